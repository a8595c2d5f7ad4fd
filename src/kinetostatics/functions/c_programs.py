"""Programs of an exported function: C functions with the recorded scalar operations of corrections, analyses and derivatives. A
pose has coordinates x of the tree of joints and orientation coordinates c of the platform. From pose to pose the robot follows a
line, along which all prescribed coordinates change in proportion. A program is valid at poses that meet its guards, the
conditions of the recorded branches.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from itertools import accumulate
from typing import Protocol

import numpy as np

from kinetostatics.compensation import BroydenSearch, ScaledCoordinates, arrival_tolerance, error_tolerance
from kinetostatics.engine.c_code import CProgram, c_program, literal
from kinetostatics.engine.loop_record import (
    Program,
    guards_met,
    newton_record,
    program_of,
    rates_record,
    side_record,
    start_record,
)
from kinetostatics.engine.pose_record import PoseModel, PoseRecord, example_of, pose_record
from kinetostatics.engine.record_derivatives import tangent_record
from kinetostatics.engine.recorder import Structure
from kinetostatics.engine.scalars import Tape
from kinetostatics.exceptions import ArgumentError
from kinetostatics.functions.c_names import c_names
from kinetostatics.functions.inputs_outputs import ALWAYS, LOADS, Quantity
from kinetostatics.kinematics.coordinates import PrescribedCoordinates
from kinetostatics.kinematics.path_following import longest_strides
from kinetostatics.kinematics.solver import SolverState
from kinetostatics.math.arrays import Array
from kinetostatics.math.rotations import Orientation, orientation_named
from kinetostatics.mechanism.tree import TreeJoint
from kinetostatics.results.compensation import loaded, pose_error, shift_of
from kinetostatics.robot import Robot

#: Arbitrary twist [m, rad] at which the search is recorded.
_TWIST = (1e-3, -2e-3, 3e-3, -4e-3, 5e-3, 6e-3)


class Exported(Protocol):
    """The function to be exported, see :class:`kinetostatics.functions.function.Function`."""

    robot: Robot
    orientation: str | None
    by_actuators: bool
    compensates: bool
    prescribed: PrescribedCoordinates
    names: list[str]
    inputs: Mapping[str, Quantity]
    outputs: Mapping[str, Quantity]

    @property
    def __call__(self) -> Callable[..., Mapping[str, Array]]:
        """Function that returns the outputs at given inputs."""


# ---- lines of coordinates ------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Line:
    """Programs that follow lines, for one set of prescribed coordinates.

    Attributes:
        prefix: prefix of the functions' names in C.
        newton: program of a correction by Newton's method.
        side: program of the test for a singular pose between two poses; None if some freedoms do not move the platform.
        start: program that chooses among equivalent coordinates at the start of a line, for instance angles that differ by full
            turns; None if no angles are prescribed.
        impose: C statements that write prescribed coordinates into ``x`` and ``c``.
        longest_steps: (n,) largest change of each coordinate in one step [m, rad].
    """

    prefix: str
    prescribed: PrescribedCoordinates
    newton: CProgram
    side: CProgram | None
    start: CProgram | None
    impose: tuple[str, ...]
    longest_steps: Array


def line_of(robot: Robot, given: PrescribedCoordinates, prefix: str = "") -> Line:
    prescribed = robot.mobility_analysis.with_dofs(given)
    what = robot.solver, prescribed, example_at(robot, prescribed)
    numbers = Structure((robot.solver, prescribed)).values

    def program(name: str, record: Program, *inputs: str) -> CProgram:
        return c_program(f"{prefix}{name}", record.tape, (*record.numbers, *record.truths), numbers, inputs)

    newton = program("newton", newton_record(*what), "state", "given")
    side = None if prescribed.local_dofs else program("side", side_record(*what), "x1", "c1", "x2", "c2")
    start = program("line", start_record(*what), "x", "c", "aim", "shorter") if prescribed.angles else None
    impose = tuple(_imposed(robot, prescribed))
    return Line(prefix, prescribed, newton, side, start, impose, longest_strides(robot.solver, prescribed))


def example_at(robot: Robot, prescribed: PrescribedCoordinates) -> SolverState:
    """Return the pose at which programs are recorded."""
    generic = robot.generic_poses.take(np.array([0]))
    return SolverState(generic.x, robot.solver.origin(prescribed, generic)[1])


def _imposed(robot: Robot, prescribed: PrescribedCoordinates) -> Iterator[str]:
    """Yield the C statements that write prescribed coordinates into x and c; see :meth:`Solver.impose`."""
    for row, column in enumerate(prescribed.columns):
        yield from _written(robot.solver.joint_of_column[column], f"target[{row}]")
    for coupling in robot.equations.couplings.items:
        if coupling.leader.first_v in prescribed.columns:
            row = prescribed.columns.index(coupling.leader.first_v)
            expression = f"({literal(coupling.multiplier)} * target[{row}] + {literal(coupling.offset)})"
            yield from _written(coupling.follower, expression)
    for row, k in enumerate(prescribed.angles):
        yield f"c[{k}] = target[{prescribed.first_angle + row}];"


def _written(joint: TreeJoint, value: str) -> Iterator[str]:
    if joint.type.endless:
        yield f"x[{joint.first_q}] = cos({value});"
        yield f"x[{joint.first_q + 1}] = sin({value});"
    else:
        yield f"x[{joint.first_q}] = {value};"


# ---- derivatives ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class CJacobian:
    """Derivatives of outputs with respect to inputs.

    Attributes:
        rates: program for the derivatives of x with respect to each prescribed coordinate, from x and c; its last result is
            whether all guards are met.
        tangent: program for the rates of outputs, from x, load, gravity and their rates.
        at: for each output, the index of its first rate among the results of ``tangent``.
        pairs: for each derivative, the output, the input, and the name of the field in C.
    """

    rates: CProgram
    tangent: CProgram
    at: Mapping[str, int]
    pairs: Sequence[tuple[Quantity, Quantity, str]]


def _jacobian(
    line: Line, robot: Robot, record: PoseRecord, numbers: Array, pairs: Sequence[tuple[Quantity, Quantity, str]]
) -> CJacobian:
    """Return the programs for derivatives; operations are added to ``record``, the record of the outputs."""
    what = robot.solver, line.prescribed, example_at(robot, line.prescribed)
    rates, constants = rates_record(*what), Structure((robot.solver, line.prescribed)).values
    names = list(dict.fromkeys(output.name for output, *_ in pairs))
    inputs = ("x", *LOADS)
    tangent = tangent_record(record.tape, record.all_rows(names), len(inputs))
    return CJacobian(
        c_program("rates", rates.tape, (*rates.numbers, *rates.truths), constants, ("x", "c")),
        c_program("tangent", record.tape, tangent, numbers, (*inputs, *(f"d_{name}" for name in inputs))),
        dict(zip(names, accumulate((len(record.rows[name]) for name in names), initial=0), strict=False)),
        pairs,
    )


def _pairs(
    function: Exported, fields_of: Mapping[str, str], of: Sequence[str], by: Sequence[str]
) -> list[tuple[Quantity, Quantity, str]]:
    """Return for each derivative the output, the input, and the name of the field in C.

    Raises:
        ArgumentError: a derivative is with respect to a parameter, not an input.
    """
    for name in by:
        if name not in function.inputs:
            raise ArgumentError(f"derivatives by {name!r} cannot be exported, only those by inputs: {', '.join(function.inputs)}")
    return [(function.outputs[a], function.inputs[b], f"{a}_by_{fields_of.get(b, b)}") for a in of for b in by]


# ---- the search for corrected positions of the actuators -----------------------------------------------------------------


@dataclass(frozen=True)
class SearchPrograms:
    """Programs for the search of :func:`kinetostatics.compensate` at one pose.

    The state of the search is a vector of numbers; a frame has 12 numbers: the platform's rotation matrix, row by row, and
    position. The last result of each program is whether all guards are met.

    Attributes:
        begin: program for the initial state, from the platform's frame and twist.
        update: program for the next state, from a state, the frame and the twist.
        remaining: program for the residual error, from the target frame, the frame and the twist.
        correct: program for the commanded actuator coordinates, from the coordinates at the target and at the pose found.
        numbers: number of entries of a state; the commanded coordinates are first.
        tolerance: largest error [m] with which the search succeeds.
        arrival_tolerance: largest error [m] of the pose to which the commanded actuator coordinates lead.
        first_error: index of the first error in a state.
        errors: number of errors in a state.
        largest_error: index of the largest error in a state.
        continues: index in a state of the flag "continue the search".
    """

    begin: CProgram
    update: CProgram
    remaining: CProgram
    correct: CProgram
    numbers: int
    tolerance: float
    arrival_tolerance: float
    first_error: int
    errors: int
    largest_error: int
    continues: int


def search_programs(robot: Robot, names: Sequence[str], orientation: Orientation) -> SearchPrograms:
    controlled, least = ScaledCoordinates(names, orientation, robot.length), error_tolerance(robot.length)
    actuated = robot.description.actuated
    R, o = robot.mechanism.platform_pose(robot.statics.example)
    platform, twist, n = np.concatenate([R.reshape(9, 1), o]), np.array([_TWIST]).T, len(names)

    def begun(frame: Array, twist: Array) -> list[Array]:
        pose = _pose(frame)
        target, angles = controlled.of(pose), orientation.coordinates(pose[0])
        error = controlled.of(loaded(*pose, twist), angles) - target
        return _flat(controlled, target, angles, BroydenSearch.started(target, np.eye(n)[:, :, None], error))

    def updated(state: Array, frame: Array, twist: Array) -> list[Array]:
        target, angles, search = _unflat(state, n)
        error = controlled.of(loaded(*_pose(frame), twist), angles) - target
        return _flat(controlled, target, angles, search.updated(error, least))

    def remaining(target: Array, frame: Array, twist: Array) -> list[Array]:
        return [pose_error(_pose(target), loaded(*_pose(frame), twist))]

    def corrected(before: Array, reached: Array) -> list[Array]:
        slides = [robot.mechanism.connections[name].type.is_slide for name in actuated]
        return [before[k] + shift_of(before[k], reached[k], slide) for k, slide in enumerate(slides)]

    first = np.concatenate([np.reshape(array, (-1, 1)) for array in begun(platform, twist)])
    drives = np.zeros((len(actuated), 1))
    return SearchPrograms(
        array_program("begin", {"frame": platform, "twist": twist}, begun),
        array_program("update", {"state": first, "frame": platform, "twist": twist}, updated),
        array_program("remaining", {"target": platform, "frame": platform, "twist": twist}, remaining),
        array_program("correct", {"target": drives, "found": drives}, corrected),
        len(first),
        least,
        arrival_tolerance(robot),
        len(first) - 3 - n,
        n,
        len(first) - 3,
        len(first) - 1,
    )


def array_program(name: str, examples: Mapping[str, Array], computed: Callable[..., Sequence[Array]]) -> CProgram:
    """Return the program of a function of arrays (k, 1), recorded at examples; its last result is whether all guards are met."""
    tape = Tape()
    record = program_of(tape, [*examples.values()], lambda *inputs: [*computed(*inputs), guards_met(tape)])
    return c_program(name, tape, (*record.numbers, *record.truths), np.array([]), tuple(examples))


def _pose(frame: Array) -> tuple[Array, Array]:
    return frame[:9].reshape(3, 3, 1), frame[9:]


def _flat(controlled: ScaledCoordinates, target: Array, angles: Array, search: BroydenSearch) -> list[Array]:
    """Return the state of the search as numbers: commanded coordinates, targets, all angles, state of Broyden's method."""
    parts = [getattr(search, field.name) for field in fields(search)]
    return [search.u / controlled.scale, target, angles, *parts[:-1], np.where(search.going, 1.0, 0.0)]


