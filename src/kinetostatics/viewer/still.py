"""The initial picture of a page in numbers: poses, colours, arrows, floor and camera of a scene's first frame."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from kinetostatics.math.arrays import Array
from kinetostatics.viewer.description import AXES, FIELD_OF_VIEW, HIDDEN, RAMP, RESTING, UNKNOWN, VIEW, Arrow, Mesh, Scene
from kinetostatics.viewer.shapes import Surface, arrow, frames_along

#: Deflections below this part of the robot's size are rounding errors.
RIGID = 1e-12
#: Approximate distance of the floor's lines as a part of the robot's size, rounded down to 1, 2 or 5 times a power of ten.
SQUARE = 0.15
#: Numbers in a decade to which the end of the colour scale is rounded up.
ROUND = (1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10)


@dataclass(frozen=True, eq=False)
class StillArrow:
    """An arrow of one frame.

    Attributes:
        arrow: the arrow of the scene.
        value: value in its label [N, N·m].
        surface: surface along z, with the tail at the origin.
        colour: "#rrggbb".
        free_end: z of the end for its label [m].
        frame: (4, 4) its axes, and its origin relative to the point of attachment.
    """

    arrow: Arrow
    value: float
    surface: Surface
    colour: str
    free_end: float
    frame: Array

    def placed(self, poses: Array) -> Array:
        """Return its transform (4, 4) for stations at ``poses`` (n, 4, 4)."""
        at = poses[self.arrow.station]
        found = self.frame.copy()
        found[:3, 3] += at[:3, 3] + at[:3, :3] @ self.arrow.offset
        return found

    def place_of_name(self, poses: Array) -> Array:
        """Return the position (3,) of its label, at its free end."""
        at = self.placed(poses)
        return np.asarray(at[:3, 3] + self.free_end * at[:3, 2])


@dataclass(frozen=True, eq=False)
class Camera:
    """Position of the camera.

    Attributes:
        target: (3,) point at the centre of the picture [m].
        direction: (3,) unit vector from the target to the camera.
        distance: distance from the target to the camera [m].
    """

    target: Array
    direction: Array
    distance: float


class Still:
    """The first frame of a scene with the initial shares of its contributions.

    Attributes:
        scene: the scene.
        rest, deformed: (n, 4, 4) poses of the stations; ``deformed`` with the scene's exaggeration.
        deflections: (n,) true displacements |u + θ × r| [m] of the vertices of coloured meshes, by path.
        largest: largest deflection [m], 0 for a rigid robot, with its station and vertex (3,).
        high: deflection at the end of the colour scale [m].
        arrows: arrows of visible length.
    """

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.rest, self.deformed = self.moved(0.0), self.moved(1.0)
        self.twists = np.einsum("nki,k->ni", scene.stations.all_twists[0], scene.shares)
        coloured = [mesh for mesh in scene.meshes if "Deformed" in mesh.roots and _is_coloured(mesh, "Deformed")]
        self.deflections = {mesh.path: self._deflections(mesh, mesh.surface.vertices) for mesh in coloured}
        corners = [
            float(self._deflections(mesh, _corners(mesh.surface.vertices)).max())
            for mesh in coloured
            if isinstance(mesh.station, int)
        ]
        most = max(
            [*corners, *(float(found.max()) for found in self.deflections.values()), *np.linalg.norm(self.twists[:, :3], axis=-1)]
        )
        rigid = most < RIGID * scene.size
        self.high = round_up(0.0 if rigid else most)
        self.largest = (0.0, scene.readout, np.zeros(3))
        for mesh in [] if rigid else coloured:
            vertex = int(np.argmax(self.deflections[mesh.path]))
            if self.deflections[mesh.path][vertex] > self.largest[0]:
                station = np.broadcast_to(mesh.station, len(mesh.surface.vertices))[vertex]
                self.largest = float(self.deflections[mesh.path][vertex]), int(station), mesh.surface.vertices[vertex]
        self.arrows = list(self._arrows())

    def moved(self, part: float) -> Array:
        """Return the stations' poses (n, 4, 4) between rest (0) and deformed (1)."""
        return self.scene.stations.moved(0, part * self.scene.exaggeration, self.scene.shares)

    def vertices(self, mesh: Mesh, root: str) -> Array:
        """Return the vertices (n, 3) of a mesh at one of its roots, world axes [m]."""
        at = (self.deformed if root == "Deformed" else self.rest)[np.broadcast_to(mesh.station, len(mesh.surface.vertices))]
        return np.asarray(np.einsum("nij,nj->ni", at[:, :3, :3], mesh.surface.vertices) + at[:, :3, 3])

    def _deflections(self, mesh: Mesh, points: Array) -> Array:
        """Return the true displacements (n,) [m] of points (n, 3) of a mesh in station coordinates."""
        station = np.broadcast_to(mesh.station, len(points))
        arms = np.einsum("nij,nj->ni", self.rest[station, :3, :3], points)
        twists = self.twists[station]
        return np.asarray(np.linalg.norm(twists[:, :3] + np.cross(twists[:, 3:], arms), axis=-1))

    def look(self, mesh: Mesh, root: str) -> str | Array:
        """Return the colour of a mesh at one of its roots: "#rrggbb", or (n, 3) one for every vertex, 0 to 1."""
        if root == "Rest":
            return RESTING[0]
        if _is_coloured(mesh, root):
            return ramp_colours(self.deflections[mesh.path] / self.high)
        return UNKNOWN if isinstance(mesh.colour, str) and mesh.colour == "deflection" else mesh.colour

    def _arrows(self) -> Iterator[StillArrow]:
        for described, metres_per_unit, radius, colour in self.scene.scaled_arrows():
            vector = described.vector[0].T @ [*self.scene.shares, 1.0]
            size = float(np.linalg.norm(vector))
            length = size * metres_per_unit
            if length <= 0.2 * radius:
                continue
            value = -size if described.positive is not None and described.positive[0] @ vector < 0 else size
            if isinstance(described.anchor, str):
                inwards = described.anchor == "tip"
            else:
                inwards = bool(described.anchor[0] @ vector < -0.1 * np.linalg.norm(described.anchor[0]) * size)
            frame = frames_along(vector[None])[0]
            frame[:3, 3] = -inwards * metres_per_unit * vector
            surface = arrow(length, radius, 1 if described.kind == "force" else 2)
            yield StillArrow(described, value, surface, colour, 0.0 if inwards else length, frame)

    # ---- floor and camera --------------------------------------------------------------------------------------------

    def outline(self) -> Array:
        """Return points (n, 3) that a picture must contain: vertices, and ends of initially visible arrows and axes."""
        points = [
            self.vertices(mesh, root)[:: 1 + len(mesh.surface.vertices) // 2000]
            for mesh in self.scene.meshes
            for root in mesh.roots
        ]
        for item in self.arrows:
            if item.arrow.group not in HIDDEN:
                at = item.placed(self.deformed)
                points.append(at[:3, 3] + np.outer([0.0, np.ptp(item.surface.vertices[:, 2])], at[:3, 2]))
        for _, station, _ in self.scene.frames:
            at = self.deformed[station]
            points.append(at[:3, 3] + AXES * self.scene.size * at[:3, :3].T)
        return np.concatenate(points)

    def floor(self) -> tuple[Array, float]:
        """Return the ends (2 n, 3) of the floor's lines below the robot, and the length of a square's side [m]."""
        points = self.outline()
        low, high = points.min(axis=0), points.max(axis=0)
        power = 10 ** math.floor(math.log10(SQUARE * self.scene.size))
        side = max(step for step in (1, 2, 5) if step * power <= SQUARE * self.scene.size) * power
        middle = np.round((low + high)[:2] / 2 / side) * side
        count = math.ceil(0.75 * self.scene.size / side)
        lines = side * np.arange(-count, count + 1)
        end = np.full_like(lines, side * count)
        across = np.stack([np.stack([lines, -end], axis=1), np.stack([lines, end], axis=1)], axis=1).reshape(-1, 2)
        plane = np.concatenate([across, across[:, ::-1]]) + middle
        return np.column_stack([plane, np.full(len(plane), low[2] - 2e-3 * self.scene.size)]), side

    def camera(self, aspect: float, above: float, below: float) -> Camera:
        """Return the camera for which the robot fills the picture, except the parts ``above`` and ``below`` of its height."""
        points = self.outline()
        centre = (points.min(axis=0) + points.max(axis=0)) / 2
        d = np.array(VIEW) / np.linalg.norm(VIEW)
        right = np.cross([0.0, 0.0, 1.0], d) / np.linalg.norm(np.cross([0.0, 0.0, 1.0], d))
        up = np.cross(d, right)
        across, along, towards = np.stack([right, up, d]) @ (points - centre).T
        half = math.tan(math.radians(FIELD_OF_VIEW) / 2)
        fits = []  # visible: low (D - z) <= x - s <= high (D - z), linear in the camera's shift s and distance D
        for x, low, high in ((across, -aspect, aspect), (along, 2 * below - 1, 1 - 2 * above)):
            most, least = float((x + high * half * towards).max()), float((x + low * half * towards).min())
            fits.append(((most - least) / ((high - low) * half), most, least, low * half, high * half))
        distance = 1.04 * max(fit[0] for fit in fits)
        shifts = [(most + least - (low + high) * distance) / 2 for _, most, least, low, high in fits]
        target = centre + shifts[0] * right + shifts[1] * up
        return Camera(target, d, distance)


def ramp_colours(parts: Array) -> Array:
    """Return the colours (n, 3), 0 to 1, at parts (n,) of the scale."""
    ramp = np.array([[int(colour[n : n + 2], 16) / 255 for n in (1, 3, 5)] for colour in RAMP])
    return np.column_stack([np.interp(parts, np.linspace(0, 1, len(RAMP)), channel) for channel in ramp.T])


def round_up(value: float) -> float:
    """Return the smallest number of ROUND not below a value; 1e-6 for zero, as in the page."""
    if not value > 0:
        return 1e-6
    power = 10.0 ** math.floor(math.log10(value))
    return next(step * power for step in ROUND if step * power >= value * (1 - 1e-6))


def _corners(points: Array) -> Array:
    """Return the corners (8, 3) of the bounding box of points (n, 3)."""
    ends = np.stack([points.min(axis=0), points.max(axis=0)])
    return np.stack([ends[[k & 1, k >> 1 & 1, k >> 2], range(3)] for k in range(8)])


def _is_coloured(mesh: Mesh, root: str) -> bool:
    """Return whether a mesh is coloured by the deflection."""
    return root == "Deformed" and isinstance(mesh.colour, str) and mesh.colour == "deflection"
