"""Second-order work of forces in the frame of the finite elements, against the textbook matrix of a beam and rigid rotations."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from kinetostatics.verification.frame import FrameBeam
from kinetostatics.verification.solve import _arm_stiffness, _beam_stiffness, _cross, _symmetric

L, P = 0.8, 3.0
BOTH = np.hsplit(np.eye(12), 2)[0].T, np.hsplit(np.eye(12), 2)[1].T
#: J. S. Przemieniecki, Theory of Matrix Structural Analysis, 1968, section 15.2: v, θ_z at both ends of a beam under tension P.
TEXTBOOK = P / (30 * L) * np.array(
    [[36, 3 * L, -36, 3 * L], [3 * L, 4 * L**2, -3 * L, -(L**2)], [-36, -3 * L, 36, -3 * L], [3 * L, -(L**2), -3 * L, 4 * L**2]]
)  # fmt: skip


@pytest.mark.parametrize("turn", [(0.0, 0.0, 0.0), (0.4, -0.7, 1.1)])
def test_beam_under_tension_has_the_textbook_geometric_stiffness(turn):
    """Without shear deformation, in both planes; stretching and twisting do no second-order work."""
    R = Rotation.from_rotvec(turn).as_matrix()
    stiffness = (1e9, 1e30, 1e30, 1e4, 2e4, 3e4)
    beam = FrameBeam(
        "rod", (0, 1), np.array([[0.1, 0.2, 0.3], [0.1, 0.2, 0.3] + L * R[:, 0]]), R, stiffness, np.zeros(6), 0.0, np.zeros(3)
    )
    turned = np.kron(np.eye(4), R)
    K = turned.T @ _beam_stiffness(beam, np.concatenate([P * R[:, 0], np.zeros(3)]), *BOTH) @ turned
    sign = np.outer([1, -1, 1, -1], [1, -1, 1, -1])
    np.testing.assert_allclose(K[np.ix_([1, 5, 7, 11], [1, 5, 7, 11])], TEXTBOOK, rtol=1e-12)
    np.testing.assert_allclose(K[np.ix_([2, 4, 8, 10], [2, 4, 8, 10])], sign * TEXTBOOK, rtol=1e-12)
    rest = K.copy()
    for plane in ([1, 5, 7, 11], [2, 4, 8, 10]):
        rest[np.ix_(plane, plane)] = 0.0
    np.testing.assert_allclose(rest, 0.0, atol=1e-12 * P / L)


def test_force_on_an_arm_has_the_second_order_work_of_its_rotation():
    """−f·(R r − r − θ × r) of a rotation R(θ) is ½ θᵀ K θ to second order."""
    f, r = np.array([3.0, -2.0, 5.0]), np.array([0.4, 0.1, -0.7])
    K = _arm_stiffness(f, r)
    np.testing.assert_allclose(K, K.T, atol=1e-15)
    for theta in 1e-3 * np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 1], [1, -2, 0.5]]):
        moved = Rotation.from_rotvec(theta).apply(r) - r - np.cross(theta, r)
        assert -f @ moved == pytest.approx(theta @ K @ theta / 2, rel=2e-3)


def test_cross_product_matrix_and_symmetric_part():
    a, b = np.array([1.0, -2.0, 3.0]), np.array([0.5, 4.0, -1.0])
    np.testing.assert_array_equal(_cross(a) @ b, np.cross(a, b))
    np.testing.assert_array_equal(_symmetric(np.array([[1.0, 2.0], [5.0, 3.0]])), [[2.0, 7.0], [7.0, 6.0]])
