"""Exported C of a five-bar against a closed form; invalid arguments, poses that are not covered, turns."""

import shutil
import subprocess

import c_programs
import numpy as np
import package_robots
import pytest
from c_programs import compiled, rows, run
from degenerate_limbs import DEPENDENT, cuts_of
from mechanisms import write_mechanism

import kinetostatics as ks
from kinetostatics.engine import c_code
from kinetostatics.functions.c_programs import search_programs
from kinetostatics.math.rotations import orientation_named

pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not installed")

#: The five-bar of the package: half the distance of its motors, its links [m], E, G [Pa], area, second moment about the vertical,
#: and the part of the area that shear across it counts with.
HALF, LINK = 0.1375, 0.23
E, G, AREA, INERTIA = 70e9, 70e9 / 2.66, 0.000384, 8.1392e-08
#: Status of a pose that the records do not cover, and of an argument that is no number.
NOT_COVERED, BAD_ARGUMENT = 6, 7


@pytest.fixture(scope="module")
def five_bar(tmp_path_factory):
    f = ks.compile(package_robots.robot("five_bar"), ("x", "y"), outputs=("actuators", "actuator_forces", "twist"))
    return f, c_programs.driver(f.export_c(tmp_path_factory.mktemp("five_bar"), name="bars"))


def by_hand(x, y, fx, fy, shear_area):
    """Return actuators' angles and torques, and how o moves in its plane, under a force there: (N,) each.

    The distal links are struts between elbow and o, the proximal ones cantilevers that these bend and pull: Castigliano.
    """
    force, found = np.array([fx, fy]), []
    home = np.arctan2(*_elbow(0.0, 0.31, -1)[::-1]), np.arctan2(*_elbow(0.0, 0.31, 1)[::-1])
    ways = []
    for side, zero in zip((-1, 1), home, strict=True):
        arm = _elbow(x, y, side)
        strut = (np.array([x - side * HALF, y]) - arm) / LINK
        ways.append((arm / LINK, strut))
        found.append(np.arctan2(arm[1], arm[0]) - zero)
    struts = np.stack([strut for _, strut in ways], axis=1)  # (2, arms, N)
    inverse = np.moveaxis(np.linalg.inv(np.moveaxis(struts, 2, 0)), 0, 2)  # forces of the struts on o, per force on it
    thrust = np.einsum("aiN,iN->aN", inverse, force)
    moved, torques = np.zeros((2, x.size)), []
    for k, (arm, strut) in enumerate(ways):
        along, across = np.sum(arm * strut, axis=0), arm[0] * strut[1] - arm[1] * strut[0]
        shortens = LINK / (E * AREA) * (1 + along**2) + across**2 * (LINK**3 / (3 * E * INERTIA) + LINK / (G * shear_area))
        moved += inverse[k] * (shortens * thrust[k])
        torques.append(-thrust[k] * across * LINK)  # what the actuator holds against the strut
    return np.stack(found), np.stack(torques), moved


def _elbow(x, y, side):
    """Return the way (2, …) from a motor to its elbow, which lies on the outer side."""
    way = np.array([x - side * HALF, y + 0 * x])
    reach = np.sqrt(np.sum(way**2, axis=0))
    turn = -side * np.arccos(reach / (2 * LINK))
    c, s = LINK * np.cos(turn), LINK * np.sin(turn)
    return np.array([c * way[0] - s * way[1], s * way[0] + c * way[1]]) / reach


