"""Interfaces of a part on the surface of its mesh: cylinders, faces, and what lies in a sphere."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import trimesh

from kinetostatics.exceptions import ArgumentError, near_names
from kinetostatics.math.arrays import Array, Index, Mask
from kinetostatics.units import parse_number

KINDS = "cylinder d=20mm near X Y Z, face near X Y Z, face NAME, or sphere r=10mm at X Y Z"
AT_A_POINT = r"(?:(cylinder|sphere) [dr]=(\S+)|face) (?:near|at) (\S+) (\S+) (\S+)"
#: Relative tolerance of a cylinder's diameter, and fraction of its radius by which its points may be off.
DIAMETER, ROUND = 0.01, 0.01


@dataclass(frozen=True)
class MeshSurface:
    """A part's surface: ``points`` (S, 3) [m], ``triangles`` (T, 3), the ``face`` (T,) of each, and the names of all faces."""

    points: Array
    triangles: Index
    face: Index
    names: Sequence[str]

    def corners(self, face: int) -> Array:
        return self.points[self.triangles[self.face == face]]

    def distance(self, face: int, point: Array) -> float:
        corners = self.corners(face)
        nearest = trimesh.triangles.closest_point(corners, np.tile(point, (len(corners), 1)))
        return float(np.linalg.norm(nearest - point, axis=1).min())


def find_interface(surface: MeshSurface, name: str, text: str) -> tuple[Mask, Array]:
    """Return which triangles (T,) are the interface that ``text`` describes, and its origin (3,) [m].

    The origin is the middle of a cylinder's axis, the centroid of a face, or the centre of a sphere.

    Raises:
        ArgumentError: the text is not one of :data:`KINDS`, or there is no such surface.
    """
    what, all_faces = f"interface {name}", np.unique(surface.face).tolist()
    if match := re.fullmatch(AT_A_POINT, text):
        kind, *words = match.groups()
        size, *point = (parse_number(word or "0", "length", f"{what}, {text!r}") for word in words)
        if kind == "cylinder":
            return _cylinder(surface, what, size, np.array(point))
        if kind == "sphere":
            inside = np.linalg.norm(surface.points[surface.triangles].mean(1) - point, axis=1) <= size
            if not inside.any():
                raise ArgumentError(f"{what}: there is no surface in the {text}: no triangle has its centre there")
            return inside, np.array(point)
        faces = [min(all_faces, key=lambda face: surface.distance(face, np.array(point)))]
    elif text.startswith("face ") and len(text.split()) == 2:
        faces = [face for face in all_faces if surface.names[face] == text.split()[1]]
        if not faces:
            raise ArgumentError(f"{what}: there is no {text}; {near_names(text.split()[1], set(surface.names) - {'default'})}")
    else:
        raise ArgumentError(f"{what}: {text!r} is not understood; write {KINDS}")
    corners = np.concatenate([surface.corners(face) for face in faces])
    areas = trimesh.triangles.area(corners)
    return np.isin(surface.face, faces), areas @ corners.mean(1) / areas.sum()


def _cylinder(surface: MeshSurface, what: str, diameter: float, point: Array) -> tuple[Mask, Array]:
    cylinders = {face: fit for face in np.unique(surface.face).tolist() if (fit := _fit(surface.corners(face)))}
    right = [face for face, (*_, radius) in cylinders.items() if abs(2 * radius - diameter) <= DIAMETER * diameter]
    if not right:
        known = sorted({f"{2000 * radius:.4g} mm" for *_, radius in cylinders.values()}) or ["none"]
        raise ArgumentError(f"{what}: there is no cylinder of diameter {1000 * diameter:.4g} mm; there are {', '.join(known)}")
    nearest = min(right, key=lambda face: surface.distance(face, point))
    axis, centre, _ = cylinders[nearest]

    def along(face: int) -> Array:
        return (surface.corners(face) @ axis).ravel()

    def together(face: int) -> bool:  # such as halves of a bore
        offset = np.cross(cylinders[face][1] - centre, axis)
        parallel = abs(cylinders[face][0] @ axis) > 1 - 1e-4 and np.linalg.norm(offset) < DIAMETER * diameter
        return bool(parallel and along(face).max() > along(nearest).min() and along(face).min() < along(nearest).max())

    faces = [face for face in right if together(face)]
    places = np.concatenate([along(face) for face in faces])
    return np.isin(surface.face, faces), centre + ((places.max() + places.min()) / 2 - centre @ axis) * axis


def _fit(corners: Array) -> tuple[Array, Array, float] | None:
    """Return axis, a point of it and radius of the cylinder with the corners (T, 3, 3) of triangles; None if there is none."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    spread, axes = np.linalg.eigh(normals.T @ normals)
    if spread[1] < 1e-3 * spread[2]:  # a plane
        return None
    flat = corners.reshape(-1, 3) @ axes[:, 1:]
    x, y, constant = np.linalg.lstsq(np.column_stack([2 * flat, np.ones(len(flat))]), (flat**2).sum(1), rcond=None)[0]
    radius = float(np.sqrt(max(constant + x**2 + y**2, 0.0)))
    round_enough = np.abs(np.linalg.norm(flat - [x, y], axis=1) - radius).max() <= ROUND * radius
    return (axes[:, 0], axes[:, 1:] @ [x, y], radius) if round_enough else None
