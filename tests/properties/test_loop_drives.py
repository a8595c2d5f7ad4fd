"""Actuated loops, and loops with limits and cones, against closed forms."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from loop_robots import (
    DENSITY,
    E_MODULUS,
    FREEDOMS,
    ONE_FREEDOM,
    Held,
    actuated,
    at,
    floating,
    frame,
    joint,
    loop,
    random_rotation,
    robot,
    shift,
    turn,
    unit,
)  # fmt: skip

import kinetostatics as ks

Z = np.array([0.0, 0, 1])
MANY_FREEDOMS = tuple(kind for kind, count in FREEDOMS.items() if count > 1)
seeds = st.integers(0, 2**32 - 1)


# ---- two linkages whose actuator is the loop ----------------------------------------------------------------------------------


class FourBar:
    """A planar four-bar linkage about z, actuated at the crank's foot; the coupler is the platform.

    The loop is that actuator (``cut`` "drive", from either side: ``swap``) or the joint of coupler and rocker.
    """

    A, D = np.zeros(2), np.array([1.0, 0.0])
    diameter = 0.03
    mass, com = 2.0, np.array([0.2, 0.1])  # of the coupler, in its frame: x along it, origin at the crank's end

    def __init__(self, crank, coupler, rocker, start, cut="drive", swap=False, kind="continuous"):
        self.crank, self.coupler, self.rocker, self.start = crank, coupler, rocker, start
        rng = np.random.default_rng(3)
        B, C = self.points(0.0)

        def anywhere(point):
            return frame(turn(Z, rng.uniform(-3, 3))[:3, :3], [*point, 0])

        rest = {
            "base": np.eye(4),
            "crank": anywhere(B if cut == "drive" else self.A),
            "platform": anywhere(C if cut == "drive" else B),
            "rocker": anywhere(self.D),
        }
        self.rest, self.swap = rest, swap
        self.coupler0 = self.coupler_frame(0.0)

        def tree(name, parent, child):
            return joint(name, "continuous", parent, child, np.linalg.inv(rest[parent]) @ rest[child], Z)

        def closing(name, kind, first, second, point):
            F = frame(random_rotation(rng), [*point, 0])
            one, two = (np.linalg.inv(rest[link]) @ F for link in (first, second))
            return loop(kind, first, one, second, two, axis=F[:3, :3].T @ Z, name=name)

        if cut == "drive":
            sides = ("crank", "base") if swap else ("base", "crank")
            parts = [tree("d", "base", "rocker"), tree("c", "rocker", "platform"), tree("b", "platform", "crank")]
            parts.append(closing("drive", kind, *sides, self.A))
        else:
            parts = [tree("drive", "base", "crank"), tree("b", "crank", "platform"), tree("d", "base", "rocker")]
            parts.append(closing("c", "revolute", "platform", "rocker", C))
        beam = f'youngs_modulus="{E_MODULUS}" poisson_ratio="0.3" density="{DENSITY}"><circle diameter="{self.diameter}"/></beam>'
        inner = at(np.linalg.inv(rest["platform"]) @ self.coupler0, [*self.com, 0])
        links = {name: "" for name in rest}
        links["platform"] = (
            f'<inertial><origin xyz="{inner[0]} {inner[1]} 0"/><mass value="{self.mass}"/>'
            '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'
        )
        self.robot = robot(
            *parts,
            f'<beam link="crank" from="drive" to="b" {beam}<beam link="rocker" from="d" to="c" {beam}',
            actuated("drive"),
            links=links,
        )

    def points(self, theta):
        """Return both ends of the coupler (2,): the crank's end, and where two circles meet, to the left of the way there."""
        angle = theta + self.start
        B = self.crank * np.array([np.cos(angle), np.sin(angle)])
        way = self.D - B
        L = np.linalg.norm(way)
        x = (self.coupler**2 - self.rocker**2 + L**2) / (2 * L)
        e = way / L
        return B, B + x * e + np.sqrt(self.coupler**2 - x**2) * np.array([-e[1], e[0]])

    def coupler_frame(self, theta):
        B, C = self.points(theta)
        return shift([*B, 0]) @ turn(Z, np.arctan2(*(C - B)[::-1]))

    def platform_frame(self, theta):
        return self.coupler_frame(theta) @ np.linalg.inv(self.coupler0) @ self.rest["platform"]

    def coordinate(self, theta):
        return -theta if self.swap else theta

    def torque(self, theta, force, gravity):
        """Return the actuator's torque by virtual work: a force (3,) at the platform's origin, and all weights."""
        area = np.pi * self.diameter**2 / 4

        def work(angle):
            B, C = self.points(angle)
            F = self.coupler_frame(angle)
            g = np.asarray(gravity)
            total = self.mass * g @ at(F, [*self.com, 0])
            total += DENSITY * area * self.crank * g[:2] @ (self.A + B) / 2
            total += DENSITY * area * self.rocker * g[:2] @ (self.D + C) / 2
            return total + force @ self.platform_frame(angle)[:3, 3]

        h = 1e-4
        slope = (8 * (work(theta + h) - work(theta - h)) - (work(theta + 2 * h) - work(theta - 2 * h))) / (12 * h)
        return self.coordinate(1.0) * -slope


