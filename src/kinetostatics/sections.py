"""Cross-sections of beams: areas, moments, shear coefficients and the stress that a section wrench causes.

The section's axes are y and z, x runs along the beam. ``I_y = ∫z² dA`` resists bending about y.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetostatics.exceptions import ArgumentError

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Section:
    """A section given by its numbers alone, ``<section>``.

    Attributes:
        area: A [m²].
        I_y, I_z: second moments of area about y and z [m⁴].
        J: torsion constant [m⁴].
        shear_area_y, shear_area_z: effective shear areas κA for forces along y and z [m²], or None when the
            file gives a shear coefficient.
    """

    area: float
    I_y: float
    I_z: float
    J: float
    shear_area_y: float | None = None
    shear_area_z: float | None = None

    @property
    def is_isotropic(self) -> bool:
        """Whether the section bends alike about every transverse axis, so that its y axis need not be given."""
        return math.isclose(self.I_y, self.I_z, rel_tol=1e-12)

    @property
    def extent(self) -> tuple[float, float]:
        """Half sizes along y and z [m], of the outline or of the equivalent ellipse; for pictures."""
        return 2 * math.sqrt(self.I_z / self.area), 2 * math.sqrt(self.I_y / self.area)

    def shear_coefficients(self, poisson_ratio: float) -> tuple[float, float] | None:
        """Return Cowper's κ for forces along y and z, or None when the shape is not known.

        Source: G. R. Cowper, The shear coefficient in Timoshenko's beam theory, J. Appl. Mech. 33 (1966).
        """
        return None

    def stress(self, wrench: Array) -> Array:
        """Return the largest von Mises stress [Pa] that a section wrench causes.

        Args:
            wrench: (6, …) section wrench in beam axes: N, V_y, V_z [N], T, M_y, M_z [N·m].

        Returns:
            (…) stress of axial force, bending and torsion at the outer fibre, where the stress of the transverse
            shear force vanishes. NaN for a section given by numbers alone, whose outer fibre is not known.
        """
        return np.full(np.shape(wrench)[1:], np.nan)


def _check(**sizes: float) -> None:
    """Raise an error unless all sizes are finite numbers greater than zero."""
    for name, size in sizes.items():
        if not isinstance(size, (int, float, np.number)) or not 0 < size < math.inf:
            raise ArgumentError(f"{name}={size!r} of a section must be a finite number greater than zero; it is in metres")


def _von_mises(normal: Array, shear: Array) -> Array:
    return np.asarray(np.sqrt(normal**2 + 3 * shear**2))


@dataclass(frozen=True)
class Tube(Section):
    """A circular tube, or with ``inner_diameter = 0`` a solid circle."""

    outer_diameter: float = 0.0
    inner_diameter: float = 0.0

    @classmethod
    def of(cls, outer_diameter: float, inner_diameter: float = 0.0) -> Tube:
        """Make a tube from its diameters [m].

        Raises:
            ArgumentError: a diameter is impossible.
        """
        _check(outer_diameter=outer_diameter, **({"inner_diameter": inner_diameter} if inner_diameter != 0 else {}))
        if inner_diameter >= outer_diameter:
            raise ArgumentError(f"inner_diameter={inner_diameter:g} must be less than outer_diameter={outer_diameter:g}")
        area = math.pi / 4 * (outer_diameter**2 - inner_diameter**2)
        second = math.pi / 64 * (outer_diameter**4 - inner_diameter**4)
        return cls(area, second, second, 2 * second, outer_diameter=outer_diameter, inner_diameter=inner_diameter)

    @property
    def extent(self) -> tuple[float, float]:  # noqa: D102
        return self.outer_diameter / 2, self.outer_diameter / 2

    def shear_coefficients(self, poisson_ratio: float) -> tuple[float, float]:  # noqa: D102
        nu, m2 = poisson_ratio, (self.inner_diameter / self.outer_diameter) ** 2
        kappa = 6 * (1 + nu) * (1 + m2) ** 2 / ((7 + 6 * nu) * (1 + m2) ** 2 + (20 + 12 * nu) * m2)
        return kappa, kappa

    def stress(self, wrench: Array) -> Array:  # noqa: D102
        radius = self.outer_diameter / 2
        normal = np.abs(wrench[0]) / self.area + np.hypot(wrench[4], wrench[5]) * radius / self.I_y
        return _von_mises(normal, np.abs(wrench[3]) * radius / self.J)


def _rectangle_torsion(width: float, height: float) -> tuple[float, float]:
    """Return J [m⁴] and the torsion modulus W_t [m³] (largest shear stress = T / W_t) of a rectangle.

    Source: Timoshenko and Goodier, Theory of Elasticity, section 109 (series of the membrane analogy).
    """
    long, short = max(width, height), min(width, height)
    odd = np.arange(1, 60, 2)
    argument = odd * math.pi * long / (2 * short)
    J = long * short**3 / 3 * (1 - 192 / math.pi**5 * short / long * float(np.sum(np.tanh(argument) / odd**5)))
    sech = 1 / np.cosh(np.minimum(argument, 700.0))
    largest = 1 - 8 / math.pi**2 * float(np.sum(sech / odd**2))
    return J, J / (short * largest)


@dataclass(frozen=True)
class Rectangle(Section):
    """A solid rectangle, ``width`` along y and ``height`` along z."""

    width: float = 0.0
    height: float = 0.0
    torsion_modulus: float = 0.0

    @classmethod
    def of(cls, width: float, height: float) -> Rectangle:
        """Make a rectangle from its sides [m].

        Raises:
            ArgumentError: a side is impossible.
        """
        _check(width=width, height=height)
        J, modulus = _rectangle_torsion(width, height)
        return cls(
            width * height,
            width * height**3 / 12,
            height * width**3 / 12,
            J,
            width=width,
            height=height,
            torsion_modulus=modulus,
        )

    @property
    def extent(self) -> tuple[float, float]:  # noqa: D102
        return self.width / 2, self.height / 2

    def shear_coefficients(self, poisson_ratio: float) -> tuple[float, float]:  # noqa: D102
        kappa = 10 * (1 + poisson_ratio) / (12 + 11 * poisson_ratio)
        return kappa, kappa

    def stress(self, wrench: Array) -> Array:
        """As in :meth:`Section.stress`; the corner's normal and the long side's shear stress are taken together.

        This is at most a little above the truth, since the two are largest at different points.
        """
        y, z = self.extent
        normal = np.abs(wrench[0]) / self.area + np.abs(wrench[4]) * z / self.I_y + np.abs(wrench[5]) * y / self.I_z
        return _von_mises(normal, np.abs(wrench[3]) / self.torsion_modulus)


@dataclass(frozen=True)
class RectangularTube(Rectangle):
    """A rectangular tube of constant wall ``thickness``; torsion by Bredt's formula for closed thin walls."""

    thickness: float = 0.0

    @classmethod
    def of(cls, width: float, height: float, thickness: float = 0.0) -> RectangularTube:
        """Make a rectangular tube from its outer sides and wall thickness [m].

        Raises:
            ArgumentError: a size is impossible.
        """
        _check(width=width, height=height, thickness=thickness)
        if 2 * thickness >= min(width, height):
            raise ArgumentError(f"thickness={thickness:g} must be less than half the smaller side, {min(width, height):g}")
        b, h, t = width, height, thickness
        inner_b, inner_h, enclosed = b - 2 * t, h - 2 * t, (b - t) * (h - t)
        return cls(
            b * h - inner_b * inner_h,
            (b * h**3 - inner_b * inner_h**3) / 12,
            (h * b**3 - inner_h * inner_b**3) / 12,
            2 * t * enclosed**2 / (b + h - 2 * t),
            width=b,
            height=h,
            torsion_modulus=2 * t * enclosed,
            thickness=t,
        )

    def shear_coefficients(self, poisson_ratio: float) -> tuple[float, float]:
        """Return Cowper's κ of a thin-walled box for forces along y and z."""

        def box(flange: float, web: float) -> float:
            nu, m, n = poisson_ratio, flange / web, flange / web
            return (
                10
                * (1 + nu)
                * (1 + 3 * m) ** 2
                / (
                    12
                    + 72 * m
                    + 150 * m**2
                    + 90 * m**3
                    + nu * (11 + 66 * m + 135 * m**2 + 90 * m**3)
                    + 10 * n**2 * ((3 + nu) * m + 3 * m**2)
                )
            )

        b, h = self.width - self.thickness, self.height - self.thickness
        return box(h, b), box(b, h)


def beam_compliance_coefficients(
    section: Section, youngs_modulus: float, shear_modulus: float, shear_areas: tuple[float, float]
) -> Any:
    """Return the six section compliances c (``docs/method.md``, section 5): 1/EA, 1/κGA_y, 1/κGA_z, 1/GJ, 1/EI_y, 1/EI_z.

    Args:
        section: the cross-section.
        youngs_modulus: E [Pa].
        shear_modulus: G [Pa].
        shear_areas: κA for forces along y and z [m²]; infinite for no shear deformation.

    Returns:
        (6,) array in the order of a wrench in beam axes, x along the beam.
    """
    E, G = youngs_modulus, shear_modulus
    return np.array(
        [
            1 / (E * section.area),
            1 / (G * shear_areas[0]),
            1 / (G * shear_areas[1]),
            1 / (G * section.J),
            1 / (E * section.I_y),
            1 / (E * section.I_z),
        ]
    )
