"""From the zero pose to thousands of poses, each the one at the end of its own straight line.

Few poses follow their own lines. Of many, polynomials through nodes predict all others so well that hardly more than one
correction is left to do; where more than four coordinates vary, one pose of each cell, the seed, predicts its neighbours
linearly. That leads to the poses at the ends of their own lines only if all these lines lie on one smooth sheet: lines that pass
a singular pose on different sides may end in different assembly modes. So some poses follow their own lines as well, and where
predictions do not agree with them, at the end or on the way, the coordinates are divided, until so few poses are left that all
follow their own lines.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from kinetostatics.kinematics.chebyshev import MOST_VARYING, Cells
from kinetostatics.kinematics.lines import follow, longest_strides
from kinetostatics.kinematics.prescribed import PrescribedCoordinates, line_start
from kinetostatics.kinematics.solver import Solver, SolverState
from kinetostatics.math.arrays import Array, chunks

#: Poses that share a seed, on average.
_FOLLOWERS = 24
#: Batches with fewer poses follow their own lines, and so do fewer seeds.
MANY, _FEW = 1500, 200
#: Where on their lines polynomials are compared with poses, and how many of these.
_LEVELS, _TESTS = (1 / 3, 2 / 3, 1.0), 32
#: Largest scaled correction expected where a prediction is compared with a pose, and scaled difference up to which both are one.
_COARSE, _SAME = 0.3, 1e-6
#: Part of the poses to which polynomials may lead but roughly.
_ROUGH = 0.05


def reach(
    solver: Solver,
    prescribed: PrescribedCoordinates,
    start: SolverState,
    target: Array,
    local: int = 0,
    origin: tuple[Array, Array] | None = None,
) -> tuple[SolverState, NDArray[np.bool_]]:
    """Reach the prescribed coordinates from ``start``.

    Args:
        solver: closes the loops.
        prescribed: which coordinates are given.
        start: one pose, or as many as there are targets.
        target: (n, N) coordinates.
        local: number of freedoms that do not move the platform; they stay as they are.
        origin: what :meth:`Solver.origin` says of the start, if that is known already.

    Returns:
        The poses, and whether each arrived.
    """
    N = target.shape[1]
    if N < MANY or start.x.shape[1] != 1 or solver.is_quick:
        return follow(solver, prescribed, start, target, local, origin)[:2]
    continuation = BatchContinuation(
        solver, prescribed, start, local, solver.origin(prescribed, start) if origin is None else origin
    )
    poses, arrived = start.take(np.zeros(N, dtype=np.intp)), np.zeros(N, dtype=bool)
    inliers = _inliers(target)
    left, parts = [np.setdiff1d(np.arange(N), inliers)], [inliers]
    while parts:
        part = parts.pop()
        if part.size < MANY:
            left.append(part)
            continue
        found = continuation.reach(target[:, part])
        if found is not None:
            at, good = found
            which = part[good]
            poses.x[:, which], poses.c[:, which], arrived[which] = at.x[:, good], at.c[:, good], True
            part = part[~good]
        divided = _divided(target[:, part], longest_strides(solver, prescribed)) if part.size else []
        if len(divided) > 1:
            parts += [part[some] for some in divided]
        else:
            left.append(part)
    rest = np.concatenate(left)
    if rest.size:
        alone, arrived[rest], _ = follow(solver, prescribed, start, target[:, rest], local, origin)
        poses.x[:, rest], poses.c[:, rest] = alone.x, alone.c
    return poses, arrived


@dataclass(frozen=True)
class _Nodes:
    """The nodes of some boxes, one box after the other: poses, and whether they have been reached."""

    cells: Cells
    boxes: NDArray[np.intp]
    poses: SolverState
    reached: NDArray[np.bool_]

    @property
    def values(self) -> Array:
        """All coordinates of the poses (nq' + 3, M)."""
        return np.concatenate([self.poses.x, self.poses.c])


@dataclass(frozen=True)
class BatchContinuation:
    """From one start to many poses: the arguments of :func:`reach`."""

    solver: Solver
    prescribed: PrescribedCoordinates
    start: SolverState
    local: int
    origin: tuple[Array, Array]

    def reach(self, target: Array) -> tuple[SolverState, NDArray[np.bool_]] | None:
        """Reach poses by predictions, and return which are reached; None if they may not be at the ends of their own lines."""
        tests = _spread(target)
        sampling = Cells.sampling(target)
        if sampling is None:
            if np.sum(np.ptp(target, axis=1) > 0) <= MOST_VARYING:
                return None
            ways = self.continue_from_start(target[:, tests], (1.0,))
            if ways is None:
                return None
            poses, arrived = self._continue_by_seeds(target)
            return (poses, arrived) if np.all(self._same(poses.take(tests), ways[0])[arrived[tests]]) else None
        places = np.append(sampling.node_targets(0, target[:, 0]), target[:, tests], axis=1)
        ways = self.continue_from_start(places, _LEVELS)
        if ways is None:
            return None
        at_nodes, at_tests = np.split(np.arange(places.shape[1]), [-tests.size])
        one_box, everyone = np.zeros(1, dtype=np.intp), np.ones(at_nodes.size, dtype=bool)
        for level, poses in zip(_LEVELS, ways, strict=True):
            samples = _Nodes(sampling, one_box, poses.take(at_nodes), everyone)
            found, good = self._through(samples, places[:, at_tests], self._at(places[:, at_tests], level), _COARSE)
            if not np.all(good & self._same(found, poses.take(at_tests))):
                return None
        cells = sampling.refined(samples.values)
        return None if cells is None else self._interpolate(self._nodes(cells, samples, target), target)

    def _line(self, target: Array) -> tuple[Array, Array]:
        """Return where the lines to targets start: see :func:`.lines.line_start`."""
        return line_start(self.prescribed, self.origin, target, shorter=False)

    def _at(self, target: Array, level: float) -> Array:
        """Return the coordinates that lines have at some part of their way."""
        first = self._line(target)[0]
        return first + level * (target - first)

    def continue_from_start(self, target: Array, levels: tuple[float, ...]) -> list[SolverState] | None:
        """Follow own lines up to some parts of their way; None if not all get there."""
        poses, result = self.start, []
        origin = self._line(target)
        for level in levels:
            there = target if level == 1 else self._at(target, level)
            poses, arrived, _ = follow(self.solver, self.prescribed, poses, there, self.local, origin)
            if not np.all(arrived):
                return None
            origin = there, poses.c
            result.append(poses)
        return result

    def _same(self, one: SolverState, other: SolverState) -> NDArray[np.bool_]:
        """Return which pairs of poses (N,) have all joints alike, but for spins that matter to nothing."""
        bodies = [joint.body for joint in self.solver.tree.joints]
        frames = [self.solver.equations.forward(poses.x) for poses in (one, other)]
        R = frames[0].rotation[:, :, bodies] - frames[1].rotation[:, :, bodies]
        p = frames[0].position[:, bodies] - frames[1].position[:, bodies]
        moved = np.max(np.abs(p), axis=(0, 1), initial=0.0) / self.solver.length
        if not self.local:
            moved = np.maximum(moved, np.max(np.abs(R), axis=(0, 1, 2), initial=0.0))
        return np.asarray(moved < _SAME)

    def _nodes(self, cells: Cells, samples: _Nodes, target: Array) -> _Nodes:
        """Reach the nodes of all boxes in which there are targets, from samples, or else on their own lines."""
        boxes, examples = np.unique(cells.number(target), return_index=True)
        places = [cells.node_targets(box, target[:, k]) for box, k in zip(boxes.tolist(), examples, strict=True)]
        wanted = np.concatenate(places, axis=1)
        poses, reached = self._through(samples, wanted, wanted, samples.cells.expected_step)
        rest = np.flatnonzero(~reached)
        if rest.size:
            found, reached[rest], _ = follow(self.solver, self.prescribed, self.start, wanted[:, rest], self.local, self.origin)
            poses.x[:, rest], poses.c[:, rest] = found.x, found.c
        return _Nodes(cells, boxes, poses, reached)

    def _continue_by_seeds(self, target: Array) -> tuple[SolverState, NDArray[np.bool_]]:
        """Reach poses by way of one seed in each cell, from which linear predictors lead to its neighbours."""
        N = target.shape[1]
        seed_numbers, seed_of = _seeds(target)
        if N < _FEW or seed_numbers.size > N / 4:
            return follow(self.solver, self.prescribed, self.start, target, self.local, self.origin)[:2]
        seeds, led = self._continue_by_seeds(target[:, seed_numbers])
        poses = SolverState(np.empty((seeds.x.shape[0], N)), np.empty((3, N)))
        arrived = np.zeros(N, dtype=bool)
        seed_number = np.where(led, np.cumsum(led) - 1, -1)[seed_of]
        # neighbours are solved together; those without a seed are not reached
        which = np.argsort(seed_number, kind="stable")
        which = which[np.searchsorted(seed_number[which], 0) :]
        seed_of = seed_number[which]
        solver, prescribed, seeds, places = self.solver, self.prescribed, seeds.take(led), target[:, seed_numbers[led]]
        per_target = _predictors(solver, prescribed, seeds, places, self.local)
        shifts = np.abs(target[:, which] - places[:, seed_of]) / longest_strides(solver, prescribed)[:, None]
        near = np.max(shifts, axis=0, initial=0.0) < 1
        which, seed_of = which[near], seed_of[near]
        for part in chunks(which.size):
            some, mine = which[part], seed_of[part]
            step = np.einsum("ijn,jn->in", per_target[:, :, mine], target[:, some] - places[:, mine])
            guess = solver.advance(prescribed, seeds.take(mine), step)
            size = solver.size(prescribed, step)
            found, arrived[some] = solver.newton(prescribed, guess, target[:, some], self.local, np.maximum(size, 1e-3))
            poses.x[:, some], poses.c[:, some] = found.x, found.c
        return poses, arrived

    def _interpolate(self, nodes: _Nodes, target: Array) -> tuple[SolverState, NDArray[np.bool_]]:
        """Reach poses from polynomials through nodes of their cells; where one of a cell is not reached, none is.

        The few to which polynomials lead but roughly follow their own lines, and count if both ways lead to one pose.
        """
        poses, arrived = self._through(nodes, target, target, nodes.cells.expected_step)
        rest = np.flatnonzero(~arrived)
        if 0 < rest.size <= _ROUGH * arrived.size:
            roughly, good = self._through(nodes, target[:, rest], target[:, rest], _COARSE)
            alone, reached, _ = follow(self.solver, self.prescribed, self.start, target[:, rest], self.local, self.origin)
            poses.x[:, rest], poses.c[:, rest] = alone.x, alone.c
            arrived[rest] = good & reached & self._same(roughly, alone)
        number = nodes.cells.number(target)
        return poses, arrived & ~np.isin(number, np.unique(number[~arrived]))

    def _through(
        self, nodes: _Nodes, places: Array, target: Array, expected_step: float
    ) -> tuple[SolverState, NDArray[np.bool_]]:
        """Reach targets from polynomials through nodes at places (n, N) of their boxes.

        Args:
            nodes: from which polynomials are made; boxes that lack one have none.
            places: where in the boxes polynomials are evaluated.
            target: the coordinates of the poses there; they are other ones than the places if nodes are only on their way.
            expected_step: scaled size of first corrections that are not to be doubted.
        """
        solver, cells, N = self.solver, nodes.cells, target.shape[1]
        number = cells.number(places)
        order = np.argsort(number, kind="stable")
        boxes, firsts = np.unique(number[order], return_index=True)
        members = np.split(order, firsts[1:])
        nodes_of = np.arange(nodes.reached.size).reshape(nodes.boxes.size, -1)[np.searchsorted(nodes.boxes, boxes)]
        usable = np.all(nodes.reached[nodes_of], axis=1)
        poses = SolverState(np.empty((nodes.poses.x.shape[0], N)), np.zeros((3, N)))
        arrived = np.zeros(N, dtype=bool)
        values, size = nodes.values, poses.x.shape[0]
        for box, mine, ours, good in zip(boxes.tolist(), members, nodes_of, usable, strict=True):
            if good:
                at_nodes = values[:, ours]
                for part in chunks(mine.size):
                    which = mine[part]
                    found = cells.interpolated(at_nodes, cells.local(box, places[:, which]))
                    poses.x[:, which], poses.c[:, which] = found[:size], found[size:]
        ready = order[np.repeat(usable, [mine.size for mine in members])]
        for part in chunks(ready.size):
            which = ready[part]
            guess = SolverState(solver.tree.normalized(poses.x[:, which]), poses.c[:, which])
            near = np.full(which.size, expected_step)
            reached, arrived[which] = solver.newton(self.prescribed, guess, target[:, which], self.local, before=near)
            poses.x[:, which], poses.c[:, which] = reached.x, reached.c
        return poses, arrived


def _spread(target: Array) -> NDArray[np.intp]:
    """Return some of the targets: those farthest towards all corners, and others anywhere."""
    low, high = target.min(axis=1), target.max(axis=1)
    varying = np.flatnonzero(high > low)
    scaled = (target[varying] - (low + high)[varying, None] / 2) / (high - low)[varying, None]
    corners = np.array(list(product((-1.0, 1.0), repeat=varying.size))) @ scaled
    others = np.random.default_rng(0).choice(target.shape[1], min(_TESTS, target.shape[1]), replace=False)
    return np.unique(np.append(np.argmax(corners, axis=1), others))


def _divided(target: Array, strides: Array) -> list[NDArray[np.intp]]:
    """Return which targets lie in the parts of their box, halved along up to three coordinates: those that go farthest."""
    low, high = target.min(axis=1), target.max(axis=1)
    widest = np.argsort(-(high - low) / strides, kind="stable")[:3]
    side = target[widest] > ((low + high) / 2)[widest, None]
    number = np.ravel_multi_index(tuple(side.astype(np.intp)), (2,) * widest.size)
    parts = [np.flatnonzero(number == k) for k in range(2**widest.size)]
    return [part for part in parts if part.size]


def _inliers(target: Array) -> NDArray[np.intp]:
    """Return the targets that are not far from where nearly all are: cells made for far ones would hardly divide the others."""
    finite = np.all(np.isfinite(target), axis=0)
    if not np.any(finite):
        return np.zeros(0, dtype=np.intp)
    ends = np.quantile(target[:, finite], (0.02, 0.98), axis=1)
    margin = (ends[1] - ends[0]) / 4
    within = (target >= (ends[0] - margin)[:, None]) & (target <= (ends[1] + margin)[:, None])
    return np.flatnonzero(np.all(within, axis=0))


def _seeds(target: Array) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the poses that are seeds, and for each pose which of them is its seed."""
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
    seed_of = np.empty(N, dtype=np.intp)
    seed_of[order] = np.repeat(np.arange(first.size), np.diff(np.r_[first, N]))
    return order[first], seed_of


def _predictors(solver: Solver, prescribed: PrescribedCoordinates, poses: SolverState, target: Array, local: int) -> Array:
    """Return :meth:`Solver.predictors` (free, n, N) at many solved poses."""
    result = np.empty((len(solver.free_columns(prescribed)) + len(prescribed.unknown_angles), *target.shape))
    for part in chunks(target.shape[1]):
        result[:, :, part] = solver.predictors(
            prescribed, SolverState(poses.x[:, part], poses.c[:, part]), target[:, part], local
        )
    return result
