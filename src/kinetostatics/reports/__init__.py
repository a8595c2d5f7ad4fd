"""What people and programs read of a robot and of a result: tables in words and units, and plain numbers for JSON.

The modules register their functions with :mod:`kinetostatics.printing.dispatch` when something is printed for the first time.
"""

import kinetostatics.reports.short  # noqa: F401 - what ``repr`` and notebooks show
from kinetostatics.reports.calibration import calibration_report, plan_report
from kinetostatics.reports.compensation import compensation_report
from kinetostatics.reports.json import result_to_dict, robot_to_dict
from kinetostatics.reports.optimum import optimum_report
from kinetostatics.reports.result import result_report
from kinetostatics.reports.robot import robot_report
from kinetostatics.reports.sensitivities import sensitivities_report
from kinetostatics.reports.tolerances import tolerances_report

__all__ = [
    "calibration_report",
    "compensation_report",
    "optimum_report",
    "plan_report",
    "result_report",
    "result_to_dict",
    "robot_report",
    "robot_to_dict",
    "sensitivities_report",
    "tolerances_report",
]
