"""Loads on links, payloads, motions, and gauges that measure deflections of the platform."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from numpy.typing import ArrayLike

from kinetostatics.description.elements import Inertia
from kinetostatics.description.fields import Vector
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
        inertia: inertia about its centre of mass; statics does not use it.
        link: the link that carries it; None: the platform.
    """

    mass: ArrayLike
    center: ArrayLike = (0.0, 0.0, 0.0)
    inertia: Inertia | None = None
    link: str | None = None


@dataclass(frozen=True, eq=False, repr=False)
class Motion(ShortRepr):
    """A motion through a pose, or through each pose of a batch: rates of the coordinates from which the poses were assembled.

    Attributes:
        velocities: (…) by name of the platform coordinate or actuator [m/s, rad/s]; zero if left out.
        accelerations: (…) by name of the platform coordinate or actuator [m/s², rad/s²]; zero if left out.
    """

    velocities: Mapping[str, ArrayLike] = field(default_factory=dict)
    accelerations: Mapping[str, ArrayLike] = field(default_factory=dict)


@dataclass(frozen=True)
class Gauge:
    """A dial gauge, displacement sensor or inclinometer at the platform.

    Attributes:
        direction: direction or axis of a positive reading; its length is ignored.
        point: measured point of the platform [m], irrelevant for a rotation; None: o.
        frame: "world": ``direction`` in world axes, ``point`` fixed in the world; "platform": both in platform axes, ``point``
            from o, moving with the platform.
        measures: "displacement" [m] or "rotation" [rad].
        sigma: standard deviation of a reading [m, rad]; None: unknown and equal for all gauges.
    """

    direction: Vector
    point: Vector | None = None
    frame: str = "world"
    measures: str = "displacement"
    sigma: float | None = None

    @property
    def kind(self) -> str:
        """Kind of the readings: "length" or "angle"."""
        return "length" if self.measures == "displacement" else "angle"


#: Predefined gauges: the components of the platform's twist at o, world axes.
COMPONENTS = {
    f"{prefix}{axis}": Gauge(tuple(float(k == j) for j in range(3)), measures=measures)  # type: ignore[arg-type]
    for prefix, measures in (("d", "displacement"), ("dr", "rotation"))
    for k, axis in enumerate("xyz")
}
