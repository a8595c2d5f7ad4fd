"""Table of the arguments that functions and commands share: kind, size, choices and help text.

An argument of a Python function and the option of the command have one name: ``closure_tolerance=`` is ``--closure-tolerance``,
except where a row names another ``option``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from kinetostatics.argument_checks import Keyword, check_choice, check_mapping, positive, whole_number


@dataclass(frozen=True)
class Argument:
    """An argument.

    Attributes:
        kind: "flag", "text", "texts", "items" (NAME=VALUE), "count" (a whole number), "number", "wrench" (three forces, three
            moments), or what a number may be: "length", "angle", "force", "mass", "acceleration".
        help: what it is.
        metavar: what help calls its value, or values.
        size: how many numbers there are; 0: one.
        choices: words that it may be.
        least: a count's smallest value.
        expected: of a positive number, what errors call it.
        example: of a mapping, what errors show.
        option: of the command line, if that is not ``--`` and the name; without dashes a positional argument.
        group: heading in the help.
    """

    kind: str
    help: str
    metavar: str | tuple[str, ...] = "TEXT"
    size: int = 0
    choices: tuple[str, ...] = ()
    least: int = 1
    expected: str = ""
    example: str = ""
    option: str = ""
    group: str = ""


XYZ = ("X", "Y", "Z")
WRENCH = ("FX", "FY", "FZ", "MX", "MY", "MZ")
#: What every command about a robot takes, and those about poses and loads.
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
        example='{"rod_diameter": 0.08}',
    ),
    "platform_link": Argument("text", "the link that is the platform, if the file does not say it, or another one", "LINK"),
    "base_link": Argument("text", "the link that stands still (default: as the file says, or the root of its tree)", "LINK"),
    # ---- pose
    "platform": Argument(
        "items",
        "coordinates of the platform, as many as its mobility: x y z of o, rx ry rz or azimuth tilt torsion",
        "NAME=VALUE",
        group="pose",
    ),
    "actuators": Argument(
        "items", "coordinates of all actuators; those in no limb, as a gripper's, may be left out", "JOINT=VALUE", group="pose"
    ),
    "near": Argument(
        "items",
        "another pose, from which the straight line to this one starts; it decides the assembly mode (default: the closed zero "
        "pose)",
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
        expected="a positive length [m] and angle [rad]",
        group="pose",
    ),
    # ---- loads
    "load": Argument("wrench", "external force [N] and moment [N·m] on the platform (default: none)", WRENCH, 6, group="load"),
    "point": Argument("length", "where the force acts (default: at o)", XYZ, 3, group="load"),
    "frame": Argument(
        "text",
        "axes of load and point; a point in the platform's frame is relative to o (default: world)",
        choices=("world", "platform"),
        group="load",
    ),
    "load_on": Argument(
        "",
        "force [N] and moment [N·m] on a link, at the point X Y Z of the link's frame (default: its origin), in the axes of the "
        "link or the world (default); may be given several times",
        ("LINK", "FX FY FZ MX MY MZ [X Y Z] [link|world]"),
        group="load",
    ),
    "payload": Argument("mass", "mass of what the robot carries [kg]", "MASS", group="load"),
    "payload_center": Argument(
        "length",
        "its centre of mass, in the platform's frame from o, or in that of its link (default: 0 0 0)",
        XYZ,
        3,
        group="load",
    ),
    "payload_link": Argument("text", "the link that carries it (default: the platform)", "LINK", group="load"),
    "gravity": Argument("acceleration", "in world axes [m/s²] (default: 0 0 -9.81)", ("GX", "GY", "GZ"), 3, group="load"),
    # ---- what is computed
    "tool": Argument(
        "length",
        "a tool's tip, from o in the platform's axes: displacements, stiffness and coordinates x y z are those of this point",
        XYZ,
        3,
    ),
    "controlled": Argument(
        "texts",
        "coordinates of the platform that the actuators correct, as many as the mobility (default: those of --platform)",
        "NAME",
    ),
    "within": Argument("number", "largest relative difference that counts as verified (default: 1e-08)", "D"),
    "hinge_axis": Argument(
        "items",
        "limbs whose first hinge is along the x axis of the limb, not y, in the table of limbs (the paper's PRU limbs)",
        "LIMB=x",
    ),
    "by": Argument(
        "texts",
        "xacro arguments of the file, or numbers of parts such as rod_1.outer_diameter; * is a wildcard (default: all arguments "
        "with an influence; of a file without, numbers of parts)",
        "NAME",
    ),
    "outputs": Argument(
        "texts", "of twist, stiffness, compliance, actuator_forces, actuators, mass (default: all of them)", "QUANTITY"
    ),
    "on_failure": Argument("text", "error or NaN where a pose has no results", choices=("raise", "nan")),
    "seed": Argument("count", "of the random numbers (default: 0)", "N", least=0),
    "json": Argument("flag", "print JSON, all numbers in SI; warnings go to standard error"),
}


def check(name: str, value: Keyword) -> Keyword:
    """Return the value of an argument of the table.

    Raises:
        ArgumentError: it is none of the choices, no such number or no mapping; the message names the argument.
    """
    argument = ARGUMENTS[name]
    if argument.choices:
        check_choice(name, value, argument.choices)
    elif argument.kind == "count":
        return whole_number(name, value, argument.least)
    elif argument.expected:
        return positive(name, value, argument.expected, infinite=True)
    elif argument.example:
        check_mapping(name, value, argument.example)
    return value
