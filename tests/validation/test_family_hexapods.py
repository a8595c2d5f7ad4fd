"""Hexapods, tripods and the five-bar of ``robots/``: mobility, and closed forms of kinematics, stiffness and forces.

The formulas are written out here, from the dimensions that the files give; of the package's own numbers they use the shear areas
alone. Wrenches and screws are about o, in world axes.
"""

import numpy as np
import pinocchio as pin
import pytest
from package_robots import robot

import kinetostatics as ks

G = 9.81
LOAD = np.array([120.0, -40.0, -500.0, 7.0, -3.0, 11.0])
X, Y, Z = np.eye(3)

#: mobility of the platform, redundant constraints, actuators
KINDS = {
    "gough_stewart": (6, 0, 6), "6rus": (6, 0, 6), "3prs": (3, 0, 3), "tricept": (3, 0, 3), "exechon": (3, 2, 3),
    "five_bar": (2, 3, 2),
}  # fmt: skip
#: two poses without symmetry
POSES = {
    "gough_stewart": (
        {"x": 0.004, "y": -0.003, "z": 0.247, "rx": 0.01, "ry": -0.02, "rz": 0.015},
        {"x": -0.006, "y": 0.002, "z": 0.241, "rx": -0.02, "ry": 0.01, "rz": 0.03},
    ),
    "6rus": (
        {"x": 0.05, "y": -0.04, "z": 0.68, "rx": 0.1, "ry": -0.15, "rz": 0.12},
        {"x": -0.07, "y": 0.03, "z": 0.6, "rx": -0.12, "ry": 0.08, "rz": -0.2},
    ),
    "3prs": ({"z": 0.6, "azimuth": 0.7, "tilt": 0.5}, {"z": 0.48, "azimuth": -2.1, "tilt": 0.69}),
    "tricept": ({"x": 0.25, "y": -0.13, "z": -1.1}, {"x": -0.1, "y": 0.22, "z": -0.8}),
    "exechon": ({"z": 0.31, "rx": 0.2, "ry": -0.2}, {"z": 0.28, "rx": -0.1, "ry": 0.3}),
    "five_bar": ({"x": 0.06, "y": 0.33}, {"x": -0.04, "y": 0.26}),
}
#: boxes of platform coordinates that docs/gallery/robots names as workspaces
WORKSPACES = {
    "gough_stewart": {
        "x": (-0.005, 0.005), "y": (-0.005, 0.005), "z": (0.24, 0.248), "rx": (-0.01, 0.01), "ry": (-0.01, 0.01),
        "rz": (-0.015, 0.015),
    },
    "6rus": {
        "x": (-0.05, 0.05), "y": (-0.05, 0.05), "z": (0.61, 0.69), "rx": (-0.08, 0.08), "ry": (-0.08, 0.08), "rz": (-0.1, 0.1),
    },
    "3prs": {"z": (0.45, 0.63), "azimuth": (-3.1, 3.1), "tilt": (0.01, np.radians(40))},
    "tricept": {"x": (-0.3, 0.3), "y": (-0.3, 0.3), "z": (-1.1, -0.8)},
    "exechon": {"z": (0.27, 0.32), "rx": (-0.2, 0.2), "ry": (-0.2, 0.3)},
    "five_bar": {"x": (-0.08, 0.08), "y": (0.25, 0.37)},
}  # fmt: skip
ORIENTATIONS = {"3prs": "tilt_torsion", "exechon": "YXZ"}


def assemble(name, coordinates, **parameters):
    return robot(name, **parameters).assemble(platform=coordinates, orientation=ORIENTATIONS.get(name))


def at_poses(name):
    """The zero pose and the two others."""
    return pytest.mark.parametrize("coordinates", [None, *POSES[name]])


def pose_at(name, coordinates, **parameters):
    """Return the configuration, the orientation and the position of the platform."""
    if coordinates is None:
        configuration = robot(name, **parameters).assemble()
    else:
        configuration = assemble(name, coordinates, **parameters)
    return configuration, configuration.platform_frame[:3, :3], configuration.platform_frame[:3, 3]


def close(found, expected, rtol=1e-10):
    expected = np.asarray(expected, dtype=float)
    np.testing.assert_allclose(found, expected, rtol=rtol, atol=rtol * np.abs(expected).max())


