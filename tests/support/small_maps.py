"""Workspace maps for the tests of indices and plots, made by hand: Datasets laid out as those of ``ks.sweep``."""

import numpy as np
import xarray as xr

import kinetostatics as ks

COMPONENTS = ["x", "y", "z", "rx", "ry", "rz"]
UNITS = {"x": "m", "y": "m", "z": "m", "rx": "rad", "ry": "rad", "rz": "rad"}


def map_of(
    coordinates,
    *,
    compliance=None,
    twist=None,
    forces=None,
    turning=(),
    status=None,
    length=1.0,
    pose=None,
    contribution=None,
    residual_error=None,
    frequencies=None,
):
    """Return a map over coordinates ``{name: (values, units)}``; all arrays batch first.

    Args:
        coordinates: the swept ones.
        compliance: (…, 6, 6); the stiffness is its inverse.
        twist: (…, 6).
        forces: {actuator: (…)}.
        turning: the actuators whose forces are torques.
        status: (…).
        length: the characteristic length.
        pose: (…, 6).
        contribution: {source: (…, 6)}.
        residual_error: (…, 6) what no actuator corrects.
        frequencies: (…, modes).
    """
    dims = tuple(coordinates)
    shape = tuple(len(values) for values, _ in coordinates.values())
    coords = {name: (name, np.asarray(values), {"units": units}) for name, (values, units) in coordinates.items()}
    coords |= {"component": COMPONENTS, "component_2": COMPONENTS, "component_unit": ("component", list(UNITS.values()))}
    data = {"characteristic_length": ((), length, {"units": "m"})}
    meanings = " ".join(item.name.lower() for item in ks.Status)
    status = np.zeros(shape, np.int8) if status is None else np.asarray(status, np.int8)
    data["status"] = (dims, status, {"flag_values": [int(item) for item in ks.Status], "flag_meanings": meanings})
    twist = np.zeros((*shape, 6)) if twist is None else twist
    data["twist"] = ((*dims, "component"), np.broadcast_to(twist, (*shape, 6)), {"unit_coordinate": "component_unit"})
    if residual_error is not None:
        data["residual_error"] = (
            (*dims, "component"),
            np.broadcast_to(residual_error, (*shape, 6)),
            {"unit_coordinate": "component_unit"},
        )
    if compliance is not None:
        compliance = np.broadcast_to(compliance, (*shape, 6, 6))
        matrix = (*dims, "component", "component_2")
        data["compliance"] = (matrix, compliance, {"unit_coordinate": "compliance_unit"})
        data["stiffness"] = (matrix, np.linalg.inv(compliance), {"unit_coordinate": "stiffness_unit"})
        moves, wrenches = list(UNITS.values()), ["N"] * 3 + ["N m"] * 3
        coords["compliance_unit"] = (matrix[-2:], [[f"{m}/({w})" if " " in w else f"{m}/{w}" for w in wrenches] for m in moves])
        coords["stiffness_unit"] = (matrix[-2:], [[f"{w}/{m}" for m in moves] for w in wrenches])
    if forces is not None:
        coords["actuator"] = list(forces)
        stacked = np.stack([np.broadcast_to(force, shape) for force in forces.values()], axis=-1)
        data["actuator_force"] = ((*dims, "actuator"), stacked, {"unit_coordinate": "actuator_force_unit"})
        data["actuator_utilization"] = ((*dims, "actuator"), stacked / 2, {"units": "1"})
        coords["actuator_force_unit"] = ("actuator", ["N m" if name in turning else "N" for name in forces])
    if contribution is not None:
        coords["source"] = list(contribution)
        stacked = np.stack([np.broadcast_to(part, (*shape, 6)) for part in contribution.values()], axis=-2)
        data["contribution"] = ((*dims, "source", "component"), stacked, {"unit_coordinate": "component_unit"})
    if frequencies is not None:
        frequencies = np.broadcast_to(frequencies, (*shape, np.shape(frequencies)[-1]))
        data["frequency"] = ((*dims, "natural_mode"), frequencies, {"units": "Hz"})
    if pose is not None:
        data["platform_pose"] = (
            (*dims, "platform_coordinate"),
            np.broadcast_to(pose, (*shape, 6)),
            {"unit_coordinate": "platform_coordinate_unit"},
        )
        coords["platform_coordinate"] = COMPONENTS
        coords["platform_coordinate_unit"] = ("platform_coordinate", list(UNITS.values()))
    return xr.Dataset(data, coords=coords)
