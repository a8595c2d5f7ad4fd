"""Stresses in cross-sections: shear stresses of rectangles and rectangular tubes by finite elements, largest von Mises stresses.

The shear stresses of a long beam under a torque T and transverse forces V_y, V_z follow from functions on its section with given
Laplacian, and given normal derivative at the edges (S. P. Timoshenko and J. N. Goodier, Theory of Elasticity, chapters 10 and
11): the warping under torsion, and a flexure function Ψ for each transverse force. They are computed on a quarter of the section
with elements of degree 6, graded towards the inner corner, in any unit of length.

The square of the von Mises stress at a point is a quadratic form of the section wrench with 21 coefficients, one for each product
of two components; these coefficients are called its form. The stresses at many points under many wrenches are therefore one
matrix product.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from kinetostatics.math.arrays import Array

_DEGREE = 6
#: Size of the elements at the inner corner, relative to the shortest length there, and ratio of consecutive sizes.
_SMALLEST, _GROWTH = 0.25, 8.0
#: Ratio of a length to an element above which the length is divided. J and κ have jumps of about 1e-7 where the number of
#: elements changes. This ratio avoids jumps at common ratios of side and wall, such as 8 and 50, as J and κ are differentiated by
#: differences.
_CUT = 1.53
#: Half of a hole, relative to the section, that counts as zero.
_THINNEST = 1e-8


class _Axis:
    """Elements along y or z, from the middle of the section to its edge.

    Attributes:
        nodes: number n of nodes.
        edges: borders of the elements.
        stiffness, mass: (2, n, n) integrals of f'g' and fg of shape functions f, g over two ranges: from the middle to the wall,
            and through the wall.
        moments, slopes: (2, 3, n) integrals of s^k f and s^k f' along the axis s, k = 0, 1, 2, over the same ranges.
    """

    def __init__(self, half: float, wall: float, smallest: float) -> None:
        inner = half - wall if half - wall > _THINNEST * half else 0.0  # a square but for rounding
        steps = smallest * _GROWTH ** np.arange(60)
        edges = [inner + s for s in steps if s < wall / _CUT] + [half]
        if inner > 0:
            edges = [0.0, *[inner - s for s in steps if s < inner / _CUT][::-1], inner, *edges]
        else:
            edges = [0.0, *edges]
        self.edges = np.array(edges)
        count = len(edges) - 1
        points, weights = np.polynomial.legendre.leggauss(_DEGREE + 2)
        self.nodes = n = count * _DEGREE + 1
        self.stiffness, self.mass = np.zeros((2, n, n)), np.zeros((2, n, n))
        self.moments, self.slopes = np.zeros((2, 3, n)), np.zeros((2, 3, n))
        f, df = np.polynomial.legendre.legvander(points, _DEGREE) @ _TO_MODES, _slopes(points)
        for k in range(count):
            size, beyond = edges[k + 1] - edges[k], int(edges[k] >= inner)
            w, s = weights * size / 2, edges[k] + size * (points + 1) / 2
            g = df * 2 / size
            at = slice(k * _DEGREE, (k + 1) * _DEGREE + 1)
            self.stiffness[beyond, at, at] += np.einsum("q,qi,qj->ij", w, g, g)
            self.mass[beyond, at, at] += np.einsum("q,qi,qj->ij", w, f, f)
            powers = w * s ** np.arange(3)[:, None]
            self.moments[beyond][:, at] += powers @ f
            self.slopes[beyond][:, at] += powers @ g

    def nodes_of(self, beyond: int) -> slice:
        """Return the nodes between the middle and the wall if ``beyond`` is 0, the nodes in the wall if ``beyond`` is 1."""
        nodes = np.flatnonzero(self.mass[beyond].diagonal())
        return slice(nodes[0], nodes[-1] + 1) if len(nodes) else slice(0, 0)

    def at(self, points: Array) -> tuple[Array, Array]:
        """Return the matrices (m, n) from nodal values to values, and from nodal values to slopes, at m points.

        At the border of two elements, the slope is that of the outer element.
        """
        which = np.clip(np.searchsorted(self.edges, points, side="right") - 1, 0, len(self.edges) - 2)
        size = np.diff(self.edges)[which]
        local = np.clip(2 * (points - self.edges[which]) / size - 1, -1, 1)
        values, slopes = np.zeros((2, len(points), self.nodes))
        rows, columns = np.arange(len(points))[:, None], which[:, None] * _DEGREE + np.arange(_DEGREE + 1)
        values[rows, columns] = np.polynomial.legendre.legvander(local, _DEGREE) @ _TO_MODES
        slopes[rows, columns] = _slopes(local) * 2 / size[:, None]
        return values, slopes


#: Gauss-Lobatto points, and the matrix from values there to Legendre coefficients.
_LOBATTO = np.concatenate([[-1.0], np.polynomial.legendre.Legendre.basis(_DEGREE).deriv().roots().real, [1.0]])
_TO_MODES = np.linalg.inv(np.polynomial.legendre.legvander(_LOBATTO, _DEGREE))


def _slopes(points: Array) -> Array:
    """Return the slopes (m, degree + 1) of the shape functions of an element at points in [−1, 1]."""
    coefficients = np.polynomial.legendre.legder(_TO_MODES)
    return np.asarray(np.polynomial.legendre.legvander(points, _DEGREE - 1) @ coefficients, dtype=np.float64)


@dataclass(frozen=True)
class ShearFunctions:
    """Shear stresses of one section under torque and transverse forces, in any unit of length.

    Attributes:
        width, height: outer sides along y and z.
        thickness: thickness of the wall; half the smaller side for a solid rectangle.
    """

    width: float
    height: float
    thickness: float

    @cached_property
    def _axes(self) -> tuple[_Axis, _Axis]:
        halves = self.width / 2, self.height / 2
        lengths = [half - self.thickness for half in halves]
        small = _SMALLEST * min([self.thickness, *[length for length in lengths if min(lengths) > 0]])
        y, z = (_Axis(half, self.thickness, small) for half in halves)
        return y, z

    @cached_property
    def _torsion(self) -> tuple[Array, float]:
        """Warping (ny, nz) at the nodes under a unit rate of twist, and the torsion constant J."""
        y, z = self._axes
        right = _over(lambda i, j: np.outer(y.slopes[i, 0], z.moments[j, 1]) - np.outer(y.moments[i, 1], z.slopes[j, 0]))
        warping = _solve(y, z, right[None], odd_y=True, odd_z=True)[0]
        polar = _over(lambda i, j: _area(y, z, i, j, 2, 0) + _area(y, z, i, j, 0, 2))
        # J = ∫ y² + z² + y ∂f/∂z − z ∂f/∂y dA over four quarters
        return warping, float(4 * (polar - np.sum(right * warping)))

    @cached_property
    def _flexure(self) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
        """For V_y and for V_z: Ψ_0 and Ψ_1 (2, ny, nz) at the nodes, with Ψ = Ψ_0 + ν Ψ_1, and their integrals ∫ s Ψ dA (2,)."""
        y, z = self._axes
        along_z, moment_z = _flexure(y, z)
        along_y, moment_y = _flexure(z, y)
        return (np.swapaxes(along_y, 1, 2), moment_y), (along_z, moment_z)

    @property
    def J(self) -> float:
        return self._torsion[1]

    @property
    def area(self) -> float:
        return self.width * self.height - (self.width - 2 * self.thickness) * (self.height - 2 * self.thickness)

    @property
    def second_moments(self) -> tuple[float, float]:
        """∫ y² dA and ∫ z² dA."""
        b, h = self.width, self.height
        inner_b, inner_h = b - 2 * self.thickness, h - 2 * self.thickness
        return (h * b**3 - inner_h * inner_b**3) / 12, (b * h**3 - inner_b * inner_h**3) / 12

    def shear_coefficients(self, poisson_ratio: float) -> tuple[float, float]:
        """Return Cowper's κ for forces along y and z, by his general formula (1966)."""
        nu, moments = poisson_ratio, self.second_moments

        def kappa(axis: int) -> float:
            moment, transverse, (plain, lateral) = moments[axis], moments[1 - axis], self._flexure[axis][1]
            return float(2 * (1 + nu) * moment / (self.area / moment * (plain + nu * lateral) - nu * (moment - transverse) / 2))

        return kappa(0), kappa(1)

    def stresses(self, y: Array, z: Array, poisson_ratio: float) -> Array:
        """Return τ_xy and τ_xz (2, 3, P) at P points of the first quarter under unit V_y, V_z and T.

        ``y`` and ``z`` (P,) are not negative.
        """
        axis_y, axis_z = self._axes
        (value_y, slope_y), (value_z, slope_z) = axis_y.at(y), axis_z.at(z)

        def gradient(function: Array) -> Array:
            return np.array(
                [np.einsum("pi,ij,pj->p", slope_y, function, value_z), np.einsum("pi,ij,pj->p", value_y, function, slope_z)]
            )

        nu = poisson_ratio
        result = np.empty((2, 3, len(y)))
        for axis, moment in enumerate(self.second_moments):
            psi = self._flexure[axis][0]
            along, across = (y, z) if axis == 0 else (z, y)
            lateral = np.empty((2, len(y)))
            lateral[axis], lateral[1 - axis] = (along**2 - across**2) / 2, y * z
            result[:, axis] = (gradient(psi[0] + nu * psi[1]) - nu * lateral) / (2 * (1 + nu) * moment)
        warping, J = self._torsion
        result[:, 2] = (gradient(warping) + np.array([-z, y])) / J
        return result

    def points(self) -> tuple[Array, Array]:
        """Return y and z (P,) of points of the first quarter that suffice for the largest stress (see :meth:`Section.stress`).

        Points closer to the sharp inner corner than both the wall thickness and a quarter of the hole's smaller side are
        excluded: the stress at the corner is unbounded, and in reality limited by the fillet.
        """
        half = np.array([self.width, self.height]) / 2
        t = self.thickness
        hole = half - t
        if hole.min() <= 0:
            y, z = np.meshgrid(*(_spread(size, t, (0.25, 0.5, 1, 1.5, 2.5)) for size in half))
            return y.ravel(), z.ravel()
        near = min(t, *(hole / 2))
        angle = np.radians([-45, 0, 45, 90, 135])
        points = [hole[:, None] + near * np.array([np.cos(angle), np.sin(angle)])]
        for k in (0, 1):
            beyond = hole[k] + t * np.array([1 / 3, 0.7, 1])
            inner = np.linspace(0, hole[k] - near, 3)
            outer = np.append(_spread(hole[k], t, (0.5, 1, 2)), beyond)
            for depth, along in ((0.0, inner), (1.0, outer)):
                pair = along, np.full(len(along), hole[1 - k] + depth * t)
                points.append(np.array(pair if k == 0 else pair[::-1]))
        y, z = np.unique(np.concatenate(points, axis=1), axis=1)
        return y, z


