"""An independent answer for the tests: a robot as bodies with finite motions, by the second derivatives of its energy.

Unknowns are the displacement u of the reference point and the rotation vector ψ of every rigid piece, R = exp(ψ), from the pose;
the platform's reference point is o. Every elastic or rigid part has deformations d(u, ψ), finite and exact, and forces f, the
further unknowns, so that rigid parts are those without compliance C. The equilibria are the stationary points of

    L(x, f) = V(x) + f · d(x) − ½ f · C f                                               (Hellinger, Reissner)

with the potential V of weights, loads and springs. Its derivatives come from arithmetic that carries first and second
derivatives along; nothing is differentiated by hand. With B = ∂d/∂x the Hessian is [[H, Bᵀ], [B, −C]], H = ∂²V/∂x² + Σ f ∂²d/∂x².

- **Beams** are geometrically exact (J. C. Simo, L. Vu-Quoc, 1986): d are the strains γ = Rᵀ x′ − e_x and κ, the axial vector of
  RᵀR′, at the Gauss points; C = (1/EA, 1/κGA_y, 1/κGA_z, 1/GJ, 1/EI_y, 1/EI_z). All six section resultants
  contribute. Displacements and rotation vectors are polynomials along a beam; as many Gauss points as their degree prevent
  locking.
- **Joints**: d are translation and rotation vector of the successor's side relative to the predecessor's, without the free
  directions. The translation is that of two points that coincide at the pose, in axes that turn with the mean of both sides
  (predecessor's rotation times half of the relative one): exchanging the sides changes nothing. Only *elastic* joints depend on
  this choice: in the predecessor's axes, the tangent differs by ½ F · (φ × s), with the relative rotation φ and the elastic
  displacement s, of first order in the force F. Free universal joints keep the angle of their axes.
- **Springs** between points have their energy, **weights** that of their centres: those of beams are distributed.
- **Loads** keep their directions. A moment M of fixed direction has no potential; its tangent is unsymmetric in general, and the
  symmetric part is that of the potential −M · ψ, with the rotation vector from the pose, which is used here. It is Argyris's
  semitangential moment: the tangent of M alone vanishes in rotation vectors.

At an equilibrium the Hessian on the tangents of the constraints does not depend on the coordinates. :func:`at_the_pose` takes it
at the *unloaded* geometry, u = ψ = 0, with the forces f of the linear solution: every body is in equilibrium there, so this is a
well-defined stiffness too: the elastic one plus the geometric stiffness of all forces. It lacks only what displacements change
in the geometry. :func:`in_equilibrium` solves the nonlinear equilibrium and has the tangent there.

Structures of robots come from :func:`energy_structure.structure_of`.
"""

from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from jets import REST, SINE, VERSINE, cross, dot, relative_rotation, spin_of, stacked, turned, variables

#: Eigenvalues of the Hessian, in units in which stiffnesses are about 1, that count as zero.
ZERO = 1e-11


# ---- the structure ---------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Beams:
    """n beams between bodies: ``bodies`` (n, 2), ``arms`` (n, 2, 3) from their references to the ends, ``axes`` (n, 3, 3) as
    columns, ``length`` (n,), ``compliance`` (n, 6) of sections, ``weight`` (n, 3) per length, ``lever`` (n, 3) to its line."""

    bodies: np.ndarray
    arms: np.ndarray
    axes: np.ndarray
    length: np.ndarray
    compliance: np.ndarray
    weight: np.ndarray
    lever: np.ndarray
    degree: int

    @property
    def inner(self):
        """Number of the inner displacements, and the forces, of a beam."""
        return 6 * (self.degree - 1) + 6 * self.degree


@dataclass(frozen=True, eq=False)
class Pairs:
    """n pairs of bodies (n, 2), with ``arms`` (n, 2, 3) from their references to points on them."""

    bodies: np.ndarray
    arms: np.ndarray


