"""Plans of measurements, against random plans and the standard errors of calibrations."""

import json
import sys

import numpy as np
import package_robots
import pytest

import kinetostatics as ks

RODS = ["rod_1", "rod_2", "rod_3"]
SOME = {"z": 0.5, "rx": [-0.1, 0.1], "ry": 0.1}
LOADS = [[0, 0, -2000, 0, 0, 0], [1000, 0, 0, 0, 0, 0]]


def test_plan_beats_random_plans():
    robot = package_robots.robot("3rps")
    over = {"z": 0.5, "rx": [-0.2, 0.0, 0.2], "ry": [-0.2, 0.0, 0.2]}
    plan = ks.plan_measurements(robot, [*RODS, "offset.dz"], 5, over, load=LOADS, readings=["dz"])
    assert plan.candidates == 18 and len(set(plan.chosen.tolist())) == 5 and plan.gain > 1.3
    assert all(plan.standard_errors[name] < error for name, error in plan.random_standard_errors.items())
    # standard errors are those of a calibration
    pose = robot.assemble(platform=dict(plan.coordinates))
    dz = ks.analyze(pose, plan.load).twist[:, 2]
    rows = {**plan.coordinates, "Fx": plan.load[:, 0], "Fz": plan.load[:, 2], "dz": dz}
    gauges = {"dz": ks.Gauge((0, 0, 1), sigma=1e-6)}
    found = ks.calibrate(robot, rows, [*RODS, "offset.dz"], gauges=gauges)
    for name, error in plan.standard_errors.items():
        assert found.estimates[name].standard_error == pytest.approx(error, rel=1e-6), name


def test_gain_for_one_unknown_is_the_standard_error_ratio():
    first, again, other = (
        ks.plan_measurements(package_robots.robot("3rps"), ["rod_1"], 2, SOME, load=LOADS, readings=["dz"], seed=seed)
        for seed in (0, 0, 1)
    )
    assert first.gain == again.gain != other.gain and first.gain > 1.05
    assert first.gain == pytest.approx(first.random_standard_errors["rod_1"] / first.standard_errors["rod_1"], rel=1e-9)


def test_saved_plan_can_be_filled_in_and_calibrated(tmp_path):
    robot = package_robots.robot("3rps")
    plan = ks.plan_measurements(robot, RODS, 3, SOME, load=LOADS, reference="unloaded")
    (tmp_path / "plan.csv").write_text("before", encoding="utf-8")
    plan.save(tmp_path / "plan.csv")
    lines = (tmp_path / "plan.csv").read_text(encoding="utf-8").splitlines()
    assert lines[0] == "z,rx,ry,Fx,Fy,Fz,Mx,My,Mz,dx,dy,dz" and len(lines) == 4 and lines[1].endswith(",,,")
    twist = ks.analyze(robot.assemble(platform=dict(plan.coordinates)), plan.load, (0, 0, 0)).twist
    filled = [line[:-3] + "," + ",".join(map(str, row)) for line, row in zip(lines[1:], twist[:, :3], strict=True)]
    (tmp_path / "plan.csv").write_text("\n".join([lines[0], *filled]), encoding="utf-8")
    found = ks.calibrate(robot, tmp_path / "plan.csv", RODS, reference="unloaded")
    assert [found.estimates[name].value for name in RODS] == pytest.approx([1.0] * 3, rel=1e-8)
    assert "times smaller than those of random plans" in str(plan) and "of '3rps'" in repr(plan)
    assert "<table" in plan._repr_html_() and json.loads(json.dumps(plan.to_dict()))["candidates"] == 4
    with pytest.raises(ks.ArgumentError, match=r"cannot be written: Is a directory"):
        plan.save(tmp_path)


def test_unknowns_without_informative_candidates_are_reported_without_scipy(monkeypatch):
    monkeypatch.setitem(sys.modules, "scipy.linalg", None)
    plan = ks.plan_measurements(package_robots.robot("3rps"), ["rod_1", "payload.mass"], 2, load=LOADS, reference="unloaded")
    assert plan.unidentifiable[0].words.startswith("no reading depends on payload") and list(plan.standard_errors) == ["rod_1"]


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"n": 3}, "^3 measurements cannot be chosen from 2 combinations of pose and load: give more, or plan fewer$"),
        ({"unknowns": RODS, "readings": ["dz"], "platform": SOME}, "^3 unknowns need at least 3 measurements of 1 reading each"),
        ({"readings": []}, "readings are empty"),
        ({"platform": {"z": 50.0, "rx": 0.0, "ry": 0.0}}, "none of 2 combinations of pose and load can be measured"),
        ({"readings": ["dzz"]}, "there is no gauge 'dzz'"),
        ({"load": [1, 2]}, "its last axis must have 6 entries"),
        ({"platform": 3}, "it must be a mapping"),
        ({"platform": SOME, "actuators": {"prismatic_1": 0.0}}, "either platform or actuators"),
        ({"platform": {"z": np.linspace(0.4, 0.5, 20001), "rx": 0, "ry": 0}}, "there must be 1 to 20,000"),
        ({"platform": {"z": 0.5, "rx": 0}}, "mobility"),
    ],
)
def test_invalid_arguments_are_refused(changes, said):
    options = {"unknowns": ["rod_1"], "n": 1, "load": LOADS}
    with pytest.raises(ks.KinetostaticsError, match=said):
        ks.plan_measurements(package_robots.robot("3rps"), **{**options, **changes})


def test_poses_that_cannot_be_measured_are_no_candidates():
    """Beyond a joint limit, or out of reach: the plan is that of the other poses."""
    for name, unknowns, axis, values, fixed in (
        ("3rps", RODS, "z", [0.5, 5.0, 0.6], {"rx": [-0.1, 0.1], "ry": 0.1}),
        ("five_bar", ["distal_1", "distal_2"], "y", [0.2, 9.0, 0.25], {"x": [-0.02, 0.02]}),
    ):
        robot, given = package_robots.robot(name), {"load": LOADS, "readings": ["dz"]}
        found = ks.plan_measurements(robot, unknowns, 4, {axis: values, **fixed}, **given)
        wanted = ks.plan_measurements(robot, unknowns, 4, {axis: values[::2], **fixed}, **given)
        assert found.candidates == wanted.candidates == 8 and set(found.coordinates[axis].tolist()) <= set(values[::2])
        assert {**found.standard_errors} == pytest.approx({**wanted.standard_errors}, rel=1e-9)
