"""Groups of equal limbs. The edges of a limb are its joints and beams. The wrench in an edge is the sum of the wrenches in the
cut joints of the limb (:mod:`kinetostatics.mechanism.limbs`), with signs 1, −1 or 0, and of the weights outboard of the edge, on
the side of the platform. Arrays are ``(component, column, limb, pose)``.
"""

from __future__ import annotations

import copy
from collections.abc import Collection, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from kinetostatics.elements.actuator import Actuators, MovedFreedom, branch_joints
from kinetostatics.elements.element import ElasticElement, carried_wrench, outboard_masks
from kinetostatics.elements.joint import ElasticJoints
from kinetostatics.elements.static_model import StaticModel
from kinetostatics.limbs.force_method import EliminationOrder
from kinetostatics.limbs.geometry import Basis, LimbGeometry, LimbSkeleton
from kinetostatics.math.arrays import Array, Mask, zeros_for
from kinetostatics.mechanism.joints import compound_joints, elastic_actuators, limb_elements, springs_of
from kinetostatics.mechanism.limbs import Edge
from kinetostatics.mechanism.tree import Frames


class LimbGroup:
    """Equal limbs, stacked.

    Attributes:
        numbers: their indices among the robot's limbs.
        compounds: for every limb, its joints.
        elements: for every limb, its beams and joints; corresponding joints may consist of different numbers of edges.
        elastic: the elastic elements: beams, joints, actuators, inboard ones first.
        dofs: for every limb, the freedoms of its joints, inboard ones first.
        passive, rotates: (k,) True for passive freedoms; True for rotations.
        compound_of: (k,) index of the compound joint of each freedom.
        platform_joint: (k,) True for the freedoms of the platform joint.
        dof_cut_signs, element_cut_signs: (…, M) signs of the cut-joint wrenches in each freedom and element.
        to_platform: (M,) True for the cut joints at the platform.

    Decided once, at generic poses (:mod:`kinetostatics.limbs.grouping`):

    Attributes:
        elimination: order of elimination for the cut-joint wrenches of a limb that is not serial.
        basis: the canonical wrenches, equal except for their labels.
        labels, attached_labels: names of the columns of J_ic and J_ig, for each limb.
        rigid_directions: number of combinations of the constraint wrenches along which the limb is rigid.
        soft: constraint wrenches that span the range of the compliance.
        at_one_pose: whether this was decided for a single pose with other ranks (:mod:`kinetostatics.statics.singularity`).
    """

    elimination: EliminationOrder | None = None
    basis: Basis
    labels: list[tuple[str, ...]]
    attached_labels: list[tuple[str, ...]]
    rigid_directions: int = 0
    soft: tuple[int, ...] = ()
    at_one_pose: bool = False

    def __init__(self, model: StaticModel, numbers: Sequence[int], joined: Collection[tuple[str, ...]] | None = None) -> None:
        self.model, self.numbers = model, tuple(numbers)
        self.limbs = [model.topology.all_limbs[k] for k in numbers]
        self.compounds = [compound_joints(model.mechanism, limb, joined) for limb in self.limbs]
        self.elements = [limb_elements(limb, compounds) for limb, compounds in zip(self.limbs, self.compounds, strict=True)]
        limb = self.limbs[0]
        self.to_platform = np.array(limb.to_platform, dtype=bool)
        self._freedom_edges = [
            [limb.edges[compound.edge] for compound in compounds for _ in compound.dofs]
            for limb, compounds in zip(self.limbs, self.compounds, strict=True)
        ]
        self.dof_cut_signs = self._cut_signs(self._freedom_edges[0])
        self.element_cut_signs = self._cut_signs([limb.edges[element.edges[-1]] for element in self.elements[0]])
        self.elastic: tuple[ElasticElement, ...] = (*self._links(), *self._elastic_joints(), *self._actuators())
        self._skeleton = LimbSkeleton(model, self.limbs, self.compounds, self.elastic)
        self.dofs, self.passive = self._skeleton.dofs, self._skeleton.passive
        self.rotates, self.compound_of = self._skeleton.rotates, self._skeleton.compound_of
        self.platform_joint = self._platform_joint()
        self._outboard_of_weights = self._outboard_of(model.weights.names)

    def decided(
        self,
        elimination: EliminationOrder | None,
        bases: Sequence[Basis] = (),
        rigid_directions: int = 0,
        soft: tuple[int, ...] = (),
    ) -> LimbGroup:
        """Return the same limbs with the decisions made at generic poses; ``bases`` contains the basis of each limb."""
        group = copy.copy(self)
        group.elimination, group.rigid_directions, group.soft = elimination, rigid_directions, soft
        if bases:
            group.basis = bases[0]
            free = () if elimination is None or not self.model.topology.plates else elimination.free
            stresses = tuple(f"self-stress {k}" for k, _ in enumerate(free, 1))
            group.labels = [(*(c.label for c in basis.constraint), *stresses) for basis in bases]
            group.attached_labels = [tuple(c.label for c in basis.attached) for basis in bases]
        return group

    def alone(self, position: int) -> LimbGroup:
        """Return one of the limbs as a separate group, with its decisions."""
        return self.on(self.model, [position])

    def on(self, model: StaticModel, positions: Sequence[int] | None = None) -> LimbGroup:
        """Return the limbs at ``positions`` (default all) of a robot of equal structure, with the decisions of this group."""
        positions = range(len(self.numbers)) if positions is None else positions
        joined = {compound.joints for row in self.compounds for compound in row}
        group = LimbGroup(model, [self.numbers[k] for k in positions], joined)
        group = group.decided(self.elimination, (), self.rigid_directions, self.soft)
        group.basis, group.labels = self.basis, [self.labels[k] for k in positions]
        group.attached_labels = [self.attached_labels[k] for k in positions]
        return group

    @property
    def is_serial(self) -> bool:
        """Whether the limb is a single chain from base to platform."""
        return self.limbs[0].is_serial

    @property
    def is_attached(self) -> bool:
        """Whether these are closed chains attached only to the base, or only to the platform."""
        return not np.any(self.to_platform)

    @property
    def partly_elastic(self) -> bool:
        """Whether the limb has elastic elements, but none that every force and moment deforms."""
        return bool(self.elastic) and not any(element.in_every_direction for element in self.elastic)

    @property
    def signature(self) -> tuple[object, ...]:
        """Key that limbs of one group share."""
        return (
            tuple((compound.type, tuple((f.rotates, f.passive) for f in compound.dofs)) for compound in self.compounds[0]),
            tuple(element.signature for element in self.elements[0]),
            tuple(element.signature for element in self.elastic),
            tuple(self.platform_joint.tolist()),
            self.limbs[0].to_platform,
            self.limbs[0].on_platform,
            self._skeleton.y_choice,
        )

    def geometry(self, frames: Frames, o: Array) -> LimbGeometry:
        return self._skeleton.geometry(frames, o)

    def _links(self) -> Iterator[ElasticElement]:
        ends: dict[str, list[int]] = {}  # elements by elastic link
        for number, element in enumerate(self.elements[0]):
            if element.is_link:
                span = self.model.topology.spans[str(self._edges_of(number)[0].span)]
                ends.setdefault(span.part.name, []).append(number)
        for numbers in ends.values():
            rows = [self._edges_of(number) for number in numbers]
            links = [[self.model.elastic_links[str(edge.span)] for edge in edges] for edges in rows]
            signs = self.element_cut_signs[numbers]
            if len(numbers) == 1:
                yield links[0][0].stacked(links[0], rows[0], numbers[0], signs[0])
            else:
                yield links[0][0].coupled(list(zip(*links, strict=True)), list(zip(*rows, strict=True)), numbers, signs)

    def _elastic_joints(self) -> Iterator[ElasticJoints]:
        for number in range(len(self.elements[0])):
            edges = self._edges_of(number)
            joints = [springs_of(self.model.mechanism, edge.joint) if edge.joint else () for edge in edges]
            for alike in zip(*joints, strict=True):
                yield ElasticJoints(alike, edges, number, self.element_cut_signs[number])

    def _edges_of(self, element: int) -> list[Edge]:
        """Return the outermost edge of an element in each limb."""
        return [limb.edges[row[element].edges[-1]] for limb, row in zip(self.limbs, self.elements, strict=True)]

    def _actuators(self) -> Iterator[Actuators]:
        actuators, model = list(elastic_actuators(self.model.mechanism).values()), self.model
        element_of = {element.compound: number for number, element in enumerate(self.elements[0])}
        freedoms = [(c, dof.rotates) for c, compound in enumerate(self.compounds[0]) for dof in compound.dofs]
        rows = []
        for compounds in self.compounds:
            joints = [c.joints[0] for c in compounds for _ in c.dofs]
            moves = [sorted((joints.index(name), ratio) for name, ratio in a.moves if name in joints) for a in actuators]
            moving = [(actuator, own) for actuator, own in zip(actuators, moves, strict=True) if own]
            rows.append(sorted(moving, key=lambda row: row[1][0]))
        for alike in zip(*rows, strict=True):
            ratios = np.array([[ratio for _, ratio in moves] for _, moves in alike]).T[..., None]
            moved_freedoms = [
                MovedFreedom(
                    number=number,
                    element=element_of[freedoms[number][0]],
                    rotates=freedoms[number][1],
                    signs=self.dof_cut_signs[number],
                    edges=tuple(row[number] for row in self._freedom_edges),
                    ratios=ratio,
                )
                for (number, _), ratio in zip(alike[0][1], ratios, strict=True)
            ]
            branches = [branch_joints(model.mechanism, model.topology, actuator) for actuator, _ in alike]
            yield Actuators([actuator for actuator, _ in alike], moved_freedoms, branches)

    def _platform_joint(self) -> Mask:
        """True for freedoms of the platform joint (k,): the outermost passive joints, with neither beam nor weight between them.

        If several joints lead to the platform, there is no platform joint.
        """
        limb = self.limbs[0]
        inside = np.zeros(len(self.passive), dtype=bool)
        if np.sum(self.to_platform) != 1:
            return inside
        last = ((int(np.flatnonzero(self.to_platform)[0]), 1),)
        position = max(k for k, edge in enumerate(limb.edges) if edge.cut_joints == last)
        outermost = position
        while position >= 0:
            edge = limb.edges[position]
            if edge.span or (limb.ends[position] and position < outermost):
                break
            connection = self.model.mechanism.connections[str(edge.joint)]
            if connection.actuated or connection.name in self.model.description.joint_stiffness:
                break
            for k, compound in enumerate(self.compounds[0]):
                if connection.name in compound.joints:
                    inside |= self.compound_of == k
            position -= 1
        return inside

    # ---- weights and loads ----------------------------------------------------------------------------------------------

    @property
    def attachments(self) -> set[str]:
        """Places at which loads affect the limbs: on the limbs, and on open branches that their actuators move."""
        return set().union(*(element.attachments for element in self.elastic), *(limb.attachments for limb in self.limbs))

    def _outboard_of(self, names: Sequence[str]) -> tuple[Array, list[list[Array]]]:
        """Return masks of the weights that are outboard: of the freedoms (g, k, W), and of each elastic element."""
        freedoms = np.array([outboard_masks(edges, names) for edges in self._freedom_edges])
        return freedoms.reshape(len(self.limbs), len(self._freedom_edges[0]), len(names)), [
            element.outboard(names) for element in self.elastic
        ]

    def carried(
        self, geometry: LimbGeometry, wrenches: Array, names: Sequence[str] | None = None
    ) -> tuple[Array, tuple[Array, ...]]:
        """Return what passive freedoms and elastic elements carry under weights or loads.

        Args:
            wrenches: (6, W, N) weights or loads about o, world axes [N, N·m].
            names: names of the loaded attachments; None: the wrenches are the robot's weights.

        Returns:
            The sums (6, passive freedoms, g, N) of the wrenches outboard of the passive freedoms, and for each element its
            :meth:`kinetostatics.elements.element.PlacedElement.carried_loads`.
        """
        freedoms, elements = self._outboard_of_weights if names is None else self._outboard_of(names)
        on_elements = tuple(
            placed.carried_loads(outboard, wrenches) for placed, outboard in zip(geometry.elements, elements, strict=True)
        )
        return np.einsum("gkw,iwn->ikgn", freedoms[:, self.passive], wrenches), on_elements

    # ---- cut joints -----------------------------------------------------------------------------------------------------

    def _cut_signs(self, edges: list[Edge]) -> NDArray[np.int8]:
        """Return the signs (edges, M) of the cut-joint wrenches in given edges."""
        table = np.zeros((len(edges), len(self.to_platform)), dtype=np.int8)
        for row, edge in enumerate(edges):
            for cut, sign in edge.cut_joints:
                table[row, cut] = sign
        return table

    def joint_equations(self, geometry: LimbGeometry) -> Array:
        """Return the matrix (k, 6 M, g, N) for the power of scaled cut-joint wrenches on each of k passive freedoms, Eq. (2)."""
        scaled = (geometry.twists[:, self.passive] * self.twist_scale).swapaxes(0, 1) / self.power_scale
        signs = self.dof_cut_signs[self.passive]
        rows = zeros_for((*signs.shape, *scaled.shape[1:]), scaled)
        for dof, cut in np.argwhere(signs).tolist():
            rows[dof, cut] = signs[dof, cut] * scaled[dof]
        return rows.reshape(len(signs), 6 * signs.shape[1], *scaled.shape[2:])

    @property
    def joint_pattern(self) -> Mask:
        """Mask (k, 6 M): True for the coefficients of :meth:`joint_equations` that may differ from zero."""
        return np.repeat(self.dof_cut_signs[self.passive] != 0, 6, axis=1)

    @property
    def platform_sum(self) -> Array:
        """Matrix (6, 6 M) that adds up the cut-joint wrenches at the platform."""
        return np.concatenate([np.eye(6) * counts for counts in self.to_platform], axis=1)

    @property
    def twist_scale(self) -> Array:
        """Factors (6, 1, 1, 1) that scale twists, for use with moments divided by the characteristic length."""
        return np.array([1.0] * 3 + [self.model.length] * 3).reshape(6, 1, 1, 1)

    def even_twists(self, geometry: LimbGeometry) -> Array:
        """Return dimensionless twists (6, k, g, N) of all freedoms: rotations by 1 rad, translations by the robot's length."""
        return geometry.twists * self.twist_scale / np.where(self.rotates, self.model.length, 1.0)[:, None, None]

    @property
    def power_scale(self) -> Array:
        """Scale (passive freedoms, 1, 1, 1) of powers: 1 for translations, the characteristic length [m] for rotations."""
        return np.where(self.rotates[self.passive], self.model.length, 1.0).reshape(-1, 1, 1, 1)

    def platform_wrench(self, cut_wrenches: Array) -> Array:
        """Return the wrench (6, …) of the platform on the limb from cut-joint wrenches (M, 6, …)."""
        return carried_wrench(self.to_platform.astype(np.int8), cut_wrenches)
