"""The how-to pages with figures: their code runs, and its results are as the pages state."""

import how_to_figures
import numpy as np
import pytest
from places import ROOT


def test_feedforward_forces_balance_robot_and_tool():
    names = how_to_figures.page_names("feedforward")
    found = names["found"]
    assert not found.status.any()
    held = sum(found.result.joint_wrenches[name][:, 2] for name in ("revolute_1", "revolute_2", "revolute_3"))
    weights = found.result.base_wrench[:, 2]
    np.testing.assert_allclose(held, weights, rtol=1e-9)
    alone = how_to_figures.ks.analyze(names["path"])
    np.testing.assert_allclose(weights - alone.base_wrench[:, 2], 12 * 9.81, rtol=1e-5)  # the tool; corrected rods are longer
    here = how_to_figures.ks.analyze(names["path"], [0, 0, -12 * 9.81, 0, 0, 0])
    for drive, force in found.actuator_forces.items():
        np.testing.assert_allclose(force, here.actuator_forces[drive], rtol=1e-4)  # nearly what the uncorrected actuators hold


def test_correction_removes_errors_of_controlled_coordinates_only():
    names = how_to_figures.page_names("correct_a_machine")
    found, other = names["found"], names["other"]
    assert found.controlled == ("z", "rx", "ry") and not found.status.any()
    for which in (found, other):
        assert max(np.abs(which.residual_error_coordinates[name]).max() for name in which.controlled) < 1e-12
    assert np.abs(found.residual_error_coordinates["y"]).max() > np.abs(found.uncorrected_error_coordinates["y"]).max() > 1e-5
    assert np.abs(other.residual_error_coordinates["rx"]).max() > 1e-4


@pytest.mark.slow
def test_sizing_finds_a_feasible_rod_diameter():
    fewer = {"[0.58, 0.6, 0.62]": "0.62", '90mm"}': '90mm"}, starts=1', "np.radians([-10, 0, 10])": "np.radians([-10, 10])"}
    best = how_to_figures.page_names("size_a_rod", **fewer)["best"]
    assert best.feasible and 0.06 < best.parameters["rod_diameter"] < 0.07 and best.poses == 4 and not best.beyond_limits
    assert best.active[0].text.startswith("deflection") and best.active[0].saving > 0


@pytest.mark.slow
def test_sampled_tolerances_agree_with_the_linear_estimate():
    s = how_to_figures.page_names("tolerances")["s"]
    assert len(s.samples.displacement) == 10_000 and len(s.parameters) == 8 and s.difference < 1e-3
    _, random, low, high = s.sampled("displacement")
    assert random == pytest.approx(float(s.standard_deviation.displacement), rel=0.04)
    assert 0 < low < high < s.worst_case.displacement < s.nominal.displacement
    assert max(s.parameters, key=s.share) == "platform.center_of_mass.x"


@pytest.mark.slow
def test_calibration_finds_the_true_stiffness_and_the_outlier():
    swaps = {"[0.55, 0.6, 0.65]": "0.55", "found = ks.calibrate(robot": "kept = ks.calibrate(robot"}
    names = how_to_figures.page_names("calibrate", **swaps)
    found, kept = names["found"], names["kept"]
    for name, true in {"rod_1": 0.85, "rod_2": 0.85, "rod_3": 1.1}.items():
        low, high = found.estimates[name].interval
        assert low < true < high, name
    (outlier,) = found.outliers
    assert (outlier.row, outlier.gauge) == (8, "back") and not found.unidentifiable and found.reduced_chi_square < 1.5
    assert kept.estimates["rod_3"].value == pytest.approx(1.4, abs=0.005)
    assert names["plan"].gain > 1 and len(names["plan"].chosen) == 10


def test_fastest_motion_is_limited_by_the_sag(capsys):
    """The page's speed is the highest that both limits permit, and the faster analysis agrees."""
    names = how_to_figures.page_names("motion")
    k, fast = names["k"], names["fast"]
    assert names["sag"](k + 0.01) > 0.2e-3 and names["torque"](k) < 40
    assert fast.peaks("displacement")["the tool's tip"].value == pytest.approx(names["sag"](k), rel=1e-9)
    assert max(abs(peak.value) for peak in fast.peaks("actuator_torque").values()) == pytest.approx(names["torque"](k), rel=1e-9)
    page = (ROOT / "docs" / "how_to" / "motion.md").read_text(encoding="utf-8")
    assert f"{1 / k:.3f} s, limited by the sag" in page
    largest = [float(line) for line in capsys.readouterr().out.splitlines()[-2:]]
    assert "{:.0f} N as one beam, {:.0f} N as a cylinder and a rod".format(*largest) in page


@pytest.mark.slow
def test_sensitivities_rank_the_rod_diameter_first():
    fewer = {"(pose, load": '(pose, ["rod_diameter", "rod_length"], load'}
    s = how_to_figures.page_names("find_what_to_stiffen", **fewer)["s"]
    assert next(iter(s)) == "rod_diameter" and s.effect("rod_diameter")[0] < 0 < s.effect("rod_diameter")[1]
    assert {"rod_1", "rod_2", "rod_3"} == set(s.sources) and "stiffen the first" in str(s)


def test_first_frequencies_of_the_map_equal_known_values(tmp_path, monkeypatch):
    """The worst of the page's poses, and the two equal frequencies of the level platform; no file is written."""
    monkeypatch.chdir(tmp_path)
    names = how_to_figures.page_names("natural_frequencies", **{"20, 41)": "20, 9)"})
    assert not [*tmp_path.iterdir()]
    ds = names["ds"]
    assert how_to_figures.ks.indices.worst(ds, "first_frequency").value == pytest.approx(78.1376, abs=1e-4)
    level = ds["frequency"][4, 4]
    assert level[1] == pytest.approx(float(level[0]), rel=1e-9) and level[0] == ds["frequency"][..., 0].max()
