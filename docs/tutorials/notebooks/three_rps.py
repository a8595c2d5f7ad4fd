# %% [markdown]
# # The 3RPS from file to figure
#
# A platform on three telescopic legs: how far does it sag, and what must
# its actuators hold? This is the first robot of Yang, Huang, Ye and Chen
# (2023), and all numbers here can be compared with theirs.

# %%
import numpy as np
from matplotlib import pyplot as plt

import kinetostatics as ks

# %% [markdown]
# ## The robot
#
# `"3rps"` is the name of a robot that comes with the package; the path of a
# file of your own goes there as well.

# %%
robot = ks.load_robot("3rps")
robot

# %% [markdown]
# `print` tells more: the limbs from base to platform, and by which forces
# each of them holds the platform.

# %%
print(robot)

# %% [markdown]
# ## A pose
#
# The robot has three freedoms, so three coordinates say where its platform
# is. Here it is 0.5 m high and leans by 10° towards −170°.

# %%
pose = robot.assemble(
    platform={
        "z": 0.5,
        "azimuth": np.radians(-170),
        "tilt": np.radians(10),
    },
    orientation="tilt_torsion",
)
pose

# %% [markdown]
# ## What gravity does
#
# The paper takes 9.8 m/s². Its Table 1 has these displacements of the
# platform's centre o, and its Table 2 these actuator forces.

# %%
result = ks.analyze(pose, gravity=[0, 0, -9.8])
result

# %%
paper_twist = [4.969e-8, 5.262e-8, -7.411e-8]  # m, along x, y and z
paper_forces = [385.435, 364.782, 367.832]  # N
forces = [
    round(float(force), 3) for force in result.actuator_forces.values()
]

np.testing.assert_allclose(result.twist[:3], paper_twist, rtol=2e-4)
np.testing.assert_allclose(forces, paper_forces, rtol=3e-6)
forces

# %% [markdown]
# The legs are as thick as an arm, so the platform sinks by less than 0.1
# µm. Which part does it? Every weight has its own share, and the shares add
# up to the whole.

# %%
shares = {
    name: round(float(twist[2]) * 1e9, 2)
    for name, twist in result.contributions.items()
}  # nm, along z
assert abs(sum(shares.values()) - result.twist[2] * 1e9) < 0.03
shares

# %% [markdown]
# ## See it
#
# The page below is the robot in this pose, its deformation exaggerated.
# Drag it with the mouse. `ks.save_html` writes the same page to a file.

# %%
ks.show(result)

# %% [markdown]
# ## Many poses at once, and a figure
#
# An array of coordinates gives a batch. The platform leans by 10° to all
# sides, one pose for every 5°.

# %%
azimuth = np.radians(np.arange(-180, 181, 5))
around = ks.analyze(
    robot.assemble(
        platform={"z": 0.5, "azimuth": azimuth, "tilt": np.radians(10)},
        orientation="tilt_torsion",
    ),
    gravity=[0, 0, -9.8],
)
sag = np.linalg.norm(around.twist[:, :3], axis=1) * 1e9  # nm

assert np.all(around.status == ks.Status.OK)
np.testing.assert_allclose(
    sag[2], np.linalg.norm(result.twist[:3]) * 1e9
)  # -170° is the pose from above
f"from {sag.min():.0f} nm to {sag.max():.0f} nm"

# %% [markdown]
# Three legs at 120° make a figure that repeats itself every 120°.

# %%
np.testing.assert_allclose(sag[24:49], sag[:25], rtol=1e-9)

figure, axes = plt.subplots(figsize=(6.5, 3.5), layout="constrained")
axes.plot(np.degrees(azimuth), sag)
axes.plot(-170, sag[2], "o", label="the paper's configuration 2")
axes.set(
    xlabel="azimuth of the lean [°]",
    ylabel="displacement of o [nm]",
    xticks=range(-180, 181, 60),
)
axes.grid(alpha=0.3)
axes.legend()
plt.show()
