"""The summary after a sweep: worst cases, also for each value of a parameter, in suitable units and without zeros."""

import numpy as np
import xarray as xr
from small_maps import map_of

import kinetostatics as ks
from kinetostatics.reports.map import map_report


def summary(ds, seconds=None):
    return str(map_report(ds, seconds))


def sized_map(twist, forces, status=None):
    """A map over two diameters and three heights, of which the diameter is a parameter of the file."""
    ds = map_of(
        {"diameter": ([0.04, 0.05], "m"), "z": ([0.1, 0.2, 0.3], "m")},
        twist=twist,
        forces=forces,
        turning=("motor",),
        status=status,
    )
    ds["characteristic_length"] = ("diameter", [1.0, 1.0])
    return ds.assign(mode=(("diameter", "z"), np.zeros((2, 3), np.int8)))


def test_summary_has_worst_cases_for_each_parameter_value():
    twist = np.zeros((2, 3, 6))
    twist[..., 2] = [[1e-3, 2e-3, 5e-4], [3e-5, 4e-5, 2e-5]]
    twist[..., 4] = [[1e-3, 2e-3, 5e-4], [3e-5, 8e-5, 2e-5]]
    lines = summary(sized_map(twist, {"motor": [[1.0, -7.0, 2.0], [3.0, 4.0, 5.0]], "slide": np.zeros((2, 3))})).splitlines()
    assert lines[2:] == [
        "  worst sag 2 mm at diameter = 0.04 m, z = 0.2 m",
        "  worst turn 2 mrad at diameter = 0.04 m, z = 0.2 m",
        "  largest actuator torque 7 N·m, motor, at diameter = 0.04 m, z = 0.2 m",
        "",
        "by diameter, each over all other axes:",
        "  diameter  worst sag  worst turn  largest actuator torque",
        "  0.04 m         2 mm      2 mrad                    7 N·m",
        "  0.05 m        40 µm     80 µrad                    5 N·m",
    ]


def test_parameter_values_without_valid_poses_have_dashes():
    beyond = int(ks.Status.LIMIT_EXCEEDED)
    twist = np.zeros((2, 3, 6))
    twist[..., 0] = 1e-6
    said = summary(sized_map(twist, {"slide": np.ones((2, 3))}, [[0, 0, 0], [beyond] * 3]))
    assert said.splitlines()[-2:] == [
        "  0.04 m         1 µm                     1 N",
        "  0.05 m            –                       –",
    ]


def test_summary_of_zero_deformation_has_no_worst_cases():
    said = summary(sized_map(np.zeros((2, 3, 6)), {"slide": np.zeros((2, 3))}))
    assert said.splitlines()[2:] == ["  the platform neither sags nor turns: no elastic part deforms"]
    assert "worst" not in said and " 0 " not in said.split("\n", 1)[1]


def test_summary_is_independent_of_blocks_and_omits_long_axes(monkeypatch):
    twist = np.random.default_rng(1).normal(size=(2, 3, 6)) * 1e-4
    ds = sized_map(twist, {"slide": np.ones((2, 3))})
    whole = summary(ds)
    monkeypatch.setattr("kinetostatics.reports.map.AT_ONCE", 1)
    assert summary(ds) == whole and "by diameter" in whole
    many = xr.concat([ds.isel(diameter=[0]).assign_coords(diameter=[0.01 * k]) for k in range(1, 30)], "diameter")
    assert "by diameter" not in summary(many)


def test_poses_without_intensities_are_as_good_as_others():
    """Unless they are beyond a limit, or have undetermined forces."""
    degenerate, beyond = int(ks.Status.BASIS_DEGENERATE), int(ks.Status.LIMIT_EXCEEDED)
    ds = sized_map(
        np.zeros((2, 3, 6)),
        {"motor": np.zeros((2, 3))},
        np.array([[0, degenerate, degenerate], [beyond, degenerate, 0]], dtype=np.int8),
    )
    ds["basis_degenerate"] = ds["status"] == degenerate
    ds["limit_exceeded"] = (("diameter", "z"), np.array([[0, 0, 0], [1, 1, 0]], dtype=bool))
    lines = summary(ds).splitlines()
    assert lines[1].split() == ["4", "reached"] and lines[2].strip() == "2 beyond a joint's limit"
    assert "intensit" not in "".join(lines)
