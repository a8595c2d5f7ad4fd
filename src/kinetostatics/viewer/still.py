"""The initial picture of a page: poses, colours, arrows, floor and camera as numbers; heading and legend as SVG.

The poses of stations are placements (4, 4) of coordinate systems that move with the robot.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from html import escape
from itertools import product

import numpy as np

from kinetostatics.math.arrays import Array
from kinetostatics.math.rotations import logarithm
from kinetostatics.viewer.description import AXES, FIELD_OF_VIEW, HIDDEN, RAMP, RESTING, UNKNOWN, VIEW, Arrow, Mesh, Scene
from kinetostatics.viewer.shapes import Surface, arrow, frames_along

#: A robot whose deflections are below this part of its size is rigid.
RIGID = 1e-12
#: Approximate distance of the floor's lines as a part of the robot's size, rounded down to 1, 2 or 5 times a power of ten.
SQUARE = 0.15
#: Numbers, times a power of ten, to which the end of the colour scale is rounded up.
ROUND = (1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10)


@dataclass(frozen=True, eq=False)
class StillArrow:
    """An arrow at one pose of the robot.

    Attributes:
        arrow: the arrow of the scene.
        value: value in its label [N, N·m].
        surface: its surface along z, with the tail at the origin.
        colour: "#rrggbb".
        free_end: z of the end with the label [m].
        frame: (4, 4) frame of the surface: its axes, and its origin relative to the point of attachment.
    """

    arrow: Arrow
    value: float
    surface: Surface
    colour: str
    free_end: float
    frame: Array

    @property
    def text(self) -> str:
        unit = self.arrow.unit
        return f"{self.arrow.label} {number(self.value)} {unit}" if unit else self.arrow.label

    def placed(self, poses: Array) -> Array:
        """Return the transform (4, 4) of the surface for the poses (n, 4, 4) of all stations."""
        at = poses[self.arrow.station]
        placement = self.frame.copy()
        placement[:3, 3] += at[:3, 3] + at[:3, :3] @ self.arrow.offset
        return placement

    def place_of_label(self, poses: Array) -> Array:
        """Return the position (3,) of the label, at the free end, for the poses (n, 4, 4) of all stations."""
        at = self.placed(poses)
        return np.asarray(at[:3, 3] + self.free_end * at[:3, 2])


class Still:
    """The first pose of a scene, with the initial factors (shares) of its contributions.

    Attributes:
        rest, deformed: (n, 4, 4) poses of the stations; ``deformed`` with the scene's exaggeration.
        twists: (n, 6) twists of the stations, not exaggerated [m, rad].
        deflections: (n,) displacements |u + θ × r| of the vertices of each coloured mesh, not exaggerated [m], by its path.
        largest: largest deflection [m], 0 for a rigid robot; its mesh, if any; and the index of its vertex.
        high: deflection at the end of the colour scale [m].
        arrows: arrows of visible length.
    """

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.rest, self.deformed = self.moved(0.0), self.moved(1.0)
        self.twists = np.einsum("nki,k->ni", scene.stations.all_twists[0], scene.shares)
        coloured = [mesh for mesh in scene.meshes if "Deformed" in mesh.roots and mesh.by_deflection]
        self.deflections = {mesh.path: self._deflections(mesh, mesh.surface.vertices) for mesh in coloured}
        most = float(np.linalg.norm(self.twists[:, :3], axis=-1).max())
        for mesh in coloured:  # for rigid links also the corners of the bounding box, as in the page
            vertices = mesh.surface.vertices
            corners = product(*zip(vertices.min(axis=0), vertices.max(axis=0), strict=True))
            points = np.array(list(corners)) if isinstance(mesh.station, int) else vertices
            most = max(most, float(self._deflections(mesh, points).max()), float(self.deflections[mesh.path].max()))
        rigid = most < RIGID * scene.size
        self.high = round_up(0.0 if rigid else most)
        self.largest: tuple[float, Mesh | None, int] = (0.0, None, 0)
        for mesh in [] if rigid else coloured:
            vertex = int(np.argmax(self.deflections[mesh.path]))
            if self.deflections[mesh.path][vertex] > self.largest[0]:
                self.largest = float(self.deflections[mesh.path][vertex]), mesh, vertex
        self.arrows = list(self._arrows())

    def moved(self, part: float) -> Array:
        """Return poses (n, 4, 4) of the stations with a ``part`` of the exaggerated displacements: 0 at rest, 1 deformed."""
        return self.scene.stations.moved(0, part * self.scene.exaggeration, self.scene.shares)

    def vertices(self, mesh: Mesh, root: str) -> Array:
        """Return the vertices (n, 3) of a mesh as drawn under one of its roots, world axes [m]."""
        return self.vertices_at(mesh, self.deformed if root == "Deformed" else self.rest)

    def vertices_at(self, mesh: Mesh, poses: Array) -> Array:
        """Return the vertices (n, 3) of a mesh for the poses (n, 4, 4) of all stations, world axes [m]."""
        at = (poses if mesh.recovery is None else self.rest)[np.broadcast_to(mesh.station, len(mesh.surface.vertices))]
        vertices = np.einsum("nij,nj->ni", at[:, :3, :3], mesh.surface.vertices) + at[:, :3, 3]
        if mesh.recovery is not None:
            turns = logarithm(np.moveaxis(poses[:, :3, :3] @ np.swapaxes(self.rest[:, :3, :3], 1, 2), 0, -1)).T
            vertices += mesh.displacements(self.rest[:, :3, :3], np.hstack([poses[:, :3, 3] - self.rest[:, :3, 3], turns]))
        return np.asarray(vertices)

    def _deflections(self, mesh: Mesh, points: Array) -> Array:
        """Return displacements (n,) [m], not exaggerated, of points (n, 3) of a mesh, given in the axes of their stations."""
        if mesh.recovery is not None:
            return np.asarray(np.linalg.norm(mesh.displacements(self.rest[:, :3, :3], self.twists), axis=-1))
        station = np.broadcast_to(mesh.station, len(points))
        arms = np.einsum("nij,nj->ni", self.rest[station, :3, :3], points)
        twists = self.twists[station]
        return np.asarray(np.linalg.norm(twists[:, :3] + np.cross(twists[:, 3:], arms), axis=-1))

    def look(self, mesh: Mesh, root: str) -> str | Array:
        """Return the colour "#rrggbb" of a mesh under one of its roots, or the colours (n, 3) of its vertices, 0 to 1."""
        if root == "Rest":
            return RESTING[0]
        if not mesh.by_deflection:
            return mesh.colour
        return _ramp_colours(self.deflections[mesh.path] / self.high) if root == "Deformed" else UNKNOWN

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

    def outline(self) -> Array:
        """Return the points (n, 3) that the picture must contain: vertices of meshes, ends of axes and of visible arrows."""
        points = [
            self.vertices(mesh, root)[:: 1 + len(mesh.surface.vertices) // 2000]
            for mesh in self.scene.meshes
            for root in mesh.roots
        ]
        for still_arrow in self.arrows:
            if still_arrow.arrow.group not in HIDDEN:
                at = still_arrow.placed(self.deformed)
                points.append(at[:3, 3] + np.outer([0.0, np.ptp(still_arrow.surface.vertices[:, 2])], at[:3, 2]))
        for _, station, _ in self.scene.frames:
            at = self.deformed[station]
            points.append(at[:3, 3] + AXES * self.scene.size * at[:3, :3].T)
        return np.concatenate(points)

    def floor(self) -> tuple[Array, float]:
        """Return the ends (2 n, 3) of the floor's n lines, and the side of its squares [m]."""
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

    def camera(self, aspect: float, above: float, below: float) -> tuple[Array, Array]:
        """Return the centre (3,) of the picture, and the position (3,) of the camera relative to it [m].

        The robot fills the picture except for a strip at the top and one at the bottom.

        Args:
            aspect: width of the picture by its height.
            above, below: heights of the strips, as parts of the picture's height.
        """
        points = self.outline()
        centre = (points.min(axis=0) + points.max(axis=0)) / 2
        d = np.array(VIEW) / np.linalg.norm(VIEW)
        right = np.cross([0.0, 0.0, 1.0], d) / np.linalg.norm(np.cross([0.0, 0.0, 1.0], d))
        up = np.cross(d, right)
        across, along, towards = np.stack([right, up, d]) @ (points - centre).T
        half = math.tan(math.radians(FIELD_OF_VIEW) / 2)
        # a point (x, z) is visible if low (D - z) <= x - s <= high (D - z), linear in the camera's shift s and distance D
        fits = []
        for x, low, high in ((across, -aspect, aspect), (along, 2 * below - 1, 1 - 2 * above)):
            most, least = float((x + high * half * towards).max()), float((x + low * half * towards).min())
            fits.append(((most - least) / ((high - low) * half), most, least, low * half, high * half))
        distance = 1.04 * max(fit[0] for fit in fits)
        shifts = [(most + least - (low + high) * distance) / 2 for _, most, least, low, high in fits]
        return centre + shifts[0] * right + shifts[1] * up, distance * d


