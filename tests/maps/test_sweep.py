"""Workspace maps: layout, agreement with single analyses, invalid arguments, the command and its documentation."""

import hashlib
import json
import re
from pathlib import Path

import numpy as np
import package_robots
import pytest
import xarray as xr
from maps import near
from page_code import run_python, text_of
from small_robots import four_bar, robot_of

import kinetostatics as ks
from kinetostatics.files.bundled import robot_path
from kinetostatics.files.reader import parse_robot_text
from kinetostatics.quantities import VARIABLES

GRID = {"z": np.linspace(0.45, 0.65, 5), "rx": np.linspace(-0.15, 0.15, 4), "ry": np.array([-0.1, 0.0, 0.12])}
LOAD = (10.0, -20.0, -500.0, 3.0, 0.0, 5.0)


def tripod(path, name, value, pattern, text):
    """Write the file of the 3RPS with one more argument, and a pattern replaced by a text with this argument."""
    head = f'<xacro:arg name="{name}" default="{value}"/>\n  <xacro:arg name="base_radius"'
    own = robot_path("3rps").read_text().replace('<xacro:arg name="base_radius"', head)
    changed = re.sub(pattern, text, own)
    assert changed != own
    path.write_text(changed)
    return path


@pytest.fixture(scope="module")
def robot():
    return package_robots.robot("3rps")


@pytest.fixture(scope="module")
def small(robot):
    return ks.sweep(robot, GRID, load=LOAD, outputs=["default", "beams"])


# ---- contents ----------------------------------------------------------------------------------------------------------


def check_pose(ds, at, result):
    """Assert that a map at one place equals the analysis of that pose."""
    here = ds.sel(at)

    def close(name, values):
        values = np.asarray(values)
        np.testing.assert_allclose(here[name].values, values, rtol=1e-9, atol=1e-10 * max(np.abs(values).max(), 1e-12))

    assert int(here["status"]) == int(result.status)
    close("twist", result.twist)
    for source, twist in result.contributions.items():
        np.testing.assert_allclose(here["contribution"].sel(source=source), twist, rtol=1e-8, atol=1e-16)
    close("stiffness", result.stiffness)
    close("compliance", result.compliance)
    close("actuator_force", list(result.actuator_forces.values()))
    close("actuator_position", list(result.configuration.actuators.values()))
    close("q", result.configuration.q)
    close("intensity", np.concatenate([limb.intensities for limb in result.limbs.values()]))
    close("attached_intensity", np.concatenate([limb.attached_intensities for limb in result.limbs.values()]))
    names = [(limb.name, label) for limb in result.limbs.values() for label in limb.labels]
    assert list(zip(here["limb"].values, here["label"].values, strict=True)) == names
    assert float(here["characteristic_length"]) == pytest.approx(result.robot.length, rel=1e-12)


def test_map_values_equal_those_of_single_analyses(robot, small):
    for z, rx, ry in ((0, 0, 0), (4, 3, 2), (2, 1, 0)):
        at = {"z": GRID["z"][z], "rx": GRID["rx"][rx], "ry": GRID["ry"][ry]}
        result = ks.analyze(robot.assemble(platform=at), load=LOAD)
        check_pose(small, at, result)
        here = small.sel(at)
        pose = result.configuration.platform
        np.testing.assert_allclose(here["platform_pose"], [pose[name] for name in "x y z rx ry rz".split()], atol=1e-13)
        for name, beam in result.beams.items():
            mine = here.sel(beam=name)
            assert float(mine["beam_stress"]) == pytest.approx(float(beam.stress), rel=1e-9)
            assert float(mine["beam_euler_ratio"]) == pytest.approx(float(beam.euler_ratio), rel=1e-9)
            assert float(mine["beam_deflection"]) == pytest.approx(np.linalg.norm(beam.deflections, axis=-1).max(), rel=1e-9)


