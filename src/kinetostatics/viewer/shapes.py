"""Triangle meshes: swept sections, balls, pins, sticks, coils and arrows.

Sections and coils are attached to several stations, coordinate systems that move with the robot, and bend when these move.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from kinetostatics.math.arrays import Array, zeros_for
from kinetostatics.math.linalg import axis_across, cross
from kinetostatics.sections.kinds import Rectangle, RectangularTube, Section, Tube
from kinetostatics.sections.tapered import Station, Tapered

Integers = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Surface:
    """A triangle mesh: ``vertices`` (n, 3) [m] and ``faces`` (m, 3), counter-clockwise seen from outside."""

    vertices: Array
    faces: Integers

    def transformed(self, matrix: Array) -> Surface:
        """Return the mesh with vertices transformed by the homogeneous ``matrix`` (4, 4)."""
        return Surface(self.vertices @ matrix[:3, :3].T + matrix[:3, 3], self.faces)


def joined(surfaces: list[Surface]) -> Surface:
    starts = np.cumsum([0] + [len(surface.vertices) for surface in surfaces[:-1]])
    return Surface(
        np.concatenate([surface.vertices for surface in surfaces]),
        np.concatenate([surface.faces + start for surface, start in zip(surfaces, starts, strict=True)]),
    )


def outlines(section: Section) -> tuple[Array, Array | None, bool]:
    """Return the outer and the inner outline (m, 2) of a section, in its axes y, z [m], and whether they are smooth.

    A section of which only area and moments are given is drawn as the ellipse with the same radii of gyration.
    """
    y, z = section.extent
    if isinstance(section, Rectangle):
        corners = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
        inner = None
        if isinstance(section, RectangularTube) and 0 < section.thickness < min(y, z):
            inner = corners * [y - section.thickness, z - section.thickness]
        return corners * [y, z], inner, False
    angle = np.arange(24) * (2 * np.pi / 24)
    circle = np.column_stack([np.cos(angle), np.sin(angle)])
    hollow = isinstance(section, Tube) and section.inner_diameter > 0
    return circle * [y, z], circle * (section.inner_diameter / 2) if hollow else None, True  # type: ignore[attr-defined]


@lru_cache(maxsize=256)
def swept(section: Section, stations: int) -> tuple[Surface, Integers]:
    """Return the surface of a section swept along a number of stations, and the index (n,) of the station of each vertex.

    A vertex is given in the axes of its station, with x = 0 along the beam; the page moves the stations to bend the surface.
    """
    places = np.linspace(0, 1, stations).tolist()
    every = [section.at(place)[-1] for place in places] if isinstance(section, Tapered) else [Station(0.0, section)] * stations
    outers, inners, smooth = zip(*(outlines(station.section) for station in every), strict=True)
    hollow, offsets = not any(inner is None for inner in inners), np.array([station.offset for station in every])[:, None]
    walls = [np.array(outers) + offsets, *([np.array(inners) + offsets] if hollow else [])]
    parts = [_wall(walls[0], smooth[0])]
    if hollow:
        surface, at = _wall(walls[1], smooth[0])
        parts.append((Surface(surface.vertices, surface.faces[:, ::-1]), at))
    parts += [_cap(walls[0][k], walls[1][k] if hollow else None, k % stations, k == 0) for k in (0, -1)]
    return joined([surface for surface, _ in parts]), np.concatenate([at for _, at in parts])


def _wall(outlines: Array, smooth: bool) -> tuple[Surface, Integers]:
    """Return the wall over outlines (stations, m, 2)."""
    stations, m = outlines.shape[:2]
    rings = outlines if smooth else np.repeat(outlines, 2, axis=1)  # duplicate vertices at edges keep them sharp
    n = rings.shape[1]
    first = np.arange(m) if smooth else 2 * np.arange(m) + 1
    after = (first + 1) % n
    start = (np.arange(stations - 1) * n)[:, None]
    a, b = start + first, start + after
    faces = np.concatenate([np.stack([a, b, a + n], axis=-1), np.stack([b, b + n, a + n], axis=-1)])
    vertices = np.column_stack([np.zeros(n * stations), rings.reshape(-1, 2)])
    return Surface(vertices, faces.reshape(-1, 3)), np.repeat(np.arange(stations), n)


def _cap(outer: Array, inner: Array | None, station: int, backwards: bool) -> tuple[Surface, Integers]:
    m = len(outer)
    middle = np.zeros_like(outer) if inner is None else inner
    k = np.arange(m)
    after = (k + 1) % m
    faces = np.concatenate([np.stack([k, after, k + m], axis=-1), np.stack([after, after + m, k + m], axis=-1)])
    points = np.concatenate([outer, middle])
    surface = Surface(np.column_stack([np.zeros(2 * m), points]), faces[:, ::-1] if backwards else faces)
    return surface, np.full(2 * m, station)


@lru_cache(maxsize=256)
def ball(radius: float) -> Surface:
    """Return a sphere with its centre at the origin."""
    return _turned(np.column_stack([np.sin(_HALF), np.cos(_HALF)]) * radius, True)


@lru_cache(maxsize=256)
def pin(radius: float, length: float, pieces: int = 1) -> Surface:
    """Return a cylinder about the z axis, its middle at the origin; its side is divided along z into ``pieces``."""
    half = length / 2
    side = [[radius, z] for z in np.linspace(half, -half, pieces + 1)]
    return _turned(np.array([[0, half], *side, [0, -half]]), False)


def stick(start: Array, end: Array, radius: float, pieces: int = 1) -> Surface:
    """Return a cylinder between two points (3,), see :func:`pin`."""
    axis = end - start
    frame = frames_along(axis[None])[0]
    frame[:3, 3] = (start + end) / 2
    return pin(radius, float(np.linalg.norm(axis)), pieces).transformed(frame)


def plate(points: Array, radius: float) -> Surface:
    """Return the thin plate through points (n, 3), with corners of this radius, and posts to points beside its plane."""
    middle, m = points.mean(axis=0), 72
    frame = frames_along(np.linalg.svd(points - middle)[2][-1:], middle[None])[0]
    local, angle, k = (points - middle) @ frame[:3, :3], np.arange(m) * (2 * np.pi / m), np.arange(m)
    outwards, after = np.column_stack([np.cos(angle), np.sin(angle)]), (k + 1) % m
    edge = local[np.argmax(outwards @ local[:, :2].T, axis=1), :2] + radius * outwards  # the convex hull of discs
    heights = radius / 2 * np.array([1, 1, -1, -1])  # duplicate rings keep edges sharp
    top, a, b = np.column_stack([np.zeros_like(k), k, after])[1:-1], m + k, 2 * m + k
    side = [np.column_stack([a, b, m + after]), np.column_stack([m + after, b, 2 * m + after])]
    body = Surface(
        np.column_stack([np.tile(edge, (4, 1)), np.repeat(heights, m)]), np.concatenate([top, *side, top[:, ::-1] + 3 * m])
    )
    posts = [stick(p * [1, 1, 0], p, radius / 2) for p in local if abs(p[2]) > radius / 2]
    return joined([body, *posts]).transformed(frame)


#: Length without turns at each end of a spring, as a part of the spring's length.
STRAIGHT = 0.1


def places_along_coil(turns: int, points: int) -> Array:
    """Return positions of stations along a spring, from 0 to 1, with ``points`` stations per turn."""
    return np.concatenate([[0.0], np.linspace(STRAIGHT, 1 - STRAIGHT, turns * points + 1), [1.0]])


@lru_cache(maxsize=256)
def coil(length: float, radius: float, wire: float, turns: int, points: int) -> tuple[Surface, Integers]:
    """Return a coil spring with small balls at its ends, and the index (n,) of the station of each vertex.

    Stations are points along the spring. Vertices are given relative to their stations, with z along the spring; the coil
    stretches when the stations move apart.
    """
    places = places_along_coil(turns, points)
    n = len(places)
    turn = np.concatenate([[0.0], np.linspace(0, turns, n - 2), [turns]])
    wide = radius * np.clip(2 * np.minimum(turn, turns - turn), 0, 1)  # the radius grows from zero within half a turn
    line = np.column_stack([wide * np.cos(2 * np.pi * turn), wide * np.sin(2 * np.pi * turn), length * places])
    tangents = np.gradient(line, axis=0)
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    side = carried_along(np.array([0.0, 1.0, 0.0]), tangents)
    ring = (np.arange(6) * (2 * np.pi / 6))[:, None, None]
    rings = line * [1, 1, 0] + wire * (np.cos(ring) * side + np.sin(ring) * crossed(tangents, side))  # (6, n, 3)
    k, start = np.arange(6), (np.arange(n - 1) * 6)[:, None]
    a, b = start + k, start + (k + 1) % 6
    faces = np.concatenate([np.stack([a, b, b + 6], axis=-1), np.stack([a, b + 6, a + 6], axis=-1)]).reshape(-1, 3)
    end = ball(2.2 * wire)
    at = np.concatenate([np.repeat(np.arange(n), 6), np.repeat([0, n - 1], len(end.vertices))])
    return joined([Surface(rings.swapaxes(0, 1).reshape(-1, 3), faces), end, end]), at


def arrow(length: float, radius: float, heads: int) -> Surface:
    """Return an arrow along the z axis with one or two heads, its tail at the origin; short arrows are thinner."""
    r = radius * min(1.0, length / (9 * radius))
    head = min(6 * r, 0.6 * length / heads)
    tips = [length - 0.75 * n * head for n in range(heads)]
    profile = [(0.0, length)]
    for n, tip in enumerate(tips):
        if n:  # the second cone starts on the shaft
            profile.append((r, tip - head / 2.4))
        profile += [(2.4 * r, tip - head), (r, tip - head)]
    return _turned(np.array([*profile, (r, 0.0), (0.0, 0.0)]), False)


def crossed(a: Array, b: Array) -> Array:
    """Return cross products of vectors (…, 3)."""
    return np.asanyarray(cross(a.T, b.T).T)


def frames_along(axes: Array, origins: Array | None = None) -> Array:
    """Return frames (F, 4, 4) whose z axes point along ``axes`` (F, 3)."""
    z = axes / np.linalg.norm(axes, axis=-1, keepdims=True)
    helper = axis_across(z[0])  # the same for all frames, so that x is continuous
    x = crossed(helper[None], z)
    x = x / np.linalg.norm(x, axis=-1, keepdims=True)
    result = zeros_for((len(axes), 4, 4), axes, *([] if origins is None else [origins]))
    result[:, :3, 0], result[:, :3, 1], result[:, :3, 2] = x, crossed(z, x), z
    result[:, 3, 3] = 1
    if origins is not None:
        result[:, :3, 3] = origins
    return result


def carried_along(start: Array, directions: Array) -> Array:
    """Return unit vectors (n, 3), normal to unit vectors ``directions`` (n, 3), that turn from row to row as little as possible.

    Each is the preceding vector (for row 0 ``start`` (3,)), projected onto the plane normal to the direction and normalized.
    """
    result, side = np.empty_like(directions), start
    for k, along in enumerate(directions):
        side = side - along * (along @ side)
        if np.linalg.norm(side) < 1e-3:  # the vector before was along the direction
            side = axis_across(along)
            side = side - along * (along @ side)
        result[k] = side = side / np.linalg.norm(side)
    return result


_HALF = np.linspace(0, np.pi, 11)


def _turned(profile: Array, smooth: bool, sides: int = 20) -> Surface:
    """Return the surface of revolution about z of a profile (n, 2) of radii and heights, from top to bottom."""
    angle = np.arange(sides) * (2 * np.pi / sides)
    circle = np.column_stack([np.cos(angle), np.sin(angle)])
    if not smooth:  # duplicate rings at edges keep them sharp
        profile = np.repeat(profile, 2, axis=0)[1:-1]
    rings = [np.column_stack([circle * r, np.full(sides, h)]) for r, h in profile]
    k = np.arange(sides)
    after = (k + 1) % sides
    faces = []
    for ring in range(0, len(rings) - 1, 1 if smooth else 2):
        a, b = ring * sides, (ring + 1) * sides
        faces += [np.stack([a + k, b + k, a + after], axis=-1), np.stack([a + after, b + k, b + after], axis=-1)]
    return Surface(np.concatenate(rings), np.concatenate(faces))
