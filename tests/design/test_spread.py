"""Tolerances of parameters, against closed forms, robots made one by one, and first order against robots made at random."""

import itertools
import json
from dataclasses import replace

import numpy as np
import package_robots
import parametric_machines
import pytest

import kinetostatics as ks
from kinetostatics.design.many_robots import NODES, Constants
from kinetostatics.design.spread import longest_sum

LOAD = [0, 0, -300, 0, 20, 0]
F, L, D, E_MODULUS = 300.0, 0.8, 0.04, 2e11


@pytest.fixture(scope="module")
def cantilever(tmp_path_factory):
    return ks.load_robot(parametric_machines.cantilever(tmp_path_factory.mktemp("files"))).assemble()


@pytest.fixture(scope="module")
def legs():
    """A spread of the tripod by tolerances of single parts and of the file."""
    pose = package_robots.robot("3rps").assemble(platform={"z": 0.5, "rx": 0.1, "ry": -0.05})
    off = {"rod_[12].outer_diameter": "0.2mm", "youngs_modulus": "2%", "revolute_1.placement.[xz]": 1e-4}
    return ks.spread(pose, off, load=LOAD, robots=2000, seed=3)


def sag(d=D, e=E_MODULUS):
    """w = F L³/3EI, I = π d⁴/64."""
    return F * L**3 / (3 * e * np.pi * d**4 / 64)


@pytest.mark.smoke
def test_closed_forms_of_the_cantilever(cantilever):
    """The sag is that of d⁻⁴ E⁻¹: 4 % more for each per cent less of the diameter."""
    no_weight = {"load": [0, 0, -F, 0, 0, 0], "gravity": (0, 0, 0)}
    found = ks.spread(cantilever, {"diameter": "0.2mm", "E": "3%"}, **no_weight)
    w, by_d, by_e = sag(), 4 * 0.2e-3 / D, 0.03
    assert found.worst_case.displacement == pytest.approx(w * (by_d + by_e), rel=1e-7)
    assert found.standard_deviation.displacement == pytest.approx(w * np.hypot(by_d, by_e) / 3, rel=1e-7)
    assert found.worst_case.twist[2] == pytest.approx(w * (by_d + by_e), rel=1e-7)
    assert found.effects["diameter"].twist[2] == pytest.approx(w * by_d, rel=1e-7)  # thicker: less far down
    assert found.effects["E"].displacement == pytest.approx(w * by_e, rel=1e-7)
    # along the rod K = E A / L
    axial = E_MODULUS * np.pi * D**2 / 4 / L
    assert found.worst_case.stiffness[0, 0] == pytest.approx(axial * (by_d / 2 + by_e), rel=1e-6)
    assert found.share("diameter") == pytest.approx(by_d**2 / (by_d**2 + by_e**2), rel=1e-6)
    # every robot made at random is the closed form at its own parameters
    assert len(found) == 10_000 and found.at_once and found.difference < 1e-6
    made = sag(found.values["diameter"], found.values["E"])
    np.testing.assert_allclose(found.samples.twist[:, 2], -made, rtol=1e-8)
    np.testing.assert_allclose(found.samples.displacement, np.abs(made - w), atol=1e-8 * w)


def test_seeds_and_distributions(cantilever):
    def errors(seed, distribution):
        found = ks.spread(cantilever, {"rod.youngs_modulus": "10%"}, robots=1000, seed=seed, distribution=distribution)
        return found.values["rod.youngs_modulus"] / E_MODULUS - 1

    normal, uniform = errors(1, "normal"), errors(1, "uniform")
    assert np.array_equal(normal, errors(1, "normal")) and not np.array_equal(normal, errors(2, "normal"))
    assert np.std(normal) == pytest.approx(0.1 / 3, rel=0.1) and np.max(np.abs(normal)) > 0.1
    assert np.std(uniform) == pytest.approx(0.1 / np.sqrt(3), rel=0.1) and np.max(np.abs(uniform)) <= 0.1


