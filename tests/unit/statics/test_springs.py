"""Springs and counterweights: balanced machines, stiffness, energy, contributions, stability, files."""

import re
from dataclasses import replace

import numpy as np
import pytest
import simple_machines as sm
from package_robots import generic_pose, rigid_links, robot

import kinetostatics as ks
from kinetostatics.checks.check import diagnose
from kinetostatics.description import Spring
from kinetostatics.files.reader import parse_robot_text
from kinetostatics.statics.springs import placed_springs

MASS, LENGTH, HEIGHT, ARM, G = 8.0, 0.4, 0.5, 0.3, 9.81
BALANCE = MASS * G * LENGTH / (HEIGHT * ARM)
SPRING = f"""<spring name="balance" stiffness="{BALANCE}" free_length="0">
<predecessor link="ground"><origin xyz="0 0 {HEIGHT}"/></predecessor>
<successor link="arm"><origin xyz="{ARM} 0 0"/></successor></spring>"""


def pendulum(more=SPRING):
    """Return an arm along x on an actuated hinge about y, with a mass at its end."""
    return f"""<robot name="pendulum"><link name="ground"/><link name="arm"/>
<link name="tip"><inertial><mass value="{MASS}"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
<joint name="hinge" type="revolute"><parent link="ground"/><child link="arm"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="0" velocity="0"/></joint>
<joint name="weld" type="fixed"><parent link="arm"/><child link="tip"/><origin xyz="{LENGTH} 0 0"/></joint>
<platform link="tip"/><transmission name="d"><joint name="hinge"/></transmission>
<joint_stiffness joint="hinge" drive="1e4"/>{more}</robot>"""


def loaded(text):
    return ks.Robot(parse_robot_text(text))


ANGLES = np.linspace(-1.2, 1.2, 7)


@pytest.mark.parametrize(
    "more",
    [SPRING, f'<counterweight name="weight" link="arm" mass="{4 * MASS}"><origin xyz="{-LENGTH / 4} 0 0"/></counterweight>'],
    ids=["spring", "counterweight"],
)
def test_a_balanced_pendulum_needs_no_torque_at_any_angle(more):
    """k a b = m g l with a spring of no free length; or a counterweight of the same first moment."""
    pose = loaded(pendulum(more)).assemble(actuators={"hinge": ANGLES})
    result = ks.analyze(pose)
    unbalanced = ks.analyze(loaded(pendulum("")).assemble(actuators={"hinge": ANGLES})).actuator_forces["hinge"]
    np.testing.assert_allclose(unbalanced, -MASS * G * LENGTH * np.cos(ANGLES), rtol=1e-12)
    np.testing.assert_allclose(result.actuator_forces["hinge"], 0, atol=1e-12)
    np.testing.assert_allclose(result.joint_wrenches["hinge"][..., 3:], 0, atol=1e-12)
    np.testing.assert_allclose(result.twist, 0, atol=1e-14)
    if "spring" in more:
        np.testing.assert_allclose(sum(result.contributions.values()), 0, atol=1e-14)
        spans = np.stack([ARM * np.cos(ANGLES), -ARM * np.sin(ANGLES) - HEIGHT], axis=-1)
        np.testing.assert_allclose(result.spring_forces["balance"], BALANCE * np.linalg.norm(spans, axis=-1), rtol=1e-12)
        # the ground carries spring and hinge: together the weight
        np.testing.assert_allclose(result.base_wrench[..., :3], np.broadcast_to([0, 0, MASS * G], (7, 3)), atol=1e-10)


#: With the spring of the pendulum, turned up by φ, the energy is −k a b sin φ; that of the weight m g l sin φ.
HARDER = SPRING.replace(f'stiffness="{BALANCE}"', f'stiffness="{3 * BALANCE}"')


