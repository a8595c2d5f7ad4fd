"""From links and joints to limbs: the graph of rigid pieces, joints and beams, cut at base and platform.

A *node* is a piece that moves as a rigid body: a link without beams, or one end of a beam's link. Joints, loops and beams are
the *edges* between nodes. With base and platform removed, every connected component that touches both is a limb; one that
touches only one of them is dead weight on it (``docs/method.md``, section 2). No name and no cut of the file plays a part.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from kinetostatics.beam_spans import SAME_POINT, BeamSpan, SpanFinder, beam_error
from kinetostatics.description import Beam
from kinetostatics.exceptions import NotYetError, RobotFileError
from kinetostatics.mechanism import Connection, Mechanism

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Edge:
    """A joint or a beam as it lies on the way out from the base (or, on a dead branch, from what it hangs on).

    Attributes:
        joint: name of the joint or loop, or None for a beam.
        beam: name of the beam, or None for a joint.
        sign: +1 if the joint's predecessor is its inboard side, else −1.
        outboard: names of the weights outboard of it; for a beam, of its outer end. Weights are named after their link or,
            for distributed ones, ``beam:`` and the beam.
        excluded: names of weights that what lies outboard seems to carry but does not: of links inside a telescope that go with
            its outer end although they hang on the inner side of this joint.
        parent: ``key`` of the edge on its inboard side, None if that is the base (of dead weight on the platform: the platform).
    """

    joint: str | None
    beam: str | None
    sign: int
    outboard: tuple[str, ...]
    parent: str | None
    excluded: tuple[str, ...] = ()

    @property
    def key(self) -> str:
        """The joint's name, or ``beam:`` and the beam's."""
        return self.joint if self.joint is not None else f"beam:{self.beam}"


@dataclass(frozen=True)
class Limb:
    """A serial limb: the edges from base to platform in turn, and what hangs on it.

    Attributes:
        name: ``limb_1``, …
        links: its links, in the order of the file.
        path: joints and beams from base to platform. The joints inside a telescopic beam stand next to it.
        branches: joints and beams of dead branches on the limb.
        weights: names of its weights.
        weight_between: whether a weight lies directly outboard of the path's k-th edge, before the next.
    """

    name: str
    links: tuple[str, ...]
    path: tuple[Edge, ...]
    branches: tuple[Edge, ...]
    weights: tuple[str, ...]
    weight_between: tuple[bool, ...]


@dataclass(frozen=True)
class DeadWeight:
    """What hangs on the base or on the platform alone, the rigid links of base or platform included."""

    links: tuple[str, ...]
    edges: tuple[Edge, ...]
    weights: tuple[str, ...]


@dataclass(frozen=True)
class Topology:
    """The robot's limbs, beams and dead weights.

    ``carried_by`` tells for every rigid link of a limb or dead branch the ``key`` of the edge that it is the outer side of.
    """

    limbs: tuple[Limb, ...]
    base: DeadWeight
    platform: DeadWeight
    beams: dict[str, BeamSpan]
    carried_by: dict[str, str]
    warnings: tuple[str, ...]


@dataclass(eq=False)
class _Node:
    """A rigid piece; ``point`` tells the nodes of one beam link apart."""

    link: str
    point: Array | None = None
    weights: list[str] = field(default_factory=list)
    merged: _Node | None = None

    def find(self) -> _Node:
        node = self
        while node.merged is not None:
            node = node.merged
        return node


@dataclass(eq=False)
class _GraphEdge:
    inner: _Node
    outer: _Node
    connection: Connection | None = None
    beam: BeamSpan | None = None

    def other(self, node: _Node) -> _Node:
        return self.outer.find() if self.inner.find() is node else self.inner.find()


def analyze_topology(mechanism: Mechanism) -> Topology:
    """Find limbs, beams and dead weights.

    Raises:
        RobotFileError: a beam's ends or what is attached along it make no sense.
        NotYetError: a limb branches or contains a closed chain.
    """
    return _Builder(mechanism).build()


class _Builder:
    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self.description = mechanism.description
        self.warnings: list[str] = []
        self.beams_of: dict[str, list[Beam]] = {}
        for beam in self.description.beams.values():
            self.beams_of.setdefault(beam.link, []).append(beam)
        self.nodes: dict[str, list[_Node]] = {}
        self.edges: list[_GraphEdge] = []
        self.misplaced: list[tuple[_GraphEdge, Connection, str]] = []
        self.carried_by: dict[str, str] = {}

    # ---- nodes and edges --------------------------------------------------------------------------------------------

    def _node_at(self, link: str, point: Array) -> _Node | None:
        """Return the node of a link at a point, None if the link has beams and none of them ends there."""
        nodes = self.nodes[link]
        if nodes[0].point is None:
            return nodes[0].find()
        for node in nodes:
            if node.point is not None and float(np.linalg.norm(node.point - point)) < SAME_POINT:
                return node.find()
        return None

    def _make_nodes(self) -> None:
        for link, data in self.description.links.items():
            if link not in self.beams_of:
                self.nodes[link] = [_Node(link, weights=[link] if data.mass > 0 else [])]
                continue
            self.nodes[link] = []
            for beam in self.beams_of[link]:
                span = self.spans[beam.name]
                for owner, point in ((span.start_link, span.start), (span.end_link, span.end)):
                    if owner == link and (not self.nodes[link] or self._node_at(link, point) is None):
                        self.nodes[link].append(_Node(link, point))
            if not self.nodes[link]:
                self.nodes[link] = [_Node(link)]

    def _make_edges(self) -> None:
        inside: set[str] = set()
        for beam in self.description.beams.values():
            span = self.spans[beam.name]
            start, end = self._node_at(span.start_link, span.start), self._node_at(span.end_link, span.end)
            if start is None or end is None:
                raise beam_error(beam, "it ends in the middle of another beam; split that beam with a fixed joint")
            if start is end:
                raise beam_error(beam, "its two ends are fixed to the same rigid piece")
            inside.update(item.name for item in (*span.inward, *span.outward))
            for path, node in ((span.inward, start), (span.outward, end)):
                link = beam.link
                for item in path[:-1]:  # links in mid-span go with the end on their side
                    link = item.other(link)
                    for other in self.nodes[link]:
                        if other.find() is not node.find():
                            other.find().merged = node.find()
            if self.nodes[beam.link][0].point is None and self.nodes[beam.link][0].find() not in (start, end):
                self.nodes[beam.link][0].find().merged = start.find()
            self.edges.append(_GraphEdge(start, end, beam=span))
        for connection in self.mechanism.connections.values():
            if connection.name in inside:
                continue
            ends: list[_Node] = []
            missing: list[str] = []
            for link in (connection.predecessor, connection.successor):
                found = self._node_at(link, connection.centre_on(link))
                if found is None:
                    missing.append(link)
                ends.append(found or self._nearest_node(link, connection.centre_on(link)))
            edge = _GraphEdge(ends[0], ends[1], connection=connection)
            self.edges.append(edge)
            self.misplaced.extend((edge, connection, link) for link in missing)

    def _nearest_node(self, link: str, point: Array) -> _Node:
        def distance(node: _Node) -> float:
            return float(np.linalg.norm(point - node.point)) if node.point is not None else 0.0

        return min(self.nodes[link], key=distance).find()

    # ---- components -------------------------------------------------------------------------------------------------

    def build(self) -> Topology:
        finder = SpanFinder(self.mechanism)
        self.base_links, self.platform_links = finder.base_links, finder.platform_links
        self.spans = finder.spans()
        self.warnings.extend(finder.warnings)
        self._make_nodes()
        self._make_edges()
        base, platform = self._merge(self.base_links), self._merge(self.platform_links)
        at: dict[_Node, list[_GraphEdge]] = {}
        direct: list[_GraphEdge] = []
        for edge in self.edges:
            inner, outer = edge.inner.find(), edge.outer.find()
            if inner is outer:
                continue
            if {inner, outer} == {base, platform}:
                if edge.connection is None or edge.connection.kind != "floating":  # which transmits nothing
                    direct.append(edge)
                continue
            at.setdefault(inner, []).append(edge)
            at.setdefault(outer, []).append(edge)
        limbs: list[tuple[int, Limb]] = []
        dead: dict[_Node, list[Edge]] = {base: [], platform: []}
        dead_nodes: dict[_Node, list[_Node]] = {base: [], platform: []}
        seen: set[_Node] = {base, platform}
        everyone = [node.find() for nodes in self.nodes.values() for node in nodes]
        for node in everyone:
            if node in seen:
                continue
            component, edges = self._component(node, at, {base, platform})
            seen.update(component)
            roots = [(edge, end) for edge in edges for end in (base, platform) if end in (edge.inner.find(), edge.outer.find())]
            to_base = [edge for edge, end in roots if end is base]
            to_platform = [edge for edge, end in roots if end is platform]
            names = self._link_names(component, edges)
            if len(edges) - len(roots) != len(component) - 1 or len(to_base) > 1 or len(to_platform) > 1:
                raise NotYetError(
                    f"the links {', '.join(names)} form a hybrid limb (a closed sub-chain, or several joints to base or "
                    "platform); only serial limbs can be analysed so far",
                    names,
                )
            if to_base and to_platform:
                limbs.append(self._limb(names, base, platform, to_base[0], at, component))
            else:
                root = base if to_base else platform
                self._grow(root, (to_base or to_platform)[0], at, dead[root])
                dead_nodes[root].extend(component)
        limbs.sort(key=lambda pair: pair[0])
        for edge in direct:
            names = self._link_names([], [edge])
            limbs.append((len(self.nodes), self._limb(names, base, platform, edge, at, [])[1]))
        self._check_misplaced([limb for _, limb in limbs], dead)
        numbered = tuple(
            Limb(f"limb_{k}", limb.links, limb.path, limb.branches, limb.weights, limb.weight_between)
            for k, (_, limb) in enumerate(limbs, 1)
        )
        return Topology(
            numbered,
            self._dead_weight(base, dead[base], dead_nodes[base]),
            self._dead_weight(platform, dead[platform], dead_nodes[platform]),
            self.spans,
            self.carried_by,
            tuple(self.warnings),
        )

    def _merge(self, links: set[str]) -> _Node:
        nodes = [self.nodes[link][0].find() for link in self.description.links if link in links]
        for node in nodes[1:]:
            if node is not nodes[0]:
                node.merged = nodes[0]
        return nodes[0]

    def _component(
        self, start: _Node, at: dict[_Node, list[_GraphEdge]], stops: set[_Node]
    ) -> tuple[list[_Node], list[_GraphEdge]]:
        nodes, edges, queue = [start], [], deque([start])
        while queue:
            node = queue.popleft()
            for edge in at.get(node, []):
                if edge not in edges:
                    edges.append(edge)
                other = edge.other(node)
                if other not in nodes and other not in stops:
                    nodes.append(other)
                    queue.append(other)
        return nodes, edges

    def _link_names(self, nodes: list[_Node], edges: list[_GraphEdge]) -> tuple[str, ...]:
        found = {link for link, own in self.nodes.items() if any(node.find() in nodes for node in own)}
        found.update(edge.beam.beam.link for edge in edges if edge.beam is not None)
        return tuple(link for link in self.description.links if link in found)

    def _weights_of(self, node: _Node) -> list[str]:
        return [name for own in self.nodes.values() for item in own if item.find() is node for name in item.weights]

    def _grow(
        self,
        inner: _Node,
        edge: _GraphEdge,
        at: dict[_Node, list[_GraphEdge]],
        out: list[Edge],
        stop: _Node | None = None,
        parent: str | None = None,
    ) -> list[str]:
        """Append the directed edges of the subtree beyond ``edge``, and return the names of its weights."""
        outer = edge.other(inner)
        below: list[str] = []
        position = len(out)
        key = ([name or f"beam:{beam}" for name, beam in self._names_of(inner, edge)])[-1]
        if outer is not stop:
            below.extend(self._weights_of(outer))
            for link, own in self.nodes.items():
                if any(node.point is None and node.find() is outer for node in own):
                    self.carried_by[link] = key
            for item in at.get(outer, []):
                if item is not edge:
                    below.extend(self._grow(outer, item, at, out, stop, key))
        out[position:position] = self._directed(inner, edge, below, parent)
        if edge.beam is not None:
            below.append(f"beam:{edge.beam.beam.name}")
        return below

    def _directed(self, inner: _Node, edge: _GraphEdge, below: list[str], parent: str | None) -> list[Edge]:
        """Return an edge, and the joints inside a telescopic beam, as seen on the way out from ``inner``."""
        forward = edge.inner.find() is inner
        if edge.connection is not None:
            return [Edge(edge.connection.name, None, 1 if forward else -1, tuple(below), parent)]
        assert edge.beam is not None
        name = edge.beam.beam.name
        if not forward:
            place = edge.beam.beam.place
            self.warnings.append(
                f"{place.file}:{place.line}: beam {name!r} runs from its end towards the platform to the one towards the base; "
                "from= should name the joint towards the base"
            )
        span = self._outward(inner, edge)
        self.spans[name] = span
        chain, before_carrier, start_link = [*span.inward[::-1], *span.outward], len(span.inward), span.start_link
        links = [start_link]
        for item in chain:
            links.append(item.other(links[-1]))
        # Links in mid-span go with the end on their side; a joint in between carries those outboard of it all the same.
        near = [link for link in links[1:before_carrier] if self._weighs(link)]
        far = [link for link in links[before_carrier + 1 : -1] if self._weighs(link)]
        result: list[Edge] = []
        for number in range(len(chain) + 1):
            if number == before_carrier:
                result.append(Edge(None, name, 1, tuple(below), parent))
                parent = result[-1].key
            if number < len(chain):
                item = chain[number]
                sign = 1 if item.predecessor == links[number] else -1
                inboard = set(links[: number + 1])
                weights = list(below)
                if number < before_carrier:
                    weights += [link for link in near if link not in inboard] + [f"beam:{name}"]
                excluded = tuple(link for link in far if link in inboard)
                result.append(Edge(item.name, None, sign, tuple(weights), parent, excluded))
                parent = result[-1].key
        return result

    def _weighs(self, link: str) -> bool:
        return link not in self.beams_of and self.description.links[link].mass > 0

    def _limb(
        self,
        names: tuple[str, ...],
        base: _Node,
        platform: _Node,
        first: _GraphEdge,
        at: dict[_Node, list[_GraphEdge]],
        component: list[_Node],
    ) -> tuple[int, Limb]:
        everything: list[Edge] = []
        weights = self._grow(base, first, at, everything, stop=platform)
        steps = self._path(base, platform, first, at)
        path: list[Edge] = []
        between: list[bool] = []
        by_name = {(edge.joint, edge.beam): edge for edge in everything}
        on_path: set[tuple[str | None, str | None]] = set()
        node = base
        for step in steps:
            directed = self._names_of(node, step)
            node = step.other(node)
            hanging = node is not platform and (
                bool(self._weights_of(node)) or any(item not in steps for item in at.get(node, []))
            )
            path.extend(by_name[key] for key in directed)
            between.extend([False] * (len(directed) - 1) + [hanging])
            on_path.update(directed)
        branches = tuple(edge for edge in everything if (edge.joint, edge.beam) not in on_path)
        order = list(self.description.links)
        rank = min((order.index(name) for name in names), default=len(order))
        return rank, Limb("", names, tuple(path), branches, tuple(weights), tuple(between))

    def _names_of(self, inner: _Node, edge: _GraphEdge) -> list[tuple[str | None, str | None]]:
        if edge.connection is not None:
            return [(edge.connection.name, None)]
        span = self._outward(inner, edge)
        before, after = span.inward[::-1], span.outward
        return [*((item.name, None) for item in before), (None, span.beam.name), *((item.name, None) for item in after)]

    def _outward(self, inner: _Node, edge: _GraphEdge) -> BeamSpan:
        """Return an edge's beam as it runs on the way out from ``inner``."""
        assert edge.beam is not None
        return edge.beam if edge.inner.find() is inner else edge.beam.reversed

    def _path(self, base: _Node, platform: _Node, first: _GraphEdge, at: dict[_Node, list[_GraphEdge]]) -> list[_GraphEdge]:
        start = first.other(base)
        before: dict[_Node, tuple[_Node, _GraphEdge]] = {start: (base, first)}
        queue = deque([start])
        while queue:
            node = queue.popleft()
            if node is platform:
                break
            for edge in at.get(node, []):
                other = edge.other(node)
                if other not in before and other is not base:
                    before[other] = (node, edge)
                    queue.append(other)
        steps: list[_GraphEdge] = []
        node = platform
        while node is not base:
            node, edge = before[node]
            steps.append(edge)
        return steps[::-1]

    def _check_misplaced(self, limbs: list[Limb], dead: dict[_Node, list[Edge]]) -> None:
        """Refuse what carries load somewhere along a beam instead of at its end."""
        on_path = {edge.joint for limb in limbs for edge in limb.path}
        loaded = {edge.joint: edge.outboard for limb in limbs for edge in limb.branches}
        loaded.update({edge.joint: edge.outboard for edges in dead.values() for edge in edges})
        for _, connection, link in self.misplaced:
            if connection.name in on_path or loaded.get(connection.name):
                beams = ", ".join(repr(beam.name) for beam in self.beams_of[link])
                place = connection.place
                raise RobotFileError(
                    f"joint {connection.name!r} carries load at a point of link {link!r} that is not an end of its beam "
                    f"({beams}); split the beam there with a fixed joint, or let it end there",
                    place.file,
                    place.line,
                )

    def _dead_weight(self, root: _Node, edges: list[Edge], nodes: list[_Node]) -> DeadWeight:
        weights = self._weights_of(root) + [name for node in nodes for name in self._weights_of(node)]
        weights += [f"beam:{edge.beam}" for edge in edges if edge.beam]
        links = tuple(link for link, own in self.nodes.items() if any(node.find() in (root, *nodes) for node in own))
        return DeadWeight(links, tuple(edges), tuple(weights))
