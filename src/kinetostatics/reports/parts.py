"""Reports of single limbs and beams."""

from __future__ import annotations

import dataclasses

import numpy as np

from kinetostatics.layout.blocks import Facts, Number, ReportSection, Table
from kinetostatics.layout.numbers import FORCES, LENGTHS, MASSES, MILLIMETRES, NOISE, PER_CENT, STRESSES, UNITS_OF, largest
from kinetostatics.layout.plain import attributes
from kinetostatics.layout.report import Report
from kinetostatics.quantities import reported_names
from kinetostatics.results.beam import BeamResult
from kinetostatics.results.limb import LimbResult, wrench_units

#: Data of a beam.
BEAM_DATA = [item.name for item in dataclasses.fields(BeamResult) if item.name not in ("name", "description")]


def limb_report(limb: LimbResult) -> Report:
    """Return the intensities of a limb's wrenches."""
    rows = []
    noise = {"N": NOISE * largest([limb.wrench[..., :3]]), "N·m": NOISE * largest([limb.wrench[..., 3:]])}
    for labels, wrenches, values in (
        (limb.labels, limb.constraint_wrenches, limb.intensities),
        (limb.attached_labels, limb.attached_wrenches, limb.attached_intensities),
    ):
        for k, (label, unit) in enumerate(zip(labels, wrench_units(labels, wrenches), strict=True)):
            rows.append((label, Number.range_of(values[..., k], UNITS_OF[unit], noise[unit])))
    words = ", ".join(f"{label} {number}" for label, number in rows) or "no constraint wrench"
    table = Table.of_rows(("wrench acting on the limb", "intensity"), rows)
    return Report(f"LimbResult {limb.name!r}: {words}", lambda: [ReportSection("", [table])], lambda: limb_data(limb))


def beam_report(beam: BeamResult) -> Report:
    """Return length, forces, stress and deflection of a beam."""
    rows = [
        ("length", Number.range_of(beam.length, MILLIMETRES)),
        ("axial force", Number.range_of(beam.section_wrenches[..., 0], FORCES)),
        ("stress", Number.range_of(beam.stress, STRESSES)),
        ("N/N_Euler", Number.range_of(beam.euler_ratio, PER_CENT, NOISE)),
        ("mass", Number.range_of(beam.mass, MASSES)),
        ("largest deflection", Number.range_of(np.linalg.norm(beam.deflections, axis=-1).max(axis=-1), LENGTHS)),
    ]
    words = ", ".join(f"{name} {number}" for name, number in rows[:4])
    return Report(f"BeamResult {beam.name!r}: {words}", lambda: [ReportSection("", [Facts(rows)])], lambda: beam_data(beam))


def limb_data(limb: LimbResult) -> dict[str, object]:
    """Return labels, units and quantities of a limb."""
    return {
        **attributes(limb, ("is_network", "beams", "platform_joints", "labels")),
        "units": wrench_units(limb.labels, limb.constraint_wrenches),
        "attached_labels": limb.attached_labels,
        "attached_units": wrench_units(limb.attached_labels, limb.attached_wrenches),
        **attributes(limb, reported_names("limbs")),
    }


def beam_data(beam: BeamResult) -> dict[str, object]:
    """Return the results of a beam that are not data of the file."""
    return attributes(beam, BEAM_DATA)
