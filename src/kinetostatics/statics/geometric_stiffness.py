"""Geometric stiffness: change of the forces at the pose with displacement (method page, section 12).

The directions of weights are constant while their lever arms rotate; springs stretch and rotate; joint wrenches rotate with the
connected parts. Under a rotation θ of a part, a point at p moves by θ × p + ½ θ × (θ × p), so that a force f there has the
potential energy −½ f · (θ × (θ × p)) of second order.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from kinetostatics.limbs.beam_formulas import turned_forces
from kinetostatics.math.arrays import Array, zeros_for
from kinetostatics.math.linalg import cross
from kinetostatics.math.rotations import skew
from kinetostatics.math.screws import move_twist, move_wrench, wrench_of_force
from kinetostatics.mechanism.limbs import carries
from kinetostatics.mechanism.tree import Frames
from kinetostatics.statics.geometric_terms import Block, GeometricTerms, PlacedSpring, coordinates_of
from kinetostatics.statics.link_loads import AppliedLoad
from kinetostatics.statics.robot_statics import RobotStatics
from kinetostatics.statics.solution import Solution
from kinetostatics.statics.turning_parts import PLATFORM, Fixed, Passage, TurningParts


class GeometricStiffness:
    """The geometric stiffness of a robot at N poses, with the loads and motions conjugate to its displacements u.

    Attributes:
        coordinates: definition of u.
    """

    def __init__(self, robot: RobotStatics, parts: TurningParts, frames: Frames, springs: Sequence[PlacedSpring]) -> None:
        self._robot, self._parts, self._frames, self._springs = robot, parts, frames, springs
        self.coordinates = coordinates_of(parts)
        _, self._o = robot.mechanism.platform_pose(frames)

    def unit_loads(self) -> list[AppliedLoad]:
        """Return the unit forces, couples and pairs of forces conjugate to the displacements."""
        o, where = self._o, self.coordinates
        none, units = np.zeros_like(o), [np.broadcast_to(unit[:, None], o.shape) for unit in np.eye(3)]
        acting: list[dict[str, Array]] = []
        for kind, number in where.blocks:
            if kind == "shift":
                acting += [{self._parts.places[PLATFORM]: np.concatenate([unit, none])} for unit in units]
            elif kind == "part":
                place, without_spin = self._parts.places[number], self._without_spin(number)
                couples = units if without_spin is None else [without_spin[:, k] for k in range(3)]
                acting += [{place: np.concatenate([none, couple])} for couple in couples]
            elif kind == "slide":
                item = self._parts.passages[number]
                for slide in item.slides:
                    wrench = wrench_of_force(self._direction(slide), self._arm(item))
                    acting.append({item.places[0]: -wrench, item.places[1]: wrench})
            else:
                acting += [self._springs[number].pull(-unit, o)[0] for unit in units]
        return [AppliedLoad(name, wrenches, {}, "change") for name, wrenches in zip(where.names, acting, strict=True)]

    def displacements(self, motion: Callable[[str], Array], blocks: Sequence[Block]) -> Array:
        """Return components of u (n, S, N) from the twists (6, S, N) of places about o."""
        rows = []
        for kind, number in blocks:
            if kind == "shift":
                rows.append(motion(self._parts.places[PLATFORM])[:3])
            elif kind == "part":
                turned, without_spin = motion(self._parts.places[number])[3:], self._without_spin(number)
                rows.append(turned if without_spin is None else np.einsum("ijn,jsn->isn", without_spin, turned))
            elif kind == "slide":
                item = self._parts.passages[number]
                inner, outer = (_at(motion(place), self._arm(item)) for place in item.places)
                axes = np.stack([self._direction(slide) for slide in item.slides])
                rows.append(np.einsum("kin,isn->ksn", axes, outer - inner))
            else:
                spring = self._springs[number]
                ends: list[Array] = [
                    np.sum(
                        [np.where(here, _at(motion(place), point - self._o), 0.0) for place, here in places.items()],
                        axis=0,
                    )
                    for point, places in zip(spring.points, spring.places, strict=True)
                ]
                rows.append(ends[1] - ends[0])
        return np.concatenate(rows)

    def under(self, solution: Solution) -> GeometricTerms:
        """Return K_g under the weights and springs alone, in equilibrium with the joint wrenches.

        Args:
            solution: an equilibrium of the poses.
        """
        carried, parts = _Carried(self._robot, solution), self._parts
        acting: list[tuple[str, Array, Array]] = []
        centres = self._robot.weights.centres(self._frames) - self._o[:, None]
        for w, name in enumerate(self._robot.weights.names):
            if not name.startswith("beam:"):
                acting.append((name, centres[:, w], solution.weights[:3, w]))
        for spring in self._springs:
            for sign, end, places in zip((1, -1), spring.points, spring.places, strict=True):
                for place, here in places.items():
                    acting.append((place, end - self._o, np.where(here, sign * spring.force, np.zeros_like(end))))
        passages = []
        for item in parts.passages:
            arm = self._arm(item)
            wrench = move_wrench(carried.by_outer_side(item), arm)
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
        return GeometricTerms(self.coordinates, parts, self._o, self._springs, acting, passages, self._without_spin)

    def _of_joint(self, item: Passage, force: Array, moment: Array) -> Array:
        """Return B (9, 9, N) of a joint, whose wrench rotates with the mean rotation θ of its two sides.

        zᵀ B z = F · (θ × s) + ½ M · (θ_inner × φ) is the energy; z consists of the rotation θ_inner of the inner side, and of the
        shift s and the rotation φ of the outer side relative to it. In a universal joint the second axis rotates with the inner
        part of the joint: this adds ½ q_1 q_2 M · (a_1 × a_2), with the angles q of φ about the axes a.
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
        """Return B (9, 9, N) of a beam with force and moment (3, N) on its outer end, and its reaction (place, arm, force)."""
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
        return self._frames.point(item.centre.body, item.centre.vector) - self._o

    def _without_spin(self, part: int) -> Array | None:
        """Return the projection (3, 3, N) that removes the rotation about a part's free spin axis; None if it has none."""
        if part not in self._parts.spins:
            return None
        first, second = (self._arm(self._parts.passages[k]) for k in self._parts.spins[part])
        along = second - first
        return np.eye(3)[:, :, None] - along[:, None] * along[None] / np.sum(along * along, axis=0)


class _Carried:
    """Wrenches in passages under weights and springs."""

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

    def by_outer_side(self, item: Passage) -> Array:
        """Return the wrench (6, N) of the inner side on the outer side, about o."""
        solution = self._solution
        total = self._robot.weights.sum(item.edge.outboard, solution.weights)
        total = total - self._robot.weights.sum(item.edge.excluded, solution.weights)
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