@pytest.mark.few(1)
@pytest.mark.parametrize(("kind", "swap"), [("continuous", False), ("continuous", True), ("revolute", False)])
def test_loop_actuated_crank_rocker_matches_closed_form(kind, swap):
    linkage = FourBar(0.3, 0.9, 0.8, 0.4, swap=swap, kind=kind)
    assert linkage.robot.mobility.platform == 1 and linkage.robot.mobility.redundant_constraints == 3
    angles = np.radians(np.arange(-360.0, 361, 15))
    poses = linkage.robot.assemble(actuators={"drive": linkage.coordinate(angles)})
    assert np.all(poses.status == ks.Status.OK)
    force, gravity = np.array([30.0, -50.0, 20.0]), (1.0, -9.0, -2.0)
    found = ks.analyze(poses, [*force, 0, 0, 0], point=poses.frame("platform")[:, :3, 3], gravity=gravity)
    for k, angle in enumerate(angles):
        np.testing.assert_allclose(poses.frame("platform")[k], linkage.platform_frame(angle), atol=1e-11)
        assert found.actuator_forces["drive"][k] == pytest.approx(linkage.torque(angle, force, gravity), rel=1e-8, abs=1e-8)
    off = poses.actuators["drive"] - linkage.coordinate(angles)
    np.testing.assert_allclose(off, 2 * np.pi * np.round(off / (2 * np.pi)), atol=1e-11)


@pytest.mark.few(2)
@pytest.mark.parametrize("cut", ["drive", "coupler"])
@pytest.mark.parametrize("start", [100, 170, 190, 230, 250, 270])
def test_drive_continues_from_pose_beyond_half_a_turn(cut, start):
    """The crank turns through 296°, not a full turn: from each pose to the next there is only one way."""
    linkage = FourBar(0.6, 1.5, 0.9, np.radians(50), cut=cut)
    pose = linkage.robot.assemble(actuators={"drive": np.radians(start)})
    for target in np.radians([150, 200, 240, 262, 270, 276]):
        other = linkage.robot.assemble(actuators={"drive": target}, near=pose)
        np.testing.assert_allclose(other.frame("platform"), linkage.platform_frame(target), atol=1e-9)


@pytest.mark.parametrize("kind", MANY_FREEDOMS)
def test_a_drive_on_several_freedoms_is_refused(kind):
    P = shift([0.1, 0.2, 0.3])
    with pytest.raises(
        ks.RobotFileError, match=f"'closing' is {kind} and cannot be actuated; only joints with one freedom can: revolute, "
    ):
        robot(joint("free", "floating", "base", "platform", P), loop(kind, "base", P, "platform", np.eye(4)), actuated("closing"))


# ---- limits ----------------------------------------------------------------------------------------------------------------


