"""Outputs of a robot at closed poses by compiled code, from coordinates, load and gravity. They are computed in stages: a call
computes the outputs of the stages up to a given one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from kinetostatics.engine import llvm
from kinetostatics.engine.code import LAST, Bound, Code, code_key, found_or_made, packed
from kinetostatics.engine.pose_record import Pose, PoseModel, example_of, outputs_at, pose_record
from kinetostatics.engine.scalars import NotRecordedError, Number, needed_by
from kinetostatics.kinematics.robot_kinematics import JointCoordinates, RobotKinematics
from kinetostatics.math.arrays import Array, Mask
from kinetostatics.quantities import OF_EQUILIBRIUM
from kinetostatics.statics.loaded_poses import LoadedAttachments
from kinetostatics.statics.robot_statics import RobotStatics
from kinetostatics.statics.small_motions import SmallMotions

#: Largest difference between compiled code and NumPy at the example, relative to the largest entry of an array.
_ALIKE = 1e-7
_FIRST = ("contributions", "singular", "indeterminate", "basis_degenerate", "doubtful")
#: Outputs of an analysis by stage: first the twist and whether the pose is singular, then the rest of the equilibrium. The
#: sufficient condition of stability has its own code, since it takes many operations.
ANALYSIS = (_FIRST, tuple(name for name in OF_EQUILIBRIUM if name not in ("twist", "usual", *_FIRST)))
STABILITY = (("is_stable",),)


class OutputPlace(NamedTuple):
    """Place of an output in the results: its shape at one pose, whether its entries are truth values, its rows, its stage."""

    shape: Sequence[int]
    truth: bool
    rows: slice
    stage: int

    def of(self, numbers: Array, truths: Mask) -> Number:
        """Return one output, poses last, from the results of all outputs, see :meth:`PoseCode.computed`."""
        return (truths if self.truth else numbers)[self.rows].reshape(*self.shape, truths.shape[1])


def pose_model(
    robot: RobotKinematics, statics: RobotStatics, stages: Sequence[Sequence[str]], attachments: LoadedAttachments | None = None
) -> tuple[PoseModel, tuple[Array, ...]]:
    """Return the model for :class:`PoseCode`, and example inputs: coordinates, load, gravity, wrenches on links."""
    members = SmallMotions(statics) if stages == STABILITY else None
    model = PoseModel(JointCoordinates(robot.solver), statics, None, attachments, members)
    return model, (robot.generic_poses.x[:, :1], *example_of(statics, attachments)[1:])


class PoseCode:
    """Compiled code of some outputs of a robot.

    Attributes:
        attachments: place of each output.
        operations: number of operations per pose.
        is_there: whether there is code.
    """

    def __init__(
        self,
        robot: RobotKinematics,
        statics: RobotStatics,
        stages: Sequence[Sequence[str]],
        attachments: LoadedAttachments | None = None,
        lanes: int = llvm.LANES,
        anew: bool = True,
    ) -> None:
        """Load the code from disk, or compile it.

        Args:
            stages: names of the outputs of each stage, see :data:`ANALYSIS`.
            lanes: poses per instruction.
            anew: whether to compile code that is not on disk.

        Raises:
            NotRecordedError: the analysis cannot be recorded.
        """
        model, example = pose_model(robot, statics, stages, attachments)
        structure = model.structure()
        self._parameters = structure.values
        self._sizes = [len(structure.values), *(len(array) for array in example)]
        self._key = code_key(f"poses {lanes} {stages} {structure.key}")
        expected = outputs_at(Pose(model, *example), [name for stage in stages for name in stage])
        make = [lambda: compiled(model, stages, example, self._sizes, lanes)]

        def is_right(codes: list[Code]) -> bool:
            return self._is_right(codes[0], expected, example)

        self.is_there = bool(found_or_made([self._key], make if anew else None, is_right))
        if anew and not self.is_there:
            raise NotRecordedError("results of compiled code differ from NumPy's")

    def _is_right(self, code: Code, expected: Mapping[str, Array], example: tuple[Array, ...]) -> bool:
        """Set ``code``, and return whether its results at the example agree with NumPy's."""
        if code.table["sizes"] != self._sizes:
            return False
        self.code, self.operations = code, int(code.table["operations"])
        self.places = {
            name: OutputPlace(shape, truth, slice(first, first + math.prod(shape)), stage)
            for name, (shape, truth, first, stage) in code.table["places"].items()
        }
        self._ends, self._truths = code.table["ends"], int(code.table["truths"])
        numbers, truths = self.computed(*example)
        outputs = {name: place.of(numbers, truths) for name, place in self.places.items()}
        closed = ("opening", "worst_equation")  # rounding errors only
        return bool(truths[0, 0]) and all(agree(expected[name], outputs[name]) for name in outputs if name not in closed)

    def computed(self, x: Array, load: Array, gravity: Array, *wrenches: Array, stage: int = LAST) -> tuple[Array, Mask]:
        """Return the numbers (R, N) and truth values (T, N) of all outputs; the first truth value is whether the code is valid.

        Args:
            x: (nq', N) coordinates of the solver.
            load: (6, N) [N, N·m].
            gravity: (3, N) [m/s²].
            wrenches: (6 P, N) wrenches at the P loaded places of links [N, N·m], if any.
            stage: outputs up to this stage are computed.
        """
        rows = self._ends[min(stage, len(self._ends) - 1)]
        return self.code.results([x, load, gravity, *wrenches], self._parameters, rows, self._truths, stage)

    def bound(self, x: Array) -> tuple[Array, Array, Callable[[], tuple[Array, Mask]]]:
        """Return arrays for load (6, 1) and gravity (3, 1) of one pose, and a function that computes the outputs at this pose.

        Args:
            x: (nq', n) array of coordinates; each call reads its first column.
        """
        load, gravity = np.zeros((6, 1)), np.zeros((3, 1))
        numbers, truths = np.empty((self._ends[-1], 1)), np.empty((self._truths, 1), dtype=bool)
        call = Bound(self.code, (x, load, gravity), self._parameters, numbers, truths)

        def computed() -> tuple[Array, Mask]:
            call()
            return numbers.copy(), truths.copy()

        return load, gravity, computed


