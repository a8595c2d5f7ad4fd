"""``--engine`` of ``analyze`` and ``check``."""

import json

import pytest
from small_robots import cantilever, write

from kinetostatics.cli.main import main


@pytest.fixture
def arm(tmp_path, monkeypatch):
    monkeypatch.setenv("KINETOSTATICS_CACHE", str(tmp_path / "code"))
    path = tmp_path / "arm.urdf"
    path.write_text(write(cantilever()).text, encoding="utf-8")
    return str(path)


def test_both_engines_print_the_same(arm, capsys, tmp_path):
    texts = []
    for engine in ("numpy", "compiled"):
        assert main(["analyze", arm, "--engine", engine, "--load", "1", "2", "3", "4", "5", "6"]) == 0
        texts.append(capsys.readouterr().out)
        assert (tmp_path / "code").exists() == (engine == "compiled")
    assert texts[0] == texts[1] and "Twist" in texts[0]


def test_check_says_what_is_compiled(arm, capsys):
    assert main(["check", arm, "--engine"]) == 0
    text = capsys.readouterr().out
    assert "the equilibrium of poses is compiled: " in text and "closing the loops is compiled: " in text
    assert main(["check", arm, "--engine", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["engine"]
    assert found["is_compiled"] and f"{found['operations']:,} operations a pose" in text
    assert main(["check", arm, "--json"]) == 0
    assert "engine" not in json.loads(capsys.readouterr().out)
