"""One limb at many poses: constraint wrenches J_ic, attached wrenches J_ig W_ig, compliance C_ic and sag Δ_igc.

All limbs are solved alike: what every edge carries is a sum of chord wrenches (:mod:`kinetostatics.topology`) and weights.

Limbs that are built alike are stacked along an axis of their own: arrays are ``(component, column, limb, pose)``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kinetostatics import beams as beam_formulas
from kinetostatics import force_method
from kinetostatics.kinematics import Frames
from kinetostatics.limb_joints import limb_elements, limb_units, sides
from kinetostatics.linalg import Cholesky, correlation, cross, dot, least_squares, normalize
from kinetostatics.screws import move_wrench
from kinetostatics.springs import springs_of
from kinetostatics.topology import Edge, Limb
from kinetostatics.wrench_bases import Basis, choose_basis, evaluate_bases

if TYPE_CHECKING:
    from kinetostatics.robot import Robot

Array = NDArray[np.float64]

#: Compliance, relative to that of its own direction alone, below which a self-stress counts as rigid.
RIGID = 1e-12


@dataclass(frozen=True)
class LimbGeometry:
    """What one pose of a group of limbs looks like: all arms are from o, arrays (…, limb, pose)."""

    axes: Array  # (3, k, g, N) axes of all freedoms
    twists: Array  # (6, k, g, N) unit twists of all freedoms about o, outboard relative to inboard
    centres: Array  # (3, units, g, N) joint centres
    limb_axes: Array  # (3, 3, g, N) columns x, y, z
    beam_axes: Array  # (3, 3, beams, g, N)
    beam_lengths: Array  # (beams, g, N)
    beam_ends: Array  # (3, beams, g, N)
    spring_axes: Array  # (3, 3, springs, g, N)
    spring_arms: Array  # (3, springs, g, N)


class _Members:
    """Bodies and local vectors of the k-th member of g limbs, as the frames want them: member by member, limb by limb."""

    def __init__(self, bodies: list[list[int]], vectors: list[list[Array]], shape: tuple[int, ...] = (3,)) -> None:
        g, k = len(bodies), len(bodies[0])
        self.count, self.limbs = k, g
        self.bodies = np.array(bodies, dtype=np.intp).reshape(g, k).T.ravel()
        stacked = np.array(vectors, dtype=float).reshape(g, k, *shape)
        self.vectors = np.moveaxis(stacked, (0, 1), (-1, -2)).reshape(*shape, k * g)

    def points(self, frames: Frames) -> Array:
        """Return world positions (3, k, g, N)."""
        if not self.count:  # which indexing would pay for
            return np.zeros((3, 0, self.limbs, frames.position.shape[2]))
        return self._shaped(frames.points(self.bodies, self.vectors))

    def directions(self, frames: Frames) -> Array:
        """Return world directions (3, k, g, N)."""
        return self._shaped(frames.directions(self.bodies, self.vectors))

    def orientations(self, frames: Frames) -> Array:
        """Return world orientations (3, 3, k, g, N)."""
        if not self.count:
            return np.zeros((3, 3, 0, self.limbs, frames.position.shape[2]))
        return self._shaped(frames.orientations(self.bodies, self.vectors))

    def _shaped(self, array: Array) -> Array:
        return array.reshape(*array.shape[:-2], self.count, self.limbs, array.shape[-1])


class LimbGroup:
    """Limbs that are built alike.

    Attributes:
        limbs: the limbs.
        numbers: their positions among the robot's limbs.
        units: of every limb, its joints.
        elements: of every limb, its beams and joints, alike but for how many edges of the file they are.
        beams, springs: of every limb, the beams and springs on its edges, inboard ones first.
        spring_elements: which elements the springs belong to.
        plan: how the chord wrenches of a limb that is not serial are found.
        rigid_directions: along how many combinations of its constraint wrenches the limb is rigid.
        basis: the readable wrenches, alike for all but for their labels.
        labels, attached_labels: names of the columns of J_ic and J_ig, for each limb.
        passive: which freedoms are passive.
        platform_joint: which freedoms belong to the platform joint.
        freedom_chords, beam_chords, spring_chords: (…, M) signs of the chord wrenches that each of them carries.
        to_platform: (M,) which chords end at the platform.
    """

    def __init__(
        self, robot: Robot, numbers: Sequence[int], bases: Sequence[Basis] = (), plan: force_method.Plan | None = None
    ) -> None:
        self.robot = robot
        self.numbers = tuple(numbers)
        self.limbs = [robot.all_limbs[k] for k in numbers]
        self.units = [limb_units(robot.mechanism, limb) for limb in self.limbs]
        self.beams = [[robot.beams[edge.beam] for edge in limb.edges if edge.beam] for limb in self.limbs]
        sprung = [
            [(edge, spring) for edge in limb.edges if edge.joint for spring in springs_of(robot.mechanism, edge.joint)]
            for limb in self.limbs
        ]
        self.springs = [[spring for _, spring in row] for row in sprung]
        self.elements = [limb_elements(limb, units) for limb, units in zip(self.limbs, self.units, strict=True)]
        element_of = {k: number for number, element in enumerate(self.elements[0]) for k in element.edges}
        self.spring_elements = tuple(element_of[self.limbs[0].edges.index(edge)] for edge, _ in sprung[0])
        self.plan = plan
        self.rigid_directions = 0
        first = self.units[0]
        self.freedoms = tables = [[freedom for unit in units for freedom in unit.freedoms] for units in self.units]
        self.passive = np.array([freedom.passive for freedom in tables[0]], dtype=bool)
        self.rotates = np.array([freedom.rotates for freedom in tables[0]], dtype=bool)
        self.unit_of = np.array([k for k, unit in enumerate(first) for _ in unit.freedoms], dtype=np.intp)
        self._axes = _Members([[f.body for f in row] for row in tables], [[f.axis for f in row] for row in tables])
        self._centres = _Members([[f.centre_body for f in row] for row in tables], [[f.centre for f in row] for row in tables])
        self._sign = np.array([[f.sign for f in row] for row in tables], dtype=float).reshape(len(tables), -1).T[..., None]
        self._outer_points = _Members(*_transposed([[self._outer_point(limb)] for limb in self.limbs]))
        spans = [[beam.span for beam in beams] for beams in self.beams]
        self._beam_starts = _Members([[s.start_body for s in row] for row in spans], [[s.start for s in row] for row in spans])
        self._beam_ends = _Members([[s.end_body for s in row] for row in spans], [[s.end for s in row] for row in spans])
        self._beam_axes = _Members(
            [[s.carrier for s in row] for row in spans], [[m.axes for m in row] for row in self.beams], (3, 3)
        )
        bodies = [[spring.body for spring in row] for row in self.springs]
        self._spring_axes = _Members(bodies, [[spring.frame[:3, :3] for spring in row] for row in self.springs], (3, 3))
        self._spring_points = _Members(bodies, [[spring.frame[:3, 3] for spring in row] for row in self.springs])
        self.compliances = _members_last([[m.compliances for m in row] for row in self.beams], (6,))
        self.spring_linear = _members_last([[spring.linear for spring in row] for row in self.springs], (3, 3))
        self.spring_angular = _members_last([[spring.angular for spring in row] for row in self.springs], (3, 3))
        limb = self.limbs[0]
        self.to_platform = np.array(limb.to_platform, dtype=bool)
        self.freedom_chords = self._chords([limb.edges[unit.edge] for unit in first for _ in unit.freedoms])
        self.beam_chords = self._chords([edge for edge in limb.edges if edge.beam])
        self.spring_chords = self._chords([edge for edge, _ in sprung[0]])
        self.platform_joint = self._platform_joint()
        self._y_choice = self._choose_y()
        self._world_y = np.eye(3)[:, np.argmin(np.abs(self._limb_z(robot.zero_frames)[:, :, 0]), axis=0)]
        own = [[robot.weights.names.index(name) for name in limb.weights] for limb in self.limbs]
        most = max(map(len, own), default=0)
        self._own_weights = np.array([row + [0] * (most - len(row)) for row in own], dtype=np.intp).reshape(len(own), most)
        self._outboard_of_freedom = self._outboard(
            [
                [limb.edges[unit.edge] for unit in units for _ in unit.freedoms]
                for limb, units in zip(self.limbs, self.units, strict=True)
            ]
        )
        self._outboard_of_beam = self._outboard([[edge for edge in limb.edges if edge.beam] for limb in self.limbs])
        self._outboard_of_spring = self._outboard([[edge for edge, _ in row] for row in sprung])
        if bases:
            self.basis = bases[0]
            self.labels = [tuple(c.label for c in basis.constraint) for basis in bases]
            self.attached_labels = [tuple(c.label for c in basis.attached) for basis in bases]

    @property
    def is_rigid(self) -> bool:
        """Whether nothing in it is elastic."""
        return not self.beams[0] and not self.springs[0]

    @property
    def is_serial(self) -> bool:
        """Whether the limb is a single way from base to platform."""
        return self.limbs[0].is_serial

    @property
    def is_hanging(self) -> bool:
        """Whether these are closed chains that hang on base or platform alone."""
        return not np.any(self.to_platform)

    @property
    def signature(self) -> tuple[object, ...]:
        """What limbs must have in common to be stacked."""
        return (
            tuple((unit.kind, tuple((f.rotates, f.passive) for f in unit.freedoms)) for unit in self.units[0]),
            tuple(element.signature for element in self.elements[0]),
            tuple(map(tuple, self.spring_chords.tolist())),
            self.spring_elements,
            tuple(self.platform_joint.tolist()),
            self.limbs[0].to_platform,
            self.limbs[0].on_platform,
            self._y_choice,
        )

    def _chords(self, edges: list[Edge]) -> NDArray[np.int8]:
        """Return the signs (edges, M) of the chord wrenches that edges carry."""
        table = np.zeros((len(edges), len(self.to_platform)), dtype=np.int8)
        for row, edge in enumerate(edges):
            for chord, sign in edge.chords:
                table[row, chord] = sign
        return table

    def _outboard(self, edges: list[list[Edge]]) -> Array:
        """Return the table (limbs, edges, own weights) of what is outboard of given edges."""
        names = self.robot.weights.names
        table = np.zeros((len(edges), len(edges[0]), self._own_weights.shape[1]))
        for g, (row, limb) in enumerate(zip(edges, self.limbs, strict=True)):
            for w in range(len(limb.weights)):
                name = names[self._own_weights[g, w]]
                table[g, :, w] = [(name in edge.outboard) - (name in edge.excluded) for edge in row]
        return table

    def _platform_joint(self) -> NDArray[np.bool_]:
        """Mark the freedoms of the outermost run of passive joints with neither beam nor weight between them.

        Where several joints lead to the platform none is the platform joint.
        """
        limb = self.limbs[0]
        inside = np.zeros(len(self.passive), dtype=bool)
        if np.sum(self.to_platform) != 1:
            return inside
        last = ((int(np.flatnonzero(self.to_platform)[0]), 1),)
        position = max(k for k, edge in enumerate(limb.edges) if edge.chords == last)
        outermost = position
        while position >= 0:
            edge = limb.edges[position]
            if edge.beam or (limb.ends[position] and position < outermost):
                break
            connection = self.robot.mechanism.connections[str(edge.joint)]
            if connection.driven or connection.name in self.robot.description.joint_stiffness:
                break
            for k, unit in enumerate(self.units[0]):
                if connection.name in unit.joints:
                    inside |= self.unit_of == k
            position -= 1
        return inside

    def _outer_point(self, limb: Limb) -> tuple[int, Array]:
        """Return body and point of the limb's outer end: its last joint's or beam's."""
        edge = limb.edges[-1]
        if edge.beam:
            span = self.robot.beams[edge.beam].span
            return span.end_body, span.end
        connection = self.robot.mechanism.connections[str(edge.joint)]
        body, frame = sides(edge, connection)[1]
        return body, frame[:3, 3]

    def _choose_y(self) -> tuple[str, int]:
        """Choose what the limb's y axis follows: a passive revolute, else a universal's axis, else a world axis."""
        frames = self.robot.zero_frames
        z = self._limb_z(frames)[:, 0, 0]
        axes = self._axes.directions(frames)[:, :, 0, 0]
        for kinds in (("revolute", "continuous", "cylindrical"), ("universal",)):
            for k, unit in enumerate(self.units[0]):
                for f in np.flatnonzero(self.unit_of == k):
                    if unit.kind in kinds and self.passive[f] and self.rotates[f] and abs(float(axes[:, f] @ z)) < 0.999:
                        return "axis", int(f)
        return "world", -1

    def _limb_z(self, frames: Frames) -> Array:
        """Return the limbs' z axes (3, g, N)."""
        if self.beams[0]:
            return self._beam_axes.orientations(frames)[:, 0, -1]
        outer = self._outer_points.points(frames)[:, 0]
        if len(self.passive):
            axis = outer - self._centres.points(frames)[:, 0]
            if float(np.min(np.sqrt(dot(axis, axis)), initial=1.0)) > 1e-9:
                return normalize(axis)
        up = np.zeros_like(outer)
        up[2] = 1
        return up

    def geometry(self, frames: Frames, o: Array) -> LimbGeometry:
        """Evaluate the limbs at given frames; ``o`` (3, N) is the reference point."""
        o = o[:, None, None]
        axes = self._axes.directions(frames)
        arms = self._centres.points(frames) - o
        twists = np.empty((6, *axes.shape[1:]))
        slides = np.flatnonzero(~self.rotates)
        twists[:3], twists[3:] = cross(arms, axes), axes
        twists[:3, slides], twists[3:, slides] = axes[:, slides], 0.0
        if np.any(self._sign < 0):
            twists *= self._sign
        last = [int(np.flatnonzero(self.unit_of == u)[-1]) for u in range(len(self.units[0]))]
        centres = np.concatenate([arms[:, last], self._outer_points.points(frames) - o], axis=1)
        beam_axes = self._beam_axes.orientations(frames)
        end = self._beam_ends.points(frames)
        lengths = dot(beam_axes[:, 0], end - self._beam_starts.points(frames))
        z = self._limb_z(frames)
        if self._y_choice[0] == "axis":
            follow = axes[:, self._y_choice[1]]
        else:
            follow = np.broadcast_to(self._world_y[:, :, None], z.shape)
        y = normalize(follow - z * dot(z, follow))
        limb_axes = np.stack([cross(y, z), y, z], axis=1)
        return LimbGeometry(
            axes,
            twists,
            centres,
            limb_axes,
            beam_axes,
            lengths,
            end - o,
            self._spring_axes.orientations(frames),
            self._spring_points.points(frames) - o,
        )

    # ---- chords -----------------------------------------------------------------------------------------------------

    def joint_equations(self, geometry: LimbGeometry) -> Array:
        """Return the passive joints' equations (k, 6 M, g, N) for scaled chord wrenches: no power on any freedom [1]."""
        scaled = geometry.twists[:, self.passive] * self.twist_scale
        rows = self.freedom_chords[self.passive].T[:, None, :, None, None] * scaled
        rows = rows.reshape(rows.shape[0] * rows.shape[1], *scaled.shape[1:]).swapaxes(0, 1)
        return np.ascontiguousarray(rows / self._row_scale)

    @property
    def platform_sum(self) -> Array:
        """The sum (6, 6 M) of the chord wrenches that the platform feels."""
        return np.concatenate([np.eye(6) * felt for felt in self.to_platform], axis=1)

    @property
    def twist_scale(self) -> Array:
        """Factors (6, 1, 1, 1) of twists for moments divided by the characteristic length."""
        return np.array([1.0] * 3 + [self.robot.length] * 3).reshape(6, 1, 1, 1)

    @property
    def _row_scale(self) -> Array:
        return np.where(self.rotates[self.passive], self.robot.length, 1.0).reshape(-1, 1, 1, 1)

    def felt(self, chords: Array) -> Array:
        """Return what the platform puts on the limb (6, …) by chord wrenches (M, 6, …)."""
        return self.carried(self.to_platform.astype(np.int8), chords)

    def carried(self, signs: NDArray[np.int8], chords: Array) -> Array:
        """Return the part (6, …) of chord wrenches (M, 6, …) that an edge with given signs carries."""
        if len(signs) == 1 and signs[0] == 1:
            return chords[0]
        total = np.zeros(chords.shape[1:])
        for number in np.flatnonzero(signs):
            total += signs[number] * chords[number]
        return total

    # ---- statics ----------------------------------------------------------------------------------------------------

    def statics(self, frames: Frames, o: Array, weights: Array, gravity: Array, misfit: Array | None = None) -> LimbStatics:
        """Evaluate the limbs' wrenches, compliances and sag.

        Args:
            frames: of all bodies.
            o: (3, N) reference point.
            weights: (6, W, N) wrenches of all weights about o [N, N·m].
            gravity: (3, N) [m/s²].
            misfit: (6, elements, g, N) what each element's outboard side is displaced by for no force, about o; None: nothing.
        """
        geometry = self.geometry(frames, o)
        own = weights[:, self._own_weights.T.ravel()].reshape(6, *self._own_weights.T.shape, weights.shape[2])
        outboard = np.einsum("gkw,iwgn->ikgn", self._outboard_of_freedom[:, self.passive], own)
        demand = np.einsum("ik...,ik...->k...", geometry.twists[:, self.passive], outboard) / self._row_scale[:, 0]
        found = self._serial(geometry, demand) if self.is_serial else self._with_rings(geometry, demand)
        chords, particular, self_stress = found.chords, found.particular, found.self_stress
        beyond = np.einsum("gbw,iwgn->ibgn", self._outboard_of_beam, own)
        spring_beyond = np.einsum("gbw,iwgn->ibgn", self._outboard_of_spring, own)
        load = self.beam_load(geometry, gravity)
        columns = np.concatenate([chords, self_stress], axis=2) if self_stress.shape[2] else chords
        gram, sag = self._strains(geometry, columns, particular, beyond, spring_beyond, load)
        error = self._misfit_strains(columns, misfit)
        loose = np.zeros((*self_stress.shape[:2], 0, *self_stress.shape[3:]))
        misfit_chords = np.zeros_like(particular)
        n = found.J_c.shape[1]
        if self_stress.shape[2]:
            gain, loose = self._relax(gram, self_stress)
            mixed = np.einsum("ab...,bj...->aj...", gain, gram[n:, :n])
            chords = chords - np.einsum("mia...,aj...->mij...", self_stress, mixed)
            particular = particular - np.einsum("mia...,ab...,b...->mi...", self_stress, gain, sag[n:])
            misfit_chords = -np.einsum("mia...,ab...,b...->mi...", self_stress, gain, error[n:])
            before = np.einsum("ii...->i...", gram[:n, :n]).max(axis=0, initial=0.0)
            gram, sag = self._strains(geometry, chords, particular, beyond, spring_beyond, load)
            rounding = np.einsum("ii...->i...", gram) <= 1e-20 * before
            gram = np.where(rounding[:, None] | rounding[None], 0.0, gram)
            error = np.where(self._contradict(loose, misfit), np.nan, self._misfit_strains(chords, misfit))
        return LimbStatics(
            self,
            geometry,
            found.J_c,
            found.J_g,
            found.W_g,
            self.felt(particular),
            gram,
            sag,
            error,
            chords,
            particular,
            misfit_chords,
            loose,
            beyond,
            spring_beyond,
            load,
            found.unbalanced,
            found.degenerate,
        )

    def _serial(self, geometry: LimbGeometry, demand: Array) -> _Wrenches:
        """Return the wrenches of serial limbs: their one chord carries just what the platform puts on them."""
        T = geometry.twists[:, self.passive]
        J_c, J_g, degenerate = evaluate_bases(self, geometry, T)
        W_g = np.zeros((J_g.shape[1], *demand.shape[1:]))
        left = demand
        if J_g.shape[1]:
            A = np.einsum("ik...,ij...->kj...", T, J_g) / self._row_scale
            factor = Cholesky(np.einsum("ki...,kj...->ij...", A, A))
            for _ in range(2):  # the second round removes the error of the normal equations
                right = -np.einsum("ki...,k...->i...", A, left)
                W_g = W_g + factor.solve(right[:, None])[:, 0]
                left = demand + np.einsum("ki...,i...->k...", A, W_g)
        none = np.zeros((1, 6, 0, *demand.shape[1:]))
        R_g = np.einsum("ij...,j...->i...", J_g, W_g)
        return _Wrenches(J_c, J_g, W_g, J_c[None], R_g[None], none, left, degenerate)

    def _with_rings(self, geometry: LimbGeometry, demand: Array) -> _Wrenches:
        """Return the wrenches of limbs with several chords."""
        assert self.plan is not None
        A = self.joint_equations(geometry)
        M, batch = len(self.to_platform), demand.shape[1:]
        found = force_method.distribute(self.plan, A, self.platform_sum, demand)
        left = demand + np.einsum("kn...,n...->k...", A, found.particular)
        scale = self.twist_scale
        J_c, J_g, degenerate = evaluate_bases(self, geometry, found.allowed / scale)
        n_c, n_g = J_c.shape[1], J_g.shape[1]
        spread = found.spread.reshape(M, 6, 6, *batch)
        chords = np.einsum("mij...,jc...->mic...", spread, J_c / scale) * scale[None]
        particular = found.particular.reshape(M, 6, *batch) * scale[:, 0]
        self_stress = found.self_stress.reshape(M, 6, len(self.plan.free), *batch) * scale[None]
        total = self.felt(particular)
        W_g = np.zeros((n_g, *batch))
        if n_c + n_g:
            # The particular solution is made the one whose platform wrench has only readable attached parts.
            basis = np.concatenate([J_c, J_g], axis=1) / scale
            parts = least_squares(basis, (total / scale[:, 0])[:, None])[:, 0]
            W_g = parts[n_c:]
            particular = particular - np.einsum("mic...,c...->mi...", chords, parts[:n_c])
        return _Wrenches(J_c, J_g, W_g, chords, particular, self_stress, left, degenerate)

    def _relax(self, gram: Array, self_stress: Array) -> tuple[Array, Array]:
        """Return the inverse (s, s, g, N) of the compliance along self-stresses, and the chord wrenches of rigid ones."""
        n = len(gram) - self_stress.shape[2]
        scaled, unit = correlation(np.moveaxis(gram, (0, 1), (-2, -1)))
        scaled, unit = scaled[..., n:, n:], unit[..., n:]
        values, vectors = np.linalg.eigh(scaled)
        soft = values > RIGID
        inverse = np.where(soft, 1 / np.where(soft, values, 1.0), 0.0)
        gain = np.einsum("...i,...ik,...k,...jk,...j->ij...", unit, vectors, inverse, vectors, unit, optimize=True)
        loose = np.where(soft[..., None, :], 0.0, vectors) * unit[..., :, None]
        return gain, np.einsum("mia...,...ab->mib...", self_stress, loose)

    def beam_load(self, geometry: LimbGeometry, gravity: Array) -> Array:
        """Return the even loads (3, beams, g, N) [N/m] of the beams' own weights, in beam axes."""
        per_length = (
            np.array([[np.nan if m.mass_per_length is None else m.mass_per_length for m in row] for row in self.beams])
            .reshape(len(self.limbs), -1)
            .T[..., None]
        )
        whole = np.array([[m.mass for m in row] for row in self.beams]).reshape(len(self.limbs), -1).T[..., None]
        with np.errstate(divide="ignore", invalid="ignore"):  # a telescope may be pushed together to nothing
            spread = np.where(np.isnan(per_length), whole / geometry.beam_lengths, per_length)
        return (
            np.einsum("ik...,i...->k...", geometry.beam_axes, np.broadcast_to(gravity[:, None, None], (3, *spread.shape)))
            * spread
        )

    def _strains(
        self, geometry: LimbGeometry, columns: Array, particular: Array, beyond: Array, spring_beyond: Array, load: Array
    ) -> tuple[Array, Array]:
        """Return the compliance (n, n, g, N) along chord wrenches (M, 6, n, g, N), and the sag (n, g, N) along them."""
        n, g, N = columns.shape[2:]
        C, sag = np.zeros((n, n, g, N)), np.zeros((n, g, N))
        if n == 0:
            return C, sag
        for b in range(len(self.beams[0])):
            c, L = self.compliances[:, b][:, None], geometry.beam_lengths[b]
            known = self.carried(self.beam_chords[b], particular) + beyond[:, b]
            wrench = np.concatenate([self.carried(self.beam_chords[b], columns), known[:, None]], axis=1)
            local = to_axes(geometry.beam_axes[:, :, b], geometry.beam_ends[:, b], wrench)
            moved = beam_formulas.end_displacement(c, L, local)
            moved[:, n] += beam_formulas.sag(c[:, 0], L, load[:, b])
            product = np.einsum("ki...,kj...->ij...", local[:, :n], moved)
            C += product[:, :n]
            sag += product[:, n]
        for k in range(len(self.springs[0])):
            known = self.carried(self.spring_chords[k], particular) + spring_beyond[:, k]
            wrench = np.concatenate([self.carried(self.spring_chords[k], columns), known[:, None]], axis=1)
            local = to_axes(geometry.spring_axes[:, :, k], geometry.spring_arms[:, k], wrench)
            product = np.einsum("ki...,kj...->ij...", local[:, :n], self.spring_twist(k, local))
            C += product[:, :n]
            sag += product[:, n]
        return C, sag

    def spring_twist(self, spring: int, wrench: Array) -> Array:
        """Return the twists (6, …, g, N) of a spring's outboard side under wrenches, both at and in its joint's frame."""
        linear, angular = self.spring_linear[:, :, spring, :, 0], self.spring_angular[:, :, spring, :, 0]
        return np.concatenate(
            [np.einsum("ijg,j...gn->i...gn", linear, wrench[:3]), np.einsum("ijg,j...gn->i...gn", angular, wrench[3:])]
        )

    def _misfit_strains(self, columns: Array, misfit: Array | None) -> Array:
        """Return what misfits (6, elements, g, N) do along chord wrenches (M, 6, n, g, N): (n, g, N)."""
        error: Array = np.zeros(columns.shape[2:])
        if misfit is None or not error.size:
            return error
        chords = self.element_chords()
        for k in range(misfit.shape[1]):
            if np.any(misfit[:, k]):
                error += np.einsum("in...,i...->n...", self.carried(chords[k], columns), misfit[:, k])
        return error

    def _contradict(self, loose: Array, misfit: Array | None) -> NDArray[np.bool_]:
        """Return where (g, N) misfits do something along self-stresses without compliance: rigid rings cannot follow them."""
        if misfit is None:
            return np.zeros(loose.shape[3:], dtype=bool)
        length = self.robot.length
        forces = np.max(np.maximum(np.abs(loose[:, :3]), np.abs(loose[:, 3:]) / length), axis=(0, 1))
        shifts = np.max(np.maximum(np.abs(misfit[:3]), np.abs(misfit[3:]) * length), axis=(0, 1))
        return np.asarray(np.any(np.abs(self._misfit_strains(loose, misfit)) > 1e-7 * forces * shifts, axis=0))

    def element_chords(self) -> NDArray[np.int8]:
        """Return the signs (elements, M) of the chord wrenches that all elements carry."""
        limb = self.limbs[0]
        return self._chords([limb.edges[element.edges[-1]] for element in self.elements[0]])


