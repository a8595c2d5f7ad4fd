"""The class of robots, with description, kinematics, poses and statics."""

from __future__ import annotations

import os
from collections.abc import Mapping
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar

from numpy.typing import ArrayLike

from kinetostatics import hooks
from kinetostatics.arguments import warn
from kinetostatics.description.robot_description import RobotDescription
from kinetostatics.elements.static_model import StaticModel
from kinetostatics.engine.programs import check_engine, compiled_loops
from kinetostatics.exceptions import ArgumentError, AssemblyError, RobotFileError
from kinetostatics.files.parameter_units import parameter_hints
from kinetostatics.files.reader import read_robot_file
from kinetostatics.kinematics import assembly
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.kinematics.reach import ordinary_poses
from kinetostatics.kinematics.robot_kinematics import RobotKinematics
from kinetostatics.kinematics.zero_pose import with_wrong_parent
from kinetostatics.layout.report import Reported
from kinetostatics.mechanism.mechanism import Mechanism
from kinetostatics.mechanism.pinocchio_loops import constraint_models
from kinetostatics.mechanism.topology import analyze_topology
from kinetostatics.statics.robot_statics import RobotStatics, make_statics

if TYPE_CHECKING:
    import pinocchio as pin

    from kinetostatics.buckling.members import Members

#: Public attributes that a robot inherits.
_PUBLIC = (
    *("description", "mechanism", "topology"),
    *("name", "size", "length", "mobility", "beams", "weights", "closing_error"),
)


def load_robot(
    path: str | os.PathLike[str],
    parameters: Mapping[str, object] | None = None,
    *,
    platform_link: str | None = None,
    base_link: str | None = None,
) -> Robot:
    """Load a robot from a URDF or xacro file.

    Args:
        path: path of the file (format: see the page on robot files), or name of a robot of the package, such as "3rps", see
            :func:`kinetostatics.robots`.
        parameters: values of the file's xacro arguments, SI units.
        platform_link: link that is the platform; its frame is o-xyz. Default: the link that the file names as platform, or the
            only end of the file's tree. If the file names no platform and has no loops, like the plain URDF of an arm, all
            movable joints are actuated.
        base_link: link fixed to the ground; default: the link that the file names as base, or the root of the file's tree.

    Raises:
        RobotFileError: the file is invalid; the message names file and line.
        PlatformMissingError: the file does not name the platform.
        ArgumentError: the file has no such link.

    Examples:
        A plain URDF has rigid links only; :func:`kinetostatics.extend_robot` makes links and actuators elastic.

        >>> import kinetostatics as ks
        >>> from kinetostatics.files.bundled import package_folder
        >>> folder = package_folder("example-robot-data") / "robots"
        >>> panda = ks.load_robot(folder / "panda_description" / "urdf" / "panda.urdf", platform_link="panda_hand")
        >>> round(float(ks.analyze(panda.assemble()).actuator_forces["panda_joint2"]), 3)
        -4.04
    """
    links = {"platform_link": platform_link, "base_link": base_link}
    robot = Robot(read_robot_file(path, parameters, **links))
    for hint in parameter_hints(robot.description.path, parameters or {}, links):
        warn(hint)
    return robot


