"""Renderings of reports: text of fixed width with or without colours, and plain HTML for light and dark pages."""

from __future__ import annotations

import os
import re
import textwrap
from collections.abc import Callable, Iterable, Mapping, Sequence
from html import escape
from importlib.resources import files
from pathlib import Path
from typing import TextIO

from kinetostatics.arguments import path_name
from kinetostatics.exceptions import ArgumentError
from kinetostatics.layout.blocks import Block, Column, Facts, ReportSection, Table, Text, Word
from kinetostatics.output_files import write_text

#: Width at which lines are wrapped [letters].
WIDTH = 110
#: Codes of Select Graphic Rendition (ECMA-48) by meaning.
CODES = {"title": "1", "warning": "33", "error": "1;31", "good": "32", "doubtful": "33", "bad": "31"}
_SIDES = {"l": "left", "r": "right"}


# ---- text ------------------------------------------------------------------------------------------------------------


def report_text(title: Sequence[str], sections: Iterable[ReportSection], colour: bool = False) -> str:
    """Return a report as text; ``title``: parts of its first line, plain texts before words with a tone."""
    first = next((k for k, piece in enumerate(title) if isinstance(piece, Word)), len(title))
    words = [_word(piece, colour) for piece in title[first:]]
    lines = [painted("title", "".join(title[:first]), colour) + "".join(words)]
    for section in sections:
        if section.title is not None:
            lines += ["", painted("title", section.title, colour)] if section.title else [""]
        indent = "" if section.title == "" else "  "
        lines += [f"{indent}{line}".rstrip() for block in section.blocks for line in block_lines(block, colour)]
    return "\n".join(lines)


def block_lines(block: Block, colour: bool = False) -> list[str]:
    if isinstance(block, Table):
        return _wide(block, colour) if block.wide else _rows(block.columns, colour)
    if isinstance(block, Facts):
        width = max((len(name) for name, _ in block.rows), default=0) + 2
        return [" " * block.indent + line for name, value in block.rows for line in _fact(name, value, width)]
    if isinstance(block, Text):
        return _sentence(block, colour)
    return list(block.lines)


def wrapped(text: str, first: str = "", width: int = WIDTH) -> list[str]:
    """Return a text as wrapped lines: the first one begins with ``first``, the others are indented by its length."""
    wrapper = textwrap.TextWrapper(width, first, " " * len(first), break_long_words=False, break_on_hyphens=False)
    return wrapper.wrap(text) or [first.rstrip()]


def _word(text: str, colour: bool) -> str:
    return painted(text.tone, text, colour) if isinstance(text, Word) else text


def _texts(value: object) -> Sequence[str]:
    return [str(value)] if isinstance(value, str) or not isinstance(value, Sequence) else value


def _fact(name: str, value: object, width: int) -> list[str]:
    lines = []
    for k, text in enumerate(_texts(value)):
        lines += wrapped(text, f"{name if k == 0 else '':{width}}")
    return lines


def _sentence(block: Text, colour: bool) -> list[str]:
    mark = " " * block.indent + {"warning": "! ", "item": "- ", "": ""}[block.kind]
    lines = wrapped((block.lead or "") + block.text, mark, WIDTH - 2 if block.kind == "warning" else WIDTH)
    if block.kind == "warning":
        return [painted("warning", line, colour) for line in lines]
    if block.lead is not None:
        lines[0] = lines[0].replace(block.lead, _word(block.lead, colour), 1)
    return lines


def _rows(columns: Sequence[Column], colour: bool) -> list[str]:
    texts = [[column.heading, *column.texts] for column in columns]
    widths = [max(map(len, cells)) for cells in texts]
    signs = ["<" if column.side == "l" else ">" for column in columns]
    headings, *rows = zip(*texts, strict=True)
    lines = []
    for row in [headings, *rows] if any(headings) else rows:
        cells = []
        for cell, sign, width in zip(row, signs, widths, strict=True):
            cells.append(f"{cell:{sign}{width}}".replace(cell, _word(cell, colour), 1))
        lines.append("  ".join(cells).rstrip())
    return lines


def _wide(table: Table, colour: bool) -> list[str]:
    """Return a table as lines; columns that do not fit are written below, after a copy of the first column."""
    widths = [max(map(len, [column.heading, *column.texts])) + 2 for column in table.columns]
    blocks: list[list[int]] = [[]]
    for k in range(1, len(widths)):
        if blocks[-1] and widths[0] + sum(widths[j] for j in blocks[-1]) + widths[k] > WIDTH:
            blocks.append([])
        blocks[-1].append(k)
    lines = []
    for k, block in enumerate(blocks):
        if k > 0:
            lines.append("")
        lines += _rows([table.columns[column] for column in (0, *block)], colour)
    return lines


