"""Robots built by name: for any sizes they load, close, have the known mobility, and pass ``check`` and ``verify``."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import kinetostatics as ks
from kinetostatics.authoring.by_name import robot_text
from kinetostatics.authoring.notation import parse_architecture
from kinetostatics.checks.check import diagnose
from kinetostatics.files.reader import parse_robot_text

#: Architectures with the freedoms of their platforms: by Grübler's formula, less spins of rods; of overconstrained ones as the
#: textbooks have them (X. Kong, C. Gosselin, Type Synthesis of Parallel Mechanisms, Springer 2007).
MOBILITIES = {
    "3-RPS": 3,
    "3-R[P]S": 3,
    "3-[R]RS": 3,
    "3-[P]RS": 3,
    "3-S[P]R": 3,
    "2-[P]RU+U[P]R": 3,
    "2-U[P]R+S[P]R": 3,
    "3-U[P]U": 3,
    "3-[P]UU": 3,
    "3-[R]UU": 3,
    "3-[R](4S)": 3,
    "3-[P](4S)": 3,
    "4-[R]2(SS)": 3,
    "3-U[P]S+UP": 3,
    "3-U[P]S+S": 3,
    "6-U[P]S": 6,
    "6-S[P]S": 6,
    "6-[R]US": 6,
    "6-[P]US": 6,
    "3-[R]RR planar": 3,
    "3-R[P]R planar": 3,
    "3-[P]RR planar": 3,
    "3-[R]RR spherical": 3,
    "3-[P]RRR cartesian": 3,
    "3-[C]RR cartesian": 3,
    "3-[P]R(4R)R cartesian": 3,
}
SIZES = st.fixed_dictionaries(
    {
        "base_radius": st.floats(0.25, 0.6),
        "platform_radius": st.floats(0.05, 0.2),
        "height": st.floats(0.3, 0.9),
        "hangs": st.booleans(),
    }
)


def build(key, sizes):
    """Return the robot of a row of the table."""
    architecture, _, arrangement = key.partition(" ")
    sizes, hangs = dict(sizes), sizes["hangs"]
    del sizes["hangs"]
    if arrangement:
        sizes["arrangement"] = arrangement
        del sizes["height"]
    elif hangs:
        sizes["height"] *= -1
    return ks.new_robot(architecture, **sizes)


@given(st.sampled_from(sorted(MOBILITIES)), SIZES)
def test_named_robot_of_any_size_closes_with_known_mobility(key, sizes):
    robot = build(key, sizes)
    assert robot.closing_error < 1e-12
    assert robot.mobility.platform == MOBILITIES[key]
    assert len(robot.description.actuated) == parse_architecture(key.partition(" ")[0]).actuators >= MOBILITIES[key]
    assert not diagnose(robot).problems
    assert ks.analyze(robot.assemble()).status == ks.Status.OK


@settings(max_examples=settings.default.max_examples // 2)
@given(st.sampled_from(sorted(MOBILITIES)), SIZES, st.floats(0.7, 1.3))
def test_named_robot_stays_closed_with_other_parameters(key, sizes, factor):
    """The parameters of the written file determine its whole geometry."""
    architecture, _, arrangement = key.partition(" ")
    text = robot_text(architecture, **({"arrangement": arrangement} if arrangement else {}))
    changed = {"platform_radius": sizes["platform_radius"], "base_radius": 0.3 * factor}
    if not arrangement:
        changed["height"] = 0.5 * factor
    robot = ks.Robot(parse_robot_text(text, parameters=changed))
    assert robot.closing_error < 1e-12 and robot.mobility.platform == MOBILITIES[key]
    assert np.isfinite(ks.analyze(robot.assemble()).twist).all()


@pytest.mark.parametrize("key", ["3-RPS", "3-[P]R(4R)R cartesian"])
def test_named_robot_agrees_with_finite_elements(key):
    robot = build(key, {"base_radius": 0.3, "platform_radius": 0.12, "height": 0.5, "hangs": True})
    assert ks.verify(robot.assemble(), load=[10, -20, 30, 1, 2, -3]).verified
