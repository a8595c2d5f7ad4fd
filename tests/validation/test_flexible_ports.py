"""Links by their matrices, with two to five interfaces: against an independent displacement method, and against beams."""

from dataclasses import replace

import numpy as np
import pytest
from frame_links import Frame
from hub_robots import hub_parts, hub_robot
from linked_frames import LinkedFrame, agrees, alike
from matrix_link import with_flexible
from simple_machines import joint, link, springs
from simple_machines import robot as robot_of

import kinetostatics as ks
from kinetostatics.buckling.estimate import estimate
from kinetostatics.description import Flexible, Joint, Link, LinkMatrices
from kinetostatics.description.elements import Inertia
from kinetostatics.math.rotations import skew

LOAD, GRAVITY, ON_MASS = [10.0, -20.0, -300.0, 4.0, 5.0, 6.0], (0.5, 0.3, -9.81), [100.0, 50.0, 20.0, 1.0, 2.0, 3.0]


def _framed(seed, density=None):
    """Return a random robot whose hub is a frame given by its matrices, the independent answer, and the free masses."""
    rng = np.random.default_rng(seed)
    ports = int(rng.integers(2, 6))
    frame = Frame(seed, ports, inner=int(rng.integers(0, 3)))
    origins = frame.nodes[:ports] - frame.nodes[0]
    parts, names, _, targets = hub_parts(seed, ports, points=origins)
    if density is not None:
        parts = [part.replace('density="7850"', f'density="{density}"') for part in parts]
    hub = Flexible("hub", LinkMatrices(names, origins, **frame.link(modal=bool(seed % 2))[2]))
    robot = ks.Robot(replace(robot_of(*parts).description, flexible={"hub": hub}))
    return (
        robot,
        LinkedFrame(parts, {"hub": (frame, names)}),
        [f"mass_{k}" for k, target in enumerate(targets) if target == "end"],
    )


@pytest.mark.few(10)
@pytest.mark.parametrize("seed", range(300))
def test_random_robots_agree_with_an_independent_frame(seed):
    """Statics under weights and loads on platform and free masses; modes with beams without mass, so that they are exact."""
    robot, frame, masses = _framed(seed)
    loads = dict.fromkeys(masses, ON_MASS)
    found = ks.analyze(robot.assemble(), LOAD, GRAVITY, loads=loads or None)
    moved, wrenches = frame.solve(np.array([LOAD]).T, np.array(GRAVITY), loads)
    agrees(found, frame, moved, wrenches)
    light, frame, _ = _framed(seed, density=0)
    if frame.slenderness > 0.5:  # shorter beams are so stiff that rounding counts
        alike(ks.modes(light.assemble(), 3).frequencies, frame.frequencies(3))


@pytest.mark.few(10)
@pytest.mark.parametrize("seed", range(300))
def test_random_robots(seed):
    """Statics with weights, loads on free masses and an assembly error; all links, or the hub alone, are given by matrices."""
    machine, targets = hub_robot(seed)
    loads = {f"mass_{k}": ON_MASS for k, target in enumerate(targets) if target == "end"}
    given = {"load": LOAD, "gravity": GRAVITY, "assembly_errors": {"head": [1e-4, 0, 2e-4, 1e-3, 0, 0]}, "loads": loads or None}
    expected = ks.analyze(machine.assemble(), **given)
    for names in (None, [name for name in machine.beams if name.startswith("hub")]):
        robot = with_flexible(machine, names, seed)
        assert len(robot.description.flexible["hub_0"].matrices.names) == len(targets)
        found = ks.analyze(robot.assemble(), **given)
        for name in ("twist", "compliance", "base_wrench", "actuator_forces", "joint_wrenches", "contributions"):
            alike(getattr(found, name), getattr(expected, name))
        both = [name for name in expected.link_contributions if name.startswith("mass") or name == "platform"]
        for name in both:
            alike(found.link_contributions[name], expected.link_contributions[name])


