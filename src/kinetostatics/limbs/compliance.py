"""Deformation of limbs: compliance C_ic, Eq. (1), and sag Δ_igc, Eqs. (16), (19), (21). The wrench in an elastic element is the
sum of the weights outboard of it, on the side of the platform, and of wrenches in the limb's cut joints
(:mod:`kinetostatics.mechanism.limbs`).

Each coefficient is a sum over elastic elements: the work of one unit wrench on the deformation due to another. Cut-joint
wrenches are ``(M, 6, …, limb, pose)``, about o.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from kinetostatics.elements.element import carried_wrench
from kinetostatics.limbs.geometry import LimbGeometry
from kinetostatics.limbs.group import LimbGroup
from kinetostatics.math.arrays import Array, Index, Mask, zeros_for
from kinetostatics.math.linalg import Cholesky, correlation, first_largest

#: Compliance, relative to the sum of absolute contributions, below which a limb or a self-stress counts as rigid.
RIGID = 1e-12
#: Limits for the fast split: smallest eigenvalue of the compliance along soft wrenches, and largest residue.
_SOFT, _RESIDUE = 1e-6, 1e-13


@dataclass(frozen=True)
class LimbLoads:
    """Forces in the elastic elements of g limbs due to weights, at zero cut-joint wrenches.

    Attributes:
        carried: for each element, what it carries (c, g, N), see :meth:`kinetostatics.elements.element.PlacedElement.carried`.
        own: for each element its weight per length (6, g, N), in its axes [N/m, N]; None without weight.
    """

    carried: tuple[Array, ...]
    own: tuple[Array | None, ...]

    def map(self, function: Callable[[Array], Array]) -> LimbLoads:
        own = tuple(None if load is None else function(load) for load in self.own)
        return LimbLoads(tuple(map(function, self.carried)), own)


def compliance_and_sag(geometry: LimbGeometry, columns: Array, particular: Array, loads: LimbLoads) -> tuple[Array, Array]:
    """Return the compliance (n, n, g, N) and the sag (n, g, N) along n sets of cut-joint wrenches.

    C_ic = Σ Wᵀ F W, Δ_igc = Σ Wᵀ (F w + u_0), Eqs. (1), (13), (16), (19), (21), summed over the elastic elements: Castigliano's
    theorem. W are the forces in an element per unit intensity, w those under the weights, F is its compliance, u_0 its
    displacement under its own weight.

    Args:
        columns: (M, 6, n, g, N) cut-joint wrenches per unit of each of n intensities.
        particular: (M, 6, g, N) cut-joint wrenches under the limbs' own weights.
        loads: the weights on the elements.
    """
    n, g, N = columns.shape[2:]
    C, sag = np.zeros((n, n, g, N)), np.zeros((n, g, N))
    if n == 0:
        return C, sag
    for element, weights, own in zip(geometry.elements, loads.carried, loads.own, strict=True):
        carried = element.carried(particular) + weights
        forces = element.forces(np.concatenate([element.carried(columns), carried[:, None]], axis=1))
        moved = element.displacements(forces)
        if own is not None:
            moved[:, n] += element.own_displacement(own)
        product = np.einsum("ki...,kj...->ij...", forces[:, :n], moved)
        C += product[:, :n]
        sag += product[:, n]
    return C, sag


def whole_compliance(group: LimbGroup, geometry: LimbGeometry) -> Array:
    """Return Σ tr F (g, N) [m/N] of all elastic compliances, for forces of 1 N and moments of 1 N times the robot's length."""
    total: Array = np.zeros(geometry.centres.shape[-2:])
    for element in geometry.elements:
        total += element.compliance_sum(group.model.length)
    return total


def assembly_error_strains(group: LimbGroup, columns: Array, assembly_error: Array | None) -> Array:
    """Return J_icᵀ e (n, g, N) for assembly errors e (6, elements, g, N) about o and cut-joint wrenches (M, 6, n, g, N)."""
    if assembly_error is None:
        return np.broadcast_to(0.0, columns.shape[2:])
    error: Array = np.zeros(columns.shape[2:])
    for k in range(assembly_error.shape[1]):
        if error.size and np.any(assembly_error[:, k]):
            error += np.einsum("in...,i...->n...", carried_wrench(group.element_cut_signs[k], columns), assembly_error[:, k])
    return error


