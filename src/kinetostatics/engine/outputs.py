"""Records of what people ask of a pose, such as its twist and drive forces, for functions and their derivatives."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from kinetostatics.description.robot import RobotDescription
from kinetostatics.engine.record import recorded_arrays
from kinetostatics.engine.scalars import Tape
from kinetostatics.engine.structure import KEPT, Structure
from kinetostatics.math.arrays import Array
from kinetostatics.mechanism.mechanism import Connection, Mechanism
from kinetostatics.mechanism.tree import Frames
from kinetostatics.statics.joint_wrenches import actuator_forces
from kinetostatics.statics.model import RobotStatics
from kinetostatics.statics.solution import Solution


def _forces(robot: RobotStatics, solution: Solution) -> Array:
    forces = actuator_forces(robot, solution)
    return np.stack([forces[name] for name in robot.description.driven])


#: What may be asked for, each (…components, N).
OUTPUTS: Mapping[str, Callable[[RobotStatics, Solution], Array]] = {
    "twist": lambda robot, solution: solution.twists.sum(axis=1),
    "contributions": lambda robot, solution: solution.twists,
    "stiffness": lambda robot, solution: solution.stiffness,
    "compliance": lambda robot, solution: solution.compliance,
    "actuator_forces": _forces,
}
#: What they take of a robot.
_KEPT: Mapping[type, tuple[str, ...]] = {
    **KEPT,
    RobotStatics: (*KEPT[RobotStatics], "joint_table"),
    Mechanism: ("platform_frame", "connections", "description"),
    RobotDescription: ("driven",),
    Connection: ("name", "kind", "predecessor_body", "predecessor_frame", "axis", "mimic"),
}


@dataclass(frozen=True)
class OutputRecord:
    """What some outputs of a robot take, operation by operation.

    Attributes:
        tape: the operations; inputs are the frames' rotations and positions, load and gravity, in this order.
        rows: the operations of each output's components, in order.
        shapes: of each output.
        holds: the operation that tells whether the record holds.
    """

    tape: Tape
    rows: Mapping[str, tuple[int, ...]]
    shapes: Mapping[str, tuple[int, ...]]
    holds: int


def structure_of(robot: RobotStatics, tape: Tape | None = None) -> Structure:
    """Take a robot apart for such a record: all of its finite numbers are parameters."""
    return Structure(robot, tape, _KEPT, all_vary=True)


def output_record(robot: RobotStatics, names: Sequence[str], example: tuple[Frames, Array, Array]) -> OutputRecord:
    """Record some outputs.

    Args:
        robot: the robot.
        names: of the outputs.
        example: frames, load (6, 1) and gravity (3, 1) of one pose, whose way is taken at branches.

    Raises:
        NotRecordedError: it takes something that is not an operation on scalars.
    """
    tape = Tape()
    copy = structure_of(robot, tape).copy

    def wanted(solution: Solution) -> dict[str, Any]:
        return {name: OUTPUTS[name](copy, solution) for name in names}

    arrays = recorded_arrays(robot, tape, copy, example, wanted)
    rows = {name: tuple(tape.number_of(entry) for entry in array[..., 0].ravel().tolist()) for name, array in arrays.items()}
    shapes = {name: tuple(array.shape[:-1]) for name, array in arrays.items()}
    return OutputRecord(tape, rows, shapes, tape.number_of(tape.holds()))
