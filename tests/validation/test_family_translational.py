"""Planar, spherical and translational robots of ``robots/``: mobility, workspaces, kinematics and statics against formulas.

Every formula is written out here from the mechanism's geometry and elementary beams; nothing is taken from the package but what
is under test.
"""

import re
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin
import pytest
from package_robots import robot
from places import ROBOTS

import kinetostatics as ks
from kinetostatics.sections import RectangularTube

X, Y, Z = np.eye(3)
G = 9.81


@dataclass(frozen=True)
class Claim:
    """Statements of file and docs: freedoms, constraints, actuators, the workspace as a grid of poses, and two poses in it."""

    mobility: int
    local: int
    redundant: int
    mass: float
    drives: tuple
    workspace: dict
    poses: tuple
    orientation: str | None = None


def grid(**axes):
    """Return all combinations of the coordinates."""
    values = np.meshgrid(*axes.values(), indexing="ij")
    return dict(zip(axes, values, strict=True))


def cylinder(radius, **more):
    """Return a grid over a disc of the xy plane, and over the other coordinates."""
    found = grid(r=np.linspace(0, radius, 3), a=np.radians(np.arange(0, 360, 30)), **more)
    r, a = found.pop("r"), found.pop("a")
    return {"x": r * np.cos(a), "y": r * np.sin(a), **found}


def deg(*values):
    return np.radians(values)


#: of the Orthoglide, for a cube of 200 mm
LEG = 0.2 / (1 / np.sqrt(6) + 1 / np.sqrt(18))
CUBE = (-LEG / np.sqrt(6), -0.03, LEG / np.sqrt(18))

CLAIMS = {
    "planar_3rrr": Claim(
        3, 0, 6, 1.0742, ("motor_1", "motor_2", "motor_3"), cylinder(0.2, rz=deg(-15, 0, 15)),
        ({"x": 0.12, "y": -0.07, "rz": 0.2}, {"x": -0.05, "y": 0.16, "rz": -0.25}),
    ),
    "spherical_3rrr": Claim(
        3, 0, 6, 0.45212, ("motor_1", "motor_2", "motor_3"),
        grid(azimuth=deg(*range(-180, 180, 30)), tilt=deg(1, 30, 60), torsion=deg(-40, 0, 40)),
        ({"azimuth": 0.7, "tilt": 0.5, "torsion": 0.3}, {"azimuth": -2.0, "tilt": 0.9, "torsion": -0.4}), "tilt_torsion",
    ),
    "tripteron": Claim(
        3, 0, 3, 15.743, ("rail_1", "rail_2", "rail_3"),
        grid(x=(-0.15, 0, 0.15), y=(-0.15, 0, 0.15), z=(-0.15, 0, 0.15)),
        ({"x": 0.1, "y": -0.08, "z": 0.12}, {"x": -0.15, "y": 0.14, "z": -0.05}),
    ),
    "linear_delta": Claim(
        3, 0, 0, 0.84837, ("rail_1", "rail_2", "rail_3"), cylinder(0.127, z=(0, 0.14, 0.277)),
        ({"x": 0.1, "y": -0.05, "z": 0.01}, {"x": -0.06, "y": 0.1, "z": 0.2}),
    ),
    "delta": Claim(
        3, 6, 0, 2.7062, ("motor_1", "motor_2", "motor_3"), cylinder(0.565, z=(-0.8, -0.7, -0.55)),
        ({"x": 0.3, "y": -0.2, "z": -0.75}, {"x": -0.1, "y": 0.45, "z": -0.6}),
    ),
    "orthoglide": Claim(
        3, 0, 12, 12.215, ("rail_1", "rail_2", "rail_3"), grid(x=CUBE, y=CUBE, z=CUBE),
        ({"x": 0.06, "y": -0.11, "z": 0.03}, {"x": -0.12, "y": 0.07, "z": -0.1}),
    ),
}  # fmt: skip

names = pytest.mark.parametrize("name", CLAIMS)


def assembled(name, which, **parameters):
    """Return the zero pose (which = 0) or one of the two poses in the workspace (1, 2)."""
    one, claim = robot(name, **parameters), CLAIMS[name]
    if which == 0:
        return one.assemble()
    return one.assemble(platform=claim.poses[which - 1], orientation=claim.orientation)


def drives(name, configuration):
    return np.stack([configuration.actuators[joint] for joint in CLAIMS[name].drives], axis=-1)


def forces(name, found):
    return np.stack([found.actuator_forces[joint] for joint in CLAIMS[name].drives], axis=-1)


