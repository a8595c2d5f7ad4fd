"""Equilibrium of the platform at the N poses of a chunk, Eqs. (11) and (12), by contribution (axis S).

The contributions to the platform's twist are the load, the weight of the platform, the weight of each limb, each load on a link,
and assembly errors. Arrays have the batch axis last; :mod:`kinetostatics.results.result` converts them to the public layout.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from kinetostatics.layout.mapping import ShortRepr
from kinetostatics.limbs.group import LimbGroup
from kinetostatics.limbs.statics import LimbStatics, limb_statics, with_loads
from kinetostatics.math.arrays import Array, zeros_for
from kinetostatics.mechanism.tree import Frames
from kinetostatics.statics.assembly_errors import AssemblyErrors
from kinetostatics.statics.link_loads import AppliedLoad, AppliedStatics, applied_statics, by_attachment
from kinetostatics.statics.loaded_poses import LoadedPoses
from kinetostatics.statics.plates import CoupledEquilibrium, Equilibrium, equilibrium
from kinetostatics.statics.robot_statics import RobotStatics
from kinetostatics.statics.singularity import any_limb, has_negative_length, unbalanced_parts, where_singular, without_equilibrium


@dataclass(frozen=True, repr=False)
class Solution(ShortRepr):
    """Equilibrium of one chunk of N poses; wrenches about o, world axes.

    Attributes:
        frames, o, gravity: frames of all bodies, o (3, N) [m], and gravity (3, N) [m/s²].
        weights: (6, W, N) the robot's weights [N, N·m].
        statics: for each group of equal limbs, their wrenches and compliance.
        errors: for each group, the twists (6, elements, g, N) due to assembly errors, or None.
        contributions: names of the contributions.
        twists: (6, S, N) contributions to the twist [m, rad], Eq. (12).
        compliance, stiffness: (6, 6, N) compliance and stiffness of the platform at o, world axes.
        intensities: for each group, W_ic (n_c, S, g, N) due to each contribution, Eq. (11).
        load, platform_weight: (6, N) external load and weight of the platform [N, N·m].
        singular: (N,) True where the platform or a limb can still move, or a beam's length is negative; there are no results
            then.
        indeterminate: (N,) True where forces in rigid limbs or rings are statically indeterminate.
        basis_degenerate: (N,) True where the canonical wrench basis of a limb degenerates.
        undetermined: for each group, (n_c, g, N) True where an intensity is statically indeterminate.
        self_stresses: for each group, (n_c, k, g, N) intensities in k self-stresses, which have no resultant on the platform.
        unbalanced: see :func:`kinetostatics.statics.singularity.unbalanced_parts`.
        applied: the loads on links, with their separate effects on limbs.
        weights_alone: ``statics`` without the loads on links; None without loads.
        tangents: for a robot with springs, matrices 1 + K_g G (n, n, N) of geometric stiffness K_g and compliance G: first for
            limbs while the platform is fixed, last for the platform. Each unstable motion causes a negative eigenvalue.
    """

    frames: Frames
    o: Array
    gravity: Array
    weights: Array
    statics: tuple[LimbStatics, ...]
    assembly_errors: AssemblyErrors | None
    errors: tuple[Array | None, ...]
    contributions: tuple[str, ...]
    twists: Array
    compliance: Array
    stiffness: Array
    intensities: tuple[Array, ...]
    load: Array
    platform_weight: Array
    singular: NDArray[np.bool_]
    indeterminate: NDArray[np.bool_]
    basis_degenerate: NDArray[np.bool_]
    undetermined: tuple[NDArray[np.bool_], ...]
    self_stresses: tuple[Array, ...]
    unbalanced: Mapping[str, Array]
    applied: tuple[AppliedStatics, ...] = ()
    weights_alone: tuple[LimbStatics, ...] | None = None
    tangents: tuple[Array, ...] = ()

    @property
    def doubtful(self) -> NDArray[np.bool_]:
        """(N,) True where the rank of a limb may differ from its rank at generic poses."""
        return any_limb([item.doubtful | item.may_stiffen for item in self.statics], self.o.shape[1])

    def statics_of_weights(self, number: int) -> LimbStatics:
        return (self.weights_alone or self.statics)[number]

    @cached_property
    def places(self) -> Mapping[str, tuple[int, int]]:
        """By the name of each limb, the index of its group and its index in the group."""
        return {
            limb.name: (number, position)
            for number, item in enumerate(self.statics)
            for position, limb in enumerate(item.group.limbs)
        }

    def contribution_mask(self, group: LimbGroup, strains: bool = False) -> Array:
        """Return (S, g, 1): 1 for the contribution of each limb's own weight, else 0.

        Closed chains attached only to the platform belong to the contribution of the platform's weight. Closed chains attached
        only to the base belong to no contribution; for them, S is larger by 1 and the last row is 1.

        Args:
            strains: whether to mark the contribution of the strains due to the own weight, instead of the contribution of the
                forces due to it; the two differ after :func:`by_mechanism`.
        """
        hanging_on_base = group.is_attached and not group.limbs[0].on_platform
        share = np.zeros((len(self.contributions) + hanging_on_base, len(group.limbs), 1))
        for position, number in enumerate(group.numbers):
            if group.is_attached:
                place = len(self.contributions) if hanging_on_base else 1
            else:
                place = self.place_of_strains(number) if strains else 2 + number
            share[place, position] = 1
        return share

    def place_of_strains(self, limb: int) -> int:
        """Return the index of the contribution of the strains due to a limb's own weight."""
        deformation = of_deformation(self.contributions[2 + limb])
        return self.contributions.index(deformation) if deformation in self.contributions else 2 + limb

    def cut_wrenches(self, number: int, strains: bool = False) -> Array:
        """Return the cut-joint wrenches X = N W_ic + X_0 + X_loads + X_errors (M, 6, S, g, N) of a group by contribution."""
        statics = self.statics[number]
        share = self.contribution_mask(statics.group, strains)
        intensities = self.intensities[number]
        if share.shape[0] > intensities.shape[1]:
            intensities = np.concatenate([intensities, np.zeros_like(intensities[:, :1])], axis=1)
        total = np.einsum("mkign,isgn->mksgn", statics.cut_wrenches, intensities)
        total += share * self.statics_of_weights(number).particular[:, :, None]
        for item in self.applied:
            part = item.statics[number]
            if part is not None:
                total[:, :, : len(item.share)] += part.particular[:, :, None] * item.share[:, None]
        if "assembly_errors" in self.contributions:
            total[:, :, self.contributions.index("assembly_errors")] += statics.assembly_error_cut_wrenches
        return total

    def total_cut_wrenches(self, number: int) -> Array:
        """Return the cut-joint wrenches (M, 6, g, N) of a group, the sum of all contributions."""
        statics = self.statics[number]
        total = np.einsum("mkign,ign->mkgn", statics.cut_wrenches, self.intensities[number].sum(axis=1))
        total += statics.particular
        if "assembly_errors" in self.contributions:
            total += statics.assembly_error_cut_wrenches
        return total


