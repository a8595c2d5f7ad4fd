"""Calibration of robots whose deviations from their files are known, and messages where readings do not determine them."""

import json
import warnings

import numpy as np
import package_robots
import parametric_machines
import pytest
import small_robots
from places import ROBOTS

import kinetostatics as ks
from kinetostatics.calibration.fit import leave_one_out, solution
from kinetostatics.calibration.readings import Model, Readings
from kinetostatics.calibration.unknowns import Unknowns
from kinetostatics.description.elements import JointStiffness
from kinetostatics.files.parameter_units import UNITS
from kinetostatics.load_case import LoadCase

NAMES = ("z", "rx", "ry")
PAYLOAD = ks.Payload(5.0, (0.1, -0.02, 0.05))
TRUE = {"rod_1": 0.8, "rod_2": 1.1, "rod_3": 0.95}
#: A dial gauge that stands beside the platform, one that goes with it, and an inclinometer.
GAUGES = {
    "front": ks.Gauge((0, 0, 2), (0.3, 0.1, 0.5), sigma=1e-7),
    "tool": ks.Gauge((1, 0, 1), (0.1, 0.05, 0.1), "platform", sigma=2e-7),
    "level": ks.Gauge((0, 1, 0), None, "platform", "rotation", 1e-6),
}


def stiffened(description, factors):
    for name, factor in factors.items():
        modulus = description.beams[name].youngs_modulus
        description = description.changed(name, youngs_modulus=factor * modulus)
    return ks.Robot(description)


def read(gauge, pose, twist):
    """What a gauge reads: by two points of the platform, before and after it moves."""
    u = np.array(gauge.direction, dtype=float) / np.linalg.norm(gauge.direction)
    R = pose.frame("platform")[..., :3, :3]
    o = np.stack([pose.platform[name] for name in "xyz"], axis=-1)
    if gauge.frame == "platform":
        u = R @ u
    if gauge.measures == "rotation":
        return np.sum(u * twist[..., 3:], axis=-1)
    point = o if gauge.point is None else o + R @ np.array(gauge.point) if gauge.frame == "platform" else np.array(gauge.point)
    return np.sum(u * (twist[..., :3] + np.cross(twist[..., 3:], point - o)), axis=-1)


@pytest.fixture(scope="module")
def table():
    """Poses and loads of a tripod, and what its gauges read when its rods are not what the file says."""
    rng = np.random.default_rng(5)
    count = 14
    rows = {"z": 0.45 + 0.2 * rng.random(count), "rx": 0.25 * rng.standard_normal(count), "ry": 0.25 * rng.standard_normal(count)}
    load = np.zeros((count, 6))
    load[:, :3] = rng.uniform(-2000, 2000, (count, 3))
    pose = stiffened(package_robots.robot("3rps").description, TRUE).assemble(platform=rows)
    loaded = ks.analyze(pose, load, payload=PAYLOAD)
    unloaded = ks.analyze(pose, payload=PAYLOAD)
    loads = {f"F{axis}": load[:, k] for k, axis in enumerate("xyz")}
    return {"poses": rows, "loads": loads, "pose": pose, "loaded": loaded.twist, "unloaded": unloaded.twist}


def columns(table, twist, gauges=GAUGES, **offsets):
    readings = {name: read(gauge, table["pose"], twist) + offsets.get(name, 0.0) for name, gauge in gauges.items()}
    return {**table["poses"], **table["loads"], **readings}


def values(found):
    return {name: estimate.value for name, estimate in found.estimates.items()}


def test_stiffness_payload_and_offsets_are_recovered(table):
    unknowns = [*TRUE, "payload.mass", "payload.x", "payload.y", "payload.z", "offsets"]
    given = columns(table, table["loaded"], front=3e-6, level=-2e-5)
    found = ks.calibrate(package_robots.robot("3rps"), given, unknowns, gauges=GAUGES)
    expected = dict(zip(unknowns, [*TRUE.values(), 5.0, *PAYLOAD.center], strict=False))
    expected |= {"offset.front": 3e-6, "offset.tool": 0.0, "offset.level": -2e-5}
    assert values(found) == pytest.approx(expected, rel=1e-8, abs=1e-13)
    assert found.converged and not found.unidentifiable and not found.outliers and found.reduced_chi_square < 1e-12
    np.testing.assert_allclose(found.computed, found.measured, rtol=0, atol=1e-14)
    assert found.payload.mass == pytest.approx(5.0, rel=1e-8)
    again = ks.analyze(found.robot.assemble(platform=table["poses"]), table["loaded"] * 0, payload=found.payload).twist
    np.testing.assert_allclose(again, table["unloaded"], atol=1e-13)
    assert found.degrees_of_freedom == 3 * 14 - 10 and len(found.measured) == 42
    errors, of_lengths = np.arange(42.0), np.array([name != "level" for name in found.gauge_of])
    for kind, mine in (("length", of_lengths), ("angle", ~of_lengths)):
        assert found.root_mean_square(errors, kind) == pytest.approx(np.sqrt(np.mean(errors[mine] ** 2)))


