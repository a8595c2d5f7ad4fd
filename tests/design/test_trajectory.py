"""Trajectories: poses, velocities, statics along the path, peaks, files, figures and the command."""

import csv
import inspect
import itertools
import re
from dataclasses import replace

import numpy as np
import package_robots
import pytest
from loop_robots import Held
from simple_machines import arm, springs

import kinetostatics as ks
from kinetostatics.buckling.stability import Stability
from kinetostatics.cli.main import main
from kinetostatics.dynamics.trajectory import _divided
from kinetostatics.results import warnings

WAY = {"x": [-0.15, 0.0, 0.15], "y": 0.0, "z": [-0.75, -0.7, -0.75]}
TIMES = [0.0, 0.1, 0.2]
PAYLOAD = ks.Payload(0.5)


@pytest.fixture(scope="module")
def delta():
    return package_robots.robot("delta")


@pytest.fixture(scope="module")
def path(delta):
    return ks.trajectory(delta, TIMES, platform=WAY, samples=41).analyze(payload=PAYLOAD)


def test_poses_lie_on_the_path(delta):
    t = ks.trajectory(delta, TIMES, platform=WAY, samples=41)
    pose = t.configuration
    assert t.times == pytest.approx(np.linspace(0, 0.2, 41))
    for name, values in WAY.items():
        assert pose.platform[name][[0, 20, 40]] == pytest.approx(np.broadcast_to(values, 3), abs=1e-12)
    assert all(np.abs(t.motion.velocities[name][[0, -1]]).max() < 1e-12 for name in WAY)
    straight = ks.trajectory(delta, platform={**WAY, "z": -0.7}, speed={"x": 3.0}, acceleration=60.0)
    assert straight.times[-1] == pytest.approx(2 * (0.15 / 3 + 3 / 60), rel=1e-14)


@pytest.mark.parametrize("name", ["delta", "3rps", "revolute loop", "prismatic loop"])
def test_actuator_velocities_are_derivatives_of_their_coordinates(name):
    kind, _, is_loop = name.partition(" ")
    robot = Held(kind, seed=3, drive="closing").robot() if is_loop else package_robots.robot(name)
    zero = robot.assemble()
    start = {n: float(v) for n, v in zero.actuators.items()}
    rng = np.random.default_rng(4)
    size = {n: 0.1 if robot.mechanism.connections[n].type.is_hinge else 0.03 for n in start}
    there = {n: [v, v + size[n] * rng.uniform(-1, 1)] for n, v in start.items()}
    t = ks.trajectory(robot, [0.0, 1.0], actuators=there, samples=9)
    for n, values in there.items():
        assert t.actuator_velocities[n][4] == pytest.approx(15 / 8 * np.diff(values)[0], rel=1e-9)


def test_actuator_velocities_equal_differences_along_the_path(delta):
    t = ks.trajectory(delta, TIMES, platform=WAY, samples=2001)
    for name, value in t.configuration.actuators.items():
        step = t.times[1]
        fine = (8 * (value[3:-1] - value[1:-3]) - value[4:] + value[:-4]) / (12 * step)
        assert t.actuator_velocities[name][2:-2] == pytest.approx(fine, rel=1e-7, abs=1e-6)


def test_actuator_work_from_rest_to_rest_is_zero(delta):
    """Without gravity."""
    found = ks.trajectory(delta, TIMES, platform=WAY).analyze(gravity=(0, 0, 0), payload=PAYLOAD)
    powers = found.over_time("actuator_power")
    work = [np.trapezoid(power, found.times) for power in powers.values()]
    assert abs(sum(work)) < 1e-8 * sum(map(abs, work))