def _ramp_colours(parts: Array) -> Array:
    """Return the colours (n, 3), 0 to 1, at parts (n,) of the colour scale."""
    ramp = np.array([[int(colour[n : n + 2], 16) / 255 for n in (1, 3, 5)] for colour in RAMP])
    return np.column_stack([np.interp(parts, np.linspace(0, 1, len(RAMP)), channel) for channel in ramp.T])


def round_up(value: float) -> float:
    """Return the smallest number of ROUND, times a power of ten, not below a value; 1e-6 for zero, as in the page."""
    if not value > 0:
        return 1e-6
    power = 10.0 ** math.floor(math.log10(value))
    return next(step * power for step in ROUND if step * power >= value * (1 - 1e-6))


#: Size of the picture for which heading and legend are made [pixels]; in wider pictures they are centred.
WIDTH, HEIGHT = 1200, 900
#: Height of a line and width of a letter [pixels].
LINE, LETTER = 24, 9.2
INK, PALE = "#20262e", "#4a5462"
#: Largest number of lines beside the colour scale; further lines are omitted.
MOST_LINES = 4


def heading(still: Still) -> tuple[str, int]:
    """Return an SVG image of title, pose, loads and notes, as wide as the picture, and its height [pixels]."""
    scene = still.scene
    facts = [fact for fact in scene.facts.lines(0) if fact != ("status", "OK")]
    lines = _in_lines(facts, WIDTH - 40)
    if scene.unloaded:
        lines += _in_lines([("", note) for note in scene.notes], WIDTH - 40)
    height = 44 + LINE * len(lines)
    parts = [f'<text x="{WIDTH / 2}" y="30" font-size="25" font-weight="700" text-anchor="middle">{escape(scene.title)}</text>']
    for k, line in enumerate(lines):
        words = "&#160;&#160; ".join(f'<tspan font-weight="600">{escape(name)}</tspan> {escape(text)}' for name, text in line)
        parts.append(f'<text x="{WIDTH / 2}" y="{54 + LINE * k}" text-anchor="middle">{words}</text>')
    return image(parts, WIDTH, height), height


