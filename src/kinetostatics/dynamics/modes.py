"""Natural frequencies and modes of small vibrations about poses."""

from __future__ import annotations

import operator

from kinetostatics.description.loads import Payload
from kinetostatics.dynamics.vibrations import Vibrations
from kinetostatics.exceptions import ArgumentError
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.math.arrays import Index
from kinetostatics.math.threads import in_threads
from kinetostatics.results.modes import Modes
from kinetostatics.vibration.eigenpairs import eigenpairs
from kinetostatics.vibration.mode_shapes import ModeShapes

#: Number of poses in a chunk, the unit of work of a thread.
_AT_ONCE = 200


def modes(configuration: Configuration, count: int = 6, *, drives: str = "locked", payload: Payload | None = None) -> Modes:
    """Compute the lowest natural frequencies and modes of one pose or a batch of poses.

    Links are rigid bodies with inertia, beams are continuous Timoshenko rods with rotary inertia, elastic joints and actuators
    are springs. The dynamic stiffness of beams is exact, without discretization, and no mode is missed (see the page on natural
    frequencies). The geometric stiffness of loads and weights is neglected; that of spring tensions is included.

    Args:
        configuration: the pose or poses.
        count: number of modes.
        drives: "locked": coordinates of actuators are fixed, or elastic with their stiffness; "free": actuators exert no force.
        payload: a :class:`Payload` with its inertia.

    Returns:
        Frequencies, shapes, effective masses and shares of energy.

    Raises:
        ArgumentError: an argument has an invalid value.

    Examples:
        >>> import kinetostatics as ks
        >>> pose = ks.load_robot("3rps").assemble(platform={"z": 0.5, "rx": 0.0, "ry": 0.0})
        >>> m = ks.modes(pose, count=3)
        >>> [round(float(f), 1) for f in m.frequencies]  # [Hz]
        [131.5, 131.5, 224.5]
        >>> {name: round(float(part[2]), 2) for name, part in m.strain_energy_shares.items()}  # what to stiffen in mode 3
        {'beam rod_1': 0.33, 'beam rod_2': 0.33, 'beam rod_3': 0.33}
        >>> int(m.count_below(400.0))
        3
    """
    try:
        number = operator.index(count)
    except TypeError:
        number = 0
    if number < 1:
        raise ArgumentError(f"count is {count!r}; it must be a whole number, 1 or more")
    vibrations = Vibrations.of("modes", configuration, drives, payload)

    def solved(poses: Index) -> ModeShapes:
        motions, model = vibrations.placed(poses)
        return ModeShapes(eigenpairs(model, number), motions)

    return Modes(configuration, number, drives, payload, tuple(in_threads(solved, vibrations.chunks(_AT_ONCE))), vibrations.valid)
