"""Selection of the shown part of a map, the range of its values, and their display units: µm instead of 1e-6 m, degrees."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from kinetostatics.arguments import warn
from kinetostatics.exceptions import ArgumentError, near_names
from kinetostatics.indices import quantity, swept
from kinetostatics.indices.map_variables import ANGULAR, LINEAR
from kinetostatics.math.arrays import Array
from kinetostatics.status import WITHOUT_NUMBERS, Status, in_map
from kinetostatics.units import IN_FIGURES, find_unit, unit

#: A component below this part of the whole displacement, rotation or force is a rounding error.
ROUNDING = 1e-11
#: Variables shown in the units of coordinates, not of small displacements.
COORDINATES = ("platform_pose", "actuator_position", "q")


@dataclass(frozen=True)
class ShownAxis:
    """A swept coordinate in the unit of a figure.

    Attributes:
        name: name of the dimension.
        values: (n,) values in the display unit; if the values are names, their indices.
        label: title of the axis, with unit.
        unit: display unit.
        ticks: the values, if they are names.
    """

    name: str
    values: Array
    label: str
    unit: str
    ticks: tuple[str, ...] = ()

    def text_at(self, place: int) -> str:
        """Return the text "name = value unit" for the value at an index."""
        return _formatted(self.name, self.ticks[place] if self.ticks else f"{self.values[place]:.4g}", self.unit)


@dataclass(frozen=True)
class Selection:
    """A quantity over some of the swept coordinates, the others fixed.

    Attributes:
        what: name of the quantity.
        axes: the varying coordinates.
        values: values over the axes; NaN at poses without a valid value.
        status: status over the axes; it gives the reason for missing values.
        units: units of the values.
        long_name: title of the values.
        fixed: text on the values of the other coordinates; empty if there are none.
    """

    what: str
    axes: tuple[ShownAxis, ...]
    values: Array
    status: NDArray[np.int8]
    units: str
    long_name: str
    fixed: str


def axis_of(ds: xr.Dataset, name: str) -> ShownAxis:
    if name not in swept(ds):
        raise ArgumentError(f"{name!r} is not swept: {near_names(name, swept(ds))}")
    numbers = np.asarray(ds[name].values)
    if not np.issubdtype(numbers.dtype, np.number):
        return ShownAxis(name, np.arange(float(len(numbers))), name, "", tuple(str(number) for number in numbers))
    size, unit = coordinate_unit(str(ds[name].attrs.get("units", "")), numbers)
    return ShownAxis(name, numbers / size, label(name, unit), unit)


def free_names(ds: xr.Dataset, fixed: Iterable[str]) -> list[str]:
    """Return the swept coordinates that have several values and are not fixed."""
    return [name for name in swept(ds) if name not in set(fixed) and ds.sizes[name] > 1]


def chosen_names(ds: xr.Dataset, requested: Sequence[str | None], fixed: Iterable[str], figure: str) -> list[str]:
    """Return the coordinates of a figure's axes: each None in ``requested`` is replaced by the next of :func:`free_names`."""
    free = free_names(ds, fixed)
    remaining = [name for name in free if name not in requested]
    if len(remaining) < sum(name is None for name in requested):
        number = ("no coordinate", "one coordinate", "two coordinates", "three coordinates")[len(requested)]
        hint = "; ks.plot.line shows a quantity over one (--kind line)" if len(free) == 1 < len(requested) else ""
        raise ArgumentError(f"{figure} needs {number} with several values; not fixed are: {', '.join(free) or 'none'}{hint}")
    return [remaining.pop(0) if name is None else name for name in requested]


