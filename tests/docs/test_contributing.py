"""Files and commands named in CONTRIBUTING.md, the hooks and the workflow exist; CITATION.cff equals the README."""

import re

import pytest
from places import ROOT

PAGE = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")


def test_files_named_in_contributing_exist():
    names = re.findall(r"`((?:src|tests|docs)/[\w/.]+)`", PAGE) + re.findall(r"\]\(([^)#:]+)", PAGE)
    assert len(names) > 15
    for name in names:
        assert (ROOT / name).exists(), name


def test_citation_equals_that_of_the_readme():
    citation = pytest.importorskip("yaml").safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    paper = citation["preferred-citation"]
    assert f"title   = {{{paper['title']}}}" in readme and f"year    = {{{paper['year']}}}" in readme
    assert " and ".join(f"{item['family-names']}, {item['given-names']}" for item in paper["authors"]) in readme


def test_hooks_and_workflow_call_existing_commands():
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
    assert "-m pytest -m slow" in (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    assert f'requires-python = ">={versions[0]}"' in project
