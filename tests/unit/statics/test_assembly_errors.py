"""Assembly errors, length errors, temperatures: closed forms, kinematics, rigid parts, branches on the platform."""

from dataclasses import replace

import numpy as np
import package_robots
import pytest
from odd_robots import parsed, rigid_limbs, written
from package_robots import robot
from simple_machines import AREA as BAR_AREA
from simple_machines import RHO, E, bar, joint, link, mount, springs, truss, two_columns
from simple_machines import THERMAL_EXPANSION as ALPHA

import kinetostatics as ks

STILL = (0, 0, 0)
AREA, INERTIA = np.pi * 0.05**2 / 4, np.pi * 0.05**4 / 64


def heated(growth, length=1.0, half=0.2):
    """Return the twist (z, ry) of two columns, the first longer by ``growth``, and its axial force, by the displacement method.

    The platform rises by z and turns by ry about y; a column's top then moves by z ∓ half·ry and turns by ry, which bends it:
    with its top also free to shift sideways along x both columns take the same side force, none in all.
    """
    axial, bend = E * AREA / length, E * INERTIA / length
    # turning by r with no side force bends each column by the moment EI/L r
    # columns at x = −half (grown) and +half: rise of their tops z + half r, z − half r  (ry > 0 lifts −x)
    A = np.array([[2 * axial, 0.0], [0.0, 2 * axial * half**2 + 2 * bend]])
    z, r = np.linalg.solve(A, [axial * growth, axial * growth * half])
    return z, r, axial * (z + half * r - growth)


@pytest.mark.parametrize(
    ("assembly_error", "growth"),
    [
        ({"a": {"temperature": 30}}, ALPHA * 30),
        ({"a": {"length": 2e-4}}, 2e-4),
        ({"a": {"length": -1e-4, "temperature": 20}}, -1e-4 + ALPHA * 20),
        ({"foot_a": [0, 0, 3e-4, 0, 0, 0]}, 3e-4),
        ({"head_a": {"twist": [0, 0, 3e-4, 0, 0, 0], "frame": "joint"}}, 3e-4),
    ],
)
def test_long_column_lifts_and_tilts_the_platform(assembly_error, growth):
    machine = two_columns()
    found = ks.analyze(machine.assemble(), gravity=STILL, assembly_errors=assembly_error)
    z, r, force = heated(growth)
    assert list(found.contributions) == ["load", "platform_weight", "limb_1", "limb_2", "assembly_errors"]
    np.testing.assert_allclose(found.twist[[2, 4]], [z, r], rtol=1e-9)
    np.testing.assert_allclose(found.contributions["assembly_errors"], found.twist, rtol=1e-12)
    np.testing.assert_allclose(found.beams["a"].section_wrenches[:, 0], force, rtol=1e-8)
    assert found.limbs["limb_1"].contributions["assembly_errors"] == pytest.approx(found.limbs["limb_1"].intensities)
    everything = sum(sum(named.values()) for named in found.source_contributions.values())
    np.testing.assert_allclose(everything, found.twist, rtol=1e-9, atol=1e-18)
    name = next(iter(assembly_error))
    assert list(found.source_contributions["assembly_errors"]) == [name]


def test_uniform_warming_causes_no_stress():
    found = ks.analyze(two_columns().assemble(), gravity=STILL, assembly_errors={name: {"temperature": 50} for name in "ab"})
    np.testing.assert_allclose(found.twist, [0, 0, 50 * ALPHA, 0, 0, 0], rtol=1e-10, atol=1e-16)
    assert np.abs(found.beams["a"].section_wrenches).max() < 1e-6


def test_assembly_errors_add_to_loads():
    machine = two_columns().assemble()
    assembly_error = {"foot_b": [1e-4, 2e-4, 3e-4, 4e-4, 5e-4, 6e-4]}
    loaded, off = ks.analyze(machine, (1, 2, 3, 4, 5, 6)), ks.analyze(machine, gravity=STILL, assembly_errors=assembly_error)
    both = ks.analyze(machine, (1, 2, 3, 4, 5, 6), assembly_errors=assembly_error)
    np.testing.assert_allclose(both.twist, loaded.twist + off.twist, rtol=1e-12)
    for name, wrench in both.joint_wrenches.items():
        np.testing.assert_allclose(wrench, loaded.joint_wrenches[name] + off.joint_wrenches[name], rtol=1e-9, atol=1e-7)


