"""What is joined to what."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TypeVar

Node = TypeVar("Node")


def reachable(starts: Iterable[Node], neighbours: Callable[[Node], Iterable[Node]]) -> dict[Node, None]:
    """Return all nodes that some nodes lead to, these themselves too, in the order in which a breadth-first search finds them."""
    seen = dict.fromkeys(starts)
    queue = list(seen)
    for node in queue:
        found = [other for other in dict.fromkeys(neighbours(node)) if other not in seen]
        seen.update(dict.fromkeys(found))
        queue += found
    return seen
