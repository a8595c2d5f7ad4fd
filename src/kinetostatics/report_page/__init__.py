"""Report page: one printable HTML file about a robot at a pose and over its workspace."""

from __future__ import annotations

import os
import re
from html import escape
from importlib.resources import files
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from kinetostatics.analysis import analyze, check_keywords
from kinetostatics.arguments import Keyword
from kinetostatics.exceptions import ArgumentError
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.layout.renderings import save_page
from kinetostatics.report_page import chapters
from kinetostatics.results.pose_arrays import tool_on_robot
from kinetostatics.workspace.sweep_plan import versions

if TYPE_CHECKING:
    from collections.abc import Sequence

    import xarray as xr


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
    **analysis: Keyword,
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
        ArgumentError: an argument is invalid, the file's extension is not .html, there are several poses, or the map is one of
            another robot.
        CoordinatesError: the controlled coordinates do not determine the pose.
        StaticsError: the pose cannot be analysed.
        KinetostaticsError: the file cannot be written.
    """
    check_keywords(save_report, analysis)
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
    """Return the page; ``arguments`` are those of :func:`kinetostatics.analyze`."""
    if not isinstance(configuration, Configuration):
        raise ArgumentError(f"a report needs a Configuration, got {configuration!r}; create one with robot.assemble(…)")
    result = analyze(configuration, **arguments)
    if result.shape != ():
        raise ArgumentError(f"a report needs one pose and one load, not a batch of the shape {result.shape}")
    place = tool_on_robot(tool, result.robot)
    tip = result.seen_from(place)
    if workspace is not None:
        workspace = chapters.checked_map(workspace, configuration, place)
    robot = result.robot
    heading = str(title or robot.name)
    parts = {
        "In short": tip.report().brief().html(),
        "The robot at the pose": chapters.scene_html(result, heading),
        "Where the sag comes from": chapters.sag_html(tip),
        "Over the workspace": "" if workspace is None else chapters.workspace_html(workspace, configuration),
        "Compensation": chapters.compensation_html(result, arguments, controlled, place),
        "Checked by finite elements": chapters.verification_html(result, arguments),
        "What is assumed": chapters.assumptions_html(result),
        "The pose in numbers": tip.report().html(),
        "The robot": robot.report().html(),
    }
    body = [f"<section>\n<h2>{name}</h2>\n{text}\n</section>" for name, text in parts.items() if text]
    pieces = {"title": escape(heading), "version": escape(versions()["kinetostatics"]), "body": "\n".join(body)}
    pieces |= {"style": _asset("report.css"), "script": _asset("report.js")}
    return re.sub(r"\{\{(\w+)\}\}", lambda found: pieces[found[1]], _asset("report.html"))


def _asset(name: str) -> str:
    return (files("kinetostatics.report_page") / "assets" / name).read_text(encoding="utf-8")
