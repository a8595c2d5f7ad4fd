"""The zero pose (the closed pose near zero), errors if there is none, and the robot's size.

At zero all joints are at zero; loops may be open.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from kinetostatics.description.joints import Joint, Loop
from kinetostatics.exceptions import RobotFileError
from kinetostatics.kinematics.coordinates import PrescribedCoordinates
from kinetostatics.kinematics.loop_constraints import LoopEquations
from kinetostatics.kinematics.loop_gaps import (
    CLOSED,
    FrameCorrection,
    are_closed_at_zero,
    are_within,
    close,
    frame_corrections,
    gaps_text,
    other_links,
)
from kinetostatics.kinematics.solver import Solver, SolverState
from kinetostatics.math.rotations import logarithm
from kinetostatics.mechanism.beam_geometry import ends_nowhere
from kinetostatics.mechanism.joints import compound_joints
from kinetostatics.mechanism.limbs import Topology
from kinetostatics.mechanism.mechanism import Mechanism

#: Gap at zero, relative to the robot's size or [rad], up to which unclosable loops count as rounded; a larger one is an error.
ROUNDING = 1e-4
#: Largest gap at zero, relative to the robot's size or [rad], for which a tolerance is accepted, as of angles with three digits.
ACCEPTED = 1e-3
#: Largest closing error [scaled m, rad] by which numbers of six digits may leave loops open.
SIX_DIGITS = 1e-5
#: Residual [scaled m, rad] above which loops count as not closed at all.
OPEN = 1e-2
#: Number of random starts for the closed zero pose if the loops do not close near zero.
_STARTS = 20
#: Largest number of corrections in a message.
_SHOWN = 6


def box_diagonal(mechanism: Mechanism) -> float:
    """Return the diagonal [m] of the box around all bodies, joints and the platform at zero."""
    frames = mechanism.forward(mechanism.tree.neutral[:, None])
    places = [(connection.predecessor_body, connection.predecessor_frame) for connection in mechanism.connections.values()]
    points = [frames.point(body, frame[:3, 3]) for body, frame in (*places, mechanism.platform_frame)]
    cloud = np.concatenate([frames.position[:, :, 0], *points], axis=1)
    return float(np.linalg.norm(cloud.max(axis=1) - cloud.min(axis=1)))


def characteristic_length(mechanism: Mechanism, topology: Topology, size: float) -> float:
    """Return the mean distance [m] of the limbs' outer joints from o; a quarter of ``size`` [m] if they are at o."""
    body, placement = mechanism.platform_frame
    frames = mechanism.forward(mechanism.tree.neutral[:, None])
    o = frames.point(body, placement[:3, 3])[:, 0]
    distances = []
    for limb in topology.limbs:
        compound_of = {name: compound for compound in compound_joints(mechanism, limb) for name in compound.joints}
        for edge in limb.edges:
            if edge.joint is None or len(edge.cut_joints) != 1 or not limb.to_platform[edge.cut_joints[0][0]]:
                continue
            connection = mechanism.connections[edge.joint]
            for link, item_body, frame in (
                (connection.successor, connection.successor_body, connection.successor_frame),
                (connection.predecessor, connection.predecessor_body, connection.predecessor_frame),
            ):
                if link in topology.platform.links:  # may differ from the platform's body if fixed by a loop
                    arm = frames.point(item_body, frame[:3, 3])[:, 0] - o
                    if edge.joint in compound_of:
                        compound = compound_of[edge.joint]
                        along = frames.direction(item_body, frame[:3, :3] @ connection.axis)[:, 0]
                        arm = arm + along * (compound.shift if compound.has_centre else -(along @ arm))
                    distances.append(float(np.linalg.norm(arm)))
                    break
    mean = float(np.mean(distances)) if distances else 0.0
    if mean > 1e-3 * size:
        return mean
    return size / 4 if size > 0 else 1.0


def written_zero(equations: LoopEquations) -> SolverState:
    """Return the pose with all joints at zero."""
    return SolverState(equations.from_model(equations.mechanism.tree.neutral[:, None]), np.zeros((3, 1)))


