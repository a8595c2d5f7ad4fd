"""A second look at the grid of one robot, once all its poses have been tried one by one.

The straight line from the zero pose may jump to another assembly mode where two of them come near each other, and it may leave
the workspace although the pose belongs to it. Both show only beside their neighbours:

1. Neighbours whose joints differ too much are told apart (:mod:`kinetostatics.workspace.continuity`). Of the parts into which the
   grid falls, those stay that small steps along the line from the zero pose reach; the others are taken back.
2. From the poses that are reached their neighbours are tried, ring by ring, until nothing more is reached.
3. Of what is left a few are tried from random starts: poses that only another mode reaches are marked.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from kinetostatics.configuration import Status
from kinetostatics.workspace.compute import assemble, pose_numbers
from kinetostatics.workspace.continuity import (
    Edges,
    JointScale,
    connected_parts,
    grid_edges,
    neighbours,
    suspect_edges,
)
from kinetostatics.workspace.grid import Block
from kinetostatics.workspace.plan import Combination, Plan
from kinetostatics.workspace.schema import NO_MODE, OTHER_MODE, ZERO_MODE, Labels

if TYPE_CHECKING:
    from kinetostatics.configuration import Configuration

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Index = NDArray[np.intp]

#: Small steps along the line from the zero pose, to tell modes apart.
STEPS = 48
#: Poses of a ring that are tried first; if none of them is reached, the ring is given up.
PROBES = 48
#: Poses that are tried in other modes, and random starts of each.
SAMPLES, STARTS = 12, 4
#: Two ways to one pose end alike up to so much [rad], and that part of the step between its neighbours.
ALIKE, ALIKE_PART = 1e-5, 0.02


@dataclass(frozen=True, eq=False)
class Finished:
    """What the second look found.

    Attributes:
        which: flat numbers of the poses whose numbers change, in the region.
        numbers: their variables, as :func:`pose_numbers` returns them; None if none changes.
        mode: (…region) which mode reaches each pose.
        jumps: pairs of neighbours that are in different modes, in the end.
        retracted: how many poses had been reached in another mode.
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
        q: (…region, nq) model coordinates, NaN where not reached.
        reached: (…region).
    """
    look = _Look(plan, labels, combination, region, q, reached)
    look.take_back()
    look.spread(ZERO_MODE)
    look.try_other_modes()
    changed = np.flatnonzero((look.mode == ZERO_MODE) != reached.ravel())
    moved = np.flatnonzero((look.mode == ZERO_MODE) & reached.ravel() & look.retracted)
    which = np.union1d(changed, moved)
    jumps = look.jumps() if which.size else 0
    gained = int(np.sum((look.mode == ZERO_MODE) & ~reached.ravel()))
    mode = look.mode.reshape(reached.shape)
    return Finished(which, look.numbers(which, cases) if which.size else None, mode, jumps, int(look.retracted.sum()), gained)


class _Look:
    """The poses of a region, flat, and what is known of them."""

    def __init__(self, plan: Plan, labels: Labels, combination: Combination, region: Block, q: Array, reached: Mask) -> None:
        self.plan, self.labels, self.combination, self.region = plan, labels, combination, region
        self.shape = reached.shape
        self.q = q.reshape(reached.size, q.shape[-1]).copy()
        self.mode = np.where(reached.ravel(), ZERO_MODE, NO_MODE).astype(np.int8)
        self.retracted = np.zeros(reached.size, dtype=bool)
        self._robot_units = [unit for _, unit in labels.q]

    @property
    def robot(self) -> Any:
        return self.plan.robot(self.combination)

    @property
    def scale(self) -> JointScale:
        return JointScale.of(self.robot, self._robot_units)

    @property
    def values(self) -> dict[str, Array]:
        return self.plan.coordinates(self.region)

    # ---- following --------------------------------------------------------------------------------------------------

    def follow(self, starts: Array, targets: dict[str, Array]) -> tuple[Array, Mask]:
        """Follow straight lines from poses ``starts`` (n, nq); return where they end, and whether they arrive."""
        robot = self.robot
        near = robot.configuration(starts, tolerance=np.inf, on_failure="nan")
        return _ends(assemble(self.plan, robot, targets, near))

    def at(self, which: Index) -> dict[str, Array]:
        """Return the coordinates of poses."""
        return {name: array[which] for name, array in self.values.items()}

    # ---- 1: other modes ---------------------------------------------------------------------------------------------

    def suspects(self) -> Edges:
        """Return the edges whose steps are too large."""
        reached = (self.mode == ZERO_MODE).reshape(self.shape)
        # lengths must be comparable to angles, for which the robot's own length is not needed to such precision
        return suspect_edges(self.q.reshape(*self.shape, -1), reached, self._rough_scale)

    @property
    def _rough_scale(self) -> JointScale:
        """A scale that needs no robot, whose building would cost more than the look: lengths by their own spread."""
        lengths = np.array([unit == "m" for unit in self._robot_units], dtype=bool)
        some = self.q[self.mode == ZERO_MODE]
        spread = np.ptp(some, axis=0) if len(some) else np.ones(len(lengths))
        return JointScale(
            np.where(lengths, 1 / np.maximum(spread, 1e-9), 1.0),
            np.array([unit == "rad" for unit in self._robot_units], dtype=bool),
        )

    def examine(self, edges: Edges) -> tuple[Mask, Mask]:
        """Follow edges; return which lead from one pose to the other, and which lead elsewhere."""
        scale = self.scale
        ends, arrived = self.follow(self.q[edges.first], self.at(edges.second))
        step = scale.difference(self.q[edges.first], self.q[edges.second])
        same = arrived & (scale.difference(ends, self.q[edges.second]) < self._alike(step))
        return same, arrived & ~same

    def _alike(self, step: Array) -> Array:
        part = 0.25 if self.robot.mobility.local else ALIKE_PART  # a strut may spin by its own way
        return ALIKE + part * step

    def jumps(self) -> int:
        """Return the number of edges that lead to another mode."""
        edges = self.suspects()
        return int(self.examine(edges)[1].sum()) if len(edges) else 0

    def take_back(self) -> None:
        """Take back poses that are not in the mode of the zero pose."""
        suspects = self.suspects()
        if not len(suspects):
            return
        same, _ = self.examine(suspects)
        if np.all(same):
            return
        size = self.mode.size
        everything = grid_edges((self.mode == ZERO_MODE).reshape(self.shape))
        broken = suspects.first[~same] * size + suspects.second[~same]
        whole = ~np.isin(everything.first * size + everything.second, broken)
        parts = connected_parts(size, Edges(everything.first[whole], everything.second[whole]))
        reached = np.flatnonzero(self.mode == ZERO_MODE)
        names, counts = np.unique(parts[reached], return_counts=True)
        good = self._is_zero_mode(parts, names)
        if not np.any(good):
            good = counts == counts.max()
        wrong = reached[~np.isin(parts[reached], names[good])]
        self.retracted[wrong] = True
        self.mode[wrong] = OTHER_MODE

    def _is_zero_mode(self, parts: Index, names: Index) -> Mask:
        """Return which parts of the grid small steps from the zero pose reach, at the pose that is nearest to it."""
        zero, distance = self._from_zero()
        order = np.lexsort((distance, parts))
        order = order[self.mode[order] == ZERO_MODE]
        nearest = order[np.searchsorted(parts[order], names)]
        targets = self.at(nearest)
        start = {name: np.where(np.isnan(zero[name]), targets[name], zero[name]) for name in targets}
        alive = np.arange(len(names))
        q = np.zeros((len(names), self.q.shape[1]))
        for step in range(1, STEPS + 1):
            goal = {name: (start[name] + (targets[name] - start[name]) * step / STEPS)[alive] for name in targets}
            if step == 1:
                ends, arrived = _ends(assemble(self.plan, self.robot, goal))
            else:
                ends, arrived = self.follow(q[alive], goal)
            alive = alive[arrived]
            q[alive] = ends[arrived]
            if not alive.size:
                break
        good = np.zeros(len(names), dtype=bool)
        difference = self.scale.difference(q[alive], self.q[nearest[alive]])
        good[alive] = difference < (0.1 if self.robot.mobility.local else ALIKE)
        return good

    def _from_zero(self) -> tuple[dict[str, float], Array]:
        """Return the zero pose's coordinates (NaN: those of the target), and how far from it each pose is."""
        robot = self.robot
        zero = robot.configuration(robot.model_q(robot.zero_poses)[:, 0], tolerance=np.inf)
        if self.plan.kind == "platform":
            found = {name: float(value) for name, value in zero.platform_coordinates(self.plan.orientation).items()}
            if self.plan.orientation == "tilt_torsion" and abs(found["tilt"]) < 1e-9:
                found["azimuth"] = np.nan  # an untilted pose has none
        else:
            found = {name: float(value) for name, value in zero.actuators.items()}
        distance = np.zeros(self.mode.size)
        for name, values in self.values.items():
            span = float(np.ptp(values)) or 1.0
            distance += np.nan_to_num((values - found[name]) / span) ** 2
        return found, distance

    # ---- 2: from neighbour to neighbour -----------------------------------------------------------------------------

    def spread(self, mode: int) -> None:
        """Reach neighbours of the poses in a mode, ring by ring, and their neighbours; each from each of them once at most."""
        tried = np.zeros((2 * len(self.shape), self.mode.size), dtype=bool)
        probing = True
        while True:
            targets, starts, ways = self._ring(mode, tried)
            if not targets.size:
                return
            if probing and targets.size > PROBES:
                some = np.linspace(0, targets.size - 1, PROBES).astype(np.intp)
                targets, starts, ways = targets[some], starts[some], ways[some]
            tried[ways, targets] = True
            ends, arrived = self.follow(self.q[starts], self.at(targets))
            if not np.any(arrived):
                return
            probing = False
            self.q[targets[arrived]] = ends[arrived]
            self.mode[targets[arrived]] = mode

    def _ring(self, mode: int, tried: Mask) -> tuple[Index, Index, Index]:
        """Return poses beside those in a mode, for each a neighbour in it, and which of its neighbours that is."""
        numbers = np.arange(self.mode.size).reshape(self.shape)
        start = np.full(self.mode.size, -1, dtype=np.intp)
        way = np.zeros(self.mode.size, dtype=np.intp)
        # poses in another mode are tried for the zero mode too
        wanted = self.mode == NO_MODE if mode == OTHER_MODE else self.mode != ZERO_MODE
        for axis, lower, upper in neighbours(self.shape):
            for side, (to, by) in enumerate(((upper, lower), (lower, upper))):
                target, source, k = numbers[to].ravel(), numbers[by].ravel(), 2 * axis + side
                fit = wanted[target] & (self.mode[source] == mode) & ~tried[k, target] & (start[target] < 0)
                start[target[fit]], way[target[fit]] = source[fit], k
        targets = np.flatnonzero(start >= 0)
        return targets, start[targets], way[targets]

    # ---- 3: what only other modes reach -----------------------------------------------------------------------------

    def try_other_modes(self) -> None:
        """Mark poses that are reached from random starts, and their neighbours; their numbers stay NaN."""
        left = np.flatnonzero(self.mode == NO_MODE)
        if left.size and not np.any(self.mode == OTHER_MODE):
            some = left[np.linspace(0, left.size - 1, min(SAMPLES, left.size)).astype(np.intp)]
            targets = np.repeat(some, STARTS)
            ends, arrived = self.follow(self._random_starts(targets.size), self.at(targets))
            self.q[targets[arrived]] = ends[arrived]
            self.mode[targets[arrived]] = OTHER_MODE
        if np.any(self.mode == OTHER_MODE):
            self.spread(OTHER_MODE)

    def _random_starts(self, count: int) -> Array:
        """Return random model coordinates (n, nq) within limits, loops open, always the same ones."""
        robot = self.robot
        random = np.random.default_rng(1)
        model = robot.model
        zero = robot.model_q(robot.zero_poses)[:, 0]
        reach = np.where([unit == "m" for unit in self._robot_units], robot.length, np.pi)
        lower = np.maximum(np.asarray(model.lowerPositionLimit), zero - reach)
        upper = np.minimum(np.asarray(model.upperPositionLimit), zero + reach)
        q = random.uniform(np.minimum(lower, upper), np.maximum(lower, upper), (count, len(zero)))
        for first, size in zip(list(model.idx_qs), list(model.nqs), strict=True):
            if size == 2:
                angle = random.uniform(-np.pi, np.pi, count)
                q[:, first], q[:, first + 1] = np.cos(angle), np.sin(angle)
            elif size > 2:
                q[:, first : first + size] = zero[first : first + size]
        return np.asarray(q)

    # ---- what comes of it -------------------------------------------------------------------------------------------

    def numbers(self, which: Index, cases: Block) -> dict[str, NDArray[Any]]:
        """Return the variables of poses, as they are now."""
        plan = self.plan
        q = np.where((self.mode[which] == ZERO_MODE)[:, None], self.q[which], np.nan)
        with np.errstate(invalid="ignore"):
            configuration = self.robot.configuration(q, tolerance=plan.tolerance, on_failure="nan")
            found = pose_numbers(plan, self.labels, self.combination, configuration, cases, self.region, which)
        found["mode"] = self.mode[which]
        return found


def _ends(configuration: Configuration) -> tuple[Array, Mask]:
    return configuration.q, np.asarray(configuration.status != Status.UNREACHABLE)
