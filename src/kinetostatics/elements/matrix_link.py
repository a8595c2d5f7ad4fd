"""Links by their matrices, ``<flexible>``.

The *ends* are the centres of the joints at the interfaces, and rigid with them. The link's axes are those of its frame. The
coordinates of :mod:`kinetostatics.description.link_matrices` are replaced by the twists of the ends, in these axes, and the
internal coordinates.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import NDArray

from kinetostatics.description.flexible import Flexible
from kinetostatics.elements.element import ElasticElement
from kinetostatics.elements.link import ElasticLink, ElasticLinks
from kinetostatics.elements.rods import Numbers
from kinetostatics.layout.mapping import ShortRepr
from kinetostatics.math.arrays import Array, Index
from kinetostatics.math.screws import rotate
from kinetostatics.mechanism.beam_geometry import BeamSpan
from kinetostatics.mechanism.limbs import Edge
from kinetostatics.mechanism.mechanism import Mechanism
from kinetostatics.mechanism.tree import Frames

if TYPE_CHECKING:
    import pinocchio as pin


@dataclass(frozen=True, repr=False, eq=False)
class MatrixLink(ShortRepr, ElasticLink):
    """A link by its matrices, independent of the pose.

    Attributes:
        mass: mass [kg], with the centre ``centre``.
        inertia: (3, 3) inertia about the centre [kg·m²], in the carrier body.
        flexibility, sag: F (6, 6) and S (6, 3), see :mod:`kinetostatics.elements.link`.
        expansion: (6,) twist of the end due to 1 K [m/K, rad/K].
        vibration: the link in vibrations.
    """

    NOT_RECORDED: ClassVar = ("inertia", "expansion", "vibration")

    name: str
    span: BeamSpan
    axes: Array
    centre: Array
    mass: float
    inertia: Array
    flexibility: Array
    sag: Array
    expansion: Array
    vibration: VibratingMatrices

    def mass_at(self, frames: Frames) -> Array:
        return np.full_like(frames.position[0, 0], self.mass)

    def inertia_at(self, frames: Frames) -> tuple[int, pin.Inertia]:
        import pinocchio as pin

        return self.span.carrier, pin.Inertia(self.mass, self.centre, self.inertia)

    def misfit(self, frames: Frames, kind: str) -> Array:
        return rotate(self.world_axes(frames), np.repeat(self.expansion[:, None], frames.position.shape[2], axis=1))

    def vibrating(self, frames: Frames) -> VibratingMatrices:
        return self.vibration

    def stacked(
        self, links: Sequence[ElasticLink], edges: Sequence[Edge], element: int = 0, signs: NDArray[np.int8] | None = None
    ) -> ElasticElement:
        flexibilities = [(link.flexibility, link.sag) for link in links if isinstance(link, MatrixLink)]
        return ElasticLinks(links, flexibilities, edges, element, signs)


@dataclass(frozen=True, eq=False)
class VibratingMatrices:
    """Stiffness and mass (12 + m, 12 + m) of a link in vibrations, whose internal coordinates remain coordinates."""

    stiffness: Array
    mass: Array

    @property
    def inner(self) -> int:
        return len(self.stiffness) - 12

    def take(self, poses: Index) -> VibratingMatrices:
        return self

    def piece(self, count: int) -> VibratingMatrices:
        return self

    def dynamic_stiffness(self, square: Numbers) -> Numbers:
        return self.stiffness - square[..., None, None] * self.mass

    def pencil(self, square: Array) -> tuple[Array, Array]:
        shape = (*square.shape, *self.stiffness.shape)
        return np.broadcast_to(self.stiffness, shape), np.broadcast_to(self.mass, shape)

    def clamped_square(self) -> Array:
        return np.full((1, 1), np.inf)

    def clamped_modes(self, square: Array) -> Index:
        return np.zeros(square.shape, dtype=np.intp)

    def axial_stiffness(self) -> Array:
        raise TypeError("links by matrices are not telescopic")

    def inside(self, ends: Array, forces: Array, square: Array, fraction: float) -> Array:
        raise TypeError("links by matrices have no inside")


def matrix_link(part: Flexible, mechanism: Mechanism, span: BeamSpan) -> MatrixLink:
    """Return a link by its matrices in its robot, with ``span`` from base to platform."""
    matrices, link, (_, placement) = part.matrices, mechanism.description.links[part.link], mechanism.body_of[part.link]
    R, origin = placement[:3, :3], placement[:3, 3]
    at = [R.T @ (mechanism.connections[name].centre_on(part.link) - origin) for name in matrices.names]
    start = R.T @ (span.start - origin)
    inner = int(np.argmin([np.linalg.norm(point - start) for point in at]))
    ports = [inner, *(k for k in range(matrices.interfaces) if k != inner)]
    size = len(matrices.stiffness)
    shapes = np.eye(size)  # coordinates of the matrices per unit of these
    shapes[: 6 * len(ports)] = 0.0
    for column, k in enumerate(ports):
        shapes[6 * k : 6 * k + 6, 6 * column : 6 * column + 6] = matrices.motions_about(at[k])[6 * k : 6 * k + 6]
    others = [k for k in range(6 * matrices.interfaces) if k // 6 != inner]
    back = np.linalg.inv(shapes[np.ix_(others, range(6, 6 * len(ports)))])
    body = link.mass, np.array(link.center_of_mass), link.inertia.matrix
    weighed = matrices if matrices.mass is not None else replace(matrices, gravity=None).with_body(*body)
    mass, centre = matrices.weight if matrices.gravity is not None else weighed.weight
    M = np.zeros((size, size)) if weighed.mass is None else weighed.mass
    inertia = np.zeros((3, 3)) if weighed.body is None else weighed.body[2]
    gravity = matrices if matrices.gravity is not None else weighed
    factor = part.stiffness_factor
    return MatrixLink(
        part.name,
        span,
        R,
        R @ centre + origin,
        mass,
        R @ inertia @ R.T,
        back @ matrices.flexibility(inner) @ back.T / factor,
        back @ gravity.displacements_by_gravity(inner) / factor,
        back @ matrices.displacements_by_heat(inner),
        VibratingMatrices(factor * shapes.T @ matrices.stiffness @ shapes, shapes.T @ M @ shapes),
    )
