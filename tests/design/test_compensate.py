"""Corrected actuator positions, checked by other methods than the one that finds them."""

import csv
import json
from types import SimpleNamespace

import numpy as np
import odd_robots
import package_robots
import pytest
import small_robots as sr
from scipy.spatial.transform import Rotation
from simple_machines import two_columns

import kinetostatics as ks
from kinetostatics.compensation import BroydenSearch
from kinetostatics.kinematics.alternatives import best_choice
from kinetostatics.results.compensation import Compensation, loaded_frame, pose_error, target_frame

LOAD = np.array([20.0, -30, -200, 4, -5, 6])
#: Soft robots, which carry less.
SOFT = {"planar_3rrr": 0.01, "spherical_3rrr": 0.01, "linear_delta": 0.001}

#: Limbs and seeds of random robots that large loads lead beyond singular poses.
BEYOND = [(["S", "rRRR"], 0), (["CrS", "pRRR", "rRRR"], 3)]


def tripod(**coordinates):
    return package_robots.robot("3rps").assemble(platform={"z": 0.5, "rx": 0.05, "ry": -0.1, **coordinates})


def stands_at(configuration, twist):
    """Return where the platform of one pose stands under load: o, and its rotation."""
    frame = configuration.platform_frame
    return frame[:3, 3] + twist[:3], Rotation.from_rotvec(np.array(twist[3:])) * Rotation.from_matrix(frame[:3, :3])


@pytest.mark.few(3)
@pytest.mark.parametrize("name", package_robots.NAMES)
def test_corrected_actuators_bring_the_loaded_platform_to_target(name):
    """All robots, at poses without symmetry; actuators alone are prescribed, and rotations are SciPy's."""
    robot = package_robots.robot(name)
    pose = robot.configuration(robot.model_q(robot.generic_poses)[:, 0])
    load = LOAD * SOFT.get(name, 1.0)
    found = ks.compensate(pose, load)
    assert found.status in (ks.Status.OK, ks.Status.LIMIT_EXCEEDED)
    assert len(found.controlled) == robot.mobility.platform
    actuated = robot.assemble(actuators=found.actuators, near=pose)
    result = ks.analyze(actuated, load)
    o, R = stands_at(actuated, result.twist)
    wanted = pose.platform_frame
    turn = R.as_rotvec()
    wanted_turn = Rotation.from_matrix(wanted[:3, :3]).as_rotvec()
    off = dict(zip(("x", "y", "z", "rx", "ry", "rz"), [*(o - wanted[:3, 3]), *(turn - wanted_turn)], strict=True))
    assert max(abs(off[coordinate]) for coordinate in found.controlled) < 1e-12
    # the motion of the unloaded platform by the correction has no part in uncorrectable directions
    scale = np.repeat([robot.length, 1.0], 3)
    moved = pose_error(target_frame(pose, None), target_frame(actuated, None))[:, 0] / scale
    parts = (found.uncorrectable_directions / scale[:, None]).T @ moved
    np.testing.assert_allclose(parts, 0, atol=10 * np.linalg.norm(moved) ** 2 + 1e-12)
    # the residual error is that of the corrected pose, and differs from the uncorrected one
    np.testing.assert_allclose(found.residual_error[:3], o - wanted[:3, 3], atol=1e-12)
    left = (R * Rotation.from_matrix(wanted[:3, :3]).inv()).as_rotvec()
    np.testing.assert_allclose(found.residual_error[3:], left, atol=1e-12)
    before = ks.analyze(pose, load)
    assert max(abs(before.twist)) > 1e-9
    np.testing.assert_allclose(found.uncorrected_error, before.twist, rtol=1e-3, atol=1e-12)
    for drive, force in result.actuator_forces.items():
        assert found.actuator_forces[drive] == pytest.approx(float(force), rel=1e-7, abs=1e-7)
        assert found.corrections[drive] == pytest.approx(float(actuated.actuators[drive] - pose.actuators[drive]), abs=1e-11)


