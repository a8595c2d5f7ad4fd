"""Elastic platforms and bases: against an independent displacement method, as links beside rigid ones, and against beams."""

import shutil
from dataclasses import replace
from functools import partial

import linked_frames
import numpy as np
import pytest
from calculix_decks import bore_lines, displacements, solid_lines
from frame_links import Frame
from hub_robots import hub_parts
from linked_frames import LinkedFrame, agrees
from matrix_link import as_matrices
from simple_machines import BEAM, CIRCLE, joint, link
from simple_machines import robot as robot_of

import kinetostatics as ks
from kinetostatics.description import Flexible, Joint, Link, LinkMatrices, Origin
from kinetostatics.math.rotations import skew

LOAD, GRAVITY, ON_MASS = [10.0, -20.0, -300.0, 4.0, 5.0, 6.0], (0.5, 0.3, -9.81), [100.0, 50.0, 20.0, 1.0, 2.0, 3.0]

alike = partial(linked_frames.alike, same_names=False)


# ---- random robots -------------------------------------------------------------------------------------------------------


def _framed(seed, density=7850):
    """Return a random robot with hub, platform and base given by matrices, some of them rigid, its answer, and free masses."""
    rng = np.random.default_rng(seed)
    ports = int(rng.integers(2, 6))
    hub = Frame(seed, ports, inner=int(rng.integers(0, 3)))
    parts, names, _, targets = hub_parts(seed, ports, points=hub.nodes[:ports] - hub.nodes[0])
    parts = [part.replace('density="7850"', f'density="{density}"') for part in parts]
    joints, frames, flexible, o = LinkedFrame(parts, {}).joints, {"hub": (hub, names)}, {}, np.zeros(3)
    elastic = [("platform",), ("base",), ("base", "platform")][seed % 3]
    for k, name in enumerate(elastic):
        at = {part.get("name"): point for part, *links, point in joints if name in links}
        origin = at["far_1"] if name == "platform" else np.zeros(3)
        at = {joint_name: point - origin for joint_name, point in at.items()}
        if len(at) < 2 or rng.random() < 0.5:  # else o is at the first joint
            at["o"] = rng.uniform(-0.2, 0.2, 3) if name == "platform" else np.zeros(3)
        order = [list(at)[j] for j in rng.permutation(len(at))]
        if "o" not in at and name == "platform":
            order.sort(key=lambda joint_name: joint_name != "far_1")
        frames[name] = Frame(seed + 1000 * (k + 1), len(order), 1, [at[joint_name] for joint_name in order]), order
        o = at.get("o", o) if name == "platform" else o
    for name, (frame, order) in frames.items():
        origins = frame.nodes[: len(order)] - (frame.nodes[0] if name == "hub" else 0.0)
        flexible[name] = Flexible(name, LinkMatrices(order, origins, **frame.link(modal=bool(seed % 2))[2]))
    o = Origin(tuple(o.tolist()))
    description = replace(robot_of(*parts).description, flexible=flexible, platform_origin=o)
    masses = [f"mass_{k}" for k, target in enumerate(targets) if target == "end"]
    return ks.Robot(description), LinkedFrame(parts, frames), masses


@pytest.mark.few(9)
@pytest.mark.parametrize("seed", range(300))
def test_random_robots_agree_with_an_independent_frame(seed):
    """Twist and its contributions, forces, wrenches and modes, with loads on platform and free masses."""
    robot, frame, masses = _framed(seed)
    loads = dict.fromkeys(masses, ON_MASS)
    found = ks.analyze(robot.assemble(), LOAD, GRAVITY, loads=loads or None)
    moved, wrenches = frame.solve(np.array([LOAD]).T, np.array(GRAVITY), loads)
    agrees(found, frame, moved, wrenches)
    alike(sum(found.contributions.values()), found.twist, 1e-12)
    none, one = np.zeros((6, 1)), np.abs(found.twist).max()
    for name in ("platform", "base"):
        if name in frame.inside:
            part = frame.platform(frame.solve(none, np.array(GRAVITY), only=name)[0])[:, 0]
            assert np.abs(found.contributions[f"{name}_weight"] - part).max() <= 1e-9 * one
    for name in masses:
        part = frame.platform(frame.solve(none, np.zeros(3), {name: ON_MASS})[0])[:, 0]
        assert np.abs(found.contributions[f"load on {name}"] - part).max() <= 1e-9 * one
    light, frame, _ = _framed(seed, density=0)
    if frame.slenderness > 0.5:  # shorter beams are so stiff that rounding counts
        alike(ks.modes(light.assemble(), 3).frequencies, frame.frequencies(3))


