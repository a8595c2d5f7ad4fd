"""Platform equilibrium, Eqs. (11), (12), (17): from limbs, loads and gravity to twist and forces, for a whole batch.

Everything here has the batch axis last; :mod:`kinetostatics.result` turns it for people.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinetostatics.configuration import Configuration, Status
from kinetostatics.continuation import CHUNK
from kinetostatics.exceptions import ArgumentError, LimbEquilibriumError, SingularPoseError, StaticsError
from kinetostatics.kinematics import Frames
from kinetostatics.limbs import LimbGroup, LimbStatics
from kinetostatics.linalg import Cholesky, cross, normalize
from kinetostatics.misfits import Misfits, parse_misfits
from kinetostatics.platform_equilibrium import PlatformEquilibrium
from kinetostatics.screws import describe_twist

if TYPE_CHECKING:
    from kinetostatics.result import Result
    from kinetostatics.robot import Robot

Array = NDArray[np.float64]

#: Smallest eigenvalue of the Gram matrix of all unit wrenches (a squared sine) above which the platform counts as held.
HELD = 1e-12
#: Largest part of a limb's weight that may stay unbalanced on its passive joints.
UNBALANCED = 1e-7


@dataclass(frozen=True)
class Solution:
    """Equilibrium of one chunk of poses; wrenches about o, world axes.

    Attributes:
        frames, o, gravity: the poses (3, N), and the field (3, N).
        weights: (6, W, N) the robot's weights.
        statics: the groups of limbs.
        misfits: what joints and beams are off by, and ``errors`` for each group (6, elements, g, N) or None.
        errors: see ``misfits``.
        sources: names of the twist's contributions.
        twists: (6, S, N) contributions to the twist.
        compliance, stiffness: (6, 6, N).
        intensities: for each group W_ic of each contribution (n_c, S, g, N).
        load, platform_weight: (6, N) external load and weight of the platform.
        status: (N,) of the statics alone.
        undetermined: for each group (n_c, g, N) whether an intensity cannot be determined.
        open: for each group (n_c, k, g, N) how intensities may change together without the platform feeling it.
        unbalanced: for each limb or dead weight, how much of its weight its passive joints cannot carry (N,).
    """

    frames: Frames
    o: Array
    gravity: Array
    weights: Array
    statics: tuple[LimbStatics, ...]
    misfits: Misfits | None
    errors: tuple[Array | None, ...]
    sources: tuple[str, ...]
    twists: Array
    compliance: Array
    stiffness: Array
    intensities: tuple[Array, ...]
    load: Array
    platform_weight: Array
    status: NDArray[np.int8]
    undetermined: tuple[NDArray[np.bool_], ...]
    open: tuple[Array, ...]
    unbalanced: Mapping[str, Array]

    def share(self, group: LimbGroup) -> Array:
        """Return (S, g, 1): 1 for the contribution that the own weight of each limb of a group belongs to.

        What hangs on the base alone contributes to nothing: its place is one behind all sources.
        """
        hanging_on_base = group.is_hanging and not group.limbs[0].on_platform
        share = np.zeros((len(self.sources) + hanging_on_base, len(group.limbs), 1))
        for position, number in enumerate(group.numbers):
            place = 2 + number
            if group.is_hanging:
                place = len(self.sources) if hanging_on_base else 1
            share[place, position] = 1
        return share

    def chord_wrenches(self, number: int) -> Array:
        """Return the chord wrenches (M, 6, S, g, N) of each contribution in a group of limbs."""
        statics = self.statics[number]
        share = self.share(statics.group)
        intensities = self.intensities[number]
        if share.shape[0] > intensities.shape[1]:
            intensities = np.concatenate([intensities, np.zeros_like(intensities[:, :1])], axis=1)
        total = np.einsum("mkign,isgn->mksgn", statics.chords, intensities)
        total += share * statics.particular[:, :, None]
        if "misfit" in self.sources:
            total[:, :, self.sources.index("misfit")] += statics.misfit_chords
        return total

    def total_chord_wrenches(self, number: int) -> Array:
        """Return the chord wrenches (M, 6, g, N) of all contributions together in a group of limbs."""
        statics = self.statics[number]
        total = np.einsum("mkign,ign->mkgn", statics.chords, self.intensities[number].sum(axis=1))
        total += statics.particular
        if "misfit" in self.sources:
            total += statics.misfit_chords
        return total


def solve(robot: Robot, frames: Frames, load: Array, gravity: Array, misfits: Misfits | None = None) -> Solution:
    """Solve Eq. (12) for N poses.

    Args:
        robot: the robot.
        frames: of all bodies.
        load: (6, N) external load about o [N, N·m].
        gravity: (3, N) [m/s²].
        misfits: what joints and beams are off by.
    """
    _, o = robot.solver.platform_pose(frames)
    weights = robot.weights.wrenches(frames, o, gravity)
    errors = tuple(None if misfits is None else misfits.of(group, frames, o) for group in robot.limb_groups)
    statics = tuple(
        group.statics(frames, o, weights, gravity, error) for group, error in zip(robot.limb_groups, errors, strict=True)
    )
    platform_weight = weights[:, robot.weights.of("platform")].sum(axis=1)
    sources = ("load", "platform_weight", *(limb.name for limb in robot.topology.limbs))
    if misfits is not None:
        sources += ("misfit",)
    N = o.shape[1]
    right = np.zeros((6, len(sources), N))
    right[:, 0], right[:, 1] = load, platform_weight
    strains = []
    for item in statics:
        strain = np.zeros((item.J_c.shape[1], len(sources), *item.J_c.shape[2:]))
        if not item.group.is_hanging:
            for position, number in enumerate(item.group.numbers):
                right[:, 2 + number] -= item.R_g[:, position]
                strain[:, 2 + number, position] = item.sag[:, position]
        if misfits is not None:
            strain[:, -1] = item.misfit
        strains.append(strain)
    balance = PlatformEquilibrium(robot, statics, N)
    twists, intensities = balance.solve(right, strains)
    status = balance.status
    for item in statics:
        degenerate = np.any(item.degenerate, axis=0)
        status = np.where((status == Status.OK) & degenerate, Status.BASIS_DEGENERATE, status).astype(np.int8)
        loose = np.any(item.loose, axis=(0, 1, 2, 3))
        status = np.where((status == Status.OK) & loose, Status.INDETERMINATE, status).astype(np.int8)
    status = np.where(_hold(statics, balance.scale, N) > HELD, status, Status.SINGULAR).astype(np.int8)
    unbalanced = _unbalanced(robot, frames, o, weights, statics)
    for part in unbalanced.values():
        status = np.where(part > UNBALANCED, Status.SINGULAR, status).astype(np.int8)
    return Solution(
        frames,
        o,
        gravity,
        weights,
        statics,
        misfits,
        errors,
        sources,
        twists,
        balance.compliance,
        balance.stiffness,
        tuple(intensities),
        load,
        platform_weight,
        status,
        tuple(balance.undetermined),
        tuple(balance.open),
        unbalanced,
    )


def unit_chords(robot: Robot, solution: Solution) -> list[Array]:
    """Return for each group the chord wrenches (M, 6, 6, g, N) under unit loads at o, world axes."""
    N = solution.o.shape[1]
    balance = PlatformEquilibrium(robot, solution.statics, N)
    none = [np.zeros((item.J_c.shape[1], 6, *item.J_c.shape[2:])) for item in solution.statics]
    _, intensities = balance.solve(np.broadcast_to(np.eye(6)[:, :, None], (6, 6, N)), none)
    return [np.einsum("mkign,isgn->mksgn", item.chords, W) for item, W in zip(solution.statics, intensities, strict=True)]


def _hold(statics: tuple[LimbStatics, ...], scale: Array, N: int) -> Array:
    """Return how well the limbs' wrenches hold the platform (N,): the smallest eigenvalue of their Gram matrix."""
    gram = np.zeros((6, 6, N))
    for item in statics:
        unit = normalize(item.J_c * scale[:, None, None, None])
        gram += np.einsum("ikgn,jkgn->ijn", unit, unit)
    return Cholesky(gram).smallest_eigenvalue()


