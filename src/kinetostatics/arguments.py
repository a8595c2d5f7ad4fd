"""Checks of arguments (type, range, choice), and the table of the arguments that functions and commands share.

An argument of a function and the corresponding option of a command have the same name (``closure_tolerance=``,
``--closure-tolerance``), unless a row of the table contains another ``option``. Every error names the argument.
"""

from __future__ import annotations

import contextlib
import importlib.util
import operator
import os
import sys
import warnings
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, SupportsFloat, SupportsIndex, TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinetostatics.exceptions import ArgumentError, KinetostaticsError

#: Types that ``float`` accepts.
FloatLike: TypeAlias = SupportsFloat | SupportsIndex | str
#: Value of a keyword that another function checks.
Keyword: TypeAlias = Any

_HOME = os.path.dirname(__file__) + os.sep


def warn(words: str) -> None:
    """Issue a warning whose location is the line outside the package that called the package."""
    frame, level = sys._getframe(), 1
    while frame.f_back is not None and frame.f_code.co_filename.startswith(_HOME):
        frame, level = frame.f_back, level + 1
    warnings.warn(words, stacklevel=level)


def need(what: str, extra: str, *packages: str) -> None:
    """Check that the packages of an optional dependency are installed; ``what`` is the task that needs them.

    Raises:
        KinetostaticsError: a package is not installed.
    """
    for name in packages:
        if importlib.util.find_spec(name) is None:
            raise KinetostaticsError(f"{what} needs {name}: pip install 'kinetostatics[{extra}]'")


def check_mapping(what: str, value: object, example: str) -> None:
    """Raise an ArgumentError with the ``example`` if a value is not a mapping whose keys are strings."""
    if not isinstance(value, Mapping):
        raise ArgumentError(f"{what} is {value!r}; it must be a mapping from names to values, such as {example}")
    for name in value:
        if not isinstance(name, str):
            raise ArgumentError(f"{what} has the key {name!r}; keys are names, as in {example}")


def names_in(what: str, value: Iterable[object], example: str) -> tuple[str, ...]:
    """Return names as a tuple; raise an ArgumentError with the ``example`` if the value is not a sequence of strings."""
    try:
        given = None if isinstance(value, str) else tuple(value)
    except TypeError:
        given = None
    names = tuple(name for name in given or () if isinstance(name, str))
    if given is None or len(names) < len(given):
        raise ArgumentError(f"{what} is {value!r}; it must be a sequence of names, such as {example}")
    return names


def check_choice(what: str, value: object, choices: Sequence[str]) -> None:
    if not isinstance(value, str) or value not in choices:
        raise ArgumentError(f"{what} is {value!r}; it must be one of {', '.join(map(repr, choices))}")


def positive(what: str, value: FloatLike, expected: str = "a positive number", infinite: bool = False) -> float:
    """Return a positive number, finite unless ``infinite``; raise an ArgumentError for other values."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = np.nan
    if not number > 0 or (number == np.inf and not infinite):
        raise ArgumentError(f"{what} is {value!r}; it must be {expected}")
    return number


def whole_number(what: str, value: SupportsIndex | None, least: int, most: int | None = None, shown: str = "") -> int:
    """Return an integer from ``least`` to ``most``; raise an ArgumentError otherwise, with ``shown`` in place of the value."""
    number = None
    if value is not None and not isinstance(value, (bool, np.bool_)):
        with contextlib.suppress(TypeError):
            number = operator.index(value)
    if number is None or number < least or (most is not None and number > most):
        end = "on" if most is None else f"to {most}"
        raise ArgumentError(f"{what} is {shown or repr(value)}; it must be a whole number from {least} {end}")
    return number


def numbers(what: str, value: object) -> NDArray[np.float64]:
    """Return an array; raise an ArgumentError if it does not contain real numbers only."""
    array = None
    with contextlib.suppress(TypeError, ValueError):
        if not np.iscomplexobj(np.asarray(value)):  # NumPy would drop the imaginary part
            array = np.array(value, dtype=float)
    if array is None:
        raise ArgumentError(f"{what} is not an array of numbers: {value!r}")
    return array


def finite_numbers(what: str, value: object) -> NDArray[np.float64]:
    """Return an array; raise an ArgumentError if it does not contain finite real numbers only."""
    array = numbers(what, value)
    if not np.all(np.isfinite(array)):
        raise ArgumentError(f"{what} has entries that are not finite: {value!r}")
    return array


def path_name(what: str, value: object) -> str:
    """Return a path as a string; raise an ArgumentError for values of other types."""
    if not isinstance(value, (str, bytes, os.PathLike)):
        raise ArgumentError(f"{what} is {value!r}; it must be the path of a file")
    return os.fsdecode(value)


# ---- table of shared arguments --------------------------------------------------------------------------------------


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
        expected: description of the expected positive number, in error messages.
        example: example of a mapping, in error messages.
        option: name on the command line, default ``--`` followed by the argument's name; without dashes, it is positional.
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
        example='{"rod_diameter": 0.08}',
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
        expected="a positive length [m] and angle [rad]",
        group="pose",
    ),
    # ---- loads
    "load": Argument("wrench", "external force [N] and moment [N·m] on the platform (default: none)", WRENCH, 6, group="load"),
    "point": Argument("length", "point of application of the force (default: o)", XYZ, 3, group="load"),
    "frame": Argument(
        "text",
        "axes of load and point (default: world); with platform, the point is relative to o",
        choices=("world", "platform"),
        group="load",
    ),
    "drives": Argument(
        "text",
        "whether actuators hold their coordinates or are free, as with open brakes (default: locked)",
        choices=("locked", "free"),
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
    "modes": Argument("count", "number of modes of vibration: their natural frequencies, or an animation of them", "N", least=0),
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
    "on_failure": Argument("text", "error or NaN at a pose without results", choices=("raise", "nan")),
    "seed": Argument("count", "seed of the random numbers (default: 0)", "N", least=0),
    "json": Argument("flag", "print JSON, all numbers in SI; warnings go to standard error"),
}


def check(name: str, value: Keyword) -> Keyword:
    """Return the value of an argument after a check against its row of :data:`ARGUMENTS`; raise an ArgumentError if it fails."""
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
