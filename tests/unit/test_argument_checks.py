"""Invalid counts and seeds are refused in the same words everywhere."""

import inspect

import numpy as np
import pytest
from package_robots import robot
from places import ROBOTS

import kinetostatics as ks
from kinetostatics.arguments import whole_number

RPS, VARY, OVER = ROBOTS / "3rps.urdf.xacro", {"rod_diameter": "5cm:6cm"}, {"z": 0.5, "rx": 0.0, "ry": 0.0}


@pytest.mark.parametrize("value", [3, np.int8(3), np.uint64(3), np.array(3)])
def test_whole_number_accepts_any_integer_type(value):
    found = whole_number("n", value, 3, 3)
    assert found == 3 and type(found) is int


@pytest.mark.few(14)
@pytest.mark.parametrize("value", [0, 2.0, "2", True, np.bool_(True), None, np.array([1]), np.float64(2)])
@pytest.mark.parametrize(
    ("name", "call"),
    [
        ("starts", lambda value: ks.optimize(RPS, VARY, "mass", ["sag < 1mm"], OVER, starts=value)),
        ("points", lambda value: ks.pareto(RPS, VARY, ("mass", "sag"), [], OVER, points=value)),
        ("samples", lambda value: ks.tolerances(robot("3rps").assemble(), {"rod_1.outer_diameter": 1e-4}, samples=value)),
        (
            "n",
            lambda value: ks.plan_measurements(robot("3rps"), ["rod_1"], value, OVER, load=[0, 0, -9, 0, 0, 0], readings=["dz"]),
        ),
        ("workers", lambda value: ks.sweep(robot("3rps"), OVER, workers=value, progress=False)),
    ],
)
def test_invalid_counts_are_refused_in_the_same_words(name, call, value):
    if value is None and name in ("samples", "workers"):
        return
    with pytest.raises(ks.ArgumentError, match=rf"^{name} is .*; it must be a whole number from [12] (on|to \d+)"):
        call(value)


def test_negative_seeds_are_refused():
    for call in (
        lambda: ks.tolerances(robot("3rps").assemble(), {"rod_1.outer_diameter": 1e-4}, seed=-1),
        lambda: ks.plan_measurements(robot("3rps"), ["rod_1"], 1, OVER, load=[0, 0, -9, 0, 0, 0], readings=["dz"], seed=-1),
    ):
        with pytest.raises(ks.ArgumentError, match=r"^seed is -1; it must be a whole number from 0 on$"):
            call()


def test_all_functions_close_loops_to_the_same_tolerance():
    """1e-10 m or rad; a compensation takes that of its pose."""
    named = {name: getattr(ks, name) for name in ks.__all__ if callable(getattr(ks, name))} | {
        "assemble": ks.Robot.assemble, "configuration": ks.Robot.configuration,
    }  # fmt: skip
    found = {}
    for name, function in named.items():
        if not inspect.isclass(function) and "closure_tolerance" in inspect.signature(function).parameters:
            found[name] = inspect.signature(function).parameters["closure_tolerance"].default
    assert {name for name, default in found.items() if default is None} == {"compensate"}
    assert len(found) > 7 and {default for default in found.values() if default is not None} == {1e-10}
