"""Indices and other quantities of workspace maps by name; best and worst poses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from kinetostatics.exceptions import ArgumentError, near_names
from kinetostatics.indices.map_variables import ANGULAR, LINEAR, absent, finished, label_dims, labelled, units_of, variable
from kinetostatics.layout.blocks import Table
from kinetostatics.layout.renderings import block_html
from kinetostatics.math.linalg import EQUAL
from kinetostatics.math.screws import COMPONENTS
from kinetostatics.measures import MEASURES, Measure
from kinetostatics.quantities import QUANTITIES, VARIABLES
from kinetostatics.status import FACTS, Status, in_map
from kinetostatics.units import KINDS, find_unit, sized_example, sized_name, typed_number
from kinetostatics.units import unit as known_unit

#: Measures (formulas of indices) without argument, by name.
INDICES: Mapping[str, Measure] = {name: measure for name, measure in MEASURES.items() if measure.argument is None}
#: Measures with the magnitude of a force or moment as argument.
ANY_DIRECTION: Mapping[str, Measure] = {name: measure for name, measure in MEASURES.items() if measure.argument is not None}


def names(ds: xr.Dataset) -> list[str]:
    """Return all names that :func:`quantity` accepts for a map, except the 36 entries of stiffness and the 36 of compliance.

    An index that needs a force or moment is listed with an example of it: ``deflection_any_direction(500 N)``.
    """
    indices = [name for name in INDICES if _applies(ds, name)]
    accepted = [*indices, *map(_example, ANY_DIRECTION), *(f"stiffness_along:{axis}" for axis in (*LINEAR, *ANGULAR))]
    for name in map(str, ds.data_vars):
        dims = label_dims(ds, name)
        if dims and "component_2" not in dims:
            parts = [name]
            for dim in dims:
                parts = [f"{part}:{label}" for part in parts for label in ds[dim].values]
            accepted += parts
    return accepted


def _applies(ds: xr.Dataset, index: str) -> bool:
    """Whether an index suits a map: an optional variable must be in the map; actuator forces must have one common unit."""
    name = _variable(INDICES[index])
    return (name in ds or not name.startswith(("actuator", "residual", "frequency"))) and (
        name != "actuator_force" or len(set(units_of(ds, name).values.ravel())) == 1
    )


def _variable(measure: Measure) -> str:
    return next(entry.variable for path, entry in QUANTITIES.items() if path.rpartition(".")[2] == measure.of)


def variable_of(what: str) -> str:
    """Return the variable of a map from which :func:`quantity` computes a quantity."""
    name, size = sized_name(what)
    if name in INDICES or name in ANY_DIRECTION:
        return _variable(MEASURES[name]) if name in ANY_DIRECTION or size is None else "contribution"
    return {"stiffness_along": "compliance"}.get(name := what.partition(":")[0], name)


def quantity(ds: xr.Dataset, what: str, beyond_limits: bool = False) -> xr.DataArray:
    """Return an index, or one number of each pose, by its name.

    Args:
        ds: the map, see :func:`kinetostatics.sweep`.
        what: an index, such as "linear_sag", "linear_sag:limb_1" (the part by one contribution), "stiffness_along:z" or, with a
            force or moment, "deflection_any_direction(500 N)", "rotation_any_direction(20 N·m)"; a colon may replace the
            parentheses, and default units are N and N·m. Or a variable of the Dataset with its labels: "twist:rx",
            "contribution:limb_1:z", "gravity_mechanism:attached:z", "actuator_force:prismatic_1",
            "intensity:limb_1: force along …", "compliance:x:ry".
        beyond_limits: see :func:`valid`.

    Raises:
        ArgumentError: the quantity is unknown, or the map lacks its data; the message lists known names.
    """
    index, size = sized_name(what)
    if index in INDICES and (size is None or INDICES[index].of == "twist"):
        return _index(ds, INDICES[index], beyond_limits, source=size)
    if index in ANY_DIRECTION and size:
        return _index(ds, ANY_DIRECTION[index], beyond_limits, _amount(what, size, index))
    name, _, rest = what.partition(":")
    if name == "stiffness_along" and rest:
        return stiffness_along(ds, rest, beyond_limits=beyond_limits)
    if name not in ds.data_vars or name in ("status", "mode", "limited_by", *FACTS):
        raise ArgumentError(f"no quantity {what!r}{_hint(ds, what)}")
    array, dims = ds[name], label_dims(ds, name)
    labels = rest.rsplit(":", len(dims) - 1) if dims else ([rest] if rest else [])
    if len(labels) != len(dims) or not all(labels):
        form = ":".join([name, *(dim.upper() for dim in dims)])
        choices = "; ".join(f"{dim}s are {', '.join(map(str, ds[dim].values))}" for dim in dims if dim != "component_2")
        raise ArgumentError(f"{what!r} is not of the form {form}" + (f", where {choices}" if choices else ""))
    units = units_of(ds, name)
    for dim, label in zip(dims, labels, strict=True):
        array = labelled(array, dim, label)
        units = labelled(units, dim, label) if dim in units.dims else units
    return finished(ds, array, beyond_limits, str(units.values), _long_name(name, labels, str(units.values)))


def _index(ds: xr.Dataset, measure: Measure, beyond_limits: bool, size: float = 1.0, source: str | None = None) -> xr.DataArray:
    """Return a measure of every pose, lazily for a lazy map; ``size`` is a force or moment [SI], ``source`` a contribution."""
    if source is None:
        array = variable(ds, _variable(measure))
    else:
        array = labelled(variable(ds, "contribution"), "source", source)
    unit = measure.unit.replace("·", " ")
    about = {"who": "the point" if "point" in ds.attrs else "o", "size": f"{size:g}"}
    words = measure.words.format(**about) + (f" by {source}" if source is not None else "")
    if measure.of == "actuator_forces":
        units = {str(text) for text in units_of(ds, "actuator_force").values.ravel()}
        if len(units) > 1:
            raise ArgumentError("forces and torques of actuators cannot be compared; choose one actuator: actuator_force:NAME")
        unit = units.pop()
        words = words if unit == "N" else words.replace("force", "torque")
        dims = ["actuator"]
    elif measure.of in ("utilization", "frequencies"):
        dims = label_dims(ds, _variable(measure))
    else:
        components = list(COMPONENTS[measure.part])
        dims = [dim for dim in ("component", "component_2") if dim in array.dims]
        array = array.sel(dict.fromkeys(dims, components))
    arrays = (array, variable(ds, "characteristic_length")) if measure.is_homogeneous else (array,)
    computed = xr.apply_ufunc(
        lambda values, length=size: measure.function(values, length),
        *arrays,
        input_core_dims=[dims, []][: len(arrays)],
        dask="parallelized",
        output_dtypes=[float],
        dask_gufunc_kwargs={"allow_rechunk": True},
    )
    return finished(ds, computed, beyond_limits, unit, words)


def stiffness_along(
    ds: xr.Dataset, direction: str | Sequence[float] | xr.DataArray, rotation: bool = False, beyond_limits: bool = False
) -> xr.DataArray:
    """Return force per displacement along a direction u, with the platform otherwise free: 1/(uᵀ C_dd u) [N/m].

    Args:
        ds: the map, see :func:`kinetostatics.sweep`.
        direction: "x", "y", "z", or "rx", "ry", "rz" for moments about these axes; or a nonzero vector of three numbers in
            world axes; or a DataArray (…, component x y z) of vectors, which may differ from pose to pose.
        rotation: whether a vector is the axis of a moment; the result is then 1/(uᵀ C_rr u) [N·m/rad]. C_dd and C_rr are the
            blocks of the compliance for translations and for rotations.
        beyond_limits: see :func:`valid`.

    Raises:
        ArgumentError: the direction has an invalid value or shape.
    """
    rotation = direction in ANGULAR if isinstance(direction, str) else rotation
    unit, name = _direction(direction)
    components = list(ANGULAR if rotation else LINEAR)
    block = variable(ds, "compliance").sel(component=components, component_2=components)
    block = block.assign_coords(component=list(LINEAR), component_2=list(LINEAR))
    along = (block * unit * unit.rename(component="component_2")).sum(["component", "component_2"], skipna=False)
    kind = f"stiffness about {name.removeprefix('r')}" if rotation else f"stiffness along {name}"
    with np.errstate(divide="ignore"):  # infinite in rigid directions
        stiffness = 1 / along
    return finished(ds, stiffness, beyond_limits, "N m/rad" if rotation else "N/m", kind)


def _direction(direction: str | Sequence[float] | xr.DataArray) -> tuple[xr.DataArray, str]:
    """Return a unit vector (…, component) and the name of the direction."""
    if isinstance(direction, xr.DataArray):
        if "component" not in direction.dims or direction.sizes["component"] != 3:
            raise ArgumentError(f"direction has the dimensions {dict(direction.sizes)}; it needs 'component' with x, y, z")
        vector, name = direction.assign_coords(component=list(LINEAR)).astype(float), str(direction.name or "a direction")
    else:
        if isinstance(direction, str):
            if direction not in (*LINEAR, *ANGULAR):
                raise ArgumentError(f"no direction {direction!r}: {', '.join((*LINEAR, *ANGULAR))}, or three numbers")
            numbers, name = np.eye(3)[LINEAR.index(direction[-1])], direction
        else:
            numbers = np.asarray(direction, dtype=float)
            name = "(" + " ".join(f"{number:g}" for number in numbers.ravel()) + ")"
        if numbers.shape != (3,) or not np.all(np.isfinite(numbers)) or not np.any(numbers):
            raise ArgumentError(f"direction {direction!r} is not a vector of three numbers other than 0 0 0")
        vector = xr.DataArray(numbers, dims="component", coords={"component": list(LINEAR)})
    return vector / (vector**2).sum("component", skipna=False) ** 0.5, name


def _example(index: str) -> str:
    return sized_example(index, KINDS[str(ANY_DIRECTION[index].argument)])


def _amount(what: str, text: str, index: str) -> float:
    """Return a positive force or moment in SI, from a text with or without unit."""
    kind = str(ANY_DIRECTION[index].argument)
    typed = typed_number(text)
    unit = find_unit(typed[1]) if typed and typed[1] else known_unit(KINDS[kind])
    if typed is None or not typed[0] > 0 or unit is None or unit.dimension != known_unit(KINDS[kind]).dimension:
        raise ArgumentError(f"{what!r}: {text!r} is not a size in {KINDS[kind]}, such as {_example(index)}")
    return unit.in_si(typed[0])


def _hint(ds: xr.Dataset, what: str) -> str:
    """Return the end of the error message for an unknown quantity."""
    name = sized_name(what)[0]
    if name in ANY_DIRECTION:
        return f": write it with its size, {_example(name)}"
    if name in VARIABLES and name not in ds:
        return f": {absent(name)}"
    accepted = names(ds)
    within = [candidate for candidate in accepted if what.lower() in candidate.lower()][:3]
    if within:
        return ": did you mean " + " or ".join(repr(candidate) for candidate in within) + "?"
    return f": {near_names(what, accepted)}"


#: Names of mechanisms and contributions in figures.
_CONTRIBUTION_NAMES = {"platform_weight": "platform weight", "attached": "attached wrenches"}


def _long_name(name: str, labels: Sequence[str], units: str) -> str:
    last = labels[-1] if labels else ""
    entry = VARIABLES.get(name)
    if name == "uncorrected_error" or (entry is not None and entry.moves_as == "twist"):
        motion = f"rotation about {last[1:]}" if last in ANGULAR else f"displacement along {last}"
        if name in ("uncorrected_error", "residual_error"):
            return f"{motion}, uncorrected" if name == "uncorrected_error" else f"residual {motion}"
        return motion + ("" if name == "twist" else f" by {_CONTRIBUTION_NAMES.get(labels[0], labels[0])}")
    if entry is not None and entry.unit == "actuator_force_unit":
        by = "" if len(labels) == 1 else f" by {_CONTRIBUTION_NAMES.get(last, last)}"
        return f"{'force' if units == 'N' else 'torque'} of {labels[0]}{by}"
    if name == "actuator_correction":
        return f"correction of {last}"
    return " ".join([name.replace("_", " "), *labels])


# ---- best and worst --------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Extreme:
    """The pose at which a quantity is best or worst.

    Attributes:
        what: name of the quantity.
        value: value of the quantity at this pose, with its sign.
        units: units of the value.
        coordinates: the swept coordinates of the pose [m, rad].
        index: index of the pose along each swept dimension.
        status: :class:`kinetostatics.Status` of the pose.
        facts: names of the facts that apply, such as "limit_exceeded".
        coordinate_units: units of the coordinates; empty if unknown.
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
        return block_html(Table.of_rows(("", ""), self._rows()))

    def _rows(self) -> list[tuple[str, str]]:
        """Return (name, value with unit) of the quantity and of each coordinate."""
        where = [(name, _written(value, self.coordinate_units.get(name, ""))) for name, value in self.coordinates.items()]
        return [(self.what, _written(self.value, "" if self.units == "1" else self.units)), *where]


