"""Compensation of gravity and loads: actuator positions at which the loaded platform is at its target.

Broyden's method finds the coordinates u to be commanded to the unloaded robot. The pose of the loaded platform is the pose at u,
displaced by the twist of :func:`kinetostatics.analyze`; the coordinates of this pose must reach their targets. The first step
subtracts the sag at the target pose. The sag at the new pose differs slightly; Broyden's update corrects the Jacobian, initially
the identity, by these differences (C. G. Broyden, A class of methods for solving nonlinear simultaneous equations, Mathematics of
Computation 19, 1965). For a tool's tip, the initial Jacobian is the derivative of the tip's coordinates by u. The steps of the
search can be recorded, for exported C.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Unpack

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.analysis import analyzed
from kinetostatics.arguments import check, names_in
from kinetostatics.exceptions import ArgumentError, AssemblyError, CoordinatesError, StaticsError
from kinetostatics.kinematics.alternatives import best_choice
from kinetostatics.kinematics.assembly import assemble, platform_coordinates
from kinetostatics.kinematics.configuration import Configuration, spread
from kinetostatics.kinematics.robot_kinematics import RobotKinematics
from kinetostatics.layout.numbers import join_words
from kinetostatics.load_case import FurtherLoads, LoadCase, load_case_of
from kinetostatics.math.arrays import Array, Mask, frozen, zeros_for
from kinetostatics.math.linalg import apply, dot
from kinetostatics.math.rotations import Orientation, orientation_named
from kinetostatics.results.compensation import Compensation, loaded_frame, target_frame
from kinetostatics.results.pose_arrays import tool_on_robot
from kinetostatics.results.result import Result
from kinetostatics.robot import Robot, robot_of

#: Largest error that counts as corrected [m; angles times the characteristic length], for robots up to 1 m (see
#: :func:`error_tolerance`), and the error at which the search ends.
CORRECTED, EXACT = 1e-12, 1e-15
#: Error that counts as corrected if actuator coordinates are prescribed instead of platform coordinates.
BY_ACTUATORS = 1e-9
#: Largest number of corrections, and of successive corrections that do not halve the error.
MOST, STALE = 40, 4
#: Difference step for the tip's Jacobian, relative to the characteristic length, and smallest ratio of its singular values for
#: which the coordinates move the tip.
STEP, SINGULAR = 1e-5, 1e-6
#: Smallest cosine of the tilt for which azimuth and tilt are replaced by two rotations, which are not singular at tilt 0.
UPRIGHT = 0.1


def compensate(
    configuration: Configuration,
    load: ArrayLike = (0, 0, 0, 0, 0, 0),
    gravity: ArrayLike = (0, 0, -9.81),
    *,
    controlled: Sequence[str] | None = None,
    orientation: str | None = None,
    on_failure: str | None = None,
    closure_tolerance: float | None = None,
    tool: ArrayLike | None = None,
    **analysis: Unpack[FurtherLoads],
) -> Compensation:
    """Find actuator positions at which the loaded platform is at its target pose, and the actuator forces there.

    With mobility n, n coordinates of the platform reach their targets. The error of the other coordinates, which no actuator can
    correct, is :attr:`Compensation.residual_error`.

    Args:
        configuration: the target of the loaded platform: a pose or a batch of poses.
        load: (…, 6) external wrench on the platform [N, N·m], see :func:`kinetostatics.analyze`.
        gravity: (…, 3) gravity, world axes [m/s²].
        controlled: names of the platform's coordinates that are to reach their targets, as many as the mobility, such as
            ``("z", "rx", "ry")``; default: the coordinates from which the pose was assembled, else the best conditioned set at
            the first pose.
        orientation: convention of orientation coordinates in ``controlled``, see :meth:`Robot.assemble`; default: as in the pose.
        on_failure: "raise" or "nan"; default: raise for one pose, NaN and a status for a batch.
        closure_tolerance: largest gap of a closed loop [m, rad], see :meth:`Robot.assemble`; default: as in the pose.
        tool: (3,) a point of the platform, from o in its axes [m], such as a tool's tip. The controlled x, y and z, and their
            errors, are the coordinates of this point instead of o. With three freedoms, ``controlled=("x", "y", "z")`` corrects
            the position of the tip, but not the angles; with six, a tool has no effect. ``load`` acts at ``point``.
        analysis: further arguments of :func:`kinetostatics.analyze`: ``point``, ``frame``, ``assembly_errors``, ``engine``, ….

    Returns:
        Actuator positions, forces, residual errors, and a status for each pose. If an actuator exceeds its limit, the status is
        LIMIT_EXCEEDED and the correction is not clipped. If actuators that move in a straight line from the target to the
        corrected positions pass a singular pose into another assembly mode, the status is UNREACHABLE.

    Raises:
        ArgumentError: an argument has an invalid value or shape.
        CoordinatesError: the coordinates are unknown, or do not determine the pose; or the actuators cannot set the coordinates
            of the tool's tip.
        AssemblyError: the unloaded robot cannot reach the pose to be commanded.
        StaticsError: no actuator positions were found, or the analysis fails at the target pose.

    Examples:
        A tripod that carries 500 N is commanded slightly higher, so that it reaches its target under load:

        >>> import kinetostatics as ks
        >>> pose = ks.load_robot("3rps").assemble(platform={"z": 0.5, "rx": 0.05, "ry": 0.0})
        >>> c = ks.compensate(pose, load=[0, 0, -500, 0, 0, 0])
        >>> c.controlled
        ('z', 'rx', 'ry')
        >>> {name: round(1e9 * float(shift)) for name, shift in c.corrections.items()}  # [nm]
        {'prismatic_1': 125, 'prismatic_2': 141, 'prismatic_3': 117}
        >>> bool(abs(c.residual_error[2]) < 1e-12)
        True
    """
    case = load_case_of(compensate, FurtherLoads, analysis, load=load, gravity=gravity)
    return compensated(configuration, case, controlled, orientation, on_failure, closure_tolerance, tool)


def compensated(
    configuration: Configuration,
    case: LoadCase,
    controlled: Sequence[str] | None,
    orientation: str | None,
    on_failure: str | None,
    closure_tolerance: float | None,
    tool: ArrayLike | None = None,
) -> Compensation:
    """Return :func:`compensate` under a load case."""
    if not isinstance(configuration, Configuration):
        raise ArgumentError(f"compensate needs a Configuration, got {configuration!r}; create one with robot.assemble(…)")
    if on_failure is not None:
        check("on_failure", on_failure)
    robot = robot_of(configuration)
    if not robot.description.actuated:
        raise ArgumentError(f"{robot.name!r} has no actuators, so that nothing can be corrected")

    uncorrected = analyzed(configuration, case, on_failure)
    convention = configuration.orientation if orientation is None else orientation_named(orientation)
    place = tool_on_robot(tool, robot)
    names = _controlled(robot, configuration, convention, controlled, place)
    shape = uncorrected.shape
    target = replace(spread(configuration, shape), orientation=convention)
    if shape != configuration.shape:
        uncorrected = analyzed(target, case, "nan")
    commanded = names if place is None else _controlled(robot, configuration, convention, None, None)
    of_o, of_tool = (ScaledCoordinates(*_well_conditioned(target, given), robot.length) for given in (commanded, names))
    closure_tolerance = configuration.closure_tolerance if closure_tolerance is None else closure_tolerance
    problem = _Problem(robot, target, of_o, of_tool, place, case, closure_tolerance)
    raising = on_failure == "raise" or (on_failure is None and shape == ())
    return Compensation(target, names, uncorrected, problem.result(uncorrected, raising), place)


def _controlled(
    robot: Robot, configuration: Configuration, convention: Orientation, given: Sequence[str] | None, tool: Array | None
) -> tuple[str, ...]:
    if given is not None:
        names = names_in("controlled", given, '("z", "rx", "ry")')
        try:
            platform_coordinates(robot, dict.fromkeys(names), convention.name)  # raises an error
        except CoordinatesError:
            if tool is None or len(names) != robot.mobility.platform or not set(names) <= set(convention.pose_names):
                raise  # otherwise the coordinates may determine the tip of a tool
        return names
    if configuration.prescribed and set(configuration.prescribed) <= set(convention.pose_names):
        return configuration.prescribed
    reached = np.flatnonzero(configuration.reached)
    pose = configuration.poses.take(reached[:1]) if reached.size else robot.zero_poses
    choice = best_choice(robot, convention, pose)
    if not choice:
        raise ArgumentError(
            f"no coordinates with the orientation {convention.name!r} determine the pose of {robot.name!r}; choose another one"
        )
    return tuple(sorted(choice, key=convention.pose_names.index))


def _well_conditioned(target: Configuration, names: tuple[str, ...]) -> tuple[tuple[str, ...], Orientation]:
    """Return coordinates and their convention.

    Near tilt 0, where azimuth and tilt are singular, the rotations rx, ry and rz replace azimuth, tilt and torsion.
    """
    if {"azimuth", "tilt"} <= set(names) and np.all(np.cos(target.platform["tilt"]) > UPRIGHT):
        others = {"azimuth": "rx", "tilt": "ry", "torsion": "rz"}
        return tuple(others.get(name, name) for name in names), orientation_named("XYZ")
    return names, target.orientation


class _Problem:
    """The equations: coordinates of the loaded platform minus their targets, as functions of the commanded coordinates u."""

    def __init__(
        self,
        robot: Robot,
        target: Configuration,
        commanded: ScaledCoordinates,
        controlled: ScaledCoordinates,
        tool: Array | None,
        case: LoadCase,
        closure_tolerance: float,
    ) -> None:
        self.robot, self.target, self.commanded, self.controlled, self.tool = robot, target, commanded, controlled, tool
        self.case, self.closure_tolerance, self._loops = case, closure_tolerance, case.loops
        frame = target_frame(target, tool)
        self._target, self._angles = controlled.of(frame), controlled.orientation.coordinates(frame[0])

    def result(self, uncorrected: Result, raising: bool) -> Result:
        """Return the analysis at the corrected actuators; poses without a correction are marked as not reached.

        Raises:
            AssemblyError, StaticsError: no correction was found, if ``raising``.
        """
        pose, result = self.target, uncorrected
        u, least = self.commanded.of(target_frame(self.target, None)), error_tolerance(self.robot.length)
        search = BroydenSearch.started(u, self._first_inverse(u), self._error(result))
        for _ in range(MOST):
            if not np.any(search.going):
                break
            pose = self._commanded(search.u, pose)
            result = self._analyzed(pose)
            search = search.updated(self._error(result), least)
        reached = pose.reached & self.target.reached & (search.size <= least)
        reached &= self._is_reached_by_actuators(pose, reached)
        if raising and not np.all(reached):
            self._complain(search.u, pose, bool(np.all(search.size <= least)))
        if np.all(reached == pose.reached):
            return result
        q = np.where(reached, pose.model_q, np.nan)
        return self._analyzed(replace(pose, reached=reached, model_q=frozen(q)))

    def _first_inverse(self, u: Array) -> Array:
        """Return the inverse Jacobians (n, n, N) of the controlled coordinates of the unloaded robot at ``u`` (n, N).

        Raises:
            CoordinatesError: the Jacobians are singular at all poses.
        """
        n, N = u.shape
        if self.tool is None:
            return np.broadcast_to(np.eye(n)[:, :, None], (n, n, N))
        step, columns = STEP * self.robot.length, []
        for k in range(n):
            by = step * np.eye(n)[:, k : k + 1]
            ends = (target_frame(self._commanded(u + sign * by, self.target), self.tool) for sign in (1, -1))
            sides = [(self.controlled.of(end, self._angles) - self._target) / step for end in ends]
            ahead, behind = sides[0], -sides[1]
            both = np.where(np.isnan(behind), ahead, np.where(np.isnan(ahead), behind, (ahead + behind) / 2))
            columns.append(both)  # one-sided if the other side is out of reach
        jacobian = np.moveaxis(np.stack(columns, axis=1), 2, 0)
        finite = np.all(np.isfinite(jacobian), axis=(1, 2))
        sizes = np.linalg.svd(jacobian[finite], compute_uv=False)
        regular = sizes[:, -1] > SINGULAR * sizes[:, 0]
        if finite.any() and not np.any(regular):
            raise CoordinatesError(
                f"the actuators of {self.robot.name!r} cannot set {join_words(self.controlled.names)} of the tool's tip "
                f"independently; choose other coordinates, such as {join_words(self.commanded.names)}",
                self.robot.mobility.platform,
            )
        inverse: Array = np.full((N, n, n), np.nan)
        inverse[np.flatnonzero(finite)[regular]] = np.linalg.inv(jacobian[finite][regular])
        return np.moveaxis(inverse, 0, 2)

    def _is_reached_by_actuators(self, pose: Configuration, which: Mask) -> Mask:
        """Return a mask (N,): True where actuators that move linearly from the target pose lead to ``pose``.

        On the way they must not pass a singular pose, beyond which there are other assembly modes at the same actuator
        coordinates. Only poses of the mask ``which`` are examined.
        """
        if not np.any(which):
            return which
        names, poses = pose.actuators, which.reshape(self.target.shape)
        given = {name: np.where(poses, value, self.target.actuators[name]) for name, value in names.items()}
        actuated = assemble(self.robot, given, None, None, self.target, self.closure_tolerance, "nan", self._loops)
        off = np.max(np.abs(self._error(self._analyzed(actuated))), axis=0, initial=0.0)
        return actuated.reached & (off <= arrival_tolerance(self.robot))

    def _analyzed(self, pose: Configuration) -> Result:
        return analyzed(pose, self.case, "nan")

    def _commanded(self, u: Array, near: Configuration, on_failure: str = "nan") -> Configuration:
        """Return the poses at scaled coordinates u (n, N) of the unloaded platform."""
        of = self.commanded
        given = dict(zip(of.names, (u / of.scale).reshape(len(of.names), *self.target.shape), strict=True))
        poses = assemble(self.robot, None, given, of.orientation.name, near, self.closure_tolerance, on_failure, self._loops)
        return replace(poses, orientation=self.target.orientation, prescribed=self.target.prescribed)

    def _complain(self, u: Array, pose: Configuration, corrected: bool) -> None:
        names = ", ".join(self.controlled.names)
        try:
            self._commanded(u, self.target, "raise")
        except AssemblyError as error:
            raise AssemblyError(
                f"no actuator positions were found that bring the loaded platform of {self.robot.name!r} to its target in "
                f"{names}; the unloaded robot cannot reach the corrected pose: {error}",
                error.residuals,
                error.mobility,
                error.reached,
            ) from error
        analyzed(pose, self.case, "raise")
        raise StaticsError(
            f"no actuator positions were found that bring the loaded platform of {self.robot.name!r} to its target in "
            f"{names}: "
            + (
                "the positions found lead, from the target pose, into another assembly mode, beyond a singular pose"
                if corrected
                else "the sag changes too much from pose to pose, as beside a singular pose"
            )
        )

    def _error(self, result: Result) -> Array:
        """Return the scaled errors (n, N) in the coordinates of the loaded platform."""
        return self.controlled.of(loaded_frame(result, self.tool), self._angles) - self._target


# ---- Broyden's method ------------------------------------------------------------------------------------------------


def error_tolerance(length: float) -> float:
    """Return the largest error [m] at which a pose counts as corrected, for a characteristic length [m]."""
    return CORRECTED * max(1.0, length)


def arrival_tolerance(robot: RobotKinematics) -> float:
    """Return the position error [m] allowed in a pose assembled from actuator coordinates, whose loops are nearly closed."""
    return BY_ACTUATORS * max(1.0, robot.length) + 10 * robot.length * robot.closing_error


class ScaledCoordinates:
    """Coordinates of the platform, scaled to lengths.

    Attributes:
        orientation: convention of the angles.
        scale: (n, 1) factors that convert the coordinates to lengths [m].
    """

    def __init__(self, names: Sequence[str], orientation: Orientation, length: float) -> None:
        """Select coordinates of a convention by name; ``length`` is the robot's characteristic length [m]."""
        self.names, self.orientation = tuple(names), orientation
        pose_names = orientation.pose_names
        self._rows = [pose_names.index(name) for name in names]
        self.scale = np.array([1.0 if name in "xyz" else length for name in names])[:, None]

    def of(self, frame: tuple[Array, Array], near: Array | None = None) -> Array:
        """Return the scaled coordinates (n, N) [m] of a frame: rotation (3, 3, N) and position (3, N).

        Of angles that differ by full turns, the angles nearest to ``near`` (3, N) are returned.
        """
        both = np.concatenate([frame[1], self.orientation.coordinates(frame[0], near=near)])
        scaled: Array = both[self._rows] * self.scale
        return scaled


