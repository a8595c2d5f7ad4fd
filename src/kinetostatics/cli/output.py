"""Output of commands: reports, JSON, warnings and files."""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

from kinetostatics.arguments import Keyword
from kinetostatics.exceptions import ArgumentError
from kinetostatics.layout.renderings import painted, use_colour

if TYPE_CHECKING:
    from kinetostatics.layout.report import Report

#: Endings of figures.
FIGURES = ("svg", "pdf", "png")


def print_json(values: Mapping[str, object]) -> None:
    """Print numbers, texts, lists and mappings as JSON: one entry per line, each array in a single line."""
    encoding = (getattr(sys.stdout, "encoding", None) or "ascii").lower().replace("-", "")
    print(_json(values, "", encoding != "utf8"))


def _json(value: object, indent: str, ascii_only: bool) -> str:
    inner = indent + "  "
    if isinstance(value, list) and value and isinstance(value[0], Mapping):
        items = [inner + _json(part, inner, ascii_only) for part in value]
        return "[\n" + ",\n".join(items) + f"\n{indent}]"
    if not isinstance(value, Mapping) or not value:
        return json.dumps(value, allow_nan=False, ensure_ascii=ascii_only)
    rows = [
        f"{inner}{json.dumps(name, ensure_ascii=ascii_only)}: {_json(part, inner, ascii_only)}" for name, part in value.items()
    ]
    return "{\n" + ",\n".join(rows) + f"\n{indent}}}"


def print_report(report: Report, warnings: Sequence[str] = ()) -> None:
    """Print a report below warnings, in colour if the terminal supports it."""
    colour = use_colour(sys.stdout)
    print("\n".join([*(painted("warning", f"! {text}", colour) for text in warnings), report.text(colour)]))


def answer(result: Keyword, args: argparse.Namespace, warnings: Sequence[str] = ()) -> None:
    """Print warnings and a result or report, and the names of the written files.

    With ``--json``, print the result's data instead; they include the warnings, which are also printed to standard error.
    """
    written = getattr(args, "out", ())
    if args.json:
        values = result.to_dict()
        reported = [*warnings, *values.get("warnings", ())]
        print_json({**values, "warnings": reported})
        print_warnings(reported)
    else:
        print_report(result.report() if hasattr(result, "report") else result, warnings)
        print(*(f"wrote {file}\n" for file in written), sep="", end="")


def print_warnings(warnings: Iterable[str]) -> None:
    """Print warnings to standard error, each in one line."""
    for warning in warnings:
        print_message("warning", warning)


def print_message(kind: str, text: str, commands: Iterable[str] = ()) -> None:
    """Print an error or a warning to standard error in one line, and suggested commands below it."""
    if sys.stderr is not None:
        begin, line, colour = f"kinetostatics: {kind}:", " ".join(text.split()), use_colour(sys.stderr)
        whole = painted(kind, f"{begin} {line}", colour) if kind == "warning" else f"{painted(kind, begin, colour)} {line}"
        print(whole, *(f"  {command}" for command in commands), sep="\n", file=sys.stderr)


# ---- files --------------------------------------------------------------------------------------------------------------


def check_folder(path: str | None) -> None:
    """Check, before long computations, that a file of ``--out`` can be written to its folder."""
    if path is None:
        return
    folder = os.path.dirname(path) or "."
    if not os.path.isdir(folder):
        raise ArgumentError(f"--out: there is no folder {folder}")
    if os.path.isdir(path):
        raise ArgumentError(f"--out: {path} is a folder; it must be a file")
    if not os.access(folder, os.W_OK):
        raise ArgumentError(f"--out: {path} cannot be written: there is no permission to write to the folder {folder}")


def check_files(paths: Iterable[str], endings: Iterable[str]) -> None:
    """Check, before long computations, that files of ``--out`` can be written.

    ``endings``: allowed endings; those of figures need Matplotlib.
    """
    for path in paths:
        check_folder(path)
        ending = ending_of(path)
        if ending not in endings:
            raise ArgumentError(f"--out: {path} does not end in {' or '.join(f'.{each}' for each in endings)}")
        if ending in FIGURES:
            from kinetostatics.plot.style import format_of  # raises an error if Matplotlib is missing

            format_of(path)


def ending_of(path: str) -> str:
    """Return the ending of a file name, in lower case."""
    return os.path.splitext(path)[1].removeprefix(".").lower()


def save_files(paths: Iterable[str], figure: str, result: Keyword, **drawn: Keyword) -> None:
    """Write a result to files: figures by the function ``figure`` of :mod:`kinetostatics.plot`, others by ``result.save``."""
    for path in paths:
        if ending_of(path) in FIGURES:
            save_figure(path, figure, result, **drawn)
        else:
            result.save(path)


def save_figure(path: str, kind: str, *shown: object, dpi: float = 300, **options: object) -> None:
    """Draw a figure by the function ``kind`` of :mod:`kinetostatics.plot`, and write it to a file."""
    from kinetostatics import plot  # raises an error if Matplotlib is missing
    from kinetostatics.plot.style import draw_into_files, save_and_close

    draw_into_files()
    save_and_close(getattr(plot, kind)(*shown, **options), path, dpi)
