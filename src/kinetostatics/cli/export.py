"""``kinetostatics export``: a function of a robot as C for a controller."""

from __future__ import annotations

import argparse

from kinetostatics.cli.answers import print_report
from kinetostatics.cli.arguments import SEVERAL, add_robot_arguments, load
from kinetostatics.cli.poses import add_orientation_argument, near_pose
from kinetostatics.exceptions import ArgumentError
from kinetostatics.printing.waiting import waiting

HELP = "write C for a controller: pose, sag and actuator forces from coordinates, load and gravity"
DESCRIPTION = (
    "Write C99 for a controller, with header, C++ wrapper, test program, CMakeLists.txt and README: from "
    "coordinates of the platform or of the actuators, load and gravity to what is asked of the pose. It needs no heap and no "
    "library but libm, and closes the loops by bounded iterations from the last pose."
)
EXAMPLES = """\
examples:
  kinetostatics export 3rps --platform z rx ry --outputs actuator_forces twist --out controller
  kinetostatics export ur10 --outputs actuator_forces --out controller --scalar float
  kinetostatics export 3rps --platform z rx ry --compensate --out controller
  kinetostatics export 3rps --platform z rx ry --jacobian actuator_forces twist --by z rx ry load --out controller
  kinetostatics export 3rps --platform z azimuth tilt --orientation tilt_torsion --out controller
  kinetostatics export 3rps --platform z rx ry --near z=0.6 rx=0 ry=5deg --out controller
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    add_robot_arguments(parser)
    parser.add_argument(
        "--platform",
        nargs="+",
        metavar="NAME",
        help="platform coordinates that are inputs, as many as the mobility (default: the actuators' coordinates)",
    )
    parser.add_argument(
        "--near",
        metavar="NAME=VALUE",
        **SEVERAL,
        help="the pose, of the platform or of the actuators, where a state in C starts; it tells the assembly mode (default: the "
        "closed zero pose, which must not be singular)",
    )
    add_orientation_argument(parser)
    parser.add_argument(
        "--outputs",
        nargs="+",
        metavar="NAME",
        help="of twist, actuator_forces, actuators, stiffness and compliance, with --compensate also residual_error (default: "
        "actuator_forces twist, with --compensate actuators actuator_forces residual_error)",
    )
    parser.add_argument(
        "--compensate",
        action="store_true",
        help="the coordinates are those at which the loaded platform is to stand, the outputs are of the corrected pose: where "
        "to command the actuators, what to feed forward, what remains",
    )
    parser.add_argument(
        "--jacobian", nargs="+", metavar="NAME", help="outputs whose derivatives are written as one more function of C"
    )
    parser.add_argument(
        "--by", nargs="+", metavar="NAME", help="inputs by which the derivatives are: coordinates (all by default), load, gravity"
    )
    parser.add_argument("--out", metavar="FOLDER", required=True, help="where the files go")
    parser.add_argument("--scalar", metavar="TYPE", default="double", help="of arguments and results: double (default) or float")
    parser.add_argument("--name", metavar="NAME", help="what all names in C begin with (default: the robot's)")


def run(args: argparse.Namespace) -> int:
    """Write the files and say which."""
    if args.by and not args.jacobian:
        raise ArgumentError("--by says by what derivatives are; say of what with --jacobian")
    with waiting("recording the robot"):
        from kinetostatics.functions.function import Function, Jacobian, compile

        usual = ("actuators", "actuator_forces", "residual_error") if args.compensate else ("actuator_forces", "twist")
        robot = load(args)
        near = near_pose(robot, args.near, {"orientation": args.orientation}) if args.near else None
        function = compile(
            robot,
            args.platform,
            orientation=None if near and not args.platform else args.orientation,
            outputs=args.outputs or usual,
            compensate=args.compensate,
        )
        exported: Function | Jacobian = function
        if args.jacobian:
            by = args.by or [name for name in function.inputs if name not in ("load", "gravity")]
            exported = function.jacobian(args.jacobian, by)
        found = exported.export_c(args.out, args.scalar, args.name, near)
    lines = [f"wrote {', '.join(found.files)} to {found.folder}", *str(function).splitlines()[1:]]
    lines.append(
        f"  {found.operations[0]:,} operations a correction of the loops, {found.operations[1]:,} behind it, "
        f"{found.work:,} bytes of work on the stack"
    )
    print_report("\n".join(lines))
    return 0
