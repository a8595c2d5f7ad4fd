"""Poses: loops closed, paths followed, freedoms counted."""
