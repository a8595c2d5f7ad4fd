"""Equilibrium of the platform on elastic and rigid limbs, Eqs. (11) and (12).

A limb with compliance C along its wrenches J contributes J C⁻¹ Jᵀ to the stiffness. A partly rigid limb has combinations of
wrenches along which it does not deform, its rigid directions. They are constraints on the platform's twist, and their intensities
are Lagrange multipliers (the saddle-point form of the method page, section 6).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinetostatics.limbs.compliance import split_by_eigenvectors, split_rigid
from kinetostatics.limbs.statics import LimbStatics
from kinetostatics.math.arrays import Array, Index, everywhere, is_filled, settles, zeros_for
from kinetostatics.math.linalg import Cholesky
from kinetostatics.statics.robot_statics import RobotStatics

#: Pivots of the scaled stiffness below this value are rounding.
SINGULAR = 1e-14
#: Residual of Eq. (5), relative to the loads, that counts as rounding.
_BALANCED = 1e-12
#: Relative singular value below which rigid wrenches count as dependent.
_DEPENDENT = 1e-9
#: Smallest eigenvalues for the fast solution: of the Gram matrix of rigid wrenches, and of the projected stiffness (relative).
_INDEPENDENT, _HELD = 1e-5, 1e-9


@dataclass(frozen=True)
class CoupledLimbs:
    """All limbs as one: wrenches J_c (6, n, 1, N), compliance C (n, n, 1, N), and decisions as of a group of limbs."""

    J_c: Array
    C: Array
    rigid_directions: int
    soft: tuple[int, ...]

    @property
    def group(self) -> CoupledLimbs:
        return self


@dataclass(frozen=True)
class _Split:
    """The rigid directions and the elastic stiffness of a group of g partly rigid limbs; arrays (g, N, …).

    The intensities of the wrenches J are W = rigid μ + give (Jᵀ Δ − Δ_igc), with the twist Δ of the platform and the displacement
    Δ_igc of the limbs' ends at W = 0. The limbs' compliance does not determine the intensities μ of the rigid directions.
    """

    rigid: Array  # (g, N, n, r)
    give: Array  # (g, N, n, n)
    J: Array  # (g, N, 6, n)

    def resisted(self, displacements: Array) -> Array:
        """Return the intensities give · ``displacements`` (n, S, g, N) of the limbs' ends, for μ = 0."""
        return np.einsum("gnij,jsgn->isgn", self.give, displacements)


