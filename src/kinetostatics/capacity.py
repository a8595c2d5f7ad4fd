"""Capacity: the largest load before an actuator's effort, a yield strength, a buckling load or a given sag is reached.

Forces and motions of linear statics are affine functions of the load; their utilizations, which are norms or largest eigenvalues
of these, are convex. Under the loads f w the largest utilization therefore passes 1 once, if it is below 1 for f = 0; this
factor is found by the method of false position (M. Dowell, P. Jarratt, A modified regula falsi method, BIT 11, 1971).

The worst direction of a force of size f maximizes a convex function u ↦ g(f u) on the unit sphere. A step to u' = ∇g/|∇g| never
decreases it, because g(f u') ≥ g(f u) + f ∇g·(u' − u). For an actuator, whose force a·w + a_0 is affine, u = ±a/|a| is exact:
the dual norm. The search starts from these directions, from the eigenvectors of the compliance, and from 26 directions of a grid.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeAlias, Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinetostatics.analysis import analyzed
from kinetostatics.arguments import positive, vector
from kinetostatics.description.loads import Payload
from kinetostatics.exceptions import ArgumentError
from kinetostatics.kinematics.configuration import Configuration, taken
from kinetostatics.load_case import CalibrationLoads, LoadCase, load_case_of
from kinetostatics.math.arrays import Array, frozen
from kinetostatics.math.linalg import normalize
from kinetostatics.math.rotations import exponential
from kinetostatics.results.capacity import Capacity
from kinetostatics.results.margins import Margins
from kinetostatics.results.result import Result
from kinetostatics.robot import robot_of

#: Distance below 1 of the largest utilization, and relative length of the bracket, at which a factor counts as found.
_REACHED, _NARROW = 1e-12, 1e-14
#: Largest number of evaluations for a factor; growth of the first bracket; largest factor of a load as large as the weights.
_MOST, _GROWTH, _LARGEST = 200, 8.0, 1e9
#: Largest number of steps to a worst direction, number of directions that are followed, relative progress that counts.
_STEPS, _FOLLOWED, _PROGRESS = 60, 6, 1e-10
#: Step of differences of a utilization, relative to the force.
_DIFFERENCE = 1e-4


def capacity(
    configuration: Configuration,
    direction: ArrayLike | None = None,
    *,
    payload: Payload | None = None,
    load: ArrayLike = (0, 0, 0, 0, 0, 0),
    sag: float | None = None,
    **analysis: Unpack[CalibrationLoads],
) -> Capacity:
    """Return the largest load that a robot may carry besides its weight, and the limit that it reaches.

    The limits are the efforts of the actuators and the yield strengths of the beams, where the file states them, the buckling
    loads of the beams, and ``sag``.

    Args:
        configuration: a pose or a batch of poses.
        direction: (…, 6) wrench on the platform about o, world axes [N, N·m], of which the largest factor is returned. None: the
            largest force that may act at o in every direction; this takes seconds for each pose.
        payload: a mass with this centre, on the platform or its ``link``, instead of ``direction``: the largest mass is returned.
        load: (…, 6) constant wrench on the platform about o, world axes [N, N·m].
        sag: largest displacement of o under all loads and weights [m]; None: any.
        analysis: further arguments of :func:`kinetostatics.analyze`: ``gravity``, ``loads``, ``assembly_errors``, ``engine``.

    Raises:
        ArgumentError: an argument has an invalid value or shape.

    Examples:
        How much may a tripod with actuators of 2000 N carry, and which force from any side moves it by one micrometre at most?

        >>> import kinetostatics as ks
        >>> pose = ks.load_robot("3rps").assemble(platform={"z": 0.5, "rx": 0.0, "ry": 0.0})
        >>> mass = ks.capacity(pose, payload=ks.Payload(1.0))
        >>> f"{mass.load:.1f} {mass.unit}, {mass.limited_by}"
        '487.9 kg, effort of prismatic_1'
        >>> force = ks.capacity(pose, sag=1e-6)
        >>> f"{force.load:.1f} {force.unit}, {force.limited_by}"
        '32.6 N, sag'
    """
    if not isinstance(configuration, Configuration):
        raise ArgumentError(f"capacity needs a Configuration, got {configuration!r}; create one with robot.assemble(…)")
    if direction is not None and payload is not None:
        raise ArgumentError("give direction= or payload=, not both")
    case = load_case_of(capacity, CalibrationLoads, analysis, load=load)
    largest_sag = None if sag is None else positive("sag", sag)
    if payload is not None:
        return _of(_Mass(configuration, case, largest_sag, payload), "kg", None)
    if direction is not None:
        wrench = vector("direction", direction, 6)
        if not np.all(np.any(wrench != 0, axis=-1)):
            raise ArgumentError("direction= is zero; it must be a wrench (6,), force and moment, that is not zero")
        return _of(_Wrench(configuration, case, largest_sag, wrench), "1", wrench)
    return _in_every_direction(configuration, case, largest_sag)


@dataclass(frozen=True, eq=False)
class _Loaded:
    """Poses under a constant load case and a load with variable factors (…)."""

    configuration: Configuration
    case: LoadCase
    sag: float | None

    def case_at(self, factor: Array) -> LoadCase:
        raise NotImplementedError

    def at(self, factor: Array) -> Result:
        return analyzed(self.configuration, self.case_at(factor), "nan")

    def margins(self, result: Result) -> Margins:
        """Return the margins of a result, with the limit "sag"."""
        margins = result.margins
        if self.sag is None:
            return margins
        sag = np.asarray(np.linalg.norm(result.twist[..., :3], axis=-1) / self.sag)
        return replace(margins, stated={**margins.stated, "sag": sag})

    def stated(self, factor: Array) -> Array:
        """Return the largest utilization (…) but for buckling; −1 without limits."""
        margins = self.margins(self.at(factor))
        return np.max([np.full(margins.shape, -1.0), *margins.stated.values()], axis=0)

    def buckling(self, factor: Array, least: float = 0.0) -> Array:
        """Return the largest utilization (…) of buckling loads, 0 if it is below ``least``."""
        result = self.at(factor)
        return np.max([np.zeros(result.shape), *result.margins.buckling(least).values()], axis=0)


@dataclass(frozen=True, eq=False)
class _Wrench(_Loaded):
    direction: Array

    def case_at(self, factor: Array) -> LoadCase:
        return replace(self.case, load=self.case.arrays[0] + factor[..., None] * self.direction)


@dataclass(frozen=True, eq=False)
class _Mass(_Loaded):
    payload: Payload

    def case_at(self, factor: Array) -> LoadCase:
        return replace(self.case, payload=replace(self.payload, mass=factor))


def _of(loaded: _Loaded, unit: str, direction: Array | None) -> Capacity:
    factor, buckles = _largest_factor(loaded)
    result = loaded.at(np.where(np.isfinite(factor), factor, 0.0))
    margins = loaded.margins(result)
    if not np.any(buckles):
        margins = replace(margins, buckling=lambda least: {})
    names = np.where(np.isfinite(factor), margins.limited_by, "")
    wrench = None if direction is None else frozen(np.array(np.broadcast_to(direction, (*factor.shape, 6))))
    return Capacity(loaded.configuration, frozen(factor), unit, names if names.shape else names[()], wrench, result)


def _largest_factor(loaded: _Loaded) -> tuple[Array, NDArray[np.bool_]]:
    """Return the largest factor (…) at which no limit is exceeded, NaN at poses without results; and where buckling limits it."""
    nothing = loaded.at(np.zeros(()))
    shape = nothing.shape
    none, first, factor = np.zeros(shape), np.full(shape, _weight(loaded.configuration)), np.full(shape, np.inf)
    if loaded.margins(nothing).stated:
        factor = _crossing(loaded.stated, none, first, factor)
    known = np.where(np.isfinite(factor), factor, 0.0)
    buckles = (loaded.buckling(known, 1.0) >= 1) | np.isinf(factor)
    if np.any(buckles):
        earlier = _crossing(loaded.buckling, none, np.where(known > 0, known, first), np.where(buckles, factor, 0.0))
        factor = np.where(buckles, np.minimum(earlier, factor), factor)
    return np.where(np.isnan(nothing.twist[..., 0]), np.nan, factor), buckles


def _weight(configuration: Configuration) -> float:
    """Return the mass of the robot [kg], at least 1, as a first guess of a factor."""
    return float(np.nanmax(np.sum(robot_of(configuration).weights.masses(configuration.frames), axis=0), initial=1.0))


def _crossing(usage: Callable[[Array], Array], low: Array, high: Array, end: Array) -> Array:
    """Return the factors (…) at which convex functions pass 1: 0 if they start above it, ``end`` if they stay below it.

    Args:
        usage: the functions of the factors (…).
        low, high: the first bracket; it is enlarged up to ``end``.
        end: largest factors; infinite ones stand for :data:`_LARGEST` times ``high``.
    """
    last = np.where(np.isinf(end), _LARGEST * high, end)
    below, above = usage(low) - 1, usage(high) - 1
    started = below < 0
    while np.any(grows := started & ~(above >= 0) & (high < last)):
        low, below = np.where(grows, high, low), np.where(grows, above, below)
        high = np.where(grows, np.minimum(_GROWTH * high, last), high)
        above = np.where(grows, usage(high) - 1, above)
    inside = started & (above >= 0)
    going, side = inside.copy(), np.zeros(low.shape)
    for _ in range(_MOST):
        if not np.any(going):
            break
        slope = np.where(going, above - below, 1.0)
        guess = np.where(going, low - below * (high - low) / slope, low)
        value = usage(guess) - 1
        left = going & (value <= 0)
        right = going & ~left
        above = np.where(left & (side < 0), above / 2, np.where(right, value, above))
        below = np.where(right & (side > 0), below / 2, np.where(left, value, below))
        low, high = np.where(left, guess, low), np.where(right, guess, high)
        side = np.where(left, -1.0, np.where(right, 1.0, side))
        going &= ~((value <= 0) & (value > -_REACHED)) & (high - low > _NARROW * high)
    return np.where(inside, low, np.where(started, end, np.where(np.isnan(below), np.nan, 0.0)))


#: A function of a load and its factors (…) that returns the largest utilization (…).
Usage: TypeAlias = Callable[[_Loaded, Array], Array]

# ---- the worst direction -----------------------------------------------------------------------------------------------


def _in_every_direction(configuration: Configuration, case: LoadCase, sag: float | None) -> Capacity:
    loads = case.at(configuration)
    numbers = np.arange(len(configuration.reached))[loads.poses(slice(None))]
    worst = np.zeros((loads.count, 6))
    for k, number in enumerate(numbers):
        pose = taken(configuration, np.array([number]), ())
        alone = replace(case, load=loads.load[:, k], gravity=loads.gravity[:, k])
        if alone.at(pose).shape != ():
            raise ArgumentError("without direction=, loads= and assembly_errors= must be the same at all poses")
        if np.all(np.isfinite(analyzed(pose, alone, "nan").twist)):
            worst[k, :3] = _worst_direction(pose, alone, sag)
    directions = worst.reshape(*loads.shape, 6)
    return _of(_Wrench(configuration, case, sag, directions), "N", directions)


def _worst_direction(pose: Configuration, case: LoadCase, sag: float | None) -> Array:
    """Return the unit vector (3,) of the force with the least capacity at one pose."""

    def of(directions: Array) -> _Wrench:
        return _Wrench(pose, case, sag, np.pad(directions, [(0, 0)] * (directions.ndim - 1) + [(0, 3)]))

    def worst(usage: Usage, directions: Array, end: float) -> tuple[Array, float]:
        def factors(some: Array) -> Array:
            loaded, first = of(some), np.full(len(some), end if np.isfinite(end) else _weight(pose))
            return _crossing(partial(usage, loaded), np.zeros(len(some)), first, np.full(len(some), end))

        least = factors(directions)
        for step in range(_STEPS):
            if not np.any(np.isfinite(least)):
                break
            sizes = np.where(np.isfinite(least), least, np.min(least))
            steps = _DIFFERENCE * np.array([1.0, -1.0])[:, None, None] * np.eye(3)
            around = of(sizes[:, None, None, None] * (directions[:, None, None] + steps))
            gradients = np.subtract(*np.moveaxis(usage(around, np.ones(())), 1, 0))
            tried = normalize(np.where(np.any(gradients, axis=1, keepdims=True), gradients, directions).T).T
            reached = factors(tried)
            better = reached < (1 - _PROGRESS) * least
            directions, least = np.where(better[:, None], tried, directions), np.where(better, reached, least)
            if step == 0:  # only the best are followed further
                best = np.argsort(least, kind="stable")[:_FOLLOWED]
                directions, least = directions[best], least[best]
            elif not np.any(better):
                break
        return directions[np.argmin(least)], float(least.min())

    starts = normalize(np.concatenate([_GRID, *_exact_directions(pose, case)]).T).T
    direction, least = starts[0], np.inf
    if of(starts).margins(analyzed(pose, case, "nan")).stated:
        direction, least = worst(_Loaded.stated, starts, np.inf)
    buckles = np.full(len(starts), True) if np.isinf(least) else of(starts).buckling(np.full(len(starts), least), 1.0) >= 1
    if np.any(buckles):
        direction, least = worst(_Loaded.buckling, starts[buckles], least)
    return direction


#: The 26 directions from the centre of a cube to its faces, edges and corners. The cube is turned, because a utilization has no
#: gradient in directions in which, by symmetry, it is that of two parts.
_GRID = (
    np.array([steps for steps in itertools.product((-1.0, 0.0, 1.0), repeat=3) if any(steps)])
    @ exponential(np.array([[0.31], [0.17], [0.23]]))[:, :, 0]
)


def _exact_directions(pose: Configuration, case: LoadCase) -> list[Array]:
    """Return the directions (n, 3) in which forces load each actuator most, and the eigenvectors of the compliance."""
    unit = analyzed(pose, replace(case, load=np.eye(3, 6) + case.arrays[0]), "nan")
    before = analyzed(pose, case, "nan")
    rows = [unit.actuator_forces[name] - force for name, force in before.actuator_forces.items()]
    rows = [row for row in rows if np.any(np.abs(row) > 1e-9)]
    axes = [*rows, *np.linalg.eigh(before.compliance[:3, :3])[1].T]
    return [np.array([row, -row]) for row in axes]
