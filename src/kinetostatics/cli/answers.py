"""How commands answer: reports, JSON, warnings and figures."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable, Mapping, Sequence

from kinetostatics.printing.colour import for_stream


def save_figure(path: str | None, kind: str, *shown: object, dpi: float = 300, **options: object) -> None:
    """Draw a figure of a kind of :mod:`kinetostatics.plot` and write it to a file, if there is a path for it."""
    if path is not None:
        from kinetostatics import plot  # which says what to install where Matplotlib is missing
        from kinetostatics.plot.style import draw_into_files, save_and_close

        draw_into_files()
        save_and_close(getattr(plot, kind)(*shown, **options), path, dpi)


def print_json(values: Mapping[str, object]) -> None:
    """Print a dict of plain values as JSON: one entry a line, arrays in one line."""
    encoding = (getattr(sys.stdout, "encoding", None) or "ascii").lower().replace("-", "")
    print(_json(values, "", encoding != "utf8"))


def _json(value: object, indent: str, ascii_only: bool) -> str:
    inner = indent + "  "
    if isinstance(value, list) and value and isinstance(value[0], Mapping):
        items = [inner + _json(item, inner, ascii_only) for item in value]
        return "[\n" + ",\n".join(items) + f"\n{indent}]"
    if not isinstance(value, Mapping) or not value:
        return json.dumps(value, allow_nan=False, ensure_ascii=ascii_only)
    rows = [
        f"{inner}{json.dumps(name, ensure_ascii=ascii_only)}: {_json(item, inner, ascii_only)}" for name, item in value.items()
    ]
    return "{\n" + ",\n".join(rows) + f"\n{indent}}}"


def print_report(text: str) -> None:
    """Print a report, in colour where the terminal wants it."""
    print(for_stream(text, sys.stdout))


def print_answer(found: str | dict[str, object], warnings: Sequence[str], *written: str | None) -> None:
    """Print what a command has found below the warnings of its pose, or as JSON with them and on standard error.

    Args:
        found: a report, or what is printed as JSON.
        warnings: of the pose.
        written: files that were written, which are told below a report; None: none.
    """
    if isinstance(found, str):
        print_report("\n".join([*(f"! {warning}" for warning in warnings), found]))
        for file in written:
            if file is not None:
                print(f"wrote {file}")
        return
    own = found.get("warnings")
    told = [*warnings, *(own if isinstance(own, list) else ())]
    print_json({**found, "warnings": told})
    print_warnings(told)


def print_warnings(warnings: Iterable[str]) -> None:
    """Print warnings to standard error, each in one line."""
    for warning in warnings:
        print(for_stream(f"kinetostatics: warning: {' '.join(warning.split())}", sys.stderr), file=sys.stderr)