@dataclass(frozen=True, eq=False)
class Joints(Pairs):
    """n joints with m deformations: ``rows`` (m, 6) are the directions of the deformations in :func:`joint_motion`, those of
    joint ``of`` (m,), with the ``compliance`` (m,) and the transmission ``ratio`` (m, a) to the elastic actuators.

    ``universal`` (n,): 1 where the axes (n, 2, 3) keep their angle, else 0."""

    axes: np.ndarray
    universal: np.ndarray
    of: np.ndarray
    rows: np.ndarray
    compliance: np.ndarray
    ratio: np.ndarray


@dataclass(frozen=True, eq=False)
class Springs(Pairs):
    """n springs: ``stiffness``, ``free_length``, ``preload`` (n, 1), ``span`` (n, 3) between the points at the pose."""

    span: np.ndarray
    stiffness: np.ndarray
    free_length: np.ndarray
    preload: np.ndarray


@dataclass(frozen=True, eq=False)
class Wrenches:
    """n forces and moments (n, 6) that keep their directions, at ``arms`` (n, 3) from the references of ``bodies`` (n,)."""

    bodies: np.ndarray
    arms: np.ndarray
    wrench: np.ndarray


@dataclass(frozen=True, eq=False)
class Structure:
    """A robot at a pose, in units of ``length`` [m] and ``force`` [N] in which stiffnesses are about 1.

    Attributes:
        count: number of bodies; the platform is body 0, the base body 1.
        drives: compliances (a,) of elastic actuators that move several joints.
    """

    count: int
    beams: Beams
    joints: Joints
    springs: Springs
    weights: Wrenches
    loads: Wrenches
    drives: np.ndarray
    length: float
    force: float

    @property
    def sizes(self):
        """Numbers of coordinates of bodies and actuators, and of forces of joints, actuators and of the base."""
        a = len(self.drives)
        return 6 * self.count + a, len(self.joints.of) + a + 6


def joint_motion(joints, moved):
    """Return translation and rotation (n, 6) of second sides relative to first ones as jets by ``moved`` (n, 12)."""
    y = variables(moved)
    shift = y[:, 6:9] - y[:, :3] + turned(y[:, 9:], joints.arms[:, 1]) - turned(y[:, 3:6], joints.arms[:, 0])
    shift = shift + (joints.arms[:, 0] - joints.arms[:, 1])
    turn = relative_rotation(y[:, 3:6], y[:, 9:])
    shift = turned(-0.5 * turn, turned(-y[:, 3:6], shift))
    normal = np.cross(joints.axes[:, 0], joints.axes[:, 1])
    size = np.linalg.norm(normal, axis=1, keepdims=True)
    size[size == 0] = 1.0
    angle = dot(turned(y[:, 3:6], joints.axes[:, 0]), turned(y[:, 9:], joints.axes[:, 1]))
    angle = (angle - np.sum(joints.axes[:, 0] * joints.axes[:, 1], axis=1, keepdims=True)) * (-1 / size)
    normal = normal / size
    return stacked(shift, turn + (angle - dot(turn, normal)) * (joints.universal[:, None] * normal))


def spring_energy(springs, moved):
    y = variables(moved)
    span = y[:, 6:9] - y[:, :3] + turned(y[:, 9:], springs.arms[:, 1]) - turned(y[:, 3:6], springs.arms[:, 0])
    span = span + (springs.arms[:, 0] - springs.arms[:, 1] + springs.span)
    square, ideal = dot(span, span), (springs.free_length == 0) & (springs.preload == 0)
    longer = (square + np.where(ideal, 1.0, 0.0)).root() - springs.free_length
    energy = longer * (longer * (0.5 * springs.stiffness) + springs.preload)
    return square * np.where(ideal, 0.5 * springs.stiffness, 0.0) + energy * np.where(ideal, 0.0, 1.0)


