"""Report page: one printable HTML file about a robot at a pose and over its workspace."""

from __future__ import annotations

import base64
import os
import tempfile
from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Unpack

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.analysis import analyze
from kinetostatics.arguments import Keyword
from kinetostatics.compensation import compensate
from kinetostatics.exceptions import ArgumentError, CoordinatesError, KinetostaticsError
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.layout.numbers import ANGLES, LENGTHS, STIFFNESSES, NoiseFloor, NumberFormat, join_words, quantity
from kinetostatics.layout.renderings import asset, filled, save_page
from kinetostatics.load_case import FurtherKeywords, check_keywords
from kinetostatics.math.arrays import Array
from kinetostatics.reports.map import coordinate_words, map_report
from kinetostatics.reports.result import noise_floor
from kinetostatics.reports.sources import parts_along, ranked, share, shown_and_rest, sources
from kinetostatics.results.pose_arrays import tool_on_robot
from kinetostatics.results.result import Result
from kinetostatics.verification import verify
from kinetostatics.viewer.page import iframe_html, page_html, page_scripts, policy
from kinetostatics.viewer.scene import describe_scene
from kinetostatics.workspace.sweep_plan import versions

if TYPE_CHECKING:
    import xarray as xr

#: Height of the scene [px].
HEIGHT = 600

#: Assumptions for every robot.
ALWAYS = (
    "Displacements are small: equilibrium is formulated at the unloaded pose, and displacements are proportional to the load.",
    "Beams are straight and prismatic, of a linear elastic material, with bending, torsion, extension and shear (Timoshenko). "
    "Axial forces do not change their stiffness; N/N_Euler shows how close they are to buckling.",
    "Base, platform and all links that are not beams are rigid.",
    "Actuators are locked at their positions. Joints have neither clearance nor friction, and all masses are at rest.",
)


def save_report(
    configuration: Configuration,
    path: str | os.PathLike[str],
    load: ArrayLike = (0, 0, 0, 0, 0, 0),
    gravity: ArrayLike = (0, 0, -9.81),
    *,
    workspace: xr.Dataset | None = None,
    title: str | None = None,
    controlled: Sequence[str] | None = None,
    tool: ArrayLike | None = None,
    **analysis: Unpack[FurtherKeywords],
) -> None:
    """Write one HTML page about a robot at a pose, which a colleague can read and print without server and network.

    Contents: the robot, assumptions, all tables of :func:`kinetostatics.analyze`, contributions to the sag, worst cases and maps
    over the workspace, corrections of the actuators (:func:`kinetostatics.compensate`), verification by finite elements
    (:func:`kinetostatics.verify`, if OpenSeesPy is installed), and a 3D view. Equal input gives equal files.

    Args:
        configuration: one pose.
        path: path of the file; an existing file is replaced.
        load: (6,) external wrench on the platform [N, N·m], see :func:`kinetostatics.analyze`.
        gravity: (3,) gravity [m/s²].
        workspace: a map of the same robot, see :func:`kinetostatics.sweep`; its figures are slices over the first two varying
            coordinates, through the point of the map nearest to the pose. Default: no chapter on the workspace.
        title: heading of the page; default: the robot's name.
        controlled: controlled coordinates of the platform, see :func:`kinetostatics.compensate`.
        tool: (3,) reference point of displacements, contributions, corrections and map, such as a tool's tip, from o in platform
            axes [m]; default: o.
        analysis: further arguments of :func:`kinetostatics.analyze`: ``point``, ``frame``, ``loads``, ``payload``, ….

    Raises:
        ArgumentError: an argument is invalid, the file's extension is not .html, there are several poses, the map is of
            another robot, or the file cannot be written.
        CoordinatesError: the controlled coordinates do not determine the pose.
        StaticsError: the pose cannot be analysed.
    """
    check_keywords(save_report, FurtherKeywords, analysis)
    given = {"load": load, "gravity": gravity, **analysis}
    save_page(path, lambda: report_html(configuration, given, workspace, title, controlled, tool))


