"""An independent answer for robots with springs: the second derivatives of their potential energy, about the unloaded pose.

Every rigid piece is a body with a displacement and a rotation vector; joints are constraints on these, exact to second order,
elastic where they are; beams are rows of short elements that turn with their chords. Energies and constraints are written down
once, in arithmetic that carries first and second derivatives along; nothing is differentiated by hand.
The forces in joints and beams are those of the unloaded shape under springs and weights: loads are no part of the stiffness. With
the forces λ of constraints and f of elastic parts, K_t = ∂²V/∂x² + Σ λ ∂²c/∂x² + Σ f ∂²d/∂x² on the null space of ∂c/∂x; the
displacement is −K_t⁻¹ ∂V/∂x.
Of the package it takes the pieces of :mod:`kinetostatics.verification.pieces` alone.
"""

from dataclasses import dataclass

import numpy as np
from finite_elements import skew

from kinetostatics.description.joint_types import Axes
from kinetostatics.verification.frame import joint_springs, releases
from kinetostatics.verification.pieces import RigidPieces

#: Singular values below this part of the largest are zero.
ZERO = 1e-9


# ---- arithmetic with first and second derivatives by 12 variables -------------------------------------------------------------


class Jet:
    """Values (…), first (…, 12) and second derivatives (…, 12, 12)."""

    __array_priority__ = 1000

    def __init__(self, value, first, second):
        self.value, self.first, self.second = value, first, second

    @classmethod
    def of(cls, value):
        value = np.asarray(value, dtype=float)
        return cls(value, np.zeros((*value.shape, 12)), np.zeros((*value.shape, 12, 12)))

    def __getitem__(self, key):
        return Jet(self.value[key], self.first[key], self.second[key])

    def __add__(self, other):
        other = jet(other)
        return Jet(self.value + other.value, self.first + other.first, self.second + other.second)

    __radd__ = __add__

    def __neg__(self):
        return Jet(-self.value, -self.first, -self.second)

    def __sub__(self, other):
        return self + -jet(other)

    def __rsub__(self, other):
        return jet(other) + -self

    def __mul__(self, other):
        other = jet(other)
        a, b = self.value[..., None], other.value[..., None]
        mixed = self.first[..., :, None] * other.first[..., None, :]
        second = a[..., None] * other.second + b[..., None] * self.second + mixed + np.swapaxes(mixed, -1, -2)
        return Jet(self.value * other.value, a * other.first + b * self.first, second)

    __rmul__ = __mul__

    def root(self):
        value = np.sqrt(self.value)
        first = self.first / (2 * value[..., None])
        second = (self.second / 2 - first[..., :, None] * first[..., None, :]) / value[..., None, None]
        return Jet(value, first, second)

    def sum(self):
        return Jet(self.value.sum(0), self.first.sum(0), self.second.sum(0))

    def by(self, matrix):
        """Return the product of a matrix (k, m) with a vector (m,)."""
        return Jet(matrix @ self.value, matrix @ self.first, np.einsum("km,mij->kij", matrix, self.second))


def jet(value):
    return value if isinstance(value, Jet) else Jet.of(value)


def cross(a, b):
    a, b = jet(a), jet(b)
    return a[[1, 2, 0]] * b[[2, 0, 1]] - a[[2, 0, 1]] * b[[1, 2, 0]]


def dot(a, b):
    return (jet(a) * b).sum()


def displacements():
    """Return displacement and rotation vector of two bodies."""
    found = []
    for k in range(4):
        item = Jet.of(np.zeros(3))
        item.first[:, 3 * k : 3 * k + 3] = np.eye(3)
        found.append(item)
    return found[:2], found[2:]


def turned(theta, vector):
    """Return a vector that turns with a body, to second order."""
    once = cross(theta, vector)
    return vector + once + 0.5 * cross(theta, once)


def relative_rotation(a, b):
    """Return the rotation vector of exp(−a) exp(b), to second order, in the axes of either."""
    return b - a - 0.5 * cross(a, b)


