"""Makes robots with castings, plates and bearings: ``python examples/robots_of_castings.py [FOLDER]``.

Needs ``pip install 'kinetostatics[cad]'``. The parts are drawn with Netgen's OpenCASCADE, written as STEP files, condensed to
their interfaces, and put in place of rigid links and of tubes of robots of the package:

- ``3rps_plate``: a plate of steel as platform, and a frame of cast iron as base,
- ``delta_bearings``: tapered carbon arms, cast crossbars at the elbows, and pairs of ball bearings at the motors,
- ``five_bar_castings``: four arms of cast aluminium.

Robots and matrices are in ``examples/castings``. All lengths of shapes are in millimetres.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

import kinetostatics as ks
from kinetostatics.description import Flexible, JointStiffness, Material, RobotDescription
from kinetostatics.sections import Station, Tapered, Tube

if TYPE_CHECKING:
    from netgen.occ import TopoDS_Shape

FOLDER = Path(__file__).parent / "castings"
#: Grey cast iron, EN-GJL-250: middle of the range of its modulus.
IRON = Material(youngs_modulus=110e9, poisson_ratio=0.26, density=7200.0)
AZIMUTHS = {1: 0.0, 2: -120.0, 3: 120.0}
#: Bearings of a motor's shaft: place along it [m], radial and axial stiffness [N/m]. The second one can slide.
BEARINGS = ((-0.02, 9e7, 4e7), (0.03, 7e7, 0.0))


# ---- parts -----------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Part:
    """A part: its shape [mm], its interfaces, and its material."""

    shape: Callable[[], TopoDS_Shape]
    interfaces: dict[str, str]
    material: str | Material


def plate() -> TopoDS_Shape:
    """Return a plate of 16 mm with three lobes, each with the bore of a ball joint, and a ring for the tool."""
    from netgen.occ import Axis, Box, Cylinder, Pnt, Z

    shape = Cylinder(Pnt(0, 0, 0), Z, r=110, h=16) + Cylinder(Pnt(0, 0, -6), Z, r=70, h=28)
    axis = Axis(Pnt(0, 0, 0), Z)
    for azimuth in AZIMUTHS.values():
        lobe = Box(Pnt(40, -35, 0), Pnt(200, 35, 16)) + Cylinder(Pnt(200, 0, -12), Z, r=35, h=28)
        shape += lobe.Rotate(axis, azimuth)
    for azimuth in AZIMUTHS.values():
        shape -= (Cylinder(Pnt(200, 0, -20), Z, r=15, h=50) + Cylinder(Pnt(118, 0, -20), Z, r=20, h=50)).Rotate(axis, azimuth)
    return shape - Cylinder(Pnt(0, 0, -20), Z, r=50, h=60)


def frame() -> TopoDS_Shape:
    """Return a star of three beams on a foot, each with a pedestal that holds the bearing of a limb."""
    from netgen.occ import Axis, Box, Cylinder, Pnt, Y, Z

    shape, axis = Cylinder(Pnt(0, 0, -170), Z, r=110, h=90), Axis(Pnt(0, 0, 0), Z)
    for azimuth in AZIMUTHS.values():
        beam = Box(Pnt(0, -35, -150), Pnt(335, 35, -95)) + Box(Pnt(265, -35, -110), Pnt(335, 35, 0))
        beam = beam + Cylinder(Pnt(300, -35, 0), Y, r=35, h=70) - Cylinder(Pnt(300, -50, 0), Y, r=20, h=100)
        shape += beam.Rotate(axis, azimuth)
    return shape - Cylinder(Pnt(0, 0, -150), Z, r=70, h=100)


def crossbar() -> TopoDS_Shape:
    """Return a socket for the end of an arm, with a bar across that ends in the balls of two joints."""
    from netgen.occ import Cylinder, Pnt, Sphere, X, Y

    bar = Cylinder(Pnt(0, -44, 0), Y, r=7, h=88) + Sphere(Pnt(0, -50, 0), 9) + Sphere(Pnt(0, 50, 0), 9)
    return Cylinder(Pnt(-30, 0, 0), X, r=21, h=44) + bar - Cylinder(Pnt(-40, 0, 0), X, r=17, h=36)


def arm(
    web: tuple[float, float], near: tuple[float, float], far: tuple[float, float], bores: tuple[float, float]
) -> TopoDS_Shape:
    """Return an arm of 230 mm along x, a tapered web with windows between two bosses.

    Args:
        web, near, far: least and greatest z of the web and of the bosses at x = 0 and x = 230 mm.
        bores: diameters of the bosses' bores.
    """
    from netgen.occ import Axes, Cylinder, Pnt, WorkPlane, Z

    outline = WorkPlane(Axes(Pnt(0, 0, web[0]), Z)).MoveTo(0, -20).LineTo(230, -14).LineTo(230, 14).LineTo(0, 20).Close()
    shape = outline.Face().Extrude(web[1] - web[0])
    for x, radius in ((60, 11), (95, 10), (127, 9), (157, 8)):
        shape -= Cylinder(Pnt(x, 0, web[0] - 1), Z, r=radius, h=web[1] - web[0] + 2)
    for x, (low, high), radius in ((0, near, 22), (230, far, 18)):
        shape += Cylinder(Pnt(x, 0, low), Z, r=radius, h=high - low)
    for x, (low, high), bore in ((0, near, bores[0]), (230, far, bores[1])):
        shape -= Cylinder(Pnt(x, 0, low - 1), Z, r=bore / 2, h=high - low + 2)
    return shape


BORES_OF_PLATE = {"spherical_1": (200, 0), "spherical_2": (-100, -173.205), "spherical_3": (-100, 173.205)}
BORES_OF_FRAME = {"revolute_1": (300, 0), "revolute_2": (-150, -259.808), "revolute_3": (-150, 259.808)}
PARTS = {
    "plate": Part(
        plate,
        {"o": "cylinder d=100mm near 0 0 0"}
        | {name: f"cylinder d=30mm near {x}mm {y}mm 0" for name, (x, y) in BORES_OF_PLATE.items()},
        "steel",
    ),
    "frame": Part(
        frame,
        {"o": "face near 0 0 -170mm"} | {name: f"cylinder d=40mm near {x}mm {y}mm 0" for name, (x, y) in BORES_OF_FRAME.items()},
        IRON,
    ),
    "crossbar": Part(
        crossbar,
        {"weld": "cylinder d=34mm near -20mm 0 0", "a": "sphere r=9.5mm at 0 50mm 0", "b": "sphere r=9.5mm at 0 -50mm 0"},
        "aluminium",
    ),
    "proximal": Part(
        lambda: arm((-22, -8), (-30, 0), (-24, -2), (24, 16)),
        {"shoulder": "cylinder d=24mm near 0 0 0", "elbow": "cylinder d=16mm near 230mm 0 0"},
        "aluminium",
    ),
    "distal_1": Part(
        lambda: arm((2, 14), (2, 24), (2, 14), (16, 12)),
        {"elbow_1": "cylinder d=16mm near 0 0 0", "clamp": "cylinder d=12mm near 230mm 0 0"},
        "aluminium",
    ),
    "distal_2": Part(
        lambda: arm((16, 28), (2, 28), (16, 28), (16, 12)),
        {"elbow_2": "cylinder d=16mm near 0 0 0", "wrist": "cylinder d=12mm near 230mm 0 0"},
        "aluminium",
    ),
}


def condensed(name: str, folder: Path) -> ks.CondensedLink:
    """Return a part condensed to its interfaces, with three modes; its STEP file is written to the folder."""
    part, path = PARTS[name], folder / f"{name}.step"
    part.shape().WriteStep(str(path))
    result = ks.condense(path, part.interfaces, part.material, within=0.03, modes=3)
    print(f"{name}: {result}")
    return result


# ---- robots ----------------------------------------------------------------------------------------------------------------


def with_part(description: RobotDescription, link: str, part: ks.CondensedLink, **joints: str) -> RobotDescription:
    """Return the robot with a part in place of a rigid link or beam; ``joints`` are those of interfaces with other names."""
    names = tuple(joints.get(name, name) for name in part.link.names)
    flexible = {**description.flexible, link: Flexible(link, replace(part.link, names=names))}
    bare = replace(
        description.links[link],
        mass=0.0,
        has_inertial=False,
        extra="",
        center_of_mass=(0, 0, 0),
        inertia=ks.description.Inertia(),
    )
    beams = {name: beam for name, beam in description.beams.items() if beam.link != link}
    return replace(description, links={**description.links, link: bare}, beams=beams, flexible=flexible)


def three_rps(parts: Callable[[str], ks.CondensedLink]) -> RobotDescription:
    """Return the 3RPS with a plate as platform, o in its ring, and a frame as base, o in its foot."""
    description = ks.load_robot("3rps").description
    return with_part(with_part(description, "base", parts("frame")), "platform", parts("plate"))


def bearing_matrix() -> tuple[float, ...]:
    """Return the stiffness of :data:`BEARINGS` in the frame of a motor's joint, whose axis is y; the motor holds its rotation."""
    K = np.zeros((6, 6))
    for y, radial, axial in BEARINGS:
        moved = np.hstack(
            [np.eye(3), [[0, 0, -y], [0, 0, 0], [y, 0, 0]]]
        )  # displacement at (0, y, 0) due to a twist at the origin
        K += moved.T @ np.diag([radial, axial, radial]) @ moved
    K[4, 4] = np.inf
    return tuple(K.ravel().tolist())


