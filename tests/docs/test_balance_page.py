"""The code of ``docs/how_to/balance_gravity.md`` runs, and does what the page says."""

import re

import numpy as np
import pytest
from places import ROOT

matplotlib = pytest.importorskip("matplotlib", reason="needs Matplotlib: pip install 'kinetostatics[plot]'")
matplotlib.use("Agg")


def test_the_pages_code_runs(tmp_path, monkeypatch, capsys):
    from matplotlib import pyplot as plt

    monkeypatch.chdir(tmp_path)
    page, names = (ROOT / "docs" / "how_to" / "balance_gravity.md").read_text(encoding="utf-8"), {}
    for code in re.findall(r"```python\n(.*?)```", page, re.DOTALL):
        exec(compile(code, "balance_gravity.md", "exec"), names)  # the page's own text
    plt.close("all")
    assert capsys.readouterr().out.splitlines()[0] == "True"
    assert (tmp_path / "balanced.png").stat().st_size > 10_000
    bare, balanced = (sum(np.abs(force) for force in names[key].actuator_forces.values()) for key in ("bare", "balanced"))
    assert np.all(balanced < bare)
