"""Command new: a robot file from a name or a notation such as 3-R[P]S, or from a URDF without statics."""

from __future__ import annotations

import argparse
import os
import sys

from kinetostatics.arguments import Keyword
from kinetostatics.authoring.file_arguments import odd_lengths
from kinetostatics.authoring.known_names import KNOWN_NAMES
from kinetostatics.cli.commands import Command
from kinetostatics.cli.inputs import number_of, option_of, parse_items, parse_parameters, unit_of
from kinetostatics.cli.options import Argument
from kinetostatics.cli.output import check_folder, print_warnings
from kinetostatics.exceptions import ArgumentError
from kinetostatics.progress import waiting

#: Options with --from only; options with an architecture only.
OF_FILES = ("platform_link", "base_link", "actuators", "elastic", "joint_stiffness", "yaml", "types", "axes")
LENGTHS = ("base_radius", "platform_radius", "height")
OF_ARCHITECTURES = (*LENGTHS, "azimuths", "placements", "guide", "axis", "section", "name")


def _new(args: argparse.Namespace) -> int:
    if args.list:
        print("\n".join(known_name.line for known_name in KNOWN_NAMES))
        return 0
    if args.out is not None and os.path.exists(args.out):
        raise ArgumentError(f"--out: {args.out} exists already; delete it or choose another name")
    check_folder(args.out)
    return _by_name(args) if args.source is None else _from_file(args)


def _by_name(args: argparse.Namespace) -> int:
    for name in OF_FILES:
        if getattr(args, name):
            raise ArgumentError(f"{option_of(name)} needs --from FILE")
    if args.architecture is None:
        raise ArgumentError("an architecture, such as 3-R[P]S, or --from FILE is missing (see kinetostatics new --help)")
    with waiting("building the robot"):
        from kinetostatics.authoring.by_name import new_robot, robot_text
        from kinetostatics.authoring.notation import parse_architecture

        architecture = parse_architecture(args.architecture)
        options = _options(args)
        robot = new_robot(args.architecture, args.out, **options)
        if args.out is None:
            sys.stdout.write(robot_text(args.architecture, **options))
            return 0
    actuated, mobility = ", ".join(robot.description.actuated), robot.mobility.platform
    chosen = " (the usual ones, as none was marked)" if architecture.actuators_chosen else ""
    print(f"{args.out}: {architecture.text}, mobility {mobility}, actuated: {actuated}{chosen}")
    print_warnings(robot.description.warnings)
    actuators = len(robot.description.actuated)
    if actuators > mobility:
        remedy = "another --arrangement, --axis or --guide may give more freedoms, or mark fewer joints in brackets"
        print_warnings([f"{actuators} actuators for mobility {mobility} brace one another: {remedy}."])
    return 0


def _from_file(args: argparse.Namespace) -> int:
    if args.architecture is not None:
        raise ArgumentError("give an architecture or --from, not both")
    for name in OF_ARCHITECTURES:
        if getattr(args, name):
            raise ArgumentError(f"{option_of(name)} is for an architecture, and not for --from")
    options = {
        "platform_link": args.platform_link,
        "base_link": args.base_link,
        "actuators": args.actuators,
        "elastic": _single_word(args.elastic) or parse_items("--elastic", args.elastic),
        "joint_stiffness": _single_word(args.joint_stiffness) or _stiffnesses(args.joint_stiffness),
        "yaml": args.yaml,
        "types": _single_word(args.types) or parse_items("--types", args.types),
        "axes": _axes(args.axes),
        "parameters": parse_parameters(args.parameters),
    }
    with waiting("extending the robot"):
        from kinetostatics.authoring.from_urdf import extend_robot, extension

        if args.out is None:
            text, _, warnings = extension(args.source, "", **options)
            sys.stdout.write(text)
            print_warnings(warnings)
            return 0
        description = extend_robot(args.source, args.out, **options).description
    elastic = ", ".join((*description.elastic_links, *description.joint_stiffness)) or "nothing yet, see its comments"
    actuated = ", ".join(description.actuated) or "none"
    loops = f"{len(description.loops)} loop{'s' * (len(description.loops) > 1)}, " if description.loops else ""
    ends = f"platform {description.platform}, base {description.base}"
    print(f"{args.out}: {loops}{ends}, actuated: {actuated}; elastic: {elastic}")
    print_warnings(description.warnings)
    return 0


def _single_word(items: list[str]) -> str | None:
    return items[0].strip() if len(items) == 1 and "=" not in items[0] else None


def _stiffnesses(items: list[str]) -> dict[str, float]:
    stiffnesses: dict[str, float] = {}
    for name, text in parse_items("--joint-stiffness", items).items():
        unit = unit_of(text)
        if unit is not None and unit.kind not in ("stiffness", "turning stiffness"):
            raise ArgumentError(
                f"--joint-stiffness: {name}: {text!r} is no stiffness; write it in N m/rad (30kNm/rad), or N/m of slides"
            )
        stiffnesses[name] = number_of("--joint-stiffness", text, None)
    return stiffnesses


def _axes(items: list[str]) -> dict[str, object]:
    axes: dict[str, object] = {}
    for name, value in parse_items("--axes", items).items():
        try:
            vectors = [[float(number) for number in part.replace(",", " ").split()] for part in value.split("/")]
        except ValueError:
            raise ArgumentError(f"--axes: {name}: {value!r} is not of the form X,Y,Z") from None
        axes[name] = vectors[0] if len(vectors) == 1 else vectors
    return axes


