"""``repr`` and HTML of robots, poses, results and their parts, for REPL and notebook: short, escaped and correct."""

import copy
import html
import pickle
import re
from collections.abc import Mapping
from html.parser import HTMLParser

import numpy as np
import package_robots
import pytest

import kinetostatics as ks
from kinetostatics.description import Beam, Link, Material, Origin, RobotDescription
from kinetostatics.files.reader import parse_robot_text
from kinetostatics.layout.blocks import Table
from kinetostatics.layout.mapping import FEW, MOST_ITEMS, ResultMapping, abbreviated
from kinetostatics.layout.renderings import block_html
from kinetostatics.sections import Tube
from kinetostatics.status import Status

#: The longest text that anything may print in a REPL.
SHORT = 2500
ROBOTS = ("robots/3rps.urdf.xacro", "robots/anymal_standing.urdf.xacro", "tests/cases/par4_articulated.urdf.xacro")
OBJECTS = ("Robot", "Configuration", "Result", "LimbResult", "BeamResult", "RobotDescription")


@pytest.fixture(autouse=True)
def in_root(monkeypatch, request):
    monkeypatch.chdir(request.config.rootpath)


@pytest.fixture(scope="module", params=ROBOTS)
def robot(request):
    return ks.load_robot(request.config.rootpath / request.param)


def poses(robot):
    """One pose, a batch with poses out of reach, one out of reach alone, and an empty batch."""
    first, *others = robot.description.actuated
    rest = dict.fromkeys(others, 0.0)
    for value in (0.0, np.array([[0.0, 0.01], [0.02, 50.0]]), 50.0, np.zeros(0)):
        yield robot.assemble(actuators={first: value, **rest}, on_failure="nan")


class Cells(HTMLParser):
    """Reader of the cells of tables and of all tags and attributes; rejects attributes that are not allowed."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.rows, self.attributes, self.open = [], [], set(), []
        self.feed(text)
        self.close()
        assert not self.open, self.open

    def handle_starttag(self, tag, attributes):
        self.tags.append(tag)
        if tag != "br":
            self.open.append(tag)
        self.attributes |= {name for name, _ in attributes}
        for name, value in attributes:
            plain = name == "style" and not re.search(r"color|background|url", value)
            assert plain or (name, value) == ("class", "warning")
        if tag == "tr":
            self.rows.append([])
        if tag in ("td", "th"):
            self.rows[-1].append("")

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] in ("td", "th"):
            self.rows[-1][-1] += data


def public(item):
    """Yield name and value of the public attributes of an object that are no methods, and not Pinocchio's."""
    for name in dir(type(item)) + list(vars(item)) if hasattr(item, "__dict__") else dir(item):
        if name not in ("model", "data") and not name.startswith("_") and not callable(getattr(type(item), name, None)):
            yield name, getattr(item, name)


@pytest.mark.few(1)
def test_reprs_of_all_public_attributes_are_short(robot):
    found = [("robot", robot), *public(robot), ("description", robot.description), *public(robot.description)]
    for pose in poses(robot):
        found += [("pose", pose), *public(pose)]
        if pose.robot is robot and pose.reached.size:
            result = ks.analyze(pose, load=[0, 0, -100, 0, 0, 0], on_failure="nan")
            found += [("result", result), *public(result)]
            for parts in (result.limbs, result.beams):
                for part in list(parts.values())[:2]:
                    found += [(part.name, part), *public(part)]
    for name, item in found:
        if name in ("urdf", "extra", "file_warnings"):  # texts of files
            continue
        for one in item if isinstance(item, tuple) else [item]:
            if not isinstance(one, np.ndarray):  # NumPy's own
                assert len(repr(one)) <= SHORT, (name, len(repr(one)), repr(one)[:300])
        if hasattr(item, "_repr_html_"):
            Cells(item._repr_html_())
        if isinstance(item, Mapping) and not isinstance(item, dict):
            assert repr(item).count("\n") <= MOST_ITEMS
    names = {type(item).__name__ for _, item in found}
    assert set(OBJECTS) <= names


