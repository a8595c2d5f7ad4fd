"""Analysis of poses under loads and gravity, in chunks of poses.

The equilibrium itself is solved in :mod:`kinetostatics.statics.solution`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.arguments import check
from kinetostatics.description.joint_types import JOINT_TYPES
from kinetostatics.description.loads import Motion, Payload
from kinetostatics.elements.link import no_length_text
from kinetostatics.engine.programs import engine_for, pose_code
from kinetostatics.exceptions import ArgumentError, LimbEquilibriumError, SingularPoseError, StaticsError
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.load_case import LoadCase
from kinetostatics.math.arrays import Array, Index, chunks, in_threads
from kinetostatics.math.linalg import canonical_basis
from kinetostatics.math.screws import describe_twist
from kinetostatics.results.pose_arrays import Chunk, CompiledChunk
from kinetostatics.results.result import Result
from kinetostatics.robot import Robot, robot_of
from kinetostatics.statics.link_loads import wrenches_of
from kinetostatics.statics.loaded_poses import LoadedPoses
from kinetostatics.statics.robot_statics import RobotStatics
from kinetostatics.statics.singularity import UNBALANCED, parts_of_batch
from kinetostatics.statics.solution import Solution
from kinetostatics.statics.springs import contribution_names, placed_springs, solve_with_springs


def analyze(
    configuration: Configuration,
    load: ArrayLike = (0, 0, 0, 0, 0, 0),
    gravity: ArrayLike = (0, 0, -9.81),
    *,
    point: ArrayLike | None = None,
    frame: str = "world",
    assembly_errors: Mapping[str, object] | None = None,
    loads: Mapping[str, object] | None = None,
    payload: Payload | None = None,
    motion: Motion | None = None,
    on_failure: str | None = None,
    engine: str = "auto",
) -> Result:
    """Compute sag, stiffness and forces at one pose or a batch of poses.

    Args:
        configuration: the pose or poses.
        load: (…, 6) external wrench on the platform: force [N], moment [N·m].
        gravity: (…, 3) gravity [m/s²] in world axes.
        point: (…, 3) point of application of the force [m], in ``frame``; default o.
        frame: "world": ``load`` and ``point`` in world axes, the point from the world origin; "platform": both in platform axes,
            the point from o.
        assembly_errors: errors of joints and beams in the unloaded robot, by name; see
            :mod:`kinetostatics.statics.assembly_errors`. The error of a joint is a twist (…, 6) [m, rad]: the displacement of its
            platform side relative to its base side, at the joint's centre, in world axes; or ``{"twist": …, "frame": "joint"}``,
            in the axes of the joint frame. A prismatic joint has its centre on the platform side. The error of a
            beam is ``{"length": …, "temperature": …}``: excess length [m], temperature rise [K]. All errors together cause the
            contribution "assembly_errors".
        loads: loads on links, by link name: a wrench (…, 6), force [N] and moment [N·m] in world axes at the link's origin; a
            :class:`LinkLoad`, for another point or for link axes; or a list of these. On an elastic link, the point must be the
            end of a beam. The loads on each link cause the contribution "load on LINK".
        payload: a :class:`Payload` on the platform or on a link; its weight causes the contribution "payload".
        motion: velocities and accelerations of the coordinates, a :class:`Motion`. The inertia of links, beams and payload, with
            Coriolis and centrifugal terms, causes the contribution "inertia".
        on_failure: "raise" or "nan"; default: raise for one pose, NaN and a status for a batch.
        engine: "numpy", "compiled", or "auto". "auto" uses compiled code if it is in memory; for 1,000 poses and more, also code
            on disk; for 10,000 and more, it compiles missing code. Otherwise NumPy computes. Numbers differ by rounding errors
            only; statuses are equal.

    Returns:
        The result; loads, gravity and point are broadcast against the batch of poses.

    Raises:
        ArgumentError: an argument has an invalid value or shape.
        SingularPoseError: with the actuators locked, the platform can still move; the message describes the motion.
        LimbEquilibriumError: a limb cannot hold its own weight.
        StaticsError: a telescopic beam or a spring has no length, or assembly errors of rigid parts contradict one another.
        RobotFileError: with ``motion``, a link has moments of inertia that no body has.

    Examples:
        A tripod carries 500 N on its platform. The contributions of load and weights sum to the twist:

        >>> import kinetostatics as ks
        >>> pose = ks.load_robot("3rps").assemble(platform={"z": 0.5, "rx": 0.0, "ry": 0.0})
        >>> result = ks.analyze(pose, load=[0, 0, -500, 0, 0, 0])
        >>> {name: round(1e9 * float(twist[2]), 1) for name, twist in result.contributions.items()}  # along z [nm]
        {'load': -56.3, 'platform_weight': -21.7, 'limb_1': -17.3, 'limb_2': -17.3, 'limb_3': -17.3}
        >>> bool(np.allclose(sum(result.contributions.values()), result.twist))
        True
        >>> {name: round(float(force), 1) for name, force in result.actuator_forces.items()}  # [N]
        {'prismatic_1': 542.8, 'prismatic_2': 542.8, 'prismatic_3': 542.8}

        A tool of 5 kg hangs 0.2 m below o, and somebody leans on the platform:

        >>> tool = ks.Payload(5.0, center=(0, 0, -0.2))
        >>> result = ks.analyze(pose, loads={"platform": [0, 0, -100, 0, 0, 0]}, payload=tool)
        >>> {name: round(1e9 * float(result.contributions[name][2]), 1) for name in ("load on platform", "payload")}  # [nm]
        {'load on platform': -11.3, 'payload': -5.5}
    """
    case = LoadCase(load, gravity, point, frame, assembly_errors, loads, payload, motion, engine)
    return analyzed(configuration, case, on_failure)


def analyzed(configuration: Configuration, case: LoadCase, on_failure: str | None = None) -> Result:
    """Return :func:`analyze` of a load case."""
    if not isinstance(configuration, Configuration):
        raise ArgumentError(f"analyze needs a Configuration, got {configuration!r}; create one with robot.assemble(…)")
    if on_failure is not None:
        check("on_failure", on_failure)
    robot, loads = robot_of(configuration), case.at(configuration)
    engine = "numpy" if case.assembly_errors is not None else case.engine

    def solved(part: slice) -> Chunk:
        given = loads.take(part)

        def solve(some: slice | Index) -> list[Solution]:
            return _solutions(robot.statics, given.take(some))

        code = pose_code(robot, robot.statics, engine, loads.count, given.applied)
        if code is None:
            return Chunk(robot, solve(slice(None)))
        stability = partial(pose_code, robot, robot.statics, engine, loads.count, given.applied, stability=True)
        inputs = [configuration.poses.x[:, loads.poses(part)], given.load, given.gravity, *wrenches_of(given.applied)]
        return CompiledChunk(robot, contribution_names(robot.statics, given.applied), code, stability, inputs, solve)

    parts = chunks(loads.count) or [slice(0, 0)]  # one chunk even of an empty batch
    found = tuple(in_threads(solved, parts, engine_for(engine, loads.count) == "compiled"))
    result = Result(configuration, loads.shape, loads.which, found, configuration.reached[loads.which], case.payload, case.loads)
    if on_failure == "raise" or (on_failure is None and loads.shape == ()):
        for chunk in found:
            if case.assembly_errors is not None or np.any(chunk["singular"]):
                for solution in chunk.solutions:
                    _complain(robot, solution)
    return result


def _solutions(robot: RobotStatics, given: LoadedPoses) -> list[Solution]:
    """Return the equilibria in the order of the poses; a pose where a limb has an unusual rank is solved separately."""
    first = solve_with_springs(robot, given)
    parts = parts_of_batch(robot, given.frames, first.o, first.statics, first.doubtful)
    if len(parts) == 1 and parts[0][1] is None:
        return [first]
    return [solve_with_springs(robot, replace(given.take(at), groups=groups)) for at, groups in parts]


def _complain(robot: Robot, solution: Solution) -> None:
    """Raise an error if a pose has no results, or if assembly errors contradict one another."""
    for p in np.flatnonzero(solution.singular):
        if short := no_length_text(robot.elastic_links.values(), solution.frames, int(p)):
            raise StaticsError(short)
        for spring in placed_springs(robot.statics, solution.frames.take(slice(p, p + 1))):
            if not np.all(np.isfinite(spring.force)):
                raise StaticsError(f"the spring {spring.name!r} has no length at this pose: its force has no direction")
    for name, part in solution.unbalanced.items():
        for p in np.flatnonzero(part > UNBALANCED):
            joints = robot.statics.passive_joints(name)
            what = name if name.startswith("limb") else f"the branch on the {name}"
            loads, cause, whole = "", "gravity", "its weight"
            if solution.applied:
                loads, cause, whole = " and the loads on its links", "gravity or load", "these"
            raise LimbEquilibriumError(
                f"{what} cannot hold its own weight{loads}: its passive joints {', '.join(joints)} would move under {cause} "
                f"({100 * float(part[p]):.3g} % of {whole} is not carried)",
                name,
                joints,
            )
    errors = solution.assembly_errors
    if errors is not None and np.any(np.any(np.isnan(solution.twists[:, -1]), axis=0) & ~solution.singular):
        names = ", ".join(sorted(errors.names))
        raise StaticsError(
            f"the assembly errors of {names} contradict one another in rigid parts, which cannot deform: give those parts some "
            "elasticity (<beam>, <joint_stiffness>)"
        )
    for p in np.flatnonzero(solution.singular):
        free = free_twists(robot, solution, int(p))
        words = "; ".join(describe_twist(twist, robot.length) for twist in free.T) or "an unknown motion"
        mobility, actuators = robot.mobility.platform, len(robot.description.actuated)
        if not actuators:
            joint = next((item.name for item in robot.description.joints.values() if JOINT_TYPES[item.type].is_single), "…")
            what_to_write = f'<transmission name="drive_1"><joint name="{joint}"/></transmission>'
            raise SingularPoseError(
                f"{robot.name!r} has no actuators, so that its platform can move: {words}; name the actuated joints, {mobility} "
                f"for a mobility of {mobility}: {what_to_write}",
                free,
            )
        few = f"the robot has only {actuators} actuators for a mobility of {mobility}"
        why = few if actuators < mobility else "the pose is singular"
        raise SingularPoseError(f"with the actuators locked the platform of {robot.name!r} can still move: {words} ({why})", free)


def free_twists(robot: Robot, solution: Solution, pose: int) -> Array:
    """(6, k) twists of the platform at o that no constraint wrench resists, world axes [m, rad]; or the least resisted one."""
    scale = np.array([1.0] * 3 + [1 / robot.length] * 3)[:, None]
    columns = [np.zeros((6, 0)), *(item.J_c[..., pose].reshape(6, -1) for item in solution.statics)]
    wrenches = np.concatenate(columns, axis=1) * scale
    U, values, _ = np.linalg.svd(wrenches, full_matrices=True)
    resisted = int(np.sum(values > 1e-6 * values.max(initial=0.0)))
    return canonical_basis(U[:, min(resisted, 5) :]) * scale
