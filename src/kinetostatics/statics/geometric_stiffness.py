"""Geometric stiffness: the change, due to displacements, of the forces at a pose (method page, section 12).

The directions of weights are constant while their lever arms rotate; springs stretch and rotate; joint wrenches rotate with the
connected parts. Under a rotation θ of a group, a point at p moves by θ × p + ½ θ × (θ × p), so that a force f there has the
second-order potential energy −½ f · (θ × (θ × p)). The sum is a quadratic form ½ uᵀ K_g u in a few displacements u: rotations of
groups, transverse displacements across prismatic joints and beams, and relative displacements of the ends of springs.
An elastic link without an inside is an elastic joint at its outer end, with its weight on the inner end.
:mod:`kinetostatics.statics.rotation_groups` defines rotation groups, junctions (joints and beams), and blocks of u. An attachment
is a rigid link, or an end of a beam.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from kinetostatics.elements.spring import PlacedSpring
from kinetostatics.elements.turned_forces import without_inner
from kinetostatics.math.arrays import Array, zeros_for
from kinetostatics.math.linalg import cross
from kinetostatics.math.rotations import skew
from kinetostatics.math.screws import move_twist, move_wrench, wrench_of_force
from kinetostatics.mechanism.limbs import carries
from kinetostatics.mechanism.tree import Frames
from kinetostatics.statics.deformation import Deformation
from kinetostatics.statics.geometric_terms import GeometricTerms, JunctionTerms
from kinetostatics.statics.link_loads import AppliedLoad
from kinetostatics.statics.robot_statics import RobotStatics
from kinetostatics.statics.rotation_groups import PLATFORM, Block, Fixed, Junction, RotationGroups, coordinates_of
from kinetostatics.statics.solution import Solution

#: Length of a telescopic beam, relative to the robot's size, below which it counts as this long.
_SHORT = 1e-6


class GeometricStiffness:
    """The displacements u of a robot at N poses, the unit loads conjugate to u, and the geometric stiffness K_g.

    Attributes:
        coordinates: the blocks of u.
        o: (3, N) position of o [m].
    """

    def __init__(self, robot: RobotStatics, groups: RotationGroups, frames: Frames, springs: Sequence[PlacedSpring]) -> None:
        self._robot, self._frames, self.rotation_groups, self.springs = robot, frames, groups, springs
        self.coordinates = coordinates_of(groups)
        _, self.o = robot.mechanism.platform_pose(frames)

    def unit_loads(self) -> list[AppliedLoad]:
        """Return for each component of u its conjugate unit load: a force, a couple, or a pair of opposite forces."""
        o, where = self.o, self.coordinates
        none, units = np.zeros_like(o), [np.broadcast_to(unit[:, None], o.shape) for unit in np.eye(3)]
        acting: list[dict[str, Array]] = []
        for kind, number in where.blocks:
            if kind == "shift":
                acting += [{self.rotation_groups.attachments[PLATFORM]: np.concatenate([unit, none])} for unit in units]
            elif kind == "group":
                attachment, without_spin = self.rotation_groups.attachments[number], self.without_spin(number)
                couples = units if without_spin is None else [without_spin[:, k] for k in range(3)]
                acting += [{attachment: np.concatenate([none, couple])} for couple in couples]
            elif kind == "slide":
                item = self.rotation_groups.junctions[number]
                for slide in item.slides:
                    wrench = wrench_of_force(self._direction(slide), self._arm(item))
                    acting.append({item.attachments[0]: -wrench, item.attachments[1]: wrench})
            else:
                acting += [self.springs[number].end_wrenches(-unit, o)[0] for unit in units]
        return [AppliedLoad(name, wrenches, {}, "change") for name, wrenches in zip(where.names, acting, strict=True)]

    def displacements(self, motion: Callable[[str], Array], blocks: Sequence[Block]) -> Array:
        """Return the blocks (n, S, N) of u; ``motion(attachment)`` is the twist (6, S, N) of an attachment about o."""
        rows = []
        for kind, number in blocks:
            if kind == "shift":
                rows.append(motion(self.rotation_groups.attachments[PLATFORM])[:3])
            elif kind == "group":
                turned, without_spin = motion(self.rotation_groups.attachments[number])[3:], self.without_spin(number)
                rows.append(turned if without_spin is None else np.einsum("ijn,jsn->isn", without_spin, turned))
            elif kind == "slide":
                item = self.rotation_groups.junctions[number]
                inner, outer = (_at(motion(attachment), self._arm(item)) for attachment in item.attachments)
                axes = np.stack([self._direction(slide) for slide in item.slides])
                rows.append(np.einsum("kin,isn->ksn", axes, outer - inner))
            else:
                spring = self.springs[number]
                ends = zip(spring.points, spring.attachments, strict=True)
                start, end = (_at(motion(attachment), point - self.o) for point, attachment in ends)
                rows.append(end - start)
        return np.concatenate(rows)

    def under(
        self,
        solution: Solution,
        deformation: Deformation,
        contributions: Sequence[str] | None = None,
        own: bool = True,
        eliminated: bool = True,
    ) -> GeometricTerms:
        """Return K_g under the weights, spring forces and joint wrenches of an equilibrium.

        Args:
            deformation: the deformation in this equilibrium.
            contributions: those whose forces stiffen the robot; None: all but the load on the platform and those on links.
            own: whether K_g includes the tangent stiffness of the springs themselves.
            eliminated: whether the inner coordinates of beams are eliminated, unless the forces are those of unit loads.
        """
        acting_loads = [item.load for item in solution.applied if item.load.kind == "spring" or contributions is not None]
        if contributions is None:
            contributions = [*self._robot.contributions[1:], *(load.name for load in acting_loads)]
        acting_loads = [load for load in acting_loads if load.name in contributions]
        weighty = "platform_weight" in contributions
        which = [solution.contributions.index(name) for name in contributions]
        transmitted = JunctionWrenches(self._robot, solution, acting_loads, which, weighty)
        acting: list[tuple[str, Array, Array]] = []
        centres = self._robot.weights.centres(self._frames) - self.o[:, None]
        for w, name in enumerate(self._robot.weights.names if weighty else ()):
            link = name.removeprefix("beam:")
            if link not in deformation.places:
                attachment = name if link == name else self._robot.topology.span_ends[link][0]
                acting.append((attachment, centres[:, w], solution.weights[:3, w]))
        for load in acting_loads:
            for attachment, wrench in load.wrenches.items():
                if attachment in load.points:
                    acting.append((attachment, load.points[attachment] - self.o, wrench[:3]))
        junctions, inner = [], []
        for item in self.rotation_groups.junctions:
            arm = self._arm(item)
            wrench = move_wrench(transmitted.on_outer_side(item), arm)
            force, moment = wrench[:3], wrench[3:]
            acting.append((item.attachments[1], arm, force))
            axes = np.stack([self._direction(slide) for slide in item.slides], axis=1) if item.slides else None
            if item.edge.span not in deformation.places:
                acting.append((item.attachments[0], arm, -force))
                junctions.append(JunctionTerms(item, arm, axes, self._of_joint(item, force, moment)))
            elif axes is not None:
                terms, matrix, back = self._of_beam(solution, deformation, item, axes, which, weighty, eliminated)
                length = self._robot.elastic_links[str(item.edge.span)].length(self._frames)
                acting.append((item.attachments[0], arm - axes[:, 0] * length, back - force))
                junctions.append(JunctionTerms(item, arm, axes, *terms))
                inner.append(matrix)
        where, rotation_groups, springs = self.coordinates, self.rotation_groups, self.springs
        return GeometricTerms(where, rotation_groups, self.o, springs, self.without_spin, acting, junctions, inner, own)

    def _of_joint(self, item: Junction, force: Array, moment: Array) -> Array:
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
        self,
        solution: Solution,
        deformation: Deformation,
        item: Junction,
        axes: Array,
        which: Sequence[int],
        weighty: bool,
        eliminated: bool,
    ) -> tuple[tuple[Array, Array | None, tuple[Array, Array] | None], Array, Array]:
        """Return ``B``, ``constant`` and ``whole`` of :class:`JunctionTerms`, the stiffness of inner coordinates, and weight.

        Inner coordinates η of stiffness K_ηη = 1 + K_g,ηη, in which the forces deflect the beam by η_0, are eliminated:
        2 B = K_zz − K_zη K_ηη⁻¹ K_ηz, and ``constant`` = K_zη K_ηη⁻¹ η_0.
        """
        name, S = str(item.edge.span), len(solution.contributions)
        model = self._robot.beams[name]
        length, lever = model.length(self._frames), model.lever(self._frames)
        if model.telescopic:  # on open branches it may have no length
            length = np.maximum(length, _SHORT * self._robot.length)
        weight = self._robot.weights.sum([f"beam:{name}"], solution.weights)[:3] * float(weighty)
        number, position = deformation.places[name]
        stack = deformation.beams[number]
        sections = stack.sections(model.inside.nodes)[:, :, :, position]
        every = [*which, *(range(S, sections.shape[2]) if weighty else ())]
        load = np.einsum("ijn,in->jn", axes, weight) / length
        turned = None if model.centre is None else np.einsum("ijn,in->jn", axes, lever)
        K = model.inside.turned_forces(length, sections[:, :, every].sum(axis=2), load, turned)
        own = np.eye(model.inside.count)[:, :, None] + K[9:, 9:]
        if not weighty or not eliminated:  # under unit loads to first order in the forces: without inner coordinates
            B = K[:9, :9] / 2
            for k in (0, 3, 6):
                B[k : k + 3] = np.einsum("ijn,jkn->ikn", axes, B[k : k + 3])
                B[:, k : k + 3] = np.einsum("ijn,kjn->ikn", B[:, k : k + 3], axes)
            return (B, None, (K, axes)), own, weight
        given = model.inside.inner_deflections(length, sections)
        first = next((k for k, name in enumerate(solution.contributions) if name.startswith("spring ")), 0)
        given[:, first : first + 1] += given[:, S:].sum(axis=1, keepdims=True)  # of bodies attached only to the base
        left = without_inner(K, given[:, :S])
        for k in (0, 3, 6):
            left[k : k + 3] = np.einsum("ijn,jkn->ikn", axes, left[k : k + 3])
            left[:, k : k + 3] = np.einsum("ijn,kjn->ikn", left[:, k : k + 3], axes)
        return (left[:, :9] / 2, left[:, 9:], None), own, weight

    def _direction(self, axis: Fixed) -> Array:
        return self._frames.direction(axis.body, axis.vector)

    def _arm(self, item: Junction) -> Array:
        return self._frames.point(item.centre.body, item.centre.vector) - self.o

    def without_spin(self, group: int) -> Array | None:
        """Return the projection 1 − n nᵀ (3, 3, N) that removes rotations about a group's free spin axis n; None without one."""
        if group not in self.rotation_groups.spins:
            return None
        first, second = (self._arm(self.rotation_groups.junctions[k]) for k in self.rotation_groups.spins[group])
        along = second - first
        return np.eye(3)[:, :, None] - along[:, None] * along[None] / np.sum(along * along, axis=0)


