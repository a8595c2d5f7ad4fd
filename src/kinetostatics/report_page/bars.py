"""Bar charts of contributions to the platform's displacement as SVG, without a plotting library."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np

from kinetostatics.layout.numbers import ANGLES, LENGTHS, NoiseFloor, NumberFormat
from kinetostatics.math.arrays import Array
from kinetostatics.reports.sources import parts_along, ranked, share, sources
from kinetostatics.results.result import Result

#: Largest number of bars; the remaining contributions are summed in one bar.
MOST = 14
#: Sizes [px]: width of the drawing, height of a row, width of the column of numbers, width of a letter.
WIDTH, ROW, NUMBERS, LETTER = 680, 20, 90, 6.4

#: Title of the bars: displacement, or rotation if the displacement is zero.
WORDS = ("displacement of {}, each along the whole displacement", "rotation, each about the axis of the whole rotation")


def contribution_bars(result: Result, noise: NoiseFloor) -> str:
    """Return bars of the contributions of weights and loads to the platform's displacement."""
    return _bars(list(result.contributions), list(result.contributions.values()), result, noise)


def source_bars(result: Result, noise: NoiseFloor) -> str:
    """Return bars of the contributions of elastic parts to the platform's displacement, the largest first."""
    names, twists = sources(result)
    return _bars([f"{name} ({kind})" for name, kind in names], list(twists), result, noise, sort=True)


def _bars(names: list[str], twists: list[Array], result: Result, noise: NoiseFloor, sort: bool = False) -> str:
    """Return one bar for each twist (6,), its component along the whole displacement; empty if the platform does not move."""
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
    words = WORDS[by].format(result.point_name)
    return _drawing(rows, form, float(sizes[by]), f"Parts of the {words}; together {form.with_unit(sizes[by])}")


def _drawing(rows: Sequence[tuple[str, float]], form: NumberFormat, whole: float, title: str) -> str:
    """Return the SVG of names and values [SI], with the value and its percentage of the whole at each bar."""
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
