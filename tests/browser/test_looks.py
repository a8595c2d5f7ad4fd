"""What robots look like: surfaces that coincide, platforms without visuals, colours of rigid links, meshes, labels in meshcat."""

import base64
import gzip
import io
import json
import re
import subprocess
import warnings
from dataclasses import replace
from importlib.resources import files

import numpy as np
import package_robots
import pytest
from browser_pages import packed_in, settle
from meshcat_windows import drawn
from page_machine import needs_node
from PIL import Image as image
from surfaces import enclosed

import kinetostatics as ks
from kinetostatics.files.reader import parse_robot_text
from kinetostatics.viewer import computing
from kinetostatics.viewer.packing import packed_code, packed_indices
from kinetostatics.viewer.scene import describe_scene
from kinetostatics.viewer.shapes import plate
from kinetostatics.viewer.visuals import link_visuals, without_textures


@pytest.fixture(scope="module")
def bare():
    """The 3RPS without visuals."""
    urdf = package_robots.robot("3rps").description.urdf
    return ks.Robot(parse_robot_text(re.sub("<visual.*?</visual>", "", urdf, flags=re.DOTALL), "bare.urdf"))


def test_coinciding_surfaces_at_rest_and_deformed_look_as_deformed(bare, visit, tmp_path):
    """The pale robot is hidden where both are at the same place; it was drawn in spots there."""
    ks.save_html(ks.analyze(bare.assemble(), load=[100, 50, -500, 0, 0, 0]), tmp_path / "bare.html", exaggeration=1e-6)
    page, seen = visit((tmp_path / "bare.html").as_uri()), []
    for on in (True, False):
        page.evaluate("on => { viewer.set_property(['Rest'], 'visible', on); viewer.set_dirty(); }", on)
        settle(page)
        data = base64.b64decode(page.evaluate("robot_page.picture(1)").partition(",")[2])
        seen.append(np.asarray(image.open(io.BytesIO(data)).convert("RGB")).astype(int))
    changed = np.abs(seen[0] - seen[1]).max(axis=2) > 8
    coloured = np.ptp(seen[1], axis=2) > 40
    assert coloured.mean() > 0.02
    assert (changed & coloured).sum() < 0.01 * coloured.sum()


def test_platform_without_visuals_is_a_plate_through_its_joints(bare):
    scene = describe_scene(ks.analyze(bare.assemble()))
    platform = next(mesh for mesh in scene.meshes if mesh.path == "platform")
    centres = [scene.stations.rest[mesh.station][0, :3, 3] for mesh in scene.meshes if re.match("joints/spherical", mesh.path)]
    at = scene.stations.rest[platform.station][0]
    vertices = platform.surface.vertices @ at[:3, :3].T + at[:3, 3]
    corners = np.array(centres)
    assert len(corners) == 3
    normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    normal /= np.linalg.norm(normal)
    beside = (vertices - corners[0]) @ normal
    side = np.linalg.norm(corners[1] - corners[0])
    assert 0 < np.ptp(beside) < 0.15 * side and abs(beside.max() + beside.min()) < 1e-9
    area = enclosed(vertices, platform.surface.faces) / np.ptp(beside)
    assert area > np.sqrt(3) / 4 * side**2  # more than the triangle: no star, no ball


@pytest.mark.parametrize(
    ("points", "area"),
    [
        ([[0, 0, 0]], np.pi),
        ([[0, 0, 0], [5, 0, 0]], np.pi + 10),
        ([[0, 0, 0], [5, 0, 0], [5, 0, 7], [0, 0, 7], [2, 0, 3]], np.pi + 35 + 24),
        ([[0, 0, 0], [0, 5, 0], [0, 5, 5]], np.pi + 12.5 + 10 + 5 * np.sqrt(2)),
    ],
)
def test_plates_are_closed_with_the_right_volume(points, area):
    """They are hulls of discs of radius 1 and height 1."""
    surface = plate(np.array(points, dtype=float), 1.0)
    assert enclosed(surface.vertices, surface.faces) == pytest.approx(area, rel=0.002)


def test_a_plate_has_posts_to_joints_beside_its_plane():
    corners = np.array([[0.0, 0, 0], [10, 0, 0], [10, 10, 0], [0, 10, 0]])
    up = np.array([0.0, 0, 1])
    surface = plate(np.concatenate([corners + up, corners - up]), 1.0)
    low, high = surface.vertices.min(axis=0), surface.vertices.max(axis=0)
    np.testing.assert_allclose([low, high], [[-1, -1, -1], [11, 11, 1]], atol=1e-9)


def test_links_of_rigid_robots_keep_their_colours():
    described = package_robots.robot("3rps").description
    rigid = ks.Robot(replace(described, beams={}, path="rigid.urdf"))
    for robot, own in ((rigid, True), (package_robots.robot("3rps"), False)):
        visuals = link_visuals(robot.description)
        scene = describe_scene(ks.analyze(robot.assemble()))
        platform = next(mesh for mesh in scene.meshes if mesh.path == "platform")
        assert platform.by_deflection is not own
        if own:
            np.testing.assert_array_equal(platform.colour, visuals["platform"].colours)
            assert not any(mesh.by_deflection for mesh in scene.meshes)


