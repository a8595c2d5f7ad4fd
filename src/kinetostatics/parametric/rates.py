"""What changes in a robot's statics and kinematics when its description changes a little: rates, by differences of fourth order.

Only the constants that follow from a description are differenced, such as products of frames and 1/EI, at no loss but for some
parts in 10¹²; what they do to a pose is differentiated exactly (:mod:`kinetostatics.functions.derivatives`).
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from kinetostatics.description.robot import RobotDescription
from kinetostatics.engine.outputs import structure_of
from kinetostatics.exceptions import ArgumentError
from kinetostatics.files.reader import known_valid
from kinetostatics.kinematics.prescribed import PrescribedCoordinates
from kinetostatics.kinematics.solver import Solver, SolverState
from kinetostatics.limbs.model import StaticModel
from kinetostatics.math.arrays import Array
from kinetostatics.mechanism.beam_model import make_beam_models
from kinetostatics.mechanism.tree import Frames
from kinetostatics.mechanism.weights import Weights
from kinetostatics.robot import Robot
from kinetostatics.statics.model import RobotStatics, statics_on

#: Steps and weights of the central difference of fourth order; what does not change at all drops out of each.
CENTRAL = ((1, 2 / 3), (2, -1 / 12))
OTHER_MECHANISM = "the robot would be another mechanism, as axes that meet in a point would not meet any more"


@dataclass(frozen=True)
class Rates:
    """How fast something changes with one number of the description.

    Attributes:
        constants: (P,) the numbers of the statics.
        rotation, position: (3, 3, B, N), (3, B, N) the frames of all bodies, with the joints as they are.
        residual: (m, N) the scaled residuals of the loops and of what is given.
        loop_actuators: (n, N) the coordinates of driven loops.
        mass: (N,) the robot's mass [kg].
    """

    constants: Array
    rotation: Array
    position: Array
    residual: Array
    loop_actuators: Array
    mass: Array


def rates_of(
    robot: Robot,
    changed: Callable[[float], RobotDescription],
    step: float,
    prescribed: PrescribedCoordinates,
    poses: SolverState,
    target: Array,
    decided: RobotStatics,
) -> Rates:
    """Return how fast a robot changes.

    Args:
        robot: the robot.
        changed: the description in which a number is larger by an amount.
        step: a small amount.
        prescribed, poses, target: where the residuals are wanted, see :meth:`Solver.system`.
        decided: the robot's statics, with the wrench bases that are taken.

    Raises:
        KinetostaticsError: there is no such robot, or it is another mechanism.
    """

    def parts(amount: float) -> list[Array]:
        """Return what :class:`Rates` are the rates of."""
        other, statics = varied_robot(robot, changed(amount), decided)
        solver = Solver(other.equations, robot.length, robot.length)
        frames = other.equations.forward(poses.x)
        residual, _ = solver.system(prescribed, poses, target)
        loops = robot.actuator_coordinates.loops
        actuators = np.array([solver.loop_coordinate(number, frames) for number in loops]).reshape(len(loops), poses.x.shape[1])
        mass = np.broadcast_to(statics.weights.masses(frames).sum(axis=0), poses.x.shape[1:])
        return [structure_of(statics).values, *_known(robot, frames), residual, actuators, mass]

    total: list[Array] = []
    for count, weight in CENTRAL:
        pairs = zip(parts(count * step), parts(-count * step), strict=True)
        terms = [weight / step * (after - before) for after, before in pairs]
        total = [a + b for a, b in zip(total, terms, strict=True)] if total else terms
    return Rates(*total)


def varied_robot(robot: Robot, description: RobotDescription, decided: RobotStatics) -> tuple[Robot, RobotStatics]:
    """Return a robot that differs a little, and its statics with what is decided about the limbs of another.

    Raises:
        KinetostaticsError: there is no such robot, or it has other coordinates, loops or limbs.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        other = Robot(_with_beam_axes(robot, description))
        if (other.equations.tree.nq, other.equations.count) == (robot.equations.tree.nq, robot.equations.count):
            zero = other.frames_at(robot.model_q(robot.zero_poses))
            beams = make_beam_models(other.mechanism, other.topology.beams, zero)
            weights = Weights(other.mechanism, other.topology, beams)
            own = robot.length, robot.rank_tolerance, robot.closing_error
            statics = statics_on(decided, StaticModel(other.mechanism, other.topology, beams, weights, zero, *own))
            if structure_of(statics).key == structure_of(decided).key:
                return other, statics
    raise ArgumentError(OTHER_MECHANISM)


def _with_beam_axes(robot: Robot, description: RobotDescription) -> RobotDescription:
    """Return a description in which every beam has the y axis that it has in the robot; one of its own could be another one."""
    beams = {}
    for name, beam in description.beams.items():
        rotation = robot.mechanism.body_of[beam.link][1][:3, :3]
        y_axis = tuple((rotation.T @ robot.beams[name].axes[:, 1]).tolist())
        beams[name] = beam if beam.y_axis is not None else replace(beam, y_axis=y_axis)
    found = replace(description, beams=beams)
    return known_valid(found) if description.is_valid else found


def _known(robot: Robot, frames: Frames) -> tuple[Array, Array]:
    """Return rotations and positions, 0 of bodies inside spherical joints, which are not among the solver's."""
    rotation, position = np.array(frames.rotation), np.array(frames.position)
    inside = bodies_inside(robot)
    rotation[:, :, inside], position[:, inside] = 0.0, 0.0
    return rotation, position


def bodies_inside(robot: Robot) -> list[int]:
    """Return the bodies between the revolutes of spherical joints."""
    return [body for run in robot.mechanism.spherical_runs for body in run.bodies[:2]]
