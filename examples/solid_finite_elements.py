"""Check beam theory against solid finite elements: a robot's pose as a CalculiX model of round steel rods.

    python examples/solid_finite_elements.py                                    the paper's 3RPS, both configurations
    python examples/solid_finite_elements.py --elements fine --grip rigid       finer, one way of gripping only
    python examples/solid_finite_elements.py --robot my_robot.urdf --actuators slide_1=0.1 slide_2=0.1 slide_3=0.2
    python examples/solid_finite_elements.py --set poisson_ratio=0
    python examples/solid_finite_elements.py --configuration 2 --picture solid.png

Needs ``ccx``, the solver of CalculiX (Debian and Ubuntu: ``apt install calculix-ccx``); ``--picture`` needs matplotlib too.
``docs/explanation/solid_finite_elements.md`` describes model and results.
"""

from __future__ import annotations

import argparse
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from reproduce_paper import GRAVITY, POSES, TABLES

import kinetostatics as ks
from kinetostatics.sections import Tube

Array = NDArray[np.float64]
Numbers = NDArray[np.int_]

ROOT = Path(__file__).resolve().parent.parent
GRIPS = ("rigid", "distributing")
#: Names of the sets of nodes of the rods' two faces.
ENDS = ("BASE", "TOP")
TWIST = ("Δ_dx [m]", "Δ_dy [m]", "Δ_dz [m]", "Δ_rx [rad]", "Δ_ry [rad]", "Δ_rz [rad]")
#: CalculiX prints seven digits: what is smaller than this part of the largest number of its kind counts as zero.
NOISE = 1e-5
#: Passive joints that can be modelled; all others but fixed ones are refused.
KINDS = ("revolute", "continuous", "prismatic", "cylindrical", "universal", "spherical")


class NotSolidError(Exception):
    """A limb of the robot is not a single straight round rod."""


@dataclass(frozen=True)
class Fineness:
    """How many elements a rod has.

    Attributes:
        core: along each side of the square in the middle of the cross-section, and so along a quarter of its circumference.
        ring: from the square to the surface, or through the wall of a tube.
        per_diameter: along the rod, for each diameter of its length; beyond twelve diameters they get longer, not more.
    """

    core: int
    ring: int
    per_diameter: float


FINENESS = {"coarse": Fineness(3, 2, 2.0), "fine": Fineness(4, 3, 4.0)}

# ---- from the robot to rods ---------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Rod:
    """A straight round rod between two joints, at one pose. SI units, world axes.

    Attributes:
        name, limb: of its beam and of its limb.
        start, end: (3,) centres of its faces towards base and platform.
        axes: (3, 3) beam axes as columns, the first along the rod.
        outer_diameter, inner_diameter: of its section.
        youngs_modulus, poisson_ratio, density: of its material.
        base_freedoms, platform_freedoms: (6, f) twists, about the face's centre, that the passive joints at its ends leave free.
    """

    name: str
    limb: str
    start: Array
    end: Array
    axes: Array
    outer_diameter: float
    inner_diameter: float
    youngs_modulus: float
    poisson_ratio: float
    density: float
    base_freedoms: Array
    platform_freedoms: Array

    @property
    def length(self) -> float:
        return float(np.linalg.norm(self.end - self.start))

    @property
    def mass(self) -> float:
        return float(np.pi / 4 * (self.outer_diameter**2 - self.inner_diameter**2) * self.length * self.density)


def joint_twists(configuration: ks.Configuration, name: str, point: Array) -> Array:
    """Return the twists (6, f) of a joint's freedoms about a point of the world."""
    robot = configuration.robot.description
    if name in robot.joints:
        joint = robot.joints[name]
        frame = configuration.frame(joint.parent) @ joint.origin.matrix
        kind, axis, second = joint.type, frame[:3, :3] @ np.array(joint.axis), None
    else:
        loop = robot.loops[name]
        frame = configuration.frame(loop.predecessor) @ loop.predecessor_origin.matrix
        other = configuration.frame(loop.successor) @ loop.successor_origin.matrix
        kind, axis, second = loop.type, frame[:3, :3] @ np.array(loop.axis), other[:3, :3] @ np.array(loop.axis2)
    if kind == "fixed":
        return np.zeros((6, 0))
    if kind not in KINDS:
        raise NotSolidError(f"joint {name!r} is {kind}; only {', '.join(KINDS)} joints can be modelled")
    turning = {"prismatic": [], "universal": [axis, second], "spherical": list(np.eye(3))}.get(kind, [axis])
    twists = [np.concatenate([np.cross(direction, point - frame[:3, 3]), direction]) for direction in turning]
    if kind in ("prismatic", "cylindrical"):
        twists.append(np.concatenate([axis, np.zeros(3)]))
    return np.array(twists).T


