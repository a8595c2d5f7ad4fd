"""The record of what closes a robot's loops: one step of Newton's method, and all frames, at one example pose.

What is recorded is :meth:`kinetostatics.kinematics.solver.Solver.system` and what the solver does with it: there is no other
mathematics here. Lengths and placements are parameters.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetostatics.engine.record import recorded_input
from kinetostatics.engine.recorder import recorded
from kinetostatics.engine.scalars import NotRecordedError, Tape
from kinetostatics.engine.structure import Structure
from kinetostatics.kinematics.loop_constraints import LoopAxes, LoopEquations
from kinetostatics.kinematics.mimic import Couplings
from kinetostatics.kinematics.solver import PrescribedCoordinates, Solver, SolverState
from kinetostatics.math.arrays import Array, Index
from kinetostatics.math.linalg import least_squares
from kinetostatics.mechanism.mechanism import Connection, Mechanism, SphericalRun
from kinetostatics.mechanism.tree import TreeJoint

#: What is kept of classes that hold more than closing the loops needs; a solver's caches are made anew.
KEPT: Mapping[type, tuple[str, ...]] = {
    Solver: (
        *("equations", "length", "reach", "slack", "tree", "mechanism", "platform_signs", "column_scale"),
        *("_row_scale", "_joint_of_column"),
    ),
    Mechanism: ("tree", "platform_frame", "base_frame"),
    LoopEquations: (
        *("mechanism", "tree", "loops", "closures", "count", "signs", "couplings", "loop_axes", "runs", "_tables", "_distance"),
        *("_alignment", "_right_angle", "_turn", "_same_here", "_same_there", "neutral"),
    ),
    Connection: ("kind", "predecessor_body", "successor_body", "predecessor_frame", "successor_frame"),
    LoopAxes: ("axis", "side", "third", "turned_side", "middle"),
    Couplings: ("count", "columns", "_couplings", "_gradient"),
    SphericalRun: ("axes", "orientation"),
    TreeJoint: ("kind", "first_q", "first_v"),
}


@dataclass(frozen=True)
class LoopRecord:
    """What closing a robot's loops takes, operation by operation.

    Attributes:
        tape: the operations; inputs are the solver's coordinates x (nq'), the platform's orientation coordinates c (3,) and the
            prescribed coordinates (n,), in this order.
        parameters: (P,) this robot's numbers.
        key: tells structures apart.
        arrays: numbers of the operations of what is computed, by name, in arrays of the shapes without poses.
        columns: (f,) the freedoms of the tree that the first unknowns of a step move, scaled by ``column_scale``.
        angles: which of the orientation coordinates c the last unknowns of a step move.
    """

    tape: Tape
    parameters: Array
    key: str
    arrays: Mapping[str, NDArray[np.intp]]
    columns: Index
    angles: tuple[int, ...]


def loop_record(solver: Solver, prescribed: PrescribedCoordinates, example: SolverState, local: int = 0) -> LoopRecord:
    """Record a step of Newton's method, with all it depends on.

    The arrays are, without poses: ``residual`` (m,) scaled, ``gradient`` (m, f + a) of the residual by the unknowns, which are
    the scaled displacements of the free columns and the unknown angles; ``step`` (f + a,) the correction; ``x`` (nq',) and ``c``
    (3,) moved by it; and, at the coordinates before that: ``q`` (nq,) of Pinocchio, ``rotation`` (3, 3, B) and ``position``
    (3, B) [m] of all bodies, world axes.

    Args:
        solver: closes the loops.
        prescribed: which coordinates are given; those of the tree must stand in x already, those of the angles in c:
            :meth:`Solver.impose`.
        example: one pose near to which guards hold.
        local: number of freedoms that do not move the platform.

    Raises:
        NotRecordedError: it takes something that is not an operation on scalars.
    """
    tape = Tape()
    structure, copy = _copy_of(solver, prescribed, local, tape)
    target = solver.values(prescribed, example)
    x, c, given = (recorded_input(tape, number, array) for number, array in enumerate((example.x, example.c, target)))
    try:
        with np.errstate(all="ignore"):
            poses = SolverState(x, c)
            residual, gradient = copy.system(prescribed, poses, given)
            step = -least_squares(gradient, residual[:, None], local)[:, 0]
            moved = copy.advance(prescribed, poses, step)
            q, frames, _ = copy.equations.place(x)
    except (ArithmeticError, AttributeError, IndexError, TypeError, ValueError) as error:  # something takes numbers for floats
        raise NotRecordedError(str(error)) from error
    found: dict[str, Any] = {"residual": residual, "gradient": gradient, "step": step, "x": moved.x, "c": moved.c, "q": q}
    found |= {"rotation": frames.rotation, "position": frames.position}
    arrays = {name: _numbers(tape, array) for name, array in found.items()}
    free = solver.free_columns(prescribed)
    return LoopRecord(tape, structure.values, structure.key, arrays, free, prescribed.unknown_angles)


def structure_of(solver: Solver, prescribed: PrescribedCoordinates, local: int, tape: Tape | None = None) -> Structure:
    """Return what a record depends on."""
    return Structure((solver, prescribed, local), tape, KEPT)


def _copy_of(solver: Solver, prescribed: PrescribedCoordinates, local: int, tape: Tape) -> tuple[Structure, Solver]:
    """Return a solver's structure, and its copy that records."""
    structure = structure_of(solver, prescribed, local, tape)
    copy: Solver = structure.copy[0]
    copy.forget()
    return structure, copy


def _numbers(tape: Tape, array: Any) -> NDArray[np.intp]:
    flat = [tape.number_of(entry) for entry in array.ravel().tolist()]
    return np.array(flat, dtype=np.intp).reshape(array.shape[:-1])


# ---- what is compiled --------------------------------------------------------------------------------------------------

#: Numbers of a pose that :func:`newton_record` keeps besides its coordinates: size of the correction before, by how much that was
#: smaller than the one before it, and whether the pose is to be corrected again, has converged, and was never beside the record.
BEFORE, SHRUNK, GOING, GOOD, HOLDS = range(5)


@dataclass(frozen=True)
class Program:
    """Operations whose results are wanted, in order."""

    tape: Tape
    numbers: tuple[int, ...]
    truths: tuple[int, ...]


def newton_record(solver: Solver, prescribed: PrescribedCoordinates, example: SolverState, local: int) -> Program:
    """Record :meth:`Solver.correct` as a step from a state to the next.

    Inputs are the state, that is x (nq'), c (3,) and the five numbers ``BEFORE`` … ``HOLDS``; and the prescribed coordinates
    (n,), behind them whether the pose is only passed. The numbers wanted are the next state; the truth value says whether the
    pose is to be corrected again.
    """
    tape = Tape()
    _, copy = _copy_of(solver, prescribed, local, tape)
    target, size = solver.values(prescribed, example), example.x.shape[0]
    flags = np.array([[0.1, 0.4, 1.0, 0.0, 1.0]]).T
    state = recorded_input(tape, 0, np.concatenate([example.x, example.c, flags]))
    given = recorded_input(tape, 1, np.append(target, [[0.0]], axis=0))
    poses, more = SolverState(state[:size], state[size : size + 3]), state[size + 3 :]

    def computed() -> list[Any]:
        going, passing = more[GOING] != 0, given[-1] != 0
        found = copy.correct(prescribed, poses, given[:-1], local, more[BEFORE], more[SHRUNK], passing)
        holds = _held(tape)
        again, good = going & found.going & holds, (more[GOOD] != 0) | (going & found.done)
        now = [*found.poses.x, *found.poses.c, found.size, found.shrunk]
        moved = [np.where(going, new, old) for new, old in zip(now, state[: size + 5], strict=True)]
        flags = [np.where(flag, 1.0, 0.0) for flag in (again, good, (more[HOLDS] != 0) & (holds | ~going))]
        return [*moved, *flags, again]

    *numbers, again = _recorded(tape, computed)
    return Program(tape, tuple(numbers), (again,))


def side_record(solver: Solver, prescribed: PrescribedCoordinates, example: SolverState, local: int) -> Program:
    """Record :meth:`Solver.surely_on_one_side`; inputs are x and c of the first and of the second pose."""
    tape = Tape()
    _, copy = _copy_of(solver, prescribed, local, tape)
    x, c, other_x, other_c = (recorded_input(tape, k, a) for k, a in enumerate((example.x, example.c) * 2))

    def computed() -> list[Any]:
        found = copy.surely_on_one_side(prescribed, SolverState(x, c), SolverState(other_x, other_c))
        return [found & _held(tape)]

    return Program(tape, (), tuple(_recorded(tape, computed)))


def place_record(solver: Solver, prescribed: PrescribedCoordinates, example: SolverState, local: int) -> Program:
    """Record :meth:`Solver.place`.

    The input is x, the numbers are q, rotations, positions and residual, and the truth value is whether the record holds.
    """
    tape = Tape()
    _, copy = _copy_of(solver, prescribed, local, tape)
    x = recorded_input(tape, 0, example.x)

    def computed() -> list[Any]:
        q, frames, residual = copy.equations.place(x)
        numbers = [q, frames.rotation.reshape(-1, 1), frames.position.reshape(-1, 1), residual]
        return [*(row for array in numbers for row in array), _held(tape)]

    *numbers, holds = _recorded(tape, computed)
    return Program(tape, tuple(numbers), (holds,))


def _held(tape: Tape) -> Any:
    """Return whether (1,) all guards up to now are met."""
    return recorded(np.array([tape.holds()], dtype=object))


def _recorded(tape: Tape, computed: Callable[[], list[Any]]) -> list[int]:
    """Return the numbers of the operations that give arrays (1,)."""
    try:
        with np.errstate(all="ignore"):
            return [tape.number_of(array[0]) for array in computed()]
    except (ArithmeticError, AttributeError, IndexError, TypeError, ValueError) as error:  # something takes numbers for floats
        raise NotRecordedError(str(error)) from error


def drives_record(solver: Solver, given: PrescribedCoordinates, example: SolverState) -> Program:
    """Record the coordinates of drives, in the order of ``given``; input is x (nq')."""
    tape = Tape()
    _, copy = _copy_of(solver, given, 0, tape)
    x = recorded_input(tape, 0, example.x)

    def computed() -> list[Any]:
        frames = copy.equations.forward(x)
        rows = [copy.equations.couplings.coordinate(copy._joint_of_column[column], x) for column in given.columns]
        return rows + [copy.loop_coordinate(number, frames) for number in given.loops]

    return Program(tape, tuple(_recorded(tape, computed)), ())
