"""``kinetostatics optimize``: the best parameters of a robot's file, under requirements over a workspace."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from kinetostatics.cli import answers, arguments, poses
from kinetostatics.printing.waiting import waiting

if TYPE_CHECKING:
    from kinetostatics.results.optimum import Optimum
    from kinetostatics.results.pareto import ParetoFront

USAGE = "ROBOT --vary NAME=FROM:TO … --subject-to REQUIREMENT … [options]"
HELP = "size a robot: the lightest rods that are stiff enough"
DESCRIPTION = "Find the parameters of a robot that are best, under requirements that hold at every pose of a grid."
EXAMPLES = f"""\
{arguments.VALUES_HELP}
  FROM:TO:COUNT and A,B,C of --platform make a grid of poses: every requirement holds at all of them.

quantities:
  mass, sag, rotation, deflection_any_direction(FORCE), rotation_any_direction(MOMENT), actuator_force, actuator_torque, stress,
  buckling; only in requirements: least_translational_stiffness, least_rotational_stiffness.

--vary:
  rod_diameter=20mm:120mm is a range, rod_diameter=20mm,25mm,30mm a list. A catalogue is a CSV file with a row for each
  size, whose columns set one argument, or several: tube_diameter+tube_wall=tubes.csv. standard_bars and standard_tubes come with
  the package. Numbers of parts have names as in tolerances, rod_1.outer_diameter=20mm:120mm, also of a plain URDF; of
  rod_*.outer_diameter=20mm:120mm all are alike.

exit code:
  0 feasible, 1 not feasible, 2 an error, such as SciPy missing: pip install 'kinetostatics[optimize]'

examples:
  kinetostatics optimize 3rps --vary rod_diameter=40mm:120mm --subject-to "deflection_any_direction(500 N) < 20um" --platform \\
      z=450mm,650mm rx=-15deg,0,15deg ry=-15deg,0,15deg --out sized.urdf
  kinetostatics optimize 3rps --vary rod_diameter=standard_bars --subject-to "sag < 0.2um" "actuator_force < 1kN" --json
  kinetostatics optimize 3rps --vary "rod_*.outer_diameter=40mm:120mm" --subject-to "sag < 0.2um" --out sized.urdf
  kinetostatics optimize 3rps --vary rod_diameter=60mm:120mm --pareto "deflection_any_direction(500 N)" --out front.svg
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    arguments.add_robot_arguments(parser)
    poses.add_pose_arguments(parser, "VALUES", "The workspace. Default: all actuators at zero.", near=False)
    arguments.add_load_arguments(parser)
    group = parser.add_argument_group("optimization")
    group.add_argument("--vary", metavar="NAME=WHAT", required=True, **arguments.SEVERAL, help="what may change")
    group.add_argument("--minimize", metavar="QUANTITY", default="mass", help="its worst pose counts (default: %(default)s)")
    group.add_argument(
        "--subject-to", metavar="REQUIREMENT", **arguments.SEVERAL, help="a quantity and its limit, such as 'sag < 20um'"
    )
    arguments.add_tool_argument(group, "tell sag, deflection and stiffness of this point instead of o")
    group.add_argument("--pareto", metavar="QUANTITY", help="minimize this one too: designs of which none is better in both")
    group.add_argument("--points", metavar="N", default="10", help="designs of --pareto (default: %(default)s)")
    group.add_argument("--starts", metavar="N", default="3", help="searches from different parameters (default: %(default)s)")
    parser.add_argument("--out", metavar="FILE", help="write the robot, plain URDF; --pareto: .csv, .svg, .pdf, .png")
    arguments.add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    """Print the optimum."""
    with waiting("optimizing"):
        from kinetostatics.design import optimize, pareto

        draws = args.pareto is not None and not (args.out or "").endswith(".csv")
        (arguments.check_figure if draws else arguments.check_folder)(args.out, "--out")
        options = arguments.load_options(args)
        _, over = poses.grid(arguments.load(args) if args.actuators else None, args)
        starts = arguments.whole_number_of("--starts", args.starts)
        points = arguments.whole_number_of("--points", args.points)
        vary = arguments.parse_items("--vary", args.vary)
        options |= {
            "orientation": args.orientation,
            "parameters": arguments.parse_parameters(args.parameters),
            "platform_link": args.platform_link,
            "base_link": args.base_link,
            "starts": starts,
            "closure_tolerance": poses.closure_tolerance_of(args),
            "tool": arguments.tool(args),
        }
        found: Optimum | ParetoFront
        feasible = True
        if args.pareto is None:
            found = optimize(args.robot, vary, args.minimize, args.subject_to, over or None, **options)
            feasible = found.feasible
        else:
            both = args.minimize, args.pareto
            found = pareto(args.robot, vary, both, args.subject_to, over or None, points=points, **options)
        if draws:
            answers.save_figure(args.out, "pareto", found)
        elif args.out is not None:
            found.save(args.out)
        answer = found.to_dict() if args.json else str(found)
    answers.print_answer(answer, [], args.out)
    return 0 if feasible else 1
