"""Command plot: figures of a workspace map."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from kinetostatics.arguments import Argument
from kinetostatics.cli.answers import save_figure
from kinetostatics.cli.commands import Command
from kinetostatics.cli.options import given_of, value_of
from kinetostatics.cli.typed_values import VALUES_HELP, parse_items, parse_quantity
from kinetostatics.description.units import find_unit
from kinetostatics.exceptions import ArgumentError, near_names
from kinetostatics.progress import waiting

if TYPE_CHECKING:
    import xarray as xr

#: Kinds of figures with their special options.
KINDS = {
    "slice": ("x", "y", "series", "value_range", "rectangular"),
    "surface": ("x", "y", "series", "value_range"),
    "workspace": ("axes", "value_range", "whole"),
    "line": ("x", "series"),
}
#: Smallest and largest dots per inch.
DPI = (10, 2400)


def _plot(args: argparse.Namespace) -> int:
    """Write the figure, or list the quantities that can be drawn."""
    if args.out is None and not args.list:
        raise ArgumentError("--out FILE is missing: the file of the figure")
    with waiting("reading the map" if args.list else "drawing"), checked_map(args.map) as ds:
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
            raise ArgumentError(f"--{name.replace('_', '-')} is not an option of a {kind}")
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
    """Return the values of ``--at`` in SI; strings unchanged."""
    found: dict[str, object] = {}
    for name, text in parse_items("--at", items).items():
        if name not in ds.dims:
            known = [str(dim) for dim in ds["status"].dims]
            raise ArgumentError(f"--at: {name!r} is not swept: {near_names(name, known)}")
        unit = find_unit(str(ds[name].attrs.get("units", "")))
        kind = None if unit is None else unit.kind or None
        try:
            found[name] = parse_quantity(text, kind) if ds[name].dtype.kind in "iuf" else text
        except ArgumentError as error:
            raise ArgumentError(f"--at: {name}: {error}") from None
    return found


def checked_map(path: str) -> xr.Dataset:
    """Open a workspace map, whose arrays are read on demand.

    Raises:
        ArgumentError: the file is not a map, or a library to read it is not installed.
        OSError: there is no such file.
    """
    import kinetostatics.indices  # noqa: F401  # says what to install where xarray is missing

    # isort: split
    import xarray as xr

    file = Path(path)
    if not file.exists():
        raise FileNotFoundError(2, "No such file or directory", path)
    try:
        found = xr.open_zarr(file) if file.is_dir() else xr.open_dataset(file, engine="h5netcdf")
    except ModuleNotFoundError as error:
        raise ArgumentError(f"{path}: reading it needs {error.name}: pip install {error.name}") from None
    except (OSError, ValueError, KeyError) as error:
        raise ArgumentError(f"{path}: not a netCDF file or zarr folder: {error}") from None
    missing = [name for name in ("status", "characteristic_length") if name not in found]
    if missing:
        found.close()
        raise ArgumentError(f"{path}: not a workspace map of kinetostatics sweep: it has no variable {missing[0]!r}")
    return found


def _list(ds: xr.Dataset) -> str:
    from kinetostatics.indices import names, quantity

    lines = ["coordinates"]
    for dim in ds["status"].dims:
        numbers, units = ds[dim].values, ds[dim].attrs.get("units", "")
        first, last = (f"{n:.6g}" if ds[dim].dtype.kind in "iuf" else str(n) for n in (numbers[0], numbers[-1]))
        lines.append(f"  {dim}: {len(numbers)} values, {first} to {last} {units}".rstrip())
    lines.append("quantities")
    one = ds.isel({dim: [0] for dim in ds["status"].dims})
    lines += [f"  {name} [{quantity(one, name).attrs['units']}]" for name in names(ds)]
    return "\n".join(lines)


PLOT = Command(
    _plot,
    help="draw figures of a workspace map",
    description=(
        "Draw a figure of a workspace map written by kinetostatics sweep: a slice in colour, surfaces, the body of reached\n"
        "poses, or lines. Poses without valid numbers are grey and hatched. Slices over azimuth and tilt are round."
    ),
    arguments=("tool",),
    own={
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
