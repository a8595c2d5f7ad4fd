"""A second look at the grid of one robot, once all its poses have been tried one by one.

The straight line from the zero pose may jump to another assembly mode where two of them come near each other, and it may leave
the workspace although the pose belongs to it. Both show only beside their neighbours:

1. Neighbours whose joints differ too much (:mod:`kinetostatics.workspace.assembly_modes.continuity`) are followed from one to the
   other. Where that leads elsewhere, both are followed once more from the zero pose, in small steps, and so are the neighbours
   of those that end elsewhere.
2. From the poses that are reached their neighbours are tried, ring by ring, until nothing more is reached.
3. Of what is left a few are tried from random starts: poses that only another mode reaches are marked.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from kinetostatics.math.arrays import Array, Index, Mask, Values
from kinetostatics.robot import Robot
from kinetostatics.status import Status
from kinetostatics.workspace.assembly_modes.continuity import Edges, JointScale, neighbours, suspect_edges
from kinetostatics.workspace.assembly_modes.other_modes import closed_starts, open_starts
from kinetostatics.workspace.block import pose_numbers
from kinetostatics.workspace.grid import Block
from kinetostatics.workspace.schema import NO_MODE, OTHER_MODE, ZERO_MODE, Labels
from kinetostatics.workspace.sweep_spec import Combination, SweepSpec

#: Small steps along the line from the zero pose, and along that from a pose to its neighbour, to tell modes apart.
STEPS, FINE = 48, 8
#: Two ways to one pose end alike up to so much [rad], and that part of the step between its neighbours.
ALIKE, ALIKE_PART = 1e-5, 0.02
#: How often poses are taken back and reached anew.
ROUNDS = 5
#: Poses beside reached ones that are tried first; if none of them is reached, the others are not tried.
PROBES = 200
#: Poses that are tried from random starts: one in so many of all, at least and at most so many.
ONE_IN, LEAST, MOST = 1000, 32, 500
#: Where a larger part than this is left, as many more are tried as are left, at most so many.
MUCH, SEARCH = 0.05, 1000


@dataclass(frozen=True, eq=False)
class Finished:
    """What the second look found.

    Attributes:
        which: flat numbers of the poses whose numbers change, in the region.
        numbers: their variables, as :func:`pose_numbers` returns them; None if none changes.
        mode: (…region) which mode reaches each pose.
        jumps: pairs of neighbours that are in different modes, in the end.
        retracted: how many poses the straight line had reached in another mode.
        gained: how many more poses are reached.
    """

    which: Index
    numbers: dict[str, Values] | None
    mode: NDArray[np.int8]
    jumps: int
    retracted: int
    gained: int


def finish(
    spec: SweepSpec, labels: Labels, combination: Combination, cases: Block, region: Block, q: Array, reached: Mask, length: float
) -> Finished:
    """Look at a region of the coordinate axes for one robot.

    Args:
        spec: of the sweep.
        labels: of the Dataset.
        combination: the robot.
        cases: which cases of loads are wanted.
        region: of the coordinate axes.
        q: (…region, nq) model coordinates as :func:`joint_state` returns them, NaN where not reached.
        reached: (…region).
        length: the robot's characteristic length [m].
    """
    look = _Look(spec, labels, combination, region, q, reached, length)
    gained = look.try_some()
    for _ in range(ROUNDS):
        before = look.count
        wrong = look.take_back()
        if before < reached.size or wrong:
            look.spread(ZERO_MODE, everywhere=gained or wrong > 0)
        if not wrong and look.count == before:
            break
    look.try_other_modes()
    there, was = look.mode == ZERO_MODE, reached.ravel()
    which = np.flatnonzero((there != was) | (there & look.retracted))
    return Finished(
        which,
        look.numbers(which, cases) if which.size else None,
        look.mode.reshape(reached.shape),
        look.jumps() if which.size else 0,
        int(np.sum(look.retracted & was)),
        int(np.sum(there & ~was)),
    )


class _Look:
    """The poses of a region of the grid by their flat numbers, and what has been tried with them.

    Attributes:
        q: (N, nq) model coordinates: where the pose is reached, in whichever mode; and if some of them are loose, x, y, z of o
            behind them, which are not.
        mode: (N,) the mode that reaches it.
        retracted: (N,) whether it had been reached in another mode.
    """

    def __init__(
        self, spec: SweepSpec, labels: Labels, combination: Combination, region: Block, q: Array, reached: Mask, length: float
    ) -> None:
        self.spec, self.labels, self.combination, self.region = spec, labels, combination, region
        self.shape, size = reached.shape, reached.size
        self.q = q.reshape(size, q.shape[-1]).copy()
        self.mode = np.where(reached.ravel(), ZERO_MODE, NO_MODE).astype(np.int8)
        self.retracted = np.zeros(size, dtype=bool)
        self.units = [str(unit) for unit in labels.said["joint_coordinate_unit"][1]]
        self.nq = len(self.units)
        units = np.array(self.units + ["m"] * (q.shape[-1] - self.nq))
        distinctive = np.array([not loose for loose in labels.loose] + [True] * (len(units) - self.nq), dtype=bool)
        self.scale = JointScale(distinctive * np.where(units == "m", 1 / length, 1.0), (units == "rad") & distinctive)
        self._sound = np.zeros(0, dtype=np.intp)  # edges that have been followed and are as they should be
        self._source = np.full(size, -1, dtype=np.intp)  # from which neighbour a pose has been reached
        self._seeds, self._seed_q = np.zeros(0, dtype=np.intp), np.zeros((0, q.shape[-1]))  # reached from random starts
        self._tried = {mode: np.zeros((2 * reached.ndim, size), dtype=bool) for mode in (ZERO_MODE, OTHER_MODE)}

    @property
    def robot(self) -> Robot:
        """The robot, which is built only when something must be followed."""
        return self.spec.robot(self.combination)

    @property
    def count(self) -> int:
        """Number of poses that are reached."""
        return int(np.sum(self.mode == ZERO_MODE))

    @cached_property
    def values(self) -> dict[str, Array]:
        """The given coordinates (N,) of all poses."""
        return self.spec.coordinates(self.region)

    def at(self, which: Index) -> dict[str, Array]:
        """Return the given coordinates of some poses."""
        return {name: array[which] for name, array in self.values.items()}

    def set(self, which: Index, q: Array, mode: int, source: Index | int = -1) -> None:
        """Say where poses are, in which mode, and from which neighbour they have been reached."""
        self.q[which], self.mode[which], self._source[which] = q, mode, source
        self._sound = self._sound[~np.isin(np.divmod(self._sound, self.mode.size), which).any(axis=0)]

    # ---- following --------------------------------------------------------------------------------------------------

    def follow(
        self, starts: Array | None, first: Mapping[str, Array | float], targets: dict[str, Array], steps: int = 1
    ) -> tuple[Array, Mask]:
        """Follow straight lines in so many steps; return where they end, and whether they arrive.

        Args:
            starts: (n, nq) poses; None: the zero pose.
            first: their coordinates.
            targets: coordinates (n,) to be reached.
            steps: how many.
        """
        count = len(next(iter(targets.values())))
        q = np.full((count, self.q.shape[1]), np.nan) if starts is None else starts.copy()
        alive = np.arange(count)
        for left in reversed(range(steps)):
            goal = {name: (end - (end - first[name]) * left / steps)[alive] for name, end in targets.items()}
            near = None
            if starts is not None or left < steps - 1:
                near = self.robot.configuration(q[alive, : self.nq], closure_tolerance=np.inf, on_failure="nan")
            found = self.spec.assemble(self.robot, goal, near)
            arrived = np.asarray(found.status != Status.UNREACHABLE)
            alive = alive[arrived]
            q[alive, : self.nq] = found.q[arrived]
            if q.shape[1] > self.nq:
                place = found.platform_coordinates(self.spec.orientation)
                q[alive, self.nq :] = np.stack([place[name] for name in "xyz"], axis=-1)[arrived]
            if not alive.size:
                break
        return q, np.isin(np.arange(count), alive)

    def follow_from_zero(self, which: Index) -> tuple[Array, Mask]:
        """Follow the straight lines from the zero pose to poses in small steps."""
        targets, zero = self.at(which), self.zero_coordinates()
        return self.follow(None, {name: zero.get(name, targets[name]) for name in targets}, targets, STEPS)

    def zero_coordinates(self) -> dict[str, float]:
        """Return the zero pose's coordinates, without an azimuth if it is not tilted."""
        zero = self.robot.configuration(self.robot.model_q(self.robot.zero_poses)[:, 0], closure_tolerance=np.inf)
        if self.spec.kind != "platform":
            return {name: float(value) for name, value in zero.actuators.items()}
        found = {name: float(value) for name, value in zero.platform_coordinates(self.spec.orientation).items()}
        if self.spec.orientation == "tilt_torsion" and abs(found["tilt"]) < 1e-9:
            del found["azimuth"]
        return found

    # ---- 1: other modes ---------------------------------------------------------------------------------------------

    def suspects(self) -> Edges:
        """Return the edges whose steps are too large."""
        found = suspect_edges(self.q.reshape(*self.shape, -1), (self.mode == ZERO_MODE).reshape(self.shape), self.scale)
        return found.where(~np.isin(found.first * self.mode.size + found.second, self._sound))

    def examine(self, edges: Edges) -> tuple[Edges, Mask]:
        """Follow edges, in small steps where one does not do; return those that fail, and which of them lead elsewhere."""
        elsewhere = np.zeros(0, dtype=bool)
        for steps in (1, FINE):
            if len(edges):
                ends, arrived = self.follow(self.q[edges.first], self.at(edges.first), self.at(edges.second), steps)
                step = self.scale.difference(self.q[edges.first], self.q[edges.second])
                same = arrived & (self.scale.difference(ends, self.q[edges.second]) < ALIKE + ALIKE_PART * step)
                self._sound = np.append(self._sound, (edges.first * self.mode.size + edges.second)[same])
                edges = edges.where(~same)
                elsewhere = arrived[~same]
        return edges, elsewhere

    def jumps(self) -> int:
        """Return the number of edges that lead to another mode."""
        return int(self.examine(self.suspects())[1].sum())

    def take_back(self) -> int:
        """Take back poses that are not in the mode of the zero pose, and return how many.

        Those on the straight line from the zero pose are followed again in small steps. A way from neighbour to neighbour may
        have passed a singular pose: what was reached on it goes, and what was reached from there.
        """
        edges, elsewhere = self.examine(self.suspects())
        if not len(edges):
            return 0
        wrong = np.zeros(self.mode.size, dtype=bool)
        seen = self._source >= 0
        ask = np.unique([edges.first, edges.second])
        while (ask := ask[~seen[ask]]).size:
            seen[ask] = True
            ends, arrived = self.follow_from_zero(ask)
            right = arrived & (self.scale.difference(ends, self.q[ask]) < ALIKE)
            wrong[ask[~right]] = True
            moved = arrived & ~right
            self.set(ask[~right], self.q[ask[~right]], OTHER_MODE)
            self.set(ask[moved], ends[moved], ZERO_MODE)
            ask = self._beside(ask[~right])
        from_neighbours = self._source >= 0
        for this, other in ((edges.first, edges.second), (edges.second, edges.first)):
            wrong[this[from_neighbours[this] & elsewhere & ~wrong[other]]] = True
        while np.any(more := from_neighbours & wrong[self._source] & ~wrong):
            wrong |= more
        gone = np.flatnonzero(wrong & from_neighbours)
        # a neighbour that stays must not mislead them again; those that go may be right the next time
        self._tried[ZERO_MODE][:, gone[wrong[self._source[gone]]]] = False
        self.set(gone, self.q[gone], OTHER_MODE)
        self.retracted |= wrong
        return int(wrong.sum())

    def _beside(self, which: Index) -> Index:
        """Return the reached poses beside some."""
        there, found = np.zeros(self.shape, dtype=bool), np.zeros(self.shape, dtype=bool)
        there.ravel()[which] = True
        for _, lower, upper in neighbours(self.shape):
            found[lower] |= there[upper]
            found[upper] |= there[lower]
        return np.flatnonzero(found.ravel() & (self.mode == ZERO_MODE))

    # ---- 2: from neighbour to neighbour -----------------------------------------------------------------------------

    def try_some(self) -> bool:
        """Try some poses from neighbours, and some from random starts; return whether any is reached from a neighbour.

        All at once, because a call is costly.
        """
        left = np.flatnonzero(self.mode == NO_MODE)
        if not left.size:
            return False
        targets, starts, ways = self._ring(ZERO_MODE)
        if targets.size > PROBES:
            some = np.linspace(0, targets.size - 1, PROBES).astype(np.intp)
            targets, starts, ways = targets[some], starts[some], ways[some]
        count = int(np.clip(self.mode.size // ONE_IN, LEAST, MOST))
        at = np.concatenate([targets, np.random.default_rng(3).choice(left, count)])
        by_chance = self._padded(open_starts(self.robot, self.units, count))
        ends, arrived = self.follow(np.concatenate([self.q[starts], by_chance]), self.at(at), self.at(at))
        self._tried[ZERO_MODE][ways, targets] = True
        hit = np.flatnonzero(arrived[: targets.size])
        self.set(at[hit], ends[hit], ZERO_MODE, starts[hit])
        hit = np.flatnonzero(arrived[targets.size :]) + targets.size
        self._seeds, self._seed_q = at[hit], ends[hit]
        return bool(np.any(arrived[: targets.size]))

    def _padded(self, starts: Array) -> Array:
        """Return model coordinates (n, nq) with places for what stands behind them in :attr:`q`."""
        return np.pad(starts, ((0, 0), (0, self.q.shape[1] - self.nq)))

    def spread(self, mode: int, everywhere: bool = True) -> None:
        """Reach neighbours of the poses in a mode, ring by ring, and their neighbours; each from each of them once at most.

        ``everywhere`` False: only those between two that are reached. That such a pose is out of reach is so unlikely that one
        failure does not prove it.
        """
        while (ring := self._ring(mode, everywhere))[0].size:
            targets, starts, ways = ring
            self._tried[mode][ways, targets] = True
            for steps, mine in ((1, ~self.retracted[targets]), (FINE, self.retracted[targets])):
                if np.any(mine):
                    to, by = targets[mine], starts[mine]
                    ends, arrived = self.follow(self.q[by], self.at(by), self.at(to), steps)
                    self.set(to[arrived], ends[arrived], mode, by[arrived])

    def _ring(self, mode: int, everywhere: bool = True) -> tuple[Index, Index, Index]:
        """Return poses beside those in a mode, for each a neighbour in it, and which of its neighbours that is.

        A pose that could not be reached from one of its neighbours is tried again only from those that have been reached since,
        and one between two that are in the mode from all its neighbours.
        """
        numbers = np.arange(self.mode.size).reshape(self.shape)
        start = np.full(self.mode.size, -1, dtype=np.intp)
        way = np.zeros(self.mode.size, dtype=np.intp)
        # poses in another mode are tried for the zero mode too
        wanted = self.mode == NO_MODE if mode == OTHER_MODE else self.mode != ZERO_MODE
        new, tried, there = self._source >= 0, self._tried[mode], self.mode == mode
        between = np.zeros(self.mode.size, dtype=bool)
        if mode == ZERO_MODE:
            for _, lower, upper in neighbours(self.shape):
                between[numbers[upper][lower]] |= there[numbers[lower][lower]] & there[numbers[upper][upper]]
        again = between | self.retracted | ~np.any(tried, axis=0) if everywhere else between
        for axis, lower, upper in neighbours(self.shape):
            for side, (to, by) in enumerate(((upper, lower), (lower, upper))):
                target, source, k = numbers[to].ravel(), numbers[by].ravel(), 2 * axis + side
                fit = wanted[target] & there[source] & ~tried[k, target] & (start[target] < 0)
                fit &= again[target] | (new[source] & everywhere)
                start[target[fit]], way[target[fit]] = source[fit], k
        targets = np.flatnonzero(start >= 0)
        return targets, start[targets], way[targets]

    # ---- 3: what only other modes reach -----------------------------------------------------------------------------

    def try_other_modes(self) -> None:
        """Mark poses that other modes reach, and their neighbours; their numbers stay NaN."""
        left = np.flatnonzero(self.mode == NO_MODE)
        mine = self.mode[self._seeds] == NO_MODE
        self.set(self._seeds[mine], self._seed_q[mine], OTHER_MODE)
        if left.size > MUCH * self.mode.size and not np.any(self.mode == OTHER_MODE):
            count = min(left.size, SEARCH)
            starts = open_starts(self.robot, self.units, count, seed=5)
            if self.spec.kind == "platform":
                starts = np.concatenate([starts, closed_starts(self.robot, count, self.spec.closure_tolerance)])
            targets = np.random.default_rng(4).choice(left, len(starts))
            ends, arrived = self.follow(self._padded(starts), self.at(targets), self.at(targets))
            self.set(targets[arrived], ends[arrived], OTHER_MODE)
        if np.any(self.mode == OTHER_MODE):
            self.spread(OTHER_MODE)

    # ---- what comes of it -------------------------------------------------------------------------------------------

    def numbers(self, which: Index, cases: Block) -> dict[str, Values]:
        """Return the variables of poses, as they are now."""
        q = np.where((self.mode[which] == ZERO_MODE)[:, None], self.q[which, : self.nq], np.nan)
        with np.errstate(invalid="ignore"):
            configuration = self.robot.configuration(q, closure_tolerance=self.spec.closure_tolerance, on_failure="nan")
            found = pose_numbers(self.spec, self.labels, self.combination, configuration, cases, self.region, which)
        return {**found, "mode": self.mode[which]}
