"""``kinetostatics calibrate``: stiffnesses, payload and offsets from measured deflections; where to measure."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from kinetostatics.argument_checks import Keyword
from kinetostatics.cli import answers, arguments, poses
from kinetostatics.exceptions import ArgumentError
from kinetostatics.printing.waiting import waiting

if TYPE_CHECKING:
    from kinetostatics.results.calibration import Calibration, MeasurementPlan
    from kinetostatics.robot import Robot

USAGE = "ROBOT [MEASUREMENTS] --unknowns NAME … [options]"
HELP = "find stiffnesses, payload and offsets from measured deflections"
DESCRIPTION = """\
Find stiffnesses, payload and offsets from measured deflections, how sure they are, what the readings cannot tell, and
which of them do not fit; or plan where to measure."""
EXAMPLES = f"""\
{arguments.VALUES_HELP}
tables:
  MEASUREMENTS is a CSV file. Its first line has titles, with units if they are not SI: coordinates of the platform or of all
  actuators, Fx Fy Fz Mx My Mz of the load, and readings: dx dy dz drx dry drz of o in world axes, and gauges by their names. Each
  further line is one pose with one load; an empty cell is no reading. The file of --gauges has name, direction ux uy uz, and,
  where they differ from what is in brackets, point x y z (o), frame world or platform (world), measures displacement or rotation
  (displacement), sigma (not known).

unknowns:
  A beam, elastic joint or actuator: a factor of its stiffness; rod_1+rod_2 for a common one. An argument of the file. A number
  of a part: motor_1.actuator_stiffness, rod_1.outer_diameter. payload.mass, payload.x, payload.y, payload.z. offset.GAUGE, or
  offsets for all.

examples:
  kinetostatics calibrate 2pru_upr examples/calibration/measurements.csv --gauges examples/calibration/gauges.csv \\
      --unknowns rod_1 rod_2 rod_3 --reference unloaded --leave-out-outliers --out mine.urdf --plot residuals.svg
  kinetostatics calibrate 2pru_upr --plan 12 --unknowns rod_1 rod_2 rod_3 --read dx dz --reference unloaded --platform \\
      z=550mm:650mm:3 rx=-15deg:15deg:3 ry=-15deg:15deg:3 --loads "0 0 -500 0 0 0" "300 0 0 0 0 0" --out to_measure.csv
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    arguments.add_robot_arguments(parser)
    parser.add_argument("measurements", metavar="MEASUREMENTS", nargs="?", help="a CSV file of poses, loads and readings")
    group = parser.add_argument_group("calibration")
    group.add_argument("--unknowns", metavar="NAME", nargs="+", required=True, help="what is looked for")
    group.add_argument("--gauges", metavar="FILE", help="a CSV file of gauges")
    group.add_argument(
        "--reference",
        metavar="WHAT",
        nargs="+",
        default=["undeformed"],
        help="what readings are differences to: undeformed (default), unloaded (the same pose, with its weight), or coordinates "
        "NAME=VALUE of an unloaded pose",
    )
    group.add_argument("--level", metavar="P", default="0.95", help="of the confidence intervals (default: %(default)s)")
    group.add_argument("--leave-out-outliers", action="store_true", help="fit once more without readings that do not fit")
    group.add_argument("--plot", metavar="FILE", help="write a figure of the residuals: .pdf, .svg or .png")
    group = parser.add_argument_group("plan")
    group.add_argument(
        "--plan", metavar="N", help="choose the N poses and loads that tell most, of all of --platform and --loads"
    )
    group.add_argument(
        "--loads", metavar="LOAD", nargs="+", default=[], help="loads that may be put on: 'FX FY FZ MX MY MZ' each"
    )
    group.add_argument("--read", metavar="GAUGE", nargs="+", default=["dx", "dy", "dz"], help="what is read (default: dx dy dz)")
    poses.add_pose_arguments(
        parser, "VALUES", "Of a plan: the poses that may be taken. Default: all actuators at zero.", near=False
    )
    arguments.add_load_arguments(parser)
    parser.add_argument("--out", metavar="FILE", help="write the robot with the estimates (plain URDF), or the plan (CSV)")
    arguments.add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    """Print estimates or a plan."""
    with waiting("calibrating"):
        arguments.check_folder(args.out)
        arguments.check_figure(args.plot)
        if (args.measurements is None) == (args.plan is None):
            raise ArgumentError("give either MEASUREMENTS, a CSV file, or --plan N for where to measure")
        options = arguments.load_options(args)
        if options.pop("load") != [0.0] * 6:
            raise ArgumentError(
                "--load: measurements have their loads in the table, Fx … Mz, and plans by --loads 'FX FY FZ MX MY MZ'"
            )
        robot = arguments.load(args)
        options |= {"gauges": args.gauges, "orientation": args.orientation, "reference": _reference(robot, args.reference)}
        options["closure_tolerance"] = poses.closure_tolerance_of(args)
        found = _calibrated(robot, args, options) if args.plan is None else _planned(robot, args, options)
        if args.out is not None:
            found.save(args.out)
        answer = found.to_dict() if args.json else str(found)
    answers.print_answer(answer, [], args.out, args.plot)
    return 0


def _calibrated(robot: Robot, args: argparse.Namespace, options: dict[str, Keyword]) -> Calibration:
    from kinetostatics.calibration import calibrate

    level = arguments.number_of("--level", args.level)
    found = calibrate(robot, args.measurements, args.unknowns, level=level, leave_out_outliers=args.leave_out_outliers, **options)
    answers.save_figure(args.plot, "calibration", found)
    return found


def _planned(robot: Robot, args: argparse.Namespace, options: dict[str, Keyword]) -> MeasurementPlan:
    from kinetostatics.calibration import plan_measurements

    if args.plot is not None:
        raise ArgumentError("--plot is not for plans")
    count = arguments.whole_number_of("--plan", args.plan)
    kinds = ["force"] * 3 + ["moment"] * 3
    loads = []
    for text in args.loads or ["0 0 0 0 0 0"]:
        cells = text.split()
        if len(cells) != 6:
            raise ArgumentError(f"--loads: {text.strip()!r} has {len(cells)} numbers; a load has six in quotes: '0 0 -500 0 0 0'")
        loads.append([arguments.number_of("--loads", cell, kind) for cell, kind in zip(cells, kinds, strict=True)])
    _, over = poses.grid(robot, args)
    return plan_measurements(robot, args.unknowns, count, over or None, loads, read=args.read, **options)


def _reference(robot: Robot, words: list[str]) -> str | dict[str, float]:
    """Return the word of ``--reference``, or the coordinates of a pose."""
    if len(words) == 1 and "=" not in words[0]:
        return words[0]
    names = set(arguments.parse_items("--reference", words))
    option = "--actuators" if names <= set(robot.description.driven) else "--platform"
    return poses.single_values(robot, option, words, "--reference")
