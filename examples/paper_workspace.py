"""Reproduce Figs 6, 7, 12 and 13 of the paper, and compare the maxima that its text reads from them with ours.

    python examples/paper_workspace.py                    print the table
    python examples/paper_workspace.py --figures FOLDER   draw the figures, as PNG, SVG and PDF
    python examples/paper_workspace.py --search           search for limits of the 3RPS's workspace with the paper's maxima
    python examples/paper_workspace.py --write-docs       put table and pictures into docs/

Needs pip install 'kinetostatics[plot]'.

C. Yang, F. Huang, W. Ye, Q. Chen, Gravity-Based Kinetostatic Modeling of Parallel Manipulators Using Screw Theory,
Chinese Journal of Mechanical Engineering 36 (2023).
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
import xarray as xr

import kinetostatics as ks

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "how_to" / "workspace_figures.md"

#: Maxima in the text: linear sag [µm], angular sag [°], force [N].
PAPER = {"2pru_upr": (26.0, 0.0075, 496.0), "3rps": (16.0, 0.002, 600.0)}
TITLES = {"2pru_upr": "2PRU-UPR", "3rps": "3RPS"}


@dataclass(frozen=True)
class Workspace:
    """A region of poses, and its grid.

    Attributes:
        robot: its name.
        what: in words.
        z: heights [m].
        angles: the largest tilt, or the largest of both angles [°].
        tilted: whether the angles are azimuth and tilt (a cylinder) or θ_X and θ_y (a box).
        beyond_limits: whether poses beyond the joints' limits count.
        left_out: J_3g2 W_3g2 is left out of Eq. (12), as the paper's analytical forces seem to be computed.
    """

    robot: str
    what: str
    z: tuple[float, float]
    angles: float
    tilted: bool = False
    beyond_limits: bool = False
    left_out: bool = False


WORKSPACES = (
    Workspace("2pru_upr", "limits of the text: \\|θ_X\\|, \\|θ_y\\| ≤ 10°, 0.3 ≤ z ≤ 0.6 m", (0.3, 0.6), 10),
    Workspace("2pru_upr", "the same, without J_3g2 W_3g2 in Eq. (12)", (0.3, 0.6), 10, left_out=True),
    Workspace("3rps", "tilt ≤ 45°, 0.2 ≤ z ≤ 0.875 m, only poses within the limits", (0.2, 0.875), 45, tilted=True),
    Workspace("3rps", "tilt ≤ 47°, 0.65 ≤ z ≤ 0.775 m, limits ignored", (0.65, 0.775), 47, tilted=True, beyond_limits=True),
    Workspace("3rps", "\\|rx\\|, \\|ry\\| ≤ 36°, 0.75 ≤ z ≤ 0.8 m, limits ignored", (0.75, 0.8), 36, beyond_limits=True),
    Workspace("3rps", "tilt ≤ 44°, 0.8 ≤ z ≤ 0.825 m, all within limits", (0.8, 0.825), 44, tilted=True),
    Workspace("3rps", "tilt ≤ 30°, 0.35 ≤ z ≤ 0.8 m, all within limits", (0.35, 0.8), 30, tilted=True),
)


# ---- maps ----------------------------------------------------------------------------------------------------------------


def sweep(robot: str, z: np.ndarray, angles: np.ndarray, tilted: bool = False) -> xr.Dataset:
    """Return the map of one of the robots under its own weight, in the paper's conditions; angles in degrees."""
    if tilted:
        around = np.arange(-180.0, 180.0, 5.0 if len(angles) > 10 else 15.0)
        platform = {"azimuth": np.radians(around), "tilt": np.radians(angles)}
    else:
        platform = {"rx": np.radians(angles), "ry": np.radians(angles)}
    gravity = (0, 0, 9.8 if robot == "2pru_upr" else -9.8)  # the paper's Table 3 has it along +Z
    orientation = "tilt_torsion" if tilted else "XYZ"
    path = ROOT / "robots" / f"{robot}.urdf.xacro"
    ds = ks.sweep(path, platform={"z": z, **platform}, orientation=orientation, gravity=gravity, progress=False)
    return with_rod_forces(ds) if robot == "2pru_upr" else ds


