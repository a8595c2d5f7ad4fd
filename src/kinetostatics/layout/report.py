"""Reports, and the base class of objects that have one."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cached_property
from importlib import import_module
from typing import Any, ClassVar

from kinetostatics.exceptions import ArgumentError, near_names
from kinetostatics.layout.blocks import ReportSection
from kinetostatics.layout.html import report_html
from kinetostatics.layout.plain import Json, plain
from kinetostatics.layout.text import report_text


class Report:
    """Report of an object: a title, sections, and data; sections and data are created on first use.

    Attributes:
        title: parts of a single line; a :class:`Word` among them has a tone.
    """

    def __init__(
        self,
        title: str | Sequence[str],
        sections: Callable[[], Iterable[ReportSection]],
        data: Callable[[], Mapping[str, object]] = dict,
    ) -> None:
        self.title: Sequence[str] = (title,) if isinstance(title, str) else title
        self._sections, self._data = sections, data

    @cached_property
    def sections(self) -> list[ReportSection]:
        """The sections that are not empty."""
        return [section for section in self._sections() if section.blocks]

    def brief(self) -> Report:
        """Return the report without its sections of detail."""
        return self._with(lambda: (section for section in self.sections if not section.detail))

    def only(self, *keys: str) -> Report:
        """Return the report with some sections only.

        Raises:
            ArgumentError: there is no such section.
        """
        known = list(dict.fromkeys(section.key for section in self.sections if section.key))
        for key in keys:
            if key not in known:
                raise ArgumentError(f"the report has no section {key!r}: {near_names(key, known)}")
        return self._with(lambda: (section for section in self.sections if section.title is None or section.key in keys))

    def _with(self, sections: Callable[[], Iterable[ReportSection]]) -> Report:
        return Report(self.title, sections, self._data)

    def text(self, colour: bool = False) -> str:
        """Return the report as text, with the codes of colours or without."""
        return report_text(self.title, self.sections, colour)

    def html(self, level: int = 3) -> str:
        """Return the report as HTML, the titles of sections as headings of a level."""
        return report_html("".join(self.title), self.sections, level)

    def to_dict(self) -> dict[str, Json]:
        """Return the data as plain numbers, lists and strings."""
        return {name: plain(value) for name, value in self._data().items()}

    def __str__(self) -> str:
        return self.text()

    def __repr__(self) -> str:
        return f"<{''.join(self.title)}>"

    def _repr_html_(self) -> str:
        return self.html()


class Reported:
    """Base of classes with a report: ``class Result(Reported, builder="reports.result:result_report")``.

    The builder is a function that returns the :class:`Report` of an object; it is imported on first use.
    """

    _builder: ClassVar[str]

    def __init_subclass__(cls, builder: str = "", **more: object) -> None:
        super().__init_subclass__(**more)
        if builder:
            cls._builder = builder

    def report(self) -> Report:
        """Return the whole report; ``print`` shows it in brief."""
        return late(self._builder)(self)  # type: ignore[no-any-return]

    def __repr__(self) -> str:
        return repr(self.report())

    def __str__(self) -> str:
        return str(self.report().brief())

    def _repr_html_(self) -> str:
        return self.report().brief().html()

    def to_dict(self) -> dict[str, Json]:
        """Return all data as plain numbers, lists and strings, as printed by ``--json``."""
        return self.report().to_dict()


def late(path: str) -> Callable[..., Any]:
    """Return a function of the package by "module:function", for modules that must not import it."""
    module, _, name = path.partition(":")
    return getattr(import_module(f"kinetostatics.{module}"), name)  # type: ignore[no-any-return]