@pytest.mark.parametrize("name", ["3rps", "2pru_upr"])
def test_finite_elements_confirm_the_corrected_pose(name):
    """OpenSees at the corrected actuators: the controlled coordinates are those wanted, within its own scatter."""
    robot = package_robots.robot(name)
    pose = robot.assemble(platform={"z": 0.5 if name == "3rps" else 0.6, "rx": 0.05, "ry": -0.06}, orientation="XYZ")
    found = ks.compensate(pose, LOAD)
    theirs = ks.verify(found.configuration, LOAD)
    assert theirs.verified
    o, R = stands_at(found.configuration, theirs.finite_elements.twist)
    angles = R.as_euler("XYZ")
    scatter = max(theirs.scatter["twist"], 1e-9) * np.linalg.norm(found.uncorrected_error[:3])
    assert abs(o[2] - pose.platform["z"]) < scatter and abs(angles[0] - 0.05) < scatter and abs(angles[1] + 0.06) < scatter
    assert found.controlled == ("z", "rx", "ry") and scatter < 1e-10


def tip_of(configuration, twist, tool):
    """Return where the tip of a tool stands under load, and the platform's rotation."""
    o, R = stands_at(configuration, twist)
    return o + R.apply(tool), R


@pytest.mark.parametrize(("name", "given"), [("3rps", ("x", "y", "z")), ("3rps", None), ("linear_delta", None)])
def test_corrected_actuators_bring_the_tool_tip_to_target(name, given):
    """Three freedoms: the tip's position, or its height and two angles; actuators alone are prescribed."""
    robot, tool, load = package_robots.robot(name), np.array([0.05, -0.04, 0.2]), LOAD * SOFT.get(name, 1.0)
    pose = tripod() if name == "3rps" else robot.configuration(robot.model_q(robot.generic_poses)[:, 0])
    found = ks.compensate(pose, load, controlled=given, tool=tool)
    actuated = robot.assemble(actuators=found.actuators, near=pose)
    tip, R = tip_of(actuated, ks.analyze(actuated, load).twist, tool)
    wanted, wanted_R = tip_of(pose, np.zeros(6), tool)
    turn = R.as_rotvec() - wanted_R.as_rotvec()
    off = dict(zip(("x", "y", "z", "rx", "ry", "rz"), [*(tip - wanted), *turn], strict=True))
    assert found.controlled == (("z", "rx", "ry") if name == "3rps" and given is None else ("x", "y", "z"))
    assert max(abs(off[coordinate]) for coordinate in found.controlled) < 1e-12
    np.testing.assert_allclose(found.residual_error[:3], tip - wanted, atol=1e-12)
    before, _ = tip_of(pose, found.uncorrected.twist, tool)
    np.testing.assert_allclose(found.uncorrected_error[:3], before - wanted, atol=1e-15)
    # o itself is corrected to another place
    of_o = ks.compensate(pose, load)
    differences = [abs(float(found.actuators[drive] - of_o.actuators[drive])) for drive in found.actuators]
    assert max(differences) > 1e-3 * max(abs(float(shift)) for shift in of_o.corrections.values())
    assert found.to_dict()["tool"] == tool.tolist() and "the tool's tip is off by" in repr(found)
    assert ("of the tool's tip. Not corrected" in str(found)) and found.to_dict()["units"]["residual_error"]


def test_tool_is_irrelevant_when_all_six_freedoms_are_corrected():
    robot = package_robots.robot("gough_stewart")
    pose = robot.assemble(
        platform={"x": 0.02, "y": 0.0, "z": float(robot.assemble().platform["z"]), "rx": 0.1, "ry": 0.0, "rz": 0.05}
    )
    of_tip, of_o = (ks.compensate(pose, LOAD, tool=tool) for tool in ((0.1, 0, 0.3), None))
    for drive, value in of_o.actuators.items():
        assert of_tip.actuators[drive] == pytest.approx(float(value), abs=1e-12)
    assert np.max(np.abs(of_tip.residual_error)) < 1e-11 < 1e-8 < np.max(np.abs(of_tip.uncorrected_error))


