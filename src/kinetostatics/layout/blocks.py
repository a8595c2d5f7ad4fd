"""Parts of a report: tables, facts, sentences and drawings; numbers are SI values with a number format."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.layout.numbers import NumberFormat, Units, largest

Tone: TypeAlias = Literal["good", "doubtful", "bad"]


class Word(str):
    """The name of a state in a report, such as ``SINGULAR``; it is coloured by its ``tone``."""

    tone: Tone

    def __new__(cls, text: str, tone: Tone) -> Word:
        word = super().__new__(cls, text)
        word.tone = tone
        return word


@dataclass(frozen=True)
class Number:
    """A number [SI] with its format, or a range from ``value`` to ``upper``; ``with_unit``: whether the unit is written."""

    value: float
    format: NumberFormat
    upper: float | None = None
    with_unit: bool = True

    @classmethod
    def of(cls, value: ArrayLike, units: Units, noise: float = 0.0, digits: int = 5) -> Number:
        """Return one number in a unit that suits its magnitude."""
        return cls(float(np.asarray(value)), NumberFormat.of(value, units, noise, digits))

    @classmethod
    def range_of(cls, values: ArrayLike, units: Units, noise: float = 0.0) -> Number:
        """Return the range from the smallest to the largest finite value; NaN if no value is finite."""
        finite = np.asarray(values, dtype=float).ravel()
        finite = finite[np.isfinite(finite)]
        if not finite.size:
            return cls(math.nan, NumberFormat("", 1.0, 0, 0.0), with_unit=False)
        form = NumberFormat.of(finite, units, noise, digits=4)
        return cls(float(finite.min()), form, float(finite.max()))

    def __str__(self) -> str:
        low = self.format(self.value)
        if self.upper is None or self.format(self.upper) == low:
            return self.format.with_unit(self.value) if self.with_unit else low
        return f"{low} to {self.format.with_unit(self.upper)}"


Cell: TypeAlias = "str | Number | float | None"


@dataclass(frozen=True)
class Column:
    """A column of a table.

    Attributes:
        title: title without the unit.
        cells: texts, numbers with formats of their own, values [SI] in ``format``, or None for empty cells.
        side: alignment of the cells, ``l`` or ``r``.
        format: format of the values [SI].
        with_unit: whether the heading contains the unit of ``format``.
    """

    title: str
    cells: Sequence[Cell]
    side: str = "l"
    format: NumberFormat | None = None
    with_unit: bool = True

    @classmethod
    def of(
        cls, title: str, values: Sequence[ArrayLike | None], form: NumberFormat | Units, with_unit: bool = True, digits: int = 4
    ) -> Column:
        """Return a column of numbers [SI] in the unit that suits the largest value, which is written with ``digits`` digits."""
        if not isinstance(form, NumberFormat):
            form = NumberFormat.of(largest(value for value in values if value is not None), form, digits=digits)
        cells = [None if value is None else float(np.asarray(value)) for value in values]
        return cls(title, cells, "r", form, with_unit)

    @classmethod
    def in_formats(cls, title: str, values: Iterable[ArrayLike], formats: Iterable[NumberFormat]) -> Column:
        """Return a column of numbers [SI], each in a format of its own, without units."""
        numbers = zip(values, formats, strict=True)
        return cls(title, [Number(float(np.asarray(value)), form, with_unit=False) for value, form in numbers], "r")

    @property
    def heading(self) -> str:
        return f"{self.title} [{self.format.unit}]" if self.format is not None and self.with_unit else self.title

    @property
    def texts(self) -> list[str]:
        return [self._text(cell) for cell in self.cells]

    def _text(self, cell: Cell) -> str:
        if isinstance(cell, str):
            return cell
        if isinstance(cell, float):
            return self.format(cell) if self.format is not None else f"{cell:.6g}"
        return "" if cell is None else str(cell)


@dataclass(frozen=True)
class Table:
    """Columns of equal length; as text, columns of a ``wide`` table that do not fit are written below the others."""

    columns: Sequence[Column]
    wide: bool = False

    @classmethod
    def of_rows(cls, header: Sequence[str], rows: Iterable[Sequence[Cell]], align: str = "", wide: bool = False) -> Table:
        """Return a table of rows; ``align`` has ``l`` or ``r`` for each column; default: first column left, others right."""
        cells = [list(row) for row in rows]
        align = align or "l" + "r" * (len(header) - 1)
        return cls(
            [Column(title, [row[k] for row in cells], side) for k, (title, side) in enumerate(zip(header, align, strict=True))],
            wide,
        )


@dataclass(frozen=True)
class Facts:
    """Rows of a name and its value: a text, a number, or several texts on separate lines."""

    rows: Sequence[tuple[str, str | Number | Sequence[str]]]
    indent: int = 0


@dataclass(frozen=True)
class Text:
    """One or more sentences.

    Attributes:
        text: the text after ``lead``.
        kind: "warning", "item" of a list, or "" for a plain sentence.
        lead: name of a state, written before the text.
        indent: indentation [letters].
    """

    text: str
    kind: Literal["", "warning", "item"] = ""
    lead: Word | None = None
    indent: int = 0


@dataclass(frozen=True)
class Lines:
    """Lines of a drawing, such as the chain of a limb, in a monospaced font."""

    lines: Sequence[str]


Block: TypeAlias = "Table | Facts | Text | Lines"


@dataclass(frozen=True)
class ReportSection:
    """A part of a report.

    Attributes:
        title: title; "": no title, and text without indentation; None: the section follows the report's title, and is part of
            every selection.
        blocks: contents; an empty section is omitted.
        key: name for the selection of sections.
        detail: whether the section is omitted in brief reports.
    """

    title: str | None
    blocks: Sequence[Block]
    key: str = ""
    detail: bool = False


def warning_section(warnings: Iterable[str]) -> ReportSection:
    """Return the section of warnings; without warnings, its text is "none"."""
    return ReportSection("Warnings", [Text(text, "warning") for text in warnings] or [Text("none")], "warnings")


def without_repetitions(names: Iterable[str]) -> list[str]:
    listed = list(names)  # a name that equals the one before becomes empty
    return ["" if k and listed[k - 1] == name else name for k, name in enumerate(listed)]
