"""Response of the platform to harmonic forces on it, and to harmonic motion of the floor, by the exact dynamic stiffness.

With the complex stiffness s K, s = 1 + iη or 1 + iωβ, and the complex mass c M, c = 1 − iα/ω, the robot's equation of motion is
s D(λ c/s) q = f: damping only makes λ complex.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetostatics.math.arrays import Array
from kinetostatics.vibration.eigenpairs import independent_motions
from kinetostatics.vibration.rods import Numbers
from kinetostatics.vibration.vibration_model import VibrationModel

#: Largest number of matrix entries, over poses and frequencies, that are solved at once.
_AT_ONCE = 4_000_000
#: Least ratio of the λ of clamped rods to the largest λ of the response, for convergence of their series.
_MARGIN = 1.2


@dataclass(frozen=True)
class Damping:
    """Damping: loss factor η, or proportional damping with factors α of the mass [1/s] and β of the stiffness [s]."""

    loss: float = 0.0
    mass: float = 0.0
    stiffness: float = 0.0

    def factors(self, omega: Array) -> tuple[Numbers, Numbers]:
        """Return the complex factors s of the stiffness and c of the mass at angular frequencies [1/s]."""
        return 1 + 1j * (self.loss + omega * self.stiffness), 1 - 1j * self.mass / omega


def responses(model: VibrationModel, platform: Array, carried: Array, omega: Array, damping: Damping) -> tuple[Numbers, Numbers]:
    """Return compliance and transmissibility (N, F, 6, 6) at a point of the platform.

    Args:
        model: the robot at N poses.
        platform: (N, 6, n) twist of the platform at the point per coordinate.
        carried: (N, 6, 6) twist of the platform at the point per translation and rotation of the floor about o.
        omega: (F,) angular frequencies [1/s].
        damping: damping of all parts.
    """
    while (divided := model.divided(_MARGIN * float(omega.max()) ** 2)) is not None:
        model = divided
    n = model.coordinates
    compliance, transmissibility = np.empty((2, model.poses, len(omega), 6, 6), dtype=complex)
    P = np.zeros((model.poses, 6, n))
    P[..., : platform.shape[2]] = platform
    for poses, basis in independent_motions(model):
        here, count = model.take(poses), max(1, _AT_ONCE // (n * n * len(poses) + 1))
        for first in range(0, len(omega), count):
            some = slice(first, first + count)
            s, c = damping.factors(np.broadcast_to(omega[some], (len(poses), len(omega[some]))))
            square = omega[some] ** 2 * c / s
            D, floor = here.dynamic_stiffness(square), here.forces_of_floor(square) / c[..., None, None]
            out = P[poses][:, None]
            if basis is not None:
                Z = basis[:, None]
                D, floor, out = np.swapaxes(Z, -1, -2) @ D @ Z, np.swapaxes(Z, -1, -2) @ floor, out @ Z
            forces = np.broadcast_to(np.swapaxes(out, -1, -2), (*D.shape[:2], D.shape[2], 6))
            moved = out @ np.linalg.solve(D, np.concatenate([forces, floor], axis=-1))
            compliance[poses, some] = moved[..., :6] / s[..., None, None]
            transmissibility[poses, some] = carried[poses][:, None] - moved[..., 6:]
    return compliance, transmissibility
