"""Rules of differentiation of recorded operations against central differences."""

import numpy as np
import pytest
from tapes import evaluate

from kinetostatics.engine import record_derivatives
from kinetostatics.engine.scalars import (
    Tape,
    absolute,
    add,
    angle_of,
    choose,
    compare,
    cosine,
    divide,
    multiply,
    needed_by,
    negative,
    sine,
    square_root,
    subtract,
    whole,
)

#: What each operation is in a function of two numbers, x and y.
FUNCTIONS = {
    "add": lambda x, y: add(x, y),
    "subtract": lambda x, y: subtract(x, y),
    "multiply": lambda x, y: multiply(x, y),
    "divide": lambda x, y: divide(x, y),
    "negative": lambda x, y: multiply(negative(x), y),
    "square_root": lambda x, y: square_root(add(multiply(x, x), y)),
    "absolute": lambda x, y: multiply(absolute(subtract(x, 2.0)), y),
    "sine": lambda x, y: multiply(sine(x), y),
    "cosine": lambda x, y: multiply(cosine(x), y),
    "angle": lambda x, y: angle_of(multiply(x, y), y),
    "choose": lambda x, y: choose(compare(">", x, 1.0), multiply(x, x), square_root(subtract(x, 1.0))),
    "choose a constant": lambda x, y: add(
        choose(compare(">", x, 1.0), multiply(x, y), 3.0), choose(compare(">", y, 1.0), 2.0, x)
    ),
    "whole": lambda x, y: add(multiply(whole(x), x), y),
}
POINTS = np.array([[0.7, 1.3, 1.8, -0.4], [1.1, 0.6, 2.1, 0.9]])


def worst_error(name):
    """Return by how much derivatives of one function, backwards and forwards, differ from central differences at most."""
    tape = Tape()
    x, y = (tape.write(("input", 0, k), value) for k, value in enumerate(POINTS[:, 1]))
    result = FUNCTIONS[name](x, y).number
    needed = needed_by(tape, [result])
    found = record_derivatives.values(tape, needed, [POINTS], np.zeros(0))
    backwards = record_derivatives.gradients(tape, found, [result], (x.number, y.number), POINTS.shape[1])
    forwards = record_derivatives.tangent_record(tape, [result], 1)
    h, none, worst = 1e-6, np.zeros((1, POINTS.shape[1])), 0.0
    for k, item in enumerate((x, y)):
        step = np.zeros((2, 1))
        step[k] = h
        up, down = (evaluate(tape, [POINTS + sign * step, POINTS], [], [result])[0] for sign in (1, -1))
        exact = (up - down) / (2 * h)
        recorded = evaluate(tape, [POINTS, np.repeat(step / h, POINTS.shape[1], axis=1)], [], forwards)[0]
        for found in (backwards.get(item.number, none)[0], recorded):
            worst = max(worst, np.max(np.abs(found - exact)[np.isfinite(exact)]))
    return worst


@pytest.mark.parametrize("name", FUNCTIONS)
def test_derivative_of_operation_equals_central_differences(name):
    assert worst_error(name) < 1e-8


@pytest.mark.parametrize("name", [name for name in FUNCTIONS if name in record_derivatives.PARTIALS])
def test_central_differences_detect_a_wrong_rule(name, monkeypatch):
    right = record_derivatives.PARTIALS[name]
    monkeypatch.setitem(record_derivatives.PARTIALS, name, lambda *numbers: tuple(1.001 * part for part in right(*numbers)))
    assert worst_error(name) > 1e-5


def test_all_operations_have_a_rule_or_no_derivative():
    """Comparisons and rounding are step functions; every other operation needs a rule."""
    steps = {"and", "or", "not", ">", ">=", "<", "<=", "==", "!=", "whole", "choose"}
    assert set(record_derivatives.PARTIALS) | steps == set(record_derivatives._FUNCTIONS)


def test_derivative_of_choose_ignores_the_branch_not_chosen():
    """√(x − 1) is chosen beyond x = 2 alone; at x = 1 its slope is infinite, and not taken, backwards or forwards."""
    tape = Tape()
    x = tape.write(("input", 0, 0), 5.0)
    result = choose(compare(">", x, 2.0), square_root(subtract(x, 1.0)), multiply(x, 3.0)).number
    points = np.array([[5.0, 1.0, 1.5]])
    found = record_derivatives.values(tape, needed_by(tape, [result]), [points], np.zeros(0))
    slopes = record_derivatives.gradients(tape, found, [result], [x.number], 3)[x.number]
    forwards = evaluate(tape, [points, np.ones((1, 3))], [], record_derivatives.tangent_record(tape, [result], 1))
    for slope in (slopes[0], forwards[0]):
        np.testing.assert_allclose(slope, [0.25, 3.0, 3.0], rtol=1e-15)
