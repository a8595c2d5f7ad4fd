"""Unknowns of a calibration: stiffnesses, arguments of the robot's file, assembly errors, a payload, offsets of gauges.

The fit varies quantities in which the readings of a statically determinate robot are linear. These varied quantities are the
unknowns, with two exceptions: the compliance factor c = 1 / factor replaces the factor of a stiffness; if the payload's mass is
unknown, its first moments replace its centre. Combinations of unknowns that no reading determines span the null space of the
Jacobian.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from kinetostatics.arguments import Keyword, names_in
from kinetostatics.description.loads import Gauge, Payload
from kinetostatics.description.robot_description import RobotDescription
from kinetostatics.exceptions import ArgumentError, near_names
from kinetostatics.layout.mapping import ResultMapping
from kinetostatics.layout.numbers import join_words
from kinetostatics.math.arrays import Array, Mask
from kinetostatics.math.linalg import pivot_rows
from kinetostatics.parametric.parametric_robot import ParametricRobot
from kinetostatics.parametric.robot_numbers import RobotNumber, as_assembly_errors
from kinetostatics.results.calibration import Unidentifiable
from kinetostatics.robot import Robot

#: Unknowns of the payload, and their units.
PAYLOAD = {"payload.mass": "kg", "payload.x": "m", "payload.y": "m", "payload.z": "m"}
#: Kinds of elastic parts, as in :attr:`kinetostatics.Result.source_contributions`, and the names of their stiffness numbers.
KINDS = {
    "beams": ("youngs_modulus", "shear_modulus"),
    "links": ("stiffness_factor",),
    "joints": ("linear_stiffness", "angular_stiffness"),
    "actuators": ("actuator_stiffness",),
}
EXAMPLE = '["rod_1", "payload.mass", "offset.dz"]'


@dataclass(frozen=True)
class Unknown:
    """An unknown of a calibration.

    Attributes:
        kind: "stiffness", "argument", "error" (of assembly), "payload" or "offset".
        unit: SI unit of the unknown.
        start: initial value of the varied quantity.
        scale: typical change of the varied quantity.
        parts: pairs such as ("beams", "rod_1") of the parts with the stiffness; or one pair ("payload", component),
            ("offset", gauge) or ("error", name); empty for an argument.
    """

    name: str
    kind: str
    unit: str
    start: float
    scale: float
    parts: tuple[tuple[str, str], ...] = ()


class Unknowns:
    """All p unknowns, and the robot, assembly errors and payload for values of the varied quantities.

    Args:
        robot: the nominal robot.
        names: names of the unknowns.
        gauges: gauges with readings; only these have offsets.
        payload: initial payload; None: no payload, or 1 kg at o if its mass or centre is an unknown.
        sizes: magnitude of the readings of each gauge.
    """

    def __init__(
        self, robot: Robot, names: object, gauges: Mapping[str, Gauge], payload: Payload | None, sizes: Mapping[str, float]
    ) -> None:
        self.robot, self.payload, self._robots = robot, payload or Payload(0.0), ParametricRobot(robot)
        given = names_in("unknowns", names, EXAMPLE)  # type: ignore[arg-type]
        names = [name.strip() for name in given]
        if "offsets" in names:
            at = names.index("offsets")
            names[at : at + 1] = [f"offset.{gauge}" for gauge in gauges]
        if not names:
            raise ArgumentError(f"unknowns are empty; name at least one: {EXAMPLE}")
        self._gauges, self._sizes = gauges, sizes
        self._carried = any(name in PAYLOAD for name in names)
        self.by_moments = "payload.mass" in names
        self.items = tuple(map(self._unknown, names))
        every = [part for unknown in self.items for part in unknown.parts or ((unknown.kind, unknown.name),)]
        if twice := next((part for part in every if every.count(part) > 1), None):
            raise ArgumentError(f"unknowns: {twice[1]!r} is named twice")

    @cached_property
    def start(self) -> Array:
        """Initial values (p,) of the varied quantities."""
        return np.array([unknown.start for unknown in self.items])

    @cached_property
    def scale(self) -> Array:
        """Typical changes (p,) of the varied quantities."""
        return np.array([unknown.scale for unknown in self.items])

    @cached_property
    def _sources(self) -> dict[str, tuple[str, str]]:
        there = self.robot.description
        every = [("beams", name) for name in there.beams] + [("links", name) for name in there.flexible]
        every += [(kind, name) for name in there.joint_stiffness for kind in ("joints", "actuators")]
        sources = [(kind, name) for kind, name in every if self._stiffnesses(kind, name)]
        names = [name for _, name in sources]
        named = {f"{kind}:{name}": (kind, name) for kind, name in sources}
        return {**named, **{name: (kind, name) for kind, name in sources if names.count(name) == 1}}

    def _stiffnesses(self, kind: str, name: str) -> list[RobotNumber]:
        every = (self._robots.every_part.get(f"{name}.{quantity}", ()) for quantity in KINDS[kind])
        return [number for numbers in every for number in numbers if number.step is not None]

    def _unknown(self, name: str) -> Unknown:
        parts = tuple(part.strip() for part in name.split("+"))
        if name in PAYLOAD:
            masses = float(np.asarray(self.payload.mass)) or 1.0
            start = masses if name == "payload.mass" else float(np.asarray(self.payload.center)["xyz".index(name[-1])])
            scale = masses if name == "payload.mass" else self.robot.length
            if name != "payload.mass" and self.by_moments:
                start, scale = start * masses, scale * masses
            return Unknown(name, "payload", PAYLOAD[name], start, scale, (("payload", name[8:]),))
        if name.startswith("offset.") and name[7:] in self._gauges:
            unit = "m" if self._gauges[name[7:]].kind == "length" else "rad"
            return Unknown(name, "offset", unit, 0.0, self._sizes[name[7:]], (("offset", name[7:]),))
        if all(part in self._sources for part in parts):
            return Unknown(name, "stiffness", "", 1.0, 1.0, tuple(self._sources[part] for part in parts))
        if name in self._robots.errors:
            error = self._robots.errors[name]
            scale = {"m": self.robot.length, "rad": 1.0, "K": 100.0}[error.unit]
            return Unknown(name, "error", error.unit, 0.0, scale, (("error", name),))
        arguments: Mapping[str, float] = {}
        reason = ""
        if "." not in name and len(parts) == 1:
            try:
                arguments = self._robots.arguments
            except ArgumentError as error:
                reason = f"; {error}"
        if name not in (*self._robots.parts, *arguments):
            names = [*self._sources, *arguments, *PAYLOAD, *(f"offset.{gauge}" for gauge in self._gauges), "offsets"]
            names += [*self._robots.parts, *self._robots.errors] if "." in name else []
            wrong = next((part for part in parts if part not in self._sources), name)
            raise ArgumentError(
                f"unknowns: {self.robot.name!r} has no {wrong!r}; give a beam, elastic joint or actuator, an argument of the "
                f"file, a number of a part, JOINT.error.rx, payload.mass, payload.x or offset.GAUGE: "
                f"{near_names(wrong, names)}{reason}"
            )
        number = self._robots.number(name)
        scale = abs(number.value) or (1.0 if name in arguments else self.robot.length)
        return Unknown(name, "argument", "" if number.unit == "1" else number.unit, number.value, scale)

    # ---- robot, errors and payload for values of the unknowns ---------------------------------------------------------

    def described(self, values: Array) -> RobotDescription:
        """Return the robot with the values (p,) of the varied quantities, without assembly errors, payload and offsets.

        Raises:
            RobotFileError: the values yield no robot.
        """
        pairs = list(zip(self.items, map(float, values), strict=True))
        description = self._robots.description({unknown.name: value for unknown, value in pairs if unknown.kind == "argument"})
        for unknown, value in pairs:
            for part in unknown.parts if unknown.kind == "stiffness" else ():
                for number in self._stiffnesses(*part):
                    description = number.changed_in(description, (1 / value - 1) * number.of(description))
        return description

    def errors(self, values: Array) -> dict[str, Keyword]:
        """Return the assembly errors as an argument of :func:`kinetostatics.analyze`, in arrays for one pose."""
        pairs = [(unknown.name, value) for unknown, value in zip(self.items, values, strict=True) if unknown.kind == "error"]
        errors = [self._robots.errors[name] for name, _ in pairs]
        return as_assembly_errors(errors, np.array([[value] for _, value in pairs])) if pairs else {}

    def payload_of(self, values: Array) -> tuple[float, Array, Array]:
        """Return (mass [kg], first moment m (3,) about o in platform axes [kg·m], derivative (3,) of m by the mass [m])."""
        given = {
            unknown.parts[0][1]: float(v) for unknown, v in zip(self.items, values, strict=True) if unknown.kind == "payload"
        }
        mass = given.get("mass", float(np.asarray(self.payload.mass)) or (1.0 if self._carried else 0.0))
        arm, moment = np.array(self.payload.center, dtype=float), np.zeros(3)
        for k, axis in enumerate("xyz"):
            if axis in given and self.by_moments:
                moment[k], arm[k] = given[axis], 0.0
            elif axis in given:
                arm[k] = given[axis]
        return mass, moment + mass * arm, arm

    def reported(self, values: Array) -> tuple[Array, Array]:
        """Return the unknowns (p,) for values of the varied quantities, and their derivatives (p, p) by these.

        The centre of a payload without mass is NaN.
        """
        mass, moment, _ = self.payload_of(values)
        names = [unknown.name for unknown in self.items]
        factors, reported = np.eye(len(values)), np.array(values, dtype=float)
        for k, unknown in enumerate(self.items):
            if unknown.kind == "stiffness":
                reported[k], factors[k, k] = 1 / values[k], -1 / values[k] ** 2
            elif unknown.kind == "payload" and self.by_moments and unknown.name != "payload.mass":
                reported[k] = moment["xyz".index(unknown.name[-1])] / mass if mass else math.nan
                factors[k, k] = 1 / mass if mass else math.nan
                factors[k, names.index("payload.mass")] = -reported[k] * factors[k, k]
        return reported, factors


#: Changes of an unknown up to this bound, relative to the largest change in a direction, count as zero.
NOTHING = 1e-5


def identifiable_ones(null: Array) -> Mask:
    """Return a mask (p,): True for identifiable unknowns, which have no component in the null space's basis (p, k)."""
    return np.asarray(~np.any(np.abs(null) > NOTHING * np.abs(null).max(initial=0.0), axis=1))


