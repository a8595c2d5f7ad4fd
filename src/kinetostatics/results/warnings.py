"""Warnings about a result, and measures of nearly singular poses. Internal arrays contain g equal limbs at N poses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinetostatics.limbs.statics import LimbStatics
from kinetostatics.math.arrays import Array, Mask, zeros_for
from kinetostatics.math.linalg import Cholesky, canonical_basis
from kinetostatics.math.screws import describe_twist
from kinetostatics.results.result import Result
from kinetostatics.robot import Robot
from kinetostatics.statics.inertia import INERTIA
from kinetostatics.statics.link_loads import sum_of
from kinetostatics.statics.loaded_poses import LoadedPoses
from kinetostatics.statics.solution import Solution, balanced
from kinetostatics.statics.springs import unstable_motions

#: A pose is nearly singular if its constraint index is smaller, or its force amplification exceeds the reciprocal.
LEAST_CONSTRAINT = 0.02
#: Components of a unit twist below this value are omitted from its description.
_NEGLIGIBLE = 2e-3


@dataclass(frozen=True, eq=False)
class NearSingularity:
    """Measures of the joint geometry at poses (N,), lengths divided by the characteristic length; NaN at poses without results.

    Attributes:
        constraint_index: (N,) √(min tᵀ (Σ Q_i Q_iᵀ) t) over unit twists t of the platform; the columns of Q_i are an orthonormal
            basis of the constraint wrenches of limb i. 0 at a singular pose. Under a unit load along t the wrenches of the limbs
            are about 1/index. The bundled robots have 0.12 to 1 at their zero poses.
        force_amplification: (N,) largest joint force of a network (a limb with rings) under a unit wrench of the platform,
            relative to this force at generic poses near the zero pose; infinite where the limb is singular, 0 without networks.
    """

    constraint_index: Array
    force_amplification: Array

    @property
    def where(self) -> NDArray[np.bool_]:
        """(N,) True at nearly singular poses."""
        return (self.constraint_index < LEAST_CONSTRAINT) | (self.force_amplification * LEAST_CONSTRAINT > 1)

    @property
    def worst(self) -> int:
        """Index of the pose nearest to a singularity."""
        return int(np.nanargmin(np.minimum(self.constraint_index, 1 / np.maximum(self.force_amplification, 1e-300))))


def near_singularity(result: Result) -> NearSingularity:
    valid = np.all(np.isfinite(result.twist.reshape(-1, 6)), axis=1)
    index, amplification = np.full((2, len(valid)), np.nan)
    if np.any(valid):
        index[valid] = np.sqrt(np.maximum(np.linalg.eigvalsh(_constraint(result)[valid])[:, 0], 0.0))
        amplification[valid] = _amplifications(result)[0][valid]
    return NearSingularity(index, amplification)


def are_regular(robot: Robot, solution: Solution, usual: Sequence[Array]) -> Mask:
    """(N,) False where :attr:`NearSingularity.where` is True: by the definiteness of matrices, which can be recorded.

    ``usual``: the result of :func:`generic_forces`.
    """
    scale = np.repeat([1.0, 1 / robot.length], 3)[:, None, None, None]
    total, regular = zeros_for((6, 6, solution.o.shape[1]), solution.o), np.ones(solution.o.shape[1], dtype=bool)
    total[range(6), range(6)] -= LEAST_CONSTRAINT**2
    for number, statics in enumerate(solution.statics):
        if statics.J_c.shape[1] and not statics.group.is_attached:
            columns = statics.J_c * scale
            gram = np.einsum("icgn,idgn->cdgn", columns, columns)
            total += np.einsum("icgn,cjgn->ijn", columns, Cholesky(gram).solve(np.swapaxes(columns, 0, 1)))
        if _is_network(statics):
            forces, most = statics.cut_wrenches[:, :3], usual[number][:, None] / LEAST_CONSTRAINT
            regular &= np.all(_is_positive(most**2 * gram - np.einsum("mkcgn,mkdgn->cdgn", forces, forces)), axis=0)
    return regular & _is_positive(total)


def _is_positive(matrix: Array) -> Mask:
    """True (…) where a symmetric matrix (n, n, …) is positive definite."""
    positive: Mask = np.all(np.einsum("ii...->i...", Cholesky(matrix).factor) > 0, axis=0)
    return positive


def near_singular_warnings(result: Result) -> list[str]:
    """Return a warning that names the nearly free motion and its stiffness; an empty list if no pose is nearly singular."""
    singularity = near_singularity(result)
    if not np.any(singularity.where):
        return []
    worst, length = singularity.worst, result.robot.length
    index = singularity.constraint_index[worst]
    if index < LEAST_CONSTRAINT:
        values, vectors = np.linalg.eigh(_constraint(result)[worst])
        twists = canonical_basis(vectors[:, values < LEAST_CONSTRAINT**2]).T
        why = f"a load along this motion causes limb wrenches of about {1 / index:.2g} times its size"
    else:
        twists = _amplifications(result)[1][worst][None]
        times = f"{singularity.force_amplification[worst]:.2g} times"
        why = f"a load along this motion causes joint forces {times} as large as near the zero pose"
    scale = np.repeat([1.0, length], 3)
    C = np.nan_to_num(result.compliance.reshape(-1, 6, 6)[worst]) * scale[:, None] * scale
    motions = [describe_twist(_clean(twist) / scale, length) + _stiffness(twist, C, length) for twist in twists]
    at = ", at the worst" if result.shape else ""
    poses = _poses(result, singularity.where)
    return [f"{poses} nearly singular{at}: the platform is almost free in {' and '.join(motions)}; {why}"]


def _bases(statics: LimbStatics, length: float) -> tuple[Array, Array]:
    """Return Q (g, N, 6, n_c) and R (g, N, n_c, n_c): Q R are each limb's constraint wrenches, moments divided by ``length``."""
    columns = np.moveaxis(np.nan_to_num(statics.J_c), (2, 3), (0, 1)) * np.repeat([1.0, 1 / length], 3)[:, None]
    Q, R = np.linalg.qr(columns)
    return Q, R


