"""Gaps of open loops: their text, motions of joints that close them, and corrections of one frame that close them at zero.

*At zero* means with all joints at zero. A *side* of a loop is its frame on the predecessor or on the successor. *Candidates* for
a correction are the origins of all joints, and of all sides of loops. The corrections of all candidates are found at once by
Gauss–Newton steps of smallest norm, with the equations of :mod:`kinetostatics.kinematics.loop_constraints`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from kinetostatics.description.joint_types import JOINT_TYPES
from kinetostatics.kinematics.coordinates import PrescribedCoordinates
from kinetostatics.kinematics.loop_constraints import Closures, LoopEquations
from kinetostatics.kinematics.solver import Solver, SolverState
from kinetostatics.math import rotations
from kinetostatics.math.arrays import Array, Mask
from kinetostatics.math.linalg import NOTHING, ranked
from kinetostatics.math.screws import move_wrench
from kinetostatics.mechanism.mechanism import Mechanism
from kinetostatics.mechanism.tree import Frames

#: Gap [m, rad] below which a loop is closed.
CLOSED = 1e-9
#: Largest gap after a correction that counts as rounding of the file [relative to the robot's size, or rad].
CLOSES = 1e-5
#: Largest step [relative to the robot's size, or rad], and largest number of steps.
_LARGEST, _STEPS = 0.5, 40
#: Relative singular value below which a displacement does not affect the loops.
_NO_EFFECT = 1e-9


def gaps_at(equations: LoopEquations, pose: SolverState) -> dict[str, tuple[float, float]]:
    """Return the gap of each loop and the error of each mimic joint at one pose, ``{name: (m, rad)}``."""
    residual, _ = equations.evaluate(equations.forward(pose.x))
    return {name: (float(a[0]), float(b[0])) for name, (a, b) in equations.loop_gaps(residual, pose.x).items()}


def are_within(gaps: Mapping[str, tuple[float, float]], metres: float, radians: float) -> bool:
    return all(a <= metres and b <= radians for a, b in gaps.values())


def worst_gaps_text(equations: LoopEquations, gaps: Mapping[str, tuple[float, float]], least: float = CLOSED) -> str:
    """Return up to three of the largest gaps above ``least`` [m, rad] as text."""
    items = list(gaps.items())
    worst = [items[k] for k in ranked([max(sizes) for _, sizes in items]) if max(items[k][1]) > least]
    shown = []
    for name, (metres, radians) in worst[:3]:
        metres, radians = (0.0 if size <= NOTHING * max(worst[0][1]) else size for size in (metres, radians))
        if max(metres, radians) > 0.01 * max(worst[0][1]):
            if name in equations.couplings.names:
                size = f"{metres:.3g} m" if metres > 0 else f"{radians:.3g} rad"
                shown.append(f"joint {name!r} is {size} away from the position by its <mimic>")
            else:
                shown.append(f"loop {name!r} stays {metres:.3g} m" + (f" and {radians:.3g} rad" if radians > 0 else "") + " open")
    return ", ".join(shown) if shown else "no loop stays open"


def gaps_text(gaps: Mapping[str, tuple[float, float]]) -> str:
    """Return all gaps as text; loops with equal gaps share one phrase."""
    alike: dict[str, list[str]] = {}
    for name, (metres, radians) in gaps.items():
        sizes = [f"{metres:.4g} m"] if metres > CLOSED else []
        sizes += [f"{radians:.4g} rad"] if radians > CLOSED else []
        if sizes:
            alike.setdefault(" and ".join(sizes), []).append(name)
    closed = sum(max(pair) <= CLOSED for pair in gaps.values())
    parts = []
    for size, names in alike.items():
        loops, verb = ("loops", "are") if len(names) > 1 else ("loop", "is")
        parts.append(f"{loops} {', '.join(map(repr, names))} {verb} {size} open")
    return ", ".join(parts) + (f" ({closed} other{'s' * (closed > 1)} closed)" if closed and parts else "")


def close(
    solver: Solver,
    poses: SolverState,
    prescribed: PrescribedCoordinates,
    target: Array,
    weight: float = 1.0,
    cutoff: float = 1e-9,
) -> tuple[SolverState, Array]:
    """Close loops with large gaps by damped least squares (Levenberg–Marquardt), pose by pose.

    Args:
        poses: initial poses.
        target: (n, 1) values of the prescribed coordinates.
        weight: weight of the equations of prescribed coordinates relative to those of the loops.
        cutoff: relative singular value below which there is no step in a direction. In an overconstrained robot with rounded
            numbers, every motion changes the gaps slightly; steps must not move the robot back in order to close such gaps.

    Returns:
        The poses with the smallest residuals found, and the largest scaled residual (N,) at each pose.
    """
    best = SolverState(np.array(poses.x), np.array(poses.c))
    solver.impose(prescribed, best, target)

    def system(poses: SolverState) -> tuple[Array, Array]:
        residual, gradient = solver.system(prescribed, poses, np.broadcast_to(target, (target.shape[0], poses.x.shape[1])))
        residual[solver.equations.count :] *= weight
        gradient[solver.equations.count :] *= weight
        return residual, gradient

    residual, gradient = system(best)
    left = np.max(np.abs(residual), axis=0, initial=0.0)
    damping = np.full(left.size, 1e-6)
    active = np.flatnonzero(left >= 1e-15)
    for _ in range(200):
        if not active.size:
            break
        r, damped = residual[:, active], damping[active]
        U, values, V = np.linalg.svd(np.moveaxis(gradient[:, :, active], -1, 0), full_matrices=False)
        usable = values > cutoff * np.max(values, axis=1, initial=0.0, keepdims=True)
        gain = np.where(usable, values / (values**2 + damped[:, None]), 0.0)
        step = -np.einsum("nkv,nk->vn", V, gain * np.einsum("nrk,rn->nk", U, r))
        largest = np.max(np.abs(step), axis=0, initial=0.0)
        step *= np.where(largest > 0.5, 0.5 / np.maximum(largest, 0.5), 1.0)
        trial = solver.advance(prescribed, best.take(active), step)
        new_residual, new_gradient = system(trial)
        better = np.sum(new_residual**2, axis=0) <= np.sum(r**2, axis=0)
        gained = active[better]
        best.x[:, gained], best.c[:, gained] = trial.x[:, better], trial.c[:, better]
        residual[:, gained], gradient[:, :, gained] = new_residual[:, better], new_gradient[:, :, better]
        left[gained] = np.max(np.abs(residual[:, gained]), axis=0, initial=0.0)
        damping[active] = np.where(better, np.maximum(damped / 10, 1e-15), 10 * damped)
        over = np.where(better, largest < 1e-15, (damping[active] > 1e6) | (largest < 1e-14))
        active = active[~over & (left[active] >= 1e-15)]
    return best, left


@dataclass(frozen=True)
class FrameCorrection:
    """A correction of the origin of a joint or loop that closes all loops at zero.

    The origin moves by ``shift`` (3,) [m], and the frame turns about it by the rotation vector ``turn`` (3,) [rad]; both vectors
    are in the axes of ``link``, in which the file gives the origin.
    """

    joint: str
    is_loop: bool
    link: str
    shift: Array
    turn: Array

    def is_motion_of(self, mechanism: Mechanism) -> bool:
        """Whether the correction is a motion of the joint itself, so that only the joint's zero would change."""
        joint = mechanism.description.joints.get(self.joint)
        if joint is None or not JOINT_TYPES[joint.type].is_single:
            return False
        moved, still = (self.shift, self.turn) if JOINT_TYPES[joint.type].is_slide else (self.turn, self.shift)
        across = np.cross(joint.origin.matrix[:3, :3] @ np.array(joint.axis), moved)
        return not np.any(still) and float(np.linalg.norm(across)) < CLOSES * float(np.linalg.norm(moved))

    def __str__(self) -> str:
        angle = float(np.linalg.norm(self.turn))
        origin = f"the origin of {'loop' if self.is_loop else 'joint'} {self.joint!r} on link {self.link!r}"
        parts = []
        if np.any(self.shift):
            parts.append(f"moving {origin} by {_vector(self.shift)} m")
        if angle:
            what = "it" if parts else origin
            parts.append(f"turning {what} by {np.degrees(angle):.4g}° about {_vector(self.turn / angle)}")
        return " and ".join(parts)


