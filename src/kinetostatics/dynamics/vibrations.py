"""Small vibrations about poses: natural frequencies, modes, and the platform's response to harmonic forces and floor motion."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike
from threadpoolctl import threadpool_limits

from kinetostatics.arguments import check, finite_numbers, whole_number
from kinetostatics.description.loads import Payload
from kinetostatics.elements.rods import Numbers
from kinetostatics.exceptions import ArgumentError
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.load_case import LoadCase
from kinetostatics.math.arrays import Array, Index, Mask, in_threads
from kinetostatics.mechanism.joints import elastic_actuator
from kinetostatics.results.dynamics import FrequencyResponse, Modes
from kinetostatics.results.pose_arrays import tool_on_robot
from kinetostatics.robot import robot_of
from kinetostatics.statics.link_loads import PAYLOAD, AppliedLoad, LinkLoads
from kinetostatics.statics.loaded_poses import LoadedPoses
from kinetostatics.statics.small_motions import PlacedMotions, SmallMotions
from kinetostatics.statics.springs import geometric_stiffness
from kinetostatics.vibration.eigenpairs import eigenpairs
from kinetostatics.vibration.motions import Damping, ModeShapes, responses
from kinetostatics.vibration.vibration_model import Part, VibrationModel, mass_at, spring_part, vibration_model

#: Largest number of poses in a chunk, the unit of work of a thread.
_POSES_OF_MODES, _POSES_OF_RESPONSES = 200, 50

#: Highest frequency [Hz] of a response.
HIGHEST = 1e9
#: Share in the strain energy, in robots with springs, of the change of the forces' lever arms.
GEOMETRIC = "lever arms of forces"

Found = TypeVar("Found")


@dataclass(frozen=True)
class Vibrations:
    """Poses, actuators and payload of a robot for small vibrations.

    Attributes:
        configuration: the pose or poses.
        structure: the coordinates of small motions.
        loads: the payload, with the batch axis of its arrays last; None without payload.
        gravity: (3, N) [m/s²].
        valid: (N,) True at valid poses: reached, with positive lengths of all telescopic beams.
    """

    configuration: Configuration
    structure: SmallMotions
    loads: LinkLoads | None
    gravity: Array
    valid: Mask

    @classmethod
    def of(cls, name: str, configuration: Configuration, drives: str, payload: Payload | None, gravity: ArrayLike) -> Vibrations:
        """Check the arguments of the function ``name``.

        Raises:
            ArgumentError: an argument has an invalid value.
            RobotFileError: a link has moments of inertia that no body has.
        """
        if not isinstance(configuration, Configuration):
            raise ArgumentError(f"{name} needs a Configuration, got {configuration!r}; create one with robot.assemble(…)")
        check("drives", drives)
        robot, shape = robot_of(configuration), configuration.shape
        robot.weights.check_inertias()
        free = {name: elastic_actuator(robot.mechanism, name, np.inf) for name in robot.description.actuated}
        structure = SmallMotions(robot.statics, free if drives == "free" else None)
        valid = np.array(configuration.reached)
        for beam in robot.beams.values():
            valid &= np.nan_to_num(beam.remaining_length(configuration.frames)) > 0
        loads = LoadCase(gravity=gravity, payload=payload).at(configuration)
        if loads.shape != shape:
            raise ArgumentError(f"gravity and payload have the batch shape {loads.shape}; it must fit that of the poses, {shape}")
        return cls(configuration, structure, loads.on_links, loads.gravity, valid)

    def in_chunks(self, function: Callable[[Index], Found], most: int) -> list[Found]:
        """Call a function, in threads, with the indices of the valid poses in chunks of ``most`` poses, or of one."""
        poses = np.flatnonzero(self.valid)
        chunks = np.array_split(poses, -(-len(poses) // max(most, 1))) if len(poses) else []
        with threadpool_limits(1, "blas"):  # threads of BLAS delay small matrices
            return in_threads(function, chunks)

    def placed(self, poses: Index) -> tuple[PlacedMotions, VibrationModel]:
        """Return the coordinates of small motions, and the masses and elastic parts, at given poses."""
        frames = self.configuration.frames.take(poses)
        motions = PlacedMotions(self.structure, frames, self.configuration.robot.mechanism.platform_pose(frames)[1])
        model, gravity = vibration_model(motions), self.gravity[:, poses]
        applied: tuple[AppliedLoad, ...] = ()
        if self.loads is not None:
            loads = self.loads.map(lambda array: array[:, poses])
            applied = loads.at(frames, gravity)
            model = replace(model, masses={**model.masses, **_carried(loads, motions, model.masses)})
        if self.structure.model.rotation_groups is not None:
            robot, columns = self.structure.model, tuple(range(motions.units.shape[1]))
            given = LoadedPoses(frames, np.zeros((6, len(poses))), gravity, applied=applied)
            u, K, buckled = geometric_stiffness(robot, self.structure.rotation_groups, given, motions.at_attachment)
            springs = {**model.springs, GEOMETRIC: spring_part(columns, u, K)}
            model = replace(model, springs=springs, buckled=buckled)
        return motions, model


def _carried(loads: LinkLoads, motions: PlacedMotions, links: Mapping[str, Part]) -> dict[str, Part]:
    """Return the payload as masses, one for each place at which it is attached at some pose, by names that no link has."""
    found: dict[str, Part] = {}
    for number, (place, _, point, mass, R, inertia) in enumerate(loads.masses(motions.frames)):
        name = f"{PAYLOAD} on {place}" if number or PAYLOAD in links else PAYLOAD
        found[name] = mass_at(motions, motions.structure.body_at[place], point, mass, R, inertia)
    return found


def modes(
    configuration: Configuration,
    count: int = 6,
    *,
    drives: str = "locked",
    payload: Payload | None = None,
    gravity: ArrayLike = (0, 0, -9.81),
) -> Modes:
    """Compute the lowest natural frequencies and modes of one pose or a batch of poses.

    Links are rigid bodies with inertia, beams are continuous Timoshenko rods with rotary inertia, elastic joints and actuators
    are springs. The dynamic stiffness of beams is exact, without discretization, and no mode is missed (see the page on natural
    frequencies). For robots with springs, the tangent stiffness is the one of :func:`kinetostatics.analyze`, with the geometric
    stiffness due to springs and weights; otherwise the geometric stiffness is neglected.

    Args:
        configuration: the pose or poses.
        count: number of modes.
        drives: "locked": coordinates of actuators are fixed, or elastic with their stiffness; "free": actuators exert no force.
        payload: a :class:`Payload` with its inertia.
        gravity: (…, 3) gravity [m/s²] in world axes, for the geometric stiffness of robots with springs.

    Returns:
        Frequencies, shapes, effective masses and shares of energy.

    Raises:
        ArgumentError: an argument has an invalid value.
        RobotFileError: a link has moments of inertia that no body has.

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
    number = whole_number("count", count, 1)
    vibrations = Vibrations.of("modes", configuration, drives, payload, gravity)

    def solved(poses: Index) -> ModeShapes:
        motions, model = vibrations.placed(poses)
        return ModeShapes(eigenpairs(model, number), motions)

    shapes = tuple(vibrations.in_chunks(solved, min(_POSES_OF_MODES, 10_000 // number**2)))
    return Modes(configuration, number, drives, payload, shapes, vibrations.valid)


def frequency_response(
    configuration: Configuration,
    frequencies: ArrayLike,
    *,
    damping: float | Mapping[str, float] = 0.02,
    tool: ArrayLike | None = None,
    drives: str = "locked",
    payload: Payload | None = None,
    gravity: ArrayLike = (0, 0, -9.81),
) -> FrequencyResponse:
    """Compute the response of the platform to harmonic forces on it, and to harmonic motion of the floor.

    The equations with the dynamic stiffness of the robot, whose beams are continuous rods, are solved at each frequency, without
    truncation to a set of modes.

    Args:
        configuration: the pose or poses.
        frequencies: (F,) frequencies [Hz].
        damping: damping ratio ζ of all modes, as a loss factor 2ζ of the stiffness; or ``{"mass": α,
            "stiffness": β}`` [1/s, s], proportional damping α M + β K of motions relative to the floor.
        tool: (3,) point of the platform for forces and displacements, from o in platform axes [m]; default: o.
        drives: "locked" or "free", see :func:`kinetostatics.modes`.
        payload: a :class:`Payload` with its inertia.
        gravity: (…, 3) [m/s²], see :func:`kinetostatics.modes`.

    Returns:
        Compliance and transmissibility, complex.

    Raises:
        ArgumentError: an argument has an invalid value.
        RobotFileError: a link has moments of inertia that no body has.

    Examples:
        The first resonance of a tripod, 131.5 Hz, amplifies motions of the floor along x:

        >>> import kinetostatics as ks
        >>> pose = ks.load_robot("3rps").assemble(platform={"z": 0.5, "rx": 0.0, "ry": 0.0})
        >>> r = ks.frequency_response(pose, [1.0, 131.465, 400.0], damping=0.02)
        >>> [round(float(abs(h)), 2) for h in r.transmissibility[:, 0, 0]]
        [1.0, 31.9, 0.49]
    """
    omega = 2 * np.pi * np.ravel(finite_numbers("frequencies", frequencies))
    if not omega.size or np.any((omega <= 0) | (omega > 2 * np.pi * HIGHEST)):
        raise ArgumentError(f"frequencies is {frequencies!r}; it must be positive numbers up to {HIGHEST:g} [Hz]")
    losses = Damping.of(damping)
    vibrations = Vibrations.of("frequency_response", configuration, drives, payload, gravity)
    robot = robot_of(configuration)
    place, body = tool_on_robot(tool, robot), vibrations.structure.platform

    def solved(poses: Index) -> tuple[Numbers, Numbers]:
        motions, model = vibrations.placed(poses)
        R, o = robot.mechanism.platform_pose(motions.frames)
        point = o if place is None else o + np.einsum("ijn,j->in", R, place)
        twists, carried = (array.transpose(2, 0, 1) for array in (motions.moved(body, point), motions.carried(point)))
        return responses(model, twists, carried, omega, losses)

    rotation_groups = vibrations.in_chunks(solved, _POSES_OF_RESPONSES)
    found = np.full((2, len(vibrations.valid), len(omega), 6, 6), complex(np.nan, np.nan))
    if rotation_groups:
        found[:, vibrations.valid] = np.concatenate(rotation_groups, axis=1)
    compliance, transmissibility = found.reshape(2, *configuration.shape, len(omega), 6, 6)
    valid, frequency = vibrations.valid, omega / (2 * np.pi)
    return FrequencyResponse(configuration, frequency, compliance, transmissibility, damping, drives, payload, place, valid)
