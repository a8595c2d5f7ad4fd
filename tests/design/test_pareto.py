"""Pareto fronts against closed forms and all combinations of lists."""

import json
from dataclasses import replace

import numpy as np
import parametric_machines
import pytest

import kinetostatics as ks
from kinetostatics.design.pareto import _limits, _undominated
from kinetostatics.design.problem import Problem

E, RHO, L, F = parametric_machines.E, parametric_machines.RHO, 0.8, 500.0
LOADED = {"load": [0, 0, -F, 0, 0, 0], "gravity": (0, 0, 0)}


@pytest.fixture(scope="module")
def cantilever(tmp_path_factory):
    return parametric_machines.cantilever(tmp_path_factory.mktemp("files"))


@pytest.fixture(scope="module")
def front(cantilever):
    return ks.pareto(cantilever, {"diameter": "20mm:120mm"}, ("mass", "sag"), points=3, starts=1, **LOADED)


def mass(sag):
    """m = ρ π d² L / 4 + m_tip, with d⁴ = 64 F L³ / (3 π E w)."""
    return RHO * L * np.pi / 4 * np.sqrt(64 * F * L**3 / (3 * np.pi * E * sag)) + 5


def test_front_of_the_cantilever_has_closed_form(front):
    masses, sags = front.objectives.T
    np.testing.assert_allclose(masses, mass(sags), rtol=1e-6)
    diameters = front.parameters["diameter"]
    assert diameters[0] == pytest.approx(0.02, rel=1e-6) and diameters[-1] == pytest.approx(0.12, rel=1e-6)
    # limits of the sag are spaced by ratios, and so are diameters: w goes as d⁻⁴
    np.testing.assert_allclose(diameters[1:] / diameters[:-1], 6**0.5, rtol=1e-6)
    assert len(front) == 3 and all(point.feasible for point in front)
    assert front[1].requirements[-1].worst == pytest.approx(sags[1]) and front.units == ("kg", "m")


@pytest.mark.few(1)
@pytest.mark.parametrize("vary", [{"diameter": "40mm:60mm"}, {"diameter": "40mm,50mm,60mm"}])
def test_all_analysed_robots_are_counted(cantilever, monkeypatch, vary):
    calls, own = [], Problem._evaluate
    monkeypatch.setattr(Problem, "_evaluate", lambda self, values: (calls.append(values), own(self, values))[1])
    assert ks.pareto(cantilever, vary, points=3, starts=1).evaluations == len(calls)


@pytest.mark.slow
def test_other_requirements_hold_on_the_front(cantilever):
    """A stress of 32 F L / (π d³) < 100 MPa keeps the thin rods out."""
    thin = (32 * F * L / (np.pi * 100e6)) ** (1 / 3)
    front = ks.pareto(cantilever, {"diameter": "20mm:60mm"}, ("mass", "sag"), ["stress < 100 MPa"], points=2, starts=1, **LOADED)
    # a load at the tip's end bends the clamped section most; shear is next to nothing there
    assert front.parameters["diameter"] == pytest.approx([thin, 0.06], rel=1e-3)
    assert front[0].active[0].text == "stress < 100 MPa"
    with pytest.raises(ks.StaticsError, match="meet all requirements"):
        ks.pareto(cantilever, {"diameter": "20mm:22mm"}, subject_to=["stress < 1 MPa"], starts=1, **LOADED)


@pytest.mark.slow
def test_parameters_without_effect_on_sag_minimize_mass(cantilever):
    """Without gravity the tip's mass has no effect on the sag: it is at its lower bound on the whole front."""
    front = ks.pareto(cantilever, {"diameter": "20mm:120mm", "tip_mass": (2.0, 8.0)}, points=2, starts=1, **LOADED)
    np.testing.assert_allclose(front.objectives[:, 0], mass(front.objectives[:, 1]) - 3, rtol=1e-6)
    np.testing.assert_allclose(front.parameters["tip_mass"], 2, rtol=1e-6)


def test_all_combinations_of_lists_are_tried(cantilever):
    front = ks.pareto(cantilever, {"diameter": "30mm,20mm,50mm", "E": "70GPa,200GPa"}, **LOADED)
    assert front.parameters["diameter"].tolist() == [0.02, 0.03, 0.05] and set(front.parameters["E"]) == {2e11}
    np.testing.assert_allclose(front.objectives[:, 0], mass(front.objectives[:, 1]), rtol=1e-9)
    with pytest.raises(ks.StaticsError, match="none of the listed values"):
        ks.pareto(cantilever, {"diameter": "20mm,30mm"}, subject_to=["sag < 1um"], **LOADED)


