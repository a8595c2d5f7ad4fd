"""Report on the computations for a robot that run as compiled code, with reasons for the others."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from kinetostatics.engine.code import cache_folder
from kinetostatics.engine.programs import compiled_statics, loops_of
from kinetostatics.exceptions import ArgumentError
from kinetostatics.kinematics.robot_kinematics import RobotKinematics
from kinetostatics.layout.mapping import ShortRepr
from kinetostatics.layout.report import Json, attributes
from kinetostatics.statics.robot_statics import RobotStatics

#: Computations by NumPy with every engine.
_BY_NUMPY = (
    "poses near which a loop's joint is turned by half a revolution, and paths close to a singular pose",
    "analyses with assembly errors",
    "poses at which a limb's bases degenerate, its joints are dependent or its self-stress is rigid",
    "results computed on request: wrenches of limbs and joints, beams, motions of links, energies",
)


class _HasStatics(Protocol):
    @property
    def name(self) -> str: ...

    @property
    def statics(self) -> RobotStatics: ...


@dataclass(frozen=True, repr=False)
class EngineReport(ShortRepr):
    """Computations for a robot that run as compiled code.

    Attributes:
        robot: name of the robot.
        is_compiled: whether the equilibrium of its poses is compiled.
        reason: reason for which the equilibrium is not compiled; None if it is compiled.
        operations: number of operations per pose; None if the equilibrium is not compiled.
        loops_compiled: whether loop closure is compiled.
        loops_reason: reason for which loop closure is not compiled; None if it is compiled.
        loop_operations: number of operations of one Newton correction at given actuators; None if loop closure is not compiled.
        by_numpy: computations that NumPy does for this robot.
        folder: folder of the compiled code.
    """

    robot: str
    is_compiled: bool
    reason: str | None
    operations: int | None
    loops_compiled: bool
    loops_reason: str | None
    loop_operations: int | None
    by_numpy: tuple[str, ...]
    folder: Path

    def __str__(self) -> str:
        if self.is_compiled:
            first = f"the equilibrium of poses is compiled: {self.operations:,} operations a pose"
        else:
            first = f"the equilibrium of poses is not compiled: {self.reason}"
        if self.loops_compiled:
            second = f"closing the loops is compiled: {self.loop_operations:,} operations a correction, at given actuators"
        else:
            second = f"closing the loops is not compiled: {self.loops_reason}"
        lines = [f"Engine of {self.robot}", f"  {first}", f"  {second}", *(f"  by NumPy: {what}" for what in self.by_numpy)]
        return "\n".join([*lines, f"  code is kept in {self.folder}"])

    def to_dict(self) -> dict[str, Json]:
        """Return everything as plain values."""
        return attributes(self, (name for name in vars(self) if name != "robot"))


def engine_report(robot: _HasStatics) -> EngineReport:
    """Return a report on the computations for a robot that run as compiled code with ``engine="compiled"``.

    Code that is not on disk yet is compiled and stored, which takes a second or more.
    """
    if not isinstance(robot, RobotKinematics):
        raise ArgumentError(f"engine_report needs a Robot, got {robot!r}; load one with ks.load_robot(…)")
    statics, loops = compiled_statics(robot, robot.statics), loops_of(robot)
    by_numpy = []
    if isinstance(statics, str):
        by_numpy.append("the equilibrium of poses")
    if isinstance(loops, str):
        by_numpy.append("closing the loops")
    return EngineReport(
        robot.name,
        is_compiled=not isinstance(statics, str),
        reason=statics if isinstance(statics, str) else None,
        operations=None if isinstance(statics, str) else statics.operations,
        loops_compiled=not isinstance(loops, str),
        loops_reason=loops if isinstance(loops, str) else None,
        loop_operations=None if isinstance(loops, str) else loops.operations,
        by_numpy=(*by_numpy, *_BY_NUMPY),
        folder=cache_folder(),
    )
