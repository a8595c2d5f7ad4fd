"""Sine, cosine and arctangent as LLVM instructions on vectors with one value per pose (a lane), without calls of functions.

Sines and cosines are Taylor polynomials of the angle minus the nearest multiple of π/2, which is subtracted in three parts.
Arctangents are polynomials of the tangent; a rotation of the point by π/4 keeps the tangent below tan π/8. The Chebyshev
coefficients of these polynomials decrease as powers of tan π/16.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence
from itertools import count

#: Constant that is added to round a number to an integer; the integer is then in the last bits of the mantissa.
_ROUNDER = 1.5 * 2.0**52
#: Numbers whose sum is π/2. The first two have 33 bits of mantissa, so that products with a number of quarter turns are exact.
_QUARTER = (1.5707963267341256, 6.077100506303966e-11, 2.0222662487959506e-21)
#: π/4 minus its floating-point number.
_REST_OF_AN_EIGHTH = 3.061616997868383e-17
_SINE = [(-1) ** k / math.factorial(2 * k + 1) for k in range(1, 9)]
_COSINE = [(-1) ** k / math.factorial(2 * k) for k in range(2, 9)]
#: Coefficients of t³, t⁵, … in arctan t, |t| ≤ tan π/8: eleven terms of the Chebyshev series
#: Σ 2 (−1)ⁿ tan²ⁿ⁺¹(π/16) / (2n + 1) T₂ₙ₊₁(t / tan π/8). The coefficient of t is 1.
_ARCTANGENT = (
    -0.3333333333331411, 0.19999999997060347, -0.14285714077811654, 0.1111110291878184, -0.09090711055931741,
    0.07689214063147491, -0.06634665375805353, 0.05662631000495569, -0.042815597215545675, 0.02039846638448244,
)  # fmt: skip


def kind_of(kind: str, lanes: int) -> str:
    """Return the LLVM type of a vector of ``lanes`` values of type ``kind``; with 0 lanes, the type of a single value."""
    return f"<{lanes} x {kind}>" if lanes else kind


def suffix(lanes: int) -> str:
    """Return the suffix of an intrinsic function's name for operands of ``lanes`` values."""
    return f"v{lanes}f64" if lanes else "f64"


def constant(value: float | bool, lanes: int) -> str:
    """Return the text of a constant with ``value`` in all lanes: a truth value, an integer or a floating-point number."""
    if isinstance(value, bool):
        kind, digits = "i1", "true" if value else "false"
    elif isinstance(value, int):
        kind, digits = "i64", str(value)
    else:
        kind, digits = "double", "0x" + struct.pack(">d", value).hex().upper()
    return "<" + ", ".join([f"{kind} {digits}"] * lanes) + ">" if lanes else digits


class Instructions:
    """LLVM instructions of one operation.

    Args:
        result: name of the final result; intermediate results are called ``result_0``, ``result_1``, ….
        lanes: poses per instruction; 0: the operation does not depend on the pose.
    """

    def __init__(self, result: str, lanes: int) -> None:
        self.lines: list[str] = []
        self._result, self._lanes, self._numbers = result, lanes, count()
        self.real, self.whole, self.truth = kind_of("double", lanes), kind_of("i64", lanes), kind_of("i1", lanes)

    def add(self, text: str, last: bool = False) -> str:
        """Add an instruction and return the name of its result; ``last``: whether this is the final result."""
        name = self._result if last else f"{self._result}_{next(self._numbers)}"
        self.lines.append(f"{name} = {text}")
        return name

    def of(self, what: str, *operands: str | float) -> str:
        """Add an arithmetic instruction on floating-point operands."""
        return self.add(f"{what} {self.real} {', '.join(self.text(operand) for operand in operands)}")

    def call(self, what: str, *operands: str | float, last: bool = False) -> str:
        """Add a call of an intrinsic function."""
        taken = ", ".join(f"{self.real} {self.text(operand)}" for operand in operands)
        return self.add(f"call {self.real} @llvm.{what}.{suffix(self._lanes)}({taken})", last)

    def choose(self, condition: str, a: str | float, b: str | float) -> str:
        """Add a selection: ``a`` where the condition is true, else ``b``."""
        return self.add(f"select {self.truth} {condition}, {self.real} {self.text(a)}, {self.real} {self.text(b)}")

    def polynomial(self, z: str, coefficients: Sequence[float]) -> str:
        """Add the polynomial Σ ``coefficients[k]`` zᵏ, by Horner's rule."""
        result: str | float = coefficients[-1]
        for value in coefficients[-2::-1]:
            result = self.call("fmuladd", result, z, value)
        return str(result)

    def bits(self, text: str, value: int, what: str) -> str:
        """Add an integer instruction whose second operand is a constant."""
        return self.add(f"{what} {self.whole} {text}, {constant(value, self._lanes)}")

    def text(self, operand: str | float) -> str:
        """Return the text of an operand: the name of a result unchanged, a number as a constant."""
        return operand if isinstance(operand, str) else constant(operand, self._lanes)


