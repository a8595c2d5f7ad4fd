"""Report of a frequency response: the largest response in each direction."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from kinetostatics.layout.blocks import Column, ReportSection, Table, Text
from kinetostatics.layout.plain import attributes
from kinetostatics.layout.report import Report
from kinetostatics.math.screws import COMPONENTS, WRENCH_COMPONENTS
from kinetostatics.reports.pose import state_title
from kinetostatics.results.frequency_response import FrequencyResponse
from kinetostatics.results.tool_point import point_name

UNITS = {
    "general": "SI: m, rad, N, N·m, Hz; world axes; last axes: twist, and wrench or motion of the floor; null: no number",
    "compliance": "twist of the platform per wrench on it, magnitude; phases in rad; transmissibility: per motion of the floor",
}


def frequency_response_report(found: FrequencyResponse) -> Report:
    """Return the report of the frequency response of a pose, or of the largest over a batch."""
    f = found.frequencies
    title = [f"Frequency response of {found.robot.name!r} at {point_name(found.tool)}: ", *state_title(found.configuration)]
    title.append(f"; {f.min():.4g} to {f.max():.4g} Hz, {len(f)} frequencies")
    return Report(title, lambda: list(_sections(found)), lambda: _data(found))


def _sections(found: FrequencyResponse) -> Iterator[ReportSection]:
    if not np.any(np.isfinite(found.compliance)):
        return
    units = ["m/N"] * 3 + ["rad/(N·m)"] * 3
    for title, key, array, along in (
        (
            "Compliance: largest twist per wrench in the same direction",
            "compliance",
            found.compliance,
            WRENCH_COMPONENTS,
        ),
        ("Transmissibility: largest motion per motion of the floor", "transmissibility", found.transmissibility, COMPONENTS),
    ):
        size = np.abs(np.einsum("...ii->...i", array)).reshape(-1, len(found.frequencies), 6)
        peak = np.nanmax(size, axis=0)
        at = np.argmax(peak, axis=0)
        names = [f"{name} per {other}" for name, other in zip(COMPONENTS, along, strict=True)]
        largest = [f"{peak[at[k], k]:.3e} {units[k]}" if key == "compliance" else f"{peak[at[k], k]:.3f}" for k in range(6)]
        columns = [Column("", names), Column("largest", largest, "r")]
        columns.append(Column("at [Hz]", [f"{found.frequencies[k]:.5g}" for k in at], "r"))
        yield ReportSection(title, [Table(columns)], key)
    ratio = found.damping
    words = ", ".join(f"{name} {value:g}" for name, value in ratio.items()) if isinstance(ratio, Mapping) else f"ratio {ratio:g}"
    yield ReportSection("", [Text(f"Damping: {words}.")])


def _data(found: FrequencyResponse) -> dict[str, object]:
    return {
        "robot": found.robot.name,
        "units": UNITS,
        "shape": found.shape,
        **attributes(found, ("damping", "drives", "tool", "frequencies")),
        "compliance": np.abs(found.compliance),
        "compliance_phase": np.angle(found.compliance),
        "transmissibility": np.abs(found.transmissibility),
        "transmissibility_phase": np.angle(found.transmissibility),
    }
