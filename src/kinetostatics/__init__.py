"""Sag, stiffness and actuator forces of parallel manipulators, straight from a URDF.

See ``README.md`` for an example; the method is that of Yang, Huang, Ye and Chen, Gravity-based kinetostatic modeling of
parallel manipulators using screw theory, Chinese Journal of Mechanical Engineering 36 (2023).
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from kinetostatics import description, sections
from kinetostatics.analysis import analyze
from kinetostatics.compensation import compensate
from kinetostatics.exceptions import (
    ArgumentError,
    AssemblyError,
    CoordinatesError,
    KinetostaticsError,
    LimbEquilibriumError,
    RobotFileError,
    SingularPoseError,
    StaticsError,
    UnknownNameError,
)
from kinetostatics.files.bundled import robots
from kinetostatics.files.reader import read_robot_file, validate
from kinetostatics.files.writer import save_robot
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.printing.dispatch import LATE_MODULES
from kinetostatics.results.beam import BeamResult
from kinetostatics.results.compensation import Compensation
from kinetostatics.results.limb import LimbResult
from kinetostatics.results.payload import PayloadCoefficients
from kinetostatics.results.result import Result
from kinetostatics.results.sensitivities import Sensitivities, Sensitivity
from kinetostatics.results.tolerances import Tolerance, Tolerances
from kinetostatics.robot import Robot, load_robot
from kinetostatics.statics.link_loads import LinkLoad, Payload
from kinetostatics.status import Status
from kinetostatics.tolerances import tolerances

if TYPE_CHECKING:
    from kinetostatics import indices
    from kinetostatics import plots as plot
    from kinetostatics.authoring.extension import extend_robot, extension_text
    from kinetostatics.authoring.robot_by_name import new_robot, robot_text
    from kinetostatics.design import sensitivities
    from kinetostatics.engine.report import EngineReport, engine_report
    from kinetostatics.files.importers import MissingFactsError, import_robot
    from kinetostatics.functions.function import Function, Jacobian, Quantity, Values, compile
    from kinetostatics.verification import verify
    from kinetostatics.viewer import save_html, save_image, show
    from kinetostatics.workspace import sweep

    __version__: str

__all__ = [
    "ArgumentError",
    "AssemblyError",
    "BeamResult",
    "Compensation",
    "Configuration",
    "CoordinatesError",
    "EngineReport",
    "Function",
    "Jacobian",
    "KinetostaticsError",
    "LimbEquilibriumError",
    "LimbResult",
    "LinkLoad",
    "MissingFactsError",
    "Payload",
    "PayloadCoefficients",
    "Quantity",
    "Result",
    "Robot",
    "RobotFileError",
    "Sensitivities",
    "Sensitivity",
    "SingularPoseError",
    "StaticsError",
    "Status",
    "Tolerance",
    "Tolerances",
    "UnknownNameError",
    "Values",
    "analyze",
    "compensate",
    "compile",
    "description",
    "engine_report",
    "extend_robot",
    "extension_text",
    "import_robot",
    "indices",
    "load_robot",
    "new_robot",
    "plot",
    "read_robot_file",
    "robot_text",
    "robots",
    "save_html",
    "save_image",
    "save_robot",
    "sections",
    "sensitivities",
    "show",
    "sweep",
    "tolerances",
    "validate",
    "verify",
]


LATE_MODULES.extend(("kinetostatics.results.warnings", "kinetostatics.reports"))


def __dir__() -> list[str]:
    return [*__all__, "__version__"]


def __getattr__(name: str) -> Any:
    """Import what is not needed for most robots, such as the viewer and workspace maps, when it is first used."""
    if name == "__version__":
        return _version()
    if name in ("save_html", "save_image", "show"):
        from kinetostatics import viewer

        return getattr(viewer, name)
    if name in ("MissingFactsError", "import_robot"):
        from kinetostatics.files import importers as foreign_loops

        return getattr(foreign_loops, name)
    if name in ("extend_robot", "extension_text"):
        from kinetostatics.authoring import extension

        return getattr(extension, name)
    if name in ("new_robot", "robot_text"):
        from kinetostatics.authoring import robot_by_name

        return getattr(robot_by_name, name)
    if name in ("Function", "Jacobian", "Quantity", "Values", "compile"):
        from kinetostatics.functions import function

        return getattr(function, name)
    if name in ("EngineReport", "engine_report"):
        from kinetostatics.engine import report

        return getattr(report, name)
    if name == "sensitivities":
        from kinetostatics import design

        return design.sensitivities
    if name in ("indices", "plot"):
        return importlib.import_module({"indices": "kinetostatics.indices", "plot": "kinetostatics.plots"}[name])
    if name == "sweep":
        from kinetostatics import workspace

        return workspace.sweep
    if name == "verify":
        from kinetostatics import verification

        return verification.verify
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def _version() -> str:
    """Return the version that is installed; it is that of the tag (see ``pyproject.toml``)."""
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("kinetostatics")
    except PackageNotFoundError:  # a folder of source that is on the path without being installed
        return "0+unknown"