@dataclass(frozen=True)
class Balanced:
    """An equilibrium, with the data for further loads on the same robot.

    Attributes:
        platform: the stiffness of the platform, factorized.
        right, strains: the right-hand sides for each contribution, see :meth:`PlatformEquilibrium.solve`.
    """

    solution: Solution
    platform: Equilibrium
    right: Array
    strains: list[Array]


def balanced(robot: RobotStatics, given: LoadedPoses) -> Balanced:
    """Solve Eq. (12) at given poses."""
    frames, gravity, assembly_errors, applied = given.frames, given.gravity, given.assembly_errors, given.applied
    _, o = robot.mechanism.platform_pose(frames)
    weights = robot.weights.wrenches(frames, o, gravity) if given.weights is None else given.weights
    groups = robot.groups if given.groups is None else given.groups
    errors = tuple(None if assembly_errors is None else assembly_errors.of(group, frames, o) for group in groups)
    statics = tuple(limb_statics(group, frames, o, weights, gravity, error) for group, error in zip(groups, errors, strict=True))
    platform_weight = weights[:, robot.weights.of("platform")].sum(axis=1)
    first = len(robot.contributions)
    contributions = (*robot.contributions, *(item.name for item in applied))
    if assembly_errors is not None:
        contributions += ("assembly_errors",)
    balance = equilibrium(robot, statics, frames, o, given.support)
    loads = applied_statics(applied, groups, frames, o, first, len(contributions))
    right, strains = _by_contribution(robot, balance, contributions, statics, given.load, platform_weight, loads)
    if isinstance(balance, CoupledEquilibrium):
        balance.add_weights(contributions, statics, weights, gravity, assembly_errors, strains)
    twists, intensities = balance.solve(right, strains, assembly_errors is not None)
    weights_alone = statics if applied else None
    if applied:
        statics = tuple(_under_loads(item, number, loads) for number, item in enumerate(statics))
    unbalanced = unbalanced_parts(robot, frames, o, weights, statics, by_attachment(loads))
    found = Solution(
        frames=frames,
        o=o,
        gravity=gravity,
        weights=weights,
        statics=statics,
        assembly_errors=assembly_errors,
        errors=errors,
        contributions=contributions,
        twists=twists,
        compliance=balance.compliance,
        stiffness=balance.stiffness,
        intensities=tuple(intensities),
        load=given.load,
        platform_weight=platform_weight,
        singular=where_singular(statics, balance, unbalanced) | has_negative_length(robot, frames),
        indeterminate=balance.indeterminate | any_limb([np.any(s.undetermined, axis=(0, 1, 2)) for s in statics], o.shape[1]),
        basis_degenerate=any_limb([item.degenerate for item in statics], o.shape[1]),
        undetermined=tuple(balance.undetermined),
        self_stresses=tuple(balance.self_stresses),
        unbalanced=unbalanced,
        applied=loads,
        weights_alone=weights_alone,
    )
    return Balanced(found, balance, right, strains)