class PlatformEquilibrium:
    """The stiffness K = Σ J_ic C_ic⁻¹ J_icᵀ of Eq. (12) at the N poses of a chunk, factorized.

    Attributes:
        scale: (6,) 1 for forces, 1/(characteristic length) for moments.
        compliance, stiffness: (6, 6, N) C = K⁻¹ and K at o; the stiffness is NaN where rigid limbs make it infinite.
        singular: (N,) True where the platform can still move.
        indeterminate: (N,) True where forces in rigid limbs are statically indeterminate.
        undetermined: for each group, (n_c, g, N) True where an intensity is statically indeterminate.
        self_stresses: for each group, (n_c, k, g, N) intensities in k self-stresses, which have no resultant on the platform.
    """

    def __init__(self, robot: RobotStatics, statics: Sequence[LimbStatics | CoupledLimbs], N: int, support: float = 0.0) -> None:
        """Factorize K; ``support`` is added to it, relative to its size, where the platform would be free."""
        self._statics = statics
        self.scale = np.array([1.0] * 3 + [1 / robot.length] * 3)
        K = np.zeros((6, 6, N))
        self._factors: list[Cholesky | _Split | None] = []
        self._halves: list[Array | None] = []
        for item in statics:
            half: Array | None = None
            if item.J_c.shape[1] == 0:
                self._factors.append(None)
            elif item.group.rigid_directions:
                split = _split(item)
                self._factors.append(split)
                K += np.einsum("gnik,gnjk->ijn", split.J @ split.give, split.J)
            else:
                factor = Cholesky(item.C)
                self._factors.append(factor)
                half = factor.forward(np.swapaxes(item.J_c, 0, 1))
                K += np.einsum("kign,kjgn->ijn", half, half)
            self._halves.append(half)
        if support:
            size = np.einsum("iin,i->n", K, self.scale**2)
            K += np.diag(support / self.scale**2)[:, :, None] * np.where(size > 0, size, 1.0)
        self._splits = splits = [factor for factor in self._factors if isinstance(factor, _Split)]
        self._rigid = _RigidPart(K, splits, self.scale) if splits else None
        self.undetermined = [np.zeros((*item.J_c.shape[1:],), dtype=bool) for item in statics]
        self.self_stresses = [np.zeros((item.J_c.shape[1], 0, *item.J_c.shape[2:])) for item in statics]
        if self._rigid is not None:
            self.compliance, self.singular = self._rigid.compliance, self._rigid.singular
            self.indeterminate = self._rigid.undetermined
            self.stiffness = np.full(K.shape, np.nan)
            places = [k for k, factor in enumerate(self._factors) if isinstance(factor, _Split)]
            for k, directions, split in zip(places, self._rigid.self_stresses(splits), splits, strict=True):
                size = np.moveaxis(np.sqrt(np.sum(split.rigid**2, axis=-1)), -1, 0)
                self.undetermined[k] = np.max(np.abs(directions), axis=1, initial=0.0) > _DEPENDENT * np.where(
                    size > 0, size, 1.0
                )
                self.self_stresses[k] = directions
        else:
            self.compliance, self.singular = _invert(K, self.scale)
            self.stiffness, self.indeterminate = K, np.zeros(N, dtype=bool)

    def solve(self, right: Array, strains: Sequence[Array], errors: bool = False) -> tuple[Array, list[Array]]:
        """Return the twists (6, S, N), and for each group the intensities (n_c, S, g, N).

        Δ = K⁻¹ (W − Σ J_ig W_ig + Σ J_ic C_ic⁻¹ Δ_igc), Eq. (12), for the motions that rigid limbs permit.

        Args:
            right: (6, S, N) external wrenches on the platform minus the attached wrenches of the limbs.
            strains: for each group, displacements (n_c, S, g, N) of the limbs' ends along their wrenches at zero intensities.
            errors: whether the last contribution is due to assembly errors, which also displace the ends of rigid limbs.
        """
        total = self.generalized_force(right, strains)
        if self._rigid is None:
            twists = np.einsum("ijn,jsn->isn", self.compliance, total)
            multipliers: list[Array] = []
        else:
            given = [strain for strain, factor in zip(strains, self._factors, strict=True) if isinstance(factor, _Split)]
            twists, multipliers = self._rigid.solve(total, self._splits, given, errors)
        intensities = self._intensities(twists, strains, multipliers)
        if self._rigid is None:
            self._refine(right, twists, intensities)
        return twists, intensities

    def generalized_force(self, right: Array, strains: Sequence[Array]) -> Array:
        """Return W − Σ J_ig W_ig + Σ J_ic C_ic⁻¹ Δ_igc (6, S, N), which times the compliance is the twist; see :meth:`solve`.

        By reciprocity, the product of this wrench and a twist of the platform is the work that all loads do when the robot moves
        with this twist of its platform.
        """
        total = np.array(right, subok=True)
        for factor, half, strain in zip(self._factors, self._halves, strains, strict=True):
            if isinstance(factor, _Split):
                total += np.einsum("gnik,ksgn->isn", factor.J, factor.resisted(strain))
            elif half is not None and isinstance(factor, Cholesky):
                for s in np.flatnonzero(np.any(is_filled(strain), axis=(0, 2, 3))):
                    total[:, s] += np.einsum("kign,kgn->in", half, factor.forward(strain[:, s, None])[:, 0])
        return total

    def with_fixed_platform(self, strains: Sequence[Array]) -> list[Array]:
        """Return for each group the intensities −C_ic⁻¹ Δ_igc (n_c, S, g, N) while the platform is fixed, Eq. (11)."""
        found = []
        for factor, strain in zip(self._factors, strains, strict=True):
            resisted = np.zeros_like(strain) if factor is None else -strain
            if isinstance(factor, Cholesky):
                resisted = factor.solve(resisted)
            elif factor is not None:
                resisted = factor.resisted(resisted)
            found.append(resisted)
        return found

    def intensities(self, twists: Array, right: Array, strains: Sequence[Array]) -> list[Array]:
        """Return for each group the intensities (n_c, S, g, N) at given twists (6, S, N) of the platform; see :meth:`solve`."""
        multipliers: list[Array] = []
        if self._rigid is not None:
            multipliers = self._rigid.multipliers(twists, self.generalized_force(right, strains), self._splits)
        return self._intensities(twists, strains, multipliers)

    def _intensities(self, twists: Array, strains: Sequence[Array], multipliers: list[Array]) -> list[Array]:
        """Return W_ic = C_ic⁻¹ (J_icᵀ Δ − Δ_igc), Eq. (11)."""
        rest = iter(multipliers)
        result: list[Array] = []
        for item, factor, strain in zip(self._statics, self._factors, strains, strict=True):
            if factor is None:
                result.append(np.zeros_like(strain))
                continue
            displacements = np.einsum("kign,ksn->isgn", item.J_c, twists) - strain
            if isinstance(factor, Cholesky):
                result.append(factor.solve(displacements))
                continue
            result.append(factor.resisted(displacements) + np.einsum("gnir,rsgn->isgn", factor.rigid, next(rest)))
        return result

    def _refine(self, right: Array, twists: Array, intensities: list[Array]) -> None:
        """Correct twists and intensities in place by the rounding residual of Eq. (5), W = Σ J_ic W_ic + Σ J_ig W_ig."""
        left = right
        for item, W in zip(self._statics, intensities, strict=True):
            left = left - np.einsum("kign,isgn->ksn", item.J_c, W)
        sizes = np.max(np.abs(right), axis=(1, 2), initial=0.0)
        largest = np.max(np.abs(left), axis=(1, 2), initial=0.0)
        if everywhere(largest <= _BALANCED * np.maximum(sizes, np.max(sizes) * self.scale)):
            return
        step = np.einsum("ijn,jsn->isn", self.compliance, left)
        twists += step
        for item, W, factor in zip(self._statics, intensities, self._factors, strict=True):
            if isinstance(factor, Cholesky):
                W += factor.solve(np.einsum("kign,ksn->isgn", item.J_c, step))