def test_gravity_mechanisms_of_maps_equal_single_analyses(robot, small):
    assert not {"mechanism", "gravity_mechanism", "actuator_gravity_mechanism", "actuator_contribution"} & {
        *small.variables,
        *small.dims,
    }
    ds = ks.sweep(robot, GRID, load=LOAD, outputs=["default", "gravity_mechanisms"])
    assert ds["gravity_mechanism"].dims == ("z", "rx", "ry", "mechanism", "component")
    assert ds["actuator_gravity_mechanism"].dims == ("z", "rx", "ry", "actuator", "mechanism")
    assert ds["actuator_contribution"].dims == ("z", "rx", "ry", "actuator", "source")
    result = ks.analyze(robot.assemble(platform={"z": ds["z"][4], "rx": ds["rx"][3], "ry": ds["ry"][2]}), load=LOAD)
    here = ds.isel(z=4, rx=3, ry=2)
    twist, force = here["gravity_mechanism"], here["actuator_gravity_mechanism"]
    np.testing.assert_allclose(twist.sel(mechanism="platform_weight"), result.contributions["platform_weight"], rtol=1e-9)
    scale = np.abs(result.twist).max()
    for way in ("attached", "deformation"):
        wanted = sum(limb[way] for limb in result.mechanism_contributions.values())
        np.testing.assert_allclose(twist.sel(mechanism=way), wanted, rtol=0, atol=1e-11 * scale)
        for drive, limbs in result.actuator_mechanism_contributions.items():
            wanted = sum(limb[way] for limb in limbs.values())
            assert float(force.sel(actuator=drive, mechanism=way)) == pytest.approx(wanted, abs=1e-9)
    for drive, parts in result.actuator_contributions.items():
        mine = here["actuator_contribution"].sel(actuator=drive)
        np.testing.assert_allclose(mine, [parts[name] for name in mine["source"].values], rtol=0, atol=1e-9)
    load = ds["contribution"].sel(source="load")
    np.testing.assert_allclose(load + ds["gravity_mechanism"].sum("mechanism"), ds["twist"], rtol=0, atol=1e-12 * scale)


def test_dimensions_labels_and_units_of_a_map(small):
    grid = ("z", "rx", "ry")
    assert {name: small[name].dims[:3] for name in ("status", "mode", "twist", "stiffness", "q")} == dict.fromkeys(
        ("status", "mode", "twist", "stiffness", "q"), grid
    )
    assert small["contribution"].dims == (*grid, "source", "component")
    assert small["stiffness"].dims == (*grid, "component", "component_2")
    assert small["intensity"].dims == (*grid, "wrench")
    assert list(small["component"].values) == ["x", "y", "z", "rx", "ry", "rz"]
    assert list(small["component_unit"].values) == ["m"] * 3 + ["rad"] * 3
    assert list(small["source"].values) == ["load", "platform_weight", "limb_1", "limb_2", "limb_3"]
    assert small["z"].attrs["units"] == "m" and small["rx"].attrs["units"] == "rad"
    assert set(small["wrench_unit"].values) == {"N"} and set(small["actuator_position_unit"].values) == {"m"}
    assert str(small["stiffness_unit"].sel(component="rx", component_2="rz").values) == "N m/rad"
    assert str(small["compliance_unit"].sel(component="rx", component_2="x").values) == "rad/N"
    assert str(small["wrench"].values[0]) == "limb_1: force along limb axis at spherical_1"
    status = small["status"]
    assert status.dtype == np.int8 and status.attrs["flag_values"].dtype == np.int8
    assert status.attrs["flag_meanings"].split()[int(ks.Status.UNREACHABLE)] == "unreachable"
    assert len(status.attrs["flag_meanings"].split()) == len(status.attrs["flag_values"]) == len(ks.Status)


def test_map_attributes_record_file_version_and_arguments(small):
    path = robot_path("3rps")
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    assert small.attrs["robot_sha256"] == digest and json.loads(small.attrs["robot_files"]) == {str(path): digest}
    assert small.attrs["robot_name"] == "3rps" and small.attrs["kinetostatics_version"] == ks.__version__
    assert small.attrs["date"].endswith("+00:00") and small.attrs["Conventions"].startswith("CF-")
    arguments = json.loads(small.attrs["arguments"])
    assert arguments["load"] == list(LOAD) and arguments["platform"]["rx"] == GRID["rx"].tolist()
    assert small.attrs["mode_jumps"] == 0


def test_map_attributes_list_included_xacro_files(tmp_path):
    robot = ks.sweep("anymal_standing")
    files = json.loads(robot.attrs["robot_files"])
    assert len(files) == 2 and any(name.endswith("anymal.urdf") for name in files)
    for name, digest in files.items():
        with open(name, "rb") as file:
            assert hashlib.sha256(file.read()).hexdigest() == digest


