"""What a robot file says, as plain frozen dataclasses; no numbers are computed here and no pose is known.

Field by field this is the format of ``docs/robot_format.md``. SI units, radians.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from kinetostatics.sections import Section

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Place:
    """Where something is written: ``file`` and ``line`` (None when unknown)."""

    file: str = "<python>"
    line: int | None = None


@dataclass(frozen=True)
class Origin:
    """A frame relative to another: ``xyz`` [m] and fixed-axes roll, pitch, yaw ``rpy`` [rad], as in URDF."""

    xyz: Vector = (0.0, 0.0, 0.0)
    rpy: Vector = (0.0, 0.0, 0.0)

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


@dataclass(frozen=True)
class Link:
    """A URDF link; ``mass`` [kg] at ``center_of_mass`` [m, link frame]; zero and the origin without ``<inertial>``."""

    name: str
    mass: float = 0.0
    center_of_mass: Vector = (0.0, 0.0, 0.0)
    has_inertial: bool = False
    place: Place = Place()


@dataclass(frozen=True)
class Mimic:
    """``<mimic>``: the joint's coordinate is ``multiplier`` times that of ``joint``, plus ``offset`` [m, rad]."""

    joint: str
    multiplier: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True)
class Joint:
    """A URDF joint of the spanning tree.

    ``axis`` is a unit vector in the joint's frame. ``lower``, ``upper`` [rad or m] are infinite where the file
    gives no limits.
    """

    name: str
    type: str
    parent: str
    child: str
    origin: Origin = Origin()
    axis: Vector = (1.0, 0.0, 0.0)
    lower: float = -math.inf
    upper: float = math.inf
    place: Place = Place()
    mimic: Mimic | None = None


@dataclass(frozen=True)
class Cone:
    """The largest ``angle`` [rad] between two axes, each in the origin frame of its own side of the loop."""

    angle: float
    predecessor_axis: Vector = (0.0, 0.0, 1.0)
    successor_axis: Vector = (0.0, 0.0, 1.0)


@dataclass(frozen=True)
class Loop:
    """A joint that closes a loop, ``<loop>``; ``axis`` and ``axis2`` are unit vectors.

    ``axis`` lies in the predecessor's origin frame, ``axis2`` (universal only) in the successor's.
    """

    name: str
    type: str
    predecessor: str
    predecessor_origin: Origin
    successor: str
    successor_origin: Origin
    axis: Vector = (1.0, 0.0, 0.0)
    axis2: Vector = (0.0, 1.0, 0.0)
    lower: float = -math.inf
    upper: float = math.inf
    cone: Cone | None = None
    place: Place = Place()


@dataclass(frozen=True)
class JointStiffness:
    """An elastic joint, bearing or drive, ``<joint_stiffness>``.

    Attributes:
        joint: the joint or loop.
        linear: stiffness [N/m] along the axes of the joint's frame on the predecessor's side. Along what the joint blocks an
            infinite value means rigid. Along a passive freedom a finite value is a spring that is relaxed at the analysed pose,
            zero and infinity mean that there is none. None: rigid, and no spring.
        angular: the same for rotations [N·m/rad] about these axes.
        drive: stiffness [N/m, N·m/rad] of a driven joint's drive along its own coordinate; None or infinity: rigid.
        place: where it is written.
    """

    joint: str
    linear: Vector | None = None
    angular: Vector | None = None
    drive: float | None = None
    place: Place = Place()


@dataclass(frozen=True)
class BeamEnd:
    """One end of a beam: the centre of a joint or loop.

    ``side`` is ``"parent"`` or ``"child"`` (of a loop: predecessor or successor) where the file says so, else None:
    the side on which the beam's link lies. It only matters for joints that slide.
    """

    joint: str
    side: str | None = None


@dataclass(frozen=True)
class Beam:
    """An elastic beam, ``<beam>``.

    Attributes:
        name: its name; the link's unless the file says otherwise.
        link: the link that carries it.
        start, end: its ends, towards the base and towards the platform; None where the file leaves the default.
        youngs_modulus, shear_modulus: E, G [Pa].
        shear_areas: κA for shear forces along the section's y and z [m²]; infinite for no shear deformation.
        density: ρ [kg/m³], or None when the link's own mass is spread along the beam.
        thermal_expansion: α [1/K].
        section: the cross-section.
        y_axis: direction of the section's y in the link's frame, or None for an isotropic section.
        place: where it is written.
    """

    name: str
    link: str
    start: BeamEnd | None
    end: BeamEnd | None
    youngs_modulus: float
    shear_modulus: float
    shear_areas: tuple[float, float]
    density: float | None
    thermal_expansion: float
    section: Section
    y_axis: Vector | None
    place: Place


@dataclass(frozen=True)
class RobotDescription:
    """A whole robot file.

    Attributes:
        name: of the robot.
        path: of the file it was read from, as given.
        urdf: the plain tree URDF, xacro expanded, with the additional elements left in (other tools skip them).
        links, joints, loops, beams: by name, in the order of the expanded file.
        base: name of the base link.
        platform: name of the platform link, and ``platform_origin`` the frame o-xyz in it.
        joint_stiffness: what is elastic in joints, by the joint's name.
        driven: names of the driven joints and loops, in the order of the file's transmissions.
        warnings: what is suspicious but not wrong, in full sentences.
    """

    name: str
    path: str
    urdf: str
    links: dict[str, Link]
    joints: dict[str, Joint]
    loops: dict[str, Loop]
    beams: dict[str, Beam]
    base: str
    platform: str
    platform_origin: Origin
    platform_place: Place
    driven: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    joint_stiffness: dict[str, JointStiffness] = field(default_factory=dict)
