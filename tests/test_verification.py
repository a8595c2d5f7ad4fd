"""The check by finite elements: every robot agrees with it, it is right by itself, and it notices what is wrong.

Skipped with a reason where OpenSeesPy is missing, unless KINETOSTATICS_REQUIRE_OPENSEES is set.
"""

import ast
import json
import os
import subprocess
import sys
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import small_robots as sr

import kinetostatics as ks
from kinetostatics import beams, cli, verification
from kinetostatics.robot_file import parse_robot_text
from kinetostatics.verification import OpenSeesError
from kinetostatics.verification import opensees as runner
from kinetostatics.verification.model import build
from kinetostatics.weights import Weights

ROOT = Path(__file__).parent.parent
ROBOTS = sorted(path.name.removesuffix(".urdf.xacro") for path in (ROOT / "robots").glob("*.urdf.xacro"))
LOAD, POINT, SIDEWAYS = (120.0, -40.0, -500.0, 7.0, -3.0, 11.0), (0.13, -0.07, 0.05), (3.0, -4.0, 8.0)


@cache
def missing():
    """Return why OpenSees cannot be used here, or None."""
    try:
        ks.verify(sr.robot_of(sr.cantilever()).assemble())
    except OpenSeesError as error:
        return str(error)
    return None


@pytest.fixture(autouse=True)
def opensees(request):
    if hasattr(request.function, "without_opensees") or not missing():
        return
    if os.environ.get("KINETOSTATICS_REQUIRE_OPENSEES"):
        pytest.fail(missing())
    pytest.skip(missing())


def without_opensees(test):
    """Mark a test that needs no OpenSees."""
    test.without_opensees = True
    return test


def assert_agrees(pose, tolerance=1e-6, **options):
    found = ks.verify(pose, tolerance=tolerance, **options)
    assert found.verified and found.conclusive, str(found)
    assert set(found.ours.joint_wrenches) <= set(found.finite_elements.joint_wrenches)
    return found


# ---- every robot that comes with the package -------------------------------------------------------------------------------


@cache
def robot(name):
    return ks.load_robot(ROOT / "robots" / f"{name}.urdf.xacro")


def pose(name, which):
    """Return the closed zero pose (0) or one of three assembled poses without symmetry (1, 2, 3)."""
    one = robot(name)
    if which == 0:
        return one.configuration(one.model_q(one.zero_poses)[:, 0])
    return one.configuration(one.model_q(one.generic_poses)[:, which - 1], tolerance=1e-9)


@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize(
    ("which", "options"),
    [
        (0, {}),
        (0, {"load": LOAD, "point": POINT}),
        (1, {"load": LOAD, "point": POINT, "frame": "platform", "gravity": SIDEWAYS}),
        (2, {"gravity": (0, 0, 9.8)}),
        (3, {"load": LOAD, "gravity": (0, 0, 0)}),
    ],
)
def test_every_robot(name, which, options):
    assert_agrees(pose(name, which), **options)


def test_configurations_2_of_the_paper():
    rps = robot("3rps").assemble(
        platform={"z": 0.5, "azimuth": np.radians(-170), "tilt": np.radians(10)}, orientation="tilt_torsion"
    )
    upr = robot("2pru_upr").assemble(platform={"z": 0.6, "rx": np.radians(-5), "ry": np.radians(-6)}, orientation="XYZ")
    for configuration in (rps, upr):
        # rounding is all that is left of the differences
        assert_agrees(configuration, 1e-9, gravity=(0, 0, -9.8))
        assert_agrees(configuration, 1e-9, gravity=SIDEWAYS, load=LOAD, point=POINT, frame="platform")


# ---- small robots: other joints, ways to write them, drives that turn, local freedoms ------------------------------------------

SPECS = {
    "gough_sps": sr.gough("S"),  # six struts that spin
    "gough_rails": sr.gough(telescopic=False),
    "puu3": sr.with_link_masses(sr.puu3()),
    "four_bar": sr.four_bar(),
    "planar_3rrr": sr.planar_3rrr(),
    "chain": sr.locked_chain([(0, 0, 0), (0.5, 0.1, 0), (0.7, 0.2, 0.5)], [(0, 0, 1), (1, 0, 0)], mass=2.0),
    "split": sr.split(sr.pru2_upr(), 3),
    "random": sr.random_spec(["pRpS", "CCP", "rC"], 4),
}


