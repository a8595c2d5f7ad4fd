"""Statics of every type of loop against closed forms, independent of where the file cuts."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from loop_robots import DENSITY, E_MODULUS, FREEDOMS, GRAVITY, ONE_FREEDOM, Held, cuts, frame, joint, loop, robot, shift

import kinetostatics as ks

seeds = st.integers(0, 2**32 - 1)
LOAD = np.array([120.0, -310, -450, 41, -23, 17])


def near(found, expected, rel=1e-8):
    """To ``rel`` of the largest entry: lengths are of the order of 1 m here, so that forces and moments compare."""
    np.testing.assert_allclose(found, expected, rtol=0, atol=rel * np.abs(expected).max())


@pytest.mark.few(3)
@pytest.mark.parametrize("kind", FREEDOMS)
@given(data=st.data())
def test_cantilever_held_by_any_loop_matches_closed_form(kind, data):
    """Twist, joint wrenches and forces in closed form, over the joint's range, in every cut, from either side."""
    cut, swap = data.draw(st.sampled_from(cuts(kind))), data.draw(st.booleans())
    drive = data.draw(st.sampled_from(("chain", "closing"))) if kind in ONE_FREEDOM else "chain"
    seed = data.draw(seeds)
    held = Held(kind, seed, cut, swap and cut != "weld", drive, right=data.draw(st.booleans()))
    q = held.random_q(np.random.default_rng(seed + 1))
    found = ks.analyze(held.robot().assemble(actuators=held.actuators(q)), LOAD, gravity=GRAVITY)
    assert found.status == ks.Status.OK
    expected = held.statics(q, LOAD)
    near(found.twist, expected.twist)
    for name, wrench in expected.wrenches.items():
        near(found.joint_wrenches[name], wrench)
    if drive == "chain":
        for name, force in zip(held.names, expected.chain_forces, strict=True):
            assert found.actuator_forces[name] == pytest.approx(force, rel=1e-9, abs=1e-7)
    else:
        assert found.actuator_forces["closing"] == pytest.approx(expected.loop_force, rel=1e-9, abs=1e-7)


# ---- the textbook's propped beams ------------------------------------------------------------------------------------------

LENGTH, DIAMETER = 0.8, 0.04
BEAM = (
    f'youngs_modulus="{E_MODULUS}" poisson_ratio="0.3" shear_coefficient="inf" density="{DENSITY}">'
    f'<circle diameter="{DIAMETER}"/></beam>'
)
#: Axes; the reaction at the tip in w L, its moment about y in w L², the tip's deflection in w L⁴/EI, its slope in w L³/EI,
#: for a cantilever along x that a joint to the ground holds at its tip, under its weight w per length along −z.
PROPPED_CASES = [
    ("spherical", {}, 3 / 8, 0, 0, -1 / 48),
    ("universal", {"axis": (1, 0, 0), "axis2": (0, 1, 0)}, 3 / 8, 0, 0, -1 / 48),
    ("universal", {"axis": (0, 0, 1), "axis2": (0, 1, 0)}, 3 / 8, 0, 0, -1 / 48),
    ("universal", {"axis": (1, 0, 0), "axis2": (0, 0, 1)}, 1 / 2, 1 / 12, 0, 0),
    ("revolute", {"axis": (0, 1, 0)}, 3 / 8, 0, 0, -1 / 48),
    ("continuous", {"axis": (0, -1, 0)}, 3 / 8, 0, 0, -1 / 48),
    ("revolute", {"axis": (1, 0, 0)}, 1 / 2, 1 / 12, 0, 0),
    ("continuous", {"axis": (0, 0, 1)}, 1 / 2, 1 / 12, 0, 0),
    ("prismatic", {"axis": (1, 0, 0)}, 1 / 2, 1 / 12, 0, 0),
    ("prismatic", {"axis": (0, 1, 0)}, 1 / 2, 1 / 12, 0, 0),
    ("prismatic", {"axis": (0, 0, 1)}, 0, -1 / 6, -1 / 24, 0),
    ("cylindrical", {"axis": (1, 0, 0)}, 1 / 2, 1 / 12, 0, 0),
    ("cylindrical", {"axis": (0, 1, 0)}, 3 / 8, 0, 0, -1 / 48),
    ("cylindrical", {"axis": (0, 0, 1)}, 0, -1 / 6, -1 / 24, 0),
    ("planar", {"axis": (0, 0, 1)}, 1 / 2, 1 / 12, 0, 0),
    ("planar", {"axis": (1, 0, 0)}, 0, -1 / 6, -1 / 24, 0),
    ("planar", {"axis": (0, 1, 0)}, 0, 0, -1 / 8, 1 / 6),
]


