"""Stiffness of poses, translations and rotations apart, and how far they are from singular ones."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import xarray as xr

from kinetostatics.argument_checks import positive
from kinetostatics.exceptions import ArgumentError
from kinetostatics.indices.poses import ANGULAR, LINEAR, finished, variable
from kinetostatics.indices.tool_point import at_point
from kinetostatics.math.arrays import Array


def translational_stiffness(
    ds: xr.Dataset, extreme: str = "least", held: bool = False, beyond_limits: bool = False
) -> xr.DataArray:
    """Return the least or greatest stiffness against forces at o over all directions of the force or displacement [N/m].

    Args:
        ds: of :func:`kinetostatics.sweep`.
        extreme: "least" or "greatest".
        held: False: |f|/|d| under a pure force, the platform free to turn: 1/eigenvalue of ``C_dd``. True: |f|/|d| of a pure
            displacement, kept from turning: eigenvalue of ``K_dd``, NaN where rigid limbs make ``K`` infinite.
        beyond_limits: as in :func:`valid`.
    """
    return _extreme_stiffness(ds, LINEAR, extreme, held, beyond_limits, "N/m", "translational")


def rotational_stiffness(ds: xr.Dataset, extreme: str = "least", held: bool = False, beyond_limits: bool = False) -> xr.DataArray:
    """Return the least or greatest stiffness against moments over all directions [N·m/rad].

    Args:
        ds: of :func:`kinetostatics.sweep`.
        extreme: "least" or "greatest".
        held: False: |m|/|r| under a pure moment, o free to move: 1/eigenvalue of ``C_rr``. True: |m|/|r| of a pure rotation
            about o, which stays where it is: eigenvalue of ``K_rr``, NaN where rigid limbs make ``K`` infinite.
        beyond_limits: as in :func:`valid`.
    """
    return _extreme_stiffness(ds, ANGULAR, extreme, held, beyond_limits, "N m/rad", "rotational")


def _extreme_stiffness(
    ds: xr.Dataset, components: Sequence[str], extreme: str, held: bool, beyond_limits: bool, units: str, kind: str
) -> xr.DataArray:
    if extreme not in ("least", "greatest"):
        raise ArgumentError(f"extreme={extreme!r}: 'least' or 'greatest' is possible")
    block = _block(variable(ds, "stiffness" if held else "compliance"), components)
    # the least stiffness belongs to the largest compliance
    largest = (extreme == "greatest") == held
    found = _per_pose(_largest if largest else _smallest, block)
    other = "translations" if kind == "rotational" else "rotations"
    name = f"{extreme} {kind} stiffness, {other} {'held' if held else 'free'}"
    return finished(ds, found if held else _inverse(found), beyond_limits, units, name)


def stiffness_along(
    ds: xr.Dataset, direction: str | Sequence[float] | xr.DataArray, rotation: bool = False, beyond_limits: bool = False
) -> xr.DataArray:
    """Return force per displacement along one direction u, the platform otherwise free: 1/(uᵀ C_dd u) [N/m].

    Args:
        ds: of :func:`kinetostatics.sweep`.
        direction: "x", "y", "z", or "rx", "ry", "rz" for moments about these axes; or a vector of three numbers in world axes,
            of any length but 0, which as a DataArray (…, component x y z) may differ from pose to pose.
        rotation: a vector is the axis of a moment; then it is 1/(uᵀ C_rr u) [N·m/rad].
        beyond_limits: as in :func:`valid`.

    Raises:
        ArgumentError: the direction is invalid.
    """
    named = isinstance(direction, str)
    unit, name = _direction(direction)
    if isinstance(direction, str):
        rotation = direction in ANGULAR
    block = _block(variable(ds, "compliance"), ANGULAR if rotation else LINEAR)
    block = block.assign_coords(component=list(LINEAR), component_2=list(LINEAR))
    along = (block * unit * unit.rename(component="component_2")).sum(["component", "component_2"], skipna=False)
    kind = f"stiffness about {name[1:] if named else name}" if rotation else f"stiffness along {name}"
    return finished(ds, _inverse(along), beyond_limits, "N m/rad" if rotation else "N/m", kind)


def deflection_any_direction(
    ds: xr.Dataset, force: float = 1.0, tool: Sequence[float] | None = None, beyond_limits: bool = False
) -> xr.DataArray:
    """Return the largest displacement under a force of given size from any direction, the platform free to turn [m].

    The force times the largest eigenvalue of ``C_dd`` at the point where it acts, whose displacement is told.

    Args:
        ds: of :func:`kinetostatics.sweep`.
        force: [N].
        tool: (3,) a point of the platform, such as a tool's tip, from o in the platform's axes [m]; default: o.
        beyond_limits: as in :func:`valid`.

    Raises:
        ArgumentError: the force is not positive, or the point is none.
    """
    size = positive("force", force, "a force [N] greater than zero")
    if tool is not None:
        ds = at_point(
            ds.drop_vars(["twist", "contribution", "gravity_mechanism", "residual_error", "stiffness"], errors="ignore"), tool
        )
    block = _block(variable(ds, "compliance"), LINEAR)
    where = "the point" if "point" in ds.attrs else "o"
    found = size * _per_pose(_largest, block)
    return finished(ds, found, beyond_limits, "m", f"largest displacement of {where} under {size:g} N from any direction")


def rotation_any_direction(ds: xr.Dataset, moment: float = 1.0, beyond_limits: bool = False) -> xr.DataArray:
    """Return the largest rotation of the platform under a moment of given size about any axis, o free to move [rad].

    The moment times the largest eigenvalue of ``C_rr``, the same at all points of the platform.

    Args:
        ds: of :func:`kinetostatics.sweep`.
        moment: [N·m].
        beyond_limits: as in :func:`valid`.

    Raises:
        ArgumentError: the moment is not positive.
    """
    size = positive("moment", moment, "a moment [N·m] greater than zero")
    found = size * _per_pose(_largest, _block(variable(ds, "compliance"), ANGULAR))
    return finished(ds, found, beyond_limits, "rad", f"largest rotation under {size:g} N·m about any axis")


def _direction(direction: str | Sequence[float] | xr.DataArray) -> tuple[xr.DataArray, str]:
    """Return a unit vector (…, component) and what to call it."""
    if isinstance(direction, str):
        if direction not in (*LINEAR, *ANGULAR):
            raise ArgumentError(f"no direction {direction!r}: {', '.join((*LINEAR, *ANGULAR))}, or three numbers")
        vector = xr.DataArray(np.eye(3)[LINEAR.index(direction[-1])], dims="component", coords={"component": list(LINEAR)})
        return vector, direction
    if isinstance(direction, xr.DataArray):
        if "component" not in direction.dims or direction.sizes["component"] != 3:
            raise ArgumentError(f"direction has the dimensions {dict(direction.sizes)}; it needs 'component' with x, y, z")
        vector = direction.assign_coords(component=list(LINEAR)).astype(float)
        name = str(direction.name or "a direction")
    else:
        numbers = np.asarray(direction, dtype=float)
        if numbers.shape != (3,) or not np.all(np.isfinite(numbers)) or not np.any(numbers):
            raise ArgumentError(f"direction {direction!r} is not a vector of three numbers other than 0 0 0")
        vector = xr.DataArray(numbers, dims="component", coords={"component": list(LINEAR)})
        name = "(" + " ".join(f"{number:g}" for number in numbers) + ")"
    return vector / (vector**2).sum("component", skipna=False) ** 0.5, name


def _block(matrix: xr.DataArray, components: Sequence[str]) -> xr.DataArray:
    return matrix.sel(component=list(components), component_2=list(components))


def _inverse(values: xr.DataArray) -> xr.DataArray:
    with np.errstate(divide="ignore"):
        return 1 / values  # type: ignore[no-any-return]  # a rigid direction is infinitely stiff


# ---- conditioning ----------------------------------------------------------------------------------------------------


def conditioning(ds: xr.Dataset, beyond_limits: bool = False) -> xr.DataArray:
    """Return how close the stiffness is to singular, from 0 (singular) to 1 (the same in all directions).

    The inverse condition number, smallest over largest eigenvalue, of the compliance made homogeneous by the characteristic
    length L: displacements are d and L r, forces f and m/L, so that all entries are m/N. It is the relative distance, in the
    spectral norm, of the homogeneous stiffness to the nearest singular matrix. For equally stiff limbs with one wrench each it
    is the square of Gosselin's and Angeles' conditioning of the Jacobian. 0 too if limbs are rigid in some directions.
    """
    low, high = _homogeneous(ds, _smallest), _homogeneous(ds, _largest)
    return finished(ds, low / high, beyond_limits, "1", "conditioning")


def singularity_distance(ds: xr.Dataset, beyond_limits: bool = False) -> xr.DataArray:
    """Return the distance of the homogeneous stiffness, as in :func:`conditioning`, to the nearest singular matrix [N/m].

    Its smallest eigenvalue: the least force per displacement over all directions in the six-dimensional space of d and L r. 0
    at a pose where the platform moves though the actuators are locked.
    """
    found = _inverse(_homogeneous(ds, _largest))
    return finished(ds, found, beyond_limits, "N/m", "distance to singularity")


def translational_conditioning(ds: xr.Dataset, beyond_limits: bool = False) -> xr.DataArray:
    """Return least over greatest translational stiffness, rotations free: 1 if the same in all directions, 0 if singular."""
    return _block_conditioning(ds, LINEAR, beyond_limits, "translational conditioning")


def rotational_conditioning(ds: xr.Dataset, beyond_limits: bool = False) -> xr.DataArray:
    """Return least over greatest rotational stiffness, translations free."""
    return _block_conditioning(ds, ANGULAR, beyond_limits, "rotational conditioning")


def _block_conditioning(ds: xr.Dataset, components: Sequence[str], beyond_limits: bool, name: str) -> xr.DataArray:
    block = _block(variable(ds, "compliance"), components)
    return finished(ds, _per_pose(_smallest, block) / _per_pose(_largest, block), beyond_limits, "1", name)


def _homogeneous(ds: xr.Dataset, function: Callable[[Array], Array]) -> xr.DataArray:
    C = variable(ds, "compliance").sel(component=[*LINEAR, *ANGULAR], component_2=[*LINEAR, *ANGULAR])
    length = variable(ds, "characteristic_length")
    scale = length.where(C["component"].isin(ANGULAR), 1.0)
    return _per_pose(function, C * scale * scale.rename(component="component_2"))


def _per_pose(function: Callable[[Array], Array], matrices: xr.DataArray) -> xr.DataArray:
    """Return a number for each matrix, lazily if the matrices are lazy."""
    return xr.apply_ufunc(
        function,
        matrices,
        input_core_dims=[["component", "component_2"]],
        dask="parallelized",
        output_dtypes=[float],
        dask_gufunc_kwargs={"allow_rechunk": True},
    )


def _eigenvalues(matrices: Array) -> Array:
    """Return the eigenvalues (…, n), ascending, of symmetric positive semidefinite matrices; NaN where one is not finite."""
    finite = np.all(np.isfinite(matrices), axis=(-2, -1))
    found = np.linalg.eigvalsh(np.where(finite[..., None, None], matrices, 0.0))
    # what rounding leaves of a zero
    found = np.where(found > 1e-14 * found[..., -1:], found, 0.0)
    return np.where(finite[..., None], found, np.nan)


def _smallest(matrices: Array) -> Array:
    return _eigenvalues(matrices)[..., 0]


def _largest(matrices: Array) -> Array:
    return _eigenvalues(matrices)[..., -1]
