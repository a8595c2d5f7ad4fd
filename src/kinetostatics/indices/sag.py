"""How far the platform moves and turns, and what the actuators must hold."""

from __future__ import annotations

from collections.abc import Sequence

import xarray as xr

from kinetostatics.exceptions import ArgumentError
from kinetostatics.indices.poses import ANGULAR, LINEAR, finished, labelled, swept, units_of, valid, variable


def linear_sag(ds: xr.Dataset, source: str | None = None, beyond_limits: bool = False) -> xr.DataArray:
    """Return how far o moves, the length |d| of the displacement [m].

    Args:
        ds: of :func:`kinetostatics.sweep`.
        source: "load", "platform_weight", "limb_1", …: what this contribution alone does; None: all together.
        beyond_limits: as in :func:`valid`.
    """
    return _sag(ds, LINEAR, source, beyond_limits, "m", "linear sag")


def angular_sag(ds: xr.Dataset, source: str | None = None, beyond_limits: bool = False) -> xr.DataArray:
    """Return by how much the platform turns, the length |r| of the rotation [rad]; arguments of :func:`linear_sag`."""
    return _sag(ds, ANGULAR, source, beyond_limits, "rad", "angular sag")


def remaining_linear_sag(ds: xr.Dataset, beyond_limits: bool = False) -> xr.DataArray:
    """Return how far o misses its place at the corrected actuators [m], in maps with the outputs "compensation".

    Args:
        ds: of :func:`kinetostatics.sweep`.
        beyond_limits: as in :func:`valid`.

    Raises:
        ArgumentError: the map has no corrections.
    """
    return _length(ds, _remaining(ds), LINEAR, beyond_limits, "m", "remaining linear sag")


def remaining_angular_sag(ds: xr.Dataset, beyond_limits: bool = False) -> xr.DataArray:
    """Return by how much the platform is turned at the corrected actuators [rad]; as :func:`remaining_linear_sag`."""
    return _length(ds, _remaining(ds), ANGULAR, beyond_limits, "rad", "remaining angular sag")


def _remaining(ds: xr.Dataset) -> xr.DataArray:
    if "twist" in ds and "residual_error" not in ds:
        raise ArgumentError("the map has no corrections; sweep with 'compensation' among the outputs")
    return variable(ds, "residual_error")


def _sag(
    ds: xr.Dataset, components: Sequence[str], source: str | None, beyond_limits: bool, units: str, name: str
) -> xr.DataArray:
    if source is None:
        twist = variable(ds, "twist")
    else:
        twist = labelled(variable(ds, "contribution"), "source", source)
        name = f"{name} by {source}"
    return _length(ds, twist, components, beyond_limits, units, name)


def _length(
    ds: xr.Dataset, twist: xr.DataArray, components: Sequence[str], beyond_limits: bool, units: str, name: str
) -> xr.DataArray:
    part = twist.sel(component=list(components))
    return finished(ds, (part**2).sum("component", skipna=False) ** 0.5, beyond_limits, units, name)


def largest_actuator_force(ds: xr.Dataset, beyond_limits: bool = False) -> xr.DataArray:
    """Return the largest magnitude of the actuators' forces at each pose [N, or N·m if all actuators turn].

    Raises:
        ArgumentError: some actuators push and others turn; then :func:`actuator_force_maxima` tells of each.
    """
    force = variable(ds, "actuator_force")
    units = {str(item) for item in units_of(ds, "actuator_force").values.ravel()}
    if len(units) > 1:
        raise ArgumentError("forces and torques of actuators cannot be compared; choose one actuator: actuator_force:NAME")
    unit = units.pop()
    kind = "force" if unit == "N" else "torque"
    return finished(ds, abs(force).max("actuator", skipna=False), beyond_limits, unit, f"largest actuator {kind}")


def actuator_force_maxima(ds: xr.Dataset, beyond_limits: bool = False) -> xr.DataArray:
    """Return the largest magnitude of each actuator's force over all poses (actuator,) [N or N·m: ``actuator_force_unit``]."""
    force = variable(ds, "actuator_force")
    found = abs(force.where(valid(ds, beyond_limits))).max(swept(ds))
    found.attrs = {**force.attrs, "long_name": "largest magnitude of the actuator's force over all poses"}
    return found
