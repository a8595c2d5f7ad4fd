"""Tables that people write as CSV: a line of titles, which may have units in brackets, such as ``z [mm]``, above the others."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable, Sequence

from kinetostatics.exceptions import ArgumentError


def numbered_rows(lines: Iterable[str]) -> list[tuple[int, list[str]]]:
    """Return all rows that are not empty, each with the number of its line.

    Raises:
        csv.Error: it is no CSV.
    """
    return [(number, row) for number, row in enumerate(csv.reader(lines), 1) if any(cell.strip() for cell in row)]


def table_rows(path: str, what: str) -> list[tuple[int, list[str]]]:
    """Return line numbers and cells of a CSV file: titles, and rows of as many cells.

    Raises:
        ArgumentError: there are none; the message says ``what`` the table is like.
    """
    try:
        with open(path, newline="", encoding="utf-8-sig") as file:
            rows = numbered_rows(file)
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise ArgumentError(f"{path} cannot be read: {getattr(error, 'strerror', None) or error}") from None
    if len(rows) < 2:
        raise ArgumentError(f"{path}: {what}")
    titles = rows[0][1]
    check_separators(f"{path}:{rows[0][0]}", titles)
    for number, row in rows[1:]:
        if len(row) != len(titles):
            raise ArgumentError(f"{path}:{number}: {len(row)} cells below {len(titles)} titles")
    return rows


def check_separators(where: str, titles: Sequence[str]) -> None:
    """Complain of a line of titles that has semicolons or tabs where commas belong.

    Raises:
        ArgumentError: it has.
    """
    if len(titles) == 1 and "\t" in titles[0]:
        raise ArgumentError(f"{where}: separate columns by commas, not by tabs")
    if len(titles) == 1 and ";" in titles[0]:
        raise ArgumentError(f"{where}: separate columns by commas, not by semicolons, and write 0.5, not 0,5")


def check_brackets(where: str, titles: Iterable[str], known: Iterable[str] = ()) -> None:
    """Complain of a title that is not known and has its unit in round brackets.

    Raises:
        ArgumentError: there is one.
    """
    for title in [title for title in titles if title not in set(known)]:
        if found := re.fullmatch(r"\s*([^()]+?)\s*\(([^()]+)\)\s*", title):
            raise ArgumentError(f"{where}: {title.strip()!r}: units stand in square brackets, as in {found[1]} [{found[2]}]")


def title_of(cell: str) -> tuple[str, str] | None:
    """Return the name and the unit, or "", in a title; None if it is none."""
    found = re.fullmatch(r"\s*([^\[\]]+?)\s*(?:\[(.+)\])?\s*", cell)
    return None if found is None else (found[1], found[2] or "")
