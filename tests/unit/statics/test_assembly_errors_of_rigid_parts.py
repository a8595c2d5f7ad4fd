"""What rigid parts and what hangs do with assembly errors and weights: contradictions are NaN, everything else is a number."""

from dataclasses import replace

import numpy as np
import pytest
from odd_robots import parsed, rigid_limbs, written
from package_robots import robot
from simple_machines import RHO, bar, joint, link, mount, springs, two_columns

import kinetostatics as ks

STILL = (0, 0, 0)
Y = (0.0, 1.0, 0.0)
CIRCLE = '<circle diameter="0.02"/>'


@pytest.mark.parametrize("size", [1e-3, 1e-9])
def test_rigid_limbs_cannot_follow_an_error_across_their_plane(size):
    """A rigid planar four-bar linkage: its two limbs both hold the platform in the plane."""
    pose = rigid_limbs().assemble()
    across = ks.analyze(pose, gravity=STILL, assembly_errors={"other_head": [0, size, 0, 0, 0, 0]}, on_failure="nan")
    assert np.isnan(across.twist).any() and across.indeterminate
    assert np.isnan(across.contributions["assembly_errors"]).any() and np.isfinite(across.contributions["load"]).all()


def test_contradictions_are_complained_of():
    assembly_errors = {"other_head": [0, 1e-3, 0, 0, 0, 0], "foot": [1e-3, 0, 0, 0, 0, 0]}
    with pytest.raises(ks.StaticsError, match="the assembly errors of foot, other_head contradict one another in rigid parts"):
        ks.analyze(rigid_limbs().assemble(), gravity=STILL, assembly_errors=assembly_errors)


def test_rigid_limbs_follow_an_error_in_their_plane():
    """The far rod is too long by 1 mm: the locked crank's head stays, the coupler turns about it."""
    pose = rigid_limbs().assemble()
    head, far, foot = np.array([0, 0, 0.5]), np.array([0.5, 0, 0.6]), np.array([0.4, 0, 0.0])
    along = (far - foot) / np.linalg.norm(far - foot)
    found = ks.analyze(pose, gravity=STILL, assembly_errors={"other_head": [*(1e-3 * along), 0, 0, 0]}, on_failure="nan")
    turn = 1e-3 / (np.cross(Y, far - head) @ along)
    o = np.array([0.2, 0, 0.5])
    np.testing.assert_allclose(found.twist[3:], [0, turn, 0], rtol=1e-9, atol=1e-15)
    np.testing.assert_allclose(found.twist[:3], turn * np.cross(Y, o - head), rtol=1e-9, atol=1e-15)


def ring(stem=True):
    """A slide that carries a rigid parallelogram and, on it, an elastic or rigid stem; the platform stays in a plane."""
    edges = [
        ("slide", "P", (0, 0, 0), "base", "slider", {"axis": (0, 0, 1), "driven": True}),
        ("left_foot", "R", (-0.3, 0, 0), "slider", "left", {"axis": Y}),
        ("right_foot", "R", (0.3, 0, 0), "slider", "right", {"axis": Y}),
        ("left_head", "R", (-0.3, 0, 0.5), "left", "coupler", {"axis": Y}),
        ("right_head", "R", (0.3, 0, 0.5), "right", "coupler", {"axis": Y}),
        ("stem_foot", "F", (0, 0, 0.5), "coupler", "stem", {}),
        ("stem_head", "F", (0, 0, 0.9), "stem", "platform", {}),
        ("pin", "E", (0, 0, 0.9), "base", "platform", {"axis": (1.0, 0, 0)}),
    ]  # fmt: skip
    beams = [("stem", "stem_foot", "stem_head", {})] if stem else []
    return parsed(written(edges, beams, {"right_head", "pin"}, o=(0, 0, 0.9), name="ring"))


@pytest.mark.parametrize("stem", [True, False])
def test_rigid_rings_cannot_follow_errors_across_their_plane(stem):
    """Nor where the whole limb is rigid."""
    pose = ring(stem).assemble()
    found = ks.analyze(pose, gravity=STILL, assembly_errors={"right_head": [0, 1e-3, 0, 0, 0, 0]}, on_failure="nan")
    assert np.isnan(found.contributions["assembly_errors"]).any() and np.isfinite(found.contributions["load"]).all()
    # both hinges of one rod too far out by as much: it only stands elsewhere
    found = ks.analyze(
        pose,
        gravity=STILL,
        assembly_errors={"right_head": [0, -1e-3, 0, 0, 0, 0], "right_foot": [0, 1e-3, 0, 0, 0, 0]},
        on_failure="nan",
    )
    assert np.isfinite(found.twist).all()


