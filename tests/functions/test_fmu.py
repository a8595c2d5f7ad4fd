"""Functional mock-up units: valid by FMPy, compiled by their own CMake, and equal to Python."""

import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import package_robots
import pytest
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu

import kinetostatics as ks
from kinetostatics.cli.main import main

pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not installed")
#: The packages of FMPy bring one.
CMAKE = shutil.which("cmake") or str(Path(sys.executable).with_name("cmake"))
TIME = np.linspace(0, 1, 11)


@pytest.fixture(scope="module")
def function():
    return ks.compile(package_robots.robot("3rps"), ("z", "rx", "ry"), outputs=("actuator_forces", "twist", "stiffness"))


@pytest.fixture(scope="module", params=[2, 3], ids=["FMI 2", "FMI 3"])
def unit(function, tmp_path_factory, request):
    """Return the folder of a compiled unit."""
    folder = tmp_path_factory.mktemp("unit")
    function.export_fmu(folder / "robot.fmu", fmi=request.param)
    assert fmpy.read_model_description(folder / "robot.fmu").fmiVersion == f"{request.param}.0"
    assert validate_fmu(str(folder / "robot.fmu")) == []
    zipfile.ZipFile(folder / "robot.fmu").extractall(folder / "unpacked")
    unpacked = folder / "unpacked"
    strict = "-DCMAKE_C_FLAGS=-Wall -Wextra -Werror"
    subprocess.run([CMAKE, "-B", "build", "-S", "sources", strict], cwd=unpacked, check=True, stdout=subprocess.DEVNULL)
    subprocess.run([CMAKE, "--build", "build"], cwd=unpacked, check=True, stdout=subprocess.DEVNULL)
    return str(unpacked)


def path():
    at = {"z": 0.5 + 0.05 * TIME, "rx": 0.1 * TIME, "ry": -0.05 * TIME}
    load = np.zeros((len(TIME), 6))
    load[:, 2], load[:, 3] = -1000 * TIME, 20 * TIME
    return at, load


def simulated(unit, at, load, output):
    names = [*at, *(f"load.{name}" for name in ("fx", "fy", "fz", "mx", "my", "mz")), *(f"gravity.{axis}" for axis in "xyz")]
    columns = np.column_stack([*at.values(), load, np.tile([0, 0, -9.81], (len(TIME), 1))])
    signals = np.zeros(len(TIME), dtype=[("time", float), *((name, float) for name in names)])
    signals["time"] = TIME
    for name, column in zip(names, columns.T, strict=True):
        signals[name] = column
    return fmpy.simulate_fmu(unit, stop_time=1.0, step_size=0.1, output_interval=0.1, input=signals, output=output)


def test_unit_equals_python_along_a_path(unit, function):
    """A step holds the inputs of its start."""
    at, load = path()
    labels = [f"actuator_forces.prismatic_{k}" for k in (1, 2, 3)] + [
        f"twist.{name}" for name in ("x", "y", "z", "rx", "ry", "rz")
    ]
    found = simulated(unit, at, load, [*labels, "stiffness.x.ry", "status", "effort_exceeded"])
    wanted = function(**at, load=load)
    expected = np.column_stack([wanted["actuator_forces"], wanted["twist"]])[:-1]
    rows = np.column_stack([found[name] for name in labels])[1:]
    for part in (slice(3), slice(3, 6), slice(6, 9)):
        np.testing.assert_allclose(rows[:, part], expected[:, part], rtol=1e-12, atol=1e-12 * np.abs(expected[:, part]).max())
    np.testing.assert_allclose(found["stiffness.x.ry"][1:], wanted["stiffness"][:-1, 0, 4], rtol=1e-9, atol=1e-3)
    assert found["status"].tolist() == [0] * len(TIME) and found["effort_exceeded"].tolist() == [0.0] * len(TIME)


def test_status_says_where_a_pose_is_out_of_reach(unit):
    at, load = path()
    at["rx"] = np.where(TIME > 0.45, 4.0, at["rx"])
    found = simulated(unit, at, load, ["twist.z", "status"])
    lost = found["status"] != 0
    assert lost.tolist() == [False] * 6 + [True] * 5 and np.isnan(found["twist.z"][lost]).all()


def test_states_are_kept_restored_and_serialized(unit):
    description = fmpy.read_model_description(unit)
    old = description.fmiVersion == "2.0"
    about = {"guid": description.guid, "unzipDirectory": unit, "instanceName": "robot"}
    made = (FMU2Slave if old else FMU3Slave)(modelIdentifier=description.coSimulation.modelIdentifier, **about)
    made.instantiate()
    reference = {variable.name: variable.valueReference for variable in description.modelVariables}
    get, put = (made.getReal, made.setReal) if old else (made.getFloat64, made.setFloat64)
    keep, restore = (made.getFMUstate, made.setFMUstate) if old else (made.getFMUState, made.setFMUState)
    serialize, deserialize = ("serializeFMUstate", "deSerializeFMUstate") if old else ("serializeFMUState", "deserializeFMUState")
    outputs = [reference["twist.z"], reference["load.fz"]]
    put([reference["load.fz"]], [-700.0])
    before, state = get(outputs), keep()
    written = getattr(made, serialize)(state)
    put([reference["load.fz"]], [300.0])
    assert get(outputs) != before
    restore(state)
    assert get(outputs) == before and before[1] == -700.0
    put([reference["load.fz"]], [300.0])
    restore(getattr(made, deserialize)(written))
    assert get(outputs) == before
    made.reset()
    assert get(outputs)[1] == 0.0
    made.freeInstance()


def test_description_has_starts_units_and_meanings(unit, function):
    variables = {variable.name: variable for variable in fmpy.read_model_description(unit).modelVariables}
    assert float(variables["z"].start) == pytest.approx(float(function.robot.assemble().platform["z"]), abs=1e-8)
    assert variables["z"].unit == "m" and variables["actuator_forces.prismatic_1"].unit == "N"
    assert variables["twist.rx"].unit == "rad" and "rotation of the platform" in variables["twist.rx"].description
    assert float(variables["gravity.z"].start) == -9.81


def test_command_writes_a_unit(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["export", "five_bar", "--platform", "x", "y", "--compensate", "--fmu", "--out", "bar.fmu"]) == 0
    assert validate_fmu("bar.fmu") == [] and "wrote bar.fmu" in capsys.readouterr().out
    assert main(["export", "five_bar", "--platform", "x", "y", "--fmi", "2", "--out", "old.fmu"]) == 0
    assert validate_fmu("old.fmu") == [] and fmpy.read_model_description("old.fmu").fmiVersion == "2.0"
    assert main(["export", "five_bar", "--platform", "x", "y", "--fmi", "1", "--out", "old.fmu"]) == 2
    assert "fmi is 1; it must be 2 or 3" in capsys.readouterr().err
    assert main(["export", "five_bar", "--platform", "x", "y", "--fmu", "--out", "bar.zip"]) == 2
    assert "'bar.zip' does not end in .fmu" in capsys.readouterr().err
    assert main(["export", "five_bar", "--fmu", "--jacobian", "twist", "--out", "bar.fmu"]) == 2
    assert "--fmu takes neither --jacobian nor --scalar" in capsys.readouterr().err
