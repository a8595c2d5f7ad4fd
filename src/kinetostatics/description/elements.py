"""Elements of a description as frozen dataclasses: links, joints, loops, beams, materials, springs.

The fields correspond to attributes of robot files, in SI units and radians. Each part checks its values when it is made; what
concerns several parts is checked when the description is validated or a robot is created. The position in the file (``place``) is
ignored in comparisons.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from kinetostatics.description.fields import (
    IN_PYTHON,
    POSITIVE,
    Angles,
    CheckedPart,
    Direction,
    Moments,
    Name,
    NotNegative,
    Number,
    Place,
    Point,
    Positive,
    PositiveOrInf,
    Stiffnesses,
    Text,
)
from kinetostatics.description.stiffness_matrix import StiffnessMatrix
from kinetostatics.exceptions import ArgumentError
from kinetostatics.layout.mapping import ShortRepr
from kinetostatics.sections.kinds import Section
from kinetostatics.sections.tapered import Tapered


@dataclass(frozen=True, repr=False)
class Origin(ShortRepr):
    """A frame relative to another: ``xyz`` [m] and fixed-axes roll, pitch, yaw ``rpy`` [rad], as in URDF."""

    xyz: Point = (0.0, 0.0, 0.0)
    rpy: Angles = (0.0, 0.0, 0.0)

    @cached_property
    def matrix(self) -> NDArray[np.float64]:
        """The frame as a read-only (4, 4) homogeneous matrix."""
        (cr, cp, cy), (sr, sp, sy) = np.cos(self.rpy), np.sin(self.rpy)
        result = np.eye(4)
        result[:3, :3] = [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
        result[:3, 3] = self.xyz
        result.setflags(write=False)
        return result

    @classmethod
    def of(cls, matrix: NDArray[np.floating[Any]]) -> Origin:
        """Return the frame of a homogeneous matrix (4, 4), exact to rounding at all orientations, pitch of 90° included."""
        yaw = math.atan2(matrix[1, 0], matrix[0, 0])
        cosine, sine = math.cos(yaw), math.sin(yaw)
        x, y = cosine * matrix[0, :3] + sine * matrix[1, :3], cosine * matrix[1, :3] - sine * matrix[0, :3]
        roll, pitch = math.atan2(-y[2], y[1]), math.atan2(-matrix[2, 0], x[0])
        return cls(tuple(matrix[:3, 3].tolist()), (roll, pitch, yaw))


#: The frame of a link itself.
AT_LINK = Origin()

#: Largest violations of the conditions on principal moments of inertia that rounding explains: relative to the largest, for four
#: digits, and absolute [kg·m²], for tensors whose entries have six decimals.
ROUNDED_INERTIA = 1e-3, 4.5e-6


@dataclass(frozen=True, repr=False)
class Inertia(ShortRepr):
    """Moments of inertia about a link's centre of mass, for vibrations and Pinocchio's model; statics does not use them.

    ``moments`` are ixx, ixy, ixz, iyy, iyz, izz [kg·m²] in axes rotated by ``rpy`` [rad] relative to the link's.
    """

    moments: Moments = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    rpy: Angles = (0.0, 0.0, 0.0)

    @property
    def matrix(self) -> NDArray[np.float64]:
        """The (3, 3) inertia [kg·m²] about the centre of mass, along the link's axes."""
        xx, xy, xz, yy, yz, zz = self.moments
        R = Origin(rpy=self.rpy).matrix[:3, :3]
        return np.asarray(R @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ R.T)

    @property
    def flaw(self) -> str:
        """Why no body has these moments, beyond :data:`ROUNDED_INERTIA`; empty if a body, rod or point mass has them."""
        least, middle, largest = np.linalg.eigvalsh(self.matrix)
        relative, absolute = ROUNDED_INERTIA
        if least + middle - largest >= -(relative * abs(largest) + absolute):
            return ""
        listed = f"{least:.4g}, {middle:.4g} and {largest:.4g} kg·m²"
        why = "none may be negative" if least < 0 else "none may exceed the sum of the others"
        return f"no body has the principal moments of inertia {listed}: {why}"


