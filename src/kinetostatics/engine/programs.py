"""Compiled code of robots in memory, and the choice between compiled code and NumPy."""

from __future__ import annotations

import os
import threading
from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Generic, TypeAlias, TypeVar
from weakref import WeakKeyDictionary

import numpy as np

from kinetostatics.arguments import check_choice
from kinetostatics.kinematics.assembly import SolverChoice, by_numpy
from kinetostatics.kinematics.coordinates import PrescribedCoordinates
from kinetostatics.kinematics.robot_kinematics import RobotKinematics
from kinetostatics.kinematics.solver import Solver
from kinetostatics.progress import waiting
from kinetostatics.statics.link_loads import AppliedLoad
from kinetostatics.statics.loaded_poses import LoadedAttachments
from kinetostatics.statics.robot_statics import RobotStatics

if TYPE_CHECKING:
    from kinetostatics.engine.loops import CompiledSolver
    from kinetostatics.engine.pose_code import PoseCode

#: Names of the engines.
ENGINES = ("auto", "numpy", "compiled")
#: Environment variable with the engine that replaces "auto".
VARIABLE = "KINETOSTATICS_ENGINE"
#: Smallest number of poses for which "auto" loads code from disk, and for which it compiles code. For fewer poses NumPy is
#: faster. Code in memory is used for any number of poses.
READING, COMPILING = 1_000, 10_000

Made = TypeVar("Made")
Key = TypeVar("Key")


@dataclass
class _Program(Generic[Made]):
    """Code of a robot for one purpose, or the reason why it has none; both are None until the code is needed."""

    made: Made | None = None
    reason: str | None = None
    lock: threading.Lock = field(default_factory=threading.Lock)


_Programs: TypeAlias = WeakKeyDictionary[RobotKinematics, defaultdict[Key, _Program[Made]]]
_POSES: _Programs[tuple[LoadedAttachments | None, bool], PoseCode] = WeakKeyDictionary()
_LOOPS: _Programs[PrescribedCoordinates, CompiledSolver] = WeakKeyDictionary()
_LOCK = threading.Lock()


def _program_of(
    programs: _Programs[Key, Made], robot: RobotKinematics, key: Key, engine: str, poses: int, find: Callable[[bool], Made | None]
) -> _Program[Made]:
    """Return a program, with its code if the engine is "compiled", or if it is "auto" and there are enough poses.

    Args:
        programs: the programs of all robots for the same purpose.
        key: identifies the program among the programs of the robot.
        engine: "auto" or "compiled".
        poses: number of poses of the call.
        find: function that returns the code on disk, or None; if its argument is True, it compiles missing code.
    """
    with _LOCK:
        program = programs.setdefault(robot, defaultdict(_Program))[key]
    if program.made is None and program.reason is None and (engine == "compiled" or poses >= READING):
        from kinetostatics.engine.scalars import NotRecordedError

        with program.lock, waiting(f"compiling code for {robot.name}, once on this computer"):
            if program.made is None and program.reason is None:
                try:
                    program.made = find(engine == "compiled" or poses >= COMPILING)
                except NotRecordedError as error:
                    program.reason = str(error)
    return program


def check_engine(engine: str) -> str:
    """Return an engine; "auto" is replaced by the value of the environment variable :data:`VARIABLE`, if there is one.

    Raises:
        ArgumentError: the name is unknown.
    """
    check_choice("engine", engine, ENGINES)
    if engine == "auto" and (meant := os.environ.get(VARIABLE)):
        check_choice(VARIABLE, meant, ENGINES)
        engine = meant
    return engine


def engine_for(engine: str, poses: int) -> str:
    """Return the engine for each of several calls with ``poses`` poses in total, for instance the calls of a map."""
    return "compiled" if engine == "auto" and poses >= COMPILING else engine


def pose_code(
    robot: RobotKinematics,
    statics: RobotStatics,
    engine: str,
    poses: int,
    applied: tuple[AppliedLoad, ...] = (),
    *,
    stability: bool = False,
) -> PoseCode | None:
    """Return the compiled code that analyses poses, or None if NumPy analyses them.

    Args:
        engine: see :func:`check_engine`.
        applied: loads on links; the code depends on their places.
        stability: whether to return the code of the sufficient condition of stability instead. There is no such code for robots
            with springs or loads on links.
    """
    if engine == "numpy" or poses == 0 or (stability and (applied or statics.description.springs)):
        return None
    return _poses_of(robot, statics, engine, poses, LoadedAttachments.of(applied), stability).made


def compiled_statics(robot: RobotKinematics, statics: RobotStatics) -> PoseCode | str:
    """Return the code of a robot's equilibrium, which is compiled if missing; a text with the reason if it cannot be compiled."""
    program = _poses_of(robot, statics, "compiled", 1)
    return program.made or str(program.reason)


def _poses_of(
    robot: RobotKinematics,
    statics: RobotStatics,
    engine: str,
    poses: int,
    attachments: LoadedAttachments | None = None,
    stability: bool = False,
) -> _Program[PoseCode]:
    def find(anew: bool) -> PoseCode | None:
        from kinetostatics.engine.pose_code import ANALYSIS, STABILITY, PoseCode

        code = PoseCode(robot, statics, STABILITY if stability else ANALYSIS, attachments, anew=anew)
        return code if code.is_there else None

    return _program_of(_POSES, robot, (attachments, stability), engine, poses, find)


def compiled_loops(engine: str) -> SolverChoice:
    """Return a function that chooses the solver of a call: a :class:`CompiledSolver`, or the robot's own solver.

    Args:
        engine: see :func:`check_engine`.
    """
    if engine == "numpy":
        return by_numpy

    def chosen(robot: RobotKinematics, prescribed: PrescribedCoordinates, poses: int) -> Solver:
        return _loops_of(robot, engine, prescribed, poses).made or robot.solver

    return chosen


def loops_of(robot: RobotKinematics) -> CompiledSolver | str:
    """Return the compiled solver for given actuator coordinates; a text with the reason if it cannot be compiled."""
    program = _loops_of(robot, "compiled", robot.mobility_analysis.with_dofs(robot.actuator_coordinates), 1)
    return program.made or str(program.reason)


def _loops_of(robot: RobotKinematics, engine: str, prescribed: PrescribedCoordinates, poses: int) -> _Program[CompiledSolver]:
    def find(anew: bool) -> CompiledSolver | None:
        from kinetostatics.engine.loops import CompiledSolver

        example = robot.generic_poses.take(np.zeros(1, dtype=np.intp))
        solver = CompiledSolver(robot.solver, prescribed, example, anew)
        return solver if solver.is_there else None

    return _program_of(_LOOPS, robot, prescribed, engine, poses, find)