def _vector(values: Array) -> str:
    return f"({', '.join(f'{value:.4g}' for value in values)})"


@dataclass(frozen=True)
class _Candidates:
    """N candidates: name of the joint or loop, whether it is a loop, and the link in which the file gives the frame.

    ``rotation`` (3, 3, N) are the orientations of these links at zero, ``origin`` (3, N) the origins of the frames [m];
    ``carried`` (2K, N) is True for the sides of loops that move with a frame: K predecessors, then K successors.
    """

    names: list[tuple[str, bool, str]]
    rotation: Array
    origin: Array
    carried: Mask


def frame_corrections(mechanism: Mechanism, size: float) -> tuple[FrameCorrection, ...]:
    """Return all corrections of single frames, the smallest first; pure displacements or pure rotations if these suffice.

    The robot's ``size`` [m] is the scale of displacements relative to rotations.
    """
    closures, sides, _, candidates = _at_zero(mechanism)
    correction_of: dict[int, FrameCorrection] = {}
    for columns in (slice(0, 3), slice(3, 6), slice(0, 6)):
        rotation, shift, closed = _best_corrections(closures, sides, candidates, columns, size)
        turn = rotations.logarithm(rotation)
        for n in np.flatnonzero(closed):
            if int(n) not in correction_of:
                back = candidates.rotation[:, :, n].T
                moved, turned = back @ shift[:, n], back @ turn[:, n]
                moved[np.abs(moved) < 1e-9 * size], turned[np.abs(turned) < 1e-9] = 0.0, 0.0
                correction_of[int(n)] = FrameCorrection(*candidates.names[n], moved, turned)
    corrections = [correction_of[n] for n in sorted(correction_of)]
    extents = [float(np.linalg.norm(correction.shift) / size + np.linalg.norm(correction.turn)) for correction in corrections]
    return tuple(corrections[k] for k in np.argsort(np.round(extents, 6), kind="stable"))


