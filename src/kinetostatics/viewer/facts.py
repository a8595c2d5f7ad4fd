"""What always stands on a page: pose, gravity, load and status of every frame, and the units of displacements."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from kinetostatics.math.arrays import Array
from kinetostatics.printing.text import ANGLES, LENGTHS, Scale, largest
from kinetostatics.reports.pose import facts_of, platform_coordinates
from kinetostatics.viewer.packing import Packing, plain_scale
from kinetostatics.viewer.poses import ShownPoses


@dataclass(frozen=True, eq=False)
class Facts:
    """The pose and what acts on it, in every frame of a path.

    Attributes:
        pose: name, unit and (F,) values of the platform's coordinates.
        gravity: (F, 3) world axes [m/s²].
        load: (F, 6) about o, world axes [N, N·m].
        status: (F,) status words, the worst first.
        displacement, rotation: units of displacements and rotations, of legend and tables alike.
    """

    pose: list[tuple[str, str, Array]]
    gravity: Array
    load: Array
    status: list[str]
    displacement: Scale
    rotation: Scale

    def plain(self, packing: Packing) -> dict[str, Any]:
        """Return it as JSON wants it."""
        return {
            "pose": [{"name": name, "unit": unit, "values": np.round(values, 6).tolist()} for name, unit, values in self.pose],
            "gravity": packing.path(self.gravity, 3), "load": packing.path(self.load, 6), "status": self.status,
        }  # fmt: skip

    def units(self) -> dict[str, Any]:
        """Return the units as JSON wants them."""
        return {"displacement": plain_scale(self.displacement), "rotation": plain_scale(self.rotation)}


def find_facts(poses: ShownPoses, displacements: Array) -> Facts:
    """Return the facts of the shown poses; ``displacements`` (…, 3) [m] are all that colours tell."""
    result, configuration = poses.result, poses.result.configuration
    pose = []
    for name, (values, ((unit, factor),), noise) in platform_coordinates(configuration).items():
        along = poses.of_configuration(values, 0)
        pose.append((name, unit, np.where(np.abs(along) <= noise, 0.0, along) / factor))
    status = [["OK"] for _ in range(poses.count)]
    for title, where, words in facts_of(result):
        for frame in np.flatnonzero(poses.take(where.astype(np.float64))):
            status[frame].insert(0, f"{title}, {words}")
    shift = float(np.linalg.norm(displacements, axis=-1).max(initial=0.0))
    twists = poses.platform_twist[..., 3:]
    return Facts(
        pose, poses.take(result.gravity), poses.take(result.load),
        ["; ".join(words[: max(1, len(words) - 1)]) for words in status],
        Scale.of(shift, LENGTHS, digits=4), Scale.of([largest([twists]), largest([twists.sum(axis=1)])], ANGLES, digits=4),
    )  # fmt: skip
