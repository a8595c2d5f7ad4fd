"""Sag, stiffness and actuator forces of parallel manipulators, straight from a URDF.

See ``README.md`` for an example; the method is that of Yang, Huang, Ye and Chen, Gravity-based kinetostatic modeling of parallel
manipulators using screw theory, Chinese Journal of Mechanical Engineering 36 (2023). The public names are listed in
``__init__.pyi`` and imported on first use.
"""

import lazy_loader

from kinetostatics import hooks

_lazy, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


def __getattr__(name: str) -> object:
    """Import a public name on first use; ``__version__`` is the version of the installed package."""
    if name != "__version__":
        return _lazy(name)
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("kinetostatics")
    except PackageNotFoundError:  # source folder on the path, not installed
        return "0+unknown"


def _report_of(subject: object, **options: object) -> object:
    from kinetostatics.reports import report_of

    return report_of(subject, **options)


def _robot_warnings(robot: object) -> tuple[str, ...]:
    from kinetostatics.checks.check import robot_warnings

    return robot_warnings(robot)


def _result_warnings(result: object) -> tuple[str, ...]:
    from kinetostatics.results.warnings import result_warnings

    return result_warnings(result)


def _robot_text(description: object) -> str:
    from kinetostatics.files.writer import robot_text

    return robot_text(description)


hooks.report_of, hooks.robot_text = _report_of, _robot_text
hooks.robot_warnings, hooks.result_warnings = _robot_warnings, _result_warnings
