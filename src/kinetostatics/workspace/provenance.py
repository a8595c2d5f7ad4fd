"""Provenance of a Dataset: files, versions, arguments."""

from __future__ import annotations

import datetime
import hashlib
import os
import shlex
from collections.abc import Mapping, Sequence
from functools import cache
from importlib import metadata

from kinetostatics.description.robot_description import RobotDescription
from kinetostatics.robot import Robot
from kinetostatics.workspace.dataset import Labels
from kinetostatics.workspace.sweep_plan import SweepPlan, as_text, sha256_of

CONVENTIONS = "CF-1.11"
#: Longest list stored in an attribute; of longer ones only first, last and count (the Dataset's coordinates contain all values).
LONGEST = 64
#: Packages on whose versions the numbers depend.
PACKAGES = {"kinetostatics": "kinetostatics", "pinocchio": "pin", "numpy": "numpy"}


@cache
def versions() -> dict[str, str]:
    """Return the versions of the packages on which the numbers depend."""
    found = {}
    for name, distribution in PACKAGES.items():
        try:
            found[name] = metadata.version(distribution)
        except metadata.PackageNotFoundError:
            found[name] = "unknown"
    return found


def files_of(description: RobotDescription) -> dict[str, str]:
    """Return the sha256 of a robot's file and of the files of its elements, by path."""
    tables = ("links", "joints", "loops", "beams", "joint_stiffness", "springs")
    places = [item.place.file for table in tables for item in getattr(description, table).values()]
    names = dict.fromkeys([description.path, description.platform_place.file, *places])
    return {name: digest for name in names if os.path.isfile(name) and (digest := sha256_of(name))}


def text_digest(description: RobotDescription) -> str:
    """Return the sha256 of the robot written as plain URDF, which contains all data of its files."""
    return hashlib.sha256(description.urdf.encode()).hexdigest()


def attributes(plan: SweepPlan, labels: Labels, robot: Robot, command_line: Sequence[str] | None = None) -> dict[str, object]:
    """Return the attributes of the Dataset; ``robot`` is the first one."""
    now = datetime.datetime.now(datetime.UTC).replace(microsecond=0).isoformat()
    command = shlex.join(command_line) if command_line else ""
    found: dict[str, object] = {
        "Conventions": CONVENTIONS,
        "title": f"workspace map of the parallel manipulator {labels.robot}",
        "source": f"kinetostatics {plan.versions['kinetostatics']}",
        "history": f"{now} {command or 'kinetostatics.sweep'}",
        "references": "Yang, Huang, Ye, Chen, Chinese Journal of Mechanical Engineering 36 (2023)",
        "date": now,
        "robot_name": labels.robot,
        "robot_path": plan.source.path,
        "robot_files": as_text(plan.source.files),
        "robot_sha256": plan.source.files.get(plan.source.path, ""),
        "robot_text_sha256": plan.source.text,
        "parameters": as_text(_short(plan.arguments["parameters"])),
        "arguments": as_text(_short(plan.arguments)),
        "sweep_sha256": plan.identity,
        **{f"{name}_version": version for name, version in plan.versions.items()},
    }
    if robot.warnings:
        found["warnings"] = "\n".join(robot.warnings)
    if command:
        found["command_line"] = command
    return found


def _short(value: object) -> object:
    if isinstance(value, Mapping):
        return {key: _short(item) for key, item in value.items()}
    if isinstance(value, list) and len(value) > LONGEST:
        return {"first": value[0], "last": value[-1], "count": len(value)}
    return value
