"""Solution of a frame by OpenSeesPy, with joints by the penalty method, extrapolated to joints without compliance.

A joint is a spring: stiff in constrained directions (the penalty), with a very small stiffness in free directions (the
regularization), so that a strut free to spin about its own axis does not make the stiffness singular. Elastic directions are
further springs in series. Every result is a rational function of the inverse penalty h; it is computed at several h, the levels,
and extrapolated to h = 0 (Richardson's extrapolation). The scatter is the largest relative difference between the extrapolations
with and without the last level. The worker is the program that runs OpenSees.
"""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import TypeVar

import numpy as np

from kinetostatics.exceptions import KinetostaticsError
from kinetostatics.layout.mapping import ResultMapping, ShortRepr
from kinetostatics.math.arrays import Array, frozen
from kinetostatics.verification.frame import Coordinate, FrameBeam, FrameJoint, FrameModel
from kinetostatics.verification.worker import Answer, BeamInput, Frame, SpringInput

#: Penalty of the first level, as a multiple of the largest stiffness of a beam or spring; each further level doubles it.
PENALTY = 30.0
LEVELS = 7
#: Stiffnesses of free directions at the first level, tried until the scatter is below ``SURE``; each further level halves them.
#: Large values disturb robots near a singular pose, small values are lost in rounding.
REGULARIZATIONS = (1e-10, 1e-12, 1e-8, 1e-11, 1e-9)
SURE = 1e-9
#: Time limit of OpenSees [s].
PATIENCE = 300.0

Solved = TypeVar("Solved")


class OpenSeesError(KinetostaticsError):
    """OpenSeesPy is missing, cannot be loaded, or failed."""


class SingularFrame(OpenSeesError):
    """OpenSees found no solution."""


@dataclass(frozen=True, eq=False, repr=False)
class FrameSolution(ShortRepr):
    """Results of a frame, SI units and world axes.

    Attributes:
        twist: (6,) twist of the platform at o [m, rad].
        compliance: (6, 6) compliance at o, by six unit loads [m/N, m/(N·m), rad/N, rad/(N·m)].
        stiffness: (6, 6) inverse of the compliance; NaN if the compliance is singular.
        joint_wrenches: (6,) wrench of each joint's inner side on its outer side, about the joint's centre [N, N·m].
        beam_wrenches: (2, 6) section wrenches at the inner and at the outer end of each beam, about the section's centroid:
            the part towards the platform acts on the part towards the base [N, N·m].
        actuator_forces: force or torque of each actuated joint [N or N·m].
        rotating_actuators: names of the actuated joints that rotate.
    """

    twist: Array
    compliance: Array
    stiffness: Array
    joint_wrenches: Mapping[str, Array]
    beam_wrenches: Mapping[str, Array]
    actuator_forces: Mapping[str, float]
    rotating_actuators: frozenset[str]


def extrapolations(model: FrameModel, scale: FrameUnits, probes: Sequence[int]) -> tuple[dict[str, Array], dict[str, Array]]:
    """Solve a frame at all levels.

    Args:
        scale: units of the results.
        probes: pieces whose displacements are returned.

    Returns:
        Results of :func:`_level_results`, extrapolated from all levels; and extrapolated from all levels but the last, to
            estimate the accuracy.

    Raises:
        OpenSeesError: OpenSeesPy is missing, cannot be loaded, or failed.
    """
    frame = frame_of(model, scale, probes)
    h = np.array([0.5**level for level in range(LEVELS)])

    def solved(regularization: float) -> tuple[float, tuple[dict[str, Array], dict[str, Array]]]:
        levels = [_level_results(level) for level in run(frame, [(PENALTY / x, regularization * x) for x in h])]
        from_all, from_less = _extrapolated(levels, h), _extrapolated(levels[:-1], h[:-1])
        return _scatter(of_platform(from_all), of_platform(from_less)), (from_all, from_less)

    return least_scatter(REGULARIZATIONS, SURE, solved)


