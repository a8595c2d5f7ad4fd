"""Poses: closure of loops, straight paths, mobility."""
