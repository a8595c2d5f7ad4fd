"""Prescribed coordinates of poses, straight lines from the coordinates of a start to a target, and mimic joints.

A mimic joint is a *follower*; the joint that it mimics is its *leader*.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from kinetostatics.math.arrays import Array, Index, Mask
from kinetostatics.math.rotations import Orientation
from kinetostatics.mechanism.mechanism import Mechanism
from kinetostatics.mechanism.tree import Tree, TreeJoint

#: Difference of residuals [rad] up to which two numbers of turns are equally good; the smaller number is chosen.
_ALIKE = 1e-9


@dataclass(frozen=True)
class PrescribedCoordinates:
    """Prescribed coordinates, in addition to the closure of loops.

    Attributes:
        columns: prescribed freedoms of the tree (actuated joints of the tree).
        loops: prescribed actuated loops, as indices in ``LoopEquations.loops``.
        positions: indices of prescribed coordinates among x, y, z.
        angles: indices of prescribed orientation coordinates.
        orientation: convention of the orientation coordinates.
        fixed_dofs: freedoms of the tree that remain constant.
        local_dofs: number of further freedoms that do not move the platform; steps have no component along these freedoms.

    Targets (n, N) contain columns, loops, positions and angles, in this order.
    """

    columns: tuple[int, ...] = ()
    loops: tuple[int, ...] = ()
    positions: tuple[int, ...] = ()
    angles: tuple[int, ...] = ()
    orientation: Orientation | None = None
    fixed_dofs: tuple[int, ...] = ()
    local_dofs: int = 0

    def __hash__(self) -> int:
        return self._hash

    @cached_property
    def _hash(self) -> int:
        return hash((self.columns, self.loops, self.positions, self.angles, self.orientation, self.fixed_dofs, self.local_dofs))

    @cached_property
    def size(self) -> int:
        return self.first_angle + len(self.angles)

    @cached_property
    def first_angle(self) -> int:
        """Index of the first angle among the targets."""
        return len(self.columns) + len(self.loops) + len(self.positions)

    @cached_property
    def unknown_angles(self) -> tuple[int, ...]:
        """Indices of the orientation coordinates that are unknown; empty if no orientation coordinate is prescribed."""
        return tuple(k for k in range(3) if k not in self.angles) if self.angles else ()


def for_each(array: Array, N: int) -> Array:
    """Return a copy (k, N) of an array (k, N), or N copies of an array (k, 1)."""
    return np.array(array, subok=True) if array.shape[1] == N else np.repeat(array, N, axis=1)


def line_start(
    prescribed: PrescribedCoordinates, origin: tuple[Array, Array], target: Array, shorter: bool | Mask
) -> tuple[Array, Array]:
    """Return (a, c) at the starts of straight lines to targets: a (n, N) prescribed, c (3, N) orientation coordinates.

    The starts are the poses of ``origin``. Of coordinates that describe the same pose, those near the target are chosen: full
    turns of the platform are added where ``shorter``; rotations about coincident axes share their angle.
    """
    first, c = (for_each(array, target.shape[1]) for array in origin)
    if prescribed.angles and prescribed.orientation is not None:
        if shorter is False and prescribed.orientation.is_unique(origin[1]):  # recorded code uses the general case
            return first, c
        given = list(prescribed.angles)
        aim = np.array(c, subok=True)
        aim[given] = target[prescribed.first_angle :]
        c = prescribed.orientation.same(c, np.where(np.isfinite(aim), aim, c), always=shorter)
        first[prescribed.first_angle :] = c[given]
    return first, c


class _Coupling(NamedTuple):
    follower: TreeJoint
    leader: TreeJoint
    multiplier: float
    offset: float

    def error(self, x: Array, value: Array) -> Array:
        """(N,) error [m, rad] of the follower if its leader has the coordinate ``value``."""
        error = self.follower.coordinate(x) - self.multiplier * value - self.offset
        if self.follower.type.endless:
            error = error - 2 * np.pi * np.round(error / (2 * np.pi))
        return error


class Couplings:
    """All mimic joints of a mechanism: follower = multiplier · leader + offset [m, rad].

    Attributes:
        names, count: names and number of the followers.
        items: leader, follower, multiplier and offset of each mimic joint.
        columns: freedoms of the followers in the tree.
        is_length: for each follower, True if it is prismatic, False if it rotates.
    """

    def __init__(self, mechanism: Mechanism, tree: Tree) -> None:
        joint_of_body = {joint.body: joint for joint in tree.joints}
        followers = {name: joint.mimic for name, joint in mechanism.connections.items() if joint.mimic is not None}
        self.names = list(followers)
        self.items = [
            _Coupling(
                joint_of_body[mechanism.body_of_joint[name]],
                joint_of_body[mechanism.body_of_joint[mimic.joint]],
                mimic.multiplier,
                mimic.offset,
            )
            for name, mimic in followers.items()
        ]
        self.count = len(self.names)
        self.columns = np.array([coupling.follower.first_v for coupling in self.items], dtype=np.intp)
        self.is_length = np.array([coupling.follower.type.is_slide for coupling in self.items], dtype=bool)
        self._gradient = np.zeros((self.count, tree.nv))
        for row, coupling in zip(self._gradient, self.items, strict=True):
            row[coupling.follower.first_v], row[coupling.leader.first_v] = 1.0, -coupling.multiplier

    def residual(self, x: Array, turns: int = 20, given: tuple[int, ...] = ()) -> Array:
        """Return the errors (count, N) [m, rad] of the followers at coordinates ``x`` (nq', N).

        Full turns of continuous leaders are chosen as in :meth:`coordinate`. The error of a follower is 0 if its leader is one of
        the freedoms ``given``.
        """
        leaders = {coupling.leader.first_v: coupling.leader for coupling in self.items if coupling.leader.first_v not in given}
        values = {column: self.coordinate(leader, x, turns=turns) for column, leader in leaders.items()}
        errors = [
            coupling.error(x, values[coupling.leader.first_v]) if coupling.leader.first_v in values else np.zeros(x.shape[1])
            for coupling in self.items
        ]
        return np.stack(errors) if errors else np.zeros((0, x.shape[1]))

    def coordinate(self, joint: TreeJoint, x: Array, near: Array | float = 0.0, turns: int = 500) -> Array:
        """Return the position (N,) [m, rad] of a one-freedom joint at the coordinates ``x`` (nq', N) of the tree.

        The full turns of a continuous joint are chosen so that its angle is consistent with all its followers and nearest to
        ``near``. If the followers are continuous too, up to ``turns`` full turns to either side are tried.
        """
        value = joint.coordinate(x)
        if not joint.type.endless:
            return value
        led = [coupling for coupling in self.items if coupling.leader.first_v == joint.first_v]
        counting = [coupling for coupling in led if not coupling.follower.type.endless]
        if counting:  # the follower with the largest motion per turn determines the number of turns best
            fastest = max(counting, key=lambda coupling: abs(coupling.multiplier))
            near = (fastest.follower.coordinate(x) - fastest.offset) / fastest.multiplier
        value = value + 2 * np.pi * np.round((near - value) / (2 * np.pi))
        if counting or not led:
            return value

        def misplaced(value: Array) -> Array:
            return np.stack([np.abs(coupling.error(x, value)) for coupling in led]).max(axis=0)

        best, least = value, misplaced(value)
        turned = np.where(value > near, -2 * np.pi, 2 * np.pi)
        for turn in range(1, turns + 1):
            if x.dtype != object and not np.any(least > _ALIKE):  # then no option is better; recorded code tries all of them
                break
            for option in (value + turn * turned, value - turn * turned):
                error = misplaced(option)
                better = error < least - _ALIKE
                best, least = np.where(better, option, best), np.where(better, error, least)
        return best

    def equations(self, x: Array, column_scale: Array, columns: tuple[int, ...]) -> tuple[Array, Array]:
        """Return (r, g): scaled residuals r (count, N), and gradients g (count, nv) by scaled freedoms, scaled to unit vectors.

        Both are zero for followers of the given freedoms ``columns``.
        """
        gradient = self._gradient * column_scale
        size = np.sqrt(np.sum(gradient**2, axis=1, keepdims=True))
        size[np.isin(self.columns, self.followers_of(columns))] = np.inf
        return self.residual(x, given=columns) / size, gradient / size

    def followers_of(self, columns: tuple[int, ...]) -> Index:
        """Return the freedoms of the followers whose leaders are among the freedoms ``columns``."""
        followers = [coupling.follower.first_v for coupling in self.items if coupling.leader.first_v in columns]
        return np.array(followers, dtype=np.intp)

    def rates_with(self, column: int) -> list[tuple[int, float]]:
        """Return (freedom, rate per unit rate of ``column``) for ``column`` itself and for its followers."""
        return [
            (column, 1.0),
            *((coupling.follower.first_v, coupling.multiplier) for coupling in self.items if coupling.leader.first_v == column),
        ]

    def impose(self, columns: tuple[int, ...], values: Array, x: Array) -> None:
        """Write the coordinates of the followers of given freedoms into ``x`` (nq', N), in place.

        ``values`` (len(columns), N) are the coordinates of the given freedoms [m, rad]; angles may exceed one turn.
        """
        for coupling in self.items:
            if coupling.leader.first_v in columns:
                coupling.follower.write(coupling.multiplier * values[columns.index(coupling.leader.first_v)] + coupling.offset, x)
