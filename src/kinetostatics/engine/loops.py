"""Newton's method for closed loops by compiled code, and by NumPy at poses that do not meet the guards, its conditions of
validity. A pose has coordinates x (nq', N) of the tree of joints and orientation coordinates c (3, N) of the platform.
"""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable, Sequence
from functools import cached_property, partial
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinetostatics.engine import llvm
from kinetostatics.engine.code import BLOCK, LAST, Bound, Code, code_key, found_or_made, packed
from kinetostatics.engine.loop_record import (
    CONVERGED,
    VALID,
    Program,
    newton_record,
    place_record,
    side_record,
    start_record,
)
from kinetostatics.engine.recorder import Structure
from kinetostatics.engine.scalars import NotRecordedError, needed_by
from kinetostatics.kinematics.coordinates import PrescribedCoordinates, for_each
from kinetostatics.kinematics.loop_constraints import Placed
from kinetostatics.kinematics.solver import MOST_CORRECTIONS, SHRINKING, Solver, SolverState
from kinetostatics.math.arrays import Array, Index
from kinetostatics.mechanism.tree import Frames

#: A step from a closed pose to prescribed coordinates: an array for the new pose, and a function. The function takes x and c of
#: the closed pose (nq' + 3, 1) and the prescribed coordinates (n, 1); it returns whether Newton's method converged and no
#: singular pose lies between the poses. If so, all columns of the array are x and c of the new pose. Each call overwrites it.
Step: TypeAlias = tuple[Array, Callable[[Array, Array], bool]]

#: Step of the prescribed coordinates [m, rad] by which code is tested, and tolerance of the comparison with NumPy.
_TRIED, _ALIKE = 1e-3, 1e-9


#: A compiled function: name, function that records it, number of input arrays, largest number of iterations.
_Function: TypeAlias = tuple[str, Callable[[Solver, PrescribedCoordinates, SolverState], Program], int, int]
_FUNCTIONS: tuple[_Function, ...] = (
    ("newton", newton_record, 2, MOST_CORRECTIONS),
    ("place", place_record, 1, 0),
    ("side", side_record, 4, 0),
)
_START: _Function = ("start", start_record, 4, 0)


