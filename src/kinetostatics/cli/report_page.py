"""Command report: a page on a robot at a pose and over its workspace."""

from __future__ import annotations

import argparse
import contextlib
import functools
from typing import TYPE_CHECKING

from kinetostatics.arguments import LOADS, POSE, ROBOT, Argument, Keyword
from kinetostatics.cli.answers import print_warnings
from kinetostatics.cli.commands import Command
from kinetostatics.cli.inputs import coordinate_kind, load_robot, loads_of, pose_of, swept_coordinates
from kinetostatics.cli.options import check_folder, given_of
from kinetostatics.cli.typed_values import GRID_HELP, VALUES_HELP, parse_values
from kinetostatics.exceptions import KinetostaticsError
from kinetostatics.progress import pausing, waiting

if TYPE_CHECKING:
    import xarray as xr

    from kinetostatics.kinematics.configuration import Configuration


def _report(args: argparse.Namespace) -> int:
    """Write the page on a robot."""
    with waiting("writing the report"):
        from kinetostatics.layout.renderings import html_path

        check_folder(html_path(args.out, "a report"))  # before the map is computed, which may take long
        loads = loads_of(args)
        configuration, warnings = pose_of(load_robot(args), args)
        with pausing():
            print_warnings(warnings)
        workspace = None
        if args.sweep:
            with contextlib.suppress(KinetostaticsError):  # without Matplotlib, a sentence replaces figures
                from kinetostatics.plot.style import draw_into_files

                draw_into_files()
            workspace = _map(configuration, args, loads)
        REPORT.called()(configuration, args.out, **loads, workspace=workspace, **given_of(("title", "controlled", "tool"), args))
    print(f"wrote {args.out}")
    return 0


def _map(configuration: Configuration, args: argparse.Namespace, loads: dict[str, Keyword]) -> xr.Dataset:
    """Return the workspace map over the coordinates of ``--sweep``; the other coordinates are those of the pose."""
    from kinetostatics.kinematics.alternatives import choices
    from kinetostatics.robot import robot_of
    from kinetostatics.workspace import sweep
    from kinetostatics.workspace.sweep_arguments import need

    need("xarray")
    robot = robot_of(configuration)
    option, swept, values = swept_coordinates(robot, args)
    if option == "--actuators":
        values = {**dict.fromkeys(robot.description.driven, 0.0), **values}
    elif not values:  # choose constant coordinates that determine the pose together with the varying ones
        together = next(iter(choices(robot, configuration.orientation, tuple(swept), robot.zero_poses)), ())
        values = {name: float(configuration.platform[name]) for name in together if set(swept) <= set(together)}
    kind = functools.partial(coordinate_kind, robot, option)
    grid: dict[str, object] = {name: parse_values("--sweep", name, text, kind(name)) for name, text in swept.items()}
    coordinates: dict[str, Keyword] = {option[2:]: grid | {name: value for name, value in values.items() if name not in grid}}
    options = given_of(("orientation", "closure_tolerance"), args)
    return sweep(robot, **coordinates, **loads, **options, command_line=args.command_line)


REPORT = Command(
    _report,
    help="write a page about a robot for reading and printing",
    description=(
        "Write one HTML page that a colleague can read and print: the robot, its assumptions, the pose in tables, sources of\n"
        "the sag, worst cases and maps of the workspace, corrections of the actuators, the comparison with finite elements,\n"
        "and a 3D view."
    ),
    arguments=(*ROBOT, *POSE, *LOADS, "tool", "controlled"),
    own={
        "out": Argument("text", "the page to write, .html", "FILE"),
        "title": Argument("text", "heading of the page (default: the robot's name)"),
        "sweep": Argument(
            "items",
            "coordinates of platform or actuators that vary over the workspace; the others are those of the pose (default: no "
            "map)",
            "NAME=VALUES",
        ),
    },
    function="report_page:save_report",
    required=("robot", "out"),
    usage="ROBOT --out FILE [options]",
    notes=f"{VALUES_HELP}{GRID_HELP}",
    examples="""
report 3rps --out report.html
report 3rps --platform z=500mm rx=3deg ry=0 --load 0 0 -500 0 0 0 --sweep rx=-15deg:15deg:13 ry=-15deg:15deg:13 --out report.html
report 3rps --load 0 100 -500 0 0 0 --tool 0 0 200mm --controlled x y z --out tip.html
report delta --payload 2kg --title "Delta with gripper" --out delta.html
""",
)