def test_calibration_with_unloaded_state_or_pose_as_reference(table):
    robot = package_robots.robot("3rps")
    found = ks.calibrate(
        robot, columns(table, table["loaded"] - table["unloaded"]), list(TRUE), gauges=GAUGES, reference="unloaded"
    )
    assert values(found) == pytest.approx(TRUE, rel=1e-8)
    # the gauges that go with the platform were set to zero at one pose
    zero = {"z": 0.5, "rx": 0.0, "ry": 0.0}
    pose = stiffened(robot.description, TRUE).assemble(platform=zero)
    start = ks.analyze(pose, payload=PAYLOAD).twist
    moving = {name: gauge for name, gauge in GAUGES.items() if name != "front"}
    given = columns(table, table["loaded"], moving)
    for name, gauge in moving.items():
        given[name] = given[name] - read(gauge, pose, start)
    found = ks.calibrate(robot, given, list(TRUE), gauges=moving, reference=zero, payload=PAYLOAD)
    assert values(found) == pytest.approx(TRUE, rel=1e-8)


def test_common_stiffness_factor_and_interval_have_closed_form(table):
    """E of all rods by one factor; its interval is that of the compliance."""
    pose = package_robots.robot("3rps").assemble(platform=table["poses"])
    load = np.stack([*table["loads"].values(), *([np.zeros(14)] * 3)], axis=-1)
    twist = ks.analyze(pose, load).twist
    noise = 1e-6 * np.random.default_rng(1).standard_normal(14)
    rows = {**table["poses"], **table["loads"], "dz": twist[:, 2] / 0.9 + noise}
    found = ks.calibrate(package_robots.robot("3rps"), rows, ["rod_1 + rod_2+rod_3"])
    estimate = found.estimates["rod_1 + rod_2+rod_3"]
    # readings are linear in the compliance: c = Σ y a / Σ a²
    a, y = twist[:, 2], rows["dz"]
    c = y @ a / (a @ a)
    error = np.sqrt(np.sum((y - c * a) ** 2) / 13 / (a @ a))
    assert estimate.value == pytest.approx(1 / c, rel=1e-7) and estimate.standard_error == pytest.approx(error / c**2, rel=1e-6)
    from scipy import stats

    reach = stats.t.ppf(0.975, 13) * error
    assert estimate.interval == pytest.approx((1 / (c + reach), 1 / (c - reach)), rel=1e-6)
    assert found.sigma[0] == pytest.approx(np.sqrt(np.sum((y - c * a) ** 2) / 13), rel=1e-6)


def test_file_arguments_of_a_cantilever_are_recovered(tmp_path):
    """The sag goes as the diameter to the power of −4; the length moves the tip."""
    path = parametric_machines.cantilever(tmp_path)
    true = ks.load_robot(path, {"diameter": 0.042, "length": 0.81})
    loads = [[0, 0, -300, 0, 0, 0], [0, 200, 0, 0, 0, 0], [0, 0, 0, 0, 30, 0], [4e5, 0, 0, 0, 0, 0]]
    twists = ks.analyze(true.assemble(), loads).twist
    rows = [
        {"Fx": w[0], "Fy": w[1], "Fz": w[2], "My": w[4], "dx": t[0], "dy": t[1], "dz": t[2]}
        for w, t in zip(loads, twists, strict=True)
    ]
    found = ks.calibrate(ks.load_robot(path), rows, ["diameter", "length"])
    assert values(found) == pytest.approx({"diameter": 0.042, "length": 0.81}, rel=1e-8)
    assert found.estimates["diameter"].unit == "m" and found.estimates["diameter"].start == 0.04
    found.save(tmp_path / "mine.urdf")
    again = ks.analyze(ks.load_robot(tmp_path / "mine.urdf").assemble(), loads).twist
    np.testing.assert_allclose(again, twists, rtol=1e-8, atol=1e-15)


