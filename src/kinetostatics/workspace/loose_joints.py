"""Which joint coordinates tell nothing of the assembly mode."""

from __future__ import annotations

import numpy as np

from kinetostatics.exceptions import KinetostaticsError
from kinetostatics.robot import Robot
from kinetostatics.status import Status
from kinetostatics.workspace.sweep_spec import SweepSpec

#: Coordinates that change by more than the second when all are moved by the first and the loops closed again are loose.
MOVED, CHANGED = 0.05, 1e-5


def loose_coordinates(spec: SweepSpec, robot: Robot) -> tuple[bool, ...]:
    """Return which model coordinates local freedoms change: a rod that spins between two spherical joints.

    They are what a pose's coordinates leave open, at a generic pose that is left a little and closed again.
    """
    if not robot.mobility.local:
        return (False,) * robot.mechanism.tree.nq
    q = robot.model_q(robot.generic_poses)[:, 0]
    pose = robot.configuration(q, tolerance=np.inf, on_failure="nan")
    known = pose.platform_coordinates(spec.orientation) if spec.kind == "platform" else pose.actuators
    names = [*spec.held, *(axis.name for axis in spec.axes_of("coordinate"))]
    random = np.random.default_rng(6)
    starts = q + random.uniform(-MOVED, MOVED, (32, len(q)))
    near = robot.configuration(starts, tolerance=np.inf, on_failure="nan")
    try:
        found = spec.assemble(robot, {name: np.full(len(starts), float(known[name])) for name in names}, near)
    except (KinetostaticsError, KeyError):  # somebody else will complain
        return (False,) * robot.mechanism.tree.nq
    ends = found.q[found.status != Status.UNREACHABLE]
    if len(ends) < 2:
        driven = {joint for joint in robot.description.driven}
        model = robot.mechanism.model
        names_of_q = [name for name, count in zip(model.names, model.nqs, strict=True) for _ in range(count)]
        return tuple(name not in driven for name in names_of_q)
    return tuple((np.ptp(ends, axis=0) > CHANGED).tolist())
