"""Surfaces of the links: shapes and meshes of the URDF's ``<visual>`` elements, read by yourdfpy."""

from __future__ import annotations

import contextlib
import io
import logging
import os
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from kinetostatics.arguments import warn
from kinetostatics.files.bundled import PackageNotFound, package_folder
from kinetostatics.math.arrays import Array
from kinetostatics.viewer.shapes import Surface, joined

if TYPE_CHECKING:
    import trimesh
    import yourdfpy

    from kinetostatics.description.robot_description import RobotDescription


Colour = tuple[float, float, float]
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
    import yourdfpy

    folder = os.path.dirname(description.path)
    logger = logging.getLogger("yourdfpy.urdf")
    level = logger.level
    logger.setLevel(logging.CRITICAL)  # it also warns of missing meshes
    missing: list[str] = []
    try:
        urdf = yourdfpy.URDF.load(
            io.BytesIO(description.urdf.encode()), build_scene_graph=False, load_meshes=False, mesh_dir=folder
        )
        palette = {material.name: material.color for material in urdf.robot.materials}
        raw: list[tuple[str, Surface, Colour]] = []
        for link in urdf.robot.links:
            for visual in link.visuals:
                colour = _colour(visual.material, palette)
                raw += [(link.name, mesh, colour or own) for mesh, own in _meshes(visual, folder, link.name, missing)]
    except (TypeError, ValueError) as error:
        warn(f"{description.path}: no <visual> is drawn, since one of them cannot be read: {error}")
        return {}
    finally:
        logger.setLevel(level)
    if missing:
        more = f" (and {len(missing) - 1} more meshes)" if len(missing) > 1 else ""
        warn(f"{missing[0]}{more}")
    share = min(1.0, MOST_FACES / max(1, sum(len(mesh.faces) for _, mesh, _ in raw)))
    result = {}
    for name in dict.fromkeys(name for name, _, _ in raw):
        meshes = [(mesh, colour) for link, mesh, colour in raw if link == name]
        pieces = [(_smooth(decimated(mesh, max(FEW_FACES, int(share * len(mesh.faces))))), colour) for mesh, colour in meshes]
        colours = np.concatenate([np.tile(colour, (len(surface.vertices), 1)) for surface, colour in pieces])
        read = sum(len(mesh.faces) for mesh, _ in meshes)
        result[name] = LinkVisual(joined([surface for surface, _ in pieces]), colours, read)
    return result


def _meshes(visual: yourdfpy.Visual, folder: str, link: str, missing: list[str]) -> list[tuple[Surface, Colour]]:
    """Return surfaces of a visual in the link's frame, and their colours in its mesh file.

    For a mesh that cannot be read, the reason is appended to ``missing``.
    """
    import trimesh

    geometry = visual.geometry
    origin = np.eye(4) if visual.origin is None else np.asarray(visual.origin)
    if geometry is None:
        return []
    if geometry.box is not None:
        meshes = [trimesh.creation.box(geometry.box.size)]
    elif geometry.cylinder is not None:
        meshes = [trimesh.creation.cylinder(geometry.cylinder.radius, geometry.cylinder.length, sections=40)]
    elif geometry.sphere is not None:
        meshes = [trimesh.creation.uv_sphere(geometry.sphere.radius, count=[16, 24])]
    elif geometry.mesh is not None:
        meshes = _read_mesh(geometry.mesh, folder, link, missing)
    else:
        return []
    surfaces = (Surface(np.asarray(mesh.vertices), np.asarray(mesh.faces)).transformed(origin) for mesh in meshes)
    return [(surface, _own_colour(mesh)) for surface, mesh in zip(surfaces, meshes, strict=True)]


def _own_colour(mesh: trimesh.Trimesh) -> Colour:
    material = getattr(mesh.visual, "material", None)
    if material is None and not mesh.visual.defined:
        return GREY
    red, green, blue = (float(part) / 255 for part in (material or mesh.visual).main_color[:3])
    return red, green, blue


def _smooth(surface: Surface) -> Surface:
    """Return a surface whose faces at a sharp edge have separate vertices, so that shading keeps the edge."""
    vertices, faces = np.ascontiguousarray(surface.vertices, float), np.ascontiguousarray(surface.faces, np.int64)
    return _smoothed(vertices.tobytes(), faces.tobytes())


def sharpened(surface: Surface) -> tuple[Surface, NDArray[np.int64]]:
    """Return a surface with separate vertices at sharp edges, and which vertex of the given surface each of them is."""
    result = _smooth(surface)
    both, count = np.concatenate([surface.vertices, result.vertices]), len(surface.vertices)
    _, first, place = np.unique(both, axis=0, return_index=True, return_inverse=True)
    return result, first[place.ravel()[count:]]


@lru_cache(maxsize=200)  # a robot may be drawn repeatedly
def _smoothed(vertices: bytes, faces: bytes) -> Surface:
    """Return the surface of :func:`_smooth`; the arguments are the bytes of vertices (n, 3) and faces (m, 3)."""
    import trimesh

    surface = trimesh.Trimesh(np.frombuffer(vertices).reshape(-1, 3), np.frombuffer(faces, np.int64).reshape(-1, 3))
    mesh = trimesh.graph.smooth_shade(surface, angle=SHARP)
    used, first, place = np.unique(np.asarray(mesh.faces), return_index=True, return_inverse=True)
    rank = np.argsort(np.argsort(first))  # vertices in the order of the faces take less space in a page
    return Surface(np.asarray(mesh.vertices)[used[np.argsort(first)]], rank[place].reshape(-1, 3))


