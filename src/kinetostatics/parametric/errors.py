"""Assembly errors as numbers of a robot: ``JOINT.error.x`` … ``rz`` in the joint's own frame, ``BEAM.error.length``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kinetostatics.arguments import Keyword
from kinetostatics.math.arrays import Array
from kinetostatics.math.screws import COMPONENTS
from kinetostatics.robot import Robot


@dataclass(frozen=True)
class ErrorParameter:
    """An assembly error of a joint or beam of the unloaded robot.

    Attributes:
        name: ``PART.error.KIND``.
        part: the joint or beam.
        kind: "x" … "rz" of a joint, along and about the axes of its frame; "length" or "temperature" of a beam.
        unit: SI unit.
    """

    name: str
    part: str
    kind: str
    unit: str

    @property
    def value(self) -> float:
        """Value of the nominal robot: zero."""
        return 0.0


def errors_of(robot: Robot) -> dict[str, ErrorParameter]:
    """Return the errors of all joints and beams of the limbs, by name."""
    found = []
    for limb in robot.topology.limbs:
        for edge in limb.edges:
            if edge.joint is not None:
                found += [(edge.joint, kind, "rad" if k > 2 else "m") for k, kind in enumerate(COMPONENTS)]
            elif edge.beam is not None:
                found.append((edge.beam, "length", "m"))
                if robot.description.beams[edge.beam].thermal_expansion:
                    found.append((edge.beam, "temperature", "K"))
    every = (ErrorParameter(f"{part}.error.{kind}", part, kind, unit) for part, kind, unit in found)
    return {item.name: item for item in every}


def together(errors: Sequence[ErrorParameter], amounts: Array) -> dict[str, Keyword]:
    """Return errors of given amounts (errors, N) as the argument ``assembly_errors`` of :func:`kinetostatics.analyze`."""
    found: dict[str, Keyword] = {}
    for error, row in zip(errors, amounts, strict=True):
        if error.kind in COMPONENTS:
            own = found.setdefault(error.part, {"twist": np.zeros((amounts.shape[1], 6)), "frame": "joint"})
            own["twist"][:, COMPONENTS.index(error.kind)] = row
        else:
            found.setdefault(error.part, {})[error.kind] = row
    return found
