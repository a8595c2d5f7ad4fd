"""Results along a trajectory: quantities over time, and their peaks."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.arguments import check_choice, path_name
from kinetostatics.exceptions import ArgumentError
from kinetostatics.files.writer import cells, write_table
from kinetostatics.layout.mapping import ResultMapping
from kinetostatics.layout.report import Reported
from kinetostatics.math.arrays import Array, frozen
from kinetostatics.math.screws import COMPONENTS, TWIST_UNITS
from kinetostatics.results.result import Result
from kinetostatics.status import Status
from kinetostatics.units import PLATFORM_UNITS


@dataclass(frozen=True)
class Peak:
    """The value of the largest magnitude along a path.

    Attributes:
        value: the value, with its sign.
        time: instant of this value [s].
    """

    value: float
    time: float


@dataclass(frozen=True, eq=False, repr=False)
class PathResult(Reported):
    """The analysis of a trajectory, see :meth:`Trajectory.analyze`. All arrays are read-only.

    Attributes:
        times: (N,) instants of the poses [s].
        actuator_velocities: (N,) velocity of each actuator along the trajectory [m/s, rad/s], by name.
        result: the :class:`Result` of all poses, batch shape (N,).
        motion_warnings: warnings about the motion.
    """

    times: Array
    actuator_velocities: Mapping[str, Array]
    result: Result
    motion_warnings: tuple[str, ...] = ()

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings about the motion and the result, in full sentences."""
        return (*self.motion_warnings, *self.result.warnings)

    def at_point(self, point: ArrayLike) -> PathResult:
        """Return the results with another reference point on the platform, see :meth:`Result.at_point`."""
        return replace(self, result=self.result.at_point(point))

    def over_time(self, what: str) -> Mapping[str, Array]:
        """Return a quantity over time, (N,) by name of the reference point, contribution, actuator, beam or joint.

        Args:
            what: "displacement" [m] and "rotation" [rad], magnitudes; "contributions" to the twist, components along the
                displacement [m]; "actuator_force" [N], "actuator_torque" [N·m], "utilization" of the efforts [1],
                "actuator_speed" [m/s], "actuator_rate" [rad/s], "actuator_power" [W]; "stress", largest of each beam [Pa];
                "joint_force" [N], "joint_moment" [N·m], magnitudes.

        Raises:
            ArgumentError: there is no such quantity.
        """
        check_choice("what", what, tuple(OVER_TIME))
        return ResultMapping({name: frozen(values) for name, values in OVER_TIME[what].of(self).items()})

    def peaks(self, what: str) -> Mapping[str, Peak]:
        """Return, for each name of :meth:`over_time`, the value of largest magnitude and the time of this value.

        Raises:
            ArgumentError: there is no such quantity.
        """
        peaks = {}
        for name, values in self.over_time(what).items():
            size = np.nan_to_num(np.abs(values), nan=-1.0)
            k = int(np.argmax(size))
            peaks[name] = Peak(float(values[k]), float(self.times[k]))
        return ResultMapping(peaks)

    def root_mean_square(self, what: str) -> Mapping[str, float]:
        """Return, for each name of :meth:`over_time`, the root mean square over time, such as of a torque that heats a motor.

        Raises:
            ArgumentError: there is no such quantity.
        """
        time = np.ptp(self.times)
        squares = {name: np.trapezoid(values**2, self.times) for name, values in self.over_time(what).items()}
        return ResultMapping({name: float(np.sqrt(square / time)) for name, square in squares.items()})

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a table with a row for each instant: coordinates, status, actuators, twist of the platform, stresses.

        Args:
            path: name of the file, ending in ``.csv``; a file of that name is replaced.

        Raises:
            ArgumentError: the name has another ending.
        """
        file = path_name("path", path)
        if not file.endswith(".csv"):
            raise ArgumentError(f"{file!r} does not end in .csv (a table)")
        pose, connections = self.result.configuration, self.result.robot.mechanism.connections
        columns = {"time [s]": cells(self.times)}
        for name, values in pose.platform.items():
            columns[f"{name} [{PLATFORM_UNITS[name]}]"] = cells(values)
        columns["status"] = [Status(int(status)).name for status in self.result.status]
        for name, force in self.result.actuator_forces.items():
            kind = connections[name].type
            columns[f"{name} [{kind.unit}]"] = cells(pose.actuators[name])
            columns[f"velocity of {name} [{kind.unit}/s]"] = cells(self.actuator_velocities[name])
            columns[f"force of {name} [{kind.force_unit}]"] = cells(force)
        for k, name in enumerate(COMPONENTS):
            columns[f"twist {name} [{TWIST_UNITS[k]}]"] = cells(self.result.twist[:, k])
        columns |= {f"stress in {name} [Pa]": cells(beam.stress) for name, beam in self.result.beams.items()}
        write_table(file, columns)


@dataclass(frozen=True)
class OverTime:
    """A quantity over time.

    Attributes:
        words: name of the quantity in reports and on axes of figures.
        unit: unit of the quantity.
        of: function that returns the values (N,) along a path, by name; see :meth:`PathResult.over_time`.
    """

    words: str
    unit: str
    of: Callable[[PathResult], Mapping[str, Array]]


def _size_of(part: slice) -> Callable[[PathResult], Mapping[str, Array]]:
    return lambda path: {path.result.point_name: np.linalg.norm(path.result.twist[:, part], axis=1)}


def _contributions(path: PathResult) -> Mapping[str, Array]:
    moved = path.result.twist[:, :3]
    along = moved / np.maximum(np.linalg.norm(moved, axis=1), np.finfo(float).tiny)[:, None]
    return {name: np.einsum("ni,ni->n", twist[:, :3], along) for name, twist in path.result.contributions.items()}


def _of_actuators(slides: bool, values: Callable[[PathResult], Mapping[str, Array]]) -> Callable[[PathResult], dict[str, Array]]:
    def selected(path: PathResult) -> dict[str, Array]:
        connections = path.result.robot.mechanism.connections
        return {name: array for name, array in values(path).items() if connections[name].type.is_slide == slides}

    return selected


def _forces(path: PathResult) -> Mapping[str, Array]:
    return path.result.actuator_forces


def _powers(path: PathResult) -> Mapping[str, Array]:
    return {name: force * path.actuator_velocities[name] for name, force in path.result.actuator_forces.items()}


def _of_joints(part: slice) -> Callable[[PathResult], Mapping[str, Array]]:
    return lambda path: {name: np.linalg.norm(w[:, part], axis=1) for name, w in path.result.joint_wrenches.items()}


#: Quantities over time by name.
OVER_TIME: Mapping[str, OverTime] = {
    "displacement": OverTime("displacement of {point}", "m", _size_of(slice(3))),
    "rotation": OverTime("rotation of the platform", "rad", _size_of(slice(3, 6))),
    "contributions": OverTime("part of the displacement of {point}", "m", _contributions),
    "actuator_force": OverTime("force of the actuator", "N", _of_actuators(True, _forces)),
    "actuator_torque": OverTime("torque of the actuator", "N·m", _of_actuators(False, _forces)),
    "utilization": OverTime("force of the actuator relative to its effort", "1", lambda path: path.result.utilization),
    "actuator_speed": OverTime("velocity of the actuator", "m/s", _of_actuators(True, lambda path: path.actuator_velocities)),
    "actuator_rate": OverTime("velocity of the actuator", "rad/s", _of_actuators(False, lambda path: path.actuator_velocities)),
    "actuator_power": OverTime("power of the actuator", "W", _powers),
    "stress": OverTime("largest von Mises stress", "Pa", lambda path: {n: beam.stress for n, beam in path.result.beams.items()}),
    "joint_force": OverTime("force in the joint", "N", _of_joints(slice(3))),
    "joint_moment": OverTime("moment in the joint", "N·m", _of_joints(slice(3, 6))),
}
