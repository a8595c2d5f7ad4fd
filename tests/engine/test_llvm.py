"""Operations in machine code against NumPy, of eight poses or of one, of inputs and of parameters."""

import numpy as np
import pytest
from tapes import evaluate

from kinetostatics.engine import llvm
from kinetostatics.engine.code import Bound, Code, packed
from kinetostatics.engine.record_derivatives import _FUNCTIONS
from kinetostatics.engine.scalars import _COMPARISONS, Tape

#: Both numbers of every operation: around all multiples of π/8, large and small ones, equal ones, zeros of both signs.
TURNS = np.arange(-24, 25) * np.pi / 8
FIRST = np.concatenate([TURNS, TURNS + 1e-9, np.sin(TURNS), [0.0, -0.0, 0.0, -0.0, 1e-300, 3e4, -7e5, 2.5, 0.5, -0.5, 1.5]])
SECOND = np.concatenate([TURNS[::-1], TURNS, np.cos(TURNS), [0.0, 0.0, -0.0, -1.0, 1.0, 2.0, 3e-9, 2.5, -0.5, 0.5, -1e300]])


def recorded(kind):
    """Return a tape of all operations on two numbers of a kind and on a truth, and those that give numbers and truths."""
    tape = Tape()
    a, b = (tape.write((kind, *((0, k) if kind == "input" else (k,))), 0.5).number for k in range(2))
    more, less = (tape.write((how, a, b), how == "<").number for how in "><")
    taken = {"and": (more, less), "or": (more, less), "not": (more,), "choose": (more, a, b)}
    numbers, truths = [], [more, less]
    for name in _FUNCTIONS:
        one = name in ("negative", "square_root", "absolute", "sine", "cosine", "whole")
        is_truth = name in _COMPARISONS or name in ("and", "or", "not")
        operation = (name, *taken.get(name, (a,) if one else (a, b)))
        (truths if is_truth else numbers).append(tape.write(operation, False if is_truth else 0.5).number)
    numbers += [tape.number_of(value) for value in (0.1, -0.0)] + [a]
    return tape, numbers, [*truths, tape.number_of(True), tape.number_of(False)]


@pytest.mark.parametrize("lanes", [llvm.LANES, 1])
@pytest.mark.parametrize("kind", ["input", "parameter"])
def test_machine_code_of_operations_equals_numpy(kind, lanes):
    """Up to rounding, and 1e-20 at multiples of half a turn; zeros have the same sign, except sines."""
    tape, numbers, truths = recorded(kind)
    code = Code(packed({}, llvm.module_of(tape, numbers, truths, 1, lanes=lanes), lanes))
    given, N = np.array([FIRST, SECOND]), FIRST.size
    found, flags = np.empty((len(numbers), N)), np.empty((len(truths), N), dtype=bool)
    if kind == "input":
        Bound(code, [given], np.empty(0), found, flags)()
    else:
        own, truth = np.empty((len(numbers), lanes)), np.empty((len(truths), lanes), dtype=bool)
        for k in range(N):
            Bound(code, [np.empty((0, lanes))], np.array(given[:, k]), own, truth)()
            assert np.array_equal(own, np.repeat(own[:, :1], lanes, axis=1), equal_nan=True)
            found[:, k], flags[:, k] = own[:, 0], truth[:, 0]
    wanted = evaluate(tape, [given], given, numbers)
    np.testing.assert_allclose(found, wanted, rtol=6e-16, atol=1e-20)
    known = ~np.isnan(wanted)
    known[[tape.operations[number][0] == "sine" for number in numbers]] = False  # that of −0 is 0
    np.testing.assert_array_equal(np.signbit(found[known]), np.signbit(wanted[known]))
    np.testing.assert_array_equal(flags, evaluate(tape, [given], given, truths))