def agrees(found):
    """Robots made at random scatter as first order says, within five of the sampling's own standard deviations: σ/√(2N)."""
    error = 5 / np.sqrt(2 * len(found))
    size = np.abs(found.nominal.twist).max()
    # the distribution of a length: of the Gaussian vector whose covariance the effects have
    scaled = [found.parameters[name].standard_deviation / found.parameters[name].tolerance for name in found.parameters]
    vectors = np.random.default_rng(11).normal(size=(40_000, len(scaled))) * scaled @ [e.twist for e in found.effects.values()]
    for name, part in {"displacement": slice(3), "rotation": slice(3, 6)}.items():
        mean, random, low, high = found.sampled(name)
        assert random == pytest.approx(float(found.standard_deviation.named(name)), rel=error), name
        expected = np.linalg.norm(vectors[:, part], axis=1)
        assert mean == pytest.approx(np.mean(expected), rel=error) and high == pytest.approx(
            np.percentile(expected, 97.5), rel=2 * error
        )
        # no length is smaller than one of its components
        for first_order in (found.worst_case, found.standard_deviation):
            assert first_order.named(name) >= np.max(first_order.twist[part]) * (1 - 1e-8)
        assert found.worst_case.named(name) <= np.linalg.norm(found.worst_case.twist[part]) * (1 + 1e-8)
    assert sum(map(found.share, found.parameters)) == pytest.approx(1)
    for name in ("x", "y", "z", "rx", "ry", "rz", *found.nominal.actuator_forces):
        mean, random, low, high = found.sampled(name)
        first = float(found.standard_deviation.named(name))
        if first < 1e-9 * max(size, abs(found.nominal.named(name))):
            continue  # rounding: the force of an actuator on which no parameter acts
        assert random == pytest.approx(first, rel=error), name
        assert abs(mean - found.nominal.named(name)) < 5 * random / np.sqrt(len(found)) + 1e-2 * random, name
        assert high - low == pytest.approx(2 * 1.96 * first, rel=2 * error), name
    diagonal = [found.samples.stiffness[:, k, k].std(ddof=1) for k in range(6)]
    np.testing.assert_allclose(diagonal, np.diagonal(found.standard_deviation.stiffness), rtol=error)
    assert found.at_once and found.difference < 1e-3 and not np.any(np.isnan(found.samples.displacement))


DOWN = [0, 0, -500, 0, 0, 0]
SCATTERED = {
    # from pose, load and tolerances: the symmetric tripod, which sags straight down and scatters to the sides; one in which
    # the file's lengths keep the loops of an overconstrained robot closed; a robot of six equal legs
    "straight": ("3rps", {"z": 0.5, "rx": 0.0, "ry": 0.0}, DOWN, {"rod_*.outer_diameter": "0.1mm"}),
    "overconstrained": ("2pru_upr", {"z": 0.6, "rx": -0.1, "ry": 0.2}, LOAD, {"rod_length": "0.1mm", "platform.mass": "1%"}),
    "hexapod": ("gough_stewart", None, DOWN, {"*.outer_diameter": "0.05mm"}),
}


@pytest.mark.parametrize("case", [pytest.param(name, marks=[pytest.mark.slow] * (k > 0)) for k, name in enumerate(SCATTERED)])
def test_first_order_and_random_robots_agree(case):
    name, platform, load, off = SCATTERED[case]
    found = ks.spread(package_robots.robot(name).assemble(platform=platform), off, robots=1500, load=load)
    agrees(found)


