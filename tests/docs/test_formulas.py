"""The page of formulas: its program gives the package's twist, and its thresholds are those of the code."""

import importlib
import re

import numpy as np
from page_code import run_python, text_of


def test_the_program_written_from_the_formulas_gives_the_twist_of_the_package():
    import kinetostatics as ks

    names = run_python("explanation/formulas")
    expected = ks.analyze(names["pose"], gravity=names["gravity"]).twist
    assert np.allclose(names["twist"], expected, rtol=2e-12, atol=0)


def test_thresholds_are_those_of_the_code():
    table = text_of("explanation/formulas").partition("<!-- thresholds: begin -->")[2].partition("<!-- thresholds: end -->")[0]
    rows = re.findall(r"^\| [^|]+ \| ([\de.-]+)[^|]* \| [^|]+ \| `([\w.]+)\.(\w+)` \|$", table, re.MULTILINE)
    assert len(rows) == table.count("\n| ") - 1
    for value, module, name in rows:
        assert getattr(importlib.import_module(f"kinetostatics.{module}"), name) == float(value), name
