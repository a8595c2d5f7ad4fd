"""Boxes of requested coordinates, with Chebyshev nodes from which polynomials predict what lies between."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Nodes along each of 1, 2, … varying coordinates of a cell, and poses of a cell per node that make them pay.
_NODES, _POSES_PER_NODE = {1: 10, 2: 8, 3: 6, 4: 4}, 6
#: So many nodes more where there is one cell only.
_MORE_NODES = 2


@dataclass(frozen=True)
class Cells:
    """A partition of the requested coordinates into boxes, with nodes for a polynomial in each.

    Attributes:
        varying: the coordinates that vary.
        low, size: (d,) corner of the first box and size of each.
        count: (d,) numbers of boxes.
        nodes: (m,) places of the nodes in a box along each coordinate, in −1 … 1 (Chebyshev).
    """

    varying: NDArray[np.intp]
    low: Array
    size: Array
    count: NDArray[np.intp]
    nodes: Array

    @classmethod
    def of(cls, target: Array) -> Cells | None:
        """Return a partition that pays: with far more poses than nodes."""
        N = target.shape[1]
        if not np.all(np.isfinite(target)):
            return None
        low, high = target.min(axis=1), target.max(axis=1)
        varying = np.flatnonzero(high > low)
        d = varying.size
        if d == 0 or d > 4:
            return None
        nodes = _NODES[d]
        boxes = N / (_POSES_PER_NODE * nodes**d)
        if boxes < 1:
            return None
        each = max(int(boxes ** (1 / d)), 1)
        if each == 1:  # nothing is to be gained by dividing, but by a higher degree
            nodes = min(nodes + _MORE_NODES, int((N / _POSES_PER_NODE) ** (1 / d) + 1e-9))
        places = np.cos(np.pi * (np.arange(nodes) + 0.5) / nodes)[::-1]
        span = (high - low)[varying]
        return cls(varying, low[varying], span / each, np.full(d, each), places)

    def number(self, target: Array) -> NDArray[np.intp]:
        """Return the box (N,) of each target."""
        place = ((target[self.varying] - self.low[:, None]) / self.size[:, None]).astype(np.intp)
        return np.asarray(np.ravel_multi_index(tuple(np.minimum(place, self.count[:, None] - 1)), tuple(self.count)))

    def local(self, box: int, target: Array) -> Array:
        """Return where in a box (d, n), in −1 … 1, targets (…, n) lie."""
        corner = np.array(np.unravel_index(box, tuple(self.count)))[:, None]
        return 2 * ((target[self.varying] - self.low[:, None]) / self.size[:, None] - corner) - 1

    def node_targets(self, box: int, example: Array) -> Array:
        """Return the coordinates (n, M) of all nodes of a box; those that do not vary are as in ``example`` (n,)."""
        corner = np.array(np.unravel_index(box, tuple(self.count)))
        axes = [self.low[k] + self.size[k] * (corner[k] + (self.nodes + 1) / 2) for k in range(self.varying.size)]
        grid = np.stack([axis.ravel() for axis in np.meshgrid(*axes, indexing="ij")])
        result = np.repeat(example[:, None], grid.shape[1], axis=1)
        result[self.varying] = grid
        return result

    def weights(self, places: Array) -> Array:
        """Return the weights (M, n) of a box's nodes in the polynomial's value at places (d, n)."""
        result = np.ones((1, places.shape[1]))
        for row in places:
            one = np.ones((self.nodes.size, row.size))
            for k, node in enumerate(self.nodes):
                for other in self.nodes[np.arange(self.nodes.size) != k]:
                    one[k] *= (row - other) / (node - other)
            result = (result[:, None] * one[None]).reshape(-1, row.size)
        return result
