"""The plan of a sweep: grid, robots, loads and outputs; its digest, and the provenance stored with the map.

A combination has one value of each varied parameter of the robot file, that is, one robot.
"""

from __future__ import annotations

import datetime
import hashlib
import itertools
import json
import math
import os
import shlex
import threading
from collections import OrderedDict
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from importlib import metadata

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.description.robot_description import RobotDescription
from kinetostatics.exceptions import ArgumentError, RobotFileError
from kinetostatics.files.reader import read_robot_file
from kinetostatics.kinematics.assembly import assemble
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.layout.report import as_json
from kinetostatics.load_case import LoadCase
from kinetostatics.math.arrays import Array
from kinetostatics.robot import Robot
from kinetostatics.workspace.grid import Axis, Block, Field, cut, sizes_of

#: Values of the parameters: an index along each parameter axis.
Combination = tuple[int, ...]

#: Names of the links of platform and base, by argument ``platform_link`` and ``base_link``; None: those of the file.
Links = Mapping[str, str | None]

#: Largest number of cached robots.
KEPT = 4
#: Longest list stored in an attribute; of a longer list only first value, last value and count (all values are coordinates).
LONGEST = 64
#: Packages on whose versions the numbers depend.
PACKAGES = {"kinetostatics": "kinetostatics", "pinocchio": "pin", "numpy": "numpy"}

_kept: OrderedDict[object, Robot] = OrderedDict()
_lock = threading.RLock()


@dataclass(frozen=True, eq=False)
class Source:
    """The origin of the robots of a sweep: a description, or a file to be read with each combination of parameters.

    Attributes:
        path: the file as given, or "<python>".
        description: description of the only robot; None if parameters vary.
        files: sha256 of the robot file and its included files, by path.
        text: sha256 of the robot written as plain URDF, with the first combination of parameters.
        links: links of platform and base, if given.
    """

    path: str
    description: RobotDescription | None
    files: Mapping[str, str]
    text: str
    links: Links = field(default_factory=dict)

    def load(self, parameters: Mapping[str, object]) -> Robot:
        if self.description is not None:
            return Robot(self.description)
        robot = Robot(read_robot_file(self.path, parameters, **self.links))
        for name, digest in self.files.items():
            if sha256_of(name) != digest:
                raise ArgumentError(f"{name} has changed since the sweep began; start the sweep again")
        return robot


