"""State-space models: static gain of the analysis, frequency response of the dynamic stiffness, names and files."""

import json

import control
import numpy as np
import package_robots
import pytest
from scipy.io import loadmat
from simple_machines import two_columns
from sprung_robots import bundled

import kinetostatics as ks
from kinetostatics.cli.main import main
from kinetostatics.description import JointStiffness


def response(model, frequency):
    s = 2j * np.pi * frequency
    return model.C @ np.linalg.solve(s * np.eye(len(model.A)) - model.A, model.B) + model.D


@pytest.fixture(scope="module")
def pose():
    return package_robots.robot("3rps").assemble(platform={"z": 0.5, "rx": 0.1, "ry": -0.05})


@pytest.mark.parametrize("damping", [0.0, {"mass": 3.0, "stiffness": 1e-5}])
def test_model_of_all_modes_has_the_exact_frequency_response(damping):
    """A platform on massless columns has six modes; its damping is proportional."""
    columns = two_columns().assemble()
    frequencies = np.geomspace(0.5, 2000, 200)
    model = ks.modes(columns, 6).state_space(damping=damping)
    exact = ks.frequency_response(columns, frequencies, damping=damping).compliance
    scale = np.abs(exact).max(axis=(1, 2))
    for k, frequency in enumerate(frequencies):
        assert np.abs(response(model, frequency) - exact[k]).max() < 1e-8 * scale[k]


@pytest.mark.parametrize("count", [1, 4, 12])
def test_static_gain_is_the_compliance_with_any_number_of_modes(pose, count):
    model = ks.modes(pose, count).state_space()
    gain = response(model, 0.0).real
    C = ks.analyze(pose).compliance
    np.testing.assert_allclose(gain, C, atol=1e-10 * np.abs(C).max())


@pytest.mark.few(4)
@pytest.mark.parametrize("name", package_robots.NAMES)
def test_static_gain_is_the_compliance_of_every_robot(name):
    """Also where motions, such as the spin of struts, have no stiffness."""
    pose = package_robots.robot(name).assemble()
    C = ks.analyze(pose).compliance
    gain = response(ks.modes(pose, 3).state_space(), 0.0).real
    np.testing.assert_allclose(gain, C, atol=1e-10 * np.abs(C).max())


@pytest.mark.parametrize("name", ["five_bar", "3rps", "gough_stewart"])
def test_static_gain_has_the_geometric_stiffness_of_springs(name):
    pose = bundled(name, 3, rigid=False)
    C = ks.analyze(pose).compliance
    places = "o", pose.robot.description.actuated[0]
    model = ks.modes(pose, 3).state_space(places, places)
    gain = response(model, 0.0).real
    np.testing.assert_allclose(gain[:6, :6], C, atol=1e-10 * np.abs(C).max())
    np.testing.assert_allclose(gain, gain.T, atol=1e-10 * np.abs(gain).max())


def test_forces_and_displacements_of_links_are_reciprocal(pose):
    model = ks.modes(pose, 8).state_space(inputs=("o", "cylinder_1"), outputs=("o", "cylinder_1"))
    gain = response(model, 0.0).real
    assert gain.shape == (12, 12)
    np.testing.assert_allclose(gain, gain.T, atol=1e-12 * np.abs(gain).max())
    loaded = ks.analyze(pose, gravity=(0, 0, 0), loads={"cylinder_1": [30.0, -20.0, 10.0, 1.0, 2.0, 3.0]})
    np.testing.assert_allclose(gain[:6, 6:] @ [30.0, -20.0, 10.0, 1.0, 2.0, 3.0], loaded.twist, rtol=1e-9, atol=1e-16)


@pytest.mark.parametrize("count", [2, 6])
def test_left_out_modes_have_the_stated_bound(pose, count):
    """A mode left out at f_k has φ²/ω_k² in the feedthrough D, instead of φ²/(ω_k² − ω²): with r = f/f_k, D r²/(1 − r²) less."""
    model = ks.modes(pose, count).state_space(damping=0.0)
    following = ks.modes(pose, count + 1).frequencies[-1]
    frequencies = np.linspace(0.01, 0.95, 200) * following
    exact = ks.frequency_response(pose, frequencies, damping=0.0).compliance
    for k, frequency in enumerate(frequencies):
        square, own = (frequency / following) ** 2, response(model, frequency).diagonal()
        bound = model.D.diagonal() * square / (1 - square)
        assert np.all(np.abs(own - exact[k].diagonal()) <= bound * (1 + 1e-6) + 1e-9 * np.abs(exact[k]).max())


