"""Self-stress in limbs with rings: it takes the value that the elasticity of beams and springs gives it (the force method).

Cut-joint wrenches are ``(M, 6, …, limb, pose)`` about o; see the method page, section 9.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinetostatics.limbs.compliance import RIGID, LimbLoads, assembly_error_strains, strains, whole_compliance
from kinetostatics.limbs.geometry import LimbGeometry
from kinetostatics.limbs.group import LimbGroup
from kinetostatics.limbs.wrenches import LimbWrenches
from kinetostatics.math.arrays import Array
from kinetostatics.math.linalg import Cholesky, correlation

#: Smallest eigenvalue of the scaled compliance along self-stresses for which a Cholesky factor is as good as eigenvectors.
_WELL_CONDITIONED = 1e-3
#: Part of a limb's whole compliance below which that along its forces is rounding.
_FELT = 1e-20


@dataclass(frozen=True)
class RelaxedLimbs:
    """Cut-joint wrenches of g limbs with self-stress relaxed, and how the limbs give way under them.

    Attributes:
        cut_wrenches: (M, 6, n_c, g, N) cut-joint wrenches per unit of each intensity.
        particular: (M, 6, g, N) cut-joint wrenches under the limbs' own weights.
        assembly_error_cut_wrenches: (M, 6, g, N) cut-joint wrenches under assembly errors; NaN where rigid rings cannot follow.
        loose: (M, 6, s, g, N) self-stresses without any compliance.
        C: (n_c, n_c, g, N) compliance C_ic, Eq. (1).
        gravity_displacement: (n_c, g, N) Δ_igc, Eqs. (16), (19), (21) [m or rad].
        assembly_error: (n_c, g, N) the same of assembly errors; NaN where rigid rings cannot follow them.
    """

    cut_wrenches: Array
    particular: Array
    assembly_error_cut_wrenches: Array
    loose: Array
    C: Array
    gravity_displacement: Array
    assembly_error: Array


def relaxed_limbs(
    group: LimbGroup, geometry: LimbGeometry, found: LimbWrenches, loads: LimbLoads, assembly_error: Array | None
) -> RelaxedLimbs:
    """Relax the self-stress y of limbs, if they have any: it takes the value of least complementary energy, ∂U/∂y = 0.

    Args:
        group, geometry: the limbs and where they are.
        found: wrenches that are in equilibrium with passive joints and weights.
        loads: the weights on beams and springs.
        assembly_error: (6, elements, g, N) what each element's outboard side is off by for no force, about o; None: nothing.
    """
    cut_wrenches, particular, self_stress = found.cut_wrenches, found.particular, found.self_stress
    if not self_stress.shape[2]:
        C, gravity_displacement = strains(group, geometry, cut_wrenches, particular, loads)
        no_stress = np.broadcast_to(0.0, particular.shape)
        return RelaxedLimbs(
            cut_wrenches,
            particular,
            no_stress,
            self_stress,
            C,
            gravity_displacement,
            assembly_error_strains(group, cut_wrenches, assembly_error),
        )
    n = cut_wrenches.shape[2]
    columns = np.concatenate([cut_wrenches, self_stress], axis=2)
    gram, lean = strains(group, geometry, columns, particular, loads)
    # where no beam and no spring feels any of them all is rounding, and nothing in it tells so
    forces = np.max(np.abs(columns) / group.twist_scale, axis=(0, 1, 2))
    felt = np.einsum("ii...->i...", gram).max(axis=0) > _FELT * whole_compliance(group, geometry) * forces**2
    gram = np.where(felt, gram, 0.0)
    gain, loose = _relaxation(gram, self_stress)
    mixed = np.einsum("ab...,bj...->aj...", gain, gram[n:, :n])
    cut_wrenches = cut_wrenches - np.einsum("mia...,aj...->mij...", self_stress, mixed)
    particular = particular - np.einsum("mia...,ab...,b...->mi...", self_stress, gain, lean[n:])
    error = assembly_error_strains(group, self_stress, assembly_error)
    assembly_error_cut_wrenches = -np.einsum("mia...,ab...,b...->mi...", self_stress, gain, error)
    before = np.einsum("ii...->i...", gram[:n, :n]).max(axis=0, initial=0.0)
    C, gravity_displacement = strains(group, geometry, cut_wrenches, particular, loads)
    rounding = np.einsum("ii...->i...", C) <= 1e-20 * before
    C = np.where(rounding[:, None] | rounding[None], 0.0, C)
    contradict = _rings_contradict(group, loose, assembly_error)
    error = np.where(contradict, np.nan, assembly_error_strains(group, cut_wrenches, assembly_error))
    assembly_error_cut_wrenches = np.where(contradict, np.nan, assembly_error_cut_wrenches)
    return RelaxedLimbs(cut_wrenches, particular, assembly_error_cut_wrenches, loose, C, gravity_displacement, error)


def _relaxation(gram: Array, self_stress: Array) -> tuple[Array, Array]:
    """Return how much self-stress answers a strain along it (s, s, g, N), and the cut-joint wrenches of rigid self-stresses.

    Args:
        gram: (n + s, n + s, g, N) compliance along n intensities and s self-stresses together.
        self_stress: (M, 6, s, g, N) cut-joint wrenches of the self-stresses.
    """
    n = len(gram) - self_stress.shape[2]
    scaled, unit = correlation(np.moveaxis(gram, (0, 1), (-2, -1)))
    scaled, unit = scaled[..., n:, n:], unit[..., n:]
    size = np.moveaxis(unit, -1, 0)
    s = len(size)
    factor = Cholesky(np.moveaxis(scaled, (-2, -1), (0, 1)))
    half = factor.forward(np.eye(s).reshape(s, s, *(1,) * (size.ndim - 1)))
    gain = np.einsum("ki...,kj...->ij...", half, half) * size[:, None] * size
    loose = np.zeros_like(self_stress)
    ill = ~(factor.smallest_eigenvalue() > _WELL_CONDITIONED)
    if np.any(ill):
        gain[:, :, ill], directions = _by_eigenvectors(scaled[ill], unit[ill])
        loose[..., ill] = np.einsum("miap,pab->mibp", self_stress[..., ill], directions)
    return gain, loose


def _by_eigenvectors(scaled: Array, unit: Array) -> tuple[Array, Array]:
    """Return the same gain (s, s, P), and the combinations (P, s, s) of self-stresses without compliance, by eigenvectors."""
    values, vectors = np.linalg.eigh(scaled)
    soft = values > RIGID
    inverse = np.where(soft, 1 / np.where(soft, values, 1.0), 0.0)
    gain = np.einsum("pi,pik,pk,pjk,pj->ijp", unit, vectors, inverse, vectors, unit, optimize=True)
    return gain, np.where(soft[:, None], 0.0, vectors) * unit[:, :, None]


def _rings_contradict(group: LimbGroup, loose: Array, assembly_error: Array | None) -> NDArray[np.bool_]:
    """Return where (g, N) assembly errors do something along self-stresses without compliance: rigid rings cannot follow them."""
    if assembly_error is None:
        return np.zeros(loose.shape[3:], dtype=bool)
    length = group.model.length
    forces = np.max(np.maximum(np.abs(loose[:, :3]), np.abs(loose[:, 3:]) / length), axis=(0, 1))
    shifts = np.max(np.maximum(np.abs(assembly_error[:3]), np.abs(assembly_error[3:]) * length), axis=(0, 1))
    return np.asarray(np.any(np.abs(assembly_error_strains(group, loose, assembly_error)) > 1e-7 * forces * shifts, axis=0))
