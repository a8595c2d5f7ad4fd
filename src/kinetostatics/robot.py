"""A robot, from its file to its poses."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.buckling.members import Member, members_of
from kinetostatics.description.robot import RobotDescription
from kinetostatics.exceptions import AssemblyError
from kinetostatics.files.reader import read_robot_file
from kinetostatics.kinematics import assembly, zero_pose
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.kinematics.loop_constraints import LoopEquations, world_frames
from kinetostatics.kinematics.mimic import Couplings
from kinetostatics.kinematics.pose_spread import ordinary_poses
from kinetostatics.kinematics.solver import Poses, Request, Solver
from kinetostatics.kinematics.unit_hints import odd_coordinates
from kinetostatics.limbs.beam_model import BeamModel, make_beam_models
from kinetostatics.limbs.gravity import Weights
from kinetostatics.limbs.group import LimbGroup
from kinetostatics.limbs.grouping import make_limb_groups
from kinetostatics.math.arrays import Array
from kinetostatics.math.linalg import dot, null_space
from kinetostatics.mechanism.limb_joints import Branch, JointTable, dead_joints, freedoms_of, limb_units
from kinetostatics.mechanism.limbs import Limb, Topology, analyze_topology
from kinetostatics.mechanism.mechanism import Mechanism
from kinetostatics.mechanism.pinocchio_loops import constraint_models
from kinetostatics.mechanism.tree import Frames
from kinetostatics.printing.mappings import Named

#: Relative singular value below which a direction counts as dependent. Angles rounded to 1.5708 leave 4e-6.
RANK_TOLERANCE = 1e-5
#: Scaled motions of freedoms below this are rounding.
IDLE = 1e-13


@dataclass(frozen=True)
class Mobility:
    """What the loops leave free, found at generic assembled poses.

    Attributes:
        platform: freedoms of the platform.
        local: freedoms that do not move the platform (a strut spinning about itself, a loose link).
        redundant_constraints: loop equations that say nothing new: the degree of overconstraint.
        gap: ratio of the smallest kept to the largest dropped singular value; small means that the count is doubtful.
    """

    platform: int
    local: int
    redundant_constraints: int
    gap: float

    def __str__(self) -> str:
        return f"{self.platform}" + (f" (+{self.local} local)" if self.local else "")


def load_robot(path: str | os.PathLike[str], parameters: Mapping[str, object] | None = None) -> Robot:
    """Load a robot from a URDF or xacro file.

    Args:
        path: of the file, whose format is described in ``docs/robot_format.md``; or the name of a robot that comes with the
            package, such as "3rps", see :func:`kinetostatics.robots`.
        parameters: values of the file's xacro arguments, SI units.

    Raises:
        RobotFileError: the file is wrong; the message names file and line.
    """
    return Robot(read_robot_file(path, parameters))


class Robot:
    """A parallel manipulator: its joints, limbs and beams.

    Attributes:
        description: what the file says.
        mechanism: bodies and connections.
        topology: limbs and dead weights.
        model: Pinocchio's model of the spanning tree.
    """

    def __init__(self, description: RobotDescription) -> None:
        self.mechanism = Mechanism(description)
        self.description = self.mechanism.description
        self.topology: Topology = analyze_topology(self.mechanism)
        self.equations = LoopEquations(self.mechanism)
        self._determined: dict[Request, bool] = {}
        self._local: dict[Request, int] = {}
        self._holding_idle: dict[Request, Request] = {}
        self._origins: dict[Request, tuple[Array, Array]] = {}

    @property
    def name(self) -> str:
        """Its name in the file."""
        return self.description.name

    @cached_property
    def model(self) -> Any:
        """Pinocchio's model of the file's tree, which weighs what the robot weighs: links, and beams as rods on their links.

        A telescope has the length of the zero pose; :attr:`Configuration.model` is the model of another pose.
        """
        zero = self.mechanism.forward(self.mechanism.tree.neutral[:, None])
        if not isinstance(self._closed_zero, AssemblyError):
            zero = self.zero_frames
        return self.weights.on_model(self.mechanism.model, zero)

    def constraint_models(self, *, anchors: bool = False) -> list[Any]:
        """Return the loops as Pinocchio's constraints on :attr:`model`, for ``pin.constraintDynamics``, ``pin.lcaba`` and others.

        A fixed loop is one constraint of six rows, a spherical one a point of three. A hinge is two points of its axis: six rows
        of rank five, which Pinocchio's proximal solvers take (``pin.ProximalSettings``). Every constraint has its loop's name.
        A driven loop is as free as the others: Pinocchio knows no force along it.

        Args:
            anchors: return ``pin.PointAnchorConstraintModel`` and ``pin.FrameAnchorConstraintModel``, which Pinocchio has since
                4.0, instead of ``pin.RigidConstraintModel``.

        Raises:
            ArgumentError: Pinocchio has no constraint for the type of a loop (universal, cylindrical, prismatic, planar);
                :meth:`Configuration.loop_model` has one for all.
        """
        return constraint_models(self.mechanism, self.model, self.length, anchors)

    def __str__(self) -> str:
        from kinetostatics.reports import robot_report

        return robot_report(self)

    def __repr__(self) -> str:
        from kinetostatics.reports.short import robot_line

        return robot_line(self)

    def _repr_html_(self) -> str:
        from kinetostatics.reports.short import robot_html

        return robot_html(self)

    # ---- the zero pose and what follows from it ---------------------------------------------------------------------

    @cached_property
    def length(self) -> float:
        """Characteristic length [m]: mean distance of the limbs' outer joints from o, or a quarter of the robot's size."""
        body, placement = self.mechanism.platform_frame
        frames = self.mechanism.forward(self.mechanism.tree.neutral[:, None])
        o = frames.points(np.array([body]), placement[:3, 3:])[:, 0, 0]
        distances = []
        for limb in self.topology.limbs:
            unit_of = {name: unit for unit in limb_units(self.mechanism, limb) for name in unit.joints}
            for edge in limb.edges:
                if edge.joint is None or len(edge.chords) != 1 or not limb.to_platform[edge.chords[0][0]]:
                    continue
                connection = self.mechanism.connections[edge.joint]
                for link, item_body, frame in (
                    (connection.successor, connection.successor_body, connection.successor_frame),
                    (connection.predecessor, connection.predecessor_body, connection.predecessor_frame),
                ):
                    if link in self.topology.platform.links:  # which need not be the platform's body, if a loop fixes them
                        at = np.array([item_body])
                        arm = frames.points(at, frame[:3, 3:])[:, 0, 0] - o
                        if edge.joint in unit_of:
                            unit = unit_of[edge.joint]
                            along = frames.directions(at, (frame[:3, :3] @ connection.axis)[:, None])[:, 0, 0]
                            arm = arm + along * (unit.shift if unit.has_centre else -(along @ arm))
                        distances.append(float(np.linalg.norm(arm)))
                        break
        mean = float(np.mean(distances)) if distances else 0.0
        if mean > 1e-3 * self.size:
            return mean
        return self.size / 4 if self.size > 0 else 1.0

    @cached_property
    def size(self) -> float:
        """Diagonal [m] of the box around the zero pose."""
        body, placement = self.mechanism.platform_frame
        frames = self.mechanism.forward(self.mechanism.tree.neutral[:, None])
        points = [frames.position[:, :, 0].T]
        for item in self.mechanism.connections.values():
            at = np.array([item.predecessor_body])
            points.append(frames.points(at, item.predecessor_frame[:3, 3:])[:, :, 0].T)
        points.append(frames.points(np.array([body]), placement[:3, 3:])[:, :, 0].T)
        cloud = np.concatenate(points)
        return float(np.linalg.norm(cloud.max(axis=0) - cloud.min(axis=0)))

    @property
    def _reach(self) -> float:
        """What the platform may move in comparison with a turn [m]."""
        return max(self.length, self.size / 4)

    @property
    def _zero(self) -> tuple[Poses, float]:
        """The closed zero pose, and the scaled residual with which it closes."""
        if isinstance(self._closed_zero, AssemblyError):
            raise self._closed_zero
        return self._closed_zero

    @cached_property
    def _closed_zero(self) -> tuple[Poses, float] | AssemblyError:
        """The same, or why it cannot be closed: the search for it is long and need not be repeated."""
        solver = Solver(self.equations, self.length, self._reach)
        tree = self.equations.tree
        start = zero_pose.written_zero(self)
        if not self.equations.loops:
            return start, 0.0
        drives = self.actuator_request
        best, residual = solver.close(start, drives, np.zeros((drives.size, 1)))
        if residual < 1e-11:
            return best, residual
        # Rounding alone is no reason to move the drives: a nearly closed pose far away would be another assembly mode.
        free = solver.close(start, Request(), np.zeros((0, 1)), cutoff=1e-3)
        if free[1] < 1e-9 or 1e-2 < residual > free[1]:
            best, residual = free
        random = np.random.default_rng(1)
        for _ in range(20):
            if residual < 1e-2:
                break
            v = random.uniform(-0.7, 0.7, tree.nv) * solver.column_scale
            trial = solver.close(Poses(tree.integrate(start.x, v[:, None]), start.c), Request(), np.zeros((0, 1)))
            if trial[1] < residual:
                best, residual = trial
        if residual > 1e-2:
            return AssemblyError(
                zero_pose.wrong_zero_text(self, assembly.say_openings(self, best)), zero_pose.gaps_at(self, best)
            )
        return best, residual

    @cached_property
    def zero_gaps(self) -> dict[str, tuple[float, float]]:
        """How far each loop is open where all joints are at zero, {name: (m, rad)}."""
        return zero_pose.gaps_at(self, zero_pose.written_zero(self))

    @cached_property
    def zero_is_near(self) -> bool:
        """Whether the loops are closed where all joints are at zero, but for rounding."""
        return zero_pose.are_within(self.zero_gaps, zero_pose.ROUNDING * self.size, zero_pose.ROUNDING)

    @cached_property
    def has_wrong_zero(self) -> bool:
        """Whether the loops are open at zero by more than rounding, and no motion of the joints closes them."""
        if self.zero_is_near:
            return False
        if isinstance(self._closed_zero, AssemblyError) or self.closing_error > zero_pose.SIX_DIGITS:
            return True
        return self.closing_error > zero_pose.CLOSED and zero_pose.is_one_frame(self)

    @cached_property
    def wrong_zero(self) -> AssemblyError | None:
        """What is wrong with the zero pose, if it is; see :attr:`has_wrong_zero`."""
        if isinstance(self._closed_zero, AssemblyError):
            return self._closed_zero
        if not self.has_wrong_zero:
            return None
        return AssemblyError(zero_pose.wrong_zero_text(self), self.zero_gaps, self.mobility.platform)

    @cached_property
    def solver(self) -> Solver:
        """Closes the loops."""
        return Solver(self.equations, self.length, self._reach, slack=1e-7 + 100 * self.closing_error)

    @property
    def zero_poses(self) -> Poses:
        """The closed zero pose, from which all others are reached."""
        return self._zero[0]

    @property
    def closing_error(self) -> float:
        """How far the loops stay open at the zero pose and beside it [scaled m, rad]: rounding, or the file's own."""
        return max(self._zero[1], self._generic[1])

    @property
    def generic_poses(self) -> Poses:
        """Three assembled poses without symmetry, near the zero pose, at which ranks and bases are decided."""
        return self._generic[0]

    @cached_property
    def _generic(self) -> tuple[Poses, float]:
        """The same, and the largest scaled residual with which they close."""
        zero, worst = self._zero
        random = np.random.default_rng(7)
        tree, solver = self.equations.tree, Solver(self.equations, self.length, self._reach)
        nothing = Request(), np.zeros((0, 1))
        tolerance = max(RANK_TOLERANCE, 30 * worst)
        found = []
        for size in (0.12, 0.1, 0.08):
            pose, direction = zero, random.standard_normal(tree.nv)
            for _ in range(2):  # twice the same way: what is free after one step tells little at a singular zero pose
                _, gradient = solver.system(nothing[0], pose, nothing[1])
                free = null_space(gradient[:, :, 0], tolerance)[0]
                v = free @ (free.T @ direction)
                v = v * solver.column_scale * (size / max(float(np.abs(v).max(initial=0.0)), 1e-9))
                moved = Poses(tree.integrate(pose.x, v[:, None]), pose.c)
                pose, residual = solver.close(moved, *nothing, cutoff=tolerance)
                worst = max(worst, residual)
            found.append(pose)
        return Poses(np.hstack([pose.x for pose in found]), np.hstack([pose.c for pose in found])), worst

    @property
    def rank_tolerance(self) -> float:
        """Relative singular value below which a direction counts as dependent; above what the file's rounding leaves."""
        return max(RANK_TOLERANCE, 30 * self.closing_error)

    @cached_property
    def mobility(self) -> Mobility:
        """Mobility of the platform, local freedoms and redundant constraints."""
        ranks, gaps, platforms = [], [], []
        solver, tree = self.solver, self.equations.tree
        for k in range(self.generic_poses.x.shape[1]):
            pose = self.generic_poses.take(np.array([k]))
            _, gradient = solver.system(Request(), pose, np.zeros((0, 1)))
            free, rank, gap = null_space(gradient[:, :, 0], self.rank_tolerance)
            values = np.linalg.svd(self._platform_map(pose) @ free, compute_uv=False)
            platforms.append(int(np.sum(values > self.rank_tolerance)))
            ranks.append(rank)
            gaps.append(gap)
        best = int(np.argmax(ranks))
        freedoms = tree.nv - ranks[best]
        platform = platforms[best]
        return Mobility(platform, freedoms - platform, self.equations.count - ranks[best], gaps[best])

    def _platform_map(self, pose: Poses) -> Array:
        """Return the scaled (6, nv) map from scaled tree freedoms to the platform's twist at o."""
        solver = self.solver
        frames = self.equations.forward(pose.x)
        twists = (self.equations.tree.twists(frames) * solver.platform_signs[:, None])[:, :, 0]
        _, position = solver.platform_pose(frames)
        linear = twists[:3] + np.cross(twists[3:], position, axis=0)
        return np.concatenate([linear / self.length, twists[3:]]) * solver.column_scale

    @cached_property
    def zero_frames(self) -> Frames:
        """Frames of the closed zero pose, a batch of one."""
        return world_frames(self.mechanism, self.mechanism.forward(self.model_q(self._zero[0])))

    @cached_property
    def beams(self) -> Mapping[str, BeamModel]:
        """All beams by name."""
        return Named(make_beam_models(self.mechanism, self.topology.beams, self.zero_frames))

    @cached_property
    def members(self) -> tuple[Member, ...]:
        """Runs of beams in one line, which buckle as one, and how their ends are held."""
        return members_of(self)

    @cached_property
    def weights(self) -> Weights:
        """Everything that weighs something."""
        return Weights(self)

    @cached_property
    def branches(self) -> tuple[Branch, ...]:
        """The passive joints of all dead branches."""
        return dead_joints(self)

    @cached_property
    def joint_table(self) -> JointTable:
        """All joints through which something is held."""
        return JointTable(self)

    def passive_joints(self, owner: str) -> list[str]:
        """Return the passive joints of a limb, or of what hangs on ``base`` or ``platform``."""
        names = [item.joint for item in self.branches if item.owner == owner]
        for limb in self.all_limbs:
            if limb.name == owner:
                for edge in limb.edges:
                    if edge.joint is not None:
                        freedoms = freedoms_of(self.mechanism, self.mechanism.connections[edge.joint], edge.sign)
                        if any(freedom.passive for freedom in freedoms):
                            names.append(edge.joint)
        return names

    @cached_property
    def all_limbs(self) -> tuple[Limb, ...]:
        """The limbs, and behind them the closed chains that hang on base or platform alone."""
        return (*self.topology.limbs, *self.topology.hanging)

    @cached_property
    def limb_groups(self) -> tuple[LimbGroup, ...]:
        """Equal limbs stacked, with their wrench bases, which are fixed once per robot."""
        generic, ordinary = (
            world_frames(self.mechanism, self.mechanism.forward(q))
            for q in (self.model_q(self.generic_poses), ordinary_poses(self))
        )
        return make_limb_groups(self, generic, ordinary)

    # ---- coordinates ------------------------------------------------------------------------------------------------

    @cached_property
    def actuator_request(self) -> Request:
        """The driven joints as the solver sees them."""
        return assembly.actuator_request(self)

    def determines(self, request: Request) -> bool:
        """Whether the requested coordinates leave the platform no freedom, at generic poses."""
        if request not in self._determined:
            self._determined[request] = any(self.determines_at(request, pose) for pose in self._each_generic_pose())
        return self._determined[request]

    def determines_at(self, request: Request, pose: Poses) -> bool:
        """Whether the requested coordinates leave the platform no freedom at one pose."""
        columns = self.solver.free_columns(request)
        moving = self._platform_map(pose)[:, columns] @ self._free_motions(request, pose)[: len(columns)]
        return float(np.abs(moving).max(initial=0.0)) < 1e-6

    def local_freedoms(self, request: Request) -> int:
        """How many freedoms the requested coordinates leave, at generic poses: local ones, if they determine the platform."""
        if request not in self._local:
            self._local[request] = min(self._free_motions(request, pose).shape[1] for pose in self._each_generic_pose())
        return self._local[request]

    def holding_idle(self, request: Request) -> Request:
        """Return a request that holds the freedoms that change neither loops nor what is requested: the spins of most rods."""
        if request not in self._holding_idle:
            gradients = [np.abs(self._gradient(request, pose)) for pose in self._each_generic_pose()]
            columns = self.solver.free_columns(request)
            idle = columns[np.max(gradients, axis=(0, 1), initial=0.0)[: columns.size] < IDLE]
            self._holding_idle[request] = replace(request, held=tuple(idle.tolist()))
        return self._holding_idle[request]

    def zero_origin(self, request: Request) -> tuple[Array, Array]:
        """Return where lines from the zero pose start, see :meth:`Solver.origin`."""
        if request not in self._origins:
            self._origins[request] = self.solver.origin(request, self.zero_poses)
        return self._origins[request]

    def _each_generic_pose(self) -> Iterator[Poses]:
        for number in range(self.generic_poses.x.shape[1]):
            yield self.generic_poses.take(np.array([number]))

    def _free_motions(self, request: Request, pose: Poses) -> Array:
        """Return a basis (n, k) of the scaled motions of free columns and unknown angles that a request allows at one pose."""
        return null_space(self._gradient(request, pose), self.rank_tolerance)[0]

    def _gradient(self, request: Request, pose: Poses) -> Array:
        """Return the gradient (m, n) of loops and request at one pose."""
        if request.orientation is not None:
            R, _ = self.solver.platform_pose(self.equations.forward(pose.x))
            pose = Poses(pose.x, request.orientation.coordinates(R))
        return self.solver.system(request, pose, self.solver.values(request, pose))[1][:, :, 0]

    @cached_property
    def _couplings(self) -> Couplings:
        """The joints that follow others, in Pinocchio's coordinates."""
        return Couplings(self.mechanism, self.mechanism.tree)

    def joint_coordinates(self, q: Array, frames: Frames) -> dict[str, Array]:
        """Return the coordinate (N,) of every one-freedom joint and loop [m, rad]; of one that others follow, all its turns."""
        result: dict[str, Array] = {}
        by_body = {joint.body: joint for joint in self.mechanism.tree.joints}
        for name, body in self.mechanism.body_of_joint.items():
            joint = by_body[body]
            if joint.nv == 1:
                result[name] = self._couplings.coordinate(joint, q)
        for number, loop in enumerate(self.equations.loops):
            if loop.kind in ("revolute", "continuous", "prismatic"):
                result[loop.name] = self.solver.loop_coordinate(number, frames)
        return result

    def limited(self, q: Array, frames: Frames) -> Iterator[tuple[str, Array, float, float]]:
        """Yield name, value (N,), lower and upper limit of every joint that has limits, cones included."""
        coordinates = self.joint_coordinates(q, frames)
        for item in self.mechanism.connections.values():
            if item.cone is not None:
                axes = [
                    frames.directions(np.array([body]), (frame[:3, :3] @ np.array(axis) / np.linalg.norm(axis))[:, None])[:, 0]
                    for body, frame, axis in (
                        (item.predecessor_body, item.predecessor_frame, item.cone.predecessor_axis),
                        (item.successor_body, item.successor_frame, item.cone.successor_axis),
                    )
                ]
                yield item.name, np.arccos(np.clip(dot(axes[0], axes[1]), -1, 1)), 0.0, item.cone.angle
            if item.name in coordinates and (np.isfinite(item.lower) or np.isfinite(item.upper)):
                yield item.name, coordinates[item.name], item.lower, item.upper

    # ---- poses ------------------------------------------------------------------------------------------------------

    def assemble(
        self,
        *,
        actuators: Mapping[str, ArrayLike] | None = None,
        platform: Mapping[str, ArrayLike] | None = None,
        orientation: str | None = None,
        near: Configuration | None = None,
        tolerance: float = 1e-10,
        on_failure: str | None = None,
    ) -> Configuration:
        """Close the loops at given actuator values or platform coordinates; arrays of coordinates give a batch.

        The assembly mode is the one that is reached by following a straight line in the given coordinates from the closed
        zero pose, or from ``near``. Of large batches few poses follow their lines and predict the others, but only where some
        more lines show that the predictions end in the same mode.

        Args:
            actuators: coordinates of all driven joints by name [m, rad] (forward kinematics); all zero if neither these nor
                ``platform`` are given.
            platform: as many platform coordinates as the mobility (inverse kinematics): ``x y z`` of o [m] and orientation [rad]
                in world axes.
            orientation: what ``rx ry rz`` mean: None or "rotation_vector"; an Euler sequence such as "XYZ" (moving axes) or "xyz"
                (fixed axes); or "tilt_torsion" for ``azimuth tilt torsion``.
            near: where the straight line starts; one pose, or a batch of the same shape. From there what turns goes the shorter
                way.
            tolerance: how far loops may stay open [m, rad]. Overconstrained files with rounded angles need a larger one; their
                loops are then closed in the least-squares sense. It does not excuse mistakes: where no motion closes the loops
                and the file's zero pose leaves them open by more than 1e-4 of the robot's size (or 1e-4 rad), it has to cover
                that gap too, and counts up to 1e-3 of the size (1e-3 rad).
            on_failure: "raise" or "nan"; default: raise for one pose, NaN and a status for a batch.

        Raises:
            CoordinatesError: unknown, missing or too many coordinates, or ones that do not determine the pose.
            AssemblyError: the pose cannot be reached; the message says which loop stays open and by how much.
        """
        found = assembly.assemble(self, actuators, platform, orientation, near, tolerance, on_failure)
        for hint in odd_coordinates(self, (actuators if platform is None else platform) or {}):
            warnings.warn(hint, stacklevel=2)
        return found

    def configuration(self, q: ArrayLike, *, tolerance: float = 1e-10, on_failure: str | None = None) -> Configuration:
        """Return the pose at Pinocchio coordinates ``q`` (…, nq) that close the loops already.

        Raises:
            ArgumentError: the size is wrong.
            AssemblyError: the loops are open by more than ``tolerance`` [m, rad].
        """
        return assembly.configuration_at(self, q, tolerance, on_failure)

    def model_q(self, poses: Poses) -> Array:
        """Return Pinocchio's coordinates (nq, N) of solved poses."""
        near = np.broadcast_to(self.mechanism.tree.neutral[:, None], (self.mechanism.tree.nq, poses.x.shape[1]))
        return self.equations.to_model(poses.x, near)