def test_argument_that_moves_the_platform_frame(tmp_path):
    """The coordinates of a pose are those of o, wherever the argument puts it: no joint of the file depends on it."""
    text = (ROBOTS / "3rps.urdf.xacro").read_text(encoding="utf-8")
    text = text.replace('<platform link="platform"/>', '<platform link="platform"><origin xyz="0 0 $(arg reach)"/></platform>')
    path = tmp_path / "reaching.urdf.xacro"
    path.write_text(text.replace("<xacro:arg", '<xacro:arg name="reach" default="0.1"/><xacro:arg', 1), encoding="utf-8")
    poses, force = {"z": [0.65, 0.7], "rx": [0.0, 0.2], "ry": [0.1, 0.0]}, [[500, 0, -2000, 0, 0, 0], [0, 800, -2000, 0, 0, 0]]
    twist = ks.analyze(ks.load_robot(path, {"reach": 0.14}).assemble(platform=poses), force).twist
    rows = poses | dict(
        zip(("Fx", "Fy", "Fz", "dx", "dy", "dz"), np.hstack([np.array(force)[:, :3], twist[:, :3]]).T, strict=True)
    )
    assert values(ks.calibrate(ks.load_robot(path), rows, ["reach"])) == pytest.approx({"reach": 0.14}, rel=1e-8)


def test_rods_in_series_are_distinguished_only_by_bending(tmp_path):
    """Pulled along both, their compliances add up as their lengths; bending distinguishes them."""
    spec = small_robots.locked_chain([(0, 0, 0), (0, 0, 1.0), (0, 0, 1.5)], [(1, 0, 0), (0, 1, 0)])
    robot = small_robots.robot_of(spec)
    factors = {"arm_1": 0.5, "arm_2": 2.0}
    pose = stiffened(robot.description, factors).assemble()
    loads = np.zeros((3, 6))
    loads[:, 2] = [1e4, 2e4, -1e4]
    dz = ks.analyze(pose, loads, (0, 0, 0)).twist[:, 2]
    found = ks.calibrate(robot, {"Fz [kN]": loads[:, 2] / 1e3, "dz [um]": 1e6 * dz}, [*factors], reference="unloaded")
    (told,) = found.unidentifiable
    assert "the compliance of arm_1 and the compliance of arm_2 cannot be distinguished" in told.words
    assert "the compliance of arm_1 + 0.5 times the compliance of arm_2" in told.words
    assert told.direction["arm_1"] / told.direction["arm_2"] == pytest.approx(-0.5, rel=1e-6)
    for estimate in found.estimates.values():
        assert not estimate.identified and estimate.interval == (0, np.inf)
    seen = [1 / found.estimates[name].value for name in factors]
    assert seen[0] + 0.5 * seen[1] == pytest.approx(1 / 0.5 + 0.5 / 2.0, rel=1e-9)  # the identifiable combination is found
    assert "cannot be distinguished" in str(found) and "1 not determined" in repr(found)
    # a payload does not change differences to the unloaded state
    found = ks.calibrate(robot, {"Fz": loads[:, 2], "dz": dz}, ["arm_1", "payload.mass"], reference="unloaded")
    assert found.unidentifiable[0].words.startswith("no reading depends on payload.mass")
    assert found.estimates["arm_1"].identified
    bent = np.concatenate([loads, [[100, 0, 0, 0, 0, 0]]])
    twist = ks.analyze(pose, bent, (0, 0, 0)).twist
    found = ks.calibrate(
        robot, {"Fz": bent[:, 2], "Fx": bent[:, 0], "dz": twist[:, 2], "dx": twist[:, 0]}, [*factors], gravity=(0, 0, 0)
    )
    assert not found.unidentifiable and values(found) == pytest.approx(factors, rel=1e-8)


@pytest.mark.slow
def test_actuator_and_beam_stiffness_are_recovered_together():
    """An arm on an elastic actuator: both deform, and the actuator turns by moment over stiffness."""
    spec = small_robots.locked_chain([(0, 0, 0), (0.8, 0, 0)], [(0, 1, 0)])
    description = small_robots.robot_of(spec).description
    description = description.with_part(ks.description.JointStiffness("turn_1", drive=4e4))
    robot = ks.Robot(description)
    rows = {"Fz": [-200, -100, 0.0], "Fx": [0, 0, 1e5]}
    load = np.zeros((3, 6))
    load[:, 2], load[:, 0] = rows["Fz"], rows["Fx"]
    true = description.with_part(ks.description.JointStiffness("turn_1", drive=3e4))
    twist = ks.analyze(stiffened(true, {"arm_1": 1.2}).assemble(), load).twist
    rows |= {"dx": twist[:, 0], "dz": twist[:, 2]}
    for name in ("turn_1", "actuators:turn_1"):
        found = ks.calibrate(robot, rows, ["arm_1", name])
        assert values(found) == pytest.approx({"arm_1": 1.2, name: 0.75}, rel=1e-8)
    # the same as numbers of parts: E grows as the stiffness, at equal ν
    modulus = description.beams["arm_1"].youngs_modulus
    found = ks.calibrate(robot, rows, ["arm_1.youngs_modulus", "turn_1.actuator_stiffness"])
    assert values(found) == pytest.approx({"arm_1.youngs_modulus": 1.2 * modulus, "turn_1.actuator_stiffness": 3e4}, rel=1e-8)
    assert [estimate.unit for estimate in found.estimates.values()] == ["Pa", "N·m/rad"]


