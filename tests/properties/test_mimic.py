"""Joints that follow others (<mimic>): positions and forces against closed forms and against Pinocchio."""

import re
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from package_robots import rates
from places import ROOT

import kinetostatics as ks
from kinetostatics.description import JointStiffness, Mimic
from kinetostatics.files.reader import parse_robot_text

ROD, DISTANCE = 0.5, 0.6

#: Two sliders on one rail, which a belt moves towards one another; their rods carry the platform between them.
BELT = f"""<robot name="belt">
  <link name="ground"/><link name="left"/><link name="right"/><link name="left_rod"/>
  <link name="plate"><inertial><mass value="2"/><inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial></link>
  <joint name="motor" type="prismatic">
    <parent link="ground"/><child link="left"/><axis xyz="1 0 0"/><limit effort="0" velocity="0"/>
  </joint>
  <joint name="belt" type="prismatic">
    <parent link="ground"/><child link="right"/><axis xyz="1 0 0"/><limit effort="0" velocity="0"/>
    <mimic joint="motor" multiplier="{{multiplier}}" offset="{DISTANCE}"/>
  </joint>
  <joint name="left_foot" type="continuous">
    <parent link="left"/><child link="left_rod"/><origin rpy="0 0.9272952180016122 0"/><axis xyz="0 1 0"/>
  </joint>
  <joint name="left_head" type="continuous">
    <parent link="left_rod"/><child link="plate"/><origin xyz="0 0 {ROD}" rpy="0 -0.9272952180016122 0"/><axis xyz="0 1 0"/>
  </joint>
  <platform link="plate"/>
  <loop name="right_foot" type="revolute">
    <predecessor link="right"/><successor link="plate"><origin xyz="0.3 0 -0.4"/></successor><axis xyz="0 1 0"/>
  </loop>
  <transmission name="drive"><joint name="motor"/></transmission>
</robot>"""


def belt(multiplier: float) -> ks.Robot:
    return ks.Robot(parse_robot_text(BELT.replace("{multiplier}", repr(multiplier))))


def height(gap: np.ndarray | float) -> np.ndarray | float:
    """Return the height of the platform above sliders that are ``gap`` apart: both rods have one length."""
    return np.sqrt(ROD**2 - (gap / 2) ** 2)


@pytest.mark.parametrize("multiplier", [-1.0, 0.25, -0.4])
def test_belt_pose_from_its_drive_matches_closed_form(multiplier: float) -> None:
    robot = belt(multiplier)
    assert (robot.mobility.platform, robot.mobility.local, robot.mobility.redundant_constraints) == (1, 0, 3)
    motor = np.linspace(-0.15, 0.2, 9)
    poses = robot.assemble(actuators={"motor": motor})
    right = multiplier * motor + DISTANCE
    np.testing.assert_allclose(poses.frame("right")[:, :3, 3], np.stack([right, 0 * right, 0 * right], -1), atol=1e-15)
    np.testing.assert_allclose(poses.platform["x"], (motor + right) / 2, atol=1e-12)
    np.testing.assert_allclose(poses.platform["z"], height(right - motor), atol=1e-12)
    assert list(poses.actuators) == ["motor"] and poses.residual.max() < 1e-12
    np.testing.assert_array_equal(poses.actuators["motor"], motor)


def test_belt_drive_from_platform_matches_closed_form() -> None:
    robot = belt(0.25)
    x = np.linspace(0.2, 0.45, 6)
    poses = robot.assemble(platform={"x": x})
    motor = (2 * x - DISTANCE) / 1.25
    np.testing.assert_allclose(poses.actuators["motor"], motor, atol=1e-12)
    np.testing.assert_allclose(poses.platform["z"], height(0.25 * motor + DISTANCE - motor), atol=1e-12)
    assert poses.residual.max() < 1e-12
    # sliders that move towards one another lift the platform straight up
    with pytest.raises(ks.exceptions.CoordinatesError, match=r"do not determine.*; z or ry does$"):
        belt(-1.0).assemble(platform={"x": 0.3})
    up = belt(-1.0).assemble(platform={"z": 0.45})
    assert 2 * up.actuators["motor"] == pytest.approx(DISTANCE - 2 * np.sqrt(ROD**2 - 0.45**2), abs=1e-12)
    with pytest.raises(ks.exceptions.CoordinatesError, match="mobility of 'belt' is 1"):
        robot.assemble(platform={"x": 0.3, "z": 0.4})