def least_scatter(regularizations: Iterable[float], sure: float, solved: Callable[[float], tuple[float, Solved]]) -> Solved:
    """Return the result of the first regularization whose scatter is below ``sure``; if there is none, of the least scatter.

    Args:
        regularizations: stiffnesses of free directions, in the order in which they are tried.
        sure: scatter below which a result is accepted at once.
        solved: function that returns scatter and result for a regularization.

    Raises:
        OpenSeesError: OpenSees found no solution for any regularization.
    """
    best: tuple[float, Solved] | None = None
    failure: OpenSeesError | None = None
    for regularization in regularizations:
        try:
            attempt = solved(regularization)
        except SingularFrame as error:  # the stiffness of free directions is lost in rounding
            failure = error
            continue
        best = attempt if best is None or attempt[0] < best[0] else best
        if best[0] < sure:
            break
    if best is None:
        raise failure or OpenSeesError("OpenSees was not run")
    return best[1]


# ---- scaling -------------------------------------------------------------------------------------------------------------


class FrameUnits:
    """Units of length [m], stiffness [N/m] and force [N] in which the numbers of the frame are of order one."""

    def __init__(self, model: FrameModel) -> None:
        self.length = model.size
        self.stiffness = model.stiffest
        unit = np.repeat([1.0, self.length], 3)
        forces = [float(np.abs(model.loads / unit).max(initial=0.0))]
        forces += [float(np.linalg.norm(beam.load / unit)) * beam.length for beam in model.beams]
        forces.append(self.stiffness * model.largest_assembly_error)
        self.force = max(forces) or 1.0

    @property
    def wrench(self) -> Array:
        return np.repeat([self.force, self.force * self.length], 3)

    @property
    def twist(self) -> Array:
        return np.repeat([self.force / self.stiffness, self.force / self.stiffness / self.length], 3)


def frame_of(model: FrameModel, scale: FrameUnits, probes: Sequence[int], elements: int = 1) -> Frame:
    """Return the worker's input, in units of ``scale``; the first nodes are the reference points of the pieces.

    Args:
        probes: pieces whose displacements are returned.
    """
    nodes: list[list[float]] = []
    fixed: list[int] = []
    ties: list[list[int]] = []

    def node(point: Array) -> int:
        nodes.append([float(value) for value in point / scale.length])
        return len(nodes) - 1

    references = [node(point) for point in model.references]

    def attached(piece: int, point: Array) -> int:
        """Return a node at ``point``, rigidly attached to a piece."""
        if piece != model.base and np.array_equal(point, model.references[piece]):
            return references[piece]
        tag = node(point)
        if piece == model.base:  # a node must not be both fixed and tied
            fixed.append(tag)
        else:
            ties.append([references[piece], tag])
        return tag

    unit = scale.stiffness * np.repeat([1.0, scale.length**2], 3)
    springs: list[SpringInput] = []
    beams: list[BeamInput] = []
    for joint in model.joints:
        inner, outer = (attached(piece, joint.point) for piece in joint.pieces)
        rows = springs_in_series(joint)
        nodes_between = [inner, *(node(joint.point) for _ in rows[1:]), outer]
        for number, (axes, stiffness) in enumerate(rows):
            turn = np.kron(np.eye(2), axes)
            springs.append(
                {
                    "tag": len(springs) + 1,
                    "nodes": nodes_between[number : number + 2],
                    "stiffness": [None if np.isinf(value) else value for value in (stiffness / unit).tolist()],
                    "axes": axes[:, :2].T.ravel().tolist(),
                    # the first spring has the assembly error of the joint
                    "assembly_error": (turn.T @ (joint.assembly_error / scale.twist)).tolist() if number == 0 else [0.0] * 6,
                }
            )
    for beam in model.beams:
        first, last = (attached(piece, point) for piece, point in zip(beam.pieces, beam.points, strict=True))
        path = [first, *(node(point) for point in beam.divided(elements)[1:-1]), last]
        section = scale.stiffness * np.array([scale.length] * 3 + [scale.length**3] * 3)
        for ends in pairwise(path):
            beams.append(
                {
                    "tag": 1_000_000 + len(beams),
                    "nodes": [*ends],
                    "stiffness": (np.array(beam.stiffness) / section).tolist(),
                    "z": beam.axes[:, 2].tolist(),
                    "load": (beam.axes.T @ beam.load[:3] * scale.length / scale.force).tolist(),
                    "at_ends": (_at_ends(beam) / np.tile(scale.wrench, 2)).tolist(),
                    "mass": 0.0,
                }
            )
    fixed.append(references[model.base])
    pieces = [piece for piece, load in enumerate(model.loads) if piece != model.base and np.any(load)]
    loads = [(references[piece], (model.loads[piece] / scale.wrench).tolist()) for piece in pieces]
    return {
        "nodes": nodes,
        "fixed": fixed,
        "ties": ties,
        "springs": springs,
        "beams": beams,
        "loads": loads,
        "probes": [references[piece] for piece in probes],
        "masses": [],
        "modes": 0,
        "springs_at_level": [],
    }


