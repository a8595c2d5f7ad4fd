"""Measures: scalar performance indices of a pose, from twist, compliance or stiffness, for requirements, maps and figures.

``C`` is the compliance at o with locked actuators; its block ``C_dd`` relates displacements to forces [m/N], ``C_rr`` rotations
to moments [rad/(N·m)]; ``K = C⁻¹`` has the blocks ``K_dd``, ``K_rr``. Eigenvalues are those of one block, so that units are not
mixed; only ``conditioning`` and ``singularity_distance`` use the whole compliance, made homogeneous by the characteristic length
L: displacements d and L r, forces f and m/L. "Free" stiffnesses are those under a pure force (moment), with free rotation
(displacement) of the platform; they follow from ``C_dd`` (``C_rr``). "Held" stiffnesses are those of a pure displacement
(rotation); they follow from ``K_dd`` (``K_rr``) and do not exist where rigid limbs make ``K`` infinite. ``C_rr`` and ``K_dd`` do
not depend on the position of o; ``C_dd`` and ``K_rr`` do.

Indices in general: A. Rosyid, B. El-Khasawneh, A. Alazzam, Performance measures of parallel kinematics manipulators, Mechanical
Sciences 11 (2020). Conditioning: C. Gosselin, J. Angeles, A global performance index for the kinematic optimization of robotic
manipulators, Journal of Mechanical Design 113 (1991); for equally stiff limbs with one wrench each, our index is the square of
theirs, which uses the Jacobian. Distance of a matrix to the nearest singular one: C. Eckart, G. Young, The approximation of one
matrix by another of lower rank, Psychometrika 1 (1936).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from kinetostatics.math.arrays import Array
from kinetostatics.units import KINDS

_D, _R, _ALL = slice(3), slice(3, 6), slice(6)


@dataclass(frozen=True)
class Measure:
    """A scalar performance index of a pose.

    Attributes:
        definition: description and formula.
        words: label in figures; {who} stands for the point, {size} for the magnitude of a force or moment in any direction.
        kind: kind of the value, see :data:`kinetostatics.units.KINDS`; "number": dimensionless.
        of: the quantity from which it is computed: "twist", "compliance", ….
        part: the components of this quantity that are used.
        function: computes the index from this part (…, k) or (…, k, k), and from a force, a moment or the characteristic length.
        better: "small" or "large": which values are good.
        argument: "force" or "moment", if ``function`` takes one.
    """

    definition: str
    words: str
    kind: str
    of: str
    part: slice
    function: Callable[[Array, Array | float], Array]
    better: str = "small"
    argument: str | None = None

    @property
    def unit(self) -> str:
        """SI unit; "1" for ratios."""
        return KINDS.get(self.kind, "1")

    @property
    def is_homogeneous(self) -> bool:
        """Whether the index depends on the characteristic length."""
        return self.part == _ALL


def _length(vectors: Array, _: Array | float) -> Array:
    return np.asarray(np.sum(vectors**2, axis=-1) ** 0.5)


def _eigenvalues(matrices: Array) -> Array:
    """(…, n) eigenvalues of symmetric positive semidefinite matrices, ascending; NaN for matrices that are not finite."""
    finite = np.all(np.isfinite(matrices), axis=(-2, -1))
    values = np.linalg.eigvalsh(np.where(finite[..., None, None], matrices, 0.0))
    # rounding errors of zero
    values = np.where(values > 1e-14 * values[..., -1:], values, 0.0)
    return np.where(finite[..., None], values, np.nan)


def _eigenvalue(k: int) -> Callable[[Array, Array | float], Array]:
    return lambda matrices, size: np.asarray(size * _eigenvalues(matrices)[..., k])


def _inverse(k: int) -> Callable[[Array, Array | float], Array]:
    """Return the function 1 / (k-th eigenvalue), infinite for the eigenvalue 0 of a rigid direction."""

    def reciprocal(matrices: Array, _: Array | float) -> Array:
        with np.errstate(divide="ignore"):
            return np.asarray(1 / _eigenvalues(matrices)[..., k])

    return reciprocal


def _ratio(matrices: Array, _: Array | float) -> Array:
    values = _eigenvalues(matrices)
    with np.errstate(invalid="ignore"):
        return np.asarray(values[..., 0] / values[..., -1])


def _homogeneous(function: Callable[[Array, Array | float], Array]) -> Callable[[Array, Array | float], Array]:
    def homogeneous(matrices: Array, length: Array | float) -> Array:
        scale = np.where(np.arange(6) < 3, 1.0, np.asarray(length)[..., None])
        return function(matrices * scale[..., :, None] * scale[..., None, :], length)

    return homogeneous


def _stiffnesses() -> dict[str, Measure]:
    measures = {}
    for kind, unit, part, block, other in (
        ("translational", "stiffness", _D, "dd", "rotations"),
        ("rotational", "turning stiffness", _R, "rr", "translations"),
    ):
        for extreme, k in (("least", -1), ("greatest", 0)):
            name, least = f"{extreme}_{kind}_stiffness", extreme == "least"
            free = f"1 / {'largest' if least else 'smallest'} eigenvalue of C_{block}, {other} free"
            held = f"{'smallest' if least else 'largest'} eigenvalue of K_{block}, {other} held"
            words = f"{extreme} {kind} stiffness, {other}"
            measures[name] = Measure(free, f"{words} free", unit, "compliance", part, _inverse(k), "large")
            measures[f"{name}_held"] = Measure(held, f"{words} held", unit, "stiffness", part, _eigenvalue(-1 - k), "large")
    return measures


# fmt: off
MEASURES: Mapping[str, Measure] = {
    "linear_sag": Measure("|d|, displacement of o", "linear sag", "length", "twist", _D, _length),
    "angular_sag": Measure("|r|, rotation of the platform", "angular sag", "angle", "twist", _R, _length),
    **_stiffnesses(),
    "translational_conditioning": Measure("smallest / largest eigenvalue of C_dd, 0 to 1", "translational conditioning", "number",
        "compliance", _D, _ratio, "large"),
    "rotational_conditioning": Measure("smallest / largest eigenvalue of C_rr, 0 to 1", "rotational conditioning", "number",
        "compliance", _R, _ratio, "large"),
    "conditioning": Measure("smallest / largest eigenvalue of C made homogeneous by the characteristic length, 0 to 1",
        "conditioning", "number", "compliance", _ALL, _homogeneous(_ratio), "large"),
    "singularity_distance": Measure("1 / largest eigenvalue of C made homogeneous by the characteristic length",
        "distance to singularity", "stiffness", "compliance", _ALL, _homogeneous(_inverse(-1)), "large"),
    "largest_actuator_force": Measure("largest magnitude of the actuators' forces", "largest actuator force", "force",
        "actuator_forces", slice(None), lambda forces, _: np.max(np.abs(forces), axis=-1)),
    "largest_utilization": Measure("largest ratio of an actuator's force to its limit of effort", "utilization of the actuators",
        "number", "utilization", slice(None), lambda ratios, _: np.fmax.reduce(ratios, axis=-1)),
    "residual_linear_sag": Measure("|d| that remains at the corrected actuators", "residual linear sag", "length",
        "residual_error", _D, _length),
    "residual_angular_sag": Measure("|r| that remains at the corrected actuators", "residual angular sag", "angle",
        "residual_error", _R, _length),
    "first_frequency": Measure("lowest natural frequency that is not zero", "first natural frequency", "frequency",
        "frequencies", slice(None), lambda frequencies, _: frequencies[..., 0], "large"),
    "deflection_any_direction": Measure("largest displacement under a force: f times the largest eigenvalue of C_dd",
        "largest displacement of {who} under {size} N from any direction", "length", "compliance", _D, _eigenvalue(-1),
        argument="force"),
    "rotation_any_direction": Measure("largest rotation under a moment: m times the largest eigenvalue of C_rr",
        "largest rotation under {size} N·m about any axis", "angle", "compliance", _R, _eigenvalue(-1), argument="moment"),
}
# fmt: on