def unit_responses(
    robot: RobotStatics, before: Balanced, loads: Sequence[AppliedLoad], moved: Array | None = None
) -> tuple[Array, Solution]:
    """Return the responses of a robot in equilibrium to n additional unit loads on links.

    Args:
        moved: (6, n, N) twists of the platform under each of these loads; None: the platform is fixed.

    Returns:
        (generalized_forces, fixed): the resultant wrenches (6, n, N) of the unit loads on the platform; by reciprocity, each is
        also the displacement along the load per unit twist of the platform. ``fixed`` is the equilibrium under these twists; its
        last contributions are the unit loads.
    """
    solution, n, S = before.solution, len(loads), len(before.solution.contributions)
    groups = tuple(item.group for item in solution.statics)
    applied = applied_statics(loads, groups, solution.frames, solution.o, 0, n)
    right = zeros_for((6, n, solution.o.shape[1]), solution.o)
    strains = [zeros_for((item.J_c.shape[1], n, *item.J_c.shape[2:]), item.J_c) for item in solution.statics]
    _add_loads(robot, before.platform, solution.statics, applied, right, strains)
    if moved is None:
        held = before.platform.with_fixed_platform(strains)
    else:
        held = before.platform.intensities(moved, right, strains)
    intensities = [np.concatenate([np.zeros_like(W), mine], axis=1) for W, mine in zip(solution.intensities, held, strict=True)]
    twists = zeros_for((6, S + n, solution.o.shape[1]), solution.twists)
    twists[:, S:] = 0.0 if moved is None else moved
    shares = [np.concatenate([np.zeros_like(twists[0, :S]), item.share]) for item in applied]
    fixed = replace(
        solution,
        contributions=(*solution.contributions, *(item.name for item in loads)),
        twists=twists,
        intensities=tuple(intensities),
        assembly_errors=None,
        errors=tuple(None for _ in groups),
        applied=tuple(replace(item, share=share) for item, share in zip(applied, shares, strict=True)),
        weights_alone=solution.weights_alone or solution.statics,
    )
    return before.platform.generalized_force(right, strains), fixed


