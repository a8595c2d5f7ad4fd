"""Style of all figures, and their files."""

from __future__ import annotations

import functools
import os
import textwrap
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import ParamSpec, TypeVar

import matplotlib as mpl
from matplotlib import pyplot as plt
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axis import XAxis, YAxis
from matplotlib.figure import Figure, SubFigure
from matplotlib.ticker import MaxNLocator
from mpl_toolkits.mplot3d import Axes3D

from kinetostatics.exceptions import ArgumentError
from kinetostatics.plot.display_units import typeset
from kinetostatics.plot.selection import ShownAxis

P = ParamSpec("P")
R = TypeVar("R")

#: Width of a column of a journal [inch].
ONE_COLUMN = 3.46

#: Luminance rises along it, so that it reads in grey; made for the colour-blind.
COLOURS = "cividis"

#: Matplotlib's settings of every figure.
STYLE: dict[str, object] = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 8,
    "axes.labelsize": 8,
    "axes.titlesize": 8,
    "figure.titlesize": 8,
    "xtick.labelsize": 7,
    "ytick.labelsize": 7,
    "legend.fontsize": 7,
    "legend.frameon": False,
    "axes.linewidth": 0.6,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "lines.linewidth": 1.2,
    "lines.markersize": 3.5,
    "hatch.linewidth": 0.5,
    "figure.dpi": 150,
    "savefig.dpi": 300,
    "pdf.fonttype": 42,  # letters stay letters
    "svg.hashsalt": "kinetostatics",  # the same figure is the same file
}

#: Letters of a title beside an inch of the figure, of which a colour bar takes a part; and a space at which no line ends.
LETTERS, NO_BREAK = 14.5, "\N{NO-BREAK SPACE}"

#: Letters along a colour bar for an inch of the figure's height.
BAR = 12.2

#: Panels in a row.
ROW = 3

#: Label of figures that are made here, of which nobody else has chosen the size.
OWN_PAGE = "kinetostatics"

#: Dashes and markers of lines, which must differ without colour.
DASHES = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)), (0, (8, 2)))
MARKERS = ("o", "s", "^", "D", "v", "x")

#: What files figures may be written to, and what else goes into them; no dates, so that the same figure is the same file.
_FORMATS: dict[str, dict[str, None]] = {
    ".pdf": {"CreationDate": None},
    ".svg": {"Date": None},
    ".png": {},
}


def styled(draw: Callable[P, R]) -> Callable[P, R]:
    """Decorate a function in which Matplotlib draws in :data:`STYLE`."""

    @functools.wraps(draw)
    def drawn(*args: P.args, **kwargs: P.kwargs) -> R:
        with mpl.rc_context(mpl.RcParams(STYLE)):
            return draw(*args, **kwargs)

    return drawn