def ring(radius, azimuths):
    azimuths = np.radians(azimuths)
    return radius * np.stack([np.cos(azimuths), np.sin(azimuths), 0 * azimuths], axis=1)


def unit(v):
    return v / np.linalg.norm(v)


def screw(direction, point, o):
    """Unit force along a direction through a point."""
    return np.concatenate([direction, np.cross(point - o, direction)])


def weight(mass, centre, o):
    return mass * G * screw(-Z, centre, o)


def slope(function, at, step):
    """Gradient by central differences of fourth order."""
    rows = []
    for d in step * np.eye(len(at)):
        rows.append((8 * (function(at + d) - function(at - d)) - function(at + 2 * d) + function(at - 2 * d)) / (12 * step))
    return np.array(rows)


def coordinates_of(configuration):
    return np.array([float(value) for value in configuration.actuators.values()])


def forces_of(result):
    return np.array([float(value) for value in result.actuator_forces.values()])


# ---- all of them -----------------------------------------------------------------------------------------------------------


@pytest.mark.few(3)
@pytest.mark.parametrize("name", KINDS)
def test_mobility_constraints_and_actuators(name):
    one = robot(name)
    mobility = one.mobility
    assert (mobility.platform, mobility.redundant_constraints, len(one.description.actuated)) == KINDS[name]
    assert mobility.local == 0 and mobility.gap > 1e3


@pytest.mark.parametrize("name", KINDS)
def test_zero_pose_is_closed_within_limits_without_warnings(name):
    zero = robot(name).configuration(pin.neutral(robot(name).model), closure_tolerance=1e-12)
    assert not zero.limits_exceeded
    np.testing.assert_allclose(zero.platform_frame[:3, :3], np.eye(3), atol=1e-14)
    assert ks.analyze(zero, load=LOAD).warnings == zero.robot.warnings


@pytest.mark.few(3)
@pytest.mark.parametrize("name", KINDS)
def test_workspace_is_reached(name):
    """A grid over the workspace, corners included, is within all limits and stays well away from singular poses."""
    ranges = WORKSPACES[name]
    grid = np.meshgrid(*(np.linspace(*ends, 3 if len(ranges) == 6 else 9) for ends in ranges.values()), indexing="ij")
    poses = assemble(name, dict(zip(ranges, grid, strict=True)))
    assert np.all(poses.status == ks.Status.OK)
    found = ks.analyze(poses)
    assert np.all(found.status == ks.Status.OK)
    softest = np.linalg.eigvalsh(found.stiffness[..., :3, :3])[..., 0]
    assert softest.min() > 0.1 * softest.max()


# ---- Gough-Stewart ---------------------------------------------------------------------------------------------------------

GOUGH_BASE = ring(0.1755, np.array([-9.5, 9.5, 110.5, 129.5, 230.5, 249.5]))
GOUGH_TOP = ring(0.118, np.array([-47.9, 47.9, 72.1, 167.9, 192.1, 287.9]))
GOUGH_LENGTH = np.linalg.norm(GOUGH_TOP[0] + 0.244 * Z - GOUGH_BASE[0])


@at_poses("gough_stewart")
def test_gough_strut_lengths(coordinates):
    pose, R, o = pose_at("gough_stewart", coordinates)
    close(coordinates_of(pose) + GOUGH_LENGTH, np.linalg.norm(o + GOUGH_TOP @ R.T - GOUGH_BASE, axis=1), 1e-13)
    again = robot("gough_stewart").assemble(actuators=pose.actuators)  # forward kinematics
    np.testing.assert_allclose(again.platform_frame, pose.platform_frame, atol=1e-12)


@at_poses("gough_stewart")
def test_gough_stiffness_and_forces(coordinates):
    """K is the sum of the struts' axial stiffnesses, and the actuators push along the struts."""
    pose, R, o = pose_at("gough_stewart", coordinates, density=0, platform_mass=10)
    lines = o + GOUGH_TOP @ R.T - GOUGH_BASE
    screws = np.array([screw(unit(line), b, o) for line, b in zip(lines, GOUGH_BASE, strict=True)]).T
    cylinder, rod = 0.58 * GOUGH_LENGTH, 0.42 * GOUGH_LENGTH
    compliance = (cylinder / 0.05**2 + rod / 0.034**2) / (200e9 * np.pi / 4)
    found = ks.analyze(pose, load=LOAD)
    close(found.stiffness, screws @ screws.T / compliance)
    W = LOAD + weight(10, o + 0.04 * R[:, 2], o)
    close(forces_of(found), np.linalg.solve(screws, -W))
    close(found.twist, np.linalg.solve(screws.T, compliance * np.linalg.solve(screws, W)))


