"""Continuity of the assembly mode along the grid of one robot.

Each pose is first assembled at the end of the straight line from the zero pose, on which the prescribed coordinates (of platform
or actuators) change linearly. A straight line may lead to another assembly mode if two modes are close, and it may leave the
workspace although its end is inside. Both cases are detected by comparison with neighbouring poses of the grid:

1. Joint coordinates are continuous functions of the prescribed coordinates, so that their steps between neighbours vary little.
Where a step is much larger than adjacent steps, the straight line between its two poses is followed. If it ends at a third pose,
the two poses are assembled again from the zero pose in small steps; where a pose changes, its neighbours are assembled again,
too. A pose found in another mode is retracted: it counts as not reached. 2. Poses that are not reached are assembled from reached
neighbours, until no more poses are reached.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from kinetostatics.math.arrays import Array, Index, Mask
from kinetostatics.robot import Robot
from kinetostatics.status import Status
from kinetostatics.workspace.dataset import Labels
from kinetostatics.workspace.grid import Block
from kinetostatics.workspace.sweep_plan import SweepPlan

Single = NDArray[np.float32]

#: Numbers of small steps on a straight line from the zero pose, and between neighbours.
STEPS, FINE = 48, 8
#: Largest difference of a pose reached on two paths: absolute [rad], and relative to the step between neighbours.
ALIKE, ALIKE_PART = 1e-5, 0.02
#: Largest number of rounds of retraction and continuation.
ROUNDS = 5
#: Number of neighbours of reached poses that are tried first; if none is reached, the others are skipped.
PROBES = 200
#: A step is suspect if it differs from an adjacent step by more than BESIDE × the smaller of both + USUAL × the median step.
BESIDE, USUAL = 0.5, 0.2
#: A step without adjacent steps is suspect if it exceeds LARGE times the median.
LARGE = 4.0
#: Largest scaled difference [rad] of two equal poses.
SAME = 1e-6


@dataclass(frozen=True, eq=False)
class JointScale:
    """Scale of differences between poses: lengths are divided by the characteristic length, full turns are ignored.

    Attributes:
        weights: (k,) factors of the k compared coordinates.
        angles: (k,) True for coordinates that are angles.
    """

    weights: Array
    angles: Mask

    def difference(self, first: Array, second: Array) -> Array:
        """Return the largest scaled difference (…) between two poses with coordinates (…, k) [rad]; NaN where not reached."""
        gap = (second - first) * self.weights
        gap = np.abs(np.where(self.angles, gap - 2 * np.pi * np.round(gap / (2 * np.pi)), gap))
        return np.asarray(gap.max(axis=-1)) if gap.shape[-1] else np.zeros(gap.shape[:-1])


@dataclass(frozen=True, eq=False)
class Edges:
    """Pairs of neighbouring poses on a grid, by flat indices."""

    first: Index
    second: Index

    def __len__(self) -> int:
        return len(self.first)

    def where(self, chosen: Mask) -> Edges:
        return Edges(self.first[chosen], self.second[chosen])


def neighbours(shape: Sequence[int]) -> Iterator[tuple[int, tuple[slice, ...], tuple[slice, ...]]]:
    """Yield each axis with two indices of grid arrays: of the lower and of the upper pose of all neighbours along this axis."""
    for axis, size in enumerate(shape):
        if size > 1:
            everything = [slice(None)] * len(shape)
            lower, upper = list(everything), list(everything)
            lower[axis], upper[axis] = slice(0, -1), slice(1, None)
            yield axis, tuple(lower), tuple(upper)


def suspect_edges(q: Array, reached: Mask, scale: JointScale) -> Edges:
    """Return the edges whose steps are much larger than adjacent steps.

    Args:
        q: (…grid, k) compared coordinates, NaN where not reached.
        reached: (…grid) True where a pose is reached.
        scale: scale of differences.
    """
    # coordinates along the first axis, for speed; single precision is enough here
    joints = np.ascontiguousarray(np.moveaxis(q, -1, 0), dtype=np.float32)
    numbers = np.arange(reached.size).reshape(reached.shape)
    firsts, seconds = [np.zeros(0, dtype=np.intp)], [np.zeros(0, dtype=np.intp)]
    for axis, lower, upper in neighbours(reached.shape):
        both = np.moveaxis(reached[lower] & reached[upper], axis, 0)
        if np.any(both):
            suspect = np.moveaxis(_suspect(np.moveaxis(joints, axis + 1, 1), both, scale), 0, axis)
            firsts.append(numbers[lower][suspect])
            seconds.append(numbers[upper][suspect])
    return Edges(np.concatenate(firsts), np.concatenate(seconds))


def _suspect(joints: Single, both: Mask, scale: JointScale) -> Mask:
    """Return a mask (n − 1, …): True for steps along axis n of ``joints`` (k, n, …) that are much larger than adjacent steps.

    ``both`` (n − 1, …) is True where both poses of a step are reached.
    """
    step = np.zeros(both.shape, dtype=np.float32)
    turn = np.zeros((both.shape[0] - 1, *both.shape[1:]), dtype=np.float32)  # difference between consecutive steps
    for row, weight, circular in zip(joints, scale.weights, scale.angles, strict=True):
        gap = (row[1:] - row[:-1]) * np.float32(weight)
        if circular:
            gap[gap > np.pi] -= 2 * np.pi
            gap[gap < -np.pi] += 2 * np.pi
        np.fmax(step, np.abs(gap), out=step)
        np.fmax(turn, np.abs(gap[1:] - gap[:-1]), out=turn)
    usual = float(np.median(step[both]))
    pair = both[1:] & both[:-1]
    odd = ~pair | (turn > BESIDE * np.minimum(step[1:], step[:-1]) + USUAL * usual)
    suspect = both & (step > SAME)
    suspect[1:] &= odd
    suspect[:-1] &= odd
    alone = both.copy()  # steps without adjacent steps
    alone[1:] &= ~pair
    alone[:-1] &= ~pair
    return np.asarray(suspect & ~(alone & (step <= LARGE * usual)))


@dataclass(frozen=True, eq=False)
class Continued:
    """Corrections of the poses of a region by continuity.

    Attributes:
        which, q: flat indices of the n changed poses; (n, nq) their model coordinates, NaN where not reached.
        jumps: number of pairs of neighbours that remain in different modes.
        retracted: number of poses that the straight line had reached in another mode.
        gained: number of additionally reached poses.
    """

    which: Index
    q: Array
    jumps: int
    retracted: int
    gained: int


def continued(plan: SweepPlan, labels: Labels, robot: Robot, region: Block, q: Array, o: Array, reached: Mask) -> Continued:
    """Return the poses of a region of the grid that change when they are compared with their neighbours.

    Args:
        region: ranges of indices along the coordinate axes.
        q: (…region, nq) model coordinates, NaN where not reached.
        o: (…region, 3) position of o [m], compared in addition to q if some joints have local freedoms.
        reached: (…region) True where a pose is reached.
    """
    poses = _RegionPoses(plan, labels, robot, region, q, o, reached)
    gained = poses.try_some()
    for _ in range(ROUNDS):
        before = poses.count
        wrong = poses.retract_other_modes()
        if before < reached.size or wrong:
            poses.assemble_unreached(everywhere=gained or wrong > 0)
        if not wrong and poses.count == before:
            break
    was = reached.ravel()
    which = np.flatnonzero((poses.reached != was) | (poses.reached & poses.retracted))
    return Continued(
        which,
        np.where(poses.reached[which, None], poses.q[which, : poses.nq], np.nan),
        poses.jumps() if which.size else 0,
        int(np.sum(poses.retracted & was)),
        int(np.sum(poses.reached & ~was)),
    )


class _RegionPoses:
    """The N poses of a region by flat index.

    Attributes:
        q: (N, nq) model coordinates of reached poses; if joints have local freedoms, followed by x, y, z of o.
        reached: (N,) True for poses reached in the assembly mode of the zero pose.
        retracted: (N,) True for poses that had been reached in another mode.
    """

    def __init__(self, plan: SweepPlan, labels: Labels, robot: Robot, region: Block, q: Array, o: Array, reached: Mask) -> None:
        self.plan, self.robot, self.region = plan, robot, region
        self.shape, size, self.nq = reached.shape, reached.size, q.shape[-1]
        places = [o] if any(labels.undetermined) else []
        self.q = np.concatenate([array.reshape(size, array.shape[-1]) for array in (q, *places)], axis=-1)
        self.reached = reached.flatten()
        self.retracted = np.zeros(size, dtype=bool)
        units = np.array([*labels.auxiliary["joint_coordinate_unit"][1], *("m",) * (3 * len(places))])
        firm = np.array([*(not undetermined for undetermined in labels.undetermined), *(True,) * (3 * len(places))])
        self.scale = JointScale(firm * np.where(units == "m", 1 / robot.length, 1.0), (units == "rad") & firm)
        self._confirmed = np.zeros(0, dtype=np.intp)  # edges along which a path between both poses was followed
        self._source = np.full(size, -1, dtype=np.intp)  # neighbour from which a pose has been reached; −1: from the zero pose
        self._tried = np.zeros((2 * reached.ndim, size), dtype=bool)

    @property
    def count(self) -> int:
        """Number of reached poses."""
        return int(np.sum(self.reached))

    @cached_property
    def values(self) -> dict[str, Array]:
        """Prescribed coordinates (N,) of all poses."""
        return self.plan.coordinates(self.region)

    def at(self, which: Index) -> dict[str, Array]:
        return {name: array[which] for name, array in self.values.items()}

    def store(self, which: Index, q: Array | None, source: Index | int = -1) -> None:
        """Store poses reached from the neighbours ``source`` or the zero pose (−1); without ``q``, mark them as not reached."""
        self.reached[which], self._source[which] = q is not None, source
        if q is not None:
            self.q[which] = q
        self._confirmed = self._confirmed[~np.isin(np.divmod(self._confirmed, self.reached.size), which).any(axis=0)]

    # ---- following --------------------------------------------------------------------------------------------------

    def follow(
        self, starts: Array | None, first: Mapping[str, Array | float], targets: dict[str, Array], steps: int = 1
    ) -> tuple[Array, Mask]:
        """Follow straight lines; return the reached poses (n, nq), and a mask (n,): True where the end is reached.

        Args:
            starts: (n, nq) poses; None: the zero pose.
            first, targets: (n,) prescribed coordinates of the starts and of the ends.
            steps: number of steps.
        """
        count = len(next(iter(targets.values())))
        q = np.full((count, self.q.shape[1]), np.nan) if starts is None else starts.copy()
        alive = np.arange(count)
        for left in reversed(range(steps)):
            goal = {name: (end - (end - first[name]) * left / steps)[alive] for name, end in targets.items()}
            near = None
            if starts is not None or left < steps - 1:
                near = self.robot.configuration(q[alive, : self.nq], closure_tolerance=np.inf, on_failure="nan")
            configuration = self.plan.assemble(self.robot, goal, near)
            arrived = np.asarray(configuration.status != Status.UNREACHABLE)
            alive = alive[arrived]
            q[alive, : self.nq] = configuration.q[arrived]
            if q.shape[1] > self.nq:
                place = configuration.platform_coordinates(self.plan.orientation)
                q[alive, self.nq :] = np.stack([place[name] for name in "xyz"], axis=-1)[arrived]
            if not alive.size:
                break
        return q, np.isin(np.arange(count), alive)

    def follow_from_zero(self, which: Index) -> tuple[Array, Mask]:
        """Follow the straight lines from the zero pose to poses in small steps; see :meth:`follow`."""
        targets, zero = self.at(which), self.zero_coordinates()
        return self.follow(None, {name: zero.get(name, targets[name]) for name in targets}, targets, STEPS)

    def zero_coordinates(self) -> dict[str, float]:
        """Return the prescribed coordinates of the zero pose, without the azimuth if the platform is not tilted."""
        zero = self.robot.configuration(self.robot.model_q(self.robot.zero_poses)[:, 0], closure_tolerance=np.inf)
        if self.plan.kind != "platform":
            return {name: float(value) for name, value in zero.actuators.items()}
        coordinates = {name: float(value) for name, value in zero.platform_coordinates(self.plan.orientation).items()}
        if self.plan.orientation == "tilt_torsion" and abs(coordinates["tilt"]) < 1e-9:
            del coordinates["azimuth"]
        return coordinates

    # ---- 1: other modes ---------------------------------------------------------------------------------------------

    def suspects(self) -> Edges:
        """Return the suspect edges, without edges that have been followed to their stored pose."""
        edges = suspect_edges(self.q.reshape(*self.shape, -1), self.reached.reshape(self.shape), self.scale)
        return edges.where(~np.isin(edges.first * self.reached.size + edges.second, self._confirmed))

    def follow_edges(self, edges: Edges) -> tuple[Edges, Mask]:
        """Follow the straight lines of edges, in small steps if necessary.

        Returns:
            The edges that do not lead to the stored pose, and a mask: True for edges that lead to another pose, False for edges
                at whose end no pose is reached.
        """
        at_other_pose = np.zeros(0, dtype=bool)
        for steps in (1, FINE):
            if len(edges):
                ends, arrived = self.follow(self.q[edges.first], self.at(edges.first), self.at(edges.second), steps)
                step = self.scale.difference(self.q[edges.first], self.q[edges.second])
                same = arrived & (self.scale.difference(ends, self.q[edges.second]) < ALIKE + ALIKE_PART * step)
                self._confirmed = np.append(self._confirmed, (edges.first * self.reached.size + edges.second)[same])
                edges = edges.where(~same)
                at_other_pose = arrived[~same]
        return edges, at_other_pose

    def jumps(self) -> int:
        """Return the number of edges that lead to another mode."""
        return int(self.follow_edges(self.suspects())[1].sum())

    def retract_other_modes(self) -> int:
        """Retract poses that are not in the mode of the zero pose, and return the number of retracted poses.

        Poses reached on the straight line from the zero pose are followed again in small steps. A pose reached from a neighbour
        is retracted together with all poses reached from it, because the path may have passed a singular pose.
        """
        edges, at_other_pose = self.follow_edges(self.suspects())
        if not len(edges):
            return 0
        wrong = np.zeros(self.reached.size, dtype=bool)
        seen = self._source >= 0
        candidates = np.unique([edges.first, edges.second])
        while (candidates := candidates[~seen[candidates]]).size:
            seen[candidates] = True
            ends, arrived = self.follow_from_zero(candidates)
            right = arrived & (self.scale.difference(ends, self.q[candidates]) < ALIKE)
            wrong[candidates[~right]] = True
            moved = arrived & ~right
            self.store(candidates[~right], None)
            self.store(candidates[moved], ends[moved])
            candidates = self._reached_neighbours(candidates[~right])
        from_neighbours = self._source >= 0
        for this, other in ((edges.first, edges.second), (edges.second, edges.first)):
            wrong[this[from_neighbours[this] & at_other_pose & ~wrong[other]]] = True
        while np.any(more := from_neighbours & wrong[self._source] & ~wrong):
            wrong |= more
        gone = np.flatnonzero(wrong & from_neighbours)
        # poses reached from retracted ones may be tried again from any neighbour
        self._tried[:, gone[wrong[self._source[gone]]]] = False
        self.store(gone, None)
        self.retracted |= wrong
        return int(wrong.sum())

    def _reached_neighbours(self, which: Index) -> Index:
        there, adjacent = np.zeros(self.shape, dtype=bool), np.zeros(self.shape, dtype=bool)
        there.ravel()[which] = True
        for _, lower, upper in neighbours(self.shape):
            adjacent[lower] |= there[upper]
            adjacent[upper] |= there[lower]
        return np.flatnonzero(adjacent.ravel() & self.reached)

    # ---- 2: continuation from neighbours ----------------------------------------------------------------------------

    def try_some(self) -> bool:
        """Try to assemble at most ``PROBES`` poses from their neighbours; return whether any is reached."""
        targets, starts, directions = self._next_poses()
        if targets.size > PROBES:
            some = np.linspace(0, targets.size - 1, PROBES).astype(np.intp)
            targets, starts, directions = targets[some], starts[some], directions[some]
        return self._try(targets, starts, directions)

    def assemble_unreached(self, everywhere: bool = True) -> None:
        """Assemble poses from reached neighbours until no more are reached; each neighbour of a pose is tried at most once.

        With ``everywhere`` False, only poses between two reached neighbours are tried.
        """
        while (poses := self._next_poses(everywhere))[0].size:
            self._try(*poses)

    def _try(self, targets: Index, starts: Index, directions: Index) -> bool:
        """Assemble the poses ``targets`` from the neighbours ``starts``; return whether any is reached.

        ``directions`` are the directions of the neighbours, see :meth:`_next_poses`. Retracted poses are followed in small steps.
        """
        count = self.count
        self._tried[directions, targets] = True
        for steps, selected in ((1, ~self.retracted[targets]), (FINE, self.retracted[targets])):
            if np.any(selected):
                to, by = targets[selected], starts[selected]
                ends, arrived = self.follow(self.q[by], self.at(by), self.at(to), steps)
                self.store(to[arrived], ends[arrived], by[arrived])
        return self.count > count

    def _next_poses(self, everywhere: bool = True) -> tuple[Index, Index, Index]:
        """Return the poses (n,) to try, a reached neighbour (n,) of each, and the directions (n,) of these neighbours.

        A direction is 2 · axis + side; side 0: the neighbour is lower. A pose that could not be reached from one neighbour is
        tried again only from neighbours that have been reached since then; a pose between two reached neighbours is tried from
        all its neighbours.
        """
        numbers = np.arange(self.reached.size).reshape(self.shape)
        start = np.full(self.reached.size, -1, dtype=np.intp)
        direction = np.zeros(self.reached.size, dtype=np.intp)
        if self.reached.all():
            return np.zeros(0, dtype=np.intp), start[:0], direction[:0]
        new, there = self._source >= 0, self.reached
        between = np.zeros(self.reached.size, dtype=bool)
        for _, lower, upper in neighbours(self.shape):
            between[numbers[upper][lower]] |= there[numbers[lower][lower]] & there[numbers[upper][upper]]
        again = between | self.retracted | ~np.any(self._tried, axis=0) if everywhere else between
        for axis, lower, upper in neighbours(self.shape):
            for side, (to, by) in enumerate(((upper, lower), (lower, upper))):
                target, source, k = numbers[to].ravel(), numbers[by].ravel(), 2 * axis + side
                fit = ~there[target] & there[source] & ~self._tried[k, target] & (start[target] < 0)
                fit &= again[target] | (new[source] & everywhere)
                start[target[fit]], direction[target[fit]] = source[fit], k
        targets = np.flatnonzero(start >= 0)
        return targets, start[targets], direction[targets]
