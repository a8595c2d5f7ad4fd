"""Inverse dynamics of a closed-loop robot with Pinocchio: actuator forces of the 3PRS while the normal of its platform circles.

    python examples/dynamics_with_pinocchio.py [PICTURE]

`kinetostatics` closes the loops, and provides the model with all masses. Pinocchio's recursive Newton–Euler algorithm computes
the generalized forces of the tree, and its loop constraints distribute them between actuators and loops. At rest these are the
forces computed by `kinetostatics`; in motion they include the inertia of platform and rods.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

import kinetostatics as ks


@dataclass(frozen=True)
class Motion:
    """Forces of the actuators along a motion.

    Attributes:
        time: (N,) [s].
        actuators: their names.
        forces: (N, actuators) their forces in motion [N or N·m].
        holding: (N, actuators) their forces at rest in the same poses [N or N·m].
        power: (N,) their total power [W].
        energy: (N,) kinetic and potential energy of the robot [J].
    """

    time: np.ndarray
    actuators: tuple[str, ...]
    forces: np.ndarray
    holding: np.ndarray
    power: np.ndarray
    energy: np.ndarray


def inverse_dynamics(pose: ks.Configuration, v: np.ndarray, a: np.ndarray) -> np.ndarray:
    """Return the actuators' forces (actuators,) [N or N·m] at one pose with joint velocities v and accelerations a (nv,)."""
    robot, model, data = pose.robot, pose.model, pose.data
    rows = []
    for constraint in robot.constraint_models():
        its = constraint.createData()
        constraint.calc(model, data, its)
        rows.append(pin.getConstraintJacobian(model, data, constraint, its))
    actuators = [model.joints[model.getJointId(name)].idx_v for name in robot.description.actuated]
    whole = pin.rnea(model, model.createData(), pose.q, v, a)
    unknowns = np.hstack([np.eye(model.nv)[:, actuators], np.concatenate(rows).T])
    return np.linalg.lstsq(unknowns, whole, rcond=1e-10)[0][: len(actuators)]


def circle(period: float = 1.0, tilt: float = np.radians(8), count: int = 60, name: str = "3prs") -> Motion:
    """Let the platform's normal circle about the vertical once.

    Args:
        period: of one turn [s].
        tilt: of the platform [rad].
        count: poses of the motion.
        name: a robot that comes with the package.
    """
    robot = ks.load_robot(name)
    step = period / (6 * count)  # poses lie closer than the ones that are kept, for the differences
    time = np.arange(count) * period / count
    angle = 2 * np.pi / period * (time[:, None] + step * np.array([-1, 0, 1]))
    height = float(robot.assemble().platform["z"])
    path = robot.assemble(platform={"z": height, "rx": tilt * np.cos(angle), "ry": tilt * np.sin(angle)})
    holding = ks.analyze(path).actuator_forces
    actuators = robot.description.actuated
    forces, power, energy = [], [], []
    for before, here, after in path.q:
        pose = robot.configuration(here)
        model = pose.model
        v = pin.difference(model, before, after) / (2 * step)
        a = (pin.difference(model, here, after) - pin.difference(model, before, here)) / step**2
        found = inverse_dynamics(pose, v, a)
        columns = [model.joints[model.getJointId(actuator)].idx_v for actuator in actuators]
        data = model.createData()
        forces.append(found)
        power.append(found @ v[columns])
        energy.append(pin.computeKineticEnergy(model, data, here, v) + pin.computePotentialEnergy(model, data, here))
    at_rest = np.stack([holding[actuator][:, 1] for actuator in actuators], axis=1)
    return Motion(time, actuators, np.array(forces), at_rest, np.array(power), np.array(energy))


def draw(motion: Motion, path: str) -> None:
    """Draw the forces over time: in motion solid, at rest dashed."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(7, 3.6), layout="constrained")
    for number, actuator in enumerate(motion.actuators):
        (line,) = axes.plot(motion.time, motion.forces[:, number], label=actuator)
        axes.plot(motion.time, motion.holding[:, number], "--", color=line.get_color())
    axes.set(
        xlabel="time [s]", ylabel="force of the actuator [N]", title="3PRS, platform circling: in motion, and at rest (dashed)"
    )
    figure.legend(loc="outside right upper")
    axes.grid(alpha=0.3)
    figure.savefig(path, dpi=110)


def main() -> None:
    """Print the largest forces, and draw them if a picture is asked for."""
    motion = circle()
    print("largest force [N]    in motion    at rest")
    for number, actuator in enumerate(motion.actuators):
        print(f"{actuator:18} {np.abs(motion.forces[:, number]).max():11.1f} {np.abs(motion.holding[:, number]).max():10.1f}")
    if len(sys.argv) > 1:
        draw(motion, sys.argv[1])


if __name__ == "__main__":
    main()
