"""Selection of the part of a map that a figure shows, and the range of its values."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from kinetostatics.argument_checks import warn
from kinetostatics.exceptions import ArgumentError, near_names
from kinetostatics.indices import quantity, swept
from kinetostatics.indices.map_variables import ANGULAR, LINEAR
from kinetostatics.math.arrays import Array
from kinetostatics.plot.display_units import coordinate_unit, display_unit, label
from kinetostatics.status import WITHOUT_NUMBERS, Status, in_map

#: Components of a motion, or parts of a force, whose largest is this small beside the whole are rounding.
ROUNDING = 1e-11
#: Variables that are coordinates, not small motions: they are shown as coordinates are.
COORDINATES = ("platform_pose", "actuator_position", "q")


@dataclass(frozen=True)
class ShownAxis:
    """A swept coordinate as the figure shows it.

    Attributes:
        name: of the dimension.
        values: (n,) in the figure's unit; names of cases are numbered.
        label: with the unit.
        unit: the figure's.
        ticks: what stands at the values, if they are names.
    """

    name: str
    values: Array
    label: str
    unit: str
    ticks: tuple[str, ...] = ()

    def said(self, place: int) -> str:
        """Return "name = value unit" of one of the values."""
        return _formatted(self.name, self.ticks[place] if self.ticks else f"{self.values[place]:.4g}", self.unit)


@dataclass(frozen=True)
class Selection:
    """A quantity over some of the swept coordinates, the others fixed.

    Attributes:
        what: its name.
        axes: the coordinates that vary.
        values: over the axes; NaN where the pose does not count.
        status: over the axes, why a pose has no number, if it has none.
        units: of the values.
        long_name: of the values.
        fixed: what the other coordinates are, in words; empty if there are none.
    """

    what: str
    axes: tuple[ShownAxis, ...]
    values: Array
    status: NDArray[np.int8]
    units: str
    long_name: str
    fixed: str


def axis_of(ds: xr.Dataset, name: str) -> ShownAxis:
    """Return a swept coordinate as figures show it.

    Raises:
        ArgumentError: it is not swept.
    """
    if name not in swept(ds):
        raise ArgumentError(f"{name!r} is not swept: {near_names(name, swept(ds))}")
    numbers = np.asarray(ds[name].values)
    if not np.issubdtype(numbers.dtype, np.number):
        return ShownAxis(name, np.arange(float(len(numbers))), name, "", tuple(str(item) for item in numbers))
    size, unit = coordinate_unit(str(ds[name].attrs.get("units", "")), numbers)
    return ShownAxis(name, numbers / size, label(name, unit), unit)


def free_names(ds: xr.Dataset, fixed: Iterable[str]) -> list[str]:
    """Return the swept coordinates that vary and are not fixed."""
    return [name for name in swept(ds) if name not in set(fixed) and ds.sizes[name] > 1]


def chosen_names(ds: xr.Dataset, wanted: Sequence[str | None], fixed: Iterable[str], figure: str) -> list[str]:
    """Return the coordinates of a figure's axes: those wanted, and in place of None the next that are free.

    Raises:
        ArgumentError: there are too few.
    """
    free = free_names(ds, fixed)
    rest = [name for name in free if name not in wanted]
    if len(rest) < sum(name is None for name in wanted):
        number = ("no coordinate", "one coordinate", "two coordinates", "three coordinates")[len(wanted)]
        hint = "; ks.plot.line shows a quantity over one (--kind line)" if len(free) == 1 < len(wanted) else ""
        raise ArgumentError(f"{figure} needs {number} with several values; not fixed are: {', '.join(free) or 'none'}{hint}")
    return [rest.pop(0) if name is None else name for name in wanted]


def _say_at_which(axes: Sequence[ShownAxis]) -> str:
    """Return a message on coordinates with several values that must be fixed."""
    several = ", ".join(f"{axis.name} has {len(axis.values)} values, from {axis.said(0)} to {axis.said(-1)}" for axis in axes)
    named = ", ".join(f"{axis.name!r}: …" for axis in axes)
    units = {"°": "deg"}
    middles = [(axis, len(axis.values) // 2) for axis in axes]
    written = " ".join(
        f"{axis.name}={axis.ticks[k] if axis.ticks else f'{axis.values[k]:.4g}{units.get(axis.unit, axis.unit)}'}"
        for axis, k in middles
    )
    return f"{several}: say at which, at={{{named}}} (--at {written})"


def select(ds: xr.Dataset, what: str, dims: Sequence[str], at: Mapping[str, float], beyond_limits: bool) -> Selection:
    """Return a quantity over ``dims``, numbers rising along them; nothing else of a lazy map is computed.

    Args:
        ds: of :func:`kinetostatics.sweep`.
        what: as in :func:`kinetostatics.indices.quantity`.
        dims: the coordinates that vary.
        at: the value of the others [m, rad]; the nearest one of the map is taken. Those with one value need none.
        beyond_limits: whether poses beyond the joints' limits count.

    Raises:
        ArgumentError: a coordinate is not swept, or not fixed, or fixed outside the map.
    """
    for name in dims:
        axis_of(ds, name)
    if len(set(dims)) < len(dims):
        raise ArgumentError(f"the axes {' and '.join(dims)} must be different coordinates")
    places, said = {}, []
    for name, value in at.items():
        axis = axis_of(ds, name)
        if name in dims:
            raise ArgumentError(f"{name} is an axis of the figure, and fixed at {value} too")
        places[name] = place_of(ds[name], axis, value)
        said.append(axis.said(places[name]))
    left = [name for name in swept(ds) if name not in dims and name not in places]
    if missing := [axis_of(ds, name) for name in left if ds.sizes[name] > 1]:
        raise ArgumentError(_say_at_which(missing))
    for name in left:
        places[name] = 0
        said.append(axis_of(ds, name).said(0))
    part = ds.isel(places)
    for name in dims:  # grids may be given in any order
        numbers = np.asarray(part[name].values)
        if numbers.dtype.kind not in "OUS" and np.any(np.diff(numbers) < 0):
            part = part.isel({name: np.argsort(numbers)})
    axes = tuple(axis_of(part, name) for name in dims)
    found = _without_rounding(part, what, quantity(part, what, beyond_limits=beyond_limits).transpose(*dims))
    return Selection(
        what=what,
        axes=axes,
        values=np.asarray(found.values, dtype=float),
        status=_status(part, dims, beyond_limits),
        units=str(found.attrs["units"]),
        long_name=str(found.attrs["long_name"]),
        fixed=", ".join([*said, *_held(ds)]),
    )


def select_each(
    ds: xr.Dataset,
    what: str,
    dims: Sequence[str],
    series: str | Mapping[str, Sequence[float]],
    most: int,
    at: Mapping[str, float],
    beyond_limits: bool,
) -> tuple[dict[str, Selection], str]:
    """Return what :func:`select` does at several values of one more coordinate, each by "name = value unit".

    Args:
        ds, what, dims, at, beyond_limits: as there.
        series: the coordinate with its values; or its name, for all of its values, or some of more than ``most``.
        most: see there.

    Returns:
        The selections; and, where not all values are chosen although none is named, how many are, which is warned of too.

    Raises:
        ArgumentError: the coordinate is not one, or has another task in the figure.
    """
    if not isinstance(series, str) and len(series) != 1:
        raise ArgumentError("series takes one coordinate")
    other = series if isinstance(series, str) else next(iter(series))
    axis = axis_of(ds, other)  # complains about its name first
    if other in dims or other in at:
        raise ArgumentError(f"{other} cannot be an axis of the figure, or fixed, and its series too")
    note, count = "", len(axis.values)
    if isinstance(series, str):
        shown = count if count <= most else most - 1 + most % 2  # of an odd number the middle one is among them
        places = np.linspace(0, count - 1, shown).round().astype(int).tolist()
        if len(places) < count:
            note = f"{len(places)} of the {count} values of {other}"
            warn(f"the figure shows {note}")
    else:
        places = [place_of(ds[other], axis, value) for value in series[other]]
    return {axis.said(k): select(ds.isel({other: k}, drop=True), what, dims, at, beyond_limits) for k in places}, note


def _without_rounding(part: xr.Dataset, what: str, found: xr.DataArray) -> xr.DataArray:
    """Return a component of small motions or a part of a force, 0 where all that is drawn is what rounding has left of 0."""
    name, _, rest = what.partition(":")
    if name in ("twist", "contribution", "gravity_mechanism") and "twist" in part:
        whole = part["twist"].sel(component=list(LINEAR if found.attrs["units"] == "m" else ANGULAR))
    elif name in ("actuator_contribution", "actuator_gravity_mechanism") and "actuator_force" in part:
        whole = part["actuator_force"].sel(actuator=rest.rpartition(":")[0])
    else:
        return found
    size = float(abs(found).max())
    return (found * 0).assign_attrs(found.attrs) if size < ROUNDING * float(abs(whole).max()) else found


def in_figure_units(parts: Sequence[Selection], unit: str | None) -> tuple[list[Array], str]:
    """Return the values of selections in one unit for all, and its name.

    Raises:
        ArgumentError: they have different units, or not the wanted one.
    """
    units = {part.units for part in parts}
    if len(units) > 1:
        raise ArgumentError(f"quantities in {' and '.join(sorted(units))} do not go into one figure")
    everything = np.concatenate([part.values.ravel() for part in parts])
    everything = everything[np.isfinite(everything)]
    if everything.size:  # what suits most of them
        everything = np.clip(everything, *main_range(everything))
    if unit is None and all(part.what.partition(":")[0] in COORDINATES for part in parts):
        size, name = coordinate_unit(units.pop(), everything)
    else:
        size, name = display_unit(units.pop(), everything, unit)
    return [part.values / size for part in parts], name


def _held(ds: xr.Dataset) -> list[str]:
    """Return the text of coordinates with a single value in the sweep: those without a unit are parameters of the file."""
    found = []
    for name in (str(item) for item in ds.coords):
        value, units = ds[name], str(ds[name].attrs.get("units", ""))
        if value.dims == () and units in ("m", "rad"):
            size, unit = coordinate_unit(units, value.values)
            found.append(_formatted(name, f"{float(value) / size:.4g}", unit))
    return found


def _formatted(name: str, value: str, unit: str) -> str:
    return f"{name} = {value} {unit}".replace(" °", "°").strip()


def _status(part: xr.Dataset, dims: Sequence[str], beyond_limits: bool) -> NDArray[np.int8]:
    status = part["status"]
    if beyond_limits:  # then that is no reason
        status = status.where(status != Status.LIMIT_EXCEEDED, Status.OK)
    else:
        beyond = in_map(part, "limit_exceeded") & ~status.isin([int(item) for item in WITHOUT_NUMBERS])
        status = status.where(~beyond, Status.LIMIT_EXCEEDED)
    return np.asarray(status.transpose(*dims).values, dtype=np.int8)


def place_of(coordinate: xr.DataArray, axis: ShownAxis, value: float) -> int:
    """Return the place of the value of a coordinate that is nearest to a given one, or has a given name.

    Raises:
        ArgumentError: there is none.
    """
    if axis.ticks:
        if str(value) not in axis.ticks:
            raise ArgumentError(f"no {axis.name} {value!r}: {near_names(str(value), axis.ticks)}")
        return axis.ticks.index(str(value))
    numbers = np.asarray(coordinate.values, dtype=float)
    place = int(np.argmin(np.abs(numbers - value)))
    step = float(np.abs(np.diff(numbers)).max(initial=0.0))
    if not abs(numbers[place] - value) <= step / 2 + 1e-9 * max(1.0, abs(value)):
        units = str(coordinate.attrs.get("units", ""))
        raise ArgumentError(
            f"{axis.name} = {value:g} {units}".rstrip()
            + f" is outside the map, which ranges from {numbers.min():g} to {numbers.max():g} {units}".rstrip()
        )
    return place


# ---- ranges ----------------------------------------------------------------------------------------------------------------

#: With fewer values none is told apart as an outlier.
FEW = 20
#: The part of the values at either end that may lie far beyond the others, and how many times their range that is.
PART, FAR = 0.02, 3.0


def main_range(values: NDArray[np.float64]) -> tuple[float, float]:
    """Return smallest and largest value, without a few outliers.

    Near a singularity the sag is unbounded, so that a single pose could leave one colour for all others.
    """
    low, high = float(values.min()), float(values.max())
    if values.size < FEW:
        return low, high
    first = float(np.quantile(values, PART, method="higher"))
    last = float(np.quantile(values, 1 - PART, method="lower"))
    far = FAR * (last - first)
    if far <= 0:
        return low, high
    return (first if first - low > far else low), (last if high - last > far else high)


@dataclass(frozen=True)
class ValueRange:
    """The values that colours or heights show.

    Attributes:
        low, high: from where to where.
        extend: at which ends of a colour bar values lie beyond.
        note: how far they go beyond a range that nobody has asked for, in words: ", up to 70.6".
    """

    low: float
    high: float
    extend: Literal["neither", "both", "min", "max"]
    note: str


def range_of(values: NDArray[np.float64], value_range: tuple[float, float] | None) -> ValueRange:
    """Return the range of finite values: the given one, or the main one."""
    low, high = value_range or main_range(values)
    least, most = float(values.min()), float(values.max())
    words = ([f"from {least:.3g}"] if least < low else []) + ([f"up to {most:.3g}"] if most > high else [])
    note = f", {' '.join(words)}".replace("-", "−") if words and value_range is None else ""
    below, above = least < low, most > high
    return ValueRange(low, high, "both" if below and above else "min" if below else "max" if above else "neither", note)


def check_range(value_range: tuple[float, float] | None) -> None:
    """Check a range of values.

    Raises:
        ArgumentError: the first is not below the second, or one is not a finite number.
    """
    if value_range is None:
        return
    try:
        low, high = (float(item) for item in value_range)
    except (TypeError, ValueError):
        raise ArgumentError(f"value_range is {value_range!r}; it must be two numbers, the smaller one first") from None
    if not (np.isfinite([low, high]).all() and low < high):
        raise ArgumentError(f"value_range is ({low:g}, {high:g}); it must be two numbers, the smaller one first")
