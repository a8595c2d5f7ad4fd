"""Directions of a body graph's edges from base to platform, compared with all paths through small networks."""

from types import SimpleNamespace

import numpy as np
import pytest

from kinetostatics.math.graphs import blocks, reachable
from kinetostatics.mechanism.body_graph import BodyEdge, RigidBody, directed_edges


class Network:
    """Rigid bodies named by letters, ``0`` the base and ``1`` the platform; edges as pairs of letters, from inner to outer."""

    def __init__(self, *edges: str, beams: str = "") -> None:
        names = sorted({letter for edge in edges for letter in edge} | {"0", "1"})
        self.named = {letter: RigidBody([letter]) for letter in names}
        self.base, self.platform = self.named["0"], self.named["1"]
        spans = {pair: SimpleNamespace(part=SimpleNamespace(name=pair)) for pair in beams.split()}
        self.edges = [BodyEdge((self.named[a], self.named[b]), span=spans.get(a + b)) for a, b in edges]

    def steps(self):
        return directed_edges(self.edges, self.base, self.platform)

    def blocks(self):
        return blocks(self.steps(), lambda step: (step.inner, step.outer), self.base, self.platform)

    def read(self):
        """Return the steps in words: ``ab``, ``~`` before those of both ways, ``-`` behind those not of the tree."""
        return [
            "~" * step.both_ways
            + step.inner.links[0]
            + step.outer.links[0]
            + "-" * (not step.in_tree and step.outer.links[0] != "1")
            for step in self.steps()
        ]


def test_chain_direction_does_not_depend_on_joint_order():
    assert Network("0a", "ab", "b1").read() == Network("a0", "ba", "1b").read() == ["0a", "ab", "b1"]
    assert Network("b1", "ab", "0a").read() == ["0a", "ab", "b1"]
    assert Network("01").read() == ["01"]


def test_only_the_bridge_has_both_directions():
    bridge = ("0a", "0b", "ab", "a1", "b1")
    assert Network(*bridge).read() == ["0a", "a1", "0b", "~ba-", "b1"]
    assert Network("0a", "0b", "ab", "a1", "b1", "1c", "c0").read()[-2:] == ["0c", "c1"]


def test_direction_with_almost_no_current_is_found():
    """Current flows from c to b only if the five edges from c to the platform resist much and the long path from b does not."""
    long = ("0a", "ap", "pq", "qr", "rs", "st", "tc", "0b", "bu", "uv", "vw", "wx", "xy", "y1", "a1", *["c1"] * 5)
    network = Network(*long, "bk", "kl", "lc", "bm", "mc")
    both = {step.edge for step in network.steps() if step.both_ways}
    assert both == {*network.edges[1:7], *network.edges[-5:]}


def test_ring_in_a_chain_has_one_direction():
    assert Network("0a", "ab", "ac", "bd", "cd", "d1").read() == ["0a", "ab", "bd", "d1", "ac", "cd-"]
    # the tree prefers beams where two edges end at one body
    assert Network("0a", "ab", "ac", "bd", "cd", "d1", beams="cd").read() == ["0a", "ab", "bd-", "ac", "cd", "d1"]


def test_dangling_edges_point_away_from_the_chain():
    assert Network("0a", "a1", "ba", "bc").read() == ["0a", "a1", "ab", "bc"]
    # a ring that hangs on the chain: its edges have no direction of their own
    assert Network("0a", "a1", "ab", "bc", "ca").read() == ["0a", "a1", "~ab", "~bc-", "~ac"]
    # a ring beyond a joint: the joint points away, the ring has no direction
    assert Network("0a", "a1", "ab", "bc", "cd", "db").read() == ["0a", "a1", "ab", "~bc", "~cd-", "~bd"]


def test_a_component_without_the_base_begins_at_the_platform():
    assert Network("ab", "b1").read() == ["1b", "ba"]
    assert Network("0a", "ab").read() == ["0a", "ab"]


def test_blocks_are_split_at_bodies_on_every_path():
    network = Network("0a", "ab", "ac", "bd", "cd", "d1")
    found = [
        (inner.links[0], outer.links[0], [step.inner.links[0] + step.outer.links[0] for step in steps])
        for inner, outer, steps in network.blocks()
    ]
    assert found == [("0", "a", ["0a"]), ("a", "d", ["ab", "bd", "ac", "cd"]), ("d", "1", ["d1"])]
    hanging = Network("ab", "b1")
    assert hanging.blocks() == []


def ways(edges, here, platform, met=()):
    """Yield all paths from a body to the platform that meet no body twice, as (edge, whether it is passed as written)."""
    if here is platform:
        yield []
        return
    for edge in edges:
        if here in edge.ends and edge.other(here) not in (*met, here):
            for rest in ways(edges, edge.other(here), platform, (*met, here)):
                yield [(edge, edge.ends[0] is here), *rest]


@pytest.mark.few(10)
@pytest.mark.parametrize("seed", range(30))
def test_directions_equal_those_of_all_paths(seed):
    random = np.random.default_rng(seed)
    base, platform, *others = bodies = [RigidBody([str(k)]) for k in range(random.integers(3, 9))]
    pairs = [(others[random.integers(k)], others[k]) for k in range(1, len(others))]  # they hang together
    pairs += [(base, others[random.integers(len(others))]), (others[random.integers(len(others))], platform)]
    pairs += [tuple(random.choice([*others, end], 2, replace=False)) for end in random.choice([base, platform], 3) if others[1:]]
    edges = [BodyEdge((a, b)) for a, b in pairs]
    passed = {edge: set() for edge in edges}
    for way in ways(edges, base, platform):
        for edge, forward in way:
            passed[edge].add(forward)
    found = {step.edge: step for step in directed_edges(edges, base, platform)}
    assert found.keys() == passed.keys()
    for edge, directions in passed.items():
        if len(directions) == 1:
            assert found[edge].inner is edge.ends[0 if directions == {True} else 1] and not found[edge].both_ways
        elif directions:
            assert found[edge].both_ways
    reached = [step.outer for step in found.values() if step.in_tree]  # the tree reaches every body but the platform once
    assert sorted(map(id, reached)) == sorted(id(body) for body in bodies if body not in (base, platform))


def test_reachable_yields_nodes_in_search_order():
    doubled = {1: [2, 3], 2: [4, 1], 3: [4, 5], 4: [], 5: [1], 6: [1]}
    assert list(reachable([1], doubled.__getitem__)) == [1, 2, 3, 4, 5]
    assert list(reachable([4, 6], doubled.__getitem__)) == [4, 6, 1, 2, 3, 5]