def test_path_results_equal_those_of_single_poses(delta, path):
    t = ks.trajectory(delta, TIMES, platform=WAY, samples=41)
    one = ks.analyze(
        delta.assemble(platform={n: v[7] for n, v in t.configuration.platform.items() if n in WAY}),
        payload=PAYLOAD,
        motion=ks.Motion({n: v[7] for n, v in t.motion.velocities.items()}, {n: v[7] for n, v in t.motion.accelerations.items()}),
    )
    assert path.result.twist[7] == pytest.approx(one.twist, abs=1e-8 * np.abs(one.twist).max())
    assert sum(path.over_time("contributions").values()) == pytest.approx(path.over_time("displacement")["o"], rel=1e-9)
    for name, parts in path.result.axial_contributions.items():
        assert sum(parts.values()) == pytest.approx(path.result.beams[name].section_wrenches[:, -1, 0], rel=1e-9)


def test_inertia_effects_grow_with_the_square_of_speed(delta, path):
    fast = ks.trajectory(delta, np.array(TIMES) / 2, platform=WAY, samples=41).analyze(payload=PAYLOAD)
    scale = np.abs(fast.result.contributions["inertia"]).max()
    assert fast.result.contributions["inertia"] == pytest.approx(4 * path.result.contributions["inertia"], abs=1e-8 * scale)


def test_peaks_have_the_extreme_value_and_its_time(path):
    force = path.result.actuator_forces["motor_1"]
    k = int(np.argmax(np.abs(force)))
    peak = path.peaks("actuator_torque")["motor_1"]
    assert (peak.value, peak.time) == (force[k], path.times[k])
    wrench = path.result.joint_wrenches["lower_2b"]
    assert path.peaks("joint_force")["lower_2b"].value == np.linalg.norm(wrench[:, :3], axis=1).max()
    assert path.root_mean_square("actuator_torque")["motor_1"] == pytest.approx(
        np.sqrt(np.trapezoid(force**2, path.times) / 0.2), rel=1e-14
    )
    assert not path.over_time("actuator_force")
    tip = path.at_point((0, 0, -0.1))
    assert tip.peaks("displacement")["the tool's tip"].value == np.linalg.norm(tip.result.twist[:, :3], axis=1).max()
    text = str(path)
    assert f"{peak.value:.3f} N·m" in text and "Path of 'delta' in 0.2 s: 41 poses" in text
    assert path.to_dict()["peaks"]["actuator_torque"]["motor_1"] == {"value": peak.value, "time": peak.time}


def test_reports_of_paths_compute_no_buckling_modes_where_nothing_buckles(path, monkeypatch):
    monkeypatch.setattr(Stability, "modes", lambda self: pytest.fail("an eigenvalue problem was solved"))
    again = replace(path, result=ks.analyze(path.result.configuration, payload=PAYLOAD))
    monkeypatch.setattr(warnings, "_changed_stiffness", lambda result: "")  # this one is of a single pose
    assert "largest von Mises stress" in str(again) and again.to_dict()["peaks"]["stress"]


def test_table_has_a_row_for_each_instant(path, tmp_path):
    path.save(tmp_path / "path.csv")
    rows = list(csv.DictReader((tmp_path / "path.csv").read_text(encoding="utf-8").splitlines()))
    assert len(rows) == 41 and {row["status"] for row in rows} == {"OK"}
    for title, values in {
        "time [s]": path.times,
        "z [m]": path.result.configuration.platform["z"],
        "velocity of motor_2 [rad/s]": path.actuator_velocities["motor_2"],
        "force of motor_2 [N·m]": path.result.actuator_forces["motor_2"],
        "twist z [m]": path.result.twist[:, 2],
        "stress in arm_1 [Pa]": path.result.beams["arm_1"].stress,
    }.items():
        assert [float(row[title]) for row in rows] == pytest.approx(list(values), rel=1e-14)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"times": TIMES}, "either as platform= or as actuators="),
        ({"platform": WAY}, "give times= of the waypoints, or speed= and acceleration="),
        ({"platform": WAY, "speed": 1.0}, "give times= of the waypoints, or speed= and acceleration="),
        ({"platform": WAY, "acceleration": 1.0}, "give times= of the waypoints, or speed= and acceleration="),
        ({"platform": WAY, "actuators": {"motor_1": [0, 1]}, "times": TIMES}, "either as platform= or as actuators="),
        ({"platform": WAY, "times": [0, 0.2, 0.1]}, "3 increasing numbers"),
        ({"platform": {**WAY, "y": [0, 1]}, "times": TIMES}, r"shapes x \(3,\), y \(2,\)"),
        ({"platform": WAY, "speed": {"x": 1.0}, "acceleration": 1.0}, "speed of z is missing"),
        ({"platform": WAY, "times": TIMES, "speed": 1.0}, "give either times="),
        ({"platform": WAY, "times": TIMES, "acceleration": 1.0}, "give either times="),
        ({"platform": {**WAY, "x": [0, 0, 1], "z": -0.7}, "speed": 1.0, "acceleration": 1.0}, "are the same"),
    ],
)
def test_invalid_trajectories_are_refused(delta, given, words):
    with pytest.raises(ks.ArgumentError, match=words):
        ks.trajectory(delta, given.pop("times", None), **given)


