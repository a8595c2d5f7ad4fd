"""Expands xacro files, with errors that name file and line, and writes the text of xacro files that include another file.

The ``xacro`` package keeps its state in its module and reports errors without lines. During an expansion, its parser is replaced
by the parser of this package, which records file and line of each element; the traceback of an error shows which element was
being expanded. Packages are found without ROS, and expressions with names such as ``__class__`` are rejected. All other
expressions are executed, as in ROS: robot files are programs.
"""

from __future__ import annotations

import contextlib
import html
import io
import numbers
import os
import re
import threading
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from types import ModuleType, TracebackType
from xml.dom import minidom

from kinetostatics.arguments import check_mapping
from kinetostatics.description.fields import Place
from kinetostatics.exceptions import ArgumentError, RobotFileError, near_names
from kinetostatics.files import mjcf, sdf
from kinetostatics.files.attributes import si_hint
from kinetostatics.files.bundled import INDEX, LIBRARY, OWN_NAME, PackageNotFound, package_folder
from kinetostatics.files.xml import XmlElement, parse, place_of, read_file, to_elements, to_text

_LOCK = threading.RLock()
_PRIVATE = re.compile(r"(?<!\w)__")


class _Arguments(dict[str, str]):
    """The substitution arguments of one expansion, by name; ``declared`` are the names that files declare."""

    def __init__(self, values: Mapping[str, str]) -> None:
        super().__init__(values)
        self.declared: set[str] = set()

    def __getitem__(self, name: str) -> str:
        value = super().__getitem__(name)
        self.declared.add(name)
        return value


def expand(
    document: minidom.Document, path: str, parameters: Mapping[str, object], values: dict[str, str] | None = None
) -> list[str]:
    """Expand a xacro document in place, and return xacro's warnings in full sentences.

    Args:
        document: a document from :func:`kinetostatics.files.xml.parse`.
        path: path of the document; included files are searched in the folder of this path.
        parameters: values of ``<xacro:arg>``, numbers or strings.
        values: receives the values of all arguments, including defaults.

    Raises:
        RobotFileError: the document cannot be expanded, or does not declare a parameter.
        ArgumentError: a parameter is neither a number nor a string.
    """
    import xacro  # takes 20 ms, not needed for plain URDF

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
            place, calls = _where(error.__traceback__)
            called = f" (in the macro called at {calls[-1]})" if calls else ""
            raise (place or Place(path)).error(_reason(error, arguments) + called) from None
    for name in parameters:
        if name not in arguments.declared:
            reason = f"the file has no <xacro:arg> for the parameter {name!r}; {near_names(name, arguments.declared)}"
            raise RobotFileError(reason, path)
    if values is not None:
        values.update(arguments)
    return [
        f"{path}: xacro warns: {line.removeprefix('warning: ').rstrip('.')}."
        for line in output.getvalue().splitlines()
        if line.startswith("warning: ")
    ]


def _as_text(name: str, value: object) -> str:
    if isinstance(value, str):
        return value
    if isinstance(value, numbers.Integral):
        return str(value if isinstance(value, bool) else int(value))
    if isinstance(value, numbers.Real):
        return repr(float(value))
    raise ArgumentError(f"the parameter {name!r} must be a number or a string, not {type(value).__name__}")


def _note_arguments(document: minidom.Document, arguments: _Arguments) -> None:
    """Record the arguments that a file declares, even where a condition excludes the declaration."""
    for element in document.getElementsByTagName("xacro:arg"):
        arguments.declared.add(element.getAttribute("name"))


@contextlib.contextmanager
def _own_state(xacro: ModuleType, arguments: _Arguments) -> Iterator[None]:
    """Replace xacro's parser by the parser of this package, and restore xacro's state afterwards, even after errors."""
    from xacro import substitution_args

    saved = {name: getattr(xacro, name) for name in ("parse", "safe_eval", "filestack", "macrostack", "verbosity")}
    saved_context, includes = dict(xacro.substitution_args_context), len(xacro.all_includes)
    find = substitution_args._eval_find

    def parse_included(_: object, filename: str) -> minidom.Document:
        path = Path(filename)
        if path.parent.name == LIBRARY and not path.exists():  # a robot of the package, copied without its library
            library_file = package_folder(OWN_NAME) / LIBRARY / path.name
            xacro.filestack[-1] = filename = str(library_file) if library_file.is_file() else filename
        try:
            data = read_file(filename)
        except (OSError, ValueError) as error:
            xacro.filestack.pop()  # the error is not in the file itself; for optional files xacro needs .exc
            reason = getattr(error, "strerror", None) or error
            cause = error if isinstance(error, OSError) else OSError(str(error))
            raise xacro.XacroException(f"cannot read {filename}: {reason}", exc=cause) from error
        document, _ = parse(data, filename)
        _note_arguments(document, arguments)
        return document

    def evaluate(text: str, *names: object) -> object:
        if _PRIVATE.search(text):
            raise xacro.XacroException("names that begin with __ are not allowed in expressions")
        return saved["safe_eval"](text, *names)

    vars(xacro).update(parse=parse_included, safe_eval=evaluate)
    substitution_args._eval_find = lambda name: str(package_folder(name))
    substitution_args._eval_dict["find"] = substitution_args._eval_find
    try:
        yield
    finally:
        vars(xacro).update(saved)
        substitution_args._eval_find = substitution_args._eval_dict["find"] = find
        xacro.substitution_args_context.clear()
        xacro.substitution_args_context.update(saved_context)
        del xacro.all_includes[includes:]


