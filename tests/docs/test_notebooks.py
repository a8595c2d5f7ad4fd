"""Notebooks: what stands in them. ``mkdocs build`` runs them, and fails where one of their assertions does."""

import re

from places import ROOT

FOLDER = ROOT / "docs" / "tutorials" / "notebooks"
NOTEBOOKS = sorted(FOLDER.glob("*.py"))


def test_all_of_them_are_in_the_site():
    listed = re.findall(r"tutorials/notebooks/(\w+)\.md", (ROOT / "mkdocs.yml").read_text(encoding="utf-8"))
    assert sorted(listed) == [path.stem for path in NOTEBOOKS] and len(listed) >= 5
    index = (FOLDER.parent / "index.md").read_text(encoding="utf-8")
    assert re.findall(r"\(notebooks/(\w+)\.py\)", index) == listed
