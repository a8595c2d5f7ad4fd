"""Limbs at many poses: constraint wrenches J_ic, attached wrenches J_ig W_ig, compliance C_ic and sag Δ_igc.

The wrench in an edge of a limb is a sum of cut-joint wrenches (:mod:`kinetostatics.mechanism.limbs`) and weights. Equal limbs are
stacked: arrays are ``(component, column, limb, pose)``.
"""

from __future__ import annotations

import operator
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

from kinetostatics.layout.mapping import ShortRepr
from kinetostatics.limbs.compliance import (
    RIGID,
    LimbLoads,
    assembly_error_strains,
    own_weights_of_beams,
    split_rigid,
    strains,
    whole_compliance,
)
from kinetostatics.limbs.geometry import LimbGeometry
from kinetostatics.limbs.group import LimbGroup
from kinetostatics.limbs.wrenches import limb_wrenches
from kinetostatics.math.arrays import Array, Mask
from kinetostatics.math.linalg import Cholesky, correlation, inverse_of
from kinetostatics.mechanism.tree import Frames

#: Smallest eigenvalue of the scaled compliance along self-stresses for which Cholesky factors replace eigenvectors.
_WELL_CONDITIONED = 1e-5
#: Compliance along wrenches, relative to the sum of all elastic compliances of the limb, that counts as rounding.
_STRAINING = 1e-20


@dataclass(frozen=True, repr=False)
class LimbStatics(ShortRepr):
    """A group of limbs at many poses; arrays (…, limb, pose), wrenches about o, world axes.

    Attributes:
        group: the limbs.
        J_c, J_g: (6, n_c, g, N), (6, n_g, g, N) constraint and attached wrenches, Eqs. (2), (4).
        W_g: (n_g, g, N) attached intensities, Eq. (3) [N or N·m].
        R_g: (6, g, N) resultant J_ig W_ig [N, N·m].
        C: (n_c, n_c, g, N) compliance C_ic, Eq. (1).
        gravity_displacement: (n_c, g, N) Δ_igc, Eqs. (16), (19), (21) [m or rad].
        assembly_error: (n_c, g, N) displacements along constraint wrenches due to assembly errors [m or rad].
        cut_wrenches: (M, 6, n_c, g, N) cut-joint wrenches per unit of each intensity; J_c for a serial limb.
        particular: (M, 6, g, N) cut-joint wrenches under the limb's own weight; R_g for a serial limb.
        assembly_error_cut_wrenches: (M, 6, g, N) self-stress: cut-joint wrenches due to assembly errors at zero intensities.
        loose: (M, 6, s, g, N) self-stresses without compliance, of undetermined magnitude.
        loads: the weights on beams and springs.
        unbalanced: (passive freedoms, g, N) residual of Eq. (3) [N].
        degenerate: (g, N) mask of degenerate canonical bases.
        doubtful: (g, N) mask of limbs whose ranks may differ from those at generic poses.
        may_stiffen: (g, N) mask of limbs whose number of rigid combinations may differ from that at generic poses.
    """

    group: LimbGroup
    J_c: Array
    J_g: Array
    W_g: Array
    R_g: Array
    C: Array
    gravity_displacement: Array
    assembly_error: Array
    cut_wrenches: Array
    particular: Array
    assembly_error_cut_wrenches: Array
    loose: Array
    loads: LimbLoads
    unbalanced: Array
    degenerate: NDArray[np.bool_]
    doubtful: NDArray[np.bool_]
    may_stiffen: NDArray[np.bool_]

    def take(self, poses: slice) -> LimbStatics:
        """Return some of the poses."""
        arrays = {item.name: getattr(self, item.name)[..., poses] for item in fields(self) if item.name not in ("group", "loads")}
        loads = LimbLoads(*(getattr(self.loads, item.name)[..., poses] for item in fields(LimbLoads)))
        return LimbStatics(group=self.group, loads=loads, **arrays)


