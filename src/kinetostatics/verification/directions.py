"""Which side of a joint or beam lies towards the base: told by paths from base to platform, one by one."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Set

#: How many steps of paths are tried before both directions count as possible.
PATIENCE = 20_000


class Directions:
    """Directions of the edges of a graph with a base and a platform.

    Where every path from base to platform that visits no node twice passes an edge in the same direction, its inner side is the
    one that comes first. Where paths pass it in both directions, as the bridge of a cross-brace, its own first side is; so it is
    in a ring that no such path passes. Other edges that none passes point away from what they hang on.

    Args:
        edges: the two nodes of every edge, by key.
        base, platform: two of the nodes.
    """

    def __init__(self, edges: Mapping[str, tuple[int, int]], base: int, platform: int) -> None:
        self.base, self.platform = base, platform
        self._edges = dict(edges)
        self._at: dict[int, list[tuple[str, int]]] = {base: [], platform: []}
        for key, (first, second) in self._edges.items():
            self._at.setdefault(first, []).append((key, second))
            self._at.setdefault(second, []).append((key, first))

    def inner_first(self, edge: str) -> bool:
        """Whether the first node of an edge lies towards the base, or towards what the edge hangs on."""
        first, second = self._edges[edge]
        forward, backward = self._passes(edge, first, second), self._passes(edge, second, first)
        if forward or backward:
            return forward
        for target, barred in ((self.base, self.platform), (self.platform, self.base)):
            if self._connected(first, target, {barred}, edge):
                return True
            if self._connected(second, target, {barred}, edge):
                return False
        return True

    def _passes(self, edge: str, first: int, second: int) -> bool:
        """Whether a path leads from the base to ``first``, along the edge to ``second``, and on to the platform."""
        if first == second or first == self.platform or second == self.base:
            return False

        def steps(node: int, path: Set[int]) -> Iterator[int]:
            """Yield the nodes after which both parts of the path can still be completed."""
            for key, other in self._at[node]:
                if key == edge or other in path or other in (second, self.platform):
                    continue
                if self._connected(other, first, path | {second, self.platform}, edge):
                    if self._connected(second, self.platform, path | {other}, edge):
                        yield other

        if not self._connected(second, self.platform, {self.base}, edge):
            return False
        if first == self.base:
            return True
        path = [self.base]
        todo = [steps(self.base, {self.base})]
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

    def _connected(self, start: int, goal: int, barred: Set[int], without: str) -> bool:
        if start in barred or goal in barred:
            return False
        seen, queue = {start}, [start]
        while queue:
            here = queue.pop()
            if here == goal:
                return True
            for key, other in self._at[here]:
                if key != without and other not in seen and other not in barred:
                    seen.add(other)
                    queue.append(other)
        return False
