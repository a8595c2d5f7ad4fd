"""Every type of loop closed, open and over its range, against closed forms of motions and gaps."""

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from loop_robots import (
    FREEDOMS,
    ONE_FREEDOM,
    Held,
    actuated,
    cuts,
    floating,
    frame,
    joint,
    loop,
    random_rotation,
    robot,
    shift,
    turn,
)
from scipy.spatial.transform import Rotation

import kinetostatics as ks

MOVING = tuple(kind for kind in FREEDOMS if kind != "fixed")
seeds = st.integers(0, 2**32 - 1)


def skew_frames(seed):
    """Return the loop's frames (4, 4) in base and platform, at random."""
    rng = np.random.default_rng(seed)
    return tuple(frame(random_rotation(rng), rng.uniform(-0.5, 0.5, 3)) for _ in range(2))


def moved(linear, angular):
    return frame(Rotation.from_rotvec(angular).as_matrix(), linear)


def angle_between(a, b):
    return float(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b))


def opening(kind, X, axis=(1, 0, 0), axis2=(0, 1, 0)):
    """Return how far a loop is open [m], [rad] when its successor's frame stands at ``X`` (4, 4) in its predecessor's."""
    d, R, a, b = X[:3, 3], X[:3, :3], np.array(axis, float), np.array(axis2, float)
    metres = {"planar": abs(a @ d)}.get(kind, np.linalg.norm(d))
    if kind in ("prismatic", "cylindrical"):
        metres = np.linalg.norm(np.cross(a, d))
    if kind in ("fixed", "prismatic"):
        radians = np.linalg.norm(Rotation.from_matrix(R).as_rotvec())
    elif kind == "universal":
        radians = abs(angle_between(a, R @ b) - angle_between(a, b))
    else:
        radians = 0.0 if kind == "spherical" else angle_between(a, R @ a)
    return float(metres), float(radians)


def q_of(one, D):
    """Return Pinocchio's coordinates at which a floating platform stands at ``D`` (4, 4)."""
    placement = one.model.jointPlacements[1].homogeneous
    return pin.SE3ToXYZQUAT(pin.SE3(np.linalg.inv(placement) @ D))


# ---- closed --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", MOVING)
def test_loop_types_have_their_number_of_constraints(kind):
    P, S = skew_frames(5)
    one = floating(kind, P, S)
    pose = one.assemble()
    assert pose.residual < 1e-15 and pose.status == ks.Status.OK
    np.testing.assert_allclose(pose.frame("platform"), P @ np.linalg.inv(S), atol=1e-15)
    assert one.equations.count == 6 - FREEDOMS[kind]
    assert (one.mobility.platform, one.mobility.local, one.mobility.redundant_constraints) == (FREEDOMS[kind], 0, 0)


@pytest.mark.few(6)
@pytest.mark.parametrize(("kind", "cut"), [(kind, cut) for kind in FREEDOMS for cut in cuts(kind)])
def test_redundant_constraints_of_two_joints_with_the_same_freedoms(kind, cut):
    """A chain and a joint with f freedoms hold the platform side by side: f freedoms, and 6 − f redundant constraints."""
    one = Held(kind, seed=2, cut=cut).robot()
    assert one.assemble().residual < 2e-15
    free = FREEDOMS[kind]
    assert (one.mobility.platform, one.mobility.local, one.mobility.redundant_constraints) == (free, 0, 6 - free)


def test_a_fixed_loop_between_base_and_platform_is_refused():
    P, S = skew_frames(5)
    with pytest.raises(ks.RobotFileError, match="rigidly fixed to the base"):
        floating("fixed", P, S)


# ---- open ----------------------------------------------------------------------------------------------------------------


@pytest.mark.few(2)
@pytest.mark.parametrize("kind", MOVING)
@given(seed=seeds)
def test_loop_gap_matches_known_opening(kind, seed):
    rng = np.random.default_rng(seed)
    P, S = skew_frames(seed)
    X = moved(rng.uniform(-1, 1, 3), rng.uniform(-1.7, 1.7, 3))
    one = floating(kind, P, S)
    q = q_of(one, P @ X @ np.linalg.inv(S))
    metres, radians = opening(kind, X)
    pose = one.configuration(q, closure_tolerance=10)
    assert [float(x[0]) for x in pose.loop_gaps["closing"]] == pytest.approx([metres, radians], abs=1e-13)
    assert pose.residual == pytest.approx(max(metres, radians), abs=1e-13)
    with pytest.raises(ks.AssemblyError) as caught:
        one.configuration(q)
    assert caught.value.residuals["closing"] == pytest.approx((metres, radians), abs=1e-13)
    words = f"loop 'closing' stays {metres:.3g} m" + (f" and {radians:.3g} rad open" if radians else " open")
    assert words in str(caught.value)


