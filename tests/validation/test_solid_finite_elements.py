"""The solid finite element example: mesh and deck against closed forms; CalculiX against the beams, where it is installed."""

import shutil
import sys
from dataclasses import replace

import numpy as np
import pytest
from places import ROOT

import kinetostatics as ks

sys.path.insert(0, str(ROOT / "examples"))

import solid_finite_elements as solid
from reproduce_paper import GRAVITY, POSES

needs_ccx = pytest.mark.skipif(shutil.which("ccx") is None, reason="needs ccx, the solver of CalculiX (apt install calculix-ccx)")
COARSE = solid.FINENESS["coarse"]
#: Coarser still, where it only has to be quick.
SKETCH = solid.Fineness(3, 1, 1.0)


def pose(robot="3rps", number=2, **parameters):
    loaded = ks.load_robot(ROOT / "robots" / f"{robot}.urdf.xacro", parameters)
    return loaded.assemble(**POSES[robot, number])


def rewritten(tmp_path, old, new):
    text = (ROOT / "robots" / "3rps.urdf.xacro").read_text(encoding="utf-8")
    assert text.count(old) == 1
    path = tmp_path / "changed.urdf.xacro"
    path.write_text(text.replace(old, new), encoding="utf-8")
    return ks.load_robot(path).assemble()


@pytest.fixture(scope="module")
def configuration():
    return pose()


def parabolic_area(diameter, arcs):
    """Area inside a regular polygon with a parabola through the middle of the arc on each side: what 8-node elements have."""
    half, r = np.pi / arcs, diameter / 2
    chord, sagitta = 2 * r * np.sin(half), r * (1 - np.cos(half))
    return arcs * (chord * r * np.cos(half) / 2 + 2 / 3 * chord * sagitta)


# ---- rods and mesh -------------------------------------------------------------------------------------------------------


def test_rods_are_those_of_the_pose(configuration):
    rods = solid.rods_of(configuration)
    result = ks.analyze(configuration)
    assert [rod.name for rod in rods] == ["rod_1", "rod_2", "rod_3"]
    for rod in rods:
        line = result.beams[rod.name]
        assert rod.length == pytest.approx(float(line.length), rel=1e-12)
        assert rod.mass == pytest.approx(float(line.mass), rel=1e-12)
        assert (rod.youngs_modulus, rod.poisson_ratio, rod.density) == pytest.approx((200e9, 0.3, 7820))
        # a revolute joint at the base, whose axis crosses the rod, and a spherical one at the platform
        assert rod.base_freedoms.shape == (6, 1) and rod.platform_freedoms.shape == (6, 3)
        assert np.abs(rod.base_freedoms[:3]).max() < 1e-12 and abs(rod.base_freedoms[3:, 0] @ rod.axes[:, 0]) < 1e-12
        assert np.abs(rod.platform_freedoms[:3]).max() < 1e-9 and np.linalg.matrix_rank(rod.platform_freedoms) == 3
    assert [rod.length for rod in rods] == pytest.approx([0.54430, 0.48824, 0.49810], abs=6e-6)  # the paper's, rounded


@pytest.mark.parametrize("inner", [0.0, 0.06])
@pytest.mark.parametrize("fineness", solid.FINENESS.values(), ids=solid.FINENESS)
def test_volume_is_that_of_parabolic_arcs(configuration, fineness, inner):
    rod = replace(solid.rods_of(configuration)[0], inner_diameter=inner)
    mesh = solid.rod_mesh(rod, fineness)
    area = parabolic_area(rod.outer_diameter, 4 * fineness.core)
    if inner:
        area -= parabolic_area(inner, 4 * fineness.core)
    volume = solid.nodal_volumes(mesh).sum()
    assert volume == pytest.approx(area * rod.length, rel=1e-9)
    assert volume * rod.density == pytest.approx(rod.mass, rel=3e-4)
    assert volume * rod.density < rod.mass


