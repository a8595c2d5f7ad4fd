"""CSV tables: a header of column names with optional units, such as ``z [mm]``, and rows with one cell per column."""

from __future__ import annotations

import csv
import os
import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass

from kinetostatics.exceptions import ArgumentError, near_names


@dataclass(frozen=True)
class CsvTable:
    """The contents of a CSV file.

    Attributes:
        place: file and line of the column names, ``FILE:LINE``.
        names: names of the columns, without units.
        rows: line number and cells of each row. A number without a unit has the column's unit appended: ``500mm``.
    """

    place: str
    names: tuple[str, ...]
    rows: tuple[tuple[int, tuple[str, ...]], ...]

    def where(self, line: int) -> str:
        return f"{self.place.rpartition(':')[0]}:{line}"


def read_csv(
    path: str | os.PathLike[str], example: str, allowed: Collection[str] | None = None, needed: Sequence[str] = (), least: int = 1
) -> CsvTable:
    """Read a CSV table.

    Args:
        example: description of a valid table, for the error if there are fewer than ``least`` rows.
        allowed: allowed names of columns; None: any.
        needed: names of required columns.

    Raises:
        ArgumentError: the file cannot be read or is not a table as required; the message names file and line.
    """
    name = os.fspath(path)
    try:
        with open(name, newline="", encoding="utf-8-sig") as file:
            lines = [(number, row) for number, row in enumerate(csv.reader(file), 1) if any(cell.strip() for cell in row)]
    except (OSError, UnicodeDecodeError, csv.Error, ValueError) as error:
        raise ArgumentError(f"{name} cannot be read: {getattr(error, 'strerror', None) or error}") from None
    if len(lines) <= least:
        raise ArgumentError(f"{name}: {example}")
    (first, titles), *rows = lines
    place = f"{name}:{first}"
    if len(titles) == 1 and (sign := re.search("[\t;]", titles[0])):
        reason = "tabs" if sign[0] == "\t" else "semicolons, and write 0.5, not 0,5"
        raise ArgumentError(f"{place}: separate columns by commas, not by {reason}")
    named = [column_name(title, place) for title in titles]
    names = tuple(column for column, _ in named)
    check_columns(place, names, allowed)
    if missing := [column for column in needed if column not in names]:
        raise ArgumentError(f"{place}: the column {missing[0]!r} is missing; needed are {', '.join(needed)}")
    for number, row in rows:
        if len(row) != len(names):
            raise ArgumentError(f"{name}:{number}: {len(row)} cells below {len(names)} titles")
    units = [unit for _, unit in named]
    return CsvTable(place, names, tuple((number, tuple(map(with_unit, map(str.strip, row), units))) for number, row in rows))


def column_name(title: str, place: str) -> tuple[str, str]:
    """Return the name and the unit in a column's title; the unit is empty if there is none."""
    match = re.fullmatch(r"\s*([^\[\]]*?)\s*(?:\[([^\[\]]+)\])?\s*", title)
    if match is None:
        raise ArgumentError(f"{place}: {title.strip()!r} is not a name, or a name with its unit: z [mm]")
    return match[1], match[2] or ""


def check_columns(place: str, names: Sequence[str], allowed: Collection[str] | None) -> None:
    """Check that all names of columns differ, are ``allowed`` (None: any), and have no unit in round brackets."""
    for name in names:
        bracketed = re.fullmatch(r"([^()]+?)\s*\(([^()]+)\)", name)
        if bracketed and name not in (allowed or ()):
            raise ArgumentError(f"{place}: {name!r}: units stand in square brackets, as in {bracketed[1]} [{bracketed[2]}]")
        if allowed is not None and name not in allowed:
            raise ArgumentError(f"{place}: there is no column {name!r}; {near_names(name, allowed)}")
        if name and names.count(name) > 1:
            raise ArgumentError(f"{place}: the column {name!r} is given twice")


def with_unit(cell: str, unit: str) -> str:
    """Return ``cell`` with a unit appended if it is a number alone."""
    try:
        float(cell)
    except ValueError:
        return cell
    return cell + unit
