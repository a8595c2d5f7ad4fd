"""The limbs' axes as tables name them: y along a limb's first hinge, or x, as in the paper's PRU limbs. z is the same in both."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from kinetostatics.exceptions import ArgumentError, near_names
from kinetostatics.math.arrays import Array


def checked(hinge_axes: Mapping[str, str], limbs: Iterable[str]) -> Mapping[str, str]:
    """Return which axis of which limb lies along its first hinge, if that makes sense.

    Raises:
        ArgumentError: there is no such limb, or the axis is neither x nor y.
    """
    known = list(limbs)
    for limb, axis in hinge_axes.items():
        if limb not in known:
            raise ArgumentError(f"there is no limb {limb!r}: {near_names(limb, known)}")
        if axis not in ("x", "y"):
            raise ArgumentError(f"the axis of {limb} along its first hinge is {axis!r}; it must be 'x' or 'y'")
    return hinge_axes


def named(label: str, intensity: Array, axis: str) -> tuple[str, Array]:
    """Return a wrench's label and intensity with the limb's ``axis`` along its first hinge.

    With x along the hinge, y = z × x points against our x.
    """
    if axis == "y":
        return label, intensity
    if "limb x" in label:
        return label.replace("limb x", "limb y"), -intensity
    return label.replace("limb y", "limb x"), intensity
