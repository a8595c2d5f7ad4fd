"""Continuation from pose to pose: local spins, singular poses on the way, large batches."""

import numpy as np
import package_robots
import pytest

from kinetostatics.kinematics.assembly import platform_coordinates


def test_local_spins_of_rods_are_held_fixed():
    """Five rods of the Delta spin by a joint of their own; the sixth is on the tree's path to the platform."""
    robot = package_robots.robot("delta")
    prescribed, _ = platform_coordinates(robot, {"x": 0.1, "y": -0.2, "z": -0.7}, None)
    held = robot.mobility_analysis.with_dofs(prescribed)
    spins = {f"upper_{limb}{rod}_z" for limb in (1, 2, 3) for rod in "ab"} - {"upper_1a_z"}
    columns = {
        joint.first_v: name
        for name, body in robot.mechanism.body_of_joint.items()
        for joint in robot.mechanism.tree.joints
        if joint.body == body
    }
    assert {columns[k] for k in held.fixed_dofs} == spins
    assert held.local_dofs == 1
    assert held.size == prescribed.size and set(robot.solver.free_columns(prescribed)) - set(
        robot.solver.free_columns(held)
    ) == set(held.fixed_dofs)


def test_continuation_does_not_cross_singular_poses():
    """Near a singular pose of the five-bar both positions of an elbow close with small corrections."""
    robot, random = package_robots.robot("five_bar"), np.random.default_rng(0)

    def side(pose):
        A, B, C = (pose.frame(link)[..., :2, 3] for link in ("proximal_2", "distal_2", "tool"))
        a, b = B - A, C - B
        return np.sign(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])

    ends = np.array([0.12, 0.0]) + random.uniform(-0.03, 0.03, (150, 2))
    angle, distance = random.uniform(0, 2 * np.pi, 150), random.uniform(0.02, 0.08, 150)
    x, y = (ends + distance[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)).T
    start = robot.assemble(platform={"x": x, "y": y})
    np.testing.assert_array_equal(side(start), side(robot.assemble()))
    found = robot.assemble(platform={"x": ends[:, 0], "y": ends[:, 1]}, near=start)
    assert np.sum(~found.reached) < 3  # lines too near to that point
    np.testing.assert_array_equal(side(found)[found.reached], side(start)[found.reached])


def differences(robot, target, kind="actuators", names=None, **options):
    """Return in how many poses a batch differs from the same poses in batches of 700, whose poses follow their own lines."""
    names = names or robot.description.actuated
    values = dict(zip(names, target, strict=True))
    batch = robot.assemble(**{kind: values}, on_failure="nan", **options)
    pieces = [
        robot.assemble(**{kind: {name: row[k : k + 700] for name, row in values.items()}}, on_failure="nan", **options)
        for k in range(0, target.shape[1], 700)
    ]
    alone = np.concatenate([piece.platform_frame for piece in pieces])
    assert np.sum(np.isfinite(alone[:, 0, 0])) > 0.05 * target.shape[1]
    return int(np.sum(~np.all(np.isclose(batch.platform_frame, alone, atol=1e-8, rtol=0, equal_nan=True), axis=(1, 2))))


@pytest.mark.few(1)
@pytest.mark.parametrize(
    ("name", "limit", "poses"),
    [
        ("spherical_3rrr", 1.2, 3000),
        ("planar_3rrr", 1.0, 2000),
        pytest.param("five_bar", 1.5, 3000, marks=pytest.mark.slow),
        pytest.param("delta", 1.5, 1000, marks=pytest.mark.slow),
    ],
)
def test_large_batch_equals_small_batches_along_their_lines(name, limit, poses):
    """Beside singular poses, lines that pass them on different sides end in different assembly modes."""
    robot = package_robots.robot(name)
    target = np.random.default_rng(1).uniform(-limit, limit, (poses, len(robot.description.actuated))).T
    assert differences(robot, target) == 0
