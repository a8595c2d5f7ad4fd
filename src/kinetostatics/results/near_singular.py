"""Nearly singular poses: measures of the constraint of the platform by the limbs.

Two dimensionless measures of the joint geometry (lengths are divided by the characteristic length):

* *Constraint index*: the square root of min tᵀ (Σ Q_i Q_iᵀ) t over unit twists t of the platform, with an orthonormal basis Q_i
  of J_ic. It is zero at a singular pose; under a unit load along the minimizing twist, the wrenches of the limbs are about
  1/index.
  The robots in ``robots/`` have 0.12 to 1 at their zero poses.
* *Force amplification* of a limb with internal loops: the largest joint force under a unit wrench of the platform,
  relative to that at generic poses near the zero pose; infinite where the limb is singular.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinetostatics.limbs.statics import LimbStatics
from kinetostatics.math.arrays import Array
from kinetostatics.math.linalg import canonical_basis
from kinetostatics.math.screws import describe_twist
from kinetostatics.results.result import Result
from kinetostatics.robot import Robot
from kinetostatics.statics.solution import balanced

#: A pose is nearly singular if its constraint index is smaller, or its force amplification exceeds the reciprocal.
LEAST_CONSTRAINT = 0.02
#: Components of a unit twist below this value are omitted from its description.
_NEGLIGIBLE = 2e-3


@dataclass(frozen=True, eq=False)
class NearSingularity:
    """Constraint of the platform at poses (N,); NaN at poses without results.

    Attributes:
        constraint_index: (N,) constraint index.
        force_amplification: (N,) largest force amplification of all networks; 0 without networks.
    """

    constraint_index: Array
    force_amplification: Array

    @property
    def where(self) -> NDArray[np.bool_]:
        """The mask (N,) of nearly singular poses."""
        return (self.constraint_index < LEAST_CONSTRAINT) | (self.force_amplification * LEAST_CONSTRAINT > 1)

    @property
    def worst(self) -> int:
        """Index of the pose nearest to a singularity."""
        return int(np.nanargmin(np.minimum(self.constraint_index, 1 / np.maximum(self.force_amplification, 1e-300))))


def near_singularity(result: Result) -> NearSingularity:
    """Return the measures of all poses of a result."""
    valid = np.all(np.isfinite(result.twist.reshape(-1, 6)), axis=1)
    index, amplification = np.full((2, len(valid)), np.nan)
    if np.any(valid):
        index[valid] = np.sqrt(np.maximum(np.linalg.eigvalsh(_constraint(result)[valid])[:, 0], 0.0))
        amplification[valid] = _amplifications(result)[0][valid]
    return NearSingularity(index, amplification)


def near_singular_message(result: Result) -> str | None:
    """Return a warning that names the nearly free motion and its stiffness; None if no pose is nearly singular."""
    found = near_singularity(result)
    where = found.where
    if not np.any(where):
        return None
    worst, length = found.worst, result.robot.length
    if found.constraint_index[worst] < LEAST_CONSTRAINT:
        values, vectors = np.linalg.eigh(_constraint(result)[worst])
        twists = canonical_basis(vectors[:, values < LEAST_CONSTRAINT**2]).T
        why = f"limbs must carry about {1 / found.constraint_index[worst]:.2g} times a load along it"
    else:
        twists = _amplifications(result)[1][worst][None]
        why = f"joints carry about {found.force_amplification[worst]:.2g} times as much under such a load as near the zero pose"
    scale = np.repeat([1.0, length], 3)
    C = np.nan_to_num(result.compliance.reshape(-1, 6, 6)[worst]) * scale[:, None] * scale
    motions = [describe_twist(_clean(twist) / scale, length) + _stiffness(twist, C, length) for twist in twists]
    poses = "the pose is" if result.shape == () else f"{int(where.sum())} of {where.size} poses are"
    at = "" if result.shape == () else ", at the worst"
    return f"{poses} nearly singular{at}: the platform is almost free in {' and '.join(motions)}; {why}"


def _bases(statics: LimbStatics, length: float) -> tuple[Array, Array]:
    """Return Q (g, N, 6, n_c) and R of the decomposition J_ic = Q R of the constraint wrenches, moments divided by the length."""
    columns = np.moveaxis(np.nan_to_num(statics.J_c), (2, 3), (0, 1)) * np.repeat([1.0, 1 / length], 3)[:, None]
    Q, R = np.linalg.qr(columns)
    return Q, R


def _constraint(result: Result) -> Array:
    """Return the sums (N, 6, 6) of the projectors on the limbs' constraint wrenches."""
    sums = []
    for solution in result.solutions:
        total = np.zeros((solution.o.shape[1], 6, 6))
        for statics in solution.statics:
            if statics.J_c.shape[1] and not statics.group.is_attached:
                Q = _bases(statics, result.robot.length)[0]
                total += np.einsum("gnik,gnjk->nij", Q, Q)
        sums.append(total)
    return np.concatenate(sums)


