"""Kinds of freedoms that do not move the platform, from the twists of the bodies."""

from types import SimpleNamespace

import numpy as np
import pytest

from kinetostatics.checks.local_freedoms import _kind, _links_of

LENGTH = 0.5


def kind(*twists, links=("a",)):
    """The kind of a motion of bodies with these twists about o: linear parts per ``LENGTH``, angular parts."""
    names = [chr(97 + k) for k in range(len(twists))]
    mechanism = SimpleNamespace(
        body_of={name: (k, None) for k, name in enumerate(names)}, connections={}, at_link=dict.fromkeys(names, ())
    )
    robot = SimpleNamespace(length=LENGTH, mechanism=mechanism, statics=SimpleNamespace(groups=()))
    motions = SimpleNamespace(robot=robot, o=np.zeros(3))
    return _kind(motions, links, list(range(len(twists))), np.array(twists, dtype=float)[:, :, None])


@pytest.mark.parametrize(
    ("twist", "expected"),
    [
        ((1, 0, 0, 0, 0, 0), "slide"), ((1, 0, 0, 0, 0, 0.9e-6), "slide"), ((1, 0, 0, 0, 0, 1.1e-6), "turn"),
        ((0, 0, 0, 0, 0, 1), "turn"), ((0, 3, 0, 0, 0, 1), "turn"), ((0, 3, 0.9e-6, 0, 0, 1), "turn"),
        ((0, 3, 1.1e-6, 0, 0, 1), "move"), ((0, 0, -0.1, 0, 0, 2), "move"), ((0, 0, -1e-5, 0, 0, -2), "move"),
    ],
)  # fmt: skip
def test_slides_turns_and_screws_differ_by_more_than_rounding(twist, expected):
    """A millionth: turning by it over the characteristic length, or sliding by it along the axis of a turn."""
    assert kind(twist) == (expected, None)


def test_bodies_that_move_differently_have_no_kind_in_common():
    turn = (0, 0, 0, 0, 0, 1.0)
    assert kind(turn, turn, links=("a", "b")) == ("turn", None)
    assert kind(turn, (0, 1e-3, 0, 0, 0, 1.0), links=("a", "b")) == ("move", None)
    assert kind(turn, (0, 1e-3, 0, 0, 0, 1.0), links=("a",)) == ("turn", None)


def test_massless_crosses_are_named_only_if_nothing_else_moves():
    links = {"cross": SimpleNamespace(mass=0.0), "rod": SimpleNamespace(mass=0.0), "arm": SimpleNamespace(mass=2.0)}
    description = SimpleNamespace(elastic_links={"rod": SimpleNamespace(link="rod")}, links=links)
    mechanism = SimpleNamespace(body_of={name: (k, None) for k, name in enumerate(links)})
    robot = SimpleNamespace(description=description, mechanism=mechanism)
    assert _links_of(robot, [0, 1, 2]) == ("rod", "arm") and _links_of(robot, [0]) == ("cross",)
    assert _links_of(robot, [0, 2]) == ("arm",) and _links_of(robot, [0, 1]) == ("rod",)
