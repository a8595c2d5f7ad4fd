"""Choice and evaluation of the bases J_ic, J_ig of a limb: candidates, which are unit forces and couples along features of the
limb, then complementary wrenches if too few candidates are suitable. A complementary wrench is made from a wrench
along a limb axis, its seed: the components along the other wrenches and along the twists of the limb are subtracted.

The choice is made once per robot. Ranks are those at generic poses, which have no special geometry; the chosen wrenches must also
be independent at ordinary poses, the zero pose and others within the limits. They are evaluated at every pose (the method page,
sections 2 to 4). In scaled wrenches and twists, all six components have the same unit.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from kinetostatics.exceptions import StaticsError
from kinetostatics.limbs import force_method
from kinetostatics.limbs.geometry import PARALLEL, Basis, Candidate, CandidateWrenches, LimbGeometry
from kinetostatics.limbs.group import LimbGroup
from kinetostatics.limbs.wrench_candidates import (
    as_component,
    attached_candidates,
    beam_candidates,
    central_candidates,
    common_point,
    constraint_candidates,
    further_candidates,
)
from kinetostatics.math.arrays import Array, Index, Mask, settles
from kinetostatics.math.linalg import canonical_basis, definite, dot, first_largest, normalize, numerical_rank, step_across

#: Smallest singular value of the unit wrenches of a chosen basis, and smallest sine of the angle that determines a direction.
MARGIN = 0.01
#: Below this eigenvalue of the Gram matrix (the squared sine of an angle) a canonical basis counts as degenerate.
DEGENERATE = 1e-10
#: Power of a unit wrench on a unit twist that counts as rounding, so that the two are reciprocal.
RECIPROCAL = 1e-14


def evaluate_bases(group: LimbGroup, geometry: LimbGeometry, allowed: Array) -> tuple[Array, Array, Mask]:
    """Return J_ic (6, n_c, g, N) and J_ig (6, n_g, g, N) about o; True where a canonical basis is degenerate (g, N).

    ``allowed`` (6, k, g, N) are twists about o that span the permitted motions of the platform; for a serial limb, the twists of
    its passive joints. Degenerate bases are replaced by orthonormal ones, from singular values. In other bases, wrenches that
    are only almost reciprocal to ``allowed`` (J_ig: to the platform joint's twists) are projected to be reciprocal.
    """
    scale = _scale(group)[:, None]
    mine = [allowed[:, k] for k in group.basis.independent]
    columns = _columns(group, group.basis.constraint, mine, [], geometry)
    carried = [geometry.twists[:, f] for f in group.basis.carried]
    columns += _columns(group, group.basis.attached, carried, columns, geometry)
    count = len(group.basis.constraint)
    g, N = geometry.limb_axes.shape[2:]
    J = np.stack(columns, axis=1) if columns else np.zeros((6, 0, g, N))
    unit = normalize(J * scale)
    bad = ~definite(np.einsum("ki...,kj...->ij...", unit, unit), DEGENERATE)  # arrays that are not finite are not definite
    if count and allowed.shape[1]:
        power = _power(allowed / scale, unit[:, :count])
        bad |= power > 1e-6 + 100 * group.model.closing_error
        off = ~bad & (power > RECIPROCAL)
        if not settles(~off):
            J[:, :count] = np.where(off, _made_reciprocal(J[:, :count], allowed, scale), J[:, :count])
    if J.shape[1] > count and np.any(group.platform_joint):
        twists = geometry.twists[:, group.platform_joint]
        off = ~bad & (_power(twists / scale, unit[:, count:]) > RECIPROCAL)
        if not settles(~off):
            J[:, count:] = np.where(off, _made_reciprocal(J, twists, scale)[:, count:], J[:, count:])
    bad = np.asarray(bad)  # a recorded value counts as decided
    if np.any(bad):
        _replace(group, J, count, scale[:, 0], geometry, allowed, bad)
    return J[:, :count], J[:, count:], bad


def _power(twists: Array, unit: Array) -> Array:
    """Return the largest power |wᵀ t| (g, N) of unit wrenches w (6, n, g, N) on normalized twists t (6, k, g, N)."""
    power = np.einsum("ki...,kj...->ij...", unit, twists) / np.sqrt(dot(twists, twists))
    largest: Array = np.max(np.abs(power), axis=(0, 1))
    return largest


def _made_reciprocal(J: Array, twists: Array, scale: Array) -> Array:
    """Return wrenches J (6, n, g, N), projected to be reciprocal to all twists (6, k, g, N).

    J must have as many independent wrenches as there are wrenches reciprocal to the twists.
    """
    size = np.sqrt(dot(J * scale, J * scale))
    return J - step_across(normalize(twists / scale), J * scale / size) * size / scale


def _columns(
    group: LimbGroup, part: Sequence[Candidate], twists: list[Array], known: list[Array], geometry: LimbGeometry
) -> list[Array]:
    """Return the wrenches (6, g, N) of the candidates ``part``, followed by complementary wrenches.

    Complementary wrenches are reciprocal to ``twists``, and independent of one another and of the wrenches ``known``.
    """
    scale, length = _scale(group), group.model.length
    wrenches = CandidateWrenches(geometry, length, PARALLEL)
    found = [wrenches.of(candidate) for candidate in part if candidate.direction[0] != "complement"]
    seeds = [int(c.direction[1]) for c in part if c.direction[0] == "complement"]
    if seeds:
        spanned = [twist / scale for twist in twists] + [w * scale for w in (*known, *found)]
        found += [w / scale for w in _complete(spanned, _seeds(geometry, length) * scale[:, None], seeds)]
    return found


def _replace(group: LimbGroup, J: Array, count: int, scale: Array, geometry: LimbGeometry, allowed: Array, bad: Mask) -> None:
    """Replace degenerate canonical bases by orthonormal ones from singular values, in place."""
    s = scale[:, 0, 0]
    for limb, pose in np.argwhere(bad):
        mine = allowed[:, :, limb, pose] / s[:, None]
        carried = geometry.twists[:, group.platform_joint, limb, pose] / s[:, None]
        if not (np.all(np.isfinite(mine)) and np.all(np.isfinite(carried))):
            continue
        reciprocal = canonical_basis(np.linalg.svd(mine, full_matrices=True)[0][:, 6 - count :])
        J[:, :count, limb, pose] = reciprocal / s[:, None]
        known = np.hstack([carried, reciprocal])
        rest = canonical_basis(np.linalg.svd(known, full_matrices=True)[0][:, 6 - (J.shape[1] - count) :])
        J[:, count:, limb, pose] = rest / s[:, None]


def choose_basis(group: LimbGroup, geometry: LimbGeometry, generic: int) -> Basis:
    """Choose ranks and canonical wrenches of one limb with known order of elimination.

    Args:
        geometry: geometry at generic poses, followed by ordinary poses.
        generic: number of generic poses.
    """
    if group.is_attached:
        return Basis((), (), (), (), np.inf)
    tolerance = group.model.rank_tolerance
    twists = group.even_twists(geometry)[:, :, 0]
    allowed = allowed_twists(group, geometry)
    mine = twists[:, group.passive] if group.is_serial else allowed[:, :, 0] / _scale(group)
    rank, gap = _rank_over_poses(mine[:, :, :generic], tolerance)
    carried_rank, _ = _rank_over_poses(twists[:, group.platform_joint, :generic], tolerance)
    if group.elimination is not None:
        rank = 6 - len(group.elimination.platform)
    n_c = 6 - rank
    independent = tuple(_independent(mine[:, :, :generic], range(mine.shape[1]), rank))
    carried = tuple(_independent(twists[:, :, :generic], np.flatnonzero(group.platform_joint), carried_rank))
    candidates = itertools.chain(constraint_candidates(group), further_candidates(group))
    meeting = common_point(group, geometry)
    if meeting is not None:
        candidates = itertools.chain(central_candidates(group, *meeting), candidates)
    if not group.is_serial:
        candidates = itertools.chain(beam_candidates(group), candidates)
    constraint = _chosen(group, geometry, generic, candidates, n_c, mine, mine[:, list(independent)], [])
    known = _columns(group, constraint, [allowed[:, k] for k in independent], [], geometry)
    attached = _chosen(
        group,
        geometry,
        generic,
        attached_candidates(group),
        6 - carried_rank - n_c,
        reciprocal_to=twists[:, group.platform_joint],
        independent=twists[:, list(carried)],
        known=known,
    )
    if not group.is_serial:
        constraint, attached = tuple(map(as_component, constraint)), tuple(map(as_component, attached))
    return Basis(constraint, attached, independent, carried, gap)


def allowed_twists(group: LimbGroup, geometry: LimbGeometry) -> Array:
    """Return twists (6, k, g, N) about o that span the platform's motions permitted by each limb."""
    if group.is_serial:
        return geometry.twists[:, group.passive]
    assert group.elimination is not None
    A = group.joint_equations(geometry)
    no_demand = np.zeros((len(A), *A.shape[2:]))
    found = force_method.distribute(group.elimination, A, group.joint_pattern, group.platform_sum, no_demand)
    return found.allowed / group.twist_scale


def _chosen(
    group: LimbGroup,
    geometry: LimbGeometry,
    generic: int,
    candidates: Iterable[Candidate],
    count: int,
    reciprocal_to: Array,
    independent: Array,
    known: list[Array],
) -> tuple[Candidate, ...]:
    """Choose candidates one by one, each reciprocal to given twists and independent of the wrenches chosen before.

    If fewer than ``count`` candidates qualify, complementary wrenches are added.

    Args:
        geometry, generic: as in :func:`choose_basis`.
        reciprocal_to: (6, k, poses) scaled twists.
        independent: (6, r, poses) a maximal independent set of these twists.
        known: (6, 1, poses) wrenches chosen before this call.
    """
    if not count:
        return ()
    scale, length = _scale(group), group.model.length
    taken = [normalize(wrench[:, 0] * scale[:, 0]) for wrench in known]
    spanned = [normalize(independent[:, k]) for k in range(independent.shape[1])]
    poses = np.arange(geometry.limb_axes.shape[-1])  # generic ones, and ordinary ones at which the limb is not singular
    judged = poses[
        (poses < generic) | (_smallest_singular_values(spanned) > MARGIN) & (_smallest_singular_values(taken) > MARGIN)
    ]
    wrenches = CandidateWrenches(geometry, length, MARGIN)
    allowed = 1e-8 + 100 * group.model.closing_error
    chosen: list[Candidate] = []
    with np.errstate(invalid="ignore", divide="ignore"):
        for candidate in candidates:
            if len(chosen) == count:
                break
            column = normalize(wrenches.of(candidate)[:, 0] * scale[:, 0])
            power = np.einsum("kin,kn->in", reciprocal_to[:, :, judged], column[:, judged])
            if float(np.abs(power).max(initial=0.0)) < allowed and _least_over_poses([*taken, column], judged) > MARGIN:
                chosen.append(_with_own_label(candidate, chosen))
                taken.append(column)
        seeds = (_seeds(geometry, length) * scale[:, None])[:, :, 0]
        ordinary = judged[judged >= generic]  # independent of how the file is written
        return (*chosen, *_complement(spanned + taken, seeds, count - len(chosen), ordinary if ordinary.size else judged))


def _with_own_label(candidate: Candidate, others: list[Candidate]) -> Candidate:
    """Return a candidate with a number added to its label if one of the ``others`` has the same label."""
    same = sum(other.label == candidate.label or other.label.startswith(f"{candidate.label} (") for other in others)
    return replace(candidate, label=f"{candidate.label} ({same + 1})") if same else candidate


def _scale(group: LimbGroup) -> Array:
    """Return factors (6, 1, 1) by which wrenches are multiplied, and twists divided, to be scaled."""
    return np.array([group.model.length] * 3 + [1.0] * 3).reshape(6, 1, 1)


def _smallest_singular_values(columns: list[Array]) -> Array:
    """Return the smallest singular value (P,) of the matrix with columns (6, P) at every pose; 0 where it is not finite."""
    if not columns:
        return np.asarray(1.0)
    stack = np.stack(columns, axis=1)
    good = np.all(np.isfinite(stack), axis=(0, 1))
    values = np.linalg.svd(np.moveaxis(np.where(good, stack, 0.0), 2, 0), compute_uv=False)
    return np.asarray(values[:, -1])


def _least_over_poses(columns: list[Array], judged: Index) -> float:
    """Return the minimum of the smallest singular value of the columns (6, P) over the poses ``judged``; 0 if not finite."""
    return float(np.min(_smallest_singular_values([column[:, judged] for column in columns])))


def _seeds(geometry: LimbGeometry, length: float) -> Array:
    """Return six wrenches (6, 6, g, N) along the limb axes, the seeds of complementary wrenches."""
    axes = geometry.limb_axes
    zero = np.zeros_like(axes)
    return np.concatenate([np.concatenate([axes, zero]), np.concatenate([zero, axes * length])], axis=1)


def _orthogonal_part(v: Array, basis: list[Array]) -> Array:
    """Return the part of ``v`` (6, …) that is orthogonal to orthonormal vectors."""
    for _ in range(2):  # twice, against rounding
        for unit in basis:
            v = v - unit * dot(unit, v)
    return v


def _orthonormal(columns: list[Array]) -> list[Array]:
    """Return orthonormal vectors with the span of independent columns (6, …)."""
    basis: list[Array] = []
    for column in columns:
        basis.append(normalize(_orthogonal_part(normalize(column), basis)))
    return basis


def _complete(spanned: list[Array], seeds: Array, chosen: Sequence[int]) -> list[Array]:
    """Return unit vectors from the chosen seeds, orthogonal to all ``spanned`` (6, …) and to one another."""
    basis = _orthonormal(spanned)
    for seed in chosen:
        unit = normalize(_orthogonal_part(normalize(_orthogonal_part(normalize(seeds[:, seed]), basis)), basis))
        basis.append(unit)
    return basis[len(spanned) :]


def _complement(spanned: list[Array], seeds: Array, count: int, judged: Index) -> list[Candidate]:
    """Choose ``count`` seeds one by one: the best conditioned together with ``spanned`` at the poses ``judged``."""
    chosen: list[int] = []
    for number in range(count):
        completed = [*(normalize(column) for column in spanned), *_complete(spanned, seeds, chosen)]
        rest = [seed for seed in range(seeds.shape[1]) if seed not in chosen]
        sizes = {seed: _least_over_poses([*completed, normalize(seeds[:, seed])], judged) for seed in rest}
        if not sizes:
            raise StaticsError(f"no complementary wrench number {number + 1} can be found")
        chosen.append(list(sizes)[first_largest(list(sizes.values()))])
    return [Candidate(("complement", seed), None, f"complementary wrench {k}") for k, seed in enumerate(chosen, 1)]


def _rank_over_poses(columns: Array, tolerance: float) -> tuple[int, float]:
    """Return the largest rank of scaled columns (6, k, P) over P poses, and the ratio of kept to dropped singular values."""
    return max(numerical_rank(columns[:, :, p], tolerance) for p in range(columns.shape[2]))


def _independent(twists: Array, among: Iterable[int], count: int) -> list[int]:
    """Return the indices of ``count`` twists (6, k, poses) from ``among``, chosen one by one for best independence."""
    chosen: list[int] = []
    among = list(among)
    for _ in range(count):
        basis = _orthonormal([twists[:, f] for f in chosen])
        rests = {int(f): _orthogonal_part(twists[:, f], basis) for f in among if int(f) not in chosen}
        chosen.append(list(rests)[first_largest([np.min(dot(rest, rest)) for rest in rests.values()])])
    return sorted(chosen)
