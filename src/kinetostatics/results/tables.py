"""Tables of results as CSV files: units in the titles, a row for each pose, empty cells where there are no numbers."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence

import numpy as np

from kinetostatics.files.writer import write_text
from kinetostatics.math.arrays import Array


def write_table(path: str, columns: Mapping[str, Sequence[str]]) -> None:
    """Write a CSV file of columns, by title; an existing file is replaced."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*columns.values(), strict=True))
    write_text(path, text.getvalue())


def cells(values: Array) -> list[str]:
    """Return numbers as texts of a column, empty if they are not finite."""
    return [f"{value:.15g}" if np.isfinite(value) else "" for value in np.ravel(values)]


def unit_of_coordinate(name: str) -> str:
    """Return the SI unit of a coordinate of the platform."""
    return "m" if name in ("x", "y", "z") else "rad"
