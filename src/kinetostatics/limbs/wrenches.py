"""Wrenches of limbs from joints and weights alone: J_ic, J_ig and W_ig, Eqs. (2)–(4), and the cut-joint wrenches.

Arrays are ``(…, limb, pose)``, wrenches about o, world axes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinetostatics.limbs import force_method
from kinetostatics.limbs.basis_choice import evaluate_bases
from kinetostatics.limbs.geometry import LimbGeometry
from kinetostatics.limbs.group import LimbGroup
from kinetostatics.math.arrays import Array
from kinetostatics.math.linalg import Cholesky, definite, least_squares, normalize

#: Squared sine of an angle below which the dependence of joint twists is checked.
DOUBTFUL = 1e-8


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
        degenerate: (g, N) mask of degenerate canonical bases.
        doubtful: (g, N) mask of limbs whose joint twists may be dependent, so that they transmit more wrenches.
    """

    J_c: Array
    J_g: Array
    W_g: Array
    cut_wrenches: Array
    particular: Array
    self_stress: Array
    unbalanced: Array
    degenerate: NDArray[np.bool_]
    doubtful: NDArray[np.bool_]


def limb_wrenches(group: LimbGroup, geometry: LimbGeometry, outboard: Array, loaded: bool = False) -> LimbWrenches:
    """Compute the wrenches of limbs that do no work on any passive freedom j, with unit twists T.

    Tᵀ J_ic = 0, Eq. (2), and T_jᵀ (J_ig W_ig + Σ w) = 0, Eq. (3), with the weights w outboard of j; J_ig W_ig is the solution of
    Eq. (4) in the canonical basis.

    Args:
        group, geometry: the limbs and their geometry.
        outboard: (6, passive freedoms, g, N) the weights outboard of each passive freedom, about o, world axes [N, N·m].
        loaded: whether ``outboard`` are loads on links instead of weights. Loads may also act on links inside a platform joint;
            their wrenches are then no combinations of the attached wrenches of weights.
    """
    T = geometry.twists[:, group.passive]
    demand = np.einsum("ik...,ik...->k...", T, outboard) / group.power_scale[:, 0]
    return _of_serial(group, geometry, T, demand, loaded) if group.is_serial else _of_rings(group, geometry, demand)


def _of_serial(group: LimbGroup, geometry: LimbGeometry, T: Array, demand: Array, loaded: bool) -> LimbWrenches:
    """Return the wrenches of serial limbs, whose single cut joint transmits the wrench of the platform on the limb.

    Args:
        group, geometry: the limbs and their geometry.
        T: (6, k, g, N) unit twists of the passive freedoms.
        demand: (k, g, N) power of the weights on them: Eq. (3) is Tᵀ J_ig W_ig = −demand [N].
        loaded: whether ``demand`` is that of loads on links instead of weights; see :func:`limb_wrenches`.
    """
    J_c, J_g, degenerate = evaluate_bases(group, geometry, T)
    W_g = np.zeros((J_g.shape[1], *demand.shape[1:]))
    left, doubtful = demand, _crossed(group, geometry)
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
        more, left = _carried(group, T, left)
        R_g = R_g + more
    return LimbWrenches(J_c, J_g, W_g, J_c[None], R_g[None], none, left, degenerate, doubtful)


def _carried(group: LimbGroup, T: Array, demand: Array) -> tuple[Array, Array]:
    """Return a wrench (6, g, N) with the power −``demand`` on the twists ``T``, and the residual."""
    twists = T * group.twist_scale / np.swapaxes(group.power_scale, 0, 1)
    chosen = list(group.basis.independent)
    factor = Cholesky(np.einsum("ia...,ib...->ab...", twists[:, chosen], twists[:, chosen]))
    wrench = np.zeros((6, *demand.shape[1:]))
    for _ in range(2):  # the second iteration corrects the error of the normal equations
        more = np.einsum("ia...,ak...->i...", twists[:, chosen], factor.solve(demand[chosen, None]))
        wrench = wrench - more * group.twist_scale[:, 0]
        demand = demand - np.einsum("ik...,i...->k...", twists, more)
    return wrench, demand


def _crossed(group: LimbGroup, geometry: LimbGeometry) -> NDArray[np.bool_]:
    """Return the mask (g, N) of limbs whose platform joint has possibly dependent twists; a single compound joint never has."""
    carried = list(group.basis.carried)
    if len({int(compound) for compound in group.compound_of[carried]}) < 2:
        return np.zeros(geometry.limb_axes.shape[2:], dtype=bool)
    twists = normalize(geometry.twists[:, carried] / group.twist_scale[::-1])
    return ~definite(np.einsum("ki...,kj...->ij...", twists, twists), DOUBTFUL)


def _of_rings(group: LimbGroup, geometry: LimbGeometry, demand: Array) -> LimbWrenches:
    """Return the wrenches of limbs with several cut joints by the force method; ``demand`` as in :func:`_of_serial`."""
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
