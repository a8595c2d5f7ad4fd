"""Workspace maps: many poses of a robot, and of its variants, as one labelled Dataset.

:func:`sweep` cuts the grid into blocks, has them computed (here, in other processes or by Dask), looks at the whole grid once
more (:mod:`kinetostatics.workspace.assembly_modes.repair`) and returns or stores an ``xarray.Dataset``. The page on maps
explains it.
"""

from kinetostatics.workspace.run import sweep

__all__ = ["sweep"]
