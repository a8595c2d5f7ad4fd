"""Workspace maps of all robots beside OpenSeesPy, and of the 3RPS beside Pinocchio."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import clocks
import grids
import numpy as np
import opensees_frames
import pinocchio as pin

import kinetostatics as ks
from kinetostatics.verification import worker
from kinetostatics.verification.model import build
from kinetostatics.verification.opensees import PENALTY, _frame, _Scale

#: A penalty in the middle of those that `kinetostatics verify` extrapolates from, and its trace of stiffness of free directions.
LEVEL = (8 * PENALTY, 1e-11)


@dataclass(frozen=True)
class Comparison:
    """Times per pose of one robot [s].

    Attributes:
        poses: of the grid.
        ours: loops closed, and all numbers of a map.
        sweep: the same by ``ks.sweep``, as a Dataset in memory, neighbours compared.
        one: OpenSees, one analysis.
        all_cases: OpenSees, what a map holds.
        plain: OpenSees, what ``kinetostatics verify`` asks of it at one penalty.
        difference: of the twists of OpenSees and ours, largest relative.
        parts: what ``ours`` consists of: loops, statics, arrays.
    """

    poses: int
    ours: float
    sweep: float
    one: float
    all_cases: float
    plain: float
    difference: float
    parts: tuple[float, float, float]


def compare(name: str, poses: int, frames: int, repeats: int, opensees: opensees_frames.OpenSees) -> Comparison:
    """Measure one robot.

    Args:
        name: of the robot.
        poses: of the grid, at least.
        frames: how many of them OpenSees solves.
        repeats: how often everything is measured.
        opensees: in this process.
    """
    robot, workspace = grids.load(name), grids.WORKSPACES[name]
    axes = workspace.axes(poses)
    coordinates = grids.mesh(axes)
    size = next(iter(coordinates.values())).size
    some = np.linspace(0, size - 1, frames).astype(int)
    single = [grids.assemble(robot, workspace, {key: float(v.ravel()[k]) for key, v in coordinates.items()}) for k in some]
    lean = [opensees_frames.frame_of(pose, grids.LOAD) for pose in single]
    models = [build(pose, np.array(grids.LOAD), opensees_frames.GRAVITY) for pose in single]
    plain = [_frame(model, _Scale(model)) for model in models]

    def each(solve: Callable[[Any], object], items: list[Any]) -> Callable[[], object]:
        return lambda: [solve(item) for item in items]

    stages: list[tuple[float, float, float]] = []
    best = clocks.interleaved(
        {
            "one": each(opensees.solve, lean),
            "ours": lambda: stages.append(_in_stages(robot, workspace, coordinates)),
            "all": each(opensees.solve_all, lean),
            "sweep": lambda: grids.sweep(robot, workspace, axes),
            "plain": each(lambda frame: worker.solve(opensees.ops, frame, *LEVEL), plain),
        },
        repeats,
    )
    return Comparison(
        size,
        best["ours"] / size,
        best["sweep"] / size,
        best["one"] / frames,
        best["all"] / frames,
        best["plain"] / frames,
        max(_difference(robot, pose, opensees.solve(frame)[0]) for pose, frame in zip(single, lean, strict=True)),
        min(((a / size, b / size, c / size) for a, b, c in stages), key=sum),
    )


def _in_stages(robot: ks.Robot, workspace: grids.Workspace, coordinates: Any) -> tuple[float, float, float]:
    """Compute a map, and return what closing the loops, statics and making the arrays take [s]."""
    clock = time.process_time
    at = [clock()]
    configuration = grids.assemble(robot, workspace, coordinates)
    at.append(clock())
    result = ks.analyze(configuration, grids.LOAD)
    at.append(clock())
    grids.map_numbers(result)
    at.append(clock())
    return at[1] - at[0], at[2] - at[1], at[3] - at[2]


def _difference(robot: ks.Robot, pose: ks.Configuration, theirs: list[float]) -> float:
    unit = np.repeat([1.0, robot.length], 3)
    ours = ks.analyze(pose, grids.LOAD).twist * unit
    return float(np.linalg.norm(np.array(theirs) * unit - ours) / np.linalg.norm(ours))


# ---- Pinocchio -------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Dynamics:
    """Times per pose [s] of ``rneaInParallel`` and of a map of the same poses; ``joints`` of the model."""

    poses: int
    joints: int
    rnea: float
    ours: float
    statics: float
    sweep: float


def compare_with_pinocchio(name: str, poses: int, repeats: int) -> Dynamics:
    """Measure Pinocchio's inverse dynamics in C++, one thread, of the model at the poses of a grid, in random order."""
    robot, workspace = grids.load(name), grids.WORKSPACES[name]
    axes = workspace.axes(poses)
    coordinates = grids.mesh(axes)
    pose = grids.assemble(robot, workspace, coordinates)
    model = robot.model
    q = pose.q.reshape(-1, model.nq)
    q = np.asfortranarray(np.random.default_rng(0).permutation(q).T)
    rest = np.zeros((model.nv, q.shape[1]), order="F")
    tau = np.zeros_like(rest)
    pool = pin.ModelPool(model, 1)
    best = clocks.interleaved(
        {
            "rnea": lambda: [pin.rneaInParallel(1, pool, q, rest, rest, tau) for _ in range(10)],
            "ours": lambda: grids.whole(robot, workspace, coordinates),
            "statics": lambda: grids.map_numbers(ks.analyze(pose, grids.LOAD)),
            "sweep": lambda: grids.sweep(robot, workspace, axes),
        },
        repeats,
    )
    size = q.shape[1]
    return Dynamics(
        size, model.njoints - 1, best["rnea"] / size / 10, best["ours"] / size, best["statics"] / size, best["sweep"] / size
    )
