"""Loads on links, payloads and motions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from numpy.typing import ArrayLike

from kinetostatics.description.elements import Inertia
from kinetostatics.layout.mapping import ShortRepr


@dataclass(frozen=True, eq=False, repr=False)
class LinkLoad(ShortRepr):
    """A force and a moment on a link.

    Attributes:
        wrench: (…, 6) force [N] and moment [N·m], about ``point``.
        point: (…, 3) point of application, always in the link's frame [m].
        frame: axes of ``wrench``: "world" or "link".
    """

    wrench: ArrayLike
    point: ArrayLike = (0.0, 0.0, 0.0)
    frame: str = "world"


@dataclass(frozen=True, eq=False, repr=False)
class Payload(ShortRepr):
    """A payload: a mass on the platform, or on another link.

    Attributes:
        mass: (…) [kg].
        center: (…, 3) its centre of mass [m], in the platform's frame o-xyz, or in the frame of ``link``.
        inertia: inertia about its centre of mass; the statics does not use it.
        link: the link that carries it; None: the platform.
    """

    mass: ArrayLike
    center: ArrayLike = (0.0, 0.0, 0.0)
    inertia: Inertia | None = None
    link: str | None = None


@dataclass(frozen=True, eq=False, repr=False)
class Motion(ShortRepr):
    """A motion through a pose, or through each pose of a batch: rates of the coordinates that the poses were assembled with.

    Attributes:
        velocities: (…) by the name of the platform's coordinate, or of the actuator [m/s, rad/s]; those left out are zero.
        accelerations: likewise [m/s², rad/s²].
    """

    velocities: Mapping[str, ArrayLike] = field(default_factory=dict)
    accelerations: Mapping[str, ArrayLike] = field(default_factory=dict)
