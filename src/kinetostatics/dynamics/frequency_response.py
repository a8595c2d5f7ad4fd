"""Response of the platform to harmonic forces and to harmonic motion of the floor."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.arguments import Keyword, finite_numbers
from kinetostatics.description.loads import Payload
from kinetostatics.dynamics.vibrations import Vibrations
from kinetostatics.exceptions import ArgumentError
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.math.arrays import Index
from kinetostatics.math.threads import in_threads
from kinetostatics.results.frequency_response import FrequencyResponse
from kinetostatics.results.tool_point import tool_on_robot
from kinetostatics.robot import robot_of
from kinetostatics.vibration.response import Damping, responses
from kinetostatics.vibration.rods import Numbers

#: Number of poses in a chunk.
_AT_ONCE = 50


def frequency_response(
    configuration: Configuration,
    frequencies: ArrayLike,
    *,
    damping: float | Mapping[str, float] = 0.02,
    tool: ArrayLike | None = None,
    drives: str = "locked",
    payload: Payload | None = None,
) -> FrequencyResponse:
    """Compute the response of the platform to harmonic forces on it, and to harmonic motion of the floor.

    The equations with the dynamic stiffness of the robot, whose beams are continuous rods, are solved at each frequency, without
    truncation to a set of modes.

    Args:
        configuration: the pose or poses.
        frequencies: (F,) frequencies [Hz].
        damping: damping ratio ζ of all modes, as a loss factor 2ζ of the stiffness; or proportional damping
            ``{"mass": α, "stiffness": β}`` [1/s, s] with α M + β K, of motions relative to the floor.
        tool: (3,) point of the platform for forces and displacements, from o in platform axes [m]; default: o.
        drives: "locked" or "free", see :func:`kinetostatics.modes`.
        payload: a :class:`Payload` with its inertia.

    Returns:
        Compliance and transmissibility, complex.

    Raises:
        ArgumentError: an argument has an invalid value.

    Examples:
        The first resonance of a tripod, 131.5 Hz, amplifies motions of the floor along x:

        >>> import kinetostatics as ks
        >>> pose = ks.load_robot("3rps").assemble(platform={"z": 0.5, "rx": 0.0, "ry": 0.0})
        >>> r = ks.frequency_response(pose, [1.0, 131.465, 400.0], damping=0.02)
        >>> [round(float(abs(h)), 2) for h in r.transmissibility[:, 0, 0]]
        [1.0, 31.9, 0.49]
    """
    omega = 2 * np.pi * np.ravel(finite_numbers("frequencies", frequencies))
    if not omega.size or np.any(omega <= 0):
        raise ArgumentError(f"frequencies is {frequencies!r}; it must be positive numbers [Hz]")
    losses = _damping(damping)
    vibrations = Vibrations.of("frequency_response", configuration, drives, payload)
    robot = robot_of(configuration)
    place, body = tool_on_robot(tool, robot), vibrations.structure.platform

    def solved(poses: Index) -> tuple[Numbers, Numbers]:
        motions, model = vibrations.placed(poses)
        R, o = robot.mechanism.platform_pose(motions.frames)
        point = o if place is None else o + np.einsum("ijn,j->in", R, place)
        return responses(model, *motions.at(body, point), omega, losses)

    parts = in_threads(solved, vibrations.chunks(_AT_ONCE))
    found = np.full((2, len(vibrations.valid), len(omega), 6, 6), np.nan, dtype=complex)
    if parts:
        found[:, vibrations.valid] = np.concatenate(parts, axis=1)
    compliance, transmissibility = found.reshape(2, *configuration.shape, len(omega), 6, 6)
    return FrequencyResponse(configuration, omega / (2 * np.pi), compliance, transmissibility, damping, drives, payload, place)


def _damping(damping: object) -> Damping:
    """Return the checked damping."""
    values: Mapping[str, Keyword] = damping if isinstance(damping, Mapping) else {"ratio": damping}
    known = {"mass", "stiffness"} if isinstance(damping, Mapping) else {"ratio"}
    good = set(values) <= known and all(isinstance(value, (int, float)) and value >= 0 for value in values.values())
    if not good:
        raise ArgumentError(
            f'damping is {damping!r}; it must be a damping ratio, such as 0.02, or {{"mass": α, "stiffness": β}} [1/s, s]'
        )
    return Damping(2 * values.get("ratio", 0.0), values.get("mass", 0.0), values.get("stiffness", 0.0))
