"""Commands on poses: analyze, verify, compensate, modes, response."""

from __future__ import annotations

import argparse
import itertools
import math
import os
import shlex
from typing import TYPE_CHECKING

from kinetostatics.arguments import Keyword
from kinetostatics.cli.commands import Command
from kinetostatics.cli.inputs import (
    GRID_HELP,
    MOST,
    VALUES_HELP,
    assembled,
    coordinate_kind,
    given_of,
    grid_of,
    load_robot,
    loads_of,
    parse_coordinates,
    parse_parameters,
    parse_range,
    payload_of,
    pose_arguments,
    pose_of,
    value_of,
)
from kinetostatics.cli.options import LOADS, POSE, ROBOT, Argument
from kinetostatics.cli.output import FIGURES, answer, check_files, save_files
from kinetostatics.exceptions import ArgumentError, KinetostaticsError
from kinetostatics.files.csv_tables import read_csv
from kinetostatics.progress import waiting
from kinetostatics.units import PLATFORM_KINDS

if TYPE_CHECKING:
    from kinetostatics.dynamics.trajectory import Trajectory
    from kinetostatics.kinematics.configuration import Configuration
    from kinetostatics.robot import Robot
#: Default number of frequencies of a response.
FREQUENCIES = 400
#: Options of ``new`` for suggested elastic parts; each group is tried in this order.
SUGGESTIONS = (("elastic", "joint_stiffness"), ("elastic",), ("joint_stiffness",))

# ---- analyze -------------------------------------------------------------------------------------------------------------

#: Sections of the report of one pose.
TABLES = (
    *("pose", "summary", "twist", "gravity", "sag", "parts", "stiffness"),
    *("forces", "limbs", "joints", "ground", "beams", "buckling"),
)


def _analyze(args: argparse.Namespace) -> int:
    with waiting("analyzing"):
        options, tool = loads_of(args), value_of("tool", args)
        warnings: list[str] = []
        check_files(args.out, ("csv", *FIGURES))
        robot = load_robot(args)
        if args.table is not None:
            if args.hinge_axis:
                raise ArgumentError("--hinge-axis is for one pose, not for --table")
            path = _trajectory(robot, args).analyze(**options)
            path = path if tool is None else path.at_point(tool)
            save_files(args.out, "path", path, **given_of(("what",), args))
            report = path.report()
        elif given := [name for name in ("out", "what", "samples") if getattr(args, name)]:
            raise ArgumentError(f"--{given[0]} is for a path: --table FILE")
        else:
            configuration, warnings = pose_of(robot, args)
            result = ANALYZE.called()(configuration, **options)
            axes = value_of("hinge_axis", args) or {}
            report = (result if tool is None else result.at_point(tool)).report(hinge_axes=axes)
        if not (args.full or args.json):
            report = report.only(*args.only) if args.only else report.brief()
        if not args.json:
            warnings = [*_rigid_advice(robot, args, options), *warnings]
    answer(report, args, warnings)
    return 0


def _trajectory(robot: Robot, args: argparse.Namespace) -> Trajectory:
    """Return the trajectory through the waypoints of ``--table``."""
    from kinetostatics.dynamics.trajectory import trajectory

    option, columns = _read_table(robot, args, timed=True)
    times = columns.pop("time")
    return trajectory(robot, times, **pose_arguments(robot, option, columns, args), **given_of(("samples",), args))


def _rigid_advice(robot: Robot, args: argparse.Namespace, loads: dict[str, Keyword]) -> list[str]:
    """Return a list with one warning if no part of the robot is elastic; otherwise an empty list.

    The warning contains commands that make the robot elastic and repeat the analysis of ``args``. They are given only if they
    make the compliance nonzero at the same pose and under the same loads.
    """
    if robot.description.elastic_links or robot.description.joint_stiffness:
        return []
    for options in SUGGESTIONS:
        if _makes_elastic(options, args, loads):
            commands = "".join(f"\n  {shlex.join(words)}" for words in _elastic_commands(options, args))
            return [f"nothing is elastic, so nothing sags; these commands make it elastic, as the file suggests:{commands}"]
    return ["nothing is elastic, so nothing sags: links get a <beam>, actuators a <joint_stiffness>"]


def _makes_elastic(options: tuple[str, ...], args: argparse.Namespace, loads: dict[str, Keyword]) -> bool:
    from kinetostatics.analysis import analyze
    from kinetostatics.authoring.from_urdf import SUGGESTED, extend_robot

    given: dict[str, Keyword] = {"platform_link": args.platform_link, "base_link": args.base_link}
    given |= dict.fromkeys(options, SUGGESTED)
    try:
        made = extend_robot(args.robot, parameters=parse_parameters(args.parameters), **given)
        return bool(analyze(pose_of(made, args)[0], **loads).compliance.any())
    except KinetostaticsError:
        return False


