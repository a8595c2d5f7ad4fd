"""Tables of gauges and of measurements: poses, loads and readings, from CSV files, columns, rows or an xarray Dataset."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from kinetostatics.arguments import Keyword, check_choice, check_mapping, finite_numbers, positive
from kinetostatics.description.loads import COMPONENTS, Gauge
from kinetostatics.exceptions import ArgumentError
from kinetostatics.files.csv_tables import check_columns, column_name, read_csv, with_unit
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.math.arrays import Array, Index
from kinetostatics.math.linalg import cross
from kinetostatics.math.screws import WRENCH_COMPONENTS
from kinetostatics.robot import Robot, robot_of
from kinetostatics.units import PLATFORM_KINDS, parse_number

if TYPE_CHECKING:
    import xarray as xr

#: Columns of a table of gauges, and kinds of their numbers; None: words.
COLUMNS = {
    **{"name": None, "frame": None, "measures": None, "sigma": "length"},
    **dict.fromkeys(("x", "y", "z"), "length"),
    **dict.fromkeys(("ux", "uy", "uz"), "number"),
}


def read_gauges(given: str | os.PathLike[str] | Mapping[str, Gauge] | None) -> dict[str, Gauge]:
    """Return gauges by name, among them the components dx … drz of the twist.

    ``given``: None, a mapping from names to gauges, or the path of a CSV file. Raise an ArgumentError if a gauge is invalid.
    """
    if given is None:
        return dict(COMPONENTS)
    if isinstance(given, (str, os.PathLike)):
        gauges = _read_file(os.fspath(given))
    else:
        check_mapping("gauges", given, '{"tip": ks.Gauge(direction=(0, 0, 1), point=(0.1, 0, 0), frame="platform")}')
        gauges = {f"gauges: {name}": (name, gauge) for name, gauge in given.items()}
    return {**COMPONENTS, **{name: _checked(where, gauge) for where, (name, gauge) in gauges.items()}}


def _checked(where: str, gauge: object) -> Gauge:
    if not isinstance(gauge, Gauge):
        raise ArgumentError(f"{where} is {gauge!r}; it must be a gauge, such as ks.Gauge(direction=(0, 0, 1))")
    direction = finite_numbers(f"{where}: direction", gauge.direction)
    point = finite_numbers(f"{where}: point", (0, 0, 0) if gauge.point is None else gauge.point)
    if direction.shape != (3,) or point.shape != (3,) or not np.any(direction):
        raise ArgumentError(f"{where}: direction and point must have three numbers each, and direction must not be zero")
    check_choice(f"{where}: frame", gauge.frame, ("world", "platform"))
    check_choice(f"{where}: measures", gauge.measures, ("displacement", "rotation"))
    if gauge.sigma is not None:
        positive(f"{where}: sigma", gauge.sigma, "a positive number [m, rad], the standard deviation of a reading")
    return gauge


def _read_file(path: str) -> dict[str, tuple[str, Gauge]]:
    """Return pairs (name, gauge) by file and line, such as "gauges.csv:3"."""
    example = "a table of gauges has a line of titles, such as name,x [mm],y [mm],z [mm],ux,uy,uz, and one of each"
    table = read_csv(path, example, COLUMNS, ("name", "ux", "uy", "uz"))
    gauges: dict[str, tuple[str, Gauge]] = {}
    for line, row in table.rows:
        where = table.where(line)
        texts = {name: cell for name, cell in zip(table.names, row, strict=True) if cell}
        kinds = {**COLUMNS, "sigma": "angle" if texts.get("measures") == "rotation" else "length"}
        cells: dict[str, Keyword] = {}
        for name, cell in texts.items():
            kind = kinds[name]
            cells[name] = cell if kind is None else parse_number(cell, kind, f"{where}: {name}")
        name = str(cells.pop("name", ""))
        if not name or any(name == other for other, _ in gauges.values()):
            raise ArgumentError(f"{where}: a gauge needs a unique name, got {name!r}")
        direction = cells.pop("ux", 0.0), cells.pop("uy", 0.0), cells.pop("uz", 0.0)
        point = tuple(cells.pop(axis) for axis in "xyz" if axis in cells)
        if len(point) in (1, 2):
            raise ArgumentError(f"{where}: a coordinate x, y or z of the point is missing; omit all three for o")
        gauges[where] = (name, Gauge(direction, point=point or None, **cells))
    return gauges


def readings_by_twist(gauges: Sequence[Gauge], which: Index, pose: Configuration, rows: Index) -> Array:
    """Return rows (n, 6) [1, m]: the product of row k and the twist [d; r] at o, world axes, is reading k.

    A gauge of direction u at the arm a from o reads the displacement u · d + (a × u) · r, or the rotation u · r. For each
    reading, ``which`` (n,) is the index of its gauge, and ``rows`` (n,) the index of its pose.
    """
    R, o = robot_of(pose).mechanism.platform_pose(pose.frames)
    factors = np.zeros((len(which), 6))
    for k, gauge in enumerate(gauges):
        of_gauge = which == k
        turn, origin = R[..., rows[of_gauge]], o[:, rows[of_gauge]]
        u = np.array(gauge.direction, dtype=float)[:, None] / np.linalg.norm(gauge.direction)
        arm = np.zeros((3, 1)) if gauge.point is None else np.array(gauge.point, dtype=float)[:, None]
        if gauge.frame == "platform":
            u, arm = (np.einsum("ijn,j->in", turn, vector[:, 0]) for vector in (u, arm))
        elif gauge.point is not None:
            arm = arm - origin
        u, arm = np.broadcast_to(u, origin.shape), np.broadcast_to(arm, origin.shape)
        part = slice(0, 3) if gauge.measures == "displacement" else slice(3, 6)
        factors[of_gauge, part] = u.T
        if gauge.measures == "displacement":
            factors[of_gauge, 3:] = cross(arm, u).T  # u · (d + r × a) = u · d + (a × u) · r
    return factors


#: Title of a column of remarks, which is ignored.
NOTE = "note"


@dataclass(frozen=True)
class Measurements:
    """Measurements, row by row; SI units.

    Attributes:
        coordinates: (N,) coordinates of the platform or the actuators, by name [m, rad]; empty: actuators at zero.
        load: (N, 6) loads [N, N·m].
        readings: (N,) readings by gauge [m, rad]; NaN if missing.
        rows: (N,) number of each row: line of the file, or index from 0.
        places: name of each row in messages.
    """

    coordinates: Mapping[str, Array]
    load: Array
    readings: Mapping[str, Array]
    rows: Index
    places: Sequence[str]

    @property
    def repeated(self) -> list[str]:
        """A list with one warning if two rows have equal numbers, since noisy readings differ; otherwise empty."""
        cells = np.column_stack([*self.coordinates.values(), self.load, *self.readings.values()])
        first: dict[bytes, int] = {}
        equal = [first.setdefault((row + 0.0).tobytes(), k) for k, row in enumerate(cells)]  # + 0.0: −0 equals 0
        again = [(k, at) for k, at in enumerate(equal) if at != k]
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
        robot: gives names and units of the actuators' coordinates.
        given: the path of a CSV file; a mapping from titles to columns; a sequence of mappings, one for each row; or an xarray
            Dataset, whose variables and coordinates are the columns. Titles may have units in brackets; the default is SI.
        gauges: gauges that may have a column.

    Raises:
        ArgumentError: a title or a cell is invalid; the message names file and line.
    """
    where, titles, rows = _table(given)
    kinds = {
        **PLATFORM_KINDS,
        **{name: robot.mechanism.connections[name].type.kind for name in robot.description.actuated},
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
            text = repr(float(cell)) if isinstance(cell, (int, float, np.number)) else str(cell).strip()
            value = math.nan if name in gauges else 0.0
            if not empty:  # a number without a unit has the unit of its column
                value = parse_number(with_unit(text, unit), kinds[name], f"{where(number)}{name}")
            columns[name].append(value)
    arrays = {name: np.array(column) for name, column in columns.items()}
    readings = {name: array for name, array in arrays.items() if name in gauges}
    if not any(np.any(np.isfinite(array)) for array in readings.values()):
        raise ArgumentError(
            f"{where(None)}there are no readings: add a column of a component of the twist, such as dz [um], or of a gauge"
        )
    coordinates = {name: array for name, array in arrays.items() if name not in readings and name not in WRENCH_COMPONENTS}
    load = np.stack([arrays.get(name, np.zeros(len(rows))) for name in WRENCH_COMPONENTS], axis=-1)
    return Measurements(coordinates, load, readings, np.array(numbers), list(map(where, numbers)))


def _table(given: object) -> tuple[Callable[[int | None], str], list[str], list[tuple[int, Sequence[object]]]]:
    """Return (where, titles, rows) of a table.

    ``where(number)`` names a row in messages, ``where(None)`` the table. ``rows`` are pairs of a row's number and its cells.
    """
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
    """Return the numeric variables of an xarray Dataset as columns of equal length, with units in their titles."""
    import xarray as xr

    numbers = {str(name): array for name, array in variables.items() if array.dtype.kind in "iuf"}
    spread = xr.broadcast(*(xr.DataArray(array) for array in numbers.values()))
    units = {name: array.attrs.get("units", "") for name, array in numbers.items()}
    titles = [f"{name} [{unit}]" if unit and "[" not in name else name for name, unit in units.items()]
    return {title: array.values.ravel() for title, array in zip(titles, spread, strict=True)}
