"""WebAssembly of recorded scalar operations: a module of functions of bounded size, which pass values through its memory.

The memory contains 8-byte numbers: inputs, outputs, intermediate values, constants. The module exports it as ``memory``, and the
function ``run``, which computes the outputs from the inputs. It imports sine, cosine and arctangent: ``Math.sin``, ``Math.cos``
and ``Math.atan2`` of a browser. Binary format: WebAssembly Core Specification 2.0, chapter 5.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Sequence

from kinetostatics.engine.c_code import places_of
from kinetostatics.engine.scalars import LEAVES, Tape, needed_by, operands

#: Largest number of operations in a function; engines optimize larger ones slowly.
_PIECE = 2000
#: Largest depth of an expression whose intermediate values have no local variable.
_DEEP = 40
_IMPORTED = {"sine": 0, "cosine": 1, "angle": 2}
_CODES = {
    "add": 0xA0, "subtract": 0xA1, "multiply": 0xA2, "divide": 0xA3, "negative": 0x9A, "square_root": 0x9F, "absolute": 0x99,
    "whole": 0x9E, "choose": 0x1B, "==": 0x61, "!=": 0x62, "<": 0x63, ">": 0x64, "<=": 0x65, ">=": 0x66, "and": 0x71, "or": 0x72,
    "not": 0x45,
}  # fmt: skip
_NUMBER, _TRUTH, _FUNCTION = 0x7C, 0x7F, 0x60
_PAGE = 65536


def wasm_module(tape: Tape, outputs: Sequence[int], inputs: Sequence[int]) -> bytes:
    """Return a module that computes the results of some operations; truth values are written as 0 and 1.

    Args:
        outputs: indices of these operations.
        inputs: lengths of the input arrays, and of the array of parameters; these arrays follow one another at the beginning of
            the memory, and the outputs follow them.
    """
    return _Module(tape, outputs, inputs).code()


def _whole(value: int, signed: bool = False) -> bytes:
    """Return an integer as LEB128."""
    parts = bytearray()
    while True:
        part, value = value & 0x7F, value >> 7
        if (value == 0 and not (signed and part & 0x40)) or (signed and value == -1 and part & 0x40):
            return bytes([*parts, part])
        parts.append(part | 0x80)


def _vector(entries: Iterable[bytes]) -> bytes:
    entries = list(entries)
    return _whole(len(entries)) + b"".join(entries)


def _sized(content: bytes) -> bytes:
    return _whole(len(content)) + content


def _name(text: str) -> bytes:
    return _sized(text.encode())


class _Module:
    """Code of a module.

    Attributes:
        places: operations whose results are stored in the memory, with the index of each result behind the outputs.
        first: index in the memory of each input array, and of the outputs.
    """

    def __init__(self, tape: Tape, outputs: Sequence[int], inputs: Sequence[int]) -> None:
        self.tape, self.outputs = tape, outputs
        self.first = [sum(inputs[:k]) for k in range(len(inputs) + 1)]
        self.is_truth = [isinstance(value, bool) for value in tape.values]
        steps = [k for k, needed in enumerate(needed_by(tape, outputs)) if needed and tape.operations[k][0] not in LEAVES]
        self.pieces = [steps[at : at + _PIECE] for at in range(0, len(steps), _PIECE)]
        piece_of = {number: k for k, piece in enumerate(self.pieces) for number in piece}
        self.uses = dict.fromkeys(steps, 0)
        last = dict(piece_of)
        for number in steps:
            for operand in operands(tape.operations[number]):
                if operand in piece_of:
                    self.uses[operand] += 1
                    last[operand] = max(last[operand], piece_of[number])
        last |= {number: len(self.pieces) for number in outputs if number in last}
        self.places, work = places_of(self.pieces, piece_of, last)
        self.work_at = self.first[-1] + len(outputs)
        self.constants_at = self.work_at + work
        self.constants: dict[str, tuple[int, float]] = {}

    def code(self) -> bytes:
        functions = [*(self._piece(piece) for piece in self.pieces), self._last()]
        one, two = bytes([1, _NUMBER]), bytes([2, _NUMBER, _NUMBER])
        kinds = [bytes([_FUNCTION, 0, 0]), bytes([_FUNCTION]) + one + one, bytes([_FUNCTION]) + two + one]
        imported = [_name("math") + _name(name) + bytes([0, kind]) for name, kind in (("sin", 1), ("cos", 1), ("atan2", 2))]
        data = b"".join(struct.pack("<d", value) for _, value in self.constants.values())
        pages = (8 * self.constants_at + len(data)) // _PAGE + 1
        exported = [_name("run") + b"\0" + _whole(len(_IMPORTED) + len(functions) - 1), _name("memory") + b"\2\0"]
        sections = [
            (1, _vector(kinds)), (2, _vector(imported)), (3, _vector([b"\0"] * len(functions))), (5, b"\1\0" + _whole(pages)),
            (7, _vector(exported)), (10, _vector(map(_sized, functions))),
            (11, _vector([b"\0\x41" + _whole(8 * self.constants_at, signed=True) + b"\x0b" + _sized(data)])),
        ]  # fmt: skip
        return b"\0asm\1\0\0\0" + b"".join(bytes([number]) + _sized(content) for number, content in sections)

    def _piece(self, piece: Sequence[int]) -> bytes:
        """Return the code of a function that computes some operations, and stores the results that other functions need."""
        within = self._within(piece)
        of_kind = [
            [number for number in piece if number not in within and self.is_truth[number] is kind] for kind in (False, True)
        ]
        slots = {number: _whole(k) for k, number in enumerate(of_kind[False] + of_kind[True])}
        code = bytearray()

        def value(number: int) -> None:
            if number in slots:
                code.extend(b"\x20" + slots[number])
            elif number in within:
                compute(number)
            else:
                code.extend(self._loaded(number))

        def compute(number: int) -> None:
            kind, *taken = self.tape.operations[number]
            for operand in (*taken[1:], taken[0]) if kind == "choose" else taken:
                value(operand)
            code.extend(b"\x10" + _whole(_IMPORTED[kind]) if kind in _IMPORTED else bytes([_CODES[kind]]))

        for number in piece:
            if number in slots:
                compute(number)
                code.extend(b"\x21" + slots[number])
        for number in piece:
            if number in self.places:
                code.extend(self._stored(self.work_at + self.places[number], number, b"\x20" + slots[number]))
        variables = [_whole(len(own)) + bytes([kind]) for own, kind in zip(of_kind, (_NUMBER, _TRUTH), strict=True)]
        return _vector(variables) + bytes(code) + b"\x0b"

    def _within(self, piece: Sequence[int]) -> dict[int, int]:
        """Return the operations without a variable, each with the only one that uses it, in whose code it is computed."""
        own, depth, within = set(piece), dict.fromkeys(piece, 0), dict[int, int]()
        for number in piece:
            for operand in operands(self.tape.operations[number]):
                if operand in own and self.uses[operand] == 1 and operand not in self.places and depth[operand] < _DEEP:
                    within[operand], depth[number] = number, max(depth[number], depth[operand] + 1)
        return within

    def _last(self) -> bytes:
        """Return the code of a function that calls all others and stores the outputs."""
        calls = b"".join(b"\x10" + _whole(len(_IMPORTED) + k) for k in range(len(self.pieces)))
        stores = (self._stored(self.first[-1] + row, number, self._loaded(number)) for row, number in enumerate(self.outputs))
        return b"\0" + calls + b"".join(stores) + b"\x0b"

    def _loaded(self, number: int) -> bytes:
        """Return the code of a value that is no variable: an input, a constant, or a result in the memory."""
        kind, *taken = self.tape.operations[number]
        if kind == "truth":
            return b"\x41" + bytes([taken[0]])
        if kind in ("input", "parameter"):
            place = self.first[taken[0] if kind == "input" else -2] + taken[-1]
        elif kind in LEAVES:
            value = float.fromhex(taken[0])
            found, _ = self.constants.setdefault(value.hex(), (len(self.constants), value))  # the text distinguishes −0 from 0
            place = self.constants_at + found
        else:
            place = self.work_at + self.places[number]
        load = b"\x41\0\x2b\3" + _whole(8 * place)
        return load + b"\x44" + bytes(8) + b"\x62" if self.is_truth[number] else load

    def _stored(self, place: int, number: int, value: bytes) -> bytes:
        return b"\x41\0" + value + (b"\xb8" if self.is_truth[number] else b"") + b"\x39\3" + _whole(8 * place)