def rods_of(configuration: ks.Configuration) -> list[Rod]:
    """Return the rods of a robot at one pose, limb by limb.

    Raises:
        NotSolidError: a limb is not a single round rod between joints, or weighs something else.
    """
    robot = configuration.robot
    lines = ks.analyze(configuration, gravity=(0, 0, 0)).beams
    rods = []
    for limb in robot.topology.limbs:
        names = [edge.span for edge in limb.edges if edge.span is not None]
        if len(names) != 1:
            raise NotSolidError(f"{limb.name} has {len(names)} beams; each limb must be a single rod")
        name, line = names[0], lines[names[0]]
        if set(limb.weights) - {f"beam:{name}"} or limb.branches:
            raise NotSolidError(f"{limb.name} carries more than its rod {name!r}: {', '.join(limb.weights)}")
        section = line.description.section
        if not isinstance(section, Tube):
            raise NotSolidError(f"the section of beam {name!r} is not a circle or a round tube")
        span = robot.beams[name].span
        inside = {item.name for item in (*span.inward, *span.outward)}
        actuated = set(robot.description.actuated)
        if any(not item.type.is_fixed and item.name not in actuated for item in (*span.inward, *span.outward)):
            raise NotSolidError(f"rod {name!r} telescopes freely: a joint inside it is not actuated, so it is not one piece")
        at = [edge.span for edge in limb.edges].index(name)
        start, end = line.points[0], line.points[-1]

        def freedoms(edges: Sequence[Any], point: Array, skip: set[str] = inside | actuated) -> Array:
            twists = [joint_twists(configuration, edge.joint, point) for edge in edges if edge.joint not in skip]
            return np.hstack([np.zeros((6, 0)), *twists])

        E, G = line.description.youngs_modulus, line.description.shear_modulus
        rods.append(
            Rod(
                name,
                limb.name,
                start,
                end,
                np.array(line.axes),
                section.outer_diameter,
                section.inner_diameter,
                E,
                E / (2 * G) - 1,
                float(line.mass / (section.area * line.length)),
                freedoms(limb.edges[:at], start),
                freedoms(limb.edges[at + 1 :], end),
            )
        )
    return rods


def platform_weight(configuration: ks.Configuration, gravity: Array) -> Array:
    """Return the wrench (6,) about o of the weights of all bodies fixed to the platform."""
    robot = configuration.robot
    total, o = np.zeros(6), configuration.platform_frame[:3, 3]
    for name in robot.topology.platform.weights:
        if name.startswith("beam:"):
            raise NotSolidError(f"the platform carries the elastic {name}; only rigid links can be modelled there")
        link, frame = robot.description.links[name], configuration.frame(name)
        centre = frame[:3, :3] @ np.array(link.center_of_mass) + frame[:3, 3]
        force = link.mass * gravity
        total += np.concatenate([force, np.cross(centre - o, force)])
    return total


# ---- the mesh -----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Mesh:
    """A rod of 20-node bricks.

    Attributes:
        nodes: (n, 3) [m].
        elements: (m, 20) numbers of their nodes, from 0, in CalculiX's order.
        faces: the 8-node quadrilaterals (f, 8) of the end towards the base and of that towards the platform.
    """

    nodes: Array
    elements: Numbers
    faces: tuple[Numbers, Numbers]


def section_mesh(outer: float, inner: float, core: int, ring: int) -> tuple[Array, Numbers]:
    """Mesh a disc (or annulus) of given diameters with 8-node quadrilaterals.

    The disc has a square with bulging sides in the middle and four fans around it, so that no element comes to a point.

    Returns:
        (n, 2) points and (m, 8) quadrilaterals: corners anticlockwise, then the middles of their sides.
    """
    R, half = outer / 2, 0.5 * outer / 2

    def side(v: Array) -> Array:  # the right-hand side of the square, which bulges a little; v runs from -1 to 1
        return np.stack([half * (1 + 0.2 * (1 - v**2)), half * v], axis=-1)

    def fan(u: Array, v: Array) -> Array:  # from the square (u = 0) to the circle (u = 1), from -45° to 45°
        arc = np.stack([np.cos(v * np.pi / 4), np.sin(v * np.pi / 4)], axis=-1)
        inside = side(v) if inner == 0 else inner / 2 * arc
        return inside * (1 - u[..., None]) + R * arc * u[..., None]

    def middle(u: Array, v: Array) -> Array:  # the square, its sides bulging less and less inwards
        bulge = 0.2
        return half * np.stack([u * (1 + bulge * (1 - v**2)), v * (1 + bulge * (1 - u**2))], axis=-1)

    blocks = []
    for quarter in range(4):
        c, s = np.cos(quarter * np.pi / 2), np.sin(quarter * np.pi / 2)
        u, v = np.meshgrid(np.linspace(0, 1, 2 * ring + 1), np.linspace(-1, 1, 2 * core + 1), indexing="ij")
        blocks.append(fan(u, v) @ np.array([[c, s], [-s, c]]))
    if inner == 0:
        u, v = np.meshgrid(*[np.linspace(-1, 1, 2 * core + 1)] * 2, indexing="ij")
        blocks.append(middle(u, v))
    points: list[Array] = []
    known: dict[tuple[int, int], int] = {}

    def number(point: Array) -> int:  # blocks share the nodes of the lines at which they meet
        key = (round(point[0] / (1e-6 * R)), round(point[1] / (1e-6 * R)))
        for near in ((key[0] + i, key[1] + j) for i in (0, -1, 1) for j in (0, -1, 1)):
            if near in known:
                return known[near]
        known[key] = len(points)
        points.append(point)
        return known[key]

    around = ((0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1))
    quads = [
        [number(block[i + a, j + b]) for a, b in around]
        for block in blocks
        for i in range(0, block.shape[0] - 2, 2)
        for j in range(0, block.shape[1] - 2, 2)
    ]
    return np.array(points), np.array(quads)


