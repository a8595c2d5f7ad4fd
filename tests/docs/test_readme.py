"""Commands, examples and tables of the README and of the pages on the paper are those of the code."""

import re
import shlex
import tomllib
from importlib import metadata
from pathlib import Path

import numpy as np
import paper_configuration_2
import paper_step_by_step as page
import pytest
import reproduce_paper
from packaging.requirements import Requirement
from page_code import between, blocks, in_a_copy, python_of
from places import ROOT

import kinetostatics as ks
from kinetostatics.cli.main import main

README = (ROOT / "README.md").read_text(encoding="utf-8")
#: Commands that take long, and have tests of their own.
OF_THEIR_OWN = ("verify", "report", "optimize", "calibrate", "tolerances", "export")


def test_paper_tables_equal_those_of_the_example():
    page = reproduce_paper.PAGE.read_text(encoding="utf-8")
    assert between(page, "paper tables").strip() == reproduce_paper.tables().strip(), (
        "stale: run python examples/reproduce_paper.py --write"
    )


def test_differences_from_the_paper_in_configuration_2():
    """Five numbers are not reproduced; eight more of the analytical row differ by 0.7 to 3.4 %."""
    printed = reproduce_paper.TABLES["2pru_upr"]["configuration_2"]
    computed = reproduce_paper.ours("2pru_upr", 2)
    differences = {
        source: np.abs(
            [
                abs(value) / abs(float(number)) - 1
                for key in ("twist", "f1", "f2", "fa")
                for value, number in zip(computed[key], printed[source][key], strict=True)
            ]
        )
        for source in ("analytical", "FEA")
    }
    missed = (differences["analytical"] > 0.005) & (differences["FEA"] > 0.005)
    assert sorted(np.flatnonzero(missed)) == [1, 2, 3, 5, 11]  # Δ_dy, Δ_dz, Δ_rx, Δ_rz, f_32
    more = differences["analytical"][~missed & (differences["analytical"] > 0.005)]
    assert more.size == 8 and 0.007 < more.min() and more.max() < 0.0342


def test_readme_example_prints_its_output(monkeypatch, capsys):
    monkeypatch.chdir(ROOT)
    code, printed = (block.text for block in blocks(between(README, "example")))
    exec(compile(code, "README.md", "exec"), {})  # the README's own text
    assert capsys.readouterr().out == printed


def test_the_example_of_assembly_errors_runs(monkeypatch, capsys):
    monkeypatch.chdir(ROOT)
    names = {}
    exec(compile(python_of("how_to/tolerances")[0], "tolerances.md", "exec"), names)  # the page's own text
    assert abs(names["result"].contributions["assembly_errors"][0]) > 1e-5
    assert "prismatic_1" in capsys.readouterr().out


@pytest.mark.slow
def test_commands_for_maps_write_their_files(monkeypatch, tmp_path, capsys):
    import matplotlib

    matplotlib.use("Agg")
    monkeypatch.chdir(tmp_path)
    commands = [shlex.split(line) for line in between(README, "maps").splitlines() if line.startswith("kinetostatics ")]
    assert [command[1] for command in commands] == ["sweep", "plot", "plot"]
    for command in commands:
        if command[1] == "sweep":  # a coarser grid
            command = [word.replace(":72", ":12").replace(":26", ":6") for word in command]
        assert main(command[1:]) == 0, capsys.readouterr().err
        assert (tmp_path / command[command.index("--out") + 1]).exists()
    assert "648 poses (z 9 × azimuth 12 × tilt 6)" in capsys.readouterr().out


def test_formulas_of_the_paper_page_equal_the_package():
    """``docs/explanation/paper.md`` with Eqs. (2) to (24) is up to date, too."""
    assert page.PAGE.read_text(encoding="utf-8") == page.page(), "stale: run python examples/paper_step_by_step.py --write"
    rows = [row for _, found in page.pages() for row in found]
    assert len(rows) > 45 and max(row.difference for row in rows) < 1e-12
    equations = " ".join(row.equation for row in rows)
    assert all(
        f"({number})" in equations for number in (2, 4, 5, 6, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 24)
    )


def test_computed_twist_fits_the_forces_the_papers_does_not():
    second = paper_configuration_2.Second.read()
    forces = {key: np.abs([limb.intensities[k] for limb in second.limbs]) for k, key in enumerate(("f1", "f2"))}
    for component in range(1, 6):  # along the line Δ_dx does not change
        np.testing.assert_allclose(second.compatible(forces, second.result.twist, component), second.result.twist, rtol=1e-8)
    assert second.compatible(second.analytical, second.analytical["twist"], 1)[0] == pytest.approx(21.56e-6, rel=5e-4)
    assert second.compatible(second.elements, second.elements["twist"], 1)[5] == pytest.approx(-0.56e-6, rel=0.01)