def _transposed(pairs: list[list[tuple[int, Array]]]) -> tuple[list[list[int]], list[list[Array]]]:
    return [[body for body, _ in row] for row in pairs], [[point for _, point in row] for row in pairs]


def _members_last(rows: list[list[Array]], shape: tuple[int, ...]) -> Array:
    """Return constants of members of g limbs as (*shape, members, g, 1)."""
    array: Array = np.array(rows, dtype=float).reshape(len(rows), len(rows[0]), *shape)
    return np.expand_dims(np.moveaxis(array, (0, 1), (-1, -2)), -1)


def to_axes(axes: Array, arm: Array, wrench: Array) -> Array:
    """Return wrenches (6, m, g, N) about o as wrenches about the point at ``arm`` (3, g, N), in axes (3, 3, g, N)."""
    moved = move_wrench(wrench, arm[:, None])
    return np.concatenate([np.einsum("ji...,jm...->im...", axes, part) for part in (moved[:3], moved[3:])])


@dataclass(frozen=True)
class _Wrenches:
    """What joints and weights alone say of the wrenches of limbs; see :class:`LimbStatics`."""

    J_c: Array
    J_g: Array
    W_g: Array
    chords: Array
    particular: Array
    self_stress: Array
    unbalanced: Array
    degenerate: NDArray[np.bool_]


