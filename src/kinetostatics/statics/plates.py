"""Elastic base and platform (*plates*): how they couple the limbs, and their deformation.

A plate is held at its first interface: the base by the ground, the platform at o. With the flexibility F of its other interfaces,
the limbs' wrenches G per unit of all intensities there, and all limbs' C_ic,
C = diag(C_ic) + Σ Gᵀ F G; what else acts on a plate displaces its interfaces by t, which adds Gᵀ t to all Δ_igc.
*Stacked* arrays (…, N) have the intensities of all limbs along one axis.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinetostatics.limbs.compliance import rigid_counts, soft_wrenches
from kinetostatics.limbs.group import LimbGroup
from kinetostatics.limbs.statics import LimbStatics, limb_statics
from kinetostatics.math.arrays import Array, zeros_for
from kinetostatics.mechanism.limbs import Edge, carries
from kinetostatics.mechanism.tree import Frames
from kinetostatics.statics.assembly_errors import AssemblyErrors
from kinetostatics.statics.link_loads import AppliedStatics
from kinetostatics.statics.platform_equilibrium import CoupledLimbs, PlatformEquilibrium
from kinetostatics.statics.robot_statics import RobotStatics


def stacked(parts: Iterable[Array]) -> Array:
    """Return arrays (n, S, g, N) of groups of limbs as one array (Σ n g, S, N)."""
    swapped = [np.swapaxes(part, 1, 2) for part in parts]
    return np.concatenate([part.reshape(part.shape[0] * part.shape[1], *part.shape[2:]) for part in swapped])


def divided(total: Array, statics: Iterable[LimbStatics]) -> list[Array]:
    """Return the parts (n, S, g, N) of an array by :func:`stacked`."""
    parts, first = [], 0
    for item in statics:
        n, g = item.J_c.shape[1:3]
        part = total[first : first + n * g]
        parts.append(np.swapaxes(part.reshape(n, g, *part.shape[1:]), 1, 2))
        first += n * g
    return parts


class Plates:
    """The plates of a robot at N poses.

    Attributes:
        wrenches: for each plate G (6p, n, N), about o, world axes, of the n stacked intensities at its p outer interfaces.
    """

    def __init__(self, robot: RobotStatics, frames: Frames, o: Array, statics: Sequence[LimbStatics]) -> None:
        self._robot, self._frames, self._o, self._statics = robot, frames, o, statics
        self._edges = list(robot.topology.plates.values())
        elements = [robot.branch_elements[edges[0].key][0][0] for edges in self._edges]
        self.placed = [element.placed(frames, o, np.zeros((6, 0, 1, o.shape[1]))) for element in elements]
        self.wrenches = [self._per_intensity(edges) for edges in self._edges]

    def _per_intensity(self, edges: Sequence[Edge]) -> Array:
        parts = [_at_ends(edges, item.group, item.cut_wrenches) for item in self._statics]
        return np.concatenate([part.reshape(len(part), part.shape[1] * part.shape[2], -1) for part in parts], axis=1)

    def compliance(self) -> Array:
        """Return C (n, n, N) of the stacked intensities."""
        sizes = [item.J_c.shape[1] * item.J_c.shape[2] for item in self._statics]
        C, first = zeros_for((sum(sizes), sum(sizes), self._o.shape[1]), *(item.C for item in self._statics), *self.wrenches), 0
        for item in self._statics:
            n, g = item.C.shape[1:3]
            for position in range(g):
                rows = range(first + position, first + n * g, g)
                C[np.ix_(rows, rows)] = item.C[:, :, position]
            first += n * g
        for placed, G in zip(self.placed, self.wrenches, strict=True):
            forces = placed.forces(G[:, :, None])
            C += np.einsum("kagn,kbgn->abn", forces, placed.displacements(forces))
        return C

    # ---- what acts on a plate, by contribution, as wrenches (6p, S, N) about o

    def by_intensities(self, intensities: Iterable[Array]) -> list[Array]:
        total = stacked(intensities)
        return [np.einsum("iln,lsn->isn", G, total) for G in self.wrenches]

    def by_weights(self, statics: Sequence[LimbStatics], weights: Array, places: Sequence[int], count: int) -> list[Array]:
        """Return the wrenches due to weights and assembly errors.

        Args:
            statics: the limbs under their own weights alone.
            weights: (6, W, N) all weights about o.
            places: indices of the contributions of the limbs, the platform and the base.
            count: the number of contributions; the last one is that of assembly errors.
        """
        names = [limb.name for limb in self._robot.topology.limbs] + ["platform", "base"]
        result = []
        for edges in self._edges:
            total = zeros_for((6 * len(edges), count, weights.shape[2]), weights, *self.wrenches)
            for name, place in zip(names, places, strict=False):
                mine = self._robot.weights.of(name)
                for k, edge in enumerate(edges):
                    mask = self._robot.weights.outboard_of(edge) * mine
                    if mask.any():
                        total[6 * k : 6 * k + 6, place] += np.einsum("w,iwn->in", mask, weights)
            for item in statics:
                if not item.group.is_attached:
                    own = _at_ends(edges, item.group, item.particular)
                    for position, number in enumerate(item.group.numbers):
                        total[:, places[number]] += own[:, position]
                    total[:, -1] += _at_ends(edges, item.group, item.assembly_error_cut_wrenches).sum(axis=1)
            result.append(total)
        return result

    def by_loads(self, applied: Iterable[AppliedStatics], count: int) -> list[Array]:
        result = []
        for edges in self._edges:
            total = zeros_for((6 * len(edges), count, self._o.shape[1]), *self.wrenches)
            for item in applied:
                own = zeros_for((6 * len(edges), self._o.shape[1]), *self.wrenches)
                for k, edge in enumerate(edges):
                    for attachment, wrench in item.load.wrenches.items():
                        if carries(edge, attachment):
                            own[6 * k : 6 * k + 6] += wrench
                for group, part in zip((item.group for item in self._statics), item.statics, strict=True):
                    if part is not None and not group.is_attached:
                        own += _at_ends(edges, group, part.particular).sum(axis=1)
                total[:, : len(item.share)] += own[:, None] * item.share
            result.append(total)
        return result

    # ---- deformation

    def displacements(
        self,
        wrenches: Sequence[Array],
        gravity: Array | None = None,
        errors: AssemblyErrors | None = None,
        places: Sequence[int] = (),
    ) -> list[tuple[Array, Array, Array]]:
        """Return for each plate its forces and displacements (r, S, 1, N), and the twists (6p, S, N) of its interfaces about o.

        Args:
            wrenches: (6p, S, N) what acts on each plate.
            gravity: (3, N) [m/s²], if the plates' own weight acts.
            errors: assembly errors, in the last contribution.
            places: as for :meth:`by_weights`.
        """
        result = []
        for edges, placed, wrench in zip(self._edges, self.placed, wrenches, strict=True):
            forces = placed.forces(wrench[:, :, None])
            moved, load = placed.displacements(forces), None if gravity is None else placed.own_load(gravity)
            if load is not None:
                share = zeros_for((wrench.shape[1], 1, 1), load)
                share[places[-2] if edges is self._robot.topology.plates.get("platform") else places[-1]] = 1.0
                moved = moved + placed.own_displacement(load[:, None] * share)
            twists = np.concatenate([motion[:, :, 0] for _, motion in placed.motions(moved)])
            for k, edge in enumerate(edges):
                if errors is not None and errors.concerns(edge):
                    twists[6 * k : 6 * k + 6, -1] += errors.of_edge(edge, self._frames, self._o)
            result.append((forces, moved, twists))
        return result

    def add_strains(self, displaced: Iterable[tuple[Array, Array, Array]], strains: Sequence[Array]) -> None:
        """Add Gᵀ t of :meth:`displacements` to Δ_igc (n, S, g, N) of each group of limbs, in place."""
        for G, (_, _, twists) in zip(self.wrenches, displaced, strict=True):
            for strain, more in zip(strains, divided(np.einsum("iln,isn->lsn", G, twists), self._statics), strict=True):
                strain += more


def places_of(contributions: Sequence[str], limbs: Sequence[int]) -> list[int]:
    """Return the indices of the contributions of the limbs' weights, of the platform's and the base's weight."""
    return [*limbs, 1, contributions.index("base_weight") if "base_weight" in contributions else len(contributions)]