@pytest.mark.few(1)
@pytest.mark.parametrize("inner", [0.0, 0.06])
def test_mesh_is_conforming(configuration, inner):
    rod = replace(solid.rods_of(configuration)[0], inner_diameter=inner)
    mesh = solid.rod_mesh(rod, COARSE)
    steps = round(rod.length / rod.outer_diameter * COARSE.per_diameter)
    quads = 4 * COARSE.core * COARSE.ring + (0 if inner else COARSE.core**2)
    assert mesh.elements.shape == (quads * steps, 20)
    assert np.array_equal(np.unique(mesh.elements), np.arange(len(mesh.nodes)))  # no node without an element
    near = np.linalg.norm(mesh.nodes[:, None] - mesh.nodes[None], axis=2) + np.eye(len(mesh.nodes))
    assert near.min() > 1e-3 * rod.outer_diameter  # and none twice
    # every element the right way round, at its corners too
    for at in solid._BRICK[:8]:
        _, slopes = solid._brick20(at.astype(float))
        assert np.linalg.det(np.einsum("ij,ejk->eik", slopes, mesh.nodes[mesh.elements])).min() > 0
    for face, centre in zip(mesh.faces, (rod.start, rod.end), strict=True):
        on_face = mesh.nodes[np.unique(face)]
        assert np.abs((on_face - centre) @ rod.axes[:, 0]).max() < 1e-12
        assert np.linalg.norm(on_face - centre, axis=1).max() == pytest.approx(rod.outer_diameter / 2, rel=1e-12)


def test_shape_functions_reproduce_quadratics():
    at = np.array([0.3, -0.6, 0.2])
    N, D = solid._brick20(at)
    for powers in [(0, 0, 0), (1, 0, 0), (0, 2, 0), (1, 1, 0), (0, 1, 2), (1, 1, 1), (2, 1, 1)]:
        values = np.prod(solid._BRICK.astype(float) ** powers, axis=1)
        assert N @ values == pytest.approx(np.prod(at**powers), abs=1e-14)
    assert pytest.approx(np.eye(3), abs=1e-14) == D @ solid._BRICK
    N, D = solid._quad8(0.3, -0.6)
    corners = solid._BRICK[[0, 1, 2, 3, 8, 9, 10, 11], :2]
    assert N @ corners == pytest.approx(np.array([0.3, -0.6])) and pytest.approx(np.eye(2)) == D @ corners


def test_mean_motion_of_a_rigid_one_is_the_motion_itself(configuration):
    rod = solid.rods_of(configuration)[1]
    mesh = solid.rod_mesh(rod, COARSE)
    which, mean = solid.mean_motion(mesh.nodes, mesh.faces[1], rod.end)
    twist = np.array([0.1, -0.2, 0.3, 0.5, -0.4, 0.6])
    moved = twist[:3] + np.cross(twist[3:], mesh.nodes[which] - rod.end)
    assert mean @ moved.ravel() == pytest.approx(twist, abs=1e-12)
    # lateral contraction moves no mean
    across = (mesh.nodes[which] - rod.end) @ (np.eye(3) - np.outer(rod.axes[:, 0], rod.axes[:, 0]))
    assert np.abs(mean @ across.ravel()).max() < 1e-12


# ---- the deck ------------------------------------------------------------------------------------------------------------


