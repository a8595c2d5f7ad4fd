"""The yardstick of workspace maps: one pose as a frame that OpenSeesPy builds and solves, written to be fast.

The geometry comes from a pose that is assembled already, as plain numbers, before any clock runs: closing the loops is no part of
the yardstick. What OpenSees then does for a pose is ``wipe``, nodes, rigid links, one ``zeroLength`` element a joint, beams with
their own weights as ``beamUniform``, and linear analysis. Nothing is there that a fast model can do without: what is rigidly
joined is one piece with as few nodes as it has points, locked actuators are no elements, hinges that cross in a point are one
joint, joints hold by one penalty and are stiff only where they block.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

import kinetostatics as ks
from kinetostatics.load_case import LoadCase
from kinetostatics.math.arrays import Array
from kinetostatics.verification.frame import FrameJoint, FrameModel
from kinetostatics.verification.frame_model import build
from kinetostatics.verification.worker import load_opensees

#: Stiffness of blocked directions, as a multiple of the stiffest beam's or spring's; of free ones, where a strut may spin.
PENALTY, GROUND = 1e5, 1e-14
#: Points that are closer [m] are the same.
SAME = 1e-9
UNITS = tuple(tuple(float(row == column) for column in range(6)) for row in range(6))


@dataclass(frozen=True)
class Frame:
    """A pose as the arguments of OpenSees' commands, SI units and world axes.

    Attributes:
        nodes: tag and coordinates.
        fixed: tags of nodes of the base.
        links: retained and constrained node of every rigid link.
        materials: tag and stiffness of every spring's direction.
        joints: arguments of ``zeroLength`` elements.
        transformations, beams: arguments of beams.
        beam_loads: tag and ``beamUniform`` of every beam.
        loads: node and wrench of rigid pieces.
        limbs: for each limb the tags of its beams and its nodes.
        platform: node at o.
    """

    nodes: list[tuple[Any, ...]]
    fixed: list[int]
    links: list[tuple[int, int]]
    materials: list[tuple[int, float]]
    joints: list[tuple[Any, ...]]
    transformations: list[tuple[Any, ...]]
    beams: list[tuple[Any, ...]]
    beam_loads: dict[int, tuple[float, float, float]]
    loads: dict[int, tuple[float, ...]]
    limbs: list[tuple[list[int], list[int]]]
    platform: int


def frame_of(pose: ks.Configuration, load: Sequence[float] = (0, 0, 0, 0, 0, 0)) -> Frame:
    """Return the frame of a single pose under gravity and a load at o."""
    model = _lean(build(pose, LoadCase(load)))
    return _Numbers(model, GROUND if pose.robot.mobility.local else 0.0).frame


# ---- making it lean ------------------------------------------------------------------------------------------------------


def _lean(model: FrameModel) -> FrameModel:
    """Return the frame without joints that hold everything, and with crossing hinges in one."""
    for number, joint in enumerate(model.joints):
        if np.all(joint.blocked) and not joint.springs:
            return _lean(_without(model, number))
    ends = [piece for joint in model.joints for piece in joint.pieces] + [piece for beam in model.beams for piece in beam.pieces]
    count = Counter(ends)
    in_beams = {piece for beam in model.beams for piece in beam.pieces} | {model.base, model.platform}
    for piece, load in enumerate(model.loads):
        if piece in in_beams or count[piece] != 2 or np.any(load):
            continue
        pair = [joint for joint in model.joints if piece in joint.pieces]
        crossed = _crossed(pair[0], pair[1], piece) if len(pair) == 2 else None
        if crossed is not None:
            rest = tuple(joint for joint in model.joints if joint not in pair)
            return _lean(replace(model, joints=(*rest, crossed)))
    return model


def _without(model: FrameModel, number: int) -> FrameModel:
    """Return the frame with the two pieces of a joint made one."""
    gone, kept = model.joints[number].pieces
    if gone in (model.base, model.platform):
        gone, kept = kept, gone
    if gone == kept:
        return replace(model, joints=tuple(joint for k, joint in enumerate(model.joints) if k != number))
    if {gone, kept} == {model.base, model.platform}:
        raise ValueError("the platform does not move")
    loads = model.loads.copy()
    arm = model.references[gone] - model.references[kept]
    loads[kept] += np.append(loads[gone][:3], loads[gone][3:] + np.cross(arm, loads[gone][:3]))
    loads[gone] = 0

    def moved(pieces: tuple[int, int]) -> tuple[int, int]:
        first, second = (kept if piece == gone else piece for piece in pieces)
        return first, second

    joints = tuple(replace(joint, pieces=moved(joint.pieces)) for k, joint in enumerate(model.joints) if k != number)
    return replace(
        model, loads=loads, joints=joints, beams=tuple(replace(beam, pieces=moved(beam.pieces)) for beam in model.beams)
    )


def _crossed(first: FrameJoint, second: FrameJoint, between: int) -> FrameJoint | None:
    """Return two joints that only turn, in one point, as one; None if they are not such."""
    if np.linalg.norm(first.point - second.point) > SAME or first.springs or second.springs:
        return None
    if not (np.all(first.blocked[:3]) and np.all(second.blocked[:3])):
        return None
    free = np.hstack([first.axes[:, ~first.blocked[3:]], second.axes[:, ~second.blocked[3:]]])
    axes, values, _ = np.linalg.svd(free, full_matrices=True)
    rank = int(np.sum(values > 1e-6))
    outer = [next(piece for piece in joint.pieces if piece != between) for joint in (first, second)]
    blocked = np.ones(6, dtype=bool)
    blocked[3 : 3 + rank] = False
    axes = axes * np.array([1, 1, np.linalg.det(axes)])
    return replace(first, pieces=(outer[0], outer[1]), axes=axes, blocked=blocked)


class _Numbers:
    """Nodes and elements of a lean frame."""

    def __init__(self, model: FrameModel, ground: float) -> None:
        self.model, self.ground = model, ground
        self.stiffest = model.stiffest
        self.points: list[Array] = []
        self.of_piece: dict[int, list[int]] = {model.platform: [self._new(model.references[model.platform])], model.base: []}
        self.materials: dict[float, int] = {}
        joints = [item for joint in model.joints for item in self._joint(joint)]
        transformations, beams, loads, nodes = [], [], {}, {}
        for beam in model.beams:
            tag = len(transformations) + 1
            ends = [self._at(piece, point) for piece, point in zip(beam.pieces, beam.points, strict=True)]
            EA, GAy, GAz, GJ, EIy, EIz = beam.stiffness
            transformations.append(("Linear", tag, *beam.axes[:, 2].tolist()))
            beams.append(("ElasticTimoshenkoBeam", tag, *ends, 1.0, 1.0, EA, GJ, EIy, EIz, GAy, GAz, tag))
            x, y, z = (beam.axes.T @ beam.load[:3]).tolist()
            loads[tag], nodes[tag] = (y, z, x), ends
        self.frame = Frame(
            [(tag, *point.tolist()) for tag, point in enumerate(self.points, 1)],
            self.of_piece[model.base],
            [(own[0], other) for piece, own in self.of_piece.items() if piece != model.base for other in own[1:]],
            [(tag, stiffness) for stiffness, tag in self.materials.items()],
            joints,
            transformations,
            beams,
            loads,
            self._loads(),
            self._limbs(nodes),
            self.of_piece[model.platform][0],
        )

    def _new(self, point: Array) -> int:
        self.points.append(point)
        return len(self.points)

    def _at(self, piece: int, point: Array) -> int:
        """Return the node of a piece at a point."""
        own = self.of_piece.setdefault(piece, [])
        for tag in own:
            if np.linalg.norm(self.points[tag - 1] - point) < SAME:
                return tag
        own.append(self._new(point))
        return own[-1]

    def _material(self, stiffness: float) -> int:
        return self.materials.setdefault(stiffness, len(self.materials) + 1)

    def _joint(self, joint: FrameJoint) -> list[tuple[Any, ...]]:
        """Return the elements of a joint: what it blocks, and what is elastic in it, in series."""
        penalty = PENALTY * self.stiffest * np.repeat([1.0, self.model.length**2], 3)
        rows = [(joint.axes, np.where(joint.blocked, penalty, self.ground * penalty))]
        for spring in joint.springs:
            rows.append((spring.axes, np.where(np.isfinite(spring.stiffness), spring.stiffness, penalty)))
        if len(rows) > 1 and np.all(joint.blocked):
            del rows[0]
        nodes = [self._at(joint.pieces[0], joint.point)]
        nodes += [self._new(joint.point) for _ in rows[1:]]
        nodes.append(self._at(joint.pieces[1], joint.point))
        found = []
        for (axes, stiffness), ends in zip(rows, pairwise(nodes), strict=True):
            directions = [k for k in range(6) if stiffness[k] > 0]
            if not directions:
                continue
            materials = [self._material(float(stiffness[k])) for k in directions]
            self.elements = getattr(self, "elements", 10_000) + 1
            orientation = (*axes[:, 0].tolist(), *axes[:, 1].tolist())
            mine = ("-mat", *materials, "-dir", *(k + 1 for k in directions), "-orient", *orientation)
            found.append(("zeroLength", self.elements, *ends, *mine))
        return found

    def _loads(self) -> dict[int, tuple[float, ...]]:
        """Return wrenches on the first nodes of pieces."""
        found = {}
        for piece, load in enumerate(self.model.loads):
            if piece == self.model.base or not np.any(load) or piece not in self.of_piece:
                continue
            node = self.of_piece[piece][0]
            arm = self.model.references[piece] - self.points[node - 1]
            found[node] = (*load[:3].tolist(), *(load[3:] + np.cross(arm, load[:3])).tolist())
        return found

    def _limbs(self, ends: dict[int, list[int]]) -> list[tuple[list[int], list[int]]]:
        """Return the beams and nodes of the parts into which the frame falls without base and platform."""
        model, fixed = self.model, {self.model.base, self.model.platform}
        root = list(range(len(model.references) + len(model.beams)))

        def find(item: int) -> int:
            while root[item] != item:
                item = root[item]
            return item

        for number, beam in enumerate(model.beams):
            for piece in set(beam.pieces) - fixed:
                root[find(piece)] = find(len(model.references) + number)
        for joint in model.joints:
            if not fixed & set(joint.pieces):
                root[find(joint.pieces[0])] = find(joint.pieces[1])
        groups: dict[int, tuple[list[int], list[int]]] = {}
        for number in range(len(model.beams)):
            groups.setdefault(find(len(model.references) + number), ([], []))[0].append(number + 1)
        for piece, own in self.of_piece.items():
            if piece not in fixed and own:
                groups.setdefault(find(piece), ([], []))[1].append(own[0])
        return list(groups.values())


# ---- OpenSees ------------------------------------------------------------------------------------------------------------


class OpenSees:
    """OpenSees in this process."""

    def __init__(self) -> None:
        self.ops = load_opensees()

    def version(self) -> str:
        """Return the version of OpenSees."""
        return str(self.ops.version())

    def prepare(self, frame: Frame) -> None:
        """Build the frame, without loads."""
        ops = self.ops
        ops.wipe()
        ops.model("basic", "-ndm", 3, "-ndf", 6)
        for node in frame.nodes:
            ops.node(*node)
        for tag in frame.fixed:
            ops.fix(tag, 1, 1, 1, 1, 1, 1)
        for retained, constrained in frame.links:
            ops.rigidLink("beam", retained, constrained)
        for tag, stiffness in frame.materials:
            ops.uniaxialMaterial("Elastic", tag, stiffness)
        for joint in frame.joints:
            ops.element(*joint)
        for transformation in frame.transformations:
            ops.geomTransf(*transformation)
        for beam in frame.beams:
            ops.element(*beam)

    def settle(self, algorithm: Sequence[str]) -> None:
        """Say how to solve."""
        ops = self.ops
        ops.constraints("Transformation")
        ops.numberer("RCM")
        ops.system("ProfileSPD")
        ops.integrator("LoadControl", 1.0)
        ops.algorithm(*algorithm)
        ops.analysis("Static", "-noWarnings")

    def weigh(self, frame: Frame, beams: Sequence[int], nodes: Sequence[int]) -> None:
        """Put weights on the frame."""
        for tag in beams:
            self.ops.eleLoad("-ele", tag, "-type", "-beamUniform", *frame.beam_loads[tag])
        for node in nodes:
            if node in frame.loads:
                self.ops.load(node, *frame.loads[node])

    def forces(self, frame: Frame) -> list[Any]:
        """Return the forces of all joints and beams."""
        tags = [item[1] for item in (*frame.joints, *frame.beams)]
        return [self.ops.eleResponse(tag, "force") for tag in tags]

    def solve(self, frame: Frame) -> tuple[list[float], list[Any]]:
        """Return the platform's twist and the forces of joints and beams: one analysis under all loads."""
        ops = self.ops
        self.prepare(frame)
        ops.timeSeries("Constant", 1)
        ops.pattern("Plain", 1, 1)
        self.weigh(frame, list(frame.beam_loads), list(frame.loads))
        self.settle(["Linear"])
        if ops.analyze(1) != 0:
            raise RuntimeError("OpenSees could not solve the frame")
        return ops.nodeDisp(frame.platform), self.forces(frame)

    def solve_all(self, frame: Frame) -> tuple[list[float], list[list[float]], list[list[float]], list[Any]]:
        """Return twist, compliance, what each limb's weight does, and the forces of joints and beams under all loads.

        The matrix is factorised once; every case of loads is one more step of the same analysis, in which only its own pattern
        acts. The cases are all loads together, six unit loads at o, and the weight of each limb but the last, which is
        the rest, as are load and platform weight by the unit loads.
        """
        ops = self.ops
        self.prepare(frame)
        cases = 7 + max(len(frame.limbs) - 1, 0)
        for case in range(1, cases + 1):
            ops.timeSeries("Path", case, "-dt", 1.0, "-values", *([0.0] * case), 1.0, 0.0)
            ops.pattern("Plain", case, case)
            if case == 1:
                self.weigh(frame, list(frame.beam_loads), list(frame.loads))
            elif case < 8:
                ops.load(frame.platform, *UNITS[case - 2])
            else:
                self.weigh(frame, *frame.limbs[case - 8])
        self.settle(["Linear", "-factorOnce"])
        found = []
        forces: list[Any] = []
        for case in range(1, cases + 1):
            if ops.analyze(1) != 0:
                raise RuntimeError("OpenSees could not solve the frame")
            found.append(ops.nodeDisp(frame.platform))
            if case == 1:
                forces = self.forces(frame)
        return found[0], found[1:7], found[7:], forces
