"""Robots with springs have one tangent stiffness: that of statics is the static limit of modes and frequency response."""

import numpy as np
import package_robots
import pytest
import small_robots as sr
import sprung_robots

import kinetostatics as ks
from kinetostatics.description import Spring
from kinetostatics.files.reader import parse_robot_text

GRAVITY = 9.81


def loaded(text):
    return ks.Robot(parse_robot_text(text))


def arm(axis="0 0 1", drive="", inertia=0.0, mass=2.0, springs=""):
    text = f"""<robot name="arm"><link name="ground"/>
        <link name="tip"><inertial><origin xyz="0.5 0 0"/><mass value="{mass}"/>
        <inertia ixx="{inertia}" iyy="{inertia}" izz="{inertia}" ixy="0" ixz="0" iyz="0"/></inertial></link>
        <joint name="a" type="revolute"><parent link="ground"/><child link="tip"/><axis xyz="{axis}"/>
        <limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
        <transmission name="t"><joint name="a"/></transmission>{drive}
        <platform link="tip"><origin xyz="0.5 0 0"/></platform>{springs}</robot>"""
    return loaded(text)


def stiff(value):
    return f'<joint_stiffness joint="a" drive="{value}"/>'


def spring(ground, tip, stiffness=0.0, free_length=0.0, preload=0.0):
    return (
        f'<spring name="s" stiffness="{stiffness}" free_length="{free_length}" preload="{preload}">'
        f'<predecessor link="ground"><origin xyz="{ground}"/></predecessor>'
        f'<successor link="tip"><origin xyz="{tip}"/></successor></spring>'
    )


@pytest.mark.parametrize("stiffness", [0.0, 1000.0])
@pytest.mark.parametrize("behind", [0.3, -1.2])
def test_arm_on_a_tensioned_spring_equals_closed_form(stiffness, behind):
    """A spring of length l and tension F from the distance d behind the pivot to the arm's end at r: K = k − F r d / l."""
    r, F, drive = 0.5, 100.0, 500.0
    length = abs(r + behind)
    free = length - F / stiffness if stiffness else 0.0
    held = spring(f"{-behind} 0 0", f"{r} 0 0", stiffness, free, 0.0 if stiffness else F)
    pose = arm(drive=stiff(drive), springs=held).assemble(actuators={"a": 0.0})
    tangent = drive - F * r * behind / length
    assert float(ks.modes(pose, 1).frequencies[0]) == pytest.approx(np.sqrt(tangent / (2 * r**2)) / 2 / np.pi, rel=1e-9)
    response = ks.frequency_response(pose, [1e-5], damping=0.0)
    assert response.compliance[0, 1, 1].real == pytest.approx(r**2 / tangent, rel=1e-9)


@pytest.mark.parametrize("angle", [0.0, 0.6])
def test_a_balanced_arm_is_indifferent(angle):
    """A spring without free length, k a b = m g c, balances the arm at every angle: only its drive returns it."""
    m, c, a, b = 4.0, 0.5, 0.4, 0.3
    held = spring(f"0 0 {a}", f"{b} 0 0", m * GRAVITY * c / (a * b))
    inertia = m * c**2 + 0.001
    for drive in (None, 50.0):
        robot = arm("0 1 0", "" if drive is None else stiff(drive), 0.001, m, held)
        pose = robot.assemble(actuators={"a": angle})
        free, locked = ks.modes(pose, 1, drives="free"), ks.modes(pose, 1)
        assert free.zero_frequencies == 1 and np.isinf(free.frequencies[0]) and free.status == ks.Status.OK
        assert "1 free motion of frequency zero" in str(free)
        expected = np.inf if drive is None else np.sqrt(drive / inertia) / 2 / np.pi
        np.testing.assert_allclose(locked.frequencies, [expected], rtol=1e-9)


