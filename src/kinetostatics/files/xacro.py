"""Expansion of xacro, with errors that name the source file and line, and always to an end.

The ``xacro`` package keeps its state in its module and reports errors without lines. Here its parser is replaced for
the time of one expansion by ours, which notes the place of each element; an error's place is then that of the element
that xacro was working on, found in the traceback. Its evaluation of expressions is replaced too, see
:mod:`kinetostatics.files.xacro_expressions`, and what it does is counted, so that no file can make it run for ever.
"""

from __future__ import annotations

import contextlib
import fnmatch
import io
import numbers
import os
import re
import threading
from collections.abc import Callable, Iterator, Mapping
from types import ModuleType, TracebackType
from xml.dom import minidom

from kinetostatics.description.elements import Place
from kinetostatics.exceptions import ArgumentError, RobotFileError, near_names
from kinetostatics.files.bundled import OWN_NAME, PackageNotFound, package_folder
from kinetostatics.files.xacro_expressions import MAX_TEXT, evaluate
from kinetostatics.files.xacro_functions import ELEMENT, MAX_STEPS, Steps, TooMuch, symbols
from kinetostatics.files.xml import clones_counted, parse, place_of, read_file, shortened

_LOCK = threading.RLock()
_BORROWED = (
    *("parse", "filestack", "macrostack", "verbosity", "safe_eval", "eval_extension", "eval_text", "eval_all"),
    *("replace_node", "get_include_files", "load_yaml", "_global_symbols"),
)
WILDCARD = re.compile(r"[*?[]")
_ONE_EXPRESSION = re.compile(r"\$\{([^}$]+)\}")


class _Arguments(dict[str, str]):
    """The substitution arguments of one expansion, which notes the names that the files know."""

    def __init__(self, values: Mapping[str, str]) -> None:
        super().__init__(values)
        self.known: set[str] = set()

    def __getitem__(self, name: str) -> str:
        value = super().__getitem__(name)
        self.known.add(name)
        return value


