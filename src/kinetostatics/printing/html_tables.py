"""Tables for notebooks: plain HTML without colours, so that they suit light and dark pages."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape


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
