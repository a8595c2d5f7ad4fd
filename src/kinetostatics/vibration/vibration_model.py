"""Dynamic stiffness D(λ) of a whole robot at the square λ = ω² of the angular frequency, without discretization.

The coordinates are the small motions of rigid bodies and joints. A beam is an exact rod, or is divided into equal rods (pieces),
whose frequencies with clamped ends are above the requested frequencies. At a requested frequency, the number of negative
eigenvalues of D(λ) is then the number of natural frequencies below it (W. H. Wittrick and F. W. Williams, Quarterly Journal of
Mechanics and Applied Mathematics 24, 1971).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from kinetostatics.elements.link import VibratingLink
from kinetostatics.elements.rods import Numbers
from kinetostatics.math.arrays import Array, Index, Mask
from kinetostatics.mechanism.body_graph import RigidBody
from kinetostatics.statics.small_motions import BeamEnds, PlacedMotions, SmallMotions
from kinetostatics.statics.springs import placed_springs

#: Singular value of the closure equations, relative to the largest, below which an equation is dependent.
_DEPENDENT = 1e-9


@dataclass(frozen=True)
class Part:
    """A mass, or a spring, at N poses.

    Attributes:
        columns: indices of the k coordinates that move the part.
        motions: (N, r, k) displacements of the part per unit of each coordinate.
        matrix: (N, r, r) mass [kg, kg·m²] or stiffness [N/m, N·m/rad] with respect to these displacements.
        carried: (N, r, 6) displacements of the part when the whole robot moves as one body, per unit of its twist about o.
        indefinite: whether the stiffness may have negative eigenvalues.
    """

    columns: tuple[int, ...]
    motions: Array
    matrix: Array
    carried: Array
    indefinite: bool = False

    def take(self, poses: Index) -> Part:
        motions, matrix, carried = self.motions[poses], self.matrix[poses], self.carried[poses]
        return replace(self, motions=motions, matrix=matrix, carried=carried)

    def of_coordinates(self) -> Array:
        """Return the mass or stiffness Tᵀ A T (N, k, k) with respect to the part's k coordinates, with the motions T."""
        return np.asarray(np.swapaxes(self.motions, 1, 2) @ self.matrix @ self.motions)


@dataclass(frozen=True)
class PlacedRod:
    """A beam at N poses.

    Attributes:
        columns: indices of the k coordinates that move its ends.
        motions: (N, 12, k) displacement and rotation of start and end per unit of each coordinate, beam axes.
        carried: (N, 12 + b, 6) displacement and rotation of start and end when the whole robot moves as one body, see
            :class:`Part`, then those of b inner coordinates, zero.
        pieces: number of equal rods into which the beam is divided.
    """

    columns: tuple[int, ...]
    motions: Array
    carried: Array
    rod: VibratingLink
    pieces: int = 1

    @property
    def piece(self) -> VibratingLink:
        return self.rod.piece(self.pieces)

    @property
    def more(self) -> int:
        """Number of coordinates of points between the pieces, and of inner coordinates."""
        return 6 * (self.pieces - 1) + self.rod.inner

    def take(self, poses: Index) -> PlacedRod:
        return replace(self, motions=self.motions[poses], carried=self.carried[poses], rod=self.rod.take(poses))

    def carried_piece(self, number: int) -> Array:
        """Return the displacements (N, 12 + b, 6) of a piece's ends when the whole robot moves as one body, see :class:`Part`."""
        if self.pieces == 1:
            return self.carried
        start, end = self.carried[:, :6], self.carried[:, 6:]
        return np.concatenate([start + (end - start) * ((number + k) / self.pieces) for k in (0, 1)], axis=1)

    def moved(self, first: int, size: float) -> Iterator[tuple[list[int], Array]]:
        """Yield for every piece its k coordinates, and the motions (…, 12 + b, k) of its ends per unit of each.

        ``first`` is the index of the first coordinate of points between the pieces, or of the inner coordinates; ``size`` is the
        robot's characteristic length [m], by which rotations at these points are multiplied.
        """
        if self.pieces == 1:
            N, rows, columns = self.motions.shape
            motions = np.zeros((N, rows + self.rod.inner, columns + self.rod.inner))
            motions[:, :rows, :columns], motions[:, rows:, columns:] = self.motions, np.eye(self.rod.inner)
            yield [*self.columns, *range(first, first + self.rod.inner)], motions
            return
        own = np.diag([1.0] * 3 + [1 / size] * 3)[None]
        inner = [(range(first + 6 * k, first + 6 * k + 6), own) for k in range(self.pieces - 1)]
        nodes: list[tuple[Sequence[int], Array]] = [
            (self.columns, self.motions[:, :6]),
            *inner,
            (self.columns, self.motions[:, 6:]),
        ]
        for (before, start), (after, end) in pairwise(nodes):
            motions = np.zeros((max(len(start), len(end)), 12, len(before) + len(after)))
            motions[:, :6, : len(before)], motions[:, 6:, len(before) :] = start, end
            yield [*before, *after], motions


