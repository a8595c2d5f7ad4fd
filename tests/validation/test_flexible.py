"""Links by their matrices, ``<flexible>``: against beams, with internal coordinates, and as files."""

from dataclasses import replace

import numpy as np
import pytest
from matrix_link import as_matrices, with_flexible
from simple_machines import BEAM, CIRCLE, joint, link
from simple_machines import robot as robot_of

import kinetostatics as ks
from kinetostatics.cli.main import main
from kinetostatics.description import Flexible, LinkMatrices
from kinetostatics.description.elements import Inertia
from kinetostatics.files.reader import read_robot_file
from kinetostatics.workspace.sweep_plan import files_of, text_digest

LOAD, GRAVITY, LENGTH, EXPANSION = [10.0, -20.0, -300.0, 4.0, 5.0, 6.0], (0.5, 0.3, -9.81), 0.8, 1.2e-5


def _parts(length=LENGTH, *more, beam=True):
    parts = [link("base"), link("arm", 0.0 if beam else 9.0, "0.3 0 0"), link("platform", 4.0, "0.1 0.02 0.03")]
    parts += [joint("shoulder", "revolute", "base", "arm"), joint("wrist", "fixed", "arm", "platform", f"{length} 0 0")]
    parts += [f'<beam link="arm" density="7850" thermal_expansion="{EXPANSION}" {BEAM}>{CIRCLE}</beam>'] * beam
    return [*parts, '<transmission name="t"><joint name="shoulder"/></transmission>', *more]


def _arm(length=LENGTH):
    return robot_of(*_parts(length))


def _in_pieces(count):
    """Return stiffness and mass (6 (count + 1), …) of the arm's beam in equal pieces, exact in static deformations."""
    piece = _arm(LENGTH / count)
    parts = as_matrices(piece, "arm", piece.zero_frames)
    whole = np.zeros((2, 6 * count + 6, 6 * count + 6))
    for k in range(count):
        whole[:, 6 * k : 6 * k + 12, 6 * k : 6 * k + 12] += parts
    return whole


def _craig_bampton(modes, count=16, **more):
    """Return the arm's beam with the lowest fixed-interface modes as internal coordinates."""
    K, M = _in_pieces(count)
    ends = [*range(6), *range(6 * count, 6 * count + 6)]
    inner = list(range(6, 6 * count))
    shapes = np.zeros((len(K), 12 + modes))
    shapes[ends, :12] = np.eye(12)
    shapes[inner, :12] = -np.linalg.solve(K[np.ix_(inner, inner)], K[np.ix_(inner, ends)])
    root = np.linalg.inv(np.linalg.cholesky(M[np.ix_(inner, inner)]))
    shapes[inner, 12:] = root.T @ np.linalg.eigh(root @ K[np.ix_(inner, inner)] @ root.T)[1][:, :modes]
    K, M = shapes.T @ K @ shapes, shapes.T @ M @ shapes
    return LinkMatrices(("shoulder", "wrist"), [[0, 0, 0], [LENGTH, 0, 0]], K, M, **more)


def _with(matrices, robot=None, **more):
    description = (robot or _arm()).description
    return ks.Robot(replace(description, beams={}, flexible={"arm": Flexible("arm", matrices, **more)}))


def test_uniform_beam_in_every_result():
    """Statics to 1e-10; strain energy and stress inside the link are not among what its matrices say."""
    robot = ks.load_robot("linear_delta")
    results = [ks.analyze(each.assemble(), load=LOAD, gravity=GRAVITY) for each in (with_flexible(robot), robot)]
    for name in ("twist", "compliance", "stiffness", "base_wrench"):
        found, expected = (getattr(result, name) for result in results)
        assert np.abs(found - expected).max() < 1e-10 * np.abs(expected).max(), name
    for name in ("actuator_forces", "joint_wrenches", "contributions"):
        found, expected = (getattr(result, name) for result in results)
        largest = max(np.abs(value).max() for value in expected.values())
        assert list(found) == list(expected)
        assert max(np.abs(found[key] - expected[key]).max() for key in expected) < 1e-10 * largest, name


