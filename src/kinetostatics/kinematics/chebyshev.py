"""Boxes of prescribed coordinates, with Chebyshev nodes from which polynomials predict what lies between."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from kinetostatics.math.arrays import Array

#: Nodes along each of 1, 2, … varying coordinates that tell how smooth everything is, and targets per node that make them pay.
_SAMPLES, _TARGETS_PER_SAMPLE = {1: 9, 2: 6, 3: 5, 4: 4}, 8
#: More coordinates than that do not vary in boxes.
MOST_VARYING = max(_SAMPLES)
#: Into how many boxes each coordinate may be divided, and with how many nodes along it.
_DIVISIONS, _MOST_NODES = (1, 2, 3, 4, 6, 8), 14
#: Scaled errors of polynomials that leave one and two corrections to do.
_ONE_CORRECTION, _TWO_CORRECTIONS = 2e-7, 1e-4
#: By how much errors may be larger than the coefficients of samples let expect.
_CAUTION = 4.0
#: Coefficients below this are rounding.
_ROUNDING = 1e-14
#: Costs, in corrections of a pose: a node, its weight in the polynomial of a pose, a box, a pose that follows its own line.
_NODE, _WEIGHT, _BOX, _WITHOUT = 2.5, 6e-4, 20.0, 12.0
#: First corrections of polynomials' poses are expected to be so many times their error, between these bounds.
_SAFETY, _EXPECTED_STEP = 20.0, (8e-4, 1e-2)


@dataclass(frozen=True)
class Cells:
    """A partition of the prescribed coordinates into boxes, with nodes for a polynomial in each.

    Attributes:
        varying: the coordinates that vary.
        low, size: (d,) corner of the first box and size of each.
        count: (d,) numbers of boxes.
        nodes: (d,) numbers of nodes along the sides of a box.
        targets: how many there are in all boxes.
        expected_step: scaled size of the first corrections of what polynomials predict that is not to be doubted.
    """

    varying: NDArray[np.intp]
    low: Array
    size: Array
    count: NDArray[np.intp]
    nodes: tuple[int, ...]
    targets: int
    expected_step: float

    @classmethod
    def sampling(cls, target: Array) -> Cells | None:
        """Return one box around all targets with few nodes, if there are far more targets than these."""
        if not np.all(np.isfinite(target)):
            return None
        low, high = target.min(axis=1), target.max(axis=1)
        varying = np.flatnonzero(high > low)
        d = varying.size
        if d not in _SAMPLES or target.shape[1] < _TARGETS_PER_SAMPLE * _SAMPLES[d] ** d:
            return None
        one = np.ones(d, dtype=np.intp)
        samples = (_SAMPLES[d],) * d
        return cls(varying, low[varying], (high - low)[varying], one, samples, target.shape[1], 3 * _EXPECTED_STEP[1])

    def refined(self, values: Array) -> Cells | None:
        """Return boxes and nodes with which polynomials pay, judged by how fast the coefficients of samples fall.

        Args:
            values: (k, M) at the nodes of one box.
        """
        choices = [self._choices(axis, values) for axis in range(self.varying.size)]
        best, chosen = _WITHOUT * self.targets, None
        for corrections, level in ((1, _ONE_CORRECTION), (2, _TWO_CORRECTIONS)):
            fewest = [np.array([_fewest(errors, level) for errors in axis]) for axis in choices]
            each = np.meshgrid(*fewest, indexing="ij")
            boxes = np.prod(np.meshgrid(*[_DIVISIONS] * len(fewest), indexing="ij"), axis=0)
            nodes = np.prod(np.array(each, dtype=float), axis=0)
            cost = boxes * (nodes * _NODE + _BOX) + self.targets * (corrections + nodes * _WEIGHT)
            where = np.unravel_index(np.argmin(cost), cost.shape)
            if cost[where] < best:
                error = max(float(axis[k][int(n[where]) - 1]) for axis, k, n in zip(choices, where, each, strict=True))
                best, chosen = float(cost[where]), (where, tuple(int(n[where]) for n in each), error)
        if chosen is None:
            return None
        where, numbers, error = chosen
        count = np.array([_DIVISIONS[k] for k in where], dtype=np.intp)
        expected_step = float(np.clip(_SAFETY * error, *_EXPECTED_STEP))
        return replace(self, size=self.size / count, count=count, nodes=numbers, expected_step=expected_step)

    def _choices(self, axis: int, values: Array) -> Array:
        """Return what errors are to be expected with each division (len(_DIVISIONS), …) of a coordinate and 1, 2, … nodes.

        The error falls with every node by the radius of the ellipse around the box in which what is interpolated is analytic
        (L. N. Trefethen, Approximation Theory and Approximation Practice, chapter 8). In a smaller box the singularity beside it
        is farther away.
        """
        m = self.nodes[axis]
        lines = np.moveaxis(values.reshape(-1, *self.nodes), axis + 1, -1)
        errors = np.full((len(_DIVISIONS), _MOST_NODES), np.inf)
        sizes = np.max(np.abs(lines @ _chebyshev(m)), axis=tuple(range(lines.ndim - 1)))
        last, before = sizes[-2:].max(), sizes[max(1, m - 4) : -2].max()
        radius = np.sqrt(max(before, 1e-300) / last) if last > _ROUNDING else 1e3
        radius = float(np.clip(radius, 1.05, 1e3))
        place = (radius + 1 / radius) / 2
        numbers = np.arange(1, _MOST_NODES + 1)
        tail = np.append(np.maximum.accumulate(sizes[:0:-1])[::-1], np.zeros(_MOST_NODES + 1 - m))[:_MOST_NODES]
        for row, division in enumerate(_DIVISIONS):
            beside = 1 + (place - 1) * division
            smaller = beside + np.sqrt(beside**2 - 1)
            model = _CAUTION * last * radius ** (m - 1) * smaller ** -numbers.astype(float)
            fewer = np.maximum(tail / float(division) ** numbers, model if last > _ROUNDING else 0.0)
            errors[row] = np.where(numbers < m - 1, fewer, model)
        return errors

    def number(self, target: Array) -> NDArray[np.intp]:
        """Return the box (N,) of each target."""
        place = ((target[self.varying] - self.low[:, None]) / self.size[:, None]).astype(np.intp)
        return np.asarray(np.ravel_multi_index(tuple(np.clip(place, 0, self.count[:, None] - 1)), tuple(self.count)))

    def local(self, box: int, target: Array) -> Array:
        """Return where in a box (d, n), in −1 … 1, targets (…, n) lie."""
        corner = np.array(np.unravel_index(box, tuple(self.count)))[:, None]
        return 2 * ((target[self.varying] - self.low[:, None]) / self.size[:, None] - corner) - 1

    def node_targets(self, box: int, example: Array) -> Array:
        """Return the coordinates (n, M) of all nodes of a box; those that do not vary are as in ``example`` (n,)."""
        corner = np.array(np.unravel_index(box, tuple(self.count)))
        places = [(_places(m) + 1) / 2 for m in self.nodes]
        axes = [self.low[k] + self.size[k] * (corner[k] + place) for k, place in enumerate(places)]
        grid = np.stack([axis.ravel() for axis in np.meshgrid(*axes, indexing="ij")])
        result = np.repeat(example[:, None], grid.shape[1], axis=1)
        result[self.varying] = grid
        return result

    def interpolated(self, values: Array, places: Array) -> Array:
        """Return the polynomials' values (k, n) at places (d, n) in a box from those (k, M) at its nodes."""
        first, *others = [_weights(m, row) for m, row in zip(self.nodes, places, strict=True)]
        product = np.ones((1, places.shape[1]))
        for one in others:
            product = (product[:, None] * one[None]).reshape(-1, one.shape[1])
        along = (values.reshape(-1, product.shape[0]) @ product).reshape(values.shape[0], *first.shape)
        return np.asarray(np.einsum("kmn,mn->kn", along, first))


def _places(m: int) -> Array:
    """Return m Chebyshev nodes in −1 … 1."""
    return np.asarray(-np.cos(np.pi * (np.arange(m) + 0.5) / m))


def _chebyshev(m: int) -> Array:
    """Return the matrix (m, m) that makes of values at the nodes (last axis) coefficients of Chebyshev polynomials."""
    matrix = 2 / m * np.cos(np.outer(np.arccos(_places(m)), np.arange(m)))
    matrix[:, 0] /= 2
    return np.asarray(matrix)


def _weights(m: int, places: Array) -> Array:
    """Return the weights (m, n) of m nodes in the polynomial's value at places (n,)."""
    polynomials = np.ones((m, places.size))
    for k in range(1, m):
        polynomials[k] = places if k == 1 else 2 * places * polynomials[k - 1] - polynomials[k - 2]
    return np.asarray(_chebyshev(m) @ polynomials)


def _fewest(errors: Array, level: float) -> float:
    """Return with how many nodes, of 1, 2, …, the error is below a level."""
    good = np.flatnonzero(errors < level)
    return float(good[0] + 1) if good.size else np.inf
