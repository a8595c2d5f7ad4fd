"""Arrays on which NumPy's functions record their scalar operations: the record. The numbers of a robot, for instance its lengths,
are parameters of the record; all other data are the robot's structure, by which compiled code is found.

Records are computed from a copy of the data with parameters in place of numbers, and therefore depend on structure and
parameters only. To save operations, numbers that are 0, 1 or −1 within rounding belong to the structure; so do infinite numbers
and NaN.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import fields, is_dataclass
from enum import Enum
from functools import cached_property

import numpy as np

from kinetostatics.engine import scalars
from kinetostatics.engine.scalars import NotRecordedError, Number, Tape
from kinetostatics.math.arrays import Array, Mask

_ELEMENTWISE: dict[object, np.ufunc] = {
    ufunc: np.frompyfunc(function, ufunc.nin, 1, identity=ufunc.identity)
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
        (np.hypot, lambda a, b: scalars.square_root(scalars.add(scalars.multiply(a, a), scalars.multiply(b, b)))),
        (np.sign, scalars.sign),
        (np.sin, scalars.sine),
        (np.cos, scalars.cosine),
        (np.arctan2, scalars.angle_of),
        (np.rint, scalars.whole),
        (np.maximum, scalars.larger),
        (np.minimum, scalars.smaller),
        (np.isnan, scalars.is_nan),
        (np.isfinite, scalars.is_finite),
        (np.logical_and, scalars.logical_and),
        (np.logical_or, scalars.logical_or),
        (np.logical_not, scalars.logical_not),
        (np.bitwise_and, scalars.logical_and),
        (np.bitwise_or, scalars.logical_or),
        (np.invert, scalars.logical_not),
        (np.greater, lambda a, b: scalars.compare(">", a, b)),
        (np.greater_equal, lambda a, b: scalars.compare(">=", a, b)),
        (np.less, lambda a, b: scalars.compare("<", a, b)),
        (np.less_equal, lambda a, b: scalars.compare("<=", a, b)),
        (np.equal, lambda a, b: scalars.compare("==", a, b)),
        (np.not_equal, lambda a, b: scalars.compare("!=", a, b)),
    )
}
#: Functions that NumPy applies to arrays of objects by the objects' operators, which is faster.
_NATIVE = {np.add, np.subtract, np.multiply, np.matmul}
_CHOOSE = np.frompyfunc(scalars.choose, 3, 1)
_WITHOUT_NAN = np.frompyfunc(scalars.without_nan, 1, 1)


class Recorded(np.ndarray[tuple[int, ...], np.dtype[np.object_]]):
    """An array of recorded scalars and constants, on which NumPy's functions record their operations."""

    def __array_ufunc__(self, ufunc: Number, method: str, *inputs: Number, **options: Number) -> Number:
        if ufunc not in _ELEMENTWISE and ufunc not in _NATIVE:
            raise NotRecordedError(f"numpy.{ufunc.__name__}")
        plain = [_plain(operand) for operand in inputs]
        out = options.pop("out", (None,))[0]
        if method == "reduce":
            result = _ELEMENTWISE[ufunc].reduce(plain[0], **options)
        elif method == "__call__":
            result = (ufunc if ufunc in _NATIVE else _ELEMENTWISE[ufunc])(*plain)
        else:
            raise NotRecordedError(f"numpy.{ufunc.__name__}.{method}")
        if out is not None and out.dtype == object:
            np.ndarray.__setitem__(out, ..., result)
            return out
        return recorded(result)  # a new array, also for an in-place operation on floats

    def __array_function__(self, function: Number, types: Number, args: Number, kwargs: Number) -> Number:
        """Apply a NumPy function. Functions of ``numpy.linalg`` cannot be recorded; others rearrange entries or apply ufuncs."""
        if function is np.linalg.norm:
            return np.sqrt(np.sum(np.square(args[0]), *args[2:], **kwargs))
        if function.__module__.startswith("numpy.linalg"):
            if scalars.by_example.get():
                return function(*[np.asarray(operand, dtype=float) for operand in args], **kwargs)
            raise NotRecordedError(f"{function.__module__}.{function.__name__}")
        if function is np.where and len(args) == 3:
            return recorded(_CHOOSE(*map(_plain, args)))
        if function is np.nan_to_num:
            return recorded(_WITHOUT_NAN(_plain(args[0])))
        if function is np.einsum:
            kwargs = {key: _plain(value) for key, value in kwargs.items() if key != "optimize"}
            return recorded(np.einsum(args[0], *map(_plain, args[1:]), **kwargs))
        return recorded(super().__array_function__(function, types, args, kwargs))