# ---- robots with several limbs -------------------------------------------------------------------------------------------


def _matrices(robot, link_name, seed, scale=1.0, thermal=False):
    """Return the matrices of a base or platform: springs and bodies at the joints and at o."""
    placement, o = robot.mechanism.body_of[link_name][1], robot.mechanism.interface_on(link_name, "o")
    parts = [part for part in robot.mechanism.at_link[link_name] if part.type.name != "floating"]
    at = [(point - placement[:3, 3]) @ placement[:3, :3] for point in (*(part.centre_on(link_name) for part in parts), o)]
    n, K, M = len(at), np.zeros((6 * len(at), 6 * len(at))), np.zeros((6 * len(at), 6 * len(at)))
    frame, free = Frame(seed, n, 0), np.zeros(6 * n)
    for k in range(n):
        for other in {n - 1, (k + 1) % n} - {k}:
            ends = np.zeros((6, 6 * n))
            ends[:, 6 * k : 6 * k + 6] = np.eye(6)
            ends[:3, 6 * other : 6 * other + 3], ends[3:, 6 * other + 3 : 6 * other + 6] = -np.eye(3), -np.eye(3)
            ends[:3, 6 * other + 3 : 6 * other + 6] = skew(at[k] - at[other])
            K += scale * ends.T @ frame.K[:6, :6] @ ends
        rows = slice(6 * k, 6 * k + 6)
        M[rows, rows] = frame.M[rows, rows]
        free[6 * k : 6 * k + 3] = 1.2e-5 * at[k]
    return LinkMatrices((*(part.name for part in parts), "o"), at, K, M, thermal=K @ free if thermal else None)


def _elastic(robot, links, scale=1.0, thermal=False):
    """Return the robot with elastic links among base and platform, and the same with rigid links at their ``o`` beside them."""
    description = robot.description
    flexible = {name: Flexible(name, _matrices(robot, name, 3 + k, scale, thermal)) for k, name in enumerate(links)}
    joints, all_links, beside = dict(description.joints), dict(description.links), {}
    ends = {"base": description.base, "platform": description.platform}
    for name, part in flexible.items():
        weld, new = f"weld_{name}", f"o_of_{name}"
        names = tuple(weld if interface == "o" else interface for interface in part.matrices.names)
        beside[name] = Flexible(name, replace(part.matrices, names=names))
        side = "parent" if name == description.base else "child"
        for key, part_joint in joints.items():
            if part_joint.type == "floating" and getattr(part_joint, side) == name:
                joints[key] = replace(part_joint, **{side: new})
        all_links[new], joints[weld] = Link(new), Joint(weld, "fixed", new, name)
        ends["base" if side == "parent" else "platform"] = new
    welded = replace(description, links=all_links, joints=joints, flexible=beside, **ends)
    return ks.Robot(replace(description, flexible=flexible)), ks.Robot(welded)


EVERY = [("3rps", ("platform",)), ("3rps", ("base", "platform")), ("linear_delta", ("base", "platform"))]


