"""Assembly of poses from prescribed coordinates: checks, closure of the loops, errors for unreachable poses."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.arguments import check, check_mapping, numbers
from kinetostatics.exceptions import ArgumentError, AssemblyError, CoordinatesError, KinetostaticsError, near_names
from kinetostatics.kinematics.alternatives import choices_text, closed_near, prescribed_platform, start_hint
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.kinematics.coordinates import PrescribedCoordinates
from kinetostatics.kinematics.loop_constraints import Placed, joined
from kinetostatics.kinematics.loop_gaps import CLOSED, close, gaps_at, gaps_text, worst_gaps_text
from kinetostatics.kinematics.path_following import FARTHEST, LONGEST_TURN, MOST_TURNED, follow, is_too_far
from kinetostatics.kinematics.robot_kinematics import RobotKinematics
from kinetostatics.kinematics.solver import Solver, SolverState
from kinetostatics.math.arrays import Array, Mask, chunks
from kinetostatics.math.rotations import Orientation, orientation_named, orientations_with

#: Gap of a loop [m, rad] that always counts as closed.
SURELY_CLOSED = 1e-9

#: Function that returns the solver of the loops for a robot, prescribed coordinates and a number of poses.
SolverChoice: TypeAlias = Callable[[RobotKinematics, PrescribedCoordinates, int], Solver]


def by_numpy(robot: RobotKinematics, prescribed: PrescribedCoordinates, poses: int) -> Solver:
    """Return the robot's solver that uses NumPy, whatever the coordinates and the number of poses."""
    return robot.solver


def assemble(
    robot: RobotKinematics,
    actuators: Mapping[str, ArrayLike] | None,
    platform: Mapping[str, ArrayLike] | None,
    orientation: str | None,
    near: Configuration | Mapping[str, float] | None,
    closure_tolerance: float,
    on_failure: str | None,
    chosen: SolverChoice = by_numpy,
) -> Configuration:
    """See :meth:`Robot.assemble`; ``chosen`` returns the solver of the loops."""
    if actuators is not None and platform is not None:
        raise CoordinatesError("give either actuators= or platform=, not both")
    if on_failure is not None:
        check("on_failure", on_failure)
    closure_tolerance = check("closure_tolerance", closure_tolerance)
    convention = orientation_named(orientation)
    if platform is not None:
        prescribed, names = platform_coordinates(robot, platform, orientation)
        given: Mapping[str, ArrayLike] = platform
    else:
        given = dict.fromkeys(robot.description.actuated, 0.0) if actuators is None else actuators
        prescribed, names = robot.actuator_coordinates, robot.actuator_names
        given = all_actuators(robot, given)
    shape, target = _stack([given[name] for name in names], names)
    raising = on_failure == "raise" or (on_failure is None and shape == ())
    if raising and robot.wrong_zero is not None and not robot.accepts(closure_tolerance):
        raise robot.wrong_zero
    start = robot.zero_poses
    if near is not None:
        start = closed_near(robot, near) if isinstance(near, Mapping) else _start(robot, near, shape)
    prescribed = robot.mobility_analysis.with_dofs(prescribed)
    origin = robot.zero_origin(prescribed) if near is None else None
    solver = chosen(robot, prescribed, target.shape[1])
    poses, arrived, gone = follow(solver, prescribed, start, target, origin)
    if raising and not arrived.all():
        worst = np.array([np.argmin(arrived)])
        raise _unreachable_error(robot, prescribed, names, poses.take(worst), target[:, worst], float(gone[worst[0]]))
    return closed_pose(
        robot,
        poses,
        solver.place(poses.x),
        shape,
        arrived,
        convention,
        closure_tolerance,
        raising,
        solved=(solver, prescribed, target),
        names=() if platform is None else tuple(names),
    )


