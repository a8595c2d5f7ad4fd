"""Properties of every robot in every pose, and agreement with an independent finite element model."""

from dataclasses import replace
from functools import cache

import finite_elements
import numpy as np
import pinocchio as pin
import pytest
import small_robots as sr
from hypothesis import assume, example, given
from hypothesis import strategies as st

import kinetostatics as ks

SPECS = {
    "rps3": sr.rps3(),
    "pru2_upr": sr.pru2_upr(),
    "gough_ups": sr.gough(),
    "gough_sps": sr.gough("S"),
    "gough_rails": sr.gough(telescopic=False),
    "puu3": sr.puu3(),
    "four_bar": sr.four_bar(),
    "planar_3rrr": sr.planar_3rrr(),
    "portal": sr.portal(mass=7.0),
    "chain": sr.locked_chain([(0, 0, 0), (0.5, 0.1, 0), (0.7, 0.2, 0.5)], [(0, 0, 1), (1, 0, 0)], mass=2.0),
}
#: how far the actuators go [m, rad] in random poses
REACH = {
    "rps3": 0.08, "pru2_upr": 0.05, "gough_ups": 0.05, "gough_sps": 0.05, "gough_rails": 0.05, "puu3": 0.1, "four_bar": 0.3,
    "planar_3rrr": 0.1, "portal": 0.0, "chain": 1.5,
}  # fmt: skip
OVERCONSTRAINED = ("pru2_upr", "four_bar", "planar_3rrr", "portal")
MOVING = tuple(name for name in SPECS if REACH[name])
TELESCOPIC = ("rps3", "pru2_upr", "gough_ups", "gough_sps")

seeds = st.integers(0, 10**6)
names = st.sampled_from(tuple(SPECS))
moving = st.sampled_from(MOVING)


@cache
def written(name):
    return sr.write(SPECS[name])


@cache
def robot(name):
    return written(name).robot()


def drives(name, rng, shape=()):
    return {joint: REACH[name] * rng.uniform(-1, 1, shape) for joint in robot(name).description.actuated}


class Case:
    """A robot in a random pose under a random load and a random field of gravity."""

    def __init__(self, name, seed):
        self.name, self.rng = name, np.random.default_rng(seed)
        self.spec, self.written, self.robot = SPECS[name], written(name), robot(name)
        self.actuators = drives(name, self.rng)
        self.pose = self.robot.assemble(actuators=self.actuators)
        self.load = self.rng.standard_normal(6) * [100, 100, 100, 20, 20, 20]
        self.gravity = self.rng.standard_normal(3) * 6
        self.result = ks.analyze(self.pose, self.load, self.gravity)
        assert self.result.status == ks.Status.OK
        self.o = self.pose.platform_frame[:3, 3]

    def again(self, spec, load=None, gravity=None, **options):
        """Analyze a variant of the spec with the same actuators."""
        pose = sr.robot_of(spec, **options).assemble(actuators=self.actuators)
        load, gravity = self.load if load is None else load, self.gravity if gravity is None else gravity
        return ks.analyze(pose, load, gravity)

    def carried(self, link):
        """Return the link's displacement (4, 4) from the zero pose."""
        return self.pose.frame(link) @ np.linalg.inv(self.written.frames[link])

    def point(self, link, p):
        return self.carried(link)[:3, :3] @ p + self.carried(link)[:3, 3]

    def direction(self, link, a):
        return self.carried(link)[:3, :3] @ sr.unit(a)

    def joints(self, limb):
        """Yield every joint with its centre and its passive freedoms as twists about the centre."""
        links = ["base", *(k.name for k in limb.links), "platform"]
        for k, joint in enumerate(limb.joints):
            inner, outer = links[k], links[k + 1]
            yield (
                joint,
                self.point(outer, joint.centre),
                finite_elements.freedoms(joint, self.direction(inner, joint.axis), self.direction(outer, joint.axis2)),
            )

    def beam_ends(self, beam):
        limb = next(limb for limb in self.spec.limbs if any(k.name == beam.link for k in limb.links))
        joints, links = [j.name for j in limb.joints], [k.name for k in limb.links]
        at = links.index(beam.link)
        ends = []
        for name in (beam.start, beam.end):
            k = joints.index(name)
            ends.append(self.point(links[k] if k <= at else links[k - 1], limb.joints[k].centre))
        return ends

    def weights(self):
        """Yield mass, centre of mass and carrying link of everything that weighs something."""
        yield self.spec.mass, self.point("platform", self.spec.com), "platform"
        for limb in self.spec.limbs:
            for link in limb.links:
                if link.mass:
                    yield link.mass, self.point(link.name, link.com), link.name
        for beam in self.spec.beams:
            start, end = self.beam_ends(beam)
            yield beam.density * beam.section.area * np.linalg.norm(end - start), (start + end) / 2, beam.link