def _at_ends(beam: FrameBeam) -> Array:
    """Return forces and moments (12,) on a beam's inner and outer end, equivalent to its uniform moment and its length error.

    For a clamped Timoshenko beam under a uniform transverse moment m, the forces are m/(1 + φ) along the transverse axis normal
    to m, with φ = 12 EI/(κGA L²). The length error is compensated by an axial force.
    """
    L, (EA, GA_y, GA_z, _, EI_y, EI_z) = beam.length, beam.stiffness
    x, y, z = beam.axes.T @ beam.load[3:]
    phi_y, phi_z = 12 * EI_z / (GA_y * L**2), 12 * EI_y / (GA_z * L**2)
    forces = np.array([EA / L * beam.length_error, z / (1 + phi_y), -y / (1 + phi_z)])
    moments = L / 2 * np.array([x, y * phi_z / (1 + phi_z), z * phi_y / (1 + phi_y)])
    return np.concatenate([beam.axes @ part for part in (-forces, moments, forces, moments)])


def springs_in_series(joint: FrameJoint) -> list[tuple[Array, Array]]:
    """Return axes (3, 3) and stiffness (6,) of each spring of a joint: infinite in constrained, zero in free directions."""
    blocks = (joint.axes, np.where(joint.blocked, np.inf, 0.0))
    springs = [(spring.axes, spring.stiffness) for spring in joint.springs]
    return springs if springs and np.all(joint.blocked) else [blocks, *springs]


def _level_results(level: Answer) -> dict[str, Array]:
    """Return the results of a level for p probes, in units of the scale.

    Returns:
        Displacements under the loads ("twist", (6p,)) and under unit loads ("compliance", (6p, 6p)); forces of springs
            ("springs", (n, 6)) and on the ends of beams ("beams", (n, 2, 6)).
    """
    moved = np.array(level["moved"])
    return {
        "twist": moved[0],
        "compliance": moved[1:].T,
        "springs": np.array(level["springs"]).reshape(-1, 6),
        "beams": np.array(level["beams"]).reshape(-1, 2, 6),
    }


# ---- extrapolation and forces --------------------------------------------------------------------------------------------


def weights_at_zero(h: Array) -> Array:
    """Return the weights (n,) with which values at ``h`` (n,) give the value at h = 0 of the polynomial through them."""
    return np.array([np.prod([other / (other - point) for other in h if other != point]) for point in h])


def _extrapolated(levels: list[dict[str, Array]], h: Array) -> dict[str, Array]:
    """Return each result at h = 0, by the polynomial through its values at ``h``."""
    weights = weights_at_zero(h).tolist()
    return {name: sum((w * level[name] for w, level in zip(weights, levels, strict=True)), np.zeros(())) for name in levels[0]}


