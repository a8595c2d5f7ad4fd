"""Natural frequencies and modes, D(λ) u = 0, with the dynamic stiffness D and the square λ = ω² of the angular frequency.

At the k-th λ the k-th smallest eigenvalue of D(λ) vanishes. Below the lowest frequency of the robot's rods with clamped ends, D
is concave in λ, and the k-th root of its linearization K̃ − λ M̃ is an upper bound of the k-th root of D. Newton's method
therefore descends to the k-th root from the bound of Rayleigh and Ritz, however close other roots are: no mode is missed or found
twice.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from kinetostatics.elements.rods import Numbers
from kinetostatics.exceptions import ArgumentError
from kinetostatics.math.arrays import Array, Index, Mask
from kinetostatics.statics.small_motions import signs_of_modes
from kinetostatics.vibration.vibration_model import VibrationModel

#: Part of the largest stiffness or mass of scaled motions below which a motion has zero stiffness or mass.
_NONE = 1e-11
#: Part of the largest stiffness of scaled motions above which a negative stiffness is no rounding error of forces.
_UNSTABLE = 1e-9
#: Relative change of λ at which Newton's method ends; the remaining error is of the order of its square.
_CONVERGED = 1e-7
_STEPS = 30
#: Largest number of modes times the cube of coordinates, for a time of a minute and a memory of 1 GB.
_LARGEST = 5e9
#: Least ratio of the λ of clamped rods to the largest requested λ.
_MARGIN = 1.6
#: Relative difference of λ below which modes belong to one eigenspace.
_EQUAL = 1e-8
#: Part of the largest motion below which a motion, or a difference of motions, counts as zero.
_MOVES = 1e-4


@dataclass(frozen=True)
class Eigenpairs:
    """The lowest modes of N poses.

    Attributes:
        square: λ = ω² (N, m), ascending [1/s²]; infinite where there are fewer modes, NaN where a motion has negative stiffness.
        free: (N,) number of motions without stiffness, whose frequency is zero; they are not among the modes.
        shapes: (N, m, n) modes in the coordinates of ``model``, with modal masses of 1 kg.
        model: the robot, with beams divided as required by these modes.
    """

    square: Array
    free: Index
    shapes: Array
    model: VibrationModel


def eigenpairs(model: VibrationModel, count: int) -> Eigenpairs:
    while True:
        if count * model.coordinates**3 > _LARGEST:
            raise ArgumentError(
                f"count is {count}: so many modes are too expensive, because they divide the beams until the robot has "
                f"{model.coordinates} coordinates; count times the cube of coordinates may be at most {_LARGEST:.0e}"
            )
        K, M = model.static_pencil
        spaces = list(_spaces(model))
        square, free = np.full((model.poses, count), np.nan), np.zeros(model.poses, dtype=np.intp)
        for space in spaces:
            square[space.poses], free[space.poses] = space.bounds(K, M, count), space.free
        divided = model.divided(_MARGIN * float(np.nanmax(square, initial=0.0)))
        if divided is None:
            break
        model = divided
    shapes = np.zeros((model.poses, count, model.coordinates))
    for space in spaces:
        square[space.poses], shapes[space.poses] = space.exact(model.take(space.poses), square[space.poses])
    return Eigenpairs(square, free, shapes, model)


def modes_below(model: VibrationModel, square: Array) -> Index:
    """Return the number (N, m) of modes below λ (N, m), including frequency zero.

    It is J(λ) = Σ J_clamped(λ) + s(D(λ)), the number s of negative eigenvalues of D(λ) and that of modes of the pieces of beams
    with clamped ends (Wittrick and Williams).
    """
    found = sum(
        (item.pieces * item.piece.clamped_modes(square) for item in model.beams.values()), np.zeros(square.shape, dtype=np.intp)
    )
    for space in _spaces(model):
        D = space.restricted(model.take(space.poses).dynamic_stiffness(square[space.poses]))
        found[space.poses] += np.sum(np.linalg.eigvalsh(_scaled(D)[0]) < 0, axis=-1)
        found[space.poses] = np.maximum(found[space.poses], space.free)  # of which rounding may hide some close to λ = 0
    return found


def independent_motions(model: VibrationModel) -> list[tuple[Index, Array | None]]:
    """Return groups of P stable poses, each with a basis (P, n, r) of motions that keep loops closed and have stiffness or mass.

    None instead of a basis stands for all motions.
    """
    return [(space.poses, space.basis) for space in _spaces(model) if space.stable]


@dataclass(frozen=True)
class _Space:
    """Poses with the same number r of independent motions, which keep loops closed and have stiffness or mass.

    ``basis`` (P, n, r) has these motions as columns, or is None if all coordinates are independent; ``free`` is the number of
    motions without stiffness. ``stable`` is False where a motion has negative stiffness, which springs and weights may cause.
    """

    poses: Index
    basis: Array | None
    free: int
    stable: bool = True

    def restricted(self, matrix: Numbers) -> Array:
        """Return Zᵀ A Z of matrices A (P, …, n, n), with the basis Z."""
        if self.basis is None:
            return matrix
        Z = self.basis.reshape(len(self.basis), *(1,) * (matrix.ndim - 3), *self.basis.shape[1:])
        return np.asarray(np.swapaxes(Z, -1, -2) @ matrix @ Z)

    def bounds(self, K: Array, M: Array, count: int) -> Array:
        """Return upper bounds (P, count) of λ by Rayleigh and Ritz; infinite where there are fewer modes, NaN if unstable."""
        K, M = self.restricted(K[self.poses]), self.restricted(M[self.poses])
        found = np.full((len(K), count), np.inf if self.stable else np.nan)
        if not self.stable:
            return found
        stiffness, mass = np.einsum("nii->n", K), np.einsum("nii->n", M)
        shift = np.where((stiffness > 0) & (mass > 0), stiffness, 1.0) / np.where(mass > 0, mass, 1.0)
        for _ in range(2):  # second step with the shift at the lowest λ, for accurate differences
            values = _roots(K, M, shift)[0][:, self.free : self.free + count]
            found[:, : values.shape[1]] = values
            shift = np.where(np.isfinite(found[:, 0]), found[:, 0], shift)
        return found

    def exact(self, model: VibrationModel, square: Array) -> tuple[Array, Array]:
        """Return λ (P, m) and modes (P, m, n), from upper bounds ``square`` of λ (P, m)."""
        modes, finite, bounds = np.arange(square.shape[1]), np.isfinite(square), square
        if not np.any(finite):
            return square, np.full((*square.shape, model.coordinates), np.nan)
        modes = modes[np.any(finite, axis=0)]  # modes without a frequency at any pose are the last ones
        square, finite = np.where(finite, square, 1.0)[:, modes], finite[:, modes]
        for _ in range(_STEPS):
            K, M = (self.restricted(matrix) for matrix in model.pencil(square))
            found = _roots(K, M, square)[0][:, modes, self.free + modes]
            change = np.abs(found - square)[finite] / square[finite]
            square = np.where(finite, found, 1.0)
            if change.max(initial=0.0) < _CONVERGED:
                break
        at = np.array(square)  # a common λ for all modes of an eigenspace
        for k in modes[1:]:
            at[:, k] = np.where(at[:, k] - at[:, k - 1] < _EQUAL * at[:, k], at[:, k - 1], at[:, k])
        K, M = (self.restricted(matrix) for matrix in model.pencil(at))
        values, vectors = _roots(K, M, at, True)
        if self.basis is not None:
            vectors = self.basis[:, None] @ vectors
        shapes = vectors[:, modes, :, self.free + modes].swapaxes(0, 1)
        _align(shapes, vectors, np.abs(values - at[..., None]) < _EQUAL * at[..., None], self.free, model.platform)
        found = np.full((*bounds.shape, model.coordinates), np.nan)
        found[:, modes] = np.where(finite[..., None], shapes, np.nan)
        bounds[:, modes] = np.where(finite, square, bounds[:, modes])
        return bounds, found


def _align(shapes: Array, vectors: Array, equal: Mask, free: int, platform: Array) -> None:
    """Normalize modes (N, m, n) in place: reproducible bases of eigenspaces, and signs by :func:`signs_of_modes`.

    In an eigenspace, the first mode has the largest possible displacement of the platform along x, the other modes have none; the
    second mode has the largest possible displacement along y, and so on for the rotations and for all coordinates. A component
    that is zero in the whole eigenspace is left out.

    Args:
        shapes: the modes.
        vectors: (N, m, n, r) all eigenvectors at the λ of each mode.
        equal: (N, m, r) True for the eigenvectors in the eigenspace of each mode.
        free: number of modes of frequency zero, the first eigenvectors.
        platform: see :class:`VibrationModel`.
    """
    sizes = equal.sum(axis=-1)
    for size in np.unique(sizes[sizes > 1]):
        poses, k = np.nonzero(sizes == size)
        mine = np.nonzero(equal[poses, k])[1].reshape(-1, size)
        space = np.take_along_axis(vectors[poses, k], mine[:, None], axis=2)
        along = np.concatenate([platform[poses] @ space[:, : platform.shape[2]], space], axis=1)
        least = _MOVES * np.linalg.norm(along, axis=2).max(axis=1)
        turn, count = np.zeros((len(poses), size, size)), np.zeros(len(poses), dtype=int)
        for row in np.moveaxis(along, 1, 0)[..., None]:
            rest = (row - turn @ (np.swapaxes(turn, 1, 2) @ row))[..., 0]
            length = np.linalg.norm(rest, axis=1)
            new = (length > least) & (count < size)
            turn[new, :, count[new]] = rest[new] / length[new, None]
            count += new
            if np.all(count == size):
                break
        shapes[poses, k] = (space @ turn[np.arange(len(poses)), :, free + k - mine[:, 0], None])[..., 0]
    twists = np.einsum("nik,nmk->nmi", platform, shapes[..., : platform.shape[2]])
    shapes *= signs_of_modes(shapes, twists, _MOVES)


def static_displacements(model: VibrationModel, forces: Array) -> Array:
    """Return displacements (N, n, k) of all coordinates under k constant forces (N, n, k), none along free motions."""
    displacements, K, whole = np.zeros(forces.shape), model.static_pencil[0], _without_cancellation(model)
    for poses, basis in model.closed_motions():
        space = _Space(poses, basis, 0)
        scaled, size = _scaled(space.restricted(K[poses]), space.restricted(whole[poses]))
        values, axes = np.linalg.eigh(scaled)
        motions = axes / size[..., None] if basis is None else basis @ (axes / size[..., None])
        compliances = np.where(values > _NONE, 1 / np.where(values > _NONE, values, 1.0), 0.0)
        displacements[poses] = motions @ (compliances[..., None] * (np.swapaxes(motions, 1, 2) @ forces[poses]))
    return displacements


def _without_cancellation(model: VibrationModel) -> Array:
    """Return the stiffness (N, n, n) without the cancellation of stiffnesses of opposite signs."""
    whole, n = np.array(model.static_pencil[0]), model.cancelling.shape[1]
    whole[:, :n, :n] += model.cancelling
    return whole


def _spaces(model: VibrationModel) -> Iterator[_Space]:
    """Yield groups of poses with equal numbers of independent motions, and of independent motions without stiffness.

    Poses at which a motion has negative stiffness are separate groups.
    """
    K, M = model.static_pencil
    whole = _without_cancellation(model)
    for poses, basis in model.closed_motions():
        every = _Space(poses, basis, 0)
        values = np.linalg.eigvalsh(_scaled(every.restricted(K[poses]), every.restricted(whole[poses]))[0])
        unstable = np.any(values < -_UNSTABLE, axis=1) | (False if model.buckled is None else model.buckled[poses])
        missing = np.where(unstable, -1, np.sum(values < _NONE, axis=1))
        for free in np.unique(missing):
            some = np.flatnonzero(missing == free)
            space = _Space(poses[some], None if basis is None else basis[some], max(int(free), 0), free >= 0)
            yield from _with_mass(space, K[poses[some]], M[poses[some]], whole[poses[some]]) if free > 0 else [space]


def _with_mass(space: _Space, K: Array, M: Array, whole: Array) -> Iterator[_Space]:
    """Yield groups of poses with equal numbers of motions, after motions without stiffness and mass are omitted."""
    K, M = space.restricted(K), space.restricted(M)
    scaled, size = _scaled(K, space.restricted(whole))
    axes = np.linalg.eigh(scaled)[1] / size[:, :, None]
    free, stiff = axes[..., : space.free], axes[..., space.free :]
    masses = np.einsum("pii->pi", M)
    # orthonormal with respect to the masses of the coordinates, so that the number without mass is independent of the basis
    unit = np.sqrt(masses + _NONE * masses.max(axis=1, keepdims=True))
    unit = np.where(unit > 0, unit, 1.0)
    free = np.linalg.qr(unit[..., None] * free)[0] / unit[..., None]
    values, turn = np.linalg.eigh(np.swapaxes(free, 1, 2) @ M @ free)
    missing = np.sum(values < _NONE, axis=1)
    for number in np.unique(missing):
        some = np.flatnonzero(missing == number)
        if not number:
            yield _Space(space.poses[some], None if space.basis is None else space.basis[some], space.free)
            continue
        basis = np.concatenate([(free[some] @ turn[some])[..., number:], stiff[some]], axis=2)
        yield _Space(space.poses[some], basis if space.basis is None else space.basis[some] @ basis, space.free - int(number))


def _scaled(matrix: Array, by: Array | None = None) -> tuple[Array, Array]:
    """Return symmetric matrices (…, n, n) scaled to diagonal entries 1, or near 0 for rounding errors; and the scale (…, n).

    ``by`` (…, n, n): matrices that the scale gives the diagonal entries 1 instead.
    """
    size = np.sqrt(np.abs(np.einsum("...ii->...i", matrix if by is None else by)))
    largest = size.max(axis=-1, keepdims=True, initial=0.0)
    size = np.where(size > _NONE * largest, size, np.where(largest > 0, largest, 1.0))
    return matrix / (size[..., :, None] * size[..., None, :]), size


def _roots(K: Array, M: Array, shift: Array, modes: bool = False) -> tuple[Array, Array]:
    """Return all λ (…, n) of K u = λ M u, ascending, and modes (…, n, n) of modal mass 1; λ is infinite for modes without mass.

    Args:
        K, M: (…, n, n) positive semidefinite matrices.
        shift: (…) a positive λ, near which the roots are most accurate.
        modes: whether to compute modes; otherwise these are undefined.
    """
    S, size = _scaled(K + shift[..., None, None] * M)
    L = np.linalg.cholesky(S)
    A = np.linalg.solve(L, M / (size[..., :, None] * size[..., None, :]))
    A = np.linalg.solve(L, np.swapaxes(A, -1, -2))
    vectors = A
    if modes:
        values, vectors = np.linalg.eigh(A)
        masses = np.maximum(values, _NONE * values[..., -1:])
        vectors = np.linalg.solve(np.swapaxes(L, -1, -2), vectors / np.sqrt(np.where(masses > 0, masses, 1.0))[..., None, :])
        vectors = (vectors / size[..., :, None])[..., ::-1]
    else:
        values = np.linalg.eigvalsh(A)
    values = values[..., ::-1]
    with np.errstate(divide="ignore"):
        return np.where(values > _NONE**2 * values[..., :1], 1 / values - shift[..., None], np.inf), vectors