#: Motions that a joint constrains, in its own frame (axis x, second axis y): shift, turn.
BLOCKED = {
    "fixed": ((2e-3, 1e-3, -2e-3), (3e-3, 0, 4e-3)),
    "revolute": ((3e-3, 0, 0), (0, 3e-3, 4e-3)),
    "continuous": ((3e-3, 0, 0), (0, -3e-3, 4e-3)),
    "prismatic": ((0, 3e-3, 0), (3e-3, 4e-3, 0)),
    "cylindrical": ((0, 0, 3e-3), (0, 0, 5e-3)),
    "universal": ((3e-3, 0, 0), (0, 0, 0)),  # turning the other way round brings the axes back to a right angle
    "spherical": ((0, 3e-3, 0), (0, 0, 0)),
    "planar": ((3e-3, 0, 0), (0, 5e-3, 0)),
}


TOOL = shift([0.3, -0.4, 0.5])


def guided(kind, X, P):
    """Return a platform guided by actuated joints with the loop's own freedoms, and the loop's successor off by X (4, 4).

    At zero the platform's frame stands at ``P @ TOOL``.
    """
    x, y, z = np.eye(3)
    chain = {
        "revolute": [("continuous", x)],
        "continuous": [("continuous", x)],
        "prismatic": [("prismatic", x)],
        "cylindrical": [("prismatic", x), ("continuous", x)],
        "universal": [("continuous", x), ("continuous", y)],
        "spherical": [("continuous", x), ("continuous", y), ("continuous", z)],
        "planar": [("prismatic", y), ("prismatic", z), ("continuous", x)],
    }[kind]
    names = [f"drive_{k}" for k in range(len(chain))]
    links = ["base", *(f"link_{k}" for k in range(1, len(chain))), "body"]
    parts = [
        joint(name, how, links[k], links[k + 1], P if k == 0 else np.eye(4), axis)
        for k, (name, (how, axis)) in enumerate(zip(names, chain, strict=True))
    ]
    parts += [joint("flange", "fixed", "body", "platform", TOOL), loop(kind, "base", P, "body", X)]
    return robot(*parts, actuated(*names), links=[*links, "platform"])


@pytest.mark.few(4)
@pytest.mark.parametrize("kind", MOVING)
def test_a_loop_that_cannot_close_is_named_with_its_opening(kind):
    """The guide has the loop's freedoms, so that no motion closes it; openings as small as from rounded angles are tolerated."""
    P, _ = skew_frames(8)
    linear, angular = map(np.array, BLOCKED[kind])
    for X, is_small in ((moved(0.01 * linear, 0.01 * angular), True), (moved(100 * linear, 60 * angular), False)):
        one, (metres, radians) = guided(kind, X, P), opening(kind, X)
        with pytest.raises(ks.AssemblyError, match="loop 'closing' stays") as caught:
            one.assemble()
        # the least squares weigh metres against radians, and may trade one for the other where the motion couples them
        assert caught.value.residuals["closing"] == pytest.approx((metres, radians), rel=1e-6 if is_small else 1e-3, abs=1e-9)
        assert ("not even with all joints free" in str(caught.value)) == (not is_small)
        if is_small:
            pose = one.assemble(closure_tolerance=1e-4)
            assert pose.residual == pytest.approx(max(metres, radians), rel=1e-6)
            np.testing.assert_allclose(pose.frame("body"), P, atol=1e-15)