# ---- other grids -------------------------------------------------------------------------------------------------------


def test_actuators_are_swept_and_scalars_held_constant(robot):
    ds = ks.sweep(robot, actuators={"prismatic_2": [0.0, 0.02, 0.03], "prismatic_1": 0.01, "prismatic_3": -0.01})
    assert ds["status"].dims == ("prismatic_2",)
    assert float(ds["prismatic_1"]) == 0.01 and ds["prismatic_1"].attrs["units"] == "m"
    result = ks.analyze(robot.assemble(actuators={"prismatic_1": 0.01, "prismatic_2": 0.03, "prismatic_3": -0.01}))
    check_pose(ds, {"prismatic_2": 0.03}, result)


def test_sweep_with_assembly_errors_and_tilt_torsion(robot):
    errors = {"rod_1": {"length": 1e-4}}
    grid = {"z": 0.5, "azimuth": np.radians([-170, 30]), "tilt": np.radians([5.0, 10.0])}
    ds = ks.sweep(robot, grid, orientation="tilt_torsion", assembly_errors=errors)
    assert list(ds["platform_coordinate"].values) == ["x", "y", "z", "azimuth", "tilt", "torsion"]
    assert "assembly_errors" in ds["source"].values and json.loads(ds.attrs["arguments"])["assembly_errors"] == errors
    at = {"azimuth": grid["azimuth"][0], "tilt": grid["tilt"][1]}
    pose = robot.assemble(platform={"z": 0.5, **at}, orientation="tilt_torsion")
    check_pose(ds, at, ks.analyze(pose, assembly_errors=errors))
    assert float(ds["platform_pose"].sel(at).sel(platform_coordinate="tilt")) == pytest.approx(at["tilt"])


def test_load_cases_and_gravities_are_named_dimensions(robot):
    z = [0.5, 0.6]
    load = xr.DataArray(
        np.random.default_rng(0).uniform(-100, 100, (3, 2, 6)),
        dims=("case", "z", "component"),
        coords={"case": list("abc"), "z": z},
    )
    gravity = xr.DataArray([[0, 0, -9.81], [9.81, 0, 0]], dims=("way", "component"))
    ds = ks.sweep(robot, {"z": z, "rx": [0.0, 0.1], "ry": 0.05}, load=load, gravity=gravity, point=[0.1, 0, 0.5])
    assert ds["twist"].dims == ("case", "way", "z", "rx", "component")
    assert ds["stiffness"].dims == ("z", "rx", "component", "component_2") and ds["q"].dims == ("z", "rx", "joint_coordinate")
    assert list(ds["case"].values) == ["a", "b", "c"]
    pose = robot.assemble(platform={"z": 0.6, "rx": 0.1, "ry": 0.05})
    result = ks.analyze(pose, load.sel(case="b", z=0.6).values, [9.81, 0, 0], point=[0.1, 0, 0.5])
    check_pose(ds, {"case": "b", "way": 1, "z": 0.6, "rx": 0.1}, result)


def test_file_parameters_are_map_dimensions():
    ds = ks.sweep(
        "3rps",
        {"z": [0.5, 0.55, 0.6], "rx": 0.1, "ry": 0.0},
        parameters={"platform_radius": [0.15, 0.2], "rod_diameter": [0.08, 0.1], "density": 7000},
    )
    assert ds["twist"].dims == ("platform_radius", "rod_diameter", "z", "component")
    assert ds["characteristic_length"].dims == ("platform_radius", "rod_diameter")
    assert float(ds["density"]) == 7000
    robot = package_robots.robot("3rps", platform_radius=0.15, rod_diameter=0.1, density=7000)
    result = ks.analyze(robot.assemble(platform={"z": 0.55, "rx": 0.1, "ry": 0.0}))
    check_pose(ds, {"platform_radius": 0.15, "rod_diameter": 0.1, "z": 0.55}, result)
    assert json.loads(ds.attrs["parameters"])["density"] == 7000


