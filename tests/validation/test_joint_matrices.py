"""Joints with a 6×6 stiffness matrix: as the short form if diagonal, as a beam or a flexible link if coupled."""

from dataclasses import replace

import numpy as np
import pytest
from matrix_link import with_flexible
from simple_machines import CIRCLE, E, arm, bar, joint, link, loop, mount, robot, springs

import kinetostatics as ks
from kinetostatics.buckling.estimate import estimate
from kinetostatics.checks.check import diagnose
from kinetostatics.description.elements import Origin
from kinetostatics.reports.robot import robot_report

LOAD, GRAVITY = [30.0, -20.0, 50.0, 4.0, -3.0, 2.0], (0.5, 0.3, -9.81)
RESULTS = ("twist", "compliance", "actuator_forces", "joint_wrenches", "base_wrench", "source_contributions")
TRANSMISSION = '<transmission name="t"><joint name="{}"/></transmission>'
LENGTH = 0.3


def alike(found, expected, tolerance, name=""):
    if hasattr(expected, "items"):
        assert list(found) == list(expected)
        for key, value in expected.items():
            alike(found[key], value, tolerance, f"{name}/{key}")
    else:
        scale = np.max(np.abs(np.nan_to_num(expected, posinf=0.0)), initial=0.0)
        np.testing.assert_allclose(found, expected, rtol=0, atol=tolerance * scale, err_msg=name)


def same(first, second, tolerance, results=RESULTS, **options):
    """Assert that two robots have the same results at their zero poses."""
    poses = [machine.assemble() for machine in (first, second)]
    found, expected = (ks.analyze(pose, LOAD, GRAVITY, **options) for pose in poses)
    for name in results:
        alike(getattr(found, name), getattr(expected, name), tolerance, name)
    modes = [ks.modes(pose, 6) for pose in poses]
    alike(modes[0].frequencies, modes[1].frequencies, tolerance, "frequencies")
    return found, expected


def numbers(matrix):
    return " ".join(map(repr, np.asarray(matrix, dtype=float).ravel().tolist()))


def compliance_of_beam(length=LENGTH):
    """Compliance (6, 6) of the end of a cantilever along z, of the section of CIRCLE without shear."""
    second_moment = np.pi * 0.05**4 / 64
    G, bend = E / 2.6, np.array([[length**3 / 3, length**2 / 2], [length**2 / 2, length]]) / (E * second_moment)
    C = np.zeros((6, 6))
    C[np.ix_((0, 4), (0, 4))] = bend
    C[np.ix_((1, 3), (1, 3))] = bend * [[1, -1], [-1, 1]]
    C[2, 2], C[5, 5] = length / (E * np.pi * 0.05**2 / 4), length / (G * 2 * second_moment)
    return C


def in_frame(matrix, rpy):
    R = Origin(rpy=rpy).matrix[:3, :3]
    turn = np.kron(np.eye(2), R)
    return turn.T @ matrix @ turn


SHORT = [
    ((1e5, 2e5, 3e5), (400.0, 500.0, 600.0)),
    ((1e5, np.inf, 3e5), (np.inf, 500.0, np.inf)),
    ((np.inf, np.inf, 3.3e5), (np.inf,) * 3),
]


@pytest.mark.parametrize("upper", [False, True])
@pytest.mark.parametrize(("linear", "angular"), SHORT)
def test_a_diagonal_matrix_is_the_short_form(linear, angular, upper):
    matrix = np.diag([*linear, *angular])
    given = numbers(matrix[np.triu_indices(6)] if upper else matrix)
    for machine in (mount, lambda part: arm(springs("shoulder", drive=2e4), part.replace("mount", "elbow"))):
        short, full = (
            machine(springs("mount", **values))
            for values in ({"linear": numbers(linear), "angular": numbers(angular)}, {"matrix": given})
        )
        found, expected = same(full, short, 1e-13)
        alike(found.second_order.twist, expected.second_order.twist, 1e-13)
        alike(found.buckling(2).load_factors, expected.buckling(2).load_factors, 1e-13)
        assert str(ks.analyze(full.assemble(), LOAD)) == str(ks.analyze(short.assemble(), LOAD))
        assert diagnose(full).elastic_joints == diagnose(short).elastic_joints


