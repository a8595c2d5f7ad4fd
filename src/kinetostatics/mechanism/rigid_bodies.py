"""The graph of a robot: rigid bodies joined by joints, loops and beams.

A *body* moves as a rigid body: a link without beams, or one end of a beam's link. Joints, loops and beams are the *edges*
between bodies. No name and no cut of the file plays a part.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from kinetostatics.math.arrays import Array
from kinetostatics.mechanism.beam_geometry import SAME_POINT, BeamSpan, SpanFinder, beam_error
from kinetostatics.mechanism.mechanism import Connection, Mechanism


@dataclass(eq=False)
class RigidBody:
    """A rigid body; ``point`` tells the bodies of one beam link apart, ``weights`` names the rigid links that weigh on it."""

    link: str
    point: Array | None = None
    weights: list[str] = field(default_factory=list)
    merged: RigidBody | None = None

    def find(self) -> RigidBody:
        """Return the body that this one has been made part of."""
        body = self
        while body.merged is not None:
            body = body.merged
        return body


@dataclass(eq=False)
class BodyEdge:
    """A joint or a beam between two bodies: predecessor and successor, or the beam's start and end."""

    inner: RigidBody
    outer: RigidBody
    connection: Connection | None = None
    beam: BeamSpan | None = None

    @property
    def ends(self) -> tuple[RigidBody, RigidBody]:
        """The bodies on both sides, inner and outer."""
        return self.inner.find(), self.outer.find()

    @property
    def key(self) -> str:
        """The joint's name, or ``beam:`` and the beam's, as of an :class:`~kinetostatics.mechanism.limbs.Edge`."""
        return self.connection.name if self.connection is not None else f"beam:{self.beam.beam.name}" if self.beam else ""

    def other(self, body: RigidBody) -> RigidBody:
        """Return the body on the other side."""
        inner, outer = self.ends
        return outer if inner is body else inner


def place_of_end(beam: str, end: int) -> str:
    """Return the name of the place at a beam's start (0) or end (1), as in the file."""
    return f"{('start', 'end')[end]}:{beam}"


