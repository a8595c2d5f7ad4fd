"""The Python and the commands of each how-to page run unchanged, one after the other, in a folder of their own."""

import os
import shlex

import matplotlib
import numpy as np
import pytest
from page_code import DOCS, blocks, commands, in_a_copy, run_commands, run_python, text_of

from kinetostatics.cli.main import main

matplotlib.use("Agg")

#: Files of the reader, which do not exist here.
OWN = ("poses.csv", "path.csv")
#: Pages whose Python or commands have tests of their own, or need windows or a file of the reader's.
ELSEWHERE = {
    "python": "balance_gravity calibrate castings correct_a_machine feedforward find_what_to_stiffen frameworks loads motion "
    "natural_frequencies pinocchio plain_urdf report robots_in_python size_a_rod tolerances viewer workspace "
    "workspace_figures".split(),
    "sh": "castings controller loads motion plain_urdf report viewer workspace_figures".split(),
}
#: Pages that take more than two seconds.
LONG = {
    "python": ["compiled"],
    "sh": "calibrate correct_a_machine find_what_to_stiffen natural_frequencies size_a_rod tolerances workspace".split(),
}
PAGES = sorted(path.stem for path in (DOCS / "how_to").glob("*.md"))


def cases(kind):
    """Return the pages with blocks of a kind that are run here."""
    found = [name for name in PAGES if any(block.kind == kind for block in blocks(text_of(f"how_to/{name}")))]
    assert set(ELSEWHERE[kind]) <= set(found)
    return [
        pytest.param(name, marks=[pytest.mark.slow] * (name in LONG[kind]))
        for name in found
        if name not in ELSEWHERE[kind] and (kind == "python" or commands(f"how_to/{name}"))
    ]


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    from matplotlib import pyplot as plt

    in_a_copy(tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("KINETOSTATICS_CACHE", str(tmp_path / "code"))
    yield
    plt.close("all")


@pytest.mark.few(2)
@pytest.mark.parametrize("name", cases("python"))
def test_python_of_a_page_runs(name):
    assert "ks" in run_python(f"how_to/{name}")


@pytest.mark.few(1)
@pytest.mark.parametrize("name", cases("sh"))
def test_commands_of_a_page_run(name, capsys):
    """All but those that need a file of the reader's own; the files named by ``--out`` exist afterwards."""
    assert run_commands(f"how_to/{name}", OWN) > 0
    for command in commands(f"how_to/{name}"):
        if "--out" in command and not set(command) & set(OWN):
            assert os.path.exists(command[command.index("--out") + 1])


def test_balancing_reduces_actuator_forces(tmp_path, capsys):
    names = run_python("how_to/balance_gravity")
    assert capsys.readouterr().out.splitlines()[0] == "True"
    assert (tmp_path / "balanced.png").stat().st_size > 10_000
    bare, balanced = (sum(np.abs(force) for force in names[key].actuator_forces.values()) for key in ("bare", "balanced"))
    assert np.all(balanced < bare)


def test_loads_page_prints_loads_and_payload_contribution(capsys):
    names = run_python("how_to/loads")
    printed = capsys.readouterr().out
    assert "load         on slider_1: force (0, -80.000, -40.000) N" in printed
    assert "payload      12.000 kg at (0, 50.0, -200.0) mm of o-xyz" in printed
    result, found, numbers = names["result"], names["found"], names["numbers"]
    np.testing.assert_allclose(found.twist @ numbers, result.contributions["payload"], rtol=1e-9, atol=1e-15)


@pytest.mark.parametrize("command", [item for item in commands("how_to/loads") if item[0] == "analyze"], ids=shlex.join)
def test_analyze_commands_of_the_loads_page_print_the_payload(command, capsys):
    assert main(command) == 0 and "payload" in capsys.readouterr().out