def about(wrench, old, new):
    """Move a wrench from one reference point to another."""
    return np.concatenate([wrench[:3], wrench[3:] + np.cross(old - new, wrench[:3])])


def motion(twist, old, new):
    """Return the twist of a body's point ``new`` from that at ``old``."""
    return np.concatenate([twist[:3] + np.cross(twist[3:], new - old), twist[3:]])


def same(found, expected, rtol=1e-9, scale=0.0):
    expected = np.asarray(expected, dtype=float)
    size = max(float(np.abs(expected).max(initial=0.0)), scale)
    np.testing.assert_allclose(found, expected, rtol=0, atol=rtol * size)


def same_twist(found, expected, rtol=1e-9):
    """Compare translations and rotations each by their own size."""
    same(found[..., :3], expected[..., :3], rtol)
    same(found[..., 3:], expected[..., 3:], rtol)


def same_forces(found, expected, rtol=1e-9):
    """Compare actuators' forces of two results."""
    assert set(found.actuator_forces) == set(expected.actuator_forces)
    for name, force in expected.actuator_forces.items():
        same(found.actuator_forces[name], force, rtol, scale=100.0)


# ---- equilibrium and compatibility ---------------------------------------------------------------------------------------


@given(names, seeds)
def test_stiffness_is_symmetric_positive_definite_inverse_of_compliance(name, seed):
    found = Case(name, seed).result
    scale = np.array([1, 1, 1, 0.3, 0.3, 0.3])
    K, C = found.stiffness / np.outer(scale, scale), found.compliance * np.outer(scale, scale)
    np.testing.assert_allclose(K, K.T, rtol=0, atol=1e-12 * np.abs(K).max())
    assert np.linalg.eigvalsh(K)[0] > 0
    np.testing.assert_array_equal(C, C.T)
    np.testing.assert_allclose(K @ C, np.eye(6), rtol=0, atol=1e-8)


@given(names, seeds)
def test_constraint_wrenches_are_reciprocal_to_all_passive_twists(name, seed):
    case = Case(name, seed)
    for limb, found in zip(case.spec.limbs, case.result.limbs.values(), strict=True):
        twists = [motion(t, centre, case.o) for _, centre, freedoms in case.joints(limb) for t in freedoms.T]
        J = found.constraint_wrenches
        T = np.array(twists).reshape(-1, 6).T
        np.testing.assert_allclose(T.T @ J, 0, atol=1e-10)
        rank = np.linalg.matrix_rank(T, tol=1e-6) if T.size else 0
        assert J.shape[1] == 6 - rank
        assert np.linalg.matrix_rank(J, tol=1e-6) == J.shape[1]
        np.testing.assert_allclose(found.compliance, found.compliance.T, rtol=0, atol=1e-13 * found.compliance.max())
        assert np.all(np.linalg.eigvalsh(found.compliance) > 0)
        for column, label in zip(J.T, found.labels, strict=True):  # unit forces or couples, as the labels say
            part = column[:3] if label.startswith("force") else column[3:]
            if not label.startswith("complementary"):
                assert np.linalg.norm(part) == pytest.approx(1)
            if label.startswith("couple"):
                np.testing.assert_allclose(column[:3], 0, atol=1e-12)


