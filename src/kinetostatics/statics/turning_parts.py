"""Parts of a robot that rotate or slide relative to one another, and the displacements u of its geometric stiffness.

A *part* is a set of bodies with a common rotation: no joint, bearing, actuator or beam lets them rotate relative to one another.
A *passage* is a joint or beam, between two parts or within one part. A *block* is a group of components of u, such as the
rotation of one part. A *place*, at which a load acts, is a rigid link or an end of a beam.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from kinetostatics.description.fields import Vector
from kinetostatics.limbs.static_model import StaticModel
from kinetostatics.math.arrays import Array
from kinetostatics.math.graphs import joined, reachable
from kinetostatics.mechanism.joints import (
    Drive,
    ElasticJoint,
    Freedom,
    compound_joints,
    drives_of,
    freedoms_of,
    limb_elements,
    sides,
    springs_of,
)
from kinetostatics.mechanism.limbs import Edge

#: Indices of the parts of base and platform.
BASE, PLATFORM = 0, 1
#: Sine of the angle below which a direction lies in the span of others.
_SAME = 1e-9


@dataclass(frozen=True)
class Fixed:
    """A point or a direction (3,) fixed in a body."""

    body: int
    vector: Array


@dataclass(frozen=True)
class Passage:
    """A joint or beam, from the part on its inner side to the part on its outer side; both may be the same part.

    Attributes:
        edge: the joint or beam; if several hinges form the joint, the outermost of them.
        owner: index of the limb that contains the joint or beam; for open branches on base or platform, the next two indices.
        inner, outer: indices of the parts.
        places: a place on the inner side, and a place on the outer side.
        centre: point of application of the wrench on the outer part; for a beam, its outer end.
        turns: axes of the free rotations, inner ones first.
        slides: orthonormal directions of free displacements of the outer side at the centre, relative to the inner side.
        is_ball: whether the joint transmits no moment.
        is_universal: whether the joint has two free rotations, with an axis fixed in each side.
    """

    edge: Edge
    owner: int
    inner: int
    outer: int
    places: tuple[str, str]
    centre: Fixed
    turns: tuple[Fixed, ...]
    slides: tuple[Fixed, ...]
    is_ball: bool
    is_universal: bool


@dataclass(frozen=True)
class TurningParts:
    """The parts of a robot.

    Attributes:
        passages: all joints and beams; hinges that form one joint are one passage.
        places: a place on each part; base and platform are the first parts.
        owners: for each part :attr:`Passage.owner` of the passage to it; −1 for base and platform.
        turning: indices of the parts whose rotations are in u; parts behind passive joints of open branches are not among them.
        spins: by part, the indices of the two ball joints that let it rotate freely about their connecting line.
        part_of: the part of each place.
        owner_at: for each place :attr:`Passage.owner` of the passage that carries it; without places on base and platform.
        spring_places: for each spring, the places of its two ends.
    """

    passages: tuple[Passage, ...]
    places: tuple[str, ...]
    owners: tuple[int, ...]
    turning: tuple[int, ...]
    spins: dict[int, tuple[int, int]]
    part_of: dict[str, int]
    owner_at: dict[str, int]
    spring_places: tuple[tuple[str, str], ...]


def turning_parts(model: StaticModel, drives: Mapping[str, Drive] | None = None) -> TurningParts:
    """Return the parts of a robot with elastic or free actuators ``drives``; None: the elastic actuators of its file."""
    return _Finder(model, drives_of(model.mechanism) if drives is None else drives).found()


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
    def __init__(self, model: StaticModel, drives: Mapping[str, Drive]) -> None:
        self.model = model
        self.topology, self.connections = model.topology, model.mechanism.connections
        self.place_at: dict[str, str] = {}  # a place on the outer side of an edge, by its key
        for place, key in self.topology.carried_by.items():
            self.place_at.setdefault(key, place)
        self.places, self.owners = [model.description.base, model.description.platform], [-1, -1]
        self.part_at: dict[str, int] = {}  # by the edge's key
        self.hinged: set[int] = set()
        self.on_elastic_drives = {joint for drive in drives.values() for joint, _ in drive.moves}

    def found(self) -> TurningParts:
        steps = list(self._steps())
        for step in steps:
            self.part_at[step.edge.key] = self._outer_part(step)
        passages = tuple(map(self._passage, steps))
        topology = self.topology
        on_limbs = [place for limb in topology.all_limbs for place in limb.places]
        known = (*on_limbs, *topology.base.places, *topology.platform.places, *topology.carried_by)
        part_of = {place: self._part(place) for place in known}
        springs = self.model.description.springs.values()
        ends = [((s.predecessor, s.predecessor_point), (s.successor, s.successor_point)) for s in springs]
        spring_places = tuple((self._place_of(*first), self._place_of(*second)) for first, second in ends)
        turning = tuple(k for k in range(1, len(self.places)) if k not in self.hinged)
        owner_by_key = {edge.key: step.owner for step in steps for edge in (step.first, step.edge)}
        owner_at = {place: owner_by_key[key] for place, key in topology.carried_by.items() if key in owner_by_key}
        places, owners = tuple(self.places), tuple(self.owners)
        return TurningParts(passages, places, owners, turning, self._spins(passages), part_of, owner_at, spring_places)

    def _steps(self) -> Iterator[_Step]:
        topology, mechanism = self.topology, self.model.mechanism
        branches: list[tuple[tuple[Edge, ...], int, int]] = []
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
            branches.append((limb.branches, number, root))
        count = len(topology.all_limbs)
        branches += [(topology.base.edges, count, BASE), (topology.platform.edges, count + 1, PLATFORM)]
        for edges_of, owner, root in branches:
            for edge in edges_of:
                dofs = freedoms_of(mechanism, self.connections[edge.joint], edge.sign) if edge.joint else ()
                yield _Step(edge, edge, owner, dofs, True, root)

    def _part(self, place: str) -> int:
        key = self.topology.carried_by.get(place)
        if key is not None:
            return self.part_at.get(key, BASE)
        return PLATFORM if place in self.topology.platform.places else BASE

    def _inner_part(self, step: _Step) -> int:
        return step.root if step.first.parent is None else self.part_at[step.first.parent]

    def _outer_part(self, step: _Step) -> int:
        inner = self._inner_part(step)
        passive = any(dof.passive and dof.rotates for dof in step.dofs)
        elastic = step.edge.beam is not None or any(np.any(spring.compliance[3:, 3:]) for spring in self._springs(step))
        elastic |= step.edge.joint in self.on_elastic_drives and any(dof.rotates for dof in step.dofs)
        if not (passive or elastic) or step.edge.key not in self.place_at:
            return inner
        number = len(self.places)
        self.places.append(self.place_at[step.edge.key])
        self.owners.append(step.owner)
        if (step.on_branch and passive) or inner in self.hinged:
            self.hinged.add(number)
        return number

    def _springs(self, step: _Step) -> tuple[ElasticJoint, ...]:
        return springs_of(self.model.mechanism, step.edge.joint) if step.edge.joint else ()

    def _passage(self, step: _Step) -> Passage:
        edge, inner = step.edge, self._inner_part(step)
        leads = edge.key in self.place_at
        outer_place = self.place_at[edge.key] if leads else self._place_on(edge, 1)
        outer = self.part_at[edge.key] if leads else self._part(outer_place)
        turns = tuple(Fixed(dof.body, dof.axis) for dof in step.dofs if dof.rotates and dof.passive)
        slides, centre = self._slides(step), self._centre(step)
        parent = step.first.parent
        inner_place = self.places[step.root] if parent is None else self.place_at.get(parent, self._place_on(step.first, 0))
        places = (inner_place, outer_place)
        is_universal = len(turns) == 2 == sum(dof.rotates for dof in step.dofs)
        return Passage(edge, step.owner, inner, outer, places, centre, turns, slides, len(turns) == 3, is_universal)

    def _slides(self, step: _Step) -> tuple[Fixed, ...]:
        if step.edge.beam is not None:
            model = self.model.elastic_links[step.edge.beam]
            return tuple(Fixed(model.span.carrier, axis) for axis in model.axes.T)
        on_elastic_drives = step.edge.joint in self.on_elastic_drives
        moving = [dof for dof in step.dofs if not dof.rotates and (on_elastic_drives or (dof.passive and not step.on_branch))]
        found = [(dof.body, dof.axis) for dof in moving]
        for spring in self._springs(step):
            found += [(spring.body, spring.frame[:3, k]) for k in range(3) if spring.compliance[k, k] > 0]
        return tuple(Fixed(found[0][0], axis) for axis in _orthonormal([axis for _, axis in found]))

    def _centre(self, step: _Step) -> Fixed:
        if step.edge.beam is not None:
            span = self.topology.beams[step.edge.beam]
            return Fixed(span.end_body, span.end)
        connection = self.connections[str(step.edge.joint)]
        if step.edge != step.first:
            return Fixed(step.dofs[-1].centre_body, step.dofs[-1].centre)
        return Fixed(connection.predecessor_body, connection.predecessor_frame[:3, 3])

    def _place_on(self, edge: Edge, side: int) -> str:
        """Return a place on the inner side (0) or on the outer side (1) of a joint or beam."""
        if edge.beam is not None:
            return self.topology.beam_ends[edge.beam][side]
        connection = self.connections[str(edge.joint)]
        link = connection.successor if (edge.sign > 0) == (side == 1) else connection.predecessor
        body, frame = sides(edge, connection)[side]
        return self._nearest(link, self.model.zero_frames.point(body, frame[:3, 3]))

    def _place_of(self, link: str, point: Vector) -> str:
        body, placement = self.model.mechanism.body_of[link]
        return self._nearest(link, self.model.zero_frames.point(body, placement[:3, :3] @ np.array(point) + placement[:3, 3]))

    def _nearest(self, link: str, at: Array) -> str:
        """Return the link, or for an elastic link the end of its beam that is nearest to a point (3, 1)."""
        beams = [name for name, span in self.topology.beams.items() if span.beam.link == link]
        if not beams:
            return link
        zero, ends = self.model.zero_frames, []
        for name in beams:
            span = self.topology.beams[name]
            points = zero.point(span.start_body, span.start), zero.point(span.end_body, span.end)
            ends += list(zip(self.topology.beam_ends[name], points, strict=True))
        return min(ends, key=lambda end: float(np.sum((end[1] - at) ** 2)))[0]

    def _spins(self, passages: Sequence[Passage]) -> dict[int, tuple[int, int]]:
        neighbours: dict[int, list[int]] = {k: [] for k in range(len(self.places))}
        for item in passages:
            if not item.is_ball:
                neighbours[item.inner].append(item.outer)
                neighbours[item.outer].append(item.inner)
        found: dict[int, tuple[int, int]] = {}
        for number in range(2, len(self.places)):
            together = reachable([number], lambda part: neighbours[part])
            balls = [
                k for k, item in enumerate(passages) if item.is_ball and (item.inner in together) != (item.outer in together)
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


#: A block of coordinates: ("shift", 0): displacement of o, for springs between base and platform; ("part", number): rotation of a
#: part; ("slide", number): displacements across a passage; ("spring", number): relative displacement of the ends.
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


def coordinates_of(parts: TurningParts) -> Coordinates:
    count = max((item.owner for item in parts.passages), default=0) + 1
    sliding = {part for item in parts.passages if item.slides for part in (item.inner, item.outer)}
    owned: list[tuple[Block, int]] = []
    pairs, on_platform = [], []
    for part in parts.turning:
        if part != PLATFORM:
            owned.append((("part", part), parts.owners[part]))
    owned += [(("slide", k), item.owner) for k, item in enumerate(parts.passages) if item.slides]
    for number, places in enumerate(parts.spring_places):
        ends = [parts.part_of[place] for place in places]
        if set(ends) == {BASE, PLATFORM} and not any(place in parts.owner_at for place in places):
            on_platform.append(number)
        elif ends[0] != ends[1] or ends[0] in sliding:  # otherwise length and direction on the part are constant
            owners = [parts.owner_at.get(place, -1) for place in places]
            mine = [owner for owner in owners if owner >= 0] or [count]
            owned.append((("spring", number), mine[0]))
            pairs.append((mine[0], mine[-1]))
    together = joined(range(count + 1), pairs)
    groups: dict[frozenset[int], list[Block]] = {}
    for block, owner in owned:
        groups.setdefault(together[owner], []).append(block)
    platform: list[Block] = [("shift", 0)] if on_platform else []
    platform += [("part", PLATFORM)] if PLATFORM in parts.turning else []
    inside = tuple(tuple(group) for group in groups.values())
    sizes = {block: 3 for block in (*platform, *(block for group in inside for block in group))}
    sizes |= {("slide", k): len(item.slides) for k, item in enumerate(parts.passages) if item.slides}
    return Coordinates(tuple(platform), inside, sizes, tuple(on_platform))
