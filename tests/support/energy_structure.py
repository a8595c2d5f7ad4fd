"""A robot at a pose as a structure of :mod:`energy_model`.

Of the package it takes the description, the frames of links at the pose, and which pieces are rigid
(:mod:`kinetostatics.verification.pieces`).
"""

import numpy as np
from energy_model import Beams, Joints, Springs, Structure, Wrenches

from kinetostatics.description.joint_types import Axes
from kinetostatics.description.loads import LinkLoad
from kinetostatics.verification.pieces import RigidPieces


def _across(axis):
    return np.linalg.svd(np.asarray(axis, dtype=float)[None])[2][1:]


def _freedoms(joint):
    """Return (translations, rotations) of a joint's type as lists of directions."""
    kind, frame = joint.type, joint.frames[0][:3, :3]
    directions = {Axes.NONE: [], Axes.AXIS: [joint.axis], Axes.BOTH: [joint.axis, joint.axis2], Axes.ALL: list(frame.T)}
    across = list(_across(joint.axis)) if kind.has_axis else []
    return {**directions, Axes.ACROSS: across}[kind.slides], directions[kind.turns]


def _joint(joint, stiffness, shared_drive):
    """Return rows (m, 6), compliances (m,), the motion (6,) of its actuator, and whether two universal axes are free."""
    frame, found = joint.frames[0][:3, :3], []
    slides, turns = _freedoms(joint)
    linear, angular = (None, None) if stiffness is None else (stiffness.linear, stiffness.angular)
    drive = None if stiffness is None or shared_drive else stiffness.drive
    for directions, values, actuated in ((slides, linear, joint.type.is_slide), (turns, angular, not joint.type.is_slide)):
        finite = np.zeros(3, bool) if values is None else np.isfinite(values) & (np.array(values) != 0)
        C = sum((np.outer(frame[:, k], frame[:, k]) / values[k] for k in np.flatnonzero(finite)), np.zeros((3, 3)))
        if actuated and drive is not None:
            C = C + np.outer(joint.axis, joint.axis) / drive
        free = np.zeros((3, 0)) if joint.locked else np.array(directions).reshape(-1, 3).T
        if free.size and finite.any():  # directions within those of springs are held
            rigid = frame[:, ~finite].T
            if joint.type.turns is Axes.BOTH:
                free = free[:, np.linalg.norm(rigid @ free, axis=0) > 1e-9]
            else:
                _, sizes, V = np.linalg.svd(rigid @ free)
                free = free @ V[: int(np.sum(sizes > 1e-9))].T
        held = np.linalg.svd(free)[0][:, free.shape[1] :] if free.size else np.eye(3)
        compliances, vectors = np.linalg.eigh(held.T @ C @ held)
        compliances[compliances < 1e-12 * compliances.max(initial=0.0)] = 0.0
        found.append(((held @ vectors).T, np.maximum(compliances, 0.0)))
    (shifts, first), (turns, second) = found
    rows = np.block([[shifts, np.zeros((len(shifts), 3))], [np.zeros((len(turns), 3)), turns]])
    move = np.append(joint.axis, np.zeros(3)) if joint.type.is_slide else np.append(np.zeros(3), joint.axis)
    return rows, np.append(first, second), move, joint.type.turns is Axes.BOTH and len(turns) == 1


def structure_of(configuration, load=(0, 0, 0, 0, 0, 0), gravity=(0, 0, -9.81), loads=None, payload=None, degree=8):
    """Return a single pose of a robot with weights and loads, as arguments of :func:`kinetostatics.analyze`.

    ``degree`` is that of the polynomials along beams: with 8, Euler's loads of clamped columns are sure to 1e-6, with 12 to 1e-9.
    """
    gravity, load = np.asarray(gravity, dtype=float), np.asarray(load, dtype=float)
    return _Builder(configuration, load, gravity, loads or {}, payload, degree).built


