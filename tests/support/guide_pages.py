"""Runs the blocks of the guide and writes its answers: ``python tests/support/guide_pages.py``.

The pages of a story are read one after the other. A block of XML is merged into the story's file: what has the tag and name of
something in the file replaces it, what is new goes before ``</robot>``. After ``<!-- lift: only once -->`` the file is as before
when the next block of commands is done. Of long answers ``<!-- shows: Robot; Errors 9 -->`` above the block names the paragraphs
that are shown, and how many lines.
"""

from __future__ import annotations

import contextlib
import io
import os
import re
import shutil
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from page_code import DOCS, Block, blocks
from places import ROOT

from kinetostatics.cli.main import main

_START = re.compile(r"^  <(?!/)([\w:]+|!--)")
_KEY = re.compile(r"^  <([\w:]+)(?: [\w:]+=\"[^\"]*\")*? ((?:name|link|joint)=\"[^\"]*\")", re.MULTILINE)


@dataclass(frozen=True)
class Story:
    """Pages that are read one after the other, and the robot file that comes about in them."""

    pages: tuple[Path, ...]
    file: str
    #: Folder whose files the reader has.
    copied: Path | None = None

    def texts(self) -> list[str]:
        """Return the texts of the pages."""
        return [page.read_text(encoding="utf-8") for page in self.pages]


def _story(folder: str, *names: str, file: str) -> Story:
    return Story(tuple(DOCS / folder / f"{name}.md" for name in names), file)


GUIDE = _story(
    "tutorials/lift_table",
    *("index", "joints", "beams", "results"),
    file="lift_table.urdf.xacro",
)
STORIES = (
    GUIDE,
    _story("start", "tour", file="3rps.urdf.xacro"),
    _story("start", "your_own_robot", file="camera_boom.urdf.xacro"),
    replace(_story("how_to", "castings", file="arm.urdf.xacro"), copied=ROOT / "examples" / "castings"),
)


# ---- merging ---------------------------------------------------------------------------------------------------------------


def merge(file: str, block: str) -> str:
    """Return a robot file with a block of elements merged into it."""
    match = re.match(r"(.*?<robot[^>]*>\n)(.*)(</robot>\n)$", file, re.DOTALL)
    assert match is not None
    head, body, tail = match.groups()
    parts = list(_elements(body))
    for number, new in enumerate(_elements(block)):
        key = _key(new)
        same = [k for k, part in enumerate(parts) if key is not None and _key(part) == key]
        if same:
            old = parts[same[0]]
            comment = re.match(r"(?:  <!--.*?-->\s*\n)*", old, re.DOTALL)
            kept = comment[0] if comment is not None and not new.startswith("  <!--") else ""
            parts[same[0]] = kept + new.rstrip("\n") + "\n" + ("\n" if old.endswith("\n\n") else "")
        else:
            if number == 0 and not parts[-1].endswith("\n\n"):
                parts[-1] += "\n"
            parts.append(new)
    return head + "".join(parts) + tail


def _elements(body: str) -> Iterator[str]:
    """Yield the elements of ``<robot>``, each with the comments before and the blank lines after it."""
    part, complete = "", False
    for line in body.splitlines(keepends=True):
        start = _START.match(line)
        if start and complete:
            yield part
            part, complete = "", False
        part += line
        if start and start[1] != "!--":
            complete = True
    yield part


def _key(element: str) -> tuple[str, ...] | None:
    found = _KEY.search(element)
    return found.groups() if found else None


# ---- running ---------------------------------------------------------------------------------------------------------------


def run(command: str) -> str:
    """Return what a command line prints, errors too."""
    program, *arguments = command.removeprefix("$ ").split()
    assert program == "kinetostatics"
    output = io.StringIO()
    with contextlib.redirect_stdout(output), contextlib.redirect_stderr(output):
        main(arguments)
    return "".join(f"{line.rstrip()}\n" for line in output.getvalue().splitlines())


def excerpt(text: str, mark: str) -> str:
    """Return the paragraphs of an answer that a mark names; … stands for what is left out."""
    if not mark.startswith("shows: "):
        return text
    wanted = [re.fullmatch(r"(.*?)(?: (\d+))?", item) for item in mark.removeprefix("shows: ").split("; ")]
    kept: list[str] = []
    for paragraph in text.rstrip("\n").split("\n\n"):
        limits = [item[2] for item in wanted if item is not None and paragraph.strip().startswith(item[1])]
        if limits:
            lines = paragraph.split("\n")
            count = int(limits[0] or len(lines))
            kept.append("\n".join(lines[:count] + ["  …"] * (count < len(lines))))
        elif kept[-1:] != ["…"]:
            kept.append("…")
    return "\n\n".join(kept) + "\n"


@contextlib.contextmanager
def working_in(folder: Path) -> Iterator[None]:
    """Work in another folder."""
    before = os.getcwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(before)


def answers(story: Story, folder: Path, run: Callable[[str], str] = run) -> tuple[list[list[tuple[Block, str]]], str]:
    """Run the pages of a story.

    Args:
        story: the story.
        folder: where it is told.
        run: returns what a command line prints.

    Returns:
        For each page every block with answers, and what it is to be: commands with what they print, or what the Python above
        prints; and the robot's file in the end.
    """
    found: list[list[tuple[Block, str]]] = [[] for _ in story.pages]
    names: dict[str, object] = {}
    file, once, printed = "", "", ""
    if story.copied is not None:
        shutil.copytree(story.copied, folder, dirs_exist_ok=True)
    with working_in(folder):
        for number, block in [(number, block) for number, text in enumerate(story.texts()) for block in blocks(text)]:
            if block.kind == "xml":
                changed = merge(file, block.text) if file else block.text
                if block.mark == "lift: only once":
                    once = changed
                else:
                    file = changed
                Path(story.file).write_text(once or file, encoding="utf-8")
            elif block.kind == "console":
                commands = [line for line in block.text.splitlines() if line.startswith("$ ")]
                found[number].append((block, "".join(f"{command}\n{excerpt(run(command), block.mark)}" for command in commands)))
                if once:
                    once = ""
                    Path(story.file).write_text(file, encoding="utf-8")
            elif block.kind == "python" and not block.mark.startswith("lift: not run"):
                output = io.StringIO()
                with contextlib.redirect_stdout(output):
                    exec(block.text, names)
                printed = output.getvalue()
            elif block.kind == "text":
                found[number].append((block, printed))
    return found, file


def write_story(story: Story) -> str:
    """Write the answers into the pages of a story, and return the last state of its file."""
    with tempfile.TemporaryDirectory() as folder:
        found, file = answers(story, Path(folder))
    for page, text, on_page in zip(story.pages, story.texts(), found, strict=True):
        for block, answer in reversed(on_page):
            text = text[: block.start] + answer + text[block.end :]
        page.write_text(text, encoding="utf-8")
    return file


def write() -> None:
    """Write all pages, and the guide's robot."""
    for story in STORIES:
        file = write_story(story)
        if story is GUIDE:
            (ROOT / "examples" / "guide_robot" / story.file).write_text(file, encoding="utf-8")


if __name__ == "__main__":
    write()
