"""Links from finite element programs: files as these write them, one written by CalculiX itself, and what is refused."""

import re
import shutil
import subprocess

import numpy as np
import pytest
from finite_elements import element, to_point
from frame_links import Frame
from scipy.io import savemat

import kinetostatics as ks
from kinetostatics.cli.main import main
from kinetostatics.description import LinkMatrices

needs_ccx = pytest.mark.skipif(shutil.which("ccx") is None, reason="needs ccx, the solver of CalculiX (apt install calculix-ccx)")


def frame_along_the_model_axes(ports=3, inner=2):
    """Return origins, stiffness and mass of a frame with fixed-interface modes, and the link by these."""
    frame = Frame(seed=7, ports=ports, inner=inner)
    frame.turn = np.eye(len(frame.K))
    names, origins, matrices = frame.link(modal=True)
    K, M = matrices["stiffness"], matrices["mass"]
    return origins, K, M, LinkMatrices(names, origins, stiffness=K, mass=M)


def same(link, other):
    scales = np.sqrt(np.diag(other.stiffness))
    gap = np.abs(link.stiffness - other.stiffness) / np.outer(scales, scales)
    masses = np.abs(link.mass - other.mass).max() / np.abs(other.mass).max()
    return link.names == other.names and np.abs(link.origins - other.origins).max() < 1e-12 and max(gap.max(), masses) < 1e-10


# ---- CalculiX and Abaqus -------------------------------------------------------------------------------------------------


def user_element(nodes, freedoms, **matrices):
    """Return a text with the matrices of nodes with equal freedoms, as Abaqus writes it."""
    lines = ["**", f"*USER ELEMENT, NODES=  {len(nodes)}, LINEAR", "** ELEMENT NODES"]
    lines += [f"** {', '.join(map(str, nodes[k : k + 10]))}," for k in range(0, len(nodes), 10)]
    lines.append(", ".join(map(str, freedoms)))
    for kind, matrix in matrices.items():
        lines.append(f"*MATRIX,TYPE={kind.upper()}")
        for row in range(len(matrix)):
            numbers = [f"{number:.16E}".replace("E", "D") for number in matrix[row, : row + 1]]
            lines += [", ".join(numbers[k : k + 4]) + "," for k in range(0, len(numbers), 4)]
    return "\n".join(lines) + "\n"


def input_file(points, sets=""):
    rows = "\n".join(f"{number}, {x:.17g}, {y:.17g}, {z:.17g}" for number, (x, y, z) in points.items())
    return f"*HEADING\nan arm\n** nodes\n*NODE, NSET=ALL\n{rows}\n{sets}*ELEMENT, TYPE=C3D20\n1, 2, 3\n"


def test_files_with_clamped_nodes_are_refused(tmp_path):
    """Such as those of CalculiX 2.20 with nodes that are not retained."""
    origins, K, *_ = frame_along_the_model_axes(inner=0)
    (tmp_path / "arm.mtx").write_text(user_element([1, 2], range(1, 7), stiffness=K[:12, :12]))
    (tmp_path / "arm.inp").write_text(input_file(dict(enumerate(origins[:2], 1))))
    with pytest.raises(ks.RobotFileError, match=r"arm\.mtx: stiffness: a rigid .* of the link causes a force along"):
        ks.files.import_link(tmp_path / "arm.mtx", {"a": 1, "b": 2})


def test_abaqus_text_of_nodes_with_six_freedoms(tmp_path):
    origins, K, M, whole = frame_along_the_model_axes(inner=0)
    (tmp_path / "arm.mtx").write_text(user_element([11, 5, 7], range(1, 7), stiffness=K, mass=M))
    (tmp_path / "arm.inp").write_text(input_file(dict(zip([11, 5, 7], origins, strict=True))))
    link = ks.files.import_link(tmp_path / "arm.mtx", {"joint_1": 11, "joint_2": "5", "joint_3": [7]})
    assert same(link, whole)
    turned = ks.files.import_link(tmp_path / "arm.mtx", {"joint_2": 5, "joint_3": 7, "joint_1": 11})
    assert turned.names == ("joint_2", "joint_3", "joint_1")
    two = ks.files.import_link(tmp_path / "arm.mtx", {"joint_1": 11, "joint_3": 7})  # node 5 follows without force
    assert two.flexibility("joint_1") == pytest.approx(whole.flexibility("joint_1")[6:, 6:], rel=1e-9, abs=1e-18)
    assert two.body[0] == pytest.approx(whole.body[0]) and two.body[1] == pytest.approx(whole.body[1])
    assert turned.flexibility("joint_1") == pytest.approx(whole.flexibility("joint_1"), rel=1e-9, abs=1e-18)


