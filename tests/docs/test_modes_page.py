"""The gallery of modes: its page is what the script writes, and its pictures are small and move."""

import sys

from PIL import Image
from places import ROOT

sys.path.insert(0, str(ROOT / "examples"))
import animated_modes


def test_the_gallery_of_modes_is_fresh():
    assert animated_modes.PAGE.read_text(encoding="utf-8") == animated_modes.page_text(), "run python examples/animated_modes.py"
    for name in animated_modes.MODES:
        file = animated_modes.PICTURES / f"{name}.webp"
        assert Image.open(file).n_frames == animated_modes.FRAMES and file.stat().st_size <= 60_000
