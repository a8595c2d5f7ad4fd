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
from kinetostatics.exceptions import ArgumentError, KinetostaticsError
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
    name: str,
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
        name: of what is changed, for messages.
        changed: the description in which it is larger by an amount.
        step: a small amount.
        prescribed, poses, target: where the residuals are wanted, see :meth:`Solver.system`.
        decided: the robot's statics, with the wrench bases that are taken.

    Raises:
        ArgumentError: the robot becomes another mechanism.
    """
    key = structure_of(decided).key

    def parts(amount: float) -> list[Array]:
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                found = _parts(robot, changed(amount), decided, key, prescribed, poses, target)
        except KinetostaticsError as error:
            raise ArgumentError(f"there is no derivative by {name!r}: {error}") from error
        if found is None:
            raise ArgumentError(
                f"there is no derivative by {name!r}: if it is only a little different, the robot is another mechanism, as axes "
                "that met in a point do not meet any more"
            )
        return found

    total: list[Array] | None = None
    for count, weight in CENTRAL:
        pairs = zip(parts(count * step), parts(-count * step), strict=True)
        terms = [weight / step * (after - before) for after, before in pairs]
        total = terms if total is None else [a + b for a, b in zip(total, terms, strict=True)]
    assert total is not None
    return Rates(*total)


def _parts(
    robot: Robot,
    description: RobotDescription,
    decided: RobotStatics,
    key: str,
    prescribed: PrescribedCoordinates,
    poses: SolverState,
    target: Array,
) -> list[Array] | None:
    """Return what :class:`Rates` are the rates of; None if the structure is another one."""
    varied = varied_robot(robot, description, decided)
    if varied is None:
        return None
    other, statics = varied
    structure = structure_of(statics)
    if structure.key != key:
        return None
    solver = Solver(other.equations, robot.length, robot.length)
    frames = other.equations.forward(poses.x)
    residual, _ = solver.system(prescribed, poses, target)
    loops = robot.actuator_coordinates.loops
    actuators = [solver.loop_coordinate(number, frames) for number in loops]
    actuators_of_loops = np.array(actuators).reshape(len(loops), poses.x.shape[1])
    mass = statics.weights.masses(frames).sum(axis=0)
    return [structure.values, *_known(robot, frames), residual, actuators_of_loops, np.broadcast_to(mass, poses.x.shape[1:])]


def varied_robot(robot: Robot, description: RobotDescription, decided: RobotStatics) -> tuple[Robot, RobotStatics] | None:
    """Return a robot that differs a little, and its statics with what is decided about the limbs of another.

    None if it has other coordinates or loops.
    """
    other = Robot(_with_beam_axes(robot, description))
    if (other.equations.tree.nq, other.equations.count) != (robot.equations.tree.nq, robot.equations.count):
        return None
    zero = other.frames_at(robot.model_q(robot.zero_poses))
    beams = make_beam_models(other.mechanism, other.topology.beams, zero)
    weights = Weights(other.mechanism, other.topology, beams)
    own = robot.length, robot.rank_tolerance, robot.closing_error
    return other, statics_on(decided, StaticModel(other.mechanism, other.topology, beams, weights, zero, *own))


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
