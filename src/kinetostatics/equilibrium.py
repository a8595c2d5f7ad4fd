"""Platform equilibrium, Eqs. (11), (12), (17): from limbs, loads and gravity to twist and forces, for a whole batch.

Everything here has the batch axis last; :mod:`kinetostatics.result` turns it for people.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinetostatics.assembly import CHUNK
from kinetostatics.configuration import Configuration, Status
from kinetostatics.exceptions import ArgumentError, LimbEquilibriumError, SingularPoseError
from kinetostatics.kinematics import Frames
from kinetostatics.limbs import LimbStatics
from kinetostatics.linalg import Cholesky, cross, normalize
from kinetostatics.screws import describe_twist

if TYPE_CHECKING:
    from kinetostatics.result import Result
    from kinetostatics.robot import Robot

Array = NDArray[np.float64]

#: Smallest eigenvalue of the Gram matrix of all unit wrenches (a squared sine) above which the platform counts as held.
HELD = 1e-12
#: The same for the stiffness itself, whose entries differ by orders of magnitude: mere rounding.
SINGULAR = 1e-14
#: Largest part of a limb's weight that may stay unbalanced on its passive joints.
UNBALANCED = 1e-7


@dataclass(frozen=True)
class Solution:
    """Equilibrium of one chunk of poses; wrenches about o, world axes.

    Attributes:
        frames, o, gravity: the poses (3, N), and the field (3, N).
        weights: (6, W, N) the robot's weights.
        statics: the groups of limbs.
        sources: names of the twist's contributions.
        twists: (6, S, N) contributions to the twist.
        compliance, stiffness: (6, 6, N).
        intensities: for each group W_ic of each contribution (n_c, S, g, N).
        load, platform_weight: (6, N) external load and weight of the platform.
        status: (N,) of the statics alone.
        undetermined: for each group (n_c, g, N) whether an intensity cannot be determined.
        unbalanced: for each limb or dead weight, how much of its weight its passive joints cannot carry (N,).
    """

    frames: Frames
    o: Array
    gravity: Array
    weights: Array
    statics: tuple[LimbStatics, ...]
    sources: tuple[str, ...]
    twists: Array
    compliance: Array
    stiffness: Array
    intensities: tuple[Array, ...]
    load: Array
    platform_weight: Array
    status: NDArray[np.int8]
    undetermined: tuple[NDArray[np.bool_], ...]
    unbalanced: Mapping[str, Array]


def solve(robot: Robot, frames: Frames, load: Array, gravity: Array) -> Solution:
    """Solve Eq. (12) for N poses.

    Args:
        robot: the robot.
        frames: of all bodies.
        load: (6, N) external load about o [N, N·m].
        gravity: (3, N) [m/s²].
    """
    _, o = robot.solver.platform_pose(frames)
    weights = robot.weights.wrenches(frames, o, gravity)
    statics = tuple(group.statics(frames, o, weights, gravity) for group in robot.limb_groups)
    platform_weight = weights[:, robot.weights.of("platform")].sum(axis=1)
    limbs = [limb.name for limb in robot.topology.limbs]
    sources = ("load", "platform_weight", *limbs)
    N = o.shape[1]
    right = np.zeros((6, len(sources), N))
    right[:, 0], right[:, 1] = load, platform_weight
    for item in statics:
        right[:, [2 + k for k in item.group.numbers]] -= item.R_g
    applied = np.array(right)
    K = np.zeros((6, 6, N))
    factors: list[Cholesky | None] = []
    for item in statics:
        if item.group.is_rigid or item.J_c.shape[1] == 0:
            factors.append(None)
            continue
        factor = Cholesky(item.C)
        factors.append(factor)
        half = factor.forward(np.swapaxes(item.J_c, 0, 1))
        K += np.einsum("kign,kjgn->ijn", half, half)
        names = [2 + k for k in item.group.numbers]
        right[:, names] += np.einsum("kign,kgn->ign", half, factor.forward(item.sag[:, None])[:, 0])
    scale = np.array([1.0] * 3 + [1 / robot.length] * 3)
    rigid = [item for item in statics if item.group.is_rigid and item.J_c.shape[1]]
    if rigid:
        J_r = np.concatenate([item.J_c.reshape(6, -1, N) for item in rigid], axis=1)
        compliance, twists, multipliers, status, free = _solve_rigid(K, J_r, right, scale)
    else:
        compliance, twists, status = _solve_elastic(K, right, scale)
        multipliers, free = np.zeros((0, len(sources), N)), np.zeros((0, N), dtype=bool)
    intensities, undetermined = [], []
    at = 0
    for item, cholesky in zip(statics, factors, strict=True):
        n, g = item.J_c.shape[1:3]
        unknown = np.zeros((n, g, N), dtype=bool)
        if cholesky is None:
            mine = multipliers[at : at + n * g].reshape(n, g, len(sources), N)
            intensities.append(np.moveaxis(mine, 1, 2))
            unknown = free[at : at + n * g].reshape(n, g, N)
            at += n * g
        else:
            strain = np.einsum("kign,ksn->isgn", item.J_c, twists)
            for position, number in enumerate(item.group.numbers):
                strain[:, 2 + number, position] -= item.sag[:, position]
            intensities.append(cholesky.solve(strain))
        undetermined.append(unknown)
        degenerate = np.any(item.degenerate, axis=0)
        status = np.where((status == Status.OK) & degenerate, Status.BASIS_DEGENERATE, status).astype(np.int8)
    status = np.where(_hold(statics, scale) > HELD, status, Status.SINGULAR).astype(np.int8)
    if not rigid:
        _refine(statics, factors, applied, compliance, twists, intensities)
    unbalanced = _unbalanced(robot, frames, o, weights, statics)
    for part in unbalanced.values():
        status = np.where(part > UNBALANCED, Status.SINGULAR, status).astype(np.int8)
    stiffness = np.full_like(compliance, np.nan) if rigid else K
    return Solution(
        frames,
        o,
        gravity,
        weights,
        statics,
        sources,
        twists,
        compliance,
        stiffness,
        tuple(intensities),
        load,
        platform_weight,
        status,
        tuple(undetermined),
        unbalanced,
    )


def _hold(statics: tuple[LimbStatics, ...], scale: Array) -> Array:
    """Return how well the limbs' wrenches hold the platform (N,): the smallest eigenvalue of their Gram matrix."""
    gram = np.zeros((6, 6, statics[0].J_c.shape[3] if statics else 1))
    for item in statics:
        unit = normalize(item.J_c * scale[:, None, None, None])
        gram += np.einsum("ikgn,jkgn->ijn", unit, unit)
    return Cholesky(gram).smallest_eigenvalue()


