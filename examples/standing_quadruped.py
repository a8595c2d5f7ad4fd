"""Sag of an ANYmal on four feet, and the forces of its feet if the trunk moves, a foot is placed outwards, or a foot is lifted.

    python examples/standing_quadruped.py

The quadruped is the file of ``example-robot-data``, included unedited by ``robots/anymal_standing.urdf.xacro``: the trunk is the
platform, each foot a ball joint on the ground; see ``docs/how_to/plain_urdf.md``.
Twelve locked actuators hold six freedoms, so
that the elasticity of the legs determines the forces of the feet. The feet also push outwards, which friction must prevent.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import kinetostatics as ks

FILE = Path(__file__).resolve().parent.parent / "robots" / "anymal_standing.urdf.xacro"
FEET = ("LF", "RF", "LH", "RH")  # left and right, fore and hind
HEIGHT = 0.48  # of the trunk's hip axes above ground [m]

SPRINGS = 300.0  # N·m/rad in every actuator, our choice: typical of series elastic actuators
STANDING = ks.load_robot(FILE)


def stand(robot: ks.Robot = STANDING, **where: object) -> ks.Configuration:
    """Return poses with the trunk level and at some place: x and y [m], default over the middle of its feet's rectangle."""
    target = {"x": 0.0, "y": 0.0, "z": HEIGHT, "rx": 0.0, "ry": 0.0, "rz": 0.0}
    return robot.assemble(platform={**target, **where})


def foot_forces(result: ks.Result) -> dict[str, np.ndarray]:
    """Return the forces (…, 3) [N] of the ground on each standing foot."""
    names = {foot: f"{foot}_contact" for foot in FEET}
    return {foot: result.joint_wrenches[name][..., :3] for foot, name in names.items() if name in result.joint_wrenches}


def lifted(pose: ks.Configuration) -> ks.Configuration:
    """Return the same pose with the left fore foot drawn up."""
    robot = ks.load_robot(FILE, {"standing": "RF LH RH"})
    q = pose.q.copy()
    model = robot.model
    q[model.joints[model.getJointId("LF_HFE")].idx_q] += np.radians(30)
    q[model.joints[model.getJointId("LF_KFE")].idx_q] -= np.radians(60)
    return robot.configuration(q)


def print_feet(result: ks.Result) -> None:
    """Print one line for each foot on the ground."""
    forces = foot_forces(result)
    weight = sum(force[2] for force in forces.values())
    print("       ground pushes up   share   and forwards   and to the left   friction needed")
    for foot, force in forces.items():
        print(
            f"   {foot} {force[2]:13.1f} N {100 * force[2] / weight:8.1f} % {force[0]:11.1f} N {force[1]:14.1f} N"
            f" {np.hypot(*force[:2]) / force[2]:14.2f}"
        )
    scale, unit = (1e6, "µ") if abs(result.twist[2]) < 1e-3 else (1e3, "m")
    x, y, z, rx, ry, _ = scale * result.twist
    moved = f"{-z:.1f} {unit}m down, {x:+.1f} {unit}m forwards, {y:+.1f} {unit}m to the left"
    print(f"   trunk: {moved}, tilted by {np.hypot(rx, ry):.1f} {unit}rad")
    actuator, torque = max(result.actuator_forces.items(), key=lambda item: abs(float(item[1])))
    print(f"   hardest actuator: {actuator}, {float(torque):+.1f} N·m\n")


def main() -> None:
    """Print the results."""
    result = ks.analyze(stand())
    mass = -result.base_wrench[2] / result.gravity[2]
    print(f"ANYmal, {mass:.2f} kg, on four feet, trunk {1e3 * HEIGHT:.0f} mm above the ground\n")
    print_feet(result)

    print(f"The same with springs of {SPRINGS:g} N·m/rad in all twelve actuators, as series elastic actuators have them")
    print_feet(ks.analyze(stand(ks.load_robot(FILE, {"actuator_stiffness": SPRINGS}))))

    print("The trunk shifts forwards over feet that stay where they are")
    shifts = np.linspace(-0.1, 0.1, 9)
    moved = ks.analyze(stand(x=shifts))
    forces = foot_forces(moved)
    front = (forces["LF"] + forces["RF"])[:, 2] / sum(force[:, 2] for force in forces.values())
    knees = {leg: np.abs(moved.actuator_forces[f"{leg}_KFE"]) for leg in ("LF", "LH")}
    print("   shift     fore feet   trunk sags   and pitches   knee torque LF, LH")
    for k, shift in enumerate(shifts):
        print(
            f"{1e3 * shift:+6.0f} mm {100 * front[k]:9.1f} % {-1e6 * moved.twist[k, 2]:9.1f} µm"
            f" {1e6 * moved.twist[k, 4]:+9.1f} µrad {knees['LF'][k]:12.1f} {knees['LH'][k]:6.1f} N·m"
        )

    print("\nThe right fore foot steps forwards, the trunk stays")
    print("   step      LF       RF       LH       RH    down    trunk sags")
    for step in np.linspace(0, 0.16, 5):
        stepped = ks.analyze(stand(ks.load_robot(FILE, {"RF_foot": f"{0.4405 + step} -0.246 0"})))
        down = "".join(f"{force[2]:8.1f} " for force in foot_forces(stepped).values())
        print(f"{1e3 * step:+6.0f} mm {down}  N   {-1e6 * stepped.twist[2]:8.1f} µm")

    print("\nThe trunk shifts to the right and back, and the left fore foot lifts")
    pose = stand(x=-0.05, y=-0.05)
    print("  four feet")
    print_feet(ks.analyze(pose))
    print("  three feet, the fourth leg drawn up")
    print_feet(ks.analyze(lifted(pose)))

    print("Where must the trunk be before that foot may lift? The force on the hind foot across from it says:")
    for shift in (0.02, 0.01, 0.0, -0.01, -0.02):
        three = foot_forces(ks.analyze(lifted(stand(x=shift, y=shift))))
        verdict = "stands" if min(force[2] for force in three.values()) > 0 else "would tip: that foot would have to be held down"
        print(f"   {1e3 * shift:+4.0f} mm forwards and to the left: RH carries {three['RH'][2]:+6.1f} N, {verdict}")


if __name__ == "__main__":
    main()