@pytest.mark.few(2)
@pytest.mark.parametrize("kind", MOVING)
@given(seed=seeds)
@example(seed=18271)  # the loop is but 42 mm beside o
def test_nearly_closed_zero_pose_is_closed_by_smallest_motion(kind, seed):
    rng = np.random.default_rng(seed)
    P, S = skew_frames(seed)
    arm = np.linalg.norm(S[:3, 3])
    off = moved(rng.uniform(-0.05, 0.05, 3) * arm, rng.uniform(-0.1, 0.1, 3))
    zero = P @ off @ np.linalg.inv(S)
    one = floating(kind, P, S, zero=zero)
    pose = one.assemble()
    assert pose.residual < 1e-10
    X = np.linalg.inv(P) @ pose.frame("platform") @ S
    assert opening(kind, X) == pytest.approx((0, 0), abs=2e-10)

    def size(end):
        """The motion from zero to an end, lengths by the robot's own."""
        motion = np.linalg.inv(zero) @ end
        return np.hypot(np.linalg.norm(motion[:3, 3]) / one.length, np.linalg.norm(pin.log3(motion[:3, :3])))

    # closed by a motion no larger than that to the closed pose it was displaced from: not in another assembly mode
    assert size(pose.frame("platform")) < 1.01 * size(P @ np.linalg.inv(S))


# ---- over the range ------------------------------------------------------------------------------------------------------


@pytest.mark.few(2)
@pytest.mark.parametrize("kind", FREEDOMS)
@given(data=st.data())
def test_loop_moves_as_its_joint_in_every_cut(kind, data):
    """Any pose over the whole range directly from zero, in every cut, from either side."""
    cut, swap = data.draw(st.sampled_from(cuts(kind))), data.draw(st.booleans())
    drive = data.draw(st.sampled_from(("chain", "closing"))) if kind in ONE_FREEDOM else "chain"
    held = Held(kind, data.draw(seeds), cut, swap and cut != "weld", drive, right=data.draw(st.booleans()))
    one = held.robot()
    q = [data.draw(st.floats(-7, 7)) if how == "R" else data.draw(st.floats(-5, 5)) for how, _ in held.chain]
    pose = one.assemble(actuators=held.actuators(q))
    assert pose.status == ks.Status.OK and pose.residual < 1e-10
    size = 1 + np.abs(np.array([*q, 0.0])).max()
    np.testing.assert_allclose(pose.platform_frame, held.platform_frame(q), atol=1e-11 * size)
    for name, value in held.actuators(q).items():
        off = pose.actuators[name] - value
        if kind != "prismatic" and not (name.startswith("chain") and held.chain[int(name[-1]) - 1][0] == "P"):
            off -= 2 * np.pi * np.round(off / (2 * np.pi))
        assert off == pytest.approx(0, abs=1e-11 * size)


def upright(kind, seed, axis=None, axis2=None, **options):
    """Return a floating platform whose loop has its axis, or the first and second axis, along world z, or x and y, at zero.

    The platform's own frame has the world's axes then. Also returns the loop's centre and o (3,) at zero.
    """
    rng = np.random.default_rng(seed)
    P, S = skew_frames(seed)
    turned = P[:3, :3].T
    if kind == "universal":
        given = {"axis": turned[:, 0], "axis2": turned[:, 1]}
    else:
        given = {} if kind == "spherical" else {"axis": turned[:, 2]}
    zero = P @ np.linalg.inv(S)
    o = rng.uniform(-0.5, 0.5, 3)
    mark = np.linalg.inv(zero) @ frame(p=o)
    tool = joint("flange", "fixed", "body", "platform", mark)
    text = loop(kind, "base", P, "body", S, **given, **options)
    one = robot(joint("free", "floating", "base", "body", zero), tool, text, links=("base", "body", "platform"))
    return one, P[:3, 3], o


def test_continuous_loop_makes_full_turns_without_a_jump():
    """Each pose from the last: coordinates are within half a turn, and the next target may lie a little beyond."""
    one, c, o = upright("continuous", 4)
    pose = one.assemble(platform={"rz": 0.0})
    step = np.radians(37)
    for k in range(1, 28):
        pose = one.assemble(platform={"rz": float(pose.platform["rz"]) + step}, near=pose)
        np.testing.assert_allclose(pose.platform_frame, turn([0, 0, 1], k * step, c) @ shift(o), atol=1e-12)


def test_cylindrical_loop_in_batches_of_turns_and_strokes():
    one, c, o = upright("cylindrical", 6)
    stroke, angle = np.meshgrid(np.linspace(-50, 50, 5), np.linspace(-3.1, 3.1, 6))
    poses = one.assemble(platform={"z": o[2] + stroke, "rz": angle})
    assert poses.shape == (6, 5) and np.all(poses.status == ks.Status.OK)
    for index in np.ndindex(poses.shape):
        expected = shift([0, 0, stroke[index]]) @ turn([0, 0, 1], angle[index], c) @ shift(o)
        np.testing.assert_allclose(poses.platform_frame[index], expected, atol=1e-11)


