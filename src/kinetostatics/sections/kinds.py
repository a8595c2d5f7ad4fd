"""Cross-sections of beams: areas, second moments, shear coefficients, and stresses under section wrenches.

The section's axes are y and z, x runs along the beam. ``I_y = ∫z² dA`` resists bending about y.

>>> rod = Tube.of(outer_diameter=0.06, inner_diameter=0.05)
>>> round(1e6 * rod.area)  # [mm²]
864
>>> [round(kappa, 3) for kappa in rod.shear_coefficients(poisson_ratio=0.3)]
[0.538, 0.538]
>>> round(float(rod.stress(np.array([1000.0, 0, 0, 0, 0, 0]))))  # 1000 N along the rod: N / A [Pa]
1157490
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from functools import lru_cache
from itertools import product

import numpy as np

from kinetostatics.exceptions import ArgumentError
from kinetostatics.math.arrays import Array
from kinetostatics.sections.stresses import (
    largest_at_points,
    largest_on_rings,
    may_be_largest,
    shear_functions,
    unit_stresses,
    von_mises_forms,
)

#: Smallest wall and hole of a rectangular tube, and smallest side of a rectangle, as a part of the larger side.
THINNEST = 1e-5


@dataclass(frozen=True)
class Section:
    """A section given only by its area and moments, ``<section>``.

    Attributes:
        area: A [m²].
        I_y, I_z: second moments of area about y and z [m⁴].
        J: torsion constant [m⁴].
        shear_area_y, shear_area_z: effective shear areas κA for forces along y and z [m²], or None if a shear coefficient is
            given.
    """

    area: float
    I_y: float
    I_z: float
    J: float
    shear_area_y: float | None = None
    shear_area_z: float | None = None

    @property
    def is_isotropic(self) -> bool:
        """Whether the bending stiffness is equal about all transverse axes, so that the y axis is arbitrary."""
        return math.isclose(self.I_y, self.I_z, rel_tol=1e-12)

    @property
    def extent(self) -> tuple[float, float]:
        """Half sizes of the outline along y and z [m]; for an unknown outline, of an ellipse with the same I_y/A and I_z/A."""
        return 2 * math.sqrt(self.I_z / self.area), 2 * math.sqrt(self.I_y / self.area)

    def shear_coefficients(self, poisson_ratio: float) -> tuple[float, float] | None:
        """Return Cowper's κ for forces along y and z, or None if the shape is unknown.

        Source: G. R. Cowper, The shear coefficient in Timoshenko's beam theory, J. Appl. Mech. 33 (1966).
        """
        return None

    def stress(self, wrench: Array, poisson_ratio: float = 0.3) -> Array:
        """Return the largest von Mises stress [Pa] under a section wrench.

        Axial force and bending are computed by Navier's formula, torsion and transverse forces by Saint-Venant's solutions
        (constant shear force, free warping), which depend on ν. The value is exact for single components; for combinations it is
        at most 1 % (circles and tubes) or 2 % (rectangles and rectangular tubes) below the largest stress. Sharp inner corners of
        rectangular tubes are excluded: the stress there is unbounded, and in reality limited by the fillet.

        Args:
            wrench: (6, …) section wrench in beam axes: N, V_y, V_z [N], T, M_y, M_z [N·m].
            poisson_ratio: ν.

        Returns:
            (…) stress. NaN for a section given only by its area and moments, because its outline is unknown.
        """
        return np.full(np.shape(wrench)[1:], np.nan)

    def largest_stress(self, wrenches: Array, poisson_ratio: float = 0.3) -> Array:
        """Return the largest stress (…) [Pa] at n sections of a beam with wrenches (6, n, …), by :meth:`stress`."""
        return self.stress(wrenches, poisson_ratio).max(axis=0)

    @property
    def places(self) -> tuple[float, ...]:
        """Fractions of the length at which the stations of a :class:`.Tapered` section are."""
        return ()

    def forms(self, poisson_ratio: float = 0.3) -> tuple[Array, int] | None:
        """Return the squared von Mises stresses at points, see :func:`.von_mises_forms`, and the number of rings of eight points.

        The forms (P, 21) are at P points. Around rings, the largest stress is searched. None: the outline is
        unknown, or varies along the beam.
        """
        return None

    def stress_along(self, wrenches: Array, fractions: Array, poisson_ratio: float = 0.3) -> Array:
        """Return :meth:`stress` (n, …) under wrenches (6, n, …) about the beam's line, at n fractions of its length."""
        return self.stress(wrenches, poisson_ratio)


