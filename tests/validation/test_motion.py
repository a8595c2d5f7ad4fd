"""Loads in motion: inertia, Coriolis and centrifugal terms, against Pinocchio, closed forms and the balance of energy."""

from dataclasses import replace

import numpy as np
import package_robots
import pinocchio as pin
import pytest
import simple_machines as sm
import small_robots as sr
from mechanisms import Joint, Link
from small_robots import Limb

import kinetostatics as ks
from kinetostatics.load_case import LoadCase
from kinetostatics.verification.frame_model import build
from kinetostatics.verification.solve import solve

#: Weights of the first and second derivative by central differences of the eighth order.
FIRST = {1: 4 / 5, 2: -1 / 5, 3: 4 / 105, 4: -1 / 280}
SECOND = {0: -205 / 72, 1: 8 / 5, 2: -1 / 5, 3: 8 / 315, 4: -1 / 560}


def rates(of, step):
    """Return first and second derivative of a quantity with the values ``of[k]`` at the times k step, k = −4 … 4."""
    first = sum(w * (of[k] - of[-k]) for k, w in FIRST.items()) / step
    return first, sum(w * (of[k] + of[-k]) / (1 if k else 2) for k, w in SECOND.items()) / step**2


def by_inverse_dynamics(robot, at, step=4e-3):
    """Return actuator forces at t = 0 where actuators are at ``at(t)``: RNEA of the tree with loops cut, by virtual work."""
    names = robot.description.actuated
    rest = robot.assemble(actuators=at(0.0))
    model = rest.model
    data = model.createData()

    def q(actuators):
        return robot.assemble(actuators=actuators, near=rest).q

    def apart(there):
        return pin.difference(model, rest.q, there)

    v = sum(w * (apart(q(at(k * step))) - apart(q(at(-k * step)))) for k, w in FIRST.items()) / step
    a = sum(w * (apart(q(at(k * step))) + apart(q(at(-k * step)))) for k, w in SECOND.items() if k) / step**2
    tau = pin.rnea(model, data, rest.q, v, a)
    found = {}
    for name in names:
        moved = [{**at(0.0), name: at(0.0)[name] + k * step} for k in (*FIRST, *(-k for k in FIRST))]
        along = dict(zip((*FIRST, *(-k for k in FIRST)), (apart(q(item)) for item in moved), strict=True))
        found[name] = tau @ (sum(w * (along[k] - along[-k]) for k, w in FIRST.items()) / step)
    return found


def random_motion(robot):
    """Return actuator coordinates as a function of time, and their velocities and accelerations at t = 0."""
    rng, names = np.random.default_rng(3), robot.description.actuated
    size = {n: 0.3 if robot.mechanism.connections[n].type.is_hinge else 0.03 for n in names}
    start, v, a = ({n: size[n] * f * x for n, x in zip(names, rng.uniform(-1, 1, len(names)), strict=True)} for f in (0.3, 4, 60))
    zero = {n: float(value) for n, value in robot.assemble().actuators.items()}
    return lambda t: {n: zero[n] + start[n] + v[n] * t + a[n] * t**2 / 2 for n in names}, v, a


@pytest.mark.few(3)
@pytest.mark.parametrize("name", ["five_bar", "6rus", "delta", "orthoglide"])
def test_actuator_forces_in_motion_equal_inverse_dynamics(name):
    robot = package_robots.robot(name)
    at, v, a = random_motion(robot)
    found = ks.analyze(robot.assemble(actuators=at(0.0)), motion=ks.Motion(v, a)).actuator_forces
    expected = by_inverse_dynamics(robot, at)
    scale = max(abs(force) for force in expected.values())
    rounding = 2e-8 if name != "delta" else 1e-7  # its rods do not spin there, and without torque here
    for n, force in expected.items():
        assert found[n] == pytest.approx(force, abs=rounding * scale)


