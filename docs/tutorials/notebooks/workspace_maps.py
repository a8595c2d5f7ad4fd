# %% [markdown]
# # Workspace maps
#
# One pose says little. A map holds thousands: where the robot gets to, how
# far it sags there, how stiff it is, and what its actuators hold.

# %%
import numpy as np
from matplotlib import pyplot as plt

import kinetostatics as ks

# %% [markdown]
# ## Sweep
#
# Arrays are dimensions of the map. The platform goes up and down and leans
# to all sides, by up to 45°.

# %%
ds = ks.sweep(
    "3rps",
    platform={
        "z": np.linspace(0.4, 0.8, 9),
        "azimuth": np.radians(np.arange(-180, 180, 5)),
        "tilt": np.radians(np.arange(0, 46, 3)),
    },
    orientation="tilt_torsion",
)
ds.sizes

# %% [markdown]
# `ds` is an [xarray](https://xarray.dev) Dataset. These are its quantities;
# each has a name, dimensions and a unit.

# %%
print(", ".join(ds.data_vars))

# %% [markdown]
# ## What is true of the poses
#
# Every pose has a status. Some are beyond the limit of a joint; they have
# numbers, but the robot must not go there.

# %%
total = ds["status"].size
beyond = int(ds["limit_exceeded"].sum())
assert (total, beyond) == (10368, 732)
assert int(ds["status"].max()) == ks.Status.LIMIT_EXCEEDED  # nothing worse
f"{total} poses, {beyond} of them beyond a joint's limit"

# %% [markdown]
# ## Where it is worst, and where best
#
# Poses beyond the limits do not count.

# %%
worst = ks.indices.worst(ds, "linear_sag")
best = ks.indices.best(ds, "least_translational_stiffness")
print(worst)
print(best)

# %% [markdown]
# The map is an xarray Dataset, so a pose is asked for by its coordinates,
# and dimensions are put together by name.

# %%
level = ds.sel(tilt=0, azimuth=0, method="nearest")
sag = abs(level["twist"].sel(component="z")) * 1e9  # nm
print(sag.values.round(1))
assert np.all(np.diff(sag) != 0)

largest = float(
    abs(ds["actuator_force"]).where(~ds["limit_exceeded"]).max()
)
f"no actuator holds more than {largest:.0f} N"

# %% [markdown]
# The robot looks the same after a third of a turn, and so must the map: it
# does, to nine digits.

# %%
field = ks.indices.quantity(ds, "linear_sag", beyond_limits=True)
np.testing.assert_allclose(
    field, field.roll(azimuth=24, roll_coords=False), rtol=1e-9
)

# %% [markdown]
# ## Figures
#
# A slice over azimuth and tilt is round: the view from above on where the
# platform leans.

# %%
ks.plot.slice(ds, "linear_sag", x="azimuth", y="tilt", at={"z": 0.7})
plt.show()
# %% [markdown]
# And the whole workspace as a body, cut open, coloured by the stiffness in
# the softest direction.

# %%
ks.plot.workspace(ds, "least_translational_stiffness", unit="N/µm")
plt.show()
