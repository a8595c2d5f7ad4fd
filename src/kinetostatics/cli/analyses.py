"""Commands on the statics of poses: analyze, verify, compensate."""

from __future__ import annotations

import argparse
import math
from typing import TYPE_CHECKING

from kinetostatics.arguments import LOADS, POSE, ROBOT, Argument
from kinetostatics.cli.answers import answer, save_files
from kinetostatics.cli.commands import Command
from kinetostatics.cli.inputs import assembled, coordinate_kind, grid_of, load_robot, loads_of, pose_of, where_of
from kinetostatics.cli.options import FIGURES, check_files, given_of, value_of
from kinetostatics.cli.rigid import rigid_advice
from kinetostatics.cli.typed_values import GRID_HELP, MOST, VALUES_HELP, parse_coordinates
from kinetostatics.description.units import PLATFORM_KINDS
from kinetostatics.exceptions import ArgumentError
from kinetostatics.files.csv_tables import read_csv
from kinetostatics.progress import waiting

if TYPE_CHECKING:
    from kinetostatics.dynamics.trajectory import Trajectory
    from kinetostatics.kinematics.configuration import Configuration
    from kinetostatics.robot import Robot


# ---- analyze -------------------------------------------------------------------------------------------------------------

#: Sections of the report of one pose.
TABLES = (
    *("pose", "summary", "twist", "gravity", "sag", "parts", "stiffness"),
    *("forces", "limbs", "joints", "ground", "beams", "buckling"),
)


def _analyze(args: argparse.Namespace) -> int:
    """Print the analysis of a pose or a path; the analysis of a path may also be written to files."""
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
        elif args.out or args.what:
            raise ArgumentError(f"--{'out' if args.out else 'what'} is for a path: --table FILE")
        else:
            configuration, warnings = pose_of(robot, args)
            result = ANALYZE.called()(configuration, **options)
            axes = value_of("hinge_axis", args) or {}
            report = (result if tool is None else result.at_point(tool)).report(hinge_axes=axes)
        if not (args.full or args.json):
            report = report.only(*args.only) if args.only else report.brief()
        if not args.json:
            warnings = [*rigid_advice(robot, args, options), *warnings]
    answer(report.to_dict() if args.json else report, warnings, args.out)
    return 0


def _trajectory(robot: Robot, args: argparse.Namespace) -> Trajectory:
    """Return the motion through the poses of ``--table``."""
    from kinetostatics.dynamics.trajectory import trajectory

    option, columns = _read_table(robot, args, timed=True)
    times = columns.pop("time")
    return trajectory(robot, times, **where_of(robot, option, columns, args))


ANALYZE = Command(
    _analyze,
    help="compute sag, stiffness, actuator forces, joint reactions and stresses at one pose or over a path",
    arguments=(*ROBOT, *POSE, *LOADS, "hinge_axis", "tool", "json"),
    function="analysis:analyze",
    own={
        "full": Argument("flag", "print all tables instead of the summary"),
        "only": Argument("texts", f"some tables: {', '.join(TABLES)}", "NAME"),
        "table": Argument("text", "a path instead of a pose: a CSV file of waypoints with their times", "FILE"),
        "what": Argument(
            "text", "what a figure of the path shows, as stress or torque_speed (default: displacement)", "QUANTITY"
        ),
        "out": Argument("texts", "write the path as a table (.csv) or a figure (.svg, .pdf, .png)", "FILE"),
    },
    exclusive=("full", "only"),
    notes=f"""\
{VALUES_HELP}paths:
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
    """Print the results of both methods and the verdict."""
    with waiting("verifying"):
        options = {**loads_of(args), **given_of(("modes", "within"), args)}
        configuration, warnings = pose_of(load_robot(args), args)
        found = VERIFY.called()(configuration, **options)
    answer(found.to_dict() if args.json else found.report(), warnings)
    return 0 if found.verified else 1


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
    """Print the corrections, and write them to files."""
    with waiting("compensating"):
        check_files(args.out, ("csv", "nc"))
        options = {**loads_of(args), **given_of(("controlled", "closure_tolerance", "tool"), args)}
        configuration, axes, warnings = _poses(load_robot(args), args)
        found = COMPENSATE.called()(configuration, **options)
        for path in args.out:
            found.save(path, axes)
        shown = found.to_dict() if args.json else found.report()
    answer(shown, warnings, args.out)
    return 0


def _poses(robot: Robot, args: argparse.Namespace) -> tuple[Configuration, dict[str, list[float]] | None, list[str]]:
    """Return the target poses, names and values of the axes if they form a grid, and warnings."""
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
    """Return whether the columns of ``--table`` are ``--platform`` or ``--actuators``, and their values in SI; or also "time".

    Raises:
        ArgumentError: coordinates are given twice, or a title or a cell is invalid; the message names file and line.
    """
    if args.platform or args.actuators:
        raise ArgumentError("give either --table or coordinates, not both")
    time = ("time",) if timed else ()
    example = f"a table has a line of names, such as {'time [s],' * timed}z [mm],rx [deg], and below it a line for each pose"
    table = read_csv(args.table, example, (*time, *robot.description.driven, *PLATFORM_KINDS), time)
    option = "--actuators" if any(name in robot.description.driven for name in table.names) else "--platform"
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
    own={
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
