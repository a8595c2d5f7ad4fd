"""``kinetostatics analyze``: sag, stiffness and forces at one pose."""

from __future__ import annotations

import argparse
from typing import Any

from kinetostatics.cli.arguments import (
    VALUES_HELP,
    add_json_argument,
    add_load_arguments,
    add_pose_arguments,
    add_robot_arguments,
    assemble,
    load,
    load_options,
    parse_items,
    print_json,
    print_warnings,
)
from kinetostatics.printing.waiting import waiting

NAME = "analyze"

EXAMPLES = f"""\
{VALUES_HELP}
examples:
  kinetostatics analyze 3rps
  kinetostatics analyze 3rps --platform z=500mm azimuth=-170deg tilt=10deg --orientation tilt_torsion
  kinetostatics analyze 2pru_upr --actuators prismatic_1=20mm prismatic_2=0 prismatic_3=-5mm --load 0 0 -500 0 0 0
  kinetostatics analyze 2pru_upr --hinge-axis limb_1=x limb_2=x --gravity 0 0 9.8
  kinetostatics analyze my_robot.urdf.xacro --set rod_diameter=80mm --gravity 0 0 0 --load 100 0 0 0 0 0 --json
"""


def add_parser(subparsers: Any) -> None:
    """Add the command to the parser."""
    parser: argparse.ArgumentParser = subparsers.add_parser(
        NAME,
        usage=f"kinetostatics {NAME} ROBOT [options]",
        help="compute sag, stiffness, drive forces, joint reactions and stresses at one pose",
        description="Compute sag, stiffness, drive forces, joint reactions and beam stresses at one pose.",
        epilog=EXAMPLES,
    )
    add_robot_arguments(parser)
    add_pose_arguments(parser)
    add_load_arguments(parser)
    parser.add_argument(
        "--hinge-axis",
        metavar="LIMB=x",
        nargs="+",
        default=[],
        help="limbs whose x axis, not y, is called the one along the first hinge in the table of limbs (the paper's PRU limbs)",
    )
    add_json_argument(parser)
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Print the analysis."""
    with waiting("analyzing"):
        from kinetostatics.analysis import analyze

        options = load_options(args)
        robot = load(args)
        configuration, warnings = assemble(robot, args)
        result = analyze(configuration, **options)
        axes = parse_items("--hinge-axis", args.hinge_axis)
        text, found = ("", result.to_dict()) if args.json else (result.report(hinge_axes=axes), {})
    if args.json:
        found["warnings"] = [*warnings, *found["warnings"]]
        print_json(found)
        print_warnings(found["warnings"])
    else:
        print("\n".join([*(f"! {warning}" for warning in warnings), text]))
    return 0
