"""The robot in a running meshcat: geometry, arrows and texts below a path of its own, beside other objects."""

import base64
import re
import signal
import socket
import subprocess
import sys

import meshcat
import numpy as np
import package_robots
import pytest
from browser_pages import ENDS, LOAD, POSES, packed_in, vertices
from meshcat_windows import Window, drawn
from pinocchio.visualize import MeshcatVisualizer
from places import ROOT
from scipy.spatial.transform import Rotation

import kinetostatics as ks
from kinetostatics.cli import main as cli
from kinetostatics.files.reader import parse_robot_text
from kinetostatics.viewer.description import HIDDEN
from kinetostatics.viewer.running_meshcat import connected
from kinetostatics.viewer.scene import describe_scene

CAMERA = "/Cameras/default/rotated/<object>"
VERTEX_COLOURS = """(path) => { const { object } = viewer.scene_tree.find([...path.split("/"), "<object>"]);
  return object.geometry.attributes.color ? [...object.geometry.attributes.color.array] : object.material.color.getHex(); }"""
PAGE = ROOT / "docs" / "how_to" / "viewer.md"


@pytest.fixture(scope="module", params=["2pru_upr", pytest.param("3rps", marks=pytest.mark.slow)])
def result(request):
    return ks.analyze(ks.load_robot(request.param).assemble(platform=POSES[request.param]), load=LOAD)


@pytest.fixture(autouse=True)
def in_root(monkeypatch, request):
    monkeypatch.chdir(request.config.rootpath)


# ---- geometry, camera and texts ------------------------------------------------------------------------------------


def test_platform_and_beam_displacements_equal_the_result(result):
    factor = 700.0
    window, node = drawn(result, exaggeration=factor)
    root = node.path.lower()
    assert root == f"/meshcat/kinetostatics/{result.robot.name}"
    frame, twist = result.configuration.platform_frame, factor * result.twist
    platform = window.transforms[f"{root}/frames/platform"]
    np.testing.assert_allclose(platform[:3, 3], frame[:3, 3] + twist[:3], rtol=0, atol=1e-14)
    np.testing.assert_allclose(platform[:3, :3], Rotation.from_rotvec(twist[3:]).as_matrix() @ frame[:3, :3], rtol=0, atol=1e-14)
    for name, beam in result.beams.items():
        surface = describe_scene(result)
        mesh = next(mesh for mesh in surface.meshes if mesh.path == f"beams/{name}" and "Deformed" in mesh.roots)
        found = window.vertices(f"{root}/deformed/beams/{name}")
        line = beam.points + factor * sum(result.beam_contributions[name].values())[:, :3]
        for station in np.unique(mesh.station):
            ring = found[mesh.station == station].astype(float)
            np.testing.assert_allclose(ring.mean(axis=0), line[station - mesh.station.min()], rtol=0, atol=1e-6)


def test_resting_robot_is_transparent_and_at_the_pose(result):
    window, node = drawn(result)
    root = node.path.lower()
    seen = 0
    for path, item in window.objects.items():
        if path.startswith(f"{root}/resting/"):
            assert item.material.opacity == 0.2
            link = path.rpartition("/")[2]
            if link in result.robot.description.links:
                np.testing.assert_array_equal(window.transforms[path], result.configuration.frame(link))
                seen += 1
    assert seen > 3


def test_deflection_colours_and_exaggeration_are_those_of_the_page(result):
    scene, (window, node) = describe_scene(result), drawn(result)
    platform = next(mesh for mesh in scene.meshes if mesh.path == result.robot.description.platform)
    item = window.objects[f"{node.path.lower()}/deformed/{platform.path}"]
    at = scene.stations.rest[platform.station][0]
    points = platform.surface.vertices @ at[:3, :3].T + at[:3, 3]
    twist, o = result.twist, result.configuration.platform_frame[:3, 3]
    lengths = np.linalg.norm(twist[:3] + np.cross(twist[3:], points - o), axis=-1)
    legend = window.words("/Cameras/default/rotated/<object>/kinetostatics/legend")
    end = 1e-6 * float(re.search(r"deflection \[µm\].*?0 +[\d.]+ +[\d.]+ +[\d.]+ +([\d.]+)", legend)[1])
    green = np.interp(lengths / end, np.linspace(0, 1, 9), [int(c[3:5], 16) / 255 for c in scene.plain()["ramp"]])
    np.testing.assert_allclose(item.geometry.color[:, 1], green, rtol=0, atol=1e-6)
    moved = window.transforms[f"{node.path.lower()}/frames/platform"][:3, 3] - o
    np.testing.assert_allclose(moved, scene.exaggeration * twist[:3], rtol=1e-9)