def _spread(end: float, scale: float, distances: tuple[float, ...]) -> Array:
    """Return five equidistant positions from 0 to ``end``, and positions at ``distances`` times ``scale`` before the end."""
    close = [end - d * scale for d in distances if d * scale < end]
    return np.unique([*np.linspace(0, end, 5), *close])


@lru_cache(maxsize=256)
def shear_functions(width: float, height: float, thickness: float) -> ShearFunctions:
    return ShearFunctions(width, height, thickness)


#: Parts of the quarter, by range (hole 0, wall 1) along y and z: both walls, and the corner between them.
_PARTS = (0, 1), (1, 0), (1, 1)


def _over(integrand: Callable[[int, int], Array]) -> Array:
    """Return the sum of an integral over the three parts of a quarter section: both walls and the corner."""
    first, second, corner = (integrand(i, j) for i, j in _PARTS)
    return first + second + corner


def _area(y: _Axis, z: _Axis, i: int, j: int, p: int, q: int) -> Array:
    """Return ∫ y^p z^q dA over the part (i, j) of the quarter section."""
    return np.asarray(y.moments[i, p].sum() * z.moments[j, q].sum())


def _flexure(r: _Axis, s: _Axis) -> tuple[Array, Array]:
    """Return the flexure function of a force along s, Ψ = Ψ_0 + ν Ψ_1 with ∇²Ψ_0 = −2s and ∇²Ψ_1 = 0.

    Returns:
        Ψ_0 and Ψ_1 (2, nr, ns) at the nodes, and their integrals ∫ s Ψ dA (2,).
    """
    load = _over(lambda i, j: 2 * np.outer(r.moments[i, 0], s.moments[j, 1]))
    lateral = _over(
        lambda i, j: (
            np.outer(r.slopes[i, 1], s.moments[j, 1])
            + (np.outer(r.moments[i, 0], s.slopes[j, 2]) - np.outer(r.moments[i, 2], s.slopes[j, 0])) / 2
        )
    )
    psi = _solve(r, s, np.array([load, load + lateral]), odd_y=False, odd_z=True)
    return psi, 4 * np.einsum("ij,kij->k", load / 2, psi)


