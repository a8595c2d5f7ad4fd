"""Springs and point masses in the scene, in meshcat and on the page; loads of links and payload in the line of facts."""

import re

import numpy as np
import pytest
from browser_pages import ENDS, move, vertices
from meshcat_windows import drawn

import kinetostatics as ks
from kinetostatics.files.reader import parse_robot_text
from kinetostatics.viewer.scene import describe_scene
from kinetostatics.viewer.shapes import coil, places_along_coil

HEIGHT, ARM, LENGTH = 0.5, 0.3, 0.4
PENDULUM = f"""<robot name="pendulum"><link name="ground"/><link name="arm"/>
<link name="tip"><inertial><mass value="8"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
<joint name="hinge" type="continuous"><parent link="ground"/><child link="arm"/><axis xyz="0 1 0"/></joint>
<joint name="weld" type="fixed"><parent link="arm"/><child link="tip"/><origin xyz="{LENGTH} 0 0"/></joint>
<platform link="tip"/><transmission name="motor"><joint name="hinge"/></transmission>
<joint_stiffness joint="hinge" drive="1e4"/>
<spring name="gas" stiffness="200" free_length="0.7" preload="-5">
<predecessor link="ground"><origin xyz="0 0 {HEIGHT}"/></predecessor>
<successor link="arm"><origin xyz="{ARM} 0 0"/></successor></spring>
<counterweight name="lead" link="arm" mass="3"><origin xyz="-0.1 0 0"/></counterweight></robot>"""
ANGLES = np.array([-1.4, 0.3, 1.2])  # the spring pushes, pushes less, pulls
LOADS = {"loads": {"arm": [0, 0, -30, 0, 0, 0]}, "payload": ks.Payload(2.0, (0.05, 0, 0))}


@pytest.fixture(scope="module")
def result():
    robot = ks.Robot(parse_robot_text(PENDULUM))
    return ks.analyze(robot.assemble(actuators={"hinge": ANGLES}), [0, 5, 0, 0, 0, 0], **LOADS)


@pytest.fixture(scope="module")
def scene(result):
    return describe_scene(result)


def ends():
    ground, zero = np.tile([0.0, 0.0, HEIGHT], (3, 1)), np.zeros(3)
    return ground, np.stack([ARM * np.cos(ANGLES), zero, -ARM * np.sin(ANGLES)], axis=-1)


def mesh_at(scene, path):
    return next(mesh for mesh in scene.meshes if mesh.path == path)


