"""One pose of thousands of robots that differ a little, by one record of their loops and one of their equilibrium.

The numbers that a record takes are inputs of it, so that every robot is a column of one batch. What they are of a robot follows
from a few that are made in full, each with one change of another size, by interpolation of their logarithms, which suits products
of powers, as 1/(EI) is one. Loops are closed by Newton's method and equilibrium is solved for each robot by itself.

Records are evaluated by NumPy, an operation for all robots at a time. Compiled code would save nothing: with 10,000 robots of the
3RPS, the 2PRU-UPR and ANYmal (4, 3 and 28 parameters) that takes 0.3, 0.3 and 1.3 s of 2.0, 1.3 and 15 s of processor, compiling
the equilibrium alone 0.2, 0.25 and 0.9 s. Nearly all else goes into robots that are made in full, several for each parameter.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping, Sequence

import numpy as np

from kinetostatics.analysis import analyze
from kinetostatics.argument_checks import Keyword
from kinetostatics.description.robot import RobotDescription
from kinetostatics.design.sensitivities import numbers_of
from kinetostatics.engine import loop_record
from kinetostatics.engine.derivatives import values
from kinetostatics.engine.llvm import needed_by
from kinetostatics.engine.outputs import OutputRecord, output_record
from kinetostatics.engine.outputs import structure_of as statics_structure
from kinetostatics.engine.programs import loops_for
from kinetostatics.engine.record import recorded_input
from kinetostatics.engine.recorder import recording
from kinetostatics.engine.scalars import Tape
from kinetostatics.engine.structure import Structure
from kinetostatics.exceptions import ArgumentError, KinetostaticsError
from kinetostatics.functions.derivatives import Derivatives
from kinetostatics.kinematics.solver import Solver, SolverState
from kinetostatics.math.arrays import Array, Mask, Values
from kinetostatics.math.linalg import least_squares
from kinetostatics.mechanism.tree import Frames
from kinetostatics.parametric.errors import AssemblyError, together
from kinetostatics.parametric.numbers import Number
from kinetostatics.parametric.rates import OTHER_MECHANISM, varied_robot
from kinetostatics.parametric.robot import ParametricRobot, same_pose
from kinetostatics.printing.waiting import waiting
from kinetostatics.results.result import Result
from kinetostatics.results.tool_point import seen
from kinetostatics.robot import Robot

#: What is computed.
WANTED = ("twist", "stiffness", "actuator_forces")
#: Where robots are made in full, as parts of the largest change of a parameter, besides the nominal one.
NODES = (-1.0, -0.5, 0.5, 1.0)
#: Robots in one batch, and of how many ways of branching there are records at most.
BATCH, RECORDS = 1000, 6
#: Corrections by Newton's method at most, and the scaled size of those that are rounding.
CORRECTIONS, ROUNDING = 12, 1e-13
#: Part of the loops' opening by the changes that may stay: more stays where an overconstrained robot's loops do not close.
OPEN = 0.03
#: Samples of a batch that are analysed one by one too.
CHECKED = 3


def random_robots(
    nominal: Result,
    derivatives: Derivatives | None,
    family: ParametricRobot,
    numbers: Sequence[Number],
    errors: Sequence[AssemblyError],
    linear: Mapping[str, Array],
    values: Array,
    analysis: Mapping[str, Keyword],
    deviation: float,
    tool: Array | None,
) -> tuple[dict[str, Array], float]:
    """Return twist, stiffness and actuator forces (N, …) of robots, and how far those that are analysed one by one differ.

    Args:
        nominal: the analysis of the nominal robot.
        derivatives: of it; None: all robots are analysed one by one.
        family: the robots that there may be.
        numbers, errors: their parameters.
        linear: (errors, …) effects per unit of assembly errors, which are added: they change no other robot to first order.
        values: (numbers + errors, N) by how much everything is off.
        analysis: arguments of :func:`kinetostatics.analyze`.
        deviation: standard deviation of the displacement, the unit of the difference.
        tool: the point of the platform of twist and stiffness; None: o.
    """
    N, own = values.shape[1], numbers_of(nominal.configuration, nominal, tool, WANTED)
    by_numbers, by_errors = values[: len(numbers)], values[len(numbers) :]
    if not numbers:
        found = {name: np.broadcast_to(array, (N, *array.shape)) for name, array in own.items()}
    elif derivatives is None:
        found = {name: np.full((N, *array.shape), np.nan) for name, array in own.items()}
    else:
        with waiting(f"computing {N:,} robots"):
            made = ManyRobots(derivatives, family, numbers, np.max(np.abs(by_numbers), axis=1)).at(by_numbers)
        found = {name: np.moveaxis(array, -1, 0) for name, array in made.items()}
    found = {name: array + np.tensordot(by_errors.T, linear[name], 1) if errors else array for name, array in found.items()}
    is_lost = np.isnan(found["twist"][:, 0])
    checked = np.flatnonzero(~is_lost)[: CHECKED * bool(numbers)].tolist()
    lost, worst = np.flatnonzero(is_lost).tolist(), math.nan
    for done, k in enumerate([*checked, *lost]):
        with waiting(f"analysing robots one by one: {done} of {len(checked) + len(lost)}"), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                off = {item.name: float(by) for item, by in zip(numbers, by_numbers[:, k], strict=True)}
                one = _analysed(family.off(off), nominal, errors, by_errors[:, [k]], analysis, tool)
            except KinetostaticsError:  # there is no such robot
                continue
        if done < len(checked):
            apart = float(np.linalg.norm((one["twist"] - found["twist"][k])[:3]))
            worst = max(apart / deviation if deviation > 0 else 0.0, 0.0 if math.isnan(worst) else worst)
        else:
            for name, array in one.items():
                found[name][k] = array
    return found, worst


def _analysed(
    description: RobotDescription,
    nominal: Result,
    errors: Sequence[AssemblyError],
    amounts: Array,
    analysis: Mapping[str, Keyword],
    tool: Array | None,
) -> dict[str, Array]:
    """Return the quantities of one robot with assembly errors by amounts (errors, 1).

    Raises:
        KinetostaticsError: there is no such robot.
    """
    pose = same_pose(nominal.configuration, Robot(description), loops_for(analysis))
    found = numbers_of(pose, analyze(pose, **{**analysis, "on_failure": "nan"}), tool, WANTED)
    if errors:
        off = analyze(pose, **{**analysis, "assembly_errors": together(errors, amounts), "on_failure": "nan"})
        found["twist"] = found["twist"] + seen(off, tool).contributions["assembly_errors"][0]
        if "actuator_forces" in found:
            more = np.array([parts["assembly_errors"][0] for parts in off.actuator_contributions.values()])
            found["actuator_forces"] = found["actuator_forces"] + more
    return found


class Constants:
    """Numbers of robots that differ by several changes, from some at which only one is made.

    Args:
        nominal: (P,) of the nominal robot.
        nodes: for each change (len(NODES), P).
    """

    def __init__(self, nominal: Array, nodes: Sequence[Array]) -> None:
        self.nominal = nominal
        at = np.stack(nodes) if len(nodes) else np.zeros((0, len(NODES), nominal.size))
        self.changing = np.flatnonzero(np.any(at != nominal, axis=(0, 1)))
        at, own = at[..., self.changing], nominal[self.changing]
        with np.errstate(all="ignore"):
            ratios = at / own
            self._is_product = np.all((ratios > 0.2) & (ratios < 5), axis=(0, 1))
            self._rates = np.where(self._is_product, np.log(np.where(self._is_product, ratios, 1.0)), at - own)

    def at(self, parts: Array, which: Sequence[int]) -> dict[int, Array]:
        """Return the numbers (N,) of those constants of ``which`` that change.

        Args:
            parts: (changes, N) the changes, as parts of the largest.
            which: numbers of constants.
        """
        weights = _lagrange(parts)
        found = {}
        rows = np.flatnonzero(np.isin(self.changing, which))
        total = np.einsum("jkn,kjp->pn", weights, self._rates[..., rows], optimize=True)
        for row, change in zip(rows.tolist(), total, strict=True):
            own = self.nominal[self.changing[row]]
            found[int(self.changing[row])] = own * np.exp(change) if self._is_product[row] else own + change
        return found

    def of(self, parts: Array, which: Sequence[int]) -> list[float | Array]:
        """Return all numbers as a record takes them: one, or (N,) for those of ``which`` that change."""
        found: list[float | Array] = self.nominal.tolist()
        for number, row in self.at(parts, which).items():
            found[number] = row
        return found


def _lagrange(parts: Array) -> Array:
    """Return the weights (len(NODES), …) with which values at the nodes, zero at zero, count elsewhere."""
    nodes = (*NODES, 0.0)
    rows = []
    for k, node in enumerate(NODES):
        others = [other for j, other in enumerate(nodes) if j != k]
        rows.append(np.prod([(parts - other) / (node - other) for other in others], axis=0))
    return np.stack(rows)


class ManyRobots:
    """Robots that differ a little, at one pose.

    Args:
        derivatives: of the nominal robot's pose, a batch of one.
        robots: the robots that there may be.
        numbers: what may be different.
        reach: (numbers,) the largest amount of each.

    Raises:
        ArgumentError: with one of the changes the robot becomes another mechanism.
        NotRecordedError: something cannot be recorded.
    """

    def __init__(self, derivatives: Derivatives, robots: ParametricRobot, numbers: Sequence[Number], reach: Array) -> None:
        self._derivatives, self._robots, self._numbers, self._reach = derivatives, robots, numbers, reach
        self._robot: Robot = derivatives.robot
        self._prescribed = derivatives.prescribed
        self._local = self._robot.mobility_analysis.local_dofs(self._prescribed)
        own = self._parts(self._robot.description)
        nodes: list[list[Array]] = [[], []]
        for number, amount in zip(numbers, reach.tolist(), strict=True):
            try:
                found = [self._parts(number.changed(node * amount), own) for node in NODES]
            except KinetostaticsError as error:
                raise ArgumentError(f"{number.name} cannot be off by so much: {error}") from error
            for several, structures in zip(nodes, zip(*found, strict=True), strict=True):
                several.append(np.stack([item.values for item in structures]))
        self._statics, self._loops = (Constants(item.values, several) for item, several in zip(own, nodes, strict=True))
        self._record_loops()

    def _parts(self, description: RobotDescription, own: Sequence[Structure] = ()) -> tuple[Structure, Structure]:
        """Return what statics and loops of a robot are made of, as those of another one are.

        Raises:
            KinetostaticsError: there is no such robot, or it is another mechanism.
        """
        other, statics = varied_robot(self._robot, description, self._robot.statics)
        loops = loop_record.structure_of(self._solver(other), self._prescribed, self._local, all_vary=True)
        if own and loops.key != own[1].key:
            raise ArgumentError(OTHER_MECHANISM)
        return statics_structure(statics), loops

    def _solver(self, robot: Robot) -> Solver:
        return Solver(robot.equations, self._robot.length, self._robot.length)

    def _record_loops(self) -> None:
        """Record what closes the loops, and where everything is then."""
        self._tape = tape = Tape()
        example = self._derivatives.pose.poses
        structure = loop_record.structure_of(self._solver(self._robot), self._prescribed, self._local, tape, all_vary=True)
        copy: Solver = structure.copy[0]
        copy.forget()
        x, c, target = (
            recorded_input(tape, k, array) for k, array in enumerate((example.x, example.c, self._derivatives.target))
        )
        with recording():
            residual, gradient = copy.system(self._prescribed, SolverState(x, c), target)
            self._residual, self._gradient = _rows(tape, residual), _rows(tape, gradient)
            self._closing = tape.number_of(tape.holds())
            _, frames, _ = copy.equations.place(x)
            self._frames = _rows(tape, frames.rotation) + _rows(tape, frames.position)
            self._placing = tape.number_of(tape.holds())
        self._shape = gradient.shape[:2]

    def at(self, amounts: Array) -> dict[str, Array]:
        """Return twist, stiffness and actuator forces (…, N) of robots; NaN where no record holds, or where loops stay open.

        Args:
            amounts: (changes, N) by how much everything is off.
        """
        parts = amounts / self._reach[:, None]
        N, bodies = parts.shape[1], self._derivatives.pose.frames.position.shape[1]
        frames = np.empty((12 * bodies, N))
        good = np.ones(N, dtype=bool)
        for some in _batches(N):
            frames[:, some], good[some] = self._closed(parts[:, some])
        names = tuple(name for name in WANTED if name in self._derivatives.outputs)
        own = self._derivatives.pose.frames
        nominal = np.concatenate([own.rotation.reshape(-1, 1), own.position.reshape(-1, 1)])
        record = self._recorded(names, np.zeros(len(self._reach)), nominal)
        found = {name: np.full((*record.shapes[name], N), np.nan) for name in names}
        left = np.flatnonzero(good)
        for _ in range(RECORDS):
            holds = np.zeros(left.size, dtype=bool)
            for some in _batches(left.size):
                here = left[some]
                outputs, holds[some] = self._equilibrium(record, names, parts[:, here], frames[:, here])
                for name, array in outputs.items():
                    found[name][..., here] = np.where(holds[some], array, np.nan)
            left = left[~holds]
            if not left.size:
                break
            record = self._recorded(names, amounts[:, left[0]], frames[:, left[:1]])
        return found

    def _recorded(self, names: Sequence[str], amounts: Array, frames: Array) -> OutputRecord:
        """Return a record of one robot's equilibrium."""
        off = {item.name: float(by) for item, by in zip(self._numbers, amounts, strict=True)}
        _, statics = varied_robot(self._robot, self._robots.off(off), self._robot.statics)
        bodies = frames.shape[0] // 12
        rotation, position = frames[: 9 * bodies].reshape(3, 3, bodies, 1), frames[9 * bodies :].reshape(3, bodies, 1)
        example = Frames(rotation, position), self._derivatives.load, self._derivatives.gravity
        return output_record(statics, names, example, tool=self._derivatives.tool)

    def _closed(self, parts: Array) -> tuple[Array, Mask]:
        """Return the frames (12 B, N) of poses whose loops are closed, and which are."""
        N, tape, solver = parts.shape[1], self._tape, self._robot.solver
        nominal = self._derivatives.pose.poses
        poses = SolverState(np.repeat(nominal.x, N, axis=1), np.repeat(nominal.c, N, axis=1))
        target = np.repeat(self._derivatives.target, N, axis=1)
        wanted = [*self._residual, *self._gradient, self._closing]
        needed = needed_by(tape, wanted)
        constants = self._loops.of(parts, _parameters(tape, needed))
        first, good = np.zeros(N), np.ones(N, dtype=bool)
        if any(isinstance(item, np.ndarray) for item in constants):
            for k in range(CORRECTIONS):
                results = values(tape, needed, [poses.x, poses.c, target], constants)
                residual = _stacked(results, self._residual, N)
                gradient = _stacked(results, self._gradient, N).reshape(*self._shape, N)
                open_by = np.max(np.abs(residual), axis=0, initial=0.0)
                first = open_by if k == 0 else first
                good = np.broadcast_to(results[self._closing], N) & (open_by <= OPEN * first + 1e-10)
                step = -least_squares(gradient, residual[:, None], self._local)[:, 0]
                poses = solver.advance(self._prescribed, poses, step)
                if np.max(np.abs(step), initial=0.0) <= ROUNDING:
                    break
        needed = needed_by(tape, [*self._frames, self._placing])
        constants = self._loops.of(parts, _parameters(tape, needed))
        results = values(tape, needed, [poses.x, poses.c, target], constants)
        return _stacked(results, self._frames, N), good & results[self._placing]

    def _equilibrium(
        self, record: OutputRecord, names: Sequence[str], parts: Array, frames: Array
    ) -> tuple[dict[str, Array], Mask]:
        """Return outputs (…, N) of closed poses, and where the record holds."""
        N, bodies = parts.shape[1], frames.shape[0] // 12
        rows = [row for name in names for row in record.rows[name]]
        needed = needed_by(record.tape, [*rows, record.holds])
        constants = self._statics.of(parts, _parameters(record.tape, needed))
        load, gravity = (np.repeat(array, N, axis=1) for array in (self._derivatives.load, self._derivatives.gravity))
        results = values(record.tape, needed, [frames[: 9 * bodies], frames[9 * bodies :], load, gravity], constants)
        found = {name: _stacked(results, record.rows[name], N).reshape(*record.shapes[name], N) for name in names}
        return found, np.broadcast_to(results[record.holds], N)


def _batches(N: int) -> list[slice]:
    return [slice(first, min(first + BATCH, N)) for first in range(0, N, BATCH)]


def _rows(tape: Tape, array: Values) -> list[int]:
    """Return the operations that give the entries of an array (…, 1)."""
    return [tape.number_of(entry) for entry in np.asarray(array[..., 0], dtype=object).ravel().tolist()]


def _parameters(tape: Tape, needed: Sequence[bool]) -> list[int]:
    """Return the numbers of the constants that are needed."""
    return [item[1] for item, is_needed in zip(tape.operations, needed, strict=False) if is_needed and item[0] == "parameter"]


def _stacked(results: Sequence[float | Array], rows: Sequence[int], N: int) -> Array:
    return np.array([np.broadcast_to(results[row], N) for row in rows], dtype=float).reshape(len(rows), N)