def _amplifications(result: Result) -> tuple[Array, Array]:
    """Return the largest force amplification (N,) of networks, and its unit wrench (N, 6); both 0 without networks."""
    usual: list[Array] | None = None
    amplifications, loads = [], []
    for solution in result.solutions:
        best, load = np.zeros(solution.o.shape[1]), np.zeros((solution.o.shape[1], 6))
        for number, statics in enumerate(solution.statics):
            if not _is_network(statics):
                continue
            usual = usual or _generic_forces(result.robot)
            sizes, wrenches = _joint_forces(statics, result.robot.length)
            ratios = sizes / usual[number][:, None]
            for ratio, wrench in zip(ratios, wrenches, strict=True):
                load = np.where((ratio > best)[:, None], wrench, load)
                best = np.maximum(best, ratio)
        amplifications.append(best)
        loads.append(load)
    return np.concatenate(amplifications), np.concatenate(loads)


def _is_network(statics: LimbStatics) -> bool:
    group = statics.group
    return bool(statics.J_c.shape[1]) and not group.is_serial and not group.is_attached


def _joint_forces(statics: LimbStatics, length: float) -> tuple[Array, Array]:
    """Return the largest joint forces (g, N) of networks under unit wrenches, and these wrenches (g, N, 6)."""
    Q, R = _bases(statics, length)
    forces = np.moveaxis(statics.cut_wrenches[:, :3], (3, 4), (0, 1))
    forces = np.nan_to_num(forces.reshape(*forces.shape[:2], -1, forces.shape[-1])) @ np.linalg.pinv(R)
    _, sizes, rows = np.linalg.svd(forces, full_matrices=False)
    return sizes[..., 0], np.einsum("gnik,gnk->gni", Q, rows[..., 0, :])


def _generic_forces(robot: Robot) -> list[Array]:
    """Return the smallest of the largest joint forces (g,) at the generic poses, for each limb group; infinite if unknown."""
    found = [np.full(len(group.limbs), np.inf) for group in robot.statics.groups]
    frames = robot.generic_frames
    N = frames.position.shape[2]
    solution = balanced(robot.statics, frames, np.zeros((6, N)), np.zeros((3, N))).solution
    for number, statics in enumerate(solution.statics):
        if _is_network(statics):
            sizes = _joint_forces(statics, robot.length)[0]
            found[number] = np.min(np.where(sizes > 0, sizes, np.inf), axis=1)
    return found


def _clean(twist: Array) -> Array:
    """Set negligible components of a unit twist to zero."""
    return np.where(np.abs(twist) < _NEGLIGIBLE, 0.0, twist)


def _stiffness(twist: Array, C: Array, length: float) -> str:
    """Return the stiffness of a motion along a unit twist as text; empty for a rigid robot."""
    soft = float(twist @ C @ twist)
    if soft <= 0:
        return ""
    turn = float(np.linalg.norm(_clean(twist)[3:])) / length
    return f" ({1 / (soft * turn**2):.3g} N·m/rad)" if turn > 0 else f" ({1 / soft:.3g} N/m)"