def close(found, expected, rtol):
    """Compare whole arrays by the size of the largest entry expected."""
    expected = np.asarray(expected, dtype=float)
    np.testing.assert_allclose(found, expected, rtol=0, atol=rtol * np.abs(expected).max())


def blocks_close(found, expected, rtol):
    """Compare stiffness matrices block by block: N/m, N and N·m."""
    for rows in (slice(0, 3), slice(3, 6)):
        for columns in (slice(0, 3), slice(3, 6)):
            scale = np.sqrt(np.abs(expected[rows, rows]).max() * np.abs(expected[columns, columns]).max())
            np.testing.assert_allclose(found[rows, columns], expected[rows, columns], rtol=0, atol=rtol * scale)


def unit(v):
    return v / np.linalg.norm(v)


def turn(axis, angle):
    """Return the rotation matrix about an axis."""
    return pin.AngleAxis(angle, unit(np.asarray(axis, dtype=float))).toRotationMatrix()


# ---- elementary beams ----------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Bar:
    """Stiffnesses of a straight beam: I is that of bending across the plane of a limb, I_in of bending within it."""

    E: float
    G: float
    area: float
    I: float  # noqa: E741
    J: float
    kappa: float = 1.0
    I_in: float = 0.0


def rectangle(E, nu, height, width):
    """Return a flat bar: height across the plane of motion. Torsion: Saint-Venant's series as Roark prints its sum."""
    a, b = max(height, width) / 2, min(height, width) / 2
    odd = np.arange(1.0, 2000, 2)
    series = np.sum(np.tanh(odd * np.pi * a / (2 * b)) / odd**5)
    J = a * b**3 * (16 / 3 - 1024 / np.pi**5 * b / a * series)
    kappa = 10 * (1 + nu) / (12 + 11 * nu)
    return Bar(E, E / 2 / (1 + nu), height * width, width * height**3 / 12, J, kappa, height * width**3 / 12)


def across(bar, start, end, tip, axis):
    """Return how a cantilever bends out of its limb's plane under loads at a tip beyond its end.

    The plane is normal to ``axis``. Loads at the tip: a force along the axis, moments about the limb's two directions in the
    plane; the same for the displacements. Worked out by integrating moments by hand.
    """
    L, along = np.linalg.norm(end - start), unit(end - start)
    side = np.cross(axis, along)
    a, b = along @ (tip - end), side @ (tip - end)
    EI, GJ, GA = bar.E * bar.I, bar.G * bar.J, bar.kappa * bar.G * bar.area
    local = np.array([
        [((L + a) ** 3 - a**3) / 3 / EI + L / GA + b**2 * L / GJ, b * L / GJ, -((L + a) ** 2 - a**2) / 2 / EI],
        [b * L / GJ, L / GJ, 0], [-((L + a) ** 2 - a**2) / 2 / EI, 0, L / EI],
    ])  # fmt: skip
    # a load (force along the axis, moment) in world axes → force, moment about the bar, moment about its side
    loads = np.zeros((3, 6))
    loads[0, :3], loads[1, 3:], loads[2, 3:] = axis, along, side
    return loads.T @ local @ loads


def limb_across(points, bars, axis, o, drive=np.inf):
    """Return the stiffness (6, 6) at o of a limb whose joints are all parallel to ``axis``, its actuator locked.

    It resists a displacement along the axis and rotations across it, and nothing else.
    """
    compliance = sum(across(bar, points[k], points[k + 1], points[-1], axis) for k, bar in enumerate(bars))
    first = unit(np.cross(axis, X + 0.3 * Y + 0.1 * Z))
    basis = np.zeros((6, 3))
    basis[:3, 0], basis[3:, 1], basis[3:, 2] = axis, first, np.cross(axis, first)
    small = basis.T @ compliance @ basis
    small[0, 0] += 1 / drive
    about_o = basis.copy()
    about_o[3:] += np.cross(points[-1] - o, basis[:3], axis=0)
    return about_o @ np.linalg.inv(small) @ about_o.T


# ---- all of them -------------------------------------------------------------------------------------------------------------


