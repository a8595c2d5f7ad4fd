"""Robots as functions of their parameters: arguments of the file, and numbers of the parts."""
