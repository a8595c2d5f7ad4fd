"""Workspace maps with another reference point, such as the tip of a tool."""

from __future__ import annotations

import json
from collections.abc import Sequence

import numpy as np
import xarray as xr

from kinetostatics.arguments import warn
from kinetostatics.exceptions import ArgumentError
from kinetostatics.indices.map_variables import ANGULAR, LINEAR, variable
from kinetostatics.math.arrays import Array
from kinetostatics.math.rotations import orientation_named
from kinetostatics.math.screws import Kind, move
from kinetostatics.quantities import VARIABLES
from kinetostatics.results.tool_point import point_of_platform
from kinetostatics.unit_hints import point_hint


def at_point(ds: xr.Dataset, tool: Sequence[float]) -> xr.Dataset:
    """Return a map with twists, stiffness and compliance at another point of the platform, such as a tool's tip, instead of o.

    Its indices and figures refer to this point: ``linear_sag(at_point(ds, (0, 0, 0.2)))`` is the displacement of the tip.

    Args:
        ds: the map, see :func:`kinetostatics.sweep`.
        tool: (3,) the point, from o in the platform's axes [m].

    Raises:
        ArgumentError: the value is not a point, or the map has another reference point already.
    """
    place = point_of_platform("tool", tool)
    size = float(variable(ds, "characteristic_length").max())
    if "point" in ds.attrs:
        raise ArgumentError("the map has another reference point than o already: use the original map")
    for hint in point_hint("tool", place, size):
        warn(hint)
    pose = variable(ds, "platform_pose")
    names = [str(name) for name in pose["platform_coordinate"].values[3:]]
    known = json.loads(str(ds.attrs.get("arguments", "{}"))).get("orientation")
    convention = orientation_named("tilt_torsion" if "tilt" in names else known)
    order = [*LINEAR, *ANGULAR]

    def arms(coordinates: Array) -> Array:
        angles = np.moveaxis(np.asarray(coordinates)[..., 3:], -1, 0)
        R = convention.matrix(angles.reshape(3, -1)).reshape(3, 3, *angles.shape[1:])
        return np.moveaxis(np.einsum("ij...,j->i...", R, place), 0, -1)

    def moved(array: Array, coordinates: Array, kind: Kind) -> Array:
        return move(kind, np.asarray(array), arms(coordinates), components_last=True)

    found = {}
    for name, item in ((name, item) for name, item in VARIABLES.items() if item.moves_as and name in ds):
        dims = [dim for dim in item.dims if dim.startswith("component")]
        array = ds[name].sel(dict.fromkeys(dims, order))
        new = xr.apply_ufunc(
            moved,
            array,
            pose,
            kwargs={"kind": item.moves_as},
            input_core_dims=[dims, ["platform_coordinate"]],
            output_core_dims=[dims],
            dask="parallelized",
            output_dtypes=[float],
            dask_gufunc_kwargs={"allow_rechunk": True},
        )
        new.attrs = {**array.attrs, "long_name": f"{array.attrs.get('long_name', name)}; of a point of the platform instead of o"}
        found[name] = new.transpose(*ds[name].dims)
    changed = ds.assign(found)
    changed.attrs = {**ds.attrs, "point": place.tolist()}
    return changed
