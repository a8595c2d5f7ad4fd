"""A function of a robot as C for controllers: records in C, and around them what follows a line and tells the status."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from kinetostatics.argument_checks import check_choice, path_name
from kinetostatics.engine.c_code import CProgram, c_program, literal
from kinetostatics.engine.loop_record import Program, drives_record, newton_record, place_record, side_record, structure_of
from kinetostatics.engine.outputs import output_record
from kinetostatics.engine.outputs import structure_of as statics_structure_of
from kinetostatics.engine.record import example_of
from kinetostatics.engine.scalars import NotRecordedError
from kinetostatics.exceptions import ArgumentError
from kinetostatics.functions import c_texts
from kinetostatics.functions.values import ALWAYS, LOADS, Quantity
from kinetostatics.kinematics.lines import longest_strides
from kinetostatics.kinematics.solver import MOST_CORRECTIONS, SHRINKING, PrescribedCoordinates, SolverState
from kinetostatics.math.arrays import Array
from kinetostatics.robot import Robot
from kinetostatics.status import WITHOUT_NUMBERS

#: Types of arguments and results.
SCALARS = ("double", "float")
#: Reference poses that the test program has.
REFERENCES = 40
#: What Python returns that the C code does not.
_NOT_IN_C = ("contributions",)


class Exported(Protocol):
    """What is exported: a function, see :class:`kinetostatics.functions.function.Function`."""

    robot: Robot
    orientation: str | None
    by_drives: bool
    prescribed: PrescribedCoordinates
    names: list[str]
    inputs: Mapping[str, Quantity]
    outputs: Mapping[str, Quantity]

    def __call__(self, **inputs: Any) -> Mapping[str, Any]:
        """Return the outputs."""


@dataclass(frozen=True)
class CExport:
    """What was written.

    Attributes:
        folder: where.
        files: names of the files.
        name: what all names in C begin with.
        operations: of a correction of the loops, and of everything behind it.
        work: bytes on the stack besides what the compiler adds.
    """

    folder: Path
    files: tuple[str, ...]
    name: str
    operations: tuple[int, int]
    work: int


def export_c(function: Exported, folder: str | os.PathLike[str], scalar: str = "double", name: str | None = None) -> CExport:
    """Write a function of a robot as C99: no heap, nothing but libm, bounded iterations, all state passed in.

    Args:
        function: from :func:`kinetostatics.compile`.
        folder: where the files go; it is made if there is none.
        scalar: "double" or "float", the type of arguments and results; inside everything is computed in double.
        name: what all names in C begin with; default: the robot's.

    Raises:
        ArgumentError: the robot or the orientation cannot be exported, the scalar is none of the two, or the folder is a file.
        OSError: a file cannot be written.
    """
    check_choice("scalar", scalar, SCALARS)
    where = Path(path_name("folder", folder))
    if where.exists() and not where.is_dir():
        raise ArgumentError(f"{where} is a file: the C code takes a folder")
    own = identifier(function.robot.name if name is None else name)
    try:
        parts = _Parts(function)
    except NotRecordedError as error:
        raise ArgumentError(f"{function.robot.name!r} cannot be exported: {error}") from error
    texts = c_texts.files(own, scalar, _facts(function, parts), _references(function, REFERENCES))
    where.mkdir(parents=True, exist_ok=True)
    for file, text in texts.items():
        (where / file).write_text(text, encoding="utf-8")
    return CExport(where, tuple(texts), own, (parts.newton.operations, parts.operations), 8 * parts.work)


def identifier(name: str) -> str:
    """Return a name as C takes it."""
    found = re.sub(r"\W", "_", name, flags=re.ASCII)
    return f"robot_{found}" if not found or found[0].isdigit() else found


class _Parts:
    """All programs of a function."""

    def __init__(self, function: Exported) -> None:
        robot = function.robot
        self.outputs = _asked(function)
        for item in self.outputs:
            if item.name in _NOT_IN_C:
                raise ArgumentError(f"{item.name!r} is not exported: leave it out of the outputs")
        if function.orientation == "tilt_torsion":
            raise ArgumentError(
                "tilt_torsion is not exported, as azimuth means nothing where the tilt is 0: take another orientation"
            )
        prescribed = robot.mobility_analysis.without_idle_dofs(function.prescribed)
        self.prescribed, self.local = prescribed, robot.mobility_analysis.local_dofs(prescribed)
        solver = robot.solver
        generic = robot.generic_poses.take(np.array([0]))
        example = SolverState(generic.x, solver.origin(prescribed, generic)[1])
        self.nx, self.nt = generic.x.shape[0], prescribed.size
        constants = structure_of(solver, prescribed, self.local).values
        self.newton = _of_program("newton", newton_record(solver, prescribed, example, self.local), constants, ("state", "given"))
        self.side = None
        if not self.local:
            side = side_record(solver, prescribed, example, self.local)
            self.side = _of_program("side", side, constants, ("x1", "c1", "x2", "c2"))
        given = robot.actuator_coordinates
        drives = drives_record(solver, given, example)
        self.drives = _of_program("drives", drives, structure_of(solver, given, 0).values, ("x",))
        names = [robot.equations.loops[k].name for k in given.loops]
        order = [name for name in robot.description.driven if name not in names] + names
        self.drive_order = [order.index(name) for name in robot.description.driven]
        # the statics, and of the frames what they take
        asked = [item.name for item in self.outputs if item.name != "actuators"]
        record = output_record(robot.statics, [*asked, "singular"], example_of(robot.statics), all_vary=False)
        numbers = statics_structure_of(robot.statics, all_vary=False).values
        wanted = [row for name in asked for row in record.rows[name]]
        self.rows = {name: len(record.rows[name]) for name in asked}
        bodies, nq, self.closures = robot.mechanism.tree.bodies, robot.mechanism.tree.nq, robot.equations.closures
        placed = place_record(solver, prescribed, example, self.local)
        self.frame_numbers = 12 * bodies
        self.frames = _of_program("frames", replace(placed, numbers=placed.numbers[nq:]), constants, ("x",))

        def place(array: int, component: int) -> str:
            name, first = (("frames", 0), ("frames", 9 * bodies), ("load", 0), ("gravity", 0))[array]
            return f"{name}[{first + component}]"

        self.statics = c_program(
            "statics",
            record.tape,
            [*wanted, record.rows["singular"][0], record.holds],
            numbers,
            place,
            ("frames", "load", "gravity"),
        )
        self.strides = longest_strides(solver, prescribed)
        zero = robot.zero_poses
        first, c0 = solver.origin(prescribed, zero)
        self.zero = zero.x[:, 0], c0[:, 0], first[:, 0]
        self.impose = list(_imposed(function, self.nx))

    @property
    def programs(self) -> list[CProgram]:
        return [item for item in (self.newton, self.side, self.drives, self.frames, self.statics) if item is not None]

    @property
    def work(self) -> int:
        """Numbers in the largest work array."""
        return max(item.work for item in self.programs)

    @property
    def operations(self) -> int:
        return self.drives.operations + self.frames.operations + self.statics.operations


def _named(inputs: Sequence[str]) -> Any:
    return lambda array, component: f"{inputs[array]}[{component}]"


def _of_program(name: str, program: Program, constants: Array, inputs: tuple[str, ...]) -> CProgram:
    return c_program(name, program.tape, (*program.numbers, *program.truths), constants, _named(inputs), inputs)


def _imposed(function: Exported, nx: int) -> Any:
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


def _written(joint: Any, value: str) -> Any:
    if joint.type.endless:
        yield f"x[{joint.first_q}] = cos({value});"
        yield f"x[{joint.first_q + 1}] = sin({value});"
    else:
        yield f"x[{joint.first_q}] = {value};"


def _facts(function: Exported, parts: _Parts) -> dict[str, Any]:
    """Return what the texts are made of."""
    connections = function.robot.mechanism.connections
    coordinates = _coordinates(function)
    ranges = {}
    for item in coordinates:
        joint = connections.get(item.name) if function.by_drives else None
        ranges[item.name] = None if joint is None or not math.isfinite(joint.lower + joint.upper) else (joint.lower, joint.upper)
    limits = {name: (connections[name].lower, connections[name].upper) for name in function.robot.description.driven}
    return {
        "robot": function.robot.name,
        "parts": parts,
        "coordinates": coordinates,
        "names": [identifier(item.name) if item.name[0].isdigit() else re.sub(r"\W", "_", item.name) for item in coordinates],
        "order": [[item.name for item in coordinates].index(name) for name in function.names],
        "ranges": ranges,
        "limits": limits,
        "orientation": function.orientation or "rotation_vector",
        "by_drives": function.by_drives,
        "outputs": parts.outputs,
        "corrections": MOST_CORRECTIONS,
        "shrinking": SHRINKING,
    }


def _references(function: Exported, poses: int) -> list[tuple[dict[str, float], Array, Array, dict[str, Array], int]]:
    """Return poses around the zero pose with loads, and what Python says of them: a third of them lie far away."""
    rng = np.random.default_rng(0)
    robot = function.robot
    coordinates = _coordinates(function)
    zero = robot.solver.values(function.prescribed, robot.zero_poses)[:, 0]
    start = {name: float(zero[k]) for k, name in enumerate(function.names)}
    wide = np.where(np.arange(poses) % 3 == 2, 6.0, 1.0)
    steps = rng.uniform(-1, 1, (len(coordinates), poses)) * wide
    load = rng.uniform(-100, 100, (poses, 6))
    gravity = np.array([0.0, 0.0, -9.81]) + rng.uniform(-1, 1, (poses, 3))
    for part in (0.15, 0.05, 0.015):  # of the robot's length, or rad: until many of them are in reach
        spans = {item.name: part * (robot.length if item.units[0] == "m" else 1.0) for item in coordinates}
        at = {name: start[name] + span * step for (name, span), step in zip(spans.items(), steps, strict=True)}
        values = function(**at, load=load, gravity=gravity)
        if np.mean(np.isin(values["status"], WITHOUT_NUMBERS)) < 0.5:
            break
    found = []
    for k in range(poses):
        expected = {item.name: np.ravel(values[item.name][k]) for item in _asked(function)}
        found.append(({name: float(at[name][k]) for name in at}, load[k], gravity[k], expected, int(values["status"][k])))
    return found


def _asked(function: Exported) -> list[Quantity]:
    """Return the outputs that were asked for."""
    return [item for name, item in function.outputs.items() if name not in ALWAYS]


def _coordinates(function: Exported) -> list[Quantity]:
    """Return the inputs that are coordinates."""
    return [item for name, item in function.inputs.items() if name not in LOADS]
