"""Report of the platform's stiffness, and tables of six components."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.layout.blocks import Block, Column, Number, Table, Text
from kinetostatics.layout.numbers import STIFFNESSES, TURNING_STIFFNESSES, NumberFormat, quantity
from kinetostatics.math.arrays import Array
from kinetostatics.math.linalg import EQUAL, first_largest
from kinetostatics.math.screws import COMPONENTS
from kinetostatics.results.result import Result


def component_table(linear: NumberFormat, angular: NumberFormat, columns: Mapping[str, ArrayLike]) -> Table:
    """Return a table of the six components of columns (6,), by their titles, with a unit for each row."""
    formats = [linear] * 3 + [angular] * 3
    names = [f"{name} [{form.unit}]" for name, form in zip(COMPONENTS, formats, strict=True)]
    numbers = [
        Column(title, [Number(float(v), form, with_unit=False) for form, v in zip(formats, np.asarray(values), strict=True)], "r")
        for title, values in columns.items()
    ]
    return Table([Column("", names), *numbers], wide=True)


def stiffness_blocks(result: Result) -> list[Block]:
    """Return the stiffness along each axis, with the other motions fixed and free, and its extremes."""
    constrained, free = np.diag(result.stiffness), _reciprocal(np.diag(result.compliance), result)
    linear = NumberFormat.of([constrained[:3], free[:3]], STIFFNESSES, digits=6)
    angular = NumberFormat.of([constrained[3:], free[3:]], TURNING_STIFFNESSES, digits=6)
    lines = [Text(f"{word} against a force at {result.point_name}: {found}") for word, found in stiffness_extremes(result)]
    return [component_table(linear, angular, {"constrained": constrained, "free": free}), *lines]


def stiffness_extremes(result: Result) -> list[tuple[str, str]]:
    """Return the least and the largest stiffness against a force, and their directions."""
    values, axes = np.linalg.eigh(result.compliance[:3, :3])
    sizes = _reciprocal(values, result)
    found = []
    for word, k in (("softest", 2), ("stiffest", 0)):
        alike = axes[:, np.abs(values - values[k]) <= EQUAL * abs(values[k])]
        found.append((word, "rigid" if np.isinf(sizes[k]) else f"{quantity(sizes[k], STIFFNESSES)} {_directions(alike)}"))
    return found


def _reciprocal(compliances: Array, result: Result) -> Array:
    """Return 1/C; infinite where C is rounding noise, as with rigid limbs."""
    C = np.abs(result.compliance)
    length = result.robot.length
    small = 1e-12 * max(float(C[:3, :3].max()), length**2 * float(C[3:, 3:].max()))
    return np.where(np.abs(compliances) > small, 1 / np.where(compliances == 0, 1.0, compliances), np.inf)


def _directions(axes: Array) -> str:
    """Return a phrase for the directions spanned by one to three orthonormal axes (3, k)."""
    if axes.shape[1] == 3:
        return "in every direction"
    if axes.shape[1] == 1:
        return f"along {_direction(axes[:, 0])}"
    normal = np.cross(axes[:, 0], axes[:, 1])
    planes = [plane for plane, part in zip(("yz", "xz", "xy"), np.abs(normal), strict=True) if part > 1 - EQUAL**2]
    return f"in every direction of the {planes[0]} plane" if planes else f"in every direction across {_direction(normal)}"


def _direction(axis: Array) -> str:
    axis = axis * np.sign(axis[first_largest(np.abs(axis))])
    return "(" + ", ".join("0" if abs(value) < 5e-4 else f"{value:.3f}" for value in axis) + ")"
