"""Twist and compliance of the platform to second order in the forces.

At the displaced pose the stiffness of a robot differs from that of linear theory by terms of first order in the forces. With the
internal forces S(v) in a small motion v, the geometric stiffness K_g(S) is linear in S, and the third derivative of the energy
along the displacement x and two motions v and w is K_g(S(x))[v, w] + K_g(S(v))[x, w] + K_g(S(w))[x, v]: the forces act at the
unloaded geometry (first term), and the displacement changes the geometry on which elastic forces act (the others). The first term
is part of the tangent stiffness, and therefore exact at any size; the others are of first order.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from kinetostatics.math.arrays import Array, Index
from kinetostatics.statics.deformation import Deformation, deform
from kinetostatics.statics.geometric_stiffness import GeometricStiffness
from kinetostatics.statics.link_loads import AppliedLoad
from kinetostatics.statics.loaded_poses import LoadedPoses
from kinetostatics.statics.robot_statics import RobotStatics
from kinetostatics.statics.rotation_groups import RotationGroups
from kinetostatics.statics.solution import Balanced, Solution, balanced
from kinetostatics.statics.springs import placed_springs, response, unstable_motions

#: Compliance, relative to the largest, below which the platform is rigid.
_RIGID = 1e-9
#: Number of halvings in (1 + X / 2ⁿ)^(2ⁿ), for exp(X).
_HALVINGS = 20


@dataclass(frozen=True)
class Changes:
    """Results of second order at N poses; NaN where the robot buckles.

    Attributes:
        twist, compliance: (6, N) and (6, 6, N), about o [m, rad; m/N, …].
        stiffness: (6, N) relative changes of the principal stiffnesses of the platform.
        motions: (6, 6, N) the motions against which they resist, as columns, with rotations multiplied by the robot's length; 0
            where the platform is rigid or the robot buckles.
    """

    twist: Array
    compliance: Array
    stiffness: Array
    motions: Array


#: Names of unit loads on the platform.
UNITS = tuple(f"unit load {k}" for k in range(6))


@dataclass(frozen=True)
class Tangent:
    """Tangent stiffness at the unloaded geometry with all forces of linear theory.

    Attributes:
        geometric_stiffness: the matrix (n, n, N) of the forces of given contributions, see :meth:`GeometricStiffness.under`.
        contributions: contributions, with the :data:`UNITS`.
        u: (n, S, N) displacements by contribution, see :mod:`kinetostatics.statics.rotation_groups`; x (n, N): without units.
        twist, compliance: (6, N) and (6, 6, N), of the platform about o.
        tangents: see :attr:`Solution.tangents`.
    """

    geometric_stiffness: Callable[..., Array]
    contributions: tuple[str, ...]
    u: Array
    x: Array
    twist: Array
    compliance: Array
    tangents: tuple[Array, ...]


def at_unloaded_geometry(
    robot: RobotStatics, rotation_groups: RotationGroups, solution: Solution, poses: Index | slice, units: bool = False
) -> tuple[Balanced, Deformation, GeometricStiffness]:
    """Return some poses of an equilibrium of linear theory, with its geometric stiffness; ``units``: with the :data:`UNITS`."""
    given = LoadedPoses(
        solution.frames,
        solution.load,
        solution.gravity,
        solution.assembly_errors,
        tuple(item.load for item in solution.applied if item.load.kind != "change"),
        tuple(item.group for item in solution.statics),
        solution.weights,
    ).take(poses)
    attachment, rows = robot.topology.platform.root, np.repeat(np.eye(6)[:, :, None], given.load.shape[1], axis=2)
    more = (AppliedLoad(name, {attachment: row}, {}, "unit") for name, row in zip(UNITS, rows, strict=True))
    before = balanced(robot, replace(given, applied=(*given.applied, *more)) if units else given)
    springs = placed_springs(robot, given.frames)
    return before, deform(robot, before.solution), GeometricStiffness(robot, rotation_groups, given.frames, springs)


def tangent_of(robot: RobotStatics, groups: RotationGroups, solution: Solution, poses: Index | slice = slice(None)) -> Tangent:
    """Return the tangent stiffness at some poses of an equilibrium of linear theory; see :func:`second_order`."""
    before, deformation, geometric = at_unloaded_geometry(robot, groups, solution, poses, units=True)
    contributions, blocks = before.solution.contributions, geometric.coordinates.blocks
    real = [k for k, name in enumerate(contributions) if name not in UNITS]
    terms = geometric.under(before.solution, deformation, [contributions[k] for k in real])
    u, twists, tangents, compliance = response(robot, geometric, terms, before, deformation)

    def of(names: Sequence[str], own: bool = True) -> Array:
        return geometric.under(before.solution, deformation, names, own).matrix(blocks, blocks)

    return Tangent(of, contributions, u, u[:, real].sum(axis=1), twists[:, real].sum(axis=1), compliance, tangents)


def second_order(robot: RobotStatics, groups: RotationGroups, solution: Solution, poses: Index | slice = slice(None)) -> Changes:
    """Return results of second order at some poses of an equilibrium of linear theory; ``groups``: with elastic actuators.

    With the forces S(v_i) of a unit load i, displacements v_i under it and x under all loads: T_i = K_g(S(v_i)) x, the twist
    changes by −½ T_iᵀ x, and the compliance by −(T_iᵀ v_j + T_jᵀ v_i).
    """
    tangent = tangent_of(robot, groups, solution, poses)
    contributions, u, compliance, N = tangent.contributions, tangent.u, tangent.compliance, tangent.twist.shape[1]
    unit, x = [name for name in contributions if name in UNITS], tangent.x
    v = u[:, [contributions.index(name) for name in unit]]
    T = np.stack([np.einsum("abn,bn->an", tangent.geometric_stiffness([name], own=False), x) for name in unit])  # K_g(S(v_i)) x
    bent = np.einsum("ian,ajn->ijn", T, v)
    change = -(bent + np.swapaxes(bent, 0, 1))
    twist = tangent.twist - np.einsum("ian,an->in", T, x) / 2
    sound = (unstable_motions(tangent.tangents, N) == 0) & np.all(np.isfinite(twist), axis=0) & ~solution.singular[poses]
    scale = np.repeat([1.0, robot.length], 3)
    unloaded, loaded, more = (
        np.where(sound, np.moveaxis(np.nan_to_num(np.moveaxis(item, 2, 0)) * np.outer(scale, scale), 0, 2), 0.0).transpose(
            2, 0, 1
        )
        for item in (solution.compliance[..., poses], compliance, change)
    )
    found = _displaced(loaded, more)
    values, axes = np.linalg.eigh(unloaded)
    values = np.where(values > _RIGID * values[:, -1:], values, 0.0)
    root, squares = np.sqrt(values), values[:, :, None] ** 2 + values[:, None] ** 2
    weight = 2 * root[:, :, None] * root[:, None] / np.where(squares > 0, squares, 1.0)  # that stiff motions turn does not count
    softer, turn = np.linalg.eigh(np.swapaxes(axes, 1, 2) @ (loaded + more - unloaded) @ axes * weight)
    stiffer = 1 / np.maximum(1 + softer, _RIGID) - 1
    final = np.where(sound[:, None, None], found / np.outer(scale, scale), np.nan)
    return Changes(
        np.where(sound, twist, np.nan),
        final.transpose(1, 2, 0),
        np.where(sound[:, None], stiffer, np.nan).T,
        np.where(sound[:, None, None], (axes * root[:, None]) @ turn, 0.0).transpose(1, 2, 0),
    )


def _displaced(compliance: Array, change: Array) -> Array:
    """Return compliances C (N, 6, 6) after a first-order ``change``, as exp(X) C exp(X)ᵀ with the least X of X C + C Xᵀ = change.

    Thus the softest motions turn and soften, and no compliance becomes negative.
    """
    values, axes = np.linalg.eigh(compliance)
    values = np.where(values > _RIGID * values[:, -1:], values, 0.0)
    squares = values[:, :, None] ** 2 + values[:, None] ** 2
    X = (np.swapaxes(axes, 1, 2) @ change @ axes) * values[:, None] / np.where(squares > 0, squares, 1.0)
    moved = np.eye(6) + X / 2**_HALVINGS
    with np.errstate(over="ignore", invalid="ignore"):  # close to buckling
        for _ in range(_HALVINGS):
            moved = moved @ moved
        half = axes @ (moved * np.sqrt(values)[:, None])
    return np.asarray(half @ np.swapaxes(half, 1, 2))
