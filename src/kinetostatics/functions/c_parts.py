"""The programs of a function in C: records of what closes the loops, of the frames and of the statics."""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Protocol

import numpy as np

from kinetostatics.engine.c_code import CProgram, c_program, literal
from kinetostatics.engine.loop_record import (
    Program,
    actuators_record,
    line_record,
    newton_record,
    place_record,
    side_record,
    structure_of,
)
from kinetostatics.engine.outputs import output_record
from kinetostatics.engine.outputs import structure_of as statics_structure_of
from kinetostatics.engine.record import example_of
from kinetostatics.exceptions import ArgumentError
from kinetostatics.functions.c_jacobian import jacobian_programs, pairs_of
from kinetostatics.functions.c_search import search_programs
from kinetostatics.functions.values import ALWAYS, LOADS, Quantity
from kinetostatics.kinematics.joint_coordinates import actuator_names
from kinetostatics.kinematics.lines import longest_strides
from kinetostatics.kinematics.prescribed import PrescribedCoordinates
from kinetostatics.kinematics.solver import SolverState
from kinetostatics.math.arrays import Array
from kinetostatics.math.orientation import orientation_named
from kinetostatics.mechanism.tree import TreeJoint
from kinetostatics.robot import Robot

#: What Python returns that the C code does not.
_NOT_IN_C = ("contributions",)
#: Outputs that are no results of the statics.
_NOT_OF_STATICS = ("actuators", "remaining")


class Exported(Protocol):
    """What is exported: a function, see :class:`kinetostatics.functions.function.Function`."""

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
        """Return the outputs."""


def asked_outputs(function: Exported) -> list[Quantity]:
    """Return the outputs that were asked for."""
    return [item for name, item in function.outputs.items() if name not in ALWAYS]


def identifier(name: str) -> str:
    """Return a name as one that may stand alone in C."""
    found = re.sub(r"\W", "_", name, flags=re.ASCII)
    return f"robot_{found}" if not found or found[0].isdigit() else found


def c_name(name: str) -> str:
    """Return the name of a coordinate as that of a member of a struct in C."""
    return identifier(name) if name[0].isdigit() else re.sub(r"\W", "_", name)