def test_what_hangs_on_the_platform_is_the_platform_s():
    """Its weight belongs to the platform's, its assembly errors move it alone, its beam bends by its own weight."""
    parts = [
        link("arm"), joint("clamp", "fixed", "platform", "arm", "0.2 0 0"), link("lamp", 2.0),
        joint("hook", "fixed", "arm", "lamp", "0.3 0 0"), bar("arm", "clamp", "hook", RHO, CIRCLE),
    ]  # fmt: skip
    machine = mount(springs("mount", linear="1e5 1e5 1e5", angular="1e4 1e4 1e4"), *parts)
    found = ks.analyze(
        machine.assemble(),
        (1, 2, 3, 0, 0, 0),
        (0, 0, -10),
        assembly_errors={"hook": [0, 1e-3, 0, 0, 0, 2e-3], "arm": {"length": 5e-4}},
    )
    lamp = found.link_contributions["lamp"]
    E, inertia, area = 2.0e11, np.pi * 0.02**4 / 64, np.pi * 0.02**2 / 4
    q, L, P = RHO * area * 10, 0.3, 20.0
    sag, slope = (
        P * L**3 / (3 * E * inertia) + q * L**4 / (8 * E * inertia),
        P * L**2 / (2 * E * inertia) + q * L**3 / (6 * E * inertia),
    )
    rigid = {name: found.contributions[name].copy() for name in lamp}
    for twist in rigid.values():
        twist[:3] += np.cross(twist[3:], [0.5, 0, 0])
    np.testing.assert_allclose(
        lamp["platform_weight"] - rigid["platform_weight"], [0, 0, -sag, 0, slope, 0], rtol=1e-8, atol=1e-16
    )
    np.testing.assert_allclose(lamp["load"], rigid["load"], rtol=1e-12, atol=1e-18)
    np.testing.assert_allclose(lamp["assembly_errors"], [5e-4, 1e-3, 0, 0, 0, 2e-3], rtol=1e-12, atol=1e-18)
    np.testing.assert_allclose(found.contributions["assembly_errors"], 0, atol=1e-18)
    line = found.beams["arm"]
    parts = found.beam_contributions["arm"]
    np.testing.assert_allclose(parts["assembly_errors"][-1], [5e-4, 0, 0, 0, 0, 0], rtol=1e-12, atol=1e-18)
    np.testing.assert_allclose(parts["assembly_errors"][10], [2.5e-4, 0, 0, 0, 0, 0], rtol=1e-12, atol=1e-18)
    np.testing.assert_allclose(line.section_wrenches[0][[2, 4]], [-(P + q * L), (P * L + q * L**2 / 2)], rtol=1e-9)


@pytest.mark.few(1)
@pytest.mark.parametrize("rigid", [("bar_1a", "bar_1b"), ("bar_1b", "bar_2b", "bar_3a", "bar_3b")])
def test_where_forces_are_undetermined_the_twist_is_that_of_stiff_parts(rigid):
    """An orthoglide, some of whose rods are rigid: as if these were a million times stiffer than the others."""
    description = robot("orthoglide").description
    stiff = {name: replace(beam.material, youngs_modulus=7e16, density=0.0) for name, beam in description.beams.items()}
    ends = {name: replace(description.beams[name], material=stiff[name]) for name in rigid}
    one = ks.Robot(replace(description, beams={name: beam for name, beam in description.beams.items() if name not in rigid}))
    other = ks.Robot(replace(description, beams={**description.beams, **ends}))
    at = dict(zip(description.driven, [[0.0, 0.01, 0.013], [0.0, -0.01, -0.004], [0.0, 0.01, 0.02]], strict=True))
    load = [10, -20, -30, 1, 2, 3]
    found, wanted = (ks.analyze(robot.assemble(actuators=at), load) for robot in (one, other))
    assert (found.status == ks.Status.INDETERMINATE).all()
    np.testing.assert_allclose(found.twist, wanted.twist, rtol=1e-4, atol=2e-9)


def test_warmth_needs_a_thermal_expansion():
    pose = two_columns(warm=False).assemble()
    with pytest.raises(ks.ArgumentError, match=r"beam 'a' has no thermal_expansion"):
        ks.analyze(pose, gravity=STILL, assembly_errors={"a": {"temperature": [0.0, 20.0]}})
    assert ks.analyze(pose, gravity=STILL, assembly_errors={"a": {"temperature": 0.0, "length": 1e-4}}).twist[2] > 0
