"""The API reference has an entry for every public name, and the page of the command line for every command."""

import importlib
import inspect
import re
from types import ModuleType

import pytest
from places import ROOT

import kinetostatics as ks
from kinetostatics.cli.main import COMMANDS

PAGES = sorted((ROOT / "docs" / "reference" / "api").glob("*.md"))
ENTRIES = [name for page in PAGES for name in re.findall(r"^::: kinetostatics\.([\w.]+)$", page.read_text("utf-8"), re.MULTILINE)]
MODULES = ("description", "exceptions", "files", "functions", "indices", "plot", "results", "sections")


def test_every_public_name_has_one_entry():
    assert len(ENTRIES) == len(set(ENTRIES))
    assert set(ks.__all__) - set(MODULES) - set(ENTRIES) == set()
    assert {name for name in ks.__all__ if isinstance(getattr(ks, name), ModuleType)} == set(MODULES)


@pytest.mark.parametrize("module", MODULES)
def test_every_name_of_a_module_has_an_entry(module):
    """An object that is public in the package too has its entry there."""
    found = importlib.import_module(f"kinetostatics.{module}")
    assert {f"{module}.{name}" for name in found.__all__ if name not in ks.__all__} - set(ENTRIES) == set()


@pytest.mark.parametrize("entry", ENTRIES)
def test_functions_methods_and_properties_of_the_api_have_docstrings(entry):
    module, _, name = f"kinetostatics.{entry}".rpartition(".")
    found = getattr(importlib.import_module(module), name)
    members = [getattr(found, item) for item in dir(found)] if inspect.isclass(found) else [found]
    for member in members:
        function = inspect.unwrap(getattr(member, "fget", getattr(member, "func", member)))  # of properties, cached or not
        if inspect.isfunction(function) and function.__module__.startswith("kinetostatics") and function.__name__[0] != "_":
            assert inspect.getdoc(member), function.__qualname__


def test_every_command_has_its_help_on_the_page():
    page = (ROOT / "docs" / "reference" / "command_line.md").read_text("utf-8")
    assert re.findall(r"^## `kinetostatics (\w+)`\n\n<!-- help: \1 -->$", page, re.MULTILINE) == list(COMMANDS)