@pytest.mark.parametrize("sigma_known", [True, False])
def test_confidence_intervals_cover_at_their_level(table, sigma_known):
    """Linear readings with noise: each unknown is covered in 90 % of trials, within three binomial standard deviations."""
    from scipy import stats

    rng, trials = np.random.default_rng(11), 400
    J = np.stack(
        [read(GAUGES["front"], table["pose"], table["loaded"] * np.cos(k * np.arange(14))[:, None]) for k in range(3)], -1
    )
    J, true, sigma = J / 1e-6, np.array([1.2, 0.8, 1.0]), 0.7
    inside = np.zeros(3)
    for _ in range(trials):
        noisy = J @ true + sigma * rng.standard_normal(14)
        x = np.linalg.lstsq(J, noisy, rcond=None)[0]
        scale = sigma if sigma_known else 1.0
        found = solution(x, J / scale, (noisy - J @ x) / scale, sigma_known)
        wide = stats.norm.ppf(0.95) if sigma_known else stats.t.ppf(0.95, found.degrees_of_freedom)
        inside += np.abs(x - true) <= wide * np.sqrt(np.diag(found.covariance))
    assert np.all(np.abs(inside / trials - 0.9) <= 3 * np.sqrt(0.9 * 0.1 / trials)), inside


def test_outliers_are_found_and_left_out_on_request(table):
    given = columns(table, table["loaded"])
    rng = np.random.default_rng(4)
    for name, gauge in GAUGES.items():
        given[name] = given[name] + 0.5 * gauge.sigma * rng.standard_normal(14)
    given["tool"][6] += 8e-6
    given["front"][9] -= 3e-6
    robot = package_robots.robot("3rps")
    unknowns = [*TRUE, "payload.mass"]
    start = ks.Payload(5.0, PAYLOAD.center)
    kept = ks.calibrate(robot, given, unknowns, gauges=GAUGES, payload=start)
    assert {(item.row, item.gauge) for item in kept.outliers} == {(6, "tool"), (9, "front")}
    assert kept.reduced_chi_square > 10 and "outlier: row 6, tool" in str(kept) and kept.used.all()
    without = ks.calibrate(robot, given, unknowns, gauges=GAUGES, payload=start, leave_out_outliers=True)
    assert int(np.sum(~without.used)) == 2 and without.reduced_chi_square < 2 and "2 outliers were left out" in str(without)
    for name, value in TRUE.items():
        low, high = without.estimates[name].interval
        assert low < value < high, name
    assert abs(without.estimates["rod_1"].value - 0.8) < abs(kept.estimates["rod_1"].value - 0.8)


def test_leave_one_out_errors_equal_those_of_refits():
    rng = np.random.default_rng(8)
    J, groups = rng.standard_normal((12, 3)), np.repeat(np.arange(6), 2)
    y = J @ [1.0, 2.0, 3.0] + 0.1 * rng.standard_normal(12)
    x = np.linalg.lstsq(J, y, rcond=None)[0]
    errors = leave_one_out(solution(x, J, y - J @ x, False), groups)
    for group in range(6):
        rest = groups != group
        other = np.linalg.lstsq(J[rest], y[rest], rcond=None)[0]
        np.testing.assert_allclose(errors[~rest], y[~rest] - J[~rest] @ other, rtol=1e-10)
    # nothing predicts a reading that alone determines an unknown
    J = np.array([[1.0, 0], [1, 0], [0, 1]])
    errors = leave_one_out(solution(np.zeros(2), J, np.zeros(3), False), np.arange(3))
    assert np.isnan(errors[2]) and np.isfinite(errors[:2]).all()


