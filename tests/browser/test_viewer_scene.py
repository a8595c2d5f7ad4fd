"""The page's scene and its files: everything that can be checked without a browser."""

import base64
import subprocess
import sys
import warnings
from dataclasses import replace

import numpy as np
import package_robots
import pytest
import simple_machines as machines
import trimesh
from browser_pages import LOAD, POSES, packed_in
from surfaces import enclosed

import kinetostatics as ks
import kinetostatics.viewer.page
from kinetostatics import sections
from kinetostatics.cli import main as cli
from kinetostatics.files.reader import parse_robot_text
from kinetostatics.viewer.cards import quantities_of
from kinetostatics.viewer.drawn_parts import find_joints
from kinetostatics.viewer.drawn_poses import MOST_POSES, ShownPoses, serpentine
from kinetostatics.viewer.packing import Packing
from kinetostatics.viewer.page import fitting_page, page_html, save_screenshot
from kinetostatics.viewer.scene import describe_scene
from kinetostatics.viewer.shapes import Surface, swept
from kinetostatics.viewer.still import Still, legend
from kinetostatics.viewer.visuals import decimated, link_visuals


@pytest.fixture(scope="module", params=["2pru_upr", pytest.param("3rps", marks=pytest.mark.slow)])
def result(request):
    robot = ks.load_robot(request.param)
    return ks.analyze(robot.assemble(platform=POSES[request.param]), load=LOAD)


@pytest.fixture(scope="module")
def scene(result):
    return describe_scene(result)


@pytest.fixture(autouse=True)
def in_root(monkeypatch, request):
    monkeypatch.chdir(request.config.rootpath)


def parts_of(scene, group):
    """Each arrow's parts (K + 1, 3) of a group's forces and couples, by name and kind."""
    return {(arrow.name, arrow.kind): arrow.vector[0] for arrow in scene.arrows if arrow.group == group}


# ---- motions -------------------------------------------------------------------------------------------------------


def test_platform_and_beam_stations_have_the_twists_of_the_result(result, scene):
    assert scene.stations.contribution_names == tuple(result.contributions)
    twists = np.stack(list(result.contributions.values()))
    np.testing.assert_array_equal(scene.stations.twists[scene.readout][0], twists)
    for name, beam in result.beams.items():
        mesh = next(mesh for mesh in scene.meshes if mesh.path == f"beams/{name}" and "Deformed" in mesh.roots)
        for n in (0, 10, 20):
            station = mesh.station.min() + n
            np.testing.assert_allclose(scene.stations.rest[station][0, :3, 3], beam.points[n])
            for k, source in enumerate(result.contributions):
                part = result.beam_contributions[name][source][n]
                np.testing.assert_array_equal(scene.stations.twists[station][0, k], part)


def test_joints_stay_connected(result):
    """Both sides of every joint that does not slide move alike at its centre."""
    poses = ShownPoses(result)
    connections = result.robot.mechanism.connections
    checked = 0
    for joint in find_joints(poses):
        if joint.beam is not None or any(connections[name].type.name == "prismatic" for name in joint.joints):
            continue
        for name in joint.joints:
            for link in (connections[name].predecessor, connections[name].successor):
                twist = poses.twist_at(link, joint.centre)
                np.testing.assert_allclose(twist[..., :3], joint.twist[..., :3], atol=1e-13)
                checked += 1
    assert checked >= 12


def test_three_revolutes_of_a_spherical_joint_are_one_ball():
    robot = package_robots.robot("gough_stewart")
    joints = {joint.name: joint for joint in find_joints(ShownPoses(ks.analyze(robot.assemble())))}
    assert joints["spherical_1"].joints == ("spherical_1_x", "spherical_1_y", "spherical_1_z")
    assert joints["spherical_1"].axis is None and joints["spherical_2"].axis is None
    assert joints["prismatic_1"].axis is not None


