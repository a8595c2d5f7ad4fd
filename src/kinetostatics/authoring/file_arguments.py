"""The xacro arguments of a generated file: names, defaults and comments."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from numbers import Real

from kinetostatics.exceptions import ArgumentError, near_names

#: Largest plausible lengths [m], by the last part of an argument's name; larger ones are probably in mm.
LARGEST = {
    **dict.fromkeys(("radius", "height", "length", "stroke"), 20.0),
    **dict.fromkeys(("width", "diameter", "thickness"), 4.0),
}
_LENGTH = re.compile(f"({'|'.join(LARGEST)})$")


@dataclass
class FileArguments:
    """Arguments of a file; given values replace defaults.

    Attributes:
        given: given values by name.
        texts: texts of the defaults by name, in the order of the file.
        comments: meanings by name.
        headings: comments on a separate line before an argument, by its name.
    """

    given: Mapping[str, object]
    texts: dict[str, str] = field(default_factory=dict)
    comments: dict[str, str] = field(default_factory=dict)
    headings: dict[str, str] = field(default_factory=dict)

    def add(self, name: str, default: object, comment: str = "", heading: str = "") -> None:
        """Add an argument, unless it exists."""
        if name in self.texts:
            return
        self.texts[name] = text_of_value(name, self.given.get(name, default))
        self.comments[name] = comment
        if heading:
            self.headings[name] = heading

    def number(self, name: str, default: float) -> float:
        """Return the given or default number of an argument."""
        value = self.given.get(name, default)
        try:
            number = float(value)  # type: ignore[arg-type]
        except (TypeError, ValueError):
            raise ArgumentError(f"{name} is {value!r}; it must be a number, in SI units") from None
        if not math.isfinite(number):
            raise ArgumentError(f"{name} is {value!r}; it must be a finite number")
        return number

    def length(self, name: str, default: float) -> float:
        """Return the given or default length of an argument [m], which must be positive."""
        number = self.number(name, default)
        if number <= 0:
            raise ArgumentError(f"{name} is {self.given.get(name)!r}; it must be greater than zero, in metres")
        return number

    def check_all_used(self, reasons: Mapping[str, str]) -> None:
        """Raise an error for values of unknown arguments, with the reason in ``reasons`` or similar names."""
        for name in self.given:
            if name not in self.texts:
                reason = reasons.get(name, near_names(name, self.texts))
                raise ArgumentError(f"this robot has no value {name!r}: {reason}")

    def lines(self, used_in: str) -> list[str]:
        """Return the lines with the declarations of arguments, and of properties for arguments used in expressions.

        Args:
            used_in: text with the expressions.
        """
        expressions = "".join(re.findall(r"\$\{[^}]*\}", "\n".join((used_in, *self.texts.values()))))
        used = set(re.findall(r"\w+", expressions))
        first: list[str] = []
        properties: list[str] = []
        late: list[str] = []
        for name, text in self.texts.items():
            argument = f'  <xacro:arg name="{name}" default="{text}"/>'
            if self.comments[name]:
                argument = f"{argument:<58} <!-- {self.comments[name]} -->"
            value = [f'  <xacro:property name="{name}" value="$(arg {name})"/>'] if name in used else []
            if "${" in text and any(other in re.findall(r"\w+", text) for other in self.texts):
                late += [argument, *value]
                continue
            first += ["", f"  <!-- {self.headings[name]} -->"] if name in self.headings else []
            first.append(argument)
            properties += value
        note = ["", "  <!-- what follows from these values, unless it is given -->"] if late else []
        return [*first, "", *properties, *note, *late]


def odd_lengths(values: Mapping[str, object]) -> list[str]:
    """Return hints at implausibly large lengths [m], which are probably in mm."""
    found = []
    for name, value in values.items():
        match = _LENGTH.search(name)
        try:
            number = float(value)  # type: ignore[arg-type]
        except (TypeError, ValueError):
            continue
        if match is not None and LARGEST[match[1]] < abs(number) < math.inf:
            found.append(
                f"{name} = {number:g} m: lengths are in m; write {number / 1000:g} for {number:g} mm, or {number:g}mm on the "
                "command line"
            )
    return found


def text_of_value(name: str, value: object) -> str:
    """Return a value as the text of an argument's default."""
    if isinstance(value, str):
        if any(sign in value for sign in '<>&"'):
            raise ArgumentError(f"{name} is {value!r}; it must be a number or a plain text")
        return value
    if isinstance(value, bool) or not isinstance(value, Real):
        if isinstance(value, (list, tuple)) or hasattr(value, "tolist"):
            return " ".join(text_of_value(name, item) for item in value)  # type: ignore[attr-defined]
        raise ArgumentError(f"{name} is {value!r}; it must be a number")
    number = float(value)
    short = f"{number:g}".replace("e+", "e")
    return short if float(short) == number else repr(number)


def rounded(value: float) -> float:
    """Return a length rounded to two digits."""
    return float(f"{value:.2g}")
