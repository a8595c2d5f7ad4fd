"""How far loops are open, in numbers and in words; and those of one pose closed from far away."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from kinetostatics.kinematics.loop_constraints import LoopEquations
from kinetostatics.kinematics.solver import PrescribedCoordinates, Solver, SolverState
from kinetostatics.math.arrays import Array
from kinetostatics.math.ordering import NOTHING, ranked

#: Gap [m, rad] below which a loop is closed.
CLOSED = 1e-9


def gaps_at(equations: LoopEquations, pose: SolverState) -> dict[str, tuple[float, float]]:
    """Return how far each loop is open at one pose, {name: (m, rad)}."""
    residual, _ = equations.evaluate(equations.forward(pose.x))
    return {name: (float(a[0]), float(b[0])) for name, (a, b) in equations.openings(residual, pose.x).items()}


def are_within(gaps: Mapping[str, tuple[float, float]], metres: float, radians: float) -> bool:
    """Whether all loops are closed up to these gaps."""
    return all(a <= metres and b <= radians for a, b in gaps.values())


def worst_gaps_text(equations: LoopEquations, gaps: Mapping[str, tuple[float, float]]) -> str:
    """Say how far the loops that are widest open are so."""
    items = list(gaps.items())
    worst = [items[k] for k in ranked([max(sizes) for _, sizes in items]) if max(items[k][1]) > CLOSED]
    shown = []
    for name, (metres, radians) in worst[:3]:
        metres, radians = (0.0 if size <= NOTHING * max(worst[0][1]) else size for size in (metres, radians))
        if max(metres, radians) > 0.01 * max(worst[0][1]):
            if name in equations.couplings.names:
                size = f"{metres:.3g} m" if metres > 0 else f"{radians:.3g} rad"
                shown.append(f"joint {name!r} is {size} beside where its <mimic> puts it")
            else:
                shown.append(f"loop {name!r} stays {metres:.3g} m" + (f" and {radians:.3g} rad" if radians > 0 else "") + " open")
    return ", ".join(shown) if shown else "no loop stays open"


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


def close(
    solver: Solver,
    poses: SolverState,
    prescribed: PrescribedCoordinates,
    target: Array,
    weight: float = 1.0,
    cutoff: float = 1e-9,
) -> tuple[SolverState, float]:
    """Close the loops of one pose from far away by damped least squares (Levenberg–Marquardt).

    Args:
        solver: whose equations they are.
        poses: one pose to start from.
        prescribed: what is given, and ``target`` (n, 1) its values.
        target: see ``prescribed``.
        weight: of the prescribed coordinates' equations against those of the loops.
        cutoff: directions with a smaller relative singular value are left alone. Rounding in a file makes every motion of an
            overconstrained robot open its loops a little; they are not to be closed by undoing the motion.

    Returns:
        The pose with the smallest residual found, and that scaled residual (largest entry).
    """
    here = SolverState(np.array(poses.x), np.array(poses.c))
    solver.impose(prescribed, here, target)
    damping = 1e-6

    def system(poses: SolverState) -> tuple[Array, Array]:
        residual, gradient = solver.system(prescribed, poses, target)
        residual[solver.equations.count :] *= weight
        gradient[solver.equations.count :] *= weight
        return residual, gradient

    residual, gradient = system(here)
    for _ in range(200):
        if not residual.size or float(np.abs(residual).max()) < 1e-15:
            break
        r = residual[:, 0]
        U, values, V = np.linalg.svd(gradient[:, :, 0], full_matrices=False)
        gain = np.where(values > cutoff * values.max(initial=0.0), values / (values**2 + damping), 0.0)
        step = np.asarray(-(V.T @ (gain * (U.T @ r))), dtype=np.float64)
        largest = float(np.abs(step).max(initial=0.0))
        if largest > 0.5:
            step *= 0.5 / largest
        trial = solver.advance(prescribed, here, step[:, None])
        new_residual, new_gradient = system(trial)
        if float(np.sum(new_residual**2)) <= float(np.sum(r**2)):
            here, residual, gradient = trial, new_residual, new_gradient
            damping = max(damping / 10, 1e-15)
            if largest < 1e-15:
                break
        else:
            damping *= 10
            if damping > 1e6 or largest < 1e-14:
                break
    return here, float(np.abs(residual).max(initial=0.0))