# ---- the robot ----------------------------------------------------------------------------------------------------------------


@dataclass
class Answer:
    """About o, world axes.

    Attributes:
        twist, compliance: of the platform (6,), (6, 6).
        negative: number of negative eigenvalues of the whole reduced tangent stiffness.
        stiffness: that of the platform, (6, 6), where it has one.
        gap: how sure ranks are: the smallest eigenvalue that counts, relative to the largest.
        linear: (6, 6) the compliance without springs and weights.
        joint_wrenches: for each joint, what its predecessor's side puts on its successor's, about the joint's centre, in the
            unloaded shape.
    """

    twist: np.ndarray
    compliance: np.ndarray
    negative: int
    stiffness: np.ndarray
    gap: float
    linear: np.ndarray
    joint_wrenches: dict


class Energy:
    """A pose of a robot; see :func:`solve`."""

    def __init__(self, configuration, gravity, elements, platform_load, loads, payload):
        self.at, self.description = configuration, configuration.robot.description
        self.pieces, self.gravity = RigidPieces(configuration), np.asarray(gravity, dtype=float)
        self.references, self.roots = [], {}
        self.base = self.body(self.pieces.base)
        #: (bodies, constraint) and (bodies, coordinates, their stiffness (k,)), names; and the energies of springs and weights
        self.constraints, self.elastic, self.energies = [], [], []
        #: what is no part of the tangent stiffness: moments at the ends of beams' elements by their weight, and loads
        self.fixed_ends, self.loads = [], []
        self.platform = self.body(self.pieces.platform)
        for beam in self.pieces.beams.values():
            for piece, point in zip(beam.pieces, beam.points, strict=True):
                self.body(piece, point)
        for item in self.pieces.jointed:
            for piece in item.pieces:
                self.body(piece, item.joint.frames[0][:3, 3])
        self.o = configuration.platform_frame[:3, 3]
        for item in self.pieces.jointed:
            if self.pieces.find(item.pieces[0]) != self.pieces.find(item.pieces[1]):
                self._joint(item)
        for name, placed in self.pieces.beams.items():
            self._beam(self.description.beams[name], placed, elements)
        for link in self.description.links.values():
            if self.pieces.is_rigid(link.name) and link.mass > 0:
                self._weight(link.name, link.mass, link.center_of_mass)
        for spring in self.description.springs.values():
            self._spring(spring)
        if payload is not None:
            frame = configuration.platform_frame if payload.link is None else configuration.frame(payload.link)
            at = frame[:3, :3] @ np.asarray(payload.center, dtype=float) + frame[:3, 3]
            body = self.platform if payload.link is None else self._at(payload.link, at)
            self.loads.append(self._force(body, at, np.append(payload.mass * self.gravity, np.zeros(3))))
        self.loads.append(self._force(self.platform, self.o, np.asarray(platform_load, dtype=float)))
        for link, wrench in (loads or {}).items():
            point = configuration.frame(link)[:3, 3]
            self.loads.append(self._force(self._at(link, point), point, np.asarray(wrench, dtype=float)))

    def body(self, piece, point=None):
        root = self.pieces.find(piece)
        if root not in self.roots:
            self.roots[root] = len(self.references)
            self.references.append(np.zeros(3) if point is None else np.array(point))
        return self.roots[root]

    def _at(self, link, point):
        return self.body(self.pieces.of_link(link) if self.pieces.is_rigid(link) else self.pieces.at(link, point), point)

    def point(self, body, displacement, at):
        """Return where a body's point ``at`` is moved to."""
        u, theta = displacement
        r = at - self.references[body]
        return at + u + cross(theta, r) + 0.5 * cross(theta, cross(theta, r))

    # ---- what stores energy, and what constrains -------------------------------------------------------------------------------

    def _joint(self, item):
        joint, bodies = item.joint, tuple(self.body(piece) for piece in item.pieces)
        one, two = displacements()
        elastic = self.description.joint_stiffness.get(joint.name)
        axes, free = releases(joint, elastic)
        first, second = (self.point(body, moved, joint.frames[1][:3, 3]) for body, moved in zip(bodies, (one, two), strict=True))
        # along axes that turn with the mean of the bodies
        mean = 0.5 * (one[1] + two[1])
        shift = turned(-mean, second - first)
        turn = relative_rotation(one[1], two[1])
        compliance = np.zeros((6, 6))
        for spring in joint_springs(joint, elastic):
            R = np.kron(np.eye(2), spring.axes)
            with np.errstate(divide="ignore"):
                compliance += R @ np.diag(1 / spring.stiffness) @ R.T
        S = np.kron(np.eye(2), axes)[:, free]
        moved = Jet(
            *(np.concatenate(parts) for parts in zip(*((p.value, p.first, p.second) for p in (shift, turn)), strict=True))
        )
        N = np.linalg.svd(S, full_matrices=True)[0][:, S.shape[1] :] if S.shape[1] else np.eye(6)
        values, vectors = np.linalg.eigh(N.T @ compliance @ N)
        rows = (N @ vectors).T
        found = moved.by(rows)
        if joint.type.turns is Axes.BOTH and S.shape[1] == 2:
            # its two axes keep their angle
            normal = np.cross(joint.axis, joint.axis2)
            along = rows @ np.append(np.zeros(3), normal / np.linalg.norm(normal))
            angle = dot(turned(one[1], joint.axis), turned(two[1], joint.axis2)) - float(joint.axis @ joint.axis2)
            angle = angle * (-1 / float(np.linalg.norm(normal)))
            off = dot(moved[3:], normal / np.linalg.norm(normal))
            for name in ("value", "first", "second"):
                change = getattr(angle, name) - getattr(off, name)
                setattr(found, name, getattr(found, name) + np.multiply.outer(along, change))
        rigid = values < 1e-14
        if joint.locked and not np.any(compliance):
            assert np.all(rigid)
        self.constraints.append((bodies, found[rigid], (joint.name, rows[rigid])))
        self.elastic.append((bodies, found[~rigid], np.diag(1 / values[~rigid]), (joint.name, rows[~rigid])))

    def _beam(self, beam, placed, elements):
        """Nodes along the beam; every element turns with the mean of its ends, and strains by what they differ from it."""
        start, end = placed.points
        x = (end - start) / np.linalg.norm(end - start)
        hint = np.array(beam.y_axis) if beam.y_axis is not None else None
        y = np.eye(3)[np.argmin(np.abs(x))] if hint is None else self.at.frame(beam.link)[:3, :3] @ hint
        y = y - x * (x @ y)
        y /= np.linalg.norm(y)
        R = np.column_stack([x, y, np.cross(x, y)])
        L, section, E, G = float(np.linalg.norm(end - start)) / elements, beam.section, beam.youngs_modulus, beam.shear_modulus
        shear = []
        for EI, GA in ((E * section.I_z, G * beam.shear_areas[0]), (E * section.I_y, G * beam.shear_areas[1])):
            shear.append(1 / (L**3 / (12 * EI) + L / GA))
        stiffness = np.diag([E * section.area / L, *shear, G * section.J / L, E * section.I_y / L, E * section.I_z / L])
        bodies = [self.body(placed.pieces[0])]
        for k in range(1, elements):
            self.references.append(start + (end - start) * k / elements)
            bodies.append(len(self.references) - 1)
        bodies.append(self.body(placed.pieces[1]))
        if beam.density is None:
            siblings = [self.pieces.beams[b.name].points for b in self.description.beams.values() if b.link == beam.link]
            share = L / sum(float(np.linalg.norm(points[1] - points[0])) for points in siblings)
            weight = self.description.links[beam.link].mass * share * self.gravity
            middle = np.average(
                [p.mean(axis=0) for p in siblings], axis=0, weights=[np.linalg.norm(p[1] - p[0]) for p in siblings]
            )
            frame = self.at.frame(beam.link)
            lever = frame[:3, :3] @ np.array(self.description.links[beam.link].center_of_mass) + frame[:3, 3] - middle
        else:
            weight, lever = beam.density * section.area * L * self.gravity, np.zeros(3)
        for k in range(elements):
            ends = [start + (end - start) * j / elements for j in (k, k + 1)]
            pair = tuple(bodies[k : k + 2])
            one, two = displacements()
            first, second = (self.point(body, moved, at) for body, moved, at in zip(pair, (one, two), ends, strict=True))
            shift = turned(-0.5 * (one[1] + two[1]), second - first) - (ends[1] - ends[0])
            parts = shift.by(R.T), relative_rotation(one[1], two[1]).by(R.T)
            moved = Jet(*(np.concatenate(item) for item in zip(*((p.value, p.first, p.second) for p in parts), strict=True)))
            self.elastic.append((pair, moved, stiffness, None))
            for body, at, sign in zip(pair, ends, (1, -1), strict=True):
                self.fixed_ends.append((body, np.append(np.zeros(3), sign * np.cross(ends[1] - ends[0], weight) / 12)))
                self._hang(body, at + lever, weight / 2, beam.name)

    def _weight(self, link, mass, centre):
        frame = self.at.frame(link)
        at = frame[:3, :3] @ np.asarray(centre, dtype=float) + frame[:3, 3]
        self._hang(self._at(link, at), at, mass * self.gravity, link)

    def _hang(self, body, at, weight, name):
        """Of a force that keeps its direction."""
        one, _ = displacements()
        self.energies.append(((body, body), -1.0 * dot(self.point(body, one, at) - at, weight), ("weight", name)))

    def _force(self, body, at, wrench):
        """Return a body and the wrench about its reference."""
        return body, np.append(wrench[:3], wrench[3:] + np.cross(at - self.references[body], wrench[:3]))

    def _spring(self, spring):
        ends, bodies = [], []
        for link, local in ((spring.predecessor, spring.predecessor_point), (spring.successor, spring.successor_point)):
            frame = self.at.frame(link)
            ends.append(frame[:3, :3] @ np.array(local) + frame[:3, 3])
            bodies.append(self._at(link, ends[-1]))
        first, second = (self.point(body, moved, at) for body, moved, at in zip(bodies, displacements(), ends, strict=True))
        square = dot(second - first, second - first)
        if spring.free_length == spring.preload == 0:
            energy = 0.5 * spring.stiffness * square
        else:
            longer = square.root() - spring.free_length
            energy = longer * (spring.preload + 0.5 * spring.stiffness * longer)
        self.energies.append((tuple(bodies), energy, ("spring", spring.name)))

    # ---- the whole -------------------------------------------------------------------------------------------------------------

    def rows(self, pair):
        return np.concatenate([6 * body + np.arange(6) for body in pair])

    def add(self, matrix, pair, block):
        rows = self.rows(pair)
        np.add.at(matrix, np.ix_(rows, rows), block)

    def solve(self):
        n = 6 * len(self.references)
        K, geometric, gradient = np.zeros((n, n)), np.zeros((n, n)), np.zeros(n)
        A, where = [np.zeros((6, n))], []
        A[0][:, 6 * self.base : 6 * self.base + 6] = np.eye(6)
        for pair, found, _ in self.constraints:
            block = np.zeros((len(found.value), n))
            rows = self.rows(pair)
            for column, row in enumerate(rows):
                block[:, row] += found.first[:, column]
            where.append(sum(map(len, A)))
            A.append(block)
        A = np.concatenate(A)
        for pair, energy, _ in self.energies:
            np.add.at(gradient, self.rows(pair), energy.first)
            self.add(geometric, pair, energy.second)
        for body, wrench in self.fixed_ends:
            gradient[6 * body : 6 * body + 6] -= wrench
        loaded = gradient.copy()
        for body, wrench in self.loads:
            loaded[6 * body : 6 * body + 6] -= wrench
        for pair, moved, stiffness, _ in self.elastic:
            self.add(K, pair, moved.first.T @ stiffness @ moved.first)
        # lengths of rotations
        points = np.array(self.references)
        length = float(np.linalg.norm(points.max(axis=0) - points.min(axis=0))) / 3 or 1.0
        unit = np.tile(np.repeat([1.0, 1 / length], 3), len(points))
        _, values, vectors = np.linalg.svd(A * unit)
        rank = int(np.sum(values > ZERO * values[0]))
        Z = unit[:, None] * vectors[rank:].T
        platform = np.eye(6)
        platform[:3, 3:] = -skew(self.o - points[self.platform])
        P = np.zeros((6, n))
        P[:, 6 * self.platform : 6 * self.platform + 6] = platform
        linear, held, _, _ = _solved(Z, K, np.column_stack([-gradient, P.T]))
        x = linear[:, 0]
        multipliers = np.linalg.lstsq(A.T / np.linalg.norm(A, axis=1), -(gradient + K @ x), rcond=None)[0] / np.linalg.norm(
            A, axis=1
        )
        wrenches = {}
        for (pair, found, (name, rows)), first in zip(self.constraints, where, strict=True):
            force = multipliers[first : first + len(found.value)]
            self.add(geometric, pair, np.einsum("k,kij->ij", force, found.second))
            wrenches[name] = wrenches.get(name, 0.0) - rows.T @ force
        for pair, moved, stiffness, name in self.elastic:
            force = stiffness @ moved.first @ x[self.rows(pair)]
            self.add(geometric, pair, np.einsum("k,kij->ij", force, moved.second))
            if name is not None:
                wrenches[name[0]] = wrenches.get(name[0], 0.0) - name[1].T @ force
        Z = Z @ _held(Z.T @ K @ Z, Z.T @ geometric @ Z)
        tangent, fine, eigenvalues, gap = _solved(Z, K + geometric, np.column_stack([-loaded, P.T]))
        compliance = P @ tangent[:, 1:]
        return Answer(
            P @ tangent[:, 0], compliance, int(np.sum(eigenvalues < 0)), np.linalg.pinv(compliance, rcond=1e-12),
            gap if held and fine else 0.0, P @ linear[:, 1:], wrenches,
        )  # fmt: skip