@pytest.mark.few(3)
@names
def test_mobility_actuators_and_mass(name):
    one, claim = robot(name), CLAIMS[name]
    found = one.mobility
    assert (found.platform, found.local, found.redundant_constraints) == (claim.mobility, claim.local, claim.redundant)
    assert found.gap > 1e6
    assert one.description.actuated == claim.drives
    assert not one.description.warnings and not one.topology.warnings
    assert len(one.topology.limbs) == 3
    assert one.closing_error < 1e-11
    zero = one.assemble()
    np.testing.assert_allclose(drives(name, zero), 0, atol=1e-12)
    found = ks.analyze(zero)
    assert found.status == ks.Status.OK and found.warnings == one.warnings
    assert found.base_wrench[2] == pytest.approx(claim.mass * G, rel=5e-5)


@names
def test_workspace_is_reached(name):
    claim = CLAIMS[name]
    configuration = robot(name).assemble(platform=claim.workspace, orientation=claim.orientation)
    assert configuration.status.size >= 27
    assert np.all(configuration.status == ks.Status.OK), configuration.limits_exceeded
    assert np.all(ks.analyze(configuration).status == ks.Status.OK)


@pytest.mark.few(1)
@names
def test_loops_close_with_other_dimensions(name):
    """The example in the file's head, and every length a little different."""
    text = (ROBOTS / f"{name}.urdf.xacro").read_text()
    example = re.search(rf"xacro {name}\.urdf\.xacro (.+)", text).group(1)
    lengths = re.findall(r'<xacro:arg name="(\w+(?:_length|_radius|_side|_width|_distance|_offset))" default="([\d.]+)"', text)
    varied = {key: float(value) * (1 + 0.01 * k) for k, (key, value) in enumerate(lengths, start=1)}
    assert len(varied) >= 3
    for parameters in (dict(item.split(":=") for item in example.split()), varied):
        one = robot(name, **parameters)
        assert one.closing_error < 1e-11
        assert one.mobility == replace(robot(name).mobility, gap=one.mobility.gap)
        assert ks.analyze(one.assemble()).status == ks.Status.OK


# ---- planar 3-RRR ----------------------------------------------------------------------------------------------------------

CORNERS = np.radians([210.0, 330.0, 90.0])
BASE_RADIUS, PLATFORM_RADIUS, BAR = 0.9 / np.sqrt(3), 0.08 / np.sqrt(3), 0.4
CRANK = rectangle(71.705e9, 0.33, 0.023, 0.006)
COUPLER = rectangle(207e9, 0.3, 0.023, 0.002)


def planar_points(x, y, rz):
    """Return B_i, E_i, C_i (3, 3 each) by the law of cosines, elbows on the left of the way from B_i to C_i."""
    found = []
    for azimuth in CORNERS:
        B = BASE_RADIUS * np.array([np.cos(azimuth), np.sin(azimuth), 0])
        C = np.array([x, y, 0]) + PLATFORM_RADIUS * np.array([np.cos(azimuth + rz), np.sin(azimuth + rz), 0])
        d = np.linalg.norm(C - B)
        inner = np.arccos(d / (2 * BAR))  # both bars are equally long
        E = B + BAR * turn(Z, inner) @ unit(C - B)
        found.append((B, E, C))
    return found


def planar_angles(x, y, rz):
    """Return the cranks' directions."""
    return np.array([np.arctan2((E - B)[1], (E - B)[0]) for B, E, _ in planar_points(x, y, rz)])


def planar_screws(pose):
    """Return for each limb its points, the coupler's force of one newton as (force; moment about o), and its lever at B_i."""
    o = np.array([pose["x"], pose["y"], 0.0])
    found = []
    for B, E, C in planar_points(**pose):
        along = unit(C - E)
        found.append(((B, E, C), np.concatenate([along, np.cross(C - o, along)]), float(np.cross(E - B, along)[2])))
    return o, found


def test_planar_inverse_kinematics():
    rng = np.random.default_rng(1)
    targets = {"x": rng.uniform(-0.14, 0.14, 20), "y": rng.uniform(-0.14, 0.14, 20), "rz": rng.uniform(-0.26, 0.26, 20)}
    configuration = robot("planar_3rrr").assemble(platform=targets)
    zero = planar_angles(0, 0, 0)
    expected = [planar_angles(x, y, rz) - zero for x, y, rz in zip(*targets.values(), strict=True)]
    expected = (np.array(expected) + np.pi) % (2 * np.pi) - np.pi
    np.testing.assert_allclose(drives("planar_3rrr", configuration), expected, atol=1e-10)
    again = robot("planar_3rrr").assemble(actuators=dict(zip(CLAIMS["planar_3rrr"].drives, expected.T, strict=True)))
    for coordinate, value in targets.items():
        np.testing.assert_allclose(again.platform[coordinate], value, atol=1e-10)