def with_rod_forces(ds: xr.Dataset) -> xr.Dataset:
    """Return the 2PRU-UPR's map with the paper's f_ia, Eq. (17): the axial force at the rod's base end.

    For a PRU limb that is not the force of its actuator, which stands on the rail. The force along the rod is the intensity of
    the first constraint wrench, and the rod's weight adds to it towards the base.
    """
    z, a, b = ds["z"], ds["rx"], ds["ry"]
    # how high A_i is above B_i: all that counts of a rod's direction
    rise = [z + 0.25 * np.sin(a), z - 0.25 * np.sin(a), z - 0.25 * np.cos(a) * np.sin(b)]
    force = []
    for k, joint in enumerate(("universal_1", "universal_2", "revolute_3")):
        tip = ds["intensity"].sel(wrench=f"limb_{k + 1}: force along limb axis at {joint}", drop=True)
        force.append(abs(tip + 7850 * 9.8 * np.pi * 0.06**2 / 4 * rise[k]))
    found = xr.concat(force, xr.Variable("rod", ["f_1a", "f_2a", "f_3a"])).transpose(*ds["status"].dims, "rod")
    found.attrs = {"units": "N", "long_name": "axial force at the rod's base end"}
    return ds.assign(rod_base_force=found)


def left_out(ds: xr.Dataset) -> tuple[xr.DataArray, xr.DataArray]:
    """Return twist and f_ia of the 2PRU-UPR as Eq. (12) gives them without J_3g2 W_3g2."""
    robot = ks.load_robot(ROOT / "robots" / "2pru_upr.urdf.xacro")
    z, a, b = np.meshgrid(*(ds[name].values for name in ("z", "rx", "ry")), indexing="ij")
    result = ks.analyze(robot.assemble(platform={"z": z, "rx": a, "ry": b}, orientation="XYZ"), gravity=(0, 0, 9.8))
    limb = result.limbs["limb_3"]
    assert limb.attached_labels[1].startswith("force along limb y")
    missing = limb.attached_wrenches[..., 1] * limb.attached_intensities[..., 1, None]
    change = np.einsum("...ij,...j->...i", result.compliance, missing)
    forces = ds["rod_base_force"].copy(deep=True)
    signed = {k: result.limbs[f"limb_{k}"].intensities[..., 0] for k in (1, 2, 3)}
    for k, limb in enumerate(result.limbs.values()):
        more = np.einsum("...ij,...kj,...k->...i", np.linalg.inv(limb.compliance), limb.constraint_wrenches, change)[..., 0]
        forces[..., k] = forces[..., k] + np.sign(signed[k + 1]) * more
    return ds["twist"] + change, forces


@cache
def map_of(robot: str, z: tuple[float, float], angles: float, tilted: bool, coarse: bool) -> xr.Dataset:
    """Return the map over a workspace. The coarse grid is part of the fine one."""
    heights, degrees = (4, 7 if tilted else 5) if coarse else (13, 25 if tilted else 21)
    start = 0.0 if tilted else -angles
    return sweep(robot, np.linspace(*z, heights), np.linspace(start, angles, degrees), tilted)


# ---- maxima --------------------------------------------------------------------------------------------------------------


def maxima(workspace: Workspace, coarse: bool = False) -> tuple[float, float, float, float]:
    """Return the largest linear sag [µm], angular sag [°], force [N], and the share of valid poses."""
    ds = map_of(workspace.robot, workspace.z, workspace.angles, workspace.tilted, coarse)
    if workspace.left_out:
        twist, force = left_out(ds)
        ds = ds.assign(twist=twist.assign_attrs(ds["twist"].attrs), rod_base_force=force)
    options = {"beyond_limits": workspace.beyond_limits}
    linear = float(ks.indices.quantity(ds, "linear_sag", **options).max())
    angular = float(ks.indices.quantity(ds, "angular_sag", **options).max())
    name = "rod_base_force" if "rod_base_force" in ds else "actuator_force"
    counts = ks.indices.valid(ds, **options)
    force = float(abs(ds[name].where(counts)).max())
    return 1e6 * linear, float(np.degrees(angular)), force, float(counts.mean())


