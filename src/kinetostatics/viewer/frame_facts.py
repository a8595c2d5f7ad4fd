"""Heading of a page: pose, gravity, load and status of every frame; units of displacements."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.layout.numbers import ANGLES, LENGTHS, NumberFormat, largest
from kinetostatics.math.arrays import Array
from kinetostatics.reports.pose import facts_of, platform_coordinates
from kinetostatics.statics.link_loads import PAYLOAD
from kinetostatics.viewer.drawn_poses import ShownPoses, about_point, loads_on_links
from kinetostatics.viewer.packing import plain_scale
from kinetostatics.viewer.single_poses import SinglePose


@dataclass(frozen=True, eq=False)
class FrameFacts:
    """Pose, loads and status in every frame of a path.

    Attributes:
        pose: name, unit and (F,) values of the platform's coordinates.
        gravity: (F, 3) gravity, world axes [m/s²]; None for a pose without loads.
        load: (F, 6) load about o, world axes [N, N·m]; None for a pose without loads.
        on_links: (F, 6) loads on links about their points of application, world axes [N, N·m], by name.
        payload: (F,) mass [kg], (F, 3) centre [m], and the link of the centre's frame (None: o-xyz); None without payload.
        status: (F,) status texts, the most severe state first.
        displacement, rotation: number formats of displacements and rotations in legend and tables.
    """

    pose: list[tuple[str, str, Array]]
    gravity: Array | None
    load: Array | None
    on_links: dict[str, Array]
    payload: tuple[Array, Array, str | None] | None
    status: list[str]
    displacement: NumberFormat
    rotation: NumberFormat

    def lines(self, frame: int) -> list[tuple[str, str]]:
        """Return the lines of the heading in a frame, title and text; the status is last."""
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
        """Return the lines of all frames."""
        return [self.lines(frame) for frame in range(len(self.status))]

    def units(self) -> dict[str, object]:
        """Return the number formats as JSON data."""
        return {"displacement": plain_scale(self.displacement), "rotation": plain_scale(self.rotation)}


def _rounded(value: float) -> str:
    """Return a coordinate in mm or degrees, without trailing zeros."""
    return f"{round(float(value), 2) + 0.0:.15g}".replace("-", "−")


def _short(value: float) -> str:
    """Return a load with up to five digits, without trailing zeros."""
    return f"{0.0 if abs(value) < 5e-6 else float(f'{value:.5g}'):.15g}".replace("-", "−")


def _vector(values: Array) -> str:
    return f"({', '.join(map(_short, values))})"


def _wrench(values: Array) -> str:
    return f"{_vector(values[:3])} N" + (f", {_vector(values[3:])} N·m" if np.any(values[3:]) else "")


def find_facts(poses: ShownPoses, all_twists: Array, size: float) -> FrameFacts:
    """Return the heading of the shown poses; ``all_twists`` (F, n, K, 6) of stations determine the unit of the legend."""
    result = poses.result
    pose = _coordinates(result.configuration, lambda values: poses.of_configuration(values, 0))
    status = [["OK"] for _ in range(poses.count)]
    for title, where, words in facts_of(result):
        for frame in np.flatnonzero(poses.take(where.astype(np.float64))):
            status[frame].insert(0, f"{title}, {words}")
    shift = float(np.linalg.norm(all_twists.sum(axis=2)[..., :3], axis=-1).max(initial=0.0))
    twists = poses.platform_twist[..., 3:]
    return FrameFacts(
        pose, poses.take(result.gravity), poses.take(result.load), _on_links(poses, size), _payload(poses),
        ["; ".join(words[: max(1, len(words) - 1)]) for words in status],
        NumberFormat.of(shift, LENGTHS, digits=4),
        NumberFormat.of([largest([twists]), largest([twists.sum(axis=1)])], ANGLES, digits=4),
    )  # fmt: skip


def facts_without_loads(poses: SinglePose) -> FrameFacts:
    """Return the heading of a pose without loads: its coordinates, if the loops are closed."""
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
        if name != PAYLOAD:  # the loaded end of a beam may change along the path
            found[name] = found.get(name, 0.0) + about_point(wrench, point, poses.o, size)
    return found


def _payload(poses: ShownPoses) -> tuple[Array, Array, str | None] | None:
    payload = poses.result.payload
    if payload is None:
        return None
    mass, center = (np.asarray(value, dtype=np.float64) for value in (payload.mass, payload.center))
    return poses.of_configuration(mass, 0), poses.of_configuration(center, 1), payload.link
