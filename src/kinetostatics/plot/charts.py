"""Charts of sensitivities, tolerances, Pareto fronts, residuals of a calibration, and frequency responses."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes

from kinetostatics.arguments import check_choice
from kinetostatics.exceptions import ArgumentError
from kinetostatics.math.arrays import Array
from kinetostatics.math.screws import COMPONENTS
from kinetostatics.plot.selection import display_unit, label
from kinetostatics.plot.style import COLOURS, DASHES, ONE_COLUMN, figure_of, legend_below, new_axes, styled
from kinetostatics.results.calibration import Calibration
from kinetostatics.results.dynamics import FrequencyResponse
from kinetostatics.results.optimum import ParetoFront
from kinetostatics.results.pose_arrays import point_name
from kinetostatics.results.sensitivities import Sensitivities, is_location
from kinetostatics.results.tolerances import LENGTHS, Tolerances
from kinetostatics.units import sized_name

#: Largest number of bars of each kind of sensitivities; number of bars of a histogram.
MOST, BARS = 12, 60
#: Length of the shortest drawn bar, as a part of the longest one.
SMALL = 0.003
#: Axis titles of quantities that may be minimized.
WORDS = {
    "sag": "displacement",
    "deflection_any_direction": "largest displacement under {}",
    "rotation_any_direction": "largest rotation under {}",
    "actuator_force": "largest actuator force",
    "actuator_torque": "largest actuator torque",
    "stress": "largest von Mises stress",
    "buckling": "used share of the buckling load",
}
#: Markers of gauges, distinguishable without colour.
MARKERS = "osD^v<>Pd*"


@styled
def sensitivities(found: Sensitivities, *, ax: Axes | None = None) -> Axes:
    """Draw the relative change of the displacement of o or a tool for an increase of each parameter or stiffness by 1 %.

    Args:
        found: the sensitivities, see :func:`kinetostatics.sensitivities`.
        ax: axes to draw on; default: a new figure one column wide.

    Returns:
        The axes; bars to the left mean less sag. Bars of parameters of the file are dark; bars of stiffnesses of parts are light
        and hatched. The title states the number of omitted small bars.

    Raises:
        ArgumentError: ``found`` has another type, the twist is not among the outputs, or o does not move.
    """
    if not isinstance(found, Sensitivities):
        raise ArgumentError(f"sensitivities needs the result of ks.sensitivities(pose), got {found!r}")
    if "twist" not in found.outputs:
        raise ArgumentError(f"sensitivities needs the twist, which is not among the outputs={found.outputs}")
    size, point = float(np.linalg.norm(found.seen.twist[found.worst][:3])), point_name(found.tool)
    if not size > 0:
        raise ArgumentError(f"the displacement of {point} is zero: effects along it are undefined")
    rows = [(name, 100 * found.effect(name)[0] / size, False) for name in found if not is_location(name)][:MOST]
    parts = sorted(found.sources, key=lambda name: -abs(found.source_effect(name)))[:MOST]
    rows += [(f"stiffness of {name}", 100 * found.source_effect(name) / size, True) for name in parts]
    least = SMALL * max((abs(value) for _, value, _ in rows), default=0.0)
    small, rows = [row for row in rows if abs(row[1]) < least], [row for row in rows if abs(row[1]) >= least]
    dark, light = mpl.colormaps[COLOURS]([0.15, 0.75])
    ax = new_axes(1.4 * ONE_COLUMN, 0.5 + 0.17 * len(rows)) if ax is None else ax
    for place, (_, value, is_part) in enumerate(rows):
        colour, hatch = (light, "////") if is_part else (dark, None)
        ax.barh(place, value, color=colour, hatch=hatch, edgecolor="white", height=0.75)
    if small:
        ax.set_title(f"not drawn: {len(small)} below {least:.1g} %")
    ax.set_yticks(range(len(rows)), [name for name, *_ in rows])
    ax.invert_yaxis()
    ax.axvline(0.0, color="0.3", linewidth=0.6)
    ax.set_xlabel(f"change of the displacement of {point} per 1 % of increase [%]")
    ax.grid(axis="x", color="0.85", linewidth=0.4)
    ax.set_axisbelow(True)
    return ax


@styled
def tolerances(found: Tolerances, what: str = "displacement", *, ax: Axes | None = None) -> Axes:
    """Draw a histogram of a quantity over random samples, and its first-order approximation.

    Args:
        found: the tolerances, see :func:`kinetostatics.tolerances`.
        what: "displacement" or "rotation", from the nominal robot; a component "x" … "rz" of the twist; or the name of an
            actuator, for its force or torque.
        ax: axes to draw on; default: a new figure one column wide.

    Returns:
        The axes; bars are samples, the solid line is their first-order approximation, and dashed lines are the worst case.

    Raises:
        ArgumentError: ``found`` has another type, the quantity is unknown, or it is equal for all samples.
    """
    if not isinstance(found, Tolerances):
        raise ArgumentError(f"tolerances needs the result of ks.tolerances(pose, …), got {found!r}")
    values = found.samples.named(what)
    worst, is_length = float(found.worst_case.named(what)), what in LENGTHS
    nominal = 0.0 if is_length else float(found.nominal.named(what))
    if not worst > 0:
        raise ArgumentError(f"{what} is the same for all samples, to first order: there is no distribution")
    if what in found.nominal.actuator_forces:
        kind = found.result.robot.mechanism.connections[what].type
        unit, title = kind.force_unit, f"{'force' if kind.is_slide else 'torque'} of {what}"
    else:
        unit = "m" if what == "displacement" or what in COMPONENTS[:3] else "rad"
        motion = f"displacement of {point_name(found.tool)}" if unit == "m" else "rotation of the platform"
        title = motion + (" from nominal" if is_length else f" {'along' if unit == 'm' else 'about'} {what[-1]}")
    values = values[np.isfinite(values)]
    size, name = display_unit(unit, [nominal, values.min(), values.max()])
    dark, light = mpl.colormaps[COLOURS]([0.1, 0.75])
    ax = new_axes(1.4 * ONE_COLUMN, 2.3) if ax is None else ax
    _, edges, _ = ax.hist(values / size, BARS, color=light, edgecolor="white", linewidth=0.3, label=f"{len(values):,} samples")
    ax.hist(_first_order(found, what) / size, edges.tolist(), histtype="step", color=dark, label="first order")
    for sign in (1,) if is_length else (1, -1):
        label = "worst case" if sign > 0 else None
        ax.axvline((nominal + sign * worst) / size, color="0.3", linestyle="--", linewidth=0.8, label=label)
    ax.set_xlabel(f"{title} [{name}]")
    ax.set_ylabel("number of samples")
    ax.legend(loc="upper left", bbox_to_anchor=(0.0, 1.16), ncols=3)
    return ax


def _first_order(found: Tolerances, what: str) -> Array:
    """Return the first-order approximation (samples,) of the quantity ``what``."""
    amounts = {name: (found.values[name] - parameter.value) / parameter.tolerance for name, parameter in found.parameters.items()}
    parts = [(found.effects[name], amount) for name, amount in amounts.items()]
    if what in LENGTHS:
        change = sum(np.outer(part, effect.twist[LENGTHS[what]]) for effect, part in parts)
        return np.asarray(np.linalg.norm(change, axis=-1))
    return np.asarray(found.nominal.named(what) + sum(part * effect.named(what) for effect, part in parts))


@styled
def pareto(found: ParetoFront, *, ax: Axes | None = None) -> Axes:
    """Draw a Pareto front; if only one parameter varies, the points are labelled with its values.

    Args:
        found: the front, see :func:`kinetostatics.pareto`.
        ax: axes to draw on; default: a new figure one column wide.

    Returns:
        The axes; the first quantity is horizontal; the second is vertical, logarithmic if it varies by more than a factor of ten.

    Raises:
        ArgumentError: ``found`` is no Pareto front.
    """
    if not isinstance(found, ParetoFront):
        raise ArgumentError(f"pareto needs the result of ks.pareto(robot, …), got {found!r}")
    scales = [display_unit(unit, found.objectives[:, k]) for k, unit in enumerate(found.units)]
    (x, y), (x_unit, y_unit) = (found.objectives / [size for size, _ in scales]).T, (name for _, name in scales)
    ax = new_axes(1.4 * ONE_COLUMN, 2.5) if ax is None else ax
    ax.plot(x, y, "o-", color=mpl.colormaps[COLOURS](0.1))
    if y.min() > 0 and y.max() > 10 * y.min():
        ax.set_yscale("log")
    if len(found.parameters) == 1:
        ((name, values),) = found.parameters.items()
        unit = found[0].units.get(name, "")
        size, shown = display_unit(unit, values) if unit else (1.0, "")
        for place, value in zip(zip(x, y, strict=True), values / size, strict=True):
            ax.annotate(f"{value:.3g} {shown}".rstrip(), place, (4, 3), textcoords="offset points", fontsize=6)
    ax.margins(0.14, 0.1)
    ax.set_xlabel(label(_axis_title(found.minimized[0]), x_unit))
    ax.set_ylabel(label(_axis_title(found.minimized[1]), y_unit))
    ax.grid(color="0.85", linewidth=0.4, which="both")
    ax.set_axisbelow(True)
    return ax


def _axis_title(quantity: str) -> str:
    name, size = sized_name(quantity)
    return WORDS.get(name, name).format(size)


@styled
def calibration(found: Calibration, *, kind: str | None = None, ax: Axes | None = None) -> Axes:
    """Draw residuals (measured minus computed readings) over computed readings; outliers are marked with row numbers.

    Args:
        found: the calibration, see :func:`kinetostatics.calibrate`.
        kind: kind of readings, "length" or "angle"; default: lengths, if there are any.
        ax: axes to draw on; default: a new figure one column and a half wide.

    Returns:
        The axes, with a marker for each gauge; the band is ± twice the largest of the readings' standard deviations.

    Raises:
        ArgumentError: ``found`` is no calibration, or there are no readings of this kind.
    """
    if not isinstance(found, Calibration):
        raise ArgumentError(f"calibration needs the result of ks.calibrate(robot, …), got {found!r}")
    kinds = np.array([found.gauges[name].kind for name in found.gauge_of])
    kind = kind or ("length" if "length" in kinds else "angle")
    of_kind = kinds == kind
    if not np.any(of_kind):
        raise ArgumentError(f"there are no readings of the kind {kind!r}; it must be one of 'length', 'angle'")
    across, across_unit = display_unit("m" if kind == "length" else "rad", found.computed[of_kind])
    up, up_unit = display_unit("m" if kind == "length" else "rad", found.residuals[of_kind])
    wrong = {(outlier.row, outlier.gauge) for outlier in found.outliers}
    ax = new_axes(1.5 * ONE_COLUMN, 0.8 * ONE_COLUMN) if ax is None else ax
    names = [name for name, gauge in found.gauges.items() if gauge.kind == kind]
    colours = mpl.colormaps[COLOURS](np.linspace(0.1, 0.8, len(names)))
    band = 2 * found.sigma[of_kind].max() / up
    ax.axhspan(-band, band, color="0.92", linewidth=0, label="±2 standard deviations")
    ax.axhline(0.0, color="0.3", linewidth=0.6)
    for k, name in enumerate(names):
        at = np.array([gauge == name for gauge in found.gauge_of])
        x, y = found.computed[at] / across, found.residuals[at] / up
        ax.plot(x, y, MARKERS[k % len(MARKERS)], color=colours[k], label=name)
        for row, predicted, residual in zip(found.rows[at].tolist(), x, y, strict=True):
            if (row, name) in wrong:
                ax.plot(predicted, residual, "o", markersize=9, markerfacecolor="none", color="0.2", markeredgewidth=0.8)
                ax.annotate(f"row {row}", (predicted, residual), xytext=(7, 0), textcoords="offset points", va="center")
    ax.set_xlabel(f"predicted reading [{across_unit}]")
    ax.set_ylabel(f"residual: measured − predicted [{up_unit}]")
    ax.grid(color="0.85", linewidth=0.4)
    ax.set_axisbelow(True)
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, 1.14), ncols=min(len(names) + 1, 4))
    return ax


@styled
def frequency_response(
    found: FrequencyResponse, what: str = "compliance", components: Sequence[str] = ("x", "y", "z"), *, ax: Axes | None = None
) -> Axes:
    """Draw magnitudes of a frequency response, with logarithmic axes.

    Args:
        found: result of :func:`kinetostatics.frequency_response` at one pose.
        what: "compliance", displacement per force in the same direction (or rotation per moment); or "transmissibility",
            displacement per displacement of the floor in the same direction (or rotation per rotation).
        components: translations "x", "y", "z", or rotations "rx", "ry", "rz".
        ax: axes to draw on; default: a new figure one column wide.

    Returns:
        The axes.

    Raises:
        ArgumentError: ``found`` is not the response at one pose, or ``what`` or ``components`` is unknown.
    """
    if not isinstance(found, FrequencyResponse) or found.shape:
        raise ArgumentError(f"frequency_response needs the result of ks.frequency_response(pose, …) at one pose, got {found!r}")
    check_choice("what", what, ("compliance", "transmissibility"))
    kinds = {COMPONENTS.index(name) // 3 for name in components if name in COMPONENTS}
    if len(kinds) != 1 or not set(components) <= set(COMPONENTS):
        raise ArgumentError(f"components is {components!r}; it must be some of x, y, z, or some of rx, ry, rz")
    ax = new_axes(ONE_COLUMN, 0.75 * ONE_COLUMN) if ax is None else ax
    colours = mpl.colormaps[COLOURS](np.linspace(0.0, 0.72, len(components)))
    for k, name in enumerate(components):
        at = COMPONENTS.index(name)
        size = np.abs(getattr(found, what)[:, at, at])
        ax.loglog(found.frequencies, size, color=colours[k], linestyle=DASHES[k], label=name)
    unit = ("m/N" if kinds == {0} else "rad/(N·m)") if what == "compliance" else ("m/m" if kinds == {0} else "rad/rad")
    ax.set(xlabel="frequency [Hz]", ylabel=f"{what} at {point_name(found.tool)} [{unit}]")
    ax.grid(which="major", color="0.85", linewidth=0.4)
    ax.margins(x=0)
    legend_below(figure_of(ax), ax.get_lines())
    return ax
