"""Comparisons with Pinocchio: frames and twists, masses and weights, loops as its constraints, constraint dynamics."""

import os
import time
from concurrent.futures import ThreadPoolExecutor
from functools import cache

import numpy as np
import pinocchio as pin
import pytest
from loop_robots import FREEDOMS, Held
from package_robots import robot
from page_code import python_of, run_python

import kinetostatics as ks
from kinetostatics.files.reader import parse_robot_text
from kinetostatics.mechanism.mechanism import Mechanism
from kinetostatics.mechanism.pinocchio_loops import LoopModel
from kinetostatics.mechanism.tree import Frames

TREE = """<robot name="tree"><link name="base"/><link name="a"/><link name="b"/><link name="c"/><link name="d"/><link name="e"/>
<link name="f"/><platform link="f"/>
<joint name="fixed" type="fixed"><parent link="a"/><child link="b"/><origin xyz="0.2 -0.1 1" rpy="0.4 0 1"/></joint>
<joint name="revolute" type="revolute"><parent link="base"/><child link="a"/><origin xyz="1 2 3" rpy="0.1 0.2 0.3"/>
<axis xyz="0 3 4"/><limit effort="1" velocity="1"/></joint>
<joint name="continuous" type="continuous"><parent link="b"/><child link="c"/><origin xyz="1 0 -2" rpy="2 0.2 0.3"/>
<axis xyz="0 1 0"/></joint>
<joint name="planar" type="planar"><parent link="c"/><child link="d"/><origin xyz="0 2 3" rpy="0.1 1 0.3"/>
<axis xyz="0 0 1"/></joint>
<joint name="floating" type="floating"><parent link="d"/><child link="e"/><origin xyz="1 2 0" rpy="0.1 0.2 3"/></joint>
<joint name="prismatic" type="prismatic"><parent link="e"/><child link="f"/><origin xyz="1 2 3" rpy="0.1 0.2 0.3"/>
<axis xyz="1 0 2"/><limit effort="1" velocity="1"/></joint></robot>"""
ROBOTS = list(ks.robots())
GRAVITY = np.array([0.7, -1.1, -9.6])


@cache
def poses(name):
    """The zero pose and one without symmetry."""
    machine = robot(name)
    found = [machine.assemble()]
    drives = dict(found[0].actuators)
    rng = np.random.default_rng(5)
    for scale in (0.1, 0.03, 0.01):
        moved = {drive: float(value) + scale * float(rng.uniform(-1, 1)) * machine.length for drive, value in drives.items()}
        other = machine.assemble(actuators=moved, on_failure="nan")
        if other.status != ks.Status.UNREACHABLE:
            return [*found, other]
    return found


def each_pose(function):
    return pytest.mark.parametrize("number", [0, 1])(pytest.mark.parametrize("name", ROBOTS)(function))


def pose_of(name, number):
    if number >= len(poses(name)):
        pytest.skip("its redundant actuators cannot be moved one by one")
    return poses(name)[number]


def test_frames_twists_and_small_displacements_equal_pinocchio():
    """Larger displacements differ: Pinocchio moves a body that slides and turns along an arc."""
    mechanism = Mechanism(parse_robot_text(TREE))
    model, tree = mechanism.model, mechanism.tree
    data = model.createData()
    random = np.random.default_rng(3)
    np.testing.assert_array_equal(tree.neutral, pin.neutral(model))
    q = np.column_stack([pin.normalize(model, random.uniform(-1, 1, model.nq)) for _ in range(7)])
    q = tree.integrate(q, random.uniform(-1, 1, (model.nv, 7)))
    frames = tree.forward(q)
    twists = tree.twists(frames)
    for k in range(7):
        pin.computeJointJacobians(model, data, q[:, k])
        for body in range(model.njoints):
            np.testing.assert_allclose(frames.rotation[:, :, body, k], data.oMi[body].rotation, atol=1e-14)
            np.testing.assert_allclose(frames.position[:, body, k], data.oMi[body].translation, atol=3e-14)
        np.testing.assert_allclose(twists[:, :, k], data.J, atol=1e-13)
    v = random.uniform(-1e-6, 1e-6, (model.nv, 7))
    wanted = np.column_stack([pin.integrate(model, *pair) for pair in zip(q.T, v.T, strict=True)])
    np.testing.assert_allclose(tree.integrate(q, v) - q, wanted - q, rtol=0, atol=2e-12)


