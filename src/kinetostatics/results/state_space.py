"""Linear models of vibration for control: state-space form of the modes of one pose.

With modes φ_k of modal mass 1 kg and angular frequencies ω_k, displacements under forces f are y = Σ φ_k q_k + D f, with
q̈_k + c_k q̇_k + ω_k² q_k = φ_kᵀ f. The residual flexibility D = G − Σ φ_k φ_kᵀ/ω_k² stands for the modes that are left out; with
it, the static gain is the static flexibility G (D. J. Ewins, Modal Testing, 2nd ed., 2000, section 4.4). If the floor
accelerates, displacements are relative to it, and the forces are those of inertia on the robot that moves with the floor.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from kinetostatics.arguments import names_in, need, path_name
from kinetostatics.exceptions import ArgumentError, near_names
from kinetostatics.layout.report import as_json
from kinetostatics.math.arrays import Array, frozen
from kinetostatics.math.screws import COMPONENTS, TWIST_UNITS, WRENCH_COMPONENTS, WRENCH_UNITS
from kinetostatics.mechanism.joints import elastic_actuators
from kinetostatics.output_files import replacing
from kinetostatics.statics.small_motions import PlacedMotions
from kinetostatics.vibration.eigenpairs import static_displacements
from kinetostatics.vibration.motions import Damping, ModeShapes

#: Name of the platform's reference point among inputs and outputs, name of an input, and beginning of the names of velocities.
PLATFORM, FLOOR, VELOCITY = "o", "acceleration of floor", "velocity of "


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


@dataclass(frozen=True)
class _Place:
    """A point of the platform or of a link, or an actuator: displacements (k, n) per unit of each of the robot's n coordinates.

    ``forces``, ``moves``: names and units of the k components of forces and of displacements.
    """

    displacements: Array
    forces: tuple[Sequence[str], Sequence[str]] = (WRENCH_COMPONENTS, WRENCH_UNITS)
    moves: tuple[Sequence[str], Sequence[str]] = (COMPONENTS, TWIST_UNITS)


def names_of(name: str, components: Sequence[str], units: Sequence[str], per: str = "") -> list[str]:
    """Return the names of the components of an input or output, with units."""
    return [f"{component.lower()} of {name} [{unit}{per}]" for component, unit in zip(components, units, strict=True)]


def _places(motions: PlacedMotions) -> dict[str, _Place]:
    """Return o, the origins of the rigid links, and the elastic actuators, at one pose."""
    structure, mechanism = motions.structure, motions.structure.model.mechanism
    points = {PLATFORM: motions.moved(structure.platform, motions.o)}
    for body in structure.graph.bodies:
        for link in body.rigid_links:
            at, placement = mechanism.body_of[link]
            points[link] = motions.moved(body, motions.frames.point(at, placement[:3, 3]))
    places = {name: _Place(rows[..., 0]) for name, rows in points.items()}
    for joint in structure.joints:
        if (name := joint.connection.name) in elastic_actuators(mechanism) and name not in places:
            row, kind = np.zeros((1, motions.units.shape[1])), joint.connection.type
            row[0, joint.columns[0]] = joint.sign / (structure.model.length if kind.is_hinge else 1.0)
            places[name] = _Place(row, (["force"], [kind.force_unit]), (["displacement"], [kind.unit]))
    return places


def state_space(
    frequencies: Array, modes: ModeShapes, inputs: Sequence[str], outputs: Sequence[str], damping: float | Mapping[str, float]
) -> StateSpace:
    """Return the model of m modes at one pose.

    Args:
        frequencies: (m,) natural frequencies [Hz]; modes that are not finite are left out.
        modes: their shapes.
        inputs, outputs, damping: see :meth:`Modes.state_space`.

    Raises:
        ArgumentError: an argument has an invalid value.
    """
    driven = names_in("inputs", inputs, '("o", "rod_1")')
    seen = names_in("outputs", outputs, '("o", "velocity of o")')
    places = _places(modes.motions)
    for name in (*(name for name in driven if name != FLOOR), *(name.removeprefix(VELOCITY) for name in seen)):
        if name in modes.motions.structure.model.description.actuated and name not in places:
            raise ArgumentError(f"no force moves the rigid actuator {name!r}; <joint_stiffness drive=…> makes it elastic")
        if name not in places:
            raise ArgumentError(f"{name!r} is neither o nor a rigid link nor an elastic actuator: {near_names(name, places)}")
    finite, model, n = np.isfinite(frequencies), modes.pairs.model, modes.motions.units.shape[1]
    undivided = replace(model, beams={name: replace(rod, pieces=1) for name, rod in model.beams.items()})
    omega, loss, shapes = 2 * np.pi * frequencies[finite], Damping.of(damping), modes.pairs.shapes[0, finite, :n]
    m, on_modes, on_coordinates, names = len(omega), list[Array](), list[Array](), list[str]()
    for name in driven:
        if name == FLOOR:
            on_modes.append(-modes.participation[0, finite])
            on_coordinates.append(-undivided.floor_inertia[0])
            names += names_of(name, COMPONENTS, TWIST_UNITS, "/s²")
        else:
            forces = places[name].displacements.T
            on_modes.append(shapes @ forces)
            on_coordinates.append(np.pad(forces, ((0, undivided.coordinates - n), (0, 0))))
            names += names_of(name, *places[name].forces)
    B = np.concatenate(on_modes, axis=1)
    static = static_displacements(undivided, np.concatenate(on_coordinates, axis=1)[None])[0, :n]
    of_states, residuals, shown = list[Array](), list[Array](), list[str]()
    for name in seen:
        place, still = places[name.removeprefix(VELOCITY)], np.zeros_like
        moved, per = place.displacements @ shapes.T, "" if name in places else "/s"
        of_states.append(np.concatenate([still(moved), moved] if per else [moved, still(moved)], axis=1))
        residuals.append((place.displacements @ static - (moved / omega**2) @ B) * (not per))
        shown += names_of(name, *place.moves, per)
    rates = loss.loss * omega + loss.mass + loss.stiffness * omega**2
    A = np.block([[np.zeros((m, m)), np.eye(m)], [-np.diag(omega**2), -np.diag(rates)]])
    matrices = A, np.concatenate([np.zeros_like(B), B]), np.concatenate(of_states), np.concatenate(residuals)
    A, B, C, D = map(frozen, matrices)
    return StateSpace(A, B, C, D, tuple(names), tuple(shown))
