"""What is told of a point of the platform: ``--tool``."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from kinetostatics.math.arrays import Array
from kinetostatics.math.screws import COMPONENTS
from kinetostatics.printing.text import ANGLES, LENGTHS, STIFFNESSES, quantity, section, table
from kinetostatics.reports.json import named
from kinetostatics.results.tool_point import PointResult


def point_report(found: PointResult) -> str:
    """Return twist and least stiffness of a point at one pose."""
    rows = []
    for k, (name, value) in enumerate(zip(COMPONENTS, found.twist, strict=True)):
        units, part = (LENGTHS, found.twist[:3]) if k < 3 else (ANGLES, found.twist[3:])
        rows.append((name, quantity(value, units, 1e-9 * float(np.max(np.abs(part))))))
    rows.append(("displacement", quantity(float(np.linalg.norm(found.twist[:3])), LENGTHS)))
    softest = float(np.linalg.eigvalsh(found.compliance[:3, :3])[-1])
    rows.append(("least stiffness", quantity(1 / softest, STIFFNESSES) if softest > 0 else "rigid"))
    place = ", ".join(f"{value:g}" for value in found.point)
    return "\n".join(section(f"At the tool's tip, ({place}) m from o in the platform's axes", table(("", ""), rows)))


def point_to_dict(found: PointResult) -> dict[str, object]:
    """Return the same as plain values."""
    return named(found, ("point", "twist", "stiffness", "compliance"))


def said_of(tool: Array | None, units: Mapping[str, str]) -> dict[str, object]:
    """Return what numbers mean that are told of a tool's tip instead of o, for JSON, and where that is."""
    if tool is None:
        return {"units": dict(units)}
    said = {name: text.replace("at o", "at the tool's tip") for name, text in units.items()}
    return {"units": {**said, "tool": "the tip, from o in the platform's axes [m]"}, "tool": np.asarray(tool).tolist()}
