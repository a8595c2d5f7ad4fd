"""The gallery says of every robot that comes with the package what the robot itself says."""

import re

import gallery_pages as gallery
import pytest

from kinetostatics.files.bundled import shipped_robots

ROBOTS = sorted(shipped_robots())


def words(text):
    """Return numbers as such, those that are only rounding as zeros, and all else as it is."""
    found = [re.fullmatch(r"-?\d+(\.\d+)?", word) for word in text.split()]
    return [float(number[0]) if number else word for number, word in zip(found, text.split(), strict=True)]


def test_every_robot_has_its_page_and_its_place():
    assert sorted(gallery.ORDER) == ROBOTS == sorted(page.stem for page in gallery.PAGES.glob("*.md"))


@pytest.mark.parametrize("page", [*map(gallery.page_of, gallery.ORDER), gallery.INDEX], ids=lambda page: page.stem)
def test_what_is_computed_is_fresh(page):
    shown, fresh = words(page.read_text(encoding="utf-8")), words(gallery.fresh(page))
    stale = "stale: run python tests/support/gallery_pages.py"
    assert len(shown) == len(fresh), stale
    for a, b in zip(shown, fresh, strict=True):
        assert a == (pytest.approx(b, rel=2e-3) if isinstance(b, float) else b), stale


def test_the_facts_are_the_robots():
    """Known beforehand: the paper's robots, the Delta's spinning rods, the isotropic Orthoglide, the tripod's sag of Table 1."""
    assert gallery.facts("3rps")["limbs, base to platform"] == "`3-R[P]S`"
    assert gallery.facts("2pru_upr")["limbs, base to platform"] == "`2-[P]RU + U[P]R`"
    assert gallery.facts("delta")["limbs, base to platform"] == "`3-[R](SS‖SS)`"
    assert [gallery.facts("delta")[key] for key in ("mobility", "local freedoms")] == ["3", "6"]
    softest, stiffest = re.findall(r"([\d.]+) N/µm", gallery.facts("orthoglide")["stiffness against a force at o, at zero"])
    assert softest == stiffest
    # at 9.81 m/s², not 9.8 as in Table 1
    sag = float(re.search(r"o moves by ([\d.]+) nm", gallery.facts("3rps")["bent by its own weight, at zero"])[1])
    assert sag == pytest.approx(83.19 * 9.81 / 9.8, rel=2e-4)


@pytest.mark.parametrize("name", ROBOTS)
def test_the_lists_of_parameters_are_those_of_the_files(name):
    page = gallery.page_of(name).read_text(encoding="utf-8")
    paragraph = page.partition("**Parameters.**")[2].partition("\n\n")[0]
    listed = re.findall(r"`(\w+)`", re.sub(r"\([^)]*\)", "", paragraph))
    assert sorted(listed) == sorted(re.findall(r'<xacro:arg name="(\w+)"', shipped_robots()[name].read_text(encoding="utf-8")))


@pytest.mark.parametrize("name", ROBOTS)
def test_every_source_that_is_named_is_there(name):
    page = gallery.page_of(name).read_text(encoding="utf-8")
    named = set(re.findall(r"\[([A-Z]\w+)\](?!\()", gallery.about(name, "Source of its dimensions")))
    for source in named:
        assert re.search(rf"(^|[.:] )\[{source}\] \w", page, re.MULTILINE), source
