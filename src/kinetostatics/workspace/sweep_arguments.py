"""The plan of a sweep from its checked arguments."""

from __future__ import annotations

import itertools
import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.analysis import analyzed
from kinetostatics.arguments import check, check_mapping, names_in, warn
from kinetostatics.description.robot_description import RobotDescription
from kinetostatics.engine.programs import engine_for
from kinetostatics.exceptions import ArgumentError, near_names
from kinetostatics.files.bundled import robot_path
from kinetostatics.kinematics.alternatives import best_choice
from kinetostatics.load_case import LoadCase
from kinetostatics.math.rotations import orientation_named
from kinetostatics.parametric.parametric_robot import ParametricRobot
from kinetostatics.quantities import VARIABLES
from kinetostatics.robot import Robot, load_robot
from kinetostatics.statics.assembly_errors import parse_assembly_errors
from kinetostatics.statics.link_loads import parse_link_loads
from kinetostatics.units import find_unit
from kinetostatics.workspace.grid import Axis, Field, coordinate_units, read_field, split_values
from kinetostatics.workspace.sweep_plan import Links, Source, SweepPlan, files_of, naming_parameters, text_digest, versions

#: Largest number of robots that are built for checks before the computation.
TRIED = 50
#: Load, gravity and point by default, with their numbers of components.
NO_LOAD: Mapping[str, tuple[ArrayLike | None, int]] = {
    "load": ((0, 0, 0, 0, 0, 0), 6),
    "gravity": ((0, 0, -9.81), 3),
    "point": (None, 3),
}


def read_plan(
    robot: Robot | RobotDescription | str | os.PathLike[str],
    coordinates: Mapping[str, Mapping[str, ArrayLike] | None],
    parameters: Mapping[str, object] | None = None,
    parameter_units: Mapping[str, str] | None = None,
    links: Links | None = None,
    outputs: Sequence[str] = ("default",),
    vectors: Mapping[str, tuple[ArrayLike | None, int]] = NO_LOAD,
    case: LoadCase | None = None,
    *,
    orientation: str | None = None,
    modes: int = 0,
    closure_tolerance: float = 1e-10,
) -> tuple[SweepPlan, Robot]:
    """Return the plan of a sweep and its first robot; most arguments are described at :func:`kinetostatics.sweep`.

    Args:
        coordinates: prescribed coordinates by "platform" or "actuators".
        links: names of the links of platform and base.
        vectors: load, gravity and point, each with its number of components.
        case: the other loads, constant over the grid.
    """
    kinds = {kind: given for kind, given in coordinates.items() if given is not None}
    if len(kinds) > 1:
        raise ArgumentError("give either platform= or actuators=, not both")
    check("modes", modes)
    closure_tolerance = check("closure_tolerance", closure_tolerance)
    case = case or LoadCase()
    requested = [*names_in("outputs", outputs, '["twist", "stiffness"]'), *(["modes"] if modes else [])]
    groups = dict.fromkeys(variable.group for variable in VARIABLES.values() if variable.group != "always")
    for name in requested:
        if name not in VARIABLES and name not in groups:
            raise ArgumentError(f"no output {name!r}: {near_names(name, [*groups, *VARIABLES])}")
        if not modes and "modes" in (name, name in VARIABLES and VARIABLES[name].group):
            raise ArgumentError(f"output {name!r} needs modes=, the number of natural frequencies")
    variables = tuple(name for name, variable in VARIABLES.items() if name in requested or variable.group in requested)
    for what in ("load", "gravity"):
        if vectors[what][0] is None:
            raise ArgumentError(f"{what} is None; it must be an array of numbers")
    varying, constants = split_values("parameters", {} if parameters is None else parameters, "parameter")
    start = {**constants, **{axis.name: axis.values[0].item() for axis in varying}}
    with naming_parameters({axis.name: start[axis.name] for axis in varying}):
        first, source = _source(robot, start, bool(varying), links or {})
    varying = _with_units(varying, first, source.links, start, parameter_units)
    if not kinds:
        kinds = {"actuators": dict.fromkeys(first.description.actuated, 0.0)}
    ((kind, given),) = kinds.items()
    if case.assembly_errors is not None:
        parse_assembly_errors(first.statics, case.assembly_errors)
    on_links = parse_link_loads(first.statics, case.loads, case.payload)
    if on_links is not None and any(array.ndim > 1 for array in on_links.arrays()):
        raise ArgumentError(
            "loads on links and the payload are constant in a sweep: give single vectors and numbers, not arrays over poses"
        )
    check_mapping(kind, given, '{"z": [0.4, 0.5, 0.6]}')
    orientation_named(orientation)
    units = coordinate_units(first, kind, list(given))
    swept, held = split_values(kind, given, "coordinate", units)
    fields, cases = _fields(vectors, [*varying, *swept])
    axes = (*varying, *cases, *swept)
    plan = SweepPlan(
        source,
        kind,
        axes,
        {name: float(value) for name, value in held.items()},
        constants if parameters else {},
        load=fields["load"],
        gravity=fields["gravity"],
        point=fields.get("point"),
        orientation=orientation,
        modes=modes,
        closure_tolerance=closure_tolerance,
        outputs=variables,
        versions=versions(),
        case=replace(case, engine=engine_for(case.engine, math.prod(axis.size for axis in axes))),
    )
    if any(VARIABLES[name].group == "compensation" for name in variables):
        plan = replace(plan, compensated=_compensated(first, kind, list(given), orientation))
    plan.keep((0,) * len(varying), first)
    return plan, first


