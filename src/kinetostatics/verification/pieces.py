"""The rigid pieces of a robot at one pose, and which side of a joint or beam lies towards the base.

A piece is a link without beams, or what is fixed to one end of a beam. Everything here follows from the file and from the frames
of the links; it is on purpose not taken from :mod:`kinetostatics.topology`, which it checks.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from kinetostatics.beam_spans import BeamSpan
    from kinetostatics.configuration import Configuration

Array = NDArray[np.float64]

#: Points of one beam's link that are closer than this [m] are the same end.
SAME_END = 1e-6


@dataclass(frozen=True)
class PlacedJoint:
    """A joint or loop of the file at the pose, world axes.

    Attributes:
        name, kind: its name and type.
        links: predecessor and successor.
        frames: (4, 4) its frame on the side of either link.
        axis: (3,) first axis, seen from the predecessor.
        axis2: (3,) second axis of a universal joint, seen from the successor.
        driven: whether it is locked.
    """

    name: str
    kind: str
    links: tuple[str, str]
    frames: tuple[Array, Array]
    axis: Array
    axis2: Array
    driven: bool

    def other(self, link: str) -> str:
        """Return the link on the other side."""
        return self.links[1] if link == self.links[0] else self.links[0]


def placed_joints(configuration: Configuration) -> dict[str, PlacedJoint]:
    """Return all joints and loops of a single pose by name."""
    description = configuration.robot.description
    driven = set(description.driven)
    found = {}
    for joint in description.joints.values():
        inner, outer = configuration.frame(joint.parent) @ joint.origin.matrix, configuration.frame(joint.child)
        axis = inner[:3, :3] @ np.array(joint.axis)
        found[joint.name] = PlacedJoint(
            joint.name, joint.type, (joint.parent, joint.child), (inner, outer), axis, axis, joint.name in driven
        )
    for loop in description.loops.values():
        inner = configuration.frame(loop.predecessor) @ loop.predecessor_origin.matrix
        outer = configuration.frame(loop.successor) @ loop.successor_origin.matrix
        found[loop.name] = PlacedJoint(
            loop.name,
            loop.type,
            (loop.predecessor, loop.successor),
            (inner, outer),
            inner[:3, :3] @ np.array(loop.axis),
            outer[:3, :3] @ np.array(loop.axis2),
            loop.name in driven,
        )
    return found


@dataclass(frozen=True)
class PlacedBeam:
    """A beam at the pose: ``pieces`` and ``points`` (2, 3) of its ends.

    ``chain`` holds the joints that a telescopic beam spans, ``links`` the links between and around them, from its start to its
    end; the ``carrier``-th of the links carries the beam.
    """

    name: str
    pieces: tuple[int, int]
    points: Array
    chain: tuple[str, ...]
    links: tuple[str, ...]
    carrier: int


class Pieces:
    """All rigid pieces of one pose.

    Attributes:
        joints: all joints and loops by name.
        beams: all beams by name.
        spanned: names of the joints inside telescopic beams.
    """

    def __init__(self, configuration: Configuration) -> None:
        self.robot = configuration.robot
        self.description = self.robot.description
        self.joints = placed_joints(configuration)
        self._frame = {link: configuration.frame(link) for link in self.description.links}
        self._parent: list[int] = []
        #: the pieces of every link with the point at which each is found, None for a link without beams
        self._of: dict[str, list[tuple[Array | None, int]]] = {}
        spans = self.robot.topology.beams
        self._carriers = {span.beam.link for span in spans.values()}
        self._make(spans.values())
        self.beams = {name: self._place(span) for name, span in spans.items()}
        self.spanned = {name for beam in self.beams.values() for name in beam.chain}
        base, platform = self._alone(self.description.base), self._alone(self.description.platform)
        self.base, self.platform = self.find(base), self.find(platform)
        self._ends = [self._rigid_with(link) for link in (self.description.base, self.description.platform)]

    def find(self, piece: int) -> int:
        """Return the piece that a piece has become part of."""
        while self._parent[piece] != piece:
            piece = self._parent[piece]
        return piece

    def is_rigid(self, link: str) -> bool:
        """Whether a link carries no beam, and so weighs at its centre of mass."""
        return link not in self._carriers

    def of_link(self, link: str) -> int:
        """Return the piece of a link without beams."""
        return self.find(self._of[link][0][1])

    def at(self, link: str, point: Array) -> int:
        """Return the piece of a link at a point (3,), or the nearest to it."""

        def distance(entry: tuple[Array | None, int]) -> float:
            return 0.0 if entry[0] is None else float(np.linalg.norm(entry[0] - point))

        return self.find(min(self._of[link], key=distance)[1])

    def ends_of(self, joint: PlacedJoint) -> tuple[int, int]:
        """Return the pieces of predecessor and successor of a joint."""
        return tuple(self.at(link, frame[:3, 3]) for link, frame in zip(joint.links, joint.frames, strict=True))  # type: ignore[return-value]

    # ---- making them ------------------------------------------------------------------------------------------------

    def _new(self) -> int:
        self._parent.append(len(self._parent))
        return self._parent[-1]

    def _alone(self, link: str) -> int:
        return self._of[link][0][1]

    def _point(self, link: str, body_point: Array) -> Array:
        """Return the world position of a point given in the body of a link."""
        placement = self.robot.mechanism.body_of[link][1]
        return np.asarray((self._frame[link] @ np.linalg.solve(placement, np.append(body_point, 1.0)))[:3])

    def _make(self, spans: Iterable[BeamSpan]) -> None:
        for link in self.description.links:
            self._of[link] = [(None, self._new())] if self.is_rigid(link) else []
        for span in spans:
            for link, body_point in ((span.start_link, span.start), (span.end_link, span.end)):
                point = self._point(link, body_point)
                if not self.is_rigid(link) and not any(
                    known is not None and np.linalg.norm(known - point) < SAME_END for known, _ in self._of[link]
                ):
                    self._of[link].append((point, self._new()))
        for entries in self._of.values():
            if not entries:  # a link in the middle of its telescopic beam
                entries.append((None, self._new()))

    def _place(self, span: BeamSpan) -> PlacedBeam:
        start = self._point(span.start_link, span.start)
        end = self._point(span.end_link, span.end)
        first, last = self.at(span.start_link, start), self.at(span.end_link, end)
        chain = [item.name for item in (*span.inward[::-1], *span.outward)]
        links = [span.start_link]
        for name in chain:
            links.append(self.joints[name].other(links[-1]))
        carrier = len(span.inward)
        for number, link in enumerate(links[1:-1], 1):
            # what the beam passes through moves with the end on its side of the carrier, the carrier itself with the start
            if number != carrier or self._of[link][0][0] is None:
                for _, piece in self._of[link]:
                    self._parent[self.find(piece)] = first if number <= carrier else last
        return PlacedBeam(span.beam.name, (first, last), np.array([start, end]), tuple(chain), tuple(links), carrier)

    # ---- which side is inboard --------------------------------------------------------------------------------------

    def _rigid_with(self, link: str) -> set[int]:
        """Return the pieces that fixed joints between links without beams join to a link."""
        found, queue = {link}, [link]
        while queue:
            here = queue.pop()
            for joint in self.joints.values():
                if joint.kind == "fixed" and here in joint.links:
                    other = joint.other(here)
                    if other not in found and self.is_rigid(other):
                        found.add(other)
                        queue.append(other)
        return {self.of_link(item) for item in found}

    def inner_first(self, edge: str, pieces: tuple[int, int]) -> bool:
        """Whether the first of the two pieces that a joint or beam joins lies towards the base.

        On what hangs on the platform alone, towards the platform. In a closed chain inside a limb the first is.

        Args:
            edge: the joint's name, or ``beam:`` and the beam's.
            pieces: on its two sides.
        """
        for target, barred in (self._ends, self._ends[::-1]):
            first, second = (self._reaches(piece, target, barred, edge) for piece in pieces)
            if first or second:
                return first
        return True

    def _reaches(self, piece: int, target: set[int], barred: set[int], without: str) -> bool:
        seen, queue = {piece}, [piece]
        while queue:
            here = queue.pop()
            if here in target:
                return True
            if here in barred:
                continue
            for name, ends in self._edges():
                if name != without and here in ends:
                    other = ends[1] if here == ends[0] else ends[0]
                    if other not in seen:
                        seen.add(other)
                        queue.append(other)
        return False

    def _edges(self) -> list[tuple[str, tuple[int, int]]]:
        if not hasattr(self, "_all_edges"):
            edges = [(joint.name, self.ends_of(joint)) for joint in self.joints.values() if joint.name not in self.spanned]
            edges += [
                (f"beam:{beam.name}", (self.find(beam.pieces[0]), self.find(beam.pieces[1]))) for beam in self.beams.values()
            ]
            self._all_edges = edges
        return self._all_edges
