"""Sources of sag and actuator forces: elastic parts, ranked by their share of the platform's motion, and mechanisms of gravity.

Gravity acts by the platform's weight, by the limbs' attached wrenches and by their deformation (Eq. (12)).
"""

from __future__ import annotations

import numpy as np

from kinetostatics.layout.blocks import Block, Column, Table
from kinetostatics.layout.numbers import ANGLES, LENGTHS, NoiseFloor, NumberFormat
from kinetostatics.math.arrays import Array
from kinetostatics.results.contributions import by_mechanism_of_gravity
from kinetostatics.results.result import Result
from kinetostatics.statics.solution import of_deformation

#: Rows of the table; the remaining sources share one row.
MOST = 8
#: Relative difference below which parts of the motion count as equal and keep the order of the file.
ALIKE = 1e-6

_KINDS = {"beams": "beam", "joints": "joint", "actuators": "actuator", "assembly_errors": "assembly error"}


def source_table(result: Result, noise: NoiseFloor) -> list[Block]:
    """Return a table of beams, elastic joints, actuators and assembly errors, ranked by their parts of the displacement.

    If o does not move, they are ranked by their parts of the rotation.

    A part is the projection of the source's displacement on the total displacement, and of its rotation on the axis of the total
    rotation; the parts sum to the totals. The last column is the share of the ranked quantity.
    """
    names, twists = sources(result)
    found = parts_along(twists, result.twist, noise)
    if found is None:
        return []
    parts, sizes, by = found
    order = ranked(parts[:, by])
    number = len(order) if len(order) <= MOST + 1 else MOST
    rows = [(*names[k], parts[k]) for k in order[:number]]
    if number < len(order):
        rows.append((f"{len(order) - number} others", "", parts[order[number:]].sum(axis=0)))
    rows.append(("total", "", np.where(np.isfinite(parts[0]), sizes, np.nan)))
    values = np.nan_to_num(np.array([part for *_, part in rows]))
    formats = (NumberFormat.of(parts[:, 0], LENGTHS, noise.displacement), NumberFormat.of(parts[:, 1], ANGLES, noise.rotation))
    titles = (f"moves {result.point_name}", "turns")
    moves = [Column.of(title, list(values[:, k]), formats[k]) for k, title in enumerate(titles)]
    shares = [f"{share(value, float(sizes[by])):.1f}" for value in values[:, by].tolist()]
    texts = [Column(title, [row[k] for row in rows]) for k, title in enumerate(("what", ""))]
    return [Table([*texts, *moves, Column("part [%]", shares, "r")])]


def share(part: float, whole: float) -> float:
    """Return a part relative to the whole [%], rounding errors as 0."""
    found = 100 * part / whole
    return found if abs(found) >= 0.05 else 0.0


def parts_along(twists: Array, whole: Array, noise: NoiseFloor) -> tuple[Array, Array, int] | None:
    """Return the parts (n, 2) of twists (n, 6) in their sum ``whole`` (6,): components of the displacements along the total
    displacement [m], and of the rotations along the total rotation [rad].

    Also returned are the magnitudes (2,) of the totals, and the index of the one by which sources are ranked: 0, or 1 if o does
    not move. Parts are NaN where the total is zero; None is returned without motion or twists.
    """
    wholes = whole[:3], whole[3:]
    sizes = np.array([np.linalg.norm(one) for one in wholes])
    matters = sizes > (noise.displacement, noise.rotation)
    if not len(twists) or not np.any(matters):
        return None
    parts = np.stack([twists[:, :3] @ wholes[0], twists[:, 3:] @ wholes[1]], axis=1)
    return np.where(matters, parts / np.where(matters, sizes, 1.0), np.nan), sizes, int(np.argmax(matters))


def sources(result: Result) -> tuple[list[tuple[str, str]], Array]:
    """Return name and kind of every elastic part, in the file's order, and its twist (n, 6)."""
    robot = result.robot
    order = {name: k for k, name in enumerate((*robot.description.beams, *robot.mechanism.connections))}
    found = [
        (name, _KINDS[kind], twist)
        for kind, named in result.source_contributions.items()
        for name, twist in sorted(named.items(), key=lambda item: order[item[0]])
    ]
    return [(name, kind) for name, kind, _ in found], np.reshape([twist for *_, twist in found], (-1, 6))


def ranked(values: Array) -> list[int]:
    """Return the order of values, the largest first; values equal within rounding keep their order."""
    left, found = np.argsort(-values, kind="stable").tolist(), []
    margin = ALIKE * float(np.max(np.abs(values), initial=0.0))
    while left:
        alike = [k for k in left if values[left[0]] - values[k] <= margin] or left[:1]
        found += sorted(alike)
        left = left[len(alike) :]
    return found


# ---- gravity ---------------------------------------------------------------------------------------------------------------


#: Names of the mechanisms of gravity in tables.
WORDS = {"attached": "attached wrenches"}


def gravity_twists(result: Result) -> dict[str, Array]:
    """Return the twists (6,) due to gravity by mechanism, and their sum."""
    parts = by_mechanism_of_gravity(result.contributions["platform_weight"], result.mechanism_contributions)
    found = {WORDS.get(name, name): twist for name, twist in parts.items()}
    return {**found, "all of gravity": np.sum(list(found.values()), axis=0)}


def actuator_parts(result: Result) -> dict[str, list[Array]]:
    """Return the parts of the actuator forces by contribution and by mechanism of gravity."""
    names = [limb.name for limb in result.robot.topology.limbs]
    limbs = {*names, *map(of_deformation, names)}
    parts: dict[str, list[Array]] = {}
    for actuator, mechanisms in result.actuator_mechanism_contributions.items():
        own = result.actuator_contributions[actuator]
        whole = {name: part for name, part in own.items() if name not in limbs}
        if limbs:
            by_mechanism = by_mechanism_of_gravity(own["platform_weight"], mechanisms)
            whole |= {WORDS.get(name, name): part for name, part in by_mechanism.items()}
        for name, part in whole.items():
            parts.setdefault(name, []).append(part)
    return parts
