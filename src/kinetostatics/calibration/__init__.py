"""Calibration of stiffnesses, payload and offsets from measured deflections, and D-optimal plans of measurements."""

from kinetostatics.calibration.calibrate import calibrate
from kinetostatics.calibration.measurement_plan import plan_measurements

__all__ = ["calibrate", "plan_measurements"]
