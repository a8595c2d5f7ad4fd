"""The code of ``docs/how_to/robots_in_python.md`` prints the output in its comments, and its example runs."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import robot_without_a_file as example
from page_code import in_a_copy, python_of, text_of

import kinetostatics as ks

PAGE = text_of("how_to/robots_in_python")


def test_blocks_print_the_output_in_their_comments(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    in_a_copy(tmp_path)
    monkeypatch.chdir(tmp_path)
    blocks = python_of("how_to/robots_in_python")
    names: dict[str, Any] = {}
    for block in blocks:
        exec(compile(block, "python_api.md", "exec"), names)  # the page's own text
        said = re.findall(r"(?:^|print\(.*\)  )# (.*)$", block, re.MULTILINE)
        assert capsys.readouterr().out.splitlines() == said
    assert len(blocks) == 9 and (tmp_path / "stronger.urdf").exists()


def test_example_file_loads_as_the_same_robot(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    example.main(str(tmp_path / "tripod.urdf"))
    assert capsys.readouterr().out.rstrip().endswith("what it loads as is the same: True")


def test_example_forces_equal_statics_by_hand() -> None:
    """The upright tripod by symmetry and statics; thicker legs hold the camera better."""
    bare = ks.analyze(ks.Robot(example.tripod()).assemble())
    np.testing.assert_allclose(bare.twist[[0, 1, 3, 4, 5]], 0, atol=1e-15)
    force = [float(value) for value in bare.actuator_forces.values()]
    length, area = np.hypot(0.2, 0.8), np.pi / 4 * (0.03**2 - 0.026**2)
    rod = 2700 * area * length
    cosine, sine = 0.8 / length, 0.2 / length
    # moments about the hinge: the ball's force across the leg holds half the rod's weight, and the cylinder's at 0.15 m
    across = 9.81 * sine * (rod / 2 + 0.5 * 0.15 / length)
    along = (9.81 * 8.0 / 3 + across * sine) / cosine  # a third of the table hangs on each ball
    assert force == [pytest.approx(along + 9.81 * rod * cosine, rel=1e-10)] * 3
    camera = example.with_camera(example.tripod())
    stiff = example.with_legs(camera, 0.05)
    assert camera.beams["rod_2"].section.outer_diameter == 0.03 and stiff.beams["rod_2"].section.outer_diameter == 0.05
    tilt = [abs(ks.analyze(ks.Robot(item).assemble()).twist[4]) for item in (camera, stiff)]
    assert tilt[1] < tilt[0] / 4
