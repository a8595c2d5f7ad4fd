"""Reproduce Tables 1 to 4 of the paper with both of its robots, side by side with the printed numbers.

    python examples/reproduce_paper.py           print the tables
    python examples/reproduce_paper.py --write   put them into docs/explanation/against_the_paper.md, between its markers

C. Yang, F. Huang, W. Ye, Q. Chen, Gravity-Based Kinetostatic Modeling of Parallel Manipulators Using Screw Theory,
Chinese Journal of Mechanical Engineering 36 (2023).
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

import kinetostatics as ks

ROOT = Path(__file__).resolve().parent.parent
TABLES = json.loads((Path(__file__).parent / "paper_tables.json").read_text(encoding="utf-8"))
PAGE = ROOT / "docs" / "explanation" / "against_the_paper.md"
BEGIN, END = "<!-- paper tables: begin -->", "<!-- paper tables: end -->"

#: What is smaller than this part of the largest number of its kind counts as zero: 1e-22 m is rounding.
NOISE = 1e-7

TITLES = {
    "3rps": ("3RPS", "Table 1: twist of o", "Table 2: forces"),
    "2pru_upr": ("2PRU-UPR", "Table 3: twist of o", "Table 4: forces"),
}
#: The paper's Table 3 has gravity along +Z.
GRAVITY = {"3rps": (0, 0, -9.8), "2pru_upr": (0, 0, 9.8)}
POSES: dict[tuple[str, int], dict[str, Any]] = {
    ("3rps", 1): {"actuators": {"prismatic_1": 0.0, "prismatic_2": 0.0, "prismatic_3": 0.0}},
    ("3rps", 2): {
        "platform": {"z": 0.5, "azimuth": np.radians(-170), "tilt": np.radians(10)},
        "orientation": "tilt_torsion",
    },
    ("2pru_upr", 1): {"platform": {"z": 0.6, "rx": 0.0, "ry": 0.0}, "orientation": "XYZ"},
    ("2pru_upr", 2): {"platform": {"z": 0.6, "rx": np.radians(-5), "ry": np.radians(-6)}, "orientation": "XYZ"},
}
#: The commands that print each configuration, with the paper's signs.
COMMANDS = {
    ("3rps", 1): "kinetostatics analyze 3rps --gravity 0 0 -9.8 --full",
    ("3rps", 2): "kinetostatics analyze 3rps --platform z=500mm azimuth=-170deg tilt=10deg --orientation tilt_torsion "
    "--gravity 0 0 -9.8 --full",
    ("2pru_upr", 1): "kinetostatics analyze 2pru_upr --platform z=600mm rx=0 ry=0 --orientation XYZ --gravity 0 0 9.8 --full",
    ("2pru_upr", 2): "kinetostatics analyze 2pru_upr --platform z=600mm rx=-5deg ry=-6deg --orientation XYZ --gravity 0 0 9.8 "
    "--full",
}
REMARKS = {
    "3rps": """\
All printed digits of the analytical rows are reproduced. Some data are not in the paper: here the platform is a disc 20 mm
thick, the limbs are numbered clockwise, and configuration 2 is z = 500 mm with a tilt of 10° towards −170° and no torsion.""",
    "2pru_upr": """\
