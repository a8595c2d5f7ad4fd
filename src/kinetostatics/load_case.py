"""Load cases: the loads of an analysis, checked once, and broadcast against the poses once.

Public functions have the flat keywords of :func:`kinetostatics.analyze`; most hand them on as ``**analysis``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from inspect import Parameter, signature
from typing import TypedDict, get_type_hints

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.arguments import Keyword, check, vector
from kinetostatics.description.loads import Motion, Payload
from kinetostatics.engine.programs import check_engine, compiled_loops
from kinetostatics.exceptions import ArgumentError, near_names
from kinetostatics.kinematics.assembly import SolverChoice
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.kinematics.coordinates import PrescribedCoordinates
from kinetostatics.kinematics.rates import moving_bodies, prescribed_motion
from kinetostatics.math.arrays import Array, Index
from kinetostatics.math.screws import move_wrench, rotate
from kinetostatics.mechanism.tree import Frames
from kinetostatics.robot import Robot, robot_of
from kinetostatics.statics.assembly_errors import AssemblyErrors, parse_assembly_errors
from kinetostatics.statics.inertia import inertial_load
from kinetostatics.statics.link_loads import LinkLoads, parse_link_loads
from kinetostatics.statics.loaded_poses import LoadedPoses


class _Common(TypedDict, total=False):
    assembly_errors: Mapping[str, object] | None
    """errors of joints and beams in the unloaded robot"""
    loads: Mapping[str, object] | None
    """loads on links"""
    engine: str
    """"auto", "numpy" or "compiled\""""


class FurtherLoads(_Common, total=False):
    """Keywords of :func:`kinetostatics.analyze` besides load and gravity."""

    point: ArrayLike | None
    """(…, 3) point of application of the force [m]"""
    frame: str
    """axes of load and point: "world" or "platform\""""
    payload: Payload | None
    """payload on the platform or a link"""


class FurtherKeywords(FurtherLoads, total=False):
    """Keywords of :func:`kinetostatics.analyze` besides load and gravity, with what happens at poses without equilibrium."""

    on_failure: str | None
    """"raise" or "nan\""""


class CalibrationLoads(_Common, total=False):
    """Keywords of :func:`kinetostatics.analyze` besides load, point, frame and payload."""

    gravity: ArrayLike
    """(3,) gravity [m/s²], world axes"""


class LoadKeywords(FurtherLoads, total=False):
    """Keywords of :func:`kinetostatics.analyze`."""

    load: ArrayLike
    """(…, 6) external wrench on the platform: force [N], moment [N·m]"""
    gravity: ArrayLike
    """(…, 3) gravity [m/s²], world axes"""


class AnalysisKeywords(LoadKeywords, FurtherKeywords, total=False):
    """Keywords of :func:`kinetostatics.analyze`, with what happens at poses without equilibrium."""


@dataclass(frozen=True, eq=False)
class LoadCase:
    """Loads of an analysis, and by which engine it is made.

    Attributes:
        load, gravity, point: arrays (…, 6), (…, 3) and (…, 3) or None; these and all others: see :func:`kinetostatics.analyze`.
    """

    load: ArrayLike = (0, 0, 0, 0, 0, 0)
    gravity: ArrayLike = (0, 0, -9.81)
    point: ArrayLike | None = None
    frame: str = "world"
    assembly_errors: Mapping[str, object] | None = None
    loads: Mapping[str, object] | None = None
    payload: Payload | None = None
    motion: Motion | None = None
    engine: str = "auto"
    #: The same arrays.
    arrays: tuple[Array, Array, Array | None] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        check("frame", self.frame)
        object.__setattr__(self, "engine", check_engine(self.engine))
        point = None if self.point is None else vector("point", self.point, 3)
        object.__setattr__(self, "arrays", (vector("load", self.load, 6), vector("gravity", self.gravity, 3), point))
        if self.motion is not None and not isinstance(self.motion, Motion):
            raise ArgumentError(f"motion= needs a Motion, such as ks.Motion({{'z': 0.5}}, {{'z': -9.0}}), got {self.motion!r}")

    @property
    def loops(self) -> SolverChoice:
        """The choice of the solver of the loops by the engine."""
        return compiled_loops(self.engine)

    @property
    def is_plain(self) -> bool:
        """Whether it has load and gravity only, in world axes and at o."""
        others = self.point, self.assembly_errors, self.loads, self.payload, self.motion
        return self.frame == "world" and all(value is None for value in others)

    def at(self, configuration: Configuration) -> BroadcastLoads:
        """Check the names in the load case by the robot, and broadcast the loads against the poses.

        Raises:
            ArgumentError: a name is unknown, or shapes do not fit.
            RobotFileError: with a motion, a link has moments of inertia that no body has.
        """
        robot, (wrench, gravity, point) = robot_of(configuration), self.arrays
        errors = None if self.assembly_errors is None else parse_assembly_errors(robot.statics, self.assembly_errors)
        on_links = parse_link_loads(robot.statics, self.loads, self.payload)
        arrays = [wrench, gravity] + ([] if point is None else [point]) + ([] if errors is None else errors.arrays())
        arrays += [] if on_links is None else on_links.arrays()
        prescribed, rates = None, list[Array]()
        if self.motion is not None:
            robot.weights.check_inertias()
            prescribed, *rates = prescribed_motion(configuration, self.motion)
            arrays += [rates[0][0][..., None]]
        try:
            shapes = {configuration.shape, *(array.shape[:-1] for array in arrays)}
            shape = np.broadcast_shapes(*shapes) if len(shapes) > 1 else configuration.shape
        except ValueError:
            others = [] if on_links is None else dict.fromkeys(array.shape[:-1] for array in on_links.arrays())
            raise ArgumentError(
                f"the batch shapes do not fit together: configuration {configuration.shape}, load {wrench.shape[:-1]}, "
                f"gravity {gravity.shape[:-1]}"
                + (f", loads on links and payload {', '.join(map(str, others))}" if others else "")
            ) from None
        count = math.prod(shape)

        def flat(array: Array) -> Array:
            every = array if array.shape[:-1] == shape else np.broadcast_to(array, shape + array.shape[-1:])
            return every.reshape(count, array.shape[-1]).T

        which: slice | Index = slice(None)
        if shape != configuration.shape:
            numbers = np.arange(math.prod(configuration.shape)).reshape(configuration.shape)
            which = np.broadcast_to(numbers, shape).ravel()
        return BroadcastLoads(
            configuration,
            shape,
            which,
            self.frame,
            flat(wrench),
            flat(gravity),
            None if point is None else flat(point),
            None if errors is None else errors.map(flat),
            None if on_links is None else on_links.map(flat),
            prescribed,
            tuple(np.array([np.broadcast_to(row, shape).ravel() for row in rate]) for rate in rates),
        )


