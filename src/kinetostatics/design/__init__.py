"""What parameters of a robot's file do: sensitivities, what their tolerances do, and sizes that are best."""

from kinetostatics.design.optimize import optimize
from kinetostatics.design.pareto import pareto
from kinetostatics.design.sensitivities import sensitivities
from kinetostatics.design.tolerances import tolerances

__all__ = ["optimize", "pareto", "sensitivities", "tolerances"]
