"""Xacro's expressions ``${…}``, computed here and not by Python.

Xacro hands them to ``eval``, from which files can be read and code be run, and which may compute for ever. Here they
are a small part of Python: numbers, strings, lists and dicts, operators, comprehensions, xacro's functions, and methods that
only look. Every step and the size of every result count towards :class:`Steps`, so that each expansion comes to an end.
"""

from __future__ import annotations

import ast
import operator
import re
import warnings
from collections.abc import Callable, Iterable, Mapping
from functools import lru_cache

from kinetostatics.files.xacro_functions import MAX_BITS, MAX_SIZE, ExpressionError, Function, Steps, TooMuch

#: Longest expression, and longest text around expressions [characters].
MAX_EXPRESSION, MAX_TEXT = 10_000, 100_000

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


def _method(value: object, name: str) -> Callable[..., object] | None:
    for kind, names in _METHODS.items():
        if isinstance(value, kind) and name in names:
            return getattr(kind, name).__get__(value)  # type: ignore[no-any-return]
    return None


def _check_method(value: object, name: str, arguments: list[object]) -> None:
    """Refuse what would give a huge text, before it is there."""
    size = 0
    if isinstance(value, str) and name == "join" and len(arguments) == 1 and isinstance(arguments[0], (list, tuple, set, dict)):
        size = len(value) * len(arguments[0])
    elif isinstance(value, str) and name == "replace" and len(arguments) >= 2:
        old, new = arguments[:2]
        size = value.count(old) * len(new) if isinstance(old, str) and isinstance(new, str) else 0
    if size > MAX_SIZE:
        raise TooMuch("a text is too long")


# ---- operators -------------------------------------------------------------------------------------------------------------


def _multiply(a: object, b: object) -> object:
    for sequence, times in ((a, b), (b, a)):
        if isinstance(sequence, (str, bytes, list, tuple)) and isinstance(times, int) and times * len(sequence) > MAX_SIZE:
            raise TooMuch("a text or list is too long")
    return operator.mul(a, b)


def _power(a: object, b: object) -> object:
    if isinstance(a, int) and isinstance(b, int) and b > 0 and a.bit_length() * b > MAX_BITS:
        raise TooMuch("an integer is too large")
    result: object = operator.pow(a, b)
    if isinstance(result, complex):
        raise ExpressionError("a power of a negative number")
    return result


def _modulo(a: object, b: object) -> object:
    if isinstance(a, str) and re.search(r"\d{4}|\*", a):
        raise TooMuch("a width in a format is too large")
    return operator.mod(a, b)


def _shift(a: object, b: object) -> object:
    if isinstance(b, int) and b > MAX_BITS:
        raise TooMuch("an integer is too large")
    return operator.lshift(a, b)


_BINARY: dict[type[ast.operator], Callable[..., object]] = {
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
_item: Callable[..., object] = operator.getitem
_iterated: Callable[..., Iterable[object]] = iter
_named: Callable[..., dict[str, object]] = dict
_UNARY: dict[type[ast.unaryop], Callable[..., object]] = {
    ast.UAdd: operator.pos,
    ast.USub: operator.neg,
    ast.Not: operator.not_,
    ast.Invert: operator.invert,
}
_COMPARE: dict[type[ast.cmpop], Callable[..., object]] = {
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.Is: operator.is_,
    ast.IsNot: operator.is_not,
    ast.In: lambda a, b: operator.contains(b, a),
    ast.NotIn: lambda a, b: not operator.contains(b, a),
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

    def value(self, node: ast.AST) -> object:
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
        found: object = _item(owner, key)
        return self.steps.weigh(found) if isinstance(key, slice) else found

    def _Slice(self, node: ast.Slice) -> slice:
        return slice(*(None if part is None else self.value(part) for part in (node.lower, node.upper, node.step)))

    def _Call(self, node: ast.Call) -> object:
        arguments = self._elements(node.args)
        named: dict[str, object] = {}
        for keyword in node.keywords:
            named.update({keyword.arg: self.value(keyword.value)} if keyword.arg else _named(self.value(keyword.value)))
        if isinstance(node.func, ast.Attribute):
            owner = self.value(node.func.value)
            method = _method(owner, node.func.attr) if not hasattr(owner, "unevaluated") else None
            if method is not None:
                self.steps.weigh([owner, arguments, named])
                _check_method(owner, node.func.attr, arguments)
                result = method(*arguments, **named)
                return self.steps.weigh(
                    list(_iterated(result)) if isinstance(owner, dict) and node.func.attr != "get" else result
                )
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
        left = self.value(node.left)
        result: object = True
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
        return self.steps.weigh(self._elements(node.elts))

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
        return self.steps.weigh(result)

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

    def _assign(self, target: ast.AST, value: object) -> None:
        if isinstance(target, ast.Name):
            self.local[target.id] = value
        elif isinstance(target, (ast.Tuple, ast.List)):
            for part, item in zip(target.elts, _iterated(value), strict=True):
                self._assign(part, item)
        else:
            raise ExpressionError("a comprehension's variable must be a name")


_NAMES: dict[type[ast.AST], str] = {
    ast.Lambda: "lambda",
    ast.NamedExpr: ":=",
    ast.JoinedStr: "a formatted string",
    ast.MatMult: "the operator @",
}
