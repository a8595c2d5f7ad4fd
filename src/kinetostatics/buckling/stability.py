"""Critical load factors λ of a robot: 1 + λ F K_g is singular, with the flexibility F and the geometric stiffness K_g.

F and K_g are those of the displacements u of :mod:`kinetostatics.statics.rotation_groups` and of the inner coordinates of beams
(:mod:`kinetostatics.elements.turned_forces`), whose flexibility is 1. K_g is due to all forces and moments of linear theory, at
the unloaded geometry. The stiffness of springs belongs to F; where it is negative, as across a compressed spring, to K_g.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from kinetostatics.description.stiffness_matrix import is_coupled
from kinetostatics.elements.beam import BeamModel
from kinetostatics.elements.beam_formulas import end_displacement
from kinetostatics.elements.turned_forces import INNER
from kinetostatics.math.arrays import Array, Index
from kinetostatics.math.linalg import solve_by_elimination
from kinetostatics.math.screws import move_wrench
from kinetostatics.statics.geometric_stiffness import GeometricStiffness, JunctionWrenches
from kinetostatics.statics.geometric_terms import GeometricTerms
from kinetostatics.statics.robot_statics import RobotStatics
from kinetostatics.statics.rotation_groups import Junction, RotationGroups
from kinetostatics.statics.second_order import at_unloaded_geometry
from kinetostatics.statics.small_motions import SmallMotions
from kinetostatics.statics.solution import Balanced, Solution
from kinetostatics.statics.springs import flexibility

#: Flexibility of scaled displacements, relative to the largest, below which they count as rigid, and their values as rounding.
_RIGID = 1e-13
#: Ratio 1/λ, relative to the largest, below which it counts as rounding.
_ROUNDING = 1e-12


@dataclass(frozen=True)
class BeamEnergy:
    """Strain energy of a beam as a function of u and its inner coordinates.

    Attributes:
        motions: (N, 6, n) displacement and rotation of the end relative to the start per unit of u, beam axes.
        stiffness: (N, 6, 6) of these.
        inner: indices of the beam's inner coordinates, whose stiffness is 1.
    """

    motions: Array
    stiffness: Array
    inner: Index

    def of(self, modes: Array, poses: Index | slice = slice(None)) -> Array:
        """Return twice the strain energies dᵀ K d + Σ η² (P, M) in modes (P, n + b, M) at P of the poses."""
        moved = self.motions[poses] @ modes[:, : self.motions.shape[2]]
        return np.asarray(np.sum(moved * (self.stiffness[poses] @ moved), axis=1) + np.sum(modes[:, self.inner] ** 2, axis=1))


@dataclass(frozen=True)
class Stability:
    """Flexibility and geometric stiffness of a robot at N poses.

    Attributes:
        before, geometric: the equilibrium, and the displacements u.
        generalized_forces: (6, n, N) resultant wrenches on the platform of the unit loads conjugate to u.
        units: (n,) 1 for rotations, 1/L for displacements, with the robot's length L [m]: factors that make u comparable.
        springs: (N, n, n) stiffness of springs, which F contains.
        flexible: F (N, n, n); b inner coordinates of beams have the flexibility 1.
        stiffening: K_g (N, n + b, n + b) of u and the inner coordinates.
        beams: strain energies by beam.
    """

    before: Balanced
    geometric: GeometricStiffness
    generalized_forces: Array
    units: Array
    springs: Array
    flexible: Array
    stiffening: Array
    beams: Mapping[str, BeamEnergy]

    def modes(self, poses: Index | slice = slice(None)) -> tuple[Array, Array]:
        """Return the ratios 1/λ (P, n + b) of forces to critical forces at P of the poses, and the modes (P, n + b, n + b).

        −Lᵀ K_g L y = y/λ with F = L Lᵀ and the mode L y. Modes are columns. The ratios are NaN where F or K_g is not finite.
        """
        A, basis, fine = (array[poses] for array in self._operator)
        ratios, modes = np.linalg.eigh(A)
        modes[:, : basis.shape[1]] = basis @ modes[:, : basis.shape[1]]
        ratios = np.where(np.abs(ratios) > _ROUNDING * np.abs(ratios).max(axis=1, keepdims=True, initial=0.0), ratios, 0.0)
        return np.where(fine[:, None], ratios, np.nan), modes

    def bound(self) -> Array:
        """Return the upper bound √Σ λ⁻² (N,) of the ratios 1/λ; NaN where F or K_g is not finite."""
        A, _, fine = self._operator
        return np.where(fine, np.sqrt(np.sum(A * A, axis=(1, 2))), np.nan)

    @cached_property
    def _operator(self) -> tuple[Array, Array, Array]:
        """Return −Lᵀ K_g L, the matrix L (N, n, n) with F = L Lᵀ, and where both are finite (N,)."""
        n = self.flexible.shape[1]
        fine = np.all(np.isfinite(self.flexible), axis=(1, 2)) & np.all(np.isfinite(self.stiffening), axis=(1, 2))
        F, A = (np.where(fine[:, None, None], matrix, 0.0) for matrix in (self.flexible, -self.stiffening))
        size = np.maximum(np.einsum("nii->ni", F), 0.0)
        comparable = size * self.units**2
        size = np.where(comparable > _RIGID * comparable.max(axis=1, keepdims=True, initial=0.0), np.sqrt(size), 0.0)
        scale = 1 / np.where(size > 0, size, np.inf)
        values, axes = np.linalg.eigh(F * (scale[:, :, None] * scale[:, None]))
        basis = size[:, :, None] * axes * np.sqrt(np.where(values > _RIGID, values, 0.0))[:, None]
        A[:, :n] = np.swapaxes(basis, 1, 2) @ A[:, :n]
        A[:, :, :n] = A[:, :, :n] @ basis
        return A, basis, fine


def stability(robot: RobotStatics, rotation_groups: RotationGroups, solution: Solution, poses: Index) -> Stability:
    """Return F and K_g at some poses of an equilibrium.

    F = Pᵀ C P + F_limbs, with the resultants P of the unit loads and the compliance C; with springs (1 + F K_t)⁻¹ F.
    """
    before, deformation, geometric = at_unloaded_geometry(robot, rotation_groups, solution, poses)
    blocks, N = geometric.coordinates.blocks, len(poses)
    generalized_forces, groups = flexibility(robot, before, geometric)
    F = np.einsum("ian,ijn,jbn->abn", generalized_forces, before.solution.compliance, generalized_forces)
    first = len(F) - sum(map(len, groups))
    for own in groups:
        F[first : first + len(own), first : first + len(own)] += own
        first += len(own)
    K, negative = (_of_springs(geometric, sign) for sign in (1, -1))
    if geometric.springs:
        F = solve_by_elimination(np.eye(len(F))[:, :, None] + np.einsum("abn,bcn->acn", F, K), F)
    terms = geometric.under(before.solution, deformation, before.solution.contributions, own=False, eliminated=False)
    beams, n = [item for item in terms.junctions if item.whole is not None], len(F)
    G = np.zeros((n + INNER * len(beams), n + INNER * len(beams), N))
    G[:n, :n] = terms.matrix(blocks, blocks) + negative
    energies = {}
    for k, item in enumerate(beams):
        assert item.whole is not None
        (whole, axes), inside = item.whole, np.arange(n + INNER * k, n + INNER * (k + 1))
        turned = np.zeros((9, 9, N))
        for row in (0, 3, 6):
            turned[row : row + 3, row : row + 3] = axes
        motions = terms.conjugate(item, turned, blocks)  # transposed
        mixed = np.einsum("akn,kjn->ajn", motions, whole[:9, 9:])
        G[:n, inside], G[inside, :n] = mixed, np.swapaxes(mixed, 0, 1)
        G[np.ix_(inside, inside)] = whole[9:, 9:]
        model = robot.beams[str(item.item.edge.beam)]
        stiffness = _stiffness(model, model.length(before.solution.frames))
        energies[model.name] = BeamEnergy(motions[:, 3:].transpose(2, 1, 0), stiffness, inside)
    F, K, G = (np.moveaxis(matrix + np.swapaxes(matrix, 0, 1), 2, 0) / 2 for matrix in (F, K, G))
    sizes = geometric.coordinates.sizes
    units = np.concatenate([np.full(sizes[block], 1.0 if block[0] == "group" else 1 / robot.length) for block in blocks])
    return Stability(before, geometric, generalized_forces, units, K, F, G, energies)


def _of_springs(geometric: GeometricStiffness, sign: int) -> Array:
    """Return the stiffness (n, n, N) of u due to the positive or negative eigenvalues of the springs' tangent stiffness."""
    springs = []
    for spring in geometric.springs:
        values, axes = np.linalg.eigh(np.nan_to_num(np.moveaxis(spring.tangent, 2, 0)))
        part = sign * np.maximum(sign * values, 0.0)
        springs.append(replace(spring, tangent=np.einsum("nia,na,nja->ijn", axes, part, axes)))
    where, rotation_groups = geometric.coordinates, geometric.rotation_groups
    terms = GeometricTerms(where, rotation_groups, geometric.o, springs, geometric.without_spin, (), (), ())
    return terms.matrix(where.blocks, where.blocks)


