"""By how much a loaded platform misses where it is wanted, before its actuators are corrected and after, and what they do."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import matplotlib as mpl
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from kinetostatics.argument_checks import check_choice
from kinetostatics.exceptions import ArgumentError, near_names
from kinetostatics.math.arrays import Array
from kinetostatics.plot.display_units import coordinate_unit, display_unit, label
from kinetostatics.plot.style import COLOURS, MARKERS, ONE_COLUMN, figure_of, legend_below, new_axes, styled
from kinetostatics.results.compensation import Compensation
from kinetostatics.results.tool_point import named_point

#: What of a coordinate is rounding [m, rad].
SAME = 1e-9
#: What can be drawn.
KINDS = ("displacement", "rotation", "correction", "force")


@dataclass(frozen=True)
class _Shown:
    """Numbers (…) by name [SI], before and after, and the words for both."""

    title: str
    unit: str
    before: Mapping[str, Array]
    after: Mapping[str, Array]
    words: tuple[str, str]


@styled
def compensation(
    found: Compensation,
    what: str = "displacement",
    *,
    x: str | None = None,
    actuators: Sequence[str] | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Draw by how much the loaded platform misses the wanted pose, uncorrected and corrected, or what the actuators do for it.

    Args:
        found: of :func:`kinetostatics.compensate`.
        what: "displacement", by how much o, or the tool's tip, misses its x, y and z; "rotation", the platform its angles;
            "correction" of the actuators; or their "force", and what of it is there without loads and payload.
        x: of a path the coordinate of the wanted platform to the right; default: the one that varies, or else the pose's number.
        actuators: of which corrections or forces are drawn; default: all, if they all slide or all turn.
        ax: to draw on; default: a new figure one column and a half wide.

    Returns:
        The axes: lines along a path, dashed what is before, markers what is after. Of one pose, and of the largest magnitudes of
        a grid of poses, bars. Where there is no correction there is no number.

    Raises:
        ArgumentError: this is no compensation, a name makes no sense, or no pose has a correction.
    """
    if not isinstance(found, Compensation):
        raise ArgumentError(f"{found!r} is no compensation: ks.compensate(pose, …) makes one")
    check_choice("what", what, KINDS)
    if actuators is not None and what in KINDS[:2]:
        raise ArgumentError(f"actuators is not for the {what} of the platform; leave it out")
    shown = _of_platform(found, what) if what in KINDS[:2] else _of_actuators(found, what, actuators)
    if not any(np.any(np.isfinite(values)) for values in shown.after.values()):
        raise ArgumentError("no pose has a correction, so that there is nothing to draw")
    ax = new_axes(1.5 * ONE_COLUMN, 0.8 * ONE_COLUMN) if ax is None else ax
    every = np.concatenate([np.ravel(values) for values in (*shown.after.values(), *shown.before.values())])
    size, unit = display_unit(shown.unit, every)
    if len(found.shape) == 1 and found.shape[0] > 1:
        _lines(ax, found, shown, size, x)
    elif x is not None:
        raise ArgumentError(f"x={x!r} is for a path, one row of poses; the batch has the shape {found.shape}")
    else:
        _bars(ax, shown, size, found.status.size)
    ax.set_ylabel(label(shown.title, unit))
    low, high = ax.get_ylim()
    if low <= 0 <= high:
        ax.axhline(0.0, color="0.3", linewidth=0.6, zorder=1)
    ax.set_axisbelow(True)
    return ax


def _of_platform(found: Compensation, what: str) -> _Shown:
    names = found.target.orientation.pose_names
    mine = names[:3] if what == "displacement" else names[3:]
    before, after = (
        {name: off[name] for name in mine} for off in (found.uncorrected_error_coordinates, found.residual_error_coordinates)
    )
    who = named_point(found.tool) if what == "displacement" else "angle"
    return _Shown(f"{who} misses by", "m" if what == "displacement" else "rad", before, after, ("uncorrected", "corrected"))


