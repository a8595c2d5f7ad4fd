"""Checks of arguments: type, range, choice. Every error names the argument."""

from __future__ import annotations

import contextlib
import importlib.util
import operator
import os
import sys
import warnings
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, SupportsFloat, SupportsIndex, TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinetostatics.exceptions import ArgumentError, KinetostaticsError

#: Types that ``float`` accepts.
FloatLike: TypeAlias = SupportsFloat | SupportsIndex | str
#: Value of a keyword that another function checks.
Keyword: TypeAlias = Any

_HOME = os.path.dirname(__file__) + os.sep


def warn(words: str) -> None:
    """Issue a warning whose location is the line outside the package that called the package."""
    frame, level = sys._getframe(), 1
    while frame.f_back is not None and frame.f_code.co_filename.startswith(_HOME):
        frame, level = frame.f_back, level + 1
    warnings.warn(words, stacklevel=level)


def need(what: str, extra: str, *packages: str) -> None:
    """Check that the packages of an optional dependency are installed; ``what`` is the task that needs them.

    Raises:
        KinetostaticsError: a package is not installed.
    """
    for name in packages:
        if importlib.util.find_spec(name) is None:
            raise KinetostaticsError(f"{what} needs {name}: pip install 'kinetostatics[{extra}]'")


def check_mapping(what: str, value: object, example: str) -> None:
    """Raise an ArgumentError with the ``example`` if a value is not a mapping whose keys are strings."""
    if not isinstance(value, Mapping):
        raise ArgumentError(f"{what} is {value!r}; it must be a mapping from names to values, such as {example}")
    for name in value:
        if not isinstance(name, str):
            raise ArgumentError(f"{what} has the key {name!r}; keys are names, as in {example}")


def names_in(what: str, value: Iterable[object], example: str) -> tuple[str, ...]:
    """Return names as a tuple; raise an ArgumentError with the ``example`` if the value is not a sequence of strings."""
    try:
        given = None if isinstance(value, str) else tuple(value)
    except TypeError:
        given = None
    names = tuple(name for name in given or () if isinstance(name, str))
    if given is None or len(names) < len(given):
        raise ArgumentError(f"{what} is {value!r}; it must be a sequence of names, such as {example}")
    return names


def check_choice(what: str, value: object, choices: Sequence[str]) -> None:
    if not isinstance(value, str) or value not in choices:
        raise ArgumentError(f"{what} is {value!r}; it must be one of {', '.join(map(repr, choices))}")


def positive(what: str, value: FloatLike, expected: str = "a positive number", infinite: bool = False) -> float:
    """Return a positive number, finite unless ``infinite``; raise an ArgumentError for other values."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = np.nan
    if not number > 0 or (number == np.inf and not infinite):
        raise ArgumentError(f"{what} is {value!r}; it must be {expected}")
    return number


def whole_number(what: str, value: SupportsIndex | None, least: int, most: int | None = None, shown: str = "") -> int:
    """Return an integer from ``least`` to ``most``; raise an ArgumentError otherwise, with ``shown`` in place of the value."""
    number = None
    if value is not None and not isinstance(value, (bool, np.bool_)):
        with contextlib.suppress(TypeError):
            number = operator.index(value)
    if number is None or number < least or (most is not None and number > most):
        end = "on" if most is None else f"to {most}"
        raise ArgumentError(f"{what} is {shown or repr(value)}; it must be a whole number from {least} {end}")
    return number


def numbers(what: str, value: object) -> NDArray[np.float64]:
    """Return an array; raise an ArgumentError if it does not contain real numbers only."""
    array = None
    with contextlib.suppress(TypeError, ValueError):
        if not np.iscomplexobj(np.asarray(value)):  # NumPy would drop the imaginary part
            array = np.array(value, dtype=float)
    if array is None:
        raise ArgumentError(f"{what} is not an array of numbers: {value!r}")
    return array


def finite_numbers(what: str, value: object) -> NDArray[np.float64]:
    """Return an array; raise an ArgumentError if it does not contain finite real numbers only."""
    array = numbers(what, value)
    if not np.all(np.isfinite(array)):
        raise ArgumentError(f"{what} has entries that are not finite: {value!r}")
    return array


def vector(what: str, value: object, size: int) -> NDArray[np.float64]:
    """Return an array (…, size); raise an ArgumentError if it has another shape, or entries that are not finite."""
    array = finite_numbers(what, value)
    if array.ndim == 0 or array.shape[-1] != size:
        raise ArgumentError(f"{what} has the shape {array.shape}; its last axis must have {size} entries")
    return array


def path_name(what: str, value: object) -> str:
    """Return a path as a string; raise an ArgumentError for values of other types."""
    if not isinstance(value, (str, bytes, os.PathLike)):
        raise ArgumentError(f"{what} is {value!r}; it must be the path of a file")
    return os.fsdecode(value)


# ---- arguments that several functions share ---------------------------------------------------------------------------

#: Accepted words, and smallest whole numbers.
CHOICES = {"frame": ("world", "platform"), "drives": ("locked", "free"), "on_failure": ("raise", "nan")}
LEAST = {"modes": 0, "seed": 0}


def check(name: str, value: Keyword) -> Keyword:
    """Return the value of a shared argument after its check; raise an ArgumentError if it fails."""
    if name in CHOICES:
        check_choice(name, value, CHOICES[name])
        return value
    if name in LEAST:
        return whole_number(name, value, LEAST[name])
    return positive(name, value, "a positive length [m] and angle [rad]", infinite=True)
