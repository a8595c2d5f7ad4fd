"""Labels of constraint wrenches agree with the wrenches: axes that a force meets, joints that its line joins."""

import numpy as np
import package_robots
import pytest
import small_robots as small
from mechanisms import Beam, Edge, Joint, Link, Mechanism, circle, write_mechanism
from places import CASES

import kinetostatics as ks


def line(configuration, joint):
    """Return a point of a joint's axis and its direction, world."""
    connection = configuration.robot.mechanism.connections[joint]
    frame = configuration.frame(connection.predecessor) @ np.linalg.inv(
        configuration.robot.mechanism.body_of[connection.predecessor][1]
    ) @ connection.predecessor_frame  # fmt: skip
    return frame[:3, 3], frame[:3, :3] @ connection.axis


def moment(wrench, o, point):
    """Return the moment about a point of a wrench given about o."""
    return wrench[3:] + np.cross(o - point, wrench[:3])


def meeting(a, b):
    """Return the point in which two lines meet; they must meet."""
    (p, u), (q, v) = a, b
    s, t = np.linalg.lstsq(np.column_stack([u, -v]), q - p, rcond=None)[0]
    np.testing.assert_allclose(p + s * u, q + t * v, atol=1e-9)
    return p + s * u


def wrenches(result, limb):
    found = result.limbs[limb]
    return dict(zip(found.labels, found.constraint_wrenches.T, strict=True))


@pytest.mark.few(1)
@pytest.mark.parametrize("number", [1, 2, 3])
def test_limbs_whose_axes_meet_have_forces_through_the_point(number):
    pose = package_robots.robot("spherical_3rrr").assemble(platform={"rx": 0.1, "ry": -0.05, "rz": 0.2})
    tip, elbow = f"tip_{number}", f"elbow_{number}"
    found = wrenches(ks.analyze(pose), f"limb_{number}")
    across = f"force ⟂ {tip} and {elbow} where they meet"
    assert list(found) == [
        f"force along the axis of {tip}",
        f"force along the axis of {elbow}",
        across,
        f"couple ⟂ {tip} and {elbow}",
    ]
    lines = {name: line(pose, name) for name in (tip, elbow)}
    point, o = meeting(*lines.values()), pose.platform_frame[:3, 3]
    for label, wrench in list(found.items())[:3]:
        np.testing.assert_allclose(moment(wrench, o, point), 0, atol=1e-12)
        assert np.linalg.norm(wrench[:3]) == pytest.approx(1, rel=1e-12), label
    for name, (_, axis) in lines.items():
        assert abs(found[f"force along the axis of {name}"][:3] @ axis) == pytest.approx(1, rel=1e-12)
        assert found[across][:3] @ axis == pytest.approx(0, abs=1e-12)