@pytest.mark.parametrize("key", reproduce_paper.COMMANDS)
def test_commands_print_the_numbers_of_the_paper_tables(key, capsys):
    from kinetostatics.cli.main import main

    command, ours = reproduce_paper.COMMANDS[key], reproduce_paper.ours(*key)
    assert command in reproduce_paper.PAGE.read_text(encoding="utf-8") and main(command.split()[1:]) == 0
    out = capsys.readouterr().out
    numbers = [abs(float(found)) for found in re.findall(r"-?\d+\.\d+", out)]
    twist = {"m": [abs(x) for x in ours["twist"][:3]], "rad": [abs(x) for x in ours["twist"][3:]]}
    for size, powers in ((twist["m"], (1e6, 1e9)), (twist["rad"], (1e6, 1e9)), (ours["f1"] + ours["f2"] + ours["fa"], (1.0,))):
        for value in size:
            if value > max(1e-6 * max(size), 1e-15):
                assert any(abs(number - value * power) < 2e-3 * number for power in powers for number in numbers), (value, out)


def test_readme_verifies_the_pose_that_it_analyses():
    lines = [line for line in between(README, "commands").splitlines() if line.startswith("kinetostatics ")]
    commands = [shlex.split(line, comments=True) for line in lines]
    analyzed, verified = ([words[2:] for words in commands if words[1] == name] for name in ("analyze", "verify"))
    assert analyzed == verified and len(verified) == 1


def test_size_of_the_environment_is_that_of_the_required_packages():
    """pip and compiled modules, some per cent of a fresh environment, are not among the files of packages."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    total, of_pinocchio, seen, wanted = 0, 0, set(), [Requirement(text) for text in project["dependencies"]]
    while wanted:
        requirement = wanted.pop()
        package = metadata.distribution(requirement.name)
        for extra in {"", *requirement.extras}:
            needed = map(Requirement, package.requires or ())
            asked = {item.name: item for item in needed if item.marker is None or item.marker.evaluate({"extra": extra})}
            wanted += [item for name, item in asked.items() if (requirement.name, extra, name) not in seen]
            seen |= {(requirement.name, extra, name) for name in asked}
        if requirement.name not in seen:
            seen.add(requirement.name)
            files = [Path(str(file.locate())) for file in package.files or ()]
            sizes = {file: file.stat().st_size for file in files if file.is_file()}
            total += sum(sizes.values())
            of_pinocchio += sum(size for file, size in sizes.items() if "cmeel.prefix" in file.parts)
    words = re.search(
        r"takes ([\d.]+) GB of disk, of which Pinocchio, its libraries and its example robots take ([\d.]+) GB",
        " ".join(README.split()),
    )
    assert total / 1e9 == pytest.approx(0.95 * float(words[1]), rel=0.1)
    assert of_pinocchio / 1e9 == pytest.approx(float(words[2]), rel=0.1)


def test_sags_named_in_the_readme_are_those_of_robots_with_rigid_joints():
    words = " ".join(README.split())
    for name, text in (("2pru_upr", "the 2PRU-UPR below sags by 24 µm"), ("ur10", "a UR10 by 0.36 mm")):
        robot = ks.load_robot(name)
        sag = np.linalg.norm(ks.analyze(robot.assemble()).twist[:3])
        size, unit = re.search(r"([\d.]+) (µm|mm)$", text).groups()
        assert text in words and f"{sag / {'µm': 1e-6, 'mm': 1e-3}[unit]:.{len(size.partition('.')[2])}f}" == size
        assert not robot.description.joint_stiffness or all(
            np.isinf(stiffness.drive) for stiffness in robot.description.joint_stiffness.values()
        )


def test_readme_commands_run_in_a_clone(monkeypatch, tmp_path, capsys):
    """The files that they name are in a clone; their output is written into its folder."""
    in_a_copy(tmp_path)
    monkeypatch.chdir(tmp_path)
    lines = [line.rpartition("&& ")[2] for line in between(README, "commands").splitlines() if "kineto" in line]
    commands = [shlex.split(line, comments=True) for line in lines]
    assert len(commands) > 6
    for command in commands:
        if command[1] in OF_THEIR_OWN:
            continue
        assert main(command[1:]) == 0, (command, capsys.readouterr().err)
    assert {"sag.html", "my_robot.urdf.xacro", "delta.urdf.xacro"} <= {path.name for path in tmp_path.iterdir()}
    assert ".venv/bin/" not in between(README, "commands") + between(README, "maps"), "the environment is activated"
    assert README.index("source .venv/bin/activate") < README.index("commands: begin")
