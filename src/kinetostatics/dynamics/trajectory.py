"""Trajectories: poses along a path with velocities and accelerations, and their analysis with inertia forces."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.analysis import analyze, check_keywords
from kinetostatics.arguments import Keyword, check_mapping, finite_numbers, positive, whole_number
from kinetostatics.description.loads import Motion
from kinetostatics.exceptions import ArgumentError, near_names
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.kinematics.rates import actuator_rates
from kinetostatics.layout.mapping import ResultMapping
from kinetostatics.math.arrays import Array, frozen
from kinetostatics.math.profiles import minimum_jerk, trapezoid_times, trapezoids
from kinetostatics.results.path import PathResult
from kinetostatics.robot import Robot


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory:
    """A motion of a robot through poses; see :func:`kinetostatics.trajectory`.

    Attributes:
        times: (N,) instants [s].
        configuration: the poses (N,).
        motion: velocities and accelerations (N,) of the coordinates.
    """

    times: Array
    configuration: Configuration
    motion: Motion

    def __repr__(self) -> str:
        return f"<Trajectory of {self.configuration.robot.name!r}: {len(self.times)} poses in {np.ptp(self.times):.4g} s>"

    @cached_property
    def actuator_velocities(self) -> Mapping[str, Array]:
        """(N,) velocity of each actuator [m/s, rad/s]."""
        rates = actuator_rates(self.configuration, self.motion)
        return ResultMapping({name: frozen(rate) for name, rate in rates.items()})

    def analyze(
        self, load: ArrayLike = (0, 0, 0, 0, 0, 0), gravity: ArrayLike = (0, 0, -9.81), **analysis: Keyword
    ) -> PathResult:
        """Compute sag, stresses and forces over the path, with the inertia of links, beams and payload.

        Args:
            load: (6,) or (N, 6) external wrench on the platform: force [N], moment [N·m].
            gravity: (3,) or (N, 3) gravity [m/s²], world axes.
            analysis: further arguments of :func:`kinetostatics.analyze`: ``payload``, ``loads``, ….

        Raises:
            ArgumentError: an argument has an invalid value or shape.
        """
        check_keywords(self.analyze, analysis)
        found = analyze(self.configuration, load, gravity, motion=self.motion, **analysis)
        if found.shape != self.times.shape:
            raise ArgumentError(
                f"a path needs one load, or one for each of its {len(self.times)} poses; these have the shape {found.shape}"
            )
        return PathResult(self.times, self.actuator_velocities, found)


def trajectory(
    robot: Robot,
    times: ArrayLike | None = None,
    *,
    platform: Mapping[str, ArrayLike] | None = None,
    actuators: Mapping[str, ArrayLike] | None = None,
    speed: float | Mapping[str, float] | None = None,
    acceleration: float | Mapping[str, float] | None = None,
    samples: int = 201,
    orientation: str | None = None,
    near: Configuration | Mapping[str, float] | None = None,
    closure_tolerance: float = 1e-10,
) -> Trajectory:
    """Return a motion through waypoints, at rest at the first and the last.

    With ``times``, the coordinates are minimum-jerk quintic splines through the waypoints, with zero acceleration at both ends.
    With ``speed`` and ``acceleration``, the coordinates follow straight lines between waypoints with trapezoidal velocity
    profiles in minimum time, and stop at each waypoint.

    Args:
        robot: the robot.
        times: (n,) times of the waypoints [s], increasing.
        platform: coordinates of the platform, (n,) or constant, see :meth:`Robot.assemble`.
        actuators: coordinates of the actuators, instead of ``platform``.
        speed: largest speed of each coordinate [m/s, rad/s], a number or by name.
        acceleration: largest acceleration of each coordinate [m/s², rad/s²], a number or by name.
        samples: number of poses, at equal intervals of time.
        orientation, near, closure_tolerance: see :meth:`Robot.assemble`.

    Raises:
        ArgumentError: an argument has an invalid value or shape.
        CoordinatesError: coordinates are unknown, missing, too many, or do not determine the pose.
        AssemblyError: a pose of the path cannot be reached.

    Examples:
        A delta robot carries 0.5 kg from one place to another:

        >>> import kinetostatics as ks
        >>> robot = ks.load_robot("delta")
        >>> way = {"x": [-0.15, 0.15], "y": 0.0, "z": -0.75}
        >>> t = ks.trajectory(robot, platform=way, speed=3.0, acceleration=60.0)
        >>> round(float(t.times[-1]), 3)  # 0.3 m / (3 m/s) + (3 m/s) / (60 m/s²) [s]
        0.15
        >>> path = t.analyze(payload=ks.Payload(0.5))
    """
    given = platform if actuators is None else actuators
    if given is None or (platform is not None and actuators is not None):
        raise ArgumentError("give the waypoints either as platform= or as actuators=")
    names, points = _waypoints("platform" if actuators is None else "actuators", given)
    samples = whole_number("samples", samples, 2)
    if times is not None:
        if speed is not None or acceleration is not None:
            raise ArgumentError("give either times= of the waypoints, or speed= and acceleration=")
        instants = finite_numbers("times", times)
        if instants.shape != points.shape[1:] or np.any(np.diff(instants) <= 0):
            raise ArgumentError(f"times is {times!r}; it must be {points.shape[1]} increasing numbers [s], one for each waypoint")
        at = np.linspace(instants[0], instants[-1], samples)
        profile = minimum_jerk(instants, points, at)
    else:
        if speed is None or acceleration is None:
            raise ArgumentError("give times= of the waypoints, or speed= and acceleration=")
        if np.any(np.all(np.diff(points, axis=1) == 0, axis=0)):
            raise ArgumentError("two waypoints in succession are the same")
        limits = _limits("speed", speed, names, points), _limits("acceleration", acceleration, names, points)
        at = np.linspace(0.0, trapezoid_times(points, *limits)[0][-1], samples)
        profile = trapezoids(points, *limits, at)
    values, *rates = (dict(zip(names, array, strict=True)) for array in profile)
    where: dict[str, Keyword] = {"platform" if actuators is None else "actuators": values}
    how: dict[str, Keyword] = {"orientation": orientation, "near": near, "closure_tolerance": closure_tolerance}
    pose = robot.assemble(**where, **how, on_failure="raise")
    return Trajectory(frozen(at), pose, Motion(*rates))


def _waypoints(what: str, given: Mapping[str, ArrayLike]) -> tuple[list[str], Array]:
    """Return names of coordinates, and their values (c, n) at the waypoints."""
    check_mapping(what, given, '{"z": [0.5, 0.6]}')
    arrays = [finite_numbers(name, value) for name, value in given.items()]
    try:
        points = np.array(np.broadcast_arrays(*arrays))
    except ValueError:
        points = np.empty(0)
    if points.ndim != 2 or points.shape[1] < 2:
        sizes = ", ".join(f"{name} {array.shape}" for name, array in zip(given, arrays, strict=True))
        raise ArgumentError(
            f"{what} has the shapes {sizes}; a path has two waypoints or more, the same number in each coordinate"
        )
    return list(given), points


def _limits(what: str, given: float | Mapping[str, float], names: list[str], points: Array) -> Array:
    """Return the limits (c,) of the coordinates; those of constant coordinates may be missing."""
    if not isinstance(given, Mapping):
        return np.full(len(names), positive(what, given))
    for name in given:
        if name not in names:
            raise ArgumentError(f"{what} has no coordinate {name!r}: {near_names(name, names)}")
    moving = [name for name, row in zip(names, points, strict=True) if np.ptp(row) > 0]
    if missing := [name for name in moving if name not in given]:
        raise ArgumentError(f"{what} of {missing[0]} is missing")
    return np.array([positive(f"{what} of {name}", given.get(name, 1.0)) for name in names])
