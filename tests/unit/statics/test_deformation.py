"""Displacements and forces of beams and networks do not depend on the description; free rotations; singularity of networks."""

import numpy as np
import pytest
from simple_machines import CIRCLE, RHO, bar, joint, link, loop, mount, robot, truss

import kinetostatics as ks
from kinetostatics.results.warnings import near_singularity

LOAD = np.array([30.0, -20.0, 50.0, 4.0, -3.0, 2.0])
CORNERS = {"base": (0, 0, 0), "n": (0.5, 0, 0.4), "m": (-0.5, 0.1, 0.4), "platform": (0.1, 0, 0.8)}


def cross_brace(*bridge, motion=None):
    """A frame of five clamped beams; the one between its two corners ``n`` and ``m`` is written from one to the other.

    Its foot turns about an axis through the base, with a ``motion``.
    """
    parts = [link("ground"), joint("turn", "revolute", "ground", "base", axis="0.2 1 0.1")]
    parts += ['<transmission name="t"><joint name="turn"/></transmission>']
    parts += [link("base"), link("n", 1.0), link("m"), link("platform", 3.0)]
    sides = [("a", "base", "n"), ("b", "base", "m"), ("c", "n", "platform"), ("d", "m", "platform"), ("e", *bridge)]
    known = {"base"}
    for name, inner, outer in sides:
        along = np.subtract(CORNERS[outer], CORNERS[inner])
        text = " ".join(map(str, along.tolist()))
        parts += [link(name), joint(f"{name}_1", "fixed", inner, name)]
        if outer in known:
            parts += [loop(f"{name}_2", "fixed", name, outer, text)]
        else:
            parts += [joint(f"{name}_2", "fixed", name, outer, text)]
        known.add(outer)
        parts += [bar(name, f"{name}_1", f"{name}_2", RHO, CIRCLE).replace('y_axis="0 1 0"', 'y_axis="0.3 1 0.2"')]
    machine = robot(*parts)
    return ks.analyze(machine.configuration(np.tile(machine.assemble().q, (3, 1))), LOAD, motion=motion)


@pytest.mark.parametrize("motion", [None, ks.Motion({"turn": 6.0}, {"turn": 90.0})])
def test_bridge_beam_does_not_depend_on_its_written_direction(motion):
    """Its stations come in the other order, with the same displacements and the opposite section wrenches."""
    one, other = cross_brace("n", "m", motion=motion), cross_brace("m", "n", motion=motion)
    np.testing.assert_allclose(other.twist, one.twist, rtol=1e-9)
    there, back = one.beams["e"], other.beams["e"]
    for what in ("points", "deflections", "rotations"):
        assert getattr(back, what).shape == getattr(there, what).shape == (3, 21, 3)
        np.testing.assert_allclose(getattr(back, what), getattr(there, what)[:, ::-1], rtol=1e-8, atol=1e-15)
    in_world = [(beam.section_wrenches[0].reshape(-1, 2, 3) @ beam.axes[0].T).reshape(-1, 6) for beam in (there, back)]
    np.testing.assert_allclose(in_world[1], -in_world[0][::-1], rtol=1e-7, atol=1e-8)
    tension = [beam.section_wrenches[:, :, 0] for beam in (there, back)]
    assert tension[0].shape == tension[1].shape == (3, 21)
    np.testing.assert_allclose(tension[1], tension[0][:, ::-1], rtol=1e-7)
    for name, same in (("e_1", "e_2"), ("e_2", "e_1")):
        np.testing.assert_allclose(np.abs(other.joint_wrenches[name][:, :3]), np.abs(one.joint_wrenches[same][:, :3]), rtol=1e-7)


def test_forces_are_the_sums_of_their_contributions():
    found = cross_brace("n", "m")
    for name, beam in found.beams.items():
        parts = found.axial_contributions[name]
        np.testing.assert_allclose(sum(parts.values()), beam.section_wrenches[:, -1, 0], rtol=1e-9)
        assert max(np.abs(part).max() for part in parts.values()) > 1e-3
    for name, wrench in found.joint_wrenches.items():
        parts = found.joint_contributions[name]
        np.testing.assert_allclose(sum(parts.values()), wrench, rtol=1e-8, atol=1e-8)
        assert "load" in parts and len(parts) > 2