def _written(value: object, units: str) -> str:
    number = f"{value:.6g}" if isinstance(value, float) else str(value)
    return f"{number} {units}".rstrip()


def best(ds: xr.Dataset, what: str, beyond_limits: bool = False) -> Extreme:
    """Return the pose of smallest sag or force, by magnitude, or of greatest stiffness or conditioning.

    Args:
        ds: the map, see :func:`kinetostatics.sweep`.
        what: see :func:`quantity`.
        beyond_limits: see :func:`valid`.

    Raises:
        ArgumentError: there is no such quantity, or no pose is valid.
    """
    return _extreme(ds, what, beyond_limits, best=True)


def worst(ds: xr.Dataset, what: str, beyond_limits: bool = False) -> Extreme:
    """Return the pose of largest sag or force, by magnitude, or of least stiffness or conditioning; see :func:`best`."""
    return _extreme(ds, what, beyond_limits, best=False)


def _extreme(ds: xr.Dataset, what: str, beyond_limits: bool, best: bool) -> Extreme:
    values = quantity(ds, what, beyond_limits)
    dims = [str(dim) for dim in values.dims]
    size = abs(values)
    large = (
        INDICES[what].better == "large"
        if what in INDICES
        else what.partition(":")[0] in ("stiffness_along", "stiffness", "frequency")
    )
    smallest = large != best
    # replaces NaN by the least favourable value; nanargmin fails with all-NaN chunks of dask
    size = size.fillna(np.inf) if smallest else size.fillna(-1.0)
    # the first of poses that are equal within rounding, as in symmetric robots
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
