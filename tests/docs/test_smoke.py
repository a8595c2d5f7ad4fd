"""The smoke tests touch every package."""

from places import ROOT, TESTS

ELSEWHERE = {"cli": TESTS / "cli"}


def test_every_package_has_a_smoke_test():
    packages = [path.parent.name for path in (ROOT / "src" / "kinetostatics").glob("*/__init__.py")]
    assert len(packages) > 15
    for name in packages:
        files = ELSEWHERE.get(name, TESTS / "unit" / name).glob("test_*.py")
        assert any("mark.smoke" in file.read_text(encoding="utf-8") for file in files), name
