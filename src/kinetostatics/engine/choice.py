"""Which engine closes the loops of poses and computes their equilibrium: NumPy, which is always there, or compiled code."""

from __future__ import annotations

import importlib.util
import os
import threading
from collections import defaultdict
from collections.abc import Callable, Mapping
from functools import cache
from typing import TYPE_CHECKING, Generic, TypeAlias, TypeVar
from weakref import WeakKeyDictionary

import numpy as np

from kinetostatics.argument_checks import check_choice
from kinetostatics.exceptions import ArgumentError
from kinetostatics.kinematics.assembly import SolverChoice, by_numpy
from kinetostatics.kinematics.prescribed import PrescribedCoordinates
from kinetostatics.kinematics.robot_kinematics import RobotKinematics
from kinetostatics.kinematics.solver import Solver, SolverState
from kinetostatics.math.arrays import Array
from kinetostatics.mechanism.tree import Frames
from kinetostatics.statics.link_loads import AppliedLoad, LoadedPlaces
from kinetostatics.statics.model import RobotStatics
from kinetostatics.statics.solution import Solution

if TYPE_CHECKING:
    from kinetostatics.engine.loops import CompiledSolver
    from kinetostatics.engine.statics import CompiledStatics

#: What may be asked for.
ENGINES = ("auto", "numpy", "compiled")
#: The environment variable that says what "auto" means.
VARIABLE = "KINETOSTATICS_ENGINE"

#: What NumPy takes for a call and for each pose, and from how much on it is worth while to look for code on disk, and to compile:
#: rough numbers [s], which do not depend on the processor, so that a program does the same every time.
_CALL, _POSE, _LOOKING, _COMPILING = 2e-3, 4e-6, 0.02, 1.0
#: The same of closing the loops.
_LOOP_CALL, _LOOP_POSE = 4e-3, 12e-6
_NOT_INSTALLED = "llvmlite is not installed: pip install 'kinetostatics[fast]'"

StaticsSolver: TypeAlias = Callable[[Frames, Array, Array, tuple[AppliedLoad, ...]], Solution]


Made = TypeVar("Made")


class _Choice(Generic[Made]):
    """What is known of one robot: its compiled code, or why there is none, and how much has been computed without."""

    def __init__(self) -> None:
        self.lock = threading.Lock()
        self.compiled: Made | None = None
        self.reason: str | None = None
        self.work = 0.0
        self.key: str | None = None

    def decide(
        self, engine: str, work: float, look: Callable[[], tuple[str, Made | None]], make: Callable[[], Made]
    ) -> Made | None:
        """Return the code if it is to be used.

        Args:
            engine: "auto" or "compiled".
            work: what NumPy takes for what is to be computed next [s].
            look: returns the structure's key, and the code if it is on disk.
            make: compiles.
        """
        if not self.lock.acquire(blocking=engine == "compiled"):
            return self.compiled  # NumPy while another thread compiles
        try:
            self.work += work
            if self.compiled is None and self.reason is None:
                if engine == "compiled":
                    self.make(make)
                elif self.work > _LOOKING:
                    if self.key is None:
                        self.key, self.compiled = look()
                        work = self.work
                    _WORK[self.key] = _WORK.get(self.key, 0.0) + work
                    if self.compiled is None and _WORK[self.key] > _COMPILING:
                        _WORK[self.key] = 0.0
                        self.make(make)
            return self.compiled
        finally:
            self.lock.release()

    def make(self, make: Callable[[], Made]) -> None:
        """Compile, or remember why that cannot be done."""
        from kinetostatics.engine.scalars import NotRecordedError

        try:
            self.compiled = make()
        except NotRecordedError as error:
            self.reason = str(error)


_CHOICES: WeakKeyDictionary[RobotStatics, defaultdict[LoadedPlaces | None, _Choice[CompiledStatics]]] = WeakKeyDictionary()
_LOOPS: WeakKeyDictionary[RobotKinematics, defaultdict[tuple[PrescribedCoordinates, int], _Choice[CompiledSolver]]] = (
    WeakKeyDictionary()
)
_LOCK = threading.Lock()
#: How much has been computed without compiled code of robots of one structure, such as those of a sweep over diameters.
_WORK: dict[str, float] = {}


@cache
def is_installed() -> bool:
    """Whether what compiles is installed."""
    return importlib.util.find_spec("llvmlite") is not None


def check_engine(engine: str) -> str:
    """Return the engine that is meant.

    Raises:
        ArgumentError: there is none of that name, or it is not installed.
    """
    check_choice("engine", engine, ENGINES)
    if engine == "auto" and (meant := os.environ.get(VARIABLE)):
        check_choice(VARIABLE, meant, ENGINES)
        engine = meant
    if engine == "compiled" and not is_installed():
        raise ArgumentError("the compiled engine needs llvmlite: pip install 'kinetostatics[fast]'; or take engine=\"numpy\"")
    return engine


