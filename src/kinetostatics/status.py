"""States of a pose as independent truth values (facts), and its status, the most severe of them.

One table serves results, reports, JSON and workspace maps. A new fact needs an entry here and an attribute of the same name in
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
    """Status of a pose: the most severe of its facts; each fact is also available as a truth value.

    The order of the numbers has no meaning. Poses that are UNREACHABLE or SINGULAR have no results. Of the other statuses,
    INDETERMINATE is the most severe, followed by BASIS_DEGENERATE and LIMIT_EXCEEDED.
    """

    OK = 0
    #: A joint is beyond its limit or cone; all numbers are valid.
    LIMIT_EXCEEDED = 1
    #: The loops do not close at these coordinates; all numbers are NaN.
    UNREACHABLE = 2
    #: With the actuators locked the platform can still move, a limb cannot hold its own weight, or a telescopic beam is
    #: retracted beyond zero length; all numbers are NaN.
    SINGULAR = 3
    #: Rigid limbs or a rigid ring are overconstrained: the twist is valid, undetermined forces are NaN.
    INDETERMINATE = 4
    #: The canonical wrench basis of a limb degenerates: the intensities of this limb are NaN, all other numbers are valid.
    BASIS_DEGENERATE = 5

    def __str__(self) -> str:
        return self.name

    def __format__(self, spec: str) -> str:
        return format(self.name, spec)


#: The statuses of poses without results.
WITHOUT_NUMBERS = (Status.UNREACHABLE, Status.SINGULAR)


@dataclass(frozen=True)
class Fact:
    """A state that may apply to a pose with results.

    Attributes:
        name: attribute of a result and variable of a Dataset.
        status: status of a pose for which this is the most severe fact; None: the fact does not affect the status.
        words: description in reports.
        summary: description in reports, following a number of poses; empty if such poses are as good as others.
    """

    name: str
    status: Status | None
    words: str
    summary: str

    @property
    def title(self) -> str:
        return self.name.upper()


#: All facts by name, the least severe first.
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
            "the wrench basis of a limb is not unique here: its intensities are NaN, all other results are valid",
            "",
        ),
        Fact(
            "indeterminate",
            Status.INDETERMINATE,
            "rigid parts are overconstrained: the twist is valid, undetermined forces are missing",
            "with undetermined forces",
        ),
        Fact(
            "effort_exceeded",
            None,
            "the force of an actuator exceeds its limit of effort; all results remain valid",
            "beyond an actuator's effort",
        ),
        Fact(
            "buckles",
            None,
            "a member buckles; the results do not apply",
            "that buckle",
        ),
    )
}

#: Names of the facts that affect the status.
REPORTED = tuple(name for name, fact in FACTS.items() if fact.status is not None)

#: Descriptions of the statuses that are not facts.
STATUS_WORDS: Mapping[Status, str] = {
    Status.OK: "the loops close, all joints are within their limits",
    Status.UNREACHABLE: "the loops do not close at these coordinates: no results",
    Status.SINGULAR: "with the actuators locked the platform or a limb can still move: no results",
}


def status_of(base: NDArray[np.int8], facts: Mapping[str, Truth]) -> NDArray[np.int8]:
    """(…) the most severe of the ``facts`` (…) that are true of each pose; ``base``: OK, UNREACHABLE or SINGULAR."""
    status = np.array(base, dtype=np.int8)
    for name, fact in FACTS.items():
        if name in facts and fact.status is not None:
            status = np.where(facts[name] & ~np.isin(status, WITHOUT_NUMBERS), fact.status, status).astype(np.int8)
    return status


def in_map(ds: xr.Dataset, name: str) -> xr.DataArray:
    """Return where a fact is true in a map; if it is not a variable of the map, only where it is the most severe fact."""
    if name in ds:
        return ds[name].astype(bool)
    status = FACTS[name].status
    return ds["status"] == (-1 if status is None else int(status))
