"""All indices by name, and any other number of a pose; the best and the worst pose."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
import xarray as xr

from kinetostatics.description.units import find_unit, sized_example, sized_name, typed_number
from kinetostatics.description.units import unit as known_unit
from kinetostatics.exceptions import ArgumentError, near_names
from kinetostatics.indices import sag, stiffness
from kinetostatics.indices.poses import ANGULAR, LINEAR, absent, finished, label_dims, labelled, units_of
from kinetostatics.layout.html import html_table
from kinetostatics.math.ordering import EQUAL
from kinetostatics.quantities import VARIABLES
from kinetostatics.status import FACTS, Status, in_map


@dataclass(frozen=True)
class Index:
    """An index by name.

    Attributes:
        function: of the Dataset and ``beyond_limits``.
        units: of its numbers.
        better: "small" or "large": which of its numbers are the good ones.
        definition: one line.
    """

    function: Callable[..., xr.DataArray]
    units: str
    better: str
    definition: str


def _stiffness_indices() -> dict[str, Index]:
    found = {}
    for kind, function, units, block, other in (
        ("translational", stiffness.translational_stiffness, "N/m", "dd", "rotations"),
        ("rotational", stiffness.rotational_stiffness, "N m/rad", "rr", "translations"),
    ):
        for extreme in ("least", "greatest"):
            for held in (False, True):
                name = f"{extreme}_{kind}_stiffness" + ("_held" if held else "")
                if held:
                    formula = f"{'smallest' if extreme == 'least' else 'largest'} eigenvalue of K_{block}, {other} held"
                else:
                    formula = f"1 / {'largest' if extreme == 'least' else 'smallest'} eigenvalue of C_{block}, {other} free"
                found[name] = Index(partial(function, extreme=extreme, held=held), units, "large", formula)
    return found


#: Every index that needs no argument, by name.
INDICES: Mapping[str, Index] = {
    "linear_sag": Index(sag.linear_sag, "m", "small", "|d|, displacement of o"),
    "angular_sag": Index(sag.angular_sag, "rad", "small", "|r|, rotation of the platform"),
    **_stiffness_indices(),
    "translational_conditioning": Index(
        stiffness.translational_conditioning, "1", "large", "smallest / largest eigenvalue of C_dd, 0 to 1"
    ),
    "rotational_conditioning": Index(
        stiffness.rotational_conditioning, "1", "large", "smallest / largest eigenvalue of C_rr, 0 to 1"
    ),
    "conditioning": Index(
        stiffness.conditioning,
        "1",
        "large",
        "smallest / largest eigenvalue of C made homogeneous by the characteristic length, 0 to 1",
    ),
    "singularity_distance": Index(
        stiffness.singularity_distance,
        "N/m",
        "large",
        "1 / largest eigenvalue of C made homogeneous by the characteristic length",
    ),
    "largest_actuator_force": Index(sag.largest_actuator_force, "N", "small", "largest magnitude of the actuators' forces"),
    "remaining_linear_sag": Index(sag.remaining_linear_sag, "m", "small", "|d| that remains at the corrected actuators"),
    "remaining_angular_sag": Index(sag.remaining_angular_sag, "rad", "small", "|r| that remains at the corrected actuators"),
}


#: What takes the size of a force or moment, and its unit.
ANY_DIRECTION: Mapping[str, tuple[Callable[..., xr.DataArray], str]] = {
    "deflection_any_direction": (stiffness.deflection_any_direction, "N"),
    "rotation_any_direction": (stiffness.rotation_any_direction, "N·m"),
}


def names(ds: xr.Dataset) -> list[str]:
    """Return everything that :func:`quantity` knows of a Dataset, but for the 36 entries each of stiffness and compliance.

    Those that take a force or moment have one of them as an example: ``deflection_any_direction(500 N)``.
    """
    indices = [name for name in INDICES if _applies(ds, name)]
    found = [*indices, *map(_example, ANY_DIRECTION), *(f"stiffness_along:{axis}" for axis in (*LINEAR, *ANGULAR))]
    for name in (str(item) for item in ds.data_vars):
        dims = label_dims(ds, name)
        if dims and "component_2" not in dims:
            parts = [name]
            for dim in dims:
                parts = [f"{part}:{label}" for part in parts for label in ds[dim].values]
            found += parts
    return found


def _applies(ds: xr.Dataset, index: str) -> bool:
    """Return whether an index exists for a Dataset: robots may have no actuators, or actuators that push and others that turn."""
    if index.startswith("remaining_"):
        return "residual_error" in ds
    if index != "largest_actuator_force":
        return True
    return "actuator_force" in ds and len(set(units_of(ds, "actuator_force").values.ravel())) == 1


def quantity(ds: xr.Dataset, what: str, beyond_limits: bool = False) -> xr.DataArray:
    """Return an index, or one number of each pose, by its name.

    Args:
        ds: of :func:`kinetostatics.sweep`.
        what: the name of an index ("linear_sag"), "stiffness_along:z", "deflection_any_direction(500 N)",
            "rotation_any_direction(20 N·m)", as in requirements of :func:`kinetostatics.optimize` (a colon does as well,
            "deflection_any_direction:500N"; without a unit in N and N·m), or a variable of the Dataset with its labels:
            "twist:rx", "contribution:limb_1:z", "gravity_mechanism:attached:z", "actuator_force:prismatic_1",
            "intensity:limb_1: force along …", "compliance:x:ry".
        beyond_limits: as in :func:`valid`.

    Raises:
        ArgumentError: there is no such thing; the message says what there is.
    """
    if what in INDICES:
        return INDICES[what].function(ds, beyond_limits=beyond_limits)
    name, _, rest = what.partition(":")
    if name == "stiffness_along" and rest:
        return stiffness.stiffness_along(ds, rest, beyond_limits=beyond_limits)
    index, size = sized_name(what)
    if index in ANY_DIRECTION and size:
        function, unit = ANY_DIRECTION[index]
        return function(ds, _amount(what, size, unit, index), beyond_limits=beyond_limits)
    if name not in ds.data_vars or name in ("status", "mode", *FACTS):
        raise ArgumentError(f"no quantity {what!r}{_hint(ds, what)}")
    found, dims = ds[name], label_dims(ds, name)
    labels = rest.rsplit(":", len(dims) - 1) if dims else ([rest] if rest else [])
    if len(labels) != len(dims) or not all(labels):
        form = ":".join([name, *(dim.upper() for dim in dims)])
        known = "; ".join(f"{dim}s are {', '.join(str(item) for item in ds[dim].values)}" for dim in dims if dim != "component_2")
        raise ArgumentError(f"{what!r} is not of the form {form}" + (f", where {known}" if known else ""))
    units = units_of(ds, name)
    for dim, label in zip(dims, labels, strict=True):
        found = labelled(found, dim, label)
        units = labelled(units, dim, label) if dim in units.dims else units
    return finished(ds, found, beyond_limits, str(units.values), _long_name(name, labels, str(units.values)))


def _example(index: str) -> str:
    """Return an index that takes a force or moment as people write it."""
    return sized_example(index, ANY_DIRECTION[index][1])


def _amount(what: str, text: str, unit: str, index: str) -> float:
    """Return a force or moment, which may carry a unit."""
    found = typed_number(text)
    own = find_unit(found[1]) if found and found[1] else known_unit(unit)
    if found is None or found[0] < 0 or own is None or own.dimension != known_unit(unit).dimension:
        raise ArgumentError(f"{what!r}: {text!r} is not a size in {unit}, such as {_example(index)}")
    return own.in_si(found[0])


def _hint(ds: xr.Dataset, what: str) -> str:
    """Return what may have been meant instead of a quantity that there is not."""
    name = sized_name(what)[0]
    if name in ANY_DIRECTION:
        return f": write it with its size, {_example(name)}"
    if name in VARIABLES and name not in ds:
        return f": {absent(name)}"
    known = names(ds)
    within = [item for item in known if what.lower() in item.lower()][:3]
    if within:
        return ": did you mean " + " or ".join(repr(item) for item in within) + "?"
    close = near_names(what, known)
    if close.startswith("did you mean"):
        return f": {close}"
    indices = ", ".join([*(item for item in INDICES if _applies(ds, item)), *map(_example, ANY_DIRECTION)])
    variables = ", ".join(str(item) for item in ds.data_vars if label_dims(ds, str(item)))
    return f": there are the indices {indices}, and numbers of {variables}"


#: What ways and contributions are called in figures.
_SAID = {"platform_weight": "platform weight", "attached": "attached wrenches"}


def _long_name(name: str, labels: Sequence[str], units: str) -> str:
    """Return what a number is, in few words."""
    last = labels[-1] if labels else ""
    entry = VARIABLES.get(name)
    if name == "uncorrected_error" or (entry is not None and entry.moves_as == "twist"):
        motion = f"rotation about {last[1:]}" if last in ANGULAR else f"displacement along {last}"
        if name in ("uncorrected_error", "residual_error"):
            return f"{motion}, uncorrected" if name == "uncorrected_error" else f"{motion} that remains"
        return motion + ("" if name == "twist" else f" by {_SAID.get(labels[0], labels[0])}")
    if entry is not None and entry.unit == "actuator_force_unit":
        by = "" if len(labels) == 1 else f" by {_SAID.get(last, last)}"
        return f"{'force' if units == 'N' else 'torque'} of {labels[0]}{by}"
    if name == "actuator_correction":
        return f"correction of {last}"
    return " ".join([name.replace("_", " "), *labels])


# ---- best and worst --------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Extreme:
    """The pose at which a quantity is best or worst.

    Attributes:
        what: the quantity.
        value: its value there, with its sign.
        units: of the value.
        coordinates: the swept coordinates of the pose [m, rad].
        index: its place along each swept dimension.
        status: :class:`kinetostatics.Status` of the pose, the worst of what is true of it.
        facts: names of all that is true of it, "limit_exceeded", ….
        coordinate_units: of the coordinates; empty where none is known.
    """

    what: str
    value: float
    units: str
    coordinates: Mapping[str, float]
    index: Mapping[str, int]
    status: Status
    coordinate_units: Mapping[str, str]
    facts: tuple[str, ...]

    def __str__(self) -> str:
        what, *where = (f"{name} = {value}" for name, value in self._rows())
        return f"{what} at {', '.join(where) or 'the only pose'}"

    def _repr_html_(self) -> str:
        return html_table("", ("", ""), self._rows())

    def _rows(self) -> list[tuple[str, str]]:
        """Return name and value of the quantity, then of the coordinates."""
        where = [(name, _written(value, self.coordinate_units.get(name, ""))) for name, value in self.coordinates.items()]
        return [(self.what, _written(self.value, "" if self.units == "1" else self.units)), *where]


def _written(value: object, units: str) -> str:
    number = f"{value:.6g}" if isinstance(value, float) else str(value)
    return f"{number} {units}".rstrip()


def best(ds: xr.Dataset, what: str, beyond_limits: bool = False) -> Extreme:
    """Return the best pose: smallest sag or force, by magnitude, greatest stiffness or conditioning.

    Args:
        ds: of :func:`kinetostatics.sweep`.
        what: as in :func:`quantity`.
        beyond_limits: as in :func:`valid`.

    Raises:
        ArgumentError: there is no such quantity, or no pose is valid.
    """
    return _extreme(ds, what, beyond_limits, best=True)


def worst(ds: xr.Dataset, what: str, beyond_limits: bool = False) -> Extreme:
    """Return the worst pose: largest sag or force, by magnitude, least stiffness or conditioning; as :func:`best`."""
    return _extreme(ds, what, beyond_limits, best=False)


def _extreme(ds: xr.Dataset, what: str, beyond_limits: bool, best: bool) -> Extreme:
    values = quantity(ds, what, beyond_limits)
    dims = [str(dim) for dim in values.dims]
    size = abs(values)
    large = INDICES[what].better == "large" if what in INDICES else what.partition(":")[0] in ("stiffness_along", "stiffness")
    smallest = large != best
    # a NaN must lose; all-NaN chunks of dask would raise in nanargmin
    size = size.fillna(np.inf) if smallest else size.fillna(-1.0)
    # of poses that are equal but for rounding, as those of a symmetric robot, the first
    extreme = size <= size.min() * (1 + EQUAL) if smallest else size >= size.max() * (1 - EQUAL)
    place = extreme.argmax(dims) if dims else {}
    index = {str(dim): int(where) for dim, where in place.items()}  # type: ignore[union-attr]
    value = float(values.isel(index))
    if np.isnan(value):
        raise ArgumentError(f"{what}: no pose of the map is valid" + ("" if beyond_limits else " and within the joints' limits"))
    return Extreme(
        what=what,
        value=value,
        units=str(values.attrs["units"]),
        coordinates={dim: ds[dim].values[k].item() for dim, k in index.items()},
        index=index,
        status=Status(int(ds["status"].isel(index))),
        coordinate_units={dim: str(ds[dim].attrs.get("units", "")) for dim in index},
        facts=tuple(name for name in FACTS if bool(in_map(ds, name).isel(index))),
    )
