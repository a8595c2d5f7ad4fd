"""Limbs, attached bodies and open branches of a mechanism, found in its graph of rigid bodies.

Terms are defined in :mod:`kinetostatics.mechanism.limbs`; a *step* is a directed edge of a limb.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from kinetostatics.math.graphs import blocks, joined, reachable
from kinetostatics.mechanism.beam_geometry import beam_error
from kinetostatics.mechanism.body_graph import (
    BodyEdge,
    BodyGraph,
    DirectedEdge,
    RigidBody,
    directed_edges,
    edges_beside,
    stars_of,
)
from kinetostatics.mechanism.cut_joints import cut_joints_carried, edges_towards_cut_joints
from kinetostatics.mechanism.joints import elastic_actuators
from kinetostatics.mechanism.limbs import AttachedBodies, Edge, Limb, LimbSegment, Topology
from kinetostatics.mechanism.mechanism import Mechanism

#: Distance from the end of a beam, relative to its length, within which a point counts as the end.
AT_END = 1e-4


def analyze_topology(mechanism: Mechanism) -> Topology:
    """Return the limbs, beams and attached bodies.

    Raises:
        RobotFileError: the start or end of a beam, or a joint along it, is invalid.
    """
    return _TopologyBuilder(mechanism).build()


class _TopologyBuilder:
    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism, self.graph = mechanism, BodyGraph(mechanism, rigid_plates=True)
        #: by the body of an interface of an elastic base or platform, the key of the edge to it
        self.port_keys = {edge.ports[1]: edge.key for edges in self.graph.plates.values() for edge in edges if edge.ports}
        self.spans = dict(self.graph.spans)
        self.warnings: list[str] = []
        self.carried_by: dict[str, str] = {}
        self.span_ends = {name: span.attachments for name, span in self.spans.items()}

    def build(self) -> Topology:
        graph = self.graph
        base, platform = graph.base, graph.platform
        neighbours: dict[RigidBody, list[RigidBody]] = {body: [] for body in graph.bodies}
        for edge in graph.edges:
            for end in edge.ends:
                neighbours[end].append(edge.other(end))
        limbs: list[tuple[list[RigidBody], list[BodyEdge]]] = []
        hanging: list[Limb] = []
        attached: dict[RigidBody, list[tuple[list[RigidBody], Limb]]] = {base: [], platform: []}
        seen: set[RigidBody] = {base, platform}
        order = {link: number for number, link in enumerate(graph.description.links)}
        for body in graph.bodies:
            if body in seen:
                continue
            together = reachable([body], lambda body: [other for other in neighbours[body] if other not in (base, platform)])
            component = [body for body in graph.bodies if body in together]
            edges = [edge for edge in graph.edges if any(end in together for end in edge.ends)]
            seen.update(component)
            touched = {end for edge in edges for end in edge.ends}
            if base in touched and platform in touched:
                limbs.append((component, edges))
                continue
            limb = self._limb(component, edges)
            root = platform if limb.on_platform else base
            attached[root].append((component, limb))
            if limb.to_platform:
                self._check_one_port(limb)
                hanging.append(replace(limb, name="platform" if limb.on_platform else "base"))
        for edge in graph.edges:
            joint = edge.connection
            is_unconstrained = joint and joint.type.is_free and joint.name not in graph.description.joint_stiffness
            if set(edge.ends) == {base, platform} and not is_unconstrained:
                limbs.append(([], [edge]))
        made = [self._limb(bodies, edges) for bodies, edges in self._coupled_limbs(limbs)]
        made.sort(key=lambda limb: min((order[link] for link in limb.links), default=len(order)))
        numbered = tuple(replace(limb, name=f"limb_{k}") for k, limb in enumerate(made, 1))
        self._check_actuators((*numbered, *hanging))
        self._check_springs()
        on_limbs = {attachment for limb in numbered for attachment in limb.attachments}
        on_base, on_platform = (self._attached(root, attached[root], on_limbs, numbered) for root in (base, platform))
        unsupported = self._check_misplaced((*numbered, *hanging), (*on_base.edges, *on_platform.edges))
        return Topology(
            limbs=numbered,
            hanging=tuple(hanging),
            base=on_base,
            platform=on_platform,
            spans=self.spans,
            carried_by=self.carried_by,
            warnings=tuple(self.warnings),
            span_ends=self.span_ends,
            without_support=unsupported,
        )

    def _check_springs(self) -> None:
        """Raise an error for springs at the end of a telescopic beam that does not move with the beam's link."""
        for spring in self.mechanism.description.springs.values():
            for link, point in ((spring.predecessor, spring.predecessor_point), (spring.successor, spring.successor_point)):
                body, placement = self.mechanism.body_of[link]
                at = placement[:3, :3] @ point + placement[:3, 3]
                spans = [span for span in self.spans.values() if span.part.link == link]
                ends = [end for span in spans for end in ((span.start_body, span.start), (span.end_body, span.end))]
                reach = AT_END * max((float(np.linalg.norm(local)) for _, local in ends), default=0.0)
                other = sorted(
                    {name for s in spans if s.start_body != s.end_body for name in (s.start_link, s.end_link)} - {link}
                )
                end_points = [local for number, local in ends if number == body]
                if other and not any(np.linalg.norm(local - at) <= reach for local in end_points):
                    points = [np.round(placement[:3, :3].T @ (local - placement[:3, 3]), 9) + 0.0 for local in end_points]
                    right, links = " or ".join(str(tuple(point.tolist())) for point in points), " or ".join(map(repr, other))
                    raise spring.place.error(
                        f"the spring {spring.name!r} ends on {link!r} where no end of its beam moves with it: put it at {right} "
                        f"of its frame, or on {links}"
                    )

    def _coupled_limbs(
        self, limbs: list[tuple[list[RigidBody], list[BodyEdge]]]
    ) -> Iterator[tuple[list[RigidBody], list[BodyEdge]]]:
        """Yield the bodies and edges of each limb; limbs coupled by an elastic actuator with mimic joints become one limb."""
        owner = {joint: k for k, (_, edges) in enumerate(limbs) for edge in edges for joint in _joints_of(edge)}
        actuators = elastic_actuators(self.mechanism).values()
        rows = [[owner[name] for name, _ in actuator.moves if name in owner] for actuator in actuators]
        together = joined(range(len(limbs)), (pair for row in rows for pair in itertools.pairwise(row)))
        for members in dict.fromkeys(together.values()):
            coupled = [limbs[k] for k in sorted(members)]
            yield [body for bodies, _ in coupled for body in bodies], [edge for _, edges in coupled for edge in edges]

    # ---- limbs ------------------------------------------------------------------------------------------------------

    def _limb(self, bodies: list[RigidBody], edges: list[BodyEdge]) -> Limb:
        graph = self.graph
        steps = directed_edges(edges, graph.base, graph.platform)
        on_platform = bool(bodies) and all(graph.base not in edge.ends for edge in edges)
        reached_by = {step.outer: step for step in steps if step.in_tree}
        outboard = self._weights_outboard(steps)
        carries = cut_joints_carried(steps, reached_by)
        cut_joints = [step for step in steps if not step.in_tree]
        leading = edges_towards_cut_joints(steps, reached_by, carries)
        beside = edges_beside(edges, leading)
        degree: dict[RigidBody, int] = {}
        for edge in edges:
            for end in edge.ends:
                degree[end] = degree.get(end, 0) + 1
        limb_edges: list[Edge] = []
        branches: list[Edge] = []
        ends: list[bool] = []
        last_key: dict[RigidBody, str] = {}
        keys: dict[BodyEdge, tuple[str, ...]] = {}
        for step in steps:
            passes = step.in_tree and degree[step.outer] == 2 and not step.outer.weights
            parent = last_key.get(step.inner) or self._port_key(step.edge, step.inner)
            chain = self._directed(step, outboard.get(step.edge, []), parent, tuple(carries[step.edge].items()))
            keys[step.edge] = tuple(edge.key for edge in chain)
            if step.in_tree:
                last_key[step.outer] = chain[-1].key
                for attachment in dict.fromkeys((*step.outer.rigid_links, *step.outer.attachments)):
                    self.carried_by[attachment] = chain[-1].key
            self._carry_ends(step, chain)
            if step.edge in leading:
                limb_edges.extend(chain)
                ends.extend([False] * (len(chain) - 1) + [not passes])
            elif step.edge in beside:  # before the edges beyond it, so that those towards the platform remain last
                first = next((k for k, edge in enumerate(limb_edges) if edge.key in beside[step.edge]), len(limb_edges))
                limb_edges[first:first], ends[first:first] = chain, [not passes]
            else:
                branches.extend(chain)
        weights = [name for body in bodies for name in body.weights]
        weights += [edge.key for edge in edges if edge.span is not None and edge.span.name == edge.span.part.name]
        attachments = [name for body in bodies for name in body.attachments]
        attachments += [end for step in steps for ends in self._ends_in_span(step) for end in ends]
        return Limb(
            "",
            graph.links_of(bodies, edges),
            tuple(limb_edges),
            tuple(branches),
            tuple(weights),
            tuple(ends),
            tuple(step.outer is graph.platform and not on_platform for step in cut_joints),
            on_platform,
            self._parts([step for step in steps if step.edge in leading], keys),
            tuple(attachments),
            tuple(self._port_key(step.edge, step.outer) for step in cut_joints),
        )

    def _port_key(self, edge: BodyEdge, end: RigidBody) -> str | None:
        """Return the key of the edge of an elastic base or platform at which the ``end`` of an edge is."""
        return None if edge.ports is None else self.port_keys.get(edge.ports[edge.ends.index(end)])

    def _check_one_port(self, limb: Limb) -> None:
        parents = {edge.parent for edge in (*limb.edges, *limb.branches)} - {edge.key for edge in (*limb.edges, *limb.branches)}
        if len(parents) > 1:
            links = ", ".join(map(repr, limb.links))
            [plate] = [edges[0] for edges in self.graph.plates.values() if {edge.key for edge in edges} & parents]
            assert plate.span is not None
            raise beam_error(plate.span.part, f"the closed chain of {links} stiffens it; include these links in its matrices")

    def _ends_in_span(self, step: DirectedEdge) -> tuple[list[str], list[str]]:
        """Return the attachments at a beam's inner end and at its outer end, each a list of one name or none.

        An attachment is listed only if joints in the beam's span connect that end to base or platform.
        """
        if step.edge.span is None:
            return [], []
        roots = self.graph.base, self.graph.platform
        span = step.edge.span if step.edge.ends[0] is step.inner else step.edge.span.reversed
        sides = zip((step.inner, step.outer), (span.inward, span.outward), span.attachments, strict=True)
        inner, outer = ([attachment] if joints and body in roots else [] for body, joints, attachment in sides)
        return inner, outer

    def _carry_ends(self, step: DirectedEdge, chain: list[Edge]) -> None:
        """Let the beam, not the joints within its span, carry the attachments at its ends."""
        if step.edge.span is None:
            return
        name = step.edge.span.name
        number, (start, end) = [edge.span for edge in chain].index(name), self.span_ends[name]
        if number > 0:
            self.carried_by[start] = chain[number - 1].key
        if number < len(chain) - 1:
            self.carried_by[end] = chain[number].key

    def _parts(self, steps: list[DirectedEdge], keys: dict[BodyEdge, tuple[str, ...]]) -> tuple[LimbSegment, ...]:
        """Divide a limb at the bodies that all paths from base to platform pass; join consecutive serial parts."""
        graph = self.graph
        if stars_of(step.edge for step in steps):  # paths meet within an elastic link
            every = tuple(key for step in steps for key in keys[step.edge])
            return (LimbSegment(every, graph.description.base, graph.description.platform, False),)
        groups: list[tuple[list[DirectedEdge], RigidBody, RigidBody]] = []
        for inner, outer, block in blocks(steps, lambda step: (step.inner, step.outer), graph.base, graph.platform):
            if groups and len(block) == 1 and len(groups[-1][0]) == self._chain_length(groups[-1][0]):
                groups[-1] = (groups[-1][0] + block, groups[-1][1], outer)
            else:
                groups.append((block, inner, outer))
        return tuple(
            LimbSegment(
                tuple(key for step in block for key in keys[step.edge]),
                self._name_of(start),
                self._name_of(end),
                len(block) == self._chain_length(block),
            )
            for block, start, end in groups
        )

    @staticmethod
    def _chain_length(steps: list[DirectedEdge]) -> int:
        """Return the number of bodies at the outer ends of edges, or 0 if two edges begin at one body.

        The number of bodies equals the number of edges if, and only if, the edges are a single chain.
        """
        return len({step.outer for step in steps}) if len({step.inner for step in steps}) == len(steps) else 0

    def _name_of(self, body: RigidBody) -> str:
        if body is self.graph.base:
            return self.graph.description.base
        if body is self.graph.platform:
            return self.graph.description.platform
        return self.graph.links_of([body], [])[0]

    def _weights_outboard(self, steps: list[DirectedEdge]) -> dict[BodyEdge, list[str]]:
        """Return, for each edge, the names of weights and attachments outboard of it."""
        hanging: dict[RigidBody, list[str]] = {}
        outboard: dict[BodyEdge, list[str]] = {}
        for step in reversed(steps):  # outer edges come after inner ones
            _, names = self._ends_in_span(step)
            if step.in_tree:
                names = step.outer.attachments + hanging.get(step.outer, [])
            outboard[step.edge] = names
            beam = step.edge.span
            beam_weight = [step.edge.key] if beam is not None and beam.name == beam.part.name else []
            hanging[step.inner] = names + beam_weight + hanging.get(step.inner, [])
        return outboard

    def _directed(
        self, step: DirectedEdge, outboard: list[str], parent: str | None, cut_joints: tuple[tuple[int, int], ...]
    ) -> list[Edge]:
        """Return a joint, or a beam and the joints within its span, directed outwards."""
        edge = step.edge
        forward = edge.ends[0] is step.inner
        if edge.connection is not None:
            sign = 1 if forward else -1
            return [Edge(edge.connection.name, None, sign, tuple(outboard), parent, (), cut_joints, step.both_ways)]
        assert edge.span is not None
        name = edge.span.name
        if not forward and not step.both_ways and edge.span.part.KIND == "beam" and (edge.span.part.start or edge.span.part.end):
            place = edge.span.part.place
            self.warnings.append(
                f"{place}: beam {name!r} runs from its end towards the platform to the one towards the base; "
                "from= should name the joint towards the base"
            )
        span = edge.span if forward else edge.span.reversed
        self.spans[name], self.span_ends[name] = span, span.attachments
        joints, before_carrier = [*span.inward[::-1], *span.outward], len(span.inward)
        links = [span.start_link]
        for joint in joints:
            links.append(joint.other(links[-1]))
        # Links within the span move with the beam's end on their side; a joint carries those links that are outboard of it.
        # The same applies to loads at the ends of the beam.
        start, end = self.span_ends[name]
        near = [link for link in links[1:before_carrier] if self.graph.is_rigid(link)]
        far = [link for link in links[before_carrier + 1 : -1] if self.graph.is_rigid(link)]
        result: list[Edge] = []
        for number in range(len(joints) + 1):
            if number == before_carrier:
                result.append(Edge(None, name, 1 if forward else -1, tuple(outboard), parent, (), cut_joints, step.both_ways))
                parent = result[-1].key
            if number < len(joints):
                joint = joints[number]
                sign = 1 if joint.predecessor == links[number] else -1
                inboard = set(links[: number + 1])
                weights = list(outboard)
                if number < before_carrier:
                    weights += [link for link in near if link not in inboard] + [f"beam:{name}", start]
                excluded = tuple(link for link in far if link in inboard) + ((end,) if number >= before_carrier else ())
                result.append(Edge(joint.name, None, sign, tuple(weights), parent, excluded, cut_joints, step.both_ways))
                parent = result[-1].key
        return result

    # ---- checks and attached bodies ---------------------------------------------------------------------------------

    def _check_misplaced(self, limbs: tuple[Limb, ...], attached: tuple[Edge, ...]) -> dict[str, str]:
        """Return :attr:`.Topology.without_support`.

        Raises:
            RobotFileError: a joint between the ends of a beam carries a cut-joint wrench or a weight.
        """
        carrying = {edge.joint for limb in limbs for edge in limb.edges}
        branches = [edge for limb in limbs for edge in limb.branches]
        outboard = {edge.joint: edge.outboard for edge in (*branches, *attached)}
        unsupported: dict[str, str] = {}
        for connection, link in self.graph.misplaced:
            attachments = outboard.get(connection.name, ())
            unsupported |= dict.fromkeys(attachments, connection.name)
            if connection.name in carrying or any(map(self._is_weight, attachments)):
                beams = ", ".join(repr(beam.name) for beam in self.graph.beams_of[link])
                raise connection.place.error(
                    f"joint {connection.name!r} carries load at a point of link {link!r} that is not an end of its beam "
                    f"({beams}); split the beam there with a fixed joint, or let it end there"
                )
        return unsupported

    def _check_actuators(self, limbs: tuple[Limb, ...]) -> None:
        """Raise an error if an elastic actuator couples a closed chain attached to base or platform with other joints."""
        for actuator in elastic_actuators(self.mechanism).values():
            joints = {name for name, _ in actuator.moves}
            if sum(any(edge.joint in joints for edge in limb.edges) for limb in limbs) > 1:
                raise self.mechanism.connections[actuator.joint].place.error(
                    f"the elastic actuator of {actuator.joint!r} moves joints of a closed chain attached to base or platform, "
                    "and others elsewhere; make it rigid"
                )

    def _is_weight(self, name: str) -> bool:
        """Whether the name is that of a weight, not of a massless attachment."""
        return name.startswith("beam:") or (name in self.graph.description.links and self.graph.weighs(name))

    def _attached(
        self, root: RigidBody, components: list[tuple[list[RigidBody], Limb]], on_limbs: set[str], limbs: Sequence[Limb]
    ) -> AttachedBodies:
        """Return the bodies attached to base or platform; attachments ``on_limbs`` are left out."""
        bodies = [root, *(body for component, _ in components for body in component)]
        weights = [*root.weights, *(name for _, limb in components for name in limb.weights)]
        edges = [edge for _, limb in components if not limb.to_platform for edge in limb.branches]
        attachments = [name for body in bodies for name in body.attachments if name not in on_limbs]
        plate = tuple(self._plate_edges(root, limbs, [limb for _, limb in components]))
        edges = [*plate, *edges]
        at = self.span_ends[str(plate[0].span)][0] if plate else self._name_of(root)
        return AttachedBodies(self.graph.links_of(bodies, []), tuple(edges), tuple(weights), tuple(attachments), at, plate)

    def _plate_edges(self, root: RigidBody, limbs: Sequence[Limb], attached: Sequence[Limb]) -> Iterator[Edge]:
        """Yield the edges of an elastic base or platform, which carry what is attached to their ends."""
        for body_edge in self.graph.plates.get(self._name_of(root), ()):
            assert body_edge.span is not None
            key, end = body_edge.key, body_edge.span.attachments[1]
            self.carried_by[end] = key
            outboard, cuts = [end], []
            for number, limb in [*enumerate(limbs), *((-1, limb) for limb in attached)]:
                for edge in (*limb.edges, *limb.branches):
                    if edge.parent == key:
                        own = [] if edge.span is None else [edge.key, self.span_ends[edge.span][0]]
                        outboard += [*own, *edge.outboard]
                        cuts += [(number, cut, sign) for cut, sign in edge.cut_joints if number >= 0]
                cuts += [(number, cut, -1) for cut, port in enumerate(limb.ports) if port == key and number >= 0]
            yield Edge(None, body_edge.span.name, 1, tuple(dict.fromkeys(outboard)), None, limb_cuts=tuple(cuts))


def _joints_of(edge: BodyEdge) -> list[str]:
    """Return the name of the edge's joint, or of the joints inside the span of a beam."""
    inside = () if edge.span is None else (*edge.span.inward, *edge.span.outward)
    return [connection.name for connection in (edge.connection, *inside) if connection is not None]
