"""The glossary against the code: attributes exist, and the code of a formula names its symbol and equation."""

import importlib
import inspect
import re
from functools import cached_property

import glossary_table
import package_robots
import pytest
from page_code import between, text_of

import kinetostatics as ks

PAGE, METHOD = text_of("explanation/glossary"), text_of("explanation/method")


def rows(name):
    return [[cell.strip() for cell in line.strip("|\n").split(" | ")] for line in between(PAGE, name).splitlines()[2:]]


def named(path):
    """Return a module, class, function or attribute of the package by its dotted name."""
    parts = path.split(".")
    for count in range(len(parts), 0, -1):
        try:
            found = importlib.import_module(".".join(["kinetostatics", *parts[:count]]))
        except ModuleNotFoundError:
            continue
        for name in parts[count:]:
            found = inspect.getattr_static(found, name)
        return found
    raise AssertionError(path)


SYMBOLS, WORDS = rows("symbols"), rows("words")


@pytest.fixture(scope="module")
def result():
    return ks.analyze(package_robots.robot("3rps").assemble())


@pytest.mark.parametrize("row", SYMBOLS, ids=lambda row: row[0])
def test_symbol_has_its_attribute_equation_and_units(row, result):
    symbol, _, equation, attribute, code, unit = row
    doc = inspect.getdoc(named(code.strip("`"))) or ""
    for part in symbol.split(", "):
        assert re.search(rf"(?<!\w){re.escape(part.split(' ')[0])}(?!\w)", doc), f"{code} does not name {part}"
    for number in re.findall(r"\((\d+)\)", equation):
        assert f"({number})" in doc, f"{code} does not name Eq. ({number})"
    section = re.fullmatch(r"§ (\d+)", equation)
    assert section is None or f"## {section[1]}. " in METHOD
    assert unit
    if attribute != "–":
        path = attribute.strip("`")
        assert eval(path, {"result": result}) is not None
        told = {item for found in re.findall(r"\[([^\]]+)\]", described(path, result)) for item in re.split(", | or ", found)}
        # a mapping's docstring gives the units of all its entries
        assert set(unit.split(", ")) <= told if path.startswith("result.paper_forces") else set(unit.split(", ")) == told


@pytest.mark.parametrize("row", WORDS, ids=lambda row: row[0])
def test_word_has_its_code(row):
    word, meaning, code = row
    doc = inspect.getdoc(named(code.strip("`"))) or ""
    assert meaning and re.search(rf"\b{word}", doc, re.IGNORECASE), f"{code} does not name the {word}"


def test_code_named_on_the_page_exists():
    paths = {path for path in re.findall(r"`([a-z_]+(?:\.\w+)+)`", PAGE) if not path.startswith("result.")}
    assert len(paths) > 15
    for path in paths:
        named(path)


def test_a_wrench_is_transformed_to_a_section_by_one_symbol():
    """X are the wrenches of cut joints, which section 9 introduces; before, there is none."""
    before = METHOD[: METHOD.index("## 9. ")]
    assert not re.search(r"(?<![A-Za-z\\])X(?![a-z])", re.sub(r"```.*?```", "", before, flags=re.DOTALL))


def described(path, result):
    """Return the docstring of an attribute, from its own or from its class."""
    owner, name = re.fullmatch(r"(.*?\w(?:\[[^\]]*\])?)\.(\w+)(?:\[[^\]]*\])*", path).groups()
    kind = type(eval(owner, {"result": result}))
    own = inspect.getattr_static(kind, name, None)
    if isinstance(own, property | cached_property):
        return inspect.getdoc(own)
    rows = re.search(rf"^ +{name}: (.*?)(?=^ +\w+(?:, \w+)*: |\Z)", kind.__doc__, re.MULTILINE | re.DOTALL)
    assert rows is not None, path
    return rows[1]


def test_rows_of_quantities_are_up_to_date():
    lines = PAGE.splitlines()
    assert all(row in lines for row in glossary_table.rows().values()), "run tests/support/glossary_table.py"
