"""Elastic links that are no beams: their interface, and links given by their matrices, ``<flexible>``."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from kinetostatics.description.elements import Beam, BeamEnd, Link
from kinetostatics.description.fields import IN_PYTHON, CheckedPart, Name, Place, Positive, Text
from kinetostatics.description.link_matrices import LinkMatrices
from kinetostatics.layout.numbers import join_words


class ElasticPart(Protocol):
    """An elastic link that is no beam: :class:`Flexible`, or another dataclass, with the method ``model`` of
    :class:`kinetostatics.elements.link.PlacedLink`.

    Attributes:
        KIND: its kind in messages.
        link: name of the robot's link.
        start, end: its ends towards base and platform, as of a :class:`Beam`.
        name: name of the elastic link.
        place: file and line.
        numbers: SI units of the numbers that may vary, by field.
        errors: SI units of its assembly errors, by kind.
    """

    KIND: ClassVar[str] = "elastic link"
    numbers: ClassVar[Mapping[str, str]]

    link: str
    start: BeamEnd | None
    end: BeamEnd | None
    name: str
    place: Place
    errors: Mapping[str, str]

    @property
    def interfaces(self) -> tuple[str, ...]:
        """The joints at which the link is held and loaded."""
        return tuple(end.joint for end in (self.start, self.end) if end is not None)

    @property
    def digest(self) -> str:
        """Text that changes with any value."""
        return repr(self)

    def check_direction(self, along: NDArray[np.float64]) -> None:
        """Raise an error if the vector (3,) between the ends, in the link's frame, does not fit the other data."""
        return

    def check_place(self, joints: Sequence[str], others: Sequence[Beam | ElasticPart], role: str) -> None:
        """Raise an error if the elastic link does not fit its link.

        Args:
            joints, others: joints and loops of the link, and its other elastic links.
            role: "base" or "platform", or empty.
        """
        return

    def hints(self, link: Link) -> Iterable[str]:
        """Return warnings, in full sentences, about differences from the link."""
        return ()


@dataclass(frozen=True, repr=False)
class Flexible(CheckedPart, ElasticPart):
    """A link by its matrices, ``<flexible>``.

    Attributes:
        link: name of the link.
        matrices: its matrices; the names of their interfaces are those of the link's joints and loops.
        stiffness_factor: factor of the stiffness and of the loads due to heat, for sensitivities, tolerances and calibration.
        name: name of the elastic link; default: the link's name.
        file: the ``.npz`` file from which the matrices are; empty for matrices made in Python.
        place: file and line of the element.
    """

    KIND: ClassVar = "flexible"
    #: Fields that compiled code does not depend on: MatrixLink has the values.
    NOT_RECORDED: ClassVar = ("matrices", "stiffness_factor", "name")

    numbers: ClassVar[Mapping[str, str]] = {"stiffness_factor": "1"}

    link: Text
    matrices: LinkMatrices
    stiffness_factor: Positive = 1.0
    name: Name = ""
    file: str = field(default="", compare=False, kw_only=True)
    place: Place = field(default=IN_PYTHON, compare=False, kw_only=True)

    def __post_init__(self) -> None:
        if not self.name:
            object.__setattr__(self, "name", self.link)
        super().__post_init__()

    @property
    def start(self) -> BeamEnd:  # type: ignore[override]
        """The first interface, ``o`` if there is one."""
        return BeamEnd(self.interfaces[0])

    @property
    def end(self) -> BeamEnd:  # type: ignore[override]
        """The second interface."""
        return BeamEnd(self.interfaces[1])

    @property
    def errors(self) -> Mapping[str, str]:  # type: ignore[override]
        """SI units of the assembly errors, by kind."""
        return {} if self.matrices.thermal is None else {"temperature": "K"}

    @property
    def interfaces(self) -> tuple[str, ...]:
        return tuple(sorted(self.matrices.names, key=lambda name: name != "o"))

    @property
    def digest(self) -> str:
        return f"{self!r} {self.matrices.digest}"

    def check_place(self, joints: Sequence[str], others: Sequence[Beam | ElasticPart], role: str) -> None:
        for other in others:
            raise self.place.error(f"{self.label}: the link {self.link!r} is elastic already by {other.name!r}, in {other.place}")
        names = self.matrices.names
        for name in names:
            if name not in joints and not (role and name == "o"):
                has = join_words(joints)
                raise self.place.error(f"{self.label}: the interface {name!r} is no joint of link {self.link!r}, which has {has}")
        for name in joints:
            if name not in names:
                reason = f"the joint {name!r} of link {self.link!r} is no interface; the interfaces are {join_words(names)}"
                raise self.place.error(f"{self.label}: {reason}")

    def hints(self, link: Link) -> list[str]:
        """Return warnings, in full sentences, about differences of the matrices from the link's ``<inertial>``."""
        if not link.has_inertial:
            weightless = self.matrices.mass is None and self.matrices.gravity is None
            return [f"{self.place}: {self.label} has no mass matrix and its link no <inertial>; it weighs nothing."] * weightless
        body = self.matrices.body
        inertia = body[2] if body is not None and not any(link.inertia.moments) else link.inertia.matrix
        words = self.matrices.differences(link.mass, np.array(link.center_of_mass), inertia)
        return [f"{self.place}: {self.label}: {difference}; the matrices count." for difference in words]
