"""The code of ``docs/how_to/balance_gravity.md`` runs, and does what the page says."""

import numpy as np
import pytest
from page_code import run_python

matplotlib = pytest.importorskip("matplotlib", reason="needs Matplotlib: pip install 'kinetostatics[plot]'")
matplotlib.use("Agg")


def test_the_pages_code_runs(tmp_path, monkeypatch, capsys):
    from matplotlib import pyplot as plt

    monkeypatch.chdir(tmp_path)
    names = run_python("how_to/balance_gravity")
    plt.close("all")
    assert capsys.readouterr().out.splitlines()[0] == "True"
    assert (tmp_path / "balanced.png").stat().st_size > 10_000
    bare, balanced = (sum(np.abs(force) for force in names[key].actuator_forces.values()) for key in ("bare", "balanced"))
    assert np.all(balanced < bare)