@pytest.mark.parametrize(("name", "links"), EVERY)
def test_results_are_those_of_the_same_link_beside_a_rigid_one(name, links):
    """One limb, which is the whole robot, has the same results, and contributions of the limbs add up to those of its weight."""
    poses = [robot.assemble() for robot in _elastic(ks.load_robot(name), links, thermal=True)]
    names = [limb.name for limb in poses[0].robot.topology.limbs]
    assert names == ["limb_1", "limb_2", "limb_3"] and len(poses[1].robot.topology.limbs) == 1
    point = poses[0].robot.description.flexible["platform"].matrices.origins[1]
    at_port = ks.LinkLoad([300.0, -80.0, 40.0, 2.0, 1.0, 3.0], point=point)
    errors = {key: {"temperature": 20.0} for key in links}
    motion = ks.Motion(accelerations={actuator: 3.0 + k for k, actuator in enumerate(poses[0].robot.description.actuated)})
    for more in ({}, {"payload": ks.Payload(2.0, (0.1, 0, 0.05))}, {"loads": {"platform": at_port}}, {"assembly_errors": errors}):
        found, expected = (ks.analyze(pose, LOAD, GRAVITY, **more) for pose in poses)
        for attribute in ("twist", "compliance", "base_wrench", "actuator_forces"):
            alike(getattr(found, attribute), getattr(expected, attribute))
        alike(expected.joint_wrenches, found.joint_wrenches)
        weights = sum(value for key, value in found.contributions.items() if key == "base_weight" or key in names)
        weights = weights + found.contributions["platform_weight"]
        same = {key: value for key, value in expected.contributions.items() if key not in ("limb_1", "platform_weight")}
        if not more:
            alike(weights, expected.contributions["limb_1"])
        alike(found.contributions, same)
        assert set(found.contributions) == {"platform_weight", *names, *same, *(["base_weight"] if "base" in links else [])}
        results = (found, expected)
        alike(*(sum(value for kind in each.source_contributions.values() for value in kind.values()) for each in results))
        for beam, expected_beam in expected.beams.items():
            for attribute in ("section_wrenches", "deflections", "strain_energy"):
                alike(getattr(found.beams[beam], attribute), getattr(expected_beam, attribute))
        for key in links:
            ends = [sum(result.interface_contributions[key].values()) for result in (found, expected)]
            alike(*(np.sort(end, axis=0) for end in ends))
    found, expected = (ks.analyze(pose, LOAD, GRAVITY, motion=motion) for pose in poses)
    alike(found.twist, expected.twist)
    compiled = ks.analyze(poses[0], LOAD, GRAVITY, engine="compiled", loads={"platform": at_port})
    alike(compiled.twist, ks.analyze(poses[0], LOAD, GRAVITY, engine="numpy", loads={"platform": at_port}).twist, 1e-11)
    alike(*(ks.modes(pose, 6).frequencies for pose in poses))


@pytest.mark.parametrize(("name", "links"), EVERY)
def test_a_stiff_plate_is_rigid(name, links):
    """With a very stiff platform and base all limbs have the wrenches, compliances and contributions of a rigid one."""
    rigid = ks.load_robot(name)
    soft = _elastic(rigid, links)[0].description
    bodies = {key: part.matrices.body for key, part in soft.flexible.items()}
    links_with_mass = {
        key: replace(part, mass=bodies[key][0], center_of_mass=tuple(bodies[key][1]), has_inertial=True)
        if key in bodies
        else part
        for key, part in rigid.description.links.items()
    }
    expected = ks.analyze(ks.Robot(replace(rigid.description, links=links_with_mass)).assemble(), LOAD, GRAVITY)
    found = ks.analyze(_elastic(rigid, links, scale=1e12)[0].assemble(), LOAD, GRAVITY)
    alike(found.contributions, expected.contributions, 1e-8)
    for attribute in ("mechanism_contributions", "actuator_contributions"):
        for key, parts in getattr(expected, attribute).items():
            alike(getattr(found, attribute)[key], parts, 1e-7)
    for limb, expected_limb in expected.limbs.items():
        for attribute in ("constraint_wrenches", "compliance", "sag", "intensities", "wrench"):
            alike(getattr(found.limbs[limb], attribute), getattr(expected_limb, attribute), 1e-7)
        assert found.limbs[limb].labels == expected_limb.labels


@pytest.mark.parametrize("links", [("platform",), ("base", "platform")])
def test_mechanisms_and_weights_of_limbs(links):
    """Parts of a limb's weight add up; the weight of a limb has the effect of the difference without it."""
    rigid = ks.load_robot("3rps")
    robot = _elastic(rigid, links)[0]
    found = ks.analyze(robot.assemble(), LOAD, GRAVITY)
    rod = next(iter(robot.description.beams))
    limb = next(item.name for item in robot.topology.limbs if any(edge.span == rod for edge in item.edges))
    light = ks.Robot(robot.description.changed(rod, density=0.0))
    without = ks.analyze(light.assemble(), LOAD, GRAVITY)
    alike(found.twist - without.twist, found.contributions[limb] - without.contributions[limb], 1e-8)
    assert np.abs(found.contributions[limb]).max() > 10 * np.abs(without.contributions[limb]).max()
    for name, parts in found.mechanism_contributions.items():
        alike(sum(parts.values()), found.contributions[name])
    alike(found.by_mechanism.twist, found.twist)