def unidentifiable(unknowns: Sequence[Unknown], null: Array) -> tuple[Unidentifiable, ...]:
    """Return the unidentifiable combinations of p unknowns.

    ``null`` (p, k): basis of changes that affect no reading, in units of the unknowns' scales.
    """
    return tuple(_combination(unknowns, direction) for direction in _sparse_basis(null).T)


def _sparse_basis(null: Array) -> Array:
    """Return a basis (p, k) of the space spanned by ``null`` (p, k) that has many zeros.

    In k pivot rows it is the identity, but each column is scaled to a largest entry of ±1.
    """
    basis = null @ np.linalg.inv(null[pivot_rows(null)])
    basis = basis / np.abs(basis).max(axis=0, initial=0.0)
    return np.where(np.abs(basis) < NOTHING, 0.0, basis)


def _combination(unknowns: Sequence[Unknown], direction: Array) -> Unidentifiable:
    involved = np.flatnonzero(direction).tolist()
    changes = ResultMapping({unknowns[k].name: float(direction[k]) for k in involved})
    names = [
        f"the compliance of {join_words([name for _, name in unknown.parts])}" if unknown.kind == "stiffness" else unknown.name
        for unknown in (unknowns[k] for k in involved)
    ]
    if len(involved) == 1:
        return Unidentifiable(changes, f"no reading depends on {names[0]}")
    beginning = f"{', '.join(names[:-1])} and {names[-1]} cannot be distinguished"
    if len(involved) == 2:
        weight = float(-direction[involved[0]] / direction[involved[1]])
        sign, kind = ("−", "difference") if weight < 0 else ("+", "sum")
        what = f"their {kind}" if abs(abs(weight) - 1) < 1e-4 else f"{names[0]} {sign} {abs(weight):.4g} times {names[1]}"
        return Unidentifiable(changes, f"{beginning}: the readings depend only on {what}, relative to the values in the file")
    return Unidentifiable(changes, f"{beginning}: a change of all in a fixed ratio changes no reading")
