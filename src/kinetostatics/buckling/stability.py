"""The critical load factors of a robot: stiffness K and geometric stiffness K_G of all its small motions, and their eigenvalues.

K_G is what all forces together add to the stiffness when all of them grow in proportion: of beams that of their axial forces, of
rigid bodies that of the forces on them, of springs and slides that of what they carry. Bending moments and torques, and the
displacements before buckling, add nothing. The robot buckles at λ times its forces where K + λ K_G is singular.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from kinetostatics.buckling.beam_elements import INNER, bending, tension
from kinetostatics.buckling.structure import Structure
from kinetostatics.math.arrays import Array, Index
from kinetostatics.math.linalg import dot
from kinetostatics.mechanism.rigid_bodies import RigidBody
from kinetostatics.mechanism.tree import Frames
from kinetostatics.statics.deformation import beam_forces
from kinetostatics.statics.joint_wrenches import carried_wrenches
from kinetostatics.statics.solution import Solution
from kinetostatics.statics.springs import placed_springs

#: How much stiffer than everything else what keeps loops of joints closed is.
_CLOSING = 1e4
#: Scaled stiffness below which a motion is one that nothing holds.
_FREE = 1e-11
#: Part of the stiffness that stands for what nothing holds, such as the spin of a strut between ball joints.
_UNHELD = 1e-9
#: Part of the largest factor below which one is rounding.
_ROUNDING = 1e-12


@dataclass(frozen=True)
class _Place:
    """Coordinates (k,) that move two bodies, and the twists (N, 6, k) that these get."""

    columns: Index
    twists: tuple[Array, Array]


@dataclass(frozen=True)
class BeamEnergy:
    """Strain energy of a beam: stiffness (N, m, m) of motions (N, m, k) of coordinates (k,), and 1 of its inner coordinates."""

    columns: Index
    motions: Array
    stiffness: Array
    inner: Index

    def of(self, modes: Array) -> Array:
        """Return twice the strain energies (N, M) in modes (N, n, M)."""
        moved = self.motions @ modes[:, self.columns]
        return np.asarray(np.sum(moved * (self.stiffness @ moved), axis=1) + np.sum(modes[:, self.inner] ** 2, axis=1))


@dataclass(frozen=True)
class Stability:
    """A robot at N poses, each with its own forces.

    Attributes:
        stiffness: K (N, n, n) of the motions of rigid bodies [N/m]; of the beams' inner coordinates it is 1.
        geometric: K_G (N, n + b, n + b) of both.
        beams: the strain energy of every beam, by name.
    """

    stiffness: Array
    geometric: Array
    beams: dict[str, BeamEnergy]

    def is_stable(self) -> bool:
        """Whether K + K_G is positive definite at all poses: none of them buckles."""
        total, n = np.array(self.geometric), self.stiffness.shape[1]
        total[:, :n, :n] += self.stiffness
        diagonal = np.einsum("nii->ni", total)
        diagonal[:, n:] += 1.0
        own = np.einsum("nii->ni", self.stiffness)
        diagonal[:, :n] += _UNHELD * np.maximum(own, _UNHELD * own.max(axis=1, keepdims=True, initial=0.0))
        try:
            np.linalg.cholesky(total)
        except np.linalg.LinAlgError:
            return False
        return True

    def modes(self) -> tuple[Array, Array]:
        """Return ratios 1/λ (N, n + b) of forces to those at which the robot buckles, and the modes (N, n + b, n + b).

        Motions that nothing holds are left out; where K or K_G are no numbers, so are the ratios.
        """
        n = self.stiffness.shape[1]
        fine = np.all(np.isfinite(self.stiffness), axis=(1, 2)) & np.all(np.isfinite(self.geometric), axis=(1, 2))
        K, G = (np.where(fine[:, None, None], matrix, 0.0) for matrix in (self.stiffness, self.geometric))
        size = np.sqrt(np.abs(np.einsum("nii->ni", K)))
        size = np.where(size > 0, size, 1.0)
        values, axes = np.linalg.eigh(K / (size[:, :, None] * size[:, None]))
        held = values > _FREE
        basis = axes * (held / np.sqrt(np.where(held, values, 1.0)))[:, None] / size[:, :, None]
        A = np.array(-G)
        A[:, :n] = np.swapaxes(basis, 1, 2) @ A[:, :n]
        A[:, :, :n] = A[:, :, :n] @ basis
        ratios, modes = np.linalg.eigh(A)
        modes[:, :n] = basis @ modes[:, :n]
        ratios = np.where(np.abs(ratios) > _ROUNDING * np.abs(ratios).max(axis=1, keepdims=True, initial=0.0), ratios, 0.0)
        return np.where(fine[:, None], ratios, np.nan), modes


@dataclass(frozen=True)
class Forces:
    """What loads a robot at N poses.

    Attributes:
        frames, o, gravity: the poses, the platform's point o (3, N) [m], and the field (3, N) [m/s²].
        beams: section forces (2, 3, N) at the start and the end of every beam, by name [N].
        joints: forces (3, J, N) of the predecessor on the successor of every joint of the joint table, and ``centres`` [m].
        centres: see ``joints``.
        others: loads and weights on rigid bodies: the body, the force (3, N) and where it acts (3, N).
    """

    frames: Frames
    o: Array
    gravity: Array
    beams: dict[str, Array]
    joints: Array
    centres: Array
    others: list[tuple[RigidBody, Array, Array]]

    def take(self, poses: Index) -> Forces:
        """Return those of some poses."""
        beams = {name: force[..., poses] for name, force in self.beams.items()}
        others = [(body, force[:, poses], point[:, poses]) for body, force, point in self.others]
        frames, joints, centres = self.frames.take(poses), self.joints[..., poses], self.centres[..., poses]
        return Forces(frames, self.o[:, poses], self.gravity[:, poses], beams, joints, centres, others)


def forces_of(structure: Structure, solution: Solution) -> Forces:
    """Return all forces at the poses of a solution; what rigid parts leave open has one of its possible values."""
    model, frames, table = structure.model, solution.frames, structure.model.joint_table
    signs = np.array([table.signs[name] for name in table.names])
    others = [(structure.graph.platform, solution.load[:3], solution.o)]
    for item in solution.applied:
        for place, wrench in item.load.wrenches.items():
            if place in structure.body_at and place in item.load.points:
                others.append((structure.body_at[place], wrench[:3] * item.times, item.load.points[place]))
    centres, number = model.weights.centres(frames), {name: k for k, name in enumerate(model.weights.names)}
    for body in structure.graph.bodies():
        for k in (number[name] for name in structure.graph.weights_of(body)):
            others.append((body, solution.weights[:3, k], centres[:, k]))
    joints = signs[:, None] * carried_wrenches(model, solution)[:3]
    points = frames.points(table.centre_body, table.centre)
    return Forces(frames, solution.o, solution.gravity, beam_forces(model, solution), joints, points, others)


def stability(structure: Structure, forces: Forces) -> Stability:
    """Put K and K_G together."""
    return _Assembly(structure, forces).result()


class _Assembly:
    def __init__(self, structure: Structure, forces: Forces) -> None:
        self.structure, self.given = structure, forces
        self.frames, self.o = forces.frames, forces.o
        self.units = structure.unit_twists(self.frames, self.o)
        N, _, n = self.units.shape
        total = n + 2 * INNER * len(structure.beams)
        self.K, self.G, self.inner = np.zeros((N, n, n)), np.zeros((N, total, total)), n
        # of bodies that are rigidly one, by their coordinates: forces and where they act, and directions of beams
        self.forces: dict[tuple[int, ...], list[tuple[Array, Array]]] = {}
        self.axes: dict[tuple[int, ...], list[Array]] = {}
        for body, force, point in forces.others:
            self._force(body, force, point)

    def result(self) -> Stability:
        """Return K and K_G of everything."""
        with np.errstate(divide="ignore", invalid="ignore"):  # telescopes without length
            beams = dict(self._beams())
            self._springs()
            self._joints()
            self._bodies()
        return Stability(self.K, self.G, beams)

    def _place(self, inner: RigidBody, outer: RigidBody, more: tuple[int, ...] = ()) -> _Place:
        columns = self.structure.columns
        used = sorted({*columns[inner], *columns[outer], *more})
        mine = self.units[:, :, used]
        first, second = (mine * np.isin(used, columns[body]) for body in (inner, outer))
        return _Place(np.array(used, dtype=np.intp), (first, second))

    def _displaced(self, twists: Array, point: Array) -> Array:
        """Return the displacements (N, 3, k) of points (3, N) that twists (N, 6, k) give."""
        arm = (point - self.o).T[:, :, None]
        return np.asarray(twists[:, 3:] + np.cross(twists[:, :3], arm, axis=1))

    def _add(self, matrix: Array, columns: Index, motions: Array, values: Array) -> None:
        matrix[:, columns[:, None], columns] += np.swapaxes(motions, 1, 2) @ values @ motions

    def _force(self, body: RigidBody, force: Array, point: Array) -> None:
        self.forces.setdefault(self.structure.columns[body], []).append((force, point))

    def _beams(self) -> Iterator[tuple[str, BeamEnergy]]:
        model = self.structure.model
        for beam in self.structure.beams:
            item = model.beams[beam.name]
            axes = np.moveaxis(self.frames.orientations(np.array([item.span.carrier]), item.axes[:, :, None])[:, :, 0], 2, 0)
            points = [
                self.frames.point(item.span.start_body, item.span.start),
                self.frames.point(item.span.end_body, item.span.end),
            ]
            length, mine = item.length(self.frames), self.given.beams[beam.name]
            self._force(beam.inner, mine[0], points[0])
            self._force(beam.outer, -mine[1], points[1])
            for body in (beam.inner, beam.outer):
                self.axes.setdefault(self.structure.columns[body], []).append(axes[:, :, 0])
            place, local = self._place(beam.inner, beam.outer), np.swapaxes(axes, 1, 2)
            turns = [local @ twists[:, :3] for twists in place.twists]
            shifts = [local @ self._displaced(twists, point) for twists, point in zip(place.twists, points, strict=True)]
            c, L = item.compliances, length[:, None]
            rows = [shifts[1][:, 0] - shifts[0][:, 0], turns[1][:, 0] - turns[0][:, 0]]
            stiffness, geometric = np.zeros((2, len(length), 10, 10))
            stiffness[:, 0, 0], stiffness[:, 1, 1] = 1 / (c[0] * length), 1 / (c[3] * length)
            along = axes[:, :, 0].T
            pulls = np.sum(along * mine, axis=1)
            # its mass may lie ahead of the sections that carry it
            pulls += item.line_density(length) * dot(along, self.given.gravity) * dot(along, item.lever(self.frames))
            coupling = np.zeros((len(length), 10, 2 * INNER))
            inner = self.inner + np.arange(2 * INNER)
            self.inner += 2 * INNER
            for k, (y, z, sign, EI) in enumerate(((1, 2, 1, 1 / c[5]), (2, 1, -1, 1 / c[4]))):
                rows += [row for e in (0, 1) for row in (shifts[e][:, y], sign * L * turns[e][:, z])]
                nodes, own, axial = slice(2 + 4 * k, 6 + 4 * k), slice(INNER * k, INNER * (k + 1)), tension(pulls, EI, length)
                stiffness[:, nodes, nodes], geometric[:, nodes, nodes] = bending(EI, length), axial[:, :4, :4]
                coupling[:, nodes, own] = axial[:, :4, 4:]
                self.G[:, inner[own, None], inner[own]] = axial[:, 4:, 4:]
            motions, columns = np.stack(rows, axis=1), place.columns
            self._add(self.K, columns, motions, stiffness)
            self._add(self.G, columns, motions, geometric)
            mixed = np.swapaxes(motions, 1, 2) @ coupling
            self.G[:, columns[:, None], inner], self.G[:, inner[:, None], columns] = mixed, np.swapaxes(mixed, 1, 2)
            yield beam.name, BeamEnergy(columns, motions, stiffness, inner)

    def _springs(self) -> None:
        """Springs between links: what of their stiffness is negative, as they push, grows with the forces."""
        body_at = self.structure.body_at
        for spring in placed_springs(self.structure.model, self.frames):
            values, axes = np.linalg.eigh(np.nan_to_num(np.moveaxis(spring.tangent, 2, 0)))
            for first, here in spring.places[0].items():
                for second, there in spring.places[1].items():
                    place = self._place(body_at[first], body_at[second])
                    ends = [self._displaced(twists, point) for twists, point in zip(place.twists, spring.points, strict=True)]
                    for matrix, part in ((self.K, np.maximum(values, 0)), (self.G, np.minimum(values, 0))):
                        stiffness = (axes * (part * (here & there)[:, None])[:, None]) @ np.swapaxes(axes, 1, 2)
                        self._add(matrix, place.columns, ends[1] - ends[0], stiffness)

    def _joints(self) -> None:
        """Joints: their springs, loops that they close, and the forces that slides pass on where the body that has them turns."""
        structure, table = self.structure, self.structure.model.joint_table
        places = {name: k for k, name in enumerate(table.names)}
        diagonal = np.einsum("nii->ni", self.K)
        closing = _CLOSING * diagonal.max(axis=1, initial=0.0)
        for joint in structure.joints:
            k = places.get(joint.connection.name)
            place = self._place(joint.inner, joint.outer, joint.columns)
            for column in joint.columns:
                freedom = structure.freedoms[column]
                if freedom is not None and freedom.stiffness:
                    scale = structure.model.length**2 if freedom.rotates else 1.0
                    self.K[:, column, column] += freedom.stiffness / scale
            if joint.closes:
                own = self.units[:, :, place.columns] * np.isin(place.columns, joint.columns)
                rows = place.twists[1] - place.twists[0] - own
                rows = rows * np.repeat([structure.model.length, 1.0], 3)[:, None]
                self._add(self.K, place.columns, rows, closing[:, None, None] * np.eye(6))
            if k is None:
                continue
            force, point = self.given.joints[:, k], self.given.centres[:, k]
            self._force(joint.outer, force, point)
            self._force(joint.inner, -force, point)
            slides = [structure.freedoms[column] for column in joint.columns]
            if any(item is not None and not item.rotates for item in slides):
                moved = self._displaced(place.twists[1], point) - self._displaced(place.twists[0], point)
                both = np.concatenate([place.twists[0][:, :3], moved], axis=1)
                # f · (θ × u) = θ · (u × f)
                fx, fy, fz = force
                zero = np.zeros_like(fx)
                turn = np.moveaxis(np.array([[zero, fz, -fy], [-fz, zero, fx], [fy, -fx, zero]]), 2, 0)
                values = np.zeros((len(turn), 6, 6))
                values[:, :3, 3:], values[:, 3:, :3] = turn, np.swapaxes(turn, 1, 2)
                self._add(self.G, place.columns, both, values)

    def _bodies(self) -> None:
        """Rigid bodies: a force f at an arm r does the work f · (θ × (θ × r)) / 2 when the body turns by θ."""
        for columns, mine in self.forces.items():
            if not columns:
                continue
            A = sum(np.einsum("in,jn->nij", force, point - self.o) for force, point in mine)
            S = (A + np.swapaxes(A, 1, 2)) / 2  # without what couples torsion and bending of beams
            axes = self.axes.get(columns, [])
            if axes and all(np.abs(np.cross(axes[0], other)).max() < 1e-6 for other in axes):
                along = axes[0][:, :, None] * axes[0][:, None]
                across = np.eye(3) - along
                S = along @ S @ along + across @ S @ across
            values = np.trace(S, axis1=1, axis2=2)[:, None, None] * np.eye(3) - S
            self._add(self.G, np.array(columns, dtype=np.intp), self.units[:, :3, list(columns)], values)
