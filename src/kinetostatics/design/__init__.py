"""Design of robots: sensitivities, tolerances and optimization of the parameters of a robot file."""

from kinetostatics.design.optimize import optimize
from kinetostatics.design.pareto import pareto
from kinetostatics.design.sensitivities import sensitivities
from kinetostatics.design.tolerances import tolerances

__all__ = ["optimize", "pareto", "sensitivities", "tolerances"]
