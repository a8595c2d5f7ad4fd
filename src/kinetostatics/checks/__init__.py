"""What is known of a robot before any load: the facts behind ``kinetostatics check``."""
