"""Bar charts of contributions to the platform's displacement as SVG, without a plotting library."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np

from kinetostatics.layout.numbers import ANGLES, LENGTHS, NoiseFloor, NumberFormat
from kinetostatics.math.arrays import Array
from kinetostatics.reports.sources import parts_along, ranked, share, sources
from kinetostatics.results.result import Result

#: Bars at most; what is behind them is one bar.
MOST = 14
#: Sizes of the drawing [px]: its width, a row, columns of names and of numbers, and the width of a letter.
WIDTH, ROW, NUMBERS, LETTER = 680, 20, 90, 6.4

#: What is ranked: the displacement, or the rotation where the point stays.
WORDS = ("displacement of {}, each along the whole displacement", "rotation, each about the axis of the whole rotation")


def contribution_bars(result: Result, noise: NoiseFloor) -> str:
    """Return bars of the parts of the platform's motion by weight and load."""
    return _bars(list(result.contributions), list(result.contributions.values()), result, noise)


def source_bars(result: Result, noise: NoiseFloor) -> str:
    """Return bars of the parts of the platform's motion by elastic part, the largest first."""
    names, twists = sources(result)
    return _bars([f"{name} ({kind})" for name, kind in names], list(twists), result, noise, sort=True)


def _bars(names: list[str], twists: list[Array], result: Result, noise: NoiseFloor, sort: bool = False) -> str:
    """Return a bar of the part of the motion of each twist (6,); nothing where nothing moves."""
    found = parts_along(np.reshape(twists, (-1, 6)), result.twist, noise)
    if found is None:
        return ""
    parts, sizes, by = found
    values = parts[:, by]
    order = ranked(values) if sort else list(range(len(values)))
    shown, rest = (order, []) if len(order) <= MOST + 1 else (order[:MOST], order[MOST:])
    rows = [(names[k], float(values[k])) for k in shown]
    if rest:
        rows.append((f"{len(rest)} others", float(values[rest].sum())))
    form = NumberFormat.of(values, (LENGTHS, ANGLES)[by], (noise.displacement, noise.rotation)[by])
    said = WORDS[by].format(result.point_name)
    return _drawing(rows, form, float(sizes[by]), f"Parts of the {said}; together {form.with_unit(sizes[by])}")


def _drawing(rows: Sequence[tuple[str, float]], form: NumberFormat, whole: float, title: str) -> str:
    """Return the SVG of names and values [SI], with the number and its part of the whole beside each bar."""
    left = min(260.0, 12 + LETTER * max(len(name) for name, _ in rows))
    low, high = min(0.0, *(value for _, value in rows)), max(0.0, *(value for _, value in rows))
    per_unit = (WIDTH - left - 1.8 * NUMBERS) / (high - low)
    zero = left - low * per_unit
    height = ROW * len(rows) + 30
    parts = [
        f'<svg class="bars" viewBox="0 0 {WIDTH} {height}" role="img" aria-label="{escape(title)}">',
        f'<text class="title" x="0" y="14">{escape(title)}</text>',
    ]
    for k, (name, value) in enumerate(rows):
        y = 26 + ROW * k
        begin, length = zero + min(0.0, value) * per_unit, abs(value) * per_unit
        colour = "less" if value < 0 else "more"
        parts += [
            f'<text class="name" x="{left - 6:.1f}" y="{y + 13}" text-anchor="end">{escape(name)}</text>',
            f'<rect class="{colour}" x="{begin:.2f}" y="{y + 3}" width="{length:.2f}" height="{ROW - 6}"/>',
            f'<text x="{zero + max(0.0, value) * per_unit + 6:.1f}" y="{y + 13}">{escape(form.with_unit(value))}'
            f" ({share(value, whole):.1f} %)</text>",
        ]
    parts.append(f'<line x1="{zero:.2f}" x2="{zero:.2f}" y1="24" y2="{height - 2}"/></svg>')
    return "\n".join(parts)
