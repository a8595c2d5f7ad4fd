"""C code of recorded scalar operations: functions of bounded size that pass intermediate values in a small work array.

A value used in only one function is a local constant. Any other value has an entry in the work array, which is reused after the
value's last use. The bounded functions limit the time of compilation, the reuse limits the memory.
"""

from __future__ import annotations

import heapq
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from kinetostatics.engine.scalars import Tape, needed_by, operands
from kinetostatics.math.arrays import Array

#: Largest number of operations in a function. Fewer functions need less memory and time: the 14,000 operations of the hexapod
#: take 7 % more time in 36 functions than in two, and a fifth more flash memory of a controller.
_PIECE = 8000

_INFIX = {"add": "+", "subtract": "-", "multiply": "*", "divide": "/", "and": "&&", "or": "||"}
_INFIX |= {how: how for how in (">", ">=", "<", "<=", "==", "!=")}
_CALLS = {"square_root": "sqrt", "absolute": "fabs", "sine": "sin", "cosine": "cos", "angle": "atan2", "whole": "rint"}


@dataclass(frozen=True)
class CProgram:
    """C code of recorded operations.

    Attributes:
        text: static functions; the last function calls the others.
        work: length of the work array.
        counts: number of operations of each kind, by name in a :class:`Tape`.
    """

    text: str
    work: int
    counts: Mapping[str, int]

    @property
    def operations(self) -> int:
        return sum(self.counts.values())


def c_program(name: str, tape: Tape, outputs: Sequence[int], constants: Array, inputs: Sequence[str]) -> CProgram:
    """Return the C code of ``static void name(const double *…, double *w, double *out)``; truth values are written as 0 and 1.

    Args:
        outputs: indices of the operations whose results are written to ``out``, in order.
        constants: values of the parameters.
        inputs: names of the input arrays.
    """
    needed = needed_by(tape, outputs)
    leaf_texts: dict[int, str] = {}
    steps: list[int] = []
    for number, operation in enumerate(tape.operations):
        kind = operation[0]
        if not needed[number]:
            continue
        if kind == "input":
            leaf_texts[number] = f"{inputs[operation[1]]}[{operation[2]}]"
        elif kind == "parameter":
            leaf_texts[number] = literal(float(constants[operation[1]]))
        elif kind == "constant":
            leaf_texts[number] = literal(float.fromhex(operation[1]))
        elif kind == "truth":
            leaf_texts[number] = "1" if operation[1] else "0"
        else:
            steps.append(number)
    pieces = [steps[first : first + _PIECE] for first in range(0, len(steps), _PIECE)] or [[]]
    piece_of = {number: k for k, piece in enumerate(pieces) for number in piece}
    last_use = {number: piece_of[number] for number in steps}
    for number in steps:
        for operand in operands(tape.operations[number]):
            if operand in last_use:
                last_use[operand] = max(last_use[operand], piece_of[number])
    for number in outputs:
        if number in last_use:
            last_use[number] = len(pieces)
    places, work = places_of(pieces, piece_of, last_use)
    arguments = ", ".join([*(f"const double *{array}" for array in inputs), "double *w"])
    truth = [isinstance(value, bool) for value in tape.values]
    lines: list[str] = []
    for k, piece in enumerate(pieces):
        lines += [f"static void {name}_{k}({arguments})", "{", *_unused(inputs)]

        def text(number: int, k: int = k) -> str:
            if number in leaf_texts:
                return leaf_texts[number]
            if piece_of[number] == k:
                return f"v{number}"
            return f"(w[{places[number]}] != 0.0)" if truth[number] else f"w[{places[number]}]"

        for number in piece:
            kind, *taken = tape.operations[number]
            lines.append(
                f"    const {'int' if truth[number] else 'double'} v{number} = {_expression(kind, [text(n) for n in taken])};"
            )
        for number in piece:
            if number in places:
                value = f"v{number} ? 1.0 : 0.0" if truth[number] else f"v{number}"
                lines.append(f"    w[{places[number]}] = {value};")
        lines += ["}", ""]
    lines += [f"static void {name}({arguments}, double *out)", "{", *_unused(inputs)]
    lines += [f"    {name}_{k}({', '.join([*inputs, 'w'])});" for k in range(len(pieces))]
    if not outputs:
        lines.append("    (void)out;")
    for row, number in enumerate(outputs):
        lines.append(f"    out[{row}] = {leaf_texts[number] if number in leaf_texts else f'w[{places[number]}]'};")
    lines += ["}", ""]
    return CProgram("\n".join(lines), max(work, 1), Counter(tape.operations[number][0] for number in steps))


def literal(value: float) -> str:
    """Return a number as a C literal with all digits; NaN and infinity as macros."""
    if value != value:
        return "(double)NAN"
    if value in (float("inf"), float("-inf")):
        return "(double)INFINITY" if value > 0 else "(-(double)INFINITY)"
    text = repr(value)
    text = text if any(letter in text for letter in ".en") else f"{text}.0"
    return f"({text})" if value < 0 or text.startswith("-") else text


def _unused(inputs: Sequence[str]) -> list[str]:
    return [f"    (void){array};" for array in (*inputs, "w")]


def _expression(kind: str, taken: Sequence[str]) -> str:
    if kind in _INFIX:
        return f"{taken[0]} {_INFIX[kind]} {taken[1]}"
    if kind in ("not", "negative"):
        return f"{'!' if kind == 'not' else '-'}{taken[0]}"
    if kind == "choose":
        return f"{taken[0]} ? {taken[1]} : {taken[2]}"
    return f"{_CALLS[kind]}({', '.join(taken)})"


def places_of(
    pieces: Sequence[Sequence[int]], piece_of: Mapping[int, int], last_use: Mapping[int, int]
) -> tuple[dict[int, int], int]:
    """Return ({operation: index in the work array} of the values used outside their own function, length of the array)."""
    places: dict[int, int] = {}
    free: list[int] = []
    ends: list[tuple[int, int]] = []
    count = 0
    for k, piece in enumerate(pieces):
        while ends and ends[0][0] < k:
            heapq.heappush(free, heapq.heappop(ends)[1])
        for number in piece:
            if last_use[number] > piece_of[number]:
                if free:
                    places[number] = heapq.heappop(free)
                else:
                    places[number], count = count, count + 1
                heapq.heappush(ends, (last_use[number], places[number]))
    return places, count