class CompiledSolver(Solver):
    """A solver with compiled corrections, for one choice of prescribed coordinates.

    Attributes:
        operations: number of operations of a correction.
        is_there: whether there is code; without code, the solver must not be used.
    """

    is_compiled = True

    def __init__(self, solver: Solver, prescribed: PrescribedCoordinates, example: SolverState, anew: bool = True) -> None:
        """Load the code from disk, or compile it.

        Args:
            example: one pose with closed loops.
            anew: whether to compile code that is not on disk.

        Raises:
            NotRecordedError: the equations cannot be recorded.
        """
        vars(self).update(vars(solver))
        self._solver, self._own, self._lock = solver, prescribed, threading.Lock()
        self._example = SolverState(np.array(example.x), np.array(self.origin(prescribed, example)[1]))
        structure = Structure((solver, prescribed))
        self._parameters, self._structure = structure.values, structure.key
        self._sizes = {"parameters": len(structure.values), "coordinates": self.tree.nq, "given": prescribed.size}
        # the test for singular poses is not used if some freedoms are local: if they do not move the platform
        self._functions = _FUNCTIONS[:2] if prescribed.local_dofs else _FUNCTIONS
        self.is_there = bool(self._codes(self._functions, self._is_right, llvm.LANES if anew else 0))
        if anew and not self.is_there:
            raise NotRecordedError("compiled loop closure differs from NumPy's")

    def _codes(self, functions: Sequence[_Function], is_right: Callable[[list[Code]], bool], lanes: int) -> list[Code]:
        """Return the code of functions, see :func:`found_or_made`; with 0 ``lanes`` nothing is compiled.

        Raises:
            NotRecordedError: the equations cannot be recorded.
        """
        given = self._solver, self._own, self._example
        make = [partial(_compiled, function[1], given, self._sizes, *function[2:], lanes) for function in functions]
        keys = [code_key(f"{what} {self._structure}") for what, *_ in functions]

        def fits(codes: list[Code]) -> bool:
            return all(code.table["sizes"] == self._sizes for code in codes) and is_right(codes)

        return found_or_made(keys, make if lanes else None, fits)

    def _is_right(self, codes: list[Code]) -> bool:
        """Set ``codes`` as code of the solver, and return whether its results near the example agree with NumPy's."""
        self._newton, self._place = codes[:2]
        self._side = None if self._own.local_dofs else codes[2]
        self.operations = int(self._newton.table["operations"])
        target = self.values(self._own, self._example) + _TRIED
        computed, good, holds = self._corrected(self._example, target, None, None)
        expected, reached = Solver.newton(self, self._own, self._example, target)
        if not (holds[0] and good[0] == reached[0]):
            return False
        if np.max(np.abs(computed.x - expected.x), initial=np.max(np.abs(computed.c - expected.c))) > _ALIKE:
            return False
        if self._side is not None:
            sure = Solver.surely_on_one_side(self, self._own, self._example, expected)
            if not np.array_equal(self._surely(self._side, self._example, expected), sure):
                return False
        (here, holds), there = self._placed(expected.x), Solver.place(self, expected.x)
        pairs = (here.q, there.q), (here.frames.position, there.frames.position), (here.residual, there.residual)
        return bool(holds[0]) and all(np.max(np.abs(a - b), initial=0.0) <= _ALIKE for a, b in pairs)

    @cached_property
    def _start(self) -> Code | None:
        """Code of :func:`.start_record`, compiled on first use; None if it cannot be recorded."""
        target = self.values(self._own, self._example) + _TRIED
        expected = Solver.line(self, self._own, self._example, target)

        def is_right(codes: list[Code]) -> bool:
            *computed, holds = self._started(codes[0], self._example, target, True)
            return bool(holds[0]) and all(
                np.max(np.abs(a - b), initial=0.0) <= _ALIKE for a, b in zip(computed, expected, strict=True)
            )

        with contextlib.suppress(NotRecordedError):
            codes = self._codes([_START], is_right, llvm.LANES)
            return codes[0] if codes else None
        return None

    def _started(self, code: Code, start: SolverState, target: Array, shorter: bool) -> tuple[Array, Array, NDArray[np.bool_]]:
        """Return prescribed coordinates (n, N) and orientation coordinates (3, N) at line starts; True where guards are met."""
        n, N = target.shape
        x, c = (start.x, start.c) if N == 1 else (for_each(start.x, N), for_each(start.c, N))
        inputs = x, c, target, np.full((1, N), float(shorter))
        numbers, truths = code.results(inputs, self._parameters, n + 3, 1)
        return numbers[:n], numbers[n:], truths[0]

    def line(
        self, prescribed: PrescribedCoordinates, start: SolverState, target: Array, shorter: bool = True
    ) -> tuple[Array, Array]:
        # the record turns actuators the shorter way
        is_recorded = prescribed == self._own and (shorter or bool(prescribed.angles)) and target.shape[1] > 0
        code = self._start if is_recorded else None
        if code is None:
            return super().line(prescribed, start, target, shorter)
        first, c, holds = self._started(code, start, target, shorter)
        if not holds.all():
            unmet = np.flatnonzero(~holds)
            here = start if start.x.shape[1] == 1 else start.take(unmet)
            first[:, unmet], c[:, unmet] = super().line(prescribed, here, target[:, unmet], shorter)
        return first, c

    def newton(
        self,
        prescribed: PrescribedCoordinates,
        poses: SolverState,
        target: Array,
        before: Array | None = None,
        passing: NDArray[np.bool_] | None = None,
    ) -> tuple[SolverState, NDArray[np.bool_]]:
        if prescribed != self._own or target.shape[1] == 0:
            return super().newton(prescribed, poses, target, before, passing)
        corrected, good, holds = self._corrected(poses, target, before, passing)
        if not np.all(holds):
            unmet = np.flatnonzero(~holds)
            some = (None if array is None else array[unmet] for array in (before, passing))
            careful, good[unmet] = super().newton(prescribed, poses.take(unmet), target[:, unmet], *some)  # type: ignore[arg-type]
            corrected.x[:, unmet], corrected.c[:, unmet] = careful.x, careful.c
        return corrected, good

    def _corrected(
        self, poses: SolverState, target: Array, before: Array | None, passing: NDArray[np.bool_] | None
    ) -> tuple[SolverState, NDArray[np.bool_], NDArray[np.bool_]]:
        """Return the corrected poses; True where Newton's method has converged (N,); True where the guards are met (N,)."""
        (size, N), count = poses.x.shape, target.shape[0]
        n = max(N, llvm.LANES)
        state, given = np.empty((size + 8, n)), np.empty((count + 1, n))
        state[:size, :N], state[size : size + 3, :N] = poses.x, poses.c
        state[size + 3, :N] = np.inf if before is None else before
        state[size + 4 :, :N] = [[SHRINKING], [1.0], [0.0], [1.0]]
        given[:count, :N], given[count, :N] = target, 0.0 if passing is None else passing
        self.impose(self._own, SolverState(state[:size, :N], state[size : size + 3, :N]), target)
        if n > N:
            state[:, N:], given[:, N:] = state[:, N - 1 : N], given[:, N - 1 : N]
        self._newton((state, given), self._parameters, state, np.empty((1, n), dtype=bool))
        flags = state[size + 3 :, :N]
        return SolverState(state[:size, :N], state[size : size + 3, :N]), flags[CONVERGED] != 0, flags[VALID] != 0

    def in_one_go(self, prescribed: PrescribedCoordinates, start: SolverState, target: Array) -> SolverState | None:
        if prescribed != self._own:
            return None
        with self._lock:
            moved, step = self._single
            if not step(np.concatenate([start.x, start.c]), target):
                return None
            state = moved[:, :1].copy()
            return SolverState(state[:-3], state[-3:])

    @cached_property
    def _single(self) -> Step:
        return self._step_of([self._newton] if self._side is None else [self._newton, self._side])

    def single_step(self) -> Step:
        """Return a :data:`Step` by code that is compiled for single poses."""
        functions = [(f"{function[0]}_of_one", *function[1:]) for function in self._functions if function[0] != "place"]
        target = self.values(self._own, self._example) + _TRIED
        start = np.concatenate([self._example.x, self._example.c])
        expected = self.in_one_go(self._own, self._example, target)

        def is_right(codes: list[Code]) -> bool:
            moved, step = self._step_of(codes)
            if step(start, target) != (expected is not None):
                return False
            return expected is None or np.max(np.abs(moved - np.concatenate([expected.x, expected.c]))) <= _ALIKE

        codes = self._codes(functions, is_right, 1)
        return self._step_of(codes) if codes else self._single

    def _step_of(self, codes: list[Code]) -> Step:
        """Return a :data:`Step` by the code of the corrections and, unless freedoms are local, of the test for singular poses."""
        size, n = self.tree.nq, codes[0].lanes
        state, given, first = np.empty((size + 8, n)), np.zeros((self._own.size + 1, n)), np.empty((size + 3, n))
        moved, flags, expected = state[: size + 3], state[size + 3 :], given[:-1]
        poses, rule = SolverState(moved[:size], moved[size:]), np.array([[np.inf, SHRINKING, 1.0, 0.0, 1.0]]).T
        newton = Bound(codes[0], (state, given), self._parameters, state, np.empty((1, n), dtype=bool))
        sure = np.ones((1, n), dtype=bool)
        pair = first[:size], first[size:], poses.x, poses.c
        side = None if self._own.local_dofs else Bound(codes[1], pair, self._parameters, np.empty((0, n)), sure)

        def step(start: Array, target: Array) -> bool:
            first[:] = moved[:] = start
            flags[:], expected[:] = rule, target
            self.impose(self._own, poses, target)
            newton()
            if not (flags[CONVERGED, 0] and flags[VALID, 0]):
                return False
            if side is not None:
                side()
            return bool(sure[0, 0])

        return moved, step

    def on_one_side(
        self, prescribed: PrescribedCoordinates, first: SolverState, second: SolverState, target: Array
    ) -> NDArray[np.bool_]:
        if prescribed != self._own or self._side is None or first.x.shape[1] == 0:
            return super().on_one_side(prescribed, first, second, target)
        sure = self._surely(self._side, first, second)
        unsure = np.flatnonzero(~sure)
        if unsure.size:
            sure[unsure] = super().on_one_side(prescribed, first.take(unsure), second.take(unsure), target[:, unsure])
        return sure

    def place(self, x: Array) -> Placed:
        if x.shape[1] == 0:
            return super().place(x)
        placed, holds = self._placed(x, 0 if x.shape[1] > 2 * BLOCK else LAST)
        if not holds.all():
            unmet = np.flatnonzero(~holds)
            careful = super().place(x[:, unmet])
            placed.q[:, unmet], placed.residual[:, unmet] = careful.q, careful.residual
            placed.frames.put(unmet, careful.frames)
        return placed

    def _placed(self, x: Array, stage: int = LAST) -> tuple[Placed, NDArray[np.bool_]]:
        """Return the placed bodies; True where the guards are met (N,). In stage 0 the frames are computed on first use."""
        nq, bodies, soon = self.mechanism.tree.nq, self.mechanism.tree.bodies, self.mechanism.tree.nq + self.equations.closures
        turned, N = soon + 9 * bodies, x.shape[1]
        numbers, truths = self._place.results([x], self._parameters, turned + 3 * bodies if stage else soon, 1, stage)
        if not stage:
            return Placed(numbers[:nq], _LaterFrames(x, self._frames), numbers[nq:]), truths[0]
        frames = Frames(numbers[soon:turned].reshape(3, 3, -1, N), numbers[turned:].reshape(3, -1, N))
        return Placed(numbers[:nq], frames, numbers[nq:soon]), truths[0]

    def _frames(self, x: Array) -> Frames:
        placed, holds = self._placed(x)
        if not holds.all():
            unmet = np.flatnonzero(~holds)
            placed.frames.put(unmet, Solver.place(self, x[:, unmet]).frames)
        return placed.frames

    def _surely(self, code: Code, first: SolverState, second: SolverState) -> NDArray[np.bool_]:
        return code.results((first.x, first.c, second.x, second.c), self._parameters, 0, 1)[1][0]


