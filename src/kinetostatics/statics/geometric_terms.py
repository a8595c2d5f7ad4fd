"""Second-order potential energy of the forces at the pose: a quadratic form ½ uᵀ K_g u in a few displacements u.

The displacements u are rotations of parts (:mod:`kinetostatics.statics.turning_parts`), transverse displacements across prismatic
joints and beams, and relative displacements of the ends of springs.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from kinetostatics.limbs.beam_formulas import of_arm
from kinetostatics.math.arrays import Array, Mask, zeros_for
from kinetostatics.math.graphs import joined
from kinetostatics.math.linalg import cross
from kinetostatics.math.rotations import skew
from kinetostatics.math.screws import move_wrench, wrench_of_force
from kinetostatics.statics.turning_parts import BASE, PLATFORM, Passage, TurningParts


@dataclass(frozen=True)
class PlacedSpring:
    """A spring at N poses.

    Attributes:
        name: name of the spring.
        points: (3, N) its two ends [m].
        places: the places of each end, with the poses (N,) at which it is there.
        length: (N,) [m].
        tension: (N,) [N].
        force: (3, N) force on the first end, directed towards the second [N].
        tangent: (3, 3, N) tangent stiffness K_t [N/m].
    """

    name: str
    points: tuple[Array, Array]
    places: tuple[dict[str, Mask], dict[str, Mask]]
    length: Array
    tension: Array
    force: Array
    tangent: Array

    def pull(self, force: Array, o: Array) -> tuple[dict[str, Array], dict[str, Array]]:
        """Return a force (3, N) on the first end and its opposite on the second: wrenches about o, and points, by place."""
        wrenches: dict[str, Array] = {}
        points: dict[str, Array] = {}
        for sign, point, places in zip((1, -1), self.points, self.places, strict=True):
            wrench = sign * wrench_of_force(force, point - o)
            for place, where in places.items():
                wrenches[place] = wrenches.get(place, 0.0) + np.where(where, wrench, 0.0)
                points.setdefault(place, point)
        return wrenches, points


#: A block of coordinates: ("shift", 0): displacement of o, for springs between base and platform; ("part", number): rotation of a
#: part; ("slide", number): displacements across a passage; ("spring", number): relative displacement of the ends.
Block: TypeAlias = tuple[str, int]


@dataclass(frozen=True)
class Coordinates:
    """The displacements u of which the geometric stiffness is a quadratic form.

    Attributes:
        platform: blocks determined by the platform's twist alone.
        inside: blocks inside limbs; those coupled by limbs or springs are together.
        sizes: sizes of all blocks.
        on_platform: indices of the springs between base and platform.
    """

    platform: tuple[Block, ...]
    inside: tuple[tuple[Block, ...], ...]
    sizes: dict[Block, int]
    on_platform: tuple[int, ...]

    @property
    def blocks(self) -> tuple[Block, ...]:
        """All blocks, in order."""
        return (*self.platform, *(block for together in self.inside for block in together))

    @property
    def names(self) -> list[str]:
        """Names of all displacements, and of the loads that do work on them."""
        return [f"change {k} of {kind} {number}" for kind, number in self.blocks for k in range(self.sizes[kind, number])]


def coordinates_of(parts: TurningParts) -> Coordinates:
    """Return the displacements u of a robot: rotations of its parts, and displacements across joints, beams and springs."""
    count = max((item.owner for item in parts.passages), default=0) + 1
    sliding = {part for item in parts.passages if item.slides for part in (item.inner, item.outer)}
    owned: list[tuple[Block, int]] = []
    pairs, on_platform = [], []
    for part in parts.turning:
        if part != PLATFORM:
            owned.append((("part", part), parts.owners[part]))
    owned += [(("slide", k), item.owner) for k, item in enumerate(parts.passages) if item.slides]
    for number, places in enumerate(parts.sprung):
        ends = [parts.part_of[place] for place in places]
        if set(ends) == {BASE, PLATFORM} and not any(place in parts.owner_at for place in places):
            on_platform.append(number)
        elif ends[0] != ends[1] or ends[0] in sliding:  # otherwise length and direction on the part are constant
            owners = [parts.owner_of(place) for place in places]
            mine = [owner for owner in owners if owner >= 0] or [count]
            owned.append((("spring", number), mine[0]))
            pairs.append((mine[0], mine[-1]))
    together = joined(range(count + 1), pairs)
    groups: dict[frozenset[int], list[Block]] = {}
    for block, owner in owned:
        groups.setdefault(together[owner], []).append(block)
    platform: list[Block] = [("shift", 0)] if on_platform else []
    platform += [("part", PLATFORM)] if PLATFORM in parts.turning else []
    inside = tuple(tuple(group) for group in groups.values())
    sizes = {block: 3 for block in (*platform, *(block for group in inside for block in group))}
    sizes |= {("slide", k): len(item.slides) for k, item in enumerate(parts.passages) if item.slides}
    return Coordinates(tuple(platform), inside, sizes, tuple(on_platform))


class GeometricTerms:
    """The quadratic form ½ uᵀ K_g u as a sum of terms, and the loads −K_g u of given displacements."""

    def __init__(
        self,
        where: Coordinates,
        parts: TurningParts,
        o: Array,
        springs: Sequence[PlacedSpring],
        acting: Sequence[tuple[str, Array, Array]],
        passages: Sequence[tuple[Passage, Array, Array | None, Array]],
        without_spin: Callable[[int], Array | None],
    ) -> None:
        """Add up the terms of the quadratic form.

        Args:
            where: definition of u.
            parts: parts of the robot.
            o: (3, N) [m].
            springs: springs of the robot.
            acting: forces on pieces of parts: place, arm from o and force (3, N).
            passages: the passages with the arm of the centre from o, the axes (3, k, N) of slides, and their matrix B (9, 9, N).
            without_spin: function that returns the projection (3, 3, N) without the free spin of a part.
        """
        self._where, self._parts, self._o = where, parts, o
        self._springs, self._acting, self._passages, self._without_spin = springs, acting, passages, without_spin
        self._found: dict[tuple[Block, Block], Array] = {}
        arms: dict[int, Array] = {}
        for place, arm, force in acting:
            part = parts.part_of[place]
            arms[part] = arms.get(part, 0.0) + of_arm(force, arm) / 2
        for part, block in arms.items():
            self._add(("part", part), ("part", part), block)
        for number, (item, _, axes, block) in enumerate(passages):
            self._add_passage(number, item, axes, block)
        for number, spring in enumerate(springs):
            self._add_spring(number, spring)

    def _add(self, one: Block, two: Block, block: Array) -> None:
        """Add a term uᵀ B v, with B = ``block``, to the quadratic form; terms in blocks that are no coordinates are ignored."""
        if one in self._where.sizes and two in self._where.sizes:
            self._found[one, two] = self._found.get((one, two), 0.0) + block
            self._found[two, one] = self._found.get((two, one), 0.0) + np.swapaxes(block, 0, 1)

    def _add_passage(self, number: int, item: Passage, axes: Array | None, block: Array) -> None:
        if item.inner == item.outer and axes is None:
            return
        inner, outer = ("part", item.inner), ("part", item.outer)
        turned: list[tuple[Block, float]] = [] if item.inner == item.outer else [(outer, 1.0), (inner, -1.0)]
        signed: tuple[list[tuple[Block, float]], ...] = (
            [(inner, 1.0)],
            [] if axes is None else [(("slide", number), 1.0)],
            turned,
        )
        for i, rows in enumerate(signed):
            for j, columns in enumerate(signed):
                part = block[3 * i : 3 * i + 3, 3 * j : 3 * j + 3]
                part = part if i != 1 or axes is None else np.einsum("jin,jkn->ikn", axes, part)
                part = part if j != 1 or axes is None else np.einsum("ijn,jkn->ikn", part, axes)
                for one, a in rows:
                    for two, b in columns:
                        self._add(one, two, a * b * part)

    def _add_spring(self, number: int, spring: PlacedSpring) -> None:
        """Add ½ uᵀ K_t u with the relative displacement u of a spring's ends.

        u is a block of its own, or for a spring between base and platform d + θ × a, with the arm a of its end from o.
        """
        span = spring.points[1] - spring.points[0]
        if ("spring", number) in self._where.sizes:
            self._add(("spring", number), ("spring", number), spring.tangent / 2)
            return
        ends = [self._parts.part_of[place] for place in self._parts.sprung[number]]
        arm = spring.points[ends.index(PLATFORM)] - self._o if number in self._where.on_platform else span
        shift, turn, by_turn = ("shift", 0), ("part", max(ends)), -skew(arm)
        moved = np.einsum("ijn,jkn->ikn", spring.tangent, by_turn)
        self._add(turn, turn, np.einsum("jin,jkn->ikn", by_turn, moved) / 2)
        if number in self._where.on_platform:
            self._add(shift, shift, spring.tangent / 2)
            self._add(shift, turn, moved)

    def matrix(self, rows: Sequence[Block], columns: Sequence[Block]) -> Array:
        """Return some rows and columns of K_g."""
        sizes = self._where.sizes
        heights, widths = ([0, *np.cumsum([sizes[block] for block in blocks]).tolist()] for blocks in (rows, columns))
        matrix = zeros_for((heights[-1], widths[-1], self._o.shape[1]), self._o)
        for i, row in enumerate(rows):
            for j, column in enumerate(columns):
                if (row, column) in self._found:
                    matrix[heights[i] : heights[i + 1], widths[j] : widths[j + 1]] = self._found[row, column]
        return matrix

    def loads(self, u: Array) -> dict[str, Array]:
        """Return the loads −K_g u as wrenches (6, S, N) about o, by place."""
        first, at = 0, {}
        for block in self._where.blocks:
            at[block] = u[first : first + self._where.sizes[block]]
            first += self._where.sizes[block]
        none = np.zeros_like(u[:3]) if len(u) > 2 else zeros_for((3, *u.shape[1:]), u)
        found: dict[str, Array] = {}

        def turn(part: int) -> Array:
            return at.get(("part", part), none)

        def put(place: str, arm: Array, force: Array, couple: Array) -> None:
            without_spin = self._without_spin(self._parts.part_of[place])  # moments along a free spin are rounding errors
            couple = couple if without_spin is None else np.einsum("ijn,jsn->isn", without_spin, couple)
            wrench = move_wrench(np.concatenate([force, couple]), -arm)
            found[place] = found.get(place, 0.0) + wrench

        for place, arm, force in self._acting:
            put(place, arm, none, -np.einsum("ijn,jsn->isn", of_arm(force, arm), turn(self._parts.part_of[place])))
        for number, (item, arm, axes, terms) in enumerate(self._passages):
            shift = none if axes is None else np.einsum("ikn,ksn->isn", axes, at["slide", number])
            inner, outer = turn(item.inner), turn(item.outer)
            z = np.concatenate([inner, shift, outer - inner])
            back = np.einsum("abn,bsn->asn", terms + np.swapaxes(terms, 0, 1), z)
            put(item.places[1], arm, -back[3:6], -back[6:])
            put(item.places[0], arm, back[3:6], back[6:] - back[:3])
        for number, spring in enumerate(self._springs):
            ends = [self._parts.part_of[place] for place in self._parts.sprung[number]]
            if ("spring", number) in at:
                apart = at["spring", number]
            elif number in self._where.on_platform:
                k = ends.index(PLATFORM)
                end = spring.points[k] - self._o
                apart = (at["shift", 0] + cross(turn(PLATFORM), end[:, None])) * (1 if k == 1 else -1)
            else:
                apart = cross(turn(ends[0]), (spring.points[1] - spring.points[0])[:, None])
            change = np.einsum("ijn,jsn->isn", spring.tangent, apart)
            for sign, end, places in zip((1, -1), spring.points, spring.places, strict=True):
                for place, here in places.items():
                    put(place, end - self._o, np.where(here, sign * change, 0.0), none)
        return found