def sizes_of(kind: type[Section]) -> tuple[str, ...]:
    """Return the names of the dimensions of a shape, such as its width: the fields that a general section lacks."""
    general = {field.name for field in fields(Section)}
    return tuple(field.name for field in fields(kind) if field.name not in general)


def _check(**sizes: float) -> None:
    for name, size in sizes.items():
        if not isinstance(size, (int, float, np.number)) or not 0 < size < math.inf:
            raise ArgumentError(f"{name}={size!r} of a section must be a finite number greater than zero; it is in metres")


@dataclass(frozen=True)
class Tube(Section):
    """A circular tube, or with ``inner_diameter = 0`` a solid circle."""

    outer_diameter: float = 0.0
    inner_diameter: float = 0.0

    @classmethod
    def of(cls, outer_diameter: float, inner_diameter: float = 0.0) -> Tube:
        """Make a tube from its diameters [m].

        Raises:
            ArgumentError: a diameter is invalid.
        """
        _check(outer_diameter=outer_diameter, **({"inner_diameter": inner_diameter} if inner_diameter != 0 else {}))
        if inner_diameter >= outer_diameter:
            raise ArgumentError(f"inner_diameter={inner_diameter:g} must be less than outer_diameter={outer_diameter:g}")
        area = math.pi / 4 * (outer_diameter**2 - inner_diameter**2)
        second = math.pi / 64 * (outer_diameter**4 - inner_diameter**4)
        return cls(area, second, second, 2 * second, outer_diameter=outer_diameter, inner_diameter=inner_diameter)

    @property
    def extent(self) -> tuple[float, float]:
        return self.outer_diameter / 2, self.outer_diameter / 2

    def shear_coefficients(self, poisson_ratio: float) -> tuple[float, float]:
        nu, m2 = poisson_ratio, (self.inner_diameter / self.outer_diameter) ** 2
        kappa = 6 * (1 + nu) * (1 + m2) ** 2 / ((7 + 6 * nu) * (1 + m2) ** 2 + (20 + 12 * nu) * m2)
        return kappa, kappa

    def stress(self, wrench: Array, poisson_ratio: float = 0.3) -> Array:
        return largest_on_rings(_tube_forms(self, float(poisson_ratio)), wrench)

    def forms(self, poisson_ratio: float = 0.3) -> tuple[Array, int]:
        forms = _tube_forms(self, float(poisson_ratio))
        return forms.reshape(-1, 21), len(forms)

    def largest_stress(self, wrenches: Array, poisson_ratio: float = 0.3) -> Array:
        # rotated axes in which the bending moment is about z
        size = np.hypot(wrenches[4], wrenches[5])
        along_z = np.reshape([1.0, 0.0], (2, *[1] * size.ndim))
        cos, sin = np.where(size > 0, np.array([wrenches[5], wrenches[4]]) / np.where(size > 0, size, 1), along_z)
        turned = np.array(wrenches, dtype=float)
        turned[1], turned[2] = cos * wrenches[1] - sin * wrenches[2], sin * wrenches[1] + cos * wrenches[2]
        turned[4], turned[5] = 0, size
        computed = may_be_largest(unit_stresses(_tube_forms(self, float(poisson_ratio))), turned)
        stresses = turned[0] * 0  # NaN remains NaN
        stresses[computed] += self.stress(turned[:, computed], poisson_ratio)
        return np.asarray(stresses.max(axis=0))