@pytest.mark.parametrize("pose", CLAIMS["planar_3rrr"].poses)
def test_planar_statics(pose):
    """In the plane the couplers push along themselves; gravity is across it, and the actuators do not feel it."""
    configuration = robot("planar_3rrr").assemble(platform=pose)
    load = np.array([30.0, -20.0, 7.0, 0.5, -0.3, 2.0])
    _, limbs = planar_screws(pose)
    plane = [0, 1, 5]
    pushes = np.linalg.solve(np.array([screw[plane] for _, screw, _ in limbs]).T, -load[plane])
    torques = [push * lever for push, (_, _, lever) in zip(pushes, limbs, strict=True)]
    close(forces("planar_3rrr", ks.analyze(configuration, load=load)), torques, 1e-11)
    np.testing.assert_allclose(forces("planar_3rrr", ks.analyze(configuration)), 0, atol=1e-11)


@pytest.mark.parametrize("pose", CLAIMS["planar_3rrr"].poses)
def test_planar_stiffness(pose):
    """In the plane cranks bend and couplers are struts; across it, every limb is a bent cantilever."""
    o, limbs = planar_screws(pose)
    K = np.zeros((6, 6))
    for (B, E, C), screw, lever in limbs:
        sine = lever / BAR
        bend = BAR**3 / (3 * CRANK.E * CRANK.I_in) + BAR / (CRANK.kappa * CRANK.G * CRANK.area)
        stretch = BAR / (CRANK.E * CRANK.area)
        compliance = BAR / (COUPLER.E * COUPLER.area) + sine**2 * bend + (1 - sine**2) * stretch
        K += np.outer(screw, screw) / compliance + limb_across((B, E, C), (CRANK, COUPLER), Z, o)
    found = ks.analyze(robot("planar_3rrr").assemble(platform=pose)).stiffness
    plane, out = [0, 1, 5], [2, 3, 4]
    assert np.abs(found[np.ix_(plane, out)]).max() < 1e-9 * np.abs(K).max()
    for block, tolerance in ((plane, 1e-12), (out, 1e-9)):  # the package cuts the series of the torsion constant short
        size = np.sqrt(np.diag(K)[block])
        np.testing.assert_allclose((found - K)[np.ix_(block, block)] / np.outer(size, size), 0, atol=tolerance)


# ---- spherical 3-RRR -------------------------------------------------------------------------------------------------------

#: u_1 u_2 u_3 as columns
TRIPOD = np.array([[np.sqrt(2 / 3), -1 / np.sqrt(6), -1 / np.sqrt(6)], [0, -np.sqrt(0.5), np.sqrt(0.5)], [-1 / np.sqrt(3)] * 3])


def spherical_orientation(angles):
    """Return the camera's rotation matrix from the actuators' angles, in closed form.

    In the motors' axes w_1 = (0, c1, s1), w_2 = (s2, 0, c2), w_3 = (c3, s3, 0), and these are perpendicular to the third, first
    and second column of the rotation. Written as Rz Ry Rx, that is: tan y = t2 cos z, tan x = (sin z sin y + t1 cos y) / cos z,
    and, after these two are put into the third, tan z = (t3 (1 + t2²) + t1 t2) / (1 − t1 t2 t3).
    """
    t1, t2, t3 = np.tan(angles)
    z = np.arctan((t3 * (1 + t2**2) + t1 * t2) / (1 - t1 * t2 * t3))
    y = np.arctan(t2 * np.cos(z))
    x = np.arctan((np.sin(z) * np.sin(y) + t1 * np.cos(y)) / np.cos(z))
    return TRIPOD @ turn(Z, z) @ turn(Y, y) @ turn(X, x) @ TRIPOD.T


def spherical_angles(R):
    """Return the actuators' angles from the camera's rotation matrix: each w_i, turned from home, meets v_i at a right angle."""
    R = TRIPOD.T @ R @ TRIPOD
    return [np.arctan(-R[1, 2] / R[2, 2]), np.arctan(-R[2, 0] / R[0, 0]), np.arctan(-R[0, 1] / R[1, 1])]


def spherical_axes(R, angles):
    u = TRIPOD.T
    w = [turn(u[i], angles[i]) @ u[(i + 1) % 3] for i in range(3)]
    v = [-R @ u[(i + 2) % 3] for i in range(3)]
    return u, w, v


