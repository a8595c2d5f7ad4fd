"""Report of buckling: load factors, and the members with the largest strain energy in each mode."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from kinetostatics.layout.blocks import Block, Column, Facts, ReportSection, Table
from kinetostatics.layout.plain import attributes
from kinetostatics.layout.report import Report
from kinetostatics.reports.pose import state_title
from kinetostatics.reports.sources import share
from kinetostatics.results.buckling import Buckling

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
    """Return a table of the buckling modes of one pose with finite load factors; an empty list if there are none."""
    modes = [k for k in range(buckling.count) if np.isfinite(buckling.load_factors[k])]
    names = [str(name) for name in buckling.members[modes]]
    parts = [f"{share(buckling.energy_shares[name][k], 1.0):.1f}" if name else "" for k, name in zip(modes, names, strict=True)]
    columns = [
        Column("mode", [str(k + 1) for k in modes]),
        Column("load factor", [float(f"{buckling.load_factors[k]:.4g}") for k in modes], "r"),
        Column("bends most", names),
        Column("share of beams' energy [%]", parts, "r"),
    ]
    return [Table(columns)] if modes else []


def _data(buckling: Buckling) -> dict[str, object]:
    return {
        "robot": buckling.robot.name,
        "units": {
            "load_factors": "common to all forces; null: none",
            "twists": "of the platform at o, of any size [m; rad]",
        },
        "shape": buckling.shape,
        **attributes(buckling.configuration, ("platform", "actuators")),
        **attributes(buckling, ("load_factors", "members", "energy_shares", "twists")),
    }
