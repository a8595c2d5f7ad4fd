"""Tolerances: closed forms, robots built and analysed one by one, first order against random samples; assembly errors too."""

import itertools
import json
import re
from dataclasses import replace

import check_texts
import numpy as np
import package_robots
import parametric_machines
import pytest
from simple_machines import bar, joint, link, loop, mount, robot, springs, two_columns

import kinetostatics as ks
from kinetostatics.design.monte_carlo import NODES, Constants
from kinetostatics.design.tolerances import _ordered, longest_sum
from kinetostatics.results.tolerances import Effect

LOAD = [0, 0, -300, 0, 20, 0]
F, L, D, E_MODULUS = 300.0, 0.8, 0.04, 2e11
STILL, COMPONENTS = (0, 0, 0), ("x", "y", "z", "rx", "ry", "rz")


@pytest.fixture(scope="module")
def cantilever(tmp_path_factory):
    return ks.load_robot(parametric_machines.cantilever(tmp_path_factory.mktemp("files"))).assemble()


@pytest.fixture(scope="module")
def legs():
    """Of the tripod by tolerances of single parts, of the file and of its assembly."""
    pose = package_robots.robot("3rps").assemble(platform={"z": 0.5, "rx": 0.1, "ry": -0.05})
    off = {"rod_[12].outer_diameter": "0.2mm", "youngs_modulus": "2%", "revolute_1.placement.[xz]": 1e-4}
    return ks.tolerances(pose, off, load=LOAD, samples=500, seed=3)


def sag(d=D, e=E_MODULUS):
    """w = F L³/3EI, I = π d⁴/64."""
    return F * L**3 / (3 * e * np.pi * d**4 / 64)


def test_cantilever_tolerances_have_closed_form(cantilever):
    """The sag goes as d⁻⁴ E⁻¹: 4 % more for each per cent less of the diameter."""
    no_weight = {"load": [0, 0, -F, 0, 0, 0], "gravity": STILL}
    found = ks.tolerances(cantilever, {"diameter": "0.2mm", "E": "3%"}, **no_weight)
    w, by_d, by_e = sag(), 4 * 0.2e-3 / D, 0.03
    assert found.worst_case.displacement == pytest.approx(w * (by_d + by_e), rel=1e-7)
    assert found.standard_deviation.displacement == pytest.approx(w * np.hypot(by_d, by_e) / 3, rel=1e-7)
    assert found.worst_case.twist[2] == pytest.approx(w * (by_d + by_e), rel=1e-7)
    assert found.effects["diameter"].twist[2] == pytest.approx(w * by_d, rel=1e-7)  # thicker: less far down
    assert found.effects["E"].displacement == pytest.approx(w * by_e, rel=1e-7)
    assert list(found.effects) == ["E", "diameter"] and found.ranked_by == "displacement"
    # along the rod K = E A / L
    axial = E_MODULUS * np.pi * D**2 / 4 / L
    assert found.worst_case.stiffness[0, 0] == pytest.approx(axial * (by_d / 2 + by_e), rel=1e-6)
    assert found.share("diameter") == pytest.approx(by_d**2 / (by_d**2 + by_e**2), rel=1e-6)
    # every sample is the closed form at its own parameters
    assert len(found.values["E"]) == 10_000 and found.at_once and found.difference < 1e-6
    made = sag(found.values["diameter"], found.values["E"])
    np.testing.assert_allclose(found.samples.twist[:, 2], -made, rtol=1e-8)
    np.testing.assert_allclose(found.samples.displacement, np.abs(made - w), atol=1e-8 * w)


def test_samples_follow_seed_and_distribution(cantilever):
    def errors(seed, distribution):
        found = ks.tolerances(cantilever, {"rod.youngs_modulus": "10%"}, samples=1000, seed=seed, distribution=distribution)
        return found.values["rod.youngs_modulus"] / E_MODULUS - 1

    normal, uniform = errors(1, "normal"), errors(1, "uniform")
    assert np.array_equal(normal, errors(1, "normal")) and not np.array_equal(normal, errors(2, "normal"))
    assert np.std(normal) == pytest.approx(0.1 / 3, rel=0.1) and np.max(np.abs(normal)) > 0.1
    assert np.std(uniform) == pytest.approx(0.1 / np.sqrt(3), rel=0.1) and np.max(np.abs(uniform)) <= 0.1


