"""``ks.save_report``: invalid arguments are errors, and a sentence stands for each missing part."""

import pytest
from package_robots import robot

import kinetostatics as ks
import kinetostatics.report_page as page
from kinetostatics.verification import OpenSeesError


def test_missing_opensees_is_explained_in_the_report(monkeypatch):
    def missing(*_more, **_options):
        raise OpenSeesError("the check by finite elements needs OpenSeesPy: pip install 'kinetostatics[verify]'")

    monkeypatch.setattr(page, "verify", missing)
    said = page.verification_html(ks.analyze(robot("five_bar").assemble()), {})
    assert said.startswith("<p>No verdict: the check by finite elements needs OpenSeesPy: pip install")


def test_undeformed_robot_has_a_sentence_instead_of_bars():
    result = ks.analyze(robot("five_bar").assemble(), gravity=[0, 0, 0])
    assert page.sag_html(result).startswith("<p>The platform does not move")


def test_invalid_controlled_is_an_error_missing_actuators_a_sentence(monkeypatch):
    result = ks.analyze(robot("five_bar").assemble())
    with pytest.raises(ks.KinetostaticsError, match="x, y"):
        page.compensation_html(result, {}, ("z", "rx"))

    def unactuated(*_more, **_options):
        raise ks.ArgumentError("'five_bar' has no actuators, so that nothing can be corrected")

    monkeypatch.setattr(page, "compensate", unactuated)
    assert page.compensation_html(result, {}, None).startswith("<p>No correction: &#x27;five_bar&#x27; has no actuators")


def test_invalid_arguments_of_save_report_are_errors(tmp_path):
    found = robot("five_bar")
    pose = found.assemble()
    with pytest.raises(ks.ArgumentError, match="a report needs a Configuration"):
        ks.save_report(found, tmp_path / "x.html")
    with pytest.raises(ks.ArgumentError, match=r"not a batch of the shape \(2,\)"):
        ks.save_report(pose, tmp_path / "x.html", load=[[0] * 6] * 2)
    with pytest.raises(ks.ArgumentError, match="the path of a file"):
        ks.save_report(pose, None)
    with pytest.raises(ks.ArgumentError, match="the map is of '3rps', but the pose of 'five_bar'"):
        ks.save_report(pose, tmp_path / "x.html", workspace=ks.sweep(found).assign_attrs(robot_name="3rps"))
    with pytest.raises(
        ks.ArgumentError, match=r"the map refers to the point \(0 0 0.1\) m of the platform: give tool=\(0, 0, 0.1\)"
    ):
        ks.save_report(pose, tmp_path / "x.html", workspace=ks.indices.at_point(ks.sweep(found), (0, 0, 0.1)))
    with pytest.raises(ks.ArgumentError, match=r"not a Dataset of ks\.sweep"):
        ks.save_report(pose, tmp_path / "x.html", workspace={})
    for name in ("x.pdf", "x.txt", "x"):
        with pytest.raises(ks.ArgumentError, match=f"{name}: the page is an HTML file, .*; name it 'x.html'"):
            ks.save_report(pose, tmp_path / name)
    with pytest.raises(ks.KinetostaticsError, match="cannot be written"):
        ks.save_report(pose, tmp_path / "none" / "x.html")
    assert not list(tmp_path.iterdir())