# ---- 6-RUS -----------------------------------------------------------------------------------------------------------------

CRANK, ROD = 0.18415, 0.7239
RUS_BASE = ring(0.4064, np.arange(0.0, 360, 60))
RUS_TOP = ring(0.40005, np.array([20.0, 40, 140, 160, 260, 280]))
RUS_LEVEL = ring(1.0, np.array([-90.0, 150, 30, 270, 150, 30]))  # the cranks' directions at zero


@at_poses("6rus")
def test_6rus_crank_angles(coordinates):
    """R. Eisele, Inverse kinematics of a Stewart platform, 2019: the angle at which the crank's tip is a rod's length from A."""
    pose, R, o = pose_at("6rus", coordinates)
    arms = o + RUS_TOP @ R.T - RUS_BASE
    e, f = 2 * CRANK * arms[:, 2], 2 * CRANK * np.sum(RUS_LEVEL * arms, axis=1)
    g = np.sum(arms**2, axis=1) + CRANK**2 - ROD**2
    np.testing.assert_allclose(coordinates_of(pose), np.arcsin(g / np.hypot(e, f)) - np.arctan2(f, e), atol=1e-12)


@at_poses("6rus")
def test_6rus_stiffness_and_torques(coordinates):
    """A rod's force bends its crank, whose motor holds it; K is the sum over the rods' lines."""
    pose, R, o = pose_at("6rus", coordinates, density=0)
    found = ks.analyze(pose, load=LOAD)
    beam = robot("6rus").description.beams["crank_1"]
    EA, GA_y, GA_z = 210e9 * 0.02 * 0.06, *beam.shear_areas * np.array(beam.shear_modulus)
    along_y = CRANK**3 / (3 * 210e9 * 0.06 * 0.02**3 / 12) + CRANK / GA_y
    along_z = CRANK**3 / (3 * 210e9 * 0.02 * 0.06**3 / 12) + CRANK / GA_z
    rod = ROD / (210e9 * np.pi / 4 * (0.03**2 - 0.022**2))
    K, screws, levers = np.zeros((6, 6)), [], []
    for q, level, b, a in zip(coordinates_of(pose), RUS_LEVEL, RUS_BASE, RUS_TOP, strict=True):
        crank, lift = np.cos(q) * level + np.sin(q) * Z, np.cos(q) * Z - np.sin(q) * level
        tip = b + CRANK * crank
        line = unit(o + R @ a - tip)
        axis = np.cross(level, Z)
        compliance = rod + (line @ crank) ** 2 * CRANK / EA + (line @ axis) ** 2 * along_y + (line @ lift) ** 2 * along_z
        screws.append(screw(line, tip, o))
        levers.append(CRANK * line @ lift)
        K += np.outer(screws[-1], screws[-1]) / compliance
    close(found.stiffness, K)
    W = LOAD + weight(160, o + 0.3 * R[:, 2], o)
    close(forces_of(found), np.linalg.solve(np.array(screws).T, -W) * levers)


# ---- 3-PRS -----------------------------------------------------------------------------------------------------------------

PRS_BASE, PRS_TOP, LINK = ring(0.35, np.array([0.0, 120, -120])), ring(0.25, np.array([0.0, 120, -120])), 0.55
PRS_BOX = 0.09 * 0.07 - 0.074 * 0.054


@at_poses("3prs")
def test_3prs_parasitic_motion(coordinates):
    """Carretero et al. 2000: o is carried along by the orientation. Bonev 2002: in tilt and torsion, there is no torsion."""
    pose, R, o = pose_at("3prs", coordinates)
    assert R[1, 0] == pytest.approx(R[0, 1], abs=1e-13)
    assert o[0] == pytest.approx(0.125 * (R[0, 0] - R[1, 1]), abs=1e-13)
    assert o[1] == pytest.approx(-0.25 * R[1, 0], abs=1e-13)
    if coordinates is not None:
        azimuth, tilt = coordinates["azimuth"], coordinates["tilt"]
        assert pose.platform["torsion"] == pytest.approx(0, abs=1e-13)
        moved = 0.125 * (1 - np.cos(tilt)) * np.array([-np.cos(2 * azimuth), np.sin(2 * azimuth)])
        np.testing.assert_allclose(o[:2], moved, atol=1e-13)


