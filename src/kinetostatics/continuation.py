"""From the zero pose to thousands of poses: some are reached on straight lines, and lead their neighbours.

The requested coordinates are divided into cells. One pose of each cell, its leader, is reached first (leaders again by leaders of
their own); all others start from their leader with a linear predictor. What that does not reach follows its own straight line.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinetostatics.linalg import least_squares
from kinetostatics.solver import Poses, Request, Solver

Array = NDArray[np.float64]

#: Poses solved together; more no longer fit into the processor's cache.
CHUNK = 2000
#: Poses that share a leader, on average.
_FOLLOWERS = 24
#: Batches with fewer poses have no leaders.
_FEW = 200
#: A pose counts as unreachable when the line to it cannot be followed in steps of this part of it; in a batch sooner.
_SHORTEST, _SHORTEST_IN_BATCH = 1e-3, 1 / 64


def reach(
    solver: Solver,
    request: Request,
    start: Poses,
    target: Array,
    local: int = 0,
    origin: tuple[Array, Array] | None = None,
) -> tuple[Poses, NDArray[np.bool_], Array]:
    """Reach the requested coordinates from ``start``.

    Args:
        solver: closes the loops.
        request: which coordinates are given.
        start: one pose, or as many as there are targets.
        target: (n, N) coordinates.
        local: number of freedoms that do not move the platform; they stay as they are.
        origin: what :meth:`Solver.origin` says of the start, if that is known already.

    Returns:
        The poses, whether each arrived, and how much of its way (0 … 1) each has gone.
    """
    N = target.shape[1]
    if N < _FEW or start.x.shape[1] != 1:
        return _follow(solver, request, start, target, local, origin, _SHORTEST)
    lead_by, leader_of = _leaders(target)
    if lead_by.size > N / 4:
        return _follow(solver, request, start, target, local, origin, _SHORTEST_IN_BATCH)
    leaders, led, _ = reach(solver, request, start, target[:, lead_by], local, origin)
    per_target = _predictors(solver, request, leaders, target[:, lead_by], local)
    poses = Poses(np.empty((start.x.shape[0], N)), np.empty((3, N)))
    arrived = np.zeros(N, dtype=bool)
    # neighbours are solved together; those without a leader have to find their own way
    order = np.argsort(leader_of, kind="stable")
    order = order[led[leader_of[order]]]
    for first in range(0, order.size, CHUNK):
        which = order[first : first + CHUNK]
        mine = leader_of[which]
        shift = target[:, which] - target[:, lead_by[mine]]
        step = np.einsum("ijn,jn->in", per_target[:, :, mine], shift)
        guess = solver.advance(request, leaders.take(mine), step)
        size = np.sqrt(np.max(step * step, axis=0, initial=0.0))
        found, good = solver.newton(request, guess, target[:, which], local, before=np.maximum(size, 1e-3))
        poses.x[:, which], poses.c[:, which], arrived[which] = found.x, found.c, good
    gone = np.where(arrived, 1.0, 0.0)
    rest = np.flatnonzero(~arrived)
    if rest.size:
        found, arrived[rest], gone[rest] = _follow(solver, request, start, target[:, rest], local, origin, _SHORTEST_IN_BATCH)
        poses.x[:, rest], poses.c[:, rest] = found.x, found.c
    return poses, arrived, gone


def _follow(
    solver: Solver,
    request: Request,
    start: Poses,
    target: Array,
    local: int,
    origin: tuple[Array, Array] | None,
    shortest: float,
) -> tuple[Poses, NDArray[np.bool_], Array]:
    """Follow every pose's own straight line, in chunks."""
    N = target.shape[1]
    poses = Poses(np.empty((start.x.shape[0], N)), np.empty((3, N)))
    arrived, gone = np.empty(N, dtype=bool), np.empty(N)
    for first in range(0, N, CHUNK):
        part = slice(first, min(first + CHUNK, N))
        mine = start if start.x.shape[1] == 1 else Poses(start.x[:, part], start.c[:, part])
        found, arrived[part], gone[part] = solver.follow(request, mine, target[:, part], local, origin, shortest)
        poses.x[:, part], poses.c[:, part] = found.x, found.c
    return poses, arrived, gone


def _leaders(target: Array) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the poses that lead, and for each pose which of them is its leader."""
    N = target.shape[1]
    finite = np.where(np.isfinite(target), target, 0.0)
    low, high = finite.min(axis=1), finite.max(axis=1)
    varying = np.flatnonzero(high > low)
    if not varying.size:
        return np.zeros(1, dtype=np.intp), np.zeros(N, dtype=np.intp)
    cells = max(round((N / _FOLLOWERS) ** (1 / varying.size)), 1)
    place = (finite[varying] - low[varying, None]) / (high - low)[varying, None] * cells
    cell = np.minimum(place.astype(np.intp), cells - 1)
    key = np.ravel_multi_index(tuple(cell), (cells,) * varying.size)
    off_centre = np.sum((place - cell - 0.5) ** 2, axis=0)
    order = np.lexsort((off_centre, key))
    first = np.flatnonzero(np.r_[True, np.diff(key[order]) > 0])
    leader_of = np.empty(N, dtype=np.intp)
    leader_of[order] = np.repeat(np.arange(first.size), np.diff(np.r_[first, N]))
    return order[first], leader_of


def _predictors(solver: Solver, request: Request, poses: Poses, target: Array, local: int) -> Array:
    """Return the scaled steps (free, n, N) per change of each requested coordinate at solved poses."""
    n, N = target.shape
    result = np.empty((len(solver.free_columns(request)) + len(request.unknown_angles), n, N))
    change = 1e-6
    for first in range(0, N, CHUNK):
        part = slice(first, min(first + CHUNK, N))
        here = Poses(poses.x[:, part], poses.c[:, part])
        residual, gradient = solver.system(request, here, target[:, part])
        rates = np.empty((residual.shape[0], n, residual.shape[1]))
        for k in range(n):
            moved = np.array(target[:, part])
            moved[k] += change
            there = Poses(np.array(here.x), np.array(here.c))
            solver.impose(request, there, moved)
            rates[:, k] = (solver.system(request, there, moved)[0] - residual) / change
        result[:, :, part] = -least_squares(gradient, rates, local)
    return np.nan_to_num(result)