@pytest.mark.few(4)
@pytest.mark.parametrize("seed", range(40))
def test_modes(seed):
    """Under a heavy platform, whose modes are far below those of the links, their mass matrices are exact to 1e-9."""
    machine = hub_robot(seed)[0]
    heavy = machine.description.with_payload("weight", "platform", 1e6, inertia=Inertia((1e6, 0.0, 0.0, 1e6, 0.0, 1e6)))
    found, expected = (ks.modes(robot.assemble(), 4).frequencies for robot in (with_flexible(ks.Robot(heavy)), ks.Robot(heavy)))
    alike(found, expected)


def test_functions_and_sensitivities():
    """Compiled results, and sensitivities to the factor of the stiffness, against differences."""
    robot = with_flexible(hub_robot(1)[0])
    pose = robot.assemble()
    compiled = ks.analyze(pose, load=LOAD, gravity=GRAVITY, engine="compiled")
    alike(compiled.twist, ks.analyze(pose, load=LOAD, gravity=GRAVITY, engine="numpy").twist, 1e-11)
    name, step = "hub_0.stiffness_factor", 1e-4
    sensitivity = ks.sensitivities(pose, by=[name], outputs=["twist"], load=LOAD, gravity=GRAVITY)[name]
    descriptions = [robot.description.changed("hub_0", stiffness_factor=1 + change) for change in (step, -step)]
    twists = [ks.analyze(ks.Robot(changed).assemble(), load=LOAD, gravity=GRAVITY).twist for changed in descriptions]
    alike(sensitivity.derivatives["twist"], (twists[0] - twists[1]) / (2 * step), 1e-6)


@pytest.mark.parametrize("seed", [1, 5, 8])
def test_heat(seed):
    """A link that expands evenly is loaded by its stiffness times the free expansion, as all beams of its frame are."""
    machine, alpha = hub_robot(seed)[0], 1.2e-5
    hubs = [name for name in machine.beams if name.startswith("hub")]
    description = machine.description
    for name in hubs:
        description = description.changed(name, thermal_expansion=alpha)
    robot = with_flexible(machine, hubs, seed)
    part = robot.description.flexible["hub_0"]
    free = np.zeros(len(part.matrices.stiffness))
    for k, axes in enumerate(part.matrices.rotations):
        joint_at = machine.mechanism.connections[part.matrices.names[k]].centre_on("hub")
        free[6 * k : 6 * k + 3] = axes.T @ (alpha * (joint_at - machine.mechanism.body_of["hub"][1][:3, 3]))
    heated = replace(part.matrices, thermal=part.matrices.stiffness @ free)
    robot = ks.Robot(robot.description.changed("hub_0", matrices=heated))
    found = ks.analyze(robot.assemble(), assembly_errors={"hub_0": {"temperature": 25.0}})
    expected = ks.analyze(ks.Robot(description).assemble(), assembly_errors={name: {"temperature": 25.0} for name in hubs})
    alike(found.twist, expected.twist)
    alike(found.joint_wrenches, expected.joint_wrenches)
    assert "hub_0.error.temperature" in str(ks.tolerances(robot.assemble(), {"hub_0.error.temperature": 5.0}).report())


LINEAR, ANGULAR = (4e6, 3e6, 9e6), (8e3, 5e3, 2e4)


