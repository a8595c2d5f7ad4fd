"""A straight elastic beam in beam axes, x from its clamped base end to its platform end: end compliance, sag under its own
weight, deflection line, and reactions if clamped at both ends. The section at s has the distance s [m] from the base end;
outboard of it is the part towards the platform end. A uniform load (6, …) is force and moment per length [N/m, N]; a linearly
varying load (12, …) has these six components at the base end, then at the platform end.

Wrenches ``[f; m]`` and twists ``[d; r]`` are about the platform end, unless a section is named. ``c`` are the six section
compliances 1/EA, 1/κGA_y, 1/κGA_z, 1/GJ, 1/EI_y, 1/EI_z. Arrays are ``(6, …)``, batch axes last; lengths (…) are in [m]. Source:
closed forms of a cantilever, e.g. S. P. Timoshenko, Strength of Materials, part I, with shear deformation added; the method page,
section 5.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from kinetostatics.math.arrays import Array, empty_for
from kinetostatics.math.linalg import solve_by_elimination

#: Points on −1 … 1 and weights that integrate polynomials up to degree 7 exactly.
_GAUSS = np.polynomial.legendre.leggauss(4)


def _six(*rows: Array | float) -> Array:
    """Return six components, broadcast against one another, as one array (6, …)."""
    arrays = [row for row in rows if isinstance(row, np.ndarray)]
    result = empty_for((6, *np.broadcast_shapes(*(row.shape for row in arrays))), *arrays)
    for k, row in enumerate(rows):
        result[k] = row
    return result


def end_displacement(c: Array, length: Array, wrench: Array) -> Array:
    """Return the twists (6, …) of the platform end under wrenches (6, …) [N, N·m] at this end.

    Across the axis, with the force f and the moment m in the sense of f: d = (L³/3EI + L/κGA) f + L²/2EI m and
    r = L²/2EI f + L/EI m; along the axis d = L/EA f and r = L/GJ m.
    """
    axial, shear_y, shear_z, twist, bend_y, bend_z = c
    fx, fy, fz, mx, my, mz = wrench
    L = length
    return _six(
        axial * L * fx,
        (bend_z * L**3 / 3 + shear_y * L) * fy + bend_z * L**2 / 2 * mz,
        (bend_y * L**3 / 3 + shear_z * L) * fz - bend_y * L**2 / 2 * my,
        twist * L * mx,
        bend_y * (L * my - L**2 / 2 * fz),
        bend_z * (L * mz + L**2 / 2 * fy),
    )


def sag(c: Array, length: Array, load: Array) -> Array:
    """Return the twists (6, …) of the platform end under a uniform load.

    Across the axis, with the force q and the moment u per length: d = (L⁴/8EI + L²/2κGA) q + L³/3EI u and
    r = L³/6EI q + L²/2EI u; along the axis d = L²/2EA q and r = L²/2GJ u.
    """
    axial, shear_y, shear_z, twist, bend_y, bend_z = c
    L = length
    qx, qy, qz, ux, uy, uz = load
    return _six(
        axial * L**2 / 2 * qx,
        (bend_z * L**4 / 8 + shear_y * L**2 / 2) * qy + bend_z * L**3 / 3 * uz,
        (bend_y * L**4 / 8 + shear_z * L**2 / 2) * qz - bend_y * L**3 / 3 * uy,
        twist * L**2 / 2 * ux,
        bend_y * (L**2 / 2 * uy - L**3 / 6 * qz),
        bend_z * (L**2 / 2 * uz + L**3 / 6 * qy),
    )


def bent_line(c: Array, length: Array, wrench: Array, load: Array, s: Array) -> Array:
    """Return the twists (6, …) of the section at s, about its centre, under a wrench at the platform end and a uniform load.

    They are ∫₀ˢ [γ + κ × (s − σ) e_x; κ] dσ, with the strains [γ; κ] = c w(σ) of sections, see :func:`section_wrench`.
    """
    axial, shear_y, shear_z, twist, bend_y, bend_z = c
    L = length
    fx, fy, fz, mx, my, mz = wrench
    qx, qy, qz, ux, uy, uz = load
    even = L * s - s**2 / 2  # ∫ of the load outboard
    point = s**2 * (3 * L - s) / 6
    spread = s**2 * (6 * L**2 - 4 * L * s + s**2) / 24
    slope = s**3 / 6 - L * s**2 / 2 + L**2 * s / 2
    return _six(
        axial * (fx * s + qx * even),
        bend_z * (fy * point + qy * spread + mz * s**2 / 2 + uz * point) + shear_y * (fy * s + qy * even),
        bend_y * (fz * point + qz * spread - my * s**2 / 2 - uy * point) + shear_z * (fz * s + qz * even),
        twist * (mx * s + ux * even),
        bend_y * (my * s - fz * even - qz * slope + uy * even),
        bend_z * (mz * s + fy * even + qy * slope + uz * even),
    )


def section_wrench(length: Array, wrench: Array, load: Array, s: Array) -> Array:
    """Return the wrenches w (6, …) of the outboard on the inboard part in the section at s, about its centre.

    The beam carries a wrench W at the platform end and a uniform load q: w(s) = X W + ∫_s^L X q dσ, X moving wrenches to s.
    """
    arm = length - s
    fx, fy, fz, mx, my, mz = wrench
    qx, qy, qz, ux, uy, uz = load
    return _six(
        fx + qx * arm,
        fy + qy * arm,
        fz + qz * arm,
        mx + ux * arm,
        my - fz * arm - qz * arm**2 / 2 + uy * arm,
        mz + fy * arm + qy * arm**2 / 2 + uz * arm,
    )


def strain_energy(c: Array, length: Array, section: Callable[[Array], Array]) -> Array:
    """Return the strain energy (…) [J], ∫ ½ wᵀ c w ds over the beam, by Gauss–Legendre quadrature (exact up to degree 7).

    ``section`` returns the section wrenches w (6, k, …) [N, N·m] at fractions (k,) of the length from the base end.
    """
    points, weights = _GAUSS
    w = section((1 + points) / 2)
    density = np.einsum("i...,ik...->k...", c, w * w)
    return np.asarray(np.einsum("k,k...->...", weights, density) * length / 4)


def of_arm(force: Array, arm: Array) -> Array:
    """Return the matrix (f·r) 1 − ½ (f rᵀ + r fᵀ) (3, 3, N) of the quadratic form −f · (θ × (θ × r)) of rotations θ."""
    product = arm[:, None] * force[None]
    return np.einsum("iin->n", product) * np.eye(3)[:, :, None] - (product + np.swapaxes(product, 0, 1)) / 2


def outboard_wrench(length: Array, load: Array, s: Array) -> Array:
    """Return the resultant (6, …) of the linearly varying load outboard of the section at ``s``, about the section's centre."""
    first, last, left = load[:6], load[6:], length - s
    here = first + (last - first) * (s / length)
    found = np.array((here + last) * left / 2)
    moment = (here[:3] / 6 + last[:3] / 3) * left**2  # e_x × ∫ (σ − s) q dσ
    found[4] -= moment[2]
    found[5] += moment[1]
    return found


