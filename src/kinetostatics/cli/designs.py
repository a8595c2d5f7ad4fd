"""Commands of design: tolerances, sensitivities, optimize, calibrate, capacity."""

from __future__ import annotations

import argparse
from dataclasses import replace
from typing import TYPE_CHECKING

from kinetostatics.arguments import Keyword
from kinetostatics.cli.commands import Command
from kinetostatics.cli.inputs import (
    VALUES_HELP,
    given_of,
    grid_of,
    link_loads_of,
    load_robot,
    loads_of,
    number_of,
    parse_items,
    parse_parameters,
    placed_payload,
    pose_of,
    single_values,
    value_of,
)
from kinetostatics.cli.options import LOADS, POSE, ROBOT, WRENCH, Argument
from kinetostatics.cli.output import FIGURES, answer, check_files, save_figure, save_files
from kinetostatics.exceptions import ArgumentError
from kinetostatics.progress import waiting

if TYPE_CHECKING:
    from kinetostatics.robot import Robot

# ---- tolerances ----------------------------------------------------------------------------------------------------------


def _tolerances(args: argparse.Namespace) -> int:
    with waiting("computing effects of tolerances"):
        check_files(args.out, FIGURES)
        options = {**loads_of(args), **given_of(("tolerances", "rank_by", "samples", "distribution", "seed", "tool"), args)}
        top = value_of("top", args)
        configuration, warnings = pose_of(load_robot(args), args)
        tolerances = TOLERANCES.called()(configuration, **options)
        save_files(args.out, "tolerances", tolerances, what=args.what or "displacement")
        if top is not None:
            tolerances = replace(tolerances, effects=dict([*tolerances.effects.items()][:top]))
    answer(tolerances, args, warnings)
    return 0


TOLERANCES = Command(
    _tolerances,
    help="rank manufacturing errors by pose error and internal force",
    description=(
        "Rank manufacturing errors by the pose error and the internal force that each causes, with the worst case, the standard\n"
        "deviation and random samples of sag, stiffness and actuator forces at one pose."
    ),
    arguments=(*ROBOT, *POSE, *LOADS, "tool", "seed", "json"),
    own_arguments={
        "tolerances": Argument("items", "parameters and their tolerances", "NAME=T", option="--tolerance"),
        "rank_by": Argument("text", "force, displacement or rotation (default: force, if there is any)", "WHAT"),
        "top": Argument("count", "print the N largest effects only", "N"),
        "samples": Argument("count", "number of random samples (default: 10000; 300 if analysed one by one)", "N", least=2),
        "distribution": Argument("text", "normal or uniform (default: normal)", "D"),
        "what": Argument("text", "quantity of the figure: displacement (default), rotation, x … rz, an actuator", "NAME"),
        "out": Argument("texts", "write a histogram (.svg, .pdf, .png)", "FILE"),
    },
    function="design:tolerances",
    usage="ROBOT [--tolerance NAME=T …] [options]",
    notes=f"""\
{VALUES_HELP}\
  A tolerance is ±, with a unit or as a percentage of the value: 0.1mm, 2%.

parameters; * is a wildcard:
  assembly errors of joints, along and about the axes of their frames, and of beams: revolute_1.error.x, revolute_1.error.rx,
  rod_1.error.length, rod_1.error.temperature; default: all of them, by 0.1 mm, 1 mrad and 1 K
  xacro arguments of the file, including all numbers computed from them: rod_diameter
  dimensions of single parts, independent of one another: rod_1.outer_diameter, platform.mass, revolute_1.placement.x
""",
    examples="""
tolerances 2pru_upr --rank-by displacement --top 10
tolerances 2pru_upr --tolerance '*.error.[xyz]=20um' '*.error.r?=0.1mrad' --json
tolerances 3rps --tolerance rod_diameter=0.1mm youngs_modulus=3% --load 0 0 -500 0 0 0 --tool 0 0 200mm
tolerances 3rps --tolerance 'rod_*.outer_diameter=0.1mm' --what prismatic_1 --out forces.svg
""",
)


# ---- sensitivities -------------------------------------------------------------------------------------------------------


def _sensitivities(args: argparse.Namespace) -> int:
    with waiting("changing parameters one by one"):
        check_files(args.out, FIGURES)
        options = {**loads_of(args), **given_of(("by", "outputs", "tool"), args)}
        configuration, warnings = pose_of(load_robot(args), args)
        sensitivities = SENSITIVITIES.called()(configuration, **options)
        save_files(args.out, "sensitivities", sensitivities)
    answer(sensitivities, args, warnings)
    return 0


