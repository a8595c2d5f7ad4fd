"""The record of a robot's equilibrium: what :func:`kinetostatics.statics.springs.solve_with_springs` does at one example pose."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, fields, is_dataclass
from functools import cached_property

import numpy as np

from kinetostatics.engine.recorder import Recorded, recording
from kinetostatics.engine.scalars import NotRecordedError, Number, Scalar, Tape, value_of
from kinetostatics.engine.structure import Structure
from kinetostatics.limbs.compliance import LimbLoads
from kinetostatics.limbs.statics import LimbStatics
from kinetostatics.math.arrays import Array, Mask
from kinetostatics.mechanism.tree import Frames
from kinetostatics.statics.link_loads import AppliedLoad, AppliedStatics, LoadedPlaces
from kinetostatics.statics.model import RobotStatics
from kinetostatics.statics.solution import Solution
from kinetostatics.statics.springs import count_of_tangents, loads_of_springs, solve_with_springs, sources_of

#: Load [N, N·m] and gravity [m/s²] of the example: nothing in particular, so that nothing vanishes.
_EXAMPLE_LOAD = (31.0, -17.0, -53.0, 7.0, 11.0, -3.0)
_EXAMPLE_GRAVITY = (0.7, -1.3, -9.1)
#: Why a robot with rigid limbs or springs that nothing holds is not recorded, and one whose rigid parts leave forces open.
SINGULAR = "the platform can move at generic poses, which singular values tell"
INDETERMINATE = "rigid limbs or rings overconstrain one another, so that singular values tell how their forces may change"
#: Why one is not of which NumPy solves already the example with more care than other poses.
CAREFUL = "a limb takes eigenvectors at generic poses already, as where self-stress is almost rigid"

#: How far two ways of computing an example may differ, beside the largest entry of an array.
_ALIKE = 1e-7
#: Arrays that are there at once, and arrays of each group of limbs.
AT_ONCE = ("twists", "singular", "indeterminate", "basis_degenerate")
AT_ONCE_OF_LIMBS = ("doubtful", "may_stiffen")


@dataclass(frozen=True)
class Place:
    """Where an array of the solution is: rows of the numbers or of the truth values, or a constant.

    Attributes:
        shape: without the poses.
        truth: whether its entries are truth values.
        first: number of its first row; None: it is a constant.
        values: of a constant, flat.
    """

    shape: tuple[int, ...]
    truth: bool
    first: int | None
    values: list[float | bool]

    def of(self, numbers: Array, truths: Mask, N: int) -> Number:
        """Return the array (*shape, N)."""
        if self.first is None:
            return self._constant if N == 1 else np.broadcast_to(self._constant, (*self.shape, N))
        rows = (truths if self.truth else numbers)[self.first : self._end]
        return rows.reshape(*self.shape, N)

    @cached_property
    def _end(self) -> int:
        return (self.first or 0) + math.prod(self.shape)

    @cached_property
    def _constant(self) -> Array:
        constant = np.array(self.values, dtype=bool if self.truth else float).reshape(*self.shape, 1)
        constant.setflags(write=False)
        return constant


@dataclass(frozen=True)
class Record:
    """What a robot's equilibrium takes, operation by operation.

    Attributes:
        tape: the operations; inputs are the frames' rotations and positions, load and gravity, in this order.
        numbers, truths: the operations whose results are wanted, in order; the first truth value is whether the record holds.
        places: where the arrays of the solution are among them, by their paths.
        soon: how many of the numbers, the first ones, the arrays take that are there at once.
        inputs: how many there are: five where loads act on links.
    """

    tape: Tape
    numbers: tuple[int, ...]
    truths: tuple[int, ...]
    places: Mapping[str, Place]
    soon: int
    inputs: int = 4


def record_of(robot: RobotStatics, places: LoadedPlaces | None = None) -> Record:
    """Record a robot's equilibrium, under loads on its links where ``places`` are loaded.

    Raises:
        NotRecordedError: it takes something that is not an operation on scalars.
    """
    tape = Tape()
    copy = structure_of(robot, places, tape).copy
    arrays = recorded_arrays(robot, tape, copy if places is None else copy[0], example_of(robot, places), arrays_of, places)
    rows: tuple[list[int], list[int]] = [], [tape.number_of(tape.holds())]
    known: dict[tuple[int, ...], int] = {}
    where = {}
    soon = 0
    for path, array in sorted(arrays.items(), key=lambda item: not is_at_once(item[0])):
        shape, flat = array.shape[:-1], array.ravel().tolist()
        truth = array.dtype == bool or (bool(flat) and all(isinstance(value_of(entry), bool) for entry in flat))
        if not any(isinstance(entry, Scalar) for entry in flat):
            where[path] = Place(shape, truth, None, [bool(entry) if truth else float(entry) for entry in flat])
            continue
        wanted_rows = tuple(tape.number_of(entry) for entry in flat)
        first = known.setdefault(wanted_rows, len(rows[truth]))
        if first == len(rows[truth]):
            rows[truth].extend(wanted_rows)
        where[path] = Place(shape, truth, first, [])
        soon = len(rows[0]) if is_at_once(path) else soon
    return Record(tape, tuple(rows[0]), tuple(rows[1]), where, soon, 4 if places is None else 5)


def recorded_arrays(
    robot: RobotStatics,
    tape: Tape,
    copy: RobotStatics,
    example: tuple[Number, ...],
    result: Callable[[Solution], Mapping[str, Array]],
    places: LoadedPlaces | None = None,
) -> Mapping[str, Array]:
    """Record what is wanted of a robot's equilibrium, as arrays of what the tape holds.

    Args:
        robot: the robot.
        tape: to write on.
        copy: the robot's data with recorded numbers.
        example: frames, load (6, 1) and gravity (3, 1) of the pose whose way is taken, and what acts at ``places`` (6 P, 1).
        result: what is wanted of the solution, by name.
        places: that are loaded.

    Raises:
        NotRecordedError: it takes something that is not an operation on scalars.
    """
    frames, *others = example
    inputs = frames.rotation, frames.position, *others
    rotation, position, *rest = (recorded_input(tape, number, array) for number, array in enumerate(inputs))
    with recording_equilibrium(robot):
        return result(by_numpy(copy, Frames(rotation, position), *rest, *([] if places is None else [places])))


@contextmanager
def recording_equilibrium(robot: RobotStatics) -> Iterator[None]:
    """Record the equilibrium of a robot inside.

    Raises:
        NotRecordedError: it takes something that is not an operation on scalars.
    """
    try:
        with recording():
            yield
    except NotRecordedError as error:
        found = solve_with_springs(robot, *example_of(robot))
        if found.singular[0] or found.indeterminate[0]:
            raise NotRecordedError(SINGULAR if found.singular[0] else INDETERMINATE) from error
        if isinstance(error.__cause__, IndexError):  # poses are picked out by what is recorded
            raise NotRecordedError(CAREFUL) from error
        raise


def recorded_input(tape: Tape, number: int, array: Array) -> Number:
    """Return what records an input array of one pose, whose values there are the example's."""
    scalars = np.empty(array.size, dtype=object)
    for k, value in enumerate(array.ravel().tolist()):
        scalars[k] = tape.write(("input", number, k), value)
    return scalars.reshape(array.shape).view(Recorded)


