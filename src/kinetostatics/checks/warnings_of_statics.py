"""Warnings from statics: uncertain ranks, actuators, poses without results."""

from __future__ import annotations

import numpy as np

from kinetostatics.analysis import analyze
from kinetostatics.checks.facts import RobotFacts
from kinetostatics.exceptions import StaticsError
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.kinematics.solver import SolverState
from kinetostatics.layout.numbers import join_words
from kinetostatics.results.result import Result
from kinetostatics.results.warnings import near_singular_message, undetermined_parts
from kinetostatics.robot import Robot

#: Ratio of the smallest nonzero to the largest zero singular value below which a count is doubtful.
SMALL_GAP = 1e4
#: Beginning of the text of a problem at the zero pose only.
AT_ZERO = "at the zero pose"


def warnings_of_statics(robot: Robot, facts: RobotFacts) -> tuple[list[str], list[str], list[str]]:
    """Return warnings of uncertain ranks and of actuators, those of the zero pose, and errors that prevent an analysis."""
    found: list[str] = []
    at_zero: list[str] = []
    problems: list[str] = []
    if robot.mobility.gap < SMALL_GAP:
        found.append(
            f"the mobility is doubtful: the smallest singular value that counts is only {robot.mobility.gap:.2g} times the "
            "largest that counts as zero"
        )
    for group in robot.statics.groups:
        if group.basis.gap < SMALL_GAP:
            found.append(
                f"the number of constraint wrenches of {group.limbs[0].name} is doubtful: the smallest singular value that "
                f"counts is only {group.basis.gap:.2g} times the largest that counts as zero"
            )
    mobility = facts.mobility
    if mobility is not None and mobility.redundant_actuators:
        held = len(facts.drives) - mobility.redundant_actuators
        found.append(
            f"{len(facts.drives)} actuators for {held} freedom{'s' * (held != 1)}: the actuation is redundant; actuators are "
            "taken as locked in position and share the load as their limbs' elasticity makes them (if the robot should have "
            "more freedoms, look for a wrong <axis>)"
        )
    for name in robot.actuators_outside_limbs:
        found.append(f"the driven joint {name} is in no limb: it only holds what hangs on {_owner(robot, name)}")
    generic = analyze(poses_of(robot, robot.generic_poses))
    zero = analyze(poses_of(robot, robot.zero_poses, first_only=True), on_failure="nan")
    problem = _statics_problem(robot, generic, zero)
    if problem is not None:
        (at_zero if problem.startswith(AT_ZERO) else problems).append(problem)
    else:
        words = near_singular_message(zero)
        at_zero += [words.replace("the pose is", "the zero pose is", 1)] if words else []
    found += facts_of_poses(generic)
    at_zero += [text for text in facts_of_poses(zero, f"{AT_ZERO} ") if text.removeprefix(f"{AT_ZERO} ") not in found]
    return found, at_zero, problems


def _owner(robot: Robot, joint: str) -> str:
    for limb in robot.topology.limbs:
        if any(edge.joint == joint for edge in limb.branches):
            return limb.name
    return "the platform" if any(edge.joint == joint for edge in robot.topology.platform.edges) else "the base"


def _statics_problem(robot: Robot, generic: Result, zero: Result) -> str | None:
    """Return the reason why statics has no results, at all poses or at the zero pose only; None if it has."""
    if not robot.mechanism.tree.nq:  # nothing moves: there is one pose only
        return _complaint(zero)
    if np.all(np.isnan(generic.twist)):
        problem = _complaint(analyze(poses_of(robot, robot.generic_poses, first_only=True), on_failure="nan"))
        return problem or "no pose could be analysed: the loops of those that were tried do not close"
    problem = _complaint(zero)
    return None if problem is None else f"{AT_ZERO} {problem}"


def _complaint(result: Result) -> str | None:
    """Return the reason why a reached pose has no results; None if it has."""
    if result.configuration.reached.all() and np.any(np.isnan(result.twist)):
        try:
            analyze(result.configuration)
        except StaticsError as error:
            return str(error)
    return None


def facts_of_poses(result: Result, where: str = "") -> list[str]:
    """Return warnings of missing results at generic poses, or at the pose named by ``where``."""
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
    """Return the configuration of solver poses, or of the first one, with a closure tolerance that the file's numbers allow."""
    q = robot.model_q(poses).T
    return robot.configuration(q[0] if first_only else q, closure_tolerance=1e-9 + 1e3 * robot.closing_error, on_failure="nan")
