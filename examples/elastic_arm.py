"""Sag and actuator torques of a UR10 along a path, and the corrected joint positions at which the tool reaches the path.

    python examples/elastic_arm.py

The arm is the file of ``example-robot-data``, included unedited by ``robots/ur10.urdf.xacro``, which makes the upper arm and the
forearm elastic; see ``docs/how_to/plain_urdf.md``. The tool points down, carries 10 kg, and moves straight outwards.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin

import kinetostatics as ks

ROOT = Path(__file__).resolve().parent.parent
ELBOW_UP = {
    "shoulder_pan_joint": 0.0,
    "shoulder_lift_joint": np.radians(-90),
    "elbow_joint": np.radians(90),
    "wrist_1_joint": np.radians(-90),
    "wrist_2_joint": np.radians(-90),
    "wrist_3_joint": 0.0,
}
PAYLOAD = 10.0  # kg, its weight acts at the flange's centre
GRAVITY = 9.81
HEIGHT = 0.3  # m
REACHES = np.linspace(0.5, 1.15, 14)  # m, from the base's axis

#: Gears that give way too [N·m/rad]: of our own, the order of magnitude of strain wave gears of this size.
SOFT_GEARS = {"shoulder_actuator_stiffness": 6e4, "elbow_actuator_stiffness": 3e4, "wrist_actuator_stiffness": 1e4}

FILE = ROOT / "robots" / "ur10.urdf.xacro"
ARM = ks.load_robot(FILE)


def path(arm: ks.Robot = ARM, reaches: np.ndarray = REACHES) -> ks.Configuration:
    """Return poses with the tool pointing down at some distances (n,) [m] in front of the base."""
    start = arm.assemble(actuators=ELBOW_UP)
    tool = start.platform_coordinates("XYZ")
    target = {"x": reaches, "y": tool["y"], "z": HEIGHT, "rx": tool["rx"], "ry": tool["ry"], "rz": tool["rz"]}
    return arm.assemble(platform=target, orientation="XYZ", near=start)


def analyze(poses: ks.Configuration) -> ks.Result:
    """Return sag and torques with the payload."""
    return ks.analyze(poses, load=[0, 0, -PAYLOAD * GRAVITY, 0, 0, 0], gravity=[0, 0, -GRAVITY])


def compensated(poses: ks.Configuration, rounds: int = 2) -> ks.Configuration:
    """Return corrected poses, from which the tool sags to the given poses: the joints undo the tool's twist."""
    model, data = ARM.model, ARM.model.createData()
    tool = model.getFrameId("tool0")
    commanded = poses
    for _ in range(rounds):
        q = commanded.q.copy()
        for k, twist in enumerate(analyze(commanded).twist):
            wanted, unloaded = poses.platform_frame[k], commanded.platform_frame[k]
            turned = pin.exp3(twist[3:]) @ unloaded[:3, :3] @ wanted[:3, :3].T
            error = np.concatenate([unloaded[:3, 3] + twist[:3] - wanted[:3, 3], pin.log3(turned)])
            jacobian = pin.computeFrameJacobian(model, data, q[k], tool, pin.LOCAL_WORLD_ALIGNED)
            q[k] -= np.linalg.solve(jacobian, error)
        commanded = ARM.configuration(q)
    return commanded


def main() -> None:
    """Print the results."""
    poses = path()
    result = analyze(poses)
    lift, elbow, wrist = (result.actuator_forces[f"{name}_joint"] for name in ("shoulder_lift", "elbow", "wrist_1"))
    print(f"A UR10 moves {PAYLOAD:g} kg straight outwards, {1e3 * HEIGHT:.0f} mm above its base. Its arm tubes are elastic.\n")
    print("             tool sags by, under               tool          torque to hold it")
    print("   reach     payload  own weight  total        tilts         lift    elbow   wrist 1")
    print("   [mm]      [µm]     [µm]        [µm]         [µrad]        [N·m]")
    parts = {name: 1e6 * result.contributions[name][:, 2] for name in ("load", "limb_1", "platform_weight")}
    tilt = 1e6 * np.linalg.norm(result.twist[:, 3:5], axis=1)
    for k, reach in enumerate(REACHES):
        own = parts["limb_1"][k] + parts["platform_weight"][k]
        print(
            f"{1e3 * reach:7.0f} {parts['load'][k]:11.1f} {own:9.1f} {parts['load'][k] + own:10.1f} {tilt[k]:12.1f}"
            f" {lift[k]:13.1f} {elbow[k]:8.1f} {wrist[k]:8.1f}"
        )
    limits = dict(zip(ARM.model.names[1:], ARM.model.effortLimit, strict=True))
    print("\nTorques are feedforward: what the controller adds so that the arm stands still without an error to work against.")
    for name, torque in (("shoulder_lift_joint", lift), ("elbow_joint", elbow), ("wrist_1_joint", wrist)):
        worst = float(np.abs(torque).max())
        print(f"  {name:20} at most {worst:6.1f} N·m, {100 * worst / limits[name]:3.0f} % of its {limits[name]:.0f} N·m")

    commanded = compensated(poses)
    after = commanded.platform_frame[:, :3, 3] + analyze(commanded).twist[:, :3] - poses.platform_frame[:, :3, 3]
    before = float(np.linalg.norm(result.twist[:, :3], axis=1).max())
    print("\nCommanding the joints so that the tool sags into its path:")
    print(f"  off the path by at most {1e6 * before:.1f} µm before, {1e6 * np.abs(after).max():.1g} µm after (in this model)")
    turned = {name: np.abs(commanded.actuators[name] - poses.actuators[name]).max() for name in poses.actuators}
    most = max(turned, key=lambda name: turned[name])
    print(f"  no joint is turned more than {most}, by {1e3 * turned[most]:.2f} mrad")

    stretched = analyze(path(ks.load_robot(FILE, SOFT_GEARS), REACHES[-1:]))
    print(f"\nWith gears that give way as well, at {1e3 * REACHES[-1]:.0f} mm: {-1e6 * stretched.twist[0, 2]:.0f} µm, of which")
    causes = {name: twist for kind in stretched.source_contributions.values() for name, twist in kind.items()}
    for name, twist in sorted(causes.items(), key=lambda item: item[1][0, 2]):
        if abs(twist[0, 2]) > 1e-9:
            print(f"  {name:20} {-1e6 * twist[0, 2]:7.1f} µm")


if __name__ == "__main__":
    main()
