"""``kinetostatics report``: one page about a robot at a pose and over its workspace, for a colleague to read and print."""

from __future__ import annotations

import argparse
import contextlib
import functools
from typing import TYPE_CHECKING

from kinetostatics.argument_checks import Keyword
from kinetostatics.cli import answers, arguments, poses
from kinetostatics.exceptions import ArgumentError, KinetostaticsError
from kinetostatics.printing.waiting import pausing, waiting

if TYPE_CHECKING:
    import xarray as xr

    from kinetostatics.kinematics.configuration import Configuration

USAGE = "ROBOT --out FILE [options]"
HELP = "write one page about a robot, to be read and printed"
DESCRIPTION = (
    "Write one HTML page that a colleague can read and print: the robot, what is assumed, the pose in tables,\n"
    "where the sag comes from, worst cases and maps of the workspace, corrections of the actuators, the verdict of finite\n"
    "elements, and the robot to look at from all sides."
)
EXAMPLES = f"""\
{arguments.VALUES_HELP}
  FROM:TO:COUNT and A,B,C of --sweep are dimensions of a grid, whose poses are all combinations of their values.

examples:
  kinetostatics report 3rps --out report.html
  kinetostatics report 3rps --platform z=500mm rx=3deg ry=0 --load 0 0 -500 0 0 0 --sweep rx=-15deg:15deg:13 ry=-15deg:15deg:13 \
--out report.html
  kinetostatics report 3rps --load 0 100 -500 0 0 0 --tool 0 0 200mm --controlled x y z --out tip.html
  kinetostatics report delta --payload 2kg --title "Delta with gripper" --out delta.html
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    arguments.add_robot_arguments(parser)
    poses.add_pose_arguments(parser)
    arguments.add_load_arguments(parser)
    arguments.add_engine_argument(parser)
    group = parser.add_argument_group("report")
    group.add_argument("--out", metavar="FILE", required=True, help="the page to write, .html")
    group.add_argument("--title", metavar="TEXT", help="heading of the page (default: the robot's name)")
    group.add_argument(
        "--sweep",
        metavar="NAME=VALUES",
        **arguments.SEVERAL,
        help="coordinates of platform or actuators that vary over the workspace, as of kinetostatics sweep; the others are those "
        "of the pose (default: no map of the workspace)",
    )
    arguments.add_tool_argument(group, "tell of this point instead of o, and correct it")
    group.add_argument(
        "--controlled",
        metavar="NAME",
        nargs="+",
        help="coordinates of the platform that the actuators are to correct, as many as the mobility (default: those of "
        "--platform)",
    )


def run(args: argparse.Namespace) -> int:
    """Write the page."""
    with waiting("writing the report"):
        from kinetostatics.printing.html import html_path
        from kinetostatics.report_page import save_report

        arguments.check_folder(html_path(args.out, "a report"))  # a map of the workspace may take long
        options = {**arguments.load_options(args), "engine": args.engine}
        robot = arguments.load(args)
        configuration, warnings = poses.assemble(robot, args)
        with pausing():
            answers.print_warnings(warnings)
        workspace = None
        if args.sweep:
            with contextlib.suppress(KinetostaticsError):  # the page has a sentence in place of figures without Matplotlib
                from kinetostatics.plot.style import draw_into_files

                draw_into_files()
            workspace = _map(configuration, args, options)
        page = {"title": args.title, "controlled": args.controlled, "tool": arguments.tool(args)}
        save_report(configuration, args.out, **options, workspace=workspace, **page)
    print(f"wrote {args.out}")
    return 0


def _map(configuration: Configuration, args: argparse.Namespace, options: dict[str, Keyword]) -> xr.Dataset:
    """Return the map over the coordinates of ``--sweep``, the others as the pose has them."""
    from kinetostatics.kinematics.coordinate_choices import choices
    from kinetostatics.robot import robot_of
    from kinetostatics.workspace import sweep
    from kinetostatics.workspace.arguments import need

    need("xarray")
    robot = robot_of(configuration)
    swept = arguments.parse_items("--sweep", args.sweep)
    actuators = [name for name in swept if name in robot.description.driven]
    if actuators and len(actuators) < len(swept):
        raise ArgumentError("--sweep: coordinates of actuators and of the platform cannot make one grid")
    option, other = ("--actuators", "--platform") if actuators else ("--platform", "--actuators")
    if getattr(args, other[2:]):
        raise ArgumentError(f"--sweep: the coordinates that do not vary are given by {option}")
    kind = functools.partial(poses.coordinate_kind, robot, option)
    values = poses.single_values(robot, option, getattr(args, option[2:]))
    if actuators:
        values = {**dict.fromkeys(robot.description.driven, 0.0), **values}
    elif not values:  # nobody has said which coordinates those of the pose are: such as go with those that vary
        together = next(iter(choices(robot, configuration.orientation, tuple(swept), robot.zero_poses)), ())
        values = {name: float(configuration.platform[name]) for name in together if set(swept) <= set(together)}
    grid = {name: arguments.parse_values("--sweep", name, text, kind(name)) for name, text in swept.items()}
    of: dict[str, Keyword] = {option[2:]: {**grid, **{name: value for name, value in values.items() if name not in grid}}}
    return sweep(
        robot,
        **of,
        **options,
        orientation=args.orientation,
        closure_tolerance=poses.closure_tolerance_of(args),
        command_line=args.command_line,
    )