@cache
def polynomials(degree):
    """Return the weights (g,) of the Gauss points on a beam of length 1, and polynomials (g, nodes) and their slopes there.

    The nodes are both ends, then inner ones.
    """
    points, weights = np.polynomial.legendre.leggauss(degree)
    inner = (1 - np.cos(np.pi * np.arange(1, degree) / degree)) / 2
    nodes, s = np.array([0.0, 1.0, *inner]), (points + 1) / 2
    values, slopes = np.empty((2, degree, degree + 1))
    for k, node in enumerate(nodes):
        others = np.delete(nodes, k)
        factors = (s[:, None] - others) / (node - others)
        values[:, k] = factors.prod(axis=1)
        slopes[:, k] = sum(np.delete(factors, j, axis=1).prod(axis=1) / (node - other) for j, other in enumerate(others))
    return weights / 2, values, slopes


def beam_energy(beams, ends, inner, geometric):
    """Return gradient (n, k) and Hessian (n, k, k) of the beams' part of L.

    Args:
        ends: (n, 12) displacements of both ends.
        inner: (n, …) those of the inner nodes, then the forces at the Gauss points.
        geometric: whether second derivatives of strains, times forces, belong to the Hessian.
    """
    n, g = len(ends), beams.degree
    weights, shapes, slopes = polynomials(g)
    x = np.concatenate([ends, inner[:, : -6 * g]], axis=1)
    forces = inner[:, -6 * g :].reshape(n, g, 6)
    to_strains = np.zeros((n, g, 9, g + 1, 6))  # x′, ψ, ψ′ at the Gauss points from the nodes' u, ψ
    for i in range(3):
        to_strains[:, :, i, :, i] = slopes / beams.length[:, None, None]
        to_strains[:, :, 3 + i, :, 3 + i] = shapes
        to_strains[:, :, 6 + i, :, 3 + i] = slopes / beams.length[:, None, None]
    to_strains = to_strains.reshape(n, g, 9, -1)
    y = np.einsum("ngik,nk->ngi", to_strains, x)
    y[:, :, :3] += beams.axes[:, None, :, 0]
    y = variables(y.reshape(-1, 9))
    psi, rate = y[:, 3:6], y[:, 6:]
    axes = np.repeat(beams.axes, g, axis=0)
    q, along = dot(psi, psi), turned(-psi, y[:, :3])
    bend = q.function(SINE) * rate - q.function(VERSINE) * cross(psi, rate) + q.function(REST) * dot(psi, rate) * psi
    strain = stacked(along, bend)
    R = np.kron(np.eye(2), np.swapaxes(axes, 1, 2)).reshape(-1, 6, 6)
    value = (np.einsum("gij,gj->gi", R, strain.value) - np.eye(6)[0]).reshape(n, g, 6)
    first = np.einsum("gij,gjk->gik", R, strain.first).reshape(n, g, 6, 9)
    first = np.einsum("ngij,ngjk->ngik", first, to_strains)
    size = weights * beams.length[:, None]
    k = x.shape[1]
    gradient, hessian = np.zeros((n, k + 6 * g)), np.zeros((n, k + 6 * g, k + 6 * g))
    gradient[:, :k] = np.einsum("ng,ngi,ngik->nk", size, forces, first)
    gradient[:, k:] = (size[..., None] * (value - beams.compliance[:, None] * forces)).reshape(n, 6 * g)
    hessian[:, k:, :k] = (size[..., None, None] * first).reshape(n, 6 * g, k)
    hessian[:, :k, k:] = np.swapaxes(hessian[:, k:, :k], 1, 2)
    at = k + np.arange(6 * g)
    hessian[:, at, at] = -(size[..., None] * beams.compliance[:, None]).reshape(n, 6 * g)
    lever = turned(psi, np.repeat(beams.lever, g, axis=0))
    weight = np.repeat(beams.weight, g, axis=0)
    turning = np.einsum("gi,gik->gk", weight, lever.first).reshape(n, g, 9)
    gradient[:, :k] -= np.einsum("ng,ngi,ngik->nk", size, turning, to_strains)
    fall = np.einsum("np,pm,ni->nmi", size, shapes, beams.weight)
    gradient[:, :k].reshape(n, g + 1, 6)[:, :, :3] -= fall
    if geometric:
        local = np.einsum("gi,gij->gj", forces.reshape(-1, 6), R)
        second = np.einsum("gj,gjab->gab", local, strain.second) - np.einsum("gi,giab->gab", weight, lever.second)
        second = second.reshape(n, g, 9, 9) * size[..., None, None]
        hessian[:, :k, :k] += np.einsum("ngai,ngab,ngbj->nij", to_strains, second, to_strains, optimize=True)
    return gradient, hessian


