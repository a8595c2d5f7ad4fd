"""Placement of limbs by symmetry or by a table. A limb leads from its base point to its platform point; base axes are X, Y, Z."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from kinetostatics.arguments import check_choice, finite_numbers
from kinetostatics.authoring.limb_parts import Skeleton
from kinetostatics.authoring.notation import Architecture
from kinetostatics.exceptions import ArgumentError, near_names
from kinetostatics.files.csv_tables import read_csv
from kinetostatics.units import parse_number

Point = tuple[float, float, float]

#: Arrangements of limbs without a table.
ARRANGEMENTS = SYMMETRIC, PLANAR, CARTESIAN, SPHERICAL = ("symmetric", "planar", "cartesian", "spherical")
#: Names of directions of guides and revolute axes.
DIRECTIONS = ("vertical", "radial", "tangential")
#: Columns of a table, and kinds of their numbers.
COLUMNS = {"base": "length", "platform": "length", "axis": "number", "guide": "number"}
ROW = '{"base": (0.3, 0, 0), "platform": (0.2, 0, 0)}, with "axis" of its revolute joints and "guide" of its carriage if need be'


@dataclass(frozen=True)
class Angle:
    """An angle as an expression of the file, and its value [rad]."""

    text: str
    value: float


@dataclass(frozen=True)
class LimbPlace:
    """Placement of a limb.

    Attributes:
        base, platform: base point in the base's frame and platform point in the platform's frame [m].
        at_base, at_platform: azimuths of the ends; None if the ends are placed by their coordinates.
        base_text, platform_text: expressions of the ends' coordinates; empty if the ends are placed by azimuths.
        axis: direction of the revolute axes in the base: one of ``DIRECTIONS``, a vector, or None: perpendicular to the limb.
        guide: direction of the carriage's guide: one of ``DIRECTIONS`` or a vector.
    """

    base: Point
    platform: Point
    at_base: Angle | None = None
    at_platform: Angle | None = None
    base_text: str = ""
    platform_text: str = ""
    axis: str | Point | None = None
    guide: str | Point = "vertical"


def direction(word: str | Point, azimuth: float) -> Point:
    """Return one of ``DIRECTIONS`` as a vector in base axes, for a limb at ``azimuth``; a vector is returned unchanged."""
    if not isinstance(word, str):
        return word
    c, s = math.cos(azimuth), math.sin(azimuth)
    return {"vertical": (0.0, 0.0, 1.0), "radial": (c, s, 0.0), "tangential": (-s, c, 0.0)}[word]


def limb_line(place: LimbPlace, height: float) -> np.ndarray:
    """Return the vector (3,) [m] from base point to platform point in the limb's frame, with all joints at zero.

    The formulas are those of the macro ``limb_frame`` of the library.
    """
    base, platform = np.array(place.base), np.array(place.platform)
    line = platform - base + np.array([0.0, 0.0, height])
    nearer = base if np.hypot(*base[:2]) > 1e-9 else platform
    azimuth = math.atan2(nearer[1], nearer[0]) if np.hypot(*nearer[:2]) > 1e-9 else 0.0
    if place.axis is None:
        out = line[0] * math.cos(azimuth) + line[1] * math.sin(azimuth)
        aside = line[1] * math.cos(azimuth) - line[0] * math.sin(azimuth)
        size = 1e-9 * np.linalg.norm(line)
        skew = 0.0 if abs(aside) <= size else math.pi / 2 if abs(out) <= size else math.atan(aside / out)
        axis = (-math.sin(azimuth + skew), math.cos(azimuth + skew), 0.0)
        turn, tilt = azimuth + skew, 0.0
    else:
        axis = direction(place.axis, azimuth)
        flat = math.hypot(axis[0], axis[1])
        upright = flat <= 1e-9 * abs(axis[2])
        turn = azimuth if upright else math.atan2(-axis[0], axis[1])
        tilt = math.copysign(math.pi / 2, axis[2]) if upright else math.atan2(axis[2], flat)
    ahead = line[0] * math.cos(turn) + line[1] * math.sin(turn)
    across = line[1] * math.cos(turn) - line[0] * math.sin(turn)
    sine, cosine = math.sin(tilt), math.cos(tilt)
    return np.array([ahead, across * cosine + line[2] * sine, line[2] * cosine - across * sine])


# ---- arrangements --------------------------------------------------------------------------------------------------


def azimuths_of(architecture: Architecture, given: Sequence[float] | None) -> list[float | None]:
    """Return the azimuths of the limbs [rad]; None for a limb at the centre.

    By default limbs are evenly spaced about Z, with two exceptions. Of 2 + 1 limbs, the two equal limbs are at Y and −Y, the
    third at X. A single limb beside three or more equal limbs is at the centre.
    """
    count = len(architecture.limbs)
    if given is not None:
        angles = finite_numbers("azimuths", given)
        if angles.shape != (count,):
            raise ArgumentError(
                f"azimuths has {angles.size} values; {architecture.text} has {count} limbs, and each needs one [rad]"
            )
        return [float(angle) for angle in angles]
    counts = [group.count for group in architecture.groups]
    if counts == [2, 1]:
        return [math.pi / 2, -math.pi / 2, 0.0]
    if len(counts) == 2 and counts[1] == 1 and counts[0] >= 3:
        return [*(2 * math.pi * k / counts[0] for k in range(counts[0])), None]
    return [2 * math.pi * k / count for k in range(count)]


def _angle_in_degrees(angle: float) -> Angle:
    degrees = round(math.degrees(angle), 9)
    exact = math.isclose(math.radians(degrees), angle, rel_tol=1e-15, abs_tol=1e-15)
    text = f"radians({degrees:g})" if exact and float(f"{degrees:g}") == degrees else repr(float(angle))
    return Angle(text, angle)


def place_by_arrangement(
    architecture: Architecture,
    skeletons: Sequence[Skeleton],
    arrangement: str,
    azimuths: Sequence[float] | None,
    values: Mapping[str, float],
    guide: str,
    axis: str | None,
) -> list[LimbPlace]:
    """Return the placements of limbs by an arrangement, one of ``ARRANGEMENTS``.

    Args:
        architecture, skeletons: the limbs.
        arrangement: if "planar", all revolute axes are vertical; if "cartesian", azimuths, guide and axis are not used.
        azimuths: azimuths of the limbs [rad]; None: evenly spaced.
        values: base_radius, base_height, platform_radius [m], base_spread, platform_spread and platform_turn [rad].
        guide, axis: one of ``DIRECTIONS``; axis None: perpendicular to the limb.
    """
    check_choice("arrangement", arrangement, ARRANGEMENTS)
    if arrangement == CARTESIAN:
        return _cartesian(architecture, skeletons, values)
    if arrangement == PLANAR:
        axis = "vertical"
    places = []
    pairs = len(skeletons) == 6 and len(architecture.groups) == 1 and azimuths is None and arrangement == SYMMETRIC
    for k, angle in enumerate(azimuths_of(architecture, azimuths)):
        if angle is None:
            height = values["base_height"]
            places.append(LimbPlace((0, 0, height), (0, 0, 0), None, None, "[0, 0, base_height]", "[0, 0, 0]", axis, guide))
            continue
        base = platform = _angle_in_degrees(angle)
        if pairs:
            base, platform = _pair_azimuths(k, values)
        if "platform_turn" in values:
            platform = Angle(f"{platform.text} + platform_turn", platform.value + values["platform_turn"])
        ends = [
            (values[radius] * math.cos(at.value), values[radius] * math.sin(at.value), z)
            for radius, at, z in (("base_radius", base, values["base_height"]), ("platform_radius", platform, 0.0))
        ]
        places.append(LimbPlace(ends[0], ends[1], base, platform, axis=axis, guide=guide))
    return places


def _pair_azimuths(k: int, values: Mapping[str, float]) -> tuple[Angle, Angle]:
    """Return the azimuths of base and platform point of limb k of six: pairs about 0°, 120°, 240° and about 60°, 180°, 300°."""
    middle, side = 120 * (k // 2), 1 if k % 2 else -1
    far = middle + 60 * side
    signs = ("-", "+") if side < 0 else ("+", "-")
    return (
        Angle(f"radians({middle}) {signs[0]} base_spread", math.radians(middle) + side * values["base_spread"]),
        Angle(f"radians({far}) {signs[1]} platform_spread", math.radians(far) - side * values["platform_spread"]),
    )


def _cartesian(architecture: Architecture, skeletons: Sequence[Skeleton], values: Mapping[str, float]) -> list[LimbPlace]:
    """Return the placements of three limbs; a cyclic permutation of X, Y, Z maps limb 1 to limb 2, and limb 2 to limb 3.

    As in a Tripteron, limb 1 has guide and revolute axes along X and its ends on −Y if it has an elbow and all its points are
    revolute or cylindrical joints. Else, as in an Orthoglide, limb 1 has its guide along X, its ends on X and its revolute axes
    along Y.
    """
    if len(skeletons) != 3:
        raise ArgumentError(
            f"arrangement 'cartesian' is for three limbs, along X, Y and Z; {architecture.text} has {len(skeletons)}"
        )
    places = []
    for k, skeleton in enumerate(skeletons):
        beside = all(point.kind in ("R", "C") for point in skeleton.points) and skeleton.has_elbow
        along, across = np.eye(3)[[k, (k + 1) % 3]]
        unit = -across if beside else along
        ends, texts = [], []
        for radius in ("base_radius", "platform_radius"):
            ends.append(_point(values[radius] * unit))
            texts.append("[" + ", ".join(("0", radius, f"-{radius}")[int(component)] for component in unit) + "]")
        axis = _point(along if beside else across)
        places.append(LimbPlace(ends[0], ends[1], None, None, texts[0], texts[1], axis, _point(along)))
    return places


# ---- tables --------------------------------------------------------------------------------------------------------


def read_placements(path: str | os.PathLike[str]) -> list[dict[str, Point]]:
    """Read a CSV table of placements, with a row for each limb in the order of the notation.

    Its columns are ``base_x, base_y, base_z, platform_x, platform_y, platform_z`` and, if necessary, ``axis_x, …`` and
    ``guide_x, …``. Lengths without a unit are in metres.

    Raises:
        ArgumentError: the table cannot be read; the message names file and line.
    """
    kinds = {f"{column}_{letter}": kind for column, kind in COLUMNS.items() for letter in "xyz"}
    points = list(kinds)[:6]
    table = read_csv(path, f"the first line names the columns, {', '.join(points)}; each further line is a limb", kinds, points)
    placements = []
    for line, row in table.rows:
        numbers = {
            name: parse_number(cell, kinds[name], f"{table.where(line)}: {name}")
            for name, cell in zip(table.names, row, strict=True)
        }
        given = [column for column in COLUMNS if any(f"{column}_{letter}" in numbers for letter in "xyz")]
        placements.append({column: _point([numbers.get(f"{column}_{letter}", 0.0) for letter in "xyz"]) for column in given})
    return placements


def place_by_table(limbs: int, table: object, guide: str) -> list[LimbPlace]:
    """Return the placements of limbs by a list of mappings or a CSV file; ``guide``: default direction of guides."""
    if isinstance(table, (str, os.PathLike)):
        table = read_placements(table)
    if not isinstance(table, Sequence) or isinstance(table, (bytes, Mapping)) or len(table) != limbs:
        count = f" has {len(table)} rows; it" if isinstance(table, Sequence) else ""
        raise ArgumentError(f"placements{count} must be a list with one row for each of the {limbs} limbs: {ROW}")
    places = []
    for k, row in enumerate(table, 1):
        what = f"placements, limb {k}"
        if not isinstance(row, Mapping) or "base" not in row or "platform" not in row:
            raise ArgumentError(f"{what}: {row!r} is not a row; write {ROW}")
        for key in row:
            if key not in COLUMNS:
                raise ArgumentError(f"{what}: {key!r} is unknown; {near_names(key, COLUMNS)}")
        points = {key: _vector(f"{what}, {key}", value) for key, value in row.items()}
        for key in ("axis", "guide"):
            if key in points and not any(points[key]):
                raise ArgumentError(f"{what}: {key} is 0 0 0; it must be a direction")
        base, platform = points["base"], points["platform"]
        base_text, platform_text = vector_text(base), vector_text(platform)
        axis, rail = points.get("axis"), points.get("guide", guide)
        places.append(LimbPlace(base, platform, None, None, base_text, platform_text, axis, rail))
    return places


def _vector(what: str, value: object) -> Point:
    vector = finite_numbers(what, value)
    if vector.shape != (3,):
        raise ArgumentError(f"{what} is {value!r}; it must be three numbers x, y, z")
    return _point(vector)


def _point(values: Sequence[float] | np.ndarray) -> Point:
    x, y, z = (float(value) for value in values)
    return x, y, z


def vector_text(vector: Sequence[float]) -> str:
    """Return a vector as an expression "[x, y, z]"."""
    return "[" + ", ".join(f"{value:g}" if float(f"{value:g}") == value else repr(value) for value in vector) + "]"