def test_default_exaggeration_moves_by_a_tenth_of_the_robot(scene):
    total = scene.stations.all_twists.sum(axis=2)
    motion = np.linalg.norm(total[..., :3], axis=-1).max() * scene.exaggeration
    turn = np.linalg.norm(total[..., 3:], axis=-1).max() * scene.exaggeration
    assert motion <= 0.1 * scene.size and turn <= 0.3
    assert motion > 0.05 * scene.size or turn > 0.15
    unloaded = package_robots.robot("3rps")
    still = describe_scene(ks.analyze(unloaded.assemble(), gravity=[0, 0, 0]))
    assert still.exaggeration == 1 and page_html(still.plain())
    assert "rigid: nothing deforms" in legend(Still(still), 0.1)[0]


def test_stress_colours_need_sections_with_a_shape():
    described = package_robots.robot("3rps").description
    outline = describe_scene(ks.analyze(package_robots.robot("3rps").assemble()))
    assert [item.key for item in quantities_of(outline.cards.values())] == ["stress", "axial", "euler"]
    plain = sections.Section(area=1e-3, I_y=1e-7, I_z=1e-7, J=2e-7)
    beams = {name: replace(beam, section=plain) for name, beam in described.beams.items()}
    scene = describe_scene(ks.analyze(ks.Robot(replace(described, beams=beams)).assemble()))
    assert [item.key for item in quantities_of(scene.cards.values())] == ["axial", "euler"]
    assert page_html(scene.plain())


# ---- wrenches ------------------------------------------------------------------------------------------------------


def test_arrows_equal_the_wrenches_on_their_lines_of_action(result, scene):
    o, rest = result.configuration.platform_frame[:3, 3], scene.stations.rest
    places = {arrow.name: rest[arrow.station][0, :3, 3] for arrow in scene.arrows if arrow.kind == "force"}
    for limb in result.limbs.values():
        for n, label in enumerate(limb.labels):
            unit, name = limb.constraint_wrenches[:, n], f"{limb.name}: {label}"
            forces = parts_of(scene, "constraint forces").get((name, "force"), np.zeros((1, 3)))
            np.testing.assert_allclose(forces.sum(axis=0), unit[:3] * limb.intensities[n], atol=1e-9)
            if name in places:
                np.testing.assert_allclose(np.cross(places[name] - o, unit[:3]), unit[3:], atol=1e-9)
            if not np.any(unit[:3]):
                couple = parts_of(scene, "constraint couples")[name, "moment"]
                np.testing.assert_allclose(couple.sum(axis=0), unit[3:] * limb.intensities[n], atol=1e-9)
        for n, label in enumerate(limb.attached_labels):
            attached = parts_of(scene, "attached wrenches")[f"{limb.name}: {label}", "force"]
            np.testing.assert_allclose(
                attached.sum(axis=0), limb.attached_wrenches[:3, n] * limb.attached_intensities[n], atol=1e-9
            )
    actuators = {arrow.name: arrow for arrow in scene.arrows if arrow.group == "actuator forces"}
    for name, force in result.actuator_forces.items():
        arrow = actuators[name]
        assert arrow.vector[0].sum(axis=0) @ arrow.positive[0] == pytest.approx(float(force), abs=1e-9)
    ground = parts_of(scene, "base reaction")
    np.testing.assert_allclose(ground["base_wrench force", "force"].sum(axis=0), result.base_wrench[:3], atol=1e-9)
    np.testing.assert_allclose(ground["base_wrench couple", "moment"].sum(axis=0), result.base_wrench[3:], atol=1e-9)
    external = parts_of(scene, "external load")
    np.testing.assert_allclose(external["load force", "force"].sum(axis=0), LOAD[:3])
    np.testing.assert_allclose(external["load couple", "moment"].sum(axis=0), LOAD[3:])
    weights = sum(part.sum(axis=0) for part in parts_of(scene, "weights").values())
    np.testing.assert_allclose(weights + result.base_wrench[:3] + LOAD[:3], 0, atol=1e-9)


def test_forces_of_rounding_size_have_no_arrow():
    """Gravity acts across the plane of a planar robot: its motors carry nothing."""
    flat = describe_scene(ks.analyze(ks.load_robot("planar_3rrr").assemble()))
    assert not parts_of(flat, "actuator forces") and parts_of(flat, "weights")