def test_c_five_bar_equals_closed_form(five_bar):
    f, program = five_bar
    rng = np.random.default_rng(3)
    N = 200
    at = {"x": rng.uniform(-0.08, 0.08, N), "y": rng.uniform(0.25, 0.35, N)}
    load = np.column_stack([rng.uniform(-200, 200, (N, 2)), np.zeros((N, 4))])
    status, found = run(program, rows(f, at, load, np.zeros((N, 3))))
    assert np.all(status == ks.Status.OK)
    sheared = f.robot.description.beams["proximal_1"].shear_areas[0]  # of tubes: tests/validation/test_section_shear.py
    angles, torques, moved = by_hand(at["x"], at["y"], load[:, 0], load[:, 1], sheared)
    np.testing.assert_allclose(found[:, :2].T, angles, atol=1e-12)
    np.testing.assert_allclose(found[:, 2:4].T, torques, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(found[:, 4:6].T, moved, rtol=1e-9, atol=1e-15)


@pytest.mark.parametrize("nothing", [np.nan, np.inf, -np.inf])
def test_c_rejects_nan_and_inf_and_keeps_the_state(five_bar, nothing):
    """Each coordinate and each component of load and gravity by itself; the next pose follows from the last valid one."""
    _, program = five_bar
    wrong = np.tile([0.01, 0.3, *[1.0] * 9], (11, 1))
    np.fill_diagonal(wrong, nothing)
    right = np.array([[0.02, 0.31, *[1.0] * 9]])
    status, found = run(program, np.concatenate([right, wrong, right]), "on")  # from one to the next
    assert status.tolist() == [ks.Status.OK, *[BAD_ARGUMENT] * 11, ks.Status.OK]
    assert np.isnan(found[1:-1]).all() and np.isfinite(found[-1]).all()
    np.testing.assert_allclose(found[-1], found[0], rtol=1e-9, atol=1e-12)


@pytest.mark.slow
def test_c_status_of_a_degenerate_limb_is_not_covered(tmp_path):
    """A stretched leg between spherical joints resists one more wrench: Python computes it, C returns NaN."""
    mechanism = DEPENDENT["a stretched leg between balls"]
    leg = write_mechanism(mechanism, cuts=cuts_of(mechanism)).robot()
    f = ks.compile(leg, outputs=("twist",))
    still, weight = {name: np.zeros(1) for name in leg.description.actuated}, np.array([[0, 0, -9.81]])
    status, found = run(c_programs.driver(f.export_c(tmp_path, name="leg")), rows(f, still, np.zeros((1, 6)), weight))
    assert status == NOT_COVERED and np.isnan(found).all()
    assert np.isfinite(f(**still)["twist"]).all()


@pytest.mark.parametrize("piece", [3, 8000])
def test_c_correction_takes_the_shorter_turn(tmp_path, monkeypatch, piece):
    """Corrections across half a turn are small; those of a slide are not. In one C function and in several."""
    monkeypatch.setattr(c_code, "_PIECE", piece)
    robot = package_robots.robot("five_bar")
    programs = search_programs(robot, ("x", "y"), orientation_named(None))
    cases = [(3.1, -3.1), (-3.1, 3.1), (0.1, 0.4), (9.5, 9.3), (0.2, 0.2 + 4 * np.pi)]
    calls = "".join(
        f"    a[0] = {wanted!r}; a[1] = 0.5; b[0] = {float(there)!r}; b[1] = 0.25; correct(a, b, w, out);"
        ' printf("%.17g %.17g\\n", out[0], out[1]);\n'
        for wanted, there in cases
    )
    assert ("correct_1(" in programs.correct.text) == (piece == 3)
    (tmp_path / "turns.c").write_text(
        f"#include <math.h>\n#include <stdio.h>\n{programs.correct.text}\nint main(void)\n{{\n"
        f"    double a[2], b[2], out[3], w[{programs.correct.work}];\n{calls}    return 0;\n}}\n"
    )
    answer = subprocess.run([compiled(tmp_path, "turns.c")], capture_output=True, text=True, check=True)
    found = np.array([line.split() for line in answer.stdout.splitlines()], dtype=float)
    wanted = [wanted + (there - wanted + np.pi) % (2 * np.pi) - np.pi for wanted, there in cases]
    np.testing.assert_allclose(found[:, 0], wanted, atol=1e-14)
    np.testing.assert_allclose(found[:, 1], 0.25, atol=1e-15)
