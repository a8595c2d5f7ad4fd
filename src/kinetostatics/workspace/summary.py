"""A few lines about a map."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from kinetostatics.configuration import Status
from kinetostatics.workspace.schema import OTHER_MODE

if TYPE_CHECKING:
    import xarray as xr

#: Values that are read at once.
AT_ONCE = 2**22
WORDS = {
    Status.OK: "reached",
    Status.LIMIT_EXCEEDED: "beyond a joint's limit",
    Status.UNREACHABLE: "unreachable",
    Status.SINGULAR: "singular",
    Status.INDETERMINATE: "with undetermined forces",
    Status.BASIS_DEGENERATE: "with unreadable intensities",
}


def summary(ds: xr.Dataset, seconds: float | None = None) -> str:
    """Return what a map says: how many poses are reached, the worst sag and the largest drive force and where, in words.

    Args:
        ds: of :func:`kinetostatics.sweep`; it is read piece by piece.
        seconds: how long it took, if that is to be said.
    """
    dims = ds["status"].dims
    size = int(ds["status"].size)
    counts = np.zeros(len(Status), dtype=int)
    others = 0
    # largest value, where, and of which drive
    sag: tuple[float, str, str] = (-1.0, "", "")
    turn, force = sag, dict.fromkeys(("N", "N m"), sag)
    units = [str(unit) for unit in ds["actuator_force_unit"].values] if "actuator_force" in ds else []
    for piece in _pieces(ds):
        part = ds.isel(piece)
        counts += np.bincount(np.ravel(part["status"].values), minlength=len(Status))
        others += int((part["mode"].values == OTHER_MODE).sum())
        twist = part["twist"].values
        sag = max(sag, _largest(part, np.sqrt((twist[..., :3] ** 2).sum(-1))), key=_first)
        turn = max(turn, _largest(part, np.sqrt((twist[..., 3:] ** 2).sum(-1))), key=_first)
        for k, unit in enumerate(units):
            found = _largest(part, np.abs(part["actuator_force"].values[..., k]), str(ds["actuator"].values[k]))
            force[unit] = max(force[unit], found, key=_first)
    sizes = " × ".join(f"{name} {ds.sizes[name]}" for name in dims)
    lines = [f"{ds.attrs.get('robot_name', 'robot')}: {size} poses" + (f" ({sizes})" if dims else "")]
    lines += [f"  {counts[status]:>10d} {word}" for status, word in WORDS.items() if counts[status]]
    if others:
        lines.append(f"  {others:>10d} of the unreachable ones in another assembly mode only")
    if sag[0] >= 0:
        lines.append(f"worst sag {1e6 * sag[0]:.4g} µm at {sag[1]}")
        lines.append(f"worst turn {np.degrees(turn[0]) * 1e3:.4g} millidegrees at {turn[1]}")
    lines += [
        f"largest drive {'force' if unit == 'N' else 'torque'} {value:.4g} {unit}, {drive}, at {where}"
        for unit, (value, where, drive) in force.items()
        if value >= 0
    ]
    if seconds is not None:
        lines.append(f"{seconds:.1f} s, {1e6 * seconds / max(size, 1):.3g} µs a pose")
    return "\n".join(lines)


def _first(found: tuple[float, str, str]) -> float:
    return found[0]


def _largest(part: xr.Dataset, values: NDArray[Any], what: str = "") -> tuple[float, str, str]:
    """Return the largest of some values, and at which coordinates it is."""
    if not np.any(np.isfinite(values)):
        return -1.0, "", ""
    place = np.unravel_index(int(np.nanargmax(values)), values.shape)
    words = []
    for name, k in zip(part["status"].dims, place, strict=True):
        value = part[name].values[k]
        number = f"{value:.6g}" if isinstance(value, (float, np.floating)) else str(value)
        words.append(f"{name} = {number}")
    return float(values[place]), ", ".join(words) or "the only pose", what


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
