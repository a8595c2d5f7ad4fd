"""Heading and legend of a picture as SVG images, for viewers without a page of their own."""

from __future__ import annotations

import math
from collections.abc import Iterable
from html import escape

from kinetostatics.viewer.description import HIDDEN, RAMP
from kinetostatics.viewer.still import Still

#: Size of the picture [pixels] for which the images are made; in wider pictures they are centred.
WIDTH, HEIGHT = 1200, 900
#: Height of a line, and width of a letter of its text [pixels].
LINE, LETTER = 24, 9.2
INK, PALE = "#20262e", "#4a5462"
#: Largest number of lines beside the colour scale; further lines are omitted.
MOST_LINES = 4


def heading(still: Still) -> tuple[str, int]:
    """Return title, pose, loads and notes as an image of the picture's width, and its height [pixels]."""
    scene = still.scene
    facts = [fact for fact in scene.facts.lines(0) if fact != ("status", "OK")]
    lines = _filled(facts, WIDTH - 40)
    if scene.unloaded:
        lines += _filled([("", note) for note in scene.notes], WIDTH - 40)
    height = 44 + LINE * len(lines)
    parts = [f'<text x="{WIDTH / 2}" y="30" font-size="25" font-weight="700" text-anchor="middle">{escape(scene.title)}</text>']
    for k, line in enumerate(lines):
        words = "&#160;&#160; ".join(f'<tspan font-weight="600">{escape(name)}</tspan> {escape(text)}' for name, text in line)
        parts.append(f'<text x="{WIDTH / 2}" y="{54 + LINE * k}" text-anchor="middle">{words}</text>')
    return image(parts, WIDTH, height), height


def legend(still: Still, square: float) -> tuple[str, int]:
    """Return an image of the colour scale and the values of the initially visible arrows, and its height [pixels].

    Args:
        still: the picture.
        square: side of a square of the floor [m].
    """
    scene, unit = still.scene, still.scene.facts.displacement
    groups: dict[str, list[str]] = {}
    colours = {}
    for item in still.arrows:
        if item.arrow.group not in HIDDEN:
            words = item.arrow.label + (f" {number(item.value)} {item.arrow.unit}" if item.arrow.unit else "")
            groups.setdefault(item.arrow.group, []).append(words)
            colours[item.arrow.group] = item.colour
    rows = []
    for group, items in groups.items():
        filled = _filled([(group, items[0]), *(("", words) for words in items[1:])], 728)
        rows += [(line, colours[group] if k == 0 else "", "," if line is not filled[-1] else "") for k, line in enumerate(filled)]
    if len(rows) > MOST_LINES:
        line, colour, _ = rows[MOST_LINES - 1]
        rows[MOST_LINES - 1 :] = [(line, colour, ", …")]
    height = 26 + LINE * max(3, len(rows) + 1)
    parts = []
    if scene.unloaded or not still.largest[0]:
        words = "without loads" if scene.unloaded else "rigid: nothing deforms"
        parts.append(f'<text x="40" y="30" font-weight="600">{words}</text>')
    else:
        stops = "".join(f'<stop offset="{k / (len(RAMP) - 1)}" stop-color="{colour}"/>' for k, colour in enumerate(RAMP))
        words = f"deflection [{unit.unit}], largest {number(still.largest[0] / unit.factor)}"
        parts += [
            f'<defs><linearGradient id="ramp">{stops}</linearGradient></defs>',
            f'<text x="40" y="30" font-weight="600">{words}</text>',
            '<rect x="40" y="42" width="340" height="16" fill="url(#ramp)"/>',
        ]
        for part in (0, 0.25, 0.5, 0.75, 1):
            value = number(part * still.high / unit.factor)
            parts.append(f'<text x="{40 + 340 * part}" y="78" font-size="16" text-anchor="middle">{value}</text>')
    for k, (line, colour, more) in enumerate(rows):
        y = 30 + LINE * k
        if colour:
            parts.append(f'<rect x="450" y="{y - 12}" width="13" height="13" rx="2" fill="{colour}"/>')
        words = ", ".join(
            f'<tspan font-weight="600">{escape(name)}</tspan> {escape(text)}' if name else escape(text) for name, text in line
        )
        parts.append(f'<text x="472" y="{y}">{words}{more}</text>')
    about = "" if scene.unloaded or not still.largest[0] else f"drawn × {number(scene.exaggeration)}; pale: at rest; "
    last = f"{about}squares of the floor: {1e3 * square:g} mm"
    parts.append(f'<text x="472" y="{30 + LINE * max(2, len(rows))}" fill="{PALE}" font-size="16">{last}</text>')
    return image(parts, WIDTH, height), height


def image(parts: Iterable[str], width: int, height: int) -> str:
    """Return an SVG image of a size [pixels]."""
    # An almost transparent white background avoids black edges of letters.
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}" '
        f'font-family="system-ui, sans-serif" font-size="18" fill="{INK}" '
        f'stroke="#fff" stroke-width="5" stroke-linejoin="round" paint-order="stroke">'
        f'<rect width="{width}" height="{height}" fill-opacity="0.02" fill="#fff" stroke="none"/>{"".join(parts)}</svg>'
    )


def number(value: float) -> str:
    """Return a number with three digits, as in the page."""
    if not math.isfinite(value):
        return "–"
    size = abs(value)
    text = "0" if size < 1e-5 else f"{value:.2e}" if size >= 1e6 else f"{value:.0f}" if size >= 100 else f"{value:#.3g}"
    return text.removesuffix(".").replace("-", "−")


def _filled(items: Iterable[tuple[str, str]], width: float) -> list[list[tuple[str, str]]]:
    """Return names and texts distributed over lines of a width [pixels]."""
    lines: list[list[tuple[str, str]]] = []
    left = 0.0
    for name, text in items:
        taken = LETTER * (len(name) + len(text) + 3)
        if taken > left:
            lines.append([])
            left = width
        lines[-1].append((name, text))
        left -= taken
    return lines