def rows() -> Iterator[str]:
    """Yield the rows of the table."""
    robot = ""
    for workspace in WORKSPACES:
        if workspace.robot != robot:
            robot = workspace.robot
            linear, angular, force = PAPER[robot]
            limits = "stated" if robot == "2pru_upr" else "not stated"
            yield f"| **{TITLES[robot]}**, the paper (limits {limits}) | **{linear:g}** | **{angular:g}** | **{force:g}** | |"
        linear, angular, force, part = maxima(workspace)
        yield f"| {workspace.what} | {linear:.2f} | {angular:.5f} | {force:.1f} | {100 * part:.0f} % |"


def table() -> str:
    """Return the table as Markdown."""
    head = ["| workspace | linear sag [µm] | angular sag [°] | f_ia [N] | poses counted |", "|---|---:|---:|---:|---:|"]
    return "\n".join([*head, *rows()])


# ---- which limits of the 3RPS's workspace? ---------------------------------------------------------------------------


def search() -> str:
    """Return the workspaces of the 3RPS with maxima nearest to the paper's, by shape and by use of the limits."""
    lines = []
    heights = np.arange(0.2, 0.951, 0.025)
    for tilted in (True, False):
        degrees = np.arange(0.0, 50.0) if tilted else np.arange(-46.0, 47.0, 2.0)
        ds = sweep("3rps", heights, degrees, tilted)
        size = ds["tilt"] if tilted else np.maximum(abs(ds["rx"]), abs(ds["ry"]))
        largest = {
            (limits, name): ks.indices.quantity(ds, index, beyond_limits=limits == "ignored")
            for limits in ("left out", "ignored")
            for name, index in (
                ("µm", "linear_sag"),
                ("°", "angular_sag"),
                ("N", "largest_actuator_force"),
            )
        }
        for limits in ("left out", "ignored", "all within"):
            found = []
            for angle in degrees[degrees > 0]:
                inside = size <= np.radians(angle) + 1e-9
                kind = "left out" if limits == "all within" else limits
                over = [dim for dim in ds["status"].dims if dim != "z"]
                linear, angular, force = (largest[kind, name].where(inside).max(over).values for name in ("µm", "°", "N"))
                whole = (ks.indices.valid(ds) | ~inside).all(over).values
                for first in range(len(heights)):
                    for last in range(first, len(heights)):
                        part = slice(first, last + 1)
                        if limits == "all within" and not whole[part].all():
                            continue
                        numbers = 1e6 * linear[part].max(), np.degrees(angular[part].max()), force[part].max()
                        off = max(abs(numbers[0] / 16 - 1), abs(numbers[2] / 600 - 1), abs(numbers[1] / 0.002 - 1) - 0.25)
                        found.append((off, angle, heights[first], heights[last], *numbers))
            found.sort()
            for off, angle, low, high, *numbers in found[:3]:
                shape = "tilt" if tilted else "|rx|, |ry|"
                lines.append(
                    f"limits {limits:10} {shape} ≤ {angle:.0f}°, {low:.3f} ≤ z ≤ {high:.3f} m: "
                    f"{numbers[0]:.2f} µm, {numbers[1]:.5f}°, {numbers[2]:.1f} N (off by {100 * off:.0f} %)"
                )
    return "\n".join(lines)


# ---- figures -------------------------------------------------------------------------------------------------------------


