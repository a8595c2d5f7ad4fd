"""Pose errors, stiffness and forces due to manufacturing tolerances; :func:`kinetostatics.tolerances` computes them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from kinetostatics.exceptions import ArgumentError, near_names
from kinetostatics.layout.mapping import ShortRepr
from kinetostatics.layout.report import Reported
from kinetostatics.math.arrays import Array
from kinetostatics.math.screws import COMPONENTS
from kinetostatics.results.result import Result

#: Lengths of parts of a twist, and where these are in it.
LENGTHS = {"displacement": slice(3), "rotation": slice(3, 6)}


@dataclass(frozen=True, eq=False, repr=False)
class PoseQuantities(ShortRepr):
    """Quantities of one pose that depend on tolerances, or their changes; of samples, whose axis is the first.

    With a tool, its tip takes the place of o.

    Attributes:
        twist: (…, 6) at o [m, rad].
        displacement: (…) distance of o from its place in the nominal robot [m]; of the nominal robot the length of its
            displacement.
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


@dataclass(frozen=True, eq=False, repr=False)
class Effect(PoseQuantities):
    """Changes by one parameter that is off by its tolerance, to first order.

    Attributes:
        force: the largest force that it locks into a joint [N], of errors of joints and beams; 0 of other parameters.
        at: the joint with that force; "" where there is none.
        moment: the largest moment that it locks into a joint, about the joint's centre [N·m].
    """

    force: float = 0.0
    at: str = ""
    moment: float = 0.0


@dataclass(frozen=True)
class Tolerance:
    """A parameter and its tolerance.

    Attributes:
        name: an argument of the robot's file, a number of a part, ``rod_1.outer_diameter``, or an assembly error,
            ``revolute_1.error.rx``, ``rod_1.error.length``.
        value: nominal, SI.
        unit: of it; empty where it is not known.
        tolerance: ± [unit].
        standard_deviation: of its distribution.
    """

    name: str
    value: float
    unit: str
    tolerance: float
    standard_deviation: float


@dataclass(frozen=True, eq=False, repr=False)
class Tolerances(Reported, builder="reports.tolerances:tolerances_report"):
    """Pose errors and forces by tolerances of parameters, to first order and of random samples.

    Attributes:
        result: the analysis of the nominal robot.
        parameters: with their tolerances, by name.
        effects: of each parameter alone, by name, the largest first, see ``ranked_by``.
        ranked_by: "force", "displacement" or "rotation".
        worst_case: Σ |∂f/∂p| t of each quantity, to first order; of displacement and rotation the length of the longest sum
            Σ ± (∂d/∂p) t.
        standard_deviation: √Σ (∂f/∂p σ)² of each quantity, to first order; of displacement and rotation the root mean square of
            their lengths, √(σx² + σy² + σz²).
        samples: the quantities of random robots, whose axis is the first; NaN where a robot has no such pose.
        values: (samples,) the parameters of these robots, by name.
        distribution: "normal" or "uniform", of the parameters.
        seed: of the random numbers.
        at_once: whether all samples were computed as one batch; else one robot after the other.
        difference: the largest difference between samples and the same robots analysed one by one, in standard deviations of the
            displacement; NaN where none was.
        tool: (3,) the point of the platform of twist and stiffness, from o in its axes [m]; None: o.
    """

    result: Result
    parameters: Mapping[str, Tolerance]
    effects: Mapping[str, Effect]
    ranked_by: str
    worst_case: PoseQuantities
    standard_deviation: PoseQuantities
    samples: PoseQuantities
    values: Mapping[str, Array]
    distribution: str
    seed: int
    at_once: bool
    difference: float
    tool: Array | None = None

    @cached_property
    def nominal(self) -> PoseQuantities:
        """The quantities of the nominal robot."""
        tip = self.result.seen_from(self.tool)
        return quantities(tip.twist, tip.stiffness, self.result.actuator_forces, np.zeros(6))

    def sampled(self, name: str) -> tuple[float, float, float, float]:
        """Return mean, standard deviation, and the limits of the middle 95 % of the samples.

        Of displacement and rotation, which are distances from the nominal robot, the second is their root mean square.

        Args:
            name: of a quantity, see :meth:`PoseQuantities.named`.
        """
        values = self.samples.named(name)
        low, high = np.nanpercentile(values, [2.5, 97.5])
        scatter = np.sqrt(np.nanmean(values**2)) if name in LENGTHS else np.nanstd(values, ddof=1)
        return float(np.nanmean(values)), float(scatter), float(low), float(high)

    def share(self, parameter: str, name: str = "displacement") -> float:
        """Return the part of a quantity's variance that is due to a parameter, to first order."""
        whole = float(self.standard_deviation.named(name))
        item = self.parameters[parameter]
        own = float(self.effects[parameter].named(name)) * item.standard_deviation / item.tolerance
        return (own / whole) ** 2 if whole > 0 else 0.0


def quantities(twist: Array, stiffness: Array, actuator_forces: Mapping[str, Array], origin: Array) -> PoseQuantities:
    """Return quantities, with the distances (…) of twists (…, 6) from the twist ``origin`` (6,)."""
    displacement, rotation = (np.linalg.norm((twist - origin)[..., part], axis=-1) for part in LENGTHS.values())
    return PoseQuantities(twist, displacement, rotation, stiffness, actuator_forces)