SENSITIVITIES = Command(
    _sensitivities,
    help="rank parameters and parts by their effect on sag, forces and mass",
    description=(
        "Differentiate sag, forces and mass at one pose with respect to arguments of the robot's file or dimensions of parts,\n"
        "and to the stiffness of every elastic part, and rank all of these by their effect on the platform."
    ),
    arguments=(*ROBOT, *POSE, *LOADS, "tool", "by", "outputs", "json"),
    own_arguments={"out": Argument("texts", "write a bar chart (.svg, .pdf, .png)", "FILE")},
    function="design:sensitivities",
    notes=VALUES_HELP,
    examples="""
sensitivities 3rps --platform z=500mm rx=3deg ry=0 --load 0 0 -500 0 0 0
sensitivities 2pru_upr --by rod_diameter rod_length --json
sensitivities delta --by "*diameter" "*.mass" "motor_1.placement.*"
sensitivities 3rps --outputs mass actuator_forces --json
sensitivities 3rps --load 0 0 -500 0 0 0 --out stiffen.svg
sensitivities 3rps --load 0 100 -500 0 0 0 --tool 0 0 200mm
""",
)


# ---- optimize ------------------------------------------------------------------------------------------------------------


def _optimize(args: argparse.Namespace) -> int:
    with waiting("optimizing"):
        front = args.pareto is not None
        check_files(args.out, ("csv", *FIGURES) if front else ("urdf",))
        options: dict[str, Keyword] = loads_of(args)
        options |= given_of(("vary", "subject_to", "orientation", "closure_tolerance", "tool", "starts"), args)
        options |= given_of(("platform_link", "base_link"), args)
        options["parameters"] = parse_parameters(args.parameters)
        option, coordinates = grid_of(load_robot(args) if args.actuators else None, args)
        options[option[2:]] = coordinates or None
        if front:
            from kinetostatics.design import pareto

            both = (args.minimize or "mass", args.pareto)
            optimum_or_front: Keyword = pareto(args.robot, minimize=both, **options, **given_of(("points",), args))
        else:
            optimum_or_front = OPTIMIZE.called()(args.robot, **options, **given_of(("minimize",), args))
        save_files(args.out, "pareto", optimum_or_front)
    answer(optimum_or_front, args)
    return 0 if front or optimum_or_front.feasible else 1


OPTIMIZE = Command(
    _optimize,
    help="size a robot: the lightest rods that are stiff enough",
    description="Find the optimal parameters of a robot, under requirements at every pose of a grid.",
    arguments=(*ROBOT, *(name for name in POSE if name != "near"), *LOADS, "tool", "json"),
    own_arguments={
        "vary": Argument("items", "parameters with their ranges, lists or catalogues", "NAME=WHAT"),
        "minimize": Argument("text", "objective: its worst value over all poses (default: mass)", "QUANTITY"),
        "subject_to": Argument("texts", "a quantity and its limit, such as 'sag < 20um'", "REQUIREMENT"),
        "pareto": Argument("text", "second objective: compute the Pareto front of both", "QUANTITY"),
        "points": Argument("count", "number of designs of --pareto (default: 10)", "N"),
        "starts": Argument("count", "number of searches from different parameters (default: 3; with --pareto 2)", "N"),
        "out": Argument(
            "texts", "write the robot as plain URDF (.urdf); with --pareto a table (.csv) or figure (.svg, .pdf, .png)", "FILE"
        ),
    },
    function="design:optimize",
    required=("robot", "vary"),
    usage="ROBOT --vary NAME=FROM:TO … --subject-to REQUIREMENT … [options]",
    grid=True,
    notes=f"""\
{VALUES_HELP}\
  FROM:TO:COUNT and A,B,C of --platform make a grid of poses: every requirement must hold at all of them.

quantities:
  mass, sag, rotation, deflection_any_direction(FORCE), rotation_any_direction(MOMENT), actuator_force, actuator_torque, stress,
  buckling; only in requirements: least_translational_stiffness, least_rotational_stiffness.

--vary:
  rod_diameter=20mm:120mm is a range, rod_diameter=20mm,25mm,30mm a list. A catalogue is a CSV file with a row for each
  size, whose columns set one argument, or several: tube_diameter+tube_wall=tubes.csv. standard_bars and standard_tubes come with
  the package. Dimensions of parts are named as in tolerances, rod_1.outer_diameter=20mm:120mm, also for a plain URDF; with
  rod_*.outer_diameter=20mm:120mm all have one value.

exit code:
  0 feasible, 1 not feasible, 2 an error, such as SciPy missing: pip install 'kinetostatics[optimize]'
""",
    examples="""
optimize 3rps --vary rod_diameter=40mm:120mm --subject-to "deflection_any_direction(500 N) < 20um" --platform z=450mm,650mm \
rx=-15deg,0,15deg ry=-15deg,0,15deg --out sized.urdf
optimize 3rps --vary rod_diameter=standard_bars --subject-to "sag < 0.2um" "actuator_force < 1kN" --json
optimize 3rps --vary "rod_*.outer_diameter=40mm:120mm" --subject-to "sag < 0.2um" --out sized.urdf
optimize 3rps --vary rod_diameter=60mm:120mm --pareto "deflection_any_direction(500 N)" --out front.svg front.csv
""",
)


