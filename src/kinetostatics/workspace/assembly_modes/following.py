"""The poses of one robot on a grid, followed from one to another."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kinetostatics.math.arrays import Array
from kinetostatics.status import Status
from kinetostatics.workspace.assembling import assemble
from kinetostatics.workspace.assembly_modes.continuity import Edges, JointScale, suspect_edges
from kinetostatics.workspace.grid import Block
from kinetostatics.workspace.plan import Combination, Plan
from kinetostatics.workspace.schema import NO_MODE, ZERO_MODE, Labels

if TYPE_CHECKING:
    from kinetostatics.kinematics.configuration import Configuration
    from kinetostatics.robot import Robot

Mask = NDArray[np.bool_]
Index = NDArray[np.intp]

#: Small steps along the line from the zero pose, and along that from a pose to its neighbour, to tell modes apart.
STEPS, FINE = 48, 8
#: Two ways to one pose end alike up to so much [rad], and that part of the step between its neighbours.
ALIKE, ALIKE_PART = 1e-5, 0.02


class Poses:
    """The poses of a region of the grid by their flat numbers.

    Attributes:
        shape: of the region.
        q: (N, nq) model coordinates: where the pose is reached, in whichever mode; and if some of them are loose, x, y, z of o
            behind them, which are not.
        mode: (N,) the mode that reaches it.
    """

    def __init__(self, plan: Plan, labels: Labels, combination: Combination, region: Block, q: Array, reached: Mask) -> None:
        self.plan, self.labels, self.combination, self.region = plan, labels, combination, region
        self.shape = reached.shape
        self.q = q.reshape(reached.size, q.shape[-1]).copy()
        self.mode = np.where(reached.ravel(), ZERO_MODE, NO_MODE).astype(np.int8)
        self.nq = len(labels.q)
        self.units = [unit for _, unit in labels.q] + (["m"] * 3 if any(labels.loose) else [])
        self.told = np.array([not loose for loose in labels.loose] + [True] * (len(self.units) - self.nq), dtype=bool)
        self.sound = np.zeros(0, dtype=np.intp)  # edges that have been followed and are as they should be

    @property
    def robot(self) -> Robot:
        """The robot, which is built only when something must be followed."""
        return self.plan.robot(self.combination)

    @cached_property
    def scale(self) -> JointScale:
        """How its joints' differences are measured."""
        scale = JointScale.of(self.robot, self.units)
        return JointScale(np.where(self.told, scale.weights, 0.0), scale.angles & self.told)

    @cached_property
    def values(self) -> dict[str, Array]:
        """The given coordinates (N,) of all poses."""
        return self.plan.coordinates(self.region)

    def at(self, which: Index) -> dict[str, Array]:
        """Return the given coordinates of some poses."""
        return {name: array[which] for name, array in self.values.items()}

    def set(self, which: Index, q: Array, mode: int) -> None:
        """Say where poses are, and in which mode."""
        self.q[which], self.mode[which] = q, mode
        first, second = np.divmod(self.sound, self.mode.size)
        self.sound = self.sound[~(np.isin(first, which) | np.isin(second, which))]

    # ---- following --------------------------------------------------------------------------------------------------

    def follow(self, starts: Array, targets: dict[str, Array]) -> tuple[Array, Mask]:
        """Follow straight lines from poses ``starts`` (n, nq); return where they end, and whether they arrive."""
        robot = self.robot
        near = robot.configuration(starts[:, : self.nq], tolerance=np.inf, on_failure="nan")
        return self._ends(assemble(self.plan, robot, targets, near))

    def _ends(self, configuration: Configuration) -> tuple[Array, Mask]:
        q = configuration.q
        if len(self.units) > self.nq:
            place = configuration.platform_coordinates(self.plan.orientation)
            q = np.concatenate([q, np.stack([place[name] for name in "xyz"], axis=-1)], axis=-1)
        return q, np.asarray(configuration.status != Status.UNREACHABLE)

    def follow_finely(
        self, starts: Array | None, first: dict[str, Array], targets: dict[str, Array], steps: int
    ) -> tuple[Array, Mask]:
        """Do the same in small steps, from coordinates ``first``; ``starts`` None: from the zero pose."""
        count = len(next(iter(targets.values())))
        q = np.full((count, self.q.shape[1]), np.nan) if starts is None else starts.copy()
        alive = np.arange(count)
        for step in range(1, steps + 1):
            goal = {name: (first[name] + (targets[name] - first[name]) * step / steps)[alive] for name in targets}
            if starts is None and step == 1:
                ends, arrived = self._ends(assemble(self.plan, self.robot, goal))
            else:
                ends, arrived = self.follow(q[alive], goal)
            alive = alive[arrived]
            q[alive] = ends[arrived]
            if not alive.size:
                break
        found = np.zeros(count, dtype=bool)
        found[alive] = True
        return q, found

    # ---- neighbours ---------------------------------------------------------------------------------------------------

    def suspects(self) -> Edges:
        """Return the edges whose steps are too large."""
        reached = (self.mode == ZERO_MODE).reshape(self.shape)
        told = self.q if np.all(self.told) else self.q[:, self.told]
        found = suspect_edges(told.reshape(*self.shape, -1), reached, self._rough_scale(told))
        new = ~np.isin(found.first * self.mode.size + found.second, self.sound)
        return Edges(found.first[new], found.second[new])

    def _rough_scale(self, told: Array) -> JointScale:
        """Return a scale that needs no robot, whose building would cost more than the look: lengths by their own spread."""
        units = [unit for unit, mine in zip(self.units, self.told, strict=True) if mine]
        some = told[self.mode == ZERO_MODE]
        spread = np.ptp(some, axis=0) if len(some) else np.ones(len(units))
        weights = np.where([unit == "m" for unit in units], 1 / np.maximum(spread, 1e-9), 1.0)
        return JointScale(weights, np.array([unit == "rad" for unit in units], dtype=bool))

    def examine(self, edges: Edges) -> tuple[Mask, Mask]:
        """Follow edges; return which lead from one pose to the other, and which lead elsewhere."""
        same, elsewhere = np.zeros(len(edges), dtype=bool), np.zeros(len(edges), dtype=bool)
        for steps in (1, FINE):  # what one step does not lead to, small ones may
            left = np.flatnonzero(~same)
            if left.size:
                first, second = edges.first[left], edges.second[left]
                ends, arrived = self.follow_finely(self.q[first], self.at(first), self.at(second), steps)
                same[left] = self.is_there(Edges(first, second), ends, arrived)
                elsewhere[left] = arrived & ~same[left]
        return same, elsewhere

    def is_there(self, edges: Edges, ends: Array, arrived: Mask) -> Mask:
        """Return which ways along edges, ending at ``ends`` (n, nq), end at their second pose."""
        step = self.scale.difference(self.q[edges.first], self.q[edges.second])
        return np.asarray(arrived & (self.scale.difference(ends, self.q[edges.second]) < ALIKE + ALIKE_PART * step))

    def jumps(self) -> int:
        """Return the number of edges that lead to another mode."""
        edges = self.suspects()
        return int(self.examine(edges)[1].sum()) if len(edges) else 0

    # ---- the zero pose ------------------------------------------------------------------------------------------------

    def is_reached_finely(self, which: Index) -> Mask:
        """Return which poses are where small steps along the straight line from the zero pose end."""
        zero, _ = self.from_zero()
        targets = self.at(which)
        start = {name: np.where(np.isnan(zero[name]), targets[name], zero[name]) for name in targets}
        q, arrived = self.follow_finely(None, start, targets, STEPS)
        difference = self.scale.difference(q, self.q[which])
        return arrived & (difference < ALIKE)

    def from_zero(self) -> tuple[dict[str, float], Array]:
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
