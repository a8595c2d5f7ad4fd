"""``kinetostatics plot``: figures of a workspace map."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from kinetostatics.cli.answers import save_figure
from kinetostatics.cli.arguments import SEVERAL, VALUES_HELP, number_of, parse_items, parse_quantity
from kinetostatics.description.units import find_unit
from kinetostatics.exceptions import ArgumentError, near_names
from kinetostatics.printing.waiting import waiting

if TYPE_CHECKING:
    import xarray as xr

KINDS = ("slice", "surface", "workspace", "line")

USAGE = "MAP [options]"
HELP = "draw figures of a workspace map"
DESCRIPTION = (
    "Draw a figure of a workspace map that kinetostatics sweep wrote: a slice in colour, surfaces, the body\n"
    "of the poses that are reached, or lines. Poses without valid numbers are grey and hatched. Slices over\n"
    "azimuth and tilt are round."
)
EXAMPLES = f"""\
{VALUES_HELP}
examples:
  kinetostatics plot map.nc --list
  kinetostatics plot map.nc --what linear_sag --x rx --y ry --at z=0.5 --out sag.svg
  kinetostatics plot map.nc --kind surface --what twist:x --x rx --y ry --over z --unit µm --out twist.pdf
  kinetostatics plot tilts.nc --x azimuth --y tilt --out round.pdf
  kinetostatics plot map.nc --kind workspace --what least_translational_stiffness --unit N/µm --out stiffness.png
  kinetostatics plot map.nc --what "deflection_any_direction(500 N)" --x rx --y ry --at z=0.5 --out softest.svg
  kinetostatics plot map.nc --kind line --what actuator_force:prismatic_1 --x z --series rx --at ry=0deg --out force.pdf
  kinetostatics plot ways.nc --kind line --what gravity_way:attached:z gravity_way:deformation:z --x tilt --out ways.pdf
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.add_argument("map", metavar="MAP", help="netCDF file (.nc) or zarr folder")
    parser.add_argument("--list", action="store_true", help="print the coordinates and the quantities that can be drawn, and end")
    parser.add_argument("--out", metavar="FILE", help="where to write the figure: .pdf, .svg or .png")
    parser.add_argument("--kind", choices=KINDS, default="slice", help="of the figure (default: %(default)s)")
    parser.add_argument(
        "--what",
        metavar="WHAT",
        nargs="+",
        default=["linear_sag"],
        help="the quantity, as --list names it; a line may show several (default: linear_sag)",
    )
    parser.add_argument("--x", metavar="NAME", help="coordinate to the right (default: the first that is not fixed)")
    parser.add_argument("--y", metavar="NAME", help="coordinate upwards, or backwards for surfaces (default: the next one)")
    parser.add_argument(
        "--axes", metavar=("A", "B", "C"), nargs=3, help="of a workspace: three coordinates, or x y z for where o is"
    )
    parser.add_argument("--over", metavar="NAME", help="coordinate that tells surfaces apart")
    parser.add_argument("--series", metavar="NAME", help="coordinate that tells lines apart")
    parser.add_argument(
        "--at",
        metavar="NAME=VALUE",
        **SEVERAL,
        help="values of all other coordinates, loads and parameters that vary, such as ry=0deg z=0.5; the nearest pose of the "
        "map is shown",
    )
    parser.add_argument(
        "--point",
        metavar=("X", "Y", "Z"),
        nargs=3,
        help="a point of the platform, such as a tool's tip, from o in its axes: the quantity is told of it instead of o",
    )
    parser.add_argument("--unit", help="of the quantity, such as µm, deg, kN, N/µm (default: what suits)")
    parser.add_argument(
        "--limits", metavar=("LOW", "HIGH"), nargs=2, help="of colours, or of a surface's heights, in the figure's unit"
    )
    parser.add_argument("--rectangular", action="store_true", help="a slice over azimuth and tilt is not to be round")
    parser.add_argument("--whole", action="store_true", help="do not cut a workspace open")
    parser.add_argument("--beyond-limits", action="store_true", help="poses beyond the joints' limits count like all others")
    parser.add_argument("--dpi", metavar="N", default="300", help="dots per inch of a PNG (default: %(default)s)")


def run(args: argparse.Namespace) -> int:
    """Write the figure."""
    if args.out is None and not args.list:
        raise ArgumentError("--out FILE is missing: where to write the figure")
    with waiting("reading the map" if args.list else "drawing"), checked_map(args.map) as ds:
        if args.list:
            said = _list(ds)
        else:
            if args.point is not None:
                from kinetostatics.indices import at_point

                ds = at_point(ds, [number_of("--point", text, "length") for text in args.point])
            _draw(ds, args)
            said = f"wrote {args.out}"
    print(said)
    return 0


def _draw(ds: xr.Dataset, args: argparse.Namespace) -> None:
    for name in ("x", "y", "axes", "over", "series", "limits", "whole", "rectangular"):
        if getattr(args, name) not in (None, False) and name not in _TAKES[args.kind]:
            raise ArgumentError(f"--{name} is not an option of a {args.kind}")
    options: dict[str, object] = {"at": _at(ds, args.at), "unit": args.unit, "beyond_limits": args.beyond_limits}
    dpi = number_of("--dpi", args.dpi)
    if not DPI[0] <= dpi <= DPI[1]:
        raise ArgumentError(f"--dpi: {dpi:g} is not between {DPI[0]} and {DPI[1]} dots per inch")
    if len(args.what) > 1 and args.kind != "line":
        raise ArgumentError(f"a {args.kind} shows one quantity, not {len(args.what)}")
    if args.limits is not None:
        options["limits"] = tuple(number_of("--limits", text) for text in args.limits)
    if args.rectangular:
        options["polar"] = False
    if args.whole:
        options["cut"] = False
    options |= {name: getattr(args, name) for name in ("x", "y", "axes", "over", "series") if name in _TAKES[args.kind]}
    save_figure(args.out, args.kind, ds, args.what if args.kind == "line" else args.what[0], dpi=dpi, **options)


#: Options of the kinds of figures that not all have.
_TAKES = {
    "slice": ("x", "y", "limits", "rectangular"),
    "surface": ("x", "y", "over", "limits"),
    "workspace": ("axes", "limits", "whole"),
    "line": ("x", "series"),
}
#: Dots per inch that make sense of a page as large as a column.
DPI = (10, 2400)


def _at(ds: xr.Dataset, items: list[str]) -> dict[str, object]:
    """Return the values of ``--at`` in SI; names, which some parameters have for values, as they stand."""
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
    """Open a map lazily.

    Raises:
        ArgumentError: the file is not a map, or what reads it is not installed.
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