def _reason(error: Exception, arguments: _Arguments) -> str:
    causes: list[BaseException] = [error]
    while isinstance(getattr(causes[-1], "exc", None), BaseException):
        causes.append(causes[-1].exc)  # type: ignore[attr-defined]
    cause = causes[-1]
    if isinstance(cause, RecursionError):
        return "xacro does not come to an end: a macro calls itself or a file includes itself"
    if isinstance(cause, OSError):
        message = causes[-2].args[0] if len(causes) > 1 else None
        return str(message or f"cannot read {cause.filename}: {cause.strerror}")
    if isinstance(cause, PackageNotFound):
        return str(cause)
    if type(cause).__name__ == "ArgException":
        near = near_names(str(cause), arguments.declared)
        return f"there is no xacro argument {str(cause)!r}: declare it with <xacro:arg name default>; {near}"
    if isinstance(cause, TypeError):  # "500mm" / 2
        for name, value in arguments.items():
            if hint := si_hint(value):
                return f"the xacro argument {name} is {value!r}, which is not a number{hint}"
    text = " ".join(str(error).split())
    text = re.sub(r"^<class '([\w.]+)'>: (.*) \2$", r"\2", text)  # xacro repeats the wrapped message
    if len(causes) == 1 and type(error).__name__ not in ("XacroException", "RuntimeError"):
        text = f"{type(error).__name__} {text}"
    return f"xacro cannot expand this: {text}"


def _where(traceback: TracebackType | None) -> tuple[Place | None, list[Place]]:
    """Return the place of the element that xacro was expanding, and the places of the macro calls around it."""
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
    if calls and calls[-1] == place:  # the error is in the call, not in the macro
        calls.pop()
    return place, calls


# ---- inclusion ------------------------------------------------------------------------------------------------------------

XACRO = "http://www.ros.org/wiki/xacro"


def read_document(
    data: bytes | str, path: str, parameters: Mapping[str, object], values: dict[str, str] | None = None
) -> tuple[XmlElement, bool, list[str]]:
    """Return the element ``<robot>`` of a file after expansion of xacro, whether the file uses xacro, and warnings.

    Args:
        path, parameters, values: see :func:`expand`.

    Raises:
        RobotFileError: the file is invalid, its outermost element is not ``<robot>``, or it has no xacro but parameters are
            given.
        ArgumentError: a parameter is neither a number nor a string.
    """
    check_mapping("parameters", parameters, '{"rod_diameter": 0.08}')
    document, uses_xacro = parse(data, path)
    warnings: list[str] = []
    if uses_xacro:
        warnings = expand(document, path, parameters, values)
    elif parameters:
        names = ", ".join(map(repr, parameters))
        raise RobotFileError(f"the file does not use xacro and has no parameters, but was given {names}", path)
    root = to_elements(document)
    if root.tag == "sdf":
        root = sdf.robot_element(root, warnings)
    elif root.tag == "mujoco":
        root = mjcf.robot_element(data, path, warnings)
    if root.tag != "robot":
        raise root.error(f"the outermost element is <{root.tag}>; in a robot file it is <robot>, <sdf> or <mujoco>")
    return root, uses_xacro, warnings


def include_path(source: str, root: XmlElement, uses_xacro: bool, additions: str, out: str) -> str | None:
    """Return the path by which the file ``out`` can include a source; None if xacro would change the source or ``additions``,
    or if the source is no URDF.

    The path is relative to the folder of ``out``, or begins with ``$(find NAME)`` if the source is in an installed package.
    """
    try:
        path = os.path.relpath(source, os.path.dirname(out) or ".")
    except ValueError:  # on another drive
        path = os.path.abspath(source)
    path = path.replace(os.sep, "/")
    if root.place.line is None or "$" in path or not path.isprintable() or "$" in additions:
        return None
    if not uses_xacro and "$" in to_text(root):
        return None
    return _in_package(source) or path


def _in_package(source: str) -> str | None:
    """Return ``$(find NAME)/…`` for a file of an installed package, else None."""
    path = Path(source).absolute()
    for folder in path.parents:
        if folder.parent.name == "share" and (folder.parents[1] / INDEX / folder.name).is_file():
            try:
                same = package_folder(folder.name).samefile(folder)
            except (PackageNotFound, OSError):
                same = False
            return f"$(find {folder.name})/{path.relative_to(folder).as_posix()}" if same else None
    return None


def including_text(name: str, include: str, comment: str, additions: str) -> str:
    """Return the text of a xacro file that includes another file and has additional elements."""
    return (
        f'<?xml version="1.0"?>\n<robot name={quoted(name)} xmlns:xacro="{XACRO}">\n'
        f"  <!-- {comment} -->\n"
        f"  <xacro:include filename={quoted(include)}/>\n\n{additions}</robot>\n"
    )


def whole_text(root: XmlElement, additions: str) -> str:
    """Return the text of a source that is a plain URDF, with additional elements at its end."""
    attributes = {name: value for name, value in root.attributes.items() if name != "xmlns:xacro"}
    head, closing, tail = to_text(replace(root, attributes=attributes), indented=True).rpartition("</robot>")
    return f"{head.rstrip()}\n\n{additions}{closing}{tail}"


def quoted(value: str) -> str:
    """Return the value of an attribute as XML, in quotes."""
    # without xml.sax.saxutils, whose import takes 50 ms
    return '"' + html.escape(value, quote=False).replace('"', "&quot;") + '"'