# ---- colour on terminals ---------------------------------------------------------------------------------------------


def use_colour(stream: TextIO | None) -> bool:
    """Whether to write colours to a stream: only if it is a terminal that supports them.

    The environment variables ``NO_COLOR`` and ``FORCE_COLOR``, if not empty, disable and enable colours (https://no-color.org,
    https://force-color.org).
    """
    if os.environ.get("NO_COLOR"):
        return False
    if os.environ.get("FORCE_COLOR"):
        return True
    return os.environ.get("TERM") != "dumb" and stream is not None and bool(stream.isatty())


def painted(meaning: str, text: str, colour: bool = True) -> str:
    """Return a text with the colour codes of a meaning, a key of :data:`CODES`; they follow the indentation."""
    bare = text.lstrip()
    return f"{text[: len(text) - len(bare)]}\033[{CODES[meaning]}m{bare}\033[0m" if colour and bare else text


# ---- HTML ------------------------------------------------------------------------------------------------------------


def html_path(path: str | os.PathLike[str]) -> str:
    """Return the path of an HTML file after a check.

    Raises:
        ArgumentError: the extension is neither ``.html`` nor ``.htm``.
    """
    file = path_name("path", path)
    if Path(file).suffix.lower() not in (".html", ".htm"):
        right = f"{Path(file).stem.strip('.') or 'page'}.html"
        raise ArgumentError(f"{file}: the page is an HTML file, which a browser prints as PDF; name it {right!r}")
    return file


def save_page(path: str | os.PathLike[str], page: Callable[[], str]) -> None:
    """Write an HTML page; ``page`` is called after the path has been checked.

    Raises:
        ArgumentError: the extension is neither ``.html`` nor ``.htm``, or the file cannot be written.
    """
    file = html_path(path)
    write_text(file, page())


def asset(package: str, name: str) -> str:
    """Return a text of the folder ``assets`` of a package."""
    return (files(package) / "assets" / name).read_text(encoding="utf-8")


def filled(template: str, texts: Mapping[str, object], markup: Mapping[str, str]) -> str:
    """Return a template with each ``{{name}}`` replaced by one of the ``texts``, escaped, or of the ``markup``, as it is."""
    pieces = {**{name: escape(str(text)) for name, text in texts.items()}, **markup}
    return re.sub(r"\{\{(\w+)\}\}", lambda match: pieces[match[1]], template)


def report_html(title: str, sections: Iterable[ReportSection]) -> str:
    """Return a report as HTML; all texts are escaped."""
    parts = [f"<p><strong>{escape(title)}</strong></p>"]
    for section in sections:
        if section.title:
            parts.append(f"<h3>{escape(section.title)}</h3>")
        parts += map(block_html, section.blocks)
    return "\n".join(filter(None, parts))


def block_html(block: Block) -> str:
    if isinstance(block, Table):
        return _table_html(block.columns)
    if isinstance(block, Facts):
        rows = [(name, "\n".join(_texts(value))) for name, value in block.rows]
        return _table_html(Table.of_rows(("", ""), rows, "ll").columns) if rows else ""
    if isinstance(block, Text):
        begin = '<p class="warning">! ' if block.kind == "warning" else "<p>"
        return f"{begin}{escape((block.lead or '') + block.text)}</p>"
    return f"<pre>{escape(chr(10).join(block.lines))}</pre>"


def _table_html(columns: Sequence[Column]) -> str:
    headings = [column.heading for column in columns]
    head = f"<thead><tr>{_cells('th', columns, headings)}</tr></thead>\n" if any(headings) else ""
    rows = zip(*(column.texts for column in columns), strict=True)
    body = "".join(f"<tr>{_cells('td', columns, row)}</tr>\n" for row in rows)
    return f"<table>\n{head}<tbody>\n{body}</tbody>\n</table>"


def _cells(tag: str, columns: Sequence[Column], texts: Sequence[str]) -> str:
    return "".join(
        f'<{tag} style="text-align: {_SIDES[column.side]}">{escape(text).replace(chr(10), "<br>")}</{tag}>'
        for column, text in zip(columns, texts, strict=True)
    )
