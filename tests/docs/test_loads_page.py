"""The code and the commands of ``docs/how_to/loads.md`` run, and do what the page says."""

import shlex

import numpy as np
import pytest
from page_code import commands, run_python

from kinetostatics.cli.main import main

matplotlib = pytest.importorskip("matplotlib", reason="needs Matplotlib: pip install 'kinetostatics[plot]'")
matplotlib.use("Agg")


def test_the_pages_code_runs(tmp_path, monkeypatch, capsys):
    from matplotlib import pyplot as plt

    monkeypatch.chdir(tmp_path)
    names = run_python("how_to/loads")
    plt.close("all")
    printed = capsys.readouterr().out
    assert "load         on slider_1: force (0, -80.000, -40.000) N" in printed
    assert "payload      12.000 kg at (0, 50.0, -200.0) mm of o-xyz" in printed
    result, found, numbers = names["result"], names["found"], names["numbers"]
    np.testing.assert_allclose(found.twist @ numbers, result.contributions["payload"], rtol=1e-9, atol=1e-15)
    assert (tmp_path / "payload.png").stat().st_size > 10_000
    # off the middle, the payload makes the two equal actuators differ at mirrored tilts
    first, second = (names["loaded"].actuator_forces[f"prismatic_{k}"] for k in (1, 2))
    bare = [names["bare"].actuator_forces[f"prismatic_{k}"] for k in (1, 2)]
    np.testing.assert_allclose(np.abs(bare[0]), np.abs(bare[1][::-1]), rtol=1e-6)
    assert np.abs(np.abs(first) - np.abs(second[::-1])).min() > 1


@pytest.mark.parametrize("command", [item for item in commands("how_to/loads") if item[0] == "analyze"], ids=shlex.join)
def test_the_pages_commands_run(command, capsys):
    assert main(command) == 0, capsys.readouterr().err
    assert "payload" in capsys.readouterr().out
