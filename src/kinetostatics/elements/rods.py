"""Exact dynamic stiffness of a uniform Timoshenko rod with rotary inertia.

At the square λ = ω² of the angular frequency the state y (displacements and section forces) of a rod obeys y′ = A(λ) y, and the
forces on its ends follow from the transfer matrix exp(A L) without discretization (W. H. Wittrick and F. W. Williams, Quarterly
Journal of Mechanics and Applied Mathematics 24, 1971; S. P. Timoshenko, Vibration Problems in Engineering, section 55). The
entries of the transfer matrix are entire functions of λ, computed by their power series, and λ may be complex.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinetostatics.math.arrays import Array, Index, Mask
from kinetostatics.math.rotations import skew

#: Real or complex numbers.
Numbers: TypeAlias = NDArray[Any]

#: Terms of the power series, enough for λ up to the lowest λ of the rod with clamped ends.
_TERMS = 22
#: Least ratio of the λ of clamped rods to λ, for convergence of the series.
_MARGIN = 1.2
#: Imaginary step of λ by which D is differentiated, relative to λ: its square vanishes against 1.
_STEP = 1e-40
#: First root of cos x cosh x = 1: the bending frequency of a clamped rod is its square times √(EI/μ)/L².
_CLAMPED = 4.730040744862704


@dataclass(frozen=True)
class Rod:
    """Uniform rods; arrays have any common shape.

    Attributes:
        length: [m].
        compliances: (6,) compliances of sections: 1/EA, 1/κGA along y and z [1/N]; 1/GJ, 1/EI about y and z [1/(N·m²)].
        density: mass per length [kg/m].
        gyration: (2,) squares of the radii of gyration about y and z, I_y/A and I_z/A [m²].
        eccentricity: (3, …) vector from the centre line to the line of mass, in beam axes [m]; None: zero.
    """

    length: Array
    compliances: Array
    density: Array
    gyration: Array
    eccentricity: Array | None = None

    @property
    def inner(self) -> int:
        return 0

    def take(self, poses: Index) -> Rod:
        arm = None if self.eccentricity is None else self.eccentricity[:, poses]
        return Rod(self.length[poses], self.compliances, self.density[poses], self.gyration, arm)

    def piece(self, count: int) -> Rod:
        """Return one of ``count`` equal pieces of the rod."""
        return replace(self, length=self.length / count)

    def axial_stiffness(self) -> Array:
        """Return EA/L [N/m]."""
        return np.asarray(1 / (self.compliances[0] * self.length))

    def inside(self, ends: Array, forces: Array, square: Array, fraction: float) -> Array:
        """Return displacement and rotation (…, 6) at a fraction of the length.

        Args:
            ends, forces: (…, 12) motions of the ends, and forces on them, at λ (…).
        """
        start = np.concatenate([ends[..., :6], -forces[..., :6]], axis=-1)
        T = self.transfer(square, fraction * self.length)
        return np.asarray((T[..., :6, :] @ start[..., None])[..., 0])

    def clamped_square(self) -> Array:
        """Return a lower bound of the lowest λ [1/s²] of the rod with clamped ends: 1/λ ≤ Σ 1/λ_k, Dunkerley's formula."""
        L, c, own = self.length, self.compliances, self.gyration
        arm = 0.0 if self.eccentricity is None else np.sum(self.eccentricity**2, axis=0)
        bending = L**4 / _CLAMPED**4 * max(c[4], c[5])
        flexible = [c[0], c[1], c[2], c[3] * (own.sum() + arm)]  # each as of a string: π² / L²
        slopes = max(c[4], c[5]) * (own.max() + arm) / 4  # rotary inertia
        total = self.density * (bending + (sum(flexible) + slopes) * L**2 / np.pi**2)
        with np.errstate(divide="ignore"):  # a rod without mass
            return np.asarray(1 / (total if self.eccentricity is None else 2 * total))

    def dynamic_stiffness(self, square: Numbers) -> Numbers:
        """Return the dynamic stiffness (…, 12, 12) at λ (…) [1/s²].

        Rows and columns: displacement and rotation of the start, displacement and rotation of the end, in beam axes; forces on
        the rod. Above the lowest λ of the rod with clamped ends, it is that of two halves without the point between them.
        """
        far = self._far(square)
        if not np.any(far):
            return self._straight(square) if self.eccentricity is None else self._eccentric(square)
        found = np.empty((*np.shape(square), 12, 12), dtype=square.dtype)
        found[..., ~far, :, :] = self.dynamic_stiffness(square[..., ~far])
        found[..., far, :, :] = _in_series(self.piece(2).dynamic_stiffness(square[..., far]))
        return found

    def clamped_modes(self, square: Array) -> Index:
        """Return the number J (…) of modes below λ (…) of the rod with clamped ends.

        J = 2 J_half + s(D_ee + D_ss), with the number s of negative eigenvalues and the ends e and s of the two halves.
        """
        far, found = self._far(square), np.zeros(np.shape(square), dtype=np.intp)
        if np.any(far):
            D = self.piece(2).dynamic_stiffness(square[..., far])
            middle = np.linalg.eigvalsh(D[..., :6, :6] + D[..., 6:, 6:])
            found[..., far] = 2 * self.piece(2).clamped_modes(square[..., far]) + np.sum(middle < 0, axis=-1)
        return found

    def _far(self, square: Numbers) -> Mask:
        """Return for the last axis of λ where it may exceed the lowest λ of the rod with clamped ends."""
        return np.asarray(np.any(_MARGIN * np.abs(square) > self.clamped_square(), axis=tuple(range(np.ndim(square) - 1))))

    def pencil(self, square: Array) -> tuple[Array, Array]:
        """Return K̃ and M̃ (…, 12, 12) of D(λ) = K̃ − λ M̃ with M̃ = −dD/dλ at λ (…).

        K̃ and M̃ are stiffness and mass matrices with the exact shapes of the rod at λ; for λ = 0, with the static shapes under
        end forces.
        """
        step = _STEP * np.maximum(square, 1.0)
        D = self.dynamic_stiffness(square + 1j * step)
        M = -D.imag / step[..., None, None]
        return D.real + square[..., None, None] * M, M

    def _straight(self, square: Numbers) -> Numbers:
        """Return D without eccentricity: k x cot x and −k x/sin x of extension, k = EA/L, and torsion, k = GJ/L; and bending."""
        c, L = self.compliances, self.length
        whole = square * self.density
        found = np.zeros((*np.broadcast_shapes(np.shape(L), np.shape(square)), 12, 12), dtype=np.result_type(square, L))
        for first, flexibility, mass in ((0, c[0], 1.0), (3, c[3], self.gyration.sum())):
            cosine, sine = _series(whole * mass * flexibility * L**2)
            stiffness = 1 / (flexibility * L * sine)
            found[..., first, first] = found[..., first + 6, first + 6] = stiffness * cosine
            found[..., first, first + 6] = found[..., first + 6, first] = -stiffness
        for shift, turn, shear, bend, about, sign in ((1, 5, c[1], c[5], 1, 1), (2, 4, c[2], c[4], 0, -1)):
            ww, wp, pp, across, mixed, turned = _bending(whole * bend * L**4, shear / (bend * L**2), self.gyration[about] / L**2)
            force, lever, moment = 1 / (bend * L**3), sign / (bend * L**2), 1 / (bend * L)
            a, b, d, e = shift, turn, shift + 6, turn + 6
            found[..., a, a] = found[..., d, d] = ww * force
            found[..., a, b] = found[..., b, a] = wp * lever
            found[..., d, e] = found[..., e, d] = -wp * lever
            found[..., b, b] = found[..., e, e] = pp * moment
            found[..., a, d] = found[..., d, a] = across * force
            found[..., a, e] = found[..., e, a] = mixed * lever
            found[..., b, d] = found[..., d, b] = -mixed * lever
            found[..., b, e] = found[..., e, b] = turned * moment
        return found

    def _eccentric(self, square: Numbers) -> Numbers:
        """Return the dynamic stiffness of a rod with eccentric mass, which couples extension, torsion and bending.

        With the transfer matrix [[a, b], [c, d]] it is [[b⁻¹ a, −b⁻¹], [−b⁻ᵀ, d b⁻¹]].
        """
        T = self.transfer(square, self.length)
        ahead = np.linalg.inv(T[..., :6, 6:])
        found = np.empty_like(T)
        found[..., :6, :6] = ahead @ T[..., :6, :6]
        found[..., :6, 6:] = -ahead
        found[..., 6:, :6] = np.swapaxes(-ahead, -1, -2)
        found[..., 6:, 6:] = T[..., 6:, 6:] @ ahead
        return found

    def transfer(self, square: Numbers, length: Array) -> Numbers:
        """Return the transfer matrix exp(A L) (…, 12, 12) at λ (…) over a length L (…) [m].

        A is the matrix of u′ = θ × e_x + c n, θ′ = c m, n′ = −λ μ (u + θ × e), m′ = −e_x × n − λ μ (i θ + e × (u + θ × e)), with
        the squares i of the radii of gyration and the eccentricity e.

        Rows and columns: displacement, rotation, and force and moment of the outer part on the inner part, in beam axes.
        """
        shape = np.broadcast_shapes(np.shape(length), np.shape(square))
        mass = np.zeros((*shape, 6, 6))
        mass[..., :3, :3] = np.eye(3)
        mass[..., 3:, 3:] = np.diag([self.gyration.sum(), *self.gyration])
        if self.eccentricity is not None:
            arm = np.broadcast_to(np.moveaxis(skew(self.eccentricity), (0, 1), (-2, -1)), (*shape, 3, 3))
            mass[..., :3, 3:], mass[..., 3:, :3] = -arm, arm
            mass[..., 3:, 3:] -= arm @ arm
        A = np.zeros((*shape, 12, 12), dtype=np.result_type(square, length))
        A[..., 1, 5], A[..., 2, 4] = 1.0, -1.0  # u′ = θ × e_x + c n
        A[..., :6, 6:] = np.diag(self.compliances)
        A[..., 6:, :6] = -(square * self.density)[..., None, None] * mass
        A[..., 10, 8], A[..., 11, 7] = 1.0, -1.0  # m′ = −e_x × n − λ …
        size = np.broadcast_to(self.length, shape)
        force, one = 1 / (max(self.compliances[4:]) * size**2), np.ones(shape)
        units = np.stack([size] * 3 + [one] * 3 + [force] * 3 + [force * size] * 3, axis=-1)
        T = _exponential(A * np.broadcast_to(length, shape)[..., None, None] * units[..., None, :] / units[..., :, None])
        return T * units[..., :, None] / units[..., None, :]