def test_reprs_have_status_shape_and_main_numbers():
    robot = package_robots.robot("3rps")
    assert repr(robot) == "<Robot '3rps': 3 limbs, 3 actuators, 3 beams>"
    one, many, lost, none = (ks.analyze(pose, on_failure="nan") for pose in poses(robot))
    z = 1e3 * float(one.configuration.platform["z"])
    assert repr(one.configuration) == f"<Configuration of '3rps': OK; x 0 mm, y 0 mm, z {z:.1f} mm, rx 0°, ry 0°, rz 0°>"
    sag = f"{1e9 * float(np.linalg.norm(one.twist[:3])):.2f} nm"
    assert repr(one) == f"<Analysis of '3rps': OK; o moves by {sag}, the platform turns by 0 µrad>"
    assert str(many.configuration) == repr(many.configuration)
    shown = "4 poses, batch shape (2, 2): 3 OK, 1 UNREACHABLE"
    assert repr(many.configuration).startswith(f"<Configuration of '3rps': {shown}; x ")
    shifts = np.linalg.norm(many.twist[..., :3], axis=-1)
    low, high = (f"{1e9 * pick(shifts):.2f}" for pick in (np.nanmin, np.nanmax))
    assert repr(many).startswith(f"<Analysis of '3rps': {shown}; o moves by {low} to {high} nm, the platform turns by 0 to ")
    assert repr(lost) == "<Analysis of '3rps': UNREACHABLE>"
    assert repr(lost.configuration).startswith("<Configuration of '3rps': UNREACHABLE; x –, y –, z –, rx –")
    assert repr(none) == "<Analysis of '3rps': 0 poses, batch shape (0,)>"
    limb, beam = one.limbs["limb_2"], one.beams["rod_2"]
    for label, value in zip(limb.labels, limb.intensities, strict=True):
        shown = "0 N" if abs(value) < 1e-6 else f"{value:.2f} N"
        assert f"{label} {shown}" in repr(limb)
    lowest, highest = beam.section_wrenches[:, 0].min(), beam.section_wrenches[:, 0].max()
    assert f"length {1e3 * float(beam.length):.1f} mm, axial force {lowest:.1f} to {highest:.1f} N, stress" in repr(beam)
    assert "–" in repr(lost.limbs["limb_1"]) and "–" in repr(lost.beams["rod_1"])
    description = robot.description
    counts = f"{len(description.links)} links, {len(description.joints)} joints, 3 loops, 3 beams, 3 actuators"
    assert repr(description) == f"<RobotDescription '3rps' from '3rps.urdf.xacro': {counts}>"


def test_repr_names_all_status_flags():
    """An actuator beyond its limit in a robot whose limbs are rigid has two flags, in a pose and in a batch."""
    robot = package_robots.robot("2pru_upr")
    for name in robot.description.beams:
        robot = ks.Robot(robot.description.without_beam(name))
    drives = dict.fromkeys(robot.description.actuated, 0.0)
    one = ks.analyze(robot.assemble(actuators=drives))
    assert Status(int(one.status)) == Status.INDETERMINATE
    assert repr(one).startswith("<Analysis of '2pru_upr': INDETERMINATE; o moves by 0 ")
    joints = dict(robot.description.joints)
    first = next(iter(drives))
    tight = ks.Robot(robot.description.changed(first, lower=0.001, upper=0.5)) if first in joints else None
    assert tight is not None
    both = ks.analyze(tight.assemble(actuators=drives))
    assert repr(both).startswith("<Analysis of '2pru_upr': INDETERMINATE, LIMIT_EXCEEDED; o moves")
    item = both.configuration.limits_exceeded[first]
    assert repr(item) == f"<LimitExceeded {first!r}: 0 beyond [0.001, 0.5]>"
    batch = ks.analyze(tight.assemble(actuators={**drives, first: np.array([0.0, 0.002])}))
    assert "2 poses, batch shape (2,): 1 LIMIT_EXCEEDED, 2 INDETERMINATE" in repr(batch)
    assert repr(batch.configuration.limits_exceeded[first]) == f"<LimitExceeded {first!r}: 1 of 2 poses beyond [0.001, 0.5]>"


def test_shipped_robots_and_extremes_are_html_tables():
    rows = Cells(ks.robots()._repr_html_()).rows
    assert rows[0] == ["name", "robot"] and dict(rows[1:]) == dict(ks.robots())
    assert ks.robots()._repr_html_().count("text-align: right") == 0, "sentences begin on the left"
    from kinetostatics import indices

    worst = indices.Extreme("linear_sag", 2.5e-6, "m", {"z": 0.5}, {"z": 0}, Status.OK, {"z": "m"}, ())
    assert Cells(worst._repr_html_()).rows == [["linear_sag", "2.5e-06 m"], ["z", "0.5 m"]]
    assert str(worst) == "linear_sag = 2.5e-06 m at z = 0.5 m"


def test_verification_is_a_table_of_differences():
    found = ks.verify(package_robots.robot("3rps").assemble())
    rows = Cells(found.report().only("differences")._repr_html_()).rows[1:]
    assert [row[0] for row in rows] == ["twist of the platform", "compliance", "stiffness", *(row[0] for row in rows[3:])]
    assert all(row[3] == "ok" and float(row[1]) < 1e-6 for row in rows)
    assert found.verdict.partition(":")[2] in html.unescape(found._repr_html_())
    twist = Cells(found.report().only("twist")._repr_html_()).rows[1:]
    assert [row[3] for row in twist if row[1] == row[2] == "0"] == ["0"] * 5  # rounding errors have no digits


def test_html_is_escaped():
    text = block_html(Table.of_rows(("<i>", ""), [("<script>alert(1)</script>", '"&"')]))
    assert "<i>" not in text and "<script>" not in text
    assert Cells(text).rows == [["<i>", ""], ["<script>alert(1)</script>", '"&"']]
    named = RobotDescription.of("<a>", links=[Link("<l>")], joints=[], platform="<l>")
    assert "<l>" not in named._repr_html_() and "<a>" not in named._repr_html_()
    assert "<x>" not in ResultMapping({"<x>": "<y>"})._repr_html_() and "<y>" not in ResultMapping({"<x>": "<y>"})._repr_html_()


