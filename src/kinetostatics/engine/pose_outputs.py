"""What people ask of closed poses, by compiled code in one go: joint coordinates, limits, equilibrium, and if all is as usual."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from itertools import accumulate, pairwise

import numpy as np

from kinetostatics.engine import cache as disk
from kinetostatics.engine import llvm
from kinetostatics.engine.code import Bound, Code, code_key, packed
from kinetostatics.engine.pose_record import Pose, PoseModel, outputs_at, pose_record
from kinetostatics.engine.record import agree, example_of
from kinetostatics.engine.scalars import NotRecordedError
from kinetostatics.kinematics.assembly import rough_residual
from kinetostatics.kinematics.prescribed import PrescribedCoordinates
from kinetostatics.kinematics.robot_kinematics import RobotKinematics
from kinetostatics.math.arrays import Array, Mask
from kinetostatics.statics.model import RobotStatics

#: Behind the outputs: how far loops are open, and truth values that tell whether a pose is to be believed, and within limits.
_OPEN, _TRUTHS = ("opening", "worst_equation"), ("singular", "usual", "within")


class CompiledOutputs:
    """Compiled code for some outputs of a robot.

    Attributes:
        operations: how many operations a pose takes.
    """

    def __init__(self, robot: RobotKinematics, statics: RobotStatics, names: Sequence[str], tolerance: float) -> None:
        """Find or make the code.

        Args:
            robot, statics: the robot.
            names: of the outputs, see :func:`kinetostatics.engine.pose_record.outputs_at`.
            tolerance: opening of a loop [m, rad] above which a pose is not reached.

        Raises:
            NotRecordedError: something cannot be recorded.
        """
        self._names, self._limits = tuple(names), (tolerance, rough_residual(robot))
        self._model = PoseModel.of(robot.solver, statics, PrescribedCoordinates())
        self._example = robot.generic_poses.x[:, :1], *example_of(statics)[1:]
        structure = self._model.taken_apart()
        self._parameters, self._structure = structure.values, f"{self._names} {structure.key}"
        found = outputs_at(Pose(self._model, *self._example), (*self._names, *_OPEN, *_TRUTHS))
        self._right = [np.asarray(found[name]) for name in self._names], [bool(found[name][0]) for name in _TRUTHS]
        self._shapes = [array.shape[:-1] for array in self._right[0]]
        ends = accumulate((int(np.prod(shape)) for shape in self._shapes), initial=0)
        self._rows = [slice(first, last) for first, last in pairwise(ends)]
        self._size = sum(rows.stop - rows.start for rows in self._rows) + len(_OPEN)
        self._alone = self._made("outputs_of_one", 1)
        self.operations = int(self._alone.table["operations"])

    @cached_property
    def _together(self) -> Code:
        """Code for many poses, made when many are asked for."""
        return self._made("outputs", llvm.LANES)

    def _made(self, what: str, lanes: int) -> Code:
        """Return code from the disk, if it is there and right, or made now."""
        key = code_key(f"{what} {self._structure}")
        kept = disk.read(key)
        if kept is not None and self._is_right(code := Code(kept)):
            return code
        kept = self._compiled(lanes)
        if not self._is_right(code := Code(kept)):
            raise NotRecordedError("compiled code gives other outputs than NumPy")
        disk.write(key, kept)
        return code

    @property
    def _sizes(self) -> list[int]:
        return [len(self._parameters), self._size, self._example[0].shape[0]]

    def _compiled(self, lanes: int) -> bytes:
        record = pose_record(self._model, (*self._names, *_OPEN, *_TRUTHS), self._example)
        numbers, truths = record.all_rows((*self._names, *_OPEN)), [*record.all_rows(_TRUTHS), record.all_hold()]
        table = {"sizes": self._sizes, "operations": sum(llvm.needed_by(record.tape, (*numbers, *truths)))}
        return packed(table, llvm.module_of(record.tape, numbers, truths, 3, lanes=lanes), lanes)

    def _is_right(self, code: Code) -> bool:
        """Whether code gives at the example what NumPy gives: whatever may be wrong with code from a disk."""
        if code.table["sizes"] != self._sizes:
            return False
        wanted, said = self._right
        numbers, truths = code.results(self._example, self._parameters, self._size, len(_TRUTHS) + 1)
        pairs = zip(wanted, self._rows, strict=True)
        return truths[:, 0].tolist() == [*said, True] and all(agree(a.ravel(), numbers[rows, 0]) for a, rows in pairs)

    def __call__(self, x: Array, load: Array, gravity: Array) -> tuple[dict[str, Array], Mask, Mask]:
        """Compute outputs of poses at solved coordinates.

        Args:
            x: (nq', N) coordinates.
            load: (6, N) [N, N·m].
            gravity: (3, N) [m/s²].

        Returns:
            Outputs and "residual" (…, N) by name; of which poses (N,) they are to be believed, as the pose is closed, nothing is
            singular or undetermined, and every limb is what it is elsewhere; and which are within all joints' limits.
        """
        numbers, truths = self._together.results((x, load, gravity), self._parameters, self._size, len(_TRUTHS) + 1)
        N = numbers.shape[1]
        pairs = zip(self._names, self._rows, self._shapes, strict=True)
        found = {name: numbers[rows].reshape(*shape, N) for name, rows, shape in pairs}
        singular, usual, within, holds = truths
        fine = holds & ~singular & usual & np.all(numbers[-2:] <= np.array([self._limits]).T, axis=0)
        return found | {"residual": numbers[-2]}, fine, within

    def bound(self, x: Array) -> tuple[Array, Array, Callable[[], tuple[dict[str, Array], bool] | None]]:
        """Return arrays (k, 1) for load and gravity of one pose, and what computes its outputs and whether it is within limits.

        That returns None where they are not to be believed. The arrays are used again by every call.

        Args:
            x: (nq', n) the coordinates, in the first column, which stay in this array.
        """
        load, gravity = (np.array(array) for array in self._example[1:])
        numbers, truths = np.empty((self._size, 1)), np.empty((len(_TRUTHS) + 1, 1), dtype=bool)
        call = Bound(self._alone, (x, load, gravity), self._parameters, numbers, truths)
        last = self._size - len(_OPEN)
        places = list(zip((*self._names, "residual"), (*self._rows, slice(last, last + 1)), (*self._shapes, ()), strict=True))
        most, rough = self._limits

        def computed() -> tuple[dict[str, Array], bool] | None:
            call()
            singular, usual, within, holds = truths[:, 0].tolist()
            flat = numbers[:, 0].copy()
            if singular or not (holds and usual and flat[-2] <= most and flat[-1] <= rough):
                return None
            flat.setflags(write=False)
            return {name: flat[rows].reshape(shape) for name, rows, shape in places}, within

        return load, gravity, computed
