"""What of a robot runs as compiled code, and what does not and why."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from kinetostatics.engine.cache import cache_folder
from kinetostatics.engine.choice import compiled_statics
from kinetostatics.printing.mappings import ShortRepr
from kinetostatics.statics.model import RobotStatics

#: What NumPy does whatever the engine.
_BY_NUMPY = (
    "closing the loops",
    "analyses with misfits",
    "poses at which a limb's bases degenerate, its joints are dependent or its self-stress is rigid",
    "what is computed when it is asked for: joint wrenches, beams, drive forces, motions of links, energies",
)


class _HasStatics(Protocol):
    @property
    def name(self) -> str: ...

    @property
    def statics(self) -> RobotStatics: ...


@dataclass(frozen=True, repr=False)
class EngineReport(ShortRepr):
    """What of a robot runs as compiled code.

    Attributes:
        robot: its name.
        is_compiled: whether the equilibrium of its poses does.
        reason: why not; None if it does.
        operations: how many additions, multiplications and so on a pose takes; None if it does not.
        by_numpy: what NumPy does in any case.
        folder: where code is kept.
    """

    robot: str
    is_compiled: bool
    reason: str | None
    operations: int | None
    by_numpy: tuple[str, ...]
    folder: Path

    def __str__(self) -> str:
        if self.is_compiled:
            first = f"the equilibrium of poses is compiled: {self.operations:,} operations a pose"
        else:
            first = f"nothing is compiled: {self.reason}"
        return "\n".join(
            [
                f"Engine of {self.robot}",
                f"  {first}",
                *(f"  by NumPy: {what}" for what in self.by_numpy),
                f"  code is kept in {self.folder}",
            ]
        )

    def to_dict(self) -> dict[str, Any]:
        """Return everything as plain values."""
        return {
            "is_compiled": self.is_compiled,
            "reason": self.reason,
            "operations": self.operations,
            "by_numpy": list(self.by_numpy),
            "folder": str(self.folder),
        }


def engine_report(robot: _HasStatics) -> EngineReport:
    """Say what of a robot runs as compiled code (``engine="compiled"``), and what does not and why.

    The code is made, and kept on disk, if it is not there yet: that takes a second or more.
    """
    found = compiled_statics(robot.statics)
    if isinstance(found, str):
        everything = ("the equilibrium of poses", *_BY_NUMPY)
        return EngineReport(robot.name, False, found, None, everything, cache_folder())
    return EngineReport(robot.name, True, None, found.operations, _BY_NUMPY, cache_folder())