def _elastic_commands(options: tuple[str, ...], args: argparse.Namespace) -> tuple[list[str], list[str]]:
    """Return (words of the command that writes the elastic robot, words of the command that analyzes it)."""
    stem = os.path.basename(args.robot).partition(".")[0] + "_elastic"
    names = itertools.chain([stem], (f"{stem}_{k}" for k in itertools.count(2)))
    out = next(file for name in names if not os.path.exists(file := f"{name}.urdf.xacro"))
    made = ["kinetostatics", "new", "--from", args.robot]
    for option, value in (("--platform-link", args.platform_link), ("--base-link", args.base_link)):
        made += [option, value] if value is not None else []
    made += ["--set", *args.parameters] if args.parameters else []
    for name in options:
        made += [f"--{name.replace('_', '-')}", "suggested"]
    typed = args.command_line
    place = typed.index(args.robot, 2)
    return [*made, "--out", out], [*typed[:place], out, *typed[place + 1 :]]


ANALYZE = Command(
    _analyze,
    help="compute sag, stiffness, actuator forces, joint reactions and stresses at one pose or over a path",
    arguments=(*ROBOT, *POSE, *LOADS, "hinge_axis", "tool", "json"),
    function="analysis:analyze",
    own_arguments={
        "full": Argument("flag", "print all tables instead of the summary"),
        "only": Argument("texts", f"some tables: {', '.join(TABLES)}", "NAME"),
        "table": Argument("text", "a path instead of a pose: a CSV file of waypoints with their times", "FILE"),
        "samples": Argument("count", "least number of poses of the path (default: 201); every waypoint is one", "N", least=2),
        "what": Argument(
            "text", "quantity of the figure of the path, such as stress or torque_speed (default: displacement)", "QUANTITY"
        ),
        "out": Argument("texts", "write the path as a table (.csv) or a figure (.svg, .pdf, .png)", "FILE"),
    },
    exclusive=("full", "only"),
    notes=f"""\
{VALUES_HELP}
paths:
  The first line of --table names the time and coordinates of the platform, or all actuators: time [ms],z [mm],rx [deg],ry [deg].
  The robot moves smoothly through the waypoints of the other lines, at rest at the first and the last.
""",
    examples="""
analyze 3rps
analyze 3rps --only twist forces
analyze 3rps --platform z=500mm azimuth=-170deg tilt=10deg --orientation tilt_torsion
analyze 2pru_upr --actuators prismatic_1=20mm prismatic_2=0 prismatic_3=-5mm --load 0 0 -500 0 0 0
analyze panda.urdf --platform-link panda_hand             # a plain URDF, as it is
analyze 3rps --load 0 100 -500 0 0 0 --tool 0 0 200mm
analyze 2pru_upr --hinge-axis limb_1=x limb_2=x --gravity 0 0 9.8
analyze 3rps --payload 5kg --payload-center 0 0 -200mm --load-on rod_1 0 0 -50N 0 0 0
analyze delta --table path.csv --payload 500g --what actuator_torque --out peaks.csv torque.svg
analyze my_robot.urdf.xacro --set rod_diameter=80mm --gravity 0 0 0 --load 100 0 0 0 0 0 --json
""",
)


# ---- verify --------------------------------------------------------------------------------------------------------------


def _verify(args: argparse.Namespace) -> int:
    with waiting("verifying"):
        options = {**loads_of(args), **given_of(("modes", "within"), args)}
        configuration, warnings = pose_of(load_robot(args), args)
        verification = VERIFY.called()(configuration, **options)
    answer(verification, args, warnings)
    return 0 if verification.verified else 1


VERIFY = Command(
    _verify,
    help="check one pose against finite elements (OpenSeesPy)",
    description="Compute one pose twice, by screw theory and by finite elements (OpenSeesPy), and compare.",
    arguments=(*ROBOT, *POSE, *LOADS, "modes", "within", "json"),
    function="verification:verify",
    notes=f"""\
{VALUES_HELP}
exit code:
  0 verified, 1 not verified, 2 an error, such as OpenSeesPy missing: pip install 'kinetostatics[verify]'
""",
    examples="""
verify 3rps
verify 3rps --platform z=500mm azimuth=-170deg tilt=10deg --orientation tilt_torsion
verify 2pru_upr --load 100 0 -500 0 0 0 --point 0 0 20mm --frame platform --json
verify delta --payload 2kg --payload-center 0 0 -50mm --modes 3
""",
)


# ---- compensate ----------------------------------------------------------------------------------------------------------


