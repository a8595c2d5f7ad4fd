"""The paper's equations (2) to (24) at configuration 2 of both its robots, compared with the results of the package.

Every formula is evaluated here from the pose alone (points, axes, sections, weights), in the paper's limb axes; the other number
is read from the result.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import reproduce_paper
from numpy.linalg import norm

import kinetostatics as ks

Array = np.ndarray


@dataclass(frozen=True)
class Row:
    """A line: a quantity, the paper's equation, the value of the paper's formula, and that of the package."""

    what: str
    equation: str
    formula: Array
    ours: Array
    scale: float = 0.0

    @property
    def difference(self) -> float:
        """Largest difference relative to the largest number, or to the given scale."""
        size = max(float(np.max(np.abs(self.ours), initial=0.0)), self.scale, 1e-300)
        return float(np.max(np.abs(self.formula - self.ours), initial=0.0)) / size


@dataclass(frozen=True)
class Limb:
    """A limb of the paper at a pose: points, axes of its frame (the paper's), section, weight."""

    number: int
    A: Array
    B: Array
    R: Array
    o: Array
    result: ks.Result

    @property
    def name(self) -> str:
        return f"limb_{self.number}"

    @property
    def mine(self) -> ks.results.LimbResult:
        return self.result.limbs[self.name]

    @property
    def length(self) -> float:
        return float(norm(self.A - self.B))

    @property
    def beam(self):
        return self.result.robot.description.beams[f"rod_{self.number}"]

    @property
    def q(self) -> Array:
        """The weight per length in limb axes [N/m]."""
        return self.R.T @ (self.beam.density * self.beam.section.area * self.result.gravity)

    @property
    def EA(self) -> float:
        return self.beam.youngs_modulus * self.beam.section.area

    @property
    def EI(self) -> float:
        return self.beam.youngs_modulus * self.beam.section.I_y

    @property
    def GA(self) -> float:
        return self.beam.shear_modulus * self.beam.section.area  # κ = 1

    @property
    def GJ(self) -> float:
        return self.beam.shear_modulus * self.beam.section.J

    def force(self, direction: Array, point: Array) -> Array:
        """A unit force through a point, about o."""
        return np.r_[direction, np.cross(point - self.o, direction)]


def limb(result: ks.Result, number: int, revolute: str, y: bool) -> Limb:
    """Return a limb; with ``y`` the paper's y_i is along the revolute axis, else x_i."""
    pose = result.configuration
    beam = result.beams[f"rod_{number}"]
    B, A = beam.points[0], beam.points[-1]
    z = (A - B) / norm(A - B)
    joint = result.robot.mechanism.connections[revolute]
    axis = pose.frame(joint.predecessor)[:3, :3] @ _in_link(result.robot, joint)
    axis = axis - z * (z @ axis)
    axis /= norm(axis)
    R = np.column_stack([np.cross(axis, z), axis, z] if y else [axis, np.cross(z, axis), z])
    return Limb(number, A, B, R, pose.platform_frame[:3, 3], result)


def _in_link(robot: ks.Robot, joint) -> Array:
    """Return a joint's axis in its predecessor's own frame."""
    placement = robot.mechanism.body_of[joint.predecessor][1]
    return placement[:3, :3].T @ joint.axis_on(True)


@dataclass(frozen=True)
class Basis:
    """For each wrench of a limb in the paper: the number of the corresponding column of ours, and its sign."""

    columns: list[int]
    signs: Array

    @classmethod
    def of(cls, ours: Array, paper: Array) -> Basis:
        cosines = (ours / norm(ours, axis=0)).T @ (paper / norm(paper, axis=0))
        columns = [int(k) for k in np.argmax(np.abs(cosines), axis=0)]
        return cls(columns, np.sign(cosines[columns, range(paper.shape[1])]))

    def vector(self, ours: Array) -> Array:
        return self.signs * ours[self.columns]

    def matrix(self, ours: Array) -> Array:
        return self.signs[:, None] * ours[np.ix_(self.columns, self.columns)] * self.signs

    def wrenches(self, ours: Array) -> Array:
        return ours[:, self.columns] * self.signs


def steps(item: Limb, J_c: Array, J_g: Array, C: Array, W_g: Array, sag: Array, names: dict[str, str]) -> Iterator[Row]:
    """Yield the rows common to all limbs, from the paper's formulas in its limb axes."""
    mine, i = item.mine, item.number
    c, g = Basis.of(mine.constraint_wrenches, J_c), Basis.of(mine.attached_wrenches, J_g)
    yield Row(f"J_{i}c", "(2)", J_c, c.wrenches(mine.constraint_wrenches))
    yield Row(f"J_{i}g", "(4)", J_g, g.wrenches(mine.attached_wrenches))
    yield Row(f"C_{i}c", names["C"], C, c.matrix(mine.compliance))
    yield Row(f"K_{i}c", "(1)", np.linalg.inv(C), c.matrix(mine.stiffness))
    yield Row(f"W_{i}g", names["W_g"], W_g, g.vector(mine.attached_intensities))
    yield Row(f"Δ_{i}gc", names["sag"], sag, c.vector(mine.sag))
    twist = item.result.twist
    yield Row(f"Δ_{i}c = J_{i}cᵀ Δ", "(9)", J_c.T @ twist, c.vector(mine.compliance @ mine.intensities + mine.sag))
    yield Row(f"W_{i}c", "(11)", np.linalg.solve(C, J_c.T @ twist - sag), c.vector(mine.intensities))
    force = float(c.vector(mine.intensities)[0]) + item.q[2] * item.length
    axial = item.result.paper_forces[item.name][f"f_{i}a"]
    yield Row(f"f_{i}a = W_{i}c1 + q_{i}z L_{i}", "(17)", np.array([force]), np.array([axial]))


def rps(item: Limb) -> Iterator[Row]:
    """The RPS limb of the 3RPS: Eqs. (13) to (17)."""
    L, q, (x, y, z) = item.length, item.q, item.R.T
    W_g = np.array([-0.5 * q[0] * L])
    power = _power_on_revolute(item, y, x, W_g[0])
    yield Row("power of weight and J_ig W_ig on S_i1", "(14)", np.array([power]), np.zeros(1), scale=norm(q) * L**2)
    yield from steps(
        item,
        np.column_stack([item.force(z, item.A), item.force(y, item.A)]),
        item.force(x, item.A)[:, None],
        np.diag([L / item.EA, L / item.GA + L**3 / (3 * item.EI)]),
        W_g,
        np.array([q[2] * L**2 / (2 * item.EA), 0.0]),
        {"C": "(13)", "W_g": "(15)", "sag": "(16)"},
    )


def _power_on_revolute(item: Limb, axis: Array, direction: Array, intensity: float) -> float:
    """Return the power of the rod's weight and of a force at A on a unit turn of the rod about an axis through B."""
    weight = item.R @ item.q * item.length
    arm = item.A - item.B
    return float(axis @ (np.cross(arm / 2, weight) + np.cross(arm, direction * intensity)))


def pru(item: Limb, tau: Array) -> Iterator[Row]:
    """A PRU limb of the 2PRU-UPR: Eqs. (18), (19); the compliance by a cantilever under a force along z, along x and a couple."""
    L, q, (x, y, z), t = item.length, item.q, item.R.T, item.R.T @ tau
    coupling = t[1] * L**2 / (2 * item.EI)
    W_g = np.array([-0.5 * q[1] * L])
    power = _power_on_revolute(item, x, y, W_g[0])
    yield Row("power of weight and J_ig W_ig on S_i1", "(14)", np.array([power]), np.zeros(1), scale=norm(q) * L**2)
    yield from steps(
        item,
        np.column_stack([item.force(z, item.A), item.force(x, item.A), np.r_[0, 0, 0, tau]]),
        item.force(y, item.A)[:, None],
        np.array(
            [
                [L / item.EA, 0, 0],
                [0, L / item.GA + L**3 / (3 * item.EI), coupling],
                [0, coupling, (t[0] ** 2 + t[1] ** 2) * L / item.EI + t[2] ** 2 * L / item.GJ],
            ]
        ),
        W_g,
        np.array([q[2] * L**2 / (2 * item.EA), 0.0, 0.0]),
        {"C": "(1), refs [15, 25]", "W_g": "(18)", "sag": "(19)"},
    )


def upr(item: Limb, tau: Array) -> Iterator[Row]:
    """The UPR limb of the 2PRU-UPR: Eqs. (20) to (24)."""
    a, q, (x, y, z), t = item.length, item.q, item.R.T, item.R.T @ tau
    W_g = np.array([-0.5 * q[0] * a, -0.5 * q[1] * a])
    # the end of the rod under its own weight and W_3g2; the shear of the two cancels
    d = W_g[1] * a**3 / (3 * item.EI) + q[1] * a**4 / (8 * item.EI)
    turn = -W_g[1] * a**2 / (2 * item.EI) - q[1] * a**3 / (6 * item.EI)
    # under the force along y through B: at the end a force, and the couple a about x that takes it there
    sideways = a / item.GA + a**3 / (3 * item.EI) - 2 * a * a**2 / (2 * item.EI) + a**2 * a / item.EI
    coupling = t[0] * (-(a**2) / (2 * item.EI) + a * a / item.EI)
    J_c = np.column_stack([item.force(z, item.A), item.force(y, item.B), np.r_[0, 0, 0, tau]])
    yield from steps(
        item,
        J_c,
        np.column_stack([item.force(x, item.A), item.force(y, item.A)]),
        np.array(
            [
                [a / item.EA, 0, 0],
                [0, sideways, coupling],
                [0, coupling, (t[0] ** 2 + t[1] ** 2) * a / item.EI + t[2] ** 2 * a / item.GJ],
            ]
        ),
        W_g,
        np.array([q[2] * a**2 / (2 * item.EA), d + turn * a, turn * t[0]]),
        {"C": "(1), ref. [5]", "W_g": "(20)", "sag": "(21)"},
    )
    moved = np.column_stack([J_c[:, 0], item.force(y, item.A), J_c[:, 2], np.r_[0, 0, 0, x]])
    D = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [0, a, 0]])
    yield Row("J′_3c D_3 = J_3c", "(22), (23)", moved @ D, J_c)
    prime = np.array([q[2] * a**2 / (2 * item.EA), d, turn * t[0], turn])
    yield Row("D_3ᵀ Δ′_3gc = Δ_3gc", "(24)", D.T @ prime, np.array([prime[0], d + turn * a, turn * t[0]]))