def _stiffness(model: BeamModel, length: Array) -> Array:
    """Return the stiffness F⁻¹ (N, 6, 6) of the end of a beam relative to its start, beam axes."""
    units = np.broadcast_to(np.eye(6)[:, :, None], (6, 6, len(length)))
    bends = end_displacement(model.compliances[:, None, None], length, units)
    with np.errstate(divide="ignore", invalid="ignore"):  # a telescope without length
        return np.moveaxis(solve_by_elimination(bends, units), 2, 0)


def estimate(structure: SmallMotions, solution: Solution) -> Array:
    """Return an upper estimate (N,) of the largest ratio of the forces to the critical forces.

    A force or moment in a limb does work of second order as far as the limb's parts turn. They turn by the deformation of the
    limb, at most as if its beams and all elastic joints were in series; and, if there are loops, by the motion of the
    platform, whose displacement is divided by the length of the limb's longest beam. Parts of loops may turn further, but all
    moments and all compliances are added up: the estimate is four times the ratio of a cantilever, and more for other robots.
    """
    model, frames, o, C = structure.model, solution.frames, solution.o, solution.compliance
    if len(model.elastic_links) > len(model.beams):  # how far other links turn is not known
        return np.full_like(C[0, 0], np.inf)
    turning = structure.rotations
    # a force and a moment deform a joint that couples them at most twice as much as if it did not
    coupled = {k for joint in structure.joints if is_coupled(structure.stiffness_of(joint)) for k in joint.columns}
    springs = {
        k: (1 + (k in coupled)) * model.length ** (2 * (k in turning)) / item.stiffness
        for k, item in enumerate(structure.freedoms)
        if item is not None and item.stiffness
    }
    springs.update({item.column: item.times**2 * springs[item.master] for item in structure.followers})
    sheared = {k in turning for k in springs} == {True, False}  # a force does work on a turn and a shift across it
    hinges, slides = (sum(c for k, c in springs.items() if (k in turning) == turns) for turns in (True, False))
    loads = [item.load for item in solution.applied]
    transmitted = JunctionWrenches(model, solution, loads, range(len(solution.contributions)), True)
    centres = model.weights.centres(frames)
    heavy = [centres[:, w] for w in range(centres.shape[1]) if np.any(solution.weights[:3, w])]
    acting = [o, *heavy, *(point for load in loads for point in load.points.values())]
    limbs: dict[int, list[Junction]] = {}
    for item in structure.rotation_groups.junctions:
        limbs.setdefault(item.owner, []).append(item)
    inside, outside, none = np.zeros_like(C[0, 0]), np.zeros_like(C[0, 0]), np.zeros_like(C[0, 0])
    loops = len(limbs) > 1 or not all(model.topology.all_limbs[number].is_serial for number in limbs)
    for junctions in limbs.values():
        moments, soft, longest, before, strongest = none, none + hinges / model.length**2, none, None, none
        for item in junctions:
            arm = frames.point(item.centre.body, item.centre.vector) - o
            wrench = move_wrench(transmitted.on_outer_side(item), arm)
            force, start = _size(wrench[:3]), arm
            strongest = np.maximum(strongest, force)
            if item.inner != item.outer:
                moments = moments + _size(wrench[3:])
            if item.edge.beam is not None:
                beam = model.beams[item.edge.beam]
                length, c = beam.length(frames), beam.compliances
                weight = solution.weights[:3, model.weights.of(f"beam:{beam.name}")].sum(axis=1)
                force, start = force + _size(weight), arm - beam.world_axes(frames)[:, 0] * length
                moments, soft = moments + length * force, soft + length * np.maximum(np.maximum(c[3:4], c[4:5]), c[5:])
                longest = np.maximum(longest, length)
            if before is not None:
                moments = moments + force * _size(start - before)
            before = arm
        longest = longest if any(item.edge.beam for item in junctions) else none + model.length
        with np.errstate(divide="ignore", invalid="ignore"):  # the length of a telescopic beam may be zero
            soft = soft + slides / longest**2
            if sheared:  # the work is at most the force times the root of both compliances, and that at most half their sum
                moments = moments + strongest * longest / 2
            if loops:
                turned = C[3, 3] + C[4, 4] + C[5, 5]
                outside = outside + 2 * moments * (turned + (C[0, 0] + C[1, 1] + C[2, 2]) / longest**2)
                outside = outside + force * _size(arm) * turned
            else:  # the last part carries forces that act at a distance
                farthest = none
                for point in acting:
                    farthest = np.maximum(farthest, _size(point - o - arm))
                moments = moments + force * farthest
            inside = np.maximum(inside, (1 + loops) * moments * soft)
    found: Array = inside + outside
    return found


def _size(vector: Array) -> Array:
    found: Array = np.sqrt(np.sum(vector * vector, axis=0))
    return found