def symbol(what: str) -> str:
    """Return the paper's symbol of a quantity of a map."""
    kind, _, part = what.partition(":")
    if kind == "twist":
        return rf"$\Delta_{{\mathrm{{{part if part.startswith('r') else 'd' + part}}}}}$"
    return rf"$f_{{{part[-1] if kind == 'actuator_force' else part[2]}a}}$"


@cache
def map_of_figures(steps: int = 33) -> xr.Dataset:
    """Return the map of the 3RPS for Figs 6 and 7, whose region the paper does not state."""
    return sweep("3rps", np.array([0.5, 0.65, 0.8]), np.linspace(-45, 45, steps))


def caption(number: int) -> str:
    """Return the caption of a figure, with numbers of its map."""
    if number == 13:
        ds = map_of("2pru_upr", (0.3, 0.6), 10, False, False)
        rails = max(float(abs(ds["actuator_force"].sel(actuator=f"prismatic_{k}")).max()) for k in (1, 2))
        rods = float(ds["rod_base_force"].max())
        return (
            f"*The paper's Fig 13: f_ia of the 2PRU-UPR, the axial forces at the rods' base ends, at most {rods:.1f} N. The "
            f"forces of the actuators of rods 1 and 2 differ from f_ia; they are at most {rails:.1f} N.*"
        )
    ds = map_of_figures()
    inside = ks.indices.valid(ds)
    tilt = np.degrees(np.arccos(np.clip(np.cos(ds["rx"]) * np.cos(ds["ry"]), -1, 1)))
    grid = "The grid is ours: angles up to 45°, z = 0.5, 0.65, 0.8 m, only poses within the joint limits."
    linear, angular, force = PAPER["3rps"]
    if number == 7:
        said = _reach("f_ia", ks.indices.quantity(ds, "largest_actuator_force").where(inside), tilt, force, " N", ".0f")
        return f"*Actuator forces of the 3RPS, after the paper's Fig 7. {grid} {said}*"
    said = _reach("the displacement of o", 1e6 * ks.indices.quantity(ds, "linear_sag").where(inside), tilt, linear, " µm", ".1f")
    more = _reach("the rotation", np.degrees(ks.indices.quantity(ds, "angular_sag").where(inside)), tilt, angular, "°", ".4f")
    return f"*Twist of the 3RPS over the angles of R = Rot_x Rot_y Rot_z, after the paper's Fig 6. {grid} {said} {more}*"


def _reach(what: str, values: xr.DataArray, tilt: xr.DataArray, limit: float, unit: str, form: str) -> str:
    """Return the largest value on our grid, and the tilt up to which values are below the paper's maximum, in words."""
    most, nearest = float(values.max()), float(tilt.where(values > limit).min())
    if most <= limit:
        return f"There {what} is at most {most:{form}}{unit} (paper: {limit:g}{unit})."
    return f"There {what} is at most {most:{form}}{unit}; up to a tilt of {nearest:.0f}° it is below the paper's {limit:g}{unit}."


