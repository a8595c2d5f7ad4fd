"""Print what CHANGELOG.md says of a version: the notes of its release.

python .ci/release_notes.py v0.2.0
"""

import re
import sys
from pathlib import Path

CHANGELOG = Path(__file__).resolve().parents[1] / "CHANGELOG.md"
HEADING = re.compile(r"^## \[?(?P<version>[^\]\s]+)\]?(?: *[-–] *(?P<date>.*))?$", re.MULTILINE)
DATE = re.compile(r"\d{4}-\d{2}-\d{2}")


def notes(changelog: str, tag: str) -> str:
    """Return the section of a version.

    Args:
        changelog: the whole file.
        tag: the version, with or without a ``v`` before it.

    Raises:
        ValueError: the file has no such section, or it has no date, or it is empty.
    """
    version = tag.removeprefix("v")
    headings = list(HEADING.finditer(changelog))
    known = ", ".join(found["version"] for found in headings) or "none"
    for found, after in zip(headings, [*headings[1:], None], strict=True):
        if found["version"] == version:
            if not DATE.fullmatch(found["date"] or ""):
                raise ValueError(f"CHANGELOG.md has no date for {version}: write ## [{version}] - YYYY-MM-DD")
            text = changelog[found.end() : after.start() if after else None].strip()
            if not re.search(r"^[-*] ", text, re.MULTILINE):
                raise ValueError(f"CHANGELOG.md says nothing of {version}")
            return text + "\n"
    raise ValueError(f"CHANGELOG.md has no section for {version}, only for {known}: rename [Unreleased] to it")


if __name__ == "__main__":
    try:
        sys.stdout.write(notes(CHANGELOG.read_text(encoding="utf-8"), sys.argv[1]))
    except ValueError as error:
        sys.exit(str(error))
