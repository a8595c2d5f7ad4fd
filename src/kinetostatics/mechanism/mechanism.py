"""A robot as bodies and the joints between them: the Pinocchio model, and all joints and loops with their frames on both sides.

A *connection* is a joint of the tree or a loop; most other modules do not distinguish between the two.
"""

from __future__ import annotations

import contextlib
import os
import sys
import threading
import weakref
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from kinetostatics.description.fields import Place, Vector
from kinetostatics.description.joint_types import JOINT_TYPES, Axes, JointType
from kinetostatics.description.joints import Cone, Joint, Loop, Mimic
from kinetostatics.description.robot_description import RobotDescription
from kinetostatics.description.validation import validate
from kinetostatics.exceptions import RobotFileError
from kinetostatics.math.arrays import Array
from kinetostatics.mechanism.tree import Frames, Tree, TreeJoint

if TYPE_CHECKING:
    import pinocchio as pin

#: ``data``: Pinocchio's working data for each mechanism, separate for each thread.
_of_thread = threading.local()


@dataclass(frozen=True)
class Connection:
    """A joint or loop between two links.

    Attributes:
        predecessor, successor: the two links; parent and child of a tree joint.
        predecessor_body, successor_body: bodies of these links.
        predecessor_frame, successor_frame: the joint's frame (4, 4) in the body of the predecessor, and of the successor.
        axis, axis2: (3,) unit vectors, in the joint frames of predecessor and successor.
        lower, upper: limits of a one-freedom joint [m, rad].
        cone: limit of a universal or spherical loop.
        actuated: whether the joint is locked in the statics: it is actuated itself, or mimics another joint.
        is_loop: whether the connection closes a loop of the file's tree.
        place: file and line.
        mimic: how the joint mimics an actuated joint, without an actuator force of its own; None if it does not.
    """

    name: str
    type: JointType
    predecessor: str
    successor: str
    predecessor_body: int
    successor_body: int
    predecessor_frame: Array
    successor_frame: Array
    axis: Array
    axis2: Array
    lower: float
    upper: float
    cone: Cone | None
    actuated: bool
    is_loop: bool
    place: Place
    mimic: Mimic | None = None

    def other(self, link: str) -> str:
        return self.successor if link == self.predecessor else self.predecessor

    def axis_on(self, predecessor_side: bool) -> Array:
        """Return ``axis`` (3,) in the predecessor's body, or else in the successor's body.

        The axis in the successor's body is valid only if it is fixed in both bodies, as for revolute and prismatic joints.
        """
        frame = self.predecessor_frame if predecessor_side else self.successor_frame
        return np.asarray(frame[:3, :3] @ self.axis)

    def centre_on(self, link: str) -> Array:
        """Return the joint's centre (3,) [m] in the body of ``link``."""
        frame = self.predecessor_frame if link == self.predecessor else self.successor_frame
        return np.asarray(frame[:3, 3])


@dataclass(frozen=True)
class SphericalRun:
    """Three passive revolute joints with massless links between, whose axes meet in one point: a spherical joint.

    Treating them as one joint avoids the singularity of three revolutes.

    Attributes:
        joints: names of the three joints, from parent to child.
        bodies: child bodies of the three joints.
        parent: parent body of the first joint.
        centre: (3,) common point of the axes in the parent body; it is the origin of the last joint's child body.
        axes: (3, 3) the three axes as columns, in the parent body, with all three joints at zero.
        orientation: (3, 3) orientation of the last joint's child body in the parent body, with all three joints at zero.
    """

    joints: tuple[str, str, str]
    bodies: tuple[int, int, int]
    parent: int
    centre: Array
    axes: Array
    orientation: Array


#: Lock of the standard error of the process.
_SILENT = threading.Lock()


@contextlib.contextmanager
def _silence() -> Iterator[None]:
    """Discard the output of Pinocchio's URDF parser on the standard error of the process."""
    with _SILENT:
        sys.stderr.flush()
        saved, sink = os.dup(2), os.open(os.devnull, os.O_WRONLY)
        try:
            os.dup2(sink, 2)
            yield
        finally:
            os.dup2(saved, 2)
            os.close(saved)
            os.close(sink)