def _compensate(args: argparse.Namespace) -> int:
    with waiting("compensating"):
        check_files(args.out, ("csv", "nc"))
        options = {**loads_of(args), **given_of(("controlled", "closure_tolerance", "tool"), args)}
        configuration, axes, warnings = _poses(load_robot(args), args)
        compensation = COMPENSATE.called()(configuration, **options)
        for path in args.out:
            compensation.save(path, axes)
    answer(compensation, args, warnings)
    return 0


def _poses(robot: Robot, args: argparse.Namespace) -> tuple[Configuration, dict[str, list[float]] | None, list[str]]:
    """Return (target poses, coordinates along the axes of their grid, warnings); the axes are None without a grid."""
    if args.table is not None:
        option, columns = _read_table(robot, args)
        return assembled(robot, option, columns, args), None, []
    option, given = grid_of(robot, args)
    axes = {name: value for name, value in given.items() if isinstance(value, list)}
    if not axes:
        configuration, warnings = pose_of(robot, args)
        return configuration, None, warnings
    if math.prod(len(values) for values in axes.values()) > MOST:
        raise ArgumentError(f"{option}: the grid has more than {MOST:,} poses")
    import numpy as np

    mesh = np.meshgrid(*axes.values(), indexing="ij")
    return assembled(robot, option, {**given, **dict(zip(axes, mesh, strict=True))}, args), axes, []


def _read_table(robot: Robot, args: argparse.Namespace, timed: bool = False) -> tuple[str, dict[str, list[float]]]:
    """Return (option, columns) of ``--table``; ``timed``: whether it also has a column "time".

    ``option``: "--platform" or "--actuators", whichever has the coordinates of the table. ``columns``: values by name, in SI.
    """
    if args.platform or args.actuators:
        raise ArgumentError("give either --table or coordinates, not both")
    time = ("time",) if timed else ()
    names = "time [s],z [mm],rx [deg]" if timed else "z [mm],rx [deg]"
    example = f"a table has a line of names, such as {names}, and below it a line for each pose"
    table = read_csv(args.table, example, (*time, *robot.description.actuated, *PLATFORM_KINDS), time)
    option = "--actuators" if any(name in robot.description.actuated for name in table.names) else "--platform"
    columns: dict[str, list[float]] = {name: [] for name in table.names}
    for line, row in table.rows:
        for name, cell in zip(table.names, row, strict=True):
            if not cell:
                raise ArgumentError(f"{table.where(line)}: {name} is missing: a cell is empty")
            kind = "time" if name in time else coordinate_kind(robot, option, name)
            columns[name] += parse_coordinates(table.where(line), name, [cell], kind)
    return option, columns


COMPENSATE = Command(
    _compensate,
    help="correct actuator positions for gravity and loads, with feedforward forces",
    description=(
        "Compute the actuator positions at which the loaded platform is at its target, the forces to feed forward\n"
        "there, and the pose error that remains."
    ),
    arguments=(*ROBOT, *POSE, "controlled", *LOADS, "tool", "json"),
    own_arguments={
        "table": Argument("text", "a CSV file of poses instead of --platform or --actuators", "FILE"),
        "out": Argument("texts", "write a table (.csv) or netCDF (.nc)", "FILE"),
    },
    function="compensation:compensate",
    grid=True,
    notes=f"""\
{VALUES_HELP}{GRID_HELP}
tables:
  The first line of --table names coordinates of the platform, or all actuators: z [mm],rx [deg],ry [deg]; the others are poses.
  --out FILE.csv has one line per pose: coordinates, status, corrected position, correction and force of each actuator, and the
  residual error. Cells without a correction are empty.
""",
    examples="""
compensate 3rps --platform z=500mm rx=3deg ry=0 --load 0 0 -500 0 0 0
compensate 3rps --platform z=450mm:650mm:5 rx=-10deg:10deg:9 ry=0 --load 0 0 -500 0 0 0 --out corrected.csv
compensate 2pru_upr --platform z=600mm rx=-5deg ry=-6deg --orientation XYZ --controlled z rx ry --json
compensate 3rps --load 0 100 -500 0 0 0 --tool 0 0 200mm --controlled x y z
compensate 3rps --platform z=0.5 rx=-10deg:10deg:21 ry=0 --load 0 0 -500 0 0 0 --out tilted.nc
plot tilted.nc --kind line --what residual_error:x uncorrected_error:x --out missed.svg
compensate 3rps --table path.csv --load 0 0 -500 0 0 0 --out corrected.nc
""",
)


# ---- modes ---------------------------------------------------------------------------------------------------------------


