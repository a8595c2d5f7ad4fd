"""Commands on single robots: check, report, export to C, and robots."""

from __future__ import annotations

import argparse
import contextlib
import functools
from typing import TYPE_CHECKING

from kinetostatics.arguments import Keyword
from kinetostatics.cli.commands import Command
from kinetostatics.cli.inputs import (
    GRID_HELP,
    VALUES_HELP,
    coordinate_kind,
    given_of,
    load_robot,
    loads_of,
    near_pose,
    parse_values,
    pose_of,
    swept_coordinates,
)
from kinetostatics.cli.options import LOADS, POSE, ROBOT, Argument
from kinetostatics.cli.output import check_folder, print_json, print_report, print_warnings
from kinetostatics.exceptions import ArgumentError, KinetostaticsError
from kinetostatics.files.bundled import copy_robots, robots
from kinetostatics.progress import pausing, waiting

if TYPE_CHECKING:
    import xarray as xr

    from kinetostatics.kinematics.configuration import Configuration

# ---- check ---------------------------------------------------------------------------------------------------------------


def _check(args: argparse.Namespace) -> int:
    with waiting("checking"):
        report = CHECK.called()(load_robot(args))
        facts = report.to_dict()
    if args.json:
        print_json(facts)
        print_warnings([*facts["problems"], *facts["warnings"]])
    else:
        print_report(report)
    return 1 if facts["problems"] else 0


CHECK = Command(
    _check,
    help="describe a robot file: mobility, limbs, wrenches, beams, warnings",
    description=(
        "Describe a robot file: mobility and redundant constraints, every limb from base to platform with its constraint\n"
        "wrenches, beams, elastic joints, masses, and probable input errors."
    ),
    arguments=(*ROBOT, "json"),
    function="reports.robot:robot_report",
    notes="exit code:\n  0 the robot can be analysed, 1 it cannot (its loops do not close), 2 the file is wrong\n",
    examples="""
check 3rps
check my_robot.urdf.xacro --set rod_diameter=80mm --json
check panda.urdf --platform-link panda_hand               # a plain URDF, as it is
""",
)


# ---- export --------------------------------------------------------------------------------------------------------------


def _export(args: argparse.Namespace) -> int:
    if args.with_respect_to and not args.jacobian:
        raise ArgumentError("--by names the inputs of derivatives; name the outputs to differentiate with --jacobian")
    with waiting("recording the robot"):
        robot = load_robot(args)
        orientation = given_of(("orientation",), args)
        near = near_pose(robot, args.near, orientation) if args.near else None
        usual = ["actuators", "actuator_forces"] if args.compensate or args.ros2 else ["actuator_forces", "twist"]
        usual += ["residual_error"] if args.compensate else []
        options = {} if near and not args.inputs else orientation
        function = EXPORT.called()(
            robot, args.inputs or None, outputs=args.outputs or usual, compensate=args.compensate, **options
        )
        exported = function
        if args.jacobian:
            inputs = [name for name in function.inputs if name not in ("load", "gravity")]
            exported = function.jacobian(args.jacobian, args.with_respect_to or inputs)
        if args.fmu or args.fmi or args.ros2:
            if args.jacobian or args.scalar:
                raise ArgumentError(f"{'--ros2' if args.ros2 else '--fmu'} takes neither --jacobian nor --scalar")
            if args.ros2:
                function.export_ros2(args.out, near=near, **given_of(("name",), args))
            else:
                function.export_fmu(args.out, near=near, **given_of(("name", "fmi"), args))
            print(f"wrote {args.out}")
            return 0
        code = exported.export_c(args.out, near=near, **given_of(("scalar", "name"), args))
    lines = [f"wrote {', '.join(code.files)} to {code.folder}", *str(function).splitlines()[1:]]
    lines.append(
        f"  {code.operations[0]:,} operations per correction of the loops, {code.operations[1]:,} for the analysis, "
        f"{code.work:,} bytes of work on the stack"
    )
    print("\n".join(lines))
    return 0


