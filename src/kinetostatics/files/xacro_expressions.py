"""Xacro's expressions ``${…}``, computed here and not by Python.

Xacro hands them to ``eval``, from which files can be read and code be run, and which may compute for ever. Here they
are a small part of Python: numbers, strings, lists and dicts, operators, comprehensions, xacro's functions, and methods that
only look. Every step and the size of every result count towards :class:`Steps`, so that each expansion comes to an end.
"""

from __future__ import annotations

import ast
import math
import operator
import re
import warnings
from collections.abc import Callable, Iterable, Mapping
from functools import lru_cache
from typing import Any

#: Longest expression, and longest text around expressions [characters].
MAX_EXPRESSION, MAX_TEXT = 10_000, 100_000
#: Largest result: characters, digits and items, those inside others included.
MAX_SIZE = 100_000
#: Largest integer [bits].
MAX_BITS = 4000
#: What one expansion may take; an element of the file counts as ``ELEMENT``.
MAX_STEPS, ELEMENT = 1_000_000, 10


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

    def weigh(self, value: Any) -> Any:
        """Return a value; count its size, and raise if it is too large."""
        size, stack = 0, [value]
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


# ---- functions -------------------------------------------------------------------------------------------------------------


def _round(number: float, digits: int | None = None) -> object:
    if digits is not None and abs(digits) > 300:
        raise ExpressionError("round() takes at most 300 digits")
    return round(number, digits)


def _sum(items: Iterable[Any], start: float = 0) -> Any:
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


def _listed(function: Callable[..., Iterable[Any]]) -> Callable[..., list[Any]]:
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
    steps: Steps, namespace: Callable[[], object], load_yaml: Callable[[str], object], own: Mapping[str, Callable[..., object]]
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
    result: dict[str, Any] = {**mathematics, **functions(_PLAIN)}
    for name in ("load_yaml", "abs_filename", "dotify"):  # old files use them without their namespace
        result[name] = xacro[name]
    for name, table in (("math", mathematics), ("python", functions(_PYTHON)), ("xacro", xacro)):
        result[name] = namespace()
        dict.update(result[name], table)
    return result


# ---- methods ---------------------------------------------------------------------------------------------------------------

_METHODS: dict[type, frozenset[str]] = {
    str: frozenset(
        "capitalize casefold count endswith find index isalnum isalpha isdecimal isdigit islower isnumeric isspace istitle "
        "isupper join lower lstrip partition removeprefix removesuffix replace rfind rindex rpartition rsplit rstrip split "
        "splitlines startswith strip swapcase title upper".split()
    ),
    list: frozenset(("count", "index", "copy")),
    tuple: frozenset(("count", "index")),
    dict: frozenset(("get", "keys", "values", "items", "copy")),
    float: frozenset(("is_integer",)),
    int: frozenset(("bit_length",)),
}


def _method(value: Any, name: str) -> Callable[..., Any] | None:
    for kind, names in _METHODS.items():
        if isinstance(value, kind) and name in names:
            return getattr(kind, name).__get__(value)  # type: ignore[no-any-return]
    return None


def _check_method(value: Any, name: str, arguments: list[Any]) -> None:
    """Refuse what would give a huge text, before it is there."""
    size = 0
    if name == "join" and len(arguments) == 1 and isinstance(arguments[0], (list, tuple, set, dict)):
        size = len(value) * len(arguments[0])
    elif name == "replace" and len(arguments) >= 2 and all(isinstance(item, str) for item in arguments[:2]):
        size = value.count(arguments[0]) * len(arguments[1])
    if size > MAX_SIZE:
        raise TooMuch("a text is too long")


# ---- operators -------------------------------------------------------------------------------------------------------------


def _multiply(a: Any, b: Any) -> Any:
    for sequence, times in ((a, b), (b, a)):
        if isinstance(sequence, (str, bytes, list, tuple)) and isinstance(times, int) and times * len(sequence) > MAX_SIZE:
            raise TooMuch("a text or list is too long")
    return a * b


