"""What a sweep is asked for, in a form that can be sent to other processes and compared with what was asked before."""

from __future__ import annotations

import hashlib
import itertools
import json
import math
import os
import threading
from collections import OrderedDict
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, fields, is_dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.argument_checks import Keyword
from kinetostatics.description.loads import Payload
from kinetostatics.description.robot import RobotDescription
from kinetostatics.engine.programs import compiled_loops
from kinetostatics.exceptions import ArgumentError, RobotFileError
from kinetostatics.files.reader import read_robot_file
from kinetostatics.kinematics.assembly import assemble
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.math.arrays import Array
from kinetostatics.robot import Robot
from kinetostatics.workspace.grid import Axis, Block, Field, sizes_of

#: Which value each parameter has: an index along each parameter axis.
Combination = tuple[int, ...]

#: Names of the platform's and the base's link, as ``platform`` and ``base``, None where the file says it.
Links = Mapping[str, str | None]

#: Robots that a thread keeps ready.
KEPT = 4

_kept = threading.local()


@dataclass(frozen=True, eq=False)
class Source:
    """Where the robots of a sweep come from: a description, or a file to be read with each combination of parameters.

    Attributes:
        path: the file as given, or "<python>".
        description: of the only robot; None if parameters vary.
        files: sha256 of the robot file and of those that it includes, by path.
        text: sha256 of the robot written as plain URDF, that of the first combination of parameters.
        links: platform and base, if the caller names them.
    """

    path: str
    description: RobotDescription | None
    files: Mapping[str, str]
    text: str
    links: Links = field(default_factory=dict)

    def load(self, parameters: Mapping[str, object]) -> Robot:
        """Return a robot.

        Raises:
            RobotFileError: the file is wrong.
            ArgumentError: a file has changed since the sweep began.
        """
        if self.description is not None:
            return Robot(self.description)
        robot = Robot(read_robot_file(self.path, parameters, **self.links))
        for name, known in self.files.items():
            if sha256_of(name) != known:
                raise ArgumentError(f"{name} has changed since the sweep began; start it anew")
        return robot


