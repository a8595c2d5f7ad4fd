"""The graph of a robot: rigid bodies joined by joints, loops and beams, and the direction of its edges from base to platform.

A *body* is a link without beams, or one end of a link with beams. Joints, loops and beams are the *edges* between bodies. The
graph depends neither on names nor on the cuts of loops in the file.

An edge has the direction in which paths from base to platform pass it. Edges passed in both directions have the direction of an
order of the bodies in which each body on a path has an earlier and a later neighbour, so that there are no directed rings.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from kinetostatics.math.arrays import Array
from kinetostatics.math.graphs import path_directions, reachable, st_order
from kinetostatics.mechanism.beam_geometry import SAME_POINT, Span, SpanFinder, beam_error
from kinetostatics.mechanism.mechanism import Connection, Mechanism


@dataclass(eq=False)
class RigidBody:
    """Links and ends of beams that move together.

    Attributes:
        links: links of the body; a link with beams belongs to every body at an end of its beams.
        rigid_links: links without beams.
        weights: links without beams that have mass.
        attachments: attachments at which loads may act: links without beams, and ends of beams.
    """

    links: list[str] = field(default_factory=list)
    rigid_links: list[str] = field(default_factory=list)
    weights: list[str] = field(default_factory=list)
    attachments: list[str] = field(default_factory=list)


@dataclass(eq=False)
class BodyEdge:
    """A joint or elastic link between two bodies; ``ends``: predecessor and successor, or start and end of the link.

    ``ports``: the ends while an elastic base or platform is elastic, in a graph in which it is rigid.
    """

    ends: tuple[RigidBody, RigidBody]
    connection: Connection | None = None
    span: Span | None = None
    ports: tuple[RigidBody, RigidBody] | None = None

    @property
    def key(self) -> str:
        """The name of the joint, or ``beam:`` and the name of the beam, as in :class:`~kinetostatics.mechanism.limbs.Edge`."""
        if self.connection is not None:
            return self.connection.name
        return f"beam:{self.span.name}" if self.span else ""

    def other(self, body: RigidBody) -> RigidBody:
        return self.ends[self.ends[0] is body]


def body_at_end(attachment: str) -> str:
    """Return the attachment that moves with the body at the end of a telescopic beam; ``attachment`` moves with its link."""
    return f"body at {attachment}"


class BodyGraph:
    """Rigid bodies and edges of a mechanism.

    Attributes:
        base_links, platform_links: links of these two bodies.
        spans: span of each beam, from start to end as in the file.
        bodies: all bodies, in the order of the file.
        edges: all edges between different bodies: beams in the order of the file, then joints in the order of their links.
        misplaced: joints attached to a beam between the beam's ends, each with the beam's link.
        plates: edges of an elastic base or platform, by its link, from the ground or o to each further interface, if it is taken
            as rigid; they are not among ``edges``.
    """

    def __init__(self, mechanism: Mechanism, rigid_plates: bool = False) -> None:
        self.mechanism = mechanism
        self.description = mechanism.description
        finder = SpanFinder(mechanism)
        self.beams_of = finder.beams_of
        self.base_links, self.platform_links = finder.base_links, finder.platform_links
        self.spans = finder.spans()

        self.misplaced: list[tuple[Connection, str]] = []
        #: the bodies of every link, each with an end point of the link's beams
        self._at = {link: self._bodies_of(link) for link in self.description.links}
        self._join_links_in_spans()
        self.base, self.platform = (
            self._join([self._at[link][0][1] for link in self.description.links if link in links])
            for links in (self.base_links, self.platform_links)
        )
        self.edges = self._in_order([*self._beam_edges(), *self._joint_edges()])
        self.plates: dict[str, list[BodyEdge]] = {}
        for root, link in ((self.base, self.description.base), (self.platform, self.description.platform)):
            if rigid_plates and link in self.beams_of:
                self._make_rigid(root, link)
        self.bodies = list(dict.fromkeys(body for here in self._at.values() for _, body in here))
        for link, here in self._at.items():
            for point, body in here:
                body.links.append(link)
                if point is None:
                    body.rigid_links.append(link)
                    if self.weighs(link):
                        body.weights.append(link)
                    if self.is_rigid(link):
                        body.attachments.append(link)
        for span in self.spans.values():
            for attachment, body in zip(span.attachments, self._ends(span), strict=True):
                if attachment not in body.attachments:
                    body.attachments += [attachment, body_at_end(attachment)] if span.spanned else [attachment]

    def links_of(self, bodies: list[RigidBody], edges: list[BodyEdge]) -> tuple[str, ...]:
        links = {link for body in bodies for link in body.links}
        links.update(edge.span.part.link for edge in edges if edge.span is not None)
        return tuple(link for link in self.description.links if link in links)

    def weighs(self, link: str) -> bool:
        """Whether a link has mass and no beams."""
        return self.is_rigid(link) and self.description.links[link].mass > 0

    def is_rigid(self, link: str) -> bool:
        """Whether a link has no beams."""
        return link not in self.beams_of

    # ---- construction -----------------------------------------------------------------------------------------------

    def _bodies_of(self, link: str) -> list[tuple[Array | None, RigidBody]]:
        """Return (point, body) for each end point (3,) of the beams of a link; (None, body) for a link without beams."""
        points: list[Array] = []
        beams = [beam.name for beam in self.beams_of.get(link, [])]
        for span in (span for span in self.spans.values() if span.part.name in beams):
            for owner, point in ((span.start_link, span.start), (span.end_link, span.end)):
                if owner == link and not any(_are_one_point(point, other) for other in points):
                    points.append(point)
        return [(point, RigidBody()) for point in points] or [(None, RigidBody())]

    def _body_at(self, link: str, point: Array) -> RigidBody | None:
        """Return the body of a link at a point (3,); None if the point is between the ends of a beam."""
        return next((body for other, body in self._at[link] if other is None or _are_one_point(point, other)), None)

    def _ends(self, span: Span) -> tuple[RigidBody, RigidBody]:
        start, end = self._body_at(span.start_link, span.start), self._body_at(span.end_link, span.end)
        if start is None or end is None:
            raise beam_error(span.part, "it ends in the middle of another beam; split that beam with a fixed joint")
        return start, end

    def _join(self, bodies: list[RigidBody]) -> RigidBody:
        """Replace several bodies by the first of them, and return it."""
        for link, here in self._at.items():
            self._at[link] = [(point, bodies[0] if body in bodies else body) for point, body in here]
        return bodies[0]

    def _make_rigid(self, root: RigidBody, link: str) -> None:
        """Join the interfaces of an elastic base or platform."""
        ports = {body for _, body in self._at[link]}
        root.weights += [f"beam:{beam.name}" for beam in self.beams_of[link]]
        for edge in self.edges:
            edge.ports = edge.ports or edge.ends
            first, second = (root if end in ports else end for end in edge.ends)
            edge.ends = first, second
        self.plates[link] = [edge for edge in self.edges if edge.span is not None and edge.span.part.link == link]
        self.edges = [edge for edge in self.edges if edge not in self.plates[link]]
        self._join([root, *ports])

    def _join_links_in_spans(self) -> None:
        """Join each link within a beam's span to the start or end on its side of the beam's link.

        The beam's link joins the start, unless a beam ends on it.
        """
        for span in self.spans.values():
            ends = self._ends(span)
            for path, body in zip((span.inward, span.outward), ends, strict=True):
                link = span.part.link
                for connection in path[:-1]:
                    link = connection.other(link)
                    self._join([body, *(other for _, other in self._at[link])])
            point, beam_body = self._at[span.part.link][0]
            if point is None and beam_body not in ends:
                self._join([ends[0], beam_body])

    def _beam_edges(self) -> Iterator[BodyEdge]:
        for span in self.spans.values():
            ends = self._ends(span)
            if ends[0] is ends[1]:
                raise beam_error(span.part, "its two ends are fixed to the same rigid piece")
            yield BodyEdge(ends, span=span)

    def _joint_edges(self) -> Iterator[BodyEdge]:
        inside = {joint.name for span in self.spans.values() for joint in (*span.inward, *span.outward)}
        for connection in self.mechanism.connections.values():
            if connection.name not in inside:
                ends = self._body_of(connection, connection.predecessor), self._body_of(connection, connection.successor)
                if ends[0] is not ends[1]:
                    yield BodyEdge(ends, connection=connection)

    def _body_of(self, connection: Connection, link: str) -> RigidBody:
        """Return the body of a link to which a joint is attached; for a joint between the ends of a beam, the nearest body."""
        centre = connection.centre_on(link)
        body = self._body_at(link, centre)
        if body is None and connection.type.is_free and link in (self.description.base, self.description.platform):
            return self._at[link][0][1]
        if body is None:
            self.misplaced.append((connection, link))
            body = min(self._at[link], key=lambda at: 0.0 if at[0] is None else float(np.linalg.norm(centre - at[0])))[1]
        return body

    def _in_order(self, edges: list[BodyEdge]) -> list[BodyEdge]:
        """Sort joints by the order of their links in the file; beams remain first."""
        order: dict[RigidBody, int] = {}
        for number, here in enumerate(self._at.values()):
            for _, body in here:
                order.setdefault(body, number)
        return sorted(edges, key=lambda edge: [] if edge.span is not None else sorted(order[end] for end in edge.ends))


def _are_one_point(first: Array, second: Array) -> bool:
    return float(np.linalg.norm(first - second)) < SAME_POINT


_Edges = dict[RigidBody, list[BodyEdge]]


@dataclass(frozen=True)
class DirectedEdge:
    """An edge with its direction.

    Attributes:
        inner, outer: bodies at the edge's inboard and outboard end.
        in_tree: whether the spanning tree reaches ``outer`` through the edge.
        both_ways: whether paths from base to platform pass the edge in both directions.
    """

    edge: BodyEdge
    inner: RigidBody
    outer: RigidBody
    in_tree: bool
    both_ways: bool


def directed_edges(edges: list[BodyEdge], base: RigidBody, platform: RigidBody) -> list[DirectedEdge]:
    """Return the edges of a limb or attached body in depth-first order from the base, or from the platform if the base has none.

    The search starts at the base (or platform). An edge comes after the edges by which the search reached the edge's inner body.
    ``edges``: all edges of the limb or attached body, or one edge between base and platform.
    """
    touched = {end for edge in edges for end in edge.ends}
    root = base if base in touched else platform
    inner: dict[BodyEdge, RigidBody] = {}
    both_ways: set[BodyEdge] = set()
    stars = stars_of(edges)
    order: dict[RigidBody | str, int] = {}
    directions: dict[BodyEdge | tuple[str, RigidBody], set[bool]] = {}
    if base in touched and platform in touched:
        ends: dict[BodyEdge | tuple[str, RigidBody], tuple[RigidBody | str, RigidBody | str]] = {}
        ends |= {edge: edge.ends for edge in edges if edge.span is None or edge.span.part.name not in stars}
        ends |= {(name, port): (name, port) for name, star in stars.items() for port in _ports(star)}
        order, directions = st_order(ends.values(), base, platform), path_directions(ends, base, platform)
    if stars:
        _put_inner_ports_first(stars.values(), edges, root, order)
    for edge in edges:
        name = "" if edge.span is None else edge.span.part.name
        passed = directions.get((name, edge.ends[1]) if name in stars else edge)
        if passed:
            inner[edge] = min(edge.ends, key=order.__getitem__)
            if len(passed) == 2 and name not in stars:
                both_ways.add(edge)
    at: _Edges = {}
    for edge in edges:
        for end in edge.ends:
            at.setdefault(end, []).append(edge)
    reached_by: dict[RigidBody, BodyEdge] = {}
    for edge in sorted(inner, key=lambda edge: edge.span is None):  # beams first, so that they are in the tree
        outer = edge.other(inner[edge])
        if outer is not platform:
            reached_by.setdefault(outer, edge)
    on_paths = dict.fromkeys([root, *(end for edge in inner for end in edge.ends)])
    seen = set(on_paths)
    # dead ends are directed away from the other edges
    for body in reachable(on_paths, lambda body: [edge.other(body) for edge in at[body]]):
        for edge in at[body]:
            other = edge.other(body)
            if edge not in inner:
                inner[edge] = edge.ends[0] if other in seen else body  # an edge to a body seen closes a ring of a dead end
                if _in_ring(edge, at, on_paths):
                    both_ways.add(edge)
            if other not in seen:
                seen.add(other)
                reached_by[other] = edge
    return list(_depth_first(root, edges, inner, reached_by, both_ways))


def stars_of(edges: Iterable[BodyEdge]) -> dict[str, list[BodyEdge]]:
    """Return the edges of each elastic link with three or more interfaces, from one of its ports (interfaces) to the others."""
    stars: dict[str, list[BodyEdge]] = {}
    for edge in edges:
        if edge.span is not None:
            stars.setdefault(edge.span.part.name, []).append(edge)
    return {name: star for name, star in stars.items() if len(star) > 1}


def _ports(star: Sequence[BodyEdge]) -> list[RigidBody]:
    return [star[0].ends[0], *(edge.ends[1] for edge in star)]


def _put_inner_ports_first(
    stars: Iterable[list[BodyEdge]], edges: Iterable[BodyEdge], root: RigidBody, order: Mapping[RigidBody | str, int]
) -> None:
    """Let the edges of each elastic link begin at its port that is first on paths, or on a dead end first from the root.

    With the link as a node of its own in ``order``, this port has an earlier neighbour outside of the link.
    """
    at: _Edges = {}
    for edge in edges:
        for end in edge.ends:
            at.setdefault(end, []).append(edge)
    from_root = {body: number for number, body in enumerate(reachable([root], lambda body: [e.other(body) for e in at[body]]))}
    for star in stars:
        spans = [edge.span for edge in star if edge.span is not None]
        ports = list(zip(_ports(star), (spans[0].start, *(span.end for span in spans)), strict=True))
        attachments = [spans[0].attachments[0], *(span.attachments[1] for span in spans)]
        first = min(range(len(ports)), key=lambda k: (order.get(ports[k][0], math.inf), from_root[ports[k][0]]))
        others = [k for k in range(len(ports)) if k != first]
        for edge, span, other in zip(star, spans, others, strict=True):
            edge.ends = ports[first][0], ports[other][0]
            ends = attachments[first], attachments[other]
            edge.span = replace(span, start=ports[first][1], end=ports[other][1], attachments=ends)


def edges_beside(edges: list[BodyEdge], leading: set[BodyEdge]) -> dict[BodyEdge, list[str]]:
    """Return the edges of elastic links to further interfaces, which carry no cut-joint wrench, with the keys of the others."""
    beside: dict[BodyEdge, list[str]] = {}
    for star in stars_of(edges).values():
        others = [edge.key for edge in star if edge in leading]
        if others:
            beside |= {edge: others for edge in star if edge not in leading}
    return beside


def _in_ring(edge: BodyEdge, at: _Edges, on_paths: Iterable[RigidBody]) -> bool:
    """Whether an edge that no path from base to platform passes is part of a ring: both its ends are reached without it."""
    reached = reachable(on_paths, lambda body: [adjacent.other(body) for adjacent in at[body] if adjacent is not edge])
    return all(end in reached for end in edge.ends)


def _depth_first(
    root: RigidBody,
    edges: list[BodyEdge],
    inner: dict[BodyEdge, RigidBody],
    reached_by: dict[RigidBody, BodyEdge],
    both_ways: set[BodyEdge],
) -> Iterator[DirectedEdge]:
    leaving: dict[RigidBody, list[BodyEdge]] = {}
    for edge in edges:
        leaving.setdefault(inner[edge], []).append(edge)
    stack = leaving.get(root, [])[::-1]
    while stack:
        edge = stack.pop()
        outer = edge.other(inner[edge])
        in_tree = reached_by.get(outer) is edge
        yield DirectedEdge(edge, inner[edge], outer, in_tree, edge in both_ways)
        if in_tree:
            stack.extend(leaving.get(outer, [])[::-1])