def _at_ends(edges: Sequence[Edge], group: LimbGroup, cut_wrenches: Array) -> Array:
    """Return the wrenches (6p, …, g, N) of g limbs on a plate with p ``edges`` from their cut-joint wrenches (M, 6, …, g, N)."""
    signs = np.zeros((len(edges), len(group.to_platform), len(group.numbers)))
    for k, edge in enumerate(edges):
        for limb, cut, sign in edge.limb_cuts:
            if limb in group.numbers:
                signs[k, cut, group.numbers.index(limb)] += sign
    found = np.einsum("kmg,mi...gn->ki...gn", signs, cut_wrenches)
    return found.reshape(-1, *found.shape[2:])


class CoupledEquilibrium:
    """The equilibrium of :class:`PlatformEquilibrium`, with limbs coupled by ``plates``; attributes and methods are the same."""

    def __init__(self, robot: RobotStatics, statics: Sequence[LimbStatics], plates: Plates, support: float) -> None:
        self._statics, self.plates, C = statics, plates, plates.compliance()
        J = np.concatenate([item.J_c.reshape(6, -1, item.J_c.shape[3]) for item in statics], axis=1)
        usual = tuple(item.group for item in statics) == robot.groups
        rigid, soft = coupled_rigidity(robot) if usual else _rigidity(statics, C)
        together = CoupledLimbs(J[:, :, None], C[:, :, None], rigid, soft)
        self._together = PlatformEquilibrium(robot, (together,), J.shape[2], support)
        self.scale, self.compliance, self.stiffness = self._together.scale, self._together.compliance, self._together.stiffness
        self.singular, self.indeterminate = self._together.singular, self._together.indeterminate
        undetermined = self._divided(self._together.undetermined[0][:, None])
        self.undetermined: list[NDArray[np.bool_]] = [part[:, 0].astype(bool) for part in undetermined]
        self.self_stresses = self._divided(self._together.self_stresses[0])

    def add_weights(
        self,
        contributions: Sequence[str],
        statics: Sequence[LimbStatics],
        weights: Array,
        gravity: Array,
        errors: AssemblyErrors | None,
        strains: Sequence[Array],
    ) -> None:
        """Add what weights and assembly errors of the plates contribute to Δ_igc (n, S, g, N) of each group, in place."""
        places = places_of(contributions, range(2, 2 + sum(len(s.group.numbers) for s in statics if not s.group.is_attached)))
        wrenches = self.plates.by_weights(statics, weights, places, len(contributions))
        self.plates.add_strains(self.plates.displacements(wrenches, gravity, errors, places), strains)

    def add_loads(self, applied: Iterable[AppliedStatics], strains: Sequence[Array]) -> None:
        """Add what loads contribute to Δ_igc (n, S, g, N) of each group, in place."""
        wrenches = self.plates.by_loads(applied, strains[0].shape[1])
        self.plates.add_strains(self.plates.displacements(wrenches), strains)

    def _divided(self, together: Array) -> list[Array]:
        return divided(together[:, :, 0], self._statics)

    def _stacked(self, strains: Iterable[Array]) -> list[Array]:
        return [stacked(strains)[:, :, None]]

    def solve(self, right: Array, strains: Sequence[Array], errors: bool = False) -> tuple[Array, list[Array]]:
        twists, [intensities] = self._together.solve(right, self._stacked(strains), errors)
        return twists, self._divided(intensities)

    def generalized_force(self, right: Array, strains: Sequence[Array]) -> Array:
        return self._together.generalized_force(right, self._stacked(strains))

    def with_fixed_platform(self, strains: Sequence[Array]) -> list[Array]:
        return self._divided(self._together.with_fixed_platform(self._stacked(strains))[0])

    def intensities(self, twists: Array, right: Array, strains: Sequence[Array]) -> list[Array]:
        return self._divided(self._together.intensities(twists, right, self._stacked(strains))[0])