def test_intensities_are_nan_where_a_parameter_changes_wrench_labels(tmp_path):
    """Joints with other names give the wrenches of the basis other labels."""
    path = tripod(tmp_path / "other.urdf.xacro", "hinge", "revolute", r"revolute_\$\{i\}", "$(arg hinge)_${i}")
    ds = ks.sweep(path, {"z": [0.5], "rx": 0.0, "ry": 0.0}, parameters={"hinge": ["revolute", "pin"]})
    assert np.all(np.isfinite(ds["intensity"].sel(hinge="revolute")))
    lost = np.isnan(ds["intensity"].sel(hinge="pin", z=0.5).values)
    assert list(lost) == ["revolute" in label for label in ds["label"].values]
    assert int(ds["status"].sel(hinge="pin", z=0.5)) == ks.Status.BASIS_DEGENERATE
    np.testing.assert_allclose(ds["twist"].sel(hinge="pin"), ds["twist"].sel(hinge="revolute"), rtol=1e-13, atol=1e-20)


def test_unreached_poses_are_nan_and_flagged():
    ds = ks.sweep("2pru_upr", {"z": [0.6, 0.9, 5.0], "rx": [0.0, 0.1], "ry": 0.0}, orientation="XYZ")
    status = ds["status"].values
    assert np.all(status[2] == ks.Status.UNREACHABLE) and np.all(status[0] != ks.Status.UNREACHABLE)
    gone = ds.isel(z=2)
    for name in ds.data_vars:
        if "z" in ds[name].dims and ds[name].dtype == np.float64:
            assert np.all(np.isnan(gone[name])), name
    assert np.all(gone["mode"] == -1) and np.all(ds["mode"].isel(z=0) == 0)


# ---- arguments ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "arguments, message",
    [
        ({"platform": {"z": [[0.5]], "rx": 0, "ry": 0}}, r"z has the shape \(1, 1\); a sweep takes the outer product"),
        ({"platform": {"z": [0.5, 0.5], "rx": 0, "ry": 0}}, "z has a value twice"),
        ({"platform": {"z": [], "rx": 0, "ry": 0}}, "z is empty"),
        ({"platform": {"z": [0.5, np.nan], "rx": 0, "ry": 0}}, "z has values that are not finite"),
        ({"platform": {"z": ["high"], "rx": 0, "ry": 0}}, "z is .* not a number"),
        ({"platform": {"z": [0.5], "rx": 0}}, "2 platform coordinates are given"),
        ({"platform": {"z": [0.5], "rx": 0, "r": 0}}, "no platform coordinate 'r'"),
        ({"load": np.zeros((2, 6))}, "give it as an xarray.DataArray"),
        ({"load": [1, 2]}, "must have 6 entries"),
        ({"load": None}, "load is None"),
        ({"gravity": [0, 0, np.nan]}, "gravity has entries that are not finite"),
        ({"loads": {"platform": np.zeros((2, 6))}}, "are constant in a sweep"),
        ({"actuators": {"prismatic_1": 0.0}, "platform": {"z": 0.5}}, "give either platform= or actuators="),
        ({"load": xr.DataArray(np.zeros((2, 6)), dims=("a", "b"))}, "one of them must be 'component'"),
        ({"load": xr.DataArray(np.zeros((2, 6)), dims=("twist", "component"))}, "'twist' cannot be the name of a dimension"),
        (
            {"load": xr.DataArray(np.zeros((2, 6)), dims=("z", "component")), "platform": {"z": [0.5, 0.6], "rx": 0, "ry": 0}},
            "other",
        ),
        ({"assembly_errors": {"rod": {"length": 1.0}}}, "no joint or beam 'rod'"),
        ({"out": "map.csv"}, r"must end in .nc"),
        ({"out": "no/such/folder/map.nc"}, "there is no folder"),
        ({"out": "map.nc", "chunks": {"z": 1}}, "out= or chunks="),
        ({"parameters": {"rod_diameter": [0.1]}}, "give its path instead of a loaded robot"),
        ({"outputs": ["twists"]}, "no output 'twists': did you mean 'twist'"),
        ({"outputs": ["twist", "spring_force"]}, "'3rps' has no spring: there is no output 'spring_force'"),
        ({"outputs": "twist"}, r"outputs is 'twist'; it must be a sequence of names, such as \["),
    ],
)
def test_invalid_arguments_are_refused(robot, tmp_path, monkeypatch, arguments, message):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ks.ArgumentError, match=message):
        ks.sweep(robot, **arguments)
    assert not list(tmp_path.iterdir())