@pytest.mark.few(1)
@pytest.mark.parametrize("robot", ["3rps", "2pru_upr"])
@pytest.mark.parametrize("grip", solid.GRIPS)
def test_joints_allow_their_freedoms_and_nothing_else(robot, grip):
    configuration = pose(robot)
    deck = solid.make_deck(configuration, GRAVITY[robot], grip=grip, fineness=solid.Fineness(2, 1, 0.3))
    faces = [np.unique(face) for mesh in deck.meshes for face in mesh.faces]
    held = sum(12 - rod.base_freedoms.shape[1] - rod.platform_freedoms.shape[1] for rod in deck.rods)
    assert len(deck.equations) == (held if grip == "distributing" else 3 * sum(map(len, faces)))
    # each equation eliminates a dof of a face's node, which no other equation contains
    eliminated = {terms[0][:2] for terms in deck.equations}
    assert len(eliminated) == len(deck.equations)
    assert not eliminated & {term[:2] for terms in deck.equations for term in terms[1:]}
    matrix = np.zeros((len(deck.equations), 3 * len(deck.nodes)))
    for row, terms in enumerate(deck.equations):
        for node, dof, coefficient in terms:
            matrix[row, 3 * (node - 1) + dof - 1] += coefficient
    o, known = deck.nodes[deck.platform[0] - 1], deck.platform[1]
    nodes, extra = np.array(deck.nodes), slice(3 * known, None)

    def misfit(displacements):
        """How far a motion of the rods' nodes and the platform is from fitting, the joints' own dofs at their best."""
        rest = matrix[:, : 3 * known] @ displacements.ravel()
        joints = matrix[:, extra]
        if joints.size:
            rest = rest + joints @ np.linalg.lstsq(joints, -rest, rcond=None)[0]
        return np.abs(rest).max()

    platform_twist = np.array([0.1, 0.2, -0.3, 0.2, -0.1, 0.3])
    for rod, mesh, first in zip(deck.rods, deck.meshes, deck.first_nodes, strict=True):
        bottom, top = (first - 1 + np.unique(face) for face in mesh.faces)
        # while platform and base stand still, a face may move as its joint lets it, and in no other way
        for which, centre, freedoms in ((bottom, rod.start, rod.base_freedoms), (top, rod.end, rod.platform_freedoms)):
            for twist in np.vstack([freedoms.T, np.eye(6)]):
                moves = np.zeros((known, 3))
                moves[which] = twist[:3] + np.cross(twist[3:], nodes[which] - centre)
                part = np.linalg.lstsq(freedoms, twist, rcond=None)[0] @ freedoms.T - twist
                assert (misfit(moves) < 1e-9) == (np.abs(part).max() < 1e-9)
    # and the platform carries all of them along
    moves = np.zeros((known, 3))
    for mesh, first in zip(deck.meshes, deck.first_nodes, strict=True):
        top = first - 1 + np.unique(mesh.faces[1])
        moves[top] = platform_twist[:3] + np.cross(platform_twist[3:], nodes[top] - o)
    moves[deck.platform[0] - 1], moves[deck.platform[1] - 1] = platform_twist[:3], platform_twist[3:]
    assert misfit(moves) < 1e-9


def test_platform_weighs_where_its_centre_of_mass_is():
    configuration = pose("2pru_upr")
    result = ks.analyze(configuration, gravity=GRAVITY["2pru_upr"])
    weight = solid.platform_weight(configuration, np.array(GRAVITY["2pru_upr"], float))
    assert weight == pytest.approx(result.platform_wrench, rel=1e-12, abs=1e-12)


def test_deck_text(configuration):
    deck = solid.make_deck(configuration, GRAVITY["3rps"], load=(1, 2, 3, 4, 5, 6))
    lines = deck.text().splitlines()
    assert lines.count("*EQUATION") == len(deck.equations) == 3 * (5 + 3)
    assert max(map(len, lines)) < 132  # CalculiX reads no more
    start = lines.index("*NODE, NSET=EVERYTHING")
    last = f"{len(deck.nodes)}, "
    assert lines[start + len(deck.nodes)].startswith(last)
    first = next(k for k, line in enumerate(lines) if line.startswith("*ELEMENT"))
    numbers = [int(word) for word in (lines[first + 1] + lines[first + 2]).split(",")]
    assert numbers == [1, *(deck.meshes[0].elements[0] + 1)]
    weight = 9.8 * np.pi * 0.2**2 * 0.02 * 7820
    assert f"{deck.platform[0]}, 3, {3 - weight:.12e}" in lines
    assert f"{deck.platform[1]}, 2, {5:.12e}" in lines
    assert "ROD3, GRAV, 9.800000000000e+00, 0.000000000000e+00, 0.000000000000e+00, -1.000000000000e+00" in lines


def test_tables_of_calculix_are_read():
    text = """
 displacements (vx,vy,vz) for set PLATFORM and time  0.1000000E+01

      1810 -2.142341E-19  4.401030E-19 -8.235586E-08

 forces (fx,fy,fz) for set BASE1 and time  0.1000000E+01

         1  7.045045E-01 -3.544063E-02 -7.369638E+00
         2 -7.580930E-01  9.099315E-01 -2.568082E+00
"""
    tables = solid.read_dat(text)
    assert tables["displacements", "PLATFORM"][1810][2] == -8.235586e-08
    assert tables["forces", "BASE1"][2].tolist() == [-0.7580930, 0.9099315, -2.568082]


# ---- refusals ------------------------------------------------------------------------------------------------------------


