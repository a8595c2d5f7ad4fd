"""Joints of the tree and loops, each checked when it is made: its type, and what this type may have."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from operator import mul
from typing import ClassVar

from kinetostatics.description.elements import AT_LINK, Origin
from kinetostatics.description.fields import (
    IN_PYTHON,
    LONGEST,
    CheckedPart,
    Direction,
    Limit,
    Name,
    NotNegative,
    Number,
    Place,
    Positive,
    Text,
)
from kinetostatics.description.joint_types import JOINT_TYPES, Axes, JointType, names_of
from kinetostatics.exceptions import near_names
from kinetostatics.layout.mapping import ShortRepr

#: Default axes and limits, and the names of the joint types with one freedom.
X, Y, NO_LIMITS, SINGLE = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (-math.inf, math.inf), ", ".join(names_of("is_single"))
#: 1 − cos of the smallest angle between the two axes of a universal joint.
_PARALLEL = 1e-9


@dataclass(frozen=True, repr=False)
class Mimic(ShortRepr):
    """``<mimic>``: the joint's coordinate is ``multiplier`` times the coordinate of ``joint``, plus ``offset`` [m, rad]."""

    joint: Text
    multiplier: Number = 1.0
    offset: Number = 0.0


class JointOrLoop(CheckedPart):
    """What joints and loops have in common: a known type, and limits."""

    WHERE: ClassVar[str]  #: the property of its types
    OTHERS: ClassVar[str] = ""
    type: str
    lower: float
    upper: float

    @property
    def of_type(self) -> JointType:
        """The row of its type in the table of joint types."""
        return JOINT_TYPES[self.type]

    def __post_init__(self) -> None:
        if self.type not in (types := names_of(self.WHERE)):
            raise self.place.error(f"{self.label} has the type {self.type!r}; {near_names(self.type, types)}{self.OTHERS}")
        super().__post_init__()
        lower, upper = self.lower, self.upper
        if (lower, upper) == (-math.inf, math.inf):
            return
        if math.isinf(lower) or math.isinf(upper):
            raise self.place.error(f"{self.label} has lower={lower:g} and upper={upper:g}; without limits both are infinite")
        if lower > upper:
            note = " (one that is left out is 0)" if self.place.line is not None and 0 in (lower, upper) else ""
            raise self.place.of("limit").error(f"{self.label} has lower={lower:g} above upper={upper:g}{note}")


