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

#: Numbers of parts that tell where something is: a per cent of their value means nothing.
LOCATIONS = ("placement", "predecessor_placement", "successor_placement", "center_of_mass")


def is_part(name: str) -> bool:
    """Return whether a name is that of a number of one part, not of an argument of the file."""
    return "." in name


def is_location(name: str) -> bool:
    """Return whether a name is that of a component of a placement or of a centre of mass."""
    return name.count(".") > 1 and name.split(".")[-2] in LOCATIONS


#: What is differentiated.
QUANTITIES = ("twist", "stiffness", "compliance", "actuator_forces", "actuators", "mass")


@dataclass(frozen=True, eq=False, repr=False)
class Sensitivity(ShortRepr):
    """Derivatives with respect to one parameter, per unit of it; batch axes first. With a tool, its tip takes the place of o.

    Attributes:
        name: of the parameter, or of the part that deforms.
        value: of the parameter.
        unit: of the parameter, SI; empty where it is not known.
        derivatives: of all quantities that were asked for, by name; they are attributes, too: ``twist`` (…, 6) [m, rad],
            ``stiffness`` and ``compliance`` (…, 6, 6) at o, actuators locked, ``actuator_forces`` (…) by actuator [N or N·m],
            ``actuators`` (…), coordinates [m, rad] of the actuators at the same coordinates of the platform, ``mass`` (…) [kg].
        exact: whether only the file's constants were differenced.
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
class Sensitivities(Reported, builder="reports.sensitivities:sensitivities_report"):
    """Derivatives with respect to parameters of the robot, and to the stiffness of every elastic part.

    ``s["rod_diameter"]`` is a :class:`Sensitivity`; iterating yields names, the most effective first.

    Attributes:
        result: the analysis about which it is differentiated.
        parameters: arguments of the file and numbers of parts by name, the one that moves o, or the tool's tip, most per part of
            its value first; then placements and centres of mass, the one that moves it most per length or angle first.
        sources: −∂twist/∂ln(stiffness) of each beam, elastic joint and actuator (…, 6) [m, rad] by name: the part of the twist
            that it makes, which is exact. One per cent more stiffness takes one per cent of it away.
        skipped: parameters that make no robot when they are changed a little, and why.
        tool: (3,) the point of the platform that twist and stiffness are told of, from o in its axes [m]; None: o.
        outputs: the quantities that were asked for. Without the twist there are no ``sources``.
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
        """Twist and stiffness about which it is differentiated: those of the tool's tip, or of o."""
        return self.result.seen_from(self.tool)

    @cached_property
    def worst(self) -> tuple[int, ...]:
        """Index in the batch of the largest displacement of o, or of the tool's tip: the pose at which effects are reported."""
        size = np.linalg.norm(np.nan_to_num(self.seen.twist[..., :3]), axis=-1)
        return tuple(int(k) for k in np.unravel_index(int(np.argmax(size)), size.shape)) if size.shape else ()

    def effect(self, name: str) -> tuple[float, float]:
        """Return by how much one per cent more of a parameter moves o along its displacement [m], and adds to the mass [kg].

        Both are zero for a parameter that is zero, NaN where it was not asked for.
        """
        item, one_per_cent = self[name], 0.01 * abs(self[name].value)
        move = self._along(item.twist) if "twist" in self.outputs else math.nan
        return one_per_cent * move, one_per_cent * (float(item.mass[self.worst]) if "mass" in self.outputs else math.nan)

    def shift_effect(self, name: str) -> float:
        """Return by how much a millimetre or milliradian of a placement or centre of mass moves o along its displacement [m].

        NaN where the twist was not asked for.
        """
        return 1e-3 * self._along(self[name].twist) if "twist" in self.outputs else math.nan

    def order(self, name: str) -> tuple[bool, float]:
        """Return the sort key of parameters: by size of the effect, placements last."""
        effect = self.shift_effect(name) if is_location(name) else self.effect(name)["twist" not in self.outputs]
        return is_location(name), 0.0 if math.isnan(effect) else -abs(effect)

    def source_effect(self, name: str) -> float:
        """Return by how much one per cent more stiffness of something moves o along its displacement [m]."""
        return -0.01 * self._along(self.sources[name])

    def _along(self, twist: Array) -> float:
        whole = self.seen.twist[self.worst][:3]
        size = float(np.linalg.norm(whole))
        return float(twist[self.worst][:3] @ whole) / size if size > 0 else 0.0
