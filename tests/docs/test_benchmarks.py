"""The benchmark of workspace maps runs, measures what it says, and its page has the tables that it writes."""

import json
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
from kinetostatics.files.bundled import shipped_robots

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
    """What stands between the markers of each topic."""
    return dict(re.findall(r"<!-- (\w+): begin -->\n(.*?)<!-- \1: end -->", path.read_text(encoding="utf-8"), re.DOTALL))


def heads(text):
    """Heads of tables with the numbers of their columns; how many poses were measured is another matter."""
    lines = text.splitlines()
    return [re.sub(r"[\d,]+ poses", "poses", above) for above, below in pairwise(lines) if below.startswith("|---")]


def rows(text):
    """The cells of the first table of a topic, its head left out."""
    lines = [line for line in text.splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[2:]]


# ---- the page ----------------------------------------------------------------------------------------------------------------


def test_the_page_has_every_robot_and_its_ratios_are_those_of_its_times():
    found = rows(numbers_of()["opensees"])
    assert [row[0].strip("`") for row in found] == list(grids.WORKSPACES)
    for row in found:
        assert int(row[1].replace(",", "")) >= 20_000
        ours, theirs = float(row[2]), [float(cell.replace(",", "")) for cell in row[5:8]]
        for ratio, time in zip(row[8:11], theirs, strict=True):
            assert float(ratio.replace(",", "")) == pytest.approx(time / ours, rel=0.06)  # of rounded numbers
        assert float(row[12]) < 1e-3


def test_what_the_page_says_of_requirements_follows_from_its_numbers():
    page_numbers = numbers_of()
    wanted = rows(page_numbers["requirements"])
    assert {row[3] for row in wanted} <= {"yes", "**no**"}
    by_robot = {row[0].strip("`"): row for row in rows(page_numbers["opensees"])}
    for name, least in topics.WANTED.items():
        (row,) = [row for row in wanted if row[0].startswith(f"`{name}`") and row[0].endswith(topics.WAYS[0][1])]
        assert row[1:3] == [f"≥ {least}", by_robot[name][8]]
        assert (row[3] == "yes") == (float(row[2]) >= least)


