"""Joints of a limb in its statics: hinges that form one joint, order, centres; and ends found for a beam."""

import numpy as np
import pytest
from simple_machines import BAR, BEAM, CIRCLE, RHO, bar, joint, link, robot

import kinetostatics as ks
from kinetostatics.mechanism.mechanism import meeting_points


def hinges(*axes, at=None):
    """A chain of hinges about these axes, under a rod: all through one point, or at the places ``at`` along x."""
    at = np.zeros(len(axes)) if at is None else np.asarray(at)
    names = ["base", *(f"link_{k}" for k in range(1, len(axes))), "rod"]
    parts = [link(name) for name in [*names, "platform"]]
    for k, axis in enumerate(axes):
        before = at[k - 1] if k else 0.0
        parts.append(joint(f"hinge_{k}", "continuous", names[k], names[k + 1], f"{at[k] - before} 0 0", axis))
    parts += [joint("head", "fixed", "rod", "platform", "0.1 0.2 1"), bar("rod", f"hinge_{len(axes) - 1}", "head", RHO, CIRCLE)]
    return robot(*parts)


X, Y, Z, OBLIQUE = "1 0 0", "0 1 0", "0 0 1", "1 1 1"


@pytest.mark.parametrize(
    ("axes", "at", "kinds"),
    [
        ((X,), None, "revolute"),
        ((X, Y), None, "universal"),
        ((X, Y, Z), None, "spherical"),
        ((X, Y, Z, X, Y, Z), None, "spherical spherical"),
        ((Y, Y), (0, 0.3), "revolute revolute"),
        ((Y, Z), (0, 0.3), "revolute revolute"),
        ((X, Y), (0, 0.3), "universal"),
        ((X, Y, Z), (0, 0.3, 0.3), "spherical"),
        ((Y, X, Z), (0, 0, 0.3), "universal revolute"),
        ((Y, X, Z), (1000, 1000, 1000 + 1e-7), "spherical"),  # but for the rounding of coordinates in mm
    ],
)
def test_hinges_with_intersecting_axes_form_one_joint(axes, at, kinds):
    [group] = hinges(*axes, at=at).statics.groups
    assert " ".join(item.type.name for item in group.compounds[0]) == kinds


def test_limb_edges_are_ordered_from_base_to_platform():
    """Whatever the order in which the file lists joints and beams."""
    machine = robot(
        link("base"), link("a"), link("b"), link("platform"), joint("third", "fixed", "b", "platform", "0 0 1"),
        joint("second", "fixed", "a", "b", "0 0 1"), joint("first", "fixed", "base", "a"),
        bar("b", "second", "third"), bar("a", "first", "second"),
    )  # fmt: skip
    [limb] = machine.topology.limbs
    assert [edge.joint or edge.span for edge in limb.edges] == ["first", "a", "second", "b", "third"]


@pytest.mark.parametrize("side", ["base", "platform"])
def test_beam_of_branched_link_runs_from_base_to_platform(side):
    """Of the three joints of the link, the ends are those towards base and platform, not the hook."""
    machine = robot(
        link("base"), link("lower"), link("rod"), link("upper"), link("platform"), link("bob"),
        joint("foot", "fixed", "base", "lower"), joint("in", "fixed", "lower", "rod", "0 0 0.2"),
        joint("hook", "fixed", "rod", "bob", "0 0 0" if side == "base" else "0 0 0.5"),
        joint("out", "fixed", "rod", "upper", "0 0 0.5"), joint("head", "fixed", "upper", "platform", "0 0 0.2"),
        f'<beam link="rod" density="0" {BEAM}>{BAR}</beam>',
    )  # fmt: skip
    found = ks.analyze(machine.assemble()).beams["rod"]
    np.testing.assert_allclose(found.points[[0, -1]], [[0, 0, 0.2], [0, 0, 0.7]], atol=1e-12)


@pytest.mark.parametrize(
    ("axes", "at", "count"),
    [
        ((X, Y, Z), None, 1),
        ((Y, Z, X), (0, 0, 0.3), 0),  # they meet, but not at the origin of the last
        ((X, Y, Z), (0, 0.3, 0.3), 1),  # nor need they at that of the first
        ((X, Y, OBLIQUE), None, 0),
        ((X, "1e-10 1 0", Z), None, 1),  # right angles but for rounding
        ((X, "1e-8 1 0", Z), None, 0),
        ((X, Y, Z, X, Y, Z), None, 2),
        ((X, Y), None, 0),
    ],
)
def test_three_orthogonal_hinges_form_one_spherical_joint(axes, at, count):
    assert len(hinges(*axes, at=at).mechanism.spherical_runs) == count


@pytest.mark.parametrize(("axes", "at"), [((X, Y), (0, 0.3)), ((X, Y, Z), (0, 0.3, 0.3)), ((X, Y, Z), (-0.2, 0.3, 0.3))])
def test_joint_centre_is_the_intersection_of_its_axes(axes, at):
    machine = hinges(*axes, at=at)
    [group] = machine.statics.groups
    frames = machine.assemble().frames
    centres = group.geometry(frames, np.zeros((3, 1))).centres
    np.testing.assert_allclose(centres[:, 0, 0, 0], [0.3, 0, 0], atol=1e-12)


@pytest.mark.parametrize(("miss", "meet"), [(0.0, True), (1e-9, True), (2e-9, False), (-2e-9, False)])
def test_lines_within_a_nanometre_intersect(miss, meet):
    """The x axis and a line across it at x = 0.3. The tolerance, 1e-9, is relative to 1 m plus the distance of their points."""
    found = meeting_points(
        np.array([1.0, 0, 0]), np.zeros(3), np.array([0, 0.6, 0.8]), np.array([0.3, 0.24 - 0.8 * miss, 0.32 + 0.6 * miss])
    )
    assert (found is not None) == meet
    assert found is None or found == pytest.approx((0.3, -0.4), abs=1e-8)


@pytest.mark.parametrize(("angle", "meet"), [(0.9e-6, False), (1.1e-6, True)])
def test_nearly_parallel_lines_do_not_intersect(angle, meet):
    found = meeting_points(np.array([1.0, 0, 0]), np.zeros(3), np.array([np.cos(angle), np.sin(angle), 0]), np.array([0.3, 0, 0]))
    assert found == (pytest.approx((0.3, 0.0)) if meet else None)