def test_nodes_of_an_interface_move_rigidly_and_millimetres_become_metres(tmp_path):
    """Four nodes with three freedoms each at both ends of a bar, from a stiffness between the means of their motions."""
    corners = np.array([[0, -1, -1], [0, 1, -1], [0, 1, 1], [0, -1, 1]]) * 20.0
    points = np.vstack([corners, corners + np.array([300.0, 0, 0])])  # mm
    bar = element(300.0, 8e7, 2e7, 1.6e7, 3e9, 5e9, 4e9)  # N, N·mm²
    shapes = np.zeros((12, 24))  # means of the nodes' motions
    for node, point in enumerate(points):
        end = 6 * (node // 4)
        shapes[end : end + 6, 3 * node : 3 * node + 3] = np.linalg.pinv(np.vstack([to_point(corner)[:3] for corner in corners]))[
            :, 3 * (node % 4) : 3 * (node % 4) + 3
        ]
        assert point.shape == (3,)
    K = shapes.T @ bar @ shapes
    numbers = range(1, 9)
    (tmp_path / "bar.mtx").write_text(user_element(list(numbers), [1, 2, 3], stiffness=K))
    sets = "*NSET, NSET=Bore\n1, 2,\n3, 4\n*NSET, NSET=half, GENERATE\n5, 6, 1\n*NSET, NSET=FLANGE\nhalf, 7, 8\n"
    (tmp_path / "nodes.inp").write_text(input_file(dict(zip(numbers, points, strict=True)), sets))
    link = ks.files.import_link(tmp_path / "bar.mtx", {"a": "bore", "b": "Flange"}, nodes=tmp_path / "nodes.inp", unit="mm")
    assert link.origins == pytest.approx(np.array([[0, 0, 0], [0.3, 0, 0]])) and link.mass is None
    right = element(0.3, 8e7, 2e7, 1.6e7, 3e3, 5e3, 4e3)  # N, N·m²
    assert np.abs(link.stiffness - right).max() < 1e-9 * np.abs(right).max()
    with pytest.raises(ks.ArgumentError, match="the interfaces are 300 m apart; if it is in mm, give the unit mm"):
        ks.files.import_link(tmp_path / "bar.mtx", {"a": "bore", "b": "Flange"}, nodes=tmp_path / "nodes.inp")


def bar_of_bricks(count=8, length=0.2, width=0.02, height=0.03):
    """Return the input file of a bar of 20-node bricks without lateral contraction, all of whose nodes are retained.

    CalculiX 2.20 clamps nodes that are not retained instead of letting them follow, and needs a freedom that is not retained:
    that of an element apart.
    """
    numbers, rows, elements = {}, [], []
    for i in range(2 * count + 1):
        for j in range(3):
            for k in range(3):
                if i % 2 + j % 2 + k % 2 <= 1:
                    numbers[i, j, k] = len(numbers) + 1
                    rows.append(f"{len(numbers)}, {i * length / 2 / count:.12g}, {(j - 1) * width / 2}, {(k - 1) * height / 2}")
    places = "000 200 220 020 002 202 222 022 100 210 120 010 102 212 122 012 001 201 221 021".split()
    for first in range(0, 2 * count, 2):
        nodes = [str(numbers[first + int(place[0]), int(place[1]), int(place[2])]) for place in places]
        elements.append(f"{first // 2 + 1}, {', '.join(nodes[:10])},\n{', '.join(nodes[10:])}")
    sets = [f"*NSET, NSET={name}" + "".join(f"\n{number}," for (i, _, _), number in numbers.items() if i == at)
            for name, at in (("LEFT", 0), ("RIGHT", 2 * count))]  # fmt: skip
    return "\n".join([
        "*NODE, NSET=ALL", *rows, "*ELEMENT, TYPE=C3D20, ELSET=BAR", *elements, *sets, "*MATERIAL, NAME=STEEL", "*ELASTIC",
        "200e9, 0", "*SOLID SECTION, ELSET=BAR, MATERIAL=STEEL", "*NODE", "9001, 1, 0, 0", "9002, 2, 0, 0", "9003, 1, 1, 0",
        "9004, 1, 0, 1", "*ELEMENT, TYPE=C3D4, ELSET=APART", "999, 9001, 9002, 9003, 9004",
        "*SOLID SECTION, ELSET=APART, MATERIAL=STEEL", "*BOUNDARY", "9001, 1, 3", "9002, 1, 3", "9003, 1, 3",
        "*STEP", "*SUBSTRUCTURE GENERATE", "*RETAINED NODAL DOFS, SORTED=NO", "ALL, 1, 3",
        "*SUBSTRUCTURE MATRIX OUTPUT, STIFFNESS=YES, OUTPUT FILE=USER DEFINED, FILE NAME=bar", "*END STEP", "",
    ])  # fmt: skip


@needs_ccx
def test_calculix_substructure_of_a_bar_has_the_stiffness_of_a_beam(tmp_path):
    (tmp_path / "bar.inp").write_text(bar_of_bricks())
    subprocess.run(["ccx", "bar"], cwd=tmp_path, check=True, capture_output=True, timeout=120)
    link = ks.files.import_link(tmp_path / "bar.mtx", {"left": "LEFT", "right": "RIGHT"})
    E, L, b, h = 200e9, 0.2, 0.02, 0.03
    # one quadratic brick over the section has uniform shear: κ = 1
    beam = element(L, E * b * h, E / 2 * b * h, E / 2 * b * h, 1.0, E * b * h**3 / 12, E * h * b**3 / 12)
    F, right = link.flexibility("left"), np.linalg.inv(beam[6:, 6:])
    assert link.origins == pytest.approx(np.array([[0, 0, 0], [L, 0, 0]]), abs=1e-12)
    assert F[0, 0] == pytest.approx(right[0, 0], rel=1e-6)
    for row, column in ((1, 1), (2, 2), (4, 4), (5, 5), (1, 5), (2, 4)):
        assert F[row, column] == pytest.approx(right[row, column], rel=1e-3), (row, column)


# ---- ANSYS and Simscape --------------------------------------------------------------------------------------------------


def ansys_files(tmp_path, points, K, M):
    np.savetxt(tmp_path / "arm_mat_K.CSV", K, fmt="%.17e", delimiter=",")
    np.savetxt(tmp_path / "arm_mat_M.CSV", M, fmt="%.17e", delimiter=",")
    rows = "\n".join(f"  {number}  {x:.16e}  {y:.16e}  {z:.16e}" for number, (x, y, z) in points.items())
    labels = "\n".join(f"  {number}  {label}" for number in points for label in "UX UY UZ ROTX ROTY ROTZ".split())
    (tmp_path / "arm_out_nodes_3D.txt").write_text(f" LIST ALL NODES\n   NODE  X  Y  Z\n{rows}\n\n   NODE  LABEL\n{labels}\n")


def test_ansys_tables_with_modes(tmp_path):
    origins, K, M, whole = frame_along_the_model_axes()
    ansys_files(tmp_path, dict(zip([4, 17, 9], origins, strict=True)), K, M)
    path = tmp_path / "arm_mat_K.CSV"
    assert same(ks.files.import_link(path, {"joint_1": 4, "joint_2": 17, "joint_3": 9}), whole)
    nodes = tmp_path / "nodes.txt"
    (tmp_path / "arm_out_nodes_3D.txt").rename(nodes)
    assert same(ks.files.import_link(path, {"joint_1": 4, "joint_2": 17, "joint_3": 9}, nodes=nodes), whole)
    # masters as ANSYS 2019 lists them: over several pages, freedoms first
    table, freedoms = nodes.read_text().replace("LABEL", "DOF").split("\n\n")
    page = "\n\n *** ANSYS - ENGINEERING ANALYSIS SYSTEM  RELEASE 2019 R3   19.5  ***\n\n 00123456  VERSION=LINUX  CP= 1.8\n\n"
    nodes.write_text(freedoms.replace("  17  UZ", f"{page}  NODE DOF\n  17  UZ") + page + table + "\n /OUTPUT FILE= TEMP\n")
    assert same(ks.files.import_link(path, {"joint_1": 4, "joint_2": 17, "joint_3": 9}, nodes=nodes), whole)


@pytest.mark.parametrize("as_structure", [False, True])
def test_simscape_reduced_order_solid(tmp_path, as_structure):
    origins, K, M, whole = frame_along_the_model_axes()
    contents = {"P": origins, "K": K, "M": M}
    savemat(tmp_path / "arm.mat", {"arm": contents} if as_structure else contents)
    link = ks.files.import_link(tmp_path / "arm.mat", {"joint_1": 1, "joint_2": 2, "joint_3": 3})
    assert same(link, whole) and link.internal == 12


def test_command_writes_the_matrices(tmp_path, capsys):
    origins, K, M, whole = frame_along_the_model_axes(ports=2, inner=1)
    savemat(tmp_path / "arm.mat", {"P": origins, "K": K, "M": M})
    files = [str(tmp_path / "arm.mat"), "--interface", "joint_1=1", "joint_2=2", "--out", str(tmp_path / "arm.npz")]
    assert main(["import-link", *files]) == 0
    assert re.search(r"arm\.npz: interfaces joint_1, joint_2; 6 internal coordinates; mass [\d.]+ kg\n", capsys.readouterr().out)
    assert same(ks.files.read_link(tmp_path / "arm.npz"), whole)


# ---- refusals ------------------------------------------------------------------------------------------------------------

SMALL = user_element([1, 2], range(1, 7), stiffness=element(1, 2e7, 1e7, 1e7, 1e4, 2e4, 2e4))
NODES = input_file({1: (0, 0, 0), 2: (1, 0, 0)})


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        (
            {"text": SMALL.replace("LINEAR", "UNSYMM")},
            r"arm\.mtx:2: '\*USER ELEMENT, NODES=  2, UNSYMM' is not known here; one \*USER",
        ),
        ({"text": SMALL.replace("STIFFNESS", "VISCOUS DAMPING")}, r"arm\.mtx:6: .*DAMPING' is not known here"),
        ({"text": SMALL + "*MATRIX,TYPE=STIFFNESS\n"}, r"arm\.mtx:\d+: '\*MATRIX,TYPE=STIFFNESS' is not known here"),
        (
            {"text": SMALL.replace("1, 2, 3, 4, 5, 6", "1, 2, 8")},
            r"arm\.mtx:5: '1, 2, 8' has freedoms other than 1 to 6 of a node",
        ),
        (
            {"text": SMALL.replace("1, 2, 3, 4, 5, 6", "1, 2, 3")},
            r"arm\.mtx:6: the matrix has 78 numbers; 21 for its 6 freedoms would",
        ),
        ({"text": SMALL.replace("D+07", "D+O7", 1)}, r"arm\.mtx:7: '2\.0+D\+O7,' are no numbers"),
        ({"text": "7, 8\n" + SMALL}, r"arm\.mtx:1: '7, 8' stands before \*USER ELEMENT"),
        ({"text": SMALL.replace("** 1, 2,", "** 1,")}, r"\*USER ELEMENT has 2 nodes, the comment ELEMENT NODES 1"),
        ({"nodes": input_file({1: (0, 0, 0)})}, r"arm\.inp: \*NODE has no coordinates of node 2, which has a matrix"),
        ({"nodes": NODES + "*TRANSFORM, NSET=ALL\n"}, r"arm\.inp:\d+: '\*TRANSFORM, NSET=ALL' is not known here"),
        ({"nodes": None}, r"arm\.inp: cannot be read: No such file"),
        (
            {"nodes": input_file({1: (0, 0, 0), 2: (0, 1, 0)})},
            r"arm\.mtx: stiffness: a rigid rotation about [xz] of the link causes",
        ),
        ({"interfaces": {"a": 1, "b": [1, 2]}}, "node 1 of .* is in several interfaces, or twice in one"),
        ({"interfaces": {"a": 1}}, "arm.mtx: names: a; two or more interfaces"),
        ({"interfaces": {"a": 1, "b": [2, 3]}}, "has no matrix of node 3; its nodes are 1, 2"),
        ({"interfaces": {"a": 1, "b": "al"}}, "interface b: 'al' is no set of nodes and no node number; did you mean 'ALL'"),
    ],
)
def test_unknown_texts_are_refused_with_file_and_line(tmp_path, changes, said):
    (tmp_path / "arm.mtx").write_text(changes.get("text", SMALL))
    if (nodes := changes.get("nodes", NODES)) is not None:
        (tmp_path / "arm.inp").write_text(nodes)
    with pytest.raises(ks.KinetostaticsError, match=said):
        ks.files.import_link(tmp_path / "arm.mtx", changes.get("interfaces", {"a": 1, "b": 2}))


