"""What a source leaves open, asked for in one message that names the exact arguments to give."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from kinetostatics.exceptions import KinetostaticsError

#: How many names a question lists.
MAX_NAMES = 30


@dataclass(frozen=True)
class Question:
    """One missing fact.

    Attributes:
        argument: of :func:`kinetostatics.import_robot` that takes the answer; the command's option has the same name.
        loop: the loop it is about; empty if it is about the robot.
        python, option: the form of the answer in Python and on the command line.
        what: what is wanted, and what the choice is.
    """

    argument: str
    loop: str
    python: str
    option: str
    what: str


class MissingFactsError(KinetostaticsError):
    """A source does not say everything that a robot file needs; the message lists all of it.

    Attributes:
        source: path of the source.
        questions: what is missing.
    """

    def __init__(self, source: str, questions: Sequence[Question]) -> None:
        self.source, self.questions = source, tuple(questions)
        super().__init__(self._message(_in_python))

    @property
    def for_command_line(self) -> str:
        """The message with the options of ``kinetostatics import`` instead of Python's arguments."""
        return self._message(_as_option)

    def _message(self, spelled: Callable[[Sequence[Question]], str]) -> str:
        lines = [f"{self.source} does not say everything; give also"]
        for argument in dict.fromkeys(question.argument for question in self.questions):
            asked = [question for question in self.questions if question.argument == argument]
            lines.append(f"  {spelled(asked)}")
            lines.extend(f"      {question.what}" for question in asked)
        return "\n".join(lines)


def _in_python(asked: Sequence[Question]) -> str:
    names = [json.dumps(question.loop, ensure_ascii=False) for question in asked]
    entries = ", ".join(f"{name}: {item.python}" if item.loop else item.python for name, item in zip(names, asked, strict=True))
    return f"{asked[0].argument}=" + (f"{{{entries}}}" if asked[0].loop else entries)


def _as_option(asked: Sequence[Question]) -> str:
    entries = " ".join(_quoted(f"{question.loop}={question.option}") if question.loop else question.option for question in asked)
    return f"--{asked[0].argument} {entries}"


def _quoted(item: str) -> str:
    """Return an item of the command line, in quotes if a shell would split or change it."""
    return item if all(character.isalnum() or character in "_-.=,:/" for character in item) else f"'{item}'"


def listed(names: Iterable[str]) -> str:
    """Return names in a row, shortened if there are very many."""
    names = list(names)
    return ", ".join(names[:MAX_NAMES]) + (", …" if len(names) > MAX_NAMES else "")