def test_the_longest_sum_of_vectors_with_signs_is_that_of_all_signs():
    rng = np.random.default_rng(4)
    flat = rng.normal(size=(6, 3)) * [1, 1, 0]
    for vectors in (rng.normal(size=(7, 3)), flat, flat * [1, 0, 0], np.eye(3)[:1], np.zeros((4, 3)), np.repeat(flat, 2, axis=0)):
        every = np.array(list(itertools.product((-1, 1), repeat=len(vectors)))) @ vectors
        assert longest_sum(1e-9 * vectors) == pytest.approx(1e-9 * np.linalg.norm(every, axis=1).max(), rel=1e-7)


def test_first_order_and_random_robots_agree_where_parts_are_off_alone(legs):
    agrees(legs)
    assert len(legs.parameters) == 5


def test_random_robots_are_those_of_their_parameters(legs):
    """Robots built by hand from a sample's parameters, placements by turning back to the file's frames."""
    for k in (5, 77):
        robot = package_robots.robot("3rps", youngs_modulus=float(legs.values["youngs_modulus"][k]))
        description = robot.description
        for name, values in legs.values.items():
            link, _, what = name.partition(".")
            if what == "outer_diameter":
                description = description.changed(link, section=ks.sections.Tube.of(float(values[k])))
            elif what.startswith("placement"):
                origin = description.joints[link].origin
                axis = origin.matrix[:3, "xyz".index(what[-1])]
                moved = np.array(origin.xyz) + values[k] * axis
                description = description.changed(link, origin=ks.description.Origin(tuple(moved.tolist()), origin.rpy))
        pose = ks.Robot(description).assemble(platform={"z": 0.5, "rx": 0.1, "ry": -0.05})
        result = ks.analyze(pose, LOAD)
        # to a small part of what the tolerances do
        np.testing.assert_allclose(legs.samples.twist[k], result.twist, atol=1e-3 * legs.standard_deviation.displacement)
        for drive, force in result.actuator_forces.items():
            scatter = float(legs.standard_deviation.actuator_forces[drive])
            assert legs.samples.actuator_forces[drive][k] == pytest.approx(float(force), abs=1e-3 * scatter)
        np.testing.assert_allclose(legs.samples.stiffness[k], result.stiffness, rtol=1e-6, atol=1e-6 * result.stiffness.max())


def test_constants_that_are_products_of_powers_and_sums_are_interpolated():
    """Of 1/(E d⁴) and of a + b with two changes: both come out at other places than the nodes."""

    def made(a, b):
        return np.array([3.0, 1 / ((1 + a) * (1 + b) ** 4), a + b, 0.0 + a])

    nodes = [np.stack([made(0.1 * u, 0) for u in NODES]), np.stack([made(0, 0.1 * u) for u in NODES])]
    constants = Constants(made(0, 0), nodes)
    found = constants.at(np.array([[0.3, -0.8], [-0.7, 0.9]]), range(4))
    assert set(found) == {1, 2, 3}
    for k, (a, b) in enumerate([(0.03, -0.07), (-0.08, 0.09)]):
        np.testing.assert_allclose([found[1][k], found[2][k], found[3][k]], made(a, b)[1:], rtol=1e-6)


def test_rigid_limbs_that_overconstrain_one_another_are_analysed_robot_by_robot():
    """The twist is affine in the platform's mass: a tolerance of it is what so much more weight does, in every robot."""
    description = package_robots.robot("2pru_upr").description.without_beam("rod_1").without_beam("rod_2")
    description, where = replace(description, joint_stiffness={}), {"z": 0.55, "rx": 0.1, "ry": 0.05}
    pose = ks.Robot(description).assemble(platform=where)
    found = ks.spread(pose, {"platform.mass": "10%"}, robots=4)
    mass = description.links["platform"].mass
    heavy = ks.analyze(ks.Robot(description.changed("platform", mass=1.1 * mass)).assemble(platform=where))
    more = heavy.twist - found.result.twist
    np.testing.assert_allclose(found.worst_case.twist, np.abs(more), atol=1e-7 * np.abs(more).max())
    wanted = found.result.twist + np.outer((found.values["platform.mass"] / mass - 1) / 0.1, more)
    np.testing.assert_allclose(found.samples.twist, wanted, atol=1e-9 * np.abs(more).max())
    assert not found.at_once and np.abs(more).max() > 1e-9