class Robot(Reported, RobotKinematics):
    """A parallel manipulator with joints, limbs and beams.

    The kinematics are in :class:`RobotKinematics`; this class adds the statics and the public methods.

    Attributes:
        description: contents of the file.
        mechanism: bodies and connections.
        topology: limbs, and the bodies attached to base and platform.
        model: Pinocchio's model of the spanning tree.
    """

    #: Cached properties that compiled code depends on.
    RECORDED: ClassVar = tuple("beams elastic_links weights solver statics members joint_coordinates size length".split())

    def __init__(self, description: RobotDescription) -> None:
        mechanism = Mechanism(description)
        try:
            topology = analyze_topology(mechanism)
        except RobotFileError as error:
            raise with_wrong_parent(error, mechanism) from None
        super().__init__(mechanism, topology)

    def __dir__(self) -> list[str]:
        names = {*vars(Robot), *vars(Reported), *_PUBLIC}
        return [name for name in super().__dir__() if name in names or name.startswith("_")]

    @cached_property
    def model(self) -> pin.Model:
        """Pinocchio's model of the file's tree with the masses of links and beams; beams are rods fixed to their links.

        Telescopic beams have their length at the zero pose; :attr:`Configuration.model` is the model at another pose.
        """
        try:
            zero = self.zero_frames
        except AssemblyError:
            zero = self.mechanism.forward(self.mechanism.tree.neutral[:, None])
        return self.weights.on_model(self.mechanism.model, zero)

    def constraint_models(self, *, anchors: bool = False) -> list[pin.RigidConstraintModel]:
        """Return the loops as Pinocchio's constraints on :attr:`model`, for ``pin.constraintDynamics``, ``pin.lcaba`` and others.

        A fixed loop is one constraint with six rows, a spherical loop a point constraint with three. A revolute loop is two point
        constraints on its axis; their six rows have rank five, as Pinocchio's proximal solvers permit
        (``pin.ProximalSettings``). Every constraint has the name of its loop. Pinocchio applies no force along an actuated loop.

        Args:
            anchors: return ``pin.PointAnchorConstraintModel`` and ``pin.FrameAnchorConstraintModel`` (Pinocchio 4.0 and newer)
                instead of ``pin.RigidConstraintModel``.

        Raises:
            ArgumentError: Pinocchio has no constraint for the type of a loop (universal, cylindrical, prismatic, planar);
                :meth:`Configuration.loop_model` supports all types.
        """
        return constraint_models(self.mechanism, self.model, self.length, anchors)

    @cached_property
    def statics(self) -> RobotStatics:
        """Immutable data of the statics; the wrench bases of the limbs are chosen once per robot."""
        model = StaticModel(
            self.mechanism,
            self.topology,
            self.elastic_links,
            self.weights,
            self.zero_frames,
            self.length,
            self.rank_tolerance,
            self.closing_error,
        )
        return make_statics(model, self.generic_frames, self.frames_at(ordinary_poses(self)))

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """Warnings that apply to all poses; :attr:`Result.warnings` includes them."""
        return hooks.robot_warnings(self)

    @cached_property
    def members(self) -> Members:
        """The members that can buckle: beams, or collinear beams that buckle as one."""
        from kinetostatics.buckling.members import Members

        return Members(self.statics)

    def assemble(
        self,
        *,
        actuators: Mapping[str, ArrayLike] | None = None,
        platform: Mapping[str, ArrayLike] | None = None,
        orientation: str | None = None,
        near: Configuration | Mapping[str, float] | None = None,
        closure_tolerance: float = 1e-10,
        on_failure: str | None = None,
        engine: str = "auto",
    ) -> Configuration:
        """Close the loops at given coordinates of actuators or platform; arrays of coordinates give a batch of poses.

        Each pose is reached along a straight line in the given coordinates, from the closed zero pose or from ``near``; this line
        decides the assembly mode.

        Args:
            actuators: coordinates of all actuated joints by name [m, rad] (forward kinematics). Actuated joints outside the
                limbs, such as a gripper's, may be omitted; they are zero. Without ``actuators`` and ``platform``, all are zero.
            platform: coordinates of the platform by name, as many as the mobility (inverse kinematics): ``x y z`` of o [m] and
                angles of orientation [rad], in world axes.
            orientation: meaning of ``rx ry rz``: None or "rotation_vector"; an Euler sequence such as "XYZ" (moving axes) or
                "xyz" (fixed axes); or "tilt_torsion" for ``azimuth tilt torsion``.
            near: start of the straight line: a pose, a batch of the same shape, or values of joints by name [m, rad], including
                passive joints, for the closed pose nearest to these values. From there the platform turns by the shorter
                rotation.
            closure_tolerance: largest gap of a closed loop [m, rad]. Overconstrained robots whose files have rounded angles need
                more than the default; their loops are closed in the least-squares sense. If gaps remain at the zero pose that
                exceed 1e-4 of the robot's size (or 1e-4 rad), the tolerance must be at least these gaps; gaps above 1e-3 of the
                size (1e-3 rad) are never accepted.
            on_failure: "raise" or "nan"; default: raise for one pose, NaN and a status for a batch.
            engine: "numpy", "compiled", or "auto": see :func:`kinetostatics.analyze`.

        Raises:
            CoordinatesError: coordinates are unknown, missing, too many, or do not determine the pose.
            AssemblyError: the pose cannot be reached; the message names the open loop and its gap.
        """
        chosen = compiled_loops(check_engine(engine))
        configuration = assembly.assemble(self, actuators, platform, orientation, near, closure_tolerance, on_failure, chosen)
        for hint in self.unit_hints((actuators if platform is None else platform) or {}):
            warn(hint)
        return configuration

    def configuration(self, q: ArrayLike, *, closure_tolerance: float = 1e-10, on_failure: str | None = None) -> Configuration:
        """Return the pose at Pinocchio coordinates ``q`` (…, nq) that close the loops already.

        Raises:
            ArgumentError: the size is wrong.
            AssemblyError: the loops are open by more than ``closure_tolerance`` [m, rad].
        """
        return assembly.configuration_at(self, q, closure_tolerance, on_failure)


def robot_of(configuration: Configuration) -> Robot:
    """Return the robot of a pose; raise an ArgumentError if it has no statics."""
    robot = configuration.robot
    if not isinstance(robot, Robot):
        raise ArgumentError(f"the pose belongs to {robot!r}, which has no statics: make one with robot.assemble(…)")
    return robot