def test_arrows_have_direction_and_value_of_the_forces(result):
    window, node = drawn(result)
    forces = f"{node.path.lower()}/forces"
    loads = np.array(LOAD[:3])
    at = window.transforms[f"{forces}/external load/load force"]
    np.testing.assert_allclose(at[:3, 2], loads / np.linalg.norm(loads), rtol=0, atol=1e-14)
    surface = window.vertices(f"{forces}/external load/load force")
    tip = surface[np.argmax(surface @ at[:3, 2])]
    np.testing.assert_allclose(tip, window.transforms[f"{node.path.lower()}/frames/platform"][:3, 3], rtol=0, atol=1e-6)
    for name, force in result.actuator_forces.items():
        words = window.words(f"{node.path.lower()}/labels/actuator forces/{name}")
        value = float(words.split()[-2].replace("−", "-"))
        assert words.split()[0] == name and words.split()[-1] == "N"
        assert value == pytest.approx(float(force), rel=5e-3)
    groups = {path[len(forces) + 1 :].split("/")[0] for path in window.objects if path.startswith(forces)}
    hidden = {path.rpartition("/")[2] for path in window.properties if path.startswith(forces)}
    assert hidden == groups & set(HIDDEN) and "constraint forces" in hidden and "external load" in groups - hidden


def test_drawing_stays_below_its_path_with_slashes_in_names():
    text = package_robots.robot("3rps").description.urdf
    robot = ks.Robot(parse_robot_text(text.replace('"platform"', '"//platform//plate"'), "slashes.urdf"))
    assert robot.description.platform == "//platform//plate"
    result = ks.analyze(robot.assemble(), load=LOAD)
    window = Window()
    node = ks.show(result, visualizer=meshcat.Visualizer(window=window)["lab"], node="mine/robot")
    assert node.path.lower() == "/meshcat/lab/mine/robot"
    stage = {
        *("/", "/Cameras/default", CAMERA, f"{CAMERA}/kinetostatics/heading", f"{CAMERA}/kinetostatics/legend", "/Background"),
        *("/Grid", "/Axes", *(f"/Lights/{name}" for name in ("PointLightNegativeX", "PointLightPositiveX", "SpotLight"))),
        "/Lights/SpotLight/<object>",
    }
    assert {path for path in window.paths if not (path + "/").startswith(node.path.lower() + "/")} == stage
    assert any(path.endswith("deformed/platform/plate") for path in window.objects)


def test_camera_frames_the_robot_and_is_kept_on_redrawing(result):
    window, node = drawn(result)
    eye, turned = window.properties[CAMERA], window.transforms["/"]
    target = window.transforms["/Cameras/default"][:3, 3]
    np.testing.assert_allclose(turned @ [*target, 1], [0, 0, 0, 1], atol=1e-12)  # it turns about the window's origin
    assert window.properties["/Background"] == {"top_color": [1, 1, 1], "bottom_color": [1, 1, 1]}
    assert window.properties["/Grid"] == {"visible": False}
    towards = np.array(eye["position"]) / np.linalg.norm(eye["position"])
    across = np.cross([0, 1, 0], towards) / np.linalg.norm(np.cross([0, 1, 0], towards))
    paths = [path for path in window.objects if path.split("/")[4:5] in (["deformed"], ["base"], ["resting"])]
    points = np.concatenate([window.vertices(path) for path in paths]) @ turned[:3, :3].T + turned[:3, 3]
    depth = np.linalg.norm(eye["position"]) - points @ towards
    seen = points @ np.stack([across, np.cross(towards, across)]).T / depth[:, None] / np.tan(np.radians(eye["fov"] / 2))
    assert np.all(depth > eye["near"]) and np.all(np.abs(seen) < [4 / 3, 1])
    assert np.ptp(seen[:, 0]) > 1.3 * 4 / 3 or np.ptp(seen[:, 1]) > 1.2
    floor = window.objects[f"{node.path.lower()}/floor"].geometry.position
    lowest = np.concatenate([window.vertices(path) for path in paths])[:, 2].min()
    assert np.ptp(floor[2]) == 0 and lowest - 0.01 < floor[2, 0] < lowest
    before = {path: dict(found) for path, found in window.properties.items() if path.startswith("/Cameras")}
    window.properties.clear()
    drawn(result, meshcat.Visualizer(window=window), exaggeration=1.0)
    assert not any(path.startswith(("/Cameras", "/Background")) for path in window.properties) and before


