"""Derivatives of the constants of statics and loops by a number of the description: central differences of fourth order.

Only constants computed from a description are differenced, such as products of frames and 1/EI, with relative errors of about
10⁻¹². Derivatives of poses and results by these constants are exact (:mod:`kinetostatics.functions.derivatives`).
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from kinetostatics.description.robot_description import RobotDescription
from kinetostatics.engine.pose_record import PoseModel
from kinetostatics.exceptions import ArgumentError
from kinetostatics.files.reader import known_valid
from kinetostatics.kinematics.solver import Solver
from kinetostatics.limbs.static_model import StaticModel
from kinetostatics.math.arrays import Array
from kinetostatics.mechanism.beam_model import make_beam_models
from kinetostatics.mechanism.weights import Weights
from kinetostatics.robot import Robot
from kinetostatics.statics.robot_statics import statics_on

#: Steps and weights of the central difference of fourth order; unchanged constants cancel exactly.
CENTRAL = ((1, 2 / 3), (2, -1 / 12))
OTHER_MECHANISM = "the robot would become another mechanism, because concurrent axes would no longer meet"


def rates_of(numbers: Callable[[float], Array], step: float) -> Array:
    """Return the derivatives of a robot's constants (P,) with respect to an amount, by a small step."""
    terms = [weight / step * (numbers(count * step) - numbers(-count * step)) for count, weight in CENTRAL]
    return np.sum(terms, axis=0)


def varied(robot: Robot, description: RobotDescription, own: PoseModel) -> tuple[PoseModel, Array]:
    """Return the model and the constants (P,) of a slightly changed robot.

    Ranks and bases are those decided for ``own``, the model of the original robot.

    Raises:
        KinetostaticsError: the description is invalid, or its coordinates, loops or limbs differ from those of the robot.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        other = Robot(_with_beam_axes(robot, description))
        if (other.equations.tree.nq, other.equations.count) == (robot.equations.tree.nq, robot.equations.count):
            zero = other.frames_at(robot.model_q(robot.zero_poses))
            beams = make_beam_models(other.mechanism, other.topology.beams, zero)
            weights = Weights(other.mechanism, other.topology, beams)
            sizes = robot.length, robot.rank_tolerance, robot.closing_error
            statics = statics_on(own.statics, StaticModel(other.mechanism, other.topology, beams, weights, zero, *sizes))
            solver = Solver(other.equations, robot.solver.length, robot.solver.reach, robot.solver.slack)
            found = PoseModel.of(solver, statics, own.prescribed)
            parts = found.structure(all_vary=True)
            if parts.key == own.structure(all_vary=True).key:
                return found, parts.values
    raise ArgumentError(OTHER_MECHANISM)


def _with_beam_axes(robot: Robot, description: RobotDescription) -> RobotDescription:
    """Return a description with explicit y axes of all beams, because default ones could change."""
    beams = {}
    for name, beam in description.beams.items():
        rotation = robot.mechanism.body_of[beam.link][1][:3, :3]
        y_axis = tuple((rotation.T @ robot.beams[name].axes[:, 1]).tolist())
        beams[name] = beam if beam.y_axis is not None else replace(beam, y_axis=y_axis)
    found = replace(description, beams=beams)
    return known_valid(found) if description.is_valid else found
