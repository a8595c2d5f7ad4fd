"""A robot, from its file to its poses."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinetostatics.beam_models import BeamModel, make_beam_models
from kinetostatics.closure import LoopEquations, world_frames
from kinetostatics.configuration import Configuration
from kinetostatics.description import RobotDescription
from kinetostatics.exceptions import ArgumentError, AssemblyError, CoordinatesError, near_names
from kinetostatics.kinematics import Frames
from kinetostatics.limb_joints import Branch, dead_joints
from kinetostatics.limbs import LimbGroup, make_limb_groups
from kinetostatics.linalg import dot
from kinetostatics.mechanism import Mechanism
from kinetostatics.orientation import orientation_named
from kinetostatics.robot_file import read_robot_file
from kinetostatics.solver import Poses, Request, Solver
from kinetostatics.topology import Topology, analyze_topology
from kinetostatics.weights import Weights

Array = NDArray[np.float64]

#: Poses solved together; more no longer fit into the processor's cache.
CHUNK = 2000


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
        path: of the file; the format is described in ``docs/robot_format.md``.
        parameters: values of the file's xacro arguments, SI units.

    Raises:
        RobotFileError: the file is wrong; the message names file and line.
        NotYetError: the robot has limbs that cannot be analysed yet.
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
        self.description = description
        self.mechanism = Mechanism(description)
        self.topology: Topology = analyze_topology(self.mechanism)
        self.equations = LoopEquations(self.mechanism)
        self._determined: dict[Request, bool] = {}

    @property
    def name(self) -> str:
        """Its name in the file."""
        return self.description.name

    @property
    def model(self) -> Any:
        """Pinocchio's model of the file's tree."""
        return self.mechanism.model

    def __str__(self) -> str:
        from kinetostatics.report import robot_report

        return robot_report(self)

    def __repr__(self) -> str:
        return f"<Robot {self.name!r} from {self.description.path!r}: {len(self.topology.limbs)} limbs>"

    # ---- the zero pose and what follows from it ---------------------------------------------------------------------

    @cached_property
    def length(self) -> float:
        """Characteristic length [m]: mean distance of the limbs' outer joints from o, or a quarter of the robot's size."""
        body, placement = self.mechanism.platform_frame
        distances = []
        for limb in self.topology.limbs:
            joint = limb.path[-1].joint
            if joint is None:
                continue
            connection = self.mechanism.connections[joint]
            for other, frame in (
                (connection.successor_body, connection.successor_frame),
                (connection.predecessor_body, connection.predecessor_frame),
            ):
                if other == body:
                    distances.append(float(np.linalg.norm(frame[:3, 3] - placement[:3, 3])))
                    break
        frames = self.mechanism.tree.forward(self.mechanism.tree.neutral[:, None])
        points = [frames.position[:, :, 0].T]
        for item in self.mechanism.connections.values():
            at = np.array([item.predecessor_body])
            points.append(frames.points(at, item.predecessor_frame[:3, 3:])[:, :, 0].T)
        points.append(frames.points(np.array([body]), placement[:3, 3:])[:, :, 0].T)
        cloud = np.concatenate(points)
        size = float(np.linalg.norm(cloud.max(axis=0) - cloud.min(axis=0)))
        mean = float(np.mean(distances)) if distances else 0.0
        if mean > 1e-3 * size:
            return mean
        return size / 4 if size > 0 else 1.0

    @cached_property
    def _zero(self) -> tuple[Poses, float]:
        """The closed zero pose, and the scaled residual with which it closes."""
        solver = Solver(self.equations, self.length)
        tree = self.equations.tree
        start = Poses(self.equations.from_model(self.mechanism.tree.neutral[:, None]), np.zeros((3, 1)))
        if not self.equations.loops:
            return start, 0.0
        drives = self._actuator_request
        best, residual = solver.close(start, drives, np.zeros((drives.size, 1)))
        if residual < 1e-11:
            return best, residual
        free = solver.close(start, Request(), np.zeros((0, 1)))
        if free[1] < 0.5 * residual:
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
            raise AssemblyError(
                f"the loops of {self.name!r} cannot be closed, not even with all joints free: " + self._say_openings(best),
                self._openings(best),
            )
        return best, residual

    @cached_property
    def solver(self) -> Solver:
        """Closes the loops."""
        return Solver(self.equations, self.length, slack=1e-7 + 100 * self._zero[1])

    @property
    def closing_error(self) -> float:
        """How far the loops stay open at the closed zero pose [m or rad, scaled]: rounding, or the file's own."""
        return self._zero[1]

    @cached_property
    def generic_poses(self) -> Poses:
        """Three assembled poses without symmetry, near the zero pose, at which ranks and bases are decided."""
        zero = self._zero[0]
        random = np.random.default_rng(7)
        tree, solver = self.equations.tree, self.solver
        found = []
        for _ in range(3):
            pose = zero
            for _ in range(2):
                _, gradient = solver.system(Request(), pose, np.zeros((0, 1)))
                free = _null_space(gradient[:, :, 0], self.rank_tolerance)[0]
                v = free @ random.standard_normal(free.shape[1])
                v = v * solver.column_scale * (0.12 / max(float(np.abs(v).max(initial=0.0)), 1e-9))
                moved = Poses(tree.integrate(pose.x, v[:, None]), pose.c)
                pose = solver.close(moved, Request(), np.zeros((0, 1)))[0]
            found.append(pose)
        return Poses(np.hstack([pose.x for pose in found]), np.hstack([pose.c for pose in found]))

    @property
    def rank_tolerance(self) -> float:
        """Relative singular value below which a direction counts as dependent; above what the file's rounding leaves."""
        return max(1e-7, 30 * self.closing_error)

    @cached_property
    def mobility(self) -> Mobility:
        """Mobility of the platform, local freedoms and redundant constraints."""
        ranks, gaps, platforms = [], [], []
        solver, tree = self.solver, self.equations.tree
        for k in range(self.generic_poses.x.shape[1]):
            pose = self.generic_poses.take(np.array([k]))
            _, gradient = solver.system(Request(), pose, np.zeros((0, 1)))
            free, rank, gap = _null_space(gradient[:, :, 0], self.rank_tolerance)
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
        return world_frames(self.mechanism, self.mechanism.tree.forward(self._model_q(self._zero[0])))

    @cached_property
    def beams(self) -> dict[str, BeamModel]:
        """All beams by name."""
        return make_beam_models(self.mechanism, self.topology.beams, self.zero_frames)

    @cached_property
    def weights(self) -> Weights:
        """Everything that weighs something."""
        return Weights(self)

    @cached_property
    def branches(self) -> tuple[Branch, ...]:
        """The passive joints of all dead branches."""
        return dead_joints(self)

    def passive_joints(self, owner: str) -> list[str]:
        """Return the passive joints of a limb, or of what hangs on ``base`` or ``platform``."""
        names = [item.joint for item in self.branches if item.owner == owner]
        for limb in self.topology.limbs:
            if limb.name == owner:
                for edge in limb.path:
                    if edge.joint is not None:
                        connection = self.mechanism.connections[edge.joint]
                        if connection.kind != "fixed" and not connection.driven:
                            names.append(edge.joint)
        return names

    @cached_property
    def limb_groups(self) -> tuple[LimbGroup, ...]:
        """Equal limbs stacked, with their wrench bases, which are fixed once per robot."""
        frames = world_frames(self.mechanism, self.mechanism.tree.forward(self._model_q(self.generic_poses)))
        return make_limb_groups(self, frames)

    # ---- coordinates ------------------------------------------------------------------------------------------------

    @cached_property
    def _actuator_request(self) -> Request:
        columns, coordinates, loops = [], [], []
        names = [loop.name for loop in self.equations.loops]
        for name in self.description.driven:
            if name in names:
                loops.append(names.index(name))
            else:
                joint = self.equations.joint_of_body[self.mechanism.body_of_joint[name]]
                columns.append(joint.first_v)
                coordinates.append((joint.first_q, joint.kind == "continuous"))
        return Request(tuple(columns), tuple(coordinates), tuple(loops))

    @property
    def _actuator_names(self) -> list[str]:
        """Driven joints in the order of the request: those of the tree, then loops."""
        loops = [loop.name for loop in self.equations.loops]
        return sorted(self.description.driven, key=lambda name: name in loops)

    def joint_coordinates(self, q: Array, frames: Frames) -> dict[str, Array]:
        """Return the coordinate (N,) of every one-freedom joint and loop [m, rad]."""
        result: dict[str, Array] = {}
        by_body = {joint.body: joint for joint in self.mechanism.tree.joints}
        for name, body in self.mechanism.body_of_joint.items():
            joint = by_body[body]
            if joint.kind == "continuous":
                result[name] = np.arctan2(q[joint.first_q + 1], q[joint.first_q])
            elif joint.kind in ("revolute", "prismatic"):
                result[name] = q[joint.first_q]
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
        zero pose, or from ``near``.

        Args:
            actuators: coordinates of all driven joints by name [m, rad] (forward kinematics); all zero if neither these nor
                ``platform`` are given.
            platform: as many platform coordinates as the mobility (inverse kinematics): ``x y z`` of o [m] and orientation [rad]
                in world axes.
            orientation: what ``rx ry rz`` mean: None or "rotation_vector"; an Euler sequence such as "XYZ" (moving axes) or "xyz"
                (fixed axes); or "tilt_torsion" for ``azimuth tilt torsion``.
            near: where the straight line starts; one pose, or a batch of the same shape.
            tolerance: how far loops may stay open [m, rad]. Overconstrained files with rounded angles need a larger one; their
                loops are then closed in the least-squares sense.
            on_failure: "raise" or "nan"; default: raise for one pose, NaN and a status for a batch.

        Raises:
            CoordinatesError: unknown, missing or too many coordinates, or ones that do not determine the pose.
            AssemblyError: the pose cannot be reached; the message says which loop stays open and by how much.
        """
        if actuators is not None and platform is not None:
            raise CoordinatesError("give either actuators= or platform=, not both")
        _check_choice("on_failure", on_failure, ("raise", "nan"))
        if not tolerance > 0:
            raise ArgumentError(f"tolerance is {tolerance}; it must be a positive length [m] and angle [rad]")
        convention = orientation_named(orientation)
        if platform is not None:
            request, names = self._platform_request(platform, orientation)
            given: Mapping[str, ArrayLike] = platform
        else:
            given = actuators if actuators is not None else {name: 0.0 for name in self.description.driven}
            request, names = self._actuator_request, self._actuator_names
            self._check_actuator_names(given)
        shape, target = _stack([given[name] for name in names], names)
        raising = on_failure == "raise" or (on_failure is None and shape == ())
        start = self._zero[0]
        if near is not None:
            if near.robot is not self:
                raise ArgumentError("near= is a configuration of another robot")
            if near.shape not in ((), shape):
                raise ArgumentError(f"near= has the batch shape {near.shape}; it must be () or {shape}")
            start = near.poses
        N = target.shape[1]
        x, c = np.empty((self.equations.tree.nq, N)), np.empty((3, N))
        arrived, gone = np.empty(N, dtype=bool), np.empty(N)
        for first in range(0, N, CHUNK):
            part = slice(first, min(first + CHUNK, N))
            mine = start if start.x.shape[1] == 1 else Poses(start.x[:, part], start.c[:, part])
            poses, arrived[part], gone[part] = self.solver.follow(request, mine, target[:, part])
            x[:, part], c[:, part] = poses.x, poses.c
        poses = Poses(x, c)
        if raising and not np.all(arrived):
            worst = int(np.argmin(arrived))
            self._say_unreachable(request, names, poses.take(np.array([worst])), target[:, [worst]], float(gone[worst]))
        return self._configuration(
            poses, shape, arrived, orientation if platform is not None else None, convention, tolerance, raising
        )

    def configuration(self, q: ArrayLike, *, tolerance: float = 1e-10, on_failure: str | None = None) -> Configuration:
        """Return the pose at Pinocchio coordinates ``q`` (…, nq) that close the loops already.

        Raises:
            ArgumentError: the size is wrong.
            AssemblyError: the loops are open by more than ``tolerance`` [m, rad].
        """
        _check_choice("on_failure", on_failure, ("raise", "nan"))
        array = np.array(q, dtype=float)
        if array.ndim == 0 or array.shape[-1] != self.mechanism.tree.nq:
            raise ArgumentError(f"q has the shape {array.shape}; the last axis must be nq = {self.mechanism.tree.nq}")
        shape = array.shape[:-1]
        flat = np.ascontiguousarray(np.moveaxis(array.reshape(-1, array.shape[-1]), -1, 0))
        poses = Poses(self.equations.from_model(flat), np.zeros((3, flat.shape[1])))
        good = np.all(np.isfinite(flat), axis=0)
        raising = on_failure == "raise" or (on_failure is None and shape == ())
        return self._configuration(poses, shape, good, None, orientation_named(None), tolerance, raising, flat)

    def _model_q(self, poses: Poses) -> Array:
        near = np.broadcast_to(self.mechanism.tree.neutral[:, None], (self.mechanism.tree.nq, poses.x.shape[1]))
        return self.equations.to_model(poses.x, near)

    def _configuration(
        self,
        poses: Poses,
        shape: tuple[int, ...],
        arrived: NDArray[np.bool_],
        orientation: str | None,
        convention: Any,
        tolerance: float,
        raising: bool,
        q: Array | None = None,
    ) -> Configuration:
        if q is None:
            q = self._model_q(poses)
        frames = world_frames(self.mechanism, self.mechanism.tree.forward(q))
        residual, _ = self.equations.evaluate(frames)
        openings = self.equations.openings(residual)
        closed = np.ones(q.shape[1], dtype=bool)
        for metres, radians in openings.values():
            closed &= (metres <= tolerance) & (radians <= tolerance)
        if raising and not np.all(closed & arrived):
            worst = int(np.argmin(closed & arrived))
            self._say_open({name: (float(a[worst]), float(b[worst])) for name, (a, b) in openings.items()}, tolerance)
        reached = arrived & closed
        q = np.where(reached, q, np.nan)
        q.setflags(write=False)
        return Configuration(self, shape, convention, poses, q, frames, openings, reached)

    # ---- complaints -------------------------------------------------------------------------------------------------

    def _check_actuator_names(self, given: Mapping[str, ArrayLike]) -> None:
        driven = self.description.driven
        for name in given:
            if name not in driven:
                raise CoordinatesError(f"no driven joint {name!r}: {near_names(name, driven)}", self.mobility.platform)
        missing = [name for name in driven if name not in given]
        if missing:
            raise CoordinatesError(
                f"actuator values are missing for {', '.join(missing)}; the robot has {len(driven)} driven joints",
                self.mobility.platform,
            )

    def _platform_request(self, platform: Mapping[str, ArrayLike], orientation: str | None) -> tuple[Request, list[str]]:
        convention = orientation_named(orientation)
        known = ("x", "y", "z", *convention.names)
        for name in platform:
            if name not in known:
                raise CoordinatesError(
                    f"no platform coordinate {name!r} with orientation {convention.name!r}: {near_names(name, known)}",
                    self.mobility.platform,
                )
        mobility = self.mobility.platform
        if len(platform) != mobility:
            raise CoordinatesError(
                f"{len(platform)} platform coordinates are given ({', '.join(platform) or 'none'}), but the mobility of "
                f"{self.name!r} is {mobility}: give exactly {mobility} of {', '.join(known)}",
                mobility,
            )
        positions = tuple(k for k, name in enumerate("xyz") if name in platform)
        angles = tuple(k for k, name in enumerate(convention.names) if name in platform)
        request = Request(positions=positions, angles=angles, orientation=convention)
        if request not in self._determined:
            self._determined[request] = self._determines(request, self.generic_poses)
        if not self._determined[request]:
            raise CoordinatesError(
                f"the coordinates {', '.join(platform)} do not determine the pose of {self.name!r}: with them held the platform "
                f"can still move; its mobility is {mobility}",
                mobility,
            )
        return request, ["xyz"[k] for k in positions] + [convention.names[k] for k in angles]

    def _determines(self, request: Request, poses: Poses) -> bool:
        """Whether the requested coordinates leave the platform no freedom, at any of the poses."""
        for k in range(poses.x.shape[1]):
            pose = poses.take(np.array([k]))
            if request.orientation is not None:
                R, _ = self.solver.platform_pose(self.equations.forward(pose.x))
                pose = Poses(pose.x, request.orientation.coordinates(R))
            _, gradient = self.solver.system(request, pose, self.solver.values(request, pose))
            free = _null_space(gradient[:, :, 0], self.rank_tolerance)[0]
            moving = self._platform_map(pose) @ free[: self.equations.tree.nv]
            if float(np.abs(moving).max(initial=0.0)) < 1e-6:
                return True
        return False

    def _openings(self, pose: Poses) -> dict[str, tuple[float, float]]:
        residual, _ = self.equations.evaluate(self.equations.forward(pose.x))
        return {name: (float(a[0]), float(b[0])) for name, (a, b) in self.equations.openings(residual).items()}

    def _say_openings(self, pose: Poses) -> str:
        return _openings_text(self._openings(pose))

    def _say_unreachable(self, request: Request, names: list[str], pose: Poses, target: Array, gone: float) -> None:
        mobility = self.mobility.platform
        nearest, _ = self.solver.close(pose, request, target, weight=1e3)
        wanted = ", ".join(f"{name} = {value:.6g}" for name, value in zip(names, target[:, 0], strict=True))
        raise AssemblyError(
            f"{self.name!r} (mobility {mobility}) cannot reach {wanted}: on the straight line from the start the loops close "
            f"up to {100 * gone:.1f} % of the way; at the target {self._say_openings(nearest)}",
            self._openings(nearest),
            mobility,
        )

    def _say_open(self, openings: dict[str, tuple[float, float]], tolerance: float) -> None:
        worst = max(max(pair) for pair in openings.values())
        text = f"the loops of {self.name!r} do not close: {_openings_text(openings)}, more than the tolerance {tolerance:g}"
        if self.mobility.redundant_constraints and worst < 1e-2:
            text += (
                f". The robot is overconstrained (by {self.mobility.redundant_constraints}), and such loops cannot close when "
                "the file's angles or lengths are rounded, which is the likely reason: write them with full precision, as "
                f"${{pi/2}} in xacro, or accept the gap with tolerance={10 ** np.ceil(np.log10(worst)):.0e}"
            )
        raise AssemblyError(text, openings, self.mobility.platform)


def _openings_text(openings: Mapping[str, tuple[float, float]]) -> str:
    worst = sorted(openings.items(), key=lambda item: -max(item[1]))
    shown = [
        f"loop {name!r} stays {metres:.3g} m" + (f" and {radians:.3g} rad" if radians > 0 else "")
        for name, (metres, radians) in worst[:3]
        if max(metres, radians) > 0.01 * max(worst[0][1])
    ]
    return ", ".join(shown) + " open" if shown else "no loop stays open"


def _null_space(matrix: Array, tolerance: float) -> tuple[Array, int, float]:
    """Return an orthonormal basis of the null space (n, k), the rank, and the gap between kept and dropped values."""
    if matrix.size == 0:
        return np.eye(matrix.shape[1]), 0, np.inf
    _, values, rows = np.linalg.svd(matrix, full_matrices=True)
    rank = int(np.sum(values > tolerance * values[0])) if values[0] > 0 else 0
    dropped = float(values[rank]) if rank < len(values) else 0.0
    gap = float(values[rank - 1]) / dropped if rank and dropped > 0 else np.inf
    return np.ascontiguousarray(rows[rank:].T), rank, gap


def _stack(values: list[ArrayLike], names: list[str]) -> tuple[tuple[int, ...], Array]:
    """Broadcast coordinates against one another; return the batch shape and the (n, N) targets."""
    arrays = []
    for value, name in zip(values, names, strict=True):
        try:
            arrays.append(np.asarray(value, dtype=float))
        except (TypeError, ValueError):
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


def _check_choice(name: str, value: str | None, choices: tuple[str, ...]) -> None:
    if value is not None and value not in choices:
        raise ArgumentError(f"{name} is {value!r}; it must be one of {', '.join(map(repr, choices))}")
