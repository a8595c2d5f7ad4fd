"""Records: lists of the scalar operations that a NumPy function performs for one pose, the example. A guard is the condition of a
branch; a record is valid at poses at which all guards have the same value as at the example.

The function is called with arrays of :class:`Scalar` in place of floats. Every scalar has a value at the example, which decides
branches. Functions that are not sequences of scalar operations (singular values, eigenvectors) raise an error.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any, TypeAlias

import numpy as np

Number: TypeAlias = Any  # a Scalar, a float, an array of Scalars or floats, or a container of arrays
#: Name and operands.
Operation: TypeAlias = tuple[Number, ...]
#: Operations without operands; their name is followed by the input array and component, the parameter, or the value.
LEAVES = ("input", "parameter", "constant", "truth")


class NotRecordedError(Exception):
    """A function is not a sequence of scalar operations."""


by_example: ContextVar[bool] = ContextVar("by_example", default=False)


@contextmanager
def deciding_by_example() -> Iterator[None]:
    """Context manager: values at the example decide branches without guards, and replace recorded numbers converted to floats.

    For the choice of what is drawn and of its form, which are those of the example at all poses.
    """
    token = by_example.set(True)
    try:
        yield
    finally:
        by_example.reset(token)


class Tape:
    """Scalar operations in the order in which they were recorded; equal operations are stored once.

    Attributes:
        operations: name and operands of each operation. Operands are indices of earlier operations, except in :data:`LEAVES`.
        values: result of each operation at the example.
        guards: value at the example of each truth value on which a branch depends, by the index of its operation.
    """

    def __init__(self) -> None:
        self.operations: list[Operation] = []
        self.values: list[float | bool] = []
        self.guards: dict[int, bool] = {}
        self._known: dict[Operation, Scalar] = {}

    def write(self, operation: Operation, value: float | bool) -> Scalar:
        """Return the scalar of an operation; record it if no equal one exists. ``value`` is the result at the example."""
        scalar = self._known.get(operation)
        if scalar is None:
            scalar = Scalar(self, len(self.operations), value)
            self.operations.append(operation)
            self.values.append(value)
            self._known[operation] = scalar
        return scalar

    def holds(self) -> Number:
        """Whether all guards recorded so far are met: a recorded truth value, or True if there are no guards."""
        met: Number = True
        for number, expected in self.guards.items():
            guard = Scalar(self, number, self.values[number])
            met = logical_and(met, guard if expected else logical_not(guard))
        return met

    def number_of(self, scalar: Number) -> int:
        """Return the index of a scalar's operation; for a constant, an operation is added."""
        if isinstance(scalar, Scalar):
            return scalar.number
        if isinstance(scalar, bool | np.bool_):
            return self.write(("truth", bool(scalar)), bool(scalar)).number
        value = float(scalar)
        # the text distinguishes −0 from 0, and makes all NaN equal
        return self.write(("constant", value.hex()), value).number


def needed_by(tape: Tape, outputs: Iterable[int]) -> list[bool]:
    """True for the operations ``outputs`` (indices) and for all operations on which they depend."""
    needed = [False] * len(tape.operations)
    for number in outputs:
        needed[number] = True
    for number in range(len(needed) - 1, -1, -1):
        if needed[number]:
            for operand in operands(tape.operations[number]):
                needed[operand] = True
    return needed


def operands(operation: Operation) -> tuple[int, ...]:
    """Return the indices of the operations whose results an operation uses."""
    return () if operation[0] in LEAVES else operation[1:]


class Scalar:
    """Result of a recorded operation: a number or a truth value.

    Attributes:
        tape, number: the tape, and the index of the operation on it.
        value: result at the example.
    """

    __slots__ = ("number", "tape", "value")

    def __init__(self, tape: Tape, number: int, value: float | bool) -> None:
        self.tape, self.number, self.value = tape, number, value

    def __repr__(self) -> str:
        return f"<Scalar {self.number}: {self.value!r}>"

    def __bool__(self) -> bool:
        """Return the truth value at the example, and record it as a guard."""
        if not isinstance(self.value, bool):
            return bool(compare("!=", self, 0.0))
        if not by_example.get():
            self.tape.guards[self.number] = self.value
        return self.value

    def __float__(self) -> float:
        if by_example.get():
            return float(self.value)
        raise NotRecordedError("a recorded number is converted to a float")

    def __pow__(self, other: Number) -> Number:
        return power(self, other)

    def __neg__(self) -> Number:
        return negative(self)

    def __pos__(self) -> Number:
        return self

    def __abs__(self) -> Number:
        return absolute(self)

    def __invert__(self) -> Number:
        return logical_not(self)

    def sqrt(self) -> Number:
        """Return the square root, as numpy.sqrt computes it of objects."""
        return square_root(self)


