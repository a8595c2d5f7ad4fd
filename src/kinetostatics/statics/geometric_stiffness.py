"""Geometric stiffness: the change, due to displacements, of the forces at a pose (method page, section 12).

The directions of weights are constant while their lever arms rotate; springs stretch and rotate; joint wrenches rotate with the
connected parts. Under a rotation θ of a part, a point at p moves by θ × p + ½ θ × (θ × p), so that a force f there has the
second-order potential energy −½ f · (θ × (θ × p)). The sum is a quadratic form ½ uᵀ K_g u in a few displacements u: rotations of
parts, transverse displacements across prismatic joints and beams, and relative displacements of the ends of springs.
:mod:`kinetostatics.statics.turning_parts` defines parts, passages (joints and beams), and blocks of u. A place is a
rigid link, or an end of a beam.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from kinetostatics.elements.beam_formulas import of_arm, turned_forces
from kinetostatics.math.arrays import Array, zeros_for
from kinetostatics.math.linalg import cross
from kinetostatics.math.rotations import skew
from kinetostatics.math.screws import move_twist, move_wrench, wrench_of_force
from kinetostatics.mechanism.limbs import carries
from kinetostatics.mechanism.tree import Frames
from kinetostatics.statics.link_loads import AppliedLoad
from kinetostatics.statics.robot_statics import RobotStatics
from kinetostatics.statics.solution import Solution
from kinetostatics.statics.turning_parts import PLATFORM, Block, Fixed, Passage, TurningParts, coordinates_of


@dataclass(frozen=True)
class PlacedSpring:
    """A spring at N poses.

    Attributes:
        points: positions (3, N) of its two ends [m].
        places: the rigid links, or ends of beams, to which its two ends are attached.
        length, tension: (N,) [m], [N].
        force: (3, N) force on the first end, directed towards the second end [N].
        tangent: (3, 3, N) tangent stiffness K_t [N/m].
    """

    name: str
    points: tuple[Array, Array]
    places: tuple[str, str]
    length: Array
    tension: Array
    force: Array
    tangent: Array

    def pull(self, force: Array, o: Array) -> tuple[dict[str, Array], dict[str, Array]]:
        """Apply a force (3, N) [N] to the first end, and its reaction to the second end.

        Returns:
            (wrenches, points): by place, the wrench (6, N) about o [N, N·m] and the point of application (3, N) [m].
        """
        wrenches: dict[str, Array] = {}
        points: dict[str, Array] = {}
        for sign, point, place in zip((1, -1), self.points, self.places, strict=True):
            wrenches[place] = wrenches.get(place, 0.0) + sign * wrench_of_force(force, point - o)
            points.setdefault(place, point)
        return wrenches, points


class GeometricTerms:
    """The quadratic form ½ uᵀ K_g u as a sum of terms."""

    def __init__(
        self,
        robot: GeometricStiffness,
        acting: Sequence[tuple[str, Array, Array]],
        passages: Sequence[tuple[Passage, Array, Array | None, Array]],
        own: bool = True,
    ) -> None:
        """Add up the terms.

        Args:
            acting: forces on parts: each with its place, arm from o (3, N) [m] and force (3, N) [N].
            passages: each passage with the arm from o to its centre (3, N) [m], the axes (3, k, N) of its k slides (None without
                slides), and the matrix B (9, 9, N) of its energy, see :meth:`GeometricStiffness._of_joint`.
            own: whether K_g includes the tangent stiffness K_t of the springs themselves.
        """
        self._robot, self._where, self._parts, self._o = robot, robot.coordinates, robot.parts, robot.o
        self._springs, self._acting, self._passages = robot.springs, acting, passages
        self._found: dict[tuple[Block, Block], Array] = {}
        arms: dict[int, Array] = {}
        for place, arm, force in acting:
            part = self._parts.part_of[place]
            arms[part] = arms.get(part, 0.0) + of_arm(force, arm) / 2
        for part, block in arms.items():
            self._add(("part", part), ("part", part), block)
        for number, (item, _, axes, block) in enumerate(passages):
            self._add_passage(number, item, axes, block)
        for number, spring in enumerate(self._springs if own else ()):
            self._add_spring(number, spring)

    def _add(self, one: Block, two: Block, block: Array) -> None:
        """Add vᵀ B w, with B = ``block`` and the displacements v and w of two blocks, if both blocks are part of u."""
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
        """Add ½ dᵀ K_t d, with the displacement d of one end of a spring relative to the other end.

        For a spring between base and platform, d = s + θ × a, with the platform's displacement s and rotation θ, and the arm a
        from o to the spring's end. For a spring between two points of one part with rotation θ, d = θ × a, with the vector a
        between the points. In all other cases d is a block of u.
        """
        span = spring.points[1] - spring.points[0]
        if ("spring", number) in self._where.sizes:
            self._add(("spring", number), ("spring", number), spring.tangent / 2)
            return
        ends = [self._parts.part_of[place] for place in spring.places]
        arm = spring.points[ends.index(PLATFORM)] - self._o if number in self._where.on_platform else span
        shift, turn, by_turn = ("shift", 0), ("part", max(ends)), -skew(arm)
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

    def loads(self, u: Array) -> dict[str, Array]:
        """Return the loads −K_g u, for u (n, S, N), as wrenches (6, S, N) about o, by place."""
        first, at = 0, {}
        for block in self._where.blocks:
            at[block] = u[first : first + self._where.sizes[block]]
            first += self._where.sizes[block]
        none = np.zeros_like(u[:3]) if len(u) > 2 else zeros_for((3, *u.shape[1:]), u)
        found: dict[str, Array] = {}

        def turn(part: int) -> Array:
            return at.get(("part", part), none)

        def put(place: str, arm: Array, force: Array, couple: Array) -> None:
            without_spin = self._robot.without_spin(self._parts.part_of[place])  # moments along a free spin are rounding errors
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
            ends = [self._parts.part_of[place] for place in spring.places]
            if ("spring", number) in at:
                apart = at["spring", number]
            elif number in self._where.on_platform:
                k = ends.index(PLATFORM)
                end = spring.points[k] - self._o
                apart = (at["shift", 0] + cross(turn(PLATFORM), end[:, None])) * (1 if k == 1 else -1)
            else:
                apart = cross(turn(ends[0]), (spring.points[1] - spring.points[0])[:, None])
            change = np.einsum("ijn,jsn->isn", spring.tangent, apart)
            for sign, end, place in zip((1, -1), spring.points, spring.places, strict=True):
                put(place, end - self._o, sign * change, none)
        return found


class GeometricStiffness:
    """The displacements u of a robot at N poses, the unit loads conjugate to u, and the geometric stiffness K_g.

    Attributes:
        coordinates: the blocks of u.
        o: (3, N) position of o [m].
    """

    def __init__(self, robot: RobotStatics, parts: TurningParts, frames: Frames, springs: Sequence[PlacedSpring]) -> None:
        self._robot, self._frames, self.parts, self.springs = robot, frames, parts, springs
        self.coordinates = coordinates_of(parts)
        _, self.o = robot.mechanism.platform_pose(frames)

    def unit_loads(self) -> list[AppliedLoad]:
        """Return for each component of u its conjugate unit load: a force, a couple, or a pair of opposite forces."""
        o, where = self.o, self.coordinates
        none, units = np.zeros_like(o), [np.broadcast_to(unit[:, None], o.shape) for unit in np.eye(3)]
        acting: list[dict[str, Array]] = []
        for kind, number in where.blocks:
            if kind == "shift":
                acting += [{self.parts.places[PLATFORM]: np.concatenate([unit, none])} for unit in units]
            elif kind == "part":
                place, without_spin = self.parts.places[number], self.without_spin(number)
                couples = units if without_spin is None else [without_spin[:, k] for k in range(3)]
                acting += [{place: np.concatenate([none, couple])} for couple in couples]
            elif kind == "slide":
                item = self.parts.passages[number]
                for slide in item.slides:
                    wrench = wrench_of_force(self._direction(slide), self._arm(item))
                    acting.append({item.places[0]: -wrench, item.places[1]: wrench})
            else:
                acting += [self.springs[number].pull(-unit, o)[0] for unit in units]
        return [AppliedLoad(name, wrenches, {}, "change") for name, wrenches in zip(where.names, acting, strict=True)]

    def displacements(self, motion: Callable[[str], Array], blocks: Sequence[Block]) -> Array:
        """Return the blocks (n, S, N) of u; ``motion(place)`` is the twist (6, S, N) of a place about o."""
        rows = []
        for kind, number in blocks:
            if kind == "shift":
                rows.append(motion(self.parts.places[PLATFORM])[:3])
            elif kind == "part":
                turned, without_spin = motion(self.parts.places[number])[3:], self.without_spin(number)
                rows.append(turned if without_spin is None else np.einsum("ijn,jsn->isn", without_spin, turned))
            elif kind == "slide":
                item = self.parts.passages[number]
                inner, outer = (_at(motion(place), self._arm(item)) for place in item.places)
                axes = np.stack([self._direction(slide) for slide in item.slides])
                rows.append(np.einsum("kin,isn->ksn", axes, outer - inner))
            else:
                spring = self.springs[number]
                start, end = (_at(motion(place), p - self.o) for p, place in zip(spring.points, spring.places, strict=True))
                rows.append(end - start)
        return np.concatenate(rows)

    def under(self, solution: Solution, own: bool = True) -> GeometricTerms:
        """Return K_g under the weights, spring forces and joint wrenches of an equilibrium, without the load on the platform.

        ``own``: whether K_g includes the tangent stiffness of the springs themselves.
        """
        transmitted = _PassageWrenches(self._robot, solution)
        acting: list[tuple[str, Array, Array]] = []
        centres = self._robot.weights.centres(self._frames) - self.o[:, None]
        for w, name in enumerate(self._robot.weights.names):
            if not name.startswith("beam:"):
                acting.append((name, centres[:, w], solution.weights[:3, w]))
        for spring in self.springs:
            for sign, end, place in zip((1, -1), spring.points, spring.places, strict=True):
                acting.append((place, end - self.o, sign * spring.force))
        passages = []
        for item in self.parts.passages:
            arm = self._arm(item)
            wrench = move_wrench(transmitted.on_outer_side(item), arm)
            force, moment = wrench[:3], wrench[3:]
            acting.append((item.places[1], arm, force))
            axes = np.stack([self._direction(slide) for slide in item.slides], axis=1) if item.slides else None
            if item.edge.beam is None:
                acting.append((item.places[0], arm, -force))
                passages.append((item, arm, axes, self._of_joint(item, force, moment)))
            elif axes is not None:
                terms, start, back = self._of_beam(solution, item.edge.beam, axes, arm, force, moment)
                acting.append((item.places[0], start, back))
                passages.append((item, arm, axes, terms))
        return GeometricTerms(self, acting, passages, own)

    def _of_joint(self, item: Passage, force: Array, moment: Array) -> Array:
        """Return the matrix B (9, 9, N) of a joint's energy zᵀ B z = F · ((θ + ½ φ) × s) + ½ M · (θ × φ).

        The joint's force F and moment M (3, N) rotate with the mean rotation θ + ½ φ of its sides. The vector z consists of the
        rotation θ of the inner side, and of the shift s and the rotation φ of the outer side relative to the inner side. In a
        universal joint the second axis rotates with the inner part of the joint: this adds ½ q_1 q_2 M · (a_1 × a_2), with the
        angles q of φ about the axes a.
        """
        found = zeros_for((9, 9, force.shape[1]), force)
        found[:3, 3:6], found[6:, 3:6] = -skew(force), -skew(force) / 2
        if not item.is_ball:
            found[:3, 6:] = -skew(moment) / 2
        if item.is_universal:
            first, second = (self._direction(axis) for axis in item.turns)
            across = cross(first, second)
            size = np.sum(across * across, axis=0)
            one, two = cross(second, across) / size, cross(across, first) / size
            found[6:, 6:] = one[:, None] * two[None] * (np.sum(moment * across, axis=0) / 2)
        return found

    def _of_beam(
        self, solution: Solution, name: str, axes: Array, arm: Array, force: Array, moment: Array
    ) -> tuple[Array, Array, Array]:
        """Return the matrix B (9, 9, N) of a beam's second-order energy (see :meth:`_of_joint`), and the force at its inner end.

        ``force`` and ``moment`` (3, N) act on the part at the beam's outer end. B is followed by the arm (3, N) [m] from o to the
        beam's inner end, and the force (3, N) [N] on the part there.
        """
        model = self._robot.beams[name]
        length, lever = model.length(self._frames), model.lever(self._frames)
        weight = self._robot.weights.sum([f"beam:{name}"], solution.weights)[:3]
        local = [np.einsum("ijn,in->jn", axes, part) for part in (-force, -moment, weight, cross(lever, weight), lever)]
        wrench, load = np.concatenate(local[:2]), np.concatenate(local[2:4]) / length
        found = turned_forces(model.compliances[:, None], length, wrench, load, local[4])
        for k in (0, 3, 6):
            found[k : k + 3] = np.einsum("ijn,jkn->ikn", axes, found[k : k + 3])
            found[:, k : k + 3] = np.einsum("ijn,kjn->ikn", found[:, k : k + 3], axes)
        return found, arm - axes[:, 0] * length, weight - force

    def _direction(self, axis: Fixed) -> Array:
        return self._frames.direction(axis.body, axis.vector)

    def _arm(self, item: Passage) -> Array:
        return self._frames.point(item.centre.body, item.centre.vector) - self.o

    def without_spin(self, part: int) -> Array | None:
        """Return the projection (3, 3, N) that removes the rotation about a part's free spin axis; None without such an axis."""
        if part not in self.parts.spins:
            return None
        first, second = (self._arm(self.parts.passages[k]) for k in self.parts.spins[part])
        along = second - first
        return np.eye(3)[:, :, None] - along[:, None] * along[None] / np.sum(along * along, axis=0)


