"""Indices of a workspace map: one number per pose, with its unit, from the Dataset that :func:`kinetostatics.sweep` makes.

Every index takes a Dataset and returns a DataArray over the swept dimensions with ``units`` and ``long_name``, NaN where the pose
is not valid (:func:`valid`). On a Dataset of dask arrays nothing is computed before it is needed. :data:`INDICES` lists them all.

``C`` is the compliance at o, actuators locked; ``C_dd`` its block of displacements under forces [m/N] and ``C_rr`` that of
rotations under moments [rad/(N·m)]; ``K = C⁻¹`` has the blocks ``K_dd``, ``K_rr``. Metres and radians never meet in one
eigenvalue, but for :func:`conditioning` and :func:`singularity_distance`, which first make them comparable by the Dataset's
characteristic length. "Free" means that a pure force (moment) acts and the platform may turn (move) as it likes: a quotient of
``C_dd`` (``C_rr``). "Held" means that it is kept from turning (moving): a quotient of ``K_dd`` (``K_rr``). ``C_rr`` and ``K_dd``
do not depend on where o is; ``C_dd`` and ``K_rr`` do.

On such indices in general: A. Rosyid, B. El-Khasawneh, A. Alazzam, Performance measures of parallel kinematics manipulators,
Mechanical Sciences 11 (2020). Conditioning: C. Gosselin, J. Angeles, A global performance index for the kinematic optimization of
robotic manipulators, Journal of Mechanical Design 113 (1991). Distance of a matrix to the nearest singular one: C. Eckart,
G. Young, The approximation of one matrix by another of lower rank, Psychometrika 1 (1936).
"""

from kinetostatics.exceptions import KinetostaticsError

try:
    import xarray as _xarray  # noqa: F401
except ModuleNotFoundError:
    raise KinetostaticsError("workspace maps need xarray: pip install 'kinetostatics[sweep]'") from None

from kinetostatics.indices.named import INDICES, Extreme, Index, best, names, quantity, worst
from kinetostatics.indices.poses import swept, valid
from kinetostatics.indices.sag import (
    actuator_force_maxima,
    angular_sag,
    largest_actuator_force,
    linear_sag,
    remaining_angular_sag,
    remaining_linear_sag,
)
from kinetostatics.indices.stiffness import (
    conditioning,
    deflection_any_direction,
    rotation_any_direction,
    rotational_conditioning,
    rotational_stiffness,
    singularity_distance,
    stiffness_along,
    translational_conditioning,
    translational_stiffness,
)
from kinetostatics.indices.tool_point import at_point

__all__ = [
    "INDICES",
    "Extreme",
    "Index",
    "actuator_force_maxima",
    "angular_sag",
    "at_point",
    "best",
    "conditioning",
    "deflection_any_direction",
    "largest_actuator_force",
    "linear_sag",
    "names",
    "quantity",
    "remaining_angular_sag",
    "remaining_linear_sag",
    "rotation_any_direction",
    "rotational_conditioning",
    "rotational_stiffness",
    "singularity_distance",
    "stiffness_along",
    "swept",
    "translational_conditioning",
    "translational_stiffness",
    "valid",
    "worst",
]