@pytest.mark.parametrize("name", SPECS)
@pytest.mark.parametrize("options", [{}, {"twirl": 3, "whole": False, "flip": True, "cut": 0}])
def test_small_robots(name, options):
    spec, options = SPECS[name], dict(options)
    if "cut" in options:
        options["cuts"] = [options.pop("cut")] * len(spec.limbs)
    assert_agrees(sr.robot_of(spec, **options).assemble(), load=LOAD, gravity=SIDEWAYS)


def link(name, mass=0.0, centre="0 0 0"):
    inertial = f'<mass value="{mass}"/><origin xyz="{centre}"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>'
    return f'<link name="{name}"><inertial>{inertial}</inertial></link>' if mass else f'<link name="{name}"/>'


def joint(name, kind, parent, child, xyz="0 0 0", axis="1 0 0", rpy="0 0 0"):
    limit = '<limit lower="-9" upper="9" effort="0" velocity="0"/>' if kind in ("revolute", "prismatic") else ""
    moving = f'<axis xyz="{axis}"/>{limit}' if kind != "fixed" else ""
    ends = f'<parent link="{parent}"/><child link="{child}"/><origin xyz="{xyz}" rpy="{rpy}"/>'
    return f'<joint name="{name}" type="{kind}">{ends}{moving}</joint>'


def beam(carrier, start, end, more='density="7850"', section='<circle diameter="0.05"/>'):
    material = f'youngs_modulus="2e11" poisson_ratio="0.3" {more}'
    return f'<beam link="{carrier}" from="{start}" to="{end}" {material}>{section}</beam>'


def made_of(*parts, drives=()):
    driven = [f'<transmission name="drive_{name}"><joint name="{name}"/></transmission>' for name in drives]
    text = "".join(["<robot name='made'>", link("base"), *parts, '<platform link="platform"/>', *driven, "</robot>"])
    return ks.Robot(parse_robot_text(text)).assemble()


PLATFORM = link("platform", 4.0, "0.1 0.1 0")
COLUMN = (
    joint("foot", "fixed", "base", "column", "0.8 0 0") + joint("head", "fixed", "column", "platform", "0 0 0.8")
    + link("column") + beam("column", "foot", "head") + PLATFORM
)  # fmt: skip


def telescope(start, *, drives, mass=2.0):
    """A clamped column carries the platform; a telescope stands beside it."""
    return made_of(
        COLUMN, link("cylinder", mass, "0 0 0.1"), link("rod"),
        joint("root", start, "base", "cylinder", axis="0 1 0"),
        joint("slide", "prismatic", "cylinder", "rod", "0 0 0.5", "0 0 1"),
        '<loop name="ball" type="spherical"><predecessor link="rod"><origin xyz="0 0 0.3"/></predecessor>'
        '<successor link="platform"><origin xyz="-0.8 0 0"/></successor></loop>',
        beam("rod", "root", "ball"), drives=drives,
    )  # fmt: skip


@pytest.mark.parametrize("start", ["fixed", "revolute"])
@pytest.mark.parametrize("drives", [(), ("slide",)])
def test_telescopes_driven_and_passive(start, drives):
    found = assert_agrees(telescope(start, drives=drives), load=LOAD, gravity=SIDEWAYS)
    if not drives:  # nothing holds a passive telescope along its axis, not even its own weight
        assert abs(found.finite_elements.joint_wrenches["slide"][2]) < 1e-9


@pytest.mark.parametrize(("carrier", "masses"), [("cylinder", 0.0), ("middle", 3.0), ("rod", 0.0)])
def test_telescope_of_three_stages(carrier, masses):
    middle = 0.0 if carrier == "middle" else masses
    configuration = made_of(
        link("cylinder", masses, "0 0 0.1"), link("middle", middle), link("rod", masses), PLATFORM,
        joint("root", "fixed", "base", "cylinder", "0 0 1", rpy="0.3 0.2 0.1"),
        joint("one", "prismatic", "cylinder", "middle", "0 0 0.5", "0 0 1"),
        joint("two", "prismatic", "middle", "rod", "0 0 0.4", "0 0 -1"), joint("tip", "fixed", "rod", "platform", "0 0 0.3"),
        beam(carrier, "root", "tip"), drives=("one", "two"),
    )  # fmt: skip
    assert_agrees(configuration, load=LOAD, gravity=SIDEWAYS)