@dataclass(frozen=True)
class VibrationModel:
    """A robot at N poses, with n coordinates of rigid bodies and joints.

    Attributes:
        masses: rigid links by name, and the payload.
        springs: elastic joints, actuators and springs by name.
        beams: all beams by name.
        closure: (N, c, n) closure equations of loops of joints.
        platform: (N, 6, n) twist of the platform at o per coordinate, with rotations multiplied by ``size``.
        size: the robot's characteristic length [m].
        buckled: (N,) True where a beam buckles between fixed ends, which makes a pose unstable; None: nowhere.
    """

    masses: Mapping[str, Part]
    springs: Mapping[str, Part]
    beams: Mapping[str, PlacedRod]
    closure: Array
    platform: Array
    size: float
    buckled: Mask | None = None

    @property
    def poses(self) -> int:
        return len(self.closure)

    @property
    def coordinates(self) -> int:
        """Number of coordinates, including those of points between pieces of beams, and inner coordinates of links."""
        return self.closure.shape[2] + sum(item.more for item in self.beams.values())

    def take(self, poses: Index) -> VibrationModel:
        return VibrationModel(
            {name: item.take(poses) for name, item in self.masses.items()},
            {name: item.take(poses) for name, item in self.springs.items()},
            {name: item.take(poses) for name, item in self.beams.items()},
            self.closure[poses],
            self.platform[poses],
            self.size,
            None if self.buckled is None else self.buckled[poses],
        )

    def divided(self, square: float) -> VibrationModel | None:
        """Add a piece to each beam whose pieces with clamped ends may have λ ≤ ``square``; return None if no beam needs one."""
        lowest = {name: float(item.piece.clamped_square().min()) for name, item in self.beams.items()}
        low = {name for name, bound in lowest.items() if bound <= square and np.isfinite(bound)}
        if not low:
            return None
        beams = {name: replace(item, pieces=item.pieces + (name in low)) for name, item in self.beams.items()}
        return replace(self, beams=beams)

    @cached_property
    def _constant(self) -> tuple[Array, Array]:
        """Stiffness and mass (N, n, n) of all parts except beams."""
        n = self.closure.shape[2]
        found = np.zeros((2, self.poses, n, n))
        for matrix, parts in zip(found, (self.springs, self.masses), strict=True):
            for part in parts.values():
                matrix[np.ix_(range(self.poses), part.columns, part.columns)] += part.of_coordinates()
        return found[0], found[1]

    @cached_property
    def cancelling(self) -> Array:
        """Stiffness (N, n, n) to add to K for a measure of the terms that cancel in it: |K_i| − K_i, summed over the springs."""
        n = self.closure.shape[2]
        found = np.zeros((self.poses, n, n))
        for part in self.springs.values():
            if part.indefinite:
                values, axes = np.linalg.eigh(part.matrix)
                motions = np.swapaxes(axes, 1, 2) @ part.motions
                cancelled = np.swapaxes(motions, 1, 2) @ ((np.abs(values) - values)[..., None] * motions)
                found[np.ix_(range(self.poses), part.columns, part.columns)] += cancelled
        return found

    @cached_property
    def first_along(self) -> Mapping[str, int]:
        """By beam, the index of its first coordinate between its ends."""
        more = np.cumsum([0, *(item.more for item in self.beams.values())])
        return dict(zip(self.beams, (self.closure.shape[2] + more).tolist(), strict=False))

    def dynamic_stiffness(self, square: Numbers) -> Numbers:
        """Return D(λ) = K − λ M + Σ Tᵀ D_rod(λ) T (N, m, n, n) at λ (N, m) [1/s²] for all coordinates [N/m]."""
        K, M = self._constant
        rods = {name: item.piece.dynamic_stiffness(square) for name, item in self.beams.items()}
        return self._assembled(K[:, None] - square[..., None, None] * M[:, None], rods)

    def pencil(self, square: Array) -> tuple[Array, Array]:
        """Return K̃ and M̃ (N, m, …) at λ (N, m), see :meth:`VibratingLink.pencil`."""
        rods = {name: item.piece.pencil(square) for name, item in self.beams.items()}
        K, M = (
            self._assembled(np.repeat(constant[:, None], square.shape[1], axis=1), {name: item[k] for name, item in rods.items()})
            for k, constant in enumerate(self._constant)
        )
        return K, M

    @cached_property
    def static_pencil(self) -> tuple[Array, Array]:
        """K̃ and M̃ (N, n, n) at λ = 0: stiffness and mass."""
        K, M = self.pencil(np.zeros((self.poses, 1)))
        return K[:, 0], M[:, 0]

    def _assembled(self, constant: Numbers, rods: Mapping[str, Numbers]) -> Numbers:
        """Return the matrices (N, m, …) of all coordinates; ``rods`` is one piece per beam, ``constant`` all other parts."""
        n = constant.shape[-1]
        found = np.zeros((*constant.shape[:2], self.coordinates, self.coordinates), dtype=constant.dtype)
        found[..., :n, :n] = constant
        poses = [range(size) for size in constant.shape[:2]]
        for name, item in self.beams.items():
            for columns, motions in item.moved(self.first_along[name], self.size):
                found[np.ix_(*poses, columns, columns)] += np.swapaxes(motions, 1, 2)[:, None] @ rods[name] @ motions[:, None]
        return found

    def forces_of_floor(self, square: Numbers) -> Numbers:
        """Return the forces (N, m, n, 6) on all coordinates at λ (N, m) when the whole robot moves as one body with the floor.

        They are Σ Tᵀ (−λ M) R + Σ Tᵀ D_rod(λ) R, with the motions T per coordinate and R of the rigid robot.
        """
        return self._carried(-square, {name: item.piece.dynamic_stiffness(square) for name, item in self.beams.items()})

    @cached_property
    def floor_inertia(self) -> Array:
        """Forces (N, n, 6) against all coordinates per unit of a constant acceleration of the floor about o [kg, kg·m]."""
        zero = np.zeros((self.poses, 1))
        return self._carried(zero + 1, {name: item.piece.pencil(zero)[1] for name, item in self.beams.items()})[:, 0]

    def _carried(self, factor: Numbers, rods: Mapping[str, Numbers]) -> Numbers:
        """Return Σ Tᵀ f M R + Σ Tᵀ A R (N, m, n, 6) for factors f (N, m) and one matrix A per beam, of a piece."""
        forces = np.zeros((*factor.shape, self.coordinates, 6), dtype=factor.dtype)
        for part in self.masses.values():
            own = np.swapaxes(part.motions, 1, 2) @ part.matrix @ part.carried
            forces[:, :, list(part.columns)] += factor[..., None, None] * own[:, None]
        for name, rod in self.beams.items():
            for number, (columns, motions) in enumerate(rod.moved(self.first_along[name], self.size)):
                forces[:, :, columns] += np.swapaxes(motions, 1, 2)[:, None] @ rods[name] @ rod.carried_piece(number)[:, None]
        return forces

    def closed_motions(self) -> list[tuple[Index, Array | None]]:
        """Return groups of P poses, each with a basis (P, n, r) of the motions that keep all loops closed (None: all motions)."""
        if not self.closure.shape[1]:
            return [(np.arange(self.poses), None)]
        _, values, axes = np.linalg.svd(self.closure)
        ranks = np.sum(values > _DEPENDENT * values.max(axis=1, keepdims=True), axis=1)
        found: list[tuple[Index, Array | None]] = []
        n = self.closure.shape[2]
        for rank in np.unique(ranks):
            poses = np.flatnonzero(ranks == rank)
            basis = np.zeros((len(poses), self.coordinates, self.coordinates - rank))
            basis[:, :n, : n - rank] = np.swapaxes(axes[poses, rank:], 1, 2)
            basis[:, n:, n - rank :] = np.eye(self.coordinates - n)
            found.append((poses, basis))
        return found


