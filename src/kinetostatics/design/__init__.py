"""What parameters of a robot's file do: sensitivities, and sizes that are best."""

from kinetostatics.design.optimize import optimize
from kinetostatics.design.sensitivities import sensitivities

__all__ = ["optimize", "sensitivities"]
