"""Links of the pages, README and CONTRIBUTING lead to files; pages, pictures and notebooks are used.

``mkdocs build --strict`` checks anchors.
"""

import re

import pytest
from places import ROOT

DOCS = ROOT / "docs"
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted(DOCS.rglob("*.md"))]


def targets(page):
    """Return what a page links to, without code."""
    text = re.sub(r"^```.*?^```$|`[^`]*`", "", page.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)
    return re.findall(r"\]\(([^)\s#:]+)(?:#[^)]*)?\)", text)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_links_lead_to_files(page):
    for target in targets(page):
        file = page.parent / target
        assert file.exists() or (file.parent.name == "notebooks" and file.with_suffix(".py").exists()), target


def test_every_picture_is_used_on_a_page():
    shown = {(page.parent / target).resolve() for page in PAGES for target in targets(page)}
    assert [picture.name for picture in (DOCS / "pictures").rglob("*.*") if picture.resolve() not in shown] == []


def test_navigation_lists_every_page_once():
    site = (ROOT / "mkdocs.yml").read_text(encoding="utf-8").partition("\nnav:\n")[2]
    listed = re.findall(r"^ +- (?:[\w ]+: )?(\S+\.md)$", site, re.MULTILINE)
    pages = [page.relative_to(DOCS).as_posix() for page in DOCS.rglob("*.md")]
    assert sorted(set(listed) - {name for name in listed if "/notebooks/" in name}) == sorted(pages)
    assert len(listed) == len(set(listed))


def test_every_notebook_is_listed():
    """``mkdocs build`` runs them, and fails where one of their assertions does."""
    notebooks = sorted((DOCS / "tutorials" / "notebooks").glob("*.py"))
    listed = re.findall(r"tutorials/notebooks/(\w+)\.md", (ROOT / "mkdocs.yml").read_text(encoding="utf-8"))
    assert sorted(listed) == [path.stem for path in notebooks] and len(listed) >= 5
    index = (DOCS / "tutorials" / "index.md").read_text(encoding="utf-8")
    assert re.findall(r"\(notebooks/(\w+)\.py\)", index) == listed