def test_more_modes_are_nearer_to_the_frequency_response(pose):
    """Between the kept modes the residual flexibility leaves an error that decreases with their number."""
    exact = ks.frequency_response(pose, [100.0], damping=0.0).compliance[0]
    errors = [np.abs(response(ks.modes(pose, count).state_space(damping=0.0), 100.0) - exact).max() for count in (3, 6, 12, 24)]
    assert errors == sorted(errors, reverse=True) and errors[-1] < 1e-5 * np.abs(exact).max()


@pytest.mark.parametrize("damping", [0.0, {"mass": 3.0, "stiffness": 1e-5}])
def test_floor_moves_the_platform_as_in_the_exact_transmissibility(damping):
    """Motions u of the floor have the acceleration −ω² u; the platform moves by (T − 1) u relative to the floor."""
    columns = two_columns().assemble()
    frequencies = np.geomspace(0.5, 2000, 200)
    model = ks.modes(columns, 6).state_space(inputs=("acceleration of floor",), damping=damping)
    assert model.inputs[0] == "x of acceleration of floor [m/s²]" and model.inputs[5] == "rz of acceleration of floor [rad/s²]"
    T = ks.frequency_response(columns, frequencies, damping=damping).transmissibility
    for k, frequency in enumerate(frequencies):
        exact = (T[k] - np.eye(6)) / -((2 * np.pi * frequency) ** 2)
        assert np.abs(response(model, frequency) - exact).max() < 1e-8 * np.abs(exact).max()


@pytest.mark.parametrize("count", [2, 12])
def test_static_gain_of_the_floor_is_the_sag_under_opposite_gravity(pose, count):
    model = ks.modes(pose, count).state_space(inputs=("acceleration of floor",), outputs=("o", "cylinder_2"))
    gain = response(model, 0.0).real
    for k, axis in enumerate(np.eye(3)):
        sag = ks.analyze(pose, gravity=-axis)
        cylinder = sum(sag.link_contributions["cylinder_2"].values())
        np.testing.assert_allclose(gain[:, k], [*sag.twist, *cylinder], rtol=1e-9, atol=1e-10 * np.abs(gain).max())


def test_turning_floor_has_the_response_of_the_rods(pose):
    """Far below the first frequency, 115 Hz, twelve modes and the residual stand for all of them."""
    model = ks.modes(pose, 12).state_space(inputs=("acceleration of floor",), damping=0.0)
    T = ks.frequency_response(pose, [20.0], damping=0.0).transmissibility[0].real
    exact = (T - np.eye(6)) / -((2 * np.pi * 20.0) ** 2)
    np.testing.assert_allclose(response(model, 20.0).real, exact, atol=1e-6 * np.abs(exact).max())


@pytest.fixture(scope="module")
def driven():
    """An overconstrained robot with elastic actuators; the third one is within a telescopic rod."""
    description = package_robots.robot("2pru_upr").description
    for name, stiffness in {"prismatic_1": 2e6, "prismatic_2": 3e6, "prismatic_3": 5e6}.items():
        description = description.with_part(JointStiffness(name, drive=stiffness))
    return ks.Robot(description).assemble(platform={"z": 0.6, "rx": -0.1, "ry": 0.2}, orientation="XYZ")


def test_force_of_an_actuator_is_a_load_on_its_slider(driven):
    """The rail is the actuator's other side."""
    model = ks.modes(driven, 9).state_space(inputs=("prismatic_1",), outputs=("o", "prismatic_1", "slider_2"))
    assert model.inputs == ("force of prismatic_1 [N]",) and model.outputs[6] == "displacement of prismatic_1 [m]"
    pushed = ks.analyze(driven, gravity=(0, 0, 0), loads={"slider_1": ks.LinkLoad([*axis_of(driven, "prismatic_1"), 0, 0, 0])})
    slider = {name: sum(pushed.link_contributions[name].values()) for name in ("slider_1", "slider_2")}
    expected = [*pushed.twist, axis_of(driven, "prismatic_1") @ slider["slider_1"][:3], *slider["slider_2"]]
    gain = response(model, 0.0).real[:, 0]
    np.testing.assert_allclose(gain, expected, rtol=1e-9, atol=1e-10 * np.abs(gain).max())


def axis_of(pose, name):
    """Return the axis of an actuator that joins a link to the base, world axes."""
    before, after = (pose.robot.assemble(actuators={**pose.actuators, name: pose.actuators[name] + step}) for step in (0.0, 1e-3))
    moved = (after.frames.point(after.robot.mechanism.body_of["slider_1"][0], np.zeros((3, 1))) for after in (before, after))
    start, end = (point[:, 0] for point in moved)
    return (end - start) / np.linalg.norm(end - start)


