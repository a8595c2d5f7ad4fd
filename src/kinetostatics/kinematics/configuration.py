"""Configurations: assembled poses with all frames."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kinetostatics.exceptions import ArgumentError, near_names
from kinetostatics.kinematics.robot_kinematics import RobotKinematics
from kinetostatics.kinematics.solver import SolverState
from kinetostatics.kinematics.velocities import platform_jacobian
from kinetostatics.layout.mapping import ResultMapping
from kinetostatics.layout.report import Reported
from kinetostatics.math.arrays import Array, Index, Mask, batch_first, frozen
from kinetostatics.math.rotations import Orientation, orientation_named
from kinetostatics.mechanism.pinocchio_loops import LoopModel, loop_model
from kinetostatics.mechanism.tree import Frames
from kinetostatics.status import Status

if TYPE_CHECKING:
    import pinocchio as pin

#: Decimals [m or rad] of coordinates in texts; further digits depend on the processor.
_DECIMALS = 10


@dataclass(frozen=True, repr=False)
class LimitExceeded:
    """A joint beyond its limits.

    Attributes:
        value: (…) coordinate, or angle of a cone [m, rad].
        lower, upper: limits of the joint [m, rad].
        where: (…) True where a limit is exceeded.
    """

    joint: str
    value: Array
    lower: float
    upper: float
    where: Mask

    def __repr__(self) -> str:
        beyond = f"{float(self.value):.6g}" if self.value.shape == () else f"{int(self.where.sum())} of {self.where.size} poses"
        return f"<LimitExceeded {self.joint!r}: {beyond} beyond [{self.lower:.6g}, {self.upper:.6g}]>"


@dataclass(frozen=True, eq=False, repr=False)
class Configuration(Reported):
    """A robot at one pose or a batch of poses, with closed loops. All arrays are read-only, batch axes first.

    Created by :meth:`Robot.assemble` or :meth:`Robot.configuration`.

    Attributes:
        robot: the robot.
        shape: batch shape (…); empty for one pose.
        orientation: convention of the orientation coordinates.
        poses: solver coordinates of the N poses.
        model_q: (nq, N) Pinocchio's coordinates; NaN where the pose is not reached.
        frames: frames of all bodies, world axes.
        loop_residual: (closures, N) residuals of the loops [m, rad].
        reached: (N,) True for poses with closed loops at the given coordinates.
        prescribed: names of the platform coordinates from which the pose was assembled, if any.
        closure_tolerance: largest gap of a closed loop [m, rad], also for poses computed from this one.
    """

    robot: RobotKinematics
    shape: tuple[int, ...]
    orientation: Orientation
    poses: SolverState
    model_q: Array
    frames: Frames
    loop_residual: Array
    reached: Mask
    prescribed: tuple[str, ...]
    closure_tolerance: float

    def __str__(self) -> str:
        if self.shape:
            return repr(self)
        coordinates = {name: float(value) for name, value in (*self.platform.items(), *self.actuators.items())}
        values = [f"{name} = {round(value, _DECIMALS) + 0.0:.6g}" for name, value in coordinates.items()]
        return f"{self.robot.name}: {', '.join(values)} (m, rad; {Status(int(self.status)).name})"

    @property
    def q(self) -> Array:
        """Pinocchio's coordinates (…, nq) [m, rad]."""
        return batch_first(self.model_q, self.shape)

    @cached_property
    def model(self) -> pin.Model:
        """Pinocchio's model (``pin.Model``) with the masses of the robot at this single pose; see :attr:`Robot.model`.

        Raises:
            ArgumentError: this is a batch of poses, or a pose that was not reached.
        """
        if self.shape or not self.reached.all():
            raise ArgumentError("Pinocchio's model needs one pose that was reached: take one pose of the batch")
        return self.robot.weights.on_model(self.robot.mechanism.model, self.frames)

    @cached_property
    def data(self) -> pin.Data:
        """A ``pin.Data`` of :attr:`model` with the frames of all links and joints, and the joint Jacobians, at this single pose.

        Its world frame is the frame of the root link of the file's tree.

        Raises:
            ArgumentError: as for :attr:`model`.
        """
        import pinocchio as pin

        data = self.model.createData()
        pin.computeJointJacobians(self.model, data, self.q)
        pin.updateFramePlacements(self.model, data)
        return data

    def loop_model(self, *, anchors: bool = False) -> LoopModel:
        """Return the robot at this single pose as Pinocchio's tree and constraints, for all types of loops.

        Universal, cylindrical, prismatic and planar loops, for which Pinocchio has no constraint, become additional joints of the
        tree; their last body gets half the inertia of the successor and is welded to it.

        Args:
            anchors: see :meth:`Robot.constraint_models`.

        Raises:
            ArgumentError: as for :attr:`model`.
        """
        return loop_model(self.robot.mechanism, self.model, self.q, self.robot.length, anchors)

    @cached_property
    def loop_gaps(self) -> Mapping[str, tuple[Array, Array]]:
        """Gap of each loop and error of each mimic joint, ``{name: (metres (N,), radians (N,))}``."""
        return ResultMapping(self.robot.equations.loop_gaps(self.loop_residual, self.poses.x))

    @cached_property
    def residual(self) -> Array:
        """(…) largest gap of a loop or error of a mimic joint [m, rad]; NaN where the pose is not reached."""
        worst = np.zeros(len(self.reached))
        for metres, radians in self.loop_gaps.values():
            worst = np.maximum(worst, np.maximum(metres, radians))
        return frozen(np.where(self.reached, worst, np.nan).reshape(self.shape))

    def frame(self, link: str) -> Array:
        """Return the frame of a link as (…, 4, 4) homogeneous matrices in world axes.

        Raises:
            ArgumentError: there is no such link.
        """
        body_of = self.robot.mechanism.body_of
        if not isinstance(link, str) or link not in body_of:
            raise ArgumentError(f"no link {link!r}: {near_names(link, body_of)}")
        return self._homogeneous(*body_of[link])

    @property
    def platform_frame(self) -> Array:
        """The frame o-xyz (…, 4, 4) in world axes."""
        return self._homogeneous(*self.robot.mechanism.platform_frame)

    def _homogeneous(self, body: int, placement: Array) -> Array:
        return batch_first(np.where(self.reached, self.frames.matrices(body, placement), np.nan), self.shape)

    def platform_coordinates(self, orientation: str | None = None) -> dict[str, Array]:
        """Return x, y, z of o [m] and its three orientation coordinates [rad], each (…).

        Args:
            orientation: see :meth:`Robot.assemble`; None: the convention used for assembly.
        """
        convention = self.orientation if orientation is None else orientation_named(orientation)
        R, position = self.robot.mechanism.platform_pose(self.frames)
        coordinates = {}
        for name, values in zip(convention.pose_names, [*position, *convention.coordinates(R)], strict=True):
            coordinates[name] = frozen(np.where(self.reached, values, np.nan).reshape(self.shape))
        return coordinates

    @cached_property
    def platform(self) -> Mapping[str, Array]:
        """All six platform coordinates, with the orientation convention used for assembly."""
        return ResultMapping(self.platform_coordinates())

    @cached_property
    def actuators(self) -> Mapping[str, Array]:
        """The coordinate (…) of every actuated joint [m, rad]."""
        coordinates = self.robot.joint_coordinates.at(self.model_q, self.frames)
        actuated = self.robot.description.actuated
        return ResultMapping({name: frozen(coordinates[name].reshape(self.shape)) for name in actuated})

    @cached_property
    def jacobian(self) -> Array:
        """(…, 6, a) twist of the platform at o, world axes, per unit speed of each of the a actuators, others at rest.

        Columns are in the order of :attr:`actuators`; units are those of the twist [m/s, rad/s] per [m/s] or [rad/s]. Loops
        remain closed. NaN where an actuator cannot move alone, as at singular poses and with redundant actuators, and where the
        pose is not reached.
        """
        return batch_first(np.where(self.reached, platform_jacobian(self.robot, self.poses), np.nan), self.shape)

    @cached_property
    def condition_number(self) -> Array:
        """(…) ratio of the largest to the smallest singular value of :attr:`jacobian`.

        Rotations of the platform and speeds of rotary actuators are multiplied by ``robot.length``. Infinite where some speeds of
        the actuators do not move the platform; NaN where the Jacobian is NaN.
        """
        length, joints = self.robot.length, self.robot.mechanism.connections
        speeds = [1.0 if joints[name].type.is_slide else length for name in self.actuators]
        scaled = self.jacobian * np.array([1.0] * 3 + [length] * 3)[:, None] / speeds
        finite = np.isfinite(scaled).all(axis=(-2, -1))
        values = np.linalg.svd(np.where(finite[..., None, None], scaled, 0.0), compute_uv=False)
        if not speeds:
            return frozen(np.full(self.shape, np.nan))
        moves = values[..., -1] > 1e-12 * values[..., 0]
        ratio = values[..., 0] / np.where(moves, values[..., -1], 1.0)
        return frozen(np.where(finite, np.where(moves, ratio, np.inf), np.nan))

    @cached_property
    def limits_exceeded(self) -> Mapping[str, LimitExceeded]:
        """The joints beyond their limits or cones in at least one pose, by name."""
        exceeded: dict[str, LimitExceeded] = {}
        for name, value, limits, within in self.robot.joint_coordinates.limited(self.model_q, self.frames):
            beyond = self.reached & ~within
            if np.any(beyond):
                exceeded[name] = LimitExceeded(name, frozen(value.reshape(self.shape)), *limits, beyond.reshape(self.shape))
        return ResultMapping(exceeded)

    @cached_property
    def limit_exceeded(self) -> Mask:
        """(…) whether a joint is beyond its limit or cone; False where the pose is not reached."""
        beyond = np.zeros(self.shape, dtype=bool)
        for exceeded in self.limits_exceeded.values():
            beyond |= exceeded.where
        return frozen(beyond)

    @cached_property
    def status(self) -> NDArray[np.int8]:
        """:class:`Status` of every pose (…): OK, LIMIT_EXCEEDED or UNREACHABLE."""
        reached = self.reached.reshape(self.shape)
        status = np.where(reached, np.where(self.limit_exceeded, Status.LIMIT_EXCEEDED, Status.OK), Status.UNREACHABLE)
        return frozen(np.asarray(status.astype(np.int8)))


def spread(configuration: Configuration, shape: tuple[int, ...]) -> Configuration:
    """Return a configuration broadcast to a larger batch shape."""
    if shape == configuration.shape:
        return configuration
    numbers = np.arange(len(configuration.reached)).reshape(configuration.shape)
    return taken(configuration, np.broadcast_to(numbers, shape).ravel(), shape)


def taken(configuration: Configuration, which: Index, shape: tuple[int, ...]) -> Configuration:
    return replace(
        configuration,
        shape=shape,
        poses=configuration.poses.take(which),
        model_q=frozen(configuration.model_q[:, which]),
        frames=configuration.frames.take(which),
        loop_residual=configuration.loop_residual[:, which],
        reached=configuration.reached[which],
    )
