"""The functions that xacro's expressions may call, and how much of time and memory an expansion may take."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping
from typing import TypeVar

#: Largest result: characters, digits and items, those inside others included.
MAX_SIZE = 100_000
#: Largest integer [bits].
MAX_BITS = 4000
#: What one expansion may take; an element of the file counts as ``ELEMENT``.
MAX_STEPS, ELEMENT = 1_000_000, 10

T = TypeVar("T")


class ExpressionError(Exception):
    """An expression has no value; the message says why."""


class TooMuch(ExpressionError):
    """A limit on sizes or on the work of an expansion is exceeded."""


class Steps:
    """How much an expansion may still do."""

    def __init__(self, left: int = MAX_STEPS) -> None:
        self.left = left

    def take(self, number: int) -> None:
        """Count ``number`` steps; raise if there are no more."""
        self.left -= number
        if self.left < 0:
            raise TooMuch("it grows too large or does not come to an end")

    def weigh(self, value: T) -> T:
        """Return a value; count its size, and raise if it is too large."""
        size, stack = 0, list[object]([value])
        while stack:
            item = stack.pop()
            if isinstance(item, (str, bytes)):
                size += len(item)
            elif isinstance(item, int):
                bits = item.bit_length()
                if bits > MAX_BITS:
                    raise TooMuch("an integer is too large")
                size += bits // 3
            elif isinstance(item, dict) and not hasattr(item, "unevaluated"):  # a namespace of xacro is no value
                stack.extend(dict.keys(item))
                stack.extend(dict.values(item))
            elif isinstance(item, (list, tuple, set, frozenset)):
                stack.extend(list.__iter__(item) if isinstance(item, list) else item)
            size += 1
            if size + len(stack) > MAX_SIZE:
                raise TooMuch("a text or list is too long")
        self.take(1 + size // 4)
        return value


class Function:
    """A function that expressions may call, and hand to ``map``."""

    def __init__(self, name: str, call: Callable[..., object], steps: Steps) -> None:
        self.name, self.call, self.steps = name, call, steps

    def __call__(self, *arguments: object, **named: object) -> object:
        """Call it; arguments and result are weighed."""
        self.steps.weigh([arguments, named])
        return self.steps.weigh(self.call(*arguments, **named))

    def __repr__(self) -> str:
        return f"{self.name}()"


def _round(number: float, digits: int | None = None) -> object:
    if digits is not None and abs(digits) > 300:
        raise ExpressionError("round() takes at most 300 digits")
    return round(number, digits)


def _sum(items: Iterable[float], start: float = 0) -> float:
    if not isinstance(start, (int, float)):
        raise ExpressionError("sum() adds numbers only")
    return sum(items, start)


def _small(name: str) -> Callable[..., int]:
    function = getattr(math, name)

    def call(*numbers: int) -> int:
        if max(numbers, default=0) > 400:
            raise TooMuch(f"{name}() of a number above 400")
        return int(function(*numbers))

    return call


def _range(*limits: int) -> list[int]:
    result = range(*limits)
    if len(result) > MAX_SIZE:
        raise TooMuch("a range is too long")
    return list(result)


def _isinstance(value: object, kind: object) -> bool:
    kinds = kind if isinstance(kind, tuple) else (kind,)
    return any(isinstance(item, Function) and isinstance(item.call, type) and isinstance(value, item.call) for item in kinds)


def _listed(function: Callable[..., Iterable[object]]) -> Callable[..., list[object]]:
    return lambda *arguments, **named: list(function(*arguments, **named))


def _tokenize(text: str, separators: str = ",; ", skip_empty: bool = True) -> list[str]:
    items = re.split("[" + re.escape(separators) + "]", text) if separators else [text]
    return [item for item in items if item or not skip_empty]


_PLAIN: dict[str, Callable[..., object]] = {
    **{"list": list, "dict": dict, "len": len, "str": str, "float": float, "int": int, "bool": bool},
    **{"min": min, "max": max, "map": _listed(map), "round": _round, "sorted": sorted, "range": _range},
}
_PYTHON: dict[str, Callable[..., object]] = {
    **_PLAIN,
    **{"abs": abs, "all": all, "any": any, "divmod": divmod, "frozenset": frozenset, "isinstance": _isinstance},
    **{"ord": ord, "repr": repr, "set": set, "sum": _sum, "tuple": tuple},
    **{function.__name__: _listed(function) for function in (enumerate, filter, reversed, zip)},
}


def symbols(
    steps: Steps,
    namespace: Callable[[], dict[str, object]],
    load_yaml: Callable[[str], object],
    own: Mapping[str, Callable[..., object]],
) -> dict[str, object]:
    """Return the names that expressions know from the start: functions, ``math.``, ``python.`` and ``xacro.``.

    Args:
        steps: of the expansion.
        namespace: makes an empty namespace of xacro.
        load_yaml: reads a YAML file.
        own: further functions of ``xacro.``.
    """

    def functions(table: Mapping[str, Callable[..., object]]) -> dict[str, Function]:
        return {name: Function(name, call, steps) for name, call in table.items()}

    mathematics: dict[str, object] = {}
    for name, item in vars(math).items():
        if isinstance(item, float):
            mathematics[name] = item
        elif not name.startswith("_") and callable(item):
            call = _small(name) if name in ("factorial", "comb", "perm") else item
            mathematics[name] = Function(name, call, steps)
    xacro = functions({**own, "load_yaml": load_yaml, "tokenize": _tokenize})
    result: dict[str, object] = {**mathematics, **functions(_PLAIN)}
    for name in ("load_yaml", "abs_filename", "dotify"):  # old files use them without their namespace
        result[name] = xacro[name]
    for name, table in (("math", mathematics), ("python", functions(_PYTHON)), ("xacro", xacro)):
        result[name] = space = namespace()
        dict.update(space, table)
    return result
