"""``kinetostatics analyze --tool``: the tip of a tool, in text and JSON."""

import json

import numpy as np
import parametric_machines
import pytest

from kinetostatics.cli.main import main


def test_the_tip_of_a_tool_beyond_a_cantilever(capsys, tmp_path):
    """w = F L³/3EI + a F L²/2EI at the tip of a tool, a beyond the end."""
    common = ["analyze", str(parametric_machines.cantilever(tmp_path)), "--load", "0", "0", "-500", "0", "0", "0"]
    common += ["--gravity", "0", "0", "0", "--tool", "200mm", "0", "0"]
    sag = 64 * 500 * (0.8**3 / 3 + 0.2 * 0.8**2 / 2) / (np.pi * 2e11 * 0.04**4)
    assert main(common) == 0
    assert f"the tool's tip moves by {1e3 * sag:.3f} mm" in capsys.readouterr().out
    assert main([*common, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["tool"]["twist"][2] == pytest.approx(-sag, rel=1e-9)
    assert main([*common[:-3], "1kg", "0", "0"]) == 2 and "--tool" in capsys.readouterr().err