def test_csv_files_datasets_and_columns_give_equal_estimates(table, tmp_path):
    """The same readings from a CSV in millimetres, an xarray Dataset and columns."""
    import xarray as xr

    robot, given = package_robots.robot("3rps"), columns(table, table["loaded"])
    path, sensors = tmp_path / "mine.csv", tmp_path / "gauges.csv"
    lines = ["z [mm],rx [deg],ry,Fx,Fy [kN],Fz,note,front [um],tool [mm],level [mrad]", ""]
    factors = {"z": 1e3, "rx": 180 / np.pi, "Fy": 1e-3, "front": 1e6, "tool": 1e3, "level": 1e3}
    for k in range(14):
        cells = {name: f"{factors.get(name, 1) * column[k]:.17g}" for name, column in given.items()}
        cells["tool"] = cells["tool"] if k else ""
        order = ("z", "rx", "ry", "Fx", "Fy", "Fz", "note", "front", "tool", "level")
        lines.append(",".join(cells.get(name, "cold") for name in order))
    path.write_text("\n".join(lines), encoding="utf-8")
    sensors.write_text(
        "name,x [mm],y [mm],z [mm],ux,uy,uz,frame,measures,sigma [um]\n"
        "front,300,100,500,0,0,2,world,displacement,0.1\ntool,100,50,100,1,0,1,platform,,0.2\n"
        "level,,,,,1,,platform,rotation,1urad\n",
        encoding="utf-8",
    )
    from_file = ks.calibrate(robot, path, list(TRUE), gauges=sensors, payload=PAYLOAD)
    assert values(from_file) == pytest.approx(TRUE, rel=1e-8)
    assert from_file.rows[0] == 3 and len(from_file.measured) == 41 and from_file.gauges["level"].sigma == 1e-6
    dataset = xr.Dataset({name: ("row", column) for name, column in given.items() if name != "z"}, {"z": ("row", given["z"])})
    dataset["z"] = ("row", 1e3 * given["z"], {"units": "mm"})
    assert values(ks.calibrate(robot, dataset, list(TRUE), gauges=GAUGES, payload=PAYLOAD)) == pytest.approx(TRUE, rel=1e-8)
    read_back = json.loads(json.dumps(from_file.to_dict()))
    assert read_back["estimates"]["rod_1"]["value"] == pytest.approx(0.8)
    text = str(from_file)
    assert "× 0.8" in text and "predicted from the other rows" in text and "41 readings of 14 rows" in text
    assert "Calibration of '3rps'" in repr(from_file) and "<table" in from_file._repr_html_()


WRONG = [
    ({"measurements": 3}, "measurements are 3; they must be a CSV file"),
    ({"measurements": {"dz": [1.0, 2.0], "Fz": [1.0, 2.0, 3.0]}}, "the columns are not equally long"),
    ({"measurements": {"Fz": [1.0]}}, "there are no readings"),
    ({"measurements": {"Fz [kg]": [1.0], "dz": [0.0]}}, "'1.0kg' is not a force"),
    ({"measurements": {"Fz": ["a lot"], "dz": [0.0]}}, "row 0: Fz: 'a lot' is not a force"),
    ({"measurements": {"dzz": [0.0]}}, "there is no column 'dzz'"),
    ({"measurements": [{"dz": 0.0, "z": 1.0}, {"dz": 0.1}]}, "row 1: z is missing"),
    ({"measurements": {"dz": [np.inf]}}, "row 0: dz: 'inf' is not a length"),
    ({"measurements": {"dz": [0.0], "dz [mm]": [0.0]}}, "'dz' is given twice"),
    ({"unknowns": []}, "unknowns are empty"),
    ({"unknowns": "diameter"}, "it must be a sequence of names"),
    ({"unknowns": ["diametre"]}, "has no 'diametre'.*did you mean 'diameter'"),
    ({"unknowns": ["rod", "beams:rod"]}, "'rod' is named twice"),
    ({"level": 95}, "it must be between 0 and 1"),
    ({"reference": "zero"}, "must be one of 'undeformed', 'unloaded'"),
    ({"reference": {"z": 0.1}}, "reference has the coordinates z"),
    ({"gravity": np.zeros((2, 3))}, "one vector .* for all rows"),
    ({"point": np.zeros((2, 3))}, "one vector .* for all rows"),
    ({"payload": 2.0}, "it must be a ks.Payload"),
    ({"gauges": {"tip": 3}}, "it must be a gauge"),
    ({"gauges": {"tip": ks.Gauge((0, 0, 0))}}, "direction must not be zero"),
    ({"gauges": {"tip": ks.Gauge((0, 0, 1), frame="tool")}}, "'world', 'platform'"),
    ({"gauges": {"dz": ks.Gauge((0, 0, 1), sigma=0)}}, "the standard deviation of a reading"),
    ({"measurements": {"dz": [0.1], "dry": [0.1]}}, "has no sigma"),
    ({"payload": ks.Payload(1.0, link="rod")}, "must be on the platform"),
    ({"robot": "cantilever"}, "calibrate needs a Robot"),
]


@pytest.fixture(scope="module")
def cantilever(tmp_path_factory):
    return ks.load_robot(parametric_machines.cantilever(tmp_path_factory.mktemp("files")))


