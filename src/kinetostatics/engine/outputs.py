"""Records of what people ask of a pose, such as its twist and actuator forces, for functions and their derivatives."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from kinetostatics.description.robot import RobotDescription
from kinetostatics.engine.record import recorded_arrays
from kinetostatics.engine.scalars import Number, Tape
from kinetostatics.engine.structure import KEPT as KEPT_OF_EQUILIBRIUM
from kinetostatics.engine.structure import Structure
from kinetostatics.math.arrays import Array, Mask
from kinetostatics.math.screws import move
from kinetostatics.mechanism.mechanism import Connection, Mechanism
from kinetostatics.mechanism.tree import Frames
from kinetostatics.quantities import COMPUTED, QUANTITIES
from kinetostatics.statics.model import RobotStatics
from kinetostatics.statics.solution import Solution


def is_usual(robot: RobotStatics, solution: Solution) -> Mask:
    """Return at which poses (N,) every limb is what it is elsewhere, and nothing is undetermined."""
    return ~solution.indeterminate & ~solution.basis_degenerate & ~solution.doubtful


#: What may be recorded, each (…components, N).
OUTPUTS: Mapping[str, Callable[[RobotStatics, Solution], Array | Mask]] = {
    **COMPUTED,
    "singular": lambda robot, solution: solution.singular,
    "usual": is_usual,
}


#: What they take of a robot.
KEPT: Mapping[type, tuple[str, ...]] = {
    **KEPT_OF_EQUILIBRIUM,
    RobotStatics: (*KEPT_OF_EQUILIBRIUM[RobotStatics], "joint_table"),
    Mechanism: ("platform_frame", "connections", "description"),
    RobotDescription: ("springs", "driven"),
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


def structure_of(robot: RobotStatics, tape: Tape | None = None, all_vary: bool = True) -> Structure:
    """Take a robot apart for such a record; see :class:`Structure`."""
    return Structure(robot, tape, KEPT, all_vary=all_vary)


def output_record(
    robot: RobotStatics,
    names: Sequence[str],
    example: tuple[Frames, Array, Array],
    all_vary: bool = True,
    tool: Array | None = None,
) -> OutputRecord:
    """Record some outputs.

    Args:
        robot: the robot.
        names: of the outputs.
        example: frames, load (6, 1) and gravity (3, 1) of one pose, whose way is taken at branches.
        all_vary: 0, 1 and −1 are numbers like others, see :class:`Structure`.
        tool: (3,) a point of the platform, from o in its axes [m], that twist, stiffness and compliance are about; None: o.

    Raises:
        NotRecordedError: it takes something that is not an operation on scalars.
    """
    tape = Tape()
    copy = structure_of(robot, tape, all_vary).copy

    def wanted(solution: Solution) -> dict[str, Number]:
        found: dict[str, Number] = {name: OUTPUTS[name](copy, solution) for name in names}
        if tool is not None:
            rotation, _ = copy.mechanism.platform_pose(solution.frames)
            arm = np.einsum("ijn,j->in", rotation, tool)
            for name, kind in ((name, QUANTITIES[name].moves_as) for name in names):
                if kind is not None and not _is_unknown(found[name]):
                    axis = QUANTITIES[name].dims.index("component")
                    found[name] = np.moveaxis(move(kind, np.moveaxis(found[name], axis, 0), arm), 0, axis)
        return found

    arrays = recorded_arrays(robot, tape, copy, example, wanted)
    rows = {name: _numbers(tape, array) for name, array in arrays.items()}
    shapes = {name: tuple(array.shape[:-1]) for name, array in arrays.items()}
    return OutputRecord(tape, rows, shapes, tape.number_of(tape.holds()))


def _is_unknown(array: Array) -> bool:
    """Whether all entries are NaN whatever the pose, as an infinite stiffness is: sums with it would spoil derivatives."""
    return all(isinstance(entry, float) and math.isnan(entry) for entry in np.asarray(array).ravel().tolist())


def _numbers(tape: Tape, array: Array) -> tuple[int, ...]:
    """Return the operations that give the entries of an array (…, 1)."""
    return tuple(tape.number_of(entry) for entry in np.asarray(array[..., 0], dtype=object).ravel().tolist())