def _solve(y: _Axis, z: _Axis, right: Array, odd_y: bool, odd_z: bool) -> Array:
    """Return k functions (k, ny, nz) at the nodes, odd or even along y and z.

    ``right`` (k, ny, nz) are the integrals of the given Laplacian and normal derivative times the shape functions.
    """
    ny, nz = y.nodes, z.nodes
    inside = (y.mass[1].diagonal() > 0)[:, None] | (z.mass[1].diagonal() > 0)
    inside[0] &= not odd_y
    inside[:, 0] &= not odd_z
    free = np.flatnonzero(inside.ravel())
    matrix = np.zeros((ny, nz, ny, nz))
    for i, j in _PARTS:  # restricted to the nodes of the part, six times as fast
        at_y, at_z = y.nodes_of(i), z.nodes_of(j)
        stiffness, mass = (m[i, at_y, at_y][:, None, :, None] for m in (y.stiffness, y.mass))
        matrix[at_y, at_z, at_y, at_z] += stiffness * z.mass[j, at_z, at_z][:, None] + mass * z.stiffness[j, at_z, at_z][:, None]
    result = np.zeros((len(right), ny * nz))
    result[:, free] = np.linalg.solve(matrix.reshape(ny * nz, -1)[np.ix_(free, free)], right.reshape(len(right), -1)[:, free].T).T
    return result.reshape(right.shape)


