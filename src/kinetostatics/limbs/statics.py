"""Limbs at many poses: constraint wrenches J_ic, attached wrenches J_ig W_ig, compliance C_ic and sag Δ_igc. The wrench in a
joint or beam is a signed sum of the wrenches in the limb's cut joints (:mod:`kinetostatics.mechanism.limbs`), and of the weights
outboard of it, on the side of the platform. Intensities are the factors of the constraint and attached wrenches.

Equal limbs are stacked: arrays are ``(component, column, limb, pose)``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from kinetostatics.layout.mapping import ShortRepr
from kinetostatics.limbs import force_method
from kinetostatics.limbs.basis_choice import evaluate_bases
from kinetostatics.limbs.compliance import (
    RIGID,
    LimbLoads,
    assembly_error_strains,
    compliance_and_sag,
    split_rigid,
    whole_compliance,
)
from kinetostatics.limbs.geometry import LimbGeometry
from kinetostatics.limbs.group import LimbGroup
from kinetostatics.math.arrays import Array, Mask
from kinetostatics.math.linalg import Cholesky, correlation, definite, least_squares, normalize
from kinetostatics.mechanism.tree import Frames

#: Squared sine of an angle below which the dependence of joint twists is checked.
DOUBTFUL = 1e-8
#: Smallest eigenvalue of the scaled compliance along self-stresses for which Cholesky factors replace eigenvectors.
_WELL_CONDITIONED = 1e-5
#: Compliance along wrenches, relative to the sum of all elastic compliances of the limb, that counts as rounding.
_STRAINING = 1e-20


@dataclass(frozen=True)
class LimbWrenches:
    """Wrenches of g limbs with M cut joints, in equilibrium with the passive joints, at N poses.

    Attributes:
        J_c, J_g: (6, n_c, g, N), (6, n_g, g, N) constraint and attached wrenches, Eqs. (2), (4).
        W_g: (n_g, g, N) attached intensities, Eq. (3) [N or N·m].
        cut_wrenches: (M, 6, n_c, g, N) cut-joint wrenches per unit of each intensity; J_c for a serial limb.
        particular: (M, 6, g, N) cut-joint wrenches under the limb's own weight; J_g W_g for a serial limb.
        self_stress: (M, 6, s, g, N) cut-joint wrenches without resultant on the platform; none for a serial limb.
        unbalanced: (passive freedoms, g, N) residual of Eq. (3) [N].
        degenerate: (g, N) True where a canonical basis is degenerate.
        doubtful: (g, N) True where joint twists may be dependent, so that the limb transmits more wrenches.
    """

    J_c: Array
    J_g: Array
    W_g: Array
    cut_wrenches: Array
    particular: Array
    self_stress: Array
    unbalanced: Array
    degenerate: Mask
    doubtful: Mask


def limb_wrenches(group: LimbGroup, geometry: LimbGeometry, outboard: Array, loaded: bool = False) -> LimbWrenches:
    """Compute the wrenches that limbs transmit, in equilibrium with their passive freedoms j of unit twists T.

    Tᵀ J_ic = 0, Eq. (2), and T_jᵀ (J_ig W_ig + Σ w) = 0, Eq. (3), with the weights w outboard of j; J_ig W_ig is the solution
    of Eq. (4) in the canonical basis.

    Args:
        outboard: (6, passive freedoms, g, N) the weights outboard of each passive freedom, about o, world axes [N, N·m].
        loaded: whether ``outboard`` are loads on links instead of weights. A load on a link inside a platform joint causes a
            wrench that is no combination of the attached wrenches of weights.
    """
    T = geometry.twists[:, group.passive]
    demand = np.einsum("ik...,ik...->k...", T, outboard) / group.power_scale[:, 0]
    return _of_serial(group, geometry, T, demand, loaded) if group.is_serial else _of_rings(group, geometry, demand)


def _of_serial(group: LimbGroup, geometry: LimbGeometry, T: Array, demand: Array, loaded: bool) -> LimbWrenches:
    """Return the wrenches of serial limbs, whose single cut joint transmits the wrench of the platform on the limb.

    ``demand`` (k, g, N) is the power of weights on the passive freedoms T (6, k, g, N): Eq. (3) is Tᵀ J_ig W_ig = −demand [N].
    """
    J_c, J_g, degenerate = evaluate_bases(group, geometry, T)
    W_g = np.zeros((J_g.shape[1], *demand.shape[1:]))
    left, doubtful = demand, _may_be_dependent(group, geometry)
    if J_g.shape[1]:
        A = np.einsum("ik...,ij...->kj...", T, J_g) / group.power_scale
        factor = Cholesky(np.einsum("ki...,kj...->ij...", A, A))
        # if an attached wrench is reciprocal to all passive joints, their twists are dependent
        pivots = np.einsum("ii...->i...", factor.factor) ** 2
        doubtful |= ~(np.min(pivots, axis=0) > DOUBTFUL * np.max(pivots, axis=0))
        for _ in range(2):  # the second iteration corrects the error of the normal equations
            right = -np.einsum("ki...,k...->i...", A, left)
            W_g = W_g + factor.solve(right[:, None])[:, 0]
            left = demand + np.einsum("ki...,i...->k...", A, W_g)
    none = np.zeros((1, 6, 0, *demand.shape[1:]))
    R_g = np.einsum("ij...,j...->i...", J_g, W_g)
    if loaded and group.basis.independent:
        more, left = _balancing(group, T, left)
        R_g = R_g + more
    return LimbWrenches(J_c, J_g, W_g, J_c[None], R_g[None], none, left, degenerate, doubtful)


def _balancing(group: LimbGroup, T: Array, demand: Array) -> tuple[Array, Array]:
    """Return a wrench (6, g, N) whose powers on the twists ``T`` (6, k, g, N) are −``demand`` (k, g, N), and the residual."""
    twists = T * group.twist_scale / np.swapaxes(group.power_scale, 0, 1)
    chosen = list(group.basis.independent)
    factor = Cholesky(np.einsum("ia...,ib...->ab...", twists[:, chosen], twists[:, chosen]))
    wrench = np.zeros((6, *demand.shape[1:]))
    for _ in range(2):  # the second iteration corrects the error of the normal equations
        more = np.einsum("ia...,ak...->i...", twists[:, chosen], factor.solve(demand[chosen, None]))
        wrench = wrench - more * group.twist_scale[:, 0]
        demand = demand - np.einsum("ik...,i...->k...", twists, more)
    return wrench, demand


def _may_be_dependent(group: LimbGroup, geometry: LimbGeometry) -> Mask:
    """True where the platform joint may have dependent twists (g, N); False for a single compound joint."""
    carried = list(group.basis.carried)
    if len({int(compound) for compound in group.compound_of[carried]}) < 2:
        return np.zeros(geometry.limb_axes.shape[2:], dtype=bool)
    twists = normalize(geometry.twists[:, carried] / group.twist_scale[::-1])
    return ~definite(np.einsum("ki...,kj...->ij...", twists, twists), DOUBTFUL)


def _of_rings(group: LimbGroup, geometry: LimbGeometry, demand: Array) -> LimbWrenches:
    """Return the wrenches of limbs with several cut joints by the force method; ``demand`` d as in :func:`_of_serial`.

    The cut-joint wrenches X obey A X = −d; the platform's wrench on the limb is P X (:mod:`kinetostatics.limbs.force_method`).
    """
    assert group.elimination is not None
    A = group.joint_equations(geometry)
    M, batch = len(group.to_platform), demand.shape[1:]
    found = force_method.distribute(group.elimination, A, group.joint_pattern, group.platform_sum, demand)
    left = force_method.remainder(group.elimination, A, demand, found.particular)
    scale = group.twist_scale
    J_c, J_g, degenerate = evaluate_bases(group, geometry, found.allowed / scale)
    n_c, n_g = J_c.shape[1], J_g.shape[1]
    spread = found.spread.reshape(M, 6, 6, *batch)
    cut_wrenches = np.einsum("mij...,jc...->mic...", spread, J_c / scale) * scale[None]
    particular = found.particular.reshape(M, 6, *batch) * scale[:, 0]
    self_stress = found.self_stress.reshape(M, 6, len(group.elimination.free), *batch) * scale[None]
    total = group.platform_wrench(particular)
    W_g = np.zeros((n_g, *batch))
    if n_c + n_g:
        # Choose the particular solution whose wrench on the platform is a combination of canonical attached wrenches.
        basis = np.concatenate([J_c, J_g], axis=1) / scale
        parts = least_squares(basis, (total / scale[:, 0])[:, None])[:, 0]
        W_g = parts[n_c:]
        particular = particular - np.einsum("mic...,c...->mi...", cut_wrenches, parts[:n_c])
    return LimbWrenches(J_c, J_g, W_g, cut_wrenches, particular, self_stress, left, degenerate, found.doubtful)


@dataclass(frozen=True, repr=False)
class LimbStatics(ShortRepr):
    """A group of limbs at many poses; arrays (…, limb, pose), wrenches about o, world axes.

    Attributes:
        J_c, J_g: (6, n_c, g, N), (6, n_g, g, N) constraint and attached wrenches, Eqs. (2), (4).
        W_g: (n_g, g, N) attached intensities, Eq. (3) [N or N·m].
        R_g: (6, g, N) resultant J_ig W_ig [N, N·m].
        C: (n_c, n_c, g, N) compliance C_ic, Eq. (1).
        gravity_displacement: (n_c, g, N) Δ_igc, Eqs. (16), (19), (21) [m or rad].
        assembly_error: (n_c, g, N) displacements along constraint wrenches due to assembly errors [m or rad].
        cut_wrenches: (M, 6, n_c, g, N) cut-joint wrenches per unit of each intensity; J_c for a serial limb.
        particular: (M, 6, g, N) cut-joint wrenches under the limb's own weight; R_g for a serial limb.
        assembly_error_cut_wrenches: (M, 6, g, N) self-stress: cut-joint wrenches due to assembly errors at zero intensities.
        undetermined: (M, 6, s, g, N) self-stresses without compliance, of undetermined magnitude.
        loads: the weights on elastic elements.
        unbalanced: (passive freedoms, g, N) residual of Eq. (3) [N].
        degenerate: (g, N) True where a canonical basis is degenerate.
        doubtful: (g, N) True where ranks may differ from the ranks at generic poses.
        may_stiffen: (g, N) True where the limb may be rigid along more or fewer combinations of wrenches than at generic poses.
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
    undetermined: Array
    loads: LimbLoads
    unbalanced: Array
    degenerate: Mask
    doubtful: Mask
    may_stiffen: Mask

    def take(self, poses: slice) -> LimbStatics:
        arrays = {item.name: getattr(self, item.name)[..., poses] for item in fields(self) if item.name not in ("group", "loads")}
        return LimbStatics(group=self.group, loads=self.loads.map(lambda array: array[..., poses]), **arrays)