def _soft(*, jointed):
    """Return a robot with a hub that is rigid, with elastic joints at two of its ports, or has the matrices of both."""
    parts, _, points, _ = hub_parts(3, ports=3, kinds=("platform",))
    text = "".join(parts).replace('<link name="hub"/>', link("hub", 20.0, "0.2 0.05 0.1"))
    values = {key: " ".join(map(str, value)) for key, value in (("linear", LINEAR), ("angular", ANGULAR))}
    soft = []
    for k in (1, 2):
        text = text.replace(f'<parent link="hub"/><child link="leg_{k}"/>', f'<parent link="tip_{k}"/><child link="leg_{k}"/>')
        xyz = " ".join(f"{number:.17g}" for number in points[k])
        text = text.replace(f'xyz="{xyz}"', 'xyz="0 0 0"')
        soft += [link(f"tip_{k}"), joint(f"soft_{k}", "fixed", "hub", f"tip_{k}", xyz)]
        soft += [springs(f"soft_{k}", **values)] * jointed
    stay = '<predecessor link="base"><origin xyz="0.1 0 1"/></predecessor><successor link="platform"/>'
    machine = robot_of(text, *soft, f'<spring name="stay" stiffness="900" free_length="0.1">{stay}</spring>')
    if jointed:
        return machine
    K, M = np.zeros((2, 18, 18))
    for k in (1, 2):
        relative = np.zeros((6, 18))
        relative[:, :6], relative[:, 6 * k : 6 * k + 6] = -np.eye(6), np.eye(6)
        relative[:3, 3:6] = skew(points[k])
        K += relative.T @ np.diag([*LINEAR, *ANGULAR]) @ relative
    hub = machine.description.links["hub"]
    arm = skew(np.array(hub.center_of_mass))
    M[:6, :6] = np.block([[hub.mass * np.eye(3), -hub.mass * arm], [hub.mass * arm, hub.inertia.matrix - hub.mass * arm @ arm]])
    matrices = LinkMatrices(("head", "soft_1", "soft_2"), points, K, M)
    return ks.Robot(replace(machine.description, flexible={"hub": Flexible("hub", matrices)}))


def test_second_order_and_modes():
    """A rigid link with elastic joints at two ports, as matrices, gives the same results, also those of second order."""
    poses = [_soft(jointed=jointed).assemble() for jointed in (False, True)]
    found, expected = (ks.analyze(pose, load=LOAD, gravity=GRAVITY) for pose in poses)
    for name in ("twist", "compliance", "contributions"):
        alike(getattr(found, name), getattr(expected, name))
    alike(*(ks.modes(pose, 4).frequencies for pose in poses))
    poses = [ks.Robot(replace(pose.robot.description, springs={})).assemble() for pose in poses]
    found, expected = (ks.analyze(pose, load=LOAD, gravity=GRAVITY) for pose in poses)
    assert np.abs(expected.second_order.twist / expected.twist - 1).max() > 1e-6
    alike(found.second_order.twist, expected.second_order.twist)
    alike(found.second_order.compliance, expected.second_order.compliance)


def test_internal_coordinates_of_a_frame():
    """A link with inner nodes, whose displacements or modes are internal coordinates, vibrates in the same way."""
    frame = Frame(seed=8, ports=3, inner=2)
    points, frequencies = frame.nodes[:3] - frame.nodes[0], []
    parts, names, _, _ = hub_parts(5, ports=3, points=points)
    for modal in (False, True):
        part = Flexible("hub", LinkMatrices(names, points, **frame.link(modal)[2]))
        description = replace(robot_of(*parts).description, flexible={"hub": part})
        frequencies.append(ks.modes(ks.Robot(description).assemble(), 25).frequencies)
    assert np.all(np.isfinite(frequencies))
    alike(*frequencies)


