"""D-optimal measurements: subsets of a grid of candidates. A candidate is a combination of a pose and a load.

The determinant of the information matrix Σ JᵀJ is maximized by exchanging each measurement in turn for the best candidate,
from several starts (V. V. Fedorov, Theory of Optimal Experiments, 1972, as modified by R. D. Cook, C. J. Nachtsheim,
Technometrics 22, 1980). J has the derivatives of the readings of one measurement, divided by sigma, by the unknowns.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from typing import Unpack

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.arguments import check, finite_numbers, names_in, whole_number
from kinetostatics.calibration.calibrate import check_robot
from kinetostatics.calibration.fit import determined
from kinetostatics.calibration.measurements import read_gauges
from kinetostatics.calibration.readings import Model, Readings
from kinetostatics.calibration.unknowns import Unknowns, identifiable_ones, unidentifiable
from kinetostatics.description.loads import Gauge, Payload
from kinetostatics.design.problem import grid_of
from kinetostatics.exceptions import ArgumentError, near_names
from kinetostatics.layout.mapping import ResultMapping
from kinetostatics.load_case import CalibrationLoads, load_case_of
from kinetostatics.math.arrays import Array, Index, frozen
from kinetostatics.results.calibration import MeasurementPlan
from kinetostatics.robot import Robot

#: Number of random starts of the exchange besides the greedy one, and of random plans for comparison.
STARTS, RANDOM = 5, 200
#: Largest number of candidates, and default sigma of gauges [m, rad].
MOST, SIGMA = 20_000, 1e-6
#: Eigenvalues of the information matrix, relative to the largest, that count as rounding.
ROUNDING = 1e-12
#: Smallest increase of the logarithm of the determinant by an exchange.
GAIN = 1e-9


def plan_measurements(
    robot: Robot,
    unknowns: Sequence[str],
    n: int,
    platform: Mapping[str, ArrayLike] | None = None,
    actuators: Mapping[str, ArrayLike] | None = None,
    *,
    load: ArrayLike = (0, 0, 0, 0, 0, 0),
    readings: Sequence[str] = ("dx", "dy", "dz"),
    gauges: str | os.PathLike[str] | Mapping[str, Gauge] | None = None,
    reference: str | Mapping[str, float] = "undeformed",
    orientation: str | None = None,
    payload: Payload | None = None,
    point: ArrayLike | None = None,
    frame: str = "world",
    seed: int = 0,
    closure_tolerance: float = 1e-10,
    **analysis: Unpack[CalibrationLoads],
) -> MeasurementPlan:
    """Choose the poses and loads of n measurements with the largest determinant of the information matrix (D-optimality).

    Args:
        robot: the nominal robot.
        unknowns: see :func:`calibrate`.
        n: number of measurements, each a pose and a load.
        platform, actuators: coordinates of the platform, or of all actuators; arrays span the grid of poses; default: all
            actuators at zero.
        load: (…, 6) possible loads [N, N·m]; the candidates are all combinations of poses and loads.
        readings: components of the twist and gauges that are read in every measurement.
        gauges, reference, orientation, payload, point, frame, closure_tolerance, analysis: see :func:`calibrate`.
        seed: seed of random plans and starts.

    Returns:
        Different combinations of a pose (reachable, not singular, within joint limits) and a load, the expected standard errors
        of the unknowns, and, for comparison, the standard errors of random plans. From six initial plans, measurements are
        exchanged one by one while the determinant increases; the best resulting plan is returned.

    Raises:
        ArgumentError: an argument has an invalid value or shape.
        KinetostaticsError: see :func:`calibrate`.

    Examples:
        >>> import kinetostatics as ks
        >>> robot = ks.load_robot("3rps")
        >>> plan = ks.plan_measurements(robot, ["rod_1", "rod_2", "rod_3"], 3,
        ...     {"z": 0.5, "rx": [-0.2, 0, 0.2], "ry": [-0.2, 0, 0.2]}, load=[0, 0, -2000, 0, 0, 0], readings=["dz"])
        >>> len(plan.chosen), plan.gain > 1
        (3, True)
    """
    case = load_case_of(plan_measurements, CalibrationLoads, analysis, point=point, frame=frame)
    check_robot("plan_measurements", robot, payload)
    seed = check("seed", seed)
    described = read_gauges(gauges)
    names = names_in("readings", readings, '["dz"]')
    for name in names:
        if name not in described:
            raise ArgumentError(f"readings: there is no gauge {name!r}: {near_names(name, described)}")
    if not names:
        raise ArgumentError('readings are empty; name at least one: ["dz"]')
    coordinates, wrenches = _candidates(platform, actuators, load, robot.description.actuated)
    every, each = len(wrenches), len(names)
    which = Readings(
        np.repeat(np.arange(every), each), np.tile(np.arange(each), every), {name: described[name] for name in names}
    )
    sigmas = np.array([gauge.sigma or SIGMA for gauge in which.gauges.values()])
    looked_for = Unknowns(robot, unknowns, which.gauges, payload, dict(zip(names, sigmas.tolist(), strict=True)))
    model = Model(looked_for, coordinates, wrenches, which, reference, orientation, case, None, closure_tolerance)
    scale, start = looked_for.scale, looked_for.start
    blocks = model.jacobian(start).reshape(every, each, -1) * scale / sigmas[:, None]
    result = model.result(start)
    usable = np.all(np.isfinite(blocks), axis=(1, 2)) & ~result.limit_exceeded[:every]
    numbers = np.flatnonzero(usable)
    count = len(numbers)
    if not count:
        raise ArgumentError(
            f"none of {every} combinations of pose and load can be measured: all poses are unreachable, singular or beyond a "
            "joint limit"
        )
    n = whole_number("n", n, 1)
    if n > count:
        raise ArgumentError(
            f"{n} measurements cannot be chosen from {count} combinations of pose and load: give more, or plan fewer"
        )
    J = blocks[usable].reshape(count * each, -1)
    columns, seen, null = determined(J)
    basis = columns[:, None] * seen
    if n * each < seen.shape[1]:
        raise ArgumentError(
            f"{seen.shape[1]} unknowns need at least {-(-seen.shape[1] // each)} measurements of {each} "
            f"reading{'s' * (each > 1)} each, not {n}"
        )
    blocks = (J @ basis).reshape(count, each, -1)
    rng = np.random.default_rng(seed)
    chosen = best_subset(blocks, n, rng)
    drawn = [rng.choice(count, n, replace=False) for _ in range(RANDOM)]
    valued = [(plan, log_det(blocks[plan])) for plan in drawn]
    usual = [(plan, value) for plan, value in valued if np.isfinite(value)]
    free = seen.shape[1]
    more = log_det(blocks[chosen]) - float(np.mean([value for _, value in usual])) if usual else np.nan
    gain = float(np.exp(more / (2 * free))) if free else float("nan")
    null = columns[:, None] * null
    identifiable = np.flatnonzero(identifiable_ones(null)).tolist()
    factors = looked_for.reported(start)[1] * scale

    def errors(plan: Index) -> Array:
        information = np.einsum("nki,nkj->ij", blocks[plan], blocks[plan])
        covariance = factors @ basis @ np.linalg.pinv(information) @ basis.T @ factors.T
        return np.asarray(np.sqrt(np.diag(covariance))[identifiable])

    ours = errors(chosen)
    others = np.exp(np.mean(np.log([errors(plan) for plan, _ in usual] or [ours * np.nan]), axis=0))
    return MeasurementPlan(
        ResultMapping({name: frozen(array[numbers[chosen]]) for name, array in coordinates.items()}),
        frozen(wrenches[numbers[chosen]]),
        names,
        ResultMapping({looked_for.items[k].name: float(error) for k, error in zip(identifiable, ours, strict=True)}),
        ResultMapping({looked_for.items[k].name: float(error) for k, error in zip(identifiable, others, strict=True)}),
        gain,
        unidentifiable(looked_for.items, null),
        count,
        every - count,
        numbers[chosen],
        robot,
    )


def _candidates(
    platform: Mapping[str, ArrayLike] | None, actuators: Mapping[str, ArrayLike] | None, load: ArrayLike, actuated: Sequence[str]
) -> tuple[dict[str, Array], Array]:
    """Return (coordinates (N,) by name, loads (N, 6)) of all N candidates."""
    wrenches = finite_numbers("load", load)
    if wrenches.ndim == 0 or wrenches.shape[-1] != 6 or not wrenches.size:
        raise ArgumentError(f"load has the shape {wrenches.shape}; its last axis must have 6 entries, force and moment")
    wrenches = wrenches.reshape(-1, 6)
    given = actuators if platform is None else platform
    poses = math.prod(finite_numbers(name, values).size for name, values in given.items()) if isinstance(given, Mapping) else 1
    if not 0 < poses * len(wrenches) <= MOST:
        raise ArgumentError(f"{poses * len(wrenches):,} combinations of pose and load are given; there must be 1 to {MOST:,}")
    coordinates, _ = grid_of(platform, actuators, actuated)
    return {name: np.repeat(array, len(wrenches)) for name, array in coordinates.items()}, np.tile(wrenches, (poses, 1))


def log_det(blocks: Array) -> float:
    """Return log det Σ JᵀJ of n measurements with the Jacobians J (n, k, r); −inf if the sum is singular."""
    values = np.linalg.eigvalsh(np.einsum("nki,nkj->ij", blocks, blocks))
    if values.size and values[0] <= ROUNDING * values[-1]:
        return -np.inf
    return float(np.sum(np.log(values)))


def best_subset(blocks: Array, n: int, rng: np.random.Generator) -> Index:
    """Return the indices (n,) of the candidates whose information matrix has the largest determinant found.

    ``blocks`` (N, k, r): Jacobians of the k readings of each of N candidates. One initial subset is chosen greedily, the others
    at random by ``rng``; each is improved by exchanges.
    """
    r, every = blocks.shape[2], np.einsum("nki,nkj->nij", blocks, blocks)
    starts: list[Index] = [_greedy(every, n)] + [rng.choice(len(every), n, replace=False) for _ in range(STARTS)]
    ridge = 1e-12 * np.trace(every.sum(axis=0)) * np.eye(r)  # until all unknowns are determined
    plans = [_exchanged(every, start, ridge) for start in starts]
    return np.sort(max(plans, key=lambda plan: float(np.linalg.slogdet(every[plan].sum(axis=0) + ridge)[1])))


def _greedy(every: Array, n: int) -> Index:
    ridge = 1e-9 * np.trace(every.sum(axis=0)) * np.eye(every.shape[1])
    chosen: list[int] = []
    for _ in range(n):
        gains = np.linalg.slogdet(ridge + every[chosen].sum(axis=0) + every)[1]
        gains[chosen] = -np.inf
        chosen.append(int(np.argmax(gains)))
    return np.array(chosen)


def _exchanged(every: Array, start: Index, ridge: Array) -> Index:
    """Improve the plan ``start`` (n,) by exchanges of one measurement; ``every`` (N, r, r) has JᵀJ of all candidates."""
    chosen = np.array(start)
    value, going = float(np.linalg.slogdet(every[chosen].sum(axis=0) + ridge)[1]), True
    while going:
        going = False
        for k in range(len(chosen)):
            others = every[np.delete(chosen, k)].sum(axis=0) + ridge
            gains = np.linalg.slogdet(others + every)[1]
            gains[np.delete(chosen, k)] = -np.inf
            best = int(np.argmax(gains))
            if gains[best] > value + GAIN:
                chosen[k], value, going = best, float(gains[best]), True
    return chosen
