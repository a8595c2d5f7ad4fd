"""Notebooks: what stands in them. ``mkdocs build`` runs them, and fails where one of their assertions does."""

import re

import pytest
from places import ROOT

FOLDER = ROOT / "docs" / "tutorials" / "notebooks"
NOTEBOOKS = sorted(FOLDER.glob("*.py"))


def test_all_of_them_are_in_the_site():
    listed = re.findall(r"tutorials/notebooks/(\w+)\.md", (ROOT / "mkdocs.yml").read_text(encoding="utf-8"))
    assert sorted(listed) == [path.stem for path in NOTEBOOKS] and len(listed) >= 5
    index = (FOLDER.parent / "index.md").read_text(encoding="utf-8")
    assert re.findall(r"\(notebooks/(\w+)\.py\)", index) == listed


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_each_teaches_asserts_and_ends_with_a_figure(path):
    text = path.read_text(encoding="utf-8")
    cells = re.split(r"^# %%", text, flags=re.MULTILINE)[1:]
    assert text.startswith("# %% [markdown]\n# # ") and text.endswith("plt.show()\n")
    assert len(re.findall(r"assert", text)) >= 3
    assert not re.search(r"^from kinetostatics|import kinetostatics\.|\bks\.[\w.]*\b_", text, re.MULTILINE), "public names only"
    words = [word for cell in cells if cell.startswith(" [markdown]") for word in cell.split()]
    assert 80 < len(words) < 800
