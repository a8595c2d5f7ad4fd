"""Which way is out: directions of the edges of small networks that a reader can follow with a finger."""

from itertools import combinations

import pytest

from kinetostatics.mechanism import edge_directions
from kinetostatics.mechanism.edge_directions import directed_edges, segments_between_cuts
from kinetostatics.mechanism.rigid_bodies import BodyEdge, RigidBody


class Network:
    """Rigid bodies named by letters, ``0`` the base and ``1`` the platform; edges as pairs of letters, from inner to outer."""

    def __init__(self, *edges: str, beams: str = "") -> None:
        names = sorted({letter for edge in edges for letter in edge} | {"0", "1"})
        self.named = {letter: RigidBody(letter) for letter in names}
        self.base, self.platform = self.named["0"], self.named["1"]
        self.edges = [BodyEdge(self.named[a], self.named[b], beam="a beam" if a + b in beams.split() else None) for a, b in edges]
        self.bodies = [body for name, body in self.named.items() if name not in "01"]

    def steps(self):
        return directed_edges(self.bodies, self.edges, self.base, self.platform)

    def read(self):
        """Return the steps in words: ``ab``, ``~`` before those of both ways, ``-`` behind those not of the tree."""
        return [
            "~" * step.both_ways + step.inner.link + step.outer.link + "-" * (not step.in_tree and step.outer.link != "1")
            for step in self.steps()
        ]

    def back(self, *known):
        """Return the edges that the search finds to be passed back, all but ``known`` taken as they are written."""
        inner = {edge: edge.inner for edge in self.edges}
        known = {edge for edge in self.edges if edge.inner.link + edge.outer.link in known}
        found = edge_directions._passed_back(inner, known, self.base, self.platform)
        return sorted(edge.inner.link + edge.outer.link for edge in found)


def test_a_chain_is_one_way_however_its_joints_are_written():
    assert Network("0a", "ab", "b1").read() == Network("a0", "ba", "1b").read() == ["0a", "ab", "b1"]
    assert Network("b1", "ab", "0a").read() == ["0a", "ab", "b1"]
    assert Network("01").read() == ["01"]


def test_only_the_bridge_is_passed_both_ways():
    bridge = ("0a", "0b", "ab", "a1", "b1")
    assert Network(*bridge).read() == ["0a", "~ab-", "a1", "0b", "b1"]
    assert Network("0a", "0b", "ab", "a1", "b1", "1c", "c0").read()[-2:] == ["0c", "c1"]
    assert Network(*bridge).back() == ["ab"] and Network(*bridge).back("ab") == []


def test_a_ring_in_a_chain_has_one_direction():
    assert Network("0a", "ab", "ac", "bd", "cd", "d1").read() == ["0a", "ab", "bd", "d1", "ac", "cd-"]
    assert Network("0a", "ab", "ac", "bd", "cd", "d1").back() == []
    # the tree prefers beams where two edges end at one body
    assert Network("0a", "ab", "ac", "bd", "cd", "d1", beams="cd").read() == ["0a", "ab", "bd-", "ac", "cd", "d1"]


def test_what_leads_nowhere_points_away():
    assert Network("0a", "a1", "ba", "bc").read() == ["0a", "a1", "ab", "bc"]
    # a ring that hangs on the chain: its edges have no direction of their own
    assert Network("0a", "a1", "ab", "bc", "ca").read() == ["0a", "a1", "~ab", "~bc-", "~ac"]
    # one beyond a joint: the joint points away, the ring has none
    assert Network("0a", "a1", "ab", "bc", "cd", "db").read() == ["0a", "a1", "ab", "~bc", "~cd-", "~bd"]


def test_a_component_without_the_base_begins_at_the_platform():
    assert Network("ab", "b1").read() == ["1b", "ba"]
    assert Network("0a", "ab").read() == ["0a", "ab"]


def test_the_rungs_of_a_ladder_are_passed_both_ways():
    ladder = Network("0a", "0b", "ab", "ac", "bd", "cd", "ce", "df", "ef", "e1", "f1")
    assert ladder.back() == ["ab", "cd", "ef"]
    assert {step.edge for step in ladder.steps() if step.both_ways} == {ladder.edges[2], ladder.edges[5], ladder.edges[8]}


@pytest.mark.parametrize(("cluster", "found"), [("pqrstu", ["ab"]), ("pqrstuv", [])])
def test_the_search_gives_up_in_large_networks(cluster, found):
    """Bodies joined each to each, that hang on the base and are looked at first: 6 have 326 ways through them, 7 have 1957."""
    dense = [a + b for a, b in combinations(cluster, 2)]
    assert Network("0a", "0b", "ab", "a1", "b1", *dense, "0p").back() == found


@pytest.mark.parametrize(("count", "found"), [(120, ["ab"]), (121, [])])
def test_the_search_is_for_limbs_of_an_ordinary_size(count, found):
    chain = [chr(k) + chr(k + 1) for k in range(1000, 1000 + count - 6)]
    assert Network("0a", "0b", "ab", "a1", "b1", "0" + chr(1000), *chain).back() == found


def test_cuts_are_what_every_way_passes():
    network = Network("0a", "ab", "ac", "bd", "cd", "d1")
    found = [
        (inner.link, outer.link, [step.inner.link + step.outer.link for step in steps])
        for inner, outer, steps in segments_between_cuts(network.steps(), network.base, network.platform)
    ]
    assert found == [("0", "a", ["0a"]), ("a", "d", ["ab", "bd", "ac", "cd"]), ("d", "1", ["d1"])]
    hanging = Network("ab", "b1")
    assert segments_between_cuts(hanging.steps(), hanging.base, hanging.platform) == []
