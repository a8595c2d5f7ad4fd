"""Surfaces of the links: shapes and meshes of the URDF's ``<visual>`` elements."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kinetostatics.arguments import warn
from kinetostatics.description.elements import Place
from kinetostatics.exceptions import RobotFileError
from kinetostatics.files.attributes import number, text, vector
from kinetostatics.files.bundled import PackageNotFound, package_folder
from kinetostatics.files.element_tables import SHAPE
from kinetostatics.files.writer import elements_of
from kinetostatics.files.xml import XmlElement
from kinetostatics.viewer.shapes import Surface, joined

if TYPE_CHECKING:
    import trimesh

    from kinetostatics.description.robot_description import RobotDescription


#: Colour of visuals without a material.
GREY = (0.62, 0.65, 0.69)
#: Angle between faces above which an edge is drawn sharp [rad].
SHARP = 0.6
#: Number of triangles of all links together to which meshes are decimated; smallest number for a single mesh.
MOST_FACES, FEW_FACES = 40_000, 300
#: Largest size of a mesh file [bytes]; reading a larger one takes minutes.
LARGE_MESH = 40_000_000


@dataclass(frozen=True, eq=False)
class LinkVisual:
    """All visuals of one link, in its frame.

    Attributes:
        surface: triangles, possibly decimated.
        colours: (n, 3) colours of the vertices, 0 to 1.
        read: number of triangles of the meshes before decimation.
    """

    surface: Surface
    colours: NDArray[np.float64]
    read: int


def link_visuals(description: RobotDescription) -> dict[str, LinkVisual]:
    """Return the visuals of the links, by link name; a warning gives the first mesh that cannot be read, and their number."""
    folder = os.path.dirname(description.path)
    missing: list[str] = []
    materials = elements_of(description.extra, Place(description.path), "the description")
    palette = {item.attributes.get("name", ""): item for item in materials if item.tag == "material"}
    raw: list[tuple[str, Surface, tuple[float, float, float]]] = []
    for link in description.links.values():
        for visual in elements_of(link.extra, link.place, f"link {link.name!r}"):
            if visual.tag == "visual":
                try:
                    colour = _colour(visual.child("material"), palette)
                    raw += [(link.name, mesh, colour) for mesh in _meshes(visual, folder, link.name, missing)]
                except RobotFileError as error:
                    missing.append(f"{error}; this visual of link {link.name!r} is not drawn")
    if missing:
        more = f" (and {len(missing) - 1} more meshes)" if len(missing) > 1 else ""
        warn(f"{missing[0]}{more}")
    share = min(1.0, MOST_FACES / max(1, sum(len(mesh.faces) for _, mesh, _ in raw)))
    result = {}
    for name in dict.fromkeys(name for name, _, _ in raw):
        mine = [(mesh, colour) for link, mesh, colour in raw if link == name]
        pieces = [(_smooth(decimated(mesh, max(FEW_FACES, int(share * len(mesh.faces))))), colour) for mesh, colour in mine]
        colours = np.concatenate([np.tile(colour, (len(surface.vertices), 1)) for surface, colour in pieces])
        read = sum(len(mesh.faces) for mesh, _ in mine)
        result[name] = LinkVisual(joined([surface for surface, _ in pieces]), colours, read)
    return result


def _meshes(visual: XmlElement, folder: str, link: str, missing: list[str]) -> list[Surface]:
    """Return the surfaces of a visual in the link's frame; for a mesh that cannot be read, append the reason to ``missing``."""
    import trimesh

    geometry = visual.child("geometry")
    if geometry is None or not geometry.children:
        return []
    shape = geometry.children[0]
    match shape.tag:
        case "box":
            meshes = [trimesh.creation.box(vector(shape, "size"))]
        case "cylinder":
            meshes = [trimesh.creation.cylinder(number(shape, "radius"), number(shape, "length"), sections=40)]
        case "sphere":
            meshes = [trimesh.creation.uv_sphere(number(shape, "radius"), count=[16, 24])]
        case "mesh":
            meshes = _read_mesh(shape, folder, link, missing)
        case _:
            return []
    origin = SHAPE.read(visual)["origin"].matrix
    return [Surface(np.asarray(mesh.vertices), np.asarray(mesh.faces)).transformed(origin) for mesh in meshes]


def _smooth(surface: Surface) -> Surface:
    """Return a surface whose faces at a sharp edge have separate vertices, so that shading keeps the edge."""
    vertices, faces = np.ascontiguousarray(surface.vertices, float), np.ascontiguousarray(surface.faces, np.int64)
    return _smoothed(vertices.tobytes(), faces.tobytes())