def test_arrow_contributions_equal_separate_analyses(result, scene):
    """The contribution of the load equals an analysis without gravity, the sum of the others one without load."""
    alone = {
        "load": describe_scene(ks.analyze(result.configuration, load=LOAD, gravity=[0, 0, 0])),
        "gravity": describe_scene(ks.analyze(result.configuration)),
    }
    k = scene.stations.contribution_names.index("load")
    for arrow in scene.arrows:
        for which, other in alone.items():
            same = [item for item in other.arrows if (item.group, item.name, item.kind) == (arrow.group, arrow.name, arrow.kind)]
            expected = same[0].vector[0].sum(axis=0) if same else np.zeros(3)
            part = arrow.vector[0, k] if which == "load" else np.delete(arrow.vector[0], k, axis=0).sum(axis=0)
            np.testing.assert_allclose(part, expected, atol=1e-8, err_msg=f"{arrow.group} {arrow.name} {which}")
        assert np.abs(arrow.vector[0, -1]).max() < 1e-8, arrow.name  # no remainder that no share scales


@pytest.mark.few(1)
@pytest.mark.parametrize("name", [*POSES, "orthoglide"])
def test_limb_weights_by_mechanism_add_up_to_their_contribution(name):
    result = ks.analyze(package_robots.robot(name).assemble(platform=POSES.get(name)), load=LOAD)
    whole, split = describe_scene(result), describe_scene(result.by_mechanism)
    limbs = len(result.limbs)
    assert split.stations.contribution_names[2:] == tuple(
        f"{limb}: {way}" for way in ("attached", "deformation") for limb in result.limbs
    )

    def together(parts):
        """Return parts (…, S, …) with both mechanisms of each limb's weight added; S is the second axis from the back."""
        attached, deformation = parts[..., 2 : 2 + limbs, :], parts[..., 2 + limbs : 2 + 2 * limbs, :]
        return np.concatenate([parts[..., :2, :], attached + deformation, parts[..., 2 + 2 * limbs :, :]], axis=-2)

    twists = whole.stations.all_twists
    np.testing.assert_allclose(together(split.stations.all_twists), twists, rtol=0, atol=1e-9 * np.abs(twists).max())
    assert [arrow.name for arrow in split.arrows] == [arrow.name for arrow in whole.arrows]
    for ours, theirs in zip(split.arrows, whole.arrows, strict=True):
        np.testing.assert_allclose(together(ours.vector), theirs.vector, rtol=0, atol=1e-8, err_msg=ours.name)


# ---- paths and failures --------------------------------------------------------------------------------------------


def test_serpentine_order_steps_between_neighbours():
    order = serpentine((3, 4, 5))
    assert sorted(order) == list(range(60))
    steps = np.diff(np.array(np.unravel_index(order, (3, 4, 5))), axis=1)
    assert np.all(np.abs(steps).sum(axis=0) == 1)
    assert list(serpentine(())) == [0] and list(serpentine((3,))) == [0, 1, 2]


def test_batch_is_drawn_as_a_path_of_its_poses():
    robot = package_robots.robot("3rps")
    z = np.array([0.45, 0.5, 0.55])
    path = describe_scene(ks.analyze(robot.assemble(platform={"z": z, "rx": 0.1, "ry": 0.0}), load=LOAD))
    one = describe_scene(ks.analyze(robot.assemble(platform={"z": 0.5, "rx": 0.1, "ry": 0.0}), load=LOAD))
    for facts, expected in ((path.facts, z), (one.facts, [0.5])):
        coordinates = {name: (unit, values) for name, unit, values in facts.pose}
        assert [*coordinates] == ["x", "y", "z", "rx", "ry", "rz"]
        assert coordinates["z"][0] == "mm" and coordinates["rx"][0] == "°"
        np.testing.assert_allclose(coordinates["z"][1], np.multiply(expected, 1e3))
        np.testing.assert_allclose(coordinates["rx"][1], np.degrees(0.1))
    assert path.stations.frames == 3
    np.testing.assert_allclose(path.stations.poses[1], one.stations.poses[0], atol=1e-12)
    np.testing.assert_allclose(path.stations.all_twists[1], one.stations.all_twists[0], atol=1e-15)
    for a, b in zip(path.arrows, one.arrows, strict=True):
        np.testing.assert_allclose(a.vector[1], b.vector[0], atol=1e-9)


