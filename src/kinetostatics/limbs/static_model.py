"""Immutable data of a robot for limbs and statics, independent of poses and kinematics, and its elastic actuators.

An actuator with mimic joints deforms along all its freedoms, under the sum of their forces. Let s_j be the unit twists of the
actuated joint and of the joints that mimic it with ratios r_j, and w_j their wrenches. The force of the actuator is
f = Σ r_j s_jᵀ w_j; with the compliance c it moves joint j by r_j s_j c f. This adds one term of rank one per actuator to the sums
of Eqs. (1) and (16). Some of these joints may be in open branches: chains of links with a free end.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from kinetostatics.description.robot_description import RobotDescription
from kinetostatics.layout.mapping import ShortRepr
from kinetostatics.math.arrays import Array
from kinetostatics.mechanism.beam_model import BeamModel
from kinetostatics.mechanism.joints import Drive, Freedoms, freedoms_of
from kinetostatics.mechanism.limbs import Edge, Topology
from kinetostatics.mechanism.mechanism import Mechanism
from kinetostatics.mechanism.tree import Frames
from kinetostatics.mechanism.weights import Weights


@dataclass(frozen=True, eq=False, repr=False)
class StaticModel(ShortRepr):
    """Data of a robot for its statics.

    Attributes:
        mechanism: bodies and connections.
        topology: limbs, and the bodies attached to base and platform.
        zero_frames: frames of the closed zero pose, a batch of one.
        length: characteristic length [m], which makes forces and moments comparable.
        rank_tolerance: relative singular value below which a direction is taken as dependent.
        closing_error: residual of the closed loops due to rounding in the file [scaled m, rad].
    """

    NOT_RECORDED: ClassVar = ("zero_frames", "example")

    mechanism: Mechanism
    topology: Topology
    beams: Mapping[str, BeamModel]
    weights: Weights
    zero_frames: Frames
    length: float
    rank_tolerance: float
    closing_error: float

    @cached_property
    def description(self) -> RobotDescription:
        return self.mechanism.description


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


def branch_joints(model: StaticModel, drive: Drive) -> tuple[BranchJoint, ...]:
    found, ratios = [], dict(drive.moves)
    for edge in model.topology.branch_edges:
        if edge.joint in ratios:
            freedoms = Freedoms(freedoms_of(model.mechanism, model.mechanism.connections[edge.joint], edge.sign))
            found.append(BranchJoint(edge, ratios[edge.joint], freedoms))
    return tuple(found)


@dataclass(frozen=True)
class LimbDrive:
    """Corresponding elastic actuators of g equal limbs, one in each limb.

    Attributes:
        joints: name of the actuator in each limb.
        compliance: (g, 1) compliance along the actuator's coordinate [m/N, rad/(N·m)].
        freedoms: indices of the limb's freedoms that the actuator moves.
        ratios: (freedoms, g, 1) motions of these freedoms per unit of the actuator's coordinate.
        branches: for each limb, the joints of open branches that the actuator moves.
    """

    joints: tuple[str, ...]
    compliance: Array
    freedoms: tuple[int, ...]
    ratios: Array
    branches: tuple[tuple[BranchJoint, ...], ...]


def limb_drives(model: StaticModel, drives: Sequence[Drive], freedoms: Sequence[Sequence[str]]) -> tuple[LimbDrive, ...]:
    """Return the elastic actuators that move freedoms of equal limbs.

    Args:
        freedoms: for every limb, the names of the joints of its freedoms, inboard ones first.
    """
    rows = []
    for joints in freedoms:
        ratios = [(drive, [(joints.index(name), ratio) for name, ratio in drive.moves if name in joints]) for drive in drives]
        rows.append(sorted(((drive, sorted(mine)) for drive, mine in ratios if mine), key=lambda item: item[1][0]))
    return tuple(
        LimbDrive(
            tuple(drive.joint for drive, _ in alike),
            np.array([drive.compliance for drive, _ in alike])[:, None],
            tuple(number for number, _ in alike[0][1]),
            np.array([[ratio for _, ratio in mine] for _, mine in alike]).T[..., None],
            tuple(branch_joints(model, drive) for drive, _ in alike),
        )
        for alike in zip(*rows, strict=True)
    )