def test_spring_coil_follows_its_end_points(result, scene):
    mesh, (ground, arm) = mesh_at(scene, "springs/gas"), ends()
    assert mesh.roots == ("Rest", "Deformed")
    first, last = mesh.station.min(), mesh.station.max()
    rest = np.stack(scene.stations.rest[first : last + 1], axis=1)  # frames, stations
    part = places_along_coil(10, 7)[:, None]
    np.testing.assert_allclose(rest[..., :3, 3], (1 - part) * ground[:, None] + part * arm[:, None], atol=1e-15)
    n = (arm - ground) / np.linalg.norm(arm - ground, axis=-1, keepdims=True)
    np.testing.assert_allclose(rest[..., :3, 2], np.broadcast_to(n[:, None], (*rest.shape[:2], 3)), atol=1e-15)
    np.testing.assert_allclose(
        np.swapaxes(rest, -1, -2)[..., :3, :3] @ rest[..., :3, :3], np.tile(np.eye(3), (*rest.shape[:2], 1, 1)), atol=1e-14
    )
    twist = scene.stations.all_twists[:, last].sum(axis=1)  # the arm turns about the hinge, the ground stays
    np.testing.assert_allclose(twist[:, :3], np.cross(result.twist[:, 3:], arm), atol=1e-15)
    assert np.all(scene.stations.all_twists[:, first] == 0) and np.abs(twist).max() > 1e-4
    middle = scene.stations.all_twists[:, (first + last) // 2].sum(axis=1)
    np.testing.assert_allclose(middle[:, :3], twist[:, :3] / 2, atol=1e-15)


def test_coil_has_the_given_turns_and_radii():
    surface, at = coil(0.5, 0.02, 0.002, 10, 7)
    count = len(places_along_coil(10, 7))
    rings = surface.vertices[: 6 * count].reshape(count, 6, 3)
    middles = rings.mean(axis=1)
    assert np.all(at[: 6 * count].reshape(count, 6) == np.arange(count)[:, None])
    angle = np.unwrap(np.arctan2(middles[4:-4, 1], middles[4:-4, 0]))
    assert abs(angle[-1] - angle[0]) / (2 * np.pi) == pytest.approx(10 - 6 / 7, abs=0.01)
    np.testing.assert_allclose(np.linalg.norm(middles[8:-8, :2], axis=1), 0.02, rtol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(rings - middles[:, None], axis=-1), 0.002, rtol=1e-9)


def test_spring_force_is_an_arrow_at_each_end(result, scene):
    ground, arm = ends()
    length = np.linalg.norm(arm - ground, axis=-1)
    tension = -5 + 200 * (length - 0.7)
    np.testing.assert_allclose(result.spring_forces["gas"], tension, rtol=1e-12)
    assert tension[0] < 0 and tension[-1] > 0
    arrows = {arrow.name: arrow for arrow in scene.arrows if arrow.group == "spring forces"}
    assert list(arrows) == ["gas on ground", "gas on arm"]
    toward = (arm - ground) / length[:, None]
    for (name, arrow), sign, at in zip(arrows.items(), (1, -1), (ground, arm), strict=True):
        np.testing.assert_allclose(arrow.vector.sum(axis=1), sign * tension[:, None] * toward, atol=1e-12)
        np.testing.assert_array_equal(
            arrow.vector[:, scene.stations.contribution_names.index("spring gas")], arrow.vector.sum(axis=1)
        )
        np.testing.assert_allclose(scene.stations.rest[arrow.station][:, :3, 3], at, atol=1e-15)
        assert arrow.anchor == "tail", name
    assert {arrow.name for arrow in scene.arrows if arrow.group == "external load"} == {
        "load force", "load on arm force", "payload force"
    }  # fmt: skip


def test_spring_card_shows_force_length_and_stiffness(result, scene):
    rows = {row.words: row for row in scene.cards["springs/gas"].rows}
    np.testing.assert_array_equal(rows["force, tension positive"].values, result.spring_forces["gas"])
    np.testing.assert_allclose(rows["length"].values, np.linalg.norm(ends()[1] - ends()[0], axis=-1))
    assert rows["stiffness"].values.tolist() == [200] * 3 and rows["stiffness"].scale.unit == "N/m"
    assert rows["free length"].values[0] == 0.7 and rows["force at the free length"].values[0] == -5
    assert scene.cards["springs/gas"].kind == "spring between ground and arm"


def test_counterweight_is_a_steel_ball_of_its_mass(scene):
    mesh = mesh_at(scene, "masses/lead")
    centre = np.stack([-0.1 * np.cos(ANGLES), 0 * ANGLES, 0.1 * np.sin(ANGLES)], axis=-1)
    np.testing.assert_allclose(scene.stations.rest[mesh.station][:, :3, 3], centre, atol=1e-15)
    radius = np.linalg.norm(mesh.surface.vertices, axis=1)
    np.testing.assert_allclose(4 / 3 * np.pi * radius**3 * 7850, 3.0, rtol=1e-6)
    assert scene.cards["masses/lead"].rows[0].values[0] == 3.0
    assert not any(mesh.path == "masses/tip" for mesh in scene.meshes)  # with moments of inertia it is a body, not a point mass


def test_spring_of_zero_length_is_drawn():
    """Without free length and preload its force is zero there, and has no direction."""
    text = PENDULUM.replace('free_length="0.7" preload="-5"', 'free_length="0"').replace(
        f'xyz="0 0 {HEIGHT}"', f'xyz="0 0 {ARM}"'
    )
    pose = ks.Robot(parse_robot_text(text)).assemble(actuators={"hinge": -np.pi / 2})
    scene = describe_scene(ks.analyze(pose))
    assert all(np.all(np.isfinite(rest)) for rest in scene.stations.rest)
    assert all(np.abs(arrow.vector).max() < 1e-9 for arrow in scene.arrows if arrow.group == "spring forces")


def test_meshcat_draws_springs_masses_and_force_arrows(result):
    window, node = drawn(result, pose=2, exaggeration=1.0)
    root = node.path.lower()
    found = window.vertices(f"{root}/resting/springs/gas")
    np.testing.assert_allclose(
        [found[:6].mean(axis=0), found[6 * 72 : 6 * 73].mean(axis=0)], [end[2] for end in ends()], atol=1e-6
    )
    assert f"{root}/deformed/masses/lead" in window.objects
    assert {f"{root}/forces/spring forces/gas on {link}" for link in ("ground", "arm")} <= set(window.objects)


def test_facts_list_link_loads_and_payload(result, scene):
    facts = scene.facts
    assert list(facts.on_links) == ["load on arm"]
    np.testing.assert_allclose(facts.on_links["load on arm"], [[0, 0, -30, 0, 0, 0]] * 3, atol=1e-12)
    mass, center, link = facts.payload
    assert mass.tolist() == [2, 2, 2] and center.tolist() == [[0.05, 0, 0]] * 3 and link is None


def test_page_shows_springs_masses_cards_and_facts(visit, result, tmp_path):
    file = tmp_path / "pendulum.html"
    ks.save_html(result, file)
    page = visit(file.as_uri())
    told = dict(page.evaluate("robot_page.facts()[0]"))
    assert told["load at o"] == "(0, 5, 0) N" and told["load on arm"] == "(0, 0, −30) N"
    assert told["payload"] == "2 kg at (50, 0, 0) mm in the frame of o"
    ground, arm = ends()
    for frame, length in enumerate(np.linalg.norm(arm - ground, axis=-1)):
        move(page, "path", frame)
        wire = vertices(page, "Rest/springs/gas")
        np.testing.assert_allclose(wire[:6].mean(axis=0), ground[frame], atol=1e-6)
        page.evaluate("robot_page.selectPath('springs/gas')")
        text = page.inner_text("#robot-card").replace("−", "-")
        assert float(re.search(r"length\t([\d.]+) mm", text)[1]) == pytest.approx(1000 * length, rel=1e-4)
        force = float(re.search(r"tension positive\t(\S+) N", text)[1])
        assert force == pytest.approx(result.spring_forces["gas"][frame], abs=0.01)
        assert "stiffness\t200" in text
    tail, tip = page.evaluate(ENDS, "Arrows/spring forces/gas on ground")  # in tension: a pull, towards the arm
    np.testing.assert_allclose(tail, ground[2], atol=1e-6)
    assert (np.array(tip) - tail) @ (arm[2] - ground[2]) > 0
    page.evaluate("robot_page.selectPath('masses/lead')")
    assert "mass\t3" in page.inner_text("#robot-card")