def _split(item: LimbStatics | CoupledLimbs) -> _Split:
    """Return rigid directions and elastic stiffness, by the wrenches ``group.soft``, or where these fail by eigenvectors."""
    r, J = item.group.rigid_directions, np.moveaxis(item.J_c, (2, 3), (0, 1))
    if len(item.group.soft) != len(item.C) - r:
        return _Split(*split_by_eigenvectors(np.moveaxis(item.C, (0, 1), (-2, -1)), r), J)
    rigid, give, sure = split_rigid(item.C, item.group.soft)
    sure = sure | ~np.all(np.isfinite(item.C), axis=(0, 1))
    if not settles(sure):
        rigid[~sure], give[~sure] = split_by_eigenvectors(np.moveaxis(item.C[..., ~sure], 2, 0), r)
    return _Split(rigid, give, J)


def _invert(K: Array, scale: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Return the compliance K⁻¹ (6, 6, N), and a mask (N,): True where the stiffness K (6, 6, N) is singular."""
    factor = Cholesky(K * scale[:, None, None] * scale[None, :, None])
    unit = np.broadcast_to(np.eye(6)[:, :, None], K.shape)
    compliance = factor.solve(unit) * scale[:, None, None] * scale[None, :, None]
    return (compliance + np.swapaxes(compliance, 0, 1)) / 2, ~(factor.smallest_pivot > SINGULAR)


def _by_projection(A: Array, K: Array) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Return the platform's compliance in the motions that rigid limbs permit, and the pseudoinverse A⁺ of the rigid wrenches A.

    With the projection P = 1 − A A⁺ on the permitted motions, the compliance is the pseudoinverse of P K P. A⁺ divides a wrench
    on the platform among the wrenches A.

    Args:
        A: (N, 6, n) unit wrenches along which the limbs are rigid.
        K: (N, 6, 6) stiffness of all elastic parts.

    Returns:
        The compliance (N, 6, 6); A⁺ (N, n, 6); and a mask (N,) of reliable poses, at which the n wrenches are independent and the
        projected stiffness is regular.
    """
    N, _, n = A.shape
    if n > 6:
        return np.zeros((N, 6, 6)), np.zeros((N, n, 6)), np.zeros(N, dtype=bool)
    across = np.swapaxes(A, 1, 2)
    gram = Cholesky(np.moveaxis(across @ A, 0, 2))
    gain = np.moveaxis(gram.inverse(), 2, 0) @ across
    gain = 2 * gain - gain @ A @ gain  # one Newton–Schulz step corrects the error of the normal equations
    sure = gram.smallest_eigenvalue() > _INDEPENDENT
    if n == 6:
        return zeros_for((N, 6, 6), A), gain, sure
    along = A @ gain
    rest = np.eye(6) - along
    mean = np.einsum("nii->n", K) / 6
    mean = np.where(mean > 0, mean, 1.0)[:, None, None]
    factor = Cholesky(np.moveaxis(rest @ (K / mean) @ rest + along, 0, 2))
    inverse = rest @ np.moveaxis(factor.inverse(), 2, 0) @ rest
    return (inverse + np.swapaxes(inverse, 1, 2)) / (2 * mean), gain, sure & (factor.smallest_eigenvalue() > _HELD)


class _RigidPart:
    """Equilibrium of a platform on partly rigid limbs: the motions that they permit, and the intensities along rigid directions.

    Arrays are (N, …), with rotations multiplied, and moments divided, by the characteristic length.
    """

    def __init__(self, K: Array, splits: list[_Split], scale: Array) -> None:
        self.scale = scale
        columns = [np.moveaxis(split.J @ split.rigid, 0, 2) for split in splits]  # (N, 6, g, r)
        J = np.concatenate([column.reshape(*column.shape[:2], -1) for column in columns], axis=2) * scale[:, None]
        N = J.shape[0]
        finite = np.all(np.isfinite(J), axis=(1, 2))
        J = np.where(finite[:, None, None], J, 0.0)
        self.sizes = np.sqrt(np.sum(J * J, axis=1))
        self.sizes = np.where(self.sizes > 0, self.sizes, 1.0)
        A = J / self.sizes[:, None]
        self.K = np.nan_to_num(np.moveaxis(K, 2, 0) * np.outer(scale, scale))
        # multipliers of wrenches in self-equilibrium, and multipliers per unit wrench on the platform
        self.unknown = np.zeros((N, J.shape[2], J.shape[2]))
        self.inverse, self.gain, sure = _by_projection(A, self.K)
        self.singular = ~finite
        if not settles(sure):
            self._by_singular_values(A[~sure], np.flatnonzero(~sure))
        self.undetermined = np.any(np.abs(self.unknown) > _DEPENDENT, axis=(1, 2))
        self.compliance = np.moveaxis(self.inverse * np.outer(scale, scale), 0, 2)

    def _by_singular_values(self, A: Array, poses: Index) -> None:
        """Compute ``inverse``, ``gain``, ``unknown`` and ``singular`` at P poses, for rigid wrenches A (P, 6, n) of any rank.

        ``inverse`` is Z (Zᵀ K Z)⁻¹ Zᵀ, with the motions Z that A permits, ``gain`` A⁺, and ``unknown`` spans the null space of A.
        """
        U, values, V = np.linalg.svd(A, full_matrices=True)
        ranks = np.sum(values > _DEPENDENT * values[:, :1], axis=1)
        for rank in np.unique(ranks):
            which = ranks == rank
            at, own, motions = poses[which], V[which], U[which][:, :, rank:]
            reduced = np.swapaxes(motions, 1, 2) @ self.K[at] @ motions
            self.inverse[at] = 0.0
            if rank < 6:
                largest = np.max(np.einsum("nii->ni", self.K[at]), axis=1)
                bad = ~(np.linalg.eigvalsh(reduced)[:, 0] > 100 * SINGULAR * largest)
                reduced = np.where(bad[:, None, None], np.eye(6 - rank), reduced)
                self.inverse[at] = motions @ np.linalg.solve(reduced, np.swapaxes(motions, 1, 2))
                self.singular[at] |= bad
            gain = np.swapaxes(own[:, :rank], 1, 2) / values[which][:, None, :rank]
            self.gain[at] = gain @ np.swapaxes(U[which][:, :, :rank], 1, 2)
            self.unknown[at, :, : A.shape[2] - rank] = np.swapaxes(own[:, rank:], 1, 2) / self.sizes[at][:, :, None]

    def self_stresses(self, splits: list[_Split]) -> list[Array]:
        """Return, for each partly rigid group, the intensities (n_c, k, g, N) in k self-stresses."""
        result, at = [], 0
        for split in splits:
            g, N, _, r = split.rigid.shape
            part = self.unknown[:, at : at + g * r].reshape(N, g, r, -1)
            result.append(np.einsum("gnir,ngrk->ikgn", split.rigid, part))
            at += g * r
        return result

    def solve(self, right: Array, splits: list[_Split], strains: list[Array], errors: bool = False) -> tuple[Array, list[Array]]:
        """Return the twists (6, S, N), and for each partly rigid group the intensities (r, S, g, N) of its r rigid directions.

        [K A; Aᵀ 0] [Δ; μ] = [W; δ], with the displacements δ of the ends of rigid limbs: Δ = Δ_0 + C (W − K Δ_0), Δ_0 = A⁺ᵀ δ,
        and μ = A⁺ (W − K Δ).
        """
        force = np.moveaxis(right * self.scale[:, None, None], 2, 0)
        given = []
        moves = np.zeros(right.shape[1])
        moves[-1:] = errors
        for split, strain in zip(splits, strains, strict=True):
            along = np.einsum("gnir,isgn->ngrs", split.rigid, strain)
            size = np.einsum("gnir,sgn->ngrs", abs(split.rigid), np.max(abs(strain), axis=0, initial=0.0))
            # no sag along rigid directions; NaN remains where rigid rings are incompatible
            given.append(np.where(np.abs(along) <= _DEPENDENT * size, 0.0, along * moves))
        target = np.concatenate([part.reshape(part.shape[0], -1, part.shape[3]) for part in given], axis=1)
        target = target / self.sizes[:, :, None]
        shift = np.swapaxes(self.gain, 1, 2) @ target
        moved = shift + self.inverse @ (force - self.K @ shift)
        multipliers = self.gain @ (force - self.K @ moved)
        if np.any(target):
            # incompatible assembly errors of rigid limbs
            null = np.einsum("nra,nrs->nas", self.unknown * self.sizes[:, :, None], target)
            against = np.max(np.abs(null), axis=1, initial=0.0) > _DEPENDENT * np.max(np.abs(target), axis=1, initial=0.0)
            moved = np.where(against[:, None], np.nan, moved)
            multipliers = np.where(against[:, None], np.nan, multipliers)
        return np.moveaxis(moved, 0, 2) * self.scale[:, None, None], self._by_group(multipliers, splits)

    def multipliers(self, twists: Array, right: Array, splits: list[_Split]) -> list[Array]:
        """Return, for each partly rigid group, the intensities (r, S, g, N) of its rigid directions at given twists (6, S, N)."""
        force = np.moveaxis(right * self.scale[:, None, None], 2, 0)
        moved = np.moveaxis(twists / self.scale[:, None, None], 2, 0)
        return self._by_group(self.gain @ (force - self.K @ moved), splits)

    def _by_group(self, multipliers: Array, splits: list[_Split]) -> list[Array]:
        multipliers = multipliers / self.sizes[:, :, None]
        parts, at = [], 0
        for split in splits:
            g, N, _, r = split.rigid.shape
            parts.append(multipliers[:, at : at + g * r].reshape(N, g, r, -1).transpose(2, 3, 1, 0))
            at += g * r
        return parts