def _held(K, geometric):
    """Return the combinations of freedoms without those that nothing holds and no force at the pose turns back or on: spins."""
    values, vectors = np.linalg.eigh(K)
    free = np.abs(values) <= ZERO * np.abs(values).max(initial=1e-300)
    turned, mixed = np.linalg.eigh(vectors[:, free].T @ geometric @ vectors[:, free])
    spins = np.abs(turned) <= 1e-6 * np.abs(geometric).max(initial=1e-300)
    return np.hstack([vectors[:, ~free], vectors[:, free] @ mixed[:, ~spins]])


def _solved(Z, K, right):
    """Return the solutions (n, k), whether what nothing holds is not moved, the eigenvalues that count, and the least of them."""
    values, vectors = np.linalg.eigh(Z.T @ K @ Z)
    size = float(np.abs(values).max(initial=1e-300))
    kept = np.abs(values) > ZERO * size
    right = Z.T @ right
    loose = float(np.abs(vectors[:, ~kept].T @ right[:, :1]).max(initial=0.0)) <= 1e-7 * float(
        np.abs(right[:, :1]).max(initial=1e-300)
    )
    found = vectors[:, kept] @ ((vectors[:, kept].T @ right) / values[kept, None])
    return Z @ found, loose, values[kept], float(np.abs(values[kept]).min(initial=size) / size)


def solve(configuration, load=(0, 0, 0, 0, 0, 0), gravity=(0, 0, -9.81), loads=None, payload=None, elements=8):
    """Analyze one pose.

    Args:
        configuration: a single pose.
        load: (6,) wrench on the platform at o, world axes: a dead load, no part of the tangent stiffness.
        gravity: (3,).
        loads: wrenches (6,) on links at their origins, dead loads too.
        payload: as in :func:`kinetostatics.analyze`.
        elements: of every beam.
    """
    return Energy(configuration, gravity, elements, load, loads, payload).solve()
