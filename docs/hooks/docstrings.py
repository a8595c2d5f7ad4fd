"""Docstrings as the site shows them.

Sphinx's roles, as ``:func:`kinetostatics.sweep```, become code that leads to the entry, where there is one. What is said of
several arguments or attributes at once, as ``lower, upper: the limits``, is said of each.
"""

from __future__ import annotations

import re
from typing import Any

import griffe

import kinetostatics

ROLE = re.compile(r":(?:func|class|meth|attr|mod|data|exc):`~?([\w.]+)`")
#: what is said of several things at once, with the lines that go on with it
SEVERAL = re.compile(r"^    (\w+)((?:, \w+)+)(: .*(?:\n {5,}.*)*)$", re.MULTILINE)


class Docstrings(griffe.Extension):
    """Changes the docstring of everything."""

    def on_object(self, *, obj: griffe.Object, **_more: Any) -> None:
        """Look at one function, class, module or attribute."""
        if obj.docstring is None:
            return

        def link(found: re.Match[str]) -> str:
            name = found[1].removeprefix("kinetostatics.")
            public = name.partition(".")[0] in kinetostatics.__all__
            path = "kinetostatics" if public or "." in name or obj.parent is None else obj.parent.path
            return f'<autoref optional identifier="{path}.{name}"><code>{name}</code></autoref>'

        def each(found: re.Match[str]) -> str:
            others = found[2].removeprefix(", ").split(", ")
            return f"    {found[1]}{found[3]}" + "".join(f"\n    {other}: likewise." for other in others)

        obj.docstring.value = SEVERAL.sub(each, ROLE.sub(link, obj.docstring.value))
