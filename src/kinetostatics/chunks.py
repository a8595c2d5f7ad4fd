"""Batches are computed in chunks: few enough poses to fit into the processor's cache, and as many as that allows."""

from __future__ import annotations

from itertools import pairwise

#: Poses of a chunk at most. Each chunk costs some milliseconds whatever its size.
AT_ONCE = 5500


def chunks(poses: int) -> list[slice]:
    """Return slices of nearly the same size that together are all of so many poses."""
    count = -(-poses // AT_ONCE)
    ends = [poses * k // count for k in range(count + 1)] if count else []
    return [slice(first, last) for first, last in pairwise(ends)]
