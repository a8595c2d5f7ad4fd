"""Buckling of members (beams, or collinear beams that buckle as one), and results with the stiffness due to the forces."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from kinetostatics.buckling.members import BucklingModes
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.layout.mapping import ResultMapping, ShortRepr
from kinetostatics.layout.report import Reported
from kinetostatics.math.arrays import Array, Mask, frozen
from kinetostatics.results.mode_arrays import Shapes
from kinetostatics.results.pose_arrays import Batch
from kinetostatics.robot import Robot, robot_of
from kinetostatics.statics.solution import Solution
from kinetostatics.statics.springs import inverse


@dataclass(frozen=True, eq=False, repr=False)
class Buckling(Shapes[BucklingModes], Reported):
    """Load factors and buckling modes of a loaded robot; see :meth:`kinetostatics.Result.buckling`.

    Arrays are read-only: batch axes first, then the mode. They are NaN where a pose has no results. All forces and moments of
    linear theory are examined, at the unloaded geometry. If there are fewer than ``count`` modes, the remaining load factors are
    infinite, and the remaining shapes NaN. The amplitude of a mode is arbitrary; the largest
    component of the platform's twist is positive. Any combination of modes with equal load factors is a mode, too.

    Attributes:
        configuration: the pose or poses, broadcast against the loads.
        count: number of modes of each pose.
        chunks: the modes of the poses with results, in the order of the poses.
        valid: (N,) True at poses with results.

    Examples:
        >>> import kinetostatics as ks
        >>> pose = ks.load_robot("3rps").assemble(platform={"z": 0.5, "rx": 0.0, "ry": 0.0})
        >>> found = ks.analyze(pose, load=[0, 0, -1e5, 0, 0, 0]).buckling(count=2)
        >>> [round(float(factor), 1) for factor in found.load_factors]
        [143.8, 143.8]
    """

    configuration: Configuration
    count: int
    chunks: tuple[BucklingModes, ...]
    valid: Mask

    @cached_property
    def load_factors(self) -> Array:
        """(…, count) load factors λ, ascending: under λ times all forces the robot buckles. Infinite if there are fewer modes.

        If a factor is below 1, the robot buckles under its loads.
        """

        def factors(chunk: BucklingModes) -> Array:
            with np.errstate(divide="ignore"):
                return np.where(np.isnan(chunk.ratios), np.nan, 1 / np.maximum(chunk.ratios, 0.0))

        return self._array((self.count,), factors)

    @cached_property
    def energy_shares(self) -> Mapping[str, Array]:
        """(…, count) share of each member in the strain energy of all beams, by names of its beams: "rod_1", "rod_2+tube_2"."""

        def shares(chunk: BucklingModes, member: tuple[str, ...]) -> Array:
            energies = chunk.energies()
            total = sum(energies.values(), np.zeros(()))
            return np.asarray(sum(energies[name] for name in member) / np.where(total > 0, total, np.nan))

        return ResultMapping(
            {
                "+".join(member): self._array((self.count,), lambda chunk, member=member: shares(chunk, member))  # type: ignore[misc]
                for member in self.robot.members.names
            }
        )

    @cached_property
    def members(self) -> NDArray[np.str_]:
        """(…, count) name of the member with the largest share of the strain energy; "" where there are fewer modes."""
        names = np.array(["", *self.energy_shares])
        shares = [self._array((self.count,), lambda chunk: np.zeros(chunk.ratios.shape)), *self.energy_shares.values()]
        return np.asarray(names[np.argmax(np.round(np.nan_to_num(shares), 9), axis=0)])


def buckling_of(configuration: Configuration, solutions: Iterable[Solution], valid: Mask, count: int) -> Buckling:
    """Return the ``count`` lowest buckling modes at those of the N poses of ``solutions`` where ``valid`` (N,) is True."""
    members, chunks, first = robot_of(configuration).members, list[BucklingModes](), 0
    for solution in solutions:
        last = first + solution.o.shape[1]
        chunks += members.modes(solution, np.flatnonzero(valid[first:last]), count)
        first = last
    return Buckling(configuration, count, tuple(chunks), valid)


@dataclass(frozen=True, eq=False, repr=False)
class SecondOrder(ShortRepr):
    """Twist, compliance and stiffness to second order in the forces, including the displacement of the robot.

    The geometric stiffness of all forces and moments of the linear analysis is part of the tangent stiffness; the change of the
    stiffness by the displaced geometry is of first order. A load moment keeps its direction; of its tangent the symmetric part is
    taken. Arrays are NaN where the robot buckles or has no results.

    Attributes:
        twist: (…, 6) [m, rad].
        compliance: (…, 6, 6) [m/N, rad/(N·m)].
        stiffness: (…, 6, 6) [N/m, N·m/rad]; NaN where limbs are rigid.
        change: (…) relative change of that principal stiffness of the platform that changes most.

    Examples:
        >>> import kinetostatics as ks
        >>> pose = ks.load_robot("3rps").assemble(platform={"z": 0.5, "rx": 0.0, "ry": 0.0})
        >>> result = ks.analyze(pose, load=[100, 0, -1e5, 0, 0, 0])
        >>> [round(1e6 * float(twist[0]), 2) for twist in (result.twist, result.second_order.twist)]  # along x [µm]
        [3.06, 3.08]
    """

    twist: Array
    compliance: Array
    stiffness: Array
    change: Array


def second_order_of(
    robot: Robot, batch: Batch, solutions: Iterable[Solution], unloaded: Array, moved: Callable[..., Array]
) -> SecondOrder:
    """Return results of second order at the reference point.

    Args:
        robot, batch, solutions: robot, poses and their equilibria.
        unloaded: stiffness of the linear analysis at the reference point.
        moved: ``moved(twist)`` and ``moved(compliance, "compliance")`` transform from o to the reference point.
    """
    found = list(map(robot.members.second_order, solutions))
    twist, compliance = moved(batch.public([item.twist for item in found])), batch.public([item.compliance for item in found])
    compliance, changes = moved(compliance, "compliance"), batch.public([item.stiffness for item in found])
    loaded, rigid = (np.moveaxis(matrix.reshape(-1, 6, 6), 0, 2) for matrix in (compliance, unloaded))
    stiffness = np.moveaxis(inverse(loaded, rigid, robot.length), 2, 0).reshape(compliance.shape)
    change = np.zeros(changes.shape[:-1])
    if changes.size:
        largest = np.argmax(np.nan_to_num(np.abs(changes)), axis=-1)[..., None]
        change = np.take_along_axis(changes, largest, axis=-1)[..., 0]
    return SecondOrder(frozen(twist), frozen(compliance), frozen(stiffness), frozen(change))
