"""Draws every kind of figure for three robots, each as a PNG: ``python examples/plot_kinds.py FOLDER [KIND …]``.

``python examples/plot_kinds.py FOLDER --docs`` then puts those of a kind beside one another, for the documentation; needs
Matplotlib, SciPy and Pillow. The fronts take some minutes.
"""

import sys
from collections.abc import Callable
from functools import cache
from itertools import product
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from PIL import Image

import kinetostatics as ks

ROBOTS = ("3rps", "delta", "2pru_upr")
DOCS = Path(__file__).resolve().parents[1] / "docs" / "pictures" / "plots"
#: Coordinates of slices to the right, upwards and held, and of one pose; angles in radians.
AXES = {"3rps": ("rx", "ry", "z"), "delta": ("x", "y", "z"), "2pru_upr": ("rx", "ry", "z")}
HEIGHT = {"3rps": 0.6, "delta": -0.8, "2pru_upr": 0.5}
LOAD = [0, 0, -500, 0, 0, 0]


def at_height(robot: str, **others: Any) -> dict[str, Any]:
    """Return coordinates of the platform at a height of its workspace; those not given are 0."""
    right, up, held = AXES[robot]
    return {right: 0.0, up: 0.0, held: HEIGHT[robot], **others}


@cache
def body(robot: str) -> xr.Dataset:
    """Return a map over all of the workspace."""
    right, up, held = AXES[robot]
    angles, reach = np.radians(np.linspace(-60, 60, 33)), np.linspace(-0.8, 0.8, 33)
    grids = {"3rps": (angles, np.linspace(0.2, 1.0, 17)), "delta": (reach, np.linspace(-1.1, -0.3, 17))}
    flat, heights = grids.get(robot, (np.radians(np.linspace(-45, 45, 31)), np.linspace(0.2, 0.9, 15)))
    return ks.sweep(robot, platform={right: flat, up: flat, held: heights}, progress=False)


@cache
def tilts(robot: str) -> xr.Dataset:
    """Return a map over azimuth and tilt; for the Delta, which does not tilt, over other planes."""
    if robot == "delta":
        reach, heights = np.linspace(-0.8, 0.8, 49), np.linspace(-1.1, -0.3, 25)
        return ks.sweep(robot, platform={"x": reach, "y": 0.0, "z": heights}, progress=False)
    turn, tilt = np.radians(np.arange(-180, 180, 7.5)), np.radians(np.arange(0, 61, 4))
    platform = {"z": HEIGHT[robot], "azimuth": turn, "tilt": tilt}
    return ks.sweep(robot, platform=platform, orientation="tilt_torsion", progress=False)


def parameters(robot: str) -> dict[str, str]:
    """Return tolerances of some numbers of a robot."""
    names = {"delta": ("rod_diameter", "arm_diameter", "rod_youngs_modulus")}
    length, other, modulus = names.get(robot, ("rod_diameter", "platform_radius", "youngs_modulus"))
    return {length: "0.1mm", other: "0.2mm", modulus: "3%"}


def near(robot: str) -> list[float]:
    """Return some heights."""
    return [HEIGHT[robot] + step for step in (-0.1, 0.0, 0.1)]


def slice_of(robot: str) -> Axes:
    """Draw a slice of the workspace."""
    right, up, held = AXES[robot]
    return ks.plot.slice(body(robot), "linear_sag", x=right, y=up, at={held: HEIGHT[robot]})


def round_slice(robot: str) -> Axes:
    """Draw a round slice, or an upright one."""
    return ks.plot.slice(tilts(robot), "least_translational_stiffness", unit="N/µm")


def slices_of(robot: str) -> Axes:
    """Draw several slices side by side."""
    right, up, held = AXES[robot]
    return ks.plot.slice(body(robot), "largest_actuator_force", x=right, y=up, series={held: near(robot)})


def one_surface(robot: str) -> Axes:
    """Draw one surface."""
    right, up, held = AXES[robot]
    return ks.plot.surface(body(robot), "linear_sag", x=right, y=up, at={held: HEIGHT[robot]})


def surfaces(robot: str) -> Axes:
    """Draw several surfaces."""
    right, up, held = AXES[robot]
    return ks.plot.surface(body(robot), "twist:z", x=right, y=up, series={held: near(robot)})


def workspace(robot: str) -> Axes:
    """Draw the body of the workspace."""
    return ks.plot.workspace(body(robot), "linear_sag")