def rod_mesh(rod: Rod, fineness: Fineness) -> Mesh:
    """Mesh a rod: its cross-section is extruded along the axis, in shorter steps near the ends, where stresses vary rapidly."""
    points, quads = section_mesh(rod.outer_diameter, rod.inner_diameter, fineness.core, fineness.ring)
    steps = max(4, round(min(rod.length / rod.outer_diameter, 12) * fineness.per_diameter))
    t = np.linspace(0, 1, steps + 1)
    stations = t - 0.6 * np.sin(2 * np.pi * t) / (2 * np.pi)
    # every station holds all nodes of the section, the halves between two of them only the corners
    corners = np.unique(quads[:, :4])
    position_of_corner = {int(corner): k for k, corner in enumerate(corners)}
    layers, offsets = [], []
    count = 0
    for k, s in enumerate(stations):
        offsets.append(count)
        levels = [(s, points)] if k == steps else [(s, points), ((s + stations[k + 1]) / 2, points[corners])]
        for level, flat in levels:
            layers.append(rod.start + level * (rod.end - rod.start) + flat @ rod.axes[:, 1:].T)
            count += len(flat)
    elements = []
    for k in range(steps):
        bottom, between, top = offsets[k], offsets[k] + len(points), offsets[k + 1]
        for quad in quads:
            middle = [between + position_of_corner[int(corner)] for corner in quad[:4]]
            elements.append([*(bottom + quad[:4]), *(top + quad[:4]), *(bottom + quad[4:]), *(top + quad[4:]), *middle])
    return Mesh(np.concatenate(layers), np.array(elements), (quads, offsets[-1] + quads))


