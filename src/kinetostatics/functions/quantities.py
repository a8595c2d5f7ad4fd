"""What a function of a robot takes and returns: names, shapes, units, frames."""

from __future__ import annotations

from collections.abc import Sequence

from kinetostatics.exceptions import ArgumentError, near_names
from kinetostatics.functions.values import ALWAYS, Quantity
from kinetostatics.math.orientation import orientation_named
from kinetostatics.math.screws import TWIST_UNITS
from kinetostatics.robot import Robot
from kinetostatics.statics.springs import sources_of

_WRENCH = ("N", "N", "N", "N·m", "N·m", "N·m")
_TWIST = ("dx", "dy", "dz", "rx", "ry", "rz")


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
    wrench = "external force and moment on the platform about o, world axes"
    found.append(Quantity("load", (6,), _WRENCH, ("fx", "fy", "fz", "mx", "my", "mz"), wrench))
    found.append(Quantity("gravity", (3,), ("m/s²",) * 3, ("x", "y", "z"), "gravity, world axes"))
    return {item.name: item for item in found}


def outputs_of(robot: Robot, asked: Sequence[str], compensate: bool) -> dict[str, Quantity]:
    """Return the outputs of a function by name: those that are asked for, status and residual.

    Raises:
        ArgumentError: there is no such output.
    """
    actuators = robot.description.driven
    kinds = [robot.mechanism.connections[name].type for name in actuators]
    sources = sources_of(robot.statics)
    status = "kinetostatics.Status; no number is valid at UNREACHABLE and SINGULAR"
    if compensate:
        status += "; UNREACHABLE also where no correction was found"
    known = [
        Quantity("twist", (6,), TWIST_UNITS, _TWIST, "displacement and rotation of the platform at o, world axes"),
        Quantity(
            "contributions",
            (6, len(sources)),
            TWIST_UNITS,
            sources,
            "what load and weights contribute to the twist, one a column",
        ),
        Quantity("stiffness", (6, 6), ("N/m, N, N·m",), _TWIST, "stiffness matrix at o, world axes"),
        Quantity("compliance", (6, 6), ("m/N, 1/N, 1/(N·m)",), _TWIST, "compliance matrix at o, world axes"),
        Quantity(
            "actuator_forces",
            (len(actuators),),
            tuple(kind.force_unit for kind in kinds),
            actuators,
            "force or torque of each actuator, positive along its coordinate",
        ),
        Quantity(
            "actuators",
            (len(actuators),),
            tuple(kind.unit for kind in kinds),
            actuators,
            "corrected coordinates of the actuators" if compensate else "actuators' coordinates",
        ),
        Quantity("status", (), ("1",), meaning=status),
        Quantity("residual", (), ("m or rad",), meaning="how far the worst loop is open"),
    ]
    if compensate:
        words = "by how much the loaded platform misses the pose that was asked for, at o, world axes"
        known.append(Quantity("remaining", (6,), TWIST_UNITS, _TWIST, words))
    by_name = {item.name: item for item in known}
    for name in asked:
        if name == "remaining" and not compensate:
            raise ArgumentError("the output 'remaining' is of functions that compensate: compile(…, compensate=True)")
        if name not in by_name:
            raise ArgumentError(f"no output {name!r}: {near_names(name, by_name)}")
    return {name: by_name[name] for name in dict.fromkeys((*asked, *ALWAYS))}