def compiled(
    model: PoseModel, stages: Sequence[Sequence[str]], example: Sequence[Array], sizes: Sequence[int], lanes: int = llvm.LANES
) -> bytes:
    """Return the content of a file of code: the compiled outputs and the table of their places."""
    record = pose_record(model, [name for stage in stages for name in stage], example)
    rows: tuple[list[int], list[int]] = [], [record.all_hold()]
    places, ends = {}, []
    for number, stage in enumerate(stages):
        for name in stage:
            output_rows = record.rows[name]
            truth = bool(output_rows) and all(isinstance(record.tape.values[row], bool) for row in output_rows)
            places[name] = record.shapes[name], truth, len(rows[truth]), number
            rows[truth].extend(output_rows)
        ends.append(len(rows[0]))
    operations = sum(needed_by(record.tape, (*rows[0], *rows[1])))
    table = {"sizes": sizes, "places": places, "ends": ends, "truths": len(rows[1]), "operations": operations}
    quickly = model.members is not None  # many operations for few poses: fast compilation matters more than fast code
    text = llvm.module_of(record.tape, *rows, len(example), stages=ends[:-1], lanes=lanes, short_blocks=quickly)
    return packed(table, text, lanes, 0 if quickly else 1)


def agree(expected: Array, computed: Array) -> bool:
    """Whether two arrays differ by less than ``_ALIKE`` times the largest expected entry, with NaN at the same places."""
    if expected.shape != computed.shape or (expected.dtype == bool) != (computed.dtype == bool):
        return False
    if expected.dtype == bool:
        return bool(np.array_equal(expected, computed))
    return bool(np.allclose(computed, expected, rtol=0, atol=_ALIKE * np.nanmax(np.abs(expected), initial=1e-20), equal_nan=True))