def test_tool_tips_in_batches_and_uncontrollable_tool_tips():
    robot = package_robots.robot("3rps")
    path = robot.assemble(platform={"z": 0.5, "azimuth": 0.3, "tilt": [0.0, 0.1, 0.2]}, orientation="tilt_torsion")
    found = ks.compensate(path, LOAD, tool=(0, 0, 0.2))
    assert found.controlled == ("z", "azimuth", "tilt") and np.max(np.abs(found.residual_error[:, 2])) < 1e-12
    assert "displacement of the tool's tip" in str(found) and "Corrected: z, azimuth and tilt of the tool's tip" in str(found)
    one = ks.compensate(
        robot.assemble(platform={"z": 0.5, "azimuth": 0.3, "tilt": 0.2}, orientation="tilt_torsion"), LOAD, tool=(0, 0, 0.2)
    )
    np.testing.assert_allclose(found.residual_error[2], one.residual_error, atol=1e-14)
    # at o itself no actuator moves the upright tripod sideways
    with pytest.raises(ks.exceptions.CoordinatesError, match="cannot set x, y and z of the tool's tip"):
        ks.compensate(tripod(rx=0.0, ry=0.0), LOAD, controlled=("x", "y", "z"), tool=(0, 0, 0))
    with pytest.raises(ks.exceptions.CoordinatesError, match="mobility"):
        ks.compensate(tripod(), LOAD, controlled=("x", "y"), tool=(0, 0, 0.2))
    with pytest.raises(ks.exceptions.CoordinatesError, match="no platform coordinate 'u'"):
        ks.compensate(tripod(), LOAD, controlled=("x", "y", "u"), tool=(0, 0, 0.2))


def test_correction_is_not_just_the_negative_twist():
    """A soft tripod sags differently at the commanded pose: a first step alone would miss."""
    robot = package_robots.robot("3rps", rod_diameter=0.004)
    pose = robot.assemble(platform={"z": 0.5, "rx": 0.1, "ry": -0.1})
    found = ks.compensate(pose, LOAD)
    first = {name: pose.platform[name] - found.residual_error_coordinates[name] for name in found.controlled}
    before = ks.analyze(pose, LOAD).twist
    naive = robot.assemble(platform={"z": 0.5 - before[2], "rx": 0.1 - before[3], "ry": -0.1 - before[4]}, near=pose)
    missed = naive.platform["z"] + ks.analyze(naive, LOAD).twist[2] - 0.5
    assert abs(missed) > 1e-9 > 1e-12 > abs(first["z"] - 0.5)


def test_batch_corrections_equal_single_corrections():
    robot = package_robots.robot("five_bar")
    poses = robot.assemble(platform={"x": 0.01, "y": [0.28, 0.3, 3.0, 0.32]})
    loads = np.stack([LOAD, 2 * LOAD])[:, None] / 10
    found, drive = ks.compensate(poses, loads), robot.description.actuated[1]
    assert found.shape == (2, 4) and found.residual_error.shape == (2, 4, 6)
    one = ks.compensate(robot.assemble(platform={"x": 0.01, "y": 0.32}), 0.2 * LOAD)
    np.testing.assert_allclose(found.actuators[drive][1, 3], one.actuators[drive], atol=1e-14)
    np.testing.assert_allclose(found.residual_error[1, 3], one.residual_error, atol=1e-14)
    failed = ~poses.reached
    assert failed.tolist() == [False, False, True, False] and np.array_equal(found.status[0] == ks.Status.UNREACHABLE, failed)
    assert np.isnan(found.actuators[drive][:, failed]).all() and np.isnan(found.residual_error[:, failed]).all()
    assert not found.residual_error.flags.writeable and not found.actuators[drive].flags.writeable
    assert "2 poses" not in str(found) and "UNREACHABLE" in str(found) and "batch shape (2, 4)" in repr(found)


def test_corrections_beyond_actuator_limits_set_the_status():
    robot = package_robots.robot("3rps", rod_diameter=0.002)
    upper = robot.mechanism.connections["prismatic_1"].upper
    start = robot.assemble(actuators=dict.fromkeys(robot.description.actuated, upper - 1e-6))
    found = ks.compensate(start, [0, 0, -2000, 0, 0, 0])
    assert start.status == ks.Status.OK and found.status == ks.Status.LIMIT_EXCEEDED
    assert found.actuators["prismatic_1"] > upper and abs(found.residual_error[2]) < 1e-12
    assert "beyond" in str(found) and "prismatic_1 is beyond its limits" in str(found)


