"""Reduced maps equal the map reduced by xarray, for any number of threads and any slabs, and take little memory."""

import subprocess
import sys

import numpy as np
import package_robots
import pytest
import xarray as xr
from maps import same

import kinetostatics as ks
from kinetostatics.cli.main import main
from kinetostatics.indices import quantity, valid
from kinetostatics.workspace import block, reduced

#: With poses beyond limits, and unreachable ones.
GRID = {"z": np.linspace(0.45, 0.65, 6), "rx": np.linspace(-0.6, 0.6, 9), "ry": np.linspace(-0.7, 0.5, 7)}
WHAT = ["linear_sag", "twist:rx"]


@pytest.fixture(scope="module")
def robot():
    return package_robots.robot("3rps")


@pytest.fixture(scope="module")
def whole(robot):
    """The whole map, with outliers among its valid poses."""
    ds = ks.sweep(robot, GRID, outputs=["twist"])
    assert 0 < valid(ds).sum() < ds["status"].size
    return ds


@pytest.fixture
def small_slabs(monkeypatch):
    """Slabs of some 20 poses, so that each operation combines several."""
    monkeypatch.setattr(reduced, "SLAB", 20)


def by_xarray(field, text, dims):
    """Return a field reduced by xarray, NaN skipped."""
    name, _, number = text.partition(" ")
    if name == "quantile":
        return field.quantile(float(number), dims, skipna=True).drop_vars("quantile")
    if name == "count":
        return (field > float(number.removeprefix("> "))).sum(dims)
    return getattr(field, name.removeprefix("arg"))(dims)


@pytest.mark.few(8)
@pytest.mark.parametrize("text", ["max", "min", "mean", "quantile 0.9", "argmax", "argmin", "count > 3e-6"])
@pytest.mark.parametrize("dims", [["rx", "ry"], ["ry", "z"], ["z", "rx", "ry"]], ids="-".join)
def test_reduced_map_equals_the_whole_map_reduced_by_xarray(robot, whole, small_slabs, text, dims):
    found = ks.sweep(robot, GRID, outputs=WHAT, reduce=dict.fromkeys(dims, text))
    kept = [name for name in GRID if name not in dims]
    assert list(found["valid_poses"].dims) == kept and set(found.coords) == set(kept)
    np.testing.assert_array_equal(found["valid_poses"], valid(whole).sum(dims))
    for what in WHAT:
        field = quantity(whole, what)
        wanted = by_xarray(field, text, dims)
        assert found[what].dims == wanted.dims
        if text == "mean":  # sums of slabs
            np.testing.assert_allclose(found[what], wanted, rtol=1e-14, atol=1e-14 * float(abs(field).max()))
        else:
            np.testing.assert_array_equal(found[what], wanted)
        assert found[what].attrs["units"] == ("1" if "count" in text else field.attrs["units"])
        if text.startswith("arg"):
            at = {dim: found[f"{what}_at_{dim}"].fillna(GRID[dim][0]) for dim in dims}
            np.testing.assert_array_equal(field.sel(at), wanted)


def test_numbers_are_the_same_for_any_number_of_threads(robot, small_slabs):
    for engine in ("numpy", "compiled"):
        options = {"outputs": WHAT, "reduce": {"rx": "mean", "ry": "mean", "z": "argmax"}, "engine": engine}
        same(ks.sweep(robot, GRID, workers=2, **options), ks.sweep(robot, GRID, workers=1, **options))


def test_compiled_numbers_do_not_depend_on_slabs(robot, monkeypatch):
    field = quantity(ks.sweep(robot, GRID, outputs=["twist"], engine="compiled"), "linear_sag")
    for slab in (13, 50, 2**16):
        monkeypatch.setattr(reduced, "SLAB", slab)
        found = ks.sweep(robot, GRID, reduce={"rx": "max", "ry": "max"}, engine="compiled")
        np.testing.assert_array_equal(found["linear_sag"], field.max(["rx", "ry"]))