def test_table_json_csv_and_figure_show_the_front(front, tmp_path):
    text = str(front)
    assert "diameter at its lower bound" in text and "120" in text and "3 designs" in repr(front)
    assert "sag" in front._repr_html_()
    read = json.loads(json.dumps(front.to_dict()))
    assert read["minimized"] == ["mass", "sag"] and len(read["points"]) == 3
    front.save(tmp_path / "front.csv")
    lines = (tmp_path / "front.csv").read_text(encoding="utf-8").splitlines()
    assert lines[0] == "mass [kg],sag [m],diameter [m]"
    np.testing.assert_array_equal(np.array([line.split(",") for line in lines[1:]], float)[:, :2], front.objectives)
    import matplotlib

    matplotlib.use("Agg")
    ax = ks.plot.pareto(front)
    assert ax.get_xlabel() == "mass [kg]" and ax.get_ylabel().startswith("displacement [") and ax.get_yscale() == "log"
    np.testing.assert_allclose(ax.lines[0].get_xdata(), front.objectives[:, 0])
    with pytest.raises(ks.ArgumentError, match="pareto needs the result of"):
        ks.plot.pareto(1)


def test_invalid_arguments_are_refused(cantilever):
    for given, message in [
        ({"minimize": "mass"}, "a front has two quantities"),
        ({"minimize": ("mass", "mass")}, "two different quantities"),
        ({"points": 1}, "points is 1; it must be a whole number from 2 to"),
        ({"minimize": ("mass", "least_translational_stiffness")}, "is not to be minimized"),
    ]:
        with pytest.raises(ks.ArgumentError, match=message):
            ks.pareto(cantilever, {"diameter": "20mm:30mm"}, **given)


def test_parameter_named_like_an_objective_has_its_own_column(front, tmp_path):
    points = tuple(replace(point, parameters={"mass": 1.0}, units={"mass": "kg"}) for point in front)
    replace(front, points=points).save(tmp_path / "front.csv")
    assert (tmp_path / "front.csv").read_text().splitlines()[0] == "mass [kg],sag [m],parameter mass [kg]"


@pytest.mark.parametrize(("name", "span", "best", "lighter"), [("tip_mass", "4:6", 4.0, 1.0), ("tip_mass", "5:6", 5.0, 0.0)])
def test_front_of_two_parameters_ends_at_the_lightest_of_the_stiffest(cantilever, name, span, best, lighter):
    """A heavier tip does not change the sag under a load alone: every point has the lightest one, the stiffest point, too,
    whether the search for the least sag began with the lightest one or not."""
    front = ks.pareto(cantilever, {"diameter": "20mm:120mm", name: span}, ("mass", "sag"), points=3, starts=1, **LOADED)
    assert front.parameters[name] == pytest.approx([best] * 3, rel=1e-6)
    assert front.parameters["diameter"] == pytest.approx(0.02 * 6 ** np.array([0, 0.5, 1]), rel=1e-5)
    np.testing.assert_allclose(front.objectives[:, 0], mass(front.objectives[:, 1]) - lighter, rtol=1e-6)


def test_designs_that_another_one_dominates_but_for_rounding_are_left_out():
    """Second quantities that differ by 1e-7 or less count as equal."""
    both = np.array(
        [[3.0, 1.0], [1.0, 2.0], [1.5, 2.0], [2.0, 2.0 * (1 - 3e-8)], [2.5, 2.0 * (1 - 1e-5)], [1.0, 2.5], [4.0, 1.5]]
    )
    assert _undominated(both) == [1, 4, 0]
    assert _undominated(np.ones((3, 2))) == [0] and _undominated(np.zeros((0, 2))) == []


def test_limits_of_a_front_lie_between_its_ends():
    """Spaced geometrically; two equal ones, if the ends are equal or no ratio exists."""
    assert _limits(8.0, 1.0, 4) == pytest.approx([8, 4, 2, 1], rel=2e-8) and np.all(_limits(8.0, 1.0, 4) > [8, 4, 2, 1])
    for most, least, both in ((1.0, 2.0, 2.0), (2.0, 2.0, 2.0), (2.0, 0.0, 2.0), (3.0, -1.0, 3.0)):
        assert _limits(most, least, 4) == pytest.approx([both, both], rel=2e-7) and np.all(_limits(most, least, 4) > both)