def test_mismatched_mimic_coordinates_are_refused() -> None:
    robot = belt(-1.0)
    q = np.array(robot.assemble(actuators={"motor": 0.05}).q)
    assert robot.configuration(q).residual < 1e-12
    # move both sliders and so the whole chain: the loop stays closed, but the belt slips
    names = list(robot.model.names)
    for joint in ("motor", "belt"):
        q[robot.model.joints[names.index(joint)].idx_q] += 0.01
    with pytest.raises(ks.AssemblyError, match=r"coupled joints of 'belt' do not fit.*'belt' is 0\.02 m away from .*<mimic>"):
        robot.configuration(q)
    assert robot.configuration(q, on_failure="nan").status == ks.Status.UNREACHABLE
    with pytest.raises(ks.exceptions.CoordinatesError, match="no actuated joint 'belt'"):
        robot.assemble(actuators={"motor": 0.0, "belt": 0.0})


@pytest.mark.parametrize("multiplier", [-1.0, 0.25])
def test_drive_force_includes_loads_of_followers(multiplier: float) -> None:
    """The motor's force is the virtual work of the platform's weight, with the motion of both sliders."""
    rod = '<beam link="left_rod" youngs_modulus="2e11" poisson_ratio="0.3" density="0"><circle diameter="0.02"/></beam></robot>'
    robot = ks.Robot(parse_robot_text(BELT.replace("{multiplier}", repr(multiplier)).replace("</robot>", rod)))
    motor = 0.1
    result = ks.analyze(robot.assemble(actuators={"motor": motor}), gravity=(0, 0, -10))
    gap = (multiplier - 1) * motor + DISTANCE
    rise = -gap / 4 / height(gap) * (multiplier - 1)  # of the platform per metre of the motor
    assert result.actuator_forces == {"motor": pytest.approx(20 * rise, rel=1e-12)}


GRIPPER = """<robot name="gripper">
  <link name="ground"/><link name="tool"/><link name="jaw_1"/><link name="jaw_2"/><link name="screw"/>
  <joint name="wrist" type="continuous">
    <parent link="ground"/><child link="tool"/><origin xyz="0 0 1"/><axis xyz="0 0 1"/>
  </joint>
  <joint name="spindle" type="continuous"><parent link="tool"/><child link="screw"/><axis xyz="1 0 0"/></joint>
  <joint name="left" type="prismatic">
    <parent link="tool"/><child link="jaw_1"/><axis xyz="1 0 0"/><limit effort="0" velocity="0" lower="0" upper="0.05"/>
    <mimic joint="spindle" multiplier="0.002" offset="0.01"/>
  </joint>
  <joint name="right" type="prismatic">
    <parent link="tool"/><child link="jaw_2"/><axis xyz="-1 0 0"/><limit effort="0" velocity="0"/>
    <mimic joint="spindle" multiplier="0.002" offset="0.01"/>
  </joint>
  <platform link="tool"/>
  <transmission name="drives"><joint name="wrist"/><joint name="spindle"/></transmission>
</robot>"""


def test_gripper_jaws_follow_spindle_over_several_turns() -> None:
    robot = ks.Robot(parse_robot_text(GRIPPER))
    assert (robot.mobility.platform, robot.mobility.local) == (1, 1)
    assert robot.assemble().frame("jaw_1")[0, 3] == 0.01
    wrist, spindle = np.meshgrid([0.0, 0.4, -3.0], [0.0, 5.0, 12.0, -20.0])
    poses = robot.assemble(actuators={"wrist": wrist, "spindle": spindle})
    opening = 0.01 + 0.002 * spindle  # of several turns too
    for jaw, sign in (("jaw_1", 1), ("jaw_2", -1)):
        expected = np.stack([sign * opening * np.cos(wrist), sign * opening * np.sin(wrist), np.ones_like(wrist)], axis=-1)
        np.testing.assert_allclose(poses.frame(jaw)[..., :3, 3], expected, atol=1e-15)
    exceeded = poses.limits_exceeded["left"]
    np.testing.assert_array_equal(exceeded.where, (opening < 0) | (opening > 0.05))
    # q determines an angle up to full turns; the jaw may have followed several of them
    assert np.all(robot.configuration(poses.q).status != ks.Status.UNREACHABLE)
    off = np.array(poses.q)
    off[..., robot.model.joints[robot.model.getJointId("left")].idx_q] += 1e-3
    assert np.all(robot.configuration(off).status == ks.Status.UNREACHABLE)


