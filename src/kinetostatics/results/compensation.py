"""Corrected actuator positions, feedforward forces and pose errors: displacement and rotation vector from the target pose."""

from __future__ import annotations

import io
import os
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinetostatics.arguments import need, path_name
from kinetostatics.exceptions import ArgumentError
from kinetostatics.files.writer import cells, write_table
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.layout.mapping import ResultMapping
from kinetostatics.layout.report import Reported
from kinetostatics.math.arrays import Array, batch_first, chunks, frozen
from kinetostatics.math.linalg import matmul, pivot_rows
from kinetostatics.math.rotations import exponential, logarithm
from kinetostatics.math.screws import COMPONENTS, TWIST_UNITS, move_twist
from kinetostatics.output_files import replacing
from kinetostatics.quantities import VARIABLES
from kinetostatics.results.result import Result
from kinetostatics.robot import robot_of
from kinetostatics.status import WITHOUT_NUMBERS, Status
from kinetostatics.units import PLATFORM_UNITS

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True, eq=False, repr=False)
class Compensation(Reported):
    """Feedforward forces and corrected actuator positions of one pose or a batch of poses; see :func:`kinetostatics.compensate`.

    Arrays are read-only, batch axes first; NaN where no correction was found.

    Attributes:
        target: target pose of the loaded platform, broadcast against the loads.
        controlled: the platform coordinates that are corrected, as many as the mobility.
        uncorrected: the analysis of the target pose, to which the uncorrected actuators bring the unloaded robot.
        result: the analysis at the corrected actuator positions.
        tool: (3,) the tool's tip, from o in platform axes [m], reference point of ``controlled`` and of pose errors; None: o.
    """

    target: Configuration
    controlled: tuple[str, ...]
    uncorrected: Result
    result: Result
    tool: Array | None = None

    def to_dataset(self, axes: Mapping[str, ArrayLike] | None = None) -> xr.Dataset:
        """Return all quantities as an ``xarray.Dataset`` with units.

        Args:
            axes: names and values of the batch axes; default: ``pose``, or ``pose_1``, ``pose_2``, ….

        Raises:
            KinetostaticsError: xarray is not installed.
            ArgumentError: the sizes of the axes differ from those of the batch.
        """
        need("a Dataset", "sweep", "xarray")
        import xarray as xr

        if axes is None:
            sizes = self.shape
            axes = {("pose" if len(sizes) == 1 else f"pose_{k + 1}"): np.arange(size) for k, size in enumerate(sizes)}
        if tuple(np.size(values) for values in axes.values()) != self.shape:
            raise ArgumentError(
                f"axes have the sizes {[np.size(v) for v in axes.values()]}; the batch has the shape {self.shape}"
            )
        grid, units = tuple(axes), _units(self)
        connections, names, platform = self.target.robot.mechanism.connections, list(self.actuators), list(self.target.platform)

        def stacked(values: Mapping[str, Array], dim: str, unit: str, long_name: str) -> tuple[object, ...]:
            return (*grid, dim), np.stack(list(values.values()), axis=-1), {"long_name": long_name, "unit_coordinate": unit}

        def twists(values: Array, long_name: str) -> tuple[object, ...]:
            return (*grid, "component"), values, {"long_name": long_name, "unit_coordinate": "component_unit"}

        attributes = {"long_name": "status", "flag_meanings": " ".join(status.name.lower() for status in Status)}
        position, force = "actuator_position_unit", "actuator_force_unit"
        data: dict[str, object] = {
            "status": (grid, self.status, attributes),
            "characteristic_length": ((), self.target.robot.length, {"units": "m"}),
            "target": stacked(self.target.platform, "platform_coordinate", "platform_coordinate_unit", "target coordinates"),
            "actuator_position": stacked(self.actuators, "actuator", position, "corrected coordinate of the actuator"),
            "actuator_correction": stacked(self.corrections, "actuator", position, "correction of the actuator"),
            "actuator_force": stacked(self.actuator_forces, "actuator", force, VARIABLES["actuator_force"].words),
            "uncorrected_error": twists(self.uncorrected_error, "pose error, uncorrected"),
            "residual_error": twists(self.residual_error, "pose error, corrected"),
        }
        if self.uncorrectable_parts.shape[-1]:
            words = {"long_name": "twists that the actuators cannot produce, at o or tool, lengths by characteristic_length"}
            data["uncorrectable_direction"] = (*grid, "component", "direction"), self.uncorrectable_directions, words
            words = {"long_name": "component of the residual error along each of these twists"}
            data["uncorrectable_part"] = (*grid, "direction"), self.uncorrectable_parts, words
        coords: dict[str, object] = {
            **{
                name: (name, np.asarray(values), {"units": units[name]} if name in units else {}) for name, values in axes.items()
            },
            "actuator": names,
            "component": list(COMPONENTS),
            "component_unit": ("component", list(TWIST_UNITS)),
            "platform_coordinate": platform,
            "platform_coordinate_unit": ("platform_coordinate", [units[name] for name in platform]),
            "actuator_position_unit": ("actuator", [units[name] for name in names]),
            "actuator_force_unit": ("actuator", [connections[name].type.force_unit.replace("·", " ") for name in names]),
        }
        about: dict[str, object] = {"robot": self.target.robot.name, "controlled": " ".join(self.controlled)}
        about |= {} if self.tool is None else {"tool": self.tool.tolist()}
        return xr.Dataset(data, coords, {**about, "orientation": self.target.orientation.name})

    def save(self, path: str | os.PathLike[str], axes: Mapping[str, ArrayLike] | None = None) -> None:
        """Write all quantities to a file; an existing file is replaced.

        Args:
            path: name of the file. ``.csv``: a table with a row for each pose and units in the titles; cells without a correction
                are empty. ``.nc``: netCDF, the Dataset of :meth:`to_dataset`.
            axes: as in :meth:`to_dataset`.

        Raises:
            ArgumentError: the name has another ending, or the file cannot be written.
        """
        name = path_name("path", path)
        if name.endswith(".csv"):
            write_table(name, _table_columns(self))
        elif name.endswith(".nc"):
            content = io.BytesIO()  # HDF5 cannot close files on a full disk
            self.to_dataset(axes).to_netcdf(content, engine="h5netcdf")
            with replacing(name) as partial:
                partial.write_bytes(content.getbuffer())
        else:
            raise ArgumentError(f"{name!r} does not end in .csv (a table) or .nc (netCDF)")

    @property
    def shape(self) -> tuple[int, ...]:
        """Batch shape of all arrays."""
        return self.result.shape

    @property
    def configuration(self) -> Configuration:
        """Pose of the unloaded robot at the corrected actuators."""
        return self.result.configuration

    @cached_property
    def status(self) -> NDArray[np.int8]:
        """:class:`Status` of every corrected pose (…), UNREACHABLE if no correction was found.

        It is also UNREACHABLE or SINGULAR where the unloaded robot is at the target pose.
        """
        before = self.uncorrected.status
        status = np.where(np.isin(before, WITHOUT_NUMBERS), before, self.result.status).astype(np.int8)
        status.setflags(write=False)
        return status

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings about the corrected poses, in full sentences; if no pose was corrected, about the uncorrected poses."""
        return (self.uncorrected if np.all(np.isin(self.status, WITHOUT_NUMBERS)) else self.result).warnings

    @cached_property
    def actuators(self) -> Mapping[str, Array]:
        """(…) corrected coordinate of every actuator [m, rad]."""
        return ResultMapping({name: frozen(self.target.actuators[name] + shift) for name, shift in self.corrections.items()})

    @cached_property
    def corrections(self) -> Mapping[str, Array]:
        """(…) correction of every actuator: corrected coordinate less coordinate at the target pose [m, rad]."""
        connections = self.target.robot.mechanism.connections
        corrections: dict[str, Array] = {}
        for name, value in self.configuration.actuators.items():
            shift = np.asarray(shift_of(self.target.actuators[name], value, connections[name].type.is_slide))
            shift = np.where(self.configuration.reached.reshape(self.shape), shift, np.nan)
            corrections[name] = frozen(np.asarray(shift))
        return ResultMapping(corrections)

    @property
    def actuator_forces(self) -> Mapping[str, Array]:
        """(…) force or torque of each actuator at the corrected pose [N or N·m], for feedforward control."""
        return self.result.actuator_forces

    @cached_property
    def uncorrected_error(self) -> Array:
        """(…, 6) pose error of the loaded platform without correction [m, rad], at o or tool, world axes."""
        return self._error(self.uncorrected)

    @cached_property
    def residual_error(self) -> Array:
        """(…, 6) pose error at the corrected actuator positions [m, rad], at o or tool, world axes."""
        return self._error(self.result)

    @cached_property
    def uncorrected_error_coordinates(self) -> Mapping[str, Array]:
        """(…) error in each coordinate of the platform without correction [m, rad]."""
        return self._coordinate_errors(self.uncorrected)

    @cached_property
    def residual_error_coordinates(self) -> Mapping[str, Array]:
        """(…) error in each coordinate of the platform after correction [m, rad]; nearly zero in controlled coordinates."""
        return self._coordinate_errors(self.result)

    @cached_property
    def uncorrectable_directions(self) -> Array:
        """(…, 6, k) twists that the actuators cannot produce, k = 6 − mobility, at o or tool, world axes [m, rad].

        They are orthonormal, and orthogonal to all twists that the actuators produce at the corrected pose, in the scalar product
        d·d'/L² + r·r' of twists [d; r] with the characteristic length L = ``robot.length``. They depend on the point and on L,
        but not on ``controlled``. NaN where no pose was found or the pose is singular.
        """
        return batch_first(uncorrectable_directions(self.configuration, self.tool), self.shape)

    @cached_property
    def uncorrectable_parts(self) -> Array:
        """(…, k) components of ``residual_error`` along ``uncorrectable_directions``.

        To first order, the components are the same before and after the correction, for every choice of ``controlled``. The
        remainder of ``residual_error`` depends on this choice.
        """
        lengths = np.repeat([self.target.robot.length, 1.0], 3) ** 2
        parts = np.einsum("...ik,...i->...k", self.uncorrectable_directions, self.residual_error / lengths)
        return frozen(np.asarray(parts))

    def _error(self, result: Result) -> Array:
        error = pose_error(target_frame(self.target, self.tool), loaded_frame(result, self.tool))
        return batch_first(error, result.shape)

    def _coordinate_errors(self, result: Result) -> Mapping[str, Array]:
        orientation = self.target.orientation
        R, position = target_frame(self.target, self.tool)
        loaded_R, loaded_position = loaded_frame(result, self.tool)
        angles_of_target = orientation.coordinates(R)
        angles = orientation.coordinates(loaded_R, near=angles_of_target) - angles_of_target
        names = orientation.pose_names
        rows = [*(loaded_position - position), *angles]
        return ResultMapping({name: frozen(row.reshape(self.shape)) for name, row in zip(names, rows, strict=True)})


def shift_of(target: Array, corrected: Array, is_slide: bool) -> Array:
    """(N,) corrected less target coordinate of an actuator [m, rad]; differences of angles are within ±π."""
    shift = corrected - target
    return shift if is_slide else shift - 2 * np.pi * np.round(shift / (2 * np.pi))


def target_frame(target: Configuration, tool: Array | None) -> tuple[Array, Array]:
    """Return (R, p) at the target pose: rotation (3, 3, N) of the platform, position (3, N) of the tool's tip or of o."""
    return _at(tool, *target.robot.mechanism.platform_pose(target.frames))


