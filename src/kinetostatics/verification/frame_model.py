"""Frame of a robot at one pose, built only from the robot's file and the poses of its links. SI units, world axes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from kinetostatics.arguments import numbers
from kinetostatics.description.joint_types import Axes
from kinetostatics.description.loads import LinkLoad, Payload
from kinetostatics.math.arrays import Array
from kinetostatics.math.linalg import axis_across
from kinetostatics.verification.frame import (
    Actuator,
    Coordinate,
    FrameBeam,
    FrameJoint,
    FrameMass,
    FrameModel,
    PointSpring,
    axes_along,
    joint_assembly_error,
    joint_springs,
    releases,
)
from kinetostatics.verification.pieces import JointedPieces, PlacedBeam, RigidPieces

if TYPE_CHECKING:
    from kinetostatics.description.elements import Spring
    from kinetostatics.kinematics.configuration import Configuration
    from kinetostatics.load_case import LoadCase


def build(configuration: Configuration, case: LoadCase) -> FrameModel:
    """Build the frame of a single pose under a load case, which is read independently of the analysis."""
    return _FrameBuilder(configuration, case.assembly_errors or {}).build(case)


class _FrameBuilder:
    def __init__(self, configuration: Configuration, assembly_errors: Mapping[str, object]) -> None:
        self.configuration = configuration
        self.description = configuration.robot.description
        self.assembly_errors = assembly_errors
        self.pieces = RigidPieces(configuration)
        self.roots: list[int] = []
        masters = {joint.mimic.joint for joint in self.description.joints.values() if joint.mimic is not None}
        self.followed = masters & set(self.description.joint_stiffness)

    def number(self, piece: int) -> int:
        root = self.pieces.find(piece)
        if root not in self.roots:
            self.roots.append(root)
        return self.roots.index(root)

    def build(self, case: LoadCase) -> FrameModel:
        load, gravity, payload = np.asarray(case.load, dtype=float), np.asarray(case.gravity, dtype=float), case.payload
        base, platform = self.number(self.pieces.base), self.number(self.pieces.platform)
        joints, coordinates = [], {}
        for number, jointed in enumerate(self.pieces.jointed):
            if self.pieces.find(jointed.pieces[0]) == self.pieces.find(jointed.pieces[1]):
                continue
            outward = self.pieces.predecessor_is_inner(number)
            joints.append(self._joint(jointed, outward))
            joint = jointed.joint
            if joint.locked:
                sign = 1.0 if outward else -1.0
                coordinates[joint.name] = Coordinate(joint.name, sign * joint.axis, not joint.type.is_slide)
        beams = [self._beam(placed, gravity) for placed in self.pieces.beams.values()]
        masses = list(self._link_masses())
        point_forces = [(body.piece, body.centre, body.mass * gravity) for body in masses]
        acting = list(self._link_loads(case.loads or {}))
        if payload is not None:
            carried = self._payload_mass(payload)
            masses.append(carried)
            acting.append((carried.piece, np.append(carried.mass * gravity, np.zeros(3)), carried.centre))
        springs = [self._spring(spring) for spring in self.description.springs.values()]
        for spring, force in springs:
            point_forces += [(spring.pieces[0], spring.points[0], force), (spring.pieces[1], spring.points[1], -force)]
        o, references = self._references(platform, beams, joints)
        loads = np.zeros((len(references), 6))
        R = self.configuration.platform_frame[:3, :3] if case.frame == "platform" else np.eye(3)
        at = o
        if case.point is not None:
            at = np.asarray(case.point, dtype=float)
            at = o + R @ at if case.frame == "platform" else at
        acting.append((platform, np.append(R @ load[:3], R @ load[3:]), at))
        for piece, wrench, at in [*acting, *((piece, np.append(force, np.zeros(3)), at) for piece, at, force in point_forces)]:
            loads[piece] += np.append(wrench[:3], wrench[3:] + np.cross(at - references[piece], wrench[:3]))
        return FrameModel(
            base,
            platform,
            references,
            loads,
            tuple(beams),
            tuple(joints),
            tuple(self._actuators(coordinates)),
            *_sizes(o, platform, references, beams, joints),
            tuple(spring for spring, _ in springs),
            tuple(point_forces),
            self.pieces.outside_limbs,
            masses=tuple(masses),
        )

    def _link_loads(self, on_links: Mapping[str, object]) -> Iterator[tuple[int, Array, Array]]:
        """Yield the loads on links, each as piece, wrench (6,), point of application (3,)."""
        for link, value in on_links.items():
            loads = value if isinstance(value, (list, tuple)) and any(isinstance(given, LinkLoad) for given in value) else [value]
            for given in loads:
                load = given if isinstance(given, LinkLoad) else LinkLoad(numbers(link, given))
                frame, wrench = self.configuration.frame(link), np.asarray(load.wrench, dtype=float)
                R = frame[:3, :3] if load.frame == "link" else np.eye(3)
                at = frame[:3, :3] @ np.asarray(load.point, dtype=float) + frame[:3, 3]
                yield self._loaded_piece(link, at), np.append(R @ wrench[:3], R @ wrench[3:]), at

    def _payload_mass(self, payload: Payload) -> FrameMass:
        link = payload.link or self.description.platform
        frame = self.configuration.platform_frame if payload.link is None else self.configuration.frame(link)
        R, at = frame[:3, :3], frame[:3, :3] @ np.asarray(payload.center, dtype=float) + frame[:3, 3]
        inertia = np.zeros((3, 3)) if payload.inertia is None else R @ payload.inertia.matrix @ R.T
        return FrameMass(self._loaded_piece(link, at), at, float(np.asarray(payload.mass)), inertia)

    def _link_masses(self) -> Iterator[FrameMass]:
        for link in self.description.links.values():
            if self.pieces.is_rigid(link.name) and link.mass > 0:
                R, piece = self.configuration.frame(link.name)[:3, :3], self.number(self.pieces.of_link(link.name))
                yield FrameMass(piece, self._centre_of_mass(link.name), link.mass, R @ link.inertia.matrix @ R.T)

    def _spring(self, spring: Spring) -> tuple[PointSpring, Array]:
        """Return the spring between its two pieces, and its force (3,) on its first end at the pose [N]."""
        ends = (spring.predecessor, spring.predecessor_point), (spring.successor, spring.successor_point)
        frames = [self.configuration.frame(link) for link, _ in ends]
        points = [frame[:3, :3] @ np.array(local) + frame[:3, 3] for frame, (_, local) in zip(frames, ends, strict=True)]
        pieces = [self._loaded_piece(link, point) for (link, _), point in zip(ends, points, strict=True)]
        span = points[1] - points[0]
        length = float(np.linalg.norm(span))
        tension = spring.preload + spring.stiffness * (length - spring.free_length)
        axes = axes_along(span, axis_across(span / length))
        # along the spring its stiffness, across it tension / length
        stiffness = np.array([spring.stiffness, tension / length, tension / length])
        return PointSpring((pieces[0], pieces[1]), np.array(points), axes, stiffness), tension * axes[:, 0]

    def _loaded_piece(self, link: str, point: Array) -> int:
        """Return the piece on which a load at a point of a link acts: in an elastic link, the piece at the nearest beam end."""
        if self.pieces.is_rigid(link):
            return self.number(self.pieces.of_link(link))
        beams = [self.pieces.beams[name] for name, beam in self.description.beams.items() if beam.link == link]
        ends = [end for beam in beams for end in zip(beam.points, beam.pieces, strict=True)]
        return self.number(min(ends, key=lambda end: float(np.linalg.norm(end[0] - point)))[1])

    def _actuators(self, coordinates: Mapping[str, Coordinate]) -> Iterator[Actuator]:
        for name in self.description.actuated:
            if name in coordinates:
                followers = [
                    (joint.mimic.multiplier, coordinates[joint.name])
                    for joint in self.description.joints.values()
                    if joint.mimic is not None and joint.mimic.joint == name and joint.name in coordinates
                ]
                stiffness = self.description.joint_stiffness[name].drive if name in self.followed else None
                yield Actuator(name, ((1.0, coordinates[name]), *followers), np.inf if stiffness is None else stiffness)

    # ---- joints and beams -------------------------------------------------------------------------------------------

    def _joint(self, jointed: JointedPieces, outward: bool) -> FrameJoint:
        joint = jointed.joint
        elastic = self.description.joint_stiffness.get(joint.name)
        if elastic is not None and joint.name in self.followed:
            elastic = replace(elastic, drive=None)  # its actuator moves several joints
        axes, free = releases(joint, elastic)
        first, second = (self.number(piece) for piece in jointed.pieces)
        # the origins of the two frames differ in joints that slide
        centre = joint.frames[1 if outward else 0][:3, 3]
        assembly_error = joint_assembly_error(self.assembly_errors.get(joint.name), joint)
        cross = (joint.axis, joint.axis2) if outward else (joint.axis2, joint.axis)
        return FrameJoint(
            joint.name,
            (first, second) if outward else (second, first),
            centre,
            axes,
            ~free,
            joint_springs(joint, elastic),
            assembly_error,
            cross if joint.type.turns is Axes.BOTH and np.count_nonzero(free[3:]) == 2 else None,
        )

    def _beam(self, placed: PlacedBeam, gravity: Array) -> FrameBeam:
        beam = self.description.beams[placed.name]
        frame = self.configuration.frame(beam.link)[:3, :3]
        outward = self.pieces.start_is_inner(placed.name)
        points = placed.points if outward else placed.points[::-1]
        span = points[1] - points[0]
        length = float(np.linalg.norm(span))
        # without y_axis the section is isotropic
        axes = axes_along(span, frame @ np.array(beam.y_axis) if beam.y_axis is not None else axis_across(span / length))
        E, G, section = beam.youngs_modulus, beam.shear_modulus, beam.section
        shear_y, shear_z = beam.shear_areas
        stiffness = (E * section.area, G * shear_y, G * shear_z, G * section.J, E * section.I_y, E * section.I_z)
        first, second = (self.number(piece) for piece in placed.pieces)
        assembly_error = self.assembly_errors.get(placed.name)
        length_error = 0.0
        if isinstance(assembly_error, Mapping) and not {"twist", "frame"} & set(assembly_error):
            rise = float(assembly_error.get("temperature", 0))
            length_error = float(assembly_error.get("length", 0)) + beam.thermal_expansion * rise * length
        lever, mass = self._lever(placed), self._mass(placed.name) / length
        return FrameBeam(
            placed.name,
            (first, second) if outward else (second, first),
            points,
            axes,
            stiffness,
            mass * np.append(gravity, np.cross(lever, gravity)),
            length_error,
            lever,
            mass,
        )

    # ---- weights and points -----------------------------------------------------------------------------------------

    def _mass(self, name: str) -> float:
        """Return a beam's mass [kg]: from its density, or else its share of the link's mass in proportion to the length."""
        beam = self.description.beams[name]

        def length(other: str) -> float:
            points = self.pieces.beams[other].points
            return float(np.linalg.norm(points[1] - points[0]))

        if beam.density is not None:
            return beam.density * beam.section.area * length(name)
        siblings = [other.name for other in self.description.beams.values() if other.link == beam.link]
        return self.description.links[beam.link].mass * length(name) / sum(map(length, siblings))

    def _lever(self, placed: PlacedBeam) -> Array:
        """Return the vector (3,) [m] from the centroid of a link's beams to the link's centre of mass; 0 with a given density."""
        beam = self.description.beams[placed.name]
        if beam.density is not None:
            return np.zeros(3)
        ends = [self.pieces.beams[other.name].points for other in self.description.beams.values() if other.link == beam.link]
        lengths = [float(np.linalg.norm(end - start)) for start, end in ends]
        middle = np.average([(start + end) / 2 for start, end in ends], axis=0, weights=lengths)
        return self._centre_of_mass(beam.link) - middle

    def _centre_of_mass(self, link: str) -> Array:
        frame = self.configuration.frame(link)
        return np.asarray(frame[:3, :3] @ np.array(self.description.links[link].center_of_mass) + frame[:3, 3])

    def _references(self, platform: int, beams: Sequence[FrameBeam], joints: Sequence[FrameJoint]) -> tuple[Array, Array]:
        o = self.configuration.platform_frame[:3, 3]
        for link in self.description.links:
            if self.pieces.is_rigid(link):
                self.number(self.pieces.of_link(link))
        points: dict[int, Array] = {platform: o}
        for piece, point in _attachments(beams, joints):
            points.setdefault(piece, point)
        return o, np.array([points.get(number, o) for number in range(len(self.roots))])


def _attachments(beams: Sequence[FrameBeam], joints: Sequence[FrameJoint]) -> list[tuple[int, Array]]:
    """Return (piece, point [m]) for every end of a beam and for both pieces of every joint."""
    ends = [(piece, point) for beam in beams for piece, point in zip(beam.pieces, beam.points, strict=True)]
    return ends + [(piece, joint.point) for joint in joints for piece in joint.pieces]


def _sizes(
    o: Array, platform: int, references: Array, beams: Sequence[FrameBeam], joints: Sequence[FrameJoint]
) -> tuple[float, float]:
    """Return ``size`` and ``length`` [m] of :class:`FrameModel`."""
    points = _attachments(beams, joints)
    cloud = np.array([o, *references, *(point for _, point in points)])
    size = float(np.linalg.norm(cloud.max(axis=0) - cloud.min(axis=0))) or 1.0
    distances = [float(np.linalg.norm(point - o)) for piece, point in points if piece == platform]
    mean = float(np.mean(distances)) if distances else 0.0
    return size, mean if mean > 1e-3 * size else size
