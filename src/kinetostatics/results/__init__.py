"""What an analysis finds, as people read it."""