def recorded(value: Number) -> Number:
    """Return arrays of objects as :class:`Recorded`, also within tuples and lists; anything else unchanged."""
    if isinstance(value, tuple | list):
        return type(value)(map(recorded, value))
    if isinstance(value, np.ndarray) and value.dtype == object and not isinstance(value, Recorded):
        return value.view(Recorded)
    return value


def recorded_input(tape: Tape, number: int, array: Array) -> Number:
    """Return input array ``number`` of the record; ``array`` has its values at the example pose."""
    scalars = np.empty(array.size, dtype=object)
    for k, value in enumerate(array.ravel().tolist()):
        scalars[k] = tape.write(("input", number, k), value)
    return scalars.reshape(array.shape).view(Recorded)


@contextmanager
def recording() -> Iterator[None]:
    """Context manager: an error of a function that cannot be recorded is raised as :class:`NotRecordedError`."""
    try:
        with np.errstate(all="ignore"):
            yield
    except (ArithmeticError, AttributeError, IndexError, TypeError, ValueError) as error:
        raise NotRecordedError(str(error)) from error


def _plain(value: Number) -> Number:
    return value.view(np.ndarray) if isinstance(value, Recorded) else value


# ---- structure and parameters --------------------------------------------------------------------------------------

#: Difference up to which a number counts as 1 or −1; ratio to the largest entry of its array up to which it counts as 0, for
#: instance a computed sine of 1e-17.
ROUNDING = 1e-14


