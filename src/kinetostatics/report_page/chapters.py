"""Chapters of a report page: reports of robot, pose and results, and sentences about assumptions."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np

from kinetostatics.arguments import Keyword
from kinetostatics.compensation import compensate
from kinetostatics.exceptions import ArgumentError, CoordinatesError, KinetostaticsError
from kinetostatics.layout.numbers import join_words
from kinetostatics.math.arrays import Array
from kinetostatics.report_page.bars import contribution_bars, source_bars
from kinetostatics.reports.result import magnitudes
from kinetostatics.results.result import Result
from kinetostatics.verification import verify
from kinetostatics.viewer.page import iframe_html, page_html
from kinetostatics.viewer.scene import describe_scene

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


def assumptions_html(result: Result) -> str:
    """Return the assumptions of an analysis (elastic and rigid parts, linearity, weights) as a list."""
    description = result.robot.description
    beams, joints = list(description.beams), list(description.joint_stiffness)
    kinds = {"beams": beams, "joints": joints, "springs": list(description.springs)}
    texts = [f"Elastic {kind}: {join_words(names, 12)}." for kind, names in kinds.items() if names] or ["Nothing is elastic."]
    if not joints:
        texts.append("Joints, bearings and actuators are rigid: the file gives no stiffnesses for them.")
    texts.append(
        f"Gravity is {_vector(result.gravity)} m/s² in world axes; it acts on all masses, and on beams along their whole length."
    )
    return "<ul>" + "".join(f"<li>{escape(text)}</li>" for text in (*texts, *ALWAYS)) + "</ul>"


def _vector(values: Array) -> str:
    return "(" + ", ".join(f"{value:.6g}" for value in np.asarray(values)) + ")"


def sag_html(result: Result) -> str:
    """Return the contributions to the platform's displacement as bars."""
    noise = magnitudes(result)
    bars_of = {"By weights and loads": contribution_bars, "By elastic parts": source_bars}
    parts = {title: bars(result, noise) for title, bars in bars_of.items()}
    found = [f"<h3>{title}</h3>\n{bars}" for title, bars in parts.items() if bars]
    return "\n".join(found) or "<p>The platform does not move: no elastic part deforms.</p>"


def compensation_html(
    result: Result, arguments: dict[str, Keyword], controlled: Sequence[str] | None, tool: Array | None = None
) -> str:
    """Return the corrections of the actuators by which the loaded platform reaches the pose."""
    try:
        return compensate(result.configuration, controlled=controlled, tool=tool, **arguments).report().html()
    except KinetostaticsError as error:
        if controlled is not None and isinstance(error, (ArgumentError, CoordinatesError)):
            raise  # an invalid argument
        return f"<p>No correction: {escape(str(error))}.</p>"


def verification_html(result: Result, arguments: dict[str, Keyword]) -> str:
    """Return the verification by finite elements, or the reason why there is none."""
    known = {name: value for name, value in arguments.items() if name not in ("engine", "on_failure")}
    try:
        found = verify(result.configuration, **known)
    except KinetostaticsError as error:
        return f"<p>No verdict: {escape(str(error))}.</p>"
    return found.report().html()


def scene_html(result: Result, title: str) -> str:
    """Return the scene of the viewer, and an image element with its picture for printing."""
    frame = iframe_html(page_html(describe_scene(result, title).plain()), HEIGHT)
    return f'<div class="scene">{frame}</div>\n<img class="still" alt="{escape(title)}, deformation exaggerated">'
