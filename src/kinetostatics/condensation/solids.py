"""Solid finite elements of a part, by Netgen and NGSolve: tetrahedra with curved edges.

Displacements are in metres; a *unit* is the length [m] of 1 in the file. An interface has a *grip*: ``rigid``, its points move as
a rigid body, or ``even``, its motion is the mean over the area, and forces are a traction that is linear over the area. The rigid
grip is stiffer than a joint on this surface, the even one more compliant than most. It is a cylinder, a face, or what lies in
a sphere on the surface of the mesh.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import trimesh

from kinetostatics.description.elements import Material
from kinetostatics.exceptions import ArgumentError, near_names
from kinetostatics.math.arrays import Array, Index, Mask
from kinetostatics.math.rotations import skew
from kinetostatics.units import parse_number
from kinetostatics.viewer.shapes import Surface
from kinetostatics.viewer.visuals import clusters, means, merged

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


#: Objects of Netgen and NGSolve, which have no types.
Foreign: TypeAlias = Any
#: Polynomial order of the displacements. With 2, coarse meshes are up to 18 % too stiff in torsion, and refining shows it late.
ORDER = 3
#: Size of a part in a file without units above which its unit is the millimetre.
MILLIMETRES_ABOVE = 5.0


class SolidPart:
    """A part's shape or volume mesh."""

    def __init__(self, path: Path, unit: str | None) -> None:
        try:
            import ngsolve
            from netgen import meshing, occ, read_gmsh, stl
        except ImportError:
            raise ArgumentError("condensing needs Netgen and NGSolve: pip install 'kinetostatics[cad]'") from None
        self.ng, suffix = ngsolve, path.suffix.lower()
        try:
            if suffix in (".step", ".stp"):
                self.geometry: Foreign = occ.OCCGeometry(str(path))
                bodies = list(self.geometry.shape.solids)
                if len(bodies) != 1:
                    raise ArgumentError(f"{path} has {len(bodies)} solids; one would be right")
                thickness, unit = 2 * bodies[0].mass / sum(face.mass for face in bodies[0].faces), "mm"  # Netgen converts to mm
            elif suffix == ".stl":
                self.geometry, body = stl.STLGeometry(str(path)), trimesh.load_mesh(str(path))
                thickness, size = 2 * body.volume / body.area, np.ptp(body.bounds, axis=0).max()
            elif suffix in (".vol", ".msh"):
                self.geometry, thickness = None, 0.0
                self.mesh: Foreign = read_gmsh.ReadGmsh(str(path)) if suffix == ".msh" else ngsolve.Mesh(str(path)).ngmesh
                size = np.ptp(np.array(self.mesh.Coordinates()), axis=0).max()
            else:
                raise ArgumentError(f"{path}: files end in .step, .stl (shapes), .vol (Netgen) or .msh (Gmsh)")
        except (OSError, RuntimeError, ValueError, TypeError, IndexError, meshing.NgException) as error:
            if isinstance(error, ArgumentError):
                raise
            raise ArgumentError(f"{path} cannot be read: {str(error).strip() or 'it has no solid'}") from None
        self.unit = 1e-3 if unit == "mm" or (unit is None and size > MILLIMETRES_ABOVE) else 1.0
        self._edge = 2.8 * thickness

    def meshed(self, level: int) -> Foreign:
        """Return the curved mesh; with each level edges are 1.4 times shorter, or half as long in a given mesh."""
        if self.geometry is None:
            if level:
                self.mesh.Refine()
            return self.ng.Mesh(self.mesh)
        finer = 1.4**level
        mesh = self.ng.Mesh(self.geometry.GenerateMesh(maxh=self._edge / finer, curvaturesafety=2 * finer))
        mesh.Curve(2)
        return mesh