def closed_zero(solver: Solver, actuators: PrescribedCoordinates) -> tuple[SolverState, float]:
    """Return the closed pose near zero and its scaled residual; if there is none, the pose with the smallest gaps found.

    The actuators remain at zero if the other joints can close the loops.
    """
    equations, tree = solver.equations, solver.tree
    start, nothing = written_zero(equations), (PrescribedCoordinates(), np.zeros((0, 1)))
    if not equations.loops:
        return start, 0.0
    best, left = close(solver, start, actuators, np.zeros((actuators.size, 1)))
    if (residual := float(left[0])) < CLOSED:
        return best, residual
    # Actuators are not moved to close gaps of rounding size: the closed pose may be far away, in another assembly mode.
    free, left = close(solver, start, *nothing, cutoff=1e-3)
    if left[0] < CLOSED or OPEN < residual > left[0]:
        best, residual = free, float(left[0])
    chance = np.random.default_rng(1).uniform(-0.7, 0.7, (_STARTS, tree.nv)).T * solver.column_scale[:, None]
    for part in (slice(0, 1), slice(1, _STARTS)):  # the first nearly always suffices
        if residual >= OPEN:
            starts = start.take(np.zeros(chance[0, part].size, dtype=np.intp))
            poses, left = close(solver, SolverState(tree.integrate(starts.x, chance[:, part]), starts.c), *nothing)
            good = left < OPEN
            which = int(np.argmax(good) if np.any(good) else np.argmin(left))
            if left[which] < residual:
                best, residual = poses.take(np.array([which])), float(left[which])
    return best, residual


def is_one_frame(mechanism: Mechanism, gaps: Mapping[str, tuple[float, float]], size: float) -> bool:
    """Whether one wrong frame would explain the open loops: at zero, its correction would close them all.

    False for a single open loop, since a correction of any of its frames could close it. Also False if a correction is a motion
    of the frame's own joint, since only the joint's zero would change.
    """
    if sum(max(pair) > CLOSED for pair in gaps.values()) < 2:
        return False
    corrections = frame_corrections(mechanism, size)
    return bool(corrections) and not any(correction.is_motion_of(mechanism) for correction in corrections)


def wrong_zero_text(mechanism: Mechanism, gaps: Mapping[str, tuple[float, float]], size: float, closest: str = "") -> str:
    """Return a text about gaps at zero, and the corrections of axes or of a single frame that would close all loops.

    Args:
        gaps: gap of each loop at zero, {name: (m, rad)}.
        size: size of the robot [m].
        closest: text on the smallest gaps with all joints free, if these are large.
    """
    name = mechanism.description.name
    text = f"the loops of {name!r} cannot be closed, not even with all joints free{': ' * bool(closest)}{closest}. "
    text += f"Where all joints are at zero, {gaps_text(gaps)}. "
    if missing := _missing_axes(mechanism):
        return text + f"The file leaves out {missing}"
    axes = _wrong_axes(mechanism)
    text += f"{axes}. Otherwise a frame in the file is wrong" if axes else "A frame in the file is wrong"
    if are_within(gaps, ACCEPTED * size, ACCEPTED):
        text += ", or an angle or a length is rounded (write them with full precision, as ${pi/2} in xacro)"
    corrections = frame_corrections(mechanism, size)
    if not corrections:
        text += ". No correction of a single frame would close all loops at zero: more than one is wrong"
    else:
        which = "Any one of these" if corrections[1:] else "This"
        text += f". {which} would close all loops at zero: {_listed(mechanism, corrections)}"
    return text + _other_links_text(mechanism, size)


def corrections_hint(mechanism: Mechanism, size: float) -> str | None:
    """Return a hint at corrections of axes, or of one frame, that would close all loops at zero without motion of the joints.

    None if there is no such correction, or if an axis is missing in the file; another warning tells of missing axes.
    """
    if _missing_axes(mechanism):
        return None
    if axes := _wrong_axes(mechanism):
        return f"the loops are open where all joints are at zero. {axes}"
    corrections = frame_corrections(mechanism, size)
    if not corrections or any(correction.is_motion_of(mechanism) for correction in corrections):
        return None
    which = "any one of these" if corrections[1:] else "this"
    return (
        "if the loops are meant to be closed where all joints are at zero, a frame in the file is wrong: "
        f"{which} would close all: {_listed(mechanism, corrections)}{_other_links_text(mechanism, size)}"
    )


