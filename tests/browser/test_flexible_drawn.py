"""Links by their matrices in the scene: their interfaces move as in the result, and the surface between them bends smoothly."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from browser_pages import move, vertices
from hub_robots import hub_robot
from matrix_link import with_flexible
from page_machine import answers, needs_node, relative
from robots_of_castings import FOLDER
from simple_machines import joint, link
from simple_machines import robot as robot_of

import kinetostatics as ks
from kinetostatics.description import Flexible, LinkMatrices
from kinetostatics.math.rotations import exponential, skew
from kinetostatics.viewer.drawn_poses import ShownPoses, blended
from kinetostatics.viewer.scene import describe_scene
from kinetostatics.viewer.single_poses import ModePoses, UnloadedPose
from kinetostatics.viewer.still import Still

LENGTH, BEAM = 0.4, 'density="0" youngs_modulus="2e11" poisson_ratio="0.3" shear_coefficient="inf"'


def cantilever(visual="", actuator='<transmission name="t"><joint name="foot"/></transmission>', material=BEAM):
    parts = [link("base"), f'<link name="arm">{visual}</link>', link("platform", 3.0), actuator]
    parts += [joint("foot", "revolute", "base", "arm"), joint("tip", "fixed", "arm", "platform", f"{LENGTH} 0 0")]
    return robot_of(*parts, f'<beam link="arm" from="foot" to="tip" {material}><circle diameter="0.03"/></beam>')


def mesh_of(scene, name):
    return next(mesh for mesh in scene.meshes if mesh.path == f"links/{name}")


@pytest.mark.parametrize("seed", [1, 3])
def test_interfaces_move_as_ends_of_beams(seed):
    """Of a link that joins three to five rods, and of the rods."""
    machine = hub_robot(seed)[0]
    robots = with_flexible(machine, seed=seed), machine
    found, expected = (ShownPoses(ks.analyze(robot.assemble(), [10, -20, -300, 4, 5, 6])) for robot in robots)
    largest = np.abs(found.platform_twist).max()
    for name, part in found.robot.description.flexible.items():
        twists, points = found.interface_twists(name), found.interfaces(name)
        ends = [
            (expected.beam_line(key)[1][0, end], expected.beam_twists(key)[:, :, end])
            for key, beam in machine.description.beams.items()
            for end in (0, -1)
            if beam.link == part.link
        ]
        for k, point in enumerate(points[0]):
            at, twist = min(ends, key=lambda end, point=point: np.linalg.norm(end[0] - point))
            np.testing.assert_allclose(point, at, atol=1e-12)
            np.testing.assert_allclose(twists[:, :, k], twist, rtol=0, atol=1e-9 * largest)


def test_interfaces_move_in_modes_and_free_motions():
    """The inner interface does not move with a locked actuator, the outer one with the platform; a free hinge turns both."""
    modes = ModePoses(ks.modes(with_flexible(cantilever()).assemble(), 3))
    foot, tip = np.moveaxis(modes.interface_twists("arm"), 2, 0)
    assert np.abs(foot).max() < 1e-12 * np.abs(tip).max()
    np.testing.assert_allclose(tip, modes.platform_twist, rtol=1e-9, atol=1e-12)
    loose = UnloadedPose(with_flexible(cantilever(actuator="")).assemble())
    foot, tip = np.moveaxis(loose.interface_twists("arm"), 2, 0)
    np.testing.assert_allclose(tip, loose.platform_twist, atol=1e-9)
    np.testing.assert_allclose(foot[..., :3], 0.0, atol=1e-9)
    assert np.linalg.norm(loose.twist_at("arm", np.array([[LENGTH / 2, 0, 0]]))[..., :3]) > 0.1 * np.linalg.norm(tip[..., :3])
    held = describe_scene(UnloadedPose(with_flexible(cantilever()).assemble()))  # nothing moves
    assert mesh_of(held, "arm").roots == ("Deformed",) and not held.stations.contribution_names


def test_motion_between_interfaces():
    """It is that of the interfaces there, rigid if theirs is, rotates by half its curl, bends in the middle as a beam does."""
    rng = np.random.default_rng(0)
    interfaces, points, twists = rng.normal(size=(2, 4, 3)), rng.normal(size=(2, 5, 3)), rng.normal(size=(2, 3, 4, 6))
    np.testing.assert_allclose(blended(interfaces, interfaces, twists), twists, atol=1e-9)
    turn, shift = rng.normal(size=(2, 3, 1, 3)), rng.normal(size=(2, 3, 1, 3))

    def rigid(at):
        return np.concatenate([shift + np.cross(turn, at[:, None]), np.broadcast_to(turn, (2, 3, at.shape[1], 3))], axis=-1)

    np.testing.assert_allclose(blended(points, interfaces, rigid(interfaces)), rigid(points), atol=1e-12)
    step = 1e-6 * np.eye(3)
    slopes = [
        (blended(points + h, interfaces, twists) - blended(points - h, interfaces, twists))[..., :3] / 2e-6 for h in step
    ]  # [derivative][component]
    curl = [slopes[j][..., k] - slopes[k][..., j] for j, k in ((1, 2), (2, 0), (0, 1))]
    np.testing.assert_allclose(blended(points, interfaces, twists)[..., 3:], np.stack(curl, axis=-1) / 2, atol=1e-6)
    tip = np.array([[0.0, 0, 0, 0, 0, 0], [0, 0, 1, 0, -1.5 / LENGTH, 0]])[None, None]
    ends = np.array([[[0.0, 0, 0], [LENGTH, 0, 0]]])
    np.testing.assert_allclose(blended(ends.mean(axis=1, keepdims=True), ends, tip)[0, 0, 0, 2], 5 / 16, rtol=1e-9)


@pytest.mark.parametrize("is_meshed", [True, False])
def test_links_are_drawn_bent(tmp_path, is_meshed):
    """Near its ends and in its middle a link is drawn as the beam whose matrices it has, within 1 % of the largest motion."""
    box = trimesh.creation.box((LENGTH, 0.06, 0.02)).subdivide_to_size(0.01)
    box.apply_translation((LENGTH / 2, 0, 0))
    box.export(tmp_path / "arm.stl")
    visual = f'<visual><geometry><mesh filename="{tmp_path}/arm.stl"/></geometry></visual>' if is_meshed else ""
    machine = cantilever(visual)
    flexible, beam = (ks.analyze(one.assemble(), [0, 0, -200, 0, 0, 0]) for one in (with_flexible(machine), machine))
    scene = describe_scene(flexible)
    mesh, still = mesh_of(scene, "arm"), Still(scene)
    assert mesh.roots == ("Rest", "Deformed") and len(np.unique(mesh.station)) > 20
    rest, bent = (still.vertices(mesh, root) for root in mesh.roots)
    if is_meshed:
        assert np.abs(np.ptp(rest, axis=0) - [LENGTH, 0.06, 0.02]).max() < 1e-6
    line = beam.beams["arm"].deflections[:, 2] * scene.exaggeration
    stations = np.linspace(0, LENGTH, len(line))
    for part in (0.0, 0.5, 1.0):
        near = np.abs(rest[:, 0] - part * LENGTH) < 2e-3
        across = (bent - rest)[near, 2]
        assert np.abs(across - np.interp(rest[near, 0], stations, line)).max() < 0.01 * np.abs(line).max()
    colours = still.deflections[mesh.path]
    assert colours.max() == pytest.approx(np.linalg.norm(flexible.twist[:3]), rel=0.02)


# ---- surfaces with recovery ------------------------------------------------------------------------------------------------

E, RHO, D, STEEL = 2e11, 7800.0, 0.03, 'density="7800" youngs_modulus="2e11" poisson_ratio="0.3" shear_coefficient="inf"'
AROUND = np.array([[0, 0.01, 0], [0, -0.005, 0.01], [0, -0.005, -0.01]])


def sections(x):
    """Return twists (6, 15) of a section of a beam along x, exact under loads at its ends and under its weight, and its strains.

    The columns are the twists of the ends, then internal coordinates: deflections x²(L − x)² across, and x (L − x) along.
    """
    L, hermite = LENGTH, np.polynomial.Polynomial
    twists, strains = np.zeros((6, 15)), np.zeros((4, 15))
    along = hermite([1, -1 / L]), hermite([0, 1 / L])
    across = hermite([1, 0, -3 / L**2, 2 / L**3]), hermite([0, 1, -2 / L, 1 / L**2])
    across += hermite([0, 0, 3 / L**2, -2 / L**3]), hermite([0, 0, -1 / L, 1 / L**2])
    for end in (0, 1):
        for row in (0, 3):
            twists[row, 6 * end + row], strains[row // 3, 6 * end + row] = along[end](x), along[end].deriv()(x)
    twists[0, 14], strains[0, 14] = x * (L - x) / L**2, (L - 2 * x) / L**2
    columns = [(1, 0, 1), (5, 1, 1), (7, 2, 1), (11, 3, 1), (2, 0, -1), (4, 1, -1), (8, 2, -1), (10, 3, -1)]
    bubble = hermite([0, 0, L**2, -2 * L, 1]) * 16 / L**4
    pairs = [(column, across[k], sign) for column, k, sign in columns] + [(12, bubble, 1), (13, bubble, -1)]
    for column, shape, sign in pairs:
        moved, turned = (1, 5) if sign > 0 else (2, 4)
        factor = -1 if column in (4, 10) else 1
        twists[moved, column], twists[turned, column] = factor * shape(x), factor * sign * shape.deriv()(x)
        strains[moved + 1, column] = factor * shape.deriv(2)(x)
    return twists, strains


def recovered_beam(turn, shift):
    """Return the matrices of this beam with its surface; the interfaces have axes ``turn`` and are displaced by ``shift``."""
    area, bending, gauss, weights = np.pi / 4 * D**2, np.pi / 64 * D**4, *np.polynomial.legendre.leggauss(8)
    K, M = np.zeros((2, 15, 15))
    for x, weight in zip((gauss + 1) / 2 * LENGTH, weights / 2 * LENGTH, strict=True):
        twists, strains = sections(x)
        K += weight * strains.T @ np.diag([E * area, E / 1.3 * bending, E * bending, E * bending]) @ strains
        M += weight * RHO * area * twists[:3].T @ twists[:3]
    along = np.linspace(0, LENGTH, 21)
    each = [
        twists[:3] + np.cross(twists[3:], arm, axis=0) for twists in (sections(x)[0] for x in along) for arm in AROUND[:, :, None]
    ]
    points = np.array([np.array([x, 0, 0]) + arm for x in along for arm in AROUND])
    triangles = np.array([[k, k + 1, k + 3] for k in range(60)])
    T = np.eye(15)
    T[:6, :6] = T[6:12, 6:12] = np.block([[turn, -skew(-shift) @ turn], [np.zeros((3, 3)), turn]])
    origins = np.array([[0, 0, 0], [LENGTH, 0, 0]]) + shift
    matrices = dict(stiffness=T.T @ K @ T, mass=T.T @ M @ T, rotations=turn, recovery=np.array(each) @ T)
    return LinkMatrices(("foot", "tip"), origins, **matrices, points=points, triangles=triangles)


@pytest.mark.parametrize("gravity", [(0, 0, -9.8), (3, -4, 5)])
def test_surface_is_displaced_as_the_beam(gravity):
    """Under loads and its weight, each alone, at a pose at which the link is turned."""
    beam = cantilever(material=STEEL)
    turn, shift = exponential(np.array([0.3, -0.5, 0.7])), np.array([0.01, 0.02, -0.03])
    flexible = ks.Robot(replace(beam.description, beams={}, flexible={"arm": Flexible("arm", recovered_beam(turn, shift))}))
    found, expected = (ks.analyze(robot.configuration([0.4]), [10, 20, -200, 3, 4, 5], gravity) for robot in (flexible, beam))
    line, scene = expected.beam_contributions["arm"], describe_scene(found)
    mesh, R = mesh_of(scene, "arm"), expected.configuration.frame("arm")[:3, :3]
    arms, (_, along) = AROUND @ R.T, expected.centre_lines["arm"]
    points = (along[:, None] + arms).reshape(-1, 3)
    for k, name in enumerate(found.contributions):
        twists = line[name]
        right = (twists[:, None, :3] + np.cross(twists[:, None, 3:], arms)).reshape(-1, 3)
        share = np.eye(len(found.contributions))[k]
        rest, bent = (
            Still(replace(scene, exaggeration=1.0)).vertices_at(mesh, scene.stations.moved(0, part, share)) for part in (0, 1)
        )
        drawn = np.linalg.norm(rest[:, None] - points, axis=2).argmin(axis=1)  # points at edges are drawn more than once
        assert set(drawn) == set(range(len(points)))
        right = right[drawn]
        np.testing.assert_allclose(bent - rest, right, rtol=0, atol=1e-8 * np.abs(right).max() + 1e-15)


def test_surface_vibrates_between_the_ends():
    """In the sixth mode the middle moves most, by the internal coordinates; three of them leave an error of one per cent."""
    beam = cantilever(material=STEEL)
    flexible = ks.Robot(
        replace(beam.description, beams={}, flexible={"arm": Flexible("arm", recovered_beam(np.eye(3), np.zeros(3)))})
    )
    lines, drawn = (ModePoses(ks.modes(robot.configuration([0.4]), 6)) for robot in (beam, flexible))
    scene = describe_scene(drawn)
    rotations, twists = np.stack(scene.stations.rest)[:, 0, :3, :3], scene.stations.all_twists[0, :, 5]
    at_middle = np.abs(mesh_of(scene, "arm").surface.vertices[:, 0] - LENGTH / 2) < 1e-9
    middle = mesh_of(scene, "arm").displacements(rotations, twists)[at_middle].mean(axis=0)
    found = np.linalg.norm(middle) / np.linalg.norm(twists[scene.readout, 3:])
    expected = np.linalg.norm(lines.beam_twists("arm")[0, 5, 10, :3]) / np.linalg.norm(lines.platform_twist[0, 5, 3:])
    assert found == pytest.approx(expected, rel=0.03)
    without = replace(mesh_of(scene, "arm"), recovery=mesh_of(scene, "arm").recovery * (np.arange(18) < 12))
    assert np.linalg.norm(without.displacements(rotations, twists)[at_middle].mean(axis=0)) < 0.2 * np.linalg.norm(middle)


@pytest.mark.browser
def test_page_moves_and_colours_surfaces(tmp_path, visit):
    """As the picture in numbers does, at both poses of a path; a click on the link names it."""
    robot = cantilever(material=STEEL)
    flexible = ks.Robot(
        replace(robot.description, beams={}, flexible={"arm": Flexible("arm", recovered_beam(np.eye(3), np.zeros(3)))})
    )
    result = ks.analyze(flexible.configuration([[0.4], [0.5]]), [10, 20, -200, 3, 4, 5])
    ks.save_html(result, tmp_path / "arm.html")
    page = visit((tmp_path / "arm.html").as_uri())
    for k in (1, 0):
        move(page, "path", k)
        still = Still(replace(describe_scene(result, pose=k), exaggeration=page.evaluate("robot_page.state.exaggeration")))
        mesh = mesh_of(still.scene, "arm")
        for root in mesh.roots:
            np.testing.assert_allclose(vertices(page, f"{root}/links/arm"), still.vertices(mesh, root), atol=2e-6)
    most = page.evaluate("robot_page.robots[0].largestDisplacement()")
    assert most == pytest.approx(still.largest[0], rel=1e-5) and still.largest[1].path == "links/arm"
    page.evaluate("robot_page.selectPath('links/arm')")
    assert "elastic link" in page.inner_text("#robot-card") and "NaN" not in page.inner_text("#robot-card")


@needs_node
def test_page_computes_what_displaces_surfaces():
    """Twists of ends and internal coordinates, after the actuator has moved and gravity has turned."""
    beam = cantilever(material=STEEL)
    matrices = recovered_beam(np.eye(3), np.zeros(3))
    flexible = ks.Robot(replace(beam.description, beams={}, flexible={"arm": Flexible("arm", matrices)}))
    given = {"load": [10, 20, -200, 3, 4, 5], "gravity": [2, -3, -8], "payload": [2.0, 0, 0, 0.1]}
    script = """machine.loads = given; machine.move("actuators", { foot: 0.5 });
      return { scene: sceneOf(machine, given.size) };"""
    start = ks.analyze(flexible.configuration([0.4]))
    (answer,) = answers(start, [(script, given | {"size": describe_scene(start).size})])
    payload = ks.Payload(given["payload"][0], given["payload"][1:])
    scene = describe_scene(ks.analyze(flexible.configuration([0.5]), given["load"], given["gravity"], payload=payload))
    mesh, expected = mesh_of(scene, "arm"), scene.stations.all_twists[0]
    found = np.reshape(answer["scene"]["stations"]["twist"], (-1, *expected.shape[1:]))
    first, count = mesh.station[0], mesh.recovery.shape[2] // 6
    assert answer["scene"]["contributions"] == list(scene.stations.contribution_names) and count == 3
    for number in range(first + 1, first + count):
        size = np.abs(expected[number]).max()
        assert size > 0 and relative(found[number], expected[number], size) < 1e-9


def test_stations_of_links_without_surface_are_the_same_at_all_poses():
    """A page computes their twists in an order that is found at another pose; sticks had radii by the robot's size there."""
    description = ks.load_robot(FOLDER / "3rps_plate.urdf").description
    bare = {name: part.matrices for name, part in description.flexible.items()}
    bare = {name: replace(matrices, points=None, triangles=None, recovery=None) for name, matrices in bare.items()}
    flexible = {name: replace(part, matrices=bare[name]) for name, part in description.flexible.items()}
    robot = ks.Robot(replace(description, flexible=flexible))
    scenes = [describe_scene(ks.analyze(robot.assemble(platform={"z": z, "rx": 0.1, "ry": 0.05}))) for z in (0.5, 0.57)]
    assert scenes[0].size != scenes[1].size and len(scenes[0].stations.rest) == len(scenes[1].stations.rest)