def delta(parts: Callable[[str], ks.CondensedLink]) -> RobotDescription:
    """Return the Delta with tapered arms, cast crossbars and bearings."""
    description = ks.load_robot("delta").description
    taper = Tapered.of([Station(0.0, Tube.of(0.058, 0.052)), Station(1.0, Tube.of(0.034, 0.028))])
    for i in (1, 2, 3):
        crossing = {"weld": f"weld_{i}", "a": f"upper_{i}a_y", "b": f"upper_{i}b_y"}
        description = with_part(description, f"elbow_{i}", parts("crossbar"), **crossing)
        description = description.changed(f"arm_{i}", section=taper)
        description = description.with_part(JointStiffness(f"motor_{i}", matrix=bearing_matrix()))
    return description


def five_bar(parts: Callable[[str], ks.CondensedLink]) -> RobotDescription:
    """Return the five-bar with cast arms."""
    description = ks.load_robot("five_bar").description
    for i in (1, 2):
        description = with_part(description, f"proximal_{i}", parts("proximal"), shoulder=f"shoulder_{i}", elbow=f"elbow_{i}")
        description = with_part(description, f"distal_{i}", parts(f"distal_{i}"))
    return description


ROBOTS = {"3rps_plate": three_rps, "delta_bearings": delta, "five_bar_castings": five_bar}


def rigid(description: RobotDescription) -> RobotDescription:
    """Return a robot whose parts from CAD are rigid bodies of the same mass."""
    links = dict(description.links)
    for part in description.flexible.values():
        mass, centre, inertia = part.matrices.body
        moments = tuple(inertia[np.triu_indices(3)].tolist())
        inertia_of = ks.description.Inertia(moments)
        links[part.link] = replace(
            links[part.link], mass=mass, center_of_mass=tuple(centre.tolist()), inertia=inertia_of, has_inertial=True
        )
    return replace(description, links=links, flexible={})


def main(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as steps:
        made: dict[str, ks.CondensedLink] = {}

        def parts(name: str) -> ks.CondensedLink:
            if name not in made:
                made[name] = condensed(name, Path(steps))
            return made[name]

        for name, robot in ROBOTS.items():
            ks.save_robot(replace(robot(parts), name=name), folder / f"{name}.urdf")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else FOLDER)
