"""Commands on workspace maps: sweep writes a map, plot draws its figures."""

from __future__ import annotations

import argparse
import os
import re
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

from kinetostatics.arguments import Keyword
from kinetostatics.cli.commands import Command
from kinetostatics.cli.inputs import (
    GRID_HELP,
    VALUES_HELP,
    given_of,
    grid_of,
    loads_of,
    option_of,
    parse_items,
    parse_quantity,
    parse_values,
    typed_units,
    unit_of,
    value_of,
)
from kinetostatics.cli.options import LOADS, POSE, ROBOT, Argument
from kinetostatics.cli.output import print_warnings, save_figure
from kinetostatics.exceptions import ArgumentError, near_names
from kinetostatics.layout.renderings import use_colour
from kinetostatics.progress import waiting
from kinetostatics.units import find_unit, typed_number

if TYPE_CHECKING:
    import xarray as xr

    from kinetostatics.robot import Robot

INTEGER = re.compile(r"[-+]?\d+")
#: Kinds of figures, each with the options that not all kinds have.
KINDS = {
    "slice": ("x", "y", "series", "value_range", "rectangular"),
    "surface": ("x", "y", "series", "value_range"),
    "workspace": ("axes", "value_range", "whole"),
    "line": ("x", "series"),
}
#: Smallest and largest dots per inch.
DPI = (10, 2400)

# ---- sweep --------------------------------------------------------------------------------------------------------------


def _sweep(args: argparse.Namespace) -> int:
    """Compute the map, or open it if its file exists, and print a summary."""
    there = os.path.exists(args.out) and not args.restart
    begin = time.perf_counter()
    try:
        ds = _map(args)
    except KeyboardInterrupt:
        part = f"{args.out.rstrip('/')}.part"
        hint = [f"the same command continues from {part}"] if os.path.isdir(part) else []
        raise KeyboardInterrupt(*hint) from None
    with ds:
        if (missing := ds.attrs.get("missing_parts")) is not None:
            count = args.part.partition("/")[2]
            print(
                f"part {args.part} is done; {args.out} will be complete after the parts {', '.join(map(str, missing))} of {count}"
            )
            return 0
        if not args.quiet and "status" not in ds:  # reduced
            print(f"{ds.load().data_vars}\nwrote {args.out}")
        elif not args.quiet:
            seconds = None if there else time.perf_counter() - begin
            with waiting("summing up"):
                from kinetostatics.reports.map import map_report

                text = map_report(ds, seconds).text(use_colour(sys.stdout))
            print(text)
            print(f"{args.out} was there already" if there else f"wrote {args.out}")
        print_warnings(str(ds.attrs.get("warnings", "")).splitlines())
    return 0


def _map(args: argparse.Namespace) -> xr.Dataset:
    parameters = {name: _parameter(name, text) for name, text in parse_items("--set", args.parameters).items()}
    options: dict[str, Keyword] = {"parameters": parameters, "parameter_units": typed_units(args.parameters)}
    if args.platform or args.actuators:
        option, given = grid_of(_first_robot(args, parameters) if args.actuators else None, args)
        options[option[2:]] = given
    options |= given_of(("orientation", "closure_tolerance", "platform_link", "base_link", "outputs", "reduce", "modes"), args)
    options |= given_of(("workers", "out", "restart", "part"), args)
    return SWEEP.called()(
        args.robot, **loads_of(args), **options, progress=False if args.quiet else None, command_line=args.command_line
    )


def _first_robot(args: argparse.Namespace, parameters: dict[str, object]) -> Robot:
    """Return the robot with the first values of all parameters, for the units of its actuators' coordinates."""
    from kinetostatics.files.bundled import robot_path
    from kinetostatics.robot import load_robot

    first = {name: value[0] if isinstance(value, list) else value for name, value in parameters.items()}
    return load_robot(robot_path(args.robot), first, platform_link=args.platform_link, base_link=args.base_link)


def _parameter(name: str, text: str) -> object:
    """Return a value of ``--set`` (a number in SI, or a text), or a list of such values."""
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
    """Whether a text is a number with a known unit or without a unit."""
    number = typed_number(text)
    return number is not None and (not number[1] or unit_of(text) is not None)