def _compiled(
    record: Callable[..., Program], given: tuple[object, ...], sizes: dict[str, int], inputs: int, repeats: int, lanes: int
) -> bytes:
    """Return the content of a file of code: the compiled record of one function."""
    program = record(*given)
    operations = sum(needed_by(program.tape, (*program.numbers, *program.truths)))
    text = llvm.module_of(program.tape, program.numbers, program.truths, inputs, repeats, program.stages, lanes)
    return packed({"sizes": sizes, "operations": operations}, text, lanes)


class _LaterFrames(Frames):
    """Frames of poses, computed on first use.

    Attributes:
        x: (nq', N) coordinates, shared with the poses: if the coordinates are corrected before the first use, the frames change
            as well.
    """

    x: Array

    def __init__(self, x: Array, place: Callable[[Array], Frames]) -> None:
        vars(self).update(x=x, _place=place)

    @cached_property
    def computed(self) -> Frames:
        place: Callable[[Array], Frames] = vars(self)["_place"]
        return place(self.x)

    @property
    def rotation(self) -> Array:  # type: ignore[override]
        return self.computed.rotation

    @property
    def position(self) -> Array:  # type: ignore[override]
        return self.computed.position

    def take(self, poses: Index | slice) -> Frames:
        return self.computed.take(poses) if "computed" in vars(self) else _LaterFrames(self.x[:, poses], vars(self)["_place"])

    def put(self, poses: Index, others: Frames) -> None:
        """Replace the frames of some poses; before the first use nothing is replaced, since frames still follow from ``x``."""
        if "computed" in vars(self):
            self.computed.put(poses, others)

    def __reduce__(self) -> tuple[object, ...]:
        """Copy and pickle the computed frames."""
        return Frames, (self.computed.rotation, self.computed.position)
