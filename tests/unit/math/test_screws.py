"""Twists, wrenches, stiffness and compliance about another point; descriptions of twists by axis and pitch."""

import numpy as np

from kinetostatics.math.screws import describe_twist, move


def test_description_of_a_twist_gives_axis_and_pitch():
    """A screw about z through (2, 0, 0) that rises by 0.3 m/rad, at half a rad/s."""
    twist = np.array([0, -2 * 0.5, 0.3 * 0.5, 0, 0, 0.5])
    assert describe_twist(twist, 1.0) == "a rotation about the axis (0, 0, 1) through o + (2, 0, 0) m with a pitch of 0.3 m/rad"
    for factor in (2, -1):
        assert describe_twist(factor * twist, 1.0) == describe_twist(twist, 1.0)
    level = "a rotation about the axis (0, 0, 1) through o + (0, 0, 0) m"
    for pitch, said in ((1.9e-6, False), (2.1e-6, True), (-2.1e-6, True)):
        assert describe_twist(np.array([0, 0, 3 * pitch, 0, 0, 3]), 2.0).startswith(level)
        assert ("pitch" in describe_twist(np.array([0, 0, 3 * pitch, 0, 0, 3]), 2.0)) == said
    for sign in (1.0, -1.0):
        assert describe_twist(sign * np.array([0, 3.0, 4.0, 0, 0, 0]), 1.0) == "a translation along (0, 0.6, 0.8)"
    for turn, words in ((2e-6, "translation"), (3e-6, "rotation")):  # 5 · 1e-6 / 2 m
        assert describe_twist(np.array([3.0, 4.0, 0, 0, 0, turn]), 2.0).startswith(f"a {words}")


def test_power_stiffness_and_compliance_do_not_depend_on_the_reference_point():
    """For every pose and column: power t · w, twist C w and wrench K t of moved quantities are the moved ones."""
    rng = np.random.default_rng(3)
    C, w, t, shift = (rng.standard_normal(shape) for shape in ((6, 6, 5), (6, 4, 5), (6, 4, 5), (3, 5)))  # neither is symmetric
    K = np.moveaxis(np.linalg.inv(np.moveaxis(C, 2, 0)), 0, 2)
    moved = {"twist": t, "wrench": w, "compliance": C, "stiffness": K}
    moved = {kind: move(kind, array, shift) for kind, array in moved.items()}
    assert np.allclose(np.sum(moved["twist"] * moved["wrench"], axis=0), np.sum(t * w, axis=0))
    for kind, matrix, by, what in (("compliance", C, "wrench", w), ("stiffness", K, "twist", t)):
        other = "twist" if by == "wrench" else "wrench"
        there = move(other, np.einsum("ijn,jkn->ikn", matrix, what), shift)
        assert np.allclose(np.einsum("ijn,jkn->ikn", moved[kind], moved[by]), there)
        assert not np.allclose(moved[kind], matrix)
    assert np.allclose(np.einsum("ijn,jkn->ikn", moved["compliance"], moved["stiffness"]), np.eye(6)[:, :, None])
    for kind, array in {"compliance": C, "twist": t[:, 0]}.items():
        last = move(kind, np.moveaxis(array, -1, 0), shift.T, components_last=True)
        assert np.array_equal(np.moveaxis(last, 0, -1), move(kind, array, shift))