@each_pose
def test_single_pose_by_pinocchio_equals_pose_of_numpy_batch(name, number):
    """Frames, and weights of each link and beam; those of links are also compared with the numbers of the file."""
    pose = pose_of(name, number)
    mechanism, weights, frames = pose.robot.mechanism, pose.robot.weights, pose.frames
    one, many = mechanism.forward(pose.model_q), mechanism.forward(np.repeat(pose.model_q, 2, axis=1))
    np.testing.assert_allclose(one.rotation[..., 0], many.rotation[..., 1], rtol=0, atol=1e-14)
    np.testing.assert_allclose(one.position[..., 0], many.position[..., 1], rtol=0, atol=1e-14)
    o, gravity = np.array([[0.3], [-0.2], [0.5]]), GRAVITY[:, None]
    twice = Frames(np.repeat(frames.rotation, 2, axis=-1), np.repeat(frames.position, 2, axis=-1))
    batch = weights.wrenches(twice, np.repeat(o, 2, axis=1), np.repeat(gravity, 2, axis=1))[..., 1]
    wrenches = weights.wrenches(frames, o, gravity)[..., 0]
    scale = np.abs(batch).max()
    np.testing.assert_allclose(wrenches, batch, rtol=0, atol=1e-13 * scale)
    if mechanism.base_frame is None:
        for link, found in zip(weights.names, wrenches.T, strict=True):
            if not link.startswith("beam:"):
                given, frame = pose.robot.description.links[link], pose.frame(link)
                force = given.mass * GRAVITY
                moment = np.cross(frame[:3, :3] @ given.center_of_mass + frame[:3, 3] - o[:, 0], force)
                np.testing.assert_allclose(found, np.r_[force, moment], rtol=0, atol=1e-13 * scale)


@pytest.mark.few(6)
@each_pose
def test_pinocchio_model_has_mass_and_centre_of_the_robot(name, number):
    pose = pose_of(name, number)
    machine, model = pose.robot, pose.model
    masses, centres = machine.weights.masses(pose.frames)[:, 0], machine.weights.centres(pose.frames)[:, :, 0]
    moving = pin.computeTotalMass(model)
    assert moving + model.inertias[0].mass == pytest.approx(masses.sum(), rel=1e-13)
    first_moment = pin.centerOfMass(model, model.createData(), pose.q) * moving
    first_moment = first_moment + model.inertias[0].mass * model.inertias[0].lever
    if machine.mechanism.base_frame is None:
        np.testing.assert_allclose(first_moment, centres @ masses, rtol=0, atol=1e-12 * masses.sum())
        zero = ks.analyze(pose, gravity=GRAVITY, on_failure="nan")
        np.testing.assert_allclose(zero.base_wrench[:3], -masses.sum() * GRAVITY, rtol=1e-9, atol=1e-9 * masses.sum())


def test_robot_model_has_the_masses_of_the_zero_pose():
    machine = robot("3rps")
    assert pin.computeTotalMass(machine.model) == pytest.approx(pin.computeTotalMass(machine.assemble().model), rel=1e-14)
    lower = machine.assemble(platform={"z": 0.4, "rx": 0.0, "ry": 0.0})
    assert pin.computeTotalMass(lower.model) < 0.9 * pin.computeTotalMass(machine.model)
    assert machine.mechanism.model.nq == machine.model.nq


def test_pinocchio_data_has_the_frames_of_the_pose():
    pose = robot("2pru_upr").assemble(platform={"z": 0.55, "rx": 0.1, "ry": -0.05}, orientation="XYZ")
    for link in pose.robot.description.links:
        frame = pose.data.oMf[pose.model.getFrameId(link)]
        np.testing.assert_allclose(frame.homogeneous, pose.frame(link), atol=1e-14)


def test_model_of_a_batch_is_an_error():
    batch = robot("3rps").assemble(platform={"z": [0.5, 0.55], "rx": 0.0, "ry": 0.0})
    with pytest.raises(ks.ArgumentError, match="one pose"):
        batch.model  # noqa: B018


def test_standard_error_is_restored_after_threads_make_robots(monkeypatch):
    """Pinocchio's parser is silenced by the file descriptor, which all threads share."""
    description, dup2 = robot("five_bar").description, os.dup2
    before = os.fstat(2)
    monkeypatch.setattr(os, "dup2", lambda *files: (dup2(*files), time.sleep(2e-3)))
    with ThreadPoolExecutor(4) as pool:
        made = [pool.submit(lambda: [Mechanism(description).model for _ in range(4)]) for _ in range(4)]
    assert all(len(item.result()) == 4 for item in made)
    after = os.fstat(2)
    assert (after.st_dev, after.st_ino) == (before.st_dev, before.st_ino)


# ---- loops ---------------------------------------------------------------------------------------------------------------