def _is_plain(value: Number, number: float) -> bool:
    return not isinstance(value, Scalar) and value == number


def _joined(name: str, a: Number, b: Number, value: float, swaps: bool = False) -> Scalar:
    tape: Tape = a.tape if isinstance(a, Scalar) else b.tape
    first, second = tape.number_of(a), tape.number_of(b)
    if swaps and second < first:
        first, second = second, first
    return tape.write((name, first, second), value)


def value_of(a: Number) -> Number:
    """Return a scalar's value at the example; a constant unchanged."""
    return a.value if isinstance(a, Scalar) else a


def _quotient(a: float, b: float) -> float:
    with np.errstate(all="ignore"):
        return float(np.float64(a) / np.float64(b))


def add(a: Number, b: Number) -> Number:
    if not isinstance(a, Scalar) and not isinstance(b, Scalar):
        return a + b
    if _is_plain(a, 0.0):
        return b
    if _is_plain(b, 0.0):
        return a
    return _joined("add", a, b, value_of(a) + value_of(b), swaps=True)


def subtract(a: Number, b: Number) -> Number:
    if not isinstance(a, Scalar) and not isinstance(b, Scalar):
        return a - b
    if _is_plain(b, 0.0):
        return a
    if _is_plain(a, 0.0):
        return negative(b)
    return _joined("subtract", a, b, value_of(a) - value_of(b))


def multiply(a: Number, b: Number) -> Number:
    if not isinstance(a, Scalar) and not isinstance(b, Scalar):
        return a * b
    for factor, other in ((a, b), (b, a)):
        if not isinstance(factor, Scalar):
            if factor == 0:
                return 0.0
            if factor == 1:
                return other
            if factor == -1:
                return negative(other)
    return _joined("multiply", a, b, value_of(a) * value_of(b), swaps=True)


def divide(a: Number, b: Number) -> Number:
    """Return a / b as a · (1 / b): the reciprocal is recorded once for all divisions by b."""
    if not isinstance(a, Scalar) and not isinstance(b, Scalar):
        return _quotient(a, b)
    if _is_plain(a, 0.0):
        return 0.0
    if not isinstance(b, Scalar):
        return multiply(a, _quotient(1.0, b))
    return multiply(a, b.tape.write(("divide", b.tape.number_of(1.0), b.number), _quotient(1.0, b.value)))


def negative(a: Number) -> Number:
    if not isinstance(a, Scalar):
        return -a
    operation = a.tape.operations[a.number]
    if operation[0] == "negative":
        return a.tape.write(a.tape.operations[operation[1]], a.tape.values[operation[1]])
    return a.tape.write(("negative", a.number), -a.value)


def power(a: Number, n: Number) -> Number:
    """Return aⁿ; a recorded ``a`` needs an integer n ≥ 0."""
    if not isinstance(a, Scalar):
        return a**n
    if _is_plain(n, 0):
        return 1.0
    if isinstance(n, Scalar) or n != int(n) or n < 1:
        raise NotRecordedError(f"a power of {n!r}")
    product, square, left = None, a, int(n)
    while left:
        if left & 1:
            product = square if product is None else multiply(product, square)
        left >>= 1
        square = multiply(square, square) if left else square
    return product


def square_root(a: Number) -> Number:
    """Return √a, NaN for a < 0."""
    if not isinstance(a, Scalar):
        return math.sqrt(a) if a >= 0 else math.nan
    return a.tape.write(("square_root", a.number), math.sqrt(a.value) if a.value >= 0 else math.nan)


def _function(name: str, function: Callable[[float], float]) -> Callable[[Number], Number]:
    """Return a function like ``function``, whose application to a scalar is recorded as operation ``name``."""

    def of(a: Number) -> Number:
        if not isinstance(a, Scalar):
            return function(a)
        return a.tape.write((name, a.number), function(a.value) if math.isfinite(a.value) else math.nan)

    return of


sine = _function("sine", math.sin)
cosine = _function("cosine", math.cos)
whole = _function("whole", lambda a: float(round(a)))


def angle_of(y: Number, x: Number) -> Number:
    """Return atan2(y, x)."""
    value = math.atan2(value_of(y), value_of(x))
    return _joined("angle", y, x, value) if isinstance(y, Scalar) or isinstance(x, Scalar) else value


