"""Compensation in C against Python: actuator positions and statuses."""

import shutil

import c_programs
import numpy as np
import package_robots
import pytest
from c_programs import SANITIZED, around, rows, run

import kinetostatics as ks
from kinetostatics.compensation import error_tolerance

pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not installed")

OUTPUTS = ("actuators", "actuator_forces", "residual_error")
TRIPOD, HEXAPOD = ("z", "rx", "ry"), ("x", "y", "z", "rx", "ry", "rz")
#: Robot, coordinates, orientation, how far around the zero pose [m and rad], poses, flags of the compiler.
ROBOTS = [
    pytest.param("five_bar", ("x", "y"), None, 0.1, 300, (), id="five_bar"),
    *(
        pytest.param(*case, marks=pytest.mark.slow, id=f"{case[0]}{'-sanitized' * bool(case[-1])}")
        for case in (
            ("five_bar", ("x", "y"), None, 0.1, 300, SANITIZED),
            ("3rps", TRIPOD, None, 0.15, 3000, ()),
            ("2pru_upr", TRIPOD, "XYZ", 0.15, 1000, SANITIZED),
            ("gough_stewart", HEXAPOD, "XYZ", 0.5, 500, ()),
        )
    ),
]


def function(name, coordinates, orientation=None, **parameters):
    robot = package_robots.robot(name, **parameters)
    return ks.compile(robot, coordinates, orientation=orientation, outputs=OUTPUTS, compensate=True)


@pytest.mark.parametrize(("name", "coordinates", "orientation", "far", "N", "flags"), ROBOTS)
def test_c_compensation_equals_python_in_and_out_of_reach(name, coordinates, orientation, far, N, flags, tmp_path):
    f = function(name, coordinates, orientation)
    at, load, gravity = around(f, N, far * np.where(np.arange(N) % 3 == 0, 6, 1), 7)
    gravity = np.array([0, 0, -9.81]) + gravity / 10
    status, found = run(c_programs.driver(f.export_c(tmp_path), flags), rows(f, at, load, gravity))
    wanted = f(**at, load=load, gravity=gravity)
    assert np.array_equal(status, wanted["status"])
    valid = np.isin(status, (ks.Status.OK, ks.Status.LIMIT_EXCEEDED))
    assert 0.3 < np.mean(valid) < 0.999
    ends = np.cumsum([np.prod(f.outputs[item].shape) for item in OUTPUTS]).astype(int)
    for item, part in zip(OUTPUTS, np.split(found[valid], ends, axis=1), strict=False):
        expected = wanted[item][valid]
        allowed = 1e-9 * np.max(np.abs(expected), axis=1)
        if item == "residual_error":  # differences of coordinates, which are zero to the tolerance of corrections
            allowed = allowed + error_tolerance(f.robot.length)
        assert np.all(np.max(np.abs(part - expected), axis=1) <= allowed), item
    assert np.all(np.isnan(found[~valid]))


@pytest.mark.slow
def test_c_compensation_rejects_other_assembly_modes(tmp_path):
    """Actuator positions that lead to another assembly mode are no correction, in Python and C."""
    f = ks.compile(package_robots.soft_five_bar(), ("x", "y"), outputs=OUTPUTS, compensate=True)
    drives = np.array([[0.6, 0.4], [-0.8 + 1.6 * 12 / 15, -0.8 + 1.6 * 10 / 15], [0.1, 0.2]]).T
    pose = f.robot.assemble(actuators=dict(zip(f.robot.description.actuated, drives, strict=True)))
    at, load, gravity = {name: pose.platform[name] for name in "xy"}, np.full((3, 6), [-100.0, 0, 0, 0, 0, 0]), np.zeros((3, 3))
    status, found = run(c_programs.driver(f.export_c(tmp_path)), rows(f, at, load, gravity))
    assert status.tolist() == f(**at, load=load, gravity=gravity)["status"].tolist() == [2, 2, 0]
    assert np.isnan(found[:2]).all() and np.isfinite(found[2]).all()


def test_function_with_compensation_equals_ks_compensate():
    f = function("3rps", TRIPOD)
    at, load = {"z": [0.5, 2.0], "rx": 0.1, "ry": -0.05}, [20, 0, -500, 3, 0, 0]
    values = f(**at, load=load)
    found = ks.compensate(f.robot.assemble(platform=at), load)
    assert found.controlled == TRIPOD and np.array_equal(values["status"], found.status)
    for item, wanted in (("actuators", found.actuators), ("actuator_forces", found.actuator_forces)):
        np.testing.assert_allclose(values[item], np.stack(list(wanted.values()), axis=-1), rtol=1e-12)
    np.testing.assert_allclose(values["residual_error"], found.residual_error, atol=1e-15)
    assert abs(values["residual_error"][0, 2]) < 1e-12 < abs(found.uncorrected_error[0, 2])
    assert values.pose.platform["z"][0] == pytest.approx(0.5)


def test_invalid_options_with_compensation_raise_argument_error(tmp_path):
    robot = package_robots.robot("3rps")
    with pytest.raises(ks.ArgumentError, match=r"compensate=True \(--compensate\) needs platform= \(--platform\), the names"):
        ks.compile(robot, compensate=True)
    with pytest.raises(ks.ArgumentError, match=r"only functions with compensation have the output 'residual_error'"):
        ks.compile(robot, TRIPOD, outputs="residual_error")
    with pytest.raises(ks.ArgumentError, match="has no derivatives"):
        function("3rps", TRIPOD).jacobian("actuators", "z")