def test_inertial_loads():
    """Accelerations load a link as they load the beam; velocities load the rest of the robot so, by the same resultants."""
    robot = ks.load_robot("linear_delta")
    poses = [each.assemble() for each in (with_flexible(robot), robot)]
    accelerations = {"x": 3.0, "y": -2.0, "z": 5.0}
    for velocities in ({}, {"x": 2.0, "y": 1.0, "z": -1.5}):
        motion = ks.Motion(velocities=velocities, accelerations=accelerations)
        found, expected = (ks.analyze(pose, load=LOAD, gravity=GRAVITY, motion=motion) for pose in poses)
        largest = max(np.abs(force).max() for force in expected.actuator_forces.values())
        assert all(
            np.abs(found.actuator_forces[name] - expected.actuator_forces[name]) < 1e-9 * largest for name in poses[1].actuators
        )
        tolerance = 1e-3 if velocities else 1e-9
        assert np.abs(found.twist - expected.twist).max() < tolerance * np.abs(expected.twist).max()
        assert np.abs(found.contributions["inertia"]).max() > 1e-2 * np.abs(found.twist).max()


@pytest.mark.parametrize("modes", [0, 6])
def test_internal_coordinates_do_not_change_statics(modes):
    thermal = _craig_bampton(modes)
    heat = np.zeros(12 + modes)
    heat[0], heat[6] = thermal.stiffness[0, 6] * EXPANSION * LENGTH, -thermal.stiffness[0, 6] * EXPANSION * LENGTH
    link_ = _craig_bampton(modes, thermal=heat)
    errors = {"assembly_errors": {"arm": {"temperature": 30.0}}, "load": LOAD, "gravity": GRAVITY}
    found, expected = (ks.analyze(robot.assemble(actuators={"shoulder": 0.4}), **errors) for robot in (_with(link_), _arm()))
    assert np.abs(found.twist / expected.twist - 1).max() < 1e-9
    assert np.abs(found.contributions["assembly_errors"]).max() > 1e-4
    softer = ks.analyze(_with(link_, stiffness_factor=0.5).assemble(actuators={"shoulder": 0.4}), **errors)
    elastic = ("load", "limb_1", "platform_weight")
    for name in elastic:
        assert softer.contributions[name] == pytest.approx(2 * found.contributions[name], rel=1e-12)
    assert softer.contributions["assembly_errors"] == pytest.approx(found.contributions["assembly_errors"], rel=1e-12)


def test_modes_converge_to_those_of_the_exact_rod():
    """With more fixed-interface modes, also below the requested frequencies, all frequencies converge from above."""
    exact = ks.modes(_arm().assemble(), 12).frequencies
    before = None
    for modes in (0, 6, 20, 60):
        found = ks.modes(_with(_craig_bampton(modes)).assemble(), 12).frequencies[: 6 + modes]
        error = found / exact[: len(found)] - 1
        assert np.all(error > -1e-9)
        if before is not None:
            assert np.all(error[: len(before)] < before + 1e-12)
        before = error
    assert error.max() < 1e-3 and error[:4].max() < 1e-5


def test_response_and_participation():
    """Masses and responses with internal coordinates are those of the rod."""
    pose, rod = _with(_craig_bampton(40)).assemble(), _arm().assemble()
    first, second = (ks.modes(each, 3) for each in (pose, rod))
    assert first.effective_masses == pytest.approx(second.effective_masses, rel=1e-4, abs=1e-6)
    for shares in ("kinetic_energy_shares", "strain_energy_shares"):
        found, expected = (getattr(item, shares) for item in (first, second))
        assert [name.replace("flexible", "beam") for name in found] == list(expected)
        for name, values in expected.items():
            assert found[name.replace("beam", "flexible")] == pytest.approx(values, rel=1e-4, abs=1e-9)
    frequencies = [3.0, 0.7 * second.frequencies[1], 1.3 * second.frequencies[1]]
    found, expected = (ks.frequency_response(each, frequencies, damping=0.01) for each in (pose, rod))
    for name in ("compliance", "transmissibility"):
        values = getattr(expected, name)
        assert np.abs(getattr(found, name) - values).max() < 1e-4 * np.abs(values).max()