def test_spherical_direct_kinematics():
    rng = np.random.default_rng(2)
    angles = rng.uniform(-0.7, 0.7, (3, 12))
    configuration = robot("spherical_3rrr").assemble(actuators=dict(zip(CLAIMS["spherical_3rrr"].drives, angles, strict=True)))
    for found, given in zip(configuration.platform_frame, angles.T, strict=True):
        np.testing.assert_allclose(found[:3, :3], spherical_orientation(given), atol=1e-10)
        np.testing.assert_allclose(found[:3, 3], 0, atol=1e-10)


@pytest.mark.parametrize("which", [1, 2])
def test_spherical_inverse_kinematics(which):
    configuration = assembled("spherical_3rrr", which)
    expected = spherical_angles(configuration.platform_frame[:3, :3])
    np.testing.assert_allclose(drives("spherical_3rrr", configuration), expected, atol=1e-10)


@pytest.mark.parametrize("which", [0, 1, 2])
def test_spherical_statics(which):
    """From ω · (w × v) = (u × w) · v dθ/dt: only moments about O reach the actuators."""
    configuration = assembled("spherical_3rrr", which, density=0)
    R = configuration.platform_frame[:3, :3]
    u, w, v = spherical_axes(R, drives("spherical_3rrr", configuration))
    load = np.array([30.0, -20.0, 50.0, 2.0, -3.0, 1.0])
    moment = load[3:] + np.cross(0.01 * R[:, 2], [0, 0, -0.3 * G])
    rates = np.array([np.cross(w[i], v[i]) / (np.cross(u[i], w[i]) @ v[i]) for i in range(3)])
    close(forces("spherical_3rrr", ks.analyze(configuration, load=load)), np.linalg.solve(rates.T, -moment), 1e-10)


def test_spherical_zero_pose_is_isotropic():
    K = ks.analyze(robot("spherical_3rrr").assemble()).stiffness
    np.testing.assert_allclose(K[3:, 3:], K[3, 3] * np.eye(3), atol=1e-10 * K[3, 3])


# ---- Tripteron -------------------------------------------------------------------------------------------------------------


def box(E, nu, depth, width, wall):
    """Return a rectangular tube, deep across the limb's plane; torsion and shear as test_section_shear.py has them checked."""
    second = (width * depth**3 - (width - 2 * wall) * (depth - 2 * wall) ** 3) / 12
    tube = RectangularTube.of(width, depth, wall)
    area = width * depth - (width - 2 * wall) * (depth - 2 * wall)
    return Bar(E, E / 2 / (1 + nu), area, second, tube.J, tube.shear_coefficients(nu)[1])


def tripteron_limbs(o):
    """Yield the axis and the points of shoulder, elbow and wrist of every limb; the three are turned cyclically."""
    for i in range(3):
        axis, across_, up = (np.eye(3)[(i + k) % 3] for k in range(3))
        shoulder, wrist = -0.45 * across_ + (o @ axis) * axis, o - 0.05 * across_
        span = wrist - shoulder
        rise = turn(axis, np.arccos(np.linalg.norm(span) / 0.6)) @ unit(span)
        yield axis, (shoulder, shoulder + 0.3 * rise, wrist)
        assert rise @ up > 0


def test_tripteron_actuators_equal_platform_coordinates():
    rng = np.random.default_rng(3)
    values = rng.uniform(-0.15, 0.15, (3, 30))
    configuration = robot("tripteron").assemble(actuators=dict(zip(CLAIMS["tripteron"].drives, values, strict=True)))
    np.testing.assert_allclose(configuration.platform_frame[:, :3, 3], values.T, atol=1e-10)
    np.testing.assert_allclose(configuration.platform_frame[:, :3, :3], np.broadcast_to(np.eye(3), (30, 3, 3)), atol=1e-10)


@pytest.mark.parametrize("which", [0, 1, 2])
def test_tripteron_actuators_carry_one_load_component_each(which):
    load = np.array([300.0, -200.0, 500.0, 20.0, -30.0, 10.0])
    found = ks.analyze(assembled("tripteron", which, density=0, slider_mass=2), load=load, point=(0.03, 0.02, 0.01))
    # the third actuator lifts the platform and its own slider, which the file draws horizontally beside its rail
    close(forces("tripteron", found), -load[:3] + [0, 0, (5 + 2) * G], 1e-11)