@pytest.mark.parametrize("samples", [2, 3, 201, 700])
def test_every_waypoint_is_an_instant(delta, samples):
    """Of many rows, all; of few, each interval is divided equally, into ``samples`` poses or more."""
    rng = np.random.default_rng(2)
    times = np.cumsum(rng.uniform(0.001, 0.01, 300))
    z = -0.72 + 1e-4 * np.cumsum(rng.uniform(-1, 1, 300))
    t = ks.trajectory(delta, times, platform={"x": 0.0, "y": 0.0, "z": z}, samples=samples)
    assert len(t.times) >= max(samples, 300) and np.all(np.diff(t.times) > 0)
    rows = np.searchsorted(t.times, times)
    assert np.array_equal(t.times[rows], times)
    assert t.configuration.platform["z"][rows] == pytest.approx(z, abs=1e-10)
    for first, last in itertools.pairwise(rows):
        assert np.ptp(np.diff(t.times[first : last + 1])) < 1e-12
        assert np.diff(t.times[first : last + 1]).max() <= np.ptp(times) / (samples - 1) + 1e-12


def test_the_peak_of_a_fast_table_is_found(delta):
    """A shake of 25 ms in 1.5 s, in rows of 1 ms; its peak is that of 5,000 poses."""
    times = np.arange(1500) * 1e-3
    z = -0.72 + 0.002 * np.exp(-(((times - 0.7013) / 0.006) ** 2))
    rows = {"x": 0.0, "y": 0.0, "z": z}
    coarse, fine = (
        ks.trajectory(delta, times, platform=rows, samples=n).analyze().peaks("actuator_torque")["motor_1"] for n in (201, 5_000)
    )
    assert abs(coarse.value) > 5 and coarse.value == pytest.approx(fine.value, rel=0.01)
    assert coarse.time == pytest.approx(fine.time, abs=1e-3)


def test_a_jump_of_an_angle_is_asked_about_and_both_pieces_of_advice_work():
    robot, times = package_robots.robot("ur10"), np.array([0.0, 0.5])
    angle, rest = np.radians([170.0, -170.0]), dict.fromkeys(robot.description.actuated[1:], 0.3)
    joint = robot.description.actuated[0]
    words = "from 170° to -170° between the waypoints 1 and 2, at 0 and 0.5 s: if it turns the short way, write 190°"
    with pytest.raises(ks.ArgumentError, match=f"{joint} turns {words}"):
        ks.trajectory(robot, times, actuators={joint: angle, **rest})
    short = ks.trajectory(robot, times, actuators={joint: np.unwrap(angle), **rest})
    long = ks.trajectory(robot, [0.0, 0.25, 0.5], actuators={joint: [angle[0], 0.0, angle[1]], **rest})
    turned = [np.trapezoid(t.actuator_velocities[joint], t.times) for t in (short, long)]
    assert np.degrees(turned) == pytest.approx([20, -340], rel=1e-3)
    with pytest.raises(ks.ArgumentError, match="rz turns from 179° to -178°"):
        ks.trajectory(robot, times, platform={"x": 0.5, "y": 0.3, "z": 0.4, "rx": 0.0, "ry": 0.0, "rz": np.radians([179, -178])})
    assert ks.trajectory(robot, actuators={joint: angle, **rest}, speed=1.0, acceleration=1.0).times[-1] > 5