@dataclass(frozen=True)
class BroadcastLoads:
    """A load case at N poses: all pairs of loads and poses, with the batch axis last.

    Attributes:
        configuration: the poses before they were broadcast.
        shape: batch shape of the pairs.
        which: for each pair, the number of its pose.
        frame: axes of ``load`` and ``point``.
        load, gravity, point: (6, N), (3, N), and (3, N) or None.
        assembly_errors, on_links: errors and loads of the pairs; None without.
        prescribed: the coordinates of a motion; None without motion.
        rates: their velocities and accelerations (n, N).
    """

    configuration: Configuration
    shape: tuple[int, ...]
    which: slice | Index
    frame: str
    load: Array
    gravity: Array
    point: Array | None
    assembly_errors: AssemblyErrors | None
    on_links: LinkLoads | None
    prescribed: PrescribedCoordinates | None
    rates: tuple[Array, ...]

    @property
    def count(self) -> int:
        """The number N of pairs."""
        return math.prod(self.shape)

    def poses(self, part: slice) -> slice | Index:
        """Return the numbers of the poses of some pairs."""
        return part if isinstance(self.which, slice) else self.which[part]

    def take(self, part: slice) -> LoadedPoses:
        """Return some pairs, with the load about o and with all loads on links: those given, payload and inertia.

        Raises:
            ArgumentError: a load acts on a beam between its ends, or the loops cannot follow the motion.
        """
        configuration, robot, poses = self.configuration, robot_of(self.configuration), self.poses(part)
        frames, gravity = configuration.frames.take(poses), self.gravity[:, part]
        load = load_at_o(robot, frames, self.load[:, part], None if self.point is None else self.point[:, part], self.frame)
        errors = None if self.assembly_errors is None else self.assembly_errors.map(lambda array: array[:, part])
        carried = None if self.on_links is None else self.on_links.map(lambda array: array[:, part])
        applied = () if carried is None else carried.at(frames, gravity)
        if self.prescribed is not None:
            here = configuration.poses.take(np.arange(math.prod(configuration.shape))[poses])
            bodies = moving_bodies(robot.solver, self.prescribed, here, *(rate[:, part] for rate in self.rates))
            if np.any(configuration.reached[poses] & ~np.isfinite(np.sum(bodies[0] + bodies[1], axis=(0, 1)))):
                raise ArgumentError(
                    "the loops cannot follow the motion: the pose is singular, or the rates of redundant actuators contradict "
                    "one another"
                )
            applied += (inertial_load(robot.statics, frames, *bodies, carried),)
        return LoadedPoses(frames, load, gravity, errors, applied)


def load_at_o(robot: Robot, frames: Frames, load: Array, point: Array | None, frame: str) -> Array:
    """(6, N) load about o, world axes; ``load`` (6, N) and ``point`` (3, N) are given in ``frame``, see `analyze`."""
    if frame == "world" and point is None:
        return load
    R, o = robot.mechanism.platform_pose(frames)
    if frame == "platform":
        load = rotate(R, load)
        if point is not None:
            point = o + np.einsum("ijn,jn->in", R, point)
    return load if point is None else move_wrench(load, o - point)


def check_keywords(function: Callable[..., object], known: type, given: Iterable[str]) -> None:
    """Raise an ArgumentError if keywords given to a function are not among those ``known``, the keys of a TypedDict."""
    names = signature(function).parameters.values()
    own, further = [item.name for item in names if item.kind is not Parameter.VAR_KEYWORD], get_type_hints(known)
    for name in given:
        if name not in further:
            hint = near_names(name, {*own, *further})
            if hint.startswith("known"):  # too many to be listed
                hint = f"its own are {', '.join(own)}, and it has those of analyze"
            raise ArgumentError(f"{function.__name__} takes no {name!r}: {hint}")


def load_case_of(function: Callable[..., object], known: type, given: Mapping[str, object], **own: Keyword) -> LoadCase:
    """Return the load case of keywords handed on to a function, see :func:`check_keywords`, and of its ``own`` arguments."""
    check_keywords(function, known, given)
    loads: dict[str, Keyword] = {name: value for name, value in given.items() if name != "on_failure"}
    return LoadCase(**loads, **own)