def configuration_at(robot: RobotKinematics, q: ArrayLike, closure_tolerance: float, on_failure: str | None) -> Configuration:
    """See :meth:`Robot.configuration`."""
    if on_failure is not None:
        check("on_failure", on_failure)
    closure_tolerance = check("closure_tolerance", closure_tolerance)
    array = numbers("q", q)
    if array.ndim == 0 or array.shape[-1] != robot.mechanism.tree.nq:
        raise ArgumentError(f"q has the shape {array.shape}; the last axis must be nq = {robot.mechanism.tree.nq}")
    shape = array.shape[:-1]
    flat = np.array(array.reshape(int(np.prod(shape)), array.shape[-1]).T, order="C")
    poses = SolverState(robot.equations.from_model(flat), np.zeros((3, flat.shape[1])))
    good = np.all(np.isfinite(flat), axis=0)
    raising = on_failure == "raise" or (on_failure is None and shape == ())
    parts = [robot.equations.placed(flat[:, part]) for part in chunks(flat.shape[1]) or [slice(0, 0)]]
    return closed_pose(robot, poses, joined(parts), shape, good, orientation_named(None), closure_tolerance, raising)


def _start(robot: RobotKinematics, near: Configuration, shape: tuple[int, ...]) -> SolverState:
    """Return the pose at which all straight lines to targets start, or one pose for each target."""
    if not isinstance(near, Configuration):
        raise ArgumentError(f"near= needs a Configuration or values of joints, got {near!r}; robot.assemble(…) creates one")
    if near.robot is not robot:
        raise ArgumentError("near= is a configuration of another robot")
    if near.shape not in ((), shape):
        raise ArgumentError(f"near= has the batch shape {near.shape}; it must be () or {shape}")
    return near.poses


def closed_pose(
    robot: RobotKinematics,
    poses: SolverState,
    placed: Placed,
    shape: tuple[int, ...],
    arrived: Mask,
    convention: Orientation,
    closure_tolerance: float,
    raising: bool,
    solved: tuple[Solver, PrescribedCoordinates, Array] | None = None,
    names: tuple[str, ...] = (),
) -> Configuration:
    """Return the configuration of solved poses, in which poses with open loops are marked as not reached.

    Poses whose residuals exceed rounding are corrected once more.

    Args:
        placed: Pinocchio's coordinates, frames and residuals of the solved poses.
        arrived: (N,) True for poses at the target coordinates.
        closure_tolerance: largest gap of a closed loop [m, rad].
        raising: whether to raise an error if a pose is not reached.
        solved: solver, prescribed coordinates and target (n, N) of the poses; None for poses given by ``q``.
        names: names of the prescribed platform coordinates.

    Raises:
        AssemblyError: a pose is not reached, and ``raising`` is set.
    """
    q, frames, residual = placed
    if solved is not None:
        worst = np.abs(residual).max(axis=0, initial=0.0)
        doubtful = arrived & (worst > robot.rough_residual)
        if doubtful.any():
            (solver, prescribed, target), rough = solved, np.flatnonzero(doubtful)
            better, _ = solver.newton(prescribed, poses.take(rough), target[:, rough])
            now = solver.place(better.x)
            poses.x[:, rough], poses.c[:, rough] = better.x, better.c
            q[:, rough], residual[:, rough] = now.q, now.residual
            frames.put(rough, now.frames)
            worst[rough] = np.max(np.abs(now.residual), axis=0, initial=0.0)
    else:
        worst = np.full(q.shape[1], np.inf)
    largest = np.zeros(q.shape[1])
    loop_gaps: dict[str, tuple[Array, Array]] = {}
    if robot.equations.couplings.count or not (2 * worst <= min(closure_tolerance, SURELY_CLOSED)).all():
        loop_gaps = robot.equations.loop_gaps(residual, poses.x)
        largest = np.max([largest, *(size for pair in loop_gaps.values() for size in pair)], axis=0)
    closed = largest <= closure_tolerance
    if closure_tolerance > SURELY_CLOSED and np.isfinite(closure_tolerance):
        wide = largest > SURELY_CLOSED
        if np.any(closed & wide) and not robot.accepts(closure_tolerance):
            closed &= ~wide
    reached = arrived & closed
    if raising and not reached.all():
        first = int(np.argmin(reached))
        gaps = {name: (float(a[first]), float(b[first])) for name, (a, b) in loop_gaps.items()}
        raise _open_error(robot, gaps, closure_tolerance)
    if not reached.all():
        q = np.where(reached, q, np.nan)
    q.setflags(write=False)
    return Configuration(robot, shape, convention, poses, q, frames, residual, reached, names, closure_tolerance)