@dataclass(frozen=True)
class LimbStatics:
    """A group of limbs at many poses; arrays (…, limb, pose), wrenches about o.

    Attributes:
        group, geometry: the limbs and where they are.
        J_c, J_g: (6, n_c, g, N), (6, n_g, g, N) constraint and attached wrenches, Eqs. (2)–(4).
        W_g: (n_g, g, N) attached intensities, Eq. (3).
        R_g: (6, g, N) their sum J_ig W_ig.
        C: (n_c, n_c, g, N) compliance C_ic, Eq. (1).
        sag: (n_c, g, N) Δ_igc, Eqs. (16), (19), (21).
        misfit: (n_c, g, N) the same of misfits.
        chords: (M, 6, n_c, g, N) chord wrenches per unit of each intensity; of a serial limb J_c itself.
        particular: (M, 6, g, N) chord wrenches under the limb's own weight; of a serial limb R_g.
        misfit_chords: (M, 6, g, N) chord wrenches under misfits with no intensity: self-stress.
        loose: (M, 6, s, g, N) self-stresses without any compliance: how much of them there is cannot be told.
        beyond, spring_beyond: (6, beams, g, N) weights outboard of each beam's outer end and of each spring.
        load: (3, beams, g, N) the beams' own weights in beam axes [N/m].
        unbalanced: (passive freedoms, g, N) what is left of Eq. (3) [N].
        degenerate: (g, N) where the bases are not the readable ones.
    """

    group: LimbGroup
    geometry: LimbGeometry
    J_c: Array
    J_g: Array
    W_g: Array
    R_g: Array
    C: Array
    sag: Array
    misfit: Array
    chords: Array
    particular: Array
    misfit_chords: Array
    loose: Array
    beyond: Array
    spring_beyond: Array
    load: Array
    unbalanced: Array
    degenerate: NDArray[np.bool_]