def _refine(
    statics: tuple[LimbStatics, ...],
    factors: list[Cholesky | None],
    applied: Array,
    compliance: Array,
    twists: Array,
    intensities: list[Array],
) -> None:
    """Let the platform move, in place, by what rounding has left unbalanced of Eq. (5).

    ``applied`` (6, S, N) is that equation's left side.
    """
    left = applied
    for item, W in zip(statics, intensities, strict=True):
        left = left - np.einsum("kign,isgn->ksn", item.J_c, W)
    step = np.einsum("ijn,jsn->isn", compliance, left)
    twists += step
    for item, W, factor in zip(statics, intensities, factors, strict=True):
        if factor is not None:
            W += factor.solve(np.einsum("kign,ksn->isgn", item.J_c, step))


def _solve_elastic(K: Array, right: Array, scale: Array) -> tuple[Array, Array, NDArray[np.int8]]:
    """Return compliance (6, 6, N), contributions (6, S, N) and status of K Δ = right."""
    S = scale[:, None, None]
    factor = Cholesky(K * S * scale[None, :, None])
    N = K.shape[2]
    unit = np.broadcast_to(np.eye(6)[:, :, None], (6, 6, N))
    solved = factor.solve(np.concatenate([unit, right * S], axis=1))
    compliance = solved[:, :6] * S * scale[None, :, None]
    status = np.where(factor.smallest_pivot > SINGULAR, Status.OK, Status.SINGULAR).astype(np.int8)
    return (compliance + np.swapaxes(compliance, 0, 1)) / 2, solved[:, 6:] * S, status


