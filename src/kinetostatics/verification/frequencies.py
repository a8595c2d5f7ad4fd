"""Natural frequencies of a frame by OpenSeesPy: beams in several elements with consistent masses, extrapolated.

Rigid bodies and eccentric masses of beams are point masses on rigid arms. A penalty is the stiffness of joints in constrained
directions. The error of an eigenvalue is a series in even powers of the element length and in all powers of the inverse penalty;
the values of several meshes, and of several levels of the penalty, are extrapolated to zero. Free directions of joints have a
small stiffness, too: an eigenvalue proportional to it is taken as zero, an eigenvalue proportional to the penalty as infinite.
The scatter is the relative change of an extrapolated value if the finest mesh or the last level is omitted.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np

from kinetostatics.math.arrays import Array
from kinetostatics.verification.frame import FrameModel
from kinetostatics.verification.opensees import FrameUnits, frame_of, least_scatter, run, weights_at_zero
from kinetostatics.verification.worker import Frame

#: Elements per beam of each mesh, and smallest number of meshes.
MESHES, FEWEST = (3, 5, 7, 9, 13, 17), 4
#: A further mesh, or another stiffness of free directions, is used until the scatter is below this value.
SURE = 5e-6
#: Penalty of the first level, as a multiple of the largest stiffness, and number of levels; each further level doubles it.
PENALTY, LEVELS = 20.0, 4
#: Stiffnesses of free directions at the first level, in the order in which they are tried; each further level halves them.
REGULARIZATIONS = (1e-10, 1e-8, 1e-12, 1e-7, 1e-11, 1e-9)
#: An eigenvalue counts as proportional to a stiffness if doubling the stiffness multiplies the eigenvalue by more than this.
FOLLOWS = 1.5
#: A beam's mass counts as lying on the centre line if its distance, divided by the beam's length, is smaller than this.
BESIDE = 1e-9


@dataclass(frozen=True)
class Frequencies:
    """Natural frequencies of a frame.

    Attributes:
        values: (count,) lowest nonzero frequencies [Hz]; infinite if there are fewer.
        scatter: largest scatter of these values.
        zero: number of zero frequencies.
    """

    values: Array
    scatter: float
    zero: int


def frequencies(model: FrameModel, count: int) -> Frequencies:
    """Return the lowest ``count`` nonzero natural frequencies of a frame.

    Raises:
        OpenSeesError: OpenSeesPy is missing, cannot be loaded, or failed.
    """
    scale = FrameUnits(model)
    total = sum(body.mass for body in model.masses) + sum(beam.mass * beam.length for beam in model.beams)
    eigenvalues: list[Array] = []
    best: Frequencies | None = None
    for elements in MESHES if model.beams else MESHES[:1]:
        mesh = frame_with_masses(model, scale, total, elements)
        if not eigenvalues:
            regularization, free, levels = least_scatter(REGULARIZATIONS, SURE, partial(_without_zeros, mesh, count))
            # with the smallest stiffness, the zeros are below the eigenvalues of a heavy platform, too
            zero = max(free, _without_zeros(mesh, count, min(REGULARIZATIONS))[1][1])
        else:
            levels = _at_levels(mesh, regularization, free + count)[:, free:]
        eigenvalues.append(levels)
        if len(eigenvalues) < (FEWEST if model.beams else 1):
            continue
        values = _limit(eigenvalues)
        less = _limit([levels[:-1] for levels in eigenvalues]), _limit(eigenvalues[:-1] or eigenvalues)
        scatter = max(relative_difference(estimate, values) for estimate in less)
        if best is None or scatter < best.scatter:
            best = Frequencies(values * np.sqrt(scale.stiffness / total) / (2 * np.pi), scatter, zero)
        if scatter < SURE:
            break
    assert best is not None
    return best


def _without_zeros(mesh: Frame, count: int, regularization: float) -> tuple[float, tuple[float, int, Array]]:
    """Compute the lowest nonzero eigenvalues of a mesh; ``regularization`` is the stiffness of free directions, at level 0.

    Returns:
        Their scatter; and a tuple: the given ``regularization``, the number of zeros, the eigenvalues (levels, count).
    """
    zeros, number = 0, count
    while True:
        levels = _at_levels(mesh, regularization, number)
        follows = np.all(levels[:-1] > FOLLOWS * levels[1:], axis=0)
        zeros = int(np.argmin(np.append(follows, False)))
        if zeros + count <= number:
            break
        number = 2 * zeros + count
    levels = levels[:, zeros : zeros + count]
    return relative_difference(_limit([levels[:-1]]), _limit([levels])), (regularization, zeros, levels)


def _at_levels(mesh: Frame, regularization: float, number: int) -> Array:
    """Return the ``number`` lowest eigenvalues (levels, number) in ascending order, infinite if there are fewer."""
    levels = run({**mesh, "modes": number}, [(PENALTY * 2**k, regularization / 2**k) for k in range(LEVELS)])
    eigenvalues = np.full((LEVELS, number), np.inf)
    for k, level in enumerate(levels):
        squares = np.sort(np.array(level["squares"][0]))
        eigenvalues[k, : len(squares)] = squares
    return eigenvalues


def _limit(meshes: list[Array]) -> Array:
    """Return the square roots (count,) of the extrapolated eigenvalues, from the eigenvalues (levels, count) of each mesh."""
    rigid = ~(meshes[0][1] < FOLLOWS * meshes[0][0])
    with np.errstate(invalid="ignore"):
        rows = [weights_at_zero(np.array([0.5**k for k in range(len(mesh))])) @ mesh for mesh in meshes]
        squares = weights_at_zero(1 / np.square(MESHES[: len(rows)], dtype=float)) @ np.array(rows)
    return np.sqrt(np.where(rigid, np.inf, np.maximum(squares, 0)))


def relative_difference(some: Array, other: Array) -> float:
    """Return the largest relative difference of positive numbers; two infinite numbers are equal."""
    compared = np.isfinite(some) | np.isfinite(other)
    with np.errstate(divide="ignore", invalid="ignore"):
        gaps = np.abs(some[compared] / other[compared] - 1)
    return float(gaps.max(initial=0.0)) if np.all(np.isfinite(gaps)) else float("inf")


# ---- masses ----------------------------------------------------------------------------------------------------------------


def frame_with_masses(model: FrameModel, scale: FrameUnits, total: float, elements: int) -> Frame:
    """Return the worker's input with masses, in units of the ``total`` mass."""
    frame = frame_of(model, scale, [], elements)
    supports = frame["fixed"]

    def put(node: int, point: Array, mass: float) -> None:
        """Add a point mass at ``point``, on a rigid arm of a node."""
        if mass and node not in supports:
            frame["ties"].append([node, len(frame["nodes"])])
            frame["masses"].append((len(frame["nodes"]), mass / total))
            frame["nodes"].append((point / scale.length).tolist())

    for body in model.masses:
        # pairs of masses on arms as long as the frame; the mass at their centre may be negative
        values, axes = np.linalg.eigh(np.trace(body.inertia) / 2 * np.eye(3) - body.inertia)
        around = values / (2 * scale.length**2)
        for mass, axis in zip(around, axes.T, strict=True):
            put(body.piece, body.centre + scale.length * axis, mass)
            put(body.piece, body.centre - scale.length * axis, mass)
        put(body.piece, body.centre, body.mass - 2 * float(np.sum(around)))
    for number, beam in enumerate(model.beams):
        beam_elements = frame["beams"][elements * number : elements * (number + 1)]
        if np.linalg.norm(beam.lever) < BESIDE * beam.length:
            for element in beam_elements:
                element["mass"] = beam.mass * scale.length / total
            continue
        EA, *_, EI_y, EI_z = beam.stiffness
        # equal masses at the ends of four arms have the rotary inertia of the section
        arms = beam.axes[:, 1] * np.sqrt(2 * EI_z / EA), beam.axes[:, 2] * np.sqrt(2 * EI_y / EA)
        path = [beam.pieces[0], *(element["nodes"][1] for element in beam_elements[:-1]), beam.pieces[1]]
        for k, (node, point) in enumerate(zip(path, beam.divided(elements), strict=True)):
            share = beam.mass * beam.length / elements * (0.5 if k in (0, elements) else 1.0)
            for arm in (*arms, *(-arm for arm in arms)):
                put(node, point + beam.lever + arm, share / 4)
    return frame