def _scatter(some: Mapping[str, Array], other: Mapping[str, Array]) -> float:
    """Return the largest relative difference of two scaled results, with divisors of at least 1e-3."""
    gaps = [np.abs(some[key] - other[key]).max(initial=0.0) / max(np.abs(some[key]).max(initial=0.0), 1e-3) for key in some]
    return float(max(gaps)) if np.all(np.isfinite(gaps)) else float("inf")


def of_platform(raw: Mapping[str, Array]) -> dict[str, Array]:
    """Return the results with displacements of the platform, the first probe, only; other pieces may spin freely."""
    return {**raw, "twist": raw["twist"][:6], "compliance": raw["compliance"][:6, :6]}


def solution(model: FrameModel, scale: FrameUnits, raw: Mapping[str, Array]) -> FrameSolution:
    """Return extrapolated results in SI units."""
    wrenches: dict[str, Array] = {}
    row = 0
    for joint in model.joints:
        # a joint inside several telescopic beams transmits the sum of their wrenches
        wrenches[joint.name] = wrenches.get(joint.name, np.zeros(6)) + raw["springs"][row] * scale.wrench
        row += len(springs_in_series(joint))
    sections = {beam.name: raw["beams"][k] * scale.wrench * np.array([[-1.0], [1.0]]) for k, beam in enumerate(model.beams)}
    forces = {
        actuator.name: sum(factor * _force_along(part, wrenches) for factor, part in actuator.moves)
        for actuator in model.actuators
    }
    C = raw["compliance"] * scale.twist[:, None] / scale.wrench
    C = (C + C.T) / 2
    rotating_actuators = frozenset(actuator.name for actuator in model.actuators if actuator.rotates)
    return FrameSolution(
        frozen(raw["twist"] * scale.twist),
        frozen(C),
        frozen(inverse(C, model.length)),
        ResultMapping({name: frozen(wrench) for name, wrench in wrenches.items()}),
        ResultMapping({name: frozen(wrench) for name, wrench in sections.items()}),
        ResultMapping(forces),
        rotating_actuators,
    )


def inverse(compliance: Array, length: float) -> Array:
    """Return the stiffness (6, 6) of a compliance; NaN if the compliance is singular."""
    unit = np.outer(*[np.repeat([1.0, length], 3)] * 2)
    try:
        return np.asarray(np.linalg.inv(compliance * unit) * unit, dtype=np.float64)
    except np.linalg.LinAlgError:
        return np.full((6, 6), np.nan)


def _force_along(part: Coordinate, wrenches: Mapping[str, Array]) -> float:
    wrench = wrenches[part.joint]
    return float(part.axis @ (wrench[3:] if part.rotates else wrench[:3]))


# ---- process of OpenSees -------------------------------------------------------------------------------------------------


def run(frame: Frame, springs: list[tuple[float, float]]) -> list[Answer]:
    """Solve a frame by OpenSees in a separate process, once for each pair (penalty, regularization) of ``springs``."""
    if importlib.util.find_spec("openseespy") is None:
        raise OpenSeesError("the check by finite elements needs OpenSeesPy: pip install 'kinetostatics[verify]'")
    command = [sys.executable, str(Path(__file__).with_name("worker.py"))]
    try:
        done = subprocess.run(
            command,
            input=json.dumps({**frame, "springs_at_level": springs}),
            capture_output=True,
            text=True,
            timeout=PATIENCE,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise OpenSeesError(f"OpenSees did not finish within {PATIENCE:g} s") from None
    try:
        answer = json.loads(done.stdout)
    except ValueError:
        raise OpenSeesError(f"the process that runs OpenSees ended with exit code {done.returncode}") from None
    if "missing" in answer:
        raise OpenSeesError(
            f"OpenSeesPy is installed but cannot be loaded ({answer['missing']}); on Debian and Ubuntu the packages libblas3, "
            "liblapack3 and libgfortran5 may be missing"
        )
    if "singular" in answer:
        raise SingularFrame(f"OpenSees failed: {answer['singular']}")
    if "error" in answer:
        raise OpenSeesError(f"OpenSees failed: {answer['error']}")
    levels: list[Answer] = answer["levels"]
    return levels