def test_stiff_robots_are_corrected_in_few_steps(monkeypatch):
    """The sag of a stiff robot is nearly the same beside a pose: the second step leaves nothing to do."""
    calls, learnt = [], BroydenSearch.updated
    monkeypatch.setattr(BroydenSearch, "updated", lambda self, *args: calls.append(1) or learnt(self, *args))
    ks.compensate(tripod(), LOAD)
    assert len(calls) <= 3


def off_by(found, load, gravity=(0, 0, -9.81)):
    """Return by how much (N,) the controlled coordinates are off where the actuators lead from the target poses."""
    actuated = found.target.robot.assemble(actuators=found.actuators, near=found.target)
    result = ks.analyze(actuated, load, gravity, on_failure="nan")
    orientation, angles = found.target.orientation, found.target.orientation.coordinates(target_frame(found.target, None)[0])
    rows = [*(loaded_frame(result, None)[1] - target_frame(found.target, None)[1])]
    rows += [*(orientation.coordinates(loaded_frame(result, None)[0], near=angles) - angles)]
    off = dict(zip(orientation.pose_names, rows, strict=True))
    return np.max([np.abs(off[name]) for name in found.controlled], axis=0)


def test_corrections_into_another_assembly_mode_are_rejected():
    """Two drives of 1 kN·m/rad and 100 N, over all poses of a grid: the search ends in another assembly mode at one of them."""
    robot = package_robots.soft_five_bar()
    first, second = np.meshgrid(*[np.linspace(-0.8, 0.8, 16)] * 2, indexing="ij")
    load = [-100, 0, 0, 0, 0, 0]
    found = ks.compensate(robot.assemble(actuators={"shoulder_1": first, "shoulder_2": second}), load)
    good = found.status == ks.Status.OK
    assert 100 < good.sum() and np.max(off_by(found, load).reshape(good.shape)[good]) < 1e-9
    # the platform's coordinates lead to the pose found there, its actuators to another
    lost = robot.assemble(actuators={"shoulder_1": first[12, 10], "shoulder_2": second[12, 10]})
    assert found.status[12, 10] == ks.Status.UNREACHABLE and lost.status == ks.Status.OK
    with pytest.raises(ks.StaticsError, match="into another assembly mode, beyond a singular pose"):
        ks.compensate(lost, load)
    # large motions cause a warning in all results
    pose = robot.assemble(actuators={"shoulder_1": 0.1, "shoulder_2": 0.2})
    load[0] = -800
    some = ks.compensate(pose, load)
    assert some.warnings == some.result.warnings and any(
        "too much for linear theory" in text for text in some.to_dict()["warnings"]
    )
    for text in (str(some), str(ks.compensate(pose, [load, load]))):
        assert "too much for linear theory" in " ".join(text.split())


@pytest.mark.few(1)
@pytest.mark.parametrize(("kinds", "seed"), BEYOND)
def test_random_robots_get_no_corrections_beyond_singular_poses(kinds, seed):
    """Loads that would move them by up to 0.6 of their size: the search leads into other modes at some."""
    robot = sr.write(sr.random_spec(kinds, seed), twirl=seed).robot()
    pose = robot.configuration(robot.model_q(robot.generic_poses)[:, 0])
    wrench = np.random.default_rng(seed).standard_normal(6) * np.repeat([1, robot.length], 3)
    twist = ks.analyze(pose, wrench, (0, 0, 0)).twist
    size = max(np.linalg.norm(twist[:3]) / robot.length, np.linalg.norm(twist[3:]))
    loads = wrench / size * np.linspace(-0.6, 0.6, 16)[:, None]
    found = ks.compensate(pose, loads, (0, 0, 0))
    good = found.status <= ks.Status.LIMIT_EXCEEDED
    assert good.any() and not good.all()
    assert np.max(off_by(found, loads, (0, 0, 0))[good]) < 1e-9 * max(1, robot.length)


