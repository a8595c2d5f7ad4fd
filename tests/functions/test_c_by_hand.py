"""Exported C of a turntable with a lift against statics, derivatives and corrections by hand; texts of the export."""

import shutil
import subprocess

import c_programs
import numpy as np
import pytest
from c_programs import SANITIZED, STRICT, compiled, rows, run
from loop_robots import actuated, frame, joint, robot
from simple_machines import springs

import kinetostatics as ks
from kinetostatics.functions import c_source

pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not installed")

#: How far o is from the axis, and how high at zero [m], stiffnesses of the drives [N·m/rad, N/m], mass [kg], its centre from o.
REACH, HEIGHT, TURN, LIFT, MASS, CENTRE = 0.3, 0.5, 200.0, 500.0, 2.0, np.array([0.05, -0.02, 0.04])
LOWER, UPPER = -0.2, 0.1
OUTPUTS = ("twist", "actuator_forces", "actuators")


def turntable():
    """An endless turn about z, on it a lift with limits that carries the platform."""
    inertia = f'<inertial><origin xyz="0.05 -0.02 0.04"/><mass value="{MASS}"/></inertial>'
    return robot(
        joint("turn", "continuous", "base", "table", np.eye(4), (0, 0, 1)),
        joint(
            "lift", "prismatic", "table", "platform", frame(p=(REACH, 0, HEIGHT)), (0, 0, 1), f'lower="{LOWER}" upper="{UPPER}"'
        ),
        actuated("turn", "lift"),
        springs("turn", drive=f"{TURN}"),
        springs("lift", drive=f"{LIFT}"),
        links={"base": "", "table": "", "platform": inertia},
        name="turntable",
    )


def by_hand(turn, z, load, gravity):
    """Return twist (6,), forces (2,) and positions (2,) of the actuators."""
    c, s = np.cos(turn), np.sin(turn)
    moves = np.array([[-REACH * s, REACH * c, 0, 0, 0, 1], [0, 0, 1, 0, 0, 0]])
    along = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ CENTRE
    wrench = load + MASS * np.concatenate([gravity, np.cross(along, gravity)])
    work, give = moves @ wrench, np.array([1 / TURN, 1 / LIFT])
    return moves.T @ (give * work), -work, np.array([turn, z - HEIGHT])


def by_corrections(turn, z, load, gravity):
    """Return positions and forces of the actuators with which the loaded platform has a turn and a height, and what remains."""
    at = np.array([turn, z])
    for _ in range(60):  # the sag at the pose that is commanded hardly changes with it
        twist, forces, _ = by_hand(*at, load, gravity)
        at = np.array([turn - twist[5], z - twist[2]])
    place = REACH * np.array([np.cos(at[0]) - np.cos(turn), np.sin(at[0]) - np.sin(turn)])
    return at - [0, HEIGHT], forces, np.concatenate([place + twist[:2], np.zeros(4)])


def some(N, seed):
    """Return coordinates, loads and gravity of N poses, that are within the limits before they are corrected."""
    rng = np.random.default_rng(seed)
    at = {"z": HEIGHT + rng.uniform(0.9 * LOWER, 0.9 * UPPER, N), "rz": rng.uniform(-3.1, 3.1, N)}
    return at, rng.uniform(-30, 30, (N, 6)), rng.uniform(-10, 10, (N, 3))


def answer(folder, *files, flags=()):
    """Return the exit status of a program and what it prints."""
    found = subprocess.run([compiled(folder, *files, flags=flags)], capture_output=True, text=True)
    return found.returncode, found.stdout


@pytest.fixture(scope="module")
def derived(tmp_path_factory):
    """The function by the platform, its derivatives, and what was exported."""
    f = ks.compile(turntable(), ("z", "rz"), outputs=OUTPUTS)
    J = f.jacobian(OUTPUTS, ("z", "rz", "load", "gravity"))
    exported = J.export_c(tmp_path_factory.mktemp("turntable"), name="table")
    subprocess.run(["gcc", *STRICT, "-c", "table.c"], cwd=exported.folder, check=True)
    return f, J, exported