@pytest.mark.parametrize(("changes", "said"), WRONG)
def test_invalid_arguments_are_refused(cantilever, changes, said):
    options = {"robot": cantilever, "measurements": {"Fz": [-10.0, -20.0], "dz": [-1e-6, -2e-6]}, "unknowns": ["diameter"]}
    with pytest.raises(ks.KinetostaticsError, match=said):
        ks.calibrate(**{**options, **changes})


def test_file_argument_of_a_changed_robot_is_refused_with_the_reason(cantilever):
    changed = ks.Robot(cantilever.description.changed("rod", density=1000.0))
    with pytest.raises(ks.ArgumentError, match=r"has no 'diameter'.*; the robot .* differs from its file"):
        ks.calibrate(changed, {"Fz": [-10.0], "dz": [-1e-6]}, ["diameter"])


WRONG_FILES = [
    ("Fz,dz\n", "a table of measurements has a line of titles"),
    ("Fz;dz\n1;2\n", r"mine.csv:1: separate columns by commas"),
    ("Fz,dz\n1,2\n\n1,2,3\n", r"mine.csv:4: 3 cells below 2 titles"),
    ("Fz [N],dz [um]\n1,2\n1,2 kN\n", r"mine.csv:3: dz: '2 kN' is not a length"),
    ("rx,dz\n,1\n", r"mine.csv:2: rx is missing: the cell is empty"),
    ("Fz,dz,speed\n1,1,1\n", r"mine.csv:1: there is no column 'speed'"),
    ("drx [mm],Fz\n1,2\n", r"mine.csv:2: drx: '1mm' is not an angle"),
]


@pytest.mark.parametrize(("text", "said"), WRONG_FILES)
def test_invalid_measurement_files_are_refused(cantilever, tmp_path, text, said):
    (tmp_path / "mine.csv").write_text(text, encoding="utf-8")
    with pytest.raises(ks.ArgumentError, match=said):
        ks.calibrate(cantilever, tmp_path / "mine.csv", ["diameter"])


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("name\n", "a table of gauges has a line of titles"),
        ("name,ux,uy,uz,colour\na,0,0,1,red\n", r":1: there is no column 'colour'"),
        ("name,ux,uy\na,0,1\n", r":1: the column 'uz' is missing"),
        ("name,ux,uy,uz\na,0,0,1\na,0,1,0\n", r":3: a gauge needs a unique name, got 'a'"),
        ("name,ux,uy,uz,x,y,z\na,0,0,1,1,,2\n", r":2: a coordinate x, y or z of the point is missing"),
        ("name,ux,uy,uz\na,0,0,0\n", r":2: direction and point must have three numbers"),
        ("name,ux,uy,uz,sigma [kg]\na,0,0,1,1\n", r":2: sigma: '1kg' is not a length"),
    ],
)
def test_invalid_gauge_files_are_refused(cantilever, tmp_path, text, said):
    (tmp_path / "gauges.csv").write_text(text, encoding="utf-8")
    with pytest.raises(ks.ArgumentError, match=said):
        ks.calibrate(cantilever, {"dz": [0.0]}, ["diameter"], gauges=tmp_path / "gauges.csv")


@pytest.mark.parametrize("mass", [["payload.mass"], []])
def test_jacobian_equals_central_differences_of_readings(mass):
    """An overconstrained robot, whose forces depend on stiffness."""
    robot = package_robots.robot("2pru_upr")
    load = np.array([[200.0, 0, -500, 0, 0, 30], [0, 300, 100, 20, 0, 0]])
    gauges = {"dx": ks.Gauge((1, 0, 0)), **GAUGES}
    readings = Readings(np.repeat([0, 1], 4), np.tile(np.arange(4), 2), gauges)
    names = ["rod_1", "rod_2+rod_3", "payload.x", "payload.z", "offset.tool", *mass]
    unknowns = Unknowns(robot, names, gauges, PAYLOAD, dict.fromkeys(gauges, 1e-5))
    model = Model(unknowns, {"z": np.array([0.6, 0.58]), "rx": np.array([0.1, -0.1]), "ry": np.array([0.0, 0.2])}, load, readings,
                  "undeformed", None, LoadCase())  # fmt: skip
    at = unknowns.start * np.array([0.8, 1.3, 0.9, 1, 1, 1.1])[: len(names)]
    J = model.jacobian(at) * unknowns.scale
    for k, step in enumerate(1e-4 * np.eye(len(names)) * unknowns.scale):
        expected = (model.predict(at + step) - model.predict(at - step)) / 2e-4
        np.testing.assert_allclose(J[:, k], expected, rtol=2e-6, atol=1e-6 * np.abs(expected).max(), err_msg=names[k])