def test_facts_show_the_status_of_a_pose_beyond_limits():
    robot = package_robots.robot("3rps")
    lower = robot.mechanism.connections["prismatic_1"].upper
    drives = {name: np.array([0.0, lower + 0.05]) for name in robot.description.actuated}
    scene = describe_scene(ks.analyze(robot.assemble(actuators=drives)))
    assert scene.facts.status[0] == "OK" and scene.facts.status[1].startswith("LIMIT_EXCEEDED, a joint is outside its limit")


def test_long_paths_have_fewer_stations_and_fit_into_a_page():
    robot = ks.load_robot("3rps")
    angle = np.linspace(0, 2 * np.pi, 250)
    path = robot.assemble(platform={"z": 0.5, "rx": 0.15 * np.cos(angle), "ry": 0.15 * np.sin(angle)})
    result = ks.analyze(path, load=LOAD)
    scene = describe_scene(result)
    assert len(page_html(scene.plain())) < 5e6
    beam, mesh = (
        result.beams["rod_2"],
        next(mesh for mesh in scene.meshes if mesh.path == "beams/rod_2" and "Deformed" in mesh.roots),
    )
    stations = np.unique(mesh.station)
    assert len(stations) == 11
    card = scene.cards["beams/rod_2"]
    assert card.first == stations[0]
    for n, station in enumerate(stations):
        np.testing.assert_allclose(scene.stations.rest[station][:, :3, 3], beam.points[:, 2 * n])
        moved = scene.stations.twists[station].sum(axis=1)[:, :3]
        np.testing.assert_allclose(moved, beam.deflections[:, 2 * n], rtol=1e-9, atol=1e-18)
        np.testing.assert_array_equal(card.lines["M_y"][:, n], beam.section_wrenches[:, 2 * n, 4])


def test_the_longest_path_fits_into_a_page_with_all_digits(tmp_path):
    robot = package_robots.robot("2pru_upr")
    turn = np.linspace(0, 6 * np.pi, MOST_POSES)
    path = robot.assemble(platform={"z": 0.6 + 0.02 * np.sin(turn / 3), "rx": 0.1 * np.cos(turn), "ry": 0.1 * np.sin(turn)})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ks.save_html(ks.analyze(path, load=LOAD), tmp_path / "path.html")
    page = (tmp_path / "path.html").read_text(encoding="utf-8")
    assert len(page) < 5e6
    stations = packed_in(page)["stations"]
    assert stations["frames"] == MOST_POSES and stations["twist"]["step"] is None


def test_large_pages_are_rounded_then_thinned_with_a_note(monkeypatch, recwarn):
    robot = package_robots.robot("3rps")
    z = np.random.default_rng(1).uniform(0.45, 0.6, 16)
    result = ks.analyze(robot.assemble(platform={"z": z, "rx": 0.0, "ry": 0.1}), load=LOAD)

    def notes(most):
        monkeypatch.setattr(kinetostatics.viewer.page, "MOST", most)
        scene = packed_in(fitting_page(lambda every: describe_scene(result, every=every)))
        assert [str(item.message) for item in recwarn] == scene["notes"]
        recwarn.clear()
        return scene["stations"]["frames"], scene["notes"]

    monkeypatch.setattr(kinetostatics.viewer.page, "_meshcat", lambda: "")
    whole = len(page_html(describe_scene(result).plain()))
    kept = len(page_html(describe_scene(result).plain(packing=Packing(20))))
    assert kept < whole
    assert notes(whole + 1) == (16, []) and notes(kept + 1) == (16, [])
    frames, (note,) = notes(kept)
    assert frames == 16 and note.startswith("numbers are rounded to 0.001 % of the largest, to keep")
    frames, (note,) = notes(len(page_html(describe_scene(result).plain(packing=Packing(12)))))
    assert frames == 8 and "one of 2 consecutive poses is shown" in note
    frames, (note,) = notes(1000)  # less than meshcat's own script
    assert frames == 1 and note.startswith("one of 16 consecutive poses is shown, ")


def test_failed_poses_are_left_out_with_a_warning():
    robot = package_robots.robot("2pru_upr")
    result = ks.analyze(robot.assemble(platform={"z": np.array([0.6, 5.0, 0.62]), "rx": 0.0, "ry": 0.0}))
    with pytest.warns(UserWarning, match="1 of 3 poses"):
        scene = describe_scene(result)
    assert scene.stations.frames == 2 and np.all(np.isfinite(scene.stations.poses))