class Solid:
    """A meshed part with N displacements and n interfaces.

    Attributes:
        surface, owner: the surface, and the number (T,) of the interface of each triangle, or −1.
        origins: (n, 3) origins of the interfaces [m].
        thermal: (N,) loads due to 1 K.
    """

    def __init__(self, part: SolidPart, level: int, interfaces: Mapping[str, str], material: Material) -> None:
        ng, unit, mesh = part.ng, part.unit, part.meshed(level)
        self._ng, self.tetrahedra = ng, int(mesh.ne)
        boundary = [(element.index, [vertex.nr for vertex in element.vertices]) for element in mesh.Elements(ng.BND)]
        faces, corners = (np.array(column) for column in zip(*boundary, strict=True))
        self.surface = MeshSurface(unit * np.array(mesh.ngmesh.Coordinates()), corners, faces, list(mesh.GetBoundaries()))
        chosen, origins = zip(*(find_interface(self.surface, *pair) for pair in interfaces.items()), strict=True)
        self.origins, self.owner = np.array(origins), np.where(np.any(chosen, 0), np.argmax(chosen, 0), -1)

        space = ng.VectorH1(mesh, order=ORDER)
        u, v = space.TnT()
        ratio = material.poisson_ratio or 0.0
        shear = material.youngs_modulus / (2 * (1 + ratio))
        lame = 2 * shear * ratio / (1 - 2 * ratio)
        strain, virtual = ((ng.Grad(w) + ng.Grad(w).trans) / 2 for w in (u, v))
        stiffness, mass = ng.BilinearForm(space, symmetric=True), ng.BilinearForm(space, symmetric=True)
        stiffness += unit * (2 * shear * ng.InnerProduct(strain, virtual) + lame * ng.Trace(strain) * ng.Trace(virtual)) * ng.dx
        mass += unit**3 * (material.density or 0.0) * u * v * ng.dx
        thermal = ng.LinearForm(space)
        thermal += unit**2 * material.thermal_expansion * (2 * shear + 3 * lame) * ng.Trace(virtual) * ng.dx
        x, y, z = (unit * coordinate for coordinate in (ng.x, ng.y, ng.z))
        displacement, rigid, loads = ng.GridFunction(space), np.empty((space.ndof, 6)), np.empty((len(chosen), space.ndof, 6))
        with ng.TaskManager():
            for form in (stiffness, mass, thermal):
                form.Assemble()
            for column, motion in enumerate([(1, 0, 0), (0, 1, 0), (0, 0, 1), (0, -z, y), (z, 0, -x), (-y, x, 0)]):
                displacement.Set(ng.CF(motion))
                rigid[:, column] = displacement.vec.FV().NumPy()
                for number, mask in enumerate(chosen):
                    load = ng.LinearForm(space)
                    load += ng.CF(motion) * v * ng.ds(definedonelements=ng.BitArray(mask.tolist()))
                    loads[number, :, column] = load.Assemble().vec.FV().NumPy()
        self._stiffness, self._mass, self.thermal = stiffness.mat, mass.mat, thermal.vec.FV().NumPy().copy()
        numbers = [[space.GetDofNrs(ng.ElementId(ng.BND, int(k))) for k in np.flatnonzero(mask)] for mask in chosen]
        self._gripped = [np.unique(np.array(each)) for each in numbers]
        all_gripped = np.concatenate(self._gripped)
        if len(np.unique(all_gripped)) < len(all_gripped):
            raise ArgumentError(f"two of the interfaces {', '.join(interfaces)} touch; a gap between them would be right")
        moves = [np.block([[np.eye(3), skew(origin)], [np.zeros((3, 3)), np.eye(3)]]) for origin in self.origins]
        #: Displacements (N, 6) of unit twists at the origins, and loads (N, 6) of unit wrenches on even grips.
        self._motions = [rigid @ move for move in moves]
        self._loads = [load @ np.linalg.inv(motion.T @ load) for load, motion in zip(loads, self._motions, strict=True)]

    def _product(self, matrix: Foreign, columns: Array) -> Array:
        given, product, result = matrix.CreateColVector(), matrix.CreateColVector(), np.empty_like(columns)
        for k in range(columns.shape[1]):
            given.FV().NumPy()[:] = columns[:, k]
            product.data = matrix * given
            result[:, k] = product.FV().NumPy()
        return result

    def with_mass(self, columns: Array) -> Array:
        return self._product(self._mass, columns)

    def _solver(self, held: Index) -> Callable[[Array], Array]:
        free = np.ones(len(self.thermal), dtype=bool)
        free[held] = False
        with self._ng.TaskManager():
            inverse = self._stiffness.Inverse(self._ng.BitArray(free.tolist()), inverse="sparsecholesky")
        return lambda loads: self._product(inverse, loads)

    def gripped(self, grip: str) -> tuple[Array, Array, Callable[[Array], Array]]:
        """Return stiffness (6n, 6n), static displacements (N, 6n) per unit motion of each interface, and a solver.

        The solver returns the displacements due to loads (N, k) while the interfaces are held.
        """
        if grip == "rigid":
            shapes = np.zeros((len(self.thermal), 6 * len(self._gripped)))
            for k, rows in enumerate(self._gripped):
                shapes[rows, 6 * k : 6 * k + 6] = self._motions[k][rows]
            solver = self._solver(np.concatenate(self._gripped))
            shapes -= solver(self._product(self._stiffness, shapes))
            return shapes.T @ self._product(self._stiffness, shapes), shapes, solver
        from scipy.linalg import qr

        # loads in equilibrium deform the part in the same way whichever six freedoms of three of its points are held
        points = self.surface.points
        first = int(np.linalg.norm(points - points.mean(0), axis=1).argmax())
        second = int(np.linalg.norm(points - points[first], axis=1).argmax())
        third = int(np.linalg.norm(np.cross(points - points[first], points[second] - points[first]), axis=1).argmax())
        rows = self._rows([first, second, third]).ravel()
        solve_held = self._solver(rows[qr(self._motions[0][rows].T, pivoting=True)[2][:6]])
        origin, motion, means = self._loads[0], self._motions[0], np.hstack(self._loads)
        carried = means[:, 6:].T @ motion  # twists of the other interfaces per unit twist of the first
        loads = means[:, 6:] - origin @ carried.T
        bent = solve_held(loads)
        stiff, relative = np.linalg.inv((loads.T @ bent + bent.T @ loads) / 2), np.hstack([-carried, np.eye(len(carried))])
        elastic = bent @ stiff @ relative
        shapes = elastic + motion @ (np.eye(6, relative.shape[1]) - origin.T @ elastic)

        def solve(given: Array) -> Array:
            moved = solve_held(given - origin @ (motion.T @ given))
            return moved - shapes @ (means.T @ moved)

        return relative.T @ stiff @ relative, shapes, solve

    def _rows(self, points: Sequence[int] | Index) -> Index:
        return np.add.outer(np.arange(3) * len(self.thermal) // 3, points)

    def pictured(self, shapes: Array, most: int) -> tuple[Array, Index, Array, Index]:
        """Return a surface with about ``most`` points: points, triangles, displacements (S, 3, k) by ``shapes`` (N, k), owner.

        A point is the mean of close points of the mesh that are on the same faces of the part.
        """
        used, triangles = np.unique(self.surface.triangles, return_inverse=True)
        surface = Surface(self.surface.points[used], triangles.reshape(-1, 3))
        of_corner = np.unique(np.column_stack([surface.faces.ravel(), np.repeat(self.surface.face, 3)]), axis=0)
        kinds, marks = np.zeros(len(used), dtype=np.int64), np.random.default_rng(0).integers(2**48, size=of_corner.max() + 1)
        np.add.at(kinds, of_corner[:, 0], marks[of_corner[:, 1]])  # equal for points on the same faces
        cluster = clusters(surface, 2 * most, kinds) if len(used) > most else np.arange(len(used))
        surface, kept = merged(surface, cluster)
        displacements = means(np.hstack(list(shapes[self._rows(used)])), cluster).reshape(len(surface.vertices), 3, -1)
        return surface.vertices, surface.faces, displacements, self.owner[kept]

    def modes(self, solve: Callable[[Array], Array], count: int) -> tuple[Array, Array]:
        """Return the squares (m,) [1/s²] of the lowest angular frequencies with held interfaces, and the modes (N, m)."""
        from scipy.sparse.linalg import LinearOperator, eigsh

        def column(product: Callable[[Array], Array]) -> Callable[[Array], Array]:
            return lambda vector: product(vector.reshape(-1, 1)).ravel()

        size = len(self.thermal)
        start = solve(self.with_mass(np.random.default_rng(0).normal(size=(size, 1))))
        mass, inverse = (LinearOperator((size, size), matvec=column(product), dtype=float) for product in (self.with_mass, solve))
        return eigsh(mass, count, M=mass, sigma=0.0, OPinv=inverse, v0=start[:, 0])  # type: ignore[no-any-return]
