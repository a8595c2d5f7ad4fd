"""``kinetostatics compensate``: feedforward forces and corrected actuator positions, of one pose, a grid or a table of poses."""

from __future__ import annotations

import argparse
import math
from typing import TYPE_CHECKING

from kinetostatics.cli import answers, arguments, poses
from kinetostatics.description.units import PLATFORM_KINDS
from kinetostatics.exceptions import ArgumentError
from kinetostatics.files.csv_tables import read_csv
from kinetostatics.printing.waiting import waiting

if TYPE_CHECKING:
    from kinetostatics.kinematics.configuration import Configuration
    from kinetostatics.robot import Robot


HELP = "correct actuator positions for gravity and loads, with the forces to feed forward"
DESCRIPTION = (
    "Find where to command the actuators so that the loaded platform stands where it was asked to, which forces\n"
    "they must hold there, and what no actuator can correct."
)
EXAMPLES = f"""\
{arguments.VALUES_HELP}
  FROM:TO:COUNT and A,B,C make a grid, whose poses are all combinations of their values.

tables:
  The first line of --table names coordinates of the platform, or all actuators: z [mm],rx [deg],ry [deg]; the others are poses.
  --out FILE.csv has one line a pose: coordinates, status, and of each actuator corrected position, correction and force; last
  what remains. Cells are empty where there is no correction. --out FILE.nc is netCDF.

examples:
  kinetostatics compensate 3rps --platform z=500mm rx=3deg ry=0 --load 0 0 -500 0 0 0
  kinetostatics compensate 3rps --platform z=450mm:650mm:5 rx=-10deg:10deg:9 ry=0 --load 0 0 -500 0 0 0 --out corrected.csv
  kinetostatics compensate 2pru_upr --platform z=600mm rx=-5deg ry=-6deg --orientation XYZ --controlled z rx ry --json
  kinetostatics compensate 3rps --load 0 100 -500 0 0 0 --tool 0 0 200mm --controlled x y z
  kinetostatics compensate 3rps --platform z=0.5 rx=-10deg:10deg:21 ry=0 --load 0 0 -500 0 0 0 --out tilted.nc
  kinetostatics plot tilted.nc --kind line --what residual_error:x uncorrected_error:x --out missed.svg
  kinetostatics compensate 3rps --table path.csv --load 0 0 -500 0 0 0 --out corrected.nc
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    arguments.add_robot_arguments(parser)
    poses.add_pose_arguments(parser, "VALUES")
    parser.add_argument("--table", metavar="FILE", help="a CSV file of poses instead of --platform or --actuators")
    parser.add_argument(
        "--controlled",
        metavar="NAME",
        nargs="+",
        help="coordinates of the platform that are to come out as wanted, as many as the mobility (default: those of --platform)",
    )
    arguments.add_load_arguments(parser)
    arguments.add_tool_argument(parser, "x, y and z of --controlled, and what remains, are those of this point instead of o")
    arguments.add_engine_argument(parser)
    parser.add_argument("--out", metavar="FILE", help="write a table (.csv) or netCDF (.nc)")
    arguments.add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    """Print the corrections, or write them to a file."""
    with waiting("compensating"):
        from kinetostatics.compensation import compensate

        arguments.check_folder(args.out)
        options = arguments.load_options(args)
        robot = arguments.load(args)
        configuration, axes, warnings = _poses(robot, args)
        found = compensate(
            configuration,
            **options,
            controlled=args.controlled,
            closure_tolerance=poses.closure_tolerance_of(args),
            engine=args.engine,
            tool=arguments.tool(args),
        )
        if args.out is not None:
            found.save(args.out, axes)
        answer = found.to_dict() if args.json else str(found)
    answers.print_answer(answer, warnings, args.out)
    return 0


def _poses(robot: Robot, args: argparse.Namespace) -> tuple[Configuration, dict[str, list[float]] | None, list[str]]:
    """Return the wanted poses, names and values of the axes of their grid if they are one, and warnings."""
    if args.table is not None:
        if args.platform or args.actuators:
            raise ArgumentError("give either --table or coordinates, not both")
        option, columns = _read_table(robot, args.table)
        return poses.assembled(robot, option, columns, args), None, []
    option, given = poses.grid(robot, args)
    axes = {name: value for name, value in given.items() if isinstance(value, list)}
    if not axes:
        configuration, warnings = poses.assemble(robot, args)
        return configuration, None, warnings
    if math.prod(len(values) for values in axes.values()) > arguments.MOST:
        raise ArgumentError(f"{option}: the grid has more than {arguments.MOST:,} poses")
    import numpy as np

    mesh = np.meshgrid(*axes.values(), indexing="ij")
    coordinates = {**given, **dict(zip(axes, mesh, strict=True))}
    return poses.assembled(robot, option, coordinates, args), axes, []


def _read_table(robot: Robot, path: str) -> tuple[str, dict[str, list[float]]]:
    """Return whether the columns of a table are ``--platform`` or ``--actuators``, and their values in SI.

    Raises:
        ArgumentError: a title or a cell makes no sense; the message names file and line.
    """
    example = "a table has a line of names, such as z [mm],rx [deg], and below it a line for each pose"
    table = read_csv(path, example, (*robot.description.driven, *PLATFORM_KINDS))
    option = "--actuators" if any(name in robot.description.driven for name in table.names) else "--platform"
    columns: dict[str, list[float]] = {name: [] for name in table.names}
    for line, row in table.rows:
        for name, cell in zip(table.names, row, strict=True):
            if not cell:
                raise ArgumentError(f"{table.where(line)}: {name} is missing: a cell is empty")
            columns[name] += arguments.parse_coordinates(
                table.where(line), name, [cell], poses.coordinate_kind(robot, option, name)
            )
    return option, columns
