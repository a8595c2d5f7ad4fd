"""Valid poses of a workspace map, and the arrays of its variables."""

from __future__ import annotations

import xarray as xr

from kinetostatics.exceptions import ArgumentError, near_names
from kinetostatics.quantities import VARIABLES
from kinetostatics.status import WITHOUT_NUMBERS, in_map

#: Components of twists.
LINEAR, ANGULAR = ("x", "y", "z"), ("rx", "ry", "rz")


def valid(ds: xr.Dataset, beyond_limits: bool = False) -> xr.DataArray:
    """Return the mask of valid poses, bool over the swept dimensions.

    Args:
        ds: the map, see :func:`kinetostatics.sweep`.
        beyond_limits: whether to include poses beyond joint limits; their results are correct, but the robot cannot reach them.

    Raises:
        ArgumentError: the Dataset is not a map.
    """
    numbers = ~variable(ds, "status").isin([int(item) for item in WITHOUT_NUMBERS])
    return numbers if beyond_limits else numbers & ~in_map(ds, "limit_exceeded")


def swept(ds: xr.Dataset) -> tuple[str, ...]:
    """Return the names of the swept dimensions."""
    return tuple(str(name) for name in variable(ds, "status").dims)


def variable(ds: xr.Dataset, name: str) -> xr.DataArray:
    """Return a variable.

    Raises:
        ArgumentError: the variable is missing: the Dataset is no map, or the variable was not among the outputs.
    """
    if isinstance(ds, xr.Dataset) and name in ds:
        return ds[name]
    if isinstance(ds, xr.Dataset) and "characteristic_length" in ds and name in VARIABLES:
        raise ArgumentError(absent(name))
    raise ArgumentError(f"this is not a Dataset of ks.sweep: it has no variable {name!r}")


def absent(name: str) -> str:
    """Return the message on a missing variable of a map."""
    group = VARIABLES[name].group
    if group == "modes":
        return f"the map has no {name!r}; sweep with modes=3, or as many as you need"
    return f"the map has no {name!r}; sweep with {(name if group in ('default', 'always') else group)!r} among the outputs"


def finished(ds: xr.Dataset, values: xr.DataArray, beyond_limits: bool, units: str, long_name: str) -> xr.DataArray:
    """Return an index, NaN at invalid poses, with its own attributes only."""
    found = values.where(valid(ds, beyond_limits)).transpose(*swept(ds))
    kept = {*swept(ds), *(name for name in ds.coords if ds[name].dims == ())}
    found = found.drop_vars([name for name in found.coords if name not in kept])
    is_about = "point" in ds.attrs and not any(word in long_name for word in ("the point", "actuator"))
    found.attrs = {"units": units, "long_name": long_name + is_about * " at a point of the platform"}
    return found


def label_dims(ds: xr.Dataset, name: str) -> list[str]:
    """Return the dimensions of a variable that are not swept: components, sources, actuators, wrenches, …."""
    return [str(dim) for dim in ds[name].dims if dim not in swept(ds)]


def units_of(ds: xr.Dataset, name: str) -> xr.DataArray:
    """Return the units of a variable, over those of its dimensions along which they differ."""
    attributes = ds[name].attrs
    where = attributes.get("unit_coordinate")
    if where is not None and set(ds[where].dims) <= set(ds[name].dims):
        return ds[where].drop_vars([coord for coord in ds[where].coords if coord not in ds[where].dims])
    return xr.DataArray(str(attributes.get("units", "1")))


def labelled(variable: xr.DataArray, dim: str, label: str) -> xr.DataArray:
    """Return the entry of an array at a label of a dimension.

    Raises:
        ArgumentError: the label is unknown; the message lists the known labels.
    """
    known = [str(item) for item in variable[dim].values]
    if label not in known:
        raise ArgumentError(f"no {dim} {label!r}: {near_names(label, known)}")
    return variable.isel({dim: known.index(label)})
