"""Limbs with branches or rings, and hanging rings, against closed forms and other descriptions of the same robot."""

from dataclasses import replace

import numpy as np
import package_robots
import pytest
from simple_machines import AREA, RHO, STEM, E, bar, joint, link, loop, parallelogram, parallelogram_parts, robot, truss

import kinetostatics as ks
from kinetostatics.checks.check import diagnose

G = 10.0


def test_truss_of_three_bars_equals_closed_form():
    """K of a statically indeterminate truss: Σ EA/L e eᵀ over its bars (S. Timoshenko, Strength of Materials, part I)."""
    machine = truss()
    (limb,) = machine.topology.limbs
    assert not limb.is_serial and len(limb.to_platform) == 4 and sum(limb.to_platform) == 1
    assert [(part.start, part.end, part.is_serial) for part in limb.parts] == [("base", "pin", False), ("pin", "platform", True)]
    found = ks.analyze(machine.assemble(), load=(30, 0, -50, 0, 0, 0), gravity=(0, 0, 0))
    directions = [np.array([-x, 1]) / np.hypot(x, 1) for x in (-1, 0, 1)]
    stiffnesses = [E * AREA / np.hypot(x, 1) for x in (-1, 0, 1)]
    C = np.linalg.inv(sum(k * np.outer(e, e) for k, e in zip(stiffnesses, directions, strict=True)))
    stem = np.diag([STEM**3 / (3 * E * 1), STEM / (E * AREA)])
    np.testing.assert_allclose(found.compliance[np.ix_([0, 2], [0, 2])], C + stem, rtol=1e-9, atol=1e-20)
    shift = C @ [30, -50]
    np.testing.assert_allclose(found.part_contributions["limb_1"][0][[0, 2]], shift, rtol=1e-9)
    for k, (stiffness, e) in enumerate(zip(stiffnesses, directions, strict=True)):
        tension = stiffness * float(e @ shift)  # with which the base side pulls the bar down
        np.testing.assert_allclose(found.joint_wrenches[f"foot_{k}"][[0, 2]], -tension * e, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("q", [0.0, 0.3, -0.8])
def test_parallelogram_torque_equals_virtual_work(q):
    machine = parallelogram()
    assert str(machine.mobility) == "1"
    pose = machine.assemble(actuators={"foot_0": q})
    found = ks.analyze(pose, load=(7, 0, -11, 0, 0, 0), gravity=(0, 0, -G))
    crank = RHO * np.pi * 0.05**2 / 4
    # virtual work: every point of the table moves by (cos q, −sin q), of the cranks by half of it
    torque = -(7 * np.cos(q) + (11 + (4 + crank) * G) * np.sin(q))
    assert found.actuator_forces["foot_0"] == pytest.approx(torque, rel=1e-10, abs=1e-10)
    np.testing.assert_allclose(found.base_wrench[:3], [-7, 0, 11 + (4 + 2 * crank) * G], atol=1e-10)


def test_inner_ring_does_not_change_the_results():
    """A parallelogram with a platform welded to its coupler against one whose coupler is the platform."""
    plain = parallelogram()
    # two parallel revolute joints lock the separate platform to the coupler
    more = [
        link("plate"),
        joint("hinge", "continuous", "platform", "plate"),
        loop("lock", "revolute", "platform", "plate", "0.5 0 0", "0.5 0 0", "0 1 0"),
    ]
    machine = robot(*parallelogram_parts(), *more, platform="plate")
    poses = [item.assemble(actuators={"foot_0": 0.4}) for item in (plain, machine)]
    results = [ks.analyze(pose, load=(7, 2, -11, 0.3, 0.2, 0.1), gravity=(1, 2, -G)) for pose in poses]
    assert [len(item.topology.limbs) for item in (plain, machine)] == [2, 1]
    for name in ("twist", "compliance", "base_wrench"):
        mine, theirs = (getattr(result, name) for result in results)
        np.testing.assert_allclose(theirs, mine, rtol=1e-9, atol=1e-9 * np.abs(mine).max())
    for name in ("foot_0", "foot_1", "head_0", "head_1"):
        np.testing.assert_allclose(results[1].joint_wrenches[name], results[0].joint_wrenches[name], rtol=1e-8, atol=1e-7)
    assert results[1].limbs["limb_1"].constraint_wrenches.shape == (6, 6)


def test_part_contributions_add_up_to_the_twist():
    """A serial wrist on a parallelogram: two parts, the wrist a cantilever."""
    circle = '<circle diameter="0.05"/>'
    more = [link("wrist"), joint("flange", "fixed", "platform", "wrist", "0.25 0 0"), link("hand", 1.0)]
    more += [joint("grip", "fixed", "wrist", "hand", "0 0 0.4"), bar("wrist", "flange", "grip", RHO, circle)]
    machine = robot(*parallelogram_parts(), *more, platform="hand")
    (limb,) = machine.topology.limbs
    assert [(part.start, part.end, part.is_serial) for part in limb.parts] == [
        ("base", "platform", False),
        ("platform", "hand", True),
    ]
    result = ks.analyze(machine.assemble(actuators={"foot_0": 0.2}), load=(5, -4, 3, 2, 1, -2))
    parts = result.part_contributions["limb_1"]
    np.testing.assert_allclose(parts[0] + parts[1], result.twist, rtol=1e-10, atol=1e-16)
    wrist = ks.analyze(machine.assemble(actuators={"foot_0": 0.2}), load=(5, -4, 3, 2, 1, -2), gravity=(0, 0, 0))
    # the wrist alone: a cantilever
    I = np.pi * 0.05**4 / 64  # noqa: E741
    bent = wrist.part_contributions["limb_1"][1]
    assert bent[0] == pytest.approx(5 * 0.4**3 / (3 * E * I) + 1 * 0.4**2 / (2 * E * I), rel=1e-9)
    assert bent[5] == pytest.approx(-2 * 0.4 / (E / 2.6 * 2 * I), rel=1e-9)


def test_hanging_rings_equal_closed_forms():
    """A ring on the platform adds its weight; one on the base does not load the platform; both carry their own thrust."""
    circle = '<circle diameter="0.02"/>'

    def ring(on, name, at):
        parts = [link(f"{name}_{k}") for k in range(3)]
        parts += [joint(f"{name}_a", "continuous", on, f"{name}_0", at)]
        parts += [joint(f"{name}_b", "fixed", f"{name}_0", f"{name}_1", "0 0 -0.3")]
        parts += [joint(f"{name}_c", "fixed", f"{name}_1", f"{name}_2", "0.3 0 0")]
        x, y, z = (float(value) for value in at.split())
        parts += [loop(f"{name}_d", "revolute", f"{name}_2", on, "0 0 0.3", f"{x + 0.3} {y} {z}", "0 1 0")]
        parts += [
            bar(f"{name}_0", f"{name}_a", f"{name}_b", RHO, circle),
            bar(f"{name}_1", f"{name}_b", f"{name}_c", RHO, circle),
        ]
        return [*parts, bar(f"{name}_2", f"{name}_c", f"{name}_d", RHO, circle)]

    column = [link("base"), link("column"), link("platform", 1.0), joint("clamp", "fixed", "base", "column")]
    column += [joint("top", "fixed", "column", "platform", "0 0 1")]
    column += [bar("column", "clamp", "top", 0.0, '<circle diameter="0.1"/>')]
    machine = robot(*column, *ring("platform", "swing", "0.1 0 0"), *ring("base", "frame", "0.5 0 0"))
    assert sorted(limb.name for limb in machine.topology.hanging) == ["base", "platform"]
    found = ks.analyze(machine.assemble(), gravity=(0, 0, -G))
    ring_mass = RHO * 0.9 * np.pi * 0.02**2 / 4
    area = np.pi * 0.1**2 / 4
    assert found.platform_wrench[2] == pytest.approx(-(1 + ring_mass) * G, rel=1e-12)
    assert found.platform_wrench[4] == pytest.approx(0.25 * ring_mass * G, rel=1e-12)
    assert found.twist[2] == pytest.approx(-(1 + ring_mass) * G / (E * area), rel=1e-10)
    assert found.base_wrench[2] == pytest.approx((1 + 2 * ring_mass) * G, rel=1e-12)
    # a portal on two hinges, symmetric: each foot carries half, and both push inwards with equal force
    left, right = (found.joint_wrenches[f"frame_{end}"] for end in "ad")
    assert left[2] == pytest.approx(ring_mass * G / 2, rel=1e-9)
    assert abs(right[2]) == pytest.approx(ring_mass * G / 2, rel=1e-9)
    portal_force = thrust()
    assert abs(left[0]) == pytest.approx(portal_force, rel=1e-9)
    # the swing hangs the same way, carried along with the platform
    assert abs(found.joint_wrenches["swing_a"][0]) == pytest.approx(portal_force, rel=1e-9)


def thrust(h=0.3, b=0.3, d=0.02):
    """Horizontal thrust of a U of three equal welded bars, hinged at both tops, under its own weight, by the force method.

    Bending and stretching of all bars, no shear. X acts at the hinges along x, outwards on the U.
    """
    area, inertia = np.pi * d**2 / 4, np.pi * d**4 / 64
    q = RHO * area * G
    # unit X: moment s in the legs (from the hinge), h in the bottom bar; axial force 1 in the bottom bar
    flexibility = 2 * h**3 / (3 * E * inertia) + b * h**2 / (E * inertia) + b / (E * area)
    # the weight bends the bottom bar as one on two supports: q x (b − x) / 2
    bending = h * q * b**3 / 12 / (E * inertia)
    return bending / flexibility


def rigid_cranks(mass):
    """Base, platform and two rigid cranks of 1 kg, of which the first is actuated."""
    parts = [link("base"), link("platform", mass), '<transmission name="t"><joint name="foot_0"/></transmission>']
    for k, x in enumerate((0.0, 0.5)):
        parts += [link(f"crank_{k}", 1.0, "0 0 0.5"), joint(f"foot_{k}", "continuous", "base", f"crank_{k}", f"{x} 0 0")]
    return parts


def test_inner_forces_of_rigid_rings_are_indeterminate():
    """A rigid parallelogram of hinges has three redundant constraints, on which the twist does not depend."""
    parts = rigid_cranks(4.0)
    parts += [link("coupler"), joint("head_0", "continuous", "crank_0", "coupler", "0 0 1")]
    parts += [loop("head_1", "revolute", "crank_1", "coupler", "0 0 1", "0.5 0 0", "0 1 0")]
    parts += [
        link("column"),
        joint("flange", "fixed", "coupler", "column", "0.25 0 0"),
        joint("top", "fixed", "column", "platform", "0 0 1"),
    ]
    parts += [bar("column", "flange", "top", 0.0, '<circle diameter="0.1"/>')]
    machine = robot(*parts)
    assert machine.mobility.redundant_constraints == 3
    found = ks.analyze(machine.assemble(actuators={"foot_0": 0.5}), load=(0, 0, -20, 0, 0, 0), gravity=(0, 0, -G))
    assert found.status == ks.Status.INDETERMINATE
    words = [text for text in found.warnings if "the rigid rings in limb_1 (" in text]
    assert len(words) == 1 and "overconstrain one another" not in words[0] and "foot_1" in words[0]
    assert words[0] in diagnose(machine).warnings
    assert np.all(np.isnan(found.joint_wrenches["head_0"])) and np.all(np.isnan(found.joint_wrenches["foot_1"]))
    assert np.all(np.isfinite(found.joint_wrenches["flange"]))
    assert found.twist[2] == pytest.approx(-(20 + 40) / (E * np.pi * 0.1**2 / 4), rel=1e-10)


@pytest.mark.parametrize("q", [0.0, 0.4, -0.9])
def test_actuator_forces_of_rigid_overconstrained_robots_are_determinate(q):
    """Virtual work determines the torque; the forces in the bearings are indeterminate."""
    parts = rigid_cranks(2.0)
    parts += [joint("head_0", "continuous", "crank_0", "platform", "0 0 1")]
    parts += [loop("head_1", "revolute", "crank_1", "platform", "0 0 1", "0.5 0 0", "0 1 0")]
    machine = robot(*parts)
    found = ks.analyze(machine.assemble(actuators={"foot_0": q}), load=(3, 0, 0, 0, 0, 0), gravity=(0, 0, -G))
    assert found.status == ks.Status.INDETERMINATE and np.all(np.isnan(found.joint_wrenches["head_0"]))
    torque = -(3 * np.cos(q) + (2 * G + 2 * 1.0 * G / 2) * np.sin(q))
    assert found.actuator_forces["foot_0"] == pytest.approx(torque, rel=1e-9)


def test_a_beam_between_welded_points_is_refused():
    """The last piece of a polyline starts at its first joint, so that a piece between lies within one rigid piece."""
    description = package_robots.robot("spherical_3rrr").description
    last = description.beams["proximal_2_3"]
    with pytest.raises(ks.RobotFileError, match=r"proximal_2_2.*fixed to the same rigid piece"):
        ks.Robot(description.with_part(replace(last, start=description.beams["proximal_2_1"].start)))