@dataclass(frozen=True)
class OtherLink:
    """A joint, or a side of a loop, that may be attached to the wrong link.

    If it were attached to one of the links ``others``, with the same numbers as origin, all loops would be closed at zero.
    """

    joint: str
    is_loop: bool
    link: str
    others: tuple[str, ...]

    def __str__(self) -> str:
        others = " or ".join(map(repr, self.others))
        return f"{'loop' if self.is_loop else 'joint'} {self.joint!r} on link {others} instead of {self.link!r}"


def other_links(mechanism: Mechanism, size: float) -> tuple[OtherLink, ...]:
    """Return joints and sides of loops whose attachment to another link, with the same origin, would close all loops at zero."""
    closures, sides, links, candidates = _at_zero(mechanism)
    parents = {joint.child: joint.parent for joint in mechanism.description.joints.values()}
    alternatives = []
    for n, (name, is_loop, link) in enumerate(candidates.names):
        child = None if is_loop else mechanism.description.joints[name].child
        targets = [other for other in links if other != link and (child is None or not _descends_from(parents, other, child))]
        moves = np.array([links[other] for other in targets]).reshape(-1, 4, 4) @ np.linalg.inv(links[link])
        moved = np.where(candidates.carried[:, n, None, None], moves[:, None] @ sides, sides)
        residual, _ = closures.evaluate(Frames(moved[..., :3, :3].transpose(2, 3, 1, 0), moved[..., :3, 3].transpose(2, 1, 0)))
        closed = np.flatnonzero(_are_closed(closures, residual, size))
        if closed.size:
            alternatives.append(OtherLink(name, is_loop, link, tuple(targets[k] for k in closed)))
    return tuple(alternatives)


def are_closed_at_zero(mechanism: Mechanism, size: float) -> bool:
    """Whether all loops are closed at zero, within rounding for a robot of this size [m]."""
    closures, sides, _, _ = _at_zero(mechanism)
    frames = Frames(sides[:, None, :3, :3].transpose(2, 3, 0, 1), sides[:, None, :3, 3].transpose(2, 0, 1))
    return bool(_are_closed(closures, closures.evaluate(frames)[0], size).all())


def _at_zero(mechanism: Mechanism) -> tuple[Closures, Array, dict[str, Array], _Candidates]:
    """Return the equations of K loops, and at zero: frames (2K, 4, 4) of the loops' sides, frames (4, 4) of links, candidates.

    Bodies of the equations are the sides of the loops: K predecessors, then K successors.
    """
    loops = [loop for loop in mechanism.connections.values() if loop.is_loop]
    frames = mechanism.tree.forward(mechanism.tree.neutral[:, None])

    sides = [frames.matrices(loop.predecessor_body, loop.predecessor_frame)[..., 0] for loop in loops]
    sides += [frames.matrices(loop.successor_body, loop.successor_frame)[..., 0] for loop in loops]
    links = {link: frames.matrices(*where)[..., 0] for link, where in mechanism.body_of.items()}
    count, here = len(loops), np.eye(4)
    free = [
        replace(loop, predecessor_body=k, successor_body=count + k, predecessor_frame=here, successor_frame=here)
        for k, loop in enumerate(loops)
    ]
    return Closures(free), np.array(sides), links, _candidates(mechanism, links, sides)


