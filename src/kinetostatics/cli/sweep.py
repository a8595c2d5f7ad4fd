"""Command sweep: a map of the workspace, written to a file."""

from __future__ import annotations

import argparse
import os
import re
import sys
import time
from typing import TYPE_CHECKING

from kinetostatics.arguments import LOADS, POSE, ROBOT, Argument, Keyword
from kinetostatics.cli.answers import print_warnings
from kinetostatics.cli.commands import Command
from kinetostatics.cli.inputs import grid_of, loads_of
from kinetostatics.cli.options import given_of
from kinetostatics.cli.typed_values import GRID_HELP, VALUES_HELP, parse_items, parse_quantity, parse_values, typed_units, unit_of
from kinetostatics.description.units import typed_number
from kinetostatics.exceptions import ArgumentError
from kinetostatics.layout.renderings import wants_colour
from kinetostatics.progress import waiting

if TYPE_CHECKING:
    import xarray as xr

    from kinetostatics.robot import Robot

INTEGER = re.compile(r"[-+]?\d+")


def _sweep(args: argparse.Namespace) -> int:
    """Compute the map, and print a summary."""
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
                from kinetostatics.reports.map import map_report

                text = map_report(found, seconds).text(wants_colour(sys.stdout))
            print(text)
            print(f"{args.out} was there already" if there else f"wrote {args.out}")
        print_warnings(str(found.attrs.get("warnings", "")).splitlines())
    return 0


def _map(args: argparse.Namespace) -> xr.Dataset:
    """Compute the workspace map of the command line."""
    from kinetostatics.workspace.sweep_arguments import need

    need("xarray")
    parameters = {name: _parameter(name, text) for name, text in parse_items("--set", args.parameters).items()}
    options: dict[str, Keyword] = {"parameters": parameters, "parameter_units": typed_units(args.parameters)}
    if args.platform or args.actuators:
        option, given = grid_of(_first_robot(args, parameters) if args.actuators else None, args)
        options[option[2:]] = given
    options |= given_of(("orientation", "closure_tolerance", "platform_link", "base_link", "outputs", "modes", "workers"), args)
    options |= given_of(("out", "restart"), args)
    return SWEEP.called()(
        args.robot, **loads_of(args), **options, progress=False if args.quiet else None, command_line=args.command_line
    )


def _first_robot(args: argparse.Namespace, parameters: dict[str, object]) -> Robot:
    """Return the robot with the first values of all parameters, which determines the units of the actuators."""
    from kinetostatics.files.bundled import robot_path
    from kinetostatics.robot import load_robot

    first = {name: value[0] if isinstance(value, list) else value for name, value in parameters.items()}
    return load_robot(robot_path(args.robot), first, platform_link=args.platform_link, base_link=args.base_link)


def _parameter(name: str, text: str) -> object:
    """Return the values of a parameter: numbers, a grid of them, several strings, or one."""
    separator = ":" if ":" in text else ","
    parts = [part.strip() for part in text.split(separator)]
    if len(parts) > 1 and all(map(typed_number, parts)) and any(map(_is_quantity, parts)):
        if separator == "," and all(INTEGER.fullmatch(part) for part in parts):
            return [int(part) for part in parts]
        return parse_values("--set", name, text)
    if len(parts) > 1 and separator == ",":
        if not all(parts):
            raise ArgumentError(f"--set: {name}={text} has an empty value between its commas")
        return parts
    if INTEGER.fullmatch(text):
        return int(text)
    return parse_quantity(text) if _is_quantity(text) else text


def _is_quantity(text: str) -> bool:
    """Return whether a text is a number, with a unit or without."""
    found = typed_number(text)
    return found is not None and (not found[1] or unit_of(text) is not None)


SWEEP = Command(
    _sweep,
    help="map sag, stiffness and actuator forces over the workspace",
    description="Analyze all poses of a grid, and variants of the robot, and write one labelled file.",
    arguments=(*ROBOT, *(name for name in POSE if name != "near"), *LOADS, "modes"),
    own={
        "parameters": Argument(
            "items", "values of the file's xacro arguments, or grids of values", "NAME=VALUES", option="--set"
        ),
        "out": Argument("text", "the file to write, .nc or .zarr", "FILE"),
        "restart": Argument("flag", "overwrite FILE"),
        "outputs": Argument(
            "texts",
            "variables, such as twist or beam_stress, or groups of them: default, beams, gravity_mechanisms, compensation",
            "NAME",
        ),
        "workers": Argument("count", "threads (default: as many as cores)", "N"),
        "quiet": Argument("flag", "no progress line and no summary"),
    },
    function="workspace:sweep",
    required=("robot", "out"),
    usage="ROBOT --platform NAME=FROM:TO:COUNT … --out FILE [options]",
    grid=True,
    notes=f"""\
{VALUES_HELP}{GRID_HELP}\
  Parameters of the file may be words too: material=steel,brass.

files:
  FILE.nc is netCDF, FILE.zarr a zarr store; Python opens them with xarray.open_dataset(FILE, engine="h5netcdf" or "zarr").
  While the sweep runs, its blocks are written to FILE.part; after an interruption, the same command continues from there.
""",
    examples="""
sweep 3rps --platform z=0.45:0.65:21 rx=-10deg:10deg:21 ry=-10deg:10deg:21 --out map.nc
sweep 3rps --platform z=500mm rx=-10deg:10deg:41 ry=0 --set rod_diameter=60mm:100mm:5 --out diameters.nc
sweep 3rps --platform z=0.5 azimuth=-180deg:175deg:72 tilt=0:50deg:26 --orientation tilt_torsion --out tilts.nc
sweep 2pru_upr --actuators prismatic_1=-20mm:20mm:9 prismatic_2=0,10mm prismatic_3=0 --outputs default beams --out map.zarr
sweep 3rps --platform z=0.5 azimuth=-170deg tilt=0:40deg:21 --orientation tilt_torsion --outputs gravity_mechanisms --out g.nc
sweep 2pru_upr --platform z=600mm rx=-10deg:10deg:21 ry=-10deg:10deg:21 --outputs default compensation --out corrected.nc
sweep 3rps --platform z=550mm rx=-20deg:20deg:41 ry=-20deg:20deg:41 --modes 3 --out frequencies.nc
sweep gough_stewart --platform z=0.5 x=-0.1:0.1:101 y=-0.1:0.1:101 rx=0 ry=0 rz=0 --outputs twist --out twist.nc
""",
)