def test_dead_weight():
    """A pendulum at rest and a driven arm hang on the platform."""
    pendulum = link("pendulum", 2.0, "0 0 -0.3") + joint("hinge", "continuous", "platform", "pendulum", axis="0 1 0")
    arm = link("arm") + link("hand", 1.0, "0.1 0 0") + joint("shoulder", "revolute", "platform", "arm", "0 0.1 0")
    hand = joint("wrist", "fixed", "arm", "hand", "0.5 0 0") + beam("arm", "shoulder", "wrist")
    assert_agrees(made_of(COLUMN, pendulum), load=LOAD)
    found = assert_agrees(made_of(COLUMN, arm, hand, drives=("shoulder",)), load=LOAD, gravity=SIDEWAYS)
    assert abs(found.finite_elements.actuator_forces["shoulder"]) < 1e-9  # along the arm


@pytest.mark.parametrize(
    "section",
    [
        '<rectangular_tube width="0.08" height="0.03" thickness="0.004"/>',
        '<section area="1e-3" I_y="1e-7" I_z="2e-7" J="2e-7" shear_area_y="5e-4" shear_area_z="8e-4"/>',
    ],
)
def test_sections_that_bend_differently(section):
    configuration = made_of(
        link("arm", 3.0, "0.5 0 0.5"), PLATFORM, joint("root", "fixed", "base", "arm", rpy="0.1 0.2 0.3"),
        joint("tip", "fixed", "arm", "platform", "1 0 1"), beam("arm", "root", "tip", 'y_axis="0 1 0.3"', section),
    )  # fmt: skip
    assert_agrees(configuration, load=LOAD, gravity=SIDEWAYS)


def test_rigid_robot():
    arm = link("arm", 3.0, "0.5 0.5 0.5") + joint("motor", "revolute", "base", "arm")
    found = assert_agrees(made_of(arm, PLATFORM, joint("tip", "fixed", "arm", "platform", "1 0 1"), drives=("motor",)), load=LOAD)
    assert "stiffness" in found.not_compared and "stiffness" not in found.differences


# ---- the judge by itself -----------------------------------------------------------------------------------------------------


def test_finite_elements_against_a_formula():
    L, d, E, nu = 1.3, 0.05, sr.E, sr.NU
    A, inertia = np.pi * d**2 / 4, np.pi * d**4 / 64
    model = build(sr.robot_of(sr.cantilever(L)).assemble(), np.array([0, 0, -20.0, 0, 0, 0]), np.array([0, 0, -9.81]))
    solution, _ = runner.solve(model)
    q, GA = sr.RHO * A * 9.81, E / (2 * (1 + nu)) * A
    sag = q * L**4 / (8 * E * inertia) + q * L**2 / (2 * GA) + 20 * L**3 / (3 * E * inertia) + 20 * L / GA
    slope = q * L**3 / (6 * E * inertia) + 20 * L**2 / (2 * E * inertia)
    np.testing.assert_allclose(solution.twist, [0, 0, -sag, 0, slope, 0], rtol=1e-12, atol=1e-18)
    np.testing.assert_allclose(
        solution.joint_wrenches["root"], [0, 0, q * L + 20, 0, -(q * L**2 / 2 + 20 * L), 0], rtol=1e-12, atol=1e-11
    )
    assert solution.compliance[0, 0] == pytest.approx(L / (E * A), rel=1e-12)


@without_opensees
def test_the_frame_is_built_without_the_statics():
    allowed = {"verification", "description", "configuration", "beam_spans", "exceptions"}
    for name in ("pieces", "directions", "connections", "frame", "model", "opensees", "worker"):
        tree = ast.parse((Path(verification.__file__).parent / f"{name}.py").read_text())
        for node in ast.walk(tree):
            if isinstance(node, ast.ImportFrom) and str(node.module).startswith("kinetostatics"):
                assert node.module.split(".")[1] in allowed, (name, node.module)


# ---- what is wrong is noticed ------------------------------------------------------------------------------------------------


def too_soft(monkeypatch):
    right = beams.end_displacement
    monkeypatch.setattr(beams, "end_displacement", lambda *args: right(*args) * (1 + 1e-5))


def too_heavy(monkeypatch):
    right = Weights.masses
    monkeypatch.setattr(Weights, "masses", lambda self, frames: right(self, frames) * (1 + 1e-5))


def wrong_sign(monkeypatch):
    right = ks.Result.actuator_forces.func
    monkeypatch.setattr(ks.Result, "actuator_forces", property(lambda self: {k: -v for k, v in right(self).items()}))