def test_parameters_changing_limbs_or_actuators_are_refused(tmp_path):
    path = tripod(tmp_path / "other.urdf.xacro", "drive", "prismatic", r"prismatic_(\$\{i\}|\d)", r"$(arg drive)_\1")
    with pytest.raises(ks.ArgumentError, match="with drive = motor the robot has other limbs or actuators"):
        ks.sweep(path, {"z": [0.5], "rx": 0.0, "ry": 0.0}, parameters={"drive": ["prismatic", "motor"]})


def test_invalid_later_parameters_are_refused_before_computing(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ks.RobotFileError, match=r"must be greater than zero \(with rod_diameter = -0.1\)"):
        ks.sweep("3rps", GRID, parameters={"rod_diameter": [0.1, 0.08, -0.1], "density": 7850}, out="map.nc")
    assert not list(tmp_path.iterdir())  # nothing has been computed


def test_only_requested_outputs_are_computed_and_stored(small, robot, tmp_path, monkeypatch):
    options = {"platform": GRID, "load": LOAD, "outputs": ["twist", "beam_stress"]}
    path = tmp_path / "few.nc"
    with ks.sweep(robot, **options, out=path) as few:
        always = {"status", "limit_exceeded", "basis_degenerate", "indeterminate", "mode", "platform_pose", "q"}
        assert {*few.data_vars} == {*always, "characteristic_length", "twist", "beam_stress"}
        assert {*few.coords} == {
            "component",
            "component_unit",
            "beam",
            *(name for name in small.coords if "coord" in name),
            *GRID,
        }
        for name in [*few.data_vars, *few.coords]:
            np.testing.assert_array_equal(few[name].values, small[name].values)
            assert few[name].attrs.keys() == small[name].attrs.keys()
    for name in ("stiffness", "actuator_forces", "buckles", "beams", "joint_wrenches"):
        monkeypatch.delattr(ks.Result, name)
    few = ks.sweep(robot, **(options | {"outputs": ["twist"]}))
    np.testing.assert_array_equal(few["twist"].values, small["twist"].values)
    with pytest.raises(ks.ArgumentError, match="the map has no 'stiffness'; sweep with 'stiffness' among the outputs"):
        ks.indices.quantity(few, "stiffness:x:x")


def test_missing_packages_are_named_with_their_extra(robot, monkeypatch):
    import importlib.util

    find = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name in ("xarray", "dask") else find(name))
    with pytest.raises(ks.KinetostaticsError, match=r"needs xarray: pip install 'kinetostatics\[sweep\]'"):
        ks.sweep(robot, GRID)
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name == "dask" else find(name))
    with pytest.raises(ks.KinetostaticsError, match=r"needs dask: pip install 'kinetostatics\[dask\]'"):
        ks.sweep(robot, GRID, chunks={})


# ---- the command -------------------------------------------------------------------------------------------------------


def command(*arguments, code=0):
    from kinetostatics.cli.main import main

    assert main(["sweep", *arguments]) == code