def _modes(args: argparse.Namespace) -> int:
    with waiting("computing modes"):
        check_files(args.out, ("npz", "mat", "json"))
        options = {**payload_of(args), **given_of(("count", "drives", "gravity"), args)}
        configuration, warnings = pose_of(load_robot(args), args)
        modes = MODES.called()(configuration, **options)
        for path in args.out:
            modes.state_space(**given_of(("inputs", "outputs", "damping"), args)).save(path)
    answer(modes, args, warnings)
    return 0


MODES = Command(
    _modes,
    help="compute natural frequencies and modes at one pose",
    description=(
        "Compute the lowest natural frequencies at one pose, with effective masses by direction and the shares of energy\n"
        "of every part. Beams vibrate as continuous rods: nothing is discretized, and no mode is missed."
    ),
    arguments=(*ROBOT, *POSE, "payload", "payload_center", "payload_link", "gravity", "drives", "json"),
    own_arguments={
        "count": Argument("count", "number of modes (default: 6)", "N"),
        "out": Argument("texts", "write the modes as a state-space model (.npz, .mat, .json)", "FILE"),
        "inputs": Argument("texts", "its inputs: o, links, elastic actuators, 'acceleration of floor' (default: o)", "NAME"),
        "outputs": Argument("texts", "its outputs: o, links, elastic actuators, or 'velocity of o' (default: o)", "NAME"),
        "damping": Argument("number", "its damping ratio (default: 0.02)", "ZETA"),
    },
    function="dynamics.vibrations:modes",
    notes=VALUES_HELP,
    examples="""
modes 3rps
modes 2pru_upr --platform z=600mm rx=-5deg ry=-6deg --orientation XYZ --count 10
modes delta --payload 2kg --payload-center 0 0 -50mm
modes ur10 --drives free --json
modes 3rps --count 12 --outputs o "velocity of o" --damping 0.01 --out model.mat
""",
)


# ---- response ------------------------------------------------------------------------------------------------------------


def _response(args: argparse.Namespace) -> int:
    with waiting("computing the frequency response"):
        import numpy as np

        check_files(args.out, ("csv", *FIGURES))
        options = {**payload_of(args), **given_of(("damping", "drives", "tool", "gravity"), args)}
        configuration, warnings = pose_of(load_robot(args), args)
        if args.frequencies is None:
            first, last, count = _range_of_modes(configuration, options)
        else:
            first, last, count = parse_range("--frequencies", "frequencies", args.frequencies)
        response = RESPONSE.called()(configuration, np.geomspace(first, last, count or FREQUENCIES), **options)
        save_files(args.out, "frequency_response", response, **given_of(("what", "components"), args))
    answer(response, args, warnings)
    return 0


def _range_of_modes(configuration: Configuration, options: dict[str, Keyword]) -> tuple[float, float, None]:
    """Return a tenth of the first natural frequency and twice the third one [Hz]."""
    import numpy as np

    from kinetostatics.dynamics.vibrations import modes

    shared = {name: value for name, value in options.items() if name not in ("damping", "tool")}
    frequencies = modes(configuration, 3, **shared).frequencies
    if not np.isfinite(frequencies[0]):
        raise ArgumentError("--frequencies is missing, and this pose has no natural frequency that would give a range")
    return float(frequencies[0]) / 10, 2 * float(np.nanmax(frequencies[np.isfinite(frequencies)])), None


RESPONSE = Command(
    _response,
    help="compute the frequency response of the platform: compliance, and transmissibility from the floor",
    description=(
        "Compute the response of the platform to harmonic forces on it, and to harmonic motion of the floor, at one pose.\n"
        "The dynamic stiffness is solved at each frequency: no modes are left out."
    ),
    arguments=(*ROBOT, *POSE, "payload", "payload_center", "payload_link", "gravity", "tool", "drives", "json"),
    own_arguments={
        "frequencies": Argument(
            "text",
            "frequencies [Hz], logarithmically spaced (default: from a tenth of the first natural frequency to twice the third; "
            f"COUNT: {FREQUENCIES})",
            "FIRST:LAST[:COUNT]",
        ),
        "damping": Argument("number", "damping ratio of all modes (default: 0.02)", "ZETA"),
        "what": Argument("text", "quantity of the figure (default: compliance)", choices=("compliance", "transmissibility")),
        "components": Argument("texts", "directions in a figure (default: x y z)", "NAME"),
        "out": Argument("texts", "write a figure (.svg, .pdf, .png) or a table (.csv)", "FILE"),
    },
    function="dynamics.vibrations:frequency_response",
    usage="ROBOT [options]",
    notes=VALUES_HELP,
    examples="""
response 3rps
response 3rps --frequencies 1:500 --out compliance.svg response.csv
response 3rps --frequencies 1:500:1000 --damping 0.01 --tool 0 0 200mm --what transmissibility --out floor.svg
response delta --frequencies 10:300 --payload 2kg --components rx ry rz --json
""",
)
