"""Style of all figures, and their files."""

from __future__ import annotations

import functools
import io
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
from kinetostatics.output_files import replacing
from kinetostatics.plot.selection import ShownAxis, typeset

P = ParamSpec("P")
R = TypeVar("R")

#: Width of a column of a journal [inch].
ONE_COLUMN = 3.46

#: Colour map of increasing luminance, for figures legible in grey and with colour blindness.
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
    "pdf.fonttype": 42,  # text is embedded as text
    "svg.hashsalt": "kinetostatics",  # reproducible files
}

#: Letters of a title per inch of the figure's width; letters of a colour bar's title per inch of the figure's height.
LETTERS, BAR = 14.5, 12.2
NO_BREAK = "\N{NO-BREAK SPACE}"

#: Panels in a row.
ROW = 3

#: Label of figures created by this package; only their size may be changed.
OWN_PAGE = "kinetostatics"

#: Dashes and markers of lines, distinguishable without colour.
DASHES = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)), (0, (8, 2)))
MARKERS = ("o", "s", "^", "D", "v", "x")

#: File formats and their metadata, without dates for reproducible files.
_FORMATS: dict[str, dict[str, None]] = {".pdf": {"CreationDate": None}, ".svg": {"Date": None}, ".png": {}}


def styled(draw: Callable[P, R]) -> Callable[P, R]:
    """Decorator of functions that draw with the settings :data:`STYLE`."""

    @functools.wraps(draw)
    def drawn(*args: P.args, **kwargs: P.kwargs) -> R:
        with mpl.rc_context(mpl.RcParams(STYLE)):
            return draw(*args, **kwargs)

    return drawn


