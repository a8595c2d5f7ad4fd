"""Groups of equal limbs. The edges of a limb are its joints and beams. The wrench in an edge is the sum of the wrenches in the
cut joints of the limb (:mod:`kinetostatics.mechanism.limbs`), with signs 1, −1 or 0, and of the weights outboard of the edge, on
the side of the platform. Arrays are ``(component, column, limb, pose)``.
"""

from __future__ import annotations

import copy
import functools
from collections.abc import Collection, Sequence

import numpy as np
from numpy.typing import NDArray

from kinetostatics.limbs.force_method import EliminationOrder
from kinetostatics.limbs.geometry import Basis, LimbGeometry, LimbSkeleton
from kinetostatics.limbs.static_model import StaticModel, limb_drives
from kinetostatics.math.arrays import Array, Mask, zeros_for
from kinetostatics.mechanism.joints import compound_joints, drives_of, limb_elements, springs_of
from kinetostatics.mechanism.limbs import Edge, carries
from kinetostatics.mechanism.tree import Frames


class LimbGroup:
    """Equal limbs, stacked.

    Attributes:
        numbers: their indices among the robot's limbs.
        compounds: for every limb, its joints.
        elements: for every limb, its beams and joints; corresponding joints may consist of different numbers of edges.
        beams, springs: for every limb, the beams and springs on its edges, inboard ones first.
        drives: the elastic actuators of the limbs.
        spring_elements: index of the element of each spring.
        dofs: for every limb, the freedoms of its joints, inboard ones first.
        passive, rotates: (k,) True for passive freedoms; True for rotations.
        compound_of: (k,) index of the compound joint of each freedom.
        platform_joint: (k,) True for the freedoms of the platform joint.
        compliances: (6, beams, g, 1) section compliances.
        beam_masses, beam_masses_per_length: (beams, g, 1) mass [kg] and mass per length [kg/m]; NaN if not given.
        spring_linear, spring_angular: (3, 3, springs, g) compliances [m/N], [rad/(N·m)].
        dof_cut_signs, beam_cut_signs, spring_cut_signs, element_cut_signs: (…, M) signs of the cut-joint wrenches in each
            freedom, beam, spring and element.
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
        self._edges = freedom_edges, beam_edges, spring_edges = self._edges_of_members()
        self.beams = [[model.beams[str(edge.beam)] for edge in row] for row in beam_edges]
        springs = functools.partial(springs_of, model.mechanism)
        self.springs = [[spring for edge in limb.edges if edge.joint for spring in springs(edge.joint)] for limb in self.limbs]
        self._skeleton = LimbSkeleton(model, self.limbs, self.compounds, self.beams, self.springs)
        self.dofs, self.passive = self._skeleton.dofs, self._skeleton.passive
        self.rotates, self.compound_of = self._skeleton.rotates, self._skeleton.compound_of
        names = [[c.joints[0] for c in row for _ in c.dofs] for row in self.compounds]  # joints of the driven freedoms
        self.drives = limb_drives(model, list(drives_of(model.mechanism).values()), names)
        self.compliances = _members_last([[m.compliances for m in row] for row in self.beams], (6,))[..., None]
        self.beam_masses = _members_last([[np.array(m.mass) for m in row] for row in self.beams], ())[..., None]
        self.beam_masses_per_length = _members_last(
            [[np.array(np.nan if m.mass_per_length is None else m.mass_per_length) for m in row] for row in self.beams], ()
        )[..., None]
        self.spring_linear = _members_last([[spring.linear for spring in row] for row in self.springs], (3, 3))
        self.spring_angular = _members_last([[spring.angular for spring in row] for row in self.springs], (3, 3))
        limb, elements = self.limbs[0], self.elements[0]
        element_of = {k: number for number, element in enumerate(elements) for k in element.edges}
        self.spring_elements = tuple(element_of[limb.edges.index(edge)] for edge in spring_edges[0])
        self.to_platform = np.array(limb.to_platform, dtype=bool)
        self.dof_cut_signs = self._cut_signs(freedom_edges[0])
        self.beam_cut_signs = self._cut_signs(beam_edges[0])
        self.spring_cut_signs = self._cut_signs(spring_edges[0])
        self.element_cut_signs = self._cut_signs([limb.edges[element.edges[-1]] for element in elements])
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
            group.labels = [tuple(c.label for c in basis.constraint) for basis in bases]
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

    def spring(self, number: int) -> tuple[Array, Array]:
        """Return the linear and angular compliances (3, 3, g) of corresponding springs."""
        return self.spring_linear[:, :, number], self.spring_angular[:, :, number]

    @property
    def only_springs(self) -> bool:
        """Whether only joints, bearings and actuators are elastic."""
        return bool(self.springs[0] or self.drives) and not self.beams[0]

    @property
    def signature(self) -> tuple[object, ...]:
        """Key that limbs of one group share."""
        return (
            tuple((compound.type, tuple((f.rotates, f.passive) for f in compound.dofs)) for compound in self.compounds[0]),
            tuple(element.signature for element in self.elements[0]),
            tuple(map(tuple, self.spring_cut_signs.tolist())),
            self.spring_elements,
            tuple((drive.freedoms, len(drive.branches[0])) for drive in self.drives),
            tuple(self.platform_joint.tolist()),
            self.limbs[0].to_platform,
            self.limbs[0].on_platform,
            self._skeleton.y_choice,
        )

    def geometry(self, frames: Frames, o: Array) -> LimbGeometry:
        return self._skeleton.geometry(frames, o)

    def _edges_of_members(self) -> tuple[list[list[Edge]], list[list[Edge]], list[list[Edge]]]:
        """Return for every limb the edges of its freedoms, of its beams and of its springs."""
        freedoms = [
            [limb.edges[compound.edge] for compound in compounds for _ in compound.dofs]
            for limb, compounds in zip(self.limbs, self.compounds, strict=True)
        ]
        beams = [[edge for edge in limb.edges if edge.beam] for limb in self.limbs]
        joints = [[edge for edge in limb.edges if edge.joint] for limb in self.limbs]
        springs = [[edge for edge in row for _ in springs_of(self.model.mechanism, str(edge.joint))] for row in joints]
        return freedoms, beams, springs

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
            if edge.beam or (limb.ends[position] and position < outermost):
                break
            connection = self.model.mechanism.connections[str(edge.joint)]
            if connection.driven or connection.name in self.model.description.joint_stiffness:
                break
            for k, compound in enumerate(self.compounds[0]):
                if connection.name in compound.joints:
                    inside |= self.compound_of == k
            position -= 1
        return inside

    # ---- weights and loads ----------------------------------------------------------------------------------------------

    @property
    def places(self) -> set[str]:
        """Places at which loads affect the limbs: on the limbs, and on open branches that their actuators move."""
        on_branches = {place for drive in self.drives for row in drive.branches for joint in row for place in joint.edge.outboard}
        return on_branches.union(*(limb.places for limb in self.limbs))

    def _outboard_of(self, names: Sequence[str]) -> list[Array]:
        """Return three masks, (g, k, W) for the k freedoms, the k beams and the k springs: 1 where weight W is outboard of it."""
        tables = [[[[carries(edge, name) for name in names] for edge in row] for row in rows] for rows in self._edges]
        return [np.array(table, dtype=float).reshape(len(table), len(table[0]), len(names)) for table in tables]

    def carried(
        self, geometry: LimbGeometry, frames: Frames, o: Array, wrenches: Array, names: Sequence[str] | None = None
    ) -> tuple[Array, Array, Array, Array]:
        """Return the sums of the wrenches outboard of passive freedoms, beams and springs, and the wrenches' forces on actuators.

        Args:
            wrenches: (6, W, N) weights or loads about o, world axes [N, N·m].
            names: names of the loaded places; None: the wrenches are the robot's weights.

        Returns:
            Arrays (6, passive freedoms, g, N), (6, beams, g, N), (6, springs, g, N) and (1, elastic actuators, g, N).
        """
        tables = self._outboard_of_weights if names is None else self._outboard_of(names)
        freedoms, beams, springs = (np.einsum("gkw,iwn->ikgn", table, wrenches) for table in tables)
        forces = zeros_for((1, len(self.drives), *geometry.centres.shape[-2:]), geometry.centres)
        for number, drive in enumerate(self.drives):
            which = list(drive.freedoms)
            forces[0, number] = np.einsum("ikgn,ikgn->gn", geometry.twists[:, which] * drive.ratios, freedoms[:, which])
            for position, joints in enumerate(drive.branches):
                for joint in joints:
                    mask = [float(carries(joint.edge, name)) for name in names or self.model.weights.names]
                    own = np.einsum("w,iwn->in", mask, wrenches)
                    forces[0, number, position] += np.einsum("in,in->n", joint.twist(frames, o), own)
        return freedoms[:, self.passive], beams, springs, forces

    def on_drive(self, geometry: LimbGeometry, number: int, cut_wrenches: Array) -> Array:
        """Return the force or torque (…, g, N) of cut-joint wrenches (M, 6, …, g, N) on an elastic actuator."""
        drive, total = self.drives[number], np.zeros(cut_wrenches.shape[2:])
        for freedom, ratio in zip(drive.freedoms, drive.ratios, strict=True):
            carried = carried_wrench(self.dof_cut_signs[freedom], cut_wrenches)
            total = total + np.einsum("i...,ij...->j...", geometry.twists[:, freedom] * ratio, carried)
        return total

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


def carried_wrench(signs: NDArray[np.int8], cut_wrenches: Array) -> Array:
    """Return the sum (6, …) of cut-joint wrenches (M, 6, …) with the ``signs`` (M,) of an edge: its wrench without weights."""
    if len(signs) == 1 and signs[0] == 1:
        return cut_wrenches[0]
    total = np.zeros(cut_wrenches.shape[1:])
    for number in np.flatnonzero(signs):
        total += signs[number] * cut_wrenches[number]
    return total


def _members_last(rows: list[list[Array]], shape: tuple[int, ...]) -> Array:
    """Return constants of members (beams or springs) of g limbs as an array (*shape, members, g)."""
    array: Array = np.array(rows, dtype=float).reshape(len(rows), len(rows[0]), *shape)
    return np.moveaxis(array, (0, 1), (-1, -2))
