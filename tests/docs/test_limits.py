"""The page on limits names the thresholds that the code warns at."""

from places import ROOT

from kinetostatics.checks.input_warnings import STUBBY
from kinetostatics.results.warnings import EULER_WARNING, LARGE_MOTION

PAGE = " ".join((ROOT / "docs" / "explanation" / "limits.md").read_text(encoding="utf-8").split())


def test_thresholds():
    words = {3.0: "three", 5.0: "five"}
    assert f"From {100 * EULER_WARNING:.0f} % on a warning" in PAGE
    assert f"A beam shorter than {words[STUBBY]} times its depth is warned of" in PAGE
    assert f"by more than {LARGE_MOTION:g} times `robot.length`, or turns by more than {LARGE_MOTION:g} rad, is warned of" in PAGE