def moving_frame(robot, at, segments, step=4e-3):
    """Return the frame of OpenSees at t = 0, its beams in segments, with gravity and the inertia forces of d'Alembert.

    Accelerations of bodies are differences of the frames of links over time. That of a beam is linear between its ends, which
    move with their links. The load along a beam is constant in each segment, with a couple for its slope.
    """
    rest = robot.assemble(actuators=at(0.0))
    poses = {k: robot.assemble(actuators=at(k * step), near=rest) for k in range(-4, 5)}
    model = build(rest, LoadCase())
    description = robot.description
    elastic = {beam.link for beam in description.beams.values()}
    rigid = [link.name for link in description.links.values() if link.mass > 0 and link.name not in elastic]

    def acceleration(link):
        """Return the acceleration field of a link, and d'Alembert's couple by its inertia tensor."""
        frames = {k: pose.frame(link) for k, pose in poses.items()}
        (_, a), R = rates({k: frame[:3, 3] for k, frame in frames.items()}, step), frames[0][:3, :3]
        spin, change = (rate @ R.T for rate in rates({k: frame[:3, :3] for k, frame in frames.items()}, step))
        w, alpha = (np.array([M[2, 1] - M[1, 2], M[0, 2] - M[2, 0], M[1, 0] - M[0, 1]]) / 2 for M in (spin, change))
        return (
            lambda point: a + np.cross(alpha, point - frames[0][:3, 3]) + np.cross(w, np.cross(w, point - frames[0][:3, 3])),
            lambda inertia: -inertia @ alpha - np.cross(w, inertia @ w),
        )

    loads, references, beams = model.loads.copy(), list(model.references), []
    for link, body in zip(rigid, model.masses, strict=True):
        field, couple = acceleration(link)
        force = -body.mass * field(body.centre)
        loads[body.piece] += np.append(force, couple(body.inertia) + np.cross(body.centre - references[body.piece], force))
    for beam in model.beams:
        span, (_, couple) = robot.beams[beam.name].span, acceleration(description.beams[beam.name].link)
        points, inner = beam.divided(segments), range(len(references), len(references) + segments - 1)
        ends = zip((span.start_link, span.end_link), (points[0], points[-1]), strict=True)
        accelerations = np.linspace(*(acceleration(link)[0](point) for link, point in ends), 2 * segments + 1)
        EA, *_, EI_y, EI_z = beam.stiffness
        rotary = couple(beam.axes @ np.diag([EI_y + EI_z, EI_y, EI_z]) @ beam.axes.T * beam.mass / EA)
        pieces = [beam.pieces[0], *inner, beam.pieces[1]]
        references += list(points[1:-1])
        for k in range(segments):
            span = points[k + 1] - points[k]
            change = -beam.mass * (accelerations[2 * k + 2] - accelerations[2 * k])
            load = np.append(-beam.mass * accelerations[2 * k + 1], rotary + np.cross(span, change) / 12)
            part = replace(beam, name=f"{beam.name} {k}", pieces=tuple(pieces[k : k + 2]), points=points[k : k + 2])
            beams.append(replace(part, load=beam.load + load))
    loads = np.vstack([loads, np.zeros((len(references) - len(loads), 6))])
    return rest, replace(model, loads=loads, references=np.array(references), beams=tuple(beams))


FURTHER = ("five_bar", "6rus", "gough_stewart", "planar_3rrr", "tripteron", "orthoglide")


@pytest.mark.few(2)
@pytest.mark.parametrize(
    ("name", "rounding"),
    [
        ("3rps", 1e-10),
        ("2pru_upr", 1e-9),
        *(pytest.param(name, 1e-9, marks=pytest.mark.slow) for name in FURTHER),
        pytest.param("delta", 1e-6, marks=pytest.mark.slow),  # its rods are free to spin
    ],
)
def test_sag_in_motion_equals_finite_elements(name, rounding):
    """Twists are extrapolated to segments without length; forces do not depend on it."""
    robot = package_robots.robot(name)
    at, v, a = random_motion(robot)
    found = []
    for segments in (4, 8, 16):
        rest, model = moving_frame(robot, at, segments)
        found.append(solve(model)[0])
    ours, (coarse, mean, fine) = ks.analyze(rest, motion=ks.Motion(v, a)), found
    twist = (64 * fine.twist - 20 * mean.twist + coarse.twist) / 45  # without errors of the second and the fourth order
    unit = np.repeat([1.0, model.length], 3)
    scale = max(np.linalg.norm(wrench / unit) for wrench in fine.joint_wrenches.values())
    in_beams = {joint for beam in robot.beams.values() for joint in beam.span.spanned}  # the frame has them at a beam's end
    for joint in set(fine.joint_wrenches) & set(ours.joint_wrenches) - in_beams:
        assert ours.joint_wrenches[joint] / unit == pytest.approx(fine.joint_wrenches[joint] / unit, abs=rounding * scale)
    assert ours.twist * unit == pytest.approx(twist * unit, abs=rounding * np.linalg.norm(twist * unit))


