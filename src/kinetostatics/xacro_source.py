"""Expansion of xacro, with errors that name the source file and line.

The ``xacro`` package keeps its state in its module and reports errors without lines. Here its parser is replaced for
the time of one expansion by ours, which notes the place of each element; an error's place is then that of the element
that xacro was working on, found in the traceback.
"""

from __future__ import annotations

import contextlib
import io
import numbers
import re
import threading
from collections.abc import Iterator, Mapping
from types import TracebackType
from typing import Any
from xml.dom import minidom

from kinetostatics.description import Place
from kinetostatics.exceptions import ArgumentError, RobotFileError, near_names
from kinetostatics.xml_source import parse, place_of

_LOCK = threading.RLock()
_BORROWED = ("parse", "filestack", "macrostack", "verbosity")


class _Arguments(dict[str, str]):
    """The substitution arguments of one expansion, which notes the names that the files know."""

    def __init__(self, values: Mapping[str, str]) -> None:
        super().__init__(values)
        self.known: set[str] = set()

    def __getitem__(self, name: str) -> str:
        value = super().__getitem__(name)
        self.known.add(name)
        return value


def expand(document: minidom.Document, path: str, parameters: Mapping[str, object]) -> list[str]:
    """Expand a xacro document in place.

    Args:
        document: as :func:`kinetostatics.xml_source.parse` returns it.
        path: its file; includes are looked for beside it.
        parameters: values of its ``<xacro:arg>``, numbers or strings.

    Returns:
        What xacro warned of, in full sentences.

    Raises:
        RobotFileError: if it cannot be expanded, or has no argument of a parameter's name.
        ArgumentError: if a parameter is neither a number nor a string.
    """
    import xacro  # takes 20 ms, which plain URDF need not pay

    arguments = _Arguments({name: _as_text(name, value) for name, value in parameters.items()})
    output = io.StringIO()
    with _LOCK, _own_state(xacro, arguments), contextlib.redirect_stdout(output), contextlib.redirect_stderr(output):
        _note_arguments(document, arguments)
        xacro.init_stacks(path)
        try:
            xacro.process_doc(document, mappings=arguments, verbosity=0)
        except RobotFileError:
            raise
        except Exception as error:
            raise _translated(error, path, arguments) from None
    for name in parameters:
        if name not in arguments.known:
            reason = f"the file has no <xacro:arg> for the parameter {name!r}; {near_names(name, arguments.known)}"
            raise RobotFileError(reason, path)
    return [
        f"{path}: xacro says: {line.removeprefix('warning: ').rstrip('.')}."
        for line in output.getvalue().splitlines()
        if line.startswith("warning: ")
    ]


def _as_text(name: str, value: object) -> str:
    if isinstance(value, str):
        return value
    if isinstance(value, (bool, numbers.Integral)):
        return str(int(value)) if not isinstance(value, bool) else str(value)
    if isinstance(value, numbers.Real):
        return repr(float(value))
    raise ArgumentError(f"the parameter {name!r} must be a number or a string, not {type(value).__name__}")


def _note_arguments(document: minidom.Document, arguments: _Arguments) -> None:
    """Note the arguments that a file declares, in branches too that are not taken this time."""
    for element in document.getElementsByTagName("xacro:arg"):
        arguments.known.add(element.getAttribute("name"))


@contextlib.contextmanager
def _own_state(xacro: Any, arguments: _Arguments) -> Iterator[None]:
    """Let xacro parse with our parser, and leave its module afterwards as it was found, after errors too."""
    saved = {name: getattr(xacro, name) for name in _BORROWED}
    saved_context, includes = dict(xacro.substitution_args_context), len(xacro.all_includes)

    def parse_included(_: object, filename: str) -> minidom.Document:
        try:
            with open(filename, "rb") as stream:
                data = stream.read()
        except OSError as error:
            xacro.filestack.pop()  # the file itself is not to blame; and xacro looks for .exc if it is optional
            raise xacro.XacroException(f"cannot read {filename}: {error.strerror}", exc=error) from error
        document, _ = parse(data, filename)
        _note_arguments(document, arguments)
        return document

    xacro.parse = parse_included
    try:
        yield
    finally:
        for name, value in saved.items():
            setattr(xacro, name, value)
        xacro.substitution_args_context.clear()
        xacro.substitution_args_context.update(saved_context)
        del xacro.all_includes[includes:]


def _translated(error: Exception, path: str, arguments: _Arguments) -> RobotFileError:
    """Return the error to raise for one that came out of xacro."""
    place, calls = _where(error.__traceback__)
    place = place or Place(path)
    called = f" (in the macro called at {calls[-1].file}:{calls[-1].line})" if calls else ""
    return RobotFileError(_reason(error, arguments) + called, place.file, place.line)


def _reason(error: Exception, arguments: _Arguments) -> str:
    cause = getattr(error, "exc", None)
    if isinstance(error, RecursionError) or isinstance(cause, RecursionError):
        return "xacro does not come to an end: a macro calls itself or a file includes itself"
    if isinstance(cause, OSError):
        return str(error.args[0])
    if isinstance(cause, ModuleNotFoundError) and cause.name and cause.name.startswith("ament_index_python"):
        return "$(find …) works only where ROS is installed; name files relative to this one instead"
    if type(cause).__name__ == "ArgException":
        known = near_names(str(cause), arguments.known)
        return f"there is no xacro argument {str(cause)!r}: declare it with <xacro:arg name default>; {known}"
    text = " ".join(str(error).split())
    text = re.sub(r"^<class '([\w.]+)'>: (.*) \2$", r"\2", text)  # xacro repeats what it wraps
    if cause is None and type(error).__name__ not in ("XacroException", "RuntimeError"):
        text = f"{type(error).__name__} {text}"
    return f"xacro cannot expand this: {text}"


def _where(traceback: TracebackType | None) -> tuple[Place | None, list[Place]]:
    """Return the place of the element that xacro was working on, and of the macro calls around it."""
    place: Place | None = None
    calls: list[Place] = []
    while traceback is not None:
        frame = traceback.tb_frame
        if frame.f_globals.get("__name__") in ("xacro", "xacro.xmlutils"):
            node = next((frame.f_locals[name] for name in ("elt", "node", "tag") if name in frame.f_locals), None)
            place = place_of(node) or place
            if frame.f_code.co_name == "handle_macro_call" and "body" in frame.f_locals and place is not None:
                calls.append(place)
        traceback = traceback.tb_next
    if calls and calls[-1] == place:  # the call itself is at fault, not what is inside
        calls.pop()
    return place, calls
