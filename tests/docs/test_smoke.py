"""The smoke tests touch every package."""

from places import ROOT, TESTS

#: Packages whose quickest tests are not in a folder of unit tests: they need maps, the command line or finite elements, compile,
#: or analyse many designs.
ELSEWHERE = {
    **{"cli": "cli", "checks": "cli", "indices": "maps", "plot": "maps", "verification": "validation", "viewer": "browser"},
    **{"engine": "engine", "functions": "functions", "design": "design"},
    **{"calibration": "design/test_calib*", "compensation": "design/test_compens*"},
}


def test_every_package_has_a_smoke_test():
    packages = [path.parent.name for path in (ROOT / "src" / "kinetostatics").glob("*/__init__.py")]
    assert len(packages) > 15
    for name in packages:
        place = ELSEWHERE.get(name, f"unit/{name}")
        files = TESTS.glob(f"{place}.py" if "*" in place else f"{place}/test_*.py")
        assert any("mark.smoke" in file.read_text(encoding="utf-8") for file in files), name