def expand(
    document: minidom.Document, path: str, parameters: Mapping[str, object], values: dict[str, str] | None = None
) -> list[str]:
    """Expand a xacro document in place.

    Args:
        document: as :func:`kinetostatics.files.xml.parse` returns it.
        path: its file; includes are looked for beside it.
        parameters: values of its ``<xacro:arg>``, numbers or strings.
        values: is filled with the values of all its arguments, those that are not given too.

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
            place, calls = _where(error.__traceback__)
            called = f" (in the macro called at {calls[-1]})" if calls else ""
            raise (place or Place(path)).error(shortened(_reason(error, arguments)) + called) from None
    for name in parameters:
        if name not in arguments.known:
            reason = f"the file has no <xacro:arg> for the parameter {name!r}; {near_names(name, arguments.known)}"
            raise RobotFileError(reason, path)
    if values is not None:
        values.update(arguments)
    return [
        f"{path}: xacro says: {shortened(line.removeprefix('warning: ').rstrip('.'))}."
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
    """Note the arguments that a file declares, in branches too that are not taken this time."""
    for element in document.getElementsByTagName("xacro:arg"):
        arguments.known.add(element.getAttribute("name"))


@contextlib.contextmanager
def _own_state(xacro: ModuleType, arguments: _Arguments) -> Iterator[None]:
    """Let xacro parse with our parser, and leave its module afterwards as it was found, after errors too."""
    saved = {name: getattr(xacro, name) for name in _BORROWED}
    saved_context, includes = dict(xacro.substitution_args_context), len(xacro.all_includes)

    steps = Steps(MAX_STEPS)

    def parse_included(_: object, filename: str) -> minidom.Document:
        try:
            data = read_file(filename)
        except (OSError, ValueError) as error:
            xacro.filestack.pop()  # the file itself is not to blame; and xacro looks for .exc if it is optional
            reason = getattr(error, "strerror", None) or error
            cause = error if isinstance(error, OSError) else OSError(str(error))
            raise xacro.XacroException(f"cannot read {filename}: {reason}", exc=cause) from error
        steps.take(len(data) // 10)
        document, _ = parse(data, filename)
        _note_arguments(document, arguments)
        return document

    vars(xacro)["parse"] = parse_included
    _count(xacro, steps)
    _replace_evaluation(xacro, steps)
    try:
        with clones_counted(lambda: steps.take(ELEMENT)):
            yield
    finally:
        for name, value in saved.items():
            setattr(xacro, name, value)
        xacro.substitution_args_context.clear()
        xacro.substitution_args_context.update(saved_context)
        del xacro.all_includes[includes:]


def _count(xacro: ModuleType, steps: Steps) -> None:
    """Let xacro count the elements and texts that it works on."""
    eval_all, eval_text, replace_node = xacro.eval_all, xacro.eval_text, xacro.replace_node

    def counted_eval_all(node: object, macros: object, table: object) -> None:
        steps.take(ELEMENT)
        eval_all(node, macros, table)

    def counted_eval_text(text: str, symbols: object) -> object:  # xacro names this argument
        if not text or "$" not in text:
            return text or ""
        if len(text) > MAX_TEXT:
            raise TooMuch(f"a text with expressions is longer than {MAX_TEXT} characters")
        steps.take(1 + len(text) // 4)
        if (found := _ONE_EXPRESSION.fullmatch(text)) is None:
            return steps.weigh(eval_text(text, symbols))
        try:  # the same without xacro's lexer: most texts are one expression
            return steps.weigh(xacro.safe_eval(found[1], symbols))
        except Exception as error:
            raise xacro.XacroException(exc=error, suffix=f"\nwhen evaluating expression '{found[1]}'") from error

    def counted_replace_node(
        node: minidom.Element, by: minidom.Node | list[minidom.Node] | None, content_only: bool = False
    ) -> None:
        inserted: list[minidom.Node] = by if isinstance(by, list) else [] if by is None else [by]
        number = sum(len(item.childNodes) for item in inserted) if content_only else len(inserted)
        steps.take(
            (1 + number) * (1 + len(node.parentNode.childNodes if node.parentNode else ()) // 500)
        )  # each is searched for in a list
        replace_node(node, by, content_only)

    vars(xacro).update(eval_all=counted_eval_all, eval_text=counted_eval_text, replace_node=counted_replace_node)


def _replace_evaluation(xacro: ModuleType, steps: Steps) -> None:
    """Let xacro compute expressions and look for included files in our way."""
    eval_extension = xacro.eval_extension
    original = xacro._global_symbols["xacro"]

    def load_yaml(filename: str) -> object:
        import yaml

        path = xacro.abs_filename_spec(filename)
        if os.path.splitext(path)[1].lower() not in (".yaml", ".yml"):
            raise xacro.XacroException(f"load_yaml reads files that end in .yaml or .yml, not {filename!r}")
        try:
            text = read_file(path).decode("utf-8")
        except (OSError, ValueError) as error:
            raise xacro.XacroException(f"cannot read {path}: {getattr(error, 'strerror', None) or error}") from None
        steps.take(5 * len(text))
        for unit in xacro.ConstructUnits:
            yaml.SafeLoader.add_constructor(unit.value.tag, unit.constructor)
        try:
            return xacro.YamlListWrapper.wrap(yaml.safe_load(text))
        except (yaml.YAMLError, RecursionError) as error:
            reason = " ".join(str(error).split()) if isinstance(error, yaml.YAMLError) else "it is nested too deep"
            raise xacro.XacroException(f"cannot read {path}: {reason}") from None

    def extension(text: str) -> object:
        if text.startswith("$(find "):
            return str(package_folder(text[7:-1].strip()))
        if not text.startswith("$(eval "):
            return eval_extension(text)
        arguments = xacro.substitution_args_context["arg"]
        constants = {"true": True, "false": False, "True": True, "False": False}
        values = {name: xacro.Table._eval_literal(value) for name, value in dict.items(arguments)}
        return str(evaluate(text[7:-1], {**xacro._global_symbols, **constants, **values}, steps))

    def include_files(text: str, table: object) -> Iterator[str]:
        spec = str(xacro.eval_text(text, table))
        path = xacro.abs_filename_spec(spec)
        if spec.startswith("library/") and not os.path.exists(path):  # a robot of the package, copied without its library
            own = package_folder(OWN_NAME) / spec
            path = str(own) if own.is_file() else path
        if not WILDCARD.search(spec) or os.path.exists(path):
            yield path
            return
        if WILDCARD.search(os.path.dirname(spec)):
            raise xacro.XacroException(
                f"{spec!r} has * ? or [ in the name of a folder; included files may have them in their own"
            )
        folder, name = os.path.split(path)
        names = sorted(os.listdir(folder or ".")) if os.path.isdir(folder or ".") else []
        found = [item for item in names if fnmatch.fnmatchcase(item, name) and (item[0] != "." or name[0] == ".")]
        if not found:
            xacro.warning(xacro.include_no_matches_msg.format(path))
        for item in found:
            yield os.path.join(folder, item)

    own: dict[str, Callable[..., object]] = {
        name: dict.__getitem__(original, name) for name in ("message", "warning", "error", "print_location", "fatal", "arg")
    }
    own.update(abs_filename=xacro.abs_filename_spec, dotify=xacro.YamlDictWrapper)
    vars(xacro).update(
        safe_eval=lambda text, names, _local=None: evaluate(text, names, steps),
        eval_extension=extension,
        get_include_files=include_files,
        load_yaml=load_yaml,
        _global_symbols=symbols(steps, xacro.NameSpace, load_yaml, own),
    )


def _reason(error: Exception, arguments: _Arguments) -> str:
    causes: list[BaseException] = [error]
    while isinstance(getattr(causes[-1], "exc", None), BaseException):
        causes.append(causes[-1].exc)  # type: ignore[attr-defined]
    cause = causes[-1]
    if isinstance(cause, RecursionError):
        return "xacro does not come to an end: a macro calls itself or a file includes itself"
    if isinstance(cause, TooMuch):
        return f"xacro cannot expand this: {cause}"
    if isinstance(cause, OSError):
        return str(causes[-2].args[0]) if len(causes) > 1 else str(cause)
    if isinstance(cause, PackageNotFound):
        return str(cause)
    if type(cause).__name__ == "ArgException":
        known = near_names(str(cause), arguments.known)
        return f"there is no xacro argument {str(cause)!r}: declare it with <xacro:arg name default>; {known}"
    text = " ".join(str(error).split())
    text = re.sub(r"^<class '([\w.]+)'>: (.*) \2$", r"\2", text)  # xacro repeats what it wraps
    if len(causes) == 1 and type(error).__name__ not in ("XacroException", "RuntimeError", "ExpressionError"):
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