def test_longer_rod_moves_platform_like_a_longer_stroke():
    """Without overconstraint an assembly error causes no forces: here it moves the platform like the prismatic joint."""
    machine = package_robots.robot("3rps")
    pose = machine.assemble(platform={"z": 0.52, "rx": 0.1, "ry": -0.15})
    moved = package_robots.rates(machine, dict(pose.actuators), lambda pose: pose.platform_frame)
    for rod, twist in zip(("rod_1", "rod_2", "rod_3"), moved.T, strict=True):
        found = ks.analyze(pose, gravity=STILL, assembly_errors={rod: {"length": 1e-4}})
        assert all(abs(force) < 1e-5 for force in found.actuator_forces.values())
        np.testing.assert_allclose(found.twist, 1e-4 * twist, rtol=1e-6, atol=1e-11)


def test_rail_offset_locks_the_documented_force_into_2pru_upr():
    """0.1 mm on one rail along X in configuration 1 causes 34 N, more than gravity's 31 N (the method page, section 6)."""
    machine = package_robots.robot("2pru_upr")
    pose = machine.assemble()
    found = ks.analyze(pose, gravity=STILL, assembly_errors={"prismatic_1": [1e-4, 0, 0, 0, 0, 0]})
    assert np.linalg.norm(found.joint_wrenches["prismatic_1"][:3]) == pytest.approx(34, abs=0.5)
    ranked = ks.tolerances(pose)
    row = ranked.effects["prismatic_1.error.x"]
    assert row.force == pytest.approx(np.linalg.norm(found.joint_wrenches[row.at][:3]), rel=1e-9)
    assert row.twist == pytest.approx(found.twist, rel=1e-9, abs=1e-18)


@pytest.mark.parametrize("name", ["2pru_upr", "linear_delta", "3prs"])
def test_joint_errors_act_at_reference_point_of_joint_wrenches(name):
    """Virtual work: an error moves the platform along a unit load by its product with the joint wrench of that load."""
    machine, rng = package_robots.robot(name), np.random.default_rng(4)
    start = machine.assemble()
    pose = machine.assemble(actuators={key: value + 0.02 * rng.random() for key, value in start.actuators.items()})
    under = ks.analyze(pose, np.eye(6), STILL)
    for slide in machine.description.joints.values():
        if slide.type == "prismatic" and slide.name in under.joint_wrenches:
            own = [1e-4, 1e-4, 1e-4, 1e-3, 1e-3, 1e-3] * rng.standard_normal(6)
            axes = np.kron(np.eye(2), pose.frame(slide.parent)[:3, :3] @ slide.origin.matrix[:3, :3])
            expected = -under.joint_wrenches[slide.name] @ axes @ own
            for value in ({"twist": own, "frame": "joint"}, axes @ own):
                twist = ks.analyze(pose, gravity=STILL, assembly_errors={slide.name: value}).twist
                np.testing.assert_allclose(twist, expected, rtol=0, atol=1e-9 * np.abs(expected).max())


def test_batch_of_assembly_errors_equals_single_analyses():
    machine = two_columns()
    shifts = np.linspace(-1e-4, 1e-4, 5)
    twist = np.zeros((5, 6))
    twist[:, 2] = shifts
    found = ks.analyze(machine.assemble(), gravity=STILL, assembly_errors={"foot_a": twist, "b": {"length": shifts}})
    assert found.shape == (5,)
    for k, shift in enumerate(shifts):
        one = ks.analyze(machine.assemble(), gravity=STILL, assembly_errors={"foot_a": twist[k], "b": {"length": shift}})
        np.testing.assert_allclose(found.twist[k], one.twist, rtol=1e-12, atol=1e-20)


@pytest.mark.parametrize(
    ("assembly_errors", "message"),
    [
        ({"rodd_1": [0] * 6}, "did you mean"),
        ({"revolute_1": [0, 0, 1e-4]}, r"shape \(3,\)"),
        ({"revolute_1": {"twist": [0] * 6, "frame": "platform"}}, "'world' or 'joint'"),
        ({"revolute_1": {"length": 1e-4}}, "'twist' and 'frame'"),
        ({"rod_1": [0] * 6}, "'length'"),
        ({"rod_1": {"lenght": 1e-4}}, "'length'"),
        ({"rod_1": {"temperature": [0.0, 10.0]}}, "thermal_expansion"),
        ({"rod_1": {"length": np.nan}}, "not finite"),
        ([1, 2], "mapping"),
    ],
)
def test_wrong_assembly_errors_are_refused(assembly_errors, message):
    pose = package_robots.robot("3rps").assemble()
    with pytest.raises(ks.ArgumentError, match=message):
        ks.analyze(pose, assembly_errors=assembly_errors)


