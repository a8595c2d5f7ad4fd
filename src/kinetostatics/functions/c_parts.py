"""The programs of a function in C: records of what closes the loops, of the frames and of the statics."""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Protocol

from kinetostatics.engine.c_code import CProgram, c_program
from kinetostatics.engine.loop_record import actuators_record, place_record, structure_of
from kinetostatics.engine.outputs import output_record
from kinetostatics.engine.outputs import structure_of as statics_structure_of
from kinetostatics.engine.record import example_of as example_of_statics
from kinetostatics.exceptions import ArgumentError
from kinetostatics.functions.c_jacobian import jacobian_programs, pairs_of
from kinetostatics.functions.c_lines import example_of, line_of, of_program
from kinetostatics.functions.c_search import search_programs
from kinetostatics.functions.values import ALWAYS, LOADS, Quantity
from kinetostatics.kinematics.joint_coordinates import actuator_names
from kinetostatics.kinematics.prescribed import PrescribedCoordinates
from kinetostatics.kinematics.solver import SolverState
from kinetostatics.math.arrays import Array
from kinetostatics.math.orientation import orientation_named
from kinetostatics.robot import Robot

#: Outputs that are no results of the statics.
_NOT_OF_STATICS = ("actuators", "residual_error")


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


#: Those of C99 and C++17.
_KEYWORDS = frozenset(
    "alignas alignof and and_eq asm auto bitand bitor bool break case catch char class compl const const_cast constexpr "
    "continue decltype default delete do double dynamic_cast else enum explicit export extern false float for friend "
    "goto if inline int long mutable namespace new noexcept not not_eq nullptr operator or or_eq private protected "
    "public register reinterpret_cast restrict return short signed sizeof static static_assert static_cast struct switch "
    "template this thread_local throw true try typedef typeid typename union unsigned using virtual void volatile "
    "wchar_t while xor xor_eq".split()
)


def asked_outputs(function: Exported) -> list[Quantity]:
    """Return the outputs that were asked for, but for those that have no entries."""
    return [item for name, item in function.outputs.items() if name not in ALWAYS and 0 not in item.shape]


def identifier(name: str) -> str:
    """Return a name as one that may stand alone in C."""
    found = re.sub(r"\W", "_", name, flags=re.ASCII)
    return f"robot_{found}" if not found or found[0].isdigit() else found


def c_names(names: Iterable[str]) -> dict[str, str]:
    """Return the names of coordinates as those of members of a struct in C and C++, which are no keywords, and all different."""
    found: dict[str, str] = {}
    for name in names:
        mine = identifier(name) if name[0].isdigit() else re.sub(r"\W", "_", name)
        while mine in _KEYWORDS or mine in found.values():
            mine += "_"
        found[name] = mine
    return found


class Parts:
    """All programs of a function.

    Attributes:
        c_names: names of the coordinates in C.
        line: what follows lines of the function's coordinates; ``drives`` those of the actuators, where it compensates.
    """

    def __init__(self, function: Exported, begin: SolverState, jacobian: tuple[Sequence[str], Sequence[str]] | None) -> None:
        robot = function.robot
        self.outputs = asked_outputs(function)
        if function.compensates and {"azimuth", "tilt"} <= set(function.names):
            raise ArgumentError(
                "azimuth and tilt are not exported together with compensation, which goes by two turns instead: take XYZ"
            )
        self.line = line_of(robot, function.prescribed)
        prescribed, solver = self.line.prescribed, robot.solver
        example = example_of(robot, prescribed)
        self.nx, self.nt = example.x.shape[0], prescribed.size
        given = robot.actuator_coordinates
        actuators = actuators_record(solver, given, example)
        self.actuators = of_program("actuators", actuators, structure_of(solver, given, self.line.local).values, ("x",))
        order = actuator_names(robot.mechanism, robot.equations)
        self.actuator_order = [order.index(name) for name in robot.description.driven]
        # the statics, and of the frames what they take
        asked = [item.name for item in self.outputs if item.name not in _NOT_OF_STATICS]
        if function.compensates and "twist" not in asked:
            asked.append("twist")
        record = output_record(robot.statics, [*asked, "singular", "usual"], example_of_statics(robot.statics), all_vary=False)
        numbers = statics_structure_of(robot.statics, all_vary=False).values
        wanted = [row for name in asked for row in record.rows[name]]
        self.rows = {name: len(record.rows[name]) for name in asked}
        bodies, nq, self.closures = robot.mechanism.tree.bodies, robot.mechanism.tree.nq, robot.equations.closures
        placed = place_record(solver, prescribed, example, self.line.local)
        self.frame_numbers = 12 * bodies
        placed = replace(placed, numbers=placed.numbers[nq:])
        self.frames = of_program("frames", placed, self.line.constants, ("x",))
        self.statics = c_program(
            "statics",
            record.tape,
            [*wanted, record.rows["singular"][0], record.holds, record.rows["usual"][0]],
            numbers,
            ("frames", "load", "gravity"),
            (("frames", 0), ("frames", 9 * bodies), ("load", 0), ("gravity", 0)),
        )
        self.c_names = c_names(name for name in function.inputs if name not in LOADS)
        self.jacobian = None
        if jacobian is not None:
            pairs = pairs_of(function.outputs, function.inputs, self.c_names, *jacobian)
            self.jacobian = jacobian_programs(robot, prescribed, example, self.line.local, record, numbers, pairs)
        first, c0 = solver.origin(prescribed, begin)
        self.start = begin.x[:, 0], c0[:, 0], first[:, 0]
        self.search = self.drives = None
        if function.compensates:
            convention = orientation_named(function.orientation)
            self.search = search_programs(robot, function.names, convention, order)
            self.drives = line_of(robot, robot.actuator_coordinates, "driven_")

    @property
    def programs(self) -> list[CProgram]:
        """All programs, in the order in which they are written."""
        lines = [self.line, *([] if self.drives is None else [self.drives])]
        found = [item for line in lines for item in line.programs] + [self.actuators, self.frames, self.statics]
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