def legend(still: Still, square: float) -> tuple[str, int]:
    """Return an SVG image of the colour scale and of the values of initially visible arrows, and its height [pixels].

    ``square`` is the side of a square of the floor [m].
    """
    scene, unit = still.scene, still.scene.facts.displacement
    groups: dict[str, list[str]] = {}
    colours = {}
    for still_arrow in still.arrows:
        if still_arrow.arrow.group not in HIDDEN:
            groups.setdefault(still_arrow.arrow.group, []).append(still_arrow.text)
            colours[still_arrow.arrow.group] = still_arrow.colour
    rows = []
    for group, texts in groups.items():
        filled = _in_lines([(group, texts[0]), *(("", words) for words in texts[1:])], 728)
        rows += [(line, colours[group] if k == 0 else "", "," if line is not filled[-1] else "") for k, line in enumerate(filled)]
    if len(rows) > MOST_LINES:
        line, colour, _ = rows[MOST_LINES - 1]
        rows = [*rows[: MOST_LINES - 1], (line, colour, ", …")]
    height = 26 + LINE * max(3, len(rows) + 1)
    parts = []
    if scene.unloaded or not still.largest[0]:
        words = "without loads" if scene.unloaded else "rigid: nothing deforms"
        parts.append(f'<text x="40" y="30" font-weight="600">{words}</text>')
    else:
        stops = "".join(f'<stop offset="{k / (len(RAMP) - 1)}" stop-color="{colour}"/>' for k, colour in enumerate(RAMP))
        words = f"deflection [{unit.unit}], largest {number(still.largest[0] / unit.factor)}"
        parts += [
            f'<defs><linearGradient id="ramp">{stops}</linearGradient></defs>',
            f'<text x="40" y="30" font-weight="600">{words}</text>',
            '<rect x="40" y="42" width="340" height="16" fill="url(#ramp)"/>',
        ]
        for part in (0, 0.25, 0.5, 0.75, 1):
            value = number(part * still.high / unit.factor)
            parts.append(f'<text x="{40 + 340 * part}" y="78" font-size="16" text-anchor="middle">{value}</text>')
    for k, (line, colour, more) in enumerate(rows):
        y = 30 + LINE * k
        if colour:
            parts.append(f'<rect x="450" y="{y - 12}" width="13" height="13" rx="2" fill="{colour}"/>')
        words = ", ".join(
            f'<tspan font-weight="600">{escape(name)}</tspan> {escape(text)}' if name else escape(text) for name, text in line
        )
        parts.append(f'<text x="472" y="{y}">{words}{more}</text>')
    about = "" if scene.unloaded or not still.largest[0] else f"drawn × {number(scene.exaggeration)}; pale: at rest; "
    last = f"{about}squares of the floor: {1e3 * square:g} mm"
    parts.append(f'<text x="472" y="{30 + LINE * max(2, len(rows))}" fill="{PALE}" font-size="16">{last}</text>')
    return image(parts, WIDTH, height), height


