"""``kinetostatics robots``: the robots that come with the package."""

from __future__ import annotations

import argparse

from kinetostatics.cli.answers import print_json
from kinetostatics.cli.arguments import SEVERAL, add_json_argument
from kinetostatics.files.bundled import copy_robots, robots

USAGE = "[options]"
HELP = "list the robots that come with the package, or copy their files"
DESCRIPTION = "List the robots that come with the package; their names do wherever a ROBOT is asked for."
EXAMPLES = """\
examples:
  kinetostatics robots
  kinetostatics robots --copy delta
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.add_argument("--copy", metavar="NAME", **SEVERAL, help="copy the files of these robots to the current folder")
    add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    """Print the list, or copy."""
    if args.copy:
        copies = [path.as_posix() for path in copy_robots(args.copy)]
        if args.json:
            print_json({"copied": copies})
        else:
            print("\n".join(f"wrote {name}" for name in copies))
    elif args.json:
        print_json(robots())
    else:
        print(robots())
    return 0