def split_rigid(C: Array, soft: tuple[int, ...]) -> tuple[Array, Array, Mask]:
    """Split the intensities W of the wrenches of partly rigid limbs: W = rigid μ + give (J_icᵀ Δ − Δ_igc), with arbitrary μ.

    Args:
        C: (n, n, g, N) compliance of the limbs along n constraint wrenches.
        soft: indices of n − r of these wrenches; their columns of C span its range.

    Returns:
        ``rigid`` (g, N, n, r), combinations of the wrenches along which the limbs are rigid; ``give`` (g, N, n, n), a generalized
        inverse of the compliance, C give C = C; ``sure`` (g, N), True where r combinations are rigid, so that the split is
        reliable.
    """
    n = len(C)
    scaled, unit = correlation(np.moveaxis(C, (0, 1), (-2, -1)))
    scaled = np.moveaxis(scaled, (-2, -1), (0, 1))
    gives, rest = list(soft), [k for k in range(n) if k not in soft]
    factor = Cholesky(scaled[np.ix_(gives, gives)])
    inverse, couples = factor.inverse(), scaled[np.ix_(gives, rest)]
    follows = np.einsum("ab...,bc...->ac...", inverse, couples)
    left = np.einsum("aa...->a...", scaled[np.ix_(rest, rest)]) - np.einsum("ab...,ab...->b...", couples, follows)
    sure = np.sum(np.abs(left), axis=0) <= _RESIDUE
    if gives:
        sure = sure & (factor.smallest_eigenvalue() > _SOFT)
    rigid = zeros_for((n, len(rest), *C.shape[2:]), C)
    rigid[gives] = -np.where(np.abs(follows) > _RESIDUE, follows, 0.0)
    rigid[rest, range(len(rest))] = 1.0
    give = zeros_for(C.shape, C)
    give[np.ix_(gives, gives)] = inverse
    units = np.moveaxis(unit, -1, 0)
    rigid, give = rigid * units[:, None], give * units[:, None] * units
    return np.moveaxis(rigid, (0, 1), (-2, -1)), np.moveaxis(give, (0, 1), (-2, -1)), sure


def split_by_eigenvectors(C: Array, r: int) -> tuple[Array, Array]:
    """Return ``rigid`` and ``give`` of :func:`split_rigid` as (…, n, r), (…, n, n), for any compliance of rank n − r.

    With C = Σ c v vᵀ, scaled, ``rigid`` are the v of the r smallest c, and ``give`` is the pseudoinverse Σ v vᵀ/c of the others.
    """
    scaled, unit = correlation(C)
    values, vectors = np.linalg.eigh(scaled)
    combined = unit[..., :, None] * vectors
    soft = combined[..., r:]
    return combined[..., :r], soft / np.maximum(values[..., None, r:], 1e-300) @ np.swapaxes(soft, -1, -2)


def soft_wrenches(C: Array, count: int) -> tuple[int, ...]:
    """Choose ``count`` of n wrenches that span the range of the compliance (n, n, poses), by Cholesky pivots, largest first."""
    finite = np.all(np.isfinite(C), axis=(0, 1))
    scaled = np.moveaxis(correlation(np.moveaxis(C[..., finite], 2, 0))[0], 0, 2)
    chosen: list[int] = []
    for _ in range(count):
        left = np.min(np.einsum("aan->an", scaled), axis=1, initial=1.0)
        left[chosen] = -1.0
        k = first_largest(left)
        chosen.append(k)
        scaled = scaled - scaled[:, k, None] * scaled[k] / np.maximum(scaled[k, k], 1e-300)
    return tuple(chosen)


def rigid_counts(C: Array) -> Index:
    """Return the number (g, N) of combinations of constraint wrenches along which limbs of compliance (n, n, g, N) are rigid."""
    if not len(C):
        return np.zeros(C.shape[2:], dtype=np.intp)
    values = np.linalg.eigvalsh(correlation(np.moveaxis(C, (0, 1), (-2, -1)))[0])
    return np.asarray(np.sum(values <= RIGID, axis=-1))