@pytest.mark.few(4)
@pytest.mark.parametrize("anchors", [False, True])
@each_pose
def test_actuator_forces_balance_gravity_in_pinocchio(name, number, anchors):
    """Gravity of Pinocchio's tree is balanced by its loop constraints and by the actuators, with the forces of ``analyze``."""
    pose = pose_of(name, number)
    _balanced(pose, pose.loop_model(anchors=anchors), anchors)
    if name not in ("2pru_upr", "linear_delta"):  # without universal loops
        _balanced(pose, LoopModel(pose.model, pose.q, pose.robot.constraint_models(anchors=anchors)), anchors)


def _balanced(pose, closed, anchors):
    machine, model, data = pose.robot, closed.model, closed.model.createData()
    pin.computeJointJacobians(model, data, closed.q)
    rows = [np.zeros((0, model.nv))]
    for constraint in closed.constraints:
        its = constraint.createData()
        constraint.calc(model, data, its)
        its = constraint.jacobian(model, data, its) if anchors else pin.getConstraintJacobian(model, data, constraint, its)
        rows.append(its.reshape(-1, model.nv))
    drives = [drive for drive in machine.description.actuated if drive in machine.mechanism.body_of_joint]
    columns = np.eye(model.nv)[:, [model.joints[machine.mechanism.body_of_joint[drive]].idx_v for drive in drives]]
    gravity = pin.computeGeneralizedGravity(model, model.createData(), closed.q)
    unknowns = np.hstack([columns, np.concatenate(rows).T])
    found = np.linalg.lstsq(unknowns, gravity, rcond=1e-10)[0]
    scale = max(np.abs(gravity).max(), 1e-3)
    np.testing.assert_allclose(unknowns @ found, gravity, rtol=0, atol=1e-11 * scale)
    if len(drives) == machine.mobility.platform == len(machine.description.actuated):  # as many actuators as freedoms
        ours = [float(ks.analyze(pose).actuator_forces[drive]) for drive in drives]
        np.testing.assert_allclose(found[: len(drives)], ours, rtol=0, atol=1e-9 * scale)


@pytest.mark.few(4)
@pytest.mark.parametrize("swap", [False, True])
@pytest.mark.parametrize("kind", [kind for kind, count in FREEDOMS.items() if count])
def test_every_loop_type_becomes_pinocchio_constraints(kind, swap):
    """Between ground and platform, with either of them as predecessor."""
    held = Held(kind, 12, swap=swap)
    pose = held.robot().assemble(actuators=held.actuators(held.random_q(np.random.default_rng(3))))
    closing, closed = pose.robot.mechanism.connections["closing"], pose.loop_model()
    assert (closing.successor_body == 0) == swap and (closing.predecessor_body == 0) != swap
    masses = [sum(inertia.mass for inertia in model.inertias) for model in (closed.model, pose.model)]
    assert masses[0] == pytest.approx(masses[1], rel=1e-12)
    _balanced(pose, closed, anchors=False)


def test_error_names_loops_without_pinocchio_constraint():
    with pytest.raises(ks.ArgumentError, match="universal loop 'universal_2'"):
        robot("2pru_upr").constraint_models()


@pytest.mark.parametrize("name", ["3rps", "five_bar"])
def test_actuator_forces_hold_the_robot_in_constraint_dynamics(name):
    """With the forces of ``analyze`` the robot does not accelerate; without them it falls."""
    pose = poses(name)[1]
    machine, model = pose.robot, pose.model
    models = machine.constraint_models()
    datas = [constraint.createData() for constraint in models]
    data, still = model.createData(), np.zeros(model.nv)
    pin.initConstraintDynamics(model, data, models, *([datas] if hasattr(pin, "PointAnchorConstraintModel") else []))
    settings = pin.ProximalSettings(1e-13, 1e-12, 60)
    model.gravity.linear = GRAVITY
    torques = np.zeros(model.nv)
    for drive, force in ks.analyze(pose, gravity=GRAVITY).actuator_forces.items():
        torques[model.joints[machine.mechanism.body_of_joint[drive]].idx_v] = force
    held = pin.constraintDynamics(model, data, pose.q, still, torques, models, datas, settings)
    falling = pin.constraintDynamics(model, data, pose.q, still, still, models, datas, settings)
    assert np.abs(held).max() < 1e-6 * np.abs(falling).max() and np.abs(falling).max() > 0.1


def test_examples_of_the_pinocchio_page_run(capsys):
    run_python("how_to/pinocchio")
    assert len(python_of("how_to/pinocchio")) == 2
    assert float(capsys.readouterr().out.split()[-1]) < 1e-9
