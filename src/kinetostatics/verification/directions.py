"""Which side of a joint or beam lies towards the base: told by paths from base to platform, one by one."""

from __future__ import annotations

from collections.abc import Mapping

from kinetostatics.math.graphs import Paths


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
        self._paths = Paths(self._edges, base, platform)

    def inner_first(self, edge: str) -> bool:
        """Whether the first node of an edge lies towards the base, or towards what the edge hangs on."""
        first, second = self._edges[edge]
        forward = self._paths.pass_along(edge, first, second)
        if forward or self._paths.pass_along(edge, second, first):
            return forward
        for target, barred in ((self.base, self.platform), (self.platform, self.base)):
            if self._paths.connected(first, target, {barred}, edge):
                return True
            if self._paths.connected(second, target, {barred}, edge):
                return False
        return True