def agrees(found):
    """Samples scatter as first order says, within five of the sampling's own standard deviations: σ/√(2N)."""
    count = len(found.samples.displacement)
    error = 5 / np.sqrt(2 * count)
    size = np.abs(found.nominal.twist).max()
    # the distribution of a length: of the Gaussian vector whose covariance the effects have
    vectors = np.random.default_rng(11).normal(size=(40_000, len(found.effects))) / 3
    vectors = vectors @ [effect.twist for effect in found.effects.values()]
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
    for name in (*COMPONENTS, *found.nominal.actuator_forces):
        mean, random, low, high = found.sampled(name)
        first = float(found.standard_deviation.named(name))
        if first < 1e-9 * max(size, abs(found.nominal.named(name))):
            continue  # rounding: the force of an actuator on which no parameter acts
        assert random == pytest.approx(first, rel=error), name
        assert abs(mean - found.nominal.named(name)) < 5 * random / np.sqrt(count) + 1e-2 * random, name
        assert high - low == pytest.approx(2 * 1.96 * first, rel=2 * error), name
    diagonal = [found.samples.stiffness[:, k, k].std(ddof=1) for k in range(6)]
    scale = 1e-9 * np.abs(found.nominal.stiffness).max()
    np.testing.assert_allclose(diagonal, np.diagonal(found.standard_deviation.stiffness), rtol=error, atol=scale)
    assert found.at_once and not found.difference > 1e-3 and not np.any(np.isnan(found.samples.displacement))


DOWN = [0, 0, -500, 0, 0, 0]
SCATTERED = {
    # from pose, load and tolerances: the symmetric tripod, which sags straight down and scatters to the sides; one in which
    # the file's lengths keep the loops of an overconstrained robot closed, and joints that do not fit stress it; a robot of six
    # equal legs; all errors of assembly
    "straight": ("3rps", {"z": 0.5, "rx": 0.0, "ry": 0.0}, DOWN, {"rod_*.outer_diameter": "0.1mm"}),
    "overconstrained": (
        "2pru_upr",
        {"z": 0.6, "rx": -0.1, "ry": 0.2},
        LOAD,
        {"rod_length": "1mm", "platform.mass": "10%", "revolute_*.error.*": 1e-7},
    ),
    "hexapod": ("gough_stewart", None, DOWN, {"*.outer_diameter": "0.05mm"}),
    "assembly": ("2pru_upr", {"z": 0.6, "rx": -0.1, "ry": 0.2}, LOAD, None),
}


@pytest.mark.parametrize(
    "case", [pytest.param(name, marks=[pytest.mark.slow] * (name in ("hexapod", "straight"))) for name in SCATTERED]
)
def test_first_order_and_random_samples_agree(case):
    name, platform, load, off = SCATTERED[case]
    agrees(ks.tolerances(package_robots.robot(name).assemble(platform=platform), off, samples=500, load=load))


def test_longest_signed_sum_equals_brute_force():
    rng = np.random.default_rng(4)
    flat = rng.normal(size=(6, 3)) * [1, 1, 0]
    for vectors in (rng.normal(size=(7, 3)), flat, flat * [1, 0, 0], np.eye(3)[:1], np.zeros((4, 3)), np.repeat(flat, 2, axis=0)):
        every = np.array(list(itertools.product((-1, 1), repeat=len(vectors)))) @ vectors
        assert longest_sum(1e-9 * vectors) == pytest.approx(1e-9 * np.linalg.norm(every, axis=1).max(), rel=1e-7)


def test_samples_equal_robots_built_from_their_parameters(legs):
    """Robots built by hand from a sample's parameters, placements by turning back to the file's frames."""
    agrees(legs)
    assert len(legs.parameters) == 5
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