@pytest.mark.parametrize(("more", "times"), [(SPRING, 0), (HARDER, 2)], ids=["balanced", "pulled up"])
def test_pendulum_stiffness_is_second_derivative_of_energy(more, times):
    """d + (k a b − m g l) sin φ: the balanced one is in neutral equilibrium; without gravity the spring's part remains."""
    pose = loaded(pendulum(more)).assemble(actuators={"hinge": -ANGLES})
    turned = MASS * G * LENGTH * np.sin(ANGLES)
    for gravity, part in (((0, 0, -G), times), ((0, 0, 0), times + 1)):
        result = ks.analyze(pose, gravity=gravity)
        np.testing.assert_allclose(1 / result.compliance[:, 4, 4], 1e4 + part * turned, rtol=1e-9)
        np.testing.assert_allclose(result.actuator_forces["hinge"], -1e4 * result.twist[:, 4], rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("angle", [np.pi - 1e-4, 1e-4 - np.pi])
def test_drive_correction_takes_the_short_way_across_half_turn(angle):
    """The correction is M / k for an arm near half a turn, on a continuous actuator."""
    text = (
        pendulum("")
        .replace('type="revolute"', 'type="continuous"')
        .replace('<limit lower="-3" upper="3" effort="0" velocity="0"/>', "")
    )
    found = ks.compensate(loaded(text).assemble(actuators={"hinge": angle}), controlled=("z",))
    assert abs(float(found.corrections["hinge"])) == pytest.approx(MASS * G * LENGTH / 1e4, rel=1e-3)


def test_effects_of_errors_exclude_the_spring_tension():
    """Spring, weight and actuator share an error of the hinge's angle; the spring's tension is no error."""
    found = ks.tolerances(loaded(pendulum(HARDER)).assemble(actuators={"hinge": -0.6}))
    row, amount = found.effects["hinge.error.ry"], found.parameters["hinge.error.ry"].tolerance
    stiffness = 2 * MASS * G * LENGTH * np.sin(0.6)
    turn = amount * 1e4 / (1e4 + stiffness)
    assert row.rotation == pytest.approx(turn, rel=1e-10) and row.displacement == pytest.approx(turn * LENGTH, rel=1e-10)
    assert abs(row.actuator_forces["hinge"]) == pytest.approx(stiffness * turn, rel=1e-9)


def pose(name, *springs):
    """A pose without symmetry of a robot with springs."""
    description = robot(name).description
    for spring in springs:
        description = description.with_part(spring)
    return generic_pose(name, description)


BESIDE = Spring("beside", 4e6, "base", "platform", (0.3, 0.1, 0.0), (0.0, 0.05, 0.02), free_length=0.2, preload=40.0)


def test_relaxed_spring_adds_its_stiffness_along_its_line():
    bare = pose("3rps")
    points = {"base": BESIDE.predecessor_point, "platform": BESIDE.successor_point}
    ends = [bare.frame(link)[:3, :3] @ np.array(point) + bare.frame(link)[:3, 3] for link, point in points.items()]
    length, arm = np.linalg.norm(ends[1] - ends[0]), ends[1] - bare.platform_frame[:3, 3]
    n, load, still = (ends[1] - ends[0]) / length, np.array([300.0, -200, 500, 20, -10, 30]), (0, 0, 0)
    at = pose("3rps", replace(BESIDE, free_length=float(length), preload=0.0))
    found, without = ks.analyze(at, load, still), ks.analyze(bare, load, still)
    along = np.append(n, np.cross(arm, n))
    K = without.stiffness + 4e6 * np.outer(along, along)
    unit = np.repeat([1.0, at.robot.length], 3)
    np.testing.assert_allclose(found.stiffness / np.outer(unit, unit), K / np.outer(unit, unit), rtol=1e-9, atol=1e-9 * K[0, 0])
    np.testing.assert_allclose(found.twist, np.linalg.solve(K, load), rtol=1e-8)
    assert float(np.abs(found.twist - without.twist).max()) > 1e-3 * float(np.abs(without.twist).max())


def test_work_of_load_is_strain_plus_spring_energy():
    """Clapeyron, with a spring that is relaxed at the pose; its work is ½ k (n·u)²."""
    spring = replace(BESIDE, predecessor="base", successor=rigid_links(robot("3rps"))[-1], preload=0.0)
    length = float(placed_springs(pose("3rps", spring).robot.statics, pose("3rps", spring).frames)[0].length[0])
    at = pose("3rps", replace(spring, free_length=length))
    (placed,) = placed_springs(at.robot.statics, at.frames)
    load = np.array([300.0, -200, 500, 20, -10, 30])
    found = ks.analyze(at, load, (0, 0, 0), loads={"platform": [0, 0, 0, 0, 0, 0]})
    twist = found.link_contributions[spring.successor]["load"]
    end = placed.points[1][:, 0] - at.frame(spring.successor)[:3, 3]
    moved = twist[:3] + np.cross(twist[3:], end)
    n = (placed.points[1] - placed.points[0])[:, 0] / length
    stored = 0.5 * spring.stiffness * float(n @ moved) ** 2
    assert float(found.strain_energy) + stored == pytest.approx(0.5 * float(load @ found.twist), rel=1e-9)
    np.testing.assert_allclose(found.compliance @ load, found.twist, rtol=1e-9)
    np.testing.assert_allclose(found.compliance, found.compliance.T, rtol=1e-12, atol=1e-20)


@pytest.mark.few(1)
@pytest.mark.parametrize("name", ["2pru_upr", "delta"])
def test_contributions_with_springs_between_any_links_add_up(name):
    """Springs between base and platform, base and a limb, a limb and the platform, two limbs; with networks and telescopes."""
    links = rigid_links(robot(name))
    ends = [("base", "platform"), ("base", links[-1]), (links[0], "platform"), (links[0], links[-1])]
    springs = [
        Spring(f"spring_{k}", 1e5 * (k + 1), *pair, (0.01, 0, 0.02), (0, 0.03, 0), free_length=0.1 * k, preload=5.0 * k)
        for k, pair in enumerate(ends)
    ]
    at = pose(name, *springs)
    result = ks.analyze(at, load=[10, 20, -30, 1, 2, 3], payload=ks.Payload(3.0, (0.1, 0, 0)))
    np.testing.assert_allclose(sum(result.contributions.values()), result.twist, rtol=1e-9)
    np.testing.assert_allclose(sum(result.by_mechanism.contributions.values()), result.twist, rtol=1e-7, atol=1e-15)
    parts = sum(part for kind in result.source_contributions.values() for part in kind.values())
    np.testing.assert_allclose(parts, result.twist, rtol=1e-8, atol=1e-13)
    payload = result.payload_coefficients.twist @ [3.0, 0.3, 0, 0]
    np.testing.assert_allclose(payload, result.contributions["payload"], rtol=1e-9, atol=1e-16)


def test_batch_of_sprung_poses_equals_single_analyses():
    one = loaded(pendulum(SPRING.replace('free_length="0"', 'free_length="0.1" preload="12"')))
    batch = ks.analyze(one.assemble(actuators={"hinge": ANGLES}))
    for k, angle in enumerate(ANGLES):
        alone = ks.analyze(one.assemble(actuators={"hinge": angle}))
        np.testing.assert_allclose(batch.twist[k], alone.twist, rtol=1e-9, atol=1e-18)


def test_springs_and_counterweights_survive_writing_and_reading():
    text = pendulum(SPRING + '<counterweight name="weight" link="arm" mass="2"><origin xyz="-0.1 0 0"/></counterweight>')
    description = parse_robot_text(text)
    assert description.springs["balance"] == Spring("balance", BALANCE, "ground", "arm", (0, 0, HEIGHT), (ARM, 0, 0))
    assert description.links["weight"].mass == 2 and description.joints["weight_mount"].origin.xyz == (-0.1, 0, 0)
    again = parse_robot_text(description.urdf)
    assert again == description
    softer = description.changed("balance", stiffness=100.0)
    assert softer.springs["balance"].stiffness == 100 and softer != description


def test_preloaded_spring_without_length_raises_an_error():
    text = pendulum(SPRING.replace(f'<origin xyz="0 0 {HEIGHT}"/>', f'<origin xyz="{ARM} 0 0"/>'))
    np.testing.assert_allclose(ks.analyze(loaded(text).assemble()).spring_forces["balance"], 0, atol=1e-12)
    with pytest.raises(ks.StaticsError, match="the spring 'balance' has no length at this pose"):
        ks.analyze(loaded(text.replace('free_length="0"', 'free_length="0" preload="5"')).assemble())


def test_implausible_springs_are_reported():
    """A free length in mm, and an end in the middle of a rod."""
    long = loaded(pendulum(SPRING.replace('free_length="0"', 'free_length="150"')))
    said = r"free length of spring 'balance' is 150 m, .* lengths are in m; write 0.15 for 150 mm"
    for warned in (diagnose(long).warnings, ks.analyze(long.assemble(), on_failure="nan").warnings):
        assert any(re.search(said, item) for item in warned)
    assert not any("free length" in item for item in ks.analyze(loaded(pendulum()).assemble()).warnings)
    rod = '<beam link="arm" youngs_modulus="70e9" poisson_ratio="0.3" density="2700"><circle diameter="0.02"/></beam>'
    with pytest.raises(ks.ArgumentError, match=r"^<text>:\d+: spring 'balance': 'arm' is elastic, and \(0.3, 0, 0\) is no end"):
        ks.analyze(loaded(pendulum(rod + SPRING)).assemble())


def test_sagging_jib_slackens_the_spring_on_its_tip():
    """t (1/k + c + 1/d) = m g / d − δ, with δ = q L⁴/8EI and c = L³/3EI of the jib, d of the actuator; the spring is relaxed."""
    L, d, k, mass = 0.9, 3e4, 2e4, 6.0
    one = sm.robot(
        sm.link("mast"), sm.link("jib"), sm.link("cage", mass), sm.link("tip"), sm.joint("root", "fixed", "mast", "jib"),
        sm.joint("end", "fixed", "jib", "tip", f"{L} 0 0"), sm.bar("jib", "root", "end", sm.RHO, '<circle diameter="0.02"/>'),
        sm.joint("lift", "prismatic", "mast", "cage", f"{L} 0 -0.5", "0 0 1"), sm.springs("lift", drive=d),
        '<transmission name="d"><joint name="lift"/></transmission>', f'<spring name="rope" stiffness="{k}" free_length="0.5">',
        '<predecessor link="tip"/><successor link="cage"/></spring>', platform="cage",
    )  # fmt: skip
    found = ks.analyze(one.assemble())
    EI, q = sm.E * np.pi * 0.02**4 / 64, sm.RHO * np.pi * 0.02**2 / 4 * G
    tension = (mass * G / d - q * L**4 / (8 * EI)) / (1 / k + L**3 / (3 * EI) + 1 / d)
    assert float(found.twist[2]) == pytest.approx(-(mass * G - tension) / d, rel=1e-9)
    assert float(found.actuator_forces["lift"]) == pytest.approx(mass * G - tension, rel=1e-9)
    assert float(found.joint_wrenches["root"][2]) == pytest.approx(tension + q * L, rel=1e-9)
    np.testing.assert_allclose(sum(found.contributions.values()), found.twist, rtol=1e-12, atol=1e-18)


def test_contributions_by_mechanism_agree_for_errors_with_springs():
    at = pose("delta", replace(BESIDE, successor="elbow_1"))
    found = ks.analyze(at, assembly_errors={at.robot.description.actuated[0]: [1e-4, 0, 2e-4, 1e-4, 0, 0]})
    parts = found.by_mechanism.contributions
    np.testing.assert_allclose(parts["assembly_errors"], found.contributions["assembly_errors"], rtol=1e-9, atol=1e-15)
    np.testing.assert_allclose(sum(parts.values()), found.twist, rtol=1e-9, atol=1e-15)


@pytest.mark.parametrize(("push", "unstable"), [(0.99, False), (1.01, True)])
def test_spring_force_beyond_critical_makes_the_pose_unstable(push, unstable):
    """A drive of k on an arm of l below a constant force F, straight above its tip at a distance h: k = F l (1 + l/h) + m g l."""
    F = (push * 1e4 - MASS * G * LENGTH) / (LENGTH * (1 + LENGTH / 0.6))
    text = f"""<spring name="press" stiffness="0" free_length="0" preload="{-F}">
<predecessor link="ground"><origin xyz="{LENGTH} 0 0.6"/></predecessor><successor link="tip"/></spring>"""
    text = (
        pendulum(text)
        .replace(f'<origin xyz="{LENGTH} 0 0"/>', f'<origin xyz="0 0 {LENGTH}"/>')
        .replace(f'xyz="{LENGTH} 0 0.6"', f'xyz="0 0 {LENGTH + 0.6}"')
    )
    found = ks.analyze(loaded(text).assemble(actuators={"hinge": 0.0}))
    said = "the pose is unstable: springs and weights overcome the stiffness of the platform"
    assert any(said in item for item in found.warnings) == unstable
    assert bool(found.compliance[4, 4] < 0) == unstable


@pytest.mark.parametrize(("angle", "words"), [(0.0, None), (-1.5, "-3.1 %"), (1.5, r"\+3.1 %")])
def test_stiffness_change_by_weights_is_warned_from_one_percent(angle, words):
    """m g l sin φ relative to the actuator: softer standing, stiffer hanging. Linear theory omits it and warns from 1 %."""
    text = pendulum("").replace('drive="1e4"', 'drive="1e3"')
    found = ks.analyze(loaded(text).assemble(actuators={"hinge": angle}))
    assert float(found.compliance[4, 4]) == pytest.approx(1e-3, rel=1e-9)
    said = [item for item in found.warnings if "the forces change the stiffness" in item]
    assert len(said) == (words is not None) and all(re.search(f"rotation about the axis .* by {words}", item) for item in said)


def test_spring_without_length_fails_only_its_own_pose():
    """A spring along an actuated slide: at zero length its force has no direction."""
    one = sm.robot(
        sm.link("ground"), sm.link("platform"), sm.joint("slide", "prismatic", "ground", "platform", axis="1 0 0"),
        '<transmission name="d"><joint name="slide"/></transmission><spring name="s" stiffness="100" free_length="0.1">',
        '<predecessor link="ground"/><successor link="platform"/></spring>',
    )  # fmt: skip
    with pytest.raises(ks.StaticsError, match="'s' has no length at this pose"):
        ks.analyze(one.assemble(actuators={"slide": 0.0}))
    found = ks.analyze(one.assemble(actuators={"slide": one.length * np.array([0.0, 1e-11, 1e-7, 0.5])}))
    assert found.status.tolist() == [ks.Status.SINGULAR, ks.Status.SINGULAR, ks.Status.OK, ks.Status.OK]
    np.testing.assert_allclose(found.actuator_forces["slide"], [np.nan, np.nan, -10.0, 100 * (one.length / 2 - 0.1)], rtol=1e-6)
    assert not any("length" in text for text in one.warnings)


def test_springs_at_the_inner_end_of_telescopic_beams_are_refused_on_loading():
    """There is an end at this pose only; at the outer end the spring is accepted, and reports are written at any pose."""
    legs = robot("3rps")
    beam, pose = legs.description.beams["rod_1"], legs.assemble()
    frame, points = pose.frame(beam.link), ks.analyze(pose).beams["rod_1"].points
    inner, outer = (tuple(map(float, frame[:3, :3].T @ (point - frame[:3, 3]))) for point in (points[0], points[-1]))
    sprung = [legs.description.with_part(Spring("s", 100.0, "base", "rod_1", (0.1, 0.2, 0.0), end)) for end in (inner, outer)]
    with pytest.raises(ks.RobotFileError) as error:
        ks.Robot(sprung[0])
    assert str(error.value) == (
        "<python>: the spring 's' ends on 'rod_1' where no end of its beam moves with it: put it at (0.0, 0.0, 0.0) of its "
        "frame, or on 'cylinder_1'"
    )
    high = ks.Robot(sprung[1]).assemble(platform={"z": 0.55, "rx": 0.0, "ry": 0.0})
    assert "spring" in str(ks.analyze(high).report()) and ks.analyze(high).warnings == ()
    on_cylinder = legs.description.with_part(Spring("s", 100.0, "base", "cylinder_1", (0.1, 0.2, 0.0)))
    assert np.all(np.isfinite(ks.analyze(ks.Robot(on_cylinder).assemble()).twist))
