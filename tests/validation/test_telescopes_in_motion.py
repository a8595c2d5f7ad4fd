"""Telescopic beams in motion: equations of Lagrange, energy, the choice of the beam's link, and two beams against Pinocchio."""

import numpy as np
import package_robots
import pinocchio as pin
import pytest
from telescopes import reaching_arm

import kinetostatics as ks

#: Weights of the first derivative by central differences of the eighth order.
FIRST = {1: 4 / 5, 2: -1 / 5, 3: 4 / 105, 4: -1 / 280}
WEIGHTLESS = (0, 0, 0)


def kinetic_energy(robot, masses, poses, step):
    """Return the kinetic energy at the middle of poses k step, k = −4 … 4, with frozen ``masses`` of the beams.

    Written from the file's data and the frames of links. Every section of a beam is at a fixed fraction of the way from start to
    end; its velocity, and so that of its mass, is linear in this fraction.
    """

    def rate(of):
        return sum(w * (of(poses[k]) - of(poses[-k])) for k, w in FIRST.items()) / step

    def spin(link):
        W = rate(lambda pose: pose.frame(link)[:3, :3]) @ poses[0].frame(link)[:3, :3].T
        return np.array([W[2, 1] - W[1, 2], W[0, 2] - W[2, 0], W[1, 0] - W[0, 1]]) / 2

    description, mechanism, total = robot.description, robot.mechanism, 0.0
    elastic = {beam.link for beam in description.beams.values()}
    for link in description.links.values():
        if link.name in elastic or not link.mass:
            continue
        centre, R, w = np.append(link.center_of_mass, 1.0), poses[0].frame(link.name)[:3, :3], spin(link.name)
        v = rate(lambda pose: pose.frame(link.name) @ centre)[:3]  # noqa: B023
        total += link.mass * v @ v / 2 + w @ R @ link.inertia.matrix @ R.T @ w / 2
    for name, model in robot.beams.items():
        span, section = model.span, model.section
        ends = ((span.start_link, span.start), (span.end_link, span.end))
        local = [np.linalg.inv(mechanism.body_of[link][1]) @ np.append(point, 1.0) for link, point in ends]

        def at(pose, fraction):
            start, end = (pose.frame(link) @ point for (link, _), point in zip(ends, local, strict=True))  # noqa: B023
            return (start + fraction * (end - start))[:3]

        off = np.zeros(3)
        if model.mass_per_length is None:  # the line of mass is parallel to the beam
            here, axis = np.append(description.links[span.part.link].center_of_mass, 1.0), at(poses[0], 1) - at(poses[0], 0)
            off = (poses[0].frame(span.part.link) @ here)[:3] - at(poses[0], 0)
            off -= axis * (off @ axis) / (axis @ axis)
        w = spin(span.part.link)
        first, last = (rate(lambda pose: at(pose, f)) + np.cross(w, off) for f in (0.0, 1.0))  # noqa: B023
        total += masses[name] * (first @ first + first @ last + last @ last) / 6
        J = poses[0].frame(span.part.link)[:3, :3] @ np.linalg.inv(mechanism.body_of[span.part.link][1][:3, :3]) @ model.axes
        own = np.diag([section.I_y + section.I_z, section.I_y, section.I_z]) / section.area
        total += masses[name] * w @ J @ own @ J.T @ w / 2
    return total


def masses_of(pose):
    return {name: float(beam.mass_at(pose.frames)[0]) for name, beam in pose.robot.beams.items()}


def energy_along(robot, at, near, masses, t, step=4e-3):
    """Return the kinetic energy at time t where actuators are at ``at(t)``."""
    poses = {k: robot.assemble(actuators=at(t + k * step), near=near) for k in range(-4, 5)}
    return kinetic_energy(robot, masses, poses, step)


def path_of(robot, seed=5):
    """Return actuator coordinates as a function of time, and their velocities and accelerations at t = 0."""
    rng, names = np.random.default_rng(seed), robot.description.actuated
    size = {n: 0.3 if robot.mechanism.connections[n].type.is_hinge else 0.05 for n in names}
    start, v, a = ({n: f * size[n] * rng.uniform(-1, 1) for n in names} for f in (0.3, 4, 30))
    zero = {n: float(value) for n, value in robot.assemble().actuators.items()}
    return lambda t: {n: zero[n] + start[n] + v[n] * t + a[n] * t**2 / 2 for n in names}, v, a


