"""A link by its matrices: stiffness, mass, and loads of gravity and heat, at its *interfaces* to the neighbouring parts.

The *coordinates* of a link with n interfaces are Tx, Ty, Tz [m], Rx, Ry, Rz [rad] of each interface along its own axes, then m
internal ones, such as the amplitudes of fixed-interface modes (Craig and Bampton, AIAA Journal 6 (1968), 1313-1319). They vanish
in rigid-body motions. Forces on the link are conjugate to the coordinates. Entries of matrices are compared after scaling the
coordinates so that the diagonal of the stiffness is 1. The *residual* of a condition is what should be zero relative to the sum
of the magnitudes of its terms.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field, fields, replace
from functools import cached_property

import numpy as np

from kinetostatics.exceptions import ArgumentError
from kinetostatics.layout.mapping import ShortRepr
from kinetostatics.math.arrays import Array, Index, frozen
from kinetostatics.math.rotations import skew

#: Largest residuals of symmetry and of forces in rigid-body motions, as files with six digits have; of the form of a body's mass.
SYMMETRIC, WITHOUT_FORCE, MASS_OF_BODY = 1e-5, 1e-5, 1e-3
#: Smallest residual that is removed: smaller ones are rounding errors of sums.
ROUNDING = 1e-12
#: Smallest eigenvalue of the scaled stiffness, absolute and relative to the residual of rigid-body motions.
LEAST_STIFFNESS, ABOVE_RESIDUAL = 1e-10, 100.0
MOTIONS = tuple(f"{motion} {axis}" for motion in ("translation along", "rotation about") for axis in "xyz")


@dataclass(frozen=True, repr=False, eq=False)
class LinkMatrices(ShortRepr):
    """A link with n ≥ 2 interfaces and m internal coordinates, by its matrices.

    Rigid-body motions up to the tolerance cause no forces; what remains of these forces is removed from the stiffness.

    Attributes:
        names: (n,) joints of the link, or ``o``, whose frames the interfaces carry.
        origins: (n, 3) origins of the interfaces in the link's frame [m].
        rotations: (n, 3, 3) axes of the interfaces as columns, along the link's axes; (3, 3): of all; default: the link's.
        stiffness: (6n + m, 6n + m) stiffness matrix [N/m, N·m/rad].
        mass: (6n + m, 6n + m) mass matrix [kg, kg·m²], or None.
        gravity: (6n + m, 3) loads due to gravity of 1 m/s² along the link's x, y, z; None: as the mass matrix implies.
        thermal: (6n + m,) loads due to 1 K; None: none.
        points, triangles: surface for pictures, (S, 3) points in the link's frame [m] and (T, 3) numbers of points; None: none.
        recovery: (S, 3, 6n + m) displacements of the points, along the link's axes, per unit of each coordinate.

    Raises:
        ArgumentError: an array has a wrong shape or entries that are not finite, a matrix is not symmetric, the stiffness is not
            positive except in the six rigid-body motions, the mass is not that of a body; the message names the entry.
    """

    names: tuple[str, ...]
    origins: Array
    rotations: Array = field(default_factory=lambda: np.eye(3), kw_only=True)
    stiffness: Array
    mass: Array | None = None
    gravity: Array | None = None
    thermal: Array | None = None
    points: Array | None = None
    triangles: Index | None = None
    recovery: Array | None = None

    def __post_init__(self) -> None:
        names = tuple(map(str, self.names))
        object.__setattr__(self, "names", names)
        if len(names) < 2 or len(set(names)) < len(names):
            raise ArgumentError(
                f"names: {', '.join(names) or 'none'}; two or more interfaces with different names would be right"
            )
        for matrix in fields(self)[1:]:
            given = getattr(self, matrix.name)
            if given is not None:
                object.__setattr__(self, matrix.name, _numbers(matrix.name, given))
        n, size = len(names), self.stiffness.shape[0] if self.stiffness.ndim else 0
        if self.rotations.shape == (3, 3):
            object.__setattr__(self, "rotations", frozen(np.tile(self.rotations, (n, 1, 1))))
        sides = [() if array is None else array.shape[:1] for array in (self.points, self.triangles, self.recovery)]
        if sides.count(()) not in (0, 3):
            raise ArgumentError("points, triangles, recovery: all of them, or none, would be right")
        shapes = {"origins": (n, 3), "rotations": (n, 3, 3), "stiffness": (max(size, 6 * n),) * 2, "mass": (size, size)}
        shapes |= {"gravity": (size, 3), "thermal": (size,), "points": (*sides[0], 3), "triangles": (*sides[1], 3)}
        for name, shape in (shapes | {"recovery": (*sides[0], 3, size)}).items():
            array = getattr(self, name)
            if array is not None and array.shape != shape:
                raise ArgumentError(f"{name} has the shape {array.shape}; {shape} would be right for {n} interfaces")
        self._check_rotations()
        self._check_stiffness()
        self._check_mass()
        self._check_loads()
        self._check_surface()

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, LinkMatrices):
            return NotImplemented
        pairs = ((getattr(self, field.name), getattr(other, field.name)) for field in fields(self))
        return all((a is None) == (b is None) and (a is None or np.array_equal(a, b)) for a, b in pairs)

    def __hash__(self) -> int:
        return hash((self.names, self.stiffness.tobytes()))

    @property
    def digest(self) -> str:
        """The sha256 of all values."""
        result = hashlib.sha256(repr(self.names).encode())
        for name in (item.name for item in fields(self)[1:]):
            array = getattr(self, name)
            result.update(name.encode() if array is None else array.tobytes())
        return result.hexdigest()

    # ---- sizes and rigid-body motions

    @property
    def interfaces(self) -> int:
        """The number n of interfaces."""
        return len(self.names)

    @property
    def internal(self) -> int:
        """The number m of internal coordinates."""
        return len(self.stiffness) - 6 * len(self.names)

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names (6n + m,) of the coordinates, such as "Tx of elbow" and "internal 1"."""
        at_interfaces = [f"{kind}{axis} of {name}" for name in self.names for kind in "TR" for axis in "xyz"]
        return (*at_interfaces, *(f"internal {k + 1}" for k in range(self.internal)))

    @cached_property
    def rigid_motions(self) -> Array:
        """Coordinates (6n + m, 6) of the rigid-body motions with unit twists [d; r] at the origin of the link, along its axes."""
        return frozen(self.motions_about(np.zeros(3)))

    @cached_property
    def mean_motion(self) -> Array:
        """Map (6, 6n + m) of the coordinates to the link's twist: the mean of those to which each interface would move it."""
        blocks = [np.linalg.inv(self.rigid_motions[6 * k : 6 * k + 6]) for k in range(self.interfaces)]
        return frozen(np.hstack([*blocks, np.zeros((6, self.internal))]) / self.interfaces)

    # ---- statics

    @cached_property
    def condensed(self) -> Array:
        """Static stiffness (6n, 6n) of the interfaces: the internal coordinates follow them without force."""
        ports = 6 * self.interfaces
        reduced = self.stiffness[:ports] @ self._static_shapes
        return frozen((reduced + reduced.T) / 2)

    @cached_property
    def gravity_loads(self) -> Array:
        """Loads (6n + m, 3) due to gravity of 1 m/s² along x, y, z: given, else those of the mass matrix, else zero."""
        if self.gravity is None and self.mass is not None:
            return frozen(self.mass @ self.rigid_motions[:, :3])
        return frozen(np.zeros((len(self.stiffness), 3))) if self.gravity is None else self.gravity

    def flexibility(self, inner: int | str) -> Array:
        """Return the compliance (6(n − 1), 6(n − 1)) [m/N, …] of the other interfaces while the interface ``inner`` is held."""
        keep = self._others(inner)
        inverse = np.linalg.inv(self.condensed[np.ix_(keep, keep)])
        return frozen((inverse + inverse.T) / 2)

    def displacements_by_gravity(self, inner: int | str) -> Array:
        """Return the coordinates (6(n − 1), 3) of the others due to 1 m/s² along x, y, z while ``inner`` is held."""
        return self._free_displacements(inner, self.gravity_loads)

    def displacements_by_heat(self, inner: int | str) -> Array:
        """Return the coordinates (6(n − 1),) of the others due to 1 K while ``inner`` is held."""
        thermal = np.zeros(len(self.stiffness)) if self.thermal is None else self.thermal
        return self._free_displacements(inner, thermal)

    def _free_displacements(self, inner: int | str, loads: Array) -> Array:
        reduced = self._static_shapes.T @ loads
        return frozen(self.flexibility(inner) @ reduced[self._others(inner)])

    def _others(self, inner: int | str) -> list[int]:
        if isinstance(inner, str) and inner not in self.names:
            raise ArgumentError(f"the link has no interface {inner!r}; it has {', '.join(self.names)}")
        held = self.names.index(inner) if isinstance(inner, str) else range(self.interfaces)[inner]
        return [k for k in range(6 * self.interfaces) if k // 6 != held]

    @property
    def _static_shapes(self) -> Array:
        """Coordinates (6n + m, 6n) per unit of those of the interfaces, without forces on the internal ones."""
        ports = 6 * self.interfaces
        inner = -np.linalg.solve(self.stiffness[ports:, ports:], self.stiffness[ports:, :ports])
        return np.vstack([np.eye(ports), inner])

    # ---- mass

    @cached_property
    def weight(self) -> tuple[float, Array]:
        """Mass [kg] and centre of mass (3,) [m], in the link's frame, by the loads due to gravity."""
        return _mass_and_centre(self.rigid_motions.T @ self.gravity_loads)

    @cached_property
    def body(self) -> tuple[float, Array, Array] | None:
        """Mass [kg], centre of mass (3,) [m] and inertia (3, 3) about it [kg·m²], in the link's frame; None without ``mass``."""
        if self.mass is None:
            return None
        rigid = self.rigid_motions.T @ self.mass @ self.rigid_motions
        mass, centre = _mass_and_centre(rigid[:, :3])
        return mass, frozen(centre), frozen(rigid[3:, 3:] + mass * skew(centre) @ skew(centre))

    def with_body(self, mass: float, centre: Array, inertia: Array) -> LinkMatrices:
        """Return the link with the mass of a rigid body that rides on the mean of its interfaces, if it has no mass matrix.

        Args:
            mass, centre, inertia: mass [kg], centre of mass (3,) [m] and inertia (3, 3) about it [kg·m²], in the link's frame.
        """
        if self.mass is not None or mass == 0:
            return self
        first = mass * skew(np.asarray(centre, float))
        second = np.asarray(inertia, float) - first @ skew(np.asarray(centre, float))
        matrix = self.mean_motion.T @ np.block([[mass * np.eye(3), -first], [first, second]]) @ self.mean_motion
        return replace(self, mass=matrix)

    def differences(self, mass: float, centre: Array, inertia: Array, within: float = 0.01) -> list[str]:
        """Return in words how the matrices differ from a body by more than the fraction ``within``; arguments: `with_body`.

        Differences of the centre of mass are relative to the link's size, those of the inertia to its largest entry.
        """
        if self.mass is None and self.gravity is None:
            return []
        inertia = np.asarray(inertia, float)
        body, centre = (*self.weight, inertia) if self.body is None else self.body, np.asarray(centre, float)
        words = []
        if abs(body[0] - mass) > within * body[0]:
            words.append(f"the mass is {body[0]:.6g} kg by its matrices, but {mass:.6g} kg is given")
        if np.linalg.norm(body[1] - centre) > within * self._size:
            words.append(f"the centre of mass is at {_vector(body[1])} m by its matrices, but {_vector(centre)} m is given")
        gap = np.abs(body[2] - inertia)
        if gap.max() > within * np.abs(body[2]).max():
            row, column = sorted(np.unravel_index(int(gap.argmax()), (3, 3)))
            values = f"{body[2][row, column]:.6g} kg·m² by its matrices, but {inertia[row, column]:.6g} kg·m² is given"
            words.append(f"i{'xyz'[row]}{'xyz'[column]} about the centre of mass is {values}")
        return words

    # ---- checks

    def motions_about(self, point: Array) -> Array:
        """Return the coordinates (6n + m, 6) of the rigid-body motions with unit twists at a point (3,) of the link's frame."""
        blocks = []
        for origin, axes in zip(self.origins - point, self.rotations, strict=True):
            blocks.append(np.block([[axes.T, -axes.T @ skew(origin)], [np.zeros((3, 3)), axes.T]]))
        return np.vstack([*blocks, np.zeros((self.internal, 6))])

    def coordinates_of(self, at: Array) -> Array:
        """Return the coordinates (6n + m, 6n + m) by unit twists [d; r] of interfaces at points (n, 3), and internal ones."""
        result = np.eye(len(self.stiffness))
        for rows, point in zip(np.arange(6 * self.interfaces).reshape(-1, 6), at, strict=True):
            result[np.ix_(rows, rows)] = self.motions_about(point)[rows]
        return result

    @property
    def _scales(self) -> Array:
        return np.asarray(np.sqrt(np.diag(self.stiffness)))

    @property
    def _size(self) -> float:
        """The largest distance [m] of an interface from their mean, or the length that compares rotations with translations."""
        squares = np.diag(self.stiffness)[: 6 * self.interfaces].reshape(-1, 2, 3).sum((0, 2))
        spread = np.linalg.norm(self.origins - self.origins.mean(0), axis=1).max()
        return max(float(spread), float(np.sqrt(squares[1] / squares[0])))

    def _check_rotations(self) -> None:
        for name, axes in zip(self.names, self.rotations, strict=True):
            residual = np.abs(axes.T @ axes - np.eye(3)).max()
            if residual > SYMMETRIC or np.linalg.det(axes) < 0:
                why = f"residual {residual:.2g}" if residual > SYMMETRIC else "left-handed"
                raise ArgumentError(
                    f"rotations: that of {name} is no rotation ({why}); right-handed orthonormal columns would be right"
                )

    def _check_symmetry(self, name: str, scales: Array) -> None:
        matrix = getattr(self, name)
        scaled = matrix / np.outer(scales, scales)
        gap = np.abs(scaled - scaled.T) / max(np.abs(scaled).max(), np.finfo(float).tiny)
        if gap.max() > SYMMETRIC:
            row, column = np.unravel_index(int(gap.argmax()), gap.shape)
            entry = f"row {self.coordinates[row]}, column {self.coordinates[column]}, is {matrix[row, column]:.6g}"
            mirror = f"but {matrix[column, row]:.6g} with row and column exchanged (residual {gap.max():.2g})"
            raise ArgumentError(f"{name} is not symmetric: the entry in {entry}, {mirror}; equal entries would be right")
        object.__setattr__(self, name, frozen((matrix + matrix.T) / 2))

    def _check_stiffness(self) -> None:
        K = self.stiffness
        least = int(np.diag(K).argmin())
        if K[least, least] <= 0:
            where = f"the entry on the diagonal at {self.coordinates[least]}"
            raise ArgumentError(f"stiffness: {where} is {K[least, least]:.6g}; a positive number would be right")
        scales = self._scales
        self._check_symmetry("stiffness", scales)
        scaled = self.stiffness / np.outer(scales, scales)
        motions = self.motions_about(self.origins.mean(0)) / np.repeat([1.0, self._size], 3)
        forces = self.stiffness @ motions
        sums = (np.abs(self.stiffness) @ np.abs(motions)).max(1)
        sums[6 * self.interfaces :] = scales[6 * self.interfaces :] * (scales[:, None] * np.abs(motions)).max()
        gap = np.abs(forces) / sums[:, None]
        residual = gap.max()
        if residual > WITHOUT_FORCE:
            row, column = np.unravel_index(int(gap.argmax()), gap.shape)
            what = f"a rigid {MOTIONS[column]} of the link causes a force along {self.coordinates[row]} (residual {residual:.2g})"
            remedy = "none would be right; see that origins are in metres, and axes and order of the coordinates as documented"
            raise ArgumentError(f"stiffness: {what}; {remedy}")
        basis = np.linalg.qr(scales[:, None] * motions, mode="complete")[0]
        values, vectors = np.linalg.eigh(basis[:, 6:].T @ scaled @ basis[:, 6:])
        if values[0] < max(LEAST_STIFFNESS, ABOVE_RESIDUAL * residual):
            strongest = self.coordinates[int(np.abs(basis[:, 6:] @ vectors[:, 0]).argmax())]
            what = "a negative stiffness" if values[0] < -LEAST_STIFFNESS else "no stiffness"
            where = f"against a motion that is no rigid-body motion, most along {strongest} (eigenvalue {values[0]:.2g})"
            raise ArgumentError(f"stiffness: the link has {what} {where}; a positive one would be right")
        if residual > ROUNDING:
            elastic = basis[:, 6:] @ (basis[:, 6:].T @ scaled @ basis[:, 6:]) @ basis[:, 6:].T
            object.__setattr__(self, "stiffness", frozen((elastic + elastic.T) / 2 * np.outer(scales, scales)))

    def _check_mass(self) -> None:
        if self.mass is None:
            return
        scales = self._scales
        self._check_symmetry("mass", scales)
        values, vectors = np.linalg.eigh(self.mass / np.outer(scales, scales))
        if values[0] < -SYMMETRIC * values[-1]:
            strongest = self.coordinates[int(np.abs(vectors[:, 0]).argmax())]
            raise ArgumentError(
                f"mass: the link has a negative mass in a motion, most along {strongest}; a positive one would be right"
            )
        self._check_body("mass", self.mass @ self.rigid_motions[:, :3])

    def _check_body(self, name: str, loads: Array) -> tuple[float, Array]:
        """Check that the loads (6n + m, 3) of unit accelerations have in sum the form of a body's; return its mass and centre."""
        total = self.motions_about(self.origins.mean(0)).T @ loads
        mass, centre = _mass_and_centre(total)
        if mass <= 0:
            raise ArgumentError(f"{name}: the link has a mass of {mass:.6g} kg; a positive one would be right")
        gap = np.abs(total - np.vstack([mass * np.eye(3), mass * skew(centre)])) / mass
        gap[3:] /= self._size
        if gap.max() > MASS_OF_BODY:
            row, column = np.unravel_index(int(gap.argmax()), gap.shape)
            what = f"in sum, a rigid {MOTIONS[row]} has {total[row, column]:.6g} for an acceleration along {'xyz'[column]}"
            right = f"the mass {mass:.6g} kg in each direction, and moments about one centre of mass, would be right"
            raise ArgumentError(f"{name}: {what} (residual {gap.max():.2g}); {right}")
        return mass, centre

    def _check_loads(self) -> None:
        if self.gravity is not None:
            mass, centre = self._check_body("gravity", self.gravity)
            if self.body is not None:
                body = self._check_body("mass", self.mass @ self.rigid_motions[:, :3])  # type: ignore[operator]
                if abs(body[0] - mass) > MASS_OF_BODY * mass or np.linalg.norm(body[1] - centre) > MASS_OF_BODY * self._size:
                    own_mean = f"{body[0]:.6g} kg at {_vector(body[1] + self.origins.mean(0))} m"
                    given = f"{mass:.6g} kg at {_vector(centre + self.origins.mean(0))} m"
                    raise ArgumentError(
                        f"gravity: its loads are those of {given}, but mass has {own_mean}; equal ones would be right"
                    )
        if self.thermal is not None:
            motions = self.motions_about(self.origins.mean(0)) / np.repeat([1.0, self._size], 3)
            total = (np.abs(motions).T @ np.abs(self.thermal)).max()
            residuals = np.abs(motions.T @ self.thermal) / max(total, np.finfo(float).tiny)
            worst = int(residuals.argmax())
            if residuals[worst] > MASS_OF_BODY:
                where = f"do work in a rigid {MOTIONS[worst]} of the link (residual {residuals[worst]:.2g})"
                raise ArgumentError(f"thermal: its loads {where}; loads in equilibrium would be right")

    def _check_surface(self) -> None:
        if self.points is None or self.triangles is None or self.recovery is None:
            return
        if not np.isin(self.triangles, np.arange(len(points := self.points))).all():
            raise ArgumentError(f"triangles: numbers of points, 0 to {len(points) - 1}, would be right")
        object.__setattr__(self, "triangles", frozen(self.triangles.astype(np.int64)))
        middle, unit = self.origins.mean(0), np.repeat([1.0, self._size], 3)
        right = np.moveaxis(np.hstack([np.zeros((3, 3, len(points))) + np.eye(3)[:, :, None], -skew((points - middle).T)]), 2, 0)
        gap = np.abs(self.recovery @ self.motions_about(middle) - right) / unit
        if gap.max(initial=0.0) > WITHOUT_FORCE * np.abs(right / unit).max():
            row, _, column = np.unravel_index(int(gap.argmax()), gap.shape)
            what = f"in a rigid {MOTIONS[column]} of the link the point {row} moves otherwise (residual {gap.max():.2g})"
            raise ArgumentError(f"recovery: {what}; displacements along the link's axes, by unit coordinates, would be right")


def _numbers(name: str, given: object) -> Array:
    try:
        array = np.array(given, dtype=float)
    except (TypeError, ValueError):
        raise ArgumentError(f"{name} is no array of numbers") from None
    if not np.isfinite(array).all():
        where = ", ".join(str(index) for index in np.argwhere(~np.isfinite(array))[0])
        raise ArgumentError(f"{name}: the entry [{where}] is {array[~np.isfinite(array)][0]}; a finite number would be right")
    return frozen(array)


def _mass_and_centre(total: Array) -> tuple[float, Array]:
    """Return mass and centre of mass (3,) of a body from its forces and moments (6, 3) against unit accelerations."""
    mass, moments = float(np.trace(total[:3])) / 3, total[3:]
    first = np.array([moments[2, 1] - moments[1, 2], moments[0, 2] - moments[2, 0], moments[1, 0] - moments[0, 1]]) / 2
    return mass, first / mass if mass else first


def _vector(vector: Array) -> str:
    return "(" + ", ".join(f"{number:.4g}" for number in vector) + ")"