@pytest.mark.few(4)
@pytest.mark.parametrize("guide_tilt", [0.0, 0.3, -0.2])
@at_poses("3prs")
def test_3prs_carriage_positions(coordinates, guide_tilt):
    pose, R, o = pose_at("3prs", coordinates, guide_tilt=guide_tilt)
    guides = np.cos(guide_tilt) * Z + np.sin(guide_tilt) * PRS_BASE / 0.35
    d = o + PRS_TOP @ R.T - PRS_BASE
    at = np.sum(guides * d, axis=1)
    np.testing.assert_allclose(coordinates_of(pose), at - np.sqrt(at**2 - np.sum(d**2, axis=1) + LINK**2), atol=1e-13)


@at_poses("3prs")
def test_3prs_stiffness(coordinates):
    """A link holds the platform along itself, as a strut, and along its hinge's axis, as a cantilever on its carriage."""
    pose, R, o = pose_at("3prs", coordinates)
    beam = robot("3prs").description.beams["link_1"]
    across = LINK**3 / (3 * 210e9 * (0.07 * 0.09**3 - 0.054 * 0.074**3) / 12) + LINK / (beam.shear_modulus * beam.shear_areas[0])
    K = np.zeros((6, 6))
    for q, b, a in zip(coordinates_of(pose), PRS_BASE, PRS_TOP, strict=True):
        top, hinge = o + R @ a, np.cross(Z, b) / 0.35
        along, sideways = screw(unit(top - b - q * Z), top, o), screw(hinge, top, o)
        K += np.outer(along, along) * 210e9 * PRS_BOX / LINK + np.outer(sideways, sideways) / across
    close(ks.analyze(pose).stiffness, K)


# ---- Tricept ---------------------------------------------------------------------------------------------------------------

TRICEPT_BASE, TRICEPT_TOP = ring(0.45, np.array([0.0, 120, -120])), ring(0.2, np.array([0.0, 120, -120]))


def tricept_struts(o):
    """Return the struts' vectors for a place of o: the tube points from O to o, and turns first about X, then about its y."""
    length = np.linalg.norm(o)
    down = -o / length
    second = unit(np.cross(down, X))
    R = np.stack([np.cross(second, down), second, down], axis=1)
    return o + TRICEPT_TOP @ R.T - TRICEPT_BASE, R


@at_poses("tricept")
def test_tricept_kinematics(coordinates):
    pose, R, o = pose_at("tricept", coordinates)
    lines, expected = tricept_struts(o)
    np.testing.assert_allclose(R, expected, atol=1e-13)
    close(coordinates_of(pose) + np.hypot(0.25, 1), np.linalg.norm(lines, axis=1), 1e-13)
    assert robot("tricept").joint_coordinates.at(pose.model_q, pose.frames)["prismatic_4"] == pytest.approx(np.linalg.norm(o) - 1)


@at_poses("tricept")
def test_tricept_stiffness(coordinates):
    """The struts hold along themselves; the tube takes two forces through O across itself and a couple normal to both axes."""
    pose, R, o = pose_at("tricept", coordinates)
    found = ks.analyze(pose)
    lines, _ = tricept_struts(o)
    screws = np.array([screw(unit(line), b, o) for line, b in zip(lines, TRICEPT_BASE, strict=True)]).T
    lengths = np.linalg.norm(lines, axis=1)
    K = (screws * (210e9 * np.pi / 4 * 0.05**2 / lengths)) @ screws.T
    along, length, couple = unit(o), np.linalg.norm(o), np.cross(X, R[:, 1])
    across = R[:, :2].T
    J = np.array([*(screw(force, np.zeros(3), o) for force in across), np.concatenate([np.zeros(3), unit(couple)])]).T
    beam = robot("tricept").description.beams["tube"]
    EI, GA = 210e9 * np.pi / 64 * (0.2**4 - 0.16**4), beam.shear_modulus * beam.shear_areas[0]
    GJ, c = 2 * EI / 2.6, unit(couple)
    C = np.diag([length**3 / (3 * EI) + length / GA] * 2 + [0.0])
    C[2, 2] = length * ((c @ along) ** 2 / GJ + (1 - (c @ along) ** 2) / EI)
    C[:2, 2] = C[2, :2] = [length**2 / (2 * EI) * np.cross(force, along) @ c for force in across]
    close(found.stiffness, K + J @ np.linalg.solve(C, J.T))
    # the constraint wrenches of the passive limb span the same space
    limb = found.limbs["limb_4"].constraint_wrenches
    assert limb.shape == (6, 3)
    assert np.linalg.matrix_rank(np.hstack([limb / np.linalg.norm(limb, axis=0), J]), tol=1e-10) == 3


