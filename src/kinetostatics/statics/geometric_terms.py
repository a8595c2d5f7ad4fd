"""The geometric stiffness K_g as a sum of terms, see :mod:`kinetostatics.statics.geometric_stiffness`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from kinetostatics.elements.beam_formulas import of_arm
from kinetostatics.elements.spring import PlacedSpring
from kinetostatics.math.arrays import Array, zeros_for
from kinetostatics.math.linalg import cross
from kinetostatics.math.rotations import skew
from kinetostatics.math.screws import move_wrench
from kinetostatics.statics.rotation_groups import PLATFORM, Block, Coordinates, Junction, RotationGroups


@dataclass(frozen=True)
class JunctionTerms:
    """Second-order energy zᵀ B z of the forces in a joint or beam.

    z consists of the rotation θ of the inner side, and of the shift s and the rotation φ of the outer side relative to the inner
    side. The inner coordinates of a beam (:mod:`kinetostatics.elements.turned_forces`) are eliminated from B, unless ``whole`` is
    given.

    Attributes:
        arm: (3, N) from o to the centre of the joint, or the outer end of the beam [m].
        axes: (3, k, N) directions of the k components of s; None without any.
        B: (9, 9, N).
        constant: (9, S, N) forces on z, by contribution, due to inner deflections under loads along the beam; None: zero.
        whole: for a beam, its geometric stiffness with inner coordinates, see :class:`.UniformInside`, and its axes (3, 3, N).
    """

    item: Junction
    arm: Array
    axes: Array | None
    B: Array
    constant: Array | None = None
    whole: tuple[Array, Array] | None = None


class GeometricTerms:
    """The quadratic form ½ uᵀ K_g u as a sum of terms."""

    def __init__(
        self,
        where: Coordinates,
        rotation_groups: RotationGroups,
        o: Array,
        springs: Sequence[PlacedSpring],
        without_spin: Callable[[int], Array | None],
        acting: Sequence[tuple[str, Array, Array]],
        junctions: Sequence[JunctionTerms],
        inner: Sequence[Array],
        own: bool = True,
    ) -> None:
        """Add up the terms.

        Args:
            acting: forces on rotation groups: each with its attachment, arm from o (3, N) [m] and force (3, N) [N].
            junctions: the energies of joints and beams.
            inner: for each beam the stiffness (b, b, N) of its b inner coordinates.
            own: whether K_g includes the tangent stiffness K_t of the springs themselves.
        """
        self._where, self._rotation_groups, self._o, self._without_spin = where, rotation_groups, o, without_spin
        self._springs, self._acting, self.junctions, self.inner = springs, acting, junctions, inner
        self._found: dict[tuple[Block, Block], Array] = {}
        arms: dict[int, Array] = {}
        for attachment, arm, force in acting:
            group = self._rotation_groups.group_of[attachment]
            arms[group] = arms.get(group, 0.0) + of_arm(force, arm) / 2
        for group, block in arms.items():
            self._add(("group", group), ("group", group), block)
        for junction in junctions:
            self._add_junction(junction)
        for number, spring in enumerate(self._springs if own else ()):
            self._add_spring(number, spring)

    def _add(self, one: Block, two: Block, block: Array) -> None:
        """Add vᵀ B w, with B = ``block`` and the displacements v and w of two blocks, if both blocks are part of u."""
        if one in self._where.sizes and two in self._where.sizes:
            self._found[one, two] = self._found.get((one, two), 0.0) + block
            self._found[two, one] = self._found.get((two, one), 0.0) + np.swapaxes(block, 0, 1)

    def _parts_of(self, junction: JunctionTerms) -> list[tuple[slice, Block, float]]:
        """Return the rows of z, each with the block of u on which they depend, and a sign."""
        item = junction.item
        inner, outer = ("group", item.inner), ("group", item.outer)
        found: list[tuple[slice, Block, float]] = [(slice(0, 3), inner, 1.0)]
        if junction.axes is not None:
            found.append((slice(3, 6), ("slide", self._rotation_groups.junctions.index(item)), 1.0))
        if item.inner != item.outer:
            found += [(slice(6, 9), outer, 1.0), (slice(6, 9), inner, -1.0)]
        return found

    def _add_junction(self, junction: JunctionTerms) -> None:
        item, axes = junction.item, junction.axes
        if item.inner == item.outer and axes is None:
            return
        rows_of_z = self._parts_of(junction)
        for rows, one, a in rows_of_z:
            for columns, two, b in rows_of_z:
                block = junction.B[rows, columns]
                if rows.start == 3 and axes is not None:
                    block = np.einsum("jin,jkn->ikn", axes, block)
                if columns.start == 3 and axes is not None:
                    block = np.einsum("ijn,jkn->ikn", block, axes)
                self._add(one, two, a * b * block)

    def _add_spring(self, number: int, spring: PlacedSpring) -> None:
        """Add ½ dᵀ K_t d, with the displacement d of one end of a spring relative to the other end.

        For a spring between base and platform, d = s + θ × a, with the platform's displacement s and rotation θ, and the arm a
        from o to the spring's end. For a spring between two points of one group with rotation θ, d = θ × a, with the vector a
        between the points. In all other cases d is a block of u.
        """
        span = spring.points[1] - spring.points[0]
        if ("spring", number) in self._where.sizes:
            self._add(("spring", number), ("spring", number), spring.tangent / 2)
            return
        ends = [self._rotation_groups.group_of[attachment] for attachment in spring.attachments]
        arm = spring.points[ends.index(PLATFORM)] - self._o if number in self._where.on_platform else span
        shift, turn, by_turn = ("shift", 0), ("group", max(ends)), -skew(arm)
        moved = np.einsum("ijn,jkn->ikn", spring.tangent, by_turn)
        self._add(turn, turn, np.einsum("jin,jkn->ikn", by_turn, moved) / 2)
        if number in self._where.on_platform:
            self._add(shift, shift, spring.tangent / 2)
            self._add(shift, turn, moved)

    def matrix(self, rows: Sequence[Block], columns: Sequence[Block]) -> Array:
        """Return the part (n, m, N) of K_g in the rows and columns of given blocks."""
        sizes = self._where.sizes
        heights, widths = ([0, *np.cumsum([sizes[block] for block in blocks]).tolist()] for blocks in (rows, columns))
        matrix = zeros_for((heights[-1], widths[-1], self._o.shape[1]), self._o)
        for i, row in enumerate(rows):
            for j, column in enumerate(columns):
                if (row, column) in self._found:
                    matrix[heights[i] : heights[i + 1], widths[j] : widths[j + 1]] = self._found[row, column]
        return matrix

    def constant(self, blocks: Sequence[Block], S: int) -> Array:
        """Return the forces (n, S, N) on given blocks of u due to inner deflections of beams under their loads."""
        given = [(junction, junction.constant) for junction in self.junctions if junction.constant is not None]
        none = zeros_for((sum(self._where.sizes[block] for block in blocks), S, self._o.shape[1]), self._o)
        return sum((self.conjugate(junction, force, blocks) for junction, force in given), none)

    def conjugate(self, junction: JunctionTerms, force: Array, blocks: Sequence[Block]) -> Array:
        """Return the forces (n, S, N) on given blocks of u that do the work of forces (9, S, N) on a junction's z."""
        found = {block: zeros_for((self._where.sizes[block], *force.shape[1:]), self._o, force) for block in blocks}
        for rows, block, sign in self._parts_of(junction):
            if block in found:
                mine = force[rows]
                if rows.start == 3 and junction.axes is not None:
                    mine = np.einsum("jin,jsn->isn", junction.axes, mine)
                found[block] = found[block] + sign * mine
        return np.concatenate(list(found.values())) if found else zeros_for((0, *force.shape[1:]), force)

    def loads(self, u: Array) -> dict[str, Array]:
        """Return the loads −K_g u, for u (n, S, N), as wrenches (6, S, N) about o, by attachment.

        They are −(B + Bᵀ) z in a junction, −K_t d in a spring, and −(f·r 1 − ½ (f rᵀ + r fᵀ)) θ under a force f at the arm r.
        """
        first, at = 0, {}
        for block in self._where.blocks:
            at[block] = u[first : first + self._where.sizes[block]]
            first += self._where.sizes[block]
        none = np.zeros_like(u[:3]) if len(u) > 2 else zeros_for((3, *u.shape[1:]), u)
        found: dict[str, Array] = {}

        group_of = self._rotation_groups.group_of

        def turn(group: int) -> Array:
            return at.get(("group", group), none)

        def put(attachment: str, arm: Array, force: Array, couple: Array) -> None:
            without_spin = self._without_spin(group_of[attachment])  # moments along a free spin are rounding errors
            couple = couple if without_spin is None else np.einsum("ijn,jsn->isn", without_spin, couple)
            wrench = move_wrench(np.concatenate([force, couple]), -arm)
            found[attachment] = found.get(attachment, 0.0) + wrench

        for attachment, arm, force in self._acting:
            put(attachment, arm, none, -np.einsum("ijn,jsn->isn", of_arm(force, arm), turn(group_of[attachment])))
        for junction in self.junctions:
            item, arm, axes = junction.item, junction.arm, junction.axes
            number = self._rotation_groups.junctions.index(item)
            shift = none if axes is None else np.einsum("ikn,ksn->isn", axes, at["slide", number])
            inner, outer = turn(item.inner), turn(item.outer)
            z = np.concatenate([inner, shift, outer - inner])
            back = np.einsum("abn,bsn->asn", junction.B + np.swapaxes(junction.B, 0, 1), z)
            back = back if junction.constant is None else back + junction.constant
            put(item.attachments[1], arm, -back[3:6], -back[6:])
            put(item.attachments[0], arm, back[3:6], back[6:] - back[:3])
        for number, spring in enumerate(self._springs):
            ends = [self._rotation_groups.group_of[attachment] for attachment in spring.attachments]
            if ("spring", number) in at:
                apart = at["spring", number]
            elif number in self._where.on_platform:
                k = ends.index(PLATFORM)
                end = spring.points[k] - self._o
                apart = (at["shift", 0] + cross(turn(PLATFORM), end[:, None])) * (1 if k == 1 else -1)
            else:
                apart = cross(turn(ends[0]), (spring.points[1] - spring.points[0])[:, None])
            change = np.einsum("ijn,jsn->isn", spring.tangent, apart)
            for sign, end, attachment in zip((1, -1), spring.points, spring.attachments, strict=True):
                put(attachment, end - self._o, sign * change, none)
        return found