@pytest.mark.parametrize(
    ("mistake", "wrong"),
    [(too_soft, {"twist", "stiffness"}), (too_heavy, {"joint_wrenches", "actuator_forces"}), (wrong_sign, {"actuator_forces"})],
)
def test_mistakes_are_noticed(monkeypatch, mistake, wrong):
    mistake(monkeypatch)
    one = ks.load_robot(ROOT / "robots" / "3rps.urdf.xacro")
    found = ks.verify(one.assemble(platform={"z": 0.5, "rx": 0.1, "ry": -0.1}), load=LOAD)
    assert not found.verified
    assert wrong <= {name for name, difference in found.differences.items() if difference > found.tolerance}
    assert found.verdict.startswith("NOT verified") and "DIFFERS" in str(found)


def test_missing_numbers_are_noticed(monkeypatch):
    right = ks.Result.twist.func
    monkeypatch.setattr(ks.Result, "twist", property(lambda self: right(self) * np.nan))
    found = ks.verify(pose("3rps", 0))
    assert not found.verified and found.differences["twist"] == np.inf
    assert json.loads(json.dumps(found.to_dict(), allow_nan=False))["differences"]["twist"] is None


@pytest.mark.parametrize("options", [{"load": np.zeros((3, 6))}, {"tolerance": 0.0}, {"frame": "moon"}, {"point": (1, 2)}])
def test_arguments_that_make_no_sense(options):
    with pytest.raises(ks.ArgumentError):
        ks.verify(pose("3rps", 0), **options)


# ---- the command ---------------------------------------------------------------------------------------------------------------


def test_command_prints_both_sides_and_nothing_else():
    done = subprocess.run(
        [sys.executable, "-m", "kinetostatics", "verify", "2pru_upr", "--load", "100", "0", "-500", "0", "0", "0"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0 and done.stderr == ""
    assert done.stdout.startswith("Check of '2pru_upr'") and done.stdout.splitlines()[-1].startswith("Verified: ")
    assert "finite elements" in done.stdout and "prismatic_3 [N]" in done.stdout


def test_command_prints_json(capsys):
    assert cli.main(["verify", "3rps", "--json", "--platform", "z=500mm", "rx=2deg", "ry=0"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["verified"] and found["differences"]["twist"] < 1e-6
    for side in ("ours", "finite_elements"):
        assert len(found[side]["twist"]) == 6 and np.shape(found[side]["stiffness"]) == (6, 6)
        assert set(found[side]["actuator_forces"]) == {"prismatic_1", "prismatic_2", "prismatic_3"}


def test_command_tells_by_its_exit_code(capsys, monkeypatch):
    too_soft(monkeypatch)
    assert cli.main(["verify", "3rps"]) == 1
    assert "NOT verified" in capsys.readouterr().out
    assert cli.main(["verify", "3rps", "--within", "1e-4"]) == 0


# ---- where OpenSees is missing, broken or crashes ------------------------------------------------------------------------------


@without_opensees
def test_missing_opensees(capsys, monkeypatch):
    monkeypatch.setattr(runner.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(OpenSeesError, match=r"pip install 'kinetostatics\[verify\]'"):
        ks.verify(pose("3rps", 0))
    assert cli.main(["verify", "3rps"]) == 2
    assert "kinetostatics[verify]" in capsys.readouterr().err


@without_opensees
@pytest.mark.parametrize(
    ("code", "message"),
    [
        ("raise ImportError('libblas.so.3: cannot open')", "cannot be loaded .*libblas3"),
        ("import os; os._exit(3)", "exit code 3"),
        ("logFile = 1", "OpenSees failed: AttributeError"),
    ],
)
def test_broken_opensees(tmp_path, monkeypatch, code, message):
    package = tmp_path / "openseespy" / "opensees"
    package.mkdir(parents=True)
    (package.parent / "__init__.py").write_text("")
    (package / "__init__.py").write_text(code)
    (tmp_path / "openseespylinux.py").write_text("")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path), prepend=os.pathsep)
    monkeypatch.setattr(runner.importlib.util, "find_spec", lambda name: object())
    with pytest.raises(OpenSeesError, match=message):
        ks.verify(pose("3rps", 0))


@without_opensees
def test_opensees_that_hangs(monkeypatch):
    def hang(*args, **options):
        raise subprocess.TimeoutExpired("opensees", options["timeout"])

    monkeypatch.setattr(runner.importlib.util, "find_spec", lambda name: object())
    monkeypatch.setattr(runner.subprocess, "run", hang)
    with pytest.raises(OpenSeesError, match="did not finish"):
        ks.verify(pose("3rps", 0))
