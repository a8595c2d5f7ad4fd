from .buckling import Buckling, SecondOrder
from .calibration import Calibration, Estimate, MeasurementPlan, Outlier, Unidentifiable
from .capacity import Capacity
from .compensation import Compensation
from .contributions import PayloadCoefficients
from .dynamics import FrequencyResponse, Modes
from .margins import Margins
from .optimum import CheckedRequirement, Optimum, ParetoFront
from .parts import BeamResult, LimbResult
from .path import PathResult
from .result import Result
from .sensitivities import Sensitivities, Sensitivity
from .state_space import StateSpace
from .tolerances import Effect, PoseQuantities, Tolerance, Tolerances

__all__ = [
    "BeamResult",
    "Buckling",
    "Calibration",
    "Capacity",
    "CheckedRequirement",
    "Compensation",
    "Effect",
    "Estimate",
    "FrequencyResponse",
    "LimbResult",
    "Margins",
    "MeasurementPlan",
    "Modes",
    "Optimum",
    "Outlier",
    "ParetoFront",
    "PathResult",
    "PayloadCoefficients",
    "PoseQuantities",
    "Result",
    "SecondOrder",
    "Sensitivities",
    "Sensitivity",
    "StateSpace",
    "Tolerance",
    "Tolerances",
    "Unidentifiable",
]