EXPORT = Command(
    _export,
    help="write C for a controller: pose, sag and actuator forces from coordinates, load and gravity",
    description=(
        "Write C99 code for a controller, with header, C++ wrapper, test program, CMakeLists.txt and README. The code computes\n"
        "quantities of the pose from load, gravity, and coordinates of the platform or of the actuators. It needs no heap and\n"
        "no library except libm, and closes the loops by a bounded number of iterations from the last pose."
    ),
    arguments=(*ROBOT, "near", "orientation"),
    own_arguments={
        "inputs": Argument(
            "texts",
            "platform coordinates that are inputs, as many as the mobility (default: the actuators' coordinates)",
            "NAME",
            option="--platform",
        ),
        "outputs": Argument(
            "texts",
            "twist, actuator_forces, actuators, stiffness, compliance; with --compensate also residual_error (default: "
            "actuator_forces twist, with --compensate actuators actuator_forces residual_error)",
            "NAME",
        ),
        "compensate": Argument(
            "flag",
            "the coordinates are the target of the loaded platform, the outputs those of the corrected pose: actuators, "
            "actuator_forces to feed forward, residual_error",
        ),
        "jacobian": Argument("texts", "outputs whose derivatives are exported as another function", "NAME"),
        "with_respect_to": Argument(
            "texts", "inputs of the derivatives: coordinates (default: all of them), load, gravity", "NAME", option="--by"
        ),
        "scalar": Argument("text", "type of arguments and results: double (default) or float", "TYPE"),
        "fmu": Argument("flag", "write a functional mock-up unit (FMI, co-simulation, sources) instead: --out robot.fmu"),
        "fmi": Argument("count", "version of the unit's standard: 3 (default) or 2", "N"),
        "ros2": Argument("flag", "write a ROS 2 package with controllers of ros2_control instead"),
        "name": Argument("text", "prefix of all names in C (default: the robot's name)", "NAME"),
        "out": Argument("text", "the folder of the files, or the .fmu file", "FOLDER"),
    },
    function="functions.compiling:compile",
    required=("robot", "out"),
    usage="ROBOT --out FOLDER [options]",
    examples="""
export 3rps --platform z rx ry --outputs actuator_forces twist --out controller
export 3rps --platform z rx ry --fmu --out robot.fmu
export 3rps --platform z rx ry --compensate --ros2 --out 3rps_control
export ur10 --outputs actuator_forces --out controller --scalar float
export 3rps --platform z rx ry --compensate --out controller
export 3rps --platform z rx ry --jacobian actuator_forces twist --by z rx ry load --out controller
export 3rps --platform z azimuth tilt --orientation tilt_torsion --out controller
export 3rps --platform z rx ry --near z=0.6 rx=0 ry=5deg --out controller
""",
)


# ---- robots --------------------------------------------------------------------------------------------------------------


def _robots(args: argparse.Namespace) -> int:
    if args.copy:
        copies = [path.as_posix() for path in copy_robots(args.copy)]
        if args.json:
            print_json({"copied": copies})
        else:
            print("\n".join(f"wrote {name}" for name in copies))
    elif args.json:
        print_json(robots())
    else:
        print(robots())
    return 0


ROBOTS = Command(
    _robots,
    help="list the robots of the package, or copy their files",
    description="List the robots of the package; their names serve as ROBOT in every command.",
    arguments=("json",),
    own_arguments={"copy": Argument("texts", "copy the files of these robots to the current folder", "NAME")},
    function="files.bundled:robots",
    usage="[options]",
    examples="""
robots
robots --copy delta
""",
)


# ---- report ----------------------------------------------------------------------------------------------------------


def _report(args: argparse.Namespace) -> int:
    with waiting("writing the report"):
        from kinetostatics.layout.renderings import html_path

        check_folder(html_path(args.out))  # before long computations
        loads = loads_of(args)
        configuration, warnings = pose_of(load_robot(args), args)
        with pausing():
            print_warnings(warnings)
        workspace = None
        if args.sweep:
            with contextlib.suppress(KinetostaticsError):  # without Matplotlib, the page has a sentence in place of the figures
                from kinetostatics.plot.style import draw_into_files

                draw_into_files()
            workspace = _map(configuration, args, loads)
        REPORT.called()(configuration, args.out, **loads, workspace=workspace, **given_of(("title", "controlled", "tool"), args))
    print(f"wrote {args.out}")
    return 0


def _map(configuration: Configuration, args: argparse.Namespace, loads: dict[str, Keyword]) -> xr.Dataset:
    """Return the map over the coordinates of ``--sweep``; the constant coordinates have their values at the pose."""
    from kinetostatics.kinematics.alternatives import choices
    from kinetostatics.robot import robot_of
    from kinetostatics.workspace import sweep

    robot = robot_of(configuration)
    option, swept, values = swept_coordinates(robot, args)
    if option == "--actuators":
        values = {**dict.fromkeys(robot.description.actuated, 0.0), **values}
    elif not values:  # constant coordinates that, with the varying ones, determine the pose
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
    own_arguments={
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
