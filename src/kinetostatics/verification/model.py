"""A robot at one pose as a frame of rigid pieces, beams and joints, from its file and the frames of its links alone.

Nothing here uses the limbs, wrenches or compliances of the package: a mistake in them must not find its way into the check. All
in SI units and world axes.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from kinetostatics.verification.frame import Drive, FrameBeam, FrameJoint, FrameModel, SpannedJoint
from kinetostatics.verification.pieces import Array, Pieces, PlacedBeam, PlacedJoint

if TYPE_CHECKING:
    from kinetostatics.configuration import Configuration

#: Which of the six directions along and about a joint's x, y, z are free; see :func:`_joint_axes`.
FREE: dict[str, tuple[int, ...]] = {
    "fixed": (),
    "revolute": (3,),
    "continuous": (3,),
    "prismatic": (0,),
    "cylindrical": (0, 3),
    "universal": (4, 5),
    "spherical": (3, 4, 5),
    "planar": (1, 2, 3),
    "floating": (0, 1, 2, 3, 4, 5),
}


def build(
    configuration: Configuration, load: Array, gravity: Array, point: Array | None = None, frame: str = "world"
) -> FrameModel:
    """Build the frame of a single pose.

    Args:
        configuration: the pose.
        load: (6,) external force and moment on the platform [N, N·m].
        gravity: (3,) [m/s²].
        point: (3,) where the force acts [m]; default o.
        frame: ``world`` or ``platform``: axes of load and point; in the platform's, the point counts from o.
    """
    return _Builder(configuration).build(load, gravity, point, frame)


class _Builder:
    def __init__(self, configuration: Configuration) -> None:
        self.configuration = configuration
        self.description = configuration.robot.description
        self.pieces = Pieces(configuration)
        self.roots: list[int] = []
        self._spanned_sign: dict[str, float] = {}

    def number(self, piece: int) -> int:
        root = self.pieces.find(piece)
        if root not in self.roots:
            self.roots.append(root)
        return self.roots.index(root)

    def build(self, load: Array, gravity: Array, point: Array | None, frame: str) -> FrameModel:
        base, platform = self.number(self.pieces.base), self.number(self.pieces.platform)
        joints = [self._joint(joint) for name, joint in self.pieces.joints.items() if name not in self.pieces.spanned]
        kept = tuple(joint for joint in joints if joint.pieces[0] != joint.pieces[1])
        beams, spanned = [], []
        for name, placed in self.pieces.beams.items():
            swapped = not self.pieces.inner_first(
                f"beam:{name}", (self.pieces.find(placed.pieces[0]), self.pieces.find(placed.pieces[1]))
            )
            placed = _turned(placed) if swapped else placed
            beams.append(self._beam(placed, gravity))
            spanned += self._spanned(placed, kept, gravity)
        weights = [
            (self.number(self.pieces.of_link(link.name)), self._weight(link.name, gravity))
            for link in self.description.links.values()
            if self.pieces.is_rigid(link.name) and link.mass > 0
        ]
        o, references = self._references(platform, beams, kept)
        loads = np.zeros((len(references), 6))
        for piece, (force, centre) in weights:
            loads[piece] += np.append(force, np.cross(centre - references[piece], force))
        R = self.configuration.platform_frame[:3, :3] if frame == "platform" else np.eye(3)
        force, moment = R @ load[:3], R @ load[3:]
        arm = np.zeros(3) if point is None else R @ point if frame == "platform" else point - o
        loads[platform] += np.append(force, moment + np.cross(arm, force))
        return FrameModel(
            base,
            platform,
            references,
            loads,
            tuple(beams),
            kept,
            tuple(spanned),
            tuple(self._drives(kept, spanned)),
            *_sizes(o, platform, references, beams, kept),
        )

    # ---- joints -----------------------------------------------------------------------------------------------------

    def _joint(self, joint: PlacedJoint) -> FrameJoint:
        ends = self.pieces.ends_of(joint)
        inner = 0 if self.pieces.inner_first(joint.name, ends) else 1
        numbers = (self.number(ends[inner]), self.number(ends[1 - inner]))
        blocked = np.ones(6, dtype=bool)
        if not joint.driven:
            blocked[list(FREE[joint.kind])] = False
        # the centre of a sliding joint is the one on its outer side; of others the two are the same
        return FrameJoint(joint.name, numbers, joint.frames[1 - inner][:3, 3], _joint_axes(joint), blocked)

    def _drives(self, joints: Sequence[FrameJoint], spanned: Sequence[SpannedJoint]) -> list[Drive]:
        found = []
        outward = {item.name: item.pieces for item in joints}
        for name in self.description.driven:
            joint = self.pieces.joints[name]
            if name in outward:
                first = self.number(self.pieces.ends_of(joint)[0])
                sign = 1.0 if first == outward[name][0] else -1.0
            elif any(item.name == name for item in spanned):
                sign = self._spanned_sign[name]
            else:
                continue
            found.append(Drive(name, sign * joint.axis, joint.kind != "prismatic"))
        return found

    # ---- beams ------------------------------------------------------------------------------------------------------

    def _beam(self, placed: PlacedBeam, gravity: Array) -> FrameBeam:
        beam = self.description.beams[placed.name]
        frame = self.configuration.frame(beam.link)[:3, :3]
        span = placed.points[1] - placed.points[0]
        length = float(np.linalg.norm(span))
        x = span / length
        # without y_axis the section is alike in all directions across the beam
        hint = frame @ np.array(beam.y_axis) if beam.y_axis is not None else np.eye(3)[int(np.argmin(np.abs(x)))]
        y = hint - x * (x @ hint)
        y /= np.linalg.norm(y)
        E, G, section = beam.youngs_modulus, beam.shear_modulus, beam.section
        stiffness = (
            E * section.area,
            G * beam.shear_areas[0],
            G * beam.shear_areas[1],
            G * section.J,
            E * section.I_y,
            E * section.I_z,
        )
        passive = [
            name for name in placed.chain if self.pieces.joints[name].kind == "prismatic" and not self.pieces.joints[name].driven
        ]
        before = placed.chain[: placed.carrier]
        return FrameBeam(
            placed.name,
            (self.number(placed.pieces[0]), self.number(placed.pieces[1])),
            placed.points,
            np.column_stack([x, y, np.cross(x, y)]),
            stiffness,
            self._mass(placed.name) / length * gravity,
            (any(name in before for name in passive), any(name not in before for name in passive)),
        )

    def _mass(self, name: str) -> float:
        """Return a beam's mass [kg]: by density, or its share of the link's by length."""
        beam = self.description.beams[name]

        def length(other: str) -> float:
            points = self.pieces.beams[other].points
            return float(np.linalg.norm(points[1] - points[0]))

        if beam.density is not None:
            return beam.density * beam.section.area * length(name)
        siblings = [other.name for other in self.description.beams.values() if other.link == beam.link]
        return self.description.links[beam.link].mass * length(name) / sum(map(length, siblings))

    def _spanned(self, placed: PlacedBeam, joints: Sequence[FrameJoint], gravity: Array) -> list[SpannedJoint]:
        """Return the joints inside a beam, whose inner end is its start.

        The beam's mass moves with the link that carries it. A joint between the inner end and that link carries the whole of it,
        and so what the inner end puts on the beam; one beyond carries none of it, and so what the beam puts on the outer end.
        Links in between are part of the piece at the end, but lie on the other side of the joint.
        """
        found = []
        for number, name in enumerate(placed.chain):
            joint = self.pieces.joints[name]
            outer_link = placed.links[number + 1]
            point = joint.frames[joint.links.index(outer_link)][:3, 3]
            self._spanned_sign[name] = 1.0 if joint.links[1] == outer_link else -1.0
            end = 0 if number < placed.carrier else 1
            between = placed.links[number + 1 : placed.carrier] if end == 0 else placed.links[placed.carrier + 1 : number + 1]
            sign = -1.0 if end == 0 else 1.0
            force = np.zeros(6)
            others: list[tuple[str, float]] = []
            for link in between:
                weight, centre = self._weight(link, gravity)
                force += sign * np.append(weight, np.cross(centre - point, weight))
                for item in joints:
                    if link in self.pieces.joints[item.name].links:
                        mine = self.number(self.pieces.of_link(link)) == item.pieces[0]
                        others.append((item.name, sign * (-1.0 if mine else 1.0)))
            found.append(SpannedJoint(name, point, placed.name, end, force, tuple(others)))
        return found

    # ---- weights and points -----------------------------------------------------------------------------------------

    def _weight(self, link: str, gravity: Array) -> tuple[Array, Array]:
        """Return the weight (3,) of a rigid link [N] and its centre of mass (3,)."""
        data, frame = self.description.links[link], self.configuration.frame(link)
        return data.mass * gravity, frame[:3, :3] @ np.array(data.center_of_mass) + frame[:3, 3]

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
    """Return every piece with the points at which something is attached to it."""
    found = [(piece, point) for beam in beams for piece, point in zip(beam.pieces, beam.points, strict=True)]
    return found + [(piece, joint.point) for joint in joints for piece in joint.pieces]


def _sizes(
    o: Array, platform: int, references: Array, beams: Sequence[FrameBeam], joints: Sequence[FrameJoint]
) -> tuple[float, float]:
    """Return the frame's size and length."""
    points = _attachments(beams, joints)
    cloud = np.array([o, *references, *(point for _, point in points)])
    size = float(np.linalg.norm(cloud.max(axis=0) - cloud.min(axis=0))) or 1.0
    distances = [float(np.linalg.norm(point - o)) for piece, point in points if piece == platform]
    mean = float(np.mean(distances)) if distances else 0.0
    return size, mean if mean > 1e-3 * size else size


def _joint_axes(joint: PlacedJoint) -> Array:
    """Return (3, 3) axes: x along the joint's axis; of a universal joint y along the first axis and x across both."""
    if joint.kind == "universal":
        x, y = np.cross(joint.axis, joint.axis2), joint.axis
        x = x / np.linalg.norm(x)
    else:
        x = joint.axis / np.linalg.norm(joint.axis)
        y = np.cross(x, np.eye(3)[int(np.argmin(np.abs(x)))])
    y = y / np.linalg.norm(y)
    return np.column_stack([x, y, np.cross(x, y)])


def _turned(beam: PlacedBeam) -> PlacedBeam:
    """Return the same beam from its other end."""
    return PlacedBeam(
        beam.name,
        (beam.pieces[1], beam.pieces[0]),
        beam.points[::-1],
        beam.chain[::-1],
        beam.links[::-1],
        len(beam.chain) - beam.carrier,
    )
