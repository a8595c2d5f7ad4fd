"""States of a pose as independent truth values (facts), and its status, the most severe of them.

One table serves results, reports, JSON and workspace maps. A further fact needs an entry here and an attribute of that name in
:class:`kinetostatics.results.result.Result`.
"""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import xarray as xr

Truth = NDArray[np.bool_]


class Status(enum.IntEnum):
    """Status of a pose: the most severe of its facts, each of which is also available as a truth value.

    The numbers are names: which of two is worse, they do not tell. Without numbers are UNREACHABLE and SINGULAR; of the others
    the worst is INDETERMINATE, then come BASIS_DEGENERATE and LIMIT_EXCEEDED.
    """

    OK = 0
    #: A joint is beyond its limit or cone; all numbers are valid.
    LIMIT_EXCEEDED = 1
    #: The loops do not close at these coordinates; all numbers are NaN.
    UNREACHABLE = 2
    #: With the actuators locked the platform can still move, a limb cannot hold its own weight, or a telescopic beam is pushed
    #: together beyond its start; all numbers are NaN.
    SINGULAR = 3
    #: Rigid limbs overconstrain one another, or a rigid ring itself: the twist is valid, undetermined forces are NaN.
    INDETERMINATE = 4
    #: The canonical wrench basis of a limb degenerates: twist and joint wrenches are valid, its intensities are NaN.
    BASIS_DEGENERATE = 5


#: The statuses of poses that have no numbers.
WITHOUT_NUMBERS = (Status.UNREACHABLE, Status.SINGULAR)


@dataclass(frozen=True)
class Fact:
    """Something that may be true of a pose that has numbers.

    Attributes:
        name: of the attribute of a result, and of the variable of a Dataset.
        status: the status of a pose of which nothing worse is true; None: the status does not tell.
        words: what it means, in reports.
        summary: of how many poses it is true, after their number.
    """

    name: str
    status: Status | None
    words: str
    summary: str

    @property
    def title(self) -> str:
        """Its name in reports."""
        return self.name.upper()


#: All facts by name, the mildest first.
FACTS: Mapping[str, Fact] = {
    fact.name: fact
    for fact in (
        Fact(
            "limit_exceeded",
            Status.LIMIT_EXCEEDED,
            "a joint is outside its limit; all results remain valid",
            "beyond a joint's limit",
        ),
        Fact(
            "basis_degenerate",
            Status.BASIS_DEGENERATE,
            "the wrench basis of a limb is degenerate; its intensities are undefined, all other results valid",
            "with unreadable intensities",
        ),
        Fact(
            "indeterminate",
            Status.INDETERMINATE,
            "rigid parts are overconstrained: the twist is valid, undetermined forces are missing",
            "with undetermined forces",
        ),
        Fact(
            "buckles",
            None,
            "a member buckles; the results do not apply",
            "that buckle",
        ),
    )
}

#: Names of those that statuses tell of.
REPORTED = tuple(name for name, fact in FACTS.items() if fact.status is not None)

#: What the other statuses mean.
STATUS_WORDS: Mapping[Status, str] = {
    Status.OK: "the loops close, all joints are within their limits",
    Status.UNREACHABLE: "the loops do not close at these coordinates: there are no numbers",
    Status.SINGULAR: "with the actuators locked the platform or a limb can still move: there are no numbers",
}


def status_of(base: NDArray[np.int8], facts: Mapping[str, Truth]) -> NDArray[np.int8]:
    """Return the worst of all that is true of poses (…).

    Args:
        base: OK, or why a pose has no numbers.
        facts: those that are true of the poses (…), by name.
    """
    status = np.array(base, dtype=np.int8)
    for name, fact in FACTS.items():
        if name in facts and fact.status is not None:
            status = np.where(facts[name] & ~np.isin(status, WITHOUT_NUMBERS), fact.status, status).astype(np.int8)
    return status


def in_map(ds: xr.Dataset, name: str) -> xr.DataArray:
    """Return of which poses of a workspace map a fact is true.

    Of a fact that is no variable of the map the status tells, where nothing is worse.
    """
    if name in ds:
        return ds[name].astype(bool)
    status = FACTS[name].status
    return ds["status"] == (-1 if status is None else int(status))