def bent(kinds, axes):
    """Return a platform on six struts, of which the first is bent: its joints are not in line with its last beam."""
    base, top, o = small.gough_points()
    edges, beams = [], []
    for k in range(6):
        n, foot, head = k + 1, tuple(base[k]), tuple(top[k])
        if k:
            along = tuple(top[k] - base[k])
            edges += [
                Edge(Joint(f"foot_{n}", "S", foot), "base", f"lower_{n}"),
                Edge(Joint(f"slide_{n}", "P", head, along, actuated=True), f"lower_{n}", f"upper_{n}"),
                Edge(Joint(f"head_{n}", "S", head), f"upper_{n}", "platform"),
            ]
            beams.append(Beam(f"upper_{n}", f"upper_{n}", f"foot_{n}", f"head_{n}", circle(0.03)))
    corner = tuple((base[0] + top[0]) / 2 + np.array([0.2, -0.1, 0.05]))
    points = [tuple(base[0]), corner, tuple(top[0])]
    names = ["base", *(f"part_{k}" for k in range(1, len(kinds))), "platform"]
    for k, (kind, axis) in enumerate(zip(kinds, axes, strict=True)):
        at = points[0] if k == 0 else points[-1] if k == len(kinds) - 1 else corner
        edges.append(Edge(Joint(f"j{k}", kind, at, axis), names[k], names[k + 1]))
    if len(kinds) == 2:  # two beams welded at the corner
        edges[-1] = Edge(Joint("weld", "F", corner), "part_1", "part_2")
        edges.append(Edge(Joint("j1", kinds[1], points[-1], axes[1]), "part_2", "platform"))
        beams += [Beam("part_1", "part_1", "j0", "weld", circle(0.03)), Beam("part_2", "part_2", "weld", "j1", circle(0.03))]
    else:
        beams += [Beam(f"part_{k}", f"part_{k}", f"j{k - 1}", f"j{k}", circle(0.03)) for k in range(1, len(kinds))]
    links = [Link(name) for name in names[1:-1]]
    robot = Mechanism(tuple(edges), tuple(links), tuple(beams), tuple(o), 3.0, tuple(o))
    cuts = {edge.joint.name for edge in edges if edge.outer == "platform"} - {"j1" if len(kinds) == 2 else f"j{len(kinds) - 1}"}
    return write_mechanism(robot, cuts=cuts).robot()


def limb_with(result, joint):
    return next(limb.name for limb in result.robot.topology.limbs if any(edge.joint == joint for edge in limb.edges))


def test_bent_strut_has_force_along_line_of_its_balls():
    robot = bent("SS", [(0, 0, 1), (0, 0, 1)])
    result = ks.analyze(robot.assemble(), gravity=(0, 0, 0))  # under which it would turn over
    ((label, wrench),) = wrenches(result, limb_with(result, "weld")).items()
    assert label == "force along the line from j0 to j1"
    base, top, o = small.gough_points()
    for point in (base[0], top[0]):
        np.testing.assert_allclose(moment(wrench, o, point), 0, atol=1e-12)


def test_force_labelled_as_meeting_two_hinges_meets_them():
    robot = bent("RRS", [(0.3, 0.2, 0.9), (-0.5, 0.8, 0.1), (0, 0, 1)])
    pose = robot.assemble()
    result = ks.analyze(pose)
    found = wrenches(result, limb_with(result, "j1"))
    meets = [label for label in found if "meets the axes" in label]
    assert meets == ["force at j2 that meets the axes of j1 and j0"]
    _, top, o = small.gough_points()
    wrench = found[meets[0]]
    np.testing.assert_allclose(moment(wrench, o, top[0]), 0, atol=1e-12)
    for joint in ("j0", "j1"):
        point, axis = line(pose, joint)
        assert moment(wrench, o, point) @ axis == pytest.approx(0, abs=1e-12)
        assert np.linalg.norm(np.cross(wrench[:3], axis)) > 1e-3  # it meets the axis and is not parallel to it


def test_planar_limb_labels_are_distinct_and_not_complementary():
    robot = small.robot_of(small.four_bar())
    for limb in ks.analyze(robot.assemble()).limbs.values():
        assert not any(label.startswith("complementary") for label in limb.labels)
        assert len(set(limb.labels)) == len(limb.labels)


def test_labels_of_parallel_hinges_do_not_depend_on_frames():
    plain, turned = (ks.load_robot(CASES / f"parallelogram_{name}.urdf") for name in ("plain", "turned_frames"))
    for angle in (0.0, 0.3, -0.7):
        one, other = (ks.analyze(robot.assemble(actuators={"a": angle}), (100, 50, -20, 3, 2, 1)) for robot in (plain, turned))
        assert one.status == other.status == ks.Status.OK
        for name, limb in one.limbs.items():
            assert other.limbs[name].labels == limb.labels
            assert not any("⟂" in label for label in limb.labels)
            np.testing.assert_allclose(other.limbs[name].intensities, limb.intensities, rtol=0, atol=1e-10)