def clamped_reaction(c: Array, length: Array, load: Array) -> Array:
    """Return the wrench −F⁻¹ u (6, …) of the clamp on the platform end of a beam clamped at both ends.

    u is the displacement of the free end under the linearly varying load, F the compliance of the end.
    """
    free = _displacement(c, length, load, np.zeros_like(load[:6]), length)
    units = np.broadcast_to(np.eye(6).reshape(6, 6, *(1,) * (load.ndim - 1)), (6, *free.shape))
    compliance = end_displacement(c[:, None], length, units).reshape(6, 6, -1)
    return -solve_by_elimination(compliance, free.reshape(6, 1, -1)).reshape(free.shape)


def clamped_line(c: Array, length: Array, load: Array, s: Array) -> Array:
    """Return the twists (6, …) of the section at ``s``, about its centre, of a beam clamped at both ends."""
    return _displacement(c, length, load, clamped_reaction(c, length, load), s)


def clamped_section_wrench(c: Array, length: Array, load: Array, s: Array) -> Array:
    """Return the section wrenches (6, …) at ``s`` of a beam clamped at both ends; see :func:`section_wrench`."""
    return _section(length, load, clamped_reaction(c, length, load), s)


def _section(length: Array, load: Array, reaction: Array, s: Array) -> Array:
    none = np.zeros((6, *(1,) * (load.ndim - 1)))
    return section_wrench(length, reaction, none, s) + outboard_wrench(length, load, s)


def _displacement(c: Array, length: Array, load: Array, reaction: Array, s: Array) -> Array:
    """Return the twists ∫₀ˢ [γ + κ × (s − σ) e_x; κ] dσ (6, …) of the section at s, by quadrature (exact to degree 4).

    [γ; κ] = c w are the strains of the section at σ. The beam is clamped at its base end, under a linearly varying load and a
    wrench ``reaction`` at the platform end.
    """
    found = np.zeros(np.broadcast_shapes(load[:6].shape, s.shape))
    for point, weight in zip(*_GAUSS, strict=True):
        place = s * (1 + point) / 2
        strain = c * _section(length, load, reaction, place) * (weight * s / 2)
        found += strain
        found[1] += (s - place) * strain[5]
        found[2] -= (s - place) * strain[4]
    return found
