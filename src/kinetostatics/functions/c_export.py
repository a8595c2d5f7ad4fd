"""Export of functions of a robot as C for controllers: records as C code, path following along straight lines, and status."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np

from kinetostatics.arguments import check_choice, path_name
from kinetostatics.compensation import MOST, error_tolerance
from kinetostatics.engine.scalars import NotRecordedError
from kinetostatics.exceptions import ArgumentError
from kinetostatics.functions import c_texts
from kinetostatics.functions.c_programs import Exported, Programs, identifier, requested_outputs
from kinetostatics.functions.inputs_outputs import LOADS, Facts, Quantity, Reference, Values
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.kinematics.solver import MOST_CORRECTIONS, SHRINKING, SolverState
from kinetostatics.math.arrays import Array
from kinetostatics.math.rotations import orientation_named
from kinetostatics.status import WITHOUT_NUMBERS, Status

#: Types of arguments and results.
SCALARS: Mapping[str, type[np.floating]] = {"double": np.float64, "float": np.float32}
#: Number of reference poses in the test program.
REFERENCES = 40


class Differentiated(Protocol):
    """Derivatives that are exported, see :class:`kinetostatics.functions.function.Jacobian`."""

    @property
    def of(self) -> tuple[str, ...]:
        """Outputs that are differentiated."""

    @property
    def by(self) -> tuple[str, ...]:
        """Inputs with respect to which they are differentiated."""

    @property
    def __call__(self) -> Callable[..., Mapping[str, Mapping[str, Array]]]:
        """Return the derivatives."""


@dataclass(frozen=True)
class CExport:
    """Result of an export.

    Attributes:
        folder: folder of the files.
        files: names of the files.
        name: prefix of all names in C.
        operations: numbers of operations of a correction of the loops, and of the analysis.
        work: bytes of work arrays on the stack.
    """

    folder: Path
    files: tuple[str, ...]
    name: str
    operations: tuple[int, int]
    work: int


def export_c(
    function: Exported,
    folder: str | os.PathLike[str],
    scalar: str = "double",
    name: str | None = None,
    jacobian: Differentiated | None = None,
    near: Configuration | Values | None = None,
) -> CExport:
    """Write a function of a robot as C99: no heap, nothing but libm, bounded iterations, all state passed in.

    Args:
        function: a function from :func:`kinetostatics.compile`.
        folder: folder of the files; created if missing.
        scalar: "double" or "float", the type of arguments and results; computations are in double.
        name: prefix of all names in C; default: the name of the robot.
        jacobian: derivatives to be exported.
        near: pose of the initial state; default: the zero pose.

    Raises:
        ArgumentError: ``near`` is not one pose of the robot; the robot or the orientation cannot be exported; ``scalar`` is
            invalid; or ``folder`` is a file.
        OSError: a file cannot be written.
    """
    check_choice("scalar", scalar, tuple(SCALARS))
    where = Path(path_name("folder", folder))
    if where.exists() and not where.is_dir():
        raise ArgumentError(f"{where} is a file: the C code needs a folder")
    own = identifier(function.robot.name if name is None else name)
    start = near.pose if isinstance(near, Values) else near
    mine = isinstance(start, Configuration) and start.robot is function.robot
    if start is not None and not (mine and start.shape == () and bool(start.reached[0])):
        raise ArgumentError("near= needs one closed pose of the robot for an export: create one with robot.assemble(…)")
    begin = function.robot.zero_poses if start is None else start.poses
    try:
        parts = Programs(function, begin, None if jacobian is None else (jacobian.of, jacobian.by))
    except NotRecordedError as error:
        raise ArgumentError(f"{function.robot.name!r} cannot be exported: {error}") from error
    references = _references(function, jacobian, start, REFERENCES, SCALARS[scalar])
    texts = c_texts.files(own, scalar, _facts(function, parts, begin), references)
    where.mkdir(parents=True, exist_ok=True)
    for file, text in texts.items():
        (where / file).write_text(text, encoding="utf-8")
    return CExport(where, tuple(texts), own, (parts.line.newton.operations, parts.pose.operations), 8 * parts.work)


def _facts(function: Exported, parts: Programs, begin: SolverState) -> Facts:
    """Return the data of the texts."""
    connections = function.robot.mechanism.connections
    coordinates = _coordinates(function)
    limits = {name: (connections[name].lower, connections[name].upper) for name in function.robot.description.driven}
    limits = {name: both for name, both in limits.items() if np.all(np.isfinite(both))}
    return {
        "robot": function.robot.name,
        "parts": parts,
        "coordinates": coordinates,
        "names": [parts.c_names[item.name] for item in coordinates],
        "order": [[item.name for item in coordinates].index(name) for name in function.names],
        "start": {name: round(value, 9) or 0.0 for name, value in _coordinates_at(function, begin).items()},
        "from_zero": begin is function.robot.zero_poses,
        "limits": limits,  # those that are finite
        "orientation": function.orientation or "rotation_vector",
        "by_actuators": function.by_actuators,
        "outputs": parts.outputs,
        "unique_below": orientation_named(function.orientation).unique_below,
        "compensates": function.compensates,
        "controlled": function.names,
        "searches": MOST,
        "absolute": {"residual_error": error_tolerance(function.robot.length)},
        "rough": function.robot.rough_residual,
        "functions": sum(line.count("= cos(") + line.count("= sin(") for line in parts.line.impose),
        "corrections": MOST_CORRECTIONS,
        "shrinking": SHRINKING,
    }


def _references(
    function: Exported, jacobian: Differentiated | None, near: Configuration | None, poses: int, scalar: type[np.floating]
) -> list[Reference]:
    """Return poses around the initial state, with loads and Python's results; a third of the poses are six times as far away.

    All numbers are representable in ``scalar``, so that both programs compute the same poses.
    """
    rng = np.random.default_rng(0)
    robot = function.robot
    coordinates = _coordinates(function)
    start = _coordinates_at(function, robot.zero_poses if near is None else near.poses)
    wide = np.where(np.arange(poses) % 3 == 2, 6.0, 1.0)
    steps = rng.uniform(-1, 1, (len(coordinates), poses)) * wide
    load = rng.uniform(-100, 100, (poses, 6)).astype(scalar).astype(float)
    gravity = (np.array([0.0, 0.0, -9.81]) + rng.uniform(-1, 1, (poses, 3))).astype(scalar).astype(float)
    for part in (0.15, 0.05, 0.015):  # of the robot's length, or rad: smaller until at least half of the poses are reached
        spans = {item.name: part * (robot.length if item.units[0] == "m" else 1.0) for item in coordinates}
        at = {name: start[name] + span * step for (name, span), step in zip(spans.items(), steps, strict=True)}
        at = {name: value.astype(scalar).astype(float) for name, value in at.items()}
        values = function(**at, load=load, gravity=gravity, near=near)
        if np.mean(np.isin(values["status"], WITHOUT_NUMBERS)) < 0.5:
            break
    found = []
    arrays = {item.name: values[item.name] for item in requested_outputs(function)}
    if jacobian is not None:
        for output, columns in jacobian(**at, load=load, gravity=gravity, near=near).items():
            arrays |= {f"{output} by {name}": array for name, array in columns.items()}
    for k in range(poses):
        expected = {name: np.ravel(array[k]) for name, array in arrays.items()}
        status = int(values["status"][k])
        if status == Status.LIMIT_EXCEEDED and not function.compensates:  # C checks limits with compensation only
            status = int(Status.OK)
        found.append(({name: float(at[name][k]) for name in at}, load[k], gravity[k], expected, status))
    return found


def _coordinates_at(function: Exported, pose: SolverState) -> dict[str, float]:
    return dict(zip(function.names, function.robot.solver.values(function.prescribed, pose)[:, 0].tolist(), strict=True))


def _coordinates(function: Exported) -> list[Quantity]:
    return [item for name, item in function.inputs.items() if name not in LOADS]