class _PassageWrenches:
    """Wrenches that passages transmit under weights and spring forces, without the load on the platform."""

    def __init__(self, robot: RobotStatics, solution: Solution) -> None:
        self._robot, self._solution = robot, solution
        self._loads = [item.load for item in solution.applied if item.load.kind == "spring"]
        own = [*solution.sources[1 : 2 + len(robot.topology.limbs)], *(item.name for item in self._loads)]
        which = [solution.sources.index(name) for name in own]
        self._cuts: dict[int, Array] = {}  # (M, 6, N) by the limb's number
        for number, statics in enumerate(solution.statics):
            parts = solution.cut_wrenches(number)
            mine = [*which, *range(len(solution.sources), parts.shape[2])]
            total = parts[:, :, mine].sum(axis=2)
            self._cuts |= {limb: total[:, :, position] for position, limb in enumerate(statics.group.numbers)}

    def on_outer_side(self, item: Passage) -> Array:
        """Return the wrench (6, N) of a passage's inner side on its outer side, about o [N, N·m]."""
        solution = self._solution
        total = self._robot.weights.carried_by(item.edge, solution.weights)
        for load in self._loads:
            for place, wrench in load.wrenches.items():
                if sign := carries(item.edge, place):
                    total = total + sign * wrench
        for cut, sign in item.edge.cut_joints:
            total = total + sign * self._cuts[item.owner][cut]
        return -total


def _at(twists: Array, arm: Array) -> Array:
    """Return the displacements (3, S, N) of a point at ``arm`` (3, N) from o due to twists (6, S, N) about o."""
    return move_twist(twists, arm)[:3]