@pytest.mark.parametrize("which", [0, 1, 2])
@pytest.mark.parametrize("drive", [5e7, np.inf])
def test_tripteron_stiffness(which, drive):
    """Arms are bent cantilevers on elastic actuators; three of their nine constraints are redundant."""
    configuration = assembled("tripteron", which, **({} if drive == 5e7 else {"actuator_stiffness": drive}))
    o = configuration.platform_frame[:3, 3]
    tube = box(70e9, 0.33, 0.08, 0.05, 0.004)
    K = sum(limb_across(points, (tube, tube), axis, o, drive) for axis, points in tripteron_limbs(o))
    blocks_close(ks.analyze(configuration).stiffness, K, 1e-11)


# ---- linear Delta, 3-PUU -----------------------------------------------------------------------------------------------------

TOWERS = np.radians([0.0, 120.0, 240.0])
ROD, REACH, HOME = 0.301, 0.212357 - 0.03 - 0.03, 0.1385


def linear_delta_rods(o):
    """Return the tangents t_i, platform points P_i and the directions d_i from carriages to platform (3, 3 each)."""
    out = np.stack([np.cos(TOWERS), np.sin(TOWERS), np.zeros(3)], axis=1)
    P = o + 0.03 * out
    C = (0.03 + REACH) * out
    C[:, 2] = o[2] + np.sqrt(ROD**2 - np.sum((P - C)[:, :2] ** 2, axis=1))
    return np.cross(Z, out), P, (P - C) / ROD


def test_linear_delta_inverse_kinematics():
    """By the formula in the firmware of such printers."""
    rng = np.random.default_rng(4)
    x, y, z = rng.uniform(-0.085, 0.085, 20), rng.uniform(-0.085, 0.085, 20), rng.uniform(0, 0.277, 20)
    configuration = robot("linear_delta").assemble(platform={"x": x, "y": y, "z": z})
    for joint, a in zip(CLAIMS["linear_delta"].drives, TOWERS, strict=True):
        height = z + np.sqrt(ROD**2 - (x - REACH * np.cos(a)) ** 2 - (y - REACH * np.sin(a)) ** 2)
        expected = height - HOME - np.sqrt(ROD**2 - REACH**2)
        np.testing.assert_allclose(configuration.actuators[joint], expected, atol=1e-10)
    np.testing.assert_allclose(configuration.platform_frame[:, :3, :3], np.broadcast_to(np.eye(3), (20, 3, 3)), atol=1e-10)


@pytest.mark.parametrize("which", [0, 1, 2])
def test_linear_delta_statics(which):
    configuration = assembled("linear_delta", which, density=0)
    load = np.array([3.0, -2.0, 5.0, 0.2, -0.3, 0.1])
    _, _, d = linear_delta_rods(configuration.platform_frame[:3, 3])
    pushes = np.linalg.solve(d.T, -(load[:3] - [0, 0, 0.35 * G]))  # what each rod puts on the platform along itself
    close(forces("linear_delta", ks.analyze(configuration, load=load)), pushes * d[:, 2] + 0.15 * G, 1e-11)


@pytest.mark.parametrize("which", [0, 1, 2])
def test_linear_delta_stiffness(which):
    """A rod between universal joints carries a force along itself and a couple across both their axes, and they do not mix."""
    configuration = assembled("linear_delta", which)
    o = configuration.platform_frame[:3, 3]
    area, second = np.pi / 4 * (0.012**2 - 0.01**2), np.pi / 64 * (0.012**4 - 0.01**4)
    K = np.zeros((6, 6))
    for tangent, P, d in zip(*linear_delta_rods(o), strict=True):
        force = np.concatenate([d, np.cross(P - o, d)])
        K += 90e9 * area / ROD * np.outer(force, force)
        couple = np.cross(tangent, unit(np.cross(tangent, d)))
        twisting = (couple @ d) ** 2
        compliance = ROD * (twisting / (8e9 * 2 * second) + (1 - twisting) / (90e9 * second))
        K[3:, 3:] += np.outer(couple, couple) / compliance
    blocks_close(ks.analyze(configuration).stiffness, K, 1e-11)


def test_linear_delta_in_its_symmetric_pose():
    """By symmetry the rods alone shorten, and every actuator lifts its carriage, its rod and a third of the platform."""
    found = ks.analyze(robot("linear_delta").assemble())
    area, rise = np.pi / 4 * (0.012**2 - 0.01**2), np.sqrt(ROD**2 - REACH**2)
    rod = 1550 * area * ROD
    np.testing.assert_allclose(forces("linear_delta", found), (0.15 + rod + 0.35 / 3) * G, rtol=1e-11)
    # a third of the platform and half a rod hang on a rod's average section
    stretch = (0.35 / 3 + rod / 2) * G * ROD / rise * ROD / (90e9 * area)
    close(found.twist, [0, 0, -stretch * ROD / rise, 0, 0, 0], 1e-10)
    axial = 90e9 * area / ROD
    expected = [1.5 * axial * (REACH / ROD) ** 2, 1.5 * axial * (REACH / ROD) ** 2, 3 * axial * (rise / ROD) ** 2]
    np.testing.assert_allclose(np.diag(found.stiffness)[:3], expected, rtol=1e-11)


