"""Limbs at many poses: constraint wrenches J_ic, attached wrenches J_ig W_ig, compliance C_ic and sag Δ_igc.

All limbs are solved alike: what every edge carries is a sum of cut-joint wrenches (:mod:`kinetostatics.mechanism.limbs`) and
weights. Limbs that are built alike are stacked along an axis of their own: arrays are ``(component, column, limb, pose)``.
"""

from __future__ import annotations

import operator
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from kinetostatics.limbs.compliance import LimbLoads, own_weights_of_beams
from kinetostatics.limbs.geometry import LimbGeometry
from kinetostatics.limbs.group import LimbGroup
from kinetostatics.limbs.redundant_forces import relaxed_limbs
from kinetostatics.limbs.wrenches import limb_wrenches
from kinetostatics.math.arrays import Array
from kinetostatics.mechanism.tree import Frames
from kinetostatics.printing.mappings import ShortRepr


@dataclass(frozen=True, repr=False)
class LimbStatics(ShortRepr):
    """A group of limbs at many poses; arrays (…, limb, pose), wrenches about o, world axes.

    Attributes:
        group: the limbs.
        J_c, J_g: (6, n_c, g, N), (6, n_g, g, N) constraint and attached wrenches, Eqs. (2), (4).
        W_g: (n_g, g, N) attached intensities, Eq. (3) [N or N·m].
        R_g: (6, g, N) their sum J_ig W_ig [N, N·m].
        C: (n_c, n_c, g, N) compliance C_ic, Eq. (1).
        gravity_displacement: (n_c, g, N) Δ_igc, Eqs. (16), (19), (21) [m or rad].
        assembly_error: (n_c, g, N) the same of assembly errors.
        cut_wrenches: (M, 6, n_c, g, N) cut-joint wrenches per unit of each intensity; of a serial limb J_c itself.
        particular: (M, 6, g, N) cut-joint wrenches under the limb's own weight; of a serial limb R_g.
        assembly_error_cut_wrenches: (M, 6, g, N) cut-joint wrenches under assembly errors with no intensity: self-stress.
        loose: (M, 6, s, g, N) self-stresses without any compliance: how much of them there is cannot be told.
        loads: the weights on beams and springs.
        unbalanced: (passive freedoms, g, N) what is left of Eq. (3) [N].
        degenerate: (g, N) where the bases are not the canonical ones.
        doubtful: (g, N) where the limb may have other ranks than at generic poses.
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


def limb_statics(
    group: LimbGroup, frames: Frames, o: Array, weights: Array, gravity: Array, assembly_error: Array | None = None
) -> LimbStatics:
    """Evaluate the wrenches, compliances and sag of alike limbs.

    Args:
        group: the limbs.
        frames: of all bodies.
        o: (3, N) reference point [m].
        weights: (6, W, N) wrenches of all weights about o [N, N·m].
        gravity: (3, N) [m/s²].
        assembly_error: (6, elements, g, N) what each element's outboard side is off by for no force, about o; None: nothing.
    """
    geometry = group.geometry(frames, o)
    outboard, beyond, spring_beyond = group.weights_outboard(weights)
    loads = LimbLoads(beyond, spring_beyond, own_weights_of_beams(group, geometry, gravity))
    return _statics(group, geometry, outboard, loads, assembly_error)


def limb_statics_under(group: LimbGroup, frames: Frames, o: Array, wrenches: Mapping[str, Array]) -> LimbStatics:
    """Evaluate alike limbs without their weights, under loads at some of their places alone.

    Args:
        group: the limbs.
        frames: of all bodies.
        o: (3, N) reference point [m].
        wrenches: (6, N) about o by the place at which they act [N, N·m].
    """
    geometry = group.geometry(frames, o)
    outboard, beyond, spring_beyond = group.loads_outboard(wrenches)
    return _statics(group, geometry, outboard, LimbLoads(beyond, spring_beyond, np.zeros((3, *beyond.shape[1:]))), None)


def with_loads(statics: LimbStatics, parts: Sequence[tuple[LimbStatics, Array]]) -> LimbStatics:
    """Return limbs under their weights and under loads together; each of the ``parts`` counts so many times (N,)."""

    def total(name: str) -> Array:
        pick = operator.attrgetter(name)
        return np.asarray(sum((pick(part) * times for part, times in parts), pick(statics)))

    return replace(
        statics,
        W_g=total("W_g"),
        R_g=total("R_g"),
        gravity_displacement=total("gravity_displacement"),
        particular=total("particular"),
        unbalanced=total("unbalanced"),
        loads=LimbLoads(total("loads.beyond"), total("loads.spring_beyond"), total("loads.own")),
    )


def _statics(
    group: LimbGroup, geometry: LimbGeometry, outboard: Array, loads: LimbLoads, assembly_error: Array | None
) -> LimbStatics:
    """Evaluate limbs under loads (6, passive freedoms, g, N) outboard of passive freedoms, and on their beams and springs."""
    found = limb_wrenches(group, geometry, outboard)
    relaxed = relaxed_limbs(group, geometry, found, loads, assembly_error)
    return LimbStatics(
        group=group,
        J_c=found.J_c,
        J_g=found.J_g,
        W_g=found.W_g,
        R_g=group.platform_wrench(relaxed.particular),
        C=relaxed.C,
        gravity_displacement=relaxed.gravity_displacement,
        assembly_error=relaxed.assembly_error,
        cut_wrenches=relaxed.cut_wrenches,
        particular=relaxed.particular,
        assembly_error_cut_wrenches=relaxed.assembly_error_cut_wrenches,
        loose=relaxed.loose,
        loads=loads,
        unbalanced=found.unbalanced,
        degenerate=found.degenerate | group.at_one_pose,
        doubtful=found.doubtful,
    )
