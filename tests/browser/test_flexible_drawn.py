"""Links by their matrices in the scene: their interfaces move as in the result, and the surface between them bends smoothly."""

import numpy as np
import pytest
import trimesh
from hub_robots import hub_robot
from matrix_link import with_flexible
from simple_machines import joint, link
from simple_machines import robot as robot_of

import kinetostatics as ks
from kinetostatics.viewer.drawn_poses import ShownPoses, blended
from kinetostatics.viewer.scene import describe_scene
from kinetostatics.viewer.single_poses import ModePoses, UnloadedPose
from kinetostatics.viewer.still import Still

LENGTH, BEAM = 0.4, 'density="0" youngs_modulus="2e11" poisson_ratio="0.3" shear_coefficient="inf"'


def cantilever(visual="", actuator='<transmission name="t"><joint name="foot"/></transmission>'):
    parts = [link("base"), f'<link name="arm">{visual}</link>', link("platform", 3.0), actuator]
    parts += [joint("foot", "revolute", "base", "arm"), joint("tip", "fixed", "arm", "platform", f"{LENGTH} 0 0")]
    return robot_of(*parts, f'<beam link="arm" from="foot" to="tip" {BEAM}><circle diameter="0.03"/></beam>')


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