@at_poses("tricept")
def test_tricept_forces(coordinates):
    """Massless struts and tube: the actuators' forces are the slope of the platform's energy over the struts' lengths."""
    pose, _, o = pose_at("tricept", coordinates, density=0)
    force = np.array([120.0, -40.0, -500.0])

    def energy(o):
        return -force @ o + 150 * G * (o - 0.2 * tricept_struts(o)[1][:, 2])[2]

    jacobian = slope(lambda o: np.linalg.norm(tricept_struts(o)[0], axis=1), o, 1e-3)
    found = ks.analyze(pose, load=[*force, 0, 0, 0])
    close(forces_of(found), np.linalg.solve(jacobian, slope(energy, o, 1e-3)), 1e-9)


# ---- Exechon ---------------------------------------------------------------------------------------------------------------

EXECHON_BASE = np.array([[0, -0.05, 0], [0, 0.05, 0], [0.18, 0, 0]])
EXECHON_TOP = np.array([[0, -0.05, 0], [0, 0.05, 0], [0.086, 0, 0]])
EXECHON_HOME = np.linalg.norm(EXECHON_TOP + 0.3 * Z - EXECHON_BASE, axis=1)


def exechon_pose(z, turn, tilt):
    """Return R and o: the plane of legs 1 and 2 turns about Y, the platform tilts in it, and leg 3 pulls o sideways."""
    c, s, ct, st = np.cos(turn), np.sin(turn), np.cos(tilt), np.sin(tilt)
    R = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]) @ np.array([[1, 0, 0], [0, ct, -st], [0, st, ct]])
    height = z / c
    return R, np.array([height * s, np.tan(tilt) * (0.18 * s - height), z])


def exechon_legs(z, turn, tilt):
    R, o = exechon_pose(z, turn, tilt)
    return o + EXECHON_TOP @ R.T - EXECHON_BASE


def exechon_three(coordinates):
    return (0.3, 0.0, 0.0) if coordinates is None else (coordinates["z"], coordinates["ry"], coordinates["rx"])


@at_poses("exechon")
def test_exechon_kinematics(coordinates):
    """Zoppi, Zlatanov, Molfino 2010: legs 1 and 2 stay in a plane through Y, leg 3 in the plane normal to the platform's y."""
    pose, R, o = pose_at("exechon", coordinates)
    expected, place = exechon_pose(*exechon_three(coordinates))
    np.testing.assert_allclose(R, expected, atol=1e-13)
    np.testing.assert_allclose(o, place, atol=1e-13)
    legs = o + EXECHON_TOP @ R.T - EXECHON_BASE
    np.testing.assert_allclose([legs[0] @ R[:, 0], legs[1] @ R[:, 0], Y @ R[:, 0], legs[2] @ R[:, 1]], 0, atol=1e-13)
    close(coordinates_of(pose) + EXECHON_HOME, np.linalg.norm(legs, axis=1), 1e-13)


@at_poses("exechon")
def test_exechon_overconstraint(coordinates):
    """Legs 1 and 2 each hold a force along the platform's x through B and a couple; these four wrenches have rank two."""
    pose, R, o = pose_at("exechon", coordinates)
    limbs = list(ks.analyze(pose).limbs.values())
    held = []
    for limb, b in zip(limbs[:2], EXECHON_BASE, strict=False):
        couple = np.concatenate([np.zeros(3), np.cross(Y, R[:, 0])])
        for column, expected in zip(limb.constraint_wrenches.T[1:], (screw(R[:, 0], b, o), couple), strict=True):
            assert min(np.abs(column - expected).max(), np.abs(column + expected).max()) < 1e-12
            held.append(expected)
    third = limbs[2].constraint_wrenches.T[1]
    assert min(np.abs(third - sign * screw(R[:, 1], EXECHON_BASE[2], o)).max() for sign in (1, -1)) < 1e-12
    assert np.linalg.matrix_rank(held, tol=1e-10) == 2
    every = np.hstack([limb.constraint_wrenches for limb in limbs])
    assert every.shape == (6, 8) and np.linalg.matrix_rank(every, tol=1e-3) == 6