def _wrong_axes(mechanism: Mechanism) -> str:
    """Return, as text, the axes x, y or z of revolute loops that would close all loops at zero; empty if there are none.

    At zero the successor's frame is turned relative to the predecessor's; a loop is closed if its axis is the axis of this turn.
    """
    names_by_axis: dict[str, list[str]] = {}
    frames = mechanism.forward(mechanism.tree.neutral[:, None])
    for loop in (loop for loop in mechanism.connections.values() if loop.is_loop):
        ends = (loop.predecessor_body, loop.predecessor_frame), (loop.successor_body, loop.successor_frame)
        first, second = (frames.matrices(*end)[..., 0] for end in ends)
        between = np.linalg.inv(first) @ second
        turn = logarithm(between[:3, :3, None])[:, 0]
        angle = float(np.linalg.norm(turn))
        is_shifted = float(np.linalg.norm(between[:3, 3])) > CLOSED
        if is_shifted or not loop.type.is_hinge or (angle > CLOSED and float(np.abs(turn).max()) < angle * (1 - CLOSED)):
            return ""
        if angle > CLOSED and float(np.linalg.norm(np.cross(loop.axis, turn))) > CLOSED * angle:
            axis = ", ".join(f"{abs(round(part / angle))}" for part in turn)
            names_by_axis.setdefault(axis, []).append(repr(loop.name))
    words = [f"the <axis> ({axis}) of {', '.join(names)}" for axis, names in names_by_axis.items()]
    return f"All loops would be closed at zero with {' and '.join(words)}" if words else ""


def _missing_axes(mechanism: Mechanism) -> str:
    """Return, as text, the joints and loops without ``<axis>`` in the file; empty if there are none."""
    description = mechanism.description
    connections: dict[str, Joint | Loop] = {**description.joints, **description.loops}
    names = [name for name in description.default_axes if name in connections and connections[name].axis == (1.0, 0.0, 0.0)]
    if not names:
        return ""
    then, them = ("then is", "it") if len(names) == 1 else ("are then", "them")
    return f"the <axis> of {', '.join(map(repr, names))}, which {then} x: write {them} first"


def _other_links_text(mechanism: Mechanism, size: float) -> str:
    """Return, as text, the joints and loops that would each close all loops at zero if attached to another link."""
    alternatives = other_links(mechanism, size)
    shown = ", or ".join(map(str, alternatives[:_SHOWN]))
    return f". Or a link is wrong: all loops would close with {shown}, with unchanged numbers" if alternatives else ""


def _listed(mechanism: Mechanism, corrections: tuple[FrameCorrection, ...]) -> str:
    text = "; ".join(map(str, corrections[:_SHOWN]))
    if len(corrections) > _SHOWN:
        more = len(corrections) - _SHOWN
        text += f"; or {'another one' if more == 1 else f'{more} others'}"
    joints = [correction.joint for correction in corrections[:_SHOWN] if not correction.is_loop]
    if not joints:
        return text
    child = mechanism.description.joints[joints[-1]].child  # the joint may be right, and the frames on its child wrong
    return f"{text}. If such a joint is right, the frames on its child link (such as {child!r}) must be moved the opposite way"


def with_wrong_parent(error: RobotFileError, mechanism: Mechanism) -> RobotFileError:
    """Return the error that a joint, or a side of a loop, is on a wrong link; if this is not likely, return the given error.

    A wrong link is likely if exactly one change of attachment, to a link of :func:`.ends_nowhere`, would close all loops at zero.
    """
    size, empty = box_diagonal(mechanism), [link for link, _ in ends_nowhere(mechanism)]
    if not empty or not mechanism.description.loops or are_closed_at_zero(mechanism, size):
        return error
    changes = [(change, link) for change in other_links(mechanism, size) for link in change.others if link in empty]
    if len(changes) != 1:
        return error
    change, link = changes[0]
    description = mechanism.description
    side = "<predecessor> or <successor>" if change.is_loop else "<parent>"
    where = (description.loops if change.is_loop else description.joints)[change.joint].place
    return where.error(
        f"the {side} of {'loop' if change.is_loop else 'joint'} {change.joint!r} seems wrong: on link {link!r} instead of "
        f"{change.link!r} it would close all loops at zero, and as it is {link!r} ends nowhere. (If it is right: {error.reason})"
    )
