"""What small errors of joints and beams do, as people read it; :func:`kinetostatics.tolerances` finds it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.math.arrays import Array
from kinetostatics.printing.dispatch import Told


@dataclass(frozen=True)
class Tolerance:
    """The effect of one error.

    Attributes:
        name: the joint or beam.
        kind: ``joint`` or ``beam``.
        error: what is off: ``x``, ``y``, ``z``, ``rx``, ``ry``, ``rz`` of a joint, along and about the axes of its frame on the
            predecessor's side; ``length`` or ``temperature`` of a beam.
        amount: by how much [m, rad, K].
        twist: what it does to the platform: displacement of o, or of the tool's tip, and rotation, world axes [m, rad].
        displacement, rotation: their sizes [m, rad].
        force: the largest force that it locks into a joint [N], and ``at`` which one; 0 and "" where there is none.
        at: see ``force``.
        moment: the largest moment that it locks into a joint, about the joint's centre [N·m].
        actuator_forces: what it adds to the actuators [N, N·m].
    """

    name: str
    kind: str
    error: str
    amount: float
    twist: tuple[float, ...]
    displacement: float
    rotation: float
    force: float
    at: str
    moment: float
    actuator_forces: dict[str, float]


@dataclass(frozen=True, repr=False)
class Tolerances(Told):
    """The effects of all errors, the worst first.

    Attributes:
        configuration: the pose.
        rows: one for each error that has an effect.
        ranked_by: ``force``, ``displacement`` or ``rotation``.
        tool: (3,) the point of the platform whose displacement is told, from o in its axes [m]; None: o.
    """

    configuration: Configuration
    rows: tuple[Tolerance, ...]
    ranked_by: str
    tool: Array | None = None

    def __iter__(self) -> Iterator[Tolerance]:
        return iter(self.rows)

    def __len__(self) -> int:
        return len(self.rows)
