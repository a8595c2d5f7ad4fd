"""Alternatives to a failed assembly: other platform coordinates, and other starts if the zero pose is singular.

A *set* of platform coordinates determines the pose of the platform, such as ("z", "rx", "ry").
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from itertools import combinations

import numpy as np

from kinetostatics.arguments import numbers
from kinetostatics.exceptions import AssemblyError, CoordinatesError, near_names
from kinetostatics.kinematics.coordinates import PrescribedCoordinates
from kinetostatics.kinematics.loop_gaps import CLOSED, close, gaps_at, worst_gaps_text
from kinetostatics.kinematics.path_following import follow
from kinetostatics.kinematics.robot_kinematics import RobotKinematics
from kinetostatics.kinematics.solver import SolverState
from kinetostatics.math.arrays import Array
from kinetostatics.math.rotations import Orientation, orientation_named

#: Order of preference of coordinates.
PREFERRED = ("z", "x", "y", "rz", "rx", "ry", "azimuth", "tilt", "torsion")
#: Largest number of sets of coordinates in a message.
NAMED = 3
#: Factor by which the measure of a set must exceed that of the best set before.
MARGIN = 1.5
#: Angles of passive hinges that are tried as other starts [rad].
_BENT = (1.0, -1.0, 0.5, -0.5)


@lru_cache(maxsize=256)
def prescribed_platform(names: tuple[str, ...], orientation: Orientation) -> PrescribedCoordinates:
    positions = tuple(k for k, name in enumerate("xyz") if name in names)
    angles = tuple(k for k, name in enumerate(orientation.names) if name in names)
    return PrescribedCoordinates(positions=positions, angles=angles, orientation=orientation)


def choices(robot: RobotKinematics, orientation: Orientation, given: Sequence[str], pose: SolverState) -> list[tuple[str, ...]]:
    """Return all sets of coordinates that determine the platform's pose at generic poses.

    Sets that fail at ``pose`` are left out, unless all fail there. Sets with the fewest coordinates that are not ``given`` come
    first; the order is otherwise z, x, y, rz, rx, ry.
    """
    candidates = [name for name in PREFERRED if name in orientation.pose_names]
    sets = [
        names
        for names in combinations(candidates, robot.mobility.platform)
        if robot.mobility_analysis.fixes_platform(prescribed_platform(names, orientation))
    ]
    here = [names for names in sets if robot.mobility_analysis.fixes_platform_at(prescribed_platform(names, orientation), pose)]
    return sorted(here or sets, key=lambda names: sum(name not in given for name in names))


def measured_choices(robot: RobotKinematics, orientation: Orientation, pose: SolverState) -> dict[tuple[str, ...], float]:
    """Return the measure of each set of :func:`choices` at one pose.

    The measure is the smallest singular value (at most 1) of the map from the platform's motions to the rates of the coordinates,
    with lengths relative to the characteristic length.
    """
    R, _ = robot.mechanism.platform_pose(robot.equations.forward(pose.x))
    rates = orientation.rates(orientation.coordinates(R))[:, :, 0]
    motions = robot.mobility_analysis.platform_motions(pose)
    rows = np.concatenate([motions[:3], np.linalg.pinv(rates) @ motions[3:]])
    measures = {}
    for names in choices(robot, orientation, (), pose):
        values = np.linalg.svd(rows[[orientation.pose_names.index(name) for name in names]], compute_uv=False)
        measures[names] = float(values.min(initial=1.0))
    return measures


def best_choice(robot: RobotKinematics, orientation: Orientation, pose: SolverState) -> tuple[str, ...]:
    """Return the set of coordinates with the largest measure at one pose; of nearly equal measures, the first set.

    The result is empty if no coordinates determine the pose.
    """
    best: tuple[str, ...] = ()
    most = 0.0
    for names, measure in measured_choices(robot, orientation, pose).items():
        if measure > MARGIN * most:
            best, most = names, measure
    return best


def choices_text(robot: RobotKinematics, orientation: Orientation, given: Sequence[str], pose: SolverState) -> str:
    options = [", ".join(names) for names in choices(robot, orientation, given, pose)]
    if not options:
        return f"no coordinates with the orientation {orientation.name!r} do"
    verb = "does" if robot.mobility.platform == 1 else "do"
    return f"{' or '.join(options[:NAMED])} {verb}{', for example' * (len(options) > NAMED)}"


def closed_near(robot: RobotKinematics, values: Mapping[str, float]) -> SolverState:
    """Return a closed pose near given values of some joints [m, rad] and zero of the others.

    Raises:
        CoordinatesError: a name is not the name of a joint with one freedom, or a value is not a finite number.
        AssemblyError: no pose near these values closes the loops.
    """
    joints, q = robot.joint_coordinates.in_tree, robot.mechanism.tree.neutral[:, None].copy()
    for name, value in values.items():
        if name not in joints:
            raise CoordinatesError(f"near: no joint {name!r} of one freedom: {near_names(name, joints)}", robot.mobility.platform)
        number = numbers(f"near: {name}", value)
        if number.ndim or not np.isfinite(number):
            raise CoordinatesError(f"near: {name} = {value!r} is not a finite number")
        joints[name].write(float(number), q)
    start = SolverState(robot.equations.from_model(q), np.zeros((3, 1)))
    pose, left = close(robot.solver, start, PrescribedCoordinates(), np.zeros((0, 1)))
    if left[0] >= CLOSED:
        gaps = gaps_at(robot.equations, pose)
        given = ", ".join(f"{name} = {value:.6g}" for name, value in values.items())
        raise AssemblyError(f"no pose near {given} closes the loops: {worst_gaps_text(robot.equations, gaps)}", gaps)
    return pose


def start_hint(robot: RobotKinematics, prescribed: PrescribedCoordinates, target: Array) -> str:
    """Return, as text, joint values for ``near=`` from which a straight line to the target (n, 1) can be followed.

    For a target of actuators, a line to platform coordinates zero is tried, too; the text then names these coordinates. The
    text is empty if no line can be followed.
    """
    for values, pose in _starts(robot):
        near = " ".join(f"{name}={value:g}" for name, value in values.items())
        python = f"in Python near={values}"
        if _arrives(robot, prescribed, pose, target):
            return f"it is reached with --near {near} ({python})"
        if prescribed.orientation is None:
            convention = orientation_named(None)
            names = best_choice(robot, convention, pose)
            platform = robot.mobility_analysis.with_dofs(prescribed_platform(names, convention))
            if names and _arrives(robot, platform, pose, np.zeros((len(names), 1))):
                named = " ".join(f"{name}=0" for name in convention.pose_names if name in names)
                return f"another pose is reached with --platform {named} --near {near} ({python})"
    return ""


def _starts(robot: RobotKinematics) -> Iterator[tuple[dict[str, float], SolverState]]:
    """Yield joint values (one angle for all passive hinges) and a closed pose near these values.

    A hinge whose child link is the platform is left out.
    """
    description = robot.description
    bent = [
        name
        for name, joint in robot.joint_coordinates.in_tree.items()
        if joint.type.is_hinge
        and name not in description.actuated
        and description.joints[name].mimic is None
        and joint.body != robot.mechanism.platform_frame[0]
    ]
    for angle in _BENT if bent else ():
        values = dict.fromkeys(bent, angle)
        try:
            yield values, closed_near(robot, values)
        except AssemblyError:
            continue


def _arrives(robot: RobotKinematics, prescribed: PrescribedCoordinates, start: SolverState, target: Array) -> bool:
    """Whether the line from ``start`` can be followed to the target, and the actuators determine the platform's pose there."""
    analysis = robot.mobility_analysis
    poses, arrived, _ = follow(robot.solver, prescribed, start, target)
    return bool(arrived[0]) and analysis.fixes_platform_at(analysis.with_dofs(robot.actuator_coordinates), poses)
