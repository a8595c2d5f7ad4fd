"""Which way is out: edges of one component of the graph directed from base to platform, and a spanning tree of them.

Where every way from base to platform passes an edge in the same direction, that is its direction. The currents of an
electrical network with the same graph tell: the sign of an edge's current is the same for all resistances if and only if it
is passed in one direction only (R. J. Duffin, *Topology of series-parallel networks*, J. Math. Anal. Appl. 10, 1965).
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np

from kinetostatics.mechanism.rigid_bodies import BodyEdge, RigidBody

#: Networks with random resistances that are compared.
_SAMPLES = 40
#: Steps of the search for a way that passes an edge back, and edges of the largest limb that is searched.
_STEPS, _SEARCHED = 400, 120
#: Part of the whole current below which an edge leads nowhere: mere rounding.
_NO_CURRENT = 1e-9


@dataclass(frozen=True)
class DirectedEdge:
    """An edge with its direction.

    Attributes:
        edge: the edge.
        inner, outer: the bodies at its ends, on the way out from the base.
        in_tree: whether the spanning tree reaches ``outer`` through it.
        both_ways: whether it is passed in both directions, so that base and platform give it none.
    """

    edge: BodyEdge
    inner: RigidBody
    outer: RigidBody
    in_tree: bool
    both_ways: bool


def directed_edges(bodies: list[RigidBody], edges: list[BodyEdge], base: RigidBody, platform: RigidBody) -> list[DirectedEdge]:
    """Return all edges of one component, depth first from the base (from the platform, if it does not touch the base).

    An edge that ends at a body where others end too, or at the platform, comes last on its own way there.

    Args:
        bodies: the bodies of the component, without base and platform.
        edges: all edges that touch them, or an edge directly between base and platform.
        base: the base.
        platform: the platform.
    """
    ends = {end for edge in edges for end in (edge.inner.find(), edge.outer.find())}
    root = base if base in ends else platform
    inner: dict[BodyEdge, RigidBody] = {}
    both_ways: set[BodyEdge] = set()
    live = {root}
    if base in ends and platform in ends:
        currents = _currents(bodies, edges, base, platform)
        for k, edge in enumerate(edges):
            flowing = currents[np.abs(currents[:, k]) > _NO_CURRENT, k]
            if flowing.size:
                forward = flowing[0] > 0
                inner[edge] = edge.inner.find() if forward else edge.outer.find()
                live.update((edge.inner.find(), edge.outer.find()))
                if np.any(flowing > 0) and np.any(flowing < 0):
                    both_ways.add(edge)
        both_ways.update(_passed_back(inner, both_ways, base, platform))
    reached_by: dict[RigidBody, BodyEdge] = {}
    for edge in sorted(inner, key=lambda edge: edge.beam is None):  # the tree prefers beams
        outer = edge.other(inner[edge])
        if outer is not platform:
            reached_by.setdefault(outer, edge)
    at: dict[RigidBody, list[BodyEdge]] = {}
    for edge in edges:
        for end in (edge.inner.find(), edge.outer.find()):
            at.setdefault(end, []).append(edge)
    queue, seen = deque(live), set(live)
    while queue:  # what leads nowhere points away from the rest
        body = queue.popleft()
        for edge in at.get(body, []):
            other = edge.other(body)
            if edge not in inner:
                inner[edge] = body
                if other in seen:  # it closes a ring that hangs
                    inner[edge] = edge.inner.find()
                if _in_ring(edge, at, live):
                    both_ways.add(edge)
            if other not in seen:
                seen.add(other)
                reached_by[other] = edge
                queue.append(other)
    return _depth_first(root, edges, inner, reached_by, both_ways)


def _in_ring(edge: BodyEdge, at: dict[RigidBody, list[BodyEdge]], live: set[RigidBody]) -> bool:
    """Whether both ends of an edge that hangs are still reached without it."""
    seen, queue = set(live), deque(live)
    while queue:
        body = queue.popleft()
        for item in at.get(body, []):
            other = item.other(body)
            if item is not edge and other not in seen:
                seen.add(other)
                queue.append(other)
    return edge.inner.find() in seen and edge.outer.find() in seen


def _passed_back(inner: dict[BodyEdge, RigidBody], known: set[BodyEdge], base: RigidBody, platform: RigidBody) -> set[BodyEdge]:
    """Return further edges that a way from base to platform passes against their direction, found by search.

    The random networks miss few of them, in which only odd resistances turn the current. The search for one edge ends after a
    number of steps that only large networks need.
    """
    at: dict[RigidBody, list[BodyEdge]] = {}
    if len(inner) > _SEARCHED:
        return set()
    for edge, start in inner.items():
        for end in (start, edge.other(start)):
            at.setdefault(end, []).append(edge)

    def reaches(start: RigidBody, used: set[RigidBody]) -> bool:
        seen, queue = {start} | used, deque([start])
        while queue:
            body = queue.popleft()
            if body is platform:
                return True
            for item in at.get(body, []):
                other = item.other(body)
                if other not in seen:
                    seen.add(other)
                    queue.append(other)
        return False

    def passes(edge: BodyEdge) -> bool:
        goal, after = edge.other(inner[edge]), inner[edge]
        if base in (goal, after) or platform in (goal, after):
            return False  # at an end of all ways there is one direction only
        steps = 0
        stack: list[tuple[RigidBody, frozenset[RigidBody]]] = [(base, frozenset([base, after]))]
        while stack and steps < _STEPS:
            steps += 1
            body, used = stack.pop()
            if body is goal:
                if reaches(after, set(used) - {after}):
                    return True
                continue
            for item in at.get(body, []):
                other = item.other(body)
                if item is not edge and other not in used and other is not platform:
                    stack.append((other, used | {other}))
        return False

    return {edge for edge in inner if edge not in known and passes(edge)}


def _depth_first(
    root: RigidBody,
    edges: list[BodyEdge],
    inner: dict[BodyEdge, RigidBody],
    reached_by: dict[RigidBody, BodyEdge],
    both_ways: set[BodyEdge],
) -> list[DirectedEdge]:
    leaving: dict[RigidBody, list[BodyEdge]] = {}
    for edge in edges:
        leaving.setdefault(inner[edge], []).append(edge)
    steps: list[DirectedEdge] = []
    stack = leaving.get(root, [])[::-1]
    while stack:
        edge = stack.pop()
        outer = edge.other(inner[edge])
        in_tree = reached_by.get(outer) is edge
        steps.append(DirectedEdge(edge, inner[edge], outer, in_tree, edge in both_ways))
        if in_tree:
            stack.extend(leaving.get(outer, [])[::-1])
    return steps


def segments_between_cuts(
    steps: list[DirectedEdge], base: RigidBody, platform: RigidBody
) -> list[tuple[RigidBody, RigidBody, list[DirectedEdge]]]:
    """Return the stretches between the bodies that every way from base to platform passes: inner, outer body and edges."""
    at: dict[RigidBody, list[DirectedEdge]] = {}
    for step in steps:
        at.setdefault(step.inner, []).append(step)
        at.setdefault(step.outer, []).append(step)

    def reach(without: RigidBody) -> set[RigidBody]:
        seen, queue = {base}, deque([base])
        while queue:
            body = queue.popleft()
            for step in at.get(body, []):
                other = step.outer if step.inner is body else step.inner
                if other is not without and other not in seen:
                    seen.add(other)
                    if other is not platform:
                        queue.append(other)
        return seen

    if base not in at or platform not in at:
        return []
    cuts = [(reach(body), body) for body in at if body not in (base, platform)]
    cuts = sorted((item for item in cuts if platform not in item[0]), key=lambda item: len(item[0]))
    result: list[tuple[RigidBody, RigidBody, list[DirectedEdge]]] = []
    left, inner = list(steps), base
    for inside, outer in [*cuts, (set(at), platform)]:
        mine = [step for step in left if step.inner in inside or step.outer in inside]
        left = [step for step in left if step not in mine]
        result.append((inner, outer, mine))
        inner = outer
    return result


def _currents(bodies: list[RigidBody], edges: list[BodyEdge], base: RigidBody, platform: RigidBody) -> np.ndarray:
    """Return the edges' currents (samples, edges) from inner to outer, parts of the whole current."""
    number = {body: k for k, body in enumerate(bodies)}
    number[base], number[platform] = len(bodies), len(bodies) + 1
    start = np.array([number[edge.inner.find()] for edge in edges])
    end = np.array([number[edge.outer.find()] for edge in edges])
    random = np.random.default_rng(0)
    result = np.empty((_SAMPLES, len(edges)))
    n = len(bodies)
    for sample in range(_SAMPLES):
        conductance = 10 ** random.uniform(-2.5, 2.5, len(edges))
        laplacian = np.zeros((n + 2, n + 2))
        np.add.at(laplacian, (start, start), conductance)
        np.add.at(laplacian, (end, end), conductance)
        np.add.at(laplacian, (start, end), -conductance)
        np.add.at(laplacian, (end, start), -conductance)
        potential = np.zeros(n + 2)
        potential[n + 1] = 1.0
        if n:
            potential[:n] = np.linalg.solve(laplacian[:n, :n], -laplacian[:n, n + 1])
        current = conductance * (potential[end] - potential[start])
        result[sample] = current / abs(float(laplacian[n] @ potential))
    return result
