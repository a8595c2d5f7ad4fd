"""A robot as a function of its numbers: arguments of its file, and numbers of its parts."""