@pytest.mark.parametrize(
    ("name", "old", "new", "said"),
    [
        ("arm_mat_K.CSV", ",", ";", r"arm_mat_K\.CSV:1: .* are no numbers"),
        ("arm_mat_M.CSV", "\n", ",1\n", r"arm_mat_M\.CSV:1: the row has 13 numbers; a square matrix of 12 would be right"),
        ("arm_out_nodes_3D.txt", "ROTX", "TEMP", r"3D\.txt:\d+: '4  TEMP' is not a node's number with UX, UY"),
        ("arm_out_nodes_3D.txt", "LABEL", "NAME", r"3D\.txt: a table NODE X Y Z and a list NODE LABEL"),
        ("arm_out_nodes_3D.txt", "X  Y  Z\n  4", "X  Y  Z\n  5", r"NODE X Y Z has no coordinates of node 4"),
        ("arm_out_nodes_3D.txt", "  17  UX", "  17  UX UY\n  17  UX", r"mat_K\.CSV: the matrix has 12 rows for 14 freedoms"),
    ],
)
def test_unknown_tables_are_refused_with_file_and_line(tmp_path, name, old, new, said):
    origins, K, M, _ = frame_along_the_model_axes(ports=2, inner=0)
    ansys_files(tmp_path, dict(zip([4, 17], origins, strict=True)), K, M)
    text = (tmp_path / name).read_text()
    (tmp_path / name).write_text(text.replace(old, new, 1 if name.endswith("txt") else -1))
    with pytest.raises(ks.RobotFileError, match=said):
        ks.files.import_link(tmp_path / "arm_mat_K.CSV", {"a": 4, "b": 17})


def test_unknown_files_are_refused(tmp_path):
    with pytest.raises(ks.ArgumentError, match=r"arm\.op2: files end in \.mtx"):
        ks.files.import_link("arm.op2", {"a": 1})
    (tmp_path / "arm.mat").write_text("no data")
    with pytest.raises(ks.RobotFileError, match=r"arm\.mat: not readable: it is no \.mat of version 7 or older"):
        ks.files.import_link(tmp_path / "arm.mat", {"a": 1})
    savemat(tmp_path / "arm.mat", {"K": np.eye(12)})
    with pytest.raises(ks.RobotFileError, match=r"arm\.mat: the variable 'P' is missing; P \(n, 3\), K and M would be right"):
        ks.files.import_link(tmp_path / "arm.mat", {"a": 1})
    savemat(tmp_path / "arm.mat", {"P": np.eye(3), "K": np.eye(12)})
    with pytest.raises(ks.RobotFileError, match=r"P has the shape \(3, 3\), K \(12, 12\); \(n, 3\) and 6n or more rows"):
        ks.files.import_link(tmp_path / "arm.mat", {"a": 1})
