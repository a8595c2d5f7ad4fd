"""What CONTRIBUTING.md and CITATION.cff say is there."""

import importlib
import re

import pytest
from places import ROOT

PAGE = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")


def test_files_and_folders_exist():
    names = re.findall(r"`((?:src|tests|docs)/[\w/.]+)`", PAGE) + re.findall(r"\]\(([^)#:]+)", PAGE)
    assert len(names) > 15
    for name in names:
        assert (ROOT / name).exists(), name


def test_tests_stand_where_the_page_says():
    source = ROOT / "src" / "kinetostatics"
    for path in (ROOT / "tests" / "unit").iterdir():
        if path.name.startswith("test_"):
            assert (source / path.name.removeprefix("test_")).is_file(), path
        elif any(path.glob("test_*.py")):
            assert (source / path.name).is_dir(), path
    for path in (ROOT / "tests").iterdir():
        assert not any(path.glob("test_*.py")) or f"`tests/{path.name}/" in PAGE, path


def test_any_stands_in_aliases_that_the_page_names():
    found = []
    for path in sorted((ROOT / "src").rglob("*.py")):
        lines = path.read_text(encoding="utf-8").splitlines()
        # of what else has the word, sentences begin with it
        found += [f"{path.name}: {line}" for line in lines if re.search(r"\bAny\b(?! (?:other|one) )|\btyping as\b", line)]
    uses = [line for line in found if not re.search(r": from typing import [\w, ]+$", line)]
    aliases = [re.search(r": (\w+): TypeAlias = .*\bAny\b.*  # \w", line) for line in uses]
    assert all(aliases), [line for line, alias in zip(uses, aliases, strict=True) if alias is None]
    sentence = re.search(r"`Any` stands only in the aliases ([^;]+);", PAGE)[1]
    assert sorted(alias[1] for alias in aliases) == sorted(re.findall(r"`(\w+)`", sentence))


def test_names_are_defined_where_the_page_says():
    for name, path in re.findall(r"`([A-Z_]{4,})` of\s+`((?:src|tests)/[\w/]+)\.py`", PAGE):
        if path.startswith("src/"):
            assert hasattr(importlib.import_module(path.removeprefix("src/").replace("/", ".")), name), (name, path)
        else:
            assert re.search(rf"^{name}\b", (ROOT / f"{path}.py").read_text(encoding="utf-8"), re.MULTILINE), (name, path)


def test_recipes_are_short():
    recipes = re.split(r"^## ", PAGE, flags=re.MULTILINE)
    assert {"Add a joint type", "Add a result", "Add a command"} <= {recipe.split("\n")[0] for recipe in recipes}
    for recipe in recipes[1:]:
        title, *lines = recipe.strip().splitlines()
        assert not title.startswith("Add") or len(lines) <= 10, title


def test_the_citation_is_that_of_the_package_and_of_the_readme():
    citation = pytest.importorskip("yaml").safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    paper = citation["preferred-citation"]
    assert f"title   = {{{paper['title']}}}" in readme and f"year    = {{{paper['year']}}}" in readme
    assert " and ".join(f"{item['family-names']}, {item['given-names']}" for item in paper["authors"]) in readme


def test_hooks_and_the_workflow_call_what_exists():
    yaml = pytest.importorskip("yaml")
    hooks = yaml.safe_load((ROOT / ".pre-commit-config.yaml").read_text(encoding="utf-8"))["repos"][0]["hooks"]
    commands = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    for hook in hooks:
        assert hook["entry"].replace(" --force-exclude", "") in commands, hook["id"]
    jobs = yaml.safe_load((ROOT / ".github" / "workflows" / "tests.yml").read_text(encoding="utf-8"))["jobs"]
    assert [step["run"] for step in jobs["everything"]["steps"] if "run" in step] == [
        ".ci/run",
        ".venv/bin/python -m pytest -m slow -n 2",
    ]
    versions = jobs["versions"]["strategy"]["matrix"]["python"]
    project = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    assert "-m pytest -m slow" in (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8") and "-m further" in commands
    assert f'requires-python = ">={versions[0]}"' in project
