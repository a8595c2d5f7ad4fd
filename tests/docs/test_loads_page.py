"""The code and the commands of ``docs/how_to/loads.md`` run, and do what the page says."""

import shlex

import numpy as np
import pytest
from page_code import commands, run_python

from kinetostatics.cli.main import main


def test_the_pages_code_runs(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    names = run_python("how_to/loads")
    printed = capsys.readouterr().out
    assert "load         on slider_1: force (0, -80.000, -40.000) N" in printed
    assert "payload      12.000 kg at (0, 50.0, -200.0) mm of o-xyz" in printed
    result, found, numbers = names["result"], names["found"], names["numbers"]
    np.testing.assert_allclose(found.twist @ numbers, result.contributions["payload"], rtol=1e-9, atol=1e-15)


@pytest.mark.parametrize("command", [item for item in commands("how_to/loads") if item[0] == "analyze"], ids=shlex.join)
def test_the_pages_commands_run(command, capsys):
    assert main(command) == 0, capsys.readouterr().err
    assert "payload" in capsys.readouterr().out