def _solve_rigid(
    K: Array, J: Array, right: Array, scale: Array
) -> tuple[Array, Array, Array, NDArray[np.int8], NDArray[np.bool_]]:
    """Solve the saddle form [K J; Jᵀ 0]: rigid limbs leave the platform only the motions reciprocal to all their wrenches.

    Returns:
        Compliance, contributions, intensities of the rigid limbs (n, S, N), status, and which intensities (n, N) are
        not determined because the rigid limbs overconstrain one another.
    """
    S, N = right.shape[1:]
    n = J.shape[1]
    compliance, twists = np.zeros((6, 6, N)), np.zeros((6, S, N))
    multipliers, free = np.zeros((n, S, N)), np.zeros((n, N), dtype=bool)
    status = np.zeros(N, dtype=np.int8)
    for p in range(N):
        wrenches = J[:, :, p] * scale[:, None]
        stiffness, force = K[:, :, p] * np.outer(scale, scale), right[:, :, p] * scale[:, None]
        if not np.all(np.isfinite(wrenches)):
            status[p] = Status.SINGULAR
            continue
        U, values, V = np.linalg.svd(wrenches, full_matrices=True)
        rank = int(np.sum(values > 1e-9 * values[0]))
        motions = U[:, rank:]
        reduced = motions.T @ stiffness @ motions
        if rank < 6:
            softest = np.linalg.eigvalsh(reduced)[0] if np.all(np.isfinite(reduced)) else -np.inf
            if not softest > 100 * SINGULAR * float(np.diag(stiffness).max()):
                status[p] = Status.SINGULAR
                continue
            inverse = motions @ np.linalg.solve(reduced, motions.T)
        else:
            inverse = np.zeros((6, 6))
        compliance[:, :, p] = inverse * np.outer(scale, scale)
        moved = inverse @ force
        twists[:, :, p] = moved * scale[:, None]
        rest = force - stiffness @ moved
        multipliers[:, :, p] = V[:rank].T @ ((U[:, :rank].T @ rest) / values[:rank, None])
        free[:, p] = np.linalg.norm(V[rank:], axis=0) > 1e-9
        if np.any(free[:, p]):
            status[p] = Status.INDETERMINATE
    return compliance, twists, multipliers, status, free


def _unbalanced(robot: Robot, frames: Frames, o: Array, weights: Array, statics: Iterable[LimbStatics]) -> dict[str, Array]:
    """Return, by limb and dead weight, the part of its weight that its passive joints cannot carry."""
    result: dict[str, Array] = {}
    for item in statics:
        for position, limb in enumerate(item.group.limbs):
            own = weights[:3, robot.weights.of(limb.name)]
            total = np.sqrt(np.sum(own**2, axis=0)).sum(axis=0)
            left = np.max(np.abs(item.unbalanced[:, position]), axis=0, initial=0.0)
            result[limb.name] = left / np.where(total > 0, total, 1.0)
    for branch in robot.branches:
        carried = np.einsum("w,iwn->in", branch.outboard, weights)
        total = np.sqrt(np.sum((weights[:3] * branch.outboard[:, None]) ** 2, axis=0)).sum(axis=0)
        power = np.abs(np.einsum("ikn,in->kn", branch.twists(frames, o), carried)) / branch.scale[:, None]
        part = np.max(power, axis=0, initial=0.0) / np.where(total > 0, total, 1.0)
        result[branch.owner] = np.maximum(result.get(branch.owner, 0.0), part)
    return result


def analyze(
    configuration: Configuration,
    load: ArrayLike = (0, 0, 0, 0, 0, 0),
    gravity: ArrayLike = (0, 0, -9.81),
    *,
    point: ArrayLike | None = None,
    frame: str = "world",
    on_failure: str | None = None,
) -> Result:
    """Compute sag, stiffness and forces at one pose or a batch of poses.

    Args:
        configuration: the pose or poses.
        load: (…, 6) external wrench on the platform: force [N], moment [N·m].
        gravity: (…, 3) gravity [m/s²] in world axes.
        point: (…, 3) where the force acts [m]; default o. In the axes and from the origin of ``frame``.
        frame: "world": ``load`` is in world axes and ``point`` a point of the world; "platform": both in the platform's axes,
            ``point`` from o.
        on_failure: "raise" or "nan"; default: raise for one pose, NaN and a status for a batch.

    Returns:
        The result; loads, gravity and point are broadcast against the batch of poses.

    Raises:
        ArgumentError: a shape or value makes no sense.
        SingularPoseError: with the drives locked the platform can still move; the message says how.
        LimbEquilibriumError: a limb cannot hold its own weight.
    """
    from kinetostatics.result import Result

    if not isinstance(configuration, Configuration):
        raise ArgumentError(f"analyze wants a pose, not {configuration!r}: make one with robot.assemble(…)")
    if frame not in ("world", "platform"):
        raise ArgumentError(f"frame is {frame!r}; it must be 'world' or 'platform'")
    if on_failure not in (None, "raise", "nan"):
        raise ArgumentError(f"on_failure is {on_failure!r}; it must be 'raise' or 'nan'")
    wrench, field = _vector("load", load, 6), _vector("gravity", gravity, 3)
    arm = None if point is None else _vector("point", point, 3)
    arrays = [wrench, field] + ([arm] if arm is not None else [])
    try:
        shape = np.broadcast_shapes(configuration.shape, *(array.shape[:-1] for array in arrays))
    except ValueError:
        raise ArgumentError(
            f"the batch shapes do not fit together: configuration {configuration.shape}, load {wrench.shape[:-1]}, "
            f"gravity {field.shape[:-1]}"
        ) from None
    N = int(np.prod(shape))
    raising = on_failure == "raise" or (on_failure is None and shape == ())

    def flat(array: Array) -> Array:
        return np.broadcast_to(array, shape + array.shape[-1:]).reshape(N, array.shape[-1]).T

    which: Any = slice(None)
    if shape != configuration.shape:
        numbers = np.arange(int(np.prod(configuration.shape))).reshape(configuration.shape)
        which = np.broadcast_to(numbers, shape).ravel()
    frames = configuration.frames
    loads, fields, arms = flat(wrench), flat(field), None if arm is None else flat(arm)
    solutions = []
    robot = configuration.robot
    for first in range(0, max(N, 1), CHUNK):  # one chunk even of an empty batch
        part = slice(first, min(first + CHUNK, N))
        mine = part if isinstance(which, slice) else which[part]
        chunk = Frames(frames.rotation[..., mine], frames.position[..., mine])
        at_o = _load_at_o(robot, chunk, loads[:, part], None if arms is None else arms[:, part], frame)
        solutions.append(solve(robot, chunk, at_o, fields[:, part]))
    reached = configuration.reached[which]
    result = Result(configuration, shape, which, tuple(solutions), reached)
    if raising:
        _complain(robot, result)
    return result


