"""What people ask of closed poses, by compiled code in one go: frames, actuators, limits, equilibrium, and if all is as usual.

What is recorded are the functions that assemble and analyse poses: there is no other mathematics here.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from itertools import pairwise

import numpy as np

from kinetostatics.engine import cache as disk
from kinetostatics.engine import llvm
from kinetostatics.engine.code import Bound, Code, code_key, packed
from kinetostatics.engine.loop_record import KEPT as KEPT_OF_LOOPS
from kinetostatics.engine.loop_record import Program, held, recorded_rows
from kinetostatics.engine.outputs import KEPT as KEPT_OF_STATICS
from kinetostatics.engine.outputs import OUTPUTS, is_usual
from kinetostatics.engine.record import agree, by_numpy, example_of, recorded_input
from kinetostatics.engine.scalars import NotRecordedError, Number, Tape
from kinetostatics.engine.structure import Structure
from kinetostatics.kinematics.assembly import rough_residual
from kinetostatics.kinematics.joint_coordinates import JointCoordinates
from kinetostatics.kinematics.loop_constraints import LoopEquations
from kinetostatics.kinematics.mimic import Couplings
from kinetostatics.kinematics.robot_kinematics import RobotKinematics
from kinetostatics.math.arrays import Array, Mask, zeros_for
from kinetostatics.mechanism.mechanism import Connection, Mechanism
from kinetostatics.mechanism.tree import Frames, TreeJoint
from kinetostatics.statics.model import RobotStatics

_KEPT: Mapping[type, tuple[str, ...]] = {
    **KEPT_OF_STATICS,
    **KEPT_OF_LOOPS,
    Mechanism: ("tree", "platform_frame", "base_frame", "connections", "description", "body_of_joint"),
    LoopEquations: (*KEPT_OF_LOOPS[LoopEquations], "loop_of", "is_length"),
    Connection: (
        *("name", "kind", "predecessor_body", "successor_body", "predecessor_frame", "successor_frame", "axis", "mimic", "cone"),
        *("lower", "upper"),
    ),
    Couplings: (*KEPT_OF_LOOPS[Couplings], "names", "is_length"),
    TreeJoint: ("kind", "body", "first_q", "first_v"),
}


class CompiledOutputs:
    """Compiled code for some outputs of a robot.

    Attributes:
        operations: how many operations a pose takes.
    """

    def __init__(self, robot: RobotKinematics, statics: RobotStatics, names: Sequence[str], tolerance: float) -> None:
        """Find or make the code.

        Args:
            robot, statics: the robot.
            names: of the outputs: those of :data:`kinetostatics.engine.outputs.OUTPUTS`, and "actuators".
            tolerance: opening of a loop [m, rad] above which a pose is not reached.

        Raises:
            NotRecordedError: something cannot be recorded.
        """
        self._names = tuple(names)
        self._example = robot.generic_poses.x[:, :1], *example_of(statics)[1:]
        self._own = JointCoordinates(robot.solver), statics, np.array([rough_residual(robot), tolerance]), self._names
        wanted, *truths = _computed(self._own, *self._example)
        self._shapes = [array.shape[:-1] for array in wanted]
        ends = np.cumsum([0, *(int(np.prod(shape)) for shape in self._shapes)]).tolist()
        self._rows = [slice(first, last) for first, last in pairwise(ends)]
        self._size = ends[-1]
        structure = Structure(self._own, None, _KEPT)
        self._parameters, self._structure, self._right = structure.values, structure.key, (wanted, truths)
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
        tape = Tape()
        copy = Structure(self._own, tape, _KEPT).copy
        copy[0].solver.forget()
        inputs = [recorded_input(tape, number, array) for number, array in enumerate(self._example)]

        def computed() -> list[Array]:
            found, fine, within = _computed(copy, *inputs)
            return [*(row for array in found for row in array.reshape(-1, 1)), fine & held(tape), within]

        *numbers, fine, within = recorded_rows(tape, computed)
        operations = sum(llvm.needed_by(tape, (*numbers, fine, within)))
        table = {"sizes": self._sizes, "operations": operations}
        return packed(table, llvm.module_of(tape, numbers, (fine, within), 3, lanes=lanes), lanes)

    def _is_right(self, code: Code) -> bool:
        """Whether code gives at the example what NumPy gives: whatever may be wrong with code from a disk."""
        if code.table["sizes"] != self._sizes:
            return False
        wanted, said = self._right
        numbers, truths = code.results(self._example, self._parameters, self._size, 2)
        pairs = zip(wanted[:-1], self._rows, strict=False)  # the last is the residual: rounding
        return bool(np.array_equal(truths, said)) and all(agree(a.ravel(), numbers[rows, 0]) for a, rows in pairs)

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
        numbers, (fine, within) = self._together.results((x, load, gravity), self._parameters, self._size, 2)
        N, names = numbers.shape[1], (*self._names, "residual")
        arrays = (numbers[rows].reshape(*shape, N) for rows, shape in zip(self._rows, self._shapes, strict=True))
        return dict(zip(names, arrays, strict=True)), fine, within

    def bound(self, x: Array) -> tuple[Array, Array, Callable[[], tuple[dict[str, Array], bool] | None]]:
        """Return arrays (k, 1) for load and gravity of one pose, and what computes its outputs and whether it is within limits.

        That returns None where they are not to be believed. The arrays are used again by every call.

        Args:
            x: (nq', n) the coordinates, in the first column, which stay in this array.
        """
        load, gravity = (np.array(array) for array in self._example[1:])
        numbers, truths = np.empty((self._size, 1)), np.empty((2, 1), dtype=bool)
        call = Bound(self._alone, (x, load, gravity), self._parameters, numbers, truths)
        places = list(zip((*self._names, "residual"), self._rows, self._shapes, strict=True))

        def computed() -> tuple[dict[str, Array], bool] | None:
            call()
            if not truths[0, 0]:
                return None
            flat = numbers[:, 0].copy()
            flat.setflags(write=False)
            return {name: flat[rows].reshape(shape) for name, rows, shape in places}, bool(truths[1, 0])

        return load, gravity, computed


def _computed(own: Number, x: Array, load: Array, gravity: Array) -> tuple[list[Array], Number, Number]:
    """Return outputs (…, N) and the residual; which poses are as usual, and which within limits."""
    coordinates, statics, (most, tolerance), names = own
    equations = coordinates.solver.equations
    q, frames, residual = equations.place(x)
    fine = np.max(np.abs(residual), axis=0, initial=0.0) <= most
    worst = zeros_for((x.shape[1],), x)
    for metres, radians in equations.openings(residual, x).values():
        worst = np.maximum(worst, np.maximum(metres, radians))
    fine, within = fine & (worst <= tolerance), _within(coordinates, q, frames)
    solution = by_numpy(statics, frames, load, gravity)
    fine = fine & ~solution.singular & is_usual(statics, solution)
    found = []
    for name in names:
        if name == "actuators":
            values = coordinates.at(q, frames)
            found.append(np.stack([values[actuator] for actuator in statics.description.driven]))
        else:
            found.append(OUTPUTS[name](statics, solution))
    return [*found, worst], fine, within


def limits_record(robot: RobotKinematics) -> tuple[Program, Array]:
    """Record whether a pose is within all joints' limits, and whether the record holds; input is x (nq').

    Return the robot's numbers (P,), too.
    """
    example, tape = robot.generic_poses.x[:, :1], Tape()
    own = JointCoordinates(robot.solver)
    coordinates = Structure(own, tape, _KEPT).copy
    coordinates.solver.forget()
    x = recorded_input(tape, 0, example)

    def computed() -> list[Array]:
        q, frames, _ = coordinates.solver.equations.place(x)
        return [_within(coordinates, q, frames), held(tape)]

    return Program(tape, (), tuple(recorded_rows(tape, computed))), Structure(own, None, _KEPT).values


def _within(coordinates: JointCoordinates, q: Array, frames: Frames) -> Number:
    """Return which poses (N,) are within the limits."""
    within: Number = np.ones(q.shape[1], dtype=bool)
    for *_, inside in coordinates.limited(q, frames):
        within = within & inside
    return within
