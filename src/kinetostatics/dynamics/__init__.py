"""Dynamics of a robot about a pose: natural frequencies and modes."""
