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

#: Parts of a twist, by the names of their magnitudes.
LENGTHS = {"displacement": slice(3), "rotation": slice(3, 6)}


@dataclass(frozen=True, eq=False, repr=False)
class PoseQuantities(ShortRepr):
    """Quantities of one pose that depend on tolerances, or changes of these quantities.

    Random samples are along the first axis. With a tool, the reference point is its tip instead of o.

    Attributes:
        twist: (…, 6) twist at o [m, rad].
        displacement: (…) distance of o from its position in the nominal robot [m]; of the nominal robot: its displacement.
        rotation: (…) angle to the platform's orientation in the nominal robot [rad]; of the nominal robot: its rotation.
        stiffness: (…, 6, 6) stiffness at o, actuators locked.
        actuator_forces: (…) force of each actuator [N or N·m].
    """

    twist: Array
    displacement: Array
    rotation: Array
    stiffness: Array
    actuator_forces: Mapping[str, Array]

    def named(self, name: str) -> Array:
        """Return "displacement", "rotation", a component "x" … "rz" of the twist, or the force of the actuator ``name``.

        Raises:
            ArgumentError: no quantity has this name.
        """
        if name in LENGTHS:
            return np.asarray(getattr(self, name))
        if name in COMPONENTS:
            return np.asarray(self.twist[..., COMPONENTS.index(name)])
        if name not in self.actuator_forces:
            names = [*LENGTHS, *COMPONENTS, *self.actuator_forces]
            raise ArgumentError(f"no quantity {name!r}: {near_names(name, names)}")
        return self.actuator_forces[name]


@dataclass(frozen=True, eq=False, repr=False)
class Effect(PoseQuantities):
    """Changes due to the deviation of one parameter by its tolerance, to first order.

    Attributes:
        force: largest joint force due to the self-stress of an assembly error [N]; 0 for other parameters.
        at: the joint with this force; "" if there is none.
        moment: largest joint moment due to self-stress, about the joint's centre [N·m].
    """

    force: float = 0.0
    at: str = ""
    moment: float = 0.0


@dataclass(frozen=True)
class Tolerance:
    """A parameter and its tolerance.

    Attributes:
        name: an argument of the file, a dimension of a part (``rod_1.outer_diameter``), or an assembly error
            (``revolute_1.error.rx``, ``rod_1.error.length``).
        value: nominal value, SI.
        unit: unit of the value; empty if unknown.
        tolerance: largest deviation (±) [unit].
        standard_deviation: standard deviation of the parameter [unit].
    """

    name: str
    value: float
    unit: str
    tolerance: float
    standard_deviation: float


@dataclass(frozen=True, eq=False, repr=False)
class Tolerances(Reported):
    """Pose errors and forces due to tolerances of parameters: first-order estimates and random samples.

    Attributes:
        result: the analysis of the nominal robot.
        parameters: parameters with their tolerances, by name.
        effects: effects of each parameter alone, by name, ranked by ``ranked_by``.
        ranked_by: "force", "displacement" or "rotation".
        worst_case: Σ |∂f/∂p| t of each quantity f, over the parameters p with tolerances t, to first order; for displacement and
            rotation d, the largest magnitude of Σ ± (∂d/∂p) t.
        standard_deviation: √Σ (∂f/∂p σ)² of each quantity f, with the parameters' standard deviations σ, to first order; for
            displacement and rotation, the root mean square of the magnitude, √(σx² + σy² + σz²).
        samples: quantities of the random samples; NaN for samples that cannot reach the pose.
        values: (samples,) parameters of the samples, by name.
        distribution: distribution of the parameters, "normal" or "uniform".
        seed: seed of the random numbers.
        at_once: whether the samples were computed as one batch, or one by one.
        difference: largest difference of displacement of samples that were analysed in the batch and one by one, relative to the
            standard deviation of the displacement; NaN if there are none.
        tool: (3,) reference point of twist and stiffness, from o in platform axes [m]; None: o.
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
        """Return mean, standard deviation, 2.5 % and 97.5 % quantile of the samples.

        Displacement and rotation are distances from the nominal robot; the root mean square replaces their standard deviation.

        Args:
            name: name of the quantity, see :meth:`PoseQuantities.named`.
        """
        values = self.samples.named(name)
        low, high = np.nanpercentile(values, [2.5, 97.5])
        scatter = np.sqrt(np.nanmean(values**2)) if name in LENGTHS else np.nanstd(values, ddof=1)
        return float(np.nanmean(values)), float(scatter), float(low), float(high)

    def share(self, parameter: str, name: str = "displacement") -> float:
        """Return the fraction of the variance of the quantity ``name`` that is due to a parameter, to first order."""
        whole = float(self.standard_deviation.named(name))
        tolerance = self.parameters[parameter]
        deviation = float(self.effects[parameter].named(name)) * tolerance.standard_deviation / tolerance.tolerance
        return (deviation / whole) ** 2 if whole > 0 else 0.0


def quantities(twist: Array, stiffness: Array, actuator_forces: Mapping[str, Array], origin: Array) -> PoseQuantities:
    """Return quantities; ``displacement`` and ``rotation`` are the magnitudes of both parts of ``twist`` − ``origin`` (6,)."""
    displacement, rotation = (np.linalg.norm((twist - origin)[..., part], axis=-1) for part in LENGTHS.values())
    return PoseQuantities(twist, displacement, rotation, stiffness, actuator_forces)
