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


#: Examples that search, or analyse many robots; what they show is tested in ``tests/design`` too.
LONG = {
    "kinetostatics.design.optimize",
    "kinetostatics.design.pareto",
    "kinetostatics.design.sensitivities",
    "kinetostatics.design.tolerances",
}


@pytest.mark.few(8)
@pytest.mark.parametrize("name", [pytest.param(name, marks=pytest.mark.slow) if name in LONG else name for name in MODULES])
def test_docstring_examples_of_a_module_pass(name):
    found = doctest.testmod(importlib.import_module(name))
    assert found.attempted > 0 and found.failed == 0