def report_html(
    configuration: Configuration,
    arguments: dict[str, Keyword],
    workspace: xr.Dataset | None,
    title: str | None,
    controlled: Sequence[str] | None,
    tool: ArrayLike | None = None,
) -> str:
    """Return the page of :func:`save_report`; ``arguments`` are the arguments of :func:`kinetostatics.analyze`."""
    if not isinstance(configuration, Configuration):
        raise ArgumentError(f"a report needs a Configuration, got {configuration!r}; create one with robot.assemble(…)")
    result = analyze(configuration, **arguments)
    if result.shape != ():
        raise ArgumentError(f"a report needs one pose and one load, not a batch of the shape {result.shape}")
    place = tool_on_robot(tool, result.robot)
    tip = result.seen_from(place)
    if workspace is not None:
        workspace = checked_map(workspace, configuration, place)
    robot = result.robot
    heading = str(title or robot.name)
    parts = {
        "In short": tip.report().brief().html(),
        "The robot at the pose": scene_html(result, heading),
        "Where the sag comes from": sag_html(tip),
        "Over the workspace": "" if workspace is None else workspace_html(workspace, configuration),
        "Compensation": compensation_html(result, arguments, controlled, place),
        "Checked by finite elements": verification_html(result, arguments),
        "What is assumed": assumptions_html(result),
        "The pose in numbers": tip.report().html(),
        "The robot": robot.report().html(),
    }
    body = [f"<section>\n<h2>{name}</h2>\n{text}\n</section>" for name, text in parts.items() if text]
    style, script, template = (asset(__package__, f"report.{ending}") for ending in ("css", "js", "html"))
    texts = {"title": heading, "version": versions()["kinetostatics"], "policy": policy(script, *page_scripts())}
    return filled(template, texts, {"body": "\n".join(body), "style": style, "script": script})


# ---- chapters ---------------------------------------------------------------------------------------------------------


def assumptions_html(result: Result) -> str:
    description = result.robot.description
    beams, joints = list(description.beams), list(description.joint_stiffness)
    kinds = {"beams": beams, "joints": joints, "springs": list(description.springs)}
    texts = [f"Elastic {kind}: {join_words(names, 12)}." for kind, names in kinds.items() if names] or ["Nothing is elastic."]
    if not joints:
        texts.append("Joints, bearings and actuators are rigid: the file gives no stiffnesses for them.")
    gravity = ", ".join(f"{value:.6g}" for value in result.gravity)
    texts.append(f"Gravity is ({gravity}) m/s² in world axes; it acts on all masses, and on beams along their whole length.")
    return "<ul>" + "".join(f"<li>{escape(text)}</li>" for text in (*texts, *ALWAYS)) + "</ul>"


def sag_html(result: Result) -> str:
    """Return bar charts of the contributions to the platform's displacement."""
    noise = noise_floor(result)
    names, twists = sources(result)
    parts = {
        "By weights and loads": _bars(list(result.contributions), list(result.contributions.values()), result, noise),
        "By elastic parts": _bars([f"{name} ({kind})" for name, kind in names], list(twists), result, noise, sort=True),
    }
    charts = [f"<h3>{title}</h3>\n{bars}" for title, bars in parts.items() if bars]
    return "\n".join(charts) or "<p>The platform does not move: no elastic part deforms.</p>"


def compensation_html(
    result: Result, arguments: dict[str, Keyword], controlled: Sequence[str] | None, tool: Array | None = None
) -> str:
    """Return the corrections of the actuators by which the loaded platform reaches the pose, or the reason why there are none."""
    try:
        return compensate(result.configuration, controlled=controlled, tool=tool, **arguments).report().html()
    except KinetostaticsError as error:
        if controlled is not None and isinstance(error, (ArgumentError, CoordinatesError)):
            raise  # an invalid argument
        return f"<p>No correction: {escape(str(error))}.</p>"


def verification_html(result: Result, arguments: dict[str, Keyword]) -> str:
    """Return the verification by finite elements, or the reason why there is none."""
    verify_arguments = {name: value for name, value in arguments.items() if name not in ("engine", "on_failure")}
    try:
        verification = verify(result.configuration, **verify_arguments)
    except KinetostaticsError as error:
        return f"<p>No verdict: {escape(str(error))}.</p>"
    return verification.report().html()


def scene_html(result: Result, title: str) -> str:
    """Return the scene of the viewer, and an image element that shows it in print."""
    frame = iframe_html(page_html(describe_scene(result, title).plain()), HEIGHT)
    return f'<div class="scene">{frame}</div>\n<img class="still" alt="{escape(title)}, deformation exaggerated">'


#: Largest number of bars; the remaining contributions share one bar.
MOST = 14
#: Sizes [px]: width of the drawing, height of a row, width of the column of numbers, width of a letter.
WIDTH, ROW, NUMBERS, LETTER = 680, 20, 90, 6.4

#: Title of the bars: displacement, or rotation if the displacement is zero.
WORDS = ("displacement of {}, each along the whole displacement", "rotation, each about the axis of the whole rotation")