def _of_actuators(found: Compensation, what: str, actuators: Sequence[str] | None) -> _Shown:
    known = list(found.actuators)
    chosen = known if actuators is None else [actuators] if isinstance(actuators, str) else list(actuators)
    for name in chosen:
        if name not in known:
            raise ArgumentError(f"actuators: there is no {name!r}: {near_names(str(name), known)}")
    kinds = {kind.unit: kind for kind in (found.target.robot.mechanism.connections[name].type for name in chosen)}
    if len(kinds) != 1:
        raise ArgumentError(
            f"actuators that slide and actuators that turn need figures of their own: choose some by actuators, of {known}"
        )
    ((unit, kind),) = kinds.items()
    if what == "correction":
        shown = {name: found.corrections[name] for name in chosen}
        return _Shown("correction of the actuator", unit, {}, shown, ("", "correction"))
    loads = ["load", *found.result.link_loads]
    parts = found.result.actuator_contributions
    after = {name: found.actuator_forces[name] for name in chosen}
    loaded = {name: np.sum([parts[name][load] for load in loads], axis=0) for name in chosen}
    some = any(np.nanmax(np.abs(part), initial=0.0) > 0 for part in loaded.values())
    before = {name: after[name] - loaded[name] for name in chosen} if some else {}
    title = f"{'force' if kind.is_slide else 'torque'} of the actuator"
    return _Shown(title, kind.force_unit, before, after, ("without loads", "with all loads"))


def _lines(ax: Axes, found: Compensation, shown: _Shown, size: float, x: str | None) -> None:
    places, words = _path(found, x)
    colours = mpl.colormaps[COLOURS](np.linspace(0.0, 0.72, len(shown.after)))
    every = max(1, len(places) // 10)
    handles: list[Artist] = []
    for k, ((name, values), colour) in enumerate(zip(shown.after.items(), colours, strict=True)):
        if name in shown.before:
            ax.plot(places, shown.before[name] / size, "--", color=colour, linewidth=0.9)
        start = k * every // len(shown.after)
        look = {"color": colour, "marker": MARKERS[k % len(MARKERS)], "markerfacecolor": "white", "markeredgewidth": 0.8}
        handles += ax.plot(places, values / size, label=name, markevery=(start, every), **look)
    if shown.before:
        handles.append(Line2D([], [], color="0.3", linestyle="--", linewidth=0.9, label=shown.words[0]))
        handles.append(Line2D([], [], color="0.3", label=shown.words[1]))
    ax.set_xlabel(words)
    ax.set_xlim(np.nanmin(places), np.nanmax(places))
    ax.grid(color="0.85", linewidth=0.4)
    _legend(ax, handles)


def _path(found: Compensation, x: str | None) -> tuple[Array, str]:
    """Return what stands below a path, and its name."""
    coordinates = found.target.platform
    if x is not None and x not in coordinates:
        raise ArgumentError(f"x is {x!r}, which is no coordinate of the wanted platform: {near_names(x, coordinates)}")
    if x is None:
        asked = [name for name in found.target.prescribed if name in coordinates]
        varied = [name for name in asked if np.ptp(coordinates[name]) > SAME]
        x = varied[0] if len(varied) == 1 else None
    if x is None:
        return np.arange(found.shape[0], dtype=np.float64), "pose"
    slides = x in ("x", "y", "z")
    values = coordinates[x] if slides else np.unwrap(coordinates[x])
    size, unit = coordinate_unit("m" if slides else "rad", values)
    return values / size, f"{x} [{unit}]"


def _bars(ax: Axes, shown: _Shown, size: float, poses: int) -> None:
    dark, light = mpl.colormaps[COLOURS]([0.15, 0.75])
    both = bool(shown.before)
    for place, name in enumerate(shown.after):
        for values, colour, hatch, side in ((shown.before, light, "////", -0.2), (shown.after, dark, None, 0.2)):
            if name in values:
                one = np.ravel(values[name] / size)
                height = one[0] if poses == 1 else np.nanmax(np.abs(one))
                ax.bar(place + side * both, height, 0.38 if both else 0.6, color=colour, hatch=hatch, edgecolor="white")
    ax.set_xticks(range(len(shown.after)), list(shown.after))
    ax.set_xlabel("" if poses == 1 else f"largest magnitude of {poses} poses")
    ax.grid(axis="y", color="0.85", linewidth=0.4)
    looks = zip(shown.words, (light, dark), ("////", None), strict=True)
    _legend(ax, [Patch(facecolor=c, hatch=h, edgecolor="white", label=text) for text, c, h in looks] if both else [])


def _legend(ax: Axes, handles: Sequence[Artist]) -> None:
    """Put the legend below a figure of its own, and above axes among others."""
    if len(figure_of(ax).axes) == 1:
        legend_below(figure_of(ax), handles)
    elif handles:
        ax.legend(handles=list(handles), loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=min(3, len(handles)))
