"""The paper, step by step: where its symbols are in the package, its equations in numbers, and what does not come out.

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

#: Symbol of the paper, its equation, the attribute, what the tables print, unit and sign.
SYMBOLS = [
    ("T_i", "(2)", "– (the passive joints' twists, reciprocal to J_ic)", "–", "m, rad"),
    ("R_i", "after (16)", "– (z along the last beam, y from the first revolute axis)", "limb axis, limb x, limb y", "–"),
    ("a_i, L_i", "(20), (13)", 'result.beams["rod_1"].length', "length", "m"),
    ("J_ic", "(2)", 'result.limbs["limb_1"].constraint_wrenches', "constraint", "1, m; about o"),
    ("J_ig", "(4)", 'result.limbs["limb_1"].attached_wrenches', "attached", "1, m; about o"),
    (
        "W_ic, f_i1, f_i2",
        "(11)",
        'result.limbs["limb_1"].intensities, result.paper_forces',
        "intensity",
        "N, N·m; what the platform puts on the limb",
    ),
    ("W_ig", "(3)", 'result.limbs["limb_1"].attached_intensities', "intensity", "N, N·m"),
    ("f_ia", "(17)", 'result.paper_forces["limb_1"]["f_1a"]', "N base end (beams)", "N; tension positive"),
    ("C_ic", "(1)", 'result.limbs["limb_1"].compliance', "–", "m/N, rad/(N·m)"),
    ("K_ic", "(1)", 'result.limbs["limb_1"].stiffness', "–", "N/m, N·m/rad"),
    ("Δ_igc", "(16), (19), (21)", 'result.limbs["limb_1"].sag', "–", "m, rad; along J_ic"),
    ("Δ_ic, Δ_ig", "(9)", "J_icᵀ result.twist, J_igᵀ result.twist", "–", "m, rad"),
    ("W_e, W_gm", "(5)", "result.load, result.platform_weight", "load at o", "N, N·m; about o"),
    ("Δ", "(12)", "result.twist", "total", "m, rad; of o"),
    ("C, K", "(12)", "result.compliance, result.stiffness", "Stiffness of the platform", "at o"),
]


def page() -> str:
    """Return docs/explanation/paper.md."""
    lines = [
        "# The paper, step by step",
        "",
        "*Written by `python examples/paper_step_by_step.py --write`; a test fails when it is stale.*",
        "",
        "C. Yang, F. Huang, W. Ye, Q. Chen, *Gravity-Based Kinetostatic Modeling of Parallel Manipulators Using Screw "
        "Theory*, Chinese "
        "Journal of Mechanical Engineering 36 (2023): where its symbols are in the package, its equations in numbers, "
        "and what does not "
        "come out.",
        "",
        "## Symbols",
        "",
        "`result` is what `ks.analyze` returns. A wrench of a limb is what the platform puts on it, about o; axes are "
        "the world's.",
        "",
        "| symbol | equation | attribute | in the tables | unit, sign |",
        "|---|---|---|---|---|",
        *(
            f"| {symbol} | {equation} | {_code(attribute)} | {label} | {unit} |"
            for symbol, equation, attribute, label, unit in SYMBOLS
        ),
        "",
        "The paper's limb axes differ from ours in one place: z_i lies along the rod in both, y_i along the first "
        "revolute axis in all our "
        "limbs and in its RPS and UPR limbs, but in its PRU limbs x_i lies along that axis. Its attached wrench *along "
        "y_i* of the PRU "
        "limbs is therefore our *force along limb x*. `kinetostatics analyze 2pru_upr --hinge-axis limb_1=x limb_2=x …` "
        '(`result.report(hinge_axes={"limb_1": "x", "limb_2": "x"})`) names them as the paper does. '
        "The numbers below are in its axes.",
        "",
        "`result.paper_forces` has its f_i1, f_i2 and f_ia by name. f_ia of Eq. (17) is the axial force at the base "
        "end of the rod: of a "
        "PRU limb that is not what the actuator holds.",
        "",
        "## The equations in numbers",
        "",
        "The paper's formulas, evaluated from points, axes, sections and weights alone. The same quantities out of the "
        "result differ by rounding only, unless a row says more. "
        "κ = 1 as in Eq. (13), and Eq. (12) with J_icᵀ where the paper prints Δ_icᵀ.",
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
        if "UPR limb 3" in title:
            lines += ["Its matrices, row by row:", "", "| | rows |", "|---|---|"]
            lines += [f"| {r.what} | {_rows(r.ours)} |" for r in rows if r.what in ("J_3c", "J_3g", "C_3c", "K_3c")]
            lines.append("")
    return "\n".join([*lines, story(), ""])


def _rows(matrix: np.ndarray) -> str:
    """Return a matrix in full, row by row."""
    size = np.max(np.abs(matrix))
    return "<br>".join(", ".join("0" if abs(x) < 1e-9 * size else f"{x:.4g}" for x in row) for row in matrix)


def _code(text: str) -> str:
    return text if text.startswith("–") else ", ".join(f"`{part}`" for part in text.split(", "))


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
