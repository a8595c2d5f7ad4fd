"""``kinetostatics tolerances``: what small errors of joints and beams do, ranked."""

from __future__ import annotations

import argparse

from kinetostatics.cli import answers, arguments, poses
from kinetostatics.printing.waiting import waiting

HELP = "rank what small errors of joints and beams do"
DESCRIPTION = (
    "Move every joint and lengthen and warm every beam a little, one after the other, at one pose without loads, "
    "and rank what that does to the platform and which forces it locks into the robot."
)
EXAMPLES = f"""\
{arguments.VALUES_HELP}
examples:
  kinetostatics tolerances 2pru_upr
  kinetostatics tolerances 2pru_upr --length 20um --angle 0.1mrad --by force --top 10
  kinetostatics tolerances 3rps --platform z=500mm rx=2deg ry=0 --json
  kinetostatics tolerances 3rps --tool 0 0 200mm
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    arguments.add_robot_arguments(parser)
    poses.add_pose_arguments(parser)
    parser.add_argument("--length", metavar="L", default="0.1mm", help="error of lengths (default: %(default)s)")
    parser.add_argument("--angle", metavar="A", default="1mrad", help="error of angles (default: %(default)s)")
    parser.add_argument(
        "--temperature", metavar="T", default="1", help="rise of one beam's temperature [K] (default: %(default)s)"
    )
    parser.add_argument("--by", metavar="WHAT", help="rank by force, displacement or rotation (default: force, if there is any)")
    parser.add_argument("--top", metavar="N", help="print the worst N only")
    arguments.add_tool_argument(parser, "tell how far this point moves instead of o")
    arguments.add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    """Print the table."""
    with waiting("trying errors one by one"):
        from dataclasses import replace

        from kinetostatics.error_ranking import tolerances

        amounts = {
            "length": arguments.parse_quantity(args.length, "length"),
            "angle": arguments.parse_quantity(args.angle, "angle"),
            "temperature": arguments.parse_quantity(args.temperature, "temperature"),
        }
        top = None if args.top is None else arguments.whole_number_of("--top", args.top)
        configuration, warnings = poses.assemble(arguments.load(args), args)
        found = tolerances(configuration, **amounts, by=args.by, tool=arguments.tool(args))
        if top is not None:
            found = replace(found, rows=found.rows[:top])
    answers.print_answer(found.to_dict() if args.json else str(found), warnings)
    return 0