@at_poses("exechon")
def test_exechon_forces(coordinates):
    """Massless legs: the actuators' forces are the slope of the platform's energy over the legs' lengths."""
    pose, _, _ = pose_at("exechon", coordinates, density=0)
    found = forces_of(ks.analyze(pose))

    def energy(at):
        R, o = exechon_pose(*at)
        return 12 * G * (o + R @ [0.043, 0, 0.06])[2]

    at = np.array(exechon_three(coordinates))
    jacobian = slope(lambda at: np.linalg.norm(exechon_legs(*at), axis=1), at, 1e-3)
    close(found, np.linalg.solve(jacobian, slope(energy, at, 1e-3)), 1e-9)
    if coordinates is None:  # moments about Y, where legs 1 and 2 stand
        third = 12 * G * 0.043 * EXECHON_HOME[2] / (0.3 * 0.18)
        half = (12 * G - third * 0.3 / EXECHON_HOME[2]) / 2
        close(found, [half, half, third], 1e-12)


# ---- five-bar --------------------------------------------------------------------------------------------------------------

ARM, MOTORS = 0.23, np.array([[-0.1375, 0], [0.1375, 0]])
ELBOWS_OUT = np.array([1, -1])
BAR_BOX, BAR_I = 0.04 * 0.03 - 0.034 * 0.024, (0.03 * 0.04**3 - 0.024 * 0.034**3) / 12


def turned(v):
    return np.stack([-v[..., 1], v[..., 0]], axis=-1)


def five_bar_shoulders(o):
    """Directions of the proximal links: isosceles triangles over the lines from the motors to C."""
    chord = o - MOTORS
    return np.arctan2(chord[:, 1], chord[:, 0]) + ELBOWS_OUT * np.arccos(np.linalg.norm(chord, axis=1) / (2 * ARM))


def five_bar_vectors(o):
    """Return unit vectors along proximal and distal links, each (2, 2)."""
    shoulders = five_bar_shoulders(o)
    proximal = np.stack([np.cos(shoulders), np.sin(shoulders)], axis=1)
    return proximal, (o - MOTORS - ARM * proximal) / ARM


@at_poses("five_bar")
def test_five_bar_kinematics(coordinates):
    pose, R, o = pose_at("five_bar", coordinates)
    home = np.array([0, 0.31])
    np.testing.assert_allclose(coordinates_of(pose), five_bar_shoulders(o[:2]) - five_bar_shoulders(home), atol=1e-13)
    # forward: C is where the circles about the elbows meet, on the far side
    elbows = MOTORS + ARM * five_bar_vectors(o[:2])[0]
    half = (elbows[1] - elbows[0]) / 2
    far = np.sqrt(ARM**2 / (half @ half) - 1)
    np.testing.assert_allclose(o, [*(elbows[0] + half + far * turned(half)), 0], atol=1e-13)
    # the tool turns with the distal link to which it is clamped
    directions = [np.arctan2(*five_bar_vectors(place)[1][0][::-1]) for place in (o[:2], home)]
    assert np.arctan2(R[1, 0], R[0, 0]) == pytest.approx(directions[0] - directions[1], abs=1e-13)


@at_poses("five_bar")
def test_five_bar_stiffness_and_torques_in_its_plane(coordinates):
    """A force at C goes along the distal links; each bends its proximal link, which the motor holds."""
    pose, _, o = pose_at("five_bar", coordinates, density=0)
    proximal, distal = five_bar_vectors(o[:2])
    beam = robot("five_bar").description.beams["proximal_1"]
    bending = ARM**3 / (3 * 70e9 * BAR_I) + ARM / (beam.shear_modulus * beam.shear_areas[0])
    stretching = ARM / (70e9 * BAR_BOX)
    along, across = np.sum(distal * proximal, axis=1), np.sum(distal * turned(proximal), axis=1)
    K = distal.T @ np.diag(1 / (stretching * (1 + along**2) + bending * across**2)) @ distal
    found = ks.analyze(pose, load=[30, -50, 0, 0, 0, 0])
    close(found.compliance[:2, :2], np.linalg.inv(K))
    close(forces_of(found), np.linalg.solve(distal.T, [-30, 50]) * ARM * across)
