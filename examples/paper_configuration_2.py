"""Configuration 2 of the 2PRU-UPR: consistency of the paper's numbers, and comparison with ours."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import reproduce_paper
from numpy.linalg import norm
from reproduce_paper import TABLES

import kinetostatics as ks

Array = np.ndarray


@dataclass(frozen=True)
class Second:
    """Configuration 2 of the 2PRU-UPR: our result, and the paper's analytical and finite element numbers."""

    result: ks.Result
    analytical: dict[str, Array]
    elements: dict[str, Array]

    @classmethod
    def read(cls) -> Second:
        printed = TABLES["2pru_upr"]["configuration_2"]
        numbers = [
            {key: np.array([float(x) for x in printed[which][key]]) for key in printed[which]} for which in ("analytical", "FEA")
        ]
        return cls(reproduce_paper.analyze("2pru_upr", 2), *numbers)

    @property
    def limbs(self) -> list[ks.results.LimbResult]:
        return list(self.result.limbs.values())

    @property
    def J(self) -> Array:
        """All nine constraint wrenches (6, 9), three of each limb."""
        return np.hstack([limb.constraint_wrenches for limb in self.limbs])

    def determinate(self) -> Array:
        """Return whether equilibrium alone, Eq. (5), determines each of the nine intensities."""
        free = np.linalg.svd(self.J)[2][6:]
        return np.max(np.abs(free), axis=0) < 1e-9

    def unbalanced(self) -> tuple[float, float]:
        """Return the force [N] and moment [N·m] left unbalanced by the paper's FEA f_11, f_21, f_31, f_32."""
        known = np.flatnonzero(self.determinate())
        found = np.concatenate([limb.intensities for limb in self.limbs])
        given = np.sign(found[known]) * np.r_[self.elements["f1"], self.elements["f2"][2]]
        attached = sum(limb.attached_wrenches @ limb.attached_intensities for limb in self.limbs)
        rest = self.result.load + self.result.platform_weight - attached - self.J[:, known] @ given
        others = np.delete(self.J, known, axis=1)
        left = rest - others @ np.linalg.lstsq(others, rest, rcond=None)[0]
        return float(norm(left[:3])), float(norm(left[3:]))

    def compatible(self, forces: dict[str, Array], given: Array, component: int) -> Array:
        """Return the twist (6,) whose displacements of the rods, Eq. (9), are those due to f_i1, f_12 and f_22, Eq. (11).

        Along the three rods, and across rods 1 and 2 with f_13 and f_23 eliminated, these are five equations for six components:
        the twist is fixed up to one parameter, for which a component of ``given`` (6,) is taken.
        """
        rows, right = [], []
        for limb, f1, f2 in zip(self.limbs, forces["f1"], forces["f2"], strict=True):
            J, C, sag, signs = limb.constraint_wrenches, limb.compliance, limb.sag, np.sign(limb.intensities)
            rows.append(J[:, 0])
            right.append(C[0, 0] * signs[0] * f1 + sag[0])
            if limb is not self.limbs[2]:
                part = C[1, 2] / C[2, 2]
                rows.append(J[:, 1] - part * J[:, 2])
                right.append((C[1, 1] - part * C[2, 1]) * signs[1] * f2 + sag[1] - part * sag[2])
        some = np.linalg.lstsq(np.array(rows), np.array(right), rcond=None)[0]
        along = np.linalg.svd(np.array(rows))[2][5]
        return np.asarray(some + along * (given[component] - some[component]) / along[component])

    def changed(self, attached: bool = False, bending: bool = False) -> tuple[Array, dict[str, Array]]:
        """Return twist and forces without J_3g2 W_3g2 in Eq. (12), or without the two bending entries of Δ_3gc."""
        third = self.limbs[2]
        twist, sags = np.array(self.result.twist), [np.array(limb.sag) for limb in self.limbs]
        if attached:
            twist += self.result.compliance @ third.attached_wrenches[:, 1] * third.attached_intensities[1]
        if bending:
            dropped = np.r_[0.0, sags[2][1:]]
            sags[2] = sags[2] - dropped
            twist -= self.result.compliance @ third.constraint_wrenches @ third.stiffness @ dropped
        found = [limb.stiffness @ (limb.constraint_wrenches.T @ twist - sag) for limb, sag in zip(self.limbs, sags, strict=True)]
        return twist, {"f1": np.abs([f[0] for f in found]), "f2": np.abs([f[1] for f in found])}


def literal() -> Array:
    """Return f_i1 at the pose that the text gives: β = 5° about y, γ = −6° about X."""
    robot = reproduce_paper.analyze("2pru_upr", 2).robot
    pose = robot.assemble(platform={"z": 0.6, "rx": np.radians(-6), "ry": np.radians(5)}, orientation="XYZ")
    return np.array([abs(float(limb.intensities[0])) for limb in ks.analyze(pose, gravity=(0, 0, 9.8)).limbs.values()])


