"""Inputs and outputs of a function of a robot, with names, shapes, units and frames; results of a call."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.arguments import names_in
from kinetostatics.exceptions import ArgumentError, near_names
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.layout.mapping import ResultMapping
from kinetostatics.load_case import LoadCase
from kinetostatics.math.arrays import Array
from kinetostatics.math.rotations import orientation_named
from kinetostatics.quantities import COMPUTED, QUANTITIES, axes_of, units_along
from kinetostatics.robot import Robot

#: A pose of the test program: coordinates, load, gravity, Python's outputs and status.
Reference: TypeAlias = tuple[dict[str, float], Array, Array, dict[str, Array], int]
#: Inputs of every function in addition to coordinates.
LOADS = ("load", "gravity")
#: Outputs of every function in addition to the requested ones.
ALWAYS = ("status", "residual")
#: Largest gap of a loop [m, rad] at a reached pose.
TOLERANCE = 1e-10
#: The possible outputs of functions, each with the attribute of the result from which it is taken.
PATHS: Mapping[str, str] = {
    **{name: name for name in (*COMPUTED, "status") if name not in LOADS},
    **{name: f"configuration.{name}" for name in ("actuators", "residual")},
    "residual_error": "sweep.residual_error",
}
#: Additions to the descriptions of some outputs, without and with compensation.
_MORE = {"status": "; kinetostatics.Status; no number is valid at UNREACHABLE and SINGULAR"}
_MORE_CORRECTED = {"actuators": ", corrected", "status": f"{_MORE['status']}; UNREACHABLE also where no correction was found"}


@dataclass(frozen=True)
class Quantity:
    """An input, an output or a parameter of a function.

    Attributes:
        name: its name.
        shape: shape without batch axes.
        units: one unit for all components, or the units along the last axis.
        axes: names of its axes, each with the labels along the axis.
        meaning: description with frame and reference point.
    """

    name: str
    shape: tuple[int, ...]
    units: tuple[str, ...]
    axes: Mapping[str, tuple[str, ...]] = field(default_factory=dict, hash=False)
    meaning: str = ""

    def __str__(self) -> str:
        units = ", ".join(dict.fromkeys(self.units))
        shape = f" {self.shape}" if self.shape else ""
        return f"{self.name}{shape} [{units}]" + (f": {self.meaning}" if self.meaning else "")


class Values(ResultMapping[str, Array]):
    """Result of a function: arrays by name, batch axes first, and the pose.

    Attributes:
        origin: the pose in the form from which compiled code starts, for ``near=`` of the next call; None if compiled code
            cannot start there.
    """

    def __init__(self, arrays: Mapping[str, Array], pose: Callable[[], Configuration], origin: object = None) -> None:
        super().__init__(arrays)
        self._made, self.origin = pose, origin

    @cached_property
    def pose(self) -> Configuration:
        """The pose or poses, for instance as ``near=`` of the next call."""
        return self._made()

    def __reduce__(self) -> tuple[object, ...]:
        """Pickle the pose, not the function that computes it."""
        return _known, (self.copy(), self.pose)


def flat_loads(load: ArrayLike, gravity: ArrayLike, *shapes: tuple[int, ...]) -> tuple[Array, Array, tuple[int, ...]]:
    """Return load (6, N), gravity (3, N) and the batch shape to which both are broadcast, together with ``shapes``.

    Raises:
        ArgumentError: a number is not finite, or shapes do not fit.
    """
    arrays = LoadCase(load, gravity).arrays[:2]
    try:
        shape = np.broadcast_shapes(*shapes, *(array.shape[:-1] for array in arrays))
    except ValueError:
        raise ArgumentError("the shapes of coordinates, load and gravity do not fit together") from None
    wrench, field = (np.broadcast_to(array, (*shape, array.shape[-1])).reshape(-1, array.shape[-1]).T for array in arrays)
    return wrench, field, shape


def _known(arrays: Mapping[str, Array], pose: Configuration) -> Values:
    return Values(arrays, lambda: pose)


def _quantity(robot: Robot, path: str, more: Mapping[str, str]) -> Quantity:
    """Return a quantity of :data:`QUANTITIES` with the labels and units of a robot."""
    entry, name = QUANTITIES[path], path.rpartition(".")[2]
    labels = axes_of(robot.statics)
    axes = {dim: labels[dim] for dim in entry.dims}
    units = np.array(units_along(robot.statics).get(entry.unit, [entry.units or "1"]))
    written = units.tolist() if units.ndim == 1 else [", ".join(dict.fromkeys(units.ravel().tolist()))]
    return Quantity(name, tuple(map(len, axes.values())), tuple(written), axes, entry.words + more.get(name, ""))


def inputs_of(robot: Robot, names: Sequence[str], by_actuators: bool, orientation: str | None) -> dict[str, Quantity]:
    """Return the inputs of a function by name: coordinates of the actuators or of the platform, load and gravity."""
    connections = robot.mechanism.connections
    quantities = []
    for name in names:
        if by_actuators:
            quantities.append(Quantity(name, (), (connections[name].type.unit,), meaning="coordinate of the actuator"))
        elif name in "xyz":
            quantities.append(Quantity(name, (), ("m",), meaning="coordinate of o, world axes"))
        else:
            words = f"orientation of the platform, {orientation_named(orientation).name}"
            quantities.append(Quantity(name, (), ("rad",), meaning=words))
    return {quantity.name: quantity for quantity in (*quantities, _quantity(robot, "load", {}), _quantity(robot, "gravity", {}))}


def outputs_of(robot: Robot, requested: Sequence[str], compensate: bool) -> dict[str, Quantity]:
    """Return the outputs of a function by name: the requested outputs, status and residual.

    Raises:
        ArgumentError: an output is unknown.
    """
    paths = {name: path for name, path in PATHS.items() if compensate or name != "residual_error"}
    for name in requested:
        if name == "residual_error" and not compensate:
            raise ArgumentError("only functions with compensation have the output 'residual_error': compile(…, compensate=True)")
        if name not in paths:
            raise ArgumentError(f"no output {name!r}: {near_names(name, paths)}")
    more = _MORE_CORRECTED if compensate else _MORE
    return {name: _quantity(robot, paths[name], more) for name in dict.fromkeys((*requested, *ALWAYS))}


def listed(what: str, names: str | Sequence[str], example: str) -> tuple[str, ...]:
    return (names,) if isinstance(names, str) else names_in(what, names, example)