@dataclass(frozen=True, eq=False)
class SweepSpec:
    """A sweep.

    Attributes:
        source: of its robots.
        kind: "platform" or "actuators": what the coordinates are.
        axes: of the grid: parameters, then cases of loads, then coordinates.
        held: coordinates that are the same everywhere [m, rad].
        constants: parameters of the robot file that are the same everywhere.
        orientation: what the platform's orientation coordinates mean.
        load, gravity, point, frame, assembly_errors: as :func:`kinetostatics.analyze` takes them.
        closure_tolerance: how far loops may stay open [m, rad].
        beams: whether stresses and deflections of beams are wanted too.
        ways: whether the ways in which gravity acts are wanted too.
        versions: of the packages that compute, by name.
        compensated: coordinates of the platform that actuators are to be corrected for; none: no corrections are wanted.
        engine: which the equilibrium is computed by, as :func:`kinetostatics.analyze` takes it.
        loads, payload: as it takes them, the same at all poses.
        outputs: names of the variables that are wanted besides what is always there; None: all that need no further argument.
    """

    source: Source
    kind: str
    axes: tuple[Axis, ...]
    held: Mapping[str, float]
    constants: Mapping[str, object]
    orientation: str | None
    load: Field
    gravity: Field
    point: Field | None
    frame: str
    assembly_errors: Mapping[str, object] | None
    closure_tolerance: float
    beams: bool
    ways: bool
    versions: Mapping[str, str]
    engine: str = "auto"
    compensated: tuple[str, ...] = ()
    loads: Mapping[str, object] | None = None
    payload: Payload | None = None
    outputs: tuple[str, ...] | None = None

    @property
    def extras(self) -> dict[str, Keyword]:
        """What is the same at all poses, as :func:`kinetostatics.analyze` takes it: assembly errors, loads on links, payload."""
        return {"assembly_errors": self.assembly_errors, "loads": self.loads, "payload": self.payload}

    # ---- the grid ---------------------------------------------------------------------------------------------------

    @property
    def shape(self) -> tuple[int, ...]:
        """Sizes of all axes."""
        return tuple(axis.size for axis in self.axes)

    @property
    def size(self) -> int:
        """Number of poses, each case of loads counted."""
        return math.prod(self.shape)

    def axes_of(self, *kinds: str) -> tuple[Axis, ...]:
        """Return the axes of given kinds."""
        return tuple(axis for axis in self.axes if axis.kind in kinds)

    def part(self, block: Block, *kinds: str) -> Block:
        """Return what a block is along the axes of given kinds."""
        return tuple(piece for piece, axis in zip(block, self.axes, strict=True) if axis.kind in kinds)

    def combinations(self, block: Block | None = None) -> Iterator[Combination]:
        """Yield the combinations of parameters, of all or of a block, the last parameter fastest."""
        block = block or tuple(slice(0, axis.size) for axis in self.axes)
        yield from itertools.product(*(range(piece.start, piece.stop) for piece in self.part(block, "parameter")))

    def parameters(self, combination: Combination) -> dict[str, object]:
        """Return the values of all parameters."""
        varying = {axis.name: axis.values[k].item() for axis, k in zip(self.axes_of("parameter"), combination, strict=True)}
        return {**self.constants, **varying}

    def coordinates(self, block: Block) -> dict[str, Array]:
        """Return the coordinates (N,) of all poses in a block of coordinate axes, held ones too."""
        axes = self.axes_of("coordinate")
        mesh = np.meshgrid(*(axis.values[piece] for axis, piece in zip(axes, block, strict=True)), indexing="ij")
        count = math.prod(sizes_of(block))
        values = {axis.name: array.ravel() for axis, array in zip(axes, mesh, strict=True)}
        return {**values, **{name: np.full(count, value) for name, value in self.held.items()}}

    # ---- robots -----------------------------------------------------------------------------------------------------

    def robot(self, combination: Combination) -> Robot:
        """Return a robot; each thread keeps the last few, because robots are costly to build and not made to be shared."""
        kept: OrderedDict[object, Robot] = _kept.__dict__.setdefault("robots", OrderedDict())
        key = (self.identity, combination)
        if key not in kept:
            varying = [axis.name for axis in self.axes_of("parameter")]
            values = self.parameters(combination)
            with saying({name: values[name] for name in varying}):
                kept[key] = self.source.load(values)
        kept.move_to_end(key)
        while len(kept) > KEPT:
            kept.popitem(last=False)
        return kept[key]

    def keep(self, combination: Combination, robot: Robot) -> None:
        """Let this thread use a robot that is there already."""
        kept: OrderedDict[object, Robot] = _kept.__dict__.setdefault("robots", OrderedDict())
        kept[self.identity, combination] = robot

    def assemble(self, robot: Robot, values: Mapping[str, ArrayLike], near: Configuration | None = None) -> Configuration:
        """Return the poses (N,) at coordinates, which have been warned of before, along a line from the zero pose or ``near``."""
        actuators, platform = (None, values) if self.kind == "platform" else (values, None)
        orientation = None if platform is None else self.orientation
        return assemble(robot, actuators, platform, orientation, near, self.closure_tolerance, "nan", compiled_loops(self.engine))

    # ---- what makes it this sweep and no other ----------------------------------------------------------------------

    @property
    def arguments(self) -> dict[str, object]:
        """All arguments as plain values."""
        return {
            self.kind: {
                **{axis.name: axis.values.tolist() for axis in self.axes_of("coordinate")},
                **self.held,
            },
            "parameters": {**{axis.name: axis.values.tolist() for axis in self.axes_of("parameter")}, **self.constants},
            "orientation": self.orientation,
            "load": self.load.as_json(),
            "gravity": self.gravity.as_json(),
            "point": None if self.point is None else self.point.as_json(),
            "frame": self.frame,
            **{name: plain(value) for name, value in self.extras.items() if name == "assembly_errors" or value is not None},
            "closure_tolerance": self.closure_tolerance,
            "beams": self.beams,
            "ways": self.ways,
            **({"compensate": list(self.compensated)} if self.compensated else {}),
            **({} if self.outputs is None else {"outputs": list(self.outputs)}),
        }

    @cached_property
    def facts(self) -> dict[str, object]:
        """Everything that the numbers depend on, as plain values in one level."""
        grid = {f"axis {axis.name}": axis.as_json() for axis in self.axes}
        return {
            **self.arguments,
            **grid,
            "robot": self.source.text,
            # robots with other parameters than the first may need what it does not
            "robot's files": {} if self.source.description is not None else dict(self.source.files),
            "order of dimensions": [axis.name for axis in self.axes],
            **{f"version of {name}": version for name, version in self.versions.items()},
        }

    @cached_property
    def identity(self) -> str:
        """Sha256 of :attr:`facts`."""
        return hashlib.sha256(as_text(self.facts).encode()).hexdigest()


@contextmanager
def saying(parameters: Mapping[str, object]) -> Iterator[None]:
    """Let complaints about a robot's file say with which parameters it was read."""
    try:
        yield
    except RobotFileError as error:
        if not parameters:
            raise
        said = ", ".join(f"{name} = {value}" for name, value in parameters.items())
        raise RobotFileError(f"{error.reason} (with {said})", error.file, error.line) from None


def plain(value: object) -> object:
    """Return nested mappings and arrays as plain values."""
    if is_dataclass(value) and not isinstance(value, type):
        return {item.name: plain(getattr(value, item.name)) for item in fields(value)}
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    return np.asarray(value).tolist() if isinstance(value, (np.ndarray, np.generic)) else value


def as_text(value: object) -> str:
    """Return plain values as JSON, always the same for the same values."""
    return json.dumps(plain(value), sort_keys=True, ensure_ascii=False, separators=(",", ":"))


def sha256_of(path: str | os.PathLike[str]) -> str:
    """Return the sha256 of a file, empty if it cannot be read."""
    try:
        with open(path, "rb") as file:
            return hashlib.sha256(file.read()).hexdigest()
    except (OSError, ValueError):
        return ""
