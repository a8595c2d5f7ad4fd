"""Topics of the page: comparison of maps with OpenSeesPy, natural frequencies, and :mod:`scaling`."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import clocks
import grids
import numpy as np
import opensees_frames
import scaling
from page import Page, micro, report, table, times

import kinetostatics as ks
from kinetostatics.load_case import LoadCase
from kinetostatics.verification import worker
from kinetostatics.verification.frame_model import build
from kinetostatics.verification.frequencies import frame_with_masses
from kinetostatics.verification.opensees import PENALTY, FrameUnits, frame_of

#: Robots of the page: the paper's, and some of each kind.
SOME = ("3rps", "2pru_upr", "gough_stewart", "spherical_3rrr", "delta", "orthoglide", "ur10", "anymal_standing")


@dataclass(frozen=True)
class Effort:
    """How much is measured.

    Attributes:
        poses: of a grid.
        frames: how many of them OpenSees solves.
        repeats: how often everything is measured.
        sizes: of the maps in processes of their own, each with its repeats.
        robots: which are compared with OpenSees.
    """

    poses: int
    frames: int
    repeats: int
    sizes: tuple[tuple[int, int], ...]
    robots: tuple[str, ...] = SOME


FULL = Effort(20_000, 20, 3, ((5_000, 6), (20_000, 5), (100_000, 2), (1_000_000, 1)))
QUICK = Effort(20_000, 10, 1, ((5_000, 3), (20_000, 2), (100_000, 1)))
TINY = Effort(200, 2, 1, ((300, 1),), ("3rps", "five_bar"))

#: How OpenSees is asked.
WAYS = (("plain", "A, as `verify` asks it"), ("all_cases", "B, all numbers, lean"), ("one", "C, one analysis, lean"))
#: A penalty in the middle of those that `kinetostatics verify` extrapolates from, and its trace of stiffness of free directions.
LEVEL = (8 * PENALTY, 1e-11)
#: Elements of a beam for natural frequencies.
ELEMENTS = 3


# ---- OpenSees ------------------------------------------------------------------------------------------------------------


def compare(name: str, effort: Effort, solver: opensees_frames.OpenSees) -> dict[str, Any]:
    """Return times per pose of one robot [s].

    Returns:
        "poses" of the grid; "ours": loops closed, and all numbers of a map, and its "parts": loops, statics, arrays; "sweep": the
        same by ``ks.sweep``; OpenSees in its :data:`WAYS`; "difference" of the twists of C and ours, largest relative.
    """
    robot, workspace = grids.load(name), grids.WORKSPACES[name]
    axes = workspace.axes(effort.poses)
    coordinates = grids.mesh(axes)
    size = scaling.count_of(axes)
    some = np.linspace(0, size - 1, effort.frames).astype(int)
    poses = [grids.assemble(robot, workspace, {key: float(v.ravel()[k]) for key, v in coordinates.items()}) for k in some]
    lean = [opensees_frames.frame_of(pose, grids.LOAD) for pose in poses]
    models = [build(pose, LoadCase(grids.LOAD)) for pose in poses]
    plain = [frame_of(model, FrameUnits(model), [model.platform]) for model in models]
    stages: list[Any] = []
    best = clocks.interleaved(
        {
            "one": lambda: [solver.solve(frame) for frame in lean],
            "ours": lambda: stages.append(_in_stages(robot, workspace, coordinates)),
            "all_cases": lambda: [solver.solve_all(frame) for frame in lean],
            "sweep": lambda: grids.sweep(robot, workspace, axes),
            "plain": lambda: [worker.solve(solver.ops, frame, *LEVEL) for frame in plain],
        },
        effort.repeats,
    )
    differences = []
    unit = np.repeat([1.0, robot.length], 3)
    for pose, frame in zip(poses, lean, strict=True):
        ours = ks.analyze(pose, grids.LOAD).twist * unit
        differences.append(float(np.linalg.norm(np.array(solver.solve(frame)[0]) * unit - ours) / np.linalg.norm(ours)))
    found = {key: value / (size if key in ("ours", "sweep") else effort.frames) for key, value in best.items()}
    return {**found, "poses": size, "parts": min(stages, key=sum) / size, "difference": max(differences)}


def _in_stages(robot: ks.Robot, workspace: grids.Workspace, coordinates: Any) -> Any:
    """Compute a map, and return what closing the loops, statics and making the arrays take [s]."""
    at = [time.process_time()]
    configuration = grids.assemble(robot, workspace, coordinates)
    at.append(time.process_time())
    result = ks.analyze(configuration, grids.LOAD)
    at.append(time.process_time())
    grids.map_numbers(result)
    return np.diff([*at, time.process_time()])


def opensees(page: Page, effort: Effort) -> None:
    """All robots beside OpenSeesPy."""
    solver = opensees_frames.OpenSees()
    found, ratios = {}, {}
    for name in effort.robots:
        found[name] = item = compare(name, effort, solver)
        ratios[name] = {way: item[way] / item["ours"] for way, _ in WAYS}
        report(f"{name}: {micro(item['ours'])} µs, OpenSees {micro(item['plain'])}")
    rows = [
        (
            *(
                f"`{name}`",
                f"{item['poses']:,}",
                micro(item["ours"]),
                " + ".join(map(micro, item["parts"])),
                micro(item["sweep"]),
            ),
            *(micro(item[way]) for way, _ in WAYS),
            *map(times, ratios[name].values()),
            f"{item['difference']:.0e}",
        )
        for name, item in found.items()
    ]
    head = ("robot", "poses", "map", "loops + statics + arrays", "`ks.sweep`", "A", "B", "C")
    ranges = (sorted(item[way] for item in ratios.values()) for way, _ in WAYS)
    spans = (
        f"{times(values[0])} … {times(values[-1])} times as fast as {letter}"
        for letter, values in zip("ABC", ranges, strict=True)
    )
    text = f"OpenSees solved {effort.frames} poses of each grid. A map is {', '.join(spans)}."
    page.add("opensees", table((*head, "A : map", "B : map", "C : map", "difference"), rows), text)


# ---- natural frequencies -------------------------------------------------------------------------------------------------


def modes(page: Page, effort: Effort) -> None:
    """Three natural frequencies of many poses, and by OpenSees with three elements a beam and consistent masses."""
    ops, rows = opensees_frames.OpenSees().ops, []
    for name in effort.robots[:3]:
        robot, workspace = grids.load(name), grids.WORKSPACES[name]
        axes = workspace.axes(max(effort.poses // 20, 2))
        coordinates = grids.mesh(axes)
        pose, size = grids.assemble(robot, workspace, coordinates), scaling.count_of(axes)
        own = ks.modes(pose, 3).frequencies.reshape(-1, 3)
        frames, units = [], []
        some = np.linspace(0, size - 1, effort.frames).astype(int)
        for k in some:
            one = grids.assemble(robot, workspace, {key: float(v.ravel()[k]) for key, v in coordinates.items()})
            model = build(one, LoadCase(gravity=np.zeros(3)))
            scale, total = FrameUnits(model), sum(item.mass for item in model.masses)
            total += sum(beam.mass * beam.length for beam in model.beams)
            frames.append({**frame_with_masses(model, scale, total, ELEMENTS), "modes": 3})
            units.append(np.sqrt(scale.stiffness / total) / (2 * np.pi))
        best = clocks.interleaved(
            {
                "ours": partial(ks.modes, pose, 3),
                "sweep": partial(_swept, robot, workspace, axes),
                "theirs": partial(_eigenvalues, ops, frames),
            },
            effort.repeats,
        )
        theirs = np.sqrt(_eigenvalues(ops, frames)) * np.array(units)[:, None]
        gap = float(np.max(np.abs(theirs / own[some] - 1)))
        ours, eigen = best["ours"] / size, best["theirs"] / effort.frames
        numbers = (f"{1e3 * value:.2f}" for value in (ours, best["sweep"] / size, eigen))
        rows.append((f"`{name}`", f"{size:,}", *numbers, times(eigen / ours), f"{gap:.0e}"))
    head = ("robot", "poses", "`ks.modes`", "`ks.sweep`", "OpenSees", "OpenSees : `ks.modes`", "difference")
    page.add("modes", table(head, rows), clocks.origin())


def _eigenvalues(ops: Any, frames: list[Any]) -> list[list[float]]:
    return [worker.eigenvalues(ops, frame, *LEVEL)["squares"][0] for frame in frames]


def _swept(robot: ks.Robot, workspace: grids.Workspace, axes: Any) -> None:
    ks.sweep(robot, **{workspace.kind: axes}, orientation=workspace.orientation, outputs=(), modes=3, progress=False)


TOPICS: dict[str, Callable[[Page, Effort], None]] = {
    "opensees": opensees,
    "sizes": lambda page, effort: scaling.sizes(page, effort.sizes),
    "modes": modes,
}