def test_heading_and_legend_show_pose_load_scale_and_forces(result):
    window, _ = drawn(result, exaggeration=1200.0, title="a < b")
    heading = " ".join(window.words(f"{CAMERA}/kinetostatics/heading").split())
    z = 1e3 * float(result.configuration.platform_coordinates()["z"])
    assert heading.startswith("a < b pose x ") and f"z {z:.4g} mm" in heading
    assert "gravity (0, 0, −9.81) m/s²" in heading and "load at o (100, 50, −500) N, (10, 20, −5) N·m" in heading
    legend = window.words(f"{CAMERA}/kinetostatics/legend")
    assert "drawn × 1200; pale: at rest; squares of the floor: " in legend and "actuator forces" in legend
    for name, force in result.actuator_forces.items():
        assert float(re.search(rf"{name} (\S+) N", legend)[1].replace("−", "-")) == pytest.approx(float(force), rel=5e-3)
    assert "constraint" not in legend  # not seen at first


def test_animation_swings_between_rest_and_deformed(result):
    window, node = drawn(result)
    root, scene = node.path.lower(), describe_scene(result)
    sent = window.animations[f"{root}/animation"]
    assert sent["options"] == {"play": True, "repetitions": 3}
    tracks = {(item["path"], track["name"]): track["keys"] for item in sent["animations"] for track in item["clip"]["tracks"]}
    middle = [key["value"] for key in tracks[f"{root}/frames/platform", ".position"]]
    o = result.configuration.platform_frame[:3, 3]
    np.testing.assert_allclose(middle[0], o + scene.exaggeration * result.twist[:3], atol=1e-12)
    np.testing.assert_allclose(middle[len(middle) // 2], o, atol=1e-12)
    assert middle[-1] == pytest.approx(middle[0])
    for name in result.beams:
        bent = window.objects[f"{root}/deformed/beams/{name}"].geometry
        influence = tracks[f"{root}/deformed/beams/{name}/<object>", ".morphTargetInfluences[0]"]
        assert influence[0]["value"] == 0.0 and influence[len(influence) // 2]["value"] == 1.0
        np.testing.assert_allclose(bent.others.mean(axis=0), result.beams[name].points.mean(axis=0), atol=5e-3)
    ks.show(result, visualizer=meshcat.Visualizer(window=window))
    assert window.animations[f"{root}/animation"]["options"]["play"] is False


@pytest.mark.slow
def test_meshcat_in_a_browser_equals_the_page(result, visit, browser, tmp_path):
    """Colours, vertices and arrows of one scene, drawn by meshcat from its commands and by the page from its description."""
    ks.save_html(result, tmp_path / "page.html")
    page = visit((tmp_path / "page.html").as_uri())
    with connected(None) as visualizer:
        root = ks.show(result, visualizer=visualizer).path.lower()[1:]
        (tmp_path / "meshcat.html").write_text(visualizer.static_html(), encoding="utf-8")
    other, problems = browser.new_page(offline=True), []
    other.set_default_timeout(90_000)
    other.on("console", lambda message: problems.append(message.text) if message.type in ("error", "warning") else None)
    other.on("pageerror", lambda error: problems.append(str(error)))
    other.goto((tmp_path / "meshcat.html").as_uri())
    other.wait_for_function(
        "viewer.scene_tree.children.Cameras.children.default.children.rotated.children['<object>'].children"
        ".kinetostatics?.children.legend?.children['<object>']"
    )
    other.evaluate("viewer.animator.pause(); viewer.animator.seek(0)")
    shown = [mesh for mesh in describe_scene(result).meshes if "Deformed" in mesh.roots]
    assert len(shown) > 8
    for mesh in shown:
        theirs, ours = (
            other.evaluate(VERTEX_COLOURS, f"{root}/deformed/{mesh.path}"),
            page.evaluate(VERTEX_COLOURS, f"Deformed/{mesh.path}"),
        )
        np.testing.assert_allclose(theirs, ours, atol=2e-5, err_msg=mesh.path)
        found = [vertices(other, f"{root}/deformed/{mesh.path}"), vertices(page, f"Deformed/{mesh.path}")]
        np.testing.assert_allclose(*found, atol=1e-5, err_msg=mesh.path)
    for name in result.actuator_forces:
        tail, tip = np.array(page.evaluate(ENDS, f"Arrows/actuator forces/{name}"))
        arrow = vertices(other, f"{root}/forces/actuator forces/{name}")
        along = (arrow - tail) @ (tip - tail) / np.linalg.norm(tip - tail) ** 2
        assert along.min() == pytest.approx(0, abs=1e-4) and along.max() == pytest.approx(1, abs=1e-4)
    other.evaluate("viewer.animator.play(); viewer.animator.pause(); viewer.animator.seek(viewer.animator.duration / 2)")
    influence = "(path) => viewer.scene_tree.find(path.split('/')).object.morphTargetInfluences[0]"
    assert {other.evaluate(influence, f"{root}/deformed/beams/{name}/<object>") for name in result.beams} == {1}
    np.testing.assert_allclose(
        vertices(other, f"{root}/deformed/{result.robot.description.platform}"),
        vertices(page, f"Rest/{result.robot.description.platform}"),
        atol=1e-5,
    )
    assert problems == []
    other.close()


def test_drawing_again_replaces_the_former_robot_only(result):
    vis = meshcat.Visualizer(window=Window())
    vis["box"].set_object(meshcat.geometry.Box([1, 1, 1]))
    window, node = drawn(result, vis)
    node["left over"].set_object(meshcat.geometry.Sphere(1))
    before = set(window.objects)
    ks.show(ks.analyze(result.configuration), visualizer=vis)
    after = set(window.objects)
    assert "/meshcat/box" in after and "external load" in str(before) and "external load" not in str(after)
    assert f"{node.path.lower()}/left over" in before - after
    assert window.deleted == [node.path.lower()] * 2


def test_one_pose_of_a_batch_is_drawn_like_the_pose_alone():
    robot = package_robots.robot("3rps")
    z = np.array([[0.5, 0.52], [0.54, 0.56], [0.58, 0.6]])
    batch = ks.analyze(robot.assemble(platform={"z": z, "rx": 0.1, "ry": 0.0}), load=LOAD)
    with pytest.raises(ks.ArgumentError, match=r"shape \(3, 2\): choose one by pose="):
        drawn(batch)
    alone, _ = drawn(ks.analyze(robot.assemble(platform={"z": 0.54, "rx": 0.1, "ry": 0.0}), load=LOAD), exaggeration=100)
    for pose in ((1, 0), (-2, -2)):
        window, _ = drawn(batch, pose=pose, exaggeration=100)
        assert window.objects.keys() == alone.objects.keys()
        for path, matrix in alone.transforms.items():
            np.testing.assert_allclose(window.transforms[path], matrix, rtol=0, atol=1e-8, err_msg=path)
    for pose in (1, (3, 0), (0, -3), (0.5, 0), (0, 0, 0), "first"):
        with pytest.raises(ks.ArgumentError, match="pose is"):
            drawn(batch, pose=pose)
    with pytest.raises(ks.ArgumentError, match="left out, as the result is of one pose"):
        drawn(ks.analyze(robot.assemble()), pose=0)
    assert describe_scene(batch, pose=(2, 1)).stations.frames == 1


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"visualizer": object()}, "must be a meshcat.Visualizer"),
        ({"node": ""}, "names joined by '/'"),
        ({"node": "/kinetostatics"}, "names joined by '/'"),
        ({"node": "a//b"}, "names joined by '/'"),
        ({"node": 3}, "names joined by '/'"),
        ({"visualizer": None, "node": "here"}, "node= needs visualizer="),
        ({"exaggeration": 0}, "positive number"),
        ({"exaggeration": float("nan")}, "positive number"),
        ({"exaggeration": "much"}, "positive number"),
    ],
)
def test_invalid_arguments_of_show_are_errors(options, words, result):
    window = Window()
    with pytest.raises(ks.ArgumentError, match=words):
        ks.show(result, **{"visualizer": meshcat.Visualizer(window=window), **options})
    assert window.paths == []


