"""Elastic actuators in limbs. An actuator with mimic joints deforms along all its freedoms, under the sum of their forces.

Let s_j be the unit twists of the actuated joint and of the joints that mimic it with ratios r_j, and w_j their wrenches. The
force of the actuator is f = Σ r_j s_jᵀ w_j; with the compliance c it moves joint j by r_j s_j c f. This adds one term of rank one
per actuator to the sums of Eqs. (1) and (16). Some of these joints may be in open branches: chains of links with a free end.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinetostatics.elements.element import WithoutInside, carried_wrench, outboard_masks
from kinetostatics.math.arrays import Array, zeros_for
from kinetostatics.mechanism.joints import ElasticActuator, Freedoms, freedoms_of
from kinetostatics.mechanism.limbs import Edge, Topology
from kinetostatics.mechanism.mechanism import Mechanism
from kinetostatics.mechanism.tree import Frames


@dataclass(frozen=True)
class BranchJoint:
    """A joint of an open branch that an elastic actuator moves.

    Attributes:
        edge: the joint, directed outwards.
        ratio: its motion per unit of the actuator's coordinate.
    """

    edge: Edge
    ratio: float
    freedoms: Freedoms

    def twist(self, frames: Frames, o: Array) -> Array:
        """Return the twist (6, N) of the joint's outer side about o, per unit of the actuator's coordinate."""
        return self.freedoms.twists(frames, o)[:, 0] * self.ratio


def branch_joints(mechanism: Mechanism, topology: Topology, actuator: ElasticActuator) -> tuple[BranchJoint, ...]:
    ratios = dict(actuator.moves)
    edges = [edge for edge in topology.branch_edges if edge.joint in ratios]
    freedoms = [Freedoms(freedoms_of(mechanism, mechanism.connections[str(edge.joint)], edge.sign)) for edge in edges]
    return tuple(BranchJoint(edge, ratios[str(edge.joint)], own) for edge, own in zip(edges, freedoms, strict=True))


@dataclass(frozen=True)
class MovedFreedom:
    """Corresponding freedoms of g limbs that actuators move.

    Attributes:
        number: index of the freedom in the limb.
        element: index of the element of the limb to which it belongs.
        rotates: whether it is a rotation.
        signs: (M,) signs of the cut-joint wrenches that its joint transmits.
        edges: the joint's edge in each limb.
        ratios: (g, 1) motion per unit of the actuator's coordinate.
    """

    number: int
    element: int
    rotates: bool
    signs: NDArray[np.int8]
    edges: tuple[Edge, ...]
    ratios: Array


class Actuators:
    """Corresponding elastic actuators of g equal limbs, see :class:`kinetostatics.elements.element.ElasticElement`."""

    kind = "actuators"
    in_every_direction = has_line = has_inside = False

    def __init__(
        self, actuators: Sequence[ElasticActuator], freedoms: Sequence[MovedFreedom], branches: Sequence[tuple[BranchJoint, ...]]
    ) -> None:
        """Set the actuators; ``branches``: for each limb, the joints of open branches that the actuator moves."""
        self.names = tuple(actuator.joint for actuator in actuators)
        self.freedoms, self.branches = tuple(freedoms), tuple(branches)
        self.compliance = np.array([actuator.compliance for actuator in actuators])[:, None]  # (g, 1) [m/N, rad/(N·m)]

    @property
    def attachments(self) -> frozenset[str]:
        return frozenset(attachment for row in self.branches for joint in row for attachment in joint.edge.outboard)

    @property
    def signature(self) -> tuple[object, ...]:
        return self.kind, tuple(freedom.number for freedom in self.freedoms), len(self.branches[0])

    def outboard(self, names: Sequence[str]) -> list[Array]:
        edges = [*(freedom.edges for freedom in self.freedoms), *([joint.edge for joint in row] for row in self.branches)]
        return [outboard_masks(row, names) for row in edges]

    def placed(self, frames: Frames, o: Array, twists: Array) -> PlacedActuators:
        rows = [twists[:, freedom.number] * freedom.ratios for freedom in self.freedoms]
        return PlacedActuators(self, rows, [[joint.twist(frames, o) for joint in row] for row in self.branches])


@dataclass(frozen=True, eq=False)
class PlacedActuators(WithoutInside):
    """Corresponding elastic actuators at N poses.

    Attributes:
        twists: for each freedom, its twists (6, g, N) about o per unit of the actuators' coordinates.
        branch_twists: for each limb, the twists (6, N) of the joints of open branches.
    """

    actuators: Actuators
    twists: list[Array]
    branch_twists: list[list[Array]]

    def carried(self, cut_wrenches: Array) -> Array:
        """Return f = Σ r_j s_jᵀ w_j."""
        total = np.zeros((1, *cut_wrenches.shape[2:]))
        for freedom, twist in zip(self.actuators.freedoms, self.twists, strict=True):
            total = total + np.einsum("i...,ij...->j...", twist, carried_wrench(freedom.signs, cut_wrenches)[:, None])
        return total

    def carried_loads(self, outboard: Sequence[Array], wrenches: Array) -> Array:
        own, branches = outboard[: len(self.twists)], outboard[len(self.twists) :]
        force = zeros_for((1, *self.twists[0].shape[1:]), wrenches, *self.twists)
        for twist, mask in zip(self.twists, own, strict=True):
            force[0] += np.einsum("ign,ign->gn", twist, np.einsum("gw,iwn->ign", mask, wrenches))
        for limb, (twists, masks) in enumerate(zip(self.branch_twists, branches, strict=True)):
            for twist, mask in zip(twists, masks, strict=True):
                force[0, limb] += np.einsum("in,in->n", twist, np.einsum("w,iwn->in", mask, wrenches))
        return force

    def forces(self, carried: Array) -> Array:
        return carried

    def displacements(self, forces: Array) -> Array:
        """Return c f."""
        return self.actuators.compliance * forces

    def motions(self, displacements: Array) -> Iterator[tuple[int, Array]]:
        for freedom, twist in zip(self.actuators.freedoms, self.twists, strict=True):
            yield freedom.element, twist[:, None] * displacements

    def travels(self, displacements: Array) -> Mapping[str, Array]:
        return {name: displacements[0, :, position] for position, name in enumerate(self.actuators.names)}

    def compliance_sum(self, length: float) -> Array:
        """Return c Σ r_j², with the ratios of rotations times ``length``."""
        sizes = [freedom.ratios * (length if freedom.rotates else 1.0) for freedom in self.actuators.freedoms]
        batch = self.twists[0].shape[1:]
        return np.broadcast_to(self.actuators.compliance * sum(size**2 for size in sizes), batch)