def test_samples_with_sizes_and_assembly_errors_equal_single_analyses():
    """A robot with the sample's modulus and errors in one analysis; with a payload, samples are analysed one by one."""
    where = {"z": 0.6, "rx": -0.1, "ry": 0.2}
    off = {"rod_1.youngs_modulus": "5%", "revolute_1.error.ry": "0.01mrad", "rod_2.error.length": "1um"}
    robot = package_robots.robot("2pru_upr")
    for tool, payload in (((0.05, 0, 0.2), None), (None, ks.Payload(3.0))):
        options = {"load": LOAD, "payload": payload}
        found = ks.tolerances(robot.assemble(platform=where), off, samples=2, tool=tool, **options)
        assert found.at_once == (payload is None) and found.ranked_by == "force"
        for k in range(2):
            value = {name: float(row[k]) for name, row in found.values.items()}
            one = ks.Robot(robot.description.changed("rod_1", youngs_modulus=value["rod_1.youngs_modulus"]))
            pose = one.assemble(platform=where)
            misfits = {
                "revolute_1": {"twist": [0, 0, 0, 0, value["revolute_1.error.ry"], 0], "frame": "joint"},
                "rod_2": {"length": value["rod_2.error.length"]},
            }
            result = ks.analyze(pose, assembly_errors=misfits, **options)
            twist = result.twist if tool is None else result.at_point(tool).twist
            tenth = 2e-2 * found.standard_deviation.displacement  # the modulus changes what errors do by 5 %
            np.testing.assert_allclose(found.samples.twist[k], twist, atol=tenth if found.at_once else 1e-15)
            forces = [row[k] for row in found.samples.actuator_forces.values()]
            np.testing.assert_allclose(forces, list(result.actuator_forces.values()), rtol=1e-3, atol=1e-6)


def test_constants_as_products_or_sums_are_interpolated_accurately():
    """1/(E d⁴) and a + b with two changes, at other values than the nodes."""

    def made(a, b):
        return np.array([3.0, 1 / ((1 + a) * (1 + b) ** 4), a + b, 0.0 + a])

    nodes = [np.stack([made(0.1 * u, 0) for u in NODES]), np.stack([made(0, 0.1 * u) for u in NODES])]
    constants = Constants(made(0, 0), nodes)
    found = constants.at(np.array([[0.3, -0.8], [-0.7, 0.9]]), range(4))
    assert found[0] == 3.0
    for k, (a, b) in enumerate([(0.03, -0.07), (-0.08, 0.09)]):
        np.testing.assert_allclose([found[1][k], found[2][k], found[3][k]], made(a, b)[1:], rtol=1e-6)


@pytest.mark.parametrize(
    ("factor", "product"), [(4.9, True), (5.1, False), (5.9, False), (0.21, True), (0.19, False), (0.0, False), (-2.0, False)]
)
def test_constants_count_as_products_up_to_a_factor_of_five(factor, product):
    """Products are exact for powers of the factor; sums for polynomials through the nodes, which may change sign."""
    law = (lambda u: factor**u) if product else (lambda u: 1 + (factor - 1) * u**2)
    nodes, parts = np.array([[law(u)] for u in NODES]), np.array([[0.3, -0.8]])
    [found] = Constants(np.array([1.0]), [nodes]).at(parts, [0])
    np.testing.assert_allclose(found, law(parts[0]), rtol=1e-12)


def test_overconstrained_rigid_limbs_are_sampled_robot_by_robot():
    """The twist is affine in the platform's mass, and so are its tolerance and every sample."""
    description = package_robots.robot("2pru_upr").description.without_beam("rod_1").without_beam("rod_2")
    description, where = replace(description, joint_stiffness={}), {"z": 0.55, "rx": 0.1, "ry": 0.05}
    pose = ks.Robot(description).assemble(platform=where)
    found = ks.tolerances(pose, {"platform.mass": "10%"}, samples=2)
    mass = description.links["platform"].mass
    heavy = ks.analyze(ks.Robot(description.changed("platform", mass=1.1 * mass)).assemble(platform=where))
    more = heavy.twist - found.result.twist
    np.testing.assert_allclose(found.worst_case.twist, np.abs(more), atol=1e-7 * np.abs(more).max())
    wanted = found.result.twist + np.outer((found.values["platform.mass"] / mass - 1) / 0.1, more)
    np.testing.assert_allclose(found.samples.twist, wanted, atol=1e-9 * np.abs(more).max())
    assert not found.at_once and np.abs(more).max() > 1e-9