@given(names, seeds)
def test_platform_and_robot_are_in_equilibrium(name, seed):
    case = Case(name, seed)
    found, spec = case.result, case.spec
    com = case.point("platform", spec.com)
    weight = np.concatenate([spec.mass * case.gravity, np.cross(com - case.o, spec.mass * case.gravity)])
    same(found.platform_wrench, case.load + weight, 1e-12)
    total = np.zeros(6)
    for limb in found.limbs.values():
        parts = limb.constraint_wrenches @ limb.intensities + limb.attached_wrenches @ limb.attached_intensities
        same(parts, limb.wrench, 1e-11, scale=1.0)
        total += limb.wrench
    same(total, case.load + weight, 1e-9)

    # the base's reaction balances all weights and loads, and is the sum of its wrenches on the limbs
    total = about(case.load, case.o, np.zeros(3))
    for mass, com, _ in case.weights():
        total += np.concatenate([mass * case.gravity, np.cross(com, mass * case.gravity)])
    same(case.result.base_wrench, -total, 1e-9)
    reaction = np.zeros(6)
    for limb in case.spec.limbs:
        joint, centre, _ = next(case.joints(limb))
        reaction += about(case.result.joint_wrenches[case.written.runs[joint.name][0]], centre, np.zeros(3))
    same(case.result.base_wrench, reaction, 1e-11)


# ---- finite elements -----------------------------------------------------------------------------------------------------


def compare(spec, robot_written, pose, found, load, gravity, rtol=1e-8):
    answer = finite_elements.solve(spec, robot_written, pose, load, gravity)
    same(found.twist, answer.twist, rtol, scale=1e-8)
    same(found.compliance, answer.compliance, rtol, scale=1e-10)
    for joint, wrench in answer.joint_wrenches.items():
        own = found.joint_wrenches[robot_written.runs[joint][-1]]
        assert np.any(np.isnan(own)) == (not answer.sure[joint])
        if answer.sure[joint]:
            same(own, wrench, rtol, scale=100.0)
    for beam, ends in answer.ends.items():
        own = np.concatenate([found.beams[beam].deflections, found.beams[beam].rotations], axis=1)[[0, -1]]
        if answer.sure[f"ends of {beam}"] and not np.any(np.isnan(own)):
            same(own, ends, rtol, scale=float(np.abs(answer.twist).max()) + 1e-8)
    return answer


@given(names, seeds)
def test_statics_of_named_cases_agrees_with_finite_elements(name, seed):
    case = Case(name, seed)
    answer = compare(case.spec, case.written, case.pose, case.result, case.load, case.gravity)
    assert not answer.free and answer.unbalanced < 1e-9


serial_limbs = st.lists(st.text("RPUSCrp", min_size=1, max_size=4), min_size=2, max_size=4)


@given(serial_limbs, seeds)
@example(["Upp", "PCU"], 734)  # five constraint wrenches in all: the platform is free
@example(["P", "CPPR"], 1301)
@example(["pRP", "UCrR"], 1358)
@example(["S", "S"], 142)  # free, held by rigid limbs alone
@example(["C", "C", "CC"], 0)  # two equal rigid limbs
@example(["rp", "pC"], 5248)  # a tree whose joints are all actuated
def test_any_serial_limbs_agree_with_finite_elements_in_any_cut(kinds, seed):
    rng = np.random.default_rng(seed)
    spec = sr.random_spec(kinds, seed)
    file = sr.write_randomly(spec, rng, seed)
    one = file.robot()
    pose = one.configuration(pin.neutral(one.model))
    load, gravity = rng.standard_normal(6) * 50, rng.standard_normal(3) * 5
    answer = finite_elements.solve(spec, file, pose, load, gravity)
    assume(answer.gap > 1e9)  # neither almost singular nor almost held
    if answer.free:
        with pytest.raises((ks.exceptions.SingularPoseError, ks.exceptions.LimbEquilibriumError)):
            ks.analyze(pose, load, gravity)
        assert np.all(np.isnan(ks.analyze(pose, load, gravity, on_failure="nan").twist))
    elif answer.unbalanced > 1e-6:
        with pytest.raises(ks.exceptions.LimbEquilibriumError):
            ks.analyze(pose, load, gravity)
    else:
        found = ks.analyze(pose, load, gravity)
        compare(spec, file, pose, found, load, gravity, 1e-6)
        unsure = not all(sure for joint, sure in answer.sure.items() if not joint.startswith("ends"))
        assert (found.status == ks.Status.INDETERMINATE) == unsure


