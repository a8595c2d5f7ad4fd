"""Derivatives of recorded scalar operations by automatic differentiation.

The reverse mode computes the derivatives of results with respect to inputs and parameters by NumPy, at many poses. The forward
mode records the rates of results. A. Griewank, A. Walther, Evaluating Derivatives, 2nd edition, 2008, chapter 3.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence

import numpy as np

from kinetostatics.engine.recorder import Recorded, recording
from kinetostatics.engine.scalars import LEAVES, Number, Scalar, Tape, needed_by, operands
from kinetostatics.math.arrays import Array

#: Partial derivatives of an operation's result with respect to its operands, as functions of operands and result. The derivative
#: of ``choose`` is that of the chosen operand; other operations, such as comparisons, have zero derivatives.
PARTIALS: dict[str, Callable[..., tuple[Number, ...]]] = {
    "add": lambda a, b, result: (1.0, 1.0),
    "subtract": lambda a, b, result: (1.0, -1.0),
    "multiply": lambda a, b, result: (b, a),
    "divide": lambda a, b, result: (1.0 / b, -result / b),
    "negative": lambda a, result: (-1.0,),
    "square_root": lambda a, result: (0.5 / result,),
    "absolute": lambda a, result: (np.sign(a),),
    "sine": lambda a, result: (np.cos(a),),
    "cosine": lambda a, result: (-np.sin(a),),
    "angle": lambda y, x, result: (x / (x * x + y * y), -y / (x * x + y * y)),
}
#: Operations whose partial derivatives may be infinite where their result is not chosen.
_MAY_BE_INFINITE = ("divide", "square_root", "angle")

#: The operations as functions of NumPy.
_FUNCTIONS: Mapping[str, Callable[..., Number]] = {
    "add": np.add,
    "subtract": np.subtract,
    "multiply": np.multiply,
    "divide": np.divide,
    "negative": np.negative,
    "square_root": np.sqrt,
    "absolute": np.abs,
    "sine": np.sin,
    "cosine": np.cos,
    "angle": np.arctan2,
    "whole": np.rint,
    "and": np.logical_and,
    "or": np.logical_or,
    "not": np.logical_not,
    ">": np.greater,
    ">=": np.greater_equal,
    "<": np.less,
    "<=": np.less_equal,
    "==": np.equal,
    "!=": np.not_equal,
    "choose": np.where,
}


def values(tape: Tape, needed: Sequence[bool], inputs: Sequence[Array], parameters: Sequence[Number] | Array) -> list[Number]:
    """Return the result of each needed operation at N poses, a number or an array (N,); None for operations that are not needed.

    Args:
        inputs: the input arrays (components, N).
        parameters: the P numbers of the robot; a number that differs from pose to pose is an array (N,).
    """
    results: list[Number] = [None] * len(needed)
    with np.errstate(all="ignore"):
        for number, is_needed in enumerate(needed):
            if not is_needed:
                continue
            name, *taken = tape.operations[number]
            if name == "input":
                results[number] = inputs[taken[0]][taken[1]]
            elif name == "parameter":
                results[number] = parameters[taken[0]]
            elif name == "constant":
                results[number] = float.fromhex(taken[0])
            elif name == "truth":
                results[number] = taken[0]
            else:
                results[number] = _FUNCTIONS[name](*[results[k] for k in taken])
    return results


def gradients(tape: Tape, results: Sequence[Number], outputs: Sequence[int], leaves: Iterable[int], N: int) -> dict[int, Array]:
    """Return the derivatives (outputs, N) of results with respect to inputs and parameters, by the index of their operation.

    Inputs and parameters without influence are omitted.

    Args:
        results: the results of all operations, see :func:`values`.
        outputs: indices of the operations whose results are differentiated.
        leaves: indices of the operations of the inputs and parameters.
    """
    leaves = set(leaves)
    active = [False] * len(results)
    for number, value in enumerate(results):
        if value is not None:
            name = tape.operations[number][0]
            if name in PARTIALS or name == "choose":
                active[number] = any(active[k] for k in operands(tape.operations[number]))
            else:
                active[number] = number in leaves
    adjoints: list[Number] = [None] * len(results)
    for row, number in enumerate(outputs):
        if active[number]:
            if adjoints[number] is None:
                adjoints[number] = np.zeros((len(outputs), N))
            adjoints[number][row] += 1.0

    def put(number: int, by: Number) -> None:
        adjoints[number] = by if adjoints[number] is None else adjoints[number] + by

    derivatives: dict[int, Array] = {}
    with np.errstate(all="ignore"):
        for number in range(len(results) - 1, -1, -1):
            adjoint = adjoints[number]
            if adjoint is None:
                continue
            name, *taken = tape.operations[number]
            adjoints[number] = None
            if name in LEAVES:
                derivatives[number] = adjoint
            elif name == "choose":
                condition, a, b = taken
                for operand, chosen in ((a, results[condition]), (b, np.logical_not(results[condition]))):
                    if active[operand]:
                        put(operand, np.where(chosen, adjoint, 0.0))
            else:
                partials = PARTIALS[name](*[results[k] for k in taken], results[number])
                for partial, operand in zip(partials, taken, strict=True):
                    if active[operand]:
                        product = partial * adjoint
                        if name in _MAY_BE_INFINITE:
                            product = np.where(adjoint == 0, 0.0, product)
                        put(operand, product)
    return derivatives


def tangent_record(tape: Tape, outputs: Sequence[int], inputs: int) -> list[int]:
    """Record the rates of results for given rates of the inputs; return the indices of the operations of these rates.

    The rates of the inputs are inputs on the same tape: the rates of input array number k are input array number ``inputs`` + k.

    Args:
        tape: the recorded operations; operations are added.
        outputs: indices of the operations whose results are differentiated.
        inputs: number of input arrays.
    """
    rates: dict[int, Number] = {}

    def scalar_of(number: int) -> Number:
        scalar = Scalar(tape, number, tape.values[number])
        return np.array([scalar], dtype=object).view(Recorded)

    with recording():
        for number, is_needed in enumerate(needed_by(tape, outputs)):
            if not is_needed:
                continue
            name, *taken = tape.operations[number]
            if name == "input":
                rates[number] = scalar_of(tape.write(("input", inputs + taken[0], taken[1]), 1.0).number)
            elif name == "choose":
                condition, a, b = taken
                if a in rates or b in rates:
                    rates[number] = np.where(scalar_of(condition), rates.get(a, 0.0), rates.get(b, 0.0))
            elif name in PARTIALS and any(operand in rates for operand in taken):
                partials = PARTIALS[name](*[scalar_of(operand) for operand in taken], scalar_of(number))
                total: Number = 0.0
                for partial, operand in zip(partials, taken, strict=True):
                    if operand in rates:
                        product = partial * rates[operand]
                        if name in _MAY_BE_INFINITE:
                            product = np.where(rates[operand] == 0, 0.0, product)
                        total = total + product
                rates[number] = total
        return [tape.number_of(rates[number][0] if number in rates else 0.0) for number in outputs]
