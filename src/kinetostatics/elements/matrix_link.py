"""Links by their matrices, ``<flexible>``.

The *ends* are the centres of the joints at the interfaces, and rigid with them. The link's axes are those of its frame. The
coordinates of :mod:`kinetostatics.description.link_matrices` are replaced by the twists of the ends, in these axes, and the
internal coordinates.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import NDArray

from kinetostatics.description.flexible import Flexible
from kinetostatics.elements.element import ElasticElement, carried_wrench, outboard_masks
from kinetostatics.elements.link import ElasticLink, ElasticLinks, LinkSurface, UnderOwnWeight
from kinetostatics.elements.rods import VibratingMatrices
from kinetostatics.layout.mapping import ShortRepr
from kinetostatics.math.arrays import Array
from kinetostatics.math.linalg import cross
from kinetostatics.math.screws import move_twist, move_wrench, rotate
from kinetostatics.mechanism.beam_geometry import Span
from kinetostatics.mechanism.limbs import Edge
from kinetostatics.mechanism.mechanism import Mechanism
from kinetostatics.mechanism.tree import FixedVectors, Frames

if TYPE_CHECKING:
    import pinocchio as pin


@dataclass(frozen=True, repr=False, eq=False)
class MatrixLink(ShortRepr, ElasticLink):
    """A link by its matrices, independent of the pose.

    Attributes:
        mass: mass [kg], with the centre ``centre``.
        inertia: (3, 3) inertia about the centre [kg·m²], in the carrier body.
        flexibility, sag: F (6p, 6p) and S (6p, 3) of its p outer ends, see :mod:`kinetostatics.elements.link`.
        expansion: (6,) twist of the end due to 1 K [m/K, rad/K].
        inertial: (6p + 6, 6) loads at the ends per unit of an acceleration [a; α] of the centre of mass.
        port: which of the outer ends is the end of ``span``.
        vibration: the link in vibrations.
    """

    NOT_RECORDED: ClassVar = ("inertia", "expansion", "inertial", "vibration", "surface")

    name: str
    span: Span
    axes: Array
    centre: Array
    mass: float
    inertia: Array
    flexibility: Array
    sag: Array
    expansion: Array
    inertial: Array
    port: int
    vibration: VibratingMatrices
    surface: LinkSurface | None

    def turning_compliance(self, frames: Frames) -> Array:
        displaced, turned = np.diag(self.flexibility).reshape(-1, 2, 3).sum(axis=2)[self.port]
        return np.asarray(turned + displaced / self.length(frames) ** 2)

    def mass_at(self, frames: Frames) -> Array:
        return np.full_like(frames.position[0, 0], self.mass)

    def inertia_at(self, frames: Frames) -> tuple[int, pin.Inertia]:
        import pinocchio as pin

        return self.span.carrier, pin.Inertia(self.mass, self.centre, self.inertia)

    def misfit(self, frames: Frames, kind: str) -> Array:
        return rotate(self.world_axes(frames), np.repeat(self.expansion[:, None], frames.position.shape[2], axis=1))

    def inertial_load(
        self,
        frames: Frames,
        acceleration: Callable[[int, Array], Array],
        couple: Callable[[int, Array, Array], Array],
    ) -> tuple[None, list[Array]]:
        """Return None, and the loads at the ends due to the acceleration as a rigid body: ``inertial`` [a; α].

        What depends on the angular velocity acts as on a body that rides on the mean motion of the ends.
        """
        body, axes = self.span.carrier, self.world_axes(frames)
        centre = frames.point(body, self.centre)
        a = acceleration(body, centre)
        units = np.broadcast_to(np.eye(3)[:, :, None], (3, 3, centre.shape[1]))
        alpha = sum(cross(units[k], acceleration(body, centre + units[k]) - a) for k in range(3)) / 2
        moment = couple(body, frames.rotation[:, :, body], self.inertia)
        J = np.einsum("ijn,jk,lkn->iln", frames.rotation[:, :, body], self.inertia, frames.rotation[:, :, body])
        rate_moment = (moment + np.einsum("ijn,jn->in", J, alpha)) / (len(self.inertial) // 6)
        local = rotate(axes, np.concatenate([a, alpha]), back=True)
        wrenches = [rotate(axes, wrench) for wrench in np.split(self.inertial @ local, len(self.inertial) // 6)]
        return None, [np.concatenate([wrench[:3], wrench[3:] + rate_moment]) for wrench in wrenches]

    def vibrating(self, frames: Frames) -> VibratingMatrices:
        return self.vibration

    def stacked(
        self, links: Sequence[ElasticLink], edges: Sequence[Edge], element: int = 0, signs: NDArray[np.int8] | None = None
    ) -> ElasticElement:
        flexibilities = [(link.flexibility, link.sag) for link in links if isinstance(link, MatrixLink)]
        return ElasticLinks(links, flexibilities, edges, element, signs)

    def coupled(
        self,
        links: Sequence[Sequence[ElasticLink]],
        edges: Sequence[Sequence[Edge]],
        elements: Sequence[int],
        signs: NDArray[np.int8],
    ) -> ElasticElement:
        return CoupledLinks([[link for link in ends if isinstance(link, MatrixLink)] for ends in links], edges, elements, signs)


def matrix_links(part: Flexible, mechanism: Mechanism, spans: Mapping[str, Span]) -> dict[str, MatrixLink]:
    """Return a link by its matrices in its robot, by the names of its ``spans`` from the inner interface to the others."""
    matrices, link, (_, placement) = part.matrices, mechanism.description.links[part.link], mechanism.body_of[part.link]
    R, origin, p = placement[:3, :3], placement[:3, 3], len(spans)
    at = [R.T @ (mechanism.interface_on(part.link, name) - origin) for name in matrices.names]
    ends = [R.T @ (point - origin) for point in (next(iter(spans.values())).start, *(span.end for span in spans.values()))]
    ports = [int(np.argmin([np.linalg.norm(point - end) for point in at])) for end in ends]
    coordinates = [6 * k + row for k in ports for row in range(6)]
    internal = range(6 * p + 6, len(matrices.stiffness))
    shapes = matrices.coordinates_of(np.array(at))[:, [*coordinates, *internal]]  # coordinates of the matrices per unit of these
    back = np.linalg.inv(shapes[np.ix_(coordinates, range(6 * p + 6))])[6:, 6:]
    outer = np.argsort(np.argsort(ports[1:]))  # of each end among the outer interfaces in the order of the matrices
    rows = [6 * int(k) + row for k in outer for row in range(6)]
    body = link.mass, np.array(link.center_of_mass), link.inertia.matrix
    weighed = matrices if matrices.mass is not None else replace(matrices, gravity=None).with_body(*body)
    gravity = matrices if matrices.gravity is not None else weighed
    (mass, centre), factor = gravity.weight, part.stiffness_factor
    M = np.zeros_like(matrices.stiffness) if weighed.mass is None else weighed.mass
    inertia = np.zeros((3, 3)) if weighed.body is None else weighed.body[2]
    F = back @ matrices.flexibility(ports[0])[np.ix_(rows, rows)] @ back.T / factor
    S = back @ gravity.displacements_by_gravity(ports[0])[rows] / factor
    expansion = (back @ matrices.displacements_by_heat(ports[0])[rows]).reshape(p, 6)
    vibration = VibratingMatrices(factor * shapes.T @ matrices.stiffness @ shapes, shapes.T @ M @ shapes, matrices.internal)
    moved_centre, J, size = R @ centre + origin, R @ inertia @ R.T, 6 * p + 6
    K = vibration.stiffness
    static = np.vstack([np.eye(size), -np.linalg.solve(K[size:, size:], K[size:, :size])])
    rigid = np.linalg.solve(shapes, matrices.motions_about(centre))
    inertial = -static.T @ vibration.mass @ rigid
    surface = None
    if matrices.points is not None and matrices.triangles is not None and matrices.recovery is not None:
        recovery = matrices.recovery @ shapes
        surface = LinkSurface(matrices.points, matrices.triangles, recovery, vibration, matrices.gravity_loads[size:])
    return {
        name: MatrixLink(name, span, R, moved_centre, mass, J, F, S, expansion[k], inertial, k, vibration, surface)
        for k, (name, span) in enumerate(spans.items())
    }


class CoupledLinks:
    """Corresponding links of g equal limbs with p ≥ 2 outer ends, see :class:`kinetostatics.elements.element.ElasticElement`."""

    kind = "links"
    in_every_direction, has_line, has_inside = True, False, False
    attachments: frozenset[str] = frozenset()

    def __init__(
        self,
        links: Sequence[Sequence[MatrixLink]],
        edges: Sequence[Sequence[Edge]],
        elements: Sequence[int],
        signs: NDArray[np.int8],
    ) -> None:
        """Set the links.

        Args:
            links, edges: for each limb, the link at each of its p outer ends, and the edges.
            elements: indices of the p elements in the limb.
            signs: (p, M) signs of the cut-joint wrenches at each end.
        """
        self.names, self.edges = tuple(ends[0].span.part.name for ends in links), list(zip(*edges, strict=True))
        self.elements, self.signs, first = tuple(elements), signs, [ends[0] for ends in links]
        orders = [[6 * link.port + row for link in ends for row in range(6)] for ends in links]
        pairs = list(zip(first, orders, strict=True))
        self.compliance = np.stack([link.flexibility[np.ix_(order, order)] for link, order in pairs], axis=-1)
        self.sag = np.stack([link.sag[order] for link, order in pairs], axis=-1)
        self.stiffness = np.stack([np.linalg.inv(F) for F in np.moveaxis(self.compliance, -1, 0)], axis=-1)
        self._axes = FixedVectors([[(link.span.carrier, link.axes)] for link in first], (3, 3))
        self._ends = FixedVectors([[(link.span.end_body, link.span.end) for link in ends] for ends in links])

    @property
    def signature(self) -> tuple[object, ...]:
        return self.kind, self.elements, tuple(map(tuple, self.signs.tolist()))

    def outboard(self, names: Sequence[str]) -> list[Array]:
        return [outboard_masks(edges, names) for edges in self.edges]

    def placed(self, frames: Frames, o: Array, twists: Array) -> PlacedCoupledLinks:
        return PlacedCoupledLinks(self, self._axes.at(frames)[:, :, 0], self._ends.points(frames) - o[:, None, None])


@dataclass(frozen=True, eq=False)
class PlacedCoupledLinks(UnderOwnWeight):
    """Corresponding links at N poses.

    Attributes:
        axes: (3, 3, g, N) their axes, world axes.
        arms: (3, p, g, N) their outer ends from o [m].
    """

    links: CoupledLinks
    axes: Array
    arms: Array

    def carried(self, cut_wrenches: Array) -> Array:
        return np.concatenate([carried_wrench(signs, cut_wrenches) for signs in self.links.signs])

    def carried_loads(self, outboard: Sequence[Array], wrenches: Array) -> Array:
        return np.concatenate([np.einsum("gw,iwn->ign", masks, wrenches) for masks in outboard])

    def forces(self, carried: Array) -> Array:
        ends = np.split(carried, self.arms.shape[1])
        local = [rotate(self.axes, move_wrench(end, self.arms[:, k]), back=True) for k, end in enumerate(ends)]
        return np.concatenate(local)

    def displacements(self, forces: Array) -> Array:
        return np.einsum("ijg,j...gn->i...gn", self.links.compliance, forces)

    def motions(self, displacements: Array) -> Iterator[tuple[int, Array]]:
        for k, (element, end) in enumerate(zip(self.links.elements, np.split(displacements, self.arms.shape[1]), strict=True)):
            yield element, move_twist(rotate(self.axes, end), -self.arms[:, k])

    def compliance_sum(self, length: float) -> Array:
        unit = np.tile([1.0] * 3 + [length] * 3, self.arms.shape[1])
        total = np.einsum("k,kkg,k->g", unit, self.links.compliance, unit)
        return np.broadcast_to(total[:, None], self.arms.shape[2:])