def test_heat_and_stiffness_are_parameters():
    """Tolerances of temperatures, and sensitivities to factors of the stiffness, against differences."""
    robot = _elastic(ks.load_robot("3rps"), ("base", "platform"), thermal=True)[0]
    pose, step, given = robot.assemble(), 1e-4, {"load": LOAD, "gravity": GRAVITY}
    for name in ("platform", "base"):
        heated = ks.analyze(pose, assembly_errors={name: {"temperature": 5.0}}).contributions["assembly_errors"]
        [effect] = ks.tolerances(pose, {f"{name}.error.temperature": 5.0}).effects.values()
        alike(np.abs(effect.twist), np.abs(heated), 1e-8)
        names = [f"{name}.stiffness_factor"]
        found = ks.sensitivities(pose, by=names, outputs=["twist"], **given)[names[0]].derivatives["twist"]
        changed = (ks.Robot(robot.description.changed(name, stiffness_factor=1 + change)) for change in (step, -step))
        first, second = (ks.analyze(each.assemble(), **given).twist for each in changed)
        alike(found, (first - second) / (2 * step), 1e-6)


def test_springs_at_an_interface():
    """A spring from the base to an interface of the platform: equilibrium and stiffness, with rotating forces."""
    elastic, jointed = (robot.description for robot in _jointed(ks.load_robot("3rps")))
    point = next(Origin(tuple(part.tolist())).xyz for part in elastic.flexible["platform"].matrices.origins)
    at_platform = ks.description.Spring("stay", 40000.0, "base", "platform", (0.0, 0.0, 0.1), point, 0.1)
    at_tip = replace(at_platform, successor="tip_0", successor_point=(0.0, 0.0, 0.0))
    results = []
    for description, spring in ((elastic, at_platform), (jointed, at_tip)):
        results.append(ks.analyze(ks.Robot(replace(description, springs={"stay": spring})).assemble(), LOAD, GRAVITY))
    alike(results[0].twist, results[1].twist)
    alike(results[0].compliance, results[1].compliance)


LINEAR, ANGULAR = (4e6, 3e6, 9e6), (8e3, 5e3, 2e4)


def _jointed(rigid):
    """Return a robot whose rigid platform has elastic joints at its ports: as matrices, and with links and elastic joints."""
    description = rigid.description
    loops = {name: item for name, item in description.loops.items() if "platform" in (item.predecessor, item.successor)}
    assert len(loops) == 3
    matrices = _matrices(rigid, "platform", 3)
    K, size, names = np.zeros_like(matrices.stiffness), 6 * len(loops), list(loops)
    order = [matrices.names.index(name) for name in names]
    for k in order:
        relative = np.zeros((6, len(K)))
        relative[:, 6 * k : 6 * k + 6], relative[:, size:] = np.eye(6), -np.eye(6)
        relative[:3, size + 3 :] = skew(matrices.origins[k] - matrices.origins[-1])
        K += relative.T @ np.diag([*LINEAR, *ANGULAR]) @ relative
    plate = description.links["platform"]
    arm = skew(np.array(plate.center_of_mass) - matrices.origins[-1])
    M = np.zeros_like(K)
    M[size:, size:] = np.block(
        [[plate.mass * np.eye(3), -plate.mass * arm], [plate.mass * arm, plate.inertia.matrix - plate.mass * arm @ arm]]
    )
    elastic = replace(description, flexible={"platform": Flexible("platform", replace(matrices, stiffness=K, mass=M))})
    links, joints, stiffness = dict(description.links), dict(description.joints), dict(description.joint_stiffness)
    moved = dict(description.loops)
    for k, name in enumerate(names):
        tip, weld = f"tip_{k}", f"soft_{k}"
        links[tip] = Link(tip)
        joints[weld] = Joint(weld, "fixed", "platform", tip, origin=Origin(tuple(matrices.origins[order[k]].tolist())))
        stiffness[weld] = ks.description.JointStiffness(weld, LINEAR, ANGULAR)
        side = "successor" if moved[name].successor == "platform" else "predecessor"
        moved[name] = replace(
            moved[name], **{side: tip, f"{side}_origin": Origin(rpy=getattr(moved[name], f"{side}_origin").rpy)}
        )
    jointed = replace(description, links=links, joints=joints, loops=moved, joint_stiffness=stiffness)
    return ks.Robot(elastic), ks.Robot(jointed)


