"""``kinetostatics import``: a robot file from a URDF whose loops another tool has described."""

from __future__ import annotations

import argparse
import math
import os
import sys
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from kinetostatics.arguments import Argument
from kinetostatics.cli.answers import print_warnings
from kinetostatics.cli.commands import Command
from kinetostatics.cli.options import check_folder
from kinetostatics.cli.values import parse_items, parse_parameters
from kinetostatics.exceptions import ArgumentError, KinetostaticsError
from kinetostatics.printing.colour import for_stream
from kinetostatics.printing.waiting import waiting

if TYPE_CHECKING:
    from kinetostatics.description.robot import RobotDescription


#: From what turn on [degrees] the platform's axes at zero are spoken of.
LEAST_TURN = 0.1


def _import(args: argparse.Namespace) -> int:
    """Write the robot file; return 2 if something more must be said."""
    from kinetostatics.files.importers.answers import MissingFactsError

    if args.out is not None and os.path.exists(args.out):
        raise ArgumentError(f"--out: {args.out} exists already; delete it or choose another name")
    check_folder(args.out)
    try:
        with waiting("importing"):
            from kinetostatics.files.importers.answers import Answers
            from kinetostatics.files.importers.convert import convert, describe

            answers = Answers(args.platform, args.base, _types(args.types), _axes(args.axes), args.driven)
            parameters = parse_parameters(args.parameters)
            out = args.out if args.out is not None else f"<import of {os.path.basename(args.source)}>"
            made = convert(args.source, args.yaml, answers, parameters=parameters, out=out)
            description = describe(made, parameters)
    except MissingFactsError as error:
        print(for_stream(f"kinetostatics: error: {error.for_command_line}", sys.stderr), file=sys.stderr)
        return 2
    if args.out is None:
        sys.stdout.write(made.text)
    else:
        with open(args.out, "x", encoding="utf-8") as stream:
            stream.write(made.text)
        loops = f"{len(made.loops)} loop" + ("" if len(made.loops) == 1 else "s")
        print(f"{args.out}: {loops}, platform {description.platform}, driven: {', '.join(description.driven) or 'none'}")
        for line in (_turned_axes(description), _what_next(args.out, description)):
            if line:
                print(line)
    print_warnings(description.warnings)
    return 0


def _turned_axes(description: RobotDescription) -> str:
    """Say how the platform's axes, to which coordinates refer, are made parallel to the base's where all joints are at zero."""
    import numpy as np

    from kinetostatics.robot import Robot

    try:
        robot = Robot(description)
        rotation = robot.mechanism.platform_pose(robot.zero_frames)[0][..., 0]
    except KinetostaticsError:  # check says what
        return ""
    angle = float(np.degrees(np.arccos(np.clip((np.trace(rotation) - 1) / 2, -1, 1))))
    if angle < LEAST_TURN:
        return ""
    origin = description.platform_origin
    back = origin.matrix[:3, :3] @ rotation.T  # the axes that would be parallel, in the platform link
    pitch = math.asin(float(np.clip(-back[2, 0], -1, 1)))
    roll, yaw = math.atan2(back[2, 1], back[2, 2]), math.atan2(back[1, 0], back[0, 0])
    xyz = "" if not any(origin.xyz) else f' xyz="{" ".join(f"{value:.12g}" for value in origin.xyz)}"'
    rpy = " ".join(f"{value if abs(value) > 1e-12 else 0.0:.12g}" for value in (roll, pitch, yaw))
    return (
        f"the axes of the platform {description.platform!r} are turned by {angle:.4g}° at zero, and coordinates and results "
        f"refer to them; parallel to the base's are those of\n"
        f'  <platform link="{description.platform}"><origin{xyz} rpy="{rpy}"/></platform>'
    )


def _what_next(path: str, description: RobotDescription) -> str:
    """Say how links of a file without beams become elastic: those between two joints."""
    if description.beams or description.joint_stiffness:
        return ""
    from kinetostatics.printing.text import listing

    ends = [link for joint in description.joints.values() for link in (joint.parent, joint.child)]
    ends += [link for loop in description.loops.values() for link in (loop.predecessor, loop.successor)]
    rigid = (description.base, description.platform)
    between = [link for link in description.links if ends.count(link) == 2 and link not in rigid]
    beam = f'<beam link="{(between or ["…"])[0]}" youngs_modulus="210e9" poisson_ratio="0.3" density="7850">'
    listed = f" (links between two joints: {listing(between)})" if between else ""
    return (
        f"all links are rigid yet: write into {path} what bends{listed}:\n"
        f'  {beam}<tube outer_diameter="0.03" inner_diameter="0.024"/></beam>\n'
        f"then: kinetostatics check {path}"
    )


def _types(items: Sequence[str]) -> Mapping[str, str] | str | None:
    if not items:
        return None
    if len(items) == 1 and "=" not in items[0]:
        return items[0]
    return parse_items("--types", items)


def _axes(items: Sequence[str]) -> dict[str, object]:
    found: dict[str, object] = {}
    for name, value in parse_items("--axes", items).items():
        try:
            vectors = [[float(number) for number in part.replace(",", " ").split()] for part in value.split("/")]
        except ValueError:
            raise ArgumentError(f"--axes: {name}: {value!r} is not of the form X,Y,Z") from None
        found[name] = vectors[0] if len(vectors) == 1 else vectors
    return found


IMPORT = Command(
    _import,
    help="make a robot file from a URDF of onshape-to-robot, of Gepetto's, or of Isaac Sim",
    arguments=("parameters",),
    own={
        "platform": Argument("text", "the platform", "LINK"),
        "base": Argument("text", "the base (default: the root of the tree)", "LINK"),
        "source": Argument("text", "the URDF or xacro file", "SOURCE", option="source"),
        "yaml": Argument("text", "a robot.yaml with closed_loop, type and name_mot", "FILE"),
        "types": Argument("texts", "LOOP=TYPE of loops; or one TYPE for all loops of which the source does not say it", "TYPE"),
        "axes": Argument(
            "items",
            "axes of loops in the frame of their first link; X,Y,Z/X,Y,Z for universal, the second in the second's",
            "LOOP=X,Y,Z",
        ),
        "driven": Argument("texts or none", "the actuators; without any there are none", "JOINT"),
        "out": Argument("text", "the file to write (default: print it)", "FILE"),
    },
    function="files.importers:import_robot",
    required=("source",),
    usage="SOURCE [options]",
    notes="""\
loops are read from
  links closing_NAME_1 and closing_NAME_2 of onshape-to-robot,
  a robot.yaml of Gepetto's example-parallel-robots (--yaml),
  <loop_joint> of Isaac Sim.
  The result includes SOURCE, which stays as it is.
""",
    examples="""
import robot.urdf
import robot.urdf --types closing_A=revolute --platform tool --driven motor1 motor2 --out five_bar.urdf.xacro
import robot.urdf --yaml robot.yaml --platform effector --out delta.urdf.xacro
""",
)
