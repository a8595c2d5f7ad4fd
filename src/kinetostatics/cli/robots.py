"""``kinetostatics robots``: the robots that come with the package."""

from __future__ import annotations

import argparse

from kinetostatics.cli.arguments import SEVERAL, Subparsers, add_command, add_json_argument, print_json
from kinetostatics.files.bundled import copy_robots, robots

NAME = "robots"

EXAMPLES = """\
examples:
  kinetostatics robots
  kinetostatics robots --copy delta
"""


def add_parser(subparsers: Subparsers) -> None:
    """Add the command to the parser."""
    parser = add_command(
        subparsers,
        NAME,
        run,
        usage="[options]",
        help="list the robots that come with the package, or copy their files",
        description="List the robots that come with the package; their names do wherever a ROBOT is asked for.",
        epilog=EXAMPLES,
    )
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