ARMS = {
    "of the rod": {},
    "of the cylinder": {"beam_link": "cylinder"},
    "with the rod's mass": {"density": "", "mass": 3.0},
    "with the cylinder's mass": {"beam_link": "cylinder", "density": "", "mass": 3.0},
}


@pytest.mark.parametrize("kind", ARMS)
def test_actuator_forces_are_those_of_lagrange_equations(kind):
    """d/dt ∂T/∂q̇ − ∂T/∂q by differences of T(q, q̇), which is quadratic in q̇, with the masses at the pose."""
    robot = reaching_arm(**ARMS[kind])
    names = robot.description.actuated
    q = np.array([0.3, -0.4, 0.35])
    v, a = np.array([1.3, -0.9, 0.8]), np.array([4.0, 6.0, -5.0])
    rest = robot.assemble(actuators=dict(zip(names, q, strict=True)))
    masses = masses_of(rest)

    def T(q, v):
        return energy_along(robot, lambda t: dict(zip(names, q + t * v, strict=True)), rest, masses, 0.0, 1e-2)

    def momentum(q, v):  # exact: T is quadratic in v
        return np.array([(T(q, v + unit) - T(q, v - unit)) / 2 for unit in np.eye(3)])

    step = 1e-2
    moved = sum(w * (momentum(q + k * step * v, v) - momentum(q - k * step * v, v)) for k, w in FIRST.items()) / step
    gained = momentum(q, a)
    ahead = {k: np.array([T(q + k * step * unit, v) for unit in np.eye(3)]) for k in range(-4, 5) if k}
    pushed = sum(w * (ahead[k] - ahead[-k]) for k, w in FIRST.items()) / step
    expected = moved + gained - pushed
    motion = ks.Motion(dict(zip(names, v, strict=True)), dict(zip(names, a, strict=True)))
    found = ks.analyze(rest, gravity=WEIGHTLESS, motion=motion).actuator_forces
    assert [found[n] for n in names] == pytest.approx(expected, abs=1e-8 * np.abs(expected).max())


@pytest.mark.few(2)
@pytest.mark.parametrize("name", ["3rps", "tricept", "2pru_upr", "exechon"])
def test_power_of_actuators_is_the_gain_of_kinetic_energy(name):
    """The masses of the beams are those of the pose."""
    robot = package_robots.robot(name)
    at, v, a = path_of(robot)
    rest = robot.assemble(actuators=at(0.0))
    masses, step = masses_of(rest), 4e-3
    energy = {k: energy_along(robot, at, rest, masses, k * step) for k in range(-4, 5) if k}
    gain = sum(w * (energy[k] - energy[-k]) for k, w in FIRST.items()) / step
    found = ks.analyze(rest, gravity=WEIGHTLESS, motion=ks.Motion(v, a)).actuator_forces
    powers = [found[n] * v[n] for n in v]
    assert sum(powers) == pytest.approx(gain, abs=1e-7 * max(map(abs, powers)))


@pytest.mark.parametrize("kind", ["with the rod's mass", "with the cylinder's mass"])
def test_work_along_a_path_is_the_gain_of_energy_of_a_constant_mass(kind):
    """With gravity, from rest to a moving pose and back to rest at another: the work is the gain of potential energy."""
    robot = reaching_arm(**ARMS[kind])
    ends = {"pan": [0.0, 0.5], "nod": [0.2, -0.6], "reach": [0.1, 0.7]}
    path = ks.trajectory(robot, [0.0, 0.4], actuators=ends, samples=2001).analyze()
    work = sum(np.trapezoid(power, path.times) for power in path.over_time("actuator_power").values())
    heights = []
    for k in (0, 1):
        pose = robot.assemble(actuators={name: values[k] for name, values in ends.items()})
        heights.append(pose.model.gravity.linear @ -pin.centerOfMass(pose.model, pose.model.createData(), pose.q))
    mass = sum(inertia.mass for inertia in pose.model.inertias)
    assert work == pytest.approx(mass * (heights[1] - heights[0]), rel=1e-6)