def test_results_without_poses_or_with_too_many_are_errors(tmp_path):
    robot = package_robots.robot("2pru_upr")
    pose = robot.assemble(platform={"z": 5.0, "rx": 0.0, "ry": 0.0}, on_failure="nan")
    with pytest.raises(ks.ArgumentError, match="UNREACHABLE"):
        ks.save_html(ks.analyze(pose, on_failure="nan"), tmp_path / "x.html")
    many = ks.analyze(robot.assemble(), load=np.zeros((1001, 6)))
    with pytest.raises(ks.ArgumentError, match="1001 poses"):
        describe_scene(many)
    empty = ks.analyze(robot.assemble(), load=np.zeros((0, 6)))
    with pytest.raises(ks.ArgumentError, match="no poses"):
        describe_scene(empty)


def test_unwritable_file_and_by_mechanism_in_meshcat_are_errors(tmp_path):
    result = ks.analyze(package_robots.robot("3rps").assemble())
    with pytest.raises(ks.KinetostaticsError, match="cannot be written"):
        ks.save_html(result, tmp_path / "missing" / "x.html")
    with pytest.raises(ks.ArgumentError, match="by_mechanism= and vary= add sliders to a page"):
        ks.show(result, by_mechanism=True, visualizer=object())


# ---- shapes and meshes ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("section", "area"),
    [
        (sections.Tube.of(0.1), np.pi * 0.05**2),
        (sections.Tube.of(0.1, 0.08), np.pi * (0.05**2 - 0.04**2)),
        (sections.Rectangle.of(0.03, 0.05), 0.03 * 0.05),
        (sections.RectangularTube.of(0.03, 0.05, 0.004), 0.03 * 0.05 - 0.022 * 0.042),
        (sections.Section(1e-3, 2e-7, 1e-7, 1e-7), np.pi * 4 * np.sqrt(1e-4 * 2e-4)),
    ],
)
def test_swept_sections_are_closed_with_the_right_volume(section, area):
    surface, at = swept(section, 5)
    vertices = surface.vertices + np.column_stack([0.1 * at, 0 * at, 0 * at])
    assert enclosed(vertices, surface.faces) == pytest.approx(area * 0.4, rel=0.015)


PARALLELOGRAM = """<robot name="parallelogram"><link name="ground"/><link name="left"/><link name="right"/>
<link name="plate">{visual}<inertial><mass value="3"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
<joint name="a" type="revolute"><parent link="ground"/><child link="left"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="1" effort="100" velocity="1"/></joint>
<joint name="b" type="continuous"><parent link="left"/><child link="plate"/><origin xyz="0 0 0.3"/><axis xyz="0 1 0"/></joint>
<joint name="d" type="continuous"><parent link="ground"/><child link="right"/><origin xyz="0.4 0 0"/><axis xyz="0 1 0"/></joint>
<platform link="plate"><origin xyz="0.2 0 0"/></platform>
<loop name="c" type="continuous"><predecessor link="right"><origin xyz="0 0 0.3"/></predecessor>
<successor link="plate"><origin xyz="0.4 0 0"/></successor><axis xyz="0 1 0"/></loop>
<beam link="left" from="a" to="b" youngs_modulus="210e9" poisson_ratio="0.3" density="7850"><circle diameter="0.02"/></beam>
<beam link="right" from="d" to="c" youngs_modulus="210e9" poisson_ratio="0.3" density="7850">
<tube outer_diameter="0.03" inner_diameter="0.02"/></beam>
<transmission name="motor"><joint name="a"/></transmission></robot>"""


def parallelogram(visual=""):
    return ks.Robot(parse_robot_text(PARALLELOGRAM.format(visual=visual), "parallelogram.urdf"))


