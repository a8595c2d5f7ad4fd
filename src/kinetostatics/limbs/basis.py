"""The canonical basis of a limb's wrenches as data: unit forces and couples along features of the limb."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar


@dataclass(frozen=True)
class Candidate:
    """A candidate wrench: a unit force through the centre of a joint, or a unit couple, along a direction.

    Attributes:
        direction: ``("limb", k)``: axis x, y or z of the limb; ``("beam", b)``: along the b-th beam, through its platform end;
            ``("axis", f)``: axis of the f-th freedom; ``("cross", f, h)``: perpendicular to the axes of two freedoms;
            ``("cross_limb", f, k)``: perpendicular to the axis of a freedom and a limb axis; ``("to", u)``: towards the centre of
            the u-th joint; ``("meets", f, h)``: intersecting the axes of two freedoms; ``("complement", s)``: no direction, but
            the s-th seed of the completion.
        centre: the joint whose centre lies on the line of the force, or two freedoms whose axes intersect there; None for a
            couple.
        label: name in reports.
    """

    NOT_RECORDED: ClassVar = ("label",)

    direction: tuple[str | int, ...]
    centre: int | tuple[int, int] | None
    label: str


@dataclass(frozen=True)
class Basis:
    """The candidates chosen for one limb.

    Attributes:
        constraint, attached: chosen candidates of J_ic and J_ig.
        independent: indices of allowed twists that are independent at generic poses, for the completion of J_ic.
        carried: likewise for the freedoms of the platform joint, for the completion of J_ig.
        gap: ratio of the smallest kept to the largest dropped singular value of the limb's twists.
    """

    constraint: tuple[Candidate, ...]
    attached: tuple[Candidate, ...]
    independent: tuple[int, ...]
    carried: tuple[int, ...]
    gap: float