@dataclass(frozen=True, eq=False)
class State:
    """Displacements of bodies, and coordinates of actuators (x,), forces (f,), and the beams' inner unknowns (n, …)."""

    x: np.ndarray
    forces: np.ndarray
    inner: np.ndarray


def at_rest(structure):
    nx, nf = structure.sizes
    return State(np.zeros(nx), np.zeros(nf), np.zeros((len(structure.beams.length), structure.beams.inner)))


@dataclass(frozen=True, eq=False)
class Equations:
    """Gradient (k,) and Hessian (k, k) of L with the beams' inner unknowns condensed, and how these follow from the others.

    ``inner_negative``: number of negative eigenvalues that were condensed."""

    gradient: np.ndarray
    hessian: np.ndarray
    inner: np.ndarray
    to_inner: np.ndarray
    beam_columns: np.ndarray
    inner_negative: int


def equations(structure, state, geometric=True, scale=1.0, condense=True):
    """Return L's derivatives, with weights, springs and loads times ``scale``; ``geometric=False`` is linear theory.

    Without condensation the beams' inner unknowns follow those of the whole.
    """
    nx, nf = structure.sizes
    beams, joints, springs = structure.beams, structure.joints, structure.springs
    n = len(beams.length)
    k = nx + nf + (0 if condense else n * (beams.inner))
    gradient, hessian = np.zeros(k), np.zeros((k, k))
    bodies = state.x[: 6 * structure.count].reshape(-1, 6)

    def columns(indices):
        return (6 * indices[..., None] + np.arange(6)).reshape(len(indices), 6 * indices.shape[1])

    def add(where, slope, second=None):
        np.add.at(gradient, where, slope)
        if second is not None:
            np.add.at(hessian, (where[:, :, None], where[:, None, :]), second)

    def push(indices, arms, forces, factor):
        """Add the potential of −forces · points of bodies."""
        points = turned(variables(bodies[indices, 3:]), arms)
        where = columns(indices[:, None])
        turn = np.einsum("ni,nik->nk", forces[:, :3], points.first) + forces[:, 3:]
        add(where, -factor * np.concatenate([forces[:, :3], turn], axis=1))
        if geometric:
            second = -factor * np.einsum("ni,nijk->njk", forces[:, :3], points.second)
            np.add.at(hessian, (where[:, 3:, None], where[:, None, 3:]), second)

    for item in (structure.weights, structure.loads):
        push(item.bodies, item.arms, item.wrench, scale)
    if len(springs.bodies):
        energy, where = spring_energy(springs, bodies[springs.bodies].reshape(-1, 12)), columns(springs.bodies)
        add(where, scale * energy.first[:, 0], scale * energy.second[:, 0] if geometric else None)
    # joints, and the base that keeps its place
    motion = joint_motion(joints, bodies[joints.bodies].reshape(-1, 12))
    where, m, a = columns(joints.bodies), len(joints.of), len(structure.drives)
    forces = state.forces[:m]
    deformation = np.einsum("mi,mi->m", joints.rows, motion.value[joints.of])
    first = np.einsum("mi,mik->mk", joints.rows, motion.first[joints.of])
    q, drive_forces = state.x[6 * structure.count :], state.forces[m : m + a]
    rows = nx + np.arange(m)
    gradient[rows] += deformation - joints.compliance * forces - joints.ratio @ q
    np.add.at(gradient, where[joints.of], forces[:, None] * first)
    hessian[rows[:, None], where[joints.of]] += first
    hessian[rows, rows] -= joints.compliance
    if a:
        drives, own = 6 * structure.count + np.arange(a), nx + m + np.arange(a)
        gradient[drives] += drive_forces - joints.ratio.T @ forces
        gradient[own] += q - structure.drives * drive_forces
        hessian[rows[:, None], drives] -= joints.ratio
        hessian[own, drives] += 1.0
        hessian[own, own] -= structure.drives
    if geometric and len(joints.bodies):
        total = np.zeros((len(joints.bodies), 6))
        np.add.at(total, joints.of, forces[:, None] * joints.rows)
        add(where, np.zeros(where.shape), np.einsum("ni,nijk->njk", total, motion.second))
    base, ground = nx + m + a + np.arange(6), 6 + np.arange(6)
    gradient[base] += state.x[ground]
    gradient[ground] += state.forces[m + a :]
    hessian[base, ground] += 1.0
    hessian[:nx, nx : nx + nf] = hessian[nx : nx + nf, :nx].T
    # beams: their ends move with bodies
    columns_of = columns(beams.bodies)
    negative, inner, to_inner = 0, np.zeros((n, beams.inner)), np.zeros((n, beams.inner, 12))
    if n:
        points = turned(variables(bodies[beams.bodies, 3:].reshape(-1, 3)), beams.arms.reshape(-1, 3))
        ends = bodies[beams.bodies].reshape(-1, 6).copy()
        ends[:, :3] += points.value - beams.arms.reshape(-1, 3)
        weighed = replace(beams, weight=scale * beams.weight)
        own, local = beam_energy(weighed, ends.reshape(n, 12), state.inner, geometric)
        move = np.zeros((n, 12, 12))
        for side in range(2):
            block = slice(6 * side, 6 * side + 6)
            move[:, block, block] = np.eye(6)
            move[:, 6 * side : 6 * side + 3, 6 * side + 3 : 6 * side + 6] = points.first.reshape(n, 2, 3, 3)[:, side]
            if geometric:
                turn = np.einsum("ni,nijk->njk", own[:, 6 * side : 6 * side + 3], points.second.reshape(n, 2, 3, 3, 3)[:, side])
                w = columns_of[:, 6 * side + 3 : 6 * side + 6]
                np.add.at(hessian, (w[:, :, None], w[:, None, :]), turn)
        K, off, inside = local[:, :12, :12], local[:, 12:, :12], local[:, 12:, 12:]
        add(columns_of, np.einsum("nki,nk->ni", move, own[:, :12]), np.einsum("nki,nkl,nlj->nij", move, K, move))
        off = np.einsum("nij,njk->nik", off, move)
        if condense:
            solved = np.linalg.solve(inside, np.concatenate([off, own[:, 12:, None]], axis=2))
            to_inner, inner = -solved[:, :, :12], -solved[:, :, 12]
            negative = int(np.sum(np.linalg.eigvalsh(inside) < 0))
            add(columns_of, np.einsum("nki,nk->ni", off, inner), np.einsum("nki,nkj->nij", off, to_inner))
        else:
            at = nx + nf + np.arange(n * (beams.inner)).reshape(n, -1)
            gradient[at] = own[:, 12:]
            hessian[at[:, :, None], at[:, None, :]] = inside
            np.add.at(hessian, (at[:, :, None], columns_of[:, None, :]), off)
            np.add.at(hessian, (columns_of[:, :, None], at[:, None, :]), np.swapaxes(off, 1, 2))
    return Equations(gradient, hessian, inner, to_inner, columns_of, negative)