def vibration_model(motions: PlacedMotions) -> VibrationModel:
    structure, size = motions.structure, motions.structure.model.length
    ends: dict[str, list[BeamEnds]] = {}
    for item in structure.elastic_links:
        ends.setdefault(structure.model.topology.spans[item.name].part.name, []).append(item)
    beams = {name: _rod(motions, links) for name, links in ends.items()}
    springs = dict(_springs(motions))
    for name, slides in _free_slides(structure):
        beams[name], springs[f"beam {name}"] = _stretching(beams[name], slides)
    platform = _poses_first(motions.moved(structure.platform, motions.o))
    platform[:, 3:] *= size
    return VibrationModel(dict(_masses(motions)), springs, beams, _poses_first(motions.closure()), platform, size)


def _stretching(item: PlacedRod, slides: Sequence[int]) -> tuple[PlacedRod, Part]:
    """Return a telescopic beam that stretches along the coordinates ``slides``, and what this changes in its stiffness.

    Slides that lengthen a beam by s distribute s evenly along it. The displacement u of a section then obeys the equation
    EA u″ + λ μ u = 0 of a rod without slides. The strain energy is that of a rod without slides plus EA (s²/2 − s e)/L, where e
    is the change of the distance between the beam's ends.
    """
    where = [item.columns.index(column) for column in slides]
    motions, changes = np.array(item.motions), np.zeros((len(item.motions), 2, len(item.columns)))
    changes[:, 1, where] = motions[:, 6, where] - motions[:, 0, where]  # −s
    motions[:, :, where] = 0.0
    changes[:, 0] = motions[:, 6] - motions[:, 0]
    stiffness = np.array([[0.0, 1.0], [1.0, 1.0]]) * item.rod.axial_stiffness()[..., None]
    nothing = np.zeros((len(motions), 2, 6))
    return replace(item, motions=motions), Part(item.columns, changes, stiffness, nothing, indefinite=True)


