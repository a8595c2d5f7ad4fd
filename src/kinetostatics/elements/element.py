"""Elastic elements: the questions that the statics of limbs asks of beams, elastic joints and actuators.

An element transmits a generalized force w (r, …), along its own axes, and deforms by the conjugate displacement
u = F w + u_0, with its compliance F and its displacement u_0 under its own weight. *Outboard* of an element are the bodies that
it carries, on the side of the platform. Corresponding elements of g equal limbs are one object; arrays are
``(component, …, limb, pose)``.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from kinetostatics.elements.loaded_beams import LoadedBeams
from kinetostatics.math.arrays import Array
from kinetostatics.math.screws import move_twist, move_wrench, rotate
from kinetostatics.mechanism.limbs import Edge, carries
from kinetostatics.mechanism.tree import Frames

#: Signs of the cut-joint wrenches in elements of open branches, which carry none.
NO_CUTS: NDArray[np.int8] = np.zeros(0, dtype=np.int8)


class PlacedElement(Protocol):
    """Corresponding elements of g limbs at N poses."""

    @property
    def line(self) -> tuple[Array, Array] | None:
        """Direction and point (3, g, N) from o of the straight line between the ends; None for elements without length."""

    def carried(self, cut_wrenches: Array) -> Array:
        """Return what cut-joint wrenches (M, 6, …, g, N) exert on the elements (c, …, g, N): wrenches about o, or forces."""

    def carried_loads(self, outboard: Sequence[Array], wrenches: Array) -> Array:
        """Return what loads (6, W, N) about o exert (c, g, N); ``outboard`` are the masks of :meth:`ElasticElement.outboard`."""

    def own_load(self, gravity: Array) -> Array | None:
        """Return what the own weight depends on (c, g, N) under ``gravity`` (3, N) [m/s²]; None for elements without weight.

        It is linear in gravity: the weight per length (6, g, N) [N/m, N] of beams, gravity along the axes of other elements.
        """

    def forces(self, carried: Array) -> Array:
        """Return the generalized forces w (r, …, g, N) of :meth:`carried`."""

    def displacements(self, forces: Array) -> Array:
        """Return F w (r, …, g, N)."""

    def own_displacement(self, load: Array) -> Array:
        """Return u_0 (r, …, g, N) under :meth:`own_load` (c, …, g, N)."""

    def motions(self, displacements: Array) -> Iterator[tuple[int, Array]]:
        """Yield the motions that displacements (r, S, g, N) cause.

        Each consists of the index of an element of the limb, and of the twist (6, S, g, N) about o of all bodies outboard of it.
        """

    def travels(self, displacements: Array) -> Mapping[str, Array]:
        """Return the deformations (S, N) of elastic actuators along their coordinates, by joint [m, rad]."""

    def compliance_sum(self, length: float) -> Array:
        """Return the sum Σ e_kᵀ F e_k (g, N) [m/N] along forces e_k of 1 N and moments of 1 N times a ``length`` [m]."""

    def strain_energy(self, forces: Array, displacements: Array) -> Array:
        """Return the strain energies ½ wᵀ u (g, N) [J] of elements without inside under forces and displacements (r, g, N)."""

    def inside(self, carried: Array, load: Array) -> LoadedBeams:
        """Return the shapes of elements with an inside under :meth:`carried` and weights per length (6, S, g, N)."""


class ElasticElement(Protocol):
    """Corresponding elements of g limbs.

    Attributes:
        kind: their group in tables: ``beams``, ``links``, ``joints`` or ``actuators``.
        names: their names, in the order of the limbs.
        in_every_direction: whether every force and moment deforms them.
        has_line: whether they have a line, see :attr:`PlacedElement.line`.
        has_inside: whether they have section forces and deflections, see :meth:`PlacedElement.inside`.
        attachments: attachments outside the limb at which loads act on them.
        signature: key that corresponding elements share.
    """

    @property
    def kind(self) -> str: ...

    @property
    def names(self) -> tuple[str, ...]: ...

    @property
    def in_every_direction(self) -> bool: ...

    @property
    def has_line(self) -> bool: ...

    @property
    def has_inside(self) -> bool: ...

    @property
    def attachments(self) -> frozenset[str]: ...

    @property
    def signature(self) -> tuple[object, ...]: ...

    def outboard(self, names: Sequence[str]) -> list[Array]:
        """Return masks (…, W): 1 where the load at an attachment, by ``names``, is outboard."""

    def placed(self, frames: Frames, o: Array, twists: Array) -> PlacedElement:
        """Return the elements at poses, ``twists`` (6, k, g, N) being the unit twists of the limbs' freedoms about o (3, N)."""


class WithoutInside:
    """What placed elements without a line, own weight, coordinates of actuators and an inside have in common."""

    @property
    def line(self) -> tuple[Array, Array] | None:
        return None

    def own_load(self, gravity: Array) -> Array | None:
        return None

    def own_displacement(self, load: Array) -> Array:
        return np.zeros_like(load)

    def travels(self, displacements: Array) -> Mapping[str, Array]:
        return {}

    def strain_energy(self, forces: Array, displacements: Array) -> Array:
        return np.einsum("ign,ign->gn", forces, displacements) / 2

    def inside(self, carried: Array, load: Array) -> LoadedBeams:
        raise TypeError(f"{type(self).__name__} have no inside")


@dataclass(frozen=True, eq=False)
class PlacedSection(WithoutInside):
    """Corresponding elements that transmit all six components of a wrench, at N poses.

    Attributes:
        signs: (M,) signs of the cut-joint wrenches.
        element: index of the element in the limb.
        axes: (3, 3, g, N) axes of the element, world axes.
        arm: (3, g, N) reference point of its forces, from o [m].
    """

    signs: NDArray[np.int8]
    element: int
    axes: Array
    arm: Array

    def carried(self, cut_wrenches: Array) -> Array:
        return carried_wrench(self.signs, cut_wrenches)

    def carried_loads(self, outboard: Sequence[Array], wrenches: Array) -> Array:
        return np.einsum("gw,iwn->ign", outboard[0], wrenches)

    def forces(self, carried: Array) -> Array:
        """Return the wrench w = Rᵀ X (…), moved to the reference point and turned into the element's axes R."""
        return rotate(self.axes, move_wrench(carried, self.arm), back=True)

    def motions(self, displacements: Array) -> Iterator[tuple[int, Array]]:
        yield self.element, move_twist(rotate(self.axes, displacements), -self.arm)

    def compliance_sum(self, length: float) -> Array:
        unit = np.broadcast_to(np.diag([1.0] * 3 + [length] * 3)[:, :, None, None], (6, 6, *self.arm.shape[1:]))
        return np.einsum("ki...,ki...->...", unit, self.displacements(unit))

    def displacements(self, forces: Array) -> Array:
        raise NotImplementedError


def carried_wrench(signs: NDArray[np.int8], cut_wrenches: Array) -> Array:
    """Return the sum (6, …) of cut-joint wrenches (M, 6, …) with the ``signs`` (M,) of an edge: its wrench without weights."""
    if len(signs) == 1 and signs[0] == 1:
        return cut_wrenches[0]
    total = np.zeros(cut_wrenches.shape[1:])
    for number in np.flatnonzero(signs):
        total += signs[number] * cut_wrenches[number]
    return total


def outboard_masks(edges: Sequence[Edge], names: Sequence[str]) -> Array:
    """Return (edges, W) 1 where the attachment of a name is outboard of an edge, else 0."""
    table = [[carries(edge, name) for name in names] for edge in edges]
    return np.array(table, dtype=float).reshape(len(edges), len(names))
