"""Links between two moving joints, which can become beams: length, mass, and the tube that has this mass."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinetostatics.authoring.file_arguments import MATERIALS
from kinetostatics.checks.input_warnings import STUBBY, WIRE
from kinetostatics.description.joint_types import JOINT_TYPES
from kinetostatics.description.joints import Joint
from kinetostatics.description.robot_description import RobotDescription

#: Suggested tubes: ratio of wall to outer diameter, material, and smallest ratio of length to diameter of the tube with the
#: mass of the link, which includes motors.
WALL, MATERIAL, SLENDER = 0.1, "aluminium", 1.5
#: Sine of the angle below which two axes are parallel.
PARALLEL = 1e-3


@dataclass(frozen=True)
class LinkSpan:
    """A link between two consecutive moving joints of the chain from base to platform.

    The last link ends at the joint that holds the platform, even if this joint is fixed. In a robot with loops, each link with
    exactly two moving joints or loops is a span.

    Attributes:
        start, end: names of the joints at the two ends, from base to platform; empty in a robot with loops.
        along: unit vector from start to end, in the link's frame, with all joints at zero.
        axis: axis of the joint at the start, in the link's frame.
        length: distance of the two joints with all joints at zero [m].
        mass: mass of the link, without links fixed to it [kg].
    """

    link: str
    start: str
    end: str
    along: NDArray[np.float64]
    axis: NDArray[np.float64]
    length: float
    mass: float

    @property
    def y_axis(self) -> NDArray[np.float64]:
        """Unit vector along the section's y: ``axis``, or else the link's x or y, projected on the plane normal to ``along``."""
        across = (axis - (axis @ self.along) * self.along for axis in (self.axis, *np.eye(3)))
        first = next(vector for vector in across if np.linalg.norm(vector) > PARALLEL)
        return np.asarray(first / np.linalg.norm(first))

    @property
    def tube(self) -> tuple[float, float] | None:
        """Outer and inner diameter [m] of a tube with the link's mass; a thicker tube is reduced to length/``STUBBY``.

        None if the link has no mass, or if the length is not between ``SLENDER`` and ``WIRE`` diameters of a tube with this mass.
        """
        if self.mass <= 0:
            return None
        area = self.mass / (MATERIALS[MATERIAL][2] * self.length)
        outer = math.sqrt(area / (math.pi * WALL * (1 - WALL)))
        if not SLENDER * outer <= self.length <= WIRE * outer:
            return None
        outer = min(float(f"{outer:.2g}"), _rounded_down(self.length / STUBBY))
        return outer, float(f"{(1 - 2 * WALL) * outer:.6g}")


def _rounded_down(value: float) -> float:
    """Round a positive number down to two significant digits."""
    digit: float = 10.0 ** (math.floor(math.log10(value)) - 1)
    return float(f"{math.floor(value / digit * (1 + 1e-12)) * digit:.2g}")


def chain_joints(description: RobotDescription) -> list[tuple[Joint, bool]]:
    """Return (joint, outwards) from base to platform; ``outwards``: whether the joint's child is on the side of the platform."""
    above = {joint.child: joint for joint in description.joints.values()}

    def to_root(link: str) -> list[Joint]:
        joints = []
        while link in above:
            joints.append(above[link])
            link = above[link].parent
        return joints

    up, down = to_root(description.base), to_root(description.platform)
    while up and down and up[-1] is down[-1]:
        del up[-1], down[-1]
    return [*((joint, False) for joint in up), *((joint, True) for joint in reversed(down))]


def spans(description: RobotDescription, frames: Mapping[str, NDArray[np.float64]]) -> dict[str, LinkSpan]:
    """Return by name the links that can become beams, from the frames (4, 4) of all links with all joints at zero.

    Without loops, there is one link between any two consecutive moving joints of the chain from base to platform: the heaviest of
    the links that are fixed to each other there. If a fixed joint holds the platform, the last link ends at this joint. With
    loops, all links with exactly two moving joints or loops are returned.
    """
    if description.loops:
        return _spans_with_loops(description)
    passed = chain_joints(description)
    ends = [k for k, (joint, _) in enumerate(passed) if not JOINT_TYPES[joint.type].is_fixed]
    if ends and ends[-1] < len(passed) - 1:
        ends.append(len(passed) - 1)
    candidates: dict[str, LinkSpan] = {}
    for first, last in itertools.pairwise(ends):
        links = [joint.child if down else joint.parent for joint, down in passed[first:last]]
        link = max(links, key=lambda name: description.links[name].mass)
        start, end = passed[first][0], passed[last][0]
        into = np.linalg.inv(frames[link])
        first_point, last_point = ((into @ frames[joint.child])[:3, 3] for joint in (start, end))
        along = last_point - first_point
        length = float(np.linalg.norm(along))
        if length > 0:
            axis = into[:3, :3] @ frames[start.child][:3, :3] @ np.array(start.axis)
            candidates[link] = LinkSpan(link, start.name, end.name, along / length, axis, length, description.links[link].mass)
    return candidates


def _spans_with_loops(description: RobotDescription) -> dict[str, LinkSpan]:
    """Return the links with exactly two moving joints or loops, except base and platform."""
    ends: dict[str, list[tuple[NDArray[np.float64], str, tuple[float, float, float]]]] = {}
    for joint in (joint for joint in description.joints.values() if not JOINT_TYPES[joint.type].is_fixed):
        ends.setdefault(joint.parent, []).append((joint.origin.matrix, joint.type, joint.axis))
        ends.setdefault(joint.child, []).append((np.eye(4), joint.type, joint.axis))
    for loop in description.loops.values():
        ends.setdefault(loop.predecessor, []).append((loop.predecessor_origin.matrix, loop.type, loop.axis))
        ends.setdefault(loop.successor, []).append((loop.successor_origin.matrix, loop.type, loop.axis))
    candidates: dict[str, LinkSpan] = {}
    for link, held in ends.items():
        if len(held) != 2 or link in (description.base, description.platform):
            continue
        (first, _, axis), (last, _, _) = sorted(held, key=lambda end: not JOINT_TYPES[end[1]].has_axis)
        along = last[:3, 3] - first[:3, 3]
        length = float(np.linalg.norm(along))
        if length > 0:
            candidates[link] = LinkSpan(link, "", "", along / length, first[:3, :3] @ axis, length, description.links[link].mass)
    return candidates
