"""Draws figures of the how-to pages from their own code: ``python examples/how_to_figures.py [FOLDER]``.

Needs Matplotlib, and Chromium for a robot.
"""

import re
import sys
import tempfile
from pathlib import Path
from typing import Any

import kinetostatics as ks

ROOT = Path(__file__).parent.parent


def page_names(page: str, **swaps: str) -> dict[str, Any]:
    """Run the code of a how-to page without its output, and return its names; ``swaps`` replace text to make it faster."""
    text = (ROOT / "docs" / "how_to" / f"{page}.md").read_text(encoding="utf-8")
    code = "".join(part.split("```")[0] for part in text.split("```python\n")[1:])
    for old, new in swaps.items():
        assert old in code
        code = code.replace(old, new)
    names: dict[str, Any] = {}
    exec("\n".join(line for line in code.splitlines() if not re.match(r"print\(|[\w.]+\.save\(", line)), names)
    return names


def draw_feedforward(path: Path) -> None:
    """Draw the actuators' forces round the cone."""
    names = page_names("feedforward")
    ks.plot.save(ks.plot.line(names["found"].to_dataset({"azimuth": names["turn"]}), names["forces"]), path, dpi=200)


def draw_correction(path: Path) -> None:
    """Draw the pose error along the path, uncorrected and corrected, for two choices of the controlled coordinates."""
    from matplotlib import pyplot as plt

    names = page_names("correct_a_machine")
    tilts = names["path"].platform["rx"]
    figure, rows = plt.subplots(2, 2, figsize=(7.2, 5.0), sharex=True, sharey="row", layout="constrained")
    for column, found in enumerate((names["found"], names["other"])):
        for row, name in zip(rows, ("y", "rx"), strict=True):
            ks.plot.line(found.to_dataset({"rx": tilts}), [f"uncorrected_error:{name}", f"residual_error:{name}"], ax=row[column])
        rows[0, column].set_title(f"controlled: {', '.join(found.controlled)}")
    for legend in list(figure.legends):
        legend.remove()
    figure.legend(rows[0, 0].get_lines(), ["uncorrected", "corrected"], loc="outside lower center", ncols=2, frameon=False)
    for axes in rows.flat:
        axes.label_outer()
    ks.plot.save(figure, path, dpi=150)
    plt.close(figure)


def draw_motion(path: Path) -> None:
    """Draw the sag of the gripper over time, and torque and speed of the motors."""
    from matplotlib import pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(7.2, 3.0), layout="constrained")
    fast = page_names("motion")["fast"]
    ks.plot.path(fast, "displacement", ax=left)
    ks.plot.path(fast, "torque_speed", ax=right)
    for axes, limits in ((left, (200,)), (right, (40, -40))):
        for limit in limits:
            axes.axhline(limit, color="0.3", linestyle=":")
    ks.plot.save(figure, path, dpi=150)
    plt.close(figure)


def draw_frequencies(path: Path) -> None:
    """Draw the first natural frequency over the tilts, and the compliance over the frequency."""
    names = page_names("natural_frequencies")
    ks.plot.save(names["figure"], path, dpi=200)
    ks.plot.save(names["compliances"], path.with_name("response_3rps.png"), dpi=200)


def draw_sensitivities(path: Path) -> None:
    """Draw the effect of one per cent more of each parameter."""
    ks.plot.save(ks.plot.sensitivities(page_names("find_what_to_stiffen")["s"]), path, dpi=200)


def draw_tolerances(path: Path) -> None:
    """Draw the histogram of random samples."""
    ks.plot.save(ks.plot.tolerances(page_names("tolerances")["s"]), path, dpi=200)


def draw_front(path: Path) -> None:
    """Draw mass against the largest deflection."""
    ks.plot.save(ks.plot.pareto(page_names("size_a_rod")["front"]), path, dpi=200)


def draw_calibration(path: Path) -> None:
    """Draw the residuals of the readings, and the outlier."""
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
    draw_motion(folder / "motion_delta.png")
    draw_frequencies(folder / "frequency_3rps.png")
    draw_sensitivities(folder / "stiffen_2pru_upr.png")
    draw_tolerances(folder / "tolerances_2pru_upr.png")
    draw_front(folder / "pareto_2pru_upr.png")
    draw_calibration(folder / "calibrate_2pru_upr.png")
    draw_pendulum(folder / "pendulum.png")
