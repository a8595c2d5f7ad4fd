"""Figures for publication: ``ks.plot``.

Of the Dataset of :func:`kinetostatics.sweep`: :func:`slice`, a quantity over two coordinates in colour; :func:`surface`, as
surfaces like the paper's Figs 6, 7, 12 and 13; :func:`workspace`, on the body of the reachable poses; :func:`line`, over one
coordinate, also of :meth:`Compensation.to_dataset`. Of other results: :func:`sensitivities`, :func:`tolerances`, :func:`pareto`,
:func:`calibration`, :func:`frequency_response`, :func:`path`. All return Matplotlib's axes; :func:`save` writes them as PDF, SVG
or PNG.

All figures have units, are legible in grey and with colour blindness (cividis; lines differ in dashes and markers), and show
poses without valid numbers as hatched grey areas, with the reason in the legend.
"""

from kinetostatics.exceptions import KinetostaticsError

try:
    import matplotlib as _matplotlib  # noqa: F401
    import xarray as _xarray  # noqa: F401
except ModuleNotFoundError as error:
    name = {"matplotlib": "Matplotlib"}.get(str(error.name), error.name)
    raise KinetostaticsError(f"figures need {name}: pip install 'kinetostatics[plot]'") from None

from kinetostatics.plot.charts import calibration, frequency_response, pareto, sensitivities, tolerances
from kinetostatics.plot.lines import line, path
from kinetostatics.plot.slices import slice
from kinetostatics.plot.style import STYLE, save
from kinetostatics.plot.surfaces import surface
from kinetostatics.plot.workspaces import workspace

__all__ = [
    "STYLE",
    "calibration",
    "frequency_response",
    "line",
    "pareto",
    "path",
    "save",
    "sensitivities",
    "slice",
    "surface",
    "tolerances",
    "workspace",
]