@dataclass(frozen=True, repr=False)
class Link(CheckedPart):
    """A URDF link.

    Attributes:
        name: name of the link.
        mass: mass [kg]; zero without ``<inertial>``.
        center_of_mass: position (3,) of the centre of mass [m] in the link's frame; the origin without ``<inertial>``.
        inertia: moments of inertia about the centre of mass.
        has_inertial: whether the link has an ``<inertial>``, as all links with a mass do.
        extra: XML of visuals, collisions and other child elements, which is preserved.
        place: file and line of the link.
    """

    KIND: ClassVar = "link"

    name: Name
    mass: NotNegative = 0.0
    center_of_mass: Point = (0.0, 0.0, 0.0)
    inertia: Inertia = Inertia()
    has_inertial: bool = False
    extra: str = field(default="", repr=False)
    place: Place = field(default=IN_PYTHON, compare=False, kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.mass != 0 or any((*self.center_of_mass, *self.inertia.moments, *self.inertia.rpy)):
            object.__setattr__(self, "has_inertial", True)


@dataclass(frozen=True, repr=False)
class JointStiffness(CheckedPart):
    """An elastic joint, bearing or actuator, ``<joint_stiffness>``.

    Attributes:
        joint: name of the joint or loop.
        linear: stiffness [N/m] along the axes of the joint's frame on the parent or predecessor. Along constrained directions,
            infinity means rigid. Along a passive freedom, a finite value is a spring that is relaxed at the analysed pose; zero
            and infinity mean no spring. None: rigid, without springs.
        angular: rotational stiffness [N·m/rad] about these axes; infinity, zero and None mean the same as for ``linear``.
        drive: stiffness [N/m, N·m/rad] of an actuated joint's actuator along the joint's coordinate; None or infinity: rigid.
        matrix: instead of ``linear`` and ``angular``, a symmetric (6, 6) matrix about the origin of this frame, order Fx Fy Fz Mx
            My Mz, whose diagonal has the same meaning; kept as the 21 numbers of its upper triangle, row by row.
        file: the file from which the matrix is; empty for a matrix given directly.
        place: file and line of the element.
    """

    joint: Text
    linear: Stiffnesses | None = None
    angular: Stiffnesses | None = None
    drive: PositiveOrInf | None = None
    matrix: StiffnessMatrix | None = None
    file: str = field(default="", compare=False, kw_only=True)
    place: Place = field(default=IN_PYTHON, compare=False, kw_only=True)

    @property
    def label(self) -> str:
        return f"{'stiffness' if self.place.line is None else '<joint_stiffness>'} of joint {self.joint!r}"


@dataclass(frozen=True, repr=False)
class Spring(CheckedPart):
    """A spring between points of two links, ``<spring>``: its tension is ``preload + stiffness (length − free_length)``.

    Attributes:
        name: name of the spring.
        stiffness: stiffness [N/m]; zero for a constant force.
        predecessor, successor: names of the links.
        predecessor_point, successor_point: ends of the spring in the links' frames [m]; on a link with beams, an end of a beam.
        free_length: length at which the tension is ``preload`` [m]; a balancing spring has zero free length and preload.
        preload: tension at the free length [N], negative in compression.
        place: file and line of the spring.
    """

    KIND: ClassVar = "spring"

    name: Name
    stiffness: NotNegative
    predecessor: Text
    successor: Text
    predecessor_point: Point = (0.0, 0.0, 0.0)
    successor_point: Point = (0.0, 0.0, 0.0)
    free_length: NotNegative = 0.0
    preload: Number = 0.0
    place: Place = field(default=IN_PYTHON, compare=False, kw_only=True)


@dataclass(frozen=True, repr=False)
class Material(ShortRepr):
    """The material of a beam; either ``poisson_ratio`` or ``shear_modulus`` is given.

    Attributes:
        youngs_modulus: E [Pa].
        poisson_ratio: ν.
        shear_modulus: G [Pa].
        density: ρ [kg/m³]; None: the mass of the beam's link is distributed along the beam.
        thermal_expansion: α [1/K].
        yield_strength: von Mises stress at which the material yields [Pa]; None: unknown.
    """

    youngs_modulus: Positive
    poisson_ratio: Number | None = None
    shear_modulus: Positive | None = None
    density: NotNegative | None = None
    thermal_expansion: Number = 0.0
    yield_strength: Positive | None = None


@dataclass(frozen=True, repr=False)
class BeamEnd(ShortRepr):
    """One end of a beam: the centre of a joint or loop.

    ``side`` is ``"parent"`` or ``"child"`` (for a loop: predecessor or successor) if given in the file; None: the side nearest to
    the beam's link. The side has no effect if the joint is attached to the beam's link and cannot slide.
    """

    joint: Text
    side: Text | None = None


@dataclass(frozen=True, repr=False)
class Beam(CheckedPart):
    """An elastic beam, ``<beam>``.

    Attributes:
        link: name of the beam's link.
        section: the cross-section, from :mod:`kinetostatics.sections`.
        material: the material.
        start, end: the beam's ends towards the base and the platform; None: at the joints of the link.
        shear_coefficient: κ of the shear stiffness κGA, or infinity for no shear deformation; None: from the shape of the section
            or its shear areas.
        y_axis: direction of the section's y axis in the link's frame; None for an isotropic section.
        name: name of the beam; default: the link's name.
        place: file and line of the beam.
    """

    KIND: ClassVar = "beam"

    #: Fields that compiled code does not depend on: BeamModel has the values.
    NOT_RECORDED: ClassVar = ("section", "material", "start", "end", "shear_coefficient", "y_axis", "name")

    link: Text
    section: Section
    material: Material
    start: BeamEnd | None = None
    end: BeamEnd | None = None
    shear_coefficient: PositiveOrInf | None = None
    y_axis: Direction | None = None
    name: Name = ""
    place: Place = field(default=IN_PYTHON, compare=False, kw_only=True)

    def __post_init__(self) -> None:
        if not self.name:
            object.__setattr__(self, "name", self.link)
        super().__post_init__()

    def check_direction(self, along: NDArray[np.float64]) -> None:
        """Raise an error if the vector (3,) between the ends, in the link's frame, is along ``y_axis``."""
        if self.y_axis is not None:
            y_axis, sizes = np.array(self.y_axis), np.linalg.norm(along) * np.linalg.norm(self.y_axis)
            if float(np.linalg.norm(np.cross(y_axis, along))) < 1e-6 * float(sizes):
                reason = "its y_axis is parallel to the beam; specify a direction perpendicular to it"
                raise self.place.error(f"<beam {self.name!r}>: {reason}")

    @property
    def errors(self) -> Mapping[str, str]:
        """SI units of the beam's assembly errors, by kind."""
        return {"length": "m", "temperature": "K"} if self.thermal_expansion else {"length": "m"}

    @property
    def youngs_modulus(self) -> float:
        """E [Pa]."""
        return self.material.youngs_modulus

    @property
    def shear_modulus(self) -> float:
        """G [Pa], given or E / 2(1 + ν)."""
        material = self.material
        if material.shear_modulus is not None:
            return material.shear_modulus
        if material.poisson_ratio is None:
            raise ArgumentError(f"the beam {self.name!r} has neither a shear modulus nor a Poisson ratio")
        return material.youngs_modulus / (2 * (1 + material.poisson_ratio))

    @property
    def poisson_ratio(self) -> float:
        """ν as given, else E / 2G − 1 of an isotropic material, or 0 if this is outside (−1, 0.5]."""
        material = self.material
        if material.poisson_ratio is not None:
            return material.poisson_ratio
        ratio = material.youngs_modulus / (2 * self.shear_modulus) - 1
        return ratio if -1 < ratio <= 0.5 else 0.0

    @property
    def density(self) -> float | None:
        """ρ [kg/m³], or None if the link's mass is distributed along the beam."""
        return self.material.density

    @property
    def thermal_expansion(self) -> float:
        """α [1/K]."""
        return self.material.thermal_expansion

    @property
    def shear_areas(self) -> tuple[float, float]:
        """Shear areas κA [m²] for shear forces along the section's y and z; infinite for no shear deformation.

        Raises:
            ArgumentError: κ is unknown.
        """
        return self.shear_areas_of(self.section)

    def shear_areas_of(self, section: Section) -> tuple[float, float]:
        """Return :attr:`shear_areas` with another section."""
        ratio = self.material.poisson_ratio
        if section.shear_area_y is not None and section.shear_area_z is not None:
            return section.shear_area_y, section.shear_area_z
        if self.shear_coefficient is not None:
            return self.shear_coefficient * section.area, self.shear_coefficient * section.area
        factors = None if ratio is None else section.shear_coefficients(ratio)
        if factors is None:
            why = "its shear_modulus leaves Poisson's ratio open" if ratio is None else "its shape is not known"
            areas = " (or <section> its shear_area_y and shear_area_z)" if type(section) is Section else ""
            raise ArgumentError(f"it needs a shear_coefficient{areas}, because {why}; 'inf' means no shear")
        return factors[0] * section.area, factors[1] * section.area


def check_section(section: Section) -> None:
    """Check the numbers of a cross-section.

    Raises:
        ArgumentError: a number is not positive, only one shear area is given, or the numbers do not agree with the sizes.
    """
    sizes = {entry.name: getattr(section, entry.name) for entry in fields(section)}
    shear = sizes["shear_area_y"], sizes["shear_area_z"]
    for station in section.stations if isinstance(section, Tapered) else ():
        check_section(station.section)
    for name, size in sizes.items():
        if name == "stations" or (size is None and name.startswith("shear_area")) or (name == "inner_diameter" and size == 0):
            continue
        try:
            POSITIVE.check(size)
        except ArgumentError as error:
            raise ArgumentError(f"{name}={size!r} {error}") from None
    if (shear[0] is None) != (shear[1] is None):
        given = "shear_area_z" if shear[0] is None else "shear_area_y"
        raise ArgumentError(f"it has {given} alone; give both shear_area_y and shear_area_z, or neither")
    kind = type(section)
    if kind is not Section and kind.of(*list(sizes.values())[len(fields(Section)) :]) != section:  # type: ignore[attr-defined]
        raise ArgumentError(f"the numbers do not agree with its sizes; make it with {kind.__name__}.of(…)")
