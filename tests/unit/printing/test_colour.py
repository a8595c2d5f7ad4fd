"""Colour: only where terminals want it, and nothing but colour."""

import io
import re

import pytest
from places import TESTS

from kinetostatics.printing.colour import coloured, for_stream, wants_colour
from kinetostatics.status import Status

CODE = re.compile("\033\\[[0-9;]*m")


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.fixture(autouse=True)
def plain_environment(monkeypatch):
    for name in ("NO_COLOR", "FORCE_COLOR"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("TERM", "xterm-256color")


@pytest.mark.parametrize(
    ("stream", "environment", "wanted"),
    [
        (Terminal(), {}, True),
        (io.StringIO(), {}, False),
        (None, {}, False),
        (Terminal(), {"TERM": "dumb"}, False),
        (Terminal(), {"NO_COLOR": "1"}, False),
        (Terminal(), {"NO_COLOR": ""}, True),
        (io.StringIO(), {"FORCE_COLOR": "1"}, True),
        (io.StringIO(), {"FORCE_COLOR": ""}, False),
        (io.StringIO(), {"FORCE_COLOR": "1", "NO_COLOR": "1"}, False),
        (Terminal(), {"FORCE_COLOR": "1", "TERM": "dumb"}, True),
    ],
)
def test_who_wants_colour(monkeypatch, stream, environment, wanted):
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    assert wants_colour(stream) is wanted
    assert (for_stream("! beware", stream) != "! beware") is wanted


def test_colour_changes_nothing_else():
    """All reports of checks: without the codes they are the same to the byte, and no code goes on in the next line."""
    texts = [path.read_text(encoding="utf-8") for path in sorted((TESTS / "golden").glob("*.txt"))]
    assert len(texts) > 20
    for text in texts:
        found = coloured(text)
        assert found != text and CODE.sub("", found) == text
        for line in found.split("\n"):
            codes = CODE.findall(line)
            assert codes[1::2] == ["\033[0m"] * (len(codes) // 2) and len(codes) % 2 == 0


def test_headings_are_bold_and_warnings_yellow():
    text = "Robot 'a'\n  base  b\n\nLimbs, from base\n  limb_1: R\n\nWarnings\n  ! the rod\n    is long\n  ! so\n  none"
    assert coloured(text).split("\n") == [
        "\033[1mRobot 'a'\033[0m",
        "  base  b",
        "",
        "\033[1mLimbs, from base\033[0m",
        "  limb_1: R",
        "",
        "\033[1mWarnings\033[0m",
        "  \033[33m! the rod\033[0m",
        "    \033[33mis long\033[0m",
        "  \033[33m! so\033[0m",
        "  none",
    ]


@pytest.mark.parametrize(
    ("line", "part", "code"),
    [
        ("Analysis of 'OK': OK, the loops close", "OK", 32),
        ("Analysis of 'a': SINGULAR, with the actuators", "SINGULAR", 31),
        ("  also BUCKLES, a beam", "BUCKLES", 31),
        ("  LIMIT_EXCEEDED      3  a joint", "LIMIT_EXCEEDED", 33),
        ("  stiffness  1e-2  1e-16  DIFFERS", "DIFFERS", 31),
        ("Verified: the largest", "Verified", 32),
        ("NOT verified: the largest", "NOT verified", 31),
        ("Not verified: the finite elements", "Not verified", 33),
        ("kinetostatics: error: OK is no robot", "kinetostatics: error:", "1;31"),
        ("kinetostatics: warning: so", "kinetostatics: warning: so", 33),
    ],
)
def test_statuses(line, part, code):
    found = coloured(line)
    assert f"\033[{code}m{part}\033[0m" in found and CODE.sub("", found) == line
    assert found.count("'OK'") == line.count("'OK'"), "a robot's name is no status"


def test_a_heading_is_bold_up_to_its_status():
    assert coloured("Analysis of 'a': OK, so") == "\033[1mAnalysis of 'a': \033[0m\033[32mOK\033[0m, so"
    assert coloured("a\n\nVerified: so").endswith("\n\033[32mVerified\033[0m: so")


def test_every_status_has_a_colour():
    for status in Status:
        assert CODE.search(coloured(f"Analysis of 'a': {status.name}, so"))
