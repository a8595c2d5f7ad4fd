"""The paper, step by step: its symbols in the package, its equations in numbers, and the numbers that are not reproduced.

    python examples/paper_step_by_step.py            print the page
    python examples/paper_step_by_step.py --write    write docs/explanation/paper.md

C. Yang, F. Huang, W. Ye, Q. Chen, Chinese Journal of Mechanical Engineering 36 (2023).
"""

from __future__ import annotations

import sys

import numpy as np
from paper_configuration_2 import story
from paper_equations import Row, pages
from reproduce_paper import ROOT

PAGE = ROOT / "docs" / "explanation" / "paper.md"


def page() -> str:
    """Return docs/explanation/paper.md."""
    lines = [
        "# The paper, step by step",
        "",
        "*Written by `python examples/paper_step_by_step.py --write`; a test fails when it is stale.*",
        "",
        "C. Yang, F. Huang, W. Ye, Q. Chen, *Gravity-Based Kinetostatic Modeling of Parallel Manipulators Using Screw "
        "Theory*, Chinese "
        "Journal of Mechanical Engineering 36 (2023): its equations in numbers, and the numbers that are not reproduced.",
        "",
        "## Symbols",
        "",
        "The [glossary](glossary.md) lists symbols and attributes. Δ_ic and Δ_ig of Eq. (9) are `J_icᵀ result.twist` and "
        "`J_igᵀ result.twist`, W_e and W_gm of Eq. (5) `result.load` and `result.platform_weight`, L_i `result.beams[…].length`.",
        "",
        "In the PRU limbs the paper's limb axis x_i is along the first revolute axis; in its other limbs, and in all limbs of "
        "this package, y_i is. Its attached wrench *along y_i* of the PRU limbs is therefore our *force along limb x*. "
        "`kinetostatics analyze 2pru_upr --hinge-axis limb_1=x limb_2=x …` "
        '(`result.report(hinge_axes={"limb_1": "x", "limb_2": "x"})`) uses the axes of the paper, as do the tables below.',
        "",
        "`result.paper_forces` contains f_i1, f_i2 and f_ia. f_ia of Eq. (17) is the axial force at the base end of the rod, "
        "in a PRU limb not the actuator force.",
        "",
        "## The equations in numbers",
        "",
        "These are the paper's formulas, evaluated from points, axes, sections and weights. They differ from the results of the "
        "package by rounding only, unless a row gives the difference. "
        "κ = 1 as in Eq. (13), and Eq. (12) has J_icᵀ instead of the printed Δ_icᵀ.",
        "",
    ]
    for title, rows in pages():
        if "PRU limb 2" in title:  # as limb 1
            continue
        lines += [f"### {title}", "", "| | equation | value |", "|---|---|---|"]
        lines += [
            f"| {r.what} | {r.equation} | {_numbers(r, r.formula)}{_noise(r.difference)} |" for r in rows if r.formula.ndim < 2
        ]
        lines.append("")

    return "\n".join([*lines, story(), ""])


def _numbers(row: Row, array: np.ndarray) -> str:
    """Return a scalar or vector in numbers."""
    size = max(float(np.max(np.abs(row.ours), initial=0.0)), row.scale)
    return ", ".join("0" if abs(x) < 1e-9 * size else f"{x:.4g}" for x in array)


def _noise(difference: float) -> str:
    return "" if difference < 1e-11 else f" (differs by {difference:.1e})"


if __name__ == "__main__":
    if "--write" in sys.argv[1:]:
        PAGE.write_text(page(), encoding="utf-8")
    else:
        print(page())