def loaded_frame(result: Result, tool: Array | None) -> tuple[Array, Array]:
    """Return (R, p) of the loaded platform: rotation (3, 3, N), position (3, N) of the tool's tip or of o."""
    R, position = result.configuration.robot.mechanism.platform_pose(result.configuration.frames)
    return _at(tool, *loaded(R, position, result.twist.reshape(-1, 6).T))


def loaded(R: Array, position: Array, twist: Array) -> tuple[Array, Array]:
    """Return rotation (3, 3, N) and position (3, N) of o after displacing a pose by ``twist`` (6, N)."""
    return matmul(exponential(twist[3:]), R), position + twist[:3]


def _at(tool: Array | None, R: Array, position: Array) -> tuple[Array, Array]:
    return R, position if tool is None else np.asarray(position + np.einsum("ijn,j->in", R, tool))


def pose_error(target: tuple[Array, Array], reached: tuple[Array, Array]) -> Array:
    """(6, N) displacement and rotation vector from pose ``target`` to pose ``reached``, each given as (R, p) [m, rad]."""
    (R, position), (other_R, other_position) = target, reached
    turn = logarithm(np.einsum("ikn,jkn->ijn", other_R, R), at_half_turns=True)
    return np.concatenate([other_position - position, turn])


# ---- files --------------------------------------------------------------------------------------------------------


