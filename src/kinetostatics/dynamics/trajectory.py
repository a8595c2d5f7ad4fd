"""Trajectories: poses along a path with velocities and accelerations, and their analysis with inertia forces.

Motions through waypoints are splines of minimum jerk or have trapezoidal velocity profiles; both start and end at rest.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias, Unpack

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.analysis import analyzed
from kinetostatics.arguments import Keyword, check_mapping, finite_numbers, positive, whole_number
from kinetostatics.description.loads import Motion
from kinetostatics.exceptions import ArgumentError, near_names
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.kinematics.rates import actuator_rates
from kinetostatics.layout.mapping import ResultMapping
from kinetostatics.load_case import FurtherKeywords, load_case_of
from kinetostatics.math.arrays import Array, frozen
from kinetostatics.results.path import PathResult
from kinetostatics.robot import Robot
from kinetostatics.units import PLATFORM_KINDS

#: Speed of the platform, relative to its largest, below which it counts as at rest.
_AT_REST = 0.01
#: Speed of the actuators per speed of the platform, relative to its median, above which there is a warning.
_FAST = 5.0


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
        """Velocity (N,) of each actuator [m/s, rad/s]."""
        return ResultMapping({name: frozen(rate) for name, rate in self._rates[0].items()})

    @cached_property
    def _rates(self) -> tuple[dict[str, Array], Array]:
        return actuator_rates(self.configuration, self.motion)

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """Warnings about actuators beyond their limits of velocity, and about a pose near a singular one on the path."""
        robot, (rates, _) = self.configuration.robot, self._rates
        beyond = []
        for name, limit in robot.description.actuator_limits("velocity").items():
            most, unit = float(np.nanmax(np.abs(rates[name]), initial=0.0)), robot.mechanism.connections[name].type.unit
            if most > limit:
                beyond.append(f"{name} moves at up to {most:.5g} {unit}/s, beyond its limit of velocity of {limit:.5g} {unit}/s")
        return (*beyond, *self._singular_warnings())

    def _singular_warnings(self) -> tuple[str, ...]:
        """Return a warning if the actuators are fast because a pose is near a singular one; for motions of the platform."""
        robot, (rates, twist) = self.configuration.robot, self._rates
        speed = np.linalg.norm(twist * np.repeat([1.0, robot.length], 3), axis=1)
        moving = speed > _AT_REST * speed.max(initial=0.0)
        if not rates or not np.any(moving) or set(self.motion.velocities) <= set(rates):
            return ()
        types = [robot.mechanism.connections[name].type for name in rates]
        units = np.array([robot.length if kind.is_hinge else 1.0 for kind in types])
        fast = np.stack([*rates.values()]) * units[:, None]
        size = np.where(moving, np.linalg.norm(fast, axis=0), 0.0)
        times = size / np.where(moving, speed, 1.0)
        times /= np.median(times[moving])
        k = int(np.argmax(np.where(times > _FAST, size, 0.0)))
        if not times[k] > _FAST:
            return ()
        number = int(np.argmax(np.abs(fast[:, k])))
        name, rate, unit = [*rates][number], abs(fast[number, k] / units[number]), types[number].unit
        return (
            f"{name} moves at {rate:.3g} {unit}/s at {self.times[k]:.4g} s, since the pose is near a singular one: for the "
            f"speed of the platform, the actuators are {times[k]:.2g} times as fast as usual on this path",
        )

    def analyze(
        self, load: ArrayLike = (0, 0, 0, 0, 0, 0), gravity: ArrayLike = (0, 0, -9.81), **analysis: Unpack[FurtherKeywords]
    ) -> PathResult:
        """Compute sag, stresses and forces over the path, with the inertia of links, beams and payload.

        Args:
            load: (6,) or (N, 6) external wrench on the platform: force [N], moment [N·m].
            gravity: (3,) or (N, 3) gravity [m/s²], world axes.
            analysis: further arguments of :func:`kinetostatics.analyze`: ``payload``, ``loads``, ….

        Raises:
            ArgumentError: an argument has an invalid value or shape.
        """
        case = load_case_of(self.analyze, FurtherKeywords, analysis, load=load, gravity=gravity, motion=self.motion)
        found = analyzed(self.configuration, case, analysis.get("on_failure"))
        if found.shape != self.times.shape:
            raise ArgumentError(
                f"a path needs one load, or one for each of its {len(self.times)} poses; these have the shape {found.shape}"
            )
        return PathResult(self.times, self.actuator_velocities, found, self.warnings)


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
    """Return a motion through waypoints, at rest at the first and at the last waypoint.

    With ``times``, the coordinates are minimum-jerk quintic splines through the waypoints, with zero acceleration at both ends.
    With ``speed`` and ``acceleration``, the coordinates vary linearly with one another between waypoints, with trapezoidal
    velocity profiles in minimum time, and stop at each waypoint.

    Args:
        robot: the robot.
        times: (n,) times of the waypoints [s], increasing.
        platform: coordinates of the platform at the waypoints, (n,) or constant, see :meth:`Robot.assemble`.
        actuators: coordinates of the actuators at the waypoints, instead of ``platform``.
        speed: largest speed of each coordinate [m/s, rad/s], a number or by name.
        acceleration: largest acceleration of each coordinate [m/s², rad/s²], a number or by name.
        samples: least number of poses. Every waypoint is a pose; the times between two waypoints are divided equally.
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
        _check_turns(robot, names, points, instants)
        at = _divided(instants, samples)
        profile = minimum_jerk(instants, points, at)
    else:
        if speed is None or acceleration is None:
            raise ArgumentError("give times= of the waypoints, or speed= and acceleration=")
        if np.any(np.all(np.diff(points, axis=1) == 0, axis=0)):
            raise ArgumentError("two waypoints in succession are the same")
        limits = _limits("speed", speed, names, points), _limits("acceleration", acceleration, names, points)
        at = _divided(trapezoid_times(points, *limits)[0], samples)
        profile = trapezoids(points, *limits, at)
    values, *rates = (dict(zip(names, array, strict=True)) for array in profile)
    where: dict[str, Keyword] = {"platform" if actuators is None else "actuators": values}
    how: dict[str, Keyword] = {"orientation": orientation, "near": near, "closure_tolerance": closure_tolerance}
    pose = robot.assemble(**where, **how, on_failure="raise")
    return Trajectory(frozen(at), pose, Motion(*rates))


