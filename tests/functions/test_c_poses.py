"""C for controllers at many poses of various robots, its rarer statuses, and its memory on a controller."""

import math
import shutil
import subprocess
from functools import cache

import c_programs
import numpy as np
import package_robots
import pytest
import simple_machines as sm
from c_programs import NEEDS_ARM, around, on_cortex_m7, rows, run
from telescopes import mast

import kinetostatics as ks

pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not installed")

OUTPUTS = ("twist", "actuator_forces", "actuators")
TRIPOD, HEXAPOD = ("z", "rx", "ry"), ("x", "y", "z", "rx", "ry", "rz")


@cache
def function(name, coordinates):
    return ks.compile(package_robots.robot(name), coordinates, orientation="XYZ", outputs=OUTPUTS)


def compare(f, program, at, load, gravity):
    """Compare statuses and outputs; return how many poses were reached, and how many were not."""
    status, found = run(program, rows(f, at, load, gravity))
    wanted = f(**at, load=load, gravity=gravity)
    python = np.where(wanted["status"] == ks.Status.LIMIT_EXCEEDED, ks.Status.OK, wanted["status"])
    assert np.array_equal(status, python)
    here, first = status == 0, 0
    for name in OUTPUTS:
        expected = wanted[name][here]
        part = found[here, first : first + expected.shape[1]]
        first += expected.shape[1]
        error, size = np.max(np.abs(part - expected), axis=1), np.max(np.abs(expected), axis=1)
        assert np.max(error / size) < 1e-9, name
    assert np.all(np.isnan(found[~here]))
    return int(np.sum(here)), int(np.sum(~here))


@pytest.mark.parametrize(
    ("name", "coordinates", "poses"),
    [
        pytest.param("2pru_upr", TRIPOD, 600),
        *(
            pytest.param(*case, marks=pytest.mark.slow)
            for case in (
                ("3rps", TRIPOD, 100_000),
                ("five_bar", ("x", "y"), 100_000),
                ("2pru_upr", TRIPOD, 100_000),
                ("gough_stewart", HEXAPOD, 10_000),
            )
        ),
    ],
)
def test_c_equals_python_at_many_poses(name, coordinates, poses, tmp_path):
    """Overconstrained and other robots, three to six freedoms: the same status everywhere, the same numbers to 1e-9."""
    f = function(name, coordinates)
    inputs = around(f, poses, np.where(np.arange(poses) % 5 == 0, 0.8, 0.15), 11, load=200.0)
    reached, not_reached = compare(f, c_programs.driver(f.export_c(tmp_path)), *inputs)
    assert reached > poses / 2 and (not_reached > poses / 500) == (name in ("five_bar", "2pru_upr"))  # the others reach all


def test_c_statuses_of_singular_poses_and_inverted_telescopes(tmp_path):
    """C does not cover singular poses (6), Python finds them singular (3); telescopes beyond their start are singular in both."""
    five_bar, tripod, telescope = function("five_bar", ("x", "y")), function("3rps", TRIPOD), ks.compile(mast(names="a"), "z")
    height = math.sqrt(0.23**2 - (0.23 - 0.1375) ** 2)  # of the elbows, 2 × 0.23 m apart: the distal links are one line
    zero = float(tripod.robot.assemble().platform["z"])
    cases = (
        (five_bar, [[0, 0.31], [0, height], [0, height + 1e-3]], [0, 6, 0], [0, 3, 0]),
        (tripod, [[zero, 0, 0], [0, 0, 0]], [0, 6], [0, 3]),
        (telescope, [[0.5], [-0.1], [0.2]], [0, 3, 0], [0, 3, 0]),
    )
    for f, coordinates, wanted, python in cases:
        inputs = np.column_stack([coordinates, np.tile([0.0] * 8 + [-9.81], (len(coordinates), 1))])
        exported = f.export_c(tmp_path / f.robot.name)
        status, found = run(c_programs.driver(exported), inputs)
        assert status.tolist() == wanted
        assert f(**dict(zip(f.names, np.transpose(coordinates), strict=True)))["status"].tolist() == python
        assert np.all(np.isnan(found[status != 0, :-1])) and np.all(np.isfinite(found[status == 0]))


@pytest.mark.slow
@NEEDS_ARM
def test_c_for_cortex_m7_uses_no_static_memory(tmp_path):
    """It compiles without warnings, and calls only libm, memcpy and memset."""
    exported = function("five_bar", ("x", "y")).export_c(tmp_path)
    text, data, bss = on_cortex_m7(tmp_path, f"{exported.name}.c")
    assert 10_000 < text < 200_000 and data == bss == 0
    names = subprocess.run(
        ["arm-none-eabi-nm", "-u", f"{exported.name}.o"], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    called = set(names.stdout.replace("U", " ").split())
    assert called <= {*"memcpy memset sqrt sin cos tan atan2 acos asin fabs fmax fmin pow round rint floor".split()}


@pytest.mark.parametrize("times", [1.0, -0.5, 1 / 3])
def test_endless_joints_that_mimic_endless_actuators_turn_beyond_half_turns(times, tmp_path):
    """The platform is given, up to more than half a turn of the actuator; its turns follow from the other joint."""
    arm = [sm.link("base"), sm.link("upper", 2.0), sm.link("fore", 1.0), sm.link("platform", 0.5)]
    mimic = f'<mimic joint="shoulder" multiplier="{times}"/></joint>'
    arm += [sm.joint("shoulder", "continuous", "base", "upper")]
    arm += [sm.joint("elbow", "continuous", "upper", "fore", "0.4 0 0").replace("</joint>", mimic)]
    arm += [sm.joint("wrist", "fixed", "fore", "platform", "0.3 0 0"), sm.bar("upper", "shoulder", "elbow")]
    arm += [sm.bar("fore", "elbow", "wrist"), '<transmission name="t"><joint name="shoulder"/></transmission>']
    f = ks.compile(sm.robot(*arm), ("ry",), outputs=("twist", "actuators"), engine="numpy")
    angles = np.array([0.5, 2.0, 3.0, 3.3, 4.0, 5.5, -2.0, -3.5, -5.0])
    inputs = np.zeros((len(angles), 10))
    inputs[:, 0], inputs[:, 9] = angles, -9.81
    status, found = run(c_programs.driver(f.export_c(tmp_path)), inputs)
    expected = f(ry=angles)
    assert np.abs(expected["actuators"]).max() > (3.2 if times < 1 else 2.7) and not np.any(status)
    np.testing.assert_allclose(found[:, :6], expected["twist"], rtol=1e-9, atol=1e-12 * np.abs(expected["twist"]).max())
    np.testing.assert_allclose(found[:, 6:7], expected["actuators"], rtol=1e-9)
