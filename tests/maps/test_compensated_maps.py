"""Maps with corrections of the actuators: each pose's are those of ``ks.compensate``."""

import numpy as np
import package_robots
import pytest

import kinetostatics as ks
from kinetostatics.cli.main import main

xr = pytest.importorskip("xarray")


def test_every_pose_of_a_map_is_corrected_as_alone():
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


@pytest.mark.slow
def test_maps_over_drives_and_maps_without_corrections(tmp_path, capsys):
    pytest.importorskip("h5netcdf")
    path = tmp_path / "map.nc"
    drives = ["prismatic_1=-10mm,10mm", "prismatic_2=0", "prismatic_3=0"]
    assert (
        main(["sweep", "3rps", "--actuators", *drives, "--outputs", "default", "compensation", "--quiet", "--out", str(path)])
        == 0
    )
    with xr.open_dataset(path, engine="h5netcdf") as ds:
        assert np.isfinite(ds.residual_error).all() and float(abs(ds.residual_error.sel(component=["z", "rx"])).max()) < 1e-7
        assert float(abs(ds.residual_error.sel(component="z")).max()) < 1e-12
    ds = ks.sweep(package_robots.robot("3rps"), actuators=dict.fromkeys(("prismatic_1", "prismatic_2", "prismatic_3"), 0.0))
    assert "residual_error" not in ds and "actuator_correction" not in ds
    with pytest.raises(ks.ArgumentError, match="'compensation' among"):
        ks.indices.quantity(ds, "residual_linear_sag")
    assert "residual_linear_sag" not in ks.indices.names(ds)
