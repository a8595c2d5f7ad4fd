"""From measured deflections to stiffnesses, payload and offsets, and which measurements tell most."""

from kinetostatics.calibration.calibrate import calibrate
from kinetostatics.calibration.plan import plan_measurements

__all__ = ["calibrate", "plan_measurements"]