def limb_statics(
    group: LimbGroup, frames: Frames, o: Array, weights: Array, gravity: Array, assembly_error: Array | None = None
) -> LimbStatics:
    """Compute wrenches, compliances and sag of equal limbs.

    Args:
        group: the limbs.
        frames: frames of all bodies, world axes.
        o: (3, N) reference point [m].
        weights: (6, W, N) wrenches of all weights about o [N, N·m].
        gravity: (3, N) gravity, world axes [m/s²].
        assembly_error: (6, elements, g, N) twists of outboard sides due to assembly errors of elements, about o; None: none.
    """
    geometry = group.geometry(frames, o)
    outboard, beyond, spring_beyond = group.weights_outboard(weights)
    on_drives = group.weights_on_drives(geometry, frames, o, weights)
    loads = LimbLoads(beyond, spring_beyond, on_drives, own_weights_of_beams(group, geometry, gravity))
    return _statics(group, geometry, outboard, loads, assembly_error, False)


def limb_statics_under(group: LimbGroup, frames: Frames, o: Array, wrenches: Mapping[str, Array]) -> LimbStatics:
    """Compute the statics of equal limbs without weights, under loads at some places.

    Args:
        group: the limbs.
        frames: frames of all bodies, world axes.
        o: (3, N) reference point [m].
        wrenches: (6, N) wrenches about o, by place [N, N·m].
    """
    geometry = group.geometry(frames, o)
    outboard, beyond, spring_beyond = group.loads_outboard(wrenches)
    on_drives = group.loads_on_drives(geometry, frames, o, wrenches)
    return _statics(group, geometry, outboard, LimbLoads(beyond, spring_beyond, on_drives, np.zeros_like(beyond)), None, True)


def with_loads(statics: LimbStatics, parts: Sequence[tuple[LimbStatics, Array]]) -> LimbStatics:
    """Return the statics of limbs under their weights and several loads, by superposition.

    Args:
        statics: statics under the weights.
        parts: statics under each load alone, with the factor (N,) of this load.
    """

    def total(name: str) -> Array:
        pick = operator.attrgetter(name)
        found: Array = sum((pick(part) * times for part, times in parts), pick(statics))
        return found

    return replace(
        statics,
        W_g=total("W_g"),
        R_g=total("R_g"),
        gravity_displacement=total("gravity_displacement"),
        particular=total("particular"),
        unbalanced=total("unbalanced"),
        loads=LimbLoads(total("loads.beyond"), total("loads.spring_beyond"), total("loads.on_drives"), total("loads.own")),
    )


def _statics(
    group: LimbGroup, geometry: LimbGeometry, outboard: Array, loads: LimbLoads, assembly_error: Array | None, loaded: bool
) -> LimbStatics:
    """Compute the statics of limbs under loads (6, passive freedoms, g, N) outboard of freedoms, and on beams and springs.

    ``loaded``: these are not weights, see :func:`limb_wrenches`.

    The self-stress y of limbs with rings minimizes the complementary energy of beams and springs, ∂U/∂y = 0 (force method; method
    page, section 9).
    """
    found = limb_wrenches(group, geometry, outboard, loaded)
    cut_wrenches, particular, self_stress = found.cut_wrenches, found.particular, found.self_stress
    if not self_stress.shape[2]:
        C, gravity_displacement = strains(group, geometry, cut_wrenches, particular, loads)
        if group.only_springs:  # a beam is compliant in every direction
            C = np.where(_straining(group, geometry, cut_wrenches, C), C, 0.0)
        error = assembly_error_strains(group, cut_wrenches, assembly_error)
        stress, loose = np.broadcast_to(0.0, particular.shape), self_stress
    else:
        n = cut_wrenches.shape[2]
        columns = np.concatenate([cut_wrenches, self_stress], axis=2)
        gram, drift = strains(group, geometry, columns, particular, loads)
        gram = np.where(_straining(group, geometry, columns, gram), gram, 0.0)
        gain, loose = _relaxation(gram, self_stress)
        mixed = np.einsum("ab...,bj...->aj...", gain, gram[n:, :n])
        cut_wrenches = cut_wrenches - np.einsum("mia...,aj...->mij...", self_stress, mixed)
        particular = particular - np.einsum("mia...,ab...,b...->mi...", self_stress, gain, drift[n:])
        error = assembly_error_strains(group, self_stress, assembly_error)
        stress = -np.einsum("mia...,ab...,b...->mi...", self_stress, gain, error)
        before = np.einsum("ii...->i...", gram[:n, :n]).max(axis=0, initial=0.0)
        C, gravity_displacement = strains(group, geometry, cut_wrenches, particular, loads)
        rounding = np.einsum("ii...->i...", C) <= 1e-20 * before
        C = np.where(rounding[:, None] | rounding[None], 0.0, C)
        incompatible = _errors_are_incompatible(group, loose, assembly_error)
        error = np.where(incompatible, np.nan, assembly_error_strains(group, cut_wrenches, assembly_error))
        stress = np.where(incompatible, np.nan, stress)
    return LimbStatics(
        group=group,
        J_c=found.J_c,
        J_g=found.J_g,
        W_g=found.W_g,
        R_g=group.platform_wrench(particular),
        C=C,
        gravity_displacement=gravity_displacement,
        assembly_error=error,
        cut_wrenches=cut_wrenches,
        particular=particular,
        assembly_error_cut_wrenches=stress,
        loose=loose,
        loads=loads,
        unbalanced=found.unbalanced,
        degenerate=found.degenerate | group.at_one_pose,
        doubtful=found.doubtful,
        may_stiffen=_may_stiffen(group, C),
    )


