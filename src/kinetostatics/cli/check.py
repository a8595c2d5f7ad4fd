"""``kinetostatics check``: what a robot file describes, and what is wrong with it."""

from __future__ import annotations

import argparse

from kinetostatics.cli.arguments import (
    Subparsers,
    add_command,
    add_json_argument,
    add_robot_arguments,
    load,
    print_json,
    print_report,
    print_warnings,
)
from kinetostatics.printing.waiting import waiting

NAME = "check"

EXAMPLES = """\
examples:
  kinetostatics check 3rps
  kinetostatics check my_robot.urdf.xacro --set rod_diameter=80mm --json
  kinetostatics check panda.urdf --platform-link panda_hand               # a plain URDF, as it is

The exit code is 0 if the robot can be analysed, 1 if it cannot (its loops do not close), 2 if the file is wrong.
"""


def add_parser(subparsers: Subparsers) -> None:
    """Add the command to the parser."""
    parser = add_command(
        subparsers,
        NAME,
        run,
        help="say what a robot file describes: mobility, limbs, wrenches, beams, warnings",
        description="Say what a robot file describes: what can move and what is held more than once, every limb from base to "
        "platform with its constraint wrenches in words, beams, elastic joints, masses, and what looks like a mistake.",
        epilog=EXAMPLES,
    )
    add_robot_arguments(parser)
    add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    """Print the report; return 1 if the robot cannot be analysed."""
    with waiting("checking"):
        from kinetostatics.checks.collect import robot_facts
        from kinetostatics.reports.json import facts_to_dict
        from kinetostatics.reports.robot import facts_report

        facts = robot_facts(load(args))
        text = "" if args.json else facts_report(facts)
    if args.json:
        print_json(facts_to_dict(facts))
        print_warnings([*facts.problems, *facts.warnings])
    else:
        print_report(text)
    return 1 if facts.problems else 0
