"""How much robots of one design differ, because their parts have tolerances; :func:`kinetostatics.spread` finds it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from kinetostatics.exceptions import ArgumentError, near_names
from kinetostatics.math.arrays import Array
from kinetostatics.math.screws import COMPONENTS
from kinetostatics.printing.dispatch import Told
from kinetostatics.printing.mappings import ShortRepr
from kinetostatics.results.result import Result
from kinetostatics.results.tool_point import seen

#: Components of a twist, by which one may ask for them.
#: Parts of a twist of which a distance is told, and where they are in it.
LENGTHS = {"displacement": slice(3), "rotation": slice(3, 6)}


@dataclass(frozen=True, eq=False, repr=False)
class SpreadQuantities(ShortRepr):
    """What tolerances change, or by how much: numbers of one pose, or of many robots, whose axis is the first.

    With a tool, its tip takes the place of o.

    Attributes:
        twist: (…, 6) at o [m, rad].
        displacement: (…) how far o is from where it is in the nominal robot, in any direction [m]; of the nominal robot the
            length of its displacement.
        rotation: (…) the same of the rotation [rad].
        stiffness: (…, 6, 6) at o, actuators locked.
        actuator_forces: (…) of each actuator [N or N·m], by actuator.
    """

    twist: Array
    displacement: Array
    rotation: Array
    stiffness: Array
    actuator_forces: Mapping[str, Array]

    def named(self, name: str) -> Array:
        """Return one: "displacement", "rotation", a component "x" … "rz" of the twist, or an actuator's force by its name.

        Raises:
            ArgumentError: there is none of that name.
        """
        if name in LENGTHS:
            return np.asarray(getattr(self, name))
        if name in COMPONENTS:
            return np.asarray(self.twist[..., COMPONENTS.index(name)])
        if name not in self.actuator_forces:
            known = [*LENGTHS, *COMPONENTS, *self.actuator_forces]
            raise ArgumentError(f"no quantity {name!r}: {near_names(name, known)}")
        return self.actuator_forces[name]


@dataclass(frozen=True)
class Toleranced:
    """A number of the robot that may be off.

    Attributes:
        name: of an argument of the robot's file, or of a number of a part: ``rod_1.outer_diameter``.
        value: its nominal value, SI.
        unit: of it; empty where it is not known.
        tolerance: by how much it may be off to either side.
        standard_deviation: with which it scatters.
    """

    name: str
    value: float
    unit: str
    tolerance: float
    standard_deviation: float


@dataclass(frozen=True, eq=False, repr=False)
class Spread(Told):
    """What tolerances of parameters do to a pose, to first order and by many robots made at random.

    Attributes:
        result: the analysis of the nominal robot.
        parameters: what may be off, by name.
        effects: what each does alone when it is off by its tolerance, to first order, by name.
        worst_case: by how much each quantity may be off at worst, to first order: Σ |∂f/∂p| t; of displacement and rotation the
            length of the longest sum Σ ± (∂d/∂p) t.
        standard_deviation: of each quantity, to first order: √Σ (∂f/∂p σ)²; of displacement and rotation the root mean square of
            their lengths, √(σx² + σy² + σz²).
        samples: each quantity of each robot made at random; the robots' axis is the first. NaN where a robot has no such pose.
        values: (robots,) the parameters of these robots, by name.
        distribution: "normal" or "uniform", of the parameters.
        seed: of the random numbers.
        at_once: whether the robots were computed together, by one record of the robot's functions; else one after the other.
        difference: by how many standard deviations of the displacement those of them that were also made one by one differ at
            most; NaN where none was.
        tool: (3,) the point of the platform that twist and stiffness are told of, from o in its axes [m]; None: o.
    """

    result: Result
    parameters: Mapping[str, Toleranced]
    effects: Mapping[str, SpreadQuantities]
    worst_case: SpreadQuantities
    standard_deviation: SpreadQuantities
    samples: SpreadQuantities
    values: Mapping[str, Array]
    distribution: str
    seed: int
    at_once: bool
    difference: float
    tool: Array | None = None

    @cached_property
    def nominal(self) -> SpreadQuantities:
        """The quantities of the nominal robot."""
        tip = seen(self.result, self.tool)
        return quantities(tip.twist, tip.stiffness, self.result.actuator_forces, np.zeros(6))

    def sampled(self, name: str) -> tuple[float, float, float, float]:
        """Return mean, standard deviation, and the limits between which 95 % of the robots made at random are.

        Of displacement and rotation, which are distances from the nominal robot, the second is their root mean square.

        Args:
            name: of a quantity, see :meth:`SpreadQuantities.named`.
        """
        values = self.samples.named(name)
        low, high = np.nanpercentile(values, [2.5, 97.5])
        scatter = np.sqrt(np.nanmean(values**2)) if name in LENGTHS else np.nanstd(values, ddof=1)
        return float(np.nanmean(values)), float(scatter), float(low), float(high)

    def share(self, parameter: str, name: str = "displacement") -> float:
        """Return which part of a quantity's variance is due to a parameter, to first order."""
        whole = float(self.standard_deviation.named(name))
        item = self.parameters[parameter]
        own = float(self.effects[parameter].named(name)) * item.standard_deviation / item.tolerance
        return (own / whole) ** 2 if whole > 0 else 0.0

    def __len__(self) -> int:
        return len(self.samples.displacement)


def quantities(twist: Array, stiffness: Array, actuator_forces: Mapping[str, Array], origin: Array) -> SpreadQuantities:
    """Return quantities, with the distances (…) of twists (…, 6) from the twist ``origin`` (6,)."""
    displacement, rotation = (np.linalg.norm((twist - origin)[..., part], axis=-1) for part in LENGTHS.values())
    return SpreadQuantities(twist, displacement, rotation, stiffness, actuator_forces)
