"""Command calibrate: stiffnesses, payload and offsets from measured deflections, and plans of measurements."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from kinetostatics.arguments import LOADS, POSE, ROBOT, Argument, Keyword
from kinetostatics.cli.answers import answer, save_files
from kinetostatics.cli.commands import Command
from kinetostatics.cli.inputs import grid_of, load_robot, loads_of, single_values
from kinetostatics.cli.options import FIGURES, check_files, given_of, value_of
from kinetostatics.cli.typed_values import VALUES_HELP, number_of, parse_items
from kinetostatics.exceptions import ArgumentError
from kinetostatics.progress import waiting

if TYPE_CHECKING:
    from kinetostatics.robot import Robot


def _calibrate(args: argparse.Namespace) -> int:
    """Print estimates or a plan."""
    with waiting("calibrating"):
        planned = value_of("plan", args)
        check_files(args.out, ("urdf", *FIGURES) if planned is None else ("csv",))
        if (args.measurements is None) == (planned is None):
            raise ArgumentError("give either MEASUREMENTS, a CSV file, or --plan N for a plan of measurements")
        if args.load is not None:
            raise ArgumentError("--load: measurements have their loads in the table, Fx … Mz, and plans by --load-case")
        options = {**loads_of(args), **given_of(("gauges", "orientation", "closure_tolerance"), args)}
        robot = load_robot(args)
        if args.reference:
            options["reference"] = _reference(robot, args.reference)
        if planned is None:
            found: Keyword = CALIBRATE.called()(
                robot, args.measurements, args.unknowns, **options, **given_of(("level", "leave_out_outliers"), args)
            )
        else:
            from kinetostatics.calibration import plan_measurements

            option, coordinates = grid_of(robot, args)
            options |= {option[2:]: coordinates or None, "load": _loads(args.load_case), **given_of(("readings",), args)}
            found = plan_measurements(robot, args.unknowns, planned, **options)
        save_files(args.out, "calibration", found)
        shown = found.to_dict() if args.json else found.report()
    answer(shown, (), args.out)
    return 0


def _loads(cases: list[str]) -> list[list[float]]:
    """Return the loads of ``--load-case``, each as six numbers [N, N·m]; by default a zero load."""
    kinds = ["force"] * 3 + ["moment"] * 3
    found = []
    for text in cases or ["0 0 0 0 0 0"]:
        cells = text.split()
        if len(cells) != 6:
            raise ArgumentError(
                f"--load-case: {text.strip()!r} has {len(cells)} numbers; a load has six in quotes: '0 0 -500 0 0 0'"
            )
        found.append([number_of("--load-case", cell, kind) for cell, kind in zip(cells, kinds, strict=True)])
    return found


def _reference(robot: Robot, words: list[str]) -> str | dict[str, float]:
    """Return the word of ``--reference``, or the coordinates of a pose."""
    if len(words) == 1 and "=" not in words[0]:
        return words[0]
    names = set(parse_items("--reference", words))
    option = "--actuators" if names <= set(robot.description.driven) else "--platform"
    return single_values(robot, option, words, "--reference")


CALIBRATE = Command(
    _calibrate,
    help="estimate stiffnesses, payload and offsets from measured deflections",
    description="""\
Estimate stiffnesses, payload and offsets from measured deflections, with confidence intervals, unidentifiable parameters
and outliers; or plan measurements.""",
    arguments=(*ROBOT, *(name for name in POSE if name != "near"), *LOADS, "json"),
    own={
        "measurements": Argument("text", "a CSV file of poses, loads and readings", "MEASUREMENTS", option="measurements"),
        "unknowns": Argument("texts", "parameters to estimate", "NAME"),
        "gauges": Argument("text", "a CSV file of gauges", "FILE"),
        "reference": Argument(
            "texts",
            "state of zero readings: undeformed (default), unloaded (the same pose, with its weight), or coordinates NAME=VALUE "
            "of an unloaded pose",
            "WHAT",
        ),
        "level": Argument("number", "confidence level of the intervals (default: 0.95)", "P"),
        "leave_out_outliers": Argument("flag", "repeat the fit without outliers"),
        "plan": Argument("count", "choose the N poses and loads with the smallest standard errors", "N", group="plan"),
        "load_case": Argument("texts", "loads that can be applied: 'FX FY FZ MX MY MZ' each", "LOAD", group="plan"),
        "readings": Argument("texts", "gauges to be read (default: dx dy dz)", "GAUGE", group="plan"),
        "out": Argument(
            "texts",
            "write the robot with the estimates as plain URDF (.urdf), the residuals as a figure, or the plan (.csv)",
            "FILE",
        ),
    },
    function="calibration:calibrate",
    required=("robot", "unknowns"),
    usage="ROBOT [MEASUREMENTS] --unknowns NAME … [options]",
    grid=True,
    notes=f"""\
{VALUES_HELP}
tables:
  MEASUREMENTS is a CSV file. Its first line has titles, with units if they are not SI: coordinates of the platform or of all
  actuators, Fx Fy Fz Mx My Mz of the load, and readings: dx dy dz drx dry drz of o in world axes, and gauges by their names. Each
  further line is one pose with one load; an empty cell is no reading. The file of --gauges has the columns name and
  ux uy uz (direction), and optionally (defaults in brackets) x y z of the point (o), frame: world or platform (world), measures:
  displacement or rotation (displacement), sigma (unknown).

unknowns:
  A beam, elastic joint or actuator: a factor of its stiffness; rod_1+rod_2 for a common one. An argument of the file. A dimension
  of a part: motor_1.actuator_stiffness, rod_1.outer_diameter. payload.mass, payload.x, payload.y, payload.z. offset.GAUGE, or
  offsets for all.

plan:
  The poses are the grid of --platform or --actuators, given by FROM:TO:COUNT and A,B,C.
""",
    examples="""
calibrate 2pru_upr examples/calibration/measurements.csv --gauges examples/calibration/gauges.csv --unknowns rod_1 rod_2 rod_3 \
--reference unloaded --leave-out-outliers --out mine.urdf residuals.svg
calibrate 2pru_upr --plan 12 --unknowns rod_1 rod_2 rod_3 --readings dx dz --reference unloaded --platform z=550mm:650mm:3 \
rx=-15deg:15deg:3 ry=-15deg:15deg:3 --load-case "0 0 -500 0 0 0" "300 0 0 0 0 0" --out to_measure.csv
""",
)
