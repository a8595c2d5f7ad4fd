"""Files of robots by path or by the name of a bundled robot, and folders of installed packages.

Packages of ROS, and robot descriptions installed by pip, have a marker file in the ament resource index,
``share/ament_index/resource_index/packages/NAME`` below the installation folder; their files are in ``share/NAME``. Only the
index is read: nothing is imported and no program is run.
"""

from __future__ import annotations

import contextlib
import os
import re
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path

from kinetostatics.arguments import names_in
from kinetostatics.exceptions import ArgumentError, RobotFileError, near_names
from kinetostatics.files.xml import read_file
from kinetostatics.output_files import write_text

ENDINGS = (".urdf.xacro", ".urdf")
#: Folder of xacro macros included by the robots, beside them.
LIBRARY = "library"

INDEX = Path("share", "ament_index", "resource_index", "packages")
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]*")
#: Folder of the robots and the library of xacro macros, the value of ``$(find kinetostatics)``: in an installed package it is
#: beside the folder of this file, in a source checkout at the top.
OWN_FOLDERS = (Path(__file__).parents[1] / "robots", Path(__file__).parents[3] / "robots")
OWN_NAME = "kinetostatics"
#: Packages on PyPI that may be suggested. Other names are not, because anybody may register them.
ON_PYPI = ("example-robot-data",)

#: First sentence of a file's first comment, which describes the robot.
_ABOUT = re.compile(r"<!--\s*(.+?\.)\s", re.DOTALL)


class Robots(dict[str, str]):
    """One sentence about each robot of the package, by name; printed as a table."""

    def __repr__(self) -> str:
        width = max(map(len, self), default=0)
        return "\n".join(f"{name:{width}}  {about}" for name, about in self.items())

    def _repr_html_(self) -> str:
        from kinetostatics.layout.blocks import Table
        from kinetostatics.layout.renderings import block_html

        return block_html(Table.of_rows(("name", "robot"), self.items(), "ll"))


def robots() -> Robots:
    """Return the robots of the package: one sentence about each, by name.

    A name can be used in place of a robot file: ``ks.load_robot("3rps")``. A file of this name in the working folder has
    priority.
    """
    return Robots({name: _about(path) for name, path in sorted(shipped_robots().items())})


def _about(path: Path) -> str:
    sentence = _ABOUT.search(path.read_text(encoding="utf-8"))
    return " ".join(sentence[1].split()) if sentence else ""


def shipped_robots() -> dict[str, Path]:
    folder = next((folder for folder in OWN_FOLDERS if folder.is_dir()), None)
    if folder is None:
        return {}
    return {path.name.removesuffix(ending): path for ending in ENDINGS for path in sorted(folder.glob(f"*{ending}"))}


def copy_robots(names: Iterable[str], folder: str | os.PathLike[str] = ".") -> list[Path]:
    """Copy files of robots of the package, and the library of xacro macros that they include; return the paths of the copies.

    The library is copied to the subfolder ``library`` of ``folder``; an equal file that exists there is kept.

    Raises:
        ArgumentError: a robot is unknown, or a file exists already; nothing is copied then.
    """
    sources = [_shipped(name) for name in dict.fromkeys(names_in("names", names, '["3rps"]'))]
    copies = {Path(folder) / source.name: source for source in sources}
    for source in sources:
        if f'"{LIBRARY}/' in source.read_text(encoding="utf-8"):
            copies |= {Path(folder) / LIBRARY / part.name: part for part in sorted((source.parent / LIBRARY).glob("*.xacro"))}
    for copy, source in list(copies.items()):
        if copy.parent.name == LIBRARY and copy.is_file() and copy.read_bytes() == source.read_bytes():
            del copies[copy]
        elif os.path.lexists(copy):
            raise ArgumentError(f"{os.fspath(copy)} is there already, and is not overwritten")
    for copy, source in copies.items():
        with contextlib.suppress(OSError):  # told by the next line
            copy.parent.mkdir(exist_ok=True)
        write_text(copy, source.read_text(encoding="utf-8"), new=True)
    return list(copies)


def _shipped(name: str) -> Path:
    shipped = shipped_robots()
    if name not in shipped:
        raise ArgumentError(f"no robot {name!r} comes with the package: {near_names(name, shipped)}")
    return shipped[name]