# ---- von Mises stresses ----------------------------------------------------------------------------------------------

_FIRST, _SECOND = np.triu_indices(6)
#: Number of wrenches computed at a time, for the processor's cache.
_CHUNK = 1024
#: Angles on rings at which Newton's method starts; at a maximum, at most half a step away, the square is at most 3.5 % larger.
_STEP = 2 * np.pi / 24
_ANGLES = np.linspace(0, 2 * np.pi, 24, endpoint=False)
_NEAR = 0.965
#: Differences of squares, relative to the largest, that count as rounding errors.
_LEVEL = 1e-11


def von_mises_forms(rows: Array) -> Array:
    """Return σ² + 3 (τ_1² + τ_2²) as quadratic forms (…, 21) of the wrench.

    ``rows`` (…, 3, 6) are the normal stress and both shear stresses under unit wrenches.
    """
    square = np.einsum("k,...ki,...kj->...ij", np.array([1.0, 3.0, 3.0]), rows, rows)
    return np.asarray(square[..., _FIRST, _SECOND] * np.where(_FIRST == _SECOND, 1, 2))


def largest_at_points(forms: Array, wrench: Array) -> Array:
    """Return the largest stress (…) at P points with forms (P, 21) under wrenches (6, …)."""
    return _by_chunks(lambda products: (forms @ products).max(axis=0), wrench)