@dataclass(frozen=True)
class BroydenSearch:
    """State of Broyden's method at N poses.

    Attributes:
        u: (n, N) scaled commanded coordinates.
        step: (n, N) last change of u.
        inverse: (n, n, N) approximate inverse Jacobian.
        error: (n, N) error of the loaded platform before this change.
        size: (N,) magnitude of the error.
        stale: (N,) number of successive steps that did not halve the error.
        going: (N,) True where the search continues.
    """

    u: Array
    step: Array
    inverse: Array
    error: Array
    size: Array
    stale: Array
    going: Mask

    @classmethod
    def started(cls, u: Array, inverse: Array, error: Array) -> BroydenSearch:
        """Return the search after its first step from ``u`` (n, N), with inverse Jacobian (n, n, N) and error (n, N) at ``u``."""
        size = _size(error)
        still, never = zeros_for(u.shape, u), zeros_for(size.shape, size)
        return cls(u, still, inverse, error, size, never, np.isfinite(size) & (size > EXACT)).moved()

    def moved(self) -> BroydenSearch:
        """Return the search after the next step; poses at which it has ended keep their u."""
        step = np.where(self.going, -apply(self.inverse, self.error), 0.0)
        return replace(self, u=self.u + step, step=step)

    def updated(self, error: Array, tolerance: float) -> BroydenSearch:
        """Return the search after the next step, which follows from the error (n, N) at the present ``u``."""
        inverse = _broyden_update(self.inverse, self.step, error - self.error, self.going)
        smaller = _size(error) < self.size / 2
        stale = np.where(smaller, 0.0, self.stale + 1.0)
        size = np.where(self.going, _size(error), self.size)
        going = self.going & np.isfinite(size) & (size > EXACT) & ~((size <= tolerance) & ~smaller) & (stale < STALE)
        return BroydenSearch(self.u, self.step, inverse, error, size, stale, going).moved()


def _broyden_update(inverse: Array, step: Array, change: Array, going: Mask) -> Array:
    """Return inverse Jacobians (n, n, N) by Broyden's update, from steps (n, N) and the changes of the error that they caused."""
    moved = apply(inverse, change)
    along = dot(step, moved)
    usable = going & np.isfinite(along) & (np.abs(along) > 0.1 * dot(step, step))
    direction = np.einsum("in,ijn->jn", step, inverse) / np.where(usable, along, 1.0)
    update = np.einsum("in,jn->ijn", step - moved, direction)
    updated: Array = inverse + np.where(usable, update, 0.0)
    return updated


def _size(error: Array) -> Array:
    largest: Array = np.max(np.abs(error), axis=0, initial=0.0)
    return largest
