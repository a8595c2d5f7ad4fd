"""C for controllers, compiled strictly and with sanitizers: states, starts, exported files and their texts."""

import re
import shutil
import subprocess

import c_programs
import numpy as np
import package_robots
import pytest
from c_programs import SANITIZED, compiled, run

import kinetostatics as ks
from kinetostatics.functions.c_source import c_array
from kinetostatics.functions.c_texts import STATUSES

pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not installed")


@pytest.fixture(scope="module")
def five_bar():
    return ks.compile(package_robots.robot("five_bar"), ("x", "y"), outputs=("twist", "actuator_forces", "actuators"))


@pytest.fixture(scope="module")
def exported(five_bar, tmp_path_factory):
    folder = tmp_path_factory.mktemp("controller")
    return five_bar.export_c(folder)


@pytest.fixture(scope="module", params=[(), pytest.param(SANITIZED, marks=pytest.mark.slow)], ids=["strict", "sanitized"])
def driver(exported, request):
    return c_programs.driver(exported, request.param)


def test_c_state_is_kept_where_a_pose_is_unreachable(five_bar, driver):
    zero = five_bar.robot.assemble().platform
    x = float(zero["x"]) + np.array([0.02, 0.04, 9.0, 0.04, np.nan, 0.05])
    inputs = np.zeros((len(x), 11))
    inputs[:, 0], inputs[:, 1], inputs[:, 10] = x, float(zero["y"]), -9.81
    status, found = run(driver, inputs, "on")
    assert status.tolist() == [0, 0, 2, 0, 7, 0]
    np.testing.assert_allclose(found[1, :-1], found[3, :-1], rtol=1e-9, atol=1e-18)


def test_c_state_may_start_at_a_given_pose(tmp_path):
    """An arm with a singular zero pose: from a bent pose C equals Python; from zero some poses are unreachable."""
    robot = package_robots.robot("ur10")
    bent = robot.assemble(actuators=dict(zip(robot.description.actuated, (0.3, -1.0, 1.2, -0.9, -1.2, 0.4), strict=True)))
    f = ks.compile(robot, ("x", "y", "z", "rx", "ry", "rz"), outputs=("twist", "actuators"), engine="numpy")
    N, rng = 24, np.random.default_rng(2)
    middle = bent.platform_coordinates("XYZ")
    at = {name: float(middle[name]) + np.where(np.arange(N) % 6 == 5, 9.0, 0.1) * rng.uniform(-1, 1, N) for name in f.names}
    inputs = np.column_stack([*at.values(), np.tile([5.0, 3, -20, 1, -2, 3, 0, 0, -9.81], (N, 1))])
    program = c_programs.driver(f.export_c(tmp_path, near=bent))
    status, found = run(program, inputs)
    wanted = f(**at, load=inputs[0, 6:12], near=bent)
    here = np.isin(wanted["status"], (0, ks.Status.LIMIT_EXCEEDED))
    assert np.array_equal(status == 0, here) and here.sum() > 12 and not here.all()
    expected = np.column_stack([wanted["twist"], wanted["actuators"]])
    for part in np.split(np.arange(12), 2):
        size = np.max(np.abs(expected[here][:, part]), axis=1)
        assert np.max(np.abs(found[here][:, part] - expected[here][:, part]) / size[:, None]) < 1e-9
    assert np.any(f(**at)["status"][here] == ks.Status.UNREACHABLE)
    with pytest.raises(ks.ArgumentError, match="near= needs one closed pose"):
        f.export_c(tmp_path, near=robot.assemble(actuators={name: [0.1, 0.2] for name in robot.description.actuated}))
    with pytest.raises(ks.ArgumentError, match="near= needs one closed pose"):
        f.export_c(tmp_path, near={"x": 0.5})
    with pytest.raises(ks.ArgumentError, match="near= needs one closed pose"):
        f.export_c(tmp_path, near=package_robots.robot("five_bar").assemble())


def test_c_azimuth_and_tilt_equal_python_also_upright(tmp_path):
    """At tilt 0 the azimuth is undefined: lines begin and end there as in Python, and azimuths take the shorter way."""
    f = ks.compile(package_robots.robot("3rps"), ("z", "azimuth", "tilt"), orientation="tilt_torsion", outputs="twist")
    N, rng = 24, np.random.default_rng(4)
    tilt = np.where(np.arange(N) % 3 == 0, 0.0, np.where(np.arange(N) % 3 == 1, 1e-10, rng.uniform(-0.1, 0.5, N)))
    at = {"z": rng.uniform(0.45, 0.6, N), "azimuth": rng.uniform(-3.5, 3.5, N), "tilt": tilt}
    inputs = np.column_stack([*at.values(), np.tile([5.0, 3, -20, 1, -2, 3, 0, 0, -9.81], (N, 1))])
    program = c_programs.driver(f.export_c(tmp_path))
    load, near = inputs[0, 3:9], None
    anew = f(**at, load=load)["twist"]
    for arguments in ((), ("on",)):
        status, found = run(program, inputs, *arguments)
        assert not np.any(status)
        for k in range(N):
            if arguments:
                near = f(**{name: float(value[k]) for name, value in at.items()}, load=load, near=near)
            wanted = near["twist"] if arguments else anew[k]
            assert np.max(np.abs(found[k, :6] - wanted)) < 1e-9 * np.max(np.abs(wanted))


