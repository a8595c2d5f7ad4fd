"""What a robot is asked for: quantities of its poses by name, and limits of them as people write them."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from kinetostatics.description.units import KINDS, parse_number, sized_example, sized_name, typed_number
from kinetostatics.exceptions import ArgumentError, near_names
from kinetostatics.math.arrays import Array
from kinetostatics.results.result import Result

_REQUIREMENT = re.compile(r"\s*([A-Za-z_]\w*)\s*(\([^()]*\)|:[^<>=≤≥]*)?\s*(<=|>=|<|>|≤|≥)\s*(.+)")


@dataclass(frozen=True)
class Measure:
    """A quantity of poses.

    Attributes:
        kind: of its numbers, as in :data:`kinetostatics.description.units.KINDS`; "number": without a unit.
        function: returns its numbers (P, k) from an analysis of P poses and the argument; NaN where a pose has none.
        argument: kind of the argument in brackets, if it has one.
        words: what it is.
        is_motion: whether it is another one at another point of the platform.
    """

    kind: str
    function: Callable[..., Array]
    argument: str | None
    words: str
    is_motion: bool = False


def _lengths(part: slice) -> Callable[[Result, float], Array]:
    return lambda result, _: np.linalg.norm(result.twist[..., part], axis=-1)[..., None]


def _largest_compliance(part: slice) -> Callable[[Result, float], Array]:
    def found(result: Result, size: float) -> Array:
        block = result.compliance[..., part, part]
        finite = np.asarray(np.all(np.isfinite(block), axis=(-2, -1)))
        values = np.linalg.eigvalsh(np.where(finite[..., None, None], block, 0.0))[..., -1:]
        return np.where(finite[..., None], size * values, np.nan)

    return found


def _least_stiffness(part: slice) -> Callable[[Result, float], Array]:
    def found(result: Result, _: float) -> Array:
        with np.errstate(divide="ignore"):
            return np.asarray(1 / _largest_compliance(part)(result, 1.0))

    return found


def _actuators(slides: bool) -> Callable[[Result, float], Array]:
    def found(result: Result, _: float) -> Array:
        connections = result.robot.mechanism.connections
        forces = [abs(f) for name, f in result.actuator_forces.items() if connections[name].type.is_slide == slides]
        if not forces:
            one, other = ("slides", "turn: actuator_torque") if slides else ("turns", "slide: actuator_force")
            hint = f"; its actuators {other}" if result.actuator_forces else ""
            raise ArgumentError(f"{result.robot.name!r} has no actuator that {one}{hint}")
        return np.stack(forces, axis=-1)

    return found


def _beams(attribute: str) -> Callable[[Result, float], Array]:
    def found(result: Result, _: float) -> Array:
        if not result.beams:
            raise ArgumentError(f"{result.robot.name!r} has no beams, and so no {attribute}")
        return np.stack([getattr(beam, attribute) for beam in result.beams.values()], axis=-1)

    return found


def mass_of(result: Result) -> Array:
    """Return the mass of everything (P,) [kg], whatever the loads are."""
    configuration = result.configuration
    masses = configuration.robot.weights.masses(configuration.frames).sum(axis=0)
    own = np.where(configuration.reached, masses, np.nan).reshape(configuration.shape)
    return np.broadcast_to(own, result.shape)


_D, _R = slice(3), slice(3, 6)
MEASURES: Mapping[str, Measure] = {
    "mass": Measure("mass", lambda result, _: mass_of(result)[..., None], None, "mass of the robot"),
    "sag": Measure("length", _lengths(_D), None, "displacement of o", True),
    "rotation": Measure("angle", _lengths(_R), None, "rotation of the platform"),
    "deflection_any_direction": Measure(
        "length", _largest_compliance(_D), "force", "largest displacement of o under a force", True
    ),
    "rotation_any_direction": Measure("angle", _largest_compliance(_R), "moment", "largest rotation under a moment"),
    "least_translational_stiffness": Measure(
        "stiffness", _least_stiffness(_D), None, "least stiffness against forces at o", True
    ),
    "least_rotational_stiffness": Measure("turning stiffness", _least_stiffness(_R), None, "least stiffness against moments"),
    "actuator_force": Measure("force", _actuators(True), None, "force of a sliding actuator"),
    "actuator_torque": Measure("moment", _actuators(False), None, "torque of a turning actuator"),
    "stress": Measure("stress", _beams("stress"), None, "largest von Mises stress of a beam"),
    "buckling": Measure("number", _beams("euler_ratio"), None, "forces over those at which it buckles"),
}


@dataclass(frozen=True)
class Requirement:
    """A limit of a quantity, which holds at every pose.

    Attributes:
        text: as it was written.
        name: of the quantity, and its ``argument`` (SI).
        argument: see ``name``.
        below: whether the quantity must be below the limit, or above.
        limit: SI.
    """

    text: str
    name: str
    argument: float
    below: bool
    limit: float

    def margins(self, values: Array) -> Array:
        """Return how far values are from the limit, as parts of it: negative where they break it, −1 where there is none."""
        found = 1 - values / self.limit if self.below else values / self.limit - 1
        return np.where(np.isnan(found), -1.0, np.minimum(found, 1e3))


def typed_unit(text: str) -> str:
    """Return the unit that a number was typed with, empty if there is none."""
    return (typed_number(text) or (0.0, ""))[1]


def _form(name: str) -> str:
    """Return a quantity as people write it, with a size if it takes one."""
    kind = MEASURES[name].argument
    return sized_example(name, KINDS[kind]) if kind else name


def parse_measure(text: object) -> tuple[str, float]:
    """Return name and argument of a quantity such as ``deflection_any_direction(500 N)``.

    Raises:
        ArgumentError: there is no such quantity.
    """
    if not isinstance(text, str):
        raise ArgumentError(
            f"minimize is {text!r}; it must be one quantity, such as 'mass'; requirements are given by subject_to"
        )
    name, argument = sized_name(text)
    if name not in MEASURES:
        raise ArgumentError(f"no quantity {name!r}: {near_names(name, map(_form, MEASURES))}")
    kind = MEASURES[name].argument
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
    name, argument = parse_measure(match[1] + (match[2] or ""))
    limit = parse_number(match[4], MEASURES[name].kind, str(text))
    if not limit > 0:
        raise ArgumentError(f"{text!r}: the limit must be greater than zero")
    return Requirement(" ".join(str(text).split()), name, argument, match[3] in ("<", "<=", "≤"), limit)
