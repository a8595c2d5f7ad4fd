"""Limbs as chains of bodies and joints from base to platform, with parallel branches: found in the body graph, written as text.

Edges in series are merged into *runs*, which end at bodies with three or more edges. The chain is divided at the bodies that lie
on every path from base to platform. Several runs between two such bodies are parallel *branches* if each connects both bodies,
otherwise a *network*. Dead ends and rings are listed with the body to which they are attached. A *node* is a body with all bodies
welded to it.
"""

from __future__ import annotations

import os
import textwrap
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import TypeAlias

from kinetostatics.description.joint_types import JOINT_TYPES
from kinetostatics.layout.renderings import WIDTH
from kinetostatics.math.graphs import blocks, joined, reachable
from kinetostatics.mechanism.body_graph import BodyEdge, BodyGraph, RigidBody
from kinetostatics.mechanism.joints import CompoundJoint, compound_joints, elastic_actuators, springs_of
from kinetostatics.mechanism.limbs import Edge, Limb, Topology
from kinetostatics.mechanism.mechanism import Connection, Mechanism


@dataclass(frozen=True)
class Body:
    """A body between two joints: the names of its links and beams, from base to platform."""

    names: tuple[str, ...]


@dataclass(frozen=True)
class JointStep:
    """A joint between two bodies; revolutes with a common point form one universal or spherical joint.

    Attributes:
        name: name of the joint; for several revolutes, the common part of their names.
        joints: names of the revolutes, or of the single joint.
        kind: URDF or loop type.
        elastic: whether the joint or its actuator is elastic.
        follows: name of the joint that it mimics, or None.
    """

    name: str
    joints: tuple[str, ...]
    kind: str
    actuated: bool = False
    elastic: bool = False
    follows: str | None = None


@dataclass(frozen=True)
class Run:
    """A chain between two bodies with three or more edges."""

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


ChainPart: TypeAlias = Body | JointStep | Branches
Chain: TypeAlias = tuple[ChainPart, ...]


@dataclass(frozen=True)
class Hanging:
    """An open branch attached to the body ``at``, or a ring that begins and ends there."""

    at: str
    chain: Chain
    is_ring: bool


@dataclass(frozen=True)
class Graph:
    """A limb as a chain from base to platform.

    Attributes:
        chain: the chain without base and platform; empty for bodies attached only to the base, or only to the platform.
        hanging: open branches and rings.
    """

    chain: Chain
    hanging: tuple[Hanging, ...]


def _parts(chain: Chain) -> Iterator[ChainPart]:
    for part in chain:
        yield part
        for run in part.runs if isinstance(part, Branches) else ():
            yield from _parts(run.chain)


def joints_of(chain: Chain) -> list[JointStep]:
    return [part for part in _parts(chain) if isinstance(part, JointStep)]


def bodies_of(chain: Chain) -> list[str]:
    """Return the names of all links and beams of a chain's bodies."""
    return [name for part in _parts(chain) if isinstance(part, Body) for name in part.names]


def joint_text(joint: JointStep) -> str:
    """Return a joint's name with remarks, such as ``universal_1_{x,y}`` or ``rail (actuated, elastic)``."""
    name = joint.name
    if len(joint.joints) > 1:
        shared = os.path.commonprefix(joint.joints)  # noqa: RUF071 names are no paths
        endings = [part.removeprefix(shared) for part in joint.joints]
        name = f"{shared}{{{','.join(endings)}}}" if shared and all(endings) else "+".join(joint.joints)
    notes = ["actuated"] * joint.actuated + ["elastic"] * joint.elastic + ["fixed"] * JOINT_TYPES[joint.kind].is_fixed
    if joint.follows is not None:
        notes.append(f"follows {joint.follows}")
    return name + (f" ({', '.join(notes)})" if notes else "")


def body_text(body: Body) -> str:
    """Return the names of a body's links and beams; if there are more than four, the first two and the last."""
    if len(body.names) <= 4:
        return " + ".join(body.names)
    return f"{body.names[0]} + {body.names[1]} + … + {body.names[-1]} ({len(body.names)} in all)"


