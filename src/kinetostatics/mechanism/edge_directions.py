"""Direction of edges from base to platform in one component of the graph, and a spanning tree.

If all paths from base to platform pass an edge in the same direction, this is its direction. It is the sign of the current in an
electrical network with the same graph; this sign is the same for all resistances if and only if the edge is passed in one
direction only (R. J. Duffin, *Topology of series-parallel networks*, J. Math. Anal. Appl. 10, 1965). A path search decides
whether a path passes the edge against the current. Edges passed in both directions have the direction of the current, so that
there are no directed rings.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from kinetostatics.math.arrays import Array
from kinetostatics.math.graphs import Paths, reachable
from kinetostatics.mechanism.rigid_bodies import BodyEdge, RigidBody

#: Current, relative to the total, that counts as rounding, so that the edge is not on a path from base to platform.
_NO_CURRENT = 1e-9

_Edges = dict[RigidBody, list[BodyEdge]]


@dataclass(frozen=True)
class DirectedEdge:
    """An edge with its direction.

    Attributes:
        edge: the edge.
        inner, outer: the bodies at its inboard and outboard end.
        in_tree: whether the spanning tree reaches ``outer`` through it.
        both_ways: whether paths from base to platform pass it in both directions.
    """

    edge: BodyEdge
    inner: RigidBody
    outer: RigidBody
    in_tree: bool
    both_ways: bool


def directed_edges(edges: list[BodyEdge], base: RigidBody, platform: RigidBody) -> list[DirectedEdge]:
    """Return all edges of one component, depth first from the base (from the platform, if it does not touch the base).

    Every edge comes after the edges on the tree's path to its inner body.

    Args:
        edges: all edges that touch the component's bodies, or an edge directly between base and platform.
        base: the base.
        platform: the platform.
    """
    at: _Edges = {}
    for edge in edges:
        for end in edge.ends:
            at.setdefault(end, []).append(edge)
    root = base if base in at else platform
    inner: dict[BodyEdge, RigidBody] = {}
    both_ways: set[BodyEdge] = set()
    if base in at and platform in at:
        currents = _currents(edges, at, base, platform)
        paths = Paths({edge: edge.ends for edge in edges}, base, platform)
        for edge, current in zip(edges, currents.tolist(), strict=True):
            if abs(current) > _NO_CURRENT:
                inner[edge] = edge.ends[int(current < 0)]
                if paths.pass_along(edge, edge.other(inner[edge]), inner[edge]):
                    both_ways.add(edge)
    reached_by: dict[RigidBody, BodyEdge] = {}
    for edge in sorted(inner, key=lambda edge: edge.beam is None):  # beams first, so that they are in the tree
        outer = edge.other(inner[edge])
        if outer is not platform:
            reached_by.setdefault(outer, edge)
    on_paths = dict.fromkeys([root, *(end for edge in inner for end in edge.ends)])
    seen = set(on_paths)
    # dead ends are directed away from the other edges
    for body in reachable(on_paths, lambda body: [edge.other(body) for edge in at[body]]):
        for edge in at[body]:
            other = edge.other(body)
            if edge not in inner:
                inner[edge] = edge.ends[0] if other in seen else body  # if seen, it closes a ring of a dead end
                if _in_ring(edge, at, on_paths):
                    both_ways.add(edge)
            if other not in seen:
                seen.add(other)
                reached_by[other] = edge
    return list(_depth_first(root, edges, inner, reached_by, both_ways))


def _in_ring(edge: BodyEdge, at: _Edges, on_paths: Iterable[RigidBody]) -> bool:
    """Whether an edge of a dead end is part of a ring: both its ends are reached without it."""
    found = reachable(on_paths, lambda body: [item.other(body) for item in at[body] if item is not edge])
    return all(end in found for end in edge.ends)


def _depth_first(
    root: RigidBody,
    edges: list[BodyEdge],
    inner: dict[BodyEdge, RigidBody],
    reached_by: dict[RigidBody, BodyEdge],
    both_ways: set[BodyEdge],
) -> Iterator[DirectedEdge]:
    leaving: dict[RigidBody, list[BodyEdge]] = {}
    for edge in edges:
        leaving.setdefault(inner[edge], []).append(edge)
    stack = leaving.get(root, [])[::-1]
    while stack:
        edge = stack.pop()
        outer = edge.other(inner[edge])
        in_tree = reached_by.get(outer) is edge
        yield DirectedEdge(edge, inner[edge], outer, in_tree, edge in both_ways)
        if in_tree:
            stack.extend(leaving.get(outer, [])[::-1])


def _currents(edges: list[BodyEdge], at: _Edges, base: RigidBody, platform: RigidBody) -> Array:
    """Return the currents (edges,) relative to the total; positive if the current enters at the first end."""
    bodies = [body for body in at if body not in (base, platform)]
    number = {body: k for k, body in enumerate([*bodies, base, platform])}
    incidence = np.zeros((len(edges), len(number)))
    for row, edge in zip(incidence, edges, strict=True):
        row[[number[body] for body in edge.ends]] = -1.0, 1.0
    conductance = 10 ** np.random.default_rng(0).uniform(
        -2.5, 2.5, len(edges)
    )  # equal conductances would leave edges without current
    n = len(bodies)
    laplacian = (incidence.T * conductance) @ incidence
    potential = np.append(np.linalg.solve(laplacian[:n, :n], -laplacian[:n, n + 1]), [0.0, 1.0])
    return np.asarray(conductance * (incidence @ potential) / abs(laplacian[n] @ potential))