def test_result_mapping_is_immutable():
    source = {"a": 1, "b": 2}
    named = ResultMapping(source)
    source["c"] = 3
    assert isinstance(named, Mapping) and dict(named) == {"a": 1, "b": 2} == named.copy() and named == {"a": 1, "b": 2}
    assert "a" in named and "c" not in named and len(named) == 2 and list(reversed(named)) == ["b", "a"]
    assert named | {"b": 5} == {"a": 1, "b": 5} and {"b": 5} | named == {"b": 2, "a": 1} and {**named} == dict(named)
    with pytest.raises(TypeError):
        named["a"] = 2
    with pytest.raises(TypeError):
        del named["a"]
    for copied in (copy.deepcopy(named), pickle.loads(pickle.dumps(named)), copy.copy(named)):
        assert copied == named and type(copied) is ResultMapping
    with pytest.raises(TypeError):
        named | 3


def test_abbreviated_values_of_arrays_mappings_and_texts():
    assert abbreviated(np.array(2.5)) == "2.5" and abbreviated(np.array([1.0, 1e-14, -2.0])) == "[1, 0, -2]"
    assert abbreviated(np.array([1.0, 1e-11])) == "[1, 1e-11]"
    assert abbreviated(np.arange(FEW + 1.0)) == f"array ({FEW + 1},), 0 to {FEW}" and abbreviated(np.arange(float(FEW)))[0] == "["
    assert abbreviated(np.full((2, 3), np.nan)) == "array (2, 3), no finite number" and abbreviated(np.array(np.nan)) == "nan"
    assert abbreviated(np.array([[np.nan, 3.0], [1.0, np.inf]])) == "array (2, 2), 1 to 3"
    assert abbreviated(np.zeros((0, 6))) == "array (0, 6)" and abbreviated(np.array([True, False])) == "[1, 0]"
    assert (
        abbreviated({"a": 1, "b": 2}) == "2 items: a, b"
        and abbreviated({}) == "no items"
        and abbreviated((1, np.array(2.0))) == "(1, 2)"
    )
    assert len(abbreviated("x" * 1000)) == 150
    assert repr(ResultMapping({"a": 1})) == "{'a': 1}" and repr(ResultMapping()) == "{}"
    many = repr(ResultMapping({f"name_{k}": np.zeros((9, 9)) for k in range(20)}))
    assert many.count("\n") == MOST_ITEMS and many.endswith("… 8 more}")


def test_repr_of_description_parts_omits_defaults():
    assert repr(Link("a", mass=2.0)) == "Link(name='a', mass=2.0, has_inertial=True)"
    assert repr(Origin()) == "Origin()" and repr(Origin(rpy=(0.0, 0.0, 1.0))) == "Origin(rpy=(0.0, 0.0, 1.0))"
    beam = Beam("rod", Tube.of(0.02), Material(2e11, 0.3))
    assert repr(beam).startswith("Beam(link='rod', section=Tube(") and "material=Material(youngs_modulus=2" in repr(beam)
    assert eval(repr(beam.material)) == beam.material and "place" not in repr(beam)
    assert "extra" not in repr(Link("a", extra="<visual/>"))


def test_modes_that_are_all_local_to_rods_name_the_first_one_of_the_platform():
    """A platform on a thick column, beside an antenna that vibrates alone on the base."""
    material = 'youngs_modulus="70e9" poisson_ratio="0.3" density="2700"'

    def robot(antenna):
        parts = """<link name="base"/><link name="column"/><link name="head"><inertial><mass value="1"/></inertial></link>
        <joint name="foot" type="fixed"><parent link="base"/><child link="column"/></joint>
        <joint name="neck" type="fixed"><parent link="column"/><child link="head"/><origin xyz="0 0 0.2"/></joint>"""
        if antenna:
            parts += """<link name="antenna"/><link name="tip"/>
            <joint name="root" type="fixed"><parent link="base"/><child link="antenna"/><origin xyz="0.3 0 0"/></joint>
            <joint name="top" type="fixed"><parent link="antenna"/><child link="tip"/><origin xyz="0 0 1"/></joint>"""
            parts += f'<beam link="antenna" from="root" to="top" {material}><circle diameter="0.005"/></beam>'
        parts += f'<beam link="column" from="foot" to="neck" {material}><circle diameter="0.05"/></beam>'
        return ks.Robot(parse_robot_text(f'<robot name="mast">{parts}<platform link="head"/></robot>')).assemble()

    first = float(ks.modes(robot(False), 1).frequencies[0])
    assert "local to rods" not in str(ks.modes(robot(False), 3))
    found = ks.modes(robot(True), 4)
    number = int(found.count_below(0.999 * first)) + 1
    assert 5 < number < 30
    expected = (
        f"All modes here are local to rods, and hardly move the platform; its first mode is mode {number}, at {first:.1f} Hz."
    )
    assert expected in " ".join(str(found).split())
    assert "local to rods" not in str(ks.modes(robot(True), number))