def sine_or_cosine(lines: Instructions, angle: str, of_cosine: bool) -> None:
    """Add the instructions that compute the sine of an angle or, if ``of_cosine``, its cosine."""
    shifted = lines.call("fmuladd", angle, 2 / math.pi, _ROUNDER)
    quarters = lines.of("fsub", shifted, _ROUNDER)
    remainder = angle
    for part in _QUARTER:
        remainder = lines.call("fmuladd", quarters, -part, remainder)
    z = lines.of("fmul", remainder, remainder)
    sine = lines.call("fmuladd", lines.of("fmul", lines.polynomial(z, _SINE), z), remainder, remainder)
    square = lines.of("fmul", z, z)
    cosine = lines.call("fmuladd", lines.polynomial(z, _COSINE), square, lines.call("fmuladd", z, -0.5, 1.0))
    number = lines.add(f"bitcast {lines.real} {shifted} to {lines.whole}")
    if of_cosine:
        number = lines.bits(number, 1, "add")
    odd = lines.add(f"trunc {lines.whole} {number} to {lines.truth}")
    value = lines.choose(odd, cosine, sine)
    sign = lines.bits(lines.bits(number, 2, "and"), 62, "shl")
    turned = lines.add(f"xor {lines.whole} {sign}, {lines.add(f'bitcast {lines.real} {value} to {lines.whole}')}")
    lines.add(f"bitcast {lines.whole} {turned} to {lines.real}", last=True)


def angle_of_point(lines: Instructions, y: str, x: str) -> None:
    """Add the instructions that compute atan2(y, x)."""
    across, along = lines.call("fabs", y), lines.call("fabs", x)
    steep = lines.add(f"fcmp ogt {lines.real} {across}, {along}")
    large, small = lines.choose(steep, across, along), lines.choose(steep, along, across)
    half = math.sqrt(2) - 1
    wide = lines.add(f"fcmp ogt {lines.real} {small}, {lines.of('fmul', large, half)}")
    above = lines.choose(wide, lines.of("fsub", small, large), small)
    below = lines.choose(wide, lines.of("fadd", small, large), large)
    nothing = lines.add(f"fcmp oeq {lines.real} {below}, {lines.text(0.0)}")
    t = lines.of("fdiv", above, lines.choose(nothing, 1.0, below))
    z = lines.of("fmul", t, t)
    angle = lines.call("fmuladd", lines.of("fmul", lines.polynomial(z, _ARCTANGENT), z), t, t)
    behind = lines.add(f"fcmp olt {lines.real} {lines.call('copysign', 1.0, x)}, {lines.text(0.0)}")
    eighths: str = lines.choose(wide, 1.0, 0.0)  # of a full turn: a further part of the angle
    for where, of in ((steep, 2.0), (behind, 4.0)):
        eighths = lines.choose(where, lines.of("fsub", of, eighths), eighths)
        angle = lines.choose(where, lines.of("fneg", angle), angle)
    angle = lines.call("fmuladd", eighths, _REST_OF_AN_EIGHTH, angle)
    lines.call("copysign", lines.call("fmuladd", eighths, math.pi / 4, angle), y, last=True)
