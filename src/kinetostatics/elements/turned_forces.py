"""Geometric stiffness of the forces in a straight beam: their second-order potential energy as its ends and its inside move.

The beam is geometrically exact (J. C. Simo, Computer Methods in Applied Mechanics and Engineering 49, 1985). A section with the
force F and the moment M turns by θ, with the strains γ and κ; the weight q per length acts at the arm r from the axis. To second
order, the energy is ∫ −F · (θ × γ) − ½ M · (θ × κ) − ½ F · (θ × (θ × e_x)) − ½ q · (θ × (θ × r)) ds.

Between its ends the beam deforms as under a wrench at its platform end, plus *inner coordinates*: amplitudes of polynomials that
vanish at both ends, deflections with their slopes; of strains γ without rotation whose mean is zero; and of rotations 6 ξ (1 − ξ)
that opposite shear strains compensate. They are orthogonal to the former in the strain energy, in which their stiffness is 1.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from kinetostatics.elements.beam_formulas import end_displacement, of_arm
from kinetostatics.math.arrays import Array, settles, zeros_for
from kinetostatics.math.linalg import NO_PIVOT, solve_by_elimination

#: Number of inner polynomials of each deflection and of torsion; relative error of Euler's loads below 2e-6.
EACH = 5
#: Number of polynomials of each of the strains γ.
EACH_STRAIN = 3
#: Number of inner coordinates of a beam: deflection about z, deflection about y, torsion; strains along x, y and z; rotations
#: about z and y with opposite shear strains.
INNER = 3 * EACH + 3 * EACH_STRAIN + 2
#: Order of their elimination: first the strains, which K couples with rotations only.
_ORDER = 9 + np.array([*range(3 * EACH, INNER - 2), *range(3 * EACH), INNER - 2, INNER - 1])
#: Fractions of the length at which section forces are given; between them, they are cubic polynomials.
NODES = np.array([0.0, 1 / 3, 2 / 3, 1.0])

_Polynomial = np.polynomial.Polynomial
_POINTS, _WEIGHTS = (np.polynomial.legendre.leggauss(12) + np.array([[1.0], [0.0]])) / 2


def _inner(order: int) -> list[_Polynomial]:
    """Return polynomials on 0 … 1, whose derivatives below ``order`` vanish at both ends and are orthonormal at ``order``."""
    s = _Polynomial([0, 1])
    legendre = [np.polynomial.Legendre.basis(k, domain=[0, 1]).convert(kind=_Polynomial) for k in range(EACH)]
    found = [(4 * s * (1 - s)) ** order * item for item in legendre]
    strains = np.array([f.deriv(order)(_POINTS) for f in found])
    basis = np.linalg.inv(np.linalg.cholesky(np.einsum("q,iq,jq->ij", _WEIGHTS, strains, strains)))
    return [sum((factor * f for factor, f in zip(row, found, strict=True)), _Polynomial([0])) for row in basis]


#: Inner polynomials of the deflection.
DEFLECTIONS = _inner(2)
#: Polynomials of the rotations: constant, by the wrench at the end, and inner ones, about x and about y or z.
_TORSION = [_Polynomial([1]), _Polynomial([0, 1]), *_inner(1)]
_BENDING = [_Polynomial([1]), _Polynomial([0, 1]), _Polynomial([0, 0, 1]), *(f.deriv() for f in DEFLECTIONS)]
_X, _Y = len(_TORSION), len(_BENDING)
_ABOUT = (slice(0, _X), slice(_X, _X + _Y), slice(_X + _Y, _X + 2 * _Y))
_STRAIN, _EVERY = _X + 2 * _Y, _X + 2 * _Y + 3 * (1 + EACH_STRAIN)
_VALUES = [np.array([f(_POINTS) for f in basis]) for basis in (_TORSION, _BENDING, _BENDING)]
_SLOPES = [np.array([f.deriv()(_POINTS) for f in basis]) for basis in (_TORSION, _BENDING, _BENDING)]
_AT_NODES = np.array([np.prod([(_POINTS - x) / (node - x) for x in NODES if x != node], axis=0) for node in NODES])


def _products(first: Array, second: Array) -> Array:
    """Return ∫ ℓ f g (4, i, j) with Lagrange's polynomials ℓ of the nodes."""
    return np.asarray(np.einsum("q,nq,iq,jq->nij", _WEIGHTS, _AT_NODES, first, second))


#: ∫ ℓ f g of rotations about two axes, and of the rotation about the first and the strain about the second.
_TURNS = {(a, b): _products(_VALUES[a], _VALUES[b]) for a in range(3) for b in range(3)}
_BENDS = {(a, b): _products(_VALUES[a], _SLOPES[b]) for a in range(3) for b in range(3)}
_LEGENDRE = [np.polynomial.Legendre.basis(k, domain=[0, 1])(_POINTS) * np.sqrt(2 * k + 1) for k in range(1 + EACH_STRAIN)]
_STRAINS = [_products(values, np.array(_LEGENDRE)) for values in _VALUES]
#: ∫ ℓ f of the strains κ and γ.
_CURVED = [_products(slopes, np.ones((1, len(_POINTS))))[:, :, 0] for slopes in _SLOPES]
_STRETCHED = _products(np.array(_LEGENDRE), np.ones((1, len(_POINTS))))[:, :, 0]


