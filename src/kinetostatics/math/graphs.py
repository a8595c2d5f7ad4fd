"""Graphs: reachable nodes, connected components, articulation points and simple paths."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from typing import TypeVar

Node = TypeVar("Node", bound=Hashable)
Edge = TypeVar("Edge")
Key = TypeVar("Key", bound=Hashable)

#: Largest number of states of a search for the directions of edges.
MOST_STATES = 10_000

_State = frozenset[tuple[Hashable, Hashable]]


def reachable(starts: Iterable[Node], neighbours: Callable[[Node], Iterable[Node]]) -> dict[Node, None]:
    """Return ``starts`` and all nodes reachable from them, in breadth-first order."""
    seen = dict.fromkeys(starts)
    queue = list(seen)
    for node in queue:
        for other in neighbours(node):
            if other not in seen:
                seen[other] = None
                queue.append(other)
    return seen


def joined(nodes: Iterable[Node], pairs: Iterable[tuple[Node, Node]]) -> dict[Node, frozenset[Node]]:
    """Return the connected component of every node; ``pairs`` are the edges."""
    at: dict[Node, list[Node]] = {node: [] for node in nodes}
    at |= neighbours_of(pairs)
    components: dict[Node, frozenset[Node]] = {}
    for node in at:
        if node not in components:
            together = frozenset(reachable([node], at.__getitem__))
            components.update(dict.fromkeys(together, together))
    return components


def blocks(
    edges: Sequence[Edge], ends: Callable[[Edge], tuple[Node, Node]], start: Node, goal: Node
) -> list[tuple[Node, Node, list[Edge]]]:
    """Divide a graph at the nodes that all paths from ``start`` to ``goal`` pass.

    Returns:
        The subgraphs in series: first node, last node, and edges of each; none if ``start`` or ``goal`` has no edge.
    """
    at = neighbours_of(map(ends, edges))
    if start not in at or goal not in at:
        return []

    def reached(without: Node) -> dict[Node, None]:
        return reachable([start], lambda node: (other for other in at[node] if node is not goal and other is not without))

    cuts = [(reached(node), node) for node in at if node not in (start, goal)]
    cuts = sorted((cut for cut in cuts if goal not in cut[0]), key=lambda cut: len(cut[0]))
    result: list[tuple[Node, Node, list[Edge]]] = []
    left, inner = list(edges), start
    for inside, outer in [*cuts, (dict.fromkeys(at), goal)]:
        block = [edge for edge in left if any(end in inside for end in ends(edge))]
        left = [edge for edge in left if edge not in block]
        result.append((inner, outer, block))
        inner = outer
    return result


def neighbours_of(edges: Iterable[tuple[Node, Node]]) -> dict[Node, list[Node]]:
    at: dict[Node, list[Node]] = {}
    for first, second in edges:
        at.setdefault(first, []).append(second)
        at.setdefault(second, []).append(first)
    return at


def st_order(edges: Iterable[tuple[Node, Node]], start: Node, goal: Node) -> dict[Node, int]:
    """Number the nodes on simple paths from ``start`` (0) to ``goal``: each other one has an earlier and a later neighbour.

    Between two numbered nodes, a path through nodes without number is inserted behind the earlier one (A. Lempel, S. Even, I.
    Cederbaum, *An algorithm for planarity testing of graphs*, 1967). An edge is on a path if, and only if, both its nodes have a
    number.
    """
    at = neighbours_of(edges)
    order, numbered = [start, goal], [start, goal]
    on_paths = {start, goal}
    for node in numbered:
        for other in at.get(node, []):
            if other in on_paths:
                continue
            before: dict[Node, Node] = {other: node}
            for step in (queue := [other]):
                for following in at[step]:
                    if following not in before and following != node:
                        before[following] = step
                        if following not in on_paths:
                            queue.append(following)
            end = next((end for end in before if end in on_paths), None)
            if end is None:
                continue
            inserted, step = [], before[end]
            while step != node:
                inserted.append(step)
                step = before[step]
            numbered += inserted
            on_paths.update(inserted)
            behind = min(order.index(node), order.index(end)) + 1
            order[behind:behind] = inserted if order[behind - 1] == end else inserted[::-1]
    return {node: number for number, node in enumerate(order)}


def path_directions(edges: Mapping[Key, tuple[Node, Node]], start: Node, goal: Node) -> dict[Key, set[bool]]:
    """Return the directions in which simple paths from ``start`` to ``goal`` pass each edge; True: from its first node.

    If there are more than :data:`MOST_STATES` states, paths pass the edges between ``start`` and ``goal`` in both directions.
    """
    parts: dict[Hashable, dict[Key, tuple[Node, Node]]] = {}
    inner = joined(
        (end for ends in edges.values() for end in ends if end not in (start, goal)),
        (ends for ends in edges.values() if start not in ends and goal not in ends),
    )
    for key, ends in edges.items():
        if ends[0] != ends[1]:
            parts.setdefault(next((inner[end] for end in ends if end in inner), key), {})[key] = ends
    directions: dict[Key, set[bool]] = {key: set() for key in edges}
    for part in parts.values():
        order = st_order(part.values(), start, goal)
        on_paths = {key: ends for key, ends in part.items() if ends[0] in order and ends[1] in order}
        directions |= _directions(on_paths, start, goal)
    return directions


def _directions(edges: Mapping[Key, tuple[Node, Node]], start: Node, goal: Node) -> dict[Key, set[bool]]:
    """Return the directions of edges that are all on paths, by combining pieces of paths edge by edge.

    A *state* is the set of pieces (first node, last node) that the edges so far make, without nodes that have no further edge; a
    node not passed is a piece by itself. The paths are the ways from state to state that end with one piece from ``start`` to
    ``goal`` (D. E. Knuth, *The Art of Computer Programming* 4A, 7.1.4: Simpath).
    """
    states: Iterable[_State] = [frozenset({(start, start), (goal, goal)})]
    layers: list[tuple[Key | None, dict[_State, list[tuple[_State, bool | None]]]]] = []
    for key, node, is_new in _sweep(edges, start, goal):
        origins: dict[_State, list[tuple[_State, bool | None]]] = {}
        for state in states:
            if key is None:  # the node has no further edge
                if node == start or not any(node in piece and piece != (node, node) for piece in state):
                    if (start, start) not in state:
                        origins.setdefault(state - {(node, node)}, []).append((state, None))
                continue
            pieces = state | {(node, node)} if is_new else state
            origins.setdefault(pieces, []).append((state, None))
            first_of, last_of = {last: first for first, last in pieces}, dict(pieces)
            for (tail, head), forward in ((edges[key], True), (edges[key][::-1], False)):
                if tail in first_of and head in last_of and first_of[tail] != head and tail != goal and head != start:
                    first, last = first_of[tail], last_of[head]
                    combined = pieces - {(first, tail), (head, last)} | {(first, last)}
                    origins.setdefault(combined, []).append((state, forward))
        if len(origins) > MOST_STATES:
            return {key: {True, False} for key in edges}
        layers.append((key, origins))
        states = origins
    directions: dict[Key, set[bool]] = {key: set() for key in edges}
    complete: set[_State] = {frozenset({(start, goal)})}
    for key, origins in reversed(layers):
        passed = [origin for state in complete for origin in origins.get(state, [])]
        complete = {state for state, _ in passed}
        if key is not None:
            directions[key] = {forward for _, forward in passed if forward is not None}
    return directions


def _sweep(edges: Mapping[Key, tuple[Node, Node]], start: Node, goal: Node) -> Iterator[tuple[Key | None, Node, bool]]:
    """Yield each edge with the node that it leads to, and whether this is the first edge there; no edge: the node's last is over.

    All edges of a node follow one another; the next node is the one with the fewest neighbours not reached yet.
    """
    at: dict[Node, list[tuple[Key, Node]]] = {}
    for key, (first, second) in edges.items():
        at.setdefault(first, []).append((key, second))
        at.setdefault(second, []).append((key, first))
    seen, swept, waiting = {start, goal}, set(), [start] if start in at else []
    while waiting:
        node = min(reversed(waiting), key=lambda node: len({other for _, other in at[node]} - seen))
        waiting.remove(node)
        for key, other in at[node]:
            if key not in swept:
                swept.add(key)
                yield key, other, other not in seen
                if other not in seen:
                    seen.add(other)
                    waiting.append(other)
        yield None, node, False