def absolute(a: Number) -> Number:
    return a.tape.write(("absolute", a.number), abs(a.value)) if isinstance(a, Scalar) else abs(a)


def sign(a: Number) -> Number:
    if isinstance(a, Scalar):
        return choose(compare(">", a, 0.0), 1.0, choose(compare("<", a, 0.0), -1.0, 0.0))
    return float(np.sign(a))


_COMPARISONS: dict[str, Callable[[Number, Number], Number]] = {
    ">": operator.gt,
    ">=": operator.ge,
    "<": operator.lt,
    "<=": operator.le,
    "==": operator.eq,
    "!=": operator.ne,
}


def compare(how: str, a: Number, b: Number) -> Number:
    """Return whether ``a`` and ``b`` fulfil the comparison ``how``, for instance ">="."""
    value = bool(_COMPARISONS[how](value_of(a), value_of(b)))
    if not isinstance(a, Scalar) and not isinstance(b, Scalar):
        return value
    return _joined(how, a, b, value)


def logical_and(a: Number, b: Number) -> Number:
    return _logical("and", True, a, b, bool(value_of(a)) and bool(value_of(b)))


def logical_or(a: Number, b: Number) -> Number:
    return _logical("or", False, a, b, bool(value_of(a)) or bool(value_of(b)))


def _logical(name: str, neutral: bool, a: Number, b: Number, value: bool) -> Number:
    a, b = _truth(a), _truth(b)
    for operand, other in ((a, b), (b, a)):
        if not isinstance(operand, Scalar):
            return other if bool(operand) is neutral else not neutral
    return a if a is b else _joined(name, a, b, value, swaps=True)


def _truth(a: Number) -> Number:
    """Return a ≠ 0 for a number, a truth value unchanged; parameters count as ≠ 0."""
    if not isinstance(a, Scalar):
        return bool(a)
    if isinstance(a.value, bool):
        return a
    return True if a.tape.operations[a.number][0] == "parameter" else compare("!=", a, 0.0)


def logical_not(a: Number) -> Number:
    a = _truth(a)
    return a.tape.write(("not", a.number), not a.value) if isinstance(a, Scalar) else not a


def choose(condition: Number, a: Number, b: Number) -> Number:
    """Return ``a`` where the condition is true, else ``b``."""
    condition = _truth(condition)
    if not isinstance(condition, Scalar):
        return a if condition else b
    if a is b:
        return a
    if isinstance(value_of(a), bool | np.bool_) and isinstance(value_of(b), bool | np.bool_):
        return logical_or(logical_and(condition, a), logical_and(logical_not(condition), b))
    tape = condition.tape
    numbers = condition.number, tape.number_of(a), tape.number_of(b)
    return tape.write(("choose", *numbers), value_of(a) if condition.value else value_of(b))


def larger(a: Number, b: Number) -> Number:
    """Return the larger number; NaN if a or b is NaN."""
    return choose(logical_or(compare(">", a, b), is_nan(a)), a, b)


def smaller(a: Number, b: Number) -> Number:
    """Return the smaller number; NaN if a or b is NaN."""
    return choose(logical_or(compare("<", a, b), is_nan(a)), a, b)


def is_nan(a: Number) -> Number:
    return compare("!=", a, a)


def is_finite(a: Number) -> Number:
    return compare("<", absolute(a), math.inf)


def without_nan(a: Number) -> Number:
    """Return a; 0 if a is NaN."""
    return choose(is_nan(a), 0.0, a)


def _operator(function: Callable[[Number, Number], Number], swapped: bool) -> Callable[[Scalar, Number], Number]:
    """Return a method of :class:`Scalar`: ``function`` of (scalar, other), if ``swapped`` of (other, scalar).

    If the other operand is an array, NumPy calls the method entry by entry.
    """

    def of(scalar: Scalar, other: Number) -> Number:
        if isinstance(other, np.ndarray):
            return NotImplemented
        return function(other, scalar) if swapped else function(scalar, other)

    return of


for _name, _of in (
    ("add", add),
    ("sub", subtract),
    ("mul", multiply),
    ("truediv", divide),
    ("or", logical_or),
    ("and", logical_and),
    *((name, lambda a, b, how=how: compare(how, a, b)) for name, how in (("lt", "<"), ("le", "<="), ("gt", ">"), ("ge", ">="))),
):
    setattr(Scalar, f"__{_name}__", _operator(_of, swapped=False))
    setattr(Scalar, f"__r{_name}__", _operator(_of, swapped=True))