@pytest.mark.few(4)
@pytest.mark.parametrize("axis", [(1, 0, 0), (0, -1, 0), (0.6, 0, 0.8), (1, 1, 1), (1, -2, 3)])
@pytest.mark.parametrize("angle", [np.pi, np.pi - 1e-9, -np.pi, 1.2 * np.pi])
def test_spherical_loop_reaches_half_a_turn(axis, angle):
    check_spherical(3, np.array(axis) / np.linalg.norm(axis) * angle)


def check_spherical(seed, vector):
    one, c, o = upright("spherical", seed % 1000)
    pose = one.assemble(platform=dict(zip(("rx", "ry", "rz"), vector, strict=True)))
    R = Rotation.from_rotvec(vector).as_matrix()
    np.testing.assert_allclose(pose.platform_frame, frame(R, c + R @ (o - c)), atol=1e-12)


@given(seed=seeds, first=st.floats(-7, 7), second=st.floats(-1.5, 1.5))
def test_universal_loop_over_turns_and_up_to_right_angles(seed, first, second):
    one, c, o = upright("universal", seed % 1000)
    pose = one.assemble(platform={"rx": first, "ry": second}, orientation="XYZ")
    expected = turn([1, 0, 0], first, c) @ turn([0, 1, 0], second, c) @ shift(o)
    np.testing.assert_allclose(pose.platform_frame, expected, atol=1e-9)


def cardan(bend, swap):
    """Return two shafts, ``input`` about z and the platform about z turned by ``bend`` about x, joined by a universal loop.

    The input's pin is x at zero, across the plane of the bend. Also returns where the platform stands at an angle of the input:
    tan(out) = tan(in) cos(bend).
    """
    x, z = np.array([1.0, 0, 0]), np.array([0, 0, 1.0])
    out = turn(x, bend)
    S = frame(random_rotation(np.random.default_rng(2)))
    mine, theirs = (S, S[:3, :3].T @ x), (np.linalg.inv(out) @ S, S[:3, :3].T @ np.cross(out[:3, 2], x))
    if swap:
        text = loop("universal", "platform", theirs[0], "input", mine[0], axis=theirs[1], axis2=mine[1])
    else:
        text = loop("universal", "input", mine[0], "platform", theirs[0], axis=mine[1], axis2=theirs[1])
    shafts = [joint("in", "continuous", "base", "input", frame(), z), joint("out", "continuous", "base", "platform", out, z)]

    def expected(angle):
        return out @ turn(z, np.arctan2(np.sin(angle) * np.cos(bend), np.cos(angle)))

    return robot(*shafts, text, actuated("in"), links=("base", "input", "platform")), expected


@pytest.mark.few(2)
@pytest.mark.parametrize("swap", [False, True])
@pytest.mark.parametrize("bend", [10.0, 45.0, 70.0, 80.0])
def test_cardan_shaft_reaches_all_angles_from_zero(bend, swap):
    """The opposite output angle closes the loop as well, but in another assembly mode."""
    shafts, expected = cardan(np.radians(bend), swap)
    assert shafts.mobility.platform == 1 and shafts.mobility.redundant_constraints == 3
    angles = np.linspace(-2 * np.pi, 2 * np.pi, 97)
    poses = shafts.assemble(actuators={"in": angles})
    assert np.all(poses.status == ks.Status.OK) and poses.residual.max() < 1e-10
    for k, angle in enumerate(angles):
        np.testing.assert_allclose(poses.frame("platform")[k], expected(angle), atol=1e-9)


@pytest.mark.few(2)
@pytest.mark.parametrize("swap", [False, True])
@pytest.mark.parametrize("bend", [60.0, 89.0, 89.9])
def test_cardan_shaft_follows_equal_steps_of_its_output(bend, swap):
    """Near a right angle the output runs through half a turn while the input hardly moves: equal steps of the output."""
    bend = np.radians(bend)
    shafts, expected = cardan(bend, swap)
    pose = shafts.assemble(actuators={"in": 0.0})
    for out in np.radians(np.arange(0, 400, 10.0)):
        angle = np.arctan2(np.sin(out), np.cos(out) * np.cos(bend))
        pose = shafts.assemble(actuators={"in": angle}, near=pose)
        np.testing.assert_allclose(pose.frame("platform"), expected(angle), atol=1e-8)
