"""Report of buckling: load factors, and the members with the largest strain energy in each mode."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from kinetostatics.layout.blocks import Block, Cell, Facts, ReportSection, Table
from kinetostatics.layout.report import Report, attributes
from kinetostatics.reports.pose import state_title
from kinetostatics.reports.sources import share
from kinetostatics.results.buckling import Buckling

#: Relative difference of load factors that count as equal.
_EQUAL = 1e-6
TITLE = "Load factors, common to all forces, at which the robot buckles"


def buckling_report(buckling: Buckling) -> Report:
    """Return the report of load factors and modes of one pose, or of the ranges of load factors over a batch."""
    title = [f"Buckling of {buckling.robot.name!r}: ", *state_title(buckling.configuration)]
    return Report(title, lambda: list(_sections(buckling)), lambda: _data(buckling))


def _sections(buckling: Buckling) -> Iterator[ReportSection]:
    if not buckling.shape:
        yield ReportSection(TITLE, buckling_blocks(buckling), "buckling")
        return
    if np.any(known := np.isfinite(buckling.load_factors)):
        least = f"{buckling.load_factors[known].min():.4g}"
        yield ReportSection("Least over the poses", [Facts([("load factor", least)])], "buckling")


def buckling_blocks(buckling: Buckling) -> list[Block]:
    """Return a table of the modes of one pose, equal load factors in one row; an empty list if none is finite."""
    factors = buckling.load_factors[np.isfinite(buckling.load_factors)]
    groups = np.split(np.arange(len(factors)), np.flatnonzero(np.diff(factors) > _EQUAL * factors[1:]) + 1)
    rows: list[tuple[Cell, ...]] = []
    for modes in filter(len, groups):
        shares = {name: round(float(np.mean(values[modes])), 6) for name, values in buckling.energy_shares.items()}
        most = max(shares, key=lambda name: shares[name], default="")
        percent = f"{share(shares[most], 1.0):.1f}" if most else ""
        rows.append((", ".join(str(k + 1) for k in modes), f"{factors[modes[0]]:.4g}", most, percent))
    return [Table.of_rows(("mode", "load factor", "bends most", "share of beams' energy [%]"), rows, "lrlr")] if rows else []


def _data(buckling: Buckling) -> dict[str, object]:
    return {
        "robot": buckling.robot.name,
        "units": {"load_factors": "common to all forces; null: none", "twists": "of the platform at o, of any size [m; rad]"},
        "shape": buckling.shape,
        **attributes(buckling.configuration, ("platform", "actuators")),
        **attributes(buckling, ("load_factors", "members", "energy_shares", "twists")),
    }
