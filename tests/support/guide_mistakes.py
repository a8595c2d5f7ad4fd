"""The mistakes of the guide: how each is made, and which places of the code answer them.

Each changes the complete example of the page on robot files, the parallelogram, or is a whole text, or code that is run on it.
"""

from __future__ import annotations

import ast
import re
import warnings as python_warnings
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
from places import ROOT

import kinetostatics as ks
from kinetostatics.checks.collect import robot_facts
from kinetostatics.exceptions import KinetostaticsError, RobotFileError

SOURCE = ROOT / "src" / "kinetostatics"
XACRO = ' xmlns:xacro="http://www.ros.org/wiki/xacro"'


@cache
def parallelogram() -> str:
    """Return the complete example of docs/reference/robot_format.md."""
    page = (ROOT / "docs" / "reference" / "robot_format.md").read_text(encoding="utf-8")
    return page.partition("## A complete example")[2].partition("```xml\n")[2].partition("```")[0]


@dataclass(frozen=True)
class Mistake:
    """One mistake.

    Attributes:
        written: what a reader sees of it.
        cure: what to do about it, if the message does not say so itself.
        swaps: what is replaced in the example, and by what.
        text: the whole file, instead of the example.
        code: what is run in Python with ``robot`` (the file), ``file`` and ``ks``; by default ``ks.load_robot(file)`` and what
            ``kinetostatics check`` looks at.
        warns: whether the answer is a warning instead of an error.
        ours: the beginning of the message, where the rest is another library's and differs between its versions.
    """

    written: str
    cure: str
    swaps: tuple[tuple[str, str], ...] = ()
    text: str | bytes | None = None
    code: str = ""
    warns: bool = False
    ours: str = ""

    def file(self) -> str | bytes:
        """Return the text of the robot file."""
        if self.text is not None:
            return self.text
        text = parallelogram()
        for old, new in self.swaps:
            assert text.count(old) >= 1, f"{old!r} is not in the example"
            text = text.replace(old, new, 1)
        return text


def swap(old: str, new: str, cure: str, written: str = "", code: str = "") -> Mistake:
    """Return the mistake of writing ``new`` instead of ``old``."""
    return Mistake(written or f"`{_one_line(new)}`", cure, ((old, new),), code=code)


def drop(old: str, cure: str, written: str = "") -> Mistake:
    """Return the mistake of leaving something out."""
    return Mistake(written or f"`{_one_line(old)}` left out", cure, ((old, ""),))


def add(new: str, cure: str, written: str = "", code: str = "", xacro: bool = False) -> Mistake:
    """Return the mistake of writing something more, at the end of the file."""
    swaps = [("</robot>", f"{new}\n</robot>")]
    if xacro:
        swaps.append(('<robot name="parallelogram">', f'<robot name="parallelogram"{XACRO}>'))
    return Mistake(written or f"`{_one_line(new)}`", cure, tuple(swaps), code=code)


def code(source: str, cure: str, written: str = "") -> Mistake:
    """Return a mistake in Python, with the example as ``robot``."""
    return Mistake(written or f"`{source}`", cure, code=source)


def whole(text: str | bytes, written: str, cure: str, source: str = "") -> Mistake:
    """Return the mistake of a whole file."""
    return Mistake(written, cure, text=text, code=source)


def _one_line(text: str) -> str:
    return " ".join(text.split()).replace("> <", "><")


# ---- what is answered --------------------------------------------------------------------------------------------------


def provoke(mistake: Mistake, folder: Path) -> tuple[list[str], set[tuple[str, int]]]:
    """Make a mistake; return the messages, without the file's name and line, and the lines of the code that raised them.

    A warning is found in what the robot, or its analysis, warns of.
    """
    content = mistake.file()
    file = folder / "robot.urdf"
    file.write_bytes(content if isinstance(content, bytes) else content.encode("utf-8", "surrogatepass"))
    names: dict[str, Any] = {"ks": ks, "np": np, "file": file, "folder": folder, "inf": float("inf"), "nan": float("nan")}
    try:
        with python_warnings.catch_warnings(record=True) as given:
            python_warnings.simplefilter("always", UserWarning)
            found = _run(mistake, file, names)
    except (KinetostaticsError, TypeError) as error:
        assert not mistake.warns, f"an error instead of a warning: {error}"
        return [_without_others(plain(error, folder), mistake.ours)], set(places(error))
    assert mistake.warns, "nothing is wrong with it"
    said = [str(item.message) for item in given if issubclass(item.category, UserWarning)]
    said += [*robot_facts(found).warnings, *(names["result"].warnings if "result" in names else ())]
    return [_bare(warning, folder) for warning in dict.fromkeys(said)], set()


def _run(mistake: Mistake, file: Path, names: dict[str, Any]) -> Any:
    """Make a mistake, and return the robot."""
    if not mistake.code:
        return look(ks.load_robot(file))
    if re.search(r"\b(robot|pose|description)\b", mistake.code) and not mistake.code.startswith("robot ="):
        names["robot"] = ks.load_robot(file)
        names["description"] = names["robot"].description
        if re.search(r"\bpose\b", mistake.code):
            names["pose"] = names["robot"].assemble()
    exec(mistake.code, names)
    return names.get("robot")


def _without_others(message: str, ours: str) -> str:
    assert message.startswith(ours), f"{message!r} does not begin with {ours!r}"
    return f"{ours} …" if ours else message


def look(robot: ks.Robot) -> ks.Robot:
    """Look at all that ``kinetostatics check`` looks at."""
    str(robot.mobility), robot.beams, robot.statics.groups
    return robot


def plain(error: Exception, folder: Path) -> str:
    """Return an error's message without place."""
    return _bare(error.reason if isinstance(error, RobotFileError) else str(error), folder)


def _bare(message: str, folder: Path) -> str:
    """Return a message without the place that it begins with, and with the names of files alone."""
    message = message.replace(f"{folder}/", "").replace(str(folder), ".")
    return re.sub(r"^robot\.urdf(:\d+)?: ", "", message)


def places(error: BaseException | None) -> Iterator[tuple[str, int]]:
    """Yield module and line of every frame of an error and of those behind it."""
    while error is not None:
        traceback: TracebackType | None = error.__traceback__
        while traceback is not None:
            path = Path(traceback.tb_frame.f_code.co_filename)
            if path.is_relative_to(SOURCE):
                yield path.relative_to(SOURCE).as_posix(), traceback.tb_lineno
            traceback = traceback.tb_next
        error = error.__cause__ or error.__context__


# ---- the places that answer ------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Site:
    """A ``raise`` in the code.

    Attributes:
        module: its file.
        first, last: its lines.
        words: the fixed parts of its message, or the code of the statement.
    """

    module: str
    first: int
    last: int
    words: str

    def __str__(self) -> str:
        return f"{self.module}:{self.first}: {self.words}"


def sites(modules: tuple[str, ...]) -> list[Site]:
    """Return every ``raise`` of a new error in some modules."""
    found = []
    for module in modules:
        for node in ast.walk(ast.parse((SOURCE / module).read_text(encoding="utf-8"))):
            if isinstance(node, ast.Raise) and node.exc is not None:
                constants = [
                    part.value for part in ast.walk(node.exc) if isinstance(part, ast.Constant) and isinstance(part.value, str)
                ]
                words = max(constants, key=len, default="").strip() or ast.unparse(node)
                found.append(Site(module, node.lineno, node.end_lineno or node.lineno, words))
    return sorted(found, key=lambda site: (site.module, site.first))