def limb_statics(
    group: LimbGroup, frames: Frames, o: Array, weights: Array, gravity: Array, assembly_error: Array | None = None
) -> LimbStatics:
    """Compute wrenches, compliances and sag of equal limbs.

    Args:
        frames: frames of all bodies, world axes.
        o: (3, N) reference point [m].
        weights: (6, W, N) wrenches of all weights about o [N, N·m].
        gravity: (3, N) gravity, world axes [m/s²].
        assembly_error: (6, elements, g, N) assembly errors: the twist of the outboard side of each element, about o; None: none.
    """
    geometry = group.geometry(frames, o)
    outboard, carried = group.carried(geometry, weights)
    loads = LimbLoads(carried, tuple(element.own_load(gravity) for element in geometry.elements))
    return _statics(group, geometry, outboard, loads, assembly_error, False)


def limb_statics_under(group: LimbGroup, frames: Frames, o: Array, wrenches: Mapping[str, Array]) -> LimbStatics:
    """Compute the statics of equal limbs without weights, under loads: ``wrenches`` (6, N) about o, by attachment [N, N·m]."""
    geometry = group.geometry(frames, o)
    loads = np.stack(list(wrenches.values()), axis=1)
    outboard, carried = group.carried(geometry, loads, list(wrenches))
    return _statics(group, geometry, outboard, LimbLoads(carried, (None,) * len(carried)), None, True)


