"""3D view of the deformed robot: a browser page that needs neither server nor network.

A result is converted to a :class:`Scene <kinetostatics.viewer.description.Scene>` of plain numbers, and the scene to one HTML
file with meshcat's script. The page computes all motions.
"""

from __future__ import annotations

import os
import sys
import tempfile
import webbrowser
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from kinetostatics.exceptions import ArgumentError
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.layout.renderings import save_page
from kinetostatics.output_files import write_text
from kinetostatics.progress import in_notebook, pausing, waiting
from kinetostatics.results.dynamics import Modes
from kinetostatics.results.result import Result
from kinetostatics.robot import Robot
from kinetostatics.viewer.description import Scene
from kinetostatics.viewer.page import fitting_page, iframe_html, save_screenshot
from kinetostatics.viewer.scene import describe_scene
from kinetostatics.viewer.single_poses import ModePoses, SinglePose, UnloadedPose

if TYPE_CHECKING:
    import meshcat


class View:
    """A page with a result; notebooks display it in place.

    Attributes:
        html: the whole page.
        path: path of the file opened in the browser, or None.
    """

    def __init__(self, html: str, path: Path | None = None) -> None:
        self.html, self.path = html, path

    def __repr__(self) -> str:
        return f"<View in {str(self.path)!r}>" if self.path else f"<View, {len(self.html) / 1e6:.1f} MB>"

    def _repr_html_(self) -> str:
        return iframe_html(self.html)


def show(
    result: Result | Configuration | Robot | UnloadedPose | Modes,
    *,
    title: str | None = None,
    pose: int | tuple[int, ...] | None = None,
    exaggeration: float | None = None,
    by_mechanism: bool = False,
    compare: Result | None = None,
    vary: Mapping[str, object] | None = None,
    visualizer: meshcat.Visualizer | None = None,
    node: str | None = None,
) -> View | meshcat.Visualizer:
    """Open a result in the browser, or below the cell of a notebook, or draw it into a running meshcat.

    Args:
        result: result of :func:`kinetostatics.analyze`; a batch of poses is animated. Or a pose or a robot, which is drawn
            without loads, with the platform's free motions when the actuators are locked. Or a result of
            :func:`kinetostatics.modes`, of which the page shows one mode at a time.
        title: heading of the picture; default: the robot's name.
        pose: index of the drawn pose of a batch; required to draw a batch into a visualizer.
        exaggeration: initial factor of displacements; default: the largest displacement is about a tenth of the robot's size.
        by_mechanism: show two sliders for each limb's weight: one for the part due to attached wrenches, one for the part due to
            the limb's deformation. See :attr:`Result.mechanism_contributions`.
        compare: a second result, of another pose, load or robot. It is drawn as a ghost over the first one, or beside it with
            the same camera. ``pose`` applies to both.
        vary: one to three parameters that the page varies by sliders, by name of an argument of the robot's file or of a number
            of a part: a range such as ``"40mm:120mm"`` or ``(0.04, 0.12)``; a list of values, or a catalogue, see
            :func:`kinetostatics.optimize`; or None for half to one and a half times the file's value.
        visualizer: a ``meshcat.Visualizer``; the robot is drawn into its scene. The first drawing also sets camera and light.
            Default: a separate page.
        node: path in meshcat's tree, relative to the visualizer; the content of this node is replaced. Default:
            ``kinetostatics/`` and the robot's name.

    Returns:
        The view, which a notebook displays if it is the last value of a cell. If a visualizer is given: the visualizer at the
        node, whose children are ``resting``, ``deformed``, ``base``, ``forces/GROUP/NAME``, ``frames``, ``floor``, ``largest``
        and ``labels``.

    Raises:
        ArgumentError: no pose could be analysed, there are more than 1000 poses, or an argument is invalid.
    """
    if visualizer is not None:
        if compare is not None:
            raise ArgumentError("compare= is for pages; a visualizer shows one result: draw the other one at another node")
        if by_mechanism or vary is not None:
            raise ArgumentError("by_mechanism= and vary= add sliders to a page; a visualizer has none: leave them out")
        if isinstance(result, Modes):
            raise ArgumentError("a visualizer shows results, and modes are shown by a page: leave visualizer= out")
        drawn = _drawable(result)
        if isinstance(drawn, Result) and pose is None and drawn.twist.size != 6:
            raise ArgumentError(f"a visualizer shows one pose, and the result has the shape {drawn.shape}: choose one by pose=")
        from kinetostatics.viewer.running_meshcat import draw  # imports meshcat, with its server

        if node is None:
            node = f"kinetostatics/{drawn.robot.name.replace('/', '_') or 'robot'}"
        return draw(describe_scene(drawn, title, pose=pose, exaggeration=exaggeration), visualizer, node)
    if node is not None:
        raise ArgumentError("node= needs visualizer=: it is the node at which the robot is drawn")
    html = _page(result, title, pose, exaggeration, by_mechanism, compare, vary=vary)
    if in_notebook():
        return View(html)
    file = _temporary_file(html, (result if isinstance(result, Robot) else result.robot).name)
    open_browser(file.as_uri())
    return View(html, file)


def save_html(
    result: Result | Configuration | Robot | UnloadedPose | Modes,
    path: str | os.PathLike[str],
    *,
    title: str | None = None,
    pose: int | tuple[int, ...] | None = None,
    exaggeration: float | None = None,
    by_mechanism: bool = False,
    compare: Result | None = None,
    vary: Mapping[str, object] | None = None,
) -> None:
    """Write the page of a result as one HTML file, which a browser opens without server and network.

    Args:
        result, title, pose, exaggeration, by_mechanism, compare, vary: see :func:`show`.
        path: path of the file; an existing file is replaced.

    Raises:
        ArgumentError: no pose could be analysed, there are more than 1000 poses, or an argument is invalid.
    """
    save_page(path, lambda: _page(result, title, pose, exaggeration, by_mechanism, compare, vary=vary))


