"""Inputs, outputs and parameters of functions, as they are told to people."""

from __future__ import annotations

from dataclasses import dataclass

#: What every function takes besides coordinates, and returns besides what was asked for.
LOADS = ("load", "gravity")
ALWAYS = ("status", "residual")
#: Opening of a loop [m, rad] above which a pose of a function is not reached.
TOLERANCE = 1e-10


@dataclass(frozen=True)
class Quantity:
    """An input, an output or a parameter of a function.

    Attributes:
        name: its name.
        shape: without batch axes.
        units: one for all components, or one for each along the last axis.
        components: what each component along the last axis is, if they have names.
        meaning: in words: frame and reference point.
    """

    name: str
    shape: tuple[int, ...]
    units: tuple[str, ...]
    components: tuple[str, ...] = ()
    meaning: str = ""

    def __str__(self) -> str:
        units = ", ".join(dict.fromkeys(self.units))
        shape = f" {self.shape}" if self.shape else ""
        return f"{self.name}{shape} [{units}]" + (f": {self.meaning}" if self.meaning else "")
