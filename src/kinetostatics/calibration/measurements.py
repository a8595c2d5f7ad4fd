"""Tables of measurements: poses, loads and readings, from CSV files, columns, rows or an xarray Dataset."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from kinetostatics.calibration.gauge_readings import number_in
from kinetostatics.description.gauges import Gauge
from kinetostatics.description.units import PLATFORM_KINDS
from kinetostatics.exceptions import ArgumentError
from kinetostatics.files.csv_tables import check_columns, column_name, read_csv
from kinetostatics.math.arrays import Array, Index
from kinetostatics.math.screws import WRENCH_COMPONENTS
from kinetostatics.robot import Robot

if TYPE_CHECKING:
    import xarray as xr

#: Title of a column of remarks, which is ignored.
NOTE = "note"


@dataclass(frozen=True)
class Measurements:
    """Measurements, row by row; SI units.

    Attributes:
        coordinates: (N,) coordinates of the platform or the actuators, by name [m, rad]; empty: the zero pose.
        load: (N, 6) loads [N, N·m].
        readings: (N,) readings by gauge [m, rad]; NaN if missing.
        rows: (N,) line of the file, or index of the row.
        places: name of each row in messages.
    """

    coordinates: Mapping[str, Array]
    load: Array
    readings: Mapping[str, Array]
    rows: Index
    places: Sequence[str]

    @property
    def repeated(self) -> list[str]:
        """A warning of rows that are equal in all numbers, including noisy readings; empty if there are none."""
        cells = np.column_stack([*self.coordinates.values(), self.load, *self.readings.values()])
        first: dict[bytes, int] = {}
        again = [(k, at) for k, row in enumerate(cells) if (at := first.setdefault((row + 0.0).tobytes(), k)) != k]
        if not again:
            return []
        here, there = (self.places[k].removesuffix(": ") for k in again[0])
        more = f", and {len(again) - 1} more do so" if len(again) > 1 else ""
        return [
            f"{here} has the pose, load and readings of {there}{more}: a repeated row counts twice and makes "
            "the intervals too narrow; leave it out"
        ]


def read_measurements(robot: Robot, given: object, gauges: Mapping[str, Gauge]) -> Measurements:
    """Read a table of measurements.

    Args:
        robot: the robot.
        given: the path of a CSV file; a mapping from titles to columns; a sequence of mappings, one for each row; or an xarray
            Dataset, whose variables and coordinates are the columns. Titles may have units in brackets; the default is SI.
        gauges: the available gauges.

    Raises:
        ArgumentError: a title or a cell is invalid; the message names file and line.
    """
    where, titles, rows = _table(given)
    kinds = {
        **PLATFORM_KINDS,
        **_actuators(robot),
        **{name: "force" if name[0] == "F" else "moment" for name in WRENCH_COMPONENTS},
    }
    kinds |= {name: gauge.kind for name, gauge in gauges.items()}
    place = where(None).removesuffix(": ")
    named = [column_name(title, place) for title in titles]
    names = [name for name, _ in named]
    check_columns(place, names, [*kinds, NOTE])
    columns: dict[str, list[float]] = {name: [] for name in names if name != NOTE}
    numbers = []
    for number, row in rows:
        numbers.append(number)
        for (name, unit), cell in zip(named, row, strict=True):
            if name == NOTE:
                continue
            empty = cell is None or (isinstance(cell, str) and not cell.strip())
            empty = empty or (isinstance(cell, (float, np.floating)) and math.isnan(cell))
            if empty and name not in gauges and name not in WRENCH_COMPONENTS:
                raise ArgumentError(f"{where(number)}{name} is missing: the cell is empty")
            nothing = math.nan if name in gauges else 0.0
            value = nothing if empty else number_in(cell, unit, kinds[name], f"{where(number)}{name}")
            columns[name].append(value)
    arrays = {name: np.array(column) for name, column in columns.items()}
    readings = {name: array for name, array in arrays.items() if name in gauges}
    if not any(np.any(np.isfinite(array)) for array in readings.values()):
        raise ArgumentError(
            f"{where(None)}there are no readings: a column of a component of the twist, such as dz [um], or of a gauge"
        )
    coordinates = {name: array for name, array in arrays.items() if name not in readings and name not in WRENCH_COMPONENTS}
    load = np.stack([arrays.get(name, np.zeros(len(rows))) for name in WRENCH_COMPONENTS], axis=-1)
    return Measurements(coordinates, load, readings, np.array(numbers), list(map(where, numbers)))


def _actuators(robot: Robot) -> dict[str, str]:
    connections = robot.mechanism.connections
    return {name: connections[name].type.kind for name in robot.description.driven}


def _table(given: object) -> tuple[Callable[[int | None], str], list[str], list[tuple[int, Sequence[object]]]]:
    """Return a function that names rows, the titles, and the rows with their numbers."""
    if isinstance(given, (str, os.PathLike)):
        path = os.fspath(given)
        what = "a table of measurements has a line of titles, such as z [mm],rx [deg],Fz [N],dz [um], and one of each row"
        table = read_csv(path, what)
        return (lambda n: f"{table.place if n is None else table.where(n)}: "), list(table.names), list(table.rows)
    if hasattr(given, "data_vars") and hasattr(given, "variables"):
        given = _columns_of(given.variables)
    elif hasattr(given, "columns") and hasattr(given, "to_dict"):  # a pandas DataFrame
        given = given.to_dict("list")
    if isinstance(given, Mapping) and given:
        try:
            columns = np.broadcast_arrays(*(np.atleast_1d(np.asarray(column, dtype=object)) for column in given.values()))
        except ValueError:
            sizes = {str(name): np.size(column) for name, column in given.items()}
            raise ArgumentError(f"measurements: the columns are not equally long: {sizes}") from None
        return _place, [str(name) for name in given], list(enumerate(zip(*(column.ravel() for column in columns), strict=True)))
    if isinstance(given, Sequence) and given and all(isinstance(row, Mapping) for row in given):
        titles = list(dict.fromkeys(str(name) for row in given for name in row))
        return _place, titles, [(k, [row.get(name) for name in titles]) for k, row in enumerate(given)]
    raise ArgumentError(
        f'measurements are {given!r}; they must be a CSV file, columns such as {{"z": [0.5, 0.6], "dz": [-1e-6, -2e-6]}}, or rows'
    )


def _place(number: int | None) -> str:
    return "measurements: " if number is None else f"measurements, row {number}: "


def _columns_of(variables: Mapping[object, xr.Variable]) -> dict[str, object]:
    """Return the columns of an xarray Dataset, broadcast against one another; units of attributes go to the titles."""
    import xarray as xr

    arrays = [array for array in variables.values() if array.dtype.kind in "iuf"]
    names = [str(name) for name, array in variables.items() if array.dtype.kind in "iuf"]
    spread = xr.broadcast(*(xr.DataArray(array) for array in arrays))
    units = [array.attrs.get("units", "") for array in arrays]
    titles = [f"{name} [{unit}]" if unit and "[" not in name else name for name, unit in zip(names, units, strict=True)]
    return {title: array.values.ravel() for title, array in zip(titles, spread, strict=True)}