def test_groups_are_reduced_in_the_order_given(robot, whole, small_slabs):
    field = quantity(whole, "linear_sag")
    found = ks.sweep(robot, GRID, reduce={"rx": "max", "ry": "max", "z": "mean"})
    np.testing.assert_allclose(found["linear_sag"], field.max(["rx", "ry"]).mean("z"), rtol=1e-14)
    other = ks.sweep(robot, GRID, reduce={"z": "mean", "rx": "max", "ry": "max"})
    np.testing.assert_allclose(other["linear_sag"], field.mean("z").max(["rx", "ry"]), rtol=1e-14)
    assert other["linear_sag"] > found["linear_sag"]
    assert int(found["valid_poses"]) == int(valid(whole).sum())
    picked = ks.sweep(robot, GRID, reduce={"rx": "argmax", "ry": "argmax", "z": "argmin"})
    at = {name: float(picked[f"linear_sag_at_{name}"]) for name in GRID}
    assert float(field.sel(at)) == float(picked["linear_sag"]) == float(field.max(["rx", "ry"]).min())
    counted = ks.sweep(robot, GRID, reduce={"rx": "count > 3 µm", "ry": "max"})
    np.testing.assert_array_equal(counted["linear_sag"], (field > 3e-6).sum("rx").max("ry"))


def test_loads_and_parameters_are_reduced(small_slabs):
    loads = xr.DataArray(
        np.diag([300.0, 200.0, 100.0, 0, 0, 0])[:3], dims=("push", "component"), coords={"push": ["x", "y", "z"]}
    )
    options = {"platform": {"z": 0.55, "rx": [0.0, 0.1], "ry": 0.0}, "parameters": {"rod_diameter": [0.06, 0.08]}, "load": loads}
    field = quantity(ks.sweep("3rps", outputs=["twist"], **options), "linear_sag")
    found = ks.sweep("3rps", reduce={"push": "argmax", "rod_diameter": "argmax"}, **options)
    np.testing.assert_array_equal(found["linear_sag"], field.max(["push"]).max("rod_diameter"))
    assert (
        found["linear_sag_at_push"].values.tolist() == ["x", "x"]
        and found["linear_sag_at_rod_diameter"].values.tolist() == [0.06] * 2
    )
    nowhere = ks.sweep("3rps", {"z": 0.5, "rx": [0.0, 3.0], "ry": [0.1, 3.0]}, reduce={"ry": "argmax"})
    assert nowhere["valid_poses"].values.tolist() == [1, 0] and np.isnan(nowhere["linear_sag_at_ry"].values).tolist() == [
        False,
        True,
    ]


def test_only_needed_variables_are_computed(robot, monkeypatch):
    seen, compute = set(), block.compute_block

    def told(plan, labels, block, q=None):
        arrays = compute(plan, labels, block, q)
        seen.update(arrays)
        return arrays

    monkeypatch.setattr(block, "compute_block", told)
    ks.sweep(robot, GRID, reduce={"rx": "max"})
    assert seen == {*reduced.NEEDED, "twist"}


@pytest.mark.parametrize(
    "reduce, outputs, message",
    [
        ({"x": "max"}, ["linear_sag"], "reduce: 'x' is not swept"),
        ({"rx": "largest"}, ["linear_sag"], "'largest' is not an operation: max, min, mean"),
        ({"rx": "count"}, ["linear_sag"], "'count' is not an operation"),
        ({"rx": "max > 3"}, ["linear_sag"], "'max > 3' is not an operation"),
        ({"rx": "quantile95"}, ["linear_sag"], "'quantile95' is not an operation"),
        ({"rx": "quantile 2"}, ["linear_sag"], "'quantile 2' is not an operation"),
        ({"rx": "count > 50 furlong"}, ["linear_sag"], "'50 furlong' is not a length such as 1m"),
        ({"rx": "count > 50 N"}, ["linear_sag"], "'50 N' is not a length such as 1m"),
        ({"rx": "max"}, ["liner_sag"], "no quantity 'liner_sag'.*linear_sag"),
        ({"rx": "max"}, ["twist"], "'twist' is not of the form twist:COMPONENT"),
        ({"rx": "max"}, ["first_frequency"], "'frequency' needs modes="),
    ],
)
def test_invalid_reductions_are_refused(robot, reduce, outputs, message):
    with pytest.raises(ks.ArgumentError, match=message):
        ks.sweep(robot, GRID, outputs=outputs, reduce=reduce)