def _power(a: Any, b: Any) -> Any:
    if isinstance(a, int) and isinstance(b, int) and b > 0 and a.bit_length() * b > MAX_BITS:
        raise TooMuch("an integer is too large")
    result = a**b
    if isinstance(result, complex):
        raise ExpressionError("a power of a negative number")
    return result


def _modulo(a: Any, b: Any) -> Any:
    if isinstance(a, str) and re.search(r"\d{4}|\*", a):
        raise TooMuch("a width in a format is too large")
    return a % b


def _shift(a: Any, b: Any) -> Any:
    if isinstance(b, int) and b > MAX_BITS:
        raise TooMuch("an integer is too large")
    return a << b


_BINARY: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: _multiply,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: _modulo,
    ast.Pow: _power,
    ast.LShift: _shift,
    ast.RShift: operator.rshift,
    ast.BitAnd: operator.and_,
    ast.BitOr: operator.or_,
    ast.BitXor: operator.xor,
}
_UNARY: dict[type[ast.unaryop], Callable[[Any], Any]] = {
    ast.UAdd: operator.pos,
    ast.USub: operator.neg,
    ast.Not: operator.not_,
    ast.Invert: operator.invert,
}
_COMPARE: dict[type[ast.cmpop], Callable[[Any, Any], Any]] = {
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.Is: operator.is_,
    ast.IsNot: operator.is_not,
    ast.In: lambda a, b: a in b,
    ast.NotIn: lambda a, b: a not in b,
}


# ---- evaluation ------------------------------------------------------------------------------------------------------------


def evaluate(text: str, names: Mapping[str, object], steps: Steps) -> object:
    """Return the value of an expression.

    Args:
        text: the expression.
        names: properties and functions.
        steps: of the expansion.

    Raises:
        ExpressionError: it is not one that is allowed, or too large; other exceptions are those of Python.
    """
    if len(text) > MAX_EXPRESSION:
        raise TooMuch(f"an expression is longer than {MAX_EXPRESSION} characters")
    return _Evaluation(names, steps).value(_parsed(text.strip()))