def test_square_rods_are_refused(tmp_path):
    square = '<rectangle width="${rod_diameter}" height="${rod_diameter}"/>'
    configuration = rewritten(tmp_path, '<circle diameter="${rod_diameter}"/>', square)
    with pytest.raises(solid.NotSolidError, match="section of beam 'rod_1' is not a circle"):
        solid.rods_of(configuration)


def test_what_hangs_on_a_rod_is_refused(tmp_path):
    clamp = '<joint name="clamp" type="fixed"><parent link="rod_1"/><child link="lamp"/></joint>'
    lamp = f'{clamp}<link name="lamp"><inertial><mass value="1"/></inertial></link></robot>'
    configuration = rewritten(tmp_path, "</robot>", lamp)
    with pytest.raises(solid.NotSolidError, match="limb_1 carries more than its rod"):
        solid.rods_of(configuration)


def test_without_calculix_there_is_one_clear_message(monkeypatch, capsys):
    monkeypatch.setattr(shutil, "which", lambda name: None)
    with pytest.raises(SystemExit) as stopped:
        solid.main(["--configuration", "1"])
    printed = capsys.readouterr()
    assert stopped.value.code == 2 and "calculix-ccx" in printed.err and printed.err.count("\n") == 1 and not printed.out


# ---- CalculiX against the beams ------------------------------------------------------------------------------------------


@needs_ccx
@pytest.mark.parametrize(("robot", "number"), [("3rps", 2), pytest.param("2pru_upr", 2, marks=pytest.mark.slow)])
def test_solids_agree_with_beams(robot, number):
    configuration, gravity = pose(robot, number), GRAVITY[robot]
    result = ks.analyze(configuration, gravity=gravity)
    decks = {grip: solid.make_deck(configuration, gravity, grip=grip, fineness=SKETCH) for grip in solid.GRIPS}
    found = {grip: solid.solve(deck) for grip, deck in decks.items()}
    length = float(configuration.robot.length)
    weight = np.linalg.norm(result.base_wrench[:3])
    for grip, each in found.items():
        assert solid.scaled_difference(each.twist, result.twist, length) < 0.015, grip
        assert each.unbalanced < 1e-6, grip  # so the weight that CalculiX puts on each node is the one we take off again
        for limb, rod in zip(result.limbs.values(), each.deck.rods, strict=True):
            assert np.abs(each.platform_wrenches[rod.name][:3] - limb.wrench[:3]).max() < 5e-4 * weight, grip
    # a rigid grip stiffens the rods, a mean one does not, and the beams lie between
    assert abs(found["rigid"].twist[2]) < 0.997 * abs(result.twist[2])
    assert abs(found["distributing"].twist[2]) == pytest.approx(abs(result.twist[2]), rel=1.5e-3)


@needs_ccx
def test_without_poissons_effect_the_grip_does_not_matter():
    """The 1 % of the rigid grip is lateral contraction held back, and the rest Cowper's shear coefficient (6/7 at ν = 0)."""
    configuration = pose(poisson_ratio=0, shear_coefficient=6 / 7)
    result = ks.analyze(configuration, gravity=GRAVITY["3rps"])
    deck = solid.make_deck(configuration, GRAVITY["3rps"], grip="rigid", fineness=SKETCH)
    assert solid.scaled_difference(solid.solve(deck).twist, result.twist, float(configuration.robot.length)) < 3e-4


@needs_ccx
def test_load_on_the_platform():
    configuration, load = pose(), (2000.0, -3000.0, 1000.0, 400.0, 500.0, -600.0)
    result = ks.analyze(configuration, load, (0, 0, 0))
    found = solid.solve(solid.make_deck(configuration, (0, 0, 0), load, fineness=SKETCH))
    assert solid.scaled_difference(found.twist, result.twist, float(configuration.robot.length)) < 0.02


@pytest.mark.slow
@needs_ccx
def test_command_prints_a_table(capsys):
    assert solid.main(["--configuration", "2", "--grip", "distributing"]) == 0
    printed = capsys.readouterr().out
    assert "| Δ_dz [m] | -7.4110e-08 | -7.4111e-08 | -7.41" in printed
    assert "| f_1a [N] | 385.435 | 385.435 | 385." in printed
