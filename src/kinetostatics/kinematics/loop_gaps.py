"""Gaps of open loops, as numbers and as text, and the closure of loops from large gaps."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from kinetostatics.kinematics.loop_constraints import LoopEquations
from kinetostatics.kinematics.prescribed import PrescribedCoordinates
from kinetostatics.kinematics.solver import Solver, SolverState
from kinetostatics.math.arrays import Array
from kinetostatics.math.ordering import NOTHING, ranked

#: Gap [m, rad] below which a loop is closed.
CLOSED = 1e-9


def gaps_at(equations: LoopEquations, pose: SolverState) -> dict[str, tuple[float, float]]:
    """Return the gap of each loop at one pose, {name: (m, rad)}."""
    residual, _ = equations.evaluate(equations.forward(pose.x))
    return {name: (float(a[0]), float(b[0])) for name, (a, b) in equations.loop_gaps(residual, pose.x).items()}


def are_within(gaps: Mapping[str, tuple[float, float]], metres: float, radians: float) -> bool:
    """Whether no loop has a larger gap."""
    return all(a <= metres and b <= radians for a, b in gaps.values())


def worst_gaps_text(equations: LoopEquations, gaps: Mapping[str, tuple[float, float]], least: float = CLOSED) -> str:
    """Return the largest gaps above ``least`` [m, rad] as text."""
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
    parts = [f"{'loops' if names[1:] else 'loop'} {', '.join(map(repr, names))} {'are' if names[1:] else 'is'} {size} open"
             for size, names in alike.items()]  # fmt: skip
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
        solver: solver with the equations.
        poses: initial poses.
        prescribed: prescribed coordinates.
        target: (n, 1) their values.
        weight: weight of the equations of prescribed coordinates relative to those of the loops.
        cutoff: relative singular value below which there is no step in a direction. Rounding in a file makes every motion of an
            overconstrained robot change its gaps slightly; they must not be closed by undoing the motion.

    Returns:
        The poses with the smallest residuals found, and these scaled residuals (N,), the largest entry of each.
    """
    found = SolverState(np.array(poses.x), np.array(poses.c))
    solver.impose(prescribed, found, target)

    def system(poses: SolverState) -> tuple[Array, Array]:
        residual, gradient = solver.system(prescribed, poses, np.broadcast_to(target, (target.shape[0], poses.x.shape[1])))
        residual[solver.equations.count :] *= weight
        gradient[solver.equations.count :] *= weight
        return residual, gradient

    residual, gradient = system(found)
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
        trial = solver.advance(prescribed, found.take(active), step)
        new_residual, new_gradient = system(trial)
        better = np.sum(new_residual**2, axis=0) <= np.sum(r**2, axis=0)
        gained = active[better]
        found.x[:, gained], found.c[:, gained] = trial.x[:, better], trial.c[:, better]
        residual[:, gained], gradient[:, :, gained] = new_residual[:, better], new_gradient[:, :, better]
        left[gained] = np.max(np.abs(residual[:, gained]), axis=0, initial=0.0)
        damping[active] = np.where(better, np.maximum(damped / 10, 1e-15), 10 * damped)
        over = np.where(better, largest < 1e-15, (damping[active] > 1e6) | (largest < 1e-14))
        active = active[~over & (left[active] >= 1e-15)]
    return found, left