_GAUSS = tuple(zip(np.array([-1, 0, 1]) * np.sqrt(0.6), np.array([5, 8, 5]) / 9, strict=True))
#: Where the nodes of a 20-node brick lie in its own coordinates, in CalculiX's order.
_BRICK = np.array(
    [(x, y, z) for z in (-1, 1) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    + [(x, y, z) for z in (-1, 1) for x, y in ((0, -1), (1, 0), (0, 1), (-1, 0))]
    + [(x, y, 0) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
)


def _brick20(at: Array) -> tuple[Array, Array]:
    """Return the shape functions (20,) of a 20-node brick at a point (3,) and their derivatives (3, 20)."""
    P, N, D = _BRICK, np.zeros(20), np.zeros((3, 20))
    # a middle node's function vanishes on the four sides to which its edge does not run; a corner's on the middles as well
    factors = np.where(P == 0, 1 - at**2, 1 + P * at)
    slopes = np.where(P == 0, -2 * at, P)
    plane = P @ at - 2
    corner = np.all(P != 0, axis=1)
    product = factors.prod(axis=1)
    N[:] = np.where(corner, product * plane / 8, product / 4)
    for k in range(3):
        rest = np.delete(factors, k, axis=1).prod(axis=1) * slopes[:, k]
        D[k] = np.where(corner, (rest * plane + product * P[:, k]) / 8, rest / 4)
    return N, D


def nodal_volumes(mesh: Mesh) -> Array:
    """Return ∫N dV (n,) of every node, whose sum is the rod's volume; times the density, the mass at the node.

    The 2 × 2 × 2 points are those with which CalculiX integrates a C3D20R element.
    """
    volumes = np.zeros(len(mesh.nodes))
    place = mesh.nodes[mesh.elements]
    for at in np.stack(np.meshgrid(*[[-1, 1]] * 3), axis=-1).reshape(-1, 3) / np.sqrt(3):
        N, D = _brick20(at)
        determinant = np.linalg.det(np.einsum("ij,ejk->eik", D, place))
        np.add.at(volumes, mesh.elements, determinant[:, None] * N)
    return volumes


def _quad8(x: float, y: float) -> tuple[Array, Array]:
    """Return the shape functions (8,) of an 8-node quadrilateral and their derivatives (2, 8)."""
    X, Y = np.array([-1, 1, 1, -1]), np.array([-1, -1, 1, 1])
    N, D = np.zeros(8), np.zeros((2, 8))
    N[:4] = (1 + x * X) * (1 + y * Y) * (x * X + y * Y - 1) / 4
    D[0, :4] = X * (1 + y * Y) * (2 * x * X + y * Y) / 4
    D[1, :4] = Y * (1 + x * X) * (2 * y * Y + x * X) / 4
    for k, Yk in ((4, -1), (6, 1)):
        N[k], D[0, k], D[1, k] = (1 - x * x) * (1 + y * Yk) / 2, -x * (1 + y * Yk), (1 - x * x) * Yk / 2
    for k, Xk in ((5, 1), (7, -1)):
        N[k], D[0, k], D[1, k] = (1 - y * y) * (1 + x * Xk) / 2, (1 - y * y) * Xk / 2, -y * (1 + x * Xk)
    return N, D


def mean_motion(nodes: Array, face: Numbers, centre: Array) -> tuple[Numbers, Array]:
    """Return the nodes of a face and the map (6, 3n) from their displacements to the face's mean motion about ``centre``.

    The mean displacement is ∫u dA / A, the mean rotation that which fits best, (∫(r² 1 - r rᵀ) dA)⁻¹ ∫ r × u dA. The forces that
    belong to them are what a designer would call evenly spread: uniform traction for a force, linear for a moment.
    """
    which = np.unique(face)
    column = {int(node): k for k, node in enumerate(which)}
    area, second, forms = 0.0, np.zeros((3, 3)), np.zeros((6, 3 * len(which)))
    for quad in face:
        place = nodes[quad]
        for x, wx in _GAUSS:
            for y, wy in _GAUSS:
                N, D = _quad8(float(x), float(y))
                dA = wx * wy * float(np.linalg.norm(np.cross(D[0] @ place, D[1] @ place)))
                r = N @ place - centre
                area += dA
                second += dA * (r @ r * np.eye(3) - np.outer(r, r))
                for n, node in zip(N, quad, strict=True):
                    k = 3 * column[int(node)]
                    forms[:3, k : k + 3] += dA * n * np.eye(3)
                    forms[3:, k : k + 3] += dA * n * skew(r)
    return which, np.concatenate([forms[:3] / area, np.linalg.solve(second, forms[3:])])


def skew(r: Array) -> Array:
    """Return the matrix of r ×."""
    return np.array([[0, -r[2], r[1]], [r[2], 0, -r[0]], [-r[1], r[0], 0]])


# ---- the deck -----------------------------------------------------------------------------------------------------------


@dataclass
class Deck:
    """A CalculiX model; nodes are numbered from 1, dofs 1 to 3.

    The platform is a pair of nodes at o: the displacements of the first are those of o, those of the second the rotations.

    Attributes:
        rods, meshes: the rods and what they are made of.
        load: (6,) wrench on the platform about o.
        gravity: (3,).
        first_nodes: number of each rod's first node.
        nodes: all points (n, 3).
        equations: each a list of (node, dof, coefficient), the sum of which is zero; the first term is eliminated.
        platform: the platform's two nodes.
    """

    rods: list[Rod]
    meshes: list[Mesh]
    load: Array
    gravity: Array
    first_nodes: list[int] = field(default_factory=list)
    nodes: list[Array] = field(default_factory=list)
    equations: list[list[tuple[int, int, float]]] = field(default_factory=list)
    platform: tuple[int, int] = (0, 0)

    def add_node(self, point: Array) -> int:
        self.nodes.append(point)
        return len(self.nodes)

    def text(self, fields: bool = False) -> str:
        """Return the input file; ``fields``: ask for the displacements of all nodes too."""
        return "\n".join(self._lines(fields)) + "\n"

    def _lines(self, fields: bool) -> Iterator[str]:
        yield "*HEADING\nrods as solids, platform and ends of joints rigid; SI units"
        yield "*NODE, NSET=EVERYTHING"
        for number, point in enumerate(self.nodes, 1):
            yield f"{number}, " + ", ".join(f"{value:.12e}" for value in point)
        element = 0
        for k, (rod, mesh, first) in enumerate(zip(self.rods, self.meshes, self.first_nodes, strict=True), 1):
            yield f"** {rod.name}\n*ELEMENT, TYPE=C3D20R, ELSET=ROD{k}"
            for nodes in mesh.elements:
                element += 1
                numbers = [str(first + int(node)) for node in nodes]
                yield f"{element}, " + ", ".join(numbers[:15]) + ",\n" + ", ".join(numbers[15:])
            yield f"*MATERIAL, NAME=MATERIAL{k}\n*ELASTIC\n{rod.youngs_modulus:.10e}, {rod.poisson_ratio:.10e}"
            yield f"*DENSITY\n{rod.density:.10e}\n*SOLID SECTION, ELSET=ROD{k}, MATERIAL=MATERIAL{k}"
            for end, face in zip(ENDS, mesh.faces, strict=True):
                yield f"*NSET, NSET={end}{k}"
                yield from (f"{first + int(node)}," for node in np.unique(face))
        yield f"*NSET, NSET=PLATFORM\n{self.platform[0]}, {self.platform[1]}"
        for terms in self.equations:
            yield f"*EQUATION\n{len(terms)}"
            for k in range(0, len(terms), 4):
                yield ", ".join(f"{node}, {dof}, {coefficient:.12e}" for node, dof, coefficient in terms[k : k + 4])
        yield "*STEP\n*STATIC\n*CLOAD"
        for node, part in zip(self.platform, (self.load[:3], self.load[3:]), strict=True):
            yield from (f"{node}, {k}, {value:.12e}" for k, value in enumerate(part, 1))
        size = float(np.linalg.norm(self.gravity))
        if size > 0:
            direction = ", ".join(f"{value:.12e}" for value in self.gravity / size)
            yield "*DLOAD"
            yield from (f"ROD{k}, GRAV, {size:.12e}, {direction}" for k in range(1, len(self.rods) + 1))
        yield "*NODE PRINT, NSET=PLATFORM\nU"
        yield from (f"*NODE PRINT, NSET={end}{k}\nRF" for k in range(1, len(self.rods) + 1) for end in ENDS)
        if fields:
            yield "*NODE PRINT, NSET=EVERYTHING\nU"
        yield "*END STEP"


def make_deck(
    configuration: ks.Configuration,
    gravity: Sequence[float],
    load: Sequence[float] = (0, 0, 0, 0, 0, 0),
    *,
    grip: str = "distributing",
    fineness: Fineness = FINENESS["coarse"],
) -> Deck:
    """Make the model of a robot at one pose, with ``load`` (force, moment about o) on its platform.

    Args:
        grip: "rigid": joints hold the rods' end faces like a welded plate; "distributing": they hold only the faces' mean
            displacement and rotation, and the faces may warp and contract.
    """
    field_of_gravity, rods = np.array(gravity, float), rods_of(configuration)
    meshes = [rod_mesh(rod, fineness) for rod in rods]
    wrench = np.array(load, float) + platform_weight(configuration, field_of_gravity)
    deck = Deck(rods, meshes, wrench, field_of_gravity)
    for mesh in meshes:
        deck.first_nodes.append(len(deck.nodes) + 1)
        deck.nodes.extend(mesh.nodes)
    o = configuration.platform_frame[:3, 3]
    deck.platform = (deck.add_node(o), deck.add_node(o))
    attach = {"rigid": _attach_rigidly, "distributing": _attach_mean}[grip]
    for rod, mesh, first in zip(rods, meshes, deck.first_nodes, strict=True):
        attach(deck, mesh, first, mesh.faces[0], rod.start, None, rod.base_freedoms)
        attach(deck, mesh, first, mesh.faces[1], rod.end, deck.platform, rod.platform_freedoms)
    return deck


Body = tuple[int, int] | None  # the platform's two nodes, or the base, which does not move


def _attach_rigidly(deck: Deck, mesh: Mesh, first: int, face: Numbers, centre: Array, body: Body, freedoms: Array) -> None:
    """Constrain every node of a face to the motion of the body, except for one more dof for each freedom of the joint."""
    which = np.unique(face)
    basis = _split(freedoms, float(np.ptp(mesh.nodes[which], axis=0).max()))[0]
    extra = [deck.add_node(centre) for _ in range(-(-basis.shape[1] // 3))]
    for node in which:
        moves = basis[:3] - skew(mesh.nodes[node] - centre) @ basis[3:]
        for k in range(3):
            terms = [(extra[j // 3], j % 3 + 1, -float(value)) for j, value in enumerate(moves[k])]
            if body is not None:
                arm = skew(mesh.nodes[node] - deck.nodes[body[0] - 1])[k]
                terms += [(body[0], k + 1, -1.0), *((body[1], j, float(value)) for j, value in enumerate(arm, 1))]
            deck.equations.append([(first + int(node), k + 1, 1.0), *(term for term in terms if abs(term[2]) > 1e-14)])


def _attach_mean(deck: Deck, mesh: Mesh, first: int, face: Numbers, centre: Array, body: Body, freedoms: Array) -> None:
    """Constrain the mean motion of a face to that of the body along every wrench that the joint transmits.

    CalculiX has *DISTRIBUTING couplings, but they only spread loads; they do not tie a face to another body.
    """
    which, rows = mean_motion(mesh.nodes, face, centre)
    dofs = [(first + int(node), k) for node in which for k in (1, 2, 3)]
    own = len(dofs)
    if body is not None:
        arm = skew(centre - deck.nodes[body[0] - 1])
        rows = np.hstack([rows, -np.block([[np.eye(3), -arm], [np.zeros((3, 3)), np.eye(3)]])])
        dofs += [(node, k) for node in body for k in (1, 2, 3)]
    rows = _split(freedoms, float(np.ptp(mesh.nodes[which], axis=0).max()))[1].T @ rows
    rows /= np.abs(rows[:, :own]).max(axis=1)[:, None]
    # each equation needs a dof of its own to eliminate: Gauss-Jordan, with the largest coefficient among the face's dofs
    pivot: dict[int, int] = {}
    while len(pivot) < len(rows):
        left = [row for row in range(len(rows)) if row not in pivot]
        at, column = np.unravel_index(int(np.abs(rows[left, :own]).argmax()), (len(left), own))
        row = left[int(at)]
        rows[row] /= rows[row, column]
        others = np.arange(len(rows)) != row
        rows[others] -= np.outer(rows[others, column], rows[row])
        pivot[row] = int(column)
    for row, mine in pivot.items():
        rest = [k for k in np.flatnonzero(np.abs(rows[row]) > 1e-13) if k != mine]
        deck.equations.append([(*dofs[mine], 1.0), *((*dofs[k], float(rows[row, k])) for k in rest)])


def _split(freedoms: Array, size: float) -> tuple[Array, Array]:
    """Return bases of a joint's freedoms, twists (6, f), and of its constraints, wrenches (6, 6 - f)."""
    scale = np.repeat([1 / size, 1.0], 3)[:, None]  # metres and radians compared by the size of the face
    U, values, _ = np.linalg.svd(scale * freedoms, full_matrices=True)
    rank = int(np.sum(values > 1e-9))
    return U[:, :rank] / scale, U[:, rank:] * scale


# ---- running CalculiX ---------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class SolidResult:
    """Results of the solid model. SI units, world axes.

    Attributes:
        twist: (6,) of the platform at o.
        base_wrenches, platform_wrenches: (6,) what base and platform put on each rod, by the rod's name, about o.
        deck: the model.
        displacements: (n, 3) of all nodes, if asked for.
        seconds: how long CalculiX took.
    """

    twist: Array
    base_wrenches: dict[str, Array]
    platform_wrenches: dict[str, Array]
    deck: Deck
    displacements: Array | None
    seconds: float

    @property
    def weights(self) -> dict[str, Array]:
        """(3,) weight of each meshed rod, whose circumference consists of parabolas."""
        pairs = zip(self.deck.rods, self.deck.meshes, strict=True)
        return {rod.name: rod.density * float(nodal_volumes(mesh).sum()) * self.deck.gravity for rod, mesh in pairs}

    @property
    def unbalanced(self) -> float:
        """Largest unbalanced force of a rod or of the platform, relative to all weights and loads."""
        missing = [self.deck.load[:3] - sum(wrench[:3] for wrench in self.platform_wrenches.values())]
        for rod in self.deck.rods:
            ends = self.base_wrenches[rod.name] + self.platform_wrenches[rod.name]
            missing.append(ends[:3] + self.weights[rod.name])
        total = self.deck.load[:3] + sum(self.weights.values())
        return float(np.linalg.norm(missing, axis=1).max() / np.linalg.norm(total))


def find_ccx() -> str:
    """Return the path of CalculiX's solver, or end the program."""
    found = shutil.which("ccx")
    if found is None:
        print(
            "this example needs ccx, the solver of CalculiX, and there is none on the PATH; Debian and Ubuntu have it in the "
            "package calculix-ccx: apt install calculix-ccx",
            file=sys.stderr,
        )
        raise SystemExit(2)
    return found


def solve(deck: Deck, folder: Path | None = None, name: str = "robot", *, fields: bool = False) -> SolidResult:
    """Run CalculiX on a deck, in a folder that is kept or in a temporary one."""
    if folder is None:
        with tempfile.TemporaryDirectory() as temporary:
            return solve(deck, Path(temporary), name, fields=fields)
    command = [find_ccx(), "-i", name]
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{name}.inp").write_text(deck.text(fields), encoding="ascii")
    begin = time.perf_counter()
    run = subprocess.run(command, cwd=folder, capture_output=True, text=True, errors="replace", check=False)
    seconds = time.perf_counter() - begin
    printed = folder / f"{name}.dat"
    tables = read_dat(printed.read_text(encoding="ascii")) if printed.exists() else {}
    if run.returncode != 0 or ("displacements", "PLATFORM") not in tables:
        raise RuntimeError(f"ccx failed on {name}.inp:\n" + "\n".join(run.stdout.splitlines()[-20:]))
    moved = tables["displacements", "PLATFORM"]
    wrenches: dict[str, dict[str, Array]] = {end: {} for end in ENDS}
    for k, (rod, mesh, first) in enumerate(zip(deck.rods, deck.meshes, deck.first_nodes, strict=True), 1):
        weight = rod.density * nodal_volumes(mesh)[:, None] * deck.gravity
        for end in ENDS:
            # CalculiX's RF is all that acts on the elements at a node: besides the joint's force the node's share of the weight
            forces = {node: force - weight[node - first] for node, force in tables["forces", f"{end}{k}"].items()}
            arms = {node: mesh.nodes[node - first] - deck.nodes[deck.platform[0] - 1] for node in forces}
            moment = sum((np.cross(arms[node], force) for node, force in forces.items()), np.zeros(3))
            wrenches[end][rod.name] = np.concatenate([sum(forces.values(), np.zeros(3)), moment])
    everything = tables.get(("displacements", "EVERYTHING"))
    displacements = None
    if everything is not None:
        displacements = np.array([everything.get(number, np.zeros(3)) for number in range(1, len(deck.nodes) + 1)])
    twist = np.concatenate([moved[deck.platform[0]], moved[deck.platform[1]]])
    return SolidResult(twist, wrenches["BASE"], wrenches["TOP"], deck, displacements, seconds)


def read_dat(text: str) -> dict[tuple[str, str], dict[int, Array]]:
    """Return the tables of CalculiX's .dat file: by quantity and set, the values of each node."""
    tables: dict[tuple[str, str], dict[int, Array]] = {}
    current: dict[int, Array] = {}
    for line in text.splitlines():
        title = re.match(r"\s*(\w+) \(.*\) for set (\S+) and time", line)
        if title:
            current = tables.setdefault((title[1], title[2]), {})
        elif line.strip():
            number, *values = line.split()
            current[int(number)] = np.array(values, dtype=float)
    return tables


# ---- comparing ----------------------------------------------------------------------------------------------------------


def scaled_difference(twist: Array, reference: Array, length: float) -> float:
    """Return the difference of two twists relative to the second, with rotations times a length."""
    scale = np.repeat([1.0, length], 3)
    return float(np.linalg.norm(scale * (twist - reference)) / np.linalg.norm(scale * reference))


def intensities(result: ks.Result, wrenches: dict[str, Array]) -> dict[str, Array]:
    """Return the platform's wrench on each limb, by the name of its rod, as intensities of the limb's wrenches."""
    found: dict[str, Array] = {}
    for limb, rod in zip(result.limbs.values(), wrenches, strict=True):
        basis = np.hstack([limb.constraint_wrenches, limb.attached_wrenches])
        values = np.asarray(np.linalg.lstsq(basis, wrenches[rod], rcond=None)[0], dtype=np.float64)
        found[limb.name] = values[: len(limb.intensities)]
    return found


def quantities(result: ks.Result, solid: SolidResult | None) -> dict[str, float]:
    """Return the quantities of the table, of the solid model or, without one, of the beams; forces as magnitudes."""
    found = dict(zip(TWIST, (result.twist if solid is None else solid.twist).tolist(), strict=True))
    if solid is None:
        forces = {name: limb.intensities for name, limb in result.limbs.items()}
    else:
        forces = intensities(result, solid.platform_wrenches)
    for number, limb in enumerate(result.robot.topology.limbs, 1):
        for k, (label, value) in enumerate(zip(result.limbs[limb.name].labels, forces[limb.name], strict=True), 1):
            found[f"f_{number}{k} {'[N·m]' if label.startswith('couple') else '[N]'}"] = abs(float(value))
        (rod,) = [edge.span for edge in limb.edges if edge.span is not None]
        line = result.beams[rod]
        axial = line.section_wrenches[0, 0] if solid is None else line.axes[:, 0] @ solid.base_wrenches[rod][:3]
        found[f"f_{number}a [N]"] = abs(float(axial))
    return found


def printed_fea(robot: str, number: int) -> dict[str, float]:
    """Return the paper's finite element row of one configuration, under the names of :func:`quantities`."""
    rows = TABLES[robot][f"configuration_{number}"]["FEA"]
    found = dict(zip(TWIST, map(float, rows["twist"]), strict=True))
    for key in ("f1", "f2", "fa"):
        found.update({f"f_{limb}{key[1]} [N]": float(value) for limb, value in enumerate(rows[key], 1)})
    return found


@dataclass(frozen=True)
class Case:
    """A pose for the comparison.

    Attributes:
        title: for the table.
        result: of the beams.
        cowper: of the same beams with Cowper's shear coefficient κ instead of the file's.
        printed: the paper's finite elements, if it is one of the paper's.
    """

    title: str
    result: ks.Result
    cowper: ks.Result
    printed: dict[str, float]


def make_case(
    title: str,
    path: Path,
    pose: dict[str, Any],
    gravity: Sequence[float],
    parameters: dict[str, float] | None = None,
    printed: dict[str, float] | None = None,
) -> Case:
    """Analyze a robot's beams at one pose, with the κ of the file and with Cowper's κ."""
    robot = ks.load_robot(path, parameters)
    beams = {}
    for name, beam in robot.description.beams.items():
        beams[name] = replace(beam, shear_coefficient=None)
    both = (robot, ks.Robot(replace(robot.description, beams=beams)))
    result, cowper = (ks.analyze(each.assemble(**pose), gravity=gravity) for each in both)
    return Case(title, result, cowper, printed or {})


def paper_case(robot: str, number: int, parameters: dict[str, float] | None = None) -> Case:
    """Return one of the paper's configurations; with other ``parameters`` it has no numbers of the paper."""
    path = ROOT / "robots" / f"{robot}.urdf.xacro"
    printed = None if parameters else printed_fea(robot, number)
    title = f"{robot}, configuration {number}"
    return make_case(title, path, POSES[robot, number], GRAVITY[robot], parameters, printed)


def table(case: Case, solids: dict[str, SolidResult]) -> str:
    """Return one case as Markdown; differences are those between solid elements and beams."""
    columns = {"beams": quantities(case.result, None), "beams, Cowper's κ": quantities(case.cowper, None)}
    columns.update({f"solid, {grip}": quantities(case.result, solid) for grip, solid in solids.items()})
    if case.printed:
        columns["paper, FEA"] = case.printed
    heads = [*columns, *(f"{grip} to beams" for grip in solids)]
    lines = [f"**{case.title}**", "", "| | " + " | ".join(heads) + " |", "|---|" + "---:|" * len(heads)]
    beams = columns["beams"]
    length = float(case.result.robot.length)

    def scaled(name: str, value: float) -> float:
        return abs(value) * length if name.endswith("[rad]") else abs(value) / length if name.endswith("[N·m]") else abs(value)

    for name, value in beams.items():
        alike = [other for other in beams if (other in TWIST) == (name in TWIST)]
        noise = NOISE * max(scaled(other, beams[other]) for other in alike)
        cells = []
        for column in columns.values():
            number = column.get(name)
            shown = "–" if number is None else f"{number:.4e}" if name in TWIST else f"{number:.3f}"
            cells.append("0" if number is not None and scaled(name, number) < noise else shown)
        for grip in solids:
            other = columns[f"solid, {grip}"][name]
            percent = "–" if scaled(name, value) < noise else f"{100 * (other - value) / value:+.2f} %"
            cells.append(percent.replace("-0.00", "+0.00"))
        lines.append(f"| {name} | " + " | ".join(cells) + " |")
    lines.append("")
    for grip, solid in solids.items():
        parts = [100 * scaled_difference(solid.twist, result.twist, length) for result in (case.result, case.cowper)]
        lines.append(
            f"- {grip}: twist as a whole {parts[0]:.2f} % from the beams, {parts[1]:.2f} % with Cowper's κ; "
            f"{sum(len(mesh.elements) for mesh in solid.deck.meshes)} elements, {len(solid.deck.nodes)} nodes; "
            f"forces balance to {solid.unbalanced:.0e}; {solid.seconds:.1f} s"
        )
    return "\n".join(lines) + "\n"


# ---- the picture --------------------------------------------------------------------------------------------------------

#: The faces of a brick along the rod: corners, then the middles of their sides.
SIDES = ((0, 1, 5, 4, 8, 17, 12, 16), (1, 2, 6, 5, 9, 18, 13, 17), (2, 3, 7, 6, 10, 19, 14, 18), (3, 0, 4, 7, 11, 16, 15, 19))


def draw(solid: SolidResult, configuration: ks.Configuration, path: Path, title: str) -> None:
    """Draw the deformed rods, exaggerated and coloured by displacement, and the undeformed rods."""
    try:
        import matplotlib

        matplotlib.use("Agg")
        import matplotlib.pyplot as plt
        from matplotlib.collections import LineCollection, PolyCollection
    except ImportError:
        print("--picture needs matplotlib: pip install matplotlib", file=sys.stderr)
        raise SystemExit(2) from None
    assert solid.displacements is not None
    deck, moved = solid.deck, solid.displacements
    azimuth, elevation = np.radians(-62), np.radians(18)
    right = np.array([-np.sin(azimuth), np.cos(azimuth), 0])
    towards = np.array([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)])
    screen = np.array([right, np.cross(towards, right)])
    largest = float(np.linalg.norm(moved[: deck.platform[0] - 1], axis=1).max())
    factor = float(f"{0.06 / largest:.1g}")
    polygons, colours, depths, ghosts = [], [], [], []
    boundary = [0, 4, 1, 5, 2, 6, 3, 7]
    for rod, mesh, first in zip(deck.rods, deck.meshes, deck.first_nodes, strict=True):
        faces = np.concatenate([mesh.elements[:, side] for side in SIDES] + list(mesh.faces))
        keys = np.sort(faces[:, :4], axis=1)
        _, index, count = np.unique(keys, axis=0, return_index=True, return_counts=True)
        outside = faces[index[count == 1]][:, boundary]
        displacement = moved[first - 1 : first - 1 + len(mesh.nodes)]
        bent = mesh.nodes + factor * displacement
        corners = bent[outside]
        normal = np.cross(corners[:, 4] - corners[:, 0], corners[:, 6] - corners[:, 2])
        middle = corners.mean(axis=1)
        axis_point = rod.start + np.clip((middle - rod.start) @ rod.axes[:, 0], 0, rod.length)[:, None] * rod.axes[:, 0]
        normal *= np.sign(np.einsum("ij,ij->i", normal, middle - axis_point))[:, None]
        normal /= np.linalg.norm(normal, axis=1)[:, None]
        light = 0.55 + 0.45 * np.clip(normal @ (towards + np.array([0.3, 0.2, 0.5])), 0, 1.3) / 1.3
        polygons.append(corners @ screen.T)
        depths.append(middle @ towards)
        value = np.linalg.norm(displacement, axis=1)[outside].mean(axis=1) / largest
        rgba = plt.get_cmap("viridis")(value)
        rgba[:, :3] *= light[:, None]
        colours.append(rgba)
        across = np.cross(towards, rod.axes[:, 0])
        edge = rod.outer_diameter / 2 * across / np.linalg.norm(across)
        ghosts += [np.array([rod.start + s * edge, rod.end + s * edge]) @ screen.T for s in (1, -1)]
    polygon, colour, depth = np.concatenate(polygons), np.concatenate(colours), np.concatenate(depths)
    order = np.argsort(depth)
    figure, axes = plt.subplots(figsize=(7.2, 5.4), dpi=130)
    # the platform: a rigid plate through the joints' centres, drawn as a circle if they lie on one around o
    o = configuration.platform_frame[:3, 3]
    ends = np.array([rod.end for rod in deck.rods])
    radius = np.linalg.norm(ends - o, axis=1)
    if np.ptp(radius) < 1e-6 * radius[0]:
        e1, e2 = configuration.platform_frame[:3, 0], configuration.platform_frame[:3, 1]
        t = np.linspace(0, 2 * np.pi, 120)[:, None]
        ends = o + radius[0] * (np.cos(t) * e1 + np.sin(t) * e2)
    twist = solid.twist
    plate = ends + factor * (twist[:3] + np.cross(twist[3:], ends - o))
    for points, style in ((ends, "--"), (plate, "-")):
        closed = np.vstack([points, points[:1]]) @ screen.T
        axes.plot(*closed.T, style, color="0.45" if style == "--" else "0.1", linewidth=0.8 if style == "--" else 1.6, zorder=3)
    axes.fill(*(plate @ screen.T).T, color="0.6", alpha=0.25, zorder=2.5)
    axes.add_collection(
        PolyCollection(list(polygon[order]), facecolors=colour[order], edgecolors=(0, 0, 0, 0.25), linewidths=0.25, zorder=2)
    )
    axes.add_collection(LineCollection(ghosts, colors="0.45", linestyles="--", linewidths=0.8, zorder=3))
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.axis("off")
    scale = matplotlib.cm.ScalarMappable(norm=matplotlib.colors.Normalize(0, largest * 1e9), cmap="viridis")
    figure.colorbar(scale, ax=axes, shrink=0.7, pad=0.02, label="displacement [nm]")
    axes.set_title(f"{title}; displacements × {factor:,.0f}; dashed: without weight", fontsize=9)
    figure.savefig(path, bbox_inches="tight")
    plt.close(figure)


# ---- the command line ---------------------------------------------------------------------------------------------------


def _named(text: str) -> tuple[str, float]:
    name, _, value = text.partition("=")
    try:
        return name, float(value)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not NAME=VALUE") from None


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--elements", choices=list(FINENESS), default="coarse", help="fineness of the mesh (default: coarse)")
    parser.add_argument("--grip", choices=GRIPS, help="how joints hold the rods' end faces (default: both ways in turn)")
    parser.add_argument("--robot", default="3rps", help="3rps, 2pru_upr (in the paper's poses) or a robot file (default: 3rps)")
    parser.add_argument("--configuration", type=int, choices=(1, 2), help="only one of the paper's two")
    parser.add_argument(
        "--actuators", nargs="*", type=_named, default=[], metavar="NAME=VALUE", help="pose of a robot file [m, rad]"
    )
    parser.add_argument(
        "--set", dest="parameters", nargs="*", type=_named, default=[], metavar="NAME=VALUE", help="the file's xacro arguments"
    )
    parser.add_argument("--keep", type=Path, metavar="FOLDER", help="keep CalculiX's input and output files there")
    parser.add_argument("--picture", type=Path, metavar="PNG", help="draw the deformed rods of the last model")
    options = parser.parse_args(arguments)
    find_ccx()
    if any(robot == options.robot for robot, _ in POSES):
        numbers = [options.configuration] if options.configuration else [1, 2]
        gravity = GRAVITY[options.robot]
        cases = [paper_case(options.robot, number, dict(options.parameters)) for number in numbers]
    else:
        gravity = (0, 0, -9.81)
        pose = {"actuators": dict(options.actuators) or None}
        cases = [make_case(options.robot, Path(options.robot), pose, gravity, dict(options.parameters))]
    for number, case in enumerate(cases, 1):
        solids = {}
        for grip in [options.grip] if options.grip else GRIPS:
            deck = make_deck(case.result.configuration, gravity, grip=grip, fineness=FINENESS[options.elements])
            solids[grip] = solve(deck, options.keep, f"case_{number}_{grip}", fields=options.picture is not None)
        print(table(case, solids))
    if options.picture is not None:
        draw(solids[grip], case.result.configuration, options.picture, case.title)
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except (NotSolidError, ks.KinetostaticsError) as error:
        sys.exit(f"error: {error}")