def _of_strain(axis: int) -> slice:
    return slice(_STRAIN + axis * (1 + EACH_STRAIN), _STRAIN + (axis + 1) * (1 + EACH_STRAIN))


def _amplitudes(c: Array, length: Array, like: Array) -> Array:
    """Return the amplitudes of all rotations, and the strains γ, per unit of each coordinate of :class:`UniformInside`."""
    N, L = length.shape[0], length
    found = zeros_for((_EVERY, 9 + INNER, N), like, length)
    x, y, z = (about.start for about in _ABOUT)
    found[x, 0], found[y, 1], found[z, 2] = 1.0, 1.0, 1.0
    found[x + 1, 6] = c[3] * L
    found[y + 1, 7], found[y + 1, 5], found[y + 2, 5] = c[4] * L, -c[4] * L**2, c[4] * L**2 / 2
    found[z + 1, 8], found[z + 1, 4], found[z + 2, 4] = c[5] * L, c[5] * L**2, -c[5] * L**2 / 2
    for k in range(3):
        first = _of_strain(k).start
        found[first, 3 + k] = c[k]
        for j in range(EACH_STRAIN):
            found[first + 1 + j, 9 + 3 * EACH + k * EACH_STRAIN + j] = np.sqrt(c[k] / L)
    for column, row, bend, shear, sign in ((7 + INNER, z, 5, 1, -1.0), (8 + INNER, y, 4, 2, 1.0)):
        size = _opposite(c[bend], c[shear], L)
        found[row + 1, column], found[row + 2, column] = 6 * size, -6 * size
        found[_of_strain(shear).start, column] = sign * size
    units = np.broadcast_to(np.eye(6)[:, :, None], (6, 6, N))
    bends = solve_by_elimination(end_displacement(c[:, :, None], length, units), units)
    found[:, 3:9] = np.einsum("aln,lbn->abn", found[:, 3:9], bends)
    for k in range(EACH):
        for first, row, number in ((9, z + 3, 5), (9 + EACH, y + 3, 4), (9 + 2 * EACH, x + 2, 3)):
            found[row + k, first + k] = np.sqrt(c[number] * L)
    return found


def _opposite(bend: Array, shear: Array, length: Array) -> Array:
    """Return the amplitude of a rotation 6 ξ (1 − ξ) and the opposite shear strain whose strain energy is ½."""
    size: Array = np.sqrt(shear * bend * length / (12 * shear + bend * length**2))
    return size


def without_inner(K: Array, given: Array) -> Array:
    """Eliminate the inner coordinates, whose stiffness is 1, from the geometric stiffness K of :class:`UniformInside`.

    Args:
        given: (b, S, N) inner coordinates under S loads, without K.

    Returns:
        (9, 9 + S, N) stiffness with respect to the other coordinates, and the forces on them by load; NaN where a beam buckles
        between fixed ends.
    """
    b = len(given)
    first = _ORDER if b == INNER else np.arange(9, 9 + b)
    order = np.concatenate([first, np.arange(9)])
    loads = np.concatenate([-given[first - 9], zeros_for((9, *given.shape[1:]), K)])
    a = np.concatenate([K[np.ix_(order, order)], loads], axis=1)
    a[:b, :b] += np.eye(b)[:, :, None]
    sizes, left, sure = np.sum(np.abs(a[:b, :b]), axis=1), np.array(a, order="C", subok=True), np.ones(K.shape[2], bool)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        for size in sizes:
            sure = sure & (np.abs(left[0, 0]) > NO_PIVOT * size)
            pivot, row, left = left[0, 0], left[0, 1:], left[1:, 1:]
            left -= (row[: len(left)] / pivot)[:, None] * row
    upper = np.triu_indices(9)
    left[upper[::-1]] = left[upper]  # a record thus needs no lower triangle
    if not settles(sure):
        some = a[..., ~sure]
        x = solve_by_elimination(some[:b, :b], some[:b, b:])
        left[..., ~sure] = some[b:, b:] - np.einsum("abn,bcn->acn", some[b:, :b], x)
    return left