def test_results_do_not_depend_on_the_link_that_has_the_beam():
    """Force of the slide, sag, wrenches of other joints and stresses: the machine is the same."""
    motion = ks.Motion({"pan": 2.0, "nod": 1.0, "reach": 1.5}, {"nod": 8.0, "reach": 10.0})
    at = {"reach": 0.4, "pan": 0.2, "nod": 0.3}
    rod, cylinder = (
        ks.analyze(reaching_arm(link).assemble(actuators=at), gravity=WEIGHTLESS, motion=motion) for link in ("rod", "cylinder")
    )
    for name, force in rod.actuator_forces.items():
        assert cylinder.actuator_forces[name] == pytest.approx(force, rel=1e-9)
    assert cylinder.twist == pytest.approx(rod.twist, rel=1e-8)
    assert cylinder.joint_wrenches["pan"] == pytest.approx(rod.joint_wrenches["pan"], rel=1e-9)
    mine, other = ((*item.beams.values(),)[0].section_wrenches for item in (rod, cylinder))
    assert other == pytest.approx(mine, rel=1e-8, abs=1e-9 * np.abs(mine).max())


def test_a_stretching_rod_equals_the_closed_form():
    """A telescope that only stretches: the tension at s from the moving end is the force of the mass beyond, μ a ξ per length."""
    robot, acceleration = reaching_arm(), 10.0
    pose = robot.assemble(actuators={"reach": 0.4, "pan": 0.0, "nod": 0.0})
    found = ks.analyze(pose, gravity=WEIGHTLESS, motion=ks.Motion({}, {"reach": acceleration}))
    [(name, beam)] = found.beams.items()
    mass, xi = masses_of(pose)[name], beam.stations
    assert found.actuator_forces["reach"] == pytest.approx((1.5 + mass / 3) * acceleration, rel=1e-10)
    assert beam.section_wrenches[:, 0] == pytest.approx(-(1.5 + mass * (1 - xi**2) / 2) * acceleration, rel=1e-9)


def test_two_beams_equal_pinocchio():
    """A tube and a rod, the accurate model of a telescope, have the forces of the recursive Newton–Euler algorithm."""
    robot, rng = reaching_arm(two_beams=True), np.random.default_rng(1)
    names = robot.description.actuated
    q, v, a = (dict(zip(names, rng.uniform(-f, f, 3), strict=True)) for f in (0.3, 2, 9))
    pose = robot.assemble(actuators=q)
    rates = np.zeros((2, pose.model.nv))
    columns = {n: pose.model.joints[pose.model.getJointId(n)].idx_v for n in names}
    for n, column in columns.items():
        rates[:, column] = v[n], a[n]
    expected = pin.rnea(pose.model, pose.model.createData(), pose.q, *rates)
    found = ks.analyze(pose, motion=ks.Motion(v, a)).actuator_forces
    for n, column in columns.items():
        assert found[n] == pytest.approx(expected[column], rel=1e-11, abs=1e-10)


@pytest.mark.parametrize("link", ["rod", "cylinder"])
def test_free_actuators_let_a_telescope_stretch_when_it_vibrates(link):
    """At low frequencies the compliance is −J M⁻¹ Jᵀ/ω²; column k of M are the actuator forces for a unit acceleration of k."""
    robot, at = reaching_arm(link), {"pan": 0.3, "nod": -0.2, "reach": 0.4}
    pose = robot.assemble(actuators=at)
    forces = [ks.analyze(pose, gravity=WEIGHTLESS, motion=ks.Motion({}, {name: 1.0})).actuator_forces for name in at]
    M = np.array([[force[name] for name in at] for force in forces])
    J = package_robots.rates(robot, at, lambda pose: pose.platform_frame)
    found = ks.frequency_response(pose, [0.01, 0.02], damping=0.0, drives="free")
    expected = -J @ np.linalg.inv(M) @ J.T / (2 * np.pi * found.frequencies[:, None, None]) ** 2
    assert found.compliance == pytest.approx(expected, abs=1e-5 * np.abs(expected).max())


def test_modes_with_free_actuators_do_not_depend_on_the_link_that_has_the_beam():
    rod, cylinder = (
        ks.modes(reaching_arm(link).assemble(actuators={"reach": 0.4, "pan": 0.3, "nod": 0.2}), 4, drives="free")
        for link in ("rod", "cylinder")
    )
    assert cylinder.frequencies == pytest.approx(rod.frequencies, rel=1e-9) and np.all(np.isfinite(rod.frequencies))
    for name in ("strain_energy_shares", "kinetic_energy_shares"):
        mine, other = (next(value for key, value in getattr(item, name).items() if "beam" in key) for item in (rod, cylinder))
        assert other == pytest.approx(mine, abs=1e-8)
