"""Arrays of recorded scalars: NumPy's functions applied to them are recorded operation by operation."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import numpy as np

from kinetostatics.engine import scalars
from kinetostatics.engine.scalars import NotRecordedError

_ELEMENTWISE: dict[object, np.ufunc] = {
    ufunc: np.frompyfunc(function, ufunc.nin, 1)
    for ufunc, function in (
        (np.add, scalars.add),
        (np.subtract, scalars.subtract),
        (np.multiply, scalars.multiply),
        (np.divide, scalars.divide),
        (np.negative, scalars.negative),
        (np.power, scalars.power),
        (np.square, lambda a: scalars.multiply(a, a)),
        (np.sqrt, scalars.square_root),
        (np.absolute, scalars.absolute),
        (np.sign, scalars.sign),
        (np.sin, scalars.sine),
        (np.cos, scalars.cosine),
        (np.arctan2, scalars.angle_of),
        (np.rint, scalars.whole),
        (np.maximum, scalars.larger),
        (np.minimum, scalars.smaller),
        (np.isnan, scalars.is_nan),
        (np.isfinite, scalars.is_finite),
        (np.logical_and, scalars.both),
        (np.logical_or, scalars.either),
        (np.logical_not, scalars.opposite),
        (np.bitwise_and, scalars.both),
        (np.bitwise_or, scalars.either),
        (np.invert, scalars.opposite),
        (np.greater, lambda a, b: scalars.compare(">", a, b)),
        (np.greater_equal, lambda a, b: scalars.compare(">=", a, b)),
        (np.less, lambda a, b: scalars.compare("<", a, b)),
        (np.less_equal, lambda a, b: scalars.compare("<=", a, b)),
        (np.equal, lambda a, b: scalars.compare("==", a, b)),
        (np.not_equal, lambda a, b: scalars.compare("!=", a, b)),
    )
}
#: For arrays of objects NumPy itself calls the operators of these functions, which is faster.
_NATIVE = {np.add, np.subtract, np.multiply, np.matmul}
_CHOOSE = np.frompyfunc(scalars.choose, 3, 1)
_WITHOUT_NAN = np.frompyfunc(scalars.without_nan, 1, 1)


class Recorded(np.ndarray[tuple[int, ...], np.dtype[np.object_]]):
    """An array of recorded scalars and constants, on which NumPy's functions record their operations."""

    def __array_ufunc__(
        self, ufunc: scalars.Number, method: str, *inputs: scalars.Number, **options: scalars.Number
    ) -> scalars.Number:
        """Apply a ufunc scalar by scalar."""
        if ufunc not in _ELEMENTWISE and ufunc not in _NATIVE:
            raise NotRecordedError(f"numpy.{ufunc.__name__}")
        plain = [_plain(item) for item in inputs]
        out = options.pop("out", (None,))[0]
        if method == "reduce":
            found = _reduced(_ELEMENTWISE[ufunc], plain[0], ufunc.identity, **options)
        elif method == "__call__":
            found = (ufunc if ufunc in _NATIVE else _ELEMENTWISE[ufunc])(*plain)
        else:
            raise NotRecordedError(f"numpy.{ufunc.__name__}.{method}")
        if out is not None and out.dtype == object:
            np.ndarray.__setitem__(out, ..., found)
            return out
        return recorded(found)  # replaces an array of floats as the result of an operation in place

    def __array_function__(
        self, function: scalars.Number, types: scalars.Number, args: scalars.Number, kwargs: scalars.Number
    ) -> scalars.Number:
        """Apply a function of NumPy, most of which rearrange entries or apply ufuncs."""
        if function.__module__.startswith("numpy.linalg"):
            raise NotRecordedError(f"{function.__module__}.{function.__name__}")
        if function is np.where and len(args) == 3:
            return recorded(_CHOOSE(*map(_plain, args)))
        if function is np.nan_to_num:
            return recorded(_WITHOUT_NAN(_plain(args[0])))
        if function is np.einsum:
            kwargs = {key: _plain(value) for key, value in kwargs.items() if key != "optimize"}
            return recorded(np.einsum(args[0], *map(_plain, args[1:]), **kwargs))
        return recorded(super().__array_function__(function, types, args, kwargs))


def recorded(found: scalars.Number) -> scalars.Number:
    """Return an array of objects, or each array in a tuple or list, as a recorded array."""
    if isinstance(found, tuple | list):
        return type(found)(map(recorded, found))
    if isinstance(found, np.ndarray) and found.dtype == object and not isinstance(found, Recorded):
        return found.view(Recorded)
    return found


@contextmanager
def recording() -> Iterator[None]:
    """Turn errors of functions that cannot be recorded into one error, as context manager.

    Raises:
        NotRecordedError: a function needs floats in place of recorded scalars.
    """
    try:
        with np.errstate(all="ignore"):
            yield
    except (ArithmeticError, AttributeError, IndexError, TypeError, ValueError) as error:
        raise NotRecordedError(str(error)) from error


def _plain(item: scalars.Number) -> scalars.Number:
    return item.view(np.ndarray) if isinstance(item, Recorded) else item


def _reduced(
    function: scalars.Number,
    array: scalars.Number,
    identity: scalars.Number,
    axis: int | tuple[int, ...] | None = 0,
    keepdims: bool = False,
    initial: scalars.Number = None,
    **_: scalars.Number,
) -> scalars.Number:
    """Reduce an array along some axes, in order."""
    axes: Sequence[int] = range(array.ndim) if axis is None else (axis,) if isinstance(axis, int) else axis
    axes = sorted(k % array.ndim for k in axes)
    first = identity if initial is None or initial is np._NoValue else initial
    result = array
    for k in reversed(axes):
        rows = list(np.moveaxis(result, k, 0))
        if not rows:
            result = np.full(tuple(n for j, n in enumerate(result.shape) if j != k), first, dtype=object)
            continue
        result = rows[0]
        for row in rows[1:]:
            result = function(result, row)
    if initial is not None and initial is not np._NoValue:
        result = function(first, result)
    if keepdims:
        result = np.asarray(result, dtype=object).reshape([1 if k in axes else n for k, n in enumerate(array.shape)])
    return result