def test_save_html_takes_pose_and_exaggeration(tmp_path):
    batch = ks.analyze(package_robots.robot("3rps").assemble(platform={"z": [0.5, 0.6], "rx": 0.0, "ry": 0.0}))
    ks.save_html(batch, tmp_path / "one.html", pose=1, exaggeration=321)
    scene = packed_in((tmp_path / "one.html").read_text(encoding="utf-8"))
    assert scene["exaggeration"]["value"] == 321.0 and scene["stations"]["frames"] == 1


# ---- other objects, servers and the command ------------------------------------------------------------------------


def test_pinocchios_visualizer_shows_the_same_robot_in_the_same_scene():
    """The code of the documentation runs, and Pinocchio's visuals are where those of the resting robot are."""
    window = Window()
    page = PAGE.read_text(encoding="utf-8").partition("## In a running meshcat")[2]
    first, second = re.findall(r"```python\n(.*?)```", page, re.DOTALL)[:2]
    names = {"ks": ks}
    server = meshcat.Visualizer(window=window)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(meshcat, "Visualizer", lambda: server)
        for block in (first, second):
            exec(compile(block, "viewer.md", "exec"), names)  # the page's own text
    assert isinstance(names["beside"], MeshcatVisualizer) and names["vis"] is server
    roots = {path.split("/")[2] for path in window.objects if path.startswith("/meshcat/")}
    assert roots == {"kinetostatics", "pinocchio"}
    shown, pose = 0, names["pose"]
    for item in names["visuals"].geometryObjects:
        frame = pose.model.frames[item.parentFrame]
        found = window.transforms[f"/meshcat/pinocchio/visuals/{item.name}"]
        link = pose.frame(frame.name)
        local = np.linalg.inv(frame.placement.homogeneous) @ item.placement.homogeneous
        np.testing.assert_allclose(found[:3, 3], (link @ local)[:3, 3], rtol=0, atol=1e-12)
        shown += 1
    assert shown > 10


