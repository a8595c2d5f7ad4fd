"""Ends of lines of coordinates, against a dense scan; ordinary poses within the limits."""

import numpy as np
import package_robots
import pytest

from kinetostatics.kinematics.reach import FINE, find_ends, ordinary_poses

SCANNED = 24


def scan(robot, pose, kind, values):
    """Which poses (n,) of a line are good, as far as all before are: reached, within limits, on one side of singular poses.

    The actuators' singular poses are where the actuators' derivatives by the platform's coordinates have no inverse.
    """
    found = robot.assemble(**{kind: values}, near=pose, on_failure="nan")
    good = found.reached & ~found.limit_exceeded
    if kind == "platform":
        columns = []
        for name in values:
            before, after = (
                robot.assemble(platform={**values, name: values[name] + step}, near=found, on_failure="nan").actuators
                for step in (-1e-5, 1e-5)
            )
            columns.append([np.nan_to_num(after[drive] - before[drive]) for drive in robot.description.actuated])
        determinant = np.linalg.det(np.moveaxis(np.array(columns), 2, 0))
        good &= determinant * determinant[0] > 0
    return np.logical_and.accumulate(good)


@pytest.mark.parametrize(
    ("name", "kind", "spans", "why"),
    [
        ("five_bar", "platform", {"x": 0.8, "y": 0.8}, {"loops", "singular"}),
        ("five_bar", "actuators", {"shoulder_1": np.pi, "shoulder_2": np.pi}, {"limit", "loops"}),
        pytest.param("planar_3rrr", "platform", {"x": 1.0, "y": 1.0, "rz": np.pi}, {"limit", "singular"}, marks=pytest.mark.slow),
    ],
)
def test_lines_end_where_a_dense_scan_does(name, kind, spans, why):
    robot = package_robots.robot(name)
    pose = robot.assemble()
    present = {c: float((pose.platform if kind == "platform" else pose.actuators)[c]) for c in spans}
    lines = [(c, sign * span) for c, span in spans.items() for sign in (-1, 1)]
    ends = find_ends(pose, kind, {c: np.array([way * (c == own) for own, way in lines]) for c in spans})
    reasons = set()
    for (coordinate, way), end in zip(lines, ends, strict=True):
        values = {c: np.full(SCANNED + 1, value) for c, value in present.items()}
        values[coordinate] = present[coordinate] + way * np.linspace(0, 1, SCANNED + 1)
        good = scan(robot, pose, kind, values)
        last = 1.0 if good.all() else (np.argmin(good) - 1) / SCANNED
        assert last - FINE <= end.part <= last + 1 / SCANNED + FINE, (coordinate, way, end)
        reasons.add(end.reason)
        if end.reason == "limit":
            at = robot.assemble(**{kind: {**present, coordinate: present[coordinate] + (end.part + 2 * FINE) * way}}, near=pose)
            assert end.joint in at.limits_exceeded
            assert end.limit in (at.limits_exceeded[end.joint].lower, at.limits_exceeded[end.joint].upper)
    assert reasons == why


def test_limits_exceeded_at_the_start_end_no_line():
    robot = package_robots.robot("3rps")
    pose = robot.assemble(platform={"z": 1.1, "rx": 0.0, "ry": 0.0})
    assert pose.limits_exceeded
    (end,) = find_ends(pose, "platform", {"z": np.array([-0.3]), "rx": np.zeros(1), "ry": np.zeros(1)})
    assert end.part == 1 and end.reason == ""


def test_ordinary_poses_lie_at_fractions_of_the_limits():
    """One actuator at a time moves by 0.2 and 0.6 of its limits, which count up to 1.2 characteristic lengths."""
    machine = package_robots.robot("3rps")
    pose = machine.configuration(ordinary_poses(machine).T)
    connections = machine.mechanism.connections
    drives = list(machine.description.actuated)
    moved = np.stack([pose.actuators[name] for name in drives], axis=1)
    wanted = [np.zeros(3)]
    far = 1.2 * machine.length
    for part in (0.2, 0.6):
        for side in ("lower", "upper"):
            wanted += list(np.diag([part * np.clip(getattr(connections[name], side), -far, far) for name in drives]))
    np.testing.assert_allclose(moved, wanted, atol=1e-9)