def example_of(robot: RobotStatics, places: LoadedPlaces | None = None) -> tuple[Number, ...]:
    """Return the example: frames of one generic pose, load (6, 1), gravity (3, 1), and what acts at ``places`` (6 P, 1)."""
    plain = robot.example, np.array([_EXAMPLE_LOAD]).T, np.array([_EXAMPLE_GRAVITY]).T
    if places is None:
        return plain
    count = 6 * sum(len(where) for _, where in places.loads)
    return *plain, (np.resize(_EXAMPLE_LOAD, count) * (1 + 0.1 * np.arange(count)))[:, None]


def structure_of(robot: RobotStatics, places: LoadedPlaces | None = None, tape: Tape | None = None) -> Structure:
    """Return what a record of a robot depends on, loaded at some places or not; see :class:`Structure`."""
    return Structure(robot if places is None else (robot, places), tape)


def by_numpy(
    robot: RobotStatics,
    frames: Frames,
    load: Array,
    gravity: Array,
    wrenches: Array | None = None,
    places: LoadedPlaces | None = None,
) -> Solution:
    """Solve as :func:`solve_with_springs`, also of one pose by the operations of many: what is recorded."""
    _, o = robot.mechanism.platform_pose(frames)
    weights = robot.weights.wrenches_of_many(frames, o, gravity)
    applied = () if places is None or wrenches is None else _loads_at(places, wrenches)
    return solve_with_springs(robot, frames, load, gravity, applied=applied, weights=weights)


def _loads_at(places: LoadedPlaces, wrenches: Array) -> tuple[AppliedLoad, ...]:
    """Return loads whose wrenches (6 P, N) are one behind the other."""
    rows = iter(wrenches.reshape(-1, 6, wrenches.shape[1]))
    return tuple(AppliedLoad(name, {place: next(rows) for place in where}) for name, where in places.loads)


def wrenches_of(applied: Iterable[AppliedLoad]) -> list[Array]:
    """Return what acts at all loaded places as one input (6 P, N) of a record; none where nothing does."""
    rows = [wrench for item in applied for wrench in item.wrenches.values()]
    return [np.concatenate(rows)] if rows else []


# ---- solutions taken apart ---------------------------------------------------------------------------------------------

#: What a solution and its limbs are given, not found.
_GIVEN = ("frames", "gravity", "load", "assembly_errors", "errors", "sources", "group")


def is_at_once(path: str) -> bool:
    """Return whether the array at a path of :func:`arrays_of` is there at once."""
    first, *others = path.strip(".").split(".")
    return first in AT_ONCE or (first == "statics" and others[1] in AT_ONCE_OF_LIMBS)


def arrays_of(solution: Solution) -> dict[str, Array]:
    """Return all arrays (…, N) that were found, by where they are."""
    return dict(_parts("", solution))


