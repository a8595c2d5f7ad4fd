"""Reports as plain HTML without colours, for light and dark pages."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from html import escape
from pathlib import Path

from kinetostatics.arguments import path_name
from kinetostatics.exceptions import ArgumentError
from kinetostatics.layout.blocks import Block, Column, Facts, ReportSection, Table, Text

_SIDES = {"l": "left", "r": "right"}


def html_path(path: str | os.PathLike[str], what: str) -> str:
    """Return the path of an HTML file.

    Args:
        path: path of the file.
        what: name of the page for the message, "a report".

    Raises:
        ArgumentError: the extension is not that of an HTML file.
    """
    file = path_name("path", path)
    if Path(file).suffix.lower() not in (".html", ".htm"):
        right = Path(file).with_suffix(".html").name
        raise ArgumentError(f"{file}: {what} is an HTML page, which a browser prints as PDF; name it {right!r}")
    return file


def report_html(title: str, sections: Iterable[ReportSection], level: int = 3) -> str:
    """Return a report as HTML with headings of a ``level``; all texts are escaped."""
    parts = [f"<p><strong>{escape(title)}</strong></p>"]
    for section in sections:
        if section.title:
            parts.append(f"<h{level}>{escape(section.title)}</h{level}>")
        parts += map(block_html, section.blocks)
    return "\n".join(filter(None, parts))


def block_html(block: Block) -> str:
    """Return one part as HTML."""
    if isinstance(block, Table):
        return _table(block.columns)
    if isinstance(block, Facts):
        rows = [
            (name, "\n".join([str(value)] if isinstance(value, str) or not isinstance(value, Sequence) else value))
            for name, value in block.rows
        ]
        return html_table("", ("", ""), rows, "ll") if rows else ""
    if isinstance(block, Text):
        begin = '<p class="warning">! ' if block.kind == "warning" else "<p>"
        return f"{begin}{escape((block.lead or '') + block.text)}</p>"
    return f"<pre>{escape(chr(10).join(block.lines))}</pre>"


def html_table(title: str, header: Sequence[str], rows: Iterable[Sequence[str]], align: str = "") -> str:
    """Return a table. All texts are escaped.

    Args:
        title: caption; empty for none.
        header: titles of the columns; all empty for none.
        rows: cells.
        align: ``l`` or ``r`` for each column; default: first column left, others right.
    """
    align = align or "l" + "r" * (len(header) - 1)
    columns = [Column(name, cells, side) for name, cells, side in zip(header, zip(*rows, strict=True), align, strict=False)]
    return _table(columns or [Column(name, []) for name in header], title)


def _table(columns: Sequence[Column], title: str = "") -> str:
    parts = ["<table>"]
    if title:
        parts.append(f'<caption style="caption-side: top; text-align: left; white-space: nowrap">{escape(title)}</caption>')
    if any(column.heading for column in columns):
        parts.append(f"<thead><tr>{_cells('th', columns, [column.heading for column in columns])}</tr></thead>")
    parts.append("<tbody>")
    parts += [f"<tr>{_cells('td', columns, row)}</tr>" for row in zip(*(column.texts for column in columns), strict=True)]
    return "\n".join([*parts, "</tbody>", "</table>"])


def _cells(tag: str, columns: Sequence[Column], texts: Sequence[str]) -> str:
    return "".join(
        f'<{tag} style="text-align: {_SIDES[column.side]}">{escape(text).replace(chr(10), "<br>")}</{tag}>'
        for column, text in zip(columns, texts, strict=True)
    )
