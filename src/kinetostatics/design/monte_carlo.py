"""Monte Carlo simulation of thousands of robots with random deviations at one pose.

A record is the list of arithmetic operations of loop closure and equilibrium. Its inputs are coordinates, loads, and the robot's
constants, that is, the numbers that enter the equations; it is valid for all robots that take the same branches of the
computation. Every robot is a column of a batch. The constants are computed from the description for four deviations of each
parameter, and interpolated for all other robots. Where a constant changes by less than a factor of 5, its logarithm is
interpolated; this is exact for products of powers such as 1/(EI). For every robot, Newton's method closes the loops, and the
equilibrium is solved.

Records are evaluated by NumPy, because compiling them takes about as long as evaluating 10,000 robots.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from kinetostatics.analysis import analyzed
from kinetostatics.description.robot_description import RobotDescription
from kinetostatics.design.sensitivities import numbers_of
from kinetostatics.engine.pose_record import PoseModel, PoseRecord, pose_record
from kinetostatics.engine.record_derivatives import values
from kinetostatics.engine.scalars import needed_by
from kinetostatics.exceptions import ArgumentError, KinetostaticsError
from kinetostatics.functions.derivatives import Derivatives
from kinetostatics.kinematics.solver import SolverState
from kinetostatics.load_case import LoadCase
from kinetostatics.math.arrays import Array, Mask
from kinetostatics.math.linalg import least_squares
from kinetostatics.parametric.parametric_robot import ParametricRobot, changed_model, same_pose
from kinetostatics.parametric.robot_numbers import ErrorParameter, RobotNumber, as_assembly_errors
from kinetostatics.progress import waiting
from kinetostatics.results.result import Result
from kinetostatics.robot import Robot

#: Quantities of each robot.
WANTED = ("twist", "stiffness", "actuator_forces")
_CLOSING = ("residual", "gradient")
#: Interpolation nodes besides the nominal robot, relative to the largest change of a parameter.
NODES = (-1.0, -0.5, 0.5, 1.0)
#: Number of robots in a batch, and largest number of records, each for other branches of the computation.
BATCH, RECORDS = 1000, 6
#: Largest number of Newton corrections, and scaled magnitude of a correction that counts as rounding.
CORRECTIONS, ROUNDING = 12, 1e-13
#: Largest remaining gap of a closed loop, relative to the initial gap; an overconstrained robot that cannot close exceeds it.
OPEN = 0.03
#: Number of samples of a batch that are also analysed one by one.
CHECKED = 3


def random_robots(
    nominal: Result,
    derivatives: Derivatives | None,
    family: ParametricRobot,
    numbers: Sequence[RobotNumber],
    errors: Sequence[ErrorParameter],
    linear: Mapping[str, Array],
    values: Array,
    case: LoadCase,
    deviation: float,
    tool: Array | None,
) -> tuple[dict[str, Array], float]:
    """Return twist, stiffness and actuator forces (N, …) of N robots, and their largest difference from single analyses.

    The difference is the distance of displacements, in units of ``deviation``; NaN if no robot was analysed singly.

    Args:
        derivatives: derivatives of this analysis; None: all robots are analysed one by one.
        linear: (errors, …) effects per unit of each assembly error, by quantity; the effects are superposed.
        values: (numbers + errors, N) deviations from the nominal values, SI.
        deviation: standard deviation of the displacement [m].
        tool: reference point of twist and stiffness; None: o.
    """
    N, nominal_arrays = values.shape[1], numbers_of(nominal.configuration, nominal, tool, WANTED)
    by_numbers, by_errors = values[: len(numbers)], values[len(numbers) :]
    if not numbers:
        samples = {name: np.broadcast_to(array, (N, *array.shape)) for name, array in nominal_arrays.items()}
    elif derivatives is None:
        samples = {name: np.full((N, *array.shape), np.nan) for name, array in nominal_arrays.items()}
    else:
        with waiting(f"computing {N:,} robots"):
            made = ManyRobots(derivatives, family, numbers, np.max(np.abs(by_numbers), axis=1)).at(by_numbers)
        samples = {name: np.moveaxis(array, -1, 0) for name, array in made.items()}
    samples = {name: array + np.tensordot(by_errors.T, linear[name], 1) if errors else array for name, array in samples.items()}
    is_lost = np.isnan(samples["twist"][:, 0])
    checked = np.flatnonzero(~is_lost)[: CHECKED * bool(numbers)].tolist()
    lost, worst = np.flatnonzero(is_lost).tolist(), math.nan
    for done, k in enumerate([*checked, *lost]):
        with waiting(f"analysing robots one by one: {done} of {len(checked) + len(lost)}"), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                off = {number.name: float(by) for number, by in zip(numbers, by_numbers[:, k], strict=True)}
                sample = _analysed(family.increased(off), nominal, errors, by_errors[:, [k]], case, tool)
            except KinetostaticsError:  # the values are invalid
                continue
        if done < len(checked):
            apart = float(np.linalg.norm((sample["twist"] - samples["twist"][k])[:3]))
            worst = max(apart / deviation if deviation > 0 else 0.0, 0.0 if math.isnan(worst) else worst)
        else:
            for name, array in sample.items():
                samples[name][k] = array
    return samples, worst


def _analysed(
    description: RobotDescription,
    nominal: Result,
    errors: Sequence[ErrorParameter],
    amounts: Array,
    case: LoadCase,
    tool: Array | None,
) -> dict[str, Array]:
    """Return the quantities of one robot with assembly errors of given amounts (errors, 1)."""
    pose = same_pose(nominal.configuration, Robot(description), case.loops)
    quantities = numbers_of(pose, analyzed(pose, case, "nan"), tool, WANTED)
    if errors:
        off = analyzed(pose, replace(case, assembly_errors=as_assembly_errors(errors, amounts)), "nan")
        quantities["twist"] = quantities["twist"] + off.seen_from(tool).contributions["assembly_errors"][0]
        if "actuator_forces" in quantities:
            more = np.array([parts["assembly_errors"][0] for parts in off.actuator_contributions.values()])
            quantities["actuator_forces"] = quantities["actuator_forces"] + more
    return quantities


class Constants:
    """Constants of robots with several changes, interpolated between robots with one change each.

    Args:
        nominal: (P,) constants of the nominal robot.
        nodes: for each change, (len(NODES), P) constants of robots with the fractions ``NODES`` of this change.
    """

    def __init__(self, nominal: Array, nodes: Sequence[Array]) -> None:
        self.nominal = nominal
        at = np.stack(nodes) if len(nodes) else np.zeros((0, len(NODES), nominal.size))
        self.changing = np.flatnonzero(np.any(at != nominal, axis=(0, 1)))
        at, nominal_values = at[..., self.changing], nominal[self.changing]
        with np.errstate(all="ignore"):
            ratios = at / nominal_values
            self._is_product = np.all((ratios > 0.2) & (ratios < 5), axis=(0, 1))
            self._rates = np.where(self._is_product, np.log(np.where(self._is_product, ratios, 1.0)), at - nominal_values)

    def at(self, parts: Array, which: Sequence[int]) -> list[float | Array]:
        """Return all constants as inputs of a record: arrays (N,) for changing constants among ``which``, else nominal scalars.

        Args:
            parts: (changes, N) changes relative to the largest change of each parameter.
            which: indices of the constants that the record needs.
        """
        constants: list[float | Array] = self.nominal.tolist()
        rows = np.flatnonzero(np.isin(self.changing, which))
        total = np.einsum("jkn,kjp->pn", _lagrange(parts), self._rates[..., rows], optimize=True)
        for row, change in zip(rows.tolist(), total, strict=True):
            number = int(self.changing[row])
            nominal_value = self.nominal[number]
            constants[number] = nominal_value * np.exp(change) if self._is_product[row] else nominal_value + change
        return constants


def _lagrange(parts: Array) -> Array:
    """Return the interpolation weights (len(NODES), …) of the values at the nodes, for functions that vanish at zero."""
    nodes = (*NODES, 0.0)
    rows = []
    for k, node in enumerate(NODES):
        others = [other for j, other in enumerate(nodes) if j != k]
        rows.append(np.prod([(parts - other) / (node - other) for other in others], axis=0))
    return np.stack(rows)


class ManyRobots:
    """Robots with small deviations at one pose.

    Args:
        derivatives: derivatives of the nominal robot at its pose, a batch of one.
        reach: (numbers,) largest deviation of each number.
    """

    def __init__(self, derivatives: Derivatives, robots: ParametricRobot, numbers: Sequence[RobotNumber], reach: Array) -> None:
        self._derivatives, self._robots, self._numbers, self._reach = derivatives, robots, numbers, reach
        self._robot: Robot = derivatives.robot
        self._prescribed = derivatives.prescribed
        self._model = derivatives.model(self._robot.statics)
        self._names = tuple(name for name in WANTED if name in derivatives.outputs)
        nominal_values, nodes = self._model.structure(all_vary=True).values, []
        for number, amount in zip(numbers, reach.tolist(), strict=True):
            try:
                made = [changed_model(self._robot, number.changed(node * amount), self._model)[1] for node in NODES]
            except KinetostaticsError as error:
                raise ArgumentError(f"{number.name} cannot deviate by its tolerance: {error}") from error
            nodes.append(np.stack(made))
        self._constants = Constants(nominal_values, nodes)
        poses = derivatives.pose.poses
        self._nominal = self._record(self._model, poses, (*_CLOSING, *self._names))

    def _record(self, model: PoseModel, poses: SolverState, names: Sequence[str]) -> PoseRecord:
        given = self._derivatives.load, self._derivatives.gravity, poses.c, self._derivatives.target
        return pose_record(model, names, (poses.x, *given), all_vary=True, tool=self._derivatives.tool)

    def at(self, amounts: Array) -> dict[str, Array]:
        """Return twist, stiffness and actuator forces (…, N) of robots; NaN where no record is valid or the loops do not close.

        Args:
            amounts: (numbers, N) deviations.
        """
        parts, N = amounts / self._reach[:, None], amounts.shape[1]
        nominal, record = self._derivatives.pose.poses, self._nominal
        poses, good = SolverState(np.repeat(nominal.x, N, axis=1), np.repeat(nominal.c, N, axis=1)), np.ones(N, dtype=bool)
        for some in _batches(N):
            closed, good[some] = self._closed(parts[:, some], poses.take(np.arange(N)[some]))
            poses.x[:, some], poses.c[:, some] = closed.x, closed.c
        quantities = {name: np.full((*record.shapes[name], N), np.nan) for name in self._names}
        left = np.flatnonzero(good)
        for _ in range(RECORDS):
            holds = np.zeros(left.size, dtype=bool)
            for some in _batches(left.size):
                here = left[some]
                outputs, fine = self._evaluated(record, self._names, parts[:, here], poses.take(here))
                holds[some] = np.broadcast_to(fine, here.size)
                for name, array in outputs.items():
                    quantities[name][..., here] = np.where(holds[some], array, np.nan)
            left = left[~holds]
            if not left.size:
                break
            off = {number.name: float(by) for number, by in zip(self._numbers, amounts[:, left[0]], strict=True)}
            model, _ = changed_model(self._robot, self._robots.increased(off), self._model)
            record = self._record(model, poses.take(left[:1]), self._names)
        return quantities

    def _closed(self, parts: Array, poses: SolverState) -> tuple[SolverState, Mask]:
        """Return corrected poses, and a mask (N,): True where the loops are closed and the record is valid."""
        N, solver = parts.shape[1], self._robot.solver
        first, good = np.zeros(N), np.ones(N, dtype=bool)
        for k in range(CORRECTIONS if self._constants.changing.size else 0):
            outputs, holds = self._evaluated(self._nominal, _CLOSING, parts, poses)
            open_by = np.max(np.abs(outputs["residual"]), axis=0, initial=0.0)
            first = open_by if k == 0 else first
            good = np.broadcast_to(holds, N) & (open_by <= OPEN * first + 1e-10)
            step = -least_squares(outputs["gradient"], outputs["residual"][:, None], self._prescribed.local_dofs)[:, 0]
            poses = solver.advance(self._prescribed, poses, step)
            if np.max(np.abs(step), initial=0.0) <= ROUNDING:
                break
        return poses, good

    def _evaluated(
        self, record: PoseRecord, names: Sequence[str], parts: Array, poses: SolverState
    ) -> tuple[dict[str, Array], Mask]:
        """Return outputs (…, N) of a record, and a mask (N,): True where the record is valid."""
        N, rows, holds, tape = parts.shape[1], record.all_rows(names), record.holds[names[-1]], record.tape
        needed = needed_by(tape, [*rows, holds])
        which = [step[1] for step, is_needed in zip(tape.operations, needed, strict=True) if is_needed and step[0] == "parameter"]
        given = (self._derivatives.load, self._derivatives.gravity, self._derivatives.target)
        load, gravity, target = (np.repeat(array, N, axis=1) for array in given)
        results = values(tape, needed, [poses.x, load, gravity, poses.c, target], self._constants.at(parts, which))
        outputs = {
            name: np.array([np.broadcast_to(results[row], N) for row in record.rows[name]]).reshape(*record.shapes[name], N)
            for name in names
        }
        return outputs, results[holds]


def _batches(N: int) -> list[slice]:
    return [slice(first, min(first + BATCH, N)) for first in range(0, N, BATCH)]
