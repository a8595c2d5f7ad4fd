"""Springs between points of two links: their forces at the pose, and the equilibrium of robots with springs.

The change K_t u of a spring's force (:mod:`kinetostatics.elements.spring`), and the change of moments as the arms of weights and
springs rotate, are the geometric stiffness K_g of the robot. The spring forces are applied as loads on links, and the effect of
K_g as further loads −K_g u; the displacements u are defined in :mod:`kinetostatics.statics.rotation_groups`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import partial

import numpy as np

from kinetostatics.description.elements import Spring
from kinetostatics.elements.spring import PlacedSpring
from kinetostatics.math.arrays import Array, Index, Mask
from kinetostatics.math.linalg import solve_by_elimination
from kinetostatics.mechanism.tree import Frames
from kinetostatics.statics.deformation import Deformation, deform
from kinetostatics.statics.geometric_stiffness import GeometricStiffness
from kinetostatics.statics.geometric_terms import GeometricTerms
from kinetostatics.statics.link_loads import AppliedLoad, attachments_at
from kinetostatics.statics.loaded_poses import LoadedPoses
from kinetostatics.statics.robot_statics import RobotStatics
from kinetostatics.statics.rotation_groups import RotationGroups
from kinetostatics.statics.singularity import parts_of_batch
from kinetostatics.statics.solution import Balanced, Solution, balanced, unit_responses, with_more

#: Eigenvalue of a tangent stiffness, relative to the elastic one, up to which a motion is unstable.
_UNSTABLE = 1e-9
#: Relative stiffness of a support for the forces of a platform that springs alone hold.
_SUPPORT = 1e-9
#: Length of a spring, relative to the robot's size, below which its force has no direction.
_NOTHING = 1e-9


def placed_springs(robot: RobotStatics, frames: Frames) -> list[PlacedSpring]:
    """Return all springs at given frames; the force of a spring of zero length is NaN.

    Raises:
        ArgumentError: a spring is attached to an elastic link, but not at the end of a beam.
    """
    if robot.rotation_groups is None:
        return []
    springs = robot.description.springs.values()
    ends = zip(springs, robot.rotation_groups.spring_attachments, strict=True)
    return [_placed(robot, spring, attachments, frames) for spring, attachments in ends]


def _placed(robot: RobotStatics, spring: Spring, attachments: tuple[str, str], frames: Frames) -> PlacedSpring:
    points = []
    what = f"spring {spring.name!r}" if spring.place.line is None else f"{spring.place}: spring {spring.name!r}"
    for link, local in ((spring.predecessor, spring.predecessor_point), (spring.successor, spring.successor_point)):
        body, placement = robot.mechanism.body_of[link]
        points.append(frames.point(body, placement[:3, :3] @ np.array(local) + placement[:3, 3]))
        attachments_at(robot, what, link, frames, points[-1])  # checks that an end of a beam is there
    return PlacedSpring.between(spring, (points[0], points[1]), attachments, _NOTHING * robot.length)


def contribution_names(robot: RobotStatics, applied: Iterable[AppliedLoad] = ()) -> tuple[str, ...]:
    """Return the names of the contributions to the twist: load, weights, loads on links, springs."""
    return (*robot.contributions, *(item.name for item in applied), *(f"spring {name}" for name in robot.description.springs))


def solve_with_springs(robot: RobotStatics, given: LoadedPoses) -> Solution:
    """Solve Eq. (12) as :func:`kinetostatics.statics.solution.balanced` does, with the robot's springs: C_t = (1 + C S)⁻¹ C.

    S is the stiffness that springs and rotating forces add to the platform, see :func:`response`.
    """
    if robot.rotation_groups is None:
        return balanced(robot, given).solution
    frames = given.frames
    springs, o = placed_springs(robot, frames), robot.mechanism.platform_pose(frames)[1]
    before = under_springs(robot, given, springs)
    solution, geometric = before.solution, GeometricStiffness(robot, robot.rotation_groups, frames, springs)
    deformation = deform(robot, solution)
    terms = geometric.under(solution, deformation)
    u, twists, tangents, compliance = response(robot, geometric, terms, before, deformation)
    found = with_more(robot, before, terms.loads(u), [f"change with {name}" for name in solution.contributions], twists)
    rigid = np.where(solution.singular, np.nan, solution.stiffness)
    stiffness = inverse(compliance, rigid, robot.length)
    sound = compliance.sum(axis=(0, 1)) + sum((item.force.sum(axis=0) for item in springs), np.zeros_like(o[0]))
    singular = found.singular | ~np.isfinite(sound)
    return replace(found, compliance=compliance, stiffness=stiffness, tangents=tangents, singular=singular)


def under_springs(robot: RobotStatics, given: LoadedPoses, springs: Iterable[PlacedSpring]) -> Balanced:
    """Solve Eq. (12) under the forces of springs, without geometric stiffness."""
    _, o = robot.mechanism.platform_pose(given.frames)
    forces = (AppliedLoad(f"spring {item.name}", *item.end_wrenches(item.force, o), "spring") for item in springs)
    return balanced(robot, replace(given, applied=(*given.applied, *forces)))


def geometric_stiffness(
    robot: RobotStatics, rotation_groups: RotationGroups, given: LoadedPoses, motion: Callable[[str], Array]
) -> tuple[Array, Array, Mask]:
    """Return the displacements u (n, k, N) per unit of k coordinates, and the geometric stiffness K_g (n, n, N).

    The third result (N,) is True where a beam buckles between fixed ends. K_g is the one of :func:`solve_with_springs`,
    without the tangent stiffness of the springs themselves.

    Args:
        rotation_groups: the groups that rotate relative to one another in the coordinates.
        given: the poses with gravity and loads on links; springs are added.
        motion: ``motion(attachment)`` (6, k, N) is the twist of an attachment about o per unit of each coordinate.
    """
    springs = placed_springs(robot, given.frames)
    geometric = GeometricStiffness(robot, rotation_groups, given.frames, springs)
    blocks = geometric.coordinates.blocks
    first = under_springs(robot, given, springs).solution
    terms = geometric.under(first, deform(robot, first), own=False)
    found, buckled = terms.matrix(blocks, blocks), unstable_motions(terms.inner, len(first.singular)) > 0
    special = {
        at.start: groups for at, groups in parts_of_batch(robot, given.frames, first.o, first.statics, first.doubtful) if groups
    }
    for pose in sorted({*special, *np.flatnonzero(first.singular).tolist()}):
        at = slice(pose, pose + 1)
        here = replace(given.take(at), groups=special.get(pose), support=_SUPPORT * bool(first.singular[pose]))
        springs = placed_springs(robot, here.frames)
        solution = under_springs(robot, here, springs).solution
        geometric_here = GeometricStiffness(robot, rotation_groups, here.frames, springs)
        terms = geometric_here.under(solution, deform(robot, solution), own=False)
        found[..., at], buckled[at] = terms.matrix(blocks, blocks), unstable_motions(terms.inner, 1) > 0
    return geometric.displacements(motion, blocks), found, buckled


def unstable_motions(tangents: Iterable[Array], N: int) -> Index:
    """Return the number (N,) of eigenvalues ≤ 0 of matrices 1 + K_g F (n, n, N), see :attr:`Solution.tangents`."""
    found = np.zeros(N, dtype=np.intp)
    for tangent in tangents:
        matrix = np.nan_to_num(np.moveaxis(tangent, 2, 0))
        change = matrix - np.eye(len(tangent))
        largest = np.einsum("nij,nji->n", change, change)  # sum of squares of the eigenvalues of the change, which are real
        doubtful = np.flatnonzero(~(largest < (1 - _UNSTABLE) ** 2))
        found[doubtful] += np.sum(np.linalg.eigvals(matrix[doubtful]).real < _UNSTABLE, axis=1)
    return found


def response(
    robot: RobotStatics, geometric: GeometricStiffness, K: GeometricTerms, before: Balanced, deformation: Deformation
) -> tuple[Array, Array, tuple[Array, ...], Array]:
    """Return the displacements u (n, S, N), the twists (6, S, N), :attr:`Solution.tangents`, and the compliance (6, 6, N).

    With the twist Δ of the platform and the changes t of the forces, the displacements are u = u_0 + U Δ + F t in limbs and P Δ
    on the platform. Then t = −K_g u and Δ = Δ_0 + C (Uᵀ t + Pᵀ t_platform), with the twist Δ_0 and the compliance C of the
    platform without K_g, and the changes t_platform conjugate to P Δ. Loads along beams add constants to t. In each limb
    (1 + K_g F) t = −K_g (u_0 + U Δ). The platform is left with the forces −(s_0 + S Δ): Δ = (1 + C S)⁻¹ (Δ_0 − C s_0), and its
    compliance is C_t = (1 + C S)⁻¹ C.
    """
    solution, where, S = before.solution, geometric.coordinates, len(before.solution.contributions)
    generalized_forces, flexibilities = flexibility(robot, before, geometric)
    u_0 = _displacements(robot, solution, geometric, deformation)
    rows = [k for kind, _ in where.platform for k in ((0, 1, 2) if kind == "shift" else (3, 4, 5))]
    P = np.eye(6)[rows][:, :, None]
    K_p, none = K.matrix(where.platform, where.platform), np.zeros_like(solution.twists[rows])
    parts = [(none + K.constant(where.platform, S), np.einsum("abn,bin->ain", K_p, P))]
    all_forces = [np.broadcast_to(P, (*P.shape[:2], none.shape[2]))]
    tangents, lefts, first = [*K.inner], [], len(rows)
    for blocks, F in zip(where.inside, flexibilities, strict=True):
        here = slice(first, first + len(F))
        U = np.swapaxes(generalized_forces[:, here], 0, 1)
        both = np.concatenate([u_0[here] - np.einsum("ain,isn->asn", U, solution.twists), U], axis=1)
        own = K.matrix(blocks, blocks)
        to_platform = K.matrix(blocks, where.platform)
        tangent = np.eye(len(F))[:, :, None] + np.einsum("abn,bcn->acn", own, F)
        right = np.einsum("abn,bsn->asn", own, both)
        right += np.einsum("abn,bsn->asn", to_platform, np.concatenate([none, all_forces[0]], axis=1))
        right[:, :S] += K.constant(blocks, S)
        found = _solved(tangent, right)
        left = both - np.einsum("abn,bsn->asn", F, found)
        lefts.append(left)
        back = np.einsum("ban,bsn->asn", to_platform, left)
        parts[0] = parts[0][0] + back[:, :S], parts[0][1] + back[:, S:]
        parts.append((found[:, :S], found[:, S:]))
        all_forces.append(both[:, S:])
        tangents.append(tangent)
        first = here.stop
    unit = np.repeat([1.0, robot.length], 3)[:, None, None]
    condensed = np.concatenate([np.concatenate(pair, axis=1) for pair in parts])
    s = np.einsum("ain,asn->isn", np.concatenate(all_forces), condensed) / unit
    compliance = solution.compliance * unit * np.swapaxes(unit, 0, 1)
    tangent = np.eye(6)[:, :, None] + np.einsum("ijn,jkn->ikn", compliance, s[:, S:] / np.swapaxes(unit, 0, 1))
    right = np.concatenate([solution.twists * unit - np.einsum("ijn,jsn->isn", compliance, s[:, :S]), compliance], axis=1)
    answer = _solved(np.where(solution.singular, np.nan, tangent), right)
    twists = np.where(solution.singular, solution.twists, answer[:, :S] / unit)
    u = [twists[rows], *(left[:, :S] + np.einsum("ain,isn->asn", left[:, S:], twists) for left in lefts)]
    compliance = answer[:, S:] / unit / np.swapaxes(unit, 0, 1)
    return np.concatenate(u), twists, (*tangents, tangent), (compliance + np.swapaxes(compliance, 0, 1)) / 2


def flexibility(robot: RobotStatics, before: Balanced, geometric: GeometricStiffness) -> tuple[Array, list[Array]]:
    """Return the flexibility of u inside of limbs with a fixed platform, and the generalized forces on the platform.

    Returns:
        (P, F): resultant wrenches (6, n, N) on the platform of the unit loads conjugate to u; and for each group of blocks
        their displacements F (m, m, N) under these loads.
    """
    generalized_forces, fixed = unit_responses(robot, before, geometric.unit_loads())
    motion, where = partial(motion_of, robot, fixed, deform(robot, fixed)), geometric.coordinates
    found, first, S = [], sum(where.sizes[block] for block in where.platform), len(before.solution.contributions)
    for blocks in where.inside:
        size = sum(where.sizes[block] for block in blocks)
        found.append(geometric.displacements(motion, blocks)[:, S + first : S + first + size])
        first += size
    return generalized_forces, found


def _solved(matrix: Array, right: Array) -> Array:
    """Return the solutions (n, m, N) of ``matrix`` x = ``right``; 0 where an equation is not finite."""
    fine = np.all(np.isfinite(matrix), axis=(0, 1)) & np.all(np.isfinite(right), axis=(0, 1))
    return solve_by_elimination(np.where(fine, matrix, np.eye(len(matrix))[:, :, None]), np.where(fine, right, 0.0))


def _displacements(robot: RobotStatics, solution: Solution, geometric: GeometricStiffness, deformation: Deformation) -> Array:
    """Return the displacements u (n, S, N) due to every contribution.

    The sag of bodies attached only to the base belongs to no contribution; it is added to the contribution of the first spring,
    or of the load.
    """
    motion = partial(motion_of, robot, solution, deformation)
    u = geometric.displacements(motion, geometric.coordinates.blocks)
    first = [k for k, item in enumerate(solution.contributions) if item.startswith("spring ")] or [0]
    u[:, first[:1]] += u[:, -1:]
    return u[:, :-1]


def motion_of(robot: RobotStatics, solution: Solution, deformation: Deformation, attachment: str) -> Array:
    """Return the twists (6, S + 1, N) of an attachment (a rigid link or end of a beam) about o, by contribution.

    The last twist is due to the weight of bodies attached only to the base; it is 0 unless the attachment is on one of them.
    """
    topology, none = robot.topology, np.zeros_like(solution.twists[:, :1])
    found = solution.twists if attachment in topology.platform.attachments else np.zeros_like(solution.twists)
    if attachment in topology.carried_by:
        found = deformation.motions[topology.carried_by[attachment]]
    return found if found.shape[1] > len(solution.contributions) else np.concatenate([found, none], axis=1)


def inverse(compliance: Array, rigid: Array, length: float) -> Array:
    """Return the stiffness C⁻¹ (6, 6, N) of a compliance C; NaN where it is singular, or where ``rigid`` (6, 6, N) is NaN."""
    unit = np.repeat([1.0, length], 3)
    scale = (unit[:, None] * unit)[:, :, None]
    scaled = compliance * scale
    fine = np.all(np.isfinite(scaled), axis=(0, 1)) & np.all(np.isfinite(rigid), axis=(0, 1))
    eye = np.eye(6)[:, :, None]
    found = solve_by_elimination(np.where(fine, scaled, eye), np.broadcast_to(eye, scaled.shape))
    return np.where(fine, (found + np.swapaxes(found, 0, 1)) / 2 * scale, np.nan)
