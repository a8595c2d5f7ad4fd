"""Natural frequencies, modes of vibration, and frequency response of the platform."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinetostatics.arguments import finite_numbers, need, path_name
from kinetostatics.description.loads import Payload
from kinetostatics.exceptions import ArgumentError
from kinetostatics.files.writer import cells, write_table
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.layout.mapping import ResultMapping
from kinetostatics.layout.report import Reported, Tabulated
from kinetostatics.math.arrays import Array, Mask
from kinetostatics.math.screws import COMPONENTS, TWIST_UNITS, WRENCH_COMPONENTS, WRENCH_UNITS
from kinetostatics.results.mode_arrays import AtPoses, Shapes
from kinetostatics.results.state_space import PLATFORM, StateSpace, names_of, state_space
from kinetostatics.status import Status
from kinetostatics.vibration.eigenpairs import modes_below
from kinetostatics.vibration.motions import ModeShapes


class _Stable:
    """Poses of which some may be unstable; ``valid`` (N,) is True at reached poses with positive lengths of all beams."""

    configuration: Configuration
    valid: Mask

    @property
    def _numbers(self) -> Array:
        """Any numbers (…, n), NaN where a motion has negative stiffness."""
        raise NotImplementedError

    @property
    def _unstable(self) -> Mask:
        return np.isnan(self._numbers[..., 0].real) & self.valid.reshape(self.configuration.shape)

    @cached_property
    def status(self) -> NDArray[np.int8]:
        """:class:`Status` of every pose (…); SINGULAR if a telescopic beam has no length or a motion has negative stiffness."""
        status, singular = self.configuration.status, np.isnan(self._numbers[..., 0].real)
        status = np.where(singular & (status != Status.UNREACHABLE), Status.SINGULAR, status).astype(np.int8)
        status.setflags(write=False)
        return status

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """A warning about unstable poses, at which a motion has negative stiffness; else empty."""
        where = self._unstable
        poses = f"{int(where.sum())} of {where.size} poses are" if where.shape else "the pose is"
        text = f"{poses} unstable: springs and weights overcome the stiffness of a motion, and no number applies"
        return (text,) if np.any(where) else ()


@dataclass(frozen=True, eq=False, repr=False)
class Modes(_Stable, Shapes[ModeShapes], Tabulated):
    """The lowest natural frequencies and modes of one pose or a batch of poses; see :func:`kinetostatics.modes`.

    Arrays are read-only, batch axes first, then the mode; NaN where a pose has no results. Every mode has a modal mass of 1 kg,
    and the largest component of the platform's twist is positive.

    Attributes:
        configuration: the pose or poses.
        count: number of modes per pose.
        drives: whether the actuators are "locked" or "free".
        payload: the payload, or None.
        chunks: the modes of the poses with results, in the order of the poses.
        valid: (N,) True at poses with results.
    """

    configuration: Configuration
    count: int
    drives: str
    payload: Payload | None
    chunks: tuple[ModeShapes, ...]
    valid: Mask

    @property
    def _numbers(self) -> Array:
        return self.frequencies

    @cached_property
    def frequencies(self) -> Array:
        """(…, count) natural frequencies, ascending [Hz]; infinite where there are fewer modes, NaN at unstable poses."""
        return self._array((self.count,), lambda chunk: np.sqrt(chunk.pairs.square) / (2 * np.pi))

    @cached_property
    def zero_frequencies(self) -> Array:
        """(…) number of motions of frequency zero, such as the spin of a strut between ball joints; they are not modes."""
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

    def state_space(
        self,
        inputs: Sequence[str] = (PLATFORM,),
        outputs: Sequence[str] = (PLATFORM,),
        damping: float | Mapping[str, float] = 0.02,
    ) -> StateSpace:
        """Return the modes of one pose, actuators locked, as a state-space model from forces to displacements.

        The displacements have the static flexibility of :func:`kinetostatics.analyze`: modes that are left out follow without
        inertia. Velocities lack this part.

        Args:
            inputs: wrenches [N, N·m], world axes: "o" on the platform at o, or a rigid link's name, at the link's origin; an
                elastic actuator's name: a force [N or N·m] in addition to that of its stiffness; "acceleration of floor":
                translation, and rotation about o [m/s², rad/s²].
            outputs: twists [m, rad] of o and of links, displacements [m or rad] of actuators, relative to the floor;
                "velocity of o" for rates [m/s, rad/s].
            damping: damping ratio of all modes, or factors of proportional damping, see
                :func:`kinetostatics.frequency_response`.

        Raises:
            ArgumentError: an argument has an invalid value, this is a batch, or the actuators are free.

        Examples:
            >>> import kinetostatics as ks
            >>> pose = ks.load_robot("3rps").assemble(platform={"z": 0.5, "rx": 0.0, "ry": 0.0})
            >>> model = ks.modes(pose, 4).state_space()
            >>> model.A.shape, model.inputs[2], model.outputs[2]
            ((8, 8), 'fz of o [N]', 'z of o [m]')
        """
        if self.shape or not self.valid.all() or self.warnings or self.drives != "locked":
            raise ArgumentError("a state-space model needs one stable pose, with locked actuators")
        return state_space(self.frequencies, self.chunks[0], inputs, outputs, damping)

    # ---- participation and energy ------------------------------------------------------------------------------------

    @cached_property
    def participation_factors(self) -> Array:
        """(…, count, 6) participation factors ∫ φ · d dm [kg, kg·m] of the modes φ.

        d is the displacement in a unit translation along x, y or z, or in a unit rotation about one of these axes through o.
        """
        return self._array((self.count, 6), lambda chunk: chunk.participation)

    @cached_property
    def effective_masses(self) -> Array:
        """(…, count, 6) effective modal masses in the directions of the participation factors, relative to total mass or inertia.

        For each direction, the sum over all modes is the fraction of the mass that is not rigidly fixed to the base.
        """

        def shares(chunk: ModeShapes) -> Array:
            total = np.einsum("nii->ni", chunk.inertia)[:, None]
            return np.asarray(chunk.participation**2 / np.where(total > 0, total, np.nan))

        return self._array((self.count, 6), shares)

    @cached_property
    def strain_energy_shares(self) -> Mapping[str, Array]:
        """(…, count) share of each beam, elastic joint, actuator and spring in the strain energy.

        For robots with springs, "lever arms of forces" is the share, possibly negative, of weights, springs and joint forces by
        their lever arms.
        """
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


@dataclass(frozen=True, eq=False, repr=False)
class FrequencyResponse(_Stable, AtPoses, Reported):
    """Response of the platform at o, or at a tool, world axes; see :func:`kinetostatics.frequency_response`.

    Arrays are read-only, batch axes first; NaN where a pose has no results or is unstable. The time factor is exp(iωt).

    Attributes:
        configuration: the pose or poses.
        frequencies: (F,) frequencies [Hz].
        compliance: (…, F, 6, 6) complex twist per wrench on the platform [m/N, rad/(N·m)].
        transmissibility: (…, F, 6, 6) complex twist of the platform per twist of the floor about o.
        damping: damping ratio, or factors of proportional damping; see :func:`kinetostatics.frequency_response`.
        drives: whether the actuators are "locked" or "free".
        payload: the payload, or None.
        tool: (3,) reference point, from o in platform axes [m]; None: o.
        valid: (N,) True at reached poses with positive lengths of all telescopic beams.
    """

    configuration: Configuration
    frequencies: Array
    compliance: NDArray[Any]
    transmissibility: NDArray[Any]
    damping: float | Mapping[str, float]
    drives: str
    payload: Payload | None
    tool: Array | None
    valid: Mask

    @property
    def _numbers(self) -> Array:
        return self.compliance[..., 0, 0]

    def __post_init__(self) -> None:
        for array in (self.frequencies, self.compliance, self.transmissibility):
            array.setflags(write=False)

    @cached_property
    def stiffness(self) -> NDArray[Any]:
        """(…, F, 6, 6) complex dynamic stiffness at the point, the inverse of the compliance [N/m, N·m/rad]."""
        return np.linalg.inv(self.compliance)

    def to_control(self) -> Any:
        """Return the compliance of one pose as a ``control.FrequencyResponseData``.

        Raises:
            ArgumentError: this is a batch.
            KinetostaticsError: the package control is missing.
        """
        if self.shape:
            raise ArgumentError("python-control takes the frequency response of one pose; this is a batch")
        need("a model for python-control", "control", "control")
        import control  # type: ignore[import-untyped, unused-ignore]

        point = PLATFORM if self.tool is None else "tool"
        named = {"inputs": names_of(point, WRENCH_COMPONENTS, WRENCH_UNITS), "outputs": names_of(point, COMPONENTS, TWIST_UNITS)}
        return control.FrequencyResponseData(np.moveaxis(self.compliance, 0, 2), 2 * np.pi * self.frequencies, **named)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write magnitudes and phases of one pose as a table.

        Args:
            path: name ending in ``.csv``; an existing file is replaced.

        Raises:
            ArgumentError: the name has another ending, or this is a batch.
        """
        name = path_name("path", path)
        if not name.endswith(".csv") or self.shape:
            raise ArgumentError(f"{name} cannot be written: the frequency response of one pose goes into a .csv file")
        columns = {"frequency [Hz]": self.frequencies}
        for what, array, per in (("compliance", self.compliance, True), ("transmissibility", self.transmissibility, False)):
            for i, row in enumerate(COMPONENTS):
                for j, column in enumerate(WRENCH_COMPONENTS if per else COMPONENTS):
                    unit = f"{TWIST_UNITS[i]}/({WRENCH_UNITS[j]})" if per else f"{TWIST_UNITS[i]}/{TWIST_UNITS[j]}"
                    columns[f"|{what} {row} {column}| [{unit}]"] = np.abs(array[:, i, j])
                    columns[f"phase of {what} {row} {column} [rad]"] = np.angle(array[:, i, j])
        write_table(name, {title: cells(column) for title, column in columns.items()})
