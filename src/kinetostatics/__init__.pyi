from . import description, exceptions, files, functions, indices, plot, results, sections
from .analysis import analyze
from .authoring.by_name import new_robot
from .authoring.from_urdf import extend_robot
from .calibration import calibrate, plan_measurements
from .capacity import capacity
from .compensation import compensate
from .condensation import condense
from .description.loads import Gauge, LinkLoad, Motion, Payload
from .design import optimize, pareto, sensitivities, tolerances
from .dynamics.trajectory import trajectory
from .dynamics.vibrations import frequency_response, modes
from .exceptions import ArgumentError, AssemblyError, KinetostaticsError, RobotFileError, StaticsError
from .files.bundled import robots
from .files.writer import save_robot
from .functions.compiling import compile
from .kinematics.configuration import Configuration
from .report_page import save_report
from .results.result import Result
from .robot import Robot, load_robot
from .status import Status
from .verification import verify
from .viewer import save_html, save_image, show
from .workspace import sweep

__version__: str

__all__ = [
    "ArgumentError",
    "AssemblyError",
    "Configuration",
    "Gauge",
    "KinetostaticsError",
    "LinkLoad",
    "Motion",
    "Payload",
    "Result",
    "Robot",
    "RobotFileError",
    "StaticsError",
    "Status",
    "analyze",
    "calibrate",
    "capacity",
    "compensate",
    "compile",
    "condense",
    "description",
    "exceptions",
    "extend_robot",
    "files",
    "frequency_response",
    "functions",
    "indices",
    "load_robot",
    "modes",
    "new_robot",
    "optimize",
    "pareto",
    "plan_measurements",
    "plot",
    "results",
    "robots",
    "save_html",
    "save_image",
    "save_report",
    "save_robot",
    "sections",
    "sensitivities",
    "show",
    "sweep",
    "tolerances",
    "trajectory",
    "verify",
]
