"""Redundant constraints: the self-stresses of a robot and the joints that they load.

A redundant constraint is a self-stress: joint forces in equilibrium without a load and with the actuators free. The self-stresses
are the null space of the equilibrium equations of all limbs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kinetostatics.checks.local_freedoms import NOTHING, Motions, eliminated, groups_of
from kinetostatics.kinematics.solver import SolverState
from kinetostatics.layout.numbers import join_words
from kinetostatics.math.arrays import Array
from kinetostatics.math.linalg import canonical_basis, null_space
from kinetostatics.math.rotations import skew
from kinetostatics.robot import Robot

#: Largest number of equations for which redundant constraints are located.
_MANY = 400


@dataclass(frozen=True)
class Redundancy:
    """Redundant constraints in one place.

    Attributes:
        limbs: names of the limbs between which the constraints act, or of the limb that contains them; else empty.
        joints, beams: joints and beams loaded by a self-stress inside a limb; joints of loops outside limbs; else empty.
        wrenches: descriptions of the wrenches between ``limbs`` at the zero pose; None inside a limb, or if the robot has
            another number of self-stresses at the zero pose.
    """

    count: int
    limbs: tuple[str, ...]
    joints: tuple[str, ...] = ()
    beams: tuple[str, ...] = ()
    wrenches: tuple[str, ...] | None = None


def redundancies(motions: Motions) -> list[Redundancy]:
    """Return the redundant constraints: first inside limbs, then between limbs, then of other loops."""
    robot = motions.robot
    total = robot.mobility.redundant_constraints
    if not total or robot.equations.count > _MANY:
        return []
    stresses = _SelfStresses(robot, motions.pose)
    constraints = [constraint for number in range(len(robot.topology.all_limbs)) for constraint in stresses.inside(number)]
    zero = _SelfStresses(robot, robot.zero_poses)
    same = zero.states.shape[1] == stresses.states.shape[1]
    for count, limbs in stresses.between():
        names = tuple(robot.topology.limbs[k].name for k in limbs)
        words = describe_wrenches(zero.wrenches_between(limbs), robot.length) if same else None
        constraints.append(Redundancy(count, names, wrenches=words))
    remaining = total - sum(constraint.count for constraint in constraints)
    if remaining > 0:  # in loops of welded links, or by joints that mimic others
        limb_joints = {edge.joint for limb in robot.topology.all_limbs for edge in (*limb.edges, *limb.branches)}
        loops = (loop.name for loop in robot.equations.loops if loop.name not in limb_joints)
        constraints.append(Redundancy(remaining, (), tuple(loops)))
    return constraints if remaining >= 0 else []


class _SelfStresses:
    """All self-stresses of a robot at one pose, with the actuators free.

    Attributes:
        states: (6 M, r) independent self-stresses, as scaled wrenches of all M cut joints of the limbs.
        first: (limbs + 1,) row of ``states`` at which each limb's wrenches begin, and the number of rows.
    """

    def __init__(self, robot: Robot, pose: SolverState) -> None:
        self.robot = robot
        frames = robot.frames_of(pose)
        o = robot.mechanism.platform_pose(frames)[1]
        limbs = robot.topology.all_limbs
        self.first = np.concatenate([[0], np.cumsum([6 * len(limb.to_platform) for limb in limbs])]).astype(int)
        rows: dict[str | tuple[int, int], Array] = {}
        balance = np.zeros((6, self.first[-1]))
        for group in robot.statics.groups:
            geometry = group.geometry(frames, o)
            twists = group.even_twists(geometry)[..., 0]
            for position, number in enumerate(group.numbers):
                columns = slice(self.first[number], self.first[number + 1])
                balance[:, columns] = group.platform_sum
                for k, dof in enumerate(group.dofs[position]):
                    row = np.zeros(self.first[-1])
                    row[columns] = (group.dof_cut_signs[k][:, None] * twists[:, k, position]).ravel()
                    connection = robot.mechanism.connections.get(dof.label)
                    alone = connection is not None and connection.type.is_single
                    rows[dof.label if alone else (number, k)] = row
        for connection in robot.mechanism.connections.values():
            if connection.mimic is not None and connection.name in rows:  # it works through its leader
                follower = rows.pop(connection.name) * connection.mimic.multiplier
                scale = 1.0
                if connection.type.is_slide != robot.mechanism.connections[connection.mimic.joint].type.is_slide:
                    scale = 1 / robot.length if connection.type.is_slide else robot.length
                rows[connection.mimic.joint] = rows.get(connection.mimic.joint, 0.0) + follower * scale
        matrix = np.array([*rows.values(), *balance]).reshape(-1, self.first[-1])
        self.states = null_space(matrix, robot.rank_tolerance)[0]

    @property
    def platform_wrenches(self) -> Array:
        """(limbs, 6, r) scaled wrenches of the platform on each limb in the r self-stresses."""
        wrenches = []
        for number, limb in enumerate(self.robot.topology.limbs):
            cut_wrenches = self.states[self.first[number] : self.first[number + 1]].reshape(len(limb.to_platform), 6, -1)
            wrenches.append(cut_wrenches[np.array(limb.to_platform, dtype=bool)].sum(axis=0))
        return np.array(wrenches).reshape(len(wrenches), 6, self.states.shape[1])

    def inside(self, number: int) -> list[Redundancy]:
        """Return the self-stresses inside a limb, one entry for each group with common joints or beams."""
        limb = self.robot.topology.all_limbs[number]
        if limb.is_serial:
            return []
        inside = np.zeros(len(self.states), dtype=bool)
        inside[self.first[number] : self.first[number + 1]] = True
        alone = _null(self.states[~inside])
        if not alone.shape[1]:
            return []
        carried = (self.states[inside] @ alone).reshape(len(limb.to_platform), 6, -1)
        edges = np.zeros((len(limb.edges), *carried.shape[1:]))
        for k, edge in enumerate(limb.edges):
            for cut, sign in edge.cut_joints:
                edges[k] += sign * carried[cut]
        columns = eliminated(edges.reshape(-1, edges.shape[2]))
        loaded = np.max(np.abs(edges @ columns), axis=1) > NOTHING
        constraints = []
        for group in groups_of(loaded.T):
            which = [edge for edge, is_loaded in zip(limb.edges, np.any(loaded[:, group], axis=1), strict=True) if is_loaded]
            joints = tuple(edge.joint for edge in which if edge.joint)
            beams = dict.fromkeys(self.robot.topology.part_of(edge) for edge in which if edge.span)
            constraints.append(Redundancy(len(group), (limb.name,), joints, tuple(beams)))
        return constraints

    def between(self) -> list[tuple[int, list[int]]]:
        """Return (number of self-stresses, indices of the limbs) for each group of limbs that stress each other."""
        wrenches = self.platform_wrenches
        if not wrenches.size:
            return []
        flat = wrenches.reshape(-1, wrenches.shape[2])
        reduced = (flat @ eliminated(flat)).reshape(*wrenches.shape[:2], -1)
        loaded = np.max(np.abs(reduced), axis=1, initial=0.0) > NOTHING
        used = [k for k in range(loaded.shape[1]) if np.any(loaded[:, k])]
        return [
            (len(group), np.flatnonzero(np.any(loaded[:, used][:, group], axis=1)).tolist())
            for group in groups_of(loaded[:, used].T)
        ]

    def wrenches_between(self, limbs: list[int]) -> Array:
        """Return an orthonormal basis (6, k) of the scaled wrenches of self-stresses that load only the given limbs."""
        wrenches = self.platform_wrenches
        others = [k for k in range(len(wrenches)) if k not in limbs]
        limb_wrenches = wrenches[limbs] @ _null(wrenches[others].reshape(-1, wrenches.shape[2]))
        U, values, _ = np.linalg.svd(np.concatenate(list(limb_wrenches), axis=1), full_matrices=False)
        return np.asarray(U[:, : int(np.sum(values > NOTHING))])


def _null(matrix: Array) -> Array:
    """Return an orthonormal basis (n, k) of the null space of a matrix (m, n) with entries of unit magnitude."""
    if not matrix.size:
        return np.eye(matrix.shape[1])
    _, values, rows = np.linalg.svd(matrix, full_matrices=matrix.shape[0] < matrix.shape[1])
    return canonical_basis(rows[int(np.sum(values > NOTHING)) :].T)


def describe_wrenches(basis: Array, length: float) -> tuple[str, ...]:
    """Describe the space of wrenches about o with the orthonormal basis (6, k); moments are divided by ``length`` [m]."""
    count = basis.shape[1]
    aligned = [float(row @ row) > 1 - 1e-8 for row in basis]
    if sum(aligned) == count:
        words = [_along("force", "along", aligned[:3]), _along("couple", "about", aligned[3:])]
        return tuple(text for text in words if text)
    forces = np.linalg.svd(basis[:3])
    kinds = int(np.sum(forces[1] > 1e-6))
    if kinds == count == 3:  # forces through one point p: m = p × f for all of them
        rows = np.concatenate([skew(-f) for f in basis[:3].T])
        point, moments = np.linalg.lstsq(rows, basis[3:].T.ravel(), rcond=None)[0], basis[3:].T.ravel()
        if float(np.max(np.abs(rows @ point - moments))) < 1e-6:
            return (f"forces through o + {_vector(point * length)} m",)
    words = []
    if kinds:
        words.append(_directions("force", forces[0][:, :kinds], "along"))
    if kinds < count:
        couples = np.linalg.svd(basis[3:] @ forces[2][kinds:].T)[0][:, : count - kinds]
        words.append(_directions("couple", couples, "about"))
    return tuple(words)


def _along(kind: str, how: str, aligned: Sequence[bool]) -> str:
    """Return forces or couples along world axes as text."""
    axes = [axis for axis, is_along in zip("xyz", aligned, strict=True) if is_along]
    if len(axes) == 3:
        return f"{kind}s in all directions"
    if len(axes) == 2:
        return f"{kind}s {how} {join_words(axes)}"
    return f"a {kind} {how} {axes[0]}" if axes else ""


def _directions(kind: str, basis: Array, how: str) -> str:
    """Return forces or couples as text; ``basis`` (3, 1 … 3) is an orthonormal basis of their directions."""
    if basis.shape[1] == 3:
        return f"{kind}s in all directions"
    direction = basis[:, 0] if basis.shape[1] == 1 else np.cross(basis[:, 0], basis[:, 1])
    direction = direction * np.sign(direction[int(np.argmax(np.abs(direction) > 1e-6))])  # first nonzero component positive
    names = [axis for axis, part in zip("xyz", direction, strict=True) if part > 1 - 1e-8]
    words = names[0] if names else _vector(direction)
    return f"a {kind} {how} {words}" if basis.shape[1] == 1 else f"{kind}s across {words}"


def _vector(v: Sequence[float] | Array) -> str:
    return "(" + ", ".join(f"{0.0 if abs(x) < 5e-5 else x:.4g}" for x in v) + ")"