def test_half_a_turn_is_no_jump():
    robot = package_robots.robot("ur10")
    first, *others = robot.description.actuated

    def turned(beyond):
        way = {first: [-1.0, -1.0 + np.pi * (1 + beyond)], **dict.fromkeys(others, 0.3)}
        return ks.trajectory(robot, [0.0, 1.0], actuators=way, samples=2)

    assert len(turned(1e-10).times) == 2
    with pytest.raises(ks.ArgumentError, match=f"{first} turns"):
        turned(1e-8)


def test_intervals_are_divided_as_finely_as_asked_up_to_rounding():
    """Half of ten steps is five, unless the interval is longer by more than rounding."""
    assert len(_divided(np.array([0.0, 0.5 + 1e-11, 1.0]), 11)) == 11
    assert len(_divided(np.array([0.0, 0.5 + 1e-8, 1.0]), 11)) == 12


def test_poses_of_a_path_close_as_those_of_the_robot(delta):
    assert ks.trajectory(delta, TIMES, platform=WAY, samples=5).configuration.residual.max() < 1e-10
    usual, own = (inspect.signature(call).parameters["closure_tolerance"] for call in (ks.Robot.assemble, ks.trajectory))
    assert own.default == usual.default == 1e-10


def test_actuators_that_race_near_a_singular_pose_are_named():
    """The elbow of a UR10 is stretched to 3 degrees; the warning's speed is that of the velocities at its instant."""
    robot = package_robots.robot("ur10")
    names = robot.description.actuated
    start, end = (
        robot.assemble(actuators=dict(zip(names, [0.3, -1.2, elbow, -0.4, 1.2, 0.2], strict=True))) for elbow in (1.5, 0.05)
    )
    way = {name: [float(start.platform[name]), float(end.platform[name])] for name in start.platform}
    t = ks.trajectory(robot, [0.0, 1.0], platform=way, near=start)
    [warning] = t.warnings
    found = re.match(r"(\w+) moves at (\S+) rad/s at (\S+) s, since the pose is near a singular one", warning)
    k = int(np.argmin(np.abs(t.times - float(found[3]))))
    assert found[1] == "elbow_joint" and abs(t.actuator_velocities[found[1]][k]) == pytest.approx(float(found[2]), rel=5e-3)
    assert warning in " ".join(str(t.analyze()).split()) and warning in t.analyze().to_dict()["warnings"]
    less = {name: [a, a + 0.6 * (b - a)] for name, (a, b) in way.items()}
    assert ks.trajectory(robot, [0.0, 1.0], platform=less, near=start).warnings == ()
    assert (
        ks.trajectory(
            robot, [0.0, 1.0], actuators={n: [float(start.actuators[n]), float(end.actuators[n])] for n in names}
        ).warnings
        == ()
    )


def test_motions_of_robots_without_actuators_cause_no_warnings():
    held = arm(*(springs(name, angular="50 50 50") for name in ("shoulder", "elbow")), actuated=False)
    assert ks.trajectory(held, [0.0, 1.0], platform={"z": [0.05, 0.1], "ry": 0.1}, samples=5).warnings == ()


def test_usual_motions_cause_no_warnings(delta):
    assert ks.trajectory(delta, TIMES, platform=WAY).warnings == ()
    assert (
        ks.trajectory(package_robots.robot("3rps"), [0, 1], platform={"z": [0.5, 0.6], "rx": [0, 0.3], "ry": 0.0}).warnings == ()
    )


