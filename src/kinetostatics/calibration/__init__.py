"""From measured deflections to stiffnesses, payload and offsets, and which measurements tell most."""

from kinetostatics.calibration.calibrate import calibrate
from kinetostatics.calibration.measurement_plan import plan_measurements

__all__ = ["calibrate", "plan_measurements"]
