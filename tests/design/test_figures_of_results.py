"""Figures of the Dataset of a compensation."""

import matplotlib
import numpy as np
import package_robots
import pytest

import kinetostatics as ks
from kinetostatics.cli.main import main

matplotlib.use("Agg")

pytestmark = pytest.mark.usefixtures("no_figures_left")

LOAD = [0, 100, -500, 0, 0, 0]
TURN = np.linspace(0, 2 * np.pi, 9)


def test_errors_and_corrections_along_a_path_are_plotted():
    cone = {"z": 0.5, "azimuth": TURN, "tilt": 0.1}
    found = ks.compensate(package_robots.robot("3rps").assemble(platform=cone, orientation="tilt_torsion"), LOAD)
    for what, values, ylabel in (
        ("uncorrected_error:x", 1e9 * found.uncorrected_error[:, 0], "displacement along x, uncorrected [nm]"),
        ("residual_error:rx", 1e9 * found.residual_error[:, 3], "residual rotation about x [nrad]"),
        ("actuator_correction:prismatic_2", 1e9 * found.corrections["prismatic_2"], "correction of prismatic_2 [nm]"),
        ("actuator_force:prismatic_1", found.actuator_forces["prismatic_1"], "force of prismatic_1 [N]"),
    ):
        ax = ks.plot.line(found.to_dataset({"azimuth": TURN}), what)
        (line,) = ax.get_lines()
        np.testing.assert_allclose(line.get_xdata(), np.degrees(TURN), atol=1e-9)
        np.testing.assert_allclose(line.get_ydata(), values, rtol=1e-12, atol=1e-9)
        assert (ax.get_xlabel(), ax.get_ylabel()) == ("azimuth [°]", ylabel)


def test_plot_command_draws_files_of_the_compensate_command(tmp_path, capsys):
    table, figure = tmp_path / "path.nc", tmp_path / "missed.svg"
    command = ["compensate", "3rps", "--platform", "z=0.5", "rx=0,0.1,0.2", "ry=0", "--load", *map(str, LOAD)]
    assert main([*command, "--out", str(table)]) == 0
    assert (
        main(["plot", str(table), "--kind", "line", "--what", "residual_error:x", "uncorrected_error:x", "--out", str(figure)])
        == 0
    )
    assert f"wrote {figure}" in capsys.readouterr().out and figure.stat().st_size > 5000
