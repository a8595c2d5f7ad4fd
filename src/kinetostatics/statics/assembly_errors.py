"""Assembly errors: twists of joints, and excess lengths of beams, in the unloaded robot.

A joint's assembly error is a twist of its platform side relative to its base side. A beam's assembly error is an excess length
plus the thermal expansion α ΔT L. Errors along constrained directions displace the platform, and stress an overconstrained robot
(method page, section 11).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from kinetostatics.arguments import finite_numbers
from kinetostatics.description.elements import Beam
from kinetostatics.description.flexible import ElasticPart
from kinetostatics.exceptions import ArgumentError, near_names
from kinetostatics.math.arrays import Array
from kinetostatics.math.screws import move_twist, rotate
from kinetostatics.mechanism.joints import sides
from kinetostatics.mechanism.limbs import Edge
from kinetostatics.mechanism.tree import Frames
from kinetostatics.statics.robot_statics import RobotStatics

if TYPE_CHECKING:
    from kinetostatics.limbs.group import LimbGroup


JOINT_KEYS, FRAMES = ("twist", "frame"), ("world", "joint")


@dataclass(frozen=True)
class JointError:
    """Assembly error of a joint: a ``twist`` [m, rad] at the joint's centre, in world axes or in the axes of the joint frame."""

    twist: Array
    in_joint_frame: bool


@dataclass(frozen=True)
class AssemblyErrors:
    """Assembly errors by name of the joint or elastic link; those of a link by kind, such as "length" or "temperature".

    Twists are (…, 6), amounts of a kind (…, 1); for a chunk of N poses they are (6, N) and (1, N).
    """

    robot: RobotStatics
    joints: Mapping[str, JointError]
    links: Mapping[str, Mapping[str, Array]]

    def arrays(self) -> list[Array]:
        found = [item.twist for item in self.joints.values()]
        return [*found, *(amount for amounts in self.links.values() for amount in amounts.values())]

    def map(self, change: Callable[[Array], Array]) -> AssemblyErrors:
        return AssemblyErrors(
            self.robot,
            {name: replace(item, twist=change(item.twist)) for name, item in self.joints.items()},
            {name: {kind: change(amount) for kind, amount in amounts.items()} for name, amounts in self.links.items()},
        )

    @property
    def names(self) -> frozenset[str]:
        return frozenset((*self.joints, *self.links))

    def of(self, group: LimbGroup, frames: Frames, o: Array) -> Array | None:
        """Return the errors of all joints and beams of g limbs, or None without errors.

        The errors are twists (6, elements, g, N) as in :meth:`of_edge`; an element is a beam, or hinges that form one joint.
        """
        if not any(self.concerns(edge) for limb in group.limbs for edge in limb.edges):
            return None
        result = np.zeros((6, len(group.elements[0]), len(group.limbs), o.shape[1]))
        for position, (limb, elements) in enumerate(zip(group.limbs, group.elements, strict=True)):
            for k, element in enumerate(elements):
                for edge in element.edges:
                    result[:, k, position] += self.of_edge(limb.edges[edge], frames, o)
        return result

    def concerns(self, edge: Edge) -> bool:
        return edge.joint in self.joints or bool(self._of_link(edge))

    def _of_link(self, edge: Edge) -> Mapping[str, Array]:
        return {} if edge.span is None else self.links.get(self.robot.topology.part_of(edge), {})

    def of_edge(self, edge: Edge, frames: Frames, o: Array) -> Array:
        """Return the error of a joint or beam: the twist (6, N) of its outboard side relative to its inboard side, about o."""
        if edge.joint in self.joints:
            return self._of_joint(edge, self.joints[str(edge.joint)], frames, o)
        result = np.zeros((6, o.shape[1]))
        for kind, amount in self._of_link(edge).items():
            link = self.robot.elastic_links[str(edge.span)]
            result += move_twist(link.misfit(frames, kind) * amount[0], o - link.ends(frames)[1])
        return result

    def _of_joint(self, edge: Edge, assembly_error: JointError, frames: Frames, o: Array) -> Array:
        connection = self.robot.mechanism.connections[str(edge.joint)]
        turned = edge.both_ways and edge.sign < 0
        twist = -assembly_error.twist if turned else assembly_error.twist
        if assembly_error.in_joint_frame:
            body, frame = connection.predecessor_body, connection.predecessor_frame
            axes = frames.orientations(np.array([body]), frame[:3, :3, None])[:, :, 0]
            twist = rotate(axes, twist)
        body, frame = sides(edge, connection)[0 if turned else 1]  # reference point of the joint's reported wrench
        centre = frames.point(body, frame[:3, 3])
        return move_twist(twist, o - centre)


