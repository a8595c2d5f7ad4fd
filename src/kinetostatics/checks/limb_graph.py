"""The chain of each limb, read from the graph of rigid bodies, see :mod:`checks.chains`.

Edges in series are merged to runs between branching bodies. The chain is divided at bodies that are on all paths from base to
platform; several runs between two such bodies are branches. Dead ends and rings are listed with the body to which they are
attached.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

from kinetostatics.checks.chains import Body, Branches, Chain, Graph, Hanging, Item, JointStep, Run, bodies_of
from kinetostatics.math.graphs import blocks, joined, reachable
from kinetostatics.mechanism.body_graph import BodyEdge, BodyGraph, RigidBody
from kinetostatics.mechanism.joints import CompoundJoint, compound_joints, drives_of, springs_of
from kinetostatics.mechanism.limbs import Edge, Limb, Topology
from kinetostatics.mechanism.mechanism import Connection, Mechanism


class GraphReader:
    """Reads the graph of a robot, limb by limb."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self.graph = BodyGraph(mechanism)

    def limb(self, limb: Limb) -> Graph:
        """Return the graph of a limb."""
        compounds = compound_joints(self.mechanism, limb)
        return _Reducer(self, [*limb.edges, *limb.branches], compounds).through(self.graph.base, self.graph.platform)

    def dead_weight(self, topology: Topology, role: str) -> Graph:
        """Return the bodies attached to the ``base`` or the ``platform`` alone."""
        edges = list((topology.base if role == "base" else topology.platform).edges)
        compounds: list[CompoundJoint] = []
        for limb in topology.hanging:
            if limb.name == role:
                known = {edge.key for edge in edges}
                edges += [edge for edge in (*limb.edges, *limb.branches) if edge.key not in known]
                compounds += compound_joints(self.mechanism, limb)
        return _Reducer(self, edges, compounds).alone(self.graph.base if role == "base" else self.graph.platform)

    def joint(self, compound: CompoundJoint | Connection) -> JointStep:
        """Return a joint as a step of a chain."""
        names = compound.joints if isinstance(compound, CompoundJoint) else (compound.name,)
        label = compound.label if isinstance(compound, CompoundJoint) else compound.name
        connections = [self.mechanism.connections[name] for name in names]
        mimic = connections[0].mimic
        elastic = any(springs_of(self.mechanism, name) or name in drives_of(self.mechanism) for name in names)
        driven = connections[0].driven and mimic is None
        return JointStep(label, names, compound.type.name, driven, elastic, None if mimic is None else mimic.joint)


@dataclass(eq=False)
class _Edge:
    """An edge of the graph during its reduction."""

    start: RigidBody
    end: RigidBody
    chain: Chain

    def leaving(self, node: RigidBody) -> _Edge:
        """Return the edge with the given node as its start."""
        return self if self.start is node else _Edge(self.end, self.start, _turned(self.chain))


def _turned(chain: Chain) -> Chain:
    """Return a chain in reverse order."""
    found: list[Item] = []
    for item in reversed(chain):
        found.append(Body(item.names[::-1]) if isinstance(item, Body) else item)
    return tuple(found)


def _joined(*chains: Chain) -> Chain:
    """Return concatenated chains, with consecutive bodies merged."""
    found: list[Item] = []
    for item in (item for chain in chains for item in chain):
        before = found[-1] if found else None
        if isinstance(item, Body) and not item.names:
            continue
        if isinstance(item, Body) and isinstance(before, Body):
            found[-1] = Body(tuple(dict.fromkeys((*before.names, *item.names))))
        else:
            found.append(item)
    return tuple(found)