def _constraint(result: Result) -> Array:
    """(N, 6, 6) Σ Q_i Q_iᵀ over all limbs; see :class:`NearSingularity`."""
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
    """Return the largest force amplification (N,) of all networks, and the unit wrench (N, 6) that causes it."""
    usual: list[Array] | None = None
    amplifications, loads = [], []
    for solution in result.solutions:
        best, load = np.zeros(solution.o.shape[1]), np.zeros((solution.o.shape[1], 6))
        for number, statics in enumerate(solution.statics):
            if not _is_network(statics):
                continue
            usual = usual or generic_forces(result.robot)
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
    """Return the largest joint force (g, N) of each network under a unit wrench, and the wrench (g, N, 6) that causes it."""
    Q, R = _bases(statics, length)
    forces = np.moveaxis(statics.cut_wrenches[:, :3], (3, 4), (0, 1))
    forces = np.nan_to_num(forces.reshape(*forces.shape[:2], -1, forces.shape[-1])) @ np.linalg.pinv(R)
    _, sizes, rows = np.linalg.svd(forces, full_matrices=False)
    return sizes[..., 0], np.einsum("gnik,gnk->gni", Q, rows[..., 0, :])


def generic_forces(robot: Robot) -> list[Array]:
    """For each group, return the largest joint force (g,) under a unit wrench, at the generic pose where it is least."""
    least_forces = [np.full(len(group.limbs), np.inf) for group in robot.statics.groups]
    frames = robot.generic_frames
    N = frames.position.shape[2]
    solution = balanced(robot.statics, LoadedPoses(frames, np.zeros((6, N)), np.zeros((3, N)))).solution
    for number, statics in enumerate(solution.statics):
        if _is_network(statics):
            sizes = _joint_forces(statics, robot.length)[0]
            least_forces[number] = np.min(np.where(sizes > 0, sizes, np.inf), axis=1)
    return least_forces


def _clean(twist: Array) -> Array:
    """Set negligible components of a unit twist to zero."""
    return np.where(np.abs(twist) < _NEGLIGIBLE, 0.0, twist)


def _stiffness(twist: Array, C: Array, length: float) -> str:
    """Return the stiffness against a motion along a unit twist as text; empty for a rigid robot."""
    soft = float(twist @ C @ twist)
    if soft <= 0:
        return ""
    turn = float(np.linalg.norm(_clean(twist)[3:])) / length
    return f" ({1 / (soft * turn**2):.3g} N·m/rad)" if turn > 0 else f" ({1 / soft:.3g} N/m)"


# ---- all warnings --------------------------------------------------------------------------------------------------

#: Fraction of the buckling load above which linear theory is doubtful.
EULER_WARNING = 0.05
#: Displacement (relative to the characteristic length) and rotation [rad] of the platform above which linear theory is doubtful.
LARGE_MOTION = 0.1
#: Relative change of the stiffness by forces above which there is a warning.
CHANGE = 0.01
#: Relative component of a self-stress, and eigenvalue of the tangent stiffness, that count as zero.
NOTHING = 1e-9
#: Gap of the loops [m, rad] above which there is a warning.
OPEN_LOOPS = 1e-9


