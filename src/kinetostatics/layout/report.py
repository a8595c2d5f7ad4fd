"""Reports with their data as JSON values, and the base class of objects with a report."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from enum import Enum
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np

from kinetostatics import hooks
from kinetostatics.arguments import check_choice, need
from kinetostatics.exceptions import ArgumentError, near_names
from kinetostatics.layout.blocks import ReportSection
from kinetostatics.layout.renderings import report_html, report_text
from kinetostatics.math.arrays import Array

Json: TypeAlias = Any  # values of json.loads and json.dumps
#: Labels of the n rows of each pose, and numbers (…, n) by title with the SI unit, batch axes first.
NumberTable: TypeAlias = tuple[Mapping[str, Sequence[object]], Mapping[str, Array]]


def as_json(value: object) -> Json:
    """Return a value as JSON data: a dataclass as a dict of its fields; a number that is not finite as None."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return attributes(value, (field.name for field in dataclasses.fields(value)))
    if isinstance(value, Mapping):
        return {str(key): as_json(part) for key, part in value.items()}
    if isinstance(value, (list, tuple)):
        return [as_json(part) for part in value]
    if isinstance(value, Enum):
        return value.name
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if isinstance(value, (np.ndarray, np.generic, float)) and not isinstance(value, np.str_):
        array = np.asarray(value)
        if array.dtype.kind == "f" and not np.all(np.isfinite(array)):
            missing = ~np.isfinite(array)
            array = array.astype(object)
            array[missing] = None
        return array.tolist()
    return value


def attributes(owner: object, names: Iterable[str]) -> dict[str, Json]:
    return {name: as_json(getattr(owner, name)) for name in names}


class Report:
    """Report of an object: a title, sections, and data; sections and data are computed when they are needed.

    Attributes:
        title: parts of a single line; a :class:`Word` among them is coloured by its tone.
        tables: functions that return tables of numbers, by name.
    """

    def __init__(
        self,
        title: str | Sequence[str],
        sections: Callable[[], Iterable[ReportSection]],
        data: Callable[[], Mapping[str, object]] = dict,
        tables: Mapping[str, Callable[[], NumberTable]] | None = None,
    ) -> None:
        self.title: Sequence[str] = (title,) if isinstance(title, str) else title
        self._sections, self._data, self.tables = sections, data, tables or {}

    @cached_property
    def sections(self) -> list[ReportSection]:
        """The sections that are not empty."""
        return [section for section in self._sections() if section.blocks]

    def brief(self) -> Report:
        """Return the report without its detailed sections."""
        return self._with(lambda: (section for section in self.sections if not section.detail))

    def only(self, *keys: str) -> Report:
        """Return the report with the sections of these keys, and all sections whose title is None.

        Raises:
            ArgumentError: the report has no section with one of these keys.
        """
        section_keys = list(dict.fromkeys(section.key for section in self.sections if section.key))
        for key in keys:
            if key not in section_keys:
                raise ArgumentError(f"the report has no section {key!r}: {near_names(key, section_keys)}")
        return self._with(lambda: (section for section in self.sections if section.title is None or section.key in keys))

    def _with(self, sections: Callable[[], Iterable[ReportSection]]) -> Report:
        return Report(self.title, sections, self._data, self.tables)

    def text(self, colour: bool = False) -> str:
        return report_text(self.title, self.sections, colour)

    def html(self) -> str:
        return report_html("".join(self.title), self.sections)

    def to_dict(self) -> dict[str, Json]:
        """Return the data as plain numbers, lists and strings."""
        return {name: as_json(value) for name, value in self._data().items()}

    def __str__(self) -> str:
        return self.text()

    def __repr__(self) -> str:
        return f"<{''.join(self.title)}>"

    def _repr_html_(self) -> str:
        return self.html()


class Reported:
    """Base of classes whose objects have a report, made by :mod:`kinetostatics.reports`."""

    def report(self) -> Report:
        """Return the whole report; ``print`` shows the brief one."""
        return hooks.report_of(self)  # type: ignore[no-any-return]

    def __repr__(self) -> str:
        return repr(self.report())

    def __str__(self) -> str:
        return str(self.report().brief())

    def _repr_html_(self) -> str:
        return self.report().brief().html()

    def to_dict(self) -> dict[str, Json]:
        """Return all data as plain numbers, lists and strings, as printed by ``--json``."""
        return self.report().to_dict()


class Tabulated(Reported):
    """Base of classes whose objects also have tables of numbers."""

    def to_dataframe(self, table: str | None = None) -> Any:
        """Return a table as a ``pandas.DataFrame`` in SI units, with the batch axes, if any, and the names of the rows as index.

        Args:
            table: name of the table: of a result "contributions" (default: twist and actuator forces by contribution) or "parts"
                (twist by elastic part and assembly error); of modes "modes".

        Raises:
            ArgumentError: there is no such table.
            KinetostaticsError: the package pandas is missing.
        """
        tables = self.report().tables
        name = next(iter(tables)) if table is None else table
        check_choice("table", name, tuple(tables))
        need("a DataFrame", "dataframe", "pandas")
        import pandas  # type: ignore[import-untyped, unused-ignore]

        rows, columns = tables[name]()
        *poses, number = (axis.ravel() for axis in np.indices(next(iter(columns.values())).shape))
        index = {f"axis {k}": axis for k, axis in enumerate(poses)}
        index |= {label: np.array([*names])[number] for label, names in rows.items()}
        return pandas.DataFrame({**index, **{title: column.ravel() for title, column in columns.items()}}).set_index([*index])