def test_command_writes_the_map_of_the_function(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    line = "3rps --platform z=450mm:650mm:5 rx=-5deg:5deg:3 ry=0 --load 0 0 -500 0 0 0 --set rod_diameter=60mm,100mm --out m.nc"
    command(*line.split())
    said = capsys.readouterr().out
    wanted = ks.sweep(
        "3rps",
        {"z": np.linspace(0.45, 0.65, 5), "rx": np.radians([-5, 0, 5.0]), "ry": 0.0},
        load=[0, 0, -500, 0, 0, 0],
        parameters={"rod_diameter": [0.06, 0.1]},
    )
    with xr.open_dataset("m.nc") as found:
        near(found.load(), wanted)
        assert found.attrs["command_line"] == f"kinetostatics sweep {line}"
    assert "3rps: 30 poses (rod_diameter 2 × z 5 × rx 3)" in said and "30 reached" in said
    sag = np.sqrt((wanted["twist"].isel(component=slice(3)) ** 2).sum("component"))
    worst = sag.where(sag == sag.max(), drop=True)
    assert f"worst sag {1e6 * float(sag.max()):.4g} µm at rod_diameter = {float(worst['rod_diameter'][0]):.6g} m, z =" in said
    assert f"largest actuator force {float(abs(wanted['actuator_force']).max()):.4g} N, prismatic_" in said


def test_summary_counts_only_poses_within_limits():
    """Beyond the limits there may be singular poses, at which values grow without bound."""
    from kinetostatics.reports.map import map_report

    grid = {"z": [0.4], "azimuth": np.radians([-120.0, 0.0]), "tilt": np.radians([0.0, 20.0, 50.0])}
    ds = ks.sweep("3rps", grid, orientation="tilt_torsion")
    assert (ds["status"] == ks.Status.LIMIT_EXCEEDED).any()
    words = str(map_report(ds))
    worst = ks.indices.worst(ds, "linear_sag")
    assert f"worst sag {1e6 * worst.value:.4g} µm at z = 0.4 m, azimuth = -120 deg, tilt = 20 deg" in words
    assert np.degrees([worst.coordinates["azimuth"], worst.coordinates["tilt"]]) == pytest.approx([-120, 20])
    assert f"largest actuator force {float(ks.indices.quantity(ds, 'largest_actuator_force').max()):.4g} N, prismatic_" in words
    assert "linear theory" not in words
    outside = str(map_report(ds.isel(azimuth=[0], tilt=[2])))
    assert "no pose is within the joints' limits; beyond them:\n  worst sag " in outside
    assert "linear theory does not apply: the pose is nearly singular" in outside


def test_command_sweeps_text_parameters_and_prints_warnings(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    modulus = """youngs_modulus="${dict(steel=210e9, brass=100e9)['$(arg material)']}\""""
    path = tripod(Path("mixed.urdf.xacro"), "material", "steel", r'youngs_modulus="[^"]*"', modulus)
    path.write_text(path.read_text().replace('<link name="platform">', '<link name="platform"><visuals/>'))
    command(*"mixed.urdf.xacro --platform z=0.5 rx=0 ry=0 --set material=steel,brass --out m.nc".split())
    said = capsys.readouterr()
    assert "2 poses (material 2)" in said.out and "worst sag" in said.out and "at material = brass" in said.out
    lines = said.err.splitlines()
    assert all(line.startswith("kinetostatics: warning: mixed.urdf.xacro:") and "<visuals>" in line for line in lines) and lines
    with xr.open_dataset("m.nc") as found:
        assert list(found["material"].values) == ["steel", "brass"]


def test_command_reports_interruption_and_existing_maps(tmp_path, monkeypatch, capsys):
    from kinetostatics.workspace import block

    monkeypatch.chdir(tmp_path)
    line = "3rps --platform z=0.45:0.65:5 rx=0 ry=0 --out m.nc".split()

    def interrupted(*arguments):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(block, "compute_block", interrupted)
        command(*line, code=130)
    said = capsys.readouterr()
    assert said.out == "" and said.err == "kinetostatics: interrupted; the same command continues from m.nc.part\n"
    command(*line)
    assert re.fullmatch(r"\d+\.\d s", capsys.readouterr().out.splitlines()[-2].strip())
    command(*line)
    said = capsys.readouterr().out
    assert said.endswith("m.nc was there already\n") and not re.search(r"\d s$", said, re.MULTILINE)


@pytest.mark.parametrize(
    "line, message",
    [
        ("3rps --platform z=0.4:0.5:1 rx=0 ry=0 --out m.nc", "must be at least 2"),
        ("3rps --platform z=0.4:5deg:3 rx=0 ry=0 --out m.nc", "is an angle, but a length is needed"),
        ("3rps --platform z=0.4:0.6:100000000000 rx=0 ry=0 --out m.nc", "z: 100000000000 values are too many; at most 1,000,000"),
        ("3rps --platform z=0.5 rx=0 ry=0 --set rod_diameter=0.1,,0.2 --out m.nc", "an empty value between its commas"),
        ("3rps --platform z=0.5 rx=0 ry=0 --set rod_diameter=0.1,0 --out m.nc", "greater than zero (with rod_diameter = 0"),
    ],
)
def test_command_refuses_invalid_arguments_in_one_line(tmp_path, monkeypatch, capsys, line, message):
    monkeypatch.chdir(tmp_path)
    command(*line.split(), code=2)
    said = capsys.readouterr().err
    assert message in said and said.count("\n") == 1
    assert not list(tmp_path.iterdir())


# ---- documentation -----------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_code_of_the_workspace_page_runs(tmp_path, monkeypatch, capsys):
    """Every Python block of docs/how_to/workspace.md; its table lists all variables of a map."""
    page = text_of("how_to/workspace")
    monkeypatch.chdir(tmp_path)
    names = run_python("how_to/workspace", {", 21)": ", 5)"})  # on a coarser grid
    said = capsys.readouterr().out
    assert "('rod_diameter', 'push', 'z', 'rx', 'component')" in said and "(5, 5, 6)" in said
    assert (tmp_path / "map.nc").exists()
    assert (tmp_path / "sag.svg").exists()
    described = set(re.findall(r"`(\w+)`", "".join(re.findall(r"^\| (.*?) \|", page, re.MULTILINE))))
    wanted = {name for name, item in VARIABLES.items() if item.group not in ("default", "always")} | {"spring_force"}
    assert set(names["ds"].data_vars) | wanted == described | {"frequency", "zero_frequencies"}  # on a page of their own


def test_spring_forces_of_a_map_follow_the_spring_law():
    """Tension is stiffness times elongation at every pose, for every load."""
    angles = np.array([-0.5, 0.4, 1.1])
    springs = "".join(
        f'<spring name="{name}" stiffness="{k}" free_length="0.4"><predecessor link="ground">'
        f'<origin xyz="0 0 0.5"/></predecessor><successor link="arm"><origin xyz="{at} 0 0"/></successor></spring>'
        for name, k, at in (("near", 500, 0.1), ("far", 200, 0.3))
    )
    text = f"""<robot name="pendulum"><link name="ground"/><link name="arm"><inertial><mass value="4"/>
<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
<joint name="hinge" type="continuous"><parent link="ground"/><child link="arm"/><axis xyz="0 1 0"/></joint>
<platform link="arm"/><transmission name="motor"><joint name="hinge"/></transmission>{springs}</robot>"""
    robot = ks.Robot(parse_robot_text(text))
    push = np.array([[0, 0, 0, 0, 0, 0], [0, 0, -50, 0, 0, 0]])
    ds = ks.sweep(robot, actuators={"hinge": angles}, load=xr.DataArray(push, dims=("push", "component")))
    assert ds["spring_force"].dims == ("hinge", "spring") and ds["spring_force"].attrs["units"] == "N"
    for name, k, at in (("near", 500, 0.1), ("far", 200, 0.3)):
        length = np.hypot(at * np.cos(angles), 0.5 + at * np.sin(angles))
        np.testing.assert_allclose(ds["spring_force"].sel(spring=name), k * (length - 0.4), rtol=1e-12)
        for drawn in ks.indices.quantity(ds, f"spring_force:{name}"):  # of each load
            np.testing.assert_array_equal(drawn, ds["spring_force"].sel(spring=name))


def test_both_engines_compute_equal_maps(tmp_path, monkeypatch):
    monkeypatch.setenv("KINETOSTATICS_CACHE", str(tmp_path / "code"))
    robot = robot_of(four_bar())
    [drive] = robot.description.actuated
    grid = {"actuators": {drive: np.linspace(-0.5, 9.0, 21)}, "gravity": [0.1, 0.2, -9.81], "progress": False, "workers": 1}
    numpy, compiled = (ks.sweep(robot, **grid, engine=engine) for engine in ("numpy", "compiled"))
    assert list((tmp_path / "code").iterdir())
    assert set(numpy) == set(compiled) and numpy.sizes == compiled.sizes and (numpy["status"] < 2).sum() > 3
    for name in numpy:
        one, other = numpy[name].values, compiled[name].values
        if one.dtype.kind == "f":
            np.testing.assert_allclose(other, one, rtol=0, atol=1e-10 * np.nanmax(np.abs(one), initial=1e-3), err_msg=name)
        else:
            np.testing.assert_array_equal(other, one, err_msg=name)
    with pytest.raises(ks.ArgumentError, match="engine is 'fast'"):
        ks.sweep(robot, **grid, engine="fast")
