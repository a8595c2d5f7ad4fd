"""Structure and parameters of a robot: the structure is the key of compiled code, the parameters are its inputs.

This module traverses the data of a robot and copies it with recorded parameters in place of numbers; all other data traversed
enter the key. A record is made from the copy alone, so that it cannot depend on anything outside key and parameters. Numbers that
are infinite, NaN or, within rounding, 0, 1 or −1 belong to the structure: they save operations.
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

#: What is nothing but rounding, of 1 and beside the largest entry of an array: else each radius of a base, whose angles have
#: sines of 0 or 1e-17, would have a structure of its own.
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
        """Take data apart.

        Args:
            robot: its statics, or other data of it.
            tape: what is to record what is done with the copy.
            all_vary: 0, 1 and −1 are numbers like others, because a robot that differs a little has other ones there.
        """
        self._hash, self._tape = hashlib.sha256(), tape
        self._all_vary = all_vary
        self._values: list[float] = []
        self._copies: dict[int, tuple[int, Number, Number]] = {}  # by id: number, the item, which keeps its id, and its copy
        self.copy = self._taken(robot)
        self.key = self._hash.hexdigest()
        self.values: Array = np.array(self._values)

    def _say(self, *what: object) -> None:
        self._hash.update(repr(what).encode())

    def _keep(self, item: Number, copy: Number) -> None:
        self._copies[id(item)] = (len(self._copies), item, copy)

    def _taken(self, item: Number) -> Number:
        if item is None or isinstance(item, bool | int | str | np.bool_ | np.integer | Enum):
            self._say(type(item).__name__, item)
            return item
        if isinstance(item, float):
            return self._number(float(item))
        known = self._copies.get(id(item))
        if known is not None:
            self._say("again", known[0])
            return known[2]
        if isinstance(item, np.ndarray):
            copy: Number = self._array(item)
            self._keep(item, copy)
            return copy
        if isinstance(item, list | tuple):
            self._say(type(item).__name__, len(item))
            parts = [self._taken(part) for part in item]
            return type(item)(*parts) if hasattr(item, "_fields") else type(item)(parts)
        if isinstance(item, set | frozenset):
            self._say("set", sorted(map(repr, item)))
            return item
        if isinstance(item, Mapping):
            self._say("mapping", len(item))
            return {self._taken(key): self._taken(value) for key, value in item.items()}
        if not type(item).__module__.startswith("kinetostatics."):
            raise TypeError(f"{type(item)} has no structure")
        return self._object(item)

    def _object(self, item: Number) -> Number:
        kind = type(item)
        copy = object.__new__(kind)
        self._keep(item, copy)
        names = _recorded_names(item)
        self._say(kind.__qualname__, names)
        for name in names:
            object.__setattr__(copy, name, self._taken(getattr(item, name)))
        return copy

    def _number(self, value: float) -> Number:
        if (value in (0.0, 1.0, -1.0) and not self._all_vary) or not math.isfinite(value):
            self._say("constant", value)
            return value
        self._say("number")
        self._values.append(value)
        if self._tape is None:
            return value
        return self._tape.write(("parameter", len(self._values) - 1), value)

    def _array(self, array: Number) -> Number:
        if array.dtype.kind != "f":
            self._say(array.dtype.str, array.shape, array.tobytes())
            return array
        flat = np.ascontiguousarray(array, dtype=float).ravel()
        constant = ~np.isfinite(flat)
        if not self._all_vary:
            size = np.max(np.abs(flat), initial=0.0, where=~constant)
            for value, rounding in ((0.0, ROUNDING * size), (1.0, ROUNDING), (-1.0, ROUNDING)):
                plain = ~constant & (np.abs(flat - value) <= rounding)
                flat = np.where(plain, value, flat)
                constant |= plain
        self._say("array", array.shape, constant.tobytes(), flat[constant].tobytes())
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
    """Return the attributes of an object that records may depend on.

    Left out are fields of a dataclass that are not compared, what is computed when it is asked for, and what a class calls
    ``NOT_RECORDED``: labels, places in files, other programs' data.
    """
    kind = type(item)
    if is_dataclass(item):
        own = [field.name for field in fields(item) if field.compare]
    else:
        own = [name for name in vars(item) if not isinstance(getattr(kind, name, None), cached_property)]
    return tuple(name for name in own if name not in getattr(kind, "NOT_RECORDED", ()))
