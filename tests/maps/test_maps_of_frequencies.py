"""Maps of natural frequencies: what single poses have, lazily, from files, and the first of them as an index."""

import numpy as np
import package_robots
import pytest

import kinetostatics as ks

GRID = {"z": [0.5, 0.55], "rx": np.radians([-20, 0, 10]), "ry": 0.1}


@pytest.fixture(scope="module")
def ds():
    return ks.sweep("3rps", GRID, parameters={"rod_diameter": [0.06, 0.08]}, payload=ks.Payload(5.0), outputs=(), modes=3)


def test_numbers_are_those_of_single_poses(ds):
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


def test_spins_are_counted_and_poses_out_of_reach_have_no_numbers():
    z = float(package_robots.robot("delta").assemble().platform["z"])
    ds = ks.sweep("delta", {"x": [0.0, 5.0], "y": 0.0, "z": z}, modes=1)
    assert ds.zero_frequencies[0] == 6 and np.isfinite(ds.frequency[0]) and np.isnan(ds.frequency[1])


def test_chunks(ds):
    options = {"parameters": {"rod_diameter": [0.06, 0.08]}, "payload": ks.Payload(5.0), "outputs": ()}
    lazy = ks.sweep("3rps", GRID, **options, modes=3, chunks={"rx": 2})
    np.testing.assert_allclose(lazy.frequency.values, ds.frequency, rtol=1e-8)


def test_a_map_without_them_says_how_to_get_them():
    with pytest.raises(ks.ArgumentError, match=r"needs modes=, the number"):
        ks.sweep("3rps", GRID, outputs=["frequency"])
    with pytest.raises(ks.ArgumentError, match=r"sweep with modes=3"):
        ks.indices.quantity(ks.sweep("3rps", GRID), "first_frequency")