GRAVITY = np.array([3.0, -2.0, -9.0])


@pytest.mark.parametrize("bridge", [("n", "m"), ("m", "n")])
def test_split_axial_force_of_a_bridge_equals_that_of_the_joint_at_its_end(bridge):
    split = ks.analyze(cross_brace(*bridge).robot.assemble(), LOAD, GRAVITY).by_mechanism
    along = split.beams["e"].axes[:, 0]
    for source, force in split.axial_contributions["e"].items():
        assert force == pytest.approx(-along @ split.joint_contributions["e_2"][source][:3], abs=1e-8)


def test_split_axial_force_of_an_open_branch_is_the_weight_that_it_carries():
    """Its deformation under its weight has no axial force of its own; the arm points downwards."""
    machine = robot(
        link("base"), link("mast"), link("platform", 3.0), joint("foot", "fixed", "base", "mast"),
        joint("top", "fixed", "mast", "platform", "0 0 0.6"), bar("mast", "foot", "top", RHO, CIRCLE),
        link("arm"), link("bob", 2.0), joint("shoulder", "fixed", "platform", "arm"),
        joint("hand", "fixed", "arm", "bob", "0.3 0 -0.4"), bar("arm", "shoulder", "hand", RHO, CIRCLE),
    )  # fmt: skip
    found = ks.analyze(machine.assemble(), LOAD, GRAVITY)
    parts = found.by_mechanism.axial_contributions["arm"]
    assert parts["platform_weight"] == pytest.approx(2.0 * GRAVITY @ [0.6, 0, -0.8], rel=1e-12)
    assert [force for source, force in parts.items() if source != "platform_weight"] == pytest.approx([0.0] * (len(parts) - 1))


def test_singular_pose_error_names_axis_of_free_rotation():
    """The hinge lies 0.4 m beside the reference point: a rotation about it moves the point by 0.4 m per radian."""
    machine = robot(
        link("base"), link("arm"), link("platform", 3.0), joint("hinge", "continuous", "base", "arm", "0 0 0.3"),
        joint("tip", "fixed", "arm", "platform", "0.4 0 0"), bar("arm", "hinge", "tip", RHO, CIRCLE),
    )  # fmt: skip
    with pytest.raises(
        ks.exceptions.SingularPoseError, match=r"rotation about the axis \(0, .?1, 0\) through o \+ \(-0.4, 0, 0\) m"
    ) as error:
        ks.analyze(machine.assemble(), gravity=(0, 0, 0))
    free = error.value.free_twists
    assert free.shape == (6, 1)
    np.testing.assert_allclose(free[:, 0] / free[4, 0], [0, 0, -0.4, 0, 1, 0], atol=1e-9)


def test_network_intensities_add_up_to_the_limb_wrench():
    """A truss on a stem under its weight: canonical wrenches times intensities give the wrench at its end."""
    found = ks.analyze(truss().assemble(), LOAD, gravity=(1.0, 2.0, -9.0))
    [limb] = found.limbs.values()
    assert limb.is_network
    total = limb.constraint_wrenches @ limb.intensities + limb.attached_wrenches @ limb.attached_intensities
    np.testing.assert_allclose(total, limb.wrench, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(total[:3], LOAD[:3] + 2.0 * np.array([1.0, 2.0, -9.0]), rtol=1e-9)
    assert near_singularity(found).force_amplification.tolist() == pytest.approx([1.0], rel=0.5)


def test_single_joint_has_no_force_amplification():
    drive = '<transmission name="t"><joint name="mount"/></transmission>'
    found = near_singularity(ks.analyze(mount(drive, kind="revolute").assemble()))
    assert found.force_amplification.tolist() == [0.0] and not found.where.any()