def test_targets_out_of_reach_are_refused():
    """The arms of the five-bar are stretched: to be commanded farther out, against the load, they would have to be longer."""
    robot = package_robots.robot("five_bar")
    far = robot.assemble(platform={"x": 0.0, "y": np.array([0.3, *np.linspace(0.4, 0.8, 81)])}, on_failure="nan")
    last = np.flatnonzero(far.reached)[-1]
    inside = robot.assemble(platform={"x": 0.0, "y": 0.3})
    edge = robot.configuration(far.q[last])
    pull = [0, -4e5, 0, 0, 0, 0]
    with pytest.raises(ks.AssemblyError, match=r"no actuator positions .* target in x, y; the unloaded robot cannot reach"):
        ks.compensate(edge, pull, controlled=("x", "y"))
    found = ks.compensate(edge, pull, controlled=("x", "y"), on_failure="nan")
    assert found.status == ks.Status.UNREACHABLE and np.isnan(found.residual_error).all()
    assert "no actuator positions" in str(found)
    assert ks.compensate(inside, [0, -40, 0, 0, 0, 0]).status == ks.Status.OK


def test_default_controlled_coordinates_are_prescribed_or_best_conditioned():
    robot = package_robots.robot("3rps")
    assert ks.compensate(tripod()).controlled == ("z", "rx", "ry")
    tilted = robot.assemble(platform={"z": 0.5, "azimuth": 0.4, "tilt": 0.0}, orientation="tilt_torsion")
    found = ks.compensate(tilted, LOAD)
    assert found.controlled == ("z", "azimuth", "tilt")
    # tilt 0 has no azimuth; the target is the direction of the platform's normal
    normal = (stands_at(found.configuration, found.result.twist)[1]).apply([0, 0, 1])
    np.testing.assert_allclose(normal, [0, 0, 1], atol=1e-12)
    drives = robot.assemble(actuators={"prismatic_1": 0.0, "prismatic_2": 0.01, "prismatic_3": -0.01})
    assert drives.prescribed == () and ks.compensate(drives).controlled == ("z", "rx", "ry")
    assert best_choice(robot, drives.orientation, drives.poses) == ("z", "rx", "ry")
    other = ks.compensate(drives, LOAD, controlled=["x", "y", "z"], orientation="XYZ")
    assert np.abs(other.residual_error[:3]).max() < 1e-12 < np.abs(other.residual_error[3:]).max()
    assert set(other.residual_error_coordinates) == {"x", "y", "z", "rx", "ry", "rz"}
    assert ks.compensate(tripod(), orientation="tilt_torsion").controlled == ("z", "azimuth", "tilt")


def test_unreached_poses_are_not_corrected():
    """Arms that point apart: no loop closes, and no pose determines the best coordinates."""
    robot = package_robots.robot("five_bar")
    apart = robot.assemble(actuators={"shoulder_1": [0.9, 1.0], "shoulder_2": [-0.9, -1.0]}, on_failure="nan")
    found = ks.compensate(apart)
    assert not apart.reached.any() and found.controlled == ("x", "y")
    assert np.all(found.status == ks.Status.UNREACHABLE) and np.isnan(found.residual_error).all()


def test_closure_tolerance_is_that_of_the_pose_by_default():
    pose = odd_robots.rounded_angles().assemble(closure_tolerance=1e-3)
    found = ks.compensate(pose, [5, 0, -10, 0, 0, 0])
    assert 1e-10 < found.configuration.residual < 1e-3 and found.status == ks.Status.OK
    with pytest.raises(ks.AssemblyError, match="do not close"):
        ks.compensate(pose, [5, 0, -10, 0, 0, 0], closure_tolerance=1e-12)


def test_further_arguments_are_passed_to_analyze():
    pose = tripod()
    at_tool = ks.compensate(pose, [50, 0, 0, 0, 0, 0], point=(0, 0, 0.2), frame="platform", gravity=(0, 0, 0))
    expected = ks.analyze(at_tool.configuration, [50, 0, 0, 0, 0, 0], point=(0, 0, 0.2), frame="platform", gravity=(0, 0, 0))
    np.testing.assert_allclose(at_tool.result.twist, expected.twist, atol=1e-16)
    length = ks.compensate(pose, gravity=(0, 0, 0), assembly_errors={"rod_1": {"length": 1e-4}})
    # a rod that is too long by 0.1 mm is actuated back by that, nearly: it stands askew
    assert length.corrections["prismatic_1"] == pytest.approx(-1e-4, rel=2e-2)
    assert max(abs(length.corrections[f"prismatic_{k}"]) for k in (2, 3)) < 5e-6


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"controlled": ("z", "rx")}, "give exactly 3"),
        ({"controlled": "z"}, "sequence of names"),
        ({"controlled": ("z", "rx", "tilt")}, "no platform coordinate"),
        ({"controlled": ("x", "rx", "rz"), "gravity": (0, 0, 0)}, "x, rx, rz do not determine the pose"),
    ],
)
def test_invalid_controlled_coordinates_are_refused(options, message):
    with pytest.raises((ks.ArgumentError, ks.exceptions.CoordinatesError), match=message):
        ks.compensate(tripod(), **options)


