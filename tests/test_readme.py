"""What the README says is what the code does."""

import re
import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")
sys.path.insert(0, str(ROOT / "examples"))
reproduce_paper = pytest.importorskip("reproduce_paper")


def between(name):
    found = re.search(rf"<!-- {name}: begin -->\n(.*?)<!-- {name}: end -->", README, re.DOTALL)
    assert found, name
    return found.group(1)


def test_tables_in_the_readme_are_those_that_the_example_computes():
    assert between("paper tables").strip() == reproduce_paper.tables().strip(), (
        "stale: run python examples/reproduce_paper.py --write-readme"
    )


def test_write_readme_changes_only_what_stands_between_the_markers(tmp_path):
    copy = tmp_path / "README.md"
    copy.write_text(README, encoding="utf-8")
    reproduce_paper.write_readme(copy, "other")
    text = copy.read_text(encoding="utf-8")
    assert text == README.replace(between("paper tables"), "\nother\n")


def test_the_complete_example_runs(monkeypatch, capsys):
    monkeypatch.chdir(ROOT)
    code = re.search(r"```python\n(.*?)```", between("example"), re.DOTALL).group(1)
    names = {}
    exec(compile(code, "README.md", "exec"), names)  # the README's own text
    assert names["result"].actuator_forces["prismatic_1"] > 0
    assert names["path"].twist.shape == (1000, 6)
    np.testing.assert_array_equal(names["path"].status, 0)
    assert "limb_1" in capsys.readouterr().out


def test_files_that_the_readme_links_to_exist():
    for target in re.findall(r"\]\(([^)#:]+)\)", README):
        assert (ROOT / target).exists(), target


def test_modules_named_in_the_readme_exist():
    rooms = README.split("## The code")[1].split("## Citing")[0]
    for row in re.findall(r"^\| (`.*?) \|", rooms, re.MULTILINE):
        for name in re.findall(r"`([a-z_*]+)`", row):
            assert list((ROOT / "src" / "kinetostatics").glob(name.rstrip("*") + "*")), name


def test_the_example_of_misfits_runs(monkeypatch, capsys):
    monkeypatch.chdir(ROOT)
    code = re.search(r"```python\n(.*?)```", between("misfits"), re.DOTALL).group(1)
    names = {}
    exec(compile(code, "README.md", "exec"), names)  # the README's own text
    assert abs(names["result"].contributions["misfit"][0]) > 1e-5
    assert "prismatic_1" in capsys.readouterr().out


def test_the_readme_counts_the_robots():
    words = {16: "Sixteen", 17: "Seventeen", 18: "Eighteen"}
    assert f"{words[len(list((ROOT / 'robots').glob('*.urdf.xacro')))]} robots come with it" in README
