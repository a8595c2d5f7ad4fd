"""A link given by its stiffness and mass matrices: what an elastic link of a new kind has to say, as one class.

The matrices refer to the twists of start and end, [d; r] each, in the axes of the robot's link. Beams as such links serve to
compare the two: :func:`as_matrices` computes their matrices by quadrature, without the package's formulas of beams.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import ClassVar

import numpy as np
import pinocchio as pin

import kinetostatics as ks
from kinetostatics.description import Flexible, LinkMatrices
from kinetostatics.description.elements import BeamEnd
from kinetostatics.description.fields import IN_PYTHON, Place
from kinetostatics.description.flexible import ElasticPart
from kinetostatics.elements.link import ElasticLink, ElasticLinks
from kinetostatics.math.rotations import skew
from kinetostatics.mechanism.beam_geometry import Span, SpanFinder

_POINTS, _WEIGHTS = (np.polynomial.legendre.leggauss(8) + np.array([[1.0], [0.0]])) / 2


@dataclass(frozen=True)
class MatrixLink(ElasticLink, ElasticPart):
    """A link with a stiffness and a mass matrix (12, 12), nested tuples; ``factor`` scales the stiffness.

    ``span``, ``axes`` and ``centre`` are those of the link in its robot.
    """

    link: str
    start: BeamEnd
    end: BeamEnd
    stiffness: tuple
    mass: tuple
    factor: float = 1.0
    name: str = ""
    place: Place = field(default=IN_PYTHON, compare=False)
    span: Span | None = field(default=None, repr=False)
    axes: np.ndarray | None = field(default=None, repr=False)
    centre: np.ndarray | None = field(default=None, repr=False)

    numbers: ClassVar = {"factor": "1"}
    errors: ClassVar = {"length": "m"}

    @classmethod
    def of(cls, link, start, end, stiffness, mass, name=""):
        """Return a link with matrices (12, 12) given as arrays."""
        return cls(link, start, end, _tuples(stiffness), _tuples(mass), name=name or link)

    # ---- in its robot

    def model(self, mechanism, span, zero):
        axes = mechanism.body_of[self.link][1][:3, :3]
        at_start = mechanism.connections[self.start.joint].centre_on(span.start_link)
        back = np.linalg.norm(at_start - span.start) > np.linalg.norm(at_start - span.end)
        order = [*range(6, 12), *range(6)] if back else list(range(12))
        K, M = (np.array(matrix)[np.ix_(order, order)] for matrix in (self.stiffness, self.mass))
        placed = replace(self, stiffness=_tuples(K * self.factor), mass=_tuples(M), factor=1.0, span=span, axes=axes)
        return replace(placed, centre=span.start + axes @ placed._rigid[1])

    @property
    def _rigid(self):
        """Mass, centre of mass from the start and inertia about the centre, link axes."""
        M, R = np.array(self.mass), np.vstack([np.eye(6), np.eye(6)])
        R[6:9, 3:] = -skew(self.axes.T @ (self.span.end - self.span.start))
        whole = R.T @ M @ R
        mass = whole[0, 0]
        cross = whole[3:, :3] / mass if mass else np.zeros((3, 3))
        centre = np.array([cross[2, 1], cross[0, 2], cross[1, 0]])
        return mass, centre, whole[3:, 3:] + mass * skew(centre) @ skew(centre)

    # ---- weight

    def mass_at(self, frames):
        return np.full_like(frames.position[0, 0], sum(self.mass[0][k] for k in (0, 6)) + sum(self.mass[6][k] for k in (0, 6)))

    def inertia_at(self, frames):
        mass, _, inertia = self._rigid
        return self.span.carrier, pin.Inertia(mass, self.centre, self.axes @ inertia @ self.axes.T)

    # ---- statics

    def stacked(self, links, edges, element=0, signs=None):
        return ElasticLinks(links, [link.flexibility for link in links], edges, element, signs)

    @property
    def flexibility(self):
        F = np.linalg.inv(np.array(self.stiffness)[6:, 6:])
        M = np.array(self.mass)
        return F, F @ (M[6:, :3] + M[6:, 6:9])

    def misfit(self, frames, kind):
        start, end = self.ends(frames)
        return np.concatenate([(end - start) / self.length(frames), np.zeros_like(start)])

    # ---- vibration: the matrices are those of the ends, without inner coordinates

    inner = 0

    def vibrating(self, frames):
        return self

    def take(self, poses):
        return self

    def piece(self, count):
        return self

    def dynamic_stiffness(self, square):
        return np.array(self.stiffness) - square[..., None, None] * np.array(self.mass)

    def pencil(self, square):
        shape = (*square.shape, 12, 12)
        return np.broadcast_to(self.stiffness, shape), np.broadcast_to(self.mass, shape)

    def clamped_square(self):
        return np.array(np.inf)

    def clamped_modes(self, square):
        return np.zeros(square.shape, dtype=int)


def _tuples(matrix):
    return tuple(map(tuple, matrix.tolist()))


def with_matrix_links(robot, names=None):
    """Return the robot with the named beams (default: all that are not telescopic) as links given by matrices."""
    description, zero = robot.description, robot.zero_frames
    names = [name for name, beam in robot.beams.items() if not beam.telescopic] if names is None else names
    finder = SpanFinder(robot.mechanism)
    links = {}
    for name in names:
        start, end = finder._ends(description.beams[name])
        K, M = as_matrices(robot, name, zero)
        links[name] = MatrixLink.of(description.beams[name].link, start, end, K, M, name)
    beams = {name: beam for name, beam in description.beams.items() if name not in links}
    return ks.Robot(replace(description, beams=beams, flexible=links))


def as_matrices(robot, name, zero):
    """Return stiffness and mass (12, 12) of a beam between its ends as in the file, in the axes of its link."""
    beam = robot.beams[name]
    L, lever = float(beam.length(zero)[0]), beam.world_axes(zero)[:, :, 0].T @ beam.lever(zero)[:, 0]
    density, section = float(beam.line_density(np.array([L]))[0]), beam.section
    c = np.diag(beam.compliances)

    def carried(s):  # displacement of the end when the section at s moves, and the wrench at s under one at the end
        found = np.eye(6)
        found[:3, 3:] = -skew(np.array([L - s, 0.0, 0.0]))
        return found

    def moved(s):  # twist at s with the start fixed, per unit of a wrench at the end
        found = np.zeros((6, 6))
        for x, weight in zip(s * _POINTS, s * _WEIGHTS, strict=True):
            lever = np.eye(6)
            lever[:3, 3:] = -skew(np.array([s - x, 0.0, 0.0]))
            found += weight * lever @ c @ carried(x).T
        return found

    stiff = np.linalg.inv(moved(L))
    ends = np.hstack([-carried(0.0), np.eye(6)])
    K = ends.T @ stiff @ ends
    inertia = np.diag([section.I_y + section.I_z, section.I_y, section.I_z]) / section.area - skew(lever) @ skew(lever)
    section_mass = density * np.block([[np.eye(3), -skew(lever)], [skew(lever), inertia]])
    M = np.zeros((12, 12))
    for x, weight in zip(L * _POINTS, L * _WEIGHTS, strict=True):
        rigid = np.eye(6)
        rigid[:3, 3:] = -skew(np.array([x, 0.0, 0.0]))
        shape = np.hstack([rigid, np.zeros((6, 6))]) + moved(x) @ stiff @ ends
        M += weight * shape.T @ section_mass @ shape
    turn = np.kron(np.eye(4), robot.mechanism.body_of[beam.span.part.link][1][:3, :3].T @ beam.axes)
    K, M = turn @ K @ turn.T, turn @ M @ turn.T
    at_start = robot.mechanism.connections[SpanFinder(robot.mechanism)._ends(robot.description.beams[name])[0].joint]
    at_start = at_start.centre_on(beam.span.start_link)
    if np.linalg.norm(at_start - beam.span.start) > np.linalg.norm(at_start - beam.span.end):
        order = [*range(6, 12), *range(6)]
        K, M = K[np.ix_(order, order)], M[np.ix_(order, order)]
    return (K + K.T) / 2, (M + M.T) / 2


def with_flexible(robot, names=None, seed=0):
    """Return the robot with the named beams (default: all that are not telescopic) as ``<flexible>`` links.

    Only beams on links all of whose joints are ends of such beams are replaced. Interfaces have random axes, and origins that are
    displaced from the joints.
    """
    description, zero, rng = robot.description, robot.zero_frames, np.random.default_rng(seed)
    names = [name for name, beam in robot.beams.items() if not beam.telescopic] if names is None else names
    finder, links, bodies = SpanFinder(robot.mechanism), {}, dict(description.links)
    for link in dict.fromkeys(description.beams[name].link for name in names):
        mine = [name for name, beam in description.beams.items() if beam.link == link]
        ends = {name: [end.joint for end in finder._ends(description.beams[name])] for name in mine}
        joints = list(dict.fromkeys(joint for pair in ends.values() for joint in pair))
        joints = [joints[k] for k in rng.permutation(len(joints))]
        if not set(mine) <= set(names) or {item.name for item in robot.mechanism.at_link[link]} != set(joints):
            continue
        K, M = np.zeros((2, 6 * len(joints), 6 * len(joints)))
        for name, pair in ends.items():
            rows = [6 * joints.index(joint) + row for joint in pair for row in range(6)]
            for whole, part in zip((K, M), as_matrices(robot, name, zero), strict=True):
                whole[np.ix_(rows, rows)] += part
        placement = robot.mechanism.body_of[link][1]
        origins, rotations, moved = [], [], np.zeros_like(K)
        for k, joint in enumerate(joints):
            point = robot.mechanism.connections[joint].centre_on(link) - placement[:3, 3]
            axes, shift = np.linalg.qr(rng.normal(size=(3, 3)))[0], rng.uniform(-0.05, 0.05, 3)
            axes *= np.linalg.det(axes)
            origins.append(placement[:3, :3].T @ point + shift)
            rotations.append(axes)
            moved[6 * k : 6 * k + 6, 6 * k : 6 * k + 6] = np.block([[axes, skew(shift) @ axes], [np.zeros((3, 3)), axes]])
        mass = moved.T @ M @ moved if M.any() else None
        bodies[link] = replace(bodies[link], mass=0.0, has_inertial=False)  # as a density replaces the <inertial>
        matrices = LinkMatrices(joints, origins, moved.T @ K @ moved, mass, rotations=rotations)
        links[mine[0]] = Flexible(link, matrices, name=mine[0])
    flexible = {part.link for part in links.values()}
    beams = {name: beam for name, beam in description.beams.items() if beam.link not in flexible}
    return ks.Robot(replace(description, links=bodies, beams=beams, flexible=links))
