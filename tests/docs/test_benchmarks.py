"""The benchmark of workspace maps runs on valid grids, and its page has the tables that it writes."""

import os
import re
import subprocess
import sys
from itertools import pairwise

import numpy as np
import package_robots
import pytest
from places import ROOT

import kinetostatics as ks

PAGE = ROOT / "docs" / "explanation" / "benchmarks.md"
sys.path.insert(0, str(ROOT / "benchmarks"))
kept = {name: os.environ.get(name) for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")}
import grids  # noqa: E402
import page  # noqa: E402
import topics  # noqa: E402

for name, value in kept.items():  # the other tests need not be kept to one thread
    if value is None:
        os.environ.pop(name, None)


def numbers_of(path=PAGE):
    """Return the text between the markers of each topic."""
    return dict(re.findall(r"<!-- (\w+): begin -->\n(.*?)<!-- \1: end -->", path.read_text(encoding="utf-8"), re.DOTALL))


def heads(text):
    """Return the heads of the tables of a text, without the numbers of measured poses."""
    lines = text.splitlines()
    return [re.sub(r"[\d,]+ poses", "poses", above) for above, below in pairwise(lines) if below.startswith("|---")]


def rows(text):
    """The cells of the first table of a topic, its head left out."""
    lines = [line for line in text.splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[2:]]


# ---- the page ----------------------------------------------------------------------------------------------------------------


def test_page_has_every_robot_and_the_ratios_of_its_times():
    found = rows(numbers_of()["opensees"])
    assert [row[0].strip("`") for row in found] == list(topics.SOME)
    for row in found:
        assert int(row[1].replace(",", "")) >= 20_000
        ours, theirs = float(row[2]), [float(cell.replace(",", "")) for cell in row[5:8]]
        for ratio, time in zip(row[8:11], theirs, strict=True):
            assert float(ratio.replace(",", "")) == pytest.approx(time / ours, rel=0.06)  # of rounded numbers
        assert float(row[11]) < 1e-3


@pytest.mark.slow
def test_small_run_writes_the_tables_between_the_markers(tmp_path):
    some = ["opensees", "sizes"]
    copy = tmp_path / "benchmarks.md"
    copy.write_text(PAGE.read_text(encoding="utf-8"), encoding="utf-8")
    command = [sys.executable, "benchmarks/workspace.py", "--tiny", "--only", *some, "--write", str(copy)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    before, after = numbers_of(), numbers_of(copy)
    assert set(after) == set(before) == {*topics.TOPICS, "machine"}
    assert {topic for topic in after if after[topic] != before[topic]} == {*some, "machine"}
    assert [heads(text) for text in after.values()] == [heads(text) for text in before.values()]
    around = [re.sub(r"begin -->.*?<!--", "", path.read_text(encoding="utf-8"), flags=re.DOTALL) for path in (PAGE, copy)]
    assert around[0] == around[1]
    assert [row[0] for row in rows(after["opensees"])] == [f"`{robot}`" for robot in topics.TINY.robots]
    assert "command: `python benchmarks/workspace.py --tiny --only opensees" in after["machine"]
    assert not re.search(r"\b(nan|inf)\b", "".join(after.values()))


def test_a_page_without_markers_is_not_overwritten(tmp_path):
    path = tmp_path / "page.md"
    path.write_text("nothing to see\n", encoding="utf-8")
    with pytest.raises(SystemExit, match="has no markers"):
        page.write(path, {"sizes": "new"})
    assert path.read_text(encoding="utf-8") == "nothing to see\n"


# ---- measured grids ------------------------------------------------------------------------------------------------------------


@pytest.mark.few(4)
@pytest.mark.parametrize("name", grids.WORKSPACES)
def test_grids_are_within_the_workspaces(name):
    workspace = grids.WORKSPACES[name]
    axes = workspace.axes(3 ** len(workspace.box) if len(workspace.box) < 6 else 64)
    result = grids.whole(package_robots.robot(name), workspace, grids.mesh(axes))
    assert np.all(result.status == ks.Status.OK)
