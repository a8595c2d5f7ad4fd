"""``kinetostatics new``: a robot file from the field's notation."""

from __future__ import annotations

import argparse
import os
import sys
from typing import Any

from kinetostatics.cli.arguments import SEVERAL, add_command, number_of, parse_items, parse_parameters, print_warnings
from kinetostatics.exceptions import ArgumentError
from kinetostatics.printing.waiting import waiting

NAME = "new"

EXAMPLES = """\
architecture:
  Limbs are strings of joints from base to platform: R revolute, P prismatic, C cylindrical, U universal, S spherical,
  (4S) two rods between spherical joints, (4R) a parallelogram. Drives stand in brackets; without any the usual ones are
  taken. Limbs are joined by +, and 3- stands for three alike.

    3-R[P]S          three telescopes, as the paper's 3RPS
    2-[P]RU+U[P]R    two rods on sliders and a telescope
    6-U[P]S          Gough-Stewart platform
    3-U[P]S+UP       Tricept: the tube in the middle is passive
    3-[R](4S)        Delta: cranks and pairs of rods
    3-[P]UU          linear Delta with one rod in each limb
    3-[R]RR          planar, with --arrangement planar
    3-[P]RRR         Tripteron, with --arrangement cartesian

examples:
  kinetostatics new "3-R[P]S" --base-radius 0.25 --platform-radius 0.2 --height 0.55 --out my_robot.urdf.xacro
  kinetostatics new "3-[R](4S)" --height=-0.6 --section rod="tube 14mm 11mm carbon" --out my_delta.urdf.xacro
  kinetostatics new "2-U[P]R+S[P]R" --placements table.csv --out my_exechon.urdf.xacro

exit code:
  0 written, 2 something is wrong
"""


def add_parser(subparsers: Any) -> None:
    """Add the command to the parser."""
    parser = add_command(
        subparsers,
        NAME,
        run,
        usage="ARCHITECTURE [options]",
        help="make a robot file from the field's notation, such as 3-R[P]S",
        description="Make a robot file from the field's notation of limbs and joints; it is commented and ready to be edited.",
        epilog=EXAMPLES,
    )
    parser.add_argument("architecture", metavar="ARCHITECTURE", help="the limbs, such as 3-R[P]S; see below")
    parser.add_argument("--base-radius", metavar="LENGTH", help="O to the limbs' base points (default: 0.3 m)")
    parser.add_argument("--platform-radius", metavar="LENGTH", help="o to their platform points (default: 0.2 m)")
    parser.add_argument("--height", metavar="LENGTH", help="of the platform above the base (default: 0.5 m; planar: 0)")
    parser.add_argument(
        "--arrangement",
        metavar="WORD",
        default="symmetric",
        help="symmetric (around Z, default), planar, or cartesian (along X, Y, Z)",
    )
    parser.add_argument(
        "--azimuths", metavar="ANGLE", nargs="+", help="of the limbs around Z, instead of even ones: 90deg -90deg 0"
    )
    parser.add_argument(
        "--placements",
        metavar="CSV",
        help="table of the limbs' points instead, with columns base_x … platform_z, and axis_x …, guide_x … if need be",
    )
    parser.add_argument("--guide", metavar="WORD", help="direction of carriages: vertical, radial or tangential")
    parser.add_argument(
        "--axis", metavar="WORD", help="direction of revolute axes: radial, tangential or vertical (default: across the limb)"
    )
    parser.add_argument(
        "--section",
        metavar="ROLE=SECTION",
        **SEVERAL,
        help='of beams: rod="tube 60mm 50mm steel" crank="rectangle 20mm 60mm aluminium"',
    )
    parser.add_argument(
        "--set",
        dest="parameters",
        metavar="NAME=VALUE",
        **SEVERAL,
        help="any other value of the file, such as stroke=100mm platform_mass=12 rod_length=0.8",
    )
    parser.add_argument("--name", metavar="NAME", help="of the robot (default: that of the file)")
    parser.add_argument("--out", "-o", metavar="FILE", help="the file to write (default: print it)")


def run(args: argparse.Namespace) -> int:
    """Write the robot file."""
    if args.out is not None and os.path.exists(args.out):
        raise ArgumentError(f"--out: {args.out} exists already; delete it or choose another name")
    folder = os.path.dirname(args.out or "")
    if folder and not os.path.isdir(folder):
        raise ArgumentError(f"--out: there is no folder {folder}")
    with waiting("building the robot"):
        from kinetostatics.authoring.notation import parse_architecture
        from kinetostatics.authoring.robot_by_name import new_robot, robot_text

        architecture = parse_architecture(args.architecture)
        options = _options(args)
        if args.out is None:
            sys.stdout.write(robot_text(args.architecture, **options))
            return 0
        robot = new_robot(args.architecture, args.out, **options)
    driven = ", ".join(robot.description.driven)
    chosen = " (the usual ones, as none was marked)" if architecture.drives_chosen else ""
    print(f"{args.out}: {architecture.text}, mobility {robot.mobility.platform}, driven: {driven}{chosen}")
    print_warnings(robot.description.warnings)
    return 0


def _options(args: argparse.Namespace) -> dict[str, Any]:
    lengths = {
        name: None
        if getattr(args, name) is None
        else number_of(f"--{name.replace('_', '-')}", getattr(args, name).strip(), "length")
        for name in ("base_radius", "platform_radius", "height")
    }
    azimuths = None if args.azimuths is None else [number_of("--azimuths", text.strip(), "angle") for text in args.azimuths]
    return {
        **lengths,
        "arrangement": args.arrangement,
        "azimuths": azimuths,
        "placements": args.placements,
        "guide": args.guide,
        "axis": args.axis,
        "sections": parse_items("--section", args.section),
        "name": args.name,
        **parse_parameters(args.parameters),
    }