# ---- invariance ----------------------------------------------------------------------------------------------------------


@given(names, seeds, st.booleans())
def test_results_rotate_and_mirror_with_the_robot(name, seed, is_mirrored):
    case = Case(name, seed)
    M = np.diag([-1.0, 1, 1]) if is_mirrored else sr.random_rotation(case.rng)
    M6 = np.kron(np.diag([1.0, np.linalg.det(M)]), M)
    spec = sr.mirrored(case.spec) if is_mirrored else sr.rotated(case.spec, M)
    found = case.again(spec, M6 @ case.load, M @ case.gravity)
    same_twist(found.twist, M6 @ case.result.twist)
    same(found.stiffness, M6 @ case.result.stiffness @ M6.T)
    same(found.base_wrench, M6 @ case.result.base_wrench)
    same_forces(found, case.result)


@given(names, seeds)
def test_results_transform_with_the_reference_point(name, seed):
    case = Case(name, seed)
    shift = case.rng.standard_normal(3) * 0.3
    moved = replace(case.spec, o=tuple(np.asarray(case.spec.o) + shift))
    o = case.point("platform", moved.o)
    found = case.again(moved, about(case.load, case.o, o))
    same_twist(found.twist, motion(case.result.twist, case.o, o))
    X = np.array([motion(t, o, case.o) for t in np.eye(6)]).T  # the twist at the old point from that at the new one
    same(found.stiffness, X.T @ case.result.stiffness @ X)
    for part, twist in case.result.contributions.items():
        if part != "load":
            same(found.contributions[part], motion(twist, case.o, o), scale=float(np.abs(found.twist).max()))
    same_forces(found, case.result)


@given(names, seeds)
def test_results_do_not_depend_on_cuts_frames_and_order(name, seed):
    case = Case(name, seed)
    rng, limbs = case.rng, case.spec.limbs
    order = rng.permutation(len(limbs))
    options = {
        "tree": int(rng.integers(len(limbs))), "cuts": [int(rng.integers(len(limb.joints))) for limb in limbs],
        "whole": bool(rng.integers(2)), "piece": int(rng.integers(3)), "flip": bool(rng.integers(2)),
        "twirl": seed, "order": order,
    }  # fmt: skip
    file = sr.write(case.spec, **options)
    pose = file.robot().assemble(actuators=case.actuators)
    found = ks.analyze(pose, case.load, case.gravity)
    assert str(pose.robot.mobility) == str(case.robot.mobility)
    assert pose.robot.mobility.redundant_constraints == case.robot.mobility.redundant_constraints
    same_twist(found.twist, case.result.twist)
    same(found.stiffness, case.result.stiffness)
    same_forces(found, case.result)
    for n, place in enumerate(order, 1):
        same(found.contributions[f"limb_{n}"], case.result.contributions[f"limb_{place + 1}"], scale=1e-7)
        same(found.limbs[f"limb_{n}"].wrench, case.result.limbs[f"limb_{place + 1}"].wrench, scale=100.0)
    for joint, parts in file.runs.items():
        own, other = found.joint_wrenches[parts[-1]], case.result.joint_wrenches[case.written.runs[joint][-1]]
        same(own, other, scale=100.0)
    for beam in case.result.beams:
        same(section_wrenches(found.beams[beam]), section_wrenches(case.result.beams[beam]), scale=100.0)
        if not case.robot.mobility.local:
            same(found.beams[beam].deflections, case.result.beams[beam].deflections, scale=1e-7)


def section_wrenches(beam):
    """Return them in world axes: without y_axis the section's axes follow the link's."""
    return beam.section_wrenches @ np.kron(np.eye(2), beam.axes).T