def test_second_order_of_elastic_joints_at_the_ports():
    found, expected = (ks.analyze(robot.assemble(), LOAD, GRAVITY) for robot in _jointed(ks.load_robot("3rps")))
    alike(found.twist, expected.twist)
    assert np.abs(expected.second_order.twist / expected.twist - 1).max() > 1e-6
    alike(found.second_order.twist, expected.second_order.twist)
    alike(found.second_order.compliance, expected.second_order.compliance)
    alike(found.buckling(2).load_factors, expected.buckling(2).load_factors)


# ---- beams, open branches, and what is refused ---------------------------------------------------------------------------

ACTUATED = '<transmission name="t"><joint name="hinge"/></transmission>'


def _column(*elements, platform="tool"):
    beams = [f'<beam link="{name}" density="7850" {BEAM}>{CIRCLE}</beam>' for name in ("post", "arm")]
    parts = [link("ground"), link("post"), link("arm"), link("tool"), joint("foot", "fixed", "ground", "post", "0.1 0 0")]
    parts += [joint("hinge", "revolute", "post", "arm", "0 0.1 0.7"), joint("head", "fixed", "arm", "tool", "0.4 0 0.2")]
    return robot_of(*parts, *beams, ACTUATED, *elements, platform=platform)


def test_a_beam_as_base_and_a_beam_as_platform():
    """A uniform beam as matrices in the place of base and platform has the results of ``<beam>`` between rigid ones."""
    beams = _column()
    zero, description = beams.zero_frames, beams.description
    ends = {"post": (("o", "hinge"), [[0, 0, 0], [0, 0.1, 0.7]]), "arm": (("hinge", "o"), [[0, 0, 0], [0.4, 0, 0.2]])}
    flexible = {
        name: Flexible(name, LinkMatrices(names, origins, *as_matrices(beams, name, zero)))
        for name, (names, origins) in ends.items()
    }
    hinge = {"hinge": description.joints["hinge"]}
    own = {name: description.links[name] for name in ends}
    elastic = ks.Robot(
        replace(
            description, links=own, joints=hinge, beams={}, flexible=flexible, base="post", platform="arm",
            platform_origin=Origin((0.4, 0, 0.2)),
        )
    )  # fmt: skip
    assert [limb.name for limb in elastic.topology.limbs] == ["limb_1"]
    found, expected = (ks.analyze(robot.assemble(actuators={"hinge": 0.4}), LOAD, GRAVITY) for robot in (elastic, beams))
    for attribute in ("twist", "compliance", "actuator_forces"):
        alike(getattr(found, attribute), getattr(expected, attribute), 1e-10)
    alike(found.base_wrench[:3], expected.base_wrench[:3], 1e-10)
    weights = found.contributions["base_weight"] + found.contributions["platform_weight"]
    alike(weights, expected.contributions["limb_1"], 1e-10)
    alike(found.contributions["load"], expected.contributions["load"], 1e-10)
    assert not found.limbs["limb_1"].compliance.any()