def save_image(
    result: Result | Configuration | Robot | UnloadedPose | Modes,
    path: str | os.PathLike[str],
    *,
    title: str | None = None,
    pose: int | tuple[int, ...] | None = None,
    exaggeration: float | None = None,
    compare: Result | None = None,
    colour: str = "deflection",
    view: str = "home",
    mode: int = 1,
    size: tuple[int, int] = (1200, 800),
) -> None:
    """Write a PNG file with the picture of a result and its legend; Chromium or Chrome has to be installed.

    Args:
        result, title, pose, exaggeration, compare: see :func:`show`. A batch is drawn at its first pose, a mode at full
            amplitude.
        path: path of the file; an existing file is replaced.
        colour: quantity shown by colours: ``"deflection"`` of all parts; or of beams only ``"stress"`` (von Mises), ``"axial"``
            (force) or ``"euler"`` (N/N_Euler).
        view: direction of view: ``"home"``, ``"front"``, ``"side"`` or ``"top"``.
        mode: number of the drawn mode, from 1.
        size: width and height [pixels].

    Raises:
        ArgumentError: no pose could be analysed, there are more than 1000 poses, an argument is invalid, or the file cannot be
            written.
        KinetostaticsError: there is no Chromium.
    """
    save_screenshot(_page(result, title, pose, exaggeration, False, compare, mode, False), path, size, colour, view)


def _page(
    result: Result | Configuration | Robot | UnloadedPose | Modes,
    title: str | None,
    pose: int | tuple[int, ...] | None,
    exaggeration: float | None,
    by_mechanism: bool,
    compare: Result | None,
    mode: int = 1,
    computes: bool = True,
    vary: Mapping[str, object] | None = None,
) -> str:
    if compare is not None and not isinstance(compare, Result):
        raise ArgumentError(f"compare= needs a Result, got {compare!r}: ks.analyze(robot.assemble())")
    if compare is not None and vary is not None:
        raise ArgumentError("vary= varies one robot, and compare= shows two: leave one of them out")
    drawn = _drawable(result, pose)
    if isinstance(drawn, SinglePose) and (compare is not None or by_mechanism):
        raise ArgumentError("compare= and by_mechanism= need a result, and this pose is drawn without loads: leave them out")
    count = len(drawn.contribution_names) if isinstance(drawn, ModePoses) else 1
    if mode not in range(1, count + 1):
        raise ArgumentError(f"mode is {mode!r}; it must be the number of a mode that is shown, 1 to {count}")

    def scene_of(drawing: Result | SinglePose, title: str | None, every: int) -> Scene:
        shown = drawing.by_mechanism if by_mechanism and isinstance(drawing, Result) else drawing
        return describe_scene(shown, title, pose=pose, exaggeration=exaggeration, every=every)

    def scene(every: int) -> Scene:
        second = None if compare is None else scene_of(compare, None, every)
        first = scene_of(drawn, title, every)
        return replace(first, first=mode - 1, compare=second, notes=[*first.notes, *notes])

    with waiting("making the page"):
        engine, notes = _engine(drawn, by_mechanism, vary) if computes and compare is None else (None, [])
        return fitting_page(scene, engine=engine)


def _engine(
    drawn: Result | SinglePose, by_mechanism: bool, vary: Mapping[str, object] | None
) -> tuple[dict[str, object] | None, list[str]]:
    """Return code and data with which the page of a single result computes; None and, of such a page, the reason if it cannot."""
    if not isinstance(drawn, Result) or drawn.shape != () or drawn.point is not None:
        if vary is not None:
            raise ArgumentError("vary= needs one result of one pose with o as reference point")
        return None, []
    from kinetostatics.engine.scalars import NotRecordedError
    from kinetostatics.viewer.computing import computing_page

    try:
        return computing_page(drawn, by_mechanism, vary), []
    except NotRecordedError as error:
        if vary is not None:
            raise ArgumentError(f"vary= needs a page that computes, and this one does not: {error}") from None
        return None, [f"this page shows one pose and computes no others: {error}"]


def _drawable(given: object, pose: int | tuple[int, ...] | None = None) -> Result | SinglePose:
    """Return a result unchanged, and for modes, a pose or a robot the :class:`SinglePose` to be drawn."""
    if isinstance(given, Result):
        return given
    if isinstance(given, Modes):
        return ModePoses(given, pose)
    if pose is not None:
        raise ArgumentError("pose= needs a Result or Modes; a pose is drawn without loads: leave it out")
    if isinstance(given, UnloadedPose):
        return given
    if isinstance(given, Robot) or (isinstance(given, Configuration) and given.shape == () and given.reached.all()):
        return UnloadedPose(given)
    raise ArgumentError(f"a picture needs a Result, Modes, a Robot or one reached Configuration, got {given!r}")


def open_browser(address: str) -> None:
    """Open an address in the browser, or print it on standard error if no browser can be started."""
    with pausing():  # some browsers run in the terminal
        if not webbrowser.open(address):
            print(f"no browser could be started; open this address yourself: {address}", file=sys.stderr)


def _temporary_file(html: str, name: str) -> Path:
    """Write a page to a temporary file that remains when the program ends."""
    safe = "".join(c if c.isalnum() or c in "-_" else "_" for c in name)
    handle, path = tempfile.mkstemp(prefix=f"kinetostatics_{safe}_", suffix=".html")
    os.close(handle)
    write_text(path, html)
    return Path(path)
