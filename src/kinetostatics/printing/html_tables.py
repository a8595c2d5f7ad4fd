"""Tables for notebooks: plain HTML without colours, so that they suit light and dark pages."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape


def html_table(title: str, header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table; the first column is to the left, the others to the right. All texts are escaped.

    Args:
        title: stands above it; empty for none.
        header: titles of the columns; all empty for none.
        rows: cells.
    """
    parts = ["<table>"]
    if title:
        parts.append(f'<caption style="caption-side: top; text-align: left; white-space: nowrap">{escape(title)}</caption>')
    if any(header):
        parts.append(f"<thead><tr>{_cells('th', header)}</tr></thead>")
    parts.append("<tbody>")
    parts += [f"<tr>{_cells('td', row)}</tr>" for row in rows]
    return "\n".join([*parts, "</tbody>", "</table>"])


def _cells(tag: str, texts: Sequence[str]) -> str:
    sides = ["left", *["right"] * len(texts)]
    return "".join(f'<{tag} style="text-align: {side}">{escape(text)}</{tag}>' for side, text in zip(sides, texts, strict=False))
