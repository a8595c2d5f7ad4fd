"""Compensation of gravity and loads: actuator positions at which the loaded platform is at its target."""

from kinetostatics.compensation.compensate import compensate

__all__ = ["compensate"]
