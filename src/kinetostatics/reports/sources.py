"""Sources of sag and actuator forces: elastic parts, ranked by their share of the platform's motion, and mechanisms of gravity.

The mechanisms are the platform's weight, the attached wrenches of the limbs, and the deformation of the limbs (Eq. (12)).
"""

from __future__ import annotations

from typing import TypeVar

import numpy as np

from kinetostatics.layout.blocks import Block, Column, Table
from kinetostatics.layout.numbers import ANGLES, LENGTHS, NoiseFloor, NumberFormat
from kinetostatics.layout.report import NumberTable
from kinetostatics.math.arrays import Array
from kinetostatics.math.screws import COMPONENTS, TWIST_UNITS
from kinetostatics.reports.pose import actuator_unit
from kinetostatics.results.contributions import by_mechanism_of_gravity
from kinetostatics.results.result import Result
from kinetostatics.statics.solution import of_deformation

Item = TypeVar("Item")
#: Largest number of sources in the table; the remaining ones share one row.
MOST = 8
#: Difference, relative to the largest value, up to which values count as equal and keep their order.
ALIKE = 1e-6

_KINDS = {"beams": "beam", "links": "link", "joints": "joint", "actuators": "actuator", "assembly_errors": "assembly error"}


def source_table(result: Result, noise: NoiseFloor) -> list[Block]:
    """Return a table of beams, elastic joints, actuators and assembly errors, ranked by their share in the last column.

    This is the share of the displacement or, if o does not move, of the rotation.
    """
    names, twists = sources(result)
    projection = parts_along(twists, result.twist, noise)
    if projection is None:
        return []
    parts, sizes, by = projection
    order = ranked(parts[:, by])
    shown, others = shown_and_rest(order, MOST)
    rows = [(*names[k], parts[k]) for k in shown]
    if others:
        rows.append((f"{len(others)} others", "", parts[others].sum(axis=0)))
    rows.append(("total", "", np.where(np.isfinite(parts[0]), sizes, np.nan)))
    values = np.nan_to_num(np.array([part for *_, part in rows]))
    formats = (NumberFormat.of(parts[:, 0], LENGTHS, noise.displacement), NumberFormat.of(parts[:, 1], ANGLES, noise.rotation))
    titles = (f"moves {result.point_name}", "turns")
    moves = [Column.of(title, list(values[:, k]), formats[k]) for k, title in enumerate(titles)]
    shares = [f"{share(value, float(sizes[by])):.1f}" for value in values[:, by].tolist()]
    texts = [Column(title, [row[k] for row in rows]) for k, title in enumerate(("what", ""))]
    return [Table([*texts, *moves, Column("part [%]", shares, "r")])]


def share(part: float, whole: float) -> float:
    """Return ``part / whole`` [%]; magnitudes below 0.05 % are 0."""
    percentage = 100 * part / whole
    return percentage if abs(percentage) >= 0.05 else 0.0


def parts_along(twists: Array, whole: Array, noise: NoiseFloor) -> tuple[Array, Array, int] | None:
    """Project twists (n, 6) on the displacement and on the rotation of their sum ``whole`` (6,).

    Returns:
        (parts, sizes, by), or None if nothing moves: parts (n, 2), components of each twist along the total displacement [m] and
        along the total rotation [rad], NaN if the total is zero; sizes (2,), magnitudes of both totals; by, the column of
        ``parts`` by which sources are ranked: 0, or 1 if o does not move.
    """
    wholes = whole[:3], whole[3:]
    sizes = np.array([np.linalg.norm(total) for total in wholes])
    matters = sizes > (noise.displacement, noise.rotation)
    if not len(twists) or not np.any(matters):
        return None
    parts = np.stack([twists[:, :3] @ wholes[0], twists[:, 3:] @ wholes[1]], axis=1)
    return np.where(matters, parts / np.where(matters, sizes, 1.0), np.nan), sizes, int(np.argmax(matters))


def sources(result: Result) -> tuple[list[tuple[str, str]], Array]:
    """Return (names, twists): name and kind of each of n sources, in the file's order within a kind; twists (…, n, 6)."""
    robot = result.robot
    order = {name: k for k, name in enumerate((*robot.description.elastic_links, *robot.mechanism.connections))}
    named_twists = [
        (name, _KINDS[kind], twist)
        for kind, named in result.source_contributions.items()
        for name, twist in sorted(named.items(), key=lambda pair: order[pair[0]])
    ]
    twists = np.reshape([twist for *_, twist in named_twists], (len(named_twists), *result.twist.shape))
    return [(name, kind) for name, kind, _ in named_twists], np.moveaxis(twists, 0, -2)


def contribution_table(result: Result) -> NumberTable:
    columns = _twist_columns(np.stack([*result.contributions.values()], axis=-2))
    for name, parts in result.actuator_contributions.items():
        columns[f"force of {name} [{actuator_unit(result.robot, name)}]"] = np.stack([*parts.values()], axis=-1)
    return {"contribution": [*result.contributions]}, columns


def part_table(result: Result) -> NumberTable:
    names, twists = sources(result)
    return {"part": [part for part, _ in names], "kind": [kind for _, kind in names]}, _twist_columns(twists)


def _twist_columns(twists: Array) -> dict[str, Array]:
    return {f"{name} [{TWIST_UNITS[k]}]": twists[..., k] for k, name in enumerate(COMPONENTS)}


def ranked(values: Array) -> list[int]:
    """Return the indices of values, the largest first; values equal within rounding keep their order."""
    left, indices = np.argsort(-values, kind="stable").tolist(), []
    margin = ALIKE * float(np.max(np.abs(values), initial=0.0))
    while left:
        alike = [k for k in left if values[left[0]] - values[k] <= margin] or left[:1]
        indices += sorted(alike)
        left = left[len(alike) :]
    return indices


def shown_and_rest(ranked: list[Item], most: int) -> tuple[list[Item], list[Item]]:
    """Return (first ``most`` items, remaining items); a single remaining item joins the first ones."""
    number = len(ranked) if len(ranked) <= most + 1 else most
    return ranked[:number], ranked[number:]


# ---- gravity ---------------------------------------------------------------------------------------------------------------


#: Names of the mechanisms of gravity in tables.
WORDS = {"attached": "attached wrenches"}


def gravity_twists(result: Result) -> dict[str, Array]:
    """Return the twist (6,) due to each mechanism of gravity, and "all of gravity"."""
    parts = by_mechanism_of_gravity(result.contributions["platform_weight"], result.mechanism_contributions)
    twists = {WORDS.get(name, name): twist for name, twist in parts.items()}
    twists |= {name: result.contributions[name] for name in ("base_weight",) if name in result.contributions}
    return {**twists, "all of gravity": np.sum(list(twists.values()), axis=0)}


def actuator_parts(result: Result) -> dict[str, list[Array]]:
    """Return the parts of the actuator forces by contribution, but with the limbs' weights divided by mechanism of gravity."""
    names = [limb.name for limb in result.robot.topology.limbs]
    limbs = {*names, *map(of_deformation, names)}
    parts: dict[str, list[Array]] = {}
    for actuator, mechanisms in result.actuator_mechanism_contributions.items():
        contributions = result.actuator_contributions[actuator]
        whole = {name: part for name, part in contributions.items() if name not in limbs}
        if limbs:
            by_mechanism = by_mechanism_of_gravity(contributions["platform_weight"], mechanisms)
            whole |= {WORDS.get(name, name): part for name, part in by_mechanism.items()}
        for name, part in whole.items():
            parts.setdefault(name, []).append(part)
    return parts
