"""Grouping of equal limbs, and the decisions made once for each group: basis, elimination order, rigid combinations of wrenches.
Generic poses, which have no special geometry, decide ranks; bases must be regular at ordinary poses too. Soft wrenches are
constraint wrenches whose compliances span the range of the compliance of a partly rigid limb.
"""

from __future__ import annotations

import numpy as np

from kinetostatics.elements.static_model import StaticModel
from kinetostatics.limbs import force_method
from kinetostatics.limbs.basis_choice import choose_basis
from kinetostatics.limbs.compliance import rigid_counts, soft_wrenches
from kinetostatics.limbs.geometry import Basis, LimbGeometry
from kinetostatics.limbs.group import LimbGroup
from kinetostatics.limbs.statics import limb_statics
from kinetostatics.math.arrays import Array
from kinetostatics.mechanism.tree import Frames, joined_frames


def make_limb_groups(model: StaticModel, frames: Frames, ordinary: Frames) -> tuple[LimbGroup, ...]:
    """Decide ranks at generic ``frames``, choose bases that are also valid at ``ordinary`` frames, and stack equal limbs.

    Raises:
        StaticsError: a limb's wrenches cannot be completed to a basis.
    """
    o = model.mechanism.platform_pose(frames)[1]
    both = joined_frames([frames, ordinary])
    o_of_both = model.mechanism.platform_pose(both)[1]
    alike: dict[tuple[object, ...], list[tuple[LimbGroup, Basis]]] = {}
    plans: dict[tuple[object, ...], list[force_method.EliminationOrder]] = {}
    for number in range(len(model.topology.all_limbs)):
        limb, basis, elimination = _decided(LimbGroup(model, [number]), (frames, o), (both, o_of_both), plans)
        key = (
            limb.signature,
            tuple((c.direction, c.centre) for c in (*basis.constraint, *basis.attached)),
            len(basis.constraint),
            basis.independent,
            basis.carried,
            elimination,
            limb.rigid_directions,
            limb.soft,
        )
        alike.setdefault(key, []).append((limb, basis))
    return tuple(_stacked(model, members) for members in alike.values())


def decided_at(model: StaticModel, number: int, frames: Frames) -> LimbGroup:
    """Return one limb with decisions made at one pose and valid for this pose only."""
    here = frames, model.mechanism.platform_pose(frames)[1]
    group = _decided(LimbGroup(model, [number]), here, here, {})[0]
    group.at_one_pose = True
    return group


def _decided(
    limb: LimbGroup,
    generic: tuple[Frames, Array],
    both: tuple[Frames, Array],
    plans: dict[tuple[object, ...], list[force_method.EliminationOrder]],
) -> tuple[LimbGroup, Basis, force_method.EliminationOrder | None]:
    """Return one limb with decisions made at generic poses, its basis, and its elimination order."""
    geometry = limb.geometry(*generic)
    elimination = None if limb.is_serial else _elimination(limb, geometry, plans.setdefault(limb.signature, []))
    basis = choose_basis(limb.decided(elimination), limb.geometry(*both), generic[1].shape[1])
    limb = limb.decided(elimination, [basis])
    return limb.decided(elimination, [basis], *_rigid_directions(limb, *generic)), basis, elimination


def _stacked(model: StaticModel, members: list[tuple[LimbGroup, Basis]]) -> LimbGroup:
    """Join groups of one limb each, with equal decisions, into one group."""
    first = members[0][0]
    numbers, bases = [limb.numbers[0] for limb, _ in members], [basis for _, basis in members]
    return LimbGroup(model, numbers).decided(first.elimination, bases, first.rigid_directions, first.soft)


def _rigid_directions(limb: LimbGroup, frames: Frames, o: Array) -> tuple[int, tuple[int, ...]]:
    """Return the number of rigid combinations of a limb's constraint wrenches at generic poses, and the soft wrenches."""
    N = o.shape[1]
    weightless = np.zeros((6, len(limb.model.weights.names), N))
    C = limb_statics(limb, frames, o, weightless, np.zeros((3, N))).C
    count = int(np.min(rigid_counts(C)))
    return count, soft_wrenches(C[:, :, 0], len(C) - count)


def _elimination(
    limb: LimbGroup, geometry: LimbGeometry, known: list[force_method.EliminationOrder]
) -> force_method.EliminationOrder:
    """Return a suitable elimination order from ``known``, the orders of equal limbs; else a new one, which is appended."""
    A, P, tolerance = limb.joint_equations(geometry)[:, :, 0], limb.platform_sum, limb.model.rank_tolerance
    for elimination in known:
        if force_method.suits(elimination, A, P, tolerance):
            return elimination
    known.append(force_method.elimination_order(A, P, tolerance))
    return known[-1]
