"""Solution of a frame with geometric stiffness and with elastic actuators that move several joints.

The geometric stiffness K_G is the second derivative of the second-order energy of springs and weights, which is the sum of three
kinds of terms. A force f of constant direction, on a piece at the arm r, has the energy −½ f·(θ × (θ × r)) under a rotation θ of
the piece. The force and moment of a joint rotate with the mean of the rotations of its two pieces. In a beam with axis direction
e, section force F and moment M, displacement u and rotation θ, the second-order work is ∫ F·(½ θ × (θ × e) − θ × u′) − ½ M·(θ ×
θ′) ds (J. C. Simo and L. Vu-Quoc, Comput. Methods Appl. Mech. Eng. 58, 1986).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from kinetostatics.layout.mapping import ResultMapping
from kinetostatics.math.arrays import Array, frozen
from kinetostatics.verification.frame import Actuator, FrameBeam, FrameJoint, FrameModel
from kinetostatics.verification.opensees import (
    FrameSolution,
    FrameUnits,
    extrapolations,
    inverse,
    solution,
    springs_in_series,
    weights_at_zero,
)

#: Difference of two extrapolated compliances, times the stiffness of the stiffest element, above which only the small stiffness
#: of free directions constrains a motion.
LOOSE = 1e9
#: A stiffness counts as zero below this part of the largest geometric stiffness; a component of a unit motion, below this value.
NOTHING = 1e-6
#: Numbers of elements of a beam for its deflections between its ends, extrapolated in even powers of their length.
ELEMENTS = np.array([8, 12, 17, 24, 34, 48, 68])
#: The iteration of displacement-dependent loads ends at this relative change, or after this number of solutions.
FOLLOWED, PASSES = 1e-12, 4


def solve(model: FrameModel) -> tuple[FrameSolution, FrameSolution]:
    """Solve a frame: first with rigid actuators, then with the deflections of elastic actuators that move several joints.

    Returns:
        The solution; and a solution extrapolated from all levels and meshes but the last ones, to estimate the accuracy.

    Raises:
        OpenSeesError: OpenSeesPy is missing, cannot be loaded, or failed.
    """
    soft = [actuator for actuator in model.actuators if np.isfinite(actuator.stiffness)]
    rigid = _solve(model, model)
    units = [_solve(_by_unit_deflection(model, actuator), model) for actuator in soft]
    first, second = (_with_elastic_actuators(model, soft, rigid[k], [unit[k] for unit in units]) for k in (0, 1))
    return first, second


def _by_unit_deflection(model: FrameModel, actuator: Actuator) -> FrameModel:
    """Return the unloaded frame whose assembly errors are the joint displacements by a unit deflection of an actuator."""
    by = {part.joint: (ratio, part) for ratio, part in actuator.moves}
    joints = []
    for joint in model.joints:
        ratio, part = by.get(joint.name, (0.0, None))
        along = np.zeros(3) if part is None else ratio * part.axis
        parts = (np.zeros(3), along) if part is not None and part.rotates else (along, np.zeros(3))
        joints.append(replace(joint, assembly_error=np.concatenate(parts)))
    beams = tuple(replace(beam, load=np.zeros(6), length_error=0.0) for beam in model.beams)
    return replace(model, loads=np.zeros_like(model.loads), beams=beams, joints=tuple(joints))


def _with_elastic_actuators(
    model: FrameModel, soft: Sequence[Actuator], rigid: FrameSolution, units: Sequence[FrameSolution]
) -> FrameSolution:
    """Add the deflections w of elastic actuators to the solution ``rigid``.

    The deflections satisfy f₀ + G w = −k w, with the actuator forces f₀ of ``rigid``, the actuator forces G by unit deflections
    (the solutions ``units``), and the stiffnesses k. By reciprocity, the actuator forces under a unit load on the platform are
    the negative displacements of the platform by unit deflections.
    """
    if not soft:
        return rigid
    G = np.array([[unit.actuator_forces[actuator.name] for unit in units] for actuator in soft])
    yielding = np.linalg.inv(G + np.diag([actuator.stiffness for actuator in soft]))
    w = -yielding @ [rigid.actuator_forces[actuator.name] for actuator in soft]
    moved = np.stack([unit.twist for unit in units], axis=1)

    def summed(pick: Callable[[FrameSolution], Mapping[str, Array]]) -> Mapping[str, Array]:
        return ResultMapping(
            {
                name: frozen(value + sum(a * pick(unit)[name] for a, unit in zip(w, units, strict=True)))
                for name, value in pick(rigid).items()
            }
        )

    C = rigid.compliance + moved @ yielding @ moved.T
    forces = {
        name: force + sum(a * unit.actuator_forces[name] for a, unit in zip(w.tolist(), units, strict=True))
        for name, force in rigid.actuator_forces.items()
    }
    return replace(
        rigid,
        twist=frozen(rigid.twist + moved @ w),
        compliance=frozen(C),
        stiffness=frozen(inverse(C, model.length)),
        joint_wrenches=summed(lambda solution: solution.joint_wrenches),
        beam_wrenches=summed(lambda solution: solution.beam_wrenches),
        actuator_forces=ResultMapping(forces),
    )


def _solve(model: FrameModel, robot: FrameModel) -> tuple[FrameSolution, FrameSolution]:
    """Solve ``model`` like :func:`solve`, with rigid actuators and the geometric stiffness of ``robot``."""
    scale = FrameUnits(model)
    answers = _with_geometric_stiffness(model, robot, scale) if model.springs else extrapolations(model, scale, [model.platform])
    all_levels, one_less = (solution(model, scale, raw) for raw in answers)
    return all_levels, one_less


def _with_geometric_stiffness(
    model: FrameModel, robot: FrameModel, scale: FrameUnits
) -> tuple[dict[str, Array], dict[str, Array]]:
    """Return results like :func:`extrapolations`, with the geometric stiffness K_G of the forces at the pose.

    OpenSees computes these forces, the displacements u₀ without K_G, and the compliance C of all pieces under unit loads. The
    displacements are u = (1 + C K_G)⁻¹ u₀. To remove rounding errors of C, the frame is solved again with the further loads −K_G
    u; the difference between its displacements and u corrects u. This is repeated until these loads no longer change. The second
    results are without the finest mesh of beams, too.
    """
    pieces = [model.platform, *(piece for piece in range(len(model.references)) if piece not in (model.base, model.platform))]
    at_the_pose, loaded = extrapolations(robot.at_the_pose, scale, pieces), extrapolations(model, scale, pieces)
    rows = np.concatenate([6 * piece + np.arange(6) for piece in pieces])
    first = np.cumsum([0, *(len(springs_in_series(joint)) for joint in model.joints)])[:-1]
    solutions = []
    # the two compliances differ only in motions constrained by nothing but the small stiffness of free directions
    difference = loaded[0]["compliance"] - loaded[1]["compliance"]
    for forces, raw, meshes in zip(at_the_pose, loaded, (ELEMENTS, ELEMENTS[:-1]), strict=True):
        K, bent = geometric_stiffness(robot, forces["springs"][first] * scale.wrench, forces["beams"] * scale.wrench, meshes)
        bent = bent[rows] / np.tile(scale.wrench, len(pieces))
        K = K[np.ix_(rows, rows)] * np.tile(scale.twist, len(pieces)) / np.tile(scale.wrench, len(pieces))[:, None]
        constrained = _constrained(difference, K)
        K, C = constrained @ K @ constrained, constrained @ raw["compliance"] @ constrained
        tangent = np.eye(len(K)) + C @ K
        moved = np.linalg.solve(tangent, constrained @ np.column_stack([raw["twist"] - C @ bent, C[:, :6]]))
        solutions.append((moved[:6, 1:], np.linalg.solve(tangent, constrained), moved[:, 0], K, bent))
    answers = []
    for number, (forces, (compliance, solved, moved, K, bent)) in enumerate(zip(at_the_pose, solutions, strict=True)):
        for _ in range(PASSES):
            loads = model.loads.copy()
            loads[pieces] -= (K @ moved + bent).reshape(-1, 6) * scale.wrench
            raw = extrapolations(replace(model, loads=loads), scale, pieces)[number]
            step = solved @ (raw["twist"] - moved)
            moved = moved + step
            if np.abs(K @ step).max(initial=0.0) <= FOLLOWED * np.abs(K @ moved).max(initial=0.0):
                break
        turns = np.zeros((len(model.references), 3))
        turns[pieces] = moved.reshape(-1, 6)[:, 3:] * scale.twist[3:]
        springs = raw["springs"].copy()
        for joint, row in zip(model.joints, first, strict=True):
            # _joint_stiffness rotates a wrench with the mean of the joint's pieces, the analysis with the mean of the compound
            # joint's pieces
            hinges, ends = robot.compound_of(joint)
            turn = np.mean(turns[list(joint.pieces)] - turns[list(ends)], axis=0)
            springs[row] += np.cross(turn, forces["springs"][row].reshape(2, 3)).ravel()
            if len(hinges) == 2:  # a universal joint transmits only a moment about the common normal of its axes
                normal = np.cross(hinges[0].axes[:, 0], hinges[1].axes[:, 0])
                springs[row, 3:] = normal * (springs[row, 3:] @ normal) / (normal @ normal)
        answers.append(raw | {"springs": springs, "twist": moved[:6], "compliance": compliance})
    return answers[0], answers[1]


def _constrained(difference: Array, K: Array) -> Array:
    """Return the projection (n, n) that removes motions without stiffness, except motions of the platform, the first piece.

    A removed motion is, for example, the spin of a strut between two spherical joints.

    Args:
        difference: (n, n) difference of the compliances extrapolated from all levels and from all levels but the last; zero for
            motions that the robot resists even without the small stiffness added to free directions.
        K: (n, n) the geometric stiffness.
    """
    values, vectors = np.linalg.eigh((difference + difference.T) / 2)
    free = vectors[:, np.abs(values) > LOOSE]
    values, turned = np.linalg.eigh(free.T @ K @ free)
    spins = free @ turned[:, np.abs(values) <= NOTHING * np.abs(K).max(initial=0.0)]
    values, turned = np.linalg.eigh(spins[:6].T @ spins[:6])
    spins = spins @ turned[:, values <= NOTHING**2]
    return np.asarray(np.eye(len(K)) - spins @ spins.T)


def geometric_stiffness(model: FrameModel, joints: Array, beams: Array, meshes: Array) -> tuple[Array, Array]:
    """Return the geometric stiffness (6n, 6n) of n pieces about their reference points, including the stiffness of springs.

    The second result (6n,) are forces due to deflections of beams under their weight between fixed ends.

    Args:
        joints: (joints, 6) wrench of the inner piece on the outer piece at the pose, about the joint's centre [N, N·m].
        beams: (beams, 2, 6) wrenches on both ends of each beam at the pose, about these ends [N, N·m].
        meshes: numbers of elements of each beam, from which its stiffness is extrapolated.
    """
    n = 6 * len(model.references)
    K, bent = np.zeros((n, n)), np.zeros(n)

    def put(pieces: tuple[int, ...], block: Array) -> None:
        rows = np.concatenate([6 * piece + np.arange(6) for piece in pieces])
        np.add.at(K, np.ix_(rows, rows), block)

    def acts(piece: int, point: Array, force: Array) -> None:
        K[6 * piece + 3 : 6 * piece + 6, 6 * piece + 3 : 6 * piece + 6] += _arm_stiffness(force, point - model.references[piece])

    def moves(pieces: tuple[int, int], points: Array) -> Array:
        """Return the displacements (2, 6, 12) of one point of each of two pieces, by the displacements of the pieces."""
        displacements = np.zeros((2, 6, 12))
        for side, (piece, point) in enumerate(zip(pieces, points, strict=True)):
            displacements[side, :, 6 * side : 6 * side + 6] = np.eye(6)
            displacements[side, :3, 6 * side + 3 : 6 * side + 6] = -_cross(point - model.references[piece])
        return displacements

    for piece, point, force in model.point_forces:
        acts(piece, point, force)
    for spring in model.springs:
        first, second = moves(spring.pieces, spring.points)[:, :3]
        apart = spring.axes.T @ (second - first)
        put(spring.pieces, apart.T @ (spring.stiffness[:, None] * apart))
    for joint, wrench in zip(model.joints, joints, strict=True):
        for piece, sign in zip(joint.pieces, (-1, 1), strict=True):
            acts(piece, joint.point, sign * wrench[:3])
        put(joint.pieces, _joint_stiffness(joint, wrench, *moves(joint.pieces, np.array([joint.point] * 2))))
    for beam, ends in zip(model.beams, beams, strict=True):
        for piece, point, end in zip(beam.pieces, beam.points, ends, strict=True):
            acts(piece, point, -end[:3])
        moved = np.vstack(list(moves(beam.pieces, beam.points)))
        by_mesh = [_divided_beam(beam, ends[1], int(count)) for count in meshes]
        weights = weights_at_zero(1 / meshes**2)
        block, forces = (np.tensordot(weights, np.array(values), 1) for values in zip(*by_mesh, strict=True))
        put(beam.pieces, moved.T @ block @ moved)
        for piece, part in zip(beam.pieces, np.split(moved.T @ forces, 2), strict=True):
            bent[6 * piece : 6 * piece + 6] += part
    return K, bent


def _cross(v: Array) -> Array:
    """Return the matrix (3, 3) of the cross product with ``v``."""
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def _arm_stiffness(force: Array, arm: Array) -> Array:
    """Return the second derivative (3, 3) of −½ f·(θ × (θ × r)) by θ."""
    return np.asarray((force @ arm) * np.eye(3) - (np.outer(force, arm) + np.outer(arm, force)) / 2)


def _symmetric(matrix: Array) -> Array:
    return np.asarray(matrix + matrix.T)


def _joint_stiffness(joint: FrameJoint, wrench: Array, inner: Array, outer: Array) -> Array:
    """Return the second derivative (12, 12) of −F·d − M·φ for the force F and the moment M of a joint.

    d is the displacement of the joint's centre on the outer piece relative to its centre on the inner piece, in the mean of both
    pieces' axes; φ is the relative rotation vector, to second order θ₂ − θ₁ − ½ θ₁ × θ₂ for the rotations θ₁ of the inner and θ₂
    of the outer piece. The second-order displacements of the centres are left to :func:`_arm_stiffness`.

    Args:
        wrench: (6,) F and M, of the inner piece on the outer piece [N, N·m].
        inner, outer: (6, 12) displacements of the centre on each piece by the displacements of the two pieces.
    """
    mean, apart = (inner[3:] + outer[3:]) / 2, outer[:3] - inner[:3]
    stiffness = _symmetric(outer[3:].T @ _cross(wrench[3:]) @ inner[3:] / 2 - mean.T @ _cross(wrench[:3]) @ apart)
    if joint.cross is None:
        return stiffness
    # the joint constrains the angle between its axes a and b, not the rotation about a × b: a·b changes by
    # −(θ₂ − θ₁)·(a × b) + ½ b·(θ₁ × (θ₁ × a)) + ½ a·(θ₂ × (θ₂ × b)) + (θ₁ × a)·(θ₂ × b)
    a, b = joint.cross
    normal = np.cross(a, b)
    angle = inner[3:].T @ _arm_stiffness(b, a) @ inner[3:] + outer[3:].T @ _arm_stiffness(a, b) @ outer[3:]
    angle -= _symmetric(inner[3:].T @ _cross(a).T @ _cross(b) @ outer[3:])
    turn = -_symmetric(outer[3:].T @ _cross(normal) @ inner[3:] / 2)
    return np.asarray(stiffness - wrench[3:] @ normal / (normal @ normal) * (angle - turn))


def _divided_beam(beam: FrameBeam, end: Array, elements: int) -> tuple[Array, Array]:
    """Return the geometric stiffness (12, 12) of a beam in elements, for the displacements of its ends, and forces (12,).

    The results are the differences of eliminating the inner nodes with and without geometric stiffness.
    """
    short = beam.length / elements
    points = beam.divided(elements)
    n = 6 * len(points)
    elastic, geometric, load = np.zeros((n, n)), np.zeros((n, n)), np.zeros(n)
    R = np.kron(np.eye(2), beam.axes)
    e, units = np.array([1.0, 0, 0]), np.eye(12)
    q = R.T @ beam.load
    element = replace(beam, points=points[:2])
    of_weight = _beam_stiffness(element, np.zeros(6), units[:6], units[6:])
    weightless = replace(element, load=np.zeros(6))
    by_wrench = np.array([_beam_stiffness(weightless, unit, units[:6], units[6:]) for unit in np.eye(6)])
    for k in range(elements):
        rows = slice(6 * k, 6 * k + 12)
        beyond = beam.length - short * (k + 1)
        arm = beam.axes[:, 0] * beyond
        force = end[:3] + beyond * beam.load[:3]
        moment = end[3:] + np.cross(arm, end[:3]) + beyond * (np.cross(arm, beam.load[:3]) / 2 + beam.load[3:])
        geometric[rows, rows] += of_weight + np.tensordot(np.concatenate([force, moment]), by_wrench, 1)
        rigid = np.eye(6)
        rigid[:3, 3:] = -short * _cross(e)
        apart = np.hstack([-rigid @ R.T, R.T])
        stiffness = np.linalg.inv(_cantilever_displacements(element, short))
        elastic[rows, rows] += apart.T @ stiffness @ apart
        sag = np.zeros(6)
        for place, share in zip(*np.polynomial.legendre.leggauss(3), strict=True):
            sag += _cantilever_displacements(element, short * (1 + place) / 2).T @ q * (share * short / 2)
        total = np.concatenate([q[:3] * short, q[3:] * short + np.cross(e, q[:3]) * short**2 / 2])
        load[rows] += apart.T @ stiffness @ sag + np.concatenate([R @ total, np.zeros(6)])
    ends, inner = np.r_[0:6, n - 6 : n], np.arange(6, n - 6)
    with_K_G, without = (
        np.linalg.solve(K[np.ix_(inner, inner)], np.column_stack([K[np.ix_(inner, ends)], load[inner]]))
        for K in (elastic + geometric, elastic)
    )
    moved, back = np.zeros((n, 13)), np.zeros((n, 12))
    moved[ends, :12], moved[inner] = np.eye(12), without * np.append(-np.ones(12), 1.0)
    back[ends], back[inner] = np.eye(12), -with_K_G[:, :12]
    difference = back.T @ geometric @ moved  # the difference of the two eliminations, without cancellation
    return difference[:, :12], difference[:, 12]


def _beam_stiffness(beam: FrameBeam, end: Array, first: Array, last: Array) -> Array:
    """Return the second derivative (12, 12) of the second-order work in a beam that has the linear bending shape.

    Args:
        end: (6,) wrench on its outer end [N, N·m].
        first, last: (6, 12) displacements of its inner and outer end by the displacements of its two pieces.
    """
    L, R = beam.length, np.kron(np.eye(2), beam.axes)
    first, last = R.T @ first, R.T @ last
    force, moment, weight, turning = (beam.axes.T @ v for v in (end[:3], end[3:], beam.load[:3], beam.load[3:]))
    of_weight = _arm_stiffness(weight, beam.axes.T @ beam.lever)
    e = np.array([1.0, 0, 0])

    def rigid(s: float) -> Array:
        return np.vstack([first[:3] - s * _cross(e) @ first[3:], first[3:]])

    wrench = np.linalg.solve(_cantilever_displacements(beam, L), last - rigid(L))
    stiffness = np.zeros((12, 12))
    for place, share in zip(*np.polynomial.legendre.leggauss(3), strict=True):  # the integrand is of the fifth degree
        s = L * (1 + place) / 2
        arm = (L - s) * e
        F = force + (L - s) * weight
        M = moment + np.cross(arm, force) + (L - s) * (np.cross(arm, weight) / 2 + turning)
        theta = (rigid(s) + _cantilever_displacements(beam, s) @ wrench)[3:]
        slopes = _cantilever_displacements(beam, s, 1) @ wrench
        along = slopes[:3] - _cross(e) @ first[3:]
        part = _symmetric(theta.T @ _cross(F) @ along + theta.T @ _cross(M) @ slopes[3:] / 2)
        stiffness += share * L / 2 * (part + theta.T @ (of_weight - _arm_stiffness(F, e)) @ theta)
    return stiffness


def _cantilever_displacements(beam: FrameBeam, s: float, derivative: int = 0) -> Array:
    """Return the displacements (6, 6) at the arc length s of a beam, clamped at its inner end, by unit wrenches on its outer end.

    With ``derivative`` 1, return the derivatives of these displacements by s.
    """
    L, (EA, GA_y, GA_z, GJ, EI_y, EI_z) = beam.length, beam.stiffness
    linear, quadratic, cubic = ((s, s**2 / 2, s**3 / 6), (1.0, s, s**2 / 2))[derivative]
    displacements = np.diag([linear / EA, linear / GA_y, linear / GA_z, linear / GJ, linear / EI_y, linear / EI_z])
    displacements[1, 1] += (L * quadratic - cubic) / EI_z
    displacements[2, 2] += (L * quadratic - cubic) / EI_y
    displacements[1, 5], displacements[5, 1] = quadratic / EI_z, (L * linear - quadratic) / EI_z
    displacements[2, 4], displacements[4, 2] = -quadratic / EI_y, -(L * linear - quadratic) / EI_y
    return displacements
