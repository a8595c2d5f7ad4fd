"""Arrays of a batch: chunks (batch axis last) are joined to read-only arrays (batch axes first), NaN at failed poses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinetostatics.layout.mapping import ResultMapping
from kinetostatics.math.arrays import Array, batch_first, frozen


@dataclass(frozen=True, eq=False)
class Batch:
    """The poses of a result: the batch ``shape``, and the mask ``valid`` (N,) of poses with results."""

    shape: tuple[int, ...]
    valid: NDArray[np.bool_]

    def public(self, chunks: Sequence[Array]) -> Array:
        """Join chunks (…, n) of all N poses to an array with batch axes first, NaN at failed poses."""
        if len(chunks) == 1 and not self.shape:
            return batch_first(chunks[0] if self.valid[0] else np.full_like(chunks[0], np.nan), ())
        inner = chunks[0].shape[:-1]
        result = np.empty((len(self.valid), *inner))
        at = 0
        for chunk in chunks:
            n = chunk.shape[-1]
            result[at : at + n] = chunk.transpose(chunk.ndim - 1, *range(chunk.ndim - 1))
            at += n
        if not np.all(self.valid):
            result[~self.valid] = np.nan
        return frozen(result.reshape(self.shape + inner))

    def by_source(self, sources: Sequence[str], chunks: Sequence[Array]) -> Mapping[str, Array]:
        """Join chunks (…, S, n) of S contributions to a quantity, by contribution; see :meth:`public`."""
        whole = self.public(chunks)
        return ResultMapping({name: whole[..., k] for k, name in enumerate(sources)})
