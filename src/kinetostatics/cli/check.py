"""``kinetostatics check``: what a robot file describes, and what is wrong with it."""

from __future__ import annotations

import argparse

from kinetostatics.cli.answers import print_json, print_report, print_warnings
from kinetostatics.cli.arguments import add_json_argument, add_robot_arguments, load
from kinetostatics.printing.waiting import waiting

HELP = "say what a robot file describes: mobility, limbs, wrenches, beams, warnings"
DESCRIPTION = (
    "Say what a robot file describes: what can move and what is held more than once, every limb from base to "
    "platform with its constraint wrenches in words, beams, elastic joints, masses, and what looks like a mistake."
)
EXAMPLES = """\
examples:
  kinetostatics check 3rps
  kinetostatics check my_robot.urdf.xacro --set rod_diameter=80mm --json
  kinetostatics check panda.urdf --platform-link panda_hand               # a plain URDF, as it is

The exit code is 0 if the robot can be analysed, 1 if it cannot (its loops do not close), 2 if the file is wrong.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    add_robot_arguments(parser)
    parser.add_argument("--engine", action="store_true", help="say too what of the robot runs as compiled code; compiles it")
    add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    """Print the report; return 1 if the robot cannot be analysed."""
    with waiting("checking"):
        from kinetostatics.checks.collect import robot_facts
        from kinetostatics.engine.report import engine_report
        from kinetostatics.reports.json import facts_to_dict
        from kinetostatics.reports.robot import facts_report

        robot = load(args)
        facts = robot_facts(robot)
        text = "" if args.json else facts_report(facts)
        engine = engine_report(robot) if args.engine and not facts.problems else None
    if args.json:
        print_json(facts_to_dict(facts) | ({} if engine is None else {"engine": engine.to_dict()}))
        print_warnings([*facts.problems, *facts.warnings])
    else:
        print_report(text if engine is None else f"{text}\n\n{engine}")
    return 1 if facts.problems else 0