def test_zero_rows_are_passive_and_others_springs():
    """A diagonal matrix of a hinge: zero about its axis leaves it passive, a number is a spring."""
    for spring in (0.0, 700.0):
        values = (1e7, 2e7, 3e7, 4e4, spring, 6e4)
        parts = (
            [link("base"), link("rod", 1.0, "0 0 0.5"), link("platform", 3.0), joint("hinge", "revolute", "base", "rod")],
            [
                joint("clamp", "fixed", "rod", "platform", "0 0 1"),
                loop("top", "spherical", "base", "platform", "0.2 0 1", "0.2 0 0"),
            ],
        )
        short, full = (
            robot(*parts[0], *parts[1], springs("hinge", **given))
            for given in (
                {"linear": numbers(values[:3]), "angular": numbers(values[3:])},
                {"matrix": numbers(np.diag(values))},
            )
        )
        same(full, short, 1e-13)


def cantilever(rpy, by_matrix, beam=True):
    turned = " ".join(map(repr, rpy))
    platform = link("platform", 3.0, "0.1 -0.2 0.05")
    if by_matrix:
        K = in_frame(np.linalg.inv(compliance_of_beam()), rpy)
        parts = [joint("mount", "fixed", "base", "platform", f"0 0 {LENGTH}", rpy=turned), springs("mount", matrix=numbers(K))]
        return robot(link("base"), platform, *parts)
    parts = [joint("root", "fixed", "base", "rod"), joint("mount", "fixed", "rod", "platform", f"0 0 {LENGTH}", rpy=turned)]
    return robot(link("base"), link("rod"), platform, *parts, bar("rod", "root", "mount", 0.0, CIRCLE))


@pytest.mark.parametrize("rpy", [(0.0, 0.0, 0.0), (0.4, -0.7, 1.1)])
@pytest.mark.parametrize("engine", ["numpy", "compiled"])
def test_a_coupled_matrix_is_a_beam(rpy, engine):
    bearing, beam = cantilever(rpy, True), cantilever(rpy, False)
    same(bearing, beam, 1e-9, ("twist", "compliance", "stiffness", "base_wrench"), engine=engine)
    response = [ks.frequency_response(machine.assemble(), [1.0, 40.0], damping=0.01) for machine in (bearing, beam)]
    alike(response[0].compliance, response[1].compliance, 1e-9)


@pytest.mark.parametrize("rpy", [(0.0, 0.0, 0.0), (0.4, -0.7, 1.1)])
def test_a_coupled_matrix_buckles_as_a_flexible_link(rpy):
    bearing, flexible = cantilever(rpy, True), with_flexible(cantilever(rpy, False))
    assert flexible.description.flexible
    found, expected = same(bearing, flexible, 1e-9, ("twist", "compliance"))
    alike(found.second_order.twist, expected.second_order.twist, 1e-9)
    alike(found.buckling(3).load_factors, expected.buckling(3).load_factors, 1e-9)


def test_springs_along_freedoms_couple_with_the_others():
    """A flexure with freedoms, all of whose rows are springs, is an elastic fixed joint of the same matrix."""
    matrix = numbers(in_frame(np.linalg.inv(compliance_of_beam()), (0.4, -0.7, 1.1)))
    fixed, *others = (
        mount(springs("mount", matrix=matrix), kind=kind) for kind in ("fixed", "revolute", "prismatic", "floating")
    )
    for flexure in others:
        same(flexure, fixed, 1e-12, ("twist", "compliance", "base_wrench"))


@pytest.mark.parametrize("head", ["fixed", "revolute"])
def test_a_coupled_matrix_in_a_loop(head):
    """Two columns, of which one is given as a bearing at its head; a hinge there leaves its row of the stiffness zero."""
    axis = None if head == "fixed" else "0 1 0"
    shared = [link("base"), link("a"), link("platform", 5.0, "0.1 0.2 0.3"), joint("foot_a", "fixed", "base", "a")]
    shared += [joint("head_a", "fixed", "a", "platform", f"0 0 {LENGTH}"), bar("a", "foot_a", "head_a", 0.0, CIRCLE)]
    beam = [link("b"), joint("foot_b", "fixed", "base", "b", "0.4 0 0"), bar("b", "foot_b", "head_b", 0.0, CIRCLE)]
    beam += [loop("head_b", head, "b", "platform", f"0 0 {LENGTH}", "0.4 0 0", axis)]
    rows = [0, 1, 2, 3, 4, 5] if head == "fixed" else [0, 1, 2, 3, 5]
    K = np.zeros((6, 6))
    K[np.ix_(rows, rows)] = np.linalg.inv(compliance_of_beam()[np.ix_(rows, rows)])
    bearing = [loop("head_b", head, "base", "platform", f"0.4 0 {LENGTH}", "0.4 0 0", axis), springs("head_b", matrix=numbers(K))]
    same(robot(*shared, *bearing), robot(*shared, *beam), 1e-9, ("twist", "compliance", "base_wrench"))


