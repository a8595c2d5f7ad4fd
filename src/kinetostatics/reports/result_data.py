"""Data of an analysis: all quantities of the table, with units and words."""

from __future__ import annotations

from collections.abc import Mapping

from kinetostatics.layout.plain import attributes
from kinetostatics.math.arrays import Array
from kinetostatics.quantities import QUANTITIES, reported_names
from kinetostatics.reports.parts import BEAM_DATA, beam_data, limb_data
from kinetostatics.reports.pose import actuator_unit, configuration_data, status_names
from kinetostatics.results.result import Result

#: Units and meaning of the numbers; batch axes come first.
UNITS = {
    "general": "SI: m, rad, kg, s, N, N·m, Pa; world axes; null: not a number, infinite or not determined",
    "batch": "arrays have the axes of `shape` first, those of `configuration` the axes of `configuration.shape`",
    "payload": "mass kg at center m of the frame of link, null: of o-xyz; coefficients: effect per kg and per kg·m of its "
    "first moment: twist, actuator_forces and joint_wrenches per unit of `parameters`, the last axis",
    "limbs": "wrenches acting on the limb: unit wrenches [force; moment] about o, intensities in `units`; where "
    "`is_network`, intensities are coordinates in a basis: the forces are `joint_wrenches` of its `platform_joints` and "
    "`section_wrenches` of its `beams`",
    "stations": "0 at the base end, 1 at the platform end of a beam; deflections in m, rotations in rad, stress in Pa",
    **{name: QUANTITIES[name].description for name in reported_names("")},
    **{name: QUANTITIES[f"beams.{name}"].description for name in reported_names("beams") if name in BEAM_DATA},
}


def result_data(tip: Result) -> dict[str, object]:
    """Return all results of an analysis, about o, and the displacement of a tool's tip; batch axes come first."""
    result = tip.seen_from(None)
    payload = result.payload and {
        **attributes(result.payload, ("mass", "center", "link")),
        "coefficients": result.payload_coefficients,
    }
    found: dict[str, object] = {
        "robot": result.robot.name,
        "file": result.robot.description.path,
        "units": UNITS,
        "shape": result.shape,
        "status": status_names(result.status),
        **result.facts,
        "warnings": result.warnings,
        "configuration": configuration_data(result.configuration),
        "payload": payload,
        **attributes(result, reported_names("")),
        "actuator_units": {name: actuator_unit(result.robot, name) for name in result.actuator_forces},
        "limbs": {name: limb_data(limb) for name, limb in result.limbs.items()},
        "beams": {name: beam_data(beam) for name, beam in result.beams.items()},
    }
    tool = {"point": tip.point, **attributes(tip, ("twist", "stiffness", "compliance"))} if tip.point is not None else None
    return found if tool is None else {**found, "tool": tool}


def units_at(tool: Array | None, units: Mapping[str, str]) -> dict[str, object]:
    """Return units and meaning of numbers about o or the tool's tip, and the position of the tip."""
    if tool is None:
        return {"units": units}
    texts = {name: text.replace("at o", "at the tool's tip") for name, text in units.items()}
    return {"units": {**texts, "tool": "the tip, from o in the platform's axes [m]"}, "tool": tool}