@pytest.mark.slow
def test_a_small_run_writes_the_tables_of_the_page_between_its_markers(tmp_path):
    pytest.importorskip("openseespy")
    some = ["opensees", "pinocchio", "sizes"]
    copy = tmp_path / "benchmarks.md"
    copy.write_text(PAGE.read_text(encoding="utf-8"), encoding="utf-8")
    command = [sys.executable, "benchmarks/workspace.py", "--tiny", "--only", *some, "--write", str(copy)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    if "cannot open shared object" in done.stderr:
        pytest.skip("OpenSeesPy cannot be loaded here")
    assert done.returncode == 0, done.stderr
    before, after = numbers_of(), numbers_of(copy)
    assert set(after) == set(before) == {*topics.TOPICS, "machine", "requirements"}
    assert {topic for topic in after if after[topic] != before[topic]} == {*some, "machine", "requirements"}
    assert [heads(text) for text in after.values()] == [heads(text) for text in before.values()]
    around = [re.sub(r"begin -->.*?<!--", "", path.read_text(encoding="utf-8"), flags=re.DOTALL) for path in (PAGE, copy)]
    assert around[0] == around[1]
    assert [row[0] for row in rows(after["opensees"])] == [f"`{robot}`" for robot in topics.TINY.robots]
    assert "command: `python benchmarks/workspace.py --tiny --only opensees" in after["machine"]
    assert not re.search(r"\b(nan|inf)\b", "".join(after.values()))


#: Scripts, and the tables that they write into pages: pages below docs/how_to, and the topics.
SCRIPTS = [
    ("engines", "compiled", "engines"),
    ("functions", "functions", "calls"),
    ("live", "viewer", "live"),
    ("controllers", "controller", "controllers"),
]


@pytest.mark.parametrize(("script", "place", "topic"), SCRIPTS)
def test_tables_say_which_command_has_made_them_from_which_source_and_when(script, place, topic):
    *_, said, end = numbers_of(ROOT / "docs" / "how_to" / f"{place}.md")[topic].splitlines()
    assert re.fullmatch(
        rf"`python benchmarks/{script}\.py --write docs/how_to/{place}\.md`, .+, commit \w+, 20\d\d-\d\d-\d\d\.", said
    )
    assert end == ""


@pytest.mark.slow
@pytest.mark.parametrize(("script", "place", "topic"), SCRIPTS)
def test_tables_of_single_robots_are_written_into_their_pages(script, place, topic, tmp_path):
    whole, copy = ROOT / "docs" / "how_to" / f"{place}.md", tmp_path / "page.md"
    copy.write_text(whole.read_text(encoding="utf-8"), encoding="utf-8")
    command = [sys.executable, f"benchmarks/{script}.py", "five_bar", "--write", str(copy)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    (before, after) = (numbers_of(path)[topic] for path in (whole, copy))
    assert heads(after) == heads(before) and [row[0] for row in rows(after)] == ["`five_bar`"]
    assert not re.search(r"\b(nan|inf)\b", after)


def test_a_page_without_markers_is_not_overwritten(tmp_path):
    path = tmp_path / "page.md"
    path.write_text("nothing to see\n", encoding="utf-8")
    with pytest.raises(SystemExit, match="has no markers"):
        page.write(path, {"sizes": "new"})
    assert path.read_text(encoding="utf-8") == "nothing to see\n"


# ---- what is measured ----------------------------------------------------------------------------------------------------------


def test_every_robot_has_a_grid():
    assert sorted(grids.WORKSPACES) == sorted(shipped_robots())


def test_grids_have_at_least_as_many_poses_as_are_asked_for():
    for workspace in grids.WORKSPACES.values():
        for poses in (5_000, 20_000, 1_000_000):
            size = np.prod([len(values) for values in workspace.axes(poses).values()])
            assert poses <= size < 1.6 * poses
        assert all((v[0], v[-1]) == workspace.box[name] for name, v in workspace.axes(300).items())


@pytest.mark.few(4)
@pytest.mark.parametrize("name", grids.WORKSPACES)
def test_grids_are_within_the_workspaces(name):
    workspace = grids.WORKSPACES[name]
    axes = workspace.axes(3 ** len(workspace.box) if len(workspace.box) < 6 else 64)
    result = grids.whole(package_robots.robot(name), workspace, grids.mesh(axes))
    assert np.all(result.status == ks.Status.OK)


@pytest.mark.few(1)
@pytest.mark.parametrize("name", grids.EDGES)
def test_about_one_pose_in_a_hundred_is_out_of_reach(name):
    robot, workspace, edge = package_robots.robot(name), grids.WORKSPACES[name], grids.EDGES[name]

    def missing(coordinates):
        return np.mean(grids.assemble(robot, workspace, coordinates).status == ks.Status.UNREACHABLE)

    near, beyond = workspace.within(**edge.inside), workspace.within(**edge.outside)
    assert missing(grids.mesh(near.axes(500))) == 0
    assert 0.004 < missing(grids.mesh(beyond.axes(3_000))) < 0.03
    middle = {key: np.array([(low + high) / 2]) for key, (low, high) in workspace.box.items()}
    assert missing({**middle, **{key: np.array([value]) for key, value in edge.far.items()}}) == 1


#: In a process of its own: OpenSees keeps one model a process, and prints when Python exits.
SOLVE = """
import json, sys, grids, opensees_frames
name = sys.argv[1]
workspace = grids.WORKSPACES[name]
at = {key: low + 0.7 * (high - low) for key, (low, high) in workspace.box.items()}
frame = opensees_frames.frame_of(grids.assemble(grids.load(name), workspace, at), grids.LOAD)
try:
    solver = opensees_frames.OpenSees()
except (ImportError, RuntimeError, OSError) as error:
    print(json.dumps({"missing": str(error)}))
else:
    twist, compliance, weights, forces = solver.solve_all(frame)
    found = {"twist": twist, "compliance": compliance, "weights": weights, "forces": forces, "alone": solver.solve(frame)[0]}
    print(json.dumps({**found, "at": at, "elements": len(frame.joints) + len(frame.beams)}))
"""


def solved(name):
    """What OpenSees says of one pose."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT / "benchmarks"), *filter(None, sys.path)])}
    done = subprocess.run([sys.executable, "-c", SOLVE, name], env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout.splitlines()[-1])
    if "missing" in found:
        assert not os.environ.get("KINETOSTATICS_REQUIRE_OPENSEES"), found["missing"]
        pytest.skip(found["missing"])
    return found


@pytest.mark.few(1)
@pytest.mark.parametrize("name", ["3rps", "tripteron", "delta"])
def test_opensees_solves_the_same_poses(name):
    """Hinges that cross in a point, elastic actuators, struts that spin: the lean frame gives all numbers of ours."""
    found = solved(name)
    pose = grids.assemble(package_robots.robot(name), grids.WORKSPACES[name], found["at"])
    ours = ks.analyze(pose, grids.LOAD)
    assert found["alone"] == pytest.approx(found["twist"], rel=1e-9)
    assert len(found["forces"]) == found["elements"] and np.all(np.isfinite(np.concatenate(found["forces"])))
    size = np.abs(ours.twist).max()
    np.testing.assert_allclose(found["twist"], ours.twist, rtol=0, atol=1e-4 * size)
    np.testing.assert_allclose(
        np.array(found["compliance"]).T, ours.compliance, rtol=0, atol=1e-4 * np.abs(ours.compliance).max()
    )
    limbs = [ours.contributions[limb] for limb in ours.limbs]
    assert len(found["weights"]) == len(limbs) - 1
    for weight in found["weights"]:  # in an order of their own
        nearest = min(limbs, key=lambda limb: np.abs(limb - weight).max())
        np.testing.assert_allclose(weight, nearest, rtol=0, atol=1e-4 * size)