def test_a_payload_is_analysed_robot_by_robot(cantilever):
    """m g L³/3EI of a payload; first order by differences then."""
    tool = ks.Payload(10.0)
    found = ks.spread(cantilever, {"E": "1%"}, payload=tool, robots=12, gravity=(0, 0, -9.81))
    assert not found.at_once and np.isnan(found.difference) and len(found) == 12
    whole = found.nominal.displacement
    assert found.worst_case.displacement == pytest.approx(0.01 * whole, rel=1e-5)
    np.testing.assert_allclose(found.samples.twist[:, 2] * found.values["E"], -whole * E_MODULUS, rtol=1e-9)
    assert "made by itself" in str(found)


def test_robots_that_cannot_be_made_do_not_count():
    """A modulus below zero makes no robot: its numbers are missing, and are no zeros."""
    pose = package_robots.robot("3rps").assemble(platform={"z": 0.5, "rx": 0.0, "ry": 0.0})
    found = ks.spread(pose, {"rod_1.youngs_modulus": "600%"}, robots=8, payload=ks.Payload(1.0), load=LOAD)
    none = found.values["rod_1.youngs_modulus"] <= 0
    assert 0 < none.sum() < 8
    for name in ("displacement", "rz", "prismatic_2"):
        np.testing.assert_array_equal(np.isnan(found.samples.named(name)), none)
    assert f"{none.sum()} robots made at random have no such pose and do not count" in " ".join(str(found).split())


def test_robots_whose_loops_do_not_close_do_not_count():
    """Near the edge of its workspace an arm of a five-bar may be too short: l1 + l2 < distance, in a plane."""
    pose = package_robots.robot("five_bar").assemble(platform={"x": 0.0, "y": 0.435})
    found = ks.spread(pose, {"distal_length": "10mm"}, robots=15, seed=4, load=[1, 0, 0, 0, 0, 0])
    short = 0.23 + found.values["distal_length"] < np.hypot(0.275 / 2, 0.435)
    assert found.at_once and 0 < short.sum() < 8
    np.testing.assert_array_equal(np.isnan(found.samples.displacement), short)


def test_the_tip_of_a_tool(cantilever):
    """w = F/3E (L³ + 3 a L² + 3 a² L)/I of a force at a tip that is a beyond the rod; as one batch, and robot by robot."""
    a, off, tool = 0.2, {"diameter": "0.1mm"}, (0.2, 0, 0)
    w = sag() * ((L + a) ** 3 - a**3) / L**3
    load = {"load": [0, 0, -F, 0, a * F, 0], "gravity": (0, 0, 0)}
    found = ks.spread(cantilever, off, robots=50, tool=tool, **load)
    assert found.nominal.displacement == pytest.approx(w, rel=1e-9) and found.at_once
    assert found.worst_case.displacement == pytest.approx(4 * w * 1e-4 / D, rel=1e-7)
    np.testing.assert_allclose(found.samples.twist[:, 2], -w * (found.values["diameter"] / D) ** -4, rtol=1e-8)
    single = ks.spread(cantilever, off, robots=3, tool=tool, payload=ks.Payload(1e-9), **load)
    assert not single.at_once and single.worst_case.displacement == pytest.approx(4 * w * 1e-4 / D, rel=1e-5)
    np.testing.assert_allclose(single.samples.twist[:, 2], -w * (single.values["diameter"] / D) ** -4, rtol=1e-8)
    np.testing.assert_allclose(single.samples.stiffness[0], found.nominal.stiffness, rtol=0.02, atol=1)
    assert "the tool's tip moves by" in str(found) and "the tool's tip moves" in repr(found)
    assert found.to_dict()["tool"] == [0.2, 0, 0] and "displacement of the tool's tip" in str(found)


