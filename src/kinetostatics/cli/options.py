"""Table of the arguments that commands share, with their kinds and the texts of the help.

An option of a command and the corresponding argument of a function have the same name (``--closure-tolerance``,
``closure_tolerance=``), unless a row of the table contains another ``option``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from kinetostatics.arguments import CHOICES, LEAST


@dataclass(frozen=True)
class Argument:
    """An argument shared by functions and commands.

    Attributes:
        kind: "flag", "text", "texts", "items" (NAME=VALUE), "count" (a whole number), "number", "wrench" (three forces, three
            moments), or the kind of a number: "length", "angle", "force", "mass", "acceleration".
        help: description in the help of the command.
        metavar: placeholder of the value in the help; for several values, one for each.
        size: how many numbers the value has; 0: it is a single number.
        choices: accepted words.
        least: smallest value of a count.
        option: name on the command line, default ``--`` followed by the argument's name; without dashes, it is positional.
        group: heading in the help.
    """

    kind: str
    help: str
    metavar: str | tuple[str, ...] = "TEXT"
    size: int = 0
    choices: tuple[str, ...] = ()
    least: int = 1
    option: str = ""
    group: str = ""


XYZ = ("X", "Y", "Z")
WRENCH = ("FX", "FY", "FZ", "MX", "MY", "MZ")
#: Arguments of all commands on robots, of those on poses, and of those on loads.
ROBOT = ("robot", "parameters", "platform_link", "base_link")
POSE = ("platform", "actuators", "near", "orientation", "closure_tolerance")
LOADS = ("load", "point", "frame", "load_on", "payload", "payload_center", "payload_link", "gravity")

ARGUMENTS: Mapping[str, Argument] = {
    # ---- robot
    "robot": Argument(
        "text", "a URDF or xacro file, or the name of a robot of the package: 3rps, 2pru_upr", "ROBOT", option="robot"
    ),
    "parameters": Argument(
        "items",
        "values of the file's xacro arguments, such as rod_diameter=80mm",
        "NAME=VALUE",
        option="--set",
    ),
    "platform_link": Argument("text", "link that is the platform (default: as in the file)", "LINK"),
    "base_link": Argument("text", "link that is fixed to the ground (default: as in the file, or the root of its tree)", "LINK"),
    # ---- pose
    "platform": Argument(
        "items",
        "coordinates of the platform, as many as its mobility: x y z of o, rx ry rz or azimuth tilt torsion",
        "NAME=VALUE",
        group="pose",
    ),
    "actuators": Argument(
        "items",
        "coordinates of all actuators; those outside the limbs, as of a gripper, may be omitted",
        "JOINT=VALUE",
        group="pose",
    ),
    "near": Argument(
        "items",
        "start of the straight line to the pose, which decides the assembly mode (default: the closed zero pose): coordinates, "
        "or values of joints, passive ones too, for the closed pose nearest to them",
        "NAME=VALUE",
        group="pose",
    ),
    "orientation": Argument(
        "text",
        "meaning of rx ry rz: rotation_vector (default), angles about moving axes (XYZ) or fixed axes (xyz), in any order of "
        "three letters; or tilt_torsion for azimuth tilt torsion",
        "NAME",
        group="pose",
    ),
    "closure_tolerance": Argument(
        "length",
        "largest gap of a closed loop, m and rad (default: 1e-10)",
        "T",
        group="pose",
    ),
    # ---- loads
    "load": Argument("wrench", "external force [N] and moment [N·m] on the platform (default: none)", WRENCH, 6, group="load"),
    "point": Argument("length", "point of application of the force (default: o)", XYZ, 3, group="load"),
    "frame": Argument(
        "text",
        "axes of load and point (default: world); with platform, the point is relative to o",
        choices=CHOICES["frame"],
        group="load",
    ),
    "drives": Argument(
        "text",
        "whether actuators hold their coordinates or are free, as with open brakes (default: locked)",
        choices=CHOICES["drives"],
    ),
    "load_on": Argument(
        "",
        "force [N] and moment [N·m] on a link, at the point X Y Z of the link's frame (default: its origin), in the axes of the "
        "link or the world (default); may be given several times",
        ("LINK", "FX FY FZ MX MY MZ [X Y Z] [link|world]"),
        group="load",
    ),
    "payload": Argument("mass", "mass of the payload [kg]", "MASS", group="load"),
    "payload_center": Argument(
        "length",
        "centre of mass of the payload, in the frame of the link that carries it (default: 0 0 0)",
        XYZ,
        3,
        group="load",
    ),
    "payload_link": Argument("text", "link that carries the payload (default: the platform)", "LINK", group="load"),
    "gravity": Argument("acceleration", "gravity in world axes [m/s²] (default: 0 0 -9.81)", ("GX", "GY", "GZ"), 3, group="load"),
    # ---- what is computed
    "tool": Argument(
        "length",
        "tool point, from o in platform axes: displacements, stiffness and coordinates x y z refer to this point",
        XYZ,
        3,
    ),
    "controlled": Argument(
        "texts",
        "coordinates of the platform that the actuators correct, as many as the mobility (default: those of --platform)",
        "NAME",
    ),
    "within": Argument("number", "largest relative difference that counts as verified (default: 1e-08)", "D"),
    "modes": Argument(
        "count", "number of modes of vibration: their natural frequencies, or an animation of them", "N", least=LEAST["modes"]
    ),
    "hinge_axis": Argument(
        "items",
        "limbs whose frame has its x axis, not its y axis, along the first hinge (the paper's PRU limbs)",
        "LIMB=x",
    ),
    "by": Argument(
        "texts",
        "xacro arguments of the file, or dimensions of parts such as rod_1.outer_diameter; * is a wildcard (default: all "
        "arguments with an influence; if the file has none, dimensions of parts)",
        "NAME",
    ),
    "outputs": Argument(
        "texts", "twist, stiffness, compliance, actuator_forces, actuators, mass (default: all of them)", "QUANTITY"
    ),
    "on_failure": Argument("text", "error or NaN at a pose without results", choices=CHOICES["on_failure"]),
    "seed": Argument("count", "seed of the random numbers (default: 0)", "N", least=LEAST["seed"]),
    "json": Argument("flag", "print JSON, all numbers in SI; warnings go to standard error"),
}