@given(names, seeds, st.integers(2, 3), st.booleans())
def test_splitting_beams_does_not_change_results(name, seed, n, own_mass):
    case = Case(name, seed)
    spec = sr.with_link_masses(case.spec) if own_mass and name not in TELESCOPIC else case.spec
    found = case.again(sr.split(spec, n))
    same_twist(found.twist, case.result.twist)
    same(found.stiffness, case.result.stiffness)
    same_forces(found, case.result)
    for number, limb in case.result.limbs.items():
        assert found.limbs[number].labels == limb.labels
        same(found.limbs[number].intensities, limb.intensities, scale=10.0)
    assert found.strain_energy == pytest.approx(case.result.strain_energy, rel=1e-9)
    if name not in TELESCOPIC:
        for beam in case.spec.beams:  # the first of the pieces has the old one's first stations
            part, whole = found.beams[beam.name], case.result.beams[beam.name]
            same(part.section_wrenches[0], whole.section_wrenches[0], scale=10.0)
            same(part.deflections[0], whole.deflections[0], scale=float(np.abs(whole.deflections).max()))


@given(names, seeds)
def test_results_do_not_depend_on_the_length_unit(name, seed):
    case = Case(name, seed)
    spec = sr.in_millimetres(case.spec) if name not in TELESCOPIC else sr.in_millimetres(with_y_axes(case.spec))
    turns = [joint.name for limb in case.spec.limbs for joint in limb.joints if joint.kind == "R"]
    targets = {joint: value * (1 if joint in turns else 1000) for joint, value in case.actuators.items()}
    pose = sr.robot_of(spec).assemble(actuators=targets, closure_tolerance=1e-8)
    found = ks.analyze(pose, case.load * [1, 1, 1, 1000, 1000, 1000], case.gravity * 1000)
    same_twist(found.twist * [1e-3, 1e-3, 1e-3, 1, 1, 1], case.result.twist)
    units = np.outer([1e3, 1e3, 1e3, 1, 1, 1], [1, 1, 1, 1e-3, 1e-3, 1e-3])
    same(found.compliance / units, case.result.compliance)
    for joint, force in case.result.actuator_forces.items():
        same(found.actuator_forces[joint] / (1000 if joint in turns else 1), force, scale=100.0)


def with_y_axes(spec):
    """Return a spec whose beams all have a y_axis."""
    return replace(spec, beams=tuple(replace(b, y_axis=sr.any_across(spec, b)) for b in spec.beams))


# ---- superposition, scaling, energy --------------------------------------------------------------------------------------


@given(names, seeds)
def test_effects_of_load_and_gravity_superpose(name, seed):
    case = Case(name, seed)
    found = case.result
    same(sum(found.contributions.values()), found.twist, 1e-14)
    alone = ks.analyze(case.pose, case.load, (0, 0, 0))
    weight = ks.analyze(case.pose, (0, 0, 0, 0, 0, 0), case.gravity)
    same_twist(alone.twist, found.contributions["load"], 1e-10)
    same_twist(alone.twist + weight.twist, found.twist, 1e-10)
    same_twist(alone.twist, found.compliance @ case.load, 1e-8)
    for joint, force in found.actuator_forces.items():
        same(alone.actuator_forces[joint] + weight.actuator_forces[joint], force, 1e-10, scale=100.0)
    twice = ks.analyze(case.pose, 2 * case.load, -3 * case.gravity)
    same_twist(twice.twist, 2 * alone.twist - 3 * weight.twist, 1e-11)


@given(names, seeds)
def test_contribution_of_a_part_is_its_effect_alone(name, seed):
    case = Case(name, seed)
    nothing = (0, 0, 0, 0, 0, 0)
    size = float(np.abs(case.result.twist).max())
    number = int(case.rng.integers(len(case.spec.limbs)))
    own = [link.name for link in case.spec.limbs[number].links]
    limbs = tuple(
        limb if k == number else replace(limb, links=tuple(replace(link, mass=0.0) for link in limb.links))
        for k, limb in enumerate(case.spec.limbs)
    )
    only = replace(sr.with_beams(case.spec, density=lambda b: b.density if b.link in own else 0.0), limbs=limbs, mass=0.0)
    found = case.again(only, nothing)
    same(found.twist, case.result.contributions[f"limb_{number + 1}"], scale=size)
    bare = sr.with_beams(
        replace(case.spec, limbs=tuple(replace(limb, links=tuple(sr.Link(k.name) for k in limb.links)) for limb in limbs)),
        density=0.0,
    )
    same(case.again(bare, nothing).twist, case.result.contributions["platform_weight"], scale=size)