def whole(result: ks.Result) -> Iterator[Row]:
    """Equations of the whole robot: (5) to (8), (10), (12)."""
    W, twist = result.load + result.platform_weight, result.twist
    limbs = list(result.limbs.values())
    held = sum(m.constraint_wrenches @ m.intensities + m.attached_wrenches @ m.attached_intensities for m in limbs)
    yield Row("W = Σ J_ic W_ic + Σ J_ig W_ig", "(5)", held, W)
    along = [(m.constraint_wrenches.T @ twist, m.attached_wrenches.T @ twist) for m in limbs]
    work = sum(m.intensities @ c + m.attached_intensities @ g for m, (c, g) in zip(limbs, along, strict=True))
    yield Row("Wᵀ Δ = Σ W_icᵀ Δ_ic + Σ W_igᵀ Δ_ig", "(6) to (8)", np.array([work]), np.array([W @ twist]))
    attached = sum(m.attached_wrenches @ m.attached_intensities for m in limbs)
    elastic = sum(m.constraint_wrenches @ m.stiffness @ (c - m.sag) for m, (c, _) in zip(limbs, along, strict=True))
    yield Row("W − Σ J_ig W_ig = Σ J_ic K_ic (Δ_ic − Δ_igc)", "(10)", elastic, W - attached)
    K = sum(m.constraint_wrenches @ m.stiffness @ m.constraint_wrenches.T for m in limbs)
    yield Row("K = Σ J_ic K_ic J_icᵀ", "(12)", K, result.stiffness)
    sagged = sum(m.constraint_wrenches @ m.stiffness @ m.sag for m in limbs)
    yield Row("Δ", "(12)", np.linalg.solve(K, W - attached + sagged), twist)


def pages() -> Iterator[tuple[str, list[Row]]]:
    """Yield a title and the rows of each part."""
    three = reproduce_paper.analyze("3rps", 2)
    yield "The 3RPS, configuration 2: RPS limb 1", list(rps(limb(three, 1, "revolute_1", y=True)))
    yield "The 3RPS, configuration 2: the whole robot", list(whole(three))
    over = reproduce_paper.analyze("2pru_upr", 2)
    frame = over.configuration.platform_frame[:3, :3]
    tau = np.cross([1.0, 0, 0], frame[:, 1])  # across the axes X and y of every universal joint
    tau /= norm(tau)
    for number in (1, 2):
        rows = list(pru(limb(over, number, f"revolute_{number}", y=False), tau))
        yield f"The 2PRU-UPR, configuration 2: PRU limb {number}", rows
    yield "The 2PRU-UPR, configuration 2: UPR limb 3", list(upr(limb(over, 3, "revolute_3", y=True), tau))
    yield "The 2PRU-UPR, configuration 2: the whole robot", list(whole(over))