def test_robot_without_visuals_is_drawn():
    scene = describe_scene(ks.analyze(parallelogram().assemble(), load=[50, 0, 0, 0, 0, 0]))
    drawn = {(root, mesh.path) for mesh in scene.meshes for root in mesh.roots}
    assert not any(root == "Base" for root, _ in drawn)
    assert {("Rest", "plate"), ("Deformed", "plate"), ("Rest", "beams/left"), ("Deformed", "beams/right")} <= drawn
    torque = next(arrow for arrow in scene.arrows if arrow.group == "actuator forces")
    assert torque.kind == "moment" and torque.name == "a"


def test_a_missing_or_broken_mesh_is_left_out_with_a_warning(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "broken.stl").write_text("this is no mesh")
    for file, words in (("gone.stl", "not found"), ("broken.stl", "cannot be read")):
        robot = parallelogram(f'<visual><geometry><mesh filename="{file}"/></geometry></visual>')
        with pytest.warns(UserWarning, match=words):
            scene = describe_scene(ks.analyze(robot.assemble()))
        assert scene.meshes


def test_meshes_are_read_and_scaled(tmp_path, monkeypatch):
    trimesh.creation.box([1, 2, 3]).export(tmp_path / "box.stl")
    monkeypatch.chdir(tmp_path)
    robot = parallelogram(
        '<visual><origin xyz="0.2 0 0"/><geometry><mesh filename="box.stl" scale="0.1 0.1 0.01"/></geometry></visual>'
    )
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        scene = describe_scene(ks.analyze(robot.assemble()))
    vertices = next(mesh for mesh in scene.meshes if mesh.path == "plate").surface.vertices
    np.testing.assert_allclose(np.ptp(vertices, axis=0), [0.1, 0.2, 0.03])
    np.testing.assert_allclose((vertices.max(axis=0) + vertices.min(axis=0)) / 2, [0.2, 0, 0], atol=1e-12)


def test_wrong_visual_leaves_the_visuals_out_with_a_warning():
    description = parallelogram('<visual><geometry><cylinder radius="thick" length="1"/></geometry></visual>').description
    with pytest.warns(UserWarning, match="no <visual> is drawn, since one of them cannot be read: .*thick"):
        assert link_visuals(description) == {}


