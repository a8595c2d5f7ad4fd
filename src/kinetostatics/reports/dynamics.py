"""Reports of natural frequencies, modes of vibration, and frequency response."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from kinetostatics.layout.blocks import Block, Cell, Column, Facts, Number, ReportSection, Table, Text
from kinetostatics.layout.numbers import MISSING, NumberFormat, Units
from kinetostatics.layout.report import Report, attributes
from kinetostatics.math.arrays import Array
from kinetostatics.math.screws import COMPONENTS, WRENCH_COMPONENTS
from kinetostatics.reports.pose import actuator_coordinates, at_pose, count, platform_coordinates, state_title, status_names
from kinetostatics.reports.sources import share as share_of
from kinetostatics.results.dynamics import FrequencyResponse, Modes
from kinetostatics.results.tool_point import point_name

HERTZ: Units = (("Hz", 1.0),)
#: Parts of a table of energies, the largest first.
MOST = 8
#: Share of the energy up to which a part is left out.
NONE = 5e-4

UNITS_OF_MODES = {
    "general": "SI: m, rad, Hz, kg; world axes, modal masses of 1 kg; null: no number, or fewer modes",
    "twists": "[displacement m; rotation rad] of the platform at o",
    "participation_factors": "translations [kg], rotations about o [kg·m]",
    "effective_masses": "relative to the total mass or inertia, by direction x, y, z, rx, ry, rz",
}


def modes_report(modes: Modes) -> Report:
    """Return the report of the modes of one pose, or of the ranges of their frequencies over a batch."""
    title = [f"Natural frequencies of {modes.robot.name!r}: "]
    if modes.shape == ():
        title += [*state_title(modes.configuration), "; " + _frequencies(modes)]
    else:
        title += state_title(modes.configuration)
    return Report(title, lambda: list(_mode_sections(modes)), lambda: _mode_data(modes))


def _frequencies(modes: Modes) -> str:
    if np.isnan(modes.frequencies[0]):
        return "unstable: a motion has negative stiffness"
    if not np.isfinite(modes.frequencies[0]):
        return "no natural frequency: no elastic part carries a mass"
    form = NumberFormat.of(modes.frequencies[:1], HERTZ, digits=4)
    return ", ".join(form(value) for value in modes.frequencies[:3]) + f"{', …' if modes.count > 3 else ''} {form.unit}"


def _mode_sections(modes: Modes) -> Iterator[ReportSection]:
    if not np.any(np.isfinite(modes.frequencies)):
        return
    if modes.shape:
        rows = [(f"mode {k + 1}", Number.range_of(modes.frequencies[..., k], HERTZ)) for k in range(modes.count)]
        yield ReportSection("Ranges over the poses", [Table.of_rows(("", "frequency"), rows)], "modes")
        return
    places = {**platform_coordinates(modes.configuration), **actuator_coordinates(modes.configuration)}
    where = ", ".join(f"{name} {at_pose(item)}" for name, item in places.items())
    how = "locked" if modes.drives == "locked" else "free"
    yield ReportSection("Pose", [Facts([("coordinates", where), ("actuators", how)])], "pose")
    numbers = [str(k + 1) for k in range(modes.count)]
    columns = [Column("mode", numbers), Column.of("frequency", list(modes.frequencies), HERTZ)]
    columns += [
        Column(name, [per_cent(value) for value in modes.effective_masses[:, k]], "r") for k, name in enumerate(COMPONENTS)
    ]
    blocks: list[Block] = [Table(columns)]
    if modes.zero_frequencies:
        blocks.append(Text(f"Not listed: {count(int(modes.zero_frequencies), 'free motion')} of frequency zero."))
    yield ReportSection("Modes, and their effective masses [%] along x, y, z and about axes through o", blocks, "modes")
    for title, key, shares in (
        ("Strain energy by part [%]: what to stiffen", "strain", modes.strain_energy_shares),
        ("Kinetic energy by part [%]: what to make lighter", "kinetic", modes.kinetic_energy_shares),
    ):
        yield ReportSection(title, [_energies(shares, numbers)], key)


def _energies(shares: Mapping[str, Array], modes: list[str]) -> Table:
    """Return the parts with the largest shares of the energy of any mode."""
    sizes = {name: float(np.max(np.nan_to_num(share))) for name, share in shares.items()}
    ranked = [name for name in sorted(sizes, key=lambda name: -round(sizes[name], 6)) if sizes[name] > NONE]
    rows: list[tuple[Cell, ...]] = []
    number = len(ranked) if len(ranked) <= MOST + 1 else MOST
    for name in ranked[:number]:
        rows.append((name, *map(per_cent, shares[name])))
    if number < len(ranked):
        rows.append(
            (f"{len(ranked) - number} others", *map(per_cent, np.sum([shares[name] for name in ranked[number:]], axis=0)))
        )
    return Table.of_rows(("part", *(f"mode {k}" for k in modes)), rows, wide=True)


def per_cent(share: float) -> str:
    """Return a share as a number of per cent."""
    return f"{share_of(share, 1.0):.1f}" if np.isfinite(share) else MISSING


def _mode_data(modes: Modes) -> dict[str, object]:
    return {
        "robot": modes.robot.name,
        "units": UNITS_OF_MODES,
        "shape": modes.shape,
        "status": status_names(modes.status),
        **attributes(modes.configuration, ("platform", "actuators")),
        **attributes(modes, ("drives", "frequencies", "zero_frequencies", "twists")),
        **attributes(modes, ("participation_factors", "effective_masses", "strain_energy_shares", "kinetic_energy_shares")),
    }


UNITS_OF_RESPONSE = {
    "general": "SI: m, rad, N, N·m, Hz; world axes; last axes: twist, and wrench or motion of the floor; null: no number",
    "compliance": "twist of the platform per wrench on it, magnitude; phases in rad; transmissibility: per motion of the floor",
}


def frequency_response_report(found: FrequencyResponse) -> Report:
    """Return the report of the frequency response of a pose, or of the largest response over a batch."""
    f = found.frequencies
    title = [f"Frequency response of {found.robot.name!r} at {point_name(found.tool)}: ", *state_title(found.configuration)]
    title.append(f"; {f.min():.4g} to {f.max():.4g} Hz, {len(f)} frequencies")
    return Report(title, lambda: list(_response_sections(found)), lambda: _response_data(found))


def _response_sections(found: FrequencyResponse) -> Iterator[ReportSection]:
    if not np.any(np.isfinite(found.compliance)):
        return
    units = ["m/N"] * 3 + ["rad/(N·m)"] * 3
    for title, key, array, along in (
        ("Compliance: largest twist per wrench in the same direction", "compliance", found.compliance, WRENCH_COMPONENTS),
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


def _response_data(found: FrequencyResponse) -> dict[str, object]:
    return {
        "robot": found.robot.name,
        "units": UNITS_OF_RESPONSE,
        "shape": found.shape,
        **attributes(found, ("damping", "drives", "tool", "frequencies")),
        "compliance": np.abs(found.compliance),
        "compliance_phase": np.angle(found.compliance),
        "transmissibility": np.abs(found.transmissibility),
        "transmissibility_phase": np.angle(found.transmissibility),
    }