def figures(coarse: bool = False) -> Iterator[tuple[str, object]]:
    """Yield names and figures."""
    from matplotlib import pyplot as plt

    twist = [f"twist:{component}" for component in ("x", "y", "z", "rx", "ry", "rz")]
    steps = 9 if coarse else 33
    rps = map_of_figures(steps)
    pru = sweep("2pru_upr", np.linspace(0.3, 0.6, 4), np.linspace(-10, 10, (steps + 1) // 2 + 4))
    actuators = [f"actuator_force:prismatic_{k}" for k in (1, 2, 3)]
    rods = [f"rod_base_force:f_{k}a" for k in (1, 2, 3)]
    for number, ds, quantities in ((6, rps, twist), (7, rps, actuators), (12, pru, twist), (13, pru, rods)):
        down = len(quantities) // 3
        with plt.rc_context(ks.plot.STYLE):
            figure, panels = plt.subplots(
                down, 3, figsize=(7.09, 2.6 * down + 0.4), subplot_kw={"projection": "3d"}, layout="constrained", squeeze=False
            )
        for k, (ax, what) in enumerate(zip(panels.ravel(), quantities, strict=True)):
            unit = "mdeg" if what in twist[3:] else None
            ks.plot.surface(ds, what, x="rx", y="ry", series="z", unit=unit, ax=ax, legend=k == 0)
            unit_shown = ax.get_title().rpartition("[")[2]
            ax.set_title(f"{symbol(what)} [{unit_shown}")
            if ds is pru:
                ax.set(xlabel=r"$\theta_X$ [°]", ylabel=r"$\theta_y$ [°]")
        yield f"figure_{number}", figure
    yield "slice_3rps", ks.plot.slice(rps, "linear_sag", x="rx", y="ry", at={"z": 0.65})
    tilts = sweep("3rps", np.array([0.65]), np.linspace(0, 50, 11 if coarse else 26), tilted=True)
    yield "round_3rps", ks.plot.slice(tilts, "linear_sag", x="azimuth", y="tilt", at={"z": 0.65})
    yield "lines_3rps", ks.plot.line(rps, actuators, x="rx", at={"z": 0.65, "ry": np.radians(20)})
    way = {"z": 0.5, "azimuth": np.radians(-170), "tilt": np.radians(np.linspace(0, 40, 21))}  # configuration 2 is at 10°
    ways = ks.sweep(
        "3rps", way, orientation="tilt_torsion", gravity=(0, 0, -9.8), outputs=["twist", "gravity_mechanisms"], progress=False
    )
    parts = [f"gravity_mechanism:{name}:z" for name in ("platform_weight", "attached", "deformation")]
    yield "ways_3rps", ks.plot.line(ways, [*parts, "twist:z"], x="tilt", unit="nm")
    body = sweep("3rps", np.linspace(0.2, 0.95, 8 if coarse else 31), np.linspace(-60, 60, 9 if coarse else 33))
    yield "workspace_3rps", ks.plot.workspace(body, "linear_sag", value_range=(0, 10))


def draw(folder: Path, endings: tuple[str, ...], dpi: float) -> None:
    """Draw all figures."""
    import matplotlib
    from matplotlib import pyplot as plt

    matplotlib.use("agg")
    folder.mkdir(parents=True, exist_ok=True)
    for name, figure in figures():
        for ending in endings:
            path = folder / f"{name}.{ending}"
            ks.plot.save(figure, path, dpi=dpi)
            print(f"{path}: {path.stat().st_size / 1e3:.0f} kB")
        plt.close("all")


def write_docs() -> None:
    """Put the tables between the markers of the page, and draw its pictures."""
    page = PAGE.read_text(encoding="utf-8")
    captions = [(f"figure {number}", caption(number)) for number in (6, 7, 13)]
    for name, text in (("indices", index_table()), ("maxima", table()), *captions):
        begin, end = f"<!-- {name}: begin -->", f"<!-- {name}: end -->"
        before, rest = page.split(begin)
        page = f"{before}{begin}\n\n{text}\n\n{end}{rest.split(end)[1]}"
    PAGE.write_text(page, encoding="utf-8")
    draw(ROOT / "docs" / "pictures", ("png",), 110)


def index_table() -> str:
    """Return the indices that need no argument as Markdown."""
    lines = ["| index | unit | definition |", "|---|---|---|"]
    for name, index in ks.indices.INDICES.items():
        units = {"1": "–"}.get(index.unit, index.unit.replace("N m", "N·m"))
        lines.append(f"| `{name}` | {units} | {index.definition.replace('|', chr(92) + '|')} |")
    return "\n".join(lines)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--figures", type=Path, metavar="FOLDER")
    parser.add_argument("--search", action="store_true")
    parser.add_argument("--write-docs", action="store_true")
    arguments = parser.parse_args()
    if arguments.figures:
        draw(arguments.figures, ("png", "svg", "pdf"), 300)
    elif arguments.search:
        print(search())
    elif arguments.write_docs:
        write_docs()
    else:
        print(table())
