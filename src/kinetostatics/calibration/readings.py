"""Readings as functions of the unknowns, with their Jacobian.

The compliance of a part is multiplied by its compliance factor. The derivative of the twist by this factor is exactly the
part's contribution to the twist (:attr:`kinetostatics.Result.source_contributions`), divided by the factor. The derivative by
the mass or a first moment of the payload is the platform's compliance times the derivative of the weight. For arguments of the
file see :mod:`kinetostatics.functions.derivatives`. Arrays (p,) have the varied quantities, see :class:`Unknowns`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from kinetostatics.analysis import analyzed
from kinetostatics.arguments import Keyword, check_choice, finite_numbers
from kinetostatics.calibration.measurements import readings_by_twist
from kinetostatics.calibration.unknowns import Unknowns
from kinetostatics.description.loads import Gauge
from kinetostatics.description.robot_description import RobotDescription
from kinetostatics.design.problem import assembled
from kinetostatics.design.sensitivities import STEP
from kinetostatics.exceptions import ArgumentError, AssemblyError, RobotFileError, StaticsError
from kinetostatics.functions.derivatives import derivatives_at
from kinetostatics.kinematics.configuration import Configuration, spread
from kinetostatics.load_case import LoadCase, load_at_o
from kinetostatics.math.arrays import Array, Index
from kinetostatics.parametric.robot_numbers import STEP as STEP_OF_CONSTANTS
from kinetostatics.results.result import Result
from kinetostatics.robot import Robot, robot_of

#: States of zero readings: the robot without weight; the same pose with weight, but without load.
REFERENCES = ("undeformed", "unloaded")


@dataclass(frozen=True)
class Readings:
    """The readings of a table.

    Attributes:
        rows: (n,) index of each reading's row in the table.
        which: (n,) index of each reading's gauge.
        gauges: gauges by name.
    """

    rows: Index
    which: Index
    gauges: Mapping[str, Gauge]


class Model:
    """Readings of a robot as functions of the unknowns.

    Args:
        coordinates: (N,) coordinates of the poses, by name.
        load: (N, 6) loads on the platform.
        reference: "undeformed", "unloaded", or coordinates of a pose without load, at which all readings are zero.
        orientation: convention of the orientation coordinates.
        case: all but the load: its point of application and axes, gravity, loads on links, ….
        rows: names of the rows, for errors about unreachable poses; None: no errors, readings at such poses are NaN.
        closure_tolerance: largest gap of a closed loop [m, rad].
    """

    def __init__(
        self,
        unknowns: Unknowns,
        coordinates: Mapping[str, Array],
        load: Array,
        readings: Readings,
        reference: object,
        orientation: str | None,
        case: LoadCase,
        rows: Sequence[str] | None = None,
        closure_tolerance: float = 1e-10,
    ) -> None:
        self.unknowns, self.readings, self.orientation = unknowns, readings, orientation
        self._closure_tolerance = closure_tolerance
        #: Loads on the platform are added about o, world axes.
        self.case = replace(case, point=None, frame="world")
        count = len(load)
        actuated = unknowns.robot.description.actuated
        given = dict(coordinates) or {name: np.zeros(count) for name in actuated}
        self._of_actuators = set(given) <= set(actuated)
        extra, self._referred = 0, np.full(count, -1)
        if isinstance(reference, Mapping):
            extra, self._referred = 1, np.full(count, count)
            if set(reference) != set(given):
                raise ArgumentError(
                    f"reference has the coordinates {', '.join(map(str, reference))}; measurements have {', '.join(given)}"
                )
            end = {name: finite_numbers(f"reference: {name}", reference[name]) for name in given}
            if any(value.size != 1 for value in end.values()):
                raise ArgumentError(f"reference is {reference!r}; it must be one pose, with a number for each coordinate")
            end = {name: value.reshape(1) for name, value in end.items()}
            given = {name: np.concatenate([given[name], end[name]]) for name in given}
        else:
            check_choice("reference", reference, REFERENCES)
            if reference == "unloaded":
                extra, self._referred = count, np.arange(count) + count
                given = {name: np.tile(value, 2) for name, value in given.items()}
        self._given, self._size = given, count + extra
        self.pose = self._assembled(unknowns.robot, None)
        if rows is not None and not np.all(self.pose.reached):
            bad = int(np.flatnonzero(~self.pose.reached)[0])
            try:
                self._assembled(unknowns.robot, None, bad)
            except AssemblyError as error:
                where = "reference: " if bad >= count and isinstance(reference, Mapping) else rows[bad % count]
                raise AssemblyError(f"{where}{error}", error.residuals, error.mobility, error.reached) from None
        wrench = np.concatenate([np.asarray(load, dtype=float), np.zeros((extra, 6))])
        _, self._gravity, point = case.arrays
        for what, array in (("gravity", self._gravity), ("point", point)):
            if array is not None and array.shape != (3,):
                raise ArgumentError(f"{what} has the shape {array.shape}; it must be one vector (3,) for all rows")
        arm = None if point is None else np.broadcast_to(point, (len(wrench), 3)).T
        self._load = load_at_o(unknowns.robot, self.pose.frames, wrench.T, arm, case.frame).T
        self._latest: tuple[bytes, Result] | None = None
        self._derived: tuple[bytes, Array] | None = None
        self.refused = ""  # reason why the last invalid values yield no robot

    def _assembled(self, robot: Robot, near: Configuration | None, only: int | None = None) -> Configuration:
        given = self._given if only is None else {name: value[only] for name, value in self._given.items()}
        how = "nan" if only is None else "raise"
        is_platform, tolerance = not self._of_actuators, self._closure_tolerance
        pose = assembled(robot, given, is_platform, self.orientation, tolerance, self.case, near if given else None, how)
        return pose if given else spread(pose, (self._size,))

    def result(self, values: Array) -> Result:
        """Return the analysis of the poses of all rows, followed by the reference poses; the latest result is cached."""
        key = values.tobytes()
        if self._latest is None or self._latest[0] != key:
            robot = Robot(self.unknowns.described(values))
            pose = replace(self.pose, robot=robot)
            if not _same_poses(robot.description, self.unknowns.robot.description):
                pose = self._assembled(robot, pose)
            self._latest = key, self._analyzed(pose, values, self.unknowns.errors(values))
        return self._latest[1]

    def _analyzed(self, pose: Configuration, values: Array, errors: Mapping[str, Keyword]) -> Result:
        given = self.case.assembly_errors or {}
        if twice := next((name for name in errors if name in given), None):
            raise ArgumentError(f"assembly_errors: the errors of {twice!r} are among the unknowns, too")
        mass, moment, _ = self.unknowns.payload_of(values)
        load = self._load + self._weight(pose, mass, moment)
        every = {**given, **errors} or None
        return analyzed(pose, replace(self.case, load=load, assembly_errors=every), "nan")

    def _weight(self, pose: Configuration, mass: float, moment: Array) -> Array:
        """Return the weight (M, 6) about o, world axes, of a mass [kg] with a first moment (3,) about o, platform axes [kg·m]."""
        R, _ = robot_of(pose).mechanism.platform_pose(pose.frames)
        arm = np.einsum("ijn,j->ni", R, moment)
        return np.concatenate([mass * np.broadcast_to(self._gravity, arm.shape), np.cross(arm, self._gravity)], axis=-1)

    def read(self, pose: Configuration, twists: Array) -> Array:
        """Return the readings (n, …) for twists (M, 6, …), less the readings at the reference poses."""
        gauges, rows, which = list(self.readings.gauges.values()), self.readings.rows, self.readings.which
        readings = np.einsum("ni,ni...->n...", readings_by_twist(gauges, which, pose, rows), twists[rows])
        before = self._referred[rows]
        if np.any(before >= 0):
            readings = readings - np.einsum("ni,ni...->n...", readings_by_twist(gauges, which, pose, before), twists[before])
        return np.asarray(readings)

    def predict(self, values: Array) -> Array:
        """Return the readings (n,) [m, rad]; NaN if these values yield no robot or no equilibrium."""
        if any(unknown.kind == "stiffness" and not v > 0 for unknown, v in zip(self.unknowns.items, values, strict=True)):
            return np.full(len(self.readings.rows), np.nan)
        try:
            result = self.result(values)
        except (RobotFileError, StaticsError) as error:
            self.refused = str(error)
            return np.full(len(self.readings.rows), np.nan)
        readings = self.read(result.configuration, result.twist)
        for unknown, value in zip(self.unknowns.items, values, strict=True):
            if unknown.kind == "offset":
                readings = readings + value * self._is_of_gauge(unknown.parts[0][1])
        return readings

    def _is_of_gauge(self, gauge: str) -> Array:
        """Return an array (n,): 1 for readings of this gauge, 0 for others."""
        return np.asarray(self.readings.which == list(self.readings.gauges).index(gauge), dtype=float)

    def jacobian(self, values: Array) -> Array:
        """Return the derivatives (n, p) of the readings by the varied quantities."""
        key = values.tobytes()
        if self._derived is None or self._derived[0] != key:
            self._derived = key, self._jacobian(values)
        return self._derived[1]

    def _jacobian(self, values: Array) -> Array:
        result = self.result(values)
        pose, sources = result.configuration, result.source_contributions
        mass, _, arm = self.unknowns.payload_of(values)
        columns = []
        for k, (unknown, value) in enumerate(zip(self.unknowns.items, values, strict=True)):
            if unknown.kind == "stiffness":
                nothing = np.zeros_like(result.twist)
                twist = sum((sources.get(kind, {}).get(name, nothing) for kind, name in unknown.parts), nothing) / value
                columns.append(self.read(pose, twist))
            elif unknown.kind == "payload":
                axis = unknown.parts[0][1]
                if axis == "mass":
                    wrench = self._weight(pose, 1.0, arm)
                else:
                    wrench = self._weight(pose, 0.0, (1.0 if self.unknowns.by_moments else mass) * np.eye(3)["xyz".index(axis)])
                columns.append(self.read(pose, np.einsum("nij,nj->ni", result.compliance, wrench)))
            elif unknown.kind == "offset":
                columns.append(self._is_of_gauge(unknown.parts[0][1]))
            elif unknown.kind == "error":  # the twist is affine in it
                alone = self.unknowns.errors(np.where(np.arange(len(values)) == k, unknown.scale, 0.0))
                ends = (self._analyzed(pose, values, errors).twist for errors in (alone, self.unknowns.errors(0.0 * values)))
                columns.append(self.read(pose, np.subtract(*ends)) / unknown.scale)
            else:
                columns.append(self._by_argument(values, k, result))
        return np.stack(columns, axis=-1)

    def _by_argument(self, values: Array, k: int, result: Result) -> Array:
        """Return the derivatives (n,) of the readings by unknown k, an argument of the file.

        They are central differences if the argument changes the poses, if assembly errors are unknown too, or if there is no
        derivative by this argument.
        """
        unknown = self.unknowns.items[k]

        def changed(by: float) -> RobotDescription:
            return self.unknowns.described(values + by * np.eye(len(values))[k])

        step = STEP_OF_CONSTANTS * unknown.scale
        derivatives = None
        if _same_poses(result.robot.description, changed(step)) and not self.unknowns.errors(values):
            derivatives = derivatives_at(result, self.case.is_plain)
        if derivatives is not None:
            with suppress(ArgumentError):  # if there is no derivative by this argument
                twist = derivatives.by_change(unknown.name, step, changed)["twist"]
                slopes = self.read(result.configuration, np.moveaxis(twist, -1, 0))
                if np.all(np.isfinite(slopes)):
                    return slopes
        latest = self._latest
        change = STEP * unknown.scale * np.eye(len(values))[k]
        above, below = self.predict(values + change), self.predict(values - change)
        self._latest = latest
        return np.asarray((above - below) / (2 * STEP * unknown.scale))


def _same_poses(first: RobotDescription, second: RobotDescription) -> bool:
    """Whether equal coordinates of the joints yield equal poses of the platform's frame in both robots."""
    return all(getattr(first, name) == getattr(second, name) for name in ("joints", "loops", "platform_origin"))
