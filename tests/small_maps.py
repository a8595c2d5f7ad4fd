"""Workspace maps for the tests of indices and plots, made by hand: Datasets laid out as those of ``ks.sweep``."""

import numpy as np
import xarray as xr

import kinetostatics as ks

COMPONENTS = ["x", "y", "z", "rx", "ry", "rz"]
UNITS = {"x": "m", "y": "m", "z": "m", "rx": "rad", "ry": "rad", "rz": "rad"}


def map_of(coordinates, *, compliance=None, twist=None, forces=None, status=None, length=1.0, pose=None, contribution=None):
    """Return a map over coordinates ``{name: (values, units)}``; all arrays batch first.

    Args:
        coordinates: the swept ones.
        compliance: (…, 6, 6); the stiffness is its inverse.
        twist: (…, 6).
        forces: {drive: (…)} [N].
        status: (…).
        length: the characteristic length.
        pose: (…, 6).
        contribution: {source: (…, 6)}.
    """
    dims = tuple(coordinates)
    shape = tuple(len(values) for values, _ in coordinates.values())
    coords = {name: (name, np.asarray(values), {"units": units}) for name, (values, units) in coordinates.items()}
    coords |= {"component": COMPONENTS, "component_2": COMPONENTS}
    data = {"characteristic_length": ((), length, {"units": "m"})}
    meanings = " ".join(item.name.lower() for item in ks.Status)
    status = np.zeros(shape, np.int8) if status is None else np.asarray(status, np.int8)
    data["status"] = (dims, status, {"flag_values": [int(item) for item in ks.Status], "flag_meanings": meanings})
    twist = np.zeros((*shape, 6)) if twist is None else twist
    data["twist"] = ((*dims, "component"), np.broadcast_to(twist, (*shape, 6)), {"long_name": "twist of the platform at o"})
    if compliance is not None:
        compliance = np.broadcast_to(compliance, (*shape, 6, 6))
        data["compliance"] = ((*dims, "component", "component_2"), compliance)
        data["stiffness"] = ((*dims, "component", "component_2"), np.linalg.inv(compliance))
    if forces is not None:
        coords["actuator"] = list(forces)
        stacked = np.stack([np.broadcast_to(force, shape) for force in forces.values()], axis=-1)
        data["actuator_force"] = ((*dims, "actuator"), stacked, {"units": "N"})
    if contribution is not None:
        coords["source"] = list(contribution)
        stacked = np.stack([np.broadcast_to(part, (*shape, 6)) for part in contribution.values()], axis=-2)
        data["contribution"] = ((*dims, "source", "component"), stacked)
    if pose is not None:
        data["platform_pose"] = ((*dims, "component"), np.broadcast_to(pose, (*shape, 6)))
    return xr.Dataset(data, coords=coords)