def _unflat(numbers: Array, n: int) -> tuple[Array, Array, BroydenSearch]:
    """Return targets, angles and the state of Broyden's method from the numbers of :func:`_flat`."""
    _, target, angles, u, step, inverse, error, size, stale, going = np.split(numbers, np.cumsum([n, n, 3, n, n, n * n, n, 1, 1]))
    search = BroydenSearch(u, step, inverse.reshape(n, n, 1), error, size[0], stale[0], going[0] != 0)
    return target, angles, search


# ---- all together --------------------------------------------------------------------------------------------------------


class Programs:
    """All programs of a function.

    Attributes:
        coordinates: inputs of the function besides load and gravity.
        limits: finite limits of the actuators' coordinates [m, rad], by name.
        efforts: limits of effort [N, N·m] by number of the actuator, if the forces of actuators are among the outputs.
        outputs: the requested outputs that are not empty.
        c_names: names of the coordinates in C.
        line: programs for lines in the function's coordinates.
        drives: programs for lines in actuator coordinates, if compensation is requested.
        pose: program for outputs and truth values, from x, load and gravity.
        at: for each output, the index of its first result; for "holds", the index of the result "all guards are met".
        jacobian: programs for derivatives, if requested.
        search: programs for compensation, if requested.
        order: for each actuator in the order of the file, its index among the coordinates of ``drives``.
        start: x, c and coordinates of the initial state.
        at_start: the coordinates of the initial state, by name.
        from_zero: whether the initial state is the zero pose.
    """

    def __init__(self, function: Exported, begin: SolverState, jacobian: tuple[Sequence[str], Sequence[str]] | None) -> None:
        robot, compensates = function.robot, function.compensates
        if compensates and {"azimuth", "tilt"} <= set(function.names):
            raise ArgumentError("azimuth and tilt cannot be exported together with compensation: use the orientation XYZ")
        self.function = function
        self.outputs = [quantity for name, quantity in function.outputs.items() if name not in ALWAYS and 0 not in quantity.shape]
        self.coordinates = [quantity for name, quantity in function.inputs.items() if name not in LOADS]
        self.c_names = c_names(quantity.name for quantity in self.coordinates)
        connections = ((name, robot.mechanism.connections[name]) for name in robot.description.actuated)
        limits = {name: (connection.lower, connection.upper) for name, connection in connections}
        self.limits = {name: both for name, both in limits.items() if np.all(np.isfinite(both))}
        efforts = robot.description.actuator_limits("effort") if "actuator_forces" in function.outputs else {}
        self.efforts = {k: efforts[name] for k, name in enumerate(robot.description.actuated) if name in efforts}
        self.line = line_of(robot, function.prescribed)
        requested = [quantity.name for quantity in self.outputs if quantity.name != "residual_error"]
        more = ("twist", "actuators", "platform", "within") if compensates else ()
        names = list(dict.fromkeys((*requested, *more, "worst_equation", "singular", "usual")))
        model = PoseModel.of(robot.solver, robot.statics, self.line.prescribed)
        example = robot.generic_poses.x[:, :1], *example_of(robot.statics)[1:]
        record, numbers = pose_record(model, names, example), model.structure().values
        rows = (*record.all_rows(), record.all_hold())
        self.pose = c_program("analysis", record.tape, rows, numbers, ("x", *LOADS))
        self.at = dict(zip((*names, "holds"), accumulate((len(record.rows[name]) for name in names), initial=0), strict=True))
        self.jacobian = None
        if jacobian is not None:
            of, by = jacobian
            self.jacobian = _jacobian(self.line, robot, record, numbers, _pairs(function, self.c_names, of, by))
        first, c = robot.solver.origin(self.line.prescribed, begin)
        self.start = begin.x[:, 0], c[:, 0], first[:, 0]
        self.from_zero = begin is robot.zero_poses
        values = robot.solver.values(function.prescribed, begin)[:, 0].tolist()
        self.at_start = {name: round(value, 9) or 0.0 for name, value in zip(function.names, values, strict=True)}
        names = robot.actuator_names
        self.order = [names.index(name) for name in robot.description.actuated]
        self.search = self.drives = None
        if compensates:
            self.search = search_programs(robot, function.names, orientation_named(function.orientation))
            self.drives = line_of(robot, robot.actuator_coordinates, "actuated_")

    @property
    def all(self) -> list[tuple[str, CProgram]]:
        """Descriptions and programs, in the order of the source file."""
        programs: list[tuple[str, CProgram | None]] = []
        for line, given in ((self.line, ""), (self.drives, ", actuators given")):
            if line is not None:
                programs += [("start of a line", line.start), (f"correction of the loops{given}", line.newton)]
                programs += [(f"test for singular poses{given}", line.side)]
        programs.append(("frames, statics, actuators", self.pose))
        if self.search is not None:
            programs += [("start of the search", self.search.begin), ("step of the search", self.search.update)]
            programs += [("residual error", self.search.remaining), ("actuator coordinates", self.search.correct)]
        if self.jacobian is not None:
            programs += [("derivatives: coordinates", self.jacobian.rates), ("derivatives: results", self.jacobian.tangent)]
        return [(what, program) for what, program in programs if program is not None]

    @property
    def work(self) -> int:
        """Length of the largest work array."""
        return max(program.work for _, program in self.all)
