"""What people and programs read of a robot and of a result: tables in words and units, and plain numbers for JSON."""

from kinetostatics.report_dict import result_to_dict, robot_to_dict
from kinetostatics.report_result import result_report
from kinetostatics.report_robot import robot_report
from kinetostatics.report_tolerances import tolerances_report

__all__ = ["result_report", "result_to_dict", "robot_report", "robot_to_dict", "tolerances_report"]
