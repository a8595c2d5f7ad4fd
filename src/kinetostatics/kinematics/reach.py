"""How far straight lines of coordinates can be followed: up to a joint's limit, a singular pose, or where the loops open."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from kinetostatics.kinematics.assembly import SolverChoice, assemble, by_numpy
from kinetostatics.kinematics.configuration import Configuration, taken
from kinetostatics.math.arrays import Array

#: Parts into which each line is cut at first, and then what is left between its last good pose and its first bad one.
FIRST, NEXT = 32, 24
#: Part of a line to which its end is found.
FINE = 6e-5


@dataclass(frozen=True)
class End:
    """Where a line of coordinates ends.

    Attributes:
        part: of the line that is good, 0 … 1.
        reason: "limit" of a joint; "singular", where the locked actuators would not hold the platform; "loops", which cannot be
            closed from there on; or "" where nothing is in the way.
        joint: whose limit, or cone, it is, and that ``limit`` [m, rad].
    """

    part: float
    reason: str = ""
    joint: str = ""
    limit: float = math.nan


def find_ends(
    pose: Configuration,
    kind: str,
    ways: Mapping[str, Array],
    orientation: str | None = None,
    chosen: SolverChoice = by_numpy,
    go_on: Callable[[], bool] = lambda: True,
) -> list[End]:
    """Return where straight lines of coordinates end, which all start at a pose.

    All lines are searched at once, coarsely and then finer. Limits that the pose itself exceeds do not count, and from a singular
    pose the actuators' singular poses do not.

    Args:
        pose: one pose.
        kind: "platform" or "actuators".
        ways: how far (L,) each line leads along each of the coordinates that determine the pose [m, rad].
        orientation, chosen: as in :func:`.assembly.assemble`.
        go_on: asked before each search; where it says no, nothing is returned.
    """
    present = pose.platform_coordinates(orientation) if kind == "platform" else pose.actuators
    count = next((len(way) for way in ways.values()), 0)
    low, high, ends = np.zeros(count), np.ones(count), [End(1.0)] * count
    near, parts = pose, FIRST
    while count and np.max(high - low) > FINE:
        if not go_on():
            return []
        along = low[:, None] + (high - low)[:, None] * np.linspace(0, 1, parts + 1)
        given = {name: float(present[name]) + along * way[:, None] for name, way in ways.items()}
        actuators, platform = (None, given) if kind == "platform" else (given, None)
        found = assemble(pose.robot, actuators, platform, orientation, near, pose.closure_tolerance, "nan", chosen)
        last = np.full(count, parts)
        for n, line in enumerate(_reasons(found, pose)):
            first = next((k for k, end in enumerate(line) if k and end is not None), None)
            if first is not None:
                last[n], ends[n] = first - 1, line[first] or ends[n]
            low[n], high[n] = along[n, last[n]], along[n, last[n] if first is None else first]
        near = taken(found, np.repeat(np.arange(count) * (parts + 1) + last, NEXT + 1), (count, NEXT + 1))
        parts = NEXT
    return [replace(end, part=float(part)) for end, part in zip(ends, low, strict=True)]


def _reasons(found: Configuration, pose: Configuration) -> list[list[End | None]]:
    """Return what is wrong with each pose (L, n) along lines, None where nothing is."""
    robot, (count, n) = pose.robot, found.shape
    reasons: list[End | None] = [None] * (count * n)
    prescribed = robot.actuator_coordinates
    if robot.mobility_analysis.fixes_platform_at(prescribed, pose.poses):
        before = np.maximum(np.arange(count * n) - (np.arange(count * n) % n > 0), 0)
        alike = robot.solver.on_one_side(prescribed, found.poses.take(before), found.poses, np.zeros((prescribed.size, 1)))
        for k in np.flatnonzero(~alike):
            reasons[k] = End(0.0, "singular")
    for joint, item in found.limits_exceeded.items():
        if joint not in pose.limits_exceeded:
            for k in np.flatnonzero(item.where):
                value = float(item.value.flat[k])
                reasons[k] = End(0.0, "limit", joint, item.lower if value < item.lower else item.upper)
    for k in np.flatnonzero(~found.reached):
        reasons[k] = End(0.0, "loops")
    return [reasons[n * k : n * (k + 1)] for k in range(count)]