def _unbalanced(robot: Robot, frames: Frames, o: Array, weights: Array, statics: Iterable[LimbStatics]) -> dict[str, Array]:
    """Return, by limb and dead weight, the part of its weight that its passive joints cannot carry."""
    result: dict[str, Array] = {}
    for item in statics:
        for position, limb in enumerate(item.group.limbs):
            own = weights[:3, robot.weights.of(limb.name)]
            total = np.sqrt(np.sum(own**2, axis=0)).sum(axis=0)
            left = np.max(np.abs(item.unbalanced[:, position]), axis=0, initial=0.0)
            result[limb.name] = np.maximum(result.get(limb.name, 0.0), left / np.where(total > 0, total, 1.0))
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
    misfits: Mapping[str, Any] | None = None,
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
        misfits: what joints and beams are off by when nothing is loaded, by name; see :mod:`kinetostatics.misfits`. A joint's
            is a twist (…, 6) [m, rad]: by how much its platform side is displaced relative to its base side, at the joint's
            centre, world axes; or ``{"twist": …, "frame": "joint"}``, in the joint's own frame. A beam's is
            ``{"length": …, "temperature": …}``: too long by [m], warmer by [K]. Their effect is the contribution "misfit".
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
    robot = configuration.robot
    errors = None if misfits is None else parse_misfits(robot, misfits)
    arrays = [wrench, field] + ([arm] if arm is not None else []) + ([] if errors is None else errors.arrays())
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
    spread = None if errors is None else errors.map(flat)
    for first in range(0, max(N, 1), CHUNK):  # one chunk even of an empty batch
        part = slice(first, min(first + CHUNK, N))
        mine = part if isinstance(which, slice) else which[part]
        chunk = Frames(frames.rotation[..., mine], frames.position[..., mine])
        at_o = _load_at_o(robot, chunk, loads[:, part], None if arms is None else arms[:, part], frame)
        mine_off = None if spread is None else spread.map(lambda array: array[:, part])  # noqa: B023
        solutions.append(solve(robot, chunk, at_o, fields[:, part], mine_off))
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
        if "misfit" in solution.sources and np.any(np.isnan(solution.twists[:, -1])):
            names = ", ".join(sorted(solution.misfits.names)) if solution.misfits is not None else ""
            raise StaticsError(
                f"the misfits of {names} contradict one another in rigid parts, which cannot give way: give those parts some "
                "elasticity (<beam>, <joint_stiffness>)"
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
    columns = [np.zeros((6, 0)), *(item.J_c[..., pose].reshape(6, -1) for item in solution.statics)]
    wrenches = np.concatenate(columns, axis=1) * scale
    sizes = np.linalg.norm(wrenches, axis=0)
    U, values, _ = np.linalg.svd(wrenches / np.where(sizes > 0, sizes, 1), full_matrices=True)
    values = np.concatenate([values, np.zeros(6 - len(values))])[:6] if len(values) < 6 else values
    free = values <= max(1e-6 * float(values[0]), float(values.min()))
    return np.asarray(U[:, free] * scale)
