"""Inputs and outputs of a function of a robot: names, shapes, units, frames."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from kinetostatics.exceptions import ArgumentError, near_names
from kinetostatics.functions.values import ALWAYS, LOADS, Quantity
from kinetostatics.math.rotations import orientation_named
from kinetostatics.quantities import COMPUTED, QUANTITIES, axes_of, units_along
from kinetostatics.robot import Robot

#: Paths in a result of the possible outputs of functions, by name.
PATHS: Mapping[str, str] = {
    **{name: name for name in (*COMPUTED, "status") if name not in LOADS},
    **{name: f"configuration.{name}" for name in ("actuators", "residual")},
    "residual_error": "sweep.residual_error",
}
#: Additional descriptions of some outputs, and of some with compensation.
_MORE = {"status": "; kinetostatics.Status; no number is valid at UNREACHABLE and SINGULAR"}
_MORE_CORRECTED = {"actuators": ", corrected", "status": f"{_MORE['status']}; UNREACHABLE also where no correction was found"}


def _quantity(robot: Robot, path: str, more: Mapping[str, str]) -> Quantity:
    """Return a quantity of the table with the labels and units of a robot."""
    entry, name = QUANTITIES[path], path.rpartition(".")[2]
    labels = axes_of(robot.statics)
    axes = {dim: labels[dim] for dim in entry.dims}
    units = np.array(units_along(robot.statics).get(entry.unit, [entry.units or "1"]))
    written = units.tolist() if units.ndim == 1 else [", ".join(dict.fromkeys(units.ravel().tolist()))]
    return Quantity(name, tuple(map(len, axes.values())), tuple(written), axes, entry.words + more.get(name, ""))


def inputs_of(robot: Robot, names: Sequence[str], by_actuators: bool, orientation: str | None) -> dict[str, Quantity]:
    """Return the inputs of a function by name: coordinates of the actuators or of the platform, load and gravity."""
    connections = robot.mechanism.connections
    found = []
    for name in names:
        if by_actuators:
            found.append(Quantity(name, (), (connections[name].type.unit,), meaning="coordinate of the actuator"))
        elif name in "xyz":
            found.append(Quantity(name, (), ("m",), meaning="coordinate of o, world axes"))
        else:
            words = f"orientation of the platform, {orientation_named(orientation).name}"
            found.append(Quantity(name, (), ("rad",), meaning=words))
    return {item.name: item for item in (*found, _quantity(robot, "load", {}), _quantity(robot, "gravity", {}))}


def outputs_of(robot: Robot, asked: Sequence[str], compensate: bool) -> dict[str, Quantity]:
    """Return the outputs of a function by name: the requested ones, status and residual.

    Raises:
        ArgumentError: an output is unknown.
    """
    known = {name: path for name, path in PATHS.items() if compensate or name != "residual_error"}
    for name in asked:
        if name == "residual_error" and not compensate:
            raise ArgumentError("only functions with compensation have the output 'residual_error': compile(…, compensate=True)")
        if name not in known:
            raise ArgumentError(f"no output {name!r}: {near_names(name, known)}")
    more = _MORE_CORRECTED if compensate else _MORE
    return {name: _quantity(robot, known[name], more) for name in dict.fromkeys((*asked, *ALWAYS))}
