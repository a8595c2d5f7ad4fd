"""Where things are."""

from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
TESTS = ROOT / "tests"
ROBOTS = ROOT / "robots"
CASES = TESTS / "cases"