@pytest.mark.few(12)
@pytest.mark.parametrize("swap", [False, True])
@pytest.mark.parametrize(("kind", "axes", "force", "moment", "sag", "slope"), PROPPED_CASES)
def test_propped_cantilevers_match_textbook_reactions(kind, axes, force, moment, sag, slope, swap):
    tip = shift([LENGTH, 0, 0])
    if swap and kind == "universal":
        axes = {"axis": axes["axis2"], "axis2": axes["axis"]}
    sides = ("platform", np.eye(4), "base", tip) if swap else ("base", tip, "platform", np.eye(4))
    one = robot(
        joint("root", "fixed", "base", "arm", np.eye(4)),
        joint("tip", "fixed", "arm", "platform", tip),
        loop(kind, *sides, **axes),
        f'<beam link="arm" from="root" to="tip" {BEAM}',
        links=("base", "arm", "platform"),
    )
    g = 9.8
    area, bending = np.pi * DIAMETER**2 / 4, np.pi * DIAMETER**4 / 64
    w, EI = DENSITY * area * g, E_MODULUS * bending
    found = ks.analyze(one.assemble(), gravity=(0, 0, -g))
    assert found.status == ks.Status.OK
    L = LENGTH
    reaction = np.array([0, 0, force * w * L, 0, moment * w * L**2, 0])
    np.testing.assert_allclose(found.joint_wrenches["closing"], reaction, rtol=0, atol=1e-9 * w * L)
    twist = np.array([0, 0, sag * w * L**4 / EI, 0, slope * w * L**3 / EI, 0])
    np.testing.assert_allclose(found.twist, twist, rtol=0, atol=1e-10 * w * L**3 / EI)
    # the wall carries the rest of the weight and its moment
    root = found.joint_wrenches["root"]
    expected = np.array([0, 0, w * L * (1 - force), 0, -w * L**2 / 2 + force * w * L**2 - moment * w * L**2, 0])
    np.testing.assert_allclose(root, expected, rtol=0, atol=1e-9 * w * L)


def test_fixed_loop_clamps_the_far_end_of_a_beam():
    """The platform in the middle: w (2L)⁴/384 EI, clamping moments w (2L)²/12."""
    L, g = LENGTH, 9.8
    area, bending = np.pi * DIAMETER**2 / 4, np.pi * DIAMETER**4 / 64
    w, EI = DENSITY * area * g, E_MODULUS * bending
    far = frame(np.array([[0, 1.0, 0], [0, 0, 1], [1, 0, 0]]), [2 * L, 0, 0])
    one = robot(
        joint("root", "fixed", "base", "near", np.eye(4)),
        joint("left", "fixed", "near", "platform", shift([L, 0, 0])),
        joint("right", "fixed", "platform", "far", np.eye(4)),
        loop("fixed", "base", far, "far", shift([-L, 0, 0]) @ far),
        f'<beam link="near" from="root" to="left" {BEAM}<beam link="far" from="closing" to="right" {BEAM}',
        links=("base", "near", "platform", "far"),
    )
    found = ks.analyze(one.assemble(), gravity=(0, 0, -g))
    assert found.twist == pytest.approx([0, 0, -w * (2 * L) ** 4 / (384 * EI), 0, 0, 0], abs=1e-10 * w * L**4 / EI)
    clamp = found.joint_wrenches["closing"]
    assert clamp == pytest.approx([0, 0, w * L, 0, w * (2 * L) ** 2 / 12, 0], abs=1e-9 * w * L)
