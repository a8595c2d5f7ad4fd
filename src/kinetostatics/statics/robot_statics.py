"""Immutable data of a robot's statics: limbs with their wrench bases, branches, the table of joints."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields

from kinetostatics.limbs.drives import BranchJoint, branch_joints
from kinetostatics.limbs.group import LimbGroup
from kinetostatics.limbs.grouping import make_limb_groups
from kinetostatics.limbs.static_model import StaticModel
from kinetostatics.mechanism.elastic_joints import Drive, ElasticJoint, drives_of, springs_of
from kinetostatics.mechanism.joint_freedoms import freedoms_of
from kinetostatics.mechanism.tree import Frames
from kinetostatics.statics.joint_table import JointTable, OpenBranch, open_branches_of
from kinetostatics.statics.turning_parts import TurningParts, turning_parts


@dataclass(frozen=True, eq=False, repr=False)
class RobotStatics(StaticModel):
    """Data of a robot for the equilibrium of its platform.

    Attributes:
        groups: equal limbs stacked, with their wrench bases, which are chosen once per robot.
        open_branches: the passive joints of all open branches.
        joint_table: all joints that carry wrenches.
        example: frames of one generic pose.
        parts: parts that rotate relative to one another, for a robot with springs; else None.
        branch_drives: elastic actuators that move joints of open branches, with these joints.
        branch_springs: elasticities of joints of open branches, by joint.
    """

    groups: tuple[LimbGroup, ...]
    open_branches: tuple[OpenBranch, ...]
    joint_table: JointTable
    example: Frames
    parts: TurningParts | None
    branch_drives: tuple[tuple[Drive, tuple[BranchJoint, ...]], ...]
    branch_springs: Mapping[str, tuple[ElasticJoint, ...]]

    def passive_joints(self, owner: str) -> list[str]:
        """Return the passive joints of a limb, or of the bodies attached to ``base`` or ``platform``."""
        names = [item.joint for item in self.open_branches if item.owner == owner]
        for limb in self.topology.all_limbs:
            for edge in limb.edges if limb.name == owner else ():
                if edge.joint is not None:
                    dofs = freedoms_of(self.mechanism, self.mechanism.connections[edge.joint], edge.sign)
                    if any(dof.passive for dof in dofs):
                        names.append(edge.joint)
        return names


def make_statics(model: StaticModel, generic: Frames, ordinary: Frames) -> RobotStatics:
    """Choose the wrench bases of the limbs and return the data of the statics.

    Args:
        model: the robot's bodies, limbs, beams and weights.
        generic: frames of its generic poses, at which ranks are decided.
        ordinary: frames of ordinary poses, at which bases must not degenerate.
    """
    return _with_groups(model, make_limb_groups(model, generic, ordinary), generic.take(slice(0, 1)))


def statics_on(statics: RobotStatics, model: StaticModel) -> RobotStatics:
    """Return the statics of a slightly different robot with the ranks and bases decided for ``statics``."""
    model = StaticModel(**{item.name: getattr(model, item.name) for item in fields(StaticModel)})
    return _with_groups(model, tuple(group.on(model) for group in statics.groups), statics.example)


def _with_groups(model: StaticModel, groups: tuple[LimbGroup, ...], example: Frames) -> RobotStatics:
    branches, table = open_branches_of(model), JointTable(model)
    parts = turning_parts(model) if model.description.springs else None
    moved = [(drive, branch_joints(model, drive)) for drive in drives_of(model.mechanism).values()]
    springs = {edge.joint: springs_of(model.mechanism, edge.joint) for edge in model.topology.branch_edges if edge.joint}
    return RobotStatics(
        **{item.name: getattr(model, item.name) for item in fields(StaticModel)},
        groups=groups,
        open_branches=branches,
        joint_table=table,
        example=example,
        parts=parts,
        branch_drives=tuple(item for item in moved if item[1]),
        branch_springs={name: mine for name, mine in springs.items() if mine},
    )