def with_more(robot: RobotStatics, before: Balanced, more: Mapping[str, Array], names: Sequence[str], twists: Array) -> Solution:
    """Return the equilibrium under one further load for each contribution; the load's effects are added to the contribution.

    Args:
        before: the equilibrium without the further loads.
        more: wrenches (6, S, N) about o for each contribution, by attachment.
        names: names of the further loads.
        twists: (6, S, N) twists of the result; computing them here, as sums, would lose digits where the further loads stiffen an
            almost free motion.
    """
    solution, S = before.solution, len(names)
    items = [AppliedLoad(name, {at: w[:, s] for at, w in more.items()}, {}, "change") for s, name in enumerate(names)]
    loads = applied_statics(items, [item.group for item in solution.statics], solution.frames, solution.o, 0, S)
    right, strains = np.array(before.right, subok=True), [np.array(strain, subok=True) for strain in before.strains]
    _add_loads(robot, before.platform, solution.statics, loads, right, strains)
    intensities = before.platform.intensities(twists, right, strains)
    applied = (*solution.applied, *loads)
    statics = tuple(_under_loads(item, number, loads) for number, item in enumerate(solution.statics))
    unbalanced = unbalanced_parts(robot, solution.frames, solution.o, solution.weights, statics, by_attachment(applied))
    return replace(
        solution,
        twists=twists,
        intensities=tuple(intensities),
        statics=statics,
        unbalanced=unbalanced,
        singular=without_equilibrium(solution.singular, unbalanced),
        applied=applied,
    )


def _under_loads(statics: LimbStatics, number: int, applied: Iterable[AppliedStatics]) -> LimbStatics:
    own = [(item.statics[number], item.times) for item in applied]
    parts = [(part, times) for part, times in own if part is not None]
    return with_loads(statics, parts) if parts else statics


def by_mechanism(robot: RobotStatics, solution: Solution) -> Solution:
    """Return the same equilibrium with the contribution of every limb's weight divided into two.

    The part due to attached wrenches, −C J_ig W_ig of Eq. (12), has the name of the limb; the part due to deformation of beams
    and springs, C J_ic K_ic Δ_igc, is an additional contribution, named by :func:`of_deformation`. The forces that carry the
    limb's own weight belong to the first part, the strains that they cause in the limb to the second part.
    """
    limbs = [limb.name for limb in robot.topology.limbs]
    if solution.contributions[2 + len(limbs) : 2 + 2 * len(limbs)] == tuple(map(of_deformation, limbs)):
        return solution  # already divided
    balance = equilibrium(robot, solution.statics, solution.frames, solution.o)
    before, after = solution.contributions[: 2 + len(limbs)], solution.contributions[2 + len(limbs) :]
    contributions = (*before, *map(of_deformation, limbs), *after)
    statics = solution.weights_alone or solution.statics
    given = solution.load, solution.platform_weight, solution.applied
    right, strains = _by_contribution(robot, balance, solution.contributions, statics, *given)
    if isinstance(balance, CoupledEquilibrium):
        weights = solution.weights, solution.gravity, solution.assembly_errors
        balance.add_weights(solution.contributions, statics, *weights, strains)
    first, last = slice(2, 2 + len(limbs)), 2 + len(limbs)
    right = np.concatenate([right[:, :last], np.zeros_like(right[:, first]), right[:, last:]], axis=1)
    moved = []
    for strain in strains:
        none = np.zeros_like(strain[:, first])
        moved.append(np.concatenate([strain[:, :2], none, strain[:, first], strain[:, last:]], axis=1))
    twists, intensities = balance.solve(right, moved, contributions[-1] == "assembly_errors")
    applied = tuple(replace(item, share=np.insert(item.share, [last] * len(limbs), 0.0, axis=0)) for item in solution.applied)
    return replace(solution, contributions=contributions, twists=twists, intensities=tuple(intensities), applied=applied)


