"""Writing of files: robots, read again with exactly equal numbers, and CSV tables of results."""

from __future__ import annotations

import csv
import io
import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Protocol

import numpy as np

from kinetostatics.arguments import path_name
from kinetostatics.description.robot_description import RobotDescription
from kinetostatics.exceptions import ArgumentError
from kinetostatics.files.reader import validate
from kinetostatics.files.robot_element import robot_text
from kinetostatics.math.arrays import Array

_COMMENT = "written by kinetostatics; the elements that are not URDF's are those of its docs/reference/robot_format.md"
#: Attributes with names of files, relative to the robot file.
_FILE = re.compile(r'(<(?:mesh|texture)\b[^<>]*\bfilename=")([^"]+)(")')


class Described(Protocol):
    """An object with a description: a robot."""

    @property
    def description(self) -> RobotDescription:
        """Its description."""


def save_robot(robot: Described | RobotDescription, path: str | os.PathLike[str]) -> None:
    """Write a robot to a plain URDF file, from which the robot is read with exactly equal numbers.

    Elements that the package does not use are written too: visuals and collisions, inertias, materials, dynamics, transmissions.
    Comments, xacro macros and unknown attributes are not. Relative names of meshes are adapted to the new file.

    Args:
        robot: the robot, or its description.
        path: path of the new file; an existing file is replaced.

    Raises:
        RobotFileError: the description is invalid.
        ArgumentError: the file cannot be written, or is a xacro whose macros would be lost.
    """
    description = validate(robot.description if hasattr(robot, "description") else robot)
    name = path_name("path", path)
    text = robot_text(_beside(description, os.path.dirname(os.path.abspath(name))), _COMMENT)
    if _uses_xacro(name):
        raise ArgumentError(f"{name} uses xacro, and its macros would be lost; write to another file")
    write_text(name, text)


def write_text(path: str | os.PathLike[str], text: str) -> None:
    """Write a file; an existing file is replaced.

    Raises:
        ArgumentError: the file cannot be written.
    """
    name = path_name("path", path)
    try:
        with open(name, "w", encoding="utf-8", newline="\n") as file:
            file.write(text)
    except OSError as error:
        raise ArgumentError(f"{name} cannot be written: {error.strerror or error}") from None
    except ValueError as error:  # a path with a null character
        raise ArgumentError(f"{name!r} cannot be written: {error}") from None


def write_table(path: str | os.PathLike[str], columns: Mapping[str, Sequence[str]]) -> None:
    """Write columns, by title, as a CSV file; an existing file is replaced.

    Raises:
        ArgumentError: the file cannot be written.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*columns.values(), strict=True))
    write_text(path, text.getvalue())


def cells(values: Array) -> list[str]:
    """Return numbers as texts of a column, empty if they are not finite."""
    return [f"{value:.15g}" if np.isfinite(value) else "" for value in np.ravel(values)]


def _uses_xacro(name: str) -> bool:
    try:
        with open(name, "rb") as file:
            return b"xmlns:xacro" in file.read()
    except (OSError, ValueError):  # it does not exist yet, or writing will raise the error
        return False


def _beside(description: RobotDescription, folder: str) -> RobotDescription:
    """Return a description with names of meshes relative to another folder."""
    source = os.path.dirname(os.path.abspath(description.path))
    if source == folder:
        return description

    def moved(match: re.Match[str]) -> str:
        before, name, after = match.groups()
        if "://" in name or os.path.isabs(name):
            return match[0]
        return f"{before}{os.path.relpath(os.path.join(source, name), folder)}{after}"

    links = {name: replace(link, extra=_FILE.sub(moved, link.extra)) for name, link in description.links.items()}
    return replace(description, links=links, extra=_FILE.sub(moved, description.extra))
