"""Natural frequencies and modes: shapes, participation by direction, shares of energy by part."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinetostatics.arguments import finite_numbers
from kinetostatics.description.loads import Payload
from kinetostatics.exceptions import ArgumentError
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.layout.mapping import ResultMapping
from kinetostatics.layout.report import Reported
from kinetostatics.math.arrays import Array, Mask
from kinetostatics.results.shapes import Shapes
from kinetostatics.status import Status
from kinetostatics.vibration.eigenpairs import modes_below
from kinetostatics.vibration.motions import ModeShapes


@dataclass(frozen=True, eq=False, repr=False)
class Modes(Shapes[ModeShapes], Reported, builder="reports.modes:modes_report"):
    """The lowest natural frequencies and modes of one pose or a batch of poses; see :func:`kinetostatics.modes`.

    Arrays are read-only, batch axes first, then the mode; NaN where a pose has no numbers. Every mode has a modal mass of 1 kg,
    and the largest component of its platform's twist is positive.

    Attributes:
        configuration: the pose or poses.
        count: number of modes per pose.
        drives: whether the actuators are "locked" or "free".
        payload: the payload, or None.
        chunks: the modes of the poses with results, in their order.
        valid: (N,) mask of poses with results.
    """

    configuration: Configuration
    count: int
    drives: str
    payload: Payload | None
    chunks: tuple[ModeShapes, ...]
    valid: Mask

    @property
    def shape(self) -> tuple[int, ...]:
        """Batch shape of all results."""
        return self.configuration.shape

    @cached_property
    def status(self) -> NDArray[np.int8]:
        """:class:`Status` of every pose (…); SINGULAR where a telescope has no length or a motion has negative stiffness."""
        status, valid = self.configuration.status, ~np.isnan(self.frequencies[..., 0])
        status = np.where(valid | (status == Status.UNREACHABLE), status, Status.SINGULAR).astype(np.int8)
        status.setflags(write=False)
        return status

    @cached_property
    def frequencies(self) -> Array:
        """(…, count) natural frequencies, ascending [Hz]; infinite where there are fewer modes."""
        return self._array((self.count,), lambda chunk: np.sqrt(chunk.pairs.square) / (2 * np.pi))

    @cached_property
    def zero_frequencies(self) -> Array:
        """(…) number of free motions, such as the spin of a strut between ball joints; they are not among the modes."""
        return self._array((), lambda chunk: chunk.pairs.free)

    def count_below(self, frequency: ArrayLike) -> Array:
        """Return the number (…) of natural frequencies above zero and below ``frequency``.

        They are counted by the signs of the eigenvalues of the dynamic stiffness (W. H. Wittrick and F. W. Williams, 1971).

        Args:
            frequency: (…) frequency, broadcast against the poses [Hz].

        Raises:
            ArgumentError: a frequency is not positive.
        """
        given = finite_numbers("frequency", frequency)
        if np.any(given <= 0):
            raise ArgumentError(f"frequency is {frequency!r}; it must be positive [Hz]")
        square = (2 * np.pi * np.broadcast_to(given, self.shape).reshape(-1, 1)[self.valid]) ** 2
        parts = iter(np.split(square, np.cumsum([len(chunk.pairs.square) for chunk in self.chunks])))
        return self._array((), lambda chunk: modes_below(chunk.pairs.model, next(parts))[:, 0] - chunk.pairs.free)

    # ---- participation and energy ------------------------------------------------------------------------------------

    @cached_property
    def participation_factors(self) -> Array:
        """(…, count, 6) participation factors ∫ φ · d dm of translations along x, y, z [kg] and rotations about o [kg·m]."""
        return self._array((self.count, 6), lambda chunk: chunk.participation)

    @cached_property
    def effective_masses(self) -> Array:
        """(…, count, 6) effective modal masses, relative to the total mass or inertia, by direction as the participation factors.

        Over all modes, those of one direction sum to the fraction of the mass that is not rigidly fixed to the base, at most 1.
        """

        def shares(chunk: ModeShapes) -> Array:
            total = np.einsum("nii->ni", chunk.inertia)[:, None]
            return np.asarray(chunk.participation**2 / np.where(total > 0, total, np.nan))

        return self._array((self.count, 6), shares)

    @cached_property
    def strain_energy_shares(self) -> Mapping[str, Array]:
        """(…, count) share of each beam, elastic joint, actuator and spring in the strain energy."""
        return self._by_part(lambda chunk: chunk.strain_energy)

    @cached_property
    def kinetic_energy_shares(self) -> Mapping[str, Array]:
        """(…, count) share of each beam, each rigid link and the payload in the kinetic energy."""
        return self._by_part(lambda chunk: chunk.kinetic_energy)

    def _by_part(self, of: Callable[[ModeShapes], Mapping[str, Array]]) -> Mapping[str, Array]:
        names = of(self.chunks[0]) if self.chunks else {}
        return ResultMapping(
            {name: self._array((self.count,), lambda chunk, name=name: of(chunk)[name]) for name in names}  # type: ignore[misc]
        )
