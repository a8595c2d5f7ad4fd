"""From the zero pose to thousands of poses: some are reached on straight lines, and lead their neighbours.

The requested coordinates are divided into cells. Where a cell has many poses, nodes of its own are reached first, and a
polynomial through them predicts all poses so well that hardly more than one correction is left to do. Where it has few, one pose
of each cell, its leader, is reached first (leaders again by leaders of their own); the others start from it with a linear
predictor. Nodes and leaders that are not reached like that follow their own straight lines; other poses the line from the nearest
pose that has been reached.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from kinetostatics.cells import Cells
from kinetostatics.chunks import chunks
from kinetostatics.solver import ALONE, Pace, Poses, Request, Solver

Array = NDArray[np.float64]

#: Poses that share a leader, on average.
_FOLLOWERS = 24
#: Batches with fewer poses have no leaders.
_FEW = 200
#: Of a batch of many poses, on the line from the nearest that has been reached, and on the own lines of leaders and nodes: of
#: those that stay out of reach others tell nearly as much.
_IN_BATCH, _FROM_NEAREST, _LEADING = Pace(1 / 64), Pace(1 / 16, 1 / 4, careful=False), Pace(1 / 4, careful=False)
#: How many of the reached poses are compared.
_COMPARED = 1000


def reach(
    solver: Solver,
    request: Request,
    start: Poses,
    target: Array,
    local: int = 0,
    origin: tuple[Array, Array] | None = None,
) -> tuple[Poses, NDArray[np.bool_]]:
    """Reach the requested coordinates from ``start``.

    Args:
        solver: closes the loops.
        request: which coordinates are given.
        start: one pose, or as many as there are targets.
        target: (n, N) coordinates.
        local: number of freedoms that do not move the platform; they stay as they are.
        origin: what :meth:`Solver.origin` says of the start, if that is known already.

    Returns:
        The poses, and whether each arrived.
    """
    few = target.shape[1] < _FEW
    if few or start.x.shape[1] != 1:
        return follow(solver, request, start, target, local, origin, ALONE if few else _IN_BATCH)[:2]
    way = _Way(solver, request, start, local, origin)
    N, usual = target.shape[1], _usual(target)
    # what is neither usual nor at a distance that can be told stays at the start
    poses, arrived = start.take(np.zeros(N, dtype=np.intp)), np.zeros(N, dtype=bool)
    if usual.size:
        found, arrived[usual] = way.reach(target[:, usual])
        poses.x[:, usual], poses.c[:, usual] = found.x, found.c
    way.from_nearest(poses, arrived, target)
    return poses, arrived


def follow(
    solver: Solver,
    request: Request,
    start: Poses,
    target: Array,
    local: int = 0,
    origin: tuple[Array, Array] | None = None,
    pace: Pace = ALONE,
) -> tuple[Poses, NDArray[np.bool_], Array]:
    """Follow every pose's own straight line, in chunks; also return how much of its way (0 … 1) each has gone."""
    N = target.shape[1]
    poses = Poses(np.empty((start.x.shape[0], N)), np.empty((3, N)))
    arrived, gone = np.empty(N, dtype=bool), np.empty(N)
    for part in chunks(N):
        alone = start.x.shape[1] == 1
        mine = start if alone else Poses(start.x[:, part], start.c[:, part])
        known = origin if alone or origin is None else (origin[0][:, part], origin[1][:, part])
        found, arrived[part], gone[part] = solver.follow(request, mine, target[:, part], local, known, pace)
        poses.x[:, part], poses.c[:, part] = found.x, found.c
    return poses, arrived, gone


@dataclass(frozen=True)
class _Nodes:
    """The nodes of some boxes, one box after the other: coordinates (n, M), poses, and whether they have been reached."""

    cells: Cells
    boxes: NDArray[np.intp]
    places: Array
    poses: Poses
    led: NDArray[np.bool_]

    @property
    def values(self) -> Array:
        """All coordinates of the poses (nq' + 3, M)."""
        return np.concatenate([self.poses.x, self.poses.c])


