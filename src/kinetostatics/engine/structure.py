"""Structure and parameters of a robot: the structure is the key of compiled code, the parameters are its inputs.

The data of a robot are traversed and copied with recorded parameters in place of numbers; all other data enter the key. Records
are made from the copy alone, so that they depend on key and parameters only. Numbers that are infinite, NaN or, within rounding,
0, 1 or −1 belong to the structure, which saves operations.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from functools import cached_property

import numpy as np

from kinetostatics.engine.recorder import Recorded
from kinetostatics.engine.scalars import Number, Tape
from kinetostatics.math.arrays import Array

#: Rounding error of 1, and of 0 relative to the largest entry of an array: a sine of 1e-17, say, is 0 for the structure, whatever
#: the radius of a base.
ROUNDING = 1e-14


class Structure:
    """A robot's data, separated into structure and numbers.

    Attributes:
        key: identifies the structure.
        values: (P,) the numbers of this robot.
        copy: the robot's data with recorded parameters of ``tape`` in place of the numbers.
    """

    def __init__(
        self,
        robot: object,
        tape: Tape | None = None,
        *,
        all_vary: bool = False,
    ) -> None:
        """Separate structure and numbers.

        Args:
            robot: its statics, or other data of it.
            tape: tape on which operations with the copy are recorded.
            all_vary: whether 0, 1 and −1 are parameters too, for records of robots whose numbers differ.
        """
        self._hash, self._tape = hashlib.sha256(), tape
        self._all_vary = all_vary
        self._values: list[float] = []
        self._copies: dict[int, tuple[int, Number, Number]] = {}  # by id: number, the item, which keeps its id, and its copy
        self.copy = self._copied(robot)
        self.key = self._hash.hexdigest()
        self.values: Array = np.array(self._values)

    def _add_to_key(self, *what: object) -> None:
        self._hash.update(repr(what).encode())

    def _keep(self, item: Number, copy: Number) -> None:
        self._copies[id(item)] = (len(self._copies), item, copy)

    def _copied(self, item: Number) -> Number:
        if item is None or isinstance(item, bool | int | str | np.bool_ | np.integer | Enum):
            self._add_to_key(type(item).__name__, item)
            return item
        if isinstance(item, float):
            return self._number(float(item))
        known = self._copies.get(id(item))
        if known is not None:
            self._add_to_key("again", known[0])
            return known[2]
        if isinstance(item, np.ndarray):
            copy: Number = self._array(item)
            self._keep(item, copy)
            return copy
        if isinstance(item, list | tuple):
            self._add_to_key(type(item).__name__, len(item))
            parts = [self._copied(part) for part in item]
            return type(item)(*parts) if hasattr(item, "_fields") else type(item)(parts)
        if isinstance(item, set | frozenset):
            self._add_to_key("set", sorted(map(repr, item)))
            return item
        if isinstance(item, Mapping):
            self._add_to_key("mapping", len(item))
            return {self._copied(key): self._copied(value) for key, value in item.items()}
        if not type(item).__module__.startswith("kinetostatics."):
            raise TypeError(f"{type(item)} has no structure")
        return self._object(item)

    def _object(self, item: Number) -> Number:
        kind = type(item)
        copy = object.__new__(kind)
        self._keep(item, copy)
        names = _recorded_names(item)
        self._add_to_key(kind.__qualname__, names)
        for name in names:
            object.__setattr__(copy, name, self._copied(getattr(item, name)))
        return copy

    def _number(self, value: float) -> Number:
        if (value in (0.0, 1.0, -1.0) and not self._all_vary) or not math.isfinite(value):
            self._add_to_key("constant", value)
            return value
        self._add_to_key("number")
        self._values.append(value)
        if self._tape is None:
            return value
        return self._tape.write(("parameter", len(self._values) - 1), value)

    def _array(self, array: Number) -> Number:
        if array.dtype.kind != "f":
            self._add_to_key(array.dtype.str, array.shape, array.tobytes())
            return array
        flat = np.ascontiguousarray(array, dtype=float).ravel()
        constant = ~np.isfinite(flat)
        if not self._all_vary:
            size = np.max(np.abs(flat), initial=0.0, where=~constant)
            for value, rounding in ((0.0, ROUNDING * size), (1.0, ROUNDING), (-1.0, ROUNDING)):
                plain = ~constant & (np.abs(flat - value) <= rounding)
                flat = np.where(plain, value, flat)
                constant |= plain
        self._add_to_key("array", array.shape, constant.tobytes(), flat[constant].tobytes())
        first = len(self._values)
        self._values += flat[~constant].tolist()
        if self._tape is None:
            return array
        copy = np.empty(flat.shape, dtype=object)
        copy[constant] = flat[constant]
        rest = np.flatnonzero(~constant).tolist()
        for place, number in enumerate(rest):
            copy[number] = self._tape.write(("parameter", first + place), float(flat[number]))
        return copy.reshape(array.shape).view(Recorded)


def _recorded_names(item: object) -> tuple[str, ...]:
    """Return the attributes of an object on which records may depend.

    Excluded are fields of a dataclass that are not compared, cached properties, and the names in ``NOT_RECORDED`` of a class:
    labels, places in files, data of other programs.
    """
    kind = type(item)
    if is_dataclass(item):
        own = [field.name for field in fields(item) if field.compare]
    else:
        own = [name for name in vars(item) if not isinstance(getattr(kind, name, None), cached_property)]
    return tuple(name for name in own if name not in getattr(kind, "NOT_RECORDED", ()))
