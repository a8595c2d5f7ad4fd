"""State-space models: static gain of the analysis, frequency response of the dynamic stiffness, names and files."""

import json

import control
import numpy as np
import package_robots
import pytest
from scipy.io import loadmat
from simple_machines import two_columns

import kinetostatics as ks
from kinetostatics.cli.main import main


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


def test_forces_and_displacements_of_links_are_reciprocal(pose):
    model = ks.modes(pose, 8).state_space(inputs=("o", "cylinder_1"), outputs=("o", "cylinder_1"))
    gain = response(model, 0.0).real
    assert gain.shape == (12, 12)
    np.testing.assert_allclose(gain, gain.T, atol=1e-12 * np.abs(gain).max())
    loaded = ks.analyze(pose, gravity=(0, 0, 0), loads={"cylinder_1": [30.0, -20.0, 10.0, 1.0, 2.0, 3.0]})
    np.testing.assert_allclose(gain[:6, 6:] @ [30.0, -20.0, 10.0, 1.0, 2.0, 3.0], loaded.twist, rtol=1e-9, atol=1e-16)


def test_more_modes_are_nearer_to_the_frequency_response(pose):
    """Between the kept modes the residual flexibility leaves an error that decreases with their number."""
    exact = ks.frequency_response(pose, [100.0], damping=0.0).compliance[0]
    errors = [np.abs(response(ks.modes(pose, count).state_space(damping=0.0), 100.0) - exact).max() for count in (3, 6, 12, 24)]
    assert errors == sorted(errors, reverse=True) and errors[-1] < 1e-5 * np.abs(exact).max()


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