def _waypoints(what: str, given: Mapping[str, ArrayLike]) -> tuple[list[str], Array]:
    """Return the names of c coordinates, and their values (c, n) at n waypoints."""
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


def _check_turns(robot: Robot, names: list[str], points: Array, times: Array) -> None:
    """Raise an error if an angle changes by more than π between two waypoints, as where it is given in −π to π."""
    for name, row in zip(names, points, strict=True):
        connection = robot.mechanism.connections.get(name)
        is_angle = PLATFORM_KINDS.get(name) == "angle" if connection is None else connection.type.is_hinge
        jumps = np.abs(np.diff(row)) > np.pi * (1 + 1e-9)
        if is_angle and np.any(jumps):
            k = int(np.argmax(jumps))
            before, after = np.degrees(row[k : k + 2])
            raise ArgumentError(
                f"{name} turns from {before:.6g}° to {after:.6g}° between the waypoints {k + 1} and {k + 2}, at {times[k]:.6g} "
                f"and {times[k + 1]:.6g} s: if it turns the short way, write {after - 360 * round((after - before) / 360):.6g}° "
                "(numpy.unwrap does so for all waypoints); if it turns so far, add waypoints between these"
            )


def _divided(times: Array, samples: int) -> Array:
    """Return instants that contain ``times`` (n,) and divide each interval equally; in all ``samples`` or more."""
    parts = np.maximum(np.ceil(np.diff(times) / np.ptp(times) * (samples - 1) - 1e-9), 1)
    return np.interp(np.arange(parts.sum() + 1), np.concatenate([[0.0], np.cumsum(parts)]), times)


def _limits(what: str, given: float | Mapping[str, float], names: list[str], points: Array) -> Array:
    """Return the limit (c,) of each coordinate; the limit of a constant coordinate may be missing."""
    if not isinstance(given, Mapping):
        return np.full(len(names), positive(what, given))
    for name in given:
        if name not in names:
            raise ArgumentError(f"{what} has no coordinate {name!r}: {near_names(name, names)}")
    moving = [name for name, row in zip(names, points, strict=True) if np.ptp(row) > 0]
    if missing := [name for name in moving if name not in given]:
        raise ArgumentError(f"{what} of {missing[0]} is missing")
    return np.array([positive(f"{what} of {name}", given.get(name, 1.0)) for name in names])


# ---- motions through waypoints -----------------------------------------------------------------------------------------

#: Values, velocities and accelerations (c, N) of c coordinates.
Profile: TypeAlias = tuple[Array, Array, Array]


def _powers(tau: Array, order: int) -> Array:
    """Return the derivatives (6, N) of 1, τ, …, τ⁵ with respect to τ, of the given order."""
    return np.array([math.perm(j, order) * tau ** max(j - order, 0) for j in range(6)])


_ROOTS, _WEIGHTS = np.polynomial.legendre.leggauss(3)  # from −1 to 1
#: Coefficients (6, 6) of the quintic with given values and first two derivatives at τ = 0 and 1.
_QUINTIC = np.linalg.inv([_powers(np.array(end), order) for end in (0.0, 1.0) for order in range(3)])
#: (6, 6) ∫ of the squared third derivative of a quintic from τ = 0 to 1, by the values and first two derivatives at both ends.
_JERKS = _powers((_ROOTS + 1) / 2, 3).T @ _QUINTIC
_SQUARED_JERK = _JERKS.T @ (_JERKS * _WEIGHTS[:, None] / 2)


