"""The equilibrium of a robot's poses by compiled code, with the careful way of NumPy where the record does not hold.

What is recorded is :func:`kinetostatics.statics.springs.solve_with_springs` itself: there is no other mathematics here.
"""

from __future__ import annotations

import weakref
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cached_property

import numpy as np

from kinetostatics.engine import cache as disk
from kinetostatics.engine import llvm
from kinetostatics.engine.code import BLOCK, Code, code_key, packed, table_of
from kinetostatics.engine.frames import LaterFrames
from kinetostatics.engine.record import (
    Place,
    Record,
    agree,
    arrays_of,
    by_numpy,
    example_of,
    is_at_once,
    record_of,
    sizes_of_applied,
    solution_of,
    structure_of,
    wrenches_of,
)
from kinetostatics.engine.scalars import NotRecordedError
from kinetostatics.math.arrays import Array, Index, Mask
from kinetostatics.mechanism.tree import Frames
from kinetostatics.statics.link_loads import AppliedLoad, LoadedPlaces
from kinetostatics.statics.model import RobotStatics
from kinetostatics.statics.solution import Solution
from kinetostatics.statics.springs import solve_with_springs, sources_of


class CompiledStatics:
    """Compiled code for one robot.

    Attributes:
        operations: how many operations a pose takes.
    """

    def __init__(self, robot: RobotStatics, places: LoadedPlaces | None = None) -> None:
        """Find or make the code.

        Args:
            robot: the robot.
            places: at which loads act on its links.

        Raises:
            NotRecordedError: the robot's statics do something that cannot be recorded.
        """
        if not self._found(robot, places):
            kept = _compiled(record_of(robot, places), len(self._parameters), robot.example.position.shape[1])
            if not (self._load(kept) and self._is_right()):
                raise NotRecordedError("compiled code gives other numbers than NumPy")
            disk.write(self._key, kept)

    @classmethod
    def kept(cls, robot: RobotStatics, places: LoadedPlaces | None = None) -> CompiledStatics | None:
        """Return the code for a robot if it is on disk."""
        item = cls.__new__(cls)
        return item if item._found(robot, places) else None

    def _found(self, robot: RobotStatics, places: LoadedPlaces | None) -> bool:
        """Take the code from the disk, if it is there and right."""
        structure = structure_of(robot, places)
        self._loaded = places
        self._robot = weakref.ref(robot)  # by which the code is found: it must not keep the robot alive
        self._parameters = structure.values
        self._key = code_key(structure.key)
        kept = disk.read(self._key)
        if kept is None:
            return False
        return self._load(kept) and self._is_right()

    @property
    def robot(self) -> RobotStatics:
        """The robot, as long as somebody has it."""
        robot = self._robot()
        assert robot is not None
        return robot

    def _load(self, kept: bytes) -> bool:
        """Make code callable, if it takes arrays of the sizes that this robot has."""
        table = table_of(kept)
        if table["parameters"] != len(self._parameters) or table["bodies"] != self.robot.example.position.shape[1]:
            return False
        self._code = Code(kept)
        self._places = [(path, Place(tuple(shape), *rest)) for path, shape, *rest in table["places"]]
        self._rows, self._truths = int(table["numbers"]), int(table["truths"])
        self._soon, self._at_once = int(table["soon"]), {path: place for path, place in self._places if is_at_once(path)}
        self.operations = int(table["operations"])
        return True

    def _is_right(self) -> bool:
        """Whether the code gives at the example what NumPy gives: whatever may be wrong with code from a disk."""
        frames, load, gravity, *wrenches = example_of(self.robot, self._loaded)
        more = [] if self._loaded is None else [*wrenches, self._loaded]
        right = by_numpy(self.robot, frames, load, gravity, *more)
        applied = tuple(item.load for item in right.applied if item.load.kind == "load")
        numbers, truths = self._computed(frames, load, gravity, applied)
        if not truths[0, 0]:
            return False
        try:
            found = arrays_of(self._solution(frames, load, gravity, applied, numbers, truths))
        except KeyError:
            return False
        wanted = arrays_of(right)
        least = {".o": self.robot.length}  # which may be nothing but rounding, at the origin
        least |= sizes_of_applied(wanted)
        checked = [path for path in wanted if "unbalanced" not in path]  # which is rounding
        return all(agree(wanted[path], found[path], least.get(path, 1e-20)) for path in checked)

    def solve(self, frames: Frames, load: Array, gravity: Array, applied: tuple[AppliedLoad, ...] = ()) -> FoundAtOnce | Solution:
        """Solve N poses; see :func:`solve_with_springs`. The ``applied`` loads act at the places that the code is for."""
        N, robot = load.shape[1], self.robot
        few = N <= 2 * BLOCK
        numbers, truths = self._computed(frames, load, gravity, applied, whole=few)
        arrays = {path: place.of(numbers, truths, N) for path, place in self._at_once.items()}

        def whole() -> Solution:
            everything = (numbers, truths) if few else self._computed(frames, load, gravity, applied)
            return self._solution(frames, load, gravity, applied, *everything, robot)

        sources, doubtful = sources_of(robot, applied), np.flatnonzero(~truths[0])
        if doubtful.size:
            doubtful = doubtful[frames.take(doubtful).are_finite()]  # what is not reached has no numbers
        if not doubtful.size:
            return FoundAtOnce(sources, arrays, whole)
        here = frames.take(doubtful), load[:, doubtful], gravity[:, doubtful]
        careful = solve_with_springs(robot, *here, applied=tuple(item.take(doubtful) for item in applied))
        if doubtful.size == N:
            return careful
        merged = _merged(arrays, arrays_of(careful), doubtful)
        return FoundAtOnce(sources, merged, lambda: _merged_solution(robot, whole(), careful, doubtful, applied))

    def _computed(
        self, frames: Frames, load: Array, gravity: Array, applied: tuple[AppliedLoad, ...], whole: bool = True
    ) -> tuple[Array, Mask]:
        """Return all numbers (R, N), or the first, and truth values (T, N), the first of which says where the record holds."""
        N, before = load.shape[1], None
        if isinstance(frames, LaterFrames) and not whole:
            rotation, position, before = frames.in_blocks()
        else:
            rotation, position = frames.rotation.reshape(-1, N), frames.position.reshape(-1, N)
        inputs, rows = [rotation, position, load, gravity, *wrenches_of(applied)], self._rows if whole else self._soon
        return self._code.results(inputs, self._parameters, rows, self._truths, whole, before)

    def _solution(
        self,
        frames: Frames,
        load: Array,
        gravity: Array,
        applied: tuple[AppliedLoad, ...],
        numbers: Array,
        truths: Mask,
        robot: RobotStatics | None = None,
    ) -> Solution:
        arrays = {path: place.of(numbers, truths, load.shape[1]) for path, place in self._places}
        return solution_of(self.robot if robot is None else robot, frames, load, gravity, arrays, applied)