@pytest.mark.parametrize("far", [40, pytest.param(400, marks=pytest.mark.slow)])
def test_gear_follows_motor_over_many_turns(far: float) -> None:
    """Both joints continuous: a platform geared down from a motor, followed over many turns."""
    gear = jack('type="continuous"|<mimic joint="motor" multiplier="-0.3" offset="0.2"/>')
    motor = np.linspace(-far, far, 41)
    angle = 0.2 - 0.3 * motor
    poses = gear.assemble(actuators={"motor": motor})
    np.testing.assert_allclose(poses.frame("l0")[:, 0, :2], np.stack([np.cos(angle), -np.sin(angle)], -1), atol=1e-12)
    angle = np.linspace(-3.1, 3.1, 15)  # takes the motor beyond half a turn both ways
    motor = (0.2 - angle) / 0.3
    poses = gear.assemble(platform={"rz": angle})
    np.testing.assert_allclose(poses.frame("rotor")[:, 0, :2], np.stack([np.cos(motor), -np.sin(motor)], -1), atol=1e-12)
    assert poses.residual.max() < 1e-12


def test_drive_of_two_legs_matches_separate_actuators() -> None:
    """A 3-RPS whose third leg follows the first: the poses are those of three actuators, and the actuator carries both legs."""
    description = ks.files.read_robot_file(ROOT / "robots" / "3rps.urdf.xacro")
    multiplier, offset = -0.4, 0.01
    description_2 = replace(
        description.changed("prismatic_3", mimic=Mimic("prismatic_1", multiplier, offset)),
        actuated=("prismatic_1", "prismatic_2"),
    )
    three, two = ks.Robot(description), ks.Robot(description_2)
    assert (two.mobility.platform, two.mobility.local, two.mobility.redundant_constraints) == (2, 0, 0)
    first, second = np.random.default_rng(1).uniform(-0.03, 0.03, (2, 300))
    poses = two.assemble(actuators={"prismatic_1": first, "prismatic_2": second})
    expected = three.assemble(actuators={"prismatic_1": first, "prismatic_2": second, "prismatic_3": multiplier * first + offset})
    np.testing.assert_allclose(poses.q, expected.q, atol=1e-12)
    assert list(poses.actuators) == ["prismatic_1", "prismatic_2"]
    wanted = {name: expected.platform[name] for name in ("z", "ry")}
    back = two.assemble(platform=wanted)
    np.testing.assert_allclose(back.q, expected.q, atol=1e-9)
    found, free = ks.analyze(poses, (1, 2, 3, 4, 5, 6)), ks.analyze(expected, (1, 2, 3, 4, 5, 6))
    np.testing.assert_allclose(found.twist, free.twist, rtol=1e-9, atol=1e-18)
    forces = free.actuator_forces
    assert list(found.actuator_forces) == ["prismatic_1", "prismatic_2"]
    np.testing.assert_allclose(
        found.actuator_forces["prismatic_1"], forces["prismatic_1"] + multiplier * forces["prismatic_3"], rtol=1e-9
    )
    np.testing.assert_allclose(found.actuator_forces["prismatic_2"], forces["prismatic_2"], rtol=1e-9)