@dataclass(frozen=True, eq=False)
class Solved:
    """A symmetric matrix with its eigenvalues; those that count as zero are left out of its inverse."""

    values: np.ndarray
    vectors: np.ndarray

    @classmethod
    def of(cls, matrix):
        return cls(*np.linalg.eigh(matrix))

    @property
    def kept(self):
        return np.abs(self.values) > ZERO

    @property
    def negative(self):
        return int(np.sum(self.values < -ZERO))

    @property
    def gap(self):
        """Ratio of the smallest value that counts and the largest that does not (or the limit between them)."""
        return float(np.abs(self.values[self.kept]).min(initial=np.inf) / ZERO)

    def solve(self, right):
        V = self.vectors[:, self.kept]
        return V @ ((V.T @ right) / self.values[self.kept].reshape(-1, *[1] * (right.ndim - 1)))

    def unbalanced(self, right):
        """Return the part of a right-hand side that does work along directions without stiffness."""
        return float(np.abs(self.vectors[:, ~self.kept].T @ right).max(initial=0.0) / max(np.abs(right).max(), 1e-300))

    def free(self, rows):
        """Return how much of the given coordinates the directions without stiffness move."""
        return float(np.abs(self.vectors[rows][:, ~self.kept]).max(initial=0.0))


def moved_by(structure, state, found, step):
    nx, _ = structure.sizes
    inner = found.inner + np.einsum("nij,nj->ni", found.to_inner, step[found.beam_columns])
    return State(state.x + step[:nx], state.forces + step[nx:], state.inner + inner)


