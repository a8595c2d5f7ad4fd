"""Derivatives by parameters of a robot; :func:`kinetostatics.sensitivities` computes them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from kinetostatics.exceptions import ArgumentError, near_names
from kinetostatics.layout.mapping import ShortRepr
from kinetostatics.layout.report import Reported
from kinetostatics.math.arrays import Array
from kinetostatics.results.result import Result

#: Dimensions of parts whose relative changes have no meaning, because they are positions.
LOCATIONS = ("placement", "predecessor_placement", "successor_placement", "center_of_mass")


def is_part(name: str) -> bool:
    """Return whether a name denotes a dimension of a part, not an argument of the file."""
    return "." in name


def is_location(name: str) -> bool:
    """Return whether a name denotes a component of a placement or of a centre of mass."""
    return name.count(".") > 1 and name.split(".")[-2] in LOCATIONS


#: Quantities that are differentiated.
QUANTITIES = ("twist", "stiffness", "compliance", "actuator_forces", "actuators", "mass")


@dataclass(frozen=True, eq=False, repr=False)
class Sensitivity(ShortRepr):
    """Derivatives per unit of one parameter; batch axes first. With a tool, the reference point is its tip instead of o.

    Attributes:
        name: name of the parameter.
        value: value of the parameter.
        unit: SI unit of the value; empty if unknown.
        derivatives: derivatives of all outputs by name, also available as attributes: ``twist`` (…, 6) [m, rad]; ``stiffness``
            and ``compliance`` (…, 6, 6) at o, actuators locked; ``actuator_forces`` (…) by actuator [N or N·m]; ``actuators``
            (…), their coordinates [m, rad], while the coordinates used for assembly are constant; ``mass`` (…) [kg].
        exact: True if only the robot's constants are differentiated by finite differences; False if whole analyses are.
    """

    name: str
    value: float
    unit: str
    derivatives: Mapping[str, Array | Mapping[str, Array]]
    exact: bool

    def __getattr__(self, quantity: str) -> Any:  # twist, stiffness, …
        if quantity not in QUANTITIES:
            raise AttributeError(f"a sensitivity has no {quantity}")
        if quantity not in self.derivatives:
            raise ArgumentError(f"{quantity} is not among the outputs={tuple(self.derivatives)}")
        return self.derivatives[quantity]


@dataclass(frozen=True, eq=False, repr=False)
class Sensitivities(Reported):
    """Derivatives of results with respect to parameters of the robot and to the stiffness of every elastic part.

    ``s["rod_diameter"]`` is a :class:`Sensitivity`; iteration yields the names, the most influential parameter first.

    Attributes:
        result: the analysis at the nominal parameters.
        parameters: sensitivities by name: first arguments of the file and dimensions of parts, ranked by the change of
            displacement (without twist among the outputs: of mass) per 1 %; then placements and centres of mass, ranked by the
            change of displacement per mm or mrad.
        sources: −∂twist/∂ln(stiffness) (…, 6) [m, rad] for each beam, elastic joint and actuator, by name: the part of the twist
            due to its deformation.
        skipped: the parameters without derivatives, each with the reason why a small change of it makes the robot invalid.
        tool: (3,) reference point of twist and stiffness, from o in platform axes [m]; None: o.
        outputs: the requested quantities. Without the twist there are no ``sources``.
    """

    result: Result
    parameters: Mapping[str, Sensitivity]
    sources: Mapping[str, Array]
    skipped: Mapping[str, str] = field(default_factory=dict)
    tool: Array | None = None
    outputs: tuple[str, ...] = QUANTITIES

    def __getitem__(self, name: str) -> Sensitivity:
        if name not in self.parameters:
            raise ArgumentError(f"no sensitivity was computed for {name!r}: {near_names(name, self.parameters)}")
        return self.parameters[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.parameters)

    def __len__(self) -> int:
        return len(self.parameters)

    @cached_property
    def seen(self) -> Result:
        """The nominal result at the tool's tip, or at o."""
        return self.result.seen_from(self.tool)

    @cached_property
    def worst(self) -> tuple[int, ...]:
        """Batch index of the pose at which the displacement of the reference point is largest; effects are those at this pose."""
        size = np.linalg.norm(np.nan_to_num(self.seen.twist[..., :3]), axis=-1)
        return tuple(int(k) for k in np.unravel_index(int(np.argmax(size)), size.shape)) if size.shape else ()

    def effect(self, name: str) -> tuple[float, float]:
        """Return the changes of the displacement's magnitude [m] and of the mass [kg] if a parameter increases by 1 %.

        Both are zero if the parameter is zero, and NaN if twist or mass, respectively, is not among the outputs.
        """
        sensitivity, one_per_cent = self[name], 0.01 * abs(self[name].value)
        move = self._along(sensitivity.twist) if "twist" in self.outputs else math.nan
        return one_per_cent * move, one_per_cent * (float(sensitivity.mass[self.worst]) if "mass" in self.outputs else math.nan)

    def shift_effect(self, name: str) -> float:
        """Return the change of the displacement's magnitude [m] per mm or mrad of a placement or centre of mass.

        NaN if the twist is not among the outputs.
        """
        return 1e-3 * self._along(self[name].twist) if "twist" in self.outputs else math.nan

    def order(self, name: str) -> tuple[bool, float]:
        """Return the key by which parameters are sorted: those with large effects first, placements and centres of mass last."""
        displacement, mass = self.effect(name)
        effect = displacement if "twist" in self.outputs else mass
        if is_location(name):
            effect = self.shift_effect(name)
        return is_location(name), 0.0 if math.isnan(effect) else -abs(effect)

    def source_effect(self, name: str) -> float:
        """Return the change of the displacement's magnitude [m] if the stiffness of a part increases by 1 %."""
        return -0.01 * self._along(self.sources[name])

    def _along(self, twist: Array) -> float:
        whole = self.seen.twist[self.worst][:3]
        size = float(np.linalg.norm(whole))
        return float(twist[self.worst][:3] @ whole) / size if size > 0 else 0.0