def test_invalid_robots_and_files_are_refused(tmp_path):
    pose = tripod()
    with pytest.raises(ks.ArgumentError, match="needs a Configuration"):
        ks.compensate(pose.robot)
    with pytest.raises(ks.ArgumentError, match="has no actuators"):
        ks.compensate(two_columns().assemble())
    found = ks.compensate(pose)
    with pytest.raises(ks.ArgumentError, match=r"does not end in \.csv"):
        found.save(tmp_path / "table.txt")
    with pytest.raises(ks.ArgumentError, match="cannot be written: No such file"):
        found.save(tmp_path / "none" / "table.csv")
    with pytest.raises(ks.ArgumentError, match="axes have the sizes"):
        found.to_dataset({"z": [1, 2]})


def test_saved_tables_and_datasets_have_all_corrections(tmp_path):
    import xarray as xr

    robot = package_robots.robot("3rps")
    z, rx = np.array([0.45, 0.5]), np.array([-0.1, 0.0, 0.1])
    grid = robot.assemble(platform={"z": z[:, None], "rx": rx, "ry": 0.0})
    found = ks.compensate(grid, LOAD)
    found.save(tmp_path / "table.csv")
    with open(tmp_path / "table.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 6 and {row["status"] for row in rows} == {"OK"}
    assert float(rows[4]["prismatic_1 [m]"]) == pytest.approx(found.actuators["prismatic_1"][1, 1], abs=1e-15)
    assert float(rows[4]["force of prismatic_1 [N]"]) == pytest.approx(found.actuator_forces["prismatic_1"][1, 1])
    assert float(rows[5]["residual_error x [m]"]) == pytest.approx(found.residual_error[1, 2, 0])
    assert float(rows[5]["z [m]"]) == 0.5 and float(rows[5]["rx [rad]"]) == pytest.approx(0.1)
    found.save(tmp_path / "grid.nc", {"z": z, "rx": rx})
    with xr.open_dataset(tmp_path / "grid.nc", engine="h5netcdf") as ds:
        one = ds.sel(z=0.5, rx=0.1, actuator="prismatic_3")
        assert float(one.actuator_correction) == found.corrections["prismatic_3"][1, 2]
        np.testing.assert_array_equal(one.uncorrectable_direction, found.uncorrectable_directions[1, 2])
        np.testing.assert_array_equal(one.uncorrectable_part, found.uncorrectable_parts[1, 2])
        assert str(one.actuator_force_unit.values) == "N" and ds.attrs["controlled"] == "z rx ry"
    assert found.to_dataset().status.dims == ("pose_1", "pose_2")
    single = ks.compensate(tripod(), LOAD)
    assert single.to_dataset().status.dims == () and json.loads(json.dumps(single.to_dict()))["status"] == "OK"


# ---- uncorrectable directions -------------------------------------------------------------------------------------------------


def motions_of_drives(pose, tool):
    """Return the platform's twists (6, n) at the tool per actuator, by differences of poses."""
    step, columns = 1e-5, []
    for name in pose.actuators:
        ends = []
        for sign in (1, -1):
            given = {key: value + sign * step * (key == name) for key, value in pose.actuators.items()}
            ends.append(pose.robot.assemble(actuators=given, near=pose).platform_frame)
        turn = Rotation.from_matrix(ends[0][:3, :3] @ ends[1][:3, :3].T).as_rotvec()
        shift = (ends[0][:3, 3] + ends[0][:3, :3] @ tool) - (ends[1][:3, 3] + ends[1][:3, :3] @ tool)
        columns.append(np.concatenate([shift, turn]) / (2 * step))
    return np.stack(columns, axis=1)


@pytest.mark.parametrize("tool", [None, (0.03, 0.0, 0.2)])
def test_no_actuator_moves_along_uncorrectable_directions(tool):
    found = ks.compensate(tripod(), LOAD, tool=tool)
    directions, scale = found.uncorrectable_directions, np.repeat([found.target.robot.length, 1.0], 3)
    assert directions.shape == (6, 3) and found.uncorrectable_parts.shape == (3,)
    unit = directions / scale[:, None]
    np.testing.assert_allclose(unit.T @ unit, np.eye(3), atol=1e-12)
    moves = motions_of_drives(found.configuration, np.array(tool or (0, 0, 0))) / scale[:, None]
    assert np.linalg.matrix_rank(moves, 1e-3) == 3
    np.testing.assert_allclose(unit.T @ (moves / np.linalg.norm(moves, axis=0)), 0, atol=1e-8)
    # the actuators could move the rest: which part of it they correct depends on the controlled coordinates
    rest = (found.residual_error - directions @ found.uncorrectable_parts) / scale
    fit = moves @ np.linalg.lstsq(moves, rest, rcond=None)[0]
    np.testing.assert_allclose(fit, rest, atol=1e-8 * np.linalg.norm(found.residual_error / scale))


def test_uncorrectable_parts_do_not_depend_on_controlled_coordinates():
    """They are those of the uncorrected error."""
    pose = tripod()
    scale = np.repeat([pose.robot.length, 1.0], 3)
    both = [ks.compensate(pose, LOAD, controlled=names) for names in (("z", "rx", "ry"), ("z", "y", "ry"))]
    size = np.linalg.norm(both[0].uncorrectable_parts)
    assert np.abs(both[0].residual_error - both[1].residual_error).max() > 0.1 * np.abs(both[0].residual_error).max()
    np.testing.assert_allclose(both[0].uncorrectable_parts, both[1].uncorrectable_parts, atol=1e-3 * size)
    before = (both[0].uncorrectable_directions / scale[:, None]).T @ (both[0].uncorrected_error / scale)
    np.testing.assert_allclose(both[0].uncorrectable_parts, before, atol=1e-3 * size)


def test_uncorrectable_directions_of_batches_and_hexapods():
    five_bar = package_robots.robot("five_bar")
    far = ks.compensate(five_bar.assemble(platform={"x": 0.0, "y": np.array([0.3, 0.9])}, on_failure="nan"), [0, -4, 0, 0, 0, 0])
    assert far.status[1] == ks.Status.UNREACHABLE and far.uncorrectable_directions.shape == (2, 6, 4)
    assert np.all(np.isfinite(far.uncorrectable_directions[0])) and np.all(np.isnan(far.uncorrectable_directions[1]))
    found = ks.compensate(tripod(z=np.array([0.5, 0.55])), LOAD)
    assert found.uncorrectable_directions.shape == (2, 6, 3)
    one = ks.compensate(tripod(), LOAD)
    np.testing.assert_allclose(found.uncorrectable_directions[0], one.uncorrectable_directions, atol=1e-9)
    assert np.abs(np.diff(found.uncorrectable_directions, axis=0)).max() < 0.05  # the same ones along a path
    assert "The actuators cannot produce 3 twists" in str(found)
    text = str(one)
    assert "Twists that the actuators cannot produce, at o, world axes, displacements in units of 200.00 mm" in text
    assert one.to_dict()["uncorrectable_parts"] == one.uncorrectable_parts.tolist()
    hexapod = package_robots.robot("gough_stewart")
    all_six = ks.compensate(hexapod.assemble(), LOAD)
    assert all_six.uncorrectable_directions.shape == (6, 0) and "cannot produce" not in str(all_six)


def test_status_is_that_of_the_target_where_it_has_no_numbers():
    """Else it is that of the corrected pose."""
    status = ks.Status
    both = [[status.OK, status.SINGULAR, status.UNREACHABLE, status.OK], [status.OK, status.OK, status.OK, status.UNREACHABLE]]
    target, corrected = (SimpleNamespace(status=np.array(values)) for values in both)
    found = Compensation.status.func(SimpleNamespace(uncorrected=target, result=corrected))
    assert found.tolist() == [status.OK, status.SINGULAR, status.UNREACHABLE, status.UNREACHABLE]