@pytest.mark.parametrize("bar_number", [0, 1, 2])
def test_long_bar_of_a_truss_stresses_the_others(bar_number):
    """Self-stress of one limb by an assembly error: K u = Σ EA/L e δ, N = EA/L (e u − δ)."""
    machine = truss()
    feet = np.array([[-1.0, 0], [0, 0], [1, 0]])
    along = np.array([0.0, 1.0]) - feet
    lengths = np.linalg.norm(along, axis=1)
    e, k = along / lengths[:, None], E * BAR_AREA / lengths
    delta = np.where(np.arange(3) == bar_number, 1e-4, 0)
    u = np.linalg.solve((e.T * k) @ e, e.T @ (k * delta))
    forces = k * (e @ u - delta)
    found = ks.analyze(machine.assemble(), gravity=STILL, assembly_errors={f"bar_{bar_number}": {"length": 1e-4}})
    np.testing.assert_allclose(found.twist[[0, 2]], u, rtol=1e-9, atol=1e-16)
    for number, force in enumerate(forces):
        np.testing.assert_allclose(found.beams[f"bar_{number}"].section_wrenches[:, 0], force, rtol=1e-7)
        wrench = found.joint_wrenches[f"foot_{number}"]
        np.testing.assert_allclose(wrench[[0, 2]], -force * e[number], rtol=1e-7, atol=1e-9 * abs(force))


@pytest.mark.parametrize("value", [[0, 0, 3e-4, 0, 0, 0], {"twist": [0, 0, 3e-4, 0, 0, 0], "frame": "joint"}])
def test_error_value_selects_between_beam_and_joint_of_one_name(value):
    """The beam a of a column and the joint at its foot, also named a."""
    description = two_columns().description
    foot, column = description.joints["foot_a"], description.beams["a"]
    joints = {("a" if name == "foot_a" else name): item for name, item in description.joints.items()}
    joints["a"] = replace(foot, name="a")
    start = replace(column.start, joint="a")
    machine = ks.Robot(replace(description, joints=joints, beams={**description.beams, "a": replace(column, start=start)}))
    joint_off = ks.analyze(machine.assemble(), gravity=STILL, assembly_errors={"a": value})
    too_long = ks.analyze(machine.assemble(), gravity=STILL, assembly_errors={"a": {"length": 3e-4}})
    z, r, _ = heated(3e-4)
    for found in (joint_off, too_long):
        np.testing.assert_allclose(found.twist[[2, 4]], [z, r], rtol=1e-9)
    warm = ks.analyze(machine.assemble(), gravity=STILL, assembly_errors={"a": {"temperature": 25}, "b": {"temperature": 25}})
    np.testing.assert_allclose(warm.twist[2], 25 * ALPHA, rtol=1e-9)


Y = (0.0, 1.0, 0.0)
CIRCLE = '<circle diameter="0.02"/>'


@pytest.mark.parametrize("size", [1e-3, 1e-9])
def test_rigid_limbs_cannot_follow_an_error_across_their_plane(size):
    """A rigid planar four-bar linkage: its two limbs both hold the platform in the plane."""
    pose = rigid_limbs().assemble()
    across = ks.analyze(pose, gravity=STILL, assembly_errors={"other_head": [0, size, 0, 0, 0, 0]}, on_failure="nan")
    assert np.isnan(across.twist).any() and across.indeterminate
    assert np.isnan(across.contributions["assembly_errors"]).any() and np.isfinite(across.contributions["load"]).all()
    assembly_errors = {"other_head": [0, size, 0, 0, 0, 0], "foot": [size, 0, 0, 0, 0, 0]}
    with pytest.raises(ks.StaticsError, match="the assembly errors of foot, other_head contradict one another in rigid parts"):
        ks.analyze(pose, gravity=STILL, assembly_errors=assembly_errors)


