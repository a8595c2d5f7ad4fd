"""Maps of natural frequencies and of corrections of the actuators: each pose has the numbers of a single analysis."""

import numpy as np
import package_robots
import pytest
import xarray as xr

import kinetostatics as ks

GRID = {"z": [0.5, 0.55], "rx": np.radians([-20, 0, 10]), "ry": 0.1}


@pytest.fixture(scope="module")
def ds():
    return ks.sweep("3rps", GRID, parameters={"rod_diameter": [0.06, 0.08]}, payload=ks.Payload(5.0), outputs=(), modes=3)


def test_map_frequencies_equal_those_of_single_poses(ds):
    assert ds.frequency.dims == ("rod_diameter", "z", "rx", "natural_mode") and ds.frequency.attrs["units"] == "Hz"
    assert list(ds.natural_mode.values) == ["1", "2", "3"] and not ds.zero_frequencies.any()
    pose = ks.load_robot("3rps", {"rod_diameter": 0.06}).assemble(platform={"z": 0.55, "rx": GRID["rx"][2], "ry": 0.1})
    own = ks.modes(pose, 3, payload=ks.Payload(5.0))
    np.testing.assert_allclose(ds.frequency[0, 1, 2], own.frequencies, rtol=1e-8)
    first = ks.indices.quantity(ds, "first_frequency")
    np.testing.assert_array_equal(first, ds.frequency[..., 0])
    assert first.attrs == {"units": "Hz", "long_name": "first natural frequency"}
    assert ks.indices.worst(ds, "first_frequency").value == first.min()
    assert ks.indices.best(ds, "frequency:2").value == ds.frequency[..., 1].max()


def test_zero_frequencies_are_counted_and_unreached_poses_are_nan():
    z = float(package_robots.robot("delta").assemble().platform["z"])
    ds = ks.sweep("delta", {"x": [0.0, 5.0], "y": 0.0, "z": z}, modes=1)
    assert ds.zero_frequencies[0] == 6 and np.isfinite(ds.frequency[0]) and np.isnan(ds.frequency[1])


def test_error_on_missing_frequencies_names_the_modes_argument():
    with pytest.raises(ks.ArgumentError, match=r"needs modes=, the number"):
        ks.sweep("3rps", GRID, outputs=["frequency"])
    with pytest.raises(ks.ArgumentError, match=r"sweep with modes=3"):
        ks.indices.quantity(ks.sweep("3rps", GRID), "first_frequency")


# ---- corrections of the actuators ----------------------------------------------------------------------------------


def test_map_corrections_equal_those_of_single_poses():
    robot = package_robots.robot("3rps")
    loads = xr.DataArray(
        [[0, 0, 0, 0, 0, 0], [50, 0, -300, 0, 0, 0]], dims=("case", "component"), coords={"case": ["idle", "cut"]}
    )
    grid = {"z": [0.45, 0.55], "rx": [-0.1, 0.0, 0.1], "ry": 0.05}
    ds = ks.sweep(robot, platform=grid, load=loads, outputs=["default", "compensation"])
    assert ds.residual_error.dims == ("case", "z", "rx", "component") and ds.actuator_correction.dims[-1] == "actuator"
    pose = robot.assemble(platform={"z": 0.55, "rx": 0.1, "ry": 0.05})
    one, there = ks.compensate(pose, loads.values[1]), {"case": "cut", "z": 0.55, "rx": 0.1}
    np.testing.assert_allclose(ds.residual_error.sel(there), one.residual_error, atol=1e-13)
    for name, shift in one.corrections.items():
        assert float(ds.actuator_correction.sel({**there, "actuator": name})) == pytest.approx(float(shift), abs=1e-13)
    before, after = (ks.indices.quantity(ds, name).sel(there) for name in ("linear_sag", "residual_linear_sag"))
    assert float(before) == pytest.approx(np.linalg.norm(one.uncorrected.twist[:3])) and after.attrs["units"] == "m"
    assert float(after) == pytest.approx(np.linalg.norm(one.residual_error[:3]))
    assert float(after) < float(before)
    assert float(ks.indices.quantity(ds, "residual_angular_sag").sel(there)) == pytest.approx(
        np.linalg.norm(one.residual_error[3:])
    )
    assert ks.indices.quantity(ds, "actuator_correction:prismatic_2").attrs == {
        "units": "m",
        "long_name": "correction of prismatic_2",
    }
    words = {"residual_error:z": "residual displacement along z", "twist:rx": "rotation about x"}
    assert {name: ks.indices.quantity(ds, name).attrs["long_name"] for name in words} == words
    assert {"residual_error:z", "actuator_correction:prismatic_1", "residual_linear_sag"} <= set(ks.indices.names(ds))
    assert ds.residual_error.sel(component="z").max() < 1e-12


def test_corrections_over_actuator_grids_and_maps_without_corrections():
    """On a grid of actuators, the best conditioned platform coordinates are corrected."""
    robot, drives = package_robots.robot("3rps"), {"prismatic_1": [-0.01, 0.01], "prismatic_2": 0.0, "prismatic_3": 0.0}
    ds = ks.sweep(robot, actuators=drives, outputs=["compensation"])
    assert np.isfinite(ds.residual_error).all() and float(abs(ds.residual_error.sel(component="z")).max()) < 1e-12
    ds = ks.sweep(robot, actuators=drives)
    assert "residual_error" not in ds and "actuator_correction" not in ds
    with pytest.raises(ks.ArgumentError, match="'compensation' among"):
        ks.indices.quantity(ds, "residual_linear_sag")
    assert "residual_linear_sag" not in ks.indices.names(ds)
