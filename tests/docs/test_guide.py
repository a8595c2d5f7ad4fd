"""The guide and the first pages: every block is run, and every output compared.

Where an output has changed, ``python tests/support/guide_pages.py`` writes the pages anew; review the difference.
"""

from __future__ import annotations

import re
import sys

import pytest
from guide_pages import GUIDE, STORIES, answers
from page_code import blocks
from places import ROOT

ROBOT = ROOT / "examples" / "guide_robot" / GUIDE.file


@pytest.fixture(scope="module", params=STORIES, ids=lambda story: story.pages[0].stem)
def story(request, tmp_path_factory):
    """The pages of a story, the outputs of their blocks, and the robot file in the end."""
    return request.param, *answers(request.param, tmp_path_factory.mktemp("guide"))


def steady(text: str) -> str:
    """Return a text with directions of arbitrary sign turned to one sign."""

    def turned(found: re.Match[str]) -> str:
        numbers = [part.strip() for part in found[2].split(",")]
        if next((part for part in numbers if float(part)), "").startswith("-"):
            numbers = [part if not float(part) else part[1:] if part[0] == "-" else f"-{part}" for part in numbers]
        return f"{found[1]} ({', '.join(numbers)})"

    return re.sub(r"\b(along|axis)\s+\(([-\d., ]+)\)", turned, text)


def words(text: str) -> list[str | float]:
    """Return words, numbers as floats with rounding errors as zeros; left and right may come in either order."""
    found: list[str | float] = []
    for word in steady(text.replace("right_", "left_")).split():
        number = re.fullmatch(r"[-+]?\d+(\.\d+)?(e[-+]\d+)?", word)
        found.append((0.0 if abs(float(word)) < 1e-9 else float(word)) if number else word)
    return found


@pytest.mark.few(2)
def test_outputs_on_the_pages_equal_those_printed(story):
    pages, found, _ = story
    everything = [item for page in found for item in page]
    assert pages is not GUIDE or len(everything) >= 15
    for block, answer in everything:
        shown, printed = words(block.text), words(answer)
        assert len(shown) == len(printed), f"stale:\n{block.text}\nnow:\n{answer}"
        for a, b in zip(shown, printed, strict=True):
            same = a == pytest.approx(b, rel=1e-3) if isinstance(a, float) and isinstance(b, float) else a == b
            assert same, f"{a} in the page, {b} printed; stale:\n{block.text}\nnow:\n{answer}"


def test_every_code_block_of_the_guide_is_recognized():
    texts = GUIDE.texts()
    found = [block for text in texts for block in blocks(text)]
    assert {block.kind for block in found} == {"xml", "console", "python", "text"}
    assert sum(text.count("```") for text in texts) == 2 * len(found)
    assert all(block.mark.startswith("lift") for block in found if block.kind == "xml")


@pytest.mark.few(2)
def test_example_robot_equals_the_robot_of_the_guide(story):
    pages, _, file = story
    assert pages is not GUIDE or ROBOT.read_text(encoding="utf-8") == file


def test_sketches_equal_those_of_the_script():
    sys.path.insert(0, str(ROBOT.parent))
    try:
        from draw_sketches import SKETCHES
    finally:
        sys.path.remove(str(ROBOT.parent))
    for name, draw in SKETCHES.items():
        assert f"pictures/{name}" in "".join(GUIDE.texts())
        assert (ROOT / "docs" / "pictures" / name).read_text(encoding="utf-8") == draw()