def test_body_of_the_inertial_without_mass():
    """Without a mass matrix the body of the ``<inertial>`` rides on the mean of both ends."""
    K = _craig_bampton(0).stiffness
    machine = robot_of(*_parts(LENGTH, beam=False))
    inertia = Inertia((0.02, 0.0, 0.0, 0.3, 0.0, 0.3))
    description = machine.description.changed("arm", inertia=inertia)
    matrices = LinkMatrices(("shoulder", "wrist"), [[0, 0, 0], [LENGTH, 0, 0]], K)
    robot = _with(matrices, ks.Robot(description))
    assert not robot.warnings
    assert robot.weights.masses(robot.zero_frames).sum() == pytest.approx(13.0)
    ride = np.hstack([np.eye(6), np.eye(6)]) / 2
    ride[0:3, 9:12] = np.array([[0, 0, 0], [0, 0, -LENGTH], [0, LENGTH, 0]]) / 2  # of the end's motion at the start
    arm = np.array([[0, 0, 0], [0, 0, -0.3], [0, 0.3, 0]])
    body = np.block([[9 * np.eye(3), -9 * arm], [9 * arm, inertia.matrix - 9 * arm @ arm]])
    explicit = LinkMatrices(matrices.names, matrices.origins, K, ride.T @ body @ ride)
    other = _with(explicit, ks.Robot(description))
    assert ks.modes(robot.assemble(), 6).frequencies == pytest.approx(ks.modes(other.assemble(), 6).frequencies, rel=1e-9)
    first, second = (ks.analyze(each.assemble(), gravity=GRAVITY).twist for each in (robot, other))
    assert first == pytest.approx(second, rel=1e-9)


def test_difference_from_the_inertial_is_a_warning():
    machine = robot_of(*_parts(LENGTH, beam=False))
    robot = _with(_craig_bampton(2), machine)
    said = [warning for warning in robot.warnings if "matrices" in warning]
    assert len(said) == 3
    assert said[0] == ("<python>: flexible 'arm': the mass is 12.3308 kg by its matrices, but 9 kg is given; the matrices count.")
    nothing = ks.Robot(
        replace(_arm().description, beams={}, flexible={}).with_part(
            Flexible("arm", LinkMatrices(("shoulder", "wrist"), [[0, 0, 0], [LENGTH, 0, 0]], _craig_bampton(0).stiffness))
        )
    )
    assert any("has no mass matrix and its link no <inertial>; it weighs nothing" in warning for warning in nothing.warnings)