def compiled_solver(robot: RobotStatics, engine: str, poses: int, applied: tuple[AppliedLoad, ...] = ()) -> StaticsSolver | None:
    """Return what solves poses by compiled code; None where NumPy does.

    "auto" compiles when so much has been computed of robots of this structure that compiling would have paid, and takes code that
    is found on disk long before.

    Args:
        robot: the robot.
        engine: see :func:`check_engine`.
        poses: that are to be solved next.
        applied: loads on links: the code is for the places at which they act.
    """
    if engine == "numpy" or poses == 0 or (engine == "auto" and not is_installed()):
        return None
    places = LoadedPlaces.of(applied)
    look, make = (lambda: _statics_on_disk(robot, places)), (lambda: _compiled_statics(robot, places))
    found = _choice_of(robot, places).decide(engine, _CALL + poses * _POSE, look, make)
    return None if found is None else found.solve


def compiled_loops(engine: str) -> SolverChoice:
    """Return what says which solver closes the loops of poses: one whose corrections are compiled, or the robot's own.

    Args:
        engine: see :func:`check_engine`; "auto" compiles when that has paid, as :func:`compiled_solver` does.
    """
    if engine == "numpy" or (engine == "auto" and not is_installed()):
        return by_numpy

    def chosen(robot: RobotKinematics, prescribed: PrescribedCoordinates, local: int, poses: int) -> Solver:
        choice = _loop_choice_of(robot, prescribed, local)
        if choice.compiled is not None:
            return choice.compiled
        work = _LOOP_CALL + poses * _LOOP_POSE
        if engine == "auto" and choice.work + work < _LOOKING:
            choice.work += work
            return robot.solver

        def make() -> CompiledSolver:
            from kinetostatics.engine.loops import CompiledSolver

            return CompiledSolver(robot.solver, prescribed, local, _example(robot))

        def look() -> tuple[str, CompiledSolver | None]:
            from kinetostatics.engine.loop_record import structure_of
            from kinetostatics.engine.loops import CompiledSolver

            key = structure_of(robot.solver, prescribed, local).key
            return key, CompiledSolver.kept(robot.solver, prescribed, local, _example(robot))

        return choice.decide(engine, work, look, make) or robot.solver

    return chosen


def loops_for(analysis: Mapping[str, object]) -> SolverChoice:
    """Return what closes the loops of poses that are analysed with arguments of :func:`kinetostatics.analyze`."""
    return compiled_loops(check_engine(str(analysis.get("engine", "auto"))))


def loops_of(robot: RobotKinematics) -> CompiledSolver | str:
    """Return what closes a robot's loops at given actuators, compiled now if need be; or why that cannot be."""
    if not is_installed():
        return _NOT_INSTALLED
    analysis = robot.mobility_analysis
    prescribed = analysis.without_idle_dofs(robot.actuator_coordinates)
    local = analysis.local_dofs(prescribed)
    compiled_loops("compiled")(robot, prescribed, local, 1)
    choice = _loop_choice_of(robot, prescribed, local)
    return choice.compiled or str(choice.reason)


def _example(robot: RobotKinematics) -> SolverState:
    return robot.generic_poses.take(np.zeros(1, dtype=np.intp))


def _loop_choice_of(robot: RobotKinematics, prescribed: PrescribedCoordinates, local: int) -> _Choice[CompiledSolver]:
    with _LOCK:
        return _LOOPS.setdefault(robot, defaultdict(_Choice))[prescribed, local]


def compiled_statics(robot: RobotStatics) -> CompiledStatics | str:
    """Return a robot's compiled code, made now if need be; or why there is none."""
    if not is_installed():
        return _NOT_INSTALLED
    choice = _choice_of(robot)
    with choice.lock:
        if choice.compiled is None and choice.reason is None:
            choice.make(lambda: _compiled_statics(robot))
    return choice.compiled or str(choice.reason)


def _choice_of(robot: RobotStatics, places: LoadedPlaces | None = None) -> _Choice[CompiledStatics]:
    with _LOCK:
        return _CHOICES.setdefault(robot, defaultdict(_Choice))[places]


def _statics_on_disk(robot: RobotStatics, places: LoadedPlaces | None) -> tuple[str, CompiledStatics | None]:
    from kinetostatics.engine.record import structure_of
    from kinetostatics.engine.statics import CompiledStatics

    structure = structure_of(robot, places)
    return structure.key, CompiledStatics.kept(robot, structure, places)


def _compiled_statics(robot: RobotStatics, places: LoadedPlaces | None = None) -> CompiledStatics:
    from kinetostatics.engine.statics import CompiledStatics

    return CompiledStatics(robot, places)