@dataclass(frozen=True, eq=False)
class SweepPlan:
    """All data of a sweep.

    Attributes:
        kind: kind of the coordinates, "platform" or "actuators".
        axes: axes of the grid: parameters, then cases of loads, then coordinates.
        held: constant coordinates [m, rad].
        load, gravity, point: arguments of :func:`kinetostatics.analyze`.
        case: the other loads, constant over the grid, and the engine.
        closure_tolerance: largest gap of a closed loop [m, rad].
        versions: versions of the packages on which the numbers depend, by name.
        compensated: platform coordinates that corrections of actuators restore; empty without the output "compensation".
        reduced: arguments ``outputs`` and ``reduce`` of a reduced map.
    """

    source: Source
    kind: str
    axes: tuple[Axis, ...]
    held: Mapping[str, float]
    constants: Mapping[str, object]
    load: Field
    gravity: Field
    outputs: tuple[str, ...]
    versions: Mapping[str, str]
    case: LoadCase
    point: Field | None = None
    closure_tolerance: float = 1e-10
    orientation: str | None = None
    compensated: tuple[str, ...] = ()
    modes: int = 0
    reduced: Mapping[str, object] = field(default_factory=dict)

    # ---- the grid ---------------------------------------------------------------------------------------------------

    @property
    def shape(self) -> tuple[int, ...]:
        return tuple(axis.size for axis in self.axes)

    @property
    def size(self) -> int:
        """Number of poses times number of load cases."""
        return math.prod(self.shape)

    def axes_of(self, *kinds: str) -> tuple[Axis, ...]:
        return tuple(axis for axis in self.axes if axis.kind in kinds)

    def part(self, block: Block, *kinds: str) -> Block:
        """Return the ranges of a block along the axes of given kinds."""
        return tuple(piece for piece, axis in zip(block, self.axes, strict=True) if axis.kind in kinds)

    def within(self, block: Block) -> SweepPlan:
        """Return the plan of a sweep over one block of the grid."""
        axes = tuple(replace(axis, values=axis.values[piece]) for axis, piece in zip(self.axes, block, strict=True))
        fields = {
            name: None if vector is None else vector.within(self.axes, block)
            for name, vector in (("load", self.load), ("gravity", self.gravity), ("point", self.point))
        }
        return replace(self, axes=axes, **fields)  # type: ignore[arg-type]

    def combinations(self) -> Iterator[Combination]:
        """Yield all combinations, the last parameter fastest."""
        yield from itertools.product(*(range(axis.size) for axis in self.axes_of("parameter")))

    def blocks(self, combination: Combination, sizes: Sequence[int], region: Block | None = None) -> Iterator[Block]:
        """Yield the blocks of one robot, of given sizes; with a region of coordinates, only blocks that overlap the region."""
        others = [axis.size for axis in self.axes if axis.kind != "parameter"]
        for block in cut(others, sizes[len(combination) :]):
            coordinates = block[len(others) - len(region) :] if region else ()
            if all(a.start < b.stop and b.start < a.stop for a, b in zip(coordinates, region or (), strict=True)):
                yield (*(slice(k, k + 1) for k in combination), *block)

    def every_block(self, sizes: Sequence[int]) -> Iterator[Block]:
        """Yield the blocks of all robots."""
        return (block for combination in self.combinations() for block in self.blocks(combination, sizes))

    def parameters(self, combination: Combination) -> dict[str, object]:
        """Return the values of all parameters, varied and constant."""
        varying = {axis.name: axis.values[k].item() for axis, k in zip(self.axes_of("parameter"), combination, strict=True)}
        return {**self.constants, **varying}

    def coordinates(self, block: Block) -> dict[str, Array]:
        """Return the coordinates (N,) of all poses in a block of coordinate axes, including constant coordinates."""
        axes = self.axes_of("coordinate")
        mesh = np.meshgrid(*(axis.values[piece] for axis, piece in zip(axes, block, strict=True)), indexing="ij")
        count = math.prod(sizes_of(block))
        values = {axis.name: array.ravel() for axis, array in zip(axes, mesh, strict=True)}
        return {**values, **{name: np.full(count, value) for name, value in self.held.items()}}

    # ---- robots -----------------------------------------------------------------------------------------------------

    def robot(self, combination: Combination) -> Robot:
        """Return the robot of a combination; the last ``KEPT`` robots are cached, because building a robot takes long."""
        with _lock:
            key, values = self._key(combination), self.parameters(combination)
            if key not in _kept:
                with naming_parameters({axis.name: values[axis.name] for axis in self.axes_of("parameter")}):
                    _kept[key] = self.source.load(values)
            _kept.move_to_end(key)
            while len(_kept) > KEPT:
                _kept.popitem(last=False)
            return _kept[key]

    def keep(self, combination: Combination, robot: Robot) -> None:
        with _lock:
            _kept[self._key(combination)] = robot

    def _key(self, combination: Combination) -> tuple[object, ...]:
        links = tuple(sorted(self.source.links.items()))
        files = tuple(self.source.files.items())
        return self.source.path, self.source.text, files, links, tuple(self.parameters(combination).items())

    def assemble(self, robot: Robot, values: Mapping[str, ArrayLike], near: Configuration | None = None) -> Configuration:
        """Return the poses (N,) at given coordinates, the ends of straight lines from the zero pose or from ``near``."""
        actuators, platform = (None, values) if self.kind == "platform" else (values, None)
        orientation = None if platform is None else self.orientation
        return assemble(robot, actuators, platform, orientation, near, self.closure_tolerance, "nan", self.case.loops)

    # ---- its identity -----------------------------------------------------------------------------------------------

    @property
    def arguments(self) -> dict[str, object]:
        """Arguments of :func:`kinetostatics.sweep` that determine its results, as plain values, without the robot."""
        return {
            self.kind: {**{axis.name: axis.values.tolist() for axis in self.axes_of("coordinate")}, **self.held},
            "parameters": {**{axis.name: axis.values.tolist() for axis in self.axes_of("parameter")}, **self.constants},
            "orientation": self.orientation,
            "load": self.load.as_json(),
            "gravity": self.gravity.as_json(),
            "point": None if self.point is None else self.point.as_json(),
            "frame": self.case.frame,
            "assembly_errors": as_json(self.case.assembly_errors),
            **{name: as_json(value) for name in ("loads", "payload") if (value := getattr(self.case, name)) is not None},
            "closure_tolerance": self.closure_tolerance,
            "outputs": list(self.outputs),
            **({"modes": self.modes} if self.modes else {}),
            **self.reduced,
        }

    @cached_property
    def facts(self) -> dict[str, object]:
        """All data on which the results of the sweep depend, as plain values by name."""
        grid = {f"axis {axis.name}": axis.as_json() for axis in self.axes}
        return {
            **self.arguments,
            **grid,
            "robot": self.source.text,
            # robots with other parameters may need further files
            "robot's files": {} if self.source.description is not None else dict(self.source.files),
            "order of dimensions": [axis.name for axis in self.axes],
            **{f"version of {name}": version for name, version in self.versions.items()},
        }

    @cached_property
    def identity(self) -> str:
        """Sha256 of :attr:`facts`."""
        return hashlib.sha256(as_text(self.facts).encode()).hexdigest()


