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

from kinetostatics.elements.beam import BeamModel
from kinetostatics.math.arrays import Array, Index
from kinetostatics.math.linalg import solve_by_elimination
from kinetostatics.statics.geometric_stiffness import GeometricStiffness
from kinetostatics.statics.geometric_terms import GeometricTerms
from kinetostatics.statics.robot_statics import RobotStatics
from kinetostatics.statics.rotation_groups import RotationGroups
from kinetostatics.statics.second_order import at_unloaded_geometry
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
    borders = np.cumsum([n, *(robot.beams[str(item.item.edge.span)].inside.count for item in beams)])
    G = np.zeros((borders[-1], borders[-1], N))
    G[:n, :n] = terms.matrix(blocks, blocks) + negative
    energies = {}
    for k, item in enumerate(beams):
        assert item.whole is not None
        (whole, axes), inside = item.whole, np.arange(borders[k], borders[k + 1])
        turned = np.zeros((9, 9, N))
        for row in (0, 3, 6):
            turned[row : row + 3, row : row + 3] = axes
        motions = terms.conjugate(item, turned, blocks)  # transposed
        mixed = np.einsum("akn,kjn->ajn", motions, whole[:9, 9:])
        G[:n, inside], G[inside, :n] = mixed, np.swapaxes(mixed, 0, 1)
        G[np.ix_(inside, inside)] = whole[9:, 9:]
        model = robot.beams[str(item.item.edge.span)]
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
    bends = model.end_displacement(length, units)
    with np.errstate(divide="ignore", invalid="ignore"):  # a telescope without length
        return np.moveaxis(solve_by_elimination(bends, units), 2, 0)
