"""Figures of workspace maps for publication, from the Dataset that :func:`kinetostatics.sweep` makes: ``ks.plot``.

:func:`slice` shows a quantity over two coordinates in colour, :func:`surface` as surfaces like the paper's Figs 6, 7, 12 and
13, :func:`workspace` on the body of the poses that are reached, and :func:`line` over one coordinate;
:func:`sensitivities`, :func:`spread`, :func:`optimum`, :func:`pareto`, :func:`calibration` and :func:`compensation` draw what
:func:`kinetostatics.sensitivities`, :func:`kinetostatics.spread`, :func:`kinetostatics.optimize`, :func:`kinetostatics.pareto`,
:func:`kinetostatics.calibrate` and :func:`kinetostatics.compensate` find. All of them return Matplotlib's axes; :func:`save`
writes them as PDF, SVG or PNG.

Every figure names its units, reads in grey and by the colour-blind (the map is cividis, lines differ in dashes and markers), and
shows poses without valid numbers in grey and hatched, with the reason in its legend.
"""

from kinetostatics.exceptions import KinetostaticsError

try:
    import matplotlib as _matplotlib  # noqa: F401
    import xarray as _xarray  # noqa: F401
except ModuleNotFoundError as error:
    name = {"matplotlib": "Matplotlib"}.get(str(error.name), error.name)
    raise KinetostaticsError(f"figures need {name}: pip install 'kinetostatics[plot]'") from None

from kinetostatics.plot.bars import sensitivities
from kinetostatics.plot.calibrations import calibration
from kinetostatics.plot.compensations import compensation
from kinetostatics.plot.fronts import pareto
from kinetostatics.plot.histogram import spread
from kinetostatics.plot.lines import line
from kinetostatics.plot.optima import optimum
from kinetostatics.plot.slices import slice
from kinetostatics.plot.style import STYLE, save
from kinetostatics.plot.surfaces import surface
from kinetostatics.plot.workspaces import workspace

__all__ = [
    "STYLE",
    "calibration",
    "compensation",
    "line",
    "optimum",
    "pareto",
    "save",
    "sensitivities",
    "slice",
    "spread",
    "surface",
    "workspace",
]