def test_readme_counts_the_operations_of_the_source(exported):
    """Every operation of the source is in one column of the table, by a count of the text."""
    source, readme = ((exported.folder / name).read_text() for name in ("five_bar.c", "README.md"))
    lines = [line.partition(" = ")[2] for line in source.splitlines() if re.match(r"    const (double|int) v\d+ = ", line)]
    patterns = {
        "additions": r" [+-] ",
        "multiplications": r" \* ",
        "divisions": r" / ",
        "square roots": r"sqrt\(",
        "sines, cosines": r"\b(sin|cos)\(",
        "arc tangents": r"atan2\(",
        "signs, roundings": r"^-|fabs\(|rint\(",
    }
    rows = [line.strip("| ").split(" | ") for line in readme.splitlines() if line.startswith("| ") and line.count("|") > 8]
    titles, total = rows[0][2:], np.sum([[int(cell.replace(",", "")) for cell in row[2:]] for row in rows[1:]], axis=0)
    counts = [sum(bool(re.search(patterns[title], line)) for line in lines) for title in titles[:-1]]
    assert [*counts, len(lines) - sum(counts)] == total.tolist()
    operations = {row[0]: sum(int(cell.replace(",", "")) for cell in row[2:]) for row in rows[1:]}
    assert exported.operations == (operations["correction of the loops"], operations["frames, statics, actuators"])
    assert f"WORK = {exported.work // 8} " in source and f"takes {exported.work:,} bytes" in readme


def test_c_test_program_reports_corrections_and_times(exported):
    program = compiled(exported.folder, "five_bar_test.c", "five_bar.c")
    first, *rest = subprocess.run([program], capture_output=True, text=True, check=True).stdout.splitlines()
    assert first == "0 of 40 poses differ"
    assert re.fullmatch(r"[\d.]+ corrections of the loops per call, average of 500 calls", rest[0])
    assert 1 <= float(rest[0].split()[0]) < 4 and re.fullmatch(
        r"[\d.e+]+ microseconds per call, average of the same calls", rest[1]
    )


def test_exported_files_and_their_texts(exported):
    assert exported.files == ("five_bar.h", "five_bar.c", "five_bar.hpp", "five_bar_test.c", "CMakeLists.txt", "README.md")
    text = (exported.folder / "five_bar.c").read_text()
    assert not any(word in text for word in ("malloc", "static double", "printf", "alloca"))
    header = (exported.folder / "five_bar.h").read_text()
    assert (
        "double x; /* x: coordinate of o, world axes [m]; 0 at the zero pose; the status is UNREACHABLE outside the workspace */"
        in header
    )
    assert "twist[6]; /* displacement of o and rotation of the platform, world axes; in the order x" in header
    readme = (exported.folder / "README.md").read_text()
    assert "| test for singular poses | step of the line |" in readme
    assert all(f"`FIVE_BAR_{name}` | {value} |" in readme for name, value, _ in STATUSES)
    assert all(ks.Status[name] == value for name, value, _ in STATUSES if name in ks.Status.__members__)
    assert c_array([0.1, -2.0]) == "{0.1, (-2.0)}" and c_array([]) == "{0.0}"


def test_readme_example_compiles_and_returns_numbers(exported):
    """Compiled strictly, at the zero pose."""
    example = (exported.folder / "README.md").read_text().partition("```c\n")[2].partition("```")[0]
    include, body = example.split("\n", 1)
    body = body.replace("/* use output */", "return output.twist[0] == output.twist[0] ? 0 : 2;")
    (exported.folder / "example.c").write_text(f"{include}\nint main(void)\n{{\n{body}return 1;\n}}\n")
    assert subprocess.run([compiled(exported.folder, "example.c", "five_bar.c")]).returncode == 0


@pytest.mark.skipif(shutil.which("g++") is None, reason="g++ is not installed")
def test_cpp_wrapper_compiles(exported):
    subprocess.run(["g++", "-std=c++11", "-Wall", "-Wextra", "-Werror", "-fsyntax-only", "-x", "c++", "five_bar.hpp"],
                   cwd=exported.folder, check=True)  # fmt: skip


def test_a_function_without_outputs_returns_the_status(five_bar, tmp_path):
    exported = ks.compile(five_bar.robot, outputs=()).export_c(tmp_path, name="poses")
    program = compiled(exported.folder, "poses.c", "poses_test.c")
    assert "0 of 40 poses differ" in subprocess.run([program], check=True, capture_output=True, text=True).stdout


def test_invalid_exports_raise_argument_error(tmp_path):
    upright = {"platform": ("z", "azimuth", "tilt"), "orientation": "tilt_torsion", "outputs": "actuators"}
    with pytest.raises(ks.ArgumentError, match="azimuth and tilt cannot be exported together with compensation"):
        ks.compile(package_robots.robot("3rps"), **upright, compensate=True).export_c(tmp_path)
    with pytest.raises(ks.ArgumentError, match="scalar"):
        ks.compile(package_robots.robot("3rps")).export_c(tmp_path, "half")
    (tmp_path / "taken").write_text("", encoding="utf-8")
    with pytest.raises(ks.ArgumentError, match="taken is a file"):
        ks.compile(package_robots.robot("3rps")).export_c(tmp_path / "taken")


def test_c_states_whether_an_actuator_is_beyond_its_effort(five_bar, driver):
    zero = five_bar.robot.assemble().platform
    inputs = np.zeros((2, 11))
    inputs[:, 0], inputs[:, 1] = float(zero["x"]), float(zero["y"])
    inputs[1, 2] = 200.0
    status, found = run(driver, inputs)
    efforts = five_bar.robot.description.actuator_limits("effort")
    assert status.tolist() == [0, 0] and found[:, -2].tolist() == [0, 1]
    assert max(abs(found[1, 6:8])) > min(efforts.values()) > max(abs(found[0, 6:8]))
