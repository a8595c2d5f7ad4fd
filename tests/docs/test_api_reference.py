"""The API reference has an entry for every public name, and the page of the command line for every command."""

import re

import pytest
from places import ROOT

import kinetostatics as ks
from kinetostatics.cli.main import COMMANDS

PAGES = sorted((ROOT / "docs" / "reference" / "api").glob("*.md"))
ENTRIES = [name for page in PAGES for name in re.findall(r"^::: kinetostatics\.([\w.]+)$", page.read_text("utf-8"), re.MULTILINE)]
MODULES = ("description", "indices", "plot", "sections")


def test_every_public_name_has_one_entry():
    assert len(ENTRIES) == len(set(ENTRIES))
    assert set(ks.__all__) - set(MODULES) - set(ENTRIES) == set()


@pytest.mark.parametrize("module", MODULES)
def test_every_name_of_a_module_has_an_entry(module):
    if module in ("indices", "plot"):
        pytest.importorskip("xarray")
        pytest.importorskip("matplotlib")
    assert {f"{module}.{name}" for name in getattr(ks, module).__all__} - set(ENTRIES) == set()


def test_the_table_of_the_api_leads_to_every_name():
    table = (ROOT / "docs" / "reference" / "api" / "index.md").read_text("utf-8")
    listed = re.findall(r"\[`(\w+)`\]\[kinetostatics\.(\w+)\]", table)
    assert [name for name, target in listed if name != target] == []
    assert {name for name, _ in listed} == set(ks.__all__) - set(MODULES)
    assert all(f"[`{module}.…`](" in table for module in MODULES)


def test_every_command_has_its_help_on_the_page():
    page = (ROOT / "docs" / "reference" / "command_line.md").read_text("utf-8")
    assert re.findall(r"^## `kinetostatics (\w+)`\n\n<!-- help: \1 -->$", page, re.MULTILINE) == list(COMMANDS)
