"""Valid poses of a workspace map, and the arrays of its variables."""

from __future__ import annotations

import json
from collections.abc import Sequence

import numpy as np
import xarray as xr

from kinetostatics.arguments import warn
from kinetostatics.exceptions import ArgumentError, near_names
from kinetostatics.math.arrays import Array
from kinetostatics.math.rotations import orientation_named
from kinetostatics.math.screws import Kind, move
from kinetostatics.quantities import VARIABLES
from kinetostatics.results.pose_arrays import point_of_platform
from kinetostatics.status import WITHOUT_NUMBERS, in_map
from kinetostatics.unit_hints import point_hint

#: Linear and angular components of twists.
LINEAR, ANGULAR = ("x", "y", "z"), ("rx", "ry", "rz")


def valid(ds: xr.Dataset, beyond_limits: bool = False) -> xr.DataArray:
    """Return a mask over the swept dimensions, True at valid poses: poses with numbers, within all joint limits.

    Args:
        ds: the map, see :func:`kinetostatics.sweep`.
        beyond_limits: whether to include poses beyond joint limits; their results are correct, but the robot cannot reach them.

    Raises:
        ArgumentError: the Dataset is not a map.
    """
    numbers = ~variable(ds, "status").isin([int(status) for status in WITHOUT_NUMBERS])
    return numbers if beyond_limits else numbers & ~in_map(ds, "limit_exceeded")


def swept(ds: xr.Dataset) -> tuple[str, ...]:
    """Return the names of the swept dimensions."""
    return tuple(str(name) for name in variable(ds, "status").dims)


def variable(ds: xr.Dataset, name: str) -> xr.DataArray:
    if isinstance(ds, xr.Dataset) and name in ds:
        return ds[name]
    if isinstance(ds, xr.Dataset) and "characteristic_length" in ds and name in VARIABLES:
        raise ArgumentError(absent(name))
    raise ArgumentError(f"this is not a Dataset of ks.sweep: it has no variable {name!r}")


def absent(name: str) -> str:
    """Return the error message for a variable that a map lacks."""
    group = VARIABLES[name].group
    if group == "modes":
        return f"the map has no {name!r}; sweep with modes=3, or as many as you need"
    return f"the map has no {name!r}; sweep with {(name if group in ('default', 'always') else group)!r} among the outputs"


def finished(ds: xr.Dataset, values: xr.DataArray, beyond_limits: bool, units: str, long_name: str) -> xr.DataArray:
    """Return values with units and name, NaN at invalid poses, with only the swept and the scalar coordinates of the map."""
    array = values.where(valid(ds, beyond_limits)).transpose(*swept(ds))
    kept = {*swept(ds), *(name for name in ds.coords if ds[name].dims == ())}
    array = array.drop_vars([name for name in array.coords if name not in kept])
    is_about = "point" in ds.attrs and not any(word in long_name for word in ("the point", "actuator"))
    array.attrs = {"units": units, "long_name": long_name + is_about * " at a point of the platform"}
    return array


def label_dims(ds: xr.Dataset, name: str) -> list[str]:
    """Return the dimensions of a variable that are not swept: components, sources, actuators, wrenches, …."""
    return [str(dim) for dim in ds[name].dims if dim not in swept(ds)]


def units_of(ds: xr.Dataset, name: str) -> xr.DataArray:
    """Return the units of a variable: one text, or an array over its labels if their units differ."""
    attributes = ds[name].attrs
    where = attributes.get("unit_coordinate")
    if where is not None and set(ds[where].dims) <= set(ds[name].dims):
        return ds[where].drop_vars([coord for coord in ds[where].coords if coord not in ds[where].dims])
    return xr.DataArray(str(attributes.get("units", "1")))


def labelled(variable: xr.DataArray, dim: str, label: str) -> xr.DataArray:
    labels = [str(text) for text in variable[dim].values]
    if label not in labels:
        raise ArgumentError(f"no {dim} {label!r}: {near_names(label, labels)}")
    return variable.isel({dim: labels.index(label)})


def at_point(ds: xr.Dataset, tool: Sequence[float]) -> xr.Dataset:
    """Return a map with twists, stiffness and compliance at another point of the platform, such as a tool's tip, instead of o.

    Its indices and figures refer to this point: ``quantity(at_point(ds, (0, 0, 0.2)), "linear_sag")`` is the tip's displacement.

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
    orientation = json.loads(str(ds.attrs.get("arguments", "{}"))).get("orientation")
    convention = orientation_named("tilt_torsion" if "tilt" in names else orientation)
    order = [*LINEAR, *ANGULAR]

    def arms(coordinates: Array) -> Array:
        angles = np.moveaxis(np.asarray(coordinates)[..., 3:], -1, 0)
        R = convention.matrix(angles.reshape(3, -1)).reshape(3, 3, *angles.shape[1:])
        return np.moveaxis(np.einsum("ij...,j->i...", R, place), 0, -1)

    def moved(array: Array, coordinates: Array, kind: Kind) -> Array:
        return move(kind, np.asarray(array), arms(coordinates), components_last=True)

    moved_arrays = {}
    for name, entry in ((name, entry) for name, entry in VARIABLES.items() if entry.moves_as and name in ds):
        dims = [dim for dim in entry.dims if dim.startswith("component")]
        array = ds[name].sel(dict.fromkeys(dims, order))
        new = xr.apply_ufunc(
            moved,
            array,
            pose,
            kwargs={"kind": entry.moves_as},
            input_core_dims=[dims, ["platform_coordinate"]],
            output_core_dims=[dims],
            dask="parallelized",
            output_dtypes=[float],
            dask_gufunc_kwargs={"allow_rechunk": True},
        )
        new.attrs = {**array.attrs, "long_name": f"{array.attrs.get('long_name', name)}; of a point of the platform instead of o"}
        moved_arrays[name] = new.transpose(*ds[name].dims)
    changed = ds.assign(moved_arrays)
    changed.attrs = {**ds.attrs, "point": place.tolist()}
    return changed