def minimum_jerk(times: Array, points: Array, at: Array) -> Profile:
    """Return the motion through ``points`` (c, n) at ``times`` (n,) [s], with zero velocity and acceleration at the ends.

    The motion is the quintic spline with continuous fourth derivatives. It minimizes the integral of the squared jerk (T. Flash
    and N. Hogan, The coordination of arm movements, Journal of Neuroscience 5, 1985, for two and three points). ``at`` (N,) [s]
    are the times of the returned values.
    """
    steps, n = np.diff(times), len(times)
    unit = steps.mean()  # of time, for the states: value, velocity and acceleration at a point
    sizes = np.tile(np.stack([np.ones(n - 1), steps / unit, (steps / unit) ** 2], axis=1), 2)
    parts = sizes[:, :, None] * _SQUARED_JERK * sizes[:, None] * ((unit / steps) ** 5)[:, None, None]
    own = parts[:-1, 3:, 3:] + parts[1:, :3, :3]  # (n − 2, 3, 3), of inner points
    states = np.zeros((n, 3, len(points)))
    states[:, 0] = points.T
    right = own @ states[1:-1] + parts[:-1, 3:, :3] @ states[:-2] + parts[1:, :3, 3:] @ states[2:]
    states[1:-1, 1:] = -_solve_in_order(own[:, 1:, 1:], parts[1:-1, 1:3, 4:], right[:, 1:])
    part = _part(times, at)
    ends = np.concatenate([states[part], states[part + 1]], axis=1).transpose(1, 0, 2) * sizes[part].T[..., None]
    tau, step = (at - times[part]) / steps[part], steps[part]
    value, velocity, acceleration = (
        np.einsum("pN,pk,kNc->cN", _powers(tau, order), _QUINTIC, ends) / step**order for order in range(3)
    )
    return value, velocity, acceleration


def _solve_in_order(diagonal: Array, above: Array, right: Array) -> Array:
    """Solve a symmetric positive definite system with right-hand sides (n, m, c) in linear time.

    ``diagonal`` (n, m, m) and ``above`` (n − 1, m, m) are the blocks of the matrix on and above its diagonal.
    """
    m = right.shape[1]
    found = np.concatenate([np.concatenate([above, np.zeros((1, m, m))])[: len(right)], right], axis=2)
    for k, pivot in enumerate(diagonal):
        if k:
            pivot = pivot - above[k - 1].T @ found[k - 1, :, :m]
            found[k, :, m:] -= above[k - 1].T @ found[k - 1, :, m:]
        found[k] = np.linalg.solve(pivot, found[k])
    for k in range(len(above) - 1, -1, -1):
        found[k, :, m:] -= found[k, :, :m] @ found[k + 1, :, m:]
    return found[:, :, m:]


def trapezoid_times(points: Array, speed: Array, acceleration: Array) -> tuple[Array, Array, Array]:
    """Return times of the points, and velocities and accelerations for motions along straight lines of the coordinates.

    Velocities and accelerations are time derivatives of the travelled fraction of a line, 0 to 1. All coordinates reach a point
    at the same time, and at least one of them reaches a limit.

    Args:
        points: (c, n) points at which the motion stops; successive points differ.
        speed, acceleration: (c,) limits of velocity and acceleration of each coordinate.

    Returns:
        The times (n,) [s] of the points, and on each line the largest velocity (n − 1,) [1/s] and acceleration (n − 1,) [1/s²].
    """
    travel = np.abs(np.diff(points, axis=1))
    with np.errstate(divide="ignore"):
        fastest = np.min(speed[:, None] / travel, axis=0)
        steepest = np.min(acceleration[:, None] / travel, axis=0)
    fastest = np.minimum(fastest, np.sqrt(steepest))  # a triangle, where the speed is not reached
    return np.concatenate([[0.0], np.cumsum(1 / fastest + fastest / steepest)]), fastest, steepest


def trapezoids(points: Array, speed: Array, acceleration: Array, at: Array) -> Profile:
    """Return the motion along straight lines with trapezoidal velocity profiles; see :func:`trapezoid_times`."""
    times, fastest, steepest = trapezoid_times(points, speed, acceleration)
    part = _part(times, at)
    rate, rise, since, left = fastest[part], steepest[part], at - times[part], times[part + 1] - at
    ramp = rate / rise
    where = [since < ramp, left <= ramp]
    s = np.select(where, [rise * since**2 / 2, 1 - rise * left**2 / 2], rate * (since - ramp / 2))
    v, a = np.select(where, [rise * since, rise * left], rate), np.select(where, [rise, -rise], 0.0)
    start, travel = points[:, part], np.diff(points, axis=1)[:, part]
    return start + travel * s, travel * v, travel * a


def _part(times: Array, at: Array) -> Array:
    """Return the index of the interval of ``times`` (n,) that contains each instant of ``at`` (N,)."""
    return np.clip(np.searchsorted(times, at, side="right") - 1, 0, len(times) - 2)
