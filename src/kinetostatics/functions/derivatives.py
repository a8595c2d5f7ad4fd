"""Derivatives of the outputs of a function with closed loops, by the implicit function theorem.

The outputs y(x, load, gravity, θ) and the residuals r(x, c, target, θ) of loops and prescribed coordinates are recorded together,
as a list of scalar operations (the record); x are the solved coordinates, c the orientation coordinates, θ the robot's constants.
The reverse mode of automatic differentiation gives all derivatives of y and r. When θ changes at rates θ', the freedoms move at
rates v' so that r remains zero: v' = −G⁺ ∂r/∂θ θ' and y' = ∂y/∂x T(x) v' + ∂y/∂θ θ'. Here G is the gradient of r by the freedoms,
and T(x) v' are the rates of the coordinates. The derivatives by the target follow in the same way. Only the rates θ'
are central differences, with relative errors of about 10⁻¹²: for example, the rate of 1/EI if the diameter of a rod changes.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np

from kinetostatics.description.robot_description import RobotDescription
from kinetostatics.engine.pose_record import PoseModel, PoseRecord, example_of, pose_record
from kinetostatics.engine.record_derivatives import gradients, values
from kinetostatics.engine.scalars import NotRecordedError, needed_by
from kinetostatics.exceptions import ArgumentError, KinetostaticsError
from kinetostatics.kinematics.alternatives import prescribed_platform
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.kinematics.coordinates import PrescribedCoordinates
from kinetostatics.kinematics.velocities import freedom_rates, with_given
from kinetostatics.math.arrays import Array, Index, Mask
from kinetostatics.parametric.parametric_robot import changed_model, have_same_statics
from kinetostatics.parametric.robot_numbers import RobotNumber
from kinetostatics.results.result import Result
from kinetostatics.robot import Robot, robot_of
from kinetostatics.statics.robot_statics import RobotStatics, statics_on

#: Quantities that are differentiated.
OUTPUTS = ("twist", "stiffness", "compliance", "actuator_forces", "actuators", "mass")
#: Relative singular value of the loops' gradient below which a motion is free.
_FREE = 1e-9
#: Fraction of a parameter's step at which the validity of a record is tested. It is so small that first-order motions keep the
#: loops closed within rounding.
_NEAR = 1e-6
#: Indices of some inputs of a record; the last index is that of the robot's constants.
_X, _LOAD, _GRAVITY, _NUMBERS = 0, 1, 2, 5


class Gradients:
    """Derivatives of outputs and residuals at N poses with respect to all inputs and constants of the robot.

    Args:
        model: the robot, with chosen wrench bases.
        inputs: x, load, gravity, c and target of the poses, each (…, N).
        poses: indices of the differentiated poses; derivatives at other poses are NaN.
        example: inputs of one pose, from which the array shapes of the results follow if ``poses`` is empty.
        tool: see :func:`kinetostatics.engine.pose_record.outputs_at`.

    Attributes:
        numbers: (P,) constants of the robot.
        records: the differentiated records, each with the indices of the poses at which it is valid.

    Raises:
        NotRecordedError: the analysis cannot be recorded.
    """

    def __init__(
        self,
        model: PoseModel,
        names: Sequence[str],
        inputs: Sequence[Array],
        poses: Index,
        example: Sequence[Array],
        tool: Array | None = None,
    ) -> None:
        self.numbers, self._inputs, self._N = model.structure(all_vary=True).values, inputs, inputs[0].shape[1]
        self.records: list[tuple[PoseRecord, Index]] = []
        self._parts: list[tuple[Index, Array]] = []
        all_names, left = ["residual", *names], poses
        while left.size or not self.records:
            first = [array[:, left[:1]] for array in inputs] if left.size else example
            record = pose_record(model, all_names, first, all_vary=True, tool=tool)
            leaves, slopes, holds = _differentiated(record, [array[:, left] for array in inputs], self.numbers)
            holds[:1] = True  # at the example pose
            self.records.append((record, left[holds]))
            self._parts.append((leaves, slopes[..., holds]))
            left = left[~holds]

    @property
    def record(self) -> PoseRecord:
        """The record at the first pose."""
        return self.records[0][0]

    def along(self, directions: Mapping[int, Array]) -> dict[str, Array]:
        """Return the rates of residuals and outputs (…, N).

        Args:
            directions: rates of inputs (…, N) or (…, 1) and of the constants (P,), by number of the array; other rates are zero.
        """
        total = np.full((len(self.record.all_rows()), self._N), np.nan)
        for (_, where), (leaves, slopes) in zip(self.records, self._parts, strict=True):
            total[:, where] = 0.0
            for kind, direction in directions.items():
                of_kind = leaves[:, 0] == kind
                moved = direction.reshape(len(direction), -1)[leaves[of_kind, 1]]
                moved = moved[:, where] if moved.shape[1] == self._N else np.repeat(moved, where.size, axis=1)
                total[:, where] += np.einsum("mln,ln->mn", slopes[:, of_kind], moved)
        ends = np.cumsum([len(rows) for rows in self.record.rows.values()])[:-1]
        parts = zip(self.record.shapes.items(), np.split(total, ends), strict=True)
        return {name: part.reshape(*shape, self._N) for (name, shape), part in parts}

    def remain_valid(self, by: float, directions: Mapping[int, Array]) -> bool:
        """Whether the records remain valid if x and the constants change by ``by`` times their rates, see :meth:`along`."""
        for record, where in self.records:
            inputs = [array[:, where] for array in self._inputs]
            if _X in directions:
                inputs[_X] = inputs[_X] + by * np.nan_to_num(directions[_X][:, where])
            needed = needed_by(record.tape, [record.all_hold()])
            results = values(record.tape, needed, inputs, self.numbers + by * directions[_NUMBERS])
            if not np.all(results[record.all_hold()]):
                return False
        return True


class Derivatives:
    """Derivatives of some outputs at N poses.

    Args:
        pose: the closed poses, of batch shape (N,).
        target: (n, N) values of the prescribed coordinates.
        load: (6, N) [N, N·m].
        gravity: (3, N) [m/s²].
        outputs: names of outputs; "mass" [kg] is the robot's mass.
        tool: (3,) reference point of twist, stiffness and compliance, from o in platform axes [m]; None: o.
    """

    def __init__(
        self,
        pose: Configuration,
        prescribed: PrescribedCoordinates,
        target: Array,
        load: Array,
        gravity: Array,
        outputs: Sequence[str],
        tool: Array | None = None,
    ) -> None:
        self.robot: Robot = robot_of(pose)
        self.pose, self.target, self.load, self.gravity = pose, target, load, gravity
        self.prescribed = self.robot.mobility_analysis.with_dofs(prescribed)
        self.outputs, self.tool = tuple(outputs), tool
        self.N = load.shape[1]

    @cached_property
    def nominal(self) -> Gradients:
        """Derivatives by inputs and by the robot's constants, with the robot's own wrench bases.

        Raises:
            ArgumentError: the robot has no derivatives.
        """
        return self._gradients(self.robot.statics)

    def _gradients(self, decided: RobotStatics) -> Gradients:
        """Return the derivatives with the wrench bases of ``decided``."""
        poses, generic = self.pose.poses, self.robot.generic_poses.take(np.array([0]))
        inputs = poses.x, self.load, self.gravity, poses.c, self.target
        target, c = self.robot.solver.origin(self.prescribed, generic)
        example = generic.x, *example_of(decided)[1:], c, target
        valid_poses = np.flatnonzero(self.pose.reached & self.pose.frames.are_finite())
        try:
            return Gradients(self.model(decided), self.outputs, inputs, valid_poses, example, self.tool)
        except NotRecordedError as error:
            raise ArgumentError(f"{self.robot.name!r} has no derivatives: {error}") from error

    def model(self, decided: RobotStatics) -> PoseModel:
        """Return the model of the robot with the wrench bases of ``decided``."""
        return PoseModel.of(self.robot.solver, decided, self.prescribed)

    # ---- closure of the loops -----------------------------------------------------------------------------------------

    @cached_property
    def _closing(self) -> tuple[Array, Array, Array]:
        """Return (gradient, inverse, rates) of the scaled residuals.

        gradient (N, m, n): of the m residuals with respect to scaled steps of the n unknowns; inverse (N, n, m): its
        pseudoinverse; rates (m, coordinates, N): of the residuals at unit rates of the prescribed coordinates.
        """
        gradient, rates = self.robot.solver.rates(self.prescribed, self.pose.poses, self.target)
        turned = np.nan_to_num(np.moveaxis(gradient, 2, 0))
        inverse = np.swapaxes(turned, 1, 2)
        if turned.size:
            inverse = np.asarray(np.linalg.pinv(turned, rcond=_FREE), dtype=np.float64)
        return turned, inverse, rates

    def _velocities(self, rates: Array) -> Array:
        """Return the rates (nv, k, N) of the freedoms that cancel given ``rates`` (m, k, N) of the residuals."""
        turned, inverse, _ = self._closing
        step = np.moveaxis(-inverse @ np.moveaxis(rates, 2, 0), 0, 2)
        return freedom_rates(self.robot.solver, self.prescribed, np.moveaxis(turned, 0, 2), rates, step)

    @cached_property
    def _by_coordinates(self) -> Array:
        """Rates (nv, coordinates, N) of the freedoms for a unit rate of each prescribed coordinate."""
        return with_given(self.robot.solver, self.prescribed, self._velocities(self._closing[2]))

    def _moving(self, v: Array) -> dict[int, Array]:
        """Return the rates of x for rates (nv, N) of the freedoms, as directions of :meth:`Gradients.along`."""
        return {_X: self.robot.solver.tree.rates(self.pose.poses.x, v)}

    # ---- derivatives by kind of input ---------------------------------------------------------------------------------

    def by_coordinate(self, k: int) -> dict[str, Array]:
        """Return the derivatives (*output, N) by the k-th prescribed coordinate."""
        return self._requested(self.nominal.along(self._moving(self._by_coordinates[:, k])))

    def by_components(self, name: str) -> dict[str, Array]:
        """Return the derivatives (*output, n, N) by the n components of "load" or "gravity"."""
        kind, size = {"load": (_LOAD, 6), "gravity": (_GRAVITY, 3)}[name]
        return _stacked([self._requested(self.nominal.along({kind: unit[:, None]})) for unit in np.eye(size)])

    def by_numbers(self, numbers: Sequence[RobotNumber]) -> dict[str, Array]:
        """Return the derivatives by numbers of the robot: (*output, N) by one number, (*output, n, N) by n numbers.

        They are NaN if the loops cannot remain closed (overconstrained robots), and for numbers without derivative.

        Raises:
            ArgumentError: no number has a derivative, since a change yields another mechanism or an invalid robot.
        """
        columns: list[dict[str, Array]] = []
        errors: list[ArgumentError] = []
        for number in numbers:
            try:
                columns.append(self._zero() if number.step is None else self.by_change(number.name, number.step, number.changed))
            except ArgumentError as error:
                errors.append(error)
                columns.append({name: np.full_like(part, np.nan) for name, part in self._zero().items()})
        if len(errors) == len(columns):
            raise errors[0]
        return columns[0] if len(columns) == 1 else _stacked(columns)

    def _zero(self) -> dict[str, Array]:
        return self._requested(self.nominal.along({}))

    def by_change(self, name: str, step: float, changed: Callable[[float], RobotDescription]) -> dict[str, Array]:
        """Return the derivatives (*output, N) by a number, with wrench bases that are also valid for the changed robot.

        Args:
            name: name of the number, for messages.
            step: step of the finite differences of constants.
            changed: function that returns the description with the number increased by an amount.

        Raises:
            ArgumentError: the change yields another mechanism or an invalid robot.
        """

        def derivatives_with(decided: RobotStatics, nominal: Gradients) -> dict[str, Array] | None:
            model = self.model(decided)

            def difference(amount: float) -> Array:
                return (
                    changed_model(self.robot, changed(amount), model)[1] - changed_model(self.robot, changed(-amount), model)[1]
                )

            # central differences of fourth order; unchanged constants cancel exactly
            rates = 2 / 3 / step * difference(step) - 1 / 12 / step * difference(2 * step)
            return self._by_rates(rates, nominal, step)

        try:
            if all(have_same_statics(changed(by), self.robot.description) for by in (step, -step)):
                return self._zero()
            with contextlib.suppress(KinetostaticsError):  # the change may affect which axes meet
                if first := derivatives_with(self.robot.statics, self.nominal):
                    return first
            decided = statics_on(Robot(changed(step)).statics, self.robot.statics)
            if second := derivatives_with(decided, self._gradients(decided)):
                return second
        except KinetostaticsError as error:
            raise ArgumentError(f"there is no derivative by {name!r}: {error}") from error
        raise ArgumentError(f"there is no derivative by {name!r}: it changes the structure of the robot's limbs")

    def _by_rates(self, rates: Array, nominal: Gradients, step: float) -> dict[str, Array] | None:
        """Return the derivatives for given rates (P,) of the constants.

        None if a change by a small fraction of ``step`` makes the records of ``nominal`` invalid.
        """
        directions = {_NUMBERS: rates}
        residual = nominal.along(directions)["residual"]
        if np.any(np.nan_to_num(residual)):
            directions |= self._moving(self._velocities(residual[:, None])[:, 0])
        if not all(nominal.remain_valid(by * step, directions) for by in (_NEAR, -_NEAR)):
            return None
        return self._requested(nominal.along(directions))

    def _requested(self, rates: Mapping[str, Array]) -> dict[str, Array]:
        return {name: rates[name] for name in self.outputs}


def _stacked(columns: Sequence[Mapping[str, Array]]) -> dict[str, Array]:
    """Stack the derivatives (*output, N) with respect to each of n numbers as (*output, n, N)."""
    return {name: np.stack([column[name] for column in columns], axis=-2) for name in columns[0]}


def derivatives_at(
    result: Result, is_plain: bool, tool: Array | None = None, names: Sequence[str] = OUTPUTS
) -> Derivatives | None:
    """Return the derivatives at all poses of an analysis, or None.

    None if the robot cannot be recorded, if a pose is not reached, or if the analysis has other loads than load and gravity.

    Args:
        is_plain: see :attr:`.LoadCase.is_plain`.
        tool: (3,) reference point of twist and stiffness, from o in platform axes [m]; None: o.
    """
    configuration = result.configuration
    if not is_plain or result.shape != configuration.shape or not np.all(configuration.reached):
        return None
    robot, N, convention = robot_of(configuration), len(configuration.reached), configuration.orientation
    if configuration.prescribed:
        prescribed = prescribed_platform(configuration.prescribed, convention)
        values = [configuration.platform[name] for name in convention.pose_names if name in configuration.prescribed]
    else:
        prescribed = robot.actuator_coordinates
        values = [configuration.actuators[name] for name in robot.actuator_names]
    target = np.array([np.ravel(value) for value in values]).reshape(len(values), N)
    load, gravity = result.load.reshape(N, 6).T, result.gravity.reshape(N, 3).T
    if not np.all(np.isfinite(load)):
        return None
    actuated = robot.description.actuated
    outputs = [name for name in OUTPUTS if name in names and (actuated or not name.startswith("actuator"))]
    derivatives = Derivatives(replace(configuration, shape=(N,)), prescribed, target, load, gravity, outputs, tool)
    with contextlib.suppress(ArgumentError):  # it has no record
        return derivatives if not N or derivatives.nominal else None
    return None


def _differentiated(record: PoseRecord, inputs: Sequence[Array], numbers: Array) -> tuple[Index, Array, Mask]:
    """Return (leaves, derivatives, valid) of a record with L inputs and constants.

    A row of ``leaves`` (L, 2) is the number of an input array and a component, or ``_NUMBERS`` and the index of a constant. The
    derivatives (rows, L, N) are with respect to these. ``valid`` (N,) is True where the record is valid.
    """
    rows, tape, N = record.all_rows(), record.tape, inputs[0].shape[1]
    needed = needed_by(tape, (*rows, record.all_hold()))
    leaves: dict[int, tuple[int, int]] = {}
    for number, (name, *taken) in enumerate(tape.operations):
        if needed[number] and name in ("input", "parameter"):
            leaves[number] = (_NUMBERS if name == "parameter" else taken[0], taken[-1])
    places = {number: place for place, number in enumerate(leaves)}
    derivatives, holds = np.zeros((len(rows), len(leaves), N)), np.zeros(N, dtype=bool)
    residuals = len(record.rows["residual"])
    at_once = max(1, 4000 // max(len(rows), 1))
    for first in range(0, N, at_once):
        part = slice(first, min(first + at_once, N))
        results = values(tape, needed, [array[:, part] for array in inputs], numbers)
        holds[part] = results[record.all_hold()]
        for some in (slice(0, residuals), slice(residuals, None)):  # residuals do not depend on the equilibrium
            for number, slopes in gradients(tape, results, rows[some], leaves, part.stop - part.start).items():
                derivatives[some, places[number], part] = slopes
    return np.array(list(leaves.values()), dtype=np.intp).reshape(-1, 2), derivatives, holds