SWEEP = Command(
    _sweep,
    help="map sag, stiffness and actuator forces over the workspace",
    description="Analyze all poses of a grid, and variants of the robot, and write one labelled file.",
    arguments=(*ROBOT, *(name for name in POSE if name != "near"), *LOADS, "modes"),
    own_arguments={
        "parameters": Argument(
            "items", "values of the file's xacro arguments, or grids of values", "NAME=VALUES", option="--set"
        ),
        "out": Argument("text", "the file to write, .nc or .zarr", "FILE"),
        "restart": Argument("flag", "overwrite FILE"),
        "part": Argument("text", "compute the K-th of N parts of FILE only, of which other jobs compute the others", "K/N"),
        "outputs": Argument(
            "texts",
            "variables, such as twist, or groups of them: default, beams, limits, capacity, gravity_mechanisms, compensation",
            "NAME",
        ),
        "reduce": Argument(
            "items",
            "reduce dimensions instead of writing the map: max, min, mean, 'quantile 0.95', argmax, argmin (with the pose) or "
            "'count > 50um'; --outputs are then quantities as of plot --list (default: linear_sag)",
            "NAME=OPERATION",
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
sweep 3rps --platform z=0.45:0.65:21 rx=-10deg:10deg:41 ry=-10deg:10deg:41 --reduce rx=argmax ry=argmax --out worst.nc
sweep 3rps --platform z=0.45:0.65:201 rx=-10deg:10deg:201 ry=-10deg:10deg:201 --out map.zarr --part 3/20
sweep 3rps --platform z=550mm rx=-20deg:20deg:41 ry=-20deg:20deg:41 --modes 3 --out frequencies.nc
sweep gough_stewart --platform z=0.5 x=-0.1:0.1:101 y=-0.1:0.1:101 rx=0 ry=0 rz=0 --outputs twist --out twist.nc
""",
)


# ---- plot --------------------------------------------------------------------------------------------------------------


def _plot(args: argparse.Namespace) -> int:
    if args.out is None and not args.list:
        raise ArgumentError("--out FILE is missing: the file of the figure")
    with waiting("reading the map" if args.list else "drawing"), open_map(args.map) as ds:
        if args.list:
            text = _list(ds)
        else:
            _draw(ds, args)
            text = f"wrote {args.out}"
    print(text)
    return 0


def _draw(ds: xr.Dataset, args: argparse.Namespace) -> None:
    kind = args.kind or "slice"
    for name in sorted({name for names in KINDS.values() for name in names} - {*KINDS[kind]}):
        if value_of(name, args) is not None:
            raise ArgumentError(f"{option_of(name)} is not an option of a {kind}")
    if (tool := value_of("tool", args)) is not None:
        from kinetostatics.indices import at_point

        ds = at_point(ds, tool)
    dpi = 300.0 if args.dpi is None else value_of("dpi", args)
    if not DPI[0] <= dpi <= DPI[1]:
        raise ArgumentError(f"--dpi: {dpi:g} is not between {DPI[0]} and {DPI[1]} dots per inch")
    what = args.what or ["linear_sag"]
    if len(what) > 1 and kind != "line":
        raise ArgumentError(f"a {kind} shows one quantity, not {len(what)}")
    options = {"at": _at(ds, args.at), **given_of(("x", "y", "axes", "series", "unit", "beyond_limits"), args)}
    if args.value_range is not None:
        options["value_range"] = tuple(value_of("value_range", args))
    if args.rectangular:
        options["polar"] = False
    if args.whole:
        options["cut"] = False
    save_figure(args.out, kind, ds, what if kind == "line" else what[0], dpi=dpi, **options)


def _at(ds: xr.Dataset, items: list[str]) -> dict[str, object]:
    """Return the values of ``--at`` by name: numbers in SI, texts unchanged."""
    values: dict[str, object] = {}
    for name, text in parse_items("--at", items).items():
        if name not in ds.dims:
            names = [str(dim) for dim in ds["status"].dims]
            raise ArgumentError(f"--at: {name!r} is not swept: {near_names(name, names)}")
        unit = find_unit(str(ds[name].attrs.get("units", "")))
        kind = None if unit is None else unit.kind or None
        try:
            values[name] = parse_quantity(text, kind) if ds[name].dtype.kind in "iuf" else text
        except ArgumentError as error:
            raise ArgumentError(f"--at: {name}: {error}") from None
    return values


def open_map(path: str) -> xr.Dataset:
    """Open a workspace map; its arrays are read when they are used. Raise an ArgumentError if the file is no map."""
    import kinetostatics.indices  # noqa: F401  # raises an error if xarray is missing

    # isort: split
    import xarray as xr

    file = Path(path)
    if not file.exists():
        raise FileNotFoundError(2, "No such file or directory", path)
    try:
        ds = xr.open_zarr(file) if file.is_dir() else xr.open_dataset(file, engine="h5netcdf")
    except ModuleNotFoundError as error:
        raise ArgumentError(f"{path}: reading it needs {error.name}: pip install {error.name}") from None
    except (OSError, ValueError, KeyError) as error:
        raise ArgumentError(f"{path}: not a netCDF file or zarr folder: {error}") from None
    missing = [name for name in ("status", "characteristic_length") if name not in ds]
    if missing:
        ds.close()
        raise ArgumentError(f"{path}: not a workspace map of kinetostatics sweep: it has no variable {missing[0]!r}")
    return ds


def _list(ds: xr.Dataset) -> str:
    from kinetostatics.indices import names, quantity

    lines = ["coordinates"]
    for dim in ds["status"].dims:
        numbers, units = ds[dim].values, ds[dim].attrs.get("units", "")
        first, last = (f"{n:.6g}" if ds[dim].dtype.kind in "iuf" else str(n) for n in (numbers[0], numbers[-1]))
        lines.append(f"  {dim}: {len(numbers)} values, {first} to {last} {units}".rstrip())
    lines.append("quantities")
    first_pose = ds.isel({dim: [0] for dim in ds["status"].dims})
    lines += [f"  {name} [{quantity(first_pose, name).attrs['units']}]" for name in names(ds)]
    return "\n".join(lines)


PLOT = Command(
    _plot,
    help="draw figures of a workspace map",
    description=(
        "Draw a figure of a workspace map written by kinetostatics sweep: a slice in colour, surfaces, the body of reached\n"
        "poses, or lines. Poses without valid numbers are grey and hatched. Slices over azimuth and tilt are round."
    ),
    arguments=("tool",),
    own_arguments={
        "map": Argument("text", "netCDF file (.nc) or zarr folder", "MAP", option="map"),
        "list": Argument("flag", "print the coordinates and quantities of the map"),
        "out": Argument("text", "the figure to write: .pdf, .svg or .png", "FILE"),
        "kind": Argument("text", "kind of the figure (default: slice)", choices=tuple(KINDS)),
        "what": Argument("texts", "the quantity, as --list names it; a line may show several (default: linear_sag)", "WHAT"),
        "x": Argument("text", "coordinate to the right (default: the first that is not fixed)", "NAME"),
        "y": Argument("text", "coordinate upwards, or backwards for surfaces (default: the next one)", "NAME"),
        "axes": Argument("names", "axes of a workspace: three coordinates, or x y z for the position of o", ("A", "B", "C"), 3),
        "series": Argument("text", "coordinate that distinguishes lines, surfaces or slices", "NAME"),
        "at": Argument(
            "items",
            "values of all other coordinates, loads and parameters that vary, such as ry=0deg z=0.5; the nearest pose of the map "
            "is shown",
            "NAME=VALUE",
        ),
        "unit": Argument("text", "unit of the quantity, such as µm, deg, kN, N/µm (default: chosen by magnitude)", "UNIT"),
        "value_range": Argument(
            "number", "range of colours, or of heights of a surface, in the unit of the figure", ("LOW", "HIGH"), 2
        ),
        "rectangular": Argument("flag", "draw a slice over azimuth and tilt with rectangular axes"),
        "whole": Argument("flag", "do not cut a workspace open"),
        "beyond_limits": Argument("flag", "include poses beyond joint limits"),
        "dpi": Argument("number", "dots per inch of a PNG (default: 300)", "N"),
    },
    required=("map",),
    usage="MAP [options]",
    notes=VALUES_HELP,
    examples="""
plot map.nc --list
plot map.nc --what linear_sag --x rx --y ry --at z=0.5 --out sag.svg
plot map.nc --kind surface --what twist:x --x rx --y ry --series z --unit µm --out twist.pdf
plot tilts.nc --x azimuth --y tilt --out round.pdf
plot map.nc --kind workspace --what least_translational_stiffness --unit N/µm --out stiffness.png
plot map.nc --what "deflection_any_direction(500 N)" --x rx --y ry --at z=0.5 --out softest.svg
plot map.nc --kind line --what actuator_force:prismatic_1 --x z --series rx --at ry=0deg --out force.pdf
plot g.nc --kind line --what gravity_mechanism:attached:z gravity_mechanism:deformation:z --x tilt --out g.pdf
""",
)
