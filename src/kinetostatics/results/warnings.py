"""Warnings about a result, in full sentences."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from kinetostatics.math.arrays import Array
from kinetostatics.math.linalg import canonical_basis
from kinetostatics.math.screws import describe_twist
from kinetostatics.results.near_singular import near_singular_message
from kinetostatics.results.result import Result
from kinetostatics.statics.link_loads import sum_of
from kinetostatics.statics.solution import Solution

#: Fraction of the Euler load above which linear theory is doubtful.
EULER_WARNING = 0.05
#: Displacement (relative to the characteristic length) and rotation [rad] of the platform above which linear theory is doubtful.
LARGE_MOTION = 0.1
#: Relative change of stiffness by forces up to which there is no warning.
CHANGE = 0.01
#: Component of a self-stress below which a joint counts as unstressed.
NOTHING = 1e-9
#: Gap of the loops [m, rad] above which there is a warning.
OPEN_LOOPS = 1e-9


def result_warnings(result: Result) -> tuple[str, ...]:
    """Return the warnings of the robot, of its poses, and of the results under the loads."""
    found = [
        *_tipping(result),
        *_buckling(result),
        *_loaded(result),
        *result.robot.warnings,
    ]
    found += _open_loops(result) + _large_motions(result)
    near = near_singular_message(result)
    found += [near] if near else []
    for item in result.configuration.limits_exceeded.values():
        slides = result.robot.mechanism.connections[item.joint].type.is_slide
        factor, unit = (1e-3, " mm") if slides else (np.pi / 180, "°")
        lower, upper = (f"{limit / factor:.6g}" for limit in (item.lower, item.upper))
        where = f" in {int(item.where.sum())} poses" if item.where.shape else f": {float(item.value) / factor:.6g}{unit}"
        found.append(f"{item.joint} is beyond its limits of {lower} to {upper}{unit}{where}")
    if np.any(result.indeterminate):
        found.append(undetermined_parts(result))
    return tuple(dict.fromkeys(found))


def _tipping(result: Result) -> list[str]:
    """Return a warning if springs and weights make poses unstable: an eigenvalue of the tangent stiffness is negative or 0."""
    if not result.robot.description.springs:
        return []
    inside, of_platform = (np.concatenate(counts) for counts in zip(*map(_negative, result.solutions), strict=True))
    where = (inside + of_platform > 0) & np.all(np.isfinite(result.twist.reshape(-1, 6)), axis=1)
    if not np.any(where):
        return []
    first = int(np.argmax(where))
    restoring = "the elastic restoring forces between parts of its limbs"
    if of_platform[first]:
        scale = np.repeat([1.0, result.robot.length], 3)
        C = np.nan_to_num(result.compliance.reshape(-1, 6, 6)[first]) * scale[:, None] * scale
        values, vectors = np.linalg.eigh(C)
        restoring = f"the elastic restoring forces of the platform in {_motions(values, vectors, 0, scale)}"
    poses = "the pose is" if result.shape == () else f"{int(where.sum())} of {where.size} poses are"
    at = "" if result.shape == () else ", at the first of them"
    return [f"{poses} unstable: the forces of springs and weights reach or exceed {restoring}{at}; the results do not apply"]


def _loaded(result: Result) -> list[str]:
    """Return a warning if forces change the stiffness, constant in linear theory."""
    near = _near(result)
    changed = _changed_stiffness(result)
    if changed:
        return ["; ".join([*near, changed])]
    return [f"{text}; linear theory underestimates the deflections" for text in near]


def _changed_stiffness(result: Result) -> str:
    """Return a clause on the change of the stiffness at the pose where the platform is soft and forces are large."""
    if result.robot.description.springs or not result.twist.size:
        return ""
    scale = np.repeat([1.0, result.robot.length], 3)
    softness = np.linalg.norm(np.nan_to_num(result.compliance.reshape(-1, 36)) * np.outer(scale, scale).ravel(), axis=1)
    parts = [(item.load, item.weights.sum(axis=1), sum_of(item.applied)) for item in result.solutions]
    forces = np.concatenate([sum(np.linalg.norm(wrench[:3], axis=0) for wrench in part) for part in parts])
    sound = np.all(np.isfinite(result.twist.reshape(-1, 6)), axis=1) & ~result.indeterminate.ravel()
    worst = int(np.argmax(np.where(sound, softness * forces, 0.0)))
    ends = np.cumsum([solution.o.shape[1] for solution in result.solutions])
    chunk = int(np.searchsorted(ends, worst, side="right"))
    solution = result.solutions[chunk]
    at = np.array([solution.o.shape[1] + worst - int(ends[chunk])])
    *_, changes, motions = (array[..., 0] for array in result.robot.members.second_order(solution, at))
    if not changes.size:
        return ""
    largest = int(np.argmax(np.abs(np.nan_to_num(changes))))
    where = "" if result.shape == () else " at the pose that is softest under them"
    if sound[worst] and np.isnan(changes[largest]):
        return "" if np.any(result.buckles) else f"the forces exceed those at which the robot is stable{where}: no result applies"
    if not sound[worst] or abs(changes[largest]) <= CHANGE:
        return ""
    against = _motions(changes, motions, largest, scale)
    change = f"the forces change the stiffness of the platform against {against} by {100 * changes[largest]:+.2g} %{where}"
    return f"{change}: linear theory neglects this, result.second_order does not"


def _motions(values: Array, vectors: Array, k: int, scale: Array) -> str:
    """Describe the motions of the k-th eigenvalue (6,); of all equal eigenvalues, as eigenvectors (6, 6) are arbitrary."""
    alike = np.abs(values - values[k]) <= 1e-6 * abs(values[k])
    spanned = np.linalg.svd(np.concatenate([vectors[:, alike].real, vectors[:, alike].imag], axis=1))[0][:, : np.sum(alike)]
    return " and ".join(describe_twist(twist / scale, scale[-1]) for twist in canonical_basis(spanned).T)


def _negative(solution: Solution) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the number of unstable motions of each pose (N,) with the platform fixed, and the number of the others."""
    counts = []
    for tangent in solution.tangents:
        matrices = np.nan_to_num(np.moveaxis(tangent, 2, 0))
        counts.append(np.sum(np.linalg.eigvals(matrices).real < NOTHING, axis=1))
    return np.sum(counts[:-1], axis=0) + np.zeros(solution.o.shape[1], dtype=np.intp), counts[-1]


