"""Joints that follow driven ones, ``<mimic>``: as equations, and as coordinates that are given with those of the drives."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinetostatics.math.arrays import Array
from kinetostatics.mechanism.mechanism import Mechanism
from kinetostatics.mechanism.tree import Tree, TreeJoint

#: Of numbers of turns that fit as well as that [rad] the smaller is meant.
_ALIKE = 1e-9


class Couplings:
    """All joints of a mechanism that mimic others; follower = multiplier · leader + offset [m, rad].

    Attributes:
        names: of the followers.
        count: how many there are.
        columns: the followers' freedoms in the tree.
        is_length: whether each slides (else it turns).
    """

    def __init__(self, mechanism: Mechanism, tree: Tree) -> None:
        joint_of_body = {joint.body: joint for joint in tree.joints}
        self.names: list[str] = []
        self._followers: list[TreeJoint] = []
        self._leaders: list[TreeJoint] = []
        self._relations: list[tuple[float, float]] = []
        for connection in mechanism.connections.values():
            if connection.mimic is not None:
                self.names.append(connection.name)
                self._followers.append(joint_of_body[mechanism.body_of_joint[connection.name]])
                self._leaders.append(joint_of_body[mechanism.body_of_joint[connection.mimic.joint]])
                self._relations.append((connection.mimic.multiplier, connection.mimic.offset))
        self.count = len(self.names)
        self.columns = np.array([joint.first_v for joint in self._followers], dtype=np.intp)
        self.is_length = np.array([joint.type.is_slide for joint in self._followers], dtype=bool)
        self._following: dict[int, list[int]] = {}
        for row, leader in enumerate(self._leaders):
            self._following.setdefault(leader.first_v, []).append(row)
        self._gradient = np.zeros((self.count, tree.nv))
        for row, (multiplier, _) in enumerate(self._relations):
            self._gradient[row, self.columns[row]] = 1.0
            self._gradient[row, self._leaders[row].first_v] = -multiplier

    def residual(self, x: Array, turns: int = 20) -> Array:
        """Return by how much (count, N) [m, rad] the followers are beside where they should be, at coordinates ``x`` (nq', N).

        The angle of a continuous leader is known but for full turns; see :meth:`coordinate`.
        """
        result = np.empty((self.count, x.shape[1]))
        for rows in self._following.values():
            value = self.coordinate(self._leaders[rows[0]], x, turns=turns)
            for row in rows:
                result[row] = self._error(row, x, value)
        return result

    def coordinate(self, joint: TreeJoint, x: Array, near: Array | float = 0.0, turns: int = 500) -> Array:
        """Return the coordinate (N,) [m, rad] of a one-freedom joint at coordinates ``x`` (nq', N).

        Of the angles of a continuous joint, which differ by full turns, it is the one nearest to ``near`` that puts all joints
        that follow it where they are. Where those turn on and on themselves, up to so many ``turns`` beside ``near`` are tried.
        """
        value = joint.coordinate(x)
        if not joint.type.endless:
            return value
        rows = self._following.get(joint.first_v, [])
        counting = [row for row in rows if not self._followers[row].type.endless]
        if counting:  # the one of which a turn moves the least of its way tells the number of turns best
            row = max(counting, key=lambda row: abs(self._relations[row][0]))
            multiplier, offset = self._relations[row]
            near = (self._followers[row].coordinate(x) - offset) / multiplier
        value = value + 2 * np.pi * np.round((near - value) / (2 * np.pi))
        if counting or not rows:
            return np.asarray(value)
        best, least = value, self._misplacement(rows, x, value)
        turned = np.where(value > near, -2 * np.pi, 2 * np.pi)
        for turn in range(1, turns + 1):
            if not np.any(least > _ALIKE):
                break
            for option in (value + turn * turned, value - turn * turned):
                error = self._misplacement(rows, x, option)
                better = error < least - _ALIKE
                best, least = np.where(better, option, best), np.where(better, error, least)
        return best

    def _misplacement(self, rows: list[int], x: Array, value: Array) -> Array:
        return np.max([np.abs(self._error(row, x, value)) for row in rows], axis=0)

    def _error(self, row: int, x: Array, value: Array) -> Array:
        """Return by how much (N,) [m, rad] a follower is beside where its leader's coordinate ``value`` puts it."""
        multiplier, offset = self._relations[row]
        error = self._followers[row].coordinate(x) - multiplier * value - offset
        return _within(error, 2 * np.pi) if self._followers[row].type.endless else error

    def equations(self, x: Array, column_scale: Array, columns: tuple[int, ...]) -> tuple[Array, Array]:
        """Return scaled residuals (count, N) and gradients (count, nv), rows of unit length, for scaled freedoms.

        They are zero for followers of the given freedoms ``columns``, which are where they should be.
        """
        gradient = self._gradient * column_scale
        size = np.sqrt(np.sum(gradient**2, axis=1, keepdims=True))
        size[np.isin(self.columns, self.given_with(columns))] = np.inf
        return self.residual(x) / size, gradient / size

    def given_with(self, columns: tuple[int, ...]) -> NDArray[np.intp]:
        """Return the freedoms of the followers whose leaders are among the given ``columns``."""
        pairs = zip(self._followers, self._leaders, strict=True)
        return np.array([follower.first_v for follower, leader in pairs if leader.first_v in columns], dtype=np.intp)

    def following(self, column: int) -> list[tuple[int, float]]:
        """Return the freedoms of the followers of a freedom, and how fast each moves with it."""
        rows = zip(self._followers, self._leaders, self._relations, strict=True)
        return [(follower.first_v, multiplier) for follower, leader, (multiplier, _) in rows if leader.first_v == column]

    def impose(self, columns: tuple[int, ...], values: Array, x: Array) -> None:
        """Write the coordinates of the followers of given freedoms into ``x`` (nq', N), in place.

        Args:
            columns: the given freedoms.
            values: their coordinates (len(columns), N) [m, rad]; angles may be of more than one turn.
            x: coordinates.
        """
        for follower, leader, (multiplier, offset) in zip(self._followers, self._leaders, self._relations, strict=True):
            if leader.first_v in columns:
                follower.write(multiplier * values[columns.index(leader.first_v)] + offset, x)


def _within(value: Array, period: float) -> Array:
    """Return a value modulo a period, at most half of it away from zero."""
    return np.asarray(value - period * np.round(value / period))
