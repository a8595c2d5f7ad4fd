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
        "This page evaluates the equations of C. Yang, F. Huang, W. Ye, Q. Chen, *Gravity-Based Kinetostatic Modeling of "
        "Parallel Manipulators Using Screw Theory*, Chinese Journal of Mechanical Engineering 36 (2023), and examines those of "
        "its numbers that are not reproduced.",
        "",
        "## Symbols",
        "",
        "The [glossary](glossary.md) lists symbols and attributes. In addition:",
        "",
        "| symbol | equation | attribute |",
        "|---|---|---|",
        "| W_e, W_gm | (5) | `result.load`, `result.platform_weight` |",
        "| Δ_ic, Δ_ig | (9) | `J_icᵀ result.twist`, `J_igᵀ result.twist` |",
        "| L_i | – | `result.beams[…].length` |",
        "| f_i1, f_i2, f_ia | (11), (17) | `result.paper_forces`; "
        "[f_ia is not always the actuator force](method.md#7-joint-wrenches-and-actuator-forces) |",
        "",
        "In this package the limb axis y_i is along the first revolute axis; in the PRU limbs of the paper x_i is. The attached "
        "wrench *along y_i* of these limbs is therefore our *force along limb x*. The tables below use the axes of the paper, "
        "and so does the report of `kinetostatics analyze 2pru_upr --hinge-axis limb_1=x limb_2=x …` "
        '(`result.report(hinge_axes={"limb_1": "x", "limb_2": "x"})`).',
        "",
        "## The equations in numbers",
        "",
        "The paper's formulas are evaluated from points, axes, sections and weights, with κ = 1 as in Eq. (13), and with J_icᵀ "
        "instead of the misprint Δ_icᵀ in Eq. (12). The values differ from those of the package by rounding only, unless a row "
        "gives the difference.",
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