def _ratios(result: Result) -> Iterator[tuple[str, float]]:
    """Yield a clause for each member, or the robot, that can buckle, with its largest ratio of load to critical load."""
    together: dict[str, list[str]] = {}
    worst = {beam.name: float(np.max(np.nan_to_num(beam.euler_ratio), initial=0.0)) for beam in result.beams.values()}
    for name, ratio in worst.items():
        together.setdefault(f"{ratio:.6g}", []).append(name)
    for names in together.values():
        yield f"beam {names[0]} buckles" if len(names) == 1 else f"beams {', '.join(names)} buckle", worst[names[0]]


def _buckling(result: Result) -> list[str]:
    return [
        f"{what}: the forces are {100 * worst:.3g} % of those at which this begins"
        for what, worst in _ratios(result)
        if worst >= 1
    ]


def _near(result: Result) -> list[str]:
    """Return clauses about what the forces are near to."""
    found = [(what, worst) for what, worst in _ratios(result) if EULER_WARNING < worst < 1]
    return [f"the forces are {100 * worst:.3g} % of those at which {what}" for what, worst in found]


def _open_loops(result: Result) -> list[str]:
    open_by = float(np.nanmax(result.configuration.residual, initial=0.0))
    if open_by <= OPEN_LOOPS:
        return []
    return [f"the loops stay open by up to {open_by:.2g} m or rad: angles or lengths of the file are rounded"]


def _large_motions(result: Result) -> list[str]:
    """Return a warning if the motion of the platform is too large for linear theory."""
    twist = np.nan_to_num(result.twist)
    shift = float(np.linalg.norm(twist[..., :3], axis=-1).max(initial=0.0))
    turn = float(np.linalg.norm(twist[..., 3:], axis=-1).max(initial=0.0))
    if shift < LARGE_MOTION * result.robot.length and turn < LARGE_MOTION:
        return []
    return [
        f"the platform moves by {shift:.3g} m and {turn:.3g} rad, which linear theory does not cover: look for wrong units "
        "in moduli, diameters and masses"
    ]


def undetermined_parts(result: Result) -> str:
    """Return a warning that names the rigid limbs and rings with statically indeterminate forces."""
    rigid: dict[str, None] = {}
    rings: dict[str, dict[str, None]] = {}
    for solution in result.solutions:
        for item, undetermined in zip(solution.statics, solution.undetermined, strict=True):
            for position, limb in enumerate(item.group.limbs):
                if np.any(undetermined[:, position]):
                    rigid[limb.name] = None
                loose = item.loose[:, :, :, position]
                for edge in limb.edges if np.any(loose) else ():
                    carried = np.sum([sign * loose[cut] for cut, sign in edge.cut_joints], axis=0)
                    if edge.joint and np.max(np.abs(carried)) > NOTHING * np.max(np.abs(loose)):
                        rings.setdefault(limb.name, {})[edge.joint] = None
    what = [f"the rigid limbs {', '.join(rigid)} overconstrain one another"] if rigid else []
    what += [
        f"the rigid rings in {limb} ({', '.join(joints)}) are overconstrained in themselves" for limb, joints in rings.items()
    ]
    return (
        f"{' and '.join(what) or 'rigid parts are overconstrained'}: their forces are statically indeterminate; "
        "undetermined forces are NaN"
    )
