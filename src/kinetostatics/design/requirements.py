"""Requirements: limits of quantities of a robot's poses, such as ``sag < 20um``."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from kinetostatics.description.units import KINDS, parse_number, sized_example, sized_name, typed_number
from kinetostatics.exceptions import ArgumentError, near_names
from kinetostatics.math.arrays import Array
from kinetostatics.measures import MEASURES, Measure
from kinetostatics.results.result import Result

_REQUIREMENT = re.compile(r"\s*([A-Za-z_]\w*)\s*(\([^()]*\)|:[^<>=≤≥]*)?\s*(<=|>=|<|>|≤|≥)\s*(.+)")


@dataclass(frozen=True)
class Requirable:
    """A quantity of poses that may be required or minimized.

    Attributes:
        kind: kind of its values, see :data:`kinetostatics.description.units.KINDS`; "number": dimensionless.
        function: computes its values (P, …, k) from an analysis, the analysis at the tool's tip, and the argument; NaN at poses
            without results.
        argument: kind of the argument in brackets, if any.
        words: definition.
        better: "small" or "large": which values are good.
    """

    kind: str
    function: Callable[[Result, Result, float], Array]
    argument: str | None
    words: str
    better: str = "small"


def _measured(measure: Measure) -> Requirable:
    """Return a measure of the twist or compliance at the tool's tip as a quantity that may be required or minimized."""

    def found(result: Result, tip: Result, size: float) -> Array:
        array = np.asarray(getattr(tip, measure.of))
        block = array[..., measure.part, measure.part] if measure.of != "twist" else array[..., measure.part]
        return measure.function(block, size or 1.0)[..., None]

    return Requirable(measure.kind, found, measure.argument, measure.definition, measure.better)


def _actuators(slides: bool) -> Callable[[Result, object, float], Array]:
    def found(result: Result, _: object, __: float) -> Array:
        connections = result.robot.mechanism.connections
        forces = [abs(f) for name, f in result.actuator_forces.items() if connections[name].type.is_slide == slides]
        if not forces:
            one, other = ("slides", "turn: actuator_torque") if slides else ("turns", "slide: actuator_force")
            hint = f"; its actuators {other}" if result.actuator_forces else ""
            raise ArgumentError(f"{result.robot.name!r} has no actuator that {one}{hint}")
        return np.stack(forces, axis=-1)

    return found


def _beams(attribute: str) -> Callable[[Result, object, float], Array]:
    def found(result: Result, _: object, __: float) -> Array:
        if not result.beams:
            raise ArgumentError(f"{result.robot.name!r} has no beams, and so no {attribute}")
        return np.stack([getattr(beam, attribute) for beam in result.beams.values()], axis=-1)

    return found


def mass_of(result: Result) -> Array:
    """Return the total mass (P,) [kg], independent of the loads."""
    configuration = result.configuration
    masses = configuration.robot.weights.masses(configuration.frames).sum(axis=0)
    own = np.where(configuration.reached, masses, np.nan).reshape(configuration.shape)
    return np.broadcast_to(own, result.shape)


#: All quantities by name.
REQUIRABLE: Mapping[str, Requirable] = {
    "mass": Requirable("mass", lambda result, _, __: mass_of(result)[..., None], None, "mass of the robot"),
    "sag": _measured(MEASURES["linear_sag"]),
    "rotation": _measured(MEASURES["angular_sag"]),
    **{name: _measured(MEASURES[name]) for name in ("deflection_any_direction", "rotation_any_direction")},
    **{name: _measured(MEASURES[name]) for name in ("least_translational_stiffness", "least_rotational_stiffness")},
    "actuator_force": Requirable("force", _actuators(True), None, "force of a sliding actuator"),
    "actuator_torque": Requirable("moment", _actuators(False), None, "torque of a turning actuator"),
    "stress": Requirable("stress", _beams("stress"), None, "largest von Mises stress of a beam"),
    "buckling": Requirable("number", _beams("euler_ratio"), None, "ratio of the forces to those at which the robot buckles"),
}


@dataclass(frozen=True)
class Requirement:
    """A limit of a quantity at every pose.

    Attributes:
        text: the requirement as given.
        name: name of the quantity.
        argument: its argument, SI.
        below: True for an upper limit, False for a lower limit.
        limit: limit, SI.
    """

    text: str
    name: str
    argument: float
    below: bool
    limit: float

    def margins(self, values: Array) -> Array:
        """Return the margins of values relative to the limit: negative if violated, −1 for NaN."""
        found = 1 - values / self.limit if self.below else values / self.limit - 1
        return np.where(np.isnan(found), -1.0, np.minimum(found, 1e3))


def typed_unit(text: str) -> str:
    """Return the unit given with a number; empty without a unit."""
    return (typed_number(text) or (0.0, ""))[1]


def _form(name: str) -> str:
    """Return a quantity as text, with a size if it takes one."""
    kind = REQUIRABLE[name].argument
    return sized_example(name, KINDS[kind]) if kind else name


def parse_quantity(text: object) -> tuple[str, float]:
    """Return name and argument of a quantity such as ``deflection_any_direction(500 N)``.

    Raises:
        ArgumentError: there is no such quantity.
    """
    if not isinstance(text, str):
        raise ArgumentError(
            f"minimize is {text!r}; it must be one quantity, such as 'mass'; requirements are given by subject_to"
        )
    name, argument = sized_name(text)
    if name not in REQUIRABLE:
        raise ArgumentError(f"no quantity {name!r}: {near_names(name, map(_form, REQUIRABLE))}")
    kind = REQUIRABLE[name].argument
    if (kind is None) != (argument is None):
        raise ArgumentError(f"{text.strip()!r}: write {_form(name)}" + (f", a {kind} in the brackets" if kind else ""))
    return name, parse_number(argument, kind or "", text) if argument is not None else 0.0


def parse_requirement(text: object) -> Requirement:
    """Return a requirement such as ``sag < 20um``.

    Raises:
        ArgumentError: it is invalid.
    """
    match = _REQUIREMENT.fullmatch(text) if isinstance(text, str) else None
    if match is None:
        raise ArgumentError(f"{text!r} is not of the form QUANTITY < LIMIT or QUANTITY > LIMIT, such as 'sag < 20um'")
    name, argument = parse_quantity(match[1] + (match[2] or ""))
    limit = parse_number(match[4], REQUIRABLE[name].kind, str(text))
    if not limit > 0:
        raise ArgumentError(f"{text!r}: the limit must be greater than zero")
    return Requirement(" ".join(str(text).split()), name, argument, match[3] in ("<", "<=", "≤"), limit)
