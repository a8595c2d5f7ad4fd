"""Poses of a map in another assembly mode: found, followed and mended."""
