"""Compensation of gravity and loads: where to command a robot so that it stands, loaded, where it was asked to."""

from kinetostatics.compensation.compensate import compensate

__all__ = ["compensate"]