def test_invalid_path_arguments_are_refused(delta, path):
    t = ks.trajectory(delta, TIMES, platform=WAY, samples=3)
    with pytest.raises(ks.AssemblyError, match="cannot reach"):
        ks.trajectory(delta, TIMES, platform={**WAY, "x": [0.0, 0.0, 2.0]}, samples=5)
    with pytest.raises(ks.ArgumentError, match="analyze takes no 'motion'"):
        t.analyze(motion=t.motion)
    with pytest.raises(ks.ArgumentError, match="one load, or one for each of its 3 poses"):
        t.analyze(np.zeros((2, 1, 6)))
    with pytest.raises(ks.ArgumentError, match="'sag'; it must be one of 'displacement'"):
        path.over_time("sag")
    with pytest.raises(ks.ArgumentError, match=r"\.csv"):
        path.save("path.txt")


# ---- figures and the command ---------------------------------------------------------------------------------------------


@pytest.mark.usefixtures("no_figures_left")
def test_figures_show_forces_speeds_and_stresses(path, capsys):
    import matplotlib

    matplotlib.use("Agg")
    ax = ks.plot.path(path, "actuator_torque")
    assert [line.get_label() for line in ax.get_lines()] == ["motor_1", "motor_2", "motor_3"]
    assert ax.get_lines()[1].get_ydata() == pytest.approx(path.result.actuator_forces["motor_2"])
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("time [s]", "torque of the actuator [N·m]")
    ax = ks.plot.path(path, "torque_speed")
    assert ax.get_lines()[1].get_xdata() == pytest.approx(path.actuator_velocities["motor_2"])
    ax = ks.plot.path(path, "stress")
    assert len(ax.get_lines()) == 6 and ax.get_title() == "the largest 6 of 9"
    assert ks.plot.path(path).get_ylabel() == "displacement of o [µm]"
    with pytest.raises(ks.ArgumentError, match=r"no force of the actuator \[N\]"):
        ks.plot.path(path, "force_speed")
    with pytest.raises(ks.ArgumentError, match="is no result of a trajectory"):
        ks.plot.path(path.result)


def test_analyze_command_with_a_table_of_waypoints(capsys, tmp_path, path):
    table, out = tmp_path / "waypoints.csv", tmp_path / "path.csv"
    table.write_text("time [ms],x [mm],y,z [mm]\n0,-150,0,-750\n100,0,0,-700\n200,150,0,-750\n", encoding="utf-8")
    figure = tmp_path / "torque.svg"
    command = ["analyze", "delta", "--table", str(table), "--payload", "500g"]
    assert main([*command, "--what", "actuator_torque", "--out", str(out), str(figure)]) == 0
    printed = capsys.readouterr().out
    assert "201 poses" in printed and f"wrote {figure}" in printed and figure.stat().st_size > 5000
    rows = list(csv.DictReader(out.read_text(encoding="utf-8").splitlines()))
    found = [float(row["force of motor_1 [N·m]"]) for row in rows[::5]]
    assert found == pytest.approx(list(path.result.actuator_forces["motor_1"]), rel=1e-9)
    assert main([*command, "--samples", "300"]) == 0 and "301 poses" in capsys.readouterr().out
    for extra, words in (
        (["analyze", "delta", "--out", str(out)], "--out is for a path: --table FILE"),
        (["analyze", "delta", "--samples", "5"], "--samples is for a path: --table FILE"),
        ([*command, "--platform", "z=1"], "either --table or coordinates"),
        ([*command, "--hinge-axis", "limb_1=x"], "--hinge-axis is for one pose"),
        ([*command, "--out", "path.nc"], "does not end in .csv"),
    ):
        assert main(extra) == 2 and words in capsys.readouterr().err
    table.write_text("z,x\n1,2\n2,3\n", encoding="utf-8")
    assert main(command) == 2 and "the column 'time' is missing" in capsys.readouterr().err
