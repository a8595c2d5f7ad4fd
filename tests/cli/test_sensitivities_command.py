"""``kinetostatics sensitivities``: the tables, JSON and the bar chart."""

import json

import pytest

from kinetostatics.cli.main import main


def test_tables_json_and_chart(capsys, tmp_path):
    pytest.importorskip("matplotlib")
    arguments = ["sensitivities", "3rps", "--load", "0", "0", "-500", "0", "0", "0", "--by", "youngs_modulus", "platform_mass"]
    chart = tmp_path / "stiffen.svg"
    assert main([*arguments, "--out", str(chart)]) == 0
    out = capsys.readouterr().out
    rows = {line.split()[0]: line.split() for line in out.splitlines() if line.startswith("  ")}
    assert "-1.000" in rows["youngs_modulus"] and rows["rod_1"][-1].startswith("-0.3") and f"wrote {chart}" in out
    assert chart.stat().st_size > 5000
    assert main([*arguments[:-1], "--json"]) == 0
    read = json.loads(capsys.readouterr().out)
    assert list(read["parameters"]) == ["youngs_modulus"] and set(read["sources"]) == {"rod_1", "rod_2", "rod_3"}
