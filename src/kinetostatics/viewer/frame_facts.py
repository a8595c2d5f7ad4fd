"""Permanent text of a page: pose, gravity, load and status of every frame, and the units of displacements."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.layout.numbers import ANGLES, LENGTHS, NumberFormat, largest
from kinetostatics.math.arrays import Array
from kinetostatics.reports.pose import facts_of, platform_coordinates
from kinetostatics.statics.link_loads import PAYLOAD
from kinetostatics.viewer.applied_loads import about_point, loads_on_links
from kinetostatics.viewer.packing import plain_scale
from kinetostatics.viewer.shown_poses import ShownPoses
from kinetostatics.viewer.standing import StandingPose


@dataclass(frozen=True, eq=False)
class FrameFacts:
    """The pose and what acts on it, in every frame of a path.

    Attributes:
        pose: name, unit and (F,) values of the platform's coordinates.
        gravity: (F, 3) world axes [m/s²].
        load: (F, 6) about o, world axes [N, N·m]; None, as gravity, of a pose without loads.
        on_links: (F, 6) loads on links, each about the point where it acts, world axes [N, N·m], by name.
        payload: (F,) mass [kg] and (F, 3) centre [m] in the frame of a link, or in o-xyz (None); None: there is none.
        status: (F,) status words, the worst first.
        displacement, rotation: units of displacements and rotations, of legend and tables alike.
    """

    pose: list[tuple[str, str, Array]]
    gravity: Array | None
    load: Array | None
    on_links: dict[str, Array]
    payload: tuple[Array, Array, str | None] | None
    status: list[str]
    displacement: NumberFormat
    rotation: NumberFormat

    def told(self, frame: int) -> list[tuple[str, str]]:
        """Return names and words of what stands on the page in a frame, its status last."""
        found = []
        if self.pose:
            pose = (f"{name} {_rounded(values[frame])}{'' if unit == '°' else ' '}{unit}" for name, unit, values in self.pose)
            found.append(("pose", ", ".join(pose)))
        if self.gravity is not None and self.load is not None:
            found += [("gravity", f"{_vector(self.gravity[frame])} m/s²"), ("load at o", _wrench(self.load[frame]))]
        found += [(name, _wrench(wrench[frame])) for name, wrench in self.on_links.items()]
        if self.payload is not None:
            mass, center, link = self.payload
            where = f"{_vector(1e3 * center[frame])} mm in the frame of {link or 'o'}"
            found.append(("payload", f"{_short(mass[frame])} kg at {where}"))
        return [*found, ("status", self.status[frame])]

    def plain(self) -> list[list[tuple[str, str]]]:
        """Return :meth:`told` of every frame."""
        return [self.told(frame) for frame in range(len(self.status))]

    def units(self) -> dict[str, object]:
        """Return the units as JSON wants them."""
        return {"displacement": plain_scale(self.displacement), "rotation": plain_scale(self.rotation)}


def _rounded(value: float) -> str:
    """Return a coordinate in mm or degrees, without zeros at the end."""
    return f"{round(float(value), 2) + 0.0:.15g}".replace("-", "−")


def _short(value: float) -> str:
    """Return a load in up to five digits, without zeros at the end."""
    return f"{0.0 if abs(value) < 5e-6 else float(f'{value:.5g}'):.15g}".replace("-", "−")


def _vector(values: Array) -> str:
    return f"({', '.join(map(_short, values))})"


def _wrench(values: Array) -> str:
    return f"{_vector(values[:3])} N" + (f", {_vector(values[3:])} N·m" if np.any(values[3:]) else "")


def find_facts(poses: ShownPoses, displacements: Array, size: float) -> FrameFacts:
    """Return the facts of the shown poses of a robot of a size [m]; ``displacements`` (…, 3) [m] are all that colours tell."""
    result = poses.result
    pose = _coordinates(result.configuration, lambda values: poses.of_configuration(values, 0))
    status = [["OK"] for _ in range(poses.count)]
    for title, where, words in facts_of(result):
        for frame in np.flatnonzero(poses.take(where.astype(np.float64))):
            status[frame].insert(0, f"{title}, {words}")
    shift = float(np.linalg.norm(displacements, axis=-1).max(initial=0.0))
    twists = poses.platform_twist[..., 3:]
    return FrameFacts(
        pose, poses.take(result.gravity), poses.take(result.load), _on_links(poses, size), _payload(poses),
        ["; ".join(words[: max(1, len(words) - 1)]) for words in status],
        NumberFormat.of(shift, LENGTHS, digits=4),
        NumberFormat.of([largest([twists]), largest([twists.sum(axis=1)])], ANGLES, digits=4),
    )  # fmt: skip


def facts_without_loads(poses: StandingPose) -> FrameFacts:
    """Return the facts of a pose without loads: its coordinates, where the loops are closed."""
    pose = [] if poses.configuration is None else _coordinates(poses.configuration, lambda values: values.reshape(1))
    formats = NumberFormat.of(0.0, LENGTHS, digits=4), NumberFormat.of([0.0], ANGLES, digits=4)
    return FrameFacts(pose, None, None, {}, None, ["OK"], *formats)


def _coordinates(configuration: Configuration, taken: Callable[[Array], Array]) -> list[tuple[str, str, Array]]:
    """Return name, unit and shown values (F,) of the platform's coordinates."""
    found = []
    for name, (values, ((unit, factor),), noise) in platform_coordinates(configuration).items():
        along = taken(values)
        found.append((name, unit, np.where(np.abs(along) <= noise, 0.0, along) / factor))
    return found


def _on_links(poses: ShownPoses, size: float) -> dict[str, Array]:
    found: dict[str, Array] = {}
    for name, _, point, wrench in loads_on_links(poses, ("load",)):
        if name != PAYLOAD:  # an end of a beam may be another place at another pose
            found[name] = found.get(name, 0.0) + about_point(wrench, point, poses.o, size)
    return found


def _payload(poses: ShownPoses) -> tuple[Array, Array, str | None] | None:
    payload = poses.result.payload
    if payload is None:
        return None
    mass, center = (np.asarray(value, dtype=np.float64) for value in (payload.mass, payload.center))
    return poses.of_configuration(mass, 0), poses.of_configuration(center, 1), payload.link
