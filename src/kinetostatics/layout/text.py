"""Reports as text of fixed width, with or without colours."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Sequence

from kinetostatics.layout.blocks import Block, Column, Facts, ReportSection, Table, Text, Word
from kinetostatics.layout.colour import painted

#: Width at which lines are wrapped [letters].
WIDTH = 110


def report_text(title: Sequence[str], sections: Iterable[ReportSection], colour: bool = False) -> str:
    """Return a report as text.

    Args:
        title: parts of the first line; a :class:`Word` among them has a tone.
        sections: see :class:`ReportSection`.
        colour: whether to include colour codes.
    """
    first = next((k for k, piece in enumerate(title) if isinstance(piece, Word)), len(title))
    words = [_word(piece, colour) for piece in title[first:]]
    lines = [painted("title", "".join(title[:first]), colour) + "".join(words)]
    for section in sections:
        if section.title is not None:
            lines += ["", painted("title", section.title, colour)] if section.title else [""]
        lines += _indented(section.blocks, 0 if section.title == "" else 2, colour)
    return "\n".join(lines)


def _indented(blocks: Iterable[Block], indent: int, colour: bool) -> list[str]:
    return [f"{' ' * indent}{line}".rstrip() for block in blocks for line in block_lines(block, colour)]


def block_lines(block: Block, colour: bool = False) -> list[str]:
    """Return the lines of one part."""
    if isinstance(block, Table):
        return _wide(block, colour) if block.wide else _table(block.columns, colour)
    if isinstance(block, Facts):
        width = max((len(name) for name, _ in block.rows), default=0) + 2
        return [" " * block.indent + line for name, value in block.rows for line in _fact(name, value, width)]
    if isinstance(block, Text):
        return _sentence(block, colour)
    return list(block.lines)


def wrapped(text: str, first: str = "", width: int = WIDTH) -> list[str]:
    """Return a text in lines; those after the first are indented by the length of ``first``."""
    wrapper = textwrap.TextWrapper(width, first, " " * len(first), break_long_words=False, break_on_hyphens=False)
    return wrapper.wrap(text) or [first.rstrip()]


def _word(text: str, colour: bool) -> str:
    return painted(text.tone, text, colour) if isinstance(text, Word) else text


def _fact(name: str, value: object, width: int) -> list[str]:
    texts = [str(value)] if isinstance(value, str) or not isinstance(value, Sequence) else value
    lines = (wrapped(text, f"{'' if k else name:{width}}") for k, text in enumerate(texts))
    return [line for some in lines for line in some]


def _sentence(block: Text, colour: bool) -> list[str]:
    mark = " " * block.indent + {"warning": "! ", "item": "- ", "": ""}[block.kind]
    lead = block.lead or ""
    lines = wrapped(lead + block.text, mark, WIDTH - 2 if block.kind == "warning" else WIDTH)
    if block.kind == "warning":
        return [painted("warning", line, colour) for line in lines]
    if block.lead is not None:
        lines[0] = lines[0].replace(block.lead, _word(block.lead, colour), 1)
    return lines


def _table(columns: Sequence[Column], colour: bool) -> list[str]:
    texts = [[column.heading, *column.texts] for column in columns]
    widths = [max(map(len, cells)) for cells in texts]
    sides = ["<" if column.side == "l" else ">" for column in columns]
    lines = []
    for row in list(zip(*texts, strict=True))[not any(column.heading for column in columns) :]:
        cells = [
            f"{cell:{side}{width}}".replace(cell, _word(cell, colour), 1) if isinstance(cell, Word) else f"{cell:{side}{width}}"
            for cell, side, width in zip(row, sides, widths, strict=True)
        ]
        lines.append("  ".join(cells).rstrip())
    return lines


def _wide(table: Table, colour: bool) -> list[str]:
    """Return the lines of a table; one that is too wide continues below, with its first column repeated."""
    widths = [max(map(len, [column.heading, *column.texts])) + 2 for column in table.columns]
    blocks: list[list[int]] = [[]]
    for k in range(1, len(widths)):
        if blocks[-1] and widths[0] + sum(widths[j] for j in blocks[-1]) + widths[k] > WIDTH:
            blocks.append([])
        blocks[-1].append(k)
    found = [_table([table.columns[k] for k in (0, *block)], colour) for block in blocks]
    return [line for k, lines in enumerate(found) for line in ([""] * (k > 0) + lines)]
