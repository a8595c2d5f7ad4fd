"""Closed poses along straight lines of prescribed coordinates, followed in steps."""

from __future__ import annotations

import numpy as np

from kinetostatics.kinematics.coordinates import PrescribedCoordinates, for_each, line_start
from kinetostatics.kinematics.solver import Solver, SolverState
from kinetostatics.math.arrays import Array, Mask, chunks, in_threads

#: Largest step along a line, in rad and in characteristic lengths. After a larger one, Newton's method may converge steadily to
#: another branch: a universal joint also closes with one axis reversed.
LONGEST_TURN, LONGEST_SHIFT = 0.7, 2.0
#: Smallest step, relative to the largest; where it fails, the line ends.
_SHORTEST = 1e-3
#: Largest length of a line, in steps of :data:`LONGEST_TURN` and in reaches of the robot. The former limits the number of steps;
#: beyond the latter, the floating-point resolution is insufficient for the closure of loops.
MOST_TURNED, FARTHEST = 1e3, 1e8
#: Beyond this distance from the start of the line, in reaches of the robot, steps are this fraction of the distance, since only
#: prismatic joints move.
_FAR_AWAY, _LEAP = 40.0, 0.25


def follow(
    solver: Solver,
    prescribed: PrescribedCoordinates,
    start: SolverState,
    target: Array,
    origin: tuple[Array, Array] | None = None,
) -> tuple[SolverState, Mask, Array]:
    """Follow straight lines of prescribed coordinates, one for each target, in chunks.

    Args:
        start: one pose, or as many as there are targets.
        target: (n, N) coordinates at the ends of the lines [m, rad].
        origin: coordinates of the start, see :meth:`Solver.origin`. None: they are computed, with full turns that shorten the
            lines.

    Returns:
        The last pose on each line; (N,) True for lines followed to their end; the fraction (N,) of each line that was followed.
    """
    N = target.shape[1]
    if len(chunks(N)) == 1:
        return _follow_chunk(solver, prescribed, start, target, origin)
    poses = SolverState(np.empty((start.x.shape[0], N)), np.empty((3, N)))
    arrived, gone = np.empty(N, dtype=bool), np.empty(N)

    def follow_chunk(part: slice) -> None:
        starts = start if start.x.shape[1] == 1 else SolverState(start.x[:, part], start.c[:, part])
        origins = origin
        if origin is not None and origin[0].shape[1] > 1:
            origins = origin[0][:, part], origin[1][:, part]
        ends, arrived[part], gone[part] = _follow_chunk(solver, prescribed, starts, target[:, part], origins)
        poses.x[:, part], poses.c[:, part] = ends.x, ends.c

    in_threads(follow_chunk, chunks(N), solver.is_compiled)
    return poses, arrived, gone


def _follow_chunk(
    solver: Solver,
    prescribed: PrescribedCoordinates,
    start: SolverState,
    target: Array,
    origin: tuple[Array, Array] | None,
) -> tuple[SolverState, Mask, Array]:
    N = target.shape[1]
    # angles of free rotations are known except for full turns: take the shorter line
    first, c = solver.line(prescribed, start, target) if origin is None else line_start(prescribed, origin, target, shorter=False)
    state = SolverState(for_each(start.x, N), c)
    strides = _relative_changes(solver, prescribed, first, target)
    if N == 1 and np.max(strides, initial=0.0) <= 1:
        moved = solver.in_one_go(prescribed, state, target)
        if moved is not None:
            return moved, np.ones(1, dtype=bool), np.ones(1)
    gone, steady, active = np.zeros(N), np.ones(N, dtype=bool), np.arange(N)
    if N > 1 and np.max(strides, initial=0.0) <= 1:  # few take more than one step
        moved, good = _step(solver, prescribed, state, target)
        if np.all(good):
            return moved, good, np.ones(N)
        state.x[:, good], state.c[:, good], gone[good] = moved.x[:, good], moved.c[:, good], 1.0
        steady, active = good, active[~good]
    most_turned, most_shifted = _largest_changes(solver, prescribed, strides)
    usual = 1 / np.maximum(1.0, np.maximum(most_turned, most_shifted))
    stride, longest = np.where(steady, usual, usual / 2), np.array(usual)
    reaches = most_shifted * (LONGEST_SHIFT * solver.length / solver.reach)
    active = active[~_beyond(most_turned, reaches)[active]]
    while active.size:
        trial = np.minimum(gone[active] + stride[active], 1.0)
        with np.errstate(invalid="ignore"):  # infinite targets
            goal = first[:, active] + trial * (target[:, active] - first[:, active])
        here = state if active.size == N else state.take(active)
        guess, before = here, None
        if np.any(leaping := stride[active] > usual[active]):
            changes = (trial - gone[active]) * (target[:, active] - first[:, active])
            guess, before = _predicted(solver, prescribed, here, changes, leaping)
        moved, good = _step(solver, prescribed, here, goal, guess, before, trial < 1)
        if np.all(good) and np.all(trial == 1) and active.size == N:
            return moved, good, trial
        arrived = active[good]
        state.x[:, arrived], state.c[:, arrived] = moved.x[:, good], moved.c[:, good]
        gone[arrived] = trial[good]
        far = arrived[gone[arrived] * reaches[arrived] > _FAR_AWAY]
        longest[far] = np.clip(_LEAP * gone[far], usual[far], 1 / np.maximum(1.0, most_turned[far]))
        calm = arrived[steady[arrived]]
        stride[calm] = np.where(longest[calm] > usual[calm], longest[calm], np.minimum(2 * stride[calm], longest[calm]))
        stride[active[~good]] /= 2
        steady[active] = good  # the stride is not doubled directly after a failed step
        active = active[(gone[active] < 1) & (stride[active] > _SHORTEST * usual[active])]
    return state, gone >= 1, gone