def tree(random: np.random.Generator, kinds: tuple[str, ...], serial: bool) -> str:
    """Return a random robot without loops in which most joints follow the first or the fourth."""
    count, leaders = 8, (0, 3)
    joints = []
    for n in range(count):
        kind = random.choice(kinds)
        origin, turn, axis = (" ".join(repr(float(value)) for value in random.normal(size=3)) for _ in range(3))
        multiplier, offset = (float(value) for value in random.normal(size=2))
        leader = leaders[0] if n < leaders[1] else random.choice(leaders)
        parent = n if serial else random.integers(n + 1)
        joints.append(
            f'<joint name="j{n}" type="{kind}"><parent link="l{parent}"/><child link="l{n + 1}"/>'
            f'<origin xyz="{origin}" rpy="{turn}"/><axis xyz="{axis}"/>'
            + ("" if kind == "continuous" else '<limit effort="0" velocity="0"/>')
            + ("" if n in leaders else f'<mimic joint="j{leader}" multiplier="{multiplier!r}" offset="{offset!r}"/>')
            + "</joint>"
        )
    links = "".join(f'<link name="l{n}"/>' for n in range(count + 1))
    drives = "".join(f'<joint name="j{n}"/>' for n in leaders)
    return (
        f'<robot name="tree">{links}{"".join(joints)}<platform link="l{count}"/>'
        f'<transmission name="drives">{drives}</transmission></robot>'
    )


@pytest.mark.few(2)
@pytest.mark.parametrize("seed", range(6))
def test_random_mimics_agree_with_pinocchio(seed: int) -> None:
    random = np.random.default_rng(seed)
    # Pinocchio's own mimic joints: a follower hangs behind its leader and has coordinates of the same kind.
    own = seed % 2 == 0
    text = tree(random, ("revolute", "prismatic") if own else ("revolute", "prismatic", "continuous"), serial=own)
    robot = ks.Robot(parse_robot_text(text))
    model = pin.buildModelFromXML(text, own)
    assert model.nv == (2 if own else 8)
    data = model.createData()
    values = {name: random.uniform(-3, 3, 5) for name in robot.description.actuated}
    poses = robot.assemble(actuators=values)
    for k in range(5):
        q = pin.neutral(model)
        for name, joint in robot.description.joints.items():
            if not own or name in values:
                mimic = joint.mimic
                value = values[name][k] if mimic is None else mimic.multiplier * values[mimic.joint][k] + mimic.offset
                place = model.joints[model.getJointId(name)]
                q[place.idx_q : place.idx_q + place.nq] = [value] if place.nq == 1 else [np.cos(value), np.sin(value)]
        pin.framesForwardKinematics(model, data, q)
        for link in robot.description.links:
            expected = data.oMf[model.getFrameId(link)].homogeneous
            np.testing.assert_allclose(poses.frame(link)[k], expected, atol=1e-12)


def stiff(robot: ks.Robot, **drives: float) -> ks.Robot:
    description = robot.description
    for name, stiffness in drives.items():
        description = description.with_part(JointStiffness(name, drive=stiffness))
    return ks.Robot(description)


@pytest.mark.few(2)
@pytest.mark.parametrize("seed", range(6))
def test_elastic_actuator_moves_its_followers_by_torque_over_stiffness(seed: int) -> None:
    """Trees of rigid links: every link moves by its Jacobian times −τ/k, and C = J k⁻¹ Jᵀ."""
    random = np.random.default_rng(seed)
    text = tree(random, ("revolute", "prismatic", "continuous"), serial=seed % 2 == 0)
    inertial = (
        '><inertial><origin xyz="0.1 -0.2 0.3"/><mass value="2"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>'
    )
    text = re.sub(r'(<link name="l[3-8]")/>', rf"\1{inertial}</inertial></link>", text)
    springs = {"j0": 3e4, "j3": 5e4}
    robot = stiff(ks.Robot(parse_robot_text(text)), **springs)
    at = dict(zip(springs, random.uniform(-1, 1, 2), strict=True))
    load = {"l8": ks.LinkLoad(random.normal(size=6) * 50), "l4": ks.LinkLoad(random.normal(size=6) * 50)}
    found = ks.analyze(robot.assemble(actuators=at), random.normal(size=6) * 100, loads=load)
    wound_up = [-float(found.actuator_forces[name]) / stiffness for name, stiffness in springs.items()]
    J = rates(robot, at, lambda pose: pose.platform_frame)
    np.testing.assert_allclose(found.twist, J @ wound_up, atol=1e-7 * np.abs(found.twist).max())
    expected = J @ np.diag(1 / np.array(list(springs.values()))) @ J.T
    np.testing.assert_allclose(found.compliance, expected, atol=1e-7 * np.abs(expected).max())
    # without gravity, as contributions of branches on the base leave out their own weight
    found = ks.analyze(robot.assemble(actuators=at), gravity=(0, 0, 0), loads=load)
    wound_up = [-float(found.actuator_forces[name]) / stiffness for name, stiffness in springs.items()]
    for link, parts in found.link_contributions.items():
        twist = sum(parts.values())
        moved = rates(robot, at, lambda pose, link=link: pose.frame(link)) @ wound_up
        np.testing.assert_allclose(twist, moved, atol=1e-7 * np.abs(found.twist).max(), err_msg=link)
    parts = found.source_contributions["actuators"]
    np.testing.assert_allclose(sum(parts.values()), found.twist, atol=1e-10 * np.abs(found.twist).max())
    if seed == 0:
        one, other = (ks.analyze(robot.assemble(actuators=at), engine=engine) for engine in ("compiled", "numpy"))
        np.testing.assert_allclose(one.twist, other.twist, rtol=1e-9)


