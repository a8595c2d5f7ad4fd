"""Linear models of vibration for control: state-space form of the modes of one pose.

With modes φ_k of modal mass 1 kg and angular frequencies ω_k, displacements under forces f are y = Σ φ_k q_k + D f, with
q̈_k + c_k q̇_k + ω_k² q_k = φ_kᵀ f. The residual flexibility D = G − Σ φ_k φ_kᵀ/ω_k² stands for the modes that are left out; with
it, the static gain is the static flexibility G (D. J. Ewins, Modal Testing, 2nd ed., 2000, section 4.4).
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from kinetostatics.arguments import names_in, need, path_name
from kinetostatics.exceptions import ArgumentError, near_names
from kinetostatics.layout.report import as_json
from kinetostatics.math.arrays import Array, frozen
from kinetostatics.math.screws import COMPONENTS, TWIST_UNITS, WRENCH_COMPONENTS, WRENCH_UNITS
from kinetostatics.output_files import replacing
from kinetostatics.vibration.motions import Damping

#: Name of the platform's reference point among inputs and outputs, and beginning of the names of velocities.
PLATFORM, VELOCITY = "o", "velocity of "
#: Function of the names of an output and an input that returns displacements (6, 6) under unit forces.
Flexibility: TypeAlias = Callable[[str, str], Array]


@dataclass(frozen=True, eq=False)
class StateSpace:
    """State-space model ẋ = A x + B u, y = C x + D u; see :meth:`Modes.state_space`. SciPy takes ``StateSpace(A, B, C, D)``.

    Attributes:
        A, B, C, D: (2m, 2m), (2m, i), (o, 2m) and (o, i) matrices; the states are m modal coordinates [m·kg^½] and their rates.
        inputs, outputs: names of the components with their SI units, such as "fx of o [N]" and "rz of rod_1 [rad]".
    """

    A: Array
    B: Array
    C: Array
    D: Array
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]

    def to_control(self) -> Any:
        """Return a ``control.StateSpace`` with the names of inputs and outputs.

        Raises:
            KinetostaticsError: the package control is missing.
        """
        need("a model for python-control", "control", "control")
        import control  # type: ignore[import-untyped, unused-ignore]

        return control.StateSpace(self.A, self.B, self.C, self.D, inputs=list(self.inputs), outputs=list(self.outputs))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write matrices and names of inputs and outputs; an existing file is replaced.

        Args:
            path: name ending in ``.npz`` (NumPy), ``.mat`` (MATLAB, needs SciPy) or ``.json``.

        Raises:
            ArgumentError: the name has another ending, or the file cannot be written.
        """
        name, content = path_name("path", path), vars(self)
        if not name.endswith((".npz", ".mat", ".json")):
            raise ArgumentError(f"{name!r} does not end in .npz, .mat or .json")
        with replacing(name) as partial, open(partial, "wb") as file:
            if name.endswith(".npz"):
                np.savez(file, **content)
            elif name.endswith(".json"):
                file.write(json.dumps(as_json(content)).encode())
            else:
                need("a .mat file", "optimize", "scipy")
                from scipy.io import savemat

                savemat(file, {**content, **{key: np.array(content[key], dtype=object) for key in ("inputs", "outputs")}})


def state_space(
    frequencies: Array,
    twists: Mapping[str, Array],
    flexibility: Flexibility,
    inputs: Sequence[str],
    outputs: Sequence[str],
    damping: float | Mapping[str, float],
) -> StateSpace:
    """Return the model of m modes.

    Args:
        frequencies: (m,) natural frequencies [Hz]; modes that are not finite are left out.
        twists: (m, 6) twists of the modes, by name of the platform's point or link.
        flexibility: the static displacements.
        inputs, outputs, damping: see :meth:`Modes.state_space`.

    Raises:
        ArgumentError: an argument has an invalid value.
    """
    driven = names_in("inputs", inputs, '("o", "rod_1")')
    seen = names_in("outputs", outputs, '("o", "velocity of o")')
    places = [name.removeprefix(VELOCITY) for name in seen]
    for name in (*driven, *places):
        if name not in twists:
            raise ArgumentError(f"{name!r} is neither o nor a rigid link: {near_names(name, twists)}")
    finite = np.isfinite(frequencies)
    omega, loss = 2 * np.pi * frequencies[finite], Damping.of(damping)
    m, none = len(omega), np.zeros((len(omega), len(omega)))
    forces = np.concatenate([twists[name][finite].T for name in driven])
    A = np.block([[none, np.eye(m)], [-np.diag(omega**2), -np.diag(loss.loss * omega + loss.mass + loss.stiffness * omega**2)]])
    B = np.concatenate([np.zeros((m, len(forces))), forces.T])
    rows, residuals = [], []
    for name, place in zip(seen, places, strict=True):
        shapes, still = twists[place][finite].T, np.zeros((6, m))
        if name == place:
            static = np.concatenate([flexibility(place, by) for by in driven], axis=1)
            rows.append(np.concatenate([shapes, still], axis=1))
            residuals.append(static - (shapes / omega**2) @ forces.T)
        else:
            rows.append(np.concatenate([still, shapes], axis=1))
            residuals.append(np.zeros((6, len(forces))))
    matrices = A, B, np.concatenate(rows), np.concatenate(residuals)
    forcing, moving = zip(WRENCH_COMPONENTS, WRENCH_UNITS, strict=True), [*zip(COMPONENTS, TWIST_UNITS, strict=True)]
    components = [(component.lower(), unit) for component, unit in forcing]
    named = tuple(f"{component} of {name} [{unit}]" for name in driven for component, unit in components)
    shown = tuple(
        f"{component} of {name} [{unit}{'' if name == place else '/s'}]"
        for name, place in zip(seen, places, strict=True)
        for component, unit in moving
    )
    A, B, C, D = (frozen(np.asarray(matrix)) for matrix in matrices)
    return StateSpace(A, B, C, D, named, shown)