def image(parts: Iterable[str], width: int, height: int) -> str:
    """Return an SVG image of given width and height [pixels]."""
    # An almost transparent white background avoids black edges of letters.
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}" '
        f'font-family="system-ui, sans-serif" font-size="18" fill="{INK}" '
        f'stroke="#fff" stroke-width="5" stroke-linejoin="round" paint-order="stroke">'
        f'<rect width="{width}" height="{height}" fill-opacity="0.02" fill="#fff" stroke="none"/>{"".join(parts)}</svg>'
    )


def number(value: float) -> str:
    """Return a number with three digits, as in the page."""
    if not math.isfinite(value):
        return "–"
    size = abs(value)
    text = "0" if size < 1e-5 else f"{value:.2e}" if size >= 1e6 else f"{value:.0f}" if size >= 100 else f"{value:#.3g}"
    return text.removesuffix(".").replace("-", "−")


def _in_lines(items: Iterable[tuple[str, str]], width: float) -> list[list[tuple[str, str]]]:
    """Distribute pairs of name and text over lines of a width [pixels]."""
    lines: list[list[tuple[str, str]]] = []
    left = 0.0
    for name, text in items:
        taken = LETTER * (len(name) + len(text) + 3)
        if taken > left:
            lines.append([])
            left = width
        lines[-1].append((name, text))
        left -= taken
    return lines
