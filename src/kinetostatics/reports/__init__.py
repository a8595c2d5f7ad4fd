"""What people and programs read of a robot and of a result: tables in words and units, and plain numbers for JSON."""

from kinetostatics.reports.json import result_to_dict, robot_to_dict
from kinetostatics.reports.result import result_report
from kinetostatics.reports.robot import robot_report
from kinetostatics.reports.tolerances import tolerances_report

__all__ = ["result_report", "result_to_dict", "robot_report", "robot_to_dict", "tolerances_report"]