def test_meshes_need_no_more_packages_of_trimesh_than_are_required(tmp_path):
    """yourdfpy, which reads the file, installs all packages of trimesh's extra ``easy``."""
    trimesh.creation.box([1, 2, 3]).export(tmp_path / "box.dae")
    shapes = ('<mesh filename="box.dae"/>', '<sphere radius="1"/>')
    visuals = "".join(f"<visual><geometry>{shape}</geometry></visual>" for shape in shapes)
    (tmp_path / "robot.urdf").write_text(PARALLELOGRAM.format(visual=visuals))
    absent = "scipy embreex vhacdx manifold3d mapbox_earcut shapely rtree httpx jsonschema charset_normalizer xxhash svg PIL"
    code = (
        f"import sys, warnings; sys.modules.update(dict.fromkeys({absent.split()}))\n"
        "warnings.simplefilter('error', UserWarning)\n"
        "import kinetostatics as ks; from kinetostatics.viewer.visuals import link_visuals\n"
        "plate = link_visuals(ks.load_robot('robot.urdf').description)['plate']; assert plate.read > 1000, plate.read"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


@pytest.mark.slow
def test_large_meshes_are_drawn_with_fewer_triangles_and_a_note():
    robot = ks.load_robot("ur10")
    visuals = link_visuals(robot.description)
    scene = describe_scene(ks.analyze(robot.assemble()), visuals=visuals)
    (note,) = [note for note in scene.notes if "triangles" in note]
    drawn, read = (int(word) for word in note.split() if word.isdigit())
    assert read > 100_000 and drawn < 42_000
    assert drawn == sum(len(visual.surface.faces) for visual in visuals.values())
    assert len(page_html(scene.plain())) < 5e6


def test_decimated_mesh_keeps_its_shape_and_volume():
    mesh = trimesh.creation.icosphere(subdivisions=5)
    fine = Surface(np.asarray(mesh.vertices), np.asarray(mesh.faces))
    coarse = decimated(fine, 3000)
    assert 1000 < len(coarse.faces) <= 3000
    np.testing.assert_allclose(np.linalg.norm(coarse.vertices, axis=1), 1, atol=0.01)
    found = trimesh.Trimesh(coarse.vertices, coarse.faces, process=False)
    assert found.volume == pytest.approx(4 / 3 * np.pi, rel=0.02)
    assert decimated(fine, 10**6) is fine


# ---- the page, the command -----------------------------------------------------------------------------------------


def test_page_holds_the_scene_and_no_external_link(scene):
    plain = scene.plain()
    page = page_html(plain)
    read = packed_in(page)
    poses = np.frombuffer(base64.b64decode(read["stations"]["pose"]), "<f4").reshape(1, -1, 7)
    np.testing.assert_allclose(poses, scene.stations.poses, atol=1e-6)
    assert 'src="http' not in page and 'href="http' not in page
    assert len(page) < 6e5
    nasty = page_html({**plain, "title": "</script><b>&"})
    assert nasty.count("</script>") == page.count("</script>")


def test_view_command_writes_pages_of_poses_and_paths(tmp_path, capsys):
    file = tmp_path / "sag.html"
    robot = "robots/3rps.urdf.xacro"
    assert cli.main(["view", robot, "--platform", "z=500mm", "rx=2deg", "ry=0", "--html", str(file)]) == 0
    assert file.read_text(encoding="utf-8").startswith("<!DOCTYPE html>")
    for sweep in (
        ["--platform", "z=500mm", "--sweep", "rx=-10deg:10deg:3", "ry=0:5deg"],
        ["--sweep", "prismatic_1=-20mm:20mm:3"],
    ):
        assert cli.main(["view", robot, *sweep, "--html", str(file)]) == 0
        assert packed_in(file.read_text(encoding="utf-8"))["stations"]["frames"] == 3
    assert cli.main(["view", robot, "--by-mechanism", "--html", str(file)]) == 0
    ways = packed_in(file.read_text(encoding="utf-8"))["contributions"]
    assert ways[:4] == ["load", "platform_weight", "limb_1: attached", "limb_2: attached"]
    capsys.readouterr()


@pytest.mark.few(5)
@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--sweep", "rx=1"], "FROM:TO"),
        (["--sweep", "rx=0:1:1"], "at least 2"),
        (["--sweep", "rx=0:1:3", "ry=0:1:4"], "move together"),
        (["--sweep", "rx=0:1", "prismatic_1=0:1"], "cannot vary together"),
        (["--platform", "rx=0", "--sweep", "rx=0:1"], "too"),
        (["--actuators", "prismatic_1=0", "--sweep", "rx=0:1"], "--platform"),
        (["--sweep", "rx=a:1"], "not a number"),
        (["--by-mechanism", "--meshcat"], "--meshcat and --by-mechanism exclude one another"),
        (["--live", "--html", "x.html"], "not allowed"),
        (["--html", "missing/x.html"], "cannot be written"),
        (["--screenshot", "sag.jpg"], "images are PNG files; name it 'sag.png'"),
        (["--colour", "stress"], "give --screenshot FILE.png too"),
        (["--screenshot", "sag.png", "--by-mechanism"], "--screenshot and --by-mechanism exclude one another"),
    ],
)
def test_invalid_options_of_view_are_errors(arguments, words, capsys):
    assert cli.main(["view", "robots/3rps.urdf.xacro", *arguments]) == 2
    assert words in capsys.readouterr().err


def test_invalid_image_options_and_missing_browser_are_errors(tmp_path, monkeypatch):
    result = ks.analyze(package_robots.robot("3rps").assemble())
    for options, words in (
        ({"colour": "red"}, "one of deflection"),
        ({"view": "back"}, "home, front"),
        ({"size": (1, 1)}, "pixels"),
    ):
        with pytest.raises(ks.ArgumentError, match=words):
            ks.save_image(result, tmp_path / "sag.png", **options)
    monkeypatch.setattr("shutil.which", lambda name: None)
    with pytest.raises(ks.KinetostaticsError, match="apt install chromium"):
        ks.save_image(result, tmp_path / "sag.png")
    monkeypatch.setattr("shutil.which", lambda name: "/bin/true")
    with pytest.raises(ks.KinetostaticsError, match="has drawn no image in 3 attempts"):
        ks.save_image(result, tmp_path / "sag.png")