def result_warnings(result: Result) -> tuple[str, ...]:
    warnings = [*_instability(result), *_buckling(result), *result.robot.warnings]
    warnings += result.robot.description.inertia_warnings if INERTIA in result.contributions else ()
    warnings += [*_open_loops(result), *_large_motions(result), *near_singular_warnings(result)]
    for exceeded in result.configuration.limits_exceeded.values():
        slides = result.robot.mechanism.connections[exceeded.joint].type.is_slide
        factor, unit = (1e-3, " mm") if slides else (np.pi / 180, "°")
        lower, upper = (f"{limit / factor:.6g}" for limit in (exceeded.lower, exceeded.upper))
        where = (
            f" in {int(exceeded.where.sum())} poses" if exceeded.where.shape else f": {float(exceeded.value) / factor:.6g}{unit}"
        )
        warnings.append(f"{exceeded.joint} is beyond its limits of {lower} to {upper}{unit}{where}")
    warnings += overload_warnings(result)
    if np.any(result.indeterminate):
        warnings.append(indeterminate_parts(result))
    return tuple(dict.fromkeys(warnings))


def overload_warnings(result: Result) -> list[str]:
    """Return a warning for each actuator beyond its limit of effort, and for each beam beyond its yield strength."""
    connections, beams, warnings = result.robot.mechanism.connections, result.robot.description.beams, []
    efforts = result.robot.description.actuator_limits("effort")
    for limit, utilization in result.margins.stated.items():
        exceeded = utilization > 1
        if not np.any(exceeded):
            continue
        kind, _, name = limit.partition(" of ")
        if kind == "effort":
            what, unit, most, of = f"the force of {name}", connections[name].type.force_unit, efforts[name], "limit of effort"
        else:
            what, unit, most, of = (
                f"the stress in {name}",
                "MPa",
                1e-6 * float(beams[name].material.yield_strength or 0.0),
                "yield strength",
            )
        value = f"{most * float(np.nanmax(utilization)):.5g} {unit}"
        where = f" in {int(exceeded.sum())} of {exceeded.size} poses, up to {value}" if result.shape else f": {value}"
        warnings.append(f"{what} is beyond the {of} of {most:.5g} {unit}{where}")
    return warnings


def _instability(result: Result) -> list[str]:
    """Return a warning about unstable poses of robots with springs: the tangent stiffness has an eigenvalue ≤ 0."""
    if not result.robot.description.springs:
        return []
    sizes = [len(solution.singular) for solution in result.solutions]
    pairs = list(zip(result.solutions, sizes, strict=True))
    inside, of_platform = (
        np.concatenate([unstable_motions(solution.tangents[part], N) for solution, N in pairs])
        for part in (slice(-1), slice(-1, None))
    )
    where = (inside + of_platform > 0) & np.all(np.isfinite(result.twist.reshape(-1, 6)), axis=1)
    if not np.any(where):
        return []
    first = int(np.argmax(where))
    stiffness = "within the limbs"
    if of_platform[first]:
        scale = np.repeat([1.0, result.robot.length], 3)
        C = np.nan_to_num(result.compliance.reshape(-1, 6, 6)[first]) * scale[:, None] * scale
        values, vectors = np.linalg.eigh(C)
        stiffness = f"of the platform in {_motions(values, vectors, 0, scale)}"
    at = ", at the first of them" if result.shape else ""
    return [f"{_poses(result, where)} unstable: springs and weights overcome the stiffness {stiffness}{at}; no result applies"]


def _poses(result: Result, where: NDArray[np.bool_]) -> str:
    """Return "3 of 10 poses are", the number of poses where ``where`` (N,) is True; or "the pose is"."""
    return f"{int(where.sum())} of {where.size} poses are" if result.shape else "the pose is"


def _buckling(result: Result) -> list[str]:
    """Return warnings about members near buckling, and about the change of stiffness by forces, which linear theory neglects."""
    chunks = [result.robot.members.ratios(solution, EULER_WARNING) for solution in result.solutions]
    ratios = {
        name: max(float(np.max(np.nan_to_num(chunk[name]), initial=0.0)) for chunk in chunks) for name in result.robot.beams
    }
    members: dict[str, list[str]] = {}
    for name, ratio in ratios.items():
        members.setdefault(f"{ratio:.6g}", []).append(name)
    beyond: list[str] = []
    near: list[str] = []
    for beams in members.values():
        ratio, of = ratios[beams[0]], "beam" if len(beams) == 1 else "beams"
        text = f"the forces are {100 * ratio:.3g} % of the buckling load of {of} {', '.join(beams)}"
        if ratio >= 1:
            beyond.append(f"{text}: no result applies")
        elif ratio > EULER_WARNING:
            near.append(text)
    if not ratios and np.any(result.buckles):
        beyond = ["the forces exceed the buckling load of the robot: no result applies"]
    if changed := _changed_stiffness(result):
        return [*beyond, "; ".join([*near, changed])]
    return [*beyond, *(f"{text}; linear theory underestimates the deflections" for text in near)]


