"""Directions in which simple paths pass edges, compared with all paths through small graphs."""

import itertools
import time

import numpy as np
import pytest

from kinetostatics.math.graphs import path_directions, st_order


def simple_paths(edges, node, goal, passed=()):
    """Yield every path from a node to the goal that meets no node twice, as (edge, whether it is passed as written)."""
    if node == goal:
        yield []
        return
    for key, (first, second) in edges.items():
        if node in (first, second) and first != second:
            other = second if node == first else first
            if other not in (*passed, node):
                for further in simple_paths(edges, other, goal, (*passed, node)):
                    yield [(key, node == first), *further]


def brute_force(edges, start, goal):
    directions = {key: set() for key in edges}
    for path in simple_paths(edges, start, goal):
        for key, forward in path:
            directions[key].add(forward)
    return directions


def check(edges, start, goal):
    directions = path_directions(edges, start, goal)
    assert directions == brute_force(edges, start, goal)
    order = st_order([edges[key] for key in edges if directions[key]], start, goal)
    for key, ways in directions.items():
        if len(ways) == 1:
            first, second = edges[key]
            assert (order[first] < order[second]) == (ways == {True})
    on_paths = {node for key, ways in directions.items() if ways for node in edges[key]}
    for node in on_paths:  # every node has an edge from an earlier and one to a later node, so that all paths lead on
        near = {order[other] for key, pair in edges.items() if directions[key] and node in pair for other in pair}
        assert node == start or min(near) < order[node]
        assert node == goal or max(near) > order[node]


def test_all_graphs_with_five_nodes():
    pairs = list(itertools.combinations(range(5), 2))
    for chosen in range(2 ** len(pairs)):
        check({k: pair for k, pair in enumerate(pairs) if chosen >> k & 1}, 0, 4)


@pytest.mark.few(4)
@pytest.mark.parametrize("seed", range(20))
def test_random_graphs(seed):
    """With parallel edges, edges from a node to itself, and parts that no path enters."""
    random = np.random.default_rng(seed)
    for _ in range(150):
        nodes, count = int(random.integers(2, 9)), int(random.integers(1, 15))
        pairs = random.integers(nodes, size=(count, 2)).tolist()
        check(dict(enumerate(map(tuple, pairs))), 0, nodes - 1)


def ladder(rungs):
    """Two rails from a start to a goal, joined by rungs; each rail and each rung is a chain of three edges."""
    pairs = [("start", "a0"), ("start", "b0"), (f"a{rungs}", "goal")]
    for k in range(1, rungs + 1):
        for first, second in ((f"a{k - 1}", f"a{k}"), (f"b{k - 1}", f"b{k}"), (f"a{k}", f"b{k}")):
            inner = [f"{first}{second}{part}" for part in "xy"]
            pairs += itertools.pairwise([first, *inner, second])
    return {f"{first}-{second}": (first, second) for first, second in pairs}


def test_ladders_in_every_order():
    """Rails are passed upwards, and all rungs both ways but the last, which only leads to the goal; in every order of edges."""
    edges = ladder(100)
    begin = time.process_time()
    directions = path_directions(edges, "start", "goal")
    assert time.process_time() - begin < 2
    for key, ways in directions.items():
        first, _, last = key.partition("-")
        rail = first[0] == last[0] and not {"a", "b"} <= set(first + last)
        assert ways == ({True} if rail or "start" in key or "goal" in key else {False} if "a100b100" in key else {True, False})
    for seed in range(3):
        keys = np.random.default_rng(seed).permutation(list(edges)).tolist()
        assert path_directions({key: edges[key] for key in keys}, "start", "goal") == directions


def test_a_graph_with_too_many_paths_is_passed_both_ways():
    """Beyond the limit of the states, an edge that paths can reach is taken as passed both ways."""
    grid = [
        ((i, j), (i + a, j + b)) for i in range(14) for j in range(14) for a, b in ((0, 1), (1, 0)) if i + a < 14 and j + b < 14
    ]
    begin = time.process_time()
    directions = path_directions(dict(enumerate(grid)), (0, 0), (13, 13))
    assert time.process_time() - begin < 20
    assert all(ways == {True, False} for ways in directions.values())
