"""Derivatives in C by coordinates, load and gravity, against Python."""

import shutil
import subprocess

import c_programs
import numpy as np
import package_robots
import pytest
from c_programs import SANITIZED, around, rows, run

import kinetostatics as ks

pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not installed")

OF = ("twist", "actuator_forces", "actuators")
ROBOTS = [
    pytest.param("five_bar", ("x", "y"), None, (), id="five_bar"),
    *(
        pytest.param(*case, marks=pytest.mark.slow, id=case[0])
        for case in (
            ("2pru_upr", ("z", "rx", "ry"), "XYZ", SANITIZED),
            ("3rps", ("z", "azimuth", "tilt"), "tilt_torsion", ()),
            ("gough_stewart", ("x", "y", "z", "rx", "ry", "rz"), "XYZ", ()),
            ("6rus", None, None, ()),
        )
    ),
]


@pytest.mark.parametrize(("name", "platform", "orientation", "flags"), ROBOTS)
def test_c_jacobian_equals_python(name, platform, orientation, flags, tmp_path):
    robot, N = package_robots.robot(name), 60
    f = ks.compile(robot, platform, orientation=orientation, outputs=OF)
    coordinates = [item for item in f.inputs if item not in ("load", "gravity")]
    J = f.jacobian(OF, (*coordinates, "load", "gravity"))
    program = c_programs.driver(J.export_c(tmp_path, name="machine"), flags, derivatives=True)
    at, load, gravity = around(f, N, 0.1, 2)
    at[coordinates[0]][0] = 40.0
    status, found = run(program, rows(f, at, load, gravity))
    wanted, values = J(**at, load=load, gravity=gravity), f(**at, load=load, gravity=gravity)
    valid = status == 0
    assert np.mean(valid) > 0.8 and (name == "6rus" or not valid[0])
    more = 1 + bool(robot.description.actuator_limits("effort"))  # the residual, and whether an effort is exceeded
    at_column = sum(int(np.prod(f.outputs[item].shape)) for item in OF) + more
    for output in OF:
        rounding = 1e-12 * np.max(np.abs(values[output][valid]))  # of outputs that do not depend on an input
        for item in J.by:
            expected = wanted[output][item].reshape(N, -1)
            part = found[:, at_column : at_column + expected.shape[1]]
            at_column += expected.shape[1]
            allowed = 1e-9 * np.max(np.abs(expected[valid]), axis=1) + rounding
            assert np.all(np.max(np.abs(part - expected)[valid], axis=1) <= allowed), (output, item)
            assert np.all(np.isnan(part[~valid]))
    assert at_column == found.shape[1]
    header = (tmp_path / "machine.h").read_text()
    assert "double twist_by_load[36]; /* 6 x 6, row by row */" in header and "machine_differentiate" in header
    assert "machine_differentiate(&input, &state, &output, &jacobian)" in (tmp_path / "machine_test.c").read_text()
    assert "machine_differentiate" in (tmp_path / "machine.hpp").read_text()


@pytest.mark.slow
@pytest.mark.parametrize("scalar", ["double", "float"])
def test_c_jacobian_of_actuators_needs_no_statics(scalar, tmp_path):
    f = ks.compile(package_robots.robot("five_bar"), ("x", "y"), outputs="actuators")
    f.jacobian("actuators", ("y", "load")).export_c(tmp_path, scalar, name="bars")
    program = c_programs.compiled(tmp_path, "bars_test.c", "bars.c", flags=SANITIZED)
    assert subprocess.run([program], capture_output=True, text=True, check=True).stdout.startswith("0 of 40 poses differ\n")


def test_c_jacobian_by_parameters_is_refused(tmp_path):
    f = ks.compile(package_robots.robot("3rps"), ("z", "rx", "ry"))
    with pytest.raises(
        ks.ArgumentError, match=r"derivatives by 'platform.mass' cannot be exported, only those by inputs: z, rx, ry"
    ):
        f.jacobian("twist", "platform.mass").export_c(tmp_path)
