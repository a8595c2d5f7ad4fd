"""The canonical basis of a limb's wrenches as data: unit forces and couples along features of the limb."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar


@dataclass(frozen=True)
class Candidate:
    """A candidate: a unit force through a joint's centre, or a unit couple, along a direction.

    Attributes:
        direction: ``("limb", k)``: the limb's axis x, y or z; ``("beam", b)``: along its b-th beam, through whose platform end a
            force passes; ``("axis", f)``: that of its f-th freedom; ``("cross", f, h)``: across two of them;
            ``("cross_limb", f, k)``; ``("to", u)``: towards the centre of its u-th joint; ``("meets", f, h)``: so that the axes
            of two freedoms are met; ``("complement", s)``: no direction but the s-th seed, see ``Basis``.
        centre: the joint whose centre the force passes through, or two freedoms in whose axes' common point it acts; None for a
            couple.
        label: its name in reports.
    """

    NOT_RECORDED: ClassVar = ("label",)

    direction: tuple[str | int, ...]
    centre: int | tuple[int, int] | None
    label: str


@dataclass(frozen=True)
class Basis:
    """The candidates chosen for one limb.

    Attributes:
        constraint, attached: candidates of J_ic and of J_ig.
        independent: which of the twists that the limb allows are independent at generic poses, for the completion of J_ic.
        carried: the same among the platform joint's freedoms, for the completion of J_ig.
        gap: ratio of the smallest kept to the largest dropped singular value of the limb's twists.
    """

    constraint: tuple[Candidate, ...]
    attached: tuple[Candidate, ...]
    independent: tuple[int, ...]
    carried: tuple[int, ...]
    gap: float
