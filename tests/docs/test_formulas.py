"""The page of formulas: its program gives the twist of the package; its thresholds and limits are those of the code."""

import importlib
import re

import numpy as np
from page_code import between, run_python, text_of

from kinetostatics.checks.input_warnings import STUBBY
from kinetostatics.results.warnings import EULER_WARNING, LARGE_MOTION


def test_program_of_the_formulas_page_equals_the_package():
    import kinetostatics as ks

    names = run_python("explanation/formulas")
    expected = ks.analyze(names["pose"], gravity=names["gravity"]).twist
    assert np.allclose(names["twist"], expected, rtol=2e-12, atol=0)


def test_thresholds_are_those_of_the_code():
    table = between(text_of("explanation/formulas"), "thresholds")
    rows = re.findall(r"^\| [^|]+ \| ([\de.-]+)[^|]* \| [^|]+ \| `([\w.]+)\.(\w+)` \|$", table, re.MULTILINE)
    assert len(rows) == table.count("\n| ")
    for value, module, name in rows:
        assert getattr(importlib.import_module(f"kinetostatics.{module}"), name) == float(value), name


def test_limits_of_the_theory_are_those_of_the_warnings():
    page = " ".join(text_of("explanation/limits").split())
    assert f"From {100 * EULER_WARNING:.0f} % on, a warning" in page
    assert f"for a beam shorter than { {3.0: 'three', 5.0: 'five'}[STUBBY] } times its depth" in page
    assert f"by more than {LARGE_MOTION:g} times `robot.length`, or turns by more than {LARGE_MOTION:g} rad" in page