def all_actuators(robot: RobotKinematics, given: Mapping[str, ArrayLike]) -> dict[str, ArrayLike]:
    """Return the values of all actuators; the default is zero for actuators outside the limbs, such as that of a gripper.

    Raises:
        CoordinatesError: an actuator of a limb is missing, or a name is unknown.
    """
    actuated = robot.description.actuated
    check_mapping("actuators", given, f"{{{actuated[0]!r}: 0.02}}" if actuated else "{}")
    for name in given:
        if name not in actuated:
            raise CoordinatesError(f"no actuated joint {name!r}: {near_names(name, actuated)}", robot.mobility.platform)
    every: dict[str, ArrayLike] = {**dict.fromkeys(robot.actuators_outside_limbs, 0.0), **given}
    missing = [name for name in actuated if name not in every]
    if missing:
        text = f"actuator values are missing for {', '.join(missing)}; the robot has {len(actuated)} actuated joints"
        raise CoordinatesError(text, robot.mobility.platform)
    return every


def platform_coordinates(
    robot: RobotKinematics, platform: Mapping[str, object], orientation: str | None
) -> tuple[PrescribedCoordinates, list[str]]:
    """Return the prescribed coordinates of the platform, and their names in the solver's order.

    Raises:
        CoordinatesError: the coordinates are unknown, too few or too many, or do not determine the pose.
    """
    convention = orientation_named(orientation)
    check_mapping("platform", platform, '{"z": 0.5}')
    pose_names, mobility = convention.pose_names, robot.mobility.platform
    for name in platform:
        if name not in pose_names:
            needed = orientations_with(name)
            hint = f"it needs orientation {needed}" if needed else near_names(name, pose_names)
            raise CoordinatesError(f"no platform coordinate {name!r} with orientation {convention.name!r}: {hint}", mobility)
    if len(platform) != mobility:
        raise CoordinatesError(
            f"{len(platform)} platform coordinates are given ({', '.join(platform) or 'none'}), but the mobility of "
            f"{robot.name!r} is {mobility}: give exactly {mobility} of {', '.join(pose_names)}"
            + (f"; {choices_text(robot, convention, tuple(platform), robot.zero_poses)}" if 0 < mobility < 6 else ""),
            mobility,
        )
    prescribed = prescribed_platform(tuple(platform), convention)
    if not robot.mobility_analysis.fixes_platform(prescribed):
        raise CoordinatesError(
            f"the coordinates {', '.join(platform)} do not determine the pose of {robot.name!r}: with them fixed, the platform "
            f"can still move; its mobility is {mobility}; {choices_text(robot, convention, tuple(platform), robot.zero_poses)}",
            mobility,
        )
    return prescribed, [name for name in pose_names if name in platform]


