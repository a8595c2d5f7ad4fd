"""Report of a workspace map: numbers of poses by state; largest sag (displacement of o), turn (rotation), actuator forces."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kinetostatics.layout.blocks import Block, ReportSection, Table, Text
from kinetostatics.layout.numbers import MISSING, NOISE, largest
from kinetostatics.layout.report import Report
from kinetostatics.math.linalg import EQUAL, first_largest
from kinetostatics.status import FACTS, Status, in_map

if TYPE_CHECKING:
    import xarray as xr

#: The largest value of a kind ("sag", "turn", "N" or "N m"), its pose as text, and the actuator (empty for sag and turn).
Extreme = tuple[float, str, str]
#: Largest number of values read at once.
AT_ONCE = 2**22
#: Least number of poses for which the time per pose is given.
MANY = 1000
#: Largest sag [m], rotation [rad] or force [N, N·m] that counts as zero.
NOTHING = 1e-13
#: Largest number of values of a parameter for which a table has a row for each value.
MOST_ROWS = 20
#: Units of a sag [m] and a turn [rad], with their sizes.
UNITS = {"sag": (("mm", 1e-3), ("µm", 1e-6), ("nm", 1e-9)), "turn": (("mrad", 1e-3), ("µrad", 1e-6), ("nrad", 1e-9))}
WORDS = {Status.OK: "reached", Status.UNREACHABLE: "unreachable", Status.SINGULAR: "singular"}


def map_report(ds: xr.Dataset, seconds: float | None = None) -> Report:
    """Return the report of a map from :func:`kinetostatics.sweep`; ``seconds``: computing time.

    Its extremes are those over the poses within the joint limits; if none of these has results, over the other poses.
    """
    dims, size = ds["status"].dims, int(ds["status"].size)
    sizes = " × ".join(f"{name} {ds.sizes[name]}" for name in dims)
    title = f"{ds.attrs.get('robot_name', 'robot')}: {size} {'pose' if size == 1 else 'poses'}" + (f" ({sizes})" if dims else "")
    return Report(title, lambda: _sections(ds, seconds))


def _sections(ds: xr.Dataset, seconds: float | None) -> Iterator[ReportSection]:
    dims, size = ds["status"].dims, int(ds["status"].size)
    facts = {name: fact for name, fact in FACTS.items() if fact.summary}
    counts = dict.fromkeys((WORDS[Status.OK], *(fact.summary for fact in facts.values()), *WORDS.values()), 0)
    several = 0
    # the largest values of each kind: within the limits, beyond them, and within them for each value of a parameter
    within: dict[str, Extreme] = {}
    outside: dict[str, Extreme] = {}
    parameters = [str(name) for name in ds["characteristic_length"].dims if 1 < ds.sizes[name] <= MOST_ROWS]
    by_value: dict[str, list[dict[str, Extreme]]] = {name: [{} for _ in range(ds.sizes[name])] for name in parameters}
    for piece in _pieces(ds):
        part = ds.isel(piece)
        status = part["status"].values
        true = {fact.summary: in_map(part, name).values for name, fact in facts.items()}
        good = (status == Status.BASIS_DEGENERATE) & ~true[FACTS["limit_exceeded"].summary]
        true |= {word: np.where(good, Status.OK, status) == state for state, word in WORDS.items()}
        for word, where in true.items():
            counts[word] += int(where.sum())
        several += int((np.sum(list(true.values()), axis=0) > 1).sum())
        beyond = true[FACTS["limit_exceeded"].summary]
        _update_largest(within, part, ~beyond)
        _update_largest(outside, part, beyond)
        for name, rows in by_value.items():
            first = piece[name].start if name in piece else 0
            for k in range(part.sizes[name]):
                _update_largest(rows[first + k], part.isel({name: [k]}), np.take(~beyond, [k], axis=dims.index(name)))
    lines = [*((number, word) for word, number in counts.items()), (several, "of them counted more than once")]
    yield ReportSection(None, [Text(f"{number:>10d} {word}") for number, word in lines if number])
    if within:
        yield ReportSection(None, _extremes(within, ds))
        yield from (_by_value(ds, name, rows) for name, rows in by_value.items())
    elif outside:
        yield ReportSection(None, [Text("no pose is within the joints' limits; beyond them:"), *_extremes(outside, ds)])
    if seconds is not None:  # for fewer poses the time is mainly that of starting Python
        yield ReportSection(
            None, [Text(f"{seconds:.1f} s" + (f", {1e6 * seconds / size:.3g} µs a pose" if size >= MANY else ""))]
        )


def _update_largest(extremes: dict[str, Extreme], part: xr.Dataset, where: NDArray[np.bool_]) -> None:
    """Update the largest values ``extremes``, by kind, from a part of the map, at poses where ``where`` is True."""
    if not where.any():
        return
    numbers = []
    if "twist" in part:
        parts = ("sag", part["twist"].values[..., :3]), ("turn", part["twist"].values[..., 3:])
        numbers += [(kind, "", np.linalg.norm(values, axis=-1)) for kind, values in parts]
    if "actuator_force" in part:
        actuators = zip(part["actuator"].values, part["actuator_force_unit"].values, strict=True)
        forces = np.moveaxis(np.abs(part["actuator_force"].values), -1, 0)
        numbers += [(str(unit), str(name), force) for (name, unit), force in zip(actuators, forces, strict=True)]
    for kind, actuator, values in numbers:
        finite = np.where(where & np.isfinite(values), values, -np.inf)
        place = np.unravel_index(first_largest(finite.ravel()), finite.shape)
        value = float(finite[place])
        if np.isfinite(value) and (kind not in extremes or extremes[kind][0] * (1 + EQUAL) < value):
            words = [
                coordinate_words(part[name], part[name].values[k]) for name, k in zip(part["status"].dims, place, strict=True)
            ]
            extremes[kind] = value, ", ".join(words) or "the only pose", actuator


def _extremes(extremes: dict[str, Extreme], ds: xr.Dataset) -> list[Block]:
    lines: list[Block] = []
    if "sag" in extremes and "turn" in extremes:
        (sag, sags, _), (turn, turns, _) = extremes["sag"], extremes["turn"]
        lines += [Text(f"worst sag {_written('sag', sag)} at {sags}")] if sag > NOTHING else []
        lines += [Text(f"worst turn {_written('turn', turn)} at {turns}")] if turn > NOTHING else []
        if max(sag, turn) <= NOTHING:
            lines.append(Text("the platform neither sags nor turns: no elastic part deforms"))
        if sag >= 0.1 * float(ds["characteristic_length"].max()) or turn >= 0.1:
            warning = "linear theory does not apply: the pose is nearly singular, or units in the file are wrong"
            lines.append(Text(warning, "warning"))
    return lines + [
        Text(f"largest actuator {_actuator_word(unit)} {_written(unit, value)}, {actuator}, at {where}")
        for unit, (value, where, actuator) in extremes.items()
        if unit not in ("sag", "turn") and value > NOTHING
    ]


def _by_value(ds: xr.Dataset, name: str, rows: list[dict[str, Extreme]]) -> ReportSection:
    """Return a table with a row for each value of a parameter; kinds that are zero everywhere are omitted."""
    named = dict.fromkeys(kind for row in rows for kind in row)
    kinds = [kind for kind in named if any(row[kind][0] > NOTHING for row in rows if kind in row)]
    titles = [f"worst {kind}" if kind in ("sag", "turn") else f"largest actuator {_actuator_word(kind)}" for kind in kinds]
    cells = [
        [
            coordinate_words(ds[name], value).partition(" = ")[2],
            *(_written(kind, row[kind][0]) if kind in row else MISSING for kind in kinds),
        ]
        for value, row in zip(ds[name].values, rows, strict=True)
    ]
    return ReportSection(f"by {name}, each over all other axes:", [Table.of_rows([name, *titles], cells)] if kinds else [])


def _actuator_word(unit: str) -> str:
    return "force" if unit == "N" else "torque"


def _written(kind: str, value: float) -> str:
    """Write a value of this kind with its unit; of sag or turn, with the largest unit of which it is at least 0.1."""
    if kind not in UNITS:
        return f"{value:.4g} {kind.replace(' ', '·')}"
    name, size = next((unit for unit in UNITS[kind] if value >= unit[1] / 10), UNITS[kind][-1])
    return f"{value / size:.4g} {name}"


def coordinate_words(coordinate: xr.DataArray, value: object) -> str:
    """Write "name = value unit"; angles are in degrees."""
    if not isinstance(value, (float, np.floating)):
        return f"{coordinate.name} = {value}"
    unit = str(coordinate.attrs.get("units", ""))
    number = float(value) if abs(float(value)) > NOISE * largest([coordinate.values]) else 0.0
    if unit == "rad":
        number, unit = np.degrees(number), "deg"
    return f"{coordinate.name} = {number:.6g} {unit}".rstrip()


def _pieces(ds: xr.Dataset) -> Iterator[dict[object, slice]]:
    """Yield pieces of the grid along its first dimension, each small enough to be read at once."""
    dims = ds["status"].dims
    if not dims:
        yield {}
        return
    layer = 12 * max(1, int(ds["status"].size) // max(1, ds.sizes[dims[0]]))
    thick = max(1, AT_ONCE // layer)
    for start in range(0, ds.sizes[dims[0]], thick):
        yield {dims[0]: slice(start, start + thick)}