# ---- Delta -----------------------------------------------------------------------------------------------------------------

ARM, DELTA_ROD, WIDTH = 0.3, 0.8, 0.1


def delta_limbs(o):
    """Yield the arm's angle, tangent, elbow E, middle P of the pair's ends and direction of the rods, all limbs in turn.

    Clavel's inverse kinematics: in the plane of the arm the elbow lies on a circle about the motor, and on a sphere about P.
    """
    for azimuth in TOWERS:
        out, tangent = np.array([np.cos(azimuth), np.sin(azimuth), 0]), np.array([-np.sin(azimuth), np.cos(azimuth), 0])
        P = o + 0.05 * out
        from_motor = P - 0.15 * out
        u, w = from_motor @ out, from_motor @ Z
        reach = (from_motor @ from_motor + ARM**2 - DELTA_ROD**2) / (2 * ARM)
        angle = np.arctan2(-w, u) - np.arccos(reach / np.hypot(u, w))
        E = 0.15 * out + ARM * (np.cos(angle) * out - np.sin(angle) * Z)
        yield angle, tangent, E, P, (P - E) / DELTA_ROD


def test_delta_inverse_kinematics():
    rng = np.random.default_rng(5)
    targets = np.array([rng.uniform(-0.35, 0.35, 20), rng.uniform(-0.35, 0.35, 20), rng.uniform(-0.8, -0.55, 20)])
    configuration = robot("delta").assemble(platform=dict(zip("xyz", targets, strict=True)))
    expected = [[angle for angle, *_ in delta_limbs(o)] for o in targets.T]
    np.testing.assert_allclose(drives("delta", configuration), expected, atol=1e-10)
    np.testing.assert_allclose(configuration.platform_frame[:, :3, :3], np.broadcast_to(np.eye(3), (20, 3, 3)), atol=1e-10)


@pytest.mark.parametrize("which", [0, 1, 2])
def test_delta_statics(which):
    """Rods without weight push along themselves; a moment on the platform makes those of a pair differ, reaching no actuator."""
    configuration = assembled("delta", which, density=0)
    load = np.array([30.0, -20.0, 50.0, 2.0, -3.0, 1.0])
    limbs = list(delta_limbs(configuration.platform_frame[:3, 3]))
    pushes = np.linalg.solve(np.array([d for *_, d in limbs]).T, -(load[:3] - [0, 0, 1.2 * G]))
    torques = []
    for push, (angle, tangent, E, _, d) in zip(pushes, limbs, strict=True):
        slope = np.cross(tangent, E - 0.15 * np.cross(tangent, Z))  # of the elbow's place by the arm's angle
        torques.append(slope @ d * push + 0.15 * G * slope[2])
        assert slope[2] == pytest.approx(-ARM * np.cos(angle))
    close(forces("delta", ks.analyze(configuration, load=load)), torques, 1e-10)


@pytest.mark.parametrize("which", [0, 1, 2])
def test_delta_stiffness(which):
    """Rods are struts, arms are cantilevers, and the crossbar at an elbow leads the struts' forces into the arm."""
    configuration = assembled("delta", which)
    o = configuration.platform_frame[:3, 3]
    area, second = np.pi / 4 * (0.05**2 - 0.044**2), np.pi / 64 * (0.05**4 - 0.044**4)
    EA, GA, EI, GJ = 70e9 * area, 0.5 * 20e9 * area, 70e9 * second, 20e9 * 2 * second
    tip = np.diag([ARM / EA, ARM**3 / 3 / EI + ARM / GA, ARM**3 / 3 / EI + ARM / GA, ARM / GJ, ARM / EI, ARM / EI])
    tip[1, 5] = tip[5, 1] = ARM**2 / 2 / EI
    tip[2, 4] = tip[4, 2] = -(ARM**2) / 2 / EI
    rod = DELTA_ROD / (110e9 * np.pi / 4 * (0.014**2 - 0.011**2))
    K = np.zeros((6, 6))
    for angle, tangent, _, P, d in delta_limbs(o):
        along = np.cos(angle) * np.cross(tangent, Z) - np.sin(angle) * Z
        R = np.kron(np.eye(2), np.column_stack([along, tangent, np.cross(along, tangent)]))
        pins = [side * WIDTH / 2 * tangent for side in (1, -1)]
        at_elbow = np.column_stack([np.concatenate([d, np.cross(pin, d)]) for pin in pins])
        at_o = np.column_stack([np.concatenate([d, np.cross(P + pin - o, d)]) for pin in pins])
        compliance = rod * np.eye(2) + at_elbow.T @ R @ tip @ R.T @ at_elbow
        K += at_o @ np.linalg.inv(compliance) @ at_o.T
    blocks_close(ks.analyze(configuration).stiffness, K, 1e-10)


