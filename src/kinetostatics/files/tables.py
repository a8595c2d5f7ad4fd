"""Tables that people write as CSV: a line of titles, which may have units in brackets, such as ``z [mm]``, above the others."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable


def numbered_rows(lines: Iterable[str]) -> list[tuple[int, list[str]]]:
    """Return all rows that are not empty, each with the number of its line.

    Raises:
        csv.Error: it is no CSV.
    """
    return [(number, row) for number, row in enumerate(csv.reader(lines), 1) if any(cell.strip() for cell in row)]


def title_of(cell: str) -> tuple[str, str] | None:
    """Return the name and the unit, or "", in a title; None if it is none."""
    found = re.fullmatch(r"\s*([^\[\]]+?)\s*(?:\[(.+)\])?\s*", cell)
    return None if found is None else (found[1], found[2] or "")