def _read_mesh(mesh: yourdfpy.Mesh, folder: str, link: str, missing: list[str]) -> list[trimesh.Trimesh]:
    """Return the triangles of a mesh file; if it cannot be read, append the reason to ``missing``."""
    import trimesh

    path = _mesh_path(mesh.filename, folder)
    if path is None or not os.path.isfile(path):
        missing.append(f"mesh {mesh.filename!r} of link {link!r} was not found and is not drawn")
        return []
    if os.path.getsize(path) > LARGE_MESH:
        size = os.path.getsize(path) / 1e6
        missing.append(f"mesh {mesh.filename!r} of link {link!r} has {size:.1f} MB, too much for a page, and is not drawn")
        return []
    try:
        is_collada = path.lower().endswith(".dae")
        source = io.BytesIO(without_textures(Path(path).read_bytes())) if is_collada else path
        scene = trimesh.load(source, "dae" if is_collada else None, force="scene", skip_materials=True)
        pieces = [geometry for geometry in scene.dump() if isinstance(geometry, trimesh.Trimesh) and len(geometry.faces)]
        if not pieces:
            raise ValueError("it contains no triangles")
    except Exception as error:  # readers of formats raise various errors
        missing.append(f"mesh {mesh.filename!r} of link {link!r} cannot be read and is not drawn: {error}")
        return []
    if mesh.scale is not None:
        for piece in pieces:
            piece.apply_transform(np.diag([*np.broadcast_to(mesh.scale, 3), 1.0]))
    return pieces


def without_textures(collada: bytes) -> bytes:
    """Return a COLLADA file without textures, which are not drawn: for a wrong reference to one, pycollada omits the surface."""
    root = ElementTree.fromstring(collada)
    for parent in list(root.iter()):
        for child in list(parent):
            name = child.tag.rpartition("}")[2]
            if name in ("library_images", "newparam") or any(part.tag.rpartition("}")[2] == "texture" for part in child):
                parent.remove(child)
    return ElementTree.tostring(root)


def _mesh_path(filename: str, folder: str) -> str | None:
    """Return the path of a mesh: in an installed package for ``package://NAME/…``, else by yourdfpy's rules."""
    from yourdfpy.urdf import filename_handler_magic

    name, _, path_in_package = filename.removeprefix("package://").partition("/")
    if filename.startswith("package://"):
        with contextlib.suppress(PackageNotFound):
            return str(package_folder(name) / path_in_package)
    path = filename_handler_magic(filename, folder)
    return None if path is None else str(path)


def _colour(material: yourdfpy.Material | None, palette: dict[str, yourdfpy.Material]) -> Colour | None:
    colour = None if material is None else material.color or palette.get(material.name)
    if colour is None:
        return None
    red, green, blue = (float(part) for part in colour.rgba[:3])
    return red, green, blue


#: Smallest and largest number of grid cells along the longest side of a mesh.
COARSEST, FINEST = 4, 4096


def decimated(surface: Surface, most: int) -> Surface:
    """Return a surface with at most ``most`` triangles: all vertices in a cell of a grid are replaced by their mean.

    Degenerate and duplicate triangles are removed. The grid is the finest one that leaves few enough triangles, or the coarsest
    one if none does. The mesh need be neither closed nor manifold.
    """
    return surface if len(surface.faces) <= most else merged(surface, clusters(surface, most))[0]


def clusters(surface: Surface, most: int, kinds: NDArray[np.integer] | None = None) -> NDArray[np.int64]:
    """Return the cluster (n,) of each vertex for :func:`decimated`; different ``kinds`` (n,) are in different ones."""
    low, high = COARSEST, FINEST
    while high - low > max(1, low // 16):
        middle = (low + high) // 2
        low, high = (middle, high) if len(merged(surface, _cells(surface, middle, kinds))[1]) <= most else (low, middle)
    return _cells(surface, low, kinds)


def _cells(surface: Surface, cells: int, kinds: NDArray[np.integer] | None) -> NDArray[np.int64]:
    vertices = surface.vertices
    start, size = vertices.min(axis=0), float(np.ptp(vertices, axis=0).max()) or 1.0
    place = np.floor((vertices - start) * (cells / size)).astype(np.int64)
    key = (place[:, 0] * (FINEST + 1) + place[:, 1]) * (FINEST + 1) + place[:, 2]
    pairs = np.column_stack([key, np.zeros_like(key) if kinds is None else kinds])
    return np.unique(pairs, axis=0, return_inverse=True)[1].ravel()


def means(values: Array, cluster: NDArray[np.int64]) -> Array:
    """Return the means of rows of ``values`` (n, k) over the clusters (n,)."""
    return np.column_stack([np.bincount(cluster, weights=column) for column in values.T]) / np.bincount(cluster)[:, None]


def merged(surface: Surface, cluster: NDArray[np.int64]) -> tuple[Surface, NDArray[np.int64]]:
    """Return a surface whose vertices are the means of the clusters (n,), and the numbers of the triangles that remain."""
    faces = cluster[surface.faces]
    a, b, c = faces.T
    whole = np.flatnonzero((a != b) & (b != c) & (c != a))
    _, first = np.unique(np.sort(faces[whole], axis=1), axis=0, return_index=True)
    kept = whole[np.sort(first)]
    return Surface(means(surface.vertices, cluster), faces[kept]), kept
