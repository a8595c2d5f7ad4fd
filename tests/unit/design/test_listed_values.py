"""Which combinations of listed values are tried, and which values are the file's own."""

from types import SimpleNamespace

import pytest

import kinetostatics as ks
from kinetostatics.design import search as module
from kinetostatics.design.search import search
from kinetostatics.parametric.variables import Choice, Range, VariedNumbers

LENGTH = Range("length", 0.1, 0.5)
ROWS = ((0.01, 0.002), (0.02, 0.001), (0.03, 0.004), (0.04, 0.001), (0.05, 0.002))


@pytest.fixture
def tried(monkeypatch):
    """The combinations of listed values with which ranges are searched; where lists are ranges, 0.031 would be the best."""
    combinations = []

    def minimize(problem, ranges, fixed, place):
        if len(ranges) > 1:
            return {"length": 0.2, "diameter": 0.031}
        combinations.append(fixed)
        return {"length": 0.3}

    monkeypatch.setattr(module, "_minimize", minimize)
    monkeypatch.setattr(module, "rank", lambda point: 0)
    return combinations


def search_with(choice):
    own = {"length": 0.2, "diameter": 0.02, "wall": 0.001}
    return search(SimpleNamespace(at=lambda found: None), [LENGTH], [choice], own, 2)


def test_all_rows_of_a_catalogue_are_tried_beside_a_range(tried):
    """Rows of a diameter and a wall cannot be interpolated."""
    ends, how = search_with(Choice(("diameter", "wall"), ROWS))
    assert tried == [{"diameter": a, "wall": b} for a, b in ROWS] and "5 of 5" in how
    assert ends == [{"length": 0.3, **one} for one in tried]
    with pytest.raises(ks.ArgumentError, match="45 combinations from catalogues are too many beside ranges"):
        search_with(Choice(("diameter", "wall"), 9 * ROWS))


def test_list_values_around_the_continuous_optimum_are_tried(tried):
    ends, how = search_with(Choice(("diameter",), tuple(row[:1] for row in ROWS)))
    assert sorted(one["diameter"] for one in tried) == [0.03, 0.04, 0.05] and "3 of 5" in how
    assert ends == [{"length": 0.3, **one} for one in tried]


@pytest.mark.parametrize(("values", "own"), [([0.02, 0.02], True), ([0.02, 0.03], False)])
def test_tied_dimensions_may_differ_in_the_file(values, own):
    alike = {"rod_*.diameter": [SimpleNamespace(value=value) for value in values], "length": [SimpleNamespace(value=0.5)]}
    sizes = VariedNumbers(None, alike)
    assert sizes.file_is_a_design == own and sizes.file_value("rod_*.diameter") == pytest.approx(sum(values) / 2)