class _Builder:
    def __init__(self, configuration, load, gravity, loads, payload, degree):
        self.at, self.description, self.gravity = configuration, configuration.robot.description, gravity
        self.pieces = RigidPieces(configuration)
        self.o, self.references = configuration.platform_frame[:3, 3], []
        self.roots = {}
        self.body(self.pieces.platform, self.o)
        self.body(self.pieces.base, self.o)
        beams = [self._beam(placed) for placed in self.pieces.beams.values()]
        joints, drives = self._joints()
        springs = [self._spring(spring) for spring in self.description.springs.values()]
        weights = [
            self._force(link.name, self._centre(link.name), np.append(link.mass * gravity, np.zeros(3)))
            for link in self.description.links.values()
            if self.pieces.is_rigid(link.name) and link.mass > 0
        ]
        acting = [(0, np.zeros(3), load), *self._loads(loads)]
        if payload is not None:
            link = payload.link
            frame = configuration.platform_frame if link is None else configuration.frame(link)
            at = frame[:3, :3] @ np.asarray(payload.center, dtype=float) + frame[:3, 3]
            acting.append(self._force(link or self.description.platform, at, np.append(payload.mass * gravity, np.zeros(3))))
        self.built = self._scaled(beams, joints, drives, springs, weights, acting, degree)

    # ---- bodies and points

    def body(self, piece, point=None):
        root = self.pieces.find(piece)
        if root not in self.roots:
            self.roots[root] = len(self.references)
            self.references.append(np.array(self.o if point is None else point, dtype=float))
        return self.roots[root]

    def on(self, piece, point):
        """Return a body, and the arm from its reference to a point."""
        number = self.body(piece, point)
        return number, point - self.references[number]

    def _on_link(self, link, point):
        if self.pieces.is_rigid(link):
            return self.on(self.pieces.of_link(link), point)
        ends = [end for name, beam in self.description.beams.items() if beam.link == link
                for end in zip(self.pieces.beams[name].points, self.pieces.beams[name].pieces, strict=True)]  # fmt: skip
        return self.on(min(ends, key=lambda end: float(np.linalg.norm(end[0] - point)))[1], point)

    def _centre(self, link):
        frame = self.at.frame(link)
        return frame[:3, :3] @ np.array(self.description.links[link].center_of_mass) + frame[:3, 3]

    def _force(self, link, at, wrench):
        return (*self._on_link(link, at), wrench)

    def _loads(self, loads):
        for link, value in loads.items():
            several = value if isinstance(value, (list, tuple)) and any(isinstance(item, LinkLoad) for item in value) else [value]
            for item in several:
                item = item if isinstance(item, LinkLoad) else LinkLoad(item)
                frame, wrench = self.at.frame(link), np.asarray(item.wrench, dtype=float).reshape(2, 3)
                wrench = (wrench @ frame[:3, :3].T if item.frame == "link" else wrench).ravel()
                yield self._force(link, frame[:3, :3] @ np.asarray(item.point, dtype=float) + frame[:3, 3], wrench)

    # ---- parts

    def _beam(self, placed):
        beam = self.description.beams[placed.name]
        start, end = placed.points
        length = float(np.linalg.norm(end - start))
        x = (end - start) / length
        y = _across(x)[0] if beam.y_axis is None else self.at.frame(beam.link)[:3, :3] @ np.array(beam.y_axis)
        y = y - x * (x @ y)
        y /= np.linalg.norm(y)
        E, G, section = beam.youngs_modulus, beam.shear_modulus, beam.section
        kGA = np.array(beam.shear_areas) * G
        stiffness = [E * section.area, *kGA, G * section.J, E * section.I_y, E * section.I_z]
        mass, lever = beam.density, np.zeros(3)
        if mass is None:
            ends = [self.pieces.beams[b.name].points for b in self.description.beams.values() if b.link == beam.link]
            lengths = [float(np.linalg.norm(b - a)) for a, b in ends]
            mass = self.description.links[beam.link].mass / sum(lengths)
            lever = self._centre(beam.link) - np.average([(a + b) / 2 for a, b in ends], axis=0, weights=lengths)
        else:
            mass *= section.area
        sides = [self.on(piece, point) for piece, point in zip(placed.pieces, placed.points, strict=True)]
        axes = np.column_stack([x, y, np.cross(x, y)])
        return [k for k, _ in sides], [arm for _, arm in sides], axes, length, stiffness, mass * self.gravity, lever

    def _joints(self):
        description = self.description
        elastic = {name: item for name, item in description.joint_stiffness.items() if item.drive is not None}
        masters = {joint.mimic.joint for joint in description.joints.values() if joint.mimic is not None} & set(elastic)
        order = sorted(masters)
        ratios = {name: (order.index(name), 1.0) for name in order}
        for joint in description.joints.values():
            if joint.mimic is not None and joint.mimic.joint in masters:
                ratios[joint.name] = order.index(joint.mimic.joint), joint.mimic.multiplier
        found = []
        for number, item in enumerate(self.pieces.jointed):
            joint = item.joint
            if self.pieces.find(item.pieces[0]) == self.pieces.find(item.pieces[1]) or joint.type.is_free:
                continue
            rows, compliance, move, universal = _joint(joint, description.joint_stiffness.get(joint.name), joint.name in masters)
            # where a joint slides, its centre is that on the side of the platform
            centre = joint.frames[1 if self.pieces.predecessor_is_inner(number) else 0][:3, 3]
            sides = [self.on(piece, centre) for piece in item.pieces]
            ratio = np.zeros((len(rows), len(order)))
            if joint.name in ratios:
                column, times = ratios[joint.name]
                ratio[:, column] = times * rows @ move
            axes = joint.axis, joint.axis2
            found.append(([k for k, _ in sides], [arm for _, arm in sides], axes, universal, rows, compliance, ratio))
        slides = [self.pieces.joints[name].type.is_slide for name in order]
        return found, [(1 / elastic[name].drive, slide) for name, slide in zip(order, slides, strict=True)]

    def _spring(self, spring):
        ends, points = [], []
        for link, local in ((spring.predecessor, spring.predecessor_point), (spring.successor, spring.successor_point)):
            frame = self.at.frame(link)
            points.append(frame[:3, :3] @ np.array(local) + frame[:3, 3])
            ends.append(self._on_link(link, points[-1]))
        numbers = spring.stiffness, spring.free_length, spring.preload
        return [k for k, _ in ends], [arm for _, arm in ends], points[1] - points[0], numbers

    # ---- units

    def _scaled(self, beams, joints, drives, springs, weights, acting, degree):
        points = np.array(self.references)
        arms = [arm for item in (*beams, *joints) for arm in item[1]]
        span = np.linalg.norm(points.max(axis=0) - points.min(axis=0)) / 3
        length = float(max([span, *map(np.linalg.norm, arms)])) or 1.0
        forces = [beam[4][0] for beam in beams]
        rows = [pair for item in joints for pair in zip(*item[4:6], strict=True)]
        forces += [(length if np.any(row[:3]) else 1 / length) / c for row, c in rows if c]
        forces += [item[3][0] * length for item in springs if item[3][0]]
        force = float(np.median(forces)) if forces else 1.0

        def table(items, k, shape):
            return np.array([item[k] for item in items], dtype=float).reshape(-1, *shape)

        def indices(items, *shape):
            return np.array([item[0] for item in items], dtype=int).reshape(-1, *shape)

        def wrenches(items):
            wrench = table(items, 2, (6,)) / force / np.repeat([1.0, length], 3)
            return Wrenches(indices(items), table(items, 1, (3,)) / length, wrench)

        stiff = table(beams, 4, (6,)) / force / np.repeat([1.0, length**2], 3)
        beam_table = Beams(
            indices(beams, 2), table(beams, 1, (2, 3)) / length, table(beams, 2, (3, 3)), table(beams, 3, ()) / length, 1 / stiff,
            table(beams, 5, (3,)) * length / force, table(beams, 6, (3,)) / length, degree,
        )  # fmt: skip
        of = np.repeat(np.arange(len(joints)), [len(item[4]) for item in joints])
        rows = np.concatenate([np.zeros((0, 6)), *(item[4] for item in joints)])
        compliance = np.concatenate([np.zeros(0), *(item[5] for item in joints)])
        drive_units = np.array([length if slides else 1.0 for _, slides in drives])
        ratio = np.concatenate([np.zeros((0, len(drives))), *(item[6] for item in joints)])
        unit = np.where(np.any(rows[:, 3:] != 0, axis=1), 1.0, length)
        compliance = compliance * force * length / unit**2
        ratio = ratio * drive_units / unit[:, None]
        joint_table = Joints(
            indices(joints, 2), table(joints, 1, (2, 3)) / length, table(joints, 2, (2, 3)), table(joints, 3, ()), of, rows,
            compliance, ratio,
        )  # fmt: skip
        drive_compliance = np.array([c for c, _ in drives]) * force * length / drive_units**2
        numbers = table(springs, 3, (3,))
        spring_table = Springs(
            indices(springs, 2), table(springs, 1, (2, 3)) / length, table(springs, 2, (3,)) / length,
            numbers[:, :1] * length / force, numbers[:, 1:2] / length, numbers[:, 2:] / force,
        )  # fmt: skip
        parts = beam_table, joint_table, spring_table, wrenches(weights), wrenches(acting), drive_compliance
        return Structure(len(self.references), *parts, length, force)