def test_hanging_browser_is_ended_and_started_again(tmp_path, monkeypatch):
    """At its first start it hangs, and a child process of it holds the pipe open."""
    browser = tmp_path / "browser"
    browser.write_text(
        "#!/bin/sh\ncd ${0%/*}; echo start >> starts; [ $(wc -l < starts) = 1 ] && { sleep 5 & sleep 5; }\n"
        'for word; do case $word in --screenshot=*) echo image > "${word#*=}";; esac; done\n'
    )
    browser.chmod(0o755)
    monkeypatch.setattr("shutil.which", lambda name: str(browser))
    monkeypatch.setattr(kinetostatics.viewer.page, "PATIENCE", (0.5, 60))
    save_screenshot("<html>", tmp_path / "sag.png", (300, 200))
    assert (tmp_path / "sag.png").read_text() == "image\n" and (tmp_path / "starts").read_text() == "start\n" * 2


def test_drawn_parts_have_the_same_stations_at_all_poses():
    """A page draws its first meshes at the stations of later poses; here both joints of the guide coincide where q = 0."""
    names, axes = ("turn", "slide", "wrist"), ("0 1 0", "0 0 1", "0 1 0")
    links = ("base", "guide", "rod", "platform")
    parts = [machines.link(name, 1.0) for name in links]
    for k, (name, axis) in enumerate(zip(names, axes, strict=True)):
        kind, at = "prismatic" if name == "slide" else "revolute", "0 0 0.5" if name == "wrist" else "0 0 0"
        parts += [machines.joint(name, kind, links[k], links[k + 1], at, axis)]
        parts += [
            f'<joint_stiffness joint="{name}" drive="1e4"/><transmission name="{name}"><joint name="{name}"/></transmission>'
        ]
    machine = machines.robot(*parts)
    poses = [machine.assemble(actuators={"turn": 0.0, "slide": q, "wrist": 0.0}) for q in (0.0, 0.1)]
    first, later = ({mesh.path: mesh.station for mesh in describe_scene(ks.analyze(pose)).meshes} for pose in poses)
    assert first == later and "joints/wrist" in first


def test_show_opens_a_browser_or_prints_the_address(monkeypatch, capsys):
    result = ks.analyze(package_robots.robot("3rps").assemble())
    opened = []
    monkeypatch.setattr("webbrowser.open", lambda address: opened.append(address) or True)
    view = ks.show(result, title="My robot")
    assert opened == [view.path.as_uri()]
    assert "<title>My robot</title>" in view.path.read_text(encoding="utf-8")
    view.path.unlink()
    monkeypatch.setattr("webbrowser.open", lambda address: False)
    view = ks.show(result)
    assert view.path.as_uri() in capsys.readouterr().err
    view.path.unlink()


def test_show_in_a_notebook_returns_an_iframe(monkeypatch):
    monkeypatch.setattr("kinetostatics.viewer.in_notebook", lambda: True)
    monkeypatch.setattr("webbrowser.open", lambda address: pytest.fail("a notebook needs no browser window"))
    view = ks.show(ks.analyze(package_robots.robot("3rps").assemble()))
    assert view.path is None and view._repr_html_().startswith("<iframe srcdoc=")


def test_mimic_joint_has_no_actuator_arrow_of_its_own():
    """A tip that turns with its arm's actuator: it is drawn as actuated, and the actuator has the only arrow."""
    turned = '<child link="tip"/><origin xyz="0.3 0 0"/><axis xyz="0 1 0"/>'
    joints = (
        '<joint name="arm_turn" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="0 1 0"/></joint>'
        f'<joint name="tip_turn" type="continuous"><parent link="arm"/>{turned}<mimic joint="arm_turn"/></joint>'
    )
    mass = '<inertial><mass value="2"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
    links = f'<link name="base"/><link name="arm"/><link name="tip">{mass}</link><platform link="tip"/>'
    text = f'<robot name="arm">{links}{joints}<transmission name="m"><joint name="arm_turn"/></transmission></robot>'
    result = ks.analyze(ks.Robot(parse_robot_text(text)).assemble())
    scene = describe_scene(result)
    assert [arrow.name for arrow in scene.arrows if arrow.group == "actuator forces"] == ["arm_turn"]
    assert "tip_turn" in str(packed_in(page_html(scene.plain())))