def test_impossible_samples_are_not_counted():
    """With a modulus below zero all values of a sample are NaN, not zero."""
    pose = package_robots.robot("3rps").assemble(platform={"z": 0.5, "rx": 0.0, "ry": 0.0})
    found = ks.tolerances(pose, {"rod_1.youngs_modulus": "600%"}, samples=5, payload=ks.Payload(1.0), load=LOAD)
    none = found.values["rod_1.youngs_modulus"] <= 0
    assert 0 < none.sum() < 5
    for name in ("displacement", "rz", "prismatic_2"):
        np.testing.assert_array_equal(np.isnan(found.samples.named(name)), none)
    assert f"{none.sum()} samples cannot reach this pose and do not count" in " ".join(str(found).split())


def test_samples_with_open_loops_are_not_counted():
    """Near the edge of its workspace an arm of a five-bar may be too short: l1 + l2 < distance, in a plane."""
    pose = package_robots.robot("five_bar").assemble(platform={"x": 0.0, "y": 0.435})
    found = ks.tolerances(pose, {"distal_length": "10mm"}, samples=6, seed=4, load=[1, 0, 0, 0, 0, 0])
    short = 0.23 + found.values["distal_length"] < np.hypot(0.275 / 2, 0.435)
    assert found.at_once and 0 < short.sum() < 6
    np.testing.assert_array_equal(np.isnan(found.samples.displacement), short)


def test_tool_tip_tolerances_have_closed_form(cantilever):
    """w = F/3E (L³ + 3 a L² + 3 a² L)/I of a force at a tip that is a beyond the rod; as one batch, and robot by robot."""
    a, off, tool = 0.2, {"diameter": "0.1mm"}, (0.2, 0, 0)
    w = sag() * ((L + a) ** 3 - a**3) / L**3
    load = {"load": [0, 0, -F, 0, a * F, 0], "gravity": STILL}
    found = ks.tolerances(cantilever, off, samples=50, tool=tool, **load)
    assert found.nominal.displacement == pytest.approx(w, rel=1e-9) and found.at_once
    assert found.worst_case.displacement == pytest.approx(4 * w * 1e-4 / D, rel=1e-7)
    np.testing.assert_allclose(found.samples.twist[:, 2], -w * (found.values["diameter"] / D) ** -4, rtol=1e-8)
    single = ks.tolerances(cantilever, off, samples=3, tool=tool, payload=ks.Payload(1e-9), **load)
    assert not single.at_once and single.worst_case.displacement == pytest.approx(4 * w * 1e-4 / D, rel=1e-5)
    np.testing.assert_allclose(single.samples.twist[:, 2], -w * (single.values["diameter"] / D) ** -4, rtol=1e-8)
    np.testing.assert_allclose(single.samples.stiffness[0], found.nominal.stiffness, rtol=0.02, atol=1)
    assert "the tool's tip moves by" in str(found) and found.to_dict()["tool"] == [0.2, 0, 0]


# ---- assembly errors -------------------------------------------------------------------------------------------------------


def alone(pose, found, name, **options):
    """Return the analysis of the robot without load in which one error is off by its tolerance."""
    part, _, kind = name.split(".")
    amount = found.parameters[name].tolerance
    given = (
        {"twist": [amount * (kind == item) for item in COMPONENTS], "frame": "joint"} if kind in COMPONENTS else {kind: amount}
    )
    return ks.analyze(pose, gravity=STILL, assembly_errors={part: given}, **options)