def test_rigid_limbs_follow_an_error_in_their_plane():
    """The far rod is too long by 1 mm: the locked crank's head stays, the coupler turns about it."""
    pose = rigid_limbs().assemble()
    head, far, foot = np.array([0, 0, 0.5]), np.array([0.5, 0, 0.6]), np.array([0.4, 0, 0.0])
    along = (far - foot) / np.linalg.norm(far - foot)
    found = ks.analyze(pose, gravity=STILL, assembly_errors={"other_head": [*(1e-3 * along), 0, 0, 0]}, on_failure="nan")
    turn = 1e-3 / (np.cross(Y, far - head) @ along)
    o = np.array([0.2, 0, 0.5])
    np.testing.assert_allclose(found.twist[3:], [0, turn, 0], rtol=1e-9, atol=1e-15)
    np.testing.assert_allclose(found.twist[:3], turn * np.cross(Y, o - head), rtol=1e-9, atol=1e-15)


def ring(stem=True):
    """A slide that carries a rigid parallelogram and, on it, an elastic or rigid stem; the platform stays in a plane."""
    edges = [
        ("slide", "P", (0, 0, 0), "base", "slider", {"axis": (0, 0, 1), "actuated": True}),
        ("left_foot", "R", (-0.3, 0, 0), "slider", "left", {"axis": Y}),
        ("right_foot", "R", (0.3, 0, 0), "slider", "right", {"axis": Y}),
        ("left_head", "R", (-0.3, 0, 0.5), "left", "coupler", {"axis": Y}),
        ("right_head", "R", (0.3, 0, 0.5), "right", "coupler", {"axis": Y}),
        ("stem_foot", "F", (0, 0, 0.5), "coupler", "stem", {}),
        ("stem_head", "F", (0, 0, 0.9), "stem", "platform", {}),
        ("pin", "E", (0, 0, 0.9), "base", "platform", {"axis": (1.0, 0, 0)}),
    ]  # fmt: skip
    beams = [("stem", "stem_foot", "stem_head", {})] if stem else []
    return parsed(written(edges, beams, {"right_head", "pin"}, o=(0, 0, 0.9), name="ring"))


@pytest.mark.parametrize("size", [1e-3, 1e-9])
@pytest.mark.parametrize("stem", [True, False])
def test_rigid_rings_cannot_follow_errors_across_their_plane(stem, size):
    """On an elastic and on a rigid stem."""
    pose, off = ring(stem).assemble(), np.array([0, size, 0, 0, 0, 0])
    found = ks.analyze(pose, gravity=STILL, assembly_errors={"right_head": off}, on_failure="nan")
    assert np.isnan(found.contributions["assembly_errors"]).any() and np.isfinite(found.contributions["load"]).all()
    # equal errors at both hinges of one rod only displace it
    found = ks.analyze(pose, gravity=STILL, assembly_errors={"right_head": -off, "right_foot": off})
    assert np.isfinite(found.twist).all()


@pytest.mark.parametrize(("across", "follows"), [(0.0, True), (1e-12, True), (1e-8, False)])
@pytest.mark.parametrize("size", [1.0, 1e-3])
def test_rigid_rings_follow_errors_in_their_plane_and_rounding_across_it(size, across, follows):
    """A rod that is 1 mm too long, with its head across the plane by rounding of its direction or by more than that."""
    pose, off = ring().assemble(), size * np.array([0, across, 1e-3, 0, 0, 0])
    found = ks.analyze(pose, gravity=STILL, assembly_errors={"right_head": off}, on_failure="nan")
    assert np.isfinite(found.contributions["assembly_errors"]).all() == follows


