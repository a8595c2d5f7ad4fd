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


def test_names_of_a_robot_are_those_of_its_entry():
    """``dir``, and with it completion, shows the entry's members and attributes, and ``report`` and ``to_dict``."""
    page = (ROOT / "docs" / "reference" / "api" / "loading.md").read_text("utf-8")
    inherited = re.search(r"^::: kinetostatics\.Robot\n(?:    .*\n)*?      inherited_members: \[(.*)\]", page, re.MULTILINE)
    attributes = re.findall(r"^    (\w+): ", inspect.getdoc(ks.Robot).partition("Attributes:")[2], re.MULTILINE)
    own = {name for name in vars(ks.Robot) if name[0] != "_"}
    shown = [name for name in dir(ks.load_robot("3rps")) if name[0] != "_"]
    assert sorted({*own, *attributes, *inherited[1].split(", "), "report", "to_dict"}) == shown and len(shown) < 25


def test_every_command_has_its_help_on_the_page():
    page = (ROOT / "docs" / "reference" / "command_line.md").read_text("utf-8")
    assert re.findall(r"^## `kinetostatics ([\w-]+)`\n\n<!-- help: \1 -->$", page, re.MULTILINE) == list(COMMANDS)