@pytest.mark.parametrize(
    ("excess", "verdict"),
    [(1e-10, "indifferent"), (-1e-13, "indifferent"), (1e-7, "falls"), (-1e-7, "swings"), (-1e-10, "swings")],
)
def test_an_arm_that_is_balanced_but_for_rounding_is_indifferent(excess, verdict):
    """Of the two stiffnesses that cancel, ± m g c sin φ, a part is left: it counts, with its sign, if it is no rounding error."""
    m, c, a, b, angle = 4.0, 0.5, 0.4, 0.3, 0.6
    held = spring(f"0 0 {a}", f"{b} 0 0", m * GRAVITY * c / (a * b) * (1 + excess))
    found = ks.modes(arm("0 1 0", "", 0.001, m, held).assemble(actuators={"a": angle}), 1, drives="free")
    left = -excess * m * GRAVITY * c * np.sin(angle) / (m * c**2 + 0.001)
    if verdict == "indifferent":
        assert found.zero_frequencies == 1 and found.status == ks.Status.OK
    elif verdict == "swings":
        np.testing.assert_allclose(found.frequencies, [np.sqrt(left) / 2 / np.pi], rtol=1e-5)
    else:
        assert np.isnan(found.frequencies[0]) and found.status == ks.Status.SINGULAR


@pytest.mark.parametrize(("preload", "stable"), [(100.0, False), (-100.0, True)])
def test_a_spring_beyond_the_pivot_decides_stability(preload, stable):
    r, d = 0.5, 0.3
    held = spring(f"{-d} 0 0", f"{r} 0 0", preload=preload)
    pose = arm(springs=held).assemble(actuators={"a": 0.0})
    found = ks.modes(pose, 1, drives="free")
    if stable:
        expected = np.sqrt(-preload * r * d / (r + d) / (2 * r * r)) / 2 / np.pi
        np.testing.assert_allclose(found.frequencies, [expected], rtol=1e-9)
        assert not found.warnings
    else:
        assert np.isnan(found.frequencies[0]) and found.status == ks.Status.SINGULAR
        assert "unstable" in found.warnings[0] and "unstable" in str(found) and "SINGULAR" in str(found)


@pytest.mark.parametrize(("drive", "stable"), [(50.0, True), (10.0, False)])
def test_statics_modes_response_and_verification_have_one_verdict(drive, stable):
    """The drive's stiffness is above or below F r d / (r + d) = 18.75 N·m/rad."""
    robot = arm(drive=stiff(drive), springs=spring("-0.3 0 0", "0.5 0 0", preload=100.0))
    pose = robot.assemble(actuators={"a": 0.0})
    result, modes = ks.analyze(pose, gravity=(0, 0, 0)), ks.modes(pose, 1, gravity=(0, 0, 0))
    response = ks.frequency_response(pose, [1e-3, 3.0], gravity=(0, 0, 0))
    for item in (result, modes, response):
        assert any("unstable" in text for text in item.warnings) != stable
    assert np.isfinite(modes.frequencies[0]) == np.all(np.isfinite(response.compliance)) == stable
    assert response.status == modes.status == (ks.Status.OK if stable else ks.Status.SINGULAR)
    assert ("SINGULAR" in str(response)) != stable


def test_passive_pendulums_swing_and_fall():
    """g / l against a hinge that nothing drives; upside down it falls; a mass on a spring in a slide has k / m."""
    nothing = spring("0 0 1", "0 0 0", free_length=1.0)
    text = """<robot name="p"><link name="ground"/><link name="tip"><inertial><origin xyz="0 0 {z}"/><mass value="2"/>
    <inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/></inertial></link>
    <joint name="a" type="revolute"><parent link="ground"/><child link="tip"/><axis xyz="0 1 0"/>
    <limit lower="-3" upper="3" effort="1" velocity="1"/></joint><platform link="tip"/>{springs}</robot>"""
    found = ks.modes(loaded(text.format(z=-0.5, springs=nothing)).assemble(), 1)
    np.testing.assert_allclose(found.frequencies, [np.sqrt(GRAVITY / 0.5) / 2 / np.pi], rtol=1e-9)
    assert np.isnan(ks.modes(loaded(text.format(z=0.5, springs=nothing)).assemble(), 1).frequencies[0])


# ---- random robots ---------------------------------------------------------------------------------------------------------


