"""CONTRIBUTING.md, hooks and workflow name what exists; CITATION.cff equals the README; which tests are chosen."""

import json
import os
import re
import subprocess
import sys

import pytest
import yaml
from places import ROOT
from selection import in_part

PAGE = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")


def test_files_named_in_contributing_exist():
    names = re.findall(r"`((?:src|tests|docs)/[\w/.]+)`", PAGE) + re.findall(r"\]\(([^)#:]+)", PAGE)
    assert len(names) > 15
    for name in names:
        assert (ROOT / name).exists(), name


def test_citation_equals_that_of_the_readme():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    paper = citation["preferred-citation"]
    assert f"title   = {{{paper['title']}}}" in readme and f"year    = {{{paper['year']}}}" in readme
    assert " and ".join(f"{item['family-names']}, {item['given-names']}" for item in paper["authors"]) in readme


def test_hooks_and_workflow_call_existing_commands():
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


def test_each_slow_test_is_in_exactly_one_part():
    """Collected as ``.ci/run`` does, with the cases that ``few`` makes slow: in one of forty parts, or of thirty."""
    code = r"""if True:
        import json, pytest
        class Collected:
            def pytest_collection_finish(self, session):
                marks = {item.nodeid: item.get_closest_marker("parts") for item in session.items}
                tests.append({test: list(mark.args) if mark else [] for test, mark in marks.items()})
        tests, options = [], ["--collect-only", "-qq", "-m", "slow", "tests/engine", "tests/validation/test_verification.py"]
        for part in ([], ["--part", "1517"], ["--part", "1557"]):
            pytest.main(options + part, plugins=[Collected()])
        print("\n" + json.dumps(tests))
    """
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    every, *parts = json.loads(done.stdout.splitlines()[-1])
    for test, count in every.items():
        assert sum(in_part(test, number, *count) for number in range(1500, 1500 + (count or [40])[0])) == 1
    for number, part in zip((1517, 1557), parts, strict=True):
        assert list(part) == [test for test, count in every.items() if in_part(test, number, *count)]
        plain, costly = ({test for test, count in part.items() if bool(count) == is_costly} for is_costly in (False, True))
        assert len(plain) > 12 and 3 < len(costly) < 12
    assert len(every) > 900 and {test for test in parts[0] if not every[test]} == {test for test in parts[1] if not every[test]}
    assert not {test for test in parts[0] if every[test]} & {test for test in parts[1] if every[test]}


@pytest.mark.parametrize("required", [False, True])
def test_what_is_missing_fails_where_everything_is_required(required, tmp_path):
    """A test of what needs CalculiX, with no program in reach."""
    name = "tests/validation/test_solid_finite_elements.py::test_solids_agree_with_beams"
    environment = {**os.environ, "PATH": str(tmp_path), "KINETOSTATICS_REQUIRE_ALL": str(int(required))}
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-rs", "-m", "not slow", name]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, env=environment)
    assert done.returncode == int(required), done.stdout
    assert "needs ccx" in done.stdout and ("KINETOSTATICS_REQUIRE_ALL is set" in done.stdout) == required
