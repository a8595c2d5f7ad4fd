"""How far loops are open, in numbers and in words."""

from __future__ import annotations

from collections.abc import Mapping

from kinetostatics.kinematics.loop_constraints import LoopEquations
from kinetostatics.kinematics.solver import SolverState
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
