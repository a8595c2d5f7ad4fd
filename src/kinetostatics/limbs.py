"""One limb at many poses: constraint wrenches J_ic, attached wrenches J_ig W_ig, compliance C_ic and sag Δ_igc.

Limbs that are built alike are stacked along an axis of their own: arrays are ``(component, column, limb, pose)``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kinetostatics import beams as beam_formulas
from kinetostatics.kinematics import Frames
from kinetostatics.limb_joints import limb_units, sides
from kinetostatics.linalg import Cholesky, cross, dot, normalize
from kinetostatics.screws import move_wrench
from kinetostatics.topology import Edge, Limb
from kinetostatics.wrench_bases import Basis, choose_basis, evaluate_bases

if TYPE_CHECKING:
    from kinetostatics.robot import Robot

Array = NDArray[np.float64]
Index = NDArray[np.intp]


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


class LimbGroup:
    """Limbs that are built alike.

    Attributes:
        limbs: the limbs.
        numbers: their positions among the robot's limbs.
        units: of every limb, its joints.
        beams: of every limb, the beams on its path, base to platform.
        basis: the readable wrenches, alike for all but for their labels.
        labels, attached_labels: names of the columns of J_ic and J_ig, for each limb.
        passive: which freedoms are passive.
        platform_joint: which freedoms belong to the platform joint.
        freedoms_before_beam: for each beam on the path, how many freedoms lie on its base side.
    """

    def __init__(self, robot: Robot, numbers: Sequence[int], bases: Sequence[Basis] = ()) -> None:
        self.robot = robot
        self.numbers = tuple(numbers)
        self.limbs = [robot.topology.limbs[k] for k in numbers]
        self.units = [limb_units(robot.mechanism, limb) for limb in self.limbs]
        self.beams = [[robot.beams[edge.beam] for edge in limb.path if edge.beam] for limb in self.limbs]
        first = self.units[0]
        tables = [[freedom for unit in units for freedom in unit.freedoms] for units in self.units]
        self.freedoms = tables
        self.passive = np.array([unit.passive for unit in first for _ in unit.freedoms], dtype=bool)
        self.rotates = np.array([freedom.rotates for freedom in tables[0]], dtype=bool)
        self.unit_of = np.array([k for k, unit in enumerate(first) for _ in unit.freedoms], dtype=np.intp)
        g, k = len(tables), len(tables[0])
        self._axis_body = np.array([[f.body for f in table] for table in tables], dtype=np.intp).reshape(g, k).T.ravel()
        self._axis = np.array([[f.axis for f in table] for table in tables]).reshape(g, k, 3).transpose(2, 1, 0).reshape(3, -1)
        self._centre_body = np.array([[f.centre_body for f in table] for table in tables], dtype=np.intp).reshape(g, k).T.ravel()
        self._centre = (
            np.array([[f.centre for f in table] for table in tables]).reshape(g, k, 3).transpose(2, 1, 0).reshape(3, -1)
        )
        self._sign = np.array([[f.sign for f in table] for table in tables], dtype=float).reshape(g, k).T[None, :, :, None]
        self._rest_point = [self._outer_point(limb) for limb in self.limbs]
        b = len(self.beams[0])
        spans = [[beam.span for beam in beams] for beams in self.beams]
        self._beam_body = {
            what: np.array([[getattr(s, what) for s in row] for row in spans], dtype=np.intp).reshape(g, b).T.ravel()
            for what in ("start_body", "end_body", "carrier")
        }
        self._beam_start = np.array([[s.start for s in row] for row in spans]).reshape(g, b, 3).transpose(2, 1, 0).reshape(3, -1)
        self._beam_end = np.array([[s.end for s in row] for row in spans]).reshape(g, b, 3).transpose(2, 1, 0).reshape(3, -1)
        self._beam_axes = (
            np.array([[m.axes for m in row] for row in self.beams]).reshape(g, b, 3, 3).transpose(2, 3, 1, 0).reshape(3, 3, -1)
        )
        self.compliances = (
            np.array([[m.compliances for m in row] for row in self.beams]).reshape(g, b, 6).transpose(2, 1, 0)[..., None]
        )
        self.freedoms_before_beam = tuple(
            sum(len(unit.freedoms) for unit in first if unit.edge < position)
            for position, edge in enumerate(self.limbs[0].path)
            if edge.beam
        )
        self.platform_joint = self._platform_joint()
        self._y_choice = self._choose_y()
        self._outboard_of_freedom = self._outboard(
            [
                [limb.path[unit.edge] for unit in units for _ in unit.freedoms]
                for limb, units in zip(self.limbs, self.units, strict=True)
            ]
        )
        self._outboard_of_beam = self._outboard([[edge for edge in limb.path if edge.beam] for limb in self.limbs])
        if bases:
            self.basis = bases[0]
            self.labels = [tuple(c.label for c in basis.constraint) for basis in bases]
            self.attached_labels = [tuple(c.label for c in basis.attached) for basis in bases]

    @property
    def is_rigid(self) -> bool:
        """Whether no beam lies on the way from base to platform."""
        return not self.beams[0]

    @property
    def signature(self) -> tuple[object, ...]:
        """What limbs must have in common to be stacked."""
        return (
            tuple((unit.kind, unit.passive, tuple(f.rotates for f in unit.freedoms)) for unit in self.units[0]),
            self.freedoms_before_beam,
            tuple(self.platform_joint.tolist()),
            self._y_choice,
        )

    def _outboard(self, edges: list[list[Edge]]) -> Array:
        """Return the table (limbs, edges, weights) of what is outboard of given edges."""
        names = self.robot.weights.names
        table = [[[(name in edge.outboard) - (name in edge.excluded) for name in names] for edge in row] for row in edges]
        return np.array(table, dtype=float).reshape(len(edges), len(edges[0]), len(names))

    def _platform_joint(self) -> NDArray[np.bool_]:
        """Mark the freedoms of the outermost run of passive joints with neither beam nor weight between them."""
        limb = self.limbs[0]
        inside = np.zeros(len(self.passive), dtype=bool)
        for position in range(len(limb.path) - 1, -1, -1):
            edge = limb.path[position]
            if edge.beam or (limb.weight_between[position] and position < len(limb.path) - 1):
                break
            connection = self.robot.mechanism.connections[str(edge.joint)]
            if connection.driven:
                break
            for k, unit in enumerate(self.units[0]):
                if connection.name in unit.joints:
                    inside |= self.unit_of == k
        return inside

    def _outer_point(self, limb: Limb) -> tuple[int, Array]:
        """Return body and point of the limb's outer end: its last joint's or beam's."""
        edge = limb.path[-1]
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
        axes = frames.directions(self._axis_body, self._axis)[:, :: len(self.limbs), 0]
        for kinds in (("revolute", "continuous", "cylindrical"), ("universal",)):
            for k, unit in enumerate(self.units[0]):
                for f in np.flatnonzero(self.unit_of == k):
                    if unit.kind in kinds and unit.passive and self.rotates[f] and abs(float(axes[:, f] @ z)) < 0.999:
                        return "axis", int(f)
        return "world", int(np.argmin(np.abs(z)))

    def _limb_z(self, frames: Frames) -> Array:
        """Return the limbs' z axes (3, g, N)."""
        g = len(self.limbs)
        if self.beams[0]:
            return frames.directions(self._beam_body["carrier"], self._beam_axes[:, 0])[:, -g:]
        k = len(self.passive)
        outer = frames.points(np.array([b for b, _ in self._rest_point]), np.array([p for _, p in self._rest_point]).T)
        if k:
            inner = frames.points(self._centre_body[:g], self._centre[:, :g])
            axis = outer - inner
            if float(np.min(np.sqrt(dot(axis, axis)), initial=1.0)) > 1e-9:
                return normalize(axis)
        up = np.zeros_like(outer)
        up[2] = 1
        return up

    def geometry(self, frames: Frames, o: Array) -> LimbGeometry:
        """Evaluate the limbs at given frames; ``o`` (3, N) is the reference point."""
        g, k, N = len(self.limbs), len(self.passive), frames.position.shape[2]
        axes = frames.directions(self._axis_body, self._axis).reshape(3, k, g, N)
        arms = (frames.points(self._centre_body, self._centre) - o[:, None]).reshape(3, k, g, N)
        twists = (
            np.concatenate(
                [np.where(self.rotates[:, None, None], cross(arms, axes), axes), np.where(self.rotates[:, None, None], axes, 0.0)]
            )
            * self._sign
        )
        firsts = [int(np.flatnonzero(self.unit_of == u)[-1]) for u in range(len(self.units[0]))]
        outer = frames.points(np.array([b for b, _ in self._rest_point]), np.array([p for _, p in self._rest_point]).T)
        centres = np.concatenate([arms[:, firsts], (outer - o[:, None])[:, None]], axis=1)
        b = len(self.beams[0])
        beam_axes = frames.orientations(self._beam_body["carrier"], self._beam_axes).reshape(3, 3, b, g, N)
        start = frames.points(self._beam_body["start_body"], self._beam_start).reshape(3, b, g, N)
        end = frames.points(self._beam_body["end_body"], self._beam_end).reshape(3, b, g, N)
        lengths = dot(beam_axes[:, 0], end - start)
        z = self._limb_z(frames)
        if self._y_choice[0] == "axis":
            follow = axes[:, self._y_choice[1]]
        else:
            follow = np.zeros_like(z)
            follow[self._y_choice[1]] = 1
        y = normalize(follow - z * dot(z, follow))
        limb_axes = np.stack([cross(y, z), y, z], axis=1)
        return LimbGeometry(axes, twists, centres, limb_axes, beam_axes, lengths, end - o[:, None, None])

    # ---- statics ----------------------------------------------------------------------------------------------------

    def statics(self, frames: Frames, o: Array, weights: Array, gravity: Array) -> LimbStatics:
        """Evaluate the limbs' wrenches, compliances and sag.

        Args:
            frames: of all bodies.
            o: (3, N) reference point.
            weights: (6, W, N) wrenches of all weights about o [N, N·m].
            gravity: (3, N) [m/s²].
        """
        geometry = self.geometry(frames, o)
        J_c, J_g, degenerate = evaluate_bases(self, geometry)
        outboard = np.einsum("gkw,iwn->ikgn", self._outboard_of_freedom, weights)
        beyond = np.einsum("gbw,iwn->ibgn", self._outboard_of_beam, weights)
        passive = self.passive
        row_scale = np.where(self.rotates[passive], self.robot.length, 1.0)[:, None, None]
        T = geometry.twists[:, passive]
        demand = np.einsum("ik...,ik...->k...", T, outboard[:, passive]) / row_scale
        W_g = np.zeros((J_g.shape[1], *demand.shape[1:]))
        left = demand
        if J_g.shape[1]:
            A = np.einsum("ik...,ij...->kj...", T, J_g) / row_scale[:, None]
            normal = np.einsum("ki...,kj...->ij...", A, A)
            factor = Cholesky(normal)
            for _ in range(2):  # the second round removes the error of the normal equations
                right = -np.einsum("ki...,k...->i...", A, left)
                W_g = W_g + factor.solve(right[:, None])[:, 0]
                left = demand + np.einsum("ki...,i...->k...", A, W_g)
        R_g = np.einsum("ij...,j...->i...", J_g, W_g)
        load = self.beam_load(geometry, gravity)
        C, sag = self._compliance(geometry, J_c, R_g, beyond, load)
        return LimbStatics(self, geometry, J_c, J_g, W_g, R_g, C, sag, beyond, load, left, degenerate)

    def beam_load(self, geometry: LimbGeometry, gravity: Array) -> Array:
        """Return the even loads (3, beams, g, N) [N/m] of the beams' own weights, in beam axes."""
        per_length = (
            np.array([[np.nan if m.mass_per_length is None else m.mass_per_length for m in row] for row in self.beams])
            .reshape(len(self.limbs), -1)
            .T[..., None]
        )
        whole = np.array([[m.mass for m in row] for row in self.beams]).reshape(len(self.limbs), -1).T[..., None]
        spread = np.where(np.isnan(per_length), whole / geometry.beam_lengths, per_length)
        return (
            np.einsum("ik...,i...->k...", geometry.beam_axes, np.broadcast_to(gravity[:, None, None], (3, *spread.shape)))
            * spread
        )

    def to_beam(self, geometry: LimbGeometry, beam: int, wrench: Array) -> Array:
        """Return wrenches (6, m, g, N) about o as wrenches about a beam's outer end, in beam axes."""
        moved = move_wrench(wrench, geometry.beam_ends[:, beam][:, None])
        axes = geometry.beam_axes[:, :, beam]
        return np.concatenate([np.einsum("ji...,jm...->im...", axes, part) for part in (moved[:3], moved[3:])])

    def _compliance(self, geometry: LimbGeometry, J_c: Array, R_g: Array, beyond: Array, load: Array) -> tuple[Array, Array]:
        n, g, N = J_c.shape[1:]
        C, sag = np.zeros((n, n, g, N)), np.zeros((n, g, N))
        if not self.beams[0] or n == 0:
            return C, sag
        for b in range(len(self.beams[0])):
            c, L = self.compliances[:, b][:, None], geometry.beam_lengths[b]
            known = (R_g + beyond[:, b])[:, None]
            local = self.to_beam(geometry, b, np.concatenate([J_c, known], axis=1))
            moved = beam_formulas.end_displacement(c, L, local)
            moved[:, n] += beam_formulas.sag(c[:, 0], L, load[:, b])
            product = np.einsum("ki...,kj...->ij...", local[:, :n], moved)
            C += product[:, :n]
            sag += product[:, n]
        return C, sag


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
        beyond: (6, beams, g, N) weights outboard of each beam's outer end.
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
    beyond: Array
    load: Array
    unbalanced: Array
    degenerate: NDArray[np.bool_]


def make_limb_groups(robot: Robot, frames: Frames) -> tuple[LimbGroup, ...]:
    """Choose every limb's basis at generic ``frames`` and stack limbs that are built alike."""
    o = robot.solver.platform_pose(frames)[1]
    members: dict[tuple[object, ...], list[tuple[int, Basis]]] = {}
    for number in range(len(robot.topology.limbs)):
        single = LimbGroup(robot, [number])
        basis = choose_basis(single, frames, o)
        key = (
            single.signature,
            tuple((c.direction, c.centre) for c in (*basis.constraint, *basis.attached)),
            len(basis.constraint),
            basis.independent,
            basis.carried,
        )
        members.setdefault(key, []).append((number, basis))
    return tuple(LimbGroup(robot, *zip(*pairs, strict=True)) for pairs in members.values())
