"""Sections that vary along a beam: linearly in their dimensions between *stations*; two stations at one place make a step."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, fields
from itertools import pairwise

import numpy as np

from kinetostatics.exceptions import ArgumentError
from kinetostatics.math.arrays import Array
from kinetostatics.math.rotations import skew
from kinetostatics.sections.kinds import Rectangle, RectangularTube, Section, Tube, sizes_of

#: Kinds of sections of uniform beams, and of stations.
UNIFORM = (Tube, Rectangle, RectangularTube, Section)


@dataclass(frozen=True)
class Station:
    """A section of a beam at a place, ``<station>``.

    Attributes:
        at: distance from the beam's start relative to its length, 0 … 1.
        section: the section there.
        offset: position (2,) of its centroid along y and z, from the line between the beam's ends [m].
    """

    at: float
    section: Section
    offset: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True)
class Tapered(Section):
    """A section that varies along the beam, by its ``stations``. Area, moments and shear areas are mean values."""

    stations: tuple[Station, ...] = ()

    @classmethod
    def of(cls, stations: Iterable[Station]) -> Tapered:
        """Make a section from its stations, from the beam's start to its end.

        Raises:
            ArgumentError: the stations do not begin at 0, end at 1 and follow one another, or are of different kinds.
        """
        given = tuple(stations)
        places, kinds = [station.at for station in given], {type(station.section) for station in given}
        most = {at: places.count(at) - (0 < at < 1) for at in places}
        if len(given) < 2 or (places[0], places[-1]) != (0, 1) or sorted(places) != places or max(most.values()) > 1:
            listed = ", ".join(f"{at:g}" for at in places)
            raise ArgumentError(f"its stations are at {listed or 'no place'}; give one at 0, one or two at each place, one at 1")
        if len(kinds) > 1 or not kinds <= set(UNIFORM) or len({station.section.shear_area_y is None for station in given}) > 1:
            names = ", ".join(sorted(kind.__name__ for kind in kinds))
            raise ArgumentError(f"its stations are {names}; give uniform sections of one kind, all or none with shear areas")
        if not np.all(np.isfinite([station.offset for station in given])):
            raise ArgumentError("an offset of its stations is not finite")
        points, weights = (np.polynomial.legendre.leggauss(4) + np.array([[1.0], [0.0]])) / 2
        pieces = [
            (w * (b.at - a.at), _between(a, b, x).section)
            for a, b in pairwise(given)
            for x, w in zip(points, weights, strict=True)
        ]
        numbers = [field.name for field in fields(Section) if getattr(given[0].section, field.name) is not None]
        means: dict[str, float] = {name: float(sum(w * getattr(part, name) for w, part in pieces)) for name in numbers}
        return cls(**means, stations=given)

    @property
    def places(self) -> tuple[float, ...]:
        return tuple(station.at for station in self.stations)

    @property
    def reversed(self) -> Tapered:
        """The same section seen from the end, with x and z axes reversed."""
        return Tapered.of(Station(1 - s.at, s.section, (s.offset[0], -s.offset[1])) for s in self.stations[::-1])

    def at(self, fraction: float) -> tuple[Station, ...]:
        """Return the section at a fraction of the length: at a step, the sections before and behind it."""
        here = tuple(station for station in self.stations if station.at == fraction)
        a, b = next((a, b) for a, b in pairwise(self.stations) if a.at < b.at and a.at <= fraction <= b.at)
        return here or (_between(a, b, (fraction - a.at) / (b.at - a.at)),)

    @property
    def is_isotropic(self) -> bool:
        return all(station.section.is_isotropic and not any(station.offset) for station in self.stations)

    @property
    def extent(self) -> tuple[float, float]:
        y, z = np.max([np.array(station.section.extent) + np.abs(station.offset) for station in self.stations], axis=0)
        return float(y), float(z)

    def shear_coefficients(self, poisson_ratio: float) -> tuple[float, float] | None:
        factors = [pair for station in self.stations if (pair := station.section.shear_coefficients(poisson_ratio)) is not None]
        return (float(np.mean(factors, axis=0)[0]), float(np.mean(factors, axis=0)[1])) if factors else None

    def stress_along(self, wrenches: Array, fractions: Array, poisson_ratio: float = 0.3) -> Array:
        result = []
        for wrench, fraction in zip(np.moveaxis(wrenches, 1, 0), fractions.tolist(), strict=True):
            stresses = []
            for station in self.at(fraction):
                moment = wrench[3:] - np.tensordot(skew(np.array([0.0, *station.offset])), wrench[:3], 1)  # about the centroid
                stresses.append(station.section.stress(np.concatenate([wrench[:3], moment]), poisson_ratio))
            result.append(np.max(stresses, axis=0))
        return np.array(result)


def _between(a: Station, b: Station, part: float) -> Station:
    """Return the station at a part of the way from one to the next."""
    kind = type(a.section)
    names = sizes_of(kind) or [field.name for field in fields(kind) if getattr(a.section, field.name) is not None]
    sizes = {name: (1 - part) * getattr(a.section, name) + part * getattr(b.section, name) for name in names}
    y, z = ((1 - part) * first + part * last for first, last in zip(a.offset, b.offset, strict=True))
    section = kind(**sizes) if kind is Section else kind.of(**sizes)  # type: ignore[attr-defined]
    return Station((1 - part) * a.at + part * b.at, section, (y, z))
