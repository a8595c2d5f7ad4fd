"""Newton's method for the loops by compiled code, with NumPy's where the record does not hold.

What is recorded is :meth:`kinetostatics.kinematics.solver.Solver.correct`: there is no other mathematics here.
"""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable
from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from kinetostatics.engine import cache as disk
from kinetostatics.engine import llvm
from kinetostatics.engine.code import BLOCK, Bound, Code, code_key, packed, side_by_side
from kinetostatics.engine.later import LaterFrames
from kinetostatics.engine.loop_record import (
    GOOD,
    HOLDS,
    Program,
    newton_record,
    place_record,
    side_record,
    start_record,
    structure_of,
)
from kinetostatics.engine.scalars import NotRecordedError
from kinetostatics.kinematics.loop_constraints import Placed
from kinetostatics.kinematics.prescribed import PrescribedCoordinates, for_each
from kinetostatics.kinematics.solver import MOST_CORRECTIONS, SHRINKING, Solver, SolverState
from kinetostatics.math.arrays import Array
from kinetostatics.mechanism.tree import Frames

#: By how much [m, rad] coordinates of an example are changed when code is tried, and how far it may be from NumPy.
_TRIED, _ALIKE = 1e-3, 1e-9


def _placed_record(solver: Solver, prescribed: PrescribedCoordinates, example: SolverState, local: int) -> Program:
    """Record :meth:`Solver.place`, with q and the residual before the frames, which not everybody wants."""
    program, nq, closures = place_record(solver, prescribed, example, local), solver.mechanism.tree.nq, solver.equations.closures
    frames = len(program.numbers) - closures
    numbers = (*program.numbers[:nq], *program.numbers[frames:], *program.numbers[nq:frames])
    return replace(program, numbers=numbers, soon=nq + closures)


#: What is compiled: its name, its record, how many arrays it takes, and how often at most it is repeated.
_FUNCTIONS = (("newton", newton_record, 2, MOST_CORRECTIONS), ("place", _placed_record, 1, 0), ("side", side_record, 4, 0))