@lru_cache(maxsize=200)  # a robot may be drawn repeatedly
def _smoothed(vertices: bytes, faces: bytes) -> Surface:
    """Return the surface of :func:`_smooth`; the arguments are the bytes of vertices (n, 3) and faces (m, 3)."""
    import trimesh

    surface = trimesh.Trimesh(np.frombuffer(vertices).reshape(-1, 3), np.frombuffer(faces, np.int64).reshape(-1, 3))
    mesh = trimesh.graph.smooth_shade(surface, angle=SHARP)
    return Surface(np.asarray(mesh.vertices), np.asarray(mesh.faces))


def _read_mesh(mesh: XmlElement, folder: str, link: str, missing: list[str]) -> list[trimesh.Trimesh]:
    """Return the triangles of a mesh file; if it cannot be read, append the reason to ``missing``."""
    import trimesh

    filename = text(mesh, "filename")
    path = _mesh_path(filename, folder)
    if path is None:
        missing.append(f"mesh {filename!r} of link {link!r} was not found and is not drawn")
        return []
    if os.path.getsize(path) > LARGE_MESH:
        size = os.path.getsize(path) / 1e6
        missing.append(f"mesh {filename!r} of link {link!r} has {size:.1f} MB, too much for a page, and is not drawn")
        return []
    try:
        scene = trimesh.load(path, force="scene", skip_materials=True)
        pieces = [item for item in scene.dump() if isinstance(item, trimesh.Trimesh) and len(item.faces)]
        if not pieces:
            raise ValueError("it contains no triangles")
    except Exception as error:  # readers of formats raise various errors
        missing.append(f"mesh {filename!r} of link {link!r} cannot be read and is not drawn: {error}")
        return []
    if "scale" in mesh.attributes:
        for piece in pieces:
            piece.apply_transform(np.diag([*vector(mesh, "scale"), 1.0]))
    return pieces


def _mesh_path(filename: str, folder: str) -> str | None:
    """Return the path of a mesh: for ``package://NAME/…`` in an installed package, else in the robot's folder or around it."""
    scheme, _, inside = filename.rpartition("://")
    path = inside
    if scheme == "package":
        name, _, path = inside.partition("/")
        with contextlib.suppress(PackageNotFound):
            folder, inside = str(package_folder(name)), ""
    candidates = [os.path.join(folder, path), inside, *(os.path.join(around, path) for around in Path(folder).parents)]
    return next(filter(os.path.isfile, candidates), None)


def _colour(material: XmlElement | None, palette: Mapping[str, XmlElement]) -> tuple[float, float, float]:
    named = None if material is None else palette.get(material.attributes.get("name", ""))
    for item in (material, named):
        if item is not None and (colour := item.child("color")) is not None:
            three = " ".join(text(colour, "rgba").split()[:3])
            return vector(replace(colour, attributes={"rgba": three}), "rgba")
    return GREY


#: Smallest and largest number of grid cells along the longest side of a mesh.
COARSEST, FINEST = 4, 4096


def decimated(surface: Surface, most: int) -> Surface:
    """Return a surface with at most ``most`` triangles: all vertices in a cell of a grid are replaced by their mean.

    Degenerate and duplicate triangles are removed. The grid is the finest one that leaves few enough triangles, or the coarsest
    one if none does. The mesh need be neither closed nor manifold.
    """
    if len(surface.faces) <= most:
        return surface
    low, high = COARSEST, FINEST
    while high - low > max(1, low // 16):
        middle = (low + high) // 2
        low, high = (middle, high) if len(_clustered(surface, middle).faces) <= most else (low, middle)
    return _clustered(surface, low)


def _clustered(surface: Surface, cells: int) -> Surface:
    vertices = surface.vertices
    start, size = vertices.min(axis=0), float(np.ptp(vertices, axis=0).max()) or 1.0
    place = np.floor((vertices - start) * (cells / size)).astype(np.int64)
    key = (place[:, 0] * (FINEST + 1) + place[:, 1]) * (FINEST + 1) + place[:, 2]
    _, cluster = np.unique(key, return_inverse=True)
    count = np.bincount(cluster)
    means = np.column_stack([np.bincount(cluster, weights=vertices[:, c]) / count for c in range(3)])
    faces = cluster[surface.faces]
    a, b, c = faces.T
    faces = faces[(a != b) & (b != c) & (c != a)]
    _, first = np.unique(np.sort(faces, axis=1), axis=0, return_index=True)
    return Surface(means, faces[np.sort(first)])
