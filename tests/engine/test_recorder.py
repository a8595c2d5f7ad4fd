"""Functions of recorded arrays against NumPy's of floats, and guards of branches."""

import numpy as np
import pytest
from tapes import evaluate

from kinetostatics.engine.recorder import Recorded
from kinetostatics.engine.scalars import NotRecordedError, Tape

VALUES = np.array([[0.5, -2.0, 0.0, np.nan], [3.0, 0.25, -1.0, 1.0]])

FUNCTIONS = {
    "sums": lambda a, b: a + b - 2 * a + (1 - b),
    "products": lambda a, b: a * b * 0.5 * (-1 * a) * (1 * b) + 0 * np.nan_to_num(a),
    "quotients": lambda a, b: a / b + 1 / b + b / 4,
    "powers": lambda a, b: a**2 + b**3 - np.square(a) ** 4,
    "roots": lambda a, b: np.sqrt(np.abs(a)) + np.sqrt(b),
    "signs": lambda a, b: np.sign(a) - -b + abs(a),
    "larger": lambda a, b: np.maximum(a, b) - np.minimum(a, 0.3),
    "choices": lambda a, b: np.where((a > b) | (a <= -2) & ~(b >= 3), a, np.where(a == b, 1.0, b)),
    "rest": lambda a, b: np.where(np.isfinite(a) & ~np.isnan(b) & (a != b) & (a < 9), 1.0, 2.0),
    "reductions": lambda a, b: np.max(np.stack([a, b, a * b]), axis=0, initial=0.1) + np.stack([a, b]).sum(axis=0) * np.ones(1),
    "kept axes": lambda a, b: (np.stack([a, b])[None] / np.max(np.stack([a, b])[None], axis=(0, 1), keepdims=True))[0, 1],
    "last axes": lambda a, b: np.sum(np.stack([a, b], axis=-1), axis=-1) + np.stack([a, b]).sum(axis=(-2,)),
    "nothing": lambda a, b: a + np.sum(np.stack([a, b])[:0], axis=0) + np.max(np.stack([a, b])[:0], axis=0, initial=2.5),
    "einsum": lambda a, b: np.einsum("i...,j...->ij...", np.stack([a, b]), np.stack([b, a]))[0, 1],
    "any": lambda a, b: np.where(np.any(np.stack([a > 1, b > 1]), axis=0), a, b),
}


def recorded(tape, values):
    array = np.empty(len(values), dtype=object)
    for k, value in enumerate(values.tolist()):
        array[k] = tape.write(("input", 0, k), value)
    return array.view(Recorded)


@pytest.mark.parametrize("name", FUNCTIONS)
@pytest.mark.parametrize("example", range(4))
def test_recorded_function_equals_numpy(name, example):
    """Recorded with one column of the values, and evaluated with all of them."""
    tape = Tape()
    a, b = recorded(tape, VALUES[:, example])[:, None]
    with np.errstate(all="ignore"):
        found = FUNCTIONS[name](a, b)
        wanted = FUNCTIONS[name](*VALUES)
    assert np.shape(found)[:-1] == np.shape(wanted)[:-1]
    entry = np.ravel(found)[0]
    np.testing.assert_allclose(evaluate(tape, [VALUES], [], [tape.number_of(entry)])[0], wanted, rtol=1e-15, atol=1e-15)
    np.testing.assert_allclose(float(entry.value), wanted[example], rtol=1e-15)
    assert not tape.guards


def test_branch_follows_the_example_and_is_guarded():
    tape = Tape()
    a = recorded(tape, np.array([1.0, -1.0]))
    assert np.any(a > 0) and list(tape.guards.values()) == [True]
    assert np.argwhere(a > 5).size == 0
    assert list(tape.guards.values()) == [True, False, False]


def test_unsupported_numpy_functions_raise_not_recorded_error():
    a = recorded(Tape(), np.array([1.0, 2.0]))
    for attempt in (
        lambda: np.linalg.svd(a[:, None]),
        lambda: np.exp(a),
        lambda: a**0.5,
        lambda: float(a[0]),
        lambda: np.add.accumulate(a),
    ):
        with pytest.raises(NotRecordedError):
            attempt()


def test_truth_of_a_parameter_is_guarded():
    """A parameter that is 0 for one robot may differ for another of the same structure."""
    tape = Tape()
    assert not tape.write(("parameter", 0), 0.0) and tape.write(("parameter", 1), 2.0)
    assert len(tape.guards) == 2 and sorted(tape.guards.values()) == [False, True]