def _unreachable_error(
    robot: RobotKinematics, prescribed: PrescribedCoordinates, names: list[str], pose: SolverState, target: Array, gone: float
) -> KinetostaticsError:
    mobility = robot.mobility.platform
    hints = robot.unit_hints(dict(zip(names, target, strict=True)))

    def as_text(values: Array) -> str:
        return ", ".join(f"{name} = {value:.6g}" for name, value in zip(names, values, strict=True))

    text = f"{robot.name!r} (mobility {mobility}) cannot reach {as_text(target[:, 0])}: "
    if gone == 0 and is_too_far(robot.solver, prescribed, pose, target)[0]:
        text += f"lines are followed up to {FARTHEST:.0e} times the robot's reach and {LONGEST_TURN * MOST_TURNED:.0f} rad, "
        text += "and the line to this target is longer"
        return AssemblyError("; ".join([text, *hints]), {}, mobility, gone)
    nearest, _ = close(robot.solver, pose, prescribed, target, weight=1e3)
    gaps = gaps_at(robot.equations, nearest)
    text += f"on the straight line from the start the loops close up to {100 * gone:.1f} % of the way; "
    if gone == 0 and not robot.mobility_analysis.fixes_platform_at(prescribed, pose):
        convention = prescribed.orientation
        others = "" if convention is None else f"; {choices_text(robot, convention, names, pose)}"
        advice = start_hint(robot, prescribed, target)
        return CoordinatesError(
            f"{robot.name!r} moves to targets from its zero pose or the pose of near=, and at this start the coordinates "
            f"{', '.join(names)} do not determine the pose: it is a singular pose for them{others}{'; ' * bool(advice)}{advice}",
            mobility,
        )
    reached = robot.solver.values(prescribed, nearest)[:, 0]
    if float(np.abs(reached - target[:, 0]).max(initial=0.0)) < 1e-3:
        worst = max((max(pair) for pair in gaps.values()), default=0.0)
        if worst < CLOSED:
            text += "the target itself can be assembled, but the line to it passes a singular pose or leaves the workspace"
            if gone == 0 and (advice := start_hint(robot, prescribed, target)):
                text += f"; {advice}"
        else:
            text += f"at the target {worst_gaps_text(robot.equations, gaps)}"
    else:
        text += f"the nearest pose found has {as_text(reached)}, and there {worst_gaps_text(robot.equations, gaps)}"
    return AssemblyError("; ".join([text, *hints]), gaps, mobility, gone)


def _open_error(robot: RobotKinematics, loop_gaps: dict[str, tuple[float, float]], closure_tolerance: float) -> AssemblyError:
    worst = max(max(pair) for pair in loop_gaps.values())
    loops = {loop.name for loop in robot.equations.loops}
    is_loop = any(max(pair) > closure_tolerance for name, pair in loop_gaps.items() if name in loops)
    text = f"the loops of {robot.name!r} do not close" if is_loop else f"the coupled joints of {robot.name!r} do not fit together"
    text += f": {worst_gaps_text(robot.equations, loop_gaps, closure_tolerance)}, more than the tolerance {closure_tolerance:g}"
    if robot.wrong_zero is not None:
        text = str(robot.wrong_zero)
    elif robot.mobility.redundant_constraints and worst < 1e-2:
        text += (
            f". The robot is overconstrained (by {robot.mobility.redundant_constraints}), and such loops cannot close when the "
            f"file's angles or lengths are rounded{', which is the likely reason' if robot.zero_is_near else ' or wrong'}: "
            "write them with full precision, as ${pi/2} in xacro, "
        )
        if robot.zero_is_near:
            text += f"or accept the gap with a tolerance of {10 ** np.ceil(np.log10(worst)):.0e}"
        else:
            text += f"and check the frames: where all joints are at zero, {gaps_text(robot.zero_loop_gaps)}"
    return AssemblyError(text, loop_gaps, robot.mobility.platform)


def _stack(values: list[ArrayLike], names: list[str]) -> tuple[tuple[int, ...], Array]:
    """Broadcast coordinates against one another; return the batch shape and the targets (n, N)."""
    if values and all(type(value) in (int, float) for value in values):  # fast path for one pose
        single = np.array(values, dtype=float)[:, None]
        if np.all(np.isfinite(single)):
            return (), single
    arrays = []
    for value, name in zip(values, names, strict=True):
        try:
            arrays.append(numbers(name, value))
        except ArgumentError:
            raise CoordinatesError(f"{name} = {value!r} is not a number or an array of numbers") from None
        if arrays[-1].ndim == 0 and not np.isfinite(arrays[-1]):
            raise CoordinatesError(f"{name} = {value!r} is not finite")
    try:
        shape = np.broadcast_shapes(*(array.shape for array in arrays))
    except ValueError:
        sizes = ", ".join(f"{name} {array.shape}" for name, array in zip(names, arrays, strict=True))
        raise CoordinatesError(f"the coordinates' shapes do not fit together: {sizes}") from None
    rows = [np.broadcast_to(array, shape).ravel() for array in arrays]
    return shape, np.array(rows).reshape(len(rows), int(np.prod(shape)))
