"""Gauges, from a table or from Python, and their readings for a twist [d; r] of the platform at o.

A gauge of direction u at the arm a from o reads the displacement u · d + (a × u) · r, or the rotation u · r.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence

import numpy as np

from kinetostatics.arguments import Keyword, check_choice, check_mapping, finite_numbers, positive
from kinetostatics.description.gauges import COMPONENTS, Gauge
from kinetostatics.description.units import parse_number
from kinetostatics.exceptions import ArgumentError
from kinetostatics.files.csv_tables import read_csv, with_unit
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.math.arrays import Array, Index
from kinetostatics.math.linalg import cross
from kinetostatics.robot import robot_of

#: Columns of a table of gauges, and kinds of their numbers; None: words.
COLUMNS = {
    **{"name": None, "frame": None, "measures": None, "sigma": "length"},
    **dict.fromkeys(("x", "y", "z"), "length"),
    **dict.fromkeys(("ux", "uy", "uz"), "number"),
}


def read_gauges(given: str | os.PathLike[str] | Mapping[str, Gauge] | None) -> dict[str, Gauge]:
    """Return gauges by name, including those for the components of the twist.

    Args:
        given: None, a mapping from names to :class:`Gauge`, or the path of a CSV file.

    Raises:
        ArgumentError: a gauge is invalid.
    """
    if given is None:
        return dict(COMPONENTS)
    if isinstance(given, (str, os.PathLike)):
        found = _read_file(os.fspath(given))
    else:
        check_mapping("gauges", given, '{"tip": ks.Gauge(direction=(0, 0, 1), point=(0.1, 0, 0), frame="platform")}')
        found = {f"gauges: {name}": (name, gauge) for name, gauge in given.items()}
    return {**COMPONENTS, **{name: _checked(where, gauge) for where, (name, gauge) in found.items()}}


def _checked(where: str, gauge: object) -> Gauge:
    if not isinstance(gauge, Gauge):
        raise ArgumentError(f"{where} is {gauge!r}; it must be a gauge, such as ks.Gauge(direction=(0, 0, 1))")
    direction = finite_numbers(f"{where}: direction", gauge.direction)
    point = finite_numbers(f"{where}: point", (0, 0, 0) if gauge.point is None else gauge.point)
    if direction.shape != (3,) or point.shape != (3,) or not np.any(direction):
        raise ArgumentError(f"{where}: direction and point must have three numbers each, and direction must not be zero")
    check_choice(f"{where}: frame", gauge.frame, ("world", "platform"))
    check_choice(f"{where}: measures", gauge.measures, ("displacement", "rotation"))
    if gauge.sigma is not None:
        positive(f"{where}: sigma", gauge.sigma, "a positive number [m, rad], the standard deviation of a reading")
    return gauge


def _read_file(path: str) -> dict[str, tuple[str, Gauge]]:
    """Return names and gauges by their places in the file."""
    example = "a table of gauges has a line of titles, such as name,x [mm],y [mm],z [mm],ux,uy,uz, and one of each"
    table = read_csv(path, example, COLUMNS, ("name", "ux", "uy", "uz"))
    found: dict[str, tuple[str, Gauge]] = {}
    for line, row in table.rows:
        where, texts = table.where(line), {name: cell for name, cell in zip(table.names, row, strict=True) if cell}
        kinds = {**COLUMNS, "sigma": "angle" if texts.get("measures") == "rotation" else "length"}
        cells: dict[str, Keyword] = {
            name: cell if (kind := kinds[name]) is None else parse_number(cell, kind, f"{where}: {name}")
            for name, cell in texts.items()
        }
        name = str(cells.pop("name", ""))
        if not name or any(name == known for known, _ in found.values()):
            raise ArgumentError(f"{where}: a gauge needs a unique name, got {name!r}")
        direction = cells.pop("ux", 0.0), cells.pop("uy", 0.0), cells.pop("uz", 0.0)
        point = tuple(cells.pop(axis) for axis in "xyz" if axis in cells)
        if len(point) in (1, 2):
            raise ArgumentError(f"{where}: a coordinate x, y or z of the point is missing; omit all three for o")
        found[where] = (name, Gauge(direction, point=point or None, **cells))
    return found


def number_in(cell: object, unit: str, kind: str, what: str) -> float:
    """Return the number of a cell in SI; a cell without a unit has the unit of its column, ``unit``.

    Raises:
        ArgumentError: the cell is no number, or has a unit of another kind.
    """
    text = repr(float(cell)) if isinstance(cell, (int, float, np.number)) else str(cell).strip()
    return parse_number(with_unit(text, unit), kind, what)


def readings_by_twist(gauges: Sequence[Gauge], which: Index, pose: Configuration, rows: Index) -> Array:
    """Return the rows (n, 6), whose products with twists at o are the readings, world axes [1, m].

    Args:
        gauges: all gauges.
        which: (n,) index of the gauge of each reading.
        pose: a batch of poses.
        rows: (n,) index of the pose of each reading.
    """
    R, o = robot_of(pose).mechanism.platform_pose(pose.frames)
    found = np.zeros((len(which), 6))
    for k, gauge in enumerate(gauges):
        mine = which == k
        turn, origin = R[..., rows[mine]], o[:, rows[mine]]
        u = np.array(gauge.direction, dtype=float)[:, None] / np.linalg.norm(gauge.direction)
        arm = np.zeros((3, 1)) if gauge.point is None else np.array(gauge.point, dtype=float)[:, None]
        if gauge.frame == "platform":
            u, arm = (np.einsum("ijn,j->in", turn, vector[:, 0]) for vector in (u, arm))
        elif gauge.point is not None:
            arm = arm - origin
        u, arm = np.broadcast_to(u, origin.shape), np.broadcast_to(arm, origin.shape)
        part = slice(0, 3) if gauge.measures == "displacement" else slice(3, 6)
        found[mine, part] = u.T
        if gauge.measures == "displacement":
            found[mine, 3:] = cross(arm, u).T  # u·(d + r × arm) = u·d + (arm × u)·r
    return found