def test_meshes_have_the_colours_of_their_files_unless_the_robot_file_gives_one():
    visuals = link_visuals(package_robots.robot("ur10").description)
    blue = np.array([97, 137, 163]) / 255  # of the lids, in the package's COLLADA files
    shoulder = np.unique(visuals["shoulder_link"].colours, axis=0)
    assert len(shoulder) > 2 and np.abs(shoulder - blue).max(axis=1).min() < 0.02


@pytest.mark.slow
def test_feet_of_anymal_are_read_though_their_file_refers_to_a_missing_texture():
    with warnings.catch_warnings():
        warnings.simplefilter("error", UserWarning)
        visuals = link_visuals(package_robots.robot("anymal_standing").description)
    trunk = np.unique(visuals["base"].colours, axis=0)
    assert trunk.shape == (1, 3)
    assert {f"{leg}_ADAPTER" for leg in ("LF", "RF", "LH", "RH")} <= set(visuals)
    assert visuals["LF_ADAPTER"].read == 81 + 4484 + 39  # the triangles of the file


def test_only_textures_are_left_out_of_a_collada_file():
    text = b"""<C xmlns="x"><library_images><image/></library_images><effect><newparam/><diffuse><texture/></diffuse>
<ambient><color>1</color></ambient></effect><geometry/></C>"""
    left = without_textures(text).decode()
    assert re.findall(r"<\w+:(\w+)", left) == ["C", "effect", "ambient", "color", "geometry"]


def test_labels_are_shown_in_meshcat_except_those_of_hidden_forces(bare):
    window, node = drawn(ks.analyze(bare.assemble(), load=[100, 0, 0, 0, 0, 0]))
    root = f"{node.path.lower()}/labels"
    hidden = [path for path, properties in window.properties.items() if path.startswith(root) and properties["visible"] is False]
    assert root not in hidden and f"{root}/constraint forces" in hidden
    assert window.words(f"{root}/external load/load force").strip() == "load force 100 N"


@pytest.mark.slow
def test_large_meshes_are_small_in_the_page_and_as_read(visit, tmp_path):
    """Rounded by less than 0.1 mm; the largest meshes of a shipped robot take less than half a megabyte."""
    result = ks.analyze(package_robots.robot("anymal_standing").assemble())
    ks.save_html(result, tmp_path / "anymal.html")
    meshes = json.dumps(packed_in((tmp_path / "anymal.html").read_text(encoding="utf-8"))["meshes"])
    assert 4 / 3 * len(gzip.compress(meshes.encode(), 6)) < 500_000
    page = visit((tmp_path / "anymal.html").as_uri())
    mesh = next(mesh for mesh in describe_scene(result).meshes if len(mesh.surface.vertices) > 10_000)
    for key, expected, tolerance in (("vertices", mesh.surface.vertices, 5e-5), ("faces", mesh.surface.faces, 0)):
        found = page.evaluate("([path, key]) => [...robot_page.solids.get(`Deformed/${path}`).spec[key]]", [mesh.path, key])
        np.testing.assert_allclose(np.reshape(found, (-1, 3)), expected, rtol=0, atol=tolerance)


@pytest.mark.parametrize("indices", [[0], [0, 1, 0, 2, 2, 3], [7, 7, 3, 70_000, 0], list(range(300))])
def test_indices_are_written_and_read_unchanged(page, indices):
    data = packed_indices(indices)
    assert page.evaluate("data => [...robot_page.unpackIndices(data)]", data) == indices


UNPACK = """
const { zipped, modules } = JSON.parse(require("fs").readFileSync(0, "utf8")), zlib = require("zlib");
const found = unpackCode(new Uint8Array(zlib.gunzipSync(Buffer.from(zipped, "base64"))), modules);
process.stdout.write(JSON.stringify(found.map((code) => Buffer.from(code).toString("base64"))));
"""


@needs_node
def test_code_is_unpacked_byte_by_byte(bare, monkeypatch):
    modules = []
    monkeypatch.setattr(computing, "packed_code", lambda all_of_a_page: modules.extend(all_of_a_page) or {})
    monkeypatch.setattr(computing, "read_stored", lambda *_: None)
    computing.computing_page(ks.analyze(bare.assemble()))
    packed = packed_code(modules)
    assert len(modules) > 3 and 5 * len(packed["zipped"]) < sum(map(len, modules))
    source = (files("kinetostatics.viewer") / "assets" / "unpacking.js").read_text(encoding="utf-8") + UNPACK
    run = subprocess.run(["node", "-e", source], input=json.dumps(packed), capture_output=True, text=True, timeout=60, check=True)
    assert [base64.b64decode(code) for code in json.loads(run.stdout)] == modules


QUICK = ("3rps", "2pru_upr")


@pytest.mark.parametrize("name", [pytest.param(n, marks=[] if n in QUICK else pytest.mark.slow) for n in package_robots.NAMES])
def test_pages_that_compute_are_small(name, tmp_path):
    ks.save_html(ks.analyze(package_robots.robot(name).assemble()), tmp_path / "page.html")
    assert (tmp_path / "page.html").stat().st_size < (0.65e6 if name in QUICK else 1.5e6)