def largest_on_rings(forms: Array, wrench: Array) -> Array:
    """Return the largest stress (…) on R rings under wrenches (6, …), from forms (R, 8, 21) at eight equidistant angles.

    Around a ring the square of the stress is a + b cos θ + c sin θ + d cos 2θ + e sin 2θ; its largest value is found by Newton's
    method.
    """
    angle = np.linspace(0, 2 * np.pi, 8, endpoint=False)
    to_waves = _waves(angle) * np.array([1, 2, 2, 2, 2])[:, None] / 8
    coefficients = np.einsum("wa,rap->rwp", to_waves, forms)
    at_angles = _waves(_ANGLES)

    def largest(products: Array) -> Array:
        waves = coefficients @ products  # (R, 5, N)
        values = np.einsum("wa,rwn->arn", at_angles, waves)
        result = values.max(axis=(0, 1))
        above = values - np.roll(values, 1, axis=0) > _LEVEL * result
        peaks = above & ~np.roll(above, -1, axis=0) & (values > _NEAR * result)
        start, ring, which = np.nonzero(peaks)
        a, b, c, d, e = waves[ring, :, which].T
        best = _ANGLES[start]
        for _ in range(4):
            _, cos, sin, cos2, sin2 = _waves(best)
            slope = -b * sin + c * cos - 2 * d * sin2 + 2 * e * cos2
            bend = -b * cos - c * sin - 4 * d * cos2 - 4 * e * sin2
            best = best - np.clip(slope / np.where(bend < 0, bend, -np.inf), -_STEP, _STEP)
        np.maximum.at(result, which, np.sum(_waves(best) * np.array([a, b, c, d, e]), axis=0))
        return np.asarray(result)

    return _by_chunks(largest, wrench)


def unit_stresses(forms: Array) -> Array:
    """Return the largest stress (6,) under each single unit component of the wrench, from the forms (…, 21) of all points."""
    return np.sqrt(forms[..., _FIRST == _SECOND].reshape(-1, 6).max(axis=0))


def may_be_largest(units: Array, wrench: Array) -> NDArray[np.bool_]:
    """Return a mask (n, …): True at the sections of a beam that may have its largest stress.

    Args:
        units: (6,) largest stresses under unit components; stresses by axial force and bending occur at one point and add up.
        wrench: (6, n, …) section wrenches.
    """
    alone = units.reshape(6, *[1] * (wrench.ndim - 1)) * np.abs(wrench)
    normal, shear = (alone[0] + alone[4] + alone[5]) ** 2, alone[1:4]
    at_least = np.maximum(normal, (shear**2).max(axis=0)).max(axis=0)
    return np.asarray(normal + shear.sum(axis=0) ** 2 >= (1 - 1e-9) * at_least)


def _waves(angle: Array) -> Array:
    return np.array([np.ones_like(angle), np.cos(angle), np.sin(angle), np.cos(2 * angle), np.sin(2 * angle)])


def _by_chunks(largest: Callable[[Array], Array], wrench: Array) -> Array:
    flat = np.asarray(wrench, dtype=float).reshape(6, -1)
    squares = np.empty(flat.shape[1])
    for start in range(0, flat.shape[1], _CHUNK):
        part = flat[:, start : start + _CHUNK]
        squares[start : start + _CHUNK] = largest(part[_FIRST] * part[_SECOND])
    return np.sqrt(np.maximum(squares, 0)).reshape(np.shape(wrench)[1:])