@pytest.mark.parametrize(("name", "determinate"), [("3rps", True), ("2pru_upr", False)])
def test_readings_of_determinate_robots_are_linear_in_compliance(name, determinate):
    robot = package_robots.robot(name)
    unknowns = Unknowns(robot, ["rod_3"], {"dz": ks.Gauge((0, 0, 1)), "dy": ks.Gauge((0, 1, 0))}, None, {})
    pose = {"z": np.array([0.6]), "rx": np.array([-0.1]), "ry": np.array([0.2])}
    readings = Readings(np.zeros(2, dtype=int), np.arange(2), unknowns._gauges)
    model = Model(unknowns, pose, np.array([[0, 100.0, -500, 0, 0, 0]]), readings, "undeformed", None, LoadCase())
    soft, own, stiff = (model.predict(np.array([c])) for c in (2.0, 1.0, 0.5))
    ratios = (soft - own) / (2 * (own - stiff))
    assert np.allclose(ratios, 1, atol=1e-7) if determinate else np.all(np.abs(ratios - 1) > 0.05)


def test_repeated_rows_cause_a_warning(cantilever, tmp_path):
    """Copied readings are no further measurements; other readings at the same pose and load are."""
    text = "Fz,dz [um],dx [um]\n-10,-5,\n-20,-11,0\n-30,-15,\n-10,-5.1,\n"
    (tmp_path / "once.csv").write_text(text, encoding="utf-8")
    (tmp_path / "twice.csv").write_text(f"{text}-20,-11,0\n-10.0,-5,\n", encoding="utf-8")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ks.calibrate(cantilever, tmp_path / "once.csv", ["rod"])
    said = r"^\S*twice\.csv:6 has the pose, load and readings of \S*twice\.csv:3, and 1 more do so: .* intervals too narrow"
    with pytest.warns(UserWarning, match=said):
        ks.calibrate(cantilever, tmp_path / "twice.csv", ["rod"])
    with pytest.warns(UserWarning, match=r"^measurements, row 1 has the pose, load and readings of measurements, row 0: a"):
        ks.calibrate(cantilever, {"Fz": [-10, -10, -20], "dz": [-5e-6, -5e-6, -1e-5]}, ["rod"])


def test_poses_may_be_given_by_actuator_coordinates(table):
    """In a pandas DataFrame."""
    import pandas

    pose = table["pose"]
    rows = pandas.DataFrame({**pose.actuators, **table["loads"], "dz [mm]": 1e3 * table["loaded"][:, 2]})
    found = ks.calibrate(package_robots.robot("3rps"), rows, list(TRUE), payload=PAYLOAD)
    assert values(found) == pytest.approx(TRUE, rel=1e-6)


def test_unreachable_rows_are_named_in_errors(tmp_path):
    robot, table = package_robots.robot("delta"), tmp_path / "mine.csv"
    table.write_text("x,y,z [mm],dz [um]\n0,0,-700,-1\n\n0,0,-710,-1\n0,0,-2000,-1\n", encoding="utf-8")
    for reference in ("undeformed", "unloaded"):
        with pytest.raises(ks.AssemblyError, match=r"mine\.csv:5: 'delta' .* cannot reach") as told:
            ks.calibrate(robot, table, ["arm_1"], reference=reference)
        assert told.value.mobility == 3
    rows = {"x": [0.0], "y": [0.0], "z": [-0.7], "dz": [-1e-6]}
    with pytest.raises(ks.AssemblyError, match=r"^reference: 'delta'"):
        ks.calibrate(robot, rows, ["arm_1"], reference={"x": 0.0, "y": 0.0, "z": -2.0})
    with pytest.raises(ks.ArgumentError, match="it must be one pose, with a number for each coordinate"):
        ks.calibrate(robot, rows, ["arm_1"], reference={"x": 0.0, "y": 0.0, "z": [-0.7, -0.71]})


def test_singular_rows_are_named_in_errors():
    """A hexapod turned by a quarter about the vertical (Fichter, 1986)."""
    robot = package_robots.robot("gough_stewart")
    height = float(robot.assemble().platform["z"])
    rows = {
        "x": [0.0] * 2,
        "y": [0.0] * 2,
        "z": [height] * 2,
        "rx": [0.0] * 2,
        "ry": [0.0] * 2,
        "rz": [0.0, np.pi / 2],
        "dz": [1e-6] * 2,
    }
    with pytest.raises(ks.StaticsError, match=r"^measurements, row 1: readings cannot be computed: "):
        ks.calibrate(robot, rows, ["rod_1"])
    regular = {name: column[:1] for name, column in rows.items()}
    singular = {name: column[1] for name, column in rows.items() if name != "dz"}
    with pytest.raises(ks.StaticsError, match=r"^reference: readings cannot be computed: "):
        ks.calibrate(robot, regular, ["rod_1"], reference=singular)


