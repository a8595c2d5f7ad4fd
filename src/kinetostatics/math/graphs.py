"""Graphs: reachable nodes, connected components, articulation points and simple paths."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence, Set
from typing import Generic, TypeVar

Node = TypeVar("Node")
Edge = TypeVar("Edge")
Key = TypeVar("Key", bound=Hashable)

#: Largest number of steps of a path search.
PATIENCE = 20_000


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
    for first, second in pairs:
        at[first].append(second)
        at[second].append(first)
    found: dict[Node, frozenset[Node]] = {}
    for node in at:
        if node not in found:
            together = frozenset(reachable([node], at.__getitem__))
            found.update(dict.fromkeys(together, together))
    return found


def blocks(
    edges: Sequence[Edge], ends: Callable[[Edge], tuple[Node, Node]], start: Node, goal: Node
) -> list[tuple[Node, Node, list[Edge]]]:
    """Divide a graph at the nodes that all paths from ``start`` to ``goal`` pass.

    Returns:
        The subgraphs in series: first node, last node, and edges of each; none if ``start`` or ``goal`` has no edge.
    """
    at: dict[Node, list[Node]] = {}
    for edge in edges:
        for one, other in (ends(edge), ends(edge)[::-1]):
            at.setdefault(one, []).append(other)
    if start not in at or goal not in at:
        return []

    def reached(without: Node) -> dict[Node, None]:
        return reachable([start], lambda node: () if node is goal else (item for item in at[node] if item is not without))

    cuts = [(reached(node), node) for node in at if node not in (start, goal)]
    cuts = sorted((item for item in cuts if goal not in item[0]), key=lambda item: len(item[0]))
    result: list[tuple[Node, Node, list[Edge]]] = []
    left, inner = list(edges), start
    for inside, outer in [*cuts, (dict.fromkeys(at), goal)]:
        mine = [edge for edge in left if any(end in inside for end in ends(edge))]
        left = [edge for edge in left if edge not in mine]
        result.append((inner, outer, mine))
        inner = outer
    return result


class Paths(Generic[Key, Node]):
    """Simple paths of a graph from one node to another.

    Args:
        edges: the two nodes of every edge, by key.
        start, goal: first and last node of the paths.
    """

    def __init__(self, edges: Mapping[Key, tuple[Node, Node]], start: Node, goal: Node) -> None:
        self.start, self.goal = start, goal
        self._at: dict[Node, list[tuple[Key, Node]]] = {start: [], goal: []}
        for key, (first, second) in edges.items():
            self._at.setdefault(first, []).append((key, second))
            self._at.setdefault(second, []).append((key, first))

    def pass_along(self, edge: Key, first: Node, second: Node) -> bool:
        """Whether a path passes ``edge`` from ``first`` to ``second``; True if undecided after :data:`PATIENCE` steps."""
        start, goal = self.start, self.goal
        if first == second or first == goal or second == start:
            return False

        def steps(node: Node, path: Set[Node]) -> Iterator[Node]:
            """Yield each neighbour of ``node`` that leaves ``first`` reachable, and ``second`` connected to the goal."""
            for key, other in self._at[node]:
                if key == edge or other in path or other in (second, goal):
                    continue
                ahead = self.connected(other, first, path | {second, goal}, edge)
                if ahead and self.connected(second, goal, path | {other}, edge):
                    yield other

        if not self.connected(second, goal, {start}, edge):
            return False
        if first == start:
            return True
        path = [start]
        todo = [steps(start, {start})]
        for _ in range(PATIENCE):
            following = next(todo[-1], None)
            if following is None:
                todo.pop()
                path.pop()
                if not todo:
                    return False
            elif following == first:
                return True
            else:
                path.append(following)
                todo.append(steps(following, set(path)))
        return True

    def connected(self, start: Node, goal: Node, barred: Set[Node], without: Key) -> bool:
        if start in barred or goal in barred:
            return False

        def neighbours(node: Node) -> Iterator[Node]:
            return (other for key, other in self._at[node] if key != without and other not in barred)

        return goal in reachable([start], neighbours)
