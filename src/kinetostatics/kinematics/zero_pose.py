"""The zero pose as the file has it: how far loops are open where all joints are at zero, and when that is a mistake."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from kinetostatics.kinematics.frame_corrections import FrameCorrection, frame_corrections
from kinetostatics.kinematics.solver import Poses

if TYPE_CHECKING:
    from kinetostatics.robot import Robot

#: Gap at zero, in robot sizes or [rad], up to which loops that cannot be closed show rounding; beyond, something is wrong.
ROUNDING = 1e-4
#: The same, up to which a tolerance that is given is accepted all the same: angles of three digits.
ACCEPTED = 1e-3
#: Closing error [scaled m, rad] of a file that has its numbers with six digits but another zero.
SIX_DIGITS = 1e-5
#: Gap [m, rad] below which a loop is closed.
CLOSED = 1e-9
#: How many corrections are shown.
_SHOWN = 6


def written_zero(robot: Robot) -> Poses:
    """Return the pose in which all joints are at zero."""
    return Poses(robot.equations.from_model(robot.mechanism.tree.neutral[:, None]), np.zeros((3, 1)))


def gaps_at(robot: Robot, pose: Poses) -> dict[str, tuple[float, float]]:
    """Return how far each loop is open at one pose, {name: (m, rad)}."""
    residual, _ = robot.equations.evaluate(robot.equations.forward(pose.x))
    return {name: (float(a[0]), float(b[0])) for name, (a, b) in robot.equations.openings(residual, pose.x).items()}


def are_within(gaps: Mapping[str, tuple[float, float]], metres: float, radians: float) -> bool:
    """Whether all loops are closed up to these gaps."""
    return all(a <= metres and b <= radians for a, b in gaps.values())


def accepts(robot: Robot, tolerance: float) -> bool:
    """Whether a tolerance [m, rad] may excuse that the loops stay open: not where a mistake in the file is larger.

    Where no motion of the joints closes the loops and the file leaves them open at zero by more than rounding, they may close
    somewhere almost, as another machine. The tolerance must cover the file's own gap then, which may not exceed ``ACCEPTED``.
    """
    if not robot.has_wrong_zero:
        return True
    return are_within(robot.zero_gaps, min(tolerance, ACCEPTED * robot.size), min(tolerance, ACCEPTED))


def is_one_frame(robot: Robot) -> bool:
    """Whether several loops are open at zero because of one wrong frame, although some motion nearly closes them.

    Where a single loop is open any frame would do, and the turn of a joint about its own axis is another zero of that joint.
    """
    if sum(max(pair) > CLOSED for pair in robot.zero_gaps.values()) < 2:
        return False
    corrections = frame_corrections(robot.mechanism, robot.size)
    return bool(corrections) and not any(item.is_motion_of(robot.mechanism) for item in corrections)


def wrong_zero_text(robot: Robot, closest: str = "") -> str:
    """Say how far the loops are open at zero, and which single frame would close them.

    Args:
        robot: whose loops cannot be closed.
        closest: how far they stay open with all joints free, in words, if that is far.
    """
    text = f"the loops of {robot.name!r} cannot be closed, not even with all joints free{': ' * bool(closest)}{closest}. "
    text += f"Where all joints are at zero, {gaps_text(robot.zero_gaps)}. A frame in the file is wrong"
    if are_within(robot.zero_gaps, ACCEPTED * robot.size, ACCEPTED):
        text += ", or an angle or a length is rounded (write them with full precision, as ${pi/2} in xacro)"
    corrections = frame_corrections(robot.mechanism, robot.size)
    if not corrections:
        return text + ". No single one, moved or turned, would close all loops at zero: more than one is wrong"
    which = "Any one of these" if corrections[1:] else "This"
    return f"{text}. {which} would close all loops at zero: {_listed(robot, corrections)}"


def corrections_hint(robot: Robot) -> str | None:
    """Say which single frame would close the loops at zero where joints have to move to close them, None if there is none."""
    if robot.zero_is_near:
        return None
    corrections = frame_corrections(robot.mechanism, robot.size)
    if not corrections or any(item.is_motion_of(robot.mechanism) for item in corrections):
        return None
    which = "any one of these" if corrections[1:] else "this"
    return (
        "if the loops are meant to be closed where all joints are at zero, a frame in the file is wrong: "
        f"{which} would close all: {_listed(robot, corrections)}"
    )


def _listed(robot: Robot, corrections: tuple[FrameCorrection, ...]) -> str:
    text = "; ".join(map(str, corrections[:_SHOWN]))
    if len(corrections) > _SHOWN:
        text += f"; or {len(corrections) - _SHOWN} others"
    return text + _on_child(robot, corrections[:_SHOWN])


def _on_child(robot: Robot, corrections: tuple[FrameCorrection, ...]) -> str:
    """Say that the joint may be right and its child's frame wrong, where there is one in which other joints lie."""
    joints = [item.joint for item in corrections if not item.is_loop]
    if not joints:
        return ""
    child = robot.description.joints[joints[-1]].child
    return f". If such a joint is right, what lies on its child (as {child!r}) is to be moved the other way instead"


def gaps_text(gaps: Mapping[str, tuple[float, float]]) -> str:
    """List every loop that is open, those that are alike together."""
    alike: dict[str, list[str]] = {}
    for name, (metres, radians) in gaps.items():
        sizes = [f"{metres:.4g} m"] if metres > CLOSED else []
        sizes += [f"{radians:.4g} rad"] if radians > CLOSED else []
        if sizes:
            alike.setdefault(" and ".join(sizes), []).append(name)
    closed = sum(max(pair) <= CLOSED for pair in gaps.values())
    parts = [f"{'loops' if names[1:] else 'loop'} {', '.join(map(repr, names))} {'are' if names[1:] else 'is'} {size} open"
             for size, names in alike.items()]  # fmt: skip
    return ", ".join(parts) + (f" ({closed} other{'s' * (closed > 1)} closed)" if closed and parts else "")
