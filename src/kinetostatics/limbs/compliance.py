"""Deformation of limbs: compliance C_ic, Eq. (1), and sag Δ_igc, Eqs. (16), (19), (21). The wrench in a beam or spring (elastic
joint) is the sum of the weights outboard of it, on the side of the platform, and of wrenches in the limb's cut joints
(:mod:`kinetostatics.mechanism.limbs`).

Each coefficient is a sum over beams and springs: the work of one unit wrench on the deformation due to another. Cut-joint
wrenches are ``(M, 6, …, limb, pose)``, about o.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetostatics.limbs import beam_formulas
from kinetostatics.limbs.geometry import LimbGeometry
from kinetostatics.limbs.group import LimbGroup, carried_wrench
from kinetostatics.math.arrays import Array, Index, Mask, zeros_for
from kinetostatics.math.linalg import Cholesky, correlation, cross, first_largest
from kinetostatics.math.screws import move_twist, move_wrench, rotate

#: Compliance, relative to the sum of absolute contributions, below which a limb or a self-stress counts as rigid.
RIGID = 1e-12
#: Limits for the fast split: smallest eigenvalue of the compliance along soft wrenches, and largest residue.
_SOFT, _RESIDUE = 1e-6, 1e-13


@dataclass(frozen=True)
class LimbLoads:
    """Wrenches in the beams and springs of g limbs due to weights, at zero cut-joint wrenches.

    Attributes:
        beyond: (6, beams, g, N) weights outboard of each beam's platform end, about o, world axes [N, N·m].
        spring_beyond: (6, springs, g, N) weights outboard of each spring, about o, world axes [N, N·m].
        on_drives: (1, drives, g, N) the force or torque of weights on each elastic actuator [N or N·m].
        own: (6, beams, g, N) the beams' own weights, force and moment per length, in beam axes [N/m, N].
    """

    beyond: Array
    spring_beyond: Array
    on_drives: Array
    own: Array


def own_weights_of_beams(group: LimbGroup, geometry: LimbGeometry, gravity: Array) -> Array:
    """Return the uniform loads (6, beams, g, N) [N/m, N] due to the beams' weights under ``gravity`` (3, N) [m/s²], in beam axes.

    A mass whose centre is not the beam's middle is distributed along a parallel line; its weight also exerts a moment.
    """
    with np.errstate(divide="ignore", invalid="ignore"):  # the length of a telescopic beam may be zero
        given = group.beam_masses_per_length
        spread = np.where(np.isnan(given), group.beam_masses / geometry.beam_lengths, given)
    field = np.broadcast_to(gravity[:, None, None], (3, *spread.shape))
    loads = np.stack([field, cross(geometry.beam_levers, field)], axis=1)
    return np.einsum("ik...,ij...->jk...", geometry.beam_axes, loads).reshape(6, *spread.shape) * spread


def strains(group: LimbGroup, geometry: LimbGeometry, columns: Array, particular: Array, loads: LimbLoads) -> tuple[Array, Array]:
    """Return the compliance (n, n, g, N) and the sag (n, g, N) along n sets of cut-joint wrenches.

    C_ic = Σ ∫ (X J_ic)ᵀ c (X J_ic) ds, Eqs. (1), (13); Δ_igc = Σ ∫ (X J_ic)ᵀ c X (J_ig W_ig + weights) ds, Eqs. (16), (19), (21):
    Castigliano's theorem, in closed form for beams. X transforms wrenches to the section at s, c is its compliance; a spring or
    actuator adds one term to each sum.

    Args:
        columns: (M, 6, n, g, N) cut-joint wrenches per unit of each of n intensities.
        particular: (M, 6, g, N) cut-joint wrenches under the limbs' own weights.
        loads: the weights on beams and springs.
    """
    n, g, N = columns.shape[2:]
    C, sag = np.zeros((n, n, g, N)), np.zeros((n, g, N))
    if n == 0:
        return C, sag
    for b in range(len(group.beams[0])):
        c, L = group.compliances[:, b][:, None], geometry.beam_lengths[b]
        known = carried_wrench(group.beam_cut_signs[b], particular) + loads.beyond[:, b]
        wrench = np.concatenate([carried_wrench(group.beam_cut_signs[b], columns), known[:, None]], axis=1)
        local = rotate(geometry.beam_axes[:, :, b], move_wrench(wrench, geometry.beam_ends[:, b]), back=True)
        moved = beam_formulas.end_displacement(c, L, local)
        moved[:, n] += beam_formulas.sag(c[:, 0], L, loads.own[:, b])
        product = np.einsum("ki...,kj...->ij...", local[:, :n], moved)
        C += product[:, :n]
        sag += product[:, n]
    for k in range(len(group.springs[0])):
        known = carried_wrench(group.spring_cut_signs[k], particular) + loads.spring_beyond[:, k]
        wrench = np.concatenate([carried_wrench(group.spring_cut_signs[k], columns), known[:, None]], axis=1)
        local = rotate(geometry.spring_axes[:, :, k], move_wrench(wrench, geometry.spring_arms[:, k]), back=True)
        product = np.einsum("ki...,kj...->ij...", local[:, :n], spring_twist(*group.spring(k), local))
        C += product[:, :n]
        sag += product[:, n]
    for k, drive in enumerate(group.drives):
        force = group.on_drive(geometry, k, columns)
        known = group.on_drive(geometry, k, particular[:, :, None])[0] + loads.on_drives[0, k]
        C += drive.compliance * force[:, None] * force
        sag += drive.compliance * force * known
    return C, sag


def whole_compliance(group: LimbGroup, geometry: LimbGeometry) -> Array:
    """Return the sum (g, N) [m/N] of all elastic compliances, along forces of 1 N and moments of 1 N times the robot's length."""
    g, N = geometry.centres.shape[-2:]
    unit = np.broadcast_to(np.diag(group.twist_scale.reshape(6))[:, :, None, None], (6, 6, g, N))
    total: Array = np.zeros((g, N))
    for b in range(len(group.beams[0])):
        moved = beam_formulas.end_displacement(group.compliances[:, b][:, None], geometry.beam_lengths[b], unit)
        total += np.einsum("ki...,ki...->...", unit, moved)
    for k in range(len(group.springs[0])):
        total += np.einsum("ki...,ki...->...", unit, spring_twist(*group.spring(k), unit))
    for drive in group.drives:
        sizes = np.where(group.rotates[list(drive.freedoms)], group.model.length, 1.0)[:, None, None]
        total += drive.compliance * np.sum((drive.ratios * sizes) ** 2, axis=0)
    return total


