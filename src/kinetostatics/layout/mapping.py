"""Read-only mappings, and dataclasses, with a ``repr`` that is short even with large arrays."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, Field, fields
from itertools import islice
from typing import NoReturn, TypeVar

import numpy as np

from kinetostatics.exceptions import UnknownNameError
from kinetostatics.math.arrays import Values

Key = TypeVar("Key")
Item = TypeVar("Item")

#: Largest size of an array that is shown with all entries.
FEW = 6
#: Largest number of shown items of a mapping, and largest length of the text of an item.
MOST_ITEMS, LONGEST = 12, 150
#: Numbers up to this fraction of the largest one of an array are rounding errors and shown as 0.
NOISE = 1e-12


class ResultMapping(dict[Key, Item]):
    """A read-only dict with a short ``repr``."""

    __slots__ = ()

    def _refuse(self, *_arguments: object, **_more: object) -> NoReturn:
        raise TypeError("results and descriptions are read-only; a description has methods that return changed copies")

    __setitem__ = __delitem__ = __ior__ = clear = pop = popitem = setdefault = update = _refuse  # type: ignore[assignment]

    def __missing__(self, key: Key) -> NoReturn:
        raise UnknownNameError(key, self)

    def __reduce__(self) -> tuple[object, ...]:
        return ResultMapping, (dict(self),)

    def __repr__(self) -> str:
        lines = [f"{key!r}: {words}" if words else str(key) for key, words in shortened_items(self)]
        line = "{" + ", ".join(lines) + "}"
        return line if len(line) <= 100 else "{" + ",\n ".join(lines) + "}"

    def _repr_html_(self) -> str:
        from kinetostatics.layout.blocks import Table
        from kinetostatics.layout.renderings import block_html

        return block_html(Table.of_rows(("", ""), [(str(key), words) for key, words in shortened_items(self)]))


def shortened_items(mapping: Mapping[Key, object]) -> list[tuple[object, str]]:
    """Return the first keys, each with its item as a short text; a last row has the number of omitted items, if any."""
    shown: list[tuple[object, str]] = [(key, abbreviated(mapping[key])) for key in islice(mapping, MOST_ITEMS)]
    left = len(mapping) - len(shown)
    return [*shown, (f"… {left} more", "")] if left else shown


def abbreviated(value: object) -> str:
    """Return a short text for a value: for small arrays all numbers, for larger ones shape and range."""
    if isinstance(value, np.ndarray):
        return _array(value)
    if isinstance(value, Mapping):
        words = f"{len(value)} items: {', '.join(map(str, value))}" if value else "no items"
    elif isinstance(value, tuple):
        words = "(" + ", ".join(map(abbreviated, value)) + ")"
    else:
        words = repr(value)
    return words if len(words) <= LONGEST else words[: LONGEST - 2] + " …"


def _array(array: Values) -> str:
    finite = array[np.isfinite(array)] if array.dtype.kind in "fc" else array.ravel()
    if array.size <= FEW and array.ndim <= 1:
        noise = NOISE * max((abs(number) for number in finite.tolist()), default=0.0) if array.dtype.kind == "f" else 0
        numbers = ["0" if abs(number) <= noise else f"{number:.6g}" for number in array.ravel().tolist()]
        return f"[{', '.join(numbers)}]" if array.ndim else numbers[0]
    words = f"array {array.shape}"
    if not array.size:
        return words
    return f"{words}, {finite.min():.6g} to {finite.max():.6g}" if finite.size else f"{words}, no finite number"


class ShortRepr:
    """Base of dataclasses with ``repr=False``: the ``repr`` has the fields that differ from their defaults, abbreviated."""

    def __repr__(self) -> str:
        shown = [
            f"{field.name}={abbreviated(getattr(self, field.name))}"
            for field in fields(self)  # type: ignore[arg-type]
            if field.repr and not _is_default(field, getattr(self, field.name))
        ]
        return f"{type(self).__name__}({', '.join(shown)})"


def _is_default(field: Field[object], value: object) -> bool:
    """Whether a field has its default value; always True for a field with a default and ``compare=False``."""
    default = field.default_factory() if field.default_factory is not MISSING else field.default
    if isinstance(value, np.ndarray):
        return default is not MISSING and np.array_equal(value, np.asarray(default))
    return default is not MISSING and (not field.compare or bool(value == default))