def make_limb_groups(robot: Robot, frames: Frames) -> tuple[LimbGroup, ...]:
    """Choose every limb's basis at generic ``frames`` and stack limbs that are built alike."""
    o = robot.solver.platform_pose(frames)[1]
    members: dict[tuple[object, ...], list[tuple[int, Basis]]] = {}
    plans: dict[tuple[object, ...], list[force_method.Plan]] = {}
    plan_of: dict[tuple[object, ...], force_method.Plan | None] = {}
    for number in range(len(robot.all_limbs)):
        single = LimbGroup(robot, [number])
        geometry = single.geometry(frames, o)
        plan = None if single.is_serial else _plan(single, geometry, plans.setdefault(single.signature, []))
        basis = choose_basis(LimbGroup(robot, [number], plan=plan), geometry)
        key = (
            single.signature,
            tuple((c.direction, c.centre) for c in (*basis.constraint, *basis.attached)),
            len(basis.constraint),
            basis.independent,
            basis.carried,
            plan,
            _rigid_directions(LimbGroup(robot, [number], [basis], plan), frames, o),
        )
        members.setdefault(key, []).append((number, basis))
        plan_of[key] = plan
    groups = [
        LimbGroup(robot, [number for number, _ in pairs], [basis for _, basis in pairs], plan_of[key])
        for key, pairs in members.items()
    ]
    for group in groups:
        group.rigid_directions = _rigid_directions(group, frames, o)
    return tuple(groups)


def _rigid_directions(group: LimbGroup, frames: Frames, o: Array) -> int:
    """Return along how many combinations of its constraint wrenches a limb is rigid, at generic poses."""
    N = o.shape[1]
    C = group.statics(frames, o, np.zeros((6, len(group.robot.weights.names), N)), np.zeros((3, N))).C
    n = C.shape[0]
    if n == 0:
        return 0
    values = np.linalg.eigvalsh(correlation(np.moveaxis(C, (0, 1), (-2, -1)))[0])
    return int(np.min(np.sum(values <= RIGID, axis=-1)))


def _plan(single: LimbGroup, geometry: LimbGeometry, known: list[force_method.Plan]) -> force_method.Plan:
    """Return a plan that another limb built alike has already, if it suits, else a new one."""
    A, P, tolerance = single.joint_equations(geometry)[:, :, 0], single.platform_sum, single.robot.rank_tolerance
    for plan in known:
        if force_method.suits(plan, A, P, tolerance):
            return plan
    known.append(force_method.make_plan(A, P, tolerance))
    return known[-1]