@lru_cache(maxsize=2000)
def _parsed(text: str) -> ast.expr:
    """Return the syntax tree of an expression, which nobody changes: macros have the same ones again and again."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # Python warns of odd constants and escapes
            return ast.parse(text, mode="eval").body
    except (MemoryError, RecursionError):  # how Python's parser puts it
        raise TooMuch("an expression is nested too deep") from None


class _Evaluation:
    """The evaluation of one expression; ``local`` are the variables of its comprehensions."""

    def __init__(self, names: Mapping[str, object], steps: Steps) -> None:
        self.names, self.steps = names, steps
        self.local: dict[str, object] = {}

    def value(self, node: ast.AST) -> Any:
        """Return the value of a node."""
        self.steps.take(1)
        method = getattr(self, f"_{type(node).__name__}", None)
        if method is None:
            raise ExpressionError(f"{_NAMES.get(type(node), type(node).__name__)} is not allowed")
        return method(node)

    def _Constant(self, node: ast.Constant) -> object:
        if not isinstance(node.value, (int, float, str, type(None))):
            raise ExpressionError(f"a constant of type {type(node.value).__name__} is not allowed")
        return self.steps.weigh(node.value)

    def _Name(self, node: ast.Name) -> object:
        if node.id in self.local:
            return self.local[node.id]
        try:
            return self.names[node.id]
        except KeyError:
            raise NameError(f"name {node.id!r} is not defined") from None

    def _Attribute(self, node: ast.Attribute) -> object:
        owner = self.value(node.value)
        if isinstance(owner, dict) and not node.attr.startswith("__"):  # namespaces and what was read from YAML
            try:
                return owner[node.attr]
            except (KeyError, AttributeError):
                pass
        raise ExpressionError(f"there is no {node.attr!r} in {ast.unparse(node.value)}, or it is not allowed")

    def _Subscript(self, node: ast.Subscript) -> object:
        owner, key = self.value(node.value), self.value(node.slice)
        return self.steps.weigh(owner[key]) if isinstance(key, slice) else owner[key]

    def _Slice(self, node: ast.Slice) -> slice:
        return slice(*(None if part is None else self.value(part) for part in (node.lower, node.upper, node.step)))

    def _Call(self, node: ast.Call) -> object:
        arguments = self._elements(node.args)
        named: dict[str, object] = {}
        for keyword in node.keywords:
            named.update({keyword.arg: self.value(keyword.value)} if keyword.arg else dict(self.value(keyword.value)))
        if isinstance(node.func, ast.Attribute):
            owner = self.value(node.func.value)
            method = _method(owner, node.func.attr) if not hasattr(owner, "unevaluated") else None
            if method is not None:
                self.steps.weigh([owner, arguments, named])
                _check_method(owner, node.func.attr, arguments)
                result = method(*arguments, **named)
                return self.steps.weigh(list(result) if isinstance(owner, dict) and node.func.attr != "get" else result)
        function = self.value(node.func)
        if not isinstance(function, Function):
            raise ExpressionError(f"{ast.unparse(node.func)} is not a function that is allowed")
        return function(*arguments, **named)

    def _BinOp(self, node: ast.BinOp) -> object:
        a, b = self.value(node.left), self.value(node.right)
        return self.steps.weigh(_BINARY[type(node.op)](a, b)) if type(node.op) in _BINARY else self.value(node.op)

    def _UnaryOp(self, node: ast.UnaryOp) -> object:
        return _UNARY[type(node.op)](self.value(node.operand))

    def _BoolOp(self, node: ast.BoolOp) -> object:
        stops_at = isinstance(node.op, ast.Or)
        result: object = None
        for part in node.values:
            result = self.value(part)
            if bool(result) == stops_at:
                break
        return result

    def _Compare(self, node: ast.Compare) -> object:
        left, result = self.value(node.left), True
        for comparison, part in zip(node.ops, node.comparators, strict=True):
            right = self.value(part)
            self.steps.weigh([left, right])
            result = _COMPARE[type(comparison)](left, right)
            if not result:
                break
            left = right
        return result

    def _IfExp(self, node: ast.IfExp) -> object:
        return self.value(node.body if self.value(node.test) else node.orelse)

    def _elements(self, parts: Iterable[ast.AST]) -> list[object]:
        """Return the values of what stands between commas, starred lists taken apart."""
        result: list[object] = []
        for part in parts:
            result.extend(self._items(part.value) if isinstance(part, ast.Starred) else [self.value(part)])
        return result

    def _List(self, node: ast.List | ast.Tuple) -> list[object]:
        return self.steps.weigh(self._elements(node.elts))  # type: ignore[no-any-return]

    def _Tuple(self, node: ast.Tuple) -> tuple[object, ...]:
        return tuple(self._List(node))

    def _items(self, node: ast.AST) -> list[object]:
        """Return what a node's value iterates over."""
        value = self.value(node)
        if not isinstance(value, (str, list, tuple, set, frozenset, dict)):
            raise ExpressionError(f"{type(value).__name__} cannot be iterated over")
        return list(value)

    def _ListComp(self, node: ast.ListComp | ast.GeneratorExp) -> list[object]:
        result: list[object] = []
        before = dict(self.local)
        self._comprehend(node, 0, result)
        self.local = before
        return self.steps.weigh(result)  # type: ignore[no-any-return]

    _GeneratorExp = _ListComp

    def _comprehend(self, node: ast.ListComp | ast.GeneratorExp, level: int, result: list[object]) -> None:
        if level == len(node.generators):
            result.append(self.value(node.elt))
            return
        loop = node.generators[level]
        for item in self._items(loop.iter):
            self._assign(loop.target, item)
            if all(self.value(condition) for condition in loop.ifs):
                self._comprehend(node, level + 1, result)

    def _assign(self, target: ast.AST, value: Any) -> None:
        if isinstance(target, ast.Name):
            self.local[target.id] = value
        elif isinstance(target, (ast.Tuple, ast.List)):
            for part, item in zip(target.elts, value, strict=True):
                self._assign(part, item)
        else:
            raise ExpressionError("a comprehension's variable must be a name")


_NAMES: dict[type[ast.AST], str] = {
    ast.Lambda: "lambda",
    ast.NamedExpr: ":=",
    ast.JoinedStr: "a formatted string",
    ast.MatMult: "the operator @",
}