# ---- Orthoglide --------------------------------------------------------------------------------------------------------------


def orthoglide_legs(o):
    """Return the directions (3, 3) of the legs from shoulders to wrists."""
    legs = np.tile(o, (3, 1))
    for i in range(3):
        legs[i, i] = -np.sqrt(LEG**2 - o @ o + o[i] ** 2)
    return legs / LEG


def test_orthoglide_kinematics():
    """(x - rho_x)² + y² + z² = L², and so on: offsets along the rails leave it as it is."""
    rng = np.random.default_rng(6)
    targets = rng.uniform(CUBE[0], CUBE[2], (20, 3))
    configuration = robot("orthoglide").assemble(platform=dict(zip("xyz", targets.T, strict=True)))
    expected = [o - LEG * np.diag(orthoglide_legs(o)) - LEG for o in targets]
    np.testing.assert_allclose(drives("orthoglide", configuration), expected, atol=1e-10)
    np.testing.assert_allclose(configuration.platform_frame[:, :3, :3], np.broadcast_to(np.eye(3), (20, 3, 3)), atol=1e-10)


def orthoglide_amplification(o):
    """Return how much faster than its actuators the platform moves, at most and at least, from their forces under unit loads.

    For points (..., 3): (2, ...).
    """
    weightless = {"density": 0, "head_mass": 0, "slider_mass": 0, "platform_mass": 0}
    x, y, z = np.moveaxis(np.array(o, dtype=float), -1, 0)[..., None]  # at each point all three loads
    pose = robot("orthoglide", **weightless).assemble(platform={"x": x + np.zeros(3), "y": y, "z": z})
    found = forces("orthoglide", ks.analyze(pose, load=np.hstack([np.eye(3), np.zeros((3, 3))])))
    return np.moveaxis(np.linalg.svd(found, compute_uv=False)[..., [0, -1]], -1, 0)


def test_orthoglide_is_isotropic_at_zero_and_bounded_by_its_design():
    np.testing.assert_allclose(orthoglide_amplification((0, 0, 0)), [1, 1], atol=1e-10)
    np.testing.assert_allclose(orthoglide_amplification([CUBE[2]] * 3), [2, 0.8], rtol=1e-9)
    np.testing.assert_allclose(orthoglide_amplification([CUBE[0]] * 3), [2, 0.5], rtol=1e-9)
    largest, least = orthoglide_amplification(np.random.default_rng(7).uniform(CUBE[0], CUBE[2], (5, 3)))
    assert np.all((least > 0.5) & (least < 1) & (largest > 1) & (largest < 2))


@pytest.mark.parametrize("which", [0, 1, 2])
def test_orthoglide_statics(which):
    """Bars without weight are struts where a force is concerned; sliders, heads and feet load the actuators by their weights."""
    configuration = assembled("orthoglide", which, density=0, head_mass=0)
    legs = orthoglide_legs(configuration.platform_frame[:3, 3])
    load = np.array([300.0, -200.0, 500.0, 20.0, -30.0, 10.0])
    pushes = np.linalg.solve(legs.T, -(load[:3] - [0, 0, 2 * G]))
    close(forces("orthoglide", ks.analyze(configuration, load=load)), pushes * np.diag(legs) + [0, 0, 2 * G], 1e-11)


@pytest.mark.parametrize("which", [0, 1, 2])
def test_orthoglide_stiffness_against_forces(which):
    """Two bars each, as long as the platform does not turn: parallelograms shear and legs swing freely."""
    configuration = assembled("orthoglide", which)
    legs = orthoglide_legs(configuration.platform_frame[:3, 3])
    expected = 2 * 70e9 * 0.03 * 0.016 / LEG * legs.T @ legs
    close(ks.analyze(configuration).stiffness[:3, :3], expected, 1e-11)