def _straining(group: LimbGroup, geometry: LimbGeometry, columns: Array, C: Array) -> Mask:
    """Return the mask (g, N) of limbs in which any of the wrenches (M, 6, n, g, N) strains a beam or spring.

    Otherwise the compliance along them consists of rounding errors only.
    """
    forces = np.max(np.abs(columns) / group.twist_scale, axis=(0, 1, 2), initial=0.0)
    largest = np.einsum("ii...->i...", C).max(axis=0, initial=0.0)
    return largest > _STRAINING * whole_compliance(group, geometry) * forces**2


def _may_stiffen(group: LimbGroup, C: Array) -> NDArray[np.bool_]:
    """Return the mask (g, N) of limbs whose rigid directions may differ from those at generic poses, except limbs with beams."""
    if not group.only_springs or len(group.soft) != len(C) - group.rigid_directions:
        return np.full(C.shape[2:], group.only_springs)
    return ~split_rigid(C, group.soft).sure


def _relaxation(gram: Array, self_stress: Array) -> tuple[Array, Array]:
    """Return the self-stress per unit strain along it (s, s, g, N), and the cut-joint wrenches of rigid self-stresses.

    Args:
        gram: (n + s, n + s, g, N) compliance along n intensities and s self-stresses together.
        self_stress: (M, 6, s, g, N) cut-joint wrenches of the self-stresses.
    """
    n = len(gram) - self_stress.shape[2]
    scaled, unit = correlation(np.moveaxis(gram, (0, 1), (-2, -1)))
    scaled, unit = scaled[..., n:, n:], unit[..., n:]
    size = np.moveaxis(unit, -1, 0)
    factor = Cholesky(np.moveaxis(scaled, (-2, -1), (0, 1)))
    gain = inverse_of(factor) * size[:, None] * size
    loose = np.zeros_like(self_stress)
    ill = ~(factor.smallest_eigenvalue() > _WELL_CONDITIONED)
    if np.any(ill):
        gain[:, :, ill], directions = _by_eigenvectors(scaled[ill], unit[ill])
        loose[..., ill] = np.einsum("miap,pab->mibp", self_stress[..., ill], directions)
    return gain, loose


def _by_eigenvectors(scaled: Array, unit: Array) -> tuple[Array, Array]:
    """Return the self-stress per unit strain (s, s, P), and rigid combinations (P, s, s) of self-stresses, by eigenvectors."""
    values, vectors = np.linalg.eigh(scaled)
    soft = values > RIGID
    inverse = np.where(soft, 1 / np.where(soft, values, 1.0), 0.0)
    gain = np.einsum("pi,pik,pk,pjk,pj->ijp", unit, vectors, inverse, vectors, unit, optimize=True)
    return gain, np.where(soft[:, None], 0.0, vectors) * unit[:, :, None]


def _errors_are_incompatible(group: LimbGroup, loose: Array, assembly_error: Array | None) -> NDArray[np.bool_]:
    """Return the mask (g, N) of incompatible assembly errors, which do work on self-stresses without compliance."""
    if assembly_error is None:
        return np.zeros(loose.shape[3:], dtype=bool)
    length = group.model.length
    forces = np.max(np.maximum(np.abs(loose[:, :3]), np.abs(loose[:, 3:]) / length), axis=(0, 1))
    shifts = np.max(np.maximum(np.abs(assembly_error[:3]), np.abs(assembly_error[3:]) * length), axis=(0, 1))
    return np.asarray(np.any(np.abs(assembly_error_strains(group, loose, assembly_error)) > 1e-7 * forces * shifts, axis=0))