def _compiled(record: Record, parameters: int, bodies: int) -> bytes:
    """Return what is kept on disk, with a table of the places."""
    wanted = record.tape, record.numbers, record.truths, record.inputs
    table = {
        "places": [[path, place.shape, place.truth, place.first, place.values] for path, place in record.places.items()],
        "numbers": len(record.numbers),
        "truths": len(record.truths),
        "soon": record.soon,
        "parameters": parameters,
        "bodies": bodies,
        "operations": sum(llvm.needed_by(record.tape, (*record.numbers, *record.truths))),
    }
    return packed(table, llvm.module_of(*wanted, soon=record.soon))


def _merged(arrays: Mapping[str, Array], careful: Mapping[str, Array], which: Index) -> dict[str, Array]:
    """Return arrays whose poses ``which`` are those of others."""
    merged = {path: np.array(array) for path, array in arrays.items()}
    for path, array in merged.items():
        array[..., which] = careful[path]
    return merged


def _merged_solution(
    robot: RobotStatics, whole: Solution, careful: Solution, which: Index, applied: tuple[AppliedLoad, ...]
) -> Solution:
    arrays = _merged(arrays_of(whole), arrays_of(careful), which)
    return solution_of(robot, whole.frames, whole.load, whole.gravity, arrays, applied)


class FoundAtOnce:
    """What of the solution of many poses is there at once, see :class:`Solution`, and the whole when it is asked for.

    Attributes:
        sources, twists, singular, indeterminate, basis_degenerate, doubtful: as of a solution.
    """

    def __init__(self, sources: tuple[str, ...], arrays: Mapping[str, Array], whole: Callable[[], Solution]) -> None:
        self.sources, self._whole, self.twists = sources, whole, arrays[".twists"]
        self.singular, self.indeterminate, self.basis_degenerate = (
            np.asarray(arrays[f".{name}"], dtype=bool) for name in ("singular", "indeterminate", "basis_degenerate")
        )
        limbs = [np.any(array, axis=0) for path, array in arrays.items() if path.startswith(".statics.")]
        self.doubtful: Mask = np.logical_or.reduce([np.zeros_like(self.singular), *limbs])

    @cached_property
    def whole(self) -> Solution:
        """The solution."""
        return self._whole()

    def __reduce__(self) -> tuple[object, ...]:
        return replace, (self.whole,)
