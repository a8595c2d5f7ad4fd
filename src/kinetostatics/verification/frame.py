"""A frame of rigid pieces, beams and joints, as plain data: SI units, world axes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class FrameBeam:
    """An elastic beam between two pieces, inner end first.

    Attributes:
        name: of the beam.
        pieces: of its ends.
        points: (2, 3) its ends [m].
        axes: (3, 3) x (along), y, z as columns.
        stiffness: EA, κGA_y, κGA_z [N], GJ, EI_y, EI_z [N·m²].
        load: (3,) its weight [N/m].
        released: whether a passive telescope leaves the inner and the outer end free along x.
    """

    name: str
    pieces: tuple[int, int]
    points: Array
    axes: Array
    stiffness: tuple[float, ...]
    load: Array
    released: tuple[bool, bool]

    @property
    def length(self) -> float:
        """Distance of its ends [m]."""
        return float(np.linalg.norm(self.points[1] - self.points[0]))


@dataclass(frozen=True)
class FrameJoint:
    """A joint between two pieces, inner first.

    Attributes:
        name: of the joint.
        pieces: which it joins.
        point: (3,) its centre [m].
        axes: (3, 3) its x, y, z as columns.
        blocked: (6,) along and about which of them it holds the pieces together.
    """

    name: str
    pieces: tuple[int, int]
    point: Array
    axes: Array
    blocked: NDArray[np.bool_]


@dataclass(frozen=True)
class SpannedJoint:
    """A joint inside a telescopic beam.

    Its wrench is what the piece at end 0 of the beam puts on it, or what the beam puts on the piece at end 1; and what acts on
    the links between that end and the joint.

    Attributes:
        name: of the joint.
        point: (3,) its centre [m].
        beam, end: see above.
        force: (6,) for the weights between, about the centre [N, N·m].
        joints: names of the joints by which something is attached between, and the signs of their wrenches.
    """

    name: str
    point: Array
    beam: str
    end: int
    force: Array
    joints: tuple[tuple[str, float], ...]


@dataclass(frozen=True)
class Drive:
    """A driven joint: world ``axis`` (3,) of the coordinate of the outer side relative to the inner, and whether it turns."""

    name: str
    axis: Array
    rotates: bool


@dataclass(frozen=True)
class FrameModel:
    """The whole frame.

    Attributes:
        base, platform: numbers of their pieces.
        references: (n, 3) a point of every piece [m]; o of the platform.
        loads: (n, 6) force and moment on every piece about its reference point [N, N·m].
        beams, joints: what joins them.
        spanned: the joints inside telescopic beams.
        drives: the driven joints.
        size: diagonal of the box around all points [m].
        length: mean distance of the platform's joints from o [m], or the size; makes rotations comparable.
    """

    base: int
    platform: int
    references: Array
    loads: Array
    beams: tuple[FrameBeam, ...]
    joints: tuple[FrameJoint, ...]
    spanned: tuple[SpannedJoint, ...]
    drives: tuple[Drive, ...]
    size: float
    length: float

    @property
    def stiffest(self) -> float:
        """Largest axial stiffness of a beam [N/m], 1 if there are none."""
        return max((beam.stiffness[0] / beam.length for beam in self.beams), default=1.0)
