"""Examples in docstrings do what they show."""

import doctest
import importlib

import pytest
from places import ROOT

SOURCE = ROOT / "src"
MODULES = sorted(
    ".".join(path.relative_to(SOURCE).with_suffix("").parts)
    for path in SOURCE.rglob("*.py")
    if ">>> " in path.read_text(encoding="utf-8")
)


@pytest.mark.parametrize("name", MODULES)
def test_examples_of_a_module(name):
    found = doctest.testmod(importlib.import_module(name))
    assert found.attempted > 0 and found.failed == 0


def test_what_a_newcomer_reads_first_has_examples():
    assert {"kinetostatics.analysis", "kinetostatics.math.screws", "kinetostatics.description.units"} <= set(MODULES)
