"""What all figures look like, and how they are written."""

from __future__ import annotations

import os
from collections.abc import Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any, Literal

import matplotlib as mpl
import numpy as np
from matplotlib import pyplot as plt
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axis import XAxis, YAxis
from matplotlib.figure import Figure, SubFigure
from matplotlib.ticker import MaxNLocator
from mpl_toolkits.mplot3d import Axes3D
from numpy.typing import NDArray

from kinetostatics.exceptions import ArgumentError
from kinetostatics.plots.selection import Axis

#: Width of one and of two columns of a journal [inch].
ONE_COLUMN, TWO_COLUMNS = 3.46, 7.09

#: Luminance rises along it, so that it reads in grey; made for the colour-blind.
COLOURS = "cividis"

#: Matplotlib's settings of every figure.
STYLE: dict[str, Any] = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 8,
    "axes.labelsize": 8,
    "axes.titlesize": 8,
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

#: Dashes and markers of lines, which must differ without colour.
DASHES = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)), (0, (8, 2)))
MARKERS = ("o", "s", "^", "D", "v", "x")

#: What files figures may be written to, and what else goes into them; no dates, so that the same figure is the same file.
_FORMATS: dict[str, dict[str, Any]] = {
    ".pdf": {"metadata": {"CreationDate": None}},
    ".svg": {"metadata": {"Date": None}},
    ".png": {},
}


def styled() -> AbstractContextManager[None]:
    """Return a context in which Matplotlib draws in :data:`STYLE`."""
    settings: Any = STYLE  # newer Matplotlib lists all keys in its types
    return mpl.rc_context(settings)


def new_axes(width: float, height: float, three_dimensional: bool = False) -> Axes:
    """Return axes on a figure of their own; to be called in :func:`styled`."""
    figure = plt.figure(figsize=(width, height), layout="constrained")
    return figure.add_subplot(projection="3d" if three_dimensional else None)  # type: ignore[no-any-return, call-overload]


def make_room(ax: Axes3D, labels: Sequence[str]) -> None:
    """Label axes in three dimensions, fill their rectangle, and draw what is listed later over what is listed earlier."""
    ax.computed_zorder = False
    ax.set_box_aspect((4, 4, 3), zoom=1.1)
    for axis, text in zip((ax.xaxis, ax.yaxis, ax.zaxis), labels, strict=True):
        axis.set_label_text(text)
        axis.labelpad = -1
        axis.set_tick_params(pad=1 if axis is ax.zaxis else -1)
        axis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
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


def legend_below(figure: Figure, handles: Sequence[Artist]) -> None:
    """Put a legend below everything else, in as many columns as the page is wide for."""
    longest = max((len(str(handle.get_label())) for handle in handles), default=0)
    points = 4.2 * longest + 38  # of letters; of the patch and the gaps
    columns = int(72 * figure.get_figwidth() / points)
    if handles:
        figure.legend(handles=list(handles), loc="outside lower center", ncols=max(1, min(columns, len(handles))))


def extend_of(values: NDArray[np.float64], low: float, high: float) -> Literal["neither", "both", "min", "max"]:
    """Return at which ends of a colour bar values lie beyond."""
    below, above = bool(np.any(values < low)), bool(np.any(values > high))
    return "both" if below and above else "min" if below else "max" if above else "neither"


def name_ticks(axis: XAxis | YAxis, shown: Axis) -> None:
    """Write names at the ticks of a coordinate that has names for values."""
    if shown.ticks:
        axis.set_ticks(shown.values, shown.ticks)


def save(figure: Figure | Axes, path: str | os.PathLike[str], dpi: float = 300) -> None:
    """Write a figure.

    Args:
        figure: a figure, or axes of it.
        path: of the file, ending in .pdf, .svg or .png.
        dpi: dots per inch of a PNG, and of what is too fine for lines in the others.

    Raises:
        ArgumentError: the ending is another one.
    """
    file = Path(path)
    options = _FORMATS.get(file.suffix.lower())
    if options is None:
        raise ArgumentError(f"{path}: figures are written as {', '.join(_FORMATS)}, by the ending of the name")
    canvas = figure_of(figure) if isinstance(figure, Axes) else figure
    with styled():  # hatches and fonts are looked up when they are drawn
        canvas.savefig(file, dpi=dpi, bbox_inches="tight", pad_inches=0.03, **options)
