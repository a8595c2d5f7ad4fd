"""What the status of a robot's poses will be: told before any is analysed."""

from __future__ import annotations

import numpy as np

from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.kinematics.solver import SolverState
from kinetostatics.layout.numbers import join_words
from kinetostatics.results.result import Result
from kinetostatics.results.warnings import undetermined_parts
from kinetostatics.robot import Robot

#: How the text of a problem of the zero pose alone begins.
AT_ZERO = "at the zero pose"


def facts_of_poses(result: Result, where: str = "") -> list[str]:
    """Say what numbers will be missing at nearly all poses, or are at the pose that ``where`` names."""
    found = [where + undetermined_parts(result)] if np.any(result.indeterminate) else []
    bad = {
        limb.name
        for solution in result.solutions
        for item in solution.statics
        for position, limb in enumerate(item.group.limbs)
        if np.any(item.degenerate[position])
    }
    limbs = [limb.name for limb in result.robot.topology.limbs if limb.name in bad]
    if limbs and np.any(result.basis_degenerate):
        verb = "degenerate" if where else "degenerate at some poses"
        found.append(f"{where}the canonical wrenches of {join_words(limbs)} {verb}: intensities are NaN there")
    return found


def poses_of(robot: Robot, poses: SolverState, first_only: bool = False) -> Configuration:
    """Return a robot at poses of the solver, or at the first of them, which close the loops as well as its file lets them."""
    q = robot.model_q(poses).T
    return robot.configuration(q[0] if first_only else q, closure_tolerance=1e-9 + 1e3 * robot.closing_error, on_failure="nan")
