"""A second look at the grid of one robot, once all its poses have been tried one by one.

The straight line from the zero pose may jump to another assembly mode where two of them come near each other, and it may leave
the workspace although the pose belongs to it. Both show only beside their neighbours:

1. Neighbours whose joints differ too much are told apart (:mod:`kinetostatics.workspace.assembly_modes.continuity`). Of the parts
   into which the grid falls, those stay that small steps along the line from the zero pose reach; the others are taken back.
2. From the poses that are reached their neighbours are tried, ring by ring, until nothing more is reached.
3. Of what is left a few are tried from random starts: poses that only another mode reaches are marked.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetostatics.math.arrays import Array
from kinetostatics.workspace.assembly_modes.continuity import Edges, connected_parts, grid_edges, neighbours
from kinetostatics.workspace.assembly_modes.following import FINE, Poses
from kinetostatics.workspace.assembly_modes.other_modes import closed_starts, open_starts
from kinetostatics.workspace.block import pose_numbers
from kinetostatics.workspace.grid import Block
from kinetostatics.workspace.plan import Combination, Plan
from kinetostatics.workspace.schema import NO_MODE, OTHER_MODE, ZERO_MODE, Labels

Mask = NDArray[np.bool_]
Index = NDArray[np.intp]

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
    numbers: dict[str, NDArray[Any]] | None
    mode: NDArray[np.int8]
    jumps: int
    retracted: int
    gained: int


def finish(
    plan: Plan, labels: Labels, combination: Combination, cases: Block, region: Block, q: Array, reached: Mask
) -> Finished:
    """Look at a region of the coordinate axes for one robot.

    Args:
        plan: of the sweep.
        labels: of the Dataset.
        combination: the robot.
        cases: which cases of loads are wanted.
        region: of the coordinate axes.
        q: (…region, nq) model coordinates as :func:`joint_state` returns them, NaN where not reached.
        reached: (…region).
    """
    look = _Look(plan, labels, combination, region, q, reached)
    seen = look.glance()
    for _ in range(ROUNDS if seen != "nothing" else 0):
        wrong = look.take_back()
        if wrong or seen == "gained":
            look.spread(ZERO_MODE)
        if not look.fill() and not wrong:
            break
    look.try_other_modes()
    changed = np.flatnonzero((look.mode == ZERO_MODE) != reached.ravel())
    moved = np.flatnonzero((look.mode == ZERO_MODE) & reached.ravel() & look.retracted)
    which = np.union1d(changed, moved)
    jumps = look.jumps() if which.size else 0
    gained = int(np.sum((look.mode == ZERO_MODE) & ~reached.ravel()))
    retracted = int(np.sum(look.retracted & reached.ravel()))
    mode = look.mode.reshape(reached.shape)
    return Finished(which, look.numbers(which, cases) if which.size else None, mode, jumps, retracted, gained)


class _Look(Poses):
    """Poses, and what has been tried with them."""

    def __init__(self, plan: Plan, labels: Labels, combination: Combination, region: Block, q: Array, reached: Mask) -> None:
        super().__init__(plan, labels, combination, region, q, reached)
        self.retracted = np.zeros(reached.size, dtype=bool)
        self._source = np.full(reached.size, -1, dtype=np.intp)  # from which neighbour a pose has been reached
        self._seeds, self._seed_q = np.zeros(0, dtype=np.intp), np.zeros((0, q.shape[-1]))  # reached from random starts
        self._tried = {mode: np.zeros((2 * reached.ndim, reached.size), dtype=bool) for mode in (ZERO_MODE, OTHER_MODE)}

    def glance(self) -> str:
        """Follow suspect edges, and try poses from neighbours and from random starts: all at once, because a call is costly.

        Returns:
            "nothing" to look at, "something", or "gained": poses are reached from neighbours.
        """
        suspects = self.suspects()
        left = np.flatnonzero(self.mode == NO_MODE)
        if not left.size and not len(suspects):
            return "nothing"
        targets, starts, ways = self._ring(ZERO_MODE, self._tried[ZERO_MODE])
        if targets.size > PROBES:
            some = np.linspace(0, targets.size - 1, PROBES).astype(np.intp)
            targets, starts, ways = targets[some], starts[some], ways[some]
        count = int(np.clip(self.mode.size // ONE_IN, LEAST, MOST)) if left.size else 0
        tries = np.random.default_rng(3).choice(left, count) if count else left
        at = np.concatenate([suspects.second, targets, tries])
        by_chance = open_starts(self.robot, self.units[: self.nq], count)
        near = self.q[np.concatenate([suspects.first, starts]), : self.nq]
        ends, arrived = self.follow(np.concatenate([near, by_chance]), self.at(at))
        edges, ring, chance = np.split(np.arange(at.size), [len(suspects), len(suspects) + targets.size])
        same = self.is_there(suspects, ends[edges], arrived[edges])
        self.sound = suspects.first[same] * self.mode.size + suspects.second[same]
        hit = chance[arrived[chance]]
        self._seeds, self._seed_q = at[hit], ends[hit]
        self._tried[ZERO_MODE][ways, targets] = True
        hit = ring[arrived[ring]]
        self.set(at[hit], ends[hit], ZERO_MODE)
        self._source[at[hit]] = starts[arrived[ring]]
        return "gained" if hit.size else "something"

    # ---- 1: other modes ---------------------------------------------------------------------------------------------

    def take_back(self) -> int:
        """Take back poses that are not in the mode of the zero pose, and return how many."""
        suspects = self.suspects()
        if not len(suspects):
            return 0
        same, elsewhere = self.examine(suspects)
        codes = suspects.first * self.mode.size + suspects.second
        self.sound = np.concatenate([self.sound, codes[same]])
        if np.all(same):
            return 0
        size = self.mode.size
        everything = grid_edges((self.mode == ZERO_MODE).reshape(self.shape))
        whole = ~np.isin(everything.first * size + everything.second, codes[~same])
        parts = connected_parts(size, Edges(everything.first[whole], everything.second[whole]))
        reached = np.flatnonzero(self.mode == ZERO_MODE)
        names, counts = np.unique(parts[reached], return_counts=True)
        good = self._is_zero_mode(parts, names)
        if not np.any(good):
            good = counts == counts.max()
        wrong = reached[~np.isin(parts[reached], names[good])]
        at_odds = elsewhere & ~np.isin(suspects.first, wrong) & ~np.isin(suspects.second, wrong)
        wrong = np.union1d(wrong, self._at_odds(Edges(suspects.first[at_odds], suspects.second[at_odds]), everything))
        self.retracted[wrong] = True
        self.set(wrong, self.q[wrong], OTHER_MODE)
        # a neighbour that stays must not mislead them again; those that go may be right the next time
        misled = (self._source[wrong] >= 0) & ~np.isin(self._source[wrong], wrong)
        self._tried[ZERO_MODE][:, wrong[~misled]] = False
        self._source[wrong] = -1
        return len(wrong)

    def _at_odds(self, edges: Edges, everything: Edges) -> Index:
        """Return which ends of edges to give up that lead elsewhere although their ends are connected by other edges.

        Poses on the straight line from the zero pose must be reached in small steps. A way from neighbour to neighbour may have
        passed a singular pose: what was reached on it goes, and of two such ends that most of whose edges lead elsewhere.
        """
        size = self.mode.size
        wrong = np.zeros(size, dtype=bool)
        by_neighbour = self._source >= 0
        ends = np.unique([edges.first, edges.second])
        straight = ends[~by_neighbour[ends]]
        if straight.size:
            wrong[straight] = ~self.is_reached_finely(straight)
        bad, total = (np.bincount(np.concatenate([e.first, e.second]), minlength=size) for e in (edges, everything))
        part = bad / np.maximum(total, 1)
        for this, other in ((edges.first, edges.second), (edges.second, edges.first)):
            undecided = by_neighbour[this] & ~wrong[other]
            worse = ~by_neighbour[other] | (part[this] >= part[other])
            wrong[this[undecided & worse]] = True
        while True:  # and what was reached from there
            more = wrong | (by_neighbour & wrong[self._source])
            if np.array_equal(more, wrong):
                return np.flatnonzero(wrong)
            wrong = more

    def _is_zero_mode(self, parts: Index, names: Index) -> Mask:
        """Return which parts of the grid small steps from the zero pose reach, at the pose that is nearest to it."""
        _, distance = self.from_zero()
        order = np.lexsort((distance, parts))
        order = order[self.mode[order] == ZERO_MODE]
        nearest = order[np.searchsorted(parts[order], names)]
        return self.is_reached_finely(nearest)

    # ---- 2: from neighbour to neighbour -----------------------------------------------------------------------------

    def spread(self, mode: int) -> None:
        """Reach neighbours of the poses in a mode, ring by ring, and their neighbours; each from each of them once at most."""
        tried = self._tried[mode]
        while True:
            targets, starts, ways = self._ring(mode, tried)
            if not targets.size:
                return
            tried[ways, targets] = True
            ends, arrived = np.empty((targets.size, self.q.shape[1])), np.zeros(targets.size, dtype=bool)
            for steps, mine in ((1, ~self.retracted[targets]), (FINE, self.retracted[targets])):
                if np.any(mine):
                    first, goal = self.at(starts[mine]), self.at(targets[mine])
                    ends[mine], arrived[mine] = self.follow_finely(self.q[starts[mine]], first, goal, steps)
            if not np.any(arrived):
                return
            self.set(targets[arrived], ends[arrived], mode)
            self._source[targets[arrived]] = starts[arrived]

    def fill(self) -> int:
        """Reach poses between two that are reached, from any of their neighbours, and return how many.

        That such a pose is out of reach is so unlikely that one failure does not prove it.
        """
        before = int(np.sum(self.mode == ZERO_MODE))
        tried = self._tried[ZERO_MODE]
        while True:
            targets, starts, ways = self._ring(ZERO_MODE, tried, between=True)
            if not targets.size:
                return int(np.sum(self.mode == ZERO_MODE)) - before
            tried[ways, targets] = True
            ends, arrived = self.follow_finely(self.q[starts], self.at(starts), self.at(targets), 1)
            self.set(targets[arrived], ends[arrived], ZERO_MODE)
            self._source[targets[arrived]] = starts[arrived]

    def _ring(self, mode: int, tried: Mask, between: bool = False) -> tuple[Index, Index, Index]:
        """Return poses beside those in a mode, for each a neighbour in it, and which of its neighbours that is.

        A pose that could not be reached from one of its neighbours is tried again only from those that have been reached since;
        ``between``: only those between two that are in the mode, from all their neighbours.
        """
        numbers = np.arange(self.mode.size).reshape(self.shape)
        start = np.full(self.mode.size, -1, dtype=np.intp)
        way = np.zeros(self.mode.size, dtype=np.intp)
        # poses in another mode are tried for the zero mode too
        wanted = self.mode == NO_MODE if mode == OTHER_MODE else self.mode != ZERO_MODE
        new = self._source >= 0
        first = self.retracted | ~np.any(tried, axis=0)
        if between:
            first = self._between(mode)
            wanted &= first & ~self.retracted
        for axis, lower, upper in neighbours(self.shape):
            for side, (to, by) in enumerate(((upper, lower), (lower, upper))):
                target, source, k = numbers[to].ravel(), numbers[by].ravel(), 2 * axis + side
                fit = wanted[target] & (self.mode[source] == mode) & ~tried[k, target] & (start[target] < 0)
                fit &= new[source] | first[target]
                start[target[fit]], way[target[fit]] = source[fit], k
        targets = np.flatnonzero(start >= 0)
        return targets, start[targets], way[targets]

    def _between(self, mode: int) -> Mask:
        """Return which poses have a neighbour in a mode on both sides, along one of the axes."""
        there = (self.mode == mode).reshape(self.shape)
        found = np.zeros(self.shape, dtype=bool)
        for _, lower, upper in neighbours(self.shape):
            before, after = np.zeros((2, *self.shape), dtype=bool)
            before[upper], after[lower] = there[lower], there[upper]
            found |= before & after
        return found.ravel()

    # ---- 3: what only other modes reach -----------------------------------------------------------------------------

    def try_other_modes(self) -> None:
        """Mark poses that other modes reach, and their neighbours; their numbers stay NaN."""
        left = np.flatnonzero(self.mode == NO_MODE)
        mine = self.mode[self._seeds] == NO_MODE
        self.set(self._seeds[mine], self._seed_q[mine], OTHER_MODE)
        if left.size > MUCH * self.mode.size and not np.any(self.mode == OTHER_MODE):
            count = min(left.size, SEARCH)
            random = np.random.default_rng(4)
            starts = open_starts(self.robot, self.units[: self.nq], count, seed=5)
            if self.plan.kind == "platform":
                starts = np.concatenate([starts, closed_starts(self.robot, count, self.plan.tolerance)])
            targets = random.choice(left, len(starts))
            ends, arrived = self.follow(starts, self.at(targets))
            self.set(targets[arrived], ends[arrived], OTHER_MODE)
        if np.any(self.mode == OTHER_MODE):
            self.spread(OTHER_MODE)

    # ---- what comes of it -------------------------------------------------------------------------------------------

    def numbers(self, which: Index, cases: Block) -> dict[str, NDArray[Any]]:
        """Return the variables of poses, as they are now."""
        plan = self.plan
        q = np.where((self.mode[which] == ZERO_MODE)[:, None], self.q[which, : self.nq], np.nan)
        with np.errstate(invalid="ignore"):
            configuration = self.robot.configuration(q, tolerance=plan.tolerance, on_failure="nan")
            found = pose_numbers(plan, self.labels, self.combination, configuration, cases, self.region, which)
        found["mode"] = self.mode[which]
        return found