def test_three_interfaces_on_an_open_branch():
    """A link on an open branch that carries two masses moves as the frame of beams that it is made of."""
    frame = Frame(seed=2, ports=3, inner=1)
    points = frame.nodes[:3] - frame.nodes[0]
    text = [" ".join(f"{number:.17g}" for number in point) for point in points]
    parts = [link("base"), link("platform", 1.0), link("hub"), link("a", 5.0, "0.1 0 0"), link("b", 3.0)]
    parts += [
        joint("foot", "revolute", "base", "platform", "0 0 1"),
        ACTUATED.replace("hinge", "foot"),
        joint("head", "fixed", "platform", "hub", "0 0 0.1"),
    ]
    parts += [joint("port_1", "fixed", "hub", "a", text[1]), joint("port_2", "fixed", "hub", "b", text[2])]
    names = ("head", "port_1", "port_2")
    hub = Flexible("hub", LinkMatrices(names, points, **frame.link()[2]))
    robot = ks.Robot(replace(robot_of(*parts).description, flexible={"hub": hub}))
    found = ks.analyze(robot.assemble(), LOAD, GRAVITY, loads={"a": ON_MASS})
    held = LinkedFrame(parts, {"hub": (frame, names)})
    moved = held.solve(np.zeros((6, 1)), np.array(GRAVITY), {"a": ON_MASS})[0][:, 0]
    for name in "ab":
        node = 6 * held.nodes[name]
        alike(sum(found.link_contributions[name].values()), moved[node : node + 6])
    assert np.abs(found.twist).max() == 0.0


def test_what_is_refused():
    """A ring of links between two interfaces of a platform; a wrong name; ``o`` elsewhere."""
    rigid = ks.load_robot("3rps")
    matrices, description = _matrices(rigid, "platform", 3), rigid.description
    at = [Origin(tuple(part.tolist())) for part in matrices.origins[:2] * 1.1]
    links, joints = {**description.links, "stay": Link("stay")}, description.joints
    joints = {**joints, "one": Joint("one", "fixed", "platform", "stay", origin=at[0])}
    ring = ks.description.Loop("two", "fixed", "platform", "stay", at[1], Origin(tuple(np.subtract(at[1].xyz, at[0].xyz))))
    ring = ks.Robot(replace(description, links=links, joints=joints, loops={**description.loops, "two": ring}))
    with pytest.raises(ks.RobotFileError, match="<flexible 'platform'>: the closed chain of 'stay' stiffens it; include these"):
        _elastic(ring, ("platform",))[0].topology  # noqa: B018
    wrong = replace(matrices, names=("x", *matrices.names[1:]))
    with pytest.raises(ks.RobotFileError, match="the interface 'x' is no joint of link 'platform'"):
        ks.Robot(replace(description, flexible={"platform": Flexible("platform", wrong)}))


# ---- solid finite elements -----------------------------------------------------------------------------------------------

PLATE_E, PLATE_RHO = 210e9, 7850.0  # of "steel"


