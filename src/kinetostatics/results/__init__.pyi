from .beam import BeamResult
from .calibration import Calibration, Estimate, MeasurementPlan, Outlier, Unidentifiable
from .compensation import Compensation
from .limb import LimbResult
from .optimum import CheckedRequirement, Optimum
from .pareto import ParetoFront
from .payload import PayloadCoefficients
from .result import Result
from .sensitivities import Sensitivities, Sensitivity
from .spread import Spread, SpreadQuantities, Toleranced
from .tolerances import Tolerance, Tolerances
from .tool_point import PointResult

__all__ = [
    "BeamResult",
    "Calibration",
    "CheckedRequirement",
    "Compensation",
    "Estimate",
    "LimbResult",
    "MeasurementPlan",
    "Optimum",
    "Outlier",
    "ParetoFront",
    "PayloadCoefficients",
    "PointResult",
    "Result",
    "Sensitivities",
    "Sensitivity",
    "Spread",
    "SpreadQuantities",
    "Tolerance",
    "Toleranced",
    "Tolerances",
    "Unidentifiable",
]
