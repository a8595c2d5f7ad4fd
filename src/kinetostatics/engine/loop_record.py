"""Records of loop closure: the scalar operations of the methods of :class:`kinetostatics.kinematics.solver.Solver`. A pose has
coordinates x (nq',) of the tree of joints and orientation coordinates c (3,) of the platform. A record is valid at poses that
meet its guards, the conditions of its branches. Lengths and placements are its parameters.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from kinetostatics.engine.recorder import Structure, recorded, recorded_input, recording
from kinetostatics.engine.scalars import Number, Tape
from kinetostatics.kinematics.coordinates import PrescribedCoordinates, line_start
from kinetostatics.kinematics.solver import Solver, SolverState
from kinetostatics.kinematics.velocities import freedom_rates, with_given
from kinetostatics.math.arrays import Array, Mask
from kinetostatics.math.linalg import least_squares

#: Rows of the state of :func:`newton_record` after the coordinates: size of the last correction; its ratio to the size of the
#: correction before; whether the pose needs another correction, has converged, and has met all guards in all corrections.
SIZE, RATIO, AGAIN, CONVERGED, VALID = range(5)


@dataclass(frozen=True)
class Program:
    """A record with its outputs.

    Attributes:
        tape: the record.
        numbers, truths: indices of the operations whose results are the outputs, numbers and truth values.
        stages: see :func:`kinetostatics.engine.llvm.module_of`.
    """

    tape: Tape
    numbers: tuple[int, ...]
    truths: tuple[int, ...]
    stages: tuple[int, ...] = ()


def _copy_of(solver: Solver, prescribed: PrescribedCoordinates, varying: Mask | None) -> tuple[Tape, Solver]:
    """Return a tape, and a copy of the solver with parameters recorded on the tape in place of numbers.

    ``varying``: which numbers of the whole solver are parameters, see :class:`Structure`; None: all that influence the record.
    """
    tape = Tape()
    return tape, Structure((solver, prescribed), tape, varying=varying, whole=varying is not None).copy[0]


def guards_met(tape: Tape) -> Number:
    """Whether all guards recorded so far are met: a recorded array (1,)."""
    return recorded(np.array([tape.holds()], dtype=object))


def program_of(
    tape: Tape, examples: Sequence[Array], computed: Callable[..., Sequence[Array]], stages: tuple[int, ...] = ()
) -> Program:
    """Record a function of arrays (k, 1); the last entry of the arrays that it returns is the truth value.

    Args:
        examples: values (k, 1) of the inputs; where the function branches, the branch for these values is recorded.
        stages: see :func:`kinetostatics.engine.llvm.module_of`.
    """
    inputs = [recorded_input(tape, number, array) for number, array in enumerate(examples)]
    with recording():
        *numbers, truth = (tape.number_of(row[0]) for array in computed(*inputs) for row in array.reshape(-1, 1))
    return Program(tape, tuple(numbers), (truth,), stages)


def newton_record(
    solver: Solver, prescribed: PrescribedCoordinates, example: SolverState, varying: Mask | None = None
) -> Program:
    """Record :meth:`Solver.correct` as a step from a state to the next state.

    A state has the coordinates x and c and the five rows ``SIZE`` … ``VALID``. Inputs: the state (nq' + 8,); the prescribed
    coordinates (n,), followed by 1 for an intermediate pose of a path, else 0. Outputs: the next state. Truth value: whether the
    pose needs another correction.
    """
    tape, copy = _copy_of(solver, prescribed, varying)
    size = example.x.shape[0]
    flags = np.array([[0.1, 0.4, 1.0, 0.0, 1.0]]).T
    given = np.append(solver.values(prescribed, example), [[0.0]], axis=0)

    def computed(state: Array, given: Array) -> list[Array]:
        poses, more = SolverState(state[:size], state[size : size + 3]), state[size + 3 :]
        going, passing = more[AGAIN] != 0, given[-1] != 0
        correction = copy.correct(prescribed, poses, given[:-1], more[SIZE], more[RATIO], passing)
        holds = guards_met(tape)
        again, good = going & correction.going & holds, (more[CONVERGED] != 0) | (going & correction.done)
        now = [*correction.poses.x, *correction.poses.c, correction.size, correction.shrunk]
        moved = [np.where(going, new, old) for new, old in zip(now, state[: size + 5], strict=True)]
        flags = [np.where(flag, 1.0, 0.0) for flag in (again, good, (more[VALID] != 0) & (holds | ~going))]
        return [*moved, *flags, again]

    return program_of(tape, [np.concatenate([example.x, example.c, flags]), given], computed)


def side_record(solver: Solver, prescribed: PrescribedCoordinates, example: SolverState, varying: Mask | None = None) -> Program:
    """Record :meth:`Solver.surely_on_one_side`.

    Inputs: x and c of a first pose, x and c of a second pose. Truth value: whether a sufficient condition excludes a singular
    pose between the two poses, and all guards are met.
    """
    tape, copy = _copy_of(solver, prescribed, varying)

    def computed(x: Array, c: Array, other_x: Array, other_c: Array) -> list[Array]:
        sure = copy.surely_on_one_side(prescribed, SolverState(x, c), SolverState(other_x, other_c))
        return [sure & guards_met(tape)]

    return program_of(tape, (example.x, example.c) * 2, computed)


def start_record(solver: Solver, prescribed: PrescribedCoordinates, example: SolverState, varying: Mask | None = None) -> Program:
    """Record :meth:`Solver.line`: the coordinates at the start of a straight line in the space of the prescribed coordinates.

    Inputs: x and c of the pose at the start, the prescribed coordinates (n,) at the end, and 1 if angles turn the shorter way,
    else 0. Outputs: prescribed coordinates (n,) and orientation coordinates (3,) at the start. Truth value: whether all guards
    are met.
    """
    tape, copy = _copy_of(solver, prescribed, varying)

    def computed(x: Array, c: Array, aim: Array, flag: Array) -> list[Array]:
        start = line_start(prescribed, copy.origin(prescribed, SolverState(x, c), aim), aim, flag[0] != 0)
        return [*start, guards_met(tape)]

    return program_of(tape, [example.x, example.c, solver.values(prescribed, example) + 0.1, np.ones((1, 1))], computed)


def rates_record(solver: Solver, prescribed: PrescribedCoordinates, example: SolverState) -> Program:
    """Record the rates dx/dt for unit rates of each prescribed coordinate, see :mod:`kinetostatics.kinematics.rates`.

    Inputs: x and c of a closed pose. Outputs: the rates (nq',), one prescribed coordinate after the other. Truth value: whether
    all guards are met.
    """
    tape, copy = _copy_of(solver, prescribed, None)

    def computed(x: Array, c: Array) -> list[Array]:
        gradient, rates = copy.rates(prescribed, SolverState(x, c), np.zeros((prescribed.size, 1)))
        step = -least_squares(gradient, rates, prescribed.local_dofs)
        # residual of the least-squares solution, for one step of refinement
        left = rates + np.einsum("mnN,nkN->mkN", gradient, step)
        step = step - least_squares(gradient, left, prescribed.local_dofs)
        v = with_given(copy, prescribed, freedom_rates(copy, prescribed, gradient, rates, step))
        return [*(copy.tree.rates(x, v[:, k]) for k in range(prescribed.size)), guards_met(tape)]

    return program_of(tape, [example.x, example.c], computed)


def place_record(solver: Solver, prescribed: PrescribedCoordinates, example: SolverState) -> Program:
    """Record :meth:`LoopEquations.place`.

    Input: x. Outputs of stage 0: Pinocchio's coordinates (nq,) and the loops' residual. Further outputs of stage 1: rotations
    (3, 3, B) and positions (3, B) of the B bodies. Truth value: whether all guards are met.
    """
    tape, copy = _copy_of(solver, prescribed, None)

    def computed(x: Array) -> list[Array]:
        q, frames, residual = copy.equations.place(x)
        return [q, residual, frames.rotation, frames.position, guards_met(tape)]

    return program_of(tape, [example.x], computed, (solver.mechanism.tree.nq + solver.equations.closures,))
