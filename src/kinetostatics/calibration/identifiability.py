"""Directions of the unknowns that no reading determines: the null space of the Jacobian."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kinetostatics.calibration.unknowns import Unknown
from kinetostatics.layout.mapping import ResultMapping
from kinetostatics.layout.numbers import join_words
from kinetostatics.math.arrays import Array, Mask
from kinetostatics.results.calibration import Unidentifiable

#: Change of an unknown, relative to the largest in a direction, that counts as zero.
NOTHING = 1e-5


def determined_ones(null: Array) -> Mask:
    """Return the mask (p,) of identifiable unknowns: those without component in the basis (p, k) of the null space."""
    return np.asarray(~np.any(np.abs(null) > NOTHING * np.abs(null).max(initial=0.0), axis=1))


def unidentifiable(unknowns: Sequence[Unknown], null: Array) -> tuple[Unidentifiable, ...]:
    """Return the unidentifiable directions.

    Args:
        unknowns: all p unknowns.
        null: (p, k) basis of changes that affect no reading, in units of the unknowns' scales.
    """
    return tuple(_one(unknowns, direction) for direction in _sparse(null).T)


def _sparse(null: Array) -> Array:
    """Return a sparse basis (p, k) of the space spanned by ``null`` (p, k), by elimination; the largest entries are 1."""
    rest = np.array(null)
    pivots: list[int] = []
    for k in range(rest.shape[1]):
        free = np.abs(rest[:, k])
        free[pivots] = 0.0
        pivot = int(np.argmax(free))
        pivots.append(pivot)
        rest[:, k] /= rest[pivot, k]
        for other in range(rest.shape[1]):
            if other != k:
                rest[:, other] -= rest[pivot, other] * rest[:, k]
    rest = rest / np.abs(rest).max(axis=0, initial=0.0)
    return np.where(np.abs(rest) < NOTHING, 0.0, rest)


def _one(unknowns: Sequence[Unknown], direction: Array) -> Unidentifiable:
    mine = np.flatnonzero(direction).tolist()
    changes = ResultMapping({unknowns[k].name: float(direction[k]) for k in mine})
    names = [_called(unknowns[k]) for k in mine]
    if len(mine) == 1:
        return Unidentifiable(changes, f"no reading depends on {names[0]}")
    together = f"{', '.join(names[:-1])} and {names[-1]} cannot be distinguished"
    if len(mine) == 2:
        a, b = direction[mine]
        weight = float(-a / b)
        sign = "difference" if weight < 0 else "sum"
        size = abs(weight)
        what = f"their {sign}" if abs(size - 1) < 1e-4 else f"{names[0]} {'−' if weight < 0 else '+'} {size:.4g} times {names[1]}"
        return Unidentifiable(changes, f"{together}: the readings depend only on {what}, relative to the values in the file")
    return Unidentifiable(changes, f"{together}: a change of all in a certain ratio changes no reading")


def _called(unknown: Unknown) -> str:
    if unknown.kind == "stiffness":
        return f"the compliance of {join_words([name for _, name in unknown.parts])}"
    return unknown.name