def _with_plate(robot):
    """Return a robot whose platform is a plate of springs below a rigid link at o, and the plate's matrices."""
    description = robot.description
    plate, body = description.platform, robot.mechanism.body_of[description.platform][1]
    free = [name for name, part in description.joints.items() if part.type == "floating"]
    names = [part.name for part in robot.mechanism.at_link[plate] if part.name not in free]
    frame = Frame(seed=4, ports=len(names) + 1, inner=0)
    at = [body[:3, :3].T @ (robot.mechanism.connections[name].centre_on(plate) - body[:3, 3]) for name in names]
    stiffness = np.zeros((6 * len(names) + 6,) * 2)
    for k, point in enumerate(at):  # springs between o and each joint, and from joint to joint
        for first, second in ((k, len(at)), (k, (k + 1) % len(at))):
            ends = np.zeros((6, len(stiffness)))
            shift = point - (np.zeros(3) if second == len(at) else at[second])
            ends[:, 6 * first : 6 * first + 6] = np.eye(6)
            ends[:, 6 * second : 6 * second + 6] = -np.block([[np.eye(3), -skew(shift)], [np.zeros((3, 3)), np.eye(3)]])
            stiffness += 1e-3 * ends.T @ frame.K[:6, :6] @ ends
    matrices = LinkMatrices((*names, "tip"), [*at, np.zeros(3)], stiffness)
    joints = {name: replace(part, child="o") if part.child == plate else part for name, part in description.joints.items()}
    part = Flexible(plate, matrices)
    links, joints = {**description.links, "o": Link("o")}, {**joints, "tip": Joint("tip", "fixed", "o", plate)}
    return ks.Robot(replace(description, links=links, joints=joints, platform="o", flexible={plate: part})), matrices


@pytest.mark.parametrize("name", ["3rps", "linear_delta"])
def test_elastic_platform(name):
    """C = C_rigid + Jᵀ F J: J are the wrenches at the plate's joints per unit load, F its flexibility with o held."""
    rigid = ks.load_robot(name)
    soft, matrices = _with_plate(rigid)
    pose = rigid.assemble()
    unit = ks.analyze(pose, load=np.eye(6), gravity=(0, 0, 0))
    R, wrenches = pose.frame("platform")[:3, :3], []
    for joint_name in matrices.names[:-1]:
        wrench = unit.joint_wrenches[joint_name]
        wrenches += [wrench[:, :3] @ R, wrench[:, 3:] @ R]
    J = np.concatenate(wrenches, axis=1).T
    expected = unit.compliance[0] + J.T @ matrices.flexibility("tip") @ J
    found = ks.analyze(soft.assemble(), load=LOAD, gravity=(0, 0, 0)).compliance
    assert np.abs(found - unit.compliance[0]).max() > 1e-3 * np.abs(found).max()
    alike(found, expected)
    assert [limb.name for limb in soft.topology.limbs] == ["limb_1"]


@pytest.mark.few(6)
@pytest.mark.parametrize("name", ["3rps", "linear_delta", *range(16)])
def test_the_estimate_that_excludes_buckling_is_three_times_the_ratio(name):
    """Robots with an elastic platform, and hubs of random links."""
    robot = with_flexible(hub_robot(name)[0], None, name) if isinstance(name, int) else _with_plate(ks.load_robot(name))[0]
    loads = np.random.default_rng(1).standard_normal((5, 6)) * [1, 1, 1, 0.3, 0.3, 0.3]
    result = ks.analyze(robot.assemble(), 30 * loads, (0, 0, 0))
    [solution] = result.solutions
    estimates = estimate(robot.members.structure, solution)
    assert np.all(np.isfinite(estimates))
    assert np.all(estimates * result.buckling(1).load_factors[:, 0] > 3)


def test_what_is_refused():
    parts, names, points, _ = hub_parts(3, ports=3, kinds=("platform",))
    frame = Frame(seed=1, ports=3, inner=0)
    K = LinkMatrices(names, frame.nodes, frame.link()[2]["stiffness"], rotations=frame.rotations)
    description = robot_of(*parts).description
    part = Flexible("hub", K)
    for other, name in ((0, "its ends 'head' and 'port_2'"), (1, "its interfaces 'port_1' and 'port_2'")):
        at_one_point = hub_parts(3, ports=3, kinds=("platform",), points=points[[0, 1, other]])[0]
        with pytest.raises(ks.RobotFileError, match=f"{name} are the same point"):
            _ = ks.Robot(replace(robot_of(*at_one_point).description, flexible={"hub": part})).topology
    assert ks.Robot(replace(description, flexible={"hub": part})).topology.spans.keys() >= {"hub", "hub/2"}