@pytest.mark.few(4)
@pytest.mark.parametrize("kind", ["revolute", "prismatic"])
@pytest.mark.parametrize(("cut", "drive"), [("joint", "chain"), ("joint", "closing"), ("both", "closing"), ("both", "chain")])
@pytest.mark.parametrize("swap", [False, True])
def test_loop_limits_are_exact_to_2e_9(kind, cut, drive, swap):
    """Passive and actuated loops, either side first: a limit is exceeded by 2e-9, but not at the limit itself."""
    lower, upper = -0.4, 0.7
    held = Held(kind, 12, cut, swap, drive, extra=f'<limit lower="{lower}" upper="{upper}"/>')
    one, plain = held.robot(), Held(kind, 12, cut, swap, drive).robot()
    sign = -1 if swap else 1
    for value, beyond in (
        (lower, False), (lower - 2e-9, True), (lower + 2e-9, False), (0.1, False),
        (upper, False), (upper + 2e-9, True), (upper - 2e-9, False), (1.4, True), (-1.4, True),
    ):  # fmt: skip
        pose = one.assemble(actuators=held.actuators([sign * value]))
        assert pose.status == (ks.Status.LIMIT_EXCEEDED if beyond else ks.Status.OK)
        assert set(pose.limits_exceeded) == ({"closing"} if beyond else set())
        if beyond:
            item = pose.limits_exceeded["closing"]
            assert (item.joint, item.lower, item.upper, bool(item.where)) == ("closing", lower, upper, True)
            assert item.value == pytest.approx(value, abs=1e-13)
    far = held.actuators([sign * 1.4])
    found, expected = ks.analyze(one.assemble(actuators=far)), ks.analyze(plain.assemble(actuators=far))
    assert found.status == ks.Status.LIMIT_EXCEEDED and expected.status == ks.Status.OK
    np.testing.assert_array_equal(found.twist, expected.twist)
    assert any("closing" in text for text in found.warnings)


@pytest.mark.parametrize(("lower", "upper"), [(3.0, 4.0), (-4.5, -2.5), (2.0, 8.0)])
def test_loop_limits_beyond_half_a_turn_select_the_turn(lower, upper):
    """A pose determines an angle up to full turns; the one within the limits is chosen."""
    held = Held("revolute", 14, "both", False, "closing", extra=f'<limit lower="{lower}" upper="{upper}"/>')
    one = held.robot()
    for value in np.linspace(lower, upper, 5):
        pose = one.assemble(actuators={"closing": value})
        assert pose.status == ks.Status.OK
        assert pose.actuators["closing"] == pytest.approx(value, abs=1e-12)
        np.testing.assert_allclose(pose.platform_frame, held.platform_frame([value]), atol=1e-11)
    for value in (lower - 0.01, upper + 0.01):
        pose = one.assemble(actuators={"closing": value})
        assert pose.status == ks.Status.LIMIT_EXCEEDED
        item = pose.limits_exceeded["closing"]
        assert float(item.value - value) % (2 * np.pi) == pytest.approx(0, abs=1e-12) or float(value - item.value) % (
            2 * np.pi
        ) == pytest.approx(0, abs=1e-12)


# ---- cones -----------------------------------------------------------------------------------------------------------------


def text_of(axis):
    return " ".join(repr(float(x)) for x in axis)


@pytest.mark.few(1)
@pytest.mark.parametrize("kind", ["universal", "spherical"])
@pytest.mark.parametrize("cut", ["joint", "both"])
@given(data=st.data())
def test_cone_limits_the_angle_between_its_axes(kind, cut, data):
    """The angle between two axes, one on either side, computed from frames; default axes and given ones; either side first."""
    swap, seed = data.draw(st.booleans()), data.draw(seeds)
    rng = np.random.default_rng(seed)
    axes = [np.array([0, 0, 1.0])] * 2
    extra = ""
    for k, name in enumerate(("predecessor_axis", "successor_axis")):
        if data.draw(st.booleans()):
            axes[k] = 3 * rng.standard_normal(3)
            extra += f' {name}="{text_of(axes[k])}"'
    limit = data.draw(st.floats(0.01, 3.1))
    held = Held(kind, seed, cut, swap, extra=f'<cone angle="{limit!r}"{extra}/>')
    q = np.array([held.random_q(rng) for _ in range(12)]).T
    poses = held.robot().assemble(actuators=dict(zip(held.names, q, strict=True)))
    angle = np.empty(12)
    for k in range(12):
        D = held.displacement(q[:, k])[:3, :3]
        moving, still = (0, 1) if held.swap else (1, 0)  # the platform's side and the arm's
        u = D @ held.J[:3, :3] @ unit(axes[moving])
        v = held.J[:3, :3] @ unit(axes[still])
        angle[k] = np.arctan2(np.linalg.norm(np.cross(u, v)), u @ v)
    beyond = angle > limit
    np.testing.assert_array_equal(poses.status, np.where(beyond, ks.Status.LIMIT_EXCEEDED, ks.Status.OK))
    assert set(poses.limits_exceeded) == ({"closing"} if beyond.any() else set())
    if beyond.any():
        item = poses.limits_exceeded["closing"]
        np.testing.assert_allclose(item.value, angle, atol=1e-7)
        np.testing.assert_array_equal(item.where, beyond)
        assert (item.lower, item.upper) == (0.0, pytest.approx(limit))