def of_deformation(limb: str) -> str:
    return f"deformation of {limb}"


def unit_cut_wrenches(robot: RobotStatics, solution: Solution) -> list[Array]:
    """Return for each group the cut-joint wrenches N C_ic⁻¹ J_icᵀ K⁻¹ (M, 6, 6, g, N) under six unit loads at o."""
    N = solution.o.shape[1]
    balance = equilibrium(robot, solution.statics, solution.frames, solution.o)
    none = [np.zeros((item.J_c.shape[1], 6, *item.J_c.shape[2:])) for item in solution.statics]
    _, intensities = balance.solve(np.broadcast_to(np.eye(6)[:, :, None], (6, 6, N)), none)
    return [np.einsum("mkign,isgn->mksgn", item.cut_wrenches, W) for item, W in zip(solution.statics, intensities, strict=True)]


def _by_contribution(
    robot: RobotStatics,
    balance: Equilibrium,
    contributions: tuple[str, ...],
    statics: Iterable[LimbStatics],
    load: Array,
    platform_weight: Array,
    applied: tuple[AppliedStatics, ...],
) -> tuple[Array, list[Array]]:
    """Return the right-hand sides W − Σ J_ig W_ig of Eq. (12) and Δ_igc of Eq. (11) for each contribution.

    ``statics`` is the state of the limbs under their own weights, without loads on links or springs.

    Returns:
        (right, strains): ``right`` (6, S, N) are the external wrenches on the platform minus the attached wrenches of the limbs;
        ``strains`` are, for each group, the displacements (n_c, S, g, N) of the limbs' ends along their wrenches due to sag and
        assembly errors.
    """
    right = zeros_for((6, len(contributions), load.shape[1]), load, platform_weight)
    statics = tuple(statics)
    right[:, 0], right[:, 1] = load, platform_weight
    strains = []
    for item in statics:
        strain = zeros_for((item.J_c.shape[1], len(contributions), *item.J_c.shape[2:]), item.J_c)
        if not item.group.is_attached:
            for position, number in enumerate(item.group.numbers):
                right[:, 2 + number] -= item.R_g[:, position]
                if item.group.rigid_directions < len(strain):  # otherwise the sag is rounding
                    strain[:, 2 + number, position] = item.gravity_displacement[:, position]
        if contributions[-1] == "assembly_errors":
            strain[:, -1] += item.assembly_error
            # with an incompatible ring there is no solution, even if the ring is not loaded
            right[:, -1, np.any(np.isnan(item.assembly_error_cut_wrenches), axis=(0, 1, 2))] = np.nan
        strains.append(strain)
    _add_loads(robot, balance, statics, applied, right, strains)
    return right, strains


def _add_loads(
    robot: RobotStatics,
    balance: Equilibrium,
    statics: Sequence[LimbStatics],
    applied: Sequence[AppliedStatics],
    right: Array,
    strains: Sequence[Array],
) -> None:
    """Add loads on links to the right-hand sides of :func:`_by_contribution`, in place."""
    for loaded in applied:
        for wrench in loaded.load.at(robot.topology.platform.attachments).values():
            right += wrench[:, None] * loaded.share
        for item, part, strain in zip(statics, loaded.statics, strains, strict=True):
            if part is not None and not item.group.is_attached:
                right -= part.R_g.sum(axis=1)[:, None] * loaded.share
                if item.group.rigid_directions < len(strain):
                    strain += part.gravity_displacement[:, None] * loaded.share[:, None]
    if isinstance(balance, CoupledEquilibrium):
        balance.add_loads(applied, strains)
