"""Results as pandas DataFrames: their rows add up to the results, and one pose of a batch has the rows of a single pose."""

import numpy as np
import package_robots
import pandas
import pytest

import kinetostatics as ks

TWIST = ["x [m]", "y [m]", "z [m]", "rx [rad]", "ry [rad]", "rz [rad]"]
LOAD = [100.0, 0.0, -500.0, 0.0, 20.0, 0.0]


@pytest.fixture(scope="module")
def robot():
    return package_robots.robot("2pru_upr")


@pytest.fixture(scope="module")
def result(robot):
    return ks.analyze(robot.assemble(platform={"z": 0.6, "rx": -0.1, "ry": 0.2}, orientation="XYZ"), load=LOAD)


def test_contributions_add_up_to_twist_and_actuator_forces(result):
    table = result.to_dataframe()
    assert table.index.name == "contribution" and list(table.index) == list(result.contributions)
    np.testing.assert_allclose(table[TWIST].sum(), result.twist, rtol=1e-12)
    np.testing.assert_array_equal(table.loc["load", TWIST], result.contributions["load"])
    for name, force in result.actuator_forces.items():
        assert table[f"force of {name} [N]"].sum() == pytest.approx(float(force), rel=1e-12)


def test_parts_add_up_to_the_twist_and_can_be_ranked(result):
    table = result.to_dataframe("parts")
    assert table.index.names == ["part", "kind"] and ("rod_1", "beam") in table.index
    np.testing.assert_allclose(table.sum(), result.twist, rtol=1e-9)
    np.testing.assert_array_equal(table.loc[("rod_3", "beam")], result.source_contributions["beams"]["rod_3"])


@pytest.mark.parametrize("which", ["contributions", "parts"])
def test_a_batch_has_a_row_for_each_pose(robot, result, which):
    z = np.array([[0.5, 0.6], [0.65, 9.0]])
    poses = robot.assemble(platform={"z": z, "rx": -0.1, "ry": 0.2}, orientation="XYZ", on_failure="nan")
    table = ks.analyze(poses, load=LOAD).to_dataframe(which)
    single = result.to_dataframe(which)
    assert table.index.names == ["axis 0", "axis 1", *single.index.names]
    twists = slice("x [m]", "rz [rad]")
    pandas.testing.assert_frame_equal(table.loc[(0, 1)].loc[:, twists], single.loc[:, twists], rtol=1e-9, atol=1e-15)
    pandas.testing.assert_frame_equal(table.loc[(0, 1)], single, rtol=1e-9, atol=1e-10)
    assert table.loc[(1, 1)].isna().all(axis=None)


def test_modes_have_frequencies_masses_and_shares(result):
    modes = ks.modes(result.configuration, 3)
    table = modes.to_dataframe()
    assert list(table.index) == [1, 2, 3] and table.index.name == "mode"
    np.testing.assert_array_equal(table["frequency [Hz]"], modes.frequencies)
    np.testing.assert_array_equal(table["effective mass ry"], modes.effective_masses[:, 4])
    for kind, shares in (("strain", modes.strain_energy_shares), ("kinetic", modes.kinetic_energy_shares)):
        of_kind = table.filter(like=f"{kind} energy of ")
        np.testing.assert_array_equal(of_kind.columns, [f"{kind} energy of {name}" for name in shares])
        np.testing.assert_allclose(of_kind.sum(axis=1), 1.0, rtol=1e-12)


def test_mistakes_are_named(result, monkeypatch):
    with pytest.raises(ks.ArgumentError, match="table is 'part'; it must be one of 'contributions', 'parts'"):
        result.to_dataframe("part")
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(ks.KinetostaticsError, match=r"needs pandas: pip install 'kinetostatics\[dataframe\]'"):
        result.to_dataframe()
