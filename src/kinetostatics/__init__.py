"""Sag, stiffness and actuator forces of parallel manipulators, straight from a URDF.

See ``README.md`` for an example; the method is that of Yang, Huang, Ye and Chen, Gravity-based kinetostatic modeling of
parallel manipulators using screw theory, Chinese Journal of Mechanical Engineering 36 (2023).
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

from kinetostatics.printing.dispatch import LATE_MODULES

if TYPE_CHECKING:
    from kinetostatics import description, indices, sections
    from kinetostatics import plots as plot
    from kinetostatics.analysis import analyze
    from kinetostatics.authoring.extension import extend_robot, extension_text
    from kinetostatics.authoring.robot_by_name import new_robot, robot_text
    from kinetostatics.calibration import calibrate, plan_measurements
    from kinetostatics.compensation import compensate
    from kinetostatics.description.gauges import Gauge
    from kinetostatics.description.loads import LinkLoad, Payload
    from kinetostatics.design import optimize, pareto, sensitivities, spread
    from kinetostatics.engine.report import EngineReport, engine_report
    from kinetostatics.error_ranking import tolerances
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
    from kinetostatics.files.importers import MissingFactsError, import_robot
    from kinetostatics.files.reader import read_robot_file, validate
    from kinetostatics.files.writer import save_robot
    from kinetostatics.functions.c_export import CExport
    from kinetostatics.functions.function import Function, Jacobian, compile
    from kinetostatics.functions.values import Quantity, Values
    from kinetostatics.kinematics.configuration import Configuration
    from kinetostatics.report_page import save_report
    from kinetostatics.results.beam import BeamResult
    from kinetostatics.results.calibration import Calibration, Estimate, MeasurementPlan, Outlier, Unidentifiable
    from kinetostatics.results.compensation import Compensation
    from kinetostatics.results.limb import LimbResult
    from kinetostatics.results.optimum import CheckedRequirement, Optimum
    from kinetostatics.results.pareto import ParetoFront
    from kinetostatics.results.payload import PayloadCoefficients
    from kinetostatics.results.result import Result
    from kinetostatics.results.sensitivities import Sensitivities, Sensitivity
    from kinetostatics.results.spread import Spread, SpreadQuantities, Toleranced
    from kinetostatics.results.tolerances import Tolerance, Tolerances
    from kinetostatics.results.tool_point import PointResult
    from kinetostatics.robot import Robot, load_robot
    from kinetostatics.status import Status
    from kinetostatics.verification import verify
    from kinetostatics.viewer import save_html, save_image, show
    from kinetostatics.workspace import sweep

    __version__: str

__all__ = [
    "ArgumentError",
    "AssemblyError",
    "BeamResult",
    "CExport",
    "Calibration",
    "CheckedRequirement",
    "Compensation",
    "Configuration",
    "CoordinatesError",
    "EngineReport",
    "Estimate",
    "Function",
    "Gauge",
    "Jacobian",
    "KinetostaticsError",
    "LimbEquilibriumError",
    "LimbResult",
    "LinkLoad",
    "MeasurementPlan",
    "MissingFactsError",
    "Optimum",
    "Outlier",
    "ParetoFront",
    "Payload",
    "PayloadCoefficients",
    "PointResult",
    "Quantity",
    "Result",
    "Robot",
    "RobotFileError",
    "Sensitivities",
    "Sensitivity",
    "SingularPoseError",
    "Spread",
    "SpreadQuantities",
    "StaticsError",
    "Status",
    "Tolerance",
    "Toleranced",
    "Tolerances",
    "Unidentifiable",
    "UnknownNameError",
    "Values",
    "analyze",
    "calibrate",
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
    "optimize",
    "pareto",
    "plan_measurements",
    "plot",
    "read_robot_file",
    "robot_text",
    "robots",
    "save_html",
    "save_image",
    "save_report",
    "save_robot",
    "sections",
    "sensitivities",
    "show",
    "spread",
    "sweep",
    "tolerances",
    "validate",
    "verify",
]

#: Where public names are, by module. They are imported when they are first used: starting up is quick.
_NAMES = {
    "analysis": ("analyze",),
    "authoring.extension": (
        "extend_robot",
        "extension_text",
    ),
    "authoring.robot_by_name": (
        "new_robot",
        "robot_text",
    ),
    "calibration": ("calibrate", "plan_measurements"),
    "compensation": ("compensate",),
    "description.gauges": ("Gauge",),
    "design": ("optimize", "pareto", "sensitivities", "spread"),
    "engine.report": (
        "EngineReport",
        "engine_report",
    ),
    "error_ranking": ("tolerances",),
    "exceptions": (
        "ArgumentError",
        "AssemblyError",
        "CoordinatesError",
        "KinetostaticsError",
        "LimbEquilibriumError",
        "RobotFileError",
        "SingularPoseError",
        "StaticsError",
        "UnknownNameError",
    ),
    "files.bundled": ("robots",),
    "files.importers": (
        "MissingFactsError",
        "import_robot",
    ),
    "files.reader": (
        "read_robot_file",
        "validate",
    ),
    "files.writer": ("save_robot",),
    "functions.c_export": ("CExport",),
    "functions.function": ("Function", "Jacobian", "compile"),
    "functions.values": ("Quantity", "Values"),
    "kinematics.configuration": ("Configuration",),
    "report_page": ("save_report",),
    "results.beam": ("BeamResult",),
    "results.calibration": (
        "Calibration",
        "Estimate",
        "MeasurementPlan",
        "Outlier",
        "Unidentifiable",
    ),
    "results.compensation": ("Compensation",),
    "results.limb": ("LimbResult",),
    "results.optimum": ("CheckedRequirement", "Optimum"),
    "results.pareto": ("ParetoFront",),
    "results.payload": ("PayloadCoefficients",),
    "results.result": ("Result",),
    "results.sensitivities": (
        "Sensitivities",
        "Sensitivity",
    ),
    "results.spread": (
        "Spread",
        "SpreadQuantities",
        "Toleranced",
    ),
    "results.tolerances": (
        "Tolerance",
        "Tolerances",
    ),
    "results.tool_point": ("PointResult",),
    "robot": (
        "Robot",
        "load_robot",
    ),
    "description.loads": ("LinkLoad", "Payload"),
    "status": ("Status",),
    "verification": ("verify",),
    "viewer": (
        "save_html",
        "save_image",
        "show",
    ),
    "workspace": ("sweep",),
}
_MODULES = {"description": "description", "indices": "indices", "plot": "plots", "sections": "sections"}
_MODULE_OF = {name: module for module, names in _NAMES.items() for name in names}


LATE_MODULES.extend(("kinetostatics.results.warnings", "kinetostatics.checks.collect", "kinetostatics.reports"))


def __dir__() -> list[str]:
    return [*__all__, "__version__"]


def __getattr__(name: str) -> object:
    """Import what a public name stands for, when it is used."""
    if name == "__version__":
        return _version()
    if name in _MODULES:
        return importlib.import_module(f"kinetostatics.{_MODULES[name]}")
    if name in _MODULE_OF:
        return getattr(importlib.import_module(f"kinetostatics.{_MODULE_OF[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def _version() -> str:
    """Return the version that is installed; it is that of the tag (see ``pyproject.toml``)."""
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("kinetostatics")
    except PackageNotFoundError:  # a folder of source that is on the path without being installed
        return "0+unknown"
