"""Reports of stability and dynamics: buckling, natural frequencies and modes, frequency response, trajectories."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from kinetostatics.layout.blocks import Block, Cell, Column, Facts, Number, ReportSection, Table, Text, warning_section
from kinetostatics.layout.numbers import MISSING, UNITS_OF, NumberFormat, Units, quantity
from kinetostatics.layout.report import NumberTable, Report, attributes
from kinetostatics.math.arrays import Array
from kinetostatics.math.screws import COMPONENTS, WRENCH_COMPONENTS
from kinetostatics.reports.pose import actuator_coordinates, at_pose, count, platform_coordinates, state_title, status_names
from kinetostatics.reports.sources import share as share_of
from kinetostatics.reports.sources import shown_and_rest
from kinetostatics.results.buckling import Buckling
from kinetostatics.results.dynamics import FrequencyResponse, Modes
from kinetostatics.results.path import OVER_TIME, PathResult
from kinetostatics.results.pose_arrays import point_name
from kinetostatics.status import WITHOUT_NUMBERS
from kinetostatics.vibration.eigenpairs import eigenpairs
from kinetostatics.vibration.motions import ModeShapes

HERTZ: Units = (("Hz", 1.0),)

# ---- buckling ------------------------------------------------------------------------------------------------------

#: Relative difference of load factors that count as equal.
_EQUAL_FACTORS = 1e-6
BUCKLING_TITLE = "Load factors, common to all forces, at which the robot buckles"


def buckling_report(buckling: Buckling) -> Report:
    title = [f"Buckling of {buckling.robot.name!r}: ", *state_title(buckling.configuration)]
    return Report(title, lambda: list(_buckling_sections(buckling)), lambda: _buckling_data(buckling))


def _buckling_sections(buckling: Buckling) -> Iterator[ReportSection]:
    if not buckling.shape:
        yield ReportSection(BUCKLING_TITLE, buckling_blocks(buckling), "buckling")
        return
    if np.any(finite := np.isfinite(buckling.load_factors)):
        least = f"{buckling.load_factors[finite].min():.4g}"
        yield ReportSection("Least over the poses", [Facts([("load factor", least)])], "buckling")


def buckling_blocks(buckling: Buckling) -> list[Block]:
    """Return a table with a row for all modes of equal load factor; empty if no load factor is finite."""
    factors = buckling.load_factors[np.isfinite(buckling.load_factors)]
    groups = np.split(np.arange(len(factors)), np.flatnonzero(np.diff(factors) > _EQUAL_FACTORS * factors[1:]) + 1)
    rows: list[tuple[Cell, ...]] = []
    for modes in filter(len, groups):
        shares = {name: round(float(np.mean(values[modes])), 6) for name, values in buckling.energy_shares.items()}
        most = max(shares, key=lambda name: shares[name], default="")
        percent = per_cent(shares[most]) if most else ""
        rows.append((", ".join(str(k + 1) for k in modes), f"{factors[modes[0]]:.4g}", most, percent))
    if not rows:
        return [Text("None: the robot buckles under no multiple of these forces.")] if not buckling.shape else []
    return [Table.of_rows(("mode", "load factor", "bends most", "share of beams' energy [%]"), rows, "lrlr")]


def _buckling_data(buckling: Buckling) -> dict[str, object]:
    return {
        "robot": buckling.robot.name,
        "units": {"load_factors": "common to all forces; null: none", "twists": "of the platform at o, of any size [m; rad]"},
        "shape": buckling.shape,
        **attributes(buckling.configuration, ("platform", "actuators")),
        **attributes(buckling, ("load_factors", "members", "energy_shares", "twists")),
    }


# ---- modes of vibration --------------------------------------------------------------------------------------------

#: Largest number of parts in a table of energies; the remaining parts share one row.
MOST = 8
#: A table of energies omits parts with smaller shares.
NONE = 5e-4

#: A mode is local if all parts moving with the platform as one body would have less than this fraction of its energy.
LOCAL = 0.01
#: Number of modes among which the first one of the platform is sought.
SOUGHT = 60

UNITS_OF_MODES = {
    "general": "SI: m, rad, Hz, kg; world axes, modal masses of 1 kg; null: no number, or fewer modes",
    "twists": "[displacement m; rotation rad] of the platform at o",
    "participation_factors": "translations [kg], rotations about o [kg·m]",
    "effective_masses": "relative to the total mass or inertia, by direction x, y, z, rx, ry, rz",
}


def modes_report(modes: Modes) -> Report:
    title = [f"Natural frequencies of {modes.robot.name!r}: "]
    if modes.shape == ():
        title += [*state_title(modes.configuration, modes.status), "; " + _frequencies(modes)]
    else:
        title += state_title(modes.configuration, modes.status)
    return Report(title, lambda: list(_mode_sections(modes)), lambda: _mode_data(modes), {"modes": lambda: _mode_table(modes)})


def _frequencies(modes: Modes) -> str:
    if np.isnan(modes.frequencies[0]):
        return "unstable: a motion has negative stiffness" if modes.warnings else "no results"
    if not np.isfinite(modes.frequencies[0]):
        if modes.zero_frequencies:
            return f"no natural frequency above zero; {count(int(modes.zero_frequencies), 'free motion')} of frequency zero"
        return "no natural frequency: no elastic part carries a mass"
    form = NumberFormat.of(modes.frequencies[:1], HERTZ, digits=4)
    return ", ".join(form(value) for value in modes.frequencies[:3]) + f"{', …' if modes.count > 3 else ''} {form.unit}"


def _mode_sections(modes: Modes) -> Iterator[ReportSection]:
    if modes.warnings:
        yield warning_section(modes.warnings)
    if not np.any(np.isfinite(modes.frequencies)):
        return
    if modes.shape:
        rows = [(f"mode {k + 1}", Number.range_of(modes.frequencies[..., k], HERTZ)) for k in range(modes.count)]
        yield ReportSection("Ranges over the poses", [Table.of_rows(("", "frequency"), rows)], "modes")
        return
    places = {**platform_coordinates(modes.configuration), **actuator_coordinates(modes.configuration)}
    where = ", ".join(f"{name} {at_pose(coordinate)}" for name, coordinate in places.items())
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
    if sentence := _local_modes(modes):
        blocks.append(Text(sentence))
    yield ReportSection("Modes, and their effective masses [%] along x, y, z and about axes through o", blocks, "modes")
    for title, key, shares in (
        ("Strain energy by part [%]: what to stiffen", "strain", modes.strain_energy_shares),
        ("Kinetic energy by part [%]: what to make lighter", "kinetic", modes.kinetic_energy_shares),
    ):
        yield ReportSection(title, [_energies(shares, numbers)], key)


def _mode_table(modes: Modes) -> NumberTable:
    columns = {"frequency [Hz]": modes.frequencies}
    columns |= {f"effective mass {name}": modes.effective_masses[..., k] for k, name in enumerate(COMPONENTS)}
    for kind, shares in (("strain", modes.strain_energy_shares), ("kinetic", modes.kinetic_energy_shares)):
        columns |= {f"{kind} energy of {name}": share for name, share in shares.items()}
    return {"mode": range(1, modes.count + 1)}, columns


def _local_modes(modes: Modes) -> str:
    """Return a sentence on the first mode that moves the platform if none of the modes at one pose does, else an empty text."""
    chunk, number = modes.chunks[0], modes.count
    while True:
        twists = chunk.of_body(chunk.motions.structure.platform, chunk.motions.o)[0]  # of modal masses of 1 kg
        moving = np.flatnonzero(np.nan_to_num(twists) ** 2 @ np.diag(chunk.inertia[0]) > LOCAL)
        if moving.size and number == modes.count:
            return ""
        if moving.size or number >= SOUGHT or not np.all(np.isfinite(chunk.pairs.square)):
            break
        number = min(2 * number, SOUGHT)
        chunk = ModeShapes(eigenpairs(chunk.pairs.model, number), chunk.motions)
    sentence = "All modes here are local to rods, and hardly move the platform"
    if not moving.size:
        return f"{sentence}; so are the first {int(np.sum(np.isfinite(chunk.pairs.square)))}."
    frequency = float(np.sqrt(chunk.pairs.square[0, moving[0]]) / (2 * np.pi))
    return f"{sentence}; its first mode is mode {moving[0] + 1}, at {quantity(frequency, HERTZ, digits=4)}."


def _energies(shares: Mapping[str, Array], modes: list[str]) -> Table:
    """Return a table with a row for each of the parts with the largest shares, and one for the other parts."""
    sizes = {name: float(np.max(np.nan_to_num(share))) for name, share in shares.items()}
    ranked = [name for name in sorted(sizes, key=lambda name: -round(sizes[name], 6)) if sizes[name] > NONE]
    rows: list[tuple[Cell, ...]] = []
    shown, others = shown_and_rest(ranked, MOST)
    rows += [(name, *map(per_cent, shares[name])) for name in shown]
    if others:
        rows.append((f"{len(others)} others", *map(per_cent, np.sum([shares[name] for name in others], axis=0))))
    return Table.of_rows(("part", *(f"mode {k}" for k in modes)), rows, wide=True)


def per_cent(share: float) -> str:
    """Write a share, from 0 to 1, in per cent without the sign %."""
    return f"{share_of(share, 1.0):.1f}" if np.isfinite(share) else MISSING


def _mode_data(modes: Modes) -> dict[str, object]:
    return {
        "robot": modes.robot.name,
        "units": UNITS_OF_MODES,
        "shape": modes.shape,
        "status": status_names(modes.status),
        "warnings": modes.warnings,
        **attributes(modes.configuration, ("platform", "actuators")),
        **attributes(modes, ("drives", "frequencies", "zero_frequencies", "twists")),
        **attributes(modes, ("participation_factors", "effective_masses", "strain_energy_shares", "kinetic_energy_shares")),
    }


# ---- frequency response --------------------------------------------------------------------------------------------

UNITS_OF_RESPONSE = {
    "general": "SI: m, rad, N, N·m, Hz; world axes; last axes: twist, and wrench or motion of the floor; null: no number",
    "compliance": "twist of the platform per wrench on it, magnitude; phases in rad; transmissibility: per motion of the floor",
}


def frequency_response_report(response: FrequencyResponse) -> Report:
    f = response.frequencies
    title = [
        f"Frequency response of {response.robot.name!r} at {point_name(response.tool)}: ",
        *state_title(response.configuration, response.status),
    ]
    title.append(f"; {f.min():.4g} to {f.max():.4g} Hz, {len(f)} frequencies")
    return Report(title, lambda: list(_response_sections(response)), lambda: _response_data(response))


def _response_sections(response: FrequencyResponse) -> Iterator[ReportSection]:
    if response.warnings:
        yield warning_section(response.warnings)
    if not np.any(np.isfinite(response.compliance)):
        return
    units = ["m/N"] * 3 + ["rad/(N·m)"] * 3
    for title, key, array, along in (
        ("Compliance: largest twist per wrench in the same direction", "compliance", response.compliance, WRENCH_COMPONENTS),
        ("Transmissibility: largest motion per motion of the floor", "transmissibility", response.transmissibility, COMPONENTS),
    ):
        size = np.abs(np.einsum("...ii->...i", array)).reshape(-1, len(response.frequencies), 6)
        peak = np.nanmax(size, axis=0)
        at = np.argmax(peak, axis=0)
        names = [f"{name} per {other}" for name, other in zip(COMPONENTS, along, strict=True)]
        largest = [f"{peak[at[k], k]:.3e} {units[k]}" if key == "compliance" else f"{peak[at[k], k]:.3f}" for k in range(6)]
        columns = [Column("", names), Column("largest", largest, "r")]
        columns.append(Column("at [Hz]", [f"{response.frequencies[k]:.5g}" for k in at], "r"))
        yield ReportSection(title, [Table(columns)], key)
    ratio = response.damping
    words = ", ".join(f"{name} {value:g}" for name, value in ratio.items()) if isinstance(ratio, Mapping) else f"ratio {ratio:g}"
    yield ReportSection("", [Text(f"Damping: {words}.")])


def _response_data(response: FrequencyResponse) -> dict[str, object]:
    return {
        "robot": response.robot.name,
        "units": UNITS_OF_RESPONSE,
        "shape": response.shape,
        "status": status_names(response.status),
        "warnings": response.warnings,
        **attributes(response, ("damping", "drives", "tool", "frequencies")),
        "compliance": np.abs(response.compliance),
        "compliance_phase": np.angle(response.compliance),
        "transmissibility": np.abs(response.transmissibility),
        "transmissibility_phase": np.angle(response.transmissibility),
    }


# ---- trajectories --------------------------------------------------------------------------------------------------

SECONDS: Units = (("s", 1.0),)
#: Units to choose from for quantities over time.
_UNITS_OVER_TIME: dict[str, Units] = {**UNITS_OF, **{unit: ((unit, 1.0),) for unit in ("m/s", "rad/s", "W")}}
UNITS_OF_PATHS = {
    "general": "SI: s, m, rad, N, N·m, Pa, W; world axes; arrays over time, last axes as in Result; null: no number",
    "actuator_velocities": "m/s, of turning joints rad/s; actuator_forces: N, of turning joints N·m",
    "peaks": "the value of the largest magnitude and its time, by quantity and name",
}


def path_report(path: PathResult) -> Report:
    title = [f"Path of {path.result.robot.name!r} in {np.ptp(path.times):.4g} s: ", *state_title(path.result)]
    return Report(title, lambda: list(_path_sections(path)), lambda: _path_data(path))


def _path_sections(path: PathResult) -> Iterator[ReportSection]:
    result = path.result
    if not np.all(np.isin(result.status, WITHOUT_NUMBERS)):
        shown = ("displacement", "rotation", "stress", "joint_force", "joint_moment")
        rows = [row for what in shown for row in _peak_rows(path, what)]
        yield ReportSection("Peaks", [Table.of_rows(("quantity", "largest", "of", "at"), rows, "lrlr")], "peaks")
        if result.actuator_forces:
            yield ReportSection("Actuators", [_actuators(path)], "actuators")
        for what in ("stress", "joint_force", "joint_moment"):
            if rows := _peak_rows(path, what, every=True):
                table = Table.of_rows(("", "largest", "at"), [(of, value, at) for _, value, of, at in rows], "lrr")
                yield ReportSection(f"Peaks of the {OVER_TIME[what].words}", [table], what, detail=True)
    yield warning_section(path.warnings)


def _peak_rows(path: PathResult, what: str, every: bool = False) -> list[tuple[str, Number, str, Number]]:
    """Return rows (quantity, peak, its name, time) for the largest peak; with ``every``, for each peak above rounding errors."""
    peaks, entry = path.peaks(what), OVER_TIME[what]
    form = NumberFormat.of([peak.value for peak in peaks.values()], _UNITS_OVER_TIME[entry.unit])
    names = [name for name in peaks if every and abs(peaks[name].value) > form.noise]
    names = names if every else sorted(peaks, key=lambda name: -abs(peaks[name].value))[:1]
    words = entry.words.format(point=path.result.point_name)
    return [
        (words, Number(peaks[name].value, form), "" if name == path.result.point_name else name, _time(path, peaks[name].time))
        for name in names
    ]


def _time(path: PathResult, time: float) -> Number:
    return Number(time, NumberFormat.of(path.times, SECONDS, digits=4))


def _actuators(path: PathResult) -> Table:
    rows: list[tuple[Cell, ...]] = []
    for force, speed in (("actuator_force", "actuator_speed"), ("actuator_torque", "actuator_rate")):
        powers, speeds, rms = path.peaks("actuator_power"), path.peaks(speed), path.root_mean_square(force)
        for name, peak in path.peaks(force).items():
            form = NumberFormat.of(peak.value, _UNITS_OVER_TIME[OVER_TIME[force].unit])
            others = ((speeds[name].value, OVER_TIME[speed].unit), (powers[name].value, "W"))
            numbers = (Number.of(value, _UNITS_OVER_TIME[unit]) for value, unit in others)
            rows.append((name, Number(peak.value, form), _time(path, peak.time), Number(rms[name], form), *numbers))
    header = ("actuator", "largest force", "at", "root mean square", "largest velocity", "largest power")
    return Table.of_rows(header, rows, "lrrrrr")


def _path_data(path: PathResult) -> dict[str, object]:
    result = path.result
    return {
        "robot": result.robot.name,
        "units": UNITS_OF_PATHS,
        "status": status_names(result.status),
        "warnings": path.warnings,
        "orientation": result.configuration.orientation.name,
        **attributes(path, ("times", "actuator_velocities")),
        **attributes(result.configuration, ("platform", "actuators")),
        **attributes(result, ("twist", "contributions", "actuator_forces", "joint_wrenches")),
        "stress": path.over_time("stress"),
        "peaks": {what: {n: {"value": p.value, "time": p.time} for n, p in path.peaks(what).items()} for what in OVER_TIME},
    }
