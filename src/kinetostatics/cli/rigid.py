"""Advice for a robot without elastic parts: commands that make it elastic, tested before they are printed."""

from __future__ import annotations

import argparse
import itertools
import os
import shlex
from typing import TYPE_CHECKING

from kinetostatics.arguments import Keyword
from kinetostatics.cli.inputs import pose_of
from kinetostatics.cli.typed_values import parse_parameters
from kinetostatics.exceptions import KinetostaticsError

if TYPE_CHECKING:
    from kinetostatics.robot import Robot

#: Options of ``new`` for suggested elastic parts, in the order in which they are tried.
SUGGESTIONS = (("elastic", "joint_stiffness"), ("elastic",), ("joint_stiffness",))


def rigid_advice(robot: Robot, args: argparse.Namespace, loads: dict[str, Keyword]) -> list[str]:
    """Return a warning with commands that make a rigid robot elastic and repeat the analysis of ``args``; none if it is elastic.

    The commands are tested, without writing the file, at the same pose and under the same loads: the compliance must not be zero.
    """
    if robot.description.beams or robot.description.joint_stiffness:
        return []
    for options in SUGGESTIONS:
        if _works(options, args, loads):
            commands = "".join(f"\n  {shlex.join(words)}" for words in _commands(options, args))
            return [f"nothing is elastic, so nothing sags; these commands make it elastic, by what the file suggests:{commands}"]
    return ["nothing is elastic, so nothing sags: links get a <beam>, actuators a <joint_stiffness>"]


def _works(options: tuple[str, ...], args: argparse.Namespace, loads: dict[str, Keyword]) -> bool:
    from kinetostatics.analysis import analyze
    from kinetostatics.authoring.from_urdf import SUGGESTED, extend_robot

    given: dict[str, Keyword] = {"platform_link": args.platform_link, "base_link": args.base_link}
    given |= dict.fromkeys(options, SUGGESTED)
    try:
        made = extend_robot(args.robot, parameters=parse_parameters(args.parameters), **given)
        return bool(analyze(pose_of(made, args)[0], **loads).compliance.any())
    except KinetostaticsError:
        return False


def _commands(options: tuple[str, ...], args: argparse.Namespace) -> tuple[list[str], list[str]]:
    """Return the command that writes the elastic robot, and the one that analyses it."""
    stem = os.path.basename(args.robot).partition(".")[0] + "_elastic"
    names = itertools.chain([stem], (f"{stem}_{k}" for k in itertools.count(2)))
    out = next(file for name in names if not os.path.exists(file := f"{name}.urdf.xacro"))
    made = ["kinetostatics", "new", "--from", args.robot]
    for option, value in (("--platform-link", args.platform_link), ("--base-link", args.base_link)):
        made += [option, value] if value is not None else []
    made += ["--set", *args.parameters] if args.parameters else []
    for name in options:
        made += [f"--{name.replace('_', '-')}", "suggested"]
    typed = args.command_line
    place = typed.index(args.robot, 2)
    return [*made, "--out", out], [*typed[:place], out, *typed[place + 1 :]]