def test_operations_that_need_too_many_poses_at_once_are_refused(robot):
    many = {"z": np.linspace(0.45, 0.65, 3), "rx": np.linspace(-0.1, 0.1, 2000), "ry": np.linspace(-0.1, 0.1, 2000)}
    message = "'quantile 0.9' over rx and ry needs all 4,000,000 poses at once, and at most 2,097,152 are possible"
    with pytest.raises(ks.ArgumentError, match=message):
        ks.sweep(robot, many, reduce={"rx": "quantile 0.9", "ry": "quantile 0.9"})
    with pytest.raises(ks.ArgumentError, match=r"give reduce= or chunks="):
        ks.sweep(robot, many, reduce={"rx": "max"}, chunks="auto")


@pytest.mark.parametrize("name", ["worst.nc", "worst.zarr"])
def test_reduced_map_is_written_and_found_again(robot, tmp_path, monkeypatch, name):
    path, options = tmp_path / name, {"reduce": {"rx": "argmax", "ry": "argmax"}, "outputs": WHAT}
    with ks.sweep(robot, GRID, out=path, **options) as found:
        same(found, ks.sweep(robot, GRID, **options))
    assert [entry.name for entry in tmp_path.iterdir()] == [name]
    with pytest.raises(ks.ArgumentError, match="map of another sweep, with other arguments"):
        ks.sweep(robot, GRID, out=path, outputs=WHAT, reduce={"rx": "argmin", "ry": "argmin"})
    monkeypatch.setattr(block, "compute_block", lambda *arguments: 1 / 0)
    ks.sweep(robot, GRID, out=path, **options).close()


def test_command_reduces_with_units(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    line = "sweep 3rps --platform z=0.5,0.6 rx=-20deg:20deg:5 ry=0 --out n.nc --reduce".split()
    assert main([*line, "rx=count >= 0.2um"]) == 0
    printed = capsys.readouterr().out
    assert "linear_sag   (z) float64" in printed and printed.endswith("wrote n.nc\n")
    grid = {"z": [0.5, 0.6], "rx": np.radians(np.linspace(-20, 20, 5)), "ry": 0.0}
    field = quantity(ks.sweep("3rps", grid, outputs=["twist"]), "linear_sag")
    with xr.open_dataset("n.nc") as found:
        np.testing.assert_array_equal(found["linear_sag"], (field >= 0.2e-6).sum("rx"))
        assert 0 < int(found["linear_sag"].sum()) < int(found["valid_poses"].sum()) == 10
    assert main([*line, "rx=count >= 0.2kg", "--restart"]) == 2 and "'0.2kg' is not a length" in capsys.readouterr().err
    assert main([*line, "ry=max", "--restart"]) == 2 and "reduce: 'ry' is not swept" in capsys.readouterr().err


MEASURED = """
import resource, sys
import numpy as np
import kinetostatics as ks
tilts = np.linspace(-0.2, 0.2, int(sys.argv[1]))
what, operations = ["linear_sag", "angular_sag", "twist:x", "twist:z"], {"rx": "max", "ry": "max"}
ks.sweep("3rps", {"z": [0.5, 0.6], "rx": tilts, "ry": tilts}, outputs=what, reduce=operations, workers=1, engine="compiled")
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""


@pytest.mark.slow
def test_memory_does_not_grow_with_the_number_of_poses():
    peaks = [
        int(subprocess.run([sys.executable, "-c", MEASURED, n], capture_output=True, check=True).stdout) for n in ("300", "900")
    ]
    assert peaks[1] < peaks[0] + 20_000 < 2**20  # KiB, at 180,000 and 1.6 million poses