def _table_columns(compensation: Compensation) -> dict[str, list[str]]:
    connections, units = compensation.target.robot.mechanism.connections, _units(compensation)
    columns = {f"{name} [{units[name]}]": cells(value) for name, value in compensation.target.platform.items()}
    columns["status"] = [Status(int(status)).name for status in compensation.status.ravel()]
    for name, force in compensation.actuator_forces.items():
        columns[f"{name} [{units[name]}]"] = cells(compensation.actuators[name])
        columns[f"correction of {name} [{units[name]}]"] = cells(compensation.corrections[name])
        columns[f"force of {name} [{connections[name].type.force_unit}]"] = cells(force)
    for k, name in enumerate(COMPONENTS):
        columns[f"residual_error {name} [{TWIST_UNITS[k]}]"] = cells(compensation.residual_error[..., k])
    return columns


def _units(compensation: Compensation) -> dict[str, str]:
    connections = compensation.target.robot.mechanism.connections
    units = {name: PLATFORM_UNITS[name] for name in compensation.target.platform}
    return units | {name: connections[name].type.unit for name in compensation.actuators}


# ---- twists that the actuators cannot produce ----------------------------------------------------------------------

#: If a singular value of the basis, projected on the coordinate axes nearest to it, is below this, a pose gets other axes.
ASKEW = 0.1