class JunctionWrenches:
    """Wrenches that junctions transmit under some contributions (indices ``which``), of loads and, if ``weighty``, weights."""

    def __init__(
        self, robot: RobotStatics, solution: Solution, loads: Sequence[AppliedLoad], which: Sequence[int], weighty: bool
    ) -> None:
        self._robot, self._solution, self._loads, self._weighty = robot, solution, loads, weighty
        self._cuts: dict[int, Array] = {}  # (M, 6, N) by the limb's number
        for number, statics in enumerate(solution.statics):
            parts = solution.cut_wrenches(number)
            every = [*which, *(range(len(solution.contributions), parts.shape[2]) if weighty else ())]
            total = parts[:, :, every].sum(axis=2)
            self._cuts |= {limb: total[:, :, position] for position, limb in enumerate(statics.group.numbers)}

    def on_outer_side(self, item: Junction) -> Array:
        """Return the wrench −(Σ ± X + Σ w) (6, N) of a junction's inner on its outer side, about o [N, N·m].

        X are cut-joint wrenches, w the weights and loads outboard of the junction.
        """
        total = self._robot.weights.carried_by(item.edge, self._solution.weights) * float(self._weighty)
        for load in self._loads:
            for attachment, wrench in load.wrenches.items():
                if sign := carries(item.edge, attachment):
                    total = total + sign * wrench
        for limb, cut, sign in (*((item.owner, *pair) for pair in item.edge.cut_joints), *item.edge.limb_cuts):
            total = total + sign * self._cuts[limb][cut]
        return -total


def _at(twists: Array, arm: Array) -> Array:
    """Return the displacements d + r × arm (3, S, N) of a point at ``arm`` (3, N) from o due to twists [d; r] (6, S, N)."""
    return move_twist(twists, arm)[:3]