@lru_cache(maxsize=256)
def _tube_forms(tube: Tube, poisson_ratio: float) -> Array:
    """Return the squared von Mises stresses at points of a tube, as forms (5, 8, 21) of :func:`.von_mises_forms`.

    The points are at eight angles on five rings from the inner to the outer face. In polar coordinates r and θ, the flexure
    function of a force along z is (a r + b / r − r³ / 4) sin θ; the constants a and b make both faces free of stress.
    """
    outer, inner, nu = tube.outer_diameter / 2, tube.inner_diameter / 2, poisson_ratio
    r = np.linspace(inner, outer, 5)[:, None]
    angle = np.arange(8) * math.pi / 4
    cos, sin = np.cos(angle), np.sin(angle)
    a = (3 + 2 * nu) / 4 * (outer**2 + inner**2)
    hole = (3 + 2 * nu) / 4 * outer**2 * (inner / np.maximum(r, outer / 8)) ** 2
    radial = (a - hole - (3 + 2 * nu) / 4 * r**2) / (2 * (1 + nu) * tube.I_y)
    around = (a + hole - (1 - 2 * nu) / 4 * r**2) / (2 * (1 + nu) * tube.I_y)
    rows = np.zeros((5, 8, 3, 6))
    rows[:, :, 0, 0] = 1 / tube.area
    rows[:, :, 0, 4], rows[:, :, 0, 5] = r * sin / tube.I_y, -r * cos / tube.I_y
    rows[:, :, 1, 1], rows[:, :, 2, 1] = radial * cos, -around * sin
    rows[:, :, 1, 2], rows[:, :, 2, 2] = radial * sin, around * cos
    rows[:, :, 2, 3] = r / tube.J
    return von_mises_forms(rows)


def _rectangle_torsion(width: float, height: float) -> float:
    """Return J [m⁴] of a rectangle.

    Source: Timoshenko and Goodier, Theory of Elasticity, section 109 (series of the membrane analogy).
    """
    long, short = max(width, height), min(width, height)
    odd = np.arange(1, 60, 2)
    argument = odd * math.pi * long / (2 * short)
    return long * short**3 / 3 * (1 - 192 / math.pi**5 * short / long * float(np.sum(np.tanh(argument) / odd**5)))


@dataclass(frozen=True)
class Rectangle(Section):
    """A solid rectangle, ``width`` along y and ``height`` along z."""

    width: float = 0.0
    height: float = 0.0

    @classmethod
    def of(cls, width: float, height: float) -> Rectangle:
        """Make a rectangle from its sides [m].

        Raises:
            ArgumentError: a side is invalid.
        """
        _check(width=width, height=height)
        if min(width, height) < THINNEST * max(width, height):
            raise ArgumentError(f"the sides {width:g} and {height:g} are too different to be those of a beam; they are in metres")
        I_y, I_z = width * height**3 / 12, height * width**3 / 12
        return cls(width * height, I_y, I_z, _rectangle_torsion(width, height), width=width, height=height)

    @property
    def extent(self) -> tuple[float, float]:
        return self.width / 2, self.height / 2

    def shear_coefficients(self, poisson_ratio: float) -> tuple[float, float]:
        kappa = 10 * (1 + poisson_ratio) / (12 + 11 * poisson_ratio)
        return kappa, kappa

    def forms(self, poisson_ratio: float = 0.3) -> tuple[Array, int]:
        return _rectangle_forms(self, float(poisson_ratio)), 0

    def stress(self, wrench: Array, poisson_ratio: float = 0.3) -> Array:
        return largest_at_points(_rectangle_forms(self, float(poisson_ratio)), wrench)

    @property
    def _wall(self) -> float:
        return min(self.width, self.height) / 2