@pytest.mark.parametrize("force", [1e4, 3e5, 1e6])
def test_the_estimate_that_excludes_buckling_is_not_below_it(force):
    """A column on a coupled bearing buckles at the stated factor, and the estimate of the ratio is not below the exact one."""
    matrix = numbers(np.linalg.inv(compliance_of_beam()))
    parts = [
        link("base"),
        link("rod"),
        link("platform", 3.0),
        joint("root", "fixed", "base", "rod"),
        springs("root", matrix=matrix),
    ]
    parts += [joint("head", "fixed", "rod", "platform", "0 0 0.5"), bar("rod", "root", "head", 0.0, CIRCLE)]
    machine = robot(*parts)
    pose = machine.assemble()
    result = ks.analyze(pose, [0, 0, -force, 0, 0, 0], (0, 0, 0))
    ratio = 1 / float(result.buckling(1).load_factors[0])
    assert bool(result.buckles) == (ratio > 1)
    assert float(estimate(machine.members.structure, next(iter(result.solutions)))[0]) > ratio


def test_files_and_checks(tmp_path):
    K = np.linalg.inv(compliance_of_beam())
    rows = [",".join(map(repr, row)) for row in K.tolist()]
    (tmp_path / "bearing.csv").write_text("\n".join(rows))
    text = cantilever((0.0, 0.0, 0.0), True).description.urdf
    start = text.index("matrix=")
    end = text.index('"', start + 8) + 1
    (tmp_path / "mount.urdf").write_text(text[:start] + 'file="bearing.csv"' + text[end:])
    machine = ks.load_robot(tmp_path / "mount.urdf")
    given = machine.description.joint_stiffness["mount"]
    assert given.matrix == cantilever((0.0, 0.0, 0.0), True).description.joint_stiffness["mount"].matrix
    assert given.file == str(tmp_path / "bearing.csv")
    ks.save_robot(machine, tmp_path / "copy.urdf")
    assert ks.load_robot(tmp_path / "copy.urdf").description.joint_stiffness["mount"].matrix == given.matrix
    assert diagnose(machine).elastic_joints[0].coupled and "mount (coupled)" in str(robot_report(machine))
    assert not any("factor of 1e3" in warning for warning in diagnose(machine).warnings)
    with pytest.raises(ks.ArgumentError, match="verify cannot check mount"):
        ks.verify(machine.assemble())
    units = np.repeat([1e-3, 1e3], 3) ** 0.5  # N/mm and N·mm/rad
    machine = ks.Robot(machine.description.changed("mount", matrix=tuple((K * np.outer(units, units)).ravel())))
    assert any("factor of 1e3" in warning and "the matrix of mount has" in warning for warning in diagnose(machine).warnings)
    lines = [
        (4, "1, 2, x", ":4", "'x' is not a number"),
        (0, "1, 2", "bearing.csv", "not 32"),
        (5, rows[5] + ", 1", "", "not 37"),
    ]
    for number, line, place, words in lines:
        (tmp_path / "bearing.csv").write_text("\n".join([*rows[: max(number - 1, 0)], line, *rows[max(number, 1) :]]))
        with pytest.raises(ks.RobotFileError, match=r"mount\.urdf:\d+") as error:
            ks.load_robot(tmp_path / "mount.urdf")
        assert place in str(error.value) and words in str(error.value)


def test_a_number_of_the_matrix_is_no_parameter():
    numbers_found = ks.sensitivities(cantilever((0.0, 0.0, 0.0), True).assemble(), by=["platform.mass"], load=LOAD)
    assert list(numbers_found) == ["platform.mass"]


def _changed(**entries):
    matrix = np.diag([1e8, 1e8, 2e8, 1e4, 1e4, 2e4])
    for entry, value in entries.items():
        row, column = (("Fx", "Fy", "Fz", "Mx", "My", "Mz").index(part) for part in (entry[:2], entry[2:4]))
        matrix[row, column] = value
        if not entry.endswith("_"):
            matrix[column, row] = value
    return matrix