@dataclass(frozen=True)
class UniformInside:
    """The inside of a uniform beam with ``compliances`` (6,) of its sections.

    Attributes:
        nodes: fractions of the length at which section forces are given.
        count: number of inner coordinates.
    """

    compliances: Array
    nodes: ClassVar[Array] = NODES
    count: ClassVar[int] = INNER

    def turned_forces(self, length: Array, sections: Array, load: Array, lever: Array | None) -> Array:
        """Return the geometric stiffness (9 + INNER, 9 + INNER, N) of the section forces of beams, in beam axes.

        It is Qᵀ H Q, with the quadratic form H of the energy at the top of the module in the amplitudes of rotations and
        strains. Its coordinates are the rotation of the base end, displacement and rotation of the platform end relative to a
        rigid-body motion with the base end, and the inner coordinates.

        Args:
            sections: (6, 4, N) forces and moments of the outboard on the inboard part at the nodes, about the axis [N, N·m].
            load: (3, N) weight per length [N/m].
            lever: (3, N) vector from the beam's axis to the line of its mass [m]; None: zero.
        """
        N, c = length.shape[0], self.compliances[:, None]
        H = zeros_for((_EVERY, _EVERY, N), sections, length)

        def add(rows: slice, columns: slice, block: Array) -> None:
            H[rows, columns] += block
            H[columns, rows] += np.swapaxes(block, 0, 1)

        force, moment = sections[:3] * length, sections[3:]
        for a in (1, 2):
            add(_ABOUT[a], _ABOUT[a], np.einsum("kij,kn->ijn", _TURNS[a, a], force[0]) / 2)
            add(_ABOUT[0], _ABOUT[a], np.einsum("kij,kn->ijn", _TURNS[0, a], force[a]) / -2)
        for a, b, k in ((1, 2, 0), (2, 0, 1), (0, 1, 2)):  # M_k (θ_a κ_b − θ_b κ_a), F_k (θ_a γ_b − θ_b γ_a)
            change = _BENDS[a, b] - np.swapaxes(_BENDS[b, a], 1, 2)
            add(_ABOUT[a], _ABOUT[b], np.einsum("kij,kn->ijn", change, moment[k]) / -2)
            for turn, strain, sign in ((a, b, -1), (b, a, 1)):
                add(_ABOUT[turn], _of_strain(strain), sign * np.einsum("kij,kn->ijn", _STRAINS[turn], force[k]))
        if lever is not None:
            arms = of_arm(load, lever) * length
            for a in range(3):
                for b in range(3):
                    H[_ABOUT[a], _ABOUT[b]] += _TURNS[a, b].sum(axis=0)[:, :, None] * arms[a, b]
        Q, H = (np.array(np.moveaxis(matrix, 2, 0), order="C", subok=True) for matrix in (_amplitudes(c, length, H), H))
        found: Array = np.moveaxis(np.swapaxes(Q, 1, 2) @ (H @ Q), 0, 2)
        return found

    def inner_deflections(self, length: Array, sections: Array) -> Array:
        """Return the inner coordinates η_k = ∫ [γ_k; κ_k] · w ds (INNER, …) under section forces w (6, 4, …).

        [γ_k; κ_k] are the strains per unit of η_k, see :meth:`turned_forces`; the stiffness of η_k is 1.
        """
        c, found = self.compliances, []
        for axis, first in ((2, 3), (1, 3), (0, 2)):
            sizes = np.sqrt(c[3 + axis] * length)
            found.append(np.einsum("ki,k...->i...", _CURVED[axis][:, first:], sections[3 + axis]) * sizes)
        for axis in range(3):
            found.append(np.einsum("ki,k...->i...", _STRETCHED[:, 1:], sections[axis]) * np.sqrt(c[axis] * length))
        for axis, bend, shear, sign in ((2, 5, 1, -1.0), (1, 4, 2, 1.0)):
            turned = np.tensordot(6 * (_CURVED[axis][:, 1] - _CURVED[axis][:, 2]), sections[3 + axis], 1)
            strained = np.tensordot(_STRETCHED[:, 0], sections[shear], 1) * (sign * length)
            found.append((_opposite(c[bend], c[shear], length) * (turned + strained))[None])
        return np.concatenate(found)

    def inner_lines(self, length: Array, fractions: Array, inner: Array) -> Array:
        """Return displacements and rotations (6, S, …) [m, rad] at fractions (S,) of beams under inner coordinates (INNER, …)."""
        c, found = self.compliances, np.zeros((6, len(fractions), *inner.shape[1:]))

        def add(row: int, size: Array, shape: _Polynomial, amplitude: Array) -> None:
            found[row] += np.multiply.outer(shape(fractions), size * amplitude)

        for k in range(EACH):
            for first, row, sign, turn in ((0, 1, 1.0, 5), (EACH, 2, -1.0, 4)):
                size = np.sqrt(c[turn] * length)
                add(row, sign * size * length, DEFLECTIONS[k], inner[first + k])
                add(turn, size, DEFLECTIONS[k].deriv(), inner[first + k])
            add(3, np.sqrt(c[3] * length), _TORSION[2 + k], inner[2 * EACH + k])
        for axis in range(3):
            for j in range(EACH_STRAIN):
                shape = np.polynomial.Legendre.basis(j + 1, domain=[0, 1]).convert(kind=_Polynomial).integ() * np.sqrt(2 * j + 3)
                add(axis, np.sqrt(c[axis] * length), shape, inner[3 * EACH + axis * EACH_STRAIN + j])
        shape = _Polynomial([0, 0, 3, -2])
        for number, row, sign, bend, shear in ((-2, 1, 1.0, 5, 1), (-1, 2, -1.0, 4, 2)):
            size = _opposite(c[bend], c[shear], length)
            add(row, sign * size * length, shape - _Polynomial([0, 1]), inner[number])
            add(bend, size, shape.deriv(), inner[number])
        return found