def rotation_vector() -> float:
    """Return Δ_dy [m] if the two angles are components of a rotation vector."""
    robot = reproduce_paper.analyze("2pru_upr", 2).robot
    pose = robot.assemble(platform={"z": 0.6, "rx": np.radians(-5), "ry": np.radians(-6)})
    return float(ks.analyze(pose, gravity=(0, 0, 9.8)).twist[1])


def story() -> str:
    """Return the comparison of configuration 2 of the 2PRU-UPR with the paper, in Markdown."""
    second = Second.read()
    force, moment = second.unbalanced()
    formula, elements = (second.compatible(row, row["twist"], 1) for row in (second.analytical, second.elements))
    without, forces_without = second.changed(attached=True)
    straight, forces_straight = second.changed(bending=True)
    off = 100 * (straight / second.elements["twist"] - 1)
    f2_off = 100 * (forces_straight["f2"] / second.elements["f2"] - 1)
    names = ["Δ_dx", "Δ_dy", "Δ_dz", "Δ_rx", "Δ_ry", "Δ_rz"]
    lines = [
        "## Configuration 2 of the 2PRU-UPR",
        "",
        "**Pose.** The text gives β = 5° about y and γ = −6° about X. At that pose f_11, f_21, f_31 are "
        f"{_list(literal(), '.2f')} N, whereas the paper's finite elements give {_list(second.elements['f1'], '.2f')} N. "
        f"At θ_X = −5°, θ_y = −6° they are {_list([abs(limb.intensities[0]) for limb in second.limbs], '.2f')} N; these angles "
        "are used here.",
        "",
        "**Signs.** Table 3 has gravity along +Z. The angles are rotations about X, then about the moving axis y "
        "(`--orientation XYZ`). As components of a rotation vector, the default, they would give "
        f"Δ_dy = {rotation_vector():.4e} m instead of {second.result.twist[1]:.4e} m.",
        "",
        "**Equilibrium.** Eq. (5) and the weights alone determine four of the nine intensities: f_11, f_21, f_31 and f_32. "
        "The first three agree with the paper's finite elements. The fourth, "
        f"f_32 = {second.elements['f2'][2]:.2f} N in the paper, is not in equilibrium with the paper's f_i1: "
        f"{force:.1f} N and {moment:.1f} N·m remain unbalanced. Equilibrium requires "
        f"{abs(second.limbs[2].intensities[1]):.2f} N.",
        "",
        "**Table 3 and Table 4.** By Eqs. (9) and (11) the forces f_i1, f_12 and f_22 of Table 4 determine the twist up to one "
        "parameter, for which the printed Δ_dy is taken. Both rows of Table 3 contradict this twist. In the analytical row Δ_dx "
        f"should be {1e6 * formula[0]:.2f}e-6 m (printed {1e6 * second.analytical['twist'][0]:.2f}e-6), in the finite element "
        f"row Δ_rz should be {1e6 * elements[5]:.2f}e-6 rad (printed {1e6 * second.elements['twist'][5]:.3f}e-6).",
        "",
        "**Analytical row.** If J_3g2 W_3g2 is left out of Eq. (12), f_11 and f_21 are "
        f"{_list(forces_without['f1'][:2], '.2f')} N (printed {_list(second.analytical['f1'][:2], '.2f')}). The other numbers "
        f"disagree: f_32 is {forces_without['f2'][2]:.2f} N (printed {second.analytical['f2'][2]:.2f}) and Δ_rz is "
        f"{without[5]:+.2e} rad (printed {second.analytical['twist'][5]:+.2e}).",
        "",
        "**Finite element row.** If the two bending entries of Δ_3gc are left out (the rod of limb 3 does not bend under its own "
        "weight), the twist is near that of the paper's finite elements in all six components:",
        "",
        "| | paper, FEA | without bending | difference | ours |",
        "|---|---:|---:|---:|---:|",
        *(
            f"| {name} | {given:.3e} | {value:.4e} | {part:+.1f} % | {own:.4e} |"
            for name, given, value, part, own in zip(
                names, second.elements["twist"], straight, off, second.result.twist, strict=True
            )
        ),
        "",
        "The twist without bending is that of rods with their weight [lumped at the ends](beside_other_methods.md). But Table 4 "
        "contradicts this explanation: with bending, f_12 and f_22 agree with the table to 0.03 %; without, they differ by "
        f"{f2_off[0]:+.1f} % and {f2_off[1]:+.1f} %. [Solid elements](solid_finite_elements.md) confirm the bending of rod 3.",
    ]
    return "\n".join(lines)


def _list(values: object, form: str) -> str:
    return ", ".join(format(float(value), form) for value in values)
