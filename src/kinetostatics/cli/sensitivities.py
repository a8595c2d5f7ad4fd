"""``kinetostatics sensitivities``: what each parameter of the robot does, ranked; what to stiffen first."""

from __future__ import annotations

import argparse

from kinetostatics.cli import answers, arguments, poses
from kinetostatics.printing.waiting import waiting

HELP = "rank what each parameter of the robot does, and what to stiffen first"
DESCRIPTION = (
    "Differentiate sag, forces and mass at one pose with respect to the arguments of the robot's file, or to\n"
    "numbers of its parts, and to the stiffness of every elastic part, and rank them by what they do\n"
    "to the platform."
)
EXAMPLES = f"""\
{arguments.VALUES_HELP}
examples:
  kinetostatics sensitivities 3rps --platform z=500mm rx=3deg ry=0 --load 0 0 -500 0 0 0
  kinetostatics sensitivities 2pru_upr --by rod_diameter rod_length --json
  kinetostatics sensitivities delta --by "*diameter" "*.mass" "motor_1.placement.*"
  kinetostatics sensitivities 3rps --of mass actuator_forces --json
  kinetostatics sensitivities 3rps --load 0 0 -500 0 0 0 --out stiffen.svg
  kinetostatics sensitivities 3rps --load 0 100 -500 0 0 0 --tool 0 0 200mm
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    arguments.add_robot_arguments(parser)
    poses.add_pose_arguments(parser)
    arguments.add_load_arguments(parser)
    arguments.add_tool_argument(parser, "differentiate twist and stiffness of this point instead of o")
    by = "xacro arguments of the file, or numbers of parts such as rod_1.outer_diameter; * stands for anything "
    by += "(default: all arguments that change anything; of a file without, numbers of parts)"
    parser.add_argument("--by", metavar="NAME", nargs="+", help=by)
    of = "twist, stiffness, compliance, actuator_forces, actuators, mass"
    described = f"quantities that are differentiated, of {of} (default: all of them)"
    parser.add_argument("--of", metavar="QUANTITY", nargs="+", default=of.split(", "), help=described)
    parser.add_argument("--out", metavar="FILE", help="write a bar chart: .pdf, .svg or .png")
    arguments.add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    """Print the tables."""
    with waiting("changing parameters one by one"):
        from kinetostatics.design import sensitivities

        arguments.check_figure(args.out, "--out")
        options = arguments.load_options(args)
        configuration, warnings = poses.assemble(arguments.load(args), args)
        found = sensitivities(configuration, args.by, of=args.of, tool=arguments.tool(args), **options)
        answers.save_figure(args.out, "sensitivities", found)
        answer = found.to_dict() if args.json else str(found)
    answers.print_answer(answer, warnings, args.out)
    return 0