class _Reducer:
    """Reduction of the edges of one limb, or of attached bodies, to a chain."""

    def __init__(self, reader: GraphReader, edges: list[Edge], compounds: Sequence[CompoundJoint]) -> None:
        self.reader, self.graph = reader, reader.graph
        self.hanging: list[Hanging] = []
        keys = {edge.key for edge in edges}
        mine = [edge for edge in self.graph.edges if edge.key in keys]
        self.ends = (self.graph.base, self.graph.platform)
        welds = joined(self.graph.bodies, (edge.ends for edge in mine if self._is_weld(edge)))
        #: for each body, the representative of all bodies welded to it
        self._node = {body: next(other for other in welds if other in welds[body]) for body in welds}
        self._names = self._name_nodes(mine)
        self.lines = self._make_lines(mine, compounds)
        self._beam_at: dict[RigidBody, str] = {}
        for line in self.lines:
            for node in (line.start, line.end):
                for beam in bodies_of(line.chain)[:1]:
                    self._beam_at.setdefault(node, beam)
        nodes = {node for line in self.lines for node in (line.start, line.end)}
        self.rings = len(self.lines) - len(nodes - set(self.ends)) - 1 if self.lines else 0

    # ---- the graph ---------------------------------------------------------------------------------------------------

    def _is_weld(self, edge: BodyEdge) -> bool:
        """Whether an edge is a rigid fixed joint inside a limb."""
        item = edge.connection
        if item is None or not item.type.is_fixed or springs_of(self.reader.mechanism, item.name):
            return False
        return not set(edge.ends) & set(self.ends)

    def _name_nodes(self, edges: list[BodyEdge]) -> dict[RigidBody, tuple[str, ...]]:
        """Return the rigid links of every node that have mass or a joint, in the order of the file."""
        description = self.reader.mechanism.description
        holding = {
            link
            for edge in edges
            if edge.connection is not None and not self._is_weld(edge)
            for link in (edge.connection.predecessor, edge.connection.successor)
        }
        members: dict[RigidBody, set[str]] = {}
        for body in {end for edge in edges for end in edge.ends}:
            links = {link for link in body.rigid_links if link in holding or description.links[link].mass > 0}
            members.setdefault(self._node[body], set()).update(links)
        named = {node: tuple(link for link in description.links if link in links) for node, links in members.items()}
        named[self.graph.base], named[self.graph.platform] = (description.base,), (description.platform,)
        return named

    def _make_lines(self, edges: list[BodyEdge], compounds: Sequence[CompoundJoint]) -> list[_Edge]:
        compound_of = {name: compound for compound in compounds for name in compound.joints}
        runs: dict[tuple[str, ...], list[BodyEdge]] = {}
        found: list[_Edge] = []
        for edge in edges:
            start, end = (self._node[body] for body in edge.ends)
            if edge.connection is not None:
                compound = compound_of.get(edge.connection.name)
                if compound is not None and len(compound.joints) > 1:
                    runs.setdefault(compound.joints, []).append(edge)
                elif not self._is_weld(edge):
                    found.append(_Edge(start, end, (self.reader.joint(compound or edge.connection),)))
            elif edge.beam is not None:
                found.append(_Edge(start, end, self._along_beam(edge)))
        for joints, parts in runs.items():
            ends = [self._node[body] for edge in parts for body in edge.ends]
            outer = [node for node in ends if ends.count(node) == 1]
            if len(outer) == 2:  # otherwise both ends are on one piece: inside the base, or a ring
                found.append(_Edge(outer[0], outer[1], (self.reader.joint(compound_of[joints[0]]),)))
        return found

    def _along_beam(self, edge: BodyEdge) -> Chain:
        """Return a beam as a body; a telescopic beam as its links and the joints between them."""
        span = edge.beam
        assert span is not None
        here = span.start_link
        name = span.beam.name if here == span.beam.link else here
        items: list[Item] = [Body((name,))]
        for connection in (*span.inward[::-1], *span.outward):
            here = connection.other(here)
            if not connection.type.is_fixed:
                items.append(self.reader.joint(connection))
            items.append(Body((span.beam.name if here == span.beam.link else here,)))
        return _joined(tuple(items))

    def name(self, node: RigidBody) -> str:
        """Return the name of a node."""
        names = self._names.get(node, ())
        return " + ".join(names) if names else f"the end of {self._beam_at[node]}" if node in self._beam_at else "a point"

    # ---- the reduction -----------------------------------------------------------------------------------------------

    def through(self, start: RigidBody, end: RigidBody) -> Graph:
        """Return the chain from one body to another."""
        self._reduce({start, end})
        chain: Chain = ()
        for here, node, lines in blocks(self.lines, lambda line: (line.start, line.end), start, end):
            lines = self._without_rings(here, node, lines)
            part = lines[0].leaving(here).chain if len(lines) == 1 else (self._branches(here, node, lines),)
            chain = _joined(chain, part, () if node is end else (Body(self._names.get(node, ())),))
        return Graph(chain, tuple(self.hanging), self.rings)

    def alone(self, root: RigidBody) -> Graph:
        """Return the open branches of a body."""
        self._reduce({root})
        if self.lines:
            self.hanging.append(Hanging(self.name(root), (self._branches(root, root, self.lines),), True))
        return Graph((), tuple(self.hanging), self.rings)

    def _reduce(self, terminals: set[RigidBody]) -> None:
        """Merge edges in series, and remove rings and dead ends."""
        while True:
            at: dict[RigidBody, list[_Edge]] = {}
            for line in self.lines:
                at.setdefault(line.start, []).append(line)
                at.setdefault(line.end, []).append(line)
            ring = next((line for line in self.lines if line.start is line.end), None)
            node = next((node for node, lines in at.items() if len(lines) < 3 and node not in terminals), None)
            if ring is not None:
                self.lines.remove(ring)
                self.hanging.append(Hanging(self.name(ring.start), ring.chain, True))
            elif node is None:
                return
            else:
                first, *others = (line.leaving(node) for line in at[node])
                inwards = _joined(_turned(first.chain), (Body(self._names.get(node, ())),))
                position = self.lines.index(at[node][0])
                self.lines = [line for line in self.lines if line not in at[node]]
                if others:
                    merged = _Edge(first.end, others[0].end, _joined(inwards, others[0].chain))
                    self.lines.insert(min(position, len(self.lines)), merged)
                else:
                    self.hanging.append(Hanging(self.name(first.end), inwards, False))

    def _without_rings(self, start: RigidBody, end: RigidBody, lines: list[_Edge]) -> list[_Edge]:
        """Remove groups of connected runs that are attached to only one of two bodies."""
        inner = [{line.start, line.end} - {start, end} for line in lines]
        pairs = ((k, h) for k, h in combinations(range(len(lines)), 2) if inner[k] & inner[h])
        left = list(lines)
        for group in dict.fromkeys(joined(range(len(lines)), pairs).values()):
            mine = [lines[k] for k in sorted(group)]
            roots = {node for line in mine for node in (line.start, line.end)} & {start, end}
            if len(roots) == 1 and len(mine) < len(lines):
                (root,) = roots
                left = [line for line in left if line not in mine]
                self.hanging.append(Hanging(self.name(root), (self._branches(root, root, mine),), True))
        return left

    def _branches(self, start: RigidBody, end: RigidBody, lines: list[_Edge]) -> Branches:
        """Return runs directed outwards from ``start``, the nearest first."""

        def others(node: RigidBody) -> Iterator[RigidBody]:
            return (line.leaving(node).end for line in lines if node in (line.start, line.end))

        near = {node: k for k, node in enumerate(reachable([start], others))}
        found = []
        for line in lines:
            outwards = near.get(line.start, 0) <= near.get(line.end, 0) and line.start is not end
            found.append(line if outwards else line.leaving(line.end))
        found.sort(key=lambda line: near.get(line.start, 0))
        runs = tuple(Run(self.name(line.start), self.name(line.end), line.chain) for line in found)
        parallel = all({line.start, line.end} == {start, end} for line in lines)
        return Branches(self.name(start), self.name(end), runs, parallel)
