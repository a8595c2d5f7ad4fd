# %% [markdown]
# # Your own robot
#
# From a name in the field's notation to a file that you can edit, check and
# trust. The robot is a lifting table on three upright legs, because its
# stiffness can be worked out by hand.

# %%
import tempfile
from pathlib import Path

import numpy as np
from matplotlib import pyplot as plt

import kinetostatics as ks

# %% [markdown]
# ## A file to begin with
#
# `3-R[P]S` says: three limbs, each with a revolute, an actuated prismatic
# and a spherical joint. The legs are upright where base and platform have
# the same radius.

# %%
file = Path(tempfile.mkdtemp()) / "lifting_table.urdf.xacro"
robot = ks.new_robot(
    "3-R[P]S",
    file,
    base_radius=0.25,
    platform_radius=0.25,
    height=0.5,
    sections={"rod": "tube 60mm 50mm steel"},
)
robot

# %% [markdown]
# The file is an ordinary xacro. These are the values at its top:

# %%
text = file.read_text(encoding="utf-8")
for line in text.splitlines():
    if "<xacro:arg" in line:
        print(line.strip())

# %% [markdown]
# ## Check it
#
# `print(robot)` is what `kinetostatics check` says. Read it before any
# number: is the mobility what you meant? Are the limbs?

# %%
assert robot.mobility.platform == 3
print(robot)

# %% [markdown]
# ## A mistake
#
# Mistakes are told with file and line, and with what would be right. Here
# the platform has the name of a link that does not exist.

# %%
wrong = file.with_name("wrong.urdf.xacro")
wrong.write_text(
    text.replace(
        '<platform link="platform"/>', '<platform link="plattform"/>'
    ),
    encoding="utf-8",
)
try:
    ks.load_robot(wrong)
except ks.RobotFileError as error:
    message = str(error).removeprefix(str(file.parent))
assert "plattform" in message
print(message)

# %% [markdown]
# ## Compare it with a formula
#
# Three upright legs of length $L$, Young's modulus $E$ and area $A$ carry a
# force along z like three springs in parallel: $k = 3 E A / L$.

# %%
result = ks.analyze(robot.assemble(), load=[0, 0, -1000, 0, 0, 0])

E, L = 210e9, 0.5  # Pa, m
A = np.pi / 4 * (0.06**2 - 0.05**2)  # m²
np.testing.assert_allclose(result.stiffness[2, 2], 3 * E * A / L, rtol=1e-9)
f"{result.stiffness[2, 2] / 1e6:.1f} N/µm"

# %% [markdown]
# A load of 1 kN presses the table down by $1000 / k$, and each actuator
# holds a third of it.

# %%
np.testing.assert_allclose(
    result.contributions["load"][2], -1000 * L / (3 * E * A), rtol=1e-9
)
unloaded = ks.analyze(robot.assemble())
more = [
    result.actuator_forces[name] - unloaded.actuator_forces[name]
    for name in result.actuator_forces
]
np.testing.assert_allclose(more, 1000 / 3, rtol=1e-9)
result

# %% [markdown]
# ## Change a value
#
# Values of the file can be changed without editing it. Pushed to the side,
# the table bends its legs: `stiffness[0, 0]` is the force along x for each
# metre, while the platform does not turn. How does that depend on the
# height?

# %%
heights = np.linspace(0.3, 1.0, 15)
sideways = []
for height in heights:
    changed = ks.load_robot(file, parameters={"height": height})
    sideways.append(ks.analyze(changed.assemble()).stiffness[0, 0])
sideways = np.array(sideways)

assert np.all(np.diff(sideways) < 0)  # the higher, the softer

# %% [markdown]
# Each leg's foot can turn about one axis, and its head about all. Along
# that axis, which is tangential, the leg is a cantilever with the stiffness
# $3 E I / L^3$, less what shear takes; across it, it swings freely. Three
# such springs, 120° apart, act along x like one and a half.

# %%
second_moment = np.pi / 64 * (0.06**4 - 0.05**4)
cantilevers = 1.5 * 3 * E * second_moment / heights**3  # N/m
assert np.all(sideways < cantilevers)
# shear matters least for long legs
assert sideways[-1] > 0.98 * cantilevers[-1]

figure, axes = plt.subplots(figsize=(6.5, 3.5), layout="constrained")
axes.plot(heights, sideways / 1e6, label="the robot")
axes.plot(
    heights, cantilevers / 1e6, "--", label="cantilevers without shear"
)
axes.set(
    xlabel="height [m]",
    ylabel="stiffness along x, not turning [N/µm]",
    yscale="log",
)
axes.grid(alpha=0.3)
axes.legend()
plt.show()