def test_effects_of_assembly_errors_equal_single_analyses():
    """A column between two clamps bends; force and moment are those of the joints that have the largest."""
    pose = two_columns().assemble()
    amounts = {"*.error.[xyz]": 2e-4, "*.error.length": 2e-4, "*.error.r?": 1e-3, "*.error.temperature": "30K"}
    found = ks.tolerances(pose, amounts, rank_by="displacement", load=DOWN)
    assert len(found.effects) == 4 * 6 + 2 * 2 and found.ranked_by == "displacement"
    sizes = [effect.displacement for effect in found.effects.values()]
    assert sizes == pytest.approx(sorted(sizes, reverse=True), rel=1e-6)  # equals stand in the file's order
    for name, effect in found.effects.items():
        one = alone(pose, found, name)
        np.testing.assert_allclose(effect.twist, one.twist, rtol=1e-9, atol=1e-15)
        forces, moments = (
            {joint: np.linalg.norm(wrench[part]) for joint, wrench in one.joint_wrenches.items()}
            for part in (slice(3), slice(3, 6))
        )
        assert effect.force == pytest.approx(max(forces.values()), rel=1e-6, abs=1e-4)
        assert effect.force == pytest.approx(forces[effect.at] if effect.at else 0.0, rel=1e-6, abs=1e-4)
        assert effect.moment == pytest.approx(max(moments.values()), rel=1e-6, abs=1e-4)
        assert effect.rotation == pytest.approx(np.linalg.norm(one.twist[3:]), rel=1e-9, abs=1e-15)
    usual = ks.tolerances(pose)
    text = str(usual)
    assert "ranked by force" in text and "foot_a.error.rx" in text and "temperature" in text
    told = {(item.unit, item.tolerance) for item in usual.parameters.values()}
    assert told == {("m", 1e-4), ("rad", 1e-3), ("K", 1.0)}


@pytest.mark.parametrize("part", [1e-2, 1e-5])
def test_small_errors_have_effects_in_proportion(part):
    """Of two equal columns, the foot of one is off by a small part of the other's error: so are force, moment and twist."""
    found = ks.tolerances(two_columns().assemble(), {"foot_a.error.z": 1e-3, "foot_b.error.z": part * 1e-3}, gravity=STILL)
    large, small = found.effects["foot_a.error.z"], found.effects["foot_b.error.z"]
    assert large.force > 1 and small.force == pytest.approx(part * large.force, rel=1e-6)
    assert small.moment == pytest.approx(part * large.moment, rel=1e-6)
    np.testing.assert_allclose(small.twist[[2, 4]], part * large.twist[[2, 4]] * [1, -1], rtol=1e-6)


@pytest.mark.parametrize(("less", "alike"), [(1e-5, True), (1e-3, False)])
def test_errors_that_cause_almost_equal_forces_are_ranked_by_their_moments(less, alike):
    """Of forces that differ by a thousandth, the larger one comes first, whatever its moment."""
    nothing = {"twist": np.zeros(6), "displacement": 0.0, "rotation": 0.0, "stiffness": np.zeros((6, 6)), "actuator_forces": {}}
    effects = {
        "bends less": Effect(**nothing, force=100.0, moment=2.0),
        "bends more": Effect(**nothing, force=100 - 100 * less, moment=3.0),
    }
    assert list(_ordered(effects, "force")) == (["bends more", "bends less"] if alike else ["bends less", "bends more"])


def test_errors_that_stress_without_moving_the_platform_are_listed():
    """A rigid locked slide holds the platform; a column with a slide beside it is bent by a shift of its foot, 12 E I δ / L³."""
    machine = robot(
        link("base"), link("column"), link("platform", 5.0),
        joint("slide", "prismatic", "base", "platform", "0 0 0.6", "0 0 1"),
        joint("foot", "fixed", "base", "column", "0.4 0 0"),
        loop("head", "prismatic", "column", "platform", "0 0 0.6", "0.4 0 0", "0 0 1"), bar("column", "foot", "head"),
        '<transmission name="t"><joint name="slide"/></transmission>',
    )  # fmt: skip
    found = ks.tolerances(machine.assemble(), samples=2, gravity=STILL)
    effect, delta = found.effects["foot.error.x"], found.parameters["foot.error.x"].tolerance
    assert effect.displacement == 0 == effect.rotation
    inertia = machine.description.beams["column"].section.I_y
    assert effect.force == pytest.approx(12 * E_MODULUS * inertia * delta / 0.6**3, rel=1e-9)
    assert "foot.error.z" not in found.effects  # along the slide