def is_too_far(solver: Solver, prescribed: PrescribedCoordinates, start: SolverState, target: Array) -> Mask:
    """(N,) True for targets (n, N) whose lines are too long to be followed."""
    strides = _relative_changes(solver, prescribed, solver.line(prescribed, start, target)[0], target)
    most_turned, most_shifted = _largest_changes(solver, prescribed, strides)
    return _beyond(most_turned, most_shifted * (LONGEST_SHIFT * solver.length / solver.reach))


def _relative_changes(solver: Solver, prescribed: PrescribedCoordinates, first: Array, target: Array) -> Array:
    """(n, N) change of each coordinate along each line, relative to its longest step; zero without unknowns."""
    with np.errstate(over="ignore", invalid="ignore"):
        lengths = np.abs(target - first) / longest_strides(solver, prescribed)[:, None]
        return lengths if solver.free_columns(prescribed).size or prescribed.unknown_angles else 0 * lengths


def _largest_changes(solver: Solver, prescribed: PrescribedCoordinates, changes: Array) -> tuple[Array, Array]:
    """Return (a, b) for each line: a (N,) largest relative change of an angle, b (N,) largest relative change of a length."""
    are_turns = turns(solver, prescribed)
    most_turned, most_shifted = (np.max(changes[rows], axis=0, initial=0.0) for rows in (are_turns, ~are_turns))
    return most_turned, most_shifted


def _beyond(most_turned: Array, reaches: Array) -> Mask:
    return np.asarray(~((most_turned <= MOST_TURNED) & (reaches <= FARTHEST)))


def _step(
    solver: Solver,
    prescribed: PrescribedCoordinates,
    here: SolverState,
    goal: Array,
    guess: SolverState | None = None,
    before: Array | None = None,
    passing: Mask | None = None,
) -> tuple[SolverState, Mask]:
    """Return the poses at ``goal`` (n, N), and (N,) True where they are reached from ``here`` without a singular pose between.

    With local freedoms, singular poses are not looked for. Newton's method starts from ``guess`` (None: ``here``); ``before`` and
    ``passing`` are as in :meth:`Solver.newton`.
    """
    moved, good = solver.newton(prescribed, here if guess is None else guess, goal, before, passing)
    if not prescribed.local_dofs and np.all(good):
        good = solver.on_one_side(prescribed, here, moved, goal)
    elif not prescribed.local_dofs:
        good[good] = solver.on_one_side(prescribed, here.take(good), moved.take(good), goal[:, good])
    return moved, good


def _predicted(
    solver: Solver, prescribed: PrescribedCoordinates, poses: SolverState, changes: Array, which: Mask
) -> tuple[SolverState, Array]:
    """Return the poses moved by ``changes`` (n, N) of the coordinates, to first order, and the sizes (N,) of these steps.

    Poses where ``which`` (N,) is False are not moved; their sizes are infinite.
    """
    guess, before = SolverState(np.array(poses.x), np.array(poses.c)), np.full(which.size, np.inf)
    some, shift = poses.take(which), changes[:, which]
    step = np.einsum("ijn,jn->in", solver.predictors(prescribed, some, np.zeros_like(shift)), shift)
    moved, before[which] = solver.advance(prescribed, some, step), np.maximum(solver.size(prescribed, step), 1e-3)
    guess.x[:, which], guess.c[:, which] = moved.x, moved.c
    return guess, before


def longest_strides(solver: Solver, prescribed: PrescribedCoordinates) -> Array:
    """Return the longest permitted step of each prescribed coordinate (n,) [m, rad]."""
    return np.where(turns(solver, prescribed), LONGEST_TURN, LONGEST_SHIFT * solver.length)


def turns(solver: Solver, prescribed: PrescribedCoordinates) -> Mask:
    """(n,) True for prescribed coordinates that are angles."""
    turns = [bool(solver.tree.column_rotates[column]) for column in prescribed.columns]
    turns += [not solver.equations.loops[number].type.is_slide for number in prescribed.loops]
    return np.array(turns + [False] * len(prescribed.positions) + [True] * len(prescribed.angles), dtype=bool)