def _parts(path: str, item: object) -> Iterator[tuple[str, Array]]:
    if isinstance(item, np.ndarray):
        yield path, item
    elif isinstance(item, tuple):
        for k, part in enumerate(item):
            yield from _parts(f"{path}.{k}", part)
    elif isinstance(item, Mapping):
        for name, part in item.items():
            yield from _parts(f"{path}.{name}", part)
    elif is_dataclass(item):
        for field in fields(item):
            part = getattr(item, field.name)
            if field.name not in _GIVEN or (isinstance(part, AppliedLoad) and part.kind != "load"):
                yield from _parts(f"{path}.{field.name}", part)


def sizes_of_applied(arrays: Mapping[str, Array]) -> dict[str, float]:
    """Return for every array of what springs do how large the same is of any spring or weight: of one it may be rounding."""
    sizes: dict[str, float] = {}
    for path, array in arrays.items():
        if array.dtype != bool:
            kind = path.rpartition(".")[2]
            sizes[kind] = max(sizes.get(kind, 1e-20), float(np.nanmax(np.abs(array), initial=0.0)))
    return {path: sizes.get(path.rpartition(".")[2], 1e-20) for path in arrays if path.startswith(".applied.")}


def agree(wanted: Array, found: Array, least: float = 1e-20) -> bool:
    """Whether arrays are the same but for rounding of their largest entry, or of ``least``; NaN in the same places."""
    if wanted.shape != found.shape or wanted.dtype != found.dtype:
        return False
    if wanted.dtype == bool:
        return bool(np.array_equal(wanted, found))
    return bool(np.allclose(found, wanted, rtol=0, atol=_ALIKE * np.nanmax(np.abs(wanted), initial=least), equal_nan=True))


def solution_of(
    robot: RobotStatics,
    frames: Frames,
    load: Array,
    gravity: Array,
    arrays: Mapping[str, Array],
    applied: tuple[AppliedLoad, ...] = (),
) -> Solution:
    """Return the solution of which :func:`arrays_of` are those, under ``applied`` loads on links."""
    found: dict[str, Number] = {name: arrays[f".{name}"] for name in _FIELDS}
    groups = range(len(robot.groups))
    found |= {name: tuple(arrays[f".{name}.{k}"] for k in groups) for name in ("intensities", "undetermined", "open")}
    statics = _statics_of(robot, ".statics", arrays)
    loads = (*applied, *(AppliedLoad(name, {}, kind=kind) for name, kind in loads_of_springs(robot, applied)))
    if loads:
        found["applied"] = tuple(_applied_of(robot, k, item, arrays) for k, item in enumerate(loads))
        found["weights_alone"] = _statics_of(robot, ".weights_alone", arrays)
    if robot.parts is not None:
        found["tangents"] = tuple(arrays[f".tangents.{k}"] for k in range(count_of_tangents(robot)))
    first = ".unbalanced."
    found["unbalanced"] = {path.removeprefix(first): arrays[path] for path in arrays if path.startswith(first)}
    return Solution(
        frames=frames,
        load=load,
        gravity=gravity,
        assembly_errors=None,
        errors=tuple(None for _ in robot.groups),
        sources=sources_of(robot, applied),
        statics=statics,
        **found,
    )


def _statics_of(robot: RobotStatics, path: str, arrays: Mapping[str, Array]) -> tuple[Number, ...]:
    """Return the limbs at a path, group by group; None for those of which nothing is there."""
    found: list[LimbStatics | None] = []
    for k, group in enumerate(robot.groups):
        if f"{path}.{k}.J_c" not in arrays:
            found.append(None)
            continue
        loads = LimbLoads(*(arrays[f"{path}.{k}.loads.{field.name}"] for field in fields(LimbLoads)))
        own: dict[str, Number] = {name: arrays[f"{path}.{k}.{name}"] for name in _LIMB_FIELDS}
        found.append(LimbStatics(group=group, loads=loads, **own))
    return tuple(found)


def _applied_of(robot: RobotStatics, number: int, load: AppliedLoad, arrays: Mapping[str, Array]) -> AppliedStatics:
    """Return what a load does, a spring or a unit change of its force."""
    first = f".applied.{number}"

    def by_place(what: str) -> dict[str, Array]:
        start = f"{first}.load.{what}."
        return {path.removeprefix(start): array for path, array in arrays.items() if path.startswith(start)}

    if load.kind != "load":
        load = AppliedLoad(load.name, by_place("wrenches"), by_place("points"), load.kind)
    return AppliedStatics(load, _statics_of(robot, f"{first}.statics", arrays), arrays[f"{first}.share"])


_LIMB_FIELDS = tuple(field.name for field in fields(LimbStatics) if field.name not in ("group", "loads"))
_FIELDS = tuple(
    field.name
    for field in fields(Solution)
    if field.name
    not in (*_GIVEN, "statics", "intensities", "undetermined", "open", "unbalanced", "applied", "weights_alone", "tangents")
)