def test_a_serial_arm_agrees_with_rnea_to_rounding():
    robot, rng = package_robots.robot("ur10"), np.random.default_rng(0)
    names = robot.description.actuated
    q, v, a = (dict(zip(names, rng.uniform(-f, f, 6), strict=True)) for f in (1, 2, 5))
    pose = robot.assemble(actuators=q)
    rates = np.zeros((2, pose.model.nv))
    for n in names:
        column = pose.model.joints[pose.model.getJointId(n)].idx_v
        rates[:, column] = v[n], a[n]
    tau = pin.rnea(pose.model, pose.model.createData(), pose.q, *rates)
    found = ks.analyze(pose, motion=ks.Motion(v, a)).actuator_forces
    for n in names:
        assert found[n] == pytest.approx(tau[pose.model.joints[pose.model.getJointId(n)].idx_v], rel=1e-11, abs=1e-10)


@pytest.mark.parametrize("name", ["orthoglide", "delta"])
def test_no_work_is_done_in_a_closed_cycle(name):
    """Without gravity the actuators' power over a period is zero; samples of a period are exact for what is smooth."""
    robot, n = package_robots.robot(name), 48
    t = 2 * np.pi * np.arange(n) / n
    base, size = robot.assemble(), {"x": 0.05, "y": 0.04, "z": 0.02}
    phase = dict(zip(size, (0.0, 0.7, 1.9), strict=True))
    path = {c: float(base.platform[c]) + s * np.sin(t + phase[c]) for c, s in size.items()}
    rates = [{c: s * f(t + phase[c]) for c, s in size.items()} for f in (np.cos, lambda x: -np.sin(x))]
    pose = robot.assemble(platform=path)
    found = ks.analyze(pose, gravity=(0, 0, 0), motion=ks.Motion(*rates))
    speeds = {a: np.real(np.fft.ifft(1j * np.fft.fftfreq(n, 1 / n) * np.fft.fft(value))) for a, value in pose.actuators.items()}
    power = np.array([found.actuator_forces[a] * speeds[a] for a in speeds])
    assert abs(power.sum()) < 1e-9 * np.abs(power).sum()


def turning_rod(**beam):
    return sr.locked_chain([(0, 0, 0), (0.8, 0, 0)], [(0, 0, 1)], **beam)


def test_turning_rod_equals_closed_form():
    """Tension μω²(L² − s²)/2; under angular acceleration the load −μαs per length, and the moment −ρIα."""
    L, d, w, alpha = 0.8, 0.05, 12.0, 40.0
    robot = sr.write(turning_rod(kappa=np.inf)).robot()
    found = ks.analyze(robot.assemble(), gravity=(0, 0, 0), motion=ks.Motion({"turn_1": w}, {"turn_1": alpha}))
    mu, A, inertia = sr.RHO * np.pi * d**2 / 4, np.pi * d**2 / 4, np.pi * d**4 / 64
    beam, s = found.beams["arm_1"], L * found.beams["arm_1"].stations
    assert beam.section_wrenches[:, 0] == pytest.approx(mu * w**2 * (L**2 - s**2) / 2, rel=1e-10, abs=1e-9)
    assert beam.section_wrenches[:, 1] == pytest.approx(-mu * alpha * (L**2 - s**2) / 2, rel=1e-10, abs=1e-9)
    assert found.twist[0] == pytest.approx(mu * w**2 * L**3 / 3 / (sr.E * A), rel=1e-10)
    tip = -mu * alpha * (11 * L**5 / 120) / (sr.E * inertia) - sr.RHO * inertia * alpha * L**3 / 3 / (sr.E * inertia)
    assert found.twist[1] == pytest.approx(tip, rel=1e-10)
    torque = mu * alpha * L**3 / 3 + sr.RHO * inertia * alpha * L
    assert found.actuator_forces["turn_1"] == pytest.approx(torque, rel=1e-10)
    assert beam.deflections[-1] == pytest.approx(found.twist[:3], rel=1e-9)
    assert found.strain_energy == pytest.approx(_energy(beam, s, sr.E * A, sr.E * inertia), rel=1e-6)


