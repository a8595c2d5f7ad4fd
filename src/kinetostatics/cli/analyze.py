"""``kinetostatics analyze``: sag, stiffness and forces at one pose."""

from __future__ import annotations

import argparse

from kinetostatics.cli import answers, arguments, poses
from kinetostatics.printing.waiting import waiting

HELP = "compute sag, stiffness, actuator forces, joint reactions and stresses at one pose"
DESCRIPTION = "Compute sag, stiffness, actuator forces, joint reactions and beam stresses at one pose."
EXAMPLES = f"""\
{arguments.VALUES_HELP}
examples:
  kinetostatics analyze 3rps
  kinetostatics analyze 3rps --platform z=500mm azimuth=-170deg tilt=10deg --orientation tilt_torsion
  kinetostatics analyze 2pru_upr --actuators prismatic_1=20mm prismatic_2=0 prismatic_3=-5mm --load 0 0 -500 0 0 0
  kinetostatics analyze panda.urdf --platform-link panda_hand             # a plain URDF, as it is
  kinetostatics analyze 3rps --load 0 100 -500 0 0 0 --tool 0 0 200mm
  kinetostatics analyze 2pru_upr --hinge-axis limb_1=x limb_2=x --gravity 0 0 9.8
  kinetostatics analyze 3rps --payload 5kg --payload-center 0 0 -200mm --load-on rod_1 0 0 -50N 0 0 0
  kinetostatics analyze my_robot.urdf.xacro --set rod_diameter=80mm --gravity 0 0 0 --load 100 0 0 0 0 0 --json
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    arguments.add_robot_arguments(parser)
    poses.add_pose_arguments(parser)
    arguments.add_load_arguments(parser)
    arguments.add_engine_argument(parser)
    parser.add_argument(
        "--hinge-axis",
        metavar="LIMB=x",
        nargs="+",
        default=[],
        help="limbs whose x axis, not y, is called the one along the first hinge in the table of limbs (the paper's PRU limbs)",
    )
    arguments.add_tool_argument(parser, "tell twist and stiffness of this point, too")
    arguments.add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    """Print the analysis."""
    with waiting("analyzing"):
        from kinetostatics.analysis import analyze

        options = arguments.load_options(args)
        robot = arguments.load(args)
        configuration, warnings = poses.assemble(robot, args)
        result = analyze(configuration, **options, engine=args.engine)
        axes = arguments.parse_items("--hinge-axis", args.hinge_axis)
        tool = arguments.tool(args)
        seen = None if tool is None else result.at_point(tool)
        found: dict[str, object] | str = result.to_dict() if args.json else result.report(hinge_axes=axes)
        if seen is not None:
            from kinetostatics.reports.tool_point import point_report, point_to_dict

            found = {**found, "tool": point_to_dict(seen)} if isinstance(found, dict) else f"{found}\n{point_report(seen)}"
    answers.print_answer(found, warnings)
    return 0
