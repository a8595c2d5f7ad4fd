"""Compare natural frequencies with a measurement: the frame of GARTEUR SM-AG19.

    python examples/measured_frame.py            the table, for both models of the strip on the wing
    python examples/measured_frame.py --write    the table into docs/explanation/measured_frame.md, and its picture (Matplotlib)

``examples/measured_frame_robot/garteur.urdf.xacro`` describes the frame. Modes are paired with the measured ones by their shapes.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import kinetostatics as ks

Array = NDArray[np.float64]

ROOT = Path(__file__).resolve().parent.parent
FILE = ROOT / "examples" / "measured_frame_robot" / "garteur.urdf.xacro"
PAGE = ROOT / "docs" / "explanation" / "measured_frame.md"
PICTURE = ROOT / "docs" / "pictures" / "measured_frame.png"
#: Shapes, measured frequencies [Hz] and damping ratios [%] of participant C: Balmès and Wright, IMAC XV, 1997.
MEASURED = {
    "wing bending, symmetric, 2 nodes": (6.376, 1.3),
    "fuselage roll, antisymmetric": (16.104, 1.3),
    "wing torsion, antisymmetric": (33.125, 0.8),
    "wing torsion, symmetric": (33.531, 1.0),
    "wing bending, antisymmetric, 3 nodes": (35.647, 1.1),
    "wing bending, symmetric, 4 nodes": (48.384, 2.3),
    "wing in plane, antisymmetric": (49.433, 0.5),
    "wing in plane, symmetric": (55.076, 0.2),
}
#: Parameters of the two models of the strip.
MODELS = {"strip left out": {"strip": False, "cells": 1}, "strip rigidly bonded": {"strip": True}}
#: Number of modes to be computed: six of the frame as a rigid body on its ropes, and the eight measured ones.
COUNT = 14
#: Half the length of a drum [m], by which the twist of the wing is multiplied to be compared with displacements.
LEVER = 0.2
#: Scale of the drawn modes: the largest displacement [m].
DRAWN = 0.25


def modes_of(**parameters: object) -> ks.results.Modes:
    """Return the lowest modes of the frame."""
    return ks.modes(ks.load_robot(FILE, parameters).assemble(), COUNT)


def wing(modes: ks.results.Modes) -> tuple[Array, Array]:
    """Return coordinates y (n,) [m] along the wing, from right to left, and displacement and rotation (count, n, 6) there."""
    pose, joints = modes.configuration, modes.robot.description.joints
    y, moved = [], []
    for name, line in modes.beam_lines.items():
        if "_wing_" in name and "strip" not in name:
            start, span = pose.frame(name)[1, 3], joints[f"{name}_end"].origin.matrix[1, 3]
            y.append(start + span * np.linspace(0, 1, line.shape[1]))
            moved.append(line)
    order = np.argsort(np.concatenate(y), kind="stable")
    return np.concatenate(y)[order], np.concatenate(moved, axis=1)[:, order]


def shapes(modes: ks.results.Modes) -> list[str]:
    """Name the shape of every mode by the motion of the wing.

    The largest of vertical displacement, twist and displacement in the wing's plane decides between bending, torsion and in
    plane. Symmetry is that about y = 0; nodes are changes of sign along the wing. In *fuselage roll* the tailplane turns with the
    fuselage, in antisymmetric bending of the wing against it. Motions with their strain energy in the ropes are those of a rigid
    body.
    """
    y, moved = wing(modes)
    ropes = modes.strain_energy_shares["rope_joint"]
    roll = modes.link_twists["fuselage"][:, 3] * modes.link_twists["fin_top"][:, 3]
    names = []
    for k in range(modes.count):
        fields = {"bending": moved[k, :, 2], "torsion": LEVER * moved[k, :, 4], "in plane": moved[k, :, 0]}
        kind = max(fields, key=lambda name: np.sqrt(np.trapezoid(fields[name] ** 2, y)))
        field = fields[kind]
        across = np.trapezoid(field * np.interp(-y, y, field), y)  # positive if both halves move alike
        parity = "symmetric" if across > 0 else "antisymmetric"
        if ropes[k] > 0.5:
            names.append("rigid body")
        elif kind == "bending" and parity == "antisymmetric" and roll[k] > 0:
            names.append("fuselage roll, antisymmetric")
        else:
            signs = np.sign(field[np.abs(field) > 1e-6 * np.abs(field).max()])
            nodes = f", {np.count_nonzero(np.diff(signs))} nodes" if kind == "bending" else ""
            names.append(f"wing {kind}, {parity}{nodes}")
    return names


def paired(modes: ks.results.Modes) -> dict[str, int]:
    """Return the index of the mode with each measured shape.

    Raises:
        ValueError: not exactly one mode has the shape.
    """
    names = shapes(modes)
    wrong = [name for name in MEASURED if names.count(name) != 1]
    if wrong:
        raise ValueError(f"the shapes {wrong} are not those of exactly one mode: {names}")
    return {name: names.index(name) for name in MEASURED}


def frequencies(**parameters: object) -> dict[str, float]:
    """Return the frequency [Hz] of each measured shape."""
    modes = modes_of(**parameters)
    return {name: float(modes.frequencies[k]) for name, k in paired(modes).items()}


def table() -> str:
    """Return the measured and the computed frequencies as a table."""
    found = [frequencies(**parameters) for parameters in MODELS.values()]
    titles = " | ".join(f"{name} [Hz] | deviation" for name in MODELS)
    lines = [f"| | shape | measured [Hz] | {titles} |", "|---|---|" + "---:|" * 5]
    for number, (name, (measured, damping)) in enumerate(MEASURED.items(), 1):
        cells = " | ".join(f"{model[name]:.2f} | {100 * (model[name] / measured - 1):+.1f} %" for model in found)
        lines.append(f"| {number} | {name} | {measured:.3f} (damping {damping} %) | {cells} |")
    return "\n".join(lines) + "\n"


def draw(path: Path) -> None:
    """Draw the first mode, and the mode with the largest deviation."""
    import matplotlib.pyplot as plt

    modes = modes_of(strip=True)
    pose, joints, pairs = modes.configuration, modes.robot.description.joints, paired(modes)
    figure = plt.figure(figsize=(9, 3.2))
    for place, name in enumerate(("wing bending, symmetric, 2 nodes", "wing in plane, antisymmetric"), 1):
        axes = figure.add_subplot(1, 2, place, projection="3d")
        lines = {beam: line[pairs[name], :, :3] for beam, line in modes.beam_lines.items() if "strip" not in beam}
        scale = DRAWN / max(np.linalg.norm(line, axis=1).max() for line in lines.values())
        drawn = []
        for beam, line in lines.items():
            span = joints[f"{beam}_end"].origin.matrix[:3, 3]
            points = pose.frame(beam)[:3, 3] + np.linspace(0, 1, len(line))[:, None] * span
            axes.plot(*points.T, color="0.7", linewidth=1)
            axes.plot(*(points + scale * line).T, color="C0", linewidth=2)
            drawn += [points, points + scale * line]
        axes.set_box_aspect(np.ptp(np.concatenate(drawn), axis=0), zoom=1.34)
        axes.set_title(f"{name}: {modes.frequencies[pairs[name]]:.2f} Hz (measured {MEASURED[name][0]:.2f})", fontsize=9, y=0.96)
        axes.set_axis_off()
        axes.view_init(elev=28, azim=-140)
    figure.subplots_adjust(left=0, right=1, bottom=0, top=1, wspace=0)
    figure.savefig(path, dpi=110)
    plt.close(figure)


def main(arguments: list[str]) -> None:
    """Print the table, or write it into the page."""
    text = table()
    print(text)
    if "--write" in arguments:
        begin, end = "<!-- table: begin -->\n", "<!-- table: end -->"
        head, _, tail = PAGE.read_text(encoding="utf-8").partition(begin)
        PAGE.write_text(head + begin + text + end + tail.partition(end)[2], encoding="utf-8")
        draw(PICTURE)


if __name__ == "__main__":
    main(sys.argv[1:])