def _vector(name: str, value: ArrayLike, size: int) -> Array:
    try:
        array = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        raise ArgumentError(f"{name} is not an array of numbers: {value!r}") from None
    if array.ndim == 0 or array.shape[-1] != size:
        raise ArgumentError(f"{name} has the shape {array.shape}; its last axis must have {size} entries")
    if not np.all(np.isfinite(array)):
        raise ArgumentError(f"{name} has entries that are not finite: {value!r}")
    return array


def _load_at_o(robot: Robot, frames: Frames, load: Array, point: Array | None, frame: str) -> Array:
    """Return the external load about o in world axes (6, N)."""
    R, o = robot.solver.platform_pose(frames)
    if frame == "platform":
        load = np.concatenate([np.einsum("ijn,jn->in", R, load[:3]), np.einsum("ijn,jn->in", R, load[3:])])
        if point is not None:
            point = o + np.einsum("ijn,jn->in", R, point)
    if point is None:
        return load
    return np.concatenate([load[:3], load[3:] + cross(point - o, load[:3])])


def _complain(robot: Robot, result: Result) -> None:
    """Raise what is wrong with the first failed pose."""
    for solution in result.solutions:
        for name, part in solution.unbalanced.items():
            for p in np.flatnonzero(part > UNBALANCED):
                joints = [joint for joint in robot.passive_joints(name)]
                what = (
                    f"{name} cannot hold its own weight"
                    if name.startswith("limb")
                    else f"what hangs on the {name} cannot hold itself"
                )
                raise LimbEquilibriumError(
                    f"{what}: its passive joints {', '.join(joints)} would move under gravity "
                    f"({100 * float(part[p]):.3g} % of its weight is not carried)",
                    name,
                    joints,
                )
        for p in np.flatnonzero(solution.status == Status.SINGULAR):
            free = free_twists(robot, solution, int(p))
            words = "; ".join(describe_twist(twist, robot.length) for twist in free.T) or "an unknown motion"
            mobility, drives = robot.mobility.platform, len(robot.description.driven)
            why = (
                f"the robot has only {drives} drives for a mobility of {mobility}"
                if drives < mobility
                else "the pose is singular"
            )
            raise SingularPoseError(
                f"with the drives locked the platform of {robot.name!r} can still move: {words} ({why})", free
            )


def free_twists(robot: Robot, solution: Solution, pose: int) -> Array:
    """Return the twists (6, k) at o that no constraint wrench of any limb resists."""
    scale = np.array([1.0] * 3 + [1 / robot.length] * 3)[:, None]
    columns = [item.J_c[..., pose].reshape(6, -1) for item in solution.statics]
    wrenches = np.concatenate(columns, axis=1) * scale
    sizes = np.linalg.norm(wrenches, axis=0)
    U, values, _ = np.linalg.svd(wrenches / np.where(sizes > 0, sizes, 1), full_matrices=True)
    values = np.concatenate([values, np.zeros(6 - len(values))])[:6] if len(values) < 6 else values
    free = values <= max(1e-6 * float(values[0]), float(values.min()))
    return np.asarray(U[:, free] * scale)
