"""A few lines about a map."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from kinetostatics.math.ordering import EQUAL, first_largest
from kinetostatics.status import FACTS, Status, in_map
from kinetostatics.workspace.schema import OTHER_MODE

if TYPE_CHECKING:
    import xarray as xr

#: A value, where it is, and of which drive.
Found = tuple[float, str, str]
#: Values that are read at once.
AT_ONCE = 2**22
#: From how many poses on their cost is told.
MANY = 1000
WORDS = {Status.OK: "reached", Status.UNREACHABLE: "unreachable", Status.SINGULAR: "singular"}


def summary(ds: xr.Dataset, seconds: float | None = None) -> str:
    """Return what a map says: how many poses are reached, the worst sag and the largest drive force and where, in words.

    Poses beyond the joints' limits count only where no other has numbers.

    Args:
        ds: of :func:`kinetostatics.sweep`; it is read piece by piece.
        seconds: how long it took, if that is to be said.
    """
    dims = ds["status"].dims
    size = int(ds["status"].size)
    counts = dict.fromkeys((WORDS[Status.OK], *(fact.summary for fact in FACTS.values()), *WORDS.values()), 0)
    several = others = 0
    units = [str(unit) for unit in ds["actuator_force_unit"].values] if "actuator_force" in ds else []
    # within the limits, and beyond them
    found = _Extremes(), _Extremes()
    for piece in _pieces(ds):
        part = ds.isel(piece)
        status = part["status"].values
        true = {fact.summary: in_map(part, name).values for name, fact in FACTS.items()}
        true |= {word: status == item for item, word in WORDS.items()}
        for word, where in true.items():
            counts[word] += int(where.sum())
        several += int((np.sum(list(true.values()), axis=0) > 1).sum())
        beyond = true[FACTS["limit_exceeded"].summary]
        others += int((part["mode"].values == OTHER_MODE).sum())
        for extremes, where in zip(found, (~beyond, beyond), strict=True):
            extremes.look_at(part, where, units)
    sizes = " × ".join(f"{name} {ds.sizes[name]}" for name in dims)
    lines = [
        f"{ds.attrs.get('robot_name', 'robot')}: {size} {'pose' if size == 1 else 'poses'}" + (f" ({sizes})" if dims else "")
    ]
    lines += [f"  {count:>10d} {word}" for word, count in counts.items() if count]
    if several:
        lines.append(f"  {several:>10d} of them counted more than once")
    if others:
        lines.append(f"  {others:>10d} of the unreachable ones in another assembly mode only")
    within, outside = found
    if within.sag is not None:
        lines += within.lines()
    elif outside.sag is not None:
        lines += ["no pose is within the joints' limits; beyond them:", *outside.lines()]
    if seconds is not None:
        # of fewer poses it says how long Python takes to start
        lines.append(f"{seconds:.1f} s" + (f", {1e6 * seconds / size:.3g} µs a pose" if size >= MANY else ""))
    return "\n".join(lines)


class _Extremes:
    """The worst poses so far: largest value, where it is, and of which drive."""

    def __init__(self) -> None:
        self.sag: Found | None = None
        self.turn: Found | None = None
        self.forces: dict[str, Found] = {}
        self.far = False

    def look_at(self, part: xr.Dataset, where: NDArray[np.bool_], units: Sequence[str]) -> None:
        """Look at the poses of a part of the map that are chosen by ``where``."""
        if not where.any():
            return
        twist = np.where(where[..., None], part["twist"].values, np.nan)
        self.sag = _larger(self.sag, part, np.sqrt((twist[..., :3] ** 2).sum(-1)))
        self.turn = _larger(self.turn, part, np.sqrt((twist[..., 3:] ** 2).sum(-1)))
        for k, unit in enumerate(units):
            force = np.where(where, np.abs(part["actuator_force"].values[..., k]), np.nan)
            largest = _larger(self.forces.get(unit), part, force, str(part["actuator"].values[k]))
            if largest is not None:
                self.forces[unit] = largest
        if self.sag is not None and self.turn is not None:
            self.far = self.sag[0] >= 0.1 * float(part["characteristic_length"].max()) or self.turn[0] >= 0.1

    def lines(self) -> list[str]:
        """Return what was found, in words."""
        found = []
        if self.sag is not None and self.turn is not None:
            found.append(f"worst sag {1e6 * self.sag[0]:.4g} µm at {self.sag[1]}")
            found.append(f"worst turn {np.degrees(self.turn[0]) * 1e3:.4g} millidegrees at {self.turn[1]}")
        if self.far:
            found.append("  linear theory does not cover that: the pose is nearly singular, or units in the file are wrong")
        return found + [
            f"largest drive {'force' if unit == 'N' else 'torque'} {value:.4g} {unit.replace(' ', '·')}, {drive}, at {where}"
            for unit, (value, where, drive) in self.forces.items()
        ]


def _larger(known: Found | None, part: xr.Dataset, values: NDArray[Any], what: str = "") -> Found | None:
    """Return the largest of some values and of what is known, and at which coordinates it is."""
    if not np.any(np.isfinite(values)):
        return known
    place = np.unravel_index(first_largest(np.where(np.isfinite(values), values, -np.inf).ravel()), values.shape)
    value = float(values[place])
    if known is not None and known[0] * (1 + EQUAL) >= value:
        return known
    words = [_said(part[name], part[name].values[k]) for name, k in zip(part["status"].dims, place, strict=True)]
    return value, ", ".join(words) or "the only pose", what


def _said(coordinate: xr.DataArray, value: Any) -> str:
    """Return "name = value unit", angles in degrees."""
    if not isinstance(value, (float, np.floating)):
        return f"{coordinate.name} = {value}"
    unit = str(coordinate.attrs.get("units", ""))
    if unit == "rad":
        value, unit = np.degrees(value), "deg"
    return f"{coordinate.name} = {value:.6g} {unit}".rstrip()


def _pieces(ds: xr.Dataset) -> Iterator[dict[Any, slice]]:
    """Yield pieces of the grid along its first dimension that are small enough to be read at once."""
    dims = ds["status"].dims
    if not dims:
        yield {}
        return
    layer = 12 * max(1, int(ds["status"].size) // max(1, ds.sizes[dims[0]]))
    thick = max(1, AT_ONCE // layer)
    for start in range(0, ds.sizes[dims[0]], thick):
        yield {dims[0]: slice(start, start + thick)}