def lines(robot: str) -> Axes:
    """Draw the actuators' forces."""
    ds = body(robot)
    right, up, held = AXES[robot]
    names = [f"actuator_force:{name}" for name in ds["actuator"].values]
    return ks.plot.line(ds, names, x=right, at={up: 0.0, held: HEIGHT[robot]})


def series(robot: str) -> Axes:
    """Draw the sag at several heights."""
    right, up, held = AXES[robot]
    return ks.plot.line(body(robot), "linear_sag", x=right, series={held: near(robot)}, at={up: 0.0})


def sensitivities(robot: str) -> Axes:
    """Draw sensitivities of the sag."""
    return ks.plot.sensitivities(ks.sensitivities(ks.load_robot(robot).assemble(platform=at_height(robot)), load=LOAD))


def tolerances(robot: str) -> Axes:
    """Draw the displacements of random samples."""
    pose = ks.load_robot(robot).assemble(platform=at_height(robot))
    return ks.plot.tolerances(ks.tolerances(pose, parameters(robot), load=LOAD))


def pareto(robot: str) -> Axes:
    """Draw mass against deflection."""
    rod = {"3rps": "40mm:120mm", "delta": "10mm:30mm"}.get(robot, "40mm:90mm")
    return ks.plot.pareto(
        ks.pareto(
            robot,
            vary={"rod_diameter": rod},
            minimize=("mass", "deflection_any_direction(500 N)"),
            platform={name: [value] for name, value in at_height(robot).items()},
            points=6,
        )
    )


def calibration(robot: str) -> Axes:
    """Draw the residuals of readings of a robot with one softer part, with noise, one of them wrong."""
    ideal = ks.load_robot(robot)
    part, beam = next(iter(ideal.description.beams.items()))
    soft = ks.Robot(ideal.description.changed(part, youngs_modulus=0.8 * beam.youngs_modulus))
    here = at_height(robot)
    grid = np.array(list(product(*([value - 0.1, value, value + 0.1] for value in here.values())))).T
    platform = dict(zip(here, grid, strict=True))
    found = ks.analyze(soft.assemble(platform=platform), LOAD).twist[:, :3]
    noise = np.random.default_rng(1).normal(scale=0.01 * np.abs(found).max(), size=found.shape)
    noise[5, 2] *= 12
    rows = {**platform, "Fz": np.full(len(found), LOAD[2]), **dict(zip(("dx", "dy", "dz"), (found + noise).T, strict=True))}
    return ks.plot.calibration(ks.calibrate(ideal, rows, [part]))


KINDS: tuple[Callable[[str], Axes], ...] = (
    slice_of,
    round_slice,
    slices_of,
    one_surface,
    surfaces,
    workspace,
    lines,
    series,
    sensitivities,
    tolerances,
    pareto,
    calibration,
)


def draw(folder: Path, kinds: list[str]) -> None:
    """Draw all kinds, or some."""
    from matplotlib import pyplot as plt

    mpl.use("agg")
    folder.mkdir(parents=True, exist_ok=True)
    for kind in KINDS:
        for robot in ROBOTS if kind.__name__ in kinds or not kinds else ():
            ks.plot.save(kind(robot), folder / f"{kind.__name__}_{robot}.png", dpi=200)
            plt.close("all")


def join(folder: Path) -> None:
    """Combine the figures of each kind side by side, or wide figures one below the other."""
    DOCS.mkdir(exist_ok=True)
    for kind in KINDS:
        found = [Image.open(folder / f"{kind.__name__}_{robot}.png").convert("RGB") for robot in ROBOTS]
        wide = max(image.width / image.height for image in found) > 2
        size = 900 if wide else 400
        found = [image.resize((size, round(image.height * size / image.width)), Image.Resampling.LANCZOS) for image in found]
        high = [image.height for image in found]
        page = Image.new("RGB", (size, sum(high)) if wide else (3 * size, max(high)), "white")
        for k, image in enumerate(found):
            page.paste(image, (0, sum(high[:k])) if wide else (k * size, 0))
        page.save(DOCS / f"{kind.__name__}.webp", quality=80, method=6)


if __name__ == "__main__":
    folder, *chosen = sys.argv[1:]
    if chosen == ["--docs"]:
        join(Path(folder))
    else:
        draw(Path(folder), chosen)