def spring_twist(linear: Array, angular: Array, wrench: Array) -> Array:
    """Return the twists (6, …, g, N) of the outboard sides of elastic joints under wrenches (6, …, g, N), both in joint frames.

    ``linear`` and ``angular`` (3, 3, g) are compliances [m/N], [rad/(N·m)].
    """
    parts = (linear, wrench[:3]), (angular, wrench[3:])
    return np.concatenate([np.einsum("ijg,j...gn->i...gn", *part) for part in parts])


def spring_motion(linear: Array, angular: Array, axes: Array, arm: Array, carried: Array) -> tuple[Array, Array]:
    """Return the twists (6, S, g, N) of outboard parts due to elastic joints, about o, and the strain energies (g, N) [J].

    Args:
        linear, angular: compliances, see :func:`spring_twist`.
        axes, arm: (3, 3, g, N) and (3, g, N) axes and origins of the joint frames, from o.
        carried: (6, S, g, N) wrenches that the joints carry under each of S superposed loads, about o.
    """
    wrench = rotate(axes, move_wrench(carried, arm), back=True)
    local = spring_twist(linear, angular, wrench)
    return move_twist(rotate(axes, local), -arm), np.einsum("ign,ign->gn", wrench.sum(axis=1), local.sum(axis=1)) / 2


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
    """Return ``rigid`` and ``give`` of :func:`split_rigid` as (…, n, r), (…, n, n), for any compliance of rank n − r."""
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
