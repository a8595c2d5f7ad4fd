"""Rigid pieces of a robot at one pose, and the joints and beams between them.

A piece is a link without beams, or the parts fixed to one end of a beam. Pieces follow from the robot's file and the poses of the
links, without :mod:`kinetostatics.mechanism.limbs`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from kinetostatics.description.joint_types import JOINT_TYPES, JointType
from kinetostatics.math.arrays import Array
from kinetostatics.math.graphs import joined, neighbours_of, path_directions, reachable
from kinetostatics.mechanism.beam_geometry import Span, SpanFinder

if TYPE_CHECKING:
    from kinetostatics.kinematics.configuration import Configuration


class Directions:
    """Inner node of every edge of a graph.

    If all simple paths from base to platform traverse an edge in the same direction, its inner node comes first on these paths.
    If paths traverse the edge in both directions (the bridge of a cross-brace), or if the edge belongs to a ring outside all
    paths, its inner node is its first node. The inner node of any other edge is the node that is connected to base or platform
    without this edge.

    Args:
        edges: the two nodes of every edge, by key.
        base, platform: two of the nodes.
    """

    def __init__(self, edges: Mapping[str, tuple[int, int]], base: int, platform: int) -> None:
        self.base, self.platform = base, platform
        self._edges = dict(edges)
        self._directions = path_directions(edges, base, platform)

    def inner_first(self, edge: str) -> bool:
        """Whether the first node of an edge is its inner node."""
        if self._directions[edge]:
            return True in self._directions[edge]
        at = neighbours_of(ends for key, ends in self._edges.items() if key != edge)
        for target, barred in ((self.base, self.platform), (self.platform, self.base)):
            inner = reachable([target], lambda node: [other for other in at.get(node, []) if other != barred])  # noqa: B023
            for end, is_inner in zip(self._edges[edge], (True, False), strict=True):
                if end in inner:
                    return is_inner
        return True


#: Largest distance [m] of two beam ends of one link that count as one point.
SAME_END = 1e-6


@dataclass(frozen=True)
class PlacedJoint:
    """A joint or loop of the file at the pose, world axes.

    Attributes:
        kind: name of its type.
        links: predecessor and successor.
        frames: (4, 4) joint frames fixed to predecessor and successor.
        axis: (3,) axis; of a universal joint, the axis fixed to the predecessor.
        axis2: (3,) axis of a universal joint fixed to the successor.
        locked: whether it is actuated, or follows an actuated joint.
    """

    name: str
    kind: str
    links: tuple[str, str]
    frames: tuple[Array, Array]
    axis: Array
    axis2: Array
    locked: bool

    @property
    def type(self) -> JointType:
        return JOINT_TYPES[self.kind]

    def other(self, link: str) -> str:
        return self.links[1] if link == self.links[0] else self.links[0]


def placed_joints(configuration: Configuration) -> dict[str, PlacedJoint]:
    description = configuration.robot.description
    actuated = set(description.actuated)
    placed = {}
    for joint in description.joints.values():
        inner, outer = configuration.frame(joint.parent) @ joint.origin.matrix, configuration.frame(joint.child)
        axis = inner[:3, :3] @ np.array(joint.axis)
        locked = joint.name in actuated or joint.mimic is not None
        placed[joint.name] = PlacedJoint(joint.name, joint.type, (joint.parent, joint.child), (inner, outer), axis, axis, locked)
    for loop in description.loops.values():
        inner = configuration.frame(loop.predecessor) @ loop.predecessor_origin.matrix
        outer = configuration.frame(loop.successor) @ loop.successor_origin.matrix
        placed[loop.name] = PlacedJoint(
            loop.name,
            loop.type,
            (loop.predecessor, loop.successor),
            (inner, outer),
            inner[:3, :3] @ np.array(loop.axis),
            outer[:3, :3] @ np.array(loop.axis2),
            loop.name in actuated,
        )
    return placed


@dataclass(frozen=True)
class JointedPieces:
    """A joint between two pieces.

    Attributes:
        pieces: pieces of its predecessor and successor.
        along: only for a joint inside a telescopic beam: the beam's name, and whether the joint's predecessor is nearer to the
            beam's start.
    """

    joint: PlacedJoint
    pieces: tuple[int, int]
    along: tuple[str, bool] | None = None


@dataclass(frozen=True)
class PlacedBeam:
    """A beam at the pose: ``pieces`` and ``points`` (2, 3) [m] at its start and its end."""

    name: str
    pieces: tuple[int, int]
    points: Array


class RigidPieces:
    """All rigid pieces of one pose.

    A telescopic beam spans joints and belongs to one of the links between its ends, its carrier. The joints between its start and
    the carrier connect the start to the beam; the other joints connect the beam to its end. The links between all these joints,
    except the carrier, are intermediate pieces.

    Attributes:
        jointed: joints with their pieces, in the order of the file. A joint inside several telescopic beams has one entry for
            each beam, with pieces of that beam.
    """

    def __init__(self, configuration: Configuration) -> None:
        self.robot = configuration.robot
        self.description = self.robot.description
        self.joints = placed_joints(configuration)
        self._frame = {link: configuration.frame(link) for link in self.description.links}
        self._parent: list[int] = []
        #: pieces of each link with their points; point None: the link is one piece
        self._of: dict[str, list[tuple[Array | None, int]]] = {}
        self._inside: list[JointedPieces] = []
        #: for each intermediate piece of a telescopic beam, the piece at the nearer end of the beam
        self._whole: dict[int, int] = {}
        spans = SpanFinder(self.robot.mechanism).spans()
        self._carriers = {span.part.link for span in spans.values()}
        self._make(spans.values())
        self.beams = {name: self._place(span) for name, span in spans.items()}
        spanned = {jointed.joint.name for jointed in self._inside}
        order = list(self.joints)
        outside = [JointedPieces(joint, self._sides(joint)) for name, joint in self.joints.items() if name not in spanned]
        self.jointed = sorted([*outside, *self._inside], key=lambda jointed: order.index(jointed.joint.name))
        self.base, self.platform = self.of_link(self.description.base), self.of_link(self.description.platform)

    def find(self, piece: int) -> int:
        """Return the piece with which ``piece`` was merged, directly or through other pieces; an unmerged piece itself."""
        while self._parent[piece] != piece:
            piece = self._parent[piece]
        return piece

    def is_rigid(self, link: str) -> bool:
        return link not in self._carriers

    def of_link(self, link: str) -> int:
        """Return the piece of a link without beams."""
        return self.find(self._of[link][0][1])

    def at(self, link: str, point: Array) -> int:
        """Return the link's piece nearest to a point (3,), world axes."""

        def distance(entry: tuple[Array | None, int]) -> float:
            return 0.0 if entry[0] is None else float(np.linalg.norm(entry[0] - point))

        return self.find(min(self._of[link], key=distance)[1])

    def _sides(self, joint: PlacedJoint) -> tuple[int, int]:
        return self.at(joint.links[0], joint.frames[0][:3, 3]), self.at(joint.links[1], joint.frames[1][:3, 3])

    # ---- construction -----------------------------------------------------------------------------------------------

    def _new(self) -> int:
        self._parent.append(len(self._parent))
        return self._parent[-1]

    def _point(self, link: str, body_point: Array) -> Array:
        """Return the world position of a point given in the frame of the body that contains the link."""
        placement = self.robot.mechanism.body_of[link][1]
        return np.asarray((self._frame[link] @ np.linalg.solve(placement, np.append(body_point, 1.0)))[:3])

    def _make(self, spans: Iterable[Span]) -> None:
        for link in self.description.links:
            self._of[link] = [(None, self._new())] if self.is_rigid(link) else []
        for span in spans:
            for link, body_point in ((span.start_link, span.start), (span.end_link, span.end)):
                point = self._point(link, body_point)
                if not self.is_rigid(link) and not any(
                    earlier is not None and np.linalg.norm(earlier - point) < SAME_END for earlier, _ in self._of[link]
                ):
                    self._of[link].append((point, self._new()))
        for entries in self._of.values():
            if not entries:  # the carrier of a telescopic beam, with joints on both sides
                entries.append((None, self._new()))

    def _place(self, span: Span) -> PlacedBeam:
        start, end = self._point(span.start_link, span.start), self._point(span.end_link, span.end)
        chain = [self.joints[connection.name] for connection in (*span.inward[::-1], *span.outward)]
        links = [span.start_link]
        for joint in chain:
            links.append(joint.other(links[-1]))
        carrier = len(span.inward)
        for link in links[1:-1]:
            for _, piece in self._of[link][1:]:
                self._parent[self.find(piece)] = self.of_link(link)
        first, last = self.at(span.start_link, start), self.at(span.end_link, end)
        before = [first, *map(self.of_link, links[1:carrier])] if carrier else []
        after = [*map(self.of_link, links[carrier + 1 : -1]), last] if carrier < len(chain) else []
        ends = (self._new() if before else first, self._new() if after else last)
        if 0 < carrier < len(chain):  # other parts of the carrier move with the beam's start
            self._parent[self.of_link(links[carrier])] = ends[0]
        for piece in (*before, ends[0]):
            self._whole[piece] = first
        for piece in (*after, ends[1]):
            self._whole[piece] = last
        for row, joints, outer in (
            ([*before, ends[0]], chain[:carrier], links[1 : carrier + 1]),
            ([ends[1], *after], chain[carrier:], links[carrier + 1 :]),
        ):
            for joint, inner_piece, outer_piece, link in zip(joints, row, row[1:], outer, strict=False):
                forward = joint.links[1] == link
                pieces = (inner_piece, outer_piece) if forward else (outer_piece, inner_piece)
                self._inside.append(JointedPieces(joint, pieces, (span.part.name, forward)))
        return PlacedBeam(span.part.name, ends, np.array([start, end]))

    # ---- inner and outer sides ---------------------------------------------------------------------------------------

    @cached_property
    def _ends(self) -> tuple[set[int], set[int]]:
        """Return two sets: pieces fixed to the base, pieces fixed to the platform; by rigid joints between rigid links."""
        stiffnesses = self.description.joint_stiffness.values()
        elastic = {stiffness.joint for stiffness in stiffnesses if stiffness.linear or stiffness.angular}
        welds = [
            joint.links
            for joint in self.joints.values()
            if joint.type.is_fixed and joint.name not in elastic and all(map(self.is_rigid, joint.links))
        ]
        body_of = joined(self.description.links, welds)
        base, platform = (
            {self.of_link(link) for link in body_of[end]} for end in (self.description.base, self.description.platform)
        )
        return base, platform

    @cached_property
    def outside_limbs(self) -> frozenset[str]:
        """Names of joints inside the base, of joints inside the platform, and of floating joints."""
        return frozenset(
            jointed.joint.name
            for jointed in self.jointed
            if jointed.joint.type.is_free or any(set(jointed.pieces) <= end for end in self._ends)
        )

    @cached_property
    def _directions(self) -> Directions:
        base, platform = self._ends

        def node(piece: int) -> int:
            piece = self.find(self._whole.get(self.find(piece), piece))
            if piece in base:
                return self.base
            return self.platform if piece in platform else piece

        edges = {f"joint:{k}": jointed.pieces for k, jointed in enumerate(self.jointed) if jointed.along is None}
        edges |= {f"beam:{name}": beam.pieces for name, beam in self.beams.items()}
        return Directions({key: (node(first), node(second)) for key, (first, second) in edges.items()}, self.base, self.platform)

    def predecessor_is_inner(self, number: int) -> bool:
        """Whether the predecessor is on the inner side of the joint ``jointed[number]``."""
        along = self.jointed[number].along
        if along is None:
            return self._directions.inner_first(f"joint:{number}")
        beam, forward = along
        return self.start_is_inner(beam) == forward

    def start_is_inner(self, beam: str) -> bool:
        return self._directions.inner_first(f"beam:{beam}")
