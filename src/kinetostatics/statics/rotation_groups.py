"""Rotation groups of a robot, the junctions between them, and the displacements u of the robot's geometric stiffness.

A *rotation group* is a set of bodies that only rotate together: no joint, bearing, actuator or beam lets them rotate relative to
one another. A *junction* is a joint or beam, between two groups or within one. A *block* is several components of u, such as
the rotation of one group. An *attachment*, at which a load acts, is a rigid link or an end of a beam.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from kinetostatics.description.fields import Vector
from kinetostatics.elements.static_model import StaticModel
from kinetostatics.math.arrays import Array
from kinetostatics.math.graphs import joined, reachable
from kinetostatics.mechanism.joints import (
    ElasticActuator,
    Freedom,
    compound_joints,
    elastic_actuators,
    freedoms_of,
    limb_elements,
    sides,
    small_freedoms,
)
from kinetostatics.mechanism.limbs import Edge

#: Indices of the groups of base and platform.
BASE, PLATFORM = 0, 1
#: Sine of the angle below which a direction lies in the span of others.
_SAME = 1e-9


@dataclass(frozen=True)
class Fixed:
    """A point or a direction (3,) fixed in a body."""

    body: int
    vector: Array


@dataclass(frozen=True)
class Junction:
    """A joint or beam, from the rotation group on its inner side to the one on its outer side; both may be the same.

    Attributes:
        edge: the joint or beam; if several hinges form the joint, the outermost of them.
        owner: index of the limb that contains the joint or beam; for open branches on base or platform, the next two indices.
        inner, outer: indices of the groups.
        attachments: an attachment on the inner side, and an attachment on the outer side.
        centre: point of application of the wrench on the outer group; for a beam, its outer end.
        turns: axes of the free rotations, inner ones first.
        slides: orthonormal directions of free displacements of the outer side at the centre, relative to the inner side.
        is_ball: whether the joint transmits no moment.
        is_universal: whether the joint has two free rotations, with an axis fixed in each side.
    """

    edge: Edge
    owner: int
    inner: int
    outer: int
    attachments: tuple[str, str]
    centre: Fixed
    turns: tuple[Fixed, ...]
    slides: tuple[Fixed, ...]
    is_ball: bool
    is_universal: bool


@dataclass(frozen=True)
class RotationGroups:
    """The rotation groups of a robot, numbered.

    Attributes:
        junctions: all joints and beams; hinges that form one joint are one junction.
        attachments: an attachment on each group; base and platform are the first groups.
        owners: for each group :attr:`Junction.owner` of the junction to it; −1 for base and platform.
        rotating: indices of the groups whose rotations are in u, which are not behind passive joints of open branches.
        spins: by group, the indices of the two ball joints that let it rotate freely about their connecting line.
        group_of: the group of each attachment.
        owner_at: for each attachment not on base or platform :attr:`Junction.owner` of the junction that carries it.
        spring_attachments: for each spring, the attachments of its two ends.
    """

    junctions: tuple[Junction, ...]
    attachments: tuple[str, ...]
    owners: tuple[int, ...]
    rotating: tuple[int, ...]
    spins: dict[int, tuple[int, int]]
    group_of: dict[str, int]
    owner_at: dict[str, int]
    spring_attachments: tuple[tuple[str, str], ...]


def find_rotation_groups(model: StaticModel, actuators: Mapping[str, ElasticActuator] | None = None) -> RotationGroups:
    """Return the rotation groups of a robot with elastic or free ``actuators``; None: the elastic actuators of its file."""
    return _Finder(model, elastic_actuators(model.mechanism) if actuators is None else actuators).found()


@dataclass(frozen=True)
class _Step:
    """A joint or beam, directed outwards; of hinges that form one joint, ``edge`` is the outermost, ``first`` the innermost."""

    edge: Edge
    first: Edge
    owner: int
    dofs: tuple[Freedom, ...]
    on_branch: bool
    root: int


class _Finder:
    def __init__(self, model: StaticModel, actuators: Mapping[str, ElasticActuator]) -> None:
        self.model, self.actuators = model, actuators
        self.topology, self.connections = model.topology, model.mechanism.connections
        self.attachment_at: dict[str, str] = {}  # an attachment on the outer side of an edge, by its key
        for attachment, key in self.topology.carried_by.items():
            self.attachment_at.setdefault(key, attachment)
        self.attachments, self.owners = [self.topology.base.root, self.topology.platform.root], [-1, -1]
        self.group_at: dict[str, int] = {}  # by the edge's key
        self.hinged: set[int] = set()

    def found(self) -> RotationGroups:
        steps = list(self._steps())
        for step in steps:
            self.group_at[step.edge.key] = self._outer_group(step)
        junctions = tuple(map(self._junction, steps))
        topology = self.topology
        on_limbs = [attachment for limb in topology.all_limbs for attachment in limb.attachments]
        known = (*on_limbs, *topology.base.attachments, *topology.platform.attachments, *topology.carried_by)
        group_of = {attachment: self._group(attachment) for attachment in known}
        springs = self.model.description.springs.values()
        ends = [((s.predecessor, s.predecessor_point), (s.successor, s.successor_point)) for s in springs]
        spring_attachments = tuple((self._attachment_of(*first), self._attachment_of(*second)) for first, second in ends)
        rotating = tuple(k for k in range(1, len(self.attachments)) if k not in self.hinged)
        owner_by_key = {edge.key: step.owner for step in steps for edge in (step.first, step.edge)}
        owner_at = {attachment: owner_by_key[key] for attachment, key in topology.carried_by.items() if key in owner_by_key}
        groups = tuple(self.attachments), tuple(self.owners), rotating, self._spins(junctions), group_of
        return RotationGroups(junctions, *groups, owner_at, spring_attachments)

    def _steps(self) -> Iterator[_Step]:
        topology, mechanism = self.topology, self.model.mechanism
        branches: list[tuple[tuple[Edge, ...], int, int]] = []
        count = len(topology.all_limbs)
        for owner, root, part in ((count, BASE, topology.base), (count + 1, PLATFORM, topology.platform)):
            for edge in part.plate:
                yield _Step(edge, edge, owner, (), True, root)
            branches.append((part.edges[len(part.plate) :], owner, root))
        for number, limb in enumerate(topology.all_limbs):
            root = PLATFORM if limb.on_platform else BASE
            compounds = compound_joints(mechanism, limb)
            last = {joint: compound.edge for compound in compounds for joint in compound.joints}
            first: Edge | None = None
            for element in limb_elements(limb, compounds):
                edges = [limb.edges[k] for k in element.edges]
                first = first or edges[0]
                if any(last.get(str(edge.joint), -1) > element.edges[-1] for edge in edges) or (
                    first != edges[0] and element.compound is None
                ):
                    continue  # a weld between hinges that form one joint
                dofs = () if element.compound is None else compounds[element.compound].dofs
                yield _Step(edges[-1], first, number, dofs, False, root)
                first = None
            branches.insert(-2, (limb.branches, number, root))
        for edges_of, owner, root in branches:
            for edge in edges_of:
                dofs = freedoms_of(mechanism, self.connections[edge.joint], edge.sign) if edge.joint else ()
                yield _Step(edge, edge, owner, dofs, True, root)

    def _group(self, attachment: str) -> int:
        key = self.topology.carried_by.get(attachment)
        if key is not None:
            return self.group_at.get(key, BASE)
        return PLATFORM if attachment in self.topology.platform.attachments else BASE

    def _inner_group(self, step: _Step) -> int:
        return step.root if step.first.parent is None else self.group_at[step.first.parent]

    def _outer_group(self, step: _Step) -> int:
        inner = self._inner_group(step)
        turns = step.edge.span is not None or any(freedom.rotates for freedom in self._freedoms(step))
        if not turns or step.edge.key not in self.attachment_at:
            return inner
        number = len(self.attachments)
        self.attachments.append(self.attachment_at[step.edge.key])
        self.owners.append(step.owner)
        if (step.on_branch and any(dof.passive and dof.rotates for dof in step.dofs)) or inner in self.hinged:
            self.hinged.add(number)
        return number

    def _freedoms(self, step: _Step) -> list[Freedom]:
        return small_freedoms(self.model.mechanism, step.edge.joint, step.dofs, self.actuators) if step.edge.joint else []

    def _junction(self, step: _Step) -> Junction:
        edge, inner = step.edge, self._inner_group(step)
        leads = edge.key in self.attachment_at
        outside = self.attachment_at[edge.key] if leads else self._attachment_on(edge, 1)
        outer = self.group_at[edge.key] if leads else self._group(outside)
        turns = tuple(Fixed(dof.body, dof.axis) for dof in step.dofs if dof.rotates and dof.passive)
        slides, centre = self._slides(step), self._centre(step)
        parent = step.first.parent
        inside = self.attachments[step.root] if parent is None else self.attachment_at.get(parent)
        attachments = (inside or self._attachment_on(step.first, 0), outside)
        is_universal = len(turns) == 2 == sum(dof.rotates for dof in step.dofs)
        return Junction(edge, step.owner, inner, outer, attachments, centre, turns, slides, len(turns) == 3, is_universal)

    def _slides(self, step: _Step) -> tuple[Fixed, ...]:
        if step.edge.span is not None:
            model = self.model.elastic_links[step.edge.span]
            return tuple(Fixed(model.span.carrier, axis) for axis in model.axes.T)
        moving = [freedom for freedom in self._freedoms(step) if not (freedom.rotates or (freedom.passive and step.on_branch))]
        return tuple(Fixed(moving[0].body, axis) for axis in _orthonormal([freedom.axis for freedom in moving]))

    def _centre(self, step: _Step) -> Fixed:
        if step.edge.span is not None:
            span = self.topology.spans[step.edge.span]
            return Fixed(span.end_body, span.end)
        connection = self.connections[str(step.edge.joint)]
        if step.edge != step.first:
            return Fixed(step.dofs[-1].centre_body, step.dofs[-1].centre)
        return Fixed(connection.predecessor_body, connection.predecessor_frame[:3, 3])

    def _attachment_on(self, edge: Edge, side: int) -> str:
        """Return an attachment on the inner side (0) or on the outer side (1) of a joint or beam."""
        if edge.span is not None:
            return self.topology.span_ends[edge.span][side]
        connection = self.connections[str(edge.joint)]
        link = connection.successor if (edge.sign > 0) == (side == 1) else connection.predecessor
        body, frame = sides(edge, connection)[side]
        return self._nearest(link, self.model.zero_frames.point(body, frame[:3, 3]))

    def _attachment_of(self, link: str, point: Vector) -> str:
        body, placement = self.model.mechanism.body_of[link]
        return self._nearest(link, self.model.zero_frames.point(body, placement[:3, :3] @ np.array(point) + placement[:3, 3]))

    def _nearest(self, link: str, at: Array) -> str:
        """Return the link, or for an elastic link the end of its beam that is nearest to a point (3, 1)."""
        beams = [name for name, span in self.topology.spans.items() if span.part.link == link]
        if not beams:
            return link
        zero, ends = self.model.zero_frames, []
        for name in beams:
            span = self.topology.spans[name]
            points = zero.point(span.start_body, span.start), zero.point(span.end_body, span.end)
            ends += list(zip(self.topology.span_ends[name], points, strict=True))
        return min(ends, key=lambda end: float(np.sum((end[1] - at) ** 2)))[0]

    def _spins(self, junctions: Sequence[Junction]) -> dict[int, tuple[int, int]]:
        neighbours: dict[int, list[int]] = {k: [] for k in range(len(self.attachments))}
        for item in junctions:
            if not item.is_ball:
                neighbours[item.inner].append(item.outer)
                neighbours[item.outer].append(item.inner)
        found: dict[int, tuple[int, int]] = {}
        for number in range(2, len(self.attachments)):
            together = reachable([number], lambda group: neighbours[group])
            balls = [
                k for k, item in enumerate(junctions) if item.is_ball and (item.inner in together) != (item.outer in together)
            ]
            if len(balls) == 2 and not {BASE, PLATFORM} & set(together):
                found[number] = (balls[0], balls[1])
        return found


def _orthonormal(axes: Sequence[Array]) -> list[Array]:
    found: list[Array] = []
    for axis in axes:
        rest = axis
        for _ in range(2):  # twice, against rounding
            rest = rest - sum((unit * (unit @ rest) for unit in found), np.zeros(3))
            if (size := float(np.linalg.norm(rest))) < _SAME:
                break
            rest = rest / size
        else:
            found.append(rest)
    return found


#: A block of coordinates: ("shift", 0): displacement of o, for springs between base and platform; ("group", number): rotation of
#: a group; ("slide", number): displacements across a junction; ("spring", number): relative displacement of the ends.
Block: TypeAlias = tuple[str, int]


@dataclass(frozen=True)
class Coordinates:
    """The displacements u of which the geometric stiffness is a quadratic form.

    Attributes:
        platform: blocks determined by the platform's twist only.
        inside: the other blocks; those that a limb or spring couples are in one tuple.
        sizes: numbers of components of all blocks.
        on_platform: indices of the springs between base and platform.
    """

    platform: tuple[Block, ...]
    inside: tuple[tuple[Block, ...], ...]
    sizes: dict[Block, int]
    on_platform: tuple[int, ...]

    @property
    def blocks(self) -> tuple[Block, ...]:
        return (*self.platform, *(block for together in self.inside for block in together))

    @property
    def names(self) -> list[str]:
        """Names of all components of u, which are also the names of the loads conjugate to them."""
        return [f"change {k} of {kind} {number}" for kind, number in self.blocks for k in range(self.sizes[kind, number])]


def coordinates_of(rotation_groups: RotationGroups) -> Coordinates:
    count = max((item.owner for item in rotation_groups.junctions), default=0) + 1
    sliding = {group for item in rotation_groups.junctions if item.slides for group in (item.inner, item.outer)}
    pairs, on_platform, rotating = [], [], [group for group in rotation_groups.rotating if group != PLATFORM]
    owned: list[tuple[Block, int]] = [(("group", group), rotation_groups.owners[group]) for group in rotating]
    owned += [(("slide", k), item.owner) for k, item in enumerate(rotation_groups.junctions) if item.slides]
    for number, attachments in enumerate(rotation_groups.spring_attachments):
        ends = [rotation_groups.group_of[attachment] for attachment in attachments]
        if set(ends) == {BASE, PLATFORM} and not any(attachment in rotation_groups.owner_at for attachment in attachments):
            on_platform.append(number)
        elif ends[0] != ends[1] or ends[0] in sliding:  # otherwise length and direction in the group are constant
            owners = [rotation_groups.owner_at.get(attachment, -1) for attachment in attachments]
            mine = [owner for owner in owners if owner >= 0] or [count]
            owned.append((("spring", number), mine[0]))
            pairs.append((mine[0], mine[-1]))
    pairs += [(item.owner, limb) for item in rotation_groups.junctions for limb, _, _ in item.edge.limb_cuts]
    owners_together = joined(range(count + 1), pairs)
    blocks_by_owner: dict[frozenset[int], list[Block]] = {}
    for block, owner in owned:
        blocks_by_owner.setdefault(owners_together[owner], []).append(block)
    platform: list[Block] = [("shift", 0)] if on_platform else []
    platform += [("group", PLATFORM)] if PLATFORM in rotation_groups.rotating else []
    inside = tuple(tuple(together) for together in blocks_by_owner.values())
    sizes = dict.fromkeys((*platform, *(block for together in inside for block in together)), 3)
    sizes |= {("slide", k): len(item.slides) for k, item in enumerate(rotation_groups.junctions) if item.slides}
    return Coordinates(tuple(platform), inside, sizes, tuple(on_platform))