All printed digits of configuration 1 are reproduced, with a density of 7850 kg/m³ instead of the 7820 kg/m³ of the text. In
configuration 2 **five numbers are not reproduced:** Δ_dy, Δ_dz, Δ_rx, Δ_rz and f_32. All other forces agree with the paper's
*finite elements*. A frame of beams in OpenSees agrees with ours to all digits (`kinetostatics verify`). [Solid finite
elements](solid_finite_elements.md) give Δ_dy between 3.110e-6 and 3.124e-6 m and Δ_rx between 7.601e-6 and 7.636e-6 rad,
depending on the joint model. No parameter was fitted. [The paper, step by step](paper.md#configuration-2-of-the-2pru-upr)
examines the disagreement, and explains the pose and the direction of gravity.""",
}


@cache
def analyze(robot: str, number: int) -> ks.Result:
    """Analyze one of the paper's configurations."""
    loaded = ks.load_robot(ROOT / "robots" / f"{robot}.urdf.xacro")
    return ks.analyze(loaded.assemble(**POSES[robot, number]), gravity=GRAVITY[robot])


def ours(robot: str, number: int) -> dict[str, list[float]]:
    """Return the paper's quantities as we compute them, forces as magnitudes like the paper's."""
    result = analyze(robot, number)
    limbs = list(result.limbs.values())
    return {
        "twist": [float(value) for value in result.twist],
        "f1": [abs(float(limb.intensities[0])) for limb in limbs],
        "f2": [abs(float(limb.intensities[1])) for limb in limbs],
        # the paper's f_ia is the axial force at the rod's base end, which for a PRU limb is not the actuator's
        "fa": [abs(float(result.beams[f"rod_{k}"].section_wrenches[0, 0])) for k in (1, 2, 3)],
    }


def difference(value: float, printed: str, scale: float) -> str:
    """Return the difference from a printed number in percent, or nothing where both are rounding."""
    reference = float(printed)
    if abs(reference) < NOISE * scale:
        return "–"
    return f"{100 * (abs(value) - abs(reference)) / abs(reference):+.2f} %".replace("-0.00", "+0.00")


def rows(robot: str, number: int, names: dict[str, list[str]]) -> Iterator[str]:
    """Yield the Markdown rows of one configuration."""
    printed, computed = TABLES[robot][f"configuration_{number}"], ours(robot, number)
    for key, labels in names.items():
        scale = max(abs(value) for value in computed[key if key == "twist" else "fa"])
        for k, label in enumerate(labels):
            if k >= len(printed["analytical"][key]):
                continue  # the paper prints limb 1 alone
            analytical, fea, value = printed["analytical"][key][k], printed["FEA"][key][k], computed[key][k]
            if abs(value) < NOISE * scale:
                continue  # zero, in the paper too
            shown = f"{value:.4e}" if key == "twist" else f"{value:.3f}"
            yield (
                f"| {number} | {label} | {analytical} | {fea} | {shown} "
                f"| {difference(value, analytical, scale)} | {difference(value, fea, scale)} |"
            )


def tables() -> str:
    """Return all four tables as Markdown."""
    twist = ["Δ_dx [m]", "Δ_dy [m]", "Δ_dz [m]", "Δ_rx [rad]", "Δ_ry [rad]", "Δ_rz [rad]"]
    lines = []
    for robot, (name, *titles) in TITLES.items():
        names: list[dict[str, list[str]]] = [
            {"twist": twist},
            {key: [f"f_{limb}{key[1]} [N]" for limb in (1, 2, 3)] for key in ("f1", "f2", "fa")},
        ]
        for title, part in zip(titles, names, strict=True):
            lines += [
                f"**{name}, {title}**",
                "",
                "| conf. | | paper, analytical | paper, FEA | ours | to analytical | to FEA |",
                "|---|---|---:|---:|---:|---:|---:|",
                *rows(robot, 1, part),
                *rows(robot, 2, part),
                "",
            ]
        commands = [f"{COMMANDS[robot, number]}  # configuration {number}" for number in (1, 2)]
        lines += ["```sh", *commands, "```", "", REMARKS[robot], ""]
    return "\n".join(lines)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--write", action="store_true", help=f"put the tables into {PAGE.name}")
    if parser.parse_args().write:
        before, _, rest = PAGE.read_text(encoding="utf-8").partition(BEGIN)
        PAGE.write_text(f"{before}{BEGIN}\n\n{tables()}\n{END}{rest.partition(END)[2]}", encoding="utf-8")
    else:
        print(tables())