@lru_cache(maxsize=256)
def _rectangle_forms(section: Rectangle, poisson_ratio: float) -> Array:
    """Return the squared von Mises stresses at P points of a rectangle or tube, as forms (P, 21) of :func:`.von_mises_forms`."""
    size = max(section.width, section.height)
    shear = shear_functions(section.width / size, section.height / size, section._wall / size)
    y, z = shear.points()
    stresses = shear.stresses(y, z, poisson_ratio) / (size ** np.array([2, 2, 3]))[:, None]
    y, z = y * size, z * size
    rows = np.zeros((2, 2, len(y), 3, 6))
    for (k, sign_y), (m, sign_z) in product(enumerate((1, -1)), enumerate((1, -1))):
        quarter = rows[k, m]
        quarter[:, 0, 0] = 1 / section.area
        quarter[:, 0, 4], quarter[:, 0, 5] = sign_z * z / section.I_y, -sign_y * y / section.I_z
        # mirrored: τ_xy is even in y and z under V_y, odd in both under V_z, odd in z under T; τ_xz with y and z exchanged
        quarter[:, 1, 1:4] = (stresses[0] * np.array([[1], [sign_y * sign_z], [sign_z]])).T
        quarter[:, 2, 1:4] = (stresses[1] * np.array([[sign_y * sign_z], [1], [sign_y]])).T
    return von_mises_forms(rows.reshape(-1, 3, 6))


@dataclass(frozen=True)
class RectangularTube(Rectangle):
    """A rectangular tube of constant wall ``thickness`` and sharp corners.

    Torsion constant and Cowper's shear coefficients follow from Saint-Venant's theory by finite elements, to 0.1 % for every wall
    thickness. In the limits they agree with Bredt's and Cowper's formulas for thin walls, and with the solid rectangle.
    """

    thickness: float = 0.0

    @classmethod
    def of(cls, width: float, height: float, thickness: float = 0.0) -> RectangularTube:
        """Make a rectangular tube from its outer sides and wall thickness [m].

        Raises:
            ArgumentError: a size is invalid.
        """
        _check(width=width, height=height, thickness=thickness)
        size = max(width, height)
        if min(width, height) - 2 * thickness < THINNEST * size:
            raise ArgumentError(f"thickness={thickness:g} must be less than half the smaller side, {min(width, height):g}")
        if thickness < THINNEST * size:
            raise ArgumentError(
                f"thickness={thickness:g} is less than {THINNEST:g} of the larger side, {size:g}; all sizes are in metres"
            )
        shear = shear_functions(width / size, height / size, thickness / size)
        I_z, I_y = (moment * size**4 for moment in shear.second_moments)
        return cls(shear.area * size**2, I_y, I_z, shear.J * size**4, width=width, height=height, thickness=thickness)

    @property
    def _wall(self) -> float:
        return self.thickness

    def shear_coefficients(self, poisson_ratio: float) -> tuple[float, float]:
        """Return Cowper's κ for forces along y and z."""
        size = max(self.width, self.height)
        return shear_functions(self.width / size, self.height / size, self.thickness / size).shear_coefficients(poisson_ratio)


def beam_compliance_coefficients(
    section: Section, youngs_modulus: float, shear_modulus: float, shear_areas: tuple[float, float]
) -> Array:
    """Return the six section compliances c (the method page, section 5): 1/EA, 1/κGA_y, 1/κGA_z, 1/GJ, 1/EI_y, 1/EI_z.

    Args:
        section: the cross-section.
        youngs_modulus: E [Pa].
        shear_modulus: G [Pa].
        shear_areas: κA for forces along y and z [m²]; infinite for no shear deformation.

    Returns:
        (6,) array in the order of a wrench in beam axes, x along the beam.
    """
    E, G = youngs_modulus, shear_modulus
    sheared = [G * area for area in (*shear_areas, section.J)]
    return 1 / np.array([E * section.area, *sheared, E * section.I_y, E * section.I_z])