@dataclass(frozen=True, eq=False)
class VibratingMatrices:
    """Stiffness and mass (6n + m, 6n + m) of a link in vibrations; its m = ``inner`` internal coordinates remain coordinates."""

    stiffness: Array
    mass: Array
    inner: int

    def take(self, poses: Index) -> VibratingMatrices:
        return self

    def piece(self, count: int) -> VibratingMatrices:
        return self

    def dynamic_stiffness(self, square: Numbers) -> Numbers:
        """Return D(λ) = K − λ M."""
        return self.stiffness - square[..., None, None] * self.mass

    def pencil(self, square: Array) -> tuple[Array, Array]:
        shape = (*square.shape, *self.stiffness.shape)
        return np.broadcast_to(self.stiffness, shape), np.broadcast_to(self.mass, shape)

    def clamped_square(self) -> Array:
        return np.full((1, 1), np.inf)

    def clamped_modes(self, square: Array) -> Index:
        return np.zeros(square.shape, dtype=np.intp)

    def inner_coordinates(self, ends: Array, square: Array, load: Array) -> Array:
        """Return the internal coordinates (…, m) for twists of the ends (…, 6n), at λ, under loads (…, m); 0 in resonance."""
        D, n = self.dynamic_stiffness(square), ends.shape[-1]
        forces = load - (D[..., n:, :n] @ ends[..., None])[..., 0]
        return np.asarray((np.linalg.pinv(D[..., n:, n:]) @ forces[..., None])[..., 0])

    def axial_stiffness(self) -> Array:
        raise TypeError("links by matrices are not telescopic")

    def inside(self, ends: Array, forces: Array, square: Array, fraction: float) -> Array:
        raise TypeError("links by matrices have no inside")


