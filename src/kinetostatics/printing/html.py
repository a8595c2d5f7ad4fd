"""Tables and reports as plain HTML without colours of its own, which suits light and dark pages.

What ``print`` shows in columns becomes headings, tables and sentences of a page.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator, Sequence
from html import escape
from itertools import groupby
from pathlib import Path

from kinetostatics.argument_checks import path_name
from kinetostatics.exceptions import ArgumentError

#: What a cell of a column of numbers begins with, or is.
_NUMBER = re.compile(r"[-−+]?\d|[–∞]$|-∞$|rigid$")
#: What only drawings of chains have in a line.
_DRAWN = "—"


def html_path(path: str | os.PathLike[str], what: str) -> str:
    """Return the name of the file that a page is written to.

    Args:
        path: of the file.
        what: the page is, "a report".

    Raises:
        ArgumentError: its ending promises something else than a page.
    """
    file = path_name("path", path)
    if Path(file).suffix.lower() not in (".html", ".htm"):
        right = Path(file).with_suffix(".html").name
        raise ArgumentError(f"{file}: {what} is an HTML page, which a browser prints as PDF; name it {right!r}")
    return file


def html_table(title: str, header: Sequence[str], rows: Iterable[Sequence[str]], align: str = "") -> str:
    """Return a table. All texts are escaped.

    Args:
        title: stands above it; empty for none.
        header: titles of the columns; all empty for none.
        rows: cells.
        align: a letter for each column, ``l`` or ``r``; default: the first to the left, the others to the right.
    """
    align = align or "l" + "r" * (len(header) - 1)
    parts = ["<table>"]
    if title:
        parts.append(f'<caption style="caption-side: top; text-align: left; white-space: nowrap">{escape(title)}</caption>')
    if any(header):
        parts.append(f"<thead><tr>{_cells('th', header, align)}</tr></thead>")
    parts.append("<tbody>")
    parts += [f"<tr>{_cells('td', row, align)}</tr>" for row in rows]
    return "\n".join([*parts, "</tbody>", "</table>"])


def _cells(tag: str, texts: Sequence[str], align: str) -> str:
    sides = {"l": "left", "r": "right"}
    return "".join(f'<{tag} style="text-align: {sides[k]}">{escape(text)}</{tag}>' for k, text in zip(align, texts, strict=False))


def html_report(text: str, level: int = 3) -> str:
    """Return a report as HTML. All its text is escaped.

    Args:
        text: a report of the package: a first line, and sections with a title and indented lines.
        level: of the headings of its sections.
    """
    parts: list[str] = []
    for number, (title, lines) in enumerate(_sections(text)):
        if number == 0:
            parts.append(f"<p><strong>{escape(title)}</strong></p>")
        elif any(lines):
            parts.append(f"<h{level}>{escape(title)}</h{level}>")
        else:
            parts.append(f"<p>{escape(title)}</p>")
        if any(_DRAWN in line for line in lines):
            drawn = escape("\n".join(lines)).strip("\n")
            parts.append(f"<pre>{drawn}</pre>")
        else:
            parts += _blocks(lines)
    return "\n".join(parts)


def _sections(text: str) -> Iterator[tuple[str, list[str]]]:
    """Yield titles and lines of the sections of a report, without the lines' common indent."""
    title, lines = "", list[str]()
    for line in text.splitlines():
        if line and not line.startswith(" "):
            if title:
                yield title, lines
            title, lines = line, []
        else:
            lines.append(line[2:])
    yield title, lines


def _blocks(lines: Sequence[str]) -> Iterator[str]:
    """Yield tables, warnings and sentences."""
    for kind, found in groupby(lines, _kind):
        some = list(found)
        if kind == "table":
            yield _table(some)
        elif kind:
            begin = '<p class="warning">' if kind == "warning" else "<p>"
            yield begin + "<br>".join(map(escape, some)) + "</p>"


def _kind(line: str) -> str:
    """Return what a line is part of; of nothing if it is empty."""
    if line.startswith("! "):
        return "warning"
    if re.search(r"\S {2,}\S", line) or line.startswith("   "):
        return "table"
    return "sentence" if line else ""


def _table(lines: Sequence[str]) -> str:
    """Return the table that lines in columns are, which are at least two spaces apart."""
    width = max(map(len, lines))
    padded = [line.ljust(width) for line in lines]
    empty = "".join(" " if all(line[k] == " " for line in padded) else "x" for k in range(width))
    starts = [0, *(found.end() for found in re.finditer(r" {2,}", empty) if 0 < found.start() and found.end() < width)]
    rows = [[line[a:b].strip() for a, b in zip(starts, [*starts[1:], width], strict=True)] for line in padded]
    columns = [[row[k] for row in rows] for k in range(len(starts))]
    numbers = [any(cells[1:]) and all(_NUMBER.match(cell) for cell in cells[1:] if cell) for cells in columns]
    titled = any(number and cells[0] and not _NUMBER.match(cells[0]) for number, cells in zip(numbers, columns, strict=True))
    if len(columns) == 2 and any(" " in cell for cell in columns[1]):  # names and values with units: no titles
        titled = False
    align = "".join("r" if number else "l" for number in numbers)
    header = rows.pop(0) if titled else [""] * len(starts)
    return html_table("", header, rows, align)