def _descends_from(parents: dict[str, str], link: str, root: str) -> bool:
    """Whether a link is ``root`` or descends from it in the tree; ``parents`` maps each link to its parent."""
    while link != root and link in parents:
        link = parents[link]
    return link == root


def _candidates(mechanism: Mechanism, links: dict[str, Array], sides: list[Array]) -> _Candidates:
    """Return the frames whose errors open loops; an error of a joint's frame moves all links beyond the joint in the tree."""
    description = mechanism.description
    loops = list(description.loops.values())
    at = [loop.predecessor for loop in loops] + [loop.successor for loop in loops]
    parents = {joint.child: joint.parent for joint in description.joints.values()}
    names: list[tuple[str, bool, str]] = []
    origins, carried = [], []

    for joint in description.joints.values():
        names.append((joint.name, False, joint.parent))
        origins.append((links[joint.parent] @ joint.origin.matrix)[:3, 3])
        carried.append([_descends_from(parents, link, joint.child) for link in at])
    for side in range(2):
        for k, loop in enumerate(loops):
            number = side * len(loops) + k
            names.append((loop.name, True, at[number]))
            origins.append(sides[number][:3, 3])
            carried.append([other == number for other in range(len(at))])
    both = np.array(carried, dtype=bool).reshape(len(names), 2, len(loops))
    kept = np.flatnonzero(np.any(both[:, 0] != both[:, 1], axis=1))
    return _Candidates(
        [names[n] for n in kept],
        np.array([links[names[n][2]][:3, :3] for n in kept]).reshape(-1, 3, 3).transpose(1, 2, 0),
        np.array([origins[n] for n in kept]).reshape(-1, 3).T,
        np.array([carried[n] for n in kept], dtype=bool).reshape(len(kept), len(at)).T,
    )


def _best_corrections(
    closures: Closures, sides: Array, candidates: _Candidates, columns: slice, size: float
) -> tuple[Array, Array, Mask]:
    """Return the corrections of N candidates that minimize the gaps, and (N,) True where all loops are then closed.

    A correction is a rotation (3, 3, N) and a shift (3, N) [m]. ``sides`` (2K, 4, 4) are the frames of the loops' sides at zero.
    ``columns`` are the components that may change: 0 to 2 of the shift, 3 to 5 of the rotation.
    """
    N, count = candidates.origin.shape[1], len(closures.loops)
    start_rotation = np.repeat(sides[:, :3, :3].transpose(1, 2, 0)[..., None], N, axis=3)
    start_position = np.repeat(sides[:, :3, 3].T[..., None], N, axis=2)
    sign = candidates.carried[count:].astype(float) - candidates.carried[:count]
    sign = sign[closures.loop_of]
    scale = np.where(closures.is_length, 1 / size, 1.0)[:, None]
    rotation, shift = rotations.identity((N,)), np.zeros((3, N))
    residual = np.empty((closures.closures, N))
    for _ in range(_STEPS):
        arm = start_position - candidates.origin[:, None]
        moved = np.einsum("ijn,jkn->ikn", rotation, arm) + (candidates.origin + shift)[:, None]
        turned = np.einsum("ijn,jlkn->ilkn", rotation, start_rotation)
        frames = Frames(np.where(candidates.carried, turned, start_rotation), np.where(candidates.carried, moved, start_position))
        residual, wrench = closures.evaluate(frames)
        centre = candidates.origin + shift
        gradient = move_wrench(wrench, centre) * np.repeat([size, 1.0], 3)[:, None, None] * (sign * scale)
        used = np.moveaxis(gradient[columns], (0, 1, 2), (2, 1, 0))
        step = np.zeros((6, N))
        step[columns] = -np.einsum("nkm,mn->kn", np.linalg.pinv(used, rcond=_NO_EFFECT), residual * scale)
        largest = np.max(np.abs(step), axis=0, initial=0.0)
        step *= np.minimum(1.0, _LARGEST / np.maximum(largest, 1e-300))
        if float(np.max(largest, initial=0.0)) < 1e-14:
            break
        shift = shift + size * step[:3]
        rotation = np.einsum("ijn,jkn->ikn", rotations.exponential(step[3:]), rotation)
    return rotation, shift, _are_closed(closures, residual, size)


def _are_closed(closures: Closures, residual: Array, size: float) -> Mask:
    """(N,) True for poses at which all loops are closed within :data:`CLOSES`."""
    return np.all([np.maximum(m / size, rad) < CLOSES for m, rad in closures.gaps(residual).values()], axis=0)