def _energy(beam, s, EA, EI):
    """Return ½ ∫ N²/EA + M²/EI ds by Simpson's rule."""
    density = (beam.section_wrenches[:, 0] ** 2 / EA + (beam.section_wrenches[:, 4:] ** 2).sum(axis=1) / EI) / 2
    weights = np.ones(len(s))
    weights[1:-1:2], weights[2:-1:2] = 4, 2
    return float(weights @ density) * (s[1] - s[0]) / 3


def test_splitting_beams_does_not_change_results():
    spec = turning_rod(mass=2.0)
    motion = ks.Motion({"turn_1": 5.0}, {"turn_1": -20.0})
    whole, parts = (ks.analyze(sr.write(item).robot().assemble(), motion=motion) for item in (spec, sr.split(spec, 4)))
    assert parts.twist == pytest.approx(whole.twist, rel=1e-9)
    assert parts.strain_energy == pytest.approx(whole.strain_energy, rel=1e-9)
    assert parts.beams["arm_1"].deflections[-1] == pytest.approx(whole.beams["arm_1"].deflections[5], rel=1e-9)
    assert parts.beams["arm_1"].section_wrenches[-1] == pytest.approx(
        whole.beams["arm_1"].section_wrenches[5], rel=1e-9, abs=1e-9
    )


@pytest.mark.parametrize("own_masses", [False, True])
def test_uniform_acceleration_equals_opposite_gravity(own_masses):
    """A frame of beams on an actuated slide: an acceleration a is gravity −a, for every result."""
    points = [(0, 0, 0), (0.5, 0.1, 0), (0.6, 0.5, 0.2)]
    chain = sr.locked_chain(points, [(0, 0, 1), (0, 1, 0)], mass=3.0)
    slide = Joint("slide", "P", (0, 0, 0), (1, 0, 0), actuated=True)
    limb = chain.limbs[0]
    links = (Link("sled", 4.0, (0.1, 0, 0)), *limb.links)
    spec = replace(chain, limbs=(Limb((slide, *limb.joints), links),))
    spec = sr.with_link_masses(spec) if own_masses else spec
    pose = sr.write(spec).robot().assemble()
    moved = ks.analyze(pose, gravity=(0, 0, 0), motion=ks.Motion(accelerations={"slide": 7.0}))
    heavy = ks.analyze(pose, gravity=(-7.0, 0, 0))
    scale = np.abs(heavy.twist).max()
    assert moved.twist == pytest.approx(heavy.twist, abs=1e-9 * scale)
    assert moved.strain_energy == pytest.approx(heavy.strain_energy, rel=1e-9)
    for name, beam in heavy.beams.items():
        for what in ("deflections", "rotations", "section_wrenches", "stress", "euler_ratio"):
            expected = getattr(beam, what)
            assert getattr(moved.beams[name], what) == pytest.approx(expected, rel=1e-8, abs=1e-9 * np.abs(expected).max())
    for name, wrench in heavy.joint_wrenches.items():
        assert moved.joint_wrenches[name] == pytest.approx(wrench, abs=1e-9 * np.abs(wrench).max() + 1e-9)


def test_payload_equals_a_heavier_platform():
    spec = turning_rod()
    motion = ks.Motion({"turn_1": 5.0}, {"turn_1": -20.0})
    inertia = ks.description.Inertia((1.0, 0, 0, 1.0, 0, 1.0))
    payload = ks.Payload(3.0, inertia=inertia)
    carried = ks.analyze(sr.write(spec).robot().assemble(), motion=motion, payload=payload)
    heavy = ks.analyze(sr.write(replace(spec, mass=3.0)).robot().assemble(), motion=motion)
    assert carried.twist == pytest.approx(heavy.twist, rel=1e-10)
    assert carried.actuator_forces["turn_1"] == pytest.approx(heavy.actuator_forces["turn_1"], rel=1e-10)