class CompiledSolver(Solver):
    """A solver whose corrections of poses with some prescribed coordinates are compiled.

    Attributes:
        is_quick: corrections cost less than predictions.
        operations: how many operations a correction takes.
    """

    is_quick = True

    def __init__(self, solver: Solver, prescribed: PrescribedCoordinates, local: int, example: SolverState) -> None:
        """Find or make the code.

        Args:
            solver: whose corrections they are.
            prescribed: which coordinates are given.
            local: number of freedoms that do not move the platform.
            example: one pose whose loops are closed.

        Raises:
            NotRecordedError: the equations do something that cannot be recorded.
        """
        if not self._found(solver, prescribed, local, example):
            kept = [
                _compiled(record(solver, prescribed, self._example, local), self._sizes, inputs, repeats)
                for _, record, inputs, repeats in self._functions
            ]
            if not (self._load(kept) and self._is_right()):
                raise NotRecordedError("compiled code closes the loops otherwise than NumPy")
            for key, content in zip(self._keys, kept, strict=True):
                disk.write(key, content)

    @classmethod
    def kept(cls, solver: Solver, prescribed: PrescribedCoordinates, local: int, example: SolverState) -> CompiledSolver | None:
        """Return the solver if its code is on disk."""
        item = cls.__new__(cls)
        return item if item._found(solver, prescribed, local, example) else None

    def _found(self, solver: Solver, prescribed: PrescribedCoordinates, local: int, example: SolverState) -> bool:
        """Take the code from the disk, if it is there and right."""
        vars(self).update(vars(solver))
        self._solver, self._own, self._local, self._lock = solver, prescribed, local, threading.Lock()
        self._example = SolverState(np.array(example.x), np.array(self.origin(prescribed, example)[1]))
        structure = structure_of(solver, prescribed, local)
        self._parameters, self._structure = structure.values, structure.key
        self._sizes = {"parameters": len(structure.values), "coordinates": self.tree.nq, "given": prescribed.size}
        # where freedoms are local, nobody asks on which side of a singular pose one is
        self._functions = _FUNCTIONS[:2] if local else _FUNCTIONS
        self._keys = [code_key(f"{what} {self._structure}") for what, *_ in self._functions]
        kept = [disk.read(key) for key in self._keys]
        return self._load([content for content in kept if content is not None]) and self._is_right()

    def _load(self, kept: list[bytes]) -> bool:
        if len(kept) < len(self._keys):
            return False
        codes = [Code(content, key) for content, key in zip(kept, self._keys, strict=True)]
        self._newton, self._place = codes[:2]
        self._side = None if self._local else codes[2]
        self.operations = int(self._newton.table["operations"])
        return all(code.table["sizes"] == self._sizes for code in codes)

    def _is_right(self) -> bool:
        """Whether the code finds beside the example what NumPy finds: whatever may be wrong with code from a disk."""
        target = self.values(self._own, self._example) + _TRIED
        found, good, holds = self._corrected(self._example, target, None, None)
        wanted, reached = Solver.newton(self, self._own, self._example, target, self._local)
        if not (holds[0] and good[0] == reached[0]):
            return False
        if np.max(np.abs(found.x - wanted.x), initial=np.max(np.abs(found.c - wanted.c))) > _ALIKE:
            return False
        if self._side is not None:
            sure = Solver.surely_on_one_side(self, self._own, self._example, wanted)
            if not np.array_equal(self._surely(self._side, self._example, wanted), sure):
                return False
        (here, holds), there = self._placed(wanted.x), Solver.place(self, wanted.x)
        pairs = (here.q, there.q), (here.frames.position, there.frames.position), (here.residual, there.residual)
        return bool(holds[0]) and all(np.max(np.abs(a - b), initial=0.0) <= _ALIKE for a, b in pairs)

    @cached_property
    def _start(self) -> Code | None:
        """Where lines start, made when the first does that is not known to start at the zero pose; None: that is NumPy's."""
        key = code_key(f"start {self._structure}")
        target = self.values(self._own, self._example) + _TRIED
        wanted = Solver.line(self, self._own, self._example, target)

        def right(kept: bytes | None) -> Code | None:
            if kept is None or (code := Code(kept, key)).table["sizes"] != self._sizes:
                return None
            *found, holds = self._started(code, self._example, target, True)
            alike = all(np.max(np.abs(a - b), initial=0.0) <= _ALIKE for a, b in zip(found, wanted, strict=True))
            return code if holds[0] and alike else None

        code = right(disk.read(key))
        if code is None:
            with contextlib.suppress(NotRecordedError):
                kept = _compiled(start_record(self._solver, self._own, self._example, self._local), self._sizes, 4, 0)
                code = right(kept)
                if code is not None:
                    disk.write(key, kept)
        return code

    def _started(self, code: Code, start: SolverState, target: Array, shorter: bool) -> tuple[Array, Array, NDArray[np.bool_]]:
        """Return the prescribed and the orientation coordinates where lines start, and where the record holds."""
        n, N = target.shape
        inputs = for_each(start.x, N), for_each(start.c, N), target, np.full((1, N), float(shorter))
        numbers, truths = code.results(inputs, self._parameters, n + 3, 1)
        return numbers[:n], numbers[n:], truths[0]

    def line(
        self, prescribed: PrescribedCoordinates, start: SolverState, target: Array, shorter: bool = True
    ) -> tuple[Array, Array]:
        """Return where lines from poses to targets (n, N) start, see :meth:`Solver.line`."""
        # the record turns actuators the shorter way in any case
        known = prescribed == self._own and (shorter or bool(prescribed.angles)) and target.shape[1] > 0
        code = self._start if known else None
        if code is None:
            return super().line(prescribed, start, target, shorter)
        first, c, holds = self._started(code, start, target, shorter)
        rest = np.flatnonzero(~holds)
        if rest.size:
            here = start if start.x.shape[1] == 1 else start.take(rest)
            first[:, rest], c[:, rest] = super().line(prescribed, here, target[:, rest], shorter)
        return first, c

    def newton(
        self,
        prescribed: PrescribedCoordinates,
        poses: SolverState,
        target: Array,
        local: int = 0,
        before: Array | None = None,
        passing: NDArray[np.bool_] | None = None,
    ) -> tuple[SolverState, NDArray[np.bool_]]:
        """Solve for ``target`` from nearby ``poses``; see :meth:`Solver.newton`."""
        if prescribed != self._own or local != self._local or target.shape[1] == 0:
            return super().newton(prescribed, poses, target, local, before, passing)
        found, good, holds = self._corrected(poses, target, before, passing)
        if not np.all(holds):
            rest = np.flatnonzero(~holds)
            some = (None if array is None else array[rest] for array in (before, passing))
            careful, good[rest] = super().newton(prescribed, poses.take(rest), target[:, rest], local, *some)  # type: ignore[arg-type]
            found.x[:, rest], found.c[:, rest] = careful.x, careful.c
        return found, good

    def _corrected(
        self, poses: SolverState, target: Array, before: Array | None, passing: NDArray[np.bool_] | None
    ) -> tuple[SolverState, NDArray[np.bool_], NDArray[np.bool_]]:
        """Return poses, which have converged, and where the record holds."""
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
        return SolverState(state[:size, :N], state[size : size + 3, :N]), flags[GOOD] != 0, flags[HOLDS] != 0

    def in_one_go(
        self, prescribed: PrescribedCoordinates, start: SolverState, target: Array, local: int = 0
    ) -> SolverState | None:
        """Return the pose at coordinates (n, 1) near one pose, see :meth:`Solver.in_one_go`."""
        if prescribed != self._own or local != self._local:
            return None
        with self._lock:
            moved, step = self._single
            if not step(np.concatenate([start.x, start.c]), target):
                return None
            found = moved[:, :1].copy()
            return SolverState(found[:-3], found[-3:])

    @cached_property
    def _single(self) -> tuple[Array, Callable[[Array, Array], bool]]:
        return self.single_step()

    def optimize(self) -> None:
        """Make code anew that was made in a hurry."""
        for code in (self._newton, self._side):
            if code is not None:
                code.optimize()

    def single_step(self) -> tuple[Array, Callable[[Array, Array], bool]]:
        """Return what goes from one closed pose to coordinates (n, 1) in one go, as :meth:`newton` and :meth:`on_one_side` do.

        It takes x and c of the pose, one below the other (nq' + 3, 1), and returns whether it arrived beyond doubt. Where it did,
        those of the pose found are in every column of the array that is returned here, which is used again by every call.
        """
        size, n = self.tree.nq, llvm.LANES
        state, given, first = np.empty((size + 8, n)), np.zeros((self._own.size + 1, n)), np.empty((size + 3, n))
        moved, flags, wanted = state[: size + 3], state[size + 3 :], given[:-1]
        poses, rule = SolverState(moved[:size], moved[size:]), np.array([[np.inf, SHRINKING, 1.0, 0.0, 1.0]]).T
        newton = Bound(self._newton, (state, given), self._parameters, state, np.empty((1, n), dtype=bool))
        sure = np.ones((1, n), dtype=bool)
        pair = first[:size], first[size:], poses.x, poses.c
        side = None if self._side is None else Bound(self._side, pair, self._parameters, np.empty((0, n)), sure)

        def step(start: Array, target: Array) -> bool:
            first[:] = moved[:] = start
            flags[:], wanted[:] = rule, target
            self.impose(self._own, poses, target)
            newton()
            if not (flags[GOOD, 0] and flags[HOLDS, 0]):
                return False
            if side is not None:
                side()
            return bool(sure[0, 0])

        return moved, step

    def on_one_side(
        self, prescribed: PrescribedCoordinates, first: SolverState, second: SolverState, target: Array
    ) -> NDArray[np.bool_]:
        """Return whether there is no singular pose (N,) between two poses each."""
        if prescribed != self._own or self._side is None or first.x.shape[1] == 0:
            return super().on_one_side(prescribed, first, second, target)
        found = self._surely(self._side, first, second)
        rest = np.flatnonzero(~found)
        if rest.size:
            found[rest] = super().on_one_side(prescribed, first.take(rest), second.take(rest), target[:, rest])
        return found

    def place(self, x: Array) -> Placed:
        """Return where coordinates ``x`` (nq', N) put everything."""
        if x.shape[1] == 0:
            return super().place(x)
        if x.shape[1] > 2 * BLOCK:
            return self._placed_later(x)
        found, holds = self._placed(x)
        rest = np.flatnonzero(~holds)
        if rest.size:
            careful = super().place(x[:, rest])
            found.q[:, rest], found.residual[:, rest] = careful.q, careful.residual
            found.frames.put(rest, careful.frames)
        return found

    @property
    def _rows(self) -> tuple[int, int, int, int]:
        """Of what is placed: where the residual, rotations and positions start, and the number of rows."""
        nq, bodies, soon = self.mechanism.tree.nq, self.mechanism.tree.bodies, self.mechanism.tree.nq + self.equations.closures
        return nq, soon, soon + 9 * bodies, soon + 12 * bodies

    def _placed(self, x: Array) -> tuple[Placed, NDArray[np.bool_]]:
        """Return where coordinates put everything, and where the record holds."""
        N, (nq, soon, turned, count) = x.shape[1], self._rows
        numbers, truths = self._place.results([x], self._parameters, count, 1)
        frames = Frames(numbers[soon:turned].reshape(3, 3, -1, N), numbers[turned:].reshape(3, -1, N))
        return Placed(numbers[:nq], frames, numbers[nq:soon]), truths[0]

    def _placed_later(self, x: Array) -> Placed:
        """Return where coordinates put everything; the frames are computed when they are asked for."""
        nq, soon, *_ = self._rows
        x = side_by_side(x, x.shape[1])
        numbers, truths = self._place.results([x], self._parameters, soon, 1, whole=False)
        rest = np.flatnonzero(~truths[0])
        if rest.size:
            careful = super().place(x[:, rest])
            numbers[:nq, rest], numbers[nq:, rest] = careful.q, careful.residual
        return Placed(numbers[:nq], LaterFrames(x, self), numbers[nq:])

    def frames_in_blocks(self, x: Array) -> tuple[Array, Array, Callable[[slice], None]]:
        """Return arrays for rotations (9 B, BLOCK) and positions (3 B, BLOCK), and what writes those of some poses there."""
        _, soon, turned, count = self._rows
        numbers, truths = np.empty((count, BLOCK)), np.empty((1, BLOCK), dtype=bool)
        rotation, position = numbers[soon:turned], numbers[turned:]
        bound = Bound(self._place, [x], self._parameters, numbers, truths)

        def write(part: slice) -> None:
            bound.move(part.start)
            bound()
            rest = np.flatnonzero(~truths[0])
            if rest.size:
                careful = Solver.place(self, x[:, part][:, rest]).frames
                rotation[:, rest], position[:, rest] = (a.reshape(-1, rest.size) for a in (careful.rotation, careful.position))

        return rotation, position, write

    def _surely(self, code: Code, first: SolverState, second: SolverState) -> NDArray[np.bool_]:
        return code.results((first.x, first.c, second.x, second.c), self._parameters, 0, 1)[1][0]


def _compiled(program: Program, sizes: dict[str, int], inputs: int, repeats: int) -> bytes:
    """Return what is kept on disk."""
    text = llvm.module_of(program.tape, program.numbers, program.truths, inputs, repeats, program.soon)
    operations = sum(llvm.needed_by(program.tape, (*program.numbers, *program.truths)))
    return packed({"sizes": sizes, "operations": operations}, text)