def _message_for_free(axes: Sequence[ShownAxis]) -> str:
    """Return an error message that asks for values of ``axes``, coordinates with several values."""
    several = ", ".join(
        f"{axis.name} has {len(axis.values)} values, from {axis.text_at(0)} to {axis.text_at(-1)}" for axis in axes
    )
    named = ", ".join(f"{axis.name!r}: …" for axis in axes)
    units = {"°": "deg"}
    middles = [(axis, len(axis.values) // 2) for axis in axes]
    written = " ".join(
        f"{axis.name}={axis.ticks[k] if axis.ticks else f'{axis.values[k]:.4g}{units.get(axis.unit, axis.unit)}'}"
        for axis, k in middles
    )
    return f"{several}: choose by at={{{named}}} (--at {written})"


def select(ds: xr.Dataset, what: str, dims: Sequence[str], at: Mapping[str, float], beyond_limits: bool) -> Selection:
    """Return a quantity over the coordinates ``dims``, sorted by their values; of a lazy map only this part is computed.

    ``at`` gives values of the other coordinates [m, rad]; the nearest values in the map are used. Coordinates with a single
    value may be omitted.
    """
    for name in dims:
        axis_of(ds, name)
    if len(set(dims)) < len(dims):
        raise ArgumentError(f"the axes {' and '.join(dims)} must be different coordinates")
    places, texts = {}, []
    for name, value in at.items():
        axis = axis_of(ds, name)
        if name in dims:
            raise ArgumentError(f"{name} cannot be both an axis of the figure and fixed at {value}")
        places[name] = place_of(ds[name], axis, value)
        texts.append(axis.text_at(places[name]))
    left = [name for name in swept(ds) if name not in dims and name not in places]
    if missing := [axis_of(ds, name) for name in left if ds.sizes[name] > 1]:
        raise ArgumentError(_message_for_free(missing))
    for name in left:
        places[name] = 0
        texts.append(axis_of(ds, name).text_at(0))
    part = ds.isel(places)
    for name in dims:  # coordinates of the grid may be unordered
        numbers = np.asarray(part[name].values)
        if numbers.dtype.kind not in "OUS" and np.any(np.diff(numbers) < 0):
            part = part.isel({name: np.argsort(numbers)})
    axes = tuple(axis_of(part, name) for name in dims)
    field = _without_rounding(part, what, quantity(part, what, beyond_limits=beyond_limits).transpose(*dims))
    return Selection(
        what=what,
        axes=axes,
        values=np.asarray(field.values, dtype=float),
        status=_status(part, dims, beyond_limits),
        units=str(field.attrs["units"]),
        long_name=str(field.attrs["long_name"]),
        fixed=", ".join([*texts, *_constants(ds)]),
    )


def select_each(
    ds: xr.Dataset,
    what: str,
    dims: Sequence[str],
    series: str | Mapping[str, Sequence[float]] | None,
    most: int,
    at: Mapping[str, float],
    beyond_limits: bool,
) -> tuple[dict[str, Selection], str]:
    """Return selections at several values of a further coordinate, with keys such as "z = 0.5 m"; and a note, or an empty text.

    Args:
        ds, what, dims, at, beyond_limits: see :func:`select`.
        series: the coordinate with its values; or its name, for all values; None: one selection, of empty key.
        most: largest number of selections if ``series`` is a name. If the coordinate has more values, evenly distributed values
            are selected; the note and a warning state their number.
    """
    if series is None:
        return {"": select(ds, what, dims, at, beyond_limits)}, ""
    if not isinstance(series, str) and len(series) != 1:
        raise ArgumentError("series takes one coordinate")
    other = series if isinstance(series, str) else next(iter(series))
    axis = axis_of(ds, other)  # checks the name
    if other in dims or other in at:
        raise ArgumentError(f"{other} cannot be the series and also an axis of the figure or fixed")
    note, count = "", len(axis.values)
    if isinstance(series, str):
        shown = count if count <= most else most - 1 + most % 2  # an odd number includes the middle value
        places = np.linspace(0, count - 1, shown).round().astype(int).tolist()
        if len(places) < count:
            note = f"{len(places)} of the {count} values of {other}"
            warn(f"the figure shows {note}")
    else:
        places = [place_of(ds[other], axis, value) for value in series[other]]
    return {axis.text_at(k): select(ds.isel({other: k}, drop=True), what, dims, at, beyond_limits) for k in places}, note


def _without_rounding(part: xr.Dataset, what: str, field: xr.DataArray) -> xr.DataArray:
    """Return the values of a quantity; a component of a displacement or force is set to 0 if all values are rounding errors."""
    name, _, actuator_and_source = what.partition(":")
    if name in ("twist", "contribution", "gravity_mechanism") and "twist" in part:
        whole = part["twist"].sel(component=list(LINEAR if field.attrs["units"] == "m" else ANGULAR))
    elif name in ("actuator_contribution", "actuator_gravity_mechanism") and "actuator_force" in part:
        whole = part["actuator_force"].sel(actuator=actuator_and_source.rpartition(":")[0])
    else:
        return field
    size = float(abs(field).max())
    return (field * 0).assign_attrs(field.attrs) if size < ROUNDING * float(abs(whole).max()) else field


def in_figure_units(parts: Sequence[Selection], unit: str | None) -> tuple[list[Array], str]:
    """Return the values of each selection in one display unit for all, and the name of this unit."""
    units = {part.units for part in parts}
    if len(units) > 1:
        raise ArgumentError(f"quantities in {' and '.join(sorted(units))} cannot be drawn in one figure")
    everything = np.concatenate([part.values.ravel() for part in parts])
    everything = everything[np.isfinite(everything)]
    if everything.size:  # without outliers
        everything = np.clip(everything, *main_range(everything))
    if unit is None and all(part.what.partition(":")[0] in COORDINATES for part in parts):
        size, name = coordinate_unit(units.pop(), everything)
    else:
        size, name = display_unit(units.pop(), everything, unit)
    return [part.values / size for part in parts], name


def _constants(ds: xr.Dataset) -> list[str]:
    """Return texts such as "z = 0.5 m" on constant coordinates of the sweep, which are scalars in m or rad."""
    texts = []
    for name in (str(coordinate) for coordinate in ds.coords):
        value, units = ds[name], str(ds[name].attrs.get("units", ""))
        if value.dims == () and units in ("m", "rad"):
            size, unit = coordinate_unit(units, value.values)
            texts.append(_formatted(name, f"{float(value) / size:.4g}", unit))
    return texts


def _formatted(name: str, value: str, unit: str) -> str:
    return f"{name} = {value} {unit}".replace(" °", "°").strip()


def _status(part: xr.Dataset, dims: Sequence[str], beyond_limits: bool) -> NDArray[np.int8]:
    status = part["status"]
    if beyond_limits:  # limits are not a reason for missing values
        status = status.where(status != Status.LIMIT_EXCEEDED, Status.OK)
    else:
        beyond = in_map(part, "limit_exceeded") & ~status.isin([int(code) for code in WITHOUT_NUMBERS])
        status = status.where(~beyond, Status.LIMIT_EXCEEDED)
    return np.asarray(status.transpose(*dims).values, dtype=np.int8)


def place_of(coordinate: xr.DataArray, axis: ShownAxis, value: float) -> int:
    """Return the index of the coordinate's value nearest to ``value``; if its values are names, ``value`` is the index itself."""
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


#: Smallest number of values for the detection of outliers.
FEW = 20
#: Part of the values at each end that may be outliers; least distance of outliers from other values, by their range.
PART, FAR = 0.02, 3.0


def main_range(values: NDArray[np.float64]) -> tuple[float, float]:
    """Return the smallest and largest value without a few outliers.

    Near a singularity the sag is unbounded: one such pose would determine the range of colours.
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
    """Range of values of colours or heights.

    Attributes:
        low, high: limits of the range.
        extend: limits beyond which there are values, in Matplotlib's terms for colour bars.
        note: text on values outside a default range, such as ", up to 70.6".
    """

    low: float
    high: float
    extend: Literal["neither", "both", "min", "max"]
    note: str


def range_of(numbers: Sequence[Array], value_range: tuple[float, float] | None) -> ValueRange:
    """Return the given range, or :func:`main_range` of the finite values of all arrays."""
    values = np.concatenate([part[np.isfinite(part)] for part in numbers])
    low, high = value_range or main_range(values)
    least, most = float(values.min()), float(values.max())
    below, above = least < low, most > high
    words = ([f"from {least:.3g}"] if below else []) + ([f"up to {most:.3g}"] if above else [])
    note = f", {' '.join(words)}".replace("-", "−") if words and value_range is None else ""
    extend: dict[tuple[bool, bool], Literal["neither", "both", "min", "max"]] = {
        (False, False): "neither", (True, False): "min", (False, True): "max", (True, True): "both"
    }  # fmt: skip
    return ValueRange(low, high, extend[below, above], note)


def check_range(value_range: tuple[float, float] | None) -> None:
    if value_range is None:
        return
    try:
        low, high = map(float, value_range)
        valid = -np.inf < low < high < np.inf
    except (TypeError, ValueError):
        valid = False
    if not valid:
        raise ArgumentError(f"value_range is {value_range!r}; it must be two numbers, the smaller one first")


def display_unit(units: str, values: ArrayLike, requested: str | None = None) -> tuple[float, str]:
    """Return size and name of the unit in which values are shown; the values are to be divided by the size.

    Args:
        units: unit of the values in the map.
        values: all values in the figure.
        requested: display unit; None: the largest unit in which the largest value is at least 1.

    Raises:
        ArgumentError: the requested unit has another dimension.
    """
    units = units.replace("N m", "N·m")
    choices = IN_FIGURES.get(units, (units,))
    if requested is not None:
        wanted, given = find_unit(requested), find_unit(units)
        if requested == units:
            return 1.0, requested
        if wanted is None or given is None or wanted.dimension != given.dimension:
            further = ", deg" if units == "rad" else ", N/µm" if units == "N/m" else ""
            raise ArgumentError(f"unit {requested!r} is not one for values in {units}: {', '.join(choices)}{further}")
        return wanted.size / given.size, _typeset_unit(requested)
    sizes = sorted((unit(name).size, name) for name in choices if find_unit(name) is not None) or [(1.0, units)]
    finite = np.asarray(values, dtype=float)
    finite = np.abs(finite[np.isfinite(finite)])
    largest = float(finite.max(initial=0.0))
    if largest == 0:
        return 1.0, units
    fitting = [pair for pair in sizes if pair[0] <= largest * (1 + 1e-12)]
    return fitting[-1] if fitting else sizes[0]


def _typeset_unit(name: str) -> str:
    """Return a unit with µ for u and ° for deg."""
    name = re.sub(r"u(?=m|rad|N|deg)", "µ", name)
    return {"deg": "°", "mdeg": "10⁻³ °"}.get(name, name)


def coordinate_unit(units: str, values: ArrayLike) -> tuple[float, str]:
    """Return size and name of the display unit of a coordinate: degrees for angles; m, or mm if all lengths are below 0.1 m."""
    if units == "rad":
        return unit("deg").size, "°"
    if units == "m":
        largest = np.abs(np.asarray(values, dtype=float)).max(initial=0.0)
        return (1.0, "m") if largest >= 0.1 or largest == 0 else (1e-3, "mm")
    return display_unit(units, values)


def label(name: str, unit: str) -> str:
    """Return "name [unit]"; the unit of a dimensionless quantity is omitted."""
    return name if unit in ("", "1") else f"{name} [{unit}]"


def typeset(text: str) -> str:
    """Return a text with typographic minus signs after "="."""
    return text.replace("= -", "= −")