def with_loads(statics: LimbStatics, parts: Sequence[tuple[LimbStatics, Array]]) -> LimbStatics:
    """Return the statics of limbs under their weights and several loads, by superposition: S_0 + Σ factor · S_load.

    ``parts`` are the statics under each single load, with the factor (N,) of this load.
    """

    def total(of: Callable[[LimbStatics], Array]) -> Array:
        found: Array = sum((of(part) * times for part, times in parts), of(statics))
        return found

    carried = zip(statics.loads.carried, *(part.loads.carried for part, _ in parts), strict=True)
    times = (1.0, *(times for _, times in parts))
    return replace(
        statics,
        W_g=total(lambda item: item.W_g),
        R_g=total(lambda item: item.R_g),
        gravity_displacement=total(lambda item: item.gravity_displacement),
        particular=total(lambda item: item.particular),
        unbalanced=total(lambda item: item.unbalanced),
        loads=LimbLoads(tuple(sum(a * t for a, t in zip(row, times, strict=True)) for row in carried), statics.loads.own),
    )


def _statics(
    group: LimbGroup, geometry: LimbGeometry, outboard: Array, loads: LimbLoads, assembly_error: Array | None, loaded: bool
) -> LimbStatics:
    """Compute the statics of limbs under loads ``outboard`` of passive freedoms and ``loads`` on elastic elements.

    ``outboard`` and ``loaded`` are explained at :func:`limb_wrenches`. The self-stress y of limbs with rings minimizes the
    complementary energy of beams and springs, ∂U/∂y = 0 (force method; method page, section 9): y = −G⁻¹ (B W + h + e), with the
    compliance G along the self-stresses, their coupling B with the intensities W, the sag h and the assembly errors e.
    """
    found = limb_wrenches(group, geometry, outboard, loaded)
    if group.model.topology.plates and found.self_stress.shape[2]:  # an elastic base or platform resists self-stresses, too
        J = np.concatenate([found.J_c, np.zeros((6, *found.self_stress.shape[2:]))], axis=1)
        every = np.concatenate([found.cut_wrenches, found.self_stress], axis=2)
        found = replace(found, J_c=J, cut_wrenches=every, self_stress=found.self_stress[:, :, :0])
    cut_wrenches, particular, self_stress = found.cut_wrenches, found.particular, found.self_stress
    if not self_stress.shape[2]:
        C, gravity_displacement = compliance_and_sag(geometry, cut_wrenches, particular, loads)
        if group.partly_elastic:  # a beam is compliant in every direction
            C = np.where(_straining(group, geometry, cut_wrenches, C), C, 0.0)
        error = assembly_error_strains(group, cut_wrenches, assembly_error)
        stress, undetermined = np.broadcast_to(0.0, particular.shape), self_stress
    else:
        n = cut_wrenches.shape[2]
        columns = np.concatenate([cut_wrenches, self_stress], axis=2)
        gram, drift = compliance_and_sag(geometry, columns, particular, loads)
        gram = np.where(_straining(group, geometry, columns, gram), gram, 0.0)
        gain, undetermined = _relaxation(gram, self_stress)
        mixed = np.einsum("ab...,bj...->aj...", gain, gram[n:, :n])
        cut_wrenches = cut_wrenches - np.einsum("mia...,aj...->mij...", self_stress, mixed)
        particular = particular - np.einsum("mia...,ab...,b...->mi...", self_stress, gain, drift[n:])
        error = assembly_error_strains(group, self_stress, assembly_error)
        stress = -np.einsum("mia...,ab...,b...->mi...", self_stress, gain, error)
        before = np.einsum("ii...->i...", gram[:n, :n]).max(axis=0, initial=0.0)
        C, gravity_displacement = compliance_and_sag(geometry, cut_wrenches, particular, loads)
        rounding = np.einsum("ii...->i...", C) <= 1e-20 * before
        C = np.where(rounding[:, None] | rounding[None], 0.0, C)
        incompatible = _errors_are_incompatible(group, undetermined, assembly_error)
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
        undetermined=undetermined,
        loads=loads,
        unbalanced=found.unbalanced,
        degenerate=found.degenerate | group.at_one_pose,
        doubtful=found.doubtful,
        may_stiffen=_may_stiffen(group, C),
    )


