"""Indices of a workspace map: one number per pose, with its unit, from the Dataset of :func:`kinetostatics.sweep`.

:func:`quantity` returns an index, or any other number of the poses, as a DataArray over the swept dimensions with ``units`` and
``long_name``, NaN where the pose is not valid (:func:`valid`). For a Dataset of dask arrays, the computation is lazy.
:data:`INDICES` lists the indices; their formulas are in :mod:`kinetostatics.measures`.
"""

from kinetostatics.exceptions import KinetostaticsError

try:
    import xarray as _xarray  # noqa: F401
except ModuleNotFoundError:
    raise KinetostaticsError("workspace maps need xarray: pip install 'kinetostatics[sweep]'") from None

from kinetostatics.indices.map_variables import at_point, swept, valid
from kinetostatics.indices.named import INDICES, Extreme, best, names, quantity, stiffness_along, worst
from kinetostatics.measures import Measure

__all__ = ["INDICES", "Extreme", "Measure", "at_point", "best", "names", "quantity", "stiffness_along", "swept", "valid", "worst"]
