"""Frames ``closing_…_1`` and ``closing_…_2``, which onshape-to-robot writes for a mate that closes a loop.

A mate called ``closing_NAME`` gives two links without a body, ``closing_NAME_1`` and ``closing_NAME_2``, each fixed to one of
the mated parts by a joint ``…_frame`` whose origin is the mate's coordinate system on that part
(https://onshape-to-robot.readthedocs.io, "Handling kinematic loops"; ``onshape_to_robot/exporter_urdf.py`` ``add_frame`` and
``assembly.py`` "Processing loop closing frames" of https://github.com/Rhoban/onshape-to-robot). Mates turn about, and slide
along, their z axis (its "Design-time considerations", "Joint frames"), and both frames' z axes point the same way.

The type of the mate is written only to MuJoCo files. Some versions add frames ``closing_NAME_1_z`` and ``closing_NAME_2_z``,
0.1 m along z, to revolute mates and no others: where both are found there, the type is known. Actuators are not written at all.
"""

from __future__ import annotations

import re
from collections.abc import Collection

import numpy as np

from kinetostatics.description.elements import Joint
from kinetostatics.description.joint_types import JOINT_TYPES
from kinetostatics.files.foreign.loop import ForeignLoop, SourceRobot

FRAME = re.compile(r"(closing_.+)_([12])")
#: Names of links that only mark frames.
MARK = re.compile(r"closing_.+_[12](_z)?")
#: Distance along z of the additional frames of revolute mates [m], and its tolerance for files with six digits.
Z_OFFSET, Z_TOLERANCE = 0.1, 1e-5


def read(source: SourceRobot, taken: Collection[str] = ()) -> list[ForeignLoop]:
    """Return the loops of all pairs of closing frames; frames in ``taken``, which are paired by another file, are ignored.

    Raises:
        RobotFileError: a frame has no partner, or is not fixed to a link.
    """
    pairs: dict[str, dict[str, Joint]] = {}
    for name, link in source.links.items():
        match = FRAME.fullmatch(name)
        if match is None or name in taken:
            continue
        joint = source.parent_joints.get(name)
        if joint is None or not JOINT_TYPES[joint.type].is_fixed:
            reason = f"the link {name!r} has the name of a loop's frame, but is not fixed to a link; rename it if it is none"
            raise link.place.error(reason)
        pairs.setdefault(match[1], {})[match[2]] = joint
    return [_loop(source, name, sides) for name, sides in pairs.items()]


def _loop(source: SourceRobot, name: str, sides: dict[str, Joint]) -> ForeignLoop:
    if len(sides) < 2:
        (there, joint), *_ = sides.items()
        missing = f"{name}_{'2' if there == '1' else '1'}"
        reason = f"the loop's frame {joint.child!r} has no partner: there is no link {missing!r}; rename it if it closes no loop"
        raise joint.place.error(reason)
    first, second = sides["1"], sides["2"]
    kind = "revolute" if all(_has_z_frame(source, joint) for joint in (first, second)) else None
    place = source.links[first.child].place
    return ForeignLoop(name, kind, first.parent, first.origin, second.parent, second.origin, (0.0, 0.0, 1.0), place)


def _has_z_frame(source: SourceRobot, joint: Joint) -> bool:
    """Whether there is the additional frame of a revolute mate, at :data:`Z_OFFSET` along z of a closing frame."""
    beside = source.parent_joints.get(f"{joint.child}_z")
    if beside is None or not JOINT_TYPES[beside.type].is_fixed or beside.parent != joint.parent:
        return False
    between = np.linalg.inv(joint.origin.matrix) @ beside.origin.matrix
    return bool(np.abs(between[:3, 3] - (0, 0, Z_OFFSET)).max() < Z_TOLERANCE)
