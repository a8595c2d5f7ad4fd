"""The smoke tests touch every package."""

from places import ROOT, TESTS

#: Packages whose quickest tests are not in a folder of unit tests: they need maps, the command line or finite elements.
ELSEWHERE = {"cli": "cli", "checks": "cli", "indices": "maps", "plots": "maps", "verification": "validation"}


def test_every_package_has_a_smoke_test():
    packages = [path.parent.name for path in (ROOT / "src" / "kinetostatics").glob("*/__init__.py")]
    assert len(packages) > 15
    for name in packages:
        files = (TESTS / ELSEWHERE.get(name, f"unit/{name}")).glob("test_*.py")
        assert any("mark.smoke" in file.read_text(encoding="utf-8") for file in files), name
