"""The table of quantities: results, JSON, maps, functions and exported C have its names, units and axes."""

import inspect
import re
from functools import cached_property

import numpy as np
import package_robots
import pytest

import kinetostatics as ks
from kinetostatics.description.elements import Spring
from kinetostatics.functions.c_texts import _words
from kinetostatics.functions.inputs_outputs import PATHS
from kinetostatics.quantities import COMPUTED, QUANTITIES, UNITS, VARIABLES, axes_of, stacked, value_at
from kinetostatics.status import FACTS

POSE = {"z": 0.5, "rx": 0.1, "ry": -0.05}
IN_RESULTS = {path: entry for path, entry in QUANTITIES.items() if not path.startswith("sweep.")}


@pytest.fixture(scope="module")
def robot():
    """The 3RPS with a spring."""
    spring = Spring("balance", 800.0, "base", "platform", (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.1, 20.0)
    return ks.Robot(package_robots.robot("3rps").description.with_part(spring))


@pytest.fixture(scope="module")
def result(robot):
    loads = {"platform": [0, 0, -100, 0, 0, 0]}
    return ks.analyze(robot.assemble(platform=POSE), [0, 0, -500, 0, 0, 0], loads=loads, payload=ks.Payload(2.0))


@pytest.fixture(scope="module")
def ds(robot):
    grid = {"z": POSE["z"], "rx": [0.0, POSE["rx"]], "ry": POSE["ry"]}
    groups = {entry.group for entry in VARIABLES.values()} - {"always"}
    return ks.sweep(robot, platform=grid, load=[0, 0, -500, 0, 0, 0], outputs=groups, modes=2)


def test_every_result_property_is_in_the_table():
    left = {"configuration", "robot", "shape", "payload", "facts", "by_mechanism", "limbs", "beams", "warnings", "centre_lines"}
    left |= {"payload_coefficients", "joint_contributions", "axial_contributions", "second_order"}  # of which people get sums
    left |= {"interface_contributions", "margins"}  # for pictures; has entries of its own
    mine = {name for name, item in vars(ks.Result).items() if isinstance(item, cached_property) and not name.startswith("_")}
    assert mine - left == {path for path in QUANTITIES if "." not in path}


@pytest.mark.parametrize("path", IN_RESULTS)
def test_results_have_axes_and_units_of_the_table(path, result, robot):
    entry, value, (owner, _, name) = IN_RESULTS[path], value_at(result, path), path.rpartition(".")
    dims = (*(["limb"] if owner == "limbs" else []), *entry.dims)
    labels = {dim: names for dim, names in axes_of(robot.statics).items() if dim != "source"}
    while hasattr(value, "items"):
        dim, dims = dims[0], dims[1:]
        assert list(value) == list(labels.get(dim, value))
        value = next(iter(value.values()), ())
    if not isinstance(value, tuple):  # parts of a limb
        assert np.ndim(value) == len(dims) and all(np.shape(value)[k] == 6 for k, dim in enumerate(dims) if dim == "component")
    limb, beam = ks.results.LimbResult, ks.results.BeamResult
    kind = {"": ks.Result, "limbs": limb, "beams": beam, "configuration": ks.Configuration}.get(owner)
    doc = inspect.getdoc(getattr(kind, name)) if hasattr(kind, name) else None
    if doc and entry.units and name not in ("actuators", "q"):
        told = {item for found in re.findall(r"\[([^\]]+)\]", doc) for item in re.split(", | or ", found)}
        assert {*entry.units.split(", ")} <= told or {*entry.units.split(", ")} == {"1"}, doc


def test_json_has_names_and_units_of_the_table(result):
    found = result.to_dict()
    limb, beam = found["limbs"]["limb_1"], found["beams"]["rod_1"]
    for path, entry in IN_RESULTS.items():
        owner, _, name = path.rpartition(".")
        if owner == "" and name not in ("status", *FACTS):
            assert name in found and found["units"][name] == f"{entry.words} [{entry.units}]"
        assert owner != "limbs" or name in limb
        assert owner != "beams" or name == "deflection" or name in beam


@pytest.mark.parametrize("name", VARIABLES)
def test_maps_have_axes_units_and_words_of_the_table(name, ds, robot):
    entry, item = VARIABLES[name], ds[name]
    assert item.dims == (*(["rx"] if "coordinate" in entry.varies else []), *entry.dims)
    assert item.attrs["long_name"] == entry.words and item.dtype == entry.dtype
    if entry.unit in UNITS:
        assert {*ds[item.attrs["unit_coordinate"]].dims} <= {*entry.dims} and item.attrs["unit_coordinate"] == entry.unit
        assert {*ds[entry.unit].values.ravel()} & {*entry.units.replace("·", " ").split(", ")}
    else:
        assert item.attrs.get("units", "") == entry.unit
    for dim, labels in axes_of(robot.statics).items():
        assert dim not in entry.dims or tuple(ds[dim].values) == labels


@pytest.mark.parametrize("name", [name for name in PATHS if name != "residual_error"])
def test_functions_and_c_have_axes_and_units_of_the_table(name, robot):
    output = ks.compile(robot, tuple(POSE), outputs=name, engine="numpy").outputs[name]
    entry = QUANTITIES[PATHS[name]]
    assert output.name == name and tuple(output.axes) == entry.dims and output.meaning.startswith(entry.words)
    assert all(output.axes[dim] == axes_of(robot.statics)[dim] for dim in entry.dims)
    assert {*entry.units.split(", ")} & {*", ".join(output.units).split(", ")} or output.units == ("1",)
    assert _words(output, str).startswith(entry.words)


def test_computed_quantities_equal_those_of_results_and_maps(result, ds, robot):
    solution, labels = result.solutions[0], {**axes_of(robot.statics), "source": tuple(result.contributions)}
    for name, of in COMPUTED.items():
        np.testing.assert_array_equal(
            stacked(value_at(result, name), QUANTITIES[name].dims, labels), of(robot.statics, solution)[..., 0]
        )
    pose = ks.analyze(robot.assemble(platform=POSE), [0, 0, -500, 0, 0, 0])
    for path, entry in IN_RESULTS.items():
        if entry.variable and not path.startswith("limbs."):
            value = stacked(value_at(pose, path), entry.dims, {**axes_of(robot.statics), "beam": tuple(ds.beam.values)})
            there = ds[entry.variable].isel(rx=-1) if "coordinate" in entry.varies else ds[entry.variable]
            np.testing.assert_allclose(
                there.values, value, rtol=1e-9, atol=1e-12 * np.max(np.abs(value), initial=0.0), err_msg=path
            )