def new_panels(count: int, width: float, height: float, projection: str | None = None) -> list[Axes]:
    """Return axes of a width and height beside one another, :data:`ROW` in a row, on a figure of their own.

    For functions that are :func:`styled`; ``projection`` is one of Matplotlib's.
    """
    columns = min(count, ROW)
    rows = -(-count // columns)
    figure = plt.figure(figsize=(columns * width, rows * height), layout="constrained", label=OWN_PAGE)
    return [figure.add_subplot(rows, columns, k + 1, projection=projection) for k in range(count)]  # type: ignore[call-overload]


def new_axes(width: float, height: float, projection: str | None = None) -> Axes:
    """Return axes on a figure of their own."""
    return new_panels(1, width, height, projection)[0]


def wrapped(text: str, figure: Figure) -> str:
    """Return the name of a colour bar in lines that are not longer than the bar."""
    return textwrap.fill(text, max(20, int(BAR * figure.get_figheight())))


def solid_axes(ax: Axes | None, height: float, what: str) -> Axes3D:
    """Return axes in three dimensions: those given, or new ones one column wide.

    Raises:
        ArgumentError: those given have two.
    """
    found = new_axes(ONE_COLUMN, height * ONE_COLUMN, projection="3d") if ax is None else ax
    if not isinstance(found, Axes3D):
        raise ArgumentError(f"{what} axes made with projection='3d'")
    return found


def make_room(ax: Axes3D, labels: Sequence[str]) -> None:
    """Label axes in three dimensions, fill their rectangle, and draw what is listed later over what is listed earlier."""
    ax.computed_zorder = False
    ax.set_box_aspect((4, 4, 3), zoom=1.1)
    for axis, text in zip((ax.xaxis, ax.yaxis, ax.zaxis), labels, strict=True):
        axis.set_label_text(text)
        axis.labelpad = -1
        axis.set_tick_params(pad=1 if axis is ax.zaxis else -1)
        axis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
        if axis is not ax.zaxis:  # the last number of x is beside the first of y
            for tick in axis.get_major_ticks(len(axis.get_majorticklocs())):
                tick.label1.set_horizontalalignment("right" if axis is ax.xaxis else "left")
        axis.pane.set(facecolor="0.97", edgecolor="0.6")
        axis._axinfo["grid"].update(color="0.85", linewidth=0.4)


def figure_of(ax: Axes) -> Figure:
    """Return the figure that axes are on."""
    figure = ax.figure
    while isinstance(figure, SubFigure):
        figure = figure.figure
    if figure is None:
        raise ArgumentError("these axes are on no figure any more")
    return figure


def title_of(ax: Axes, text: str) -> str:
    """Return a title, parts between commas, in lines for which the figure has room; a longer one would make it wider."""
    parts = typeset(text).replace(", ", ",\0").replace(" ", NO_BREAK).replace("\0", " ")
    width = int(figure_of(ax).get_figwidth() * LETTERS)
    return textwrap.fill(parts, width, break_long_words=False, break_on_hyphens=False).replace(NO_BREAK, " ")


def legend_below(figure: Figure, handles: Sequence[Artist]) -> None:
    """Put a legend below everything else, in columns of equal height, as many as the page is wide for.

    A figure of one of our own pages (:func:`new_axes`) grows by what the legend needs beyond two rows.
    """
    if not handles:
        return
    longest = max(len(str(handle.get_label())) for handle in handles)
    points = 4.2 * longest + 38  # of letters; of the patch and the gaps
    rows = -(-len(handles) // max(1, int(72 * figure.get_figwidth() / points)))
    # an empty line above: labels of axes in three dimensions reach below what Matplotlib makes room for
    title = " " if any(isinstance(ax, Axes3D) for ax in figure.axes) else None
    figure.legend(handles=list(handles), loc="outside lower center", ncols=-(-len(handles) // rows), title=title)
    if figure.get_label() == OWN_PAGE and rows > 2:
        figure.set_figheight(figure.get_figheight() + (rows - 2) * 11 / 72)


def name_ticks(axis: XAxis | YAxis, shown: ShownAxis) -> None:
    """Put ticks at round values of a coordinate, or names at the values of one that has names."""
    if shown.ticks:
        axis.set_ticks(shown.values, shown.ticks)
    elif len(shown.values) == 1:  # its cell has some width, which means nothing
        axis.set_ticks(shown.values, [f"{shown.values[0]:.4g}".replace("-", "−")])
    else:
        wide = shown.unit == "°" and max(shown.values) - min(shown.values) > 90
        axis.set_major_locator(MaxNLocator(7, steps=[1, 1.5, 3, 4.5, 6, 9, 10] if wide else [1, 2, 5, 10]))


@styled  # hatches and fonts are looked up when they are drawn
def save(figure: Figure | Axes, path: str | os.PathLike[str], dpi: float = 300) -> None:
    """Write a figure.

    Args:
        figure: a figure, or axes of it.
        path: of the file, ending in .pdf, .svg or .png.
        dpi: dots per inch of a PNG, and of what is too fine for lines in the others.

    Raises:
        ArgumentError: the ending is another one.
    """
    options = format_of(path)
    if not isinstance(figure, Axes | Figure):
        raise ArgumentError(f"{figure!r} is no figure: functions of ks.plot return the axes of one")
    canvas = figure_of(figure) if isinstance(figure, Axes) else figure
    canvas.savefig(Path(path), dpi=dpi, bbox_inches="tight", pad_inches=0.03, metadata=options)


def format_of(path: str | os.PathLike[str]) -> dict[str, None]:
    """Return the metadata of a figure's file.

    Raises:
        ArgumentError: figures are not written to files of this ending.
    """
    options = _FORMATS.get(Path(path).suffix.lower())
    if options is None:
        raise ArgumentError(f"{path}: figures are written as {', '.join(_FORMATS)}, by the ending of the name")
    return options


def draw_into_files() -> None:
    """Open no windows: for commands, which write their figures."""
    plt.switch_backend("agg")


def save_and_close(ax: Axes, path: str | os.PathLike[str], dpi: float = 300) -> None:
    """Write the figure as :func:`save` does, and close it."""
    save(ax, path, dpi)
    plt.close(figure_of(ax))