@given(st.sampled_from([name for name in SPECS if name not in OVERCONSTRAINED]), seeds)
def test_without_overconstraint_no_force_depends_on_stiffness(name, seed):
    case = Case(name, seed)
    assert case.robot.mobility.redundant_constraints == 0
    factors = {beam.name: case.rng.uniform(0.2, 5) for beam in case.spec.beams}
    found = case.again(sr.with_beams(case.spec, E=lambda b: b.E * factors[b.name], kappa=0.7))
    same_forces(found, case.result)
    for joint, wrench in case.result.joint_wrenches.items():
        same(found.joint_wrenches[joint], wrench, scale=100.0)


def line_integral(beam, values):
    """Integrate a polynomial of degree ≤ 5 given at a beam's stations over its length."""
    x = beam.stations * beam.length
    integral = np.polynomial.Polynomial.fit(x, values, 5).integ()
    return integral(x[-1]) - integral(x[0])


def work_of_weights(case, found, displaced):
    """Work of all weights over the displacements of a result."""
    twist_of = {link: sum(parts.values()) for link, parts in displaced.link_contributions.items()}
    work = 0.0
    bends = [beam.link for beam in case.spec.beams]
    for mass, com, link in case.weights():
        if link not in bends:
            moved = motion(twist_of[link], case.pose.frame(link)[:3, 3], com)
            work += mass * case.gravity @ moved[:3]
    for name, beam in displaced.beams.items():
        q = case.gravity * found.beams[name].mass / beam.length
        work += line_integral(beam, beam.deflections @ q)
    return work


@given(names, seeds)
def test_work_satisfies_betti_and_clapeyron(name, seed):
    case = Case(name, seed)
    found = case.result
    first, second = ks.analyze(case.pose, case.load, (0, 0, 0)), ks.analyze(case.pose, np.zeros(6), case.gravity)
    scale = float(np.sqrt(first.strain_energy * second.strain_energy))
    assert case.load @ second.twist == pytest.approx(work_of_weights(case, second, first), rel=1e-8, abs=1e-9 * scale)
    work = (case.load @ found.twist + work_of_weights(case, found, found)) / 2
    assert work == pytest.approx(float(found.strain_energy), rel=1e-8)
    assert sum(beam.strain_energy for beam in found.beams.values()) == pytest.approx(found.strain_energy)


STEPS = (-2, -1, 1, 2)


def slope(values, h):
    """Return the derivative from values at ``STEPS`` times h; error h⁴."""
    return (values[0] - 8 * values[1] + 8 * values[2] - values[3]) / (12 * h)


@given(moving, seeds)
def test_actuator_forces_are_virtual_work_of_loads_and_weights(name, seed):
    case = Case(name, seed)
    h = 1e-3
    masses = [(m, link, np.linalg.inv(case.pose.frame(link)) @ [*com, 1]) for m, com, link in case.weights()]

    def place(joint, step):
        moved = {**case.actuators, joint: case.actuators[joint] + step}
        return case.robot.assemble(actuators=moved, near=case.pose)

    for joint in case.actuators:
        poses = [place(joint, k * h) for k in STEPS]
        work = sum(m * case.gravity @ slope([(pose.frame(a) @ p)[:3] for pose in poses], h) for m, a, p in masses)
        moved = slope([pose.platform_frame for pose in poses], h)
        turning = moved[:3, :3] @ case.pose.platform_frame[:3, :3].T
        turned = np.array([turning[2, 1], turning[0, 2], turning[1, 0]])
        work += case.load[:3] @ moved[:3, 3] + case.load[3:] @ turned
        assert case.result.actuator_forces[joint] == pytest.approx(-work, rel=1e-6, abs=1e-4)


# ---- batches and loads ---------------------------------------------------------------------------------------------------