def meeting_points(a: Array, p: Array, b: Array, q: Array) -> tuple[float, float] | None:
    """Return (s, t) of the intersection of two lines p + s a and q + t b; None if there is none.

    s = (q − p) × b · n / n², t = (q − p) × a · n / n² with n = a × b.
    """
    normal = np.cross(a, b)
    square = float(normal @ normal)
    size = 1.0 + float(np.linalg.norm(q - p))
    if square < 1e-12 or abs(float(normal @ (q - p))) > 1e-9 * size:
        return None
    return float(np.cross(q - p, b) @ normal) / square, float(np.cross(q - p, a) @ normal) / square


def _connection(
    joint: Joint | Loop,
    actuated: bool,
    sides: tuple[str, str, int, int, Array, Array],
    axis2: Vector,
    cone: Cone | None = None,
    mimic: Mimic | None = None,
) -> Connection:
    axes, limits = (np.array(joint.axis), np.array(axis2)), (joint.lower, joint.upper)
    return Connection(
        joint.name, JOINT_TYPES[joint.type], *sides, *axes, *limits, cone, actuated, isinstance(joint, Loop), joint.place, mimic
    )


class Mechanism:
    """Bodies, connections and the spanning tree of a robot, independent of its pose.

    Attributes:
        model: Pinocchio's model of the tree, with the inertias of the URDF elements.
        connections: all joints and loops by name, fixed ones too, in the order of the file, loops last.
        body_of: body of every link, and the link's placement (4, 4) in this body.
        tree: the tree in Pinocchio's coordinates.
        platform_frame: body of the platform, and placement (4, 4) of the frame o-xyz in this body.
        base_frame: body and placement of a base link that moves relative to the root of the tree; the world frame is then the
            base link's. None: the base link is fixed to the root; the world frame is the root link's.
    """

    NOT_RECORDED = ("model", "at_link", "link_inertias")

    def __init__(self, description: RobotDescription) -> None:
        import pinocchio as pin

        self.description = description = validate(description)
        try:
            with _silence():
                self.model: pin.Model = pin.buildModelFromXML(description.urdf)
        except (ValueError, RuntimeError) as error:
            raise RobotFileError(f"Pinocchio cannot read the URDF part of the file: {error}", description.path) from None
        model = self.model
        links = (frame for frame in model.frames if frame.type == pin.FrameType.BODY)
        self.body_of: dict[str, tuple[int, Array]] = {
            frame.name: (int(frame.parentJoint), np.array(frame.placement.homogeneous)) for frame in links
        }
        numbers = {name: index for index, name in enumerate(model.names)}
        self.body_of_joint = {name: numbers[name] for name in description.joints if name in numbers}
        self.connections: dict[str, Connection] = {}
        for joint in description.joints.values():
            (body, frame), (child_body, child_frame) = self.body_of[joint.parent], self.body_of[joint.child]
            sides = joint.parent, joint.child, body, child_body, frame @ joint.origin.matrix, child_frame
            actuated = joint.name in description.actuated or joint.mimic is not None
            self.connections[joint.name] = _connection(joint, actuated, sides, (0.0, 1.0, 0.0), mimic=joint.mimic)
        for loop in description.loops.values():
            (body, frame), (other_body, other_frame) = self.body_of[loop.predecessor], self.body_of[loop.successor]
            frames = frame @ loop.predecessor_origin.matrix, other_frame @ loop.successor_origin.matrix
            sides = loop.predecessor, loop.successor, body, other_body, *frames
            self.connections[loop.name] = _connection(loop, loop.name in description.actuated, sides, loop.axis2, loop.cone)
        joints = []
        for name, body in self.body_of_joint.items():
            joint, number = description.joints[name], model.joints[body]
            axis = (0.0, 0.0, 1.0) if JOINT_TYPES[joint.type].slides is Axes.ACROSS else joint.axis  # as in Pinocchio
            placement, first = np.array(model.jointPlacements[body].homogeneous), (int(number.idx_q), int(number.idx_v))
            joints.append(TreeJoint(JOINT_TYPES[joint.type], int(model.parents[body]), body, placement, axis, *first))
        joints.sort(key=lambda joint: joint.body)
        self.tree = Tree(joints, int(model.njoints), int(model.nq), int(model.nv))
        for tree_joint in self.tree.joints:  # the zero of mimic joints includes their offset
            mimic = description.joints[model.names[tree_joint.body]].mimic
            if mimic is not None:
                tree_joint.write(mimic.offset, self.tree.neutral)
        body, frame = self.body_of[description.platform]
        self.platform_frame: tuple[int, Array] = body, frame @ description.platform_origin.matrix
        base = self.body_of[description.base]
        self.base_frame: tuple[int, Array] | None = None if base[0] == 0 else base

    def forward(self, q: Array) -> Frames:
        """Return the frames of all bodies at Pinocchio's coordinates (nq, N): one pose by Pinocchio, many by NumPy."""
        if q.shape[1] != 1 or q.dtype == object:
            return self.tree.forward(q)
        import pinocchio as pin

        if not hasattr(_of_thread, "data"):
            _of_thread.data = weakref.WeakKeyDictionary()
        if self not in _of_thread.data:
            _of_thread.data[self] = self.model.createData()
        data = _of_thread.data[self]
        pin.forwardKinematics(self.model, data, np.ascontiguousarray(q[:, 0]))
        placements = np.array([placement.homogeneous for placement in data.oMi])
        return Frames(placements[:, :3, :3].transpose(1, 2, 0)[..., None], placements[:, :3, 3].T[..., None])

    @cached_property
    def at_link(self) -> dict[str, list[Connection]]:
        result: dict[str, list[Connection]] = {name: [] for name in self.description.links}
        for connection in self.connections.values():
            result[connection.predecessor].append(connection)
            result[connection.successor].append(connection)
        return result

    def interface_on(self, link: str, name: str) -> Array:
        """Return the centre (3,) [m] of a joint, or o of base or platform (the origin of the base), in the body of ``link``."""
        connection = self.connections.get(name)
        if connection is not None and link in (connection.predecessor, connection.successor):
            return connection.centre_on(link)
        placement = self.platform_frame[1] if link == self.description.platform else self.body_of[link][1]
        return np.asarray(placement[:3, 3])

    def platform_pose(self, frames: Frames) -> tuple[Array, Array]:
        """Return the platform's orientation (3, 3, N) and the position (3, N) [m] of o, world axes."""
        body, placement = self.platform_frame
        R = frames.rotation[:, :, body]
        position = frames.position[:, body] + np.einsum("ijn,j->in", R, placement[:3, 3])
        return np.einsum("ijn,jk->ikn", R, placement[:3, :3]), position

    @cached_property
    def spherical_runs(self) -> tuple[SphericalRun, ...]:
        """All triples of consecutive revolutes of the tree, each perpendicular to the next, that form spherical joints."""
        beam_links = {beam.link for beam in self.description.elastic_links.values()}
        runs: list[SphericalRun] = []
        taken: set[str] = set()

        def turns_freely(connection: Connection) -> bool:
            return connection.type.is_hinge and not connection.actuated and not connection.is_loop

        def following(connection: Connection) -> Connection | None:
            link = connection.successor
            others = [other for other in self.at_link[link] if other is not connection]
            is_massless = self.description.links[link].mass == 0 and link not in beam_links
            return others[0] if is_massless and len(others) == 1 and turns_freely(others[0]) else None

        for first in self.connections.values():
            if not turns_freely(first) or first.name in taken:
                continue
            second = following(first)
            third = following(second) if second else None
            if second is None or third is None or second.name in taken or third.name in taken:
                continue
            run = self._spherical_run(first, second, third)
            if run is not None:
                runs.append(run)
                taken.update(run.joints)
        return tuple(runs)

    def _spherical_run(self, *three: Connection) -> SphericalRun | None:
        bodies = tuple(connection.successor_body for connection in three)
        placements = [self.model.jointPlacements[body].homogeneous for body in bodies]
        axes, points, frame = [], [], np.eye(4)
        for connection, placement in zip(three, placements, strict=True):
            frame = frame @ placement
            axes.append(frame[:3, :3] @ connection.axis)
            points.append(frame[:3, 3])
        first = meeting_points(axes[0], points[0], axes[1], points[1])
        size = 1.0 + float(np.abs(points).max())
        if first is None or max(abs(float(axes[0] @ axes[1])), abs(float(axes[1] @ axes[2]))) > 1e-9:
            return None
        centre = points[0] + first[0] * axes[0]
        if float(np.abs(centre - points[2]).max()) > 1e-12 * size:
            return None
        names, parent = (three[0].name, three[1].name, three[2].name), int(self.model.parents[bodies[0]])
        return SphericalRun(names, (bodies[0], bodies[1], bodies[2]), parent, centre, np.column_stack(axes), frame[:3, :3])
