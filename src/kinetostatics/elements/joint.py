"""Elastic joints in limbs: bearings and springs, whose forces refer to the frame of the joint."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinetostatics.elements.element import NO_CUTS, PlacedSection, outboard_masks
from kinetostatics.math.arrays import Array
from kinetostatics.mechanism.joints import ElasticJoint
from kinetostatics.mechanism.limbs import Edge
from kinetostatics.mechanism.tree import FixedVectors, Frames


class ElasticJoints:
    """Corresponding elastic joints of g equal limbs, see :class:`kinetostatics.elements.element.ElasticElement`."""

    kind = "joints"
    in_every_direction = has_line = has_inside = False
    attachments: frozenset[str] = frozenset()

    def __init__(
        self, joints: Sequence[ElasticJoint], edges: Sequence[Edge], element: int = 0, signs: NDArray[np.int8] | None = None
    ) -> None:
        """Set the joints.

        Args:
            joints, edges: the joints, and their edges in the limbs.
            element: index of the element in the limb; irrelevant in open branches.
            signs: (M,) signs of the cut-joint wrenches that the joints transmit; none in open branches.
        """
        self.names, self.edges, self.element = tuple(joint.joint for joint in joints), tuple(edges), element
        self.signs = NO_CUTS if signs is None else signs
        self._axes = FixedVectors([[(joint.body, joint.frame[:3, :3])] for joint in joints], (3, 3))
        self._origins = FixedVectors([[(joint.body, joint.frame[:3, 3])] for joint in joints])
        self.compliance = np.stack([joint.compliance for joint in joints], axis=-1)  # (6, 6, g)

    @property
    def signature(self) -> tuple[object, ...]:
        return self.kind, self.element, tuple(self.signs.tolist())

    def outboard(self, names: Sequence[str]) -> list[Array]:
        return [outboard_masks(self.edges, names)]

    def placed(self, frames: Frames, o: Array, twists: Array) -> PlacedJoints:
        arm = self._origins.points(frames)[:, 0] - o[:, None]
        return PlacedJoints(self.signs, self.element, self._axes.at(frames)[:, :, 0], arm, self)


@dataclass(frozen=True, eq=False)
class PlacedJoints(PlacedSection):
    """Corresponding elastic joints at N poses."""

    joints: ElasticJoints

    def displacements(self, forces: Array) -> Array:
        """Return u = F w, with the joints' compliance F."""
        return np.einsum("ijg,j...gn->i...gn", self.joints.compliance, forces)