def uncorrectable_directions(configuration: Configuration, tool: Array | None) -> Array:
    """(6, k, N) twists of :attr:`Compensation.uncorrectable_directions` [m, rad]; NaN where no pose was found.

    With displacements divided by the characteristic length, they are an orthonormal basis of the orthogonal complement of all
    twists that the platform can have if the actuators move. Of these bases, the one nearest to some coordinate axes is chosen,
    with the same axes at all poses of the batch, if possible.
    """
    robot = robot_of(configuration)
    n, length = robot.mobility.platform, robot.length
    R, _ = robot.mechanism.platform_pose(configuration.frames)
    directions = np.full((R.shape[2], 6, 6 - n), np.nan)
    reached = np.flatnonzero(configuration.reached)
    for part in chunks(reached.size):
        which = reached[part]
        moves = robot.mobility_analysis.motions_at(configuration.poses.take(which))
        if tool is not None:
            arms = np.einsum("ijn,j->in", R[:, :, which], tool / length)
            moves = np.moveaxis(move_twist(np.moveaxis(moves, 0, 2), arms), 2, 0)
        regular = np.all(np.isfinite(moves), axis=(1, 2))
        directions[which[regular]] = np.linalg.svd(moves[regular])[0][:, :, n:]
    left = np.flatnonzero(np.all(np.isfinite(directions), axis=(1, 2)))
    while n < 6 and left.size:
        axes = pivot_rows(directions[left[0]])
        U, sizes, V = np.linalg.svd(np.swapaxes(directions[left][:, axes], 1, 2))
        distinct = (sizes[:, -1] >= ASKEW) | (np.arange(left.size) == 0)
        directions[left[distinct]] = (directions[left] @ U @ V)[distinct]
        left = left[~distinct]
    directions[:, :3] *= length
    return np.moveaxis(directions, 0, 2)
