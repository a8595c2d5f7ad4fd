"""Figures for publication: ``ks.plot``.

A quantity of a map (:func:`kinetostatics.sweep`) is drawn over two coordinates by :func:`slice`, in colour, and :func:`surface`,
like the paper's Figs 6, 7, 12 and 13; over three by :func:`workspace`, on the body of valid poses; over one by :func:`line`,
which also draws :meth:`Compensation.to_dataset`. Other results are drawn by :func:`sensitivities`, :func:`tolerances`,
:func:`pareto`, :func:`calibration`, :func:`capacity`, :func:`frequency_response` and :func:`path`. All functions return
Matplotlib's axes; :func:`save` writes them as PDF, SVG or PNG.

All figures have units, and are legible in grey and with colour blindness (cividis; lines differ in dashes and markers). Poses
without valid numbers are hatched grey areas; the legend gives the reason.
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
from kinetostatics.plot.polar import capacity
from kinetostatics.plot.slices import slice
from kinetostatics.plot.style import STYLE, save
from kinetostatics.plot.surfaces import surface, workspace

__all__ = [
    "STYLE",
    "calibration",
    "capacity",
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