def test_tool_tip_effects_follow_from_those_of_o():
    """The tip moves by the displacement of o and the rotation times its arm."""
    pose, tool = package_robots.robot("3rps").assemble(platform={"z": 0.5, "rx": 0.1, "ry": -0.05}), (0.05, 0, 0.2)
    of_o, of_tip = (ks.tolerances(pose, rank_by="rotation", tool=place).effects for place in (None, tool))
    arm = pose.platform_frame[:3, :3] @ tool
    assert list(of_o) == list(of_tip) and any(effect.rotation > 1e-4 for effect in of_tip.values())
    for name, other in of_tip.items():
        one = of_o[name].twist
        np.testing.assert_allclose(other.twist, [*np.add(one[:3], np.cross(one[3:], arm)), *one[3:]], atol=1e-15)


@pytest.mark.parametrize("platform", [None, {"z": 0.5, "rx": 0.1, "ry": -0.05}])
def test_assembly_errors_of_determinate_robots_cause_no_forces(platform):
    found = ks.tolerances(package_robots.robot("3rps").assemble(platform=platform), load=LOAD)
    assert found.ranked_by == "displacement" and all(item.force == 0 == item.moment for item in found.effects.values())
    assert "The assembly errors cause no self-stress." in str(found)
    assert np.all(found.samples.actuator_forces["prismatic_1"] == found.result.actuator_forces["prismatic_1"])
    # errors along a joint's own freedoms do nothing: a spherical joint's rotations are not among the effects
    assert {name.rpartition(".")[2] for name in found.effects if name.startswith("spherical")} <= {"x", "y", "z"}
    named = ks.tolerances(found.result.configuration, {"spherical_1.error.rx": "1mrad"}, samples=2)
    assert named.effects["spherical_1.error.rx"].rotation < 1e-12  # but listed when named


def test_all_errors_of_an_elastic_joint_are_listed():
    """Every error moves the platform; shifts of 1e-12 m from rounding do not change the order."""
    pose = mount(springs("mount", linear="1e5 1e5 1e5", angular="1e4 1e4 1e4")).assemble()
    assert [name[-2:] for name in ks.tolerances(pose, samples=2).effects] == [".x", ".y", ".z", "rx", "ry", "rz"]


def test_indeterminate_forces_are_left_out_of_effects():
    """Rigid bars of a parallelogram share forces indeterminately; the largest force is that of the other bars."""
    description = package_robots.robot("orthoglide").description
    for name in ("bar_1b", "bar_2b", "bar_3a", "bar_3b"):
        description = description.without_beam(name)
    pose = ks.Robot(description).assemble()
    with pytest.warns(
        UserWarning, match=r"rail_2\.error\.y contradicts rigid parts, which cannot deform; it and \d+ other errors are"
    ):
        found = ks.tolerances(pose, samples=2)
    assert all(np.all(np.isfinite([item.force, item.moment, *item.twist])) for item in found.effects.values())
    name, effect = next(iter(found.effects.items()))
    forces = [np.linalg.norm(wrench[:3]) for wrench in alone(pose, found, name).joint_wrenches.values()]
    assert np.any(np.isnan(forces)) and name.endswith(".x") and effect.force == pytest.approx(np.nanmax(forces), rel=1e-6)


def test_rounding_of_forces_is_judged_independently_of_error_size():
    """Effects are linear: errors that cause self-stress in moments alone do so at any size."""
    pose = package_robots.robot("tripteron").assemble()

    def told(size):
        off = {"*.error.[xyz]": f"{0.1 * size}mm", "*.error.length": f"{0.1 * size}mm", "*.error.r?": f"{size}mrad"}
        found = ks.tolerances(pose, off, samples=2, gravity=STILL)
        return {name: (item.force / size, item.moment / size) for name, item in found.effects.items()}

    own = told(1.0)
    assert sum(force == 0 < moment for force, moment in own.values()) == 24
    for other in (told(1e8), told(1e-8)):
        for name, (force, moment) in other.items():
            assert (force, moment) == pytest.approx(own[name], rel=1e-6) and (force == 0) == (own[name][0] == 0)


def test_errors_incompatible_with_rigid_parts_are_named():
    rigid = package_robots.robot("2pru_upr").description
    for name in list(rigid.beams):
        rigid = rigid.without_beam(name)
    with pytest.raises(ks.StaticsError, match=r"revolute_1\.error\.\w+ contradicts rigid parts, which cannot deform"):
        ks.tolerances(ks.Robot(replace(rigid, joint_stiffness={})).assemble(), {"revolute_1.error.*": 1e-5})


