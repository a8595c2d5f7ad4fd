# %% [markdown]
# # Tolerances of an overconstrained machine
#
# The 2PRU-UPR is held more often than necessary. That makes it stiff, but
# parts that do not fit exactly force one another: errors of assembly lock
# in forces. How large may the errors be?

# %%
import numpy as np
from matplotlib import pyplot as plt

import kinetostatics as ks

# %% [markdown]
# ## Is it overconstrained?
#
# Three constraints of the robot are redundant. The file does not say so; it
# follows from the joint axes.

# %%
robot = ks.load_robot("2pru_upr")
pose = robot.assemble()
assert robot.mobility.redundant_constraints == 3
print("\n".join(str(robot).splitlines()[:9]))

# %% [markdown]
# ## One error
#
# The hinge of limb 1 is turned by 1 mrad about the y axis of its frame.
# Without weight, all that follows is the error's own doing.

# %%
result = ks.analyze(
    pose,
    gravity=[0, 0, 0],
    assembly_errors={
        "revolute_1": {"twist": [0, 0, 0, 0, 1e-3, 0], "frame": "joint"}
    },
)
locked = max(
    np.linalg.norm(wrench[:3]) for wrench in result.joint_wrenches.values()
)
np.testing.assert_allclose(locked, 261.064, rtol=1e-4)
moved = np.linalg.norm(result.twist[:3]) * 1e6
f"{locked:.0f} N in the joints, and o moves by {moved:.0f} µm"

# %% [markdown]
# It does not reach the actuators: forces that are locked in need no
# actuator.

# %%
assert max(abs(force) for force in result.actuator_forces.values()) < 1e-6

# %% [markdown]
# ## All errors, ranked
#
# `ks.tolerances` takes every error of every joint and rod, by 0.1 mm, 1
# mrad and 1 K unless tolerances are given.

# %%
found = ks.tolerances(pose)
found

# %% [markdown]
# Only some errors cause self-stress. The others move the platform, and a
# calibration takes them out.

# %%
harmful = {
    name: effect
    for name, effect in found.effects.items()
    if effect.force > 1e-6
}
assert len(found.effects) == 50 and len(harmful) == 24
f"{len(harmful)} of {len(found.effects)}"

# %% [markdown]
# ## A limit
#
# Errors act in proportion. If no error alone shall lock in more than 50 N,
# this is how exact each angle must be:

# %%
worst = {}
for name, effect in harmful.items():
    joint, _, error = name.split(".")
    if error in ("rx", "ry", "rz"):
        slope = effect.force / found.parameters[name].tolerance  # N/rad
        worst[joint] = max(worst.get(joint, (0.0, "")), (slope, name))
needed = {
    joint: 50 / slope * 1e3 for joint, (slope, _) in worst.items()
}  # mrad
assert min(needed, key=needed.get) in ("revolute_1", "revolute_2")
{joint: f"{value:.2f} mrad" for joint, value in needed.items()}

# %% [markdown]
# Try it: the worst joint off by just that much locks in 50 N.

# %%
slope, name = max(worst.values())
joint, _, component = name.split(".")
error = [0.0] * 6
error[("x", "y", "z", "rx", "ry", "rz").index(component)] = 50 / slope
again = ks.analyze(
    pose,
    gravity=[0, 0, 0],
    assembly_errors={joint: {"twist": error, "frame": "joint"}},
)
np.testing.assert_allclose(
    np.linalg.norm(again.joint_wrenches[harmful[name].at][:3]),
    50,
    rtol=1e-6,
)

# %% [markdown]
# ## Thinner rods forgive more
#
# Softer rods lock in less force, but they sag more under their own weight.

# %%
diameters = np.linspace(0.03, 0.09, 7)
assembly_error = {
    "revolute_1": {"twist": [0, 0, 0, 0, 1e-3, 0], "frame": "joint"}
}
forces, sags = [], []
for diameter in diameters:
    changed = ks.load_robot(
        "2pru_upr", parameters={"rod_diameter": diameter}
    )
    home = changed.assemble()
    off = ks.analyze(
        home, gravity=[0, 0, 0], assembly_errors=assembly_error
    )
    forces.append(
        max(
            np.linalg.norm(wrench[:3])
            for wrench in off.joint_wrenches.values()
        )
    )
    sags.append(np.linalg.norm(ks.analyze(home).twist[:3]) * 1e6)  # µm

# %% [markdown]
# Locked-in forces grow with the fourth power of the diameter, as the rods'
# stiffness in bending does. Sag falls with less than that, because thicker
# rods are heavier.

# %%
force_power = np.polyfit(np.log(diameters), np.log(forces), 1)[0]
sag_power = np.polyfit(np.log(diameters), np.log(sags), 1)[0]
assert abs(force_power - 4) < 0.02
assert -3.3 < sag_power < -3.0
f"force ~ diameter^{force_power:.2f}, sag ~ diameter^{sag_power:.2f}"

# %%
figure, axes = plt.subplots(figsize=(6.5, 3.5), layout="constrained")
axes.loglog(sags, forces, "o-")
for diameter, sag, force in zip(diameters, sags, forces, strict=True):
    axes.annotate(f"  {diameter * 1e3:.0f} mm", (sag, force), fontsize=8)
axes.set(
    xlabel="displacement of o under the robot's weight [µm]",
    ylabel="force locked in by 1 mrad [N]",
)
axes.grid(alpha=0.3, which="both")
plt.show()
