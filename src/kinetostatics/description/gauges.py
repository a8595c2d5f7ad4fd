"""Gauges that measure displacements of the platform."""

from __future__ import annotations

from dataclasses import dataclass

from kinetostatics.description.elements import Vector


@dataclass(frozen=True)
class Gauge:
    """A dial gauge, displacement sensor or inclinometer at the platform.

    Attributes:
        direction: along which, or about which, the reading is positive; of any length, which does not matter.
        point: of the platform that is touched [m]; it does not matter to a rotation. None: o.
        frame: "world": ``direction`` is in world axes and ``point`` a point of the world, where the gauge stands; "platform":
            both in the platform's axes, ``point`` from o, so that they go with the platform.
        measures: "displacement" [m] or "rotation" [rad].
        sigma: standard deviation of a reading [m, rad]; None: not known, and the same for all gauges.
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


#: Gauges that need no description: the components of the platform's twist at o, world axes.
COMPONENTS = {
    f"{prefix}{axis}": Gauge(tuple(float(k == j) for j in range(3)), measures=measures)  # type: ignore[arg-type]
    for prefix, measures in (("d", "displacement"), ("dr", "rotation"))
    for k, axis in enumerate("xyz")
}