@pytest.fixture(scope="module")
def corrected(tmp_path_factory):
    """The function that compensates, and what was exported."""
    f = ks.compile(turntable(), ("z", "rz"), outputs=("actuators", "actuator_forces", "residual_error"), compensate=True)
    return f, f.export_c(tmp_path_factory.mktemp("corrected"), name="5 tables")


def test_c_results_and_derivatives_equal_hand_calculation(derived):
    f, _, exported = derived
    at, load, gravity = some(40, 1)
    status, found = run(c_programs.driver(exported, derivatives=True), rows(f, at, load, gravity))
    assert not status.any() and found.shape[1] == 11 + 11 * 10

    def numbers(row):
        return np.concatenate(by_hand(row[1], row[0], row[2:8], row[8:]))

    for row, inputs in zip(found, rows(f, at, load, gravity), strict=True):
        np.testing.assert_allclose(row[:10], numbers(inputs), rtol=1e-9, atol=1e-12)
        ends = [[numbers(inputs + k * e) for k in (1, 2, -1, -2)] for e in 1e-3 * np.eye(11)]
        slopes = np.array([8 * (a - c) - (b - d) for a, b, c, d in ends]).T / 12e-3  # of fourth order
        parts = [np.split(part, [1, 2, 8], axis=1) for part in np.split(slopes, [6, 8])]
        np.testing.assert_allclose(row[11:], np.concatenate([np.ravel(a) for part in parts for a in part]), rtol=1e-8, atol=1e-9)


def test_c_null_pointers_are_bad_arguments(derived):
    folder = derived[2].folder
    calls = ["(0, &s, &o)", "(&i, 0, &o)", "(&i, &s, 0)"]
    calls = [f"table_evaluate{call}" for call in calls] + [f"table_differentiate{call[:-1]}, &j)" for call in calls]
    (folder / "null.c").write_text(
        '#include "table.h"\nint main(void)\n{\n    table_input i = {0};\n    table_state s;\n    table_output o;\n'
        "    table_jacobian j;\n    table_start(&s);\n    return !("
        + " && ".join(f"{call} == TABLE_BAD_ARGUMENT" for call in [*calls, "table_differentiate(&i, &s, &o, 0)"])
        + ");\n}\n"
    )
    assert answer(folder, "null.c", "table.o")[0] == 0


@pytest.mark.parametrize("flags", [(), pytest.param(SANITIZED, marks=pytest.mark.slow)], ids=["strict", "sanitized"])
def test_c_corrections_equal_hand_calculation(corrected, flags):
    """Also across half a turn, and beyond limits with status 1; sanitizers check the sizes of arrays."""
    f, exported = corrected
    at, load, gravity = some(200, 2)
    status, found = run(c_programs.driver(exported, flags), rows(f, at, load, gravity))
    wanted = [by_corrections(at["rz"][k], at["z"][k], load[k], gravity[k]) for k in range(200)]
    drives, forces, residual_error = (np.array(part) for part in zip(*wanted, strict=True))
    np.testing.assert_allclose(found[:, :2], drives, atol=1e-11)
    np.testing.assert_allclose(found[:, 2:4], forces, atol=1e-9)
    np.testing.assert_allclose(found[:, 4:10], residual_error, atol=1e-11)
    beyond = (drives[:, 1] < LOWER) | (drives[:, 1] > UPPER)
    assert np.array_equal(status, np.where(beyond, 1, 0)) and 5 < beyond.sum() < 100
    assert np.max(np.abs(drives[:, 0])) > np.pi
    back = f(**at, load=load, gravity=gravity)
    assert np.array_equal(back["status"], status) and np.max(np.abs(back["actuators"] - drives)) < 1e-11


def test_c_unfinished_correction_is_unreachable(corrected, tmp_path, monkeypatch):
    """One step leaves 1e-10 rad of a turn of 1e-5 rad, which exceeds the tolerance of corrections."""
    monkeypatch.setattr(c_source, "MOST", 1)
    program = c_programs.driver(corrected[0].export_c(tmp_path))
    poses = np.zeros((2, 11))
    poses[:, :2], poses[:, 3] = (HEIGHT, 0.5), np.array([1e-5, 1e-9]) * TURN / REACH  # turns of 1e-5 and 1e-9 rad
    assert run(program, poses)[0].tolist() == [2, 0]