def _straining(group: LimbGroup, geometry: LimbGeometry, columns: Array, C: Array) -> Mask:
    """True where any of the wrenches (M, 6, n, g, N) strains a beam or spring of the limb (g, N).

    In the other limbs, the compliance along these wrenches consists of rounding errors only.
    """
    forces = np.max(np.abs(columns) / group.twist_scale, axis=(0, 1, 2), initial=0.0)
    largest = np.einsum("ii...->i...", C).max(axis=0, initial=0.0)
    return largest > _STRAINING * whole_compliance(group, geometry) * forces**2


def _may_stiffen(group: LimbGroup, C: Array) -> Mask:
    """True (g, N) where a limb without beams may have another number of rigid combinations of wrenches than at generic poses."""
    if not group.partly_elastic or len(group.soft) != len(C) - group.rigid_directions:
        return np.full(C.shape[2:], group.partly_elastic)
    return ~split_rigid(C, group.soft)[2]


def _relaxation(gram: Array, self_stress: Array) -> tuple[Array, Array]:
    """Return the amounts G⁻¹ (s, s, g, N) of s self-stresses per unit strain along each, and rigid cut-joint wrenches.

    ``gram`` (n + s, n + s, g, N) is the compliance along n intensities and s self-stresses together. The rigid cut-joint
    wrenches (M, 6, s, g, N) are self-stresses without compliance; zero where all self-stresses are compliant.
    """
    n = len(gram) - self_stress.shape[2]
    scaled, unit = correlation(np.moveaxis(gram, (0, 1), (-2, -1)))
    scaled, unit = scaled[..., n:, n:], unit[..., n:]
    size = np.moveaxis(unit, -1, 0)
    factor = Cholesky(np.moveaxis(scaled, (-2, -1), (0, 1)))
    gain = factor.inverse() * size[:, None] * size
    undetermined = np.zeros_like(self_stress)
    ill = ~(factor.smallest_eigenvalue() > _WELL_CONDITIONED)
    if np.any(ill):
        gain[:, :, ill], directions = _by_eigenvectors(scaled[ill], unit[ill])
        undetermined[..., ill] = np.einsum("miap,pab->mibp", self_stress[..., ill], directions)
    return gain, undetermined