@dataclass(frozen=True)
class _Way:
    """From one start to many poses: the arguments of :func:`reach`."""

    solver: Solver
    request: Request
    start: Poses
    local: int
    origin: tuple[Array, Array] | None

    def reach(self, target: Array) -> tuple[Poses, NDArray[np.bool_]]:
        """Reach what polynomials, leaders or, where there are but few poses, straight lines lead to."""
        sampling = Cells.sampling(target)
        if sampling is None:
            return self._lead(target)
        samples = self._nodes(sampling, target, self._lead)
        cells = sampling.refined(samples.values, samples.led)
        if cells is None and not np.all(samples.led):
            cells = sampling.even
        if cells is None:
            return self._lead(target)
        return self._interpolate(self._nodes(cells, target, lambda places: self._interpolate(samples, places)), target)

    def _nodes(self, cells: Cells, target: Array, reach: Callable[[Array], tuple[Poses, NDArray[np.bool_]]]) -> _Nodes:
        """Reach the nodes of all boxes in which there are targets."""
        boxes, examples = np.unique(cells.number(target), return_index=True)
        places = [cells.node_targets(box, target[:, k]) for box, k in zip(boxes.tolist(), examples, strict=True)]
        wanted = np.concatenate(places, axis=1)
        poses, led = reach(wanted)
        self._on_own_lines(poses, led, wanted)
        return _Nodes(cells, boxes, wanted, poses, led)

    def _lead(self, target: Array) -> tuple[Poses, NDArray[np.bool_]]:
        """Reach poses by way of one leader of each cell."""
        N = target.shape[1]
        lead_by, leader_of = _leaders(target)
        if N < _FEW or lead_by.size > N / 4:
            return self._follow(target, replace(_IN_BATCH, careful=False))
        leaders, led = self.reach(target[:, lead_by])
        self._on_own_lines(leaders, led, target[:, lead_by])
        poses = Poses(np.empty((leaders.x.shape[0], N)), np.empty((3, N)))
        arrived = np.zeros(N, dtype=bool)
        follower_of = np.where(led, np.cumsum(led) - 1, -1)[leader_of]
        # neighbours are solved together; those without a leader are not reached
        order = np.argsort(follower_of, kind="stable")
        order = order[np.searchsorted(follower_of[order], 0) :]
        self._led(leaders.take(led), target[:, lead_by[led]], follower_of[order], poses, arrived, target, order)
        return poses, arrived

    def _led(
        self,
        leaders: Poses,
        places: Array,
        leader_of: NDArray[np.intp],
        poses: Poses,
        arrived: NDArray[np.bool_],
        target: Array,
        which: NDArray[np.intp],
    ) -> None:
        """Reach some of the targets, in place, from the leaders (len(which),) at places (n, M) with linear predictors."""
        solver, request = self.solver, self.request
        per_target = _predictors(solver, request, leaders, places, self.local)
        shifts = np.abs(target[:, which] - places[:, leader_of]) / solver.longest_strides(request)[:, None]
        near = np.max(shifts, axis=0, initial=0.0) < 1
        which, leader_of = which[near], leader_of[near]
        for part in chunks(which.size):
            some, mine = which[part], leader_of[part]
            step = np.einsum("ijn,jn->in", per_target[:, :, mine], target[:, some] - places[:, mine])
            guess = solver.advance(request, leaders.take(mine), step)
            size = solver.size(request, step)
            found, arrived[some] = solver.newton(request, guess, target[:, some], self.local, np.maximum(size, 1e-3))
            poses.x[:, some], poses.c[:, some] = found.x, found.c

    def _interpolate(self, nodes: _Nodes, target: Array) -> tuple[Poses, NDArray[np.bool_]]:
        """Reach poses from polynomials through nodes of their cells; what these do not reach, from the nodes themselves."""
        solver, cells, N = self.solver, nodes.cells, target.shape[1]
        number = cells.number(target)
        order = np.argsort(number, kind="stable")
        boxes, firsts = np.unique(number[order], return_index=True)
        members = np.split(order, firsts[1:])
        nodes_of = np.arange(nodes.led.size).reshape(nodes.boxes.size, -1)[np.searchsorted(nodes.boxes, boxes)]
        usable = np.all(nodes.led[nodes_of], axis=1)
        poses = Poses(np.empty((nodes.poses.x.shape[0], N)), np.zeros((3, N)))
        arrived = np.zeros(N, dtype=bool)
        values, size = nodes.values, poses.x.shape[0]
        for box, mine, ours, good in zip(boxes.tolist(), members, nodes_of, usable, strict=True):
            if good:
                at_nodes = values[:, ours]
                for part in chunks(mine.size):
                    which = mine[part]
                    found = cells.interpolated(at_nodes, cells.local(box, target[:, which]))
                    poses.x[:, which], poses.c[:, which] = found[:size], found[size:]
        ready = order[np.repeat(usable, [mine.size for mine in members])]
        for part in chunks(ready.size):
            which = ready[part]
            guess = Poses(solver.tree.normalized(poses.x[:, which]), poses.c[:, which])
            near = np.full(which.size, cells.foreseen)
            reached, arrived[which] = solver.newton(self.request, guess, target[:, which], self.local, before=near)
            poses.x[:, which], poses.c[:, which] = reached.x, reached.c
        rest, leader_of = [], []
        for mine, ours, good in zip(members, nodes_of, usable, strict=True):
            left, leading = mine[~arrived[mine]], ours[nodes.led[ours]]
            if left.size and leading.size and not good:
                rest.append(left)
                leader_of.append(leading[_nearest(target[:, left], nodes.places[:, leading])[0]])
        if rest:
            left, lead_by = np.concatenate(rest), np.concatenate(leader_of)
            leaders, follower_of = np.unique(lead_by, return_inverse=True)
            self._led(nodes.poses.take(leaders), nodes.places[:, leaders], follower_of, poses, arrived, target, left)
        doubtful = ready[~arrived[ready]]  # nodes that no polynomial goes through may be of several assembly modes
        if doubtful.size:
            reached, arrived[doubtful] = self._lead(target[:, doubtful])
            poses.x[:, doubtful], poses.c[:, doubtful] = reached.x, reached.c
        return poses, arrived

    def _on_own_lines(self, poses: Poses, arrived: NDArray[np.bool_], target: Array) -> None:
        """Reach the rest of the targets, which lead others, on their own lines from the start, in place."""
        rest = np.flatnonzero(~arrived)
        if rest.size:
            found, arrived[rest] = self._follow(target[:, rest], _LEADING)
            poses.x[:, rest], poses.c[:, rest] = found.x, found.c

    def _follow(self, target: Array, pace: Pace) -> tuple[Poses, NDArray[np.bool_]]:
        """Follow the targets' own lines from the start."""
        return follow(self.solver, self.request, self.start, target, self.local, self.origin, pace)[:2]

    def from_nearest(self, poses: Poses, arrived: NDArray[np.bool_], target: Array) -> None:
        """Reach the rest of the targets from the nearest of the poses that have arrived, in place; without any, from the start.

        What has been reached that way may lead to more.
        """
        pool, rest = np.flatnonzero(arrived), np.flatnonzero(~arrived)
        if pool.size > _COMPARED:
            pool = np.random.default_rng(0).choice(pool, _COMPARED, replace=False)
        scaled = target / self.solver.longest_strides(self.request)[:, None]
        distance = np.full(target.shape[1], np.inf)
        while rest.size:
            if pool.size:
                nearest, new = _nearest(scaled[:, rest], scaled[:, pool])
                closer = new < distance[rest]
                rest, nearest = rest[closer], pool[nearest[closer]]
                distance[rest] = new[closer]
                near = poses.take(nearest)
                origin: tuple[Array, Array] | None = (target[:, nearest], near.c)
                pace = _FROM_NEAREST
            else:
                near, origin, pace = self.start, self.origin, _IN_BATCH
            found, good, _ = follow(self.solver, self.request, near, target[:, rest], self.local, origin, pace)
            poses.x[:, rest], poses.c[:, rest], arrived[rest] = found.x, found.c, good
            pool, rest = rest[good], rest[~good]
            if not pool.size:
                return


