"""Checks of arguments of public functions: type, range, choice; an invalid one is an ArgumentError that names it."""

from __future__ import annotations

import contextlib
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
Keyword: TypeAlias = Any  # value of a keyword, checked by the function to which it is passed on

_HOME = os.path.dirname(__file__) + os.sep


def warn(words: str) -> None:
    """Issue a warning that is attributed to the line, outside the package, from which the package was called."""
    frame, level = sys._getframe(), 1
    while frame.f_back is not None and frame.f_code.co_filename.startswith(_HOME):
        frame, level = frame.f_back, level + 1
    warnings.warn(words, stacklevel=level)


def need_scipy(what: str) -> None:
    """Check that SciPy, which ``what`` needs, is installed.

    Raises:
        KinetostaticsError: SciPy is not installed.
    """
    try:
        import scipy.optimize  # noqa: F401
    except ModuleNotFoundError:
        raise KinetostaticsError(f"{what} needs SciPy: pip install 'kinetostatics[optimize]'") from None


def check_mapping(what: str, value: object, example: str) -> None:
    """Check that a value is a mapping whose keys are names.

    Raises:
        ArgumentError: the value is no such mapping; the message shows ``example``.
    """
    if not isinstance(value, Mapping):
        raise ArgumentError(f"{what} is {value!r}; it must be a mapping from names to values, such as {example}")
    for name in value:
        if not isinstance(name, str):
            raise ArgumentError(f"{what} has the key {name!r}; keys are names, as in {example}")


def names_in(what: str, value: Iterable[object], example: str) -> tuple[str, ...]:
    """Return several names as a tuple.

    Raises:
        ArgumentError: the value is not a sequence of names, or is a single string; the message shows ``example``.
    """
    try:
        given = None if isinstance(value, str) else tuple(value)
    except TypeError:
        given = None
    names = tuple(name for name in given or () if isinstance(name, str))
    if given is None or len(names) < len(given):
        raise ArgumentError(f"{what} is {value!r}; it must be a sequence of names, such as {example}")
    return names


def check_choice(what: str, value: object, choices: Sequence[str]) -> None:
    """Check that a value is one of several words.

    Raises:
        ArgumentError: the value is not one of ``choices``.
    """
    if not isinstance(value, str) or value not in choices:
        raise ArgumentError(f"{what} is {value!r}; it must be one of {', '.join(map(repr, choices))}")


def positive(what: str, value: FloatLike, expected: str = "a positive number", infinite: bool = False) -> float:
    """Return a positive number; infinity is accepted if ``infinite`` is set.

    Raises:
        ArgumentError: the value is not such a number; the message contains ``expected``.
    """
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = np.nan
    if not number > 0 or (number == np.inf and not infinite):
        raise ArgumentError(f"{what} is {value!r}; it must be {expected}")
    return number


def whole_number(
    what: str, value: SupportsIndex | None, least: int, most: int | None = None, why: str = "", shown: str = ""
) -> int:
    """Return an integer (Python or NumPy) between ``least`` and ``most``.

    Raises:
        ArgumentError: the value is not such an integer; the message contains ``shown`` (the value as text) and ``why`` (the
            reason for the upper limit).
    """
    number = None
    if value is not None and not isinstance(value, (bool, np.bool_)):
        with contextlib.suppress(TypeError):
            number = operator.index(value)
    if number is None or number < least or (most is not None and number > most):
        end = "on" if most is None else f"to {most}"
        raise ArgumentError(f"{what} is {shown or repr(value)}; it must be a whole number from {least} {end}{why}")
    return number


def numbers(what: str, value: object) -> NDArray[np.float64]:
    """Return an array of numbers.

    Raises:
        ArgumentError: the value is of another type.
    """
    array = None
    with contextlib.suppress(TypeError, ValueError):
        if not np.iscomplexobj(np.asarray(value)):  # NumPy would drop the imaginary part
            array = np.array(value, dtype=float)
    if array is None:
        raise ArgumentError(f"{what} is not an array of numbers: {value!r}")
    return array


def finite_numbers(what: str, value: object) -> NDArray[np.float64]:
    """Return an array of finite numbers.

    Raises:
        ArgumentError: the value is of another type.
    """
    array = numbers(what, value)
    if not np.all(np.isfinite(array)):
        raise ArgumentError(f"{what} has entries that are not finite: {value!r}")
    return array


def path_name(what: str, value: object) -> str:
    """Return a path as a string.

    Raises:
        ArgumentError: the value is of another type.
    """
    if not isinstance(value, (str, bytes, os.PathLike)):
        raise ArgumentError(f"{what} is {value!r}; it must be the path of a file")
    return os.fsdecode(value)