@pytest.mark.further
def test_the_tip_of_a_tool_turns_with_each_platform():
    """With the actuators held every robot leans in another way: those of the batch are those made one by one."""
    pose = package_robots.robot("3rps").assemble(actuators={"prismatic_1": 0.05, "prismatic_2": -0.05, "prismatic_3": 0.0})
    found = ks.spread(pose, {"revolute_1.placement.z": "5mm"}, robots=5, load=LOAD, tool=(0.3, 0.2, -0.1))
    assert found.at_once and found.difference < 1e-4  # to a part of the standard deviation


def test_tables_and_json(legs):
    text = str(legs)
    rows = {line.split()[0]: line for line in text.splitlines() if line.startswith("  ")}
    assert "0.0002 m" in rows["rod_1.outer_diameter"] and "4e+09 Pa" in rows["youngs_modulus"]
    assert "2,000 robots" in text and "a third of" in text and "prismatic_1" in rows
    assert "robots" in repr(legs) and "rotation" in legs._repr_html_()
    shares = [legs.share(name) for name in legs.parameters]
    assert sum(shares) == pytest.approx(1)
    read = json.loads(json.dumps(legs.to_dict()))
    assert read["random"]["displacement"][1] == pytest.approx(legs.sampled("displacement")[1])
    assert read["parameters"]["rod_2.outer_diameter"]["unit"] == "m" and read["seed"] == 3
    with pytest.raises(ks.ArgumentError, match="no quantity 'sag'"):
        legs.sampled("sag")


def test_histogram(legs):
    pytest.importorskip("matplotlib").use("Agg")
    ax = ks.plot.spread(legs, "prismatic_2")
    assert ax.get_xlabel() == "force of prismatic_2 [N]" and sum(bar.get_height() for bar in ax.patches[:60]) == 2000
    # bars, and the outline of the same robots to first order
    bars, outline = ax.patches[:60], ax.patches[60]
    np.testing.assert_allclose(sorted(y for _, y in outline.get_xy()[1:-1:2]), sorted(bar.get_height() for bar in bars), atol=40)
    assert len(ax.lines) == 2
    ax = ks.plot.spread(legs)
    assert ax.get_xlabel() == "distance of o from the nominal robot [nm]" and len(ax.lines) == 1
    with pytest.raises(ks.ArgumentError, match="is no spread"):
        ks.plot.spread(1)


def test_mistakes(cantilever):
    mistakes = {
        "nothing in it": {},
        "did you mean 'diameter'": {"diametre": "1mm"},
        "given in kg, but it is in m": {"diameter": "1kg"},
        "must be a positive number": {"diameter": -1.0},
        "nothing: give it with a unit": {"tip.center_of_mass.x": "1%"},
        "E cannot be off by so much: .*youngs_modulus": {"E": "400%"},
        "named twice": {"rod.*": "1%", "rod.outer_diameter": "1mm"},
        "is not a number": {"diameter": "thick"},
        "given in mm, but it has no unit": {"rod.poisson_ratio": "1mm"},
    }
    for message, off in mistakes.items():
        with pytest.raises(ks.ArgumentError, match=message):
            ks.spread(cantilever, off)
    with pytest.raises(ks.ArgumentError, match="robots is 1; it must be a whole number from 2 on"):
        ks.spread(cantilever, {"E": "1%"}, robots=1)
    with pytest.raises(ks.ArgumentError, match="single pose"):
        ks.spread(package_robots.robot("3rps").assemble(platform={"z": [0.5, 0.6], "rx": 0.0, "ry": 0.0}), {"rod_diameter": 1e-4})
    pose = package_robots.robot("2pru_upr").assemble()
    with pytest.raises(ks.ArgumentError, match="of an overconstrained robot, tolerances tells"):
        ks.spread(pose, {"revolute_1.placement.x": "0.1mm"})