def mass_at(motions: PlacedMotions, body: RigidBody, centre: Array, mass: Array | float, axes: Array, inertia: Array) -> Part:
    """Return the part of a mass [kg] fixed to a body, with its centre (3, N) and its inertia (3, 3) or (3, 3, N) in ``axes``."""
    columns, R = motions.structure.columns[body], axes.transpose(2, 0, 1)
    matrix = np.zeros((len(R), 6, 6))
    matrix[:, :3, :3] = np.eye(3) * np.reshape(mass, (-1, 1, 1))
    matrix[:, 3:, 3:] = R @ np.moveaxis(inertia, (0, 1), (-2, -1)) @ np.swapaxes(R, 1, 2)
    return Part(columns, _poses_first(motions.moved(body, centre, columns)), matrix, _poses_first(motions.carried(centre)))


def spring_part(columns: tuple[int, ...], motions: Array, matrix: Array) -> Part:
    """Return a part with the stiffness ``matrix`` (r, r, N) of displacements ``motions`` (r, k, N) per unit of a coordinate."""
    nothing = np.zeros((matrix.shape[2], len(matrix), 6))
    return Part(columns, motions.transpose(2, 0, 1), matrix.transpose(2, 0, 1), nothing, indefinite=True)


def _poses_first(array: Array) -> Array:
    return np.ascontiguousarray(array.transpose(2, 0, 1))