def coupled_rigidity(robot: RobotStatics) -> tuple[int, tuple[int, ...]]:
    """Return the number of rigid combinations of the intensities of all limbs, and intensities that span the others."""
    if not any(group.rigid_directions for group in robot.groups):
        return 0, ()
    frames = robot.example
    o, still = robot.mechanism.platform_pose(frames)[1], np.zeros((3, 1))
    weightless = np.zeros((6, len(robot.weights.names), 1))
    statics = [limb_statics(group, frames, o, weightless, still) for group in robot.groups]
    return _rigidity(statics, Plates(robot, frames, o, statics).compliance())


def _rigidity(statics: Sequence[LimbStatics], C: Array) -> tuple[int, tuple[int, ...]]:
    count = int(np.min(rigid_counts(C))) if any(item.group.rigid_directions for item in statics) else 0
    return count, soft_wrenches(C, len(C) - count) if count else ()


Equilibrium: TypeAlias = PlatformEquilibrium | CoupledEquilibrium


def equilibrium(
    robot: RobotStatics, statics: tuple[LimbStatics, ...], frames: Frames, o: Array, support: float = 0.0
) -> Equilibrium:
    """Return the equilibrium of the platform; see :class:`PlatformEquilibrium`."""
    if not robot.topology.plates:
        return PlatformEquilibrium(robot, statics, o.shape[1], support)
    return CoupledEquilibrium(robot, statics, Plates(robot, frames, o, statics), support)
