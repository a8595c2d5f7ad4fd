"""Releases: version, notes, packages and the conda recipe."""

import importlib.metadata
import re
import runpy
import tomllib

import pytest
from places import ROOT

import kinetostatics as ks

PROJECT = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
notes = runpy.run_path(str(ROOT / ".ci" / "release_notes.py"))["notes"]
differences = runpy.run_path(str(ROOT / ".ci" / "package_contents.py"))["differences"]

CHANGELOG = """# Changelog

## [Unreleased]

## [0.2.0] - 2026-12-24

### Added

- A thing.

## [0.1.0]

- The first.

## [0.0.1] - 2026-01-01

"""


def test_notes_of_a_release_are_the_section_of_its_version():
    assert notes(CHANGELOG, "v0.2.0") == notes(CHANGELOG, "0.2.0") == "### Added\n\n- A thing.\n"
    with pytest.raises(ValueError, match=r"no section for 0\.3\.0, only for Unreleased, 0\.2\.0, 0\.1\.0, 0\.0\.1"):
        notes(CHANGELOG, "v0.3.0")
    with pytest.raises(ValueError, match=r"no date for 0\.1\.0: write ## \[0\.1\.0\] - YYYY"):
        notes(CHANGELOG, "v0.1.0")
    with pytest.raises(ValueError, match=r"says nothing of 0\.0\.1"):
        notes(CHANGELOG, "v0.0.1")


def test_unreleased_section_becomes_notes_of_a_version():
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert text.count("## [Unreleased]") == 1
    found = notes(text.replace("## [Unreleased]", "## [7.8.9] - 2026-12-24"), "v7.8.9")
    assert found.startswith("### ") and "\n## " not in found


def test_version_comes_from_the_tag_only():
    assert 'dynamic = ["version"]' in PROJECT and 'fallback-version = "0.1.dev0"' in PROJECT
    assert "version:" not in re.sub("cff-version:", "", (ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert re.match(r"\d+[.+]", ks.__version__)


def test_version_of_uninstalled_source_is_unknown(monkeypatch):
    def version(name):
        raise importlib.metadata.PackageNotFoundError(name)

    monkeypatch.setattr(importlib.metadata, "version", version)
    assert ks.__version__ == "0+unknown"


def test_missing_and_extra_files_of_packages_are_reported():
    files = {"robots/a.urdf.xacro", "src/kinetostatics/b.py", "tests/c.py"}
    licence = "k-1.dist-info/licenses/LICENSE"
    whole = {"kinetostatics/robots/a.urdf.xacro", "kinetostatics/b.py", "k-1.dist-info/entry_points.txt", licence}
    assert differences(whole, files | {"PKG-INFO"}, files) == []
    assert differences(whole - {"kinetostatics/robots/a.urdf.xacro"}, files, files) == [
        "the wheel lacks kinetostatics/robots/a.urdf.xacro"
    ]
    assert differences(whole | {"tests/c.py"}, files - {"tests/c.py"}, files) == [
        "the wheel holds tests/c.py, which is no part of the package",
        "the source archive lacks tests/c.py",
    ]
    assert differences(whole - {licence}, files, files) == ["the wheel lacks .dist-info/licenses/LICENSE"]


def test_linters_are_a_dependency_group_and_no_requirement_of_the_tests():
    project = tomllib.loads(PROJECT)
    linters = set(requirements(project["dependency-groups"]["lint"]))
    assert linters == {"ruff", "mypy", "deptry", "import-linter"}
    assert linters.isdisjoint(requirements(project["project"]["optional-dependencies"]["test"]))
    assert "--group lint" in (ROOT / ".ci" / "run").read_text(encoding="utf-8")


def test_release_workflow_calls_existing_scripts():
    import yaml

    jobs = yaml.safe_load((ROOT / ".github" / "workflows" / "release.yml").read_text(encoding="utf-8"))["jobs"]
    steps = jobs["build"]["steps"]
    assert steps[0]["with"]["fetch-depth"] == 0, "a shallow clone does not know its tags"
    called = re.findall(r"\.ci/[\w.]+", " ".join(step.get("run", "") for step in steps))
    assert called == [".ci/release_notes.py", ".ci/packages"] and all((ROOT / name).exists() for name in called)
    assert ".ci/packages build/main" in (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    assert jobs["index"]["permissions"] == {"id-token": "write"}, "trusted publishing needs a token of its own"


# ---- conda -----------------------------------------------------------------------------------------------------------

#: Names that conda-forge has for packages of PyPI.
CONDA_NAMES = {"pin": "pinocchio", "meshcat": "meshcat-python", "matplotlib": "matplotlib-base"}


def requirements(lines):
    """Return the required versions by name."""
    found = {}
    for line in lines:
        name, versions = re.fullmatch(r"([\w-]+)(?:\[\w+\])?\s*([^;]*)(?:;.*)?", line).groups()
        found.setdefault(CONDA_NAMES.get(name, name), versions.strip().replace(" ", ""))
    return found


def test_conda_recipe_has_the_requirements_of_the_package():
    import yaml

    recipe = yaml.safe_load((ROOT / "conda" / "recipe.yaml").read_text(encoding="utf-8"))
    project = tomllib.loads(PROJECT)
    run = requirements(recipe["requirements"]["run"])
    assert run.pop("python") == project["project"]["requires-python"]
    assert run == requirements(project["project"]["dependencies"])
    optional = requirements(line for extra in project["project"]["optional-dependencies"].values() for line in extra)
    assert requirements(recipe["requirements"]["run_constraints"]).items() <= optional.items()
    assert set(project["build-system"]["requires"]) <= set(recipe["requirements"]["host"])
    (entry,) = recipe["build"]["python"]["entry_points"]
    assert entry.split(" = ") == ["kinetostatics", project["project"]["scripts"]["kinetostatics"]]
    assert recipe["about"]["summary"] == project["project"]["description"]
