"""Workspace chapter of a report page: worst cases as text, and figures of maps."""

from __future__ import annotations

import base64
import tempfile
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from kinetostatics.exceptions import ArgumentError, KinetostaticsError
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.layout.numbers import STIFFNESSES, quantity
from kinetostatics.math.arrays import Array
from kinetostatics.reports.map import coordinate_words, map_report

if TYPE_CHECKING:
    import xarray as xr

#: Quantities of the workspace chapter, if the map has them.
SHOWN = ("linear_sag", "angular_sag", "least_translational_stiffness", "largest_actuator_force")


def checked_map(workspace: xr.Dataset, configuration: Configuration, tool: Array | None) -> xr.Dataset:
    """Return a map of this robot with the tool's tip as reference point.

    Raises:
        ArgumentError: the Dataset is not a map, or the map has another robot or reference point.
    """
    from kinetostatics.indices import at_point
    from kinetostatics.indices.map_variables import variable

    variable(workspace, "status")
    name, of = configuration.robot.name, workspace.attrs.get("robot_name")
    if of != name:
        raise ArgumentError(f"the map is of {of!r}, and the pose of {name!r}: sweep the same robot")
    own = workspace.attrs.get("point")
    if own is None:
        return workspace if tool is None else at_point(workspace, tool.tolist())
    if tool is None or not np.array_equal(own, tool):
        point = f"({' '.join(f'{value:g}' for value in own)})"
        raise ArgumentError(f"the map is about the point {point} m of the platform: give tool={point.replace(' ', ', ')}, too")
    return workspace


def workspace_html(workspace: xr.Dataset, configuration: Configuration) -> str:
    """Return the worst cases of a map, and figures of it through the pose."""
    about = "<p>Sag and stiffness are those of the tool's tip.</p>" if "point" in workspace.attrs else ""
    return "\n".join([map_report(workspace).html(), _softest(workspace), about, _figures(workspace, configuration)])


def _softest(workspace: xr.Dataset) -> str:
    """Return a sentence on the pose of least translational stiffness."""
    from kinetostatics import indices

    what = "least_translational_stiffness"
    try:
        found = indices.worst(workspace, what)
    except ArgumentError:  # no valid pose
        return ""
    where = ", ".join(coordinate_words(workspace[name], value) for name, value in found.coordinates.items())
    return f"<p>least translational stiffness {quantity(found.value, STIFFNESSES)} at {escape(where or 'the only pose')}</p>"


def _figures(workspace: xr.Dataset, configuration: Configuration) -> str:
    """Return figures over the first two varying coordinates through the pose; a sentence if Matplotlib is missing."""
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
    found = []
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
        found.append(f'<img class="map" alt="{words}" src="data:image/svg+xml;base64,{data}">')
    return f'<div class="maps">{"".join(found)}</div>'