def assert_one_tangent(pose):
    """The static limit of the response is the compliance; both are stable or unstable; return whether numbers were compared."""
    result = ks.analyze(pose, on_failure="nan")
    modes = ks.modes(pose, 1)
    lowest = float(modes.frequencies[0])
    response = ks.frequency_response(pose, [1e-5 * lowest if np.isfinite(lowest) else 1e-3], damping=0.0)
    if result.status == ks.Status.SINGULAR:
        return False
    unstable = any("unstable" in text for text in result.warnings)
    assert np.isnan(modes.frequencies[0]) == np.isnan(response.compliance[0, 0, 0]) == unstable
    assert bool(modes.warnings) == bool(response.warnings) == unstable
    if unstable:
        return False
    unit = np.repeat([1.0, pose.robot.length], 3)
    statics, limit = result.compliance * np.outer(unit, unit), response.compliance[0].real * np.outer(unit, unit)
    assert np.abs(limit - statics).max() <= 1e-9 * np.abs(statics).max() + 1e-30  # a rigid robot has none
    return True


@pytest.mark.few(30)
@pytest.mark.parametrize("rigid", [True, False])
@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("name", package_robots.NAMES)
def test_static_limit_of_sprung_package_robots_is_the_compliance(name, seed, rigid):
    assert_one_tangent(sprung_robots.bundled(name, seed, rigid=rigid))


@pytest.mark.few(20)
@pytest.mark.parametrize("seed", range(50))
def test_static_limit_of_sprung_hybrids_is_the_compliance(seed):
    assert_one_tangent(sprung_robots.hybrid(seed))


@pytest.mark.few(20)
@pytest.mark.parametrize("seed", range(40))
def test_static_limit_of_sprung_random_robots_is_the_compliance(seed):
    rng = np.random.default_rng(seed)
    limbs = list(rng.choice(sr.LIMBS, int(rng.integers(2, 6))))
    while sum(map(sr.wrenches, limbs)) < 6:
        limbs.append(str(rng.choice(sr.LIMBS)))
    assert_one_tangent(sprung_robots.serial(limbs, seed, rigid=bool(rng.integers(2))))


# ---- beams near buckling ---------------------------------------------------------------------------------------------------


def column(share):
    """Return a cantilever whose tip a constant force pulls towards its foot, a share of the load under which it buckles, and the
    lateral stiffness P / L tan kL / (tan kL − kL) of its tip: the foot is a fixed point, so that kL = π at buckling."""
    length, bend = 1.5, sr.E * 4e-7
    section = sr.Section(2e3, 4e-7, 4e-7, 6e-7)  # stiff in tension and shear
    spec = sr.cantilever(length, (0, 0, 1), section=section, y_axis=(0, 1, 0), density=0.0)
    kl, force = np.pi * np.sqrt(share), share * np.pi**2 * bend / length**2
    robot = sr.robot_of(spec)
    pull = Spring("pull", 0.0, robot.description.base, robot.description.platform, (0, 0, 0), (0, 0, 0), 0.0, force)
    pose = ks.Robot(robot.description.with_part(pull)).assemble()
    return pose, force / length * np.tan(kl) / (np.tan(kl) - kl)


@pytest.mark.parametrize("share", [0.3, 0.9, 0.99])
def test_statics_and_response_near_buckling_equal_the_closed_form(share):
    pose, stiffness = column(share)
    result, response = ks.analyze(pose, gravity=(0, 0, 0)), ks.frequency_response(pose, [1e-5], damping=0.0, gravity=(0, 0, 0))
    assert 1 / float(result.compliance[0, 0]) == pytest.approx(stiffness, rel=1e-5)
    assert 1 / float(response.compliance[0, 0, 0].real) == pytest.approx(stiffness, rel=1e-5)


def test_statics_and_modes_are_unstable_beyond_buckling():
    pose, _ = column(1.001)
    assert any("unstable" in text for text in ks.analyze(pose, gravity=(0, 0, 0)).warnings)
    assert ks.modes(pose, 1, gravity=(0, 0, 0)).warnings