def test_an_elastic_actuator_couples_the_legs_that_it_moves() -> None:
    """A 3-RPS whose third leg follows the first: as with rigid actuators and both legs longer by the drive's deflection."""
    description = ks.files.read_robot_file(ROOT / "robots" / "3rps.urdf.xacro")
    rigid = ks.Robot(
        replace(description.changed("prismatic_3", mimic=Mimic("prismatic_1", -0.4)), actuated=("prismatic_1", "prismatic_2"))
    )
    at = {"prismatic_1": 0.02, "prismatic_2": -0.01}
    pose, held = stiff(rigid, prismatic_1=3e6).assemble(actuators=at), rigid.assemble(actuators=at)
    load = [300, -200, -500, 10, 20, 30]
    found = ks.analyze(pose, load)
    way = -found.actuator_forces["prismatic_1"] / 3e6
    slides = {"prismatic_1": way, "prismatic_3": -0.4 * way}
    assembly_errors = {
        name: {"twist": [*(size * np.array(description.joints[name].axis)), 0, 0, 0], "frame": "joint"}
        for name, size in slides.items()
    }
    expected = ks.analyze(held, load, assembly_errors=assembly_errors)
    np.testing.assert_allclose(found.twist, expected.twist, rtol=1e-9, atol=1e-15)
    for name, force in found.actuator_forces.items():
        assert force == pytest.approx(expected.actuator_forces[name], rel=1e-9)
    for name, wrench in found.joint_wrenches.items():
        np.testing.assert_allclose(wrench, expected.joint_wrenches[name], rtol=0, atol=1e-8 * 500, err_msg=name)
    corrected = ks.compensate(pose, load)
    there = ks.analyze(pose.robot.assemble(actuators=dict(corrected.actuators), near=pose), load)
    turned = there.configuration.platform_frame[:3, :3] @ pose.platform_frame[:3, :3].T
    np.testing.assert_allclose([turned[2, 1], turned[0, 2]], -there.twist[3:5], atol=2e-6)  # it corrects rx and ry
    assert max(ks.verify(pose, load).differences.values()) < 1e-7


def test_load_on_screw_winds_up_the_motor_beside_it() -> None:
    """The motor carries nothing; the screw that follows it carries the platform; a gear beside it turns along."""
    jacks = stiff(jack(GEAR.format(0.25), SCREW.format(3e-3)), motor=40.0)
    found = ks.analyze(jacks.assemble(actuators={"motor": 2.0}), [0, 0, -700, 0, 0, 0])
    assert found.twist == pytest.approx([0, 0, -700 * 3e-3**2 / 40, 0, 0, 0])
    for link, turned in (("rotor", -700 * 3e-3 / 40), ("l0", -700 * 3e-3 / 40 / 4)):
        assert sum(found.link_contributions[link].values()) == pytest.approx([0, 0, 0, 0, 0, turned])


