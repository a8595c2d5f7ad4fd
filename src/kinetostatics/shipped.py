"""The robots that come with the package, and what a ROBOT on the command line may be."""

from __future__ import annotations

import os
from pathlib import Path

from kinetostatics.exceptions import ArgumentError, near_names

#: In an installed package the robots lie beside this file, in a source checkout at its top.
FOLDERS = (Path(__file__).parent / "robots", Path(__file__).parents[2] / "robots")
ENDINGS = (".urdf.xacro", ".urdf")


def shipped_robots() -> dict[str, Path]:
    """Return the files of the robots that come with the package, by name."""
    folder = next((item for item in FOLDERS if item.is_dir()), None)
    if folder is None:
        return {}
    return {path.name.removesuffix(ending): path for ending in ENDINGS for path in sorted(folder.glob(f"*{ending}"))}


def robot_path(robot: str | os.PathLike[str]) -> Path:
    """Return the file of a robot given by a path or by the name of one that comes with the package.

    Raises:
        ArgumentError: there is neither such a file nor such a name.
    """
    path, shipped = Path(robot), shipped_robots()
    if path.is_file():
        return path
    name = os.fsdecode(robot)
    if name in shipped:
        return shipped[name]
    if path.is_dir():
        raise ArgumentError(f"{name!r} is a folder, not a robot file")
    raise ArgumentError(
        f"there is no robot file {name!r}, and no robot of that name comes with the package: {near_names(name, shipped)}"
    )
