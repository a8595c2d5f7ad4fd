"""A map by compiled code is that of NumPy but for rounding, and is the same sweep."""

import numpy as np
import pytest
from small_robots import four_bar, robot_of

import kinetostatics as ks

pytest.importorskip("xarray")


def test_both_engines_make_the_same_map(tmp_path, monkeypatch):
    monkeypatch.setenv("KINETOSTATICS_CACHE", str(tmp_path / "code"))
    robot = robot_of(four_bar())
    [drive] = robot.description.driven
    grid = {"actuators": {drive: np.linspace(-0.5, 9.0, 21)}, "gravity": [0.1, 0.2, -9.81], "progress": False, "workers": 1}
    numpy, compiled = (ks.sweep(robot, **grid, engine=engine) for engine in ("numpy", "compiled"))
    assert list((tmp_path / "code").iterdir())
    assert set(numpy) == set(compiled) and numpy.sizes == compiled.sizes and (numpy["status"] < 2).sum() > 3
    for name in numpy:
        one, other = numpy[name].values, compiled[name].values
        if one.dtype.kind == "f":
            np.testing.assert_allclose(other, one, rtol=0, atol=1e-10 * np.nanmax(np.abs(one), initial=1e-3), err_msg=name)
        else:
            np.testing.assert_array_equal(other, one, err_msg=name)
    with pytest.raises(ks.ArgumentError, match="engine is 'fast'"):
        ks.sweep(robot, **grid, engine="fast")
