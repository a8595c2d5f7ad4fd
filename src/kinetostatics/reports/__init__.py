"""Functions that make the reports of robots, poses and results."""

from __future__ import annotations

from functools import singledispatch

from kinetostatics.description.robot_description import RobotDescription
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.layout.report import Report
from kinetostatics.reports.calibration import calibration_report, plan_report
from kinetostatics.reports.capacity import capacity_report
from kinetostatics.reports.compensation import compensation_report
from kinetostatics.reports.dynamics import buckling_report, frequency_response_report, modes_report, path_report
from kinetostatics.reports.optimum import optimum_report, pareto_report
from kinetostatics.reports.parts import beam_report, limb_report
from kinetostatics.reports.pose import configuration_report
from kinetostatics.reports.result import result_report
from kinetostatics.reports.robot import description_report, robot_report
from kinetostatics.reports.sensitivities import sensitivities_report
from kinetostatics.reports.tolerances import tolerances_report
from kinetostatics.reports.verification import verification_report
from kinetostatics.results.buckling import Buckling
from kinetostatics.results.calibration import Calibration, MeasurementPlan
from kinetostatics.results.capacity import Capacity
from kinetostatics.results.compensation import Compensation
from kinetostatics.results.dynamics import FrequencyResponse, Modes
from kinetostatics.results.optimum import Optimum, ParetoFront
from kinetostatics.results.parts import BeamResult, LimbResult
from kinetostatics.results.path import PathResult
from kinetostatics.results.result import Result
from kinetostatics.results.sensitivities import Sensitivities
from kinetostatics.results.tolerances import Tolerances
from kinetostatics.robot import Robot
from kinetostatics.verification.compare import Verification


@singledispatch
def report_of(subject: object) -> Report:
    """Return the report of an object, by its type."""
    raise TypeError(f"{type(subject).__name__} has no report")


for _kind, _report in (
    (Robot, robot_report),
    (RobotDescription, description_report),
    (Verification, verification_report),
    (Configuration, configuration_report),
    (Result, result_report),
    (LimbResult, limb_report),
    (BeamResult, beam_report),
    (Optimum, optimum_report),
    (ParetoFront, pareto_report),
    (Calibration, calibration_report),
    (MeasurementPlan, plan_report),
    (PathResult, path_report),
    (Sensitivities, sensitivities_report),
    (Modes, modes_report),
    (FrequencyResponse, frequency_response_report),
    (Tolerances, tolerances_report),
    (Compensation, compensation_report),
    (Capacity, capacity_report),
    (Buckling, buckling_report),
):
    report_of.register(_kind, _report)
