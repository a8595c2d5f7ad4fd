"""Operations on recorded and plain numbers, in any combination of operands, against Python's."""

import math
import operator
from itertools import product

import numpy as np
import pytest
from tapes import evaluate

from kinetostatics.engine import scalars
from kinetostatics.engine.scalars import Scalar, Tape, value_of

NUMBERS = (0.0, 1.0, -1.0, 2.5, -0.5, math.nan, math.inf)
#: Equivalents of the functions of two numbers in Python.
OF_TWO = {
    "add": operator.add,
    "subtract": operator.sub,
    "multiply": operator.mul,
    "divide": lambda a, b: float(np.float64(a) / np.float64(b)),
    "angle_of": math.atan2,
    "larger": lambda a, b: math.nan if math.isnan(a) or math.isnan(b) else max(a, b),
    "smaller": lambda a, b: math.nan if math.isnan(a) or math.isnan(b) else min(a, b),
    "logical_and": lambda a, b: bool(a) and bool(b),
    "logical_or": lambda a, b: bool(a) or bool(b),
}
OF_ONE = {
    "negative": operator.neg,
    "square_root": lambda a: math.sqrt(a) if a >= 0 else math.nan,
    "sine": lambda a: math.sin(a) if math.isfinite(a) else math.nan,
    "cosine": lambda a: math.cos(a) if math.isfinite(a) else math.nan,
    "absolute": abs,
    "sign": lambda a: float(np.sign(a)),
    "logical_not": lambda a: not a,
    "is_nan": math.isnan,
    "is_finite": math.isfinite,
    "without_nan": lambda a: 0.0 if math.isnan(a) else a,
}
#: Operands for which Python has no value, or for which products and quotients of a plain zero stay zero.
WITHOUT = {
    "sine": (math.inf,),
    "cosine": (math.inf,),
    "sign": (math.nan,),
    "multiply": (math.nan, math.inf),
    "divide": (0.0, math.nan, math.inf),
}


def numbers_for(name, *numbers):
    return [a for a in numbers if a not in WITHOUT.get(name, ())]


def check(function, wanted, examples, numbers):
    """Record with the examples, some operands plain, and evaluate with other numbers where they are not."""
    for recorded in product((True, False), repeat=len(examples)):
        tape = Tape()
        inputs = [tape.write(("input", 0, k), value) for k, value in enumerate(examples)]
        own = [item if one else value for item, one, value in zip(inputs, recorded, examples, strict=True)]
        with np.errstate(all="ignore"):
            found = function(*own)
            np.testing.assert_allclose(value_of(found), wanted(*examples), rtol=1e-15)
            if not isinstance(found, Scalar):
                continue
            columns = [numbers if one else [value] * len(numbers) for one, value in zip(recorded, examples, strict=True)]
            results = evaluate(tape, [np.array(columns)], [], [found.number])[0]
            np.testing.assert_allclose(results, [wanted(*column) for column in zip(*columns, strict=True)], rtol=1e-15)
        assert not tape.guards


@pytest.mark.parametrize("name", OF_TWO)
def test_binary_functions_equal_python(name):
    for a, b in product(numbers_for(name, *NUMBERS), repeat=2):
        check(getattr(scalars, name), OF_TWO[name], (a, b), numbers_for(name, 3.0, -0.7, 0.0, b))


@pytest.mark.parametrize("name", OF_ONE)
def test_unary_functions_equal_python(name):
    for a in numbers_for(name, *NUMBERS):
        check(getattr(scalars, name), OF_ONE[name], (a,), numbers_for(name, 3.0, -0.7, 0.0, math.nan, math.inf))


@pytest.mark.parametrize("how", scalars._COMPARISONS)
def test_comparisons_equal_python(how):
    for a, b in product(NUMBERS, repeat=2):
        check(lambda a, b: scalars.compare(how, a, b), scalars._COMPARISONS[how], (a, b), [3.0, -0.7, b])


@pytest.mark.parametrize("condition", [True, False])
def test_choose_returns_the_chosen_operand(condition):
    for a, b in ((2.0, 3.0), (2.0, 2.0), (True, False), (False, True), (True, True)):
        for recorded in product((True, False), repeat=3):
            tape = Tape()
            own = [tape.write(("input", 0, k), value) if one else value for k, (value, one) in
                   enumerate(zip((condition, a, b), recorded, strict=True))]  # fmt: skip
            found = scalars.choose(*own)
            assert value_of(found) == (a if condition else b)
            if isinstance(found, Scalar):
                columns = np.array([[not condition] if recorded[0] else [condition], [a], [b]])
                assert evaluate(tape, [columns.astype(float)], [], [found.number])[0][0] == (a if columns[0, 0] else b)


def test_neutral_operations_are_not_recorded():
    tape = Tape()
    a, b = (tape.write(("input", 0, k), value) for k, value in enumerate((2.0, 3.0)))
    less, truth = -a, tape.write(("input", 0, 2), True)
    more = scalars.compare(">", a, b)
    count = len(tape.operations)
    for found in (a + 0.0, 0.0 + a, a - 0.0, 1.0 * a, a * 1.0, -less, a / 1.0, +a, scalars.choose(truth, a, a)):
        assert found is a
    for found in (0.0 - a, -1.0 * a, a * -1.0):
        assert found is less
    assert (truth & True) is truth and (False | truth) is truth and (truth & truth) is truth
    for found, plain in (
        (a * 0.0, 0.0),
        (0.0 * a, 0.0),
        (0.0 / a, 0.0),
        (a**0, 1.0),
        (truth & False, False),
        (True | truth, True),
    ):
        assert found == plain and not isinstance(found, Scalar)
    assert len(tape.operations) == count
    # a robot's number that is 0 has a guard of its own
    assert scalars.logical_and(tape.write(("parameter", 0), 2.0), truth) is truth
    assert (a + b) is (b + a) and (a * b) is (b * a) and scalars.logical_and(truth, more) is scalars.logical_and(more, truth)
    assert (a - b) is not (b - a) and scalars.angle_of(a, b) is not scalars.angle_of(b, a)


@pytest.mark.parametrize("example", [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)])
def test_record_holds_where_all_branches_match_the_example(example):
    tape = Tape()
    a, b = (tape.write(("input", 0, k), value) for k, value in enumerate(example))
    for one in (a, b):
        bool(scalars.compare(">", one, 0.0))
    others = np.array(list(product((2.0, -2.0), repeat=2))).T
    found = evaluate(tape, [others], [], [tape.holds().number])[0]
    np.testing.assert_array_equal(found, np.all(np.sign(others) == np.array(example)[:, None], axis=0))
