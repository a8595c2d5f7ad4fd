"""Conversion of objects to values of JSON: numbers, strings, lists and dicts."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping
from enum import Enum
from typing import Any, TypeAlias

import numpy as np

Json: TypeAlias = Any  # values of json.loads and json.dumps


def plain(value: object) -> Json:
    """Return a value as JSON data: dataclasses as their fields; numbers that are not finite as None."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return attributes(value, (item.name for item in dataclasses.fields(value)))
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if isinstance(value, Enum):
        return value.name
    if isinstance(value, (np.ndarray, np.generic, float)) and not isinstance(value, np.str_):
        array = np.asarray(value)
        if array.dtype.kind == "f" and not np.all(np.isfinite(array)):
            missing = ~np.isfinite(array)
            array = array.astype(object)
            array[missing] = None
        return array.tolist()
    return value


def attributes(item: object, names: Iterable[str]) -> dict[str, Json]:
    """Return some attributes of an object as plain values."""
    return {name: plain(getattr(item, name)) for name in names}