def _changed_stiffness(result: Result) -> str:
    """Return how much forces change the stiffness, as a clause; for the pose where compliance times force is largest."""
    if not result.twist.size:
        return ""
    scale = np.repeat([1.0, result.robot.length], 3)
    softness = np.linalg.norm(np.nan_to_num(result.compliance.reshape(-1, 36)) * np.outer(scale, scale).ravel(), axis=1)
    parts = [(solution.load, solution.weights.sum(axis=1), sum_of(solution.applied)) for solution in result.solutions]
    forces = np.concatenate([sum(np.linalg.norm(wrench[:3], axis=0) for wrench in part) for part in parts])
    sound = np.all(np.isfinite(result.twist.reshape(-1, 6)), axis=1) & ~result.indeterminate.ravel()
    worst = int(np.argmax(np.where(sound, softness * forces, 0.0)))
    ends = np.cumsum([solution.o.shape[1] for solution in result.solutions])
    chunk = int(np.searchsorted(ends, worst, side="right"))
    solution = result.solutions[chunk]
    at = np.array([solution.o.shape[1] + worst - int(ends[chunk])])
    second_order = result.robot.members.second_order(solution, at)
    changes, motions = second_order.stiffness[:, 0], second_order.motions[..., 0]
    if not changes.size:
        return ""
    largest = int(np.argmax(np.abs(np.nan_to_num(changes))))
    where = "" if result.shape == () else " at the pose that is softest under them"
    if not sound[worst] or not abs(changes[largest]) > CHANGE:
        return ""
    against = _motions(changes, motions, largest, scale)
    change = f"the forces change the stiffness of the platform against {against} by {100 * changes[largest]:+.2g} %{where}"
    return f"{change}, which linear theory neglects: see result.second_order"


def _motions(values: Array, vectors: Array, k: int, scale: Array) -> str:
    """Describe the motions spanned by all eigenvectors whose eigenvalues equal the k-th of ``values`` (6,)."""
    alike = np.abs(values - values[k]) <= 1e-6 * abs(values[k])
    spanned = np.linalg.svd(np.concatenate([vectors[:, alike].real, vectors[:, alike].imag], axis=1))[0][:, : np.sum(alike)]
    return " and ".join(describe_twist(twist / scale, scale[-1]) for twist in canonical_basis(spanned).T)


def _open_loops(result: Result) -> list[str]:
    open_by = float(np.nanmax(result.configuration.residual, initial=0.0))
    if open_by <= OPEN_LOOPS:
        return []
    return [f"the loops stay open by up to {open_by:.2g} m or rad: angles or lengths of the file are rounded"]


def _large_motions(result: Result) -> list[str]:
    twist = np.nan_to_num(result.twist)
    shift = float(np.linalg.norm(twist[..., :3], axis=-1).max(initial=0.0))
    turn = float(np.linalg.norm(twist[..., 3:], axis=-1).max(initial=0.0))
    if shift < LARGE_MOTION * result.robot.length and turn < LARGE_MOTION:
        return []
    return [
        f"the platform moves by {shift:.3g} m and {turn:.3g} rad, too much for linear theory: check the units of moduli, "
        "diameters and masses"
    ]


def indeterminate_parts(result: Result) -> str:
    """Return a warning that names the rigid limbs and rings with statically indeterminate forces."""
    rigid: dict[str, None] = {}
    rings: dict[str, dict[str, None]] = {}
    for solution in result.solutions:
        for statics, unknown in zip(solution.statics, solution.undetermined, strict=True):
            for position, limb in enumerate(statics.group.limbs):
                if np.any(unknown[:, position]):
                    rigid[limb.name] = None
                undetermined = statics.undetermined[:, :, :, position]
                for edge in limb.edges if np.any(undetermined) else ():
                    carried = np.sum([sign * undetermined[cut] for cut, sign in edge.cut_joints], axis=0)
                    if edge.joint and np.max(np.abs(carried)) > NOTHING * np.max(np.abs(undetermined)):
                        rings.setdefault(limb.name, {})[edge.joint] = None
    what = [f"the rigid limbs {', '.join(rigid)} overconstrain one another"] if rigid else []
    what += [
        f"the rigid rings in {limb} ({', '.join(joints)}) are overconstrained in themselves" for limb, joints in rings.items()
    ]
    return (
        f"{' and '.join(what) or 'rigid parts are overconstrained'}: their forces are statically indeterminate, returned as NaN"
    )
