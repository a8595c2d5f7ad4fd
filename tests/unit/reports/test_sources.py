"""Sources of the sag: every report ranks the elastic parts, also where only beams are elastic."""

import re
from types import SimpleNamespace

import numpy as np
import package_robots
import pytest

import kinetostatics as ks
from kinetostatics.layout.numbers import NoiseFloor
from kinetostatics.layout.renderings import block_lines
from kinetostatics.reports.sources import ALIKE, MOST, ranked, source_table
from kinetostatics.sections import Tube

TITLE = "Sources of the sag: parts along the total displacement and rotation"


@pytest.fixture(autouse=True)
def in_root(monkeypatch, request):
    monkeypatch.chdir(request.config.rootpath)


def ranking(result):
    """The rows of the report's table: name, kind, numbers."""
    report = str(result.report())
    assert report.count(TITLE) == 1
    lines = report[report.index(TITLE) :].split("\n\n")[0].splitlines()[1:]
    assert lines[0].split() == "what moves o [nm] turns [µrad] part [%]".split() or "moves o [" in lines[0]
    return [re.split(r" {2,}", line.strip()) for line in lines[1:]], lines[0]


def test_beams_are_ranked_by_their_share_of_the_sag():
    """The thinnest of three rods deforms most; equal ones stand in the file's order; the parts add up."""
    description = ks.files.read_robot_file("robots/3rps.urdf.xacro")
    equal = ks.analyze(ks.Robot(description).assemble(), load=[0, 0, -500, 0, 0, 0])
    rows, _ = ranking(equal)
    assert [row[0] for row in rows] == ["rod_1", "rod_2", "rod_3", "total"]
    assert [row[-1] for row in rows] == ["33.3", "33.3", "33.3", "100.0"]
    thin = ks.Robot(description.changed("rod_2", section=Tube.of(0.05)).changed("rod_3", section=Tube.of(0.07)))
    result = ks.analyze(thin.assemble(), load=[0, 0, -500, 0, 0, 0])
    rows, header = ranking(result)
    assert [row[0] for row in rows] == ["rod_2", "rod_3", "rod_1", "total"] and [row[1] for row in rows[:3]] == ["beam"] * 3
    unit = {"µm": 1e-6, "nm": 1e-9}[re.search(r"moves o \[(.*?)\]", header)[1]]
    whole = result.twist[:3]
    for name, _, shift, _, part in rows[:3]:
        expected = result.source_contributions["beams"][name][:3] @ whole / np.linalg.norm(whole)
        assert float(shift) * unit == pytest.approx(expected, rel=2e-3)  # of three digits
        assert float(part) == pytest.approx(100 * expected / np.linalg.norm(whole), abs=0.06)
    assert float(rows[3][1]) * unit == pytest.approx(np.linalg.norm(whole), rel=1e-4)


def test_elastic_actuators_are_ranked_among_beams():
    description = ks.files.read_robot_file("robots/3rps.urdf.xacro")
    stiff = ks.description.JointStiffness("prismatic_2", drive=1e6)
    rows, _ = ranking(ks.analyze(ks.Robot(description.with_part(stiff)).assemble()))
    assert rows[0][:2] == ["prismatic_2", "actuator"] and [row[1] for row in rows[1:4]] == ["beam"] * 3
    assert sorted(row[0] for row in rows[1:4]) == ["rod_1", "rod_2", "rod_3"] and float(rows[0][-1]) > 90


def test_smallest_sources_share_one_row():
    result = ks.analyze(package_robots.robot("anymal_standing").assemble())
    rows, _ = ranking(result)
    assert len(result.source_contributions["beams"]) == 16 and len(rows) == MOST + 2
    assert rows[MOST][0] == "8 others" and sum(float(row[-1]) for row in rows[:-1]) == pytest.approx(100, abs=0.5)


def fake(beams, twist):
    """Return a stand-in for a result with the given contributions of beams and twist."""
    robot = SimpleNamespace(
        description=SimpleNamespace(elastic_links=dict.fromkeys(beams)), mechanism=SimpleNamespace(connections={})
    )
    return SimpleNamespace(robot=robot, point_name="o", twist=np.array(twist, dtype=float), source_contributions={"beams": beams})


def lines_of(result, noise):
    (table,) = source_table(result, noise)
    return block_lines(table)


def test_single_remaining_source_has_its_own_row():
    for count, rows in ((MOST + 1, MOST + 1), (MOST + 2, MOST + 1)):
        beams = {f"b{k}": np.array([count - k, 0, 0, 0, 0, 0.0]) for k in range(count)}
        lines = lines_of(fake(beams, sum(beams.values())), NoiseFloor(1e-9, 1e-9, 0, 0))
        assert len(lines) == rows + 2 and ("others" in lines[-2]) == (count > MOST + 1)


def test_sources_are_ranked_by_rotation_where_o_does_not_move():
    beams = {"a": np.array([1e-12, 0, 0, 0, 0, 1e-3]), "b": np.array([-1e-12, 0, 0, 0, 0, 3e-3])}
    lines = lines_of(fake(beams, [1e-13, 0, 0, 0, 0, 4e-3]), NoiseFloor(1e-10, 1e-9, 0, 0))
    assert [line.split()[0] for line in lines] == ["what", "b", "a", "total"]
    assert [line.split()[-1] for line in lines[1:]] == ["75.0", "25.0", "100.0"] and lines[1].split()[2] == "0"


def test_ranking_is_absent_without_motion():
    pose = package_robots.robot("3rps").assemble()
    assert TITLE not in str(ks.analyze(pose, gravity=[0, 0, 0]).report())
    assert source_table(fake({}, np.ones(6)), NoiseFloor(0, 0, 0, 0)) == []


def test_ties_keep_the_order_of_the_file():
    assert ranked(np.array([1.0, 3.0, 2.0])) == [1, 2, 0]
    noise = 1e-13 * np.array([1, 3, -2, 0])
    assert ranked(np.ones(4) + noise) == [0, 1, 2, 3] and ranked(np.array([-1.0, 2.0, 2.0, -1.0])) == [1, 2, 0, 3]
    assert ranked(np.array([1.0, 1 + 0.9 * ALIKE])) == [0, 1] and ranked(np.array([1.0, 1 + 1.2 * ALIKE])) == [1, 0]
    assert sorted(ranked(np.array([np.nan, 1.0, np.nan]))) == [0, 1, 2] and ranked(np.zeros(0)) == []