def _rods(pose):
    """Yield spherical joint and centre, direction and stiffness of the springs that a rod is there, in the platform's frame."""
    frame = pose.frame("platform")
    for k in (1, 2, 3):
        foot, (name, rod) = pose.frame(f"cylinder_{k}"), (f"spherical_{k}", pose.robot.description.beams[f"rod_{k}"])
        head = frame[:3, 3] + frame[:3, :3] @ pose.robot.mechanism.connections[name].centre_on("platform")
        along = head - foot[:3, 3]
        L, A, E, G = np.linalg.norm(along), rod.section.area, rod.youngs_modulus, rod.shear_modulus
        lateral = L**3 / (3 * E * rod.section.I_y) + L / (rod.shear_coefficient * A * G)
        for direction, stiffness in ((along / L, E * A / L), (foot[:3, 1], 1 / lateral)):
            yield name, (head - frame[:3, 3]) @ frame[:3, :3], direction @ frame[:3, :3], stiffness


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("ccx") is None, reason="needs ccx, the solver of CalculiX (apt install calculix-ccx)")
def test_a_tripod_with_a_plate_agrees_with_calculix(tmp_path, monkeypatch):
    """Twist under six loads and the plate's weight: a ring of steel on three bores, on rods that are springs there."""
    occ = pytest.importorskip("netgen.occ")
    monkeypatch.setenv("KINETOSTATICS_CACHE", str(tmp_path / "cache"))
    rigid = ks.load_robot("3rps")
    bores = {f"spherical_{k}": rigid.mechanism.connections[f"spherical_{k}"].centre_on("platform") for k in (1, 2, 3)}
    shape = occ.Cylinder(occ.Pnt(0, 0, -8), occ.Z, r=225, h=16) - occ.Cylinder(occ.Pnt(0, 0, -20), occ.Z, r=50, h=40)
    for x, y, _ in bores.values():
        shape = shape - occ.Cylinder(occ.Pnt(1000 * x, 1000 * y, -20), occ.Z, r=12, h=40)
    shape.WriteStep(str(tmp_path / "plate.step"))
    near = {name: f"cylinder d=24mm near {x} {y} {z}" for name, (x, y, z) in bores.items()}
    part = ks.condense(tmp_path / "plate.step", {**near, "o": "cylinder d=100mm near 0 0 0"}, within=0.03, modes=0)
    description = replace(rigid.description, flexible={"platform": Flexible("platform", part.link)})
    for k in (1, 2, 3):
        description = description.changed(f"rod_{k}", density=0.0)
    pose = ks.Robot(description).assemble(platform={"z": 0.5, "rx": 0.1, "ry": -0.06})
    found = ks.analyze(pose, np.eye(6), (0, 0, -9.81))

    mesh = occ.OCCGeometry(str(tmp_path / "plate.step")).GenerateMesh(maxh=18, curvaturesafety=5, grading=0.3)
    mesh.SecondOrder()
    nodes = {name: 9000001 + 2 * k for k, name in enumerate((*bores, "o"))}
    lines = solid_lines(mesh)
    for name, node in nodes.items():
        centre = bores.get(name, np.zeros(3))
        words = ", ".join(f"{number:.12g}" for number in centre)
        lines += [*bore_lines(mesh, name, *(1000 * centre[:2]), 12 if name in bores else 50), "*NODE", f"{node}, {words}"]
        lines += [f"{node + 1}, {words}", f"*RIGID BODY, NSET={name}, REF NODE={node}, ROT NODE={node + 1}"]
    for number, (name, head, direction, stiffness) in enumerate(_rods(pose), 9000101):
        lines += ["*NODE", f"{number}, " + ", ".join(f"{value:.12g}" for value in head - 0.5 * direction)]
        lines += [f"*ELEMENT, TYPE=SPRINGA, ELSET=S{number}", f"{number}, {number}, {nodes[name]}"]
        lines += [f"*SPRING, ELSET=S{number}", "", f"{stiffness:.12g}", "*BOUNDARY", f"{number}, 1, 3"]
    lines += ["*MATERIAL, NAME=STEEL", "*ELASTIC", f"{PLATE_E}, 0.3", "*DENSITY", f"{PLATE_RHO}"]
    lines += ["*SOLID SECTION, ELSET=PART, MATERIAL=STEEL", "*NSET, NSET=O", f"{nodes['o']}, {nodes['o'] + 1}"]
    R = pose.frame("platform")[:3, :3]
    for load in (*np.eye(6), None):
        lines += ["*STEP", "*STATIC", "*CLOAD, OP=NEW"]
        local = np.zeros(6) if load is None else np.concatenate([load[:3] @ R, load[3:] @ R])
        lines += [f"{nodes['o'] + k // 3}, {k % 3 + 1}, {value:.12g}" for k, value in enumerate(local)]
        down = ", ".join(f"{value:.12g}" for value in -R[2])
        lines += ["*DLOAD, OP=NEW", f"PART, GRAV, {9.81 if load is None else 0.0}, {down}"]
        lines += ["*NODE PRINT, NSET=O", "U", "*END STEP"]
    solid = (displacements(tmp_path, lines, (nodes["o"], nodes["o"] + 1)) @ R.T).reshape(7, 6)

    C, root = found.compliance[0], np.linalg.cholesky(np.linalg.inv(solid[:6]))
    assert np.abs(solid[:6] - solid[:6].T).max() < 1e-4 * np.abs(solid[:6]).max()
    stiff = ks.analyze(
        ks.Robot(replace(description, flexible={})).assemble(platform={"z": 0.5, "rx": 0.1, "ry": -0.06})
    ).compliance
    assert np.abs(np.linalg.eigvalsh(root.T @ (C - stiff) @ root)).max() > 0.3  # the plate deforms by as much as the rods
    assert part.error < 0.03
    assert np.abs(np.linalg.eigvalsh(root.T @ (C - solid[:6]) @ root)).max() < part.error
    weight = found.contributions["platform_weight"][0]
    assert np.sqrt((weight - solid[6]) @ np.linalg.solve(solid[:6], weight - solid[6])) < part.error * np.sqrt(
        solid[6] @ np.linalg.solve(solid[:6], solid[6])
    )
