"""Where installed packages keep their robots: what ``$(find NAME)`` in a xacro means.

ROS's packages, and robot descriptions that pip installs, leave a marker in an index: a file
``share/ament_index/resource_index/packages/NAME`` below the folder that they are installed into (ROS's own documentation
calls it the ament resource index). Their files are then in ``share/NAME`` beside it. Only this is looked up: nothing is
imported and no program is run.
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterator
from pathlib import Path

from kinetostatics.exceptions import near_names

INDEX = Path("share", "ament_index", "resource_index", "packages")
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]*")
#: Where the robots of this package are, and the library of xacro macros: in an installed package beside the folder of this file,
#: in a source checkout at its top. It is what ``$(find kinetostatics)`` means.
OWN_FOLDERS = (Path(__file__).parents[1] / "robots", Path(__file__).parents[3] / "robots")
OWN_NAME = "kinetostatics"
#: What to install for a package that is known to come from PyPI. Other names are not suggested: anybody may register one.
ON_PYPI = {"example-robot-data": "example-robot-data"}


class PackageNotFound(LookupError):
    """There is no such package; the message says what to do."""


def package_folder(name: str) -> Path:
    """Return the folder with the files of an installed package.

    ``kinetostatics`` is the folder of the robots that come with this package, with its library of xacro macros. Others are
    looked for, in this order, in ROS's workspaces (``AMENT_PREFIX_PATH``), beside the packages that pip installed
    (``cmeel.prefix``, where Pinocchio and its robots are), and in Python's own prefix.

    Raises:
        PackageNotFound: there is none, or the name is not one.
    """
    if not NAME.fullmatch(name):
        raise PackageNotFound(f"{name!r} is not the name of a package: write letters, digits, - and _, as in $(find my_robots)")
    if name == OWN_NAME:
        own = next((folder for folder in OWN_FOLDERS if folder.is_dir()), None)
        if own is not None:
            return own
    known = {OWN_NAME}
    for prefix in _prefixes():
        if (prefix / INDEX / name).is_file() and (prefix / "share" / name).is_dir():
            return prefix / "share" / name
        if (prefix / INDEX).is_dir():
            known.update(os.listdir(prefix / INDEX))
    if name in ON_PYPI:
        raise PackageNotFound(f"the package {name!r} is not installed: pip install {ON_PYPI[name]}")
    raise PackageNotFound(
        f"$(find {name}) finds no such package, neither in ROS (is its workspace sourced?) nor beside this one; name files "
        f"relative to this one instead; {near_names(name, known)}"
    )


def _prefixes() -> Iterator[Path]:
    for text in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep):
        if text:
            yield Path(text)
    for text in sys.path:
        if text:
            yield Path(text) / "cmeel.prefix"
    yield Path(sys.prefix)
