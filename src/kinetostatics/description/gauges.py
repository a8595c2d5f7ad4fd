"""Gauges that measure displacements of the platform."""

from __future__ import annotations

from dataclasses import dataclass

from kinetostatics.description.elements import Vector


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
