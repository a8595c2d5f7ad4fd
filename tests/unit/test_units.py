"""Units of numbers on the command line and in figures."""

import json
import math

import numpy as np
import pytest

import kinetostatics as ks
from kinetostatics.cli.inputs import parse_parameters, parse_quantity
from kinetostatics.cli.main import main
from kinetostatics.plot.selection import display_unit
from kinetostatics.units import BASIC, IN_FIGURES, IN_REPORTS, KINDS, PREFIXES, find_unit, unit

DEGREE = math.pi / 180


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("80mm", 0.08),
        ("0.5", 0.5),
        ("-1e-3", -1e-3),
        ("+.5E2", 50.0),
        ("1e3mm", 1.0),
        ("7µm", 7e-6),
        ("7 um", 7e-6),
        ("1.5kN", 1500.0),
        ("20N·m", 20.0),
        ("20Nm", 20.0),
        ("3kNm", 3000.0),
        ("3N*mm", 0.003),
        ("6bar", 6e5),
        ("5N/mm²", 5e6),
        ("7.85g/cm3", 7850.0),
        ("7850kg/m**3", 7850.0),
        ("2kN·m/mrad", 2e6),
        ("12e-6 1/K", 12e-6),
        ("9810mm/s2", 9.81),
        ("90°", math.pi / 2),
        ("180mdeg", math.pi / 1000),
        ("5Nm/deg", 5 / DEGREE),
        ("2m/(N·m)", 2.0),
    ],
)
def test_quantities_with_units_are_parsed(text, value):
    assert parse_quantity(text) == pytest.approx(value, rel=4e-16)


@pytest.mark.parametrize("decimals", range(1, 1000, 137))
def test_decimal_units_are_as_exact_as_decimal_numbers(decimals):
    assert parse_quantity(f"{decimals}mm") == float(f"{decimals}e-3")
    assert parse_quantity(f"{decimals}µm") == float(f"{decimals}e-6")
    assert parse_quantity(f"{decimals}GPa") == float(f"{decimals}e9")


def test_units_take_every_prefix_and_kinds_have_si_units():
    for name, (_, dimension) in BASIC.items():
        for prefix, ten in PREFIXES.items():
            found = unit(f"{prefix}{name}")
            assert found.dimension == dimension and found.size == pytest.approx(10.0**ten * unit(name).size, rel=1e-15)
    assert [(unit(name).kind, unit(name).size) for name in KINDS.values()] == [(kind, 1) for kind in KINDS]


@pytest.mark.parametrize(
    ("left", "right"),
    [
        ("N", "kg·m/s2"),
        ("J", "N·m"),
        ("Pa", "N/m2"),
        ("bar", "MPa"),
        ("Hz", "1/s"),
        ("deg", "rad"),
        ("°", "rad"),
        ("N/m", "J/m2"),
    ],
)
def test_derived_units_have_the_dimensions_of_their_definitions(left, right):
    assert unit(left).dimension == unit(right).dimension and unit("kN").size == 1e3 and unit("bar").size == 1e5
    basic = [unit(name).dimension for name in ("m", "kg", "s", "K", "rad")]
    np.testing.assert_array_equal(basic, np.eye(5))


@pytest.mark.parametrize(
    "text",
    ["", "inch", "e", "N/", "/", "//m", "()", "mN·", "m5", "kgm", "Nx", "°C", "min", "m//s", "2", "mm mm x", "(N", "N)", "1/(mm"],
)
def test_invalid_units_are_not_found(text):
    assert find_unit(text) is None


def test_error_of_unknown_unit_lists_known_units():
    with pytest.raises(ks.ArgumentError) as caught:
        parse_quantity("3furlong")
    assert all(f" {name}" in str(caught.value) for name in BASIC if name != "°")


@pytest.mark.parametrize(
    ("command", "message"),
    [
        ("analyze 3rps --load 100mm 0 0 0 0 0", "--load: '100mm' is a length, but a force is needed"),
        ("analyze 3rps --gravity 0 0 -9.81m/s", "--gravity: '-9.81m/s' is another quantity, but an acceleration is needed"),
        ("analyze 3rps --actuators prismatic_1=5deg", "--actuators: prismatic_1: '5deg' is an angle, but a length is needed"),
        ("analyze 3rps --closure-tolerance 1kg", "--closure-tolerance: '1kg' is a mass, but a length is needed"),
        ("view 3rps --platform z=0.5 rx=0 --sweep ry=0:5mm", "--sweep: ry: '5mm' is a length, but an angle is needed"),
        ("tolerances 3rps --tolerance rod_1.error.length=5N", "rod_1.error.length is given in N, but it is in m"),
        ("sweep 3rps --set rod_diameter=60mm:100deg:5 --out x.nc", "rod_diameter: '60mm' and '100deg' are not of one kind"),
        ("sweep 3rps --set rod_diameter=60mm:100inch:5 --out x.nc", "'100inch' has the unknown unit 'inch'; units are m, g,"),
    ],
)
def test_a_unit_of_another_kind_is_refused(capsys, tmp_path, monkeypatch, command, message):
    monkeypatch.chdir(tmp_path)
    assert main(command.split()) == 2
    out, err = capsys.readouterr()
    assert out == "" and message in err and err.count("\n") == 1


def test_options_with_units_equal_plain_numbers(capsys):
    def analyzed(*options):
        assert main(["analyze", "3rps", "--json", *options]) == 0
        return json.loads(capsys.readouterr().out)["twist"]

    plain = analyzed(
        *"--set rod_diameter=0.08 youngs_modulus=70e9 density=2700 platform_mass=30".split(),
        *"--platform z=0.55 rx=0.01 ry=0 --load 1500 0 -2000 3 0.02 0 --gravity 0 0 -9.81 --closure-tolerance 1e-9".split(),
    )
    typed = analyzed(
        *"--set rod_diameter=8cm youngs_modulus=70GPa density=2.7g/cm3 platform_mass=30kg".split(),
        *"--platform z=5.5dm rx=10mrad ry=0° --load 1.5kN 0 -2kN 3N·m 20Nmm 0N·m --gravity 0 0m/s² -981cm/s2".split(),
        *"--closure-tolerance 1nm".split(),
    )
    np.testing.assert_allclose(typed, plain, rtol=1e-13, atol=0)


def test_text_parameters_are_not_taken_for_quantities():
    assert parse_parameters(["a=3D-printed", "b=316L steel", "c=5 rods", "d=2x", "e=10mm"]) == {
        "a": "3D-printed", "b": "316L steel", "c": "5 rods", "d": "2x", "e": 0.01,
    }  # fmt: skip


def test_display_units_are_of_the_same_kind():
    for units, names in (*IN_FIGURES.items(), *IN_REPORTS.items()):
        assert {unit(name).dimension for name in names} == {unit(units).dimension}
    assert all(units in names for units, names in IN_FIGURES.items())
    assert display_unit("N m", [3.0], "Nmm") == (1e-3, "Nmm")
    assert display_unit("m", [3.0], "cm") == (1e-2, "cm")
    assert display_unit("Pa", [3e8], "bar") == (1e5, "bar")
    assert display_unit("N/m", [3e8], "N/mm") == (1e3, "N/mm")
    with pytest.raises(ks.ArgumentError, match="unit 'bar' is not one for values in m: m, mm, µm"):
        display_unit("m", [1.0], "bar")