def test_branch_on_platform_has_own_errors_and_platform_weight():
    """Its weight counts for the platform, its assembly errors move only the branch, its beam bends under its own weight."""
    parts = [
        link("arm"), joint("clamp", "fixed", "platform", "arm", "0.2 0 0"), link("lamp", 2.0),
        joint("hook", "fixed", "arm", "lamp", "0.3 0 0"), bar("arm", "clamp", "hook", RHO, CIRCLE),
    ]  # fmt: skip
    machine = mount(springs("mount", linear="1e5 1e5 1e5", angular="1e4 1e4 1e4"), *parts)
    found = ks.analyze(
        machine.assemble(),
        (1, 2, 3, 0, 0, 0),
        (0, 0, -10),
        assembly_errors={"hook": [0, 1e-3, 0, 0, 0, 2e-3], "arm": {"length": 5e-4}},
    )
    lamp = found.link_contributions["lamp"]
    E, inertia, area = 2.0e11, np.pi * 0.02**4 / 64, np.pi * 0.02**2 / 4
    q, L, P = RHO * area * 10, 0.3, 20.0
    sag = (P / 3 + q * L / 8) * L**3 / (E * inertia)
    slope = (P / 2 + q * L / 6) * L**2 / (E * inertia)
    rigid = {name: found.contributions[name].copy() for name in lamp}
    for twist in rigid.values():
        twist[:3] += np.cross(twist[3:], [0.5, 0, 0])
    np.testing.assert_allclose(
        lamp["platform_weight"] - rigid["platform_weight"], [0, 0, -sag, 0, slope, 0], rtol=1e-8, atol=1e-16
    )
    np.testing.assert_allclose(lamp["load"], rigid["load"], rtol=1e-12, atol=1e-18)
    np.testing.assert_allclose(lamp["assembly_errors"], [5e-4, 1e-3, 0, 0, 0, 2e-3], rtol=1e-12, atol=1e-18)
    np.testing.assert_allclose(found.contributions["assembly_errors"], 0, atol=1e-18)
    line = found.beams["arm"]
    parts = found.beam_contributions["arm"]
    np.testing.assert_allclose(parts["assembly_errors"][-1], [5e-4, 0, 0, 0, 0, 0], rtol=1e-12, atol=1e-18)
    np.testing.assert_allclose(parts["assembly_errors"][10], [2.5e-4, 0, 0, 0, 0, 0], rtol=1e-12, atol=1e-18)
    np.testing.assert_allclose(line.section_wrenches[0][[2, 4]], [-(P + q * L), (P * L + q * L**2 / 2)], rtol=1e-9)


@pytest.mark.few(1)
@pytest.mark.parametrize("rigid", [("bar_1a", "bar_1b"), ("bar_1b", "bar_2b", "bar_3a", "bar_3b")])
def test_twist_with_indeterminate_forces_is_that_of_stiff_parts(rigid):
    """An orthoglide, some of whose rods are rigid, against one where these are a million times stiffer than the others."""
    description = robot("orthoglide").description
    stiff = {name: replace(beam.material, youngs_modulus=7e16, density=0.0) for name, beam in description.beams.items()}
    ends = {name: replace(description.beams[name], material=stiff[name]) for name in rigid}
    one = ks.Robot(replace(description, beams={name: beam for name, beam in description.beams.items() if name not in rigid}))
    other = ks.Robot(replace(description, beams={**description.beams, **ends}))
    at = dict(zip(description.actuated, [[0.0, 0.01, 0.013], [0.0, -0.01, -0.004], [0.0, 0.01, 0.02]], strict=True))
    load = [10, -20, -30, 1, 2, 3]
    found, wanted = (ks.analyze(robot.assemble(actuators=at), load) for robot in (one, other))
    assert (found.status == ks.Status.INDETERMINATE).all()
    np.testing.assert_allclose(found.twist, wanted.twist, rtol=1e-4, atol=2e-9)


@pytest.mark.parametrize("error", [1e-3, [1e-3], [[1e-3] * 5], {"twist": 0.0}])
def test_twists_of_assembly_errors_have_six_entries(error):
    pose = ks.load_robot("3rps").assemble()
    with pytest.raises(ks.ArgumentError, match="its last axis must have 6 entries"):
        ks.analyze(pose, assembly_errors={"spherical_1": error})


def test_split_contributions_of_a_rigid_limb_have_the_effects_of_its_errors():
    """One leg of three without a beam: an error of its actuator displaces the platform."""
    description = robot("3rps").description.without_beam("rod_1")
    pose = ks.Robot(description).assemble(actuators={"prismatic_1": 0.02, "prismatic_2": 0.0, "prismatic_3": -0.01})
    result = ks.analyze(
        pose, [30, -20, 50, 4, -3, 2], assembly_errors={"prismatic_1": [0, 0, 1e-4, 0, 0, 0], "rod_2": {"length": 2e-4}}
    )
    split = result.by_mechanism
    assert np.abs(result.contributions["assembly_errors"]).max() > 1e-5
    for name in ("assembly_errors", "load", "platform_weight"):
        np.testing.assert_allclose(split.contributions[name], result.contributions[name], rtol=1e-9, atol=1e-14)
    np.testing.assert_allclose(split.twist, result.twist, rtol=1e-9, atol=1e-14)
