"""From the zero pose to thousands of poses: some are reached on straight lines, and lead their neighbours.

The requested coordinates are divided into cells. Where a cell has many poses, nodes of its own are reached first, and a
polynomial through them predicts all poses so well that hardly more than one correction is left to do. Where it has few, one pose
of each cell, its leader, is reached first (leaders again by leaders of their own); the others start from it with a linear
predictor. What that does not reach follows its own straight line.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinetostatics.linalg import least_squares
from kinetostatics.solver import Poses, Request, Solver

Array = NDArray[np.float64]

#: Poses solved together; more no longer fit into the processor's cache.
CHUNK = 2000
#: Poses that share a leader, on average.
_FOLLOWERS = 24
#: Nodes along each of 1, 2, … varying coordinates of a cell, and poses of a cell per node that make them pay.
_NODES, _POSES_PER_NODE = {1: 10, 2: 8, 3: 6, 4: 4}, 6
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
    grid = _Cells.of(target)
    if grid is not None:
        return _interpolate(solver, request, start, target, local, origin, grid)
    return _lead(solver, request, start, target, local, origin)


def _lead(
    solver: Solver,
    request: Request,
    start: Poses,
    target: Array,
    local: int,
    origin: tuple[Array, Array] | None,
) -> tuple[Poses, NDArray[np.bool_], Array]:
    """Reach poses by way of one leader of each cell."""
    N = target.shape[1]
    lead_by, leader_of = _leaders(target)
    if lead_by.size > N / 4:
        return _follow(solver, request, start, target, local, origin, _SHORTEST_IN_BATCH)
    leaders, led, _ = reach(solver, request, start, target[:, lead_by], local, origin)
    per_target = _predictors(solver, request, leaders, target[:, lead_by], local)
    poses = Poses(np.empty((start.x.shape[0], N)), np.empty((3, N)))
    arrived = np.zeros(N, dtype=bool)
    # neighbours are solved together; those without a leader have to find their own way
    order = np.argsort(leader_of, kind="stable")
    shifts = np.abs(target - target[:, lead_by[leader_of]]) / solver.longest_strides(request)[:, None]
    order = order[(led[leader_of] & (np.max(shifts, axis=0, initial=0.0) < 1))[order]]
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


@dataclass(frozen=True)
class _Cells:
    """A partition of the requested coordinates into boxes, with nodes for a polynomial in each.

    Attributes:
        varying: the coordinates that vary.
        low, size: (d,) corner of the first box and size of each.
        count: (d,) numbers of boxes.
        nodes: (m,) places of the nodes in a box along each coordinate, in −1 … 1 (Chebyshev).
    """

    varying: NDArray[np.intp]
    low: Array
    size: Array
    count: NDArray[np.intp]
    nodes: Array

    @classmethod
    def of(cls, target: Array) -> _Cells | None:
        """Return a partition that pays: with far more poses than nodes."""
        N = target.shape[1]
        if not np.all(np.isfinite(target)):
            return None
        low, high = target.min(axis=1), target.max(axis=1)
        varying = np.flatnonzero(high > low)
        d = varying.size
        if d == 0 or d > 4:
            return None
        nodes = _NODES[d]
        boxes = N / (_POSES_PER_NODE * nodes**d)
        if boxes < 1:
            return None
        each = max(int(boxes ** (1 / d)), 1)
        places = np.cos(np.pi * (np.arange(nodes) + 0.5) / nodes)[::-1]
        span = (high - low)[varying]
        return cls(varying, low[varying], span / each, np.full(d, each), places)

    def number(self, target: Array) -> NDArray[np.intp]:
        """Return the box (N,) of each target."""
        place = ((target[self.varying] - self.low[:, None]) / self.size[:, None]).astype(np.intp)
        return np.asarray(np.ravel_multi_index(tuple(np.minimum(place, self.count[:, None] - 1)), tuple(self.count)))

    def local(self, box: int, target: Array) -> Array:
        """Return where in a box (d, n), in −1 … 1, targets (…, n) lie."""
        corner = np.array(np.unravel_index(box, tuple(self.count)))[:, None]
        return 2 * ((target[self.varying] - self.low[:, None]) / self.size[:, None] - corner) - 1

    def node_targets(self, box: int, example: Array) -> Array:
        """Return the coordinates (n, M) of all nodes of a box; those that do not vary are as in ``example`` (n,)."""
        corner = np.array(np.unravel_index(box, tuple(self.count)))
        axes = [self.low[k] + self.size[k] * (corner[k] + (self.nodes + 1) / 2) for k in range(self.varying.size)]
        grid = np.stack([axis.ravel() for axis in np.meshgrid(*axes, indexing="ij")])
        result = np.repeat(example[:, None], grid.shape[1], axis=1)
        result[self.varying] = grid
        return result

    def weights(self, places: Array) -> Array:
        """Return the weights (M, n) of a box's nodes in the polynomial's value at places (d, n)."""
        result = np.ones((1, places.shape[1]))
        for row in places:
            one = np.ones((self.nodes.size, row.size))
            for k, node in enumerate(self.nodes):
                for other in self.nodes[np.arange(self.nodes.size) != k]:
                    one[k] *= (row - other) / (node - other)
            result = (result[:, None] * one[None]).reshape(-1, row.size)
        return result


def _interpolate(
    solver: Solver,
    request: Request,
    start: Poses,
    target: Array,
    local: int,
    origin: tuple[Array, Array] | None,
    cells: _Cells,
) -> tuple[Poses, NDArray[np.bool_], Array]:
    """Reach poses from polynomials through nodes of their cells."""
    N = target.shape[1]
    number = cells.number(target)
    order = np.argsort(number, kind="stable")
    boxes, firsts = np.unique(number[order], return_index=True)
    members = np.split(order, firsts[1:])
    pairs = list(zip(boxes.tolist(), members, strict=True))
    wanted = np.concatenate([cells.node_targets(box, target[:, mine[0]]) for box, mine in pairs], axis=1)
    nodes, led, _ = _lead(solver, request, start, wanted, local, origin)
    M = wanted.shape[1] // len(boxes)
    poses = Poses(np.empty((start.x.shape[0], N)), np.empty((3, N)))
    arrived = np.zeros(N, dtype=bool)
    usable = [led[k * M : (k + 1) * M].all() for k in range(len(boxes))]
    guess = Poses(np.empty((start.x.shape[0], N)), np.zeros((3, N)))
    for k, (box, mine) in enumerate(pairs):
        if usable[k]:
            part = slice(k * M, (k + 1) * M)
            weights = cells.weights(cells.local(box, target[:, mine]))
            guess.x[:, mine] = nodes.x[:, part] @ weights
            guess.c[:, mine] = nodes.c[:, part] @ weights
    ready = np.concatenate([mine for mine, good in zip(members, usable, strict=True) if good] or [np.zeros(0, dtype=np.intp)])
    for first in range(0, ready.size, CHUNK):
        which = ready[first : first + CHUNK]
        state = Poses(solver.tree.normalized(guess.x[:, which]), guess.c[:, which])
        near = np.full(which.size, 8e-4)
        found, arrived[which] = solver.newton(request, state, target[:, which], local, before=near)
        poses.x[:, which], poses.c[:, which] = found.x, found.c
    gone = np.where(arrived, 1.0, 0.0)
    rest = np.flatnonzero(~arrived)
    if rest.size:
        found, arrived[rest], gone[rest] = _lead(solver, request, start, target[:, rest], local, origin)
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
