"""Critical load factors λ of a robot, (K + λ K_G) u = 0, with stiffness K and geometric stiffness K_G of all small motions.

λ K_G is the change of the stiffness due to λ times the forces: axial forces of beams, forces on rigid bodies, forces of springs
and in slides. Bending moments, torques and displacements before buckling are neglected.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from kinetostatics.buckling.beam_elements import INNER, bending, condensed_tension, tension
from kinetostatics.math.arrays import Array, Index, Mask, settles, zeros_for
from kinetostatics.math.linalg import cross, definite_in_order, dot, fronts
from kinetostatics.math.screws import move_wrench
from kinetostatics.mechanism.body_graph import RigidBody
from kinetostatics.mechanism.tree import Frames
from kinetostatics.statics.deformation import beam_forces
from kinetostatics.statics.inertia import line_resultants
from kinetostatics.statics.joint_wrenches import carried_wrenches
from kinetostatics.statics.small_motions import Follower, PlacedMotions, SmallMotions
from kinetostatics.statics.solution import Solution
from kinetostatics.statics.springs import placed_springs

#: Ratio of the stiffness of closed loops to the largest stiffness of the robot.
_CLOSING = 1e4
#: Scaled stiffness below which a motion counts as free, such as the spin of a strut between ball joints.
_FREE = 1e-11
#: Stiffness added to all motions, so that free motions do not count as unstable: relative to their own stiffness; and relative to
#: the closing stiffness of loops, to exceed its rounding errors.
_ADDED, _ADDED_LOOPS = 1e-9, 1e-14
#: Ratio 1/λ, relative to the largest, below which it counts as rounding.
_ROUNDING = 1e-12


#: Blocks (m, m, N) on the diagonal of a matrix, and their rows.
_Blocks = Sequence[tuple[slice, Array]]


@dataclass(frozen=True)
class BeamEnergy:
    """Strain energy of a beam as a function of the coordinates.

    Attributes:
        columns: indices (k,) of the coordinates that move the beam's ends.
        motions: (m, k, N) motions of the ends per unit of each coordinate.
        stiffness: diagonal blocks of the beam's stiffness with respect to these motions.
        inner: indices of the beam's inner coordinates (amplitudes of deflections with fixed ends), whose stiffness is 1.
    """

    columns: tuple[int, ...]
    motions: Array
    stiffness: _Blocks
    inner: Index

    def of(self, modes: Array) -> Array:
        """Return twice the strain energies (N, M) in modes (N, n, M)."""
        moved = np.moveaxis(np.moveaxis(self.motions, 2, 0) @ modes[:, self.columns], 0, 2)
        return np.asarray(np.sum(moved * _product(self.stiffness, moved), axis=0).T + np.sum(modes[:, self.inner] ** 2, axis=1))


@dataclass(frozen=True)
class Stability:
    """Stiffness and geometric stiffness of a robot at N poses.

    Attributes:
        stiffness: K (N, n, n) of the n coordinates of small motions [N/m]; beams also have b inner coordinates of stiffness 1.
        geometric: K_G (N, n + b, n + b) of all coordinates.
        beams: the strain energy of every beam, by name.
        motions: coordinates of the small motions of rigid bodies.
    """

    stiffness: Array
    geometric: Array
    beams: dict[str, BeamEnergy]
    motions: PlacedMotions

    def modes(self) -> tuple[Array, Array]:
        """Return the ratios 1/λ (N, n + b) of forces to critical forces, and the buckling modes (N, n + b, n + b) as columns.

        Motions without stiffness have the ratio 0. The ratios are NaN where K or K_G is not finite.
        """
        n = self.stiffness.shape[1]
        fine = np.all(np.isfinite(self.stiffness), axis=(1, 2)) & np.all(np.isfinite(self.geometric), axis=(1, 2))
        K, G = (np.where(fine[:, None, None], matrix, 0.0) for matrix in (self.stiffness, self.geometric))
        size = np.sqrt(np.abs(np.einsum("nii->ni", K)))
        size = np.where(size > 0, size, 1.0)
        values, axes = np.linalg.eigh(K / (size[:, :, None] * size[:, None]))
        elastic = values > _FREE
        basis = axes * (elastic / np.sqrt(np.where(elastic, values, 1.0)))[:, None] / size[:, :, None]
        A = np.array(-G)
        A[:, :n] = np.swapaxes(basis, 1, 2) @ A[:, :n]
        A[:, :, :n] = A[:, :, :n] @ basis
        ratios, modes = np.linalg.eigh(A)
        modes[:, :n] = basis @ modes[:, :n]
        for item in self.motions.structure.followers:
            modes[:, item.column] = item.times * modes[:, item.master]
        ratios = np.where(np.abs(ratios) > _ROUNDING * np.abs(ratios).max(axis=1, keepdims=True, initial=0.0), ratios, 0.0)
        return np.where(fine[:, None], ratios, np.nan), modes


@dataclass(frozen=True)
class Forces:
    """All forces on and in a robot at N poses, world axes.

    Attributes:
        o: (3, N) position of o [m].
        gravity: (3, N) [m/s²].
        beams: by beam, the section forces (2, 3, N) at its start and end [N].
        joints: (3, J, N) forces of the predecessor on the successor of every joint of the joint table [N].
        centres: (3, J, N) points of application of these forces [m].
        others: loads and weights on rigid bodies: the body, the wrench (6, N) about o [N, N·m], and the point of application
            (3, N) of the wrench's force [m].
        lines: by beam, the loads (12, N) along it except its weight, see :class:`kinetostatics.statics.link_loads.AppliedLoad`.
    """

    frames: Frames
    o: Array
    gravity: Array
    beams: dict[str, Array]
    joints: Array
    centres: Array
    others: list[tuple[RigidBody, Array, Array]]
    lines: dict[str, Array]

    def take(self, poses: Index) -> Forces:
        beams = {name: force[..., poses] for name, force in self.beams.items()}
        others = [(body, wrench[:, poses], point[:, poses]) for body, wrench, point in self.others]
        frames, joints, centres = self.frames.take(poses), self.joints[..., poses], self.centres[..., poses]
        lines = {name: line[:, poses] for name, line in self.lines.items()}
        return Forces(frames, self.o[:, poses], self.gravity[:, poses], beams, joints, centres, others, lines)


def forces_of(structure: SmallMotions, solution: Solution) -> Forces:
    """Return all forces at the poses of a solution; statically indeterminate forces are one of their solutions."""
    model, frames, table = structure.model, solution.frames, structure.model.joint_table
    signs = np.array([table.signs[name] for name in table.names])
    lines: dict[str, Array] = {}
    others = [(structure.platform, solution.load, solution.o)]
    for item in solution.applied:
        for place, wrench in item.load.wrenches.items():
            if place in structure.body_at and place in item.load.points:
                others.append((structure.body_at[place], wrench * item.times, item.load.points[place]))
        for name, line in item.load.lines.items():  # without its resultants: the load acts along the beam
            beam, lines[name] = model.beams[name], lines.get(name, 0.0) + line * item.times
            resultants = line_resultants(beam, frames, line)
            for place, wrench, end in zip(model.topology.line_ends(name), resultants, beam.ends(frames), strict=True):
                about_o = move_wrench(-wrench * item.times, solution.o - end)
                others.append((structure.body_at[place], about_o, item.load.points[place]))
    centres = model.weights.centres(frames)
    others += [(body, solution.weights[:, k], centres[:, k]) for body, k in structure.weights]
    joints = signs[:, None] * carried_wrenches(model, solution)[:3]
    points = frames.points(table.centre_body, table.centre)
    return Forces(frames, solution.o, solution.gravity, beam_forces(model, solution), joints, points, others, lines)


def stability(structure: SmallMotions, forces: Forces) -> Stability:
    found = _Assembly(structure, forces)
    return Stability(np.moveaxis(found.K, 2, 0), np.moveaxis(found.G, 2, 0), found.beams, found.motions)


def surely_stable(structure: SmallMotions, forces: Forces, times: float = 1.0) -> Mask:
    """Return a mask (N,): True where a sufficient condition shows that K + K_G is positive definite under ``times`` the forces.

    For all values of the inner coordinates of a beam, xᵀ(K + K_G)x ≥ uᵀ(B + G)u − |Cᵀu|²/(1 − β), with the motions u of its ends,
    their bending and geometric stiffness B and G, the geometric stiffness C that couples them with the inner coordinates, and the
    ratio β of the largest compressive force to the critical force of the beam with clamped ends. The condition is not met for
    β ≥ 1. The remaining matrix, of rigid-body motions, is sparse because the limbs are connected at the platform only.
    """
    found = _Assembly(structure, forces, condensed=True, times=times)
    diagonal = np.einsum("iin->in", found.G)
    diagonal += found.added
    return definite_in_order(found.G, fronts(len(found.G), frozenset(found.coupled)))


class _Assembly:
    """Assembly of K (n, n, N) and K_G (n + b, n + b, N).

    If ``condensed``, only the diagonal (n, N) of K and a lower bound (n, n, N) of K + K_G without inner coordinates are
    assembled, for ``times`` the given forces.
    """

    def __init__(self, structure: SmallMotions, forces: Forces, condensed: bool = False, times: float = 1.0) -> None:
        self.structure, self.given, self.condensed, self.times = structure, forces, condensed, times
        self.places = {name: k for k, name in enumerate(structure.model.joint_table.names)}
        self.frames, self.o = forces.frames, forces.o
        self.motions = PlacedMotions(structure, self.frames, self.o)
        self.units = self.motions.units
        _, n, N = self.units.shape
        total = n if condensed else n + 2 * INNER * len(structure.beams)
        self.K, self.G = (zeros_for(shape, self.o) for shape in ((n, N) if condensed else (n, n, N), (total, total, N)))
        self.inner = n
        self.coupled: set[tuple[int, ...]] = set()
        # for all bodies with the same coordinates: forces with their points of application, and directions of beams
        self.forces: dict[tuple[int, ...], list[tuple[Array, Array]]] = {}
        self.axes: dict[tuple[int, ...], list[Array]] = {}
        for body, wrench, point in forces.others:
            self._force(body, wrench[:3], point)
        with np.errstate(divide="ignore", invalid="ignore"):  # telescopes without length
            self.beams = dict(self._beams())
            self._springs()
            closing = _CLOSING * self._diagonal().max(axis=0, initial=0.0)
            self._joints()
            self._bodies()
            own = np.array(self._diagonal(), subok=True)
            self._close_loops(closing)
            self.added = _ADDED * np.maximum(own, _ADDED * own.max(axis=0, initial=0.0))
            self.added += _ADDED_LOOPS * (self._diagonal() - own)
        for item in structure.followers:
            self._transfer_follower(item)

    def _diagonal(self) -> Array:
        return self.K if self.condensed else np.einsum("iin->in", self.K)

    def _add(self, columns: tuple[int, ...], motions: Array, stiffness: _Blocks = (), geometric: _Blocks = ()) -> None:
        """Add terms to K and K_G, given by diagonal blocks with respect to m motions, which are linear in k coordinates.

        ``columns`` are the indices of the coordinates; ``motions`` (m, k, N) are the motions per unit of each coordinate.
        """
        self.coupled.add(columns)
        where, products = list(columns), [_product(blocks, motions) for blocks in (stiffness, geometric)]
        if self.condensed:
            self.K[where] += np.einsum("ikn,ikn->kn", motions, products[0])
            self.G[np.ix_(where, where)] += np.einsum("ikn,iln->kln", motions, products[0] + self.times * products[1])
        else:
            for matrix, product in zip((self.K, self.G), products, strict=True):
                matrix[np.ix_(where, where)] += np.einsum("ikn,iln->kln", motions, product)

    def _transfer_follower(self, item: Follower) -> None:
        """Transfer the forces on the coordinate of a mimic joint to the coordinate of its actuator."""
        for matrix in (self.K, self.G):
            matrix[item.master] += item.times * matrix[item.column]
            matrix[item.column] = 0.0
            if matrix.ndim == 3:
                matrix[:, item.master] += item.times * matrix[:, item.column]
                matrix[:, item.column] = 0.0
        self.coupled = {tuple({item.master if column == item.column else column for column in group}) for group in self.coupled}

    def _force(self, body: RigidBody, force: Array, point: Array) -> None:
        self.forces.setdefault(self.structure.columns[body], []).append((force, point))

    def _beams(self) -> Iterator[tuple[str, BeamEnergy]]:
        for beam in self.structure.beams:
            item, bodies = self.structure.model.beams[beam.name], (beam.inner, beam.outer)
            axes = np.array(item.world_axes(self.frames), order="C", subok=True)
            points = item.ends(self.frames)
            length, mine = item.length(self.frames), self.given.beams[beam.name]
            self._force(beam.inner, mine[0], points[0])
            self._force(beam.outer, -mine[1], points[1])
            for body in bodies:
                self.axes.setdefault(self.structure.columns[body], []).append(axes[:, 0])
            columns = self.structure.columns_of(*bodies)
            ends = [self.motions.moved(columns, body, point) for body, point in zip(bodies, points, strict=True)]
            world = np.stack([ends[1][1] - ends[0][1], ends[0][0] * length, ends[1][0] * length])
            local = np.einsum("ian,mikn->amkn", axes, world)
            motions = np.concatenate([local[:1, 0], local[:1, 2] - local[:1, 1], local[1], local[2]])
            motions[3:5], motions[6:8] = local[2, 1:], -local[1, 1:]
            c, along = item.compliances, axes[:, 0]
            pulls = np.einsum("in,ein->en", along, mine)
            # axial shift of the weight relative to the sections
            pulls += item.line_density(length) * dot(along, self.given.gravity) * dot(along, item.lever(self.frames))
            stretch, twist = 1 / (c[0] * length), 1 / (c[3] * length**3)
            stiffness = [(slice(0, 1), stretch[None, None]), (slice(1, 2), twist[None, None])]
            geometric = []
            for k, EI in enumerate((1 / c[5], 1 / c[4])):
                nodes = slice(2 + 3 * k, 5 + 3 * k)
                stiffness.append((nodes, bending(EI, length)))
                if self.condensed:
                    geometric.append((nodes, condensed_tension(self.times * pulls, EI, length) / self.times))
                    continue
                axial, where, own = tension(pulls, EI, length), list(columns), list(range(self.inner, self.inner + INNER))
                geometric.append((nodes, axial[:3, :3]))
                mixed = np.einsum("ikn,ijn->kjn", motions[nodes], axial[:3, 3:])
                self.G[np.ix_(where, own)], self.G[np.ix_(own, where)] = mixed, np.swapaxes(mixed, 0, 1)
                self.G[np.ix_(own, own)] = axial[3:, 3:]
                self.inner += INNER
            self._add(columns, motions, stiffness, geometric)
            yield beam.name, BeamEnergy(columns, motions, stiffness, np.arange(self.inner - 2 * INNER, self.inner))

    def _springs(self) -> None:
        """Add springs between links. A compressed spring is unstable across its axis; this negative stiffness belongs to K_G."""
        for spring in placed_springs(self.structure.model, self.frames):
            values, axes = np.linalg.eigh(np.nan_to_num(np.moveaxis(spring.tangent, 2, 0)))
            stiff = np.einsum("nia,na,nja->ijn", axes, np.maximum(values, 0), axes)
            unstable = np.einsum("nia,na,nja->ijn", axes, np.minimum(values, 0), axes)
            self._add(*self.motions.stretched(spring), [(slice(0, 3), stiff)], [(slice(0, 3), unstable)])

    def _joints(self) -> None:
        """Add the stiffness of elastic joints, joint forces on bodies, and the geometric stiffness of forces in slides."""
        structure, one = self.structure, np.ones_like(self.o[:1, None])
        for joint in structure.joints:
            k, bodies = self.places.get(joint.connection.name), (joint.inner, joint.outer)
            for column in joint.columns:
                freedom = structure.freedoms[column]
                if freedom is not None and freedom.stiffness:
                    scale = structure.model.length**2 if freedom.rotates else 1.0
                    self._add((column,), one, [(slice(0, 1), freedom.stiffness / scale * one)])
            if k is None:
                continue
            force, point = self.given.joints[:, k], self.given.centres[:, k]
            self._force(joint.outer, force, point)
            self._force(joint.inner, -force, point)
            slides = [structure.freedoms[column] for column in joint.columns]
            if any(item is not None and not item.rotates for item in slides):
                columns = structure.columns_of(*bodies)
                ends = [self.motions.moved(columns, body, point) for body in bodies]
                both = np.concatenate([ends[0][0], ends[1][1] - ends[0][1]])
                # f · (θ × u) = θ · (u × f)
                values = zeros_for((6, 6, force.shape[1]), force)
                for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
                    values[i, 3 + j] = values[3 + j, i] = force[k]
                    values[j, 3 + i] = values[3 + i, j] = -force[k]
                self._add(columns, both, (), [(slice(0, 6), values)])

    def _close_loops(self, closing: Array) -> None:
        """Add the stiffness ``closing`` (N,) [N/m] along the constrained directions of joints that close loops."""
        for columns, rows in self.motions.gaps():
            rows *= np.sqrt(closing)
            self._add(columns, rows, [(slice(0, 6), np.broadcast_to(np.eye(6)[:, :, None], (6, 6, len(closing))))])

    def _bodies(self) -> None:
        """Add the geometric stiffness of rigid bodies.

        Under a rotation θ, a force f at an arm r does the work f · (θ × (θ × r)) / 2.
        """
        for columns, mine in self.forces.items():
            turning = tuple(column for column in columns if column in self.structure.turning)
            if not turning:
                continue
            forces, points = (np.stack(items) for items in zip(*mine, strict=True))
            A = np.einsum("fin,fjn->ijn", forces, points - self.o)
            S = (A + np.swapaxes(A, 0, 1)) / 2  # without the coupling of torsion and bending of beams
            axes = self.axes.get(columns, [])
            if axes and all(settles(np.abs(cross(axes[0], other)) < 1e-6) for other in axes):
                e, f = axes[0], np.einsum("ijn,jn->in", S, axes[0])
                mixed = (f - dot(e, f) * e)[:, None] * e
                S -= mixed + np.swapaxes(mixed, 0, 1)
            values = np.einsum("iin->n", S) * np.eye(3)[:, :, None] - S
            self._add(turning, self.units[3:, list(turning)], (), [(slice(0, 3), values)])


def _product(blocks: _Blocks, motions: Array) -> Array:
    """Return the product of a matrix (m, m, N), given by diagonal blocks, and motions (m, k, N)."""
    found = zeros_for(motions.shape, motions, *(values for _, values in blocks))
    for rows, values in blocks:
        found[rows] = np.einsum("ijn,jkn->ikn", values, motions[rows])
    return found
