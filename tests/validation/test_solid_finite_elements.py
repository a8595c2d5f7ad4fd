"""The solid finite element example: mesh and deck against closed forms; CalculiX against the beams, where it is installed."""

import shutil

import numpy as np
import pytest
import solid_finite_elements as solid
from places import ROOT
from reproduce_paper import GRAVITY, POSES

import kinetostatics as ks

needs_ccx = pytest.mark.skipif(shutil.which("ccx") is None, reason="needs ccx, the solver of CalculiX (apt install calculix-ccx)")
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


# ---- rods and mesh -------------------------------------------------------------------------------------------------------


def test_rods_equal_the_beams_of_the_pose(configuration):
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


# ---- the deck ------------------------------------------------------------------------------------------------------------


def test_platform_weight_acts_at_its_centre_of_mass():
    configuration = pose("2pru_upr")
    result = ks.analyze(configuration, gravity=GRAVITY["2pru_upr"])
    weight = solid.platform_weight(configuration, np.array(GRAVITY["2pru_upr"], float))
    assert weight == pytest.approx(result.platform_wrench, rel=1e-12, abs=1e-12)


# ---- refusals ------------------------------------------------------------------------------------------------------------


def test_square_rods_are_refused(tmp_path):
    square = '<rectangle width="${rod_diameter}" height="${rod_diameter}"/>'
    configuration = rewritten(tmp_path, '<circle diameter="${rod_diameter}"/>', square)
    with pytest.raises(solid.NotSolidError, match="section of beam 'rod_1' is not a circle"):
        solid.rods_of(configuration)


def test_links_attached_to_a_rod_are_refused(tmp_path):
    clamp = '<joint name="clamp" type="fixed"><parent link="rod_1"/><child link="lamp"/></joint>'
    lamp = f'{clamp}<link name="lamp"><inertial><mass value="1"/></inertial></link></robot>'
    configuration = rewritten(tmp_path, "</robot>", lamp)
    with pytest.raises(solid.NotSolidError, match="limb_1 carries more than its rod"):
        solid.rods_of(configuration)


def test_missing_calculix_prints_one_message(monkeypatch, capsys):
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
        assert each.unbalanced < 1e-6, grip  # the weight that CalculiX puts on each node is subtracted again
        for limb, rod in zip(result.limbs.values(), each.deck.rods, strict=True):
            assert np.abs(each.platform_wrenches[rod.name][:3] - limb.wrench[:3]).max() < 5e-4 * weight, grip
    # a rigid grip stiffens the rods, a mean one does not, and the beams lie between
    assert abs(found["rigid"].twist[2]) < 0.997 * abs(result.twist[2])
    assert abs(found["distributing"].twist[2]) == pytest.approx(abs(result.twist[2]), rel=1.5e-3)


@pytest.mark.slow
@needs_ccx
def test_rigid_grip_has_no_effect_without_poisson_contraction():
    """The 1 % of the rigid grip is restrained lateral contraction, the rest Cowper's shear coefficient (6/7 at ν = 0)."""
    configuration = pose(poisson_ratio=0, shear_coefficient=6 / 7)
    result = ks.analyze(configuration, gravity=GRAVITY["3rps"])
    deck = solid.make_deck(configuration, GRAVITY["3rps"], grip="rigid", fineness=SKETCH)
    assert solid.scaled_difference(solid.solve(deck).twist, result.twist, float(configuration.robot.length)) < 3e-4


@pytest.mark.slow
@needs_ccx
def test_twist_under_platform_load_agrees_with_beams():
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