def chain_lines(start: str, chain: Chain, end: str, indent: str = "") -> list[str]:
    """Return a chain as lines such as ``base —revolute_1→ rod_1 —spherical_1→ platform``, with branches on separate lines."""
    lines: list[str] = []
    words = [start] if start else []

    def put(body: str) -> None:
        if words:
            words[-1] += f" {body}" if words[-1].endswith("→") else f" + {body}"
        else:
            words.append(body)

    left: str | None = end
    for k, part in enumerate(chain):
        if isinstance(part, JointStep):
            words.append(f"—{joint_text(part)}→")
        elif isinstance(part, Body):
            name = body_text(part)
            if not words or words[-1] != name:
                put(name)
        else:
            if words and words[-1].endswith("→"):
                put(part.start)
            what = f"{len(part.runs)} ways" if part.parallel else "a network"
            lines += _filled(words, f", then {what} to {part.end}:" if words else f"{what} to {part.end}:", indent)
            words = []
            for run in part.runs:
                ends = ("", "") if part.parallel else (run.start, run.end)
                inner = chain_lines(ends[0], run.chain, ends[1], indent + "    ")
                lines += [f"{indent}  - {inner[0].lstrip()}", *inner[1:]]
            if k == len(chain) - 1:
                left = None
            elif not isinstance(chain[k + 1], Body):
                words = [part.end]
    if left:
        put(left)
    return [*lines, *_filled(words, "", indent)]


def _filled(words: list[str], last: str, indent: str) -> list[str]:
    """Return words as lines, with the text ``last`` after the last word; continuation lines are indented further."""
    space = "\xa0"  # textwrap does not break at it
    text = " ".join(word.replace(" ", space) for word in words) + last.replace(" ", space)
    wrapper = textwrap.TextWrapper(WIDTH, indent, f"{indent}    ", break_long_words=False, break_on_hyphens=False)
    return [line.replace(space, " ") for line in wrapper.wrap(text)]