@contextmanager
def naming_parameters(parameters: Mapping[str, object]) -> Iterator[None]:
    """Add the values of parameters to errors of a robot's file."""
    try:
        yield
    except RobotFileError as error:
        if not parameters:
            raise
        values = ", ".join(f"{name} = {value}" for name, value in parameters.items())
        raise RobotFileError(f"{error.reason} (with {values})", error.file, error.line) from None


def as_text(value: object) -> str:
    """Return JSON with sorted keys, so that equal values have equal text."""
    return json.dumps(as_json(value), sort_keys=True, ensure_ascii=False, separators=(",", ":"))


def sha256_of(path: str | os.PathLike[str]) -> str:
    """Return the sha256 of a file, empty if it cannot be read."""
    try:
        with open(path, "rb") as file:
            return hashlib.sha256(file.read()).hexdigest()
    except (OSError, ValueError):
        return ""


@cache
def versions() -> dict[str, str]:
    """Return the versions of the packages on which the numbers depend."""
    installed = {}
    for name, distribution in PACKAGES.items():
        try:
            installed[name] = metadata.version(distribution)
        except metadata.PackageNotFoundError:
            installed[name] = "unknown"
    return installed


def files_of(description: RobotDescription) -> dict[str, str]:
    """Return the sha256 of a robot's file and of the files of its elements, by path."""
    tables = ("links", "joints", "loops", "beams", "joint_stiffness", "springs", "flexible")
    places = [element.place.file for table in tables for element in getattr(description, table).values()]
    with_matrices = (*description.flexible.values(), *description.joint_stiffness.values())
    matrices = [path for part in with_matrices if (path := getattr(part, "file", ""))]
    names = dict.fromkeys([description.path, description.platform_place.file, *places, *matrices])
    return {name: digest for name in names if os.path.isfile(name) and (digest := sha256_of(name))}


def text_digest(description: RobotDescription) -> str:
    """Return the sha256 of the robot written as plain URDF, which contains all data of its files."""
    return hashlib.sha256(
        "".join([description.urdf, *(part.digest for part in description.flexible.values())]).encode()
    ).hexdigest()


def attributes_of_map(plan: SweepPlan, robot: Robot, command_line: Sequence[str] | None = None) -> dict[str, object]:
    """Return the attributes of the Dataset; ``robot`` is the first robot of the sweep."""
    now = datetime.datetime.now(datetime.UTC).replace(microsecond=0).isoformat()
    command = shlex.join(command_line) if command_line else ""
    attributes: dict[str, object] = {
        "Conventions": "CF-1.11",
        "title": f"workspace map of the parallel manipulator {robot.name}",
        "source": f"kinetostatics {plan.versions['kinetostatics']}",
        "history": f"{now} {command or 'kinetostatics.sweep'}",
        "references": "Yang, Huang, Ye, Chen, Chinese Journal of Mechanical Engineering 36 (2023)",
        "date": now,
        "robot_name": robot.name,
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
        attributes["warnings"] = "\n".join(robot.warnings)
    if command:
        attributes["command_line"] = command
    return attributes


def _short(value: object) -> object:
    if isinstance(value, Mapping):
        return {key: _short(element) for key, element in value.items()}
    if isinstance(value, list) and len(value) > LONGEST:
        return {"first": value[0], "last": value[-1], "count": len(value)}
    return value