def decoded(page):
    """The commands of a page that meshcat wrote."""
    return b"".join(base64.b64decode(text) for text in re.findall(r"base64,([A-Za-z0-9+/=]+)\"", page))


@pytest.fixture(scope="module")
def server():
    vis = meshcat.Visualizer()
    yield vis
    vis.window.server_proc.terminate()
    vis.window.server_proc.wait()


def test_real_server_stores_shows_and_deletes_the_robot(server, result):
    server["box"].set_object(meshcat.geometry.Box([1, 1, 1]))
    node = ks.show(result, visualizer=server)
    ks.show(result, visualizer=server, node="again")
    node["resting"].set_property("visible", False)
    held = decoded(server.static_html())
    for path in ("/meshcat/box", f"{node.path.lower()}/deformed/", "/meshcat/again/forces/external load", "limb_1"):
        assert path.encode() in held, path
    assert "<iframe" in server.render_static().data and server.url() in server.jupyter_cell().data
    node.delete()
    held = decoded(server.static_html())
    assert node.path.lower().encode() not in held and b"/meshcat/again/deformed/" in held and b"/meshcat/box" in held


def test_command_draws_into_a_running_server(server, capsys):
    url = server.window.zmq_url
    assert cli.main(["view", "robots/3rps.urdf.xacro", "--meshcat", url, "--exaggeration", "50"]) == 0
    assert capsys.readouterr().out == f"drawn at /meshcat/kinetostatics/3rps of {server.url()}\n"
    assert b"/meshcat/kinetostatics/3rps/deformed/" in decoded(server.static_html())


@pytest.mark.slow
def test_command_starts_and_stops_a_server(tmp_path):
    code = (
        "import sys, webbrowser; webbrowser.open = lambda address: True;"
        "from kinetostatics.cli.main import main; sys.exit(main(['view', 'robots/3rps.urdf.xacro', '--meshcat']))"
    )
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    line = process.stdout.readline()
    assert re.fullmatch(r"drawn at /meshcat/kinetostatics/3rps of (http://127\.0\.0\.1:\d+/static/) \(Ctrl\+C ends it\)\n", line)
    process.send_signal(signal.SIGINT)
    rest, _ = process.communicate(timeout=60)
    assert process.returncode == 0 and rest == ""


def test_server_of_the_command_listens_on_loopback_only():
    """At 127.0.0.1; meshcat's own server would answer at all addresses of 127.0.0.0/8."""
    with connected(None) as visualizer:
        port = int(visualizer.url().split(":")[2].partition("/")[0])
        with socket.create_connection(("127.0.0.1", port), timeout=5):
            pass
        with pytest.raises(OSError):
            socket.create_connection(("127.0.0.2", port), timeout=5)
        server = visualizer.window.server_proc
    assert server.poll() is not None


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--meshcat", "http://127.0.0.1:7000"], "no meshcat-server answers"),
        (["--meshcat", "tcp://127.0.0.1:1"], "no meshcat-server answers"),
        (["--meshcat", "--live"], "not allowed"),
        (["--meshcat", "--platform", "z=0.5", "--sweep", "rx=0:1"], "exclude one another"),
        (["--exaggeration", "0"], "positive number"),
    ],
)
def test_invalid_meshcat_and_exaggeration_options_are_errors(arguments, words, capsys, monkeypatch):
    monkeypatch.setattr("kinetostatics.viewer.running_meshcat.PATIENCE", 300)
    assert cli.main(["view", "robots/3rps.urdf.xacro", *arguments]) == 2
    assert words in capsys.readouterr().err


def test_connections_are_closed_at_their_end():
    """A context that is collected before its sockets would wait for them for ever."""
    with connected(None) as visualizer:
        socket = visualizer.window.zmq_socket
    assert socket.closed and socket.context.closed