def _compensated(robot: Robot, kind: str, given: Sequence[str], orientation: str | None) -> tuple[str, ...]:
    """Return the platform coordinates to be corrected.

    On a grid of the platform these are the prescribed coordinates; on a grid of actuators, the coordinates that best determine
    the zero pose.
    """
    names = tuple(given) if kind == "platform" else best_choice(robot, orientation_named(orientation), robot.zero_poses)
    if not names:
        raise ArgumentError(f"{robot.name!r} has no platform coordinates that its actuators can correct")
    return names


def _with_units(
    varying: Sequence[Axis], first: Robot, links: Links, start: Mapping[str, object], given: Mapping[str, str] | None
) -> list[Axis]:
    """Check the given units, and return the axes of parameters with their units where known."""
    given = {} if given is None else given
    check_mapping("parameter_units", given, '{"rod_diameter": "m"}')
    for name, text in given.items():
        unit = find_unit(text) if isinstance(text, str) else None
        if name not in start or unit is None or unit.size != 1:
            raise ArgumentError(f"parameter_units: {name!r}: {text!r} is not the SI unit of one of parameters=")
    family = ParametricRobot(first, links)
    family.check_units(given, "parameters")
    units = {axis.name: family.number(axis.name).unit for axis in varying if axis.name in family.arguments}
    return [replace(axis, units=units.get(axis.name) or given.get(axis.name, "")) for axis in varying]


def _source(
    robot: Robot | RobotDescription | str | os.PathLike[str], parameters: Mapping[str, object], varying: bool, links: Links
) -> tuple[Robot, Source]:
    """Return the first robot, and the description or file from which all robots of the sweep are made."""
    if isinstance(robot, (str, os.PathLike)):
        path = os.fspath(robot_path(robot))
        first = load_robot(path, parameters, **links)
    elif parameters:
        raise ArgumentError(
            "parameters need the robot's file: give its path instead of a loaded robot, with all values that differ from the "
            "file's defaults in parameters="
        )
    elif any(links.values()):
        raise ArgumentError(
            "platform_link and base_link need the robot's file: give its path, or load the robot with "
            "load_robot(…, platform_link=…, base_link=…)"
        )
    else:
        first = robot if isinstance(robot, Robot) else Robot(robot)
        path = first.description.path
    description = first.description
    files = files_of(description)
    return first, Source(path, None if varying else description, files, text_digest(description), links)


def _fields(given: Mapping[str, tuple[object, int]], grid_axes: Sequence[Axis]) -> tuple[dict[str, Field], list[Axis]]:
    """Return load, gravity and point as fields, and the axes of their dimensions that are not yet in the grid."""
    fields: dict[str, Field] = {}
    cases: list[Axis] = []
    for what, (value, size) in given.items():
        if value is None:
            continue
        fields[what], axes = read_field(what, value, size)
        for axis in axes:
            same = next((other for other in (*grid_axes, *cases) if other.name == axis.name), None)
            if same is None:
                cases.append(axis)
            elif not np.array_equal(same.values, axis.values):
                raise ArgumentError(f"{what} varies along {axis.name!r}, but with other values than those of the grid")
    return fields, cases


def try_plan(plan: SweepPlan, first: Robot) -> None:
    """Warn of coordinates in unusual units, and analyse the first pose, so that errors are raised before the computation."""
    for hint in first.unit_hints({**plan.held, **{axis.name: axis.values for axis in plan.axes_of("coordinate")}}):
        warn(hint)
    corner = plan.coordinates(tuple(slice(0, 1) for _ in plan.axes_of("coordinate")))
    configuration = plan.assemble(first, corner)
    analyzed(configuration, replace(plan.case, engine="auto"), "nan")


def try_robots(plan: SweepPlan) -> None:
    """Load the robots of all combinations of parameters, if there are at most ``TRIED``, to raise errors of the file early."""
    combinations = list(itertools.islice(plan.combinations(), TRIED + 1))
    if len(combinations) <= TRIED:
        for combination in combinations:
            plan.robot(combination)
