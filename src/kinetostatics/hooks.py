"""Functions that lower layers call and upper layers define: :mod:`kinetostatics` sets them when it is imported."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any


def _undefined(*arguments: object, **options: object) -> Any:
    raise RuntimeError("import kinetostatics first")


#: Makes the report of an object, with options of this report.
report_of: Callable[..., Any] = _undefined
#: Return the warnings about a robot, and about a result.
robot_warnings: Callable[[Any], tuple[str, ...]] = _undefined
result_warnings: Callable[[Any], tuple[str, ...]] = _undefined
#: Returns the text of a description's robot file.
robot_text: Callable[[Any], str] = _undefined