def test_elastic_actuator_coupling_a_ring_on_base_is_refused() -> None:
    axis = '<axis xyz="0 0 1"/>'
    ring = (
        '<link name="a"/><link name="b"/><joint name="side" type="continuous"><parent link="ground"/><child link="a"/>'
        f'<mimic joint="motor"/>{axis}</joint><joint name="corner" type="continuous"><parent link="a"/><child link="b"/>'
        f'<origin xyz="1 0 0"/>{axis}</joint><loop name="shut" type="cylindrical"><predecessor link="ground">'
        f'<origin xyz="2 0 0"/></predecessor><successor link="b"><origin xyz="1 0 0"/></successor>{axis}</loop>'
        '<joint_stiffness joint="motor" drive="40"/></robot>'
    )
    text = jack(SCREW.format(3e-3)).description.urdf
    with pytest.raises(ks.RobotFileError, match="'motor' moves joints of a closed chain attached to base or platform"):
        _ = ks.Robot(parse_robot_text(text.replace("</robot>", ring))).topology


def jack(*followers: str) -> ks.Robot:
    """Return a motor with a continuous joint, and joints that follow it; the last carries the platform."""
    links = "".join(f'<link name="l{k}"/>' for k in range(len(followers)))
    joints = "".join(
        f'<joint name="f{k}" {kind}><parent link="ground"/><child link="l{k}"/>{rest}<axis xyz="0 0 1"/></joint>'
        for k, (kind, rest) in enumerate(follower.split("|") for follower in followers)
    )
    return ks.Robot(
        parse_robot_text(
            f'<robot name="jack"><link name="ground"/><link name="rotor"/>{links}<joint name="motor" type="continuous">'
            f'<parent link="ground"/><child link="rotor"/><axis xyz="0 0 1"/></joint>{joints}'
            f'<platform link="l{len(followers) - 1}"/><transmission name="t"><joint name="motor"/></transmission></robot>'
        )
    )


GEAR = 'type="continuous"|<mimic joint="motor" multiplier="{}" offset="0.3"/>'
SCREW = 'type="prismatic"|<limit effort="1" velocity="1"/><mimic joint="motor" multiplier="{}" offset="0.02"/>'


def test_gears_together_determine_turns_of_the_motor() -> None:
    """One wheel repeats after two turns of the motor, another after three, both together after six."""
    gears = jack(GEAR.format(0.5), GEAR.format(1 / 3))
    angle = np.array([0.0, 3.5, -9.0, 12.0, 18.0, -18.5])
    poses = gears.assemble(actuators={"motor": angle})
    np.testing.assert_allclose(poses.actuators["motor"], angle, atol=1e-9)
    beyond = gears.assemble(actuators={"motor": angle + 12 * np.pi})
    np.testing.assert_allclose(beyond.actuators["motor"], angle, atol=1e-9)
    np.testing.assert_allclose(beyond.frame("l0"), poses.frame("l0"), atol=1e-12)


def test_screws_on_one_motor_must_agree_on_turns() -> None:
    """Each slide alone fits some number of motor turns; different numbers are refused."""
    jacks = jack(SCREW.format(2e-3), GEAR.format(0.25), SCREW.format(3e-3))
    angle = np.array([0.4, 40.0, -70.0])
    poses = jacks.assemble(actuators={"motor": angle})
    np.testing.assert_allclose(poses.actuators["motor"], angle, atol=1e-9)
    np.testing.assert_allclose(poses.platform["z"], 3e-3 * angle + 0.02, atol=1e-12)
    q = np.array(poses.q[1])
    slide = jacks.model.joints[jacks.model.getJointId("f0")].idx_q
    q[slide] += 2e-3 * 2 * np.pi
    with pytest.raises(ks.AssemblyError, match="do not fit together"):
        jacks.configuration(q)
    held = jacks.assemble(platform={"z": 0.2})
    np.testing.assert_allclose(held.frame("l0")[2, 3], 0.02 + 2e-3 * 0.18 / 3e-3, atol=1e-12)


@pytest.mark.parametrize(("miss", "turns"), [(0.5e-9, 0), (2e-9, 3)])
def test_fewest_turns_are_chosen_among_equal_fits(miss: float, turns: int) -> None:
    """The follower turns by a third of the leader's angle: three turns of the leader are one of it, but for ``miss``."""
    gear = jack(GEAR.format(repr(1 / 3 + miss / (6 * np.pi))))
    pose = gear.assemble(actuators={"motor": 0.3 + 6 * np.pi}, closure_tolerance=1e-8)
    found = gear.configuration(pose.q, closure_tolerance=1e-8)
    assert found.actuators["motor"] == pytest.approx(0.3 + 2 * np.pi * turns, abs=1e-9)