def new_panels(count: int, width: float, height: float, projection: str | None = None) -> list[Axes]:
    """Return several axes of given width and height [inch] on a new figure, :data:`ROW` in a row."""
    columns = min(count, ROW)
    rows = -(-count // columns)
    figure = plt.figure(figsize=(columns * width, rows * height), layout="constrained", label=OWN_PAGE)
    return [figure.add_subplot(rows, columns, k + 1, projection=projection) for k in range(count)]  # type: ignore[call-overload]


def new_axes(width: float, height: float, projection: str | None = None) -> Axes:
    return new_panels(1, width, height, projection)[0]


def wrapped(text: str, figure: Figure) -> str:
    """Return the title of a colour bar or vertical axis, wrapped to the height of the figure."""
    return textwrap.fill(text, max(20, int(BAR * figure.get_figheight())))


def solid_axes(ax: Axes | None, height: float, what: str) -> Axes3D:
    """Return the given axes, or new three-dimensional axes, one column wide and ``height`` column widths high."""
    axes = new_axes(ONE_COLUMN, height * ONE_COLUMN, projection="3d") if ax is None else ax
    if not isinstance(axes, Axes3D):
        raise ArgumentError(f"{what} axes made with projection='3d'")
    return axes


def set_up_solid_axes(ax: Axes3D, labels: Sequence[str]) -> None:
    """Set labels, size and ticks of three-dimensional axes; artists are drawn in the order in which they are added."""
    ax.computed_zorder = False
    ax.set_box_aspect((4, 4, 3), zoom=1.1)
    for axis, text in zip((ax.xaxis, ax.yaxis, ax.zaxis), labels, strict=True):
        axis.set_label_text(text)
        axis.labelpad = -1
        axis.set_tick_params(pad=1 if axis is ax.zaxis else -1)
        axis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
        if axis is not ax.zaxis:  # avoid overlap of the last number of x with the first of y
            for tick in axis.get_major_ticks(len(axis.get_majorticklocs())):
                tick.label1.set_horizontalalignment("right" if axis is ax.xaxis else "left")
        axis.pane.set(facecolor="0.97", edgecolor="0.6")
        axis._axinfo["grid"].update(color="0.85", linewidth=0.4)


def figure_of(ax: Axes) -> Figure:
    figure = ax.figure
    while isinstance(figure, SubFigure):
        figure = figure.figure
    if figure is None:
        raise ArgumentError("these axes have been removed from their figure")
    return figure


def title_of(ax: Axes, text: str) -> str:
    """Return a title wrapped to the figure's width; lines end after commas only."""
    parts = typeset(text).replace(", ", ",\0").replace(" ", NO_BREAK).replace("\0", " ")
    width = int(figure_of(ax).get_figwidth() * LETTERS)
    return textwrap.fill(parts, width, break_long_words=False, break_on_hyphens=False).replace(NO_BREAK, " ")


def legend_below(figure: Figure, handles: Sequence[Artist]) -> None:
    """Add a legend below the figure, in as many columns as fit; a new figure is enlarged for more than two rows."""
    if not handles:
        return
    longest = max(len(str(handle.get_label())) for handle in handles)
    points = 4.2 * longest + 38  # width of letters, patch and gaps [pt]
    rows = -(-len(handles) // max(1, int(72 * figure.get_figwidth() / points)))
    # an empty line above: labels of three-dimensional axes extend below the space reserved by Matplotlib
    title = " " if any(isinstance(ax, Axes3D) for ax in figure.axes) else None
    figure.legend(handles=list(handles), loc="outside lower center", ncols=-(-len(handles) // rows), title=title)
    if figure.get_label() == OWN_PAGE and rows > 2:
        figure.set_figheight(figure.get_figheight() + (rows - 2) * 11 / 72)


def name_ticks(axis: XAxis | YAxis, shown: ShownAxis) -> None:
    """Set ticks at round values of a coordinate; if its values are names, at each value."""
    if shown.ticks:
        axis.set_ticks(shown.values, shown.ticks)
    elif len(shown.values) == 1:  # the width of its cell is arbitrary
        axis.set_ticks(shown.values, [f"{shown.values[0]:.4g}".replace("-", "−")])
    else:
        wide = shown.unit == "°" and max(shown.values) - min(shown.values) > 90
        axis.set_major_locator(MaxNLocator(7, steps=[1, 1.5, 3, 4.5, 6, 9, 10] if wide else [1, 2, 5, 10]))


@styled  # hatches and fonts are resolved at drawing time
def save(figure: Figure | Axes, path: str | os.PathLike[str], dpi: float = 300) -> None:
    """Write a figure.

    Args:
        figure: a figure, or axes of it.
        path: path of the file, with the extension .pdf, .svg or .png.
        dpi: dots per inch of a PNG, and of cells drawn as pixels in the other formats.

    Raises:
        ArgumentError: the path has another extension, or the file cannot be written.
    """
    options = format_of(path)
    if not isinstance(figure, Axes | Figure):
        raise ArgumentError(f"save needs a figure or axes, as returned by functions of ks.plot, got {figure!r}")
    canvas = figure_of(figure) if isinstance(figure, Axes) else figure
    content = io.BytesIO()  # Matplotlib cannot close a PDF on a full disk
    ending = Path(path).suffix[1:].lower()
    canvas.savefig(content, format=ending, dpi=dpi, bbox_inches="tight", pad_inches=0.03, metadata=options)
    with replacing(path) as partial:
        partial.write_bytes(content.getbuffer())


def format_of(path: str | os.PathLike[str]) -> dict[str, None]:
    """Return the metadata of a figure's file, without a date, so that equal figures give equal files."""
    options = _FORMATS.get(Path(path).suffix.lower())
    if options is None:
        raise ArgumentError(f"{path}: figures are written as {', '.join(_FORMATS)}, by the extension of the name")
    return options


def draw_into_files() -> None:
    """Switch to a backend of Matplotlib without windows, for the command line."""
    plt.switch_backend("agg")


def save_and_close(ax: Axes, path: str | os.PathLike[str], dpi: float = 300) -> None:
    save(ax, path, dpi)
    plt.close(figure_of(ax))
