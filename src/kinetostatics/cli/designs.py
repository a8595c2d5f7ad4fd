"""Commands on designs: tolerances, sensitivities, optimize."""

from __future__ import annotations

import argparse
from dataclasses import replace

from kinetostatics.arguments import LOADS, POSE, ROBOT, Argument, Keyword
from kinetostatics.cli.answers import answer, save_files
from kinetostatics.cli.commands import Command
from kinetostatics.cli.inputs import grid_of, load_robot, loads_of, pose_of
from kinetostatics.cli.options import FIGURES, check_files, given_of, value_of
from kinetostatics.cli.typed_values import VALUES_HELP, parse_parameters
from kinetostatics.progress import waiting

# ---- tolerances ----------------------------------------------------------------------------------------------------------


def _tolerances(args: argparse.Namespace) -> int:
    """Print the effects of the tolerances and the random variation, and write figures."""
    with waiting("computing effects of tolerances"):
        check_files(args.out, FIGURES)
        options = {**loads_of(args), **given_of(("tolerances", "rank_by", "samples", "distribution", "seed", "tool"), args)}
        top = value_of("top", args)
        configuration, warnings = pose_of(load_robot(args), args)
        found = TOLERANCES.called()(configuration, **options)
        save_files(args.out, "tolerances", found, what=args.what or "displacement")
        if top is not None:
            found = replace(found, effects=dict([*found.effects.items()][:top]))
        shown = found.to_dict() if args.json else found.report()
    answer(shown, warnings, args.out)
    return 0


TOLERANCES = Command(
    _tolerances,
    help="rank manufacturing errors by pose error and internal force",
    description=(
        "Rank manufacturing errors by the pose error and the internal force that each causes, with the worst case, the standard\n"
        "deviation and random samples of sag, stiffness and actuator forces at one pose."
    ),
    arguments=(*ROBOT, *POSE, *LOADS, "tool", "seed", "json"),
    own={
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
    """Print the sensitivities of parameters and parts, and write figures."""
    with waiting("changing parameters one by one"):
        check_files(args.out, FIGURES)
        options = {**loads_of(args), **given_of(("by", "outputs", "tool"), args)}
        configuration, warnings = pose_of(load_robot(args), args)
        found = SENSITIVITIES.called()(configuration, **options)
        save_files(args.out, "sensitivities", found)
        shown = found.to_dict() if args.json else found.report()
    answer(shown, warnings, args.out)
    return 0


SENSITIVITIES = Command(
    _sensitivities,
    help="rank parameters and parts by their effect on sag, forces and mass",
    description=(
        "Differentiate sag, forces and mass at one pose with respect to the arguments of the robot's file, or to\n"
        "dimensions of its parts, and to the stiffness of every elastic part, and rank them by their effect on the platform."
    ),
    arguments=(*ROBOT, *POSE, *LOADS, "tool", "by", "outputs", "json"),
    own={"out": Argument("texts", "write a bar chart (.svg, .pdf, .png)", "FILE")},
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
    """Print the optimum, or the Pareto front, and write robots, tables and figures."""
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
            found: Keyword = pareto(args.robot, minimize=both, **options, **given_of(("points",), args))
        else:
            found = OPTIMIZE.called()(args.robot, **options, **given_of(("minimize",), args))
        save_files(args.out, "pareto", found)
        shown = found.to_dict() if args.json else found.report()
    answer(shown, (), args.out)
    return 0 if front or found.feasible else 1


OPTIMIZE = Command(
    _optimize,
    help="size a robot: the lightest rods that are stiff enough",
    description="Find the optimal parameters of a robot, under requirements at every pose of a grid.",
    arguments=(*ROBOT, *(name for name in POSE if name != "near"), *LOADS, "tool", "json"),
    own={
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
