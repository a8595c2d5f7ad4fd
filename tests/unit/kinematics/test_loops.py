"""The equations of every loop type: blocked and free motions, and gradients."""

from types import SimpleNamespace

import numpy as np
import package_robots
import pytest
from loop_robots import FREEDOMS

from kinetostatics.files.reader import parse_robot_text
from kinetostatics.kinematics.assembly import closed_pose
from kinetostatics.kinematics.loop_constraints import LoopEquations, signed_powers
from kinetostatics.math.rotations import exponential, orientation_named
from kinetostatics.mechanism.mechanism import Mechanism

#: A universal joint whose axes are not at right angles, beside the types of the table.
OBLIQUE = "oblique universal"


def equations_of(kind):
    """A platform that floats, with one loop of a given type to the base; all frames askew."""
    extra = '<limit lower="-1" upper="1"/>' if kind in ("revolute", "prismatic") else ""
    if kind == OBLIQUE:
        kind, extra = "universal", '<axis xyz="1 0 0"/><axis2 xyz="0.5 0 1"/>'
    mechanism = Mechanism(
        parse_robot_text(
            f"""<robot name="{kind}"><link name="base"/><link name="platform"/><platform link="platform"/>
            <joint name="free" type="floating"><parent link="base"/><child link="platform"/>
            <origin xyz="0.3 -0.2 0.1" rpy="0.3 0.1 -0.5"/></joint>
            <loop name="closing" type="{kind}">
            <predecessor link="base"><origin xyz="0.1 0.2 0.3" rpy="0.5 -0.4 1"/></predecessor>
            <successor link="platform"><origin xyz="-0.2 0.1 0.4" rpy="1 0.2 -0.3"/></successor>{extra}</loop></robot>"""
        )
    )
    return LoopEquations(mechanism)


def residual_at(kind, motion):
    equations = equations_of(kind)
    return equations.evaluate(equations.forward(pose_with(equations.mechanism, *motion)))[0]


def pose_with(mechanism, linear, angular):
    """Coordinates at which the successor's origin frame has moved from the predecessor's, in the predecessor's axes."""
    loop = mechanism.connections["closing"]
    moved = np.eye(4)
    moved[:3, :3], moved[:3, 3] = exponential(np.array(angular, float)[:, None])[..., 0], linear
    body = loop.predecessor_frame @ moved @ np.linalg.inv(loop.successor_frame)
    placement = mechanism.model.jointPlacements[1].homogeneous
    import pinocchio as pin

    return pin.SE3ToXYZQUAT(pin.SE3(np.linalg.inv(placement) @ body))[:, None]


@pytest.mark.parametrize("kind", FREEDOMS)
def test_loop_gradient_is_the_derivative_of_the_residual(kind):
    equations = equations_of(kind)
    random = np.random.default_rng(1)
    q = pose_with(equations.mechanism, (0, 0, 0), (0, 0, 0))
    residual, wrench = equations.evaluate(equations.forward(q))
    np.testing.assert_allclose(residual, 0, atol=1e-14)
    assert len(residual) == 6 - FREEDOMS[kind]
    gradient = signed_powers(equations.signs, wrench, equations.tree.twists(equations.forward(q)))[..., 0]
    assert np.linalg.matrix_rank(gradient, tol=1e-9) == 6 - FREEDOMS[kind]
    step = 1e-6
    for _ in range(5):
        v = random.uniform(-1, 1, (6, 1))
        ends = [equations.evaluate(equations.forward(equations.tree.integrate(q, sign * step * v)))[0] for sign in (-1, 1)]
        np.testing.assert_allclose((ends[1] - ends[0])[:, 0] / (2 * step), gradient @ v[:, 0], atol=1e-8)


ALLOWED = {
    "revolute": [((0, 0, 0), (0.7, 0, 0)), ((0, 0, 0), (-2.5, 0, 0))],
    "continuous": [((0, 0, 0), (3.0, 0, 0))],
    "prismatic": [((0.4, 0, 0), (0, 0, 0))],
    "cylindrical": [((0.4, 0, 0), (1.2, 0, 0))],
    "universal": [((0, 0, 0), (0.8, 0, 0)), ((0, 0, 0), (0, -1.1, 0))],
    OBLIQUE: [((0, 0, 0), (0, 0, 0)), ((0, 0, 0), (0.8, 0, 0))],
    "spherical": [((0, 0, 0), (0.4, -0.9, 0.5))],
    "planar": [((0, 0.3, -0.2), (1.4, 0, 0))],
}
BLOCKED = {
    "fixed": [((1e-3, 0, 0), (0, 0, 0)), ((0, 0, 0), (0, 1e-3, 0))],
    "revolute": [((0, 1e-3, 0), (0.5, 0, 0)), ((0, 0, 0), (0, 0, 1e-3)), ((1e-3, 0, 0), (0, 0, 0))],
    "continuous": [((0, 0, 0), (0, 2.0, 0))],
    "prismatic": [((0.4, 1e-3, 0), (0, 0, 0)), ((0.4, 0, 0), (1e-3, 0, 0))],
    "cylindrical": [((0.4, 0, 1e-3), (0, 0, 0)), ((0.4, 0, 0), (0, 1e-3, 0))],
    "universal": [((0, 0, 0), (0, 0, 1e-3)), ((0, 1e-3, 0), (0.4, 0, 0))],
    OBLIQUE: [((0, 0, 0), (0, 1e-3, 0))],
    "spherical": [((1e-3, 0, 0), (0.4, -0.9, 0.5))],
    "planar": [((1e-3, 0.3, 0), (0, 0, 0)), ((0, 0.3, 0), (0, 1e-3, 0))],
}


@pytest.mark.parametrize(("kind", "motion"), [(kind, m) for kind, motions in ALLOWED.items() for m in motions])
def test_free_motions_leave_no_residual(kind, motion):
    np.testing.assert_allclose(residual_at(kind, motion), 0, atol=1e-13)


@pytest.mark.parametrize(("kind", "motion"), [(kind, m) for kind, motions in BLOCKED.items() for m in motions])
def test_residual_is_the_size_of_a_blocked_motion(kind, motion):
    size = next(abs(x) for part in motion for x in part if abs(x) in (1e-3, 2.0))
    assert np.linalg.norm(residual_at(kind, motion)) == pytest.approx(size, rel=2e-3)


def test_poses_with_avoidable_residual_are_corrected_once_more():
    machine = package_robots.robot("planar_3rrr")
    exact, asked = machine.generic_poses, []
    rough = exact.take(np.arange(exact.x.shape[1]))
    rough.x[:, 1] += 1e-11

    def newton(prescribed, poses, target):
        asked.append(target[0].tolist())
        return exact.take(target[0]), None

    how = (3,), np.ones(3, dtype=bool), orientation_named(None), 1e-10, False
    solved = SimpleNamespace(newton=newton, place=machine.solver.place), None, np.arange(3)[None]
    found = closed_pose(machine, rough, machine.solver.place(rough.x), *how, solved)
    assert asked == [[1]] and found.residual.max() < 1e-13 and np.all(found.poses.x == exact.x)
    assert np.all(found.frames.position == machine.solver.place(exact.x).frames.position)