def test_wrong_signs_and_units_are_reported(cantilever):
    """F L³ / 3 E I of the rod, with its weight left out: read well, with the wrong sign, and a thousand times too large."""
    diameter, loads = 0.04, np.array([-10.0, -20.0, -30.0])
    sag = loads * 0.8**3 / (3 * 2e11 * np.pi * diameter**4 / 64) * np.array([1.01, 0.99, 1.0])
    unexplained, odd = "residuals are almost as large as the readings", "rod: differs from the file by a factor of more than 100"
    for factor, words in ((1.0, ()), (-1.0, (unexplained,)), (1000.0, (odd,)), (1e-3, (odd,))):
        found = ks.calibrate(cantilever, {"Fz": loads, "dz": factor * sag}, ["rod"], gravity=(0, 0, 0))
        text = " ".join(str(found).split())
        assert [item for item in (unexplained, odd) if item in text] == list(words)
        if factor > 0:
            assert found.estimates["rod"].value == pytest.approx(1 / factor, rel=0.01)


@pytest.mark.parametrize("unit", UNITS[JointStiffness].values())
def test_stiffnesses_of_joints_are_never_negative(unit):
    estimate = ks.results.Estimate("joint", "argument", -1.0, unit, 1.0, (-2.0, 0.0), 0.5, True)
    assert estimate.impossible == "no stiffness is negative"


def test_impossible_estimates_are_reported(cantilever):
    """An upward reading needs a negative payload: a warning; or a tip of negative mass: an error."""
    with pytest.warns(UserWarning, match=r"payload\.mass is estimated as -\d+\.\d+ kg, and no mass is negative; check"):
        found = ks.calibrate(cantilever, {"dz": [1e-6]}, ["payload.mass"])
    assert found.estimates["payload.mass"].value < 0
    assert "payload.mass is not possible: no mass is negative." in " ".join(str(found).split())
    with pytest.raises(ks.ArgumentError, match=r"fit of tip_mass reached .* kg, and a further change yields no robot"):
        ks.calibrate(cantilever, {"dz": [1e-6]}, ["tip_mass"])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert ks.calibrate(cantilever, {"dz": [-1e-3]}, ["payload.mass"]).estimates["payload.mass"].impossible == ""


def test_assembly_errors_are_recovered_beside_stiffness():
    """A hinge is turned, one rod too long, and another softer than in the file."""
    robot = package_robots.robot("2pru_upr")
    poses = {"z": [0.55, 0.6, 0.65], "rx": [0.0, 0.1, -0.1], "ry": [0.0, -0.2, 0.1]}
    modulus = robot.description.beams["rod_1"].youngs_modulus
    soft = ks.Robot(robot.description.changed("rod_1", youngs_modulus=0.8 * modulus))
    errors = {"revolute_1": {"twist": [0, 0, 0, 0, 2e-4, 0], "frame": "joint"}, "rod_2": {"length": 3e-5}}
    load = np.tile([100.0, 50, -500, 0, 0, 0], (3, 1))
    twist = ks.analyze(soft.assemble(platform={k: np.array(v) for k, v in poses.items()}), load, assembly_errors=errors).twist
    rows = {**poses, "Fx": load[:, 0], "Fy": load[:, 1], "Fz": load[:, 2]}
    rows |= {name: twist[:, k] for k, name in enumerate(("dx", "dy", "dz", "drx", "dry", "drz"))}
    gauges = {
        name: ks.Gauge(tuple(np.eye(3)[k % 3]), measures=("displacement", "rotation")[k > 2], sigma=1e-7)
        for k, name in enumerate(("dx", "dy", "dz", "drx", "dry", "drz"))
    }
    wanted = {"rod_1.youngs_modulus": 0.8 * modulus, "revolute_1.error.ry": 2e-4, "rod_2.error.length": 3e-5}
    found = ks.calibrate(robot, rows, [*wanted, "rod_3"], gauges=gauges)
    assert {name: found.estimates[name].value for name in wanted} == pytest.approx(wanted, rel=1e-9)
    assert found.estimates["rod_3"].value == pytest.approx(1.0, rel=1e-4) and found.reduced_chi_square < 1e-6
    with pytest.raises(ks.ArgumentError, match="the errors of 'rod_2' are among the unknowns, too"):
        ks.calibrate(robot, rows, [*wanted], gauges=gauges, assembly_errors={"rod_2": {"length": 1e-5}})