def _usual(target: Array) -> NDArray[np.intp]:
    """Return the targets that are not far from where nearly all are: cells made for far ones would hardly divide the others."""
    finite = np.all(np.isfinite(target), axis=0)
    if not np.any(finite):
        return np.zeros(0, dtype=np.intp)
    ends = np.quantile(target[:, finite], (0.02, 0.98), axis=1)
    margin = (ends[1] - ends[0]) / 4
    within = (target >= (ends[0] - margin)[:, None]) & (target <= (ends[1] + margin)[:, None])
    return np.flatnonzero(np.all(within, axis=0))


def _nearest(points: Array, places: Array) -> tuple[NDArray[np.intp], Array]:
    """Return which of places (n, M) is nearest to each point (n, N), and how far it is."""
    nearest, distance = np.empty(points.shape[1], dtype=np.intp), np.empty(points.shape[1])
    square = np.einsum("im,im->m", places, places)
    for part in chunks(nearest.size):
        with np.errstate(over="ignore", invalid="ignore"):
            found = np.argmin(square - 2 * points[:, part].T @ places, axis=1)
            distance[part] = np.sqrt(np.sum((points[:, part] - places[:, found]) ** 2, axis=0))
        nearest[part] = found
    return nearest, distance


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
    """Return :meth:`Solver.predictors` (free, n, N) at many solved poses."""
    result = np.empty((len(solver.free_columns(request)) + len(request.unknown_angles), *target.shape))
    for part in chunks(target.shape[1]):
        result[:, :, part] = solver.predictors(request, Poses(poses.x[:, part], poses.c[:, part]), target[:, part], local)
    return result
