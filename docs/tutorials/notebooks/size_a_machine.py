# %% [markdown]
# # Size a machine
#
# How thick must the rods be? A tool on the 3RPS presses with 500 N.
# Wherever the platform goes and leans, it may move by 10 µm. The rods
# shall be as light as possible.

# %%
import numpy as np
from matplotlib import pyplot as plt

import kinetostatics as ks

# %% [markdown]
# ## The poses and the candidates
#
# The diameter of the rods is an argument of the robot's file,
# `rod_diameter`. An array of values is a dimension of the map, like the
# coordinates of the platform: nine robots at 98 poses each.

# %%
ds = ks.sweep(
    "3rps",
    platform={
        "z": [0.45, 0.65],
        "rx": np.radians(np.linspace(-15, 15, 7)),
        "ry": np.radians(np.linspace(-15, 15, 7)),
    },
    parameters={"rod_diameter": np.linspace(0.04, 0.12, 9)},
    load=[0, 0, -500, 0, 0, 0],
    outputs=["default", "beams"],
)
assert (
    int(ds["status"].max()) == 0
)  # all poses are reached, within all limits
ds["twist"].sizes

# %% [markdown]
# ## The worst pose of each
#
# What counts is the worst of all poses. The index `linear_sag` is how far
# o moves, here under load and weight together.

# %%
poses = ["z", "rx", "ry"]
sag = ks.indices.quantity(ds, "linear_sag").max(poses) * 1e6  # µm
allowed = 10.0
fits = sag["rod_diameter"].where(sag <= allowed, drop=True)
diameter = float(fits.min())
np.testing.assert_allclose(diameter, 0.07)
at_most = float(sag.sel(rod_diameter=diameter))
f"{diameter * 1e3:.0f} mm: at most {at_most:.1f} µm"

# %% [markdown]
# Where is that worst pose?

# %%
ks.indices.worst(ds.sel(rod_diameter=[diameter]), "linear_sag")

# %% [markdown]
# ## What else could break
#
# The stress in the rods and the force at which they would buckle are in the
# map too. Neither decides here: stiffness does.

# %%
chosen = ds.sel(rod_diameter=diameter)
stress = float(chosen["beam_stress"].max()) / 1e6  # MPa
buckling = float(
    chosen["beam_euler_ratio"].max()
)  # axial force over Euler's
assert stress < 5 and buckling < 0.01
f"{stress:.1f} MPa, {buckling:.2%} of Euler's load"

# %% [markdown]
# ## And the actuators
#
# Thicker rods are heavier, and the actuators hold their weight. Between 40
# mm and 120 mm the largest actuator force more than doubles.

# %%
force = abs(ds["actuator_force"]).max([*poses, "actuator"])
assert force[-1] > 2 * force[0]
force.values.round()

# %% [markdown]
# ## The figure
#
# Sag falls and actuator forces rise with the diameter: the thinnest rods
# that are stiff enough are best.

# %%
figure, axes = plt.subplots(figsize=(6.5, 3.5), layout="constrained")
millimetres = ds["rod_diameter"] * 1e3
axes.semilogy(millimetres, sag, "o-")
axes.axhline(allowed, color="grey", linestyle="--")
axes.plot(
    diameter * 1e3,
    sag.sel(rod_diameter=diameter),
    "o",
    markersize=11,
    markerfacecolor="none",
    color="black",
)
axes.set(
    xlabel="diameter of the rods [mm]",
    ylabel="largest displacement of o [µm]",
)
axes.grid(alpha=0.3)
right = axes.twinx()
right.plot(millimetres, force, "s-", color="tab:orange")
right.set(ylabel="largest actuator force [N]", ylim=(0, None))
plt.show()
