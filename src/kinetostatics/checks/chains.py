"""Chains of bodies and joints of a limb from base to platform, with parallel branches, their text, and their search in the graph.

Edges in series are merged to runs between branching bodies. The chain is divided at bodies that are on all paths from base to
platform; several runs between two such bodies are branches. Dead ends and rings are listed with the body to which they are
attached.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import TypeAlias

from kinetostatics.description.joint_types import JOINT_TYPES
from kinetostatics.layout.renderings import WIDTH
from kinetostatics.math.graphs import blocks, joined, reachable
from kinetostatics.mechanism.body_graph import BodyEdge, BodyGraph, RigidBody
from kinetostatics.mechanism.joints import CompoundJoint, compound_joints, drives_of, springs_of
from kinetostatics.mechanism.limbs import Edge, Limb, Topology
from kinetostatics.mechanism.mechanism import Connection, Mechanism


@dataclass(frozen=True)
class Body:
    """Links and beams that form one body between two joints, by name, in the direction from base to platform."""

    names: tuple[str, ...]


@dataclass(frozen=True)
class JointStep:
    """A joint between two bodies; revolutes with a common point form one universal or spherical joint.

    Attributes:
        name: name of the joint; for several revolutes, the common part of their names.
        joints: the joints' names.
        kind: URDF or loop type.
        driven, elastic: whether it is driven, and whether it or its actuator is elastic.
        follows: name of the joint that it mimics, or None.
    """

    name: str
    joints: tuple[str, ...]
    kind: str
    driven: bool = False
    elastic: bool = False
    follows: str | None = None


@dataclass(frozen=True)
class Run:
    """A chain between two branching bodies."""

    start: str
    end: str
    chain: Chain


@dataclass(frozen=True)
class Branches:
    """Runs between two bodies: parallel branches if all connect both bodies (``parallel``), otherwise a network."""

    start: str
    end: str
    runs: tuple[Run, ...]
    parallel: bool


Item: TypeAlias = Body | JointStep | Branches
Chain: TypeAlias = tuple[Item, ...]


@dataclass(frozen=True)
class Hanging:
    """A branch that starts at the body ``at``; ``is_ring``: it also ends there."""

    at: str
    chain: Chain
    is_ring: bool


@dataclass(frozen=True)
class Graph:
    """A limb as a chain from base to platform.

    Attributes:
        chain: chain without base and platform; empty for attached bodies.
        hanging: branches and rings on bodies.
        rings: number of independent rings.
    """

    chain: Chain
    hanging: tuple[Hanging, ...]
    rings: int


def joint_string(chain: Chain) -> str:
    """Return the joints of a chain as letters, such as ``R(driven) (S S | S S)``; networks in square brackets."""
    words = []
    for item in chain:
        if isinstance(item, JointStep):
            if item.elastic or not JOINT_TYPES[item.kind].is_fixed:
                words.append(JOINT_TYPES[item.kind].symbol + ("(driven)" if item.driven else ""))
        elif isinstance(item, Branches):
            parts = [joint_string(run.chain) for run in item.runs]
            network = f"[{' '.join(filter(None, parts)) or '–'}]"
            words.append(f"({' | '.join(part or '–' for part in parts)})" if item.parallel else network)
    return " ".join(words)


def _items(chain: Chain) -> Iterator[Item]:
    for item in chain:
        yield item
        for run in item.runs if isinstance(item, Branches) else ():
            yield from _items(run.chain)


def joints_of(chain: Chain) -> list[JointStep]:
    """Return all joints of a chain."""
    return [item for item in _items(chain) if isinstance(item, JointStep)]


def bodies_of(chain: Chain) -> list[str]:
    """Return the names of all bodies of a chain."""
    return [name for item in _items(chain) if isinstance(item, Body) for name in item.names]


def joint_words(joint: JointStep) -> str:
    """Return a joint's name with remarks, such as ``universal_1_{x,y}`` or ``rail (driven, elastic)``."""
    name = joint.name
    if joint.joints != (name,):
        rests = [item[len(name) :].lstrip("_-. ") for item in joint.joints]
        together = all(item.startswith(name) for item in joint.joints) and all(rests)
        between = joint.joints[0][len(name) : len(joint.joints[0]) - len(rests[0])]
        name = f"{name}{between}{{{','.join(rests)}}}" if together else "+".join(joint.joints)
    notes = ["driven"] * joint.driven + ["elastic"] * joint.elastic + ["fixed"] * JOINT_TYPES[joint.kind].is_fixed
    if joint.follows is not None:
        notes.append(f"follows {joint.follows}")
    return name + (f" ({', '.join(notes)})" if notes else "")


