"""How a class is printed without knowing its report: the functions of reports register themselves here, by class.

A class calls these functions; the modules that know how to answer stand above it (:mod:`kinetostatics.reports`).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import singledispatch
from importlib import import_module
from typing import Any, TypeAlias, TypeVar

R = TypeVar("R")
Json: TypeAlias = Any  # what json.loads returns, and what is changed before json.dumps takes it

#: Modules that register reports. They are imported when something is printed for the first time: importing the package is quick.
LATE_MODULES: list[str] = []


@singledispatch
def text_of(item: object, **options: object) -> str:
    """Return the whole report of something, which ``print`` shows."""
    return str(_late(text_of.dispatch, item)(item, **options))


@singledispatch
def dict_of(item: object) -> dict[str, object]:
    """Return everything about something as plain numbers, lists and strings, fit for JSON."""
    return dict(_late(dict_of.dispatch, item)(item))


@singledispatch
def line_of(item: object) -> str:
    """Return the one line about something that ``repr`` shows."""
    return str(_late(line_of.dispatch, item)(item))


@singledispatch
def html_of(item: object) -> str:
    """Return the HTML table about something that notebooks show."""
    return str(_late(html_of.dispatch, item)(item))


@singledispatch
def warnings_of(item: object) -> tuple[str, ...]:
    """Return what to be careful about in something, in full sentences."""
    return tuple(_late(warnings_of.dispatch, item)(item))


@singledispatch
def urdf_of(item: object) -> str:
    """Return the text of a robot file that loads as the same robot."""
    return str(_late(urdf_of.dispatch, item)(item))


def _late(dispatch: Callable[[type], Callable[..., R]], item: object) -> Callable[..., R]:
    """Return the function for something that none was registered for until now."""
    for name in LATE_MODULES:
        import_module(name)
    found = dispatch(type(item))
    if found is dispatch(object):
        raise NotImplementedError(f"nothing is registered that writes a {type(item).__name__}")
    return found


class Shown:
    """A base of classes whose ``repr`` is one line, and which notebooks show as a table."""

    def __repr__(self) -> str:
        return line_of(self)

    def _repr_html_(self) -> str:
        return html_of(self)


class Told(Shown):
    """A base of classes that print as a whole report, and tell everything as plain values too."""

    def __str__(self) -> str:
        return text_of(self)

    def to_dict(self) -> dict[str, Json]:
        """Return everything as plain numbers, lists and strings: what ``--json`` prints."""
        return dict_of(self)
