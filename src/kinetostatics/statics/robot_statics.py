"""Immutable data of a robot's statics: limbs with their wrench bases, joints that carry wrenches, passive joints of branches.

An open branch is a chain of links with a free end, on a limb, the base or the platform.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np

from kinetostatics.elements.actuator import BranchJoint, branch_joints
from kinetostatics.elements.element import ElasticElement
from kinetostatics.elements.joint import ElasticJoints
from kinetostatics.elements.static_model import StaticModel
from kinetostatics.limbs.group import LimbGroup
from kinetostatics.limbs.grouping import make_limb_groups
from kinetostatics.math.arrays import Array
from kinetostatics.mechanism.joints import ElasticActuator, Freedoms, elastic_actuators, freedoms_of, sides, springs_of
from kinetostatics.mechanism.limbs import Edge, carries
from kinetostatics.mechanism.tree import Frames
from kinetostatics.statics.rotation_groups import RotationGroups, find_rotation_groups


class PassiveBranchJoint:
    """A passive joint of an open branch; the branch must be in equilibrium at the given pose.

    Attributes:
        owner: name of the limb that carries the branch, ``base`` or ``platform``.
        edge: the joint, directed outwards.
        outboard: (W,) mask of the weights that the joint carries.
        scale: (k,) 1 for a translation, the characteristic length for a rotation; the power of a load is divided by it.
    """

    def __init__(self, model: StaticModel, owner: str, edge: Edge) -> None:
        connection = model.mechanism.connections[str(edge.joint)]
        self.owner, self.joint = owner, connection.name
        self.edge = edge
        self.outboard = model.weights.outboard_of(edge)
        self._freedoms = Freedoms([f for f in freedoms_of(model.mechanism, connection, edge.sign) if f.passive])
        self.scale = np.where(self._freedoms.rotates, model.length, 1.0)

    def twists(self, frames: Frames, o: Array) -> Array:
        return self._freedoms.twists(frames, o)


def passive_branch_joints_of(model: StaticModel) -> tuple[PassiveBranchJoint, ...]:
    topology = model.topology
    parts = [(limb.name, limb.branches) for limb in topology.all_limbs]
    parts += [("base", topology.base.edges), ("platform", topology.platform.edges)]
    found = []
    for owner, edges in parts:
        for edge in edges:
            if edge.joint is not None:
                branch = PassiveBranchJoint(model, owner, edge)
                if branch.scale.size:
                    found.append(branch)
    return tuple(found)


class JointTable:
    """The J joints that carry wrenches, also fixed joints: in limbs, in open branches, and on base and platform.

    Attributes:
        owners: name of the limb of each joint, ``base`` or ``platform``.
        signs: by name, 1 if the wrench of the predecessor on the successor is reported, else −1.
        cut_signs: (J, Q) sign of each cut-joint wrench of the robot in the wrench of the joint's outboard side on its inboard
            side.
        outboard: (J, W) mask of the weights that each joint carries.
        reported: (J,) −1 if the wrench of the inboard side on the outboard side is reported, 1 for its reaction.
        centre_body, centre: body (J,) on which the reported wrench acts, and position (3, J) of the joint's centre in it.
    """

    def __init__(self, model: StaticModel) -> None:
        topology = model.topology
        found: list[tuple[Edge, int, str]] = []
        self._first = [0]
        for limb in topology.all_limbs:
            found += [(edge, self._first[-1], limb.name) for edge in (*limb.edges, *limb.branches)]
            self._first.append(self._first[-1] + len(limb.to_platform))
        for owner, dead in (("base", topology.base), ("platform", topology.platform)):
            found += [(edge, 0, owner) for edge in dead.edges]
        entries = [(edge, k) for edge, k, _ in found if edge.joint is not None]
        self.names = [str(edge.joint) for edge, _ in entries]
        self.owners = [owner for edge, _, owner in found if edge.joint is not None]
        self.cut_signs = np.zeros((len(entries), self._first[-1]))
        for row, (edge, k) in enumerate(entries):
            for cut, sign in edge.cut_joints:
                self.cut_signs[row, k + cut] = sign
        self._edges = [edge for edge, _ in entries]
        outboard = [model.weights.outboard_of(edge) for edge in self._edges]
        self.outboard = np.array(outboard).reshape(len(entries), len(model.weights.names))
        turned = [edge.both_ways and edge.sign < 0 for edge, _ in entries]
        self.signs = {str(edge.joint): edge.sign * (-1 if back else 1) for (edge, _), back in zip(entries, turned, strict=True)}
        self.reported = np.where(turned, 1.0, -1.0)
        outer = [
            sides(edge, model.mechanism.connections[str(edge.joint)])[0 if back else 1]
            for (edge, _), back in zip(entries, turned, strict=True)
        ]
        self.centre_body = np.array([body for body, _ in outer], dtype=np.intp)
        self.centre = np.array([frame[:3, 3] for _, frame in outer]).reshape(-1, 3).T

    def carrying(self, attachment: str) -> Array:
        """Return (J,) 1 for the joints that carry a load at an attachment, else 0."""
        return np.array([carries(edge, attachment) for edge in self._edges], dtype=float)

    def cuts_of(self, limb: int) -> slice:
        return slice(self._first[limb], self._first[limb + 1])


@dataclass(frozen=True, eq=False, repr=False)
class RobotStatics(StaticModel):
    """Data of a robot for the equilibrium of its platform.

    Attributes:
        groups: equal limbs, stacked, with their wrench bases, which are chosen once per robot.
        example: frames of one generic pose.
        rotation_groups: they rotate relative to one another; for a robot with springs; else None.
        branch_actuators: elastic actuators that move joints of open branches, with these joints.
        branch_elements: elastic links and joints of open branches, by key of their first edge, with their edges.
        contributions: names of the contributions to the twist without loads.
    """

    groups: tuple[LimbGroup, ...]
    passive_branch_joints: tuple[PassiveBranchJoint, ...]
    joint_table: JointTable
    example: Frames
    rotation_groups: RotationGroups | None
    branch_actuators: tuple[tuple[ElasticActuator, tuple[BranchJoint, ...]], ...]
    branch_elements: Mapping[str, tuple[tuple[ElasticElement, tuple[Edge, ...]], ...]]

    @cached_property
    def contributions(self) -> tuple[str, ...]:
        base = ("base_weight",) if self.topology.base.plate else ()
        return ("load", "platform_weight", *(limb.name for limb in self.topology.limbs), *base)

    def passive_joints(self, owner: str) -> list[str]:
        """Return the passive joints of a limb, or of the bodies attached only to ``base`` or only to ``platform``."""
        names = [item.joint for item in self.passive_branch_joints if item.owner == owner]
        for limb in self.topology.all_limbs:
            for edge in limb.edges if limb.name == owner else ():
                if edge.joint is not None:
                    dofs = freedoms_of(self.mechanism, self.mechanism.connections[edge.joint], edge.sign)
                    if any(dof.passive for dof in dofs):
                        names.append(edge.joint)
        return names


def make_statics(model: StaticModel, generic: Frames, ordinary: Frames) -> RobotStatics:
    """Choose the wrench bases of the limbs and return the data of the statics.

    Ranks are decided at the poses ``generic``; wrench bases must not degenerate at the poses ``ordinary``.
    """
    return _with_groups(model, make_limb_groups(model, generic, ordinary), generic.take(slice(0, 1)))


def statics_on(statics: RobotStatics, model: StaticModel) -> RobotStatics:
    """Return the statics of a slightly different robot ``model``, with the ranks and wrench bases of ``statics``."""
    model = StaticModel(**{item.name: getattr(model, item.name) for item in fields(StaticModel)})
    return _with_groups(model, tuple(group.on(model) for group in statics.groups), statics.example)


def _with_groups(model: StaticModel, groups: tuple[LimbGroup, ...], example: Frames) -> RobotStatics:
    branches, table = passive_branch_joints_of(model), JointTable(model)
    rotation_groups = find_rotation_groups(model) if model.description.springs else None
    actuators = elastic_actuators(model.mechanism).values()
    moved = [(actuator, branch_joints(model.mechanism, model.topology, actuator)) for actuator in actuators]
    links: dict[str, list[Edge]] = {}
    for edge in model.topology.branch_edges:
        links.setdefault(edge.joint or f"beam:{model.topology.part_of(edge)}", []).append(edge)
    elements = {edges[0].key: tuple(_elements_of(model, edges)) for edges in links.values()}
    return RobotStatics(
        **{item.name: getattr(model, item.name) for item in fields(StaticModel)},
        groups=groups,
        passive_branch_joints=branches,
        joint_table=table,
        example=example,
        rotation_groups=rotation_groups,
        branch_actuators=tuple(item for item in moved if item[1]),
        branch_elements={key: elastic for key, elastic in elements.items() if elastic},
    )


def _elements_of(model: StaticModel, edges: Sequence[Edge]) -> Iterator[tuple[ElasticElement, tuple[Edge, ...]]]:
    """Yield the elements of a joint, or of an elastic link with its ``edges`` to one or more outer ends."""
    links = [model.elastic_links[edge.span] for edge in edges if edge.span is not None]
    if len(links) == 1:
        yield links[0].stacked(links, edges), tuple(edges)
    elif links:
        ends = range(len(links))
        yield links[0].coupled([links], [edges], ends, np.zeros((len(links), 0), dtype=np.int8)), tuple(edges)
    for edge in edges:
        for joint in springs_of(model.mechanism, edge.joint) if edge.joint is not None else ():
            yield ElasticJoints([joint], [edge]), (edge,)