@pytest.mark.parametrize("kind", ["universal", "spherical"])
def test_cone_angles_are_exact_to_2e_9(kind):
    """The platform tilts about the loop's first axis, and its z axis by the same angle."""
    P = np.eye(4)
    one = floating(kind, P, shift([0.1, 0.2, 0.3]), extra='<cone angle="0.5"/>')
    for value, beyond in ((0.5, False), (0.5 + 2e-9, True), (0.5 - 2e-9, False), (-0.5, False), (-0.5 - 2e-9, True), (3.0, True)):
        target = {"rx": value, "ry": 0.0} | ({"rz": 0.0} if kind == "spherical" else {})
        pose = one.assemble(platform=target, orientation="XYZ")
        assert pose.status == (ks.Status.LIMIT_EXCEEDED if beyond else ks.Status.OK)
        if beyond:
            assert pose.limits_exceeded["closing"].value == pytest.approx(abs(value), abs=1e-12)


def test_a_spherical_loop_may_spin_within_its_cone():
    one = floating("spherical", np.eye(4), shift([0.1, 0.2, 0.3]), extra='<cone angle="0.1"/>')
    pose = one.assemble(platform={"rx": 0, "ry": 0, "rz": np.linspace(-3, 3, 7)})
    assert np.all(pose.status == ks.Status.OK)


# ---- wrong descriptions ----------------------------------------------------------------------------------------------------

WITHOUT_LIMIT = tuple(kind for kind in FREEDOMS if kind not in ONE_FREEDOM)
WITHOUT_CONE = tuple(kind for kind in FREEDOMS if kind not in ("universal", "spherical"))


@pytest.mark.parametrize(
    ("kind", "inside", "complaint"),
    [
        *((kind, '<limit lower="-1" upper="1"/>', f"is {kind}, and <limit> is for revolute, ") for kind in WITHOUT_LIMIT),
        *((kind, '<cone angle="1"/>', f"is {kind}, and <cone> is for universal and spherical") for kind in WITHOUT_CONE),
        *((kind, '<axis2 xyz="0 1 0"/>', f"is {kind} and has no <axis2>") for kind in FREEDOMS if kind != "universal"),
        *((kind, '<axis xyz="0 1 0"/>', f"is {kind} and has no <axis>") for kind in ("fixed", "spherical")),
        *((kind, '<axis xyz="0 0 0"/>', "0 0 0' of <axis> is zero") for kind in FREEDOMS if kind not in ("fixed", "spherical")),
        *((kind, '<axis xyz="0 1"/>', "must be three numbers, not 2") for kind in ("revolute", "planar", "universal")),
        ("revolute", '<limit lower="1" upper="-1"/>', "lower=1 above upper=-1"),
        ("revolute", '<limit lower="1"/>', "one that is left out is 0"),
        ("prismatic", '<limit lower="inf" upper="1"/>', "is not finite"),
        ("prismatic", '<limit low="0" upper="1"/>', "'low' is not an attribute of <limit>; did you mean 'lower'"),
        ("universal", '<axis xyz="0 2 0"/><axis2 xyz="0 -1 0"/>', "the two axes .* are parallel"),
        ("spherical", "<cone/>", "lacks the attribute 'angle'"),
        ("spherical", '<cone angle="0"/>', "must be greater than zero"),
        ("universal", '<cone angle="1" axis="0 0 1"/>', "'axis' is not an attribute of <cone>"),
        ("universal", '<cone angle="1" successor_axis="0 0 0"/>', "successor_axis='0 0 0' of <cone> is zero"),
        ("spherical", '<cone angle="1" predecessor_axis="1 0"/>', "must be three numbers, not 2"),
        ("spherical", '<cone angle="1"/><cone angle="2"/>', "cone"),
        ("planar", '<limits lower="0" upper="1"/>', "<limits> does not belong in"),
    ],
)  # fmt: skip
def test_wrong_limits_cones_and_axes_are_refused(kind, inside, complaint):
    P = shift([0.1, 0.2, 0.3])
    text = loop(kind, "base", P, "platform", np.eye(4), extra="\n" + inside)
    with pytest.raises(ks.RobotFileError, match=complaint) as caught:
        robot("\n", joint("free", "floating", "base", "platform", P), "\n", text)
    assert caught.value.line in (3, 4)  # of the loop, or of an element in it
