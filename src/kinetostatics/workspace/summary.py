"""A few lines about a map."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

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
    # within the limits, and beyond them: the largest of each kind
    within: dict[str, Found] = {}
    outside: dict[str, Found] = {}
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
        _look_at(within, part, ~beyond)
        _look_at(outside, part, beyond)
    sizes = " × ".join(f"{name} {ds.sizes[name]}" for name in dims)
    lines = [
        f"{ds.attrs.get('robot_name', 'robot')}: {size} {'pose' if size == 1 else 'poses'}" + (f" ({sizes})" if dims else "")
    ]
    lines += [f"  {count:>10d} {word}" for word, count in counts.items() if count]
    if several:
        lines.append(f"  {several:>10d} of them counted more than once")
    if others:
        lines.append(f"  {others:>10d} of the unreachable ones in another assembly mode only")
    if within:
        lines += _said_of(within, ds)
    elif outside:
        lines += ["no pose is within the joints' limits; beyond them:", *_said_of(outside, ds)]
    if seconds is not None:
        # of fewer poses it says how long Python takes to start
        lines.append(f"{seconds:.1f} s" + (f", {1e6 * seconds / size:.3g} µs a pose" if size >= MANY else ""))
    return "\n".join(lines)


def _look_at(found: dict[str, Found], part: xr.Dataset, where: NDArray[np.bool_]) -> None:
    """Take note of the largest values at the poses of a part of the map that are chosen by ``where``."""
    if not where.any():
        return
    twist = part["twist"].values
    numbers = [("sag", "", np.linalg.norm(twist[..., :3], axis=-1)), ("turn", "", np.linalg.norm(twist[..., 3:], axis=-1))]
    if "actuator_force" in part:
        drives = zip(part["actuator"].values, part["actuator_force_unit"].values, strict=True)
        forces = np.moveaxis(np.abs(part["actuator_force"].values), -1, 0)
        numbers += [(str(unit), str(name), force) for (name, unit), force in zip(drives, forces, strict=True)]
    for kind, drive, values in numbers:
        largest = _larger(found.get(kind), part, np.where(where, values, np.nan), drive)
        if largest is not None:
            found[kind] = largest


def _said_of(found: dict[str, Found], ds: xr.Dataset) -> list[str]:
    """Return the largest values in words."""
    lines = []
    if "sag" in found and "turn" in found:
        (sag, sags, _), (turn, turns, _) = found["sag"], found["turn"]
        lines += [f"worst sag {1e6 * sag:.4g} µm at {sags}", f"worst turn {np.degrees(turn) * 1e3:.4g} millidegrees at {turns}"]
        if sag >= 0.1 * float(ds["characteristic_length"].max()) or turn >= 0.1:
            lines.append("  linear theory does not cover that: the pose is nearly singular, or units in the file are wrong")
    return lines + [
        f"largest drive {'force' if unit == 'N' else 'torque'} {value:.4g} {unit.replace(' ', '·')}, {drive}, at {where}"
        for unit, (value, where, drive) in found.items()
        if unit not in ("sag", "turn")
    ]


def _larger(known: Found | None, part: xr.Dataset, values: NDArray[np.generic], what: str = "") -> Found | None:
    """Return the largest of some values and of what is known, and at which coordinates it is."""
    if not np.any(np.isfinite(values)):
        return known
    place = np.unravel_index(first_largest(np.where(np.isfinite(values), values, -np.inf).ravel()), values.shape)
    value = float(values[place])
    if known is not None and known[0] * (1 + EQUAL) >= value:
        return known
    words = [_said(part[name], part[name].values[k]) for name, k in zip(part["status"].dims, place, strict=True)]
    return value, ", ".join(words) or "the only pose", what


def _said(coordinate: xr.DataArray, value: object) -> str:
    """Return "name = value unit", angles in degrees."""
    if not isinstance(value, (float, np.floating)):
        return f"{coordinate.name} = {value}"
    unit = str(coordinate.attrs.get("units", ""))
    if unit == "rad":
        value, unit = np.degrees(value), "deg"
    return f"{coordinate.name} = {value:.6g} {unit}".rstrip()


def _pieces(ds: xr.Dataset) -> Iterator[dict[object, slice]]:
    """Yield pieces of the grid along its first dimension that are small enough to be read at once."""
    dims = ds["status"].dims
    if not dims:
        yield {}
        return
    layer = 12 * max(1, int(ds["status"].size) // max(1, ds.sizes[dims[0]]))
    thick = max(1, AT_ONCE // layer)
    for start in range(0, ds.sizes[dims[0]], thick):
        yield {dims[0]: slice(start, start + thick)}