# ---- tables and figures ----------------------------------------------------------------------------------------------------


def test_tables_and_json_show_tolerances_and_samples(legs):
    text = str(legs)
    rows = {line.split()[0]: line for line in text.splitlines() if line.startswith("  ")}
    assert "0.0002 m" in rows["rod_1.outer_diameter"] and "4e+09 Pa" in rows["youngs_modulus"]
    assert "500 random samples" in text and "a third of" in text and "prismatic_1" in rows
    assert "moves by" in repr(legs) and "rotation" in legs._repr_html_()
    read = json.loads(json.dumps(legs.to_dict()))
    assert read["random"]["displacement"][1] == pytest.approx(legs.sampled("displacement")[1])
    assert read["parameters"]["rod_2.outer_diameter"]["unit"] == "m" and read["seed"] == 3
    with pytest.raises(ks.ArgumentError, match="no quantity 'sag'"):
        legs.sampled("sag")


def test_rounding_noise_is_zero_in_the_table():
    """Beside a deflection of micrometres one of 1e-16 m is rounding, which differs between processors."""
    assert not re.search(r"e-\d\d", str(ks.tolerances(check_texts.robot("rigid_limbs").assemble()).report().only("variation")))


def test_histogram_shows_samples_and_first_order_outline(legs):
    import matplotlib

    matplotlib.use("Agg")
    ax = ks.plot.tolerances(legs, "prismatic_2")
    assert ax.get_xlabel() == "force of prismatic_2 [N]" and sum(bar.get_height() for bar in ax.patches[:60]) == 500
    # bars, and the outline of the same robots to first order
    bars, outline = ax.patches[:60], ax.patches[60]
    np.testing.assert_allclose(sorted(y for _, y in outline.get_xy()[1:-1:2]), sorted(bar.get_height() for bar in bars), atol=40)
    assert len(ax.lines) == 2
    ax = ks.plot.tolerances(legs)
    assert ax.get_xlabel() == "displacement of o from nominal [nm]" and len(ax.lines) == 1
    with pytest.raises(ks.ArgumentError, match="tolerances needs the result of"):
        ks.plot.tolerances(1)


def test_invalid_tolerances_are_refused(cantilever):
    mistakes = {
        "tolerances is empty": {},
        "did you mean 'diameter'": {"diametre": "1mm"},
        "given in kg, but it is in m": {"diameter": "1kg"},
        "must be a positive number": {"diameter": -1.0},
        "is zero: give it with a unit": {"tip.center_of_mass.x": "1%"},
        "E cannot deviate by its tolerance: .*youngs_modulus": {"E": "400%"},
        "named twice": {"rod.*": "1%", "rod.outer_diameter": "1mm"},
        "is not a number": {"diameter": "thick"},
        "given in mm, but it has no unit": {"rod.poisson_ratio": "1mm"},
        "did you mean 'rod.error.length'": {"rod.error.lenght": "1mm"},
        "rod.error.length is given in mrad, but it is in m": {"rod.error.length": "1mrad"},
    }
    for message, off in mistakes.items():
        with pytest.raises(ks.ArgumentError, match=message):
            ks.tolerances(cantilever, off)
    with pytest.raises(ks.ArgumentError, match="samples is 1; it must be a whole number from 2 on"):
        ks.tolerances(cantilever, {"E": "1%"}, samples=1)
    several = package_robots.robot("3rps").assemble(platform={"z": [0.5, 0.6], "rx": 0.0, "ry": 0.0})
    with pytest.raises(ks.ArgumentError, match="single pose"):
        ks.tolerances(several, {"rod_diameter": 1e-4})
    pose = package_robots.robot("2pru_upr").assemble()
    with pytest.raises(ks.ArgumentError, match=r"overconstrained robot, tolerances of JOINT\.error\.x"):
        ks.tolerances(pose, {"revolute_1.placement.x": "0.1mm"})
    with pytest.warns(UserWarning, match=r"the tolerance revolute_1\.error\.rx = 1 rad is"):
        ks.tolerances(pose, {"revolute_1.error.rx": 1.0}, samples=2)
