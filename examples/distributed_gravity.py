"""Effect of lumping the weights of rods, as simpler models do, on the sag of the paper's robots.

    python examples/distributed_gravity.py             print the table
    python examples/distributed_gravity.py --write     put table and figure into docs/

Eq. (12) is solved with other W_ig, Δ_igc and platform loads; everything else stays as it is:

- *at the platform*: the weights of all rods act at the platform's point o, and the rods are massless;
- *at the rods' ends*: half of the weight acts on the joint to the platform, the other half on the base or on a slider;
- *at the rods' middles*: a point mass, with the same attached wrenches as the spread weight.
"""

from __future__ import annotations

import sys

import numpy as np
import reproduce_paper
from paper_equations import Limb, limb
from reproduce_paper import ROOT

import kinetostatics as ks

PAGE = ROOT / "docs" / "explanation" / "beside_other_methods.md"
PICTURE = ROOT / "docs" / "pictures" / "distributed_gravity.png"

SPREAD, MIDDLES, ENDS, PLATFORM = "spread", "at the rods' middles", "at the rods' ends", "at the platform"
MODELS = (SPREAD, MIDDLES, ENDS, PLATFORM)
ROBOTS = {"3rps": "3RPS", "2pru_upr": "2PRU-UPR"}
COMPONENTS = ("Δ_dx", "Δ_dy", "Δ_dz", "Δ_rx", "Δ_ry", "Δ_rz")


def limbs_of(name: str, result: ks.Result) -> list[Limb]:
    """Return the limbs in the paper's axes."""
    return [limb(result, i, f"revolute_{i}", y=name == "3rps" or i == 3) for i in (1, 2, 3)]


def gravity_displacement(item: Limb, places: np.ndarray, shares: np.ndarray) -> np.ndarray:
    """Return Δ_igc (n_c,) of point masses on the rod, along our J_ic, with the reactions J_ig W_ig at its end.

    Args:
        item: the limb, a cantilever from B to A.
        places: (k,) where the masses sit, 0 at B … 1 at A; their centre must be the rod's middle.
        shares: (k,) of the rod's weight.
    """
    L, own = item.length, item.mine
    held = item.R.T @ (own.attached_wrenches @ own.attached_intensities)[:3]
    loads = [(place * L, share * item.q * L) for place, share in zip(places, shares, strict=True)]
    # along the rod W_ig has no part; across it the end's reaction
    loads.append((L, held * [1, 1, 0]))
    shift, turn = np.zeros(3), np.zeros(3)
    for s, load in loads:
        bent = s**3 / (3 * item.EI) + s**2 / (2 * item.EI) * (L - s) + s / item.GA
        shift += load * [bent, bent, s / item.EA]
        turn += np.array([-load[1], load[0], 0.0]) * s**2 / (2 * item.EI)
    d, r = item.R @ shift, item.R @ turn
    return own.constraint_wrenches.T @ np.r_[d + np.cross(r, item.o - item.A), r]


def nodes(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return places and shares of the weight of a rod that is divided into ``count`` springs, lumped at their nodes."""
    shares = np.full(count + 1, 1.0 / count)
    shares[[0, -1]] /= 2
    return np.linspace(0, 1, count + 1), shares


def twist_of(name: str, number: int, model: str | int) -> np.ndarray:
    """Return the twist (6,) of o [m, rad] in one of the paper's configurations, with the rods' weight as in a model.

    A number as the model: the rods are cut into so many springs, with the weight at their nodes.
    """
    result = reproduce_paper.analyze(name, number)
    right = result.load + result.platform_weight
    for item in limbs_of(name, result):
        own = item.mine
        if model == PLATFORM:
            right = right + np.r_[item.R @ item.q * item.length, np.zeros(3)]
            continue
        if model == SPREAD:
            sag = own.sag
        elif model == MIDDLES:
            sag = gravity_displacement(item, np.array([0.5]), np.ones(1))
        else:
            sag = gravity_displacement(item, *nodes(1 if model == ENDS else int(model)))
        right = right - own.attached_wrenches @ own.attached_intensities + own.constraint_wrenches @ own.stiffness @ sag
    return np.linalg.solve(result.stiffness, right)


def springs() -> str:
    """Return the error of Δ_dy of the 2PRU-UPR in configuration 2 if each rod is divided into springs, as Markdown."""
    exact = twist_of("2pru_upr", 2, SPREAD)[1]
    counts = (1, 2, 4, 8, 16)
    off = (100 * (twist_of("2pru_upr", 2, count)[1] / exact - 1) for count in counts)
    head = ["| springs in each rod | " + " | ".join(map(str, counts)) + " |", "|---|" + "---:|" * len(counts)]
    return "\n".join([*head, "| Δ_dy is off by | " + " | ".join(f"{value:+.2g} %" for value in off) + " |"])


def table() -> str:
    """Return the twists of configuration 2 as Markdown."""
    lines = ["| robot, configuration | rods' weight | " + " | ".join(COMPONENTS) + " |", "|---|---|" + "---:|" * 6]
    for name, title in ROBOTS.items():
        for model in MODELS:
            lines.append(f"| {title}, 2 | {model} | " + " | ".join(f"{value:.3e}" for value in twist_of(name, 2, model)) + " |")
    return "\n".join(lines)


def draw() -> None:
    """Draw the displacement of o in configuration 2 of both robots."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, panels = pyplot.subplots(1, 4, figsize=(9.5, 3.2), layout="constrained", width_ratios=(3, 3, 3, 3))
    for k, (name, title) in enumerate(ROBOTS.items()):
        for j, (part, unit, factor) in enumerate((((0, 1, 2), "nm", 1e9), ((3, 4, 5), "nrad", 1e9))):
            axes, width = panels[2 * k + j], 0.8 / len(MODELS)
            if name == "2pru_upr":
                unit, factor = ("µm", 1e6) if j == 0 else ("µrad", 1e6)
            for m, model in enumerate(MODELS):
                values = factor * twist_of(name, 2, model)[list(part)]
                axes.bar(np.arange(3) + (m - 1.5) * width, values, width, label=model if k == j == 0 else None)
            axes.axhline(0, color="0.3", linewidth=0.6)
            axes.set_xticks(range(3), [COMPONENTS[i] for i in part])
            axes.set_title(f"{title} [{unit}]", fontsize="medium")
    figure.legend(loc="outside lower center", ncols=4, title="the rods' weight")
    figure.savefig(PICTURE, dpi=110)


def write() -> None:
    """Put the table between the markers of the page, and the figure beside it."""
    page = PAGE.read_text(encoding="utf-8")
    for name, text in (("lumped", table()), ("springs", springs())):
        begin, end = f"<!-- {name}: begin -->", f"<!-- {name}: end -->"
        before, rest = page.split(begin)
        page = f"{before}{begin}\n\n{text}\n\n{end}{rest.split(end)[1]}"
    PAGE.write_text(page, encoding="utf-8")
    draw()


if __name__ == "__main__":
    if "--write" in sys.argv[1:]:
        write()
    else:
        print(f"{table()}\n\n{springs()}")
