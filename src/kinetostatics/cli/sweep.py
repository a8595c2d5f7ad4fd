"""``kinetostatics sweep``: a map of the workspace, written to a file."""

from __future__ import annotations

import argparse
import os
import re
import sys
import time
from typing import TYPE_CHECKING

from kinetostatics.argument_checks import Keyword
from kinetostatics.cli import answers, arguments, poses
from kinetostatics.description.units import typed_number
from kinetostatics.exceptions import ArgumentError
from kinetostatics.printing.waiting import waiting

if TYPE_CHECKING:
    import xarray as xr

    from kinetostatics.robot import Robot


INTEGER = re.compile(r"[-+]?\d+")

USAGE = "ROBOT --platform NAME=FROM:TO:COUNT … --out FILE [options]"
HELP = "map sag, stiffness and actuator forces over the workspace"
DESCRIPTION = "Analyze all poses of a grid, and variants of the robot, and write one labelled file."
EXAMPLES = f"""\
{arguments.VALUES_HELP}
  FROM:TO:COUNT and A,B,C are dimensions of the grid, whose poses are all combinations of their values.
  Parameters of the file may be words too: material=steel,brass.

files:
  FILE.nc is netCDF, FILE.zarr a zarr store; Python opens them with xarray.open_dataset(FILE, engine="h5netcdf" or "zarr").
  While the sweep runs, its blocks lie in FILE.part; if it is interrupted, the same command goes on with it.

examples:
  kinetostatics sweep 3rps --platform z=0.45:0.65:21 rx=-10deg:10deg:21 ry=-10deg:10deg:21 --out map.nc
  kinetostatics sweep 3rps --platform z=500mm rx=-10deg:10deg:41 ry=0 --set rod_diameter=60mm:100mm:5 --out diameters.nc
  kinetostatics sweep 3rps --platform z=0.5 azimuth=-180deg:175deg:72 tilt=0:50deg:26 --orientation tilt_torsion --out tilts.nc
  kinetostatics sweep 2pru_upr --actuators prismatic_1=-20mm:20mm:9 prismatic_2=0,10mm prismatic_3=0 --beams --out map.zarr
  kinetostatics sweep 3rps --platform z=0.5 azimuth=-170deg tilt=0:40deg:21 --orientation tilt_torsion --ways --out ways.nc
  kinetostatics sweep 2pru_upr --platform z=600mm rx=-10deg:10deg:21 ry=-10deg:10deg:21 --compensate --out corrected.nc
  kinetostatics sweep gough_stewart --platform z=0.5 x=-0.1:0.1:101 y=-0.1:0.1:101 rx=0 ry=0 rz=0 --outputs twist --out twist.nc
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    arguments.add_robot_arguments(parser, "VALUES")
    poses.add_pose_arguments(parser, "VALUES", "The grid. Default: all actuators at zero.", near=False)
    arguments.add_load_arguments(parser)
    arguments.add_engine_argument(parser)
    group = parser.add_argument_group("sweep")
    group.add_argument("--out", metavar="FILE", required=True, help="the file to write, .nc or .zarr")
    group.add_argument("--restart", action="store_true", help="overwrite FILE")
    group.add_argument("--beams", action="store_true", help="add stresses and deflections of the beams, which takes longer")
    group.add_argument(
        "--ways",
        action="store_true",
        help="add how gravity acts on twist and actuators: by the platform's weight, by attached wrenches, by deformation",
    )
    group.add_argument(
        "--compensate",
        action="store_true",
        help="add corrections of the actuators for weights and loads, and what then remains",
    )
    group.add_argument(
        "--outputs", metavar="NAME", nargs="+", help="only these variables, such as twist or beam_stress, besides status and pose"
    )
    group.add_argument("--workers", metavar="N", help="threads (default: as many as cores)")
    group.add_argument("--quiet", action="store_true", help="no progress line and no summary")


def run(args: argparse.Namespace) -> int:
    """Sweep, and say what came of it."""
    there = os.path.exists(args.out) and not args.restart
    begin = time.perf_counter()
    try:
        found = _map(args)
    except KeyboardInterrupt:
        part = f"{args.out.rstrip('/')}.part"
        if os.path.isdir(part):
            print(f"kinetostatics: interrupted; the same command goes on with what is in {part}", file=sys.stderr)
        raise
    with found:
        if not args.quiet:
            seconds = None if there else time.perf_counter() - begin
            with waiting("summing up"):
                from kinetostatics.workspace.summary import summary

                text = summary(found, seconds)
            print(text)
            print(f"{args.out} was there already" if there else f"wrote {args.out}")
        answers.print_warnings(str(found.attrs.get("warnings", "")).splitlines())
    return 0


def _map(args: argparse.Namespace) -> xr.Dataset:
    """Return the map."""
    from kinetostatics.workspace import sweep
    from kinetostatics.workspace.arguments import need

    need("xarray")
    options = {**arguments.load_options(args), **_grid(args)}
    return sweep(
        args.robot,
        **options,
        closure_tolerance=poses.closure_tolerance_of(args),
        engine=args.engine,
        beams=args.beams,
        ways=args.ways,
        compensate=args.compensate,
        outputs=args.outputs,
        out=args.out,
        restart=args.restart,
        workers=None if args.workers is None else arguments.whole_number_of("--workers", args.workers),
        progress=False if args.quiet else None,
        platform_link=args.platform_link,
        base_link=args.base_link,
        command_line=args.command_line,
    )


def _grid(args: argparse.Namespace) -> dict[str, Keyword]:
    """Return coordinates and parameters as :func:`kinetostatics.sweep` takes them."""
    parameters = {name: _parameter(name, text) for name, text in arguments.parse_items("--set", args.parameters).items()}
    found: dict[str, object] = {"parameters": parameters, "orientation": args.orientation}
    found["parameter_units"] = arguments.typed_units(args.parameters)
    if args.platform or args.actuators:
        option, given = poses.grid(_first_robot(args, parameters) if args.actuators else None, args)
        found[option[2:]] = given
    return found


def _first_robot(args: argparse.Namespace, parameters: dict[str, object]) -> Robot:
    """Return the robot with the first values of all parameters, to know which actuators turn."""
    from kinetostatics.files.bundled import robot_path
    from kinetostatics.robot import load_robot

    first = {name: value[0] if isinstance(value, list) else value for name, value in parameters.items()}
    return load_robot(robot_path(args.robot), first, platform=args.platform_link, base=args.base_link)


def _parameter(name: str, text: str) -> object:
    """Return the values of a parameter: numbers, a grid of them, several strings, or one."""
    separator = ":" if ":" in text else ","
    parts = [part.strip() for part in text.split(separator)]
    if len(parts) > 1 and all(map(typed_number, parts)) and any(map(_is_quantity, parts)):
        if separator == "," and all(INTEGER.fullmatch(part) for part in parts):
            return [int(part) for part in parts]
        return arguments.parse_values("--set", name, text)
    if len(parts) > 1 and separator == ",":
        if not all(parts):
            raise ArgumentError(f"--set: {name}={text} has an empty value between its commas")
        return parts
    if INTEGER.fullmatch(text):
        return int(text)
    return arguments.parse_quantity(text) if _is_quantity(text) else text


def _is_quantity(text: str) -> bool:
    """Return whether a text is a number, with a unit or without."""
    found = typed_number(text)
    return found is not None and (not found[1] or arguments.unit_of(text) is not None)
