"""Functions of a robot evaluated by compiled code: one pose by Newton's method from a neighbouring pose, or many poses at once.

Poses at which the compiled code may be invalid are computed by :func:`kinetostatics.kinematics.assembly.assemble` and
:func:`kinetostatics.analyze`.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.engine.loops import CompiledSolver
from kinetostatics.engine.pose_code import PoseCode
from kinetostatics.engine.programs import compiled_loops
from kinetostatics.engine.scalars import NotRecordedError, Number
from kinetostatics.functions.inputs_outputs import TOLERANCE, Values, flat_loads
from kinetostatics.kinematics import assembly
from kinetostatics.kinematics.configuration import Configuration, spread, taken
from kinetostatics.kinematics.coordinates import PrescribedCoordinates
from kinetostatics.kinematics.path_following import longest_strides
from kinetostatics.kinematics.solver import SolverState
from kinetostatics.math.arrays import Array, frozen
from kinetostatics.math.rotations import orientation_named
from kinetostatics.robot import Robot
from kinetostatics.status import Status

#: Outputs on which the validity of the others depends.
_CLOSED = ("worst_equation", "opening", "within", "singular", "usual")
_STATUSES = tuple(frozen(np.array(status, dtype=np.int8)) for status in (Status.LIMIT_EXCEEDED, Status.OK))


@dataclass(frozen=True)
class _Closed:
    """A pose with closed loops.

    Attributes:
        owner: the function that computed it.
        state: (nq' + 3, 1) coordinates x of the solver, then orientation coordinates c of the platform.
        target: prescribed coordinates [m, rad].
    """

    owner: CompiledFunction
    state: Array
    target: tuple[float, ...]

    @cached_property
    def poses(self) -> SolverState:
        return SolverState(self.state[:-3], self.state[-3:])


class CompiledFunction:
    """Compiled code of a function.

    Args:
        names: names of the prescribed coordinates.
        given: names of the prescribed coordinates that are arguments; the others are zero.

    Attributes:
        unique_below: magnitude [rad] below which orientation coordinates are unique, see :meth:`Orientation.is_unique`.

    Raises:
        NotRecordedError: there is no code for this robot.
    """

    def __init__(
        self,
        robot: Robot,
        prescribed: PrescribedCoordinates,
        orientation: str | None,
        names: Sequence[str],
        given: Sequence[str],
        outputs: Sequence[str],
    ) -> None:
        self._robot, self._names, self._given = robot, tuple(names), set(given)
        self._convention, self._by_actuators = orientation_named(orientation), not (prescribed.positions or prescribed.angles)
        self.prescribed = prescribed = robot.mobility_analysis.with_dofs(prescribed)
        solver = compiled_loops("compiled")(robot, prescribed, 1)
        if not isinstance(solver, CompiledSolver):
            raise NotRecordedError("the loops are not compiled")
        self._solver, self._stages = solver, ((*outputs, *_CLOSED),)
        self._code, self._most = PoseCode(robot, robot.statics, self._stages, lanes=1), robot.rough_residual
        self._strides = longest_strides(solver, prescribed).tolist()
        several = prescribed.angles and prescribed.orientation is not None
        self.unique_below = self._convention.unique_below if several else math.inf
        target, c = robot.zero_origin(prescribed)
        self._zero = _Closed(self, np.concatenate([robot.zero_poses.x, c]), tuple(target[:, 0].tolist()))
        self._moved, self._step = solver.single_step()
        self._load, self._gravity, self._computed = self._code.bound(self._moved[:-3])
        self._places = [
            (name, place.rows, tuple(place.shape)) for name, place in self._code.places.items() if name not in _CLOSED
        ]
        self._rows = tuple(self._code.places[name].rows.start for name in _CLOSED)
        self._lock = threading.Lock()  # calls share their arrays

    def single(
        self, coordinates: Mapping[str, Number], near: Configuration | Values | None, load: ArrayLike, gravity: ArrayLike
    ) -> Values | None:
        """Return the outputs at ``coordinates``, found from the neighbouring pose ``near``.

        None if an argument is not a finite number, the step is too long, Newton's method does not converge, or the code is not
        valid at the pose.
        """
        start = self._zero
        if near is not None:
            origin = near.origin if isinstance(near, Values) else None
            if not isinstance(origin, _Closed) or origin.owner is not self:
                return None
            start = origin
        if coordinates.keys() != self._given:
            return None
        for value in coordinates.values():
            if not (isinstance(value, (int, float)) and math.isfinite(value)):
                return None
        wrench, field = _column(load, 6), _column(gravity, 3)
        if wrench is None or field is None:
            return None
        target = self._target(coordinates)
        aim, state, first = np.array(target)[:, None], start.state, start.target
        if not max(map(abs, state[-3:, 0].tolist())) < self.unique_below:  # coordinates at the start of a line are not unique
            begin, c = self._solver.line(self.prescribed, start.poses, aim, near is not None)
            state, first = np.concatenate([start.poses.x, c]), tuple(begin[:, 0].tolist())
        for a, b, longest in zip(target, first, self._strides, strict=True):
            if not abs(a - b) <= longest:
                return None
        with self._lock:
            if not self._step(state, aim):
                return None
            self._load[:], self._gravity[:] = wrench, field
            numbers, truths = self._computed()
            there = _Closed(self, self._moved[:, :1].copy(), target)
        numbers, flags, (rough, opening, within, singular, usual) = numbers[:, 0], truths[:, 0].tolist(), self._rows
        if flags[singular] or not (flags[0] and flags[usual] and numbers[rough] <= self._most and numbers[opening] <= TOLERANCE):
            return None
        numbers.setflags(write=False)
        values = {name: numbers[rows].reshape(shape) for name, rows, shape in self._places}
        values |= {"status": _STATUSES[flags[within]], "residual": numbers[opening : opening + 1].reshape(())}
        return Values(values, lambda: self._configuration(there), there)

    @cached_property
    def _code_of_many(self) -> PoseCode:
        """Code for many poses, created on first use."""
        return PoseCode(self._robot, self._robot.statics, self._stages)

    def _target(self, coordinates: Mapping[str, Number]) -> tuple[float, ...]:
        return tuple([float(coordinates.get(name, 0.0)) for name in self._names])

    def origin(self, pose: Configuration, coordinates: Mapping[str, Number]) -> _Closed | None:
        """Return a pose as ``near`` of the next call; None if it is not a single reached pose."""
        if pose.shape or not pose.reached.all():
            return None
        return _Closed(self, np.concatenate([pose.poses.x, pose.poses.c]), self._target(coordinates))

    def _configuration(self, closed: _Closed) -> Configuration:
        names = () if self._by_actuators else self._names
        target = np.array(closed.target)[:, None]
        return assembly.closed_pose(
            self._robot,
            closed.poses,
            self._solver.place(closed.poses.x),
            shape=(),
            arrived=np.ones(1, dtype=bool),
            convention=self._convention,
            closure_tolerance=TOLERANCE,
            raising=False,
            solved=(self._solver, self.prescribed, target),
            names=names,
        )

    def many(
        self,
        pose: Configuration,
        load: ArrayLike,
        gravity: ArrayLike,
        by_analysis: Callable[[Configuration, Array, Array], Mapping[str, Array]],
    ) -> dict[str, Array]:
        """Return the outputs at poses, each (…, *shape).

        Args:
            load, gravity: (…, 6) [N, N·m] and (…, 3) [m/s²].
            by_analysis: function that returns the outputs at poses where the compiled code may be invalid.

        Raises:
            ArgumentError: shapes do not fit.
        """
        wrench, field, shape = flat_loads(load, gravity, pose.shape)
        poses = spread(pose, shape)
        numbers, truths = self._code_of_many.computed(poses.poses.x, wrench, field)
        arrays = {name: place.of(numbers, truths) for name, place in self._code_of_many.places.items()}
        rough, opening, within, singular, usual = (arrays.pop(name) for name in _CLOSED)
        fine = truths[0] & usual & ~singular & (rough <= self._most) & (opening <= TOLERANCE)
        outputs = {name: np.moveaxis(array, -1, 0).copy() for name, array in (arrays | {"residual": opening}).items()}
        outputs["status"] = np.where(within, Status.OK, Status.LIMIT_EXCEEDED).astype(np.int8)
        doubtful = np.flatnonzero(~(fine & poses.reached))
        if doubtful.size:
            here = taken(poses, doubtful, doubtful.shape)
            for name, array in by_analysis(here, wrench[:, doubtful].T, field[:, doubtful].T).items():
                outputs[name][doubtful] = array
        return {name: array.reshape((*shape, *array.shape[1:])) for name, array in outputs.items()}


def _column(value: ArrayLike, size: int) -> Array | None:
    """Return a vector of finite numbers as a column (size, 1); None for anything else."""
    try:
        array = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        return None
    return array[:, None] if array.shape == (size,) and math.isfinite(sum(array.tolist())) else None
