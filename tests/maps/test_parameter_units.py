"""Units of a file's parameters: inferred from the dimensions they change, taken from typed values, or unknown."""

from __future__ import annotations

from pathlib import Path

import pytest
import xarray as xr
from matplotlib import pyplot as plt

import kinetostatics as ks
from kinetostatics.cli.main import main
from kinetostatics.files.bundled import robot_path
from kinetostatics.files.parameter_units import parameter_unit
from kinetostatics.files.reader import read_robot_file


def unit_of(path, parameters, name):
    """Return the unit of a parameter, by the file read again."""
    return parameter_unit(parameters[name], lambda value: read_robot_file(path, {**parameters, name: value}))


@pytest.fixture
def file(tmp_path):
    """A robot with a parameter, and expressions of it."""

    def write(expression: str, mass: str = "1") -> str:
        text = robot_path("five_bar").read_text(encoding="utf-8")
        head, tail = text.split("</robot>")
        more = f'<xacro:arg name="p" default="1"/><xacro:property name="p" value="$(arg p)"/>{head.partition("<xacro:arg")[1]}'
        text = head.replace("<xacro:arg", more, 1)
        text += (
            f'<link name="more"><inertial><mass value="{mass}"/><inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/>'
            f'</inertial></link><joint name="on" type="fixed"><parent link="tool"/><child link="more"/>'
            f'<origin xyz="{expression}"/></joint></robot>{tail}'
        )
        (tmp_path / "r.urdf.xacro").write_text(text, encoding="utf-8")
        return str(tmp_path / "r.urdf.xacro")

    return write


@pytest.mark.parametrize(
    ("expression", "mass", "unit"),
    [
        ("${p} 0 0", "1", "m"),
        ("${0.3 - p} ${p/2} 0", "1", "m"),
        ("0 0 0", "${p}", "kg"),
        ("${p} 0 0", "${p}", ""),  # a plain number, or a mistake
        ("${p/1000} 0 0", "1", ""),  # in mm
        ("${(1 + 1e-6) * p} 0 0", "1", ""),
        ("${(1 + 1e-8) * p} 0 0", "1", "m"),  # but for rounding
        ("${sin(p)} 0 0", "1", ""),  # whose slope is 1 at zero
        ("${p if p == 0 else 1/0} 0 0", "1", ""),  # any other value is refused
    ],
)
def test_parameter_has_the_unit_of_dimensions_changing_one_for_one(file, expression, mass, unit):
    assert unit_of(file(expression, mass), {"p": 0.0 if "sin" in expression or "if" in expression else 0.1}, "p") == unit


@pytest.mark.parametrize(("numbers", "unit"), [('stiffness="${p}" preload="1"', "N/m"), ('stiffness="7" preload="${-p}"', "N")])
def test_numbers_of_springs_have_units(file, numbers, unit):
    path = Path(file("0 0 0"))
    ends = '<predecessor link="base"><origin xyz="0 0 1"/></predecessor><successor link="tool"/>'
    spring = f'<spring name="s" free_length="0" {numbers}>{ends}</spring></robot>'
    path.write_text(path.read_text(encoding="utf-8").replace("</robot>", spring), encoding="utf-8")
    assert unit_of(str(path), {"p": 3.0}, "p") == unit


def test_unit_is_inferred_downwards_where_larger_values_fail(file):
    assert unit_of(file("${1/0 if p > 0.1 else p} 0 0"), {"p": 0.1}, "p") == "m"


def test_text_and_boolean_parameters_have_no_unit(file):
    assert unit_of(file("0 0 0"), {"p": "steel"}, "p") == unit_of(file("0 0 0"), {"p": True}, "p") == ""


@pytest.mark.slow
def test_maps_and_figures_show_parameter_units(tmp_path):
    ds = ks.sweep("3rps", parameters={"rod_diameter": [0.06, 0.08], "density": [7000.0, 7850.0], "poisson_ratio": [0.3, 0.31]})
    assert [ds[name].units for name in ("rod_diameter", "density", "poisson_ratio")] == ["m", "kg/m³", "1"]
    ax = ks.plot.slice(ds, x="rod_diameter", y="density", at={"poisson_ratio": 0.3})
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("rod_diameter [mm]", "density [kg/m³]")
    ax = ks.plot.slice(ds, x="rod_diameter", y="poisson_ratio", at={"density": 7000.0})
    assert ax.get_ylabel() == "poisson_ratio"
    plt.close("all")
    ds.to_netcdf(tmp_path / "map.nc", engine="h5netcdf")
    with xr.open_dataset(tmp_path / "map.nc", engine="h5netcdf") as again:
        assert again.density.units == "kg/m³"


@pytest.mark.slow
def test_typed_units_apply_where_none_can_be_inferred(file, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    path = file("${2 * p} 0 0")
    command = ["sweep", path, "--platform", "x=0", "y=0.3", "--out", "m.nc", "--set"]
    assert main([*command, "p=10mm:20mm:3"]) == 0
    with xr.open_dataset("m.nc", engine="h5netcdf") as ds:
        assert ds.p.units == "m" and ds.p.values[0] == 0.01
    assert main([*command, "p=0.01,0.02", "--restart"]) == 0
    with xr.open_dataset("m.nc", engine="h5netcdf") as ds:
        assert "units" not in ds.p.attrs


@pytest.mark.few(1)
@pytest.mark.parametrize("values", ["80mm", "1mm:2mm:2", "2mm,3mm"])
def test_a_length_for_an_angle_is_refused(values, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    more = ["sweep", "3prs", "--out", "m.nc"] if values != "80mm" else ["analyze", "3prs"]
    assert main([*more, "--set", f"guide_tilt={values}"]) == 2
    said = capsys.readouterr().err
    assert "parameters: guide_tilt is given in m, but it is in rad" in said
    assert main(["check", "3prs", "--set", "guide_tilt=1deg", "link_width=95mm"]) == 0


def test_parameter_units_must_be_si_units_of_swept_parameters():
    options = {"parameters": {"rod_diameter": [0.06, 0.08]}}
    for units in ({"rod_diameter": "mm"}, {"rod_diameter": 3}, {"rod": "m"}):
        with pytest.raises(ks.ArgumentError, match="is not the SI unit of one of parameters="):
            ks.sweep("3rps", **options, parameter_units=units)
