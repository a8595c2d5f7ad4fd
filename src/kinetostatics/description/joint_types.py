"""Table of joint types: their freedoms, and whether they may be joints or loops.

All other properties follow from the freedoms. A new type of loop needs only a row of the table; a new type of tree joint must
also be a type that Pinocchio's parser reads.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from functools import cached_property

import numpy as np

from kinetostatics.math.arrays import Array
from kinetostatics.math.linalg import across


class Axes(Enum):
    """Directions of the translations of a joint, or axes of its rotations."""

    NONE = "none"
    AXIS = "its axis"
    ACROSS = "two directions across its axis"
    BOTH = "its axis, fixed in the predecessor, and axis2, fixed in the successor"
    ALL = "all three"

    @property
    def count(self) -> int:
        return _COUNTS[self]


_COUNTS = {Axes.NONE: 0, Axes.AXIS: 1, Axes.ACROSS: 2, Axes.BOTH: 2, Axes.ALL: 3}


@dataclass(frozen=True)
class JointType:
    """Properties of a joint type.

    Attributes:
        name: name in robot files.
        symbol: letter in the names of limbs, such as ``RRPS``.
        slides: directions of translations: ``NONE``, ``AXIS``, ``ACROSS`` or ``ALL``.
        turns: axes of rotations: ``NONE``, ``AXIS``, ``BOTH`` (without translations) or ``ALL``.
        in_tree: whether it may be a ``<joint>`` of the spanning tree.
        in_loop: whether it may be a ``<loop>``.
        endless: whether the angle about its axis has no limits, and its coordinates are (cos, sin) instead of the angle.
    """

    name: str
    symbol: str
    slides: Axes = Axes.NONE
    turns: Axes = Axes.NONE
    in_tree: bool = False
    in_loop: bool = True
    endless: bool = False

    @cached_property
    def freedoms(self) -> int:
        return self.slides.count + self.turns.count

    @cached_property
    def coordinates(self) -> int:
        """Number of coordinates in Pinocchio's ``q``: shifts, then an angle, (cos, sin) or a quaternion (x, y, z, w)."""
        return self.slides.count + (4 if self.turns is Axes.ALL else self.turns.count + self.endless)

    @cached_property
    def is_fixed(self) -> bool:
        return self.freedoms == 0

    @cached_property
    def is_free(self) -> bool:
        """Whether it has all six freedoms."""
        return self.freedoms == 6

    @cached_property
    def is_single(self) -> bool:
        """Whether it has one freedom, so that it may be actuated, have a limit, or follow another joint."""
        return self.freedoms == 1

    @cached_property
    def has_limits(self) -> bool:
        return self.is_single and not self.endless

    @cached_property
    def is_slide(self) -> bool:
        """Whether translation along its axis is its only freedom; its coordinate is a length."""
        return self.is_single and self.slides is Axes.AXIS

    @cached_property
    def is_hinge(self) -> bool:
        """Whether rotation about its axis is its only freedom."""
        return self.is_single and self.turns is Axes.AXIS

    @cached_property
    def is_on_axis(self) -> bool:
        """Whether it moves along and about its axis only, so that its origin is an arbitrary point of the axis."""
        return not self.is_fixed and {self.slides, self.turns} <= {Axes.NONE, Axes.AXIS}

    @cached_property
    def has_axis(self) -> bool:
        """Whether it has an axis: of translation or rotation, normal of a plane, or the first of two axes."""
        return not {self.slides, self.turns} <= {Axes.NONE, Axes.ALL}

    @cached_property
    def has_cone(self) -> bool:
        """Whether a ``<cone>`` may limit its tilt."""
        return self.in_loop and self.slides is Axes.NONE and self.turns.count > 1

    def axes(self, axis: Array) -> tuple[Array, Array]:
        """Return the directions (3, k) of the translations and the axes (3, k) of the rotations of a joint with an ``axis`` (3,).

        They are given in the joint's frame. The second axis of ``BOTH`` is omitted, because it is fixed in the successor.
        """

        def directions(which: Axes) -> Array:
            if which is Axes.ACROSS:
                return np.stack(across(axis), 1)
            return np.eye(3) if which is Axes.ALL else axis[:, None][:, : which is not Axes.NONE]

        return directions(self.slides), directions(self.turns)

    @cached_property
    def unit(self) -> str:
        """SI unit of the coordinate of a joint with one freedom."""
        return "m" if self.is_slide else "rad"

    @cached_property
    def force_unit(self) -> str:
        """SI unit of the force or torque of an actuator at a joint with one freedom."""
        return "N" if self.is_slide else "N·m"

    @cached_property
    def kind(self) -> str:
        """Kind of the coordinate of a joint with one freedom, "length" or "angle"."""
        return "length" if self.is_slide else "angle"


JOINT_TYPES = {
    kind.name: kind
    for kind in (
        JointType("fixed", "fixed", in_tree=True),
        JointType("revolute", "R", turns=Axes.AXIS, in_tree=True),
        JointType("continuous", "R", turns=Axes.AXIS, in_tree=True, endless=True),
        JointType("prismatic", "P", slides=Axes.AXIS, in_tree=True),
        JointType("cylindrical", "C", slides=Axes.AXIS, turns=Axes.AXIS),
        JointType("universal", "U", turns=Axes.BOTH),
        JointType("spherical", "S", turns=Axes.ALL),
        JointType("floating", "F", slides=Axes.ALL, turns=Axes.ALL, in_tree=True, in_loop=False),
        JointType("planar", "E", slides=Axes.ACROSS, turns=Axes.AXIS, in_tree=True, endless=True),
    )
}


def names_of(condition: str) -> tuple[str, ...]:
    """Return the names of the types for which ``condition``, a boolean attribute of :class:`JointType`, is true."""
    return tuple(name for name, kind in JOINT_TYPES.items() if getattr(kind, condition))