def body_words(body: Body) -> str:
    """Return the names of links and beams that move together, of more than four the first two and the last."""
    if len(body.names) <= 4:
        return " + ".join(body.names)
    return f"{body.names[0]} + {body.names[1]} + … + {body.names[-1]} ({len(body.names)} in all)"


def chain_lines(start: str, chain: Chain, end: str, indent: str = "") -> list[str]:
    """Return a chain as lines such as ``base —revolute_1→ rod_1 —spherical_1→ platform``, with branches on separate lines."""
    lines: list[str] = []
    words = [start] if start else []

    def put(body: str) -> None:
        if not words:
            words.append(body)
        elif words[-1].endswith("→"):
            words[-1] += f" {body}"
        else:
            words[-1] += f" + {body}"

    left: str | None = end
    for k, item in enumerate(chain):
        if isinstance(item, JointStep):
            words.append(f"—{joint_words(item)}→")
        elif isinstance(item, Body):
            name = body_words(item)
            if not words or words[-1] != name:
                put(name)
        else:
            if words and words[-1].endswith("→"):
                put(item.start)
            what = f"{len(item.runs)} ways" if item.parallel else "a network"
            lines += _filled(words, f", then {what} to {item.end}:" if words else f"{what} to {item.end}:", indent)
            words = []
            for run in item.runs:
                ends = ("", "") if item.parallel else (run.start, run.end)
                inner = chain_lines(ends[0], run.chain, ends[1], indent + "    ")
                lines += [f"{indent}  - {inner[0].lstrip()}", *inner[1:]]
            if k == len(chain) - 1:
                left = None
            elif not isinstance(chain[k + 1], Body):
                words = [item.end]
    if left:
        put(left)
    return [*lines, *_filled(words, "", indent)]


def _filled(words: list[str], last: str, indent: str) -> list[str]:
    """Return words distributed over lines; continuation lines are indented further."""
    if not words and not last:
        return []
    words = [*words[:-1], words[-1] + last] if words else [last]
    lines = [indent + words[0]]
    for word in words[1:]:
        if len(lines[-1]) + 1 + len(word) > WIDTH:
            lines.append(indent + "    " + word)
        else:
            lines[-1] += f" {word}"
    return lines


class GraphReader:
    """Search for chains in the graph of a robot, limb by limb."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism, self.graph = mechanism, BodyGraph(mechanism)

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
        first = self.mechanism.connections[names[0]]
        elastic = any(springs_of(self.mechanism, name) or name in drives_of(self.mechanism) for name in names)
        driven = first.driven and first.mimic is None
        return JointStep(label, names, compound.type.name, driven, elastic, first.mimic.joint if first.mimic else None)


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
    return tuple(Body(item.names[::-1]) if isinstance(item, Body) else item for item in reversed(chain))


def _joined(*chains: Chain) -> Chain:
    """Return concatenated chains, with consecutive bodies merged."""
    found: list[Item] = []
    for item in (item for chain in chains for item in chain):
        if isinstance(item, Body) and not item.names:
            continue
        before = found[-1] if found else None
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
        beam = span.beam

        def body(link: str) -> Body:
            return Body((beam.name if link == beam.link else link,))

        here = span.start_link
        items: list[Item] = [body(here)]
        for connection in (*span.inward[::-1], *span.outward):
            here = connection.other(here)
            if not connection.type.is_fixed:
                items.append(self.reader.joint(connection))
            items.append(body(here))
        return _joined(tuple(items))

    def name(self, node: RigidBody) -> str:
        """Return the name of a node."""
        names = self._names.get(node, ())
        if names:
            return " + ".join(names)
        return f"the end of {self._beam_at[node]}" if node in self._beam_at else "a point"

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
                    self.lines.insert(position, _Edge(first.end, others[0].end, _joined(inwards, others[0].chain)))
                else:
                    self.hanging.append(Hanging(self.name(first.end), inwards, False))

    def _without_rings(self, start: RigidBody, end: RigidBody, lines: list[_Edge]) -> list[_Edge]:
        """Remove groups of connected runs that are attached to only one of two bodies."""
        inner = [{line.start, line.end} - {start, end} for line in lines]
        pairs = ((k, h) for k, h in combinations(range(len(lines)), 2) if inner[k] & inner[h])
        left = lines
        for group in dict.fromkeys(joined(range(len(lines)), pairs).values()):
            mine = [lines[k] for k in sorted(group)]
            roots = {node for line in mine for node in (line.start, line.end)} & {start, end}
            if len(roots) == 1 and len(mine) < len(lines):
                root = roots.pop()
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