# ---- results ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Answer:
    """About o, world axes.

    Attributes:
        twist, compliance: of the platform (6,), (6, 6); the twist of a finite motion is displacement and rotation vector.
        linear_twist, linear: the same without geometric stiffness.
        negative: number of negative eigenvalues of the tangent stiffness, inner freedoms included.
        free: whether the platform can move without resistance.
        gap: how far from zero the smallest stiffness is, in units of what counts as zero: large if the answer is sure; 0 if
            nothing balances the loads.
        turn: largest rotation [rad] of any body or section; at the pose, of linear theory.
    """

    twist: np.ndarray
    compliance: np.ndarray
    linear_twist: np.ndarray
    linear: np.ndarray
    negative: int
    free: bool
    gap: float
    turn: float

    @property
    def stiffness(self):
        return np.linalg.inv(self.compliance)


def linear_solution(structure):
    """Return the linear equations, their factors, and the state whose forces are those of the linear solution, at the pose."""
    rest = at_rest(structure)
    found = equations(structure, rest, geometric=False)
    factors = Solved.of(found.hessian)
    return found, factors, moved_by(structure, rest, found, -factors.solve(found.gradient))


def _platform(structure, solved, psi=(0, 0, 0)):
    """Return the compliance (6, 6) of the platform, whose rotation vector is ``psi``."""
    T = np.eye(6)
    T[3:, 3:] = spin_of(np.asarray(psi, dtype=float))
    right = np.zeros((len(solved.values), 6))
    right[:6] = T.T
    return T @ solved.solve(right)[:6]


def _largest_rotation(structure, state):
    bodies, inner = state.x[: 6 * structure.count], state.inner[:, : -6 * structure.beams.degree]
    return float(np.linalg.norm(np.append(bodies, inner).reshape(-1, 6)[:, 3:], axis=1).max())


def _answer(structure, twist, compliance, found, tangent, factors, negative, turn):
    unit = np.repeat([structure.length, 1.0], 3)
    scale = np.outer(unit, unit) / (structure.force * structure.length)
    balanced = factors.unbalanced(found.gradient) < 1e-7
    gap, free = min(tangent.gap, factors.gap) * balanced, tangent.free(slice(6)) > 1e-6
    linear, rigid = -factors.solve(found.gradient), _platform(structure, factors)
    return Answer(twist * unit, compliance * scale, linear[:6] * unit, rigid * scale, negative, free, gap, turn)


