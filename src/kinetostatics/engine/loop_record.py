"""Records of the closure of a robot's loops: a step of Newton's method, frames, actuators, and the side of a singular pose.

The functions of :class:`kinetostatics.kinematics.solver.Solver` are recorded, with lengths and placements as parameters.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from kinetostatics.engine.record import recorded_input
from kinetostatics.engine.recorder import recorded, recording
from kinetostatics.engine.scalars import Number, Tape
from kinetostatics.engine.structure import Structure
from kinetostatics.kinematics.prescribed import PrescribedCoordinates, line_start
from kinetostatics.kinematics.solver import Solver, SolverState
from kinetostatics.kinematics.velocities import freedom_rates, with_given
from kinetostatics.math.arrays import Array
from kinetostatics.math.linalg import least_squares


def structure_of(solver: Solver, prescribed: PrescribedCoordinates, tape: Tape | None = None) -> Structure:
    """Return the data on which a record depends; see :class:`Structure`."""
    return Structure((solver, prescribed), tape)


def _copy_of(solver: Solver, prescribed: PrescribedCoordinates, tape: Tape) -> Solver:
    """Return a solver's copy that records."""
    copy: Solver = structure_of(solver, prescribed, tape).copy[0]
    return copy


#: Numbers of a pose that :func:`newton_record` keeps besides its coordinates: size of the correction before, by how much that was
#: smaller than the one before it, and whether the pose is to be corrected again, has converged, and was never beside the record.
BEFORE, SHRUNK, GOING, GOOD, HOLDS = range(5)


@dataclass(frozen=True)
class Program:
    """Operations whose results are wanted, in order; ``stages`` tell how many of the numbers may be computed alone."""

    tape: Tape
    numbers: tuple[int, ...]
    truths: tuple[int, ...]
    stages: tuple[int, ...] = ()


def newton_record(solver: Solver, prescribed: PrescribedCoordinates, example: SolverState) -> Program:
    """Record :meth:`Solver.correct` as a step from a state to the next.

    Inputs are the state, that is x (nq'), c (3,) and the five numbers ``BEFORE`` … ``HOLDS``; and the prescribed coordinates
    (n,), behind them whether the pose is only passed. The numbers wanted are the next state; the truth value says whether the
    pose is to be corrected again.
    """
    tape = Tape()
    copy = _copy_of(solver, prescribed, tape)
    target, size = solver.values(prescribed, example), example.x.shape[0]
    flags = np.array([[0.1, 0.4, 1.0, 0.0, 1.0]]).T
    state = recorded_input(tape, 0, np.concatenate([example.x, example.c, flags]))
    given = recorded_input(tape, 1, np.append(target, [[0.0]], axis=0))
    poses, more = SolverState(state[:size], state[size : size + 3]), state[size + 3 :]

    def computed() -> list[Array]:
        going, passing = more[GOING] != 0, given[-1] != 0
        found = copy.correct(prescribed, poses, given[:-1], more[BEFORE], more[SHRUNK], passing)
        holds = held(tape)
        again, good = going & found.going & holds, (more[GOOD] != 0) | (going & found.done)
        now = [*found.poses.x, *found.poses.c, found.size, found.shrunk]
        moved = [np.where(going, new, old) for new, old in zip(now, state[: size + 5], strict=True)]
        flags = [np.where(flag, 1.0, 0.0) for flag in (again, good, (more[HOLDS] != 0) & (holds | ~going))]
        return [*moved, *flags, again]

    *numbers, again = recorded_rows(tape, computed)
    return Program(tape, tuple(numbers), (again,))


def side_record(solver: Solver, prescribed: PrescribedCoordinates, example: SolverState) -> Program:
    """Record :meth:`Solver.surely_on_one_side`; inputs are x and c of the first and of the second pose."""
    tape = Tape()
    copy = _copy_of(solver, prescribed, tape)
    x, c, other_x, other_c = (recorded_input(tape, k, a) for k, a in enumerate((example.x, example.c) * 2))

    def computed() -> list[Array]:
        found = copy.surely_on_one_side(prescribed, SolverState(x, c), SolverState(other_x, other_c))
        return [found & held(tape)]

    return Program(tape, (), tuple(recorded_rows(tape, computed)))


def start_record(solver: Solver, prescribed: PrescribedCoordinates, example: SolverState) -> Program:
    """Record :meth:`Solver.line`.

    Inputs are x and c of the pose where a line starts, the target (n,), and whether the shorter way is wanted (1,). The numbers
    are the prescribed coordinates and all orientation coordinates (3,) with which it starts, the truth value tells whether the
    record holds.
    """
    tape = Tape()
    copy = _copy_of(solver, prescribed, tape)
    examples = example.x, example.c, solver.values(prescribed, example) + 0.1, np.ones((1, 1))
    x, c, aim, flag = (recorded_input(tape, k, array) for k, array in enumerate(examples))

    def computed() -> list[Array]:
        numbers = line_start(prescribed, copy.origin(prescribed, SolverState(x, c), aim), aim, flag[0] != 0)
        return [*(row for array in numbers for row in array.reshape(-1, 1)), held(tape)]

    *numbers, holds = recorded_rows(tape, computed)
    return Program(tape, tuple(numbers), (holds,))


def rates_record(solver: Solver, prescribed: PrescribedCoordinates, example: SolverState) -> Program:
    """Record how fast x changes with each given coordinate, see :mod:`kinetostatics.kinematics.velocities`.

    Inputs are x and c of a closed pose. The numbers are the rates, for one coordinate after the other; the truth value is whether
    the record holds.
    """
    tape = Tape()
    copy = _copy_of(solver, prescribed, tape)
    x, c = recorded_input(tape, 0, example.x), recorded_input(tape, 1, example.c)

    def computed() -> list[Array]:
        poses = SolverState(x, c)
        gradient, rates = copy.rates(prescribed, poses, np.zeros((prescribed.size, 1)))
        step = -least_squares(gradient, rates, prescribed.local_dofs)
        left = rates + np.einsum("mnN,nkN->mkN", gradient, step)  # in digits that the step has lost
        step = step - least_squares(gradient, left, prescribed.local_dofs)
        v = with_given(copy, prescribed, freedom_rates(copy, prescribed, gradient, rates, step))
        return [*(row for k in range(prescribed.size) for row in copy.tree.rates(x, v[:, k])), held(tape)]

    *numbers, holds = recorded_rows(tape, computed)
    return Program(tape, tuple(numbers), (holds,))


def place_record(solver: Solver, prescribed: PrescribedCoordinates, example: SolverState) -> Program:
    """Record :meth:`Solver.place`.

    The input is x, the numbers are q, rotations, positions and residual, and the truth value is whether the record holds.
    """
    tape = Tape()
    copy = _copy_of(solver, prescribed, tape)
    x = recorded_input(tape, 0, example.x)

    def computed() -> list[Array]:
        q, frames, residual = copy.equations.place(x)
        numbers = [q, frames.rotation.reshape(-1, 1), frames.position.reshape(-1, 1), residual]
        return [*(row for array in numbers for row in array), held(tape)]

    *numbers, holds = recorded_rows(tape, computed)
    return Program(tape, tuple(numbers), (holds,))


def held(tape: Tape) -> Number:
    """Return whether (1,) all guards up to now are met."""
    return recorded(np.array([tape.holds()], dtype=object))


def recorded_rows(tape: Tape, computed: Callable[[], list[Array]]) -> list[int]:
    """Return the numbers of the operations that give arrays (1,)."""
    with recording():
        return [tape.number_of(array[0]) for array in computed()]