class Structure:
    """A robot's data, separated into structure and numbers.

    Attributes:
        key: digest of the structure.
        values: (P,) the numbers of this robot.
        copy: the robot's data, with parameters recorded on ``tape`` in place of the numbers.
    """

    def __init__(
        self, robot: object, tape: Tape | None = None, *, all_vary: bool = False, varying: Mask | None = None, whole: bool = False
    ) -> None:
        """Separate structure and numbers.

        Args:
            robot: the robot's statics, or other data of the robot.
            tape: tape of the parameters; None: the copy keeps the numbers.
            all_vary: whether 0, 1 and −1 are parameters too, for records that are evaluated with the numbers of other robots.
            varying: True for those of these parameters (P,) that vary; the copy keeps the other numbers.
            whole: whether attributes that do not influence the statics, such as outlines of sections, are copied too. Texts are
                then no part of the key, and numbers within rounding of 0, 1 and −1 are replaced by these.
        """
        self._hash, self._tape, self._all_vary, self._whole = hashlib.sha256(), tape, all_vary or varying is not None, whole
        self._varying, self._count = varying, 0
        self._values: list[float] = []
        self._copies: dict[int, tuple[int, Number, Number]] = {}  # by id: index, item (stored to keep its id), copy
        self.copy = self._copied(robot)
        self.key = self._hash.hexdigest()
        self.values: Array = np.array(self._values)

    def _add_to_key(self, *what: object) -> None:
        self._hash.update(repr(what).encode())

    def _keep(self, original: Number, copy: Number) -> None:
        self._copies[id(original)] = (len(self._copies), original, copy)

    def _copied(self, original: Number) -> Number:
        if original is None or isinstance(original, bool | int | str | np.bool_ | np.integer | Enum):
            self._add_to_key(type(original).__name__, original if not (self._whole and isinstance(original, str)) else "")
            return original
        if isinstance(original, float):
            return self._number(float(original))
        earlier = self._copies.get(id(original))
        if earlier is not None:
            self._add_to_key("again", earlier[0])
            return earlier[2]
        if isinstance(original, np.ndarray):
            copy: Number = self._array(original)
            self._keep(original, copy)
            return copy
        if isinstance(original, list | tuple):
            self._add_to_key(type(original).__name__, len(original))
            parts = [self._copied(part) for part in original]
            if self._is_kept(parts, original):
                return original
            return type(original)(*parts) if hasattr(original, "_fields") else type(original)(parts)
        if isinstance(original, set | frozenset):
            self._add_to_key("set", sorted(map(repr, original)))
            return original
        if isinstance(original, Mapping):
            self._add_to_key("mapping", len(original))
            copies = {self._copied(key): self._copied(value) for key, value in original.items()}
            return original if self._is_kept(copies.values(), original.values()) else copies
        if is_dataclass(original) or type(original).__module__.startswith("kinetostatics."):
            return self._object(original)
        if self._whole:
            return original
        raise TypeError(f"{type(original)} has no structure")

    def _object(self, original: Number) -> Number:
        """Copy the attributes of an object that may influence records.

        Not copied: cached properties, except those in ``RECORDED`` of the object's class; fields of a dataclass that are not
        compared; unless the whole is copied, attributes in ``NOT_RECORDED``, for instance labels and places in files.
        """
        kind = type(original)
        copy = object.__new__(kind)
        self._keep(original, copy)
        if is_dataclass(original):
            attributes = [field.name for field in fields(original) if field.compare]
        else:
            attributes = [name for name in vars(original) if not isinstance(getattr(kind, name, None), cached_property)]
        left_out = () if self._whole else getattr(kind, "NOT_RECORDED", ())
        names = tuple(name for name in (*attributes, *getattr(kind, "RECORDED", ())) if name not in left_out)
        self._add_to_key(kind.__qualname__, names)
        for name in names:
            vars(copy)[name] = self._copied(getattr(original, name))
        if self._is_kept(map(vars(copy).get, names), (getattr(original, name) for name in names)):
            self._copies[id(original)] = (*self._copies[id(original)][:2], original)
            return original
        if self._whole and is_dataclass(original):
            vars(copy).update({field.name: getattr(original, field.name) for field in fields(original) if not field.compare})
        return copy

    def _is_kept(self, copies: Iterable[object], originals: Iterable[object]) -> bool:
        """Whether no number in data varies, so that they need no copy."""
        return self._varying is not None and all(a is b for a, b in zip(copies, originals, strict=True))

    def _number(self, value: float) -> Number:
        if (value in (0.0, 1.0, -1.0) and not self._all_vary) or not math.isfinite(value):
            self._add_to_key("constant", value)
            return value
        self._add_to_key("number")
        self._values.append(value)
        return self._parameter(len(self._values) - 1, value)

    def _parameter(self, number: int, value: float) -> Number:
        """Return the copy of a number: a parameter, or without tape, or if it does not vary, the number itself."""
        if self._tape is None or not (self._varying is None or self._varying[number]):
            return value
        self._count += 1
        return self._tape.write(("parameter", number if self._varying is None else self._count - 1), value)

    def _array(self, array: Number) -> Number:
        if array.dtype.kind != "f":
            self._add_to_key(array.dtype.str, array.shape, array.tobytes())
            return array
        flat = np.ascontiguousarray(array, dtype=float).ravel()
        constant = ~np.isfinite(flat)
        if self._whole or not self._all_vary:
            size, plain = np.max(np.abs(flat), initial=0.0, where=~constant), np.zeros(flat.shape, dtype=bool)
            for value, rounding in ((0.0, ROUNDING * size), (1.0, ROUNDING), (-1.0, ROUNDING)):
                near = ~constant & (np.abs(flat - value) <= rounding)
                flat, plain = np.where(near, value, flat), plain | near
            if not self._all_vary:
                constant |= plain
        self._add_to_key("array", array.shape, constant.tobytes(), flat[constant].tobytes())
        first = len(self._values)
        self._values += flat[~constant].tolist()
        if self._tape is None:
            return array
        if self._varying is not None and not np.any(self._varying[first : len(self._values)]):
            return array if np.array_equal(array.ravel(), flat, equal_nan=True) else flat.reshape(array.shape)
        copy = flat.astype(object)
        varying = np.flatnonzero(~constant).tolist()
        for place, number in enumerate(varying):
            if self._varying is None or self._varying[first + place]:
                copy[number] = self._parameter(first + place, float(flat[number]))
        return copy.reshape(array.shape).view(Recorded)
