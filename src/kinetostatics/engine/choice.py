"""Which engine computes the equilibrium of poses: NumPy, which is always there, or compiled code."""

from __future__ import annotations

import importlib.util
import os
import threading
from collections.abc import Callable
from functools import cache
from typing import TYPE_CHECKING, TypeAlias
from weakref import WeakKeyDictionary

from kinetostatics.argument_checks import check_choice
from kinetostatics.exceptions import ArgumentError
from kinetostatics.math.arrays import Array
from kinetostatics.mechanism.tree import Frames
from kinetostatics.statics.model import RobotStatics
from kinetostatics.statics.solution import Solution

if TYPE_CHECKING:
    from kinetostatics.engine.statics import CompiledStatics

#: What may be asked for.
ENGINES = ("auto", "numpy", "compiled")
#: The environment variable that says what "auto" means.
VARIABLE = "KINETOSTATICS_ENGINE"

#: What NumPy takes for a call and for each pose, and from how much on it is worth while to look for code on disk, and to compile:
#: rough numbers [s], which do not depend on the processor, so that a program does the same every time.
_CALL, _POSE, _LOOKING, _COMPILING = 2e-3, 4e-6, 0.02, 1.0

Solver: TypeAlias = Callable[[Frames, Array, Array], Solution]


class _Choice:
    """What is known of one robot: its compiled code, or why there is none, and how much has been computed without."""

    def __init__(self) -> None:
        self.lock = threading.Lock()
        self.compiled: CompiledStatics | None = None
        self.reason: str | None = None
        self.work = 0.0
        self.key: str | None = None


_CHOICES: WeakKeyDictionary[RobotStatics, _Choice] = WeakKeyDictionary()
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


def compiled_solver(robot: RobotStatics, engine: str, poses: int) -> Solver | None:
    """Return what solves poses by compiled code; None where NumPy does.

    "auto" compiles when so much has been computed of robots of this structure that compiling would have paid, and takes code that
    is found on disk long before.

    Args:
        robot: the robot.
        engine: see :func:`check_engine`.
        poses: that are to be solved next.
    """
    if engine == "numpy" or poses == 0 or (engine == "auto" and not is_installed()):
        return None
    choice = _choice_of(robot)
    with choice.lock:
        work = _CALL + poses * _POSE
        choice.work += work
        if choice.compiled is None and choice.reason is None:
            if engine == "compiled":
                _compile(robot, choice)
            elif choice.work > _LOOKING:
                if choice.key is None:
                    from kinetostatics.engine.statics import CompiledStatics
                    from kinetostatics.engine.structure import Structure

                    structure = Structure(robot)
                    choice.key, work = structure.key, choice.work
                    choice.compiled = CompiledStatics.kept(robot, structure)
                _WORK[choice.key] = _WORK.get(choice.key, 0.0) + work
                if choice.compiled is None and _WORK[choice.key] > _COMPILING:
                    _WORK[choice.key] = 0.0
                    _compile(robot, choice)
    return None if choice.compiled is None else choice.compiled.solve


def compiled_statics(robot: RobotStatics) -> CompiledStatics | str:
    """Return a robot's compiled code, made now if need be; or why there is none."""
    if not is_installed():
        return "llvmlite is not installed: pip install 'kinetostatics[fast]'"
    choice = _choice_of(robot)
    with choice.lock:
        if choice.compiled is None and choice.reason is None:
            _compile(robot, choice)
    return choice.compiled or str(choice.reason)


def _choice_of(robot: RobotStatics) -> _Choice:
    with _LOCK:
        return _CHOICES.setdefault(robot, _Choice())


def _compile(robot: RobotStatics, choice: _Choice) -> None:
    from kinetostatics.engine.scalars import NotRecordedError
    from kinetostatics.engine.statics import CompiledStatics

    try:
        choice.compiled = CompiledStatics(robot)
    except NotRecordedError as error:
        choice.reason = str(error)
