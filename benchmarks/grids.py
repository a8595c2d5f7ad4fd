"""Grids in the workspaces of the robots that come with the package, as ``docs/gallery/robots`` and the tests name them."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import kinetostatics as ks

Array = NDArray[np.float64]

ROBOTS = Path(__file__).resolve().parent.parent / "robots"
#: At o, so that no contribution to the twist is zero [N, N·m].
LOAD = (30.0, -20.0, -100.0, 1.0, 2.0, -3.0)


@dataclass(frozen=True)
class Workspace:
    """A box of coordinates, of the platform or of the actuators, and what its angles mean."""

    box: Mapping[str, tuple[float, float]]
    orientation: str | None = None
    kind: str = "platform"

    def axes(self, poses: int) -> dict[str, Array]:
        """Return axes of a grid of at least so many poses, about equally many values along each."""
        counts: list[int] = []
        for left in range(len(self.box), 0, -1):
            done = int(np.prod(counts))
            counts.append(max(2, int(np.ceil((poses / done) ** (1 / left) - 1e-9))))
        return {name: np.linspace(*ends, count) for (name, ends), count in zip(self.box.items(), sorted(counts), strict=True)}

    def within(self, **changed: tuple[float, float]) -> Workspace:
        """Return the workspace with other ends of some coordinates."""
        return Workspace({**self.box, **changed}, self.orientation, self.kind)


def _degrees(low: float, high: float) -> tuple[float, float]:
    return float(np.radians(low)), float(np.radians(high))


def _square(radius: float) -> dict[str, tuple[float, float]]:
    """Return the square inside a disc."""
    half = radius / np.sqrt(2)
    return {"x": (-half, half), "y": (-half, half)}


def _cube(low: float, high: float) -> dict[str, tuple[float, float]]:
    return dict.fromkeys("xyz", (low, high))


#: reaches of the Orthoglide's cube of 200 mm
_LEG = 0.2 / (1 / np.sqrt(6) + 1 / np.sqrt(18))

WORKSPACES: dict[str, Workspace] = {
    "3rps": Workspace({"z": (0.35, 0.7), "rx": (-0.2, 0.2), "ry": (-0.2, 0.2)}, "XYZ"),
    "2pru_upr": Workspace({"z": (0.3, 0.6), "rx": (-0.17, 0.17), "ry": (-0.17, 0.17)}, "XYZ"),
    "gough_stewart": Workspace(
        {
            "x": (-0.005, 0.005), "y": (-0.005, 0.005), "z": (0.24, 0.248),
            "rx": (-0.01, 0.01), "ry": (-0.01, 0.01), "rz": (-0.015, 0.015),
        }
    ),
    "6rus": Workspace(
        {
            "x": (-0.05, 0.05), "y": (-0.05, 0.05), "z": (0.61, 0.69),
            "rx": (-0.08, 0.08), "ry": (-0.08, 0.08), "rz": (-0.1, 0.1),
        }
    ),
    "3prs": Workspace({"z": (0.45, 0.63), "azimuth": (-3.1, 3.1), "tilt": _degrees(1, 40)}, "tilt_torsion"),
    "tricept": Workspace({"x": (-0.3, 0.3), "y": (-0.3, 0.3), "z": (-1.1, -0.8)}),
    "exechon": Workspace({"z": (0.27, 0.32), "rx": (-0.2, 0.2), "ry": (-0.2, 0.3)}, "YXZ"),
    "five_bar": Workspace({"x": (-0.08, 0.08), "y": (0.25, 0.37)}),
    "planar_3rrr": Workspace({**_square(0.2), "rz": _degrees(-15, 15)}),
    "spherical_3rrr": Workspace(
        {"azimuth": _degrees(-180, 170), "tilt": _degrees(1, 60), "torsion": _degrees(-40, 40)}, "tilt_torsion"
    ),
    "tripteron": Workspace(_cube(-0.15, 0.15)),
    "linear_delta": Workspace({**_square(0.127), "z": (0.0, 0.277)}),
    "delta": Workspace({**_square(0.565), "z": (-0.8, -0.55)}),
    "orthoglide": Workspace(_cube(-_LEG / np.sqrt(6), _LEG / np.sqrt(18))),
    "ur10": Workspace(
        {
            "shoulder_pan_joint": (-1.0, 1.0), "shoulder_lift_joint": (-2.0, 0.0), "elbow_joint": (0.5, 2.0),
            "wrist_1_joint": (-1.0, 1.0), "wrist_2_joint": (-1.0, 1.0), "wrist_3_joint": (-1.0, 1.0),
        },
        kind="actuators",
    ),
    "anymal_standing": Workspace(
        {
            "x": (-0.04, 0.04), "y": (-0.03, 0.03), "z": (0.45, 0.485),
            "rx": (-0.06, 0.06), "ry": (-0.08, 0.08), "rz": (-0.1, 0.1),
        }
    ),
}  # fmt: skip


def load(name: str) -> ks.Robot:
    """Return a robot."""
    return ks.load_robot(ROBOTS / f"{name}.urdf.xacro")


def mesh(axes: Mapping[str, Array]) -> dict[str, Array]:
    """Return the coordinates of all poses of a grid, the last coordinate fastest."""
    values = np.meshgrid(*axes.values(), indexing="ij")
    return dict(zip(axes, values, strict=True))


def assemble(robot: ks.Robot, workspace: Workspace, coordinates: Mapping[str, Array]) -> ks.Configuration:
    """Close the loops at coordinates."""
    given: dict[str, Any] = {workspace.kind: coordinates}
    if workspace.kind == "platform":
        given["orientation"] = workspace.orientation
    return robot.assemble(**given, on_failure="nan")


def map_numbers(result: ks.Result) -> None:
    """Have everything computed that a workspace map holds."""
    result.status, result.twist, result.contributions, result.stiffness, result.compliance, result.actuator_forces
    for limb in result.limbs.values():
        limb.intensities, limb.attached_intensities


def whole(robot: ks.Robot, workspace: Workspace, coordinates: Mapping[str, Array]) -> ks.Result:
    """Close the loops at coordinates and compute all numbers of a map."""
    result = ks.analyze(assemble(robot, workspace, coordinates), LOAD)
    map_numbers(result)
    return result


def sweep(name: str | ks.Robot, workspace: Workspace, axes: Mapping[str, Array], **options: Any) -> Any:
    """Return the map of a grid; that some neighbours are in different assembly modes is of no interest here."""
    if isinstance(name, str):
        name = str(ROBOTS / f"{name}.urdf.xacro")
    options = {"workers": 1, **options}
    if workspace.kind == "platform":
        options["orientation"] = workspace.orientation
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message=".*different assembly modes.*")
        return ks.sweep(name, **{workspace.kind: axes}, load=LOAD, progress=False, **options)