def _masses(motions: PlacedMotions) -> Iterator[tuple[str, Part]]:
    weights, frames = motions.structure.model.weights, motions.frames
    for body, number in motions.structure.weights:
        if motions.structure.columns[body]:
            name = weights.names[number]
            at, inertia = motions.structure.model.mechanism.body_of[name][0], weights.inertias[name]
            centre, axes = frames.point(at, inertia.lever), frames.rotation[:, :, at]
            yield name, mass_at(motions, body, centre, inertia.mass, axes, inertia.inertia)


def _springs(motions: PlacedMotions) -> Iterator[tuple[str, Part]]:
    structure, N = motions.structure, motions.o.shape[1]
    for joint in structure.joints:
        stiffness = structure.stiffness_of(joint)
        if np.any(stiffness):
            scale = [structure.model.length if k in structure.rotations else 1.0 for k in joint.columns]
            moved = np.broadcast_to(np.diag(1 / np.array(scale)), (N, len(scale), len(scale)))
            matrix = np.broadcast_to(stiffness, moved.shape)
            yield joint.connection.name, Part(joint.columns, moved, matrix, np.zeros((N, len(scale), 6)))
    for spring in placed_springs(structure.model, motions.frames):
        columns, stretch = motions.stretched(spring)
        yield f"spring {spring.name}", spring_part(columns, stretch, spring.tangent)


def _free_slides(structure: SmallMotions) -> Iterator[tuple[str, list[int]]]:
    """Yield the telescopic beams with free actuators in their span, and the coordinates of these actuators."""
    free = {k for k, item in enumerate(structure.freedoms) if item and not item.rotates and not item.stiffness}
    for name, span in structure.model.topology.spans.items():
        at = [joint for joint in structure.joints if joint.connection.actuated and joint.connection.name in span.spanned]
        if slides := [column for joint in at for column in joint.columns if column in free]:
            yield name, slides


def _rod(motions: PlacedMotions, ends: Sequence[BeamEnds]) -> PlacedRod:
    """Return a beam, or an elastic link by its spans from one interface to the others."""
    structure, frames = motions.structure, motions.frames
    links = [structure.model.elastic_links[item.name] for item in ends]
    link, bodies = links[0], [ends[0].inner, *(item.outer for item in ends)]
    points, columns = [link.ends(frames)[0], *(item.ends(frames)[1] for item in links)], structure.columns_of(*bodies)
    axes, size = link.world_axes(frames).transpose(2, 1, 0), 6 * len(bodies)
    turned = np.zeros((len(axes), size, size))
    for k in range(0, size, 3):
        turned[:, k : k + 3, k : k + 3] = axes
    moved = [motions.moved(body, point, columns) for body, point in zip(bodies, points, strict=True)]
    carried = turned @ _poses_first(np.concatenate([motions.carried(point) for point in points]))
    vibrating = link.vibrating(frames)
    carried = np.pad(carried, ((0, 0), (0, vibrating.inner), (0, 0)))
    return PlacedRod(columns, turned @ _poses_first(np.concatenate(moved)), carried, vibrating)