def _by_eigenvectors(scaled: Array, unit: Array) -> tuple[Array, Array]:
    """Return the amounts G⁺ (s, s, P) of self-stresses per unit strain, and the rigid combinations (P, s, s), by eigenvectors."""
    values, vectors = np.linalg.eigh(scaled)
    soft = values > RIGID
    inverse = np.where(soft, 1 / np.where(soft, values, 1.0), 0.0)
    gain = np.einsum("pi,pik,pk,pjk,pj->ijp", unit, vectors, inverse, vectors, unit, optimize=True)
    return gain, np.where(soft[:, None], 0.0, vectors) * unit[:, :, None]


def _errors_are_incompatible(group: LimbGroup, undetermined: Array, assembly_error: Array | None) -> Mask:
    """True where assembly errors are incompatible (g, N): self-stresses without compliance do work on them."""
    if assembly_error is None:
        return np.zeros(undetermined.shape[3:], dtype=bool)
    length = group.model.length
    forces = np.max(np.maximum(np.abs(undetermined[:, :3]), np.abs(undetermined[:, 3:]) / length), axis=(0, 1))
    shifts = np.max(np.maximum(np.abs(assembly_error[:3]), np.abs(assembly_error[3:]) * length), axis=(0, 1))
    works = np.abs(assembly_error_strains(group, undetermined, assembly_error))
    return np.asarray(np.any(works > 1e-7 * forces * shifts, axis=0))