def shown_path(path: str) -> str:
    """Return a path for messages: the file name of a bundled robot, or the path relative to the working folder if below it."""
    if not os.path.isabs(path):
        return path
    if any(os.path.dirname(path) == os.fspath(folder) for folder in OWN_FOLDERS):
        return os.path.basename(path)
    try:
        from_here = os.path.relpath(path)
    except (ValueError, OSError):  # another drive, or no working folder
        return path
    return path if from_here.startswith(os.pardir) else from_here


def robot_path(robot: str | os.PathLike[str]) -> Path:
    """Return the file of a robot, given by the path or by the name of a robot of the package.

    Raises:
        RobotFileError: there is neither a file nor a robot of this name.
        ArgumentError: the value is neither a path nor a name.
    """
    _, path = read_robot(robot)
    return Path(path)


def read_robot(robot: str | os.PathLike[str]) -> tuple[bytes, str]:
    """Return the content and the path of a robot's file, given by the path or by the name of a robot of the package.

    Raises:
        RobotFileError: the file cannot be read.
        ArgumentError: the value is neither a path nor a name.
    """
    if not isinstance(robot, (str, bytes, os.PathLike)):
        raise ArgumentError(f"{robot!r} is neither the path of a robot's file nor the name of a robot of the package")
    name = os.fsdecode(robot)
    try:
        given = Path(name)
        path = given if given.is_file() else shipped_robots().get(name, given)
        return read_file(path), name if path == given else os.fspath(path)
    except FileNotFoundError as error:
        raise RobotFileError(f"the file cannot be read: {error.strerror}{_similar_names(name)}", name) from None
    except OSError as error:
        raise RobotFileError(f"the file cannot be read: {error.strerror or error}", name) from None
    except ValueError as error:  # a path with a null character
        raise RobotFileError(f"the file cannot be read: {error}", name) from None


def _similar_names(name: str) -> str:
    """Return a text with similar names of bundled robots; empty if ``name`` is a path with none."""
    near = near_names(re.sub(r"(\.urdf)?(\.xacro)?$", "", os.path.basename(name)), shipped_robots())
    if near.startswith("known") and (os.path.dirname(name) or "." in name):
        return ""
    return f", and no robot of that name comes with the package: {near}"


# ---- installed packages ---------------------------------------------------------------------------------------------------


class PackageNotFound(LookupError):
    """A package is not installed; the message gives the command that installs it, if known."""


def package_folder(name: str) -> Path:
    """Return the folder with the files of an installed package.

    ``kinetostatics`` names the folder of the robots and xacro macros of this package. Other packages are searched, in this order,
    in ROS's workspaces (``AMENT_PREFIX_PATH``), beside the packages that pip installed (``cmeel.prefix``, where Pinocchio and its
    robots are), and in Python's own prefix.

    Raises:
        PackageNotFound: the package is not installed, or the name is invalid.
    """
    if not NAME.fullmatch(name):
        raise PackageNotFound(f"{name!r} is not the name of a package: write letters, digits, - and _, as in $(find my_robots)")
    if name == OWN_NAME:
        robots_folder = next((folder for folder in OWN_FOLDERS if folder.is_dir()), None)
        if robots_folder is not None:
            return robots_folder
    installed = {OWN_NAME}
    for prefix in _prefixes():
        if (prefix / INDEX / name).is_file() and (prefix / "share" / name).is_dir():
            return prefix / "share" / name
        if (prefix / INDEX).is_dir():
            installed.update(os.listdir(prefix / INDEX))
    if name in ON_PYPI:
        raise PackageNotFound(f"the package {name!r} is not installed: pip install {name}")
    raise PackageNotFound(
        f"$(find {name}) finds no such package, neither in ROS (is its workspace sourced?) nor in Python's folders; write a path "
        f"relative to this file instead; {near_names(name, installed)}"
    )


def _prefixes() -> Iterator[Path]:
    for text in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep):
        if text:
            yield Path(text)
    for text in sys.path:
        if text:
            yield Path(text) / "cmeel.prefix"
    yield Path(sys.prefix)
