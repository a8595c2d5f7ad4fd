"""``kinetostatics tolerances``: pose errors and internal forces by manufacturing errors, ranked, with random samples."""

from __future__ import annotations

import argparse

from kinetostatics.cli import answers, arguments, poses
from kinetostatics.printing.waiting import waiting

USAGE = "ROBOT [--tolerance NAME=T …] [options]"
HELP = "rank manufacturing errors by pose error and internal force"
DESCRIPTION = (
    "Rank manufacturing errors by the pose error and the internal force of each alone, with the worst case, the standard\n"
    "deviation and random samples of sag, stiffness and actuator forces at one pose."
)
EXAMPLES = f"""\
{arguments.VALUES_HELP}
  A tolerance is to either side, with a unit or as a part of the value: 0.1mm, 2%.

parameters; * is a wildcard:
  assembly errors, of joints along and about the axes of their frames, of beams by length and temperature: revolute_1.error.x,
  revolute_1.error.rx, rod_1.error.length, rod_1.error.temperature; without --tolerance all of them, by 0.1 mm, 1 mrad and 1 K
  xacro arguments of the file, which change all that it computes from them: rod_diameter
  numbers of single parts, each off by itself: rod_1.outer_diameter, platform.mass, revolute_1.placement.x

examples:
  kinetostatics tolerances 2pru_upr --rank-by displacement --top 10
  kinetostatics tolerances 2pru_upr --tolerance '*.error.[xyz]=20um' '*.error.r?=0.1mrad' --json
  kinetostatics tolerances 3rps --tolerance rod_diameter=0.1mm youngs_modulus=3% --load 0 0 -500 0 0 0 --tool 0 0 200mm
  kinetostatics tolerances 3rps --tolerance 'rod_*.outer_diameter=0.1mm' --what prismatic_1 --out forces.svg
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    arguments.add_robot_arguments(parser)
    poses.add_pose_arguments(parser)
    arguments.add_load_arguments(parser)
    arguments.add_tool_argument(parser, "tell twist and stiffness of this point instead of o")
    parser.add_argument("--tolerance", metavar="NAME=T", **arguments.SEVERAL, help="parameters and their tolerances")
    parser.add_argument("--rank-by", metavar="WHAT", help="force, displacement or rotation (default: force, if there is any)")
    parser.add_argument("--top", metavar="N", help="print the N largest effects only")
    parser.add_argument("--samples", metavar="N", help="random robots (default: 10000; 300 where analysed one by one)")
    parser.add_argument("--distribution", metavar="D", default="normal", help="normal or uniform (default: %(default)s)")
    parser.add_argument("--seed", metavar="N", default="0", help="of the random numbers (default: %(default)s)")
    parser.add_argument("--what", metavar="NAME", default="displacement", help="what --out shows: rotation, x … rz, an actuator")
    parser.add_argument("--out", metavar="FILE", help="write a histogram: .pdf, .svg or .png")
    arguments.add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    """Print the tables."""
    with waiting("computing effects of tolerances"):
        from dataclasses import replace

        from kinetostatics.design import tolerances

        arguments.check_figure(args.out, "--out")
        options = arguments.load_options(args)
        options["samples"] = None if args.samples is None else arguments.whole_number_of("--samples", args.samples, 2)
        options["seed"] = arguments.whole_number_of("--seed", args.seed, 0)
        top = None if args.top is None else arguments.whole_number_of("--top", args.top)
        given = arguments.parse_items("--tolerance", args.tolerance) or None
        configuration, warnings = poses.assemble(arguments.load(args), args)
        options |= {"rank_by": args.rank_by, "distribution": args.distribution, "tool": arguments.tool(args)}
        found = tolerances(configuration, given, **options)
        answers.save_figure(args.out, "tolerances", found, args.what)
        if top is not None:
            found = replace(found, effects=dict([*found.effects.items()][:top]))
        answer = found.to_dict() if args.json else str(found)
    answers.print_answer(answer, warnings, args.out)
    return 0