def parse_assembly_errors(robot: RobotStatics, assembly_errors: Mapping[str, object]) -> AssemblyErrors:
    """Check the argument ``assembly_errors`` of an analysis.

    Raises:
        ArgumentError: a name is unknown, a shape is wrong, or a value is not finite.
    """
    if not isinstance(assembly_errors, Mapping):
        raise ArgumentError(f"assembly_errors= needs a mapping from names of joints and beams, got {assembly_errors!r}")
    joints: dict[str, JointError] = {}
    links: dict[str, dict[str, Array]] = {}
    known_joints = robot.mechanism.connections
    known_links = {name: link for name, link in robot.description.elastic_links.items() if link.errors}
    for name, value in assembly_errors.items():
        # a joint and a beam may have the same name
        is_joint = not isinstance(value, Mapping) or bool(set(value) & set(JOINT_KEYS))
        if name in known_joints and (is_joint or name not in known_links):
            if name not in robot.joint_table.names:
                raise ArgumentError(
                    f"joint {name!r} lies within the rigid base or platform, or carries nothing: its assembly error has no "
                    "effect; specify errors of the joints between the limbs and the base or platform"
                )
            joints[name] = _joint_error(name, value)
        elif name in known_links:
            links[name] = _link_error(known_links[name], value)
        else:
            known = near_names(name, [*known_joints, *known_links])
            raise ArgumentError(f"assembly_errors= names no joint or beam {name!r}: {known}")
    return AssemblyErrors(robot, joints, links)


def _link_error(link: Beam | ElasticPart, value: object) -> dict[str, Array]:
    if not isinstance(value, Mapping) or not value or set(value) - {"length", "temperature"}:
        raise ArgumentError(
            f"the assembly error of beam {link.name!r} is {value!r}; it must be a mapping with 'length' [m] or 'temperature' [K]"
        )
    amounts = {kind: finite_numbers(f"{kind} of {link.name!r}", amount) for kind, amount in value.items()}
    if "temperature" not in link.errors and np.any(amounts.get("temperature", 0.0)):
        raise ArgumentError(
            f"beam {link.name!r} has no thermal_expansion, so that temperature has no effect: write thermal_expansion [1/K] "
            "in its <beam> element (steel: 1.2e-5)"
        )
    return {kind: amount[..., None] for kind, amount in amounts.items()}


def _joint_error(name: str, value: object) -> JointError:
    what, frame = f"the assembly error of joint {name!r}", "world"
    if isinstance(value, Mapping):
        if "twist" not in value or set(value) - set(JOINT_KEYS):
            raise ArgumentError(f"{what} is {value!r}; it must be a twist, or a mapping with 'twist' and 'frame'")
        frame, value = value.get("frame", "world"), value["twist"]
    if not isinstance(frame, str) or frame not in FRAMES:
        raise ArgumentError(f"the frame of {what} is {frame!r}; it must be 'world' or 'joint'")
    twist = finite_numbers(what, value)
    if twist.ndim == 0 or twist.shape[-1] != 6:
        raise ArgumentError(f"{what} has the shape {twist.shape}; its last axis must have 6 entries")
    return JointError(twist, frame == "joint")