class BodyGraph:
    """Pieces and edges of a mechanism.

    Attributes:
        base, platform: the bodies that base and platform belong to.
        base_links, platform_links: links that are rigidly part of them.
        spans: all beams, from start to end as in the file.
        edges: all edges between different bodies: beams in the order of the file, joints in that of their links.
        misplaced: joints that are attached to a beam elsewhere than at its ends, and the beam's link.
        warnings: what is suspicious, in full sentences.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self.description = mechanism.description
        finder = SpanFinder(mechanism)
        self.beams_of = finder.beams_of
        self.base_links, self.platform_links = finder.base_links, finder.platform_links
        self.spans = finder.spans()
        self.warnings = list(finder.warnings)
        self._bodies: dict[str, list[RigidBody]] = {}
        self._ends: dict[str, RigidBody] = {}
        self.misplaced: list[tuple[Connection, str]] = []
        self._make_bodies()
        edges = self._make_edges()
        self.base, self.platform = self._merge(self.base_links), self._merge(self.platform_links)
        self.edges = self._in_order([edge for edge in edges if edge.inner.find() is not edge.outer.find()])
        for edge in edges:
            if edge.beam is not None and edge.inner.find() is edge.outer.find():
                raise beam_error(edge.beam.beam, "its two ends are fixed to the same rigid piece")
        self._links_of: dict[RigidBody, list[str]] = {}
        self._weights_of: dict[RigidBody, list[str]] = {}
        self._rigid_links_of: dict[RigidBody, list[str]] = {}
        for link, bodies in self._bodies.items():
            for body in bodies:
                whole = body.find()
                self._links_of.setdefault(whole, []).append(link)
                self._weights_of.setdefault(whole, []).extend(body.weights)
                if body.point is None:
                    self._rigid_links_of.setdefault(whole, []).append(link)
        self._places_of: dict[RigidBody, list[str]] = {
            body: [link for link in links if link not in self.beams_of] for body, links in self._rigid_links_of.items()
        }
        for name, body in self._ends.items():
            self._places_of.setdefault(body.find(), []).append(name)

    def bodies(self) -> list[RigidBody]:
        """Return all bodies, in the order of the file."""
        return list(dict.fromkeys(body.find() for bodies in self._bodies.values() for body in bodies))

    def weights_of(self, body: RigidBody) -> list[str]:
        """Return the names of the rigid links that weigh on a body."""
        return self._weights_of.get(body, [])

    def places_of(self, body: RigidBody) -> list[str]:
        """Return the names of the places of a body at which loads may act: its links without beams, and the ends of beams."""
        return self._places_of.get(body, [])

    def rigid_links_of(self, body: RigidBody) -> list[str]:
        """Return the links without beams that a body consists of."""
        return self._rigid_links_of.get(body, [])

    def links_of(self, bodies: list[RigidBody], edges: list[BodyEdge]) -> tuple[str, ...]:
        """Return the links of some bodies and beams, in the order of the file."""
        found = {link for body in bodies for link in self._links_of.get(body, [])}
        found.update(edge.beam.beam.link for edge in edges if edge.beam is not None)
        return tuple(link for link in self.description.links if link in found)

    def weighs(self, link: str) -> bool:
        """Whether a link is rigid and weighs something."""
        return self.is_rigid(link) and self.description.links[link].mass > 0

    def is_rigid(self, link: str) -> bool:
        """Whether a link has no beams."""
        return link not in self.beams_of

    # ---- construction -----------------------------------------------------------------------------------------------

    def _body_at(self, link: str, point: Array) -> RigidBody | None:
        """Return the body of a link at a point, None if the link has beams and none of them ends there."""
        bodies = self._bodies[link]
        if bodies[0].point is None:
            return bodies[0].find()
        for body in bodies:
            if body.point is not None and float(np.linalg.norm(body.point - point)) < SAME_POINT:
                return body.find()
        return None

    def _make_bodies(self) -> None:
        for link, data in self.description.links.items():
            if link not in self.beams_of:
                self._bodies[link] = [RigidBody(link, weights=[link] if data.mass > 0 else [])]
                continue
            self._bodies[link] = []
            for beam in self.beams_of[link]:
                span = self.spans[beam.name]
                for owner, point in ((span.start_link, span.start), (span.end_link, span.end)):
                    if owner == link and (not self._bodies[link] or self._body_at(link, point) is None):
                        self._bodies[link].append(RigidBody(link, point))
            if not self._bodies[link]:
                self._bodies[link] = [RigidBody(link)]

    def _make_edges(self) -> list[BodyEdge]:
        edges: list[BodyEdge] = []
        inside: set[str] = set()
        for beam in self.description.beams.values():
            span = self.spans[beam.name]
            start, end = self._body_at(span.start_link, span.start), self._body_at(span.end_link, span.end)
            if start is None or end is None:
                raise beam_error(beam, "it ends in the middle of another beam; split that beam with a fixed joint")
            self._ends |= {place_of_end(beam.name, 0): start, place_of_end(beam.name, 1): end}
            inside.update(item.name for item in (*span.inward, *span.outward))
            for path, body in ((span.inward, start), (span.outward, end)):
                link = beam.link
                for item in path[:-1]:  # links in mid-span go with the end on their side
                    link = item.other(link)
                    for other in self._bodies[link]:
                        if other.find() is not body.find():
                            other.find().merged = body.find()
            if self._bodies[beam.link][0].point is None and self._bodies[beam.link][0].find() not in (start, end):
                self._bodies[beam.link][0].find().merged = start.find()
            edges.append(BodyEdge(start, end, beam=span))
        for connection in self.mechanism.connections.values():
            if connection.name in inside:
                continue
            ends: list[RigidBody] = []
            for link in (connection.predecessor, connection.successor):
                found = self._body_at(link, connection.centre_on(link))
                if found is None:
                    self.misplaced.append((connection, link))
                ends.append(found or self._nearest_body(link, connection.centre_on(link)))
            edges.append(BodyEdge(ends[0], ends[1], connection=connection))
        return edges

    def _in_order(self, edges: list[BodyEdge]) -> list[BodyEdge]:
        """Sort joints by the places of their links in the file, be they joints of its tree or loops; beams stay first."""
        order: dict[RigidBody, int] = {}
        for number, bodies in enumerate(self._bodies.values()):
            for body in bodies:
                order.setdefault(body.find(), number)

        def place(edge: BodyEdge) -> list[int]:
            return [] if edge.beam is not None else sorted((order[edge.inner.find()], order[edge.outer.find()]))

        return sorted(edges, key=place)

    def _nearest_body(self, link: str, point: Array) -> RigidBody:
        gaps = [0.0 if body.point is None else float(np.linalg.norm(point - body.point)) for body in self._bodies[link]]
        return self._bodies[link][int(np.argmin(gaps))].find()

    def _merge(self, links: set[str]) -> RigidBody:
        bodies = [self._bodies[link][0].find() for link in self.description.links if link in links]
        for body in bodies[1:]:
            if body is not bodies[0]:
                body.merged = bodies[0]
        return bodies[0]