def _in_series(D: Numbers) -> Numbers:
    """Return the dynamic stiffness (…, 12, 12) of two equal rods, one after the other, from that of each.

    The displacement v of the point between them is eliminated from (D_ee + D_ss) v + D_es u_start + D_se u_end = 0.
    """
    start, across, end = D[..., :6, :6], D[..., :6, 6:], D[..., 6:, 6:]
    ahead = np.concatenate([np.swapaxes(across, -1, -2), across], axis=-1)  # forces on the point between them
    found = -np.swapaxes(ahead, -1, -2) @ np.linalg.solve(start + end, ahead)
    found[..., :6, :6] += start
    found[..., 6:, 6:] += end
    return np.asarray(found)


def _series(x: Numbers) -> tuple[Numbers, Numbers]:
    """Return cos √x and sin √x / √x."""
    cosine, sine = np.ones_like(x), np.ones_like(x)
    for n in range(_TERMS, 0, -1):
        cosine = 1 - x / ((2 * n - 1) * 2 * n) * cosine
        sine = 1 - x / (2 * n * (2 * n + 1)) * sine
    return cosine, sine


def _bending(x: Numbers, s: Array, r: Array) -> tuple[Numbers, ...]:
    """Return the entries of the dynamic stiffness of bending, divided by EI/L³, EI/L² or EI/L.

    With deflection and slope w₀, p₀ at the start and w₁, p₁ at the end, the order of the entries is (w₀, w₀), (w₀, p₀), (p₀, p₀),
    (w₀, w₁), (w₀, p₁), (p₀, p₁).

    Args:
        x: λ μ L⁴ / EI.
        s: EI / (κGA L²).
        r: ρI / (μ L²).
    """
    p, q = (s + r) * x, s * r * x**2 - x  # A⁴ + p A² + q = 0
    # A²ⁿ = a + b A²; exp(A) = C0 + C1 A + C2 A² + C3 A³
    a, b = np.ones_like(q), np.zeros_like(q)
    C0, C1, C2, C3 = a, a, b, b
    over = 1.0
    for n in range(1, _TERMS + 1):
        a, b = -q * b, a - p * b
        over /= 2 * n * (2 * n - 1)
        C0, C2 = C0 + a * over, C2 + b * over
        C1, C3 = C1 + a * (over / (2 * n + 1)), C3 + b * (over / (2 * n + 1))
    shear, turn = C1 - s * x * C3, C1 - r * x * C3
    ww, pp = C0 - s * x * C2, C0 - r * x * C2  # by displacements at the start
    wp, pw = turn - s * x * C3, x * C3
    wq, wm = s * shear - C3, C2  # by forces at the start
    D = wq * turn + wm**2
    return (
        (turn * ww - wm * pw) / D,
        (turn * wp - wm * pp) / D,
        (wm * wp + wq * pp) / D,
        -turn / D,
        wm / D,
        -wq / D,
    )


def _exponential(A: Numbers) -> Numbers:
    """Return exp(A) (…, n, n) by scaling, power series and squaring."""
    squarings = max(0, int(np.ceil(np.log2(np.abs(A).sum(axis=-1).max(initial=1e-9)))))
    scaled = A / 2**squarings
    found = term = np.broadcast_to(np.eye(A.shape[-1]), A.shape).astype(A.dtype)
    for n in range(1, _TERMS):
        term = term @ scaled / n
        found = found + term
    for _ in range(squarings):
        found = found @ found
    return found