@given(names, seeds)
def test_batch_element_equals_single_analysis(name, seed):
    rng = np.random.default_rng(seed)
    shape = (2, 3)
    one = robot(name)
    targets = drives(name, rng, shape)
    load, gravity = rng.standard_normal((*shape, 6)) * 100, rng.standard_normal((3, 3)) * 5
    poses = one.assemble(actuators=targets)
    batch = ks.analyze(poses, load, gravity)  # poses without actuators take the shape of the loads
    assert batch.shape == shape == batch.twist.shape[:-1] == batch.status.shape
    assert batch.stiffness.shape == (*shape, 6, 6)
    i = tuple(rng.integers(shape))
    alone = ks.analyze(one.assemble(actuators={k: v[i] for k, v in targets.items()}), load[i], gravity[i[1]])
    # rounding, times the condition of the robot
    rtol = 1e-12 if name in ("rps3", "pru2_upr") else 1e-9
    same(poses.q[i] if targets else poses.q, alone.configuration.q, 1e-12, scale=1.0)
    same_twist(batch.twist[i], alone.twist, rtol)
    same(batch.stiffness[i], alone.stiffness, rtol)
    same(batch.base_wrench[i], alone.base_wrench, rtol, scale=100.0)
    for joint, wrench in alone.joint_wrenches.items():
        same(batch.joint_wrenches[joint][i], wrench, rtol, scale=100.0)
    for joint, force in alone.actuator_forces.items():
        assert batch.actuator_forces[joint].shape == shape
        same(batch.actuator_forces[joint][i], force, rtol, scale=100.0)
    for part, twist in alone.contributions.items():
        same(batch.contributions[part][i], twist, rtol, scale=1e-6)
    for number, limb in alone.limbs.items():
        for what in ("constraint_wrenches", "attached_wrenches", "compliance", "sag", "intensities", "wrench"):
            own, expected = getattr(batch.limbs[number], what), getattr(limb, what)
            assert own.shape == shape + expected.shape
            same(own[i], expected, rtol, scale=100.0 if what in ("intensities", "wrench") else 1e-8)
    for number, beam in alone.beams.items():
        for what in ("length", "mass", "points", "section_wrenches", "stress", "strain_energy", "deflections"):
            own, expected = getattr(batch.beams[number], what), getattr(beam, what)
            assert own.shape == shape + expected.shape
            same(own[i], expected, 10 * rtol, scale={"section_wrenches": 100.0}.get(what, 1e-7))
        same(batch.beams[number].rotations[i], beam.rotations, 10 * rtol, scale=1e-6)
    for link, parts in alone.link_contributions.items():
        for part, twist in parts.items():
            same(batch.link_contributions[link][part][i], twist, 10 * rtol, scale=1e-6)


@given(names, seeds)
def test_load_point_and_frame_transform_the_wrench(name, seed):
    case = Case(name, seed)
    R, f = case.pose.platform_frame[:3, :3], case.load
    p = case.rng.standard_normal(3) * 0.4
    there = ks.analyze(case.pose, f, case.gravity, point=case.o + p)
    same_twist(there.twist, ks.analyze(case.pose, about(f, p, np.zeros(3)), case.gravity).twist, 1e-9)
    R6 = np.kron(np.eye(2), R)
    turned = ks.analyze(case.pose, R6.T @ f, case.gravity, frame="platform")
    same_twist(turned.twist, case.result.twist, 1e-9)
    both = ks.analyze(case.pose, R6.T @ f, case.gravity, frame="platform", point=R.T @ p)
    same_twist(both.twist, there.twist, 1e-9)
    many = ks.analyze(case.pose, f, case.gravity, point=[case.o, case.o + p])
    assert many.twist.shape == (2, 6)
    same_twist(many.twist[1], there.twist, 1e-9)


def test_robot_without_joints_accepts_batches():
    one = robot("portal")
    poses = one.configuration(np.zeros((2, 3, one.model.nq)))
    found = ks.analyze(poses, gravity=(0, 0, -9.81))
    assert found.twist.shape == (2, 3, 6)
    same(found.twist[1, 2], ks.analyze(one.assemble()).twist, 1e-12)


def test_results_are_read_only():
    found = ks.analyze(robot("rps3").assemble())
    beam, limb = found.beams["rod_1"], found.limbs["limb_1"]
    for array in (
        found.twist, found.stiffness, found.compliance, found.contributions["limb_1"], found.base_wrench, found.status,
        found.joint_wrenches["revolute_1"], found.actuator_forces["prismatic_1"], limb.constraint_wrenches, limb.sag,
        limb.intensities, beam.deflections, beam.stress, found.configuration.q,
    ):  # fmt: skip
        assert not array.flags.writeable