def test_c_statics_with_mimic_joint_equals_hand_calculation(tmp_path):
    """A continuous joint and its mimic move o; header and README give units, limits and the number of sines."""
    table = robot(
        joint("turn", "continuous", "base", "table", np.eye(4), (0, 0, 1)),
        joint("lift", "prismatic", "table", "sledge", frame(p=(REACH, 0, HEIGHT)), (0, 0, 1), f'lower="{LOWER}" upper="{UPPER}"'),
        joint("back", "continuous", "sledge", "platform", np.eye(4), (0, 0, 1)).replace(
            "</joint>", '<mimic joint="turn" multiplier="-0.7" offset="0.2"/></joint>'
        ),
        actuated("turn", "lift"),
        springs("turn", drive=f"{TURN}"),
        springs("lift", drive=f"{LIFT}"),
        links=("base", "table", "sledge", "platform"),
    )
    f = ks.compile(table, outputs="twist")
    exported = f.export_c(tmp_path, name="table")
    rng = np.random.default_rng(3)
    at = {"turn": rng.uniform(-9, 9, 30), "lift": rng.uniform(LOWER, UPPER, 30)}
    load = rng.uniform(-30, 30, (30, 6))
    status, found = run(c_programs.driver(exported), rows(f, at, load, np.zeros((30, 3))))
    assert not status.any()
    c, s, none = np.cos(at["turn"]), np.sin(at["turn"]), np.zeros(30)
    moves = np.array([-REACH * s, REACH * c, none, none, none, none + 0.3])
    sags = moves * np.sum(moves * load.T, axis=0) / TURN
    sags[2] = load[:, 2] / LIFT
    np.testing.assert_allclose(found[:, :6].T, sags, atol=1e-12)
    header, readme = ((tmp_path / name).read_text() for name in ("table.h", "README.md"))
    assert "double turn; /* turn: coordinate of the actuator [rad]; 0 at the zero pose; the status is" in header
    assert "double lift; /* lift: coordinate of the actuator [m]; 0 at the zero pose; valid from -0.2 to 0.1 */" in header
    assert ", nor are 4 sines and cosines of given angles in each step of a line." in readme


# ---- exported test programs --------------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.few(1)
@pytest.mark.parametrize("case", ["derivatives", "corrections"])
def test_test_programs_detect_errors_of_1e_7(case, derived, corrected):
    """The programs pass with the exported files, and fail if loads of derivatives or corrections are larger by 1e-7."""
    exported, item = (derived[2], "twist_by_rz") if case == "derivatives" else (corrected[1], "actuators")
    folder, name = exported.folder, exported.name
    code, printed = answer(folder, f"{name}_test.c", f"{name}.c")
    assert code == 0 and printed.startswith("0 of 40 poses differ\n")
    assert float(printed.splitlines()[1].split()[0]) < 30  # corrections of loops per call: the search ends
    text = (folder / f"{name}.c").read_text()
    first, _, last = text.rpartition(" load[k] = (double)")
    derivatives = f"{first} load[k] = (1.0 + 1e-7) * (double){last}"
    wrong = derivatives if case == "derivatives" else text.replace("= (double)actuators[", "= 1.0000001 * actuators[")
    (folder / "wrong.c").write_text(wrong)
    code, printed = answer(folder, f"{name}_test.c", "wrong.c")
    assert code == 1 and printed.startswith(f"{item} differs by")


def test_c_float_export_passes_its_test_program(derived, tmp_path):
    derived[0].export_c(tmp_path, "float", name="small")
    code, told = answer(tmp_path, "small_test.c", "small.c")
    assert code == 0 and told.startswith("0 of 40 poses differ\n")
    header, readme = ((tmp_path / name).read_text() for name in ("small.h", "README.md"))
    assert "    float twist[6];" in header and "    float load[6];" in header and "    float z; /* z: " in header
    assert "Arguments and results are `float`" in readme