def test_factor_of_the_stiffness_is_calibrated():
    change = np.linspace(-0.03, 0.03, 6)
    force, gauges = np.linspace(-2000, 2000, 6), {"front": ks.Gauge((0, 0, 1), (0.3, 0.1, 0.5))}
    robot, true = with_flexible(ks.load_robot("linear_delta")), {"rod_1": 0.8, "rod_2": 1.1}
    description = robot.description
    for name, factor in true.items():
        description = description.changed(name, stiffness_factor=factor)
    zero = {name: float(robot.assemble().platform[name]) for name in "xyz"}
    at = {"x": zero["x"] + change, "y": zero["y"] + 30 * change**2, "z": zero["z"] + 20 * change**2}
    load = np.outer(force, [0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
    pose = ks.Robot(description).assemble(platform=at)
    twist = ks.analyze(pose, load).twist
    o = np.stack([pose.platform[name] for name in "xyz"], axis=-1)
    front = (twist[:, :3] + np.cross(twist[:, 3:], np.array([0.3, 0.1, 0.5]) - o))[:, 2]
    fit = ks.calibrate(robot, {**at, "Fz": force, "front": front}, list(true), gauges=gauges)
    assert {name: estimate.value for name, estimate in fit.estimates.items()} == pytest.approx(true, rel=1e-7)


# ---- files ---------------------------------------------------------------------------------------------------------------

FLEXIBLE = '<flexible link="arm" file="parts/arm.npz" stiffness_factor="0.9"/>'


def _file(tmp_path, element=FLEXIBLE, matrices=None):
    (tmp_path / "parts").mkdir(exist_ok=True)
    ks.files.save_link(matrices or _craig_bampton(4), tmp_path / "parts" / "arm.npz")
    text = f'<robot name="r">{"".join(_parts(LENGTH, element, beam=False))}<platform link="platform"/></robot>'
    (tmp_path / "robot.urdf").write_text(text)
    return tmp_path / "robot.urdf"


def test_file_is_as_python(tmp_path, capsys):
    robot = ks.load_robot(_file(tmp_path))
    made = _with(_craig_bampton(4), robot, stiffness_factor=0.9)
    assert robot.description == made.description
    first, second = (ks.analyze(each.assemble(), load=LOAD).twist for each in (robot, made))
    assert np.array_equal(first, second)
    assert any(name.endswith("arm.npz") for name in files_of(robot.description))
    assert text_digest(robot.description) != text_digest(_with(_craig_bampton(5), robot, stiffness_factor=0.9).description)
    assert main(["check", str(tmp_path / "robot.urdf")]) == 0
    shown = capsys.readouterr().out
    assert "1 flexible link" in shown and "shoulder and wrist" in shown and "12.33" in shown
    assert main(["analyze", str(tmp_path / "robot.urdf"), "--load", "0", "0", "-100", "0", "0", "0"]) == 0
    assert "nothing is elastic" not in capsys.readouterr().err


def test_writing_refers_to_the_matrices_or_writes_them(tmp_path):
    robot = ks.load_robot(_file(tmp_path))
    (tmp_path / "out").mkdir()
    ks.save_robot(robot, tmp_path / "out" / "same.urdf")
    assert 'file="../parts/arm.npz"' in (tmp_path / "out" / "same.urdf").read_text()
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["same.urdf"]
    other = _with(_craig_bampton(5), robot, stiffness_factor=0.9)
    ks.save_robot(other, tmp_path / "out" / "other.urdf")
    changed = robot.description.changed("arm", matrices=_craig_bampton(5))
    ks.save_robot(changed, tmp_path / "out" / "changed.urdf")
    for name in ("other", "changed"):
        again = read_robot_file(tmp_path / "out" / f"{name}.urdf")
        assert again.flexible == other.description.flexible
        assert (tmp_path / "out" / f"{name}_arm.npz").exists()
    assert read_robot_file(tmp_path / "out" / "same.urdf") == robot.description


@pytest.mark.parametrize(
    ("element", "said"),
    [
        (FLEXIBLE.replace("arm.npz", "leg.npz"), r"robot\.urdf:1: <flexible> .*parts/leg\.npz: not readable: No such file"),
        (
            FLEXIBLE.replace('link="arm"', 'link="platform"'),
            "the interface 'shoulder' is no joint of link 'platform', which has wrist",
        ),
        (FLEXIBLE.replace('link="arm"', 'link="leg"'), "refers to the link 'leg', which does not exist; known: "),
        (FLEXIBLE.replace("file", "path"), "'path' is not an attribute of <flexible>"),
        (FLEXIBLE.replace("0.9", "-1"), "stiffness_factor='-1' of <flexible> of link 'arm' must be greater than zero"),
        (FLEXIBLE * 2, "the flexible link name 'arm' is taken already, in .*robot.urdf:1"),
        (FLEXIBLE + FLEXIBLE.replace("link", 'name="again" link'), "the link 'arm' is elastic already by 'again', in "),
        (FLEXIBLE + f'<beam link="arm" density="1" {BEAM}>{CIRCLE}</beam>', "is elastic already by 'arm', in"),
        (
            FLEXIBLE + link("tool") + joint("mount", "fixed", "arm", "tool"),
            "the joint 'mount' of link 'arm' is no interface; the interfaces are shoulder and wrist",
        ),
    ],
)
def test_wrong_elements_are_refused(tmp_path, element, said):
    path = _file(tmp_path, element)
    with pytest.raises(ks.RobotFileError, match=said):
        ks.load_robot(path)


def test_wrong_interfaces_are_refused(tmp_path):
    own = _craig_bampton(0)
    path = _file(tmp_path, matrices=replace(own, names=("shoulder", "elbow")))
    with pytest.raises(ks.RobotFileError, match="the interface 'elbow' is no joint of link 'arm', which has shoulder and wrist"):
        ks.load_robot(path)
    with pytest.raises(ks.RobotFileError, match="matrices=None of flexible 'arm' is not of the type LinkMatrices"):
        Flexible("arm", None)