def at_the_pose(structure, stiffening_loads=True):
    """Return the tangent stiffness at the unloaded geometry with the forces of the linear solution, and the motion it gives.

    Args:
        stiffening_loads: whether the forces due to loads belong to the geometric stiffness, or only those of weights and springs.
    """
    found, factors, solution = linear_solution(structure)
    acting = structure
    if not stiffening_loads:
        acting = replace(structure, loads=replace(structure.loads, wrench=0 * structure.loads.wrench))
        _, _, solution = linear_solution(acting)
    state = _forces_at_the_pose(structure, solution)
    loaded = equations(acting, state)
    tangent = Solved.of(loaded.hessian)
    twist = -tangent.solve(equations(structure, state).gradient)[:6]
    negative = tangent.negative + loaded.inner_negative - factors.negative - found.inner_negative
    turn = _largest_rotation(structure, moved_by(structure, at_rest(structure), found, -factors.solve(found.gradient)))
    return _answer(structure, twist, _platform(structure, tangent), found, tangent, factors, negative, turn)


def _forces_at_the_pose(structure, solution):
    """Return the state of the pose, u = ψ = 0, with the forces of a solution."""
    inner = solution.inner.copy()
    inner[:, : -6 * structure.beams.degree] = 0.0
    return State(0 * solution.x, solution.forces, inner)


def load_factors(structure, count=3):
    """Return the smallest positive factors of all forces at which a robot without springs loses its stability at its pose."""
    _, _, solution = linear_solution(structure)
    state = _forces_at_the_pose(structure, solution)
    elastic = equations(structure, state, geometric=False, condense=False).hessian
    geometric = equations(structure, state, condense=False).hessian - elastic
    factors = Solved.of(elastic)
    moving = np.any(geometric != 0, axis=0)
    right = np.zeros((len(elastic), int(moving.sum())))
    right[np.flatnonzero(moving), np.arange(right.shape[1])] = 1.0
    flexibility = factors.solve(right)[moving]
    values, vectors = np.linalg.eigh((flexibility + flexibility.T) / 2)
    half = vectors * np.sqrt(np.maximum(values, 0.0))
    ratios = np.linalg.eigvalsh(-half.T @ geometric[np.ix_(moving, moving)] @ half)[::-1][:count]
    return np.array([1 / ratio if ratio > 1e-9 else np.inf for ratio in ratios])


def in_equilibrium(structure, iterations=12, tolerance=1e-11):
    """Return finite motion and tangent stiffness in the nonlinear equilibrium, by Newton's method, in steps if needed.

    Raises:
        ArithmeticError: the iterations do not converge.
    """
    first, factors, _ = linear_solution(structure)
    for steps in (1, 4, 16):
        state = _followed(structure, np.arange(1, steps + 1) / steps, iterations, tolerance)
        if state is not None:
            break
    else:
        raise ArithmeticError("no equilibrium under these loads")
    found = equations(structure, state)
    tangent = Solved.of(found.hessian)
    negative = tangent.negative + found.inner_negative - factors.negative - first.inner_negative
    compliance, turn = _platform(structure, tangent, state.x[3:6]), _largest_rotation(structure, state)
    return _answer(structure, state.x[:6], compliance, first, tangent, factors, negative, turn)


def _followed(structure, scales, iterations, tolerance):
    """Return the equilibrium under the last one of growing loads; None if an iteration does not converge."""
    state = at_rest(structure)
    for scale in scales:
        for _ in range(iterations):
            found = equations(structure, state, scale=scale)
            step = -Solved.of(found.hessian).solve(found.gradient)
            largest = np.abs(step[: structure.sizes[0]]).max()
            if not largest < 1.0:
                return None
            state = moved_by(structure, state, found, step)
            if largest < tolerance:
                break
        else:
            return None
    return state
