"""docs/gallery/robots.md says of every robot that comes with the package what the robot itself says."""

import re

import pytest
from places import ROOT

import kinetostatics as ks
from kinetostatics.files.bundled import shipped_robots

PAGE = (ROOT / "docs" / "gallery" / "robots.md").read_text(encoding="utf-8")
ROBOTS = sorted(shipped_robots())


def cells(line: str) -> list[str]:
    """Return what stands in the cells of a row of a table."""
    return [cell.strip() for cell in line.strip().strip("|").split("|")]


def section(name: str) -> str:
    """Return the section of a robot."""
    parts = re.split(r"^## ", PAGE, flags=re.MULTILINE)
    (found,) = [part for part in parts if part.partition("\n")[0].endswith(f"`{name}.urdf.xacro`")]
    return found


def row(name: str, what: str) -> str:
    """Return the second cell of the one row of a robot's section that begins with ``what``."""
    (found,) = [cells(line) for line in section(name).splitlines() if line.startswith(f"| {what}")]
    return found[1]


@pytest.fixture(scope="module", params=ROBOTS)
def robot(request):
    """Each robot in turn."""
    return request.param, ks.load_robot(shipped_robots()[request.param])


def test_the_table_lists_every_robot_once_in_the_order_of_the_sections():
    listed = re.findall(r"^\| [^|]+ \| \[`(\w+)`\]\(\.\./\.\./robots/(\w+)\.urdf\.xacro\) \|", PAGE, flags=re.MULTILINE)
    assert [name for name, _ in listed] == [file for _, file in listed]
    assert sorted(name for name, _ in listed) == ROBOTS
    assert re.findall(r"^## .*`(\w+)\.urdf\.xacro`$", PAGE, flags=re.MULTILINE) == [name for name, _ in listed]


def test_mobility_redundant_constraints_and_local_freedoms_are_the_robots(robot):
    name, loaded = robot
    (line,) = [cells(line) for line in PAGE.splitlines() if f"[`{name}`](" in line]
    mobility = loaded.mobility
    assert [int(cell) for cell in line[3:6]] == [mobility.platform, mobility.redundant_constraints, mobility.local]


def test_the_sections_agree_with_the_table(robot):
    name, loaded = robot
    mobility = loaded.mobility
    said = re.findall(r"\d+", row(name, "mobility"))
    assert [int(number) for number in said] == [mobility.platform] + [mobility.local] * (mobility.local > 0)
    assert int(re.match(r"\d+", row(name, "redundant constraints"))[0]) == mobility.redundant_constraints


def test_masses_are_the_robots(robot):
    name, loaded = robot
    value, unit = re.match(r"([\d.]+) (kg)", row(name, "all that moves")).groups()
    digits = len(value.partition(".")[2])
    total = float(loaded.weights.masses(loaded.zero_frames).sum())
    assert unit == "kg" and round(total, digits) == float(value)


def test_the_lists_of_parameters_are_those_of_the_files(robot):
    name, _ = robot
    text = shipped_robots()[name].read_text(encoding="utf-8")
    paragraph = section(name).partition("**Parameters.**")[2].partition("\n\n")[0]
    listed = re.findall(r"`(\w+)`", re.sub(r"\([^)]*\)", "", paragraph))
    assert sorted(listed) == sorted(re.findall(r'<xacro:arg name="(\w+)"', text))
