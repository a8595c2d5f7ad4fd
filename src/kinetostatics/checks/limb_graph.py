"""Which joint joins which bodies, read from the graph of rigid pieces: one chain for each limb, see :mod:`checks.chains`.

Series and parallel stretches of the graph are merged until one chain is left (R. J. Duffin, *Topology of series-parallel
networks*, J. Math. Anal. Appl. 10, 1965); what cannot be merged, as a brace across a frame, stays a network. What leads nowhere
hangs on the chain.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from kinetostatics.checks.chains import Body, Chain, Graph, Hanging, Item, JointStep, Network, Stretch, Ways, bodies_of
from kinetostatics.math.graphs import blocks, joined
from kinetostatics.mechanism.elastic_joints import drives_of, springs_of
from kinetostatics.mechanism.limb_joints import CompoundJoint, compound_joints
from kinetostatics.mechanism.limbs import Edge, Limb, Topology
from kinetostatics.mechanism.mechanism import Connection, Mechanism
from kinetostatics.mechanism.rigid_bodies import BodyEdge, BodyGraph, RigidBody


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
        """Return what hangs on the ``base`` or the ``platform`` alone."""
        edges = list((topology.base if role == "base" else topology.platform).edges)
        compounds: list[CompoundJoint] = []
        for limb in topology.hanging:
            if limb.name == role:
                known = {edge.key for edge in edges}
                edges += [edge for edge in (*limb.edges, *limb.branches) if edge.key not in known]
                compounds += compound_joints(self.mechanism, limb)
        return _Reducer(self, edges, compounds).alone(self.graph.base if role == "base" else self.graph.platform)

    def joint(self, compound: CompoundJoint | Connection) -> JointStep:
        """Return a joint as it stands in a chain."""
        names = compound.joints if isinstance(compound, CompoundJoint) else (compound.name,)
        label = compound.label if isinstance(compound, CompoundJoint) else compound.name
        connections = [self.mechanism.connections[name] for name in names]
        mimic = connections[0].mimic
        elastic = any(springs_of(self.mechanism, name) or name in drives_of(self.mechanism) for name in names)
        driven = connections[0].driven and mimic is None
        return JointStep(label, names, compound.kind, driven, elastic, None if mimic is None else mimic.joint)


@dataclass(eq=False)
class _Line:
    """An edge of the graph while it is reduced."""

    start: RigidBody
    end: RigidBody
    chain: Chain

    def leaving(self, node: RigidBody) -> _Line:
        """Return the same edge as it leads away from a node."""
        return self if self.start is node else _Line(self.end, self.start, _turned(self.chain))


def _turned(chain: Chain) -> Chain:
    """Return a chain from its other end."""
    found: list[Item] = []
    for item in reversed(chain):
        if isinstance(item, Body):
            found.append(Body(item.names[::-1]))
        elif isinstance(item, Ways):
            found.append(Ways(item.end, item.start, tuple(_turned(way) for way in item.ways)))
        elif isinstance(item, Network):
            found.append(Network(item.end, item.start, item.stretches))
        else:
            found.append(item)
    return tuple(found)


def _joined(*chains: Chain) -> Chain:
    """Return chains end to end, with bodies that follow one another in one."""
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
    """Merges the edges of one limb, or of a dead weight, to a chain."""

    def __init__(self, reader: GraphReader, edges: list[Edge], compounds: Sequence[CompoundJoint]) -> None:
        self.reader, self.graph = reader, reader.graph
        self.hanging: list[Hanging] = []
        keys = {edge.key for edge in edges}
        mine = [edge for edge in self.graph.edges if edge.key in keys]
        self.ends = (self.graph.base, self.graph.platform)
        welds = joined(self.graph.bodies, (edge.ends for edge in mine if self._is_weld(edge)))
        #: the piece that stands for all that are welded to each
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
        """Return the rigid links of every node that weigh something or hold a joint, in the order of the file."""
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

    def _make_lines(self, edges: list[BodyEdge], compounds: Sequence[CompoundJoint]) -> list[_Line]:
        compound_of = {name: compound for compound in compounds for name in compound.joints}
        runs: dict[tuple[str, ...], list[BodyEdge]] = {}
        found: list[_Line] = []
        for edge in edges:
            start, end = (self._node[body] for body in edge.ends)
            if edge.connection is not None:
                compound = compound_of.get(edge.connection.name)
                if compound is not None and len(compound.joints) > 1:
                    runs.setdefault(compound.joints, []).append(edge)
                elif not self._is_weld(edge):
                    found.append(_Line(start, end, (self.reader.joint(compound or edge.connection),)))
            elif edge.beam is not None:
                found.append(_Line(start, end, self._along_beam(edge)))
        for joints, parts in runs.items():
            ends = [self._node[body] for edge in parts for body in edge.ends]
            outer = [node for node in ends if ends.count(node) == 1]
            if len(outer) == 2:  # else a run whose ends are one piece: it lies within the base or a ring of its own
                found.append(_Line(outer[0], outer[1], (self.reader.joint(compound_of[joints[0]]),)))
        return found

    def _along_beam(self, edge: BodyEdge) -> Chain:
        """Return a beam as a body; a telescope as its links and the joints between them."""
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
        """Return what a node is called."""
        names = self._names.get(node, ())
        return " + ".join(names) if names else f"the end of {self._beam_at[node]}" if node in self._beam_at else "a point"

    # ---- the reduction -----------------------------------------------------------------------------------------------

    def through(self, start: RigidBody, end: RigidBody) -> Graph:
        """Return the chain from one piece to another."""
        self._reduce({start, end})
        chain: Chain = ()
        for here, node, lines in blocks(self.lines, lambda line: (line.start, line.end), start, end):
            if len(lines) == 1:
                chain = _joined(chain, lines[0].leaving(here).chain)
            else:
                chain = _joined(chain, (self._network(here, node, lines),))
            if node is not end:
                chain = _joined(chain, (Body(self._names.get(node, ())),))
        return Graph(chain, tuple(self.hanging), self.rings)

    def alone(self, root: RigidBody) -> Graph:
        """Return what hangs on a piece."""
        self._reduce({root})
        if self.lines:
            self.hanging.append(Hanging(self.name(root), (self._network(root, root, self.lines),), True))
        return Graph((), tuple(self.hanging), self.rings)

    def _reduce(self, terminals: set[RigidBody]) -> None:
        while self._in_line(terminals) or self._side_by_side() or self._dead_ends(terminals):
            pass

    def _at(self) -> dict[RigidBody, list[_Line]]:
        found: dict[RigidBody, list[_Line]] = {}
        for line in self.lines:
            found.setdefault(line.start, []).append(line)
            found.setdefault(line.end, []).append(line)
        return found

    def _in_line(self, terminals: set[RigidBody]) -> bool:
        """Merge two edges that follow one another, or take a ring off the node on which it hangs."""
        for line in self.lines:
            if line.start is line.end:
                self.lines.remove(line)
                self.hanging.append(Hanging(self.name(line.start), line.chain, True))
                return True
        for node, lines in self._at().items():
            if len(lines) == 2 and node not in terminals:
                first, second = lines[0].leaving(node), lines[1].leaving(node)
                merged = _joined(_turned(first.chain), (Body(self._names.get(node, ())),), second.chain)
                self._replace(lines, _Line(first.end, second.end, merged))
                return True
        return False

    def _side_by_side(self) -> bool:
        """Merge all edges between the same two nodes."""
        between: dict[frozenset[RigidBody], list[_Line]] = {}
        for line in self.lines:
            between.setdefault(frozenset((line.start, line.end)), []).append(line)
        several = [same for same in between.values() if len(same) > 1]
        for same in several:
            start, end = same[0].start, same[0].end
            ways: list[Chain] = []
            for line in same:
                chain = line.leaving(start).chain
                ways += chain[0].ways if len(chain) == 1 and isinstance(chain[0], Ways) else [chain]
            self._replace(same, _Line(start, end, (Ways(self.name(start), self.name(end), tuple(ways)),)))
        return bool(several)

    def _dead_ends(self, terminals: set[RigidBody]) -> bool:
        """Take an edge off that leads nowhere."""
        for node, lines in self._at().items():
            if len(lines) == 1 and node not in terminals:
                chain = _turned(lines[0].leaving(node).chain)
                self.lines.remove(lines[0])
                root = lines[0].leaving(node).end
                self.hanging.append(Hanging(self.name(root), _joined(chain, (Body(self._names.get(node, ())),)), False))
                return True
        return False

    def _replace(self, old: list[_Line], new: _Line) -> None:
        position = self.lines.index(old[0])
        self.lines = [line for line in self.lines if line not in old]
        self.lines.insert(min(position, len(self.lines)), new)

    # ---- what cannot be merged ---------------------------------------------------------------------------------------

    def _network(self, start: RigidBody, end: RigidBody, lines: list[_Line]) -> Network:
        """Return a network, its stretches directed outwards from ``start``."""
        distance, queue = {start: 0}, [start]
        for node in queue:
            for line in lines:
                if node in (line.start, line.end):
                    other = line.leaving(node).end
                    if other not in distance:
                        distance[other] = distance[node] + 1
                        queue.append(other)
        found = []
        for line in lines:
            outwards = distance.get(line.start, 0) <= distance.get(line.end, 0) and line.start is not end
            way = line if outwards else line.leaving(line.end)
            found.append((distance.get(way.start, 0), Stretch(self.name(way.start), self.name(way.end), way.chain)))
        found.sort(key=lambda item: item[0])
        return Network(self.name(start), self.name(end), tuple(stretch for _, stretch in found))