def test_batches_and_engines_agree():
    robot = package_robots.robot("3rps")
    z, rates = np.array([0.5, 0.55]), [{"z": np.array([0.4, -0.3]), "rx": 0.2}, {"z": 5.0}]
    pose = robot.assemble(platform={"z": z, "rx": 0.1, "ry": 0.0})
    found = ks.analyze(pose, motion=ks.Motion(*rates), engine="numpy")
    compiled = ks.analyze(pose, motion=ks.Motion(*rates), engine="compiled")
    assert compiled.twist == pytest.approx(found.twist, rel=1e-9, abs=1e-18)
    for k in range(2):
        single = ks.analyze(
            robot.assemble(platform={"z": z[k], "rx": 0.1, "ry": 0.0}),
            motion=ks.Motion({"z": rates[0]["z"][k], "rx": 0.2}, {"z": 5.0}),
        )
        assert single.twist == pytest.approx(found.twist[k], rel=1e-8)
        assert single.beams["rod_1"].stress == pytest.approx(found.beams["rod_1"].stress[k], rel=1e-8)
    loads = np.array([[[100.0, 0, 0, 0, 0, 0]], [[0, 0, 0, 0, 0, 0]], [[0, 0, 50.0, 0, 0, 0]]])
    assert ks.analyze(pose, loads, motion=ks.Motion(*rates)).twist[1] == pytest.approx(found.twist, rel=1e-9)


@pytest.mark.parametrize(
    ("motion", "words"),
    [
        ({"z": 1.0}, "Motion"),
        (ks.Motion({"w": 1.0}), "no platform coordinate 'w'"),
        (ks.Motion({"z": [1.0, 2.0, 3.0]}), "do not fit"),
        (ks.Motion({"z": "fast"}), "rate of z"),
    ],
)
def test_invalid_motions_raise_argument_error(motion, words):
    pose = package_robots.robot("3rps").assemble(platform={"z": [0.5, 0.55], "rx": 0.1, "ry": 0.0})
    with pytest.raises(ks.ArgumentError, match=words):
        ks.analyze(pose, motion=motion)


def test_contradictory_rates_are_refused():
    robot = package_robots.robot("anymal_standing")
    with pytest.raises(ks.ArgumentError, match="redundant actuators contradict"):
        ks.analyze(robot.assemble(), motion=ks.Motion(dict.fromkeys(robot.description.actuated, 0.2)))


def test_mass_beside_a_beam_feels_an_acceleration_as_opposite_gravity():
    """The mass of a link whose centre is beside its beam acts on the beam with a lever, at rest and in motion."""
    rod = (
        '<beam link="rod" from="foot" to="head" youngs_modulus="2e11" poisson_ratio="0.3" shear_coefficient="0.9">'
        '<circle diameter="0.03"/></beam>'
    )
    parts = sm.link("base"), sm.link("cart", 1.0), sm.link("rod", 3.0, "0.1 0.05 0.4"), sm.link("platform", 2.0)
    slide, foot = sm.joint("slide", "prismatic", "base", "cart", axis="1 2 0.5"), sm.joint("foot", "fixed", "cart", "rod")
    head = sm.joint("head", "fixed", "rod", "platform", "0 0 0.8")
    drive = '<transmission name="t"><joint name="slide"/></transmission>'
    pose, axis = sm.robot(*parts, slide, foot, head, rod, drive).assemble(), np.array([1, 2, 0.5]) / np.sqrt(5.25)
    moved = ks.analyze(pose, gravity=(0, 0, 0), motion=ks.Motion({"slide": 1.3}, {"slide": 4.0}))
    heavy = ks.analyze(pose, gravity=-4.0 * axis)
    np.testing.assert_allclose(moved.twist, heavy.twist, rtol=0, atol=1e-12 * np.abs(heavy.twist).max())
    wrenches = [found.beams["rod"].section_wrenches for found in (moved, heavy)]
    np.testing.assert_allclose(*wrenches, rtol=0, atol=1e-10 * np.abs(wrenches[1]).max())
    # clamped foot: the moment of 3 kg at the link's centre of mass and of 2 kg at the head
    moment = np.cross([0.1, 0.05, 0.4], 3.0 * -4.0 * axis) + np.cross([0, 0, 0.8], 2.0 * -4.0 * axis)
    np.testing.assert_allclose(heavy.joint_wrenches["foot"][3:], -moment, rtol=1e-9)
