"""``kinetostatics spread``: how much robots of one design differ, as their parts have tolerances."""

from __future__ import annotations

import argparse

from kinetostatics.cli import answers, arguments, poses
from kinetostatics.printing.waiting import waiting

USAGE = "ROBOT --off NAME=TOLERANCE … [options]"
HELP = "how much robots of one design differ, as their parts have tolerances"
DESCRIPTION = (
    "Find worst case and standard deviation of sag, stiffness and actuator forces at one pose, to first order, and\n"
    "compute thousands of robots whose parameters are off at random."
)
EXAMPLES = f"""\
{arguments.VALUES_HELP}
  A tolerance is to either side, with a unit or as a part of the value: 0.1mm, 2%.

parameters:
  xacro arguments of the file, which change all that it computes from them: rod_diameter
  numbers of single parts, each off by itself: rod_1.outer_diameter, platform.mass, revolute_1.placement.x; * stands for anything

examples:
  kinetostatics spread 3rps --off rod_diameter=0.1mm youngs_modulus=3% --load 0 0 -500 0 0 0
  kinetostatics spread 3rps --off 'rod_*.outer_diameter=0.1mm' --load 0 100 -500 0 0 0 --tool 0 0 200mm
  kinetostatics spread 2pru_upr --off 'rod_*.outer_diameter=0.1mm' platform.mass=1% --json
  kinetostatics spread 3rps --off 'revolute_*.placement.[xyz]=0.05mm' --what prismatic_1 --out forces.svg
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    arguments.add_robot_arguments(parser)
    poses.add_pose_arguments(parser)
    arguments.add_load_arguments(parser)
    arguments.add_tool_argument(parser, "tell twist and stiffness of this point instead of o")
    parser.add_argument("--off", metavar="NAME=T", required=True, **arguments.SEVERAL, help="parameters and their tolerances")
    parser.add_argument("--robots", metavar="N", help="robots made at random (default: 10000; 300 where made one by one)")
    parser.add_argument("--distribution", metavar="D", default="normal", help="normal or uniform (default: %(default)s)")
    parser.add_argument("--seed", metavar="N", default="0", help="of the random numbers (default: %(default)s)")
    parser.add_argument("--what", metavar="NAME", default="displacement", help="what --out shows: rotation, x … rz, an actuator")
    parser.add_argument("--out", metavar="FILE", help="write a histogram: .pdf, .svg or .png")
    arguments.add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    """Print the tables."""
    with waiting("making robots"):
        from kinetostatics.design import spread

        arguments.check_figure(args.out, "--out")
        options = arguments.load_options(args)
        robots = None if args.robots is None else arguments.whole_number_of("--robots", args.robots, 2)
        seed = arguments.whole_number_of("--seed", args.seed, 0)
        off = arguments.parse_items("--off", args.off)
        configuration, warnings = poses.assemble(arguments.load(args), args)
        found = spread(
            configuration, off, robots=robots, distribution=args.distribution, seed=seed, tool=arguments.tool(args), **options
        )
        answers.save_figure(args.out, "spread", found, args.what)
        answer = found.to_dict() if args.json else str(found)
    answers.print_answer(answer, warnings, args.out)
    return 0