@pytest.mark.parametrize(
    ("matrix", "words"),
    [
        (np.eye(5), ["36 numbers", "21", "not 25"]),
        (_changed(FxMy_=5e4), ["not symmetric", "Fx My = 50000 and My Fx = 0"]),
        (_changed(FxMy=5e2, MyFx_=5e5), ["not symmetric", "Fx My = 500 and My Fx = 500000", "factor of 1000"]),
        (_changed(FxMy=1e5, MyFx_=1e5 + 20), ["not symmetric", "Fx My = 100000 and My Fx = 100020"]),  # √(Fx Fx · My My) is 1e6
        (_changed(FxMy=1e5, MyFx_=1e5 + 5), []),
        (_changed(FxMy=5e-1, MyFx_=5e5), ["not symmetric", "a factor of 1e+06, as between units"]),
        (_changed(FxMy=5e-4, MyFx_=5e5), ["not symmetric", "a factor of 1e+09, as between units"]),
        (_changed(FxFy_=5, FyFx_=5e-9), []),
        (_changed(FxMx=1.5e6), ["not positive", "Fx Mx = 1.5e+06; less than 1e+06, the root of the product"]),
        (_changed(FxMx=5e7), ["not positive", "Fx Mx = 5e+07", "less than 1e+06", "factor of 1000"]),
        (_changed(FxFy=1e8 * (1 - 1e-9)), []),  # the least of its eigenvalues, 1 ± Fx Fy / 1e8, is 1e-9
        (_changed(FxFy=1e8 * (1 - 1e-11)), ["no positive stiffness", "eigenvalue 1e-11"]),
        (_changed(FxFx=-1), ["Fx Fx = -1", "zero"]),
        (_changed(FxFx=0), ["linear diagonal of the matrix", "0 along x", "constrains"]),
        (_changed(FxFx=0, FxMy=3), ["Fx My = 3", "because Fx is free (zero)"]),
        (_changed(FxFx=np.inf, FxMy=3), ["Fx My = 3", "because Fx is rigid (inf)"]),
        (_changed(FxFy=np.nan), ["Fx Fy = nan", "at most"]),
        (_changed(FxFy=0.7e8, FxFz=0.99e8, FyFz=-0.99e8), ["no positive stiffness", "eigenvalue"]),
    ],
)
def test_wrong_matrices_are_refused(matrix, words):
    if not words:
        assert mount(springs("mount", matrix=numbers(matrix)))
        return
    with pytest.raises(ks.RobotFileError, match="mount") as error:
        mount(springs("mount", matrix=numbers(matrix)))
    assert "<text>:" in str(error.value) and all(word in str(error.value) for word in words), str(error.value)
    with pytest.raises(ks.RobotFileError):
        description = mount(springs("mount", linear="1 1 1")).description
        stiffness = replace(description.joint_stiffness["mount"], linear=None, matrix=matrix)
        ks.Robot(replace(description, joint_stiffness={"mount": stiffness}))


@pytest.mark.parametrize(
    ("kind", "axis", "attributes", "words"),
    [
        ("fixed", "0 1 0", 'matrix="1 2 3" file="x.csv"', ["21"]),
        ("fixed", "0 1 0", f'matrix="{numbers(np.eye(6))}" linear="1 1 1"', ["matrix and also linear or angular"]),
        ("fixed", "0 1 0", f'matrix="{numbers(np.eye(6))}" file="x.csv"', ["a matrix and a file"]),
        ("fixed", "0 1 0", 'file="no_such.csv"', ["no_such.csv", "No such file"]),
        ("fixed", "0 1 0", 'matrix="1 2 N"', ["'N' is not a number"]),
        ("revolute", "0 1 0", f'matrix="{numbers(_changed(MxMx=0))}"', ["angular diagonal of the matrix", "0 about x"]),
        ("revolute", "1 1 0", f'matrix="{numbers(_changed(MxMx=0))}"', ["none of its frame's axes", "angular diagonal"]),
        ("prismatic", "0 1 0", f'matrix="{numbers(_changed(MyMy=0))}"', ["angular diagonal of the matrix", "0 about y"]),
    ],
)
def test_wrong_elements_are_refused(kind, axis, attributes, words):
    with pytest.raises(ks.RobotFileError) as error:
        mount(f'<joint_stiffness joint="mount" {attributes}/>', kind=kind, axis=axis)
    assert "<text>:" in str(error.value) and all(word in str(error.value) for word in words), str(error.value)
