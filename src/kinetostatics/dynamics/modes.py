"""Natural frequencies and modes of poses, small vibrations about them."""

from __future__ import annotations

import operator
from collections.abc import Mapping

import numpy as np

from kinetostatics.arguments import check
from kinetostatics.description.loads import Payload
from kinetostatics.exceptions import ArgumentError
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.math.arrays import Array, Index
from kinetostatics.math.threads import in_threads
from kinetostatics.mechanism.elastic_joints import Drive
from kinetostatics.results.modes import Modes
from kinetostatics.robot import Robot, robot_of
from kinetostatics.statics.link_loads import PAYLOAD, LinkLoads, parse_link_loads
from kinetostatics.statics.small_motions import PlacedMotions, SmallMotions
from kinetostatics.vibration.mode_shapes import ModeShapes, mode_shapes
from kinetostatics.vibration.vibration_model import Part, mass_at

#: Poses of a chunk: threads take turns at them.
_AT_ONCE = 200


def modes(configuration: Configuration, count: int = 6, *, drives: str = "locked", payload: Payload | None = None) -> Modes:
    """Compute the lowest natural frequencies and modes of one pose or a batch of poses.

    Links vibrate by their inertia, beams as continuous Timoshenko rods with rotary inertia; elastic joints and actuators are
    springs. Nothing is discretized: the dynamic stiffness of beams is exact, and no mode is missed (the page on natural
    frequencies). What loads and weights do to the stiffness is neglected; the tension of springs is not.

    Args:
        configuration: the pose or poses.
        count: number of modes.
        drives: "locked": actuators hold their coordinates, those with a stiffness elastically; "free": brakes are open, and
            actuators put up no force.
        payload: what the robot carries, a :class:`Payload`, with its inertia.

    Returns:
        Frequencies, shapes, effective masses and shares of energy.

    Raises:
        ArgumentError: an argument has an invalid value.

    Examples:
        >>> import kinetostatics as ks
        >>> pose = ks.load_robot("3rps").assemble(platform={"z": 0.5, "rx": 0.0, "ry": 0.0})
        >>> m = ks.modes(pose, count=3)
        >>> [round(float(f), 1) for f in m.frequencies]  # [Hz]
        [131.5, 131.5, 224.5]
        >>> {name: round(float(part[2]), 2) for name, part in m.strain_energy_shares.items()}  # what to stiffen in mode 3
        {'beam rod_1': 0.33, 'beam rod_2': 0.33, 'beam rod_3': 0.33}
        >>> int(m.count_below(400.0))
        3
    """
    if not isinstance(configuration, Configuration):
        raise ArgumentError(f"modes needs a Configuration, got {configuration!r}; create one with robot.assemble(…)")
    check("drives", drives)
    try:
        number = operator.index(count)
    except TypeError:
        number = 0
    if number < 1:
        raise ArgumentError(f"count is {count!r}; it must be a whole number, 1 or more")
    robot = robot_of(configuration)
    structure = SmallMotions(robot.statics, _free_drives(robot) if drives == "free" else None)
    valid = np.array(configuration.reached)
    for beam in robot.beams.values():
        valid &= np.nan_to_num(beam.remaining_length(configuration.frames)) > 0
    poses = np.flatnonzero(valid)
    shape, loads = configuration.shape, parse_link_loads(robot.statics, None, payload)
    if loads is not None:
        try:
            loads = loads.map(lambda array: np.broadcast_to(array, shape + array.shape[-1:]).reshape(-1, array.shape[-1]).T)
        except ValueError:
            raise ArgumentError(f"the payload's arrays do not fit the poses, whose batch shape is {shape}") from None
    inertia = np.zeros((3, 3)) if payload is None or payload.inertia is None else payload.inertia.matrix

    def solved(some: Index) -> ModeShapes:
        frames = configuration.frames.take(some)
        motions = PlacedMotions(structure, frames, robot.mechanism.platform_pose(frames)[1])
        here = None if loads is None else loads.map(lambda array: array[:, some])
        return mode_shapes(motions, _carried(here, inertia, motions), number)

    parts = np.array_split(poses, -(-len(poses) // _AT_ONCE)) if len(poses) else []
    return Modes(configuration, number, drives, payload, tuple(in_threads(solved, parts)), valid)


def _free_drives(robot: Robot) -> Mapping[str, Drive]:
    """Return the actuators as drives without stiffness."""
    mimics = [(item.name, item.mimic) for item in robot.mechanism.connections.values() if item.mimic is not None]
    return {
        name: Drive(name, np.inf, ((name, 1.0), *((other, mimic.multiplier) for other, mimic in mimics if mimic.joint == name)))
        for name in robot.description.driven
    }


def _carried(loads: LinkLoads | None, inertia: Array, motions: PlacedMotions) -> dict[str, Part]:
    """Return the payload on each place where it is at any pose; ``inertia`` (3, 3) is about its centre, axes of its link."""
    found = {}
    for number, (place, point, mass, R) in enumerate(loads.masses(motions.frames) if loads is not None else ()):
        axes, there = R.transpose(2, 0, 1), mass > 0
        matrix = np.zeros((len(mass), 6, 6))
        matrix[:, :3, :3] = mass[:, None, None] * np.eye(3)
        matrix[:, 3:, 3:] = axes @ inertia @ np.swapaxes(axes, 1, 2) * there[:, None, None]
        name = PAYLOAD if not number else f"{PAYLOAD} on {place}"
        found[name] = mass_at(motions, motions.structure.body_at[place], point, matrix)
    return found
