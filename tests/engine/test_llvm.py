"""Operations in machine code against NumPy, of eight poses or of one, of inputs and of parameters."""

import numpy as np
import pytest
from tapes import FIRST, SECOND, evaluate, recorded

from kinetostatics.engine import llvm
from kinetostatics.engine.code import Bound, Code, packed


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