def _options(args: argparse.Namespace) -> dict[str, Keyword]:
    typed = {name: getattr(args, name) for name in LENGTHS}
    # very large lengths without a unit are probably in mm
    plain = {name: text for name, text in parse_items("--set", args.parameters).items() if unit_of(text) is None}
    for words in odd_lengths({name: text for name, text in (typed | plain).items() if text is not None}):
        raise ArgumentError(f"{words} (or {words.split()[2]}m if that is meant)")
    lengths = {name: None if text is None else number_of(option_of(name), text.strip(), "length") for name, text in typed.items()}
    azimuths = None if not args.azimuths else [number_of("--azimuths", text.strip(), "angle") for text in args.azimuths]
    return {
        **lengths,
        "arrangement": args.arrangement,
        "azimuths": azimuths,
        "placements": args.placements,
        "guide": args.guide,
        "axis": args.axis,
        "sections": parse_items("--section", args.section),
        "name": args.name,
        **parse_parameters(args.parameters),
    }


NEW = Command(
    _new,
    help="make a robot file from a name such as Delta or 3-R[P]S, or from a URDF",
    description=(
        "Make a robot file, commented and ready to be edited, from a known name, a notation of limbs and joints, or a URDF.\n"
        "The URDF is included unchanged; loops may be those of onshape-to-robot, Gepetto or Isaac Sim."
    ),
    arguments=("parameters", "platform_link", "base_link"),
    own_arguments={
        "architecture": Argument(
            "text", "a name such as Delta, or limbs such as 3-R[P]S; see below", "ARCHITECTURE", option="architecture"
        ),
        "list": Argument("flag", "list known names of robots with their architectures"),
        "base_radius": Argument("length", "distance of the base points of limbs from O (default: 0.3 m)", "LENGTH"),
        "platform_radius": Argument("length", "distance of the platform points of limbs from o (default: 0.2 m)", "LENGTH"),
        "height": Argument("length", "height of the platform above the base (default: 0.5 m; planar: 0)", "LENGTH"),
        "arrangement": Argument(
            "text",
            "symmetric (around Z), planar, cartesian (along X, Y, Z), or spherical (all axes through O); default: the name's",
            "WORD",
        ),
        "azimuths": Argument("texts", "azimuths of the limbs around Z (default: equal spacing): 90deg -90deg 0", "ANGLE"),
        "placements": Argument(
            "text", "CSV table of the limbs' points, with columns base_x … platform_z, and optionally axis_x …, guide_x …", "CSV"
        ),
        "guide": Argument("text", "direction of carriages: vertical, radial or tangential", "WORD"),
        "axis": Argument(
            "text", "direction of revolute axes: radial, tangential or vertical (default: perpendicular to the limb)", "WORD"
        ),
        "section": Argument(
            "items", 'sections of beams: rod="tube 60mm 50mm steel" crank="rectangle 20mm 60mm aluminium"', "ROLE=SECTION"
        ),
        "name": Argument("text", "name of the robot (default: that of the file)", "NAME"),
        "source": Argument(
            "text", "a URDF or xacro, which the new file includes unchanged", "FILE", option="--from", group="from a URDF"
        ),
        "actuators": Argument(
            "texts or none",
            "actuators besides joints with a <transmission> (default: all joints, without loops)",
            "JOINT",
            group="from a URDF",
        ),
        "elastic": Argument(
            "items",
            'links that are beams: upper_arm="tube 60mm 50mm steel"; or the word suggested, for suggestions from the file',
            "LINK=SECTION",
            group="from a URDF",
        ),
        "joint_stiffness": Argument(
            "items",
            "stiffness of actuators and gears: elbow=30kNm/rad; or the word suggested, for estimates from efforts of the file",
            "JOINT=VALUE",
            group="from a URDF",
        ),
        "yaml": Argument("text", "the YAML file with the loops of the URDF", "FILE", group="from a URDF"),
        "types": Argument(
            "items",
            "joint types of loops; or one TYPE for all loops without a type in the source",
            "LOOP=TYPE",
            group="from a URDF",
        ),
        "axes": Argument(
            "items",
            "axes of loops in the frame of their first link; X,Y,Z/X,Y,Z for universal, the second in that of the second link",
            "LOOP=X,Y,Z",
            group="from a URDF",
        ),
        "out": Argument("text", "the file to write (default: print it)", "FILE"),
    },
    function="authoring.by_name:new_robot",
    usage="ARCHITECTURE [options], or new --from FILE [options]",
    notes=f"""\
architecture:
  Limbs are strings of joints from base to platform: R revolute, P prismatic, C cylindrical, U universal, S spherical,
  (4S) two rods between spherical joints, (4R) a parallelogram. Actuators are in brackets; by default the usual ones are
  chosen. Limbs are joined by +, and 3- means three equal limbs.

{"".join(f"    {known_name.line}{chr(10)}" for known_name in KNOWN_NAMES)}""",
    examples="""
new "3-R[P]S" --base-radius 0.25 --platform-radius 0.2 --height 0.55 --out my_robot.urdf.xacro
new Delta --height=-0.6 --section rod="tube 14mm 11mm carbon" --out my_delta.urdf.xacro
new "2-U[P]R+S[P]R" --placements table.csv --out my_exechon.urdf.xacro
new --from panda.urdf --platform-link panda_hand --out my_panda.urdf.xacro
new --from ur10.urdf --platform-link tool0 --elastic upper_arm_link="tube 108mm 98mm aluminium" --joint-stiffness \
elbow_joint=30kNm/rad --out my_ur10.urdf.xacro
new --from robot.urdf --platform-link tool --types closing_A=revolute --actuators motor1 motor2 --out five_bar.urdf.xacro
new --from robot.urdf --yaml robot.yaml --platform-link effector --out delta.urdf.xacro
""",
)