# ---- calibrate -------------------------------------------------------------------------------------------------------


def _calibrate(args: argparse.Namespace) -> int:
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
            calibration_or_plan: Keyword = CALIBRATE.called()(
                robot, args.measurements, args.unknowns, **options, **given_of(("level", "leave_out_outliers"), args)
            )
        else:
            from kinetostatics.calibration import plan_measurements

            option, coordinates = grid_of(robot, args)
            options |= {option[2:]: coordinates or None, "load": _loads(args.load_case), **given_of(("readings",), args)}
            calibration_or_plan = plan_measurements(robot, args.unknowns, planned, **options)
        save_files(args.out, "calibration", calibration_or_plan)
    answer(calibration_or_plan, args)
    return 0


def _loads(cases: list[str]) -> list[list[float]]:
    """Return the loads (n, 6) [N, N·m] of ``--load-case``; without this option, one load that is zero."""
    kinds = ["force"] * 3 + ["moment"] * 3
    loads = []
    for text in cases or ["0 0 0 0 0 0"]:
        cells = text.split()
        if len(cells) != 6:
            raise ArgumentError(
                f"--load-case: {text.strip()!r} has {len(cells)} numbers; a load has six in quotes: '0 0 -500 0 0 0'"
            )
        loads.append([number_of("--load-case", cell, kind) for cell, kind in zip(cells, kinds, strict=True)])
    return loads


def _reference(robot: Robot, words: list[str]) -> str | dict[str, float]:
    """Return the value of ``--reference``: a word, or a pose's coordinates by name."""
    if len(words) == 1 and "=" not in words[0]:
        return words[0]
    names = set(parse_items("--reference", words))
    option = "--actuators" if names <= set(robot.description.actuated) else "--platform"
    return single_values(robot, option, words, "--reference")


CALIBRATE = Command(
    _calibrate,
    help="estimate stiffnesses, payload and offsets from measured deflections",
    description="""\
Estimate stiffnesses, payload and offsets from measured deflections, with confidence intervals, unidentifiable parameters
and outliers; or plan measurements.""",
    arguments=(*ROBOT, *(name for name in POSE if name != "near"), *LOADS, "json"),
    own_arguments={
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


# ---- capacity ------------------------------------------------------------------------------------------------------------


def _capacity(args: argparse.Namespace) -> int:
    with waiting("computing the capacity"):
        check_files(args.out, FIGURES)
        limits = {**given_of(("load", "gravity", "sag"), args), **link_loads_of(args)}
        chosen = given_of(("direction",), args)
        if args.mass or args.payload_center is not None or args.payload_link is not None:
            chosen["payload"] = placed_payload(1.0, args)
        configuration, warnings = pose_of(load_robot(args), args)
        found = CAPACITY.called()(configuration, **chosen, **limits)
        for path in args.out:
            save_figure(path, "capacity", configuration, **limits, **given_of(("plane",), args))
    answer(found, args, warnings)
    return 0


CAPACITY = Command(
    _capacity,
    help="compute the largest load or mass before an effort, yield, buckling or a sag is reached",
    description=(
        "Compute the largest force in any direction, factor of a wrench (--direction), or mass (--mass) that the robot may\n"
        "carry besides its weight, and the limit that it reaches."
    ),
    arguments=(*ROBOT, *POSE, "load", "load_on", "gravity", "payload_center", "payload_link", "json"),
    own_arguments={
        "direction": Argument("wrench", "wrench at o whose largest factor is computed [N, N·m]", WRENCH, 6),
        "mass": Argument("flag", "compute the largest mass of a payload"),
        "sag": Argument("length", "largest displacement of o", "SAG"),
        "plane": Argument("text", "plane of the figure (default: xz)", choices=("xy", "xz", "yz")),
        "out": Argument("texts", "draw the largest force over its direction in a plane (.svg, .pdf, .png)", "FILE"),
    },
    function="capacity:capacity",
    notes=VALUES_HELP,
    examples="""
capacity 3rps --platform z=500mm rx=0 ry=0
capacity 3rps --mass --payload-center 0 0 -200mm
capacity 3rps --direction 0 0 -1 0 0 0 --sag 50um --out capacity.svg
""",
)
