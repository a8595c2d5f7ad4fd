"""Figures of a compensation and of an optimum: every number in them is that of the result."""

import numpy as np
import package_robots
import parametric_machines
import pytest

import kinetostatics as ks
from kinetostatics.cli.main import main
from kinetostatics.exceptions import ArgumentError

matplotlib = pytest.importorskip("matplotlib", reason="needs Matplotlib: pip install 'kinetostatics[plot]'")
matplotlib.use("Agg")

pytestmark = pytest.mark.usefixtures("no_figures_left")

LOAD = [0, 100, -500, 0, 0, 0]
TILTS = np.linspace(-0.2, 0.2, 7)


@pytest.fixture(scope="module")
def path():
    pose = package_robots.robot("3rps").assemble(platform={"z": 0.5, "rx": TILTS, "ry": 0.0})
    return ks.compensate(pose, LOAD, payload=ks.Payload(5.0))


def drawn(ax):
    """Numbers of lines with a label, and of dashed ones."""
    named = {line.get_label(): line for line in ax.get_lines() if not line.get_label().startswith("_")}
    dashed = [line for line in ax.get_lines() if line.get_linestyle() == "--"]
    return named, dashed


@pytest.mark.parametrize("what, names, unit", [("displacement", "xyz", 1e6), ("rotation", ("rx", "ry", "rz"), 1e6)])
def test_a_path_has_before_and_after_of_every_coordinate(path, what, names, unit):
    ax = ks.plot.compensation(path, what)
    named, dashed = drawn(ax)
    assert list(named) == list(names) and len(dashed) == 3
    assert ax.get_ylabel() == {"displacement": "o misses by [µm]", "rotation": "angle misses by [µrad]"}[what]
    assert ax.get_xlabel() == "rx [°]"
    for (name, line), other in zip(named.items(), dashed, strict=True):
        np.testing.assert_allclose(line.get_xdata(), np.degrees(TILTS), atol=1e-9)
        np.testing.assert_allclose(line.get_ydata(), unit * path.residual_error_coordinates[name], rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(other.get_ydata(), unit * path.uncorrected_error_coordinates[name], rtol=1e-12, atol=1e-12)


def test_drives_have_corrections_and_forces(path):
    named, dashed = drawn(ks.plot.compensation(path, "correction", x="y"))
    assert list(named) == list(path.corrections) and not dashed
    sizes = {float(np.round(line.get_ydata()[0] / path.corrections[name][0], 3)) for name, line in named.items()}
    assert len(sizes) == 1 and sizes <= {1e6, 1e9}
    np.testing.assert_allclose(named["prismatic_1"].get_xdata(), 1e3 * path.target.platform["y"], atol=1e-9)
    ax = ks.plot.compensation(path, "force", actuators=["prismatic_2"])
    named, (weights,) = drawn(ax)
    np.testing.assert_allclose(named["prismatic_2"].get_ydata(), path.actuator_forces["prismatic_2"], rtol=1e-12)
    alone = ks.analyze(path.configuration).actuator_forces["prismatic_2"]  # what the same actuators hold without load and payload
    np.testing.assert_allclose(weights.get_ydata(), alone, rtol=1e-9)
    assert ax.get_ylabel() == "force of the actuator [N]"


def test_poses_that_are_no_path_are_bars():
    pose = package_robots.robot("3rps").assemble(platform={"z": np.array([[0.45], [0.5]]), "rx": np.array([0.0, 0.1]), "ry": 0.0})
    found = ks.compensate(pose, LOAD)
    ax = ks.plot.compensation(found)
    heights = np.array([bar.get_height() for bar in ax.patches]).reshape(3, 2)  # of x, y, z: before, after
    before, after = (
        [1e6 * np.abs(off[name]).max() for name in "xyz"]
        for off in (found.uncorrected_error_coordinates, found.residual_error_coordinates)
    )
    np.testing.assert_allclose(heights, np.stack([before, after], axis=1), rtol=1e-12, atol=1e-12)
    assert ax.get_xlabel() == "largest magnitude of 4 poses"
    one = ks.compensate(package_robots.robot("3rps").assemble(platform={"z": 0.5, "rx": 0.1, "ry": 0.0}), LOAD)
    values = [bar.get_height() for bar in ks.plot.compensation(one, "correction").patches]
    np.testing.assert_allclose(
        np.array(values) / values[0], np.array(list(one.corrections.values())) / one.corrections["prismatic_1"]
    )
    with pytest.raises(ArgumentError, match="x='z' is for a path"):
        ks.plot.compensation(found, x="z")


def test_a_path_round_a_cone_goes_on_beyond_half_a_turn():
    turn = np.linspace(0, 2 * np.pi, 9)
    cone = {"z": 0.5, "azimuth": turn, "tilt": 0.1}
    found = ks.compensate(package_robots.robot("3rps").assemble(platform=cone, orientation="tilt_torsion"), LOAD)
    ax = ks.plot.compensation(found, "force")
    np.testing.assert_allclose(ax.get_lines()[0].get_xdata(), np.degrees(turn), atol=1e-9)
    assert ax.get_xlabel() == "azimuth [°]" and ax.get_ylim()[0] > 0  # forces that are far from zero fill the figure


def test_what_cannot_be_drawn_of_a_compensation_is_told(path):
    for arguments, options, words in (
        ((1,), {}, "is no compensation"),
        ((path, "sag"), {}, "what is 'sag'; it must be one of 'displacement', 'rotation', 'correction', 'force'"),
        ((path,), {"x": "zz"}, "no coordinate of the wanted platform"),
        ((path,), {"actuators": ["prismatic_1"]}, "actuators is not for the displacement"),
        ((path, "force"), {"actuators": ["prism"]}, "actuators: there is no 'prism'"),
    ):
        with pytest.raises(ArgumentError, match=words):
            ks.plot.compensation(*arguments, **options)


def test_the_commands_write_these_figures(tmp_path, capsys):
    figure = tmp_path / "missed.svg"
    command = ["compensate", "3rps", "--platform", "z=0.5", "rx=0,0.1,0.2", "ry=0", "--load", *map(str, LOAD)]
    assert main([*command, "--plot", str(figure), "--what", "force"]) == 0
    assert "with all loads" in figure.read_text(encoding="utf-8") and f"wrote {figure}" in capsys.readouterr().out
    assert main([*command, "--what", "force"]) == 2 and "give --plot FILE too" in capsys.readouterr().err
    assert main([*command, "--plot", str(tmp_path / "no" / "missed.svg")]) == 2
    assert "--plot: there is no folder" in capsys.readouterr().err
    assert main([*command[:1], "no_such_robot", "--plot", "missed.gif"]) == 2  # before anything that takes long
    assert "figures are written as .pdf, .svg, .png" in capsys.readouterr().err


# ---- optimum ----------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def best(tmp_path_factory):
    pytest.importorskip("scipy")
    robot = parametric_machines.cantilever(tmp_path_factory.mktemp("cantilever"))
    loads = {"load": [0, 0, -500, 0, 0, 0], "gravity": (0, 0, 0)}
    wishes = ["sag < 1.5 mm", "least_translational_stiffness > 1 N/mm", "stress < 10 MPa"]
    return ks.optimize(robot, {"diameter": "20mm,40mm,50mm,60mm"}, subject_to=wishes, **loads)


def test_an_optimum_shows_parameters_between_bounds_and_how_much_of_limits_is_used(best):
    assert best.allowed == {"diameter": (0.02, 0.04, 0.05, 0.06)}
    ax = ks.plot.optimum(best)
    (point,) = [line for line in ax.get_lines() if line.get_marker() == "D"]
    value = best.parameters["diameter"]
    assert point.get_xdata()[0] == pytest.approx(100 * np.log(value / 0.02) / np.log(3))
    assert "place between bounds (logarithmic)" in ax.get_xlabel()
    used = [bar.get_width() for bar in ax.patches]
    for item, width in zip(best.requirements, used, strict=True):
        ratio = item.limit / item.worst if ">" in item.text else item.worst / item.limit
        assert width == pytest.approx(100 * min(ratio, 1.6))
    rows = [text.get_text() for text in ax.get_yticklabels()]
    assert rows[0] == f"diameter\n{1000 * value:.4g} mm" and [row.split("\n")[0] for row in rows[1:]] == [
        item.text for item in best.requirements
    ]  # fmt: skip
    words = [text.get_text() for text in ax.figure.legends[0].get_texts()]
    states = {"broken" if item.margin < -1e-6 else "decides" if item.active else "has a margin" for item in best.requirements}
    assert set(words) == states and ("not feasible" in ax.get_title()) == (not best.feasible)
    with pytest.raises(ArgumentError, match="is no optimum"):
        ks.plot.optimum(3)


def test_the_command_draws_an_optimum(tmp_path, capsys):
    pytest.importorskip("scipy")
    robot, figure = parametric_machines.cantilever(tmp_path), tmp_path / "sized.png"
    command = ["optimize", str(robot), "--load", "0", "0", "-500", "0", "0", "0", "--vary", "diameter=50mm,60mm"]
    assert main([*command, "--subject-to", "sag < 5mm", "--plot", str(figure), "--json"]) in (0, 1)
    assert figure.stat().st_size > 5000 and '"allowed"' in capsys.readouterr().out