class GraphReader:
    """Search for the chains of a robot's limbs and of its attached bodies."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism, self.graph = mechanism, BodyGraph(mechanism, rigid_plates=True)

    def limb(self, limb: Limb) -> Graph:
        compounds = compound_joints(self.mechanism, limb)
        return _Reducer(self, [*limb.edges, *limb.branches], compounds).chain_between(self.graph.base, self.graph.platform)

    def attached(self, topology: Topology, role: str) -> Graph:
        """Return the open branches and rings attached to base or platform (``role``: ``base`` or ``platform``)."""
        edges = list((topology.base if role == "base" else topology.platform).edges)
        compounds: list[CompoundJoint] = []
        for limb in topology.hanging:
            if limb.name == role:
                present = {edge.key for edge in edges}
                edges += [edge for edge in (*limb.edges, *limb.branches) if edge.key not in present]
                compounds += compound_joints(self.mechanism, limb)
        return _Reducer(self, edges, compounds).attached_to(self.graph.base if role == "base" else self.graph.platform)

    def joint(self, compound: CompoundJoint | Connection) -> JointStep:
        names = compound.joints if isinstance(compound, CompoundJoint) else (compound.name,)
        label = compound.label if isinstance(compound, CompoundJoint) else compound.name
        first = self.mechanism.connections[names[0]]
        elastic = any(springs_of(self.mechanism, name) or name in elastic_actuators(self.mechanism) for name in names)
        actuated = first.actuated and first.mimic is None
        return JointStep(label, names, compound.type.name, actuated, elastic, first.mimic.joint if first.mimic else None)


@dataclass(eq=False)
class _Run:
    """A run of joints between two nodes, while the graph is reduced."""

    start: RigidBody
    end: RigidBody
    chain: Chain

    def leaving(self, node: RigidBody) -> _Run:
        """Return the run in the direction away from ``node``, one of its ends."""
        return self if self.start is node else _Run(self.end, self.start, _reversed(self.chain))


def _reversed(chain: Chain) -> Chain:
    return tuple(Body(part.names[::-1]) if isinstance(part, Body) else part for part in reversed(chain))


def _joined(*chains: Chain) -> Chain:
    """Return the concatenation of chains; consecutive bodies are merged."""
    parts: list[ChainPart] = []
    for part in (part for chain in chains for part in chain):
        if isinstance(part, Body) and not part.names:
            continue
        before = parts[-1] if parts else None
        if isinstance(part, Body) and isinstance(before, Body):
            parts[-1] = Body(tuple(dict.fromkeys((*before.names, *part.names))))
        else:
            parts.append(part)
    return tuple(parts)


class _Reducer:
    """Reduction of the edges of one limb, or of attached bodies, to a chain."""

    def __init__(self, reader: GraphReader, edges: list[Edge], compounds: Sequence[CompoundJoint]) -> None:
        self.reader, self.graph = reader, reader.graph
        self.hanging: list[Hanging] = []
        keys = {edge.key for edge in edges}
        limb_edges = [edge for edge in self.graph.edges if edge.key in keys]
        self.ends = (self.graph.base, self.graph.platform)
        welds = joined(self.graph.bodies, (edge.ends for edge in limb_edges if self._is_weld(edge)))
        #: for each body, the representative of all bodies welded to it
        self._node = {body: next(other for other in welds if other in welds[body]) for body in welds}
        self._names = self._name_nodes(limb_edges)
        self.runs = self._make_runs(limb_edges, compounds)
        self._beam_at: dict[RigidBody, str] = {}
        for run in self.runs:
            for node in (run.start, run.end):
                for beam in bodies_of(run.chain)[:1]:
                    self._beam_at.setdefault(node, beam)

    def _is_weld(self, edge: BodyEdge) -> bool:
        """Whether an edge is a rigid fixed joint between bodies other than base and platform."""
        connection = edge.connection
        is_rigid = connection is not None and connection.type.is_fixed and not springs_of(self.reader.mechanism, connection.name)
        return is_rigid and not set(edge.ends) & set(self.ends)

    def _name_nodes(self, edges: list[BodyEdge]) -> dict[RigidBody, tuple[str, ...]]:
        """Return for each node the names of its links without beams that have a mass or a joint, in the order of the file."""
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

    def _make_runs(self, edges: list[BodyEdge], compounds: Sequence[CompoundJoint]) -> list[_Run]:
        compound_of = {name: compound for compound in compounds for name in compound.joints}
        parts_of: dict[tuple[str, ...], list[BodyEdge]] = {}
        runs: list[_Run] = []
        for edge in edges:
            start, end = (self._node[body] for body in edge.ends)
            if edge.connection is not None:
                compound = compound_of.get(edge.connection.name)
                if compound is not None and len(compound.joints) > 1:
                    parts_of.setdefault(compound.joints, []).append(edge)
                elif not self._is_weld(edge):
                    runs.append(_Run(start, end, (self.reader.joint(compound or edge.connection),)))
            elif edge.span is not None:
                runs.append(_Run(start, end, self._along_beam(edge)))
        for joints, parts in parts_of.items():
            ends = [self._node[body] for edge in parts for body in edge.ends]
            outer = [node for node in ends if ends.count(node) == 1]
            if len(outer) == 2:  # otherwise both ends are on one piece: inside the base, or a ring
                runs.append(_Run(outer[0], outer[1], (self.reader.joint(compound_of[joints[0]]),)))
        return runs

    def _along_beam(self, edge: BodyEdge) -> Chain:
        """Return a beam as a body, or a telescopic beam as its links and the joints between them."""
        span = edge.span
        assert span is not None
        here, names = span.start_link, {span.part.link: span.part.name}
        parts: list[ChainPart] = [Body((names.get(here, here),))]
        for connection in (*span.inward[::-1], *span.outward):
            here = connection.other(here)
            if not connection.type.is_fixed:
                parts.append(self.reader.joint(connection))
            parts.append(Body((names.get(here, here),)))
        return _joined(tuple(parts))

    def name(self, node: RigidBody) -> str:
        names = self._names.get(node, ())
        if names:
            return " + ".join(names)
        return f"the end of {self._beam_at[node]}" if node in self._beam_at else "a point"

    def chain_between(self, start: RigidBody, end: RigidBody) -> Graph:
        self._reduce({start, end})
        chain: Chain = ()
        for here, node, runs in blocks(self.runs, lambda run: (run.start, run.end), start, end):
            runs = self._without_rings(here, node, runs)
            part = runs[0].leaving(here).chain if len(runs) == 1 else (self._branches(here, node, runs),)
            chain = _joined(chain, part, () if node is end else (Body(self._names.get(node, ())),))
        return Graph(chain, tuple(self.hanging))

    def attached_to(self, root: RigidBody) -> Graph:
        self._reduce({root})
        if self.runs:
            self.hanging.append(Hanging(self.name(root), (self._branches(root, root, self.runs),), True))
        return Graph((), tuple(self.hanging))

    def _reduce(self, terminals: set[RigidBody]) -> None:
        """Merge edges in series; move rings and dead ends to ``hanging``."""
        while True:
            at: dict[RigidBody, list[_Run]] = {}
            for run in self.runs:
                at.setdefault(run.start, []).append(run)
                at.setdefault(run.end, []).append(run)
            ring = next((run for run in self.runs if run.start is run.end), None)
            node = next((node for node, runs in at.items() if len(runs) < 3 and node not in terminals), None)
            if ring is not None:
                self.runs.remove(ring)
                self.hanging.append(Hanging(self.name(ring.start), ring.chain, True))
            elif node is None:
                return
            else:
                first, *others = (run.leaving(node) for run in at[node])
                inwards = _joined(_reversed(first.chain), (Body(self._names.get(node, ())),))
                position = self.runs.index(at[node][0])
                self.runs = [run for run in self.runs if run not in at[node]]
                if others:
                    self.runs.insert(position, _Run(first.end, others[0].end, _joined(inwards, others[0].chain)))
                else:
                    self.hanging.append(Hanging(self.name(first.end), inwards, False))

    def _without_rings(self, start: RigidBody, end: RigidBody, runs: list[_Run]) -> list[_Run]:
        """Return the runs between two nodes; groups of runs connected to only one of these nodes are moved to ``hanging``."""
        inner = [{run.start, run.end} - {start, end} for run in runs]
        pairs = ((k, h) for k, h in combinations(range(len(runs)), 2) if inner[k] & inner[h])
        left = runs
        for group in dict.fromkeys(joined(range(len(runs)), pairs).values()):
            connected = [runs[k] for k in sorted(group)]
            roots = {node for run in connected for node in (run.start, run.end)} & {start, end}
            if len(roots) == 1 and len(connected) < len(runs):
                root = roots.pop()
                left = [run for run in left if run not in connected]
                self.hanging.append(Hanging(self.name(root), (self._branches(root, root, connected),), True))
        return left

    def _branches(self, start: RigidBody, end: RigidBody, runs: list[_Run]) -> Branches:
        """Return the runs, each directed away from ``start``, those nearest to ``start`` first."""

        def others(node: RigidBody) -> Iterator[RigidBody]:
            return (run.leaving(node).end for run in runs if node in (run.start, run.end))

        near = {node: k for k, node in enumerate(reachable([start], others))}
        directed = []
        for run in runs:
            outwards = near.get(run.start, 0) <= near.get(run.end, 0) and run.start is not end
            directed.append(run if outwards else run.leaving(run.end))
        directed.sort(key=lambda run: near.get(run.start, 0))
        parallel = all({run.start, run.end} == {start, end} for run in runs)
        named = tuple(Run(self.name(run.start), self.name(run.end), run.chain) for run in directed)
        return Branches(self.name(start), self.name(end), named, parallel)
