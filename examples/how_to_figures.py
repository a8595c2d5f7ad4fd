"""Draws figures of the how-to pages from their own code: ``python examples/how_to_figures.py [FOLDER]``.

Needs Matplotlib, and Chromium for a robot.
"""

import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

import kinetostatics as ks

ROOT = Path(__file__).parent.parent


def page_names(page: str, **swaps: str) -> dict[str, Any]:
    """Run the code of a how-to page, but for what it prints and writes, and return its names; ``swaps`` make it shorter."""
    text = (ROOT / "docs" / "how_to" / f"{page}.md").read_text(encoding="utf-8")
    code = "".join(part.split("```")[0] for part in text.split("```python\n")[1:])
    for old, new in swaps.items():
        assert old in code
        code = code.replace(old, new)
    names: dict[str, Any] = {}
    exec(
        "\n".join(line for line in code.splitlines() if not line.startswith(("print", "found.save", "best.save", "front.save"))),
        names,
    )
    return names


def draw_feedforward(path: Path) -> None:
    """Draw the drives' forces round the cone."""
    from matplotlib import pyplot as plt

    names = page_names("feedforward")
    alone = ks.analyze(names["path"])
    figure, axes = plt.subplots(figsize=(6.4, 3.4), layout="constrained")
    for k, (drive, force) in enumerate(names["found"].actuator_forces.items()):
        axes.plot(np.degrees(names["turn"]), force, color=f"C{k}", label=drive)
        axes.plot(np.degrees(names["turn"]), alone.actuator_forces[drive], "--", color=f"C{k}", linewidth=0.9)
    axes.set(xlabel="azimuth [°]", ylabel="force of the drive [N]", xlim=(0, 360), xticks=range(0, 361, 60))
    axes.legend(frameon=False, ncols=3, loc="upper center", bbox_to_anchor=(0.5, 1.15))
    axes.grid(alpha=0.3)
    figure.savefig(path, dpi=150)
    plt.close(figure)


def draw_correction(path: Path) -> None:
    """Draw what the platform misses along the path, uncorrected and corrected."""
    from matplotlib import pyplot as plt

    names = page_names("correct_a_machine")
    found, other = names["found"], names["other"]
    angle = np.degrees(found.wanted.platform["rx"])
    figure, rows = plt.subplots(2, 3, figsize=(8.4, 4.6), sharex=True, sharey="row", layout="constrained")
    columns = {
        "uncorrected": found.deviation_coordinates,
        "corrected: z, rx, ry": found.remaining_coordinates,
        "corrected: z, y, ry": other.remaining_coordinates,
    }
    for column, (title, off) in enumerate(columns.items()):
        for k, name in enumerate(off):
            axes = rows[k // 3, column]
            axes.plot(angle, 1e6 * off[name], label=name)
            axes.grid(alpha=0.3)
        rows[0, column].set_title(title)
        rows[1, column].set_xlabel("rx [°]")
    rows[0, 0].set_ylabel("position of o misses by [µm]")
    rows[1, 0].set_ylabel("angle misses by [µrad]")
    for axes in rows[:, 2]:
        axes.legend(frameon=False, loc="center left", bbox_to_anchor=(1.0, 0.5))
    figure.savefig(path, dpi=150)
    plt.close(figure)


def draw_sensitivities(path: Path) -> None:
    """Draw what one per cent more of each parameter does."""
    ks.plot.save(ks.plot.sensitivities(page_names("find_what_to_stiffen")["s"]), path, dpi=200)


def draw_spread(path: Path) -> None:
    """Draw how far robots made at random differ."""
    ks.plot.save(ks.plot.spread(page_names("tolerances")["s"]), path, dpi=200)


def draw_front(path: Path) -> None:
    """Draw mass against the largest deflection."""
    ks.plot.save(ks.plot.pareto(page_names("size_a_rod")["front"]), path, dpi=200)


def draw_sizes(path: Path) -> None:
    """Draw mass and largest deflection over the diameter, and the optimum."""
    from matplotlib import pyplot as plt

    best = page_names("size_a_rod")["best"]
    diameters = np.linspace(0.04, 0.09, 26)
    angles = np.radians([-10, 0, 10])
    over = {"z": [0.58, 0.6, 0.62], "rx": angles, "ry": angles}
    ds = ks.sweep("2pru_upr", platform=over, parameters={"rod_diameter": diameters})
    deflection = ks.indices.deflection_any_direction(ds, 500, beyond_limits=True).max(["z", "rx", "ry"])
    masses = []
    for diameter in diameters:
        robot = ks.load_robot("2pru_upr", {"rod_diameter": float(diameter)})
        masses.append(float(robot.weights.masses(robot.zero_frames).sum()))
    figure, axes = plt.subplots(figsize=(6.4, 3.4), layout="constrained")
    axes.semilogy(1e3 * diameters, 1e3 * deflection)
    axes.axhline(0.15, color="grey", linestyle="--")
    axes.plot(1e3 * best.parameters["rod_diameter"], 1e3 * best.active[0].worst, "ko", markersize=9, markerfacecolor="none")
    axes.set(xlabel="diameter of the rods [mm]", ylabel="largest deflection under 500 N [mm]")
    axes.grid(alpha=0.3, which="both")
    right = axes.twinx()
    right.plot(1e3 * diameters, masses, color="tab:orange")
    right.set_ylabel("mass [kg]", color="tab:orange")
    figure.savefig(path, dpi=150)
    plt.close(figure)


def draw_calibration(path: Path) -> None:
    """Draw the residuals of the readings, and the one that does not fit."""
    ks.plot.save(ks.plot.calibration(page_names("calibrate")["found"]), path, dpi=200)


def draw_pendulum(path: Path) -> None:
    """Draw the pendulum that a spring balances, as the page shows it; needs Chromium."""
    with tempfile.TemporaryDirectory() as folder:
        own = {f'"{name}"': f'"{folder}/{name}"' for name in ("pendulum.urdf", "balanced.png")}
        pendulum = page_names("balance_gravity", **own)["pendulum"]
        result = ks.analyze(pendulum.assemble(actuators={"hinge": 0.4}))
        ks.save_image(result, path, size=(760, 560))


if __name__ == "__main__":
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "docs" / "pictures"
    draw_feedforward(folder / "feedforward_3rps.png")
    draw_correction(folder / "corrected_2pru_upr.png")
    draw_sensitivities(folder / "stiffen_2pru_upr.png")
    draw_spread(folder / "spread_2pru_upr.png")
    draw_front(folder / "pareto_2pru_upr.png")
    draw_sizes(folder / "size_2pru_upr.png")
    draw_calibration(folder / "calibrate_2pru_upr.png")
    draw_pendulum(folder / "pendulum.png")