@pytest.mark.few(4)
@pytest.mark.parametrize("name", package_robots.NAMES)
def test_actuators_move_by_their_force_times_compliance(name):
    """Slides and hinges, in limbs and in telescopic rods, on either side of their joints."""
    description, rng = package_robots.robot(name).description, np.random.default_rng(1)
    stiffnesses = {actuator: float(rng.uniform(1e5, 1e6)) for actuator in description.actuated}
    for actuator, stiffness in stiffnesses.items():
        description = description.with_part(JointStiffness(actuator, drive=stiffness))
    pose = package_robots.generic_pose(name, description)
    forces = ks.analyze(pose, gravity=(0, 0, 0), load=np.eye(6)).actuator_forces
    expected = np.array([-forces[actuator] / stiffness for actuator, stiffness in stiffnesses.items()])
    gain = response(ks.modes(pose, 6).state_space(outputs=tuple(stiffnesses)), 0.0).real
    np.testing.assert_allclose(gain, expected, rtol=1e-7, atol=1e-9 * np.abs(expected).max())


def test_actuators_are_reciprocal_with_points(driven):
    places = ("o", "prismatic_1", "slider_2", "prismatic_3")
    for frequency in (0.0, 70.0):
        gain = response(ks.modes(driven, 9).state_space(places, places, damping=0.0), frequency).real
        np.testing.assert_allclose(gain, gain.T, atol=1e-11 * np.abs(gain).max())


def test_velocities_are_rates_of_displacements():
    model = ks.modes(two_columns().assemble(), 6).state_space(outputs=("o", "velocity of o"))
    both = response(model, 30.0)
    np.testing.assert_allclose(both[6:], 2j * np.pi * 30.0 * both[:6], atol=1e-12 * np.abs(both[6:]).max())
    assert model.outputs[0] == "x of o [m]" and model.outputs[11] == "rz of velocity of o [rad/s]"
    assert model.inputs[:4] == ("fx of o [N]", "fy of o [N]", "fz of o [N]", "mx of o [N·m]")


def test_models_open_in_python_control(pose):
    model = ks.modes(pose, 6).state_space()
    made = model.to_control()
    assert made.input_labels == list(model.inputs) and made.output_labels == list(model.outputs)
    np.testing.assert_allclose(made(2j * np.pi * 40.0), response(model, 40.0), rtol=1e-9, atol=1e-20)
    measured = ks.frequency_response(pose, [10.0, 40.0])
    data = measured.to_control()
    assert isinstance(data, control.FrequencyResponseData)
    np.testing.assert_array_equal(data(2j * np.pi * 40.0), measured.compliance[1])
    assert data.input_labels == list(model.inputs) and data.output_labels == list(model.outputs)
    tip = ks.frequency_response(pose, [10.0, 40.0], tool=[0, 0, 0.1]).to_control()
    assert tip.output_labels[5] == "rz of tool [rad]"


def test_files_have_matrices_and_names(pose, tmp_path, capsys):
    model = ks.modes(pose, 3).state_space()
    for ending in ("npz", "mat", "json"):
        model.save(tmp_path / f"m.{ending}")
    with np.load(tmp_path / "m.npz") as stored:
        np.testing.assert_array_equal(stored["A"], model.A)
        assert tuple(stored["inputs"]) == model.inputs
    matrices = loadmat(tmp_path / "m.mat")
    np.testing.assert_array_equal(matrices["D"], model.D)
    assert [str(name[0]) for name in matrices["outputs"].ravel()] == list(model.outputs)
    assert json.loads((tmp_path / "m.json").read_text())["C"] == model.C.tolist()
    assert main(["modes", "3rps", "--outputs", "o", "velocity of o", "--out", f"{tmp_path}/c.npz"]) == 0
    with np.load(tmp_path / "c.npz") as stored:
        assert stored["C"].shape == (12, 12)
    with pytest.raises(ks.ArgumentError, match=r"does not end in \.npz, \.mat or \.json"):
        model.save(tmp_path / "m.txt")


def test_models_need_one_stable_pose_with_locked_actuators(pose):
    with pytest.raises(ks.ArgumentError, match="needs one stable pose, with locked actuators"):
        ks.modes(pose, 3, drives="free").state_space()
    with pytest.raises(ks.ArgumentError, match="'rod' is neither o nor a rigid link"):
        ks.modes(pose, 3).state_space(inputs=("rod",))
    with pytest.raises(ks.ArgumentError, match="no force moves the rigid actuator 'prismatic_1'; <joint_stiffness drive=…>"):
        ks.modes(pose, 3).state_space(outputs=("velocity of prismatic_1",))
    with pytest.raises(ks.ArgumentError, match="'acceleration of floor' is neither o nor"):
        ks.modes(pose, 3).state_space(outputs=("acceleration of floor",))
