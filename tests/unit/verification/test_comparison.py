"""Relative differences, extrapolation and verdicts of ``verify``, without finite elements."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from kinetostatics.verification import OpenSeesError, opensees
from kinetostatics.verification.compare import Verification, _ReferenceValues, _relative
from kinetostatics.verification.frame import FrameBeam, FrameJoint, FrameModel, JointSpring
from kinetostatics.verification.frequencies import MESHES, _limit, relative_difference
from kinetostatics.verification.opensees import FrameSolution, FrameUnits, SingularFrame, _scatter, least_scatter, weights_at_zero

INF, NAN, L = np.inf, np.nan, 0.5
UNIT = np.repeat([1.0, L], 3)


def verification(differences, scatter, within=1e-8):
    nothing = dict.fromkeys(("configuration", "result", "ours", "finite_elements"))
    more = {"joint_differences": {}, "not_compared": {}, "length": 1.0, "within": within}
    return Verification(**nothing, differences=differences, scatter=scatter, **more)


@pytest.mark.parametrize(
    ("differences", "scatter", "verified", "conclusive", "words"),
    [
        ({"twist": 0.9e-8, "frequencies": 0.9e-5}, {"twist": 0.9e-8}, True, True, "verified: the largest difference is 9.0e-09"),
        ({"twist": 1.1e-8, "stiffness": 0.9e-8}, {"twist": 1e-9}, False, True, "NOT verified: the largest"),
        ({"twist": 1e-9, "frequencies": 1.1e-5}, {"frequencies": 0.9e-5}, False, True, "(frequencies), 1e-05 is allowed"),
        ({"twist": 1.1e-8}, {"twist": 1.2e-8, "frequencies": 0.9e-5}, False, False, "solution is accurate to 1.2e-08"),
        ({"twist": 0.5e-8}, {"frequencies": 1.2e-5}, True, False, "verified: "),
    ],
)  # fmt: skip
def test_verdict_compares_differences_and_scatter_with_what_is_allowed(differences, scatter, verified, conclusive, words):
    """1e-8, of frequencies 1e-5; a difference that the reference solution cannot show is no error of the analysis."""
    found = verification(differences, scatter)
    assert (found.verified, found.conclusive) == (verified, conclusive)
    assert words in found.verdict and ("NOT" in found.verdict) == (conclusive and not verified)


@pytest.mark.parametrize(("within", "allowed"), [(1e-12, 1e-5), (1e-3, 1e-3)])
def test_more_may_be_allowed_but_not_less_than_meshes_agree_to(within, allowed):
    found = verification({}, {}, within)
    assert found.allowed("frequencies") == allowed and found.allowed("twist") == within


def test_relative_differences_of_numbers_and_frequencies():
    assert (
        _relative(0.3, 2.0) == 0.15
        and _relative(0.0, 0.0) == 0.0
        and _relative(1e-300, 0.0) == INF
        and _relative(NAN, 2.0) == INF
    )
    some, other = np.array([2.0, 3.0, INF]), np.array([2.0, 3.3, INF])
    assert relative_difference(some, other) == pytest.approx(0.3 / 3.3) and relative_difference(some, some) == 0.0
    assert (
        relative_difference(some, np.array([2.0, INF, INF])) == 1 and relative_difference(np.array([2.0, INF]), other[:2]) == INF
    )
    assert relative_difference(np.zeros(0), np.zeros(0)) == 0.0 and relative_difference(np.array([1.0]), np.array([0.0])) == INF
    assert relative_difference(np.array([NAN]), np.array([1.0])) == INF


def test_scatter_is_relative_to_the_result_but_no_less_than_a_thousandth_of_the_scale():
    some = {"twist": np.array([1.0, -4.0]), "forces": np.array([1e-6, 0.0])}
    assert _scatter(some, {**some, "twist": np.array([1.1, -4.0])}) == pytest.approx(0.1 / 4)
    assert _scatter(some, {**some, "forces": np.array([3e-6, 0.0])}) == pytest.approx(2e-3)
    assert _scatter(some, some) == 0.0 and _scatter(some, {**some, "twist": np.array([NAN, -4.0])}) == INF


def test_weights_extrapolate_polynomials_exactly():
    h = np.array([1.0, 0.5, 0.25, 0.125])
    for power, limit in ((0, 1.0), (1, 0.0), (2, 0.0), (3, 0.0)):
        assert weights_at_zero(h) @ h**power == pytest.approx(limit, abs=1e-13)


def test_eigenvalues_are_extrapolated_over_penalties_and_meshes():
    """A polynomial in the inverse penalty and in the square of the element size; what grows with the penalty is rigid."""
    levels, limit = 0.5 ** np.arange(4), np.array([4.0, 25.0])
    meshes = []
    for n in MESHES[:4]:
        mesh = limit * (1 + 0.3 * levels - 0.2 * levels**3)[:, None] * (1 + 0.7 / n**2 + 0.1 / n**4)
        meshes.append(np.column_stack([mesh, 1e9 / levels]))
    np.testing.assert_allclose(_limit(meshes), [2.0, 5.0, INF], rtol=1e-12)
    rounding = [np.column_stack([-1e-9 + 1e-8 * levels, 1 + 0 * levels])]
    np.testing.assert_allclose(_limit(rounding), [0.0, 1.0], rtol=1e-12)


def solution(twist, compliance, wrenches, forces=None, beams=None):
    with np.errstate(divide="ignore"):
        stiffness = np.linalg.inv(compliance) if np.linalg.matrix_rank(compliance) == 6 else np.full((6, 6), NAN)
    return FrameSolution(twist, compliance, stiffness, wrenches, beams or {}, forces or {}, frozenset({"motor"}))


def reference(theirs, load=10.0, stiffest=1e6, error=0.0):
    loads = np.zeros((2, 6))
    loads[0, 0] = load
    model = SimpleNamespace(length=L, loads=loads, beams=(), stiffest=stiffest, largest_assembly_error=error)
    return _ReferenceValues(model, theirs)


TWIST, C = np.array([3e-5, 0.0, 0.0, 0.0, 8e-5, 0.0]), np.diag([1e-6, 2e-6, 3e-6, 4e-6, 5e-6, 6e-6])
WRENCHES = {"hinge": np.array([0.0, 6.0, 0.0, 0.0, 0.0, 0.0]), "motor": np.array([0.0, 0.0, 0.0, 4.0, 0.0, 0.0])}


def test_differences_are_relative_to_norms_with_moments_divided_by_the_length():
    theirs = solution(TWIST, C, WRENCHES, {"motor": 4.0, "hinge": 6.0}, {"rod": np.ones((2, 6))})
    sizes = reference(theirs)
    assert sizes.twist_size == pytest.approx(5e-5) and sizes.wrench_size == pytest.approx(8.0)  # 4 N·m are 8 N
    assert sizes.compliance_size == pytest.approx(np.linalg.norm([1e-6, 2e-6, 3e-6, 1e-6, 1.25e-6, 1.5e-6]))
    other = {"hinge": WRENCHES["hinge"] + [0, 0, 0.8, 0, 0, 0], "motor": WRENCHES["motor"]}
    bent = np.ones((2, 6))
    bent[1, 3] += 0.8
    ours = solution(TWIST + 1e-6 * np.eye(6)[5], 1.5 * C, other, {"motor": 4.4, "hinge": 6.4}, {"rod": bent})
    found = sizes.differences(ours, theirs, ["hinge", "motor"], ["rod"])
    assert found == pytest.approx(
        {
            "twist": 0.01,
            "compliance": 0.5,
            "stiffness": 1 / 3,
            "joint_wrenches": 0.1,
            "beam_wrenches": 0.2,
            "actuator_forces": 0.1,
        }
    )
    assert sizes.differences(ours, theirs, ["hinge"], [])["actuator_forces"] == pytest.approx(0.05)
    assert sizes.differences(ours, theirs, [], [])["joint_wrenches"] == 0.0
    lost = solution(TWIST * NAN, C, {**WRENCHES, "hinge": np.full(6, NAN)})
    assert sizes.wrench(lost.joint_wrenches["hinge"], WRENCHES["hinge"]) == INF


def test_results_that_vanish_by_symmetry_are_compared_with_what_the_loads_could_cause():
    """A thousandth of the load times the softness, or of an assembly error."""
    nothing = {"hinge": np.zeros(6)}
    sizes = reference(solution(np.zeros(6), C, nothing))
    softness = np.linalg.norm([1e-6, 2e-6, 3e-6, 1e-6, 1.25e-6, 1.5e-6])
    assert sizes.twist_size == pytest.approx(1e-3 * softness * 10) and sizes.wrench_size == pytest.approx(1e-3 * 10)
    sizes = reference(solution(np.zeros(6), C, nothing), load=0.0, error=2e-4)
    assert sizes.twist_size == pytest.approx(2e-7) and sizes.wrench_size == pytest.approx(2e-7 / softness)
    sizes = reference(solution(np.zeros(6), np.zeros((6, 6)), nothing), stiffest=1e6)
    assert sizes.compliance_size == pytest.approx(1e-9) and sizes.twist_size == pytest.approx(1e-3 * 10 * 1e-6)


@pytest.mark.parametrize(("least", "invertible"), [(6e-6, True), (3e-14, True), (3e-16, False), (0.0, False)])
def test_compliance_with_a_direction_of_rounding_has_no_stiffness(least, invertible):
    theirs = solution(TWIST, np.diag([1e-6, 2e-6, 3e-6, 4e-6, 5e-6, max(least, 1e-30)]), WRENCHES)
    assert reference(theirs).has_stiffness(theirs) == invertible


def test_first_regularization_that_is_sure_or_the_least_scatter():
    tried = []

    def solved(regularization):
        tried.append(regularization)
        if regularization == 1.0:
            raise SingularFrame("lost")
        return {2.0: 0.3, 3.0: 0.1, 4.0: 0.05, 5.0: 0.2}[regularization], f"with {regularization}"

    assert least_scatter([1.0, 2.0, 3.0, 4.0, 5.0], 0.11, solved) == "with 3.0" and tried == [1.0, 2.0, 3.0]
    assert least_scatter([2.0, 3.0, 5.0, 1.0], 0.01, solved) == "with 3.0"
    with pytest.raises(OpenSeesError, match="lost"):
        least_scatter([1.0, 1.0], 0.1, solved)


@pytest.mark.parametrize(("scatter", "runs"), [(0.9e-9, 1), (1.1e-9, 2)])
def test_further_regularizations_are_tried_from_a_scatter_of_1e_9(scatter, runs, monkeypatch):
    tried, scatters = [], iter([scatter, 0.5e-9])
    monkeypatch.setattr(opensees, "frame_of", lambda *given: {})
    monkeypatch.setattr(opensees, "run", lambda frame, springs: tried.append(springs) or [{}] * len(springs))
    monkeypatch.setattr(opensees, "_level_results", lambda level: {"twist": np.zeros(6), "compliance": np.zeros((6, 6))})
    monkeypatch.setattr(opensees, "_scatter", lambda some, other: next(scatters))
    opensees.extrapolations(frame_model([frame_joint("j", (0, 1))]), None, [1])
    assert len(tried) == runs and all(len(springs) == opensees.LEVELS for springs in tried)
    assert [springs[0][1] for springs in tried] == list(opensees.REGULARIZATIONS[:runs])


def frame_joint(name, pieces, blocked=5, springs=(), error=0.0):
    """A joint at the origin with so many blocked directions."""
    return FrameJoint(name, pieces, np.zeros(3), np.eye(3), np.arange(6) < blocked, springs, np.full(6, error))


def frame_model(joints, loads=None, beams=(), compounds=()):
    n = 1 + max(piece for joint in joints for piece in joint.pieces)
    loads = np.zeros((n, 6)) if loads is None else loads
    return FrameModel(0, n - 1, np.zeros((n, 3)), loads, beams, tuple(joints), (), 2.0, L, compound_joints=compounds)


def test_units_are_the_largest_force_or_one():
    """Forces on pieces with moments divided by the size, weights of beams, what assembly errors cause; nothing of these: 1 N."""
    joint, soft = frame_joint("j", (0, 1)), JointSpring(np.eye(3), np.array([5e5, INF, INF, INF, INF, 1e9]))
    beam = FrameBeam(
        "rod", (0, 1), np.array([[0, 0, 0], [3.0, 0, 0]]), np.eye(3), (6e6,) * 6, np.array([0, 0, 4.0, 0, 0, 0]), 0.0, np.zeros(3)
    )
    assert FrameUnits(frame_model([joint])).force == 1.0
    assert FrameUnits(frame_model([joint], np.array([[0.0] * 6, [0, -3.0, 0, 0, 8.0, 0]]))).force == 4.0
    assert FrameUnits(frame_model([joint], beams=(beam,))).force == 12.0
    twisted = frame_model([frame_joint("j", (0, 1), springs=(soft,), error=1e-3)])
    assert twisted.stiffest == pytest.approx(1e9 / L**2) and twisted.largest_assembly_error == pytest.approx(
        1e-3 * np.sqrt(3 + 12)
    )
    assert FrameUnits(twisted).force == pytest.approx(1e-3 * np.sqrt(15) * 1e9 / L**2)
    assert frame_model([joint]).stiffest == 1.0 and frame_model([joint], beams=(beam,)).stiffest == 2e6
    rod = replace(beam, length_error=-0.5)
    assert frame_model([joint], beams=(rod,)).largest_assembly_error == 0.5


def test_compound_joint_reaches_through_rigid_joints_only():
    """Two hinges with a fixed joint between them are one universal joint, from the first piece to the last."""
    first, second, other = frame_joint("a", (0, 1)), frame_joint("b", (2, 3)), frame_joint("c", (3, 4))
    compounds = (frozenset(("a", "b")),)
    model = frame_model([first, frame_joint("weld", (1, 2), 6), second, other], compounds=compounds)
    assert model.compound_of(first) == model.compound_of(second) == ([first, second], (0, 3))
    assert model.compound_of(other) == ([other], (3, 4))
    meeting = frame_joint("b", (1, 2))
    assert frame_model([first, meeting, frame_joint("d", (2, 3), 6)], compounds=compounds).compound_of(first)[1] == (0, 2)
    # a joint that is blocked but elastic, or free, joins no pieces
    elastic = frame_joint("weld", (3, 0), 6, (JointSpring(np.eye(3), np.full(6, 1e6)),))
    for between in (elastic, frame_joint("hinge", (3, 0), 5)):
        model = frame_model([first, frame_joint("weld", (1, 2), 6), second, between], compounds=compounds)
        assert model.compound_of(first)[1] == (0, 3)