def _bars(names: list[str], twists: list[Array], result: Result, noise: NoiseFloor, sort: bool = False) -> str:
    """Return a bar chart of the parts of twists (6,) along the platform's motion; an empty text if the platform does not move."""
    along = parts_along(np.reshape(twists, (-1, 6)), result.twist, noise)
    if along is None:
        return ""
    parts, sizes, by = along
    values = parts[:, by]
    order = ranked(values) if sort else list(range(len(values)))
    shown, others = shown_and_rest(order, MOST)
    rows = [(names[k], float(values[k])) for k in shown]
    if others:
        rows.append((f"{len(others)} others", float(values[others].sum())))
    form = NumberFormat.of(values, (LENGTHS, ANGLES)[by], (noise.displacement, noise.rotation)[by])
    words = WORDS[by].format(result.point_name)
    return _drawing(rows, form, float(sizes[by]), f"Parts of the {words}; together {form.with_unit(sizes[by])}")


def _drawing(rows: Sequence[tuple[str, float]], form: NumberFormat, whole: float, title: str) -> str:
    """Return a bar chart (SVG) of named values [SI]; beside each bar stand the value and its percentage of the whole."""
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


#: Quantities of the workspace chapter, if the map has them.
SHOWN = ("linear_sag", "angular_sag", "least_translational_stiffness", "largest_actuator_force")


def checked_map(workspace: xr.Dataset, configuration: Configuration, tool: Array | None) -> xr.Dataset:
    """Return a map with the tool's tip as reference point; an error if the map is of another robot or another point."""
    from kinetostatics.indices import at_point
    from kinetostatics.indices.map_variables import variable

    variable(workspace, "status")
    name, of = configuration.robot.name, workspace.attrs.get("robot_name")
    if of != name:
        raise ArgumentError(f"the map is of {of!r}, but the pose of {name!r}: sweep the same robot")
    map_point = workspace.attrs.get("point")
    if map_point is None:
        return workspace if tool is None else at_point(workspace, tool.tolist())
    if tool is None or not np.array_equal(map_point, tool):
        point = f"({' '.join(f'{value:g}' for value in map_point)})"
        raise ArgumentError(f"the map refers to the point {point} m of the platform: give tool={point.replace(' ', ', ')} too")
    return workspace


def workspace_html(workspace: xr.Dataset, configuration: Configuration) -> str:
    """Return the worst cases of a map, and figures of its slices near the pose."""
    about = "<p>Sag and stiffness are those of the tool's tip.</p>" if "point" in workspace.attrs else ""
    return "\n".join([map_report(workspace).html(), _softest(workspace), about, _figures(workspace, configuration)])


def _softest(workspace: xr.Dataset) -> str:
    """Return a sentence on the pose of least translational stiffness."""
    from kinetostatics import indices

    what = "least_translational_stiffness"
    try:
        softest = indices.worst(workspace, what)
    except ArgumentError:  # no valid pose
        return ""
    where = ", ".join(coordinate_words(workspace[name], value) for name, value in softest.coordinates.items())
    return f"<p>least translational stiffness {quantity(softest.value, STIFFNESSES)} at {escape(where or 'the only pose')}</p>"


def _figures(workspace: xr.Dataset, configuration: Configuration) -> str:
    """Return figures of slices over the first two varying coordinates; if Matplotlib is missing, a sentence."""
    try:
        from kinetostatics import plot
    except KinetostaticsError as error:
        return f"<p>There are no maps here: {escape(str(error))}.</p>"
    from kinetostatics import indices
    from kinetostatics.plot.selection import free_names
    from kinetostatics.plot.style import save_and_close

    names = free_names(workspace, ())
    if not names:
        return ""
    here = {**configuration.platform, **configuration.actuators}
    at = {name: float(here[name]) for name in names[2:] if name in here}
    figures = []
    for what in sorted(set(SHOWN) & set(indices.names(workspace)), key=SHOWN.index):
        try:
            if len(names) > 1:
                axes = plot.slice(workspace, what, *names[:2], at=at)
            else:
                axes = plot.line(workspace, what, names[0])
        except ArgumentError:  # no valid pose
            continue
        with tempfile.TemporaryDirectory(prefix="kinetostatics_") as folder:
            file = Path(folder) / "map.svg"
            save_and_close(axes, file)
            data = base64.b64encode(file.read_bytes()).decode()
        words = escape(f"{what} over {', '.join(names[:2])}")
        figures.append(f'<img class="map" alt="{words}" src="data:image/svg+xml;base64,{data}">')
    return f'<div class="maps">{"".join(figures)}</div>'
