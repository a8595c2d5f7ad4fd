"""``kinetostatics verify``: the analysis of one pose beside that of finite elements."""

from __future__ import annotations

import argparse

from kinetostatics.cli import answers, arguments, poses
from kinetostatics.printing.waiting import waiting

HELP = "check one pose against finite elements (OpenSeesPy)"
DESCRIPTION = "Compute one pose twice, by screw theory and by finite elements (OpenSeesPy), and compare."
EXAMPLES = f"""\
{arguments.VALUES_HELP}
exit code:
  0 verified, 1 not verified, 2 an error, such as OpenSeesPy missing: pip install 'kinetostatics[verify]'

examples:
  kinetostatics verify 3rps
  kinetostatics verify 3rps --platform z=500mm azimuth=-170deg tilt=10deg --orientation tilt_torsion
  kinetostatics verify 2pru_upr --load 100 0 -500 0 0 0 --point 0 0 20mm --frame platform --json
  kinetostatics verify delta --payload 2kg --payload-center 0 0 -50mm
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    arguments.add_robot_arguments(parser)
    poses.add_pose_arguments(parser)
    arguments.add_load_arguments(parser)
    arguments.add_json_argument(parser)
    parser.add_argument(
        "--within", metavar="D", default="1e-8", help="largest relative difference that counts as verified (default: %(default)s)"
    )


def run(args: argparse.Namespace) -> int:
    """Print both sides and the verdict."""
    with waiting("verifying"):
        from kinetostatics.verification import verify

        options = arguments.load_options(args)
        within = arguments.parse_quantity(args.within, "number")
        configuration, warnings = poses.assemble(arguments.load(args), args)
        found = verify(configuration, **options, within=within)
    answers.print_answer(found.to_dict() if args.json else str(found), warnings)
    return 0 if found.verified else 1