class Parts:
    """All programs of a function.

    Attributes:
        c_names: names of the coordinates in C.
    """

    def __init__(self, function: Exported, begin: SolverState, jacobian: tuple[Sequence[str], Sequence[str]] | None) -> None:
        robot = function.robot
        self.outputs = asked_outputs(function)
        for item in self.outputs:
            if item.name in _NOT_IN_C:
                raise ArgumentError(f"{item.name!r} is not exported: leave it out of the outputs")
        if function.compensates and {"azimuth", "tilt"} <= set(function.names):
            raise ArgumentError(
                "azimuth and tilt are not exported together with compensation, which goes by two turns instead: take XYZ"
            )
        prescribed = robot.mobility_analysis.without_idle_dofs(function.prescribed)
        self.prescribed, self.local = prescribed, robot.mobility_analysis.local_dofs(prescribed)
        solver = robot.solver
        generic = robot.generic_poses.take(np.array([0]))
        example = SolverState(generic.x, solver.origin(prescribed, generic)[1])
        self.nx, self.nt = generic.x.shape[0], prescribed.size
        constants = structure_of(solver, prescribed, self.local).values
        self.newton = _of_program("newton", newton_record(solver, prescribed, example, self.local), constants, ("state", "given"))
        self.line = None
        if prescribed.angles:
            line = line_record(prescribed, solver.values(prescribed, example), example.c)
            self.line = _of_program("line", line, np.zeros(0), ("first", "angles", "aim", "shorter"))
        self.side = None
        if not self.local:
            side = side_record(solver, prescribed, example, self.local)
            self.side = _of_program("side", side, constants, ("x1", "c1", "x2", "c2"))
        given = robot.actuator_coordinates
        actuators = actuators_record(solver, given, example)
        self.actuators = _of_program("actuators", actuators, structure_of(solver, given, 0).values, ("x",))
        order = actuator_names(robot.mechanism, robot.equations)
        self.actuator_order = [order.index(name) for name in robot.description.driven]
        # the statics, and of the frames what they take
        asked = [item.name for item in self.outputs if item.name not in _NOT_OF_STATICS]
        if function.compensates and "twist" not in asked:
            asked.append("twist")
        record = output_record(robot.statics, [*asked, "singular"], example_of(robot.statics), all_vary=False)
        numbers = statics_structure_of(robot.statics, all_vary=False).values
        wanted = [row for name in asked for row in record.rows[name]]
        self.rows = {name: len(record.rows[name]) for name in asked}
        bodies, nq, self.closures = robot.mechanism.tree.bodies, robot.mechanism.tree.nq, robot.equations.closures
        placed = place_record(solver, prescribed, example, self.local)
        self.frame_numbers = 12 * bodies
        self.frames = _of_program("frames", replace(placed, numbers=placed.numbers[nq:]), constants, ("x",))
        self.statics = c_program(
            "statics",
            record.tape,
            [*wanted, record.rows["singular"][0], record.holds],
            numbers,
            ("frames", "load", "gravity"),
            (("frames", 0), ("frames", 9 * bodies), ("load", 0), ("gravity", 0)),
        )
        self.c_names = {name: c_name(name) for name in function.inputs if name not in LOADS}
        self.jacobian = None
        if jacobian is not None:
            pairs = pairs_of(function.outputs, function.inputs, self.c_names, *jacobian)
            self.jacobian = jacobian_programs(robot, prescribed, example, self.local, record, numbers, pairs)
        self.strides = longest_strides(solver, prescribed)
        first, c0 = solver.origin(prescribed, begin)
        self.start = begin.x[:, 0], c0[:, 0], first[:, 0]
        self.search = None
        if function.compensates:
            convention = orientation_named(function.orientation)
            self.search = search_programs(robot, function.names, convention, order)
        self.impose = list(_imposed(function))

    @property
    def programs(self) -> list[CProgram]:
        """All programs, in the order in which they are written."""
        found = [
            item for item in (self.line, self.newton, self.side, self.actuators, self.frames, self.statics) if item is not None
        ]
        more = [item.programs for item in (self.search, self.jacobian) if item is not None]
        return [*found, *itertools.chain(*more)]

    @property
    def work(self) -> int:
        """Numbers in the largest work array."""
        return max(item.work for item in self.programs)

    @property
    def operations(self) -> int:
        """How many operations are done behind the closing of the loops."""
        return self.actuators.operations + self.frames.operations + self.statics.operations


def _of_program(name: str, program: Program, constants: Array, inputs: tuple[str, ...]) -> CProgram:
    return c_program(name, program.tape, (*program.numbers, *program.truths), constants, inputs)


def _imposed(function: Exported) -> Iterator[str]:
    """Yield lines of C that write given coordinates into x and c; see :meth:`Solver.impose`."""
    robot = function.robot
    solver, prescribed = robot.solver, function.prescribed
    for row, column in enumerate(prescribed.columns):
        yield from _written(solver.joint_of_column[column], f"target[{row}]")
    for item in robot.equations.couplings.items:
        if item.leader.first_v in prescribed.columns:
            row = prescribed.columns.index(item.leader.first_v)
            yield from _written(item.follower, f"({literal(item.multiplier)} * target[{row}] + {literal(item.offset)})")
    for row, k in enumerate(prescribed.angles):
        yield f"c[{k}] = target[{prescribed.first_angle + row}];"


def _written(joint: TreeJoint, value: str) -> Iterator[str]:
    if joint.type.endless:
        yield f"x[{joint.first_q}] = cos({value});"
        yield f"x[{joint.first_q + 1}] = sin({value});"
    else:
        yield f"x[{joint.first_q}] = {value};"