@dataclass(frozen=True, repr=False)
class Joint(JointOrLoop):
    """A URDF joint of the spanning tree.

    Attributes:
        name: name of the joint.
        type: ``fixed``, ``revolute``, ``continuous``, ``prismatic``, ``floating`` or ``planar``.
        parent, child: names of the links that it joins.
        origin: the joint's frame, relative to the parent link; the child's frame coincides with it when the coordinate is zero.
        axis: the axis in the joint's frame; a unit vector once the description is validated.
        lower, upper: limits of the coordinate [rad or m]; infinite if the file has no limits.
        mimic: the joint whose coordinate this joint follows; None if it follows none.
        effort, velocity: limits of the actuator's force and speed [N or N·m, m/s or rad/s]; 0: unknown.
        extra: XML of ``<dynamics>``, ``<safety_controller>`` and other child elements, which is preserved.
        place: file and line of the joint.
    """

    KIND: ClassVar = "joint"
    WHERE: ClassVar = "in_tree"
    OTHERS: ClassVar = " (joints of other types are a <loop>, or several joints in a row)"

    name: Name
    type: Text
    parent: Text
    child: Text
    origin: Origin = AT_LINK
    axis: Direction = (1.0, 0.0, 0.0)
    lower: Limit = -math.inf
    upper: Limit = math.inf
    mimic: Mimic | None = None
    effort: NotNegative = 0.0
    velocity: NotNegative = 0.0
    extra: str = field(default="", repr=False)
    place: Place = field(default=IN_PYTHON, compare=False, kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        kind, place = self.of_type, self.place
        if not kind.has_axis:
            object.__setattr__(self, "axis", X)
        if kind.slides is Axes.ACROSS and math.hypot(*self.axis[:2]) > 1e-9:
            lacks = place.line is not None and "axis" not in place.inner
            stated = "it has no <axis>, for which the default is x" if lacks else "its axis is not z"
            raise place.of("axis").error(
                f"{self.label} is {kind.name} and {stated}, but planar joints of Pinocchio move in the xy plane of "
                'the joint\'s frame: write <axis xyz="0 0 1"/> and turn the frame with <origin rpy>, or use a planar <loop>'
            )
        if self.mimic is not None and not kind.is_fixed:
            self._check_mimic(kind, self.mimic, place.of("mimic"))

    def _check_mimic(self, kind: JointType, mimic: Mimic, place: Place) -> None:
        if not kind.is_single:
            raise place.error(f"{self.label} is {kind.name} and cannot mimic; only joints with one freedom can: {SINGLE}")
        if not 1 / LONGEST <= abs(mimic.multiplier) <= LONGEST:
            raise place.error(
                f"multiplier={mimic.multiplier:g} of <mimic> in {self.label} must be of a size between {1 / LONGEST:g} and "
                f"{LONGEST:g}: the joint's coordinate is multiplier times that of the other joint plus offset, in m and rad"
            )
        if abs(mimic.offset) > LONGEST:
            raise place.error(
                f"offset={mimic.offset:g} of <mimic> in {self.label} is too large; it is in m or rad, at most {LONGEST:g}"
            )


@dataclass(frozen=True, repr=False)
class Cone(ShortRepr):
    """Limit of a loop: the largest ``angle`` [rad] between two axes, given in the loop's frames on predecessor and successor."""

    angle: Positive
    predecessor_axis: Direction = (0.0, 0.0, 1.0)
    successor_axis: Direction = (0.0, 0.0, 1.0)


@dataclass(frozen=True, repr=False)
class Loop(JointOrLoop):
    """A joint that closes a loop, ``<loop>``.

    Attributes:
        name: name of the loop.
        type: one of the eight joint types that can close a loop, see :mod:`kinetostatics.description.joint_types`.
        predecessor, successor: names of the links that it joins.
        predecessor_origin, successor_origin: the joint's frame on each of these links, relative to the link.
        axis: first axis, in the frame ``predecessor_origin``; a unit vector once the description is validated.
        axis2: second axis of a universal joint, in the frame ``successor_origin``; a unit vector once the description is
            validated.
        lower, upper: limits of the coordinate of a joint with one freedom [rad or m]; infinite if the file has no limits.
        cone: limit of a universal or spherical joint.
        effort, velocity: see :class:`Joint`.
        place: file and line of the loop.
    """

    KIND: ClassVar = "loop"
    WHERE: ClassVar = "in_loop"

    name: Name
    type: Text
    predecessor: Text
    successor: Text
    predecessor_origin: Origin = AT_LINK
    successor_origin: Origin = AT_LINK
    axis: Direction = (1.0, 0.0, 0.0)
    axis2: Direction = (0.0, 1.0, 0.0)
    lower: Limit = -math.inf
    upper: Limit = math.inf
    cone: Cone | None = None
    effort: NotNegative = 0.0
    velocity: NotNegative = 0.0
    place: Place = field(default=IN_PYTHON, compare=False, kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        kind, place, limits = self.of_type, self.place, (self.lower, self.upper)
        limited = (*limits, self.effort, self.velocity) != (*NO_LIMITS, 0, 0)
        given = {"axis": self.axis != X, "axis2": self.axis2 != Y, "limit": limited, "cone": self.cone is not None}
        self.check_given(tag for tag, there in given.items() if there)
        if kind.endless and limits != NO_LIMITS:
            raise place.of("limit").error(f"{self.label} is {kind.name}, which means unlimited; make it revolute to limit it")
        if kind.turns is Axes.BOTH and 1 - abs(sum(map(mul, self.axis, self.axis2))) < _PARALLEL:
            raise place.of("axis2", "axis").error(
                f"the two axes of {self.label} are parallel where its frames coincide; left out, <axis> is x and <axis2> is y"
            )
        if self.cone is not None and self.cone.angle > math.pi:
            if self.cone.angle > math.pi + 1e-9:  # a rounded π may be slightly larger
                raise place.of("cone").error(
                    f"angle={self.cone.angle:g} of <cone> in {self.label} is above π; it is an angle between two axes, in radians"
                )
            object.__setattr__(self, "cone", replace(self.cone, angle=math.pi))

    def check_given(self, tags: Iterable[str]) -> None:
        """Raise an error if one of the child elements ``tags``, which are given, does not belong to this type of loop."""
        kind, name = self.of_type, self.type
        rules = {
            "axis": (kind.has_axis, f"{name} and has no <axis>; turn its frames with <origin rpy>"),
            "axis2": (kind.turns is Axes.BOTH, f"{name} and has no <axis2>; only universal has"),
            "limit": (
                kind.is_single,
                f"{name}, and <limit> is for {SINGLE}{'; a <cone> limits it' if kind.has_cone else ''}",
            ),
            "cone": (kind.has_cone, f"{name}, and <cone> is for {' and '.join(names_of('has_cone'))}"),
        }
        for tag in tags:
            allowed, reason = rules.get(tag, (True, ""))
            if not allowed:
                raise self.place.of(tag).error(f"{self.label} is {reason}")
